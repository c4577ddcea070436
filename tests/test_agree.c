/* agree: compares sums and marks with a projection by the test's own arithmetic, and what
 * is expected by chance with random draws. */
#include "rc_agree.h"

#include <math.h>
#include <string.h>

#include "test_support.h"

enum { N = 20 };

#define LIMIT 9.0 /* px^2 */

typedef struct {
    test_scene scene;
    rigcal_camera camera;
    rigcal_observation o[N];
    rigcal_real sigma[N];
    rigcal_view view;
    rigcal_points points;
} problem;

/* Some points are wrong, one in five of them by much. */
static void make(problem *p, test_rng *rng, int with_lens, int with_sigma)
{
    rigcal_real uv_middle[2];
    int32_t at;

    p->camera = test_pinhole();
    if (with_lens) {
        p->camera.k1 = RC(-0.1);
        p->camera.p1 = RC(0.001);
    }
    test_scene_random(&p->scene, rng, N, TEST_GENERAL);
    test_observations(p->o, &p->scene, &p->camera);
    for (int i = 0; i < N; i++) {
        const double most = i % 5 == 0 ? 100 : 3;
        for (int k = 0; k < 2; k++) {
            p->o[i].uv[k] = RC(D(p->o[i].uv[k]) + test_uniform(rng, -most, most));
        }
        p->sigma[i] = RC(test_uniform(rng, 0.5, 2));
    }
    p->view = VIEW(&p->camera, p->o, with_sigma ? p->sigma : NULL, N);
    rc_points_of(&p->points, &p->view, NULL);
    ASSERT_STATUS(RIGCAL_OK, rc_points_survey(&p->points, uv_middle, &at));
}

/* The true pose with an error of turn and shift. */
static void pose_near(rigcal_transform *cam_from_points, const problem *p, test_rng *rng,
                      double most)
{
    double turn[9], R[9], t[3], X[3], q[3];

    test_rotation(turn, test_uniform(rng, -most, most), test_uniform(rng, -most, most),
                  test_uniform(rng, -most, most));
    test_product(R, turn, p->scene.R);
    test_to_double(X, p->points.origin, 3);
    memcpy(t, p->scene.t, sizeof t);
    test_apply(q, R, X, t);
    test_to_real(cam_from_points->R, R, 9);
    test_to_real(cam_from_points->t, q, 3);
}

static double distance2(const problem *p, const rigcal_transform *T, int i)
{
    double X[3], o[3], R[9], t[3], X_c[3], uv[2], sum = 0;

    test_to_double(X, p->o[i].X_w, 3);
    test_to_double(o, p->points.origin, 3);
    test_transform_parts(R, t, T);
    for (int k = 0; k < 3; k++) {
        X[k] -= o[k];
    }
    test_apply(X_c, R, X, t);
    if (X_c[2] <= 0) {
        return 1e300;
    }
    test_project_px(uv, &p->camera, X_c);
    for (int k = 0; k < 2; k++) {
        sum += pow(uv[k] - D(p->o[i].uv[k]), 2);
    }
    return p->view.sigma == NULL ? sum : sum / pow(D(p->sigma[i]), 2);
}

/* ---- sums and marks -------------------------------------------------------- */

static void test_the_sum_is_that_of_the_errors_and_their_limit(void)
{
    test_rng rng = test_seed(1);

    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        rigcal_transform T;
        rigcal_real sum;
        problem p;
        double exact = 0;
        size_t count = 0;

        make(&p, &rng, trial % 2, trial / 2 % 2);
        pose_near(&T, &p, &rng, trial % 3 == 2 ? 3 : 0.002);
        for (int i = 0; i < N; i++) {
            const double d2 = distance2(&p, &T, i);
            count += d2 <= LIMIT;
            exact += fmin(d2, LIMIT);
        }
        TEST_ASSERT_EQUAL_INT(count,
                              rc_agree_score(&sum, &p.points, &T, RC(LIMIT), RC_MAX));
        ASSERT_NEAR(exact, sum, TOL(1e-8, 0.1));
    }
}

