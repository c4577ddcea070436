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

/* An approach ends when a step gains no more than this part of the sum, usually after 3
 * to 5 steps; and at the latest after so many. */
#define APPROACHED RC(1e-4)
enum { APPROACH_STEPS = 12 };

/* Whether there is code for rays far off the axis: it takes poses of three points. */
enum { WITH_WIDE = RIGCAL_WITH_THREE_POINTS };

/* ---- what is fitted ------------------------------------------------------ */

void rc_fit_of(rigcal_fit *fit, const rigcal_camera *camera,
               const rigcal_observation observations[], const rigcal_real sigma[],
               const uint8_t mask[], size_t n)
{
    fit->camera = camera;
    fit->observations = observations;
    fit->sigma = sigma;
    fit->mask = mask;
    fit->n = n;
    fit->is_mirrored = 0;
    fit->left_out = -1;
}

void rc_fit_begin(rigcal_fit *fit, const rigcal_real origin[3])
{
    rc_vec3_copy(fit->origin, origin);
    fit->pixel = rc_pixel_size(fit->camera);
    fit->nothing = GAIN_NOTHING * fit->pixel * fit->pixel;
    rc_lens_of(&fit->lens, fit->camera);
}

extern inline int rc_fit_uses(const rigcal_fit *fit, size_t i);

void rc_fit_point(rigcal_real x[3], const rigcal_fit *fit, size_t i)
{
    const rigcal_real *const X = fit->observations[i].X_w;
    const rigcal_real *const o = fit->origin;
    rc_vec3_sub(x, fit->is_mirrored ? o : X, fit->is_mirrored ? X : o);
}

void rc_fit_place(rigcal_real q[3], rigcal_real X_c[3], const rigcal_fit *fit,
                  const rigcal_transform *cam_from_points, size_t i)
{
    rigcal_real x[3];
    rc_fit_point(x, fit, i);
    rc_mat3_mul_vec3(q, cam_from_points->R, x);
    rc_vec3_copy(X_c, q);
    rc_vec3_add(X_c, cam_from_points->t);
}

/* The error of point i in pixels, its derivative B by X_c, and what rc_fit_place
 * gives. */
static inline rigcal_status error_of(rigcal_real e[2], rigcal_real B[6],
                                     rigcal_real q[3], rigcal_real X_c[3],
                                     const rigcal_fit *fit,
                                     const rigcal_transform *cam_from_points,
                                     size_t i)
{
    rc_fit_place(q, X_c, fit, cam_from_points, i);
    const rigcal_status status =
        rc_project_through(e, B, &fit->lens, fit->camera, X_c);
    for (int k = 0; k < 2; k++) {
        e[k] = fit->observations[i].uv[k] - e[k];
    }
    return status;
}

rigcal_real rc_fit_distance2(const rigcal_fit *fit,
                             const rigcal_transform *cam_from_points, size_t i)
{
    rigcal_real e[2] = {0, 0}, B[6], q[3], X_c[3];
    if (error_of(e, B, q, X_c, fit, cam_from_points, i) != RIGCAL_OK) {
        return RC_MAX;
    }
    return rc_min(e[0] * e[0] + e[1] * e[1], RC_MAX);
}

/* ---- normal equations ---------------------------------------------------- */

/* The curvature of the projection in H: a saddle is where it makes H indefinite. And the
 * errors along the rays, from which a refinement of a wide target begins. */
enum { LEFT_OUT, ALONG_RAYS, MINDED, SADDLE };

/* H is held in blocks: by w (symmetric), across (a row of w, a column of dt) and by dt
 * (symmetric). */
enum { ACROSS = 6, BY_DT = 15 };

/* What Newton's H has beyond that of Gauss and Newton: the curvature of uv, times -e.
 * That of a pinhole is -(c k^T + k c^T) / Z, k = (0, 0, 1), and a lens bends little
 * more: it goes into M, by dt. That of exp([w]x) q, [w]x [w]x q / 2, makes
 * (c.q) 1 - (c q^T + q c^T) / 2 by w. */
