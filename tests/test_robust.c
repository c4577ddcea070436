/* robust: scenes in which some pixels belong to other points, or are random. The result is
 * compared with that of rigcal_pose_solve for the right points. */
#include <math.h>
#include <string.h>

#include "rc_agree.h"
#include "rc_sample.h"
#include "test_support.h"

enum { N_MAX = TEST_SCENE_MAX };

static const double NOISE = 0.5; /* px */

typedef enum { NEAR_THE_TARGET, IN_THE_IMAGE, SWAPPED } wrongness;

/* ---- scenes -------------------------------------------------------------- */

typedef struct {
    test_scene scene;
    rigcal_camera camera;
    rigcal_observation o[N_MAX];
    uint8_t right[N_MAX], inliers[N_MAX];
    int n, n_wrong;
    rigcal_pose poses[RIGCAL_POSES_MAX];
    size_t n_found, n_inliers;
} problem;

static void make(problem *p, test_rng *rng, int n, test_shape shape)
{
    p->camera = test_pinhole();
    test_scene_random(&p->scene, rng, n, shape);
    test_observations(p->o, &p->scene, &p->camera);
    p->n = n;
    p->n_wrong = 0;
    for (int i = 0; i < n; i++) {
        p->right[i] = 1;
        for (int k = 0; k < 2; k++) {
            p->o[i].uv[k] = RC(D(p->o[i].uv[k]) + NOISE * test_normal(rng));
        }
    }
}

/* Makes the last points wrong, from n - 1 downwards; they are as random as any. */
static void spoil(problem *p, test_rng *rng, int n_wrong, wrongness how)
{
    double low[2] = {0, 0}, high[2] = {D(p->camera.width), D(p->camera.height)};
    const rigcal_observation last = p->o[p->n - 1];

    for (int k = 0; k < 2 && how == NEAR_THE_TARGET; k++) {
        low[k] = 1e9;
        high[k] = -1e9;
        for (int i = 0; i < p->n; i++) {
            low[k] = fmin(low[k], D(p->o[i].uv[k]));
            high[k] = fmax(high[k], D(p->o[i].uv[k]));
        }
    }
    for (int i = p->n - 1; i >= p->n - n_wrong; i--) {
        p->right[i] = 0;
        for (int k = 0; k < 2; k++) {
            p->o[i].uv[k] = how != SWAPPED       ? RC(test_uniform(rng, low[k], high[k]))
                            : i > p->n - n_wrong ? p->o[i - 1].uv[k]
                                                 : last.uv[k];
        }
    }
    p->n_wrong = n_wrong;
}

static rigcal_status solve(problem *p, const rigcal_robust_options *options)
{
    memset(p->inliers, 7, sizeof p->inliers);
    return rigcal_robust_solve(p->poses, RIGCAL_POSES_MAX, &p->n_found, p->inliers,
                               &p->n_inliers, NULL,
                               &VIEW(&p->camera, p->o, NULL, (size_t)p->n), options);
}

static double error_of(const problem *p, const rigcal_pose *pose)
{
    double R[9], t[3];

    test_transform_parts(R, t, &pose->cam_from_world);
    return test_angle_between(R, p->scene.R);
}

static double least_error(const problem *p, const rigcal_pose poses[], size_t n)
{
    double least = 1e300;

    for (size_t i = 0; i < n; i++) {
        least = fmin(least, error_of(p, &poses[i]));
    }
    return least;
}

/* The error of the pose of the right points alone. */
static double error_without_wrong_ones(const problem *p)
{
    rigcal_pose poses[RIGCAL_POSES_MAX];
    size_t n_found;

    TEST_ASSERT_TRUE(
        rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL,
                          &VIEW(&p->camera, p->o, NULL, (size_t)(p->n - p->n_wrong)),
                          NULL) >= 0);
    return least_error(p, poses, n_found);
}

/* Whether the pose is right. A right point farther off than the threshold, or a wrong one
 * that is within it by chance, may move the pose by no more than its own noise. */
static int is_right(const problem *p)
{
    return least_error(p, p->poses, p->n_found) <=
           2 * error_without_wrong_ones(p) + 2 * TEST_PI / 180;
}

static int counted(const problem *p)
{
    int count = 0;

    for (int i = 0; i < p->n; i++) {
        TEST_ASSERT_TRUE(p->inliers[i] <= 1);
        count += p->inliers[i];
    }
    return count;
}

/* Reverses the order, so that the wrong points come first. */
static void turn_round(problem *p)
{
    for (int i = 0; i < p->n / 2; i++) {
        const rigcal_observation o = p->o[i];
        const uint8_t right = p->right[i];

        p->o[i] = p->o[p->n - 1 - i];
        p->o[p->n - 1 - i] = o;
        p->right[i] = p->right[p->n - 1 - i];
        p->right[p->n - 1 - i] = right;
    }
}

/* Whether the inliers are exactly the points within the threshold of the first pose. */
static int inliers_are_those_of_the_pose(const problem *p, double threshold_px)
{
    double R[9], t[3], X[3], X_c[3], uv[2];

    test_transform_parts(R, t, &p->poses[0].cam_from_world);
    for (int i = 0; i < p->n; i++) {
        test_to_double(X, p->o[i].X_w, 3);
        test_apply(X_c, R, X, t);
        test_project_px(uv, &p->camera, X_c);
        const double distance = hypot(uv[0] - D(p->o[i].uv[0]), uv[1] - D(p->o[i].uv[1]));
        if (p->inliers[i] != (distance <= threshold_px)) {
            return 0;
        }
    }
    return 1;
}

/* ---- wrong correspondences ----------------------------------------------- */

