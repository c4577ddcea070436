#include "rc_chance.h"
#include "rc_choose.h"
#include "rc_graph.h"

/* The choice: pairs of cameras are scored, the best is the seed; then camera after camera
 * joins, and the placements that it sees are placed again (CHOICE in EQUATIONS.md). */

/* ---- constants ----------------------------------------------------------- */

/* sigma^2: of the limit below which two claims agree. Where noise is not all, right views
 * need more than 1. */
static const rigcal_real LADDER[RIGCAL_CHOOSE_RUNGS] = {1, 4, 16, 64, 256, 1024};

/* share: a rung is high enough when the next one makes no more than 1 / this agree. */
#define RUNG_ENOUGH RC(0.8)

/* share: of views, below which they contradict each other. */
#define SHARE_LEAST RC(0.5)

/* px: the least noise that is believed where none is stated. Pixels are not better. */
#define NOISE_LEAST RC(0.01)

/* halvings: of a search of the median. Its error is this part of the largest. */
enum { HALVINGS = 60 };

/* pairs: with each camera, that are scored besides those of the tree. More take time. */
enum { PAIRS_MORE = 3 };

/* views: of a placement, of most information. Those may place it, and when so many have,
 * another camera does not place it again. */
enum { VIEWS_MOST = 8 };

enum {
    CHECKING = 1,
    WEIGHING,
    PAIRING,
    LISTING,
    SCORING,
    CLAIMING,
    SUPPORTING,
    RESECTING,
    FRAMING,
    DONE
};

enum { PLACEMENTS = RIGCAL_CHOOSE_PLACEMENTS, HYPOTHESES = 4 * PLACEMENTS };

/* Of a camera. */
enum { WAITS = 0, JOINED = 1, CHANGED = 2 };

/* Of a placement: no joined camera saw it; it is to be placed; its views disagree; they
 * agree, or it is one view. */
enum { UNSEEN = 0, STALE = 1, DOUBTFUL = 2, KNOWN = 3 };

/* ---- memory -------------------------------------------------------------- */

typedef struct {
    rigcal_real *count;          /* of each placement: its views, */
    rigcal_real *first;          /* the first of them, */
    rigcal_real *placed;         /* the view that placed it: 2 view + candidate, */
    rigcal_real *strength;       /* and how well */
    rigcal_real *camera, *told;  /* of each view; what it tells */
    rigcal_real *links;          /* of two cameras */
    rigcal_real *score, *number; /* of each camera, its best hypothesis */
    rigcal_real *state;          /* of each camera */
    rc_claim *cams;              /* cam_from_rig of the joined ones */
    rigcal_real *list, *scores;  /* of placements, and the hypotheses there */
    rc_claim *rows;              /* hypotheses of two placements, 4 each */
    rc_claim *claims;            /* in the same memory: of one placement */
} grow_parts;

static void parts_of(grow_parts *p, const rigcal_choose_solver *s)
{
    const rigcal_rig *const rig = s->check.rig;
    const size_t C = rig->n_cameras, F = rig->n_placements;
    rc_rig_parts own;
    rc_rig_parts_of(&own, rig, 0);
    p->count = own.count;
    p->first = own.W;
    p->placed = p->first + F;
    p->strength = p->placed + F;
    p->camera = p->strength + F;
    p->told = p->camera + rig->n_views;
    p->links = p->told + rig->n_views;
    p->score = p->links + RIGCAL_LINKS(C);
    p->number = p->score + C;
    p->state = p->number + C;
    p->cams = (rc_claim *)(void *)(p->state + C);
    p->list = p->state + C + RC_CLAIM_REALS * C;
    p->scores = p->list + PLACEMENTS;
    p->rows = (rc_claim *)(void *)(p->scores + RIGCAL_CHOOSE_RUNGS * HYPOTHESES);
    p->claims = (rc_claim *)(void *)p->list;
}

size_t rigcal_choose_work(size_t n_cameras, size_t n_placements, size_t n_views)
{
    return RIGCAL_CHOOSE_WORK(n_cameras, n_placements, n_views);
}

static void fail(rigcal_choose_solver *s, rigcal_status status)
{
    s->status = status;
    s->phase = DONE;
    rc_rig_forget(s->check.rig);
}

