/* rig: the public functions of a rig: the pose of a view, the accuracy of the poses, the
 * residuals. Their numbers are compared with the truth in test_adjust.c, their views in
 * test_views.c. */
#include <math.h>
#include <string.h>

#include "rigcal_solvers.h"
#include "test_fit.h"
#include "test_rigs.h"

static test_rig r;

#define WANTS_RIG TEST_WANTS_RAM(sizeof(test_rig) + 12000)

static void make(void)
{
    test_rng rng = test_seed(351);

    test_rig_random(&r, &rng, 3, 4, 8);
    test_rig_see_all(&r, &rng, 0.3);
    test_rig_solve_views(&r);
}

static void make_adjusted(void)
{
    rigcal_rig_fit fit;

    make();
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
}

static void test_the_information_of_a_view_is_that_of_its_covariance(void)
{
    WANTS_RIG;
    make();
    for (size_t v = 0; v < r.rig.n_views; v++) {
        rigcal_pose_uncertainty u;
        double product = 0;

        ASSERT_STATUS(RIGCAL_OK, rigcal_pose_covariance(&u, &r.views[v].view,
                                                        &r.own[v].cam_from_target, 1));
        for (int i = 0; i < 6; i++) {
            for (int k = 0; k < 6; k++) {
                product +=
                    test_in_blocks(r.own[v].information, i, k) * D(u.Sigma[6 * k + i]);
            }
        }
        ASSERT_NEAR(6, product, TOL(1e-8, 1e-2));
        TEST_ASSERT_EQUAL_UINT64(8, r.own[v].n);
        TEST_ASSERT_EQUAL_INT32(r.views[v].camera, r.own[v].camera);
        TEST_ASSERT_EQUAL_INT32(r.views[v].placement, r.own[v].placement);
    }
}

static void test_a_pose_of_a_view_is_refused_and_nothing_written(void)
{
    rigcal_transform T;
    rigcal_view_pose pose;

    WANTS_RIG;
    make();
    T = r.own[0].cam_from_target;
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_view_pose_make(NULL, &r.views[0], &T));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, pose, rigcal_view_pose_make(&pose, NULL, &T));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, pose, rigcal_view_pose_make(&pose, &r.views[0], NULL));
    T.t[2] = -T.t[2];
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, pose, rigcal_view_pose_make(&pose, &r.views[0], &T));
    T.R[0] = 4;
    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, pose,
                   rigcal_view_pose_make(&pose, &r.views[0], &T));
    r.views[0].view.n = 2;
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, pose,
                   rigcal_view_pose_make(&pose, &r.views[0], &r.own[0].cam_from_target));
}

/* Points on a line through the target. A turn about the line moves none of them. */
static void test_points_that_do_not_fix_a_pose_are_degenerate(void)
{
    const rigcal_camera camera = test_pinhole();
    rigcal_transform T = test_transform((const double[]){1, 0, 0, 0, 1, 0, 0, 0, 1},
                                        (const double[]){0.125, -0.25, 4});
    rigcal_observation o[5];
    rigcal_rig_view seen = {VIEW(&camera, o, NULL, 5), 0, 0, 0};
    rigcal_view_pose pose;

    for (int k = 0; k < 5; k++) {
        const double X[3] = {0.25 * (k - 2), 0.125 * (k - 2), 0.5 * (k - 2)};
        const double X_c[3] = {X[0] + 0.125, X[1] - 0.25, X[2] + 4};
        double uv[2];

        test_project_px(uv, &camera, X_c);
        test_to_real(o[k].X_w, X, 3);
        test_to_real(o[k].uv, uv, 2);
    }
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, pose, rigcal_view_pose_make(&pose, &seen, &T));
    for (int k = 1; k < 5; k++) { /* all in one place */
        o[k] = o[0];
    }
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, pose, rigcal_view_pose_make(&pose, &seen, &T));
    o[4].X_w[0] += 1; /* four on a line and one beside it: that fixes a pose */
    for (int k = 0; k < 4; k++) {
        const double X[3] = {0.25 * (k - 2), 0.125 * (k - 2), 0.5 * (k - 2)};

        test_to_real(o[k].X_w, X, 3);
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_view_pose_make(&pose, &seen, &T));
}

static void test_a_held_camera_is_known_exactly(void)
{
    rigcal_real Sigma[36], of_one[36], of_two[36];

    WANTS_RIG;
    make_adjusted();
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(Sigma, &r.rig, 1, 0));
    for (int k = 0; k < 36; k++) {
        ASSERT_NEAR(0, Sigma[k], 0);
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(of_one, &r.rig, 1, 1));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(of_two, &r.rig, 2, 1));
    for (int k = 0; k < 36; k++) {
        ASSERT_NEAR(4 * D(of_one[k]), of_two[k], TOL(1e-15, 1e-6) * fabs(D(of_two[k])));
    }
}

