#include "rc_adjust.h"

/* ---- views by a loss of their points ------------------------------------- */

/* The loss of a squared error, which is divided by sigma^2. *weight is its weight in least
 * squares. */
static rigcal_real loss_of(rigcal_real *weight, rigcal_real error2, int32_t loss)
{
    const rigcal_real from =
        (loss == RIGCAL_LOSS_HUBER) ? RC_HUBER_FROM : RC_TRUNCATED_FROM;
    *weight = 1;
    if (error2 <= from * from) {
        return error2;
    }
    if (loss == RIGCAL_LOSS_HUBER) {
        const rigcal_real error = RC_SQRT(error2);
        *weight = from / error;
        return from * (2 * error - from);
    }
    *weight = 0;
    return from * from;
}

/* The equations of a view. A point that its camera cannot see counts as an error above any
 * limit. */
static rigcal_status equations_by_loss(rigcal_real *sum, rigcal_real g[6],
                                       rigcal_real H[21], rc_chain *chain, int32_t *camera,
                                       const rigcal_rig_solver *s)
{
    rigcal_points points;
    rigcal_rig_view v;
    const rigcal_real sigma2 = s->rig->sigma_px * s->rig->sigma_px;
    rigcal_status status = rc_rig_view_at(&v, s->rig, s->view);
    if (status != RIGCAL_OK) {
        return status;
    }
    *camera = v.camera;
    rc_rig_chain(chain, s->rig, v.camera, s->placement, s->view);
    rc_rig_points_of(&points, &v);
    rc_rigid_clear(g, H);
    *sum = 0;
    for (size_t i = 0; i < v.view.n; i++) {
        rigcal_real e[2], B[6], q[3], X_c[3], weight, error2 = RC_MAX;
        status = rc_points_residual(e, B, q, X_c, &points, &chain->cam_from_target, i);
        if (status != RIGCAL_OK && s->loss == RIGCAL_LOSS_HUBER) {
            return status;
        }
        const rigcal_real of_point = rc_points_weight(&points, i);
        if (status == RIGCAL_OK) {
            error2 = of_point * (e[0] * e[0] + e[1] * e[1]) / sigma2;
        }
        *sum += sigma2 * loss_of(&weight, error2, s->loss);
        if (weight > 0) {
            rc_rigid_add(g, H, B, q, e, of_point * weight, NULL, 0);
        }
    }
    return rc_is_finite(*sum) ? RIGCAL_OK : RIGCAL_ERR_NO_RAY;
}

static const struct rigcal_rig_given GIVEN_LOSS = {rc_rig_check_points, equations_by_loss,
                                                   rc_rig_step, rc_rig_move, 0};

rigcal_status rigcal_rig_robust_begin(rigcal_rig_solver *solver, rigcal_rig *rig,
                                      int32_t loss)
{
    if (loss != RIGCAL_LOSS_HUBER && loss != RIGCAL_LOSS_TRUNCATED) {
        return RIGCAL_ERR_RANGE;
    }
    if (rig != NULL && !(rig->sigma_px > 0)) {
        return rc_is_finite(rig->sigma_px) ? RIGCAL_ERR_RANGE : RIGCAL_ERR_NOT_FINITE;
    }
    const rigcal_status status = rc_rig_begin_points(solver, rig, &GIVEN_LOSS);
    if (status == RIGCAL_OK) {
        solver->loss = loss;
    }
    return status;
}

/* ---- points that are wrong ----------------------------------------------- */

/* Number of wrong points of one view. */
static size_t count_wrong(const rigcal_rig *rig, const rigcal_rig_view *v, size_t view)
{
    rigcal_points points;
    rc_chain chain;
    size_t n = 0;
    const rigcal_real limit = RC_TRUNCATED_FROM * rig->sigma_px;
    rc_rig_chain(&chain, rig, v->camera, (size_t)v->placement, view);
    rc_rig_points_of(&points, v);
    for (size_t i = 0; i < v->view.n; i++) {
        n += !(rc_points_error2(&points, &chain.cam_from_target, i) <= limit * limit);
    }
    return n;
}

rigcal_status rigcal_rig_robust_result(rigcal_rig_fit *fit, size_t *n_wrong,
                                       int32_t *at_fault, const rigcal_rig_solver *solver)
{
    rigcal_rig_fit found;
    size_t n = 0;
    if (at_fault != NULL) {
        *at_fault = -1;
    }
    if (fit == NULL || n_wrong == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status outcome = rigcal_rig_result(&found, at_fault, solver);
    if (outcome < 0) {
        return outcome;
    }
    const rigcal_rig *const rig = solver->rig;
    for (size_t i = 0; i < rig->n_views; i++) {
        rigcal_rig_view v;
        if (!rc_rig_is_left_out(rig, i)) {
            const rigcal_status status = rc_rig_view_at(&v, rig, i);
            if (status != RIGCAL_OK) {
                return status;
            }
            n += count_wrong(rig, &v, i);
        }
    }
    const rigcal_real lost = 2 * (rigcal_real)(int32_t)n;
    const rigcal_real limit = RC_TRUNCATED_FROM * rig->sigma_px;
    if (solver->loss == RIGCAL_LOSS_TRUNCATED) {
        found.sum = rc_max(0, found.sum - lost / 2 * limit * limit);
        found.freedom = rc_max(0, found.freedom - lost);
        found.n_points -= n;
    }
    found.sigma_px = (found.freedom > 0) ? RC_SQRT(found.sum / found.freedom) : 0;
    found.F = found.freedom_between = found.freedom_within = 0;
    *fit = found;
    *n_wrong = n;
    return outcome;
}

rigcal_status rigcal_rig_adjust_robust(rigcal_rig_fit *fit, size_t *n_wrong,
                                       int32_t *at_fault, rigcal_rig *rig)
{
    static const int32_t LOSSES[2] = {RIGCAL_LOSS_HUBER, RIGCAL_LOSS_TRUNCATED};
    rigcal_rig_solver solver;
    rigcal_status status = (fit == NULL || n_wrong == NULL) ? RIGCAL_ERR_NULL : RIGCAL_OK;
    if (at_fault != NULL) {
        *at_fault = -1;
    }
    for (int k = 0; k < 2 && status >= 0; k++) {
        status = rigcal_rig_robust_begin(&solver, rig, LOSSES[k]);
        if (status != RIGCAL_OK) {
            return status;
        }
        while (rigcal_rig_step(&solver, 100) == RIGCAL_RUNNING) {
        }
        status = rc_rig_outcome(at_fault, &solver);
    }
    return (status >= 0) ? rigcal_rig_robust_result(fit, n_wrong, at_fault, &solver)
                         : status;
}
