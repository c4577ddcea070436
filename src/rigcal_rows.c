#include "rc_rows.h"

/* ---- constants ----------------------------------------------------------- */

/* 1: a match that is nearer to the line through both centres than this times its noise has
 * no direction across this line. */
#define EPIPOLE_NOISE RC(10)

/* rad: the least such angle if the noise is smaller. It is rounding. */
#define EPIPOLE_ROUNDING (64 * RC_EPS)

/* 1: a pinhole does not image rays with a larger tangent. */
#define TANGENT_MOST RC_TOL(1e8, 1e4)

/* ---- a ray and its noise -------------------------------------------------- */

/* rc_sight_of in closed form, with m = c (x, y, 1): T = sigma c^3 ((1 + y^2, -x y, -x) /
 * fx, (-x y, 1 + x^2, -y) / fy). */
static rigcal_status sight_of_pinhole(rc_sight *sight, const rigcal_camera *camera,
                                      const rigcal_real ray[3], rigcal_real sigma_px)
{
    if (!(ray[2] > 0)) {
        return RIGCAL_ERR_BEHIND;
    }
    const rigcal_real x = ray[0] / ray[2], y = ray[1] / ray[2];
    const rigcal_real xx = 1 + x * x, yy = 1 + y * y;
    if (!(xx + yy <= TANGENT_MOST * TANGENT_MOST)) {
        return RIGCAL_ERR_NO_RAY;
    }
    const rigcal_real c = 1 / RC_SQRT(xx + y * y), scale = sigma_px * c * c * c;
    const rigcal_real u = scale / camera->fx, v = scale / camera->fy;
    rigcal_real *const m = sight->m, *const along_u = sight->T[0];
    rigcal_real *const along_v = sight->T[1];
    m[0] = c * x;
    m[1] = c * y;
    m[2] = c;
    along_u[0] = u * yy;
    along_u[1] = -u * x * y;
    along_u[2] = -u * x;
    along_v[0] = -v * x * y;
    along_v[1] = v * xx;
    along_v[2] = -v * y;
    return RIGCAL_OK;
}

/* rc_lens_is_pinhole, inline because each row needs it twice. */
static inline int is_pinhole(const rigcal_camera *camera)
{
    const int is_distorted = camera->k1 != 0 || camera->k2 != 0 || camera->p1 != 0 ||
                             camera->p2 != 0 || camera->k3 != 0 || camera->k4 != 0 ||
                             camera->k5 != 0 || camera->k6 != 0;
    return !is_distorted && !rc_lens_is_fisheye(camera);
}

