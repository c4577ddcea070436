#include "rc_camera.h"

#include <string.h>

/* A shorter focal length is a mistake, and would vanish in products. */
#define FOCAL_MIN RC(1e-6)

/* ---- checks -------------------------------------------------------------- */

/* A camera's real numbers, fx to k6, in their order. */
enum { K1 = 4, P1 = 6, K5 = 10, NUMBERS = 12 };

static void copy_numbers(rigcal_real out[NUMBERS], const rigcal_camera *camera)
{
    memcpy(out, (const char *)camera + offsetof(rigcal_camera, fx),
           NUMBERS * sizeof *out);
}

rigcal_status rc_check_camera(const rigcal_camera *camera)
{
    const rigcal_camera *const c = camera;
    rigcal_real numbers[NUMBERS];
    if (c == NULL) {
        return RIGCAL_ERR_NULL;
    }
    copy_numbers(numbers, c);
    if (!rc_all_finite(numbers, NUMBERS)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    /* As unsigned, 0 and the negative are large. */
    const int size_ok = (uint32_t)c->width - 1 < RC_IMAGE_MAX &&
                        (uint32_t)c->height - 1 < RC_IMAGE_MAX;
    const int numbers_ok = rc_min(c->fx, c->fy) >= FOCAL_MIN &&
                           rc_all_within(numbers, NUMBERS, RC_PIXEL_MAX);
    const int lens_ok =
        c->lens == RIGCAL_LENS_BROWN ||
        (RIGCAL_WITH_FISHEYE && c->lens == RIGCAL_LENS_FISHEYE &&
         rc_all_within(&numbers[P1], 2, 0) &&
         rc_all_within(&numbers[K5], 2, 0));
    return (size_ok && numbers_ok && lens_ok && c->reserved == 0)
               ? RIGCAL_OK
               : RIGCAL_ERR_CAMERA;
}

rigcal_status rc_check_pixel(const rigcal_real uv[2])
{
    return rc_check_numbers(uv, 2, RC_PIXEL_MAX);
}

rigcal_status rc_check_observation(const rigcal_observation *o)
{
    const rigcal_status status = rc_check_point(o->X_w);
    const rigcal_status uv_status = rc_check_pixel(o->uv);
    return (status == RIGCAL_OK || uv_status == RIGCAL_ERR_NOT_FINITE)
               ? uv_status
               : status;
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

/* Normalised images have a focal length of 1, real ones of hundreds of pixels. */
rigcal_real rc_pixel_size(const rigcal_camera *camera)
{
    return rc_min(1, camera->fx * camera->fx / 800);
}

/* ---- the lens map -------------------------------------------------------- */

void rc_lens_of(rigcal_lens *lens, const rigcal_camera *camera)
{
    const rigcal_camera *const c = camera;
    const int is_fisheye =
        RIGCAL_WITH_FISHEYE && c->lens == RIGCAL_LENS_FISHEYE;
    rigcal_real numbers[NUMBERS];
    copy_numbers(numbers, c);
    lens->is_fisheye = is_fisheye;
    lens->is_pinhole =
        !is_fisheye && rc_all_within(&numbers[K1], NUMBERS - K1, 0);
    lens->N[0] = lens->D[0] = 1;
    lens->N[1] = c->k1;
    lens->N[2] = c->k2;
    lens->N[3] = c->k3;
    lens->N[4] = is_fisheye ? c->k4 : 0;
    lens->D[1] = is_fisheye ? 0 : c->k4;
    lens->D[2] = c->k5;
    lens->D[3] = c->k6;
    lens->q[0] = c->p2;
    lens->q[1] = c->p1;
}

/* Value and derivative of a polynomial of ascending powers. */
static rigcal_real polynomial(rigcal_real *derivative, const rigcal_real c[],
                              int degree, rigcal_real s)
{
    rigcal_real value = c[degree], slope = 0;
    for (int i = degree - 1; i >= 0; i--) {
        slope = slope * s + value;
        value = value * s + c[i];
    }
    *derivative = slope;
    return value;
}

/* With d = N / D, d' = (N' - d D') / D and p = d' x + 2 q:
 *   J = (d + 2 q.x) I + p x^T + x p^T */
int rc_lens_map(rigcal_real F[2], rigcal_real J[3], const rigcal_lens *lens,
                const rigcal_real x[2])
{
    const rigcal_real *const q = lens->q;
    const rigcal_real s = x[0] * x[0] + x[1] * x[1];
    rigcal_real dN, dD;
    const rigcal_real N = polynomial(&dN, lens->N, 4, s);
    const rigcal_real D = polynomial(&dD, lens->D, 3, s);
    if (!(D > 0)) {
        return 0;
    }
    const rigcal_real d = N / D, slope = (dN - d * dD) / D;
    const rigcal_real scale = d + 2 * (q[0] * x[0] + q[1] * x[1]);
    const rigcal_real p[2] = {slope * x[0] + 2 * q[0], slope * x[1] + 2 * q[1]};

    F[0] = scale * x[0] + q[0] * s;
    F[1] = scale * x[1] + q[1] * s;
    J[0] = scale + 2 * p[0] * x[0];
    J[1] = p[0] * x[1] + p[1] * x[0];
    J[2] = scale + 2 * p[1] * x[1];
    return 1;
}

static int is_positive_definite(const rigcal_real J[3])
{
    return J[0] + J[2] > 0 && J[0] * J[2] - J[1] * J[1] > 0;
}

/* ---- the usable part of the lens ----------------------------------------- */

enum { SLOPE_DEGREE = 6, WALK_MAX = 1024 };

/* Lower and upper bound of a polynomial within `half` of `middle`: the other terms of
 * its series there take from the first, and add to it, no more than their absolute
 * values. Their distance from the true range shrinks as half^2. */
static void polynomial_range(rigcal_real range[2], const rigcal_real c[],
                             int degree, rigcal_real middle, rigcal_real half)
{
    rigcal_real b[SLOPE_DEGREE + 1], power = half, reach = 0;
    memcpy(b, c, (size_t)(degree + 1) * sizeof *b);
    for (int i = 0; i <= degree; i++) { /* powers of s - middle: b[i] is done */
        for (int j = degree - 1; j >= i; j--) {
            b[j] += middle * b[j + 1];
        }
        if (i > 0) {
            reach += power * RC_FABS(b[i]);
            power *= half;
        }
    }
    range[0] = b[0] - reach;
    range[1] = b[0] + reach;
}

/* Numerator of d/dr (r N / D) over D^2: (N + 2 s N') D - 2 s N D'. */
static void radial_slope(rigcal_real G[SLOPE_DEGREE + 1],
                         const rigcal_lens *lens)
{
    for (int i = 0; i <= SLOPE_DEGREE; i++) {
        G[i] = 0;
    }
    for (int i = 0; i < 5; i++) {
        for (int j = 0; j < 4 && i + j <= SLOPE_DEGREE; j++) {
            G[i + j] +=
                lens->N[i] * lens->D[j] * (rigcal_real)(1 + 2 * (i - j));
        }
    }
}

/* The least of N / D, of which N is no less than `low`, D > 0 between its bounds. */
RC_APART static rigcal_real least_quotient(rigcal_real low,
                                           const rigcal_real D[2])
{
    return low / ((low > 0) ? D[1] : D[0]);
}

/* Along the direction e, at x = r e, let c = q.e and n = q.e', e' normal to e.
 * In the basis (e, e') the Jacobian is
 *
 *     [ g' + 6 c r     2 n r   ]       g' = G / D^2,  d = N / D
 *     [   2 n r       d + 2 c r]
 *
 * It is positive definite on all of r^2 in [a, a + h] when the bounds of G, N and
 * D there make it so. c r and n r are given where r^2 is `end`. */
static int is_usable_between(const rigcal_lens *lens,
                             const rigcal_real G[SLOPE_DEGREE + 1],
                             rigcal_real c, rigcal_real n, rigcal_real end,
                             rigcal_real a, rigcal_real h)
{
    const rigcal_real half = h / 2, middle = a + half;
    rigcal_real slope[2], N[2], D[2];
    polynomial_range(D, lens->D, 3, middle, half);
    polynomial_range(slope, G, SLOPE_DEGREE, middle, half);
    if (!(D[0] > 0)) {
        return 0;
    }
    if (!(RC_FABS(c) > 0 || RC_FABS(n) > 0)) {
        return slope[0] > 0; /* then d > 0 too: g rises from 0 */
    }
    polynomial_range(N, lens->N, 4, middle, half);
    const rigcal_real far = (a + h) / end;
    const rigcal_real c_low = c * RC_SQRT((c > 0) ? a / end : far);
    const rigcal_real along =
        least_quotient(least_quotient(slope[0], D), D) + 6 * c_low;
    const rigcal_real across = least_quotient(N[0], D) + 2 * c_low;
    return along > 0 && across > 0 && along * across > 4 * n * n * far;
}

static int is_definite_at(const rigcal_lens *lens, const rigcal_real x[2],
                          rigcal_real part)
{
    const rigcal_real at[2] = {part * x[0], part * x[1]};
    rigcal_real F[2], J[3];
    return rc_lens_map(F, J, lens, at) && is_positive_definite(J);
}

/* Walks from the axis to x in steps that are halved until the bounds decide, or their
 * end is seen to be beyond a turning point, and doubled after each success. */
int rc_lens_is_usable(const rigcal_lens *lens, const rigcal_real x[2])
{
    rigcal_real G[SLOPE_DEGREE + 1];
    const rigcal_real end = x[0] * x[0] + x[1] * x[1];
    const rigcal_real c = lens->q[0] * x[0] + lens->q[1] * x[1];
    const rigcal_real n = lens->q[1] * x[0] - lens->q[0] * x[1];
    rigcal_real a = 0, h = end;
    if (lens->is_pinhole) {
        return rc_is_finite(end);
    }
    radial_slope(G, lens);
    for (int i = 0; i < WALK_MAX && h > RC_EPS * end; i++) {
        if (is_usable_between(lens, G, c, n, end, a, h)) {
            a += h;
            h = rc_min(2 * h, end - a);
        } else if (is_definite_at(lens, x, RC_SQRT((a + h) / end))) {
            h /= 2;
        } else {
            return 0;
        }
    }
    return rc_is_finite(end) && end - a <= 4 * RC_EPS * end;
}

/* ---- from a pixel to a ray ----------------------------------------------- */

enum { NEWTON_MAX = 60, STAGES_MAX = 64 };

/* How far from the pixel a ray's projection may be, besides rounding [px]. Newton
 * goes on to rounding; this only tells an answer from none. */
#define MISS_MAX_PX RC_TOL(5e-10, 1e-3)

/* Newton's method for F(x) = target from x, a place where J is positive definite.
 * A step that leaves such places, or does not bring F nearer, is halved. Ends
 * where no step helps any more and returns |F(x) - target| there. */
RC_APART static rigcal_real solve_from(rigcal_real x[2],
                                       const rigcal_lens *lens,
                                       const rigcal_real target[2])
{
    rigcal_real F[2], J[3], step[2] = {0, 0}, miss = RC_MAX;
    rigcal_real at[2] = {x[0], x[1]};

    for (int i = 0; i < NEWTON_MAX; i++) {
        rigcal_real gap[2] = {0, 0}, next = RC_MAX;
        if (rc_lens_map(F, J, lens, at) && is_positive_definite(J)) {
            gap[0] = target[0] - F[0];
            gap[1] = target[1] - F[1];
            next = RC_SQRT(gap[0] * gap[0] + gap[1] * gap[1]);
        }
        if (next < miss) {
            const rigcal_real det = J[0] * J[2] - J[1] * J[1];
            miss = next;
            x[0] = at[0];
            x[1] = at[1];
            step[0] = (J[2] * gap[0] - J[1] * gap[1]) / det;
            step[1] = (J[0] * gap[1] - J[1] * gap[0]) / det;
        } else {
            step[0] /= 2;
            step[1] /= 2;
        }
        at[0] = x[0] + step[0];
        at[1] = x[1] + step[1];
        if (!(RC_FABS(at[0] - x[0]) > 0 || RC_FABS(at[1] - x[1]) > 0)) {
            break;
        }
    }
    return miss;
}

/* x with F(x) = target, on the part of the plane that does not fold. The answer
 * is followed from the axis in `stages` equal parts of the target: one nearly
 * always serves; more keep a strongly curved lens from being jumped across. */
static int invert_lens(rigcal_real x[2], const rigcal_lens *lens,
                       const rigcal_real target[2], rigcal_real tolerance)
{
    for (int stages = 1; stages <= STAGES_MAX; stages *= 2) {
        rigcal_real miss = 0;
        x[0] = x[1] = 0;
        for (int i = 1; i <= stages && miss <= tolerance; i++) {
            const rigcal_real part = (rigcal_real)i / (rigcal_real)stages;
            const rigcal_real aim[2] = {part * target[0], part * target[1]};
            miss = solve_from(x, lens, aim);
        }
        if (miss <= tolerance && rc_lens_is_usable(lens, x)) {
            return 1;
        }
    }
    return 0;
}

/* The ray at x, theta = |x| < pi off the axis: (sin theta / theta x, cos theta) by their
 * series in theta^2. The C library's would bring along its reduction of large angles,
 * 3 KB of flash. */
static rigcal_status fisheye_ray(rigcal_real ray[3], const rigcal_real x[2])
{
    enum { TERMS = 14 }; /* at pi the next is below 1e-16 */
    const rigcal_real theta2 = x[0] * x[0] + x[1] * x[1];
    rigcal_real sinc = 1, cosine = 1;
    if (!(theta2 < RC_PI * RC_PI)) {
        return RIGCAL_ERR_NO_RAY;
    }
    for (int k = 2 * TERMS; k > 0; k -= 2) {
        sinc = 1 - theta2 / (rigcal_real)(k * (k + 1)) * sinc;
        cosine = 1 - theta2 / (rigcal_real)(k * (k - 1)) * cosine;
    }
    ray[0] = sinc * x[0];
    ray[1] = sinc * x[1];
    ray[2] = cosine;
    return RIGCAL_OK;
}

rigcal_status rc_pixel_to_ray(rigcal_real ray[3], const rigcal_camera *camera,
                              const rigcal_real uv[2])
{
    const rigcal_camera *const c = camera;
    const rigcal_real target[2] = {(uv[0] - c->cx) / c->fx,
                                   (uv[1] - c->cy) / c->fy};
    const rigcal_real pixels[3] = {uv[0], uv[1], c->cx};
    const rigcal_real largest = rc_max(rc_vec3_max_abs(pixels), RC_FABS(c->cy));
    const rigcal_real tolerance =
        (MISS_MAX_PX + 4 * RC_EPS * largest) / rc_max(c->fx, c->fy);
    rigcal_real x[2] = {target[0], target[1]};
    rigcal_lens lens;

    rc_lens_of(&lens, camera);
    if (!lens.is_pinhole && !invert_lens(x, &lens, target, tolerance)) {
        return RIGCAL_ERR_NO_RAY;
    }
    if (RIGCAL_WITH_FISHEYE && lens.is_fisheye) {
        return fisheye_ray(ray, x);
    }
    const rigcal_real m[3] = {x[0], x[1], 1};
    return rc_vec3_unit(ray, m) ? RIGCAL_OK : RIGCAL_ERR_NO_RAY;
}

/* ---- from a point to a pixel --------------------------------------------- */

/* Angle of (r, Z) off the Z axis, r >= 0: that of |Z| is halved twice, to an eighth of
 * a turn at most, whose tangent's series is short. atan2 would bring 0.8 KB along. */
static rigcal_real angle_off_axis(rigcal_real r, rigcal_real Z)
{
    /* The next term is below rounding. */
    enum { TERMS = RIGCAL_USE_FLOAT ? 10 : 22 };
    rigcal_real t = r / (RC_FABS(Z) + RC_SQRT(r * r + Z * Z)), sum = 0;
    t /= 1 + RC_SQRT(1 + t * t);
    for (int k = 2 * TERMS - 1; k > 0; k -= 2) {
        sum = 1 / (rigcal_real)k - t * t * sum;
    }
    return (Z < 0) ? RC_PI - 4 * t * sum : 4 * t * sum;
}

/* A lens maps the plane point x = (X, Y) / depth. Brown: depth = Z. Fisheye: r / theta.
 * *bend = d(1 / depth)/dr / r, *sink = d(1 / depth)/dZ. */
static rigcal_status plane_depth(rigcal_real *depth, rigcal_real *bend,
                                 rigcal_real *sink, int is_fisheye,
                                 const rigcal_real X_c[3])
{
    const rigcal_real Z = X_c[2];
    const rigcal_real rr = X_c[0] * X_c[0] + X_c[1] * X_c[1];
    if (RIGCAL_WITH_FISHEYE && is_fisheye && rr > 0) {
        const rigcal_real r = RC_SQRT(rr), by_rho2 = 1 / (rr + Z * Z);
        *depth = r / angle_off_axis(r, Z);
        *bend = (Z * by_rho2 - 1 / *depth) / rr;
        *sink = -by_rho2;
        return RIGCAL_OK;
    }
    if (!(Z > 0)) { /* straight behind a fisheye is no direction in its image */
        return is_fisheye ? RIGCAL_ERR_NO_RAY : RIGCAL_ERR_BEHIND;
    }
    *depth = Z;
    *bend = 0;
    *sink = -1 / (Z * Z);
    return RIGCAL_OK;
}

/* The common case, a lens without distortion, costs nothing but the division. */
static rigcal_status project_pinhole(rigcal_real uv[2], rigcal_real J_uv[6],
                                     const rigcal_camera *camera,
                                     const rigcal_real X_c[3])
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

/* Through any lens. Also gives the place x in the plane of the lens map. X_c is scaled
 * first, so that its largest coordinate is 1: then nothing overflows on the way. With
 * the lens's Jacobian J and (X, Y) = j, J dx/dX_c = (J / depth + bend J j j^T, sink J j). */
static rigcal_status project_by(rigcal_real x[2], rigcal_real uv[2],
                                rigcal_real J_uv[6], const rigcal_lens *lens,
                                const rigcal_camera *camera,
                                const rigcal_real X_c[3])
{
    const rigcal_real largest = rc_vec3_max_abs(X_c);
    rigcal_real depth, bend, sink, F[2], J[3];
    if (!(largest > 0)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    const rigcal_real scaled[3] = {X_c[0] / largest, X_c[1] / largest,
                                   X_c[2] / largest};
    const rigcal_status status =
        plane_depth(&depth, &bend, &sink, lens->is_fisheye, scaled);
    if (status != RIGCAL_OK) {
        return status;
    }
    x[0] = scaled[0] / depth;
    x[1] = scaled[1] / depth;
    if (!rc_lens_map(F, J, lens, x) || !rc_all_finite(F, 2)) {
        return RIGCAL_ERR_NO_RAY;
    }
    const rigcal_real focal[2] = {camera->fx, camera->fy};
    uv[0] = focal[0] * F[0] + camera->cx;
    uv[1] = focal[1] * F[1] + camera->cy;
    for (int row = 0; row < 2; row++) {
        const rigcal_real *const j = &J[row]; /* (xx, xy), then (xy, yy) */
        const rigcal_real f = focal[row] / largest, by_depth = f / depth;
        const rigcal_real along = f * (j[0] * scaled[0] + j[1] * scaled[1]);
        J_uv[3 * row] = by_depth * j[0] + bend * along * scaled[0];
        J_uv[3 * row + 1] = by_depth * j[1] + bend * along * scaled[1];
        J_uv[3 * row + 2] = sink * along;
    }
    return RIGCAL_OK;
}

rigcal_status rc_project_through(rigcal_real uv[2], rigcal_real J_uv[6],
                                 const rigcal_lens *lens,
                                 const rigcal_camera *camera,
                                 const rigcal_real X_c[3])
{
    rigcal_real x[2];
    return lens->is_pinhole ? project_pinhole(uv, J_uv, camera, X_c)
                            : project_by(x, uv, J_uv, lens, camera, X_c);
}

/* The pixel, and the proof that the lens sees the point there. */
rigcal_status rc_project_usable(rigcal_real uv[2], const rigcal_camera *camera,
                                const rigcal_real X_c[3])
{
    rigcal_lens lens;
    rigcal_real x[2], pixel[2], J_uv[6];
    rc_lens_of(&lens, camera);
    const rigcal_status status = project_by(x, pixel, J_uv, &lens, camera, X_c);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!rc_lens_is_usable(&lens, x) || !rc_all_finite(pixel, 2)) {
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

rigcal_status rigcal_project(rigcal_real uv[2], const rigcal_camera *camera,
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

rigcal_status rigcal_pixel_to_ray(rigcal_real ray[3],
                                  const rigcal_camera *camera,
                                  const rigcal_real uv[2])
{
    const rigcal_status status = check_camera_pixel(ray, camera, uv);
    return (status == RIGCAL_OK) ? rc_pixel_to_ray(ray, camera, uv) : status;
}

rigcal_status rigcal_undistort_pixel(rigcal_real uv_straight[2],
                                     const rigcal_camera *camera,
                                     const rigcal_real uv[2])
{
    rigcal_real ray[3];
    rigcal_status status = check_camera_pixel(uv_straight, camera, uv);
    if (status == RIGCAL_OK) {
        status = rc_pixel_to_ray(ray, camera, uv);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!(ray[2] > RC_EPS)) {
        return RIGCAL_ERR_WIDE_RAY;
    }
    uv_straight[0] = camera->fx * (ray[0] / ray[2]) + camera->cx;
    uv_straight[1] = camera->fy * (ray[1] / ray[2]) + camera->cy;
    return RIGCAL_OK;
}

rigcal_status rigcal_distort_pixel(rigcal_real uv[2],
                                   const rigcal_camera *camera,
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

static rigcal_status check_count(size_t n)
{
    if (n < 1) {
        return RIGCAL_ERR_TOO_FEW;
    }
    return (n <= RC_COUNT_MAX) ? RIGCAL_OK : RIGCAL_ERR_RANGE;
}

void rc_write_fault(int32_t *bad, int32_t index)
{
    if (bad != NULL) {
        *bad = index;
    }
}

rigcal_status rigcal_sightings_from_observations(
    rigcal_sighting sightings[], int32_t *bad, const rigcal_camera *camera,
    const rigcal_observation observations[], size_t n)
{
    rigcal_real ray[3];
    rigcal_status status = RIGCAL_OK;
    if (sightings == NULL || observations == NULL) {
        status = RIGCAL_ERR_NULL;
    } else {
        status = rc_check_camera(camera);
    }
    if (status == RIGCAL_OK) {
        status = check_count(n);
    }
    rc_write_fault(bad, -1);
    if (status != RIGCAL_OK) {
        return status;
    }
    /* Twice through, so that nothing is written when anything is wrong. */
    for (size_t i = 0; i < n; i++) {
        status = rc_check_observation(&observations[i]);
        if (status == RIGCAL_OK) {
            status = rc_pixel_to_ray(ray, camera, observations[i].uv);
        }
        if (status != RIGCAL_OK) {
            rc_write_fault(bad, (int32_t)i);
            return status;
        }
    }
    for (size_t i = 0; i < n; i++) {
        (void)rc_pixel_to_ray(sightings[i].ray, camera, observations[i].uv);
        for (int j = 0; j < 3; j++) {
            sightings[i].X_w[j] = observations[i].X_w[j];
        }
    }
    return RIGCAL_OK;
}

rigcal_status rigcal_reprojection_rms(rigcal_real *rms_px, int32_t *worst,
                                      const rigcal_camera *camera,
                                      const rigcal_transform *cam_from_world,
                                      const rigcal_observation observations[],
                                      size_t n)
{
    if (rms_px == NULL || observations == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_camera(camera);
    if (status == RIGCAL_OK) {
        status = rc_check_transform(cam_from_world);
    }
    if (status == RIGCAL_OK) {
        status = check_count(n);
    }
    rigcal_real sum = 0, largest = -1;
    size_t largest_at = 0;
    for (size_t i = 0; i < n && status == RIGCAL_OK; i++) {
        rigcal_real X_c[3], uv[2];
        status = rc_check_observation(&observations[i]);
        if (status != RIGCAL_OK) {
            break;
        }
        rc_transform_point(X_c, cam_from_world, observations[i].X_w);
        status = rc_project_usable(uv, camera, X_c);
        if (status != RIGCAL_OK) {
            break;
        }
        const rigcal_real du = uv[0] - observations[i].uv[0];
        const rigcal_real dv = uv[1] - observations[i].uv[1];
        const rigcal_real squared = du * du + dv * dv;
        sum += squared;
        if (squared > largest) {
            largest = squared;
            largest_at = i;
        }
    }
    if (status == RIGCAL_OK && !rc_is_finite(sum)) {
        status = RIGCAL_ERR_NO_RAY;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    *rms_px = RC_SQRT(sum / (rigcal_real)n);
    if (worst != NULL) {
        *worst = (int32_t)largest_at;
    }
    return RIGCAL_OK;
}
