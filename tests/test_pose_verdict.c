/* pose: what the solver says of its result. Each verdict is compared with its definition,
 * on both sides of its limit. */
#include <math.h>
#include <string.h>

#include "rc_chance.h"
#include "test_problem.h"

/* The pixel of an image whose focal length is fx: 1 in a real one. */
static double pixel_of(const test_problem *p)
{
    return fmin(1, D(p->camera.fx) * D(p->camera.fx) / 800);
}

/* Magnifies the image. Without a focal length it becomes a normalised one. */
static void zoom(test_problem *p, double fx)
{
    const double by = fx / D(p->camera.fx);

    p->camera.fx *= RC(by);
    p->camera.fy *= RC(by);
    p->camera.cx *= RC(by);
    p->camera.cy *= RC(by);
    test_observe(p);
}

/* The widest difference from the first pixel, along u or v. */
static double extent_of(const test_problem *p)
{
    double extent = 0;

    for (int i = 0; i < p->scene.n; i++) {
        for (int k = 0; k < 2; k++) {
            extent = fmax(extent, fabs(D(p->o[i].uv[k]) - D(p->o[0].uv[k])));
        }
    }
    return extent;
}

/* The noise that is stated, or is believed if none is: 2 px, or 0.7 % of a large image. */
static void test_a_fit_is_poor_beyond_the_noise(void)
{
    static const double FOCAL[3] = {1, 600, 4000}, SIGMA[4] = {0, 0.4, 0, 3};
    test_rng rng = test_seed(7001);
    int poor = 0, n_trials = 0;

    for (int trial = 0; trial < TEST_TRIALS(360); trial++) {
        const double sigma = SIGMA[trial / 3 % 4];
        const int has_weights = trial / 12 % 2;
        test_problem p;

        test_random_problem(&p, &rng, 14, TEST_PLANAR);
        zoom(&p, FOCAL[trial % 3]);
        const double pixel = pixel_of(&p);
        const rigcal_pose_options options = test_options(sigma * pixel);
        p.use_sigma = has_weights;
        for (int i = 0; i < 14; i++) {
            p.sigma[i] = RC(test_uniform(&rng, 0.5, 2));
        }
        const double noise =
            sigma > 0 ? sigma * pixel : fmax(2 * pixel, 0.007 * extent_of(&p));
        test_add_noise(&p, &rng, noise * test_uniform(&rng, 1, 1.8));
        if (test_solve_pose(&p, &options) < 0) {
            continue;
        }
        const double rms = D(p.poses[0].rms_px);
        const double sum = sigma > 0 ? D(p.poses[0].sse) : 14 * rms * rms;
        const double believed =
            sigma > 0 ? sigma * pixel : fmax(2 * pixel, 0.007 * extent_of(&p));
        const double most =
            believed * believed * D(rc_chi2_limit(rc_freedom(14), RC(4.75)));
        if (fabs(sum - most) < TOL(1e-9, 1e-2) * most) {
            continue;
        }
        TEST_ASSERT_EQUAL_INT(sum > most, p.status == RIGCAL_POOR_FIT);
        poor += sum > most;
        n_trials++;
    }
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 ||
                     (n_trials > 300 && poor > 60 && n_trials - poor > 60));
}

/* The standard deviation of the turn, for the stated noise, or that of the fit but at least
 * a quarter of a pixel. Far targets. */
