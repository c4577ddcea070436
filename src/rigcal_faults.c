#include "rc_motion.h"
#include "rc_columns.h"
#include "rc_moved.h"

enum {
    DONE = 1,
    COUNTING,    /* counts the views of each camera, finds how far the points reach */
    SUMMING,     /* adds the sums of a view */
    ELIMINATING, /* eliminates a placement */
    MOVING,      /* tests whether a camera moved at this placement */
    TESTING      /* tests a fault, after all views have been added */
};

/* ---- memory ------------------------------------------------------------ */

/* Takes memory for the kinds of s->columns.kinds. Returns 0 if there is not enough. */
static int lay_out(rigcal_faults_solver *s)
{
    rc_rig_parts parts;
    const size_t n_cameras = s->rig->n_cameras;
    const int is_moved = rc_columns_has(&s->columns, RIGCAL_FAULT_MOVED);
    rc_rig_parts_of(&parts, s->rig, 0);
    rigcal_real *const saved = (rigcal_real *)(void *)parts.saved;
    rc_pool pool = {{saved, s->options->work},
                    {(size_t)(parts.S - saved), s->options->work_capacity},
                    1};
    s->moves.total =
        rc_pool_take(&pool, n_cameras); /* taken first: it and reference lie at the same
                                           place in every pass */
    s->columns.reference = rc_pool_take(&pool, 3 * n_cameras);
    s->columns.rig = s->rig;
    s->columns.n = s->n;
    s->columns.border.W = parts.W;
    s->columns.border.slot = parts.slot;
    rc_columns_lay_out(&s->columns, &pool, is_moved ? 12 : 0);
    rc_moved_lay_out(&s->moves, &s->columns, &pool);
    return pool.is_enough;
}

/* The kind that can wait longest: MOVED if it is one of them, otherwise the last. */
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

/* Chooses the kinds of the next pass: as many as there is memory for. The others wait for a
 * later pass. Returns 0 if there is memory for none. */
static int choose_kinds(rigcal_faults_solver *s)
{
    s->columns.kinds = s->left;
    while (!lay_out(s)) {
        s->columns.kinds &= ~RIGCAL_FAULTS_OF(last_of(s->columns.kinds));
        if (s->columns.kinds == 0) {
            return 0;
        }
    }
    s->left &= ~s->columns.kinds;
    return 1;
}

/* ---- a pass ------------------------------------------------------------ */

static void end(rigcal_faults_solver *s, rigcal_status status, int32_t at_fault)
{
    s->status = status;
    s->at_fault = at_fault;
    s->phase = DONE;
}

/* Goes down from s->placement to the next placement that was seen. The tests for cameras
 * that moved need the views from the last placement to the first. Returns 0 if there is
 * none. */
static int begin_placement(rigcal_faults_solver *s)
{
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, s->rig, 0);
    while (s->placement > 0) {
        s->placement--;
        s->first -= rc_rig_views_of(&parts, s->placement);
        if (parts.count[s->placement] > 0) {
            rc_border_next(&s->columns.border);
            s->view = s->first;
            s->phase = SUMMING;
            s->n_seen++;
            return 1;
        }
    }
    return 0;
}

/* Adds the priors of cameras, which belong to the sum and to its derivative. */
static rigcal_status add_priors(rigcal_faults_solver *s)
{
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, s->rig, 0);
    for (size_t c = 0; c < s->rig->n_cameras; c++) {
        if (rc_rig_has_prior(s->rig, c)) {
            rigcal_real sum, g[6], H[21];
            const rigcal_status status = rc_rig_prior(&sum, g, H, NULL, s->rig, c);
            if (status != RIGCAL_OK) {
                return status;
            }
            rc_columns_add_gradient(&s->columns, parts.column[c], g);
            s->sum += sum;
        }
    }
    return RIGCAL_OK;
}