static void test_three_in_ten_may_be_wrong(void)
{
    static const int POINTS[3] = {12, 20, TEST_MANY};
    test_rng rng = test_seed(1);
    int scenes = 0, wrong = 0, other_inliers = 0, few = 0, unstable = 0;

    TEST_ON_HOST_ONLY("a rate wants all scenes");
    for (int n = 0; n < 900; n++) {
        problem p;

        make(&p, &rng, POINTS[n % 3], (test_shape)(n / 3 % 3));
        spoil(&p, &rng, p.n * 3 / 10, (wrongness)(n / 9 % 3));
        const rigcal_status status = solve(&p, NULL);
        scenes++;
        if (status < 0) {
            wrong++;
            continue;
        }
        wrong += !is_right(&p);
        few += status == RIGCAL_FEW_AGREE;
        unstable += !inliers_are_those_of_the_pose(&p, 3);
        other_inliers += memcmp(p.inliers, p.right, (size_t)p.n) != 0;
        TEST_ASSERT_EQUAL_INT(counted(&p), p.n_inliers);
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(scenes / 1000, wrong);
    TEST_ASSERT_LESS_OR_EQUAL_INT(1, unstable);
    TEST_ASSERT_LESS_THAN_INT(scenes / 10, other_inliers);
    TEST_ASSERT_LESS_THAN_INT(scenes / 50, few);
}

static void test_none_need_be_wrong(void)
{
    test_rng rng = test_seed(2);

    for (int n = 0; n < TEST_TRIALS(60); n++) {
        rigcal_pose plain[RIGCAL_POSES_MAX];
        size_t n_found;
        problem p;

        make(&p, &rng, 8 + n % 20, (test_shape)(n % 3));
        const rigcal_status status = solve(&p, NULL);
        TEST_ASSERT_TRUE(status >= 0);
        if (p.n_inliers < (size_t)p.n) {
            continue;
        }
        const rigcal_status expected =
            rigcal_pose_solve(plain, RIGCAL_POSES_MAX, &n_found, NULL,
                              &VIEW(&p.camera, p.o, NULL, (size_t)p.n), NULL);
        if (status != RIGCAL_FEW_AGREE) {
            ASSERT_STATUS(expected, status);
        }
        TEST_ASSERT_EQUAL_INT(n_found, p.n_found);
        TEST_ASSERT_EQUAL_MEMORY(plain, p.poses, n_found * sizeof plain[0]);
    }
}

static void test_all_wrong_is_not_believed(void)
{
    test_rng rng = test_seed(3);
    int believed = 0, few = 0;

    for (int n = 0; n < TEST_TRIALS(300); n++) {
        problem p;

        make(&p, &rng, n % 4 == 0 ? 5 : 6 * (n % 4) + 2, (test_shape)(n % 3));
        spoil(&p, &rng, p.n, (wrongness)(n % 2));
        FILL(p.poses);
        const rigcal_status status = solve(&p, NULL);
        if (status < 0) {
            ASSERT_UNTOUCHED(p.poses);
        }
        few += status == RIGCAL_FEW_AGREE;
        believed += status >= 0 && status != RIGCAL_FEW_AGREE;
    }
    TEST_ASSERT_EQUAL_INT(0, believed);
    TEST_ASSERT_LESS_THAN_INT(10, few);
}

/* Of five points with one wrong, four agree. Chance does that in one of some ten images, so
 * the status says it. With eight points and one wrong it does not. */
static void test_few_points_are_told_to_be_few(void)
{
    test_rng rng = test_seed(4);
    int sure_of_five = 0, found_of_five = 0, sure_of_eight = 0;

    for (int n = 0; n < TEST_TRIALS(100); n++) {
        problem p;

        make(&p, &rng, 5, TEST_GENERAL);
        spoil(&p, &rng, 1, IN_THE_IMAGE);
        turn_round(&p);
        rigcal_status status = solve(&p, NULL);
        sure_of_five += status == RIGCAL_OK || status == RIGCAL_AMBIGUOUS;
        found_of_five +=
            status == RIGCAL_FEW_AGREE && memcmp(p.inliers, p.right, (size_t)p.n) == 0;
        make(&p, &rng, 8, TEST_GENERAL);
        spoil(&p, &rng, 1, IN_THE_IMAGE);
        status = solve(&p, NULL);
        sure_of_eight += status == RIGCAL_OK && is_right(&p);
    }
    TEST_ASSERT_EQUAL_INT(0, sure_of_five);
    if (TEST_ONE_IN == 1) {
        TEST_ASSERT_GREATER_THAN_INT(80, found_of_five);
        TEST_ASSERT_GREATER_THAN_INT(90, sure_of_eight);
    }
}

/* Points given twice, and points nearly in one place, make triples that fix no pose. */
static void test_points_may_be_given_twice(void)
{
    test_rng rng = test_seed(5);

    for (int n = 0; n < TEST_TRIALS(60); n++) {
        problem p;

        make(&p, &rng, 20, (test_shape)(n % 3));
        for (int i = 0; i < 8; i++) {
            p.o[i + 4] = p.o[i % 4];
            p.o[i + 4].X_w[0] += RC(n % 2 == 0 ? 0 : 1e-4);
        }
        spoil(&p, &rng, 4, NEAR_THE_TARGET);
        TEST_ASSERT_TRUE(solve(&p, NULL) >= 0);
        TEST_ASSERT_TRUE(is_right(&p));
    }
}

/* A wrong pixel may be one for which the lens has no ray. */
static void test_a_pixel_without_a_ray_is_a_wrong_one(void)
{
    test_rng rng = test_seed(6);
    problem p;

    make(&p, &rng, 12, TEST_GENERAL);
    p.camera.k1 = RC(-0.2);
    for (int i = 0; i < p.n; i++) {
        double X_c[3], uv[2];

        test_apply(X_c, p.scene.R, p.scene.X[i], p.scene.t);
        test_project_px(uv, &p.camera, X_c);
        test_to_real(p.o[i].uv, uv, 2);
    }
    p.o[11].uv[0] = 1e6;
    p.right[11] = 0;
    p.n_wrong = 1;
    ASSERT_STATUS(RIGCAL_OK, solve(&p, NULL));
    TEST_ASSERT_EQUAL_MEMORY(p.right, p.inliers, 12);
    TEST_ASSERT_TRUE(least_error(&p, p.poses, 1) < TOL(1e-7, 1e-2));
}

/* Seven in ten are wrong, within the target's own image. The six right ones are too close
 * to their projections to be chance. */
static void test_six_of_twenty_are_believed(void)
{
    test_rng rng = test_seed(11);
    int believed = 0, right = 0;

    TEST_ON_HOST_ONLY("a rate wants all scenes");
    for (int n = 0; n < 300; n++) {
        problem p;

        make(&p, &rng, 20, TEST_GENERAL);
        spoil(&p, &rng, 14, NEAR_THE_TARGET);
        const rigcal_status status = solve(&p, NULL);
        believed += status == RIGCAL_MOST_DISAGREE;
        right += status == RIGCAL_MOST_DISAGREE && is_right(&p);
    }
    TEST_ASSERT_GREATER_OR_EQUAL_INT(270, right);
    TEST_ASSERT_LESS_OR_EQUAL_INT(1, believed - right);
}

/* Nine in ten are wrong. Some 10 000 triples find the right ones. */
static void test_nine_in_ten_may_be_wrong(void)
{
    test_rng rng = test_seed(12);
    int right = 0;

    TEST_ON_HOST_ONLY("it takes 50 points or more");
    for (int n = 0; n < 20; n++) {
        problem p;

        make(&p, &rng, N_MAX, TEST_GENERAL);
        spoil(&p, &rng, N_MAX * 88 / 100, IN_THE_IMAGE);
        right += solve(&p, NULL) == RIGCAL_MOST_DISAGREE && is_right(&p);
    }
    TEST_ASSERT_GREATER_OR_EQUAL_INT(19, right);
}

/* ---- thresholds ---------------------------------------------------------- */

/* sigma_i scales the threshold of each point. */
static void test_relative_noise_widens_the_threshold(void)
{
    test_rng rng = test_seed(7);
    rigcal_real sigma[12];
    problem p;

    make(&p, &rng, 12, TEST_GENERAL);
    for (int i = 0; i < 12; i++) {
        sigma[i] = 1;
    }
    p.o[3].uv[0] += 20;
    ASSERT_STATUS(RIGCAL_OK, solve(&p, NULL));
    TEST_ASSERT_EQUAL_INT(0, p.inliers[3]);
    sigma[3] = 20;
    TEST_ASSERT_TRUE(rigcal_robust_solve(p.poses, RIGCAL_POSES_MAX, &p.n_found, p.inliers,
                                         &p.n_inliers, NULL,
                                         &VIEW(&p.camera, p.o, sigma, 12), NULL) >= 0);
    TEST_ASSERT_EQUAL_INT(1, p.inliers[3]);
    TEST_ASSERT_EQUAL_INT(12, p.n_inliers);
}

static void test_the_threshold_is_that_stated(void)
{
    test_rng rng = test_seed(8);
    rigcal_robust_options options;
    problem p;

    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    make(&p, &rng, 20, TEST_GENERAL);
    p.o[3].uv[0] += 10;
    ASSERT_STATUS(RIGCAL_OK, solve(&p, &options)); /* 3 px */
    TEST_ASSERT_EQUAL_INT(0, p.inliers[3]);
    options.threshold_px = 20;
    TEST_ASSERT_TRUE(solve(&p, &options) >= 0);
    TEST_ASSERT_EQUAL_INT(1, p.inliers[3]);
    options.threshold_px = 0;
    options.sigma_px = 5; /* 20 px */
    TEST_ASSERT_TRUE(solve(&p, &options) >= 0);
    TEST_ASSERT_EQUAL_INT(1, p.inliers[3]);
}

static void test_a_threshold_may_be_less_than_a_pixel(void)
{
    test_rng rng = test_seed(16);
    rigcal_robust_options options;
    problem p;

    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    make(&p, &rng, 20, TEST_GENERAL);
    test_observations(p.o, &p.scene, &p.camera);
    p.o[3].uv[0] += RC(0.5);
    options.threshold_px = RC(0.25);
    ASSERT_STATUS(RIGCAL_OK, solve(&p, &options));
    TEST_ASSERT_EQUAL_INT(0, p.inliers[3]);
    TEST_ASSERT_EQUAL_INT(19, p.n_inliers);
    options.threshold_px = RC(0.75);
    TEST_ASSERT_TRUE(solve(&p, &options) >= 0);
    TEST_ASSERT_EQUAL_INT(20, p.n_inliers);
}

/* One point is off by a little less or more than the threshold, the others are exact. They
 * are so many that the one cannot draw the pose towards itself. The threshold is 3 px, four
 * times the noise stated, or what is stated; in an image whose unit is the focal length,
 * 3 / 800 of it. */
static void test_a_point_agrees_up_to_the_threshold(void)
{
    static const struct {
        double threshold, sigma, limit, focal;
    } CASE[] = {{0, 0, 3, 800},     {0, 0.5, 2, 800},     {0, 0.05, 0.2, 800},
                {0, 5, 20, 800},    {0.25, 0, 0.25, 800}, {0.6, 3, 0.6, 800},
                {7, 0.1, 7, 800},   {0, 0, 3 / 800.0, 1}, {0, 0, 1.5, 20},
                {1.5, 0, 1.5, 800}, {0.01, 0, 0.01, 1}};

    TEST_ON_HOST_ONLY("40 points");
    for (size_t k = 0; k < 2 * sizeof CASE / sizeof CASE[0]; k++) {
        const double by = k % 2 ? 1.06 : 0.97, f = CASE[k / 2].focal;
        test_rng rng = test_seed(24);
        rigcal_robust_options options;
        problem p;

        ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
        options.threshold_px = RC(CASE[k / 2].threshold);
        options.sigma_px = RC(CASE[k / 2].sigma);
        make(&p, &rng, 40, TEST_GENERAL);
        p.camera.fx = p.camera.fy = RC(f);
        p.camera.cx = RC(0.4 * f);
        p.camera.cy = RC(0.3 * f);
        p.camera.width = f < 800 ? 40 : 640;
        p.camera.height = f < 800 ? 30 : 480;
        test_observations(p.o, &p.scene, &p.camera);
        p.o[3].uv[0] += RC(0.6 * by * CASE[k / 2].limit);
        p.o[3].uv[1] -= RC(0.8 * by * CASE[k / 2].limit);
        TEST_ASSERT_TRUE(solve(&p, &options) >= 0);
        TEST_ASSERT_EQUAL_INT(by < 1, p.inliers[3]);
        TEST_ASSERT_EQUAL_INT(40 - (by > 1), p.n_inliers);
    }
}

/* Three points alone fit several poses; these five have two. */
static void test_with_room_for_one_pose_the_best_is_written(void)
{
    test_rng rng = test_seed(17);
    int several = 0;

    for (int n = 0; n < TEST_TRIALS(40); n++) {
        rigcal_pose one[2];
        uint8_t inliers[N_MAX];
        size_t n_found, n_inliers;
        problem p;

        make(&p, &rng, 12, TEST_PLANAR);
        const rigcal_status status = solve(&p, NULL);
        if (status < 0 || p.n_found < 2) {
            continue;
        }
        memset(one, 7, sizeof one);
        const rigcal_pose beyond = one[1];
        ASSERT_STATUS(status,
                      rigcal_robust_solve(one, 1, &n_found, inliers, &n_inliers, NULL,
                                          &VIEW(&p.camera, p.o, NULL, 12), NULL));
        TEST_ASSERT_EQUAL_INT(1, n_found);
        TEST_ASSERT_EQUAL_INT(p.n_inliers, n_inliers);
        TEST_ASSERT_EQUAL_MEMORY(&p.poses[0], &one[0], sizeof one[0]);
        TEST_ASSERT_EQUAL_MEMORY(&beyond, &one[1], sizeof beyond);
        several++;
    }
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || several > 3);
}

