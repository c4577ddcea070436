#include "rc_camera.h"

/* ---- constants ----------------------------------------------------------- */

/* px: a shorter focal length is a mistake, and would vanish in products. */
#define FOCAL_MIN RC(1e-6)

/* px: focal length of a usual camera. If the unit of uv cannot be a pixel, errors assumed
 * in pixels are those of such a camera. */
#define FOCAL_USUAL RC(800)

/* px: a ray is an answer if its projection is no farther from the pixel than this and
 * rounding. Newton's method itself goes on until rounding. */
#define MISS_MAX_PX RC_TOL(5e-10, 1e-3)

/* part of the largest pixel: rounding adds this to MISS_MAX_PX. */
#define MISS_ROUNDING (4 * RC_EPS)

/* terms: the length of the series of the sine and the cosine. At pi the next one is below
 * 1e-16. */
enum { RAY_TERMS = 14 };

/* terms: the length of the series of the arc tangent, up to an eighth of a turn. The next
 * one is below rounding. */
enum { ANGLE_TERMS = RIGCAL_USE_FLOAT ? 10 : 22 };

/* ---- checks -------------------------------------------------------------- */

/* A camera's real numbers, fx to k6, in their order. */
enum { P1 = 6, K5 = 10, NUMBERS = 12 };

