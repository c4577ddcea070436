#include "rc_levenberg.h"

/* ---- constants ----------------------------------------------------------- */

/* part of D: damping of the first step. It is small, so it does not slow a good start. */
#define DAMPING_FIRST RC(1e-5)

/* part of D: a step with at most this damping counts as undamped, and may be the last. */
#define DAMPING_NEAR RC(1e-2)

/* part of D: the search ends if this much damping does not help. */
#define DAMPING_LAST RC(1e8)

/* part of D: first damping of a Newton's H that is not positive definite. */
#define DAMPING_INDEFINITE RC(1e-4)

/* part of D: if Newton's H needs more damping, J^T J takes its place. */
#define DAMPING_NEWTON RC(10)

/* factor: multiplies the damping after a step that did harm. */
#define DAMPING_MORE RC(10)

/* factor: multiplies the damping after a step that helped. */
#define DAMPING_LESS RC(0.1)

/* part of the sum: a rise up to this may be rounding. */
#define SUM_ROUNDING (16 * RC_EPS)

/* part of the sum: the search ends when the expected further gain is less, as judged by how
 * fast the gains fall. */
#define LEFT_LEAST RC_TOL(1e-12, 1e-6)

/* part of the sum: the search ends with a step that gains less. */
#define GAIN_LEAST RC_TOL(1e-13, 1e-6)

/* part of the sum: if a step that promised less makes the sum rise, the rise is
 * rounding. */
#define GAIN_ROUNDING RC_TOL(1e-7, 1e-4)

/* ratio of gains: if a gain is more than this part of the one before, the search is in a
 * valley, where Newton's H helps. */
#define SLOW RC(0.1)

void rc_levenberg_begin(rigcal_levenberg *lm, int is_near)
{
    lm->want = RC_WANT_EQUATIONS;
    lm->equations = RC_GAUSS_NEWTON;
    lm->status = RIGCAL_RUNNING;
    lm->sum = RC_MAX;
    lm->last_gain = 0;
    lm->lambda = is_near ? 0 : DAMPING_FIRST;
}

void rc_levenberg_evaluated(rigcal_levenberg *lm, rigcal_status status, rigcal_real sum)
{
    RIGCAL_ASSERT(lm->status == RIGCAL_RUNNING && lm->want == RC_WANT_EQUATIONS);
    if (status != RIGCAL_OK) {
        lm->status = status;
    } else {
        lm->sum = sum;
        lm->want = RC_WANT_STEP;
    }
}

void rc_levenberg_not_definite(rigcal_levenberg *lm)
{
    RIGCAL_ASSERT(lm->status == RIGCAL_RUNNING && lm->want == RC_WANT_STEP);
    if (lm->equations == RC_GAUSS_NEWTON) {
        lm->status = RIGCAL_ERR_DEGENERATE;
    } else if (lm->lambda > DAMPING_NEWTON) {
        lm->equations = RC_GAUSS_NEWTON;
        lm->want = RC_WANT_EQUATIONS;
    } else {
        lm->equations = RC_NEWTON_INDEFINITE;
        lm->lambda = rc_max(DAMPING_MORE * lm->lambda, DAMPING_INDEFINITE);
    }
}

/* A nearly undamped step is the last if almost nothing is left to gain after it. If each
 * gain is r = gain / last_gain of the one before, gain r / (1 - r) is left. Near an optimum
 * the gains fall ever faster. In a valley r is near 1, and a small gain alone says
 * nothing. The square of a gain may overflow. */
static int is_last(const rigcal_levenberg *lm, rigcal_real gain, rigcal_real negligible)
{
    return lm->lambda <= DAMPING_NEAR &&
           (gain <= negligible || gain <= GAIN_LEAST * lm->sum ||
            gain / lm->sum * gain <= (lm->last_gain - gain) * LEFT_LEAST);
}

int rc_levenberg_promised(rigcal_levenberg *lm, rigcal_real gain, rigcal_real negligible)
{
    RIGCAL_ASSERT(lm->status == RIGCAL_RUNNING && lm->want == RC_WANT_STEP);
    RIGCAL_ASSERT(negligible >= 0);
    const int is_indefinite = lm->equations == RC_NEWTON_INDEFINITE;
    if (is_last(lm, gain, negligible)) {
        if (is_indefinite) { /* a saddle: no optimum, and no step leads down */
            lm->status = RIGCAL_BUDGET_SPENT;
            return RC_STEP_NONE;
        }
        lm->sum = rc_max(0, lm->sum - gain); /* by the quadratic model, not evaluated */
        lm->status = RIGCAL_OK;
        return RC_STEP_LAST;
    }
    if (is_indefinite || (lm->last_gain > 0 && gain > SLOW * lm->last_gain)) {
        lm->equations = RC_NEWTON;
    }
    return RC_STEP_TRY;
}

int rc_levenberg_tried(rigcal_levenberg *lm, rigcal_status status, rigcal_real sum,
                       rigcal_real gain, rigcal_real negligible)
{
    RIGCAL_ASSERT(lm->status == RIGCAL_RUNNING && lm->want == RC_WANT_STEP);
    if (status == RIGCAL_OK && sum <= lm->sum * (1 + SUM_ROUNDING) + negligible) {
        lm->sum = sum;
        lm->last_gain = gain;
        lm->lambda *= DAMPING_LESS;
        return 1;
    }
    lm->want = RC_WANT_EQUATIONS;
    lm->equations = RC_NEWTON;
    lm->last_gain = 0;
    lm->lambda = rc_max(DAMPING_MORE * lm->lambda, DAMPING_FIRST);
    if (gain <= GAIN_ROUNDING * lm->sum || lm->lambda > DAMPING_LAST) {
        lm->status = RIGCAL_OK; /* no step helps any more */
    }
    return 0;
}
