#include "rc_triangulate.h"

/* ---- constants ----------------------------------------------------------- */

/* part of an element of the diagonal: a smaller pivot is rounding. */
#define RANK_TOL (4 * RC_EPS)

/* part of the larger coordinate: a smaller disparity is rounding. */
#define DISPARITY_LEAST (4 * RC_EPS)

/* ---- depth --------------------------------------------------------------- */

/* (22)..(24): the normal equations of  depth_b m_b - depth_a r = t,  r = R m_a:
 *
 *     [  r.r   -r.m_b  ] [depth_a]   [ -r.t  ]
 *     [ -r.m_b  m_b.m_b] [depth_b] = [ m_b.t ]      det = |r x m_b|^2
 *
 * det comes from the cross product. The difference of products would cancel at small
 * parallax, where det decides. */
static rigcal_status two_depths(rigcal_real depth_ab[2], rigcal_real *miss,
                                const rigcal_transform *b_from_a, const rigcal_real m_a[3],
                                const rigcal_real m_b[3])
{
    const rigcal_real *const t_ba = b_from_a->t;
    rigcal_real r[3], normal[3], gap[3];
    rc_mat3_mul_vec3(r, b_from_a->R, m_a);
    rc_vec3_cross(normal, r, m_b);

    const rigcal_real det = rc_vec3_dot(normal, normal);
    if (!(det >= RC_PARALLAX_MIN)) { /* the rays have length 1 */
        return RIGCAL_ERR_PARALLEL;
    }
    const rigcal_real rm = rc_vec3_dot(r, m_b);
    const rigcal_real rt = rc_vec3_dot(r, t_ba);
    const rigcal_real mt = rc_vec3_dot(m_b, t_ba);
    const rigcal_real depth_a = (rm * mt - rt) / det;
    const rigcal_real depth_b = (mt - rm * rt) / det;
    if (!(depth_a > 0 && depth_b > 0)) {
        return RIGCAL_ERR_BEHIND;
    }
    for (int i = 0; i < 3; i++) {
        gap[i] = depth_b * m_b[i] - depth_a * r[i] - t_ba[i];
    }
    depth_ab[0] = depth_a;
    depth_ab[1] = depth_b;
    *miss = rc_vec3_norm(gap);
    return RIGCAL_OK;
}

