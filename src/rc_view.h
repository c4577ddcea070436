/* rc_view.h - the search over the direction of the optical axis: yaw and
 * translation are eliminated together (EQUATIONS.md A). */
#ifndef RC_VIEW_H
#define RC_VIEW_H

#include "rc_transform.h"

/* Sums over the points, from which the cost of any direction follows in the same
 * time whatever n is. x is a point counted from the (weighted) mean of the points,
 * u its normalised image in a virtual camera that looks at the middle of the
 * target's image: there the cost is nearly the error in the image. Symmetric
 * matrices are held as xx, xy, xz, yy, yz, zz. */
void rc_view_begin(rigcal_view_moments *view);
void rc_view_add(rigcal_view_moments *view, rigcal_real weight,
                 const rigcal_real x[3], const rigcal_real u[2]);

/* Rows m1, m2 that complete the unit vector m3 to a rotation. Any will do: what they
 * turn by about m3 is taken up by yaw. */
void rc_view_complete(rigcal_real m1[3], rigcal_real m2[3],
                      const rigcal_real m3[3]);

/* After the last point. 0 when the image has no extent. */
int rc_view_finish(rigcal_view_moments *view);

/* Object-space cost of the direction m3 (unit length: the optical axis, seen from
 * the target), least over translation, with the points' mean in front, and over
 * yaw: of its two minima the one that is the pose's near an optimum; far from any, in
 * some three directions of a hundred, it may be the other. RC_MAX where the mean
 * cannot be in front. */
rigcal_real rc_view_cost(const rigcal_view_moments *view,
                         const rigcal_real m3[3]);

/* The moments of the points mirrored at their mean, -x: only the depth changes its
 * sign. */
void rc_view_mirror(rigcal_view_moments *view);

/* The pose that has that cost: virtual camera from the points as counted above. */
void rc_view_pose(rigcal_transform *virtual_from_points,
                  const rigcal_view_moments *view, const rigcal_real m3[3]);

/* The direction across which the points extend least, unit length, and by how much: with
 * a, b, c the mean squares along the axes over that of all, *thickness is 1 / (1/a + 1/b +
 * 1/c), about the least of them; of a plane rounding. 0 when the points are (nearly) on a
 * line, which has no such direction. */
int rc_view_normal(rigcal_real normal[3], rigcal_real *thickness,
                   const rigcal_view_moments *view);

#endif /* RC_VIEW_H */