static void add_curvature(rigcal_real H[21], rigcal_real M[9],
                          const rigcal_real c[3], const rigcal_real q[3],
                          const rigcal_real X_c[3], int is_fisheye)
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
                           const rigcal_real q[3], rigcal_real a,
                           const rigcal_real m[3], rigcal_real b,
                           const rigcal_real n[3])
{
    rigcal_real row[3];
    rc_vec3_combine(row, a, m, b, n);
    rc_vec3_add(across, row);
    rc_vec3_cross(out, q, row);
}

/* One point. With q = R x and dX_c = w x q + dt, its rows of J are B [-[q]x, 1],
 * B = d uv / dX_c. So with c = B^T e and M = B^T B it adds (q x c, c) to g, and to H
 * M by dt, K = [q]x M across, and K [q]x^T by w, the rows of which are q x those of K.
 * Written out, for this is where the time of a refinement goes. Z > 0: with the
 * curvature. */
RC_APART static void add_point(rigcal_real g[6], rigcal_real H[21],
                               const rigcal_real B[6], const rigcal_real q[3],
                               const rigcal_real e[2], rigcal_real weight,
                               const rigcal_real X_c[3], int is_fisheye)
{
    const rigcal_real *const bu = B, *const bv = B + 3;
    rigcal_real *const across = &H[ACROSS], *const by_dt = &H[BY_DT];
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

static void clear_sums(rigcal_real *sse, rigcal_real g[6], rigcal_real H[21])
{
    *sse = 0;
    for (int k = 0; k < 6; k++) {
        g[k] = 0;
    }
    for (int k = 0; k < 21; k++) {
        H[k] = 0;
    }
}

static rigcal_real weight_of(const rigcal_fit *fit, size_t i)
{
    return (fit->sigma == NULL) ? 1 : 1 / (fit->sigma[i] * fit->sigma[i]);
}

static rigcal_status equations(rigcal_real *sse, rigcal_real g[6],
                               rigcal_real H[21], const rigcal_fit *fit,
                               const rigcal_transform *cam_from_points,
                               int with_curvature)
{
    rigcal_real sum;
    clear_sums(&sum, g, H);
    for (size_t i = 0; i < fit->n; i++) {
        rigcal_real e[2] = {0, 0}, B[6], q[3], X_c[3];
        if (!rc_fit_uses(fit, i)) {
            continue;
        }
        const rigcal_status status =
            error_of(e, B, q, X_c, fit, cam_from_points, i);
        if (status != RIGCAL_OK) {
            return status;
        }
        const rigcal_real weight = weight_of(fit, i);
        add_point(g, H, B, q, e, weight, with_curvature ? X_c : NULL,
                  fit->lens.is_fisheye);
        sum += weight * (e[0] * e[0] + e[1] * e[1]);
    }
    *sse = sum;
    return rc_is_finite(sum) ? RIGCAL_OK : RIGCAL_ERR_NO_RAY;
}

rigcal_status rc_normal_equations(rigcal_real *sse, rigcal_real g[6],
                                  rigcal_real H[21], const rigcal_fit *fit,
                                  const rigcal_transform *cam_from_points)
{
    return equations(sse, g, H, fit, cam_from_points, 0);
}

rigcal_status rc_newton_equations(rigcal_real *sse, rigcal_real g[6],
                                  rigcal_real H[21], const rigcal_fit *fit,
                                  const rigcal_transform *cam_from_points)
{
    return equations(sse, g, H, fit, cam_from_points, 1);
}

/* ---- the 6 x 6 system ---------------------------------------------------- */

/* Cholesky's factor of a 6 x 6 matrix in blocks: (first 0; across^T second). */
typedef struct {
    rigcal_real first[6], across[3][3], second[6];
} factor6;

/* A + damping D of a block A, D = diag(A). Where Newton's curvature has made an element
 * of it small or negative, D has a part of the largest. */
static void damp(rigcal_real damped[6], rigcal_real D[3],
                 const rigcal_real A[6], rigcal_real damping)
{
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

/* L L^T = H + damping D. 0: not positive definite to rounding. */
static int factor(factor6 *L, const rigcal_real H[21], rigcal_real damping)
{
    rigcal_real D[3];
    damp(L->first, D, H, damping);
    if (!rc_sym3_factor(L->first, L->first, D, RANK_TOL)) {
        return 0;
    }
    damp(L->second, D, &H[BY_DT], damping);
    for (int column = 0; column < 3; column++) {
        rigcal_real x[3] = {H[ACROSS + column], H[ACROSS + 3 + column],
                            H[ACROSS + 6 + column]};
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

/* x <- (L L^T)^-1 x */
static void solve(rigcal_real x[6], const factor6 *L)
{
    rc_sym3_forward(x, L->first);
    for (int k = 0; k < 3; k++) {
        rc_vec3_add_scaled(&x[3], -x[k], L->across[k]);
    }
    rc_sym3_forward(&x[3], L->second);
    rc_sym3_backward(&x[3], L->second);
    for (int k = 0; k < 3; k++) {
        x[k] -= rc_vec3_dot(L->across[k], &x[3]);
    }
    rc_sym3_backward(x, L->first);
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
 * (1, v), v = w / 2, for the exponential: right to second order, and for any step a
 * rotation. It takes a column r of R to r + (v x r + v x (v x r)) 2 / (1 + |v|^2). */
RC_APART static void move(rigcal_transform *pose, const rigcal_real d[6])
{
    rigcal_real v[3];
    rc_vec3_scale(v, RC(0.5), d);
    const rigcal_real scale = 2 / (1 + rc_vec3_dot(v, v));
    for (int column = 0; column < 3; column++) {
        rigcal_real *const R = &pose->R[column];
        const rigcal_real r[3] = {R[0], R[3], R[6]};
        rigcal_real once[3], twice[3];
        rc_vec3_cross(once, v, r);
        rc_vec3_cross(twice, v, once);
        for (int k = 0; k < 3; k++) {
            R[3 * k] += scale * (once[k] + twice[k]);
        }
    }
    rc_vec3_add(pose->t, &d[3]);
}

void rc_refine_begin(rigcal_refinement *state, int is_wide)
{
    state->lambda = DAMPING_FIRST;
    state->sse = RC_MAX;
    state->last_gain = 0;
    state->evals = 0;
    state->is_stale = 1;
    state->curvature = is_wide ? ALONG_RAYS : LEFT_OUT; /* 1 and 0 */
    state->status = RIGCAL_RUNNING;
}

/* The equations where `state` is. */
static void evaluate(rigcal_refinement *state, const rigcal_fit *fit)
{
    const rigcal_status status =
        equations(&state->sse, state->g, state->H, fit, &state->cam_from_points,
                  state->curvature != LEFT_OUT);
    if (status != RIGCAL_OK) {
        state->status = status;
    }
    state->is_stale = 0;
}

/* The step from where `state` is; *gain gets what it promises, undiminished. 0: H is not
 * positive definite. */
RC_APART static int damped_step(rigcal_real d[6], rigcal_real *gain,
                                const rigcal_refinement *state)
{
    factor6 L;
    if (!factor(&L, state->H, state->lambda)) {
        return 0;
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
    return 1;
}

/* Newton's H need not be positive definite, as on a saddle: it is damped more, call by
 * call, until it is, or left out. That of Gauss and Newton is singular. */
static void bend_up(rigcal_refinement *state)
{
    if (state->curvature == LEFT_OUT) {
        state->status = RIGCAL_ERR_DEGENERATE;
    } else if (state->lambda > DAMPING_NEWTON) {
        state->curvature = LEFT_OUT;
        state->is_stale = 1;
    } else {
        state->curvature = SADDLE;
        state->lambda = rc_max(10 * state->lambda, DAMPING_BEND);
    }
}

/* A nearly undamped step is the last when next to nothing is left to gain after
 * it. Were the gains to go on falling as from the step before, by r = gain /
 * last_gain each, that would be gain r / (1 - r); near an optimum they fall ever
 * faster, and in a valley, where r is near 1, a small gain alone says nothing. */
static int is_last(const rigcal_refinement *state, rigcal_real gain,
                   rigcal_real nothing)
{
    return state->lambda <= DAMPING_NEAR &&
           (gain <= nothing || gain <= GAIN_LEAST * state->sse ||
            gain * gain <= (state->last_gain - gain) * LEFT_LEAST * state->sse);
}

/* Takes the step unless it does harm. Then it is taken back (the turn by its inverse: no
 * copy of the rotation), the equations are stale, and from there on the damping is
 * stronger and the curvature minded. */
static void try_step(rigcal_refinement *state, const rigcal_fit *fit,
                     rigcal_real d[6], rigcal_real gain)
{
    rigcal_transform *const pose = &state->cam_from_points;
    rigcal_real sse, t[3];
    rc_vec3_copy(t, pose->t);
    move(pose, d);
    const rigcal_status status = equations(&sse, state->g, state->H, fit, pose,
                                           state->curvature != LEFT_OUT);
    if (status == RIGCAL_OK &&
        sse <= state->sse * (1 + SUM_ROUNDING) + fit->nothing) {
        state->sse = sse;
        state->last_gain = gain;
        state->lambda *= RC(0.1);
        return;
    }
    rc_vec3_scale(d, -1, d);
    move(pose, d);
    rc_vec3_copy(pose->t, t);
    state->is_stale = 1;
    state->curvature = MINDED;
    state->last_gain = 0;
    state->lambda = rc_max(10 * state->lambda, DAMPING_FIRST);
    if (gain <= GAIN_ROUNDING * state->sse || state->lambda > DAMPING_LAST) {
        state->status = RIGCAL_OK; /* no step helps any more */
    }
}

/* A step of Gauss and Newton on errors that are to first order those in pixels and have no
 * pole where a point is 90 degrees off the axis: e = -J X_c / |X_c|, J = d uv / d X at the
 * ray m of the pixel, where J m = 0. It is neither damped nor refused: the weights of rays
 * far off the axis make its way a steep and winding valley, which small steps would follow
 * for long. */
RC_APART static void approach(rigcal_refinement *state, const rigcal_fit *fit)
{
    rigcal_real d[6], gain = 0;
    state->lambda = 0;
    clear_sums(&state->sse, state->g, state->H);
    for (size_t i = 0; i < fit->n; i++) {
        rigcal_real ray[3], e[2], J[6], q[3], X_c[3];
        if (!rc_fit_uses(fit, i)) {
            continue;
        }
        (void)rc_pixel_to_ray(ray, fit->camera, fit->observations[i].uv);
        (void)rc_project_through(e, J, &fit->lens, fit->camera, ray);
        rc_fit_place(q, X_c, fit, &state->cam_from_points, i);
        e[0] = -rc_vec3_dot(&J[0], X_c);
        e[1] = -rc_vec3_dot(&J[3], X_c);
        const rigcal_real weight = weight_of(fit, i) / rc_vec3_dot(X_c, X_c);
        add_point(state->g, state->H, J, q, e, weight, NULL, 0);
        state->sse += weight * (e[0] * e[0] + e[1] * e[1]);
    }
    if (damped_step(d, &gain, state)) {
        move(&state->cam_from_points, d);
    }
    if (gain <= APPROACHED * state->sse || state->evals == APPROACH_STEPS) {
        state->curvature = LEFT_OUT;
    }
}

static void advance(rigcal_refinement *state, const rigcal_fit *fit)
{
    rigcal_real d[6], gain;
    if (WITH_WIDE && state->curvature == ALONG_RAYS) {
        approach(state, fit);
        return;
    }
    if (state->is_stale) {
        evaluate(state, fit);
        return;
    }
    if (!damped_step(d, &gain, state)) {
        bend_up(state);
        return;
    }
    const int is_saddle = state->curvature == SADDLE;
    if (is_last(state, gain, fit->nothing)) {
        if (is_saddle) { /* no optimum, and no way down */
            state->status = RIGCAL_BUDGET_SPENT;
            return;
        }
        /* Unseen: its sum is known to second order. */
        move(&state->cam_from_points, d);
        state->sse = rc_max(0, state->sse - gain);
        state->status = RIGCAL_OK;
        return;
    }
    if (is_saddle || (state->last_gain > 0 && gain > SLOW * state->last_gain)) {
        state->curvature = MINDED;
    }
    try_step(state, fit, d, gain);
}

void rc_refine_step(rigcal_refinement *state, const rigcal_fit *fit,
                    int32_t max_evals)
{
    state->evals++;
    advance(state, fit);
    if (state->status == RIGCAL_RUNNING && state->evals >= max_evals) {
        state->status = RIGCAL_BUDGET_SPENT;
    }
}
