/* roots: the poses of the widest triple of few points, compared with the truth. */
#include <math.h>
#include <string.h>

#include "rc_roots.h"
#include "test_support.h"

#if RIGCAL_FOR_SPEED && RIGCAL_WITH_THREE_POINTS
/* Points in a box, seen exactly by a pinhole. */
typedef struct {
    rigcal_camera camera;
    rigcal_observation seen[8];
    double R[9], t[3];
    rigcal_points points;
} scene;

static void make_scene(scene *s, test_rng *rng, int n, double across)
{
    const double box[3] = {1, across, across};
    rigcal_real uv_middle[2];
    int32_t at;

    memset(s, 0, sizeof *s);
    s->camera = test_pinhole();
    test_random_rotation(s->R, rng);
    s->t[2] = test_uniform(rng, 3, 6);
    for (int i = 0; i < n; i++) {
        double X[3], X_c[3], uv[2];

        for (int k = 0; k < 3; k++) {
            X[k] = box[k] * test_uniform(rng, -0.5, 0.5);
        }
        test_apply(X_c, s->R, X, s->t);
        test_project_px(uv, &s->camera, X_c);
        test_to_real(s->seen[i].X_w, X, 3);
        test_to_real(s->seen[i].uv, uv, 2);
    }
    rc_points_of(&s->points, &VIEW(&s->camera, s->seen, NULL, n), NULL);
    ASSERT_STATUS(RIGCAL_OK, rc_points_survey(&s->points, uv_middle, &at));
}

/* Runs all steps. There are at most two for the triple and its poses, three for rays, and
 * one for each score. */
static int32_t find(rigcal_optima *optima, const rigcal_points *points)
{
    rigcal_triple triple = {0};
    uint8_t n = 0;

    int is_done = 0;
    while (!is_done) {
        is_done = rc_roots_step(optima, &n, &triple, points);
        TEST_ASSERT_TRUE(is_done == 0 || is_done == 1);
        TEST_ASSERT_LESS_OR_EQUAL_INT32(5 + RC_P3P_MAX, triple.count);
    }
    return n;
}

/* The angle between a pose that was found and the truth. */
static double off_truth(const scene *s, const rigcal_optimum *pose)
{
    rigcal_transform T;
    double R[9], t[3];

    rc_optimum_transform(&T, pose);
    test_transform_parts(R, t, &T);
    return test_angle_between(R, s->R);
}

/* With 4 to 8 points in a cube the truth comes first. The poses come in the order of their
 * sums, none of them more than a hundred times worse than a pixel. */
static void test_the_truth_is_the_first(void)
{
    test_rng rng = test_seed(2601);
    int found = 0;

    for (int trial = 0; trial < 400; trial++) {
        rigcal_optima optima;
        scene s;

        make_scene(&s, &rng, 4 + trial % 5, 1);
        memset(&optima, 0, sizeof optima); /* poses beyond the end of the list would fit
                                              exactly */
        const int32_t n = find(&optima, &s.points);
        TEST_ASSERT_EQUAL_INT32(0, optima.n);
        TEST_ASSERT_LESS_OR_EQUAL_INT32(RC_P3P_MAX, n);
        if (n == 0) { /* a narrow triple */
            continue;
        }
        found++;
        TEST_ASSERT_TRUE(off_truth(&s, &optima.list[0]) < TOL(1e-5, 0.02));
        for (int32_t k = 1; k < n; k++) {
            TEST_ASSERT_TRUE(optima.list[k].sse >= optima.list[k - 1].sse);
            TEST_ASSERT_TRUE(optima.list[k].sse <= RC(100) * (1 + optima.list[0].sse));
        }
    }
    TEST_ASSERT_GREATER_THAN_INT(320, found);
}

/* The triple by its definition. Returns its height above its first side, as a part of
 * it. */
static double widest(int index[3], const scene *s, int n)
{
    double middle[3] = {0, 0, 0}, at[3], side[3], x[3], across[3], height = 0;

    for (int i = 0; i < 3 * n; i++) {
        middle[i % 3] += D(s->seen[i / 3].X_w[i % 3]) / n;
    }
    for (int k = 0; k < 3; k++) {
        double most = -1;

        for (int i = 0; i < n; i++) {
            for (int j = 0; j < 3; j++) {
                x[j] = D(s->seen[i].X_w[j]) - (k == 0 ? middle[j] : at[j]);
            }
            if (k == 2) {
                test_cross(across, side, x);
            }
            const double far = k == 2 ? test_norm(across) / test_norm(side) : test_norm(x);
            if (far > most) {
                most = far;
                index[k] = i;
            }
        }
        for (int j = 0; j < 3 && k < 2; j++) {
            side[j] = D(s->seen[index[k]].X_w[j]) - at[j];
            if (k == 0) {
                at[j] = D(s->seen[index[0]].X_w[j]);
            }
        }
        height = most;
    }
    return height / test_norm(side);
}

