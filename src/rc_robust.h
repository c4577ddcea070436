/* rc_robust.h - a pose from correspondences some of which are wrong; see rigcal.h. */
#ifndef RC_ROBUST_H
#define RC_ROBUST_H

#include "rc_pose.h"

#endif /* RC_ROBUST_H */
