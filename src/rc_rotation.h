/* rc_rotation.h - rotations without argument checks; see rigcal.h. */
#ifndef RC_ROTATION_H
#define RC_ROTATION_H

#include "rc_linalg.h"

/* ---- constants ----------------------------------------------------------- */

/* rad: beyond this the spacing of rigcal_real, as an angle, exceeds 1e-10 / 1e-4. */
#define RC_ANGLE_MAX RC_TOL(1e6, 1e3)

/* ---- functions ----------------------------------------------------------- */

/* Orthonormal to the tolerance of rigcal.h and right-handed. NaN is neither. */
int rc_is_rotation(const rigcal_real R[9]);

/* OK, ERR_NULL, ERR_NOT_FINITE or ERR_ROTATION: what a public function finds
 * first about a rotation that it is handed. */
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

/* atan2 in (-pi, pi]: of a half turn whose sine is rounding, or -0, atan2 itself
 * may make -pi. */
rigcal_real rc_angle(rigcal_real sine, rigcal_real cosine);

/* What rounding has made of a rotation is one again: its first row keeps its direction. */
void rc_rotation_tidy(rigcal_real R[9]);

/* 0 when M is singular to working precision or mirrors; R is then untouched. */
int rc_rotation_nearest(rigcal_real R[9], const rigcal_real M[9]);

#endif /* RC_ROTATION_H */
