/* rc_agree.h - which points agree with a pose, and whether chance explains that they do
 * (EQUATIONS.md E). No derivatives, no square roots. */
#ifndef RC_AGREE_H
#define RC_AGREE_H

#include "rc_chance.h"
#include "rc_points.h"

/* Of squared distances, each bin half the one before: the last is for distances below
 * 0.6 % of the limit's. */
enum { RC_AGREE_BINS = 16 };

/* Sum over the points of their squared distance from their projection over sigma_i^2, none
 * counting more than `limit` [px^2]. It is given up where it comes to `enough`: *sum is
 * then at least that. Returns how many of the points gone through are within the limit. */
size_t rc_agree_score(rigcal_real *sum, const rigcal_points *points,
                      const rigcal_transform *cam_from_points, rigcal_real limit,
                      rigcal_real enough);

/* How far the points within the limit are off: bin k is for those within limit / 2^k and
 * not limit / 2^(k + 1), the last for all that are nearer. */
typedef struct {
    size_t count[RC_AGREE_BINS];
    rigcal_real sum[RC_AGREE_BINS]; /* of their distances squared */
} rc_agree_histogram;

/* Sets marks[i] to 1 for points within the limit, to 0 for the others. *off, which may be
 * NULL, gets the distances. Returns how many marks changed. */
size_t rc_agree_mark(uint8_t marks[], rc_agree_histogram *off, const rigcal_points *points,
                     const rigcal_transform *cam_from_points, rigcal_real limit);

/* (E) By how many poses so many of n points would be expected to be so near if all were
 * wrong: of the nearest k, for the k of which that is least. It is not sought below
 * `enough`. area: of the pixels, in the unit of the distances squared. */
rigcal_real rc_agree_by_chance(const rc_agree_histogram *off, size_t n, rigcal_real area,
                               rigcal_real enough);

#endif /* RC_AGREE_H */
