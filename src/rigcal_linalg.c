#include "rc_linalg.h"

/* ---- constants ----------------------------------------------------------- */

/* part: the moments of points, divided by their trace, have eigenvalues whose products in
 * pairs add up to this. If the sum is less, the points are on a line to rounding. */
#define LINE_THICKNESS RC_TOL(1e-12, 1e-7)

/* squarings: a matrix is squared this many times, an even number. This raises the ratios of
 * its eigenvalues to the power 64. */
enum { SQUARINGS = 6 };

/* part of the largest of its block: the least element of D. So damping acts even where
 * Newton's H has a small or negative element. */
#define D_LEAST RC(1e-2)

/* part of an element of the diagonal: a smaller pivot is rounding. */
#define RANK_TOL (8 * RC_EPS)

/* ---- numbers ------------------------------------------------------------- */

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
    RIGCAL_ASSERT((x != NULL || n == 0) && limit >= 0);
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

void rc_clear(rigcal_real x[], size_t n)
{
    for (size_t i = 0; i < n; i++) {
        x[i] = 0;
    }
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
    /* A reciprocal would not do: 1 / largest overflows if largest is subnormal. */
    const rigcal_real b[3] = {a[0] / largest, a[1] / largest, a[2] / largest};
    rc_vec3_scale(out, 1 / rc_vec3_norm(b), b);
    return 1;
}

void rc_vec3_complete(rigcal_real m1[3], rigcal_real m2[3], const rigcal_real m3[3])
{
    RIGCAL_ASSERT(RC_IS_UNIT(m3));
    const rigcal_real sign = (m3[2] < 0) ? RC(-1) : RC(1);
    const rigcal_real a = -1 / (sign + m3[2]);
    const rigcal_real b = m3[0] * m3[1] * a;
    m1[0] = 1 + sign * m3[0] * m3[0] * a;
    m1[1] = sign * b;
    m1[2] = -sign * m3[0];
    m2[0] = b;
    m2[1] = sign + m3[1] * m3[1] * a;
    m2[2] = -m3[1];
}

void rc_mat3_tmul_vec3(rigcal_real out[3], const rigcal_real M[9], const rigcal_real v[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = M[i] * v[0] + M[3 + i] * v[1] + M[6 + i] * v[2];
    }
}

void rc_mat3_mul(rigcal_real out[9], const rigcal_real A[9], const rigcal_real B[9])
{
    for (int i = 0; i < 3; i++) {
        rc_mat3_tmul_vec3(&out[3 * i], B, &A[3 * i]);
    }
}

void rc_mat3_mul_t(rigcal_real out[9], const rigcal_real A[9], const rigcal_real B[9])
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

void rc_sym3_mul_vec3(rigcal_real out[3], const rigcal_real A[6], const rigcal_real v[3])
{
    out[0] = rc_vec3_dot(A, v);
    out[1] = A[1] * v[0] + A[3] * v[1] + A[4] * v[2];
    out[2] = A[2] * v[0] + A[4] * v[1] + A[5] * v[2];
}

/* *inverse = 1 / sqrt(pivot). Returns 0 if pivot <= least. */
RC_APART static int invert_root(rigcal_real *inverse, rigcal_real pivot, rigcal_real least)
{
    if (!(pivot > least)) {
        return 0;
    }
    *inverse = 1 / RC_SQRT(pivot);
    return 1;
}

int rc_sym3_factor(rigcal_real L[6], const rigcal_real A[6], const rigcal_real diagonal[3],
                   rigcal_real rank_tol)
{
    RIGCAL_ASSERT(rank_tol >= 0);
    if (!invert_root(&L[0], A[0], rank_tol * diagonal[0])) {
        return 0;
    }
    L[1] = A[1] * L[0];
    L[2] = A[2] * L[0];
    if (!invert_root(&L[3], A[3] - L[1] * L[1], rank_tol * diagonal[1])) {
        return 0;
    }
    L[4] = (A[4] - L[2] * L[1]) * L[3];
    return invert_root(&L[5], A[5] - L[2] * L[2] - L[4] * L[4], rank_tol * diagonal[2]);
}

