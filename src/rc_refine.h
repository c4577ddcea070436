/* rc_refine.h - maximum likelihood: least squares of the reprojection error in
 * pixels, through the lens (EQUATIONS.md B). */
#ifndef RC_REFINE_H
#define RC_REFINE_H

#include "rc_camera.h"

/* What is fitted: n observations. sigma NULL: all 1; a mask's 0 leaves the point out, NULL:
 * none. Nothing is read; all points count, and none is mirrored. */
void rc_fit_of(rigcal_fit *fit, const rigcal_camera *camera,
               const rigcal_observation observations[], const rigcal_real sigma[],
               const uint8_t mask[], size_t n);

/* The rest of it: the lens of the camera, which is checked, and the origin from which the
 * points count, so that a far world costs no digits and w turns about the middle of the
 * target. */
void rc_fit_begin(rigcal_fit *fit, const rigcal_real origin[3]);

/* Whether point i counts. */
inline int rc_fit_uses(const rigcal_fit *fit, size_t i)
{
    return (int32_t)i != fit->left_out && (fit->mask == NULL || fit->mask[i] != 0);
}

/* Point i from the origin; of a mirrored target, mirrored there. */
void rc_fit_point(rigcal_real x[3], const rigcal_fit *fit, size_t i);

/* Point i from the origin, turned into the camera's axes, q = R x, and in its frame. */
void rc_fit_place(rigcal_real q[3], rigcal_real X_c[3], const rigcal_fit *fit,
                  const rigcal_transform *cam_from_points, size_t i);

/* Squared distance [px^2] of point i from its projection; RC_MAX: it has none. */
rigcal_real rc_fit_distance2(const rigcal_fit *fit,
                             const rigcal_transform *cam_from_points, size_t i);

/* Sum of squared errors over sigma at a pose, J^T e, and J^T J in blocks
 * (rigcal_refine.c), in the tangent space (w, dt): R <- exp([w]x) R, t <- t + dt.
 * OK, or ERR_BEHIND, ERR_NO_RAY: the camera does not see a point. */
rigcal_status rc_normal_equations(rigcal_real *sse, rigcal_real g[6],
                                  rigcal_real H[21], const rigcal_fit *fit,
                                  const rigcal_transform *cam_from_points);

/* The same, but that H has the curvature of a pinhole's projection too: Newton's, half
 * the second derivative of the sum but for that of the lens. */
rigcal_status rc_newton_equations(rigcal_real *sse, rigcal_real g[6],
                                  rigcal_real H[21], const rigcal_fit *fit,
                                  const rigcal_transform *cam_from_points);

/* Levenberg-Marquardt from state->cam_from_points, one evaluation of the equations a
 * call, with Newton's in place of Gauss and Newton's where progress is slow;
 * state->status is RUNNING until it is OK, BUDGET_SPENT (max_evals) or a failure. is_wide:
 * from errors along the rays, whose equations take the ray of every pixel too. */
void rc_refine_begin(rigcal_refinement *state, int is_wide);
void rc_refine_step(rigcal_refinement *state, const rigcal_fit *fit,
                    int32_t max_evals);

/* Inverse of J^T J, full. 0 when it is singular: the points do not fix the pose. */
int rc_refine_covariance(rigcal_real Sigma[36], const rigcal_real H[21]);

/* Of it the trace of the rotation's block alone. */
int rc_refine_rotation_variance(rigcal_real *variance, const rigcal_real H[21]);

#endif /* RC_REFINE_H */
