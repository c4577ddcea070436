/* rc_pose.h - what layers below use of the pose solver. */
#ifndef RC_POSE_H
#define RC_POSE_H

#include "rc_camera.h"
#include "rc_equations.h"
#include "rc_neldermead.h"

#endif /* RC_POSE_H */