static void test_a_pose_is_vague_beyond_a_quarter_radian(void)
{
    static const double FOCAL[2] = {1, 600}, SIGMA[3] = {0, 0.1, 0.8};
    test_rng rng = test_seed(7002);
    int vague = 0, sure = 0;

    for (int trial = 0; trial < TEST_TRIALS(400); trial++) {
        const double sigma = SIGMA[trial / 2 % 3], far = pow(10, test_uniform(&rng, 0, 2));
        const int n = 5 + trial % 6;
        rigcal_pose_uncertainty u;
        test_problem p;

        test_random_problem(&p, &rng, n, TEST_GENERAL);
        for (int k = 0; k < 3; k++) {
            p.scene.t[k] *= far;
        }
        zoom(&p, FOCAL[trial % 2]);
        const double pixel = pixel_of(&p);
        const rigcal_pose_options options = test_options(sigma * pixel);
        test_add_noise(&p, &rng, trial / 6 % 2 ? 0.6 * pixel : 0.02 * pixel);
        if (test_solve_pose(&p, &options) < 0 || p.status == RIGCAL_POOR_FIT ||
            p.status == RIGCAL_BUDGET_SPENT) {
            continue;
        }
        const double of_fit = sqrt(D(p.poses[0].sse) / (2 * n - 6));
        const double noise = sigma > 0 ? sigma * pixel : fmax(of_fit, 0.25 * pixel);
        if (rigcal_pose_covariance(&u, &VIEW_OF(&p), &p.poses[0].cam_from_world,
                                   RC(noise)) != RIGCAL_OK) {
            continue;
        }
        const double turn =
            sqrt(D(u.rotation[0]) * D(u.rotation[0]) + D(u.rotation[1]) * D(u.rotation[1]) +
                 D(u.rotation[2]) * D(u.rotation[2]));
        if (fabs(turn - 0.25) < TOL(1e-3, 2e-2)) {
            continue;
        }
        TEST_ASSERT_EQUAL_INT(turn > 0.25, p.status == RIGCAL_VAGUE);
        vague += turn > 0.25;
        sure += turn <= 0.25;
    }
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || (vague > 60 && sure > 60));
}

/* Mirrored points are suspected if the fit is worse than the noise, at least 0.1 px. The
 * image is exact, so they fit much better. */
static void test_mirrored_points_are_suspected_beyond_the_noise(void)
{
    static const double FOCAL[2] = {1, 600}, SIGMA[3] = {0, 0.05, 0.3};
    test_rng rng = test_seed(7003);
    int suspected = 0, trusted = 0;

    for (int trial = 0; trial < TEST_TRIALS(360); trial++) {
        const double sigma = SIGMA[trial / 2 % 3];
        test_problem p;

        test_random_problem(&p, &rng, 10, TEST_GENERAL);
        p.scene.t[2] *= pow(10, test_uniform(&rng, 0, 1.5));
        zoom(&p, FOCAL[trial % 2]);
        const double pixel = pixel_of(&p), noise = fmax(sigma, 0.1) * pixel;
        const rigcal_pose_options options = test_options(sigma * pixel);
        for (int i = 0; i < 10; i++) {
            p.o[i].X_w[1] = -p.o[i].X_w[1];
        }
        if (test_solve_pose(&p, &options) < 0) {
            continue;
        }
        const double sse = D(p.poses[0].sse), most = noise * noise * 14;
        const double poor = (sigma > 0 ? sigma * sigma : 4) * pixel * pixel *
                            D(rc_chi2_limit(14, RC(4.75)));
        if (sse > poor || fabs(sse - most) < TOL(1e-3, 5e-2) * most) {
            continue;
        }
        TEST_ASSERT_EQUAL_INT(sse > most, p.status == RIGCAL_POOR_FIT);
        suspected += sse > most;
        trusted += sse <= most;
    }
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || (suspected > 20 && trusted > 20));
}

/* An exact image has a second minimum too. It does not fit, but of four points or more all
 * minima are told. */
static void test_exact_images_of_squares_keep_both_minima(void)
{
    test_rng rng = test_seed(7004);
    int both = 0;

    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        test_problem p;

        test_random_problem(&p, &rng, 4, TEST_SQUARE);
        if (trial % 2) {
            zoom(&p, 1);
        }
        TEST_ASSERT_TRUE(test_solve_pose(&p, NULL) >= 0);
        const size_t exact = p.n_found;
        test_add_noise(&p, &rng, 1e-3 * pixel_of(&p));
        TEST_ASSERT_TRUE(test_solve_pose(&p, NULL) >= 0);
        TEST_ASSERT_EQUAL_size_t(p.n_found, exact);
        both += exact > 1;
    }
    TEST_ASSERT_TRUE(both > 50 || TEST_ONE_IN > 1);
}

/* Three points with noise: poses that fit exactly, and minima that do not. These are
 * dropped if others fit, unless a noise is stated that may explain them. */
