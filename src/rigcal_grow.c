#include "rc_chance.h"
#include "rc_graph.h"
#include "rc_score.h"

/* Scores pairs of cameras and takes the best pair as the seed. Then one camera after the
 * other joins. The placements that it sees are placed anew each time (CHOICE in
 * EQUATIONS.md). */

/* ---- constants ----------------------------------------------------------- */

/* share: a rung is high enough if at least this share of the placements that agree at the
 * next rung agree at it. */
#define RUNG_ENOUGH RC(0.8)

/* share of the placements: if fewer of them agree, the views contradict each other. */
#define SHARE_LEAST RC(0.5)

/* placements: two cameras are believed against the others if they agree in this many,
 * besides the one that joins them. */
enum { SURE_LEAST = 2 };

/* rung: the highest at which two cameras are believed so. At higher rungs wrong views agree
 * by chance. */
enum { SURE_RUNG = 2 };

/* pairs: the number that is scored for each camera, those that share most information. More
 * take more time. */
enum { PAIRS_MOST = 3 };

/* views: this many views of a placement, those with most information, may place it. */
enum { VIEWS_MOST = 8 };

enum { CHECKING = 1, WEIGHING, PAIRING, SCORING, CLAIMING, SUPPORTING, RESECTING, DONE };

/* ---- what is handed in --------------------------------------------------- */

/* Reads and checks the second pose of a view. Keeps the variance that the first pose's fit
 * leaves, from which the noise is found. */
RC_APART static rigcal_status check_second(rigcal_choose_solver *s, const rc_score_parts *p,
                                           size_t view)
{
    rigcal_view_pose first, second;
    rigcal_status status = rc_candidate_at(&first, s->choice, s->check.rig, view, 0);
    p->camera[view] = p->told[view] = -1;
    s->choice->takes[view] = RIGCAL_TAKES_NONE;
    if (status != RIGCAL_OK || rc_rig_is_left_out(s->check.rig, view)) {
        return status;
    }
    status = rc_candidate_at(&second, s->choice, s->check.rig, view, 1);
    if (status != RIGCAL_OK) {
        return status;
    }
    p->camera[view] = (rigcal_real)first.camera;
    if (first.n > 3 && first.n <= RC_COUNT_MAX) {
        p->told[view] = first.sse / rc_chi2_limit(rc_freedom(first.n), 0);
    }
    if (second.n == 0) {
        return RIGCAL_OK;
    }
    return (second.camera != first.camera || second.placement != first.placement)
               ? RIGCAL_ERR_RANGE
               : rc_check_pose(&second);
}

static rigcal_status begin_weighing(rigcal_choose_solver *s, const rc_score_parts *p)
{
    const rigcal_rig *const rig = s->check.rig;
    const rigcal_real variance = rc_score_variance(rig, p);
    rc_rig_parts parts;
    if (!(variance > 0)) {
        return RIGCAL_ERR_TOO_FEW;
    }
    s->choice->sigma_px = RC_SQRT(variance);
    s->limit = RC_CHOOSE_LIMIT * variance;
    rc_rig_parts_of(&parts, rig, 0);
    p->first[0] = 0;
    for (size_t f = 0; f < rig->n_placements; f++) {
        p->first[f + 1] = p->first[f] + (rigcal_real)rc_rig_views_of(&parts, f);
    }
    rc_clear(p->placed, 2 * rig->n_placements);
    rc_clear(p->links, RIGCAL_LINKS(rig->n_cameras));
    rc_clear(p->score, 3 * rig->n_cameras);
    s->phase = WEIGHING;
    return RIGCAL_OK;
}

static rigcal_status checking_step(rigcal_choose_solver *s, const rc_score_parts *p)
{
    const size_t view = s->check.view;
    const rigcal_status status = rc_views_step(&s->check);
    const rigcal_status second = (status < 0) ? RIGCAL_OK : check_second(s, p, view);
    if (second != RIGCAL_OK || (status < 0 && s->check.view == view)) {
        s->check.at_fault = (int32_t)view;
    }
    if (status < 0 || second != RIGCAL_OK) {
        return (status < 0) ? status : second;
    }
    return (status == RIGCAL_OK) ? begin_weighing(s, p) : RIGCAL_OK;
}

