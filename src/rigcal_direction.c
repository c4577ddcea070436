#include "rc_direction.h"

/* ---- constants ----------------------------------------------------------- */

/* 1, a tangent: longest Newton step to the best yaw. A longer one may leave its basin. */
#define STEP_MOST RC(0.5)

/* 1, a tangent: a smaller step is the last. The error of the cost is the square of that
 * step. */
#define STEP_SMALL RC(1e-3)

/* steps: the most to the best yaw, usually 2 or 3. */
enum { NEWTON_STEPS_MAX = 6 };

/* part of the squared distance from the middle: an image with a smaller squared extent
 * counts as one point. */
#define EXTENT_LEAST (64 * RC_EPS)

/* ---- moments ------------------------------------------------------------- */

void rc_moments_begin(rigcal_moments *sums)
{
    *sums = (rigcal_moments){0};
}

/* Adds x x^T to the four sums that contain it, with their factors. The products are
 * computed once. */
static inline void add_outers(rigcal_moments *sums, rigcal_real k, rigcal_real weight,
                              const rigcal_real wu[2], const rigcal_real x[3])
{
    const rigcal_real xx[6] = {x[0] * x[0], x[0] * x[1], x[0] * x[2],
                               x[1] * x[1], x[1] * x[2], x[2] * x[2]};
    for (int i = 0; i < 6; i++) {
        sums->K_less_C[i] += k * xx[i];
        sums->C[i] += weight * xx[i];
        sums->G[0][i] += wu[0] * xx[i];
        sums->G[1][i] += wu[1] * xx[i];
    }
}

void rc_moments_add(rigcal_moments *sums, rigcal_real weight, const rigcal_real x[3],
                    const rigcal_real u[2])
{
    RIGCAL_ASSERT(weight > 0);
    const rigcal_real uu = weight * (u[0] * u[0] + u[1] * u[1]);
    const rigcal_real wu[2] = {weight * u[0], weight * u[1]};
    sums->weight += weight;
    sums->S += uu;
    rc_vec3_add_scaled(sums->h, uu, x);
    if (RC_FOR_SPEED) {
        add_outers(sums, uu - weight, weight, wu, x);
    } else {
        rc_sym3_add_outer(sums->K_less_C, uu - weight, x);
        rc_sym3_add_outer(sums->C, weight, x);
        rc_sym3_add_outer(sums->G[0], wu[0], x);
        rc_sym3_add_outer(sums->G[1], wu[1], x);
    }
    for (int part = 0; part < 2; part++) {
        sums->u_mean[part] += wu[part];
        rc_vec3_add_scaled(sums->V_mean[part], wu[part], x);
    }
}

/* The sums were taken about zero; this subtracts the means. sum x = 0. */
int rc_moments_finish(rigcal_moments *sums)
{
    RIGCAL_ASSERT(sums->weight > 0);
    const rigcal_real w = sums->weight, about_zero = sums->S;
    for (int part = 0; part < 2; part++) {
        sums->u_mean[part] /= w;
        rc_vec3_scale(sums->V_mean[part], 1 / w, sums->V_mean[part]);
        sums->S -= w * sums->u_mean[part] * sums->u_mean[part];
        rc_vec3_add_scaled(sums->h, -w * sums->u_mean[part], sums->V_mean[part]);
        rc_sym3_add_outer(sums->K_less_C, -w, sums->V_mean[part]);
    }
    return sums->S > EXTENT_LEAST * about_zero && sums->S > EXTENT_LEAST * RC_EPS * w;
}

/* ---- the cost of a direction --------------------------------------------- */

/* The cost as a function of yaw, with z = exp(i yaw):
 *   base - Re(a z) - Re(U^2 z^2) / (2 S),     depth (Re(U z) - B) / S > 0 */
typedef struct {
    rigcal_real base, a[2], U[2], B;
    rigcal_real m1[3], m2[3];
} harmonics;

/* (r - i s) . (m1 + i m2), times scale. */
static void project(rigcal_real out[2], const harmonics *f, rigcal_real scale,
                    const rigcal_real r[3], const rigcal_real s[3])
{
    out[0] = scale * (rc_vec3_dot(r, f->m1) + rc_vec3_dot(s, f->m2));
    out[1] = scale * (rc_vec3_dot(r, f->m2) - rc_vec3_dot(s, f->m1));
}

static void harmonics_of(harmonics *f, const rigcal_moments *sums, const rigcal_real m3[3])
{
    const rigcal_real n = sums->weight;
    rigcal_real KCm[3], yr[3], yi[3];

    rc_vec3_complete(f->m1, f->m2, m3);
    f->B = rc_vec3_dot(sums->h, m3);
    /* g = n conj(V_mean),  U = g.(m1 + i m2) */
    const rigcal_real *const vr = sums->V_mean[0], *const vi = sums->V_mean[1];
    project(f->U, f, n, vr, vi);
    /* y = conj(G) m3 - (B / S) g,  a = 2 y.(m1 + i m2) */
    const rigcal_real k = -n * f->B / sums->S;
    rc_sym3_mul_vec3(yr, sums->G[0], m3);
    rc_sym3_mul_vec3(yi, sums->G[1], m3);
    rc_vec3_add_scaled(yr, k, vr);
    rc_vec3_add_scaled(yi, k, vi);
    project(f->a, f, 2, yr, yi);

    const rigcal_real UU = f->U[0] * f->U[0] + f->U[1] * f->U[1];
    rc_sym3_mul_vec3(KCm, sums->K_less_C, m3);
    f->base = (sums->C[0] + sums->C[3] + sums->C[5]) + rc_vec3_dot(KCm, m3) -
              (UU / 2 + f->B * f->B) / sums->S;
}

