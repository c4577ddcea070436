/* rc_refine.h - the maximum-likelihood pose: least squares of the reprojection error in
 * pixels, through the lens (EQUATIONS.md B). */
#ifndef RC_REFINE_H
#define RC_REFINE_H

#include "rc_levenberg.h"
#include "rc_points.h"

/* At a pose, over those of the first n observations that count: *sum of the squared errors
 * over sigma^2, g = J^T e, and H by `equations`, RC_GAUSS_NEWTON or another, in the blocks
 * of rc_sym6_*; in the tangent space (w, dt): R <- exp([w]x) R, t <- t + dt.
 * OK, or ERR_BEHIND, ERR_NO_RAY: the camera does not see a point. */
rigcal_status rc_refine_equations(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                                  const rigcal_points *points, size_t n,
                                  const rigcal_transform *cam_from_points, int equations);

/* Levenberg-Marquardt from state->cam_from_points, one evaluation of the equations a step.
 * state->search.status is RUNNING until it is OK, BUDGET_SPENT (max_evals) or a failure.
 * is_wide: from errors along the rays at first, whose equations take the ray of every pixel
 * too. */
void rc_refine_begin(rigcal_refinement *state, int is_wide);

/* After rc_refine_begin: the first step of many points is to be by some of them. */
void rc_refine_begin_part(rigcal_refinement *state, const rigcal_points *points);

void rc_refine_step(rigcal_refinement *state, const rigcal_points *points,
                    int32_t max_evals);

#endif /* RC_REFINE_H */
