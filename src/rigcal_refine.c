#include "rc_refine.h"

/* ---- constants ----------------------------------------------------------- */

/* rad: one step turns at most this far. A larger turn would leave the basin. */
#define TURN_MOST RC(0.3)

/* part of the sum: an approach ends after a step that gains no more than this. */
#define APPROACHED RC(1e-4)

/* steps: an approach takes at most this many, usually 3 to 5. */
enum { APPROACH_STEPS = 12 };

/* points: the first step of a refinement may go by this many, if at least twice as many
 * count. */
enum { PART = 12 };

/* part of the sum: after a step that gains no more than this, H is nearly the same. */
#define SAME_H RC(1e-3)

/* Whether there is code for rays far off the axis. It needs the poses of three points. */
enum { WITH_WIDE = RIGCAL_WITH_THREE_POINTS };

/* ---- the equations ------------------------------------------------------- */

/* Adds a point to g. x is its place in the lens's plane, c the force along X and Y. */
static inline void add_force(rigcal_real g[6], const rigcal_real q[3],
                             const rigcal_real x[2], const rigcal_real c[2])
{
    const rigcal_real along = -(c[0] * x[0] + c[1] * x[1]);
    g[0] += q[1] * along - q[2] * c[1];
    g[1] += q[2] * c[0] - q[0] * along;
    g[2] += q[0] * c[1] - q[1] * c[0];
    g[3] += c[0];
    g[4] += c[1];
    g[5] += along;
}

/* Computes the last column (u, v, m) of M. */
RIGCAL_FORCE_INLINE static inline void column_of(rigcal_real uvm[3],
                                                 const rigcal_real ahb[3],
                                                 const rigcal_real x[2], int is_pinhole)
{
    uvm[0] = -ahb[0] * x[0];
    uvm[1] = -ahb[2] * x[1];
    if (!is_pinhole) {
        uvm[0] -= ahb[1] * x[1];
        uvm[1] -= ahb[1] * x[0];
    }
    uvm[2] = -(uvm[0] * x[0] + uvm[1] * x[1]);
}

/* Adds the curvature (B5) to the part of H by w, and to uvm, the last column of M. */
static inline void add_bend(rigcal_real H[21], rigcal_real uvm[3], const rigcal_real q[3],
                            const rigcal_real x[2], const rigcal_real c[2],
                            rigcal_real by_Z)
{
    const rigcal_real along = -(c[0] * x[0] + c[1] * x[1]);
    const rigcal_real d0 = c[0] * q[0], d1 = c[1] * q[1], d2 = along * q[2];
    uvm[0] += c[0] * by_Z;
    uvm[1] += c[1] * by_Z;
    uvm[2] += 2 * along * by_Z;
    H[0] += d1 + d2;
    H[1] -= (c[0] * q[1] + c[1] * q[0]) / 2;
    H[2] -= (c[0] * q[2] + along * q[0]) / 2;
    H[3] += d0 + d2;
    H[4] -= (c[1] * q[2] + along * q[1]) / 2;
    H[5] += d0 + d1;
}

/* Adds a point to H (B5) from the block (a h; h b) of M and its last column. For a pinhole
 * h is 0. */
