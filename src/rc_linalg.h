/* rc_linalg.h - 3-vectors, 3 x 3 matrices (row-major), small Cholesky. */
#ifndef RC_LINALG_H
#define RC_LINALG_H

#include "rc_real.h"

static inline rigcal_real rc_vec3_dot(const rigcal_real a[3],
                                      const rigcal_real b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void rc_vec3_cross(rigcal_real out[3], const rigcal_real a[3],
                                 const rigcal_real b[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static inline void rc_vec3_sub(rigcal_real out[3], const rigcal_real a[3],
                               const rigcal_real b[3])
{
    out[0] = a[0] - b[0];
    out[1] = a[1] - b[1];
    out[2] = a[2] - b[2];
}

/* out += s a */
static inline void rc_vec3_add_scaled(rigcal_real out[3], rigcal_real s,
                                      const rigcal_real a[3])
{
    out[0] += s * a[0];
    out[1] += s * a[1];
    out[2] += s * a[2];
}

static inline rigcal_real rc_vec3_norm(const rigcal_real a[3])
{
    return RC_SQRT(rc_vec3_dot(a, a));
}

static inline rigcal_real rc_vec3_max_abs(const rigcal_real a[3])
{
    return rc_max(RC_FABS(a[0]), rc_max(RC_FABS(a[1]), RC_FABS(a[2])));
}

/* out = a / |a| without overflow or underflow on the way; 0 when a is zero. */
int rc_vec3_unit(rigcal_real out[3], const rigcal_real a[3]);

/* out = M v, out = M^T v */
void rc_mat3_mul_vec3(rigcal_real out[3], const rigcal_real M[9],
                      const rigcal_real v[3]);
void rc_mat3_tmul_vec3(rigcal_real out[3], const rigcal_real M[9],
                       const rigcal_real v[3]);

/* out = A B, out = A B^T */
void rc_mat3_mul(rigcal_real out[9], const rigcal_real A[9],
                 const rigcal_real B[9]);
void rc_mat3_mul_t(rigcal_real out[9], const rigcal_real A[9],
                   const rigcal_real B[9]);

/* Cofactors of M: det(M) M^-T. Returns det(M). */
rigcal_real rc_mat3_cofactors(rigcal_real out[9], const rigcal_real M[9]);

enum { RC_CHOLESKY_MAX = 6 };

/* Lower Cholesky factor of the symmetric n x n matrix A, n <= RC_CHOLESKY_MAX,
 * in place; only the lower triangle is read and written. 0 when A is not positive
 * definite to working precision: a pivot has lost all but `rank_tol` of the
 * diagonal element it came from. */
int rc_cholesky(rigcal_real A[], int n, rigcal_real rank_tol);

/* x <- (L L^T)^-1 x */
void rc_cholesky_solve(rigcal_real x[], const rigcal_real L[], int n);

/* out = (L L^T)^-1, the full symmetric matrix. */
void rc_cholesky_inverse(rigcal_real out[], const rigcal_real L[], int n);

#endif /* RC_LINALG_H */
