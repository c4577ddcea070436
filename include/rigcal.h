/* rigcal.h - where each camera of a rig is, from a few points of known shape.
 *
 * This header is the manual: behaviour not written here is not promised.
 *
 *   frames     world or target (any origin), rig, camera: x right, y down,
 *              z forward along the optical axis; all right-handed
 *   b_from_a   takes coordinates in frame a to frame b:  X_b = R_ba X_a + t_ba.
 *              Chains read by eye:  c_from_a = c_from_b * b_from_a
 *   units      lengths in the caller's unit, one throughout; angles in radian;
 *              pixels with (0, 0) the centre of the top-left pixel
 *   range      coordinates and lengths within 1e30 / 1e9, pixels within 1e9, counts
 *              within 2^28; ERR_RANGE beyond, in every function that takes them
 *   storage    3 x 3 matrices row-major, vectors are columns
 *   arguments  outputs, then inputs, then counts and options; an output may not
 *              overlap an input or another output
 *   ownership  the caller owns every buffer; none is kept after the call, but
 *              for what a solver that was begun reads until it is done
 *   outcome    rigcal_status: 0 done; negative: failed, outputs untouched (work
 *              buffers may be); positive: outputs written and usable, with the
 *              caveat named
 *   arguments  are checked first, in every function: NULL, NaN, infinity and
 *   checked    numbers out of range have statuses of their own
 *   reentrant  no globals, no heap, no stdio, no errno; every loop is bounded
 *   accuracy   figures are for double / float: "1e-12 / 1e-4"
 *
 * Numbers in parentheses, (9) to (26), and letters are those of EQUATIONS.md.
 */
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
#define RIGCAL_VERSION_MINOR 1
#define RIGCAL_VERSION_PATCH 0

typedef int32_t rigcal_status;

enum {
    RIGCAL_OK = 0,

    /* Usable, with a caveat. */
    RIGCAL_RUNNING = 1,      /* a stepwise solver wants another step */
    RIGCAL_BUDGET_SPENT = 2, /* evaluations ran out first; best found so far */
    RIGCAL_DISCONNECTED = 3, /* some cameras share no placement with the first */
    RIGCAL_AMBIGUOUS = 4,    /* another pose fits nearly as well */
    RIGCAL_POOR_FIT = 5,     /* the error is too large for noise */
    RIGCAL_FEW_AGREE = 6,    /* so few observations agree that chance may do it */
    RIGCAL_VAGUE = 7,        /* the data hardly fix the pose */
    RIGCAL_UNSEEN_POINT = 8, /* the lens images no ray at a pixel; the point was left
                                out */
    RIGCAL_MOST_DISAGREE = 9,/* more observations disagree with the pose than agree */

    /* The arguments. */
    RIGCAL_ERR_NULL = -1,       /* a pointer that must not be NULL is */
    RIGCAL_ERR_NOT_FINITE = -2, /* an input is NaN or infinite */
    RIGCAL_ERR_RANGE = -3,      /* a count, option or number out of its range */
    RIGCAL_ERR_CAMERA = -4,     /* intrinsics: focal length or size not positive,
                                   lens unknown, a coefficient it has not */
    RIGCAL_ERR_ROTATION = -5,   /* a matrix is not a rotation to 1e-6 / 1e-3, a
                                   quaternion or a mean of rotations is no
                                   direction, or the matrix mirrors */
    RIGCAL_ERR_CAPACITY = -6,   /* a buffer of the caller's is too small */
    RIGCAL_ERR_STATE = -7,      /* a solver that was not begun, or not finished */

    /* The geometry. */
    RIGCAL_ERR_TOO_FEW = -8,     /* fewer points, views or pairs than unknowns */
    RIGCAL_ERR_COINCIDENT = -9,  /* fewer than three distinct points or rays */
    RIGCAL_ERR_COLLINEAR = -10,  /* all the points lie on one line */
    RIGCAL_ERR_EDGE_ON = -11,    /* all the rays lie in one plane */
    RIGCAL_ERR_PRECISION = -12,  /* the origin is so far away that rigcal_real
                                    cannot hold the shape: move it nearer */
    RIGCAL_ERR_NO_RAY = -13,     /* the lens model images no ray there */
    RIGCAL_ERR_BEHIND = -14,     /* a point is not in front of a camera */
    RIGCAL_ERR_WIDE_RAY = -15,   /* a ray 90 degrees or more off the axis has no
                                    (x, y, 1); a pose in a build without three
                                    points refuses one from 80 degrees on */
    RIGCAL_ERR_PARALLEL = -16,   /* rays (nearly) parallel: depth unknown */
    RIGCAL_ERR_EPIPOLE = -17,    /* the point is the image of the other camera's
                                    centre: every line through it matches */
    RIGCAL_ERR_OUTSIDE = -18,    /* the line does not cross the image */
    RIGCAL_ERR_DEGENERATE = -19, /* equations singular: no unique answer */
    RIGCAL_ERR_NO_POSE = -20,    /* no start led to a pose with every point in
                                    front: wrong correspondences or mirrored
                                    coordinates; seldom a search that missed */

    /* Stored bytes. */
    RIGCAL_ERR_DAMAGED = -21, /* incomplete, or altered since they were saved */
    RIGCAL_ERR_FOREIGN = -22, /* not a stored calibration */
    RIGCAL_ERR_VERSION = -23, /* whole, but of a form that this version of the
                                 library does not know */

    /* Wrong correspondences. */
    RIGCAL_ERR_NO_CONSENSUS = -24, /* no more observations agree on a pose than
                                     chance makes agree */

    /* A tag. */
    RIGCAL_ERR_MIRRORED = -25 /* what only a mirror shows: a tag from behind, corners
                                 in the other order */
};

/* MAJOR * 10000 + MINOR * 100 + PATCH of the linked library. */
RIGCAL_API int32_t rigcal_version(void);

/* 8 (double) or 4 (float): what the linked library calls rigcal_real. A caller
 * compiled otherwise must not go on. */
RIGCAL_API int32_t rigcal_sizeof_real(void);

/* The name of a status ("RIGCAL_ERR_NULL") and a sentence a person can act on.
 * Static, never NULL: a number that is no status gives "unknown status". */
RIGCAL_API const char *rigcal_status_name(rigcal_status status);
RIGCAL_API const char *rigcal_status_text(rigcal_status status);

/* One line of the library's own account of its public structs, for bindings that
 * cannot see the header: "rigcal_camera" with offset 0 and the struct's size, or
 * "rigcal_camera.fx" with the field's offset and size, in bytes. */
typedef struct {
    char name[48];
    int32_t offset;
    int32_t size;
} rigcal_layout_entry;

/* Line `index` of that account, 0 to rigcal_layout_count() - 1.
 * OK, ERR_NULL, ERR_RANGE (no such line). */
RIGCAL_API int32_t rigcal_layout_count(void);
RIGCAL_API rigcal_status rigcal_layout(rigcal_layout_entry *entry, int32_t index);

/* ==== rotation ============================================================
 *
 * Every function: OK, ERR_NULL, ERR_NOT_FINITE; those that take a rotation also
 * ERR_ROTATION. Rotations come out orthonormal to a few units in the last place.
 *
 * Yaw, pitch, roll compose as R = Rz(yaw) Ry(pitch) Rx(roll) (8). */

/* R[9] from ypr = (yaw, pitch, roll), any angles within 1e6 / 1e3, else
 * ERR_RANGE (beyond that the angle's own rounding is the larger error). */
RIGCAL_API rigcal_status rigcal_rotation_from_yaw_pitch_roll(
    rigcal_real R[9], const rigcal_real ypr[3]);

/* Yaw and roll in (-pi, pi], pitch in [-pi/2, pi/2]. At gimbal lock (|pitch| =
 * pi/2) yaw and roll turn about one axis: roll is given as 0. */
RIGCAL_API rigcal_status rigcal_yaw_pitch_roll_from_rotation(
    rigcal_real ypr[3], const rigcal_real R[9]);

