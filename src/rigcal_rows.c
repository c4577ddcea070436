#include "rc_rows.h"

/* ---- constants ----------------------------------------------------------- */

/* 1: nearer to the line through both centres than so many times its noise a match has no
 * direction across. */
#define EPIPOLE_NOISE RC(10)

/* rad: the same for rounding, where the noise is less. */
#define EPIPOLE_ROUNDING (64 * RC_EPS)

/* ---- a ray and its noise -------------------------------------------------- */

/* d uv = B dm, B m = 0. Of all dm that is the shortest: T = B^T (B B^T)^-1. */
rigcal_status rc_sight_of(rc_sight *sight, const rigcal_camera *camera,
                          const rigcal_real ray[3], rigcal_real sigma_px)
{
    rigcal_real uv[2], B[6];
    if (!rc_vec3_unit(sight->m, ray)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    const rigcal_status status =
        rc_project_through(uv, B, camera, rc_lens_is_pinhole(camera), sight->m);
    if (status != RIGCAL_OK) {
        return status;
    }
    const rigcal_real uu = rc_vec3_dot(B, B), vv = rc_vec3_dot(&B[3], &B[3]);
    const rigcal_real across = rc_vec3_dot(B, &B[3]);
    const rigcal_real det = uu * vv - across * across;
    if (!(det > 0 && det <= RC_MAX)) {
        return RIGCAL_ERR_NO_RAY;
    }
    const rigcal_real scale = sigma_px / det;
    rc_vec3_combine(sight->T[0], scale * vv, B, -scale * across, &B[3]);
    rc_vec3_combine(sight->T[1], scale * uu, &B[3], -scale * across, B);
    return RIGCAL_OK;
}

/* ---- a match --------------------------------------------------------------- */

/* What the noise of a ray does to e: along its two columns. Returns their square. */
static rigcal_real noise_of(rigcal_real along[2], const rc_sight *sight,
                            const rigcal_real g[3])
{
    along[0] = rc_vec3_dot(sight->T[0], g);
    along[1] = rc_vec3_dot(sight->T[1], g);
    return along[0] * along[0] + along[1] * along[1];
}

/* Whether a ray keeps off the line through both centres: |g| = |t| sin of the angle. */
static int keeps_off(const rc_sight *sight, const rigcal_real g[3], const rigcal_real t[3])
{
    const rigcal_real noise =
        rc_vec3_dot(sight->T[0], sight->T[0]) + rc_vec3_dot(sight->T[1], sight->T[1]);
    const rigcal_real least =
        rc_max(EPIPOLE_NOISE * EPIPOLE_NOISE * noise, EPIPOLE_ROUNDING * EPIPOLE_ROUNDING);
    return rc_vec3_dot(g, g) > least * rc_vec3_dot(t, t);
}

/* The ray at which e = 0 to second order, `by` = e / s^2. */
static void correct(rigcal_real m[3], const rc_sight *sight, rigcal_real by,
                    const rigcal_real along[2])
{
    rc_vec3_copy(m, sight->m);
    rc_vec3_add_scaled(m, -by * along[0], sight->T[0]);
    rc_vec3_add_scaled(m, -by * along[1], sight->T[1]);
}

/* h = by (-m x g - t x c; c), with the gradients g of e by m = m_b and c by t. */
static void derivatives(rigcal_real h[6], rigcal_real by, const rigcal_real t[3],
                        const rigcal_real c[3], const rigcal_real m[3],
                        const rigcal_real g[3])
{
    rigcal_real moved[3], turned[3];
    rc_vec3_cross(moved, t, c);
    rc_vec3_cross(turned, m, g);
    rc_vec3_combine(h, -by, moved, -by, turned);
    rc_vec3_scale(&h[3], by, c);
}

/* (M1) The constraint e = m_b . (t x R m_a), b_from_a = (R, t); r = -e / s, s^2 = the noise
 * of e. (M2), (M3) h at the corrected match: at the noisy one h along the base is
 * -r / |base|, of which a match knows nothing. A move of both cameras together is not seen:
 * h_a = -R^T h_b. */
static rigcal_status match_row(rc_row *row, const rc_seen *seen, const rigcal_transform *a,
                               const rigcal_transform *b)
{
    const rc_sight *const sight_a = &seen->sight[0], *const sight_b = &seen->sight[1];
    rigcal_transform b_from_a;
    rigcal_real along_a[2], along_b[2], m_a[3], m_b[3], q[3], g_a[3], g_b[3], n_a[3], c[3];
    const rigcal_real *const t = b_from_a.t;
    rc_transform_between(&b_from_a, b, a);
    rc_mat3_mul_vec3(q, b_from_a.R, sight_a->m);
    rc_vec3_cross(g_b, t, q);
    rc_vec3_cross(n_a, sight_b->m, t);
    rc_mat3_tmul_vec3(g_a, b_from_a.R, n_a);
    const rigcal_real e = rc_vec3_dot(sight_b->m, g_b);
    const rigcal_real s2 =
        noise_of(along_a, sight_a, g_a) + noise_of(along_b, sight_b, g_b);
    if (!(keeps_off(sight_a, g_b, t) && keeps_off(sight_b, n_a, t) && s2 > 0)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    const rigcal_real by = 1 / RC_SQRT(s2);
    row->r = -e * by;
    row->reach = RC_SQRT(rc_vec3_dot(t, t));
    correct(m_a, sight_a, e / s2, along_a);
    correct(m_b, sight_b, e / s2, along_b);
    rc_mat3_mul_vec3(q, b_from_a.R, m_a);
    rc_vec3_cross(g_b, t, q);
    rc_vec3_cross(c, q, m_b);
    derivatives(row->h_b, by, b->t, c, m_b, g_b);
    rc_mat3_tmul_vec3(row->h_a, b_from_a.R, row->h_b);
    rc_mat3_tmul_vec3(&row->h_a[3], b_from_a.R, &row->h_b[3]);
    rc_vec3_scale(row->h_a, -1, row->h_a);
    rc_vec3_scale(&row->h_a[3], -1, &row->h_a[3]);
    return RIGCAL_OK;
}

/* ---- a view of a target ------------------------------------------------------ */

/* (M4) A point u from the target's origin, seen along the axes of the camera at p = q +
 * t_a: dp = w_a x q + dt_a - R_ab (w_b x u + dt_b). */
static rigcal_status view_rows(rc_row rows[2], const rc_seen *seen,
                               const rigcal_transform *a, const rigcal_transform *b)
{
    rigcal_real u[3], Y[3], q[3], p[3], uv[2], B[6];
    rc_vec3_sub(u, seen->X, b->t);
    rc_mat3_tmul_vec3(Y, b->R, u);
    rc_mat3_mul_vec3(q, a->R, Y);
    rc_vec3_copy(p, q);
    rc_vec3_add(p, a->t);
    const rigcal_status status =
        rc_project_through(uv, B, seen->camera, rc_lens_is_pinhole(seen->camera), p);
    if (status != RIGCAL_OK) {
        return status;
    }
    const rigcal_real by = 1 / seen->sigma_px;
    for (int k = 0; k < 2; k++) {
        rc_row *const row = &rows[k];
        rigcal_real in_rig[3], c[3];
        row->r = by * (seen->uv[k] - uv[k]);
        row->reach = rc_vec3_norm(p);
        rc_vec3_scale(&row->h_a[3], by, &B[3 * k]);
        rc_vec3_cross(row->h_a, q, &row->h_a[3]);
        rc_mat3_tmul_vec3(in_rig, a->R, &row->h_a[3]);
        rc_mat3_mul_vec3(c, b->R, in_rig);
        rc_vec3_scale(&row->h_b[3], -1, c);
        rc_vec3_cross(row->h_b, u, &row->h_b[3]);
        if (!rc_is_finite(row->r) || !rc_all_finite(row->h_b, 6)) {
            return RIGCAL_ERR_NO_RAY;
        }
    }
    return RIGCAL_OK;
}

rigcal_status rc_rows_of(rc_row rows[], const rc_seen *seen, const rigcal_transform *a,
                         const rigcal_transform *b)
{
    return (seen->n_rows == 1) ? match_row(rows, seen, a, b) : view_rows(rows, seen, a, b);
}

/* ---- a target gets its place ------------------------------------------------- */

/* With T = camera_from_target the target's pose is T^-1 camera_from_rig: R = R_T^T R_c,
 * t = R_T^T (t_c - t_T). The errors (w, dt) of the camera and (v, ds) of T turn into
 * R_T^T (w - v) and R_T^T (dt - ds + (t_c - t_T) x v). */
void rc_rows_place(rigcal_transform *target_from_rig, rigcal_real by_camera[36],
                   rigcal_real by_view[36], const rigcal_transform *camera_from_rig,
                   const rigcal_transform *camera_from_target)
{
    const rigcal_real *const R = camera_from_target->R;
    rigcal_transform target_from_camera;
    rigcal_real from[3];
    rc_transform_invert(&target_from_camera, camera_from_target);
    rc_transform_compose(target_from_rig, &target_from_camera, camera_from_rig);
    rc_vec3_sub(from, camera_from_rig->t, camera_from_target->t);
    rc_clear(by_camera, 36);
    rc_clear(by_view, 36);
    for (int i = 0; i < 3; i++) {
        const rigcal_real column[3] = {R[i], R[3 + i], R[6 + i]}; /* row i of R^T */
        for (int j = 0; j < 3; j++) {
            by_camera[6 * i + j] = by_camera[6 * (i + 3) + j + 3] = column[j];
            by_view[6 * i + j] = by_view[6 * (i + 3) + j + 3] = -column[j];
        }
        rc_vec3_cross(&by_view[6 * (i + 3)], column, from);
    }
}
