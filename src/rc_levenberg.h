/* rc_levenberg.h - the damping of Levenberg-Marquardt, and when to stop.
 *
 * It knows no equations and no dimension. Its owner evaluates and solves; it says what to
 * do next. So there is no callback, and a search may pause at any evaluation.
 *
 *     rc_levenberg_begin(&lm, 0);
 *     while (lm.status == RIGCAL_RUNNING) {
 *         if (lm.want == RC_WANT_EQUATIONS) {
 *             evaluate the sum of squares, J^T e = g and H at the current place
 *             rc_levenberg_evaluated(&lm, status, sum);
 *         } else if ((H + lambda D) d = g cannot be solved: not positive definite) {
 *             rc_levenberg_not_definite(&lm);
 *         } else {
 *             switch (rc_levenberg_promised(&lm, d.g, negligible)) {
 *             case RC_STEP_TRY:
 *                 move by d; evaluate there
 *                 if (!rc_levenberg_tried(&lm, status, sum, d.g, negligible))
 *                     move back
 *                 break;
 *             case RC_STEP_LAST: move by d, without an evaluation; break;
 *             case RC_STEP_NONE: break;
 *             }
 *         }
 *     } */
#ifndef RC_LEVENBERG_H
#define RC_LEVENBERG_H

#include "rc_real.h"

enum { RC_WANT_EQUATIONS, RC_WANT_STEP };

/* Which H is wanted: J^T J; Newton's, with the curvature of the residuals; Newton's, after
 * it was not positive definite. */
enum { RC_GAUSS_NEWTON, RC_NEWTON, RC_NEWTON_INDEFINITE };

enum { RC_STEP_TRY, RC_STEP_LAST, RC_STEP_NONE };

/* Begins a search. If is_near, the first step is not damped. */
void rc_levenberg_begin(rigcal_levenberg *lm, int is_near);

/* Takes the sum at the current place, or the status of an evaluation that failed. A failure
 * ends the search. */
void rc_levenberg_evaluated(rigcal_levenberg *lm, rigcal_status status, rigcal_real sum);

/* H + lambda D is not positive definite. If H is J^T J the search ends with ERR_DEGENERATE.
 * Newton's H is damped more at each call, and in the end replaced by J^T J. */
void rc_levenberg_not_definite(rigcal_levenberg *lm);

/* `gain` is the decrease of the sum that the step promises without damping. A change of the
 * sum up to `negligible` means nothing. Returns RC_STEP_. */
int rc_levenberg_promised(rigcal_levenberg *lm, rigcal_real gain, rigcal_real negligible);

/* Takes the outcome of a step that was tried. Returns 1 if the step stays. Returns 0 if it
 * did harm and must be taken back; the equations then belong to another place. */
int rc_levenberg_tried(rigcal_levenberg *lm, rigcal_status status, rigcal_real sum,
                       rigcal_real gain, rigcal_real negligible);

#endif /* RC_LEVENBERG_H */
