/* diagnose: scenes with one wrong point, mirrored ones, and ones in other units. */
#include <math.h>
#include <string.h>

#include "test_support.h"

enum { N_MAX = 20, N_MANY = 70 };

static const double NOISE = 0.5; /* px */

typedef struct {
    test_scene scene;
    rigcal_camera camera;
    rigcal_observation o[N_MAX];
    rigcal_real rms_without[N_MAX];
    rigcal_blame blame;
    rigcal_diagnosis diagnosis;
    int n;
} problem;

static void make(problem *p, test_rng *rng, int n, test_shape shape)
{
    p->camera = test_pinhole();
    p->n = n;
    test_scene_random(&p->scene, rng, n, shape);
    test_observations(p->o, &p->scene, &p->camera);
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < 2; k++) {
            p->o[i].uv[k] = RC(D(p->o[i].uv[k]) + NOISE * test_normal(rng));
        }
    }
}

/* Point i of more than N_MAX points before one camera, without noise. i counts from 0. */
static rigcal_observation exact_point(problem *p, test_rng *rng, int i)
{
    if (i % N_MAX == 0) {
        const test_scene same = p->scene;

        make(p, rng, N_MAX, TEST_GENERAL);
        if (i > 0) {
            memcpy(p->scene.R, same.R, sizeof same.R);
            memcpy(p->scene.t, same.t, sizeof same.t);
        }
        test_observations(p->o, &p->scene, &p->camera);
    }
    return p->o[i % N_MAX];
}

/* Moves the pixel of a point by this much, in a random direction. */
static void spoil(problem *p, test_rng *rng, int i, double by_px)
{
    const double angle = test_uniform(rng, 0, 2 * TEST_PI);

    p->o[i].uv[0] = RC(D(p->o[i].uv[0]) + by_px * cos(angle));
    p->o[i].uv[1] = RC(D(p->o[i].uv[1]) + by_px * sin(angle));
}

static rigcal_pose_options stated(double sigma_px)
{
    rigcal_pose_options options;

    ASSERT_STATUS(RIGCAL_OK, rigcal_pose_defaults(&options));
    options.sigma_px = RC(sigma_px);
    return options;
}

static void blame(problem *p, const rigcal_pose_options *options)
{
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_pose_blame(&p->blame, p->rms_without,
                                    &VIEW(&p->camera, p->o, NULL, (size_t)p->n), options));
}

static int diagnose(problem *p, const rigcal_pose_options *options)
{
    ASSERT_STATUS(RIGCAL_OK, rigcal_pose_diagnose(
                                 &p->diagnosis, p->rms_without,
                                 &VIEW(&p->camera, p->o, NULL, (size_t)p->n), options));
    return p->diagnosis.verdict;
}

/* ---- one point ----------------------------------------------------------- */

/* The number of 100 scenes in which the right point is surely blamed. Another point must
 * never be. */
