/* rc_bearings.h - points, and the rays along which they were seen. */
#ifndef RC_BEARINGS_H
#define RC_BEARINGS_H

#include "rc_camera.h"
#include "rigcal_paper.h"

/* Checks a bearing: OK, ERR_NOT_FINITE, ERR_RANGE. If need_z, also ERR_WIDE_RAY: z is not
 * positive. */
rigcal_status rc_check_bearing(const rigcal_bearing *bearing, int need_z);

/* The status of the first bearing that is wrong, of n; also ERR_NULL. */
rigcal_status rc_check_bearings(const rigcal_bearing bearings[], size_t n, int need_z);

#endif /* RC_BEARINGS_H */
