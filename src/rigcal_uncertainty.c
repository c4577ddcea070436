#include "rc_chance.h"
#include "rc_refine.h"

/* Two shifts of a covariance. From t' of the points' own origin to t of the world's origin:
 * t = t' - R o, so dt = dt' - w x R o. To the camera's centre -R^T t, with w and dt in the
 * camera's axes: d(-R^T t) = -R^T (dt - w x t). Both are Sigma <- A Sigma A^T with A = (1
 * 0; [s]x 1), where s = R o or s = t. */
static void shift_covariance(rigcal_real Sigma[36], const rigcal_real s[3])
{
    const rigcal_real S[9] = {0, -s[2], s[1], s[2], 0, -s[0], -s[1], s[0], 0};
    for (int j = 0; j < 6; j++) { /* rows: dt += [s]x w */
        for (int r = 0; r < 3; r++) {
            for (int k = 0; k < 3; k++) {
                Sigma[6 * (3 + r) + j] += S[3 * r + k] * Sigma[6 * k + j];
            }
        }
    }
    for (int j = 0; j < 6; j++) { /* columns */
        for (int r = 0; r < 3; r++) {
            for (int k = 0; k < 3; k++) {
                Sigma[6 * j + 3 + r] += S[3 * r + k] * Sigma[6 * j + k];
            }
        }
    }
}

/* Standard deviations along the world's axes, from a covariance block in the camera's
 * axes. */
static void center_sigmas(rigcal_real out[3], const rigcal_real Sigma[36],
                          const rigcal_real R[9])
{
    for (int i = 0; i < 3; i++) {
        rigcal_real variance = 0;
        for (int r = 0; r < 3; r++) {
            for (int c = 0; c < 3; c++) {
                variance += R[3 * r + i] * Sigma[6 * (3 + r) + 3 + c] * R[3 * c + i];
            }
        }
        out[i] = RC_SQRT(rc_max(0, variance));
    }
}

static void fill_uncertainty(rigcal_pose_uncertainty *out,
                             const rigcal_transform *cam_from_world,
                             const rigcal_real at_points[36],
                             const rigcal_real turned_origin[3], rigcal_real noise2)
{
    rigcal_real at_center[36];
    for (int k = 0; k < 36; k++) {
        out->Sigma[k] = noise2 * at_points[k];
    }
    shift_covariance(out->Sigma, turned_origin);
    for (int row = 0; row < 6; row++) { /* symmetric to the last bit */
        for (int column = 0; column < row; column++) {
            out->Sigma[6 * column + row] = out->Sigma[6 * row + column];
        }
    }
    for (int k = 0; k < 36; k++) {
        at_center[k] = out->Sigma[k];
    }
    shift_covariance(at_center, cam_from_world->t);
    center_sigmas(out->center, at_center, cam_from_world->R);
    for (int k = 0; k < 3; k++) {
        out->rotation[k] = RC_SQRT(out->Sigma[7 * k]);
        out->translation[k] = RC_SQRT(rc_max(0, out->Sigma[7 * (3 + k)]));
    }
    out->sigma_px = RC_SQRT(noise2);
}

/* Checks the caller's input and surveys the points. */
static rigcal_status survey(rigcal_points *points, const rigcal_view *view,
                            const rigcal_transform *cam_from_world, rigcal_real sigma_px)
{
    rigcal_real uv_middle[2];
    int32_t at;
    rigcal_status status = rc_check_view(view);
    if (status == RIGCAL_OK) {
        status = rc_check_transform(cam_from_world);
    }
    if (status == RIGCAL_OK) {
        status = rc_check_noise(&sigma_px);
    }
    if (status == RIGCAL_OK && view->n == 3 && !(sigma_px > 0)) {
        status = RIGCAL_ERR_TOO_FEW;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_points_of(points, view, NULL);
    status = rc_points_survey(points, uv_middle, &at);
    return (status == RIGCAL_ERR_COINCIDENT || status == RIGCAL_ERR_PRECISION) ? RIGCAL_OK
                                                                               : status;
}

rigcal_status rigcal_pose_covariance(rigcal_pose_uncertainty *out, const rigcal_view *view,
                                     const rigcal_transform *cam_from_world,
                                     rigcal_real sigma_px)
{
    rigcal_points points;
    if (out == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = survey(&points, view, cam_from_world, sigma_px);
    if (status != RIGCAL_OK) {
        return status;
    }
    /* A line fixes no turn about itself. Rounding may hide this from the normal equations,
     * but not from the points. */
    if (rc_points_are_on_line(&points)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    rigcal_real sse, g[6], H[21], at_points[36], turned[3];
    rigcal_transform cam_from_points = *cam_from_world;
    rc_transform_point(cam_from_points.t, cam_from_world, points.origin);
    status = rc_refine_equations(&sse, g, H, &points, view->n, &cam_from_points,
                                 RC_GAUSS_NEWTON);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!rc_sym6_invert(at_points, H)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    rc_mat3_mul_vec3(turned, cam_from_world->R, points.origin);
    fill_uncertainty(out, cam_from_world, at_points, turned,
                     (sigma_px > 0) ? sigma_px * sigma_px : sse / rc_freedom(view->n));
    return RIGCAL_OK;
}
