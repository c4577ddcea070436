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

/* Starts with arrays full of other values, which must not matter. */
static rigcal_status join(void)
{
    int32_t at_fault = -2;
    rigcal_status status;

    memset(r.cams, 0, sizeof r.cams);
    memset(r.places, 0, sizeof r.places);
    status = rigcal_rig_join(&r.rig, &at_fault);
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
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
    ASSERT_STATUS(RIGCAL_ERR_ROTATION, rigcal_rig_join(&r.rig, &at_fault));
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

/* Exact poses give the rig at once, so the adjustment that follows has nothing left to
 * do. */
static void test_the_adjustment_starts_at_the_joined_cameras(void)
{
    test_rng rng = test_seed(347);
    static rigcal_rig_solver solver;

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(10); trial++) {
        test_rig_random(&r, &rng, 4, 3, 6);
        for (int f = 0; f < 3; f++) {
            test_rig_see(&r, &rng, f, f, 0);
            test_rig_see(&r, &rng, f + 1, f, 0);
        }
        give_true_poses(100);
        memset(r.cams, 0, sizeof r.cams);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_join_begin(&solver, &r.rig));
        do {
            ASSERT_STATUS(RIGCAL_RUNNING, rigcal_rig_join_step(&solver, 1));
        } while (solver.phase == RC_RIG_CHECKING || solver.phase == RC_RIG_CHECKED ||
                 solver.phase == RC_RIG_PLACING || solver.phase == RC_RIG_REACHING);
        assert_joined();
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
}
