#include "rc_transform.h"

/* ---- constants ----------------------------------------------------------- */

/* steps: the most to the mean of rotations, usually 2 or 3. It bounds the worst case, which
 * the manual states. */
enum { KARCHER_MAX = 20 };

/* rad: the steps end if one turns no more than this, which is rounding. */
#define KARCHER_END (4 * RC_EPS)

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

rigcal_status rc_check_ray(const rigcal_real ray[3])
{
    const rigcal_status status = rc_check_point(ray);
    return (status == RIGCAL_OK && !(rc_vec3_max_abs(ray) > 1 / RC_COORDINATE_MAX))
               ? RIGCAL_ERR_RANGE
               : status;
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

void rc_transform_compose(rigcal_transform *c_from_a, const rigcal_transform *c_from_b,
                          const rigcal_transform *b_from_a)
{
    RIGCAL_ASSERT(c_from_a != c_from_b && c_from_a != b_from_a);
    rc_mat3_mul(c_from_a->R, c_from_b->R, b_from_a->R);
    rc_transform_point(c_from_a->t, c_from_b, b_from_a->t);
}

void rc_transform_invert(rigcal_transform *a_from_b, const rigcal_transform *b_from_a)
{
    RIGCAL_ASSERT(a_from_b != b_from_a);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            a_from_b->R[3 * i + j] = b_from_a->R[3 * j + i];
        }
    }
    rc_mat3_tmul_vec3(a_from_b->t, b_from_a->R, b_from_a->t);
    for (int i = 0; i < 3; i++) {
        a_from_b->t[i] = 0 - a_from_b->t[i]; /* so that 0 gives +0 */
    }
}

void rc_transform_point(rigcal_real X_b[3], const rigcal_transform *b_from_a,
                        const rigcal_real X_a[3])
{
    rc_mat3_mul_vec3(X_b, b_from_a->R, X_a);
    rc_vec3_add(X_b, b_from_a->t);
}

/* The quaternion (1, v), v = w / 2, stands for the exponential: it is exact to second
 * order, and a rotation for any step. It takes a column r of R to r + (v x r + v x (v x r))
 * 2 / (1 + |v|^2). */
RC_APART void rc_transform_move(rigcal_transform *pose, const rigcal_real d[6])
{
    rigcal_real v[3];
    rc_vec3_scale(v, RC(0.5), d);
    const rigcal_real scale = 2 / (1 + rc_vec3_dot(v, v));
    for (int column = 0; column < 3; column++) {
        rigcal_real *const R = &pose->R[column];
        const rigcal_real r[3] = {R[0], R[3], R[6]};
        rigcal_real once[3], twice[3];
        rc_vec3_cross(once, v, r);
        rc_vec3_cross(twice, v, once);
        for (int k = 0; k < 3; k++) {
            R[3 * k] += scale * (once[k] + twice[k]);
        }
    }
    rc_vec3_add(pose->t, &d[3]);
}

/* What a step (w, ds) adds to t: ds, and what the turn does to t. */
static void shift_of(rigcal_real dt[3], const rigcal_real d[6], const rigcal_real t[3])
{
    rigcal_real v[3], once[3], twice[3];
    rc_vec3_scale(v, RC(0.5), d);
    const rigcal_real scale = 2 / (1 + rc_vec3_dot(v, v));
    rc_vec3_cross(once, v, t);
    rc_vec3_cross(twice, v, once);
    rc_vec3_add(once, twice);
    rc_vec3_combine(dt, 1, &d[3], scale, once);
}

void rc_transform_displace(rigcal_transform *pose, rigcal_real dt[3],
                           const rigcal_real d[6])
{
    rigcal_real step[6];
    shift_of(dt, d, pose->t);
    rc_vec3_copy(step, d);
    rc_vec3_copy(&step[3], dt);
    rc_transform_move(pose, step);
}

