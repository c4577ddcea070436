/* join: all cameras and placements from the poses of the views, weighted by their
 * information. The truth: simulated rigs, and the bound of maximum likelihood. */
#include <math.h>
#include <string.h>

#include "rc_adjust.h"
#include "test_fit.h"
#include "test_rigs.h"

static test_rig r;

#define WANTS_RIG TEST_WANTS_RAM(sizeof(test_rig) + 12000)
#define TOL_ENTRY TOL(1e-12, 2e-5)
#define TOL_LENGTH TOL(1e-11, 2e-4)

static void assert_the_rest_is_untouched(void)
{
    for (size_t c = r.rig.n_cameras; c < RIG_CAMERAS_MAX; c++) {
        ASSERT_UNTOUCHED(r.cams[c]);
    }
    for (size_t f = r.rig.n_placements; f < RIG_PLACEMENTS_MAX; f++) {
        ASSERT_UNTOUCHED(r.places[f]);
    }
}

/* Starts with arrays full of other values, which must not matter. */
static rigcal_status join(void)
{
    int32_t at_fault = -2;
    rigcal_status status;

    FILL(r.cams);
    FILL(r.places);
    FILL(r.work);
    status = rigcal_rig_join(&r.rig, &at_fault);
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
    assert_the_rest_is_untouched();
    return status;
}

/* Gives the views their true poses. `strength` is the information on each number. */
static void give_true_poses(double strength)
{
    for (size_t v = 0; v < r.rig.n_views; v++) {
        static const int DIAGONAL[6] = {0, 3, 5, 15, 18, 20};

        memset(&r.own[v], 0, sizeof r.own[v]);
        r.own[v].camera = r.views[v].camera;
        r.own[v].placement = r.views[v].placement;
        r.own[v].n = 6;
        r.own[v].cam_from_target =
            test_rig_chain(&r, r.views[v].camera, r.views[v].placement);
        for (int k = 0; k < 6; k++) {
            r.own[v].information[DIAGONAL[k]] = RC(strength);
        }
    }
    r.rig.view_poses = r.own;
}

static void assert_joined(void)
{
    for (size_t c = 0; c < r.rig.n_cameras; c++) {
        ASSERT_TRANSFORM(&r.true_cams[c], &r.cams[c], TOL_ENTRY, TOL_LENGTH);
    }
}

static void test_exact_poses_give_the_rig(void)
{
    test_rng rng = test_seed(341);

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(60); trial++) {
        test_rig_random(&r, &rng, 1 + trial % 4, 1 + trial % 8, 6);
        test_rig_see_all(&r, &rng, 0);
        give_true_poses(100);
        ASSERT_STATUS(RIGCAL_OK, join());
        assert_joined();
        for (size_t f = 0; f < r.rig.n_placements; f++) {
            ASSERT_TRANSFORM(&r.true_places[f], &r.places[f], TOL_ENTRY, TOL_LENGTH);
        }
    }
}

/* Cameras c and c + 1 share only placement c. The order of the cameras is random. */
static void test_a_chain_of_neighbours_is_joined(void)
{
    test_rng rng = test_seed(342);

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(40); trial++) {
        int order[4] = {0, 1, 2, 3};

        test_rig_random(&r, &rng, 4, 3, 6);
        for (int i = 0; i < 4; i++) {
            const int k = (int)(test_next(&rng) % (uint64_t)(i + 1)), kept = order[i];

            order[i] = order[k];
            order[k] = kept;
        }
        for (int f = 0; f < 3; f++) {
            test_rig_see(&r, &rng, order[f], f, 0);
            test_rig_see(&r, &rng, order[f + 1], f, 0);
        }
        give_true_poses(100);
        ASSERT_STATUS(RIGCAL_OK, join());
        assert_joined();
    }
}