static int surely_blamed(int n, double by_px, const rigcal_pose_options *options,
                         uint64_t seed)
{
    test_rng rng = test_seed(seed);
    int right = 0, other = 0;

    for (int k = 0; k < 100; k++) {
        const int wrong = k % n;
        problem p;

        make(&p, &rng, n, TEST_GENERAL);
        spoil(&p, &rng, wrong, by_px);
        blame(&p, options);
        right += p.blame.verdict == RIGCAL_BLAME_SURE && p.blame.point == wrong;
        other += p.blame.verdict == RIGCAL_BLAME_SURE && p.blame.point != wrong;
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(2, other);
    return right;
}

static void test_the_wrong_point_is_blamed(void)
{
    const rigcal_pose_options known = stated(NOISE);

    TEST_ON_HOST_ONLY("a rate wants all scenes");
    TEST_ASSERT_GREATER_THAN_INT(95, surely_blamed(8, 30, NULL, 1));
    TEST_ASSERT_GREATER_THAN_INT(95, surely_blamed(20, 10, NULL, 2));
    TEST_ASSERT_GREATER_THAN_INT(60, surely_blamed(6, 50, NULL, 3));
    TEST_ASSERT_GREATER_THAN_INT(80, surely_blamed(6, 30, &known, 4));
    TEST_ASSERT_GREATER_THAN_INT(95, surely_blamed(8, 30, &known, 5));
}

/* With unknown noise, five points hardly ever show the wrong one. With known noise they
 * often do. */
static void test_five_points_tell_little(void)
{
    const rigcal_pose_options known = stated(NOISE);

    TEST_ON_HOST_ONLY("a rate wants all scenes");
    const int unknown = surely_blamed(5, 30, NULL, 6);

    TEST_ASSERT_LESS_THAN_INT(50, unknown);
    TEST_ASSERT_GREATER_THAN_INT(unknown, surely_blamed(5, 30, &known, 6));
}

/* The bound on the chance holds: of data without a wrong point, at most one in a hundred
 * gets blame. */
static void test_noise_is_seldom_blamed(void)
{
    const rigcal_pose_options known = stated(NOISE);
    test_rng rng = test_seed(7);
    int sure = 0, likely = 0;

    TEST_ON_HOST_ONLY("a rate wants all scenes");
    for (int k = 0; k < 600; k++) {
        problem p;

        make(&p, &rng, 5 + k % 8, (test_shape)(k % 3));
        blame(&p, k % 2 ? &known : NULL);
        sure += p.blame.verdict == RIGCAL_BLAME_SURE;
        likely += p.blame.verdict == RIGCAL_BLAME_LIKELY;
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(6, sure);
    TEST_ASSERT_LESS_OR_EQUAL_INT(70, likely);
}

/* Compares each number with the fits that it stands for. */
static void test_numbers_are_those_of_the_fits(void)
{
    test_rng rng = test_seed(8);
    int n_certain = 0;

    for (int round = 0; round < 12; round++) {
        const rigcal_pose_options known = stated(NOISE);
        const rigcal_pose_options *const options = round % 2 ? &known : NULL;
        rigcal_pose pose;
        size_t n_found;
        double all, sum = 0, best = 1e300, rest[N_MAX];
        problem p;

        make(&p, &rng, 7, TEST_GENERAL);
        if (round < 6) {
            spoil(&p, &rng, 2, 6);
        }
        blame(&p, options);
        TEST_ASSERT_TRUE(p.blame.chance <= 1 && p.blame.probability <= 1);
        n_certain += p.blame.chance >= 1;
        TEST_ASSERT_TRUE(rigcal_pose_solve(&pose, 1, &n_found, NULL,
                                           &VIEW(&p.camera, p.o, NULL, 7), options) >= 0);
        ASSERT_NEAR(pose.rms_px, p.blame.rms_px, 1e-6);
        all = D(pose.sse);
        for (int i = 0; i < 7; i++) {
            rigcal_observation left[N_MAX];

            memcpy(left, p.o, sizeof left);
            memmove(&left[i], &left[i + 1], (size_t)(6 - i) * sizeof left[0]);
            TEST_ASSERT_TRUE(rigcal_pose_solve(&pose, 1, &n_found, NULL,
                                               &VIEW(&p.camera, left, NULL, 6),
                                               options) >= 0);
            ASSERT_NEAR(pose.rms_px, p.rms_without[i], TOL(1e-6, 1e-2));
            rest[i] = D(pose.sse);
            best = fmin(best, rest[i]);
        }
        for (int i = 0; i < 7; i++) {
            sum += options ? exp((best - rest[i]) / (2 * NOISE * NOISE))
                           : pow(best / rest[i], 3);
        }
        ASSERT_NEAR(1 / sum, p.blame.probability, 0.02);
        ASSERT_NEAR(fmin(1, 7 * (options ? exp((best - all) / (2 * NOISE * NOISE))
                                         : pow(best / all, 3))),
                    p.blame.chance, 0.01);
    }
    TEST_ASSERT_TRUE(n_certain > 0); /* the bound is 1 where it would be more */
}

/* Errors of all sizes: the limits of both verdicts have scenes on both their sides, within
 * a factor of two. */
static void test_verdicts_are_those_of_chance_and_probability(void)
{
    const rigcal_pose_options known = stated(NOISE);
    test_rng rng = test_seed(22);
    int near_sure = 0, near_likely[2] = {0, 0}, near_certain[2] = {0, 0};

    TEST_ON_HOST_ONLY("each limit wants scenes");
    for (int k = 0; k < 1500; k++) {
        problem p;

        make(&p, &rng, 5 + k % 4, TEST_GENERAL);
        spoil(&p, &rng, k % 5, test_uniform(&rng, 0, 20));
        blame(&p, k % 2 ? &known : NULL);
        const double chance = D(p.blame.chance), probability = D(p.blame.probability);
        TEST_ASSERT_EQUAL_INT32(chance <= 0.01 && probability >= 0.99 ? RIGCAL_BLAME_SURE
                                : chance <= 0.1                       ? RIGCAL_BLAME_LIKELY
                                                                      : RIGCAL_BLAME_NONE,
                                p.blame.verdict);
        near_sure += probability >= 0.99 && chance > 0.005 && chance <= 0.01;
        if (chance > 0.05 && chance < 0.2) {
            near_likely[chance > 0.1]++;
        }
        if (chance <= 0.01 && probability > 0.98 && probability < 0.995) {
            near_certain[probability >= 0.99]++;
        }
    }
    TEST_ASSERT_TRUE(near_sure > 2);
    for (int side = 0; side < 2; side++) {
        TEST_ASSERT_TRUE(near_likely[side] > 2 && near_certain[side] > 2);
    }
}

/* Of 100 exact points one is off, by so much that the chance is 5 % above or below the
 * limit. That it is this one of the 64 that are tried is sure in both cases. */
static void test_a_point_that_is_certain_may_be_chance(void)
{
    enum { MANY = 100 };
    const rigcal_pose_options known = stated(NOISE);
    static rigcal_observation o[MANY];
    rigcal_blame found;
    problem p;

    TEST_ON_HOST_ONLY("some 2000 poses of 99 points");
    for (int side = 0; side < 2; side++) {
        const double wanted = side ? 0.0105 : 0.0095;
        double low = 1.5, high = 4;

        for (int round = 0; round < 14; round++) {
            const double off = (low + high) / 2;
            test_rng rng = test_seed(26);

            for (int i = 0; i < MANY; i++) {
                o[i] = exact_point(&p, &rng, i);
            }
            o[50].uv[0] += RC(off);
            ASSERT_STATUS(
                RIGCAL_OK,
                rigcal_pose_blame(&found, NULL, &VIEW(&p.camera, o, NULL, MANY), &known));
            *(D(found.chance) > wanted ? &low : &high) = off;
        }
        ASSERT_NEAR(wanted, found.chance, 1e-4);
        TEST_ASSERT_EQUAL_INT32(50, found.point);
        TEST_ASSERT_TRUE(found.probability >= RC(0.99));
        TEST_ASSERT_EQUAL_INT32(side ? RIGCAL_BLAME_LIKELY : RIGCAL_BLAME_SURE,
                                found.verdict);
    }
}

/* The rest is poor where rigcal_pose_solve says so of it, not where it has another
 * caveat. */
static void test_the_rest_is_poor_where_its_fit_is(void)
{
    const rigcal_pose_options known = stated(NOISE);
    test_rng rng = test_seed(23);
    int n_poor = 0, n_other = 0;

    for (int k = 0; k < TEST_TRIALS(60); k++) {
        rigcal_observation rest[N_MAX];
        rigcal_pose pose;
        size_t n_found;
        problem p;

        make(&p, &rng, 6, TEST_PLANAR);
        if (k % 3 == 0) {
            spoil(&p, &rng, 1, 30);
            spoil(&p, &rng, 3, 30);
        }
        blame(&p, &known);
        const int out = p.blame.point;
        memcpy(rest, p.o, sizeof rest);
        memmove(&rest[out], &rest[out + 1], (size_t)(5 - out) * sizeof rest[0]);
        const rigcal_status status = rigcal_pose_solve(
            &pose, 1, &n_found, NULL, &VIEW(&p.camera, rest, NULL, 5), &known);
        TEST_ASSERT_EQUAL_INT32(status == RIGCAL_POOR_FIT, p.blame.is_rest_poor);
        n_poor += status == RIGCAL_POOR_FIT;
        n_other += status > 0 && status != RIGCAL_POOR_FIT;
    }
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || (n_poor > 2 && n_other > 2));
}

/* ---- no pose of all points ------------------------------------------------ */

/* Random pixels, for which there is no pose. */
static void test_points_without_a_pose_have_no_rms(void)
{
    test_rng rng = test_seed(14);
    int n_found = 0, n_blamed = 0;

    for (int k = 0; k < 200 && n_found < TEST_TRIALS(10); k++) {
        rigcal_pose pose;
        size_t n;
        problem p;

        make(&p, &rng, 5, TEST_GENERAL);
        for (int i = 0; i < p.n; i++) {
            p.o[i].uv[0] = RC(test_uniform(&rng, -1e5, 1e5));
            p.o[i].uv[1] = RC(test_uniform(&rng, -1e5, 1e5));
        }
        if (rigcal_pose_solve(&pose, 1, &n, NULL, &VIEW(&p.camera, p.o, NULL, 5), NULL) !=
            RIGCAL_ERR_NO_POSE) {
            continue;
        }
        n_found++;
        TEST_ASSERT_TRUE(diagnose(&p, NULL) >= RIGCAL_DIAGNOSIS_ONE_POINT);
        p.blame = p.diagnosis.blame;
        ASSERT_NEAR(-1, p.blame.rms_px, 0);
        if (p.blame.point >= 0) {
            ASSERT_NEAR(p.rms_without[p.blame.point], p.blame.rms_without_px, 0);
            TEST_ASSERT_TRUE(p.blame.rms_without_px >= 0);
            n_blamed++;
        } else {
            TEST_ASSERT_EQUAL_INT32(RIGCAL_BLAME_NONE, p.blame.verdict);
        }
    }
    TEST_ASSERT_EQUAL_INT(TEST_TRIALS(10), n_found);
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || (n_blamed > 0 && n_blamed < n_found));
}

