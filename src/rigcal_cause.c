#include "rc_adjust.h"
#include "rc_choose.h"
#include "rc_pose.h"

/* Why a view contradicts the others. It is tested with its points permuted, as a view of
 * the placement before or after, and with the lens of another camera. A cause is found if
 * it then agrees with the rest. All views of a camera are tested together in the same
 * way. */

enum {
    DONE = 1,
    TESTING, /* tests the causes, one after the other */
    SOLVING, /* solves the pose of the view as it is tested */
    SCORING  /* compares where one view puts a camera with the others */
};

/* Tests of a camera: unchanged, one placement late, one early, then the permutations. */
enum { AS_IT_IS, LATE, EARLY, FIRST_PERMUTATION };

/* ---- what the others say ---------------------------------------------------- */

/* The first view of this placement or, if nobody saw it, of one after it. */
static rigcal_status first_of(size_t *first, const rigcal_rig *rig, int32_t placement)
{
    size_t low = 0, high = rig->n_views;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        rigcal_view_pose own;
        const rigcal_status status = rc_rig_pose_at(&own, rig, middle);
        if (status != RIGCAL_OK) {
            return status;
        }
        if (own.placement < placement) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    *first = low;
    return RIGCAL_OK;
}

/* The claim about a placement that one view of `camera` makes. Returns 0 if the view's
 * information matrix is not positive definite. */
static int place_by(rc_claim *placement, const rigcal_cause_solver *s,
                    const rigcal_view_pose *own, size_t camera)
{
    rc_claim view, exact = {0};
    exact.b_from_a = s->rig->cams_from_rig[camera];
    if (!rc_claim_of_view(&view, own, own->sse, 0, 0)) {
        return 0;
    }
    rc_claim_place(placement, &view, &exact, 0);
    return 1;
}

/* The claim about placement f that the views of other cameras than these two make. It is
 * the rig's placement with the information of the kept views. If all are left out, it is
 * the claim of the first of them. placement->view is -1 if there is no such view. */
static rigcal_status place_by_others(rc_claim *placement, const rigcal_cause_solver *s,
                                     int32_t f, int32_t camera, int32_t other)
{
    static const rigcal_real NONE[6] = {0};
    const rigcal_rig *const rig = s->rig;
    rigcal_real g[6], H[21], Sigma[36];
    rc_chain chain;
    size_t v = 0;
    rigcal_status status = first_of(&v, rig, f);
    placement->view = -1;
    rc_rigid_clear(g, H);
    for (; status == RIGCAL_OK && v < rig->n_views; v++) {
        rigcal_view_pose own;
        status = rc_rig_pose_at(&own, rig, v);
        if (status != RIGCAL_OK || own.placement != f) {
            break;
        }
        if (own.camera == camera || own.camera == other) {
            continue;
        }
        if (placement->view < 0 && !place_by(placement, s, &own, (size_t)own.camera)) {
            return RIGCAL_ERR_DEGENERATE;
        }
        if (!rc_rig_is_left_out(rig, v)) {
            chain.R_c = rig->cams_from_rig[own.camera].R;
            rc_chain_add_placement(g, H, &chain, NONE, own.information);
        }
    }
    if (status == RIGCAL_OK && rc_sym6_invert(Sigma, H)) { /* not if none is kept: H = 0 */
        rc_sym6_pack(placement->Sigma, Sigma);
        placement->b_from_a = rig->rig_from_placements[f];
    }
    return status;
}

static void end(rigcal_cause_solver *s, rigcal_status status)
{
    s->status = status;
    s->phase = DONE;
}

/* ---- one view ---------------------------------------------------------------- */

/* Notes what a test has found. The cause with the least distance counts. */
static void note(rigcal_cause_solver *s, rigcal_real apart, int32_t cause, int32_t number)
{
    rigcal_cause *const found = &s->found;
    const rigcal_real part = apart / s->limit;
    if (!(part <= 1)) {
        return;
    }
    if (cause == RIGCAL_CAUSE_SHIFTED && found->cause == RIGCAL_CAUSE_SHIFTED &&
        found->shift != number) {
        found->is_still = 1; /* the placements before and after fit alike */
    }
    if (found->cause == RIGCAL_CAUSE_UNKNOWN || part < found->distance) {
        found->cause = cause;
        found->distance = part;
        found->permutation = (cause == RIGCAL_CAUSE_TURNED) ? number : -1;
        found->shift = (cause == RIGCAL_CAUSE_SHIFTED) ? number : 0;
        found->camera = (cause == RIGCAL_CAUSE_SWAPPED) ? number : -1;
    }
}

