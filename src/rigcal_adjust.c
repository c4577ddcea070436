#include "rc_adjust.h"

#include <string.h>

#include "rc_refine.h"

/* ---- constants ----------------------------------------------------------- */

/* passes: a search makes at most this many over all views, usually 4 to 8. This bounds the
 * worst case. */
enum { PASSES_MAX = 200 };

/* part of the diagonal before placements were eliminated: a smaller pivot of a camera is
 * rounding. */
#define RANK_TOL RC_TOL(1e-12, 1e-6)

/* part of the sum: the search ends when the expected further gain is less, as judged by how
 * fast the gains fall. The poses are then within a few millionths of their sigma. */
#define GAIN_ENOUGH RC_TOL(1e-10, 1e-6)

/* ---- views by their points ----------------------------------------------- */

rigcal_status rc_rig_check_points(int32_t *camera, int32_t *placement, rigcal_rig_solver *s)
{
    rigcal_rig_view v;
    rigcal_view_pose own;
    rigcal_points points;
    rigcal_status status = rc_rig_view_at(&v, s->rig, s->view);
    if (status != RIGCAL_OK) {
        return status;
    }
    *camera = v.camera;
    *placement = v.placement;
    if (rc_rig_is_left_out(s->rig, s->view)) {
        return RIGCAL_OK;
    }
    status = (v.target != 0) ? RIGCAL_ERR_RANGE : rc_rig_points(&points, &v);
    if (status != RIGCAL_OK) {
        return status;
    }
    s->n_points += points.n_used;
    s->negligible += points.negligible;
    if (s->rig->view_poses == NULL && s->rig->view_pose_source == NULL) {
        return RIGCAL_OK;
    }
    status = rc_rig_pose_at(&own, s->rig, s->view);
    s->own_sum += own.sse;
    return status;
}

void rc_rig_points_of(rigcal_points *points, const rigcal_rig_view *view)
{
    rc_points_of(points, &view->view, NULL);
    points->is_pinhole = (uint8_t)rc_lens_is_pinhole(view->view.camera);
    points->origin[0] = points->origin[1] = points->origin[2] = 0;
}

rigcal_status rc_rig_equations(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                               const rigcal_rig_view *view,
                               const rigcal_transform *cam_from_target)
{
    rigcal_points points;
    rc_rig_points_of(&points, view);
    return rc_refine_equations(sum, g, H, &points, view->view.n, cam_from_target,
                               RC_GAUSS_NEWTON);
}

rigcal_status rc_rig_view_equations(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                                    rc_chain *chain, const rigcal_rig_view *v,
                                    const rigcal_rig *rig, size_t view)
{
    rc_rig_chain(chain, rig, v->camera, (size_t)v->placement, view);
    const rigcal_status status = rc_rig_equations(sum, g, H, v, &chain->cam_from_target);
    if (status == RIGCAL_OK && rig->clocks != NULL) {
        rig->clocks->calls->weigh(sum, g, H, chain, rig);
    }
    return status;
}

static rigcal_status equations_of_points(rigcal_real *sum, rigcal_real g[6],
                                         rigcal_real H[21], rc_chain *chain,
                                         int32_t *camera, const rigcal_rig_solver *s)
{
    rigcal_rig_view v;
    const rigcal_status status = rc_rig_view_at(&v, s->rig, s->view);
    if (status != RIGCAL_OK) {
        return status;
    }
    *camera = v.camera;
    rc_chain_of(chain, &s->rig->cams_from_rig[v.camera],
                &s->rig->rig_from_placements[s->placement]);
    return rc_rig_equations(sum, g, H, &v, &chain->cam_from_target);
}

const struct rigcal_rig_given rc_given_points = {rc_rig_check_points, equations_of_points,
                                                 rc_rig_step, rc_rig_move, 0};

/* ---- a pass -------------------------------------------------------------- */

void rc_rig_end(rigcal_rig_solver *s, rigcal_status status, int32_t at_fault)
{
    s->search.status = status;
    s->at_fault = at_fault;
    s->phase = RC_RIG_DONE;
    rc_rig_forget(s->rig);
}