static void test_a_point_behind_the_camera_disagrees(void)
{
    test_rng rng = test_seed(2);
    rigcal_transform T;
    rigcal_real sum;
    problem p;

    make(&p, &rng, 0, 0);
    pose_near(&T, &p, &rng, 0);
    for (int k = 0; k < 3; k++) { /* all pixels are as before */
        T.t[k] = -T.t[k];
    }
    for (int k = 0; k < 9; k++) {
        T.R[k] = -T.R[k];
    }
    TEST_ASSERT_EQUAL_INT(0, rc_agree_score(&sum, &p.points, &T, RC(LIMIT), RC_MAX));
    ASSERT_NEAR(N * LIMIT, sum, 0);
}

/* A sum that is given up early cannot have been the least. */
static void test_to_give_up_early_finds_the_same_best(void)
{
    test_rng rng = test_seed(3);

    for (int trial = 0; trial < TEST_TRIALS(40); trial++) {
        rigcal_real least = RC_MAX, least_whole = RC_MAX, sum;
        int best = -1, best_whole = -1;
        problem p;

        make(&p, &rng, trial % 2, 0);
        for (int k = 0; k < 30; k++) {
            rigcal_transform T;
            pose_near(&T, &p, &rng, 0.02);
            const size_t whole = rc_agree_score(&sum, &p.points, &T, RC(LIMIT), RC_MAX);
            if (sum < least_whole) {
                least_whole = sum;
                best_whole = k;
            }
            const size_t count = rc_agree_score(&sum, &p.points, &T, RC(LIMIT), least);
            TEST_ASSERT_LESS_OR_EQUAL_INT(whole, count);
            if (sum < least) {
                least = sum;
                best = k;
            }
        }
        TEST_ASSERT_EQUAL_INT(best_whole, best);
        ASSERT_NEAR(D(least_whole), least, 0);
    }
}

static void test_marks_and_bins_are_those_of_the_distances(void)
{
    test_rng rng = test_seed(4);

    for (int trial = 0; trial < TEST_TRIALS(40); trial++) {
        rc_agree_histogram off;
        uint8_t marks[N] = {0};
        rigcal_transform T;
        problem p;
        double sum = 0, binned = 0;
        size_t count = 0, in_bins = 0;

        make(&p, &rng, trial % 2, trial / 2 % 2);
        pose_near(&T, &p, &rng, 0.002);
        const size_t changed = rc_agree_mark(marks, &off, &p.points, &T, RC(LIMIT));
        for (int i = 0; i < N; i++) {
            const double d2 = distance2(&p, &T, i);
            TEST_ASSERT_EQUAL_INT(d2 <= LIMIT, marks[i]);
            count += marks[i];
            sum += d2 <= LIMIT ? d2 : 0;
        }
        for (int k = 0; k < RC_AGREE_BINS; k++) {
            in_bins += off.count[k];
            binned += D(off.sum[k]);
            TEST_ASSERT_TRUE(D(off.sum[k]) <= D(RC(off.count[k])) * LIMIT / pow(2, k));
        }
        TEST_ASSERT_EQUAL_INT(count, changed);
        TEST_ASSERT_EQUAL_INT(count, in_bins);
        ASSERT_NEAR(sum, RC(binned), TOL(1e-8, 0.1));
        TEST_ASSERT_EQUAL_INT(0, rc_agree_mark(marks, NULL, &p.points, &T, RC(LIMIT)));
    }
}

/* ---- chance ---------------------------------------------------------------- */

/* All of n points in a square of 100 px are wrong. Each triple has two poses, at which the
 * other points lie anywhere. Counts the triples with two more points whose squared
 * distances sum to at most `sum`. */
