#include "rc_cost.h"

#include "rc_adjust.h"
#include "rc_score.h"

/* ---- constants ----------------------------------------------------------- */

/* sigma^2: the median of chi squared with 6 degrees of freedom. The middle view costs about
 * this if noise is the only error. */
#define COST_USUAL RC(5.35)

/* of the median's excess over noise: how much the limit grows with it. Errors of lens and
 * target have longer tails than noise. With 10 the limit is some 75 times the middle cost.
 * Right views of real sets, with clocks apart, have cost up to 60 times. */
#define SCALE_SLOPE RC(10)

void rc_judge_end(rigcal_judge_solver *s, rigcal_status status, int32_t at_fault)
{
    s->status = status;
    s->at_fault = at_fault;
    s->phase = RC_JUDGE_DONE;
}

/* ---- what is handed in ------------------------------------------------------ */

/* ---- what a view costs ----------------------------------------------------- */

/* Of each view of a placement, in rig->work: H and g by the placement, and the excess of
 * the view's sum of squared errors over that at its own pose. */
enum { BLOCK_G = 21, BLOCK_EXCESS = 27, BLOCK = 36 };

static void add_block(rigcal_real H[21], const rigcal_real block[BLOCK])
{
    for (int k = 0; k < 21; k++) {
        H[k] += block[k];
    }
}

void rc_judge_next_placement(rigcal_judge_solver *s, const rc_rig_parts *parts)
{
    while (s->placement < s->rig->n_placements &&
           rc_rig_views_of(parts, s->placement) == 0) {
        s->placement++;
    }
    s->first = s->view;
    s->n_kept = 0;
}

static int is_end_of_placement(const rigcal_judge_solver *s, const rc_rig_parts *parts)
{
    return s->view - s->first == rc_rig_views_of(parts, s->placement);
}

void rc_judge_begin_pass(rigcal_judge_solver *s, int32_t phase)
{
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, s->rig, s->adjust.n);
    rc_clear(parts.slot, s->rig->n_cameras); /* 1: the camera's views can be judged */
    s->view = s->placement = s->n_costs = s->n_places = 0;
    s->phase = phase;
    rc_judge_next_placement(s, &parts);
}

/* Evaluates view s->view where the rig is: its sum of squared errors, its equations by its
 * own pose, and its rms. If the view is left out and cannot be seen there, its rms stays as
 * it is. */
static rigcal_status evaluate(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                              rc_chain *chain, rigcal_judge_solver *s)
{
    rigcal_rig_view v;
    rigcal_status status = rc_rig_view_at(&v, s->rig, s->view);
    if (status != RIGCAL_OK) {
        return status;
    }
    status = rc_rig_view_equations(sum, g, H, chain, &v, s->rig, s->view);
    if (status == RIGCAL_OK) {
        s->judged[s->view].rms_px = RC_SQRT(*sum / (rigcal_real)(int32_t)v.view.n);
    }
    return (status == RIGCAL_OK || s->left_out[s->view] != 0) ? RIGCAL_OK : status;
}

void rc_judge_evaluate(rigcal_judge_solver *s, const rc_rig_parts *parts)
{
    if (s->left_out[s->view] == 0) {
        rigcal_real *const block = &parts->W[BLOCK * s->n_kept++];
        rigcal_real sum, g[6], H[21];
        rc_chain chain;
        rigcal_view_pose own;
        rigcal_status status = evaluate(&sum, g, H, &chain, s);
        if (status == RIGCAL_OK) {
            status = rc_candidate_at(&own, s->choice, s->rig, s->view,
                                     s->choice->takes[s->view] == RIGCAL_TAKES_SECOND);
        }
        if (status != RIGCAL_OK) {
            rc_judge_end(s, status, (int32_t)s->view);
            return;
        }
        rc_rigid_clear(&block[BLOCK_G], block);
        rc_chain_add_placement(&block[BLOCK_G], block, &chain, g, H);
        block[BLOCK_EXCESS] = rc_max(0, sum - own.sse);
    }
    s->view++;
    if (is_end_of_placement(s, parts)) {
        s->view = s->first;
        s->slot = 0;
        s->phase = RC_JUDGE_COSTING;
    }
}

