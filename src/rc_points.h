/* rc_points.h - the points of a view that count, and from where they count.
 *
 * Points are counted from an origin in their middle, so that a far world costs no digits
 * and a small turn is one about the middle of the target. `cam_from_points` is the pose
 * that takes points so counted into the camera's frame. */
#ifndef RC_POINTS_H
#define RC_POINTS_H

#include "rc_residual.h"

/* Checks the view's pointers and camera. Returns OK, ERR_NULL, ERR_NOT_FINITE or
 * ERR_CAMERA. */
rigcal_status rc_check_view(const rigcal_view *view);

/* Checks the noise that a caller states [px]: 0 if unknown, else a number whose square is a
 * number too. Returns OK, ERR_NOT_FINITE or ERR_RANGE. */
rigcal_status rc_check_noise(const rigcal_real *sigma_px);

/* A change of a sum of squared errors [px^2] below this means nothing. extent_px is the
 * size of the image; `pixel_size` comes from rc_pixel_size. */
rigcal_real rc_negligible(rigcal_real pixel_size, rigcal_real extent_px);

/* Takes all points of a checked view, or those whose `mask` is 1 (NULL: no mask). Reads no
 * observation. */
void rc_points_of(rigcal_points *points, const rigcal_view *view, const uint8_t mask[]);

/* Checks the points that count, and finds where they are: fills in the rest of *points.
 * Their origin is their mean, weighed by 1 / sigma^2. uv_middle gets the mean of their
 * pixels. Returns OK, or ERR_NOT_FINITE or ERR_RANGE of observation *at_fault (else it is
 * -1). Also ERR_RANGE of their number, ERR_TOO_FEW (below 3) and, with *points complete,
 * ERR_COINCIDENT or ERR_PRECISION. */
rigcal_status rc_points_survey(rigcal_points *points, rigcal_real uv_middle[2],
                               int32_t *at_fault);

/* The first point from i on that counts, or n if there is none. */
RC_INLINE size_t rc_points_next(const rigcal_points *points, size_t i)
{
    while (i < points->view.n && ((int32_t)i == points->left_out ||
                                  (points->mask != NULL && points->mask[i] != 1))) {
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

/* Sets x to point i, counted from the origin. A mirrored target is mirrored there. */
RC_INLINE void rc_points_at(rigcal_real x[3], const rigcal_points *points, size_t i)
{
    RIGCAL_ASSERT(i < points->view.n);
    const rigcal_real *const X = points->view.observations[i].X_w;
    const rigcal_real *const o = points->origin;
    rc_vec3_sub(x, points->is_mirrored ? o : X, points->is_mirrored ? X : o);
}

/* Computes q = R x, and X_c = q + t, the point in the camera's frame. */
void rc_points_place(rigcal_real q[3], rigcal_real X_c[3], const rigcal_points *points,
                     const rigcal_transform *cam_from_points, size_t i);

/* Computes what rc_residual and rc_points_place compute for point i. */
rigcal_status rc_points_residual(rigcal_real e[2], rigcal_real B[6], rigcal_real q[3],
                                 rigcal_real X_c[3], const rigcal_points *points,
                                 const rigcal_transform *cam_from_points, size_t i);

/* The squared distance [px^2] of the pixel of point i from its projection. RC_MAX if it has
 * no projection. */
rigcal_real rc_points_distance2(const rigcal_points *points,
                                const rigcal_transform *cam_from_points, size_t i);

/* The same, divided by sigma_i^2. */
rigcal_real rc_points_error2(const rigcal_points *points,
                             const rigcal_transform *cam_from_points, size_t i);

/* Whether the points that count are on a line, to rounding. */
int rc_points_are_on_line(const rigcal_points *points);

#endif /* RC_POINTS_H */
