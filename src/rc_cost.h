/* rc_cost.h - what a view of an adjusted rig costs (JUDGE in EQUATIONS.md). */
#ifndef RC_COST_H
#define RC_COST_H

#include "rc_choose.h"

/* ---- constants ----------------------------------------------------------- */

/* sigma^2: what a view may cost at most where noise is all. Its excess is chi square of 6,
 * which passes this once in two million right views. */
#define RC_COST_LIMIT RC(40)

enum {
    RC_JUDGE_DONE = 1,
    RC_JUDGE_CHECKING,   /* the poses of a view by itself */
    RC_JUDGE_ADJUSTING,  /* the rig */
    RC_JUDGE_EVALUATING, /* a view of a placement, where the rig is */
    RC_JUDGE_COSTING,    /* what such a view costs */
    RC_JUDGE_SCALING,    /* the limit, by the middle cost */
    RC_JUDGE_PLACING,    /* a placement, by its views' own poses */
    RC_JUDGE_NAMING,
    RC_JUDGE_CONCLUDING
};

/* ---- functions ----------------------------------------------------------- */

void rc_judge_end(rigcal_judge_solver *s, rigcal_status status, int32_t at_fault);

/* The placement under way as a pose of view v by itself has it; view is -1 where there is
 * no such pose. */
rigcal_status rc_judge_claim(rc_claim *claim, const rigcal_judge_solver *s, size_t v,
                             int candidate, int with_camera);

/* Begins a pass over the placements: RC_JUDGE_EVALUATING or _PLACING. */
void rc_judge_begin_pass(rigcal_judge_solver *s, int32_t phase);

/* From s->placement on the first one that was seen. */
void rc_judge_next_placement(rigcal_judge_solver *s, const rc_rig_parts *parts);

/* One view of a pass: where the rig is; then, those of its placement being done, what it
 * costs. After the last the phase is RC_JUDGE_SCALING. */
void rc_judge_evaluate(rigcal_judge_solver *s, const rc_rig_parts *parts);
void rc_judge_cost(rigcal_judge_solver *s, const rc_rig_parts *parts);

/* Sets the scale: by how much the views differ more than noise explains, from the median
 * cost. */
void rc_judge_set_scale(rigcal_judge_solver *s, const rc_rig_parts *parts);

#endif /* RC_COST_H */
