/* rc_filter.h - the poses of bodies, and the joint covariance of their errors, as rows and
 * time change them (M6 to M9 of MONITOR in EQUATIONS.md).
 *
 * P = U D U^T (Bierman 1977): U is unit upper triangular, and its column j is packed as row
 * j of a lower triangle is, with D on the diagonal. In float it stays positive definite
 * where P itself would not: a pair's baseline is never seen, all else to ever less. */
#ifndef RC_FILTER_H
#define RC_FILTER_H

#include "rc_rows.h"

/* ---- a factored covariance ---------------------------------------------------- */

/* A row's own part of n unknowns: 6 numbers from `at` on, less than 0: none. */
typedef struct {
    int32_t at[2];
    const rigcal_real *h[2];
} rc_part;

/* room = U^T h. Returns h P h; O(n^2) at most, of n unknowns, 6 of each body. */
rigcal_real rc_filter_seen(rigcal_real room[], const rigcal_real UD[], size_t n,
                           const rc_part *part);

/* P -= gain / S P h h^T P, gain <= 1, after rc_filter_seen: S = hPh + the noise. Then
 * room = P h, of the P before. O(n^2) */
void rc_filter_learn(rigcal_real UD[], rigcal_real room[], size_t n, rigcal_real hPh,
                     rigcal_real S, rigcal_real gain);

/* A row that may be wrong (M8): nu is its innovation, S the variance of that if it is
 * right. beta, the probability that it is; gain, of rc_filter_learn; the likelihood of nu.
 * */
typedef struct {
    rigcal_real beta, gain, likelihood;
} rc_doubt;

void rc_filter_doubt(rc_doubt *doubt, rigcal_real nu, rigcal_real S, rigcal_real wrong);

/* P in the place of UD, packed; and back. O(n^3 / 6) each. */
void rc_filter_multiply(rigcal_real UD[], size_t n);
void rc_filter_factor(rigcal_real P[], size_t n);

/* ---- bodies ------------------------------------------------------------------ */

/* (M9) What a body that is open makes of a row: its noise of variance 1 + BEND hPh u, with
 * u the variance of w and of dt / reach. UD: the factors of the body's own P, n unknowns.
 * */
rigcal_real rc_filter_bend(const rigcal_real UD[], size_t n, size_t first,
                           rigcal_real reach);

/* Where the parts are, in memory of the caller's. Of n = 6 (n_bodies - 1) unknowns: */
typedef struct {
    size_t n_bodies, frame, n;
    size_t n_cameras;        /* the first bodies; the others are targets */
    uint32_t placed;         /* bit k: target k has a place */
    rigcal_transform *poses; /* n_bodies, body_from_rig */
    rigcal_real *UD;         /* n (n + 1) / 2 */
    rigcal_real *d;          /* n: the error estimated, and not yet in the poses */
    rigcal_real *room;       /* n; zeros between rows: one that fails leaves no trace */
} rc_filter;

/* Whether a body is there: a camera, or a target with a place. */
int rc_filter_has(const rc_filter *f, size_t body);

/* The first unknown of a body; -1: it is the frame. */
int32_t rc_filter_first(const rc_filter *f, size_t body);

/* What a row does: its innovation in standard deviations z, and sd = sqrt(S). */
typedef struct {
    rigcal_real z, sd;
    rc_doubt doubt;
} rc_news;

/* A row of bodies a and b, told but not learnt: O(n). 0: its numbers are not finite. */
int rc_filter_ask(rc_news *news, const rc_filter *f, size_t a, size_t b, const rc_row *row,
                  rigcal_real wrong);

/* The same, and learnt: O(n^2). open: bits of the bodies that may be off by degrees: 1 of
 * a, 2 of b. */
int rc_filter_row(rc_news *news, const rc_filter *f, size_t a, size_t b, const rc_row *row,
                  rigcal_real wrong, int open);

/* Takes d of a body into its pose; what rounding leaves of it stays in d. */
void rc_filter_apply(const rc_filter *f, size_t body);

/* A body moved, by variances q_rad of each axis and q_t (M6, M7), or by the covariance
 * Q[36]; P is multiplied out. A move of the frame is one of all others. O(n_bodies^2) */
void rc_filter_spread(const rc_filter *f, rigcal_real P[], size_t body, rigcal_real q_rad,
                      rigcal_real q_t);
void rc_filter_spread_by(const rc_filter *f, rigcal_real P[], size_t body,
                         const rigcal_real Q[36]);

/* out = A B C^T, 6 x 6, row by row. */
void rc_filter_through(rigcal_real out[36], const rigcal_real A[36],
                       const rigcal_real B[36], const rigcal_real C[36]);

/* The pose of a body is `pose` now. Of the frame: all others follow, so that its own pose
 * stays. */
void rc_filter_put(const rc_filter *f, size_t body, const rigcal_transform *pose);

/* Of P = U D U^T the covariance of two bodies, row by row; 0 of the frame. O(n) */
void rc_filter_block(rigcal_real out[36], const rc_filter *f, size_t a, size_t b);

/* One element of P. O(n) */
rigcal_real rc_filter_element(const rigcal_real UD[], size_t n, size_t i, size_t j);

/* A body leaves: its unknowns are 0, and so is what is known of them. P is multiplied out.
 * */
void rc_filter_leave(const rc_filter *f, rigcal_real P[], size_t body);

/* Adds a body whose error depends on another body: d = by d_other + noise of covariance Q.
 * P is multiplied out. */
void rc_filter_come(const rc_filter *f, rigcal_real P[], size_t body, size_t other,
                    const rigcal_real by[36], const rigcal_real Q[36]);

#endif /* RC_FILTER_H */
