#include "rc_refine.h"

/* Damping to start with, where it hardly matters, and where it is hopeless. */
#define DAMPING_FIRST RC(1e-5)
#define DAMPING_NEAR RC(1e-2)
#define DAMPING_LAST RC(1e8)

/* Damping of a Newton's H that is not positive definite: the first, and the last. */
#define DAMPING_BEND RC(1e-4)
#define DAMPING_NEWTON RC(10)

/* Rise of the sum that may be rounding. */
#define SUM_ROUNDING (16 * RC_EPS)

/* What may be left to gain when a refinement ends, as a part of the sum, judged by
 * how fast the gains fall; and a gain that is small enough by itself. */
#define LEFT_LEAST RC_TOL(1e-12, 1e-6)
#define GAIN_LEAST RC_TOL(1e-13, 1e-6)

/* GAIN_LEAST in px^2, for images without noise. */
#define GAIN_NOTHING RC_TOL(1e-20, 1e-7)

/* A step refused although it promised no more than this part has met rounding. */
#define GAIN_ROUNDING RC_TOL(1e-7, 1e-4)

/* The most that one step turns [rad]: a larger one would leave the basin. */
#define TURN_MOST RC(0.3)

/* Gains that fall no faster than this are those of a valley: Newton's H from there. */
#define SLOW RC(0.1)

/* Least element of the damping matrix, as a part of the largest of its block. */
#define D_LEAST RC(1e-2)

/* Pivots are compared with this part of their diagonal. */
#define RANK_TOL (8 * RC_EPS)

void rc_fit_begin(rc_fit *fit, const rigcal_camera *camera,
                  const rigcal_observation observations[],
                  const rigcal_real sigma[], const uint8_t mask[], size_t n,
                  const rigcal_real origin[3])
{
    fit->camera = camera;
    fit->observations = observations;
    fit->sigma = sigma;
    fit->mask = mask;
    fit->n = n;
    fit->origin = origin;
    fit->is_mirrored = 0;
    rc_lens_of(&fit->lens, camera);
}

/* ---- normal equations ---------------------------------------------------- */

/* What Newton's H has beyond that of Gauss and Newton: the curvature of uv, times -e.
 * That of a pinhole is -(c k^T + k c^T) / Z, k = (0, 0, 1), and a lens bends little
 * more: it goes into M. That of exp([w]x) q, [w]x [w]x q / 2, makes
 * (c.q) 1 - (c q^T + q c^T) / 2 by w. */
static void add_curvature(rigcal_real H[21], rigcal_real M[6],
                          const rigcal_real c[3], const rigcal_real q[3],
                          rigcal_real Z)
{
    const rigcal_real along = rc_vec3_dot(c, q);
    M[2] += c[0] / Z;
    M[4] += c[1] / Z;
    M[5] += 2 * c[2] / Z;
    H[0] += along - c[0] * q[0];
    H[1] -= (c[0] * q[1] + c[1] * q[0]) / 2;
    H[2] += along - c[1] * q[1];
    H[3] -= (c[0] * q[2] + c[2] * q[0]) / 2;
    H[4] -= (c[1] * q[2] + c[2] * q[1]) / 2;
    H[5] += along - c[2] * q[2];
}

/* c = w B^T e, M = w B^T B */
static inline void square(rigcal_real c[3], rigcal_real M[6],
                          const rigcal_real B[6], rigcal_real du, rigcal_real dv,
                          rigcal_real weight)
{
    const rigcal_real *const bu = B, *const bv = B + 3;
    const rigcal_real wu[3] = {weight * bu[0], weight * bu[1], weight * bu[2]};
    const rigcal_real wv[3] = {weight * bv[0], weight * bv[1], weight * bv[2]};
    for (int k = 0; k < 3; k++) {
        c[k] = wu[k] * du + wv[k] * dv;
    }
    M[0] = wu[0] * bu[0] + wv[0] * bv[0];
    M[1] = wu[0] * bu[1] + wv[0] * bv[1];
    M[2] = wu[0] * bu[2] + wv[0] * bv[2];
    M[3] = wu[1] * bu[1] + wv[1] * bv[1];
    M[4] = wu[1] * bu[2] + wv[1] * bv[2];
    M[5] = wu[2] * bu[2] + wv[2] * bv[2];
}