/* Targets of any size and shape, with their origin anywhere. */
static void test_the_triple_is_the_widest(void)
{
    test_rng rng = test_seed(2605);
    int narrow = 0;

    for (int trial = 0; trial < 300; trial++) {
        const double unit = pow(10, test_uniform(&rng, -3, 3));
        const int n = 4 + trial % 5;
        rigcal_triple triple = {0};
        rigcal_optima optima;
        rigcal_real uv_middle[2];
        uint8_t n_roots = 0;
        int32_t at;
        int index[3];
        scene s;

        make_scene(&s, &rng, n, test_uniform(&rng, 0.1, 0.8));
        for (int i = 0; i < n; i++) {
            for (int k = 0; k < 3; k++) {
                s.seen[i].X_w[k] = RC(unit * (D(s.seen[i].X_w[k]) + 1 + k));
            }
        }
        ASSERT_STATUS(RIGCAL_OK, rc_points_survey(&s.points, uv_middle, &at));
        optima.n = 0;
        const double height = widest(index, &s, n);
        const int is_done = rc_roots_step(&optima, &n_roots, &triple, &s.points);
        for (int k = 0; k < 3; k++) {
            TEST_ASSERT_EQUAL_INT32(index[k], triple.index[k]);
        }
        TEST_ASSERT_EQUAL_INT(height < 0.25, is_done);
        narrow += height < 0.25;
    }
    TEST_ASSERT_TRUE(narrow > 30 && narrow < 270);
}

/* Two pairs of equally far points: the first ones count. A triple of exactly a quarter of
 * its length is narrow. */
static void test_of_equal_points_the_first_ones_count(void)
{
    for (int wider = 0; wider < 2; wider++) {
        const rigcal_real high = RC(1 + wider / 16.0);
        const rigcal_real X[4][3] = {{-2, 0, 0}, {2, 0, 0}, {0, high, 0}, {0, -high, 0}};
        rigcal_triple triple = {0};
        rigcal_optima optima;
        rigcal_real uv_middle[2];
        uint8_t n_roots = 0;
        int32_t at;
        scene s;

        memset(&s, 0, sizeof s);
        s.camera = test_pinhole();
        for (int i = 0; i < 4; i++) {
            memcpy(s.seen[i].X_w, X[i], sizeof X[i]);
            s.seen[i].uv[0] = RC(320) + 100 * X[i][0];
            s.seen[i].uv[1] = RC(240) + 100 * X[i][1];
        }
        rc_points_of(&s.points, &VIEW(&s.camera, s.seen, NULL, 4), NULL);
        ASSERT_STATUS(RIGCAL_OK, rc_points_survey(&s.points, uv_middle, &at));
        optima.n = 0;
        TEST_ASSERT_EQUAL_INT(!wider, rc_roots_step(&optima, &n_roots, &triple, &s.points));
        for (int k = 0; k < 3; k++) {
            TEST_ASSERT_EQUAL_INT32(k, triple.index[k]);
        }
    }
}

/* The sum of the squared errors of the points outside the triple, and how many of them are
 * behind the camera. */
static double sum_of(int *behind, const scene *s, int n, const int index[3],
                     const rigcal_transform *T)
{
    double sum = 0;

    *behind = 0;
    for (int i = 0; i < n; i++) {
        double R[9], t[3], x[3], X_c[3], uv[2];

        if (i == index[0] || i == index[1] || i == index[2]) {
            continue;
        }
        test_transform_parts(R, t, T);
        for (int k = 0; k < 3; k++) {
            x[k] = D(s->seen[i].X_w[k]) - D(s->points.origin[k]);
        }
        test_apply(X_c, R, x, t);
        if (X_c[2] <= 0) {
            ++*behind;
            continue;
        }
        test_project_px(uv, &s->camera, X_c);
        sum += pow(uv[0] - D(s->seen[i].uv[0]), 2) + pow(uv[1] - D(s->seen[i].uv[1]), 2);
    }
    return sum;
}

/* Of all poses of the triple those come back that are not a hundred times worse than the
 * best and a pixel. Pixels are garbled, so that some poses leave points behind the camera:
 * the more of them, the later they come. */
