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

rigcal_status rc_refine_equations(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                                  const rigcal_points *points, size_t n,
                                  const rigcal_transform *cam_from_points, int equations)
{
    RIGCAL_ASSERT(n <= points->view.n);
    RIGCAL_ASSERT(equations >= RC_GAUSS_NEWTON && equations <= RC_NEWTON_INDEFINITE);
    const int is_fisheye = rc_lens_is_fisheye(points->view.camera);
    rigcal_real total = 0;
    rc_rigid_clear(g, H);
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
