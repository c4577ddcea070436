#include "rc_score.h"

#include "rc_graph.h"

/* ---- constants ----------------------------------------------------------- */

/* times: tau^2 grows by this from each rung to the next. At rung 0 it is 1: noise alone. */
#define LADDER_STEP RC(4)

/* px: the least noise where none is stated. No camera's pixels are better. */
#define NOISE_LEAST RC(0.01)

enum { RUNGS = RIGCAL_CHOOSE_RUNGS, HYPOTHESES = 4 * RC_SCORE_PLACEMENTS };

rigcal_real rc_score_tau2(int rung)
{
    rigcal_real tau2 = 1;
    for (int k = 0; k < rung; k++) {
        tau2 *= LADDER_STEP;
    }
    return tau2;
}

/* ---- memory -------------------------------------------------------------- */

void rc_score_parts_of(rc_score_parts *parts, const rigcal_rig *rig)
{
    const size_t C = rig->n_cameras, F = rig->n_placements;
    rc_rig_parts own;
    rc_rig_parts_of(&own, rig, 0);
    parts->first = own.W;
    parts->placed = parts->first + F + 1;
    parts->strength = parts->placed + F;
    parts->camera = parts->strength + F;
    parts->told = parts->camera + rig->n_views;
    parts->links = parts->told + rig->n_views;
    parts->score = parts->links + RIGCAL_LINKS(C);
    parts->number = parts->score + C;
    parts->state = parts->number + C;
    parts->cams = (rc_claim *)(void *)(parts->state + C);
    parts->list = (rigcal_real *)(parts->cams + C);
    parts->scores = parts->list + RC_SCORE_PLACEMENTS;
    parts->rows = (rc_claim *)(void *)(parts->scores + RUNGS * HYPOTHESES);
    parts->claims = (rc_claim *)(void *)parts->list;
}

/* ---- poses of a view ----------------------------------------------------- */

