/* rigcal_point.h - points in space from a calibrated rig, with how sure they are. Included
 * by rigcal.h, whose first page holds here too.
 *
 *   rigcal_point_measure   a point from what two or more cameras saw of it; its covariance
 *                          has the noise of the pixels and the error of the calibration
 *   rigcal_point_distance  how far two such points are apart, with its sigma
 *
 * EQUATIONS.md POINT has the mathematics. */
#ifndef RIGCAL_H
#include "rigcal.h" /* which includes this one in its turn */
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
    rigcal_real uv[2]; /* pixel, as seen: distorted */
} rigcal_sighting;

enum rigcal_sighting_limits { RIGCAL_SIGHTINGS_MAX = 1000, RIGCAL_SIGHTING_PAIRS = 120 };

/* What a point is measured from. Set it to zero, then what is there. */
typedef struct rigcal_sightings {
    const rigcal_calibrated_rig *rig;
    const rigcal_sighting *seen; /* n */
    size_t n;                    /* 2 .. RIGCAL_SIGHTINGS_MAX */
    const rigcal_real *sigma_px; /* rig->n_cameras: noise of one coordinate of a pixel of
                                    each camera; NULL: rig->sigma_px of all */
    rigcal_real parallax_least;  /* radian, to pi / 2: the widest angle between two rays
                                    must have as much; 0: 0.1 degree, and never less */
    int32_t keep_all;            /* 1: no view is dropped, whatever it says; 0 */
    rigcal_real *work;           /* memory to work in */
    size_t work_capacity;        /* its number of reals: RIGCAL_POINT_WORK */
} rigcal_sightings;

/* Reals to work in. The same as a function: rigcal_point_work. */
#define RIGCAL_POINT_WORK(n) \
    ((size_t)(n) * (2 * (size_t)(n) + 44) + \
     ((size_t)(n) > 16 ? 3 * (size_t)RIGCAL_SIGHTING_PAIRS : 0))
RIGCAL_API size_t rigcal_point_work(size_t n);

/* What an error d = (w, dt) of a camera's pose moves a point by: gain d, gain 3 x 6. */
typedef struct rigcal_point_gain {
    int32_t camera; /* of the rig */
    rigcal_real gain[18];
} rigcal_point_gain;

/* A point, and how sure it is. gains and gains_capacity are set by the caller. */
typedef struct rigcal_measured_point {
    rigcal_real X[3];     /* in the frame of the rig */
    rigcal_real Sigma[9]; /* covariance of its error: of the noise of the pixels, and of
                                   the calibration */
    rigcal_real Sigma_noise[9]; /* of the noise alone. Where the rig has no joint covariance
                                   (its sigma_px is 0) its poses count as exact, and this is
                                   Sigma. So is a camera that is held */
    rigcal_real chi2, freedom;  /* chi square of the views, and its degrees of freedom,
                                   2 n_used - 3: whether they show one point */
    rigcal_real parallax;       /* radian: the widest angle between the rays of two views */
    rigcal_real rms_px;         /* sqrt(sum(du^2 + dv^2) / n_used) */
    size_t n_used;              /* views that it is measured from */
    rigcal_point_gain *gains;   /* n_used are written, in the order of the views; NULL: not
                                   wanted. rigcal_point_distance wants them */
    size_t gains_capacity;
} rigcal_measured_point;

/* A point from n views: maximum likelihood in pixels through the full lens models, each
 * camera with its own noise.
 *
 *   point   out     see above; gains_capacity >= n, if there are gains
 *   used    out     n: 1 where a view is used, 0 where it contradicts the others and was
 *                   dropped; NULL: not wanted
 *   s       in/out  work is written
 *
 * Views are right when chi2 is below what noise exceeds once in a hundred times. Else, of
 * three views or more, the pairs of views are tried, for n over 16 the
 * RIGCAL_SIGHTING_PAIRS of widest parallax: each makes a point, and another view agrees
 * when it is within chi square of 2 at 99 %. The most that agree are used. Both limits are
 * sqrt(F) times as large where the rig's F is above 1: its views differ by more than noise.
 *
 * OK. RIGCAL_VIEWS_LEFT_OUT: some views were dropped. RIGCAL_FEW_AGREE: the same, and only
 * two agree, which two wrong views may do by chance. RIGCAL_POOR_FIT: all views are used
 * and chi2 is too large: they do not show one point, and no view is the one that is wrong.
 * RIGCAL_BUDGET_SPENT. All of these are written.
 * RIGCAL_DISCONNECTED: two of the cameras have no common frame; not written. ERR_NULL,
 * ERR_NOT_FINITE, ERR_CAMERA, ERR_ROTATION, ERR_RANGE, ERR_TOO_FEW, ERR_CAPACITY; ERR_STATE
 * (no noise is known: the rig's sigma_px is 0, and none are given); ERR_NO_RAY,
 * ERR_PARALLEL, ERR_BEHIND; ERR_DEGENERATE (the covariance of the rig is none);
 * ERR_NO_CONSENSUS (no pair of views agrees).
 * Time O(n^3), for few views some 2000 + 5000 n multiplications; with views to be dropped
 * at most 120 points of two views and 120 n projections more. */
RIGCAL_API rigcal_status rigcal_point_measure(rigcal_measured_point *point, uint8_t used[],
                                              const rigcal_sightings *s);

typedef struct rigcal_point_solver rigcal_point_solver; /* see rigcal_solvers.h */

/* The same in steps. A unit is one view: checked, with its ray; evaluated; compared with a
 * point; or its two rows of the covariance, O(n^2); or one view's angles to the others,
 * O(n). The same bits whatever the budgets. `s` and what it points to must last. The step
 * returns RUNNING or what the result is going to return. */
RIGCAL_API rigcal_status rigcal_point_begin(rigcal_point_solver *solver,
                                            const rigcal_sightings *s);
RIGCAL_API rigcal_status rigcal_point_step(rigcal_point_solver *solver, int32_t budget);
RIGCAL_API rigcal_status rigcal_point_result(rigcal_measured_point *point, uint8_t used[],
                                             const rigcal_point_solver *solver);

/* ==== a length =============================================================== */

/* The distance of two points that were measured with one rig, and its standard deviation:
 * the calibration's error is common to both and mostly cancels. Their cameras need not be
 * the same. sigma NULL: not wanted. OK, ERR_NULL (also of gains), ERR_NOT_FINITE,
 * ERR_RANGE, those of rigcal_calibrated_covariance; ERR_COINCIDENT: the points are one.
 * RIGCAL_DISCONNECTED: not written. O(n^2) of their views. */
RIGCAL_API rigcal_status rigcal_point_distance(rigcal_real *distance, rigcal_real *sigma,
                                               const rigcal_calibrated_rig *rig,
                                               const rigcal_measured_point *p,
                                               const rigcal_measured_point *q);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_POINT_H */