/* If no camera is held, the first camera of each group is the frame. */
static void test_each_group_has_a_frame_of_its_own(void)
{
    static const rigcal_transform ORIGIN = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    test_rng rng = test_seed(343);
    rigcal_transform back, expected;

    WANTS_RIG;
    test_rig_random(&r, &rng, 4, 2, 6);
    test_rig_see(&r, &rng, 0, 0, 0);
    test_rig_see(&r, &rng, 2, 0, 0);
    test_rig_see(&r, &rng, 3, 1, 0);
    test_rig_see(&r, &rng, 1, 1, 0);
    give_true_poses(100);
    ASSERT_STATUS(RIGCAL_DISCONNECTED, join());
    ASSERT_TRANSFORM(&ORIGIN, &r.cams[0], 0, 0);
    ASSERT_TRANSFORM(&ORIGIN, &r.cams[1], 0, 0);
    ASSERT_TRANSFORM(&r.true_cams[2], &r.cams[2], TOL_ENTRY, TOL_LENGTH);
    back = test_inverse(&r.true_cams[1]);
    expected = test_times(&r.true_cams[3], &back);
    ASSERT_TRANSFORM(&expected, &r.cams[3], TOL_ENTRY, TOL_LENGTH);
    expected = test_times(&r.true_cams[1], &r.true_places[1]);
    ASSERT_TRANSFORM(&expected, &r.places[1], TOL_ENTRY, TOL_LENGTH);
}

static void test_a_camera_that_is_held_stays_and_is_the_frame(void)
{
    test_rng rng = test_seed(344);
    rigcal_transform held;
    int32_t at_fault;

    WANTS_RIG;
    test_rig_random(&r, &rng, 3, 4, 6);
    test_rig_see_all(&r, &rng, 0);
    give_true_poses(100);
    r.roles[2] = RIGCAL_CAMERA_HELD;
    r.rig.roles = r.roles;
    memset(r.cams, 0, sizeof r.cams);
    held = r.cams[2] = r.true_cams[2];
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_join(&r.rig, &at_fault));
    TEST_ASSERT_EQUAL_MEMORY(&held, &r.cams[2], sizeof held);
    assert_joined();
    r.cams[2].R[0] = 5;
    at_fault = -2;
    ASSERT_STATUS(RIGCAL_ERR_ROTATION, rigcal_rig_join(&r.rig, &at_fault));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
}

/* A wrong view with almost no information does not move the rig. */
static void test_a_view_counts_by_its_information(void)
{
    static const double OFF[6] = {0.05, -0.03, 0.04, 0.1, 0.1, -0.1};
    test_rng rng = test_seed(345);

    WANTS_RIG;
    test_rig_random(&r, &rng, 2, 3, 6);
    test_rig_see_all(&r, &rng, 0);
    give_true_poses(1);
    r.own[3].cam_from_target = test_moved(&r.own[3].cam_from_target, OFF);
    for (int k = 0; k < 21; k++) {
        r.own[3].information[k] *= RC(1e-6);
    }
    ASSERT_STATUS(RIGCAL_OK, join());
    ASSERT_TRANSFORM(&r.true_cams[1], &r.cams[1], 2e-6, 3e-6);
}

/* Two views of two cameras. One is off by d, and one has three times the information.
 * Camera 1 must move as the harmonic sums of the informations say. */
static void test_two_placements_are_averaged_by_information(void)
{
    static const double OFF[6] = {0, 0, 0, 0.01, -0.02, 0.03};
    test_rng rng = test_seed(346);
    double d[6];

    WANTS_RIG;
    test_rig_random(&r, &rng, 2, 2, 6);
    test_rig_see_all(&r, &rng, 0);
    give_true_poses(1);
    /* Turns are known exactly, so only shifts are averaged. */
    for (int v = 0; v < 4; v++) {
        for (int k = 0; k < 6; k++) {
            static const int TURNS[3] = {0, 3, 5}, SHIFTS[3] = {15, 18, 20};

            if (k < 3) {
                r.own[v].information[TURNS[k]] = RC(1e6);
            } else {
                r.own[v].information[SHIFTS[k - 3]] = RC(v < 2 ? 3 : 1);
            }
        }
    }
    r.own[3].cam_from_target = test_moved(&r.own[3].cam_from_target, OFF);
    ASSERT_STATUS(RIGCAL_OK, join());
    test_step_between(d, &r.cams[1], &r.true_cams[1]);
    for (int k = 3; k < 6; k++) { /* 3 / 2 against 1 / 2 */
        ASSERT_NEAR(OFF[k] / 4, d[k], 2e-5);
    }
}