rigcal_status rc_rig_outcome(int32_t *at_fault, const rigcal_rig_solver *s)
{
    const rigcal_status status = s->search.status;
    if (at_fault != NULL) {
        *at_fault = s->at_fault;
    }
    return (status == RIGCAL_OK && s->is_disconnected) ? RIGCAL_DISCONNECTED : status;
}

/* Begins the next placement that was seen, from s->placement on. If the cameras have moved,
 * it first takes a step of its own. Returns 0 if there is none. */
static int begin_placement(rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    while (s->placement < s->rig->n_placements && !(parts->count[s->placement] > 0)) {
        s->view += rc_rig_views_of(parts, s->placement);
        s->placement++;
    }
    rc_rigid_clear(s->gp, s->Hp);
    s->first = s->view;
    s->row = 0;
    s->phase = (s->is_trial || s->is_last) ? RC_RIG_SETTLING : RC_RIG_REDUCING;
    return s->placement < s->rig->n_placements;
}

/* Begins a pass at the first view. */
static void begin_pass(rigcal_rig_solver *s)
{
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, s->rig, s->n);
    if (!s->is_last) {                                       /* the last pass keeps the
                                                                factor */
        rc_clear(parts.S, s->n * (s->n + 1) / 2 + 2 * s->n); /* S, g and d */
    }
    s->sum = s->gain = 0;
    s->view = s->placement = 0;
    s->evals += s->is_trial ? 2 : 1;
    (void)begin_placement(s, &parts);
}

/* ---- elimination --------------------------------------------------------- */

/* Adds the equations of one camera, whose unknowns begin at `at`. */
static void add_camera(const rc_rig_parts *parts, size_t at, const rigcal_real g[6],
                       const rigcal_real H[21])
{
    rigcal_real full[36];
    rc_sym6_unpack(full, H);
    for (size_t i = 0; i < 6; i++) {
        rigcal_real *const row = &parts->S[rc_packed_at(at + i, at)];
        for (size_t j = 0; j <= i; j++) {
            row[j] += full[6 * i + j];
        }
        parts->g[at + i] += g[i];
        parts->d[at + i] += full[7 * i];
    }
}

/* S -= Y_i Y_j^T. Each row of Y has six of the placement's unknowns. */
static void subtract_block(rigcal_real S[], size_t at_i, size_t at_j,
                           const rigcal_real Y_i[36], const rigcal_real Y_j[36])
{
    const int is_below = at_i >= at_j; /* only the lower triangle is kept */
    const rigcal_real *const down = is_below ? Y_i : Y_j;
    const rigcal_real *const across = is_below ? Y_j : Y_i;
    const size_t at_down = is_below ? at_i : at_j, at_across = is_below ? at_j : at_i;
    for (size_t i = 0; i < 6; i++) {
        rigcal_real *const row = &S[rc_packed_at(at_down + i, at_across)];
        const size_t end = (at_i == at_j) ? i + 1 : 6;
        for (size_t j = 0; j < end; j++) {
            row[j] -= rc_vec6_dot(&down[6 * i], &across[6 * j]);
        }
    }
}

/* L of L L^T = H of the placement, in the memory of H. */
static rc_sym6_factor *factor_of(rigcal_rig_solver *s)
{
    return (rc_sym6_factor *)(void *)s->Hp;
}

/* Eliminates the placement from the camera of a slot. s->gp must hold L^-1 g. Each row of W
 * becomes a row of Y = W L^-T. */
static void eliminate_slot(rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    const size_t slot = s->row++;
    rigcal_real *const Y = &parts->W[36 * slot];
    if (!(parts->slot[slot] >= 0)) {
        return;
    }
    const size_t at = (size_t)parts->slot[slot];
    for (size_t i = 0; i < 6; i++) {
        rc_sym6_forward(&Y[6 * i], factor_of(s));
        parts->g[at + i] -= rc_vec6_dot(&Y[6 * i], s->gp);
    }
    for (size_t other = 0; other <= slot; other++) {
        if (parts->slot[other] >= 0) {
            subtract_block(parts->S, at, (size_t)parts->slot[other], Y,
                           &parts->W[36 * other]);
        }
    }
}