/* ---- steps --------------------------------------------------------------- */

/* Checks how many triples are tried if `agree` points agree with the first pose. 0.7 of the
 * useful triples lead to the pose. The chance to miss all must be below exp(-6.9). */
static void assert_tried(int n, int agree, int32_t samples)
{
    const double all = n * (n - 1) * (n - 2) / 6.0;
    const double useful = 0.7 * (agree * (agree - 1) * (agree - 2) / 6.0);
    const int is_all = all <= samples;
    test_rng rng = test_seed(18);
    rigcal_robust_options options;
    rigcal_robust_solver solver;
    double missed[2];
    problem p;

    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    options.samples = samples;
    make(&p, &rng, n, TEST_GENERAL);
    test_observations(p.o, &p.scene, &p.camera);
    for (int i = agree; i < n; i++) {
        p.o[i].uv[0] += RC(100 + 17 * (i - agree));
    }
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_robust_begin(&solver, p.inliers, NULL,
                                      &VIEW(&p.camera, p.o, NULL, (size_t)n), &options));
    while (rigcal_robust_step(&solver, 1000) == RIGCAL_RUNNING) {
    }
    for (int k = 0; k < 2; k++) {
        const double tried = solver.tried - k;
        missed[k] = is_all ? useful * log(1 - tried / all) : -useful / all * tried;
    }
    TEST_ASSERT_TRUE(missed[0] <= -6.9);
    TEST_ASSERT_TRUE(missed[1] > -6.9);
}

static void test_as_many_triples_are_tried_as_the_chance_to_miss_asks(void)
{
    assert_tried(10, 10, 10000); /* each of the 120 triples at most once: 10 are enough */
    assert_tried(10, 8, 10000);
    assert_tried(20, 20, 1000); /* at random: 10 */
    assert_tried(20, 15, 1000);
}

static void test_budgets_change_no_bit(void)
{
    static const int32_t BUDGET[3] = {1, 7, 100000};
    test_rng rng = test_seed(9);

    for (int n = 0; n < 12; n++) {
        problem p;

        make(&p, &rng, n % 2 ? 11 : 40, (test_shape)(n % 3));
        spoil(&p, &rng, 3, NEAR_THE_TARGET);
        const rigcal_status status = solve(&p, NULL);
        for (int k = 0; k < 3; k++) {
            rigcal_robust_solver solver;
            rigcal_pose poses[RIGCAL_POSES_MAX];
            uint8_t inliers[N_MAX];
            size_t n_found, n_inliers;
            int32_t spent = 0;

            ASSERT_STATUS(RIGCAL_OK, rigcal_robust_begin(
                                         &solver, inliers, NULL,
                                         &VIEW(&p.camera, p.o, NULL, (size_t)p.n), NULL));
            while (rigcal_robust_step(&solver, BUDGET[k]) == RIGCAL_RUNNING) {
                spent += BUDGET[k];
                TEST_ASSERT_LESS_THAN_INT(7 * 500 + 9000, spent);
            }
            ASSERT_STATUS(status, rigcal_robust_result(poses, RIGCAL_POSES_MAX, &n_found,
                                                       &n_inliers, &solver));
            TEST_ASSERT_EQUAL_INT(p.n_found, n_found);
            TEST_ASSERT_EQUAL_INT(p.n_inliers, n_inliers);
            TEST_ASSERT_EQUAL_MEMORY(p.inliers, inliers, p.n);
            TEST_ASSERT_EQUAL_MEMORY(p.poses, poses, n_found * sizeof poses[0]);
            /* it belongs to the caller, who may have freed it */
            solver.points.view.camera = NULL;
            solver.points.view.observations = NULL;
            ASSERT_STATUS(RIGCAL_OK, rigcal_robust_step(&solver, 1));
        }
    }
}

/* With one sample, one scene in a hundred is wrong too often. Another seed draws other
 * samples. */
