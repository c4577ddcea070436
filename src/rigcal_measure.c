#include "rc_measure.h"

/* Least parallax, as sin^2 of the angle between two rays: 0.1 degree. A bearing
 * error e moves the point by range * e / sin(angle) in depth, there over 500
 * times as far as sideways. */
#define PARALLAX_MIN RC(3.05e-6)

/* An epipole is met when t and R m are parallel to this many roundings. */
#define EPIPOLE_TOL (16 * RC_EPS)

/* alpha^2 + beta^2 of a line in distance form. */
#define LINE_TOL RC_TOL(1e-6, 1e-3)

static rigcal_status check_ray(const rigcal_real ray[3])
{
    const rigcal_status status = rc_check_point(ray);
    if (status != RIGCAL_OK) {
        return status;
    }
    return (rc_vec3_max_abs(ray) > 1 / RC_COORDINATE_MAX) ? RIGCAL_OK
                                                          : RIGCAL_ERR_RANGE;
}

/* ---- depth --------------------------------------------------------------- */

/* (22)..(24): normal equations of  depth_b m_b - depth_a r = t,  r = R m_a:
 *
 *     [  r.r   -r.m_b  ] [depth_a]   [ -r.t  ]
 *     [ -r.m_b  m_b.m_b] [depth_b] = [ m_b.t ]      det = |r x m_b|^2
 *
 * det is taken from the cross product: the difference of products cancels at
 * small parallax, which is where it decides. */