/* ---- the cameras' step --------------------------------------------------- */

static void save_poses(const rigcal_rig *rig, const rc_rig_parts *parts)
{
    memcpy(parts->saved, rig->cams_from_rig, rig->n_cameras * sizeof *parts->saved);
    memcpy(&parts->saved[rig->n_cameras], rig->rig_from_placements,
           rig->n_placements * sizeof *parts->saved);
}

static void restore_poses(const rigcal_rig *rig, const rc_rig_parts *parts)
{
    memcpy(rig->cams_from_rig, parts->saved, rig->n_cameras * sizeof *parts->saved);
    memcpy(rig->rig_from_placements, &parts->saved[rig->n_cameras],
           rig->n_placements * sizeof *parts->saved);
}

void rc_rig_move(const rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    for (size_t c = 0; c < s->rig->n_cameras; c++) {
        if (parts->column[c] >= 0) {
            rc_transform_move(&s->rig->cams_from_rig[c],
                              &parts->g[(size_t)parts->column[c]]);
        }
    }
}

/* Ends the search. The covariance needs the factor of undamped equations, so a pass may
 * follow. */
static void end_search(rigcal_rig_solver *s, rigcal_status status)
{
    s->search.status = status;
    if (s->is_join) {
        s->phase = RC_RIG_DONE;
        rc_rig_forget(s->rig);
    } else if (!(s->search.lambda > 0)) {
        s->phase = RC_RIG_INVERTING;
    } else {
        s->search.lambda = 0;
        s->is_final = 1;
        s->is_trial = 0;
        begin_pass(s);
    }
}

/* Takes the cameras' step, if it is worth it, after their equations were factored. */
static void take_step(rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    rigcal_real gain = s->gain;
    rc_packed_forward(parts->g, parts->S, s->n);
    for (size_t i = 0; i < s->n; i++) {
        gain += parts->g[i] * parts->g[i];
    }
    rc_packed_backward(parts->g, parts->S, s->n);
    s->promised = gain;
    const rigcal_real little = GAIN_ENOUGH * s->search.sum;
    const int is_enough =
        gain <= little || gain / little * gain <= s->search.last_gain - gain;
    const int step =
        rc_levenberg_promised(&s->search, gain, is_enough ? gain : s->negligible);
    if (step == RC_STEP_TRY && s->evals >= PASSES_MAX) {
        end_search(s, RIGCAL_BUDGET_SPENT);
        return;
    }
    save_poses(s->rig, parts);
    s->is_trial = step == RC_STEP_TRY;
    s->is_last = step == RC_STEP_LAST && s->is_lagging == 0;
    if (s->is_trial || s->is_last) {
        s->given->move(s, parts);
    } else { /* not yet the end: the same poses once more, with their own motion */
        s->search.status = RIGCAL_RUNNING;
        s->search.want = RC_WANT_EQUATIONS;
    }
    begin_pass(s);
}

static void factor_row(rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    const size_t i = s->row++;
    if (i < s->n) {
        /* where stamps have noise, rounding may leave a diagonal below 0 */
        const rigcal_real least = RANK_TOL * rc_max(parts->d[i], 0);
        parts->S[rc_packed_at(i, i)] *= 1 + s->search.lambda;
        if (!rc_packed_factor_row(parts->S, i, least)) {
            rc_rig_end(s, RIGCAL_ERR_DEGENERATE, -1);
            return;
        }
    }
    if (s->row >= s->n) {
        s->row = 0;
        if (s->is_final) {
            s->phase = RC_RIG_INVERTING;
        } else {
            take_step(s, parts);
        }
    }
}