/* Views that are left out after the adjustment say nothing about the placement. */
static void test_a_placement_that_no_view_is_left_of_has_no_covariance(void)
{
    static uint8_t left_out[RIG_VIEWS_MAX];
    rigcal_real Sigma[36];

    WANTS_RIG;
    make_adjusted();
    memset(left_out, 0, sizeof left_out);
    r.rig.left_out = left_out;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_placement(Sigma, &r.rig, 1, 1));
    memset(left_out + 3, 1, 3); /* of placement 1 */
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE, rigcal_rig_placement(Sigma, &r.rig, 1, 1));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_placement(Sigma, &r.rig, 1, 0));
}

/* Asks a rig that has no covariance for one. */
static void assert_no_covariance(void)
{
    rigcal_real Sigma[36];
    rigcal_transform pair;

    ASSERT_REFUSED(RIGCAL_ERR_STATE, Sigma, rigcal_rig_covariance(Sigma, &r.rig, 1, 1));
    ASSERT_REFUSED(RIGCAL_ERR_STATE, Sigma, rigcal_rig_placement(Sigma, &r.rig, 1, 1));
    ASSERT_REFUSED(RIGCAL_ERR_STATE, Sigma, rigcal_rig_pair(&pair, Sigma, &r.rig, 1, 0, 1));
}

static void test_a_rig_that_is_not_adjusted_has_no_covariance(void)
{
    rigcal_rig_fit fit;

    WANTS_RIG;
    make(); /* its memory is all zeros */
    assert_no_covariance();
    for (size_t k = 0; k < RIG_WORK; k++) {
        r.work[k] = RC(1e9);
    }
    assert_no_covariance();
    for (size_t k = 0; k < RIG_WORK; k++) {
        r.work[k] = TEST_NAN;
    }
    assert_no_covariance();
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_join(&r.rig, NULL));
    assert_no_covariance();
    make_adjusted();
    r.views[5].camera = 9;
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_rig_adjust(&fit, NULL, &r.rig));
    assert_no_covariance();
}

static void test_arguments_of_the_covariances_are_checked(void)
{
    rigcal_real Sigma[36], duv[16];
    rigcal_transform pair;
    size_t n;

    WANTS_RIG;
    make_adjusted();
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, Sigma, rigcal_rig_covariance(Sigma, &r.rig, 1, 3));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, Sigma, rigcal_rig_covariance(Sigma, &r.rig, -1, 1));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, Sigma, rigcal_rig_placement(Sigma, &r.rig, 1, 4));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, Sigma, rigcal_rig_pair(&pair, Sigma, &r.rig, 1, 0, 3));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, pair, rigcal_rig_pair(&pair, Sigma, &r.rig, 1, 3, 0));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, duv,
                   rigcal_rig_residuals(duv, 16, &n, &r.rig, r.rig.n_views));
    ASSERT_REFUSED(RIGCAL_ERR_CAPACITY, duv, rigcal_rig_residuals(duv, 15, &n, &r.rig, 2));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_residuals(duv, 16, &n, &r.rig, 2));
}

static void test_cameras_of_two_groups_have_no_pair(void)
{
    test_rng rng = test_seed(352);
    rigcal_real Sigma[36];
    rigcal_transform pair;
    rigcal_rig_fit fit;

    WANTS_RIG;
    test_rig_random(&r, &rng, 4, 3, 8);
    test_rig_see(&r, &rng, 0, 0, 0.3);
    test_rig_see(&r, &rng, 2, 0, 0.3);
    test_rig_see(&r, &rng, 1, 1, 0.3);
    test_rig_see(&r, &rng, 3, 1, 0.3);
    ASSERT_STATUS(RIGCAL_DISCONNECTED, rigcal_rig_adjust(&fit, NULL, &r.rig));
    ASSERT_REFUSED(RIGCAL_DISCONNECTED, pair,
                   rigcal_rig_pair(&pair, Sigma, &r.rig, 1, 0, 3));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_pair(&pair, Sigma, &r.rig, 1, 0, 2));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_pair(&pair, Sigma, &r.rig, 1, 3, 1));
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, Sigma, rigcal_rig_placement(Sigma, &r.rig, 1, 2));
}

