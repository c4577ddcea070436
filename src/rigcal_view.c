#include "rc_view.h"

/* ---- moments ------------------------------------------------------------- */

void rc_view_begin(rc_view *view)
{
    *view = (rc_view){0};
}

/* sums += s x x^T */
static void add_outer(rigcal_real sums[6], rigcal_real s, const rigcal_real x[3])
{
    const rigcal_real sx = s * x[0], sy = s * x[1];
    sums[0] += sx * x[0];
    sums[1] += sx * x[1];
    sums[2] += sx * x[2];
    sums[3] += sy * x[1];
    sums[4] += sy * x[2];
    sums[5] += s * x[2] * x[2];
}

void rc_view_add(rc_view *view, const rigcal_real x[3], const rigcal_real u[2])
{
    const rigcal_real uu = u[0] * u[0] + u[1] * u[1];
    view->n += 1;
    view->S += uu;
    view->trace_C += rc_vec3_dot(x, x);
    rc_vec3_add_scaled(view->h, uu, x);
    add_outer(view->Q, uu - 1, x);
    for (int part = 0; part < 2; part++) {
        view->u_mean[part] += u[part];
        rc_vec3_add_scaled(view->V_mean[part], u[part], x);
        add_outer(view->G[part], (part == 0) ? u[0] : -u[1], x);
    }
}

/* The sums were taken about zero; the means are taken out here. sum x = 0. */
int rc_view_finish(rc_view *view)
{
    const rigcal_real n = view->n;
    for (int part = 0; part < 2; part++) {
        view->u_mean[part] /= n;
        for (int k = 0; k < 3; k++) {
            view->V_mean[part][k] /= n;
        }
        view->S -= n * view->u_mean[part] * view->u_mean[part];
        rc_vec3_add_scaled(view->h, -n * view->u_mean[part], view->V_mean[part]);
        add_outer(view->Q, -n, view->V_mean[part]);
    }
    return view->S > 0;
}

/* ---- the cost of a direction --------------------------------------------- */

/* Rows m1, m2 that complete m3 to a rotation (Duff et al. 2017). Any pair will do:
 * what it turns by about m3 is taken up by yaw. */
