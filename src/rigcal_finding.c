#include "rc_finding.h"
#include "rc_logs.h"

/* ---- constants ----------------------------------------------------------- */

/* 1: the views disagree if noise alone gives such an F with a smaller chance than this. */
#define DISAGREES RC(0.001)

/* 1: a fault is named if the chance to find any fault where there is none is smaller than
 * this. */
#define FOUND RC(0.01)

/* 1: faults whose criteria differ by less fit alike: their odds are within exp(9.2 / 2) =
 * 100. */
#define ALIKE_MOST RC(9.2)

/* part of F - 1: a fault must explain at least this much to be the reason, if F stays
 * significant. */
#define EXPLAINS_LEAST RC(0.5)

/* part of the sum: the most that a gain may take. More would give the logarithm of 0. */
#define GAIN_MOST (1 - RC_EPS)

/* part of the disagreement: if more of it lies along the motion, single time stamps are
 * wrong. */
#define ALONG_MOST RC(0.3)

/* 1: least correlation of neighbouring residuals that is a pattern. */
#define PATTERN_LEAST RC(0.1)

/* standard deviations: a pattern must also exceed this many. */
#define PATTERN_DEVIATIONS RC(4)

/* 1: half of a view's six pose parameters. Fitting them lowers the variance of the products
 * of neighbours by the square of their expected sum, over this. */
#define POSE_PARTS RC(3)

rigcal_real rc_F_of(const rc_common *c, rigcal_real gain, rigcal_real own_gain,
                    rigcal_real k)
{
    const rigcal_real own = c->own - own_gain;
    const rigcal_real between = rc_max(1, c->freedom_between - k);
    return (own > 0) ? ((c->sum - gain) - own) / between / (own / c->freedom_within) : 0;
}

int rc_F_disagrees(const rc_common *c, rigcal_real F, rigcal_real k)
{
    return rc_f_tail(F, rc_max(1, c->freedom_between - k), c->freedom_within) <= DISAGREES;
}

/* Clears a fault whose numbers overflow: the views do not show it. */
static void keep_if_finite(rigcal_fault *fault)
{
    const rigcal_real others[6] = {fault->gain,    fault->p,    fault->bic,
                                   fault->F_after, fault->turn, fault->shift};
    if (rc_all_finite(others, 6) && rc_all_finite(fault->value, RIGCAL_FAULT_VALUES) &&
        rc_all_finite(fault->sigma, RIGCAL_FAULT_VALUES)) {
        return;
    }
    const rigcal_fault unseen = {.kind = fault->kind,
                                 .camera = fault->camera,
                                 .placement = fault->placement,
                                 .n = fault->n};
    *fault = unseen;
}

/* n log(1 - gain / sum); 0 if the pixels are exact. */
static rigcal_real log_of_rest(const rc_common *c, rigcal_real gain)
{
    return (c->sum > 0) ? c->n_measured * rc_log1p(-rc_min(gain / c->sum, GAIN_MOST)) : 0;
}

void rc_finding_of(rigcal_fault *fault, const rc_common *c, const rc_one_step *step)
{
    const rigcal_real k = (rigcal_real)(int32_t)step->k, freedom = c->freedom - k;
    const rigcal_real gain = rc_min(step->gain, GAIN_MOST * c->sum);
    const rigcal_real variance = (c->sum - gain) / freedom;
    const rigcal_real F = rc_F_of(c, 0, 0, 0);
    fault->is_seen = 1;
    fault->n = (int32_t)step->k;
    fault->gain = gain;
    fault->p = rc_f_tail(gain / k / variance, k, freedom);
    fault->p = rc_min(1, fault->p * (rigcal_real)(int32_t)step->tries);
    fault->bic = log_of_rest(c, gain) + k * rc_log1p(c->n_measured - 1);
    fault->F_after = rc_max(0, rc_F_of(c, gain, step->own_gain, k));
    fault->explains = !rc_F_disagrees(c, fault->F_after, k) ||
                      fault->F_after - 1 <= (1 - EXPLAINS_LEAST) * (F - 1);
    for (size_t i = 0; i < step->k; i++) {
        const rigcal_real sigma = RC_SQRT(step->variance[i] * variance);
        const rigcal_real large = RIGCAL_FAULT_DEVIATIONS * sigma;
        fault->turn = rc_max(fault->turn, large * step->turn[i]);
        fault->shift = rc_max(fault->shift, large * step->shift[i]);
        if (i < RIGCAL_FAULT_VALUES) {
            fault->value[i] = step->theta[i];
            fault->sigma[i] = sigma;
        }
    }
    keep_if_finite(fault);
}

/* Whether a comes before b. Those that are not seen are in the order of their kinds,
 * however many passes there are. */
static int is_before(const rigcal_fault *a, const rigcal_fault *b)
{
    if (a->is_seen != b->is_seen) {
        return a->is_seen;
    }
    return a->is_seen ? a->bic < b->bic : a->kind < b->kind;
}

void rc_finding_rank(rigcal_fault faults[], int32_t *n, size_t capacity,
                     const rigcal_fault *fault)
{
    size_t at = (size_t)*n;
    if (at < capacity) {
        *n += 1;
    } else if (is_before(fault, &faults[capacity - 1])) {
        at = capacity - 1;
    } else {
        return;
    }
    for (; at > 0 && is_before(fault, &faults[at - 1]); at--) {
        faults[at] = faults[at - 1];
    }
    faults[at] = *fault;
}

void rc_finding_judge(rigcal_faults *found, const rigcal_fault faults[], const rc_common *c)
{
    const rigcal_real seen = (rigcal_real)found->n_seen;
    const int disagrees = rc_F_disagrees(c, found->F, 0);
    const int is_named = seen > 0 && faults[0].p * seen < FOUND;
    found->verdict = !disagrees           ? RIGCAL_RIG_AGREES
                     : !is_named          ? RIGCAL_RIG_UNEXPLAINED
                     : faults[0].explains ? RIGCAL_RIG_EXPLAINED
                                          : RIGCAL_RIG_FOUND;
    if (!is_named) {
        return;
    }
    found->bits |= RIGCAL_FAULTS_NAMED;
    found->explained = (found->F > 1) ? (found->F - faults[0].F_after) / (found->F - 1) : 0;
    for (int32_t i = 1;
         i < found->n && faults[i].is_seen && faults[i].bic < faults[0].bic + ALIKE_MOST;
         i++) {
        found->n_alike = i;
        found->bits |= RIGCAL_FAULTS_ALIKE;
    }
}

void rc_finding_residues(rigcal_faults *found, const rc_residues *r, const rc_common *c)
{
    const rigcal_real variance = c->own / c->freedom_within, n = 2 * r->n;
    if (n > 0 && variance > 0) {
        const rigcal_real pattern = (r->product / variance - r->expected) / n;
        found->pattern = rc_max(-1, rc_min(pattern, 1));
        found->pattern_sigma = RC_SQRT(rc_max(n - r->expected2 / POSE_PARTS, 1)) / n;
        if (found->pattern > PATTERN_LEAST &&
            found->pattern > PATTERN_DEVIATIONS * found->pattern_sigma) {
            found->bits |= RIGCAL_FAULTS_PATTERN;
        }
    }
    if (r->disagreement > 0 && r->speed2 > 0) {
        found->along = rc_min(r->along / r->disagreement, 1);
        found->along_time = RC_SQRT(r->along / r->speed2);
        if (found->along > ALONG_MOST && (found->bits & RIGCAL_FAULTS_PATTERN) == 0) {
            found->bits |= RIGCAL_FAULTS_ALONG_MOTION;
        }
    }
}