static void invert_row(rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    if (s->row < s->n) {
        if (s->phase == RC_RIG_INVERTING) {
            rc_packed_invert_row(parts->S, s->row);
        } else {
            rc_packed_square_row(parts->S, s->row, s->n);
        }
        s->row++;
    }
    if (s->row >= s->n) {
        s->row = 0;
        s->phase = (s->phase == RC_RIG_INVERTING) ? RC_RIG_SQUARING : RC_RIG_DONE;
    }
}

/* ---- the end of a pass --------------------------------------------------- */

/* Ends a pass, after all views were evaluated or one failed with `status`. */
static void end_pass(rigcal_rig_solver *s, rigcal_status status)
{
    rc_rig_parts parts;
    rigcal_levenberg *const lm = &s->search;
    rc_rig_parts_of(&parts, s->rig, s->n);
    s->row = 0;
    s->phase = RC_RIG_FACTORING;
    if (s->is_final || s->is_last) {
        if (status != RIGCAL_OK) {
            rc_rig_end(s, status, (int32_t)s->view);
        } else if (s->is_last) {
            s->is_last = 0;
            end_search(s, RIGCAL_OK);
        }
    } else if (!s->is_trial) {
        rc_levenberg_evaluated(lm, status, s->sum);
        if (lm->status != RIGCAL_RUNNING) {
            rc_rig_end(s, status, (int32_t)s->view);
        }
    } else if (!rc_levenberg_tried(lm, status, s->sum, s->promised, s->negligible)) {
        restore_poses(s->rig, &parts);
        s->is_trial = 0;
        if (lm->status != RIGCAL_RUNNING) {
            end_search(s, lm->status); /* lambda > 0: a step was taken back */
        } else {
            begin_pass(s);
        }
    }
}

/* Adds the prior of camera s->row. */
RC_APART static void add_prior(rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    const rigcal_rig *const rig = s->rig;
    const size_t c = s->row++;
    if (rc_rig_has_prior(rig, c)) {
        rigcal_real sum, g[6], H[21];
        if (rc_rig_prior(&sum, g, H, parts, rig, c) != RIGCAL_OK) {
            rc_rig_end(s, RIGCAL_ERR_DEGENERATE, -1);
            return;
        }
        add_camera(parts, (size_t)parts->column[c], g, H);
        s->sum += sum;
    }
    if (s->row >= rig->n_cameras) {
        end_pass(s, RIGCAL_OK);
    }
}

/* Goes to the next placement that was seen, or ends the pass. */
static void next_placement(rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    s->placement++;
    if (begin_placement(s, parts)) {
        return;
    }
    if (s->is_last) {
        end_pass(s, RIGCAL_OK);
    } else {
        s->phase = RC_RIG_PRIORS;
    }
}

/* Ends a placement, after all its views were added. */
static void end_placement(rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    if (!rc_sym6_factor_of(factor_of(s), s->Hp, s->search.lambda)) {
        s->view--; /* one of its views is at fault */
        end_pass(s, RIGCAL_ERR_DEGENERATE);
    } else if (s->phase == RC_RIG_SETTLING) {
        rc_sym6_solve(s->gp, factor_of(s));
        rc_transform_move(&s->rig->rig_from_placements[s->placement], s->gp);
        if (s->is_last) {
            next_placement(s, parts);
        } else {
            rc_rigid_clear(s->gp, s->Hp);
            s->view = s->first;
            s->phase = RC_RIG_REDUCING;
        }
    } else {
        rc_sym6_forward(s->gp, factor_of(s));
        s->gain += rc_vec6_dot(s->gp, s->gp);
        s->phase = RC_RIG_ELIMINATING;
    }
}

static int is_end_of_placement(const rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    return s->view - s->first == rc_rig_views_of(parts, s->placement);
}

/* Adds a view to its placement's equations. If the pass reduces, adds it to its camera's
 * too. */