/* Rotation vector w: the axis times the angle, right-handed (Rodrigues; OpenCV's
 * rvec). |w| <= 1e6 / 1e3, else ERR_RANGE. Back: |w| in [0, pi]. */
RIGCAL_API rigcal_status rigcal_rotation_from_vector(rigcal_real R[9],
                                                     const rigcal_real w[3]);
RIGCAL_API rigcal_status rigcal_vector_from_rotation(rigcal_real w[3],
                                                     const rigcal_real R[9]);

/* Quaternion (w, x, y, z), scalar first, of any length but zero (ERR_ROTATION);
 * R takes v to q v q*. Back: unit length, w >= 0. */
RIGCAL_API rigcal_status rigcal_rotation_from_quaternion(
    rigcal_real R[9], const rigcal_real q_wxyz[4]);
RIGCAL_API rigcal_status rigcal_quaternion_from_rotation(
    rigcal_real q_wxyz[4], const rigcal_real R[9]);

/* The rotation nearest to M in the sum of squared differences: the orthogonal
 * factor of its polar decomposition (Higham 1986). ERR_ROTATION when M is
 * singular to working precision or mirrors (det <= 0). At most 40 iterations, usually
 * 7 or fewer. */
RIGCAL_API rigcal_status rigcal_rotation_nearest(rigcal_real R[9],
                                                 const rigcal_real M[9]);

/* Angle of the rotation that takes Ra to Rb, [0, pi]; accurate for the smallest
 * angles too. */
RIGCAL_API rigcal_status rigcal_rotation_angle(rigcal_real *angle,
                                               const rigcal_real Ra[9],
                                               const rigcal_real Rb[9]);

/* ==== transform ===========================================================
 *
 * A rigid transform b_from_a: X_b = R X_a + t. Every function: OK, ERR_NULL,
 * ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE. */
typedef struct {
    rigcal_real R[9]; /* rotation, row by row */
    rigcal_real t[3]; /* origin of a in frame b */
} rigcal_transform;

RIGCAL_API rigcal_status rigcal_transform_compose(
    rigcal_transform *c_from_a, const rigcal_transform *c_from_b,
    const rigcal_transform *b_from_a);

RIGCAL_API rigcal_status rigcal_transform_invert(
    rigcal_transform *a_from_b, const rigcal_transform *b_from_a);

RIGCAL_API rigcal_status rigcal_transform_point(
    rigcal_real X_b[3], const rigcal_transform *b_from_a,
    const rigcal_real X_a[3]);

/* Where the camera is: its centre in the world, o_w = -R^T t. */
RIGCAL_API rigcal_status rigcal_camera_center(
    rigcal_real o_w[3], const rigcal_transform *cam_from_world);

/* (17), (18): camera b from camera a, when both know where one world is. The
 * answer does not depend on where that world has its origin. */
RIGCAL_API rigcal_status rigcal_relative_pose(
    rigcal_transform *b_from_a, const rigcal_transform *b_from_world,
    const rigcal_transform *a_from_world);

/* ==== camera ==============================================================
 *
 * Intrinsics, known beforehand. With (x, y) = (X, Y) / Z of a point in the
 * camera frame, r^2 = x^2 + y^2 and theta = angle off the optical axis:
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
 * A distortion polynomial turns back somewhere off the axis and images a second,
 * spurious ray on the same pixels. The lens is used only out to there: along each
 * straight line from the axis, as long as the Jacobian of (xd, yd) is positive
 * definite. Beyond, the answer is ERR_NO_RAY, never the other branch. */
enum { RIGCAL_LENS_BROWN = 0, RIGCAL_LENS_FISHEYE = 1 };

typedef struct {
    int32_t lens;          /* RIGCAL_LENS_ */
    int32_t width, height; /* pixels, 1 .. 1000000 */
    int32_t reserved;      /* 0 */
    rigcal_real fx, fy;    /* focal length, pixels, > 0 */
    rigcal_real cx, cy;    /* principal point, pixels */
    rigcal_real k1, k2, p1, p2, k3, k4, k5, k6; /* each within 1e9 */
} rigcal_camera;

/* A reference point and the pixel it was seen at. */
typedef struct {
    rigcal_real X_w[3];
    rigcal_real uv[2];
} rigcal_observation;

/* A reference point and the ray it was seen along, in the camera frame, of any
 * length but zero: what the solvers take, so that any lens serves. */
typedef struct {
    rigcal_real X_w[3];
    rigcal_real ray[3];
} rigcal_sighting;

/* Whether the intrinsics can be used. OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA.
 * All functions that take a camera check it so. */
RIGCAL_API rigcal_status rigcal_camera_check(const rigcal_camera *camera);

/* Pixel of a point in the camera frame, inside the image or not. ERR_BEHIND when
 * it is not in front (Brown: Z <= 0), ERR_NO_RAY when it lies beyond the lens's
 * turning point, ERR_DEGENERATE at the camera centre; and those of the check. One
 * proof, as below. */
RIGCAL_API rigcal_status rigcal_project(rigcal_real uv[2],
                                        const rigcal_camera *camera,
                                        const rigcal_real X_c[3]);

/* Unit ray imaged at a pixel: its projection is that pixel to 1e-9 px / 2e-3 px
 * (in an image of up to 4000 px; in float times the lens's magnification, where
 * that is above 1), or ERR_NO_RAY. A damped Newton iteration from
 * the axis, then a proof that the straight path to the answer does not cross the
 * turning point. At most 127 Newton solves of 60 steps, usually one of 3 to 6, and 7
 * proofs of 1024 steps, usually one of 1 to 3. */
RIGCAL_API rigcal_status rigcal_pixel_to_ray(rigcal_real ray[3],
                                             const rigcal_camera *camera,
                                             const rigcal_real uv[2]);

/* The pixel at which the same camera without distortion would see the ray of uv,
 * and back. Lines in space are straight there. ERR_NO_RAY as above;
 * ERR_WIDE_RAY for a fisheye's rays at 90 degrees and beyond. */
RIGCAL_API rigcal_status rigcal_undistort_pixel(rigcal_real uv_straight[2],
                                                const rigcal_camera *camera,
                                                const rigcal_real uv[2]);
RIGCAL_API rigcal_status rigcal_distort_pixel(rigcal_real uv[2],
                                              const rigcal_camera *camera,
                                              const rigcal_real uv_straight[2]);

/* Rays of n >= 1 observations (ERR_TOO_FEW for none). *bad (NULL: not wanted) is the
 * observation at fault, or -1. */
RIGCAL_API rigcal_status rigcal_sightings_from_observations(
    rigcal_sighting sightings[], int32_t *bad, const rigcal_camera *camera,
    const rigcal_observation observations[], size_t n);

/* Root mean square distance [px] of n >= 1 observed pixels from the projections
 * of their points: sqrt(sum(du^2 + dv^2) / n). `worst` (may be NULL) gets the
 * index of the largest. ERR_BEHIND, ERR_NO_RAY as rigcal_project; ERR_TOO_FEW. */
RIGCAL_API rigcal_status rigcal_reprojection_rms(
    rigcal_real *rms_px, int32_t *worst, const rigcal_camera *camera,
    const rigcal_transform *cam_from_world,
    const rigcal_observation observations[], size_t n);

/* ==== neldermead ==========================================================
 *
 * Minimises a function of 1 to 3 variables by the simplex method of Nelder and
 * Mead (1965) in the form of Lagarias et al. (1998), which fminsearch and SciPy
 * share: reflection 1, expansion 2, contraction 1/2, shrink 1/2. Knows nothing
 * of cameras. Evaluation by evaluation it does what
 * scipy.optimize.minimize(method='Nelder-Mead') does from the same simplex.
 *
 * Ask for the point to evaluate, tell its cost, until told to stop:
 *
 *     rigcal_neldermead_begin(&nm, x0, k, xtol, ftol, max_evals);
 *     while ((status = rigcal_neldermead_ask(x, &nm)) == RIGCAL_RUNNING)
 *         rigcal_neldermead_tell(&nm, cost(x));
 *
 * so there is no callback, and the search may pause at any evaluation.
 *
 * It stops when every vertex is within xtol of the best in every coordinate and
 * every cost within ftol of the best (both floored at a few roundings of the
 * best), or after max_evals. A cost of NaN or infinity is a place to move away
 * from. */
