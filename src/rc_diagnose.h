/* rc_diagnose.h - what is wrong with observations that fit badly; see rigcal.h. */
#ifndef RC_DIAGNOSE_H
#define RC_DIAGNOSE_H

#include "rc_pose.h"

#endif /* RC_DIAGNOSE_H */
