#include "rc_points.h"

/* ---- constants ----------------------------------------------------------- */

/* px, or 1 where relative: a smaller sigma is refused as a mistake. */
#define SIGMA_MIN RC(1e-6)

/* px, or 1 where relative: a larger sigma is refused as a mistake. */
#define SIGMA_MAX RC(1e6)

/* px^2: in images without noise a smaller change of a sum of squares means nothing. */
#define GAIN_NEGLIGIBLE RC_TOL(1e-20, 1e-7)

/* part of the image's extent: this is rounding of a pixel. Its square means nothing
 * either. */
#define PIXEL_ROUNDING (8 * RC_EPS)

/* ---- checks -------------------------------------------------------------- */

static rigcal_status check_sigma(const rigcal_real *sigma)
{
    const rigcal_status status = rc_check_numbers(sigma, 1, SIGMA_MAX);
    return (status == RIGCAL_OK && !(*sigma >= SIGMA_MIN)) ? RIGCAL_ERR_RANGE : status;
}

rigcal_status rc_check_noise(const rigcal_real *sigma_px)
{
    RIGCAL_ASSERT(sigma_px != NULL);
    return rc_all_within(sigma_px, 1, 0) ? RIGCAL_OK : check_sigma(sigma_px);
}

rigcal_status rc_check_view(const rigcal_view *view)
{
    if (view == NULL || view->observations == NULL) {
        return RIGCAL_ERR_NULL;
    }
    return rc_check_camera(view->camera);
}

/* ---- survey -------------------------------------------------------------- */

void rc_points_of(rigcal_points *points, const rigcal_view *view, const uint8_t mask[])
{
    points->view = *view;
    points->mask = mask;
    points->left_out = -1;
    if (RC_FOR_SPEED) {
        points->proved2 = 0;
    }
    points->is_mirrored = 0;
}

extern inline size_t rc_points_next(const rigcal_points *points, size_t i);
extern inline rigcal_real rc_points_weight(const rigcal_points *points, size_t i);
extern inline void rc_points_at(rigcal_real x[3], const rigcal_points *points, size_t i);

rigcal_real rc_negligible(rigcal_real pixel_size, rigcal_real extent_px)
{
    RIGCAL_ASSERT(pixel_size > 0 && extent_px >= 0);
    const rigcal_real rounding = PIXEL_ROUNDING * extent_px;
    return rc_max(GAIN_NEGLIGIBLE * pixel_size * pixel_size, rounding * rounding);
}

/* The distance of the farthest pixel from the axis, in the lens's plane. */
static rigcal_real reach_of(const rigcal_points *points)
{
    const rigcal_camera *const c = points->view.camera;
    rigcal_real most = 0;
    for (size_t i = rc_points_next(points, 0); i < points->view.n;
         i = rc_points_next(points, i + 1)) {
        const rigcal_real *const uv = points->view.observations[i].uv;
        const rigcal_real x = (uv[0] - c->cx) / c->fx, y = (uv[1] - c->cy) / c->fy;
        most = rc_max(most, x * x + y * y);
    }
    return RC_SQRT(most);
}

/* Fills in what *points says of its view, besides where the points are. */
static void prepare(rigcal_points *points)
{
    points->is_pinhole = (uint8_t)rc_lens_is_pinhole(points->view.camera);
    points->pixel_size = rc_pixel_size(points->view.camera);
    points->negligible *= rc_negligible(points->pixel_size, points->extent_px);
    if (RC_FOR_SPEED && !points->is_pinhole && !rc_lens_is_fisheye(points->view.camera)) {
        points->proved2 = rc_lens_proved(points->view.camera, reach_of(points));
    }
}

/* Whether an observation is within all limits; NaN is not. */
static inline int is_within(const rigcal_observation *o)
{
    return RC_FABS(o->X_w[0]) <= RC_COORDINATE_MAX &&
           RC_FABS(o->X_w[1]) <= RC_COORDINATE_MAX &&
           RC_FABS(o->X_w[2]) <= RC_COORDINATE_MAX && RC_FABS(o->uv[0]) <= RC_PIXEL_MAX &&
           RC_FABS(o->uv[1]) <= RC_PIXEL_MAX;
}

/* Checks observation i and its sigma. The detailed check runs only if something is
 * wrong. */
static rigcal_status check_point(const rigcal_view *view, size_t i)
{
    const rigcal_observation *const o = &view->observations[i];
    const rigcal_status status =
        (RC_FOR_SPEED && is_within(o)) ? RIGCAL_OK : rc_check_observation(o);
    return (status == RIGCAL_OK && view->sigma != NULL) ? check_sigma(&view->sigma[i])
                                                        : status;
}