/* Permutes the points of the tested view, in memory of the caller. Returns 0 if the view
 * has not exactly the target's points. */
static int permute(rigcal_cause_solver *s, size_t row)
{
    const rigcal_symmetries *const sym = s->symmetries;
    const int32_t *const number = &sym->permutations[row * sym->n_points];
    const rigcal_observation *const from = s->seen.view.observations;
    if (rc_check_view(&s->seen.view) != RIGCAL_OK || s->seen.view.n != sym->n_points) {
        return 0;
    }
    for (size_t i = 0; i < sym->n_points; i++) {
        rc_vec3_copy(sym->room[i].X_w, from[number[i]].X_w);
        sym->room[i].uv[0] = from[i].uv[0];
        sym->room[i].uv[1] = from[i].uv[1];
    }
    s->seen.view.observations = sym->room;
    return 1;
}

/* Begins to solve the tested view as it is now. */
static void begin_solving(rigcal_cause_solver *s)
{
    if (rigcal_pose_begin(&s->pose, NULL, &s->seen.view, NULL) == RIGCAL_OK) {
        s->phase = SOLVING;
    }
}

/* Tests the view with the lens of the camera of view v, if v is another view of the
 * placement and is left out too. */
static void test_swap(rigcal_cause_solver *s, size_t v)
{
    rigcal_rig_view other;
    if (v == s->view || !rc_rig_is_left_out(s->rig, v)) {
        return;
    }
    rigcal_status status = rc_rig_view_at(&other, s->rig, v);
    if (status == RIGCAL_OK) {
        status = rc_check_view(&other.view);
    }
    if (status == RIGCAL_OK) {
        s->lens = *other.view.camera;
        s->acting = other.camera;
        status = rc_rig_view_at(&s->seen, s->rig, s->view);
    }
    if (status != RIGCAL_OK) {
        end(s, status);
        return;
    }
    s->seen.view.camera = &s->lens;
    begin_solving(s);
}

static size_t n_permutations(const rigcal_cause_solver *s)
{
    return (s->symmetries == NULL) ? 0 : s->symmetries->n_permutations;
}

/* Begins the next test of a view: the permutations, then as it is, then other lenses. */
static void test_view(rigcal_cause_solver *s)
{
    const size_t n = n_permutations(s), test = s->test++;
    if (test <= n) {
        const rigcal_status status = rc_rig_view_at(&s->seen, s->rig, s->view);
        s->acting = s->own.camera;
        if (status != RIGCAL_OK) {
            end(s, status);
        } else if (test == n || permute(s, test)) {
            begin_solving(s);
        }
    } else if (s->first + (test - n - 1) < s->last) {
        test_swap(s, s->first + (test - n - 1));
    } else {
        end(s, RIGCAL_OK);
    }
}

/* Compares the poses of the tested view with a placement as the other views have it. */
static rigcal_status compare_with(rigcal_cause_solver *s, int32_t placement,
                                  const rigcal_pose poses[], size_t found, int32_t cause,
                                  int32_t number)
{
    rc_claim here, there;
    const rigcal_status status =
        place_by_others(&there, s, placement, s->own.camera, s->acting);
    for (size_t i = 0; status == RIGCAL_OK && there.view >= 0 && i < found; i++) {
        rigcal_view_pose own;
        if (rigcal_view_pose_make(&own, &s->seen, &poses[i].cam_from_world) == RIGCAL_OK) {
            (void)place_by(&here, s, &own, (size_t)s->acting); /* it can be inverted */
            note(s, rc_claims_apart(&here, &there) + poses[i].sse - poses[0].sse, cause,
                 number);
        }
    }
    return status;
}

/* A view as it is is compared with the placements before and after, any other with its
 * own placement. */
static void compare_view(rigcal_cause_solver *s)
{
    const size_t n = n_permutations(s), test = s->test - 1;
    const int32_t f = s->own.placement;
    rigcal_pose poses[2];
    size_t found = 0;
    rigcal_status status = RIGCAL_OK;
    s->phase = TESTING;
    if (rigcal_pose_result(poses, 2, &found, NULL, &s->pose) < 0) {
        return;
    }
    if (test < n) {
        status = compare_with(s, f, poses, found, RIGCAL_CAUSE_TURNED, (int32_t)test);
    } else if (test > n) {
        status = compare_with(s, f, poses, found, RIGCAL_CAUSE_SWAPPED, s->acting);
    } else {
        status = compare_with(s, f - 1, poses, found, RIGCAL_CAUSE_SHIFTED, -1);
        if (status == RIGCAL_OK) {
            status = compare_with(s, f + 1, poses, found, RIGCAL_CAUSE_SHIFTED, 1);
        }
    }
    if (status != RIGCAL_OK) {
        end(s, status);
    }
}

