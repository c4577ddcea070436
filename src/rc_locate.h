/* rc_locate.h - finds a point from the views that are used, with its covariance. It takes
 * one view a step (POINT in EQUATIONS.md). */
#ifndef RC_LOCATE_H
#define RC_LOCATE_H

#include "rc_sight.h"

rc_sighted *rc_sights_of(const rigcal_point_solver *p);

/* The number, among all views, of the k-th view that is used. */
size_t rc_sight_number(const rigcal_point_solver *p, size_t k);

/* Squared sine of the angle between two rays. Rays of opposite directions have the angle
 * 0. */
rigcal_real rc_sight_aside(const rc_sighted *a, const rc_sighted *b);

/* The widest such angle between the views that are used [radian]. */
rigcal_real rc_locate_parallax(const rigcal_point_solver *p);

/* Begins a point from the first n_used views of the order. Each step takes one view and
 * returns RUNNING until the end. Then it returns OK or BUDGET_SPENT, and p->X, p->sums,
 * p->chi2 and e, A, B, G of the views are written. Or it returns ERR_NO_RAY, ERR_PARALLEL,
 * ERR_BEHIND or ERR_DEGENERATE. */
void rc_locate_begin(rigcal_point_solver *p, size_t n_used);
rigcal_status rc_locate_step(rigcal_point_solver *p);

#endif /* RC_LOCATE_H */
