#include "rc_residual.h"

extern inline rigcal_status rc_residual(rigcal_real e[2], rigcal_real B[6],
                                        const rigcal_camera *camera, int is_pinhole,
                                        const rigcal_real uv[2], const rigcal_real X_c[3]);

void rc_residual_along_ray(rigcal_real e[2], rigcal_real B[6], const rigcal_camera *camera,
                           int is_pinhole, const rigcal_real m[3],
                           const rigcal_real X_c[3])
{
    (void)rc_project_through(e, B, camera, is_pinhole, m);
    e[0] = -rc_vec3_dot(&B[0], X_c);
    e[1] = -rc_vec3_dot(&B[3], X_c);
}

/* ---- by a rigid transform ------------------------------------------------- */

void rc_rigid_clear(rigcal_real g[6], rigcal_real H[21])
{
    for (int k = 0; k < 6; k++) {
        g[k] = 0;
    }
    for (int k = 0; k < 21; k++) {
        H[k] = 0;
    }
}

/* The second derivative of uv, times -e. With c = B^T e, that of a pinhole is
 * -(c k^T + k c^T) / Z, k = (0, 0, 1). That of a fisheye nearly has X_c / |X_c|^2 in the
 * place of k / Z, and distortion bends little more: it goes into M, by dt. That of
 * exp([w]x) q, which is [w]x [w]x q / 2, makes (c.q) 1 - (c q^T + q c^T) / 2 by w. */
static void add_curvature(rigcal_real H[21], rigcal_real M[9], const rigcal_real c[3],
                          const rigcal_real q[3], const rigcal_real X_c[3], int is_fisheye)
{
    const rigcal_real along = rc_vec3_dot(c, q);
    rigcal_real k[3] = {0, 0, 1 / X_c[2]}, row[3];
    if (RIGCAL_WITH_FISHEYE && is_fisheye) {
        rc_vec3_scale(k, 1 / rc_vec3_dot(X_c, X_c), X_c);
    }
    for (int i = 0, at = 0; i < 3; at += 3 - i, i++) {
        rc_vec3_combine(row, c[i], k, k[i], c);
        rc_vec3_add(&M[3 * i], row);
        rc_vec3_combine(row, c[i], q, q[i], c);
        H[at] += along;
        for (int j = i; j < 3; j++) {
            H[at + j - i] -= row[j] / 2;
        }
    }
}

/* K row by row: the row of [q]x M is a m + b n, m and n two rows of M; across += it, and
 * out = q x it. */
static inline void add_row(rigcal_real out[3], rigcal_real across[3],
                           const rigcal_real q[3], rigcal_real a, const rigcal_real m[3],
                           rigcal_real b, const rigcal_real n[3])
{
    rigcal_real row[3];
    rc_vec3_combine(row, a, m, b, n);
    rc_vec3_add(across, row);
    rc_vec3_cross(out, q, row);
}

/* With c = B^T e and M = B^T B the point adds (q x c, c) to g, and to H: M by dt,
 * K = [q]x M across, and K [q]x^T by w, the rows of which are q x those of K. Written out,
 * for this is where the time of a refinement goes. */
RC_APART void rc_rigid_add(rigcal_real g[6], rigcal_real H[21], const rigcal_real B[6],
                           const rigcal_real q[3], const rigcal_real e[2],
                           rigcal_real weight, const rigcal_real X_c[3], int is_fisheye)
{
    RIGCAL_ASSERT(weight > 0);
    const rigcal_real *const bu = B, *const bv = B + 3;
    rigcal_real *const across = &H[RC_SYM6_ACROSS], *const by_dt = &H[RC_SYM6_SECOND];
    rigcal_real c[3], M[9], v[3];
    rc_vec3_combine(c, weight * e[0], bu, weight * e[1], bv);
    rc_vec3_combine(&M[0], weight * bu[0], bu, weight * bv[0], bv);
    rc_vec3_combine(&M[3], weight * bu[1], bu, weight * bv[1], bv);
    rc_vec3_combine(&M[6], weight * bu[2], bu, weight * bv[2], bv);
    if (X_c != NULL) {
        add_curvature(H, M, c, q, X_c, is_fisheye);
    }
    rc_vec3_cross(v, q, c);
    rc_vec3_add(&g[0], v);
    rc_vec3_add(&g[3], c);
    rc_vec3_add(by_dt, M);
    by_dt[3] += M[4];
    by_dt[4] += M[5];
    by_dt[5] += M[8];
    add_row(v, &across[0], q, q[1], &M[6], -q[2], &M[3]);
    rc_vec3_add(H, v);
    add_row(v, &across[3], q, q[2], &M[0], -q[0], &M[6]);
    H[3] += v[1];
    H[4] += v[2];
    add_row(v, &across[6], q, q[0], &M[3], -q[1], &M[0]);
    H[5] += v[2];
}

/* ---- by a point ----------------------------------------------------------- */

void rc_point_add(rigcal_real g[3], rigcal_real H[6], const rigcal_real B[6],
                  const rigcal_real R_ca[9], const rigcal_real e[2])
{
    for (int row = 0; row < 2; row++) {
        rigcal_real J[3];
        rc_mat3_tmul_vec3(J, R_ca, &B[3 * row]);
        rc_vec3_add_scaled(g, e[row], J);
        rc_sym3_add_outer(H, 1, J);
    }
}
