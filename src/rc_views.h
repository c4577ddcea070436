/* rc_views.h - what is handed in of a rig: its memory to work in, its views one by one,
 * their checks, and which cameras they connect. */
#ifndef RC_VIEWS_H
#define RC_VIEWS_H

#include "rc_chain.h"
#include "rc_points.h"

/* What an adjustment takes from the clocks of a rig, which has them by
 * rigcal_clocks_defaults alone: a program without clocks does not have these functions. */
struct rigcal_clock_calls {
    /* Begins a search that rc_rig_begin has begun; or ends it, with an error of what is
     * handed in. */
    rigcal_status (*begin)(rigcal_rig_solver *s);

    /* A placement to where a view sees it. */
    void (*place)(rigcal_transform *rig_from_placement, const rigcal_rig *rig,
                  int32_t camera, size_t placement, size_t view);

    /* Takes the noise of its stamp out of the equations of the view placed last. */
    void (*weigh)(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                  const rc_chain *chain, const rigcal_rig *rig);
};

typedef struct rc_rig_parts rc_rig_parts;

/* What is given of a view, its points or its own pose: functions to check view s->view,
 * counting what s counts, and to make its equations where the rig is: *sum, g and H by
 * (w, dt) of cam_from_target. And a unit of the search, and the cameras' part of its step,
 * which are others where a rig has clocks. */
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
    rigcal_real *count;      /* of each placement, its views; less than 0: all left out */
    rigcal_real *column;     /* of each camera, its first unknown; -1: it is held */
    rigcal_real *slot;       /* of each view of a placement, the same */
    rigcal_real *W;          /* 36 of each view of a placement */
    rigcal_transform *saved; /* the cameras, the placements */
    rigcal_real *S, *g;      /* of the cameras, packed; then the covariance, and the step */
    rigcal_real *d;          /* the diagonal before placements were eliminated */
};

void rc_rig_parts_of(rc_rig_parts *parts, const rigcal_rig *rig, size_t n_unknowns);

/* OK, or ERR_RANGE: not a camera and a placement of the rig. */
rigcal_status rc_rig_numbers(const rigcal_rig *rig, int32_t camera, int32_t placement);

/* View `index`, of what the caller gives: of a camera and placement of the rig, whenever it
 * is asked. */
rigcal_status rc_rig_view_at(rigcal_rig_view *out, const rigcal_rig *rig, size_t index);
rigcal_status rc_rig_pose_at(rigcal_view_pose *out, const rigcal_rig *rig, size_t index);

/* What is handed to a public step: the phase of its solver, NULL if there is no solver. OK;
 * ERR_NULL; ERR_STATE: it has not begun; ERR_RANGE of the budget. */
rigcal_status rc_check_step(const int32_t *phase, int32_t budget);

/* OK; of a pose of a view ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE, ERR_DEGENERATE. */
rigcal_status rc_check_pose(const rigcal_view_pose *pose);

/* 1 / variance of a view's rotation, for noise of 1 px [1/rad^2]. */
rigcal_real rc_view_information(const rigcal_view_pose *pose);

/* Of the turn between two cameras, by two views of one placement: their variances are
 * added. */
rigcal_real rc_information_of_both(rigcal_real a, rigcal_real b);

/* Pointers and counts; not what they point to. */
rigcal_status rc_rig_check(const rigcal_rig *rig);

/* The points of a view, which count from the target's own origin. OK, and the errors of a
 * view. */
rigcal_status rc_rig_points(rigcal_points *points, const rigcal_rig_view *view);

/* How many views there are of a placement, left out or not: they follow one another. */
size_t rc_rig_views_of(const rc_rig_parts *parts, size_t placement);

/* The chain of a view, where the rig is and the clocks stand. */
void rc_rig_chain(rc_chain *chain, const rigcal_rig *rig, int32_t camera, size_t placement,
                  size_t view);

int rc_rig_is_left_out(const rigcal_rig *rig, size_t view);
int rc_rig_is_held(const rigcal_rig *rig, size_t camera);
int rc_rig_has_prior(const rigcal_rig *rig, size_t camera);

/* Whether the memory to work in holds what an adjustment leaves there: unknowns in the
 * order of their cameras, and variances above 0. *parts: where its parts begin. */
int rc_rig_is_adjusted(rc_rig_parts *parts, const rigcal_rig *rig);

/* The memory to work in holds no covariance of the cameras. */
void rc_rig_forget(const rigcal_rig *rig);

/* Checks cameras, then view by view: counts those of each placement, groups the cameras
 * that they connect, and numbers the unknowns. RUNNING until the last; the view at fault is
 * s->view, if there is one. */
rigcal_status rc_views_begin(rigcal_rig_solver *s);
rigcal_status rc_views_step(rigcal_rig_solver *s);

#endif /* RC_VIEWS_H */
