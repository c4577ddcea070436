/* Sources of views that fail, or that give something else the second time: for every
 * function that reads views, and each of its calls. The status of a source must be
 * returned. A number from a source must be checked before it is used as an index. */
#include <string.h>

#include "rigcal_solvers.h"
#include "test_boards.h"

enum { CAMERAS = 4, PLACES = 6, SEEN = 3, VIEWS = PLACES * SEEN, WRONG = 7 };

/* What a source does at call number `at`. */
enum {
    FAILS,
    CAMERA_BELOW,
    CAMERA_BEYOND,
    CAMERA_OTHER,
    PLACEMENT_BELOW,
    PLACEMENT_BEYOND,
    PLACEMENT_OTHER,
    NO_POINTS,
    NO_NUMBER,
    NO_INFORMATION,
    AT_INFINITY,
    TOO_MANY,
    WAYS
};

static struct {
    size_t calls, at;
    int way;
} source;

static test_boards b, before;
static rigcal_view_pose second[VIEWS];
static rigcal_observation changed[BOARD_POINTS], room[BOARD_POINTS];
static int32_t turned[BOARD_POINTS];
static const rigcal_symmetries symmetries = {turned, 1, BOARD_POINTS, room};
static rigcal_rig_clocks clocks;
static rigcal_real times[PLACES], instants[PLACES], offsets[CAMERAS];
static int32_t states[CAMERAS];
static rigcal_real
    memory[RIGCAL_FAULTS_WORK(CAMERAS, CAMERAS) + RIGCAL_FAULTS_CLOCKS_WORK(CAMERAS) +
           RIGCAL_ESTIMATE_WORK(CAMERAS, CAMERAS) + RIGCAL_CONSIDER_CLOCKS_WORK(CAMERAS)];
static rigcal_intrinsics_sigma sigmas[CAMERAS];

static int is_now(void)
{
    return ++source.calls == source.at;
}

static void change_place(int32_t *camera, int32_t *placement)
{
    switch (source.way) {
    case CAMERA_BELOW:
        *camera = -1;
        break;
    case CAMERA_BEYOND:
        *camera = CAMERAS;
        break;
    case CAMERA_OTHER:
        *camera = (*camera + 1) % CAMERAS;
        break;
    case PLACEMENT_BELOW:
        *placement = -1;
        break;
    case PLACEMENT_BEYOND:
        *placement = PLACES;
        break;
    case PLACEMENT_OTHER:
        *placement = (*placement + 1) % PLACES;
        break;
    default:
        break;
    }
}

static rigcal_status next_view(rigcal_rig_view *view, size_t index, void *context)
{
    (void)context;
    *view = b.views[index];
    if (!is_now()) {
        return RIGCAL_OK;
    }
    change_place(&view->camera, &view->placement);
    memcpy(changed, view->view.observations, sizeof changed);
    if (source.way == NO_NUMBER) {
        changed[3].uv[0] = TEST_NAN;
    } else if (source.way == AT_INFINITY) {
        changed[3].uv[0] = changed[5].uv[1] = RC(1e7);
    } else if (source.way == NO_INFORMATION) { /* all points in one */
        for (int i = 0; i < BOARD_POINTS; i++) {
            changed[i] = changed[0];
        }
    }
    view->view.observations = changed;
    view->view.n = (source.way == NO_POINTS) ? 0 : view->view.n;
    return (source.way == FAILS) ? RIGCAL_ERR_DAMAGED : RIGCAL_OK;
}

static rigcal_status change_pose(rigcal_view_pose *pose)
{
    if (!is_now()) {
        return RIGCAL_OK;
    }
    change_place(&pose->camera, &pose->placement);
    if (source.way == NO_NUMBER) {
        pose->sse = TEST_NAN;
    } else if (source.way == AT_INFINITY) {
        pose->cam_from_target.t[1] = RC(1e8);
    } else if (source.way == NO_INFORMATION) {
        memset(pose->information, 0, sizeof pose->information);
    } else if (source.way == NO_POINTS) {
        pose->n = 0;
    } else if (source.way == TOO_MANY) {
        pose->n = SIZE_MAX;
    }
    return (source.way == FAILS) ? RIGCAL_ERR_DAMAGED : RIGCAL_OK;
}

static rigcal_status next_pose(rigcal_view_pose *pose, size_t index, void *context)
{
    (void)context;
    *pose = b.own[index];
    return change_pose(pose);
}

static rigcal_status next_second(rigcal_view_pose *pose, size_t index, void *context)
{
    (void)context;
    *pose = second[index];
    return change_pose(pose);
}

