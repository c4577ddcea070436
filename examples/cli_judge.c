/* Which pose each view has, and which views are wrong. */
#include "cli_calibrate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ==== the library, in steps =============================================== */

static rigcal_status choose_in_steps(calibration *c, int32_t *at_fault)
{
    const int32_t budget = (int32_t)c->rig.n_views;
    rigcal_choose_solver solver;
    rigcal_status status = rigcal_choose_begin(&solver, &c->choice, &c->rig);
    unsigned long step = 0;

    if (status != RIGCAL_OK) {
        return status;
    }
    do {
        cli_progress(c->rig.n_views, "choosing the poses of %lu views, step %lu",
                     (unsigned long)c->rig.n_views, ++step);
        status = rigcal_choose_step(&solver, budget);
    } while (status == RIGCAL_RUNNING);
    return rigcal_choose_result(at_fault, &solver);
}

static rigcal_status judge_in_steps(calibration *c, uint8_t left_out[], int32_t *at_fault)
{
    const int32_t budget = (int32_t)c->rig.n_views;
    rigcal_judge_solver solver;
    rigcal_status status =
        rigcal_judge_begin(&solver, c->judged, left_out, &c->choice, &c->rig);
    unsigned long step = 0;

    if (status != RIGCAL_OK) {
        return status;
    }
    do {
        cli_progress(c->rig.n_views, "adjusting the rig of %lu views, step %lu",
                     (unsigned long)c->rig.n_views, ++step);
        status = rigcal_judge_step(&solver, budget);
    } while (status == RIGCAL_RUNNING);
    return rigcal_judge_result(&c->judgement, at_fault, &solver);
}

/* ==== the choice ========================================================== */

/* Without --sigma, and if all views have three points, the data do not show the noise. It
 * is then taken as one pixel. */
static rigcal_status choose_poses(calibration *c, int32_t *at_fault)
{
    rigcal_status status = choose_in_steps(c, at_fault);

    if (status == RIGCAL_ERR_TOO_FEW && !(c->rig.sigma_px > 0)) {
        c->rig.sigma_px = 1;
        status = choose_in_steps(c, at_fault);
        c->rig.sigma_px = 0;
    }
    return status;
}

/* ==== what follows ======================================================== */

/* Whether the camera of this view has another view that is checked. */
static int has_another(const calibration *c, const view *v)
{
    const view *other;
    const view *end = views_of(&other, c, v->camera);

    for (; other < end; other++) {
        if (other != v && other->verdict == RIGCAL_VIEW_FITS) {
            return 1;
        }
    }
    return 0;
}

void note_verdicts(calibration *c)
{
    size_t i;

    for (i = 0; i < c->rig.n_views; i++) {
        view *v = rig_view(c, i);

        v->verdict = (int8_t)c->judged[i].verdict;
        v->is_left_out =
            v->verdict == RIGCAL_VIEW_CONTRADICTS || v->verdict == RIGCAL_VIEW_ONE_OF_TWO;
        v->in_rig = !v->is_left_out;
        c->n_left_out += (size_t)v->is_left_out;
        if (c->choice.takes[i] == RIGCAL_TAKES_SECOND) {
            view_take(c, v, 1);
        }
    }
    cli_free(c->judged);
    c->judged = NULL;
    for (i = 0; i < c->n_views; i++) {
        view *v = &c->views[i];

        v->settled = v->status == RIGCAL_AMBIGUOUS && v->verdict == RIGCAL_VIEW_FITS &&
                     has_another(c, v);
    }
}

/* The first camera that still has a view. */
static size_t first_camera(const calibration *c)
{
    size_t first = c->rig.n_cameras, i;

    for (i = 0; i < c->rig.n_views; i++) {
        const view *v = rig_view(c, i);

        if (v->in_rig && v->rig_camera < first) {
            first = v->rig_camera;
        }
    }
    return first;
}