static void test_seed_and_samples_count(void)
{
    test_rng rng = test_seed(10);
    rigcal_robust_options options;
    int differ = 0;

    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    options.samples = 2;
    for (int n = 0; n < 40; n++) {
        problem p;

        make(&p, &rng, 40, TEST_GENERAL);
        spoil(&p, &rng, 16, NEAR_THE_TARGET);
        options.seed = 1;
        const rigcal_status first = solve(&p, &options);
        ASSERT_STATUS(first, solve(&p, &options));
        options.seed = (uint32_t)(n + 2);
        differ += first != solve(&p, &options);
    }
    TEST_ASSERT_GREATER_THAN_INT(0, differ);
}

/* The search ends when its units are spent, with the best pose so far or with none. */
static void test_a_search_ends_after_the_units_that_it_may_spend(void)
{
    test_rng rng = test_seed(14);
    rigcal_robust_options options;
    problem p;
    int found = 0;

    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    for (int n = 0; n < TEST_TRIALS(40); n++) {
        rigcal_robust_solver solver;
        int32_t units = 0;

        make(&p, &rng, 20, TEST_GENERAL);
        spoil(&p, &rng, 14, IN_THE_IMAGE);
        options.max_units = 1;
        ASSERT_STATUS(RIGCAL_ERR_NO_CONSENSUS, solve(&p, &options));
        options.max_units = 100;
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_robust_begin(&solver, p.inliers, NULL,
                                          &VIEW(&p.camera, p.o, NULL, 20), &options));
        for (units = 0; rigcal_robust_step(&solver, 1) == RIGCAL_RUNNING; units++) {
        }
        TEST_ASSERT_GREATER_OR_EQUAL_INT(99, units);
        TEST_ASSERT_LESS_OR_EQUAL_INT(50, solver.tried); /* each takes two units at least */
        options.max_units = 100000;
        found += solve(&p, &options) >= 0 && is_right(&p);
    }
    TEST_ASSERT_GREATER_OR_EQUAL_INT(TEST_TRIALS(40) * 9 / 10, found);
}

enum { TRIPLES = 10 * 9 * 8 / 6 };

/* Follows a search of ten wrong points, and checks the triples that it tries: all of them
 * once, if as many samples may be drawn. The first is (0, 1, 2); the number of the next one
 * is that many further on, in the order of a dictionary, and again from 0. */
static void assert_each_is_tried_once(int32_t samples)
{
    static uint8_t tried[10][10][10];
    test_rng rng = test_seed(15);
    rigcal_robust_options options;
    rigcal_robust_solver solver;
    problem p;
    int32_t before = -1, expected[3];

    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    options.samples = samples;
    memset(tried, 0, sizeof tried);
    make(&p, &rng, 10, TEST_GENERAL);
    spoil(&p, &rng, 10, IN_THE_IMAGE);
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_robust_begin(&solver, p.inliers, NULL,
                                      &VIEW(&p.camera, p.o, NULL, 10), &options));
    do {
        if (solver.tried != before && solver.tried < TRIPLES) {
            const int32_t *const s = solver.sample;
            before = solver.tried;
            rc_sample_ranked(expected, 10, before * rc_sample_stride(TRIPLES) % TRIPLES);
            TEST_ASSERT_EQUAL_INT32_ARRAY(expected, s, 3);
            TEST_ASSERT_TRUE(0 <= s[0] && s[0] < s[1] && s[1] < s[2] && s[2] < 10);
            TEST_ASSERT_EQUAL_INT(0, tried[s[0]][s[1]][s[2]]++);
        }
    } while (rigcal_robust_step(&solver, 1) == RIGCAL_RUNNING);
    TEST_ASSERT_EQUAL_INT(TRIPLES, solver.tried);
    TEST_ASSERT_EQUAL_INT(TRIPLES - 1, before);
}

static void test_all_triples_are_tried_once(void)
{
    assert_each_is_tried_once(10000);
    assert_each_is_tried_once(TRIPLES);
}

/* With one sample fewer than there are triples they are random: those that the generator
 * gives one after the other, from the seed on. */
static void test_random_triples_are_tried_in_the_order_drawn(void)
{
    test_rng rng = test_seed(15);
    rigcal_robust_options options;
    rigcal_robust_solver solver;
    problem p;

    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    options.samples = TRIPLES - 1;
    make(&p, &rng, 10, TEST_GENERAL);
    spoil(&p, &rng, 10, IN_THE_IMAGE);
    for (uint32_t seed = 0; seed < 3; seed++) {
        uint32_t random = seed == 0 ? UINT32_C(0x9e3779b9) : seed;
        int32_t before = -1, expected[3] = {0, 0, 0};

        options.seed = seed;
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_robust_begin(&solver, p.inliers, NULL,
                                          &VIEW(&p.camera, p.o, NULL, 10), &options));
        do {
            if (solver.tried != before && solver.tried < TRIPLES - 1) {
                rc_sample_random(expected, &random, 10);
                before = solver.tried;
                TEST_ASSERT_EQUAL_INT32_ARRAY(expected, solver.sample, 3);
            }
        } while (rigcal_robust_step(&solver, 1) == RIGCAL_RUNNING);
        TEST_ASSERT_EQUAL_INT(TRIPLES - 1, solver.tried);
        TEST_ASSERT_EQUAL_INT(TRIPLES - 2, before);
    }
}

/* Where the marks of the best pose do not change, its points are solved at once: one unit
 * chooses them, those of rigcal_pose_step solve them, one looks at the pose, and one at its
 * misfit. */
static void test_points_that_stay_the_same_are_solved_at_once(void)
{
    test_rng rng = test_seed(21);
    rigcal_robust_solver solver;
    rigcal_pose_solver plain;
    problem p;
    int32_t units = 0, own = 0;

    make(&p, &rng, 12, TEST_GENERAL);
    test_observations(p.o, &p.scene, &p.camera); /* without noise */
    const rigcal_view view = VIEW(&p.camera, p.o, NULL, 12);
    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_begin(&solver, p.inliers, NULL, &view, NULL));
    while (solver.tried < solver.wanted) {
        ASSERT_STATUS(RIGCAL_RUNNING, rigcal_robust_step(&solver, 1));
    }
    do {
        units++;
    } while (rigcal_robust_step(&solver, 1) == RIGCAL_RUNNING);
    ASSERT_STATUS(RIGCAL_OK, rigcal_pose_begin(&plain, NULL, &view, NULL));
    do {
        own++;
    } while (rigcal_pose_step(&plain, 1) == RIGCAL_RUNNING);
    TEST_ASSERT_EQUAL_INT32(own + 3, units);
    TEST_ASSERT_EQUAL_INT(12, counted(&p));
}

/* ---- the verdict ----------------------------------------------------------- */

/* A pose that was found, for points as the solver has centred them. */
static rigcal_transform centred(const rigcal_robust_solver *s, const rigcal_pose *pose)
{
    rigcal_transform T = pose->cam_from_world;
    double R[9], t[3], origin[3], moved[3];

    test_transform_parts(R, t, &T);
    test_to_double(origin, s->points.origin, 3);
    test_apply(moved, R, origin, t);
    test_to_real(T.t, moved, 3);
    return T;
}

/* Whether the rival of the search is as good to within 0.7 points, is none of the poses
 * found, and agrees with other points. */
static int has_rival(const rigcal_robust_solver *s, const problem *p, int *changed)
{
    uint8_t marks[N_MAX];

    const double limit = pow(D(s->threshold_px), 2);

    if (!(D(s->rival_cost) < D(s->cost) + 0.7 * limit)) {
        return 0;
    }
    for (size_t i = 0; i < p->n_found; i++) {
        const rigcal_transform T = centred(s, &p->poses[i]);
        if (!rc_agree_differ(&s->rival, &T, RC(0.05))) {
            return 0;
        }
    }
    memcpy(marks, p->inliers, sizeof marks);
    *changed = (int)rc_agree_mark(marks, NULL, &s->points, &s->rival, RC(limit));
    return *changed > 0;
}

