/* rc_rig.h - cameras joined into a rig; see rigcal.h. */
#ifndef RC_RIG_H
#define RC_RIG_H

#include "rc_transform.h"

#endif /* RC_RIG_H */
