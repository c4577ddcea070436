/* rigcal_point.h - points in space from a calibrated rig, with their covariances. Included
 * by rigcal.h, whose first page holds here too.
 *
 *   rigcal_point_measure   a point from where two or more cameras saw it. Its covariance
 *                          contains the noise of the pixels and the error of the
 *                          calibration
 *   rigcal_point_distance  the distance between two such points, with its sigma
 *
 * EQUATIONS.md POINT has the mathematics. */
#ifndef RIGCAL_H
#include "rigcal.h" /* rigcal.h includes this header too */
#endif

#ifndef RIGCAL_POINT_H
#define RIGCAL_POINT_H

#ifdef __cplusplus
extern "C" {
#endif

/* ==== a point ================================================================ */

/* Where one camera saw a point. */
typedef struct rigcal_sighting {
    int32_t camera;    /* 0 .. rig->n_cameras - 1 */
    rigcal_real uv[2]; /* pixel as observed, distorted */
} rigcal_sighting;

enum rigcal_sighting_limits { RIGCAL_SIGHTINGS_MAX = 1000, RIGCAL_SIGHTING_PAIRS = 120 };

/* What a point is measured from. Set it to zero, then fill in what there is. */
typedef struct rigcal_sightings {
    const rigcal_calibrated_rig *rig;
    const rigcal_sighting *seen; /* n */
    size_t n;                    /* 2 .. RIGCAL_SIGHTINGS_MAX */
    const rigcal_real *sigma_px; /* rig->n_cameras: noise of one coordinate of a pixel, for
                                    each camera; NULL: rig->sigma_px for all */
    rigcal_real parallax_least;  /* the widest angle between two rays must be at least this;
                                    radian, to pi / 2. 0, or less than 0.1 degree: 0.1
                                    degree */
    int32_t keep_all;            /* 1: no view is dropped, even if it contradicts. 0:
                                    default */
    rigcal_real *work;           /* memory to work in */
    size_t work_capacity;        /* its number of reals: RIGCAL_POINT_WORK */
} rigcal_sightings;

/* Reals to work in. The same as a function: rigcal_point_work. */
#define RIGCAL_POINT_WORK(n) \
    ((size_t)(n) * (2 * (size_t)(n) + 44) + \
     ((size_t)(n) > 16 ? 3 * (size_t)RIGCAL_SIGHTING_PAIRS : 0))
RIGCAL_API size_t rigcal_point_work(size_t n);

/* An error d = (w, dt) of a camera's pose moves a point by gain d. gain is 3 x 6, row by
 * row. */
typedef struct rigcal_point_gain {
    int32_t camera; /* of the rig */
    rigcal_real gain[18];
} rigcal_point_gain;

/* A point, and how sure it is. gains and gains_capacity are set by the caller. */
typedef struct rigcal_measured_point {
    rigcal_real X[3];     /* in the frame of the rig */
    rigcal_real Sigma[9]; /* covariance of its error, from the noise of the pixels and the
                             calibration */
    rigcal_real Sigma_noise[9]; /* the part from the noise alone. A camera that is held
                                   counts as exact. If the rig has no joint covariance (its
                                   sigma_px is 0), all cameras do, and this is Sigma */
    rigcal_real chi2, freedom;  /* chi square of the views, and its degrees of freedom, 2
                                   n_used - 3. Tells whether the views show one point */
    rigcal_real parallax;       /* radian: the widest angle between the rays of two views */
    rigcal_real rms_px;         /* sqrt(sum(du^2 + dv^2) / n_used) */
    size_t n_used;              /* number of views that it is measured from */
    rigcal_point_gain *gains;   /* n_used are written, in the order of the views; NULL: not
                                   wanted. rigcal_point_distance needs them */
    size_t gains_capacity;
} rigcal_measured_point;

/* A point from n views, by maximum likelihood in pixels through the full lens models. Each
 * camera has its own noise.
 *
 *   point   out     see above; gains_capacity >= n, if there are gains
 *   used    out     n: 1 where a view is used, 0 where it contradicts the others and was
 *                   dropped; NULL: not wanted
 *   s       in/out  work is written
 *
 * All views are used if chi2 is below the limit that noise alone exceeds once in a hundred
 * times. Otherwise, if there are three views or more, pairs of views are tried; for n
 * above 16 only the RIGCAL_SIGHTING_PAIRS pairs with the widest parallax. Each pair gives
 * a point. Another view agrees with it if its chi square, with 2 degrees, is within the
 * limit at 99 %. The largest set of views that agree is used. Where the rig's F is above
 * 1, its views differ by more than noise, and both limits of chi square are sqrt(F) times
 * as large.
 *
 * OK. RIGCAL_VIEWS_LEFT_OUT: some views were dropped. RIGCAL_FEW_AGREE: some were dropped
 * and only two agree, which two wrong views may do by chance. RIGCAL_POOR_FIT: all views
 * are used and chi2 is too large. The views do not show one point, and no single view is
 * to blame. RIGCAL_BUDGET_SPENT. With all of these the point is written.
 * RIGCAL_DISCONNECTED: two of the cameras have no common frame; no point is written.
 * ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_ROTATION, ERR_RANGE, ERR_TOO_FEW,
 * ERR_CAPACITY; ERR_STATE (no noise is known: the rig's sigma_px is 0, and none are
 * given); ERR_NO_RAY, ERR_PARALLEL, ERR_BEHIND; ERR_DEGENERATE (the rig's covariance is
 * not one); ERR_NO_CONSENSUS (no pair of views agrees). Time O(n^3). For few views that is
 * some 2000 + 5000 n multiplications. To drop views takes at most 120 points of two views
 * and 120 n projections more. */
RIGCAL_API rigcal_status rigcal_point_measure(rigcal_measured_point *point, uint8_t used[],
                                              const rigcal_sightings *s);

typedef struct rigcal_point_solver rigcal_point_solver; /* see rigcal_solvers.h */

/* The same in steps. A unit is one view: checked, with its ray; evaluated; compared with a
 * point; its two rows of the covariance, O(n^2); or its angles to the others, O(n). The
 * budgets do not change one bit of the result. `s` and what it points to must last. The
 * step returns RUNNING, or the status that the result will return. */
RIGCAL_API rigcal_status rigcal_point_begin(rigcal_point_solver *solver,
                                            const rigcal_sightings *s);
RIGCAL_API rigcal_status rigcal_point_step(rigcal_point_solver *solver, int32_t budget);
RIGCAL_API rigcal_status rigcal_point_result(rigcal_measured_point *point, uint8_t used[],
                                             const rigcal_point_solver *solver);

/* ==== a length =============================================================== */

/* The distance between two points that were measured with one rig, and its standard
 * deviation. The error of the calibration is common to both points and mostly cancels.
 * Their cameras need not be the same. sigma NULL: not wanted. OK, ERR_NULL (also of
 * gains), ERR_NOT_FINITE, ERR_RANGE, those of rigcal_calibrated_covariance;
 * ERR_COINCIDENT: the points are one. RIGCAL_DISCONNECTED: nothing is written. O(n^2) for
 * n views of the points. */
RIGCAL_API rigcal_status rigcal_point_distance(rigcal_real *distance, rigcal_real *sigma,
                                               const rigcal_calibrated_rig *rig,
                                               const rigcal_measured_point *p,
                                               const rigcal_measured_point *q);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_POINT_H */