/* One point. With q = R x and dX_c = w x q + dt, its rows of J are B [-[q]x, 1],
 * B = d uv / dX_c. So with c = B^T e and M = B^T B (xx, xy, xz, yy, yz, zz) it adds
 * (q x c, c) to g, and to H the blocks M by dt, K = [q]x M across, and [q]x M [q]x^T
 * by w. Written out, for this is where the time of a refinement goes. Z > 0: with the
 * curvature. */
RC_APART static void add_point(rigcal_real g[6], rigcal_real H[21],
                               const rigcal_real B[6], const rigcal_real q[3],
                               const rigcal_real e[2], rigcal_real weight,
                               rigcal_real Z)
{
    rigcal_real c[3], M[6];
    square(c, M, B, e[0], e[1], weight);
    if (Z > 0) {
        add_curvature(H, M, c, q, Z);
    }
    const rigcal_real x = q[0], y = q[1], z = q[2];
    g[0] += y * c[2] - z * c[1];
    g[1] += z * c[0] - x * c[2];
    g[2] += x * c[1] - y * c[0];
    g[3] += c[0];
    g[4] += c[1];
    g[5] += c[2];
    H[9] += M[0];
    H[13] += M[1];
    H[14] += M[3];
    H[18] += M[2];
    H[19] += M[4];
    H[20] += M[5];

    const rigcal_real Kx[3] = {y * M[2] - z * M[1], y * M[4] - z * M[3],
                               y * M[5] - z * M[4]};
    H[6] += Kx[0];
    H[10] += Kx[1];
    H[15] += Kx[2];
    H[0] += y * Kx[2] - z * Kx[1];
    const rigcal_real Ky[3] = {z * M[0] - x * M[2], z * M[1] - x * M[4],
                               z * M[2] - x * M[5]};
    H[7] += Ky[0];
    H[11] += Ky[1];
    H[16] += Ky[2];
    H[1] += y * Ky[2] - z * Ky[1];
    H[2] += z * Ky[0] - x * Ky[2];
    const rigcal_real Kz[3] = {x * M[1] - y * M[0], x * M[3] - y * M[1],
                               x * M[4] - y * M[2]};
    H[8] += Kz[0];
    H[12] += Kz[1];
    H[17] += Kz[2];
    H[3] += y * Kz[2] - z * Kz[1];
    H[4] += z * Kz[0] - x * Kz[2];
    H[5] += x * Kz[1] - y * Kz[0];
}

static rigcal_status equations(rigcal_real *sse, rigcal_real g[6],
                               rigcal_real H[21], const rc_fit *fit,
                               const rigcal_transform *cam_from_points,
                               int with_curvature)
{
    rigcal_real sum = 0;
    for (int k = 0; k < 21; k++) {
        H[k] = 0;
        g[k % 6] = 0;
    }
    for (size_t i = 0; i < fit->n; i++) {
        const rigcal_observation *const o = &fit->observations[i];
        if (fit->mask != NULL && !fit->mask[i]) {
            continue;
        }
        rigcal_real x[3], q[3], X_c[3], uv[2], B[6];
        if (fit->is_mirrored) {
            rc_vec3_sub(x, fit->origin, o->X_w);
        } else {
            rc_vec3_sub(x, o->X_w, fit->origin);
        }
        rc_mat3_mul_vec3(q, cam_from_points->R, x);
        for (int k = 0; k < 3; k++) {
            X_c[k] = q[k] + cam_from_points->t[k];
        }
        const rigcal_status status =
            rc_project_through(uv, B, &fit->lens, fit->camera, X_c);
        if (status != RIGCAL_OK) {
            return status;
        }
        const rigcal_real e[2] = {o->uv[0] - uv[0], o->uv[1] - uv[1]};
        const rigcal_real weight =
            (fit->sigma == NULL) ? 1 : 1 / (fit->sigma[i] * fit->sigma[i]);
        add_point(g, H, B, q, e, weight, with_curvature ? X_c[2] : 0);
        sum += weight * (e[0] * e[0] + e[1] * e[1]);
    }
    *sse = sum;
    return rc_is_finite(sum) ? RIGCAL_OK : RIGCAL_ERR_NO_RAY;
}

