/* rc_rows.h - what cameras see, as rows. A row is one scalar equation, r = h_a . d_a + h_b
 * . d_b + noise of standard deviation 1 (M1 to M4 of MONITOR in EQUATIONS.md). A body is a
 * camera or a target, and its pose is body_from_rig. d = (w, ds) is its error: a turn by w
 * about the body's own centre, then a shift by ds. R becomes exp(w) R, and t becomes exp(w)
 * t + ds. So no row depends on where the rig has its origin. */
#ifndef RC_ROWS_H
#define RC_ROWS_H

#include "rc_camera.h"

/* The unit ray of a pixel, and how the pixel's noise moves it. The columns T[0] and T[1]
 * are sigma_px dm/du and sigma_px dm/dv, across the ray. */
typedef struct {
    rigcal_real m[3], T[2][3];
} rc_sight;

/* Makes the sight of a checked camera. ray may have any length but 0. OK, ERR_NO_RAY,
 * ERR_BEHIND, ERR_DEGENERATE. */
rigcal_status rc_sight_of(rc_sight *sight, const rigcal_camera *camera,
                          const rigcal_real ray[3], rigcal_real sigma_px);

typedef struct {
    rigcal_real r, h_a[6], h_b[6];
    rigcal_real reach; /* length: a shift by it changes h like a turn by a radian */
} rc_row;

/* What was seen of two bodies a and b: a match, or a point of a target. */
typedef struct {
    size_t a, b;
    int n_rows;                  /* 1: a match of two cameras; 2: camera a sees target b */
    rc_sight sight[2];           /* of a match: the two rays */
    const rigcal_camera *camera; /* of a view: the camera, */
    rigcal_real X[3], uv[2];     /* the point of the target and its pixel, */
    rigcal_real sigma_px;        /* and the pixel's noise */
} rc_seen;

/* Makes the n_rows rows, with the two bodies at these poses. OK; of a match ERR_DEGENERATE
 * (it is on the line through both centres); of a view ERR_BEHIND, ERR_NO_RAY,
 * ERR_DEGENERATE. */
rigcal_status rc_rows_of(rc_row rows[], const rc_seen *seen, const rigcal_transform *a,
                         const rigcal_transform *b);

/* Places a target by a view of a camera. by_camera says how its error depends on the error
 * of the camera's pose. by_view says it of the error (w, dt) of the view's pose, where t
 * becomes t + dt. They are 36 numbers each, row by row. */
void rc_rows_place(rigcal_transform *target_from_rig, rigcal_real by_camera[36],
                   rigcal_real by_view[36], const rigcal_transform *camera_from_rig,
                   const rigcal_transform *camera_from_target);

#endif /* RC_ROWS_H */