/* ---- all views of a camera ----------------------------------------------------- */

/* Replaces the pose of the target by the pose of the permuted target. The information
 * matrix moves to the origin of the permuted target. */
static void turn(rigcal_view_pose *own, const rigcal_transform *target_from_turned)
{
    const rigcal_transform before = own->cam_from_target;
    rigcal_real g[6] = {0}, W[36];
    rc_chain chain;
    rc_transform_compose(&own->cam_from_target, &before, target_from_turned);
    chain.R_c = before.R;
    rc_vec3_sub(chain.lever, before.t, own->cam_from_target.t);
    rc_chain_camera(g, own->information, W, &chain);
}

/* The claim of where the camera is that view v makes in this test. claim->view is -1 if
 * there is none: another camera's view, or the only view of its placement. */
static rigcal_status claim_camera(rc_claim *claim, const rigcal_cause_solver *s, size_t v)
{
    const int32_t shift = (s->test == LATE) ? -1 : (s->test == EARLY) ? 1 : 0;
    rigcal_view_pose own;
    rc_claim view, there;
    rigcal_status status = rc_rig_pose_at(&own, s->rig, v);
    claim->view = -1;
    if (status != RIGCAL_OK || own.camera != s->acting) {
        return status;
    }
    status = place_by_others(&there, s, own.placement + shift, own.camera, -1);
    if (s->test >= FIRST_PERMUTATION) {
        turn(&own, &s->target_from_turned);
    }
    if (status == RIGCAL_OK && there.view >= 0 &&
        rc_claim_of_view(&view, &own, own.sse, 0, 0)) {
        rc_claim_between(claim, &view, &there);
    }
    return status;
}

/* Counts the views that agree with where view s->view puts the camera. */
static rigcal_status score(int32_t *agree, int32_t *n, const rigcal_cause_solver *s)
{
    rc_claim by_view, by_other;
    rigcal_status status = claim_camera(&by_view, s, s->view);
    *agree = *n = 0;
    for (size_t v = 0; status == RIGCAL_OK && by_view.view >= 0 && v < s->rig->n_views;
         v++) {
        status = claim_camera(&by_other, s, v);
        if (status == RIGCAL_OK && by_other.view >= 0) {
            *n += 1;
            *agree += v == s->view || rc_claims_apart(&by_view, &by_other) < s->limit;
        }
    }
    return status;
}

/* Ends a test whose views were all scored. The test counts if most views agree, and more
 * than in the tests before. */
static void end_camera_test(rigcal_cause_solver *s)
{
    rigcal_cause *const found = &s->found;
    const size_t test = s->test++;
    const int is_most = s->agree > 1 && 2 * s->agree > s->checked;
    s->phase = TESTING;
    if (test == AS_IT_IS) {
        found->n_agree = s->agree;
        found->n_views = s->checked;
    } else if (is_most && found->cause == RIGCAL_CAUSE_SHIFTED && test == EARLY) {
        found->is_still = 1;
    }
    if (test != AS_IT_IS && is_most && s->agree > found->n_agree) {
        const int is_turn = test >= FIRST_PERMUTATION;
        found->cause = is_turn ? RIGCAL_CAUSE_TURNED : RIGCAL_CAUSE_SHIFTED;
        found->permutation = is_turn ? (int32_t)(test - FIRST_PERMUTATION) : -1;
        found->shift = (test == LATE) ? -1 : (test == EARLY) ? 1 : 0;
        found->n_agree = s->agree;
        found->n_views = s->checked;
    }
}

/* Scores one view: how many other views agree with where it puts the camera? */
static void score_view(rigcal_cause_solver *s)
{
    int32_t agree, n;
    const rigcal_status status = score(&agree, &n, s);
    if (status != RIGCAL_OK) {
        end(s, status);
        return;
    }
    if (agree > s->agree) {
        s->agree = agree;
        s->checked = n;
    }
    if (++s->view == s->rig->n_views) {
        end_camera_test(s);
    }
}

static void begin_scoring(rigcal_cause_solver *s)
{
    s->view = 0;
    s->agree = s->checked = 0;
    s->phase = SCORING;
}

/* Begins the next test of a camera. For a permutation it solves one view, which gives the
 * turn of the target by the permutation. */
