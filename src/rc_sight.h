/* rc_sight.h - what one camera of a calibrated rig saw of a point: its equations, and the
 * covariance that it has with the others (POINT in EQUATIONS.md). */
#ifndef RC_SIGHT_H
#define RC_SIGHT_H

#include "rc_calibrated.h"
#include "rc_triangulate.h"

/* One view, in the caller's memory to work in. */
typedef struct {
    rigcal_real order;      /* of the k-th: the number of the k-th view that is used */
    rigcal_real agrees;     /* with the pair under way: 1; 0 */
    rigcal_real chosen;     /* agrees with the best pair so far: 1; 0 */
    rigcal_real first;      /* unknown of its camera; -1: its pose is exact */
    rigcal_real is_pinhole; /* 1; 0 */
    rigcal_real weight;     /* 1 / sigma^2 [1/px^2] */
    rigcal_real ray[3];     /* in the rig's frame, of length 1; 0: the lens images none */
    rigcal_real e[2];       /* what is left [px] */
    rigcal_real A[6];       /* d projection / d X, 2 x 3 */
    rigcal_real B[12];      /* d projection / d (w, dt), 2 x 6 */
    rigcal_real G[6];       /* d X / d pixel, 3 x 2 */
    rigcal_real y[8];       /* two rows of L^-1 (A e), L L^T = V */
} rc_sighted;

/* Its number of reals, as RIGCAL_POINT_WORK has it. */
enum { RC_SIGHT_REALS = 43 };

/* Checks view i and its camera, and makes its ray. */
rigcal_status rc_sight_check(rc_sighted *v, const rigcal_sightings *s, size_t i);

/* e and A at X. OK, ERR_BEHIND, ERR_NO_RAY, ERR_DEGENERATE. */
rigcal_status rc_sight_evaluate(rc_sighted *v, const rigcal_sightings *s, size_t i,
                                const rigcal_real X[3]);

/* B, after A; and whether the camera sees X through its lens: OK, ERR_BEHIND, ERR_NO_RAY,
 * ERR_DEGENERATE. */
rigcal_status rc_sight_move(rc_sighted *v, const rigcal_sightings *s, size_t i,
                            const rigcal_real X[3]);

/* C = B_a Sigma_ab B_b^T, 2 x 2: what the calibration adds to V. */
void rc_sight_block(rigcal_real C[4], const rc_sighted *a, const rc_sighted *b,
                    const rigcal_real Sigma[]);

/* Adds the k-th view that is used. 0: V is not positive definite. */
int rc_sight_add(rigcal_point_sums *sums, rc_sighted sights[], size_t k,
                 const rigcal_real Sigma[]);

#endif /* RC_SIGHT_H */
