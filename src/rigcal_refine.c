#include "rc_refine.h"

/* ---- constants ----------------------------------------------------------- */

/* rad: the most that one step turns. A larger turn would leave the basin. */
#define TURN_MOST RC(0.3)

/* part of the sum: an approach ends with a step that gains no more. */
#define APPROACHED RC(1e-4)

/* steps: of an approach, usually 3 to 5. */
enum { APPROACH_STEPS = 12 };

/* Whether there is code for rays far off the axis, which takes poses of three points. */
enum { WITH_WIDE = RIGCAL_WITH_THREE_POINTS };

/* ---- the equations ------------------------------------------------------- */

/* What a pinhole's point adds (E1): x = X / Z and y = Y / Z, a = w fx^2 / Z^2,
 * b = w fy^2 / Z^2, and c, the force on it. M is (a 0 ax; 0 b by; ax by m), of which the
 * zeros are used; K = [q]x M row by row. */
static inline void add_pinhole(rigcal_real g[6], rigcal_real H[21], const rigcal_real q[3],
                               const rigcal_real c[3], rigcal_real a, rigcal_real b,
                               rigcal_real x, rigcal_real y)
{
    const rigcal_real ax = -a * x, by = -b * y, m = -(ax * x + by * y);
    g[0] += q[1] * c[2] - q[2] * c[1];
    g[1] += q[2] * c[0] - q[0] * c[2];
    g[2] += q[0] * c[1] - q[1] * c[0];
    g[3] += c[0];
    g[4] += c[1];
    g[5] += c[2];
    H[15] += a;
    H[17] += ax;
    H[18] += b;
    H[19] += by;
    H[20] += m;
    const rigcal_real k00 = q[1] * ax, k01 = q[1] * by - q[2] * b, k02 = q[1] * m - q[2] * by;
    const rigcal_real k10 = q[2] * a - q[0] * ax, k11 = -q[0] * by, k12 = q[2] * ax - q[0] * m;
    const rigcal_real k20 = -q[1] * a, k21 = q[0] * b, k22 = q[0] * by - q[1] * ax;
    H[6] += k00;
    H[7] += k01;
    H[8] += k02;
    H[9] += k10;
    H[10] += k11;
    H[11] += k12;
    H[12] += k20;
    H[13] += k21;
    H[14] += k22;
    H[0] += q[1] * k02 - q[2] * k01;
    H[1] += q[2] * k00 - q[0] * k02;
    H[2] += q[0] * k01 - q[1] * k00;
    H[3] += q[2] * k10 - q[0] * k12;
    H[4] += q[0] * k11 - q[1] * k10;
    H[5] += q[0] * k21 - q[1] * k20;
}

/* (E1) The equations of a pinhole by Gauss and Newton, written out: here is where the time
 * of a search goes. */
static rigcal_status pinhole_equations(rigcal_real *sum, rigcal_real g[6],
                                       rigcal_real H[21], const rigcal_points *points,
                                       size_t n, const rigcal_transform *cam_from_points)
{
    const rigcal_camera *const camera = points->view.camera;
    const rigcal_real *const t = cam_from_points->t;
    rigcal_real total = 0;
    for (size_t i = rc_points_next(points, 0); i < n; i = rc_points_next(points, i + 1)) {
        const rigcal_real *const uv = points->view.observations[i].uv;
        rigcal_real x[3], q[3];
        rc_points_at(x, points, i);
        rc_mat3_mul_vec3(q, cam_from_points->R, x);
        const rigcal_real Z = q[2] + t[2];
        if (!(Z > 0)) {
            return RIGCAL_ERR_BEHIND;
        }
        const rigcal_real by_Z = 1 / Z, weight = rc_points_weight(points, i);
        const rigcal_real at[2] = {(q[0] + t[0]) * by_Z, (q[1] + t[1]) * by_Z};
        const rigcal_real bu = camera->fx * by_Z, bv = camera->fy * by_Z;
        const rigcal_real eu = uv[0] - (camera->fx * at[0] + camera->cx);
        const rigcal_real ev = uv[1] - (camera->fy * at[1] + camera->cy);
        const rigcal_real wu = weight * bu, wv = weight * bv;
        rigcal_real c[3] = {wu * eu, wv * ev, 0};
        c[2] = -(c[0] * at[0] + c[1] * at[1]);
        add_pinhole(g, H, q, c, wu * bu, wv * bv, at[0], at[1]);
        total += weight * (eu * eu + ev * ev);
    }
    *sum = total;
    return rc_is_finite(total) ? RIGCAL_OK : RIGCAL_ERR_NO_RAY;
}

rigcal_status rc_refine_equations(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                                  const rigcal_points *points, size_t n,
                                  const rigcal_transform *cam_from_points, int equations)
{
    RIGCAL_ASSERT(n <= points->view.n);
    RIGCAL_ASSERT(equations >= RC_GAUSS_NEWTON && equations <= RC_NEWTON_INDEFINITE);
    const int is_fisheye = rc_lens_is_fisheye(points->view.camera);
    rigcal_real total = 0;
    rc_rigid_clear(g, H);
    if (RC_FOR_SPEED && points->is_pinhole && equations == RC_GAUSS_NEWTON) {
        return pinhole_equations(sum, g, H, points, n, cam_from_points);
    }
    for (size_t i = rc_points_next(points, 0); i < n; i = rc_points_next(points, i + 1)) {
        rigcal_real e[2] = {0, 0}, B[6], q[3], X_c[3];
        const rigcal_status status =
            rc_points_residual(e, B, q, X_c, points, cam_from_points, i);
        if (status != RIGCAL_OK) {
            return status;
        }
        const rigcal_real weight = rc_points_weight(points, i);
        rc_rigid_add(g, H, B, q, e, weight, (equations != RC_GAUSS_NEWTON) ? X_c : NULL,
                     is_fisheye);
        total += weight * (e[0] * e[0] + e[1] * e[1]);
    }
    *sum = total;
    return rc_is_finite(total) ? RIGCAL_OK : RIGCAL_ERR_NO_RAY;
}

