/* rc_neldermead.h - the search without argument checks; see rigcal_paper.h. */
#ifndef RC_NELDERMEAD_H
#define RC_NELDERMEAD_H

#include "rc_linalg.h"
#include "rigcal_paper.h"

void rc_neldermead_begin(rigcal_neldermead *nm, const rigcal_real x0[], int32_t k,
                         rigcal_real xtol, rigcal_real ftol, int32_t max_evals);

void rc_neldermead_begin_simplex(rigcal_neldermead *nm, const rigcal_real simplex[],
                                 int32_t k, rigcal_real xtol, rigcal_real ftol,
                                 int32_t max_evals);

/* The vertex of the least cost. */
const rigcal_vertex *rc_neldermead_best(const rigcal_neldermead *nm);

/* Takes the cost of nm->trial. Sets the next trial and nm->status. */
void rc_neldermead_tell(rigcal_neldermead *nm, rigcal_real cost);

#endif /* RC_NELDERMEAD_H */
