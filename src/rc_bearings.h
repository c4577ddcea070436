/* rc_bearings.h - points and the rays that they were seen along. */
#ifndef RC_BEARINGS_H
#define RC_BEARINGS_H

#include "rc_camera.h"
#include "rigcal_paper.h"

/* OK, ERR_NOT_FINITE, ERR_RANGE or, where z is to be positive, ERR_WIDE_RAY. */
rigcal_status rc_check_bearing(const rigcal_bearing *bearing, int need_z);

/* The first fault among n bearings; and ERR_NULL. */
rigcal_status rc_check_bearings(const rigcal_bearing bearings[], size_t n, int need_z);

#endif /* RC_BEARINGS_H */
