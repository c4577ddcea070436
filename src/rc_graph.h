/* rc_graph.h - what two cameras have in common (CHOICE in
 * EQUATIONS.md). */
#ifndef RC_GRAPH_H
#define RC_GRAPH_H

#include "rc_views.h"

/* The check alone, of the poses of the views: for rc_views_begin. */
extern const struct rigcal_rig_given rc_given_poses;

#endif /* RC_GRAPH_H */