/* ---- what reads views -------------------------------------------------------- */

static int32_t at_fault;

static rigcal_status joins(void)
{
    return rigcal_rig_join(&b.rig, &at_fault);
}

static rigcal_status adjusts(void)
{
    rigcal_rig_fit fit;

    return rigcal_rig_adjust(&fit, &at_fault, &b.rig);
}

static rigcal_status adjusts_robustly(void)
{
    rigcal_rig_fit fit;
    size_t n_wrong;

    return rigcal_rig_adjust_robust(&fit, &n_wrong, &at_fault, &b.rig);
}

static rigcal_status chooses(void)
{
    return rigcal_rig_choose(&b.choice, &at_fault, &b.rig);
}

static rigcal_status judges(void)
{
    return rigcal_rig_judge(&b.judgement, &at_fault, b.judged, b.left_out, &b.choice,
                            &b.rig);
}

static rigcal_status tells_the_cause(void)
{
    rigcal_cause cause;

    return rigcal_rig_cause(&cause, &b.rig, &b.judgement, &symmetries, WRONG);
}

static rigcal_status tells_the_cause_of_a_camera(void)
{
    rigcal_cause cause;

    return rigcal_camera_cause(&cause, &b.rig, &b.judgement, &symmetries,
                               (size_t)b.views[WRONG].camera);
}

static rigcal_status links(void)
{
    rigcal_link found[RIGCAL_LINKS(CAMERAS)];
    int32_t n_groups;

    return rigcal_rig_links(found, RIGCAL_LINKS(CAMERAS), &n_groups, &at_fault, &b.rig);
}

static rigcal_status tells_the_noise(void)
{
    rigcal_real sigma_px[CAMERAS], freedom[CAMERAS];

    return rigcal_rig_noise(sigma_px, freedom, &b.rig);
}

static rigcal_status tells_a_placement(void)
{
    rigcal_real Sigma[36];

    return rigcal_rig_placement(Sigma, &b.rig, RC(0.3), 2);
}

static rigcal_status tells_residuals(void)
{
    rigcal_real duv[2 * BOARD_POINTS];
    size_t n;

    return rigcal_rig_residuals(duv, 2 * BOARD_POINTS, &n, &b.rig, 5);
}

static rigcal_status considers(void)
{
    rigcal_considered considered = {0};

    considered.effects = memory;
    considered.capacity = sizeof memory / sizeof *memory;
    const rigcal_status status = rigcal_rig_consider(&considered, &at_fault, &b.rig);
    b.rig.considered = NULL;
    return status;
}

static rigcal_status estimates(void)
{
    static const rigcal_intrinsics_change MADE[CAMERAS];
    rigcal_intrinsics_change change[CAMERAS], sigma[CAMERAS];
    rigcal_estimated estimated = {0};

    estimated.considered.effects = memory;
    estimated.considered.capacity = sizeof memory / sizeof *memory;
    estimated.made = MADE;
    estimated.change = change;
    estimated.sigma = sigma;
    const rigcal_status status =
        rigcal_rig_estimate(&estimated, &at_fault, &b.rig, RC(0.3));
    b.rig.considered = NULL;
    return status;
}

static rigcal_status finds_faults(void)
{
    rigcal_fault faults[20];
    rigcal_faults found;
    rigcal_faults_options options = {0};

    options.work = memory;
    options.work_capacity = sizeof memory / sizeof *memory;
    return rigcal_rig_faults(&found, faults, 20, &at_fault, &options, &b.rig);
}

/* ---- the trial of each --------------------------------------------------------- */

/* The view WRONG is turned and has a second pose. is_adjusted: the rig was adjusted without
 * that view. */
static void make(int seen, int is_adjusted, int has_clocks)
{
    test_rng rng = test_seed(4000);
    rigcal_rig_fit fit;

    for (int32_t i = 0; i < BOARD_POINTS; i++) {
        turned[i] = BOARD_POINTS - 1 - i;
    }
    test_boards_make(&b, &rng, CAMERAS, PLACES, seen, 0.3, 0);
    test_boards_solve(&b);
    memset(second, 0, sizeof second);
    second[WRONG] = b.own[WRONG];
    test_boards_reverse(&b, WRONG);
    test_boards_solve_view(&b, WRONG);
    test_boards_join(&b, 0.3);
    b.rig.sigma_px = b.choice.sigma_px = RC(0.3);
    b.judgement.sigma_px = RC(0.3);
    b.judgement.scale = 1;
    ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_defaults(&clocks));
    for (int f = 0; f < PLACES; f++) {
        times[f] = RC(f);
    }
    memset(offsets, 0, sizeof offsets);
    clocks.times = times;
    clocks.instants = instants;
    clocks.offsets = offsets;
    clocks.states = states;
    if (is_adjusted) {
        b.left_out[WRONG] = 1;
        b.rig.left_out = b.left_out;
        b.rig.clocks = has_clocks ? &clocks : NULL;
        TEST_ASSERT_TRUE(rigcal_rig_adjust(&fit, &at_fault, &b.rig) >= 0);
    }
    for (int c = 0; c < CAMERAS; c++) {
        sigmas[c] = (rigcal_intrinsics_sigma){RC(1e-3), RC(1e-4), RC(1), 0, 0};
    }
    b.rig.intrinsics_sigmas = sigmas;
    b.rig.views = NULL;
    b.rig.view_poses = NULL;
    b.rig.view_source = next_view;
    b.rig.view_pose_source = next_pose;
    before = b;
}

