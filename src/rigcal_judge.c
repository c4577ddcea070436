#include "rc_cost.h"

#include "rc_adjust.h"
#include "rc_score.h"

/* ---- constants ----------------------------------------------------------- */

/* rounds: wrong views are named in at most this many rounds. Each round takes the worst
 * view of every placement. Wrong views that it hides follow in the next round. */
enum { ROUNDS = 3 };

/* ---- what is handed in ------------------------------------------------------ */

static void begin_adjustment(rigcal_judge_solver *s)
{
    const rigcal_status status = rigcal_rig_begin(&s->adjust, s->rig);
    s->phase = RC_JUDGE_ADJUSTING;
    s->adjustments++;
    if (status != RIGCAL_OK) {
        rc_judge_end(s, status, -1);
    }
}

/* Checks the second pose of a view, and what the choice says of the view. The first pose
 * has been checked. */
static rigcal_status check_view(rigcal_judge_solver *s, size_t v)
{
    rigcal_view_pose first, second;
    second.n = 0;
    rigcal_status status = rc_candidate_at(&first, s->choice, s->rig, v, 0);
    if (status == RIGCAL_OK) {
        status = rc_candidate_at(&second, s->choice, s->rig, v, 1);
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
            (second.n > 0 && (!(second.sse >= 0) || second.camera != first.camera ||
                              second.placement != first.placement)))
               ? RIGCAL_ERR_RANGE
               : RIGCAL_OK;
}

/* ---- naming ---------------------------------------------------------------- */

/* Values of left_out: for good, or only as a trial. */
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

/* If one view is left of a placement that several cameras saw, it is left out too. */
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

/* Leaves out the last view of a camera whose other views are left out. The camera would be
 * wherever this view puts it, and nothing shows that the view is right. */