enum { RIGCAL_NELDERMEAD_DIM_MAX = 3 };

typedef struct {
    rigcal_real x[3], cost; /* of a simplex: the first k coordinates count */
} rigcal_vertex;

typedef struct {
    int32_t k, evals, max_evals;
    int32_t phase;       /* internal; 0: not begun */
    int32_t vertex_next; /* internal */
    int32_t status;      /* RUNNING, OK or BUDGET_SPENT */
    rigcal_real xtol, ftol;
    rigcal_vertex trial;     /* the point asked for */
    rigcal_vertex reflected; /* kept while an expansion is tried */
    rigcal_vertex vertex[4]; /* k + 1 of them, best first between iterations */
} rigcal_neldermead;

/* Starts from x0[k] with fminsearch's simplex: each coordinate in turn larger by
 * 5 %, or 0.00025 where it is zero. k 1 .. 3, tolerances >= 0, max_evals >= 1;
 * ERR_RANGE otherwise. OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE. */
RIGCAL_API rigcal_status rigcal_neldermead_begin(
    rigcal_neldermead *nm, const rigcal_real x0[], int32_t k, rigcal_real xtol,
    rigcal_real ftol, int32_t max_evals);

/* The same from a simplex of the caller's: k + 1 vertices of k coordinates. */
RIGCAL_API rigcal_status rigcal_neldermead_begin_simplex(
    rigcal_neldermead *nm, const rigcal_real simplex[], int32_t k,
    rigcal_real xtol, rigcal_real ftol, int32_t max_evals);

/* RUNNING: x[k] is the point to evaluate. OK, BUDGET_SPENT: done, x untouched.
 * ERR_NULL, ERR_STATE (not begun). */
RIGCAL_API rigcal_status rigcal_neldermead_ask(rigcal_real x[],
                                               const rigcal_neldermead *nm);

/* The cost of the point asked for. Returns what the next ask will, or ERR_STATE
 * when none was asked for. */
RIGCAL_API rigcal_status rigcal_neldermead_tell(rigcal_neldermead *nm,
                                                rigcal_real cost);

/* At most `budget` >= 1 evaluations of `cost` (ERR_NULL if NULL), for callers
 * who prefer a callback. RUNNING: call again. OK, BUDGET_SPENT, ERR_RANGE,
 * ERR_STATE. */
typedef rigcal_real (*rigcal_cost)(void *context, const rigcal_real x[]);
RIGCAL_API rigcal_status rigcal_neldermead_step(rigcal_neldermead *nm,
                                                rigcal_cost cost, void *context,
                                                int32_t budget);

/* The best vertex so far, at any time after the first cost was told: x[k], its
 * cost, evaluations spent (`cost` and `evals` may be NULL). The search's status,
 * ERR_NULL, ERR_STATE (too early), or ERR_NOT_FINITE (no vertex has a finite
 * cost). */
RIGCAL_API rigcal_status rigcal_neldermead_result(rigcal_real x[],
                                                  rigcal_real *cost,
                                                  int32_t *evals,
                                                  const rigcal_neldermead *nm);

/* ==== equations ===========================================================
 *
 * The calibration equations of the method, one by one, for those who study it,
 * teach it or build on it. The solver below uses these. */

/* Which Euler angle is found by linear algebra while the other two are searched.
 * The two that remain keep the order yaw, pitch, roll. */
enum {
    RIGCAL_YAW = 0,
    RIGCAL_PITCH = 1,
    RIGCAL_ROLL = 2,
    RIGCAL_BEST_CONDITIONED = 3 /* solver only: the one with the least cond(A) */
};

/* The equation of one pair of points (11)..(13): normal . R offset = 0. */
typedef struct {
    rigcal_real normal[3]; /* unit, of the plane of rays i and j: m_i x m_j */
    rigcal_real offset[3]; /* unit, X_i - X_j */
    int32_t i, j;          /* indices of the sightings */
} rigcal_pair;

/* Pairs enough for n sightings: 4 n, or all n (n - 1) / 2 where that is less. */
#define RIGCAL_PAIRS_FOR(n) ((n) <= 9 ? (n) * ((n)-1) / 2 : 4 * (n))
RIGCAL_API size_t rigcal_pairs_for(size_t n);

/* The pair (i, j); the other sightings are not read. ERR_COINCIDENT when the points, or
 * the rays, are the same to rounding: such a pair carries no equation. OK, ERR_NULL,
 * ERR_NOT_FINITE, ERR_RANGE (a ray of length zero; i, j not two different indices
 * below n). */
RIGCAL_API rigcal_status rigcal_pair_make(rigcal_pair *pair,
                                          const rigcal_sighting sightings[],
                                          size_t n, int32_t i, int32_t j);

/* Chooses pairs among n >= 3 sightings: all of them up to n = 9, else 4 n, every
 * point in about eight, spread by a fixed disorder so that runs repeat. Left out
 * are degenerate pairs and those whose rays lie closer than a sixth of the image
 * that the target fills, whose sine is mostly noise. The first two are well
 * conditioned for the published elimination by two pairs. A capacity below
 * rigcal_pairs_for(n) bounds memory at some accuracy, with few points at much:
 * fewer are chosen, still spread. A larger one changes nothing. Time O(n).
 *
 *   pairs     out   `capacity` entries, *n_pairs of them written; >= 3
 *   sightings in    n of them; every ray less than 90 degrees off the axis
 *
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE (ray of length zero, a coordinate
 * beyond 1e30 / 1e9, n above 2^28), ERR_TOO_FEW (n < 3), ERR_CAPACITY
 * (capacity < 3), ERR_WIDE_RAY, ERR_COINCIDENT, ERR_COLLINEAR, ERR_EDGE_ON,
 * ERR_PRECISION. */
RIGCAL_API rigcal_status rigcal_pairs_choose(rigcal_pair pairs[],
                                             size_t *n_pairs, size_t capacity,
                                             const rigcal_sighting sightings[],
                                             size_t n);

/* (13): sine-like residual e = normal . R offset of one pair.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE (the pair's vectors are
 * not of unit length, here and below). */
RIGCAL_API rigcal_status rigcal_pair_residual(rigcal_real *e,
                                              const rigcal_pair *pair,
                                              const rigcal_real R[9]);

/* (14): e = p cos w + q sin w + k for the eliminated angle w when the other two
 * are fixed. pqk[3] out. `eliminate` RIGCAL_YAW, _PITCH or _ROLL, else ERR_RANGE.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE. */
RIGCAL_API rigcal_status rigcal_pair_coefficients(rigcal_real pqk[3],
                                                  const rigcal_pair *pair,
                                                  int32_t eliminate,
                                                  const rigcal_real angles[2]);

typedef struct {
    rigcal_real angle;     /* eliminated angle w, (-pi, pi] */
    rigcal_real cosine, sine; /* solution of A (c, s)^T = b before normalising */
    rigcal_real condition; /* cond_2(A) */
    rigcal_real unit;      /* (15): c^2 + s^2 - 1 */
    rigcal_real residual;  /* the objective: |(15)| + sum |e| */
} rigcal_elimination;

/* (14), (15) and the objective of the two-angle search at one place.
 *
 *   pairs       n_pairs >= 3
 *   eliminating 2: A is of the first two pairs, the others are residuals
 *               (13c): the method as published. 0: A is of all pairs, by least
 *               squares, all are residuals: less noise in w for the same work
 *
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE, ERR_TOO_FEW, ERR_DEGENERATE (A
 * singular to rounding, by all pairs from cond(A) = 1e7 / 700 on; or c = s = 0).
 * Time O(n_pairs). */
