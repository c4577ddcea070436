#include "rc_band.h"
#include "rc_chance.h"
#include "rc_logs.h"

/* ---- constants ----------------------------------------------------------- */

/* 1: the least probability that may be asked for. Less is a mistake. */
#define PROBABILITY_MIN RC(0.001)

/* 1: the largest probability that may be asked for. Nearer to 1 float has no digits
 * left. */
#define PROBABILITY_MAX RC(0.999999)

/* px: the largest noise of a pixel. More is a mistake, and its square may overflow. */
#define NOISE_MOST RC(1e6)

/* 1: the most standard deviations. More are a mistake. */
#define K_MAX RC(100)

/* sine: at a smaller angle rays are parallel to rounding, or a ray points to the
 * epipole. */
#define PARALLEL_TOL (16 * RC_EPS)

/* squared standard deviations: within three of them of an epipole, the line has no
 * direction or the depth no sign. */
#define EPIPOLE_LIMIT2 RC(9)

/* px^2: limit of the squared width and distance. Beyond it m is 90 degrees off the line,
 * and the number means nothing. */
#define WIDTH2_MOST RC(1e24)

/* part of the area that a patch has in a pinhole's image: a lens that leaves less is about
 * to fold. The zone that is lost is some tenths of a pixel wide. */
#define SQUEEZED RC(0.02)

/* ---- how wide ------------------------------------------------------------ */

