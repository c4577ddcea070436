/* rc_intrinsics.h - how a projection changes with the camera's intrinsics (CONSIDER in
 * EQUATIONS.md). */
#ifndef RC_INTRINSICS_H
#define RC_INTRINSICS_H

#include "rc_camera.h"

/* The parameters of a camera: fx and fy by a part of themselves, fx / fy by a part, the
 * principal point [px], k1 and k2. */
enum {
    RC_BY_FOCAL = 0,
    RC_BY_ASPECT = 1,
    RC_BY_CENTRE = 2, /* and the next one: cx, cy */
    RC_BY_K1 = 4,
    RC_BY_K2 = 5,
    RC_INTRINSICS = 6
};

/* D = d projection / d parameters, row by row: 2 x RC_INTRINSICS. x and uv are what
 * rc_project_by has found for the point: its place in the plane of the lens map, and its
 * pixel. */
void rc_intrinsics(rigcal_real D[2 * RC_INTRINSICS], const rigcal_camera *camera,
                   const rigcal_real x[2], const rigcal_real uv[2]);

#endif /* RC_INTRINSICS_H */
