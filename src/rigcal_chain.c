#include "rc_chain.h"

/* Where the elements of a symmetric block stand in a full one. */
static const uint8_t FULL[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
static const uint8_t PACKED[6] = {0, 1, 2, 4, 5, 8};

void rc_chain_of(rc_chain *chain, const rigcal_transform *cam_from_rig,
                 const rigcal_transform *rig_from_placement)
{
    rigcal_transform *const T = &chain->cam_from_target;
    chain->R_c = cam_from_rig->R;
    rc_mat3_mul(T->R, cam_from_rig->R, rig_from_placement->R);
    rc_mat3_mul_vec3(chain->lever, cam_from_rig->R, rig_from_placement->t);
    rc_vec3_copy(T->t, chain->lever);
    rc_vec3_add(T->t, cam_from_rig->t);
}

/* out = M R, row by row */
static void turn_columns(rigcal_real out[9], const rigcal_real M[9], const rigcal_real R[9])
{
    for (int row = 0; row < 3; row++) {
        rc_mat3_tmul_vec3(&out[3 * row], R, &M[3 * row]);
    }
}

/* out = R^T M R */
static void turn_both(rigcal_real out[9], const rigcal_real M[9], const rigcal_real R[9])
{
    rigcal_real MR[9];
    turn_columns(MR, M, R);
    for (int column = 0; column < 3; column++) {
        const rigcal_real x[3] = {MR[column], MR[3 + column], MR[6 + column]};
        rigcal_real y[3];
        rc_mat3_tmul_vec3(y, R, x);
        for (int row = 0; row < 3; row++) {
            out[3 * row + column] = y[row];
        }
    }
}

/* M += [a]x N, three columns each */
static void add_cross(rigcal_real M[9], const rigcal_real a[3], const rigcal_real N[9])
{
    for (int column = 0; column < 3; column++) {
        const rigcal_real x[3] = {N[column], N[3 + column], N[6 + column]};
        rigcal_real y[3];
        rc_vec3_cross(y, a, x);
        for (int row = 0; row < 3; row++) {
            M[3 * row + column] += y[row];
        }
    }
}

static void unpack(rigcal_real out[9], const rigcal_real packed[6])
{
    for (int k = 0; k < 9; k++) {
        out[k] = packed[FULL[k]];
    }
}

void rc_chain_add_placement(rigcal_real g_placement[6], rigcal_real H_placement[21],
                            const rc_chain *chain, const rigcal_real g[6],
                            const rigcal_real H[21])
{
    const rigcal_real *const R = chain->R_c;
    rigcal_real block[9], turned[9], v[3];
    for (int half = 0; half < 2; half++) {
        rigcal_real *const sum = &H_placement[half * RC_SYM6_SECOND];
        rc_mat3_tmul_vec3(v, R, &g[3 * half]);
        rc_vec3_add(&g_placement[3 * half], v);
        unpack(block, &H[half * RC_SYM6_SECOND]);
        turn_both(turned, block, R);
        for (int k = 0; k < 6; k++) {
            sum[k] += turned[PACKED[k]];
        }
    }
    turn_both(turned, &H[RC_SYM6_ACROSS], R);
    for (int k = 0; k < 9; k++) {
        H_placement[RC_SYM6_ACROSS + k] += turned[k];
    }
}

/* With E = [a]x, the rows by w of A^T H are those of H plus E times its rows by dt. */
void rc_chain_camera(rigcal_real g[6], rigcal_real H[21], rigcal_real W[36],
                     const rc_chain *chain)
{
    const rigcal_real *const a = chain->lever;
    rigcal_real *const across = &H[RC_SYM6_ACROSS];
    rigcal_real by_w[9], by_dt[9], across_t[9], turned[9], v[3];
    rc_vec3_cross(v, a, &g[3]);
    rc_vec3_add(&g[0], v);
    unpack(by_w, &H[0]);
    unpack(by_dt, &H[RC_SYM6_SECOND]);
    for (int k = 0; k < 9; k++) {
        across_t[k] = across[3 * (k % 3) + k / 3];
    }
    add_cross(by_w, a, across_t); /* A^T H, its rows by w */
    add_cross(across, a, by_dt);
    const rigcal_real *const quarters[4] = {by_w, across, across_t, by_dt};
    for (int q = 0; q < 4; q++) { /* W = A^T H B */
        turn_columns(turned, quarters[q], chain->R_c);
        for (int k = 0; k < 9; k++) {
            W[18 * (q / 2) + 6 * (k / 3) + 3 * (q % 2) + k % 3] = turned[k];
        }
    }
    for (int row = 0; row < 3; row++) { /* A^T H A: its columns by w, as the rows before */
        rc_vec3_cross(v, a, &across[3 * row]);
        rc_vec3_add(&by_w[3 * row], v);
    }
    for (int k = 0; k < 6; k++) {
        H[k] = by_w[PACKED[k]];
    }
}

void rc_deviation(rigcal_real d[6], const rigcal_transform *to,
                  const rigcal_transform *from)
{
    rigcal_real R[9];
    rc_mat3_mul_t(R, to->R, from->R);
    rc_vector_from_rotation(d, R);
    rc_vec3_sub(&d[3], to->t, from->t);
}
