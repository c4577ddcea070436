/* rc_graph.h - what a view tells, and what two cameras have in common (CHOICE in
 * EQUATIONS.md). */
#ifndef RC_GRAPH_H
#define RC_GRAPH_H

#include "rc_views.h"

/* OK, or what is wrong with a pose of a view. */
rigcal_status rc_check_pose(const rigcal_view_pose *pose);

/* The check alone, of the poses of the views: for rc_views_begin. */
extern const struct rigcal_rig_given rc_given_poses;

/* 1 / variance of a view's rotation, for noise of 1 px [1/rad^2]. */
rigcal_real rc_view_information(const rigcal_view_pose *pose);

/* Of the turn between two cameras, by two views of one placement: inverse variances as they
 * are added. */
rigcal_real rc_information_of_both(rigcal_real a, rigcal_real b);

#endif /* RC_GRAPH_H */
