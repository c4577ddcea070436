#include "rc_refine.h"

/* Damping to start with, where it hardly matters, and where it is hopeless. */
#define DAMPING_FIRST RC(1e-5)
#define DAMPING_NEAR RC(1e-2)
#define DAMPING_LAST RC(1e8)

/* Rise of the sum that may be rounding. */
#define SUM_ROUNDING (16 * RC_EPS)

/* A step that promised to lower the sum by no more than this part of it was the
 * last: what remains is a small fraction of that. A billionth of the sum is a
 * thirty-thousandth of a standard deviation. */
#define GAIN_LEAST RC_TOL(1e-8, 1e-6)

/* One refused although it promised no more than this has met rounding. */
#define GAIN_ROUNDING RC_TOL(1e-7, 1e-4)

/* GAIN_LEAST in px^2, for images without noise. */
#define GAIN_NOTHING RC_TOL(1e-20, 1e-7)

/* Pivots are compared with this part of their diagonal. */
#define RANK_TOL (8 * RC_EPS)

/* ---- normal equations ---------------------------------------------------- */

/* One residual e and its row of J: with q = R x and dX_c = w x q + dt, a row b by
 * dX_c is (a, b) by (w, dt), a = q x b. Written out, for this is where the time of
 * a refinement goes. */
static void add_row(rigcal_real g[6], rigcal_real H[21], const rigcal_real b[3],
                    const rigcal_real q[3], rigcal_real e)
{
    rigcal_real a[3];
    rc_vec3_cross(a, q, b);
    rc_vec3_add_scaled(&g[0], e, a);
    rc_vec3_add_scaled(&g[3], e, b);
    H[0] += a[0] * a[0];
    H[1] += a[1] * a[0];
    H[2] += a[1] * a[1];
    rc_vec3_add_scaled(&H[3], a[2], a);
    rc_vec3_add_scaled(&H[6], b[0], a);
    H[9] += b[0] * b[0];
    rc_vec3_add_scaled(&H[10], b[1], a);
    H[13] += b[1] * b[0];
    H[14] += b[1] * b[1];
    rc_vec3_add_scaled(&H[15], b[2], a);
    rc_vec3_add_scaled(&H[18], b[2], b);
}

rigcal_status rc_normal_equations(rigcal_real *sse, rigcal_real g[6],
                                  rigcal_real H[21], const rc_fit *fit,
                                  const rigcal_transform *cam_from_points)
{
    rigcal_real sum = 0;
    for (int k = 0; k < 21; k++) {
        H[k] = 0;
        g[k % 6] = 0;
    }
    for (size_t i = 0; i < fit->n; i++) {
        const rigcal_observation *const o = &fit->observations[i];
        rigcal_real x[3], q[3], X_c[3], uv[2], J_c[6];
        rc_vec3_sub(x, o->X_w, fit->origin);
        rc_mat3_mul_vec3(q, cam_from_points->R, x);
        for (int k = 0; k < 3; k++) {
            X_c[k] = q[k] + cam_from_points->t[k];
        }
        const rigcal_status status =
            rc_project_through(uv, J_c, &fit->lens, fit->camera, X_c);
        if (status != RIGCAL_OK) {
            return status;
        }
        rigcal_real du = o->uv[0] - uv[0], dv = o->uv[1] - uv[1];
        if (fit->sigma != NULL) {
            const rigcal_real by_sigma = 1 / fit->sigma[i];
            du *= by_sigma;
            dv *= by_sigma;
            for (int k = 0; k < 6; k++) {
                J_c[k] *= by_sigma;
            }
        }
        add_row(g, H, &J_c[0], q, du);
        add_row(g, H, &J_c[3], q, dv);
        sum += du * du + dv * dv;
    }
    *sse = sum;
    return rc_is_finite(sum) ? RIGCAL_OK : RIGCAL_ERR_NO_RAY;
}

/* ---- the packed 6 x 6 system --------------------------------------------- */

/* L L^T = H + damping diag(H), lower triangles row by row; the diagonal of L is
 * held as its inverse. 0: not positive definite to rounding. */
static int factor(rigcal_real L[21], const rigcal_real H[21], rigcal_real damping)
{
    for (int i = 0, row = 0; i < 6; row += ++i) {
        for (int j = 0, column = 0; j <= i; column += ++j) {
            rigcal_real sum = H[row + j];
            for (int k = 0; k < j; k++) {
                sum -= L[row + k] * L[column + k];
            }
            if (j < i) {
                L[row + j] = sum * L[column + j];
                continue;
            }
            sum += damping * H[row + i];
            if (!(sum > RANK_TOL * H[row + i])) {
                return 0;
            }
            L[row + i] = 1 / RC_SQRT(sum);
        }
    }
    return 1;
}