/* ---- what is handed in --------------------------------------------------- */

/* Pose 0 or 1 of a view; n is 0 where there is none. */
static rigcal_status candidate_at(rigcal_view_pose *pose, const rigcal_choose_solver *s,
                                  size_t view, int candidate)
{
    const rigcal_rig *const rig = s->check.rig;
    const rigcal_choice *const choice = s->choice;
    if (candidate == 0) {
        return rc_rig_pose_at(pose, rig, view);
    }
    if (choice->second_poses != NULL) {
        *pose = choice->second_poses[view];
        return RIGCAL_OK;
    }
    pose->n = 0;
    return (choice->second_source == NULL)
               ? RIGCAL_OK
               : choice->second_source(pose, view, rig->context);
}

/* Both poses of a view as claims; those that are not there have view -1. */
static rigcal_status claims_of(rc_claim claims[2], const rigcal_choose_solver *s,
                               size_t view)
{
    rigcal_real first_sse = 0;
    for (int i = 0; i < 2; i++) {
        rigcal_view_pose pose;
        const rigcal_status status = candidate_at(&pose, s, view, i);
        if (status != RIGCAL_OK) {
            return status;
        }
        first_sse = (i == 0) ? pose.sse : first_sse;
        claims[i].view = -1;
        if (pose.n > 0 &&
            !rc_claim_of_view(&claims[i], &pose, first_sse, (int32_t)view, i)) {
            return RIGCAL_ERR_DEGENERATE;
        }
    }
    return RIGCAL_OK;
}