static void test_what_is_expected_is_the_mean_of_draws(void)
{
    enum { POINTS = 8, DRAWS = 4000 };
    const double most = 900, side = 100;
    test_rng rng = test_seed(5);
    rc_agree_histogram off = {{0}, {0}};
    double sets = 0, squares = 0;

    TEST_ON_HOST_ONLY("a mean of few draws says nothing");
    for (int draw = 0; draw < DRAWS; draw++) {
        double here = 0;
        for (int pose = 0; pose < 2 * 56; pose++) {
            double d2[POINTS - 3];
            for (int i = 0; i < POINTS - 3; i++) { /* the projection is in the middle of the
                                                      square */
                d2[i] = pow(test_uniform(&rng, -side / 2, side / 2), 2) +
                        pow(test_uniform(&rng, -side / 2, side / 2), 2);
                for (int k = 0; k < i; k++) {
                    here += d2[i] + d2[k] <= most;
                }
            }
        }
        sets += here;
        squares += here * here;
    }
    off.count[0] = 5;
    off.sum[0] = RC(most);
    const double mean = sets / DRAWS, noise = sqrt((squares / DRAWS - mean * mean) / DRAWS);
    const double expected = D(rc_agree_by_chance(&off, POINTS, RC(side * side), 0));
    /* there are n - 3 possible numbers of points; Stirling's factorial is off by 4 % */
    ASSERT_NEAR((POINTS - 3) * mean, RC(expected), 0.05 * expected + 5 * 5 * noise);
}

/* Six points are near and four are not so near. The six alone are less likely by chance. */
static void test_the_nearest_count_if_they_alone_are_rarer(void)
{
    rc_agree_histogram off = {{0}, {0}}, near = {{0}, {0}};
    const rigcal_real area = RC(1e4);

    off.count[8] = near.count[8] = 6;
    off.sum[8] = near.sum[8] = RC(0.1);
    off.count[0] = 4;
    off.sum[0] = RC(30);
    const double alone = D(rc_agree_by_chance(&near, 100, area, 0));
    ASSERT_NEAR(alone, rc_agree_by_chance(&off, 100, area, 0), 1e-6 * alone);
    off.count[0] = 0; /* three points are never unlikely */
    off.count[8] = 3;
    TEST_ASSERT_TRUE(D(rc_agree_by_chance(&off, 100, area, 0)) > 1e30);
}

/* All pixels are in one column: no area is left for chance, so that any points agree. */
static void test_without_an_area_all_is_chance(void)
{
    rc_agree_histogram off = {{0}, {0}};

    off.count[0] = 5;
    off.sum[0] = 1;
    /* 8 - 3 numbers of points; 2 poses of each of 56 triples; 10 pairs of 5 more points;
     * Stirling: 1 / sqrt(2 pi 2) */
    const double sets = 5.0 * 2 * 56 * 10 / sqrt(4 * TEST_PI);
    ASSERT_NEAR(sets, rc_agree_by_chance(&off, 8, 0, 0), 1e-5 * sets);
}

/* The square of the depth overflows. */
static void test_a_point_beyond_all_numbers_disagrees(void)
{
    test_rng rng = test_seed(6);
    rigcal_transform T;
    rigcal_real sum;
    problem p;

    make(&p, &rng, 0, 0);
    pose_near(&T, &p, &rng, 0);
    for (int k = 0; k < 3; k++) {
        T.t[k] = RC(k == 2 ? TOL(1e200, 1e30) : TOL(1e199, 1e29));
    }
    TEST_ASSERT_EQUAL_INT(0, rc_agree_score(&sum, &p.points, &T, RC(LIMIT), RC_MAX));
    ASSERT_NEAR(N * LIMIT, sum, 0);
}

