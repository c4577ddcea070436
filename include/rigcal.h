/* rigcal.h - where each camera of a rig is, from a few points of known shape.
 *
 * This header is the manual: behaviour that is not written here is not promised.
 *
 * START HERE. Most people need seven calls:
 *
 *   rigcal_pose_solve        one camera's pose from the points that it saw
 *   rigcal_tag_solve         the same from the four corners of one square tag
 *   rigcal_pose_covariance   how sure that pose is
 *   rigcal_rig_join          all cameras in one frame, from poses to shared placements
 *   rigcal_point_triangulate a point in space from two or more cameras
 *   rigcal_epiline_px        the line on which a match must lie in another image
 *   rigcal_store_save        the calibration as bytes, for flash or a file
 *
 * Every function returns a rigcal_status. 0: the call is done. Negative: it failed and
 * wrote no output (except in a rig: see rigcal_rig). Positive: it wrote outputs that can be
 * used, and the status names a caveat. rigcal_status_text says it in words. The programs
 * in examples/ have at most 40 lines each.
 *
 *   frames     world or target (any origin), rig, camera: x right, y down, z forward
 *              along the optical axis; all right-handed
 *   b_from_a   takes coordinates in frame a to frame b:  X_b = R_ba X_a + t_ba. Chains
 *              read by eye:  c_from_a = c_from_b * b_from_a
 *   units      lengths in the caller's unit, one throughout; angles in radian; pixels
 *              with (0, 0) the centre of the top-left pixel
 *   range      coordinates and lengths within 1e30 / 1e9, pixels within 1e9, counts
 *              within 2^28; ERR_RANGE beyond, in every function that takes them. Results
 *              of inputs near these ends may be beyond
 *   storage    3 x 3 matrices row by row, vectors are columns
 *   arguments  outputs first, then inputs, then options; a capacity follows its array;
 *              an output may not overlap an input or another output
 *   checks     come first, in every function: NULL, NaN, infinity and numbers out of
 *              range have statuses of their own
 *   at_fault   where a function has it (NULL: not wanted), it is always written: the
 *              index of the observation at fault, or -1
 *   ownership  the caller owns every buffer. No function keeps a pointer after it
 *              returns, except *_begin: its inputs must stay valid until the result
 *   reentrant  no globals, no heap, no stdio, no errno; every loop is bounded
 *   accuracy   figures are for double / float: "1e-12 / 1e-4"
 *
 * Numbers in parentheses, (9) to (26), and letters are those of EQUATIONS.md.
 *
 * Headers: this one includes rigcal_measure.h (points and matching lines), rigcal_rig.h
 * (several cameras), rigcal_choose.h (which of two poses a view has), rigcal_judge.h (which
 * views are wrong), rigcal_point.h (points with their sigma), rigcal_match.h (the band of a
 * matching line, and the search in it), rigcal_monitor.h (whether a rig has moved) and
 * rigcal_solvers.h (what the solvers keep; only its sizes matter to a caller). It does not
 * include rigcal_paper.h, which has the published procedure and its parts. */
#ifndef RIGCAL_H
#define RIGCAL_H

#include <stddef.h>
#include <stdint.h>

#include "rigcal_config.h" /* rigcal_real, RIGCAL_API */

