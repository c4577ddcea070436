/* rc_refine.h - the maximum-likelihood pose: least squares of the reprojection error in
 * pixels, through the lens (EQUATIONS.md B). */
#ifndef RC_REFINE_H
#define RC_REFINE_H

#include "rc_levenberg.h"
#include "rc_points.h"

/* Computes the equations at a pose, over those of the first n observations that count: *sum
 * of the squared errors over sigma^2, g = J^T e, and H in the blocks of rc_sym6_*.
 * `equations`, RC_GAUSS_NEWTON or another, chooses the kind of H. The tangent space is
 * (w, dt): R <- exp([w]x) R, t <- t + dt. Returns OK, or ERR_BEHIND or ERR_NO_RAY if the
 * camera does not see a point. */
rigcal_status rc_refine_equations(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                                  const rigcal_points *points, size_t n,
                                  const rigcal_transform *cam_from_points, int equations);

/* Begins Levenberg-Marquardt from state->cam_from_points. Each step evaluates the equations
 * once. state->search.status is RUNNING until it is OK, BUDGET_SPENT (max_evals) or a
 * failure. If `is_wide`, the refinement starts with errors along the rays. Then it also
 * computes the ray of every pixel. */
void rc_refine_begin(rigcal_refinement *state, int is_wide);

/* Call it after rc_refine_begin: the first step then goes by some of the points, if there
 * are many. */
void rc_refine_begin_part(rigcal_refinement *state, const rigcal_points *points);

void rc_refine_step(rigcal_refinement *state, const rigcal_points *points,
                    int32_t max_evals);

#endif /* RC_REFINE_H */
