#include "rc_border.h"
#include "rc_evidence.h"
#include "rc_finding.h"
#include "rc_moved.h"
#include "rc_views.h"

/* ---- constants ----------------------------------------------------------- */

/* part of Q: with less of it left when all else is free, a parameter cannot be seen. */
#define RANK_TOL RC_TOL(1e-10, 1e-5)

/* sigma: a point beyond it was left out by the truncated loss. */
#define TRUNCATED_FROM RC(4)

/* 1: of the board's half extent. A board of one line has no shape across it. */
#define EXTENT_LEAST RC(1e-12)

/* part of the disagreement: along the motion as much means single stamps that are wrong. */
#define ALONG_MOST RC(0.3)

/* 1: a pattern of neighbouring residuals is one above this, */
#define PATTERN_LEAST RC(0.1)

/* standard deviations: and above so many. */
#define PATTERN_DEVIATIONS RC(4)

enum {
    DONE = 1,
    COUNTING,    /* where the points are, and how many views a camera has */
    SUMMING,     /* a view's sums */
    ELIMINATING, /* its placement */
    MOVING,      /* whether the camera of one of its views moved there */
    TESTING      /* a fault, once all views have been summed up */
};

/* ---- what belongs to a kind ------------------------------------------------- */

static const uint8_t KIND_OF[RC_COLUMNS] = {
    RIGCAL_FAULT_CLOCK,  RIGCAL_FAULT_DRIFT,      RIGCAL_FAULT_SHUTTER,
    RIGCAL_FAULT_FOCAL,  RIGCAL_FAULT_ASPECT,     RIGCAL_FAULT_CENTRE,
    RIGCAL_FAULT_CENTRE, RIGCAL_FAULT_DISTORTION, RIGCAL_FAULT_DISTORTION,
    RIGCAL_FAULT_BENT,   RIGCAL_FAULT_BENT,       RIGCAL_FAULT_STRETCHED};

/* The first parameter of a view that belongs to a kind; CLOCKS has that of CLOCK. */
static size_t parameter_of(int32_t kind)
{
    size_t p = 0;
    while (KIND_OF[p] != ((kind == RIGCAL_FAULT_CLOCKS) ? RIGCAL_FAULT_CLOCK : kind)) {
        p++;
    }
    return p;
}

static int is_of_camera(int32_t kind)
{
    return kind != RIGCAL_FAULT_CLOCKS && kind < RIGCAL_FAULT_BENT;
}

static int has_kind(const rigcal_faults_solver *s, int32_t kind)
{
    return (s->kinds & RIGCAL_FAULTS_OF(kind)) != 0;
}

static int has_clocks(const rigcal_faults_solver *s)
{
    return has_kind(s, RIGCAL_FAULT_CLOCK) || has_kind(s, RIGCAL_FAULT_CLOCKS);
}

/* Columns: the clock of each camera, the others of each camera, those of the board. */
static size_t column_of(const rigcal_faults_solver *s, size_t camera, size_t parameter)
{
    const size_t clocks = has_clocks(s) ? s->rig->n_cameras : 0;
    if (parameter == RC_BY_CLOCK) {
        return camera;
    }
    return clocks + (size_t)s->columns.at[parameter] +
           s->columns.per_camera *
               ((parameter < RC_OF_CAMERA) ? camera : s->rig->n_cameras);
}

static void number_columns(rigcal_faults_solver *s)
{
    int32_t rank = 0;
    for (size_t p = RC_BY_CLOCK; p < RC_COLUMNS; p++) {
        if (p == RC_OF_CAMERA) {
            s->columns.per_camera = (size_t)rank;
            rank = 0;
        }
        s->columns.at[p] = -1;
        if (p == RC_BY_CLOCK) {
            s->columns.at[p] = has_clocks(s) ? 0 : -1;
        } else if (has_kind(s, KIND_OF[p])) {
            s->columns.at[p] = rank++;
        }
    }
    s->border.k = (has_clocks(s) ? s->rig->n_cameras : 0) +
                  s->columns.per_camera * s->rig->n_cameras + (size_t)rank;
}

/* ---- memory ----------------------------------------------------------------- */

size_t rigcal_faults_work(size_t n_free, size_t n_cameras)
{
    return RIGCAL_FAULTS_WORK(n_free, n_cameras);
}

size_t rigcal_faults_least(size_t n_free, size_t n_cameras)
{
    return RIGCAL_FAULTS_LEAST(n_free, n_cameras);
}

/* What is left of two pieces of memory: the rig's saved poses, and the caller's. */
typedef struct {
    rigcal_real *at[2];
    size_t left[2];
    int is_enough;
} pool;

