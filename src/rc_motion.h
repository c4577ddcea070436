/* rc_motion.h - how a target moves: the curve through placements that are near in time
 * (CLOCKS in EQUATIONS.md). It stores nothing but a pose and a time of each placement. */
#ifndef RC_MOTION_H
#define RC_MOTION_H

#include "rc_chain.h"

/* The placements of a rig in the order of time. */
typedef struct {
    const rigcal_transform *poses; /* n: rig_from_placements */
    const rigcal_real *times; /* n [s], rising; unknown: NaN or above RC_COORDINATE_MAX */
    size_t n;
    rigcal_real longest; /* longest step from one placement of a run to the next [s] */
    int32_t neighbours;  /* the most of one placement: 1 .. RIGCAL_MOTION_MOST */
} rc_path;

/* (H1), (H2): the motion at placement f, from its nearest neighbours in its unbroken run.
 * They are taken from both sides in turn, while there are any. */
void rc_motion_of(rigcal_motion *motion, const rc_path *path, size_t f);

/* (H2): d, by which rc_transform_move takes the placement to where it is `after` its time,
 * and its velocity xi there. */
void rc_motion_at(rigcal_real d[6], rigcal_real xi[6], const rigcal_motion *motion,
                  rigcal_real after);

/* (H3): m = B xi, the (w, dt) by which cam_from_target moves in a second. */
void rc_motion_seen(rigcal_real m[6], const rc_chain *chain, const rigcal_real xi[6]);

#endif /* RC_MOTION_H */
