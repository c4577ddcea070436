/* rc_linalg.h - 3-vectors, 3 x 3 matrices (row-major), symmetric matrices and their
 * Cholesky factors. */
#ifndef RC_LINALG_H
#define RC_LINALG_H

#include "rc_real.h"

RC_INLINE rigcal_real rc_vec3_dot(const rigcal_real a[3], const rigcal_real b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline void rc_vec3_cross(rigcal_real out[3], const rigcal_real a[3],
                          const rigcal_real b[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

RC_INLINE rigcal_real rc_vec6_dot(const rigcal_real a[6], const rigcal_real b[6])
{
    return rc_vec3_dot(a, b) + rc_vec3_dot(&a[3], &b[3]);
}

RC_INLINE void rc_vec3_copy(rigcal_real out[3], const rigcal_real a[3])
{
    out[0] = a[0];
    out[1] = a[1];
    out[2] = a[2];
}

inline void rc_vec3_sub(rigcal_real out[3], const rigcal_real a[3], const rigcal_real b[3])
{
    out[0] = a[0] - b[0];
    out[1] = a[1] - b[1];
    out[2] = a[2] - b[2];
}

/* out += a */
inline void rc_vec3_add(rigcal_real out[3], const rigcal_real a[3])
{
    out[0] += a[0];
    out[1] += a[1];
    out[2] += a[2];
}

/* out += s a */
inline void rc_vec3_add_scaled(rigcal_real out[3], rigcal_real s, const rigcal_real a[3])
{
    out[0] += s * a[0];
    out[1] += s * a[1];
    out[2] += s * a[2];
}

/* out = s a */
inline void rc_vec3_scale(rigcal_real out[3], rigcal_real s, const rigcal_real a[3])
{
    out[0] = s * a[0];
    out[1] = s * a[1];
    out[2] = s * a[2];
}

/* out = s a + t b */
inline void rc_vec3_combine(rigcal_real out[3], rigcal_real s, const rigcal_real a[3],
                            rigcal_real t, const rigcal_real b[3])
{
    out[0] = s * a[0] + t * b[0];
    out[1] = s * a[1] + t * b[1];
    out[2] = s * a[2] + t * b[2];
}

/* x = 0 */
void rc_clear(rigcal_real x[], size_t n);

/* Whether a vector has length 1, to the tolerance of a rotation. For preconditions. */
#define RC_IS_UNIT(v) (RC_FABS(rc_vec3_dot(v, v) - 1) <= RC_TOL(1e-6, 1e-3))

rigcal_real rc_vec3_norm(const rigcal_real a[3]);
rigcal_real rc_vec3_max_abs(const rigcal_real a[3]);

/* out = a / |a| without overflow or underflow on the way. Returns 0 if a is zero. */
int rc_vec3_unit(rigcal_real out[3], const rigcal_real a[3]);

/* Rows m1 and m2 that make a rotation with the unit vector m3 (Duff et al. 2017). */
void rc_vec3_complete(rigcal_real m1[3], rigcal_real m2[3], const rigcal_real m3[3]);

/* out = M v, out = M^T v */
inline void rc_mat3_mul_vec3(rigcal_real out[3], const rigcal_real M[9],
                             const rigcal_real v[3])
{
    out[0] = rc_vec3_dot(&M[0], v);
    out[1] = rc_vec3_dot(&M[3], v);
    out[2] = rc_vec3_dot(&M[6], v);
}

void rc_mat3_tmul_vec3(rigcal_real out[3], const rigcal_real M[9], const rigcal_real v[3]);

/* out = A B, out = A B^T */
void rc_mat3_mul(rigcal_real out[9], const rigcal_real A[9], const rigcal_real B[9]);
void rc_mat3_mul_t(rigcal_real out[9], const rigcal_real A[9], const rigcal_real B[9]);

/* The cofactors of M, det(M) M^-T. Returns det(M). */
rigcal_real rc_mat3_cofactors(rigcal_real out[9], const rigcal_real M[9]);

/* Symmetric 3 x 3 matrices are stored as xx, xy, xz, yy, yz, zz. */

/* A += s x x^T */
void rc_sym3_add_outer(rigcal_real A[6], rigcal_real s, const rigcal_real x[3]);

/* The direction of unit length in which points with the moments C = sum x x^T extend least:
 * the eigenvector of the least eigenvalue. With the eigenvalues a, b, c divided by their
 * sum, *thickness is 1 / (1/a + 1/b + 1/c), which is about the least of them. For a plane
 * it is rounding. Returns 0 if the points are on a line to rounding and have no such
 * direction. */
int rc_sym3_thinnest(rigcal_real normal[3], rigcal_real *thickness, const rigcal_real C[6]);

/* out = A v */
void rc_sym3_mul_vec3(rigcal_real out[3], const rigcal_real A[6], const rigcal_real v[3]);

/* Cholesky's factor of A = L L^T. L is xx, yx, zx, yy, zy, zz, with the inverses of its
 * diagonal; it may be A. Returns 0 if A is not positive definite to working precision: a
 * pivot is at most `rank_tol` times its element of `diagonal`. */
int rc_sym3_factor(rigcal_real L[6], const rigcal_real A[6], const rigcal_real diagonal[3],
                   rigcal_real rank_tol);

/* damped = A + damping D. D is diag(A), but at least a hundredth of its largest element. */
void rc_sym3_damp(rigcal_real damped[6], rigcal_real D[3], const rigcal_real A[6],
                  rigcal_real damping);

/* x <- L^-1 x, x <- L^-T x */
inline void rc_sym3_forward(rigcal_real x[3], const rigcal_real L[6])
{
    x[0] *= L[0];
    x[1] = (x[1] - L[1] * x[0]) * L[3];
    x[2] = (x[2] - L[2] * x[0] - L[4] * x[1]) * L[5];
}

inline void rc_sym3_backward(rigcal_real x[3], const rigcal_real L[6])
{
    x[2] *= L[5];
    x[1] = (x[1] - L[4] * x[2]) * L[3];
    x[0] = (x[0] - L[1] * x[1] - L[2] * x[2]) * L[0];
}

/* ---- symmetric 6 x 6 matrices, in blocks of three -----------------------
 *
 * H[21]: the first block as above, the block across (row by row: a row of the first three,
 * a column of the last three), and the second block as above. */
enum { RC_SYM6_ACROSS = 6, RC_SYM6_SECOND = 15 };

/* Cholesky's factor of such a matrix: (first 0; across^T second). */
typedef struct {
    rigcal_real first[6], across[3][3], second[6];
} rc_sym6_factor;

/* L L^T = H + damping D, with D as in rc_sym3_damp. L may lie in the memory of H, element
 * by element. Returns 0 if it is not positive definite to rounding. */
int rc_sym6_factor_of(rc_sym6_factor *L, const rigcal_real H[21], rigcal_real damping);

/* x <- L^-1 x, x <- L^-T x, x <- (L L^T)^-1 x */
void rc_sym6_forward(rigcal_real x[6], const rc_sym6_factor *L);
void rc_sym6_backward(rigcal_real x[6], const rc_sym6_factor *L);
void rc_sym6_solve(rigcal_real x[6], const rc_sym6_factor *L);

/* All of H, row by row; and H from the upper triangle. */
void rc_sym6_unpack(rigcal_real full[36], const rigcal_real H[21]);
void rc_sym6_pack(rigcal_real H[21], const rigcal_real full[36]);

/* y = H x */
void rc_sym6_mul(rigcal_real y[6], const rigcal_real H[21], const rigcal_real x[6]);

/* Sigma = H^-1, row by row. Returns 0 if H is not positive definite to rounding. */
int rc_sym6_invert(rigcal_real Sigma[36], const rigcal_real H[21]);

/* The trace of the first block of H^-1. Returns 0 as above; *trace then keeps its value. */
int rc_sym6_inverse_trace(rigcal_real *trace, const rigcal_real H[21]);

/* ---- symmetric matrices of any size, packed ------------------------------
 *
 * The lower triangle row by row: element (i, j), j <= i, is A[i (i + 1) / 2 + j]. */
inline size_t rc_packed_at(size_t i, size_t j)
{
    return i * (i + 1) / 2 + j;
}

/* The place of element (i, j), whichever of both is larger. */
RC_INLINE size_t rc_packed_of(size_t i, size_t j)
{
    return (i >= j) ? rc_packed_at(i, j) : rc_packed_at(j, i);
}

/* Replaces row i of A by row i of Cholesky's factor, with the inverse of its diagonal. The
 * rows above must have been replaced. Returns 0 if the pivot is at most `least`: A is not
 * positive definite to rounding. O(i^2). */
int rc_packed_factor_row(rigcal_real A[], size_t i, rigcal_real least);

/* x <- L^-1 x, x <- L^-T x; O(n^2). */
void rc_packed_forward(rigcal_real x[], const rigcal_real L[], size_t n);
void rc_packed_backward(rigcal_real x[], const rigcal_real L[], size_t n);

/* The first replaces row i of L by row i of L^-1, O(i^2). The second then replaces row i of
 * L^-1 by row i of (L L^T)^-1 = L^-T L^-1, O(n i). The rows above must have been
 * replaced. */
void rc_packed_invert_row(rigcal_real L[], size_t i);
void rc_packed_square_row(rigcal_real L_inverse[], size_t i, size_t n);

/* A <- A^-1, O(n^3). Returns 0 if A is not positive definite to rounding; A is then
 * overwritten. */
int rc_packed_invert(rigcal_real A[], size_t n);

#endif /* RC_LINALG_H */