/* ---- steps --------------------------------------------------------------- */

static void test_the_budget_changes_no_bit(void)
{
    static const int32_t BUDGETS[] = {1, 2, 7, 1000};
    test_rng rng = test_seed(349);
    rigcal_transform cams[RIG_CAMERAS_MAX], places[RIG_PLACEMENTS_MAX];

    WANTS_RIG;
    test_rig_random(&r, &rng, 3, 4, 8);
    test_rig_see_all(&r, &rng, 0.3);
    test_rig_solve_views(&r);
    ASSERT_STATUS(RIGCAL_OK, join());
    memcpy(cams, r.cams, sizeof cams);
    memcpy(places, r.places, sizeof places);
    for (int k = 0; k < 4; k++) {
        rigcal_rig_solver solver;
        rigcal_rig_fit fit;

        memset(r.cams, 0, sizeof r.cams);
        memset(r.places, 0, sizeof r.places);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_join_begin(&solver, &r.rig));
        ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_rig_result(&fit, NULL, &solver));
        while (rigcal_rig_join_step(&solver, BUDGETS[k]) == RIGCAL_RUNNING) {
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_result(&fit, NULL, &solver));
        TEST_ASSERT_EQUAL_MEMORY(cams, r.cams, 3 * sizeof cams[0]);
        TEST_ASSERT_EQUAL_MEMORY(places, r.places, 4 * sizeof places[0]);
    }
}

/* To first order, the quadratic functions of the views replace their points. */
static void test_the_fit_is_that_of_the_adjustment(void)
{
    test_rng rng = test_seed(350);

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(20); trial++) {
        rigcal_rig_solver solver;
        rigcal_rig_fit joined, adjusted;

        test_rig_random(&r, &rng, 3, 5, 8);
        test_rig_see_all(&r, &rng, 0.3);
        test_rig_solve_views(&r);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_join_begin(&solver, &r.rig));
        while (rigcal_rig_join_step(&solver, 1000) == RIGCAL_RUNNING) {
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_result(&joined, NULL, &solver));
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&adjusted, NULL, &r.rig));
        ASSERT_NEAR(adjusted.sum, joined.sum, 0.03 * D(adjusted.sum));
        ASSERT_NEAR(adjusted.F, joined.F, 0.1 * D(adjusted.F));
        ASSERT_NEAR(adjusted.freedom, joined.freedom, 0);
        ASSERT_NEAR(adjusted.freedom_within, joined.freedom_within, 0);
        TEST_ASSERT_EQUAL_UINT64(adjusted.n_points, joined.n_points);
    }
}

/* ---- statistics ---------------------------------------------------------- */

/* The rms of the error over the bound, sqrt(chi square / 6), for camera 1. The covariance
 * is that of an adjustment at the truth of each rig. */
static double error_over_bound(test_rng *rng, int n_cameras, int n_placements, int rigs)
{
    double sum = 0;

    for (int trial = 0; trial < rigs; trial++) {
        rigcal_real Sigma[36];
        rigcal_rig_fit fit;
        rigcal_transform joined;
        int32_t at_fault;
        double d[6], full[36];

        test_rig_random(&r, rng, n_cameras, n_placements, 8);
        test_rig_see_all(&r, rng, 0.3);
        test_rig_solve_views(&r);
        ASSERT_STATUS(RIGCAL_OK, join());
        joined = r.cams[1];
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(Sigma, &r.rig, RC(0.3), 1));
        test_step_between(d, &joined, &r.true_cams[1]);
        test_to_double(full, Sigma, 36);
        sum += test_squared_distance(d, full, 6) / 6 / rigs;
    }
    return sqrt(sum);
}

static void test_two_cameras_come_near_the_bound(void)
{
    test_rng rng = test_seed(347);
    double ratio;

    TEST_ON_HOST_ONLY("the mean of many rigs");
    ratio = error_over_bound(&rng, 2, 6, 400);
    TEST_ASSERT_TRUE(ratio > 0.94 && ratio < 1.1);
}

