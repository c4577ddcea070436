/* rigcal_consider.h - intrinsics that are not exact, in every covariance of a rig. Included
 * by rigcal.h, whose first page holds here too.
 *
 * Intrinsics have errors, which a calibration program states as standard deviations. These
 * errors move the rig without making its views disagree. Errors of 0.3 % in the focal
 * length and 3 px in the centre move cameras by many times what the noise of pixels
 * explains. To account for them:
 *
 *   rig.intrinsics_sigmas   set the standard deviations of each camera
 *   rigcal_rig_adjust       as always: the poses do not change
 *   rigcal_rig_consider     makes one more pass over the views
 *
 * From then on every covariance of the rig is sigma_px^2 S^-1 + G Sigma G^T. The first
 * term is the noise of the pixels. The second is what the intrinsics add: Sigma is their
 * covariance, and G is the effect of each on the poses. Deviations of 0 do not change one
 * bit.
 *
 * The errors of the intrinsics also raise the residuals a little, and F with them. So
 * sigma_px and F of the adjustment contain a part of what the second term counts.
 * rigcal_considered_fit subtracts this part.
 *
 * EQUATIONS.md CONSIDER has the mathematics. */
#ifndef RIGCAL_H
#include "rigcal.h" /* rigcal.h includes this header too */
#endif

#ifndef RIGCAL_CONSIDER_H
#define RIGCAL_CONSIDER_H

