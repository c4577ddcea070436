/* rc_trial.h - after an alarm, which body was it, and where is it now (M15 of MONITOR in
 * EQUATIONS.md). Each body has a trial: it is open to the largest move thought possible,
 * all others are where the filter has them, and it alone takes the rows that come. The sum
 * of the logs of their likelihoods tells how well it explains them. */
#ifndef RC_TRIAL_H
#define RC_TRIAL_H

#include "rc_alarm.h"
#include "rc_filter.h"

/* Numbers of a trial: the move (w, dt), the factors of its covariance, and the sum of logs.
 * They take the place of the windows that the alarm lends. */
enum { RC_TRIAL_MOVE = 0, RC_TRIAL_UD = 6, RC_TRIAL_LOG = 27, RC_TRIAL_SIZE = 28 };

/* One for each body, in memory of the alarm's. They begin with the body's part of the
 * evidence, which other rows gave. */
void rc_trial_begin(const rc_filter *f, const rc_alarm *alarm, rigcal_real bodies[],
                    rigcal_real move_rad, rigcal_real move_t);

/* What was seen goes to all trials. Returns whether its rows are more likely wrong than
 * right by each of them. */
int rc_trial_take(const rc_filter *f, rigcal_real bodies[], const rc_seen *seen,
                  rigcal_real wrong);

/* The probability that it was this body, if it was one of them. */
rigcal_real rc_trial_share(const rc_filter *f, const rigcal_real bodies[], size_t body);

/* Where its trial has a body, and the covariance of that. */
void rc_trial_result(rigcal_transform *pose, rigcal_real Sigma[36], const rc_filter *f,
                     const rigcal_real bodies[], size_t body);

/* The largest sum of logs is 0 again, so that none outgrows its rounding. */
void rc_trial_settle(const rc_filter *f, rigcal_real bodies[]);

#endif /* RC_TRIAL_H */