static void complete_rotation(rigcal_real m1[3], rigcal_real m2[3],
                              const rigcal_real m3[3])
{
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

static inline void sym3_mul(rigcal_real out[3], const rigcal_real A[6],
                     const rigcal_real v[3])
{
    out[0] = A[0] * v[0] + A[1] * v[1] + A[2] * v[2];
    out[1] = A[1] * v[0] + A[3] * v[1] + A[4] * v[2];
    out[2] = A[2] * v[0] + A[4] * v[1] + A[5] * v[2];
}

/* What is left of the cost as a function of yaw, z = exp(i yaw):
 *   base - Re(a z) - Re(U^2 z^2) / (2 S),     depth (Re(U z) - B) / S > 0 */
typedef struct {
    rigcal_real base, a[2], U[2], B;
    rigcal_real m1[3], m2[3];
} harmonics;

static void harmonics_of(harmonics *f, const rc_view *view,
                         const rigcal_real m3[3])
{
    const rigcal_real n = view->n;
    rigcal_real w[3], yr[3], yi[3];

    complete_rotation(f->m1, f->m2, m3);
    f->B = rc_vec3_dot(view->h, m3);
    /* g = n conj(V_mean),  U = g.(m1 + i m2) */
    const rigcal_real *const vr = view->V_mean[0], *const vi = view->V_mean[1];
    f->U[0] = n * (rc_vec3_dot(vr, f->m1) + rc_vec3_dot(vi, f->m2));
    f->U[1] = n * (rc_vec3_dot(vr, f->m2) - rc_vec3_dot(vi, f->m1));
    /* y = G m3 - (B / S) g,  a = 2 y.(m1 + i m2) */
    const rigcal_real k = n * f->B / view->S;
    sym3_mul(yr, view->G[0], m3);
    sym3_mul(yi, view->G[1], m3);
    rc_vec3_add_scaled(yr, -k, vr);
    rc_vec3_add_scaled(yi, k, vi);
    f->a[0] = 2 * (rc_vec3_dot(yr, f->m1) - rc_vec3_dot(yi, f->m2));
    f->a[1] = 2 * (rc_vec3_dot(yr, f->m2) + rc_vec3_dot(yi, f->m1));

    const rigcal_real UU = f->U[0] * f->U[0] + f->U[1] * f->U[1];
    sym3_mul(w, view->Q, m3);
    f->base = view->trace_C + rc_vec3_dot(w, m3) -
              (UU / 2 + f->B * f->B) / view->S;
}

/* With psi = yaw + arg U the second harmonic is g cos 2 psi, g >= 0, and the
 * depth is positive for cos psi > B / |U|:
 *   gain(psi) = p cos psi + q sin psi + g cos 2 psi,   q >= 0 by reflection
 * so the maximum lies in psi = 0 .. pi. Coarse samples, then Newton's method on
 * the point (c, s) of the circle. Gives the gain, and z = exp(i yaw). */
static rigcal_real best_yaw(rigcal_real z[2], const harmonics *f,
                            const rc_view *view)
{
#if NSAMP==2
    static const rigcal_real SAMPLES[2][2] = {{RC(0.5), RC(0.866)},{RC(-.5), RC(0.866)}};
#elif NSAMP==1
    static const rigcal_real SAMPLES[1][2] = {{RC(0.0), RC(1)}};
#elif NSAMP==3
    static const rigcal_real SAMPLES[3][2] = {{RC(0.7071), RC(0.7071)},{RC(0), RC(1)},{RC(-.7071), RC(0.7071)}};
#else
    static const rigcal_real SAMPLES[5][2] = {{RC(0.98481), RC(0.17365)},
                                              {RC(0.76604), RC(0.64279)},
                                              {RC(0.34202), RC(0.93969)},
                                              {RC(-0.17365), RC(0.98481)},
                                              {RC(-0.76604), RC(0.64279)}};
#endif
    const rigcal_real U = RC_SQRT(f->U[0] * f->U[0] + f->U[1] * f->U[1]);
    if (!(U > f->B)) {
        return -RC_MAX;
    }
    const rigcal_real ur = f->U[0] / U, ui = f->U[1] / U;
    const rigcal_real p = f->a[0] * ur + f->a[1] * ui;
    const rigcal_real signed_q = f->a[0] * ui - f->a[1] * ur;
    const rigcal_real q = RC_FABS(signed_q);
    const rigcal_real g = U * U / (2 * view->S);
    const rigcal_real c_least = f->B / U;

    rigcal_real c = 1, s = 0, best = p + g;
    for (int i = 0; i < NSAMP && SAMPLES[i][0] > c_least; i++) {
        const rigcal_real ci = SAMPLES[i][0], si = SAMPLES[i][1];
        const rigcal_real gain = p * ci + q * si + g * (2 * ci * ci - 1);
        if (gain > best) {
            best = gain;
            c = ci;
            s = si;
        }
    }
    for (int i = 0; i < NEWTON_STEPS; i++) {
        const rigcal_real slope = q * c - p * s - 4 * g * s * c;
        const rigcal_real bend = p * c + q * s + 4 * g * (c * c - s * s);
        if (!(bend > 0)) {
            break;
        }
        rigcal_real step = slope / bend;
        step = rc_min(rc_max(step, RC(-0.5)), RC(0.5));
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
    return p * c + q * s + g * (2 * c * c - 1);
}

rigcal_real rc_view_cost(const rc_view *view, const rigcal_real m3[3])
{
    harmonics f;
    rigcal_real z[2];
    harmonics_of(&f, view, m3);
    const rigcal_real gain = best_yaw(z, &f, view);
    return (gain > -RC_MAX) ? f.base - gain : RC_MAX;
}

void rc_view_pose(rigcal_transform *virtual_from_points, const rc_view *view,
                  const rigcal_real m3[3])
{
    rigcal_transform *const T = virtual_from_points;
    harmonics f;
    rigcal_real z[2] = {1, 0};
    harmonics_of(&f, view, m3);
    (void)best_yaw(z, &f, view);
    for (int k = 0; k < 3; k++) {
        T->R[k] = z[0] * f.m1[k] - z[1] * f.m2[k];
        T->R[3 + k] = z[1] * f.m1[k] + z[0] * f.m2[k];
        T->R[6 + k] = m3[k];
    }
    const rigcal_real depth =
        (f.U[0] * z[0] - f.U[1] * z[1] - f.B) / view->S;
    for (int part = 0; part < 2; part++) {
        T->t[part] = rc_vec3_dot(view->V_mean[part], m3) +
                     depth * view->u_mean[part];
    }
    T->t[2] = depth;
}
