/* rc_rotation.h - rotations without argument checks; see rigcal.h. */
#ifndef RC_ROTATION_H
#define RC_ROTATION_H

#include "rc_linalg.h"

/* ---- constants ----------------------------------------------------------- */

/* rad: the largest angle. Beyond it the spacing of rigcal_real exceeds 1e-10 / 1e-4 rad. */
#define RC_ANGLE_MAX RC_TOL(1e6, 1e3)

/* ---- functions ----------------------------------------------------------- */

/* Whether R is orthonormal to the tolerance of rigcal.h and right-handed. Returns 0 for
 * NaN. */
int rc_is_rotation(const rigcal_real R[9]);

/* Checks a rotation from a caller: OK, ERR_NULL, ERR_NOT_FINITE or ERR_ROTATION. */
rigcal_status rc_check_rotation(const rigcal_real R[9]);

void rc_rotation_x(rigcal_real R[9], rigcal_real angle);
void rc_rotation_y(rigcal_real R[9], rigcal_real angle);
void rc_rotation_z(rigcal_real R[9], rigcal_real angle);
void rc_rotation_from_yaw_pitch_roll(rigcal_real R[9], const rigcal_real ypr[3]);
void rc_yaw_pitch_roll_from_rotation(rigcal_real ypr[3], const rigcal_real R[9]);
void rc_rotation_from_quaternion(rigcal_real R[9], const rigcal_real q_wxyz[4]);
void rc_quaternion_from_rotation(rigcal_real q_wxyz[4], const rigcal_real R[9]);
void rc_rotation_from_vector(rigcal_real R[9], const rigcal_real w[3]);
void rc_vector_from_rotation(rigcal_real w[3], const rigcal_real R[9]);
rigcal_real rc_rotation_angle(const rigcal_real Ra[9], const rigcal_real Rb[9]);

/* atan2 in (-pi, pi]. atan2 itself may return -pi for a half turn whose sine is rounding or
 * -0. */
rigcal_real rc_angle(rigcal_real sine, rigcal_real cosine);

/* Makes a rotation again of what rounding left of one. Its first row keeps its
 * direction. */
void rc_rotation_tidy(rigcal_real R[9]);

/* The nearest rotation to M. Returns 0, without writing R, if M is singular to working
 * precision or mirrors. */
int rc_rotation_nearest(rigcal_real R[9], const rigcal_real M[9]);

#endif /* RC_ROTATION_H */