static rigcal_status add_equations(rigcal_rig_solver *s, const rc_rig_parts *parts,
                                   size_t slot)
{
    rigcal_real sum = 0, g[6], H[21];
    rc_chain chain;
    int32_t camera = -1;
    const rigcal_status status = s->given->equations(&sum, g, H, &chain, &camera, s);
    if (status != RIGCAL_OK) {
        s->is_final |= camera < 0; /* no view: another step would not help */
        return status;
    }
    rc_chain_add_placement(s->gp, s->Hp, &chain, g, H);
    if (s->phase == RC_RIG_REDUCING) {
        s->sum += sum;
        parts->slot[slot] = parts->column[camera];
        if (parts->slot[slot] >= 0) {
            rc_chain_camera(g, H, &parts->W[36 * slot], &chain);
            add_camera(parts, (size_t)parts->slot[slot], g, H);
        }
    }
    return RIGCAL_OK;
}

static void add_view(rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    const size_t slot = s->view - s->first;
    parts->slot[slot] = -1;
    const rigcal_status status =
        rc_rig_is_left_out(s->rig, s->view) ? RIGCAL_OK : add_equations(s, parts, slot);
    if (status != RIGCAL_OK) {
        end_pass(s, status);
        return;
    }
    s->view++;
    if (is_end_of_placement(s, parts)) {
        end_placement(s, parts);
    }
}

/* ---- the search ---------------------------------------------------------- */

rigcal_status rc_rig_begin(rigcal_rig_solver *s, rigcal_rig *rig,
                           const struct rigcal_rig_given *given)
{
    if (rigcal_rig_work(0, rig->n_cameras, rig->n_placements) > rig->work_capacity) {
        return RIGCAL_ERR_CAPACITY;
    }
    rig->considered = NULL; /* it belongs to the rig before this search */
    *s = (rigcal_rig_solver){0};
    s->rig = rig;
    s->given = given;
    s->is_join = given->is_join;
    s->phase = RC_RIG_CHECKING;
    s->at_fault = -1;
    rc_levenberg_begin(&s->search, 1);
    const rigcal_status status = rc_views_begin(s);
    if (status != RIGCAL_OK) {
        rc_rig_end(s, status, -1);
    }
    return RIGCAL_OK;
}

rigcal_status rc_rig_begin_points(rigcal_rig_solver *s, rigcal_rig *rig,
                                  const struct rigcal_rig_given *given)
{
    if (s == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_rig_check(rig);
    if (status == RIGCAL_OK && rig->views == NULL && rig->view_source == NULL) {
        status = RIGCAL_ERR_NULL;
    }
    for (size_t c = 0; status == RIGCAL_OK && c < rig->n_cameras; c++) {
        status = rc_check_transform(&rig->cams_from_rig[c]);
    }
    if (status == RIGCAL_OK) {
        status = rc_rig_begin(s, rig, given);
    }
    return (status == RIGCAL_OK && rig->clocks != NULL) ? rig->clocks->calls->begin(s)
                                                        : status;
}

static void checking_step(rigcal_rig_solver *s)
{
    const rigcal_status status = rc_views_step(s);
    if (status == RIGCAL_OK) {
        s->phase = RC_RIG_CHECKED;
    } else if (status != RIGCAL_RUNNING) {
        rc_rig_end(s, status, (s->view < s->rig->n_views) ? (int32_t)s->view : -1);
    }
}

void rc_rig_step(rigcal_rig_solver *s)
{
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, s->rig, s->n);
    switch (s->phase) {
    case RC_RIG_CHECKING:
        checking_step(s);
        break;
    case RC_RIG_SETTLING:
    case RC_RIG_REDUCING:
        add_view(s, &parts);
        break;
    case RC_RIG_ELIMINATING:
        eliminate_slot(s, &parts);
        if (s->row == rc_rig_views_of(&parts, s->placement)) {
            next_placement(s, &parts);
        }
        break;
    case RC_RIG_CHECKED:
        begin_pass(s);
        break;
    case RC_RIG_PRIORS:
        add_prior(s, &parts);
        break;
    case RC_RIG_FACTORING:
        factor_row(s, &parts);
        break;
    case RC_RIG_INVERTING:
    case RC_RIG_SQUARING:
        invert_row(s, &parts);
        break;
    default:
        break;
    }
}