/* The cofactors of C have the eigenvectors of C. Each eigenvalue is the product of the
 * other two of C, so the direction of least extent has the largest. A few squarings leave
 * only this direction. */
int rc_sym3_thinnest(rigcal_real normal[3], rigcal_real *thickness, const rigcal_real C[6])
{
    RIGCAL_ASSERT(C[0] >= 0 && C[3] >= 0 && C[5] >= 0);
    static const uint8_t FULL[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
    const rigcal_real by_trace = 1 / (C[0] + C[3] + C[5]);
    rigcal_real A[9], B[9];
    int at = 0;
    for (int k = 0; k < 9; k++) {
        A[k] = by_trace * C[FULL[k]];
    }
    const rigcal_real det = rc_mat3_cofactors(B, A);
    const rigcal_real trace = B[0] + B[4] + B[8];
    if (!(trace > LINE_THICKNESS)) {
        return 0;
    }
    for (int k = 0; k < 9; k++) {
        B[k] /= trace;
    }
    /* No underflow: the largest eigenvalue is 1/3 or more. */
    for (int i = 0; i < SQUARINGS; i += 2) {
        rc_mat3_mul(A, B, B);
        rc_mat3_mul(B, A, A);
    }
    for (int k = 4; k < 9; k += 4) {
        at = (B[k] > B[at]) ? k : at;
    }
    (void)rc_vec3_unit(normal, &B[at - at / 4]);
    *thickness = det / trace;
    return 1;
}

void rc_sym3_damp(rigcal_real damped[6], rigcal_real D[3], const rigcal_real A[6],
                  rigcal_real damping)
{
    RIGCAL_ASSERT(damping >= 0);
    static const uint8_t DIAGONAL[3] = {0, 3, 5};
    const rigcal_real least = D_LEAST * rc_max(A[0], rc_max(A[3], A[5]));
    for (int k = 0; k < 6; k++) {
        damped[k] = A[k];
    }
    for (int k = 0; k < 3; k++) {
        D[k] = rc_max(A[DIAGONAL[k]], least);
        damped[DIAGONAL[k]] += damping * D[k];
    }
}

/* ---- 6 x 6 --------------------------------------------------------------- */

int rc_sym6_factor_of(rc_sym6_factor *L, const rigcal_real H[21], rigcal_real damping)
{
    rigcal_real D[3];
    rc_sym3_damp(L->first, D, H, damping);
    if (!rc_sym3_factor(L->first, L->first, D, RANK_TOL)) {
        return 0;
    }
    rc_sym3_damp(L->second, D, &H[RC_SYM6_SECOND], damping);
    for (int column = 0; column < 3; column++) {
        const rigcal_real *const across = &H[RC_SYM6_ACROSS + column];
        rigcal_real x[3] = {across[0], across[3], across[6]};
        rc_sym3_forward(x, L->first);
        for (int k = 0; k < 3; k++) {
            L->across[k][column] = x[k];
        }
    }
    for (int k = 0; k < 3; k++) {
        rc_sym3_add_outer(L->second, -1, L->across[k]);
    }
    return rc_sym3_factor(L->second, L->second, D, RANK_TOL);
}

void rc_sym6_forward(rigcal_real x[6], const rc_sym6_factor *L)
{
    rc_sym3_forward(x, L->first);
    for (int k = 0; k < 3; k++) {
        rc_vec3_add_scaled(&x[3], -x[k], L->across[k]);
    }
    rc_sym3_forward(&x[3], L->second);
}

void rc_sym6_backward(rigcal_real x[6], const rc_sym6_factor *L)
{
    rc_sym3_backward(&x[3], L->second);
    for (int k = 0; k < 3; k++) {
        x[k] -= rc_vec3_dot(L->across[k], &x[3]);
    }
    rc_sym3_backward(x, L->first);
}

void rc_sym6_solve(rigcal_real x[6], const rc_sym6_factor *L)
{
    rc_sym6_forward(x, L);
    rc_sym6_backward(x, L);
}

/* The index of each element of H in a full matrix, and in its other triangle. */
static const uint8_t IN_FULL[21] = {0,  1,  2,  7,  8,  14, 3,  4,  5,  9, 10,
                                    11, 15, 16, 17, 21, 22, 23, 28, 29, 35};
static const uint8_t MIRRORED[21] = {0,  6,  12, 7,  13, 14, 18, 24, 30, 19, 25,
                                     31, 20, 26, 32, 21, 27, 33, 28, 34, 35};

void rc_sym6_unpack(rigcal_real full[36], const rigcal_real H[21])
{
    for (int k = 0; k < 21; k++) {
        full[IN_FULL[k]] = full[MIRRORED[k]] = H[k];
    }
}

void rc_sym6_pack(rigcal_real H[21], const rigcal_real full[36])
{
    for (int k = 0; k < 21; k++) {
        H[k] = full[IN_FULL[k]];
    }
}

void rc_sym6_mul(rigcal_real y[6], const rigcal_real H[21], const rigcal_real x[6])
{
    rigcal_real half[3];
    rc_sym3_mul_vec3(y, H, x);
    rc_mat3_mul_vec3(half, &H[RC_SYM6_ACROSS], &x[3]);
    rc_vec3_add(y, half);
    rc_mat3_tmul_vec3(&y[3], &H[RC_SYM6_ACROSS], x);
    rc_sym3_mul_vec3(half, &H[RC_SYM6_SECOND], &x[3]);
    rc_vec3_add(&y[3], half);
}

int rc_sym6_invert(rigcal_real Sigma[36], const rigcal_real H[21])
{
    rc_sym6_factor L;
    rigcal_real column[6];
    if (!rc_sym6_factor_of(&L, H, 0)) {
        return 0;
    }
    for (int j = 0; j < 6; j++) {
        for (int i = 0; i < 6; i++) {
            column[i] = (i == j) ? 1 : 0;
        }
        rc_sym6_solve(column, &L);
        for (int i = 0; i < 6; i++) {
            Sigma[6 * i + j] = column[i];
        }
    }
    return 1;
}

int rc_sym6_inverse_trace(rigcal_real *trace, const rigcal_real H[21])
{
    rc_sym6_factor L;
    if (!rc_sym6_factor_of(&L, H, 0)) {
        return 0;
    }
    *trace = 0;
    for (int j = 0; j < 3; j++) {
        rigcal_real column[6] = {0, 0, 0, 0, 0, 0};
        column[j] = 1;
        rc_sym6_solve(column, &L);
        *trace += column[j];
    }
    return 1;
}

/* ---- packed -------------------------------------------------------------- */

/* a.b of n elements */
static rigcal_real dot(const rigcal_real a[], const rigcal_real b[], size_t n)
{
    rigcal_real sum = 0;
    for (size_t k = 0; k < n; k++) {
        sum += a[k] * b[k];
    }
    return sum;
}

int rc_packed_factor_row(rigcal_real A[], size_t i, rigcal_real least)
{
    RIGCAL_ASSERT(!(least < 0));
    rigcal_real *const row = &A[rc_packed_at(i, 0)];
    for (size_t j = 0; j < i; j++) {
        const rigcal_real *const above = &A[rc_packed_at(j, 0)];
        row[j] = (row[j] - dot(row, above, j)) * above[j];
    }
    return invert_root(&row[i], row[i] - dot(row, row, i), least);
}

void rc_packed_forward(rigcal_real x[], const rigcal_real L[], size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const rigcal_real *const row = &L[rc_packed_at(i, 0)];
        x[i] = (x[i] - dot(row, x, i)) * row[i];
    }
}