/* What the sum of squared errors falls by without the view [px^2]: the view's own excess,
 * and what its placement gains by settling without it while the cameras stay. Returns -1 if
 * the other views do not fix the placement. */
static rigcal_real cost_of(const rigcal_judge_solver *s, const rc_rig_parts *parts,
                           size_t slot)
{
    const rigcal_real *const block = &parts->W[BLOCK * slot];
    rigcal_real y[6], H[21];
    rc_sym6_factor L;
    rc_rigid_clear(y, H);
    for (size_t other = 0; other < s->n_kept; other++) {
        if (other != slot) {
            add_block(H, &parts->W[BLOCK * other]);
        }
    }
    if (s->n_kept < 2 || !rc_sym6_factor_of(&L, H, 0)) {
        return -1;
    }
    rc_vec3_copy(&y[0], &block[BLOCK_G]);
    rc_vec3_copy(&y[3], &block[BLOCK_G + 3]);
    rc_sym6_forward(y, &L);
    return block[BLOCK_EXCESS] + rc_vec3_dot(&y[0], &y[0]) + rc_vec3_dot(&y[3], &y[3]);
}

/* Moves a claimed pose of the current placement from the time of view v to the placement's
 * own time. */
static void move_to_instant(rigcal_transform *pose, const rigcal_judge_solver *s,
                            int32_t camera, size_t v)
{
    const rigcal_transform *const own = &s->rig->rig_from_placements[s->placement];
    rigcal_transform seen = *own;
    rigcal_real d[6];
    s->rig->clocks->calls->place(&seen, s->rig, camera, s->placement, v);
    rc_deviation(d, own, &seen);
    rc_transform_move(pose, d);
}

