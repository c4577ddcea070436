/* rc_optima.h - the optima that a search has found. */
#ifndef RC_OPTIMA_H
#define RC_OPTIMA_H

#include "rc_transform.h"

void rc_optimum_transform(rigcal_transform *cam_from_points, const rigcal_optimum *optimum);

/* The first optimum whose rotation is within a (small) angle of R, or -1. */
int32_t rc_optima_near(const rigcal_optima *optima, const rigcal_real R[9],
                       rigcal_real angle);

/* Keeps the RIGCAL_POSES_MAX best, in order of their sums. The new one replaces the one at
 * `same`, which is the same pose and worse. If `same` is -1, the pose is a new one. Returns
 * its index, or -1 if there was no place for it. */
int32_t rc_optima_insert(rigcal_optima *optima, int32_t same,
                         const rigcal_transform *cam_from_points, rigcal_real sse);

#endif /* RC_OPTIMA_H */
