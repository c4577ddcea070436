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
};
typedef struct rigcal_considered rigcal_considered;

/* Reals of its memory, of so many cameras that are free or have a prior, and so many in
 * all. The same as a function: rigcal_consider_work. */
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

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_CONSIDER_H */
