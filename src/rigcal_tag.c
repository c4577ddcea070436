#include "rc_pose.h"

/* ---- constants ----------------------------------------------------------- */

/* odds: poses seen from behind are dropped, unless the likelihood of those from the front
 * is no more than this times that of the best. */
#define FRONT_LEAST RC(1e-3)

/* Whether the camera is on the side that the tag's z axis points to. Then z.t < 0 by
 * more than rounding, with z the third column of the rotation. Edge-on a tag shows
 * neither side. */
static int is_from_front(const rigcal_pose_solver *solver, int32_t i)
{
    rigcal_transform T;
    rc_pose_found(&T, solver, i);
    const rigcal_real rounding = 16 * RC_EPS * rc_vec3_max_abs(T.t);
    return T.R[2] * T.t[0] + T.R[5] * T.t[1] + T.R[8] * T.t[2] < -rounding;
}

static void place_corners(rigcal_observation corners[4], const rigcal_real uv[8],
                          rigcal_real size)
{
    const rigcal_real half = size / 2;
    for (int i = 0; i < 4; i++) {
        corners[i].X_w[0] = (i == 1 || i == 2) ? half : -half;
        corners[i].X_w[1] = (i < 2) ? half : -half;
        corners[i].X_w[2] = 0;
        corners[i].uv[0] = uv[2 * i];
        corners[i].uv[1] = uv[2 * i + 1];
    }
}

/* Keeps the poses seen from the front. Returns 0 if none of them may be right. */
static int keep_front(rigcal_pose_solver *solver)
{
    const int32_t n = rc_pose_n_found(solver);
    rigcal_real likelihood = 0;
    for (int32_t i = 0; i < n; i++) {
        if (is_from_front(solver, i)) {
            likelihood = rc_max(likelihood, rc_pose_likelihood(solver, i));
        }
    }
    if (!(likelihood > FRONT_LEAST)) {
        return 0;
    }
    for (int32_t i = n - 1; i >= 0; i--) {
        if (!is_from_front(solver, i)) {
            rc_pose_drop(solver, i);
        }
    }
    return 1;
}

rigcal_status rigcal_tag_solve(rigcal_pose cams_from_tag[], size_t capacity,
                               size_t *n_found, int32_t *at_fault,
                               const rigcal_camera *camera, const rigcal_real uv[8],
                               rigcal_real size, const rigcal_pose_options *options)
{
    rigcal_observation corners[4];
    rigcal_pose_solver solver;
    rc_write_fault(at_fault, -1);
    if (cams_from_tag == NULL || n_found == NULL || camera == NULL || uv == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (!rc_is_finite(size)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    if (!(size > 0) || capacity < 1) {
        return RIGCAL_ERR_RANGE;
    }
    place_corners(corners, uv, size);
    const rigcal_view view = {camera, corners, NULL, 4};
    const rigcal_status status = rigcal_pose_begin(&solver, at_fault, &view, options);
    if (status != RIGCAL_OK) {
        return status;
    }
    (void)rigcal_pose_step(&solver, INT32_MAX);
    if (rc_pose_n_found(&solver) > 0 && !keep_front(&solver)) {
        return RIGCAL_ERR_MIRRORED;
    }
    return rigcal_pose_result(cams_from_tag, capacity, n_found, at_fault, &solver);
}