static rigcal_real *take(pool *from, size_t n)
{
    const int which = (n <= from->left[0]) ? 0 : 1;
    rigcal_real *const at = from->at[which];
    if (n > from->left[which]) {
        from->is_enough = 0;
        return NULL;
    }
    from->left[which] -= n;
    from->at[which] += n;
    return at;
}

static size_t packed(size_t n)
{
    return n * (n + 1) / 2;
}

static size_t most(size_t a, size_t b)
{
    return (a > b) ? a : b;
}

static void take_columns(rigcal_faults_solver *s, pool *from)
{
    rigcal_columns *const c = &s->columns;
    const size_t k = s->border.k, n_cameras = s->rig->n_cameras;
    const size_t n_pairs = (RC_PAIRS - 1) * n_cameras + 1;
    s->border.T = take(from, k * s->n);
    c->Q = take(from, k);
    c->q = take(from, k);
    c->raw = take(from, k);
    c->own_Q = take(from, k);
    c->own_q = take(from, k);
    c->pairs = take(from, n_pairs);
    c->own_pairs = take(from, n_pairs);
    c->clocks = take(from, has_clocks(s) ? packed(n_cameras) : 0);
}

/* Memory for the kinds of s->kinds. 0: there is not enough. */
static int lay_out(rigcal_faults_solver *s)
{
    rc_rig_parts parts;
    const size_t n_cameras = s->rig->n_cameras;
    const int is_moved = has_kind(s, RIGCAL_FAULT_MOVED);
    rc_rig_parts_of(&parts, s->rig, 0);
    number_columns(s);
    pool from = {
        {(rigcal_real *)(void *)parts.saved, s->options->work},
        {(size_t)(parts.S - (rigcal_real *)(void *)parts.saved), s->options->work_capacity},
        1};
    const size_t test = s->n + packed(n_cameras) + 5 * n_cameras;
    s->moves.total = take(&from, n_cameras); /* where it was in the pass before */
    s->border.n = s->n;
    s->border.W = parts.W;
    s->border.slot = parts.slot;
    s->border.Z = take(&from, most(most(6 * s->border.k, test), is_moved ? 12 * s->n : 0));
    take_columns(s, &from);
    s->g = take(&from, s->n);
    s->moves.so_far = take(&from, n_cameras);
    s->moves.camera = take(&from, n_cameras);
    if (is_moved) {
        s->moves.S = take(&from, packed(6 * n_cameras));
        s->moves.g = take(&from, 6 * n_cameras);
        s->moves.best = take(&from, RC_MOVED_SIZE * n_cameras);
    }
    return from.is_enough;
}

/* The last of some kinds, MOVED before all others. */
static int32_t last_of(int32_t kinds)
{
    int32_t kind = RIGCAL_FAULT_KINDS - 1;
    if ((kinds & RIGCAL_FAULTS_OF(RIGCAL_FAULT_MOVED)) != 0) {
        return RIGCAL_FAULT_MOVED;
    }
    while ((kinds & RIGCAL_FAULTS_OF(kind)) == 0) {
        kind--;
    }
    return kind;
}

/* The kinds of the next pass: as many as there is memory for, the last ones later. */
static int choose_kinds(rigcal_faults_solver *s)
{
    s->kinds = s->left;
    while (!lay_out(s)) {
        s->kinds &= ~RIGCAL_FAULTS_OF(last_of(s->kinds));
        if (s->kinds == 0) {
            return 0;
        }
    }
    s->left &= ~s->kinds;
    return 1;
}

/* ---- a pass ------------------------------------------------------------------ */

static void end(rigcal_faults_solver *s, rigcal_status status, int32_t at_fault)
{
    s->status = status;
    s->at_fault = at_fault;
    s->phase = DONE;
}

/* A placement that was seen, from s->placement down. Views are looked at from the last
 * placement to the first, for cameras that moved. 0: there is none. */
static int begin_placement(rigcal_faults_solver *s)
{
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, s->rig, 0);
    while (s->placement > 0) {
        s->placement--;
        s->first -= rc_rig_views_of(&parts, s->placement);
        if (parts.count[s->placement] > 0) {
            rc_border_next(&s->border);
            s->view = s->first;
            s->phase = SUMMING;
            s->n_seen++;
            return 1;
        }
    }
    return 0;
}

