/* rc_filter.h - the poses of bodies and the joint covariance P of their errors (w, ds),
 * which are those of rc_rows.h. Rows and time change them (M6 to M9 of MONITOR in
 * EQUATIONS.md).
 *
 * P = U D U^T (Bierman 1977). U is unit upper triangular. Its column j is packed like row j
 * of a lower triangle, with D on the diagonal. In float this form stays positive definite,
 * where P itself would not: the baseline of a pair is never seen, while all else becomes
 * ever surer. */
#ifndef RC_FILTER_H
#define RC_FILTER_H

#include "rc_rows.h"

/* ---- a factored covariance ---------------------------------------------------- */

/* The parts of a row that are not 0, of n unknowns: 6 numbers from at[k] on. at[k] < 0:
 * there is no such part; one of the two there is. */
typedef struct {
    int32_t at[2];
    const rigcal_real *h[2];
} rc_part;

/* room = U^T h. Returns h P h. n is 6 for each body. O(n^2) at most */
rigcal_real rc_filter_seen(rigcal_real room[], const rigcal_real UD[], size_t n,
                           const rc_part *part);

/* P -= gain / S P h h^T P with gain <= 1, after rc_filter_seen. S is hPh plus the variance
 * of the noise. Afterwards room = P h, with P before the change. O(n^2) */
void rc_filter_learn(rigcal_real UD[], rigcal_real room[], size_t n, rigcal_real hPh,
                     rigcal_real S, rigcal_real gain);

/* A row that may be wrong (M8). nu is its innovation, S the variance of nu if the row is
 * right. beta is the probability that it is right, gain that of rc_filter_learn, likelihood
 * that of nu. */
typedef struct {
    rigcal_real beta, gain, likelihood;
} rc_doubt;

void rc_filter_doubt(rc_doubt *doubt, rigcal_real nu, rigcal_real S, rigcal_real wrong);

/* Replaces UD by P, packed, and P by UD. O(n^3 / 6) each */
void rc_filter_multiply(rigcal_real UD[], size_t n);
void rc_filter_factor(rigcal_real P[], size_t n);

/* ---- bodies ------------------------------------------------------------------ */

/* (M9) What an open body adds to the variance of a row's noise: BEND u, to be multiplied by
 * hPh. u is the variance of w and of dt / reach. UD are the factors of P, or of the body's
 * own P, with n unknowns. */
rigcal_real rc_filter_bend(const rigcal_real UD[], size_t n, size_t first,
                           rigcal_real reach);

/* Pointers into memory of the caller, for n = 6 (n_bodies - 1) unknowns. */
typedef struct {
    size_t n_bodies, frame, n;
    size_t n_cameras;        /* these come first; the other bodies are targets */
    uint32_t placed;         /* bit k: target k has a place */
    rigcal_transform *poses; /* n_bodies, body_from_rig */
    rigcal_real *UD;         /* n (n + 1) / 2 */
    rigcal_real *d;          /* n: the estimated error that is not yet in the poses */
    rigcal_real *room;       /* n; all 0 between rows, so a row that fails leaves no
                                trace */
} rc_filter;

/* Whether a body is present: a camera, or a target with a place. */
int rc_filter_has(const rc_filter *f, size_t body);

/* The first unknown of a body, or -1 for the frame. */
int32_t rc_filter_first(const rc_filter *f, size_t body);

/* A row's innovation z in standard deviations, and its standard deviation sd = sqrt(S). */
typedef struct {
    rigcal_real z, sd;
    rc_doubt doubt;
} rc_news;

/* Evaluates a row of bodies a and b, without learning it: O(n). Returns 0 if its numbers
 * are not finite. */
int rc_filter_ask(rc_news *news, const rc_filter *f, size_t a, size_t b, const rc_row *row,
                  rigcal_real wrong);

/* Evaluates a row and learns it: O(n^2). open: bits of the bodies that may be off by
 * degrees: 1 for a, 2 for b. */
int rc_filter_row(rc_news *news, const rc_filter *f, size_t a, size_t b, const rc_row *row,
                  rigcal_real wrong, int open);

/* Moves the pose of a body by d. What rounding leaves of the step stays in d. */
void rc_filter_apply(const rc_filter *f, size_t body);

/* Adds the move of a body to P, which must be multiplied out: the variances q_rad and q_t
 * of each axis (M6, M7), or the covariance Q. A move of the frame is a move of all others.
 * O(n_bodies^2) */
void rc_filter_spread(const rc_filter *f, rigcal_real P[], size_t body, rigcal_real q_rad,
                      rigcal_real q_t);
void rc_filter_spread_by(const rc_filter *f, rigcal_real P[], size_t body,
                         const rigcal_real Q[36]);

/* P += M at the block of bodies a and b <= a, neither of which is the frame. P must be
 * multiplied out. M is 6 x 6, row by row. */
void rc_filter_add(const rc_filter *f, rigcal_real P[], size_t a, size_t b,
                   const rigcal_real M[36]);

/* out = A B C^T, 6 x 6, row by row. */
void rc_filter_through(rigcal_real out[36], const rigcal_real A[36],
                       const rigcal_real B[36], const rigcal_real C[36]);

/* Sets the pose of a body. If it is the frame, all other poses move instead, and its own
 * stays. */
void rc_filter_put(const rc_filter *f, size_t body, const rigcal_transform *pose);

/* The covariance of two bodies from P = U D U^T, row by row. It is 0 for the frame. O(n) */
void rc_filter_block(rigcal_real out[36], const rc_filter *f, size_t a, size_t b);

/* One element of P. O(n) */
rigcal_real rc_filter_element(const rigcal_real UD[], size_t n, size_t i, size_t j);

/* Removes a body: its rows and columns of P, and its error, become 0. P must be multiplied
 * out. */
void rc_filter_leave(const rc_filter *f, rigcal_real P[], size_t body);

/* Adds a body whose error depends on another body: d = by d_other + noise of covariance Q.
 * P must be multiplied out. */
void rc_filter_come(const rc_filter *f, rigcal_real P[], size_t body, size_t other,
                    const rigcal_real by[36], const rigcal_real Q[36]);

#endif /* RC_FILTER_H */
