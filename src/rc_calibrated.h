/* rc_calibrated.h - a calibrated rig, with the joint covariance of its cameras, in memory
 * of the caller. See rigcal_rig.h. */
#ifndef RC_CALIBRATED_H
#define RC_CALIBRATED_H

#include "rc_transform.h"
#include "rc_views.h"

/* Checks pointers, counts, groups, roles, and the numbers besides the covariance. OK,
 * ERR_NULL, ERR_TOO_FEW, ERR_CAPACITY, ERR_NOT_FINITE, ERR_RANGE; ERR_STATE: there is no
 * joint covariance. *n_free: number of cameras that are not held. */
rigcal_status rc_calibrated_check(size_t *n_free, const rigcal_calibrated_rig *rig);

/* The first unknown of a camera of a checked rig, or -1 if it is held. */
rigcal_real rc_calibrated_first(const rigcal_calibrated_rig *rig, size_t camera);

/* Checks sigma_px, F and its two degrees of freedom: OK, ERR_NOT_FINITE, ERR_RANGE (below
 * 0), ERR_STATE (sigma_px is 0). */
rigcal_status rc_calibrated_numbers(const rigcal_real numbers[4]);

#endif /* RC_CALIBRATED_H */