static rigcal_status two_depths(rigcal_real depth_ab[2], rigcal_real *miss,
                                const rigcal_transform *b_from_a,
                                const rigcal_real m_a[3],
                                const rigcal_real m_b[3])
{
    const rigcal_real *const t_ba = b_from_a->t;
    rigcal_real r[3], normal[3], gap[3];
    rc_mat3_mul_vec3(r, b_from_a->R, m_a);
    rc_vec3_cross(normal, r, m_b);

    const rigcal_real det = rc_vec3_dot(normal, normal);
    if (!(det >= PARALLAX_MIN)) { /* of unit rays */
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
                                     const rigcal_real ray_a[3],
                                     const rigcal_real ray_b[3])
{
    if (depth_ab == NULL || miss == NULL || ray_a == NULL || ray_b == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_transform(b_from_a);
    if (status == RIGCAL_OK) {
        status = check_ray(ray_a);
    }
    if (status == RIGCAL_OK) {
        status = check_ray(ray_b);
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
          rc_max(4 * RC_EPS * size, baseline / RC_COORDINATE_MAX))) {
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

/* What one point is seen by. */
typedef struct {
    const rigcal_camera *cameras;
    const rigcal_transform *cams_from_world;
    const rigcal_real *uv;
    size_t n;
} views;

static rigcal_status check_views(const views *v, rigcal_real sigma_px)
{
    rigcal_status status = rc_check_numbers(&sigma_px, 1, RC(1e6));
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

/* x <- (L L^T)^-1 x */
static void solve(rigcal_real x[3], const rigcal_real L[6])
{
    rc_sym3_forward(x, L);
    rc_sym3_backward(x, L);
}

/* The point with the least sum of squared distances from the rays, along unit d from a
 * point o: sum (I - d d^T) (X - o) = 0, o = -R^T t. Two rays an angle a apart leave the
 * sum of I - d d^T a least eigenvalue of a^2 / 2. */
static rigcal_status nearest_to_rays(rigcal_real X[3], const views *v)
{
    const rigcal_real n = (rigcal_real)v->n, of_n[3] = {n, n, n};
    rigcal_real A[6] = {n, 0, 0, n, 0, n};
    X[0] = X[1] = X[2] = 0;
    for (size_t i = 0; i < v->n; i++) {
        const rigcal_transform *const T = &v->cams_from_world[i];
        rigcal_real ray[3], d[3], o[3];
        const rigcal_status status =
            rc_pixel_to_ray(ray, &v->cameras[i], &v->uv[2 * i]);
        if (status != RIGCAL_OK) {
            return status;
        }
        rc_mat3_tmul_vec3(d, T->R, ray);
        rc_mat3_tmul_vec3(o, T->R, T->t);
        rc_vec3_add_scaled(X, rc_vec3_dot(d, o), d);
        rc_vec3_add_scaled(X, -1, o);
        rc_sym3_add_outer(A, -1, d);
    }
    if (!rc_sym3_factor(A, A, of_n, PARALLAX_MIN / 4)) {
        return RIGCAL_ERR_PARALLEL;
    }
    solve(X, A);
    return RIGCAL_OK;
}

/* Sum of squared pixel distances at X, J^T J and J^T e. */
static rigcal_status sum_squares(rigcal_real *sum, rigcal_real H[6],
                                 rigcal_real g[3], const views *v,
                                 const rigcal_real X[3])
{
    *sum = 0;
    for (int k = 0; k < 6; k++) {
        H[k] = 0;
        g[k / 2] = 0;
    }
    for (size_t i = 0; i < v->n; i++) {
        rigcal_real X_c[3], uv[2], J_c[6], J[3];
        rigcal_lens lens;
        rc_transform_point(X_c, &v->cams_from_world[i], X);
        rc_lens_of(&lens, &v->cameras[i]);
        const rigcal_status status =
            rc_project_through(uv, J_c, &lens, &v->cameras[i], X_c);
        if (status != RIGCAL_OK) {
            return status;
        }
        for (int row = 0; row < 2; row++) {
            const rigcal_real e = v->uv[2 * i + (size_t)row] - uv[row];
            *sum += e * e;
            rc_mat3_tmul_vec3(J, v->cams_from_world[i].R, &J_c[3 * row]);
            rc_vec3_add_scaled(g, e, J);
            rc_sym3_add_outer(H, 1, J);
        }
    }
    return rc_is_finite(*sum) ? RIGCAL_OK : RIGCAL_ERR_NO_RAY;
}

enum { EVALS_MAX = 100, HALVINGS_MAX = 30 };

/* Change of the sum, as a part of it, that may be rounding: that of a pixel of
 * 1000 over a distance of a tenth. Near the minimum the sum no longer tells two
 * points apart, while the step still does: so steps are taken until they are small
 * or shrink no more, and shortened only when they do harm. The sum of exact pixels is
 * all rounding, and ends them when it falls no more. */
#define SUM_ROUNDING RC_TOL(1e-10, 1e-3)

/* Gauss-Newton from X, a step halved until it does no harm. Gives the sum at the end,
 * and the Cholesky factor of J^T J. */
static rigcal_status refine_point(rigcal_real X[3], rigcal_real *sum,
                                  rigcal_real L[6], const views *v)
{
    const rigcal_real small2 = 16 * RC_EPS * RC_EPS;
    rigcal_real step[3] = {0, 0, 0}, last_gain = RC_MAX;
    int halvings = 0;
    *sum = RC_MAX;
    for (int i = 0; i < EVALS_MAX && halvings < HALVINGS_MAX; i++) {
        rigcal_real at[3], H[6], g[3], sum_at;
        rc_vec3_copy(at, X);
        rc_vec3_add(at, step);
        const rigcal_status status = sum_squares(&sum_at, H, g, v, at);
        if (i == 0 && status != RIGCAL_OK) {
            return status;
        }
        if (status != RIGCAL_OK || !(sum_at <= *sum * (1 + SUM_ROUNDING))) {
            rc_vec3_scale(step, RC(0.5), step);
            halvings++;
            continue;
        }
        const int is_small =
            i > 0 && !(rc_vec3_dot(step, step) > small2 * rc_vec3_dot(at, at));
        const int falls = sum_at < *sum;
        halvings = 0;
        *sum = sum_at;
        rc_vec3_copy(X, at);
        const rigcal_real diagonal[3] = {H[0], H[3], H[5]};
        if (!rc_sym3_factor(L, H, diagonal, 4 * RC_EPS)) {
            return RIGCAL_ERR_PARALLEL;
        }
        rc_vec3_copy(step, g);
        solve(step, L);
        const rigcal_real gain = rc_vec3_dot(g, step); /* what it promises */
        if (is_small || (!(gain < last_gain / 4) &&
                         (gain <= SUM_ROUNDING * sum_at || !falls))) {
            break;
        }
        last_gain = gain;
    }
    return RIGCAL_OK;
}

rigcal_status rigcal_triangulate(rigcal_point *point,
                                 const rigcal_camera cameras[],
                                 const rigcal_transform cams_from_world[],
                                 const rigcal_real uv[], size_t n,
                                 rigcal_real sigma_px)
{
    if (point == NULL || cameras == NULL || cams_from_world == NULL ||
        uv == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const views v = {cameras, cams_from_world, uv, n};
    rigcal_real X[3], L[6], sum = 0;
    rigcal_status status = check_views(&v, sigma_px);
    if (status == RIGCAL_OK) {
        status = nearest_to_rays(X, &v);
    }
    if (status == RIGCAL_OK) {
        status = refine_point(X, &sum, L, &v);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    for (int k = 0; k < 3; k++) {
        rigcal_real *const row = &point->Sigma[3 * k];
        row[0] = row[1] = row[2] = 0;
        row[k] = sigma_px * sigma_px;
        solve(row, L);
        point->X[k] = X[k];
    }
    point->rms_px = RC_SQRT(sum / (rigcal_real)n);
    return RIGCAL_OK;
}

/* ---- the matching line --------------------------------------------------- */

/* Divides by |(alpha, beta)|: the left side becomes a distance. 0 when the line
 * is at infinity. */
static int scale_line(rigcal_real line[3])
{
    const rigcal_real length = RC_SQRT(line[0] * line[0] + line[1] * line[1]);
    if (!(length > EPIPOLE_TOL * RC_FABS(line[2]))) {
        return 0;
    }
    rc_vec3_scale(line, 1 / length, line);
    return 1;
}

/* (26): (alpha, beta, gamma) = t x R m_a, from unit vectors. */
static rigcal_status epiline(rigcal_real line[3],
                             const rigcal_transform *b_from_a,
                             const rigcal_real ray_a[3])
{
    rigcal_real m[3], r[3], t[3];
    (void)rc_vec3_unit(m, ray_a);
    rc_mat3_mul_vec3(r, b_from_a->R, m);
    if (!rc_vec3_unit(t, b_from_a->t)) {
        return RIGCAL_ERR_EPIPOLE;
    }
    rc_vec3_cross(line, t, r);
    if (!(rc_vec3_norm(line) > EPIPOLE_TOL)) {
        return RIGCAL_ERR_EPIPOLE;
    }
    return scale_line(line) ? RIGCAL_OK : RIGCAL_ERR_OUTSIDE;
}

static rigcal_status check_epiline(const rigcal_real out[],
                                   const rigcal_transform *b_from_a,
                                   const rigcal_real ray_a[3])
{
    if (out == NULL || ray_a == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = rc_check_transform(b_from_a);
    return (status == RIGCAL_OK) ? check_ray(ray_a) : status;
}

rigcal_status rigcal_epiline(rigcal_real line[3],
                             const rigcal_transform *b_from_a,
                             const rigcal_real ray_a[3])
{
    rigcal_real found[3];
    rigcal_status status = check_epiline(line, b_from_a, ray_a);
    if (status == RIGCAL_OK) {
        status = epiline(found, b_from_a, ray_a);
    }
    if (status == RIGCAL_OK) {
        rc_vec3_copy(line, found);
    }
    return status;
}

/* x = (u - cx) / fx and y alike put into alpha x + beta y + gamma = 0. */
rigcal_status rigcal_epiline_px(rigcal_real line_px[3],
                                const rigcal_camera *camera_b,
                                const rigcal_transform *b_from_a,
                                const rigcal_real ray_a[3])
{
    rigcal_real line[3];
    rigcal_status status = check_epiline(line_px, b_from_a, ray_a);
    if (status == RIGCAL_OK) {
        status = rc_check_camera(camera_b);
    }
    if (status == RIGCAL_OK) {
        status = epiline(line, b_from_a, ray_a);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    line[0] /= camera_b->fx;
    line[1] /= camera_b->fy;
    line[2] -= line[0] * camera_b->cx + line[1] * camera_b->cy;
    if (!scale_line(line)) {
        return RIGCAL_ERR_OUTSIDE;
    }
    rc_vec3_copy(line_px, line);
    return RIGCAL_OK;
}

static rigcal_status check_line(const rigcal_real line_px[3])
{
    if (line_px == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (!rc_all_finite(line_px, 3)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    const rigcal_real squared =
        line_px[0] * line_px[0] + line_px[1] * line_px[1];
    return (RC_FABS(squared - 1) <= LINE_TOL) ? RIGCAL_OK : RIGCAL_ERR_RANGE;
}

rigcal_status rigcal_epiline_distance(rigcal_real *distance_px,
                                      const rigcal_real line_px[3],
                                      const rigcal_camera *camera_b,
                                      const rigcal_real uv_b[2])
{
    rigcal_real straight[2];
    if (distance_px == NULL || line_px == NULL || uv_b == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = check_line(line_px);
    if (status == RIGCAL_OK) {
        status = rigcal_undistort_pixel(straight, camera_b, uv_b);
    }
    if (status == RIGCAL_OK) {
        *distance_px =
            line_px[0] * straight[0] + line_px[1] * straight[1] + line_px[2];
    }
    return status;
}

static rigcal_real within(rigcal_real x, rigcal_real low, rigcal_real high)
{
    return rc_max(low, rc_min(x, high));
}

/* Narrows [from, to] to where low <= start + s slope <= high (Liang and Barsky
 * 1984). */
static void clip_interval(rigcal_real *from, rigcal_real *to, rigcal_real start,
                          rigcal_real slope, rigcal_real low, rigcal_real high)
{
    if (RC_FABS(slope) > 0) {
        const rigcal_real a = (low - start) / slope, b = (high - start) / slope;
        *from = rc_max(*from, rc_min(a, b));
        *to = rc_min(*to, rc_max(a, b));
    } else if (!(start >= low && start <= high)) {
        *to = -RC_MAX;
    }
}

rigcal_status rigcal_epiline_clip(rigcal_real ends[4],
                                  const rigcal_real line_px[3], int32_t width,
                                  int32_t height)
{
    if (ends == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = check_line(line_px);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (width < 1 || height < 1 || width > RC_IMAGE_MAX || height > RC_IMAGE_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    const rigcal_real right = (rigcal_real)width - RC(0.5);
    const rigcal_real bottom = (rigcal_real)height - RC(0.5);
    const rigcal_real alpha = line_px[0], beta = line_px[1];
    /* The foot of the perpendicular from the image's centre, and onwards. */
    const rigcal_real cu = (right - RC(0.5)) / 2, cv = (bottom - RC(0.5)) / 2;
    const rigcal_real distance = alpha * cu + beta * cv + line_px[2];
    const rigcal_real u = cu - distance * alpha, v = cv - distance * beta;
    rigcal_real from = -RC_MAX, to = RC_MAX;
    clip_interval(&from, &to, u, beta, RC(-0.5), right);
    clip_interval(&from, &to, v, -alpha, RC(-0.5), bottom);
    if (!(from < to)) {
        return RIGCAL_ERR_OUTSIDE;
    }
    /* Rounding may put an end on the border just beyond it. */
    ends[0] = within(u + from * beta, RC(-0.5), right);
    ends[1] = within(v - from * alpha, RC(-0.5), bottom);
    ends[2] = within(u + to * beta, RC(-0.5), right);
    ends[3] = within(v - to * alpha, RC(-0.5), bottom);
    return RIGCAL_OK;
}

static rigcal_status check_depth_range(const rigcal_camera *camera_b,
                                       rigcal_real near_a, rigcal_real far_a)
{
    const rigcal_status status = rc_check_camera(camera_b);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!rc_is_finite(near_a) || !rc_is_finite(far_a)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    return (near_a > 0 && far_a > near_a && far_a <= RC_COORDINATE_MAX)
               ? RIGCAL_OK
               : RIGCAL_ERR_RANGE;
}

/* The point at a depth along ray_a, in the frame of b. */
static void point_at_depth(rigcal_real X_b[3], const rigcal_transform *b_from_a,
                           const rigcal_real ray_a[3], rigcal_real depth)
{
    const rigcal_real X_a[3] = {depth * ray_a[0], depth * ray_a[1],
                                depth * ray_a[2]};
    rc_transform_point(X_b, b_from_a, X_a);
}

rigcal_status rigcal_epiline_segment(rigcal_real ends[4],
                                     const rigcal_camera *camera_b,
                                     const rigcal_transform *b_from_a,
                                     const rigcal_real ray_a[3],
                                     rigcal_real near_a, rigcal_real far_a)
{
    rigcal_status status = check_epiline(ends, b_from_a, ray_a);
    if (status == RIGCAL_OK) {
        status = check_depth_range(camera_b, near_a, far_a);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    rigcal_real found[4];
    for (int i = 0; i < 2; i++) {
        rigcal_real X_b[3];
        point_at_depth(X_b, b_from_a, ray_a, (i == 0) ? near_a : far_a);
        if (!(X_b[2] > RC_EPS * rc_vec3_max_abs(X_b))) {
            return RIGCAL_ERR_WIDE_RAY;
        }
        found[2 * i] = camera_b->fx * (X_b[0] / X_b[2]) + camera_b->cx;
        found[2 * i + 1] = camera_b->fy * (X_b[1] / X_b[2]) + camera_b->cy;
    }
    for (int i = 0; i < 4; i++) {
        ends[i] = found[i];
    }
    return RIGCAL_OK;
}

rigcal_status rigcal_epiline_curve(rigcal_real uv_b[], int32_t *n_written,
                                   int32_t count, const rigcal_camera *camera_b,
                                   const rigcal_transform *b_from_a,
                                   const rigcal_real ray_a[3],
                                   rigcal_real near_a, rigcal_real far_a)
{
    if (n_written == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = check_epiline(uv_b, b_from_a, ray_a);
    if (status == RIGCAL_OK) {
        status = check_depth_range(camera_b, near_a, far_a);
    }
    if (status == RIGCAL_OK && count < 2) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    int32_t written = 0;
    for (int32_t i = 0; i < count; i++) {
        /* 1 / depth from 1 / near to 1 / far in even steps. Near / far may underflow. */
        const rigcal_real s = (rigcal_real)i / (rigcal_real)(count - 1);
        const rigcal_real depth =
            (i + 1 < count) ? near_a / ((1 - s) + s * (near_a / far_a)) : far_a;
        rigcal_real X_b[3];
        point_at_depth(X_b, b_from_a, ray_a, depth);
        if (rigcal_project(&uv_b[2 * written], camera_b, X_b) == RIGCAL_OK) {
            written++;
        }
    }
    if (written == 0) {
        return RIGCAL_ERR_OUTSIDE;
    }
    *n_written = written;
    return RIGCAL_OK;
}