RIGCAL_FORCE_INLINE static inline void add_in_plane(rigcal_real H[21],
                                                    const rigcal_real q[3],
                                                    const rigcal_real ahb[3],
                                                    const rigcal_real uvm[3],
                                                    int is_pinhole)
{
    const rigcal_real a = ahb[0], h = ahb[1], b = ahb[2];
    const rigcal_real u = uvm[0], v = uvm[1], m = uvm[2];
    H[15] += a;
    if (!is_pinhole) {
        H[16] += h;
    }
    H[17] += u;
    H[18] += b;
    H[19] += v;
    H[20] += m;
    const rigcal_real k00 = is_pinhole ? q[1] * u : q[1] * u - q[2] * h;
    const rigcal_real k01 = q[1] * v - q[2] * b;
    const rigcal_real k02 = q[1] * m - q[2] * v;
    const rigcal_real k10 = q[2] * a - q[0] * u;
    const rigcal_real k11 = is_pinhole ? -q[0] * v : q[2] * h - q[0] * v;
    const rigcal_real k12 = q[2] * u - q[0] * m;
    const rigcal_real k20 = is_pinhole ? -q[1] * a : q[0] * h - q[1] * a;
    const rigcal_real k21 = is_pinhole ? q[0] * b : q[0] * b - q[1] * h;
    const rigcal_real k22 = q[0] * v - q[1] * u;
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

/* Sets c = J c and (a h; h b) = J (a 0; 0 b) J. */
static inline void pull_back(rigcal_real c[2], rigcal_real ahb[3], const rigcal_real J[3])
{
    const rigcal_real a = ahb[0], b = ahb[2], c0 = c[0];
    c[0] = J[0] * c0 + J[1] * c[1];
    c[1] = J[1] * c0 + J[2] * c[1];
    ahb[0] = a * J[0] * J[0] + b * J[1] * J[1];
    ahb[1] = J[1] * (a * J[0] + b * J[2]);
    ahb[2] = a * J[1] * J[1] + b * J[2] * J[2];
}

/* Which points a pass goes through, and which equations it makes. */
typedef struct {
    size_t n, stride; /* takes one in `stride` of the first n observations */
    int equations;
} pass_kind;

/* (B5) Makes the equations of a pinhole or Brown's lens, without H if H is NULL. The loop
 * is written out because a search spends its time here. */
RIGCAL_FORCE_INLINE static inline rigcal_status go_through(
    rigcal_real *sum, rigcal_real g[6], rigcal_real H[21], const rigcal_points *points,
    const rigcal_transform *T, const pass_kind *pass, int is_pinhole)
{
    const rigcal_camera *const camera = points->view.camera;
    const rigcal_real fx = camera->fx, fy = camera->fy;
    rigcal_real total = 0;
    size_t more = 0; /* every other stride is longer, so that a pass does not follow a row
                        of a grid */
    for (size_t i = rc_points_next(points, 0); i < pass->n;
         i = rc_points_next(points, i + pass->stride + more)) {
        const rigcal_real *const uv = points->view.observations[i].uv;
        const rigcal_real weight = rc_points_weight(points, i);
        more = (pass->stride > 1) ? 1 - more : 0;
        rigcal_real X[3], q[3], J[3], uvm[3];
        rc_points_at(X, points, i);
        rc_mat3_mul_vec3(q, T->R, X);
        const rigcal_real Z = q[2] + T->t[2], by_Z = 1 / Z;
        const rigcal_real x[2] = {(q[0] + T->t[0]) * by_Z, (q[1] + T->t[1]) * by_Z};
        rigcal_real F[2] = {x[0], x[1]};
        if (!(Z > 0)) {
            return RIGCAL_ERR_BEHIND;
        }
        if (!is_pinhole && !rc_lens_map(F, J, camera, x)) {
            return RIGCAL_ERR_NO_RAY;
        }
        const rigcal_real bu = fx * by_Z, bv = fy * by_Z, wu = weight * bu,
                          wv = weight * bv;
        const rigcal_real eu = uv[0] - (fx * F[0] + camera->cx);
        const rigcal_real ev = uv[1] - (fy * F[1] + camera->cy);
        rigcal_real c[2] = {wu * eu, wv * ev}, ahb[3] = {wu * bu, 0, wv * bv};
        if (!is_pinhole) {
            pull_back(c, ahb, J);
        }
        total += weight * (eu * eu + ev * ev);
        add_force(g, q, x, c);
        if (H == NULL) {
            continue;
        }
        column_of(uvm, ahb, x, is_pinhole);
        if (pass->equations != RC_GAUSS_NEWTON) {
            add_bend(H, uvm, q, x, c, by_Z);
        }
        add_in_plane(H, q, ahb, uvm, is_pinhole);
    }
    *sum = total;
    return rc_is_finite(total) ? RIGCAL_OK : RIGCAL_ERR_NO_RAY;
}

RC_APART static rigcal_status pinhole_equations(rigcal_real *sum, rigcal_refinement *state,
                                                const rigcal_points *points,
                                                const pass_kind *pass)
{
    return go_through(sum, state->g, state->H, points, &state->cam_from_points, pass, 1);
}

RC_APART static rigcal_status lens_equations(rigcal_real *sum, rigcal_refinement *state,
                                             const rigcal_points *points,
                                             const pass_kind *pass)
{
    return go_through(sum, state->g, state->H, points, &state->cam_from_points, pass, 0);
}

RC_APART static rigcal_status pinhole_force(rigcal_real *sum, rigcal_refinement *state,
                                            const rigcal_points *points,
                                            const pass_kind *pass)
{
    return go_through(sum, state->g, NULL, points, &state->cam_from_points, pass, 1);
}

RC_APART static rigcal_status lens_force(rigcal_real *sum, rigcal_refinement *state,
                                         const rigcal_points *points, const pass_kind *pass)
{
    return go_through(sum, state->g, NULL, points, &state->cam_from_points, pass, 0);
}

static rigcal_status plane_equations(rigcal_real *sum, rigcal_refinement *state,
                                     const rigcal_points *points, const pass_kind *pass)
{
    rc_rigid_clear(state->g, state->H);
    return points->is_pinhole ? pinhole_equations(sum, state, points, pass)
                              : lens_equations(sum, state, points, pass);
}

/* The same without H. */
static rigcal_status plane_force(rigcal_real *sum, rigcal_refinement *state,
                                 const rigcal_points *points, const pass_kind *pass)
{
    rc_clear(state->g, 6);
    return points->is_pinhole ? pinhole_force(sum, state, points, pass)
                              : lens_force(sum, state, points, pass);
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

/* Computes the step from where `state` is. *gain gets the gain that the full step promises.
 * Returns 0 if H is not positive definite. */
RC_APART_FAST static int damped_step(rigcal_real d[6], rigcal_real *gain,
                                     const rigcal_refinement *state)
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
    state->is_approach = (uint8_t)is_wide;
    if (RC_FOR_SPEED) {
        state->is_part = 0;
    }
}

void rc_refine_begin_part(rigcal_refinement *state, const rigcal_points *points)
{
    state->is_part = RC_FOR_SPEED && points->n_used >= 2 * PART &&
                     !rc_lens_is_fisheye(points->view.camera);
}

/* Computes *sum, state->g and state->H where `state` is. Without `with_H` it leaves H as it
 * was, if that is quicker. */
static rigcal_status evaluate(rigcal_real *sum, rigcal_refinement *state,
                              const rigcal_points *points, int with_H)
{
    if (RC_FOR_SPEED && !rc_lens_is_fisheye(points->view.camera)) {
        const pass_kind pass = {points->view.n, 1, state->search.equations};
        return (with_H || pass.equations != RC_GAUSS_NEWTON)
                   ? plane_equations(sum, state, points, &pass)
                   : plane_force(sum, state, points, &pass);
    }
    return rc_refine_equations(sum, state->g, state->H, points, points->view.n,
                               &state->cam_from_points, state->search.equations);
}

/* Makes a step by some of the points, which costs nearly nothing. It is never refused: all
 * points go on from wherever it ends. */
RC_APART static void part_step(rigcal_refinement *state, const rigcal_points *points)
{
    rigcal_real sum, gain, d[6];
    const pass_kind pass = {points->view.n, points->n_used / PART, RC_GAUSS_NEWTON};
    if (plane_equations(&sum, state, points, &pass) == RIGCAL_OK &&
        damped_step(d, &gain, state)) {
        rc_transform_move(&state->cam_from_points, d);
    }
    state->is_part = 0;
}

/* Adds the equations of point i, seen along ray m. Returns what it adds to the sum. */
RC_APART_FAST static rigcal_real add_along(rigcal_refinement *state,
                                           const rigcal_points *points, size_t i,
                                           const rigcal_real m[3])
{
    rigcal_real e[2], B[6], q[3], X_c[3];
    rc_points_place(q, X_c, points, &state->cam_from_points, i);
    rc_residual_along_ray(e, B, points->view.camera, points->is_pinhole, m, X_c);
    const rigcal_real weight = rc_points_weight(points, i) / rc_vec3_dot(X_c, X_c);
    rc_rigid_add(state->g, state->H, B, q, e, weight, NULL, 0);
    return weight * (e[0] * e[0] + e[1] * e[1]);
}

/* Makes a step of Gauss and Newton on errors along the rays. It is neither damped nor
 * refused. The weights of rays far off the axis make a steep and winding valley, which
 * small steps would follow for long. */
RC_APART_FAST static void approach(rigcal_refinement *state, const rigcal_points *points)
{
    const rigcal_view *const view = &points->view;
    rigcal_real d[6], gain = 0, sum = 0;
    rc_rigid_clear(state->g, state->H);
    for (size_t i = rc_points_next(points, 0); i < view->n;
         i = rc_points_next(points, i + 1)) {
        rigcal_real *const m = d; /* holds a ray until there is a step */
        (void)rc_pixel_to_ray(m, view->camera, view->observations[i].uv);
        sum += add_along(state, points, i, m);
    }
    if (damped_step(d, &gain, state)) {
        rc_transform_move(&state->cam_from_points, d);
    }
    if (gain <= APPROACHED * sum || state->evals == APPROACH_STEPS) {
        state->is_approach = 0;
    }
}

/* Moves by the next step, if there is one. Returns 1 if the step is to be tried. */
static int move_on(rigcal_real d[6], rigcal_real *gain, rigcal_refinement *state,
                   const rigcal_points *points)
{
    if (!damped_step(d, gain, state)) {
        rc_levenberg_not_definite(&state->search);
        return 0;
    }
    const int step = rc_levenberg_promised(&state->search, *gain, points->negligible);
    if (step == RC_STEP_NONE) {
        return 0;
    }
    rc_transform_move(&state->cam_from_points, d);
    return step == RC_STEP_TRY;
}

/* Evaluates the equations where `state` is, or makes a step. A step that does harm is
 * undone by the inverse turn, which saves a copy of the rotation. */
RC_APART_FAST static void search(rigcal_refinement *state, const rigcal_points *points)
{
    rigcal_levenberg *const lm = &state->search;
    rigcal_transform *const pose = &state->cam_from_points;
    rigcal_real d[6], t[3], gain = 0, sum = 0;
    const int is_step = lm->want != RC_WANT_EQUATIONS;
    rc_vec3_copy(t, pose->t);
    if (is_step && !move_on(d, &gain, state, points)) {
        return;
    }
    const int is_same_H = RC_FOR_SPEED && is_step && gain <= SAME_H * lm->sum;
    const rigcal_status status = evaluate(&sum, state, points, !is_same_H);
    if (!is_step) {
        rc_levenberg_evaluated(lm, status, sum);
    } else if (!rc_levenberg_tried(lm, status, sum, gain, points->negligible)) {
        rc_vec3_scale(d, -1, d);
        rc_transform_move(pose, d);
        rc_vec3_copy(pose->t, t);
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
    } else if (RC_FOR_SPEED && state->is_part) {
        part_step(state, points);
    } else {
        search(state, points);
    }
    if (state->search.status == RIGCAL_RUNNING && state->evals >= max_evals) {
        state->search.status = RIGCAL_BUDGET_SPENT;
    }
}