/* (17), (18):  R_ba = R_bw R_aw^T,  t_ba = t_bw - R_ba t_aw */
void rc_transform_between(rigcal_transform *b_from_a, const rigcal_transform *b_from_world,
                          const rigcal_transform *a_from_world)
{
    RIGCAL_ASSERT(b_from_a != b_from_world && b_from_a != a_from_world);
    rigcal_real turned[3];
    rc_mat3_mul_t(b_from_a->R, b_from_world->R, a_from_world->R);
    rc_mat3_mul_vec3(turned, b_from_a->R, a_from_world->t);
    rc_vec3_sub(b_from_a->t, b_from_world->t, turned);
}

void rc_transform_carry(rigcal_real out[36], const rigcal_transform *b_from_a)
{
    const rigcal_real *const R = b_from_a->R;
    rc_clear(out, 36);
    for (int j = 0; j < 3; j++) {
        const rigcal_real r[3] = {R[j], R[3 + j], R[6 + j]};
        rigcal_real shift[3];
        rc_vec3_cross(shift, b_from_a->t, r);
        for (int i = 0; i < 3; i++) {
            out[6 * i + j] = out[6 * (i + 3) + j + 3] = r[i];
            out[6 * (i + 3) + j] = shift[i];
        }
    }
}

/* R is R_b R_c^T: the turns give q_rad (R, R [t_c]^T; [t_b] R, [t_b] R [t_c]^T), the shifts
 * give q_t R. */
void rc_transform_carry_equal(rigcal_real M[36], const rigcal_transform *b_from_a,
                              const rigcal_transform *c_from_a, rigcal_real q_rad,
                              rigcal_real q_t)
{
    rigcal_real R[9];
    rc_mat3_mul_t(R, b_from_a->R, c_from_a->R);
    for (int i = 0; i < 3; i++) {
        rigcal_real *const row = &M[6 * i];
        rc_vec3_scale(row, q_rad, &R[3 * i]);
        rc_vec3_cross(&row[3], c_from_a->t, row);
    }
    for (int j = 0; j < 6; j++) {
        const rigcal_real column[3] = {M[j], M[6 + j], M[12 + j]};
        rigcal_real shift[3];
        rc_vec3_cross(shift, b_from_a->t, column);
        for (int i = 0; i < 3; i++) {
            M[6 * (i + 3) + j] = shift[i] + (j < 3 ? 0 : q_t * R[3 * i + j - 3]);
        }
    }
}

/* ---- the mean of transforms ---------------------------------------------- */

static rigcal_real weight_of(const rigcal_real weight[], size_t i)
{
    return (weight == NULL) ? 1 : weight[i];
}

/* The rotation vector from mean to R_i, in the frame of a. */
static void deviation(rigcal_real w[3], const rigcal_real mean[9], const rigcal_real R_i[9])
{
    rigcal_real mean_t[9], R_i_t[9], between[9];
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++) {
            mean_t[3 * r + c] = mean[3 * c + r];
            R_i_t[3 * r + c] = R_i[3 * c + r];
        }
    }
    rc_mat3_mul_t(between, mean_t, R_i_t); /* mean^T R_i */
    rc_vector_from_rotation(w, between);
}

/* One step to the Karcher mean: turns by the mean deviation. Returns the angle of the
 * turn. */
static rigcal_real karcher_step(rigcal_real mean[9], const rigcal_transform transforms[],
                                const rigcal_real weight[], size_t n, rigcal_real total)
{
    rigcal_real step[3] = {0, 0, 0}, turn[9], turned[9];
    for (size_t i = 0; i < n; i++) {
        rigcal_real w[3];
        deviation(w, mean, transforms[i].R);
        rc_vec3_add_scaled(step, weight_of(weight, i) / total, w);
    }
    rc_rotation_from_vector(turn, step);
    rc_mat3_mul(turned, mean, turn);
    for (int k = 0; k < 9; k++) {
        mean[k] = turned[k];
    }
    return rc_vec3_norm(step);
}

