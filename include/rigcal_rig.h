/* rigcal_rig.h - several cameras in one frame. Included by rigcal.h, whose first page holds
 * here too.
 *
 * A target is shown to the cameras in one place after the other, its placements. What a
 * camera sees of it there is a view. From the pose of each view by itself,
 *
 *   rigcal_view_pose_make   its pose, with what its points know of it      every view
 *   rigcal_rig_join         all cameras and placements from those          no point is read
 *   rigcal_rig_adjust       the same at maximum likelihood, over all points
 *   rigcal_rig_covariance   how sure a camera is, _pair two, _placement the target
 *
 * EQUATIONS.md RIG has the mathematics. */
#ifndef RIGCAL_RIG_H
#define RIGCAL_RIG_H

#include "rigcal.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ==== what is handed in ====================================================== */

/* What one camera saw of the target in one placement. Several targets of known relation are
 * one target with more points. */
typedef struct rigcal_rig_view {
    rigcal_view view;  /* sigma: NULL, or of each point, a factor of the rig's */
    int32_t camera;    /* 0 .. n_cameras - 1 */
    int32_t placement; /* 0 .. n_placements - 1 */
    int32_t target;    /* 0: so far there is one */
} rigcal_rig_view;

/* The pose of one view by itself, and what its points know of it. */
typedef struct rigcal_view_pose {
    rigcal_transform cam_from_target;
    rigcal_real information[21]; /* J^T J by (w, dt) of the pose, for noise of 1 px */
    rigcal_real sse;             /* sum of |du|^2 / sigma_i^2 */
    size_t n;                    /* number of points */
    int32_t camera, placement;
} rigcal_view_pose;

/* View `index` of n_views, for those that do not fit into memory: from flash, from a file.
 * What it points to must last until the next call. OK, or a status that ends the work. */
typedef rigcal_status (*rigcal_view_source)(rigcal_rig_view *view, size_t index,
                                            void *context);
typedef rigcal_status (*rigcal_view_pose_source)(rigcal_view_pose *pose, size_t index,
                                                 void *context);

/* What is known of a camera beforehand. */
enum rigcal_camera_roles {
    RIGCAL_CAMERA_FREE = 0,
    RIGCAL_CAMERA_HELD = 1, /* its pose is right as it is */
    RIGCAL_CAMERA_PRIOR = 2 /* its pose has a covariance: see priors */
};

typedef struct rigcal_camera_prior {
    rigcal_transform cam_from_rig;
    rigcal_real Sigma[36]; /* of (w, dt), row by row */
} rigcal_camera_prior;

/* Cameras, placements, and what was seen. Set it to zero, then what is there. */
typedef struct rigcal_rig {
    rigcal_transform *cams_from_rig; /* n_cameras */
    size_t n_cameras;
    rigcal_transform *rig_from_placements; /* n_placements */
    size_t n_placements;
    int32_t *group; /* n_cameras, written: the number of the group that a camera connects
                       in, counted from 0 in the order of their first cameras. Cameras of
                       different groups have no common frame */

    size_t n_views;               /* in the order of their placements, of one no camera
                                     twice */
    const rigcal_rig_view *views; /* n_views, or NULL: view_source */
    rigcal_view_source view_source;
    const rigcal_view_pose *view_poses; /* n_views, or NULL: view_pose_source */
    rigcal_view_pose_source view_pose_source;
    void *context;           /* of the sources */
    const uint8_t *left_out; /* n_views, or NULL: none. A view of which it is not 0 is
                                passed over; of it only camera and placement are read */

    const uint8_t *roles; /* n_cameras; NULL: the first of each group is held */
    const rigcal_camera_prior *priors; /* n_cameras, of which those of that role count */
    rigcal_real sigma_px; /* noise of one coordinate of a pixel; 0: unknown. With a prior
                             it must be known */

    rigcal_real *work;    /* memory to work in */
    size_t work_capacity; /* its number of reals: RIGCAL_RIG_WORK */
} rigcal_rig;

/* Reals to work in, of so many cameras that are free or have a prior, and so many in all.
 * The same as a function: rigcal_rig_work. */
#define RIGCAL_RIG_WORK(n_free, n_cameras, n_placements) \
    (3 * (size_t)(n_free) * (6 * (size_t)(n_free) + 1) + 12 * (size_t)(n_free) + \
     51 * (size_t)(n_cameras) + 13 * (size_t)(n_placements))
RIGCAL_API size_t rigcal_rig_work(size_t n_free, size_t n_cameras, size_t n_placements);

/* ==== the join =============================================================== */

/* The pose of a view, for the join: what its points know there. OK, ERR_NULL, those of
 * rigcal_pose_covariance. O(n). */
RIGCAL_API rigcal_status rigcal_view_pose_make(rigcal_view_pose *pose,
                                               const rigcal_rig_view *view,
                                               const rigcal_transform *cam_from_target);

/* All cameras and placements from the poses of the views, weighed by their information as
 * full matrices: next to maximum likelihood, and the start of the adjustment. Writes
 * cams_from_rig (held ones and those with priors are where they were), rig_from_placements
 * and group. The frame is that of camera 0, if none is held.
 * OK, RIGCAL_DISCONNECTED, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE, ERR_TOO_FEW
 * (no camera, no view), ERR_CAPACITY, ERR_TWICE, ERR_UNSORTED, ERR_DEGENERATE (the
 * information of a view or placement is not positive definite), and what a source returns.
 * *at_fault: the number of the view, or -1. Time O(n_views n_cameras). */
