/* rc_agree.h - which points agree with a pose, and whether chance explains that they do
 * (EQUATIONS.md E). It needs no derivatives and no square roots. */
#ifndef RC_AGREE_H
#define RC_AGREE_H

#include "rc_chance.h"
#include "rc_points.h"

/* Bins of squared distances. Each reaches half as far as the one before. The last is for
 * distances below 0.6 % of the limit. */
enum { RC_AGREE_BINS = 16 };

/* The sum over the points of their squared distance from their projection over sigma_i^2.
 * No point adds more than `limit` [px^2]. The loop stops when the sum reaches `enough`:
 * then *sum is at least that. Returns how many of the points gone through are within the
 * limit. */
size_t rc_agree_score(rigcal_real *sum, const rigcal_points *points,
                      const rigcal_transform *cam_from_points, rigcal_real limit,
                      rigcal_real enough);

/* How far the points within the limit are off. Bin k is for those within limit / 2^k but
 * not within limit / 2^(k + 1). The last bin is for all nearer points. */
typedef struct {
    size_t count[RC_AGREE_BINS];
    rigcal_real sum[RC_AGREE_BINS]; /* of their squared distances */
} rc_agree_histogram;

/* The mark of a point. NO_RAY stays as it is: the lens images no ray at that pixel. A point
 * beside the turning point of the lens may be seen near such a pixel. */
enum { RC_AGREE_NOT, RC_AGREE_YES, RC_AGREE_NO_RAY };

/* Sets marks[i] to 1 for points within the limit, else to 0. *off gets the distances,
 * unless it is NULL. Returns how many marks changed. */
size_t rc_agree_mark(uint8_t marks[], rc_agree_histogram *off, const rigcal_points *points,
                     const rigcal_transform *cam_from_points, rigcal_real limit);

/* The area [px^2] of the rectangle in which the points were seen, over the mean of their
 * sigma_i^2. It exceeds the image by at most the image's size. */
rigcal_real rc_agree_area(const rigcal_view *view);

/* (E) How badly the rectangle in which the points were seen fits that of the image of all
 * points. It is 1 less the area that they share over the area of both together: 0 if they
 * are equal, 1 if they do not meet. It is 1 if the camera does not see a point. */
rigcal_real rc_agree_misfit(const rigcal_points *points,
                            const rigcal_transform *cam_from_points);

/* Whether two poses differ by more than `most` [rad], or more than that part of a's
 * distance. */
int rc_agree_differ(const rigcal_transform *a, const rigcal_transform *b, rigcal_real most);

/* (E) The expected number of poses that have as many of n points as near, if all points are
 * wrong. The nearest k points are counted, for the k that makes the figure least. The
 * search stops once it is below `enough`. area: of the pixels, in the unit of the squared
 * distances. */
rigcal_real rc_agree_by_chance(const rc_agree_histogram *off, size_t n, rigcal_real area,
                               rigcal_real enough);

#endif /* RC_AGREE_H */