static rigcal_status mean_rotation(rigcal_real R[9], const rigcal_transform transforms[],
                                   const rigcal_real weight[], size_t n, rigcal_real total)
{
    rigcal_real sum[9] = {0}, mean[9];
    for (size_t i = 0; i < n; i++) {
        for (int k = 0; k < 9; k++) {
            sum[k] += weight_of(weight, i) / total * transforms[i].R[k];
        }
    }
    if (!rc_rotation_nearest(mean, sum)) {
        return RIGCAL_ERR_ROTATION;
    }
    for (int i = 0; i < KARCHER_MAX; i++) {
        if (!(karcher_step(mean, transforms, weight, n, total) > KARCHER_END)) {
            break;
        }
    }
    (void)rc_rotation_nearest(R, mean); /* it is a rotation except for rounding */
    return RIGCAL_OK;
}

rigcal_status rc_transform_mean(rigcal_transform *mean, rigcal_real *sigma_rad,
                                rigcal_real *sigma_t, const rigcal_transform transforms[],
                                const rigcal_real weight[], size_t n)
{
    RIGCAL_ASSERT(transforms != NULL && n >= 1);
    rigcal_real total = 0, angles = 0, lengths = 0;
    rigcal_transform found = {{0}, {0}};
    for (size_t i = 0; i < n; i++) {
        total += weight_of(weight, i);
    }
    const rigcal_status status = mean_rotation(found.R, transforms, weight, n, total);
    if (status != RIGCAL_OK) {
        return status;
    }
    for (size_t i = 0; i < n; i++) {
        rc_vec3_add_scaled(found.t, weight_of(weight, i) / total, transforms[i].t);
    }
    for (size_t i = 0; i < n; i++) {
        const rigcal_real part = weight_of(weight, i) / total;
        rigcal_real dt[3];
        const rigcal_real angle = rc_rotation_angle(found.R, transforms[i].R);
        rc_vec3_sub(dt, transforms[i].t, found.t);
        angles += part * angle * angle;
        lengths += part * rc_vec3_dot(dt, dt);
    }
    *mean = found;
    if (sigma_rad != NULL) {
        *sigma_rad = RC_SQRT(angles);
    }
    if (sigma_t != NULL) {
        *sigma_t = RC_SQRT(lengths);
    }
    return RIGCAL_OK;
}

/* ---- public -------------------------------------------------------------- */

static rigcal_status check_two(const rigcal_transform *out, const rigcal_transform *first,
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

rigcal_status rigcal_transform_point(rigcal_real X_b[3], const rigcal_transform *b_from_a,
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

static rigcal_status check_weights(const rigcal_real weight[], size_t n)
{
    rigcal_real total = 0;
    for (size_t i = 0; i < n; i++) {
        const rigcal_real w = weight_of(weight, i);
        if (!rc_is_finite(w)) {
            return RIGCAL_ERR_NOT_FINITE;
        }
        if (!(w >= 0 && w <= RC_COORDINATE_MAX)) {
            return RIGCAL_ERR_RANGE;
        }
        total += w;
    }
    return (total > 0) ? RIGCAL_OK : RIGCAL_ERR_RANGE;
}

rigcal_status rigcal_transform_mean(rigcal_transform *mean, rigcal_real *sigma_rad,
                                    rigcal_real *sigma_t,
                                    const rigcal_transform transforms[],
                                    const rigcal_real weight[], size_t n)
{
    if (mean == NULL || transforms == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (n < 1) {
        return RIGCAL_ERR_TOO_FEW;
    }
    rigcal_status status = (n > RC_COUNT_MAX) ? RIGCAL_ERR_RANGE : check_weights(weight, n);
    for (size_t i = 0; i < n && status == RIGCAL_OK; i++) {
        status = rc_check_transform(&transforms[i]);
    }
    return (status == RIGCAL_OK)
               ? rc_transform_mean(mean, sigma_rad, sigma_t, transforms, weight, n)
               : status;
}
