#include "rc_adjust.h"

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
    if (solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_rig_check(rig);
    if (status == RIGCAL_OK && rig->views == NULL && rig->view_source == NULL) {
        status = RIGCAL_ERR_NULL;
    }
    if (status == RIGCAL_OK &&
        rigcal_rig_work(0, rig->n_cameras, rig->n_placements) > rig->work_capacity) {
        status = RIGCAL_ERR_CAPACITY;
    }
    for (size_t c = 0; status == RIGCAL_OK && c < rig->n_cameras; c++) {
        status = rc_check_transform(&rig->cams_from_rig[c]);
    }
    if (status == RIGCAL_OK) {
        rc_rig_begin(solver, rig, 0);
    }
    return status;
}

rigcal_status rigcal_rig_step(rigcal_rig_solver *solver, int32_t budget)
{
    if (solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (solver->phase == 0) {
        return RIGCAL_ERR_STATE;
    }
    if (budget < 1) {
        return RIGCAL_ERR_RANGE;
    }
    for (; budget > 0 && solver->phase != RC_RIG_DONE; budget--) {
        rc_rig_step(solver);
    }
    return (solver->phase == RC_RIG_DONE) ? RIGCAL_OK : RIGCAL_RUNNING;
}

/* Placements that were seen, and cameras with a prior, in unknowns. */
static void fill_fit(rigcal_rig_fit *fit, const rigcal_rig_solver *s)
{
    const rigcal_rig *const rig = s->rig;
    rigcal_real unknowns = (rigcal_real)(int32_t)(s->n + 6 * s->n_seen);
    for (size_t c = 0; rig->roles != NULL && c < rig->n_cameras; c++) {
        unknowns -= (rig->roles[c] == RIGCAL_CAMERA_PRIOR) ? 6 : 0;
    }
    const rigcal_real measured = 2 * (rigcal_real)(int32_t)s->n_points;
    *fit = (rigcal_rig_fit){0};
    fit->sum = s->search.sum;
    fit->freedom = measured - unknowns;
    fit->sigma_px = (fit->freedom > 0) ? RC_SQRT(fit->sum / fit->freedom) : 0;
    fit->n_points = s->n_points;
    fit->evals = s->evals;
    const rigcal_real within = measured - 6 * (rigcal_real)(int32_t)rig->n_views;
    const rigcal_real between = fit->freedom - within;
    if ((rig->view_poses != NULL || rig->view_pose_source != NULL) && within > 0 &&
        between > 0 && s->own_sum > 0) {
        fit->F = rc_max(0, fit->sum - s->own_sum) / between / (s->own_sum / within);
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
    if (at_fault != NULL) {
        *at_fault = solver->at_fault;
    }
    const rigcal_status status = solver->search.status;
    if (status < 0) {
        return status;
    }
    fill_fit(fit, solver);
    return (status == RIGCAL_OK && solver->is_disconnected) ? RIGCAL_DISCONNECTED : status;
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
    while (rigcal_rig_step(&solver, 1000) == RIGCAL_RUNNING) {
    }
    return rigcal_rig_result(fit, at_fault, &solver);
}

/* ---- how sure ------------------------------------------------------------ */

/* out: the covariance of cameras a and b, for noise of 1 px, row by row. */
static void block_of(rigcal_real out[36], const rigcal_rig *rig, size_t a, size_t b)
{
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, rig, 0);
    for (int k = 0; k < 36; k++) {
        out[k] = 0;
    }
    if (!(parts.column[a] >= 0 && parts.column[b] >= 0)) {
        return;
    }
    const size_t at_a = (size_t)parts.column[a], at_b = (size_t)parts.column[b];
    for (size_t i = 0; i < 6; i++) {
        for (size_t j = 0; j < 6; j++) {
            const size_t row = at_a + i, column = at_b + j;
            out[6 * i + j] = parts.S[(row >= column) ? rc_packed_at(row, column)
                                                     : rc_packed_at(column, row)];
        }
    }
}

/* Whether the memory to work in holds what an adjustment leaves there: unknowns in the
 * order of their cameras, variances above 0, views of a placement. */
static int is_adjusted(const rigcal_rig *rig)
{
    rc_rig_parts parts;
    size_t n = 0;
    if (rig->work_capacity < rigcal_rig_work(0, rig->n_cameras, rig->n_placements)) {
        return 0;
    }
    rc_rig_parts_of(&parts, rig, 0);
    for (size_t c = 0; c < rig->n_cameras; c++) {
        if (parts.column[c] >= 0) {
            n++;
        }
    }
    if (rig->work_capacity < rigcal_rig_work(n, rig->n_cameras, rig->n_placements)) {
        return 0;
    }
    n = 0;
    for (size_t c = 0; c < rig->n_cameras; c++) {
        const rigcal_real column = parts.column[c];
        const int is_next = column >= (rigcal_real)n && column <= (rigcal_real)n;
        if (!(column >= -1 && column <= -1) &&
            !(is_next && parts.S[rc_packed_at(n, n)] > 0)) {
            return 0;
        }
        n += is_next ? 6 : 0;
    }
    for (size_t f = 0; f < rig->n_placements; f++) {
        if (!(parts.count[f] >= 0 && parts.count[f] <= (rigcal_real)rig->n_cameras)) {
            return 0;
        }
    }
    return 1;
}

static rigcal_status check_sure(const rigcal_real *Sigma, const rigcal_rig *rig,
                                rigcal_real sigma_px, size_t camera)
{
    rigcal_status status = (Sigma == NULL) ? RIGCAL_ERR_NULL : rc_rig_check(rig);
    if (status == RIGCAL_OK) {
        status = rc_check_noise(&sigma_px);
    }
    if (status == RIGCAL_OK && camera >= rig->n_cameras) {
        status = RIGCAL_ERR_RANGE;
    }
    return (status == RIGCAL_OK && !is_adjusted(rig)) ? RIGCAL_ERR_STATE : status;
}

rigcal_status rigcal_rig_covariance(rigcal_real Sigma[36], const rigcal_rig *rig,
                                    rigcal_real sigma_px, size_t camera)
{
    const rigcal_status status = check_sure(Sigma, rig, sigma_px, camera);
    if (status != RIGCAL_OK) {
        return status;
    }
    block_of(Sigma, rig, camera, camera);
    for (int k = 0; k < 36; k++) {
        Sigma[k] *= sigma_px * sigma_px;
    }
    return RIGCAL_OK;
}

/* Sigma += J_left S J_right^T */
static void add_turned(rigcal_real Sigma[36], const rigcal_real J_left[36],
                       const rigcal_real S[36], const rigcal_real J_right[36])
{
    rigcal_real half[36];
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++) {
            half[6 * i + j] = 0;
            for (int k = 0; k < 6; k++) {
                half[6 * i + j] += J_left[6 * i + k] * S[6 * k + j];
            }
        }
    }
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++) {
            Sigma[6 * i + j] += rc_vec3_dot(&half[6 * i], &J_right[6 * j]) +
                                rc_vec3_dot(&half[6 * i + 3], &J_right[6 * j + 3]);
        }
    }
}

