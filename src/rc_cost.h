/* rc_cost.h - the cost of a view of an adjusted rig (JUDGE in EQUATIONS.md). */
#ifndef RC_COST_H
#define RC_COST_H

#include "rc_choose.h"

/* ---- constants ----------------------------------------------------------- */

/* sigma^2: the most that a view may cost if noise is the only error. The cost is then chi
 * squared with 6 degrees of freedom, which exceeds 40 for one in two million right
 * views. */
#define RC_COST_LIMIT RC(40)

enum {
    RC_JUDGE_DONE = 1,
    RC_JUDGE_CHECKING,   /* checks the poses of a view by itself */
    RC_JUDGE_ADJUSTING,  /* adjusts the rig */
    RC_JUDGE_EVALUATING, /* evaluates a view of a placement, the rig as it is */
    RC_JUDGE_COSTING,    /* computes what such a view costs */
    RC_JUDGE_SCALING,    /* sets the limit from the median cost */
    RC_JUDGE_PLACING,    /* places a placement by the poses of its views */
    RC_JUDGE_NAMING,
    RC_JUDGE_CONCLUDING
};

/* ---- functions ----------------------------------------------------------- */

void rc_judge_end(rigcal_judge_solver *s, rigcal_status status, int32_t at_fault);

/* The claim about the current placement that pose `candidate` of view v makes. claim->view
 * is -1 if there is no such pose. */
rigcal_status rc_judge_claim(rc_claim *claim, const rigcal_judge_solver *s, size_t v,
                             int candidate, int with_camera);

/* Begins a pass over the placements: RC_JUDGE_EVALUATING or _PLACING. */
void rc_judge_begin_pass(rigcal_judge_solver *s, int32_t phase);

/* Goes to the first placement that was seen, from s->placement on. */
void rc_judge_next_placement(rigcal_judge_solver *s, const rc_rig_parts *parts);

/* One view of a pass. rc_judge_evaluate computes its equations where the rig is. After all
 * views of a placement rc_judge_cost computes what each costs. After the last the phase is
 * RC_JUDGE_SCALING. */
void rc_judge_evaluate(rigcal_judge_solver *s, const rc_rig_parts *parts);
void rc_judge_cost(rigcal_judge_solver *s, const rc_rig_parts *parts);

/* Sets the scale from the median cost. The scale says how much more the views differ than
 * noise explains. */
void rc_judge_set_scale(rigcal_judge_solver *s, const rc_rig_parts *parts);

#endif /* RC_COST_H */