static rigcal_real *link_of(const rc_score_parts *p, size_t a, size_t b)
{
    return &p->links[(a < b) ? RIGCAL_LINK(a, b) : RIGCAL_LINK(b, a)];
}

static void begin_pairing(rigcal_choose_solver *s)
{
    for (int k = 0; k < RIGCAL_CHOOSE_RUNGS; k++) {
        s->seed[k].b = -1;
    }
    s->which = s->view = 0; /* the two cameras of a pair */
    s->phase = PAIRING;
}

/* Computes the information of a view. Adds what it shares with the placement's earlier
 * views to the links of their cameras. */
RC_APART static rigcal_status weighing_step(rigcal_choose_solver *s,
                                            const rc_score_parts *p)
{
    rigcal_view_pose pose;
    const size_t view = s->view;
    const rigcal_status status = rc_rig_pose_at(&pose, s->check.rig, view);
    if (status != RIGCAL_OK) {
        return status;
    }
    p->told[view] = (p->camera[view] < 0) ? 0 : rc_view_information(&pose);
    for (size_t v = (size_t)p->first[pose.placement]; v < view; v++) {
        if (p->camera[v] >= 0 && p->camera[view] >= 0) {
            *link_of(p, (size_t)p->camera[v], (size_t)p->camera[view]) +=
                rc_information_of_both(p->told[v], p->told[view]);
        }
    }
    if (++s->view == s->check.rig->n_views) {
        begin_pairing(s);
    }
    return RIGCAL_OK;
}

/* ---- which pairs are scored ---------------------------------------------- */

/* How many links of camera a have more information than its link to b. Of equal links the
 * one to the lower camera counts as more. */
static size_t rank_of(const rc_score_parts *p, size_t n_cameras, size_t a, size_t b)
{
    const rigcal_real link = *link_of(p, a, b);
    size_t rank = 0;
    for (size_t d = 0; d < n_cameras; d++) {
        if (d != a && d != b) {
            const rigcal_real other = *link_of(p, a, d);
            rank += (other > link || (!(other < link) && d < b));
        }
    }
    return rank;
}

static int is_joined(const rc_score_parts *p, size_t camera)
{
    return p->state[camera] >= RC_JOINED && p->state[camera] <= RC_JOINED;
}

/* Whether a pair is scored. Only pairs of cameras that have not joined are: of a camera
 * that has not joined, none that shares a placement with it has. */
static int is_scored(const rigcal_choose_solver *s, const rc_score_parts *p, size_t a,
                     size_t b)
{
    const size_t C = s->check.rig->n_cameras;
    return *link_of(p, a, b) > 0 && !is_joined(p, a) &&
           (rank_of(p, C, a, b) < PAIRS_MOST || rank_of(p, C, b, a) < PAIRS_MOST);
}

static rigcal_real total_of(const rc_score_parts *p, size_t n_cameras, size_t camera)
{
    rigcal_real sum = 0;
    for (size_t d = 0; d < n_cameras; d++) {
        sum += (d == camera) ? 0 : *link_of(p, camera, d);
    }
    return sum;
}

/* A pair has been scored: keeps the best hypothesis at each rung. */
static void finish_pair(rigcal_choose_solver *s, const rc_score_parts *p)
{
    for (int k = 0; k < RIGCAL_CHOOSE_RUNGS; k++) {
        rigcal_seed *const seed = &s->seed[k], found = {0, s->a, s->b, 0, (int32_t)s->n};
        found.score = rc_score_best(&found.number, s, p, k);
        s->counts[k] += (rigcal_real)(rc_score_agree(found.score) - 1);
        if (seed->b < 0 || found.score > seed->score) {
            *seed = found;
        }
    }
    s->most += (rigcal_real)(s->n - 1);
    s->phase = PAIRING;
}

/* ---- growing ------------------------------------------------------------- */

static void begin_placing(rigcal_choose_solver *s)
{
    s->placement = s->view = s->n = 0;
    s->phase = CLAIMING;
}

/* A camera joins. The placements that it sees must be placed anew, unless enough cameras
 * have seen them. Waiting cameras that see one of these are scored again. */