/* With psi = yaw + arg U the second harmonic is u2 cos 2 psi, u2 = |U|^2 / (2 S). The depth
 * is positive for cos psi > B / |U|.
 *
 *   gain(psi) = p cos psi + q sin psi + u2 cos 2 psi,   q >= 0 by reflection
 *
 * So the maximum lies in 0 <= psi <= pi. At the truth psi is small, because U e^(i yaw) =
 * sum conj(du) q_xy and du is nearly q_xy over the depth. So Newton's method on the point
 * (c, s) of the circle starts at 0, or at a right angle if that is better. Writes the
 * harmonics of m3 and z = exp(i yaw). Returns the gain, or -RC_MAX if no yaw has a positive
 * depth. */
static rigcal_real best_yaw(rigcal_real z[2], harmonics *f, const rigcal_moments *sums,
                            const rigcal_real m3[3])
{
    harmonics_of(f, sums, m3);
    const rigcal_real U = RC_SQRT(f->U[0] * f->U[0] + f->U[1] * f->U[1]);
    if (!(U > f->B) || !(U > 0)) {
        return -RC_MAX;
    }
    const rigcal_real by_U = 1 / U;
    const rigcal_real ur = f->U[0] * by_U, ui = f->U[1] * by_U;
    const rigcal_real p = f->a[0] * ur + f->a[1] * ui;
    const rigcal_real signed_q = f->a[0] * ui - f->a[1] * ur;
    const rigcal_real q = RC_FABS(signed_q);
    const rigcal_real u2 = U * U / (2 * sums->S);
    const rigcal_real c_least = f->B * by_U;

    const int from_right_angle = c_least < 0 && q - u2 > p + u2;
    rigcal_real c = from_right_angle ? 0 : 1, s = from_right_angle ? 1 : 0;
    rigcal_real step = 1;
    for (int i = 0; i < NEWTON_STEPS_MAX && RC_FABS(step) > STEP_SMALL; i++) {
        const rigcal_real slope = q * c - p * s - 4 * u2 * s * c;
        const rigcal_real curvature = p * c + q * s + 4 * u2 * (c * c - s * s);
        if (!(curvature > 0)) {
            break;
        }
        step = rc_min(rc_max(slope / curvature, -STEP_MOST), STEP_MOST);
        const rigcal_real by = 1 / RC_SQRT(1 + step * step);
        const rigcal_real c_next = (c - s * step) * by;
        s = (s + c * step) * by;
        c = c_next;
    }
    if (c < c_least) {
        c = c_least;
        s = RC_SQRT(rc_max(0, 1 - c * c));
    }
    const rigcal_real s_signed = (signed_q < 0) ? -s : s;
    z[0] = c * ur + s_signed * ui;
    z[1] = s_signed * ur - c * ui;
    return p * c + q * s + u2 * (2 * c * c - 1);
}

void rc_moments_mirror(rigcal_moments *sums)
{
    for (int k = 0; k < 3; k++) {
        sums->h[k] = -sums->h[k];
        sums->V_mean[0][k] = -sums->V_mean[0][k];
        sums->V_mean[1][k] = -sums->V_mean[1][k];
    }
}

rigcal_real rc_direction_cost(const rigcal_moments *sums, const rigcal_real m3[3])
{
    RIGCAL_ASSERT(RC_IS_UNIT(m3));
    harmonics f;
    rigcal_real z[2];
    const rigcal_real gain = best_yaw(z, &f, sums, m3);
    return (gain > -RC_MAX) ? f.base - gain : RC_MAX;
}

void rc_direction_pose(rigcal_transform *virtual_from_points, const rigcal_moments *sums,
                       const rigcal_real m3[3])
{
    RIGCAL_ASSERT(RC_IS_UNIT(m3));
    rigcal_transform *const T = virtual_from_points;
    harmonics f;
    rigcal_real z[2] = {1, 0};
    (void)best_yaw(z, &f, sums, m3);
    rc_vec3_combine(&T->R[0], z[0], f.m1, -z[1], f.m2);
    rc_vec3_combine(&T->R[3], z[1], f.m1, z[0], f.m2);
    rc_vec3_copy(&T->R[6], m3);
    const rigcal_real depth = (f.U[0] * z[0] - f.U[1] * z[1] - f.B) / sums->S;
    for (int part = 0; part < 2; part++) {
        T->t[part] = rc_vec3_dot(sums->V_mean[part], m3) + depth * sums->u_mean[part];
    }
    T->t[2] = depth;
}