RIGCAL_API rigcal_status rigcal_eliminate(rigcal_elimination *out,
                                          const rigcal_pair pairs[],
                                          size_t n_pairs, int32_t eliminating,
                                          int32_t eliminate,
                                          const rigcal_real angles[2]);

/* (5): sum |e| over n_pairs >= 3 pairs at ypr, the objective of the search over
 * all three angles. OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE, ERR_TOO_FEW. */
RIGCAL_API rigcal_status rigcal_three_angle_residual(rigcal_real *residual,
                                                     const rigcal_pair pairs[],
                                                     size_t n_pairs,
                                                     const rigcal_real ypr[3]);

/* (10a), (10b), (16): t of cam_from_world for a known rotation. By pairs: t_z is
 * the average over the pairs of (10a) and (10b) (coordinates that differ by less
 * than 1e-9 / 1e-4 are left out), t_x and t_y the average of (9) over the points.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE, ERR_ROTATION, ERR_TOO_FEW (n < 2, no
 * pairs), ERR_WIDE_RAY, ERR_DEGENERATE (nothing left to average). */
RIGCAL_API rigcal_status rigcal_translation_from_pairs(
    rigcal_real t[3], const rigcal_real R[9], const rigcal_sighting sightings[],
    size_t n, const rigcal_pair pairs[], size_t n_pairs);

/* The better one: least squares over all 2 n equations t_xy - u t_z = u q_z -
 * q_xy, q = R X, n >= 2. Statuses as above; ERR_DEGENERATE when all rays are the
 * same. */
RIGCAL_API rigcal_status rigcal_translation_least_squares(
    rigcal_real t[3], const rigcal_real R[9], const rigcal_sighting sightings[],
    size_t n);

/* ==== paper ===============================================================
 *
 * Where one camera is, by the published procedure: Nelder-Mead over two angles
 * with the third eliminated (14), (15), or over three (5), (6); translation by
 * least squares (16). */
typedef struct {
    int32_t angles;      /* 2 (default) or 3: how many are searched; 3 needs a
                            guess */
    int32_t eliminate;   /* RIGCAL_BEST_CONDITIONED (default), _YAW, .. */
    int32_t eliminating; /* pairs that eliminate: 0 all (default), 2 as published */
    int32_t use_guess;   /* 1: from guess_ypr, a local search. 0 (default): from
                            a fixed grid of the two angles, no guess needed */
    int32_t max_evals;   /* over all starts: 0 for 1000 with a guess, 3952
                            without; >= 1 with a guess, >= 192 without */
    int32_t reserved;    /* 0 */
    rigcal_real guess_ypr[3]; /* yaw, pitch, roll of cam_from_world; the
                                 eliminated one is not used */
    rigcal_real xtol;    /* radian; 0: 1e-10 / 1e-5 */
    rigcal_real ftol;    /* of the objective; 0: 1e-10 / 1e-5 */
} rigcal_paper_options;

typedef struct {
    rigcal_transform cam_from_world;
    rigcal_real ypr[3];    /* yaw, pitch, roll of its rotation */
    rigcal_real residual;  /* the objective at the answer: sum of sines */
    rigcal_real condition; /* cond(A) at the answer; 0 with three angles */
    rigcal_real rms;       /* root mean square distance of the projected from the
                              observed normalised image points (x, y) */
    int32_t eliminated;    /* RIGCAL_YAW, _PITCH, _ROLL; -1 with three angles */
    int32_t evals;         /* evaluations of the objective, all starts */
    int32_t starts;        /* simplex searches run */
    int32_t reserved;
} rigcal_paper_pose;

enum { RIGCAL_PAPER_SEEDS = 24 };

/* A search under way. Flat and copyable; its fields are internal. */
typedef struct {
    const rigcal_sighting *sightings;
    const rigcal_pair *pairs;
    size_t n, n_pairs;
    rigcal_paper_options options;
    rigcal_neldermead nm;
    rigcal_paper_pose best;
    rigcal_real least_condition, seed_cost[RIGCAL_PAPER_SEEDS];
    int32_t seed_node[RIGCAL_PAPER_SEEDS];
    int32_t phase, next, eliminate, found, behind, evals, starts, spent;
} rigcal_paper_solver;

/* All defaults. OK, ERR_NULL. */
RIGCAL_API rigcal_status rigcal_paper_defaults(rigcal_paper_options *options);

/* Begins a search over pairs chosen by rigcal_pairs_choose or by the caller.
 * `sightings` and `pairs` are read until the search is done, so they must stay;
 * n >= 3, n_pairs >= 3. options NULL: all defaults.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE, ERR_TOO_FEW, ERR_WIDE_RAY. */
RIGCAL_API rigcal_status rigcal_paper_begin(rigcal_paper_solver *solver,
                                            const rigcal_sighting sightings[],
                                            size_t n, const rigcal_pair pairs[],
                                            size_t n_pairs,
                                            const rigcal_paper_options *options);

/* Spends at most `budget` >= 1 units: an evaluation, O(n_pairs), of which there are at
 * most max_evals; the pose where a start has ended, O(n_pairs + n), of at most 25; or the
 * condition of one of the three eliminations. RUNNING: call again. OK, BUDGET_SPENT: ask
 * for the result. The same bits come out whatever the budgets. ERR_NULL, ERR_RANGE,
 * ERR_STATE; when it ends without a pose, ERR_NO_POSE or ERR_BEHIND. */
RIGCAL_API rigcal_status rigcal_paper_step(rigcal_paper_solver *solver,
                                           int32_t budget);

/* The best pose of a search that is done, with every point in front.
 * OK, BUDGET_SPENT, ERR_NULL, ERR_STATE (not begun or still running),
 * ERR_BEHIND (the guess led to a pose that fits with points behind the camera:
 * the mirror solution), ERR_NO_POSE. */
RIGCAL_API rigcal_status rigcal_paper_result(rigcal_paper_pose *pose,
                                             const rigcal_paper_solver *solver);

/* begin, step to the end, result. */
RIGCAL_API rigcal_status rigcal_paper_solve(rigcal_paper_pose *pose,
                                            const rigcal_sighting sightings[],
                                            size_t n, const rigcal_pair pairs[],
                                            size_t n_pairs,
                                            const rigcal_paper_options *options);

/* ==== pose ================================================================
 *
 * One camera's pose from n >= 3 observations and nothing else: no guess. The
 * direction of the optical axis is searched on the whole sphere, yaw and
 * translation being eliminated together (EQUATIONS.md A); each optimum is then
 * refined to the maximum-likelihood pose, the least squares of the reprojection
 * error in pixels through the full lens model (B).
 *
 * A flat target seen from afar has two optima that fit nearly alike (C): all that
 * were found are returned, best first, and the status tells when the first is not
 * sure. Three points have up to four poses that fit exactly (D), and nothing in them
 * tells which is right. Where noise has made two of these one, a minimum is left that does
 * not fit exactly. It is returned besides exact poses only if sigma_px is given.
 *
 * Points of a pinhole may be up to 89 degrees off its axis, those of a fisheye as far as
 * its lens goes. Where one is more than 60 degrees off, or 80 off the middle of the
 * target's image, poses of three points are tried too, or instead, and refinement begins
 * with errors along the rays (B).
 *
 * Where no noise is stated, some is assumed, in pixels. The unit of uv is a pixel, if fx
 * is 28 or more. For shorter ones, as of normalised images, a pixel is fx^2 / 800. */
enum { RIGCAL_POSES_MAX = 4, RIGCAL_POSE_SEEDS = 3 };

typedef struct {
    rigcal_transform cam_from_world;
    rigcal_real sse;         /* sum of |du|^2 / sigma_i^2 over the points; px^2
                                where no sigma is given */
    rigcal_real rms_px;      /* reprojection error: root mean square a point */
    rigcal_real probability; /* that this is the right one of those found, for
                                normal noise; over all found they sum to 1 */
} rigcal_pose;