static void begin_pass(rigcal_faults_solver *s)
{
    rc_columns_begin(&s->columns);
    if (rc_columns_has(&s->columns, RIGCAL_FAULT_MOVED)) {
        rc_moved_begin(&s->moves, &s->columns);
    }
    s->n_points = s->n_used = s->n_seen = s->n_neighbours = 0;
    s->sum = s->own = s->product = s->expected = s->expected2 = 0;
    s->along = s->disagreement = s->speed2 = 0;
    s->first = s->rig->n_views;
    s->placement = s->rig->n_placements;
    s->found.passes++;
    const rigcal_status status = add_priors(s);
    if (status != RIGCAL_OK) {
        end(s, status, -1);
    } else if (!begin_placement(s)) {
        end(s, RIGCAL_ERR_TOO_FEW, -1);
    }
}

/* ---- where the points are ---------------------------------------------- */

/* Whether the camera's pose can take up any turn and shift: it is free, or it is the only
 * one of its group that is held. */
static int is_free_to_move(const rigcal_faults_solver *s, size_t camera)
{
    rc_rig_parts parts;
    size_t fixed = 0;
    rc_rig_parts_of(&parts, s->rig, 0);
    for (size_t c = 0; c < s->rig->n_cameras; c++) {
        if (s->rig->group[c] == s->rig->group[camera] &&
            (parts.column[c] < 0 || rc_rig_has_prior(s->rig, c))) {
            fixed++;
        }
    }
    return !rc_rig_has_prior(s->rig, camera) && (parts.column[camera] >= 0 || fixed == 1);
}

/* Sets the reference of a camera from its first view. */
static void set_reference(const rigcal_faults_solver *s, const rigcal_rig_view *v)
{
    rigcal_real *const reference = &s->columns.reference[3 * v->camera];
    rc_chain chain;
    rc_clear(reference, 3);
    if (is_free_to_move(s, (size_t)v->camera)) {
        rc_rig_chain(&chain, s->rig, v->camera, (size_t)v->placement, s->view);
        reference[0] = 1 / v->view.camera->fx;
        reference[1] = 1 / v->view.camera->fy;
        reference[2] = chain.cam_from_target.t[2];
    }
}