static void test_of_three_points_only_poses_that_fit_are_told(void)
{
    test_rng rng = test_seed(7005);
    int dropped = 0, none_fits = 0;

    for (int trial = 0; trial < TEST_TRIALS(9000); trial++) {
        const double fx = trial % 2 ? 600 : 0.04;
        size_t fitting = 0;
        test_problem p, stated;

        test_random_problem(&p, &rng, 3, TEST_GENERAL);
        zoom(&p, fx);
        test_add_noise(&p, &rng, 3 * pixel_of(&p));
        const double most = TOL(1e-11, 1e-5) * pixel_of(&p) * pixel_of(&p);
        const rigcal_pose_options options = test_options(0.9 * pixel_of(&p));
        stated = p;
        if (test_solve_pose(&stated, &options) < 0 || test_solve_pose(&p, NULL) < 0) {
            continue;
        }
        for (size_t i = 0; i < stated.n_found; i++) {
            fitting += D(stated.poses[i].sse) <= most;
        }
        TEST_ASSERT_EQUAL_size_t(fitting > 0 ? fitting : stated.n_found, p.n_found);
        for (size_t i = 0; i < p.n_found; i++) {
            ASSERT_TRANSFORM(&stated.poses[i].cam_from_world, &p.poses[i].cam_from_world, 0,
                             0);
        }
        dropped += fitting > 0 && fitting < stated.n_found;
        none_fits += fitting == 0;
    }
    TEST_ASSERT_TRUE(RIGCAL_USE_FLOAT || TEST_ONE_IN > 1 || (dropped > 9 && none_fits > 1));
}

/* ---- how far it searches ------------------------------------------------- */

static int count_units(test_problem *p, const rigcal_pose_options *options)
{
    rigcal_pose_solver solver;
    int units = 1;

    ASSERT_STATUS(RIGCAL_OK, rigcal_pose_begin(&solver, NULL, &VIEW_OF(p), options));
    while (rigcal_pose_step(&solver, 1) == RIGCAL_RUNNING) {
        units++;
    }
    p->status = rigcal_pose_result(p->poses, RIGCAL_POSES_MAX, &p->n_found, NULL, &solver);
    return units;
}

/* Few points whose first poses fit need no lattice of hundreds of directions. If they do
 * not fit, the lattice is searched too, and may have a better pose. */
static void test_the_lattice_is_searched_only_if_nothing_fits(void)
{
    const rigcal_pose_options options = test_options(0.05);
    test_rng rng = test_seed(7007);
    int quick = 0, thorough = 0, missed = 0;

    TEST_ON_HOST_ONLY("a rate wants all scenes");
    if (!RIGCAL_FOR_SPEED) {
        return; /* the lattice comes first */
    }
    for (int trial = 0; trial < 300; trial++) {
        test_fitted fitted;
        test_problem p;

        test_random_problem(&p, &rng, 4 + trial % 5, TEST_GENERAL);
        quick += count_units(&p, NULL) < 45;
        TEST_ASSERT_TRUE(p.status >= 0);
        test_add_noise(&p, &rng, 20);
        thorough += count_units(&p, &options) >= 45;
        TEST_ASSERT_TRUE(p.status >= 0);
        const test_data data = test_data_of(&p);
        memcpy(fitted.R, p.scene.R, sizeof fitted.R);
        memcpy(fitted.t, p.scene.t, sizeof fitted.t);
        missed += test_fit(&fitted, &data) &&
                  D(p.poses[0].sse) > fitted.sse * (1 + TOL(1e-6, 1e-2));
    }
    TEST_ASSERT_GREATER_THAN_INT(270, quick);
    TEST_ASSERT_GREATER_THAN_INT(297, thorough);
    TEST_ASSERT_LESS_OR_EQUAL_INT(3, missed);
}

/* Noise so large that three points have no exact pose, or other ones than near the truth:
 * the best pose is no worse than the minimum next to the truth. */
static void test_three_points_that_fit_badly_give_their_best_pose(void)
{
    const rigcal_pose_options options = test_options(0.01);
    test_rng rng = test_seed(7008);
    int missed = 0, poor = 0;

    TEST_ON_HOST_ONLY("a rate wants all scenes");
    for (int trial = 0; trial < 3000; trial++) {
        test_fitted fitted;
        test_problem p;

        test_random_problem(&p, &rng, 3, TEST_GENERAL);
        test_add_noise(&p, &rng, 150);
        (void)test_solve_pose(&p, &options);
        if (p.status != RIGCAL_POOR_FIT) {
            continue;
        }
        const test_data data = test_data_of(&p);
        memcpy(fitted.R, p.scene.R, sizeof fitted.R);
        memcpy(fitted.t, p.scene.t, sizeof fitted.t);
        missed += test_fit(&fitted, &data) &&
                  D(p.poses[0].sse) > fitted.sse * (1 + TOL(1e-6, 1e-2));
        poor++;
    }
    TEST_ASSERT_EQUAL_INT(0, missed);
    TEST_ASSERT_GREATER_THAN_INT(20, poor);
}