typedef struct {
    int32_t use_start; /* 1: `start` is a previous pose, and the only seed unless
                          it proves bad; only the optimum near it is returned.
                          0 (default) */
    rigcal_real sigma_px; /* noise of one coordinate of a pixel (times sigma_i
                             where those are given), when known: then the fit is
                             judged by it; 1e-6 .. 1e6. 0 (default):
                             unknown, at least 0.01 px, and integrated over */
    rigcal_transform start;
} rigcal_pose_options;

/* Internal: a lens as its map of the plane, N(s) / D(s) x + 2 (q.x) x + q s. */
typedef struct {
    int32_t is_fisheye, is_pinhole;
    rigcal_real N[5], D[4], q[2];
} rigcal_lens;

/* Internal: what is fitted. The points count from `origin`. */
typedef struct {
    const rigcal_camera *camera;
    const rigcal_observation *observations;
    const rigcal_real *sigma;
    const uint8_t *mask;
    size_t n;
    int32_t is_mirrored, left_out;
    rigcal_real pixel, nothing, origin[3];
    rigcal_lens lens;
} rigcal_fit;

/* Internal: sums over the points from which the cost of a direction follows. */
typedef struct {
    rigcal_real weight, S, u_mean[2], V_mean[2][3], h[3], Q[6], C[6], G[2][6];
} rigcal_view_moments;

/* Internal: a refinement under way. */
typedef struct {
    int32_t evals, is_stale, curvature, status;
    rigcal_real sse, last_gain, lambda;
    rigcal_transform cam_from_points;
    rigcal_real g[6], H[21];
} rigcal_refinement;

/* Internal: a descent under way, near the direction m3. */
typedef struct {
    rigcal_real m3[3];
    rigcal_neldermead nm;
} rigcal_descent;

/* Internal: the first three different points and their rays; `count`, how many different
 * ones there are, 4 for more. */
typedef struct {
    int32_t index[3], count;
    rigcal_real ray[3][3];
} rigcal_pose_triple;

/* Internal: a refined pose, of the camera from the points' own origin; the third row of
 * its rotation is the cross product of these two. */
typedef struct {
    rigcal_real rows[6], t[3], sse;
} rigcal_pose_optimum;

/* Internal: where the seeds of a search come from, its best directions first, by their
 * numbers in the lattice. */
typedef struct {
    int32_t index[RIGCAL_POSE_SEEDS], reserved;
    rigcal_real least_cost, azimuth[2], cost[RIGCAL_POSE_SEEDS];
    rigcal_view_moments moments;
} rigcal_pose_lattice;

/* A search under way. Flat and copyable; its fields are internal. */
typedef struct {
    int32_t phase, next, n_seeds, n_exact, n_found, is_flat, is_plane, leans,
        failure, bad, is_warm, point, is_mirrored, is_vague, is_unfinished,
        is_wide, picks;
    size_t n, n_used;
    rigcal_real extent_px, scale, sigma_px, axis[3], normal[3];
    rigcal_fit fit;
    union {
        rigcal_pose_lattice lattice;
        rigcal_transform exact[RIGCAL_POSES_MAX];
    } from;
    union {
        rigcal_pose_triple triple;
        rigcal_descent descent;
        rigcal_refinement fit;
    } work;
    rigcal_pose_optimum found[RIGCAL_POSES_MAX];
} rigcal_pose_solver;

/* All defaults. OK, ERR_NULL. */
RIGCAL_API rigcal_status rigcal_pose_defaults(rigcal_pose_options *options);

/* Begins a search. `camera`, `observations` and `sigma` are read until its result has
 * been asked for, so they must stay. Looks at every number once, and at no ray but one:
 * time O(n), about that of an evaluation.
 *
 *   bad      out  the observation at fault, or -1; NULL: not wanted
 *   sigma    in   n standard deviations of the observations relative to each
 *                 other, 1e-6 .. 1e6; NULL: all equal
 *   options  in   NULL: all defaults
 *
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_RANGE, ERR_ROTATION (of start),
 * ERR_TOO_FEW (n < 3), ERR_COINCIDENT, ERR_PRECISION. */
RIGCAL_API rigcal_status rigcal_pose_begin(
    rigcal_pose_solver *solver, int32_t *bad, const rigcal_camera *camera,
    const rigcal_observation observations[], const rigcal_real sigma[], size_t n,
    const rigcal_pose_options *options);

/* Spends at most `budget` >= 1 units. RUNNING: call again; the same bits come out whatever
 * the budgets. OK: ask for the result. ERR_NULL, ERR_RANGE, ERR_STATE.
 *
 *   a unit is                                    of one search, at most    usually
 *   the ray of one point (of 16 of a pinhole)    n; 2 n if one is unseen   n
 *   a direction's cost, the equations of a       900 (wide: 2000)          50 to 70
 *     refinement, O(n), or the next start                                  (wide: 150)
 *   the proof that a lens with distortion sees   7 n                       n to 2 n
 *     one point where an optimum puts it
 *
 * The first equations of a refinement of a wide target take the rays of all points too. */
RIGCAL_API rigcal_status rigcal_pose_step(rigcal_pose_solver *solver,
                                          int32_t budget);

/* The optima of a search that is done, best first: the first *n_found of
 * poses[capacity], capacity >= 1. *bad (NULL: not wanted) is the observation at fault, or
 * -1. The first status that applies:
 *
 * RIGCAL_POOR_FIT: the error is larger than noise of sigma_px causes once in a million
 *     fits: wrong correspondences, target or intrinsics. Where no sigma_px was given, of
 *     noise of 2 px, or of 0.7 % of the image's extent where that is more. Or mirrored
 *     points (left-handed coordinates, an image with v upwards) would be a hundred times
 *     as likely, unless the target is flat or wide.
 * RIGCAL_BUDGET_SPENT: the refinement of the first pose ran out of evaluations.
 * RIGCAL_VAGUE: the data hardly fix the first pose: the standard deviation of its rotation
 *     is above 0.25 rad for noise of sigma_px or, if that is not given, for the noise
 *     that its error shows, but at least 0.25 px.
 * RIGCAL_AMBIGUOUS: another pose fits nearly as well: see `probability`. A target seen
 *     exactly edge-on has a flipped twin that fits alike.
 * RIGCAL_UNSEEN_POINT: the lens images no ray at the pixel of point *bad. The poses are
 *     those of the other points.
 * OK: the first pose is right with probability 0.99 or more.
 *
 * All these poses are finite, R a rotation to rounding, every point in front of the camera
 * and within its lens.
 *
 * ERR_NULL, ERR_RANGE, ERR_STATE, ERR_NO_POSE, ERR_DEGENERATE (the observations do not fix
 * the pose). A search, which is not run where `start` fits, can also return ERR_NO_RAY
 * (two pixels or more have no ray; *bad is the second), ERR_COINCIDENT (fewer than three
 * different points), ERR_COLLINEAR, and in a build without three points ERR_WIDE_RAY. */
RIGCAL_API rigcal_status rigcal_pose_result(rigcal_pose poses[], size_t *n_found,
                                            size_t capacity, int32_t *bad,
                                            const rigcal_pose_solver *solver);

/* begin, step to the end, result. */
RIGCAL_API rigcal_status rigcal_solve_pose(
    rigcal_pose poses[], size_t *n_found, size_t capacity, int32_t *bad,
    const rigcal_camera *camera, const rigcal_observation observations[],
    const rigcal_real sigma[], size_t n, const rigcal_pose_options *options);

/* How far a pose can be trusted. */
typedef struct {
    rigcal_real Sigma[36];    /* covariance of (w, dt), row by row, for
                                 R <- exp([w]x) R, t <- t + dt: w [rad] and dt
                                 along the camera's axes */
    rigcal_real rotation[3];  /* 1-sigma of w */
    rigcal_real translation[3]; /* 1-sigma of t */
    rigcal_real center[3];    /* 1-sigma of the camera's centre, world axes */
    rigcal_real sigma_px;     /* the noise it was reckoned with */
} rigcal_pose_uncertainty;