rigcal_status rigcal_depth_two_views(rigcal_real depth_ab[2], rigcal_real *miss,
                                     const rigcal_transform *b_from_a,
                                     const rigcal_real ray_a[3], const rigcal_real ray_b[3])
{
    if (depth_ab == NULL || miss == NULL || ray_a == NULL || ray_b == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_transform(b_from_a);
    if (status == RIGCAL_OK) {
        status = rc_check_ray(ray_a);
    }
    if (status == RIGCAL_OK) {
        status = rc_check_ray(ray_b);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    rigcal_real m_a[3], m_b[3], ranges[2];
    (void)rc_vec3_unit(m_a, ray_a);
    (void)rc_vec3_unit(m_b, ray_b);
    status = two_depths(ranges, miss, b_from_a, m_a, m_b);
    if (status == RIGCAL_OK) {
        depth_ab[0] = ranges[0] / rc_vec3_norm(ray_a);
        depth_ab[1] = ranges[1] / rc_vec3_norm(ray_b);
    }
    return status;
}

rigcal_status rigcal_depth_aligned(rigcal_real X_left[3], rigcal_real baseline,
                                   const rigcal_real xy_left[2],
                                   const rigcal_real xy_right[2])
{
    if (X_left == NULL || xy_left == NULL || xy_right == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (!rc_is_finite(baseline) || !rc_all_finite(xy_left, 2) ||
        !rc_all_finite(xy_right, 2)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    if (!(baseline > 0) || !(baseline <= RC_COORDINATE_MAX) ||
        !rc_all_within(xy_left, 2, RC_COORDINATE_MAX) ||
        !rc_all_within(xy_right, 2, RC_COORDINATE_MAX)) {
        return RIGCAL_ERR_RANGE;
    }
    const rigcal_real disparity = xy_left[0] - xy_right[0];
    const rigcal_real size = rc_max(RC_FABS(xy_left[0]), RC_FABS(xy_right[0]));
    if (!(RC_FABS(disparity) >
          rc_max(DISPARITY_LEAST * size, baseline / RC_COORDINATE_MAX))) {
        return RIGCAL_ERR_PARALLEL;
    }
    if (!(disparity > 0)) {
        return RIGCAL_ERR_BEHIND;
    }
    X_left[2] = baseline / disparity;   /* (19) */
    X_left[0] = X_left[2] * xy_left[0]; /* (20) */
    X_left[1] = X_left[2] * xy_left[1];
    return RIGCAL_OK;
}

/* ---- triangulation ------------------------------------------------------- */

/* The views of one point. */
typedef struct {
    const rigcal_camera *cameras;
    const rigcal_transform *cams_from_world;
    const rigcal_real *uv;
    size_t n;
} sightings;

static rigcal_status check_sightings(const sightings *v, rigcal_real sigma_px)
{
    rigcal_status status = rc_check_noise(&sigma_px);
    if (status == RIGCAL_OK && !(sigma_px > 0)) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK && v->n < 2) {
        status = RIGCAL_ERR_TOO_FEW;
    }
    if (status == RIGCAL_OK && v->n > RC_COUNT_MAX) {
        status = RIGCAL_ERR_RANGE;
    }
    for (size_t i = 0; i < v->n && status == RIGCAL_OK; i++) {
        status = rc_check_camera(&v->cameras[i]);
        if (status == RIGCAL_OK) {
            status = rc_check_transform(&v->cams_from_world[i]);
        }
        if (status == RIGCAL_OK) {
            status = rc_check_pixel(&v->uv[2 * i]);
        }
    }
    return status;
}

RC_APART void rc_point_solve(rigcal_real x[3], const rigcal_real L[6])
{
    rc_sym3_forward(x, L);
    rc_sym3_backward(x, L);
}

/* Finds the point with the least sum of squared distances from the rays: sum (I - d d^T) (X
 * - o) = 0. A ray begins at o = -R^T t and has the unit direction d. The sum of I - d d^T
 * over two rays an angle a apart has the determinant 2 sin^2 a, in any frame. So n^3 /
 * determinant, 4 / sin^2 a for two rays, is the measure of parallax for n rays. */
static rigcal_status nearest_to_rays(rigcal_real X[3], const sightings *v)
{
    const rigcal_real n = (rigcal_real)v->n;
    rigcal_real A[6] = {n, 0, 0, n, 0, n};
    rc_clear(X, 3);
    for (size_t i = 0; i < v->n; i++) {
        const rigcal_transform *const T = &v->cams_from_world[i];
        rigcal_real ray[3], d[3], o[3];
        const rigcal_status status = rc_pixel_to_ray(ray, &v->cameras[i], &v->uv[2 * i]);
        if (status != RIGCAL_OK) {
            return status;
        }
        rc_mat3_tmul_vec3(d, T->R, ray);
        rc_mat3_tmul_vec3(o, T->R, T->t);
        rc_vec3_add_scaled(X, rc_vec3_dot(d, o), d);
        rc_vec3_sub(X, X, o);
        rc_sym3_add_outer(A, -1, d);
    }
    if (rc_point_factor(A, A, 0)) {
        const rigcal_real by_root = n * A[0] * A[3] * A[5]; /* n / sqrt(determinant) */
        if (n * by_root * by_root <= 4 / RC_PARALLAX_MIN) {
            rc_point_solve(X, A);
            return RIGCAL_OK;
        }
    }
    return RIGCAL_ERR_PARALLEL;
}

/* The state of a triangulation. */
typedef struct {
    rigcal_levenberg search;
    rigcal_real X[3], g[3], H[6], negligible;
} triangulation;

/* *sum is the sum of squared pixel distances at s->X; g = J^T e and H = J^T J. */
static rigcal_status evaluate(rigcal_real *sum, triangulation *s, const sightings *v)
{
    *sum = 0;
    rc_clear(s->H, 6);
    rc_clear(s->g, 3);
    for (size_t i = 0; i < v->n; i++) {
        const rigcal_transform *const T = &v->cams_from_world[i];
        const rigcal_camera *const camera = &v->cameras[i];
        rigcal_real X_c[3], e[2], B[6];
        rc_transform_point(X_c, T, s->X);
        const rigcal_status status =
            rc_residual(e, B, camera, rc_lens_is_pinhole(camera), &v->uv[2 * i], X_c);
        if (status != RIGCAL_OK) {
            return status;
        }
        rc_point_add(s->g, s->H, B, T->R, e);
        *sum += e[0] * e[0] + e[1] * e[1];
    }
    return rc_is_finite(*sum) ? RIGCAL_OK : RIGCAL_ERR_NO_RAY;
}

RC_APART int rc_point_factor(rigcal_real L[6], const rigcal_real H[6], rigcal_real damping)
{
    rigcal_real D[3];
    rc_sym3_damp(L, D, H, damping);
    return rc_sym3_factor(L, L, D, RANK_TOL);
}

/* Moves by the next step, if there is one. Returns whether it is to be tried. J^T J serves
 * as Newton's H too, because the residuals of a point are small against the curvature. */
static int move_on(rigcal_real *gain, triangulation *s)
{
    rigcal_real L[6], step[3];
    if (!rc_point_factor(L, s->H, s->search.lambda)) {
        rc_levenberg_not_definite(&s->search);
        return 0;
    }
    rc_vec3_copy(step, s->g);
    rc_point_solve(step, L);
    *gain = rc_vec3_dot(s->g, step);
    const int taken = rc_levenberg_promised(&s->search, *gain, s->negligible);
    if (taken == RC_STEP_NONE) {
        return 0;
    }
    rc_vec3_add(s->X, step);
    return taken == RC_STEP_TRY;
}

/* One evaluation, or none. */
static void step_once(triangulation *s, const sightings *v)
{
    rigcal_real before[3], gain = 0, sum = 0;
    const int is_step = s->search.want != RC_WANT_EQUATIONS;
    rc_vec3_copy(before, s->X);
    if (is_step && !move_on(&gain, s)) {
        return;
    }
    const rigcal_status status = evaluate(&sum, s, v);
    if (!is_step) {
        rc_levenberg_evaluated(&s->search, status, sum);
    } else if (!rc_levenberg_tried(&s->search, status, sum, gain, s->negligible)) {
        rc_vec3_copy(s->X, before);
    }
}

rigcal_status rigcal_point_triangulate(rigcal_point *point, const rigcal_camera cameras[],
                                       const rigcal_transform cams_from_world[],
                                       const rigcal_real uv[], size_t n,
                                       rigcal_real sigma_px)
{
    if (point == NULL || cameras == NULL || cams_from_world == NULL || uv == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const sightings v = {cameras, cams_from_world, uv, n};
    triangulation s;
    rigcal_real L[6];
    rigcal_status status = check_sightings(&v, sigma_px);
    if (status == RIGCAL_OK) {
        status = nearest_to_rays(s.X, &v);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    s.negligible = rc_negligible(rc_pixel_size(cameras), (rigcal_real)cameras->width);
    rc_levenberg_begin(&s.search, 0);
    for (int i = 0; i < RC_TRIANGULATION_EVALS && s.search.status == RIGCAL_RUNNING; i++) {
        step_once(&s, &v);
    }
    status = s.search.status;
    if (status == RIGCAL_ERR_DEGENERATE || (status >= 0 && !rc_point_factor(L, s.H, 0))) {
        return RIGCAL_ERR_PARALLEL;
    }
    if (status < 0) {
        return status;
    }
    rc_vec3_copy(point->X, s.X);
    for (int k = 0; k < 3; k++) {
        rigcal_real *const row = &point->Sigma[3 * k];
        rc_clear(row, 3);
        row[k] = sigma_px * sigma_px;
        rc_point_solve(row, L);
    }
    point->rms_px = RC_SQRT(s.search.sum / (rigcal_real)n);
    return (status == RIGCAL_OK) ? RIGCAL_OK : RIGCAL_BUDGET_SPENT;
}

/* ---- Section VI-C -------------------------------------------------------- */

rigcal_status rigcal_point_bound(rigcal_real *bound, const rigcal_transform *b_from_a_used,
                                 const rigcal_transform *b_from_a_true,
                                 const rigcal_real X_a[3])
{
    if (bound == NULL || b_from_a_true == NULL || X_a == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_transform(b_from_a_used);
    if (status == RIGCAL_OK) {
        status = rc_check_transform(b_from_a_true);
    }
    if (status == RIGCAL_OK) {
        status = rc_check_point(X_a);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    rigcal_real dt[3];
    const rigcal_real angle = rc_rotation_angle(b_from_a_true->R, b_from_a_used->R);
    rc_vec3_sub(dt, b_from_a_used->t, b_from_a_true->t);
    *bound = 2 * RC_SIN(angle / 2) * rc_vec3_norm(X_a) + rc_vec3_norm(dt);
    return RIGCAL_OK;
}