/* Pixels without any pose near them: a refinement may run out of evaluations in a valley.
 * If nothing better is found, its pose is told, with this status. */
static void test_a_pose_on_its_way_is_told_as_unfinished(void)
{
    const rigcal_pose_options options = test_options(1000);
    test_rng rng = test_seed(7009);
    int unfinished = 0, alone = 0, gained = 0;

    TEST_ON_HOST_ONLY("a rate wants all scenes");
    for (int trial = 0; trial < 3000; trial++) {
        test_fitted fitted;
        test_problem p;

        test_random_problem(&p, &rng, 4 + trial % 3, TEST_GENERAL);
        for (int i = 0; i < 2 * p.scene.n; i++) {
            p.o[i / 2].uv[i % 2] = RC(test_uniform(&rng, -3000, 3000));
        }
        if (test_solve_pose(&p, &options) != RIGCAL_BUDGET_SPENT) {
            continue;
        }
        const test_data data = test_data_of(&p);
        test_transform_parts(fitted.R, fitted.t, &p.poses[0].cam_from_world);
        ASSERT_NEAR(test_sse(&data, fitted.R, fitted.t), p.poses[0].sse,
                    TOL(1e-6, 1e-2) * D(p.poses[0].sse));
        (void)test_fit(&fitted, &data);
        gained += fitted.sse < D(p.poses[0].sse) * (1 - TOL(1e-9, 1e-5));
        unfinished++;
        alone += p.n_found == 1;
    }
    TEST_ASSERT_GREATER_THAN_INT(5, unfinished);
    TEST_ASSERT_GREATER_THAN_INT(5, alone);
    TEST_ASSERT_GREATER_THAN_INT(3, gained);
}

/* ---- points that the lens does not see ----------------------------------- */

/* A barrel lens has no image far outside its own. */
static void unsee(test_problem *p, int i)
{
    p->o[i].uv[0] = RC(i % 2 ? 20000 : -20000);
}

/* One such point is left out; a second one, or too few others, is a failure. Points are
 * looked at in their order. */
static void test_points_without_a_ray_are_counted(void)
{
    static const double BARREL[15] = {0, 640, 480, 500, 500, 320, 240, -0.3};
    test_rng rng = test_seed(7006);

    for (int n = 3; n < 8; n++) {
        for (int first = 0; first < n; first++) {
            int32_t at_fault = -2;
            test_problem p;

            test_random_problem(&p, &rng, n, TEST_GENERAL);
            p.camera = test_camera(BARREL);
            test_observe(&p);
            unsee(&p, first);
            const rigcal_status one = rigcal_pose_solve(
                p.poses, RIGCAL_POSES_MAX, &p.n_found, &at_fault, &VIEW_OF(&p), NULL);
            TEST_ASSERT_EQUAL_INT(first, at_fault);
            TEST_ASSERT_TRUE(n == 3 ? one == RIGCAL_ERR_NO_RAY : one > 0);
            if (n > 4) {
                const int second = (first + 2) % n;

                unsee(&p, second);
                ASSERT_STATUS(RIGCAL_ERR_NO_RAY,
                              rigcal_pose_solve(p.poses, RIGCAL_POSES_MAX, &p.n_found,
                                                &at_fault, &VIEW_OF(&p), NULL));
                TEST_ASSERT_EQUAL_INT(first > second ? first : second, at_fault);
            }
        }
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_fit_is_poor_beyond_the_noise);
    RUN_TEST(test_a_pose_is_vague_beyond_a_quarter_radian);
    RUN_TEST(test_mirrored_points_are_suspected_beyond_the_noise);
    RUN_TEST(test_exact_images_of_squares_keep_both_minima);
    RUN_TEST(test_of_three_points_only_poses_that_fit_are_told);
    RUN_TEST(test_the_lattice_is_searched_only_if_nothing_fits);
    RUN_TEST(test_three_points_that_fit_badly_give_their_best_pose);
    RUN_TEST(test_a_pose_on_its_way_is_told_as_unfinished);
    RUN_TEST(test_points_without_a_ray_are_counted);
}