static void begin_pass(rigcal_faults_solver *s)
{
    const rigcal_columns *const c = &s->columns;
    const size_t k = s->border.k, n_cameras = s->rig->n_cameras;
    const size_t n_pairs = (RC_PAIRS - 1) * n_cameras + 1;
    rc_border_begin(&s->border);
    rc_clear(c->Q, k);
    rc_clear(c->q, k);
    rc_clear(c->raw, k);
    rc_clear(c->own_Q, k);
    rc_clear(c->own_q, k);
    rc_clear(c->pairs, n_pairs);
    rc_clear(c->own_pairs, n_pairs);
    rc_clear(c->clocks, has_clocks(s) ? packed(n_cameras) : 0);
    rc_clear(s->g, s->n);
    if (has_kind(s, RIGCAL_FAULT_MOVED)) {
        rc_moved_begin(&s->moves, n_cameras);
    }
    s->n_points = s->n_used = s->n_seen = s->n_neighbours = 0;
    s->sum = s->own = s->product = s->expected = 0;
    s->along = s->disagreement = s->speed2 = 0;
    s->first = s->rig->n_views;
    s->placement = s->rig->n_placements;
    s->found.passes++;
    if (!begin_placement(s)) {
        end(s, RIGCAL_ERR_TOO_FEW, -1);
    }
}

/* ---- where the points are ----------------------------------------------------- */

/* View s->view: its camera has one more, and the board reaches over its points. */
static rigcal_status count_view(rigcal_faults_solver *s)
{
    rigcal_rig_view v;
    rigcal_points points;
    if (rc_rig_is_left_out(s->rig, s->view)) {
        return RIGCAL_OK;
    }
    rigcal_status status = rc_rig_view_at(&v, s->rig, s->view);
    if (status == RIGCAL_OK && (v.camera < 0 || (size_t)v.camera >= s->rig->n_cameras)) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK) {
        status = rc_rig_points(&points, &v);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    s->moves.total[v.camera] += 1;
    for (size_t i = 0; i < v.view.n; i++) {
        for (int k = 0; k < 2; k++) {
            const rigcal_real x = v.view.observations[i].X_w[k];
            s->low[k] = rc_min(s->low[k], x);
            s->high[k] = rc_max(s->high[k], x);
        }
    }
    return RIGCAL_OK;
}

static void counting_step(rigcal_faults_solver *s)
{
    const rigcal_status status = count_view(s);
    if (status != RIGCAL_OK) {
        end(s, status, (int32_t)s->view);
    } else if (++s->view == s->rig->n_views) {
        begin_pass(s);
    }
}

static void scan_of(rc_scan *scan, const rigcal_faults_solver *s)
{
    const rigcal_real limit = TRUNCATED_FROM * s->rig->sigma_px;
    for (int k = 0; k < 2; k++) {
        scan->middle[k] = s->low[k] + (s->high[k] - s->low[k]) / 2;
        scan->half[k] = rc_max((s->high[k] - s->low[k]) / 2, EXTENT_LEAST);
    }
    scan->limit2 = (s->options->is_truncated != 0) ? limit * limit : 0;
}

/* ---- a view -------------------------------------------------------------------- */

static int is_in_pass(const rigcal_faults_solver *s, size_t parameter)
{
    return s->columns.at[parameter] >= 0;
}

/* Which of the pairs of all columns the k-th of a view of a camera is. */
static size_t pair_of(const rigcal_faults_solver *s, size_t camera, size_t k)
{
    return (RC_PAIRS - 1) * ((k < RC_PAIRS - 1) ? camera : s->rig->n_cameras) +
           ((k < RC_PAIRS - 1) ? k : 0);
}

static void add_columns(rigcal_faults_solver *s, const rc_evidence *v,
                        const rc_chain *chain, size_t camera)
{
    for (size_t p = 0; p < RC_COLUMNS; p++) {
        if (is_in_pass(s, p)) {
            const size_t at = column_of(s, camera, p);
            rc_border_add(&s->border, chain, at, v->E[p]);
            s->columns.Q[at] += v->Q[p];
            s->columns.raw[at] += v->Q[p];
            s->columns.q[at] += v->q[p];
        }
    }
    for (size_t k = 0; k < RC_PAIRS; k++) {
        s->columns.pairs[pair_of(s, camera, k)] += v->pairs[k];
    }
}

static void add_own_columns(rigcal_faults_solver *s, const rc_evidence *v, size_t camera)
{
    for (size_t p = 0; p < RC_COLUMNS; p++) {
        if (is_in_pass(s, p)) {
            const size_t at = column_of(s, camera, p);
            s->columns.own_Q[at] += v->Q[p];
            s->columns.own_q[at] += v->q[p];
        }
    }
    for (size_t k = 0; k < RC_PAIRS; k++) {
        s->columns.own_pairs[pair_of(s, camera, k)] += v->pairs[k];
    }
}

/* How much of the view's disagreement lies along its motion (H12), its sum having been. */
static void add_along(rigcal_faults_solver *s, rigcal_real Q, rigcal_real q,
                      rigcal_real disagreement)
{
    if (Q > 0) {
        s->along += q * q / Q;
        s->disagreement += disagreement;
        s->speed2 += Q;
    }
}

