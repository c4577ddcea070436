/* rc_pose.h - the pose solver, for layers that build on it. */
#ifndef RC_POSE_H
#define RC_POSE_H

#include "rc_chance.h"
#include "rc_seeds.h"

/* Like rigcal_pose_begin, but for points made by rc_points_of. It surveys them, and checks
 * everything except that `solver` is not NULL. */
rigcal_status rc_pose_begin(rigcal_pose_solver *solver, int32_t *at_fault,
                            rigcal_points *points, const rigcal_pose_options *options);

/* After a search is done: how many optima it found, optimum i, and its likelihood divided
 * by that of the first. */
int32_t rc_pose_n_found(const rigcal_pose_solver *s);
void rc_pose_found(rigcal_transform *cam_from_points, const rigcal_pose_solver *s,
                   int32_t i);
rigcal_real rc_pose_likelihood(const rigcal_pose_solver *s, int32_t i);

/* The origin to which the points of this search are centred. */
const rigcal_real *rc_pose_origin(const rigcal_pose_solver *s);

/* Removes optimum i from those found. */
void rc_pose_drop(rigcal_pose_solver *s, int32_t i);

#endif /* RC_POSE_H */