static void test_camera(rigcal_cause_solver *s)
{
    const size_t row = s->test - FIRST_PERMUTATION;
    if (s->test < FIRST_PERMUTATION) {
        begin_scoring(s);
        return;
    }
    if (row >= n_permutations(s)) {
        end(s, RIGCAL_OK);
        return;
    }
    for (size_t v = 0; v < s->rig->n_views; v++) {
        rigcal_status status = rc_rig_pose_at(&s->own, s->rig, v);
        if (status == RIGCAL_OK && s->own.camera == s->acting) {
            status = rc_rig_view_at(&s->seen, s->rig, v);
            if (status == RIGCAL_OK && permute(s, row)) {
                begin_solving(s);
                break;
            }
        }
        if (status != RIGCAL_OK) {
            end(s, status);
            return;
        }
    }
    if (s->phase == TESTING) { /* no view can be permuted */
        s->test++;
    }
}

static void compare_camera(rigcal_cause_solver *s)
{
    rigcal_pose pose;
    size_t found;
    if (rigcal_pose_result(&pose, 1, &found, NULL, &s->pose) < 0) {
        s->test++;
        s->phase = TESTING;
        return;
    }
    rigcal_transform target_from_cam;
    rc_transform_invert(&target_from_cam, &s->own.cam_from_target);
    rc_transform_compose(&s->target_from_turned, &target_from_cam, &pose.cam_from_world);
    begin_scoring(s);
}

/* ---- the search ------------------------------------------------------------------ */

