/* rc_direction.h - the search over the direction of the optical axis: yaw and translation
 * are eliminated together (EQUATIONS.md A, whose symbols these are). */
#ifndef RC_DIRECTION_H
#define RC_DIRECTION_H

#include "rc_transform.h"

/* Sums over the points, from which the cost of any direction follows in the same time
 * whatever n is: begin, add each point, finish. x is a point counted from the (weighted)
 * mean of the points, u its normalised image in a virtual camera that looks at the middle
 * of the target's image: there the cost is nearly the error in the image. finish: 0 when
 * the image has no extent. */
void rc_moments_begin(rigcal_moments *sums);
void rc_moments_add(rigcal_moments *sums, rigcal_real weight, const rigcal_real x[3],
                    const rigcal_real u[2]);
int rc_moments_finish(rigcal_moments *sums);

/* The sums of the points mirrored at their mean, -x: only the depth changes its sign. */
void rc_moments_mirror(rigcal_moments *sums);

/* Object-space cost of the direction m3 (unit length: the optical axis, seen from the
 * target): the least over translation, with the points' mean in front, and over yaw. As a
 * function of yaw it has up to two minima. Near an optimum the right one is found; far from
 * any, in some three directions of a hundred, it may be the other. RC_MAX where the mean
 * cannot be in front. */
rigcal_real rc_direction_cost(const rigcal_moments *sums, const rigcal_real m3[3]);

/* The pose that has that cost: virtual camera from the points as counted above. */
void rc_direction_pose(rigcal_transform *virtual_from_points, const rigcal_moments *sums,
                       const rigcal_real m3[3]);

#endif /* RC_DIRECTION_H */
