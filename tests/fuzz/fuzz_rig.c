/* The join, the graph, the choice, the judgement and its causes, with any views. */
#include <math.h>
#include <string.h>

#include "fuzz_rigs.h"

static void check_graph(fuzz_rig *made)
{
    rigcal_rig *rig = &made->rig;
    rigcal_link links[RIGCAL_LINKS(RIG_CAMERAS)];
    rigcal_advice advice[RIG_CAMERAS];
    rigcal_status status;
    int32_t n_groups, at_fault;
    size_t n;

    MARK(links);
    MARK(n_groups);
    status = rigcal_rig_links(links, RIGCAL_LINKS(RIG_CAMERAS), &n_groups, &at_fault, rig);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, links);
    PROMISE_UNTOUCHED(status, n_groups);
    if (status < 0) {
        return;
    }
    PROMISE(n_groups >= 1 && n_groups <= (int32_t)rig->n_cameras);
    MARK(advice);
    status = rigcal_rig_advise(advice, RIG_CAMERAS, &n, links, rig);
    PROMISE(fuzz_is_status(status));
    PROMISE(status < 0 || (int32_t)n == n_groups - 1);
}

static void check_join(fuzz_rig *made, fuzz_budget budget)
{
    rigcal_rig *rig = &made->rig;
    rigcal_transform cams[RIG_CAMERAS], placements[RIG_PLACEMENTS];
    rigcal_rig_solver solver;
    rigcal_rig_fit fit;
    rigcal_status status = rigcal_rig_join(rig, NULL), stepped;
    int32_t at_fault;

    PROMISE(fuzz_is_status(status) && status != RIGCAL_RUNNING);
    if (status < 0) {
        return;
    }
    fuzz_rig_check(rig);
    memcpy(cams, made->cams_from_rig, sizeof cams);
    memcpy(placements, made->rig_from_placements, sizeof placements);
    stepped = rigcal_rig_join_begin(&solver, rig);
    PROMISE(stepped >= 0);
    do {
        stepped = rigcal_rig_join_step(&solver, fuzz_budget_next(&budget));
    } while (stepped == RIGCAL_RUNNING);
    PROMISE(rigcal_rig_result(&fit, &at_fault, &solver) == status);
    PROMISE(memcmp(cams, made->cams_from_rig, sizeof cams) == 0);
    PROMISE(memcmp(placements, made->rig_from_placements, sizeof placements) == 0);
}

static void check_causes(const rigcal_rig *rig, const rigcal_judgement *judgement)
{
    static const int32_t REVERSED[RIG_POINTS] = {5, 4, 3, 2, 1, 0};
    rigcal_observation room[RIG_POINTS];
    rigcal_symmetries symmetries;
    rigcal_status status;
    rigcal_cause cause;
    size_t i;

    symmetries.permutations = REVERSED;
    symmetries.n_permutations = 1;
    symmetries.n_points = RIG_POINTS;
    symmetries.room = room;
    for (i = 0; i < rig->n_views && i < 3; i++) {
        MARK(cause);
        status = rigcal_rig_cause(&cause, rig, judgement, &symmetries, i);
        PROMISE(fuzz_is_status(status));
        PROMISE_UNTOUCHED(status, cause);
        PROMISE(status < 0 || (cause.cause >= RIGCAL_CAUSE_UNKNOWN &&
                               cause.cause <= RIGCAL_CAUSE_SWAPPED));
    }
    MARK(cause);
    status = rigcal_camera_cause(&cause, rig, judgement, NULL, rig->n_cameras - 1);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, cause);
}

static void check_judgement(fuzz_rig *made, fuzz_bytes *bytes, fuzz_budget budget)
{
    static fuzz_rig other;
    rigcal_rig *rig = &made->rig;
    rigcal_judged_view judged[RIG_VIEWS];
    uint8_t takes[RIG_VIEWS] = {0}, left_out[RIG_VIEWS] = {0};
    rigcal_choice choice;
    rigcal_choose_solver solver;
    rigcal_judgement judgement;
    rigcal_status status, stepped;
    int32_t at_fault, counted;
    size_t i;

    memset(&choice, 0, sizeof choice);
    choice.second_poses = made->second_poses;
    choice.takes = takes;
    if (fuzz_below(bytes, 2) == 1) {
        rig->sigma_px = fuzz_real(bytes);
    }
    other = *made;
    status = rigcal_rig_choose(&choice, &at_fault, rig);
    PROMISE(fuzz_is_status(status) && status != RIGCAL_RUNNING);
    PROMISE(at_fault >= -1 && at_fault < (int32_t)rig->n_views);
    if (status < 0) {
        return;
    }
    fuzz_rig_check(rig);
    PROMISE(choice.sigma_px > 0 && choice.share >= 0 && choice.share <= 1);
    for (i = 0; i < rig->n_views; i++) {
        PROMISE(takes[i] <= RIGCAL_TAKES_NONE);
    }
    /* The same in steps must change the rig in the same way. */
    memcpy(made->cams_from_rig, other.cams_from_rig, sizeof other.cams_from_rig);
    memcpy(other.cams_from_rig, rig->cams_from_rig, sizeof other.cams_from_rig);
    stepped = rigcal_choose_begin(&solver, &choice, rig);
    PROMISE(stepped >= 0);
    do {
        stepped = rigcal_choose_step(&solver, fuzz_budget_next(&budget));
    } while (stepped == RIGCAL_RUNNING);
    PROMISE(rigcal_choose_result(&at_fault, &solver) == status);

    MARK(judgement);
    MARK(judged);
    status = rigcal_rig_judge(&judgement, &at_fault, judged, left_out, &choice, rig);
    PROMISE(fuzz_is_status(status) && status != RIGCAL_RUNNING);
    PROMISE_UNTOUCHED(status, judgement);
    if (status < 0) {
        return;
    }
    fuzz_rig_check(rig);
    counted = judgement.n_fit + judgement.n_contradict + judgement.n_one_of_two +
              judgement.n_unchecked;
    PROMISE(counted == (int32_t)rig->n_views);
    PROMISE(judgement.adjustments >= 1 && judgement.adjustments <= 6);
    for (i = 0; i < rig->n_views; i++) {
        PROMISE(judged[i].verdict >= 0 && judged[i].verdict <= RIGCAL_VIEW_UNCHECKED);
        PROMISE(left_out[i] <= 1 && fuzz_all_finite(&judged[i].cost, 1));
    }
    check_causes(rig, &judgement);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static fuzz_rig made;
    fuzz_bytes bytes = {data, data + size};
    const int kind = fuzz_below(&bytes, 3);
    const fuzz_budget budget = fuzz_budget_of(&bytes);

    if (!fuzz_rig_read(&made, &bytes)) {
        return 0;
    }
    switch (kind) {
    case 0:
        check_graph(&made);
        check_join(&made, budget);
        break;
    default:
        check_judgement(&made, &bytes, budget);
        break;
    }
    return 0;
}
