#include "rc_transform.h"

rigcal_status rc_check_transform(const rigcal_transform *b_from_a)
{
    if (b_from_a == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status t_status = rc_check_point(b_from_a->t);
    if (t_status == RIGCAL_ERR_NOT_FINITE) {
        return t_status;
    }
    const rigcal_status status = rc_check_rotation(b_from_a->R);
    return (status == RIGCAL_OK) ? t_status : status;
}

rigcal_status rc_check_point(const rigcal_real X[3])
{
    return rc_check_numbers(X, 3, RC_COORDINATE_MAX);
}

void rc_transform_identity(rigcal_transform *a_from_a)
{
    for (int i = 0; i < 9; i++) {
        a_from_a->R[i] = (i % 4 == 0) ? 1 : 0;
    }
    for (int i = 0; i < 3; i++) {
        a_from_a->t[i] = 0;
    }
}

void rc_transform_compose(rigcal_transform *c_from_a,
                          const rigcal_transform *c_from_b,
                          const rigcal_transform *b_from_a)
{
    rc_mat3_mul(c_from_a->R, c_from_b->R, b_from_a->R);
    rc_transform_point(c_from_a->t, c_from_b, b_from_a->t);
}

void rc_transform_invert(rigcal_transform *a_from_b,
                         const rigcal_transform *b_from_a)
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            a_from_b->R[3 * i + j] = b_from_a->R[3 * j + i];
        }
    }
    rc_mat3_tmul_vec3(a_from_b->t, b_from_a->R, b_from_a->t);
    for (int i = 0; i < 3; i++) {
        a_from_b->t[i] = 0 - a_from_b->t[i]; /* 0 stays +0 */
    }
}

void rc_transform_point(rigcal_real X_b[3], const rigcal_transform *b_from_a,
                        const rigcal_real X_a[3])
{
    rc_mat3_mul_vec3(X_b, b_from_a->R, X_a);
    rc_vec3_add(X_b, b_from_a->t);
}

/* (17), (18):  R_ba = R_bw R_aw^T,  t_ba = t_bw - R_ba t_aw */
void rc_transform_between(rigcal_transform *b_from_a,
                      const rigcal_transform *b_from_world,
                      const rigcal_transform *a_from_world)
{
    rigcal_real turned[3];
    rc_mat3_mul_t(b_from_a->R, b_from_world->R, a_from_world->R);
    rc_mat3_mul_vec3(turned, b_from_a->R, a_from_world->t);
    rc_vec3_sub(b_from_a->t, b_from_world->t, turned);
}

/* ---- public -------------------------------------------------------------- */

static rigcal_status check_two(const rigcal_transform *out,
                               const rigcal_transform *first,
                               const rigcal_transform *second)
{
    if (out == NULL || first == NULL || second == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = rc_check_transform(first);
    return (status == RIGCAL_OK) ? rc_check_transform(second) : status;
}

rigcal_status rigcal_transform_compose(rigcal_transform *c_from_a,
                                       const rigcal_transform *c_from_b,
                                       const rigcal_transform *b_from_a)
{
    const rigcal_status status = check_two(c_from_a, c_from_b, b_from_a);
    if (status == RIGCAL_OK) {
        rc_transform_compose(c_from_a, c_from_b, b_from_a);
    }
    return status;
}

rigcal_status rigcal_transform_invert(rigcal_transform *a_from_b,
                                      const rigcal_transform *b_from_a)
{
    const rigcal_status status =
        (a_from_b == NULL) ? RIGCAL_ERR_NULL : rc_check_transform(b_from_a);
    if (status == RIGCAL_OK) {
        rc_transform_invert(a_from_b, b_from_a);
    }
    return status;
}

rigcal_status rigcal_transform_point(rigcal_real X_b[3],
                                     const rigcal_transform *b_from_a,
                                     const rigcal_real X_a[3])
{
    if (X_b == NULL || b_from_a == NULL || X_a == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_transform(b_from_a);
    if (status == RIGCAL_OK) {
        status = rc_check_point(X_a);
    }
    if (status == RIGCAL_OK) {
        rc_transform_point(X_b, b_from_a, X_a);
    }
    return status;
}

rigcal_status rigcal_camera_center(rigcal_real o_w[3],
                                   const rigcal_transform *cam_from_world)
{
    const rigcal_status status =
        (o_w == NULL) ? RIGCAL_ERR_NULL : rc_check_transform(cam_from_world);
    if (status == RIGCAL_OK) {
        rigcal_transform world_from_cam;
        rc_transform_invert(&world_from_cam, cam_from_world);
        for (int i = 0; i < 3; i++) {
            o_w[i] = world_from_cam.t[i];
        }
    }
    return status;
}

rigcal_status rigcal_transform_between(rigcal_transform *b_from_a,
                                   const rigcal_transform *b_from_world,
                                   const rigcal_transform *a_from_world)
{
    const rigcal_status status = check_two(b_from_a, b_from_world, a_from_world);
    if (status == RIGCAL_OK) {
        rc_transform_between(b_from_a, b_from_world, a_from_world);
    }
    return status;
}