/* Right and wrong points, near the others, with more or less noise. */
static void make_doubtful(problem *p, int trial)
{
    test_rng rng = test_seed(5000 + (uint64_t)trial);
    const int n = 6 + trial % 7 + (trial / 5 % 2 ? 4 : 0);

    make(p, &rng, n, (test_shape)(trial % 3));
    for (int i = 0; i < 2 * n; i++) {
        p->o[i / 2].uv[i % 2] +=
            RC((trial % 5) * (trial / 5 % 2 ? 3 : 0.3) * test_normal(&rng));
    }
    spoil(p, &rng,
          trial % 4 == 0   ? n
          : trial % 4 == 1 ? 0
          : trial % 4 == 2 ? 2
                           : n / 2,
          NEAR_THE_TARGET);
}

/* (E): there is no consensus if chance expects 0.3 such poses or more. There is a caveat if
 * it expects 5e-5 over the fourth power of the misfit, if there is a rival, or if fewer
 * than 6 points agree. Each limit has scenes on both its sides, within a factor of two. */
static void test_the_verdict_is_that_of_chance_and_of_the_rival(void)
{
    int near_none[2] = {0, 0}, near_doubt[2] = {0, 0}, of_rival[3] = {0, 0, 0};
    rigcal_robust_options options;
    int n_small = 0;

    TEST_ON_HOST_ONLY("each limit wants scenes");
    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    for (int trial = 0; trial < 6000; trial++) {
        rigcal_robust_solver s;
        problem p;
        int changed = -1;

        make_doubtful(&p, trial);
        options.threshold_px = RC(trial / 5 % 2 ? 25 : 3);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_robust_begin(&s, p.inliers, NULL,
                                          &VIEW(&p.camera, p.o, NULL, (size_t)p.n), NULL));
        while (rigcal_robust_step(&s, 1000) == RIGCAL_RUNNING) {
        }
        const rigcal_status status =
            rigcal_robust_result(p.poses, RIGCAL_POSES_MAX, &p.n_found, &p.n_inliers, &s);
        if (s.failure < 0) {
            ASSERT_STATUS((rigcal_status)s.failure, status);
            continue;
        }
        const double chance = D(s.by_chance);
        near_none[chance >= 0.3] += chance > 0.15 && chance < 0.6;
        TEST_ASSERT_EQUAL_INT(chance >= 0.3, status == RIGCAL_ERR_NO_CONSENSUS);
        if (status < 0) {
            continue;
        }
        const rigcal_transform best = centred(&s, &p.poses[0]);
        const double misfit = D(rc_agree_misfit(&s.points, &best));
        const double doubt = chance * pow(misfit, 4);
        n_small += p.n_inliers >= 6 && !(doubt >= 5e-5) && chance * pow(0.2, 4) >= 5e-5;
        const int is_rival = doubt < 5e-5 && has_rival(&s, &p, &changed);
        near_doubt[doubt >= 5e-5] += doubt > 2.5e-5 && doubt < 1e-4;
        of_rival[changed < 2 ? changed + 1 : 0] += changed < 2;
        if (fabs(doubt - 5e-5) > 1e-8) { /* the test computes with more digits */
            TEST_ASSERT_EQUAL_INT(p.n_inliers < 6 || doubt >= 5e-5 || is_rival,
                                  status == RIGCAL_FEW_AGREE);
        }
    }
    for (int k = 0; k < 2; k++) {
        TEST_ASSERT_TRUE(near_none[k] > 5 && near_doubt[k] > 5);
        TEST_ASSERT_TRUE(n_small > 2);         /* much by chance, but little misfit */
        TEST_ASSERT_TRUE(of_rival[1 + k] > 5); /* the same points, and one other point */
    }
}

/* Half of the points, or fewer than half of them, agree. */
static void test_fewer_than_half_is_told(void)
{
    for (int agree = 9; agree <= 11; agree++) {
        test_rng rng = test_seed(23);
        problem p;

        make(&p, &rng, 20, TEST_GENERAL);
        test_observations(p.o, &p.scene, &p.camera);
        for (int i = agree; i < 20; i++) {
            p.o[i].uv[0] += RC(100 + 17 * (i - agree));
            p.o[i].uv[1] += RC(i % 3 * 60 - 60);
        }
        ASSERT_STATUS(agree < 10 ? RIGCAL_MOST_DISAGREE : RIGCAL_OK, solve(&p, NULL));
        TEST_ASSERT_EQUAL_INT(agree, p.n_inliers);
    }
}

/* ---- two targets ----------------------------------------------------------- */

/* Half of the points are seen at the pose of the scene, the other half at another. Nothing
 * tells which is right: the status says it, and the marks are those of the pose
 * returned. */
static void test_of_two_poses_that_fit_as_well_neither_is_sure(void)
{
    test_rng rng = test_seed(22);
    int n_doubtful = 0;

    for (int trial = 0; trial < TEST_TRIALS(40); trial++) {
        double turn[9], R[9];
        problem p;

        make(&p, &rng, 20, TEST_GENERAL);
        test_rotation(turn, 0.5, 0.3, -0.4);
        test_product(R, turn, p.scene.R);
        for (int i = 10; i < 20; i++) {
            double X_c[3], uv[2];

            test_apply(X_c, R, p.scene.X[i], p.scene.t);
            test_project_px(uv, &p.camera, X_c);
            for (int k = 0; k < 2; k++) {
                p.o[i].uv[k] = RC(uv[k] + NOISE * test_normal(&rng));
            }
        }
        const rigcal_status status = solve(&p, NULL);
        TEST_ASSERT_TRUE(status >= 0);
        TEST_ASSERT_TRUE(inliers_are_those_of_the_pose(&p, 3));
        TEST_ASSERT_EQUAL_INT(counted(&p), p.n_inliers);
        n_doubtful += status == RIGCAL_FEW_AGREE;
    }
    TEST_ASSERT_GREATER_THAN_INT(TEST_TRIALS(40) / 2, n_doubtful);
}

/* ---- thresholds near the noise, and below it ------------------------------ */

/* The set of points that agree changes again and again. The last pose is right. */
static void test_a_threshold_of_two_sigma_gives_the_right_pose(void)
{
    rigcal_robust_options options;
    problem p;

    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    options.threshold_px = RC(2 * NOISE);
    options.samples = 200;
    for (int trial = 0; trial < TEST_TRIALS(32); trial++) {
        test_rng rng = test_seed(900 + (uint64_t)(trial / 2));

        make(&p, &rng, N_MAX < 56 ? N_MAX : 44 + 12 * (trial % 2),
             trial % 4 < 2 ? TEST_PLANAR : TEST_GENERAL);
        TEST_ASSERT_TRUE(solve(&p, &options) >= 0);
        TEST_ASSERT_TRUE(is_right(&p));
        TEST_ASSERT_TRUE(2 * counted(&p) > p.n);
    }
}

/* The image has so many pixels, and the noise is so small, that rounding decides which
 * points agree. */
static rigcal_status solve_to_rounding(problem *p, int n, double threshold)
{
    const rigcal_real larger = 50;
    rigcal_robust_options options;
    rigcal_robust_solver solver;
    rigcal_real sigma[N_MAX];

    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    options.threshold_px = RC(threshold);
    options.samples = 200;
    p->camera.fx *= larger;
    p->camera.fy *= larger;
    p->camera.cx *= larger;
    p->camera.cy *= larger;
    p->camera.width *= 50;
    p->camera.height *= 50;
    for (int i = 0; i < n; i++) {
        p->o[i].uv[0] *= larger;
        p->o[i].uv[1] *= larger;
        sigma[i] = RC(TOL(1e-6, 1));
    }
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_robust_begin(&solver, p->inliers, NULL,
                                      &VIEW(&p->camera, p->o, sigma, (size_t)n), &options));
    while (rigcal_robust_step(&solver, 1) == RIGCAL_RUNNING) {
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(9, solver.rounds); /* searches, as the header says */
    return rigcal_robust_result(p->poses, RIGCAL_POSES_MAX, &p->n_found, &p->n_inliers,
                                &solver);
}

