/* rc_times.h - the time of each view of a rig whose cameras have clocks, and where the view
 * sees its placement (CLOCKS in EQUATIONS.md). */
#ifndef RC_TIMES_H
#define RC_TIMES_H

#include "rc_motion.h"
#include "rc_views.h"

/* Checks what the caller gave of clocks, except the function pointers. Finds the duration
 * of a frame and the middle of the recording. */
rigcal_status rc_times_check(const rigcal_rig *rig);

/* The motion of a placement. poses has the poses of all placements. */
void rc_times_motion(rigcal_motion *motion, const rigcal_rig *rig,
                     const rigcal_transform poses[], size_t placement);

/* How long after the time `from` a view was taken, by its camera's clock. Sets
 * clocks->memory.since. */
rigcal_real rc_times_after(const rigcal_rig *rig, int32_t camera, size_t placement,
                           size_t view, rigcal_real from);

/* rigcal_clock_calls.place and .weigh. clocks->memory has the motion of placement
 * clocks->memory.placement. For another placement the motion is computed anew. */
void rc_times_place(rigcal_transform *rig_from_placement, const rigcal_rig *rig,
                    int32_t camera, size_t placement, size_t view);
void rc_times_weigh(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                    const rc_chain *chain, const rigcal_rig *rig);

#endif /* RC_TIMES_H */