/* d uv = B dm and B m = 0. Of all dm that fit, T = B^T (B B^T)^-1 gives the shortest. */
rigcal_status rc_sight_of(rc_sight *sight, const rigcal_camera *camera,
                          const rigcal_real ray[3], rigcal_real sigma_px)
{
    if (is_pinhole(camera)) {
        return sight_of_pinhole(sight, camera, ray, sigma_px);
    }
    rigcal_real uv[2], B[6];
    if (!rc_vec3_unit(sight->m, ray)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    const rigcal_status status = rc_project_through(uv, B, camera, 0, sight->m);
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

/* out = M^T v, inline because it is called often here. */
static inline void turn_back(rigcal_real out[3], const rigcal_real M[9],
                             const rigcal_real v[3])
{
    out[0] = M[0] * v[0] + M[3] * v[1] + M[6] * v[2];
    out[1] = M[1] * v[0] + M[4] * v[1] + M[7] * v[2];
    out[2] = M[2] * v[0] + M[5] * v[1] + M[8] * v[2];
}

/* R = B A^T; t = t_b - R t_a. */
static inline void relate(rigcal_real R[9], rigcal_real t[3], const rigcal_transform *b,
                          const rigcal_transform *a)
{
    rc_mat3_mul_vec3(&R[0], a->R, &b->R[0]);
    rc_mat3_mul_vec3(&R[3], a->R, &b->R[3]);
    rc_mat3_mul_vec3(&R[6], a->R, &b->R[6]);
    t[0] = b->t[0] - rc_vec3_dot(&R[0], a->t);
    t[1] = b->t[1] - rc_vec3_dot(&R[3], a->t);
    t[2] = b->t[2] - rc_vec3_dot(&R[6], a->t);
}

/* What the noise of a ray does to e, along its two columns. Returns the sum of their
 * squares. */
static inline rigcal_real noise_of(rigcal_real along[2], const rc_sight *sight,
                                   const rigcal_real g[3])
{
    along[0] = rc_vec3_dot(sight->T[0], g);
    along[1] = rc_vec3_dot(sight->T[1], g);
    return along[0] * along[0] + along[1] * along[1];
}

/* Whether a ray is far enough from the line through both centres: |g| = |t| sin of the
 * angle. */
static inline int keeps_off(const rc_sight *sight, const rigcal_real g[3], rigcal_real t2)
{
    const rigcal_real noise =
        rc_vec3_dot(sight->T[0], sight->T[0]) + rc_vec3_dot(sight->T[1], sight->T[1]);
    const rigcal_real least =
        rc_max(EPIPOLE_NOISE * EPIPOLE_NOISE * noise, EPIPOLE_ROUNDING * EPIPOLE_ROUNDING);
    return rc_vec3_dot(g, g) > least * t2;
}

/* The ray at which e = 0 to second order. `by` = e / s^2. */
static inline void correct(rigcal_real m[3], const rc_sight *sight, rigcal_real by,
                           const rigcal_real along[2])
{
    const rigcal_real u = by * along[0], v = by * along[1];
    m[0] = sight->m[0] - u * sight->T[0][0] - v * sight->T[1][0];
    m[1] = sight->m[1] - u * sight->T[0][1] - v * sight->T[1][1];
    m[2] = sight->m[2] - u * sight->T[0][2] - v * sight->T[1][2];
}

/* The derivatives of -e at the match (m_a, m_b), times by = 1 / s. With the gradients g of
 * e by m_b and c of e by t, h_b = by (-m_b x g; c). A move of both cameras together is not
 * seen: camera b then moves by w_b = R w_a and ds_b = R ds_a + t x R w_a. So h_a is -R^T
 * (h_b's w - t x c; c). */
static void derive(rc_row *row, rigcal_real by, const rigcal_real R[9],
                   const rigcal_real t[3], const rigcal_real m_a[3],
                   const rigcal_real m_b[3])
{
    rigcal_real q[3], g[3], c[3], turned[3];
    rc_mat3_mul_vec3(q, R, m_a);
    rc_vec3_cross(g, t, q);
    rc_vec3_cross(c, q, m_b);
    rc_vec3_scale(c, by, c);
    rc_vec3_cross(turned, g, m_b);
    rc_vec3_scale(row->h_b, by, turned);
    rc_vec3_copy(&row->h_b[3], c);
    rc_vec3_cross(q, t, c);
    rc_vec3_sub(q, q, row->h_b);
    turn_back(row->h_a, R, q);
    turn_back(turned, R, c);
    rc_vec3_scale(&row->h_a[3], -1, turned);
}

/* (M1) The constraint is e = m_b . (t x R m_a), with b_from_a = (R, t). r = -e / s, and s^2
 * is the variance of e. (M2), (M3) h is taken at the corrected match. At the noisy one h
 * would be -r / |base| along the base, although a match contains no information on its
 * length. */
static rigcal_status match_row(rc_row *row, const rc_seen *seen, const rigcal_transform *a,
                               const rigcal_transform *b)
{
    const rc_sight *const sight_a = &seen->sight[0], *const sight_b = &seen->sight[1];
    rigcal_real R[9], t[3], along_a[2], along_b[2], m_a[3], m_b[3], q[3], g_a[3], g_b[3];
    relate(R, t, b, a);
    rc_mat3_mul_vec3(q, R, sight_a->m);
    rc_vec3_cross(g_b, t, q);
    rc_vec3_cross(q, sight_b->m, t);
    turn_back(g_a, R, q);
    const rigcal_real e = rc_vec3_dot(sight_b->m, g_b), t2 = rc_vec3_dot(t, t);
    const rigcal_real s2 =
        noise_of(along_a, sight_a, g_a) + noise_of(along_b, sight_b, g_b);
    if (!(keeps_off(sight_a, g_b, t2) && keeps_off(sight_b, q, t2) && s2 > 0)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    const rigcal_real by = 1 / RC_SQRT(s2), back = e * by * by;
    row->r = -e * by;
    row->reach = RC_SQRT(t2);
    correct(m_a, sight_a, back, along_a);
    correct(m_b, sight_b, back, along_b);
    derive(row, by, R, t, m_a, m_b);
    return RIGCAL_OK;
}

/* ---- a view of a target ------------------------------------------------------ */

/* (M4) A point X of the target is at p in the camera's frame: dp = w_a x p + ds_a - R_ab
 * (w_b x X + ds_b). */
static rigcal_status view_rows(rc_row rows[2], const rc_seen *seen,
                               const rigcal_transform *a, const rigcal_transform *b)
{
    rigcal_real u[3], Y[3], p[3], uv[2], B[6];
    rc_vec3_sub(u, seen->X, b->t);
    rc_mat3_tmul_vec3(Y, b->R, u);
    rc_mat3_mul_vec3(p, a->R, Y);
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
        rc_vec3_cross(row->h_a, p, &row->h_a[3]);
        rc_mat3_tmul_vec3(in_rig, a->R, &row->h_a[3]);
        rc_mat3_mul_vec3(c, b->R, in_rig);
        rc_vec3_scale(&row->h_b[3], -1, c);
        rc_vec3_cross(row->h_b, seen->X, &row->h_b[3]);
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

/* With T = camera_from_target the target's pose is T^-1 camera_from_rig. So the camera's
 * error is carried by T^-1. The errors v, dt of T become -R_T^T v and -R_T^T dt. */
void rc_rows_place(rigcal_transform *target_from_rig, rigcal_real by_camera[36],
                   rigcal_real by_view[36], const rigcal_transform *camera_from_rig,
                   const rigcal_transform *camera_from_target)
{
    rigcal_transform target_from_camera;
    rc_transform_invert(&target_from_camera, camera_from_target);
    rc_transform_compose(target_from_rig, &target_from_camera, camera_from_rig);
    rc_transform_carry(by_camera, &target_from_camera);
    rc_clear(by_view, 36);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            by_view[6 * i + j] = by_view[6 * (i + 3) + j + 3] = -by_camera[6 * i + j];
        }
    }
}
