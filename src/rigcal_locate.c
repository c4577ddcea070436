#include "rc_locate.h"

/* What the next view is used for. */
enum { RAYS, EVALUATE, COVARIANCE };

rc_sighted *rc_sights_of(const rigcal_point_solver *p)
{
    return (rc_sighted *)(void *)p->sightings->work;
}

size_t rc_sight_number(const rigcal_point_solver *p, size_t k)
{
    return (size_t)rc_sights_of(p)[k].order;
}

static void clear_equations(rigcal_point_solver *p)
{
    for (int k = 0; k < 6; k++) {
        p->H[k] = 0;
        p->g[k / 2] = 0;
    }
}

static void begin_views(rigcal_point_solver *p, int32_t stage)
{
    p->stage = stage;
    p->view = 0;
}

static void end(rigcal_point_solver *p, rigcal_status status)
{
    p->located = status;
}

/* ---- the start ------------------------------------------------------------ */

rigcal_real rc_sight_aside(const rc_sighted *a, const rc_sighted *b)
{
    rigcal_real normal[3];
    rc_vec3_cross(normal, a->ray, b->ray);
    return rc_vec3_dot(normal, normal);
}

rigcal_real rc_locate_parallax(const rigcal_point_solver *p)
{
    return RC_ATAN2(RC_SQRT(p->aside), RC_SQRT(rc_max(0, 1 - p->aside)));
}

/* ---- the search ---------------------------------------------------------- */

static void begin_equations(rigcal_point_solver *p)
{
    clear_equations(p);
    p->sum = 0;
    begin_views(p, EVALUATE);
}

/* L L^T = A, without damping. Returns 0 if A is not positive definite. */
static int factor(rigcal_real L[6], const rigcal_real A[6])
{
    const rigcal_real diagonal[3] = {A[0], A[3], A[5]};
    return rc_sym3_factor(L, A, diagonal, 0);
}

static void begin_covariance(rigcal_point_solver *p)
{
    rigcal_real L[6];
    if (!factor(L, p->H)) {
        end(p, RIGCAL_ERR_PARALLEL);
        return;
    }
    for (int k = 0, at = 0; k < 3; at += 3 - k, k++) {
        rigcal_real row[3] = {0, 0, 0};
        row[k] = 1;
        rc_point_solve(row, L);
        for (int j = k; j < 3; j++) {
            p->sums.N[at + j - k] = row[j];
        }
    }
    for (int k = 0; k < 6; k++) {
        p->sums.Sigma[k] = p->sums.N[k];
        p->sums.M[k] = 0;
        p->sums.c[k / 2] = 0;
    }
    p->sums.q = 0;
    begin_views(p, COVARIANCE);
}

/* Begins one step of the search. Returns 0 if there is no point to evaluate. */
static int take_step(rigcal_point_solver *p)
{
    rigcal_real L[6], step[3];
    p->evals++;
    p->is_tried = p->search.want != RC_WANT_EQUATIONS;
    if (!p->is_tried) {
        return 1;
    }
    if (!rc_point_factor(L, p->H, p->search.lambda)) {
        rc_levenberg_not_definite(&p->search);
        return 0;
    }
    rc_vec3_copy(step, p->g);
    rc_point_solve(step, L);
    rc_vec3_copy(p->before, p->X);
    p->gain = rc_vec3_dot(p->g, step);
    const int taken = rc_levenberg_promised(&p->search, p->gain, p->negligible);
    if (taken != RC_STEP_NONE) {
        rc_vec3_add(p->X, step);
    }
    return taken == RC_STEP_TRY;
}

static void go_on(rigcal_point_solver *p)
{
    while (p->search.status == RIGCAL_RUNNING && p->evals < RC_TRIANGULATION_EVALS) {
        if (take_step(p)) {
            begin_equations(p);
            return;
        }
    }
    if (p->search.status < 0) {
        end(p, (p->search.status == RIGCAL_ERR_DEGENERATE) ? RIGCAL_ERR_PARALLEL
                                                           : p->search.status);
    } else if (p->is_stale) { /* the equations are computed anew where the search ends */
        p->is_tried = 0;
        begin_equations(p);
    } else {
        begin_covariance(p);
    }
}

static void begin_search(rigcal_point_solver *p)
{
    const rigcal_real least = p->sightings->parallax_least;
    if (!(p->aside >= RC_PARALLAX_MIN) || (least > 0 && rc_locate_parallax(p) < least) ||
        !rc_point_factor(p->H, p->H, 0)) {
        end(p, RIGCAL_ERR_PARALLEL);
        return;
    }
    rc_point_solve(p->g, p->H);
    rc_vec3_copy(p->X, p->g);
    p->is_stale = 0;
    rc_levenberg_begin(&p->search, 0);
    go_on(p);
}