rigcal_status rigcal_match_k(rigcal_real *k, rigcal_real probability, int32_t purpose)
{
    if (k == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (!rc_is_finite(probability)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    if (!(probability >= PROBABILITY_MIN) || !(probability <= PROBABILITY_MAX) ||
        (purpose != RIGCAL_MATCH_SEARCH && purpose != RIGCAL_MATCH_DRAW)) {
        return RIGCAL_ERR_RANGE;
    }
    *k = (purpose == RIGCAL_MATCH_SEARCH) ? rc_normal_within(probability)
                                          : rc_plane_within(probability);
    return RIGCAL_OK;
}

/* ---- the ray of a pixel -------------------------------------------------- */

/* D = (b x m, m x a) / c, with J = (a; b), the rows of d uv / dm, both across m, and c = (a
 * x b).m. So J D = 1 and m D = 0. */
rigcal_status rc_band_place(rigcal_real uv[2], rigcal_real J[6], rigcal_real D[2][3],
                            const rigcal_camera *camera, int is_pinhole,
                            const rigcal_real m[3])
{
    const rigcal_status status = rc_project_through(uv, J, camera, is_pinhole, m);
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_vec3_cross(D[0], &J[3], m);
    rc_vec3_cross(D[1], m, &J[0]);
    const rigcal_real c = rc_vec3_dot(&J[0], D[0]);
    const rigcal_real area = c * RC_SQRT(rc_vec3_dot(m, m));
    if (!(area > SQUEEZED * camera->fx * camera->fy)) {
        return RIGCAL_ERR_NO_RAY;
    }
    rc_vec3_scale(D[0], 1 / c, D[0]);
    rc_vec3_scale(D[1], 1 / c, D[1]);
    return RIGCAL_OK;
}

static rigcal_status make_ray(rigcal_real m[3], rigcal_real D[2][3],
                              const rigcal_camera *camera, const rigcal_real uv[2])
{
    rigcal_real again[2], J[6];
    rigcal_status status = rc_pixel_to_ray(m, camera, uv);
    if (status == RIGCAL_OK) {
        status = rc_band_place(again, J, D, camera, rc_lens_is_pinhole(camera), m);
    }
    return (status == RIGCAL_OK) ? RIGCAL_OK : RIGCAL_ERR_NO_RAY;
}

rigcal_status rigcal_ray_make(rigcal_ray *ray, const rigcal_camera *camera,
                              const rigcal_real uv[2])
{
    rigcal_real m[3], D[2][3];
    if (ray == NULL || uv == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_camera(camera);
    if (status == RIGCAL_OK) {
        status = rc_check_pixel(uv);
    }
    if (status == RIGCAL_OK) {
        status = make_ray(m, D, camera, uv);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    for (int i = 0; i < 3; i++) {
        ray->m[i] = m[i];
        ray->D[2 * i] = D[0][i];
        ray->D[2 * i + 1] = D[1][i];
    }
    return RIGCAL_OK;
}

/* ---- the band of a pixel ------------------------------------------------- */

rigcal_real rc_largest_of(rigcal_real a, rigcal_real b, rigcal_real c)
{
    const rigcal_real half = (a - c) / 2;
    return (a + c) / 2 + RC_SQRT(half * half + b * b);
}

static rigcal_status check_range(rigcal_real near_a, rigcal_real far_a)
{
    if (!rc_is_finite(near_a) || !rc_is_finite(far_a)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    const int is_endless = far_a >= 0 && !(far_a > 0);
    return (near_a >= 0 && near_a <= RC_COORDINATE_MAX && (is_endless || far_a > near_a) &&
            far_a <= RC_COORDINATE_MAX)
               ? RIGCAL_OK
               : RIGCAL_ERR_RANGE;
}

/* Checks sigma_b and k of a pair or a band: OK, ERR_NOT_FINITE, ERR_RANGE. */
static rigcal_status check_widths(rigcal_real sigma_b, rigcal_real k)
{
    if (!rc_is_finite(sigma_b) || !rc_is_finite(k)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    return (sigma_b > 0 && sigma_b <= NOISE_MOST && k > 0 && k <= K_MAX) ? RIGCAL_OK
                                                                         : RIGCAL_ERR_RANGE;
}

static rigcal_status check_pair(const rigcal_match_pair *pair)
{
    rigcal_status status = rc_check_camera(pair->camera_a);
    if (status == RIGCAL_OK) {
        status = rc_check_camera(pair->camera_b);
    }
    if (status == RIGCAL_OK) {
        status = rc_check_transform(&pair->b_from_a);
    }
    rigcal_real nothing = 0;
    for (int i = 0; i < 36; i++) {
        nothing += 0 * pair->Sigma[i]; /* NaN if one of them is not finite */
    }
    if (status == RIGCAL_OK && !rc_is_finite(nothing)) {
        status = RIGCAL_ERR_NOT_FINITE;
    }
    for (int i = 0; i < 6 && status == RIGCAL_OK; i++) {
        status = (pair->Sigma[7 * i] >= 0) ? RIGCAL_OK : RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK) {
        status = check_widths(pair->sigma_b, pair->k);
    }
    if (status == RIGCAL_OK && !rc_is_finite(pair->sigma_a)) {
        status = RIGCAL_ERR_NOT_FINITE;
    }
    if (status == RIGCAL_OK && (!(pair->sigma_a >= 0) || !(pair->sigma_a <= NOISE_MOST))) {
        status = RIGCAL_ERR_RANGE;
    }
    return (status == RIGCAL_OK) ? check_range(pair->near_a, pair->far_a) : status;
}

/* x^T A y with a 3 x 3 block A of Sigma. */
static rigcal_real between(const rigcal_real x[3], const rigcal_real block[],
                           const rigcal_real y[3])
{
    return x[0] * rc_vec3_dot(&block[0], y) + x[1] * rc_vec3_dot(&block[6], y) +
           x[2] * rc_vec3_dot(&block[12], y);
}

/* Where the blocks of Sigma begin: of w, of w and dt, of dt. */
enum { OF_W = 0, ACROSS = 3, OF_DT = 21 };

/* (M3) The axes are q = ray, e = towards and n = line / across; t = (x, y, 0). The error
 * (w, dt) of the calibration moves the line by K^T (w, dt), with the columns
 *
 *     (-y e, 0), (x e, -n), (x n, e)
 *
 * A turn of q by (0, be, bn) moves it by (-y bn, x bn, -x be). */
static void line_covariance(rigcal_band *band, const rigcal_match_pair *pair,
                            rigcal_real D_a[2][3], const rigcal_real n[3])
{
    const rigcal_real *const e = band->towards, *const S = pair->Sigma;
    const rigcal_real x = band->along, y = band->across;
    const rigcal_real ee = between(e, &S[OF_W], e), en = between(e, &S[OF_W], n);
    const rigcal_real nn = between(n, &S[OF_W], n);
    const rigcal_real e_e = between(e, &S[ACROSS], e), e_n = between(e, &S[ACROSS], n);
    const rigcal_real n_e = between(n, &S[ACROSS], e), n_n = between(n, &S[ACROSS], n);
    rigcal_real *const M = band->Sigma_line;
    M[0] = y * y * ee;
    M[1] = y * (e_n - x * ee);
    M[2] = -y * (x * en + e_e);
    M[3] = x * (x * ee - 2 * e_n) + between(n, &S[OF_DT], n);
    M[4] = x * (x * en + e_e - n_n) - between(n, &S[OF_DT], e);
    M[5] = x * (x * nn + 2 * n_e) + between(e, &S[OF_DT], e);
    for (int column = 0; column < 2; column++) {
        rigcal_real turned[3];
        rc_mat3_mul_vec3(turned, pair->b_from_a.R, D_a[column]);
        const rigcal_real be = rc_vec3_dot(turned, e), bn = rc_vec3_dot(turned, n);
        const rigcal_real moved[3] = {-y * bn, x * bn, -x * be};
        rc_sym3_add_outer(M, pair->sigma_a * pair->sigma_a, moved);
    }
}

/* Checks that the line has a direction: its length must exceed max(3, k) times its largest
 * standard deviation. Also sets the variance of the direction of t. n and (x e - y q) / |t|
 * are across t. */
static rigcal_status check_epipole(rigcal_band *band, const rigcal_match_pair *pair,
                                   const rigcal_real n[3])
{
    const rigcal_real *const dt = &pair->Sigma[OF_DT], *const M = band->Sigma_line;
    const rigcal_real x = band->along, y = band->across, t2 = x * x + y * y;
    rigcal_real aside[3];
    rc_vec3_combine(aside, x, band->towards, -y, band->ray);
    const rigcal_real variance =
        rc_largest_of(between(n, dt, n), between(n, dt, aside) / RC_SQRT(t2),
                      between(aside, dt, aside) / t2) /
        t2;
    band->epipole2 = (variance < 0) ? 0 : variance; /* of a Sigma that is none */
    const rigcal_real largest = rc_largest_of(M[3], M[4], M[5]);
    if (!rc_all_finite(M, 6) || !rc_is_finite(band->epipole2)) {
        return RIGCAL_ERR_RANGE;
    }
    return (y * y > rc_max(EPIPOLE_LIMIT2, band->k * band->k) * largest)
               ? RIGCAL_OK
               : RIGCAL_ERR_EPIPOLE;
}

static rigcal_status fill_band(rigcal_band *band, const rigcal_match_pair *pair,
                               const rigcal_real m[3], rigcal_real D_a[2][3])
{
    rigcal_real turned[3], direction[3], aside[3];
    const rigcal_real *const t = pair->b_from_a.t;
    rc_mat3_mul_vec3(turned, pair->b_from_a.R, m);
    (void)rc_vec3_unit(band->ray, turned);
    if (!rc_vec3_unit(direction, t)) {
        return RIGCAL_ERR_EPIPOLE;
    }
    rc_vec3_cross(turned, direction, band->ray); /* a difference of products would cancel */
    if (!(rc_vec3_norm(turned) > PARALLEL_TOL)) {
        return RIGCAL_ERR_EPIPOLE;
    }
    (void)rc_vec3_unit(aside, turned);
    rc_vec3_cross(band->towards, band->ray, aside);
    band->along = rc_vec3_dot(band->ray, t);
    band->across = rc_vec3_dot(band->towards, t);
    rc_vec3_scale(band->line, band->across, aside);
    band->camera_b = *pair->camera_b;
    band->sigma_b = pair->sigma_b;
    band->k = pair->k;
    band->near_a = pair->near_a;
    band->far_a = pair->far_a;
    line_covariance(band, pair, D_a, aside);
    return check_epipole(band, pair, aside);
}

rigcal_status rigcal_band_make(rigcal_band *band, const rigcal_match_pair *pair,
                               const rigcal_real uv_a[2])
{
    rigcal_real m[3], D_a[2][3];
    rigcal_band made;
    if (band == NULL || pair == NULL || uv_a == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = check_pair(pair);
    if (status == RIGCAL_OK) {
        status = rc_check_pixel(uv_a);
    }
    if (status == RIGCAL_OK) {
        status = make_ray(m, D_a, pair->camera_a, uv_a);
    }
    if (status == RIGCAL_OK) {
        status = fill_band(&made, pair, m, D_a);
    }
    if (status == RIGCAL_OK) {
        *band = made;
    }
    return status;
}

rigcal_status rigcal_band_make_ray(rigcal_band *band, const rigcal_match_pair *pair,
                                   const rigcal_ray *ray_a)
{
    rigcal_real D_a[2][3];
    rigcal_band made;
    if (band == NULL || pair == NULL || ray_a == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = check_pair(pair);
    if (status == RIGCAL_OK) {
        status = rc_ray_check(ray_a);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    for (int i = 0; i < 6; i++) {
        D_a[i % 2][i / 2] = ray_a->D[i];
    }
    status = fill_band(&made, pair, ray_a->m, D_a);
    if (status == RIGCAL_OK) {
        *band = made;
    }
    return status;
}

rigcal_status rc_band_check(const rigcal_band *band)
{
    if (band == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_camera(&band->camera_b);
    const rigcal_real numbers[] = {band->along, band->across, band->epipole2};
    if (status == RIGCAL_OK &&
        (!rc_all_finite(numbers, 3) || !rc_all_finite(band->ray, 3) ||
         !rc_all_finite(band->towards, 3) || !rc_all_finite(band->line, 3) ||
         !rc_all_finite(band->Sigma_line, 6))) {
        status = RIGCAL_ERR_NOT_FINITE;
    }
    if (status == RIGCAL_OK) {
        status = check_widths(band->sigma_b, band->k);
    }
    if (status == RIGCAL_OK) {
        status = check_range(band->near_a, band->far_a);
    }
    if (status == RIGCAL_OK &&
        (!RC_IS_UNIT(band->ray) || !RC_IS_UNIT(band->towards) || !(band->across > 0) ||
         !rc_all_within(band->line, 3, RC_COORDINATE_MAX) ||
         !rc_all_within(numbers, 2, RC_COORDINATE_MAX) || !(band->epipole2 >= 0))) {
        status = RIGCAL_ERR_RANGE;
    }
    return status;
}

/* ---- a candidate --------------------------------------------------------- */

/* Whether m, of length 1, is within 3 standard deviations of the direction of t. x, y and h
 * are its parts along ray, along towards and across both. The squared sine of the angle is
 * ((along y - across x)^2 + |t|^2 h^2) / |t|^2. */
static int is_near_epipole(const rigcal_band *band, const rigcal_ray *ray,
                           const rigcal_real xyh[3])
{
    const rigcal_real *const D = ray->D;
    const rigcal_real t2 = band->along * band->along + band->across * band->across;
    const rigcal_real aside = band->along * xyh[1] - band->across * xyh[0];
    const rigcal_real squared = aside * aside + t2 * xyh[2] * xyh[2];
    const rigcal_real sigma2 = band->sigma_b * band->sigma_b;
    const rigcal_real uu = D[0] * D[0] + D[2] * D[2] + D[4] * D[4];
    const rigcal_real vv = D[1] * D[1] + D[3] * D[3] + D[5] * D[5];
    if (squared > EPIPOLE_LIMIT2 * t2 * (band->epipole2 + sigma2 * (uu + vv))) {
        return 0;
    }
    const rigcal_real uv = D[0] * D[1] + D[2] * D[3] + D[4] * D[5];
    const rigcal_real variance = band->epipole2 + sigma2 * rc_largest_of(uu, uv, vv);
    return squared <= EPIPOLE_LIMIT2 * t2 * variance;
}

/* (M2), (M5) */
rigcal_status rc_band_test(rigcal_match *match, const rigcal_band *band,
                           const rigcal_ray *ray)
{
    const rigcal_real *const D = ray->D, *const l = band->line, *const M = band->Sigma_line;
    const rigcal_real s = rc_vec3_dot(l, ray->m);
    const rigcal_real x = rc_vec3_dot(ray->m, band->ray);
    const rigcal_real y = rc_vec3_dot(ray->m, band->towards);
    const rigcal_real xyh[3] = {x, y, s / band->across}, h = xyh[2];
    const rigcal_real g[2] = {D[0] * l[0] + D[2] * l[1] + D[4] * l[2],
                              D[1] * l[0] + D[3] * l[1] + D[5] * l[2]};
    const rigcal_real slope2 = g[0] * g[0] + g[1] * g[1];
    const rigcal_real variance = x * (x * M[0] + 2 * (y * M[1] + h * M[2])) +
                                 y * (y * M[3] + 2 * h * M[4]) + h * h * M[5] +
                                 band->sigma_b * band->sigma_b * slope2;
    const rigcal_real width2 = variance / slope2, distance2 = s * s / slope2;
    if (!(variance > 0 && width2 > 0 && width2 <= WIDTH2_MOST && distance2 <= WIDTH2_MOST &&
          s * s / variance <= WIDTH2_MOST)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    if (is_near_epipole(band, ray, xyh)) {
        return RIGCAL_ERR_EPIPOLE;
    }
    match->half_width_px = band->k * RC_SQRT(width2);
    if (RC_FABS(y) <= PARALLEL_TOL) {
        return RIGCAL_ERR_PARALLEL;
    }
    const rigcal_real depth = band->across * (x / y) - band->along;
    if (!(y > 0 && depth > 0)) {
        return RIGCAL_ERR_BEHIND;
    }
    match->chi2 = s * s / variance;
    match->distance_px = s / RC_SQRT(slope2);
    match->score = match->chi2 + rc_log(width2);
    match->depth_a = depth;
    match->is_inside = match->chi2 <= band->k * band->k && depth >= band->near_a &&
                       (depth <= band->far_a || !(band->far_a > 0));
    return RIGCAL_OK;
}

rigcal_status rc_ray_check(const rigcal_ray *ray)
{
    if (RC_IS_UNIT(ray->m) && rc_all_within(ray->D, 6, RC_COORDINATE_MAX)) {
        return RIGCAL_OK;
    }
    return (rc_all_finite(ray->m, 3) && rc_all_finite(ray->D, 6)) ? RIGCAL_ERR_RANGE
                                                                  : RIGCAL_ERR_NOT_FINITE;
}

rigcal_status rigcal_band_test_ray(rigcal_match *match, const rigcal_band *band,
                                   const rigcal_ray *ray_b)
{
    rigcal_match found;
    if (match == NULL || ray_b == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_band_check(band);
    if (status == RIGCAL_OK) {
        status = rc_ray_check(ray_b);
    }
    if (status == RIGCAL_OK) {
        status = rc_band_test(&found, band, ray_b);
    }
    if (status == RIGCAL_OK) {
        found.index = 0;
        *match = found;
    }
    return status;
}

rigcal_status rigcal_band_test(rigcal_match *match, const rigcal_band *band,
                               const rigcal_real uv_b[2])
{
    rigcal_ray ray;
    if (match == NULL || band == NULL || uv_b == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = rigcal_ray_make(&ray, &band->camera_b, uv_b);
    return (status == RIGCAL_OK) ? rigcal_band_test_ray(match, band, &ray) : status;
}