/* Points on a long line at a distance of 1, and a point at a distance r from the line. If
 * the target turns about the line, that point moves along its own ray: the ray touches its
 * circle. */
static void put_on_a_ray(problem *p, test_rng *rng, double r)
{
    const double far = sqrt(1 - r * r), ahead[3] = {0, 0, 1};
    const double R[9] = {1, 0, 0, 0, far, r, 0, -r, far};
    double turned[9];

    p->camera = test_pinhole();
    p->camera.fx = p->camera.fy = 200;
    p->n = 5;
    test_random_rotation(turned, rng);
    for (int i = 0; i < p->n; i++) {
        const double X[3] = {i > 0 ? test_uniform(rng, -8, 8) : 0, i > 0 ? 0 : r, 0};
        double X_w[3], X_c[3], uv[2];

        test_apply(X_c, R, X, ahead);
        test_apply(X_w, turned, X, NULL);
        test_project_px(uv, &p->camera, X_c);
        test_to_real(p->o[i].X_w, X_w, 3);
        test_to_real(p->o[i].uv, uv, 2);
    }
}

/* The data do not show the turn about the line, and some of these scenes have no pose. The
 * diagnosis works in spite of that. */
static void test_of_a_turn_that_no_point_shows_there_may_be_no_pose(void)
{
    test_rng rng = test_seed(18);
    int n_degenerate = 0;

    TEST_ON_HOST_ONLY("some of many scenes");
    for (int k = 0; k < 100; k++) {
        rigcal_pose pose;
        size_t n;
        problem p;

        put_on_a_ray(&p, &rng, test_uniform(&rng, 0.2, 0.9));
        const rigcal_status status = rigcal_pose_solve(
            &pose, 1, &n, NULL, &VIEW(&p.camera, p.o, NULL, (size_t)p.n), NULL);
        blame(&p, NULL);
        TEST_ASSERT_EQUAL_INT(status < 0, p.blame.rms_px < 0);
        n_degenerate += status == RIGCAL_ERR_DEGENERATE;
    }
    TEST_ASSERT_TRUE(n_degenerate > 0);
}

/* n random points before a fisheye. */
static void before_a_fisheye(rigcal_camera *camera, rigcal_observation o[], int n)
{
    test_rng rng = test_seed(16);

    *camera = test_pinhole();
    camera->lens = RIGCAL_LENS_FISHEYE;
    camera->fx = camera->fy = 200;
    for (int i = 0; i < n; i++) {
        double X[3], X_c[3], uv[2];

        for (int k = 0; k < 3; k++) {
            X[k] = test_uniform(&rng, -1, 1);
            X_c[k] = X[k] + (k == 2 ? 3 : 0);
        }
        test_project_px(uv, camera, X_c);
        test_to_real(o[i].X_w, X, 3);
        test_to_real(o[i].uv, uv, 2);
    }
}

/* One point for which the lens has no ray counts as left out. If there are two, there is no
 * pose, whichever other point is left out, and no point gets blame. */