/* Adds a ray to sum (I - d d^T) (X - o) = 0, o = -R^T t, d along the ray. */
static void add_ray(rigcal_point_solver *p)
{
    const rigcal_sightings *const s = p->sightings;
    const size_t i = rc_sight_number(p, p->view);
    const rc_sighted *const v = &rc_sights_of(p)[i];
    const rigcal_transform *const T = &s->rig->cameras[s->seen[i].camera].cam_from_rig;
    rigcal_real o[3];
    if (!(rc_vec3_dot(v->ray, v->ray) > 0)) {
        end(p, RIGCAL_ERR_NO_RAY);
        return;
    }
    rc_mat3_tmul_vec3(o, T->R, T->t);
    rc_vec3_add_scaled(p->g, rc_vec3_dot(v->ray, o), v->ray);
    rc_vec3_add_scaled(p->g, -1, o);
    rc_sym3_add_outer(p->H, -1, v->ray);
    for (size_t k = 0; k < p->view; k++) {
        p->aside =
            rc_max(p->aside, rc_sight_aside(v, &rc_sights_of(p)[rc_sight_number(p, k)]));
    }
    if (++p->view == p->n_used) {
        begin_search(p);
    }
}

/* Goes on after all views have been evaluated at X, or after one of them failed. */
static void evaluated(rigcal_point_solver *p, rigcal_status status)
{
    if (p->is_stale && p->search.status != RIGCAL_RUNNING) {
        begin_covariance(p);
        return;
    }
    p->is_stale = 0;
    if (!p->is_tried) {
        rc_levenberg_evaluated(&p->search, status, p->sum);
    } else if (!rc_levenberg_tried(&p->search, status, p->sum, p->gain, p->negligible)) {
        rc_vec3_copy(p->X, p->before);
        p->is_stale = 1;
    }
    rc_vec3_copy(p->before, p->X);
    go_on(p);
}

static void evaluate_view(rigcal_point_solver *p)
{
    const size_t i = rc_sight_number(p, p->view);
    rc_sighted *const v = &rc_sights_of(p)[i];
    rigcal_status status = rc_sight_evaluate(v, p->sightings, i, p->X);
    if (status != RIGCAL_OK) {
        evaluated(p, status);
        return;
    }
    for (int row = 0; row < 2; row++) {
        const rigcal_real *const A = &v->A[3 * row];
        rc_vec3_add_scaled(p->g, v->weight * v->e[row], A);
        rc_sym3_add_outer(p->H, v->weight, A);
        p->sum += v->weight * v->e[row] * v->e[row];
    }
    if (++p->view == p->n_used) {
        evaluated(p, rc_is_finite(p->sum) ? RIGCAL_OK : RIGCAL_ERR_NO_RAY);
    }
}

/* ---- its covariance ------------------------------------------------------- */

/* Ends if the rig's covariance is not positive definite, or is not finite. */
static void end_without_covariance(rigcal_point_solver *p)
{
    end(p, rc_all_finite(p->sums.Sigma, 6) ? RIGCAL_ERR_DEGENERATE : RIGCAL_ERR_NOT_FINITE);
}

/* Also sets chi2, the minimum of e^T V^-1 e over X: a move of X to there lowers the sum at
 * the present X by c^T M^-1 c. */
static void add_covariance(rigcal_point_solver *p)
{
    const size_t i = rc_sight_number(p, p->view);
    rc_sighted *const v = &rc_sights_of(p)[i];
    rigcal_real L[6], x[3];
    const rigcal_status status = rc_sight_move(v, p->sightings, i, p->X);
    if (status != RIGCAL_OK) {
        end(p, status);
        return;
    }
    if (!rc_sight_add(&p->sums, rc_sights_of(p), p->view, p->sightings->rig->Sigma)) {
        end_without_covariance(p);
        return;
    }
    if (++p->view < p->n_used) {
        return;
    }
    if (!factor(L, p->sums.M) || !rc_all_finite(p->sums.Sigma, 6)) {
        end_without_covariance(p);
        return;
    }
    rc_vec3_copy(x, p->sums.c);
    rc_point_solve(x, L);
    p->chi2 = rc_max(0, p->sums.q - rc_vec3_dot(x, p->sums.c));
    end(p, (p->search.status == RIGCAL_OK) ? RIGCAL_OK : RIGCAL_BUDGET_SPENT);
}

/* ---- one view ------------------------------------------------------------ */

void rc_locate_begin(rigcal_point_solver *p, size_t n_used)
{
    const rigcal_real n = (rigcal_real)n_used;
    p->n_used = n_used;
    p->evals = 0;
    p->aside = 0;
    clear_equations(p);
    p->H[0] = p->H[3] = p->H[5] = n;
    p->located = RIGCAL_RUNNING;
    begin_views(p, RAYS);
}

rigcal_status rc_locate_step(rigcal_point_solver *p)
{
    if (p->stage == RAYS) {
        add_ray(p);
    } else if (p->stage == EVALUATE) {
        evaluate_view(p);
    } else {
        add_covariance(p);
    }
    return p->located;
}