rigcal_status rc_normal_equations(rigcal_real *sse, rigcal_real g[6],
                                  rigcal_real H[21], const rc_fit *fit,
                                  const rigcal_transform *cam_from_points)
{
    return equations(sse, g, H, fit, cam_from_points, 0);
}

rigcal_status rc_newton_equations(rigcal_real *sse, rigcal_real g[6],
                                  rigcal_real H[21], const rc_fit *fit,
                                  const rigcal_transform *cam_from_points)
{
    return equations(sse, g, H, fit, cam_from_points, 1);
}

/* ---- the packed 6 x 6 system --------------------------------------------- */

/* Lower triangles of 3 x 3 are held row by row, their diagonals as inverses. */

/* L L^T = A + damping diag(A). 0: not positive definite to rounding. `diagonal` is
 * what the pivots are compared with. */
static int factor3(rigcal_real L[6], const rigcal_real A[6],
                   const rigcal_real diagonal[3])
{
    if (!(A[0] > RANK_TOL * diagonal[0])) {
        return 0;
    }
    L[0] = 1 / RC_SQRT(A[0]);
    L[1] = A[1] * L[0];
    L[3] = A[3] * L[0];
    const rigcal_real yy = A[2] - L[1] * L[1];
    if (!(yy > RANK_TOL * diagonal[1])) {
        return 0;
    }
    L[2] = 1 / RC_SQRT(yy);
    L[4] = (A[4] - L[3] * L[1]) * L[2];
    const rigcal_real zz = A[5] - L[3] * L[3] - L[4] * L[4];
    if (!(zz > RANK_TOL * diagonal[2])) {
        return 0;
    }
    L[5] = 1 / RC_SQRT(zz);
    return 1;
}

/* x <- L^-1 x, x <- L^-T x */
static inline void forward3(rigcal_real x[3], const rigcal_real L[6])
{
    x[0] *= L[0];
    x[1] = (x[1] - L[1] * x[0]) * L[2];
    x[2] = (x[2] - L[3] * x[0] - L[4] * x[1]) * L[5];
}

static inline void backward3(rigcal_real x[3], const rigcal_real L[6])
{
    x[2] *= L[5];
    x[1] = (x[1] - L[4] * x[2]) * L[2];
    x[0] = (x[0] - L[1] * x[1] - L[3] * x[2]) * L[0];
}

/* The Cholesky factor (first 0; across second) of a 6 x 6 matrix. */
typedef struct {
    rigcal_real first[6], across[3][3], second[6];
} factor6;

/* L L^T = H + damping D, D = diag(H). Where Newton's curvature has made an element
 * of it small or negative, D has a part of the block's largest. 0: not positive
 * definite to rounding. */
static int factor(factor6 *L, const rigcal_real H[21], rigcal_real damping)
{
    const rigcal_real least[2] = {
        D_LEAST * rc_max(H[0], rc_max(H[2], H[5])),
        D_LEAST * rc_max(H[9], rc_max(H[14], H[20]))};
    const rigcal_real diagonal[6] = {
        rc_max(H[0], least[0]),  rc_max(H[2], least[0]),  rc_max(H[5], least[0]),
        rc_max(H[9], least[1]),  rc_max(H[14], least[1]), rc_max(H[20], least[1])};
    const rigcal_real A[6] = {H[0] + damping * diagonal[0], H[1],
                              H[2] + damping * diagonal[1], H[3], H[4],
                              H[5] + damping * diagonal[2]};
    if (!factor3(L->first, A, diagonal)) {
        return 0;
    }
    for (int i = 0, row = 6; i < 3; row += 4 + i++) {
        for (int k = 0; k < 3; k++) {
            L->across[i][k] = H[row + k];
        }
        forward3(L->across[i], L->first);
    }
    const rigcal_real *const a = L->across[0], *const b = L->across[1],
                            *const c = L->across[2];
    const rigcal_real S[6] = {H[9] + damping * diagonal[3] - rc_vec3_dot(a, a),
                              H[13] - rc_vec3_dot(b, a),
                              H[14] + damping * diagonal[4] - rc_vec3_dot(b, b),
                              H[18] - rc_vec3_dot(c, a),
                              H[19] - rc_vec3_dot(c, b),
                              H[20] + damping * diagonal[5] - rc_vec3_dot(c, c)};
    return factor3(L->second, S, &diagonal[3]);
}