static void test_more_cameras_come_near_the_bound(void)
{
    test_rng rng = test_seed(348);
    double ratio;

    TEST_ON_HOST_ONLY("the mean of many rigs");
    ratio = error_over_bound(&rng, 4, 6, 300);
    TEST_ASSERT_TRUE(ratio > 0.94 && ratio < 1.1);
}

/* ---- where the search starts ---------------------------------------------- */

static const double OFF_THE_TRUTH[6] = {0.02, -0.03, 0.01, 0.05, -0.04, 0.03};

/* Steps until the cameras and placements are those from which the search starts. Returns
 * the number of steps that looked at a view. */
static int join_to_start(rigcal_rig_solver *solver)
{
    int looks = 0;

    FILL(r.places);
    FILL(r.work);
    for (size_t c = 0; c < RIG_CAMERAS_MAX; c++) {
        if (r.rig.roles == NULL || r.rig.roles[c] != RIGCAL_CAMERA_HELD) {
            FILL(r.cams[c]);
        }
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_join_begin(solver, &r.rig));
    do {
        looks += solver->phase == RC_RIG_PLACING || solver->phase == RC_RIG_REACHING;
        ASSERT_STATUS(RIGCAL_RUNNING, rigcal_rig_join_step(solver, 1));
    } while (solver->phase == RC_RIG_CHECKING || solver->phase == RC_RIG_CHECKED ||
             solver->phase == RC_RIG_PLACING || solver->phase == RC_RIG_REACHING);
    assert_the_rest_is_untouched();
    return looks;
}

static void scale_information(size_t view, double by)
{
    for (int k = 0; k < 21; k++) {
        r.own[view].information[k] *= RC(by);
    }
}

/* Exact poses give the rig at once, so the adjustment that follows has nothing left to
 * do. Neither the scale of the information matters nor which camera is held. */
static void test_the_adjustment_starts_at_the_joined_cameras(void)
{
    static const double STRENGTHS[3] = {100, 0.01, 1e6};
    test_rng rng = test_seed(347);
    static rigcal_rig_solver solver;

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(12); trial++) {
        test_rig_random(&r, &rng, 4, 3, 6);
        if (trial % 2) { /* camera 1 or 3, and no camera is at the origin */
            r.true_cams[0] = test_moved(&r.true_cams[0], OFF_THE_TRUTH);
            r.roles[trial % 4] = RIGCAL_CAMERA_HELD;
            r.rig.roles = r.roles;
        }
        for (int f = 0; f < 3; f++) {
            test_rig_see(&r, &rng, f, f, 0);
            test_rig_see(&r, &rng, f + 1, f, 0);
        }
        give_true_poses(STRENGTHS[trial % 3]);
        (void)join_to_start(&solver);
        assert_joined();
    }
}

/* Placement 0 is seen by the held cameras 0 and 1, and by camera 2. One of the first two
 * views is wrong: camera 2 starts where the view of more information puts it, or of equal
 * ones the first. */
static void test_a_placement_starts_by_its_best_view(void)
{
    static const double BY[3] = {1, 0.5, 2};
    test_rng rng = test_seed(351);
    static rigcal_rig_solver solver;

    WANTS_RIG;
    for (int trial = 0; trial < 6; trial++) {
        const int wrong = trial % 2;
        const double by = BY[trial / 2];
        const int is_used = wrong ? by > 1 : by >= 1;
        double d[6];

        test_rig_random(&r, &rng, 3, 1, 6);
        test_rig_see_all(&r, &rng, 0);
        give_true_poses(4);
        scale_information((size_t)wrong, by);
        r.own[wrong].cam_from_target =
            test_moved(&r.own[wrong].cam_from_target, OFF_THE_TRUTH);
        r.roles[0] = r.roles[1] = RIGCAL_CAMERA_HELD;
        r.rig.roles = r.roles;
        (void)join_to_start(&solver);
        test_step_between(d, &r.cams[2], &r.true_cams[2]);
        TEST_ASSERT_EQUAL_INT(is_used, test_norm(d) > 0.01);
    }
}