rigcal_status rc_check_camera(const rigcal_camera *camera)
{
    const rigcal_camera *const c = camera;
    if (c == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_real *const numbers = rc_camera_numbers(c, offsetof(rigcal_camera, fx));
    const rigcal_status status = rc_check_numbers(numbers, NUMBERS, RC_PIXEL_MAX);
    if (status == RIGCAL_ERR_NOT_FINITE) {
        return status;
    }
    /* As unsigned numbers, 0 and negative ones are large. */
    const int size_ok =
        (uint32_t)c->width - 1 < RC_IMAGE_MAX && (uint32_t)c->height - 1 < RC_IMAGE_MAX;
    const int numbers_ok = status == RIGCAL_OK && rc_min(c->fx, c->fy) >= FOCAL_MIN;
    const int lens_ok = c->lens == RIGCAL_LENS_BROWN ||
                        (rc_lens_is_fisheye(c) && rc_all_within(&numbers[P1], 2, 0) &&
                         rc_all_within(&numbers[K5], 2, 0));
    return (size_ok && numbers_ok && lens_ok) ? RIGCAL_OK : RIGCAL_ERR_CAMERA;
}

rigcal_status rc_check_pixel(const rigcal_real uv[2])
{
    return rc_check_numbers(uv, 2, RC_PIXEL_MAX);
}

rigcal_status rc_check_observation(const rigcal_observation *o)
{
    const rigcal_status status = rc_check_point(o->X_w);
    const rigcal_status uv_status = rc_check_pixel(o->uv);
    return (status == RIGCAL_OK || uv_status == RIGCAL_ERR_NOT_FINITE) ? uv_status : status;
}

static rigcal_status check_camera_pixel(const rigcal_real out[],
                                        const rigcal_camera *camera,
                                        const rigcal_real uv[2])
{
    if (out == NULL || uv == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = rc_check_camera(camera);
    return (status == RIGCAL_OK) ? rc_check_pixel(uv) : status;
}

void rc_write_fault(int32_t *at_fault, int32_t index)
{
    if (at_fault != NULL) {
        *at_fault = index;
    }
}

/* Normalised images have a focal length of 1, real ones have hundreds of pixels. */
rigcal_real rc_pixel_size(const rigcal_camera *camera)
{
    RIGCAL_ASSERT(camera->fx > 0);
    return rc_min(1, camera->fx * camera->fx / FOCAL_USUAL);
}

/* ---- from a pixel to a ray ----------------------------------------------- */

/* The ray at x, theta = |x| < pi off the axis: (sin theta / theta x, cos theta), by their
 * series in theta^2. The C library's functions would need 3 KB of flash, because they
 * reduce large angles. */
RC_APART_FAST static rigcal_status fisheye_ray(rigcal_real ray[3], const rigcal_real x[2])
{
    const rigcal_real theta2 = x[0] * x[0] + x[1] * x[1];
    rigcal_real sinc = 1, cosine = 1;
    if (!(theta2 < RC_PI * RC_PI)) {
        return RIGCAL_ERR_NO_RAY;
    }
    for (int k = 2 * RAY_TERMS; k > 0; k -= 2) {
        sinc = 1 - theta2 / (rigcal_real)(k * (k + 1)) * sinc;
        cosine = 1 - theta2 / (rigcal_real)(k * (k - 1)) * cosine;
    }
    ray[0] = sinc * x[0];
    ray[1] = sinc * x[1];
    ray[2] = cosine;
    return RIGCAL_OK;
}

/* How far a ray's projection may be from its pixel, at focal length 1. A ray that is found
 * is as good as rounding allows, so the smaller focal length serves: if the other is much
 * larger, rounding alone is more than a part of a pixel. */
RC_APART_FAST static rigcal_real tolerance_at(const rigcal_camera *c,
                                              const rigcal_real uv[2])
{
    const rigcal_real pixels[3] = {uv[0], uv[1], c->cx};
    const rigcal_real largest = rc_max(rc_vec3_max_abs(pixels), RC_FABS(c->cy));
    return (MISS_MAX_PX + MISS_ROUNDING * largest) / rc_min(c->fx, c->fy);
}

rigcal_status rc_pixel_to_ray(rigcal_real ray[3], const rigcal_camera *camera,
                              const rigcal_real uv[2])
{
    RIGCAL_ASSERT(rc_check_camera(camera) == RIGCAL_OK && rc_all_finite(uv, 2));
    const rigcal_camera *const c = camera;
    const rigcal_real target[2] = {(uv[0] - c->cx) / c->fx, (uv[1] - c->cy) / c->fy};
    rigcal_real m[3] = {target[0], target[1], 1};
    if (!rc_lens_is_pinhole(c) && !rc_lens_invert(m, c, target, tolerance_at(c, uv))) {
        return RIGCAL_ERR_NO_RAY;
    }
    if (rc_lens_is_fisheye(c)) {
        return fisheye_ray(ray, m);
    }
    (void)rc_vec3_unit(ray, m); /* m[2] is 1 */
    return RIGCAL_OK;
}

/* ---- from a point to a pixel --------------------------------------------- */

/* The angle of (r, Z) off the Z axis, r >= 0. The angle for |Z| is halved twice, to at most
 * an eighth of a turn, where the series of the arc tangent is short. atan2 would cost
 * 0.8 KB. */
static rigcal_real angle_off_axis(rigcal_real r, rigcal_real Z)
{
    rigcal_real t = r / (RC_FABS(Z) + RC_SQRT(r * r + Z * Z)), sum = 0;
    t /= 1 + RC_SQRT(1 + t * t);
    for (int k = 2 * ANGLE_TERMS - 1; k > 0; k -= 2) {
        sum = 1 / (rigcal_real)k - t * t * sum;
    }
    return (Z < 0) ? RC_PI - 4 * t * sum : 4 * t * sum;
}

/* A lens maps the plane point x = (X, Y) / depth. Brown's depth is Z, the fisheye's is
 * r / theta. *bend = d(1 / depth)/dr / r, *sink = d(1 / depth)/dZ. */
static rigcal_status plane_depth(rigcal_real *depth, rigcal_real *bend, rigcal_real *sink,
                                 int is_fisheye, const rigcal_real X_c[3])
{
    const rigcal_real Z = X_c[2];
    const rigcal_real rr = X_c[0] * X_c[0] + X_c[1] * X_c[1];
    if (RIGCAL_WITH_FISHEYE && is_fisheye && rr > RC_EPS * RC_EPS) {
        const rigcal_real r = RC_SQRT(rr), by_rho2 = 1 / (rr + Z * Z);
        *depth = r / angle_off_axis(r, Z);
        *bend = (Z * by_rho2 - 1 / *depth) / rr;
        *sink = -by_rho2;
        return RIGCAL_OK;
    }
    if (!(Z > 0)) { /* a fisheye images nothing straight behind it */
        return is_fisheye ? RIGCAL_ERR_NO_RAY : RIGCAL_ERR_BEHIND;
    }
    *depth = Z;
    *bend = 0;
    *sink = -1 / (Z * Z);
    return RIGCAL_OK;
}

/* The common case, a lens without distortion, costs nothing but the division. */
static rigcal_status project_pinhole(rigcal_real uv[2], rigcal_real J_uv[6],
                                     const rigcal_camera *camera, const rigcal_real X_c[3])
{
    if (!(X_c[2] > 0)) {
        return RIGCAL_ERR_BEHIND;
    }
    const rigcal_real by_Z = 1 / X_c[2];
    const rigcal_real x = X_c[0] * by_Z, y = X_c[1] * by_Z;
    uv[0] = camera->fx * x + camera->cx;
    uv[1] = camera->fy * y + camera->cy;
    J_uv[0] = camera->fx * by_Z;
    J_uv[1] = 0;
    J_uv[2] = -J_uv[0] * x;
    J_uv[3] = 0;
    J_uv[4] = camera->fy * by_Z;
    J_uv[5] = -J_uv[4] * y;
    return RIGCAL_OK;
}

/* Scales X_c first, so that its largest coordinate is 1 and nothing overflows on the way.
 * With the lens's Jacobian J and (X, Y) = j,
 * J dx/dX_c = (J / depth + bend J j j^T, sink J j). */
rigcal_status rc_project_by(rigcal_real x[2], rigcal_real uv[2], rigcal_real J_uv[6],
                            const rigcal_camera *camera, const rigcal_real X_c[3])
{
    const rigcal_real largest = rc_vec3_max_abs(X_c);
    rigcal_real depth, bend, sink, F[2], J[3];
    if (!(largest > 0)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    const rigcal_real scaled[3] = {X_c[0] / largest, X_c[1] / largest, X_c[2] / largest};
    const rigcal_status status =
        plane_depth(&depth, &bend, &sink, rc_lens_is_fisheye(camera), scaled);
    if (status != RIGCAL_OK) {
        return status;
    }
    x[0] = scaled[0] / depth;
    x[1] = scaled[1] / depth;
    /* With a focal length of RC_PIXEL_MAX the pixel is still finite. */
    if (!rc_lens_map(F, J, camera, x) || !rc_all_within(F, 2, RC_MAX / RC_PIXEL_MAX / 2)) {
        return RIGCAL_ERR_NO_RAY;
    }
    const rigcal_real focal[2] = {camera->fx, camera->fy};
    uv[0] = focal[0] * F[0] + camera->cx;
    uv[1] = focal[1] * F[1] + camera->cy;
    for (int row = 0; row < 2; row++) {
        const rigcal_real j[3] = {J[row], J[row + 1], 0}; /* (xx, xy), then (xy, yy) */
        const rigcal_real f = focal[row] / largest;
        const rigcal_real along = f * (j[0] * scaled[0] + j[1] * scaled[1]);
        rc_vec3_combine(&J_uv[3 * row], f / depth, j, bend * along, scaled);
        J_uv[3 * row + 2] = sink * along;
    }
    return RIGCAL_OK;
}

rigcal_status rc_project_through(rigcal_real uv[2], rigcal_real J_uv[6],
                                 const rigcal_camera *camera, int is_pinhole,
                                 const rigcal_real X_c[3])
{
    RIGCAL_ASSERT(is_pinhole == rc_lens_is_pinhole(camera));
    rigcal_real x[2];
    return is_pinhole ? project_pinhole(uv, J_uv, camera, X_c)
                      : rc_project_by(x, uv, J_uv, camera, X_c);
}

/* Computes the pixel, and proves that the lens sees the point there. */
rigcal_status rc_project_usable(rigcal_real uv[2], const rigcal_camera *camera,
                                const rigcal_real X_c[3])
{
    RIGCAL_ASSERT(rc_check_camera(camera) == RIGCAL_OK);
    rigcal_real x[2], pixel[2], J_uv[6];
    const rigcal_status status = rc_project_by(x, pixel, J_uv, camera, X_c);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!rc_lens_is_usable(camera, x)) {
        return RIGCAL_ERR_NO_RAY;
    }
    uv[0] = pixel[0];
    uv[1] = pixel[1];
    return RIGCAL_OK;
}

/* ---- public -------------------------------------------------------------- */

rigcal_status rigcal_camera_check(const rigcal_camera *camera)
{
    return rc_check_camera(camera);
}

rigcal_status rigcal_camera_project(rigcal_real uv[2], const rigcal_camera *camera,
                                    const rigcal_real X_c[3])
{
    if (uv == NULL || camera == NULL || X_c == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = rc_check_camera(camera);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!rc_all_finite(X_c, 3)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    return rc_project_usable(uv, camera, X_c);
}

rigcal_status rigcal_camera_ray(rigcal_real ray[3], const rigcal_camera *camera,
                                const rigcal_real uv[2])
{
    const rigcal_status status = check_camera_pixel(ray, camera, uv);
    return (status == RIGCAL_OK) ? rc_pixel_to_ray(ray, camera, uv) : status;
}

rigcal_status rigcal_camera_undistort(rigcal_real uv_straight[2],
                                      const rigcal_camera *camera, const rigcal_real uv[2])
{
    rigcal_real ray[3];
    rigcal_status status = check_camera_pixel(uv_straight, camera, uv);
    if (status == RIGCAL_OK) {
        status = rc_pixel_to_ray(ray, camera, uv);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!(ray[2] > RC_FORWARD_LEAST)) {
        return RIGCAL_ERR_WIDE_RAY;
    }
    uv_straight[0] = camera->fx * (ray[0] / ray[2]) + camera->cx;
    uv_straight[1] = camera->fy * (ray[1] / ray[2]) + camera->cy;
    return RIGCAL_OK;
}

rigcal_status rigcal_camera_distort(rigcal_real uv[2], const rigcal_camera *camera,
                                    const rigcal_real uv_straight[2])
{
    const rigcal_status status = check_camera_pixel(uv, camera, uv_straight);
    if (status != RIGCAL_OK) {
        return status;
    }
    const rigcal_real m[3] = {(uv_straight[0] - camera->cx) / camera->fx,
                              (uv_straight[1] - camera->cy) / camera->fy, 1};
    return rc_project_usable(uv, camera, m);
}

rigcal_status rigcal_view_rms(rigcal_real *rms_px, int32_t *worst, const rigcal_view *view,
                              const rigcal_transform *cam_from_world)
{
    if (rms_px == NULL || view == NULL || view->observations == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_observation *const o = view->observations;
    rigcal_status status = rc_check_camera(view->camera);
    if (status == RIGCAL_OK) {
        status = rc_check_transform(cam_from_world);
    }
    if (status == RIGCAL_OK && (view->n < 1 || view->n > RC_COUNT_MAX)) {
        status = (view->n < 1) ? RIGCAL_ERR_TOO_FEW : RIGCAL_ERR_RANGE;
    }
    rigcal_real sum = 0, largest = -1;
    size_t largest_at = 0;
    for (size_t i = 0; i < view->n && status == RIGCAL_OK; i++) {
        rigcal_real X_c[3], uv[2];
        status = rc_check_observation(&o[i]);
        if (status != RIGCAL_OK) {
            break;
        }
        rc_transform_point(X_c, cam_from_world, o[i].X_w);
        status = rc_project_usable(uv, view->camera, X_c);
        if (status != RIGCAL_OK) {
            break;
        }
        const rigcal_real du = uv[0] - o[i].uv[0], dv = uv[1] - o[i].uv[1];
        const rigcal_real squared = du * du + dv * dv;
        sum += squared;
        if (squared > largest) {
            largest = squared;
            largest_at = i;
        }
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!rc_is_finite(sum)) {
        return RIGCAL_ERR_NO_RAY;
    }
    *rms_px = RC_SQRT(sum / (rigcal_real)view->n);
    if (worst != NULL) {
        *worst = (int32_t)largest_at;
    }
    return RIGCAL_OK;
}
