/* rc_triangulate.h - what points from rays have in common; see rigcal_measure.h. */
#ifndef RC_TRIANGULATE_H
#define RC_TRIANGULATE_H

#include "rc_levenberg.h"
#include "rc_points.h"

/* ---- constants ----------------------------------------------------------- */

/* sine squared of the angle between two rays: the least parallax, 0.1 degree. A bearing
 * error e moves the point by range * e / sin(angle) in depth, there over 500 times as far
 * as sideways. */
#define RC_PARALLAX_MIN RC(3.05e-6)

/* evaluations: of a triangulation, usually 2 or 3. The worst case that the manuals
 * state. */
enum { RC_TRIANGULATION_EVALS = 50 };

/* ---- what is shared ------------------------------------------------------- */

/* L L^T = H, damped. 0: not positive definite to rounding. */
int rc_point_factor(rigcal_real L[6], const rigcal_real H[6], rigcal_real damping);

/* x <- (L L^T)^-1 x */
void rc_point_solve(rigcal_real x[3], const rigcal_real L[6]);

#endif /* RC_TRIANGULATE_H */