static void test_a_threshold_below_rounding_has_no_consensus(void)
{
    test_rng rng = test_seed(16);
    problem p;

    for (int trial = 0; trial < TEST_TRIALS(20); trial++) {
        make(&p, &rng, 6, TEST_GENERAL);
        ASSERT_STATUS(RIGCAL_ERR_NO_CONSENSUS, solve_to_rounding(&p, 6, 1e-6));
    }
}

/* Where the last bits decide, the marks change with every pose. The search ends all the
 * same. With a threshold 30 times as wide all points agree. */
static void test_marks_that_rounding_decides_end(void)
{
    for (int trial = 0; trial < TEST_TRIALS(20); trial++) {
        for (int is_wide = 0; is_wide < 2; is_wide++) {
            test_rng rng = test_seed(900 + (uint64_t)trial);
            problem p;

            make(&p, &rng, 20, TEST_GENERAL);
            test_observations(p.o, &p.scene, &p.camera); /* without noise */
            const rigcal_status status =
                solve_to_rounding(&p, 20, TOL(3e-6, 1e-3) * (is_wide ? 30 : 1));
            TEST_ASSERT_TRUE(status >= 0 ||
                             (!is_wide && status == RIGCAL_ERR_NO_CONSENSUS));
            if (status >= 0) {
                TEST_ASSERT_TRUE(least_error(&p, p.poses, p.n_found) < TOL(1e-9, 1e-3));
                TEST_ASSERT_TRUE(!is_wide || p.n_inliers == 20);
                TEST_ASSERT_EQUAL_UINT64(counted(&p), p.n_inliers);
            }
        }
    }
}

/* If the points that agree have no pose of their own, the status says why: it is that of
 * these points alone. */
static void test_what_agrees_may_have_no_pose(void)
{
    rigcal_robust_options options;
    problem p;

    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    options.threshold_px = 40;
    options.samples = 200;
    for (int trial = 0; trial < TEST_TRIALS(20); trial++) {
        test_rng rng = test_seed(900 + (uint64_t)trial);

        make(&p, &rng, 9, TEST_PLANAR);
        spoil(&p, &rng, 6, IN_THE_IMAGE);
        const rigcal_status status = solve(&p, &options);
        if (status < 0 && status != RIGCAL_ERR_NO_CONSENSUS) {
            rigcal_observation agreeing[9];
            size_t n = 0;

            for (int i = 0; i < 9; i++) {
                if (p.inliers[i] != 0) {
                    agreeing[n++] = p.o[i];
                }
            }
            ASSERT_STATUS(status,
                          rigcal_pose_solve(p.poses, RIGCAL_POSES_MAX, &p.n_found, NULL,
                                            &VIEW(&p.camera, agreeing, NULL, n), NULL));
        }
    }
}

/* ---- what is refused ------------------------------------------------------- */

static void test_points_on_a_line_are_refused(void)
{
    test_rng rng = test_seed(17);
    problem p;

    make(&p, &rng, 6, TEST_GENERAL);
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < 3; k++) {
            p.o[i].X_w[k] = RC(i * (k + 1));
        }
    }
    ASSERT_STATUS(RIGCAL_ERR_COLLINEAR, solve(&p, NULL));
}

static void test_options_out_of_range_are_refused(void)
{
    test_rng rng = test_seed(18);
    rigcal_robust_options options;
    problem p;

    make(&p, &rng, 6, TEST_GENERAL);
    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    options.threshold_px = -1;
    ASSERT_STATUS(RIGCAL_ERR_RANGE, solve(&p, &options));
    options.sigma_px = RC(NAN); /* a number that is none comes first */
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, solve(&p, &options));
    options.threshold_px = 1;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, solve(&p, &options));
}

/* Nothing is written, by neither function. */
static void test_four_points_or_room_for_no_pose_are_refused(void)
{
    test_rng rng = test_seed(25);
    rigcal_robust_solver solver;
    size_t n_found, n_inliers;
    uint8_t inliers[8];
    rigcal_pose pose;
    problem p;

    make(&p, &rng, 8, TEST_GENERAL);
    const rigcal_view view = VIEW(&p.camera, p.o, NULL, 8);
    FILL(n_found);
    FILL(n_inliers);
    FILL(inliers);
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, pose,
                   rigcal_robust_solve(&pose, 1, &n_found, inliers, &n_inliers, NULL,
                                       &VIEW(&p.camera, p.o, NULL, 4), NULL));
    ASSERT_REFUSED(
        RIGCAL_ERR_RANGE, pose,
        rigcal_robust_solve(&pose, 0, &n_found, inliers, &n_inliers, NULL, &view, NULL));
    ASSERT_UNTOUCHED(inliers);
    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_begin(&solver, inliers, NULL, &view, NULL));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, pose, /* before the search is looked at */
                   rigcal_robust_result(&pose, 0, &n_found, &n_inliers, &solver));
    ASSERT_REFUSED(RIGCAL_ERR_STATE, pose,
                   rigcal_robust_result(&pose, 1, &n_found, &n_inliers, &solver));
    while (rigcal_robust_step(&solver, 1000) == RIGCAL_RUNNING) {
    }
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, pose,
                   rigcal_robust_result(&pose, 0, &n_found, &n_inliers, &solver));
    ASSERT_UNTOUCHED(n_found);
    ASSERT_UNTOUCHED(n_inliers);
    TEST_ASSERT_TRUE(rigcal_robust_result(&pose, 1, &n_found, &n_inliers, &solver) >= 0);
    TEST_ASSERT_EQUAL(1, n_found);
    TEST_ASSERT_TRUE(/* five points are enough */
                     rigcal_robust_solve(&pose, 1, &n_found, inliers, &n_inliers, NULL,
                                         &VIEW(&p.camera, p.o, NULL, 5), NULL) >= 0);
}

/* Each pointer in turn. Only that of the observation at fault, and options, may be
 * missing. */
static void test_each_pointer_must_be_there(void)
{
    test_rng rng = test_seed(31);
    rigcal_robust_solver solver;
    size_t n_found, n_inliers;
    uint8_t inliers[8];
    rigcal_pose pose;
    problem p;

    make(&p, &rng, 8, TEST_GENERAL);
    const rigcal_view view = VIEW(&p.camera, p.o, NULL, 8);
    for (int none = 0; none < 5; none++) {
        rigcal_pose *const to = none == 0 ? NULL : &pose;
        size_t *const found = none == 1 ? NULL : &n_found;
        size_t *const count = none == 2 ? NULL : &n_inliers;
        uint8_t *const marks = none == 3 ? NULL : inliers;
        const rigcal_view *const of = none == 4 ? NULL : &view;

        ASSERT_STATUS(RIGCAL_ERR_NULL,
                      rigcal_robust_solve(to, 1, found, marks, count, NULL, of, NULL));
        if (none < 3) {
            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_robust_begin(&solver, inliers, NULL, &view, NULL));
            ASSERT_STATUS(RIGCAL_ERR_NULL, /* before the search is looked at */
                          rigcal_robust_result(to, 1, found, count, &solver));
            while (rigcal_robust_step(&solver, 1000) == RIGCAL_RUNNING) {
            }
            ASSERT_STATUS(RIGCAL_ERR_NULL,
                          rigcal_robust_result(to, 1, found, count, &solver));
        } else {
            ASSERT_STATUS(RIGCAL_ERR_NULL,
                          rigcal_robust_begin(&solver, marks, NULL, of, NULL));
        }
    }
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_robust_result(&pose, 1, &n_found, &n_inliers, NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_robust_begin(NULL, inliers, NULL, &view, NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_robust_step(NULL, 1));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_robust_step(&solver, 0));
}

