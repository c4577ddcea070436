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

    while (!rc_roots_step(optima, &n, &triple, points)) {
        TEST_ASSERT_LESS_THAN_INT32(5 + RC_P3P_MAX, triple.count);
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
        memset(&optima, 0, sizeof optima); /* what is beyond the list fits exactly */
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
    RUN_TEST(test_a_narrow_triple_gives_none);
    RUN_TEST(test_one_pixel_gives_none);
    RUN_TEST(test_only_points_that_count_do);
#endif
}