static rigcal_status leave_out_lone_cameras(rigcal_judge_solver *s,
                                            const rc_rig_parts *parts, uint8_t mark)
{
    rigcal_real *const kept = parts->slot, *const all = parts->W; /* views of each camera */
    rc_clear(kept, s->rig->n_cameras);
    rc_clear(all, s->rig->n_cameras);
    for (int is_marking = 0; is_marking < 2; is_marking++) {
        for (size_t v = 0; v < s->rig->n_views; v++) {
            rigcal_view_pose own;
            const rigcal_status status = rc_candidate_at(&own, s->choice, s->rig, v, 0);
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

/* Begins an adjustment without the views that are left out. Views that then stand alone are
 * left out as well. */
static void adjust_without(rigcal_judge_solver *s, const rc_rig_parts *parts, uint8_t mark)
{
    const rigcal_status status = leave_out_lone(s, parts, mark);
    begin_adjustment(s);
    if (status != RIGCAL_OK) {
        rc_judge_end(s, status, -1);
    }
}

/* Takes back the views that were left out because their claims disagree, if their points
 * fit. Returns their number. */
static size_t take_back(rigcal_judge_solver *s)
{
    size_t n = 0;
    for (size_t v = 0; v < s->rig->n_views; v++) {
        const rigcal_judged_view *const judged = &s->judged[v];
        if (s->choice->takes[v] == RIGCAL_TAKES_NONE && judged->rms_px >= 0 &&
            judged->cost <= RC_COST_LIMIT * s->scale) {
            s->choice->takes[v] = RIGCAL_TAKES_FIRST;
            s->left_out[v] = 0;
            n++;
        }
    }
    return n;
}

/* Leaves out the worst view of each placement if its cost is above the limit. If no view is
 * left out, the worst of all is left out as a trial. So no view raises its own limit. */
static void name_worst(rigcal_judge_solver *s, const rc_rig_parts *parts)
{
    size_t first = 0, most = 0, n = 0;
    rigcal_real highest = 0;
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
        if (cost > RC_COST_LIMIT * s->scale) {
            s->left_out[worst] = OUT;
            n++;
        }
        if (cost > highest) {
            highest = cost;
            most = worst;
        }
        first = end_of;
    }
    n += (s->rounds == 1) ? take_back(s) : 0;
    const int is_trial = n == 0 && highest > RC_COST_LIMIT;
    s->tried_cost = is_trial ? highest : 0;
    if (is_trial) {
        s->left_out[most] = OUT_TO_SEE;
    }
    if (n > 0 || is_trial) {
        adjust_without(s, parts, is_trial ? OUT_TO_SEE : OUT);
    } else {
        s->phase = RC_JUDGE_CONCLUDING;
    }
}

/* Judges the view that was left out as a trial by the limit that the others set. It stays
 * out, or the rig before the trial is adjusted again. */
static void end_trial(rigcal_judge_solver *s)
{
    const int is_out = s->tried_cost > RC_COST_LIMIT * s->scale;
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

/* Chooses the next phase after the rig was adjusted and the costs are known. */
static void decide(rigcal_judge_solver *s)
{
    if (s->tried_cost > 0) {
        end_trial(s);
    }
    if (s->phase == RC_JUDGE_ADJUSTING) {
        return;
    }
    if (!s->is_placed) {
        rc_judge_begin_pass(s, RC_JUDGE_PLACING);
    } else {
        s->phase = (s->rounds++ < ROUNDS) ? RC_JUDGE_NAMING : RC_JUDGE_CONCLUDING;
    }
}

/* ---- placing again ---------------------------------------------------------- */

static int32_t taken(const rigcal_judge_solver *s, size_t v)
{
    return (s->left_out[v] == 0) ? s->choice->takes[v] : RIGCAL_TAKES_NONE;
}

/* Decides which views of the current placement agree. If others agree than before, the
 * placement is moved to where these views have it. Until the end `verdict` holds what a
 * view took before. */
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
            const rigcal_status status = rc_judge_claim(&claims[n], s, v, candidate, 1);
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
        rc_judge_end(s, status, (int32_t)s->first);
        return;
    }
    s->view += count;
    s->placement++;
    rc_judge_next_placement(s, parts);
    if (s->placement < s->rig->n_placements) {
        return;
    }
    s->is_placed = 1;
    const rigcal_status lone = leave_out_lone(s, parts, OUT);
    if (lone != RIGCAL_OK) {
        rc_judge_end(s, lone, -1);
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

/* Checks one view as the join checks it. All views are checked: none is left out yet. */
static void checking_step(rigcal_judge_solver *s, const rc_rig_parts *parts)
{
    const size_t v = s->adjust.view;
    rc_rig_step(&s->adjust);
    const rigcal_status status =
        (s->adjust.phase == RC_RIG_DONE) ? s->adjust.search.status : check_view(s, v);
    if (status != RIGCAL_OK) {
        rc_judge_end(s, status,
                     (s->adjust.phase == RC_RIG_DONE) ? s->adjust.at_fault : (int32_t)v);
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
            const int32_t verdict = (count == 1)  ? RIGCAL_VIEW_UNCHECKED
                                    : (kept == 0) ? RIGCAL_VIEW_ONE_OF_TWO
                                    : is_out      ? RIGCAL_VIEW_CONTRADICTS
                                                  : RIGCAL_VIEW_FITS;
            s->judged[v].verdict = verdict;
            if (is_out) {
                s->choice->takes[v] = RIGCAL_TAKES_NONE;
            }
            s->judged[v].cost = rc_max(0, s->judged[v].cost) / (RC_COST_LIMIT * s->scale);
            s->n_of[verdict]++;
        }
        first += count;
    }
    rc_judge_end(s, RIGCAL_OK, -1);
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
        rc_judge_end(s, status, at_fault);
    } else {
        s->sigma2 = rc_max(s->sigma2, s->adjust.negligible);
        rc_judge_begin_pass(s, RC_JUDGE_EVALUATING);
    }
}

static void step(rigcal_judge_solver *s)
{
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, s->rig, s->adjust.n);
    switch (s->phase) {
    case RC_JUDGE_CHECKING:
        checking_step(s, &parts);
        break;
    case RC_JUDGE_SCALING:
        rc_judge_set_scale(s, &parts);
        decide(s);
        break;
    case RC_JUDGE_ADJUSTING:
        adjust_step(s);
        break;
    case RC_JUDGE_EVALUATING:
        rc_judge_evaluate(s, &parts);
        break;
    case RC_JUDGE_COSTING:
        rc_judge_cost(s, &parts);
        break;
    case RC_JUDGE_PLACING:
        place_again(s, &parts);
        break;
    case RC_JUDGE_NAMING:
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
    if (status == RIGCAL_OK) { /* an adjustment needs all of these */
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
    solver->phase = RC_JUDGE_CHECKING;
    return rigcal_rig_join_begin(&solver->adjust, rig); /* checks the poses */
}

rigcal_status rigcal_judge_step(rigcal_judge_solver *solver, int32_t budget)
{
    const rigcal_status status =
        rc_check_step((solver == NULL) ? NULL : &solver->phase, budget);
    if (status != RIGCAL_OK) {
        return status;
    }
    for (; budget > 0 && solver->phase != RC_JUDGE_DONE; budget--) {
        step(solver);
    }
    return (solver->phase == RC_JUDGE_DONE) ? RIGCAL_OK : RIGCAL_RUNNING;
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
    if (solver->phase != RC_JUDGE_DONE) {
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
    while (rigcal_judge_step(&solver, 100) == RIGCAL_RUNNING) {
    }
    return rigcal_judge_result(judgement, at_fault, &solver);
}
