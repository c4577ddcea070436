#include "rc_linalg.h"

int rc_vec3_unit(rigcal_real out[3], const rigcal_real a[3])
{
    const rigcal_real largest = rc_vec3_max_abs(a);
    if (!(largest > 0)) {
        return 0;
    }
    /* Two divisions, not one by a reciprocal: 1 / largest overflows when largest
     * is subnormal. */
    const rigcal_real b[3] = {a[0] / largest, a[1] / largest, a[2] / largest};
    const rigcal_real length = rc_vec3_norm(b);
    for (int i = 0; i < 3; i++) {
        out[i] = b[i] / length;
    }
    return 1;
}

void rc_mat3_mul_vec3(rigcal_real out[3], const rigcal_real M[9],
                      const rigcal_real v[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = rc_vec3_dot(&M[3 * i], v);
    }
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

int rc_cholesky(rigcal_real A[], int n, rigcal_real rank_tol)
{
    RIGCAL_ASSERT(n >= 1 && n <= RC_CHOLESKY_MAX);
    for (int j = 0; j < n; j++) {
        const rigcal_real diagonal = A[j * n + j];
        rigcal_real pivot = diagonal;
        for (int k = 0; k < j; k++) {
            pivot -= A[j * n + k] * A[j * n + k];
        }
        if (!(pivot > rank_tol * diagonal)) {
            return 0;
        }
        const rigcal_real root = RC_SQRT(pivot);
        A[j * n + j] = root;
        for (int i = j + 1; i < n; i++) {
            rigcal_real sum = A[i * n + j];
            for (int k = 0; k < j; k++) {
                sum -= A[i * n + k] * A[j * n + k];
            }
            A[i * n + j] = sum / root;
        }
    }
    return 1;
}

void rc_cholesky_solve(rigcal_real x[], const rigcal_real L[], int n)
{
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++) {
            x[i] -= L[i * n + k] * x[k];
        }
        x[i] /= L[i * n + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++) {
            x[i] -= L[k * n + i] * x[k];
        }
        x[i] /= L[i * n + i];
    }
}

void rc_cholesky_inverse(rigcal_real out[], const rigcal_real L[], int n)
{
    rigcal_real column[RC_CHOLESKY_MAX];
    for (int j = 0; j < n; j++) {
        for (int i = 0; i < n; i++) {
            column[i] = (i == j) ? 1 : 0;
        }
        rc_cholesky_solve(column, L, n);
        for (int i = 0; i < n; i++) {
            out[i * n + j] = column[i];
        }
    }
}