/* Makes the pose of the first camera of each group exact, to the last digit. */
static void make_exact(const calibration *c)
{
    static const rigcal_transform IDENTITY = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    size_t i, k;

    for (i = 0; i < c->rig.n_cameras && c->rig.roles == NULL; i++) {
        for (k = 0; k < i && c->rig.group[k] != c->rig.group[i]; k++) {
        }
        if (k == i) {
            c->rig.cams_from_rig[i] = IDENTITY;
        }
    }
}

/* Gives the rig the frame of another camera, because the camera whose frame it has lost its
 * last view. */
static rigcal_status change_frame(calibration *c, size_t main_camera, int32_t *at_fault)
{
    rigcal_rig *rig = &c->rig;
    const rigcal_transform main_from_rig = rig->cams_from_rig[main_camera];
    size_t i;

    for (i = 0; i < rig->n_cameras; i++) {
        const rigcal_transform was = rig->cams_from_rig[i];

        rigcal_transform_between(&rig->cams_from_rig[i], &was, &main_from_rig);
    }
    for (i = 0; i < rig->n_placements; i++) {
        rigcal_transform moved;

        if (rigcal_transform_compose(&moved, &main_from_rig,
                                     &rig->rig_from_placements[i]) >= 0) {
            rig->rig_from_placements[i] = moved;
        }
    }
    c->main_camera = main_camera;
    make_exact(c);
    return rigcal_rig_adjust(&c->judgement.fit, at_fault, rig);
}

/* If the adjustment fails, the poses are chosen again, so that the rig is that of the
 * choice. A copy of a million placements would take too much memory. */
static int judge_views(calibration *c)
{
    rigcal_rig *rig = &c->rig;
    uint8_t *left_out = cli_alloc(rig->n_views, sizeof *left_out);
    int32_t at_fault = -1;
    rigcal_status status;

    status = judge_in_steps(c, left_out, &at_fault);
    if (status >= 0) {
        note_verdicts(c);
        if (c->rig.roles == NULL && first_camera(c) != c->main_camera) {
            status = change_frame(c, first_camera(c), &at_fault);
        }
    }
    if (status == RIGCAL_ERR_TOO_FEW) {
        rig->left_out = NULL;
        return 0;
    }
    if (status < 0) {
        name_rig_trouble(c, "the rig is joined but not adjusted,", status, at_fault);
        rig->left_out = NULL;
        choose_poses(c, &at_fault);
        make_exact(c);
        return 1;
    }
    if (status != RIGCAL_OK && status != RIGCAL_DISCONNECTED &&
        status != RIGCAL_VIEWS_LEFT_OUT) {
        name_rig_trouble(c, "the rig", status, -1);
    }
    c->fit = c->judgement.fit;
    c->is_adjusted = 1;
    find_causes(c);
    return 1;
}

int judge_rig(calibration *c)
{
    int32_t at_fault = -1;
    rigcal_status status;
    size_t i;

    for (i = 0; i < c->n_views; i++) {
        c->views[i].verdict = -1;
    }
    c->choice.second_source = second_pose_at;
    if (c->judged == NULL) {
        c->choice.takes = cli_alloc(c->n_views, sizeof *c->choice.takes);
        c->judged = cli_alloc(c->n_views, sizeof *c->judged);
    }
    status = choose_poses(c, &at_fault);
    if (status == RIGCAL_ERR_CONTRADICTION) {
        find_contradiction(c);
        return 0;
    }
    if (status < 0) {
        name_rig_trouble(c, "the cameras cannot be joined", status, at_fault);
        return 0;
    }
    make_exact(c);
    give_times(c);
    switch (test_all_views(c)) {
    case TEST_EXPLAINS:
        return 1;
    case TEST_PAIRS_ANEW:
        return RIG_PAIRED_ANEW;
    default:
        break;
    }
    if (!judge_views(c)) {
        find_contradiction(c);
        return 0;
    }
    test_rig(c);
    return 1;
}
