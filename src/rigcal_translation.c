#include "rc_translation.h"

/* ---- constants ----------------------------------------------------------- */

/* part of the largest coordinate: rays that differ by less are the same. */
#define SAME (8 * RC_EPS)

/* 1: (10a) and (10b) divide by the difference of two normalised coordinates only if it is
 * larger. */
#define SPREAD_MIN RC_TOL(1e-9, 1e-4)

/* ---- translation --------------------------------------------------------- */

/* u = (x, y) and q = R (X - origin) of a bearing. */
static void ray_and_turned(rigcal_real u[2], rigcal_real q[3], const rigcal_real R[9],
                           const rigcal_bearing *bearing, const rigcal_real origin[3])
{
    rigcal_real x[3];
    u[0] = bearing->ray[0] / bearing->ray[2];
    u[1] = bearing->ray[1] / bearing->ray[2];
    rc_vec3_sub(x, bearing->X_w, origin);
    rc_mat3_mul_vec3(q, R, x);
}

/* Turns t for another origin into t for the world's own origin. */
static void move_origin(rigcal_real t[3], const rigcal_real R[9],
                        const rigcal_real origin[3])
{
    rigcal_real turned[3];
    rc_mat3_mul_vec3(turned, R, origin);
    rc_vec3_sub(t, t, turned);
}

/* Least squares of  t_xy - u t_z = w,  w = u q_z - q_xy. With the means subtracted
 *   t_z = -sum du.w / sum |du|^2,   t_xy = mean(w) + mean(u) t_z */
rigcal_status rc_translation_least_squares(rigcal_real t[3], const rigcal_real R[9],
                                           const rigcal_bearing bearings[], size_t n)
{
    RIGCAL_ASSERT(n >= 2 && rc_is_rotation(R));
    const rigcal_real *const origin = bearings[0].X_w;
    rigcal_real u[2], q[3], u_mean[2] = {0, 0}, w_mean[2] = {0, 0};
    rigcal_real du_w = 0, du_du = 0, u_largest = 0;

    for (size_t i = 0; i < n; i++) {
        ray_and_turned(u, q, R, &bearings[i], origin);
        for (int k = 0; k < 2; k++) {
            u_mean[k] += u[k];
            w_mean[k] += u[k] * q[2] - q[k];
            u_largest = rc_max(u_largest, RC_FABS(u[k]));
        }
    }
    for (int k = 0; k < 2; k++) {
        u_mean[k] /= (rigcal_real)n;
        w_mean[k] /= (rigcal_real)n;
    }
    for (size_t i = 0; i < n; i++) {
        ray_and_turned(u, q, R, &bearings[i], origin);
        for (int k = 0; k < 2; k++) {
            const rigcal_real du = u[k] - u_mean[k];
            du_w += du * (u[k] * q[2] - q[k] - w_mean[k]);
            du_du += du * du;
        }
    }
    const rigcal_real rounding = SAME * rc_max(u_largest, SAME);
    if (!(du_du > (rigcal_real)n * rounding * rounding)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    t[2] = -du_w / du_du;
    t[0] = w_mean[0] + u_mean[0] * t[2];
    t[1] = w_mean[1] + u_mean[1] * t[2];
    move_origin(t, R, origin);
    return RIGCAL_OK;
}

/* ---- public -------------------------------------------------------------- */

static rigcal_status check_translation(const rigcal_real t[3], const rigcal_real R[9],
                                       const rigcal_bearing bearings[], size_t n)
{
    if (t == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_rotation(R);
    if (status == RIGCAL_OK) {
        status = rc_check_bearings(bearings, n, 1);
    }
    return (status == RIGCAL_OK && n < 2) ? RIGCAL_ERR_TOO_FEW : status;
}

rigcal_status rigcal_translation_least_squares(rigcal_real t[3], const rigcal_real R[9],
                                               const rigcal_bearing bearings[], size_t n)
{
    rigcal_real found[3];
    rigcal_status status = check_translation(t, R, bearings, n);
    if (status == RIGCAL_OK) {
        status = rc_translation_least_squares(found, R, bearings, n);
    }
    for (int i = 0; i < 3 && status == RIGCAL_OK; i++) {
        t[i] = found[i];
    }
    return status;
}

/* (10a), (10b) of one pair: adds t_z from each coordinate in which the two differ
 * enough. */
static void sum_depths(rigcal_real *sum, size_t *count, const rigcal_real R[9],
                       const rigcal_bearing *first, const rigcal_bearing *second,
                       const rigcal_real origin[3])
{
    rigcal_real u_i[2], u_j[2], q_i[3], q_j[3];
    ray_and_turned(u_i, q_i, R, first, origin);
    ray_and_turned(u_j, q_j, R, second, origin);
    for (int k = 0; k < 2; k++) {
        const rigcal_real du = u_i[k] - u_j[k];
        if (RC_FABS(du) > SPREAD_MIN) {
            *sum += (q_i[k] - q_j[k] - (u_i[k] * q_i[2] - u_j[k] * q_j[2])) / du;
            ++*count;
        }
    }
}

rigcal_status rigcal_translation_from_pairs(rigcal_real t[3], const rigcal_real R[9],
                                            const rigcal_bearing bearings[], size_t n,
                                            const rigcal_pair pairs[], size_t n_pairs)
{
    rigcal_status status = check_translation(t, R, bearings, n);
    if (status == RIGCAL_OK) {
        status = rc_check_pairs(pairs, n_pairs, 1);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    const rigcal_real *const origin = bearings[0].X_w;
    rigcal_real found[3] = {0, 0, 0}, sum = 0;
    size_t count = 0;
    for (size_t p = 0; p < n_pairs; p++) {
        const int32_t i = pairs[p].i, j = pairs[p].j;
        if ((size_t)i >= n || (size_t)j >= n) { /* or negative */
            return RIGCAL_ERR_RANGE;
        }
        sum_depths(&sum, &count, R, &bearings[i], &bearings[j], origin);
    }
    if (count == 0) {
        return RIGCAL_ERR_DEGENERATE;
    }
    found[2] = sum / (rigcal_real)count;
    for (size_t i = 0; i < n; i++) { /* (9) */
        rigcal_real u[2], q[3];
        ray_and_turned(u, q, R, &bearings[i], origin);
        found[0] += u[0] * (q[2] + found[2]) - q[0];
        found[1] += u[1] * (q[2] + found[2]) - q[1];
    }
    found[0] /= (rigcal_real)n;
    found[1] /= (rigcal_real)n;
    move_origin(found, R, origin);
    for (int i = 0; i < 3; i++) {
        t[i] = found[i];
    }
    return RIGCAL_OK;
}
