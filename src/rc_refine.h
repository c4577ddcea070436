/* rc_refine.h - maximum likelihood: least squares of the reprojection error in
 * pixels, through the lens (EQUATIONS.md B). */
#ifndef RC_REFINE_H
#define RC_REFINE_H

#include "rc_camera.h"

/* What is fitted. X counts from `origin`, so that a far world costs no digits. */
typedef struct {
    const rigcal_camera *camera;
    const rigcal_observation *observations;
    const uint8_t *use; /* one byte an observation, 0 leaves it out; or NULL */
    size_t n;
    rigcal_real origin[3];
    rc_lens lens;
} rc_fit;

/* Normal equations at a pose, in the tangent space (w, dt): R <- exp([w]x) R,
 * t <- t + dt. H: lower triangle of J^T J, row by row. */
typedef struct {
    rigcal_real H[21], g[6], sse;
} rc_normal;

/* OK, ERR_BEHIND or ERR_NO_RAY: a point is not seen by the camera. */
rigcal_status rc_normal_at(rc_normal *out, const rc_fit *fit,
                           const rigcal_transform *cam_from_points);

/* Levenberg-Marquardt from *pose, at most max_steps. *sse gets the sum of squares
 * in pixels. OK, BUDGET_SPENT, ERR_BEHIND, ERR_NO_RAY, ERR_DEGENERATE. */
rigcal_status rc_refine(rigcal_transform *cam_from_points, rigcal_real *sse,
                        const rc_fit *fit, int max_steps);

#endif /* RC_REFINE_H */