/* Both poses of the view that has just been checked. */
static rigcal_status check_both(rigcal_choose_solver *s, const grow_parts *p, size_t view)
{
    rigcal_view_pose first, second;
    rc_sym6_factor L;
    rigcal_status status = candidate_at(&first, s, view, 0);
    if (status == RIGCAL_OK) {
        status = candidate_at(&second, s, view, 1);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    p->camera[view] = (rigcal_real)first.camera;
    p->told[view] = (first.n > 3) ? first.sse / rc_chi2_limit(rc_freedom(first.n), 0) : -1;
    s->choice->takes[view] = RIGCAL_TAKES_NONE;
    if (first.n > RC_COUNT_MAX || !(first.sse >= 0)) {
        return RIGCAL_ERR_RANGE;
    }
    if (second.n == 0) {
        return RIGCAL_OK;
    }
    if (second.camera != first.camera || second.placement != first.placement ||
        !(second.sse >= 0)) {
        return RIGCAL_ERR_RANGE;
    }
    status = rc_check_transform(&second.cam_from_target);
    if (status == RIGCAL_OK) {
        status = rc_check_numbers(second.information, 21, RC_MAX);
    }
    return (status == RIGCAL_OK && !rc_sym6_factor_of(&L, second.information, 0))
               ? RIGCAL_ERR_DEGENERATE
               : status;
}

/* The number at that place of x, in the order of size; those below 0 do not count. */
static rigcal_real ordered(const rigcal_real x[], size_t n, size_t place)
{
    rigcal_real low = 0, high = 0;
    for (size_t i = 0; i < n; i++) {
        high = rc_max(high, x[i]);
    }
    for (int k = 0; k < HALVINGS; k++) {
        const rigcal_real middle = low + (high - low) / 2;
        size_t within = 0;
        for (size_t i = 0; i < n; i++) {
            within += (x[i] >= 0 && x[i] <= middle);
        }
        if (within > place) {
            high = middle;
        } else {
            low = middle;
        }
    }
    return high;
}

/* sigma^2, stated or the median of the views' own; 0: it cannot be known. */
static rigcal_real variance_of(const rigcal_choose_solver *s, const grow_parts *p)
{
    const rigcal_rig *const rig = s->check.rig;
    size_t n = 0;
    if (rig->sigma_px > 0) {
        return rig->sigma_px * rig->sigma_px;
    }
    for (size_t v = 0; v < rig->n_views; v++) {
        n += (p->told[v] >= 0);
    }
    if (n == 0) {
        return 0;
    }
    const rigcal_real middle = (ordered(p->told, rig->n_views, (n - 1) / 2) +
                                ordered(p->told, rig->n_views, n / 2)) /
                               2;
    return rc_max(middle, NOISE_LEAST * NOISE_LEAST);
}

static void begin_weighing(rigcal_choose_solver *s, const grow_parts *p)
{
    const rigcal_rig *const rig = s->check.rig;
    const rigcal_real variance = variance_of(s, p);
    if (!(variance > 0)) {
        fail(s, RIGCAL_ERR_TOO_FEW);
        return;
    }
    s->choice->sigma_px = RC_SQRT(variance);
    s->limit = RC_CHOOSE_LIMIT * variance;
    size_t first = 0;
    for (size_t f = 0; f < rig->n_placements; f++) {
        p->first[f] = (rigcal_real)first;
        first += (size_t)p->count[f];
    }
    rc_clear(p->placed, 2 * rig->n_placements);
    rc_clear(p->links, RIGCAL_LINKS(rig->n_cameras));
    rc_clear(p->state, rig->n_cameras);
    s->view = s->placement = 0;
    s->phase = WEIGHING;
}

static void checking_step(rigcal_choose_solver *s, const grow_parts *p)
{
    const size_t view = s->check.view;
    rigcal_status status = rc_views_step(&s->check);
    if (status >= 0) {
        const rigcal_status both = check_both(s, p, view);
        status = (both == RIGCAL_OK) ? status : both;
    }
    if (status == RIGCAL_OK) {
        begin_weighing(s, p);
    } else if (status != RIGCAL_RUNNING) {
        s->check.at_fault = (view < s->check.rig->n_views) ? (int32_t)view : -1;
        fail(s, status);
    }
}

static rigcal_real *link_of(const grow_parts *p, size_t a, size_t b)
{
    return &p->links[(a < b) ? RIGCAL_LINK(a, b) : RIGCAL_LINK(b, a)];
}

static void begin_pairing(rigcal_choose_solver *s, const grow_parts *p);

/* What a view tells, and what its camera has in common with those before. */
static rigcal_status weighing_step(rigcal_choose_solver *s, const grow_parts *p)
{
    rigcal_view_pose pose;
    const size_t view = s->view;
    const rigcal_status status = candidate_at(&pose, s, view, 0);
    if (status != RIGCAL_OK) {
        return status;
    }
    p->told[view] = rc_view_information(&pose);
    for (size_t v = (size_t)p->first[pose.placement]; v < view; v++) {
        *link_of(p, (size_t)p->camera[v], (size_t)p->camera[view]) +=
            rc_information_of_both(p->told[v], p->told[view]);
    }
    if (++s->view == s->check.rig->n_views) {
        begin_pairing(s, p);
    }
    return RIGCAL_OK;
}

/* ---- which pairs are scored ---------------------------------------------- */

/* The tree of most information, by Prim: p->number gets the camera that each hangs on, or
 * its own. */
static void grow_tree(const grow_parts *p, size_t n_cameras)
{
    for (size_t c = 0; c < n_cameras; c++) {
        p->number[c] = (rigcal_real)c;
        p->score[c] = 0; /* its link to the tree; below 0: it is in it */
    }
    for (size_t k = 0; k < n_cameras; k++) {
        size_t next = n_cameras;
        for (size_t c = 0; c < n_cameras; c++) {
            if (p->score[c] >= 0 && (next == n_cameras || p->score[c] > p->score[next])) {
                next = c;
            }
        }
        p->score[next] = -1;
        for (size_t c = 0; c < n_cameras; c++) {
            if (p->score[c] >= 0 && *link_of(p, c, next) > p->score[c]) {
                p->score[c] = *link_of(p, c, next);
                p->number[c] = (rigcal_real)next;
            }
        }
    }
}

/* How many links of camera a tell more than that to b. */
static size_t rank_of(const grow_parts *p, size_t n_cameras, size_t a, size_t b)
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

static int is_scored(const rigcal_choose_solver *s, const grow_parts *p, size_t a, size_t b)
{
    const size_t C = s->check.rig->n_cameras;
    if (!(*link_of(p, a, b) > 0) || p->state[a] > 0 || p->state[b] > 0) {
        return 0;
    }
    return (size_t)p->number[a] == b || (size_t)p->number[b] == a ||
           rank_of(p, C, a, b) < PAIRS_MORE || rank_of(p, C, b, a) < PAIRS_MORE;
}

static void begin_pairing(rigcal_choose_solver *s, const grow_parts *p)
{
    grow_tree(p, s->check.rig->n_cameras);
    for (int k = 0; k < RIGCAL_CHOOSE_RUNGS; k++) {
        s->seed[k] = (rigcal_seed){0, -1, -1, 0};
    }
    s->a = s->b = 0;
    s->phase = PAIRING;
}

/* ---- one pair ------------------------------------------------------------ */

/* The view of a camera in a placement, or n_views. */
static size_t view_of(const rigcal_choose_solver *s, const grow_parts *p, size_t camera,
                      size_t placement)
{
    const size_t first = (size_t)p->first[placement];
    for (size_t v = first; v < first + (size_t)p->count[placement]; v++) {
        if ((size_t)p->camera[v] == camera) {
            return v;
        }
    }
    return s->check.rig->n_views;
}

/* What a placement tells of camera b from a, or from the rig; 0: nothing. */
static rigcal_real told_by(const rigcal_choose_solver *s, const grow_parts *p,
                           size_t placement)
{
    const size_t none = s->check.rig->n_views,
                 view = view_of(s, p, (size_t)s->b, placement);
    const int least = s->is_relaxed ? DOUBTFUL : KNOWN;
    size_t other = none;
    if (s->a >= 0) {
        other = view_of(s, p, (size_t)s->a, placement);
    } else if (p->strength[placement] >= (rigcal_real)least) {
        other = (size_t)p->placed[placement] / 2;
    }
    return (view == none || other == none)
               ? 0
               : rc_information_of_both(p->told[view], p->told[other]);
}

/* The placements that tell most of b from a, most first. */
static void listing_step(rigcal_choose_solver *s, const grow_parts *p)
{
    rigcal_real *const told = p->scores;
    s->n = 0;
    for (size_t f = 0; f < s->check.rig->n_placements; f++) {
        const rigcal_real more = told_by(s, p, f);
        size_t at = s->n;
        if (!(more > 0) || (at == PLACEMENTS && !(more > told[at - 1]))) {
            continue;
        }
        s->n += (at < PLACEMENTS);
        at -= (at == PLACEMENTS);
        for (; at > 0 && more > told[at - 1]; at--) {
            told[at] = told[at - 1];
            p->list[at] = p->list[at - 1];
        }
        told[at] = more;
        p->list[at] = (rigcal_real)f;
    }
    rc_clear(p->scores, RIGCAL_CHOOSE_RUNGS * HYPOTHESES);
    s->row = s->column = 0;
    s->phase = (s->n > 0) ? SCORING : RESECTING;
}

/* Where b is from a by each two of their poses in a placement, or from the rig. */
static rigcal_status hypotheses(rc_claim out[4], const rigcal_choose_solver *s,
                                const grow_parts *p, size_t placement)
{
    rc_claim of_a[2], of_b[2];
    const size_t view = view_of(s, p, (size_t)s->b, placement);
    const size_t placing = (size_t)p->placed[placement];
    const size_t other = (s->a >= 0) ? view_of(s, p, (size_t)s->a, placement) : placing / 2;
    rigcal_status status = claims_of(of_b, s, view);
    if (status == RIGCAL_OK) {
        status = claims_of(of_a, s, other);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    if (s->a < 0) {
        rc_claim_place(&of_a[1 - placing % 2], &of_a[placing % 2],
                       &p->cams[(size_t)p->camera[other]], 0);
        of_a[0] = of_a[1 - placing % 2];
        of_a[0].extra = 0;
        of_a[1].view = -1;
    }
    for (int k = 0; k < 4; k++) {
        out[k].view = -1;
        if (of_a[k / 2].view >= 0 && of_b[k % 2].view >= 0) {
            rc_claim_between(&out[k], &of_b[k % 2], &of_a[k / 2]);
        }
    }
    return RIGCAL_OK;
}

/* What a placement costs a hypothesis, at each rung: the score of it is how many agree, less
 * a part below 1 that grows with the cost. */
static void add_cost(const rigcal_choose_solver *s, rigcal_real *scores, rigcal_real cost)
{
    for (int k = 0; k < RIGCAL_CHOOSE_RUNGS; k++) {
        const rigcal_real part = cost / (s->limit * LADDER[k]);
        scores[k] += ((part < 1) ? 1 : 0) - rc_min(part, 1) / (PLACEMENTS + 1);
    }
}

static int32_t agree_of(rigcal_real score)
{
    return (int32_t)(score + 1 - RC(0.5) / (PLACEMENTS + 1));
}

/* The hypotheses of placement s->row of the list against those of s->column. */
static void compare(rigcal_choose_solver *s, const grow_parts *p)
{
    const rc_claim *const rows = p->rows, *const columns = p->rows + 4;
    rigcal_real least[8];
    for (int k = 0; k < 8; k++) {
        least[k] = s->limit * LADDER[RIGCAL_CHOOSE_RUNGS - 1];
    }
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4 && rows[i].view >= 0; j++) {
            if (columns[j].view >= 0) {
                const rigcal_real apart = rc_claims_apart(&rows[i], &columns[j]);
                least[i] = rc_min(least[i], apart + columns[j].extra);
                least[4 + j] = rc_min(least[4 + j], apart + rows[i].extra);
            }
        }
    }
    for (size_t i = 0; i < 4; i++) {
        add_cost(s, &p->scores[RIGCAL_CHOOSE_RUNGS * (4 * s->row + i)], least[i]);
        add_cost(s, &p->scores[RIGCAL_CHOOSE_RUNGS * (4 * s->column + i)], least[4 + i]);
    }
}

