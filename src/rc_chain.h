/* rc_chain.h - a view of a rig as a chain of two transforms (RIG in EQUATIONS.md).
 *
 * cam_from_target = cam_from_rig rig_from_placement. A small turn and shift (w, dt) of
 * each, which makes R <- exp([w]x) R and t <- t + dt, moves cam_from_target by
 *
 *     d_target = A d_camera + B d_placement,
 *     A = (1 0; -[a]x 1),  B = (R_c 0; 0 R_c),  a = R_c t_placement
 *
 * So the least squares by cam_from_target, g = J^T e and H = J^T J, turn into least squares
 * by both. */
#ifndef RC_CHAIN_H
#define RC_CHAIN_H

#include "rc_transform.h"

typedef struct {
    rigcal_transform cam_from_target;
    const rigcal_real *R_c;
    rigcal_real lever[3]; /* a */
} rc_chain;

void rc_chain_of(rc_chain *chain, const rigcal_transform *cam_from_rig,
                 const rigcal_transform *rig_from_placement);

/* g_placement += B^T g, H_placement += B^T H B */
void rc_chain_add_placement(rigcal_real g_placement[6], rigcal_real H_placement[21],
                            const rc_chain *chain, const rigcal_real g[6],
                            const rigcal_real H[21]);

/* g <- A^T g, H <- A^T H A, and W = A^T H B, row by row. Rows of W belong to the camera,
 * columns to the placement. */
void rc_chain_camera(rigcal_real g[6], rigcal_real H[21], rigcal_real W[36],
                     const rc_chain *chain);

/* d = (log(R_to R^T), t_to - t): the step that takes `from` to `to`. It is exact to first
 * order. */
void rc_deviation(rigcal_real d[6], const rigcal_transform *to,
                  const rigcal_transform *from);

#endif /* RC_CHAIN_H */
