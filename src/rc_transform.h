/* rc_transform.h - rigid transforms without argument checks; see rigcal.h. */
#ifndef RC_TRANSFORM_H
#define RC_TRANSFORM_H

#include "rc_rotation.h"

/* Checks a transform from a caller: OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION or
 * ERR_RANGE. */
rigcal_status rc_check_transform(const rigcal_transform *b_from_a);

/* Checks a point from a caller: OK, ERR_NULL, ERR_NOT_FINITE or ERR_RANGE. */
rigcal_status rc_check_point(const rigcal_real X[3]);

/* Checks a ray, of any length but zero: the same statuses. */
rigcal_status rc_check_ray(const rigcal_real ray[3]);

void rc_transform_identity(rigcal_transform *a_from_a);
void rc_transform_compose(rigcal_transform *c_from_a, const rigcal_transform *c_from_b,
                          const rigcal_transform *b_from_a);
void rc_transform_invert(rigcal_transform *a_from_b, const rigcal_transform *b_from_a);
void rc_transform_point(rigcal_real X_b[3], const rigcal_transform *b_from_a,
                        const rigcal_real X_a[3]);
void rc_transform_between(rigcal_transform *b_from_a, const rigcal_transform *b_from_world,
                          const rigcal_transform *a_from_world);

/* R <- exp([w]x) R, t <- t + dt for the step d = (w, dt). The exponential is exact to
 * second order, and R stays a rotation for any step. */
void rc_transform_move(rigcal_transform *pose, const rigcal_real d[6]);

/* R <- exp([w]x) R, t <- exp([w]x) t + ds for d = (w, ds): a turn about the own centre,
 * then a shift. dt is what t had to change by, before rounding. */
void rc_transform_displace(rigcal_transform *pose, rigcal_real dt[3],
                           const rigcal_real d[6]);

/* Carries the error d = (w, ds) of a to b. An error turns by w about the own centre, then
 * shifts by ds. With b_from_a = (R, t), w becomes R w and ds becomes R ds + t x R w: 36
 * numbers, row by row. */
void rc_transform_carry(rigcal_real out[36], const rigcal_transform *b_from_a);

/* M = B Q C^T, with B and C of rc_transform_carry and Q diagonal: q_rad for each element of
 * w, q_t for each of ds. */
void rc_transform_carry_equal(rigcal_real M[36], const rigcal_transform *b_from_a,
                              const rigcal_transform *c_from_a, rigcal_real q_rad,
                              rigcal_real q_t);

/* rigcal_transform_mean of n >= 1 transforms, after the weights were checked: OK or
 * ERR_ROTATION. */
rigcal_status rc_transform_mean(rigcal_transform *mean, rigcal_real *sigma_rad,
                                rigcal_real *sigma_t, const rigcal_transform transforms[],
                                const rigcal_real weight[], size_t n);

#endif /* RC_TRANSFORM_H */
