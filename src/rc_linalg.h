/* rc_linalg.h - 3-vectors, 3 x 3 matrices (row-major), their Cholesky factor. */
#ifndef RC_LINALG_H
#define RC_LINALG_H

#include "rc_real.h"

inline rigcal_real rc_vec3_dot(const rigcal_real a[3],
                               const rigcal_real b[3])
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

inline void rc_vec3_copy(rigcal_real out[3], const rigcal_real a[3])
{
    out[0] = a[0];
    out[1] = a[1];
    out[2] = a[2];
}

inline void rc_vec3_sub(rigcal_real out[3], const rigcal_real a[3],
                        const rigcal_real b[3])
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
inline void rc_vec3_add_scaled(rigcal_real out[3], rigcal_real s,
                               const rigcal_real a[3])
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

rigcal_real rc_vec3_norm(const rigcal_real a[3]);
rigcal_real rc_vec3_max_abs(const rigcal_real a[3]);

/* out = a / |a| without overflow or underflow on the way; 0 when a is zero. */
int rc_vec3_unit(rigcal_real out[3], const rigcal_real a[3]);

/* out = M v, out = M^T v */
inline void rc_mat3_mul_vec3(rigcal_real out[3], const rigcal_real M[9],
                             const rigcal_real v[3])
{
    out[0] = rc_vec3_dot(&M[0], v);
    out[1] = rc_vec3_dot(&M[3], v);
    out[2] = rc_vec3_dot(&M[6], v);
}

void rc_mat3_tmul_vec3(rigcal_real out[3], const rigcal_real M[9],
                       const rigcal_real v[3]);

/* out = A B, out = A B^T */
void rc_mat3_mul(rigcal_real out[9], const rigcal_real A[9],
                 const rigcal_real B[9]);
void rc_mat3_mul_t(rigcal_real out[9], const rigcal_real A[9],
                   const rigcal_real B[9]);

/* Cofactors of M: det(M) M^-T. Returns det(M). */
rigcal_real rc_mat3_cofactors(rigcal_real out[9], const rigcal_real M[9]);

/* Symmetric 3 x 3 matrices are held as xx, xy, xz, yy, yz, zz. */

/* A += s x x^T */
void rc_sym3_add_outer(rigcal_real A[6], rigcal_real s, const rigcal_real x[3]);

/* out = A v */
void rc_sym3_mul_vec3(rigcal_real out[3], const rigcal_real A[6],
                      const rigcal_real v[3]);

/* Cholesky's factor of A = L L^T: L is xx, yx, zx, yy, zy, zz, its diagonal held as
 * inverses, and may be A. 0 when A is not positive definite to working precision: a
 * pivot is no more than `rank_tol` of its element of `diagonal`. */
int rc_sym3_factor(rigcal_real L[6], const rigcal_real A[6],
                   const rigcal_real diagonal[3], rigcal_real rank_tol);

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

#endif /* RC_LINALG_H */