void rc_packed_backward(rigcal_real x[], const rigcal_real L[], size_t n)
{
    for (size_t i = n; i-- > 0;) {
        const rigcal_real *const row = &L[rc_packed_at(i, 0)];
        x[i] *= row[i];
        for (size_t k = 0; k < i; k++) {
            x[k] -= row[k] * x[i];
        }
    }
}

/* Row i of L^-1: M_ij = -(sum over j <= k < i of L_ik M_kj) / L_ii. The sum for j uses only
 * elements of row i from j on, so those before it may be overwritten. */
void rc_packed_invert_row(rigcal_real L[], size_t i)
{
    rigcal_real *const row = &L[rc_packed_at(i, 0)];
    for (size_t j = 0; j < i; j++) {
        rigcal_real sum = 0;
        for (size_t k = j; k < i; k++) {
            sum += row[k] * L[rc_packed_at(k, j)];
        }
        row[j] = -sum * row[i];
    }
}

/* Row i of M^T M: sum over k >= max(i, j) of M_ki M_kj. For j <= i only rows from i on are
 * needed. */
void rc_packed_square_row(rigcal_real L_inverse[], size_t i, size_t n)
{
    RIGCAL_ASSERT(i < n);
    for (size_t j = 0; j <= i; j++) {
        rigcal_real sum = 0;
        for (size_t k = i; k < n; k++) {
            sum += L_inverse[rc_packed_at(k, i)] * L_inverse[rc_packed_at(k, j)];
        }
        L_inverse[rc_packed_at(i, j)] = sum;
    }
}