static rigcal_status check_symmetries(const rigcal_symmetries *sym)
{
    if (sym == NULL || sym->n_permutations == 0) {
        return RIGCAL_OK;
    }
    if (sym->permutations == NULL || sym->room == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (sym->n_points > RC_COUNT_MAX || sym->n_permutations > RC_COUNT_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    if (sym->n_points < 3) {
        return RIGCAL_ERR_TOO_FEW;
    }
    for (size_t row = 0; row < sym->n_permutations; row++) {
        const int32_t *const number = &sym->permutations[row * sym->n_points];
        for (size_t i = 0; i < sym->n_points; i++) {
            sym->room[i].uv[0] = 0;
        }
        for (size_t i = 0; i < sym->n_points; i++) { /* each point must occur once */
            if (number[i] < 0 || (size_t)number[i] >= sym->n_points ||
                sym->room[number[i]].uv[0] > 0) {
                return RIGCAL_ERR_RANGE;
            }
            sym->room[number[i]].uv[0] = 1;
        }
    }
    return RIGCAL_OK;
}

/* Checks the poses of all views, and the placements of those that are not left out. */
static rigcal_status check_views(const rigcal_rig *rig)
{
    int32_t before = 0;
    for (size_t v = 0; v < rig->n_views; v++) {
        rigcal_view_pose own;
        rc_sym6_factor L;
        rigcal_status status = rc_rig_pose_at(&own, rig, v);
        if (status == RIGCAL_OK) {
            status = rc_check_transform(&own.cam_from_target);
        }
        if (status == RIGCAL_OK) {
            status = rc_check_numbers(own.information, 21, RC_MAX);
        }
        if (status == RIGCAL_OK && !rc_sym6_factor_of(&L, own.information, 0)) {
            status = RIGCAL_ERR_DEGENERATE;
        }
        if (status == RIGCAL_OK && own.placement < before) {
            status = RIGCAL_ERR_UNSORTED;
        }
        if (status == RIGCAL_OK && !rc_rig_is_left_out(rig, v)) {
            status = rc_check_transform(&rig->rig_from_placements[own.placement]);
        }
        if (status != RIGCAL_OK) {
            return status;
        }
        before = own.placement;
    }
    return RIGCAL_OK;
}

/* Begins the tests of the view or camera `number`. */
static rigcal_status begin(rigcal_cause_solver *s, const rigcal_rig *rig,
                           rigcal_real limit_px2, const rigcal_symmetries *symmetries,
                           size_t number, int is_camera)
{
    if (s == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_rig_check(rig);
    if (status == RIGCAL_OK &&
        ((rig->views == NULL && rig->view_source == NULL) ||
         (rig->view_poses == NULL && rig->view_pose_source == NULL))) {
        status = RIGCAL_ERR_NULL;
    }
    if (status == RIGCAL_OK) {
        status = rc_check_numbers(&limit_px2, 1, RC_COORDINATE_MAX);
    }
    if (status == RIGCAL_OK &&
        (!(limit_px2 > 0) || number >= (is_camera ? rig->n_cameras : rig->n_views))) {
        status = RIGCAL_ERR_RANGE;
    }
    for (size_t c = 0; status == RIGCAL_OK && c < rig->n_cameras; c++) {
        status = rc_check_transform(&rig->cams_from_rig[c]);
    }
    if (status == RIGCAL_OK) {
        status = check_views(rig);
    }
    if (status == RIGCAL_OK) {
        status = check_symmetries(symmetries);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    *s = (rigcal_cause_solver){0};
    s->rig = rig;
    s->symmetries = symmetries;
    s->limit = limit_px2;
    s->is_camera = is_camera;
    s->found.permutation = s->found.camera = -1;
    s->phase = TESTING;
    s->view = number;
    s->acting = (int32_t)number;
    if (!is_camera) {
        status = rc_rig_pose_at(&s->own, rig, number);
        if (status == RIGCAL_OK) {
            status = first_of(&s->first, rig, s->own.placement);
        }
        if (status == RIGCAL_OK) {
            status = first_of(&s->last, rig, s->own.placement + 1);
        }
    }
    if (status != RIGCAL_OK) {
        s->phase = 0;
    }
    return status;
}

static void step(rigcal_cause_solver *s)
{
    if (s->phase == SOLVING) {
        if (rigcal_pose_step(&s->pose, 1) == RIGCAL_RUNNING) {
            return;
        }
        if (s->is_camera) {
            compare_camera(s);
        } else {
            compare_view(s);
        }
    } else if (s->phase == SCORING) {
        score_view(s);
    } else if (s->is_camera) {
        test_camera(s);
    } else {
        test_view(s);
    }
}

static rigcal_real limit_of(const rigcal_judgement *judgement)
{
    return RC_CHOOSE_LIMIT * judgement->scale * judgement->sigma_px * judgement->sigma_px;
}

rigcal_status rigcal_cause_begin(rigcal_cause_solver *solver, const rigcal_rig *rig,
                                 const rigcal_judgement *judgement,
                                 const rigcal_symmetries *symmetries, size_t view)
{
    return (judgement == NULL)
               ? RIGCAL_ERR_NULL
               : begin(solver, rig, limit_of(judgement), symmetries, view, 0);
}

rigcal_status rigcal_camera_cause_begin(rigcal_cause_solver *solver, const rigcal_rig *rig,
                                        const rigcal_judgement *judgement,
                                        const rigcal_symmetries *symmetries, size_t camera)
{
    return (judgement == NULL)
               ? RIGCAL_ERR_NULL
               : begin(solver, rig, limit_of(judgement), symmetries, camera, 1);
}

rigcal_status rigcal_cause_step(rigcal_cause_solver *solver, int32_t budget)
{
    const rigcal_status status =
        rc_check_step((solver == NULL) ? NULL : &solver->phase, budget);
    if (status != RIGCAL_OK) {
        return status;
    }
    for (; budget > 0 && solver->phase != DONE; budget--) {
        step(solver);
    }
    return (solver->phase == DONE) ? RIGCAL_OK : RIGCAL_RUNNING;
}

rigcal_status rigcal_cause_result(rigcal_cause *cause, const rigcal_cause_solver *solver)
{
    if (cause == NULL || solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (solver->phase != DONE) {
        return RIGCAL_ERR_STATE;
    }
    if (solver->status == RIGCAL_OK) {
        *cause = solver->found;
    }
    return solver->status;
}

static rigcal_status run(rigcal_cause *cause, rigcal_cause_solver *s, rigcal_status begun)
{
    if (begun != RIGCAL_OK || cause == NULL) {
        return (begun != RIGCAL_OK) ? begun : RIGCAL_ERR_NULL;
    }
    while (rigcal_cause_step(s, 100) == RIGCAL_RUNNING) {
    }
    return rigcal_cause_result(cause, s);
}

rigcal_status rigcal_rig_cause(rigcal_cause *cause, const rigcal_rig *rig,
                               const rigcal_judgement *judgement,
                               const rigcal_symmetries *symmetries, size_t view)
{
    rigcal_cause_solver s;
    return run(cause, &s, rigcal_cause_begin(&s, rig, judgement, symmetries, view));
}

rigcal_status rigcal_camera_cause(rigcal_cause *cause, const rigcal_rig *rig,
                                  const rigcal_judgement *judgement,
                                  const rigcal_symmetries *symmetries, size_t camera)
{
    rigcal_cause_solver s;
    return run(cause, &s,
               rigcal_camera_cause_begin(&s, rig, judgement, symmetries, camera));
}
