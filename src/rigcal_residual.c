#include "rc_residual.h"

extern inline rigcal_status rc_residual(rigcal_real e[2], rigcal_real B[6],
                                        const rigcal_camera *camera, int is_pinhole,
                                        const rigcal_real uv[2], const rigcal_real X_c[3]);

void rc_residual_along_ray(rigcal_real e[2], rigcal_real B[6], const rigcal_camera *camera,
                           int is_pinhole, const rigcal_real m[3], const rigcal_real X_c[3])
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

/* Adds the second derivative of uv, times -e. With c = B^T e a pinhole has
 * -(c k^T + k c^T) / Z, k = (0, 0, 1). A fisheye nearly has X_c / |X_c|^2 instead of k / Z,
 * and distortion bends little more. This goes into M, by dt. exp([w]x) q has
 * [w]x [w]x q / 2, which makes (c.q) 1 - (c q^T + q c^T) / 2 by w. */
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

/* Computes row i of M = B^T B, weighed. */
RIGCAL_FORCE_INLINE static inline void put_row(rigcal_real M[9], rigcal_real weight,
                                               const rigcal_real B[6], int i)
{
    rc_vec3_combine(&M[3 * i], weight * B[i], B, weight * B[3 + i], B + 3);
}

/* Adds row i of a point's part of H: from M by dt, from K = [q]x M across, and from
 * K [q]x^T by w. The last is q x the row of K. The row of [q]x M is a m + b n, with two
 * rows m and n of M. */
RIGCAL_FORCE_INLINE static inline void add_row(rigcal_real H[21], const rigcal_real q[3],
                                               const rigcal_real M[9], int i)
{
    static const uint8_t CYCLE[5] = {0, 1, 2, 0, 1};
    const int j = CYCLE[i + 1], k = CYCLE[i + 2], at = i * (7 - i) / 2;
    rigcal_real *const by_w = &H[at], *const by_dt = &H[RC_SYM6_SECOND + at];
    rigcal_real row[3], v[3];
    for (int c = i; c < 3; c++) {
        by_dt[c - i] += M[3 * i + c];
    }
    rc_vec3_combine(row, q[j], &M[3 * k], -q[k], &M[3 * j]);
    rc_vec3_add(&H[RC_SYM6_ACROSS + 3 * i], row);
    rc_vec3_cross(v, q, row);
    for (int c = i; c < 3; c++) {
        by_w[c - i] += v[c];
    }
}

/* With c = B^T e and M = B^T B the point adds (q x c, c) to g, and adds to H by rows. The
 * rows are written out for speed, because an adjustment spends its time here. */
RC_APART void rc_rigid_add(rigcal_real g[6], rigcal_real H[21], const rigcal_real B[6],
                           const rigcal_real q[3], const rigcal_real e[2],
                           rigcal_real weight, const rigcal_real X_c[3], int is_fisheye)
{
    RIGCAL_ASSERT(weight > 0);
    rigcal_real c[3], M[9], v[3];
    rc_vec3_combine(c, weight * e[0], B, weight * e[1], B + 3);
    if (RC_FOR_SPEED) {
        put_row(M, weight, B, 0);
        put_row(M, weight, B, 1);
        put_row(M, weight, B, 2);
    } else {
        for (int i = 0; i < 3; i++) {
            put_row(M, weight, B, i);
        }
    }
    if (X_c != NULL) {
        add_curvature(H, M, c, q, X_c, is_fisheye);
    }
    rc_vec3_cross(v, q, c);
    rc_vec3_add(&g[0], v);
    rc_vec3_add(&g[3], c);
    if (RC_FOR_SPEED) {
        add_row(H, q, M, 0);
        add_row(H, q, M, 1);
        add_row(H, q, M, 2);
    } else {
        for (int i = 0; i < 3; i++) {
            add_row(H, q, M, i);
        }
    }
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