/* A tree has no cycle, so there is nothing to close. */
static void test_without_a_cycle_there_is_no_loop_closure(void)
{
    test_rng rng = test_seed(353);
    rigcal_rig_fit fit;

    WANTS_RIG;
    test_rig_random(&r, &rng, 3, 2, 8);
    test_rig_see(&r, &rng, 0, 0, 0.3);
    test_rig_see(&r, &rng, 1, 0, 0.3);
    test_rig_see(&r, &rng, 1, 1, 0.3);
    test_rig_see(&r, &rng, 2, 1, 0.3);
    test_rig_solve_views(&r);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    ASSERT_NEAR(0, fit.F, 0);
    ASSERT_NEAR(0, fit.freedom_between, 0);
}

/* Views of three points fit exactly by themselves, whatever the noise is. So there is no
 * error inside views to compare the rig with. */
static void test_views_of_three_points_have_no_test_of_the_rig(void)
{
    rigcal_rig_fit fit;

    WANTS_RIG;
    make();
    for (size_t v = 0; v < r.rig.n_views; v++) {
        r.views[v].view.n = 3;
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    ASSERT_NEAR(12 * 6 - 6 * (2 + 4), fit.freedom, 0);
    TEST_ASSERT_TRUE(fit.sigma_px > RC(0.1) && fit.sigma_px < RC(0.6));
    ASSERT_NEAR(0, fit.F, 0);
    ASSERT_NEAR(0, fit.freedom_between, 0);
    ASSERT_NEAR(0, fit.freedom_within, 0);
}

static void test_steps_are_asked_in_order(void)
{
    rigcal_rig_solver solver;
    rigcal_rig_fit fit;

    WANTS_RIG;
    make();
    memset(&solver, 0, sizeof solver);
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_rig_step(&solver, 5));
    ASSERT_REFUSED(RIGCAL_ERR_STATE, fit, rigcal_rig_result(&fit, NULL, &solver));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_begin(&solver, &r.rig));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_rig_step(&solver, 0));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rig_step(NULL, 1));
    ASSERT_STATUS(RIGCAL_RUNNING, rigcal_rig_step(&solver, 1));
    ASSERT_REFUSED(RIGCAL_ERR_STATE, fit, rigcal_rig_result(&fit, NULL, &solver));
}

static void test_poses_to_start_from_are_checked(void)
{
    rigcal_rig_fit fit;
    int32_t at_fault;

    WANTS_RIG;
    make();
    r.cams[2].R[3] = 3;
    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, fit, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
    make();
    r.places[1].t[0] = TEST_NAN;
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, fit, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_INT32(3, at_fault); /* the first view of placement 1 */
}

/* 12 views of 8 points have 192 numbers; 2 cameras and 4 placements are free. The estimated
 * noise has the standard deviation 0.017; the tolerance 0.06 is more than three times
 * that. */
static void test_the_noise_found_is_that_of_the_pixels(void)
{
    rigcal_rig_fit fit;

    WANTS_RIG;
    make();
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    ASSERT_NEAR(192 - 6 * (2 + 4), fit.freedom, 0);
    ASSERT_NEAR(0.3, fit.sigma_px, 0.06);
    ASSERT_NEAR(D(fit.sum), D(fit.sigma_px) * D(fit.sigma_px) * D(fit.freedom),
                TOL(1e-12, 1e-5) * D(fit.sum));
}

/* The unknowns lower the freedom of all cameras together by their number. The covariance is
 * that of the last step but one. After that step the poses moved by 1e-7. */
static void test_the_freedom_of_the_cameras_is_that_of_the_rig(void)
{
    rigcal_rig_fit fit;
    rigcal_real sigma_px[3], freedom[3];

    WANTS_RIG;
    make();
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_noise(sigma_px, freedom, &r.rig));
    ASSERT_NEAR(192 - 6 * (2 + 4), D(freedom[0]) + D(freedom[1]) + D(freedom[2]),
                TOL(1e-3, 0.1));
}

/* Three points of one view fit exactly: there is no noise to state. */
static void test_without_freedom_there_is_no_noise(void)
{
    test_rng rng = test_seed(352);
    rigcal_rig_fit fit;

    WANTS_RIG;
    test_rig_random(&r, &rng, 1, 1, 8);
    test_rig_see_all(&r, &rng, 0.3);
    r.views[0].view.n = 3;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    ASSERT_NEAR(0, fit.freedom, 0);
    ASSERT_NEAR(0, fit.sigma_px, 0);
}

/* If the placement is known by others, a view of three points has 6 numbers for the 6
 * unknowns of its camera, and a small part of one left: the noise is still stated. */
