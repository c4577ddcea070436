/* rc_pose.h - what the pose solver is made of. */
#ifndef RC_POSE_H
#define RC_POSE_H

#include "rc_neldermead.h"
#include "rc_refine.h"
#include "rc_view.h"

#endif /* RC_POSE_H */
