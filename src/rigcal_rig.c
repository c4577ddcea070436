#include "rc_adjust.h"
#include "rc_joint.h"

rigcal_status rigcal_view_pose_make(rigcal_view_pose *pose, const rigcal_rig_view *view,
                                    const rigcal_transform *cam_from_target)
{
    if (pose == NULL || view == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_points points;
    rigcal_status status = rc_rig_points(&points, view);
    if (status == RIGCAL_OK) {
        status = rc_check_transform(cam_from_target);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    rigcal_real sum, g[6], H[21];
    rc_sym6_factor L;
    status = rc_rig_equations(&sum, g, H, view, cam_from_target);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!rc_sym6_factor_of(&L, H, 0)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    pose->cam_from_target = *cam_from_target;
    for (int k = 0; k < 21; k++) {
        pose->information[k] = H[k];
    }
    pose->sse = sum;
    pose->n = points.n_used;
    pose->camera = view->camera;
    pose->placement = view->placement;
    return RIGCAL_OK;
}

/* ---- the adjustment ------------------------------------------------------ */

rigcal_status rigcal_rig_begin(rigcal_rig_solver *solver, rigcal_rig *rig)
{
    return rc_rig_begin_points(solver, rig, &rc_given_points);
}

rigcal_status rigcal_rig_step(rigcal_rig_solver *solver, int32_t budget)
{
    const rigcal_status status =
        rc_check_step((solver == NULL) ? NULL : &solver->phase, budget);
    if (status != RIGCAL_OK) {
        return status;
    }
    for (; budget > 0 && solver->phase != RC_RIG_DONE; budget--) {
        solver->given->step(solver);
    }
    return (solver->phase == RC_RIG_DONE) ? RIGCAL_OK : RIGCAL_RUNNING;
}

static rigcal_real real_of(size_t n)
{
    return (rigcal_real)(int32_t)n;
}

static void fill_fit(rigcal_rig_fit *fit, const rigcal_rig_solver *s)
{
    const rigcal_real measured = 2 * real_of(s->n_points);
    const rigcal_real freedom =
        measured - 6 * real_of(s->n_free + s->n_seen) - real_of(s->n_clocks);
    const rigcal_real within = measured - 6 * real_of(s->n_used);
    const rigcal_real between = freedom - within;
    *fit = (rigcal_rig_fit){0};
    fit->sum = s->search.sum + (s->is_join ? s->own_sum : 0);
    fit->freedom = freedom;
    fit->sigma_px = (freedom > 0) ? RC_SQRT(fit->sum / freedom) : 0;
    fit->n_points = s->n_points;
    fit->evals = s->evals;
    if (s->own_sum > 0 && within > 0 && between > 0) {
        fit->F = rc_max(0, fit->sum / s->own_sum - 1) * within / between;
        fit->freedom_between = between;
        fit->freedom_within = within;
    }
}

rigcal_status rigcal_rig_result(rigcal_rig_fit *fit, int32_t *at_fault,
                                const rigcal_rig_solver *solver)
{
    if (at_fault != NULL) {
        *at_fault = -1;
    }
    if (fit == NULL || solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (solver->phase != RC_RIG_DONE) {
        return RIGCAL_ERR_STATE;
    }
    const rigcal_status status = rc_rig_outcome(at_fault, solver);
    if (status >= 0) {
        fill_fit(fit, solver);
    }
    return status;
}

rigcal_status rigcal_rig_adjust(rigcal_rig_fit *fit, int32_t *at_fault, rigcal_rig *rig)
{
    rigcal_rig_solver solver;
    if (at_fault != NULL) {
        *at_fault = -1;
    }
    if (fit == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = rigcal_rig_begin(&solver, rig);
    if (status != RIGCAL_OK) {
        return status;
    }
    while (rigcal_rig_step(&solver, 100) == RIGCAL_RUNNING) {
    }
    return rigcal_rig_result(fit, at_fault, &solver);
}

/* ---- how sure ------------------------------------------------------------ */

/* Checks the arguments of a function that computes the covariance of a pose. *parts says
 * where the parts of rig->work begin. */
static rigcal_status check_sure(const rigcal_real *Sigma, const rigcal_rig *rig,
                                rigcal_real sigma_px, size_t camera, rc_rig_parts *parts)
{
    if (Sigma == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_rig_check(rig);
    if (status == RIGCAL_OK) {
        status = rc_check_noise(&sigma_px);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    if (camera >= rig->n_cameras) {
        return RIGCAL_ERR_RANGE;
    }
    return rc_rig_is_adjusted(parts, rig) ? RIGCAL_OK : RIGCAL_ERR_STATE;
}

rigcal_status rigcal_rig_covariance(rigcal_real Sigma[36], const rigcal_rig *rig,
                                    rigcal_real sigma_px, size_t camera)
{
    rc_rig_parts parts;
    const rigcal_status status = check_sure(Sigma, rig, sigma_px, camera, &parts);
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_joint_block(Sigma, parts.S, parts.column[camera], parts.column[camera]);
    for (int k = 0; k < 36; k++) {
        Sigma[k] *= sigma_px * sigma_px;
    }
    if (rig->considered != NULL) {
        rig->considered->by->camera(Sigma, rig, camera);
    }
    return RIGCAL_OK;
}

/* The sum of A_ij B_ij: the trace of A B^T. */
static rigcal_real trace_of_product(const rigcal_real A[36], const rigcal_real B[36])
{
    rigcal_real sum = 0;
    for (int k = 0; k < 36; k++) {
        sum += A[k] * B[k];
    }
    return sum;
}

rigcal_status rigcal_rig_pair(rigcal_transform *b_from_a, rigcal_real Sigma[36],
                              const rigcal_rig *rig, rigcal_real sigma_px, size_t a,
                              size_t b)
{
    rc_rig_parts parts;
    rigcal_status status = check_sure(Sigma, rig, sigma_px, a, &parts);
    if (status == RIGCAL_OK && (b_from_a == NULL || b >= rig->n_cameras)) {
        status = (b_from_a == NULL) ? RIGCAL_ERR_NULL : RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK && rig->group[a] != rig->group[b]) {
        status = RIGCAL_DISCONNECTED;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_joint_pair(b_from_a, Sigma, &rig->cams_from_rig[a], &rig->cams_from_rig[b], parts.S,
                  parts.column[a], parts.column[b], sigma_px * sigma_px);
    if (rig->considered != NULL) {
        rig->considered->by->pair(Sigma, b_from_a, rig, a, b);
    }
    return RIGCAL_OK;
}

/* Checks the same, and that no placement has more views than there are cameras. */
static rigcal_status check_counts(const rigcal_real *Sigma, const rigcal_rig *rig,
                                  rigcal_real sigma_px)
{
    rc_rig_parts parts;
    rigcal_status status = check_sure(Sigma, rig, sigma_px, 0, &parts);
    for (size_t f = 0; status == RIGCAL_OK && f < rig->n_placements; f++) {
        if (!(RC_FABS(parts.count[f]) <= (rigcal_real)rig->n_cameras)) {
            status = RIGCAL_ERR_STATE;
        }
    }
    return status;
}

/* The equations of one view, with the poses as they are. */
static rigcal_status equations_of(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                                  rc_chain *chain, rigcal_rig_view *v,
                                  const rigcal_rig *rig, size_t view)
{
    const rigcal_status status = rc_rig_view_at(v, rig, view);
    if (status != RIGCAL_OK) {
        return status;
    }
    return rc_rig_view_equations(sum, g, H, chain, v, rig, view);
}

/* Covariances of the pose of a placement, for noise of 1 px. `first` is its first view.
 * Sigma is the whole covariance, `inverse` = H^-1 the placement's own part. `on` says how
 * the pose depends on the cameras, d = -H^-1 sum of W_i^T d_i. */
static rigcal_status place_sure(rigcal_real Sigma[36], rigcal_real inverse[36],
                                const rc_leverage *on, const rigcal_rig *rig, size_t first)
{
    rigcal_real sum, g[6], H[21], g_placement[6], H_placement[21], spread[36], half[36];
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, rig, 0);
    rc_rigid_clear(g_placement, H_placement);
    for (size_t i = 0; i < on->count; i++) {
        rigcal_rig_view v;
        rc_chain chain;
        on->at[i] = -1;
        if (rc_rig_is_left_out(rig, first + i)) {
            continue;
        }
        const rigcal_status status = equations_of(&sum, g, H, &chain, &v, rig, first + i);
        if (status != RIGCAL_OK) {
            return status;
        }
        rc_chain_add_placement(g_placement, H_placement, &chain, g, H);
        rc_chain_camera(g, H, &on->W[36 * i], &chain);
        on->at[i] = parts.column[v.camera];
    }
    if (!rc_sym6_invert(inverse, H_placement)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    rc_joint_spread(spread, on);
    rc_clear(half, 36);
    rc_mat6_add_product(half, spread, inverse, 0);
    for (int k = 0; k < 36; k++) {
        Sigma[k] = inverse[k];
    }
    rc_mat6_add_product(Sigma, inverse, half, 0);
    return RIGCAL_OK;
}

rigcal_status rigcal_rig_placement(rigcal_real Sigma[36], rigcal_rig *rig,
                                   rigcal_real sigma_px, size_t placement)
{
    rc_rig_parts parts;
    rigcal_real inverse[36], more[36];
    size_t first = 0;
    rigcal_status status = check_counts(Sigma, rig, sigma_px);
    if (status == RIGCAL_OK && placement >= rig->n_placements) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_rig_parts_of(&parts, rig, 0);
    if (!(parts.count[placement] > 0)) {
        return RIGCAL_ERR_TOO_FEW;
    }
    for (size_t f = 0; f < placement; f++) {
        first += rc_rig_views_of(&parts, f);
    }
    const size_t count = rc_rig_views_of(&parts, placement);
    const rc_leverage on = {parts.S, parts.W, parts.slot, count};
    rc_clear(more, 36);
    if (rig->considered != NULL) {
        status = rig->considered->by->placement(more, rig, first, count, placement);
    }
    if (status == RIGCAL_OK) {
        status = place_sure(Sigma, inverse, &on, rig, first);
    }
    if (status == RIGCAL_OK) {
        rc_mat6_make_symmetric(Sigma, sigma_px * sigma_px);
        for (int k = 0; k < 36; k++) {
            Sigma[k] += more[k];
        }
    }
    return status;
}

/* ---- noise of each camera ------------------------------------------------ */

/* Adds a view to its camera's sum and freedom. T is the pose of the view, from camera and
 * placement. The unknowns lower the freedom of the points by trace(H Cov(T)). */
static rigcal_status add_noise(rigcal_real sum[], rigcal_real freedom[],
                               const rigcal_real Sigma[36], const rigcal_real inverse[36],
                               const rc_leverage *on, const rigcal_rig *rig, size_t first,
                               size_t i)
{
    rigcal_rig_view v;
    rc_chain chain;
    rigcal_real sse, g[6], H[21], g_placement[6], H_placement[21], M[36], Z[36];
    const rigcal_status status = equations_of(&sse, g, H, &chain, &v, rig, first + i);
    if (status != RIGCAL_OK) {
        return status;
    }
    const size_t c = (size_t)v.camera;
    rc_rigid_clear(g_placement, H_placement);
    rc_chain_add_placement(g_placement, H_placement, &chain, g, H);
    rc_sym6_unpack(M, H_placement);
    rigcal_real lost = trace_of_product(M, Sigma);
    rc_chain_camera(g, H, &on->W[36 * i], &chain);
    rc_sym6_unpack(M, H);
    rc_joint_block(Z, on->S, on->at[i], on->at[i]);
    lost += trace_of_product(M, Z);
    rc_joint_across(Z, on, i);
    rc_clear(M, 36);
    rc_mat6_add_product(M, &on->W[36 * i], Z, 1);
    lost -= 2 * trace_of_product(M, inverse);
    sum[c] += sse;
    freedom[c] += 2 * real_of(v.view.n) - lost;
    return RIGCAL_OK;
}

rigcal_status rigcal_rig_noise(rigcal_real sigma_px[], rigcal_real freedom[],
                               rigcal_rig *rig)
{
    rc_rig_parts parts;
    rigcal_real Sigma[36], inverse[36];
    size_t first = 0;
    rigcal_status status =
        (freedom == NULL) ? RIGCAL_ERR_NULL : check_counts(sigma_px, rig, 0);
    if (status != RIGCAL_OK) {
        return status;
    }
    /* Outputs are written at the end only. Until then the sums are in the memory where the
     * adjustment kept poses. */
    rc_rig_parts_of(&parts, rig, 0);
    rigcal_real *const sum = parts.saved[0].R, *const left = sum + rig->n_cameras;
    rc_clear(sum, 2 * rig->n_cameras);
    for (size_t f = 0; f < rig->n_placements && status == RIGCAL_OK; f++) {
        const rc_leverage on = {parts.S, parts.W, parts.slot, rc_rig_views_of(&parts, f)};
        if (parts.count[f] > 0) {
            status = place_sure(Sigma, inverse, &on, rig, first);
        }
        for (size_t i = 0; i < on.count && status == RIGCAL_OK; i++) {
            if (!rc_rig_is_left_out(rig, first + i)) {
                status = add_noise(sum, left, Sigma, inverse, &on, rig, first, i);
            }
        }
        first += on.count;
    }
    for (size_t c = 0; c < rig->n_cameras && status == RIGCAL_OK; c++) {
        sigma_px[c] = (left[c] > 0) ? RC_SQRT(sum[c] / left[c]) : 0;
        freedom[c] = left[c];
    }
    return status;
}

/* ---- what is left -------------------------------------------------------- */

rigcal_status rigcal_rig_residuals(rigcal_real duv[], size_t capacity, size_t *n_written,
                                   const rigcal_rig *rig, size_t view)
{
    rigcal_rig_view v = {{NULL, NULL, NULL, 0}, 0, 0, 0};
    rigcal_points points;
    rc_chain chain;
    rigcal_status status =
        (duv == NULL || n_written == NULL) ? RIGCAL_ERR_NULL : rc_rig_check(rig);
    if (status == RIGCAL_OK && view >= rig->n_views) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK) {
        status = rc_rig_view_at(&v, rig, view);
    }
    if (status == RIGCAL_OK) {
        status = rc_rig_points(&points, &v);
    }
    if (status == RIGCAL_OK && (size_t)v.view.n > capacity / 2) {
        status = RIGCAL_ERR_CAPACITY;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_rig_chain(&chain, rig, v.camera, (size_t)v.placement, view);
    rigcal_real last[2] = {0, 0};
    for (size_t i = 0; i < 2 * v.view.n; i++) { /* first a trial of all points */
        rigcal_real B[6], q[3], X_c[3];
        const size_t point = i % v.view.n;
        rigcal_real *const to = (i < v.view.n) ? last : &duv[2 * point];
        status = rc_points_residual(to, B, q, X_c, &points, &chain.cam_from_target, point);
        if (status != RIGCAL_OK) {
            return status;
        }
    }
    *n_written = v.view.n;
    return RIGCAL_OK;
}