/* The motion by cam_from_target of the view whose chain was found last. */
static rigcal_real motion_of(rigcal_real m[6], const rc_chain *chain, const rigcal_rig *rig)
{
    rc_clear(m, 6);
    if (rig->clocks == NULL) {
        return 0;
    }
    rc_motion_seen(m, chain, rig->clocks->memory.velocity);
    return rig->clocks->memory.since;
}

static rigcal_status add_view(rigcal_faults_solver *s)
{
    rigcal_rig_view view;
    rc_scan scan;
    rc_evidence v;
    rc_chain chain;
    rc_rig_parts parts;
    rigcal_real m[6], d[6], expected;
    rigcal_status status = rc_rig_view_at(&view, s->rig, s->view);
    if (status == RIGCAL_OK && (s->border.count >= s->rig->n_cameras || view.camera < 0 ||
                                (size_t)view.camera >= s->rig->n_cameras)) {
        status = RIGCAL_ERR_STATE;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    const size_t c = (size_t)view.camera;
    rc_rig_parts_of(&parts, s->rig, 0);
    scan_of(&scan, s);
    rc_rig_chain(&chain, s->rig, view.camera, s->placement, s->view);
    const rigcal_real since = motion_of(m, &chain, s->rig);
    status = rc_evidence_of(&v, &scan, &view, &chain, m, since);
    if (status != RIGCAL_OK) {
        return status;
    }
    rigcal_real g[6], H[21];
    for (int k = 0; k < 21; k++) {
        g[k % 6] = v.g[k % 6];
        H[k] = v.H[k];
    }
    rc_border_view(&s->border, &chain, parts.column[c], g, H);
    if (has_kind(s, RIGCAL_FAULT_MOVED)) {
        rc_moved_view(&s->moves, &s->border, c, g, H);
    }
    for (int k = 0; parts.column[c] >= 0 && k < 6; k++) {
        s->g[(size_t)parts.column[c] + (size_t)k] += g[k];
    }
    add_columns(s, &v, &chain, c);
    const rigcal_real sum = v.sum, Q = v.Q[RC_BY_CLOCK], q = v.q[RC_BY_CLOCK];
    if (!rc_evidence_alone(&v, d)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    add_own_columns(s, &v, c);
    add_along(s, Q, q, sum - v.sum);
    s->product += rc_evidence_pattern(&expected, &v, d);
    s->expected += expected;
    s->n_neighbours += v.n_neighbours;
    s->n_points += v.n;
    s->n_used++;
    s->sum += sum;
    s->own += v.sum;
    return RIGCAL_OK;
}

static void summing_step(rigcal_faults_solver *s)
{
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, s->rig, 0);
    const rigcal_status status =
        rc_rig_is_left_out(s->rig, s->view) ? RIGCAL_OK : add_view(s);
    if (status != RIGCAL_OK) {
        end(s, status, (int32_t)s->view);
    } else if (++s->view - s->first == rc_rig_views_of(&parts, s->placement)) {
        s->phase = ELIMINATING;
    }
}

/* ---- a placement ---------------------------------------------------------------- */

static rigcal_real dot(const rigcal_real a[], const rigcal_real b[], size_t n)
{
    rigcal_real sum = 0;
    for (size_t i = 0; i < n; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

/* What columns by themselves, and the cameras' g, lose to the placement. */
static void eliminate_columns(rigcal_faults_solver *s)
{
    const rc_border *const b = &s->border;
    const size_t n_cameras = s->rig->n_cameras;
    for (size_t i = 0; i < b->k; i++) {
        const rigcal_real *const Y = &b->Z[6 * i];
        s->columns.Q[i] -= dot(Y, Y, 6);
        s->columns.q[i] -= dot(Y, b->gp, 6);
        for (size_t j = 0; has_clocks(s) && i < n_cameras && j < i; j++) {
            s->columns.clocks[rc_packed_at(i, j)] -= dot(Y, &b->Z[6 * j], 6);
        }
    }
    for (size_t k = 0; k < RC_PAIRS; k++) {
        const size_t p = rc_pair_first[k];
        for (size_t c = 0; is_in_pass(s, p) && c < ((p < RC_OF_CAMERA) ? n_cameras : 1);
             c++) {
            const rigcal_real *const Y = &b->Z[6 * column_of(s, c, p)];
            s->columns.pairs[pair_of(s, c, k)] -= dot(Y, &Y[6], 6);
        }
    }
    for (size_t row = 0; row < 6 * b->count; row++) {
        if (b->slot[row / 6] >= 0) {
            s->g[(size_t)b->slot[row / 6] + row % 6] -= dot(&b->W[6 * row], b->gp, 6);
        }
    }
}

static void begin_testing(rigcal_faults_solver *s);

static void next_placement(rigcal_faults_solver *s)
{
    if (!begin_placement(s)) {
        begin_testing(s);
    }
}

static void eliminating_step(rigcal_faults_solver *s)
{
    if (!rc_border_eliminate(&s->border)) {
        end(s, RIGCAL_ERR_DEGENERATE, (int32_t)s->first);
        return;
    }
    eliminate_columns(s);
    s->slot = 0;
    s->phase = MOVING;
    if (has_kind(s, RIGCAL_FAULT_MOVED)) {
        rc_moved_eliminate(&s->moves, &s->border);
    }
}

/* Whether a camera saw the placement. */
static int is_there(const rigcal_faults_solver *s, size_t camera)
{
    for (size_t slot = 0; slot < s->border.count; slot++) {
        if ((size_t)s->moves.camera[slot] == camera) {
            return 1;
        }
    }
    return 0;
}

/* A camera may have moved before the placement where it has views on both sides. Between two
 * of its views one placement is as good as another. */
static void moving_step(rigcal_faults_solver *s)
{
    rc_rig_parts parts;
    const uint8_t *const breaks = s->options->breaks;
    const size_t c = s->slot++;
    if (!has_kind(s, RIGCAL_FAULT_MOVED) || c >= s->rig->n_cameras ||
        (breaks != NULL && breaks[s->placement] == 0)) {
        next_placement(s);
    } else if (s->moves.so_far[c] > 0 && s->moves.so_far[c] < s->moves.total[c] &&
               (breaks != NULL || is_there(s, c))) {
        rc_rig_parts_of(&parts, s->rig, 0);
        rc_moved_test(&s->moves, &s->border, parts.S, parts.column, s->rig->n_cameras, c,
                      s->placement, s->border.Z);
    }
}

/* ---- a fault ---------------------------------------------------------------------- */

static rigcal_real real_of(size_t n)
{
    return (rigcal_real)(int32_t)n;
}

static void common_of(rc_common *c, const rigcal_faults_solver *s)
{
    c->sum = s->sum;
    c->own = s->own;
    c->n_measured = 2 * real_of(s->n_points);
    c->freedom = c->n_measured - 6 * real_of(s->n_free + s->n_seen);
    c->freedom_within = c->n_measured - 6 * real_of(s->n_used);
    c->freedom_between = c->freedom - c->freedom_within;
}

/* The cameras whose clocks are freed together: not the first of its group, and the clock is
 * seen. */
static int is_freed(const rigcal_faults_solver *s, size_t camera)
{
    int is_first = 1;
    for (size_t c = 0; c < camera; c++) {
        is_first &= s->rig->group[c] != s->rig->group[camera];
    }
    return !is_first && s->columns.raw[camera] > 0;
}

/* Columns of a fault; the number of them. */
static size_t count_columns(const rigcal_faults_solver *s)
{
    if (s->test != RIGCAL_FAULT_CLOCKS) {
        size_t n = 0;
        for (size_t p = 0; p < RC_COLUMNS; p++) {
            n += KIND_OF[p] == s->test;
        }
        return n;
    }
    size_t n = 0;
    for (size_t c = 0; c < s->rig->n_cameras; c++) {
        n += (size_t)is_freed(s, c);
    }
    return n;
}

static size_t column_at(const rigcal_faults_solver *s, size_t j)
{
    if (s->test != RIGCAL_FAULT_CLOCKS) {
        return column_of(s, (size_t)s->camera, parameter_of(s->test)) + j;
    }
    size_t c = 0;
    while (!is_freed(s, c) || j-- > 0) {
        c++;
    }
    return c;
}

/* Q across columns i > j of the fault; of the views by themselves. */
static rigcal_real Q_across(const rigcal_faults_solver *s, size_t i, size_t j)
{
    if (s->test == RIGCAL_FAULT_CLOCKS) {
        return s->columns.clocks[rc_packed_at(column_at(s, i), column_at(s, j))];
    }
    size_t k = 0;
    while (rc_pair_first[k] != parameter_of(s->test)) {
        k++;
    }
    return s->columns.pairs[pair_of(s, (size_t)s->camera, k)];
}

/* The room for a test, in the place of Z. */
typedef struct {
    rigcal_real *G, *I, *theta, *variance, *turn, *shift;
} room;

static room room_of(const rigcal_faults_solver *s, size_t k)
{
    room r;
    r.G = s->border.Z;
    r.I = r.G + s->n;
    r.theta = r.I + packed(k);
    r.variance = r.theta + k;
    r.turn = r.variance + k;
    r.shift = r.turn + k;
    return r;
}

/* I and u of (H6), u in the place of theta, and what a unit of each does (H13). */
static void reduce(const room *r, const rigcal_faults_solver *s, size_t k)
{
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, s->rig, 0);
    for (size_t j = 0; j < k; j++) {
        const size_t at = column_at(s, j);
        rc_border_effect(r->G, &s->border, parts.S, at);
        rc_moved_most(&r->turn[j], &r->shift[j], r->G, s->n);
        r->theta[j] = s->columns.q[at] - dot(r->G, s->g, s->n);
        for (size_t i = j; i < k; i++) {
            const rigcal_real Q = (i == j) ? s->columns.Q[at] : Q_across(s, i, j);
            r->I[rc_packed_at(i, j)] =
                Q - dot(r->G, &s->border.T[s->n * column_at(s, i)], s->n);
        }
    }
}

/* theta, the gain and the variances. 0: the fault cannot be seen. */
static int solve(rigcal_real *gain, const room *r, const rigcal_faults_solver *s, size_t k)
{
    for (size_t i = 0; i < k; i++) {
        const rigcal_real raw = s->columns.raw[column_at(s, i)];
        if (!(raw > 0) || !rc_packed_factor_row(r->I, i, RANK_TOL * raw)) {
            return 0;
        }
    }
    rc_packed_forward(r->theta, r->I, k);
    *gain = dot(r->theta, r->theta, k);
    rc_packed_backward(r->theta, r->I, k);
    for (size_t i = 0; i < k; i++) {
        rc_packed_invert_row(r->I, i);
    }
    for (size_t i = 0; i < k; i++) {
        r->variance[i] = 0;
        for (size_t j = i; j < k; j++) {
            const rigcal_real x = r->I[rc_packed_at(j, i)];
            r->variance[i] += x * x;
        }
    }
    return 1;
}

/* What the views gain by themselves from theta (H8). */
static rigcal_real own_gain(const rigcal_faults_solver *s, const room *r, size_t k)
{
    rigcal_real gain = 0;
    for (size_t i = 0; i < k; i++) {
        const size_t at = column_at(s, i);
        gain +=
            r->theta[i] * (2 * s->columns.own_q[at] - r->theta[i] * s->columns.own_Q[at]);
    }
    for (size_t p = 0; p < RC_PAIRS && s->test != RIGCAL_FAULT_CLOCKS; p++) {
        if (k == 2 && rc_pair_first[p] == parameter_of(s->test)) {
            gain -= 2 * r->theta[0] * r->theta[1] *
                    s->columns.own_pairs[pair_of(s, (size_t)s->camera, p)];
        }
    }
    return gain;
}

/* Where the caller wants them, the clocks one by one. */
static void write_clocks(const rigcal_faults_solver *s, const room *r, rigcal_real variance)
{
    const size_t n_cameras = s->rig->n_cameras;
    size_t j = 0;
    for (size_t c = 0; s->options->clocks != NULL && c < n_cameras; c++) {
        if (is_freed(s, c)) {
            s->options->clocks[c] = r->theta[j];
            s->options->clocks[n_cameras + c] = RC_SQRT(r->variance[j++] * variance);
        }
    }
}

static void test_columns(rigcal_fault *fault, const rigcal_faults_solver *s)
{
    rc_common common;
    rigcal_real gain;
    const size_t k = count_columns(s);
    const room r = room_of(s, k);
    common_of(&common, s);
    fault->n = (int32_t)k;
    reduce(&r, s, k);
    if (k == 0 || !(common.freedom > real_of(k)) || !solve(&gain, &r, s, k)) {
        return;
    }
    const rc_one_step step = {k,      1,       r.theta, r.variance,
                              r.turn, r.shift, gain,    own_gain(s, &r, k)};
    rc_finding_of(fault, &common, &step);
    if (s->test == RIGCAL_FAULT_CLOCKS) {
        write_clocks(s, &r, (s->sum - fault->gain) / (common.freedom - real_of(k)));
    }
}

static void test_moved(rigcal_fault *fault, const rigcal_faults_solver *s)
{
    rc_common common;
    const rigcal_real *const best = &s->moves.best[RC_MOVED_SIZE * (size_t)s->camera];
    const rc_one_step step = {6,
                              (size_t)best[RC_MOVED_TRIES],
                              &best[RC_MOVED_THETA],
                              &best[RC_MOVED_VARIANCE],
                              &best[RC_MOVED_TURN],
                              &best[RC_MOVED_SHIFT],
                              best[RC_MOVED_GAIN],
                              0};
    common_of(&common, s);
    fault->n = 6;
    if (best[RC_MOVED_GAIN] > 0 && common.freedom > real_of(step.k)) {
        fault->placement = (int32_t)best[RC_MOVED_AT];
        rc_finding_of(fault, &common, &step);
    }
}

/* ---- all faults of a pass ----------------------------------------------------------- */

/* The next fault from s->test, s->camera on. 0: there is none. */
static int find_test(rigcal_faults_solver *s)
{
    for (; s->test < RIGCAL_FAULT_KINDS; s->test++, s->camera = 0) {
        const int32_t n = is_of_camera(s->test) ? (int32_t)s->rig->n_cameras : 1;
        if (has_kind(s, s->test) && s->camera < n) {
            return 1;
        }
    }
    return 0;
}

static void finish(rigcal_faults_solver *s);

static void go_on_testing(rigcal_faults_solver *s)
{
    if (find_test(s)) {
        return;
    }
    if (s->left == 0) {
        finish(s);
    } else if (choose_kinds(s)) {
        begin_pass(s);
    } else {
        end(s, RIGCAL_ERR_CAPACITY, -1);
    }
}

static void begin_testing(rigcal_faults_solver *s)
{
    const size_t n_cameras = s->rig->n_cameras;
    for (size_t c = 0; has_clocks(s) && c < n_cameras; c++) {
        s->columns.clocks[rc_packed_at(c, c)] = s->columns.Q[c];
    }
    s->test = s->camera = 0;
    s->phase = TESTING;
    go_on_testing(s);
}

static void testing_step(rigcal_faults_solver *s)
{
    rigcal_fault fault = {0};
    fault.kind = s->test;
    fault.camera = is_of_camera(s->test) ? s->camera : -1;
    fault.placement = -1;
    if (s->test == RIGCAL_FAULT_MOVED) {
        test_moved(&fault, s);
    } else {
        test_columns(&fault, s);
    }
    if (s->test != RIGCAL_FAULT_CLOCKS || fault.n > 1) {
        s->found.n_seen += fault.is_seen;
        rc_finding_rank(s->faults, &s->found.n, s->capacity, &fault);
    }
    s->camera++;
    go_on_testing(s);
}

/* ---- the verdict ------------------------------------------------------------------------ */

/* Neighbouring residuals, and the part along the motion. */
static void judge_residuals(rigcal_faults *found, const rigcal_faults_solver *s,
                            const rc_common *common)
{
    const rigcal_real variance = s->own / common->freedom_within;
    if (s->n_neighbours > 0 && variance > 0) {
        const rigcal_real n = 2 * real_of(s->n_neighbours);
        found->pattern = (s->product / variance - s->expected) / n;
        found->pattern_sigma = 1 / RC_SQRT(n);
        if (found->pattern > PATTERN_LEAST &&
            found->pattern > PATTERN_DEVIATIONS * found->pattern_sigma) {
            found->bits |= RIGCAL_FAULTS_PATTERN;
        }
    }
    if (s->disagreement > 0 && s->speed2 > 0) {
        found->along = s->along / s->disagreement;
        found->along_time = RC_SQRT(s->along / s->speed2);
        if (found->along > ALONG_MOST && (found->bits & RIGCAL_FAULTS_PATTERN) == 0) {
            found->bits |= RIGCAL_FAULTS_ALONG_MOTION;
        }
    }
}

/* Why clocks could not be tested, and that two cameras are alike. */
static void judge_clocks(rigcal_faults *found, const rigcal_faults_solver *s)
{
    const rigcal_rig_clocks *const clocks = s->rig->clocks;
    found->frame = (clocks == NULL) ? 0 : clocks->frame;
    if (clocks == NULL) {
        found->bits |= RIGCAL_FAULTS_NO_TIMES;
    } else if (!(s->speed2 > 0)) {
        found->bits |= RIGCAL_FAULTS_NO_NEIGHBOUR;
    } else {
        const rigcal_real off = RIGCAL_FAULT_DEVIATIONS * found->sigma_px;
        if (off * off > s->speed2 * found->frame * found->frame / 2) {
            found->bits |= RIGCAL_FAULTS_NO_MOTION;
        }
    }
    if (s->rig->n_cameras == 2) {
        found->bits |= RIGCAL_FAULTS_TWO_CAMERAS;
    }
}

static void finish(rigcal_faults_solver *s)
{
    rc_common common;
    rigcal_faults *const found = &s->found;
    common_of(&common, s);
    s->phase = DONE;
    s->status = RIGCAL_OK;
    found->n_cameras = (int32_t)s->rig->n_cameras;
    found->clocks = s->options->clocks;
    found->freedom_between = common.freedom_between;
    found->freedom_within = common.freedom_within;
    found->sigma_px = (common.freedom > 0) ? RC_SQRT(s->sum / common.freedom) : 0;
    if (!(common.freedom_between > 0) || !(common.freedom_within > 0) || !(s->own > 0)) {
        found->bits |= RIGCAL_FAULTS_NO_LOOP;
        judge_clocks(found, s);
        return;
    }
    found->own_px = RC_SQRT(s->own / common.freedom_within);
    found->F = rc_F_of(&common, 0, 0, 0);
    judge_residuals(found, s, &common);
    judge_clocks(found, s);
    rc_finding_judge(found, s->faults, &common);
}

/* ---- in steps ------------------------------------------------------------------------------ */

static rigcal_status check(const rigcal_rig *rig, const rigcal_faults_options *options,
                           size_t capacity)
{
    rc_rig_parts parts;
    rigcal_status status = rc_rig_check(rig);
    if (status == RIGCAL_OK && rig->views == NULL && rig->view_source == NULL) {
        status = RIGCAL_ERR_NULL;
    }
    if (status == RIGCAL_OK &&
        (capacity < 1 || options->kinds < 0 || options->kinds > RIGCAL_FAULTS_ALL ||
         options->is_truncated < 0 || options->is_truncated > 1 ||
         (options->is_truncated > 0 && !(rig->sigma_px > 0)))) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK && !rc_rig_is_adjusted(&parts, rig)) {
        status = RIGCAL_ERR_STATE;
    }
    for (size_t f = 0; status == RIGCAL_OK && f < rig->n_placements; f++) {
        if (!(RC_FABS(parts.count[f]) <= real_of(rig->n_cameras))) {
            status = RIGCAL_ERR_STATE;
        }
    }
    return status;
}

static void count_unknowns(rigcal_faults_solver *s)
{
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, s->rig, 0);
    s->n = s->n_free = 0;
    for (size_t c = 0; c < s->rig->n_cameras; c++) {
        if (parts.column[c] >= 0) {
            s->n += 6;
            s->n_free += rc_rig_has_prior(s->rig, c) ? 0 : 1;
        }
    }
}

