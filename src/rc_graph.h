/* rc_graph.h - the information that two cameras share (CHOICE in EQUATIONS.md). */
#ifndef RC_GRAPH_H
#define RC_GRAPH_H

#include "rc_views.h"

/* Only the check of the views' poses, for rc_views_begin. */
extern const struct rigcal_rig_given rc_given_poses;

#endif /* RC_GRAPH_H */
