/* rc_times.h - the time of each view of a rig whose cameras have clocks, and where it sees
 * its placement (CLOCKS in EQUATIONS.md). */
#ifndef RC_TIMES_H
#define RC_TIMES_H

#include "rc_motion.h"
#include "rc_views.h"

/* Checks what the caller gave of clocks, except their calls; finds the frame and the
 * middle. */
rigcal_status rc_times_check(const rigcal_rig *rig);

/* The motion of a placement, of which *poses are all. */
void rc_times_motion(rigcal_motion *motion, const rigcal_rig *rig,
                     const rigcal_transform poses[], size_t placement);

/* rigcal_clock_calls.place and .weigh. The motion of clocks->memory.placement is that of
 * clocks->memory, of others it is found anew. */
void rc_times_place(rigcal_transform *rig_from_placement, const rigcal_rig *rig,
                    int32_t camera, size_t placement, size_t view);
void rc_times_weigh(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                    const rc_chain *chain, const rigcal_rig *rig);

#endif /* RC_TIMES_H */