#ifdef __cplusplus
extern "C" {
#endif

/* How far one standard deviation of each intrinsic parameter moves the cameras. Set the
 * struct to zero, then set the memory and its capacity, and loss. It must last as
 * long as covariances are asked for. */
struct rigcal_considered {
    const struct rigcal_considering *by; /* written, as n and k */
    size_t n, k;          /* number of unknowns of the cameras; of intrinsics that are not
                             exact */
    rigcal_real *effects; /* memory: k rows of n, then the effects on the placement last
                             asked for */
    size_t capacity;      /* number of reals of that memory: RIGCAL_CONSIDER_WORK */
    int32_t loss;         /* of rigcal_losses: that by which the rig was adjusted last;
                             0: least squares */
    const rigcal_real *factor; /* written: after an estimate, k rows of a triangle; else
                                  NULL */
    rigcal_real sum, own_sum;  /* written [px^2]: what the errors of the intrinsics are
                                  expected to add to `sum` of rigcal_rig_fit, and to the
                                  sums of the views, each with a pose of its own; after an
                                  estimate 0 */
};
typedef struct rigcal_considered rigcal_considered;

/* Reals of that memory, for n_cameras of which n_free are free or have a prior. As a
 * function: rigcal_consider_work. */
#define RIGCAL_CONSIDER_WORK(n_free, n_cameras) \
    (36 * (size_t)(n_cameras) * ((size_t)(n_free) + 1))
RIGCAL_API size_t rigcal_consider_work(size_t n_free, size_t n_cameras);

/* Reals that a rig with clocks needs in addition. */
#define RIGCAL_CONSIDER_CLOCKS_WORK(n_cameras) \
    (4 * (size_t)(n_cameras) * (3 * (size_t)(n_cameras) + 2))
RIGCAL_API size_t rigcal_consider_clocks_work(size_t n_cameras);

/* Considers the errors of the intrinsics. Where clocks are free, intrinsics also move the
 * cameras through the clocks, and the cameras' covariances contain this. The covariance of
 * a placement is computed as if there were no clocks.
 *
 * Call it after rigcal_rig_adjust, for a rig with intrinsics_sigmas (NULL: all are exact).
 * It sets rig->considered. After rigcal_rig_adjust_robust set `loss` to
 * RIGCAL_LOSS_TRUNCATED: otherwise the wrong points count here too.
 * OK; ERR_NULL, ERR_NOT_FINITE, ERR_RANGE (a deviation below 0 or above 1e9; loss
 * without rig->sigma_px), ERR_STATE (not adjusted), ERR_CAPACITY, and those of views and
 * sources. After an error rig->considered is NULL. *at_fault: the number of the view, or of
 * the camera whose deviation is at fault, or -1. Time O(n) + O(n_views n_cameras^2) +
 * O(n_cameras^3). */
RIGCAL_API rigcal_status rigcal_rig_consider(rigcal_considered *considered,
                                             int32_t *at_fault, rigcal_rig *rig);

/* *out: `fit`, that of the last adjustment, without what the errors of the intrinsics are
 * expected to add to it. sum, sigma_px and F differ; they are 0 if the deviations explain
 * all that there is. Take the noise for a covariance from *out: sigma_px, or the noise
 * inside the views times sqrt(F) if F is above 1. `fit` still says how much the views
 * disagree. `out` may be `fit`. If rig->considered is NULL, *out is *fit. In float, after
 * Huber's loss, it is right only if the adjustment was begun once more at its answer. OK,
 * ERR_NULL, ERR_NOT_FINITE. O(1) */
RIGCAL_API rigcal_status rigcal_considered_fit(rigcal_rig_fit *out,
                                               const rigcal_rig_fit *fit,
                                               const rigcal_rig *rig);

typedef struct rigcal_consider_solver rigcal_consider_solver; /* see rigcal_solvers.h */

/* The same in steps. A unit is one view, O(n); the elimination of one placement,
 * O(n_cameras^2); or one row of the effects, O(n_cameras^2). The budgets do not change one
 * bit of the result. All that is handed in must last. */
RIGCAL_API rigcal_status rigcal_consider_begin(rigcal_consider_solver *solver,
                                               rigcal_considered *considered,
                                               rigcal_rig *rig);
RIGCAL_API rigcal_status rigcal_consider_step(rigcal_consider_solver *solver,
                                              int32_t budget);
RIGCAL_API rigcal_status rigcal_consider_result(int32_t *at_fault,
                                                const rigcal_consider_solver *solver);

/* ---- intrinsics that are estimated -------------------------------------------
 *
 * An option. It needs deviations that are honest. The views move the intrinsics a little
 * way from where the calibration program had them, and the deviations hold them back. If
 * the intrinsics were more accurate than their deviations say, the rig gets worse.
 *
 *   rigcal_rig_adjust       as always
 *   rigcal_rig_estimate     the most likely change of every camera's intrinsics
 *   rigcal_camera_change    puts the change into the cameras; then start again with the
 *                           first line, until `step` is below 0.1, after two to four
 *                           rounds
 *
 * After the last rigcal_rig_estimate every covariance of the rig is sigma_px^2 S^-1 + G
 * Sigma G^T. Sigma is then the covariance that the intrinsics still have. */

/* A change of a camera's own numbers, or the deviations of one. */
typedef struct rigcal_intrinsics_change {
    rigcal_real focal;  /* of fx and fy together, relative to them */
    rigcal_real aspect; /* of fx / fy, relative to it */
    rigcal_real cx, cy; /* [px] */
    rigcal_real k1, k2;
} rigcal_intrinsics_change;

/* *out: the camera with fx (1 + focal + aspect / 2), fy (1 + focal - aspect / 2), and the
 * other changes added. `out` may be `camera`. OK, ERR_NULL, ERR_NOT_FINITE, and every
 * status of rigcal_camera_check, for the changed camera too. After an error nothing is
 * written. O(1) */
RIGCAL_API rigcal_status rigcal_camera_change(rigcal_camera *out,
                                              const rigcal_camera *camera,
                                              const rigcal_intrinsics_change *change);

/* Set it to zero, then set the pointers, and the memory and capacity of `considered`. */
typedef struct rigcal_estimated {
    rigcal_considered considered;         /* with RIGCAL_ESTIMATE_WORK reals */
    const rigcal_intrinsics_change *made; /* n_cameras: the part of the change that the
                                             views' cameras already contain. 0 at first */
    rigcal_intrinsics_change *change;     /* n_cameras, written: the most likely change,
                                             counted from the cameras without any change. It
                                             may be the array `made` */
    rigcal_intrinsics_change *sigma;      /* n_cameras, written: standard deviations after
                                             the estimate */
    rigcal_real step; /* written: the largest of (change - made) / sigma */
} rigcal_estimated;

/* Reals of its memory. The same as a function: rigcal_estimate_work. */
#define RIGCAL_ESTIMATE_WORK(n_free, n_cameras) \
    (RIGCAL_CONSIDER_WORK(n_free, n_cameras) + \
     3 * (size_t)(n_cameras) * (6 * (size_t)(n_cameras) + 5))
RIGCAL_API size_t rigcal_estimate_work(size_t n_free, size_t n_cameras);

/* After rigcal_rig_adjust, of a rig with intrinsics_sigmas; sigma_px > 0 [px] is the noise
 * of its pixels. Sets rig->considered to the errors that are left, so *estimated must last
 * as long as covariances are asked for. A parameter whose deviation is 0 does not move,
 * and its deviation stays 0. Points count as by considered.loss. In
 * float the deviations are accurate to some 5 %. Two passes over the views, in one call:
 * O(n) + O(n_views n_cameras^2) + O(n_cameras^3). OK; ERR_NOT_FINITE, ERR_RANGE (sigma_px;
 * a number of `made` beyond 1e9; loss without rig->sigma_px), ERR_STATE (also:
 * the rig has clocks), and those of rigcal_rig_consider. After an error rig->considered is
 * NULL, and nothing is written to `change` and `sigma`. *at_fault: as in
 * rigcal_rig_consider. */
RIGCAL_API rigcal_status rigcal_rig_estimate(rigcal_estimated *estimated, int32_t *at_fault,
                                             rigcal_rig *rig, rigcal_real sigma_px);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_CONSIDER_H */