/* A hypothesis costs its own placement what its poses fit worse than the first ones. */
static void compare_own(rigcal_choose_solver *s, const grow_parts *p)
{
    for (size_t i = 0; i < 4; i++) {
        rigcal_real *const scores = &p->scores[RIGCAL_CHOOSE_RUNGS * (4 * s->row + i)];
        if (p->rows[i].view >= 0) {
            add_cost(s, scores, p->rows[i].extra);
        } else { /* never the best */
            scores[0] = scores[1] = scores[2] = scores[3] = scores[4] = scores[5] =
                -2 * PLACEMENTS;
        }
    }
}

/* All are scored: the best of them, rung by rung. */
static void finish_pair(rigcal_choose_solver *s, const grow_parts *p)
{
    const size_t n = 4 * s->n;
    for (int k = 0; k < RIGCAL_CHOOSE_RUNGS; k++) {
        size_t best = 0;
        for (size_t h = 1; h < n; h++) {
            if (p->scores[RIGCAL_CHOOSE_RUNGS * h + (size_t)k] >
                p->scores[RIGCAL_CHOOSE_RUNGS * best + (size_t)k]) {
                best = h;
            }
        }
        const rigcal_real score = p->scores[RIGCAL_CHOOSE_RUNGS * best + (size_t)k];
        const int32_t number = 4 * (int32_t)p->list[best / 4] + (int32_t)(best % 4);
        if (s->a >= 0 && !s->is_again && s->n > 1) {
            s->counts[k] += (rigcal_real)(agree_of(score) - 1);
        }
        if (s->a >= 0 && (s->seed[k].b < 0 || score > s->seed[k].score)) {
            s->seed[k] = (rigcal_seed){score, s->a, s->b, number};
        } else if (s->a < 0 && k == s->rung) {
            p->score[s->b] = score;
            p->number[s->b] = (rigcal_real)number;
        }
    }
    if (s->a >= 0 && !s->is_again) {
        s->most += (rigcal_real)(int32_t)(s->n - 1);
    }
    s->phase = (s->a >= 0) ? PAIRING : RESECTING;
}