RIGCAL_API rigcal_status rigcal_rig_join(rigcal_rig *rig, int32_t *at_fault);

typedef struct rigcal_rig_solver rigcal_rig_solver; /* see rigcal_solvers.h */

/* The same in steps. Its result is rigcal_rig_result's: to first order, what the fit of the
 * adjustment is going to be, F included. A unit is one view: looked at, or its quadratic,
 * or its part of the elimination, O(n_cameras); or one row of the factor. */
RIGCAL_API rigcal_status rigcal_rig_join_begin(rigcal_rig_solver *solver, rigcal_rig *rig);
RIGCAL_API rigcal_status rigcal_rig_join_step(rigcal_rig_solver *solver, int32_t budget);

/* ==== the adjustment ========================================================= */

/* How well an adjusted rig fits. */
typedef struct rigcal_rig_fit {
    rigcal_real sum;      /* of |du|^2 / sigma_i^2 over all points, and of the priors */
    rigcal_real freedom;  /* 2 n_points - 6 (free cameras) - 6 (placements seen) */
    rigcal_real sigma_px; /* sqrt(sum / freedom); 0: no freedom */
    size_t n_points;
    int32_t evals; /* evaluations of each view, settling included */

    /* The loop closure: how much the views disagree, against what they do by themselves.
     * For noise alone F is distributed as F(freedom_between, freedom_within); sqrt(F) tells
     * how many times more than noise they disagree. 0, of no freedom: there is no cycle, or
     * no view_poses are given. */
    rigcal_real F, freedom_between, freedom_within;
} rigcal_rig_fit;

/* Cameras and placements together by maximum likelihood in pixels over all views, from
 * where they are. After it the rig's `work` holds the cameras' covariance: keep it, and the
 * rig, for the functions below. OK, RIGCAL_DISCONNECTED, RIGCAL_BUDGET_SPENT, and the
 * errors of rigcal_rig_join; of its views those of rigcal_pose_begin, ERR_BEHIND,
 * ERR_NO_RAY, ERR_DEGENERATE. */
RIGCAL_API rigcal_status rigcal_rig_adjust(rigcal_rig_fit *fit, int32_t *at_fault,
                                           rigcal_rig *rig);

/* The same in steps. A unit is one view's evaluation with its block, O(n) and O(n_cameras);
 * one view's part of the elimination of its placement; or one row of the factor. The same
 * bits whatever the budgets. `rig` must last. */
RIGCAL_API rigcal_status rigcal_rig_begin(rigcal_rig_solver *solver, rigcal_rig *rig);
RIGCAL_API rigcal_status rigcal_rig_step(rigcal_rig_solver *solver, int32_t budget);
RIGCAL_API rigcal_status rigcal_rig_result(rigcal_rig_fit *fit, int32_t *at_fault,
                                           const rigcal_rig_solver *solver);

/* ==== how sure =============================================================== */

/* Sigma: covariance of (w, dt) of a camera's pose in the frame of the rig, for noise of
 * sigma_px: 0 of one that is held. OK, ERR_NULL, ERR_RANGE, ERR_STATE (not adjusted). */
RIGCAL_API rigcal_status rigcal_rig_covariance(rigcal_real Sigma[36], const rigcal_rig *rig,
                                               rigcal_real sigma_px, size_t camera);

/* b_from_a, and its covariance, cross terms included: the same whichever camera is held.
 * The statuses above; RIGCAL_DISCONNECTED: the two have no common frame, nothing is
 * written. */
RIGCAL_API rigcal_status rigcal_rig_pair(rigcal_transform *b_from_a, rigcal_real Sigma[36],
                                         const rigcal_rig *rig, rigcal_real sigma_px,
                                         size_t a, size_t b);

/* Of a placement, of (w, dt) of rig_from_placement: it evaluates its views once more. The
 * statuses above, ERR_TOO_FEW (no view of it), and those of views. O(n_views) + O(n). */
RIGCAL_API rigcal_status rigcal_rig_placement(rigcal_real Sigma[36], rigcal_rig *rig,
                                              rigcal_real sigma_px, size_t placement);

/* Noise of each camera by its own residuals: sigma_px[n_cameras], 0 without freedom, and
 * its degrees of freedom[n_cameras]: 2 n_points of the camera less what they lose to the
 * unknowns, trace(H Cov(cam_from_target)) of each view. Without priors they sum up to
 * rigcal_rig_fit's. It evaluates every view twice. The statuses of rigcal_rig_placement.
 * O(n_views n_cameras) + O(n). */
RIGCAL_API rigcal_status rigcal_rig_noise(rigcal_real sigma_px[], rigcal_real freedom[],
                                          rigcal_rig *rig);

/* What is left of one view: duv gets (du, dv) [px] of each of its n points, observed less
 * projected; *n_written n. OK, ERR_NULL, ERR_RANGE, ERR_CAPACITY (2 n > capacity), those of
 * views and sources. */
RIGCAL_API rigcal_status rigcal_rig_residuals(rigcal_real duv[], size_t capacity,
                                              size_t *n_written, const rigcal_rig *rig,
                                              size_t view);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_RIG_H */
