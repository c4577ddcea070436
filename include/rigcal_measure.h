/* rigcal_measure.h - points in space and matching lines, with known poses. Included by
 * rigcal.h, whose first page holds here too.
 *
 * Depths count in lengths of the ray that is handed in: with m = (x, y, 1) the number is
 * Z, with a unit ray it is the distance. */
#ifndef RIGCAL_H
#include "rigcal.h" /* which includes this one in its turn */
#endif

#ifndef RIGCAL_MEASURE_H
#define RIGCAL_MEASURE_H

#ifdef __cplusplus
extern "C" {
#endif

/* ==== depth =============================================================== */

/* (22)..(24): depths of one point along its rays in two cameras, by least squares on
 * depth_b ray_b = depth_a R ray_a + t, and the distance by which the rays miss each other
 * there.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE (ray of length zero), ERR_PARALLEL
 * (rays within 0.1 degree), ERR_BEHIND (the rays meet behind). */
RIGCAL_API rigcal_status rigcal_depth_two_views(rigcal_real depth_ab[2], rigcal_real *miss,
                                                const rigcal_transform *b_from_a,
                                                const rigcal_real ray_a[3],
                                                const rigcal_real ray_b[3]);

/* (19), (20): aligned stereo, the right camera at (baseline, 0, 0) of the left, both
 * looking the same way. X_left[3] from normalised points (x, y).
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE (baseline <= 0), ERR_PARALLEL (no disparity),
 * ERR_BEHIND (negative disparity). */
RIGCAL_API rigcal_status rigcal_depth_aligned(rigcal_real X_left[3], rigcal_real baseline,
                                              const rigcal_real xy_left[2],
                                              const rigcal_real xy_right[2]);

/* ==== point =============================================================== */

typedef struct rigcal_point {
    rigcal_real X[3];     /* in the frame that the cameras' poses start from */
    rigcal_real Sigma[9]; /* its covariance for the sigma_px given */
    rigcal_real rms_px;   /* sqrt(sum(du^2 + dv^2) / n) */
} rigcal_point;

/* A point from n >= 2 views: least squares of the pixel distances through the full lens
 * models, by Levenberg-Marquardt from the point nearest to all the rays: at most 50
 * evaluations, usually 2 or 3, of exact pixels 1. sigma_px > 0: noise of one coordinate.
 *
 *   cameras, cams_from_world, uv   in   n of each, uv as n pairs
 *
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_ROTATION, ERR_RANGE, ERR_TOO_FEW,
 * ERR_NO_RAY, ERR_PARALLEL, ERR_BEHIND; and, written, RIGCAL_BUDGET_SPENT. */
RIGCAL_API rigcal_status rigcal_point_triangulate(rigcal_point *point,
                                                  const rigcal_camera cameras[],
                                                  const rigcal_transform cams_from_world[],
                                                  const rigcal_real uv[], size_t n,
                                                  rigcal_real sigma_px);

/* Section VI-C: how far a point that is measured at X_a can be off in frame b when
 * b_from_a is used in place of the true transform: 2 sin(angle / 2) |X_a| + |dt|,
 * 2 sin(angle / 2) being the spectral norm of the difference of the rotations.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE. */
RIGCAL_API rigcal_status rigcal_point_bound(rigcal_real *bound,
                                            const rigcal_transform *b_from_a_used,
                                            const rigcal_transform *b_from_a_true,
                                            const rigcal_real X_a[3]);

/* ==== epiline: the matching line ========================================== */

/* (25), (26): the matching line (epipolar line) in camera b of what camera a sees along
 * ray_a: alpha x + beta y + gamma = 0 in normalised coordinates of b,
 * alpha^2 + beta^2 = 1, so the left side is a signed distance.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE (ray of length zero), ERR_EPIPOLE
 * (also when the centres of a and b coincide), ERR_OUTSIDE (the plane through the line
 * holds nothing in front of b: the line is at infinity). */
RIGCAL_API rigcal_status rigcal_epiline(rigcal_real line[3],
                                        const rigcal_transform *b_from_a,
                                        const rigcal_real ray_a[3]);

/* The same line in pixels of camera b without distortion (as rigcal_camera_undistort
 * gives), again with alpha^2 + beta^2 = 1: distances are pixels. And ERR_CAMERA. */
RIGCAL_API rigcal_status rigcal_epiline_px(rigcal_real line_px[3],
                                           const rigcal_camera *camera_b,
                                           const rigcal_transform *b_from_a,
                                           const rigcal_real ray_a[3]);

/* Signed distance [px], in undistorted pixels, of the observed (distorted) pixel uv_b from
 * such a line. OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_NO_RAY, ERR_WIDE_RAY,
 * ERR_RANGE (alpha^2 + beta^2 is not 1). */
RIGCAL_API rigcal_status rigcal_epiline_distance(rigcal_real *distance_px,
                                                 const rigcal_real line_px[3],
                                                 const rigcal_camera *camera_b,
                                                 const rigcal_real uv_b[2]);

/* The part of a line that lies in the rectangle of the image, pixel borders included:
 * -0.5 <= u <= width - 0.5, v alike; sizes 1 .. 1000000. ends = (u1, v1, u2, v2), in the
 * direction (beta, -alpha).
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE, ERR_OUTSIDE. */
RIGCAL_API rigcal_status rigcal_epiline_clip(rigcal_real ends[4],
                                             const rigcal_real line_px[3], int32_t width,
                                             int32_t height);

/* Where along the line the match can be, its depth along ray_a being between near > 0 and
 * far > near: undistorted pixels of both, ends = (u, v at near, u, v at far).
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_CAMERA, ERR_RANGE, ERR_WIDE_RAY (one of
 * them is not in front of camera b). */
RIGCAL_API rigcal_status rigcal_epiline_segment(rigcal_real ends[4],
                                                const rigcal_camera *camera_b,
                                                const rigcal_transform *b_from_a,
                                                const rigcal_real ray_a[3],
                                                rigcal_real near_a, rigcal_real far_a);

/* The same as it runs in the real, distorted image, where it is a curve: the pixels at
 * `capacity` >= 2 depths from near to far, evenly spaced in 1 / depth, which is nearly
 * evenly in the image. Those that camera b cannot see, being behind it or beyond its lens,
 * are left out: uv_b, 2 capacity numbers, holds *n_written pairs.
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