rigcal_status rc_judge_claim(rc_claim *claim, const rigcal_judge_solver *s, size_t v,
                             int candidate, int with_camera)
{
    rigcal_view_pose first, pose;
    rc_claim view, camera = {0};
    pose.n = 0;
    rigcal_status status = rc_candidate_at(&first, s->choice, s->rig, v, 0);
    if (status == RIGCAL_OK) {
        status = rc_candidate_at(&pose, s->choice, s->rig, v, candidate);
    }
    claim->view = -1;
    if (status != RIGCAL_OK || pose.n == 0) {
        return status;
    }
    camera.b_from_a = s->rig->cams_from_rig[first.camera];
    if (with_camera) {
        rigcal_real Sigma[36];
        status = rigcal_rig_covariance(Sigma, s->rig, 1, (size_t)first.camera);
        rc_sym6_pack(camera.Sigma, Sigma);
    }
    if (!rc_claim_of_view(&view, &pose, first.sse, (int32_t)v, candidate)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    rc_claim_place(claim, &view, &camera, with_camera);
    if (s->rig->clocks != NULL) {
        move_to_instant(&claim->b_from_a, s, first.camera, v);
    }
    return status;
}

/* The claim about the placement that its kept views make together. */
static void claim_of_kept(rc_claim *claim, const rigcal_judge_solver *s,
                          const rc_rig_parts *parts)
{
    rigcal_real g[6], H[21], Sigma[36];
    rc_rigid_clear(g, H);
    rc_clear(Sigma, 36); /* what it stays where H cannot be inverted */
    for (size_t slot = 0; slot < s->n_kept; slot++) {
        add_block(H, &parts->W[BLOCK * slot]);
    }
    *claim = (rc_claim){0};
    claim->b_from_a = s->rig->rig_from_placements[s->placement];
    (void)rc_sym6_invert(Sigma, H);
    rc_sym6_pack(claim->Sigma, Sigma);
}

/* How far the pose of a left-out view is from the placement as the kept views have it. If
 * none is kept: how far it is from the nearest of the other views. */
static rigcal_status distance_of(rigcal_real *least, const rigcal_judge_solver *s,
                                 const rc_rig_parts *parts)
{
    const size_t count = rc_rig_views_of(parts, s->placement);
    rc_claim own, other;
    rigcal_status status = rc_judge_claim(&own, s, s->view, 0, 0);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (s->n_kept > 0) {
        claim_of_kept(&other, s, parts);
        *least = rc_claims_apart(&own, &other);
        return RIGCAL_OK;
    }
    *least = -1;
    for (size_t v = s->first; status == RIGCAL_OK && v < s->first + count; v++) {
        if (v != s->view) {
            status = rc_judge_claim(&other, s, v, 0, 0);
            if (status == RIGCAL_OK) {
                const rigcal_real apart = rc_claims_apart(&own, &other);
                *least = (*least < 0) ? apart : rc_min(*least, apart);
            }
        }
    }
    return status;
}

/* The distance takes errors for linear. So the cost is at most what the view's own sum,
 * `least_sum` at its pose, rises by where the kept views put the placement. */
static rigcal_status judge_left_out(rigcal_judge_solver *s, const rc_rig_parts *parts,
                                    rigcal_real least_sum)
{
    rigcal_judged_view *const judged = &s->judged[s->view];
    rigcal_real sum, g[6], H[21], least;
    rc_chain chain;
    rigcal_status status = distance_of(&least, s, parts);
    if (status != RIGCAL_OK) {
        return status;
    }
    judged->cost = least / s->sigma2 * (RC_COST_LIMIT / RC_CHOOSE_LIMIT);
    judged->rms_px = -1;
    if (s->n_kept > 0) {
        status = evaluate(&sum, g, H, &chain, s);
        if (judged->rms_px >= 0) {
            judged->cost = rc_min(judged->cost, (sum - least_sum) / s->sigma2);
        }
    }
    return status;
}

static void end_placement(rigcal_judge_solver *s, const rc_rig_parts *parts)
{
    s->n_places += (s->n_kept > 1) ? 1 : 0;
    s->placement++;
    rc_judge_next_placement(s, parts);
    s->phase = RC_JUDGE_EVALUATING;
    if (s->placement == s->rig->n_placements) {
        s->phase = RC_JUDGE_SCALING;
    }
}

void rc_judge_cost(rigcal_judge_solver *s, const rc_rig_parts *parts)
{
    rigcal_view_pose own;
    rigcal_status status = rc_rig_pose_at(&own, s->rig, s->view);
    if (status == RIGCAL_OK && s->left_out[s->view] != 0) {
        status = judge_left_out(s, parts, own.sse);
    } else if (status == RIGCAL_OK) {
        const rigcal_real cost = cost_of(s, parts, s->slot++);
        s->judged[s->view].cost = -1;
        if (cost >= 0) {
            s->judged[s->view].cost = cost / s->sigma2;
            s->n_costs++;
            parts->slot[own.camera] = 1;
        }
    }
    if (status != RIGCAL_OK) {
        rc_judge_end(s, status, (int32_t)s->view);
        return;
    }
    s->view++;
    if (is_end_of_placement(s, parts)) {
        end_placement(s, parts);
    }
}

/* ---- the limit --------------------------------------------------------------- */

/* The cost at this place when the costs are sorted. */
static rigcal_real cost_at(const rigcal_judge_solver *s, size_t place)
{
    rigcal_real low = 0, high = 0;
    for (int k = 0; k <= RC_HALVINGS; k++) {
        const rigcal_real middle = (k == 0) ? RC_MAX : low + (high - low) / 2;
        size_t within = 0;
        for (size_t v = 0; v < s->rig->n_views; v++) {
            const rigcal_real cost = s->judged[v].cost;
            if (s->left_out[v] == 0 && cost >= 0) {
                high = (k == 0) ? rc_max(high, cost) : high;
                within += cost <= middle;
            }
        }
        if (k > 0 && within > place) {
            high = middle;
        } else if (k > 0) {
            low = middle;
        }
    }
    return high;
}

void rc_judge_set_scale(rigcal_judge_solver *s, const rc_rig_parts *parts)
{
    rigcal_real free_cameras = 0;
    for (size_t c = 0; c < s->rig->n_cameras; c++) {
        free_cameras += (parts->column[c] >= 0) ? parts->slot[c] : 0;
    }
    const rigcal_real more = (rigcal_real)(int32_t)(s->n_costs - s->n_places);
    const rigcal_real cycles = more - free_cameras;
    s->scale = 1;
    if (cycles > 0) {
        const rigcal_real two =
            cost_at(s, (s->n_costs - 1) / 2) + cost_at(s, s->n_costs / 2);
        const rigcal_real ratio = two * more / (2 * COST_USUAL * cycles);
        s->scale = 1 + SCALE_SLOPE * rc_max(0, ratio - 1);
    }
}
