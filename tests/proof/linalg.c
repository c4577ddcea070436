/* For Frama-C's Eva: the functions of matrices access nothing outside of arrays that are as
 * large as rc_linalg.h says, whatever the numbers. SIZE is that of a packed matrix.
 * tests/proof/run.sh runs it. */
#include "rc_linalg.h"

#include "__fc_builtin.h"

#define UNKNOWN(array) Frama_C_make_unknown((char *)(array), sizeof(array))

static void three(void)
{
    static rigcal_real a[3], b[3], M[9], K[9], A[6], D[3];
    rigcal_real c[3], out[9], L[6], thickness;
    UNKNOWN(a);
    UNKNOWN(b);
    UNKNOWN(M);
    UNKNOWN(K);
    UNKNOWN(A);
    UNKNOWN(D);
    rc_vec3_cross(c, a, b);
    (void)rc_vec3_dot(a, b);
    rc_vec3_sub(c, a, b);
    rc_vec3_add(c, a);
    rc_vec3_add_scaled(c, a[0], b);
    rc_vec3_scale(c, a[0], b);
    rc_vec3_combine(c, a[0], a, a[1], b);
    rc_mat3_mul_vec3(c, M, a);
    (void)rc_vec3_norm(a);
    (void)rc_vec3_max_abs(a);
    (void)rc_vec3_unit(c, a);
    rc_vec3_complete(c, b, a);
    rc_mat3_tmul_vec3(c, M, a);
    rc_mat3_mul(out, M, K);
    rc_mat3_mul_t(out, M, K);
    (void)rc_mat3_cofactors(out, M);
    rc_sym3_mul_vec3(c, A, a);
    (void)rc_sym3_thinnest(c, &thickness, A);
    if (rc_sym3_factor(L, A, D, 0)) {
        rc_sym3_forward(a, L);
        rc_sym3_backward(a, L);
    }
    rc_sym3_add_outer(A, a[0], b);
    rc_sym3_damp(L, D, A, 0);
}

static void six(void)
{
    static rigcal_real H[21], x[6];
    rc_sym6_factor L;
    rigcal_real full[36], y[6], trace;
    UNKNOWN(H);
    UNKNOWN(x);
    (void)rc_all_finite(H, 21);
    (void)rc_check_numbers(H, 21, 1);
    if (rc_sym6_factor_of(&L, H, 0)) {
        rc_sym6_solve(x, &L);
    }
    rc_sym6_mul(y, H, x);
    (void)rc_sym6_invert(full, H);
    (void)rc_sym6_inverse_trace(&trace, H);
    rc_sym6_unpack(full, H);
    rc_sym6_pack(H, full);
}

/* The calls that compute a joint covariance. The arrays end where the matrix ends. */
static void packed(void)
{
    static rigcal_real A[SIZE * (SIZE + 1) / 2], x[SIZE];
    UNKNOWN(A);
    UNKNOWN(x);
    for (size_t i = 0; i < SIZE; i++) {
        (void)rc_packed_factor_row(A, i, 0);
    }
    rc_packed_forward(x, A, SIZE);
    rc_packed_backward(x, A, SIZE);
    for (size_t i = 0; i < SIZE; i++) {
        rc_packed_invert_row(A, i);
    }
    for (size_t i = 0; i < SIZE; i++) {
        rc_packed_square_row(A, i, SIZE);
    }
    rc_clear(x, SIZE);
}

int main(void)
{
    three();
    six();
    packed();
    return 0;
}
