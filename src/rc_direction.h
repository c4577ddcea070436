/* rc_direction.h - the search over the direction of the optical axis. Yaw and translation
 * are eliminated together (EQUATIONS.md A, which defines the symbols). */
#ifndef RC_DIRECTION_H
#define RC_DIRECTION_H

#include "rc_transform.h"

/* Sums over the points. The cost of any direction follows from them in a time that does not
 * depend on n. Begin, add each point, finish. x is a point less the weighted mean of the
 * points. u is its normalised image in a virtual camera that looks at the middle of the
 * target's image. There the cost is nearly the error in the image. finish returns 0 if the
 * image has no extent. */
void rc_moments_begin(rigcal_moments *sums);
void rc_moments_add(rigcal_moments *sums, rigcal_real weight, const rigcal_real x[3],
                    const rigcal_real u[2]);
int rc_moments_finish(rigcal_moments *sums);

/* The sums for the points mirrored at their mean, -x. For the same direction and yaw the
 * depth changes its sign, and the cost stays. */
void rc_moments_mirror(rigcal_moments *sums);

/* Object-space cost of the direction m3 of unit length: the optical axis as seen from the
 * target. It is the minimum over translation, with the points' mean in front, and over yaw.
 * As a function of yaw it has up to two minima. Near an optimum the lower one is found; far
 * from any, in some three directions of a hundred, it may be the other. RC_MAX if the mean
 * cannot be in front. */
rigcal_real rc_direction_cost(const rigcal_moments *sums, const rigcal_real m3[3]);

/* The pose of this cost: virtual camera from the points, less their mean as above. */
void rc_direction_pose(rigcal_transform *virtual_from_points, const rigcal_moments *sums,
                       const rigcal_real m3[3]);

#endif /* RC_DIRECTION_H */
