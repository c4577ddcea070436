#include "rc_adjust.h"
#include "rc_choose.h"

/* ---- constants ----------------------------------------------------------- */

/* sigma^2: what a view may cost at most where noise is all. Its excess is chi square of 6,
 * which passes this once in two million right views. */
#define COST_LIMIT RC(40)

/* sigma^2: the median of chi square of 6 degrees of freedom, about which the middle view
 * costs where noise is all. */
#define COST_USUAL RC(5.35)

/* of the median's excess over noise: how much the limit grows with it. Patterns of lens and
 * target have longer tails than noise: with 4 the limit is some 30 times the middle cost,
 * which no right view of the real sets comes near. */
#define SCALE_SLOPE RC(4)

/* rounds of naming: one takes every wrong view that is the worst of its placement; views
 * hidden by worse ones follow. */
enum { ROUNDS = 3 };

/* halvings: of a search of the median. Its error is this part of the largest cost. */
enum { HALVINGS = 60 };

enum {
    DONE = 1,
    CHECKING,   /* the poses of a view by itself */
    ADJUSTING,  /* the rig */
    EVALUATING, /* a view of a placement, where the rig is */
    COSTING,    /* what such a view costs */
    SCALING,    /* the limit, by the middle cost */
    PLACING,    /* a placement, by its views' own poses */
    NAMING,
    CONCLUDING
};

static void end(rigcal_judge_solver *s, rigcal_status status, int32_t at_fault)
{
    s->status = status;
    s->at_fault = at_fault;
    s->phase = DONE;
}

/* ---- what is handed in ------------------------------------------------------ */

/* Pose 0 or 1 of a view by itself; n is 0 where there is none. */
static rigcal_status pose_of(rigcal_view_pose *pose, const rigcal_judge_solver *s,
                             size_t view, int candidate)
{
    const rigcal_choice *const choice = s->choice;
    if (candidate == 0) {
        return rc_rig_pose_at(pose, s->rig, view);
    }
    if (choice->second_poses != NULL) {
        *pose = choice->second_poses[view];
        return RIGCAL_OK;
    }
    pose->n = 0;
    return (choice->second_source == NULL)
               ? RIGCAL_OK
               : choice->second_source(pose, view, s->rig->context);
}

static void begin_adjustment(rigcal_judge_solver *s)
{
    const rigcal_status status = rigcal_rig_begin(&s->adjust, s->rig);
    s->phase = ADJUSTING;
    s->adjustments++;
    if (status != RIGCAL_OK) {
        end(s, status, -1);
    }
}

/* What the choice says of a view whose first pose has been checked. */
static rigcal_status check_view(rigcal_judge_solver *s, size_t v)
{
    rigcal_view_pose first, second;
    rigcal_status status = pose_of(&first, s, v, 0);
    if (status == RIGCAL_OK) {
        status = pose_of(&second, s, v, 1);
    }
    if (status == RIGCAL_OK && second.n > 0) {
        status = rc_check_transform(&second.cam_from_target);
    }
    if (status == RIGCAL_OK && second.n > 0) {
        status = rc_check_numbers(second.information, 21, RC_MAX);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    const uint8_t takes = s->choice->takes[v];
    s->left_out[v] = takes == RIGCAL_TAKES_NONE;
    return (takes > RIGCAL_TAKES_NONE || !(first.sse >= 0) ||
            (takes == RIGCAL_TAKES_SECOND && second.n == 0) ||
            (second.n > 0 && !(second.sse >= 0 && second.camera == first.camera)))
               ? RIGCAL_ERR_RANGE
               : RIGCAL_OK;
}

/* ---- what a view costs ----------------------------------------------------- */

/* Of each view of a placement, in the memory to work in: H, g by the placement, and by how
 * much its sum of squared errors is more than that of its own pose. */
enum { BLOCK_G = 21, BLOCK_EXCESS = 27, BLOCK = 36 };

static void add_block(rigcal_real H[21], const rigcal_real block[BLOCK])
{
    for (int k = 0; k < 21; k++) {
        H[k] += block[k];
    }
}

/* From the first placement that was seen on. */
static void next_placement(rigcal_judge_solver *s, const rc_rig_parts *parts)
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

static void begin_pass(rigcal_judge_solver *s, int32_t phase)
{
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, s->rig, s->adjust.n);
    rc_clear(parts.slot, s->rig->n_cameras); /* 1: the camera's views can be judged */
    s->view = s->placement = s->n_costs = s->n_places = 0;
    s->phase = phase;
    next_placement(s, &parts);
}