/* The covariance sigma_px^2 (J^T J)^-1 at a pose, which is the Cramer-Rao bound at
 * the true one. sigma_px 0: estimated, sqrt(sse / (2 n - 6)), which needs n >= 4.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_ROTATION, ERR_RANGE, ERR_TOO_FEW
 * (n < 3, or n = 3 without sigma_px), ERR_BEHIND, ERR_NO_RAY, ERR_DEGENERATE. */
RIGCAL_API rigcal_status rigcal_pose_covariance(
    rigcal_pose_uncertainty *out, const rigcal_camera *camera,
    const rigcal_transform *cam_from_world,
    const rigcal_observation observations[], const rigcal_real sigma[], size_t n,
    rigcal_real sigma_px);

/* ==== tag =================================================================
 *
 * The commonest case: one square tag. Its frame has the origin in the middle, x to the
 * right and y up as it is read, z out of it, towards who reads it; the unit is that of
 * `size`, the length of its edge.
 *
 *   uv   in   its corners, as pixels: top left, top right, bottom right, bottom left as
 *             it is read (ArUco's order; AprilTag's p[3], p[2], p[1], p[0])
 *
 * Only poses that see its front are returned, at most two as a rule, best first; the
 * rest is as of rigcal_solve_pose with these four points. Its statuses, ERR_RANGE (size
 * not above 0) and ERR_MIRRORED: the corners run the wrong way round. */
RIGCAL_API rigcal_status rigcal_solve_tag(
    rigcal_pose cams_from_tag[], size_t *n_found, size_t capacity, int32_t *bad,
    const rigcal_camera *camera, const rigcal_real uv[8], rigcal_real size,
    const rigcal_pose_options *options);

/* ==== robust ==============================================================
 *
 * One camera's pose from observations some of which are wrong: another point's
 * pixel, or none's. Poses of three points each (D) are tried, from all triples or from
 * random ones, and scored by all the points. The last word has rigcal_solve_pose on
 * the points that agree with the best, which are chosen anew until they stay. The same
 * input and seed give the same bits. */
typedef struct {
    rigcal_real threshold_px; /* a point farther than this from its projection is
                                 wrong (times sigma_i where those are given);
                                 1e-6 .. 1e6. 0 (default): 4 sigma_px, or 3 pixels */
    rigcal_real sigma_px;     /* as in rigcal_pose_options */
    int32_t samples;          /* at most so many triples; all of them when there are
                                 no more. 500 (default), 1 .. 100000 */
    uint32_t seed;            /* of the random triples. 1 (default) */
} rigcal_robust_options;

/* Internal: the best pose of three points so far, and the rays and poses of one triple. */
typedef struct {
    rigcal_transform best, tried[4];
    rigcal_real ray[3][3], cost;
} rigcal_robust_poses;

/* A search under way. Flat and copyable; its fields are internal. */
typedef struct {
    const rigcal_camera *camera;
    const rigcal_observation *observations;
    const rigcal_real *sigma;
    uint8_t *inliers;
    size_t n, n_agree;
    union {
        rigcal_robust_poses some;
        rigcal_pose_solver pose;
    } work;
    rigcal_real origin[3], sigma_px, threshold_px, missed, area_px2;
    uint32_t random;
    int32_t sample[3], samples, tried, is_complete, phase, next, n_poses, rounds, failure;
} rigcal_robust_solver;

/* All defaults. OK, ERR_NULL. */
RIGCAL_API rigcal_status rigcal_robust_defaults(rigcal_robust_options *options);

/* As rigcal_pose_begin; `inliers`, n bytes, is written until the search is done, so
 * it must stay too, and holds nothing of use before, or after a failure.
 *
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_RANGE, ERR_TOO_FEW (n < 5),
 * ERR_COINCIDENT, ERR_COLLINEAR, ERR_PRECISION. */
RIGCAL_API rigcal_status rigcal_robust_begin(
    rigcal_robust_solver *solver, uint8_t inliers[], int32_t *bad,
    const rigcal_camera *camera, const rigcal_observation observations[],
    const rigcal_real sigma[], size_t n, const rigcal_robust_options *options);

/* Spends at most `budget` >= 1 units: the ray of one point of a triple (of a pinhole all
 * three), one of its poses scored by all points, the choice of those that agree, or a
 * unit of rigcal_pose_step. Each O(n); of a triple at most 7 (a pinhole: 5), and those of
 * nine searches, which without rays and proofs are 9000. RUNNING: call again; the same
 * bits come out whatever the budgets. OK: ask for the result. ERR_NULL, ERR_RANGE,
 * ERR_STATE. */
RIGCAL_API rigcal_status rigcal_robust_step(rigcal_robust_solver *solver,
                                            int32_t budget);

/* As rigcal_pose_result, of the *n_inliers points that agree: those whose byte of
 * `inliers` is 1, not 0. The first status that applies:
 *
 * RIGCAL_FEW_AGREE: so few agree that with all points wrong it would happen more than
 *     once in a thousand times: do not trust the pose without another reason.
 * RIGCAL_POOR_FIT, _BUDGET_SPENT, _VAGUE, _AMBIGUOUS: as there, of these points.
 * RIGCAL_MOST_DISAGREE: fewer than half of all points agree. The pose is no chance, but may
 *     be that of a part of the target, as of a grid shifted by one square.
 * OK.
 * ERR_NO_CONSENSUS: no more agree than chance makes agree.
 * ERR_NULL, ERR_RANGE, ERR_STATE, ERR_NO_POSE, ERR_DEGENERATE, and what begin and
 * rigcal_pose_begin say of the points that agree. */
RIGCAL_API rigcal_status rigcal_robust_result(rigcal_pose poses[], size_t *n_found,
                                              size_t *n_inliers, size_t capacity,
                                              const rigcal_robust_solver *solver);

/* begin, step to the end, result. */
RIGCAL_API rigcal_status rigcal_solve_pose_robust(
    rigcal_pose poses[], size_t *n_found, uint8_t inliers[], size_t *n_inliers,
    size_t capacity, int32_t *bad, const rigcal_camera *camera,
    const rigcal_observation observations[], const rigcal_real sigma[], size_t n,
    const rigcal_robust_options *options);

/* ==== diagnose ============================================================
 *
 * What is wrong with observations that fit badly. Each function solves some poses of the
 * n points in one call: one, two for the mirrored target and image, and one for each point
 * that is left out in turn. Of more than RIGCAL_BLAME_TRIES points only those farthest
 * from their projections are left out. The stack does not grow with n. */
enum { RIGCAL_BLAME_TRIES = 64 };

enum {
    RIGCAL_BLAME_NONE = 0,   /* no point stands out */
    RIGCAL_BLAME_LIKELY = 1, /* one does, but chance, or another point, may be it */
    RIGCAL_BLAME_SURE = 2    /* chance 0.01 or less, probability 0.99 or more */
};

typedef struct {
    int32_t verdict;            /* RIGCAL_BLAME_ */
    int32_t point;              /* without which the rest agree best; -1 when no
                                   rest has a pose */
    int32_t is_rest_poor;       /* 1: the rest are RIGCAL_POOR_FIT too */
    int32_t reserved;           /* 0 */
    rigcal_real rms_px;         /* of all points; -1: they have no pose */
    rigcal_real rms_without_px; /* without that point */
    rigcal_real chance;         /* that noise alone does as much for the best of n
                                   points: an F test of 2 and 2 n - 8 degrees of
                                   freedom, or chi squared where sigma_px is given;
                                   an upper bound, at most 1 */
    rigcal_real probability;    /* that it is this point, if it is one of them (C) */
} rigcal_blame;

