/* rigcal_consider.h - intrinsics that are not exact, in every covariance of a rig. Included
 * by rigcal.h, whose first page holds here too.
 *
 * Intrinsics have errors, which a calibration program states as standard deviations. They
 * move the rig without making its views disagree: 0.3 % of the focal length and 3 px of the
 * centre move cameras by many times what the noise of pixels explains. So
 *
 *   rig.intrinsics_sigmas   of each camera its deviations
 *   rigcal_rig_adjust       as ever: the poses do not change
 *   rigcal_rig_consider     one more pass over the views
 *
 * and from then on every covariance of the rig is sigma_px^2 S^-1 + G Sigma G^T: that of
 * the pixels, and what the intrinsics add. Deviations of 0 add nothing, not one bit.
 *
 * EQUATIONS.md CONSIDER has the mathematics. */
#ifndef RIGCAL_H
#include "rigcal.h" /* which includes this one in its turn */
#endif

#ifndef RIGCAL_CONSIDER_H
#define RIGCAL_CONSIDER_H

#ifdef __cplusplus
extern "C" {
#endif

/* What one deviation of each of the intrinsics does to the cameras. Set it to zero, then
 * the memory and its capacity. It must last as long as covariances are asked for. */
struct rigcal_considered {
    const struct rigcal_considering *by; /* written, as the rest: */
    size_t n, k;          /* unknowns of the cameras; intrinsics that are not exact */
    rigcal_real *effects; /* memory: k rows of n, then of the placement last asked for */
    size_t capacity;      /* its number of reals: RIGCAL_CONSIDER_WORK */
    const rigcal_real *factor; /* written: of an estimate, k rows of a triangle; NULL */
};
typedef struct rigcal_considered rigcal_considered;

/* Reals of its memory, for n_cameras of which n_free are free or have a prior. The same as
 * a function: rigcal_consider_work. */
#define RIGCAL_CONSIDER_WORK(n_free, n_cameras) \
    (36 * (size_t)(n_cameras) * ((size_t)(n_free) + 1))
RIGCAL_API size_t rigcal_consider_work(size_t n_free, size_t n_cameras);

/* More of them, for a rig with clocks. */
#define RIGCAL_CONSIDER_CLOCKS_WORK(n_cameras) \
    (4 * (size_t)(n_cameras) * (3 * (size_t)(n_cameras) + 2))
RIGCAL_API size_t rigcal_consider_clocks_work(size_t n_cameras);

/* With clocks that are free the cameras' covariances contain what the intrinsics do to
 * them through the clocks. That of a placement is as without clocks.
 *
 * After rigcal_rig_adjust, of a rig with intrinsics_sigmas (NULL: all are exact). Sets
 * rig->considered. After rigcal_rig_adjust_robust all points count, the wrong ones too.
 * OK; ERR_NULL, ERR_NOT_FINITE, ERR_RANGE (a deviation below 0 or above 1e9), ERR_STATE
 * (not adjusted), ERR_CAPACITY, and those of views and sources: rig->considered is then
 * NULL. *at_fault: the number of the view, or -1; of a deviation, the camera. Time O(n) +
 * O(n_views n_cameras^2) + O(n_cameras^3). */
RIGCAL_API rigcal_status rigcal_rig_consider(rigcal_considered *considered,
                                             int32_t *at_fault, rigcal_rig *rig);

typedef struct rigcal_consider_solver rigcal_consider_solver; /* see rigcal_solvers.h */

/* The same in steps. A unit is one view, O(n); the elimination of one placement,
 * O(n_cameras^2); or one row of the effects, O(n_cameras^2). The same bits whatever the
 * budgets. All must last. */
RIGCAL_API rigcal_status rigcal_consider_begin(rigcal_consider_solver *solver,
                                               rigcal_considered *considered,
                                               rigcal_rig *rig);
RIGCAL_API rigcal_status rigcal_consider_step(rigcal_consider_solver *solver,
                                              int32_t budget);
RIGCAL_API rigcal_status rigcal_consider_result(int32_t *at_fault,
                                                const rigcal_consider_solver *solver);

/* ---- intrinsics that are estimated -------------------------------------------
 *
 * An option, for deviations that are honest. The views move the intrinsics a little way
 * from where the calibration program had them; the deviations hold them back. Where the
 * intrinsics were right all the same, the rig gets worse by it.
 *
 *   rigcal_rig_adjust       as ever
 *   rigcal_rig_estimate     the most likely change of every camera's intrinsics
 *   rigcal_camera_change    puts it into the cameras, and from the first line again, until
 *                           `step` is below 0.1: two to four rounds
 *
 * After the last rigcal_rig_estimate every covariance of the rig is sigma_px^2 S^-1 +
 * G Sigma G^T with Sigma what is left of the intrinsics' covariance. */

/* A change of a camera's own numbers, or the deviations of one. */
typedef struct rigcal_intrinsics_change {
    rigcal_real focal;  /* of fx and fy together, as a part of them */
    rigcal_real aspect; /* of fx / fy, as a part of it */
    rigcal_real cx, cy; /* [px] */
    rigcal_real k1, k2;
} rigcal_intrinsics_change;

/* *out: the camera with fx (1 + focal + aspect / 2), fy (1 + focal - aspect / 2), and the
 * others added; out may be `camera`. OK, ERR_NULL, ERR_NOT_FINITE, and every status of
 * rigcal_camera_check, of what comes out too; nothing is written then. O(1) */
RIGCAL_API rigcal_status rigcal_camera_change(rigcal_camera *out,
                                              const rigcal_camera *camera,
                                              const rigcal_intrinsics_change *change);

/* Set it to zero, then the pointers and the capacity of `considered`. */
typedef struct rigcal_estimated {
    rigcal_considered considered;         /* with RIGCAL_ESTIMATE_WORK reals */
    const rigcal_intrinsics_change *made; /* n_cameras: what the views' cameras contain of
                                             it already. 0 at first */
    rigcal_intrinsics_change *change;     /* n_cameras, written: the most likely, from the
                                         cameras without any. It may be `made` */
    rigcal_intrinsics_change *sigma;      /* n_cameras, written: deviations afterwards */
    rigcal_real step; /* written: the largest of change less made, by that deviation */
} rigcal_estimated;

/* Reals of its memory. The same as a function: rigcal_estimate_work. */
#define RIGCAL_ESTIMATE_WORK(n_free, n_cameras) \
    (RIGCAL_CONSIDER_WORK(n_free, n_cameras) + \
     3 * (size_t)(n_cameras) * (6 * (size_t)(n_cameras) + 5))
RIGCAL_API size_t rigcal_estimate_work(size_t n_free, size_t n_cameras);

/* After rigcal_rig_adjust, of a rig with intrinsics_sigmas; sigma_px > 0 [px] is the noise
 * of its pixels. Sets rig->considered to what is left: *estimated must last as long. A
 * deviation of 0 stays 0, and what it is of does not move. In float the deviations are good
 * to some 5 %. Two passes over the views, in one call: O(n) + O(n_views n_cameras^2) +
 * O(n_cameras^3). OK; ERR_NOT_FINITE, ERR_RANGE (sigma_px; a number of `made` beyond 1e9),
 * ERR_STATE also: the rig has clocks; and those of rigcal_rig_consider: rig->considered is
 * then NULL, and nothing of `change` and `sigma` is written. *at_fault: as there. */
RIGCAL_API rigcal_status rigcal_rig_estimate(rigcal_estimated *estimated, int32_t *at_fault,
                                             rigcal_rig *rig, rigcal_real sigma_px);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_CONSIDER_H */