static void test_the_noise_of_a_camera_with_hardly_any_freedom(void)
{
    rigcal_rig_fit fit;
    rigcal_real sigma_px[3], freedom[3];
    size_t n = 0;

    WANTS_RIG;
    make();
    for (size_t v = 0; v < r.rig.n_views; v++) {
        if (r.views[v].camera != 2 || r.views[v].placement == 0) {
            r.views[n] = r.views[v];
            r.views[n].view.n = r.views[v].camera == 2 ? 3 : 8;
            n++;
        }
    }
    r.rig.n_views = n;
    r.rig.view_poses = NULL;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_noise(sigma_px, freedom, &r.rig));
    TEST_ASSERT_TRUE(freedom[2] > 0 && freedom[2] < 1);
    TEST_ASSERT_TRUE(sigma_px[2] > 0);
}

/* Point 0 of every view has half the noise, or is seen four times. */
static void make_weighed(const rigcal_real sigma[], int is_repeated)
{
    make();
    for (size_t v = 0; v < r.rig.n_views; v++) {
        rigcal_view *const view = &r.views[v].view;

        view->sigma = is_repeated ? NULL : sigma;
        for (; is_repeated && view->n < 11; view->n++) {
            r.o[v][view->n] = r.o[v][0];
        }
    }
}

static void test_a_point_of_half_the_noise_counts_as_four(void)
{
    static const rigcal_real sigma[8] = {RC(0.5), 1, 1, 1, 1, 1, 1, 1};
    rigcal_transform cams[RIG_CAMERAS_MAX];
    rigcal_view_pose pose[2];
    rigcal_rig_fit fit[2];

    WANTS_RIG;
    for (int k = 0; k < 2; k++) {
        make_weighed(sigma, k);
        ASSERT_STATUS(RIGCAL_OK, rigcal_view_pose_make(&pose[k], &r.views[5],
                                                       &r.own[5].cam_from_target));
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit[k], NULL, &r.rig));
        if (k == 0) {
            memcpy(cams, r.cams, sizeof cams);
        }
    }
    ASSERT_NEAR(pose[1].sse, pose[0].sse, TOL(1e-10, 1e-3) * D(pose[1].sse));
    for (int k = 0; k < 21; k++) {
        ASSERT_NEAR(pose[1].information[k], pose[0].information[k],
                    TOL(1e-10, 1e-4) * D(pose[1].information[0] + pose[1].information[20]));
    }
    ASSERT_NEAR(fit[1].sum, fit[0].sum, TOL(1e-9, 1e-3) * D(fit[1].sum));
    for (int c = 0; c < 3; c++) {
        ASSERT_TRANSFORM(&r.cams[c], &cams[c], TOL(1e-7, 1e-4), TOL(1e-6, 1e-3));
    }
}

/* Views have no poses of their own to compare with. */
static void test_without_poses_of_views_there_is_no_loop_closure(void)
{
    rigcal_rig_fit fit;

    WANTS_RIG;
    make();
    r.rig.view_poses = NULL;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    ASSERT_NEAR(0, fit.F, 0);
    ASSERT_NEAR(0, fit.freedom_between, 0);
    ASSERT_NEAR(0, fit.freedom_within, 0);
}

TEST_MAIN()
{
    RUN_TEST(test_the_information_of_a_view_is_that_of_its_covariance);
    RUN_TEST(test_a_pose_of_a_view_is_refused_and_nothing_written);
    RUN_TEST(test_points_that_do_not_fix_a_pose_are_degenerate);
    RUN_TEST(test_a_held_camera_is_known_exactly);
    RUN_TEST(test_a_placement_that_no_view_is_left_of_has_no_covariance);
    RUN_TEST(test_a_rig_that_is_not_adjusted_has_no_covariance);
    RUN_TEST(test_arguments_of_the_covariances_are_checked);
    RUN_TEST(test_cameras_of_two_groups_have_no_pair);
    RUN_TEST(test_without_a_cycle_there_is_no_loop_closure);
    RUN_TEST(test_views_of_three_points_have_no_test_of_the_rig);
    RUN_TEST(test_steps_are_asked_in_order);
    RUN_TEST(test_poses_to_start_from_are_checked);
    RUN_TEST(test_the_noise_found_is_that_of_the_pixels);
    RUN_TEST(test_the_freedom_of_the_cameras_is_that_of_the_rig);
    RUN_TEST(test_without_freedom_there_is_no_noise);
    RUN_TEST(test_the_noise_of_a_camera_with_hardly_any_freedom);
    RUN_TEST(test_without_poses_of_views_there_is_no_loop_closure);
    RUN_TEST(test_a_point_of_half_the_noise_counts_as_four);
}
