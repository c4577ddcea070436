/* rc_equations.h - the calibration equations without argument checks; see
 * rigcal.h. */
#ifndef RC_EQUATIONS_H
#define RC_EQUATIONS_H

#include "rc_rotation.h"

/* OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE or, where z is to be positive,
 * ERR_WIDE_RAY: the first fault among n sightings. */
rigcal_status rc_check_sightings(const rigcal_sighting sightings[], size_t n,
                                 int need_z);

/* OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE or ERR_TOO_FEW. */
rigcal_status rc_check_pairs(const rigcal_pair pairs[], size_t n_pairs,
                             size_t n_least);

/* OK or ERR_DEGENERATE. */
rigcal_status rc_eliminate(rigcal_elimination *out, const rigcal_pair pairs[],
                           size_t n_pairs, int32_t eliminating,
                           int32_t eliminate, const rigcal_real angles[2]);

rigcal_real rc_three_angle_residual(const rigcal_pair pairs[], size_t n_pairs,
                                    const rigcal_real ypr[3]);

/* OK or ERR_DEGENERATE. */
rigcal_status rc_translation_least_squares(rigcal_real t[3],
                                           const rigcal_real R[9],
                                           const rigcal_sighting sightings[],
                                           size_t n);

/* (yaw, pitch, roll) from the two angles searched and the eliminated one. */
void rc_angles_join(rigcal_real ypr[3], int32_t eliminate,
                    const rigcal_real angles[2], rigcal_real eliminated);
void rc_angles_split(rigcal_real angles[2], int32_t eliminate,
                     const rigcal_real ypr[3]);

#endif /* RC_EQUATIONS_H */
