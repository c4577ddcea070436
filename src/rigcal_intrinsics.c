#include "rc_intrinsics.h"

/* With s = |x|^2 the lens map changes by x s / D with k1, and by x s^2 / D with k2. This
 * holds for Brown's lens and for the fisheye, whose x has the length theta and whose D is
 * 1. */
void rc_intrinsics(rigcal_real D[2 * RC_INTRINSICS], const rigcal_camera *camera,
                   const rigcal_real x[2], const rigcal_real uv[2])
{
    const rigcal_real s = x[0] * x[0] + x[1] * x[1];
    const rigcal_real k4 = rc_lens_is_fisheye(camera) ? 0 : camera->k4;
    const rigcal_real along = s / (1 + s * (k4 + s * (camera->k5 + s * camera->k6)));
    const rigcal_real f[2] = {camera->fx, camera->fy};
    const rigcal_real c[2] = {camera->cx, camera->cy};
    for (int row = 0; row < 2; row++) {
        rigcal_real *const d = &D[RC_INTRINSICS * row];
        d[RC_BY_FOCAL] = uv[row] - c[row];
        d[RC_BY_ASPECT] = ((row == 0) ? d[RC_BY_FOCAL] : -d[RC_BY_FOCAL]) / 2;
        d[RC_BY_CENTRE] = (row == 0) ? 1 : 0;
        d[RC_BY_CENTRE + 1] = (row == 0) ? 0 : 1;
        d[RC_BY_K1] = f[row] * along * x[row];
        d[RC_BY_K2] = d[RC_BY_K1] * s;
    }
}
