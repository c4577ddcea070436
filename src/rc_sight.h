/* rc_sight.h - what one camera of a calibrated rig saw of a point: its equations, and its
 * covariance with the other views (POINT in EQUATIONS.md). */
#ifndef RC_SIGHT_H
#define RC_SIGHT_H

#include "rc_calibrated.h"
#include "rc_triangulate.h"

/* One view, in the caller's memory to work in. */
typedef struct {
    rigcal_real order;      /* of element k: the number of the k-th view that is used */
    rigcal_real agrees;     /* 1: it agrees with the current pair; 0 */
    rigcal_real chosen;     /* 1: it agrees with the best pair so far; 0 */
    rigcal_real first;      /* first unknown of its camera; -1: its pose is exact */
    rigcal_real is_pinhole; /* 1; 0 */
    rigcal_real weight;     /* 1 / sigma^2 [1/px^2] */
    rigcal_real ray[3];     /* in the rig's frame, of length 1; 0: the lens has none */
    rigcal_real e[2];       /* residual [px] */
    rigcal_real A[6];       /* d projection / d X, 2 x 3 */
    rigcal_real B[12];      /* d projection / d (w, dt), 2 x 6 */
    rigcal_real G[6];       /* d X / d pixel, 3 x 2 */
    rigcal_real y[8];       /* its two rows of L^-1 (A e), L L^T = V */
} rc_sighted;

/* Number of reals of rc_sighted, as in RIGCAL_POINT_WORK. */
enum { RC_SIGHT_REALS = 43 };

/* Checks view i and its camera, and makes its ray. */
rigcal_status rc_sight_check(rc_sighted *v, const rigcal_sightings *s, size_t i);

/* Computes e and A at X. OK, ERR_BEHIND, ERR_NO_RAY, ERR_DEGENERATE. */
rigcal_status rc_sight_evaluate(rc_sighted *v, const rigcal_sightings *s, size_t i,
                                const rigcal_real X[3]);

/* Computes B after A, and checks that the camera sees X through its lens: OK, ERR_BEHIND,
 * ERR_NO_RAY, ERR_DEGENERATE. */
rigcal_status rc_sight_move(rc_sighted *v, const rigcal_sightings *s, size_t i,
                            const rigcal_real X[3]);

/* C = B_a Sigma_ab B_b^T, 2 x 2: what the calibration's error adds to V. */
void rc_sight_block(rigcal_real C[4], const rc_sighted *a, const rc_sighted *b,
                    const rigcal_real Sigma[]);

/* Adds the k-th used view to the sums. Returns 0 if V is not positive definite. */
int rc_sight_add(rigcal_point_sums *sums, rc_sighted sights[], size_t k,
                 const rigcal_real Sigma[]);

#endif /* RC_SIGHT_H */