/* Cameras 0 and 1 share two placements. Of one of them a view is wrong: camera 1 starts by
 * the placement whose two views say more together, or by the first of two that say as much.
 * 8 and 8 say 4 together, 5 and 15 say 3.75, and 4 and 100 say 100 / 26. */
static void test_a_camera_starts_by_the_best_way(void)
{
    static const struct {
        double information[4];
        int wrong, is_used; /* the placement */
    } CASES[6] = {{{8, 8, 8, 8}, 0, 1},   {{8, 8, 8, 8}, 1, 0},   {{8, 8, 5, 15}, 0, 1},
                  {{4, 100, 8, 8}, 1, 1}, {{4, 100, 8, 8}, 0, 0}, {{8, 8, 4, 100}, 1, 0}};
    test_rng rng = test_seed(352);
    static rigcal_rig_solver solver;

    WANTS_RIG;
    for (int trial = 0; trial < 6; trial++) {
        const int wrong = CASES[trial].wrong;
        double d[6];

        test_rig_random(&r, &rng, 2, 2, 6);
        test_rig_see_all(&r, &rng, 0);
        give_true_poses(1);
        for (size_t v = 0; v < 4; v++) {
            scale_information(v, CASES[trial].information[v]);
        }
        r.own[2 * wrong + 1].cam_from_target =
            test_moved(&r.own[2 * wrong + 1].cam_from_target, OFF_THE_TRUTH);
        (void)join_to_start(&solver);
        test_step_between(d, &r.cams[1], &r.true_cams[1]);
        TEST_ASSERT_EQUAL_INT(CASES[trial].is_used, test_norm(d) > 0.01);
    }
}

/* Nobody saw placements 0, 2, 3 and 5. Views that are left out say nothing. */
static void test_placements_that_nobody_saw_are_passed(void)
{
    static const int SEEN[6][2] = {{0, 1}, {1, 1}, {3, 1}, {1, 4}, {2, 4}, {3, 4}};
    static const uint8_t OUT[6] = {0, 0, 1, 0, 0, 0};
    test_rng rng = test_seed(353);
    static rigcal_rig_solver solver;

    WANTS_RIG;
    test_rig_random(&r, &rng, 4, 6, 6);
    for (int v = 0; v < 6; v++) {
        test_rig_see(&r, &rng, SEEN[v][0], SEEN[v][1], 0);
    }
    give_true_poses(100);
    memset(&r.own[2].cam_from_target, 0, sizeof r.own[2].cam_from_target);
    memset(r.own[2].information, 0, sizeof r.own[2].information);
    r.rig.left_out = OUT;
    (void)join_to_start(&solver);
    assert_joined();
    ASSERT_TRANSFORM(&r.true_places[1], &r.places[1], TOL_ENTRY, TOL_LENGTH);
    ASSERT_TRANSFORM(&r.true_places[4], &r.places[4], TOL_ENTRY, TOL_LENGTH);
    ASSERT_STATUS(RIGCAL_OK, join());
    assert_joined();
}

/* Placement 0 leads from camera 1 to camera 2, placement 1 from camera 0 to camera 1. In
 * the first round nothing places placement 0, so its views are looked at once. */
static void test_views_are_looked_at_only_where_they_lead(void)
{
    test_rng rng = test_seed(354);
    static rigcal_rig_solver solver;

    WANTS_RIG;
    test_rig_random(&r, &rng, 3, 2, 6);
    test_rig_see(&r, &rng, 1, 0, 0);
    test_rig_see(&r, &rng, 2, 0, 0);
    test_rig_see(&r, &rng, 0, 1, 0);
    test_rig_see(&r, &rng, 1, 1, 0);
    give_true_poses(100);
    TEST_ASSERT_EQUAL_INT((2 + 4) + (4 + 4) + (4 + 4), join_to_start(&solver));
    assert_joined();
}

/* ---- when it ends ---------------------------------------------------------- */

/* What a relative error of 4 epsilon in each number of a pose does to the sum: the turn
 * counts as a whole, the shift times the distance. */
