#include "rc_chain.h"

/* ---- constants ----------------------------------------------------------- */

/* of 1 + cos(angle): below it the turn is so close to half a circle that the rest of its
 * sine does not show its axis. */
#define HALF_TURN RC_TOL(1e-12, 1e-6)

/* terms: the length of the series for the angle of a sine. It is exact to rounding for a
 * turn up to a right angle, and to one part in a million up to half a circle. */
enum { ARCSINE_TERMS = 14 };

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

static void transpose(rigcal_real M[36])
{
    for (int row = 1; row < 6; row++) {
        for (int column = 0; column < row; column++) {
            const rigcal_real kept = M[6 * row + column];
            M[6 * row + column] = M[6 * column + row];
            M[6 * column + row] = kept;
        }
    }
}

/* M <- M A: a row (x, y) becomes (x + a x y, y). */
static void times_A(rigcal_real M[36], const rc_chain *chain)
{
    for (int row = 0; row < 6; row++) {
        rigcal_real v[3];
        rc_vec3_cross(v, chain->lever, &M[6 * row + 3]);
        rc_vec3_add(&M[6 * row], v);
    }
}

/* M <- M B: a row (x, y) becomes (R^T x, R^T y). */
static void times_B(rigcal_real M[36], const rc_chain *chain)
{
    for (int half = 0; half < 12; half++) {
        rigcal_real v[3];
        rc_mat3_tmul_vec3(v, chain->R_c, &M[3 * half]);
        rc_vec3_copy(&M[3 * half], v);
    }
}

void rc_chain_add_placement(rigcal_real g_placement[6], rigcal_real H_placement[21],
                            const rc_chain *chain, const rigcal_real g[6],
                            const rigcal_real H[21])
{
    rigcal_real M[36], packed[21];
    for (int half = 0; half < 6; half += 3) {
        rigcal_real v[3];
        rc_mat3_tmul_vec3(v, chain->R_c, &g[half]);
        rc_vec3_add(&g_placement[half], v);
    }
    rc_sym6_unpack(M, H);
    times_B(M, chain);
    transpose(M);
    times_B(M, chain);
    rc_sym6_pack(packed, M);
    for (int k = 0; k < 21; k++) {
        H_placement[k] += packed[k];
    }
}

void rc_chain_camera(rigcal_real g[6], rigcal_real H[21], rigcal_real W[36],
                     const rc_chain *chain)
{
    rigcal_real M[36], v[3];
    rc_vec3_cross(v, chain->lever, &g[3]);
    rc_vec3_add(&g[0], v);
    rc_sym6_unpack(M, H);
    times_A(M, chain);
    transpose(M); /* A^T H */
    for (int k = 0; k < 36; k++) {
        W[k] = M[k];
    }
    times_A(M, chain);
    rc_sym6_pack(H, M);
    times_B(W, chain);
}

/* With x = sin(angle / 4) the angle is 4 asin(x), computed by its series. This needs
 * neither an arc tangent nor cases. */
void rc_deviation(rigcal_real d[6], const rigcal_transform *to,
                  const rigcal_transform *from)
{
    rigcal_real R[9];
    rc_mat3_mul_t(R, to->R, from->R);
    rc_vec3_sub(&d[3], to->t, from->t);
    const rigcal_real versine = (1 + R[0] + R[4] + R[8]) / 2; /* 1 + cos(angle) */
    if (versine < HALF_TURN) {
        d[0] = RC_PI; /* no small step undoes it, about any axis */
        d[1] = d[2] = 0;
        return;
    }
    const rigcal_real cos_half = RC_SQRT(versine / 2);
    const rigcal_real x_by_sine = 1 / (8 * cos_half * RC_SQRT((1 + cos_half) / 2));
    d[0] = x_by_sine * (R[7] - R[5]);
    d[1] = x_by_sine * (R[2] - R[6]);
    d[2] = x_by_sine * (R[3] - R[1]);
    const rigcal_real xx = rc_vec3_dot(d, d);
    rigcal_real term = 4, angle_by_x = 4;
    for (int k = 1; k <= ARCSINE_TERMS; k++) {
        const rigcal_real even = (rigcal_real)(2 * k);
        term *= xx * (even - 1) / even;
        angle_by_x += term / (even + 1);
    }
    rc_vec3_scale(d, angle_by_x, d);
}