/* x <- (L L^T)^-1 x */
static void solve(rigcal_real x[6], const factor6 *L)
{
    forward3(x, L->first);
    for (int i = 0; i < 3; i++) {
        x[3 + i] -= rc_vec3_dot(L->across[i], x);
    }
    forward3(x + 3, L->second);
    backward3(x + 3, L->second);
    for (int i = 0; i < 3; i++) {
        rc_vec3_add_scaled(x, -x[3 + i], L->across[i]);
    }
    backward3(x, L->first);
}

int rc_refine_covariance(rigcal_real Sigma[36], const rigcal_real H[21])
{
    factor6 L;
    rigcal_real column[6];
    if (!factor(&L, H, 0)) {
        return 0;
    }
    for (int j = 0; j < 6; j++) {
        for (int i = 0; i < 6; i++) {
            column[i] = (i == j) ? 1 : 0;
        }
        solve(column, &L);
        for (int i = 0; i < 6; i++) {
            Sigma[6 * i + j] = column[i];
        }
    }
    return 1;
}

int rc_refine_rotation_variance(rigcal_real *variance, const rigcal_real H[21])
{
    factor6 L;
    if (!factor(&L, H, 0)) {
        return 0;
    }
    *variance = 0;
    for (int j = 0; j < 3; j++) {
        rigcal_real column[6] = {0, 0, 0, 0, 0, 0};
        column[j] = 1;
        solve(column, &L);
        *variance += column[j];
    }
    return 1;
}

/* ---- Levenberg-Marquardt ------------------------------------------------- */

/* R <- exp([w]x) R, t <- t + dt for the step d = (w, dt), with the quaternion
 * (1, w / 2) for the exponential: right to second order, and for any step a
 * rotation. */
RC_APART static void move(rigcal_transform *pose, const rigcal_real d[6])
{
    const rigcal_real x = d[0] / 2, y = d[1] / 2, z = d[2] / 2;
    const rigcal_real s = 2 / (1 + x * x + y * y + z * z);
    const rigcal_real turn[9] = {
        1 - s * (y * y + z * z), s * (x * y - z),         s * (x * z + y),
        s * (x * y + z),         1 - s * (x * x + z * z), s * (y * z - x),
        s * (x * z - y),         s * (y * z + x),         1 - s * (x * x + y * y)};
    for (int column = 0; column < 3; column++) {
        const rigcal_real r[3] = {pose->R[column], pose->R[3 + column],
                                  pose->R[6 + column]};
        for (int row = 0; row < 3; row++) {
            pose->R[3 * row + column] = rc_vec3_dot(&turn[3 * row], r);
        }
    }
    rc_vec3_add_scaled(pose->t, 1, &d[3]);
}

void rc_refine_begin(rigcal_refinement *state)
{
    state->lambda = DAMPING_FIRST;
    state->sse = RC_MAX;
    state->last_gain = 0;
    state->evals = 0;
    state->is_stale = 1;
    state->is_newton = 0;
    state->status = RIGCAL_RUNNING;
}

/* The equations where `state` is. */
static void evaluate(rigcal_refinement *state, const rc_fit *fit)
{
    const rigcal_status status =
        equations(&state->sse, state->g, state->H, fit, &state->cam_from_points,
                  state->is_newton);
    if (status != RIGCAL_OK) {
        state->status = status;
    }
    state->is_stale = 0;
}

enum { SINGULAR, SADDLE, BOWL };

/* The step from where `state` is; *gain gets what it promises, undiminished. Newton's
 * H need not be positive definite, as on a saddle: it is damped until it is. */