static void test_what_is_negligible_is_rounding_of_the_poses(void)
{
    static const double TURNS[3] = {1, 2, 4}, SHIFTS[3] = {8, 16, 32};
    static const int AT[6] = {0, 3, 5, 15, 18, 20};
    test_rng rng = test_seed(355);
    static rigcal_rig_solver solver;
    double expected = 0;

    WANTS_RIG;
    test_rig_random(&r, &rng, 2, 2, 6);
    test_rig_see_all(&r, &rng, 0);
    give_true_poses(1);
    for (int v = 0; v < 4; v++) {
        const rigcal_real *const t = r.own[v].cam_from_target.t;
        const double epsilons = 4 * D(RC_EPS), scale = v + 1;
        const double far2 = D(t[0]) * D(t[0]) + D(t[1]) * D(t[1]) + D(t[2]) * D(t[2]);

        for (int k = 0; k < 21; k++) {
            r.own[v].information[k] = RC(0.001 * k);
        }
        for (int k = 0; k < 3; k++) {
            r.own[v].information[AT[k]] = RC(scale * TURNS[k]);
            r.own[v].information[AT[3 + k]] = RC(scale * SHIFTS[k]);
            expected += epsilons * epsilons * scale * (TURNS[k] + SHIFTS[k] * far2);
        }
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_join_begin(&solver, &r.rig));
    while (solver.phase == RC_RIG_CHECKING) {
        ASSERT_STATUS(RIGCAL_RUNNING, rigcal_rig_join_step(&solver, 1));
    }
    ASSERT_NEAR(1, D(solver.negligible) / expected, TOL(1e-12, 1e-5));
}

/* ---- sources ---------------------------------------------------------------- */

static size_t calls, fails_at, failed;

static rigcal_status pose_that_fails(rigcal_view_pose *pose, size_t index, void *context)
{
    (void)context;
    *pose = r.own[index];
    if (++calls == fails_at) {
        failed = index;
        return RIGCAL_ERR_DAMAGED;
    }
    return RIGCAL_OK;
}

static void test_a_source_that_fails_ends_the_join(void)
{
    test_rng rng = test_seed(356);
    size_t n;

    WANTS_RIG;
    test_rig_random(&r, &rng, 3, 2, 6);
    test_rig_see_all(&r, &rng, 0);
    give_true_poses(100);
    r.rig.view_poses = NULL;
    r.rig.view_pose_source = pose_that_fails;
    calls = fails_at = 0;
    ASSERT_STATUS(RIGCAL_OK, join());
    assert_joined();
    n = calls;
    r.rig.view_pose_source = NULL;
    ASSERT_STATUS(RIGCAL_ERR_NULL, join());
    r.rig.view_pose_source = pose_that_fails;
    for (fails_at = 1; fails_at <= n; fails_at++) {
        int32_t at_fault = -2;

        calls = 0;
        ASSERT_STATUS(RIGCAL_ERR_DAMAGED, rigcal_rig_join(&r.rig, &at_fault));
        TEST_ASSERT_EQUAL_size_t(fails_at, calls);
        TEST_ASSERT_EQUAL_INT32((int32_t)failed, at_fault);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_exact_poses_give_the_rig);
    RUN_TEST(test_a_chain_of_neighbours_is_joined);
    RUN_TEST(test_each_group_has_a_frame_of_its_own);
    RUN_TEST(test_a_camera_that_is_held_stays_and_is_the_frame);
    RUN_TEST(test_a_view_counts_by_its_information);
    RUN_TEST(test_two_placements_are_averaged_by_information);
    RUN_TEST(test_the_budget_changes_no_bit);
    RUN_TEST(test_the_fit_is_that_of_the_adjustment);
    RUN_TEST(test_two_cameras_come_near_the_bound);
    RUN_TEST(test_more_cameras_come_near_the_bound);
    RUN_TEST(test_the_adjustment_starts_at_the_joined_cameras);
    RUN_TEST(test_a_placement_starts_by_its_best_view);
    RUN_TEST(test_a_camera_starts_by_the_best_way);
    RUN_TEST(test_placements_that_nobody_saw_are_passed);
    RUN_TEST(test_views_are_looked_at_only_where_they_lead);
    RUN_TEST(test_what_is_negligible_is_rounding_of_the_poses);
    RUN_TEST(test_a_source_that_fails_ends_the_join);
}
