/* rc_pose.h - what the pose solver is made of. */
#ifndef RC_POSE_H
#define RC_POSE_H

#include "rc_neldermead.h"
#include "rc_p3p.h"
#include "rc_refine.h"
#include "rc_view.h"

/* rigcal_pose_begin of the points whose mask is not 0 (NULL: all), but that *at is
 * always written and a failure may leave *solver half-written. The mask must stay. */
rigcal_status rc_pose_begin(rigcal_pose_solver *solver, int32_t *at,
                            const rigcal_camera *camera,
                            const rigcal_observation observations[],
                            const rigcal_real sigma[], const uint8_t mask[],
                            size_t n, const rigcal_pose_options *options);

/* Of a search that is done: likelihood of optimum i over that of the first. */
rigcal_real rc_pose_likelihood(const rigcal_pose_solver *s, int32_t i);

#endif /* RC_POSE_H */