/* Which one of n >= 5 points to blame for a bad fit. rms_without[i] is the rms without
 * point i [px], -1 where the rest has no pose or i was not left out; NULL: not wanted.
 * Noise is integrated over or, better, stated in the options. Of five points the four
 * left have two degrees of freedom: unless the noise is stated, an error of 60 times the
 * noise is surely blamed less than half of the time.
 *
 * OK, ERR_NULL, and those of rigcal_pose_begin; ERR_TOO_FEW (n < 5). */
RIGCAL_API rigcal_status rigcal_blame_point(
    rigcal_blame *blame, rigcal_real rms_without[], const rigcal_camera *camera,
    const rigcal_observation observations[], const rigcal_real sigma[], size_t n,
    const rigcal_pose_options *options);

enum {
    RIGCAL_DIAGNOSIS_CONSISTENT = 0,  /* the fit is not RIGCAL_POOR_FIT */
    RIGCAL_DIAGNOSIS_UNITS = 1,       /* the same, but the length of t is not that of
                                         the previous pose, by a factor of units */
    RIGCAL_DIAGNOSIS_ONE_POINT = 2,   /* one point is wrong: see blame */
    RIGCAL_DIAGNOSIS_MIRRORED = 3,    /* the target's coordinates are left-handed, or
                                         the image is mirrored or v counts upwards,
                                         which make nearly the same image: so fitted,
                                         the data are a thousand times likelier */
    RIGCAL_DIAGNOSIS_UNEXPLAINED = 4  /* poor, and none of these */
};

typedef struct {
    int32_t verdict;             /* RIGCAL_DIAGNOSIS_ */
    int32_t is_handed;           /* 1: the data tell that nothing is mirrored, or
                                    that something is; 0: they fit nearly alike
                                    mirrored, as those of a flat target always do,
                                    and of any far away */
    rigcal_real rms_mirrored_px; /* of the target mirrored, Z to -Z; -1: no pose */
    rigcal_real rms_flipped_px;  /* of the image flipped, v to height - 1 - v */
    rigcal_real units;           /* 10, 25.4, 100, 1000 or the inverse of one of
                                    these: about the length of t found over that of
                                    the previous pose. 0: no such factor, or no pose */
    rigcal_blame blame;
} rigcal_diagnosis;

/* Whether the fit of n >= 5 points is consistent and, if not, what would make it so. With
 * options->use_start, `start` is a previous pose in the right units; it is used for
 * nothing else. rms_without as in rigcal_blame_point. OK and as rigcal_blame_point. */
RIGCAL_API rigcal_status rigcal_diagnose_pose(
    rigcal_diagnosis *diagnosis, rigcal_real rms_without[],
    const rigcal_camera *camera, const rigcal_observation observations[],
    const rigcal_real sigma[], size_t n, const rigcal_pose_options *options);

/* ==== measure =============================================================
 *
 * Depths count in lengths of the ray that is handed in: with m = (x, y, 1) the
 * number is Z, with a unit ray it is the distance. */

/* (22)..(24): depths of one point along its rays in two cameras, by least
 * squares on depth_b ray_b = depth_a R ray_a + t, and the distance by which the
 * rays miss each other there.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE (ray of length zero),
 * ERR_PARALLEL (rays within 0.1 degree), ERR_BEHIND (the rays meet behind). */
RIGCAL_API rigcal_status rigcal_depth_two_views(
    rigcal_real depth_ab[2], rigcal_real *miss, const rigcal_transform *b_from_a,
    const rigcal_real ray_a[3], const rigcal_real ray_b[3]);

/* (19), (20): aligned stereo, the right camera at (baseline, 0, 0) of the left,
 * both looking the same way. X_left[3] from normalised points (x, y).
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE (baseline <= 0), ERR_PARALLEL (no
 * disparity), ERR_BEHIND (negative disparity). */
RIGCAL_API rigcal_status rigcal_depth_aligned(rigcal_real X_left[3],
                                              rigcal_real baseline,
                                              const rigcal_real xy_left[2],
                                              const rigcal_real xy_right[2]);

typedef struct {
    rigcal_real X[3];     /* in the frame the cameras' poses start from */
    rigcal_real Sigma[9]; /* its covariance for the sigma_px given */
    rigcal_real rms_px;   /* sqrt(sum(du^2 + dv^2) / n) */
} rigcal_point;

/* A point from n >= 2 views: least squares of the pixel distances through the
 * full lens models (Gauss-Newton with step control: at most 100 evaluations, usually 2 to
 * 8), from the point nearest to all the rays.
 * sigma_px > 0: noise of one coordinate.
 *
 *   cameras, cams_from_world, uv   in   n of each, uv as n pairs
 *
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_ROTATION, ERR_RANGE, ERR_TOO_FEW,
 * ERR_NO_RAY, ERR_PARALLEL, ERR_BEHIND. */
RIGCAL_API rigcal_status rigcal_triangulate(
    rigcal_point *point, const rigcal_camera cameras[],
    const rigcal_transform cams_from_world[], const rigcal_real uv[], size_t n,
    rigcal_real sigma_px);

/* (25), (26): the matching line (epipolar line) in camera b of what camera a sees
 * along ray_a: alpha x + beta y + gamma = 0 in normalised coordinates of b,
 * alpha^2 + beta^2 = 1, so the left side is a signed distance.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE (ray of length zero),
 * ERR_EPIPOLE (also when the centres of a and b coincide), ERR_OUTSIDE (the plane
 * through the line holds nothing in front of b: the line is at infinity). */
RIGCAL_API rigcal_status rigcal_epiline(rigcal_real line[3],
                                        const rigcal_transform *b_from_a,
                                        const rigcal_real ray_a[3]);

/* The same line in pixels of camera b without distortion (as
 * rigcal_undistort_pixel gives), again with alpha^2 + beta^2 = 1: distances are
 * pixels. And ERR_CAMERA. */
RIGCAL_API rigcal_status rigcal_epiline_px(rigcal_real line_px[3],
                                           const rigcal_camera *camera_b,
                                           const rigcal_transform *b_from_a,
                                           const rigcal_real ray_a[3]);

/* Signed distance [px], in undistorted pixels, of the observed (distorted) pixel
 * uv_b from such a line. OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_NO_RAY,
 * ERR_WIDE_RAY, ERR_RANGE (alpha^2 + beta^2 is not 1). */
RIGCAL_API rigcal_status rigcal_epiline_distance(rigcal_real *distance_px,
                                                 const rigcal_real line_px[3],
                                                 const rigcal_camera *camera_b,
                                                 const rigcal_real uv_b[2]);

/* The part of a line that lies in the rectangle of the image, pixel borders
 * included: -0.5 <= u <= width - 0.5, v alike; sizes 1 .. 1000000. ends = (u1, v1, u2,
 * v2), in the direction (beta, -alpha).
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE, ERR_OUTSIDE. */
RIGCAL_API rigcal_status rigcal_epiline_clip(rigcal_real ends[4],
                                             const rigcal_real line_px[3],
                                             int32_t width, int32_t height);

/* Where along the line the match can be, its depth along ray_a being between
 * near > 0 and far > near: undistorted pixels of both, ends = (u, v at near, u, v
 * at far). OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_CAMERA, ERR_RANGE,
 * ERR_WIDE_RAY (one of them is not in front of camera b). */
RIGCAL_API rigcal_status rigcal_epiline_segment(
    rigcal_real ends[4], const rigcal_camera *camera_b,
    const rigcal_transform *b_from_a, const rigcal_real ray_a[3],
    rigcal_real near_a, rigcal_real far_a);

/* The same as it runs in the real, distorted image, where it is a curve:
 * `count` >= 2 pixels at depths from near to far, evenly spaced in 1 / depth,
 * which is nearly evenly in the image. Those that camera b cannot see, being
 * behind it or beyond its lens, are left out: uv_b holds *n_written pairs.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_CAMERA, ERR_RANGE, ERR_OUTSIDE
 * (none left). */
