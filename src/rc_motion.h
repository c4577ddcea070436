/* rc_motion.h - how a target moves: the curve through its placements near in time (CLOCKS
 * in EQUATIONS.md). Nothing is stored beyond a pose and a time of each placement. */
#ifndef RC_MOTION_H
#define RC_MOTION_H

#include "rc_chain.h"

/* The placements of a rig in time. */
typedef struct {
    const rigcal_transform *poses; /* n: rig_from_placements */
    const rigcal_real *times; /* n [s], rising; above RC_COORDINATE_MAX, NaN: unknown */
    size_t n;
    rigcal_real longest; /* step from one placement to the next of a run [s] */
    int32_t neighbours;  /* at most, of one placement: 1 .. RIGCAL_MOTION_MOST */
} rc_path;

/* (H1), (H2): of placement f, by its nearest neighbours in its unbroken run, as many on
 * each side where there are. */
void rc_motion_of(rigcal_motion *motion, const rc_path *path, size_t f);

/* (H2): d, what takes the placement to where it is `after` its time, for rc_transform_move;
 * and its velocity xi there. */
void rc_motion_at(rigcal_real d[6], rigcal_real xi[6], const rigcal_motion *motion,
                  rigcal_real after);

/* (H3): m = B xi, by which cam_from_target moves in a second, as (w, dt). */
void rc_motion_seen(rigcal_real m[6], const rc_chain *chain, const rigcal_real xi[6]);

#endif /* RC_MOTION_H */
