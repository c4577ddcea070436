/* rigcal_clocks.h - a rig whose cameras have clocks of their own. Included by rigcal.h,
 * whose first page holds here too.
 *
 * A target that moves is somewhere else when a camera is late. Between placements that are
 * near in time its motion is known, so that the adjustment can tell how late each camera
 * is.
 *
 *   rigcal_clocks_defaults   then the times, the offsets, and rigcal_rig.clocks = &clocks
 *   rigcal_rig_adjust        as ever: cameras, placements and clocks together
 *   rigcal_clocks_sigma      how sure each clock is
 *   rigcal_clocks_frames     by how many frames the stamps of a camera are off
 *
 * EQUATIONS.md CLOCKS has the mathematics. */
#ifndef RIGCAL_H
#include "rigcal.h" /* which includes this one in its turn */
#endif

#ifndef RIGCAL_CLOCKS_H
#define RIGCAL_CLOCKS_H

#ifdef __cplusplus
extern "C" {
#endif

/* What is known of the clock of a camera after an adjustment. */
enum rigcal_clock_states {
    RIGCAL_CLOCK_HELD = 0,  /* as it was handed in. So is that of a camera without views */
    RIGCAL_CLOCK_FREE = 1,  /* estimated */
    RIGCAL_CLOCK_ALONE = 2, /* held: no placement of its views has a neighbour in time */
    RIGCAL_CLOCK_STILL = 3  /* held: the target hardly moves there */
};

struct rigcal_clock_calls; /* the library's own */

/* The motion of a target about one of its placements: its (w, dt) at the time x after that
 * is x (c[0] + (x - t[0]) (c[1] + (x - t[1]) (...))). t: the times of its neighbours. */
enum rigcal_motion_limits { RIGCAL_MOTION_MOST = 4 };
typedef struct rigcal_motion {
    int32_t n; /* neighbours in time that the curve leads through; 0: unknown */
    rigcal_real t[RIGCAL_MOTION_MOST], c[RIGCAL_MOTION_MOST][6];
} rigcal_motion;

/* What the library remembers from one view to the next. */
typedef struct rigcal_clock_memory {
    int32_t pass;      /* of the adjustment */
    int32_t is_moved;  /* 1: some view is of another instant than its placement */
    int32_t placement; /* whose motion that is; -1: of none */
    rigcal_motion motion;
    rigcal_real step[6], moved; /* to the nearest placement; against its noise */
    rigcal_real views, late;    /* of the placement: its views, and the sum of `after` */
    rigcal_real velocity[6];    /* of the view placed last */
    rigcal_real after, since;   /* its time after the placement; its stamp after `middle` */
    rigcal_real middle, ratio2; /* (noise of a pixel / noise of a stamp)^2 */
} rigcal_clock_memory;

/* Times count from about the start of the recording, in seconds or in any other unit: in
 * float they are exact to 1 ms up to 8000 s. Camera c sees at the stamp t what the target
 * does at t + offsets[c] + drifts[c] (t - middle), where middle is half way from the first
 * to the last of `times`. */
typedef struct rigcal_rig_clocks {
    const struct rigcal_clock_calls *calls; /* rigcal_clocks_defaults sets it */
    const rigcal_real *times; /* n_placements: the stamp of each, rising from one to the
                                      next; NaN: not known */
    const rigcal_real *view_times; /* n_views, or NULL: the stamp of each view; NaN: that
                                      of its placement */
    rigcal_real
        *instants;        /* n_placements, written: when rig_from_placements holds, the mean
                              time of the placement's views by the clocks. Above 1e30
                              (float 1e9): not known */
    rigcal_real *offsets; /* n_cameras: in, where to start; out, how late each is */
    rigcal_real *drifts;  /* n_cameras, or NULL: 0 */
    const uint8_t *held;  /* n_cameras, or NULL: none; not 0: that clock is right as it is.
                              Of a group without one, the first camera with views is held */
    int32_t *states;      /* n_cameras, written: RIGCAL_CLOCK_ */
    int32_t free_offsets, free_drifts; /* 1: estimate them; 0: as they are handed in */
    int32_t neighbours;     /* of a placement, by which its motion is known: 1 .. 4 */
    rigcal_real frame;      /* time from one frame to the next; 0: find it in `times`, and
                              write it: the middle one of the steps below 0.35 */
    rigcal_real sigma_time; /* noise of the stamp of a view by itself; 0: none. The noise of
                               a pixel must be known: rig->sigma_px, or view_poses */
    rigcal_clock_memory memory; /* the library's own */
} rigcal_rig_clocks;

/* All 0 but calls, and neighbours, which are 4. OK, ERR_NULL. */
RIGCAL_API rigcal_status rigcal_clocks_defaults(rigcal_rig_clocks *clocks);

/* Reals of the rig's memory to work in, beyond RIGCAL_RIG_WORK or RIGCAL_JUDGE_WORK, for a
 * rig with clocks. The same as a function: rigcal_clocks_work. */
#define RIGCAL_CLOCKS_WORK(n_free, n_cameras) \
    (12 * (size_t)(n_free) * (size_t)(n_cameras) + \
     (size_t)(n_cameras) * (2 * (size_t)(n_cameras) + 23))
RIGCAL_API size_t rigcal_clocks_work(size_t n_free, size_t n_cameras);

/* Standard deviations of offsets, and of drifts (NULL: not asked), each of n_cameras, for
 * noise of sigma_px; 0 of one that is not free. OK, ERR_NULL (no clocks too), ERR_RANGE,
 * ERR_STATE (not adjusted). O(n_cameras) */
RIGCAL_API rigcal_status rigcal_clocks_sigma(rigcal_real offsets[], rigcal_real drifts[],
                                             const rigcal_rig *rig, rigcal_real sigma_px);

/* frames[n_cameras]: offsets in frames, rounded. Not all 0: the views that belong together
 * carry other numbers. Give those of camera c the placement that is frames[c] later, and
 * adjust again. OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE (frame is not above 0). */
RIGCAL_API rigcal_status rigcal_clocks_frames(int32_t frames[],
                                              const rigcal_rig_clocks *clocks,
                                              size_t n_cameras);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_CLOCKS_H */
