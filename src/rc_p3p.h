/* rc_p3p.h - all poses from three points (EQUATIONS.md D). */
#ifndef RC_P3P_H
#define RC_P3P_H

#include "rc_transform.h"

enum { RC_P3P_MAX = 4 };

/* Finds the poses at which the points x, counted from any origin, lie in front along the
 * unit rays. There are 0 to RC_P3P_MAX of them, in no order; no more is written. If noise
 * has made a pair of nearly equal poses complex, their real part counts too: it is a start
 * for least squares, not a solution. Returns 0 if points are on a line, rays coincide or
 * nothing fits. The error is rounding times the condition of the pose, which is bad if two
 * poses are about to merge. Mean 3800 instructions (gcc 12 -O2, x86-64, double). */
int rc_p3p(rigcal_transform cam_from_points[RC_P3P_MAX], const rigcal_real x[3][3],
           const rigcal_real ray[3][3]);

/* The same one by one, with little stack, for the points in P->work.x. `begin` returns 0 if
 * there is no pose to ask for. Else each `next` gives a pose, until one returns 0. */
int rc_p3p_begin(rigcal_p3p *P, const rigcal_real ray[3][3]);
int rc_p3p_next(rigcal_transform *cam_from_points, rigcal_p3p *P,
                const rigcal_real ray[3][3]);

#endif /* RC_P3P_H */