rigcal_status rigcal_faults_begin(rigcal_faults_solver *s, rigcal_fault faults[],
                                  size_t capacity, const rigcal_faults_options *options,
                                  rigcal_rig *rig)
{
    if (s == NULL || faults == NULL || options == NULL || options->work == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = check(rig, options, capacity);
    if (status != RIGCAL_OK) {
        return status;
    }
    *s = (rigcal_faults_solver){0};
    s->rig = rig;
    s->options = options;
    s->faults = faults;
    s->capacity = capacity;
    s->left = (options->kinds == 0) ? RIGCAL_FAULTS_ALL : options->kinds;
    s->at_fault = -1;
    for (int k = 0; k < 2; k++) {
        s->low[k] = RC_MAX;
        s->high[k] = -RC_MAX;
    }
    count_unknowns(s);
    if (!choose_kinds(s)) {
        return RIGCAL_ERR_CAPACITY;
    }
    rc_clear(s->moves.total, rig->n_cameras);
    if (options->clocks != NULL) {
        rc_clear(options->clocks, 2 * rig->n_cameras);
    }
    s->phase = COUNTING;
    return RIGCAL_OK;
}

static void one_step(rigcal_faults_solver *s)
{
    switch (s->phase) {
    case COUNTING:
        counting_step(s);
        break;
    case SUMMING:
        summing_step(s);
        break;
    case ELIMINATING:
        eliminating_step(s);
        break;
    case MOVING:
        moving_step(s);
        break;
    default:
        testing_step(s);
        break;
    }
}

rigcal_status rigcal_faults_step(rigcal_faults_solver *solver, int32_t budget)
{
    const rigcal_status status =
        rc_check_step((solver == NULL) ? NULL : &solver->phase, budget);
    if (status != RIGCAL_OK) {
        return status;
    }
    for (; budget > 0 && solver->phase != DONE; budget--) {
        one_step(solver);
    }
    return (solver->phase == DONE) ? RIGCAL_OK : RIGCAL_RUNNING;
}

rigcal_status rigcal_faults_result(rigcal_faults *found, int32_t *at_fault,
                                   const rigcal_faults_solver *solver)
{
    if (at_fault != NULL) {
        *at_fault = -1;
    }
    if (found == NULL || solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (solver->phase != DONE) {
        return RIGCAL_ERR_STATE;
    }
    if (at_fault != NULL) {
        *at_fault = solver->at_fault;
    }
    if (solver->status == RIGCAL_OK) {
        *found = solver->found;
    }
    return solver->status;
}

rigcal_status rigcal_rig_faults(rigcal_faults *found, rigcal_fault faults[],
                                size_t capacity, int32_t *at_fault,
                                const rigcal_faults_options *options, rigcal_rig *rig)
{
    rigcal_faults_solver solver;
    if (at_fault != NULL) {
        *at_fault = -1;
    }
    if (found == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status =
        rigcal_faults_begin(&solver, faults, capacity, options, rig);
    if (status != RIGCAL_OK) {
        return status;
    }
    while (rigcal_faults_step(&solver, 1000) == RIGCAL_RUNNING) {
    }
    return rigcal_faults_result(found, at_fault, &solver);
}
