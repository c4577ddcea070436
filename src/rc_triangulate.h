/* rc_triangulate.h - what all layers share that find points from rays; see
 * rigcal_measure.h. */
#ifndef RC_TRIANGULATE_H
#define RC_TRIANGULATE_H

#include "rc_levenberg.h"
#include "rc_points.h"

/* ---- constants ----------------------------------------------------------- */

/* squared sine of the angle between two rays: the least parallax, 0.1 degree. A bearing
 * error e moves the point in depth by range * e / sin(angle). At this angle that is over
 * 500 times as far as sideways. */
#define RC_PARALLAX_MIN RC(3.05e-6)

/* evaluations: the most of a triangulation, usually 2 or 3. It bounds the worst case, which
 * the manuals state. */
enum { RC_TRIANGULATION_EVALS = 50 };

/* ---- what is shared ------------------------------------------------------- */

/* L L^T = H with damping. Returns 0 if H is not positive definite to rounding. */
int rc_point_factor(rigcal_real L[6], const rigcal_real H[6], rigcal_real damping);

/* x <- (L L^T)^-1 x */
void rc_point_solve(rigcal_real x[3], const rigcal_real L[6]);

#endif /* RC_TRIANGULATE_H */
