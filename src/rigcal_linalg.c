#include "rc_linalg.h"

int rc_is_finite(rigcal_real x)
{
    return RC_FABS(x) <= RC_MAX;
}

int rc_all_finite(const rigcal_real x[], int n)
{
    return rc_all_within(x, n, RC_MAX);
}

int rc_all_within(const rigcal_real x[], int n, rigcal_real limit)
{
    for (int i = 0; i < n; i++) {
        if (!(RC_FABS(x[i]) <= limit)) {
            return 0;
        }
    }
    return 1;
}

rigcal_status rc_check_numbers(const rigcal_real x[], int n, rigcal_real limit)
{
    if (x == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (rc_all_within(x, n, limit)) {
        return RIGCAL_OK;
    }
    return rc_all_finite(x, n) ? RIGCAL_ERR_RANGE : RIGCAL_ERR_NOT_FINITE;
}

rigcal_real rc_vec3_norm(const rigcal_real a[3])
{
    return RC_SQRT(rc_vec3_dot(a, a));
}

rigcal_real rc_vec3_max_abs(const rigcal_real a[3])
{
    return rc_max(RC_FABS(a[0]), rc_max(RC_FABS(a[1]), RC_FABS(a[2])));
}

int rc_vec3_unit(rigcal_real out[3], const rigcal_real a[3])
{
    const rigcal_real largest = rc_vec3_max_abs(a);
    if (!(largest > 0)) {
        return 0;
    }
    /* Not by a reciprocal: 1 / largest overflows when largest is subnormal. */
    const rigcal_real b[3] = {a[0] / largest, a[1] / largest, a[2] / largest};
    rc_vec3_scale(out, 1 / rc_vec3_norm(b), b);
    return 1;
}

void rc_mat3_tmul_vec3(rigcal_real out[3], const rigcal_real M[9],
                       const rigcal_real v[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = M[i] * v[0] + M[3 + i] * v[1] + M[6 + i] * v[2];
    }
}

void rc_mat3_mul(rigcal_real out[9], const rigcal_real A[9],
                 const rigcal_real B[9])
{
    for (int i = 0; i < 3; i++) {
        rc_mat3_tmul_vec3(&out[3 * i], B, &A[3 * i]);
    }
}

void rc_mat3_mul_t(rigcal_real out[9], const rigcal_real A[9],
                   const rigcal_real B[9])
{
    for (int i = 0; i < 3; i++) {
        rc_mat3_mul_vec3(&out[3 * i], B, &A[3 * i]);
    }
}

rigcal_real rc_mat3_cofactors(rigcal_real out[9], const rigcal_real M[9])
{
    rc_vec3_cross(&out[0], &M[3], &M[6]);
    rc_vec3_cross(&out[3], &M[6], &M[0]);
    rc_vec3_cross(&out[6], &M[0], &M[3]);
    return rc_vec3_dot(&M[0], &out[0]);
}

void rc_sym3_add_outer(rigcal_real A[6], rigcal_real s, const rigcal_real x[3])
{
    const rigcal_real sy = s * x[1];
    rc_vec3_add_scaled(A, s * x[0], x);
    A[3] += sy * x[1];
    A[4] += sy * x[2];
    A[5] += s * x[2] * x[2];
}

void rc_sym3_mul_vec3(rigcal_real out[3], const rigcal_real A[6],
                      const rigcal_real v[3])
{
    out[0] = rc_vec3_dot(A, v);
    out[1] = A[1] * v[0] + A[3] * v[1] + A[4] * v[2];
    out[2] = A[2] * v[0] + A[4] * v[1] + A[5] * v[2];
}

/* Of the root of a pivot, the inverse. */
static int invert_root(rigcal_real *inverse, rigcal_real pivot,
                       rigcal_real least)
{
    if (!(pivot > least)) {
        return 0;
    }
    *inverse = 1 / RC_SQRT(pivot);
    return 1;
}

int rc_sym3_factor(rigcal_real L[6], const rigcal_real A[6],
                   const rigcal_real diagonal[3], rigcal_real rank_tol)
{
    if (!invert_root(&L[0], A[0], rank_tol * diagonal[0])) {
        return 0;
    }
    L[1] = A[1] * L[0];
    L[2] = A[2] * L[0];
    if (!invert_root(&L[3], A[3] - L[1] * L[1], rank_tol * diagonal[1])) {
        return 0;
    }
    L[4] = (A[4] - L[2] * L[1]) * L[3];
    return invert_root(&L[5], A[5] - L[2] * L[2] - L[4] * L[4],
                       rank_tol * diagonal[2]);
}

/* ---- the bodies of inline functions -------------------------------------- */

extern inline rigcal_real rc_max(rigcal_real a, rigcal_real b);
extern inline rigcal_real rc_min(rigcal_real a, rigcal_real b);
extern inline rigcal_real rc_vec3_dot(const rigcal_real a[3],
                                      const rigcal_real b[3]);
extern inline void rc_vec3_cross(rigcal_real out[3], const rigcal_real a[3],
                                 const rigcal_real b[3]);
extern inline void rc_vec3_copy(rigcal_real out[3], const rigcal_real a[3]);
extern inline void rc_vec3_sub(rigcal_real out[3], const rigcal_real a[3],
                               const rigcal_real b[3]);
extern inline void rc_vec3_add(rigcal_real out[3], const rigcal_real a[3]);
extern inline void rc_vec3_add_scaled(rigcal_real out[3], rigcal_real s,
                                      const rigcal_real a[3]);
extern inline void rc_vec3_scale(rigcal_real out[3], rigcal_real s,
                                 const rigcal_real a[3]);
extern inline void rc_vec3_combine(rigcal_real out[3], rigcal_real s,
                                   const rigcal_real a[3], rigcal_real t,
                                   const rigcal_real b[3]);
extern inline void rc_mat3_mul_vec3(rigcal_real out[3], const rigcal_real M[9],
                                    const rigcal_real v[3]);
extern inline void rc_sym3_forward(rigcal_real x[3], const rigcal_real L[6]);
extern inline void rc_sym3_backward(rigcal_real x[3], const rigcal_real L[6]);