#ifdef __cplusplus
extern "C" {
#endif

/* ==== about: version, statuses, layout ==================================== */

#define RIGCAL_VERSION_MAJOR 0
#define RIGCAL_VERSION_MINOR 2
#define RIGCAL_VERSION_PATCH 0

/* Every status: its name, its number, and its text. */
/* clang-format off */
#define RIGCAL_STATUSES(S)                                                               \
    S(RIGCAL_OK, 0, "done")                                                              \
                                                                                         \
    /* Outputs are written, with a caveat: of any solver. */                             \
    S(RIGCAL_RUNNING, 1, "the solver is not finished: call its step function again")     \
    S(RIGCAL_BUDGET_SPENT, 2,                                                            \
      "the evaluations ran out before the tolerance was met: the best found so far was " \
      "returned; allow more, or check the data")                                         \
    /* Of a rig. */                                                                      \
    S(RIGCAL_DISCONNECTED, 3,                                                            \
      "some cameras share no placement of the target with the first one: place the "     \
      "target where both sides see it")                                                  \
    /* Of a pose. */                                                                     \
    S(RIGCAL_AMBIGUOUS, 4,                                                               \
      "another pose fits nearly as well: see the probabilities; tilt the target or use " \
      "another camera to tell")                                                          \
    S(RIGCAL_POOR_FIT, 5,                                                                \
      "the error is too large for noise: check the correspondences, the target and the " \
      "intrinsics")                                                                      \
    S(RIGCAL_FEW_AGREE, 6,                                                               \
      "so few observations agree that chance may do it: check the correspondences, or "  \
      "give more")                                                                       \
    S(RIGCAL_VAGUE, 7,                                                                   \
      "the data hardly fix the pose: move nearer, or observe points that are farther "   \
      "apart")                                                                           \
    S(RIGCAL_UNSEEN_POINT, 8,                                                            \
      "the lens model images no ray at one of the pixels: the pose is that of the "      \
      "other points; check that pixel and the lens")                                     \
    S(RIGCAL_MOST_DISAGREE, 9,                                                           \
      "most observations disagree with this pose: check the correspondences and the "    \
      "target's coordinates")                                                            \
    S(RIGCAL_VIEWS_LEFT_OUT, 10,                                                         \
      "some views contradict the others and were left out: see which, and why")          \
                                                                                         \
    /* The arguments: of any function. */                                                \
    S(RIGCAL_ERR_NULL, -1, "a pointer that must not be NULL is NULL")                    \
    S(RIGCAL_ERR_NOT_FINITE, -2, "an input is NaN or infinite")                          \
    S(RIGCAL_ERR_RANGE, -3,                                                              \
      "a count, an option or a number is outside its documented range")                  \
    S(RIGCAL_ERR_CAMERA, -4,                                                             \
      "the intrinsics cannot be used: focal lengths and image size must be positive, "   \
      "the lens known, coefficients within 1e9, and those that the lens does not use 0") \
    S(RIGCAL_ERR_ROTATION, -5,                                                           \
      "a matrix is not a rotation to 1e-6 (float 1e-3), a quaternion has length 0, or "  \
      "rotations cancel when averaged")                                                  \
    S(RIGCAL_ERR_CAPACITY, -6,                                                           \
      "a buffer is too small: the manual says what it takes")                            \
    S(RIGCAL_ERR_STATE, -7, "the solver was not begun, or is not finished")              \
    S(RIGCAL_ERR_TOO_FEW, -8,                                                            \
      "too few points, views or pairs for the unknowns: observe more")                   \
                                                                                         \
    /* The geometry. */                                                                  \
    S(RIGCAL_ERR_COINCIDENT, -9,                                                         \
      "fewer than three distinct points or rays: check for points entered twice")        \
    S(RIGCAL_ERR_COLLINEAR, -10,                                                         \
      "all the points lie on one line, about which the camera may turn freely: add a "   \
      "point off the line")                                                              \
    S(RIGCAL_ERR_EDGE_ON, -11,                                                           \
      "all the rays lie in one plane: the target is seen edge-on, tilt it")              \
    S(RIGCAL_ERR_PRECISION, -12,                                                         \
      "the points are so far from the origin that their shape is lost in rounding: "     \
      "subtract a common offset")                                                        \
    S(RIGCAL_ERR_NO_RAY, -13,                                                            \
      "the lens model images no ray there: the pixel or point is outside its usable "    \
      "field")                                                                           \
    S(RIGCAL_ERR_BEHIND, -14, "a point is not in front of the camera")                   \
    S(RIGCAL_ERR_WIDE_RAY, -15,                                                          \
      "a ray is 90 degrees or more off the optical axis (80, for a pose in a build "     \
      "without three points), which this function cannot use")                           \
    S(RIGCAL_ERR_PARALLEL, -16,                                                          \
      "the rays are parallel or nearly so, so the depth is unknown: move the cameras "   \
      "apart")                                                                           \
    S(RIGCAL_ERR_EPIPOLE, -17,                                                           \
      "the point is the image of the other camera's centre: every line through it "      \
      "matches")                                                                         \
    S(RIGCAL_ERR_OUTSIDE, -18, "the line does not cross the image")                      \
    S(RIGCAL_ERR_DEGENERATE, -19,                                                        \
      "the equations are singular: this geometry has no unique answer")                  \
    S(RIGCAL_ERR_NO_POSE, -20,                                                           \
      "no start led to a pose with every point in front: check the correspondences, "    \
      "and that the coordinates are right-handed")                                       \
                                                                                         \
    /* Stored bytes. */                                                                  \
    S(RIGCAL_ERR_DAMAGED, -21,                                                           \
      "the stored bytes are incomplete or were altered: use another copy, or calibrate " \
      "again")                                                                           \
    S(RIGCAL_ERR_FOREIGN, -22, "these bytes are not a stored calibration")               \
    S(RIGCAL_ERR_VERSION, -23,                                                           \
      "the calibration was stored in a form that this version of the library does not "  \
      "know: use the one that stored it")                                                \
                                                                                         \
    /* Of a robust pose; of a tag. */                                                    \
    S(RIGCAL_ERR_NO_CONSENSUS, -24,                                                      \
      "no more observations agree on a pose than chance makes agree: check the "         \
      "correspondences, the target and the camera")                                      \
    S(RIGCAL_ERR_MIRRORED, -25,                                                          \
      "only a mirror shows this: the corners run the wrong way round, the tag is seen "  \
      "from behind or the image is flipped")                                             \
                                                                                         \
    /* Of a rig's views. */                                                              \
    S(RIGCAL_ERR_TWICE, -26,                                                             \
      "two views are of the same camera and placement: make one view of them")           \
    S(RIGCAL_ERR_UNSORTED, -27,                                                          \
      "the views are not in the order of their placements: sort them")                   \
    S(RIGCAL_ERR_CONTRADICTION, -28,                                                     \
      "the views contradict each other, most of them: check which image is of which "    \
      "camera and placement, the target's coordinates and the intrinsics")
/* clang-format on */

typedef int32_t rigcal_status;

#define RIGCAL_STATUS_VALUE(name, number, text) name = (number),
enum rigcal_statuses { RIGCAL_STATUSES(RIGCAL_STATUS_VALUE) };

/* MAJOR * 10000 + MINOR * 100 + PATCH of the linked library. */
RIGCAL_API int32_t rigcal_version(void);

/* The size of rigcal_real in the linked library: 8 (double) or 4 (float). A caller whose
 * own size differs must not go on. */
RIGCAL_API int32_t rigcal_sizeof_real(void);

/* The name of a status ("RIGCAL_ERR_NULL") and its text. The text says what is wrong and
 * what to do. Both are static and never NULL. A number that is no status gives "unknown
 * status". */
RIGCAL_API const char *rigcal_status_name(rigcal_status status);
RIGCAL_API const char *rigcal_status_text(rigcal_status status);

/* One line of the list of the library's structs, for bindings that cannot read this
 * header. A line is "rigcal_camera" with offset 0 and the struct's size, or
 * "rigcal_camera.fx" with the field's offset and size, in bytes. A solver has one line,
 * with its size. */
typedef struct rigcal_layout_entry {
    char name[48];
    int32_t offset;
    int32_t size;
} rigcal_layout_entry;

/* Line `index` of that list, 0 to rigcal_layout_count() - 1.
 * OK, ERR_NULL, ERR_RANGE (no such line). */
RIGCAL_API int32_t rigcal_layout_count(void);
RIGCAL_API rigcal_status rigcal_layout(rigcal_layout_entry *entry, int32_t index);

/* ==== rotation ============================================================
 *
 * Every function: OK, ERR_NULL, ERR_NOT_FINITE; those that take a rotation also
 * ERR_ROTATION. Rotations come out orthonormal to a few units in the last place.
 *
 * Yaw, pitch, roll compose as R = Rz(yaw) Ry(pitch) Rx(roll) (8). */

/* R[9] from ypr = (yaw, pitch, roll). Angles may be of up to 1e6 / 1e3; beyond, the
 * rounding of the angle would be the larger error: ERR_RANGE. */
RIGCAL_API rigcal_status rigcal_rotation_from_yaw_pitch_roll(rigcal_real R[9],
                                                             const rigcal_real ypr[3]);

/* Yaw and roll in (-pi, pi], pitch in [-pi/2, pi/2]. At gimbal lock (|pitch| = pi/2) yaw
 * and roll turn about the same axis; then roll is 0. */
RIGCAL_API rigcal_status rigcal_yaw_pitch_roll_from_rotation(rigcal_real ypr[3],
                                                             const rigcal_real R[9]);

/* Rotation vector w: the axis times the angle, right-handed (Rodrigues; OpenCV's rvec).
 * |w| <= 1e6 / 1e3, else ERR_RANGE. The inverse returns |w| in [0, pi]. */
RIGCAL_API rigcal_status rigcal_rotation_from_vector(rigcal_real R[9],
                                                     const rigcal_real w[3]);
RIGCAL_API rigcal_status rigcal_vector_from_rotation(rigcal_real w[3],
                                                     const rigcal_real R[9]);

/* Quaternion (w, x, y, z), scalar first. Its length may be anything but zero
 * (ERR_ROTATION). R takes v to q v q*. The inverse returns unit length and w >= 0. */
RIGCAL_API rigcal_status rigcal_rotation_from_quaternion(rigcal_real R[9],
                                                         const rigcal_real q_wxyz[4]);
RIGCAL_API rigcal_status rigcal_quaternion_from_rotation(rigcal_real q_wxyz[4],
                                                         const rigcal_real R[9]);

/* The rotation nearest to M in the sum of squared differences: the orthogonal factor of
 * its polar decomposition (Higham 1986). ERR_ROTATION when M is singular to working
 * precision or mirrors (det <= 0). At most 40 iterations, usually 7 or fewer. */
RIGCAL_API rigcal_status rigcal_rotation_nearest(rigcal_real R[9], const rigcal_real M[9]);

/* Angle of the rotation that takes Ra to Rb, in [0, pi]. It is accurate for the smallest
 * angles too. */
RIGCAL_API rigcal_status rigcal_rotation_angle(rigcal_real *angle, const rigcal_real Ra[9],
                                               const rigcal_real Rb[9]);

/* ==== transform ===========================================================
 *
 * A rigid transform b_from_a: X_b = R X_a + t. Every function: OK, ERR_NULL,
 * ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE. */
typedef struct rigcal_transform {
    rigcal_real R[9]; /* rotation, row by row */
    rigcal_real t[3]; /* origin of a in frame b */
} rigcal_transform;

RIGCAL_API rigcal_status rigcal_transform_compose(rigcal_transform *c_from_a,
                                                  const rigcal_transform *c_from_b,
                                                  const rigcal_transform *b_from_a);

RIGCAL_API rigcal_status rigcal_transform_invert(rigcal_transform *a_from_b,
                                                 const rigcal_transform *b_from_a);

RIGCAL_API rigcal_status rigcal_transform_point(rigcal_real X_b[3],
                                                const rigcal_transform *b_from_a,
                                                const rigcal_real X_a[3]);

/* (17), (18): camera b from camera a, when the poses of both are known in the same world.
 * The answer does not depend on where that world has its origin. */
RIGCAL_API rigcal_status rigcal_transform_between(rigcal_transform *b_from_a,
                                                  const rigcal_transform *b_from_world,
                                                  const rigcal_transform *a_from_world);

/* The mean of n >= 1 estimates of one transform. Its rotation minimises the weighted sum
 * of squared angles (Karcher mean, iterated from the chordal mean; Hartley et al. 2013; at
 * most 20 iterations). Its t is the weighted mean. weight NULL: all are equal; else each
 * is >= 0, and one is above 0. sigma_rad, sigma_t (NULL: not wanted): weighted root mean
 * square deviation of the estimates, as an angle and as a length. Also returns
 * ERR_TOO_FEW, and ERR_ROTATION when the rotations cancel. */
RIGCAL_API rigcal_status rigcal_transform_mean(rigcal_transform *mean,
                                               rigcal_real *sigma_rad, rigcal_real *sigma_t,
                                               const rigcal_transform transforms[],
                                               const rigcal_real weight[], size_t n);

/* ==== camera ==============================================================
 *
 * Intrinsics, known beforehand. With (x, y) = (X, Y) / Z of a point in the camera frame,
 * r^2 = x^2 + y^2 and theta = angle off the optical axis:
 *
 *   RIGCAL_LENS_BROWN (Brown 1966; OpenCV's order and signs), Z > 0 only
 *     d  = (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6)
 *     xd = x d + 2 p1 x y + p2 (r^2 + 2 x^2)
 *     yd = y d + p1 (r^2 + 2 y^2) + 2 p2 x y
 *     a pinhole has all eight coefficients 0
 *   RIGCAL_LENS_FISHEYE (Kannala & Brandt 2006; OpenCV's fisheye), theta < pi
 *     (xd, yd) = (x, y) / r * theta (1 + k1 theta^2 + .. + k4 theta^8)
 *     p1, p2, k5, k6 must be 0
 *
 *   u = fx xd + cx,  v = fy yd + cy        (the principal point may be anywhere)
 *
 * A distortion polynomial turns back somewhere off the axis. Beyond that turning point it
 * images a second, spurious ray on the same pixels. The lens is therefore used only up to
 * the turning point: along each straight line from the axis, as long as the Jacobian of
 * (xd, yd) is positive definite. Beyond it the answer is ERR_NO_RAY, never the spurious
 * ray. */
enum rigcal_lenses { RIGCAL_LENS_BROWN = 0, RIGCAL_LENS_FISHEYE = 1 };

typedef struct rigcal_camera {
    int32_t lens;                               /* RIGCAL_LENS_ */
    int32_t width, height;                      /* pixels, 1 .. 1000000 */
    rigcal_real fx, fy;                         /* focal length, pixels, > 0 */
    rigcal_real cx, cy;                         /* principal point, pixels */
    rigcal_real k1, k2, p1, p2, k3, k4, k5, k6; /* each within 1e9 */
} rigcal_camera;

/* A reference point and the pixel that it was seen at. */
typedef struct rigcal_observation {
    rigcal_real X_w[3];
    rigcal_real uv[2];
} rigcal_observation;

/* A view: what one camera saw of the target in one image. */
typedef struct rigcal_view {
    const rigcal_camera *camera;
    const rigcal_observation *observations; /* n of them */
    const rigcal_real *sigma; /* n standard deviations of the observations relative to
                                 each other, 1e-6 .. 1e6; NULL: all equal */
    size_t n;
} rigcal_view;

/* Whether the intrinsics can be used. OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA. Every
 * function that takes a camera makes this check. */
RIGCAL_API rigcal_status rigcal_camera_check(const rigcal_camera *camera);

/* Where the camera is: its centre in the world, o_w = -R^T t.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE. */
RIGCAL_API rigcal_status rigcal_camera_center(rigcal_real o_w[3],
                                              const rigcal_transform *cam_from_world);

/* Pixel of a point in the camera frame. The pixel may lie outside the image. ERR_BEHIND
 * when the point is not in front (Brown: Z <= 0), ERR_NO_RAY when it lies beyond the
 * lens's turning point, ERR_DEGENERATE at the camera's centre, and every status of
 * rigcal_camera_check. Cost: one proof, see rigcal_camera_ray. */
RIGCAL_API rigcal_status rigcal_camera_project(rigcal_real uv[2],
                                               const rigcal_camera *camera,
                                               const rigcal_real X_c[3]);

/* Unit ray that is imaged at a pixel, or ERR_NO_RAY. The ray's projection is the pixel to
 * 1e-9 px / 2e-3 px, where the image and the focal lengths have up to 4000 px. In float
 * the error is multiplied by the lens's magnification, if that is above 1. The ray is
 * found by a damped Newton iteration from the axis. Then a proof follows that the straight
 * path to it does not cross the turning point. Cost: at most 127 Newton solves of 60
 * steps, usually one of 3 to 6; at most 7 proofs of 1024 steps, usually one of 1 to 3. */
RIGCAL_API rigcal_status rigcal_camera_ray(rigcal_real ray[3], const rigcal_camera *camera,
                                           const rigcal_real uv[2]);

/* The pixel at which the same camera without distortion would see the ray of uv, and the
 * inverse. In undistorted pixels, straight lines in space are straight. ERR_NO_RAY as
 * above; ERR_WIDE_RAY for a fisheye's rays at 90 degrees and beyond. */
RIGCAL_API rigcal_status rigcal_camera_undistort(rigcal_real uv_straight[2],
                                                 const rigcal_camera *camera,
                                                 const rigcal_real uv[2]);
RIGCAL_API rigcal_status rigcal_camera_distort(rigcal_real uv[2],
                                               const rigcal_camera *camera,
                                               const rigcal_real uv_straight[2]);

/* Root mean square distance [px] of n >= 1 observed pixels from the projections of their
 * points: sqrt(sum(du^2 + dv^2) / n). view->sigma does not weigh them. `worst` (NULL: not
 * wanted) gets the index of the largest distance. ERR_BEHIND, ERR_NO_RAY, ERR_DEGENERATE
 * as rigcal_camera_project; ERR_TOO_FEW; ERR_ROTATION, ERR_RANGE. */
RIGCAL_API rigcal_status rigcal_view_rms(rigcal_real *rms_px, int32_t *worst,
                                         const rigcal_view *view,
                                         const rigcal_transform *cam_from_world);

/* ==== pose ================================================================
 *
 * One camera's pose from a view of n >= 3 points. No guess is needed. The search covers
 * every direction that the optical axis can have; for each direction, yaw and translation
 * follow from linear equations (EQUATIONS.md A). Each optimum is then refined to the
 * maximum-likelihood pose, which has the least sum of squared reprojection errors in
 * pixels through the full lens model (B).
 *
 * A flat target seen from afar has two optima that fit nearly alike (C). All optima that
 * were found are returned, best first. The status says when the first is not sure.
 *
 * Three points have up to four poses that fit exactly (D), and nothing in the data says
 * which is right. Noise can merge two of these poses into one minimum that does not fit
 * exactly. Such a minimum is returned beside exact poses only if sigma_px is given.
 *
 * Points of a pinhole may be up to 89 degrees off its axis, those of a fisheye as far as
 * its lens goes. Where one is more than 60 degrees off, or 80 off the middle of the
 * target's image, the target is *wide*: poses of three points are tried too, or instead,
 * and refinement begins with errors along the rays (B).
 *
 * Where the noise is not stated, the solver assumes one, in pixels. The unit of uv is a
 * pixel if fx is 28 or more. For a shorter fx, as of normalised images, a pixel is fx^2 /
 * 800. */
enum rigcal_pose_limits { RIGCAL_POSES_MAX = 4 };

typedef struct rigcal_pose {
    rigcal_transform cam_from_world;
    rigcal_real sse;         /* sum of |du|^2 / sigma_i^2 over the points; without
                                view->sigma, in px^2 */
    rigcal_real rms_px;      /* reprojection error: sqrt(sum(du^2 + dv^2) / n) */
    rigcal_real probability; /* that this pose is the right one of those found, if noise is
                                normal. They sum to 1 over all that were found */
} rigcal_pose;

typedef struct rigcal_pose_options {
    int32_t use_start;    /* 1: the search starts from `start`, a previous pose, and returns
                             only the optimum near it; if that is bad, the whole sphere is
                             searched. 0: default */
    rigcal_real sigma_px; /* noise of one coordinate of a pixel, times sigma_i where
                             view->sigma is given; 1e-6 .. 1e6. The fit is judged by it. 0
                             (default): unknown; probabilities are then integrated over all
                             noise from 0.01 px on */
    rigcal_transform start;
} rigcal_pose_options;

typedef struct rigcal_pose_solver rigcal_pose_solver; /* see rigcal_solvers.h */

/* All defaults. OK, ERR_NULL. */
RIGCAL_API rigcal_status rigcal_pose_defaults(rigcal_pose_options *options);

/* begin, step to the end, result. poses[capacity], capacity >= 1; options NULL: all
 * defaults. Statuses: those of the three. */
RIGCAL_API rigcal_status rigcal_pose_solve(rigcal_pose poses[], size_t capacity,
                                           size_t *n_found, int32_t *at_fault,
                                           const rigcal_view *view,
                                           const rigcal_pose_options *options);

/* Begins a search. What the view points to must last until the result has been asked for.
 * This call checks every number once and computes one ray. Time O(n), about that of one
 * evaluation.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_RANGE, ERR_ROTATION (of start),
 * ERR_TOO_FEW (n < 3), ERR_COINCIDENT, ERR_PRECISION. */
RIGCAL_API rigcal_status rigcal_pose_begin(rigcal_pose_solver *solver, int32_t *at_fault,
                                           const rigcal_view *view,
                                           const rigcal_pose_options *options);

/* Spends at most `budget` >= 1 units. RUNNING: call again. The budgets do not change a bit
 * of the result. OK: ask for the result. ERR_NULL, ERR_RANGE, ERR_STATE.
 *
 *   a unit is                                    of one search, at most    usually
 *   the ray of one point (of 16 of a pinhole)    n; 2 n if one is unseen   n
 *   a direction's cost, the equations of a       900 (wide: 2500)          40 to 70
 *     refinement, O(n), or the next start                                  (10 to 120);
 *                                                                         n <= 8: 7 to 55
 *   the proof that a lens with distortion sees   7 n                       1 to 4; of a
 *     one point where an optimum puts it, or                               fisheye n to
 *     all of them at once                                                  2 n
 *
 * In the refinement of a wide target, the first equations also compute the rays of all
 * points. */
RIGCAL_API rigcal_status rigcal_pose_step(rigcal_pose_solver *solver, int32_t budget);

/* The optima of a search that is done, best first. They are the first *n_found of
 * poses[capacity], capacity >= 1. Returns the first of these statuses that applies:
 *
 * RIGCAL_POOR_FIT: the error is so large that noise of sigma_px causes it at most once in
 *     a million fits. The correspondences, the target or the intrinsics are wrong. Without
 *     sigma_px, the noise counts as 2 px, or as 0.7 % of the image's extent if that is
 *     more. The status also applies when mirrored points (left-handed coordinates, an
 *     image with v upwards) would be a hundred times as likely. Flat and wide targets, and
 *     a pose found from `start`, are not tested for mirroring.
 * RIGCAL_BUDGET_SPENT: the refinement of the first pose ran out of evaluations.
 * RIGCAL_VAGUE: the data hardly fix the first pose: the standard deviation of its rotation
 *     is above 0.25 rad for noise of sigma_px. Without sigma_px, the noise is what the
 *     pose's error shows, but at least 0.25 px.
 * RIGCAL_AMBIGUOUS: another pose fits nearly as well: see `probability`. A target seen
 *     exactly edge-on has a flipped twin that fits alike.
 * RIGCAL_UNSEEN_POINT: the lens images no ray at the pixel of point *at_fault. The poses
 *     are those of the other points.
 * OK: the first pose is right with probability 0.99 or more.
 *
 * All these poses are finite. R is a rotation to rounding. Every point lies in front of
 * the camera and within its lens, to the rounding of t and of the points.
 *
 * ERR_NULL, ERR_RANGE, ERR_STATE, ERR_NO_POSE, ERR_DEGENERATE (the observations do not fix
 * the pose). Where `start` fits, the search is not run. A search can also return
 * ERR_NO_RAY (two pixels or more have no ray; *at_fault is the second), ERR_COINCIDENT,
 * ERR_COLLINEAR, and in a build without three points ERR_WIDE_RAY. */
RIGCAL_API rigcal_status rigcal_pose_result(rigcal_pose poses[], size_t capacity,
                                            size_t *n_found, int32_t *at_fault,
                                            const rigcal_pose_solver *solver);

/* How far a pose can be trusted. */
typedef struct rigcal_pose_uncertainty {
    rigcal_real Sigma[36];      /* covariance of (w, dt), row by row, for
                                   R <- exp([w]x) R, t <- t + dt: w [rad] and dt along the
                                   camera's axes */
    rigcal_real rotation[3];    /* 1-sigma of w */
    rigcal_real translation[3]; /* 1-sigma of t */
    rigcal_real center[3];      /* 1-sigma of the camera's centre, world axes */
    rigcal_real sigma_px;       /* the noise that it holds for */
} rigcal_pose_uncertainty;

/* The covariance sigma_px^2 (J^T J)^-1 at a pose. At the true pose it is the Cramer-Rao
 * bound. sigma_px 0: the noise is estimated as sqrt(sse / (2 n - 6)), which needs n >= 4.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_ROTATION, ERR_RANGE, ERR_TOO_FEW (n < 3, or
 * n = 3 without sigma_px), ERR_BEHIND, ERR_NO_RAY, ERR_DEGENERATE. */
RIGCAL_API rigcal_status rigcal_pose_covariance(rigcal_pose_uncertainty *out,
                                                const rigcal_view *view,
                                                const rigcal_transform *cam_from_world,
                                                rigcal_real sigma_px);

/* ==== tag =================================================================
 *
 * The commonest case: one square tag. The origin of its frame is the tag's middle. For
 * someone who reads the tag, x points to the right, y up, and z out of the tag towards the
 * reader. The unit is that of `size`, the length of an edge.
 *
 *   uv   in   its corners, as pixels: top left, top right, bottom right, bottom left as it
 *             is read (ArUco's order; AprilTag's p[3], p[2], p[1], p[0])
 *
 * Only poses that see the tag's front are returned, best first, and usually at most two.
 * All else is as in rigcal_pose_solve with these four points. Statuses: those of
 * rigcal_pose_solve, ERR_RANGE (size not above 0) and ERR_MIRRORED (the corners run the
 * wrong way round). */
RIGCAL_API rigcal_status rigcal_tag_solve(rigcal_pose cams_from_tag[], size_t capacity,
                                          size_t *n_found, int32_t *at_fault,
                                          const rigcal_camera *camera,
                                          const rigcal_real uv[8], rigcal_real size,
                                          const rigcal_pose_options *options);

/* ==== robust ==============================================================
 *
 * One camera's pose from a view some of whose observations are wrong: another point's
 * pixel, or none's. Poses of three points each (D) are tried, from all triples or from
 * random ones, and scored by all the points. The best so far is refined by the points that
 * agree with it. The search ends when a better one is unlikely (E). Then rigcal_pose_solve
 * runs on the points that agree with the best pose; this is repeated, at most 8 times,
 * until the set of agreeing points no longer changes. The same input and seed give the same
 * bits. */
typedef struct rigcal_robust_options {
    rigcal_real threshold_px; /* a point farther than this from its projection is wrong
                                 (times sigma_i where those are given), and so is a
                                 pixel at which the lens images no ray; 1e-6 .. 1e6.
                                 0 (default): 4 sigma_px, or 3 pixels */
    rigcal_real sigma_px;     /* as in rigcal_pose_options */
    int32_t samples;          /* the most triples that are tried; all, when there are no
                                 more. 10000 (default): with nine in ten points wrong the
                                 chance to miss is 1e-3. 1 .. 100000 */
    uint32_t seed;            /* of the random triples. 1 (default) */
    int32_t max_units;        /* the most units that are spent on triples; then the best
                                 pose so far must do. 100000 (default), >= 1 */
} rigcal_robust_options;

typedef struct rigcal_robust_solver rigcal_robust_solver; /* see rigcal_solvers.h */

/* All defaults. OK, ERR_NULL. */
RIGCAL_API rigcal_status rigcal_robust_defaults(rigcal_robust_options *options);

/* begin, step to the end, result. */
RIGCAL_API rigcal_status rigcal_robust_solve(rigcal_pose poses[], size_t capacity,
                                             size_t *n_found, uint8_t inliers[],
                                             size_t *n_inliers, int32_t *at_fault,
                                             const rigcal_view *view,
                                             const rigcal_robust_options *options);

/* As rigcal_pose_begin; `inliers`, n bytes, is written until the search is done, so it must
 * stay valid too. Do not read it before the search is done, or after a failure.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_RANGE, ERR_TOO_FEW (n < 5),
 * ERR_COINCIDENT, ERR_COLLINEAR, ERR_PRECISION. */
RIGCAL_API rigcal_status rigcal_robust_begin(rigcal_robust_solver *solver,
                                             uint8_t inliers[], int32_t *at_fault,
                                             const rigcal_view *view,
                                             const rigcal_robust_options *options);

/* Spends at most `budget` >= 1 units, each O(n). RUNNING: call again; the same bits come
 * out whatever the budgets. OK: ask for the result. ERR_NULL, ERR_RANGE, ERR_STATE.
 *
 *   a unit is                                          at most
 *   the ray of one point of a triple (of a pinhole     a triple takes 7 of these two
 *     all three), or one pose scored by all points       (of a pinhole 5); all with
 *   the choice of the points that agree with a good      the next two max_units
 *     pose, one evaluation of them, or its score       20 a good pose
 *   the ray of one point at last, not of a pinhole     n
 *   the choice of the points that agree at last, one   28
 *     evaluation of them, or one look at their pose
 *   a unit of rigcal_pose_step                         those of 9 searches */
RIGCAL_API rigcal_status rigcal_robust_step(rigcal_robust_solver *solver, int32_t budget);

/* As rigcal_pose_result, of the *n_inliers points that agree: those whose byte of `inliers`
 * is 1, not 0. The first status that applies:
 *
 * RIGCAL_FEW_AGREE: do not trust the pose without another reason (E). Fewer than 6 points
 *     agree; or so few agree, or they agree so badly, that it might be chance with all
 *     points wrong; or other points agree nearly as well with another pose. Of 270 000
 *     scenes with all points wrong, at most 3 have a pose without this caveat.
 * RIGCAL_POOR_FIT, _BUDGET_SPENT, _VAGUE, _AMBIGUOUS: as there, of these points.
 * RIGCAL_MOST_DISAGREE: fewer than half of all points agree. They do not agree by chance,
 *     but the pose may be that of a part of the target, as of a grid shifted by one square.
 * OK.
 * ERR_NO_CONSENSUS: no more points agree than by chance, or those that agree are too few
 *     for a pose, or lie on a line.
 * ERR_NULL, ERR_RANGE, ERR_STATE, ERR_NO_POSE, ERR_DEGENERATE. */
RIGCAL_API rigcal_status rigcal_robust_result(rigcal_pose poses[], size_t capacity,
                                              size_t *n_found, size_t *n_inliers,
                                              const rigcal_robust_solver *solver);

/* ==== diagnose ============================================================
 *
 * What is wrong with observations that fit badly. One call solves several poses: one of
 * all n points, two of the mirrored target and image, and one for each point that is left
 * out in turn. Of more than RIGCAL_BLAME_TRIES points, only those farthest from their
 * projections are left out in turn. The stack does not grow with n. */
enum rigcal_blame_limits { RIGCAL_BLAME_TRIES = 64 };

enum rigcal_blame_verdicts {
    RIGCAL_BLAME_NONE = 0,   /* no point stands out */
    RIGCAL_BLAME_LIKELY = 1, /* one does, but chance or another point may be the reason */
    RIGCAL_BLAME_SURE = 2    /* chance 0.01 or less, probability 0.99 or more */
};

typedef struct rigcal_blame {
    int32_t verdict;            /* RIGCAL_BLAME_ */
    int32_t point;              /* the one without which the others agree best; -1: no such
                                   others have a pose */
    int32_t is_rest_poor;       /* 1: the others are RIGCAL_POOR_FIT too */
    rigcal_real rms_px;         /* of all points; -1: they have no pose */
    rigcal_real rms_without_px; /* without that point */
    rigcal_real chance;         /* that noise alone makes the fit improve as much, for the
                                   best of n points. It is an upper bound, at most 1, from
                                   an F test of 2 and 2 n - 8 degrees of freedom, or from
                                   chi squared where sigma_px is given */
    rigcal_real probability;    /* that this point is wrong, if one point is (C) */
} rigcal_blame;

/* Which one of n >= 5 points to blame for a bad fit. rms_without[i] is the rms without
 * point i [px]. It is -1 where the other points have no pose, where the lens does not see
 * one of them, or where i was not left out. NULL: not wanted. State the noise in the
 * options if you know it; otherwise it is integrated over. Of five points, the four that
 * are left have two degrees of freedom. Without stated noise, RIGCAL_BLAME_SURE is then
 * reached less than half of the time, even for an error of 60 times the noise.
 * OK, ERR_NULL, ERR_TOO_FEW (n < 5), the statuses of rigcal_pose_begin, and errors of
 * rigcal_pose_result that no one point causes. */
RIGCAL_API rigcal_status rigcal_pose_blame(rigcal_blame *blame, rigcal_real rms_without[],
                                           const rigcal_view *view,
                                           const rigcal_pose_options *options);

enum rigcal_diagnosis_verdicts {
    RIGCAL_DIAGNOSIS_CONSISTENT = 0, /* the fit is not RIGCAL_POOR_FIT, and not MIRRORED */
    RIGCAL_DIAGNOSIS_UNITS = 1,      /* the fit is consistent, but the length of t differs
                                        from that of the previous pose by a factor between
                                        units */
    RIGCAL_DIAGNOSIS_ONE_POINT = 2,  /* one point is wrong: see blame */
    RIGCAL_DIAGNOSIS_MIRRORED = 3,   /* the target's coordinates are left-handed, or the
                                        image is mirrored, or v counts upwards. All three
                                        make nearly the same image. Fitted as such, the data
                                        are a thousand times likelier */
    RIGCAL_DIAGNOSIS_UNEXPLAINED = 4 /* poor, and none of these */
};

typedef struct rigcal_diagnosis {
    int32_t verdict;             /* RIGCAL_DIAGNOSIS_ */
    int32_t is_handed;           /* 1: the data decide whether they are mirrored. 0: both
                                    readings fit about equally well, as those of a distant
                                    target do, and of a flat one unless the principal point
                                    is beside the middle of the image */
    rigcal_real rms_mirrored_px; /* of the target mirrored, Z to -Z; -1: no pose */
    rigcal_real rms_flipped_px;  /* of the image flipped, v to height - 1 - v */
    rigcal_real units;           /* about the length of t found, over that of the previous
                                    pose: 10, 25.4, 100, 1000 or the inverse of one of
                                    these. 0: no such factor, or no pose */
    rigcal_blame blame;
} rigcal_diagnosis;

/* Whether the fit of n >= 5 points is consistent and, if not, what would make it so. With
 * options->use_start, `start` is a previous pose in the right units; it serves only to
 * compare the units. rms_without and the statuses are as in rigcal_pose_blame. */
RIGCAL_API rigcal_status rigcal_pose_diagnose(rigcal_diagnosis *diagnosis,
                                              rigcal_real rms_without[],
                                              const rigcal_view *view,
                                              const rigcal_pose_options *options);

/* ==== store ===============================================================
 *
 * A calibration as bytes, for a flash page, a file or a message. The form is little-endian
 * and has no gaps. Every machine and compiler writes the same bytes.
 * examples/data/FORMAT.md has the table of fields. The bytes carry a version and CRC-32s.
 * One or two altered bits, and every length that is too short, are always refused. Other
 * damage is missed with a chance of one in 4e9. The checks guard against accidents, not
 * against forgery. */

/* One camera of a stored calibration. */
typedef struct rigcal_mounted_camera {
    rigcal_camera camera;
    rigcal_transform cam_from_rig;
    rigcal_real Sigma[36]; /* covariance of cam_from_rig, in the form of
                              rigcal_pose_uncertainty. It must be symmetric and positive
                              semidefinite, to 1e-9 / 1e-5 of a correlation. The lower
                              triangle is stored. All 0: the pose is exact, as that of
                              camera 0 of a rig */
    int32_t has_Sigma;     /* 1: Sigma is known. 0: it is not read, and is 0 when loaded */
} rigcal_mounted_camera;

/* What stored bytes say besides their cameras. */
typedef struct rigcal_saved_info {
    uint32_t sequence;  /* the caller's number of this calibration. Of two numbers, a is the
                           later one if (int32_t)(a - b) > 0; this survives the wrap at
                           2^32 */
    uint32_t tag;       /* the caller gives it any meaning, as a rig's serial number */
    int32_t n_cameras;  /* 1 .. RIGCAL_STORE_CAMERAS_MAX */
    int32_t n_free;     /* cameras of the joint covariance (rigcal_store_save_rig); -1: the
                           bytes hold none */
    int32_t n_bytes;    /* of the stored form, from its first byte on */
    int32_t real_bytes; /* 4 or 8: rigcal_sizeof_real() of the build that saved it */
} rigcal_saved_info;

/* Bytes that n cameras take, n in 1 .. 65535: 32, and 376 in double or 196 in float for
 * each camera. STORE_SIZE is for the reals of this build, STORE_SIZE_OF for reals of
 * real_bytes bytes. The function returns 0 for any other n. */
enum rigcal_store_limits {
    RIGCAL_STORE_CAMERAS_MAX = 65535,
    RIGCAL_STORE_HEADER_BYTES = 32
};
#define RIGCAL_STORE_SIZE_OF(n, real_bytes) \
    (RIGCAL_STORE_HEADER_BYTES + (n) * (16 + 45 * (real_bytes)))
#define RIGCAL_STORE_SIZE(n) RIGCAL_STORE_SIZE_OF(n, sizeof(rigcal_real))
RIGCAL_API size_t rigcal_store_size(size_t n_cameras);

/* Writes n_cameras >= 1 cameras in their order into the first *n_bytes =
 * rigcal_store_size(n_cameras) of bytes[capacity]. Refuses numbers that other functions
 * would refuse.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_ROTATION, ERR_RANGE (t, has_Sigma, a Sigma
 * that is no covariance, n_cameras), ERR_TOO_FEW (no camera), ERR_CAPACITY. */
RIGCAL_API rigcal_status rigcal_store_save(uint8_t bytes[], size_t capacity,
                                           size_t *n_bytes,
                                           const rigcal_mounted_camera cameras[],
                                           size_t n_cameras, uint32_t sequence,
                                           uint32_t tag);

/* Whether bytes[n_bytes] begin with a whole stored calibration, and which one. Bytes after
 * its end are not read. Time is linear in its bytes.
 * OK, ERR_NULL, ERR_FOREIGN (other bytes, erased flash among them), ERR_DAMAGED (also:
 * fewer bytes than it has), ERR_VERSION. */
RIGCAL_API rigcal_status rigcal_store_info(rigcal_saved_info *info, const uint8_t bytes[],
                                           size_t n_bytes);

/* Loads the cameras of such bytes into the first info->n_cameras of cameras[capacity], and
 * checks them as any input. A camera of a calibrated rig (rigcal_rig.h) gets its own
 * covariance. A build of the same precision loads what was saved, bit for bit. A build of
 * the other precision can load the bytes too: a float build rounds to nearest; a double
 * build makes rotations orthonormal to its own rounding. The statuses of
 * rigcal_store_info, ERR_CAPACITY, and ERR_NOT_FINITE (also: too large for a float build),
 * ERR_CAMERA, ERR_ROTATION, ERR_RANGE for numbers that rigcal_store_save would have
 * refused. */
RIGCAL_API rigcal_status rigcal_store_load(rigcal_mounted_camera cameras[], size_t capacity,
                                           rigcal_saved_info *info, const uint8_t bytes[],
                                           size_t n_bytes);

#ifdef __cplusplus
}
#endif

#include "rigcal_measure.h"
#include "rigcal_rig.h"
#include "rigcal_choose.h"
#include "rigcal_judge.h"
#include "rigcal_clocks.h"
#include "rigcal_faults.h"
#include "rigcal_consider.h"
#include "rigcal_point.h"
#include "rigcal_match.h"
#include "rigcal_monitor.h"
#include "rigcal_solvers.h"

#endif /* RIGCAL_H */
