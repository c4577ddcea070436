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

/* ---- exact numbers --------------------------------------------------------- */

enum { EXACT = 8 };

/* A camera without turn, and points at a depth of 1. Every number is exact, so that limits
 * are met to the last bit. */
typedef struct {
    rigcal_camera camera;
    rigcal_observation o[EXACT];
    rigcal_real sigma[EXACT];
    rigcal_points points;
    rigcal_transform pose;
} exact;

static void make_exact(exact *e, int with_sigma)
{
    memset(e, 0, sizeof *e);
    e->camera.fx = 64;
    e->camera.fy = 32;
    e->camera.cx = 64;
    e->camera.cy = 16;
    e->camera.width = 128;
    e->camera.height = 64;
    e->pose.R[0] = e->pose.R[4] = e->pose.R[8] = 1;
    for (int i = 0; i < EXACT; i++) {
        e->o[i].X_w[0] = RC(i - 4) / 8;
        e->o[i].X_w[1] = RC(i % 3) / 4;
        e->o[i].X_w[2] = 1;
        e->o[i].uv[0] = 64 + 64 * e->o[i].X_w[0];
        e->o[i].uv[1] = 16 + 32 * e->o[i].X_w[1];
        e->sigma[i] = 2;
    }
    rc_points_of(&e->points, &VIEW(&e->camera, e->o, with_sigma ? e->sigma : NULL, EXACT),
                 NULL);
    rc_clear(e->points.origin, 3);
}

/* A lens that moves no point: its numerator and denominator are the same. */
static void with_lens(exact *e, int is_lens)
{
    e->camera.k1 = e->camera.k4 = RC(is_lens ? 0.125 : 0);
    e->points.is_pinhole = (uint8_t)!is_lens;
}

/* Squared distances of 16, 16, 17, 25, 8, 9, 2 and 0 px^2, of which 16 agree: the first
 * ones, and those in u or in v alone, meet the limit exactly; 8 and 2 the ends of bins. */
static void test_a_point_at_the_limit_agrees(void)
{
    static const double OFF[EXACT][2] = {{4, 0},  {0, -4}, {4, 1}, {0, 5},
                                         {-2, 2}, {3, 0},  {1, 1}, {0, 0}};
    static const uint8_t AGREE[EXACT] = {1, 1, 0, 0, 1, 1, 1, 1};

    for (int way = 0; way < 4; way++) { /* a pinhole or not; with sigma 2 or without */
        const double by = way / 2 ? 4 : 1;
        rc_agree_histogram off;
        uint8_t marks[EXACT];
        rigcal_real sum;
        exact e;

        make_exact(&e, way / 2);
        with_lens(&e, way % 2 == 0);
        for (int i = 0; i < EXACT; i++) {
            e.o[i].uv[0] += RC(OFF[i][0]);
            e.o[i].uv[1] += RC(OFF[i][1]);
            marks[i] = (uint8_t)(i % 2);
        }
        const rigcal_real limit = RC(16 / by);
        TEST_ASSERT_EQUAL_INT(6, rc_agree_score(&sum, &e.points, &e.pose, limit, RC_MAX));
        ASSERT_NEAR((16 + 16 + 16 + 16 + 8 + 9 + 2) / by, sum, 0);
        /* the loop ends as soon as the sum is enough */
        TEST_ASSERT_EQUAL_INT(
            2, rc_agree_score(&sum, &e.points, &e.pose, limit, RC(3 * 16 / by)));
        ASSERT_NEAR(3 * 16 / by, sum, 0);
        /* marks 0, 3, 4 and 6 change */
        TEST_ASSERT_EQUAL_INT(4, rc_agree_mark(marks, &off, &e.points, &e.pose, limit));
        TEST_ASSERT_EQUAL_MEMORY(AGREE, marks, sizeof marks);
        for (int k = 0; k < RC_AGREE_BINS; k++) {
            const int count = k == 0 ? 3 : k == 1 || k == 3 || k == 15;
            const double binned = k == 0 ? 16 + 16 + 9 : k == 1 ? 8 : k == 3 ? 2 : 0;
            TEST_ASSERT_EQUAL_INT(count, off.count[k]);
            ASSERT_NEAR(binned / by, off.sum[k], 0);
        }
    }
}

/* A point in the plane of the camera's centre, or behind it, has no projection, even where
 * its pixel is on the line to it. */
