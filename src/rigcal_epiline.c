#include "rc_camera.h"

/* ---- constants ----------------------------------------------------------- */

/* sine: if t and R m are more parallel, the ray meets the epipole to rounding. */
#define EPIPOLE_TOL (16 * RC_EPS)

/* 1: how far alpha^2 + beta^2 of a line may be from 1. It allows for a line that was
 * written with seven digits. */
#define LINE_TOL RC_TOL(1e-6, 1e-3)

/* Divides by |(alpha, beta)|, so that the left side becomes a distance. Returns 0 if the
 * line is at infinity. */
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
static rigcal_status epiline(rigcal_real line[3], const rigcal_transform *b_from_a,
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
    return (status == RIGCAL_OK) ? rc_check_ray(ray_a) : status;
}

rigcal_status rigcal_epiline(rigcal_real line[3], const rigcal_transform *b_from_a,
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

/* x = (u - cx) / fx and the like for y, put into alpha x + beta y + gamma = 0. */
rigcal_status rigcal_epiline_px(rigcal_real line_px[3], const rigcal_camera *camera_b,
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
    const rigcal_real squared = line_px[0] * line_px[0] + line_px[1] * line_px[1];
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
        status = rigcal_camera_undistort(straight, camera_b, uv_b);
    }
    if (status == RIGCAL_OK) {
        *distance_px = line_px[0] * straight[0] + line_px[1] * straight[1] + line_px[2];
    }
    return status;
}

static rigcal_real within(rigcal_real x, rigcal_real low, rigcal_real high)
{
    return rc_max(low, rc_min(x, high));
}

/* Narrows [from, to] to where low <= start + s slope <= high (Liang and Barsky 1984). */
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

rigcal_status rigcal_epiline_clip(rigcal_real ends[4], const rigcal_real line_px[3],
                                  int32_t width, int32_t height)
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
    /* (u, v) is the foot of the perpendicular from the image's centre. The line is followed
     * from there. */
    const rigcal_real cu = (right - RC(0.5)) / 2, cv = (bottom - RC(0.5)) / 2;
    const rigcal_real distance = alpha * cu + beta * cv + line_px[2];
    const rigcal_real u = cu - distance * alpha, v = cv - distance * beta;
    rigcal_real from = -RC_MAX, to = RC_MAX;
    clip_interval(&from, &to, u, beta, RC(-0.5), right);
    clip_interval(&from, &to, v, -alpha, RC(-0.5), bottom);
    if (!(from < to)) {
        return RIGCAL_ERR_OUTSIDE;
    }
    /* Rounding may put an end just beyond the border. */
    ends[0] = within(u + from * beta, RC(-0.5), right);
    ends[1] = within(v - from * alpha, RC(-0.5), bottom);
    ends[2] = within(u + to * beta, RC(-0.5), right);
    ends[3] = within(v - to * alpha, RC(-0.5), bottom);
    return RIGCAL_OK;
}

static rigcal_status check_depth_range(const rigcal_camera *camera_b, rigcal_real near_a,
                                       rigcal_real far_a)
{
    const rigcal_status status = rc_check_camera(camera_b);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!rc_is_finite(near_a) || !rc_is_finite(far_a)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    return (near_a > 0 && far_a > near_a && far_a <= RC_COORDINATE_MAX) ? RIGCAL_OK
                                                                        : RIGCAL_ERR_RANGE;
}

/* The point at a depth along ray_a, in the frame of b. */
static void point_at_depth(rigcal_real X_b[3], const rigcal_transform *b_from_a,
                           const rigcal_real ray_a[3], rigcal_real depth)
{
    const rigcal_real X_a[3] = {depth * ray_a[0], depth * ray_a[1], depth * ray_a[2]};
    rc_transform_point(X_b, b_from_a, X_a);
}

rigcal_status rigcal_epiline_segment(rigcal_real ends[4], const rigcal_camera *camera_b,
                                     const rigcal_transform *b_from_a,
                                     const rigcal_real ray_a[3], rigcal_real near_a,
                                     rigcal_real far_a)
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
        if (!(X_b[2] > RC_FORWARD_LEAST * rc_vec3_max_abs(X_b))) {
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

rigcal_status rigcal_epiline_curve(rigcal_real uv_b[], size_t capacity, size_t *n_written,
                                   const rigcal_camera *camera_b,
                                   const rigcal_transform *b_from_a,
                                   const rigcal_real ray_a[3], rigcal_real near_a,
                                   rigcal_real far_a)
{
    if (n_written == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = check_epiline(uv_b, b_from_a, ray_a);
    if (status == RIGCAL_OK) {
        status = check_depth_range(camera_b, near_a, far_a);
    }
    if (status == RIGCAL_OK && (capacity < 2 || capacity > RC_COUNT_MAX)) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    size_t written = 0;
    for (size_t i = 0; i < capacity; i++) {
        /* 1 / depth goes from 1 / near to 1 / far in even steps. Near / far may
         * underflow. */
        const rigcal_real s = (rigcal_real)i / (rigcal_real)(capacity - 1);
        const rigcal_real depth =
            (i + 1 < capacity) ? near_a / ((1 - s) + s * (near_a / far_a)) : far_a;
        rigcal_real X_b[3];
        point_at_depth(X_b, b_from_a, ray_a, depth);
        if (rc_project_usable(&uv_b[2 * written], camera_b, X_b) == RIGCAL_OK) {
            written++;
        }
    }
    if (written == 0) {
        return RIGCAL_ERR_OUTSIDE;
    }
    *n_written = written;
    return RIGCAL_OK;
}
