/* rc_alarm.h - evidence that a body of a rig has moved (ALARM in EQUATIONS.md).
 *
 * The state is a struct and RC_ALARM_BODY numbers of each body. It holds no pointer, so it
 * can be copied. The filter of the rig calls
 *
 *     rc_alarm_begin    once
 *     rc_alarm_row      for each row that the filter took
 *     rc_alarm_frame    at the end of a frame: the evidence; 0 or more is the alarm
 *     rc_alarm_again    when the alarm was answered
 *
 * Between an alarm and its answer the first RC_ALARM_WINDOW numbers of each body are not
 * used: rc_alarm_lent is where they are. */
#ifndef RC_ALARM_H
#define RC_ALARM_H

#include "rc_linalg.h"

/* ---- constants ----------------------------------------------------------- */

/* frames: of the longest window; a move that takes more to be seen is followed. */
#define RC_ALARM_LONGEST 256

enum {
    RC_ALARM_WINDOWS = 5,
    RC_ALARM_WINDOW = 28, /* numbers of a window: G, H, |W|^(1/2) */
    RC_ALARM_BODY = RC_ALARM_WINDOWS * RC_ALARM_WINDOW + 21 + 6
};

/* ---- state --------------------------------------------------------------- */

typedef struct {
    int32_t n_bodies;
    rigcal_real common;        /* 0 .. 1: how far the rows of a frame err together */
    rigcal_real log_limit;     /* log of A K B */
    rigcal_real move_rad;      /* the largest turn thought possible [rad] */
    rigcal_real move_t;        /* the largest shift thought possible [length] */
    rigcal_real rows, squares; /* of recent rows: their number, and the sum of psi^2 */
} rc_alarm;

/* ---- functions ----------------------------------------------------------- */

/* bodies: RC_ALARM_BODY numbers for each of n_bodies >= 1.
 * arl0_frames: mean number of frames between false alarms, 100 or more. */
void rc_alarm_begin(rc_alarm *alarm, rigcal_real bodies[], size_t n_bodies,
                    rigcal_real arl0_frames, rigcal_real common, rigcal_real move_rad,
                    rigcal_real move_t);

/* One row: its innovation z [standard deviations], that deviation sd = sqrt(S), and its
 * derivatives by the errors of the two bodies a and b that it is of. */
void rc_alarm_row(rc_alarm *alarm, rigcal_real bodies[], rigcal_real z, rigcal_real sd,
                  size_t a, const rigcal_real h_a[6], size_t b, const rigcal_real h_b[6]);

/* Ends a frame. Returns the evidence: log of the sum over A, 0 or more is the alarm. */
rigcal_real rc_alarm_frame(rc_alarm *alarm, rigcal_real bodies[]);

/* The alarm was answered: all windows start anew. What was measured of the rows stays. */
void rc_alarm_again(rc_alarm *alarm, rigcal_real bodies[]);

/* Another body takes the place of this one: its windows start, nothing is known of it. */
void rc_alarm_forget(rc_alarm *alarm, rigcal_real bodies[], size_t body);

/* RC_ALARM_WINDOW numbers of a body, for the trials between the alarm and its answer. */
rigcal_real *rc_alarm_lent(rigcal_real bodies[], size_t body);

/* ---- after rc_alarm_frame -------------------------------------------------- */

/* A body's part of the sum, 0 .. 1; all are 1 together. */
rigcal_real rc_alarm_share(const rc_alarm *alarm, const rigcal_real bodies[], size_t body);

/* 1: the body is blind: since the last longest window began it had fewer than 6 rows. */
int rc_alarm_is_blind(const rigcal_real bodies[], size_t body);

/* The smallest turn of a body, about the axis that is seen worst, that the longest window
 * would have noticed [rad]. 0: none would; the body is blind or turns about one axis are
 * not seen. */
rigcal_real rc_alarm_smallest(const rc_alarm *alarm, const rigcal_real bodies[],
                              size_t body);

/* rms of the clipped innovations over that of normal noise as stated: 1 is as stated, at
 * most 1.6. 0: there was no row. */
rigcal_real rc_alarm_noise(const rc_alarm *alarm);

#endif /* RC_ALARM_H */