static void test_of_two_points_beyond_the_lens_none_is_blamed(void)
{
    static rigcal_observation o[N_MANY];
    static rigcal_real rms_without[N_MANY];
    rigcal_camera camera;
    rigcal_diagnosis found;

    for (int n = 8; n <= N_MANY; n += N_MANY - 8) {
        before_a_fisheye(&camera, o, n);
        o[2].uv[0] = o[5].uv[1] = 1200; /* beyond its image */
        ASSERT_STATUS(RIGCAL_OK, rigcal_pose_diagnose(&found, rms_without,
                                                      &VIEW(&camera, o, NULL, n), NULL));
        TEST_ASSERT_EQUAL_INT32(RIGCAL_DIAGNOSIS_UNEXPLAINED, found.verdict);
        TEST_ASSERT_EQUAL_INT32(RIGCAL_BLAME_NONE, found.blame.verdict);
        TEST_ASSERT_EQUAL_INT32(-1, found.blame.point);
        ASSERT_NEAR(-1, found.blame.rms_px, 0);
        for (int i = 0; i < n; i++) {
            ASSERT_NEAR(-1, rms_without[i], 0);
        }
    }
}

/* n random points before a camera, one of which is given behind it. With it there is no
 * pose. */
static void with_one_behind(rigcal_camera *camera, rigcal_observation o[], int n,
                            int behind)
{
    test_rng rng = test_seed(21);

    *camera = test_pinhole();
    camera->fx = camera->fy = 200;
    for (int i = 0; i < n; i++) {
        double X[3], X_c[3], uv[2];

        for (int k = 0; k < 3; k++) {
            X[k] = test_uniform(&rng, -1, 1);
            X_c[k] = X[k] + (k == 2 ? 2 : 0);
        }
        test_project_px(uv, camera, X_c);
        X[2] = i == behind ? -3 : X[2];
        test_to_real(o[i].X_w, X, 3);
        test_to_real(o[i].uv, uv, 2);
    }
}

/* Without a pose of all, the first 64 points are left out in turn. The wrong point gets
 * blame if it is the last of these, and none if it comes next. */
static void test_without_a_pose_the_first_points_are_left_out(void)
{
    static rigcal_observation o[RIGCAL_BLAME_TRIES + 2];
    static rigcal_real rms_without[RIGCAL_BLAME_TRIES + 2];
    const int n = RIGCAL_BLAME_TRIES + 2;
    rigcal_camera camera;
    rigcal_blame found;

    TEST_ON_HOST_ONLY("200 poses of 65 points");
    for (int at = RIGCAL_BLAME_TRIES - 1; at <= RIGCAL_BLAME_TRIES; at++) {
        const int is_tried = at < RIGCAL_BLAME_TRIES;

        with_one_behind(&camera, o, n, at);
        ASSERT_STATUS(RIGCAL_OK, rigcal_pose_blame(&found, rms_without,
                                                   &VIEW(&camera, o, NULL, n), NULL));
        TEST_ASSERT_EQUAL_INT32(is_tried ? at : -1, found.point);
        TEST_ASSERT_EQUAL_INT32(is_tried ? RIGCAL_BLAME_SURE : RIGCAL_BLAME_NONE,
                                found.verdict);
        ASSERT_NEAR(-1, found.rms_px, 0);
        ASSERT_NEAR(is_tried ? 0 : 1, found.chance, 1e-6);
        ASSERT_NEAR(is_tried ? 1 : 0, found.probability, 0);
        for (int i = 0; i < n; i++) {
            const int has_rms = is_tried && i == at;
            ASSERT_NEAR(has_rms ? 0 : -1, rms_without[i], has_rms ? 1e-3 : 0);
        }
        ASSERT_STATUS(RIGCAL_OK, /* nobody wants rms_without */
                      rigcal_pose_blame(&found, NULL, &VIEW(&camera, o, NULL, n), NULL));
        TEST_ASSERT_EQUAL_INT32(is_tried ? at : -1, found.point);
    }
}

/* 64 points are each left out, also two that are alike. Without either the rest is the
 * same; the first of them gets the blame. Of 65, points alike are tried once. */
static void test_of_64_points_each_is_left_out(void)
{
    static rigcal_observation o[RIGCAL_BLAME_TRIES + 1];
    static rigcal_real rms_without[RIGCAL_BLAME_TRIES + 1];
    test_rng rng = test_seed(19);
    rigcal_blame found;
    problem p;

    TEST_ON_HOST_ONLY("130 poses of 64 points");
    for (int n = RIGCAL_BLAME_TRIES; n <= RIGCAL_BLAME_TRIES + 1; n++) {
        for (int i = 0; i < n; i++) {
            o[i] = exact_point(&p, &rng, i);
            o[i].uv[0] += RC(NOISE * test_normal(&rng));
        }
        o[61].uv[0] += 9;
        o[62] = o[61];
        ASSERT_STATUS(RIGCAL_OK, rigcal_pose_blame(&found, rms_without,
                                                   &VIEW(&p.camera, o, NULL, n), NULL));
        for (int i = 0; i < n; i++) {
            const int is_tried = n == RIGCAL_BLAME_TRIES || i != 62;
            TEST_ASSERT_EQUAL_INT(is_tried, rms_without[i] >= 0);
            ASSERT_NEAR(is_tried ? D(rms_without[i]) : -1, rms_without[i], 0);
        }
        TEST_ASSERT_EQUAL_INT32(61, found.point);
        ASSERT_NEAR(D(rms_without[61]), found.rms_without_px, 0);
    }
}

/* Ten points, nine of them seen eight times. Points with equal distance count as one, so at
 * most ten are tried. */
