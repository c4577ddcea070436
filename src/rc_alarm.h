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
 * Between an alarm and its answer, others may use the first RC_ALARM_WINDOW numbers of each
 * body: rc_alarm_lent says where they are. */
#ifndef RC_ALARM_H
#define RC_ALARM_H

#include "rc_linalg.h"

/* ---- constants ----------------------------------------------------------- */

/* frames: length of the longest window. If a move takes longer to be seen, the filter
 * follows it instead. */
#define RC_ALARM_LONGEST 256

enum {
    RC_ALARM_WINDOWS = 5,
    RC_ALARM_WINDOW = 28, /* numbers of a window: G, H, |W|^(1/2) */
    RC_ALARM_BODY = RC_ALARM_WINDOWS * RC_ALARM_WINDOW + 21 + 6
};

/* ---- state --------------------------------------------------------------- */

typedef struct {
    int32_t n_bodies;
    rigcal_real common;        /* 0 .. 1: share by which the rows of a frame err together */
    rigcal_real log_limit;     /* log(A K B): bound, windows, bodies */
    rigcal_real move_rad;      /* the largest turn thought possible [rad] */
    rigcal_real move_t;        /* the largest shift thought possible [length] */
    rigcal_real rows, squares; /* of recent rows: number, sum of psi^2 */
} rc_alarm;

/* ---- functions ----------------------------------------------------------- */

/* Begins. bodies has RC_ALARM_BODY numbers for each of n_bodies >= 2 bodies. arl0_frames is
 * the mean number of frames between false alarms, 100 or more. */
void rc_alarm_begin(rc_alarm *alarm, rigcal_real bodies[], size_t n_bodies,
                    rigcal_real arl0_frames, rigcal_real common, rigcal_real move_rad,
                    rigcal_real move_t);

/* Takes one row: its innovation z [standard deviations], the standard deviation sd =
 * sqrt(S), and its derivatives by the errors of its two bodies a and b. */
void rc_alarm_row(rc_alarm *alarm, rigcal_real bodies[], rigcal_real z, rigcal_real sd,
                  size_t a, const rigcal_real h_a[6], size_t b, const rigcal_real h_b[6]);

/* Ends a frame. Returns the evidence, log(sum / A). 0 or more is the alarm. */
rigcal_real rc_alarm_frame(rc_alarm *alarm, rigcal_real bodies[]);

/* After the alarm was answered: starts all windows anew. What was measured of the rows
 * stays. */
void rc_alarm_again(rc_alarm *alarm, rigcal_real bodies[]);

/* Another body takes the place of this one: starts its windows and clears what was
 * measured. */
void rc_alarm_forget(rc_alarm *alarm, rigcal_real bodies[], size_t body);

/* RC_ALARM_WINDOW numbers of a body, which the trials use between the alarm and its
 * answer. */
rigcal_real *rc_alarm_lent(rigcal_real bodies[], size_t body);

/* ---- after rc_alarm_frame -------------------------------------------------- */

/* log of the sum over all bodies. Takes one exp for each body */
rigcal_real rc_alarm_log_sum(const rc_alarm *alarm, const rigcal_real bodies[]);

/* The share of a body in that sum, 0 .. 1. All shares add up to 1. */
rigcal_real rc_alarm_share(const rigcal_real bodies[], size_t body, rigcal_real log_sum);

/* 1: the body is blind. It had fewer than 6 rows in the longest window. */
int rc_alarm_is_blind(const rigcal_real bodies[], size_t body);

/* The smallest turn of a body that the longest window would have noticed, about the axis
 * for which it sees least [rad]. 0: it would notice none, because the body is blind or
 * turns about one axis are not seen. */
rigcal_real rc_alarm_smallest(const rc_alarm *alarm, const rigcal_real bodies[],
                              size_t body);

/* The rms of the clipped innovations, relative to that of normal noise as stated. 1: the
 * noise is as stated; at most 1.6. 0: there was no row. */
rigcal_real rc_alarm_noise(const rc_alarm *alarm);

#endif /* RC_ALARM_H */