/* Calls `function` again and again. In each run another one of its calls to a source goes
 * wrong; if there are many calls, only some. */
static void try_all(rigcal_status (*function)(void))
{
    size_t n;

    source.at = 0;
    source.calls = 0;
    TEST_ASSERT_TRUE(function() >= 0);
    n = source.calls;
    TEST_ASSERT_TRUE(n > 0);
    for (source.way = 0; source.way < WAYS; source.way++) {
        const size_t stride = 1 + TEST_ONE_IN * n / ((source.way == FAILS) ? 300 : 40);

        for (source.at = 1; source.at <= n;
             source.at += (source.at * TEST_ONE_IN < 40) ? 1 : stride) {
            b = before;
            source.calls = 0;
            at_fault = -2;
            const rigcal_status status = function();

            TEST_ASSERT_TRUE(at_fault >= -2 && at_fault < VIEWS);
            if (source.way == FAILS) {
                ASSERT_STATUS(RIGCAL_ERR_DAMAGED, status);
                TEST_ASSERT_TRUE(source.calls <= source.at + 1);
            } else {
                TEST_ASSERT_TRUE(rigcal_status_name(status) != NULL);
            }
        }
    }
    b = before;
}

static void test_sources_of_a_join_and_a_choice(void)
{
    TEST_ON_HOST_ONLY("thousands of searches");
    make(SEEN, 0, 0);
    try_all(links);
    try_all(joins);
    before.choice.second_source = b.choice.second_source = next_second;
    try_all(chooses);
}

static void test_sources_of_an_adjustment(void)
{
    TEST_ON_HOST_ONLY("thousands of searches");
    make(SEEN, 0, 0);
    before.rig.left_out = b.rig.left_out = b.left_out;
    before.left_out[WRONG] = b.left_out[WRONG] = 1;
    try_all(adjusts);
    try_all(adjusts_robustly);
}

static void test_sources_of_a_judgement(void)
{
    TEST_ON_HOST_ONLY("thousands of searches");
    make(SEEN, 0, 0);
    before.choice.second_source = b.choice.second_source = next_second;
    before.choice.takes[WRONG] = b.choice.takes[WRONG] = RIGCAL_TAKES_SECOND;
    try_all(judges);
    make(2, 0, 0); /* two views disagree, so none is left */
    try_all(judges);
}

static void test_sources_of_a_cause(void)
{
    TEST_ON_HOST_ONLY("thousands of searches");
    make(SEEN, 1, 0);
    before.left_out[WRONG + 1] = b.left_out[WRONG + 1] = 1; /* of the same placement */
    try_all(tells_the_cause);
    try_all(tells_the_cause_of_a_camera);
}

static void test_sources_after_an_adjustment(void)
{
    TEST_ON_HOST_ONLY("thousands of searches");
    make(SEEN, 1, 0);
    try_all(tells_the_noise);
    try_all(tells_a_placement);
    try_all(tells_residuals);
    try_all(considers);
    try_all(estimates);
    try_all(finds_faults);
}

static void test_sources_of_a_rig_with_clocks(void)
{
    TEST_ON_HOST_ONLY("thousands of searches");
    make(SEEN, 1, 1);
    try_all(considers);
    try_all(finds_faults);
    try_all(adjusts);
}

TEST_MAIN()
{
    RUN_TEST(test_sources_of_a_join_and_a_choice);
    RUN_TEST(test_sources_of_an_adjustment);
    RUN_TEST(test_sources_of_a_judgement);
    RUN_TEST(test_sources_of_a_cause);
    RUN_TEST(test_sources_after_an_adjustment);
    RUN_TEST(test_sources_of_a_rig_with_clocks);
}
