/* rc_residual.h - the pixel error of one point through the lens, and what it adds to least
 * squares by a rigid transform or by the point (EQUATIONS.md B).
 *
 * Of a point X_c in the camera's frame: e = uv - projection [px], and
 * B = d projection / d X_c, 2 x 3. Where X_c = q + t, q = R x, a small turn w and shift dt
 * of the transform move it by w x q + dt, so the rows of J are (q x b, b), b a row of B. A
 * point in frame a moves it by R_ca dX_a, so its rows are those of B R_ca. */
#ifndef RC_RESIDUAL_H
#define RC_RESIDUAL_H

#include "rc_camera.h"

/* Returns OK, or what rc_project_through returns; then e and B are undefined. */
inline rigcal_status rc_residual(rigcal_real e[2], rigcal_real B[6],
                                 const rigcal_camera *camera, int is_pinhole,
                                 const rigcal_real uv[2], const rigcal_real X_c[3])
{
    const rigcal_status status = rc_project_through(e, B, camera, is_pinhole, X_c);
    if (status == RIGCAL_OK) {
        e[0] = uv[0] - e[0];
        e[1] = uv[1] - e[1];
    }
    return status;
}

/* The error along the observed unit ray m. To first order it is the error in pixels,
 * without the pole that a pinhole has 90 degrees off the axis. B = d projection / d X at m,
 * where B m = 0; e = -B X_c. Both are |X_c| times too large: weigh them by 1 / |X_c|^2. */
void rc_residual_along_ray(rigcal_real e[2], rigcal_real B[6], const rigcal_camera *camera,
                           int is_pinhole, const rigcal_real m[3],
                           const rigcal_real X_c[3]);

/* Least squares by a rigid transform: g = J^T e and H = J^T J in the blocks of rc_sym6_*,
 * by w, across (a row of w, a column of dt) and by dt. */
void rc_rigid_clear(rigcal_real g[6], rigcal_real H[21]);

/* Adds one point, weighed. If X_c is not NULL, H also gets the curvature of the error, as
 * in Newton's method. It is exact for a pinhole, and nearly so for another lens. */
void rc_rigid_add(rigcal_real g[6], rigcal_real H[21], const rigcal_real B[6],
                  const rigcal_real q[3], const rigcal_real e[2], rigcal_real weight,
                  const rigcal_real X_c[3], int is_fisheye);

/* Least squares by a point of frame a: g += J^T e, H += J^T J (xx, xy, xz, yy, yz, zz),
 * J = B R_ca. */
void rc_point_add(rigcal_real g[3], rigcal_real H[6], const rigcal_real B[6],
                  const rigcal_real R_ca[9], const rigcal_real e[2]);

#endif /* RC_RESIDUAL_H */