/* View v, where the rig is: its equations by its own pose, and its rms. */
static rigcal_status evaluate(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                              rc_chain *chain, rigcal_judge_solver *s)
{
    rigcal_rig_view v;
    rigcal_status status = rc_rig_view_at(&v, s->rig, s->view);
    if (status == RIGCAL_OK) {
        rc_chain_of(chain, &s->rig->cams_from_rig[v.camera],
                    &s->rig->rig_from_placements[v.placement]);
        status = rc_rig_equations(sum, g, H, &v, &chain->cam_from_target);
    }
    s->judged[s->view].rms_px =
        (status == RIGCAL_OK) ? RC_SQRT(*sum / (rigcal_real)(int32_t)v.view.n) : -1;
    return status;
}

static void evaluate_view(rigcal_judge_solver *s, const rc_rig_parts *parts)
{
    if (s->left_out[s->view] == 0) {
        rigcal_real *const block = &parts->W[BLOCK * s->n_kept++];
        rigcal_real sum, g[6], H[21];
        rc_chain chain;
        rigcal_view_pose own;
        rigcal_status status = evaluate(&sum, g, H, &chain, s);
        if (status == RIGCAL_OK) {
            status =
                pose_of(&own, s, s->view, s->choice->takes[s->view] == RIGCAL_TAKES_SECOND);
        }
        if (status != RIGCAL_OK) {
            end(s, status, (int32_t)s->view);
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
        s->phase = COSTING;
    }
}

/* What the sum of squared errors falls by without the view: its own excess, and what its
 * placement gains as it settles by the others, cameras where they are. Less than 0: the
 * others do not fix it. */
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

/* The placement under way as a pose of view v by itself has it; view is -1 where there is
 * no such pose. */
static rigcal_status claim_of(rc_claim *claim, const rigcal_judge_solver *s, size_t v,
                              int candidate, int with_camera)
{
    rigcal_view_pose first, pose;
    rc_claim view, camera = {0};
    rigcal_status status = pose_of(&first, s, v, 0);
    if (status == RIGCAL_OK) {
        status = pose_of(&pose, s, v, candidate);
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
    return status;
}

/* The placement as those of its views have it that are not left out. */
static void claim_of_kept(rc_claim *claim, const rigcal_judge_solver *s,
                          const rc_rig_parts *parts)
{
    rigcal_real g[6], H[21], Sigma[36];
    rc_rigid_clear(g, H);
    for (size_t slot = 0; slot < s->n_kept; slot++) {
        add_block(H, &parts->W[BLOCK * slot]);
    }
    *claim = (rc_claim){0};
    claim->b_from_a = s->rig->rig_from_placements[s->placement];
    if (rc_sym6_invert(Sigma, H)) { /* else no other is far from it */
        rc_sym6_pack(claim->Sigma, Sigma);
    }
}

/* Of a view that is left out: how far its own pose is from the placement as those that are
 * not left out have it or, where all are, from the nearest of the others. */
static rigcal_status distance_of(rigcal_real *least, const rigcal_judge_solver *s,
                                 const rc_rig_parts *parts)
{
    const size_t count = rc_rig_views_of(parts, s->placement);
    rc_claim own, other;
    rigcal_status status = claim_of(&own, s, s->view, 0, 0);
    if (s->n_kept > 0) {
        claim_of_kept(&other, s, parts);
        *least = rc_claims_apart(&own, &other);
        return status;
    }
    *least = -1;
    for (size_t v = s->first; status == RIGCAL_OK && v < s->first + count; v++) {
        if (v != s->view) {
            status = claim_of(&other, s, v, 0, 0);
            const rigcal_real apart = rc_claims_apart(&own, &other);
            *least = (*least < 0) ? apart : rc_min(*least, apart);
        }
    }
    return status;
}

static rigcal_status judge_left_out(rigcal_judge_solver *s, const rc_rig_parts *parts)
{
    rigcal_judged_view *const judged = &s->judged[s->view];
    rigcal_real sum, g[6], H[21], least;
    rc_chain chain;
    const rigcal_status status = distance_of(&least, s, parts);
    judged->cost = least / s->sigma2 * (COST_LIMIT / RC_CHOOSE_LIMIT);
    judged->rms_px = -1;
    if (s->n_kept > 0) {
        (void)evaluate(&sum, g, H, &chain, s);
    }
    return status;
}

static void end_placement(rigcal_judge_solver *s, const rc_rig_parts *parts)
{
    s->n_places += (s->n_kept > 1) ? 1 : 0;
    s->placement++;
    next_placement(s, parts);
    s->phase = EVALUATING;
    if (s->placement == s->rig->n_placements) {
        s->phase = SCALING;
    }
}

static void cost_view(rigcal_judge_solver *s, const rc_rig_parts *parts)
{
    rigcal_view_pose own;
    rigcal_status status = rc_rig_pose_at(&own, s->rig, s->view);
    if (status == RIGCAL_OK && s->left_out[s->view] != 0) {
        status = judge_left_out(s, parts);
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
        end(s, status, (int32_t)s->view);
        return;
    }
    s->view++;
    if (is_end_of_placement(s, parts)) {
        end_placement(s, parts);
    }
}

/* ---- naming ---------------------------------------------------------------- */

/* left_out of a view that is left out for good, and of one that is so to see. */
enum { OUT = 1, OUT_TO_SEE = 2 };

/* How many views of a placement are not left out; *last is one of them. */
static size_t kept_of(size_t *last, const rigcal_judge_solver *s, size_t first,
                      size_t count)
{
    size_t kept = 0;
    for (size_t v = first; v < first + count; v++) {
        if (s->left_out[v] == 0) {
            *last = v;
            kept++;
        }
    }
    return kept;
}

/* Of a placement that several cameras saw, a view with which no other agrees is left out
 * too. */
static void leave_out_lone_views(rigcal_judge_solver *s, const rc_rig_parts *parts,
                                 uint8_t mark)
{
    size_t first = 0, last = 0;
    for (size_t f = 0; f < s->rig->n_placements; f++) {
        const size_t count = rc_rig_views_of(parts, f);
        if (count > 1 && kept_of(&last, s, first, count) == 1) {
            s->left_out[last] = mark;
        }
        first += count;
    }
}

/* So is the view by which alone a camera would hang on the others, where it has more that
 * do not agree: it is where that view puts it, and nothing says that it is right. */
static rigcal_status leave_out_lone_cameras(rigcal_judge_solver *s,
                                            const rc_rig_parts *parts, uint8_t mark)
{
    rigcal_real *const kept = parts->slot, *const all = parts->W; /* of each camera */
    rc_clear(kept, s->rig->n_cameras);
    rc_clear(all, s->rig->n_cameras);
    for (int is_marking = 0; is_marking < 2; is_marking++) {
        for (size_t v = 0; v < s->rig->n_views; v++) {
            rigcal_view_pose own;
            const rigcal_status status = pose_of(&own, s, v, 0);
            if (status != RIGCAL_OK) {
                return status;
            }
            const size_t c = (size_t)own.camera;
            if (rc_rig_views_of(parts, (size_t)own.placement) < 2) {
                continue;
            }
            if (!is_marking) {
                kept[c] += (s->left_out[v] == 0) ? 1 : 0;
                all[c] += 1;
            } else if (s->left_out[v] == 0 && kept[c] < 2 && all[c] > 1 &&
                       !rc_rig_is_held(s->rig, c) && !rc_rig_has_prior(s->rig, c)) {
                s->left_out[v] = mark;
            }
        }
    }
    return RIGCAL_OK;
}

static rigcal_status leave_out_lone(rigcal_judge_solver *s, const rc_rig_parts *parts,
                                    uint8_t mark)
{
    leave_out_lone_views(s, parts, mark);
    const rigcal_status status = leave_out_lone_cameras(s, parts, mark);
    leave_out_lone_views(s, parts, mark);
    return status;
}

/* Adjusts, without the views that are left out and those that they leave alone. */
static void adjust_without(rigcal_judge_solver *s, const rc_rig_parts *parts, uint8_t mark)
{
    const rigcal_status status = leave_out_lone(s, parts, mark);
    begin_adjustment(s);
    if (status != RIGCAL_OK) {
        end(s, status, -1);
    }
}

/* Leaves out the worst view of each placement if it is beyond the limit. Where none is, the
 * worst of all is left out to see: so no view raises its own limit. */
static void name_worst(rigcal_judge_solver *s, const rc_rig_parts *parts)
{
    size_t first = 0, most = 0, n = 0;
    s->tried_cost = 0;
    for (size_t f = 0; f < s->rig->n_placements; f++) {
        const size_t end_of = first + rc_rig_views_of(parts, f);
        rigcal_real cost = -1;
        size_t worst = first;
        for (size_t v = first; v < end_of; v++) {
            if (s->left_out[v] == 0 && s->judged[v].cost > cost) {
                cost = s->judged[v].cost;
                worst = v;
            }
        }
        if (cost > COST_LIMIT * s->scale) {
            s->left_out[worst] = OUT;
            n++;
        }
        if (cost > s->tried_cost) {
            s->tried_cost = cost;
            most = worst;
        }
        first = end_of;
    }
    const int is_trial = n == 0 && s->tried_cost > COST_LIMIT;
    if (is_trial) {
        s->left_out[most] = OUT_TO_SEE;
    } else {
        s->tried_cost = 0;
    }
    if (n > 0 || is_trial) {
        adjust_without(s, parts, is_trial ? OUT_TO_SEE : OUT);
    } else {
        s->phase = CONCLUDING;
    }
}

/* The view that was left out to see is judged by the limit that the others set: it stays
 * out, or the rig before stands. */
static void end_trial(rigcal_judge_solver *s)
{
    const int is_out = s->tried_cost > COST_LIMIT * s->scale;
    for (size_t v = 0; v < s->rig->n_views; v++) {
        if (s->left_out[v] == OUT_TO_SEE) {
            s->left_out[v] = is_out ? OUT : 0;
        }
    }
    s->tried_cost = 0;
    if (is_out) {
        return;
    }
    s->rounds = ROUNDS;
    begin_adjustment(s);
}

/* The rig has been adjusted, and the costs are known. */
static void decide(rigcal_judge_solver *s)
{
    if (s->tried_cost > 0) {
        end_trial(s);
    }
    if (s->phase == ADJUSTING) {
        return;
    }
    if (!s->is_placed) {
        begin_pass(s, PLACING);
    } else {
        s->phase = (s->rounds++ < ROUNDS) ? NAMING : CONCLUDING;
    }
}

/* The cost of that place in the order of size. */
static rigcal_real cost_at(const rigcal_judge_solver *s, size_t place)
{
    rigcal_real low = 0, high = 0;
    for (int k = 0; k <= HALVINGS; k++) {
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

/* By how much the views differ more than by noise, told by the middle one. */
static void set_scale(rigcal_judge_solver *s, const rc_rig_parts *parts)
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
    decide(s);
}

/* ---- placing again ---------------------------------------------------------- */

static int32_t taken(const rigcal_judge_solver *s, size_t v)
{
    return (s->left_out[v] == 0) ? s->choice->takes[v] : RIGCAL_TAKES_NONE;
}

/* Which views of the placement under way agree, and where it then is, if that is not what
 * it was. `verdict` holds meanwhile what a view took. */
static rigcal_status choose_placement(rigcal_judge_solver *s, const rc_rig_parts *parts,
                                      size_t count)
{
    const rigcal_real limit = RC_CHOOSE_LIMIT * s->scale * s->sigma2;
    const int is_double =
        s->choice->second_poses != NULL || s->choice->second_source != NULL;
    rc_claim *const claims =
        (rc_claim *)(void *)(is_double ? &parts->d[s->adjust.n] : parts->W);
    uint8_t *const takes = s->choice->takes;
    size_t n = 0;
    rc_support support;
    for (size_t v = s->first; v < s->first + count; v++) {
        s->judged[v].verdict = taken(s, v);
        for (int candidate = 0; candidate <= is_double; candidate++) {
            const rigcal_status status = claim_of(&claims[n], s, v, candidate, 1);
            if (status != RIGCAL_OK) {
                return status;
            }
            n += claims[n].view >= 0;
        }
    }
    const size_t best = rc_choose_place(&support, takes, claims, n, limit);
    for (size_t v = s->first; v < s->first + count; v++) {
        s->left_out[v] = takes[v] == RIGCAL_TAKES_NONE;
        if (takes[v] != s->judged[v].verdict) {
            s->rig->rig_from_placements[s->placement] = claims[best].b_from_a;
        }
    }
    return RIGCAL_OK;
}

static void place_again(rigcal_judge_solver *s, const rc_rig_parts *parts)
{
    const size_t count = rc_rig_views_of(parts, s->placement);
    const rigcal_status status = choose_placement(s, parts, count);
    if (status != RIGCAL_OK) {
        end(s, status, (int32_t)s->first);
        return;
    }
    s->view += count;
    s->placement++;
    next_placement(s, parts);
    if (s->placement < s->rig->n_placements) {
        return;
    }
    s->is_placed = 1;
    const rigcal_status lone = leave_out_lone(s, parts, OUT);
    if (lone != RIGCAL_OK) {
        end(s, lone, -1);
        return;
    }
    for (size_t v = 0; v < s->rig->n_views; v++) {
        if (taken(s, v) != s->judged[v].verdict) {
            begin_adjustment(s);
            return;
        }
    }
    decide(s);
}

/* ---- the search ------------------------------------------------------------- */

/* The views in turn, as the join checks them: they are not left out before. */
static void checking_step(rigcal_judge_solver *s, const rc_rig_parts *parts)
{
    const size_t v = s->adjust.view;
    rc_rig_step(&s->adjust);
    const rigcal_status status =
        (s->adjust.phase == RC_RIG_DONE) ? s->adjust.search.status : check_view(s, v);
    if (status != RIGCAL_OK) {
        end(s, status, (s->adjust.phase == RC_RIG_DONE) ? s->adjust.at_fault : (int32_t)v);
    } else if (s->adjust.phase == RC_RIG_CHECKED) {
        adjust_without(s, parts, OUT);
    }
}

static void conclude(rigcal_judge_solver *s, const rc_rig_parts *parts)
{
    size_t first = 0, last = 0;
    for (size_t f = 0; f < s->rig->n_placements; f++) {
        const size_t count = rc_rig_views_of(parts, f);
        const size_t kept = kept_of(&last, s, first, count);
        for (size_t v = first; v < first + count; v++) {
            const int is_out = s->left_out[v] != 0;
            const int32_t verdict = (count == 1 || (kept == 1 && !is_out))
                                        ? RIGCAL_VIEW_UNCHECKED
                                    : (kept == 0) ? RIGCAL_VIEW_ONE_OF_TWO
                                    : is_out      ? RIGCAL_VIEW_CONTRADICTS
                                                  : RIGCAL_VIEW_FITS;
            s->judged[v].verdict = verdict;
            if (is_out) {
                s->choice->takes[v] = RIGCAL_TAKES_NONE;
            }
            s->judged[v].cost = rc_max(0, s->judged[v].cost) / (COST_LIMIT * s->scale);
            s->n_of[verdict]++;
        }
        first += count;
    }
    end(s, RIGCAL_OK, -1);
}

static void adjust_step(rigcal_judge_solver *s)
{
    rigcal_rig_fit fit;
    int32_t at_fault;
    if (rigcal_rig_step(&s->adjust, 1) == RIGCAL_RUNNING) {
        return;
    }
    const rigcal_status status = rigcal_rig_result(&fit, &at_fault, &s->adjust);
    if (status < 0) {
        end(s, status, at_fault);
    } else {
        s->sigma2 = rc_max(s->sigma2, s->adjust.negligible);
        begin_pass(s, EVALUATING);
    }
}

static void step(rigcal_judge_solver *s)
{
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, s->rig, s->adjust.n);
    switch (s->phase) {
    case CHECKING:
        checking_step(s, &parts);
        break;
    case SCALING:
        set_scale(s, &parts);
        break;
    case ADJUSTING:
        adjust_step(s);
        break;
    case EVALUATING:
        evaluate_view(s, &parts);
        break;
    case COSTING:
        cost_view(s, &parts);
        break;
    case PLACING:
        place_again(s, &parts);
        break;
    case NAMING:
        name_worst(s, &parts);
        break;
    default:
        conclude(s, &parts);
        break;
    }
}

size_t rigcal_judge_work(size_t n_cameras, size_t n_placements)
{
    return RIGCAL_JUDGE_WORK(n_cameras, n_placements);
}

static rigcal_status check(const rigcal_judged_view judged[], const uint8_t left_out[],
                           const rigcal_choice *choice, const rigcal_rig *rig)
{
    const rigcal_status status = rc_rig_check(rig);
    if (judged == NULL || left_out == NULL || choice == NULL || choice->takes == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    if (rig->view_poses == NULL && rig->view_pose_source == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (rig->work_capacity < rigcal_judge_work(rig->n_cameras, rig->n_placements)) {
        return RIGCAL_ERR_CAPACITY;
    }
    const rigcal_status noise = rc_check_noise(&choice->sigma_px);
    return (noise == RIGCAL_OK && !(choice->sigma_px > 0)) ? RIGCAL_ERR_RANGE : noise;
}

rigcal_status rigcal_judge_begin(rigcal_judge_solver *solver, rigcal_judged_view judged[],
                                 uint8_t left_out[], rigcal_choice *choice, rigcal_rig *rig)
{
    if (solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = check(judged, left_out, choice, rig);
    if (status == RIGCAL_OK) { /* all that an adjustment wants */
        status = rigcal_rig_begin(&solver->adjust, rig);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    *solver = (rigcal_judge_solver){0};
    solver->rig = rig;
    solver->judged = judged;
    solver->choice = choice;
    solver->left_out = left_out;
    solver->sigma2 = choice->sigma_px * choice->sigma_px;
    for (size_t v = 0; v < rig->n_views; v++) {
        left_out[v] = 0;
    }
    rig->left_out = left_out;
    solver->phase = CHECKING;
    return rigcal_rig_join_begin(&solver->adjust, rig); /* which checks the poses */
}

rigcal_status rigcal_judge_step(rigcal_judge_solver *solver, int32_t budget)
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
    for (; budget > 0 && solver->phase != DONE; budget--) {
        step(solver);
    }
    return (solver->phase == DONE) ? RIGCAL_OK : RIGCAL_RUNNING;
}

rigcal_status rigcal_judge_result(rigcal_judgement *judgement, int32_t *at_fault,
                                  const rigcal_judge_solver *solver)
{
    if (at_fault != NULL) {
        *at_fault = -1;
    }
    if (judgement == NULL || solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (solver->phase != DONE) {
        return RIGCAL_ERR_STATE;
    }
    if (at_fault != NULL) {
        *at_fault = solver->at_fault;
    }
    if (solver->status != RIGCAL_OK) {
        return solver->status;
    }
    const int32_t *const n = solver->n_of;
    const rigcal_status status = rigcal_rig_result(&judgement->fit, NULL, &solver->adjust);
    judgement->sigma_px = RC_SQRT(solver->sigma2);
    judgement->scale = solver->scale;
    judgement->n_fit = n[RIGCAL_VIEW_FITS];
    judgement->n_contradict = n[RIGCAL_VIEW_CONTRADICTS];
    judgement->n_one_of_two = n[RIGCAL_VIEW_ONE_OF_TWO];
    judgement->n_unchecked = n[RIGCAL_VIEW_UNCHECKED];
    judgement->adjustments = solver->adjustments;
    return (status == RIGCAL_OK && judgement->n_contradict + judgement->n_one_of_two > 0)
               ? RIGCAL_VIEWS_LEFT_OUT
               : status;
}

rigcal_status rigcal_rig_judge(rigcal_judgement *judgement, int32_t *at_fault,
                               rigcal_judged_view judged[], uint8_t left_out[],
                               rigcal_choice *choice, rigcal_rig *rig)
{
    rigcal_judge_solver solver;
    if (at_fault != NULL) {
        *at_fault = -1;
    }
    if (judgement == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = rigcal_judge_begin(&solver, judged, left_out, choice, rig);
    if (status != RIGCAL_OK) {
        return status;
    }
    while (rigcal_judge_step(&solver, 1000) == RIGCAL_RUNNING) {
    }
    return rigcal_judge_result(judgement, at_fault, &solver);
}