static void test_a_point_in_the_plane_of_the_camera_disagrees(void)
{
    for (int way = 0; way < 2; way++) {
        for (int place = 0; place < 4; place++) {
            uint8_t marks[EXACT] = {0};
            rigcal_real sum;
            exact e;

            make_exact(&e, 0);
            with_lens(&e, way == 0);
            rigcal_real *const X = e.o[3].X_w;
            X[0] = RC(place == 1 ? 0.25 : 0);
            X[1] = RC(place == 2 ? 0.25 : 0);
            X[2] = RC(place == 3 ? -1 : 0);
            e.o[3].uv[0] = 64;
            e.o[3].uv[1] = 16;
            TEST_ASSERT_EQUAL_INT(EXACT - 1,
                                  rc_agree_score(&sum, &e.points, &e.pose, 16, RC_MAX));
            ASSERT_NEAR(16, sum, 0);
            TEST_ASSERT_EQUAL_INT(EXACT - 1,
                                  rc_agree_mark(marks, NULL, &e.points, &e.pose, 16));
            TEST_ASSERT_EQUAL_INT(0, marks[3]);
            ASSERT_NEAR(1, rc_agree_misfit(&e.points, &e.pose), 0);
        }
    }
}

/* Points were seen in 50 x 40 px; an image of 128 x 64 px. */
static void test_the_area_is_that_of_the_pixels_by_the_mean_variance(void)
{
    static const double SIDE[3][2] = {{-1, 256}, {-1000, 60}, {-128, 1000}};
    exact e;

    make_exact(&e, 0);
    for (int i = 0; i < EXACT; i++) {
        e.o[i].uv[0] = RC(i == 2 ? 10 : i == 6 ? 60 : 30 + i);
        e.o[i].uv[1] = RC(i == 0 ? 55 : i == 7 ? 15 : 40);
        e.sigma[i] = RC(i == 1 ? 3 : i == 5 ? 0.5 : 2);
    }
    ASSERT_NEAR(2000, rc_agree_area(&VIEW(&e.camera, e.o, NULL, EXACT)), 0);
    ASSERT_NEAR(2000 * 8 / (9 + 0.25 + 6 * 4),
                rc_agree_area(&VIEW(&e.camera, e.o, e.sigma, EXACT)), TOL(1e-12, 1e-4));
    for (int i = 0; i < 3; i++) { /* the image's size beyond the image is the most */
        const double low = fmax(SIDE[i][0], -128), high = fmin(SIDE[i][1], 256);
        e.o[2].uv[0] = RC(SIDE[i][0]);
        e.o[6].uv[0] = RC(SIDE[i][1]);
        ASSERT_NEAR((high - low) * 40, rc_agree_area(&VIEW(&e.camera, e.o, NULL, EXACT)),
                    0);
    }
    e.o[0].uv[1] = 1000;
    e.o[7].uv[1] = -1000;
    ASSERT_NEAR(3 * 128 * 3 * 64, rc_agree_area(&VIEW(&e.camera, e.o, NULL, EXACT)), 0);
    for (int side = 0; side < 2; side++) { /* all beyond that: one column */
        for (int i = 0; i < EXACT; i++) {
            e.o[i].uv[0] = RC(side ? 1000 + i : -1000 - i);
        }
        ASSERT_NEAR(0, rc_agree_area(&VIEW(&e.camera, e.o, NULL, EXACT)), 0);
    }
}

/* Images that do not meet share nothing, beside each other or across a corner. */
static void test_a_target_elsewhere_has_the_most_misfit(void)
{
    for (int way = 1; way < 4; way++) {
        exact e;
        make_exact(&e, 0);
        e.points.is_pinhole = 1;
        e.pose.t[0] = RC(way % 2 ? 2 : 0);
        e.pose.t[1] = RC(way / 2 ? -2 : 0);
        ASSERT_NEAR(1, rc_agree_misfit(&e.points, &e.pose), 0);
    }
}

/* By more than the limit, not by the limit: a shift of one half of the distance of a; turns
 * by the angle, here about each axis. */