static void join(rigcal_choose_solver *s, const rc_score_parts *p, size_t camera)
{
    p->state[camera] = RC_JOINED;
    for (size_t f = 0; f < s->check.rig->n_placements; f++) {
        const size_t end = (size_t)p->first[f + 1];
        int n = 0, is_seen = 0;
        for (size_t v = (size_t)p->first[f]; v < end; v++) {
            if (p->camera[v] >= 0) {
                const size_t c = (size_t)p->camera[v];
                is_seen |= (c == camera);
                n += is_joined(p, c);
            }
        }
        if (!is_seen || n > VIEWS_MOST) {
            continue;
        }
        p->strength[f] = RC_STALE;
        for (size_t v = (size_t)p->first[f]; v < end; v++) {
            if (p->camera[v] >= 0 && !is_joined(p, (size_t)p->camera[v])) {
                p->state[(size_t)p->camera[v]] = RC_CHANGED;
            }
        }
    }
    begin_placing(s);
}

/* Camera s->b joins by the hypothesis of this number. */
static rigcal_status join_by(rigcal_choose_solver *s, const rc_score_parts *p,
                             int32_t number)
{
    const size_t camera = (size_t)s->b;
    const rigcal_status status = rc_score_claim(&p->cams[camera], s, p, (size_t)number);
    if (status == RIGCAL_OK) {
        join(s, p, camera);
    }
    return status;
}

/* Whether two cameras agree in most of the placements that they share. Then other cameras
 * may be wrong throughout, and are left out. The hypothesis' own placement does not
 * count. */
static int is_sure(const rigcal_seed *seed)
{
    const int32_t agree = rc_score_agree(seed->score) - 1;
    return agree >= SURE_LEAST &&
           (rigcal_real)agree >= SHARE_LEAST * (rigcal_real)(seed->n - 1);
}

/* Sets tau^2: that of the first rung to which the next one adds little. Returns 0 if the
 * views contradict each other. */
static int choose_rung(rigcal_choose_solver *s)
{
    rigcal_choice *const choice = s->choice;
    int k = 0;
    while (k < RIGCAL_CHOOSE_RUNGS - 2 &&
           (!(s->counts[k] > 0) || !(s->counts[k] >= RUNG_ENOUGH * s->counts[k + 1]))) {
        k++;
    }
    s->rung = k;
    choice->tau2 = rc_score_tau2(k);
    choice->share = (s->most > 0) ? s->counts[k] / s->most : 0;
    return !(s->most > 0) || choice->share >= SHARE_LEAST ||
           (k <= SURE_RUNG && is_sure(&s->seed[k]));
}

/* The best pair is the seed, and its first camera the frame for now. If there is no pair,
 * one camera that has not joined begins by itself. */
RC_APART static rigcal_status begin_frame(rigcal_choose_solver *s, const rc_score_parts *p)
{
    if (!s->is_again && !choose_rung(s)) {
        return RIGCAL_ERR_CONTRADICTION;
    }
    const rigcal_seed best = s->seed[s->rung];
    size_t first = 0;
    while (is_joined(p, first)) {
        first++;
    }
    for (size_t c = 0; c < s->check.rig->n_cameras; c++) {
        p->score[c] = RC_SCORE_NONE;
    }
    s->is_again = 1;
    s->a = best.a;
    s->b = best.b;
    first = (best.b < 0) ? first : (size_t)best.a;
    p->cams[first] = (rc_claim){0};
    rc_transform_identity(&p->cams[first].b_from_a);
    join(s, p, first);
    return (best.b < 0) ? RIGCAL_OK : join_by(s, p, best.number);
}

/* Begins the next pair. Camera a, the frame, is the one that shares more information with
 * all cameras. So the order of the cameras does not matter. */
static rigcal_status pairing_step(rigcal_choose_solver *s, const rc_score_parts *p)
{
    const size_t C = s->check.rig->n_cameras;
    if (++s->which >= s->view) {
        s->which = 0;
        s->view++;
    }
    if (s->view >= C) {
        return begin_frame(s, p);
    }
    if (is_scored(s, p, s->which, s->view)) {
        const int is_less = total_of(p, C, s->which) < total_of(p, C, s->view);
        s->a = (int32_t)(is_less ? s->view : s->which);
        s->b = (int32_t)(is_less ? s->which : s->view);
        if (rc_score_begin(s, p)) { /* not where a source has changed a placement */
            s->phase = SCORING;
        }
    }
    return RIGCAL_OK;
}

