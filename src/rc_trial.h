/* rc_trial.h - finds, after an alarm, which body moved and where it is now (M15 of MONITOR
 * in EQUATIONS.md). Each body has a trial, which assumes that it alone moved: it may have
 * made the largest move thought possible, all others are where the filter has them. Only
 * the trials take the rows that come. The sum of the logs of the rows' likelihoods measures
 * how well a trial explains them. */
#ifndef RC_TRIAL_H
#define RC_TRIAL_H

#include "rc_alarm.h"
#include "rc_filter.h"

/* ---- constants ----------------------------------------------------------- */

/* part of a distance: the shift that goes with a turn of one radian. The distance is the
 * mean one between cameras, or that of a target from the frame. */
#define RC_LEVER RC(0.1)

/* ---- trials -------------------------------------------------------------- */

/* Numbers of a trial: the move (w, ds), the factors of its covariance, and the sum of logs.
 * They lie in the memory that the alarm lends. */
enum { RC_TRIAL_MOVE = 0, RC_TRIAL_UD = 6, RC_TRIAL_LOG = 27, RC_TRIAL_SIZE = 28 };

/* The variance of a body's shift if it makes the largest move: q_t of a camera. For a
 * target its distance from the frame, times RC_LEVER and the turn, adds to it. */
rigcal_real rc_trial_shift(const rc_filter *f, size_t body, rigcal_real q_rad,
                           rigcal_real q_t);

/* Begins a trial for each body, in memory of the alarm. Its sum of logs begins with the
 * body's share of the evidence, which came from other rows. */
void rc_trial_begin(const rc_filter *f, const rc_alarm *alarm, rigcal_real bodies[],
                    rigcal_real move_rad, rigcal_real move_t);

/* Hands what was seen to the trials of its two bodies. Returns whether its rows are more
 * likely wrong than right in the filter, where no body moved. */
int rc_trial_take(const rc_filter *f, rigcal_real bodies[], const rc_seen *seen,
                  rigcal_real wrong);

/* The probability that this body moved, if one of them did. */
rigcal_real rc_trial_share(const rc_filter *f, const rigcal_real bodies[], size_t body);

/* The pose that a body has in its trial, and its covariance. */
void rc_trial_result(rigcal_transform *pose, rigcal_real Sigma[36], const rc_filter *f,
                     const rigcal_real bodies[], size_t body);

/* Subtracts the largest sum of logs from all, so that none grows until rounding matters. */
void rc_trial_settle(const rc_filter *f, rigcal_real bodies[]);

#endif /* RC_TRIAL_H */