RIGCAL_API rigcal_status rigcal_epiline_curve(
    rigcal_real uv_b[], int32_t *n_written, int32_t count,
    const rigcal_camera *camera_b, const rigcal_transform *b_from_a,
    const rigcal_real ray_a[3], rigcal_real near_a, rigcal_real far_a);

/* ==== rig ================================================================= */

/* The mean of n >= 1 estimates of one transform: the rotation that minimises the
 * weighted sum of squared angles (Karcher mean, from the chordal mean; Hartley et
 * al. 2013; at most 20 iterations), and the weighted mean of t. weight NULL: all
 * equal; else each >= 0, not all 0. sigma_rad, sigma_t (may be NULL): weighted
 * root mean square deviation of the estimates, as an angle and as a length.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION (also when they cancel), ERR_RANGE,
 * ERR_TOO_FEW. */
RIGCAL_API rigcal_status rigcal_transform_mean(
    rigcal_transform *mean, rigcal_real *sigma_rad, rigcal_real *sigma_t,
    const rigcal_transform transforms[], const rigcal_real weight[], size_t n);

/* One camera's pose against one placement of the target. */
typedef struct {
    rigcal_transform cam_from_target;
    rigcal_real weight; /* > 0; e.g. the number of points */
    int32_t camera;     /* 0 .. n_cameras - 1 */
    int32_t placement;  /* >= 0; equal numbers saw the target in one place */
} rigcal_view;

/* Puts n_cameras cameras into the frame of camera 0: from the poses to common
 * placements (17), (18), averaged over placements; a camera that shares none with
 * camera 0 is joined through others that do, the best-shared first. A placement
 * counts by both its weights, w and W, as 1 / (1/w + 1/W).
 *
 *   cams_from_rig  out   n_cameras; the rig frame is camera 0's
 *   group          out   n_cameras; the number of the group a camera connects
 *                        in, counted from 0 in the order of their first cameras:
 *                        0 is camera 0's. Cameras of another group stand in the
 *                        frame of the first camera of their own group
 *   views          in    n_views, in any order
 *   work           work  n_views transforms
 *   weight         work  n_views
 *
 * OK, RIGCAL_DISCONNECTED, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE,
 * ERR_TOO_FEW (no camera). ERR_ROTATION also when the poses contradict each other
 * so far that they have no mean; the outputs are then undefined.
 * Time O(n_cameras^2 n_views^2), stack constant. */
RIGCAL_API rigcal_status rigcal_rig_join(
    rigcal_transform cams_from_rig[], int32_t group[], size_t n_cameras,
    const rigcal_view views[], size_t n_views, rigcal_transform work[],
    rigcal_real weight[]);

/* Where a placement of the target is in the rig: the mean over the cameras that
 * saw it. n_views and work as above; only views of `placement` by cameras of
 * `in_group` count; ERR_TOO_FEW when there is none. */
RIGCAL_API rigcal_status rigcal_rig_place(
    rigcal_transform *rig_from_target, int32_t placement, int32_t in_group,
    const rigcal_transform cams_from_rig[], const int32_t group[],
    size_t n_cameras, const rigcal_view views[], size_t n_views,
    rigcal_transform work[], rigcal_real weight[]);

/* Section VI-C: how far a point measured at X_a can be off in frame b when
 * b_from_a is used in place of the true transform:
 * 2 sin(angle / 2) |X_a| + |dt|, 2 sin(angle / 2) being the spectral norm of the
 * difference of the rotations. OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION,
 * ERR_RANGE. */
RIGCAL_API rigcal_status rigcal_measurement_bound(
    rigcal_real *bound, const rigcal_transform *b_from_a,
    const rigcal_transform *b_from_a_true, const rigcal_real X_a[3]);

/* ==== store ===============================================================
 *
 * A calibration as bytes, for a flash page, a file or a message. The form is
 * little-endian, without gaps, the same from every machine and compiler; DESIGN.md
 * has its table. It carries a version and CRC-32s: one or two altered bits and every
 * length too short are refused for certain, other damage but for one chance in 4e9.
 * That guards against accidents, not forgery. */

/* One camera of a stored calibration. */
typedef struct {
    rigcal_camera camera;
    rigcal_transform cam_from_rig;
    rigcal_real Sigma[36]; /* covariance of cam_from_rig, as of a pose in
                              rigcal_pose_uncertainty: symmetric and positive
                              semidefinite, to 1e-9 / 1e-5 of a correlation. The
                              lower triangle is stored. All 0 is an exact pose, as
                              camera 0 of a rig has */
    int32_t has_Sigma;     /* 1: known. 0: not; Sigma is not read, and 0 when
                              loaded */
    int32_t reserved;      /* 0 */
} rigcal_mounted_camera;

/* What is told of stored bytes without their cameras. */
typedef struct {
    uint32_t sequence;  /* the caller's number of this calibration; the later one of
                           two is a when (int32_t)(a - b) > 0, which survives the
                           wrap at 2^32 */
    uint32_t tag;       /* the caller's, of any meaning: a rig's serial number */
    int32_t n_cameras;  /* 1 .. RIGCAL_SAVE_CAMERAS_MAX */
    int32_t n_bytes;    /* of the stored form, from its first byte on */
    int32_t real_bytes; /* 4 or 8: rigcal_sizeof_real() of who saved it */
} rigcal_saved_info;

/* Bytes that n cameras take, 1 .. 65535, for this build and for one whose reals
 * have so many bytes: 32 and 376 a camera in double, 196 in float. The function
 * gives 0 for another n. */
enum { RIGCAL_SAVE_CAMERAS_MAX = 65535, RIGCAL_SAVE_HEADER_BYTES = 32 };
#define RIGCAL_SAVE_SIZE_OF(n, real_bytes) \
    (RIGCAL_SAVE_HEADER_BYTES + (n) * (16 + 45 * (real_bytes)))
#define RIGCAL_SAVE_SIZE(n) RIGCAL_SAVE_SIZE_OF(n, sizeof(rigcal_real))
RIGCAL_API size_t rigcal_save_size(size_t n_cameras);

/* Writes n_cameras >= 1 cameras in their order as bytes[capacity], of which the first
 * *n_bytes = rigcal_save_size(n_cameras) are written. Only what every other function
 * would take is saved.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_ROTATION, ERR_RANGE (t, has_Sigma,
 * reserved, a Sigma that is no covariance, n_cameras), ERR_TOO_FEW (no camera),
 * ERR_CAPACITY. */
RIGCAL_API rigcal_status rigcal_save(uint8_t bytes[], size_t *n_bytes,
                                     size_t capacity,
                                     const rigcal_mounted_camera cameras[],
                                     size_t n_cameras, uint32_t sequence,
                                     uint32_t tag);

/* Whether bytes[n_bytes] begin with a whole stored calibration, and which. What
 * follows its end is not read. Time O(bytes of it).
 * OK, ERR_NULL, ERR_FOREIGN (other bytes, erased flash among them), ERR_DAMAGED (also:
 * fewer bytes than it has), ERR_VERSION. */
RIGCAL_API rigcal_status rigcal_load_info(rigcal_saved_info *info,
                                          const uint8_t bytes[], size_t n_bytes);

/* The cameras of such bytes: the first info->n_cameras of cameras[capacity], checked
 * as any input is. By a build of the same precision bit for bit what was saved. A
 * build of the other precision reads them too: a float build rounds to nearest; a
 * double build makes rotations orthonormal to its own rounding.
 * Those of rigcal_load_info, ERR_CAPACITY, and ERR_NOT_FINITE (also: too large for a
 * float build), ERR_CAMERA, ERR_ROTATION, ERR_RANGE for numbers that rigcal_save
 * would have refused. */
RIGCAL_API rigcal_status rigcal_load(rigcal_mounted_camera cameras[],
                                     rigcal_saved_info *info, size_t capacity,
                                     const uint8_t bytes[], size_t n_bytes);

#ifdef __cplusplus
}
#endif
#endif /* RIGCAL_H */