static void test_points_that_are_seen_alike_are_tried_once(void)
{
    test_rng rng = test_seed(17);
    rigcal_observation o[73];
    rigcal_real rms_without[73];
    rigcal_blame found;
    int n = 0, n_tried = 0;
    problem p;

    TEST_ON_HOST_ONLY("13 poses of 73 points");
    make(&p, &rng, 10, TEST_GENERAL);
    spoil(&p, &rng, 4, 30);
    for (int k = 0; k < 80; k++) {
        if (k % 10 != 4 || k < 10) {
            o[n++] = p.o[k % 10];
        }
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_pose_blame(&found, rms_without,
                                               &VIEW(&p.camera, o, NULL, n), NULL));
    TEST_ASSERT_EQUAL_INT32(RIGCAL_BLAME_SURE, found.verdict);
    TEST_ASSERT_EQUAL_INT32(4, found.point);
    for (int i = 0; i < n; i++) {
        n_tried += rms_without[i] >= 0;
    }
    TEST_ASSERT_EQUAL_INT(10, n_tried);
}

/* ---- mirrors and units --------------------------------------------------- */

static void test_consistent_data_are(void)
{
    test_rng rng = test_seed(9);
    int consistent = 0, handed = 0;

    TEST_ON_HOST_ONLY("a rate wants all scenes");
    for (int k = 0; k < 100; k++) {
        problem p;

        make(&p, &rng, 10, TEST_GENERAL);
        consistent += diagnose(&p, NULL) == RIGCAL_DIAGNOSIS_CONSISTENT;
        handed += p.diagnosis.is_handed;
    }
    TEST_ASSERT_EQUAL_INT(100, consistent);
    TEST_ASSERT_GREATER_THAN_INT(80, handed);
}

static void test_mirrored_data_are_told(void)
{
    test_rng rng = test_seed(10);
    int told = 0;

    TEST_ON_HOST_ONLY("a rate wants all scenes");
    for (int k = 0; k < 60; k++) {
        problem p;

        make(&p, &rng, 10, TEST_GENERAL);
        for (int i = 0; i < p.n; i++) {
            if (k % 2) {
                p.o[i].X_w[k / 2 % 3] = -p.o[i].X_w[k / 2 % 3];
            } else {
                p.o[i].uv[1] = RC(p.camera.height - 1) - p.o[i].uv[1];
            }
        }
        told += diagnose(&p, NULL) == RIGCAL_DIAGNOSIS_MIRRORED;
    }
    TEST_ASSERT_GREATER_THAN_INT(54, told);
}

/* Both mirrored readings are fits of data that are mirrored by hand: Z to -Z, and v to
 * height - 1 - v. The camera's centre is beside the middle, and its lens has no symmetry.
 * Where one reading is believed, the data decide. */
static void test_mirrored_readings_are_fits_of_mirrored_data(void)
{
    test_rng rng = test_seed(24);
    int n_told[2] = {0, 0};

    for (int k = 0; k < TEST_TRIALS(24); k++) {
        double rms[2];
        problem p;

        make(&p, &rng, 9, TEST_GENERAL);
        p.camera.cy = RC(200);
        p.camera.k1 = RC(-0.05);
        p.camera.p1 = RC(0.01);
        p.camera.p2 = RC(-0.005);
        for (int i = 0; i < p.n; i++) {
            double X_c[3], uv[2];

            test_apply(X_c, p.scene.R, p.scene.X[i], p.scene.t);
            test_project_px(uv, &p.camera, X_c);
            uv[1] = k % 3 == 1 ? 479 - uv[1] : uv[1];
            test_to_real(p.o[i].uv, uv, 2);
            p.o[i].uv[0] += RC(NOISE * test_normal(&rng));
            p.o[i].X_w[2] *= RC(k % 3 == 2 ? -1 : 1);
        }
        const int verdict = diagnose(&p, NULL);
        for (int way = 0; way < 2; way++) {
            rigcal_observation o[N_MAX];
            rigcal_pose pose;
            size_t n_found;

            memcpy(o, p.o, sizeof o);
            for (int i = 0; i < p.n; i++) {
                if (way == 0) {
                    o[i].X_w[2] = -o[i].X_w[2];
                } else {
                    o[i].uv[1] = 479 - o[i].uv[1];
                }
            }
            rms[way] = rigcal_pose_solve(&pose, 1, &n_found, NULL,
                                         &VIEW(&p.camera, o, NULL, (size_t)p.n), NULL) >= 0
                           ? D(pose.rms_px)
                           : -1;
        }
        ASSERT_NEAR(rms[0], p.diagnosis.rms_mirrored_px, TOL(1e-5, 1e-2));
        ASSERT_NEAR(rms[1], p.diagnosis.rms_flipped_px, TOL(1e-5, 1e-2));
        if (verdict == RIGCAL_DIAGNOSIS_MIRRORED) {
            TEST_ASSERT_EQUAL_INT(1, p.diagnosis.is_handed);
            n_told[rms[1] < rms[0]]++;
        }
    }
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || (n_told[0] > 2 && n_told[1] > 2));
}

static void test_a_flat_target_has_no_hand(void)
{
    test_rng rng = test_seed(11);

    for (int k = 0; k < 20; k++) {
        problem p;

        make(&p, &rng, 10, TEST_PLANAR);
        TEST_ASSERT_EQUAL_INT(RIGCAL_DIAGNOSIS_CONSISTENT, diagnose(&p, NULL));
        TEST_ASSERT_EQUAL_INT(0, p.diagnosis.is_handed);
    }
}

