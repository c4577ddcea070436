/* rc_adjust.h - adjusts all cameras and placements of a rig by least squares. Each
 * placement is eliminated after its views were added (RIG in EQUATIONS.md). The views are
 * given by their points, or, in the join, by their own poses and information. */
#ifndef RC_ADJUST_H
#define RC_ADJUST_H

#include "rc_chain.h"
#include "rc_levenberg.h"
#include "rc_views.h"

/* The points of a view, which has been checked. They count from the target's own origin. */
void rc_rig_points_of(rigcal_points *points, const rigcal_rig_view *view);

/* Checks view s->view, which is given by its points. */
rigcal_status rc_rig_check_points(int32_t *camera, int32_t *placement,
                                  rigcal_rig_solver *s);

/* The equations of one view at cam_from_target: *sum, g and H by its (w, dt). */
rigcal_status rc_rig_equations(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                               const rigcal_rig_view *view,
                               const rigcal_transform *cam_from_target);

/* The same for view number `view` at its present pose, by its present clocks. Also returns
 * its chain. */
rigcal_status rc_rig_view_equations(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                                    rc_chain *chain, const rigcal_rig_view *v,
                                    const rigcal_rig *rig, size_t view);

/* Begins a search. Each step does one unit, until s->phase is RC_RIG_DONE. `given`: whether
 * views are given by their points or, in the join, by their own poses. After all checks the
 * phase is RC_RIG_CHECKED. Then the poses from which the search starts may be set; for this
 * the join has two phases of its own. OK or ERR_CAPACITY. After another error the search is
 * done at once. */
enum {
    RC_RIG_DONE = 1,
    RC_RIG_CHECKED,
    RC_RIG_PLACING,
    RC_RIG_REACHING,
    RC_RIG_CHECKING,    /* checks the input, view by view */
    RC_RIG_SETTLING,    /* adds views for the placement's own step */
    RC_RIG_REDUCING,    /* adds views by camera and placement */
    RC_RIG_ELIMINATING, /* eliminates the placement from a camera */
    RC_RIG_PRIORS,      /* adds the prior of a camera */
    RC_RIG_FACTORING,   /* factors a row of the cameras' equations */
    RC_RIG_INVERTING,
    RC_RIG_SQUARING
};
extern const struct rigcal_rig_given rc_given_points;
rigcal_status rc_rig_begin(rigcal_rig_solver *s, rigcal_rig *rig,
                           const struct rigcal_rig_given *given);

/* Begins a search as rc_rig_begin does, after the checks of an adjustment, which has views
 * and starts where the rig is. */
rigcal_status rc_rig_begin_points(rigcal_rig_solver *s, rigcal_rig *rig,
                                  const struct rigcal_rig_given *given);

/* One unit, for views of one instant. rc_rig_move moves the cameras by the step. */
void rc_rig_step(rigcal_rig_solver *s);
void rc_rig_move(const rigcal_rig_solver *s, const rc_rig_parts *parts);

/* Ends the search without a covariance. at_fault: a view, or -1. */
void rc_rig_end(rigcal_rig_solver *s, rigcal_status status, int32_t at_fault);

/* The status of a search that is done. */
rigcal_status rc_rig_outcome(int32_t *at_fault, const rigcal_rig_solver *s);

#endif /* RC_ADJUST_H */
