#include "rc_bearings.h"

/* ---- checks -------------------------------------------------------------- */

rigcal_status rc_check_bearing(const rigcal_bearing *bearing, int need_z)
{
    if (!rc_all_finite(bearing->X_w, 3) || !rc_all_finite(bearing->ray, 3)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    if (!rc_all_within(bearing->X_w, 3, RC_COORDINATE_MAX) ||
        !(rc_vec3_max_abs(bearing->ray) > 0)) {
        return RIGCAL_ERR_RANGE;
    }
    if (need_z && !(bearing->ray[2] > RC_FORWARD_LEAST * rc_vec3_max_abs(bearing->ray))) {
        return RIGCAL_ERR_WIDE_RAY;
    }
    return RIGCAL_OK;
}

rigcal_status rc_check_bearings(const rigcal_bearing bearings[], size_t n, int need_z)
{
    if (bearings == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (n > RC_COUNT_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    for (size_t i = 0; i < n; i++) {
        const rigcal_status status = rc_check_bearing(&bearings[i], need_z);
        if (status != RIGCAL_OK) {
            return status;
        }
    }
    return RIGCAL_OK;
}

/* ---- public -------------------------------------------------------------- */

rigcal_status rigcal_bearings_of_view(rigcal_bearing bearings[], int32_t *at_fault,
                                      const rigcal_view *view)
{
    rigcal_real ray[3];
    rc_write_fault(at_fault, -1);
    if (bearings == NULL || view == NULL || view->observations == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_observation *const o = view->observations;
    rigcal_status status = rc_check_camera(view->camera);
    if (status == RIGCAL_OK && (view->n < 1 || view->n > RC_COUNT_MAX)) {
        status = (view->n < 1) ? RIGCAL_ERR_TOO_FEW : RIGCAL_ERR_RANGE;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    /* Passes twice over the points, so that nothing is written if one is wrong. */
    for (size_t i = 0; i < view->n; i++) {
        status = rc_check_observation(&o[i]);
        if (status == RIGCAL_OK) {
            status = rc_pixel_to_ray(ray, view->camera, o[i].uv);
        }
        if (status != RIGCAL_OK) {
            rc_write_fault(at_fault, (int32_t)i);
            return status;
        }
    }
    for (size_t i = 0; i < view->n; i++) {
        (void)rc_pixel_to_ray(bearings[i].ray, view->camera, o[i].uv);
        rc_vec3_copy(bearings[i].X_w, o[i].X_w);
    }
    return RIGCAL_OK;
}