/* x <- (L L^T)^-1 x */
static void solve(rigcal_real x[6], const rigcal_real L[21])
{
    for (int i = 0, row = 0; i < 6; row += ++i) {
        for (int k = 0; k < i; k++) {
            x[i] -= L[row + k] * x[k];
        }
        x[i] *= L[row + i];
    }
    for (int i = 5, row = 15; i >= 0; row -= i, i--) {
        x[i] *= L[row + i];
        for (int k = 0; k < i; k++) {
            x[k] -= L[row + k] * x[i];
        }
    }
}

int rc_refine_covariance(rigcal_real Sigma[36], const rigcal_real H[21])
{
    rigcal_real L[21], column[6];
    if (!factor(L, H, 0)) {
        return 0;
    }
    for (int j = 0; j < 6; j++) {
        for (int i = 0; i < 6; i++) {
            column[i] = (i == j) ? 1 : 0;
        }
        solve(column, L);
        for (int i = 0; i < 6; i++) {
            Sigma[6 * i + j] = column[i];
        }
    }
    return 1;
}

/* ---- Levenberg-Marquardt ------------------------------------------------- */

/* R <- exp([w]x) R, t <- t + dt, with the quaternion (1, w / 2) for the exponential:
 * right to second order, and for any step a rotation. */
static void moved(rigcal_transform *out, const rigcal_transform *from,
                  const rigcal_real d[6])
{
    const rigcal_real q_wxyz[4] = {1, d[0] / 2, d[1] / 2, d[2] / 2};
    rigcal_real turn[9];
    rc_rotation_from_quaternion(turn, q_wxyz);
    rc_mat3_mul(out->R, turn, from->R);
    for (int k = 0; k < 3; k++) {
        out->t[k] = from->t[k] + d[3 + k];
    }
}

void rc_refine_begin(rigcal_refinement *state,
                     const rigcal_transform *cam_from_points)
{
    state->cam_from_points = *cam_from_points;
    state->lambda = DAMPING_FIRST;
    state->sse = RC_MAX;
    state->evals = 0;
    state->status = RIGCAL_RUNNING;
}

/* The step from where `state` is; *gain gets what it promises. 0: singular. */
static int damped_step(rigcal_real d[6], rigcal_real *gain,
                       const rigcal_refinement *state)
{
    rigcal_real L[21];
    if (!factor(L, state->H, state->lambda)) {
        return 0;
    }
    *gain = 0;
    for (int k = 0; k < 6; k++) {
        d[k] = state->g[k];
    }
    solve(d, L);
    for (int k = 0; k < 6; k++) {
        *gain += d[k] * state->g[k];
    }
    return 1;
}

/* Takes the candidate when it does no harm, else damps more. */
static void judge_candidate(rigcal_refinement *state, const rc_fit *fit,
                            const rigcal_transform *candidate, rigcal_real gain)
{
    rigcal_real sse, g[6], H[21];
    if (rc_normal_equations(&sse, g, H, fit, candidate) != RIGCAL_OK ||
        !(sse <= state->sse * (1 + SUM_ROUNDING) + GAIN_NOTHING)) {
        state->lambda = rc_max(10 * state->lambda, DAMPING_FIRST);
        if (gain <= GAIN_ROUNDING * state->sse || state->lambda > DAMPING_LAST) {
            state->status = RIGCAL_OK; /* no step helps any more */
        }
        return;
    }
    state->cam_from_points = *candidate;
    state->sse = sse;
    state->lambda *= RC(0.1);
    for (int k = 0; k < 21; k++) {
        state->H[k] = H[k];
    }
    for (int k = 0; k < 6; k++) {
        state->g[k] = g[k];
    }
}

/* A nearly undamped step that promises next to nothing is the last. */
static int is_last(const rigcal_refinement *state, rigcal_real gain)
{
    return state->lambda <= DAMPING_NEAR &&
           (gain <= GAIN_LEAST * state->sse || gain <= GAIN_NOTHING);
}

void rc_refine_step(rigcal_refinement *state, const rc_fit *fit,
                    int32_t max_evals)
{
    if (state->evals++ == 0) {
        const rigcal_status status =
            rc_normal_equations(&state->sse, state->g, state->H, fit,
                                &state->cam_from_points);
        state->status = (status == RIGCAL_OK) ? RIGCAL_RUNNING : status;
        return;
    }
    rigcal_real d[6], gain;
    rigcal_transform candidate;
    if (!damped_step(d, &gain, state)) {
        state->status = RIGCAL_ERR_DEGENERATE;
        return;
    }
    moved(&candidate, &state->cam_from_points, d);
    if (is_last(state, gain)) { /* taken unseen: its sum is known to second order */
        state->cam_from_points = candidate;
        state->sse = rc_max(0, state->sse - gain);
        state->status = RIGCAL_OK;
        return;
    }
    judge_candidate(state, fit, &candidate, gain);
    if (state->status == RIGCAL_RUNNING && state->evals >= max_evals) {
        state->status = RIGCAL_BUDGET_SPENT;
    }
}
