#include "rc_camera.h"

/* ---- constants ----------------------------------------------------------- */

/* sine: the least angle between the baseline and the optical axes is 10 degrees. Below it,
 * the aligned images would consist mostly of stretched pixels. */
#define AXIS_SINE_MIN RC(0.1736)

/* The rows x, y, z of aligned_from_a are unit vectors in frame a. x is along the baseline,
 * in the direction of both cameras' x axes. z is the direction across x that is nearest to
 * both optical axes. */
static rigcal_status align(rigcal_rectified *out, const rigcal_transform *b_from_a)
{
    const rigcal_real *const R = b_from_a->R;
    rigcal_real *const x = &out->aligned_from_a[0], *const y = &out->aligned_from_a[3];
    rigcal_real *const z = &out->aligned_from_a[6], centre[3];
    out->baseline = rc_vec3_norm(b_from_a->t); /* also 0 if its square underflows */
    rc_mat3_tmul_vec3(centre, R, b_from_a->t);
    if (!(out->baseline > 0)) {
        return RIGCAL_ERR_PARALLEL;
    }
    (void)rc_vec3_unit(x, centre); /* towards a from b */
    const rigcal_real axes_x[3] = {1 + R[0], R[1], R[2]};
    const rigcal_real axes_z[3] = {R[6], R[7], 1 + R[8]};
    out->a_is_right = rc_vec3_dot(x, axes_x) > 0;
    if (!out->a_is_right) {
        rc_vec3_scale(x, -1, x);
    }
    const rigcal_real along = rc_vec3_dot(x, axes_z);
    rigcal_real aside[3];
    rc_vec3_combine(aside, 1, axes_z, -along, x);
    if (!(rc_vec3_norm(aside) > AXIS_SINE_MIN * rc_vec3_norm(axes_z))) {
        return RIGCAL_ERR_EPIPOLE;
    }
    (void)rc_vec3_unit(z, aside);
    rc_vec3_cross(y, z, x);
    rc_mat3_mul_t(out->aligned_from_b, out->aligned_from_a, R);
    rc_rotation_tidy(out->aligned_from_b);
    return RIGCAL_OK;
}

/* Adds the place of the image's middle in the aligned frame, normalised, to xy. */
static rigcal_status add_middle(rigcal_real xy[2], const rigcal_real aligned_from_cam[9],
                                const rigcal_camera *camera)
{
    const rigcal_real middle[2] = {(rigcal_real)(camera->width - 1) / 2,
                                   (rigcal_real)(camera->height - 1) / 2};
    rigcal_real ray[3], m[3];
    const rigcal_status status = rc_pixel_to_ray(ray, camera, middle);
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_mat3_mul_vec3(m, aligned_from_cam, ray);
    if (!(m[2] > RC_FORWARD_LEAST)) {
        return RIGCAL_ERR_WIDE_RAY;
    }
    xy[0] += m[0] / m[2];
    xy[1] += m[1] / m[2];
    return RIGCAL_OK;
}

rigcal_status rigcal_rectify(rigcal_rectified *rectified, const rigcal_camera *camera_a,
                             const rigcal_camera *camera_b,
                             const rigcal_transform *b_from_a)
{
    rigcal_rectified made = {0};
    rigcal_real xy[2] = {0, 0};
    if (rectified == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_camera(camera_a);
    if (status == RIGCAL_OK) {
        status = rc_check_camera(camera_b);
    }
    if (status == RIGCAL_OK) {
        status = rc_check_transform(b_from_a);
    }
    if (status == RIGCAL_OK) {
        status = align(&made, b_from_a);
    }
    if (status == RIGCAL_OK) {
        status = add_middle(xy, made.aligned_from_a, camera_a);
    }
    if (status == RIGCAL_OK) {
        status = add_middle(xy, made.aligned_from_b, camera_b);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    made.camera.lens = RIGCAL_LENS_BROWN;
    made.camera.width = camera_a->width;
    made.camera.height = camera_a->height;
    made.camera.fx = made.camera.fy =
        (camera_a->fx + camera_a->fy + camera_b->fx + camera_b->fy) / 4;
    made.camera.cx = (rigcal_real)(camera_a->width - 1) / 2 - made.camera.fx * xy[0] / 2;
    made.camera.cy = (rigcal_real)(camera_a->height - 1) / 2 - made.camera.fy * xy[1] / 2;
    status = rc_check_camera(&made.camera);
    if (status == RIGCAL_OK) {
        *rectified = made;
    }
    return (status == RIGCAL_OK) ? status : RIGCAL_ERR_WIDE_RAY;
}