static void test_one_wrong_point_is_told_and_several_are_not_explained(void)
{
    const rigcal_pose_options known = stated(NOISE);
    test_rng rng = test_seed(12);
    int one = 0, unexplained = 0;

    TEST_ON_HOST_ONLY("a rate wants all scenes");
    for (int k = 0; k < 40; k++) {
        problem p;

        make(&p, &rng, 12, TEST_GENERAL);
        spoil(&p, &rng, k % 12, 60);
        one += diagnose(&p, &known) == RIGCAL_DIAGNOSIS_ONE_POINT &&
               p.diagnosis.blame.point == k % 12;
        for (int i = 0; i < 4; i++) {
            spoil(&p, &rng, (k + 1 + i) % 12, 60);
        }
        unexplained += diagnose(&p, &known) == RIGCAL_DIAGNOSIS_UNEXPLAINED;
    }
    TEST_ASSERT_GREATER_THAN_INT(38, one);
    TEST_ASSERT_GREATER_THAN_INT(38, unexplained);
}

/* A target in millimetres with a previous pose in metres, and similar mistakes. */
static void test_units_are_told_from_a_previous_pose(void)
{
    static const double FACTOR[4] = {1000, 0.01, 25.4, 1};
    test_rng rng = test_seed(13);

    for (int k = 0; k < 16; k++) {
        const double factor = FACTOR[k % 4];
        rigcal_pose_options options = stated(0);
        problem p;

        make(&p, &rng, 10, TEST_GENERAL);
        for (int i = 0; i < p.n; i++) {
            for (int j = 0; j < 3; j++) {
                p.o[i].X_w[j] = RC(factor * (p.scene.X[i][j] - p.scene.X[0][j]));
            }
        }
        options.use_start = 1;
        options.start = test_transform(p.scene.R, p.scene.t);
        test_apply(p.scene.t, p.scene.R, p.scene.X[0], p.scene.t);
        test_to_real(options.start.t, p.scene.t, 3);
        TEST_ASSERT_EQUAL_INT(factor > 1 || factor < 1 ? RIGCAL_DIAGNOSIS_UNITS
                                                       : RIGCAL_DIAGNOSIS_CONSISTENT,
                              diagnose(&p, &options));
        ASSERT_NEAR(factor > 1 || factor < 1 ? factor : 0, p.diagnosis.units,
                    TOL(1e-6, 1e-4) * factor);
    }
}

/* A factor counts as a mistake of units up to 10 % off, to either side. */
static void test_units_are_told_up_to_a_tenth(void)
{
    static const double UNIT[4] = {10, 25.4, 100, 1000};
    static const double OFF[4] = {1.09, 1.11, 1 / 1.09, 1 / 1.11};
    test_rng rng = test_seed(25);

    for (int k = 0; k < 32; k++) {
        const double unit = k / 4 % 2 ? UNIT[k / 8] : 1 / UNIT[k / 8];
        rigcal_pose_options options = stated(0);
        problem p;

        make(&p, &rng, 8, TEST_GENERAL);
        test_observations(p.o, &p.scene, &p.camera);
        options.use_start = 1;
        options.start = test_transform(p.scene.R, p.scene.t);
        for (int j = 0; j < 3; j++) {
            options.start.t[j] = RC(p.scene.t[j] / unit / OFF[k % 4]);
        }
        TEST_ASSERT_EQUAL_INT(k % 2 ? RIGCAL_DIAGNOSIS_CONSISTENT : RIGCAL_DIAGNOSIS_UNITS,
                              diagnose(&p, &options));
        ASSERT_NEAR(k % 2 ? 0 : unit, p.diagnosis.units, TOL(1e-12, 1e-6) * unit);
    }
}

/* Four points on a line have no pose, and the fifth is beside it. Only without the fifth is
 * there no rms. */
static void test_there_is_no_rms_where_the_others_have_no_pose(void)
{
    static const double X[5][3] = {
        {-2, 0, 0}, {-1, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0.5, 2, 1}};
    test_rng rng = test_seed(14);
    problem p;

    make(&p, &rng, 5, TEST_GENERAL);
    test_rotation(p.scene.R, 0.3, 0.2, 0.1);
    p.scene.t[0] = p.scene.t[1] = 0.1;
    p.scene.t[2] = 8;
    memcpy(p.scene.X, X, sizeof X);
    test_observations(p.o, &p.scene, &p.camera);
    blame(&p, NULL);
    for (int i = 0; i < 4; i++) {
        TEST_ASSERT_TRUE(p.rms_without[i] >= 0);
    }
    TEST_ASSERT_TRUE(p.rms_without[4] >= -1 && p.rms_without[4] <= -1);
}

/* If there are more points than are tried, those that are not tried have no rms. The wrong
 * point has one. */
static void test_there_is_no_rms_of_what_was_not_left_out(void)
{
    enum { MANY = RIGCAL_BLAME_TRIES + 6 };
    test_rng rng = test_seed(15);
    rigcal_observation o[MANY];
    rigcal_real rms_without[MANY];
    rigcal_blame found;
    int none = 0;
    problem p;

    make(&p, &rng, N_MAX, TEST_GENERAL);
    for (int i = 0; i < MANY; i++) {
        double X[3], X_c[3], uv[2];

        for (int k = 0; k < 3; k++) {
            X[k] = p.scene.X[i % N_MAX][k] + 0.01 * test_normal(&rng);
        }
        test_apply(X_c, p.scene.R, X, p.scene.t);
        test_project_px(uv, &p.camera, X_c);
        uv[0] += NOISE * test_normal(&rng) + (i == 40 ? 30 : 0);
        uv[1] += NOISE * test_normal(&rng);
        test_to_real(o[i].X_w, X, 3);
        test_to_real(o[i].uv, uv, 2);
        rms_without[i] = 7;
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_pose_blame(&found, rms_without,
                                               &VIEW(&p.camera, o, NULL, MANY), NULL));
    for (int i = 0; i < MANY; i++) {
        none += rms_without[i] >= -1 && rms_without[i] <= -1;
        TEST_ASSERT_TRUE(rms_without[i] >= -1 && rms_without[i] < 7);
    }
    TEST_ASSERT_EQUAL_INT(MANY - RIGCAL_BLAME_TRIES, none);
    TEST_ASSERT_EQUAL_INT(40, found.point);
    TEST_ASSERT_TRUE(rms_without[40] > 0);
}

