/* rc_pose.h - the pose solver, for layers that build on it. */
#ifndef RC_POSE_H
#define RC_POSE_H

#include "rc_chance.h"
#include "rc_seeds.h"

/* rigcal_pose_begin of points as rc_points_of makes them, which are surveyed here. Checks
 * everything but that `solver` is not NULL. */
rigcal_status rc_pose_begin(rigcal_pose_solver *solver, int32_t *at_fault,
                            rigcal_points *points, const rigcal_pose_options *options);

/* Of a search that is done: how many points it took, how many optima it found, where
 * optimum i is, and its likelihood over that of the first. */
size_t rc_pose_n_used(const rigcal_pose_solver *s);
int32_t rc_pose_n_found(const rigcal_pose_solver *s);
void rc_pose_found(rigcal_transform *cam_from_points, const rigcal_pose_solver *s,
                   int32_t i);
rigcal_real rc_pose_likelihood(const rigcal_pose_solver *s, int32_t i);

/* Takes optimum i out of those found. */
void rc_pose_drop(rigcal_pose_solver *s, int32_t i);

#endif /* RC_POSE_H */