/* Finds where the points and their pixels are. */
RC_APART_FAST static rigcal_status measure(rigcal_points *points, rigcal_real uv_middle[2],
                                           int32_t *at_fault)
{
    const rigcal_observation *const o = points->view.observations, *first = NULL;
    rigcal_real total = 0, size = 0, extent = 0;
    rigcal_real shift[3] = {0, 0, 0}, uv_shift[3] = {0, 0, 0};
    size_t n_used = 0;
    *at_fault = -1;
    if (points->view.n > RC_COUNT_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    for (size_t i = rc_points_next(points, 0); i < points->view.n;
         i = rc_points_next(points, i + 1)) {
        const rigcal_status status = check_point(&points->view, i);
        if (status != RIGCAL_OK) {
            *at_fault = (int32_t)i;
            return status;
        }
        if (n_used++ == 0) {
            first = &o[i];
        }
        rigcal_real x[3]; /* differences of two points are exact */
        const rigcal_real weight = rc_points_weight(points, i);
        rc_vec3_sub(x, o[i].X_w, first->X_w);
        rc_vec3_add_scaled(shift, weight, x);
        size = rc_max(size, rc_vec3_max_abs(x));
        total += weight;
        const rigcal_real uv[3] = {o[i].uv[0] - first->uv[0], o[i].uv[1] - first->uv[1], 0};
        rc_vec3_add_scaled(uv_shift, weight, uv);
        extent = rc_max(extent, rc_vec3_max_abs(uv));
    }
    if (n_used < 3) {
        return RIGCAL_ERR_TOO_FEW;
    }
    rc_vec3_combine(points->origin, 1, first->X_w, 1 / total, shift);
    uv_middle[0] = first->uv[0] + uv_shift[0] / total;
    uv_middle[1] = first->uv[1] + uv_shift[1] / total;
    points->n_used = n_used;
    points->negligible = total / (rigcal_real)(int32_t)n_used; /* the mean weight */
    points->size = size;
    points->extent_px = extent;
    return RIGCAL_OK;
}

rigcal_status rc_points_survey(rigcal_points *points, rigcal_real uv_middle[2],
                               int32_t *at_fault)
{
    const rigcal_status status = measure(points, uv_middle, at_fault);
    if (status != RIGCAL_OK) {
        return status;
    }
    prepare(points);
    if (!(points->size > 1 / RC_COORDINATE_MAX)) {
        return RIGCAL_ERR_COINCIDENT;
    }
    return (rc_vec3_max_abs(points->origin) * RC_EPS <= RC_SHAPE_ROUNDING * points->size)
               ? RIGCAL_OK
               : RIGCAL_ERR_PRECISION;
}

/* ---- one point ----------------------------------------------------------- */

void rc_points_place(rigcal_real q[3], rigcal_real X_c[3], const rigcal_points *points,
                     const rigcal_transform *cam_from_points, size_t i)
{
    rigcal_real x[3];
    rc_points_at(x, points, i);
    rc_mat3_mul_vec3(q, cam_from_points->R, x);
    rc_vec3_copy(X_c, q);
    rc_vec3_add(X_c, cam_from_points->t);
}

rigcal_status rc_points_residual(rigcal_real e[2], rigcal_real B[6], rigcal_real q[3],
                                 rigcal_real X_c[3], const rigcal_points *points,
                                 const rigcal_transform *cam_from_points, size_t i)
{
    rc_points_place(q, X_c, points, cam_from_points, i);
    return rc_residual(e, B, points->view.camera, points->is_pinhole,
                       points->view.observations[i].uv, X_c);
}

rigcal_real rc_points_distance2(const rigcal_points *points,
                                const rigcal_transform *cam_from_points, size_t i)
{
    rigcal_real e[2] = {0, 0}, B[6], q[3], X_c[3];
    if (rc_points_residual(e, B, q, X_c, points, cam_from_points, i) != RIGCAL_OK) {
        return RC_MAX;
    }
    return rc_min(e[0] * e[0] + e[1] * e[1], RC_MAX);
}

rigcal_real rc_points_error2(const rigcal_points *points,
                             const rigcal_transform *cam_from_points, size_t i)
{
    const rigcal_real *const sigma = points->view.sigma;
    const rigcal_real squared = rc_points_distance2(points, cam_from_points, i);
    return (sigma == NULL) ? squared : squared / (sigma[i] * sigma[i]);
}

int rc_points_are_on_line(const rigcal_points *points)
{
    rigcal_real C[6] = {0, 0, 0, 0, 0, 0}, normal[3], thickness, x[3];
    for (size_t i = rc_points_next(points, 0); i < points->view.n;
         i = rc_points_next(points, i + 1)) {
        rc_points_at(x, points, i);
        rc_sym3_add_outer(C, 1, x);
    }
    return !rc_sym3_thinnest(normal, &thickness, C);
}
