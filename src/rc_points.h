/* rc_points.h - the points of a view that count, and from where they count.
 *
 * Points are counted from an origin in their middle, so that a far world costs no digits
 * and a small turn is one about the middle of the target. `cam_from_points` is the pose
 * that takes points so counted into the camera's frame. */
#ifndef RC_POINTS_H
#define RC_POINTS_H

#include "rc_residual.h"

/* OK; ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA of the view's pointers and camera. */
rigcal_status rc_check_view(const rigcal_view *view);

/* The noise that a caller states [px]: 0 for unknown, or a number whose square is one.
 * OK, ERR_NOT_FINITE, ERR_RANGE. */
rigcal_status rc_check_noise(const rigcal_real *sigma_px);

/* A change of a sum of squared errors [px^2] that means nothing, in an image of which
 * extent_px is the size; `pixel_size` as of rc_pixel_size. */
rigcal_real rc_negligible(rigcal_real pixel_size, rigcal_real extent_px);

/* All points of a checked view, or those that `mask` (NULL: none) does not have at 0. Reads
 * no observation. */
void rc_points_of(rigcal_points *points, const rigcal_view *view, const uint8_t mask[]);

/* Checks the points that count, and finds where they are: fills in the rest of *points.
 * Their origin is their mean, weighed by sigma. uv_middle gets the mean of their pixels.
 * OK; ERR_NOT_FINITE, ERR_RANGE of the observation *at_fault, else -1; ERR_RANGE of their
 * number; ERR_TOO_FEW (below 3); and, *points complete, ERR_COINCIDENT, ERR_PRECISION. */
rigcal_status rc_points_survey(rigcal_points *points, rigcal_real uv_middle[2],
                               int32_t *at_fault);

/* The first point from i on that counts; n when there is none. */
RC_INLINE size_t rc_points_next(const rigcal_points *points, size_t i)
{
    while (i < points->view.n && ((int32_t)i == points->left_out ||
                                  (points->mask != NULL && points->mask[i] == 0))) {
        i++;
    }
    return i;
}

/* 1 / sigma^2 of point i. */
RC_INLINE rigcal_real rc_points_weight(const rigcal_points *points, size_t i)
{
    RIGCAL_ASSERT(i < points->view.n);
    const rigcal_real *const sigma = points->view.sigma;
    return (sigma == NULL) ? 1 : 1 / (sigma[i] * sigma[i]);
}

/* x: point i counted from the origin; of a mirrored target, mirrored there. */
RC_INLINE void rc_points_at(rigcal_real x[3], const rigcal_points *points, size_t i)
{
    RIGCAL_ASSERT(i < points->view.n);
    const rigcal_real *const X = points->view.observations[i].X_w;
    const rigcal_real *const o = points->origin;
    rc_vec3_sub(x, points->is_mirrored ? o : X, points->is_mirrored ? X : o);
}

/* q = R x, and X_c = q + t, the point in the camera's frame. */
void rc_points_place(rigcal_real q[3], rigcal_real X_c[3], const rigcal_points *points,
                     const rigcal_transform *cam_from_points, size_t i);

/* rc_residual of point i, and what rc_points_place gives. */
rigcal_status rc_points_residual(rigcal_real e[2], rigcal_real B[6], rigcal_real q[3],
                                 rigcal_real X_c[3], const rigcal_points *points,
                                 const rigcal_transform *cam_from_points, size_t i);

/* Squared distance [px^2] of the pixel of point i from its projection; RC_MAX: it has
 * none. */
rigcal_real rc_points_distance2(const rigcal_points *points,
                                const rigcal_transform *cam_from_points, size_t i);

/* The same over sigma_i^2. */
rigcal_real rc_points_error2(const rigcal_points *points,
                             const rigcal_transform *cam_from_points, size_t i);

/* Whether the points that count are on a line, to rounding. */
int rc_points_are_on_line(const rigcal_points *points);

#endif /* RC_POINTS_H */
