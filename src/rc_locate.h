/* rc_locate.h - a point from the views that are used, with its covariance, view by view
 * (POINT in EQUATIONS.md). */
#ifndef RC_LOCATE_H
#define RC_LOCATE_H

#include "rc_sight.h"

rc_sighted *rc_sights_of(const rigcal_point_solver *p);

/* The number of the k-th view that is used. */
size_t rc_sight_number(const rigcal_point_solver *p, size_t k);

/* Sine squared of the angle between two rays, either way. */
rigcal_real rc_sight_aside(const rc_sighted *a, const rc_sighted *b);

/* The widest such angle of the views that are used [radian]. */
rigcal_real rc_locate_parallax(const rigcal_point_solver *p);

/* From the first n_used of the views' order. Then view after view: RUNNING; OK, and
 * BUDGET_SPENT, p->X, p->sums, p->chi2 and the views' e, A, B, G are there; ERR_NO_RAY,
 * ERR_PARALLEL, ERR_BEHIND, ERR_DEGENERATE. */
void rc_locate_begin(rigcal_point_solver *p, size_t n_used);
rigcal_status rc_locate_step(rigcal_point_solver *p);

#endif /* RC_LOCATE_H */