/* A rotation M, and [x]x M below it: what a step of a camera does to b_from_a. */
static void fill_step(rigcal_real J[36], const rigcal_real x[3], const rigcal_real M[9])
{
    for (int column = 0; column < 3; column++) {
        const rigcal_real m[3] = {M[column], M[3 + column], M[6 + column]};
        rigcal_real moved[3];
        rc_vec3_cross(moved, x, m);
        for (int row = 0; row < 3; row++) {
            J[6 * row + column] = J[6 * (row + 3) + column + 3] = m[row];
            J[6 * row + column + 3] = 0;
            J[6 * (row + 3) + column] = moved[row];
        }
    }
}

static void make_symmetric(rigcal_real Sigma[36], rigcal_real scale)
{
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j <= i; j++) {
            Sigma[6 * j + i] = Sigma[6 * i + j] = scale * Sigma[6 * i + j];
        }
    }
}

rigcal_status rigcal_rig_pair(rigcal_transform *b_from_a, rigcal_real Sigma[36],
                              const rigcal_rig *rig, rigcal_real sigma_px, size_t a,
                              size_t b)
{
    static const rigcal_real ONE[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    rigcal_status status = check_sure(Sigma, rig, sigma_px, a);
    if (status == RIGCAL_OK && (b_from_a == NULL || b >= rig->n_cameras)) {
        status = (b_from_a == NULL) ? RIGCAL_ERR_NULL : RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK && rig->group[a] != rig->group[b]) {
        status = RIGCAL_DISCONNECTED;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    rigcal_real x[3], minus_R[9], J_a[36], J_b[36], S[36];
    rc_transform_between(b_from_a, &rig->cams_from_rig[b], &rig->cams_from_rig[a]);
    rc_mat3_mul_vec3(x, b_from_a->R, rig->cams_from_rig[a].t);
    for (int k = 0; k < 9; k++) {
        minus_R[k] = -b_from_a->R[k];
    }
    fill_step(J_b, x, ONE);
    fill_step(J_a, x, minus_R);
    for (int k = 0; k < 36; k++) {
        Sigma[k] = 0;
    }
    block_of(S, rig, a, a);
    add_turned(Sigma, J_a, S, J_a);
    block_of(S, rig, b, b);
    add_turned(Sigma, J_b, S, J_b);
    block_of(S, rig, a, b);
    add_turned(Sigma, J_a, S, J_b);
    block_of(S, rig, b, a);
    add_turned(Sigma, J_b, S, J_a);
    make_symmetric(Sigma, sigma_px * sigma_px);
    return RIGCAL_OK;
}

/* Of a placement: H, and W of each of its views in the memory to work in; parts->slot gets
 * their cameras. */
static rigcal_status gather(rigcal_real H_placement[21], const rigcal_rig *rig,
                            const rc_rig_parts *parts, size_t placement, size_t first)
{
    rigcal_real g_placement[6];
    rc_rigid_clear(g_placement, H_placement);
    for (size_t i = 0; i < (size_t)parts->count[placement]; i++) {
        rigcal_rig_view v;
        rc_chain chain;
        rigcal_real sum, g[6], H[21];
        rigcal_status status = rc_rig_view_at(&v, rig, first + i);
        if (status == RIGCAL_OK) {
            rc_chain_of(&chain, &rig->cams_from_rig[v.camera],
                        &rig->rig_from_placements[placement]);
            status = rc_rig_equations(&sum, g, H, &v, &chain.cam_from_target);
        }
        if (status != RIGCAL_OK) {
            return status;
        }
        rc_chain_add_placement(g_placement, H_placement, &chain, g, H);
        rc_chain_camera(g, H, &parts->W[36 * i], &chain);
        parts->slot[i] = (rigcal_real)v.camera;
    }
    return RIGCAL_OK;
}

rigcal_status rigcal_rig_placement(rigcal_real Sigma[36], rigcal_rig *rig,
                                   rigcal_real sigma_px, size_t placement)
{
    rc_rig_parts parts;
    rc_sym6_factor L;
    rigcal_real H[21], S[36];
    size_t first = 0;
    rigcal_status status = check_sure(Sigma, rig, sigma_px, 0);
    if (status == RIGCAL_OK && placement >= rig->n_placements) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_rig_parts_of(&parts, rig, 0);
    const size_t count = (size_t)parts.count[placement];
    for (size_t f = 0; f < placement; f++) {
        first += (size_t)parts.count[f];
    }
    status = (count == 0) ? RIGCAL_ERR_TOO_FEW : gather(H, rig, &parts, placement, first);
    if (status == RIGCAL_OK && !rc_sym6_factor_of(&L, H, 0)) {
        status = RIGCAL_ERR_DEGENERATE;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    /* Column by column: H^-1 e, and W H^-1 of each view, transposed, in the place of W. */
    (void)rc_sym6_invert(Sigma, H);
    for (size_t i = 0; i < count; i++) {
        rigcal_real *const W = &parts.W[36 * i];
        rigcal_real turned[36];
        for (int row = 0; row < 6; row++) {
            rc_sym6_solve(&W[6 * row], &L);
        }
        for (int k = 0; k < 36; k++) {
            turned[k] = W[6 * (k % 6) + k / 6];
        }
        for (int k = 0; k < 36; k++) {
            W[k] = turned[k];
        }
    }
    for (size_t i = 0; i < count; i++) {
        for (size_t j = 0; j < count; j++) {
            block_of(S, rig, (size_t)parts.slot[i], (size_t)parts.slot[j]);
            add_turned(Sigma, &parts.W[36 * i], S, &parts.W[36 * j]);
        }
    }
    make_symmetric(Sigma, sigma_px * sigma_px);
    return RIGCAL_OK;
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
    rc_chain_of(&chain, &rig->cams_from_rig[v.camera],
                &rig->rig_from_placements[v.placement]);
    for (size_t i = 0; i < v.view.n; i++) {
        rigcal_real B[6], q[3], X_c[3];
        status =
            rc_points_residual(&duv[2 * i], B, q, X_c, &points, &chain.cam_from_target, i);
        if (status != RIGCAL_OK) {
            return status;
        }
    }
    *n_written = v.view.n;
    return RIGCAL_OK;
}
