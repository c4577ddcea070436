/* rc_border.h - parameters beside cameras and placements. It finds what they share with the
 * cameras, and eliminates one placement after the other (CONSIDER in EQUATIONS.md).
 *
 * Each parameter is a column. With D, the derivative of a view's projections by the
 * parameter, the view adds E = J^T D, 6 numbers by (w, dt) of cam_from_target. It also adds
 * Q = D^T D and q = D^T e, of columns alone. A placement has the factor L, the rows Y_c =
 * W_c L^-T of each camera, and Y = L^-1 sum of B^T E. When it is eliminated
 *
 *     T_c += A^T E - Y_c Y,    Q -= Y^T Y,    q -= Y^T L^-1 g
 *
 * The rig must have been adjusted: S^-1 is in rig->work. It belongs to the poses before the
 * last step, so it is off by some 1e-4 of itself. An adjustment that begins at the optimum
 * makes it exact. */
#ifndef RC_BORDER_H
#define RC_BORDER_H

#include "rc_chain.h"

typedef rigcal_border rc_border; /* the caller who begins it owns all memory */

/* The number of reals of Q, and the index of its element (i, j), first[i] <= j <= i.
 * O(i) */
size_t rc_border_size(const rc_border *border);
size_t rc_border_at(const rc_border *border, size_t i, size_t j);

/* Sets all sums to 0 and begins the first placement. */
void rc_border_begin(rc_border *border);

/* Adds a view of the placement: its chain, the first unknown of its camera (-1: held), and
 * its equations by cam_from_target. Afterwards g and H are by the camera. */
void rc_border_view(rc_border *border, const rc_chain *chain, rigcal_real at,
                    rigcal_real g[6], rigcal_real H[21]);

/* Adds E of the last view to a column. */
void rc_border_add(rc_border *border, const rc_chain *chain, size_t column,
                   const rigcal_real E[6]);

/* Eliminates the placement after all its views were added. Returns 0, and adds nothing, if
 * its information is not positive definite to rounding. O(k (n_views + widest row of Q)) */
int rc_border_eliminate(rc_border *border);

/* Begins the next placement. */
void rc_border_next(rc_border *border);

/* G = S^-1 T of a column: what one unit of the parameter does to the cameras. S_inverse is
 * packed. G must not be T. O(n^2) */
void rc_border_effect(rigcal_real G[], const rc_border *border,
                      const rigcal_real S_inverse[], size_t column);

/* I_ij = Q_ij - T_i^T G_j, and u_i = q_i - G_i^T g. g is that of the cameras; NULL stands
 * for 0. */
rigcal_real rc_border_information(const rc_border *border, size_t i, size_t j,
                                  const rigcal_real G_j[]);
rigcal_real rc_border_slope(const rc_border *border, size_t i, const rigcal_real G_i[],
                            const rigcal_real g[]);

/* rows <- L^-1 rows: k rows of `width`. L is packed as by rc_packed_factor_row. The sum of
 * the rows' outer products is then that of the old rows with the weight (L L^T)^-1. O(k^2
 * width) */
void rc_border_mix(rigcal_real rows[], size_t width, const rigcal_real L[], size_t k);

#endif /* RC_BORDER_H */
