/* rc_adjust.h - all cameras and placements of a rig by least squares, each placement
 * eliminated as it streams by (RIG in EQUATIONS.md). The views are given by their points,
 * or by their own poses and information, which is the join. */
#ifndef RC_ADJUST_H
#define RC_ADJUST_H

#include "rc_chain.h"
#include "rc_levenberg.h"
#include "rc_views.h"

/* The points of a view that was checked; they count from the target's own origin. */
void rc_rig_points_of(rigcal_points *points, const rigcal_rig_view *view);

/* Checks view s->view by its points. */
rigcal_status rc_rig_check_points(int32_t *camera, int32_t *placement,
                                  rigcal_rig_solver *s);

/* One view at cam_from_target: *sum, g and H by (w, dt) of that. */
rigcal_status rc_rig_equations(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                               const rigcal_rig_view *view,
                               const rigcal_transform *cam_from_target);

/* View `view`, where the rig is and the clocks stand: the same, and its chain. */
rigcal_status rc_rig_view_equations(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                                    rc_chain *chain, const rigcal_rig_view *v,
                                    const rigcal_rig *rig, size_t view);

/* Begins a search; steps do one unit each until s->phase is RC_RIG_DONE. `given`: views by
 * their points, or by their own poses, which is the join. Once all has been checked the
 * phase is RC_RIG_CHECKED: then the poses from which the search starts may be set, for
 * which the join has two phases. OK or ERR_CAPACITY; of other errors it is done at once. */
enum {
    RC_RIG_DONE = 1,
    RC_RIG_CHECKED,
    RC_RIG_PLACING,
    RC_RIG_REACHING,
    RC_RIG_CHECKING,    /* what is handed in, view by view */
    RC_RIG_SETTLING,    /* a placement's own step, its views' equations being added */
    RC_RIG_REDUCING,    /* its views' equations, by camera and placement */
    RC_RIG_ELIMINATING, /* the placement, from the equations of one of its cameras */
    RC_RIG_PRIORS,      /* what is known of the cameras beforehand */
    RC_RIG_FACTORING,   /* a row of the cameras' equations */
    RC_RIG_INVERTING,
    RC_RIG_SQUARING
};
extern const struct rigcal_rig_given rc_given_points;
rigcal_status rc_rig_begin(rigcal_rig_solver *s, rigcal_rig *rig,
                           const struct rigcal_rig_given *given);

/* The same, and the checks of an adjustment from where the rig is, which has views. */
rigcal_status rc_rig_begin_points(rigcal_rig_solver *s, rigcal_rig *rig,
                                  const struct rigcal_rig_given *given);

/* One unit, as of views of one instant; and the cameras' part of a step. */
void rc_rig_step(rigcal_rig_solver *s);
void rc_rig_move(const rigcal_rig_solver *s, const rc_rig_parts *parts);

/* Ends it, without a covariance. at_fault: a view, or -1. */
void rc_rig_end(rigcal_rig_solver *s, rigcal_status status, int32_t at_fault);

/* Of a search that is done. */
rigcal_status rc_rig_outcome(int32_t *at_fault, const rigcal_rig_solver *s);

#endif /* RC_ADJUST_H */
