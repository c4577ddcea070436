/* rc_border.h - parameters beside cameras and placements: what they share with the cameras
 * once each placement has been eliminated, as placements stream by (CONSIDER in
 * EQUATIONS.md).
 *
 * Of each parameter, a column, a view has E = J^T D, 6 numbers by (w, dt) of
 * cam_from_target; Q = D^T D and q = D^T e are of columns alone. A placement with the
 * factor L, the cameras' rows Y_c = W_c L^-T and Y = L^-1 sum of B^T E leaves
 *
 *     T_c += A^T E - Y_c Y,    Q -= Y^T Y,    q -= Y^T L^-1 g
 *
 * The rig has been adjusted: S^-1 is in its memory to work in, of the poses before the last
 * step, which is some 1e-4 of it. An adjustment from the optimum makes it exact. */
#ifndef RC_BORDER_H
#define RC_BORDER_H

#include "rc_chain.h"

typedef rigcal_border rc_border; /* all memory is of who begins it */

/* The number of reals of Q, and where element (i, j), first[i] <= j <= i, of it is. O(i) */
size_t rc_border_size(const rc_border *border);
size_t rc_border_at(const rc_border *border, size_t i, size_t j);

/* All sums are 0; the first placement begins. */
void rc_border_begin(rc_border *border);

/* A view of the placement: its chain, its camera's first unknown (-1: it is held), and its
 * equations by cam_from_target. Afterwards g and H are by the camera. */
void rc_border_view(rc_border *border, const rc_chain *chain, rigcal_real at,
                    rigcal_real g[6], rigcal_real H[21]);

/* Adds E of that view to a column. */
void rc_border_add(rc_border *border, const rc_chain *chain, size_t column,
                   const rigcal_real E[6]);

/* The placement has all its views: it is eliminated. 0: its information is not positive
 * definite to rounding, nothing has been added. O(k (n_views + widest row of Q)) */
int rc_border_eliminate(rc_border *border);

/* The next placement begins. */
void rc_border_next(rc_border *border);

/* G = S^-1 T of a column; S_inverse packed. What one unit of the parameter does to the
 * cameras. G may not be T. O(n^2) */
void rc_border_effect(rigcal_real G[], const rc_border *border,
                      const rigcal_real S_inverse[], size_t column);

/* I_ij = Q_ij - T_i^T G_j, and u_i = q_i - G_i^T g; g of the cameras, NULL: 0. */
rigcal_real rc_border_information(const rc_border *border, size_t i, size_t j,
                                  const rigcal_real G_j[]);
rigcal_real rc_border_slope(const rc_border *border, size_t i, const rigcal_real G_i[],
                            const rigcal_real g[]);

/* rows <- L^-1 rows: k rows of `width`, L packed as of rc_packed_factor_row. The sum of
 * their outer products is then that with the weight (L L^T)^-1. O(k^2 width) */
void rc_border_mix(rigcal_real rows[], size_t width, const rigcal_real L[], size_t k);

#endif /* RC_BORDER_H */
