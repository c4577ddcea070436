/* rc_times.h - the time of each view of a rig whose cameras have clocks, and where it sees
 * its placement (CLOCKS in EQUATIONS.md). */
#ifndef RC_TIMES_H
#define RC_TIMES_H

#include "rc_motion.h"
#include "rc_views.h"

/* Whether a time is known: it is finite, and within RC_COORDINATE_MAX. */
int rc_times_is_known(rigcal_real time);

/* What is handed in of clocks, but for their calls; finds the frame and the middle. */
rigcal_status rc_times_check(const rigcal_rig *rig);

/* The stamp of a view, which may not be known; and what its camera's clock makes of it. */
rigcal_real rc_times_stamp(const rigcal_rig_clocks *clocks, size_t placement, size_t view);
rigcal_real rc_times_of(const rigcal_rig_clocks *clocks, rigcal_real stamp, size_t camera);

/* The placements with these poses, at their instants. */
void rc_times_path(rc_path *path, const rigcal_rig *rig, const rigcal_transform poses[]);

/* rigcal_clock_calls.place and .weigh. The motion of clocks->memory.placement is that of
 * clocks->memory, of others it is found anew. */
void rc_times_place(rigcal_transform *rig_from_placement, const rigcal_rig *rig,
                    int32_t camera, size_t placement, size_t view);
void rc_times_weigh(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                    const rc_chain *chain, const rigcal_rig *rig);

#endif /* RC_TIMES_H */