/* Pixels that are exact in every number: the target's box is that of the pixels. */
static void test_a_target_in_its_place_has_no_misfit(void)
{
    rigcal_camera camera;
    rigcal_observation o[4];
    rigcal_points points;
    rigcal_real uv_middle[2];
    rigcal_transform T;
    int32_t at;

    memset(&camera, 0, sizeof camera);
    camera.fx = camera.fy = 64;
    camera.cx = camera.cy = 64;
    camera.width = camera.height = 128;
    memset(&T, 0, sizeof T);
    T.R[0] = T.R[4] = T.R[8] = 1;
    for (int i = 0; i < 4; i++) {
        o[i].X_w[0] = (i == 0) ? RC(-0.375) : (i % 2 == 0) ? RC(-0.25) : RC(0.25);
        o[i].X_w[1] = (i == 0) ? RC(-0.375) : (i < 2) ? RC(-0.25) : RC(0.25);
        o[i].X_w[2] = 1;
        o[i].uv[0] = 64 + 64 * o[i].X_w[0];
        o[i].uv[1] = 64 + 64 * o[i].X_w[1];
    }
    const rigcal_view view = VIEW(&camera, o, NULL, 4);
    rc_points_of(&points, &view, NULL);
    ASSERT_STATUS(RIGCAL_OK, rc_points_survey(&points, uv_middle, &at));
    for (int k = 0; k < 3; k++) {
        T.t[k] = points.origin[k];
    }
    ASSERT_NEAR(0, rc_agree_misfit(&points, &T), 0);
    /* Each box is 0.625 wide, and shares 0.6 of its width: 3/7 of the union. */
    T.t[0] += RC(0.25);
    ASSERT_NEAR(4.0 / 7, rc_agree_misfit(&points, &T), 1e-6);
}

/* In any unit of length the same points agree. One in the camera's centre never does. */
static void test_points_agree_in_any_unit_of_length(void)
{
    test_rng rng = test_seed(21);
    const rigcal_real unit = RC(TOL(1.0 / (1 << 30), 1.0 / 64));
    rigcal_real sum[2], uv_middle[2];
    size_t n[2];
    rigcal_transform T;
    int32_t at;
    problem p;

    make(&p, &rng, 0, 0);
    pose_near(&T, &p, &rng, 0);
    n[0] = rc_agree_score(&sum[0], &p.points, &T, RC(LIMIT), RC_MAX);
    for (int i = 0; i < N; i++) {
        for (int k = 0; k < 3; k++) {
            p.o[i].X_w[k] *= unit;
        }
    }
    rc_points_of(&p.points, &p.view, NULL);
    ASSERT_STATUS(RIGCAL_OK, rc_points_survey(&p.points, uv_middle, &at));
    for (int k = 0; k < 3; k++) {
        T.t[k] *= unit;
    }
    n[1] = rc_agree_score(&sum[1], &p.points, &T, RC(LIMIT), RC_MAX);
    TEST_ASSERT_EQUAL_size_t(n[0], n[1]);
    TEST_ASSERT_GREATER_THAN_size_t(4, n[1]);
    ASSERT_NEAR(sum[0], sum[1], TOL(1e-9, 1e-2) * D(sum[0]));

    for (int k = 0; k < 3; k++) { /* all points are in the centre */
        p.points.origin[k] = p.o[0].X_w[k];
        T.t[k] = 0;
    }
    for (int i = 0; i < N; i++) {
        memcpy(p.o[i].X_w, p.points.origin, sizeof p.o[i].X_w);
    }
    TEST_ASSERT_EQUAL_INT(0, rc_agree_score(&sum[0], &p.points, &T, RC(LIMIT), RC_MAX));
    ASSERT_NEAR(N * LIMIT, sum[0], TOL(1e-9, 1e-3));
}

TEST_MAIN()
{
    RUN_TEST(test_points_agree_in_any_unit_of_length);
    RUN_TEST(test_the_sum_is_that_of_the_errors_and_their_limit);
    RUN_TEST(test_a_point_behind_the_camera_disagrees);
    RUN_TEST(test_to_give_up_early_finds_the_same_best);
    RUN_TEST(test_marks_and_bins_are_those_of_the_distances);
    RUN_TEST(test_what_is_expected_is_the_mean_of_draws);
    RUN_TEST(test_the_nearest_count_if_they_alone_are_rarer);
    RUN_TEST(test_without_an_area_all_is_chance);
    RUN_TEST(test_a_point_beyond_all_numbers_disagrees);
    RUN_TEST(test_a_target_in_its_place_has_no_misfit);
}