/* A flat target with one point off its plane, on the wrong side. Either that point is
 * wrong, or the target is mirrored. The reading that fits better counts. */
static void test_a_point_on_the_wrong_side_is_wrong_or_the_target_is_mirrored(void)
{
    const rigcal_pose_options known = stated(NOISE);
    int n_mirrored = 0, n_one = 0;

    TEST_ON_HOST_ONLY("both want many scenes");
    for (int k = 0; k < 40; k++) {
        test_rng rng = test_seed(1800 + (uint64_t)k);
        problem p;

        p.camera = test_pinhole();
        p.n = 9;
        test_scene_random(&p.scene, &rng, p.n, TEST_GENERAL);
        for (int i = 0; i < p.n; i++) {
            double X_c[3], uv[2];

            p.scene.X[i][2] = i == 8 ? 0.7 : 0;
            test_apply(X_c, p.scene.R, p.scene.X[i], p.scene.t);
            test_project_px(uv, &p.camera, X_c);
            test_to_real(p.o[i].X_w, p.scene.X[i], 3);
            for (int j = 0; j < 2; j++) {
                p.o[i].uv[j] = RC(uv[j] + NOISE * test_normal(&rng));
            }
        }
        p.o[8].X_w[2] = -p.o[8].X_w[2];
        (void)diagnose(&p, &known);
        const rigcal_diagnosis *const d = &p.diagnosis;
        if (d->blame.verdict == RIGCAL_BLAME_SURE && d->blame.point == 8 &&
            !d->blame.is_rest_poor && d->rms_mirrored_px >= 0 &&
            D(d->rms_mirrored_px) < 2 * NOISE) {
            const int is_better =
                d->rms_mirrored_px < d->blame.rms_without_px ||
                (d->rms_flipped_px >= 0 && d->rms_flipped_px < d->blame.rms_without_px);

            TEST_ASSERT_EQUAL_INT32(is_better ? RIGCAL_DIAGNOSIS_MIRRORED
                                              : RIGCAL_DIAGNOSIS_ONE_POINT,
                                    d->verdict);
            n_mirrored += is_better;
            n_one += !is_better;
        }
    }
    TEST_ASSERT_TRUE(n_mirrored > 2 && n_one > 2);
}

/* The same with a flipped image whose principal point is beside the middle, so that the two
 * mirrored readings differ. The better one counts, which may be either. */
static void test_of_two_mirrored_readings_the_better_one_counts(void)
{
    const rigcal_pose_options known = stated(NOISE);
    int n_decided = 0, n_other = 0;

    TEST_ON_HOST_ONLY("it wants many scenes");
    for (int k = 0; k < 200; k++) {
        test_rng rng = test_seed(2000 + (uint64_t)k);
        problem p;

        p.camera = test_pinhole();
        p.camera.cy = RC(239.5 + test_uniform(&rng, 5, 60));
        p.n = 9;
        test_scene_random(&p.scene, &rng, p.n, TEST_GENERAL);
        for (int i = 0; i < p.n; i++) {
            double X_c[3], uv[2];

            p.scene.X[i][2] = i == 8 ? 0.4 : 0;
            test_apply(X_c, p.scene.R, p.scene.X[i], p.scene.t);
            test_project_px(uv, &p.camera, X_c);
            test_to_real(p.o[i].X_w, p.scene.X[i], 3);
            p.o[i].uv[0] = RC(uv[0] + NOISE * test_normal(&rng));
            p.o[i].uv[1] = RC((k % 2 ? uv[1] : 479 - uv[1]) + NOISE * test_normal(&rng));
        }
        p.o[8].X_w[2] *= RC(k % 2 ? -1 : 1);
        (void)diagnose(&p, &known);
        const rigcal_diagnosis *const d = &p.diagnosis;
        if (d->blame.verdict == RIGCAL_BLAME_SURE && !d->blame.is_rest_poor &&
            d->rms_flipped_px >= 0 && d->rms_flipped_px < d->blame.rms_without_px &&
            (d->rms_mirrored_px < 0 || d->rms_mirrored_px >= d->blame.rms_without_px)) {
            TEST_ASSERT_EQUAL_INT32(RIGCAL_DIAGNOSIS_MIRRORED, d->verdict);
            n_decided++;
        }
        if (d->blame.verdict == RIGCAL_BLAME_SURE && !d->blame.is_rest_poor && k % 2 &&
            d->rms_mirrored_px >= 0 && d->rms_mirrored_px < d->blame.rms_without_px &&
            (d->rms_flipped_px < 0 || d->rms_flipped_px >= d->blame.rms_without_px)) {
            TEST_ASSERT_EQUAL_INT32(RIGCAL_DIAGNOSIS_MIRRORED, d->verdict);
            n_other++;
        }
    }
    TEST_ASSERT_TRUE(n_decided > 2 && n_other > 2);
}

/* A previous pose serves only to compare units: with any such pose, also the other pose of
 * a flat target, the diagnosis is the same. */
