/* rigcal_measure.h - points in space and matching lines, with known poses. Included by
 * rigcal.h, whose first page holds here too.
 *
 * A depth is a multiple of the ray that is handed in. For the ray (x, y, 1) the depth is
 * Z; for a unit ray it is the distance. */
#ifndef RIGCAL_H
#include "rigcal.h" /* rigcal.h includes this header too */
#endif

#ifndef RIGCAL_MEASURE_H
#define RIGCAL_MEASURE_H

#ifdef __cplusplus
extern "C" {
#endif

/* ==== depth =============================================================== */

/* (22)..(24): the depths of one point along its rays in two cameras, by least squares on
 * depth_b ray_b = depth_a R ray_a + t. *miss gets the distance between the two rays there.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE (ray of length zero), ERR_PARALLEL
 * (rays within 0.1 degree), ERR_BEHIND (the rays meet behind). */
RIGCAL_API rigcal_status rigcal_depth_two_views(rigcal_real depth_ab[2], rigcal_real *miss,
                                                const rigcal_transform *b_from_a,
                                                const rigcal_real ray_a[3],
                                                const rigcal_real ray_b[3]);

/* (19), (20): aligned stereo. The right camera is at (baseline, 0, 0) in the frame of the
 * left one, and both look the same way. Computes X_left[3] from normalised points (x, y).
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE (baseline <= 0), ERR_PARALLEL (no disparity),
 * ERR_BEHIND (negative disparity). */
RIGCAL_API rigcal_status rigcal_depth_aligned(rigcal_real X_left[3], rigcal_real baseline,
                                              const rigcal_real xy_left[2],
                                              const rigcal_real xy_right[2]);

/* ==== point =============================================================== */

typedef struct rigcal_point {
    rigcal_real X[3];     /* in the frame "world" of cams_from_world */
    rigcal_real Sigma[9]; /* covariance of X for noise of sigma_px */
    rigcal_real rms_px;   /* sqrt(sum(du^2 + dv^2) / n) */
} rigcal_point;

/* A point from n >= 2 views. It has the least sum of squared pixel distances through the
 * full lens models. The search is Levenberg-Marquardt, from the point that is nearest to
 * all the rays. It takes at most 50 evaluations, usually 2 or 3, and 1 if the pixels are
 * exact. sigma_px > 0: noise of one coordinate of a pixel.
 *
 *   cameras, cams_from_world, uv   in   n of each, uv as n pairs
 *
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_ROTATION, ERR_RANGE, ERR_TOO_FEW,
 * ERR_NO_RAY, ERR_PARALLEL, ERR_BEHIND; and RIGCAL_BUDGET_SPENT, with the point
 * written. */
RIGCAL_API rigcal_status rigcal_point_triangulate(rigcal_point *point,
                                                  const rigcal_camera cameras[],
                                                  const rigcal_transform cams_from_world[],
                                                  const rigcal_real uv[], size_t n,
                                                  rigcal_real sigma_px);

/* Section VI-C: the greatest error in frame b of a point that is measured at X_a, when
 * b_from_a_used stands for the true transform. It is 2 sin(angle / 2) |X_a| + |dt|. The
 * angle is that between the two rotations, and 2 sin(angle / 2) is the spectral norm of
 * their difference.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE. */
RIGCAL_API rigcal_status rigcal_point_bound(rigcal_real *bound,
                                            const rigcal_transform *b_from_a_used,
                                            const rigcal_transform *b_from_a_true,
                                            const rigcal_real X_a[3]);

/* ==== epiline: the matching line ========================================== */

/* (25), (26): the matching line (epipolar line) in camera b of a point that camera a sees
 * along ray_a. The line is alpha x + beta y + gamma = 0 in normalised coordinates of b. As
 * alpha^2 + beta^2 = 1, the left side is a signed distance.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE (ray of length zero), ERR_EPIPOLE
 * (also when the centres of a and b coincide), ERR_OUTSIDE (the plane of the line has no
 * point in front of b: the line is at infinity). */
RIGCAL_API rigcal_status rigcal_epiline(rigcal_real line[3],
                                        const rigcal_transform *b_from_a,
                                        const rigcal_real ray_a[3]);

/* The same line in pixels of camera b without distortion (as rigcal_camera_undistort
 * gives), again with alpha^2 + beta^2 = 1, so distances are in pixels. Also returns
 * ERR_CAMERA. */
RIGCAL_API rigcal_status rigcal_epiline_px(rigcal_real line_px[3],
                                           const rigcal_camera *camera_b,
                                           const rigcal_transform *b_from_a,
                                           const rigcal_real ray_a[3]);

/* Signed distance from such a line of the observed (distorted) pixel uv_b, in undistorted
 * pixels. OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_NO_RAY, ERR_WIDE_RAY, ERR_RANGE
 * (alpha^2 + beta^2 is not 1). */
RIGCAL_API rigcal_status rigcal_epiline_distance(rigcal_real *distance_px,
                                                 const rigcal_real line_px[3],
                                                 const rigcal_camera *camera_b,
                                                 const rigcal_real uv_b[2]);

/* The part of a line that lies in the rectangle of the image, to the outer borders of its
 * pixels: -0.5 <= u <= width - 0.5, and the same for v. Sizes are 1 .. 1000000. ends =
 * (u1, v1, u2, v2), in the direction (beta, -alpha).
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE, ERR_OUTSIDE. */
RIGCAL_API rigcal_status rigcal_epiline_clip(rigcal_real ends[4],
                                             const rigcal_real line_px[3], int32_t width,
                                             int32_t height);

/* The part of the line on which the match can be, if its depth along ray_a is between
 * near_a > 0 and far_a > near_a. ends = (u, v at near_a, u, v at far_a), in undistorted
 * pixels.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_CAMERA, ERR_RANGE, ERR_WIDE_RAY (one of
 * the ends is not in front of camera b). */
RIGCAL_API rigcal_status rigcal_epiline_segment(rigcal_real ends[4],
                                                const rigcal_camera *camera_b,
                                                const rigcal_transform *b_from_a,
                                                const rigcal_real ray_a[3],
                                                rigcal_real near_a, rigcal_real far_a);

/* The same segment in the real, distorted image, where it is a curve. The function
 * computes the pixels at `capacity` >= 2 depths from near_a to far_a. The depths are
 * evenly spaced in 1 / depth, and so nearly evenly in the image. Pixels that camera b
 * cannot see, behind it or beyond its lens, are left out. uv_b has room for 2 capacity
 * numbers, and *n_written pairs are written.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_CAMERA, ERR_RANGE, ERR_OUTSIDE (none
 * left). */
RIGCAL_API rigcal_status rigcal_epiline_curve(rigcal_real uv_b[], size_t capacity,
                                              size_t *n_written,
                                              const rigcal_camera *camera_b,
                                              const rigcal_transform *b_from_a,
                                              const rigcal_real ray_a[3],
                                              rigcal_real near_a, rigcal_real far_a);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_MEASURE_H */