static void test_the_others_rule_poses_out(void)
{
    test_rng rng = test_seed(2606);
    int out = 0, several_behind = 0;

    for (int trial = 0; trial < 400; trial++) {
        const int n = 4 + trial % 5;
        const double noise = trial % 2 ? 3 : 150;
        rigcal_transform all[RC_P3P_MAX];
        rigcal_real ray[3][3], uv_middle[2];
        rigcal_optima optima;
        double sums[RC_P3P_MAX], best = 1e300;
        int32_t as_int32[3], at;
        int index[3], behind, last_behind = 0, expected = 0, is_close = 0;
        scene s;

        make_scene(&s, &rng, n, 1);
        if (trial % 4 == 1) { /* a normalised image, whose pixel is smaller */
            s.camera.fx = s.camera.fy = 1;
            s.camera.cx = s.camera.cy = 0;
        } else if (trial % 2 == 0) { /* all around the camera */
            s.camera.fx = s.camera.fy = 20;
        }
        for (int i = 0; i < n; i++) {
            for (int k = 0; k < 2; k++) {
                const double uv = D(s.seen[i].uv[k]) + noise * test_normal(&rng);

                s.seen[i].uv[k] = RC(trial % 4 == 1 ? (uv - (k ? 240 : 320)) / 600 : uv);
            }
        }
        ASSERT_STATUS(RIGCAL_OK, rc_points_survey(&s.points, uv_middle, &at));
        optima.n = 0;
        const int32_t found = find(&optima, &s.points);
        if (widest(index, &s, n) < 0.25) {
            continue;
        }
        for (int k = 0; k < 3; k++) {
            as_int32[k] = index[k];
            ASSERT_STATUS(RIGCAL_OK,
                          rc_pixel_to_ray(ray[k], &s.camera, s.seen[index[k]].uv));
        }
        const int32_t n_all =
            rc_poses_of_three(all, &s.points, as_int32, (const rigcal_real(*)[3])ray);
        for (int32_t k = 0; k < n_all; k++) {
            sums[k] = sum_of(&behind, &s, n, index, &all[k]);
            sums[k] = behind > 0 ? 1e200 : sums[k];
            best = fmin(best, sums[k]);
        }
        const double most = 100 * (best + pow(D(s.points.pixel_size), 2));
        for (int32_t k = 0; k < n_all; k++) {
            expected += sums[k] <= most;
            is_close |= fabs(sums[k] - most) < TOL(1e-6, 1e-2) * most;
        }
        TEST_ASSERT_TRUE(is_close || found == expected);
        out += found < n_all;
        for (int32_t k = 0; k < found; k++) {
            rigcal_transform T;

            rc_optimum_transform(&T, &optima.list[k]);
            const double sum = sum_of(&behind, &s, n, index, &T);
            TEST_ASSERT_TRUE(rc_is_finite(optima.list[k].sse));
            TEST_ASSERT_GREATER_OR_EQUAL_INT(last_behind, behind);
            last_behind = behind;
            several_behind += behind > 1;
            if (behind == 0) {
                ASSERT_NEAR(sum, optima.list[k].sse, TOL(1e-6, 5e-2) * (sum + 1e-6));
            }
        }
    }
    TEST_ASSERT_GREATER_THAN_INT(50, out);
    TEST_ASSERT_GREATER_THAN_INT(10, several_behind);
}

/* Three points nearly on a line have no poses that could be starts. */
static void test_a_narrow_triple_gives_none(void)
{
    test_rng rng = test_seed(2602);

    for (int trial = 0; trial < 100; trial++) {
        rigcal_optima optima;
        scene s;

        make_scene(&s, &rng, 8, 0.05);
        optima.n = 0;
        TEST_ASSERT_EQUAL_INT32(0, find(&optima, &s.points));
    }
}

/* Points that all have one pixel have no pose. */
static void test_one_pixel_gives_none(void)
{
    test_rng rng = test_seed(2604);
    rigcal_optima optima;
    scene s;

    make_scene(&s, &rng, 6, 1);
    for (int i = 1; i < 6; i++) {
        memcpy(s.seen[i].uv, s.seen[0].uv, sizeof s.seen[i].uv);
    }
    optima.n = 0;
    TEST_ASSERT_EQUAL_INT32(0, find(&optima, &s.points));
}

/* Points that do not count are in no triple. Here the farthest point has a pixel that is
 * far off. */
static void test_only_points_that_count_do(void)
{
    test_rng rng = test_seed(2603);
    uint8_t mask[8] = {0, 1, 1, 1, 1, 1, 1, 1};

    for (int trial = 0; trial < 100; trial++) {
        rigcal_real uv_middle[2];
        rigcal_optima optima;
        int32_t at;
        scene s;

        make_scene(&s, &rng, 8, 1);
        s.seen[0].X_w[0] = RC(3);
        s.seen[0].uv[0] += RC(200);
        rc_points_of(&s.points, &VIEW(&s.camera, s.seen, NULL, 8), mask);
        ASSERT_STATUS(RIGCAL_OK, rc_points_survey(&s.points, uv_middle, &at));
        optima.n = 0;
        if (find(&optima, &s.points) > 0) {
            TEST_ASSERT_TRUE(off_truth(&s, &optima.list[0]) < TOL(1e-5, 0.02));
        }
    }
}

#endif

TEST_MAIN()
{
#if RIGCAL_FOR_SPEED && RIGCAL_WITH_THREE_POINTS
    RUN_TEST(test_the_truth_is_the_first);
    RUN_TEST(test_the_triple_is_the_widest);
    RUN_TEST(test_of_equal_points_the_first_ones_count);
    RUN_TEST(test_the_others_rule_poses_out);
    RUN_TEST(test_a_narrow_triple_gives_none);
    RUN_TEST(test_one_pixel_gives_none);
    RUN_TEST(test_only_points_that_count_do);
#endif
}