/* ---- a step -------------------------------------------------------------- */

/* The step from where `state` is; *gain gets what it promises, undiminished. 0: H is not
 * positive definite. */
static int damped_step(rigcal_real d[6], rigcal_real *gain, const rigcal_refinement *state)
{
    rc_sym6_factor L;
    if (!rc_sym6_factor_of(&L, state->H, state->search.lambda)) {
        return 0;
    }
    for (int k = 0; k < 6; k++) {
        d[k] = state->g[k];
    }
    rc_sym6_solve(d, &L);
    *gain = rc_vec3_dot(d, state->g) + rc_vec3_dot(d + 3, state->g + 3);
    const rigcal_real turn = rc_vec3_norm(d);
    if (turn > TURN_MOST) {
        for (int k = 0; k < 6; k++) {
            d[k] *= TURN_MOST / turn;
        }
    }
    return 1;
}

/* ---- Levenberg-Marquardt ------------------------------------------------- */

void rc_refine_begin(rigcal_refinement *state, int is_wide)
{
    rc_levenberg_begin(&state->search, is_wide);
    state->evals = 0;
    state->is_approach = is_wide;
}

/* *sum, state->g and state->H where `state` is. */
static rigcal_status evaluate(rigcal_real *sum, rigcal_refinement *state,
                              const rigcal_points *points)
{
    return rc_refine_equations(sum, state->g, state->H, points, points->view.n,
                               &state->cam_from_points, state->search.equations);
}

/* A step of Gauss and Newton on errors along the rays. It is neither damped nor refused:
 * the weights of rays far off the axis make its way a steep and winding valley, which small
 * steps would follow for long. */
RC_APART static void approach(rigcal_refinement *state, const rigcal_points *points)
{
    const rigcal_view *const view = &points->view;
    rigcal_real d[6], gain = 0, sum = 0;
    rc_rigid_clear(state->g, state->H);
    for (size_t i = rc_points_next(points, 0); i < view->n;
         i = rc_points_next(points, i + 1)) {
        rigcal_real e[2], B[6], q[3], X_c[3];
        rc_points_place(q, X_c, points, &state->cam_from_points, i);
        rc_residual_along_ray(e, B, view->camera, points->is_pinhole,
                              view->observations[i].uv, X_c);
        const rigcal_real weight = rc_points_weight(points, i) / rc_vec3_dot(X_c, X_c);
        rc_rigid_add(state->g, state->H, B, q, e, weight, NULL, 0);
        sum += weight * (e[0] * e[0] + e[1] * e[1]);
    }
    if (damped_step(d, &gain, state)) {
        rc_transform_move(&state->cam_from_points, d);
    }
    if (gain <= APPROACHED * sum || state->evals == APPROACH_STEPS) {
        state->is_approach = 0;
    }
}

/* Takes the step unless it does harm. Then it is taken back, the turn by its inverse: no
 * copy of the rotation. */
static void try_step(rigcal_refinement *state, const rigcal_points *points,
                     rigcal_real d[6], rigcal_real gain)
{
    rigcal_transform *const pose = &state->cam_from_points;
    rigcal_real sum = 0, t[3];
    rc_vec3_copy(t, pose->t);
    rc_transform_move(pose, d);
    const rigcal_status status = evaluate(&sum, state, points);
    if (!rc_levenberg_tried(&state->search, status, sum, gain, points->negligible)) {
        rc_vec3_scale(d, -1, d);
        rc_transform_move(pose, d);
        rc_vec3_copy(pose->t, t);
    }
}

static void search(rigcal_refinement *state, const rigcal_points *points)
{
    rigcal_levenberg *const lm = &state->search;
    rigcal_real d[6], gain, sum = 0;
    if (lm->want == RC_WANT_EQUATIONS) {
        const rigcal_status status = evaluate(&sum, state, points);
        rc_levenberg_evaluated(lm, status, sum);
    } else if (!damped_step(d, &gain, state)) {
        rc_levenberg_not_definite(lm);
    } else {
        const int step = rc_levenberg_promised(lm, gain, points->negligible);
        if (step == RC_STEP_TRY) {
            try_step(state, points, d, gain);
        } else if (step == RC_STEP_LAST) {
            rc_transform_move(&state->cam_from_points, d);
        }
    }
}

void rc_refine_step(rigcal_refinement *state, const rigcal_points *points,
                    int32_t max_evals)
{
    RIGCAL_ASSERT(max_evals >= 1);
    RIGCAL_ASSERT(state->search.status == RIGCAL_RUNNING);
    state->evals++;
    if (WITH_WIDE && state->is_approach) {
        approach(state, points);
    } else {
        search(state, points);
    }
    if (state->search.status == RIGCAL_RUNNING && state->evals >= max_evals) {
        state->search.status = RIGCAL_BUDGET_SPENT;
    }
}