static void test_a_previous_pose_changes_no_fit(void)
{
    test_rng rng = test_seed(20);
    int n_second = 0;

    for (int k = 0; k < TEST_TRIALS(40); k++) {
        rigcal_pose_options options = stated(0);
        rigcal_pose poses[RIGCAL_POSES_MAX];
        size_t n_found;
        problem p, q;

        make(&p, &rng, 6, TEST_PLANAR);
        q = p;
        const int verdict = diagnose(&p, NULL);
        if (rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL,
                              &VIEW(&p.camera, p.o, NULL, (size_t)p.n), NULL) < 0) {
            continue;
        }
        n_second += n_found > 1;
        options.use_start = 1;
        options.start = poses[n_found - 1].cam_from_world;
        TEST_ASSERT_EQUAL_INT(verdict, diagnose(&q, &options));
        TEST_ASSERT_EQUAL_INT32(p.diagnosis.is_handed, q.diagnosis.is_handed);
        TEST_ASSERT_EQUAL_INT32(p.diagnosis.blame.point, q.diagnosis.blame.point);
        ASSERT_NEAR(D(p.diagnosis.rms_mirrored_px), q.diagnosis.rms_mirrored_px, 0);
        ASSERT_NEAR(D(p.diagnosis.rms_flipped_px), q.diagnosis.rms_flipped_px, 0);
        ASSERT_NEAR(D(p.diagnosis.blame.rms_px), q.diagnosis.blame.rms_px, 0);
        ASSERT_NEAR(D(p.diagnosis.blame.chance), q.diagnosis.blame.chance, 0);
        for (int i = 0; i < p.n; i++) {
            ASSERT_NEAR(D(p.rms_without[i]), q.rms_without[i], 0);
        }
    }
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || n_second > 3);
}

/* (C), from the numbers that are returned: both mirrored readings are a thousand times less
 * likely. */
static void test_the_data_decide_where_neither_mirrored_reading_fits(void)
{
    int n_both = 0, n_one[2] = {0, 0};

    TEST_ON_HOST_ONLY("the borderline wants many scenes");
    for (int k = 0; k < 300; k++) {
        test_rng rng = test_seed(1900 + (uint64_t)k);
        int n_unlike = 0, is_unlike[2];
        problem p;

        p.camera = test_pinhole();
        p.camera.cy = RC(test_uniform(&rng, 0, 480)); /* the flipped camera differs from
                                                         it */
        const double thickness = test_uniform(&rng, 0.02, 0.2);
        p.n = 9;
        test_scene_random(&p.scene, &rng, p.n, TEST_GENERAL);
        for (int i = 0; i < p.n; i++) {
            double X_c[3], uv[2];

            p.scene.X[i][2] *= thickness;
            test_apply(X_c, p.scene.R, p.scene.X[i], p.scene.t);
            test_project_px(uv, &p.camera, X_c);
            test_to_real(p.o[i].X_w, p.scene.X[i], 3);
            for (int j = 0; j < 2; j++) {
                p.o[i].uv[j] = RC(uv[j] + NOISE * test_normal(&rng));
            }
        }
        if (diagnose(&p, NULL) == RIGCAL_DIAGNOSIS_MIRRORED) {
            continue;
        }
        const double rms = D(p.diagnosis.blame.rms_px);
        const double mirrored[2] = {D(p.diagnosis.rms_mirrored_px),
                                    D(p.diagnosis.rms_flipped_px)};
        for (int i = 0; i < 2; i++) {
            is_unlike[i] = mirrored[i] < 0 || pow(rms / mirrored[i], 2 * (p.n - 3)) < 1e-3;
            n_unlike += is_unlike[i];
        }
        TEST_ASSERT_EQUAL_INT32(n_unlike == 2, p.diagnosis.is_handed);
        n_both += n_unlike == 2;
        n_one[0] += n_unlike == 1 && is_unlike[0];
        n_one[1] += n_unlike == 1 && is_unlike[1];
    }
    TEST_ASSERT_TRUE(n_both > 2 && n_one[0] > 2 && n_one[1] > 2);
}

TEST_MAIN()
{
    RUN_TEST(test_the_wrong_point_is_blamed);
    RUN_TEST(test_five_points_tell_little);
    RUN_TEST(test_noise_is_seldom_blamed);
    RUN_TEST(test_numbers_are_those_of_the_fits);
    RUN_TEST(test_verdicts_are_those_of_chance_and_probability);
    RUN_TEST(test_a_point_that_is_certain_may_be_chance);
    RUN_TEST(test_the_rest_is_poor_where_its_fit_is);
    RUN_TEST(test_consistent_data_are);
    RUN_TEST(test_mirrored_data_are_told);
    RUN_TEST(test_mirrored_readings_are_fits_of_mirrored_data);
    RUN_TEST(test_a_flat_target_has_no_hand);
    RUN_TEST(test_one_wrong_point_is_told_and_several_are_not_explained);
    RUN_TEST(test_units_are_told_from_a_previous_pose);
    RUN_TEST(test_units_are_told_up_to_a_tenth);
    RUN_TEST(test_there_is_no_rms_where_the_others_have_no_pose);
    RUN_TEST(test_there_is_no_rms_of_what_was_not_left_out);
    RUN_TEST(test_points_without_a_pose_have_no_rms);
    RUN_TEST(test_of_a_turn_that_no_point_shows_there_may_be_no_pose);
    RUN_TEST(test_of_two_points_beyond_the_lens_none_is_blamed);
    RUN_TEST(test_without_a_pose_the_first_points_are_left_out);
    RUN_TEST(test_of_64_points_each_is_left_out);
    RUN_TEST(test_points_that_are_seen_alike_are_tried_once);
    RUN_TEST(test_a_point_on_the_wrong_side_is_wrong_or_the_target_is_mirrored);
    RUN_TEST(test_of_two_mirrored_readings_the_better_one_counts);
    RUN_TEST(test_a_previous_pose_changes_no_fit);
    RUN_TEST(test_the_data_decide_where_neither_mirrored_reading_fits);
}