static rigcal_status scoring_step(rigcal_choose_solver *s, const rc_score_parts *p)
{
    const rigcal_status status = rc_score_step(s, p);
    if (status != RIGCAL_OK) {
        return (status == RIGCAL_RUNNING) ? RIGCAL_OK : status;
    }
    if (s->a >= 0) {
        finish_pair(s, p);
        return RIGCAL_OK;
    }
    int32_t number;
    p->score[s->b] = rc_score_best(&number, s, p, s->rung);
    p->number[s->b] = (rigcal_real)number;
    s->phase = RESECTING;
    return RIGCAL_OK;
}

/* Marks all waiting cameras to be scored. If is_relaxed, placements whose views disagree
 * count too. Returns how many cameras wait. */
static size_t score_all(rigcal_choose_solver *s, const rc_score_parts *p, int is_relaxed)
{
    size_t n = 0;
    s->is_relaxed = is_relaxed;
    for (size_t c = 0; c < s->check.rig->n_cameras; c++) {
        if (!is_joined(p, c)) {
            p->state[c] = RC_CHANGED;
            n++;
        }
    }
    return n;
}

static rigcal_status resecting_step(rigcal_choose_solver *s, const rc_score_parts *p)
{
    const size_t C = s->check.rig->n_cameras;
    size_t best = C;
    s->a = -1;
    for (size_t c = 0; c < C; c++) {
        if (p->state[c] > RC_JOINED) {
            p->state[c] = RC_WAITS;
            p->score[c] = RC_SCORE_NONE;
            s->b = (int32_t)c;
            if (rc_score_begin(s, p)) {
                s->phase = SCORING;
            }
            return RIGCAL_OK;
        }
        if (!(p->state[c] > 0) && p->score[c] > RC_SCORE_NONE &&
            (best == C || p->score[c] > p->score[best])) {
            best = c;
        }
    }
    if (best < C) {
        s->b = (int32_t)best;
        const rigcal_status status = join_by(s, p, (int32_t)p->number[best]);
        if (s->is_relaxed) {
            (void)score_all(s, p, 0);
        }
        return status;
    }
    if (score_all(s, p, !s->is_relaxed) == 0) { /* all have joined */
        s->is_final = 1;
        for (size_t f = 0; f < s->check.rig->n_placements; f++) {
            p->strength[f] = RC_STALE;
        }
        begin_placing(s);
    } else if (!s->is_relaxed) { /* relaxed scores joined none: begin another group */
        begin_pairing(s);
    }
    return RIGCAL_OK;
}

/* ---- the frame ----------------------------------------------------------- */

/* Writes where a camera is, or should be. Returns 1 if the caller gave it: a prior or a
 * held pose. */
static int is_given(rigcal_transform *cam_from_rig, const rigcal_rig *rig, size_t camera)
{
    if (rc_rig_has_prior(rig, camera)) {
        *cam_from_rig = rig->priors[camera].cam_from_rig;
        return 1;
    }
    *cam_from_rig = rig->cams_from_rig[camera];
    return rc_rig_is_held(rig, camera);
}

/* Moves a group from the frame in which it grew to the frame of the rig. `camera` gets the
 * pose that was given, or else the identity. */
RC_APART static void set_frame(const rigcal_choose_solver *s, const rc_score_parts *p,
                               size_t camera)
{
    rigcal_rig *const rig = s->check.rig;
    rigcal_transform given, back, grown_from_rig, rig_from_grown;
    if (!is_given(&given, rig, camera)) {
        rc_transform_identity(&given);
    }
    rc_transform_invert(&back, &p->cams[camera].b_from_a);
    rc_transform_compose(&grown_from_rig, &back, &given);
    rc_transform_invert(&rig_from_grown, &grown_from_rig);
    for (size_t f = 0; f < rig->n_placements; f++) {
        rigcal_transform *const placement = &rig->rig_from_placements[f];
        const size_t by = (size_t)p->placed[f] / 2;
        if (p->strength[f] > RC_STALE &&
            rig->group[(size_t)p->camera[by]] == rig->group[camera]) {
            const rigcal_transform grown = *placement;
            rc_transform_compose(placement, &rig_from_grown, &grown);
        }
    }
    for (size_t c = 0; c < rig->n_cameras; c++) {
        rigcal_transform *const cam_from_rig = &rig->cams_from_rig[c];
        if (rig->group[c] == rig->group[camera] && !is_given(cam_from_rig, rig, c)) {
            rc_transform_compose(cam_from_rig, &p->cams[c].b_from_a, &grown_from_rig);
        }
    }
}

