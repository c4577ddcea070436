/* rc_views.h - the input of a rig: its memory to work in, its views one by one, their
 * checks, and which cameras they connect. */
#ifndef RC_VIEWS_H
#define RC_VIEWS_H

#include "rc_chain.h"
#include "rc_points.h"

/* ---- constants ----------------------------------------------------------- */

/* sigma: by the truncated loss a larger error counts as much as one of this size. So the
 * point is left out. */
#define RC_TRUNCATED_FROM RC(4)

/* sigma: Huber's loss is linear for larger errors. */
#define RC_HUBER_FROM RC(2)

/* ---- functions ----------------------------------------------------------- */

/* What an adjustment needs of the clocks of a rig. Only rigcal_clocks_defaults sets these
 * pointers, so a program without clocks does not link the functions. */
struct rigcal_clock_calls {
    /* Begins the clocks' part of a search that rc_rig_begin has begun. Ends the search if
     * the input has an error. */
    rigcal_status (*begin)(rigcal_rig_solver *s);

    /* Moves a placement to where a view sees it. */
    void (*place)(rigcal_transform *rig_from_placement, const rigcal_rig *rig,
                  int32_t camera, size_t placement, size_t view);

    /* Eliminates the noise of the stamp from the equations of the view that was placed
     * last. */
    void (*weigh)(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                  const rc_chain *chain, const rigcal_rig *rig);
};

typedef struct rc_rig_parts rc_rig_parts;

/* Functions for views that are given by their points or by their own poses. `check` checks
 * view s->view and counts what s counts. `equations` makes the equations of the view where
 * the rig is: *sum, g and H by (w, dt) of cam_from_target, without the noise of stamps.
 * `step` is one unit of the search, `move` moves the cameras by its step. The last two
 * differ if a rig has clocks. */
struct rigcal_rig_given {
    rigcal_status (*check)(int32_t *camera, int32_t *placement, rigcal_rig_solver *s);
    rigcal_status (*equations)(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                               rc_chain *chain, int32_t *camera,
                               const rigcal_rig_solver *s);
    void (*step)(rigcal_rig_solver *s);
    void (*move)(const rigcal_rig_solver *s, const rc_rig_parts *parts);
    int is_join;
};

/* Where the parts of rig->work begin. */
struct rc_rig_parts {
    rigcal_real *count;      /* of each placement: its views; below 0: all are left out */
    rigcal_real *column;     /* of each camera: its first unknown; -1: held */
    rigcal_real *slot;       /* of each view of a placement: the same */
    rigcal_real *W;          /* 36 of each view of a placement */
    rigcal_transform *saved; /* poses of the cameras, then of the placements */
    rigcal_real *S, *g;      /* S of the cameras, packed, later the covariance; the step */
    rigcal_real *d;          /* the diagonal before placements were eliminated */
};

void rc_rig_parts_of(rc_rig_parts *parts, const rigcal_rig *rig, size_t n_unknowns);

/* OK, or ERR_RANGE: these are not a camera and a placement of the rig. */
rigcal_status rc_rig_numbers(const rigcal_rig *rig, int32_t camera, int32_t placement);

/* View `index`, and its pose, as the caller gives them. ERR_RANGE if they are not of a
 * camera and placement of the rig, which is checked at each call. */
rigcal_status rc_rig_view_at(rigcal_rig_view *out, const rigcal_rig *rig, size_t index);
rigcal_status rc_rig_pose_at(rigcal_view_pose *out, const rigcal_rig *rig, size_t index);

/* Checks the arguments of a public step. phase is that of its solver, or NULL if there is
 * no solver. OK; ERR_NULL; ERR_STATE: it has not begun; ERR_RANGE: the budget. */
rigcal_status rc_check_step(const int32_t *phase, int32_t budget);

/* Checks a pose of a view: OK, ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE, ERR_DEGENERATE. */
rigcal_status rc_check_pose(const rigcal_view_pose *pose);

/* 1 / variance of a view's rotation, for noise of 1 px [1/rad^2]. */
rigcal_real rc_view_information(const rigcal_view_pose *pose);

/* The information on the turn between two cameras from two views of one placement. Their
 * variances add up. */
rigcal_real rc_information_of_both(rigcal_real a, rigcal_real b);

/* Checks pointers and counts, not what the pointers point to. */
rigcal_status rc_rig_check(const rigcal_rig *rig);

/* The points of a view. They count from the target's own origin. OK, and the errors of a
 * view. */
rigcal_status rc_rig_points(rigcal_points *points, const rigcal_rig_view *view);

/* The weight of point i of a view in an adjustment by a loss of rigcal_losses, over
 * sigma_i^2. 0: by this loss it does not count. The loss 0 is that of least squares, for
 * which sigma_px is not read. */
rigcal_real rc_rig_weight(const rigcal_points *points,
                          const rigcal_transform *cam_from_target, size_t i, int32_t loss,
                          rigcal_real sigma_px);

/* Number of views of a placement, left out or not. They follow one another. */
size_t rc_rig_views_of(const rc_rig_parts *parts, size_t placement);

/* The chain of a view, with the poses and clocks as they are. */
void rc_rig_chain(rc_chain *chain, const rigcal_rig *rig, int32_t camera, size_t placement,
                  size_t view);

int rc_rig_is_left_out(const rigcal_rig *rig, size_t view);
int rc_rig_is_held(const rigcal_rig *rig, size_t camera);
int rc_rig_has_prior(const rigcal_rig *rig, size_t camera);

/* Checks the role of a camera, and its prior if it has one. */
rigcal_status rc_rig_check_camera(const rigcal_rig *rig, size_t camera);

/* The equations of a camera's prior (G7), in pixels: what it adds to the sum, g and H, and,
 * if parts is not NULL, to S left of the camera's own block. O(n_cameras). OK, or
 * ERR_DEGENERATE: its covariance is not one. */
rigcal_status rc_rig_prior(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                           const rc_rig_parts *parts, const rigcal_rig *rig, size_t camera);

/* Whether the memory to work in holds what an adjustment leaves there: unknowns in the
 * order of their cameras, and variances above 0. *parts says where its parts begin. */
int rc_rig_is_adjusted(rc_rig_parts *parts, const rigcal_rig *rig);

/* Marks that the memory to work in holds no covariance of the cameras. */
void rc_rig_forget(const rigcal_rig *rig);

/* Check the cameras, then one view a step. They count the views of each placement, group
 * the cameras that these connect, and number the unknowns. RUNNING until the last view.
 * s->view is the view at fault, if there is one. */
rigcal_status rc_views_begin(rigcal_rig_solver *s);
rigcal_status rc_views_step(rigcal_rig_solver *s);

#endif /* RC_VIEWS_H */
