/* rc_transform.h - rigid transforms without argument checks; see rigcal.h. */
#ifndef RC_TRANSFORM_H
#define RC_TRANSFORM_H

#include "rc_rotation.h"

/* OK, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION or ERR_RANGE. */
rigcal_status rc_check_transform(const rigcal_transform *b_from_a);

/* OK, ERR_NULL, ERR_NOT_FINITE or ERR_RANGE. */
rigcal_status rc_check_point(const rigcal_real X[3]);

void rc_transform_identity(rigcal_transform *a_from_a);
void rc_transform_compose(rigcal_transform *c_from_a,
                          const rigcal_transform *c_from_b,
                          const rigcal_transform *b_from_a);
void rc_transform_invert(rigcal_transform *a_from_b,
                         const rigcal_transform *b_from_a);
void rc_transform_point(rigcal_real X_b[3], const rigcal_transform *b_from_a,
                        const rigcal_real X_a[3]);
void rc_transform_between(rigcal_transform *b_from_a,
                      const rigcal_transform *b_from_world,
                      const rigcal_transform *a_from_world);

#endif /* RC_TRANSFORM_H */