/* Finishes the choice. The frame of each group is that of its first camera that is given,
 * or else that of its first camera. */
static void finish(rigcal_choose_solver *s, const rc_score_parts *p)
{
    const rigcal_rig *const rig = s->check.rig;
    rigcal_transform ignored;
    for (size_t c = 0; c < rig->n_cameras; c++) {
        size_t first = c, given = rig->n_cameras;
        for (size_t d = rig->n_cameras; d-- > 0;) {
            if (rig->group[d] == rig->group[c]) {
                first = d;
                given = is_given(&ignored, rig, d) ? d : given;
            }
        }
        if (first == c) {
            set_frame(s, p, (given < rig->n_cameras) ? given : first);
        }
    }
    s->choice->n_left_out = 0;
    for (size_t v = 0; v < rig->n_views; v++) {
        s->choice->n_left_out += (s->choice->takes[v] == RIGCAL_TAKES_NONE);
    }
    rc_rig_forget(rig);
    s->status = s->check.is_disconnected ? RIGCAL_DISCONNECTED : RIGCAL_OK;
    s->phase = DONE;
}

/* ---- placing ------------------------------------------------------------- */

/* Whether a claim comes from one of the VIEWS_MOST views of most information. */
static int may_place(const rigcal_choose_solver *s, const rc_score_parts *p, size_t which)
{
    const rigcal_real told = p->told[(size_t)p->claims[which].view];
    int more = 0;
    for (size_t i = 0; i < s->n; i++) {
        const rc_claim *const other = &p->claims[i];
        more += (!(other->candidate > 0) && p->told[(size_t)other->view] > told);
    }
    return more < VIEWS_MOST;
}

/* Adds the claims of the next view about its placement. */
RC_APART static rigcal_status claiming_step(rigcal_choose_solver *s,
                                            const rc_score_parts *p)
{
    const size_t view = (size_t)p->first[s->placement] + s->view;
    const rigcal_real strength = p->strength[s->placement];
    if (strength > RC_STALE || strength < RC_STALE ||
        view == (size_t)p->first[s->placement + 1]) {
        s->which = 0;
        s->best = -1;
        s->phase = SUPPORTING;
        return RIGCAL_OK;
    }
    s->view++;
    if (p->camera[view] < 0 || !is_joined(p, (size_t)p->camera[view])) {
        return RIGCAL_OK;
    }
    rc_claim own[2];
    const rigcal_status status = rc_candidates(own, s, view);
    for (int i = 0; i < 2 && status == RIGCAL_OK; i++) {
        if (own[i].view >= 0) {
            rc_claim_place(&p->claims[s->n++], &own[i], &p->cams[(size_t)p->camera[view]],
                           1);
        }
    }
    return status;
}

static void place(rigcal_choose_solver *s, const rc_score_parts *p)
{
    const rc_claim *const best = &p->claims[s->best];
    rc_support support;
    rc_choose_support(&support, s->choice->takes, p->claims, s->n, (size_t)s->best,
                      s->limit * s->choice->tau2);
    s->check.rig->rig_from_placements[s->placement] = best->b_from_a;
    p->placed[s->placement] = 2 * best->view + best->candidate;
    p->strength[s->placement] =
        (support.agree > 1 || support.n == 1) ? RC_KNOWN : RC_DOUBTFUL;
}

/* Compares one claim with all others of its placement. After the last one the placement is
 * placed. */