static void test_poses_differ_by_an_angle_or_a_part_of_the_distance(void)
{
    for (int k = 0; k < 3; k++) {
        exact e;
        make_exact(&e, 0);
        rigcal_transform other = e.pose;
        e.pose.t[k] = 1;
        other.t[k] = RC(1.5);
        TEST_ASSERT_FALSE(rc_agree_differ(&e.pose, &other, RC(0.5)));
        TEST_ASSERT_TRUE(rc_agree_differ(&other, &e.pose, RC(0.25)));
        TEST_ASSERT_FALSE(rc_agree_differ(&other, &e.pose, RC(0.375))); /* 1/3 of other */
        other.t[k] = RC(1.53125);
        TEST_ASSERT_TRUE(rc_agree_differ(&e.pose, &other, RC(0.5)));
        other.t[k] = RC(0.46875);
        TEST_ASSERT_TRUE(rc_agree_differ(&e.pose, &other, RC(0.5)));
        other.t[k] = 1;
        for (int step = -1; step <= 1; step += 2) {
            double R[9];
            test_rotation(R, k == 0 ? 0.05 + step * 1e-4 : 0,
                          k == 1 ? 0.05 + step * 1e-4 : 0, k == 2 ? 0.05 + step * 1e-4 : 0);
            test_to_real(other.R, R, 9);
            TEST_ASSERT_EQUAL_INT(step > 0, rc_agree_differ(&e.pose, &other, RC(0.05)));
            TEST_ASSERT_EQUAL_INT(step > 0, rc_agree_differ(&other, &e.pose, RC(0.05)));
        }
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

/* (E) by plain arithmetic, for the k nearest of n points. */
static double expected_by_chance(int n, int k, double sum, double area)
{
    double sets = n * (n - 1.0) * (n - 2) / 3;
    for (int i = 0; i < k - 3; i++) {
        sets *= (n - 3.0 - i) / (i + 1);
    }
    const double near = fmin(1, exp(1) * TEST_PI * sum / (k - 3) / area);
    return (n - 3) * sets * pow(near, k - 3) / sqrt(2 * TEST_PI * (k - 3));
}

static void test_chance_is_the_least_of_all_counts(void)
{
    const double area = 1e4;
    test_rng rng = test_seed(7);

    for (int trial = 0; trial < TEST_TRIALS(200); trial++) {
        rc_agree_histogram off = {{0}, {0}};
        double least = 1e300, sum = 0;
        const int n = 30;
        int k = 0;

        for (int bin = RC_AGREE_BINS - 1; bin >= 0; bin--) {
            const int count = (int)test_uniform(&rng, 0, trial % 2 ? 1.4 : 3);
            off.count[bin] = (size_t)(k + count <= n ? count : 0);
            for (size_t i = 0; i < off.count[bin]; i++) {
                off.sum[bin] += RC(test_uniform(&rng, 0.5, 1) * 900 / pow(2, bin));
            }
            sum += D(off.sum[bin]);
            k += (int)off.count[bin];
            if (off.count[bin] > 0 && k > 3) {
                least = fmin(least, expected_by_chance(n, k, sum, area));
            }
        }
        const double found = D(rc_agree_by_chance(&off, (size_t)n, RC(area), 0));
        if (k <= 3) {
            TEST_ASSERT_TRUE(found >= D(RC_MAX));
        } else {
            ASSERT_NEAR(least, found, TOL(1e-10, 1e-3) * least);
        }
    }
}

/* The search for the least goes from all points to the nearest. It ends below `enough`, not
 * at it. */
static void test_chance_is_sought_until_it_is_enough(void)
{
    rc_agree_histogram all = {{0}, {0}}, near = {{0}, {0}};
    const rigcal_real area = RC(1e4);

    all.count[0] = 10; /* the same sum as of both bins below */
    all.sum[0] = 3002;
    near.count[0] = 4;
    near.sum[0] = 3000;
    near.count[8] = 6;
    near.sum[8] = 2;
    const rigcal_real first = rc_agree_by_chance(&all, 20, area, 0);
    const rigcal_real least = rc_agree_by_chance(&near, 20, area, 0);
    TEST_ASSERT_TRUE(D(least) < D(first) / 2);
    ASSERT_NEAR(D(least), rc_agree_by_chance(&near, 20, area, first), 0);
    ASSERT_NEAR(D(first), rc_agree_by_chance(&near, 20, area, RC(1.001) * first), 0);
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
    RUN_TEST(test_a_point_at_the_limit_agrees);
    RUN_TEST(test_a_point_in_the_plane_of_the_camera_disagrees);
    RUN_TEST(test_the_area_is_that_of_the_pixels_by_the_mean_variance);
    RUN_TEST(test_a_target_elsewhere_has_the_most_misfit);
    RUN_TEST(test_poses_differ_by_an_angle_or_a_part_of_the_distance);
    RUN_TEST(test_chance_is_the_least_of_all_counts);
    RUN_TEST(test_chance_is_sought_until_it_is_enough);
}