static rigcal_status scoring_step(rigcal_choose_solver *s, const grow_parts *p)
{
    rigcal_status status = RIGCAL_OK;
    if (s->column == 0) {
        status = hypotheses(p->rows, s, p, (size_t)p->list[s->row]);
    }
    if (status == RIGCAL_OK && s->column < s->row) {
        status = hypotheses(p->rows + 4, s, p, (size_t)p->list[s->column]);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    if (s->column < s->row) {
        compare(s, p);
        s->column++;
    } else {
        compare_own(s, p);
        s->column = 0;
        if (++s->row == s->n) {
            finish_pair(s, p);
        }
    }
    return RIGCAL_OK;
}

/* ---- growing ------------------------------------------------------------- */

/* A camera joins: what it sees is placed again, where few have seen it yet, and cameras that
 * wait are compared again with what has changed. */
static void join(rigcal_choose_solver *s, const grow_parts *p, size_t camera)
{
    p->state[camera] = JOINED;
    for (size_t f = 0; f < s->check.rig->n_placements; f++) {
        const size_t first = (size_t)p->first[f], end = first + (size_t)p->count[f];
        size_t n = 0;
        if (view_of(s, p, camera, f) == s->check.rig->n_views) {
            continue;
        }
        for (size_t v = first; v < end; v++) {
            n += (p->state[(size_t)p->camera[v]] == JOINED);
        }
        for (size_t v = first; v < end && n <= VIEWS_MOST; v++) {
            rigcal_real *const state = &p->state[(size_t)p->camera[v]];
            *state = (*state == JOINED) ? JOINED : CHANGED;
            p->strength[f] = STALE;
        }
    }
    s->placement = s->view = s->n = 0;
    s->phase = CLAIMING;
}

/* All cameras that wait are compared (again). */
static int compare_all(const rigcal_choose_solver *s, const grow_parts *p)
{
    int n = 0;
    for (size_t c = 0; c < s->check.rig->n_cameras; c++) {
        if (p->state[c] != JOINED) {
            p->state[c] = CHANGED;
            n++;
        }
    }
    return n;
}

/* Camera s->b joins by a hypothesis. */
static rigcal_status join_by(rigcal_choose_solver *s, const grow_parts *p, size_t number)
{
    const rigcal_status status = hypotheses(p->rows, s, p, number / 4);
    if (status == RIGCAL_OK) {
        p->cams[s->b] = p->rows[number % 4];
        join(s, p, (size_t)s->b);
    }
    return status;
}

/* The first camera of a frame. */
static void join_first(rigcal_choose_solver *s, const grow_parts *p, size_t camera)
{
    rc_claim *const it = &p->cams[camera];
    rc_transform_identity(&it->b_from_a);
    rc_clear(it->Sigma, 21);
    rc_clear(it->pivot, 3);
    join(s, p, camera);
}

/* tau^2: the first rung to which the next adds little. */
static int choose_rung(rigcal_choose_solver *s)
{
    rigcal_choice *const choice = s->choice;
    int k = 0;
    while (k < RIGCAL_CHOOSE_RUNGS - 2 &&
           !(s->counts[k] > 0 && s->counts[k] >= RUNG_ENOUGH * s->counts[k + 1])) {
        k++;
    }
    s->rung = k;
    choice->tau2 = LADDER[k];
    choice->share = (s->most > 0) ? s->counts[k] / s->most : 0;
    return !(s->most > 0) || choice->share >= SHARE_LEAST;
}

/* The best pair is the seed; without one a camera by itself. */
static rigcal_status seed(rigcal_choose_solver *s, const grow_parts *p)
{
    if (!s->is_again && !choose_rung(s)) {
        return RIGCAL_ERR_CONTRADICTION;
    }
    const rigcal_seed *const best = &s->seed[s->rung];
    size_t alone = 0;
    while (p->state[alone] == JOINED) {
        alone++;
    }
    for (size_t c = 0; c < s->check.rig->n_cameras; c++) {
        p->score[c] = -2 * PLACEMENTS;
    }
    s->is_again = 1;
    join_first(s, p, (best->b < 0) ? alone : (size_t)best->a);
    if (best->b < 0) {
        return RIGCAL_OK;
    }
    s->a = best->a;
    s->b = best->b;
    return join_by(s, p, (size_t)best->number);
}

static rigcal_status pairing_step(rigcal_choose_solver *s, const grow_parts *p)
{
    if (++s->a >= s->b) {
        s->a = 0;
        s->b++;
    }
    if ((size_t)s->b >= s->check.rig->n_cameras) {
        return seed(s, p);
    }
    if (is_scored(s, p, (size_t)s->a, (size_t)s->b)) {
        s->phase = LISTING;
    }
    return RIGCAL_OK;
}

/* No camera is left to compare: the best joins. */
static rigcal_status next_camera(rigcal_choose_solver *s, const grow_parts *p)
{
    const size_t C = s->check.rig->n_cameras;
    size_t best = C, left = 0;
    for (size_t c = 0; c < C; c++) {
        left += (p->state[c] != JOINED);
        if (p->state[c] != JOINED && p->score[c] > -PLACEMENTS &&
            (best == C || p->score[c] > p->score[best])) {
            best = c;
        }
    }
    if (best < C) {
        const size_t number = (size_t)p->number[best];
        s->b = (int32_t)best;
        const rigcal_status status = join_by(s, p, number);
        if (s->is_relaxed) {
            s->is_relaxed = 0;
            (void)compare_all(s, p);
        }
        return status;
    }
    if (left > 0 && !s->is_relaxed) { /* placements of which views disagree will do */
        s->is_relaxed = 1;
        (void)compare_all(s, p);
    } else if (left > 0) { /* another group */
        s->is_relaxed = 0;
        begin_pairing(s, p);
    } else {
        s->is_final = 1;
        for (size_t f = 0; f < s->check.rig->n_placements; f++) {
            p->strength[f] = (p->count[f] > 0) ? STALE : UNSEEN;
        }
        s->placement = s->view = s->n = 0;
        s->phase = CLAIMING;
    }
    return RIGCAL_OK;
}

static rigcal_status resecting_step(rigcal_choose_solver *s, const grow_parts *p)
{
    s->a = -1;
    for (size_t c = 0; c < s->check.rig->n_cameras; c++) {
        if (p->state[c] == CHANGED) {
            p->state[c] = WAITS;
            p->score[c] = -2 * PLACEMENTS;
            s->b = (int32_t)c;
            s->phase = LISTING;
            return RIGCAL_OK;
        }
    }
    return next_camera(s, p);
}

/* The claims of a view about its placement. */
static rigcal_status claiming_step(rigcal_choose_solver *s, const grow_parts *p)
{
    const size_t F = s->check.rig->n_placements;
    while (s->placement < F && p->strength[s->placement] != STALE) {
        s->placement++;
    }
    if (s->placement == F) {
        s->phase = s->is_final ? FRAMING : RESECTING;
        return RIGCAL_OK;
    }
    const size_t view = (size_t)p->first[s->placement] + s->view;
    const size_t camera = (size_t)p->camera[view];
    if (p->state[camera] == JOINED) {
        rc_claim own[2];
        const rigcal_status status = claims_of(own, s, view);
        if (status != RIGCAL_OK) {
            return status;
        }
        for (int i = 0; i < 2; i++) {
            if (own[i].view >= 0) {
                rc_claim_place(&p->claims[s->n++], &own[i], &p->cams[camera], 1);
            }
        }
    }
    if (++s->view == (size_t)p->count[s->placement]) {
        s->phase = SUPPORTING;
        s->which = 0;
        s->best = -1;
    }
    return RIGCAL_OK;
}

/* Whether a claim is of one of the views that tell most. */
static int may_place(const rigcal_choose_solver *s, const grow_parts *p, size_t which)
{
    const rc_claim *const claims = p->claims;
    const int32_t view = claims[which].view;
    int more = 0;
    for (size_t i = 0; i < s->n; i++) {
        more += (claims[i].candidate == 0 && p->told[claims[i].view] > p->told[view]);
    }
    return more < VIEWS_MOST;
}

static void place(rigcal_choose_solver *s, const grow_parts *p)
{
    const rc_claim *const best = &p->claims[s->best];
    rc_support support;
    rc_choose_support(&support, s->choice->takes, p->claims, s->n, (size_t)s->best,
                      s->limit * LADDER[s->rung]);
    s->check.rig->rig_from_placements[s->placement] = best->b_from_a;
    p->placed[s->placement] = (rigcal_real)(2 * best->view + best->candidate);
    p->strength[s->placement] = (support.agree > 1 || support.n == 1) ? KNOWN : DOUBTFUL;
    s->view = s->n = 0;
    s->phase = CLAIMING;
}

/* One claim against all others of the placement. */
static void supporting_step(rigcal_choose_solver *s, const grow_parts *p)
{
    while (s->which < s->n && !may_place(s, p, s->which)) {
        s->which++;
    }
    if (s->which == s->n) {
        place(s, p);
        return;
    }
    rc_support support;
    const rc_support before = {s->cost, s->spread, s->agree, 0};
    rc_choose_support(&support, NULL, p->claims, s->n, s->which,
                      s->limit * LADDER[s->rung]);
    if (s->best < 0 || rc_choose_is_better(&support, &before)) {
        s->best = (int32_t)s->which;
        s->cost = support.cost;
        s->spread = support.spread;
        s->agree = support.agree;
    }
    s->which++;
}

/* ---- the frame ----------------------------------------------------------- */

/* 1: where the camera is, is given. */
static int is_given(rigcal_transform *cam_from_rig, const rigcal_rig *rig, size_t camera)
{
    if (rc_rig_has_prior(rig, camera)) {
        *cam_from_rig = rig->priors[camera].cam_from_rig;
        return 1;
    }
    *cam_from_rig = rig->cams_from_rig[camera];
    return rc_rig_is_held(rig, camera);
}

/* A group from the frame in which it grew: that of `camera`, as it is to be. */
static void set_frame(const rigcal_choose_solver *s, const grow_parts *p, size_t camera)
{
    rigcal_rig *const rig = s->check.rig;
    const int32_t group = rig->group[camera];
    rigcal_transform given, back, grown_from_rig, rig_from_grown, old;
    if (!is_given(&given, rig, camera)) {
        rc_transform_identity(&given);
    }
    rc_transform_invert(&back, &p->cams[camera].b_from_a);
    rc_transform_compose(&grown_from_rig, &back, &given);
    rc_transform_invert(&rig_from_grown, &grown_from_rig);
    for (size_t c = 0; c < rig->n_cameras; c++) {
        if (rig->group[c] == group && !is_given(&rig->cams_from_rig[c], rig, c)) {
            rc_transform_compose(&rig->cams_from_rig[c], &p->cams[c].b_from_a,
                                 &grown_from_rig);
        }
    }
    for (size_t f = 0; f < rig->n_placements; f++) {
        const size_t first = (size_t)p->first[f];
        if (p->count[f] > 0 && rig->group[(size_t)p->camera[first]] == group) {
            old = rig->rig_from_placements[f];
            rc_transform_compose(&rig->rig_from_placements[f], &rig_from_grown, &old);
        }
    }
}

static void framing_step(rigcal_choose_solver *s, const grow_parts *p)
{
    const rigcal_rig *const rig = s->check.rig;
    rigcal_transform ignored;
    size_t first = 0;
    for (int32_t group = 0; first < rig->n_cameras; group++) {
        size_t frame = rig->n_cameras;
        first = rig->n_cameras;
        for (size_t c = rig->n_cameras; c-- > 0;) {
            if (rig->group[c] == group) {
                first = c;
                frame = is_given(&ignored, rig, c) ? c : frame;
            }
        }
        if (first < rig->n_cameras) {
            set_frame(s, p, (frame < rig->n_cameras) ? frame : first);
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
    solver->check.at_fault = -1;
    solver->phase = CHECKING;
    return rc_views_begin(&solver->check);
}

static rigcal_status one_step(rigcal_choose_solver *s, const grow_parts *p)
{
    switch (s->phase) {
    case CHECKING:
        checking_step(s, p);
        return RIGCAL_OK;
    case WEIGHING:
        return weighing_step(s, p);
    case PAIRING:
        return pairing_step(s, p);
    case LISTING:
        listing_step(s, p);
        return RIGCAL_OK;
    case SCORING:
        return scoring_step(s, p);
    case CLAIMING:
        return claiming_step(s, p);
    case SUPPORTING:
        supporting_step(s, p);
        return RIGCAL_OK;
    case RESECTING:
        return resecting_step(s, p);
    default:
        framing_step(s, p);
        return RIGCAL_OK;
    }
}

rigcal_status rigcal_choose_step(rigcal_choose_solver *solver, int32_t budget)
{
    grow_parts p;
    if (solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (solver->phase == 0) {
        return RIGCAL_ERR_STATE;
    }
    if (budget < 1) {
        return RIGCAL_ERR_RANGE;
    }
    parts_of(&p, solver);
    for (; budget > 0 && solver->phase != DONE; budget--) {
        const rigcal_status status = one_step(solver, &p);
        if (status != RIGCAL_OK) {
            fail(solver, status);
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
    while (rigcal_choose_step(&solver, 1000) == RIGCAL_RUNNING) {
    }
    return rigcal_choose_result(at_fault, &solver);
}