static void supporting_step(rigcal_choose_solver *s, const rc_score_parts *p)
{
    while (s->which < s->n && !may_place(s, p, s->which)) {
        s->which++;
    }
    if (s->which < s->n) {
        rc_support support;
        const rc_support before = {s->cost, s->spread, s->agree, 0};
        rc_choose_support(&support, NULL, p->claims, s->n, s->which,
                          s->limit * s->choice->tau2);
        if (s->best < 0 || rc_choose_is_better(&support, &before)) {
            s->best = (int32_t)s->which;
            s->cost = support.cost;
            s->spread = support.spread;
            s->agree = support.agree;
        }
        s->which++;
        return;
    }
    if (s->best >= 0) {
        place(s, p);
    }
    s->view = s->n = 0;
    s->phase = CLAIMING;
    if (++s->placement == s->check.rig->n_placements) {
        s->phase = RESECTING;
        if (s->is_final) {
            finish(s, p);
        }
    }
}

size_t rigcal_choose_work(size_t n_cameras, size_t n_placements, size_t n_views)
{
    return RIGCAL_CHOOSE_WORK(n_cameras, n_placements, n_views);
}

/* ---- public -------------------------------------------------------------- */

rigcal_status rigcal_choose_begin(rigcal_choose_solver *solver, rigcal_choice *choice,
                                  rigcal_rig *rig)
{
    if (solver == NULL || choice == NULL || choice->takes == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_rig_check(rig);
    if (status == RIGCAL_OK && rig->view_poses == NULL && rig->view_pose_source == NULL) {
        status = RIGCAL_ERR_NULL;
    }
    if (status == RIGCAL_OK && rigcal_choose_work(rig->n_cameras, rig->n_placements,
                                                  rig->n_views) > rig->work_capacity) {
        status = RIGCAL_ERR_CAPACITY;
    }
    for (size_t c = 0; status == RIGCAL_OK && c < rig->n_cameras; c++) {
        status =
            rc_rig_is_held(rig, c) ? rc_check_transform(&rig->cams_from_rig[c]) : RIGCAL_OK;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    *solver = (rigcal_choose_solver){0};
    solver->choice = choice;
    solver->check.rig = rig;
    solver->check.is_join = 1;
    solver->check.given = &rc_given_poses;
    solver->check.at_fault = -1;
    solver->phase = CHECKING;
    return rc_views_begin(&solver->check);
}

static rigcal_status one_step(rigcal_choose_solver *s, const rc_score_parts *p)
{
    switch (s->phase) {
    case CHECKING:
        return checking_step(s, p);
    case WEIGHING:
        return weighing_step(s, p);
    case PAIRING:
        return pairing_step(s, p);
    case SCORING:
        return scoring_step(s, p);
    case CLAIMING:
        return claiming_step(s, p);
    case RESECTING:
        return resecting_step(s, p);
    default:
        supporting_step(s, p);
        return RIGCAL_OK;
    }
}

rigcal_status rigcal_choose_step(rigcal_choose_solver *solver, int32_t budget)
{
    rc_score_parts p;
    rigcal_status status = rc_check_step((solver == NULL) ? NULL : &solver->phase, budget);
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_score_parts_of(&p, solver->check.rig);
    for (; budget > 0 && solver->phase != DONE; budget--) {
        status = one_step(solver, &p);
        if (status != RIGCAL_OK) {
            solver->status = status;
            solver->phase = DONE;
            rc_rig_forget(solver->check.rig);
        }
    }
    return (solver->phase == DONE) ? RIGCAL_OK : RIGCAL_RUNNING;
}

rigcal_status rigcal_choose_result(int32_t *at_fault, const rigcal_choose_solver *solver)
{
    if (at_fault != NULL) {
        *at_fault = -1;
    }
    if (solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (solver->phase != DONE) {
        return RIGCAL_ERR_STATE;
    }
    if (at_fault != NULL) {
        *at_fault = solver->check.at_fault;
    }
    return solver->status;
}

rigcal_status rigcal_rig_choose(rigcal_choice *choice, int32_t *at_fault, rigcal_rig *rig)
{
    rigcal_choose_solver solver;
    if (at_fault != NULL) {
        *at_fault = -1;
    }
    const rigcal_status status = rigcal_choose_begin(&solver, choice, rig);
    if (status != RIGCAL_OK) {
        return status;
    }
    while (rigcal_choose_step(&solver, 100) == RIGCAL_RUNNING) {
    }
    return rigcal_choose_result(at_fault, &solver);
}