RC_APART static int damped_step(rigcal_real d[6], rigcal_real *gain,
                                rigcal_refinement *state)
{
    factor6 L;
    int shape = BOWL;
    while (!factor(&L, state->H, state->lambda)) {
        if (!state->is_newton || state->lambda > DAMPING_NEWTON) {
            return SINGULAR;
        }
        state->lambda = rc_max(10 * state->lambda, DAMPING_BEND);
        shape = SADDLE;
    }
    for (int k = 0; k < 6; k++) {
        d[k] = state->g[k];
    }
    solve(d, &L);
    *gain = rc_vec3_dot(d, state->g) + rc_vec3_dot(d + 3, state->g + 3);
    const rigcal_real turn = rc_vec3_norm(d);
    if (turn > TURN_MOST) {
        for (int k = 0; k < 6; k++) {
            d[k] *= TURN_MOST / turn;
        }
    }
    return shape;
}

/* A nearly undamped step is the last when next to nothing is left to gain after
 * it. Were the gains to go on falling as from the step before, by r = gain /
 * last_gain each, that would be gain r / (1 - r); near an optimum they fall ever
 * faster, and in a valley, where r is near 1, a small gain alone says nothing. */
static int is_last(const rigcal_refinement *state, rigcal_real gain)
{
    return state->lambda <= DAMPING_NEAR &&
           (gain <= GAIN_NOTHING || gain <= GAIN_LEAST * state->sse ||
            gain * gain <= (state->last_gain - gain) * LEFT_LEAST * state->sse);
}

/* Takes the step unless it does harm. Then it is taken back, the equations are stale,
 * and from there on the damping is stronger and the curvature minded. */
static void try_step(rigcal_refinement *state, const rc_fit *fit,
                     const rigcal_real d[6], rigcal_real gain)
{
    const rigcal_transform before = state->cam_from_points;
    rigcal_real sse;
    move(&state->cam_from_points, d);
    const rigcal_status status = equations(&sse, state->g, state->H, fit,
                                           &state->cam_from_points,
                                           state->is_newton);
    if (status == RIGCAL_OK &&
        sse <= state->sse * (1 + SUM_ROUNDING) + GAIN_NOTHING) {
        state->sse = sse;
        state->last_gain = gain;
        state->lambda *= RC(0.1);
        return;
    }
    state->cam_from_points = before;
    state->is_stale = 1;
    state->is_newton = 1;
    state->last_gain = 0;
    state->lambda = rc_max(10 * state->lambda, DAMPING_FIRST);
    if (gain <= GAIN_ROUNDING * state->sse || state->lambda > DAMPING_LAST) {
        state->status = RIGCAL_OK; /* no step helps any more */
    }
}

static void advance(rigcal_refinement *state, const rc_fit *fit)
{
    rigcal_real d[6], gain;
    if (state->is_stale) {
        evaluate(state, fit);
        return;
    }
    const int shape = damped_step(d, &gain, state);
    if (shape == SINGULAR) {
        state->status = state->is_newton ? RIGCAL_RUNNING : RIGCAL_ERR_DEGENERATE;
        state->is_newton = 0;
        state->is_stale = 1;
        return;
    }
    if (is_last(state, gain)) {
        if (shape == SADDLE) {
            state->status = RIGCAL_BUDGET_SPENT; /* no optimum, and no way down */
            return;
        }
        move(&state->cam_from_points, d); /* unseen: its sum is known to second order */
        state->sse = rc_max(0, state->sse - gain);
        state->status = RIGCAL_OK;
        return;
    }
    if (state->last_gain > 0 && gain > SLOW * state->last_gain) {
        state->is_newton = 1;
    }
    try_step(state, fit, d, gain);
}

void rc_refine_step(rigcal_refinement *state, const rc_fit *fit,
                    int32_t max_evals)
{
    state->evals++;
    advance(state, fit);
    if (state->status == RIGCAL_RUNNING && state->evals >= max_evals) {
        state->status = RIGCAL_BUDGET_SPENT;
    }
}