int rc_packed_invert(rigcal_real A[], size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const rigcal_real diagonal = A[rc_packed_at(i, i)];
        if (!(diagonal > 0) || !rc_packed_factor_row(A, i, RANK_TOL * diagonal)) {
            return 0;
        }
    }
    for (size_t i = 0; i < n; i++) {
        rc_packed_invert_row(A, i);
    }
    for (size_t i = 0; i < n; i++) {
        rc_packed_square_row(A, i, n);
    }
    return 1;
}

/* ---- the bodies of inline functions -------------------------------------- */

extern inline rigcal_real rc_max(rigcal_real a, rigcal_real b);
extern inline rigcal_real rc_min(rigcal_real a, rigcal_real b);
extern inline rigcal_real rc_vec3_dot(const rigcal_real a[3], const rigcal_real b[3]);
extern inline rigcal_real rc_vec6_dot(const rigcal_real a[6], const rigcal_real b[6]);
extern inline void rc_vec3_cross(rigcal_real out[3], const rigcal_real a[3],
                                 const rigcal_real b[3]);
extern inline void rc_vec3_copy(rigcal_real out[3], const rigcal_real a[3]);
extern inline void rc_vec3_sub(rigcal_real out[3], const rigcal_real a[3],
                               const rigcal_real b[3]);
extern inline void rc_vec3_add(rigcal_real out[3], const rigcal_real a[3]);
extern inline void rc_vec3_add_scaled(rigcal_real out[3], rigcal_real s,
                                      const rigcal_real a[3]);
extern inline void rc_vec3_scale(rigcal_real out[3], rigcal_real s, const rigcal_real a[3]);
extern inline void rc_vec3_combine(rigcal_real out[3], rigcal_real s,
                                   const rigcal_real a[3], rigcal_real t,
                                   const rigcal_real b[3]);
extern inline void rc_mat3_mul_vec3(rigcal_real out[3], const rigcal_real M[9],
                                    const rigcal_real v[3]);
extern inline void rc_sym3_forward(rigcal_real x[3], const rigcal_real L[6]);
extern inline void rc_sym3_backward(rigcal_real x[3], const rigcal_real L[6]);
extern inline size_t rc_packed_at(size_t i, size_t j);
extern inline size_t rc_packed_of(size_t i, size_t j);