rigcal_status rc_candidate_at(rigcal_view_pose *pose, const rigcal_choice *choice,
                              const rigcal_rig *rig, size_t view, int candidate)
{
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

rigcal_status rc_candidates(rc_claim claims[2], const rigcal_choose_solver *s, size_t view)
{
    rigcal_real first_sse = 0;
    for (int i = 0; i < 2; i++) {
        rigcal_view_pose pose;
        const rigcal_status status =
            rc_candidate_at(&pose, s->choice, s->check.rig, view, i);
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

size_t rc_score_view_of(const rigcal_rig *rig, const rc_score_parts *parts, size_t camera,
                        size_t placement)
{
    const size_t end = (size_t)parts->first[placement + 1];
    for (size_t v = (size_t)parts->first[placement]; v < end; v++) {
        if (parts->camera[v] >= 0 && (size_t)parts->camera[v] == camera) {
            return v;
        }
    }
    return rig->n_views;
}

/* ---- the noise ----------------------------------------------------------- */

/* The number at this place when x is sorted. Numbers below 0 do not count. */
static rigcal_real ordered(const rigcal_real x[], size_t n, size_t place)
{
    rigcal_real low = 0, high = 0;
    for (size_t i = 0; i < n; i++) {
        high = rc_max(high, x[i]);
    }
    for (int k = 0; k < RC_HALVINGS; k++) {
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

rigcal_real rc_score_variance(const rigcal_rig *rig, const rc_score_parts *parts)
{
    size_t n = 0;
    if (rig->sigma_px > 0) {
        return rig->sigma_px * rig->sigma_px;
    }
    for (size_t v = 0; v < rig->n_views; v++) {
        n += (parts->told[v] >= 0);
    }
    if (n == 0) {
        return 0;
    }
    const rigcal_real low = ordered(parts->told, rig->n_views, (n - 1) / 2);
    const rigcal_real high = ordered(parts->told, rig->n_views, n / 2);
    return rc_max(low + (high - low) / 2, NOISE_LEAST * NOISE_LEAST);
}

/* ---- the list ------------------------------------------------------------ */

/* The view that camera s->a has of a placement or, if s->a is -1, the view that placed it.
 * Returns n_views if there is none. */
static size_t other_view(const rigcal_choose_solver *s, const rc_score_parts *parts,
                         size_t placement)
{
    const rigcal_rig *const rig = s->check.rig;
    if (s->a >= 0) {
        return rc_score_view_of(rig, parts, (size_t)s->a, placement);
    }
    const int least = s->is_relaxed ? RC_DOUBTFUL : RC_KNOWN;
    return (parts->strength[placement] >= (rigcal_real)least)
               ? (size_t)parts->placed[placement] / 2
               : rig->n_views;
}

int rc_score_begin(rigcal_choose_solver *s, const rc_score_parts *parts)
{
    const rigcal_rig *const rig = s->check.rig;
    rigcal_real *const told = parts->scores; /* information of the placements in the list */
    size_t n = 0;
    for (size_t f = 0; f < rig->n_placements; f++) {
        const size_t view = rc_score_view_of(rig, parts, (size_t)s->b, f);
        const size_t other = other_view(s, parts, f);
        if (view == rig->n_views || other == rig->n_views) {
            continue;
        }
        const rigcal_real more =
            rc_information_of_both(parts->told[view], parts->told[other]);
        size_t at = n;
        n += (n < RC_SCORE_PLACEMENTS);
        for (; at > 0 && more > told[at - 1]; at--) {
            if (at < RC_SCORE_PLACEMENTS) {
                told[at] = told[at - 1];
                parts->list[at] = parts->list[at - 1];
            }
        }
        if (at < RC_SCORE_PLACEMENTS) {
            told[at] = more;
            parts->list[at] = (rigcal_real)f;
        }
    }
    rc_clear(parts->scores, RUNGS * HYPOTHESES);
    s->n = n;
    s->row = s->column = 0;
    return n > 0;
}

/* ---- hypotheses ---------------------------------------------------------- */

/* Claims of where camera b is from a: from each pair of their poses in this placement. If
 * s->a is -1, the placement's pose in the rig stands for the poses of a. */
static rigcal_status hypotheses(rc_claim out[4], const rigcal_choose_solver *s,
                                const rc_score_parts *parts, size_t placement)
{
    rc_claim of_a[2], of_b[2];
    const size_t placing = (size_t)parts->placed[placement];
    const size_t view = rc_score_view_of(s->check.rig, parts, (size_t)s->b, placement);
    const size_t other = other_view(s, parts, placement);
    rigcal_status status = rc_candidates(of_b, s, view);
    if (status == RIGCAL_OK) {
        status = rc_candidates(of_a, s, other);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    if (s->a < 0) {
        rc_claim *const placed = &out[0]; /* scratch, overwritten below */
        rc_claim_place(placed, &of_a[placing % 2],
                       &parts->cams[(size_t)parts->camera[other]], 0);
        placed->extra = 0;
        of_a[0] = *placed;
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

rigcal_status rc_score_claim(rc_claim *b_from_a, const rigcal_choose_solver *s,
                             const rc_score_parts *parts, size_t number)
{
    const rigcal_status status = hypotheses(parts->rows, s, parts, number / 4);
    *b_from_a = parts->rows[number % 4];
    return status;
}

/* ---- scores -------------------------------------------------------------- */

/* Adds the cost of one more placement to hypothesis k of placement `row` of the list. The
 * score is the number of placements that agree. A part below 1, which grows with the cost,
 * is subtracted. */
static void add_cost(const rigcal_choose_solver *s, const rc_score_parts *parts, size_t row,
                     size_t k, rigcal_real cost)
{
    rigcal_real *const scores = &parts->scores[RUNGS * (4 * row + k)];
    rigcal_real part = cost / s->limit;
    for (int rung = 0; rung < RUNGS; rung++) {
        const rigcal_real agrees = (part < 1) ? 1 : 0;
        scores[rung] += agrees - rc_min(part, 1) / (RC_SCORE_PLACEMENTS + 1);
        part /= LADDER_STEP;
    }
}

int32_t rc_score_agree(rigcal_real score)
{
    return (int32_t)(score + 1 - RC(0.5) / (RC_SCORE_PLACEMENTS + 1));
}

/* Scores the hypotheses of placement s->row of the list against those of s->column. Each
 * costs the other placement what its nearest hypothesis there costs. */
static void compare(const rigcal_choose_solver *s, const rc_score_parts *parts)
{
    const rc_claim *const rows = parts->rows, *const columns = parts->rows + 4;
    const rigcal_real most = s->limit * rc_score_tau2(RUNGS - 1);
    rigcal_real of_column[4] = {most, most, most, most};
    for (size_t i = 0; i < 4; i++) {
        rigcal_real of_row = most;
        for (size_t j = 0; j < 4; j++) {
            if (rows[i].view >= 0 && columns[j].view >= 0) {
                const rigcal_real apart = rc_claims_apart(&rows[i], &columns[j]);
                of_row = rc_min(of_row, apart + columns[j].extra);
                of_column[j] = rc_min(of_column[j], apart + rows[i].extra);
            }
        }
        add_cost(s, parts, s->row, i, of_row);
    }
    for (size_t j = 0; j < 4; j++) {
        add_cost(s, parts, s->column, j, of_column[j]);
    }
}

/* A hypothesis costs its own placement what its poses fit worse than the first poses. Where
 * there is no hypothesis the score is below all others, whatever is added to it. */
static void compare_own(const rigcal_choose_solver *s, const rc_score_parts *parts)
{
    for (size_t i = 0; i < 4; i++) {
        rigcal_real *const scores = &parts->scores[RUNGS * (4 * s->row + i)];
        if (parts->rows[i].view >= 0) {
            add_cost(s, parts, s->row, i, parts->rows[i].extra);
        } else {
            for (int rung = 0; rung < RUNGS; rung++) {
                scores[rung] = RC_SCORE_NONE;
            }
        }
    }
}

rigcal_status rc_score_step(rigcal_choose_solver *s, const rc_score_parts *parts)
{
    const int is_own = s->column == s->row;
    rigcal_status status = RIGCAL_OK;
    if (s->column == 0) { /* a new row begins */
        status = hypotheses(parts->rows, s, parts, (size_t)parts->list[s->row]);
    }
    if (status == RIGCAL_OK && !is_own) {
        status = hypotheses(parts->rows + 4, s, parts, (size_t)parts->list[s->column]);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!is_own) {
        compare(s, parts);
        s->column++;
        return RIGCAL_RUNNING;
    }
    compare_own(s, parts);
    s->column = 0;
    s->row++;
    return (s->row == s->n) ? RIGCAL_OK : RIGCAL_RUNNING;
}

rigcal_real rc_score_best(int32_t *number, const rigcal_choose_solver *s,
                          const rc_score_parts *parts, int rung)
{
    const rigcal_real *const scores = &parts->scores[rung];
    size_t best = 0;
    for (size_t h = 1; h < 4 * s->n; h++) {
        if (scores[RUNGS * h] > scores[RUNGS * best]) {
            best = h;
        }
    }
    *number = 4 * (int32_t)parts->list[best / 4] + (int32_t)(best % 4);
    return scores[RUNGS * best];
}