/* The pose is that of the points marked, though the threshold is so near the noise that the
 * marks change again and again; and the marks are those of the pose. */
static void test_the_pose_is_that_of_the_points_marked(void)
{
    rigcal_robust_options options;
    int other = 0;

    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    options.threshold_px = RC(2 * NOISE);
    options.samples = 200;
    for (int trial = 0; trial < TEST_TRIALS(60); trial++) {
        test_rng rng = test_seed(700 + (uint64_t)trial);
        rigcal_observation marked[N_MAX];
        rigcal_pose plain;
        size_t n = 0, n_found;
        problem p;

        make(&p, &rng, 20, TEST_GENERAL);
        if (solve(&p, &options) < 0) {
            continue;
        }
        for (int i = 0; i < p.n; i++) {
            marked[n] = p.o[i];
            n += p.inliers[i];
        }
        TEST_ASSERT_TRUE(rigcal_pose_solve(&plain, 1, &n_found, NULL,
                                           &VIEW(&p.camera, marked, NULL, n), NULL) >= 0);
        for (int k = 0; k < 3; k++) {
            other += fabs(D(plain.cam_from_world.t[k]) -
                          D(p.poses[0].cam_from_world.t[k])) > TOL(1e-9, 1e-3);
        }
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(3, other); /* one search may end before it settles */
}

/* Four of five points agree, too few to improve a pose. What is in `inliers` before the
 * search does not matter, not even if it is the result. */
static void test_what_was_in_the_marks_does_not_matter(void)
{
    test_rng rng = test_seed(26);
    int32_t units[2] = {0, 0};

    for (int trial = 0; trial < TEST_TRIALS(20); trial++) {
        problem p;

        make(&p, &rng, 5, TEST_GENERAL);
        test_observations(p.o, &p.scene, &p.camera);
        p.o[4].uv[0] += 150;
        for (int way = 0; way < 2; way++) {
            rigcal_robust_solver solver;

            for (int i = 0; i < 5; i++) {
                p.inliers[i] = way && i < 4;
            }
            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_robust_begin(&solver, p.inliers, NULL,
                                              &VIEW(&p.camera, p.o, NULL, 5), NULL));
            for (units[way] = 1; rigcal_robust_step(&solver, 1) == RIGCAL_RUNNING;) {
                units[way]++;
            }
        }
        TEST_ASSERT_EQUAL_INT32(units[0], units[1]);
    }
}

/* The noise that is stated also judges the pose of the points that agree. */
static void test_the_noise_judges_the_pose_too(void)
{
    test_rng rng = test_seed(27);
    rigcal_robust_options options;
    rigcal_pose_options plain;

    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    ASSERT_STATUS(RIGCAL_OK, rigcal_pose_defaults(&plain));
    for (int trial = 0; trial < TEST_TRIALS(20); trial++) {
        rigcal_pose poses[RIGCAL_POSES_MAX];
        size_t n_found;
        problem p;

        options.sigma_px = plain.sigma_px = RC(trial % 2 ? 0.05 : 0.5);
        options.threshold_px = 3;
        make(&p, &rng, 12, trial % 4 < 2 ? TEST_PLANAR : TEST_GENERAL);
        const rigcal_status status = solve(&p, &options);
        if (status < 0 || status == RIGCAL_FEW_AGREE || p.n_inliers < 12) {
            continue;
        }
        ASSERT_STATUS(rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL,
                                        &VIEW(&p.camera, p.o, NULL, 12), &plain),
                      status);
        TEST_ASSERT_EQUAL_size_t(n_found, p.n_found);
        for (size_t i = 0; i < n_found; i++) {
            ASSERT_NEAR(D(poses[i].probability), p.poses[i].probability, 0);
        }
        TEST_ASSERT_EQUAL_INT(trial % 2, status == RIGCAL_POOR_FIT);
    }
}

/* The numbers of the header. */
static void test_options_have_their_defaults_and_their_ranges(void)
{
    test_rng rng = test_seed(28);
    rigcal_robust_options options;
    problem p;

    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_robust_defaults(NULL));
    FILL(options);
    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    ASSERT_NEAR(0, options.threshold_px, 0);
    ASSERT_NEAR(0, options.sigma_px, 0);
    TEST_ASSERT_EQUAL_INT32(10000, options.samples);
    TEST_ASSERT_EQUAL_UINT32(1, options.seed);
    TEST_ASSERT_EQUAL_INT32(100000, options.max_units);
    make(&p, &rng, 6, TEST_GENERAL);
    for (int way = 0; way < 6; way++) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
        options.samples = way < 3 ? 100000 : way == 3 ? 100001 : way == 4 ? 0 : 1;
        options.max_units = way == 5 ? 0 : way == 0 ? INT32_MAX : 1;
        const rigcal_status status = solve(&p, &options);
        TEST_ASSERT_EQUAL_INT(way > 2, status == RIGCAL_ERR_RANGE);
        TEST_ASSERT_TRUE(way > 0 || status >= 0);
    }
}

static void test_a_solver_that_was_not_begun_is_refused(void)
{
    rigcal_robust_solver solver;

    memset(&solver, 0, sizeof solver);
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_robust_step(&solver, 1));
    memset(&solver, 0x7f, sizeof solver);
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_robust_step(&solver, 1));
}

/* Seed 0 would draw the same triple for ever. */
static void test_seed_0_is_a_seed(void)
{
    test_rng rng = test_seed(19);
    rigcal_robust_options options;
    problem p;

    make(&p, &rng, N_MAX, TEST_GENERAL); /* too many triples to try all */
    spoil(&p, &rng, N_MAX / 2, NEAR_THE_TARGET);
    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    options.samples = 1000;
    options.seed = 0;
    TEST_ASSERT_TRUE(solve(&p, &options) >= 0);
    TEST_ASSERT_TRUE(is_right(&p));
}

/* ---- the cost of a search -------------------------------------------------- */

/* Whatever the unit at which it must end, a search returns the best pose so far. */
static void test_a_search_may_end_at_any_unit(void)
{
    rigcal_robust_options options;
    problem p;
    int right = 0;

    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    for (int units = 1; units < 40; units++) {
        test_rng rng = test_seed(20);

        make(&p, &rng, 20, TEST_GENERAL);
        options.max_units = units;
        const rigcal_status status = solve(&p, &options);
        TEST_ASSERT_TRUE(status >= 0 || status == RIGCAL_ERR_NO_CONSENSUS);
        TEST_ASSERT_TRUE(status < 0 || is_right(&p));
        TEST_ASSERT_TRUE(status >= 0 || right == 0);
        right += status >= 0;
    }
    TEST_ASSERT_TRUE(right > 20);
}

/* A unit of the search is the ray of one point, or those of all three points of a pinhole;
 * then a pose is scored. */
static void test_a_unit_is_one_ray_or_those_of_a_pinhole(void)
{
    for (int with_lens = 0; with_lens < 2; with_lens++) {
        test_rng rng = test_seed(29);
        rigcal_robust_solver solver;
        problem p;

        make(&p, &rng, 8, TEST_GENERAL);
        p.camera.k1 = RC(with_lens ? -0.01 : 0);
        ASSERT_STATUS(RIGCAL_OK, rigcal_robust_begin(&solver, p.inliers, NULL,
                                                     &VIEW(&p.camera, p.o, NULL, 8), NULL));
        for (int unit = 1; unit < (with_lens ? 3 : 1); unit++) {
            ASSERT_STATUS(RIGCAL_RUNNING, rigcal_robust_step(&solver, 1));
            TEST_ASSERT_EQUAL_INT32(unit, solver.next);
            TEST_ASSERT_EQUAL_INT32(0, solver.n_poses);
        }
        ASSERT_STATUS(RIGCAL_RUNNING, rigcal_robust_step(&solver, 1));
        TEST_ASSERT_EQUAL_INT32(0, solver.next);
        TEST_ASSERT_TRUE(solver.n_poses > 0);
    }
}

