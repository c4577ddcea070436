/* rigcal_rig.h - several cameras in one frame. Included by rigcal.h, whose first page holds
 * here too.
 *
 * A target is shown to the cameras in one place after the other. Each place is a
 * placement, and what one camera sees of the target there is a view. First the pose of
 * each view is solved by itself, then:
 *
 *   rigcal_view_pose_make   the pose of a view, with its information     for every view
 *   rigcal_rig_join         cameras and placements from these poses      reads no point
 *   rigcal_rig_adjust       the same by maximum likelihood               reads all points
 *   rigcal_rig_covariance   covariance of a camera; _pair: of two, _placement: the target
 *   rigcal_calibrated_take  what to keep; rigcal_store_save_rig turns it into bytes
 *
 * EQUATIONS.md RIG has the mathematics. */
#ifndef RIGCAL_H
#include "rigcal.h" /* rigcal.h includes this header too */
#endif

#ifndef RIGCAL_RIG_H
#define RIGCAL_RIG_H

#ifdef __cplusplus
extern "C" {
#endif

/* ==== what is handed in ====================================================== */

/* What one camera saw of the target in one placement. Several targets whose relative poses
 * are known count as one target with more points. */
typedef struct rigcal_rig_view {
    rigcal_view view;  /* its sigma: NULL, or a factor for each point by which rig->sigma_px
                          is multiplied */
    int32_t camera;    /* 0 .. n_cameras - 1 */
    int32_t placement; /* 0 .. n_placements - 1 */
    int32_t target;    /* 0: there is one target so far */
} rigcal_rig_view;

/* The pose of one view by itself, and how well its points fix it. */
typedef struct rigcal_view_pose {
    rigcal_transform cam_from_target;
    rigcal_real information[21]; /* J^T J for (w, dt) of the pose, for noise of 1 px */
    rigcal_real sse;             /* sum of |du|^2 / sigma_i^2 */
    size_t n;                    /* number of points */
    int32_t camera, placement;
} rigcal_view_pose;

/* A function of the caller's that writes view `index` of n_views, from flash or a file,
 * for views that do not fit into memory. What the view points to must last until the next
 * call. Returns OK, or a status that ends the work. */
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

/* Standard deviations of a camera's intrinsics, as its calibration states them; 0:
 * exact. */
typedef struct rigcal_intrinsics_sigma {
    rigcal_real focal;  /* of fx and fy together, relative to them */
    rigcal_real aspect; /* of fx / fy, relative to it */
    rigcal_real centre; /* of cx and of cy [px] */
    rigcal_real k1, k2;
} rigcal_intrinsics_sigma;

/* Cameras, placements, and what was seen. Set it to zero, then fill in what there is.
 * A search writes the poses, group and clocks of the rig as it goes, and `takes` of
 * rigcal_choose.h. After an error they are as it left them. */
typedef struct rigcal_rig {
    rigcal_transform *cams_from_rig; /* n_cameras */
    size_t n_cameras;
    rigcal_transform *rig_from_placements; /* n_placements */
    size_t n_placements;
    int32_t *group; /* n_cameras, written: the number of the camera's group. Groups are
                       counted from 0 in the order of their first cameras. Cameras of
                       different groups have no common frame */

    size_t n_views;               /* in the order of their placements; in each placement
                                     every camera at most once */
    const rigcal_rig_view *views; /* n_views, or NULL: view_source */
    rigcal_view_source view_source;
    const rigcal_view_pose *view_poses; /* n_views, or NULL: view_pose_source */
    rigcal_view_pose_source view_pose_source;
    void *context;           /* handed to both sources */
    const uint8_t *left_out; /* n_views, or NULL: none. Not 0: the view is left out, and
                                only its camera and placement are read */

    const uint8_t *roles; /* n_cameras; NULL: the first of each group is held */
    const rigcal_camera_prior *priors;     /* n_cameras; those of cameras in the role
                                          RIGCAL_CAMERA_PRIOR count */
    const rigcal_real *priors_information; /* of rigcal_priors_information: then the Sigma
                                              of each prior does not count. NULL: priors
                                              are independent of each other */
    rigcal_real sigma_px; /* noise of one coordinate of a pixel; 0: unknown. It must be
                             known if there is a prior */

    rigcal_real *work;    /* memory to work in */
    size_t work_capacity; /* its number of reals: RIGCAL_RIG_WORK */

    struct rigcal_rig_clocks *clocks; /* clocks of the cameras, see rigcal_clocks.h; NULL:
                                         all views of a placement were taken at one
                                         instant */
    const rigcal_intrinsics_sigma *intrinsics_sigmas; /* n_cameras, or NULL: exact. Only
                                                         rigcal_rig_consider reads them */
    const struct rigcal_considered *considered; /* NULL; rigcal_rig_consider sets it */
} rigcal_rig;

/* Reals of `work`, for n_cameras of which n_free are free or have a prior. As a function:
 * rigcal_rig_work. */
#define RIGCAL_RIG_WORK(n_free, n_cameras, n_placements) \
    (3 * (size_t)(n_free) * (6 * (size_t)(n_free) + 1) + 12 * (size_t)(n_free) + \
     51 * (size_t)(n_cameras) + 13 * (size_t)(n_placements))
RIGCAL_API size_t rigcal_rig_work(size_t n_free, size_t n_cameras, size_t n_placements);

/* The information of all cameras with a prior together: the inverse of their joint
 * covariance. Cameras that one calibration found need it, because their errors are not
 * independent: all contain those of the camera whose frame is the rig's. If such priors
 * count as independent, Sigma of a camera after the adjustment is some 25 % too small.
 * information, Sigma: of (w, dt) of the cameras in the role RIGCAL_CAMERA_PRIOR, in the
 * order of the rig: the lower triangle row by row, RIGCAL_CALIBRATED_SIZE(n_priors) reals.
 * information may be Sigma. OK, ERR_NULL, ERR_TOO_FEW (no prior), ERR_RANGE (more than
 * RIGCAL_STORE_FREE_MAX), ERR_NOT_FINITE, ERR_DEGENERATE (Sigma is not positive definite to
 * rounding, or its inverse is too large for a number; then information contains no result).
 * O(n_priors^3) */
RIGCAL_API rigcal_status rigcal_priors_information(rigcal_real information[],
                                                   const rigcal_real Sigma[],
                                                   size_t n_priors);

/* ==== the join =============================================================== */

/* Makes the pose of a view for the join, with its information at cam_from_target. OK,
 * ERR_NULL, those of rigcal_pose_covariance. O(n). */
RIGCAL_API rigcal_status rigcal_view_pose_make(rigcal_view_pose *pose,
                                               const rigcal_rig_view *view,
                                               const rigcal_transform *cam_from_target);

/* Computes all cameras and placements from the poses of the views, which are weighed by
 * their full information matrices. The result is close to maximum likelihood, and the
 * adjustment starts from it. Writes cams_from_rig, rig_from_placements and group. Cameras
 * that are held stay where they were. The frame of a group is theirs or that of its priors;
 * if it has neither, it is that of its first camera.
 * OK, RIGCAL_DISCONNECTED, RIGCAL_BUDGET_SPENT, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION,
 * ERR_RANGE, ERR_TOO_FEW (no camera, no view), ERR_CAPACITY, ERR_TWICE, ERR_UNSORTED,
 * ERR_DEGENERATE (the information of a view or placement is not positive definite), and
 * what a source returns.
 * *at_fault: the number of the view, or -1. Time O(n_views n_cameras). */
RIGCAL_API rigcal_status rigcal_rig_join(rigcal_rig *rig, int32_t *at_fault);

typedef struct rigcal_rig_solver rigcal_rig_solver; /* see rigcal_solvers.h */

/* The same in steps. Ask rigcal_rig_result for the result: to first order it is the fit
 * that the adjustment will have, F included. A unit is one view: checked, or its
 * quadratic, or its part of the elimination, O(n_cameras); or one row of the factor. */
RIGCAL_API rigcal_status rigcal_rig_join_begin(rigcal_rig_solver *solver, rigcal_rig *rig);
RIGCAL_API rigcal_status rigcal_rig_join_step(rigcal_rig_solver *solver, int32_t budget);

/* ==== the adjustment ========================================================= */

/* How well an adjusted rig fits. */
typedef struct rigcal_rig_fit {
    rigcal_real sum;      /* of |du|^2 / sigma_i^2 over all points, and of the priors */
    rigcal_real freedom;  /* 2 n_points - 6 (free cameras) - 6 (placements seen) - (offsets
                             and drifts that were free) */
    rigcal_real sigma_px; /* sqrt(sum / freedom); 0: no freedom */
    size_t n_points;
    int32_t evals; /* evaluations of each view, also those that settle placements */

    /* The loop closure: how much the views disagree with each other, compared with the
       errors inside each view. For noise alone F has the distribution F(freedom_between,
       freedom_within). The views disagree by sqrt(F) times what noise explains. F and its
       freedoms are 0 if there is no cycle, or no view_poses are given. */
    rigcal_real F, freedom_between, freedom_within;
} rigcal_rig_fit;

/* Adjusts cameras and placements together, by maximum likelihood in pixels over all views.
 * It starts from the poses in the rig. Afterwards the rig's `work` holds the cameras'
 * covariance: keep `work` and the rig for the functions below. OK, RIGCAL_DISCONNECTED,
 * RIGCAL_BUDGET_SPENT, the errors of rigcal_rig_join, and for views those of
 * rigcal_pose_begin, ERR_BEHIND, ERR_NO_RAY, ERR_DEGENERATE. */
RIGCAL_API rigcal_status rigcal_rig_adjust(rigcal_rig_fit *fit, int32_t *at_fault,
                                           rigcal_rig *rig);

/* The same in steps. A unit is one view's evaluation with its block, O(n) and O(n_cameras);
 * one view's part of the elimination of its placement; or one row of the factor. The
 * budgets do not change one bit of the result. `rig` must last. */
RIGCAL_API rigcal_status rigcal_rig_begin(rigcal_rig_solver *solver, rigcal_rig *rig);
RIGCAL_API rigcal_status rigcal_rig_step(rigcal_rig_solver *solver, int32_t budget);
RIGCAL_API rigcal_status rigcal_rig_result(rigcal_rig_fit *fit, int32_t *at_fault,
                                           const rigcal_rig_solver *solver);

/* ---- wrong points -----------------------------------------------------------
 *
 * Where whole views are wrong, find them first (rigcal_judge.h). Then wrong points are
 * dealt with in two rounds. Huber's loss, linear from 2 sigma, limits their effect.
 * Starting from its answer, the truncated loss, constant from 4 sigma, leaves them out
 * altogether. The points that remain have the equations of least squares, so the
 * covariance is valid as it is. The noise of stamps (rigcal_clocks.h) does not widen these
 * limits: a point is compared with where its view's stamp says it is. */

enum rigcal_losses { RIGCAL_LOSS_HUBER = 1, RIGCAL_LOSS_TRUNCATED = 2 };

/* rigcal_rig_adjust with Huber's loss and then with the truncated one. rig->sigma_px must
 * be stated. *fit is that of the points within 4 sigma, without F. *n_wrong is the number
 * of the other points: their residual (rigcal_rig_residuals) is above 4 sigma_i sigma_px,
 * or their camera cannot see them. The statuses of rigcal_rig_adjust; ERR_RANGE (also:
 * sigma_px is 0). */
RIGCAL_API rigcal_status rigcal_rig_adjust_robust(rigcal_rig_fit *fit, size_t *n_wrong,
                                                  int32_t *at_fault, rigcal_rig *rig);

/* One of the two losses in steps, by rigcal_rig_step. The result reads all points once
 * more. */
RIGCAL_API rigcal_status rigcal_rig_robust_begin(rigcal_rig_solver *solver, rigcal_rig *rig,
                                                 int32_t loss);
RIGCAL_API rigcal_status rigcal_rig_robust_result(rigcal_rig_fit *fit, size_t *n_wrong,
                                                  int32_t *at_fault,
                                                  const rigcal_rig_solver *solver);

/* ==== how sure ===============================================================
 *
 * If rigcal_rig_consider (rigcal_consider.h) has been called after the adjustment, all
 * covariances below contain the errors of the intrinsics. ERR_STATE is then also returned
 * if the rig has been adjusted again since. */

/* Sigma: covariance of (w, dt) of a camera's pose in the frame of the rig, for noise of
 * sigma_px. It is 0 for a camera that is held. OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE,
 * ERR_STATE (not adjusted). */
RIGCAL_API rigcal_status rigcal_rig_covariance(rigcal_real Sigma[36], const rigcal_rig *rig,
                                               rigcal_real sigma_px, size_t camera);

/* b_from_a, and its covariance, cross terms included. Both are the same whichever camera
 * is held. The statuses above; RIGCAL_DISCONNECTED: the two have no common frame, and
 * nothing is written. */
RIGCAL_API rigcal_status rigcal_rig_pair(rigcal_transform *b_from_a, rigcal_real Sigma[36],
                                         const rigcal_rig *rig, rigcal_real sigma_px,
                                         size_t a, size_t b);

/* Covariance of (w, dt) of rig_from_placements[placement], as if clocks were exact. It
 * evaluates the placement's views once more, all points, also those that a robust
 * adjustment left out. The statuses above, ERR_TOO_FEW (the placement has no view), and
 * those of views. O(n_views) + O(n). */
RIGCAL_API rigcal_status rigcal_rig_placement(rigcal_real Sigma[36], rigcal_rig *rig,
                                              rigcal_real sigma_px, size_t placement);

/* Noise of each camera from its own residuals. sigma_px[n_cameras] is the noise, 0 without
 * freedom. freedom[n_cameras] are the degrees of freedom: 2 n_points of the camera, less
 * what each of its views loses to the unknowns, trace(H Cov(cam_from_target)). Without
 * priors and free clocks they sum up to the freedom of rigcal_rig_fit. Clocks count as
 * exact. All points count, also those that a robust adjustment left out. The function
 * evaluates every view twice. The statuses of rigcal_rig_placement. O(n_views n_cameras) +
 * O(n). */
RIGCAL_API rigcal_status rigcal_rig_noise(rigcal_real sigma_px[], rigcal_real freedom[],
                                          rigcal_rig *rig);

/* The residuals of one view. duv gets (du, dv) [px] of each of its n points, observed
 * minus projected. *n_written is the number of points n. OK, ERR_NULL, ERR_RANGE,
 * ERR_CAPACITY (2 n > capacity), those of views and sources. */
RIGCAL_API rigcal_status rigcal_rig_residuals(rigcal_real duv[], size_t capacity,
                                              size_t *n_written, const rigcal_rig *rig,
                                              size_t view);

/* ==== a calibrated rig, to keep ============================================== */

/* What to keep when the views and `work` are gone: the cameras, and the joint covariance
 * of their poses. The caller owns the arrays. */
typedef struct rigcal_calibrated_rig {
    rigcal_mounted_camera *cameras; /* Sigma of each: its block of the joint covariance */
    int32_t *group;                 /* as of rigcal_rig */
    uint8_t *held;                  /* 1: the camera is held and has no unknowns; else 0 */
    size_t capacity;                /* of each of the three arrays, in cameras */
    rigcal_real *Sigma;    /* covariance of (w, dt) of all cameras that are not held, in
                              their order: the lower triangle row by row */
    size_t Sigma_capacity; /* its number of reals: RIGCAL_CALIBRATED_SIZE */
    size_t n_cameras;      /* 1 .. RIGCAL_STORE_CAMERAS_MAX */
    rigcal_real sigma_px;  /* noise for which Sigma is; 0: there is no joint covariance */
    rigcal_real F, freedom_between, freedom_within; /* as in rigcal_rig_fit */
} rigcal_calibrated_rig;

/* Reals of Sigma for n_free cameras that are not held, at most RIGCAL_STORE_FREE_MAX. */
#define RIGCAL_STORE_FREE_MAX 3800
#define RIGCAL_CALIBRATED_SIZE(n_free) (3 * (size_t)(n_free) * (6 * (size_t)(n_free) + 1))
RIGCAL_API size_t rigcal_calibrated_size(size_t n_free);

/* Takes a calibrated rig out of an adjusted rig. sigma_px > 0 is the noise for which Sigma
 * is computed. If the views disagree, use the noise of the pixels times sqrt(F), which is
 * that of rigcal_considered_fit if intrinsics were considered. Writes all but the pointers,
 * the capacities and cameras[i].camera, which the caller fills in.
 * fit: that of the adjustment, or NULL: F is not known. OK, ERR_CAPACITY, and those of
 * rigcal_rig_covariance; after an error nothing is written. O(n_cameras^2) */
RIGCAL_API rigcal_status rigcal_calibrated_take(rigcal_calibrated_rig *out,
                                                const rigcal_rig *rig,
                                                const rigcal_rig_fit *fit,
                                                rigcal_real sigma_px);

/* Sigma[6 i + j]: covariance of element i of (w, dt) of camera a with element j of (w, dt)
 * of camera b. If a == b, it is the covariance of one camera. It is 0 if either camera is
 * held. OK, ERR_NULL, ERR_TOO_FEW (no camera), ERR_CAPACITY, ERR_NOT_FINITE, ERR_RANGE,
 * ERR_STATE (sigma_px is 0). */
RIGCAL_API rigcal_status rigcal_calibrated_covariance(rigcal_real Sigma[36],
                                                      const rigcal_calibrated_rig *rig,
                                                      size_t a, size_t b);

/* As rigcal_rig_pair. The statuses above, ERR_ROTATION, RIGCAL_DISCONNECTED. */
RIGCAL_API rigcal_status rigcal_calibrated_pair(rigcal_transform *b_from_a,
                                                rigcal_real Sigma[36],
                                                const rigcal_calibrated_rig *rig, size_t a,
                                                size_t b);

/* Bytes that a calibrated rig takes; see "store" in rigcal.h. The function returns 0 for
 * counts that cannot be stored. */
#define RIGCAL_STORE_RIG_SIZE_OF(n, n_free, real_bytes) \
    (RIGCAL_STORE_HEADER_BYTES + 4 * (size_t)(real_bytes) + \
     (size_t)(n) * (20 + 24 * (size_t)(real_bytes)) + \
     RIGCAL_CALIBRATED_SIZE(n_free) * (size_t)(real_bytes))
#define RIGCAL_STORE_RIG_SIZE(n, n_free) \
    RIGCAL_STORE_RIG_SIZE_OF(n, n_free, sizeof(rigcal_real))
RIGCAL_API size_t rigcal_store_rig_size(size_t n_cameras, size_t n_free);

/* As rigcal_store_save, for a calibrated rig. cameras[i].Sigma and has_Sigma are not read,
 * because the joint covariance contains them. The function refuses a joint covariance with
 * variances below 0, correlations beyond 1, or a camera's block that is no covariance. The
 * statuses of rigcal_store_save, and ERR_STATE (sigma_px is 0). */
RIGCAL_API rigcal_status rigcal_store_save_rig(uint8_t bytes[], size_t capacity,
                                               size_t *n_bytes,
                                               const rigcal_calibrated_rig *rig,
                                               uint32_t sequence, uint32_t tag);

/* As rigcal_store_load, for a calibrated rig. The caller sets the arrays of rig and their
 * capacities; rigcal_store_info tells how large they must be. Bytes of rigcal_store_save
 * can be loaded too. They have no joint covariance: then sigma_px is 0, each camera has
 * its own Sigma, and rig->Sigma may be NULL. The statuses of rigcal_store_load. */
RIGCAL_API rigcal_status rigcal_store_load_rig(rigcal_calibrated_rig *rig,
                                               rigcal_saved_info *info,
                                               const uint8_t bytes[], size_t n_bytes);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_RIG_H */