/* Counts view s->view for its camera, and widens the extent of the board to its points. */
static rigcal_status count_view(rigcal_faults_solver *s)
{
    rigcal_rig_view v;
    rigcal_points points;
    if (rc_rig_is_left_out(s->rig, s->view)) {
        return RIGCAL_OK;
    }
    rigcal_status status = rc_rig_view_at(&v, s->rig, s->view);
    if (status == RIGCAL_OK) {
        status = rc_rig_points(&points, &v);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!(s->moves.total[v.camera] > 0)) {
        set_reference(s, &v);
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

static void scan_of(rc_scan *scan, const rigcal_faults_solver *s, int32_t camera)
{
    const rigcal_real limit = RC_TRUNCATED_FROM * s->rig->sigma_px;
    for (int k = 0; k < 2; k++) {
        scan->middle[k] = s->low[k] + (s->high[k] - s->low[k]) / 2;
        const rigcal_real half = (s->high[k] - s->low[k]) / 2;
        scan->half[k] = (half > 0) ? half : 1; /* all points are on a line, so none is off
                                                  the middle */
    }
    scan->reference = &s->columns.reference[3 * camera];
    scan->limit2 = (s->options->is_truncated != 0) ? limit * limit : 0;
}

/* ---- a view ------------------------------------------------------------ */

/* Adds how much of the view's disagreement lies along its motion (H14). Q and q are those
 * of the clock. */
static void add_along(rigcal_faults_solver *s, rigcal_real Q, rigcal_real q,
                      rigcal_real disagreement)
{
    if (Q > 0) {
        s->along += q * q / Q;
        s->disagreement += disagreement;
        s->speed2 += Q;
    }
}

/* m is the motion of cam_from_target, for the view whose chain was computed last. Returns
 * its time after the middle of the recording. */
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
    if (status != RIGCAL_OK) {
        return status;
    }
    const size_t c = (size_t)view.camera;
    rc_rig_parts_of(&parts, s->rig, 0);
    scan_of(&scan, s, view.camera);
    rc_rig_chain(&chain, s->rig, view.camera, s->placement, s->view);
    const rigcal_real since = motion_of(m, &chain, s->rig);
    status = rc_evidence_of(&v, &scan, &view, &chain, m, since);
    if (status != RIGCAL_OK) {
        return status;
    }
    rigcal_real g[6], H[21], sum = v.sum;
    for (int k = 0; k < 21; k++) {
        g[k % 6] = v.g[k % 6];
        H[k] = v.H[k];
    }
    if (s->rig->clocks != NULL) {
        s->rig->clocks->calls->weigh(&sum, g, H, &chain, s->rig);
        rc_evidence_stamp(&v, s->rig->clocks->memory.ratio2);
    }
    rc_border_view(&s->columns.border, &chain, parts.column[c], g, H);
    rc_columns_add(&s->columns, &v, &chain, c, since, g);
    if (rc_columns_has(&s->columns, RIGCAL_FAULT_MOVED)) {
        rc_moved_view(&s->moves, &s->columns.border, c, g, H);
        rc_moved_clock(&s->moves, &s->columns, &v, &chain, c);
    }
    const rigcal_real Q = v.left * v.Q[RC_BY_CLOCK], q = v.left * v.q[RC_BY_CLOCK];
    if (!rc_evidence_alone(&v, d)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    rc_columns_add_alone(&s->columns, &v, c);
    add_along(s, Q, q, sum - v.sum);
    s->product += rc_evidence_pattern(&expected, &v, d);
    s->expected += expected;
    s->expected2 += expected * expected;
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

/* ---- a placement ------------------------------------------------------- */

static void begin_testing(rigcal_faults_solver *s);

static void next_placement(rigcal_faults_solver *s)
{
    if (!begin_placement(s)) {
        begin_testing(s);
    }
}

static void eliminating_step(rigcal_faults_solver *s)
{
    if (!rc_border_eliminate(&s->columns.border)) {
        end(s, RIGCAL_ERR_DEGENERATE, (int32_t)s->first);
        return;
    }
    rc_columns_eliminate(&s->columns);
    s->slot = 0;
    s->phase = MOVING;
    if (rc_columns_has(&s->columns, RIGCAL_FAULT_MOVED)) {
        rc_moved_eliminate(&s->moves, &s->columns);
    }
}

/* Tests whether a camera moved before this placement. It needs views of the camera on both
 * sides. Between two of its views all placements fit alike, so only one is tested. */
static void moving_step(rigcal_faults_solver *s)
{
    rc_rig_parts parts;
    const uint8_t *const breaks = s->options->breaks;
    const size_t c = s->slot++;
    if (!rc_columns_has(&s->columns, RIGCAL_FAULT_MOVED) || c >= s->rig->n_cameras ||
        (breaks != NULL && breaks[s->placement] == 0)) {
        next_placement(s);
    } else if (s->moves.so_far[c] > 0 && s->moves.so_far[c] < s->moves.total[c] &&
               (breaks != NULL || rc_moved_saw(&s->moves, &s->columns, c))) {
        rc_rig_parts_of(&parts, s->rig, 0);
        rc_moved_test(&s->moves, &s->columns, parts.S, parts.column, c, s->placement,
                      s->columns.border.Z);
    }
}

/* ---- a fault ----------------------------------------------------------- */

static rigcal_real real_of(size_t n)
{
    return (rigcal_real)(int32_t)n;
}

static void common_of(rc_common *c, const rigcal_faults_solver *s)
{
    c->sum = s->sum;
    c->own = s->own;
    c->n_measured = 2 * real_of(s->n_points);
    c->freedom = c->n_measured - 6 * real_of(s->n_free + s->n_seen) -
                 real_of(rc_columns_n_free(&s->columns));
    c->freedom_within = c->n_measured - 6 * real_of(s->n_used);
    c->freedom_between = c->freedom - c->freedom_within;
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

/* ---- all faults of a pass ---------------------------------------------- */

/* Finds the next fault from s->test, s->camera on. Returns 0 if there is none. */
static int find_test(rigcal_faults_solver *s)
{
    for (; s->test < RIGCAL_FAULT_KINDS; s->test++, s->camera = 0) {
        const int32_t n = rc_is_of_camera(s->test) ? (int32_t)s->rig->n_cameras : 1;
        if (rc_columns_has(&s->columns, s->test) && s->camera < n) {
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
    } else {
        (void)choose_kinds(s);
        begin_pass(s);
    }
}

static void begin_testing(rigcal_faults_solver *s)
{
    s->test = s->camera = 0;
    s->phase = TESTING;
    go_on_testing(s);
}

static void testing_step(rigcal_faults_solver *s)
{
    rigcal_fault fault = {0};
    fault.kind = s->test;
    fault.camera = rc_is_of_camera(s->test) ? s->camera : -1;
    fault.placement = -1;
    if (s->test == RIGCAL_FAULT_MOVED) {
        test_moved(&fault, s);
    } else {
        rc_common common;
        common_of(&common, s);
        rc_columns_test(&fault, &s->columns, &common, s->options->clocks);
    }
    if (s->test != RIGCAL_FAULT_CLOCKS || fault.n > 1) {
        s->found.n_seen += fault.is_seen;
        rc_finding_rank(s->faults, &s->found.n, s->capacity, &fault);
    }
    s->camera++;
    go_on_testing(s);
}

/* ---- the verdict ------------------------------------------------------- */

/* Notes why clocks could not be tested, and whether there are two cameras only. */
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
        for (int32_t i = 0; i < found->n; i++) {
            s->faults[i].explains = 0;
        }
        judge_clocks(found, s);
        return;
    }
    found->own_px = RC_SQRT(s->own / common.freedom_within);
    found->F = rc_F_of(&common, 0, 0, 0);
    const rc_residues residues = {
        real_of(s->n_neighbours), s->product, s->expected, s->expected2, s->along,
        s->disagreement,          s->speed2};
    rc_finding_residues(found, &residues, &common);
    judge_clocks(found, s);
    rc_finding_judge(found, s->faults, &common);
}

/* ---- in steps ---------------------------------------------------------- */

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
    for (size_t c = 0; status == RIGCAL_OK && c < rig->n_cameras; c++) {
        status = rc_rig_check_camera(rig, c);
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
    for (size_t c = 0; c < s->rig->n_cameras; c++) {
        if (parts.column[c] >= 0) {
            s->n += 6;
            s->n_free += rc_rig_has_prior(s->rig, c) ? 0 : 1;
        }
    }
}

rigcal_status rigcal_faults_begin(rigcal_faults_solver *solver, rigcal_fault faults[],
                                  size_t capacity, const rigcal_faults_options *options,
                                  rigcal_rig *rig)
{
    rigcal_faults_solver s = {0}; /* a solver that is refused stays unchanged */
    if (solver == NULL || faults == NULL || options == NULL || options->work == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = check(rig, options, capacity);
    if (status != RIGCAL_OK) {
        return status;
    }
    s.rig = rig;
    s.options = options;
    s.faults = faults;
    s.capacity = capacity;
    s.phase = COUNTING;
    s.at_fault = -1;
    for (int k = 0; k < 2; k++) {
        s.low[k] = RC_MAX;
        s.high[k] = -RC_MAX;
    }
    count_unknowns(&s);
    const int32_t all = (options->kinds == 0) ? RIGCAL_FAULTS_ALL : options->kinds;
    for (s.left = all; s.left != 0;) { /* every pass must fit */
        if (!choose_kinds(&s)) {
            return RIGCAL_ERR_CAPACITY;
        }
    }
    s.left = all;
    (void)choose_kinds(&s);
    rc_clear(s.moves.total, rig->n_cameras);
    if (options->clocks != NULL) {
        rc_clear(options->clocks, 2 * rig->n_cameras);
    }
    *solver = s;
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
    while (rigcal_faults_step(&solver, 100) == RIGCAL_RUNNING) {
    }
    return rigcal_faults_result(found, at_fault, &solver);
}
