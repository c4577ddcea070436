/* rigcal_clocks.h - a rig whose cameras have clocks of their own. Included by rigcal.h,
 * whose first page holds here too.
 *
 * When a camera is late, a moving target has gone on. Between placements that are near in
 * time, the target's motion is known. From that motion the adjustment can tell how late
 * each camera is.
 *
 *   rigcal_clocks_defaults   then set the times, the offsets, and rigcal_rig.clocks
 *   rigcal_rig_adjust        as always; it adjusts cameras, placements and clocks
 *   rigcal_clocks_sigma      the standard deviation of each clock's offset and drift
 *   rigcal_clocks_frames     by how many frames the stamps of a camera are off
 *
 * EQUATIONS.md CLOCKS has the mathematics. */
#ifndef RIGCAL_H
#include "rigcal.h" /* rigcal.h includes this header too */
#endif

#ifndef RIGCAL_CLOCKS_H
#define RIGCAL_CLOCKS_H

#ifdef __cplusplus
extern "C" {
#endif

/* What is known of the clock of a camera after an adjustment. */
enum rigcal_clock_states {
    RIGCAL_CLOCK_HELD = 0,  /* stays as handed in. So does the clock of a camera without
                               views */
    RIGCAL_CLOCK_FREE = 1,  /* estimated */
    RIGCAL_CLOCK_ALONE = 2, /* held, because no placement of its views has a neighbour in
                               time */
    RIGCAL_CLOCK_STILL = 3  /* held, because the target hardly moves in its views */
};

struct rigcal_clock_calls; /* the library's own */

/* The motion of a target near one of its placements. At the time x after the placement its
 * motion (w, dt) is x (c[0] + (x - t[0]) (c[1] + (x - t[1]) (...))). t: the times of the
 * placement's neighbours, counted from it. */
enum rigcal_motion_limits { RIGCAL_MOTION_MOST = 4 };
typedef struct rigcal_motion {
    int32_t n; /* number of neighbours in time that the curve passes through; 0: the motion
                  is unknown */
    rigcal_real t[RIGCAL_MOTION_MOST], c[RIGCAL_MOTION_MOST][6];
} rigcal_motion;

/* What the library remembers from one view to the next. Do not read or write it. */
typedef struct rigcal_clock_memory {
    int32_t pass;      /* of the adjustment */
    int32_t is_moved;  /* 1: some view was taken at another instant than its placement */
    int32_t placement; /* the placement whose motion this is; -1: none */
    rigcal_motion motion;
    rigcal_real step[6], moved; /* to the nearest placement; against its noise */
    rigcal_real views, late;    /* of the placement: its views, and the sum of `after` */
    rigcal_real velocity[6];    /* of the view placed last */
    rigcal_real after, since;   /* its time after the placement; its stamp after `middle` */
    rigcal_real middle, ratio2; /* (noise of a pixel / noise of a stamp)^2 */
} rigcal_clock_memory;

/* Count times from about the start of the recording, in seconds or in any other unit. In
 * float, seconds are exact to 1 ms up to 8000 s. What camera c stamps with t happens at
 * the time t + offsets[c] + drifts[c] (t - middle). The middle is half way between the
 * first and the last of `times`. */
typedef struct rigcal_rig_clocks {
    const struct rigcal_clock_calls *calls; /* rigcal_clocks_defaults sets it */
    const rigcal_real *times; /* n_placements: the stamp of each placement. Stamps rise from
                                 one to the next; NaN: not known */
    const rigcal_real *view_times; /* n_views, or NULL: the stamp of each view; NaN: the
                                      stamp is that of its placement */
    rigcal_real *instants; /* n_placements, written: the time for which rig_from_placements
                             is valid, the mean time of the placement's views by the clocks.
                              Above 1e30 (float 1e9): not known */
    rigcal_real *offsets;  /* n_cameras. In: where to start. Out: how late each camera is */
    rigcal_real *drifts;   /* n_cameras, or NULL: all are 0 */
    const uint8_t *held;   /* n_cameras, or NULL: none. Not 0: that clock is right as it is.
                              In a group without such a clock, the clock of the first camera
                              with views is held */
    int32_t *states;       /* n_cameras, written: RIGCAL_CLOCK_ */
    int32_t free_offsets, free_drifts; /* 1: estimate them; 0: as they are handed in */
    int32_t neighbours;     /* how many neighbours of a placement give its motion: 1 .. 4 */
    rigcal_real frame;      /* time from one frame to the next. 0: it is found in `times`
                               and written, as the median of the steps below 0.35 */
    rigcal_real sigma_time; /* noise of the stamp of each view; 0: none. It needs the noise
                               of a pixel, from rig->sigma_px or view_poses */
    rigcal_clock_memory memory; /* the library's own */
} rigcal_rig_clocks;

/* Sets `calls`, sets `neighbours` to 4, and sets all else to 0. OK, ERR_NULL. */
RIGCAL_API rigcal_status rigcal_clocks_defaults(rigcal_rig_clocks *clocks);

/* Reals of rig->work that a rig with clocks needs in addition to RIGCAL_RIG_WORK or
 * RIGCAL_JUDGE_WORK. As a function: rigcal_clocks_work. */
#define RIGCAL_CLOCKS_WORK(n_free, n_cameras) \
    (12 * (size_t)(n_free) * (size_t)(n_cameras) + \
     (size_t)(n_cameras) * (2 * (size_t)(n_cameras) + 23))
RIGCAL_API size_t rigcal_clocks_work(size_t n_free, size_t n_cameras);

/* Standard deviations of offsets, and of drifts (NULL: not wanted), n_cameras each, for
 * noise of sigma_px. A value that is not free has 0. OK, ERR_NULL (also: the rig has no
 * clocks), ERR_NOT_FINITE, ERR_RANGE, ERR_STATE (not adjusted). O(n_cameras) */
RIGCAL_API rigcal_status rigcal_clocks_sigma(rigcal_real offsets[], rigcal_real drifts[],
                                             const rigcal_rig *rig, rigcal_real sigma_px);

/* frames[n_cameras]: the offsets in frames, rounded. If one of them is not 0, views of the
 * same instant carry different placement numbers. Then give each view of camera c the
 * placement that is frames[c] later, and adjust again. OK, ERR_NULL, ERR_NOT_FINITE,
 * ERR_RANGE (frame is not above 0). */
RIGCAL_API rigcal_status rigcal_clocks_frames(int32_t frames[],
                                              const rigcal_rig_clocks *clocks,
                                              size_t n_cameras);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_CLOCKS_H */
