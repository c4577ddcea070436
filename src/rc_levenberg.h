/* rc_levenberg.h - Levenberg-Marquardt's damping, and when to stop.
 *
 * It knows no equations and no dimension: its owner evaluates and solves, and is told what
 * to do next. So there is no callback, and a search may pause at any evaluation.
 *
 *     rc_levenberg_begin(&lm, 0);
 *     while (lm.status == RIGCAL_RUNNING) {
 *         if (lm.want == RC_WANT_EQUATIONS) {
 *             evaluate the sum of squares, J^T e = g and H where the search is
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
 *     }
 */
#ifndef RC_LEVENBERG_H
#define RC_LEVENBERG_H

#include "rc_real.h"

enum { RC_WANT_EQUATIONS, RC_WANT_STEP };

/* What H is to be: J^T J; Newton's, with the curvature of the residuals; the same after it
 * was seen not to be positive definite. */
enum { RC_GAUSS_NEWTON, RC_NEWTON, RC_NEWTON_INDEFINITE };

enum { RC_STEP_TRY, RC_STEP_LAST, RC_STEP_NONE };

/* is_near: the first step is not damped. */
void rc_levenberg_begin(rigcal_levenberg *lm, int is_near);

/* The sum where the search is, or the status of an evaluation that failed, which ends
 * it. */
void rc_levenberg_evaluated(rigcal_levenberg *lm, rigcal_status status, rigcal_real sum);

/* H + lambda D is not positive definite. J^T J: the search ends, ERR_DEGENERATE. Newton's:
 * it is damped more, call by call, or given up for J^T J. */
void rc_levenberg_not_definite(rigcal_levenberg *lm);

/* `gain`: by how much the step is to lower the sum, were there no damping. `negligible`: a
 * change of the sum that means nothing. Returns RC_STEP_. */
int rc_levenberg_promised(rigcal_levenberg *lm, rigcal_real gain, rigcal_real negligible);

/* The outcome of a step that was tried. 1: it stays. 0: it did harm and is to be taken
 * back; the equations are those of another place then. */
int rc_levenberg_tried(rigcal_levenberg *lm, rigcal_status status, rigcal_real sum,
                       rigcal_real gain, rigcal_real negligible);

#endif /* RC_LEVENBERG_H */
