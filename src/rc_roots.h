/* rc_roots.h - where few points may be, from three of them (EQUATIONS.md D). */
#ifndef RC_ROOTS_H
#define RC_ROOTS_H

#include "rc_optima.h"
#include "rc_p3p.h"
#include "rc_points.h"

/* (D) All poses of three of the points from their unit rays; how many, as of rc_p3p. */
int32_t rc_poses_of_three(rigcal_transform cam_from_points[RC_P3P_MAX],
                          const rigcal_points *points, const int32_t index[3],
                          const rigcal_real ray[3][3]);

/* (D4) Returns the number of poses of the widest triple that the other points do not rule
 * out, 0 also where the lens images no ray at a point of the triple. They stand in list[],
 * best first. optima->n is 0 and stays so: read a pose before so many optima are found.
 * O(n). */
int32_t rc_roots_find(rigcal_optima *optima, const rigcal_points *points);

#endif /* RC_ROOTS_H */