/* Counts the steps of one unit that a search takes. */
static int steps_of(rigcal_robust_solver *solver, problem *p, int n, int32_t max_units)
{
    rigcal_robust_options options;
    int steps = 1;

    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    options.max_units = max_units;
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_robust_begin(solver, p->inliers, NULL,
                                      &VIEW(&p->camera, p->o, NULL, n), &options));
    while (rigcal_robust_step(solver, 1) == RIGCAL_RUNNING) {
        steps++;
    }
    return steps;
}

/* Triples alone count against the most units: where a search has ended within them, it
 * takes as many steps whatever is left, with the ray of each point at last once. */
static void test_units_that_a_search_has_left_change_nothing(void)
{
    test_rng rng = test_seed(31);
    rigcal_robust_solver solver;
    problem p;

    make(&p, &rng, 12, TEST_GENERAL);
    p.camera.k1 = RC(-0.01);
    test_observations(p.o, &p.scene, &p.camera);
    spoil(&p, &rng, 3, IN_THE_IMAGE);
    const int steps = steps_of(&solver, &p, 12, 100000);
    const int32_t spent = solver.units;

    TEST_ASSERT_TRUE(spent > 0 && spent + 12 < steps);
    for (int32_t left = 0; left <= 20; left++) {
        TEST_ASSERT_EQUAL_INT(steps, steps_of(&solver, &p, 12, spent + left));
        TEST_ASSERT_EQUAL_INT32(spent, solver.units);
    }
}

/* The most units, one after the other, that a search spends on one pose that it scored. */
static int most_units_of_a_pose(problem *p)
{
    rigcal_robust_solver solver;
    int most = 0, units = 0;
    int32_t tried = -1, next = -1;

    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_robust_begin(&solver, p->inliers, NULL,
                                      &VIEW(&p->camera, p->o, NULL, (size_t)p->n), NULL));
    while (rigcal_robust_step(&solver, 1) == RIGCAL_RUNNING &&
           solver.tried < solver.wanted) {
        units = solver.tried == tried && solver.next == next ? units + 1 : 0;
        tried = solver.tried;
        next = solver.next;
        most = units > most ? units : most;
    }
    return most;
}

/* A good pose takes at most 20 units, and some take that many: four times the choice of
 * points, three evaluations, and the score. A pose with which four points agree is not
 * improved, one with five is. */
static void test_a_good_pose_takes_up_to_20_units(void)
{
    int most = 0;

    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        test_rng rng = test_seed(3000 + (uint64_t)trial);
        problem p;

        make(&p, &rng, 20, TEST_GENERAL);
        for (int i = 0; i < 40; i++) {
            p.o[i / 2].uv[i % 2] += RC(1.5 * test_normal(&rng));
        }
        const int units = most_units_of_a_pose(&p);
        most = units > most ? units : most;
        for (int agree = 4; agree <= 5; agree++) {
            make(&p, &rng, 6, TEST_GENERAL);
            test_observations(p.o, &p.scene, &p.camera);
            for (int i = agree; i < 6; i++) {
                p.o[i].uv[0] += RC(400 + 200 * (i - agree));
                p.o[i].uv[1] -= RC(300 * (i - agree));
            }
            TEST_ASSERT_EQUAL_INT(agree == 5, most_units_of_a_pose(&p) > 1);
        }
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(20, most);
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || most == 20);
}

/* A search that must end while it improves a good pose returns that pose. 14 of 20 points
 * are wrong, so that no pose before it is good. */
static void test_a_pose_that_is_being_improved_counts(void)
{
    rigcal_robust_options options;

    TEST_ON_HOST_ONLY("a search for each unit");
    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    for (int trial = 0; trial < 10; trial++) {
        test_rng rng = test_seed(30 + (uint64_t)trial);
        rigcal_robust_solver solver;
        problem p;

        make(&p, &rng, 20, TEST_GENERAL);
        test_observations(p.o, &p.scene, &p.camera); /* without noise */
        spoil(&p, &rng, 14, IN_THE_IMAGE);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_robust_begin(&solver, p.inliers, NULL,
                                          &VIEW(&p.camera, p.o, NULL, 20), NULL));
        options.max_units = 0;
        do { /* until the right points are chosen for a pose */
            ASSERT_STATUS(RIGCAL_RUNNING, rigcal_robust_step(&solver, 1));
            options.max_units++;
        } while (counted(&p) < 6 || memcmp(p.inliers, p.right, 6) != 0);
        ASSERT_STATUS(RIGCAL_MOST_DISAGREE, solve(&p, &options));
        TEST_ASSERT_TRUE(is_right(&p));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_three_in_ten_may_be_wrong);
    RUN_TEST(test_none_need_be_wrong);
    RUN_TEST(test_all_wrong_is_not_believed);
    RUN_TEST(test_few_points_are_told_to_be_few);
    RUN_TEST(test_points_may_be_given_twice);
    RUN_TEST(test_a_pixel_without_a_ray_is_a_wrong_one);
    RUN_TEST(test_relative_noise_widens_the_threshold);
    RUN_TEST(test_the_threshold_is_that_stated);
    RUN_TEST(test_budgets_change_no_bit);
    RUN_TEST(test_units_that_a_search_has_left_change_nothing);
    RUN_TEST(test_seed_and_samples_count);
    RUN_TEST(test_six_of_twenty_are_believed);
    RUN_TEST(test_nine_in_ten_may_be_wrong);
    RUN_TEST(test_a_search_ends_after_the_units_that_it_may_spend);
    RUN_TEST(test_all_triples_are_tried_once);
    RUN_TEST(test_random_triples_are_tried_in_the_order_drawn);
    RUN_TEST(test_points_that_stay_the_same_are_solved_at_once);
    RUN_TEST(test_the_verdict_is_that_of_chance_and_of_the_rival);
    RUN_TEST(test_fewer_than_half_is_told);
    RUN_TEST(test_of_two_poses_that_fit_as_well_neither_is_sure);
    RUN_TEST(test_a_threshold_may_be_less_than_a_pixel);
    RUN_TEST(test_a_point_agrees_up_to_the_threshold);
    RUN_TEST(test_with_room_for_one_pose_the_best_is_written);
    RUN_TEST(test_as_many_triples_are_tried_as_the_chance_to_miss_asks);
    RUN_TEST(test_a_threshold_of_two_sigma_gives_the_right_pose);
    RUN_TEST(test_a_threshold_below_rounding_has_no_consensus);
    RUN_TEST(test_marks_that_rounding_decides_end);
    RUN_TEST(test_what_agrees_may_have_no_pose);
    RUN_TEST(test_points_on_a_line_are_refused);
    RUN_TEST(test_options_out_of_range_are_refused);
    RUN_TEST(test_options_have_their_defaults_and_their_ranges);
    RUN_TEST(test_a_solver_that_was_not_begun_is_refused);
    RUN_TEST(test_four_points_or_room_for_no_pose_are_refused);
    RUN_TEST(test_each_pointer_must_be_there);
    RUN_TEST(test_the_pose_is_that_of_the_points_marked);
    RUN_TEST(test_what_was_in_the_marks_does_not_matter);
    RUN_TEST(test_the_noise_judges_the_pose_too);
    RUN_TEST(test_seed_0_is_a_seed);
    RUN_TEST(test_a_search_may_end_at_any_unit);
    RUN_TEST(test_a_unit_is_one_ray_or_those_of_a_pinhole);
    RUN_TEST(test_a_good_pose_takes_up_to_20_units);
    RUN_TEST(test_a_pose_that_is_being_improved_counts);
}
