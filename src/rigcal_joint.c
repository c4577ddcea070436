#include "rc_joint.h"

/* ---- 6 x 6 --------------------------------------------------------------- */

void rc_mat6_add_product(rigcal_real out[36], const rigcal_real A[36],
                         const rigcal_real B[36], int is_transposed)
{
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < 6; k++) {
            const rigcal_real a = is_transposed ? A[6 * k + i] : A[6 * i + k];
            for (int j = 0; j < 6; j++) {
                out[6 * i + j] += a * B[6 * k + j];
            }
        }
    }
}

void rc_mat6_make_symmetric(rigcal_real M[36], rigcal_real scale)
{
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j <= i; j++) {
            M[6 * j + i] = M[6 * i + j] = scale * M[6 * i + j];
        }
    }
}

/* ---- cameras, and what hangs on them ------------------------------------- */

void rc_joint_block(rigcal_real out[36], const rigcal_real S[], rigcal_real a,
                    rigcal_real b)
{
    rc_clear(out, 36);
    if (!(a >= 0 && b >= 0)) {
        return;
    }
    for (size_t i = 0; i < 6; i++) {
        for (size_t j = 0; j < 6; j++) {
            const size_t row = (size_t)a + i, column = (size_t)b + j;
            out[6 * i + j] = S[rc_packed_of(row, column)];
        }
    }
}

void rc_joint_across(rigcal_real Z[36], const rc_leverage *on, size_t i)
{
    rc_clear(Z, 36);
    for (size_t j = 0; j < on->count; j++) {
        rigcal_real Sigma_ij[36];
        rc_joint_block(Sigma_ij, on->S, on->at[i], on->at[j]);
        rc_mat6_add_product(Z, Sigma_ij, &on->W[36 * j], 0);
    }
}

void rc_joint_spread(rigcal_real Sigma[36], const rc_leverage *on)
{
    rc_clear(Sigma, 36);
    for (size_t i = 0; i < on->count; i++) {
        rigcal_real Z[36];
        if (on->at[i] >= 0) {
            rc_joint_across(Z, on, i);
            rc_mat6_add_product(Sigma, &on->W[36 * i], Z, 1);
        }
    }
}

/* ---- a pair -------------------------------------------------------------- */

/* W = (M 0; [x]x M  M)^T: what a step of a camera does to b_from_a. M is a rotation or the
 * negative of one. */
static void fill_step(rigcal_real W[36], const rigcal_real x[3], const rigcal_real M[9])
{
    rc_clear(W, 36);
    for (int column = 0; column < 3; column++) {
        const rigcal_real m[3] = {M[column], M[3 + column], M[6 + column]};
        rc_vec3_copy(&W[6 * column], m);
        rc_vec3_cross(&W[6 * column + 3], x, m);
        rc_vec3_copy(&W[6 * column + 21], m);
    }
}

void rc_joint_steps_of_pair(rigcal_real W[72], const rigcal_transform *b_from_a,
                            const rigcal_transform *a_from_rig)
{
    static const rigcal_real ONE[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    rigcal_real x[3], minus_R[9];
    rc_mat3_mul_vec3(x, b_from_a->R, a_from_rig->t);
    for (int k = 0; k < 9; k++) {
        minus_R[k] = -b_from_a->R[k];
    }
    fill_step(&W[0], x, minus_R);
    fill_step(&W[36], x, ONE);
}

void rc_joint_pair(rigcal_transform *b_from_a, rigcal_real Sigma[36],
                   const rigcal_transform *a_from_rig, const rigcal_transform *b_from_rig,
                   const rigcal_real S[], rigcal_real a, rigcal_real b, rigcal_real scale)
{
    rigcal_real W[72], at[2] = {a, b};
    const rc_leverage on = {S, W, at, 2};
    rc_transform_between(b_from_a, b_from_rig, a_from_rig);
    rc_joint_steps_of_pair(W, b_from_a, a_from_rig);
    rc_joint_spread(Sigma, &on);
    rc_mat6_make_symmetric(Sigma, scale);
}
