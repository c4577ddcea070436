/* Two points at the rim of a lens's field, whose pixels noise had moved beyond it, made a
 * robust pose of many right points fail with RIGCAL_ERR_NO_RAY. One such point gave
 * RIGCAL_UNSEEN_POINT, which the header did not name. */
#include <math.h>
#include <string.h>

#include "rigcal_solvers.h"
#include "test_support.h"

enum { N = 20, AT_RIM = 2 };

static rigcal_camera camera;
static rigcal_observation seen[N];
static uint8_t inliers[N];

/* The lens 1 - 0.3 r^2 folds at r = 1.0541, where the image of a ray is 0.70273 from the
 * axis. A ray at r = 1.03 is imaged at 0.70218. AT_RIM points, from `rim` on, have such
 * rays, and pixels at 0.7045: off by 0.0023 of the focal length, and beyond the fold. */
static void observe(double R[9], int rim, test_rng *rng)
{
    static const double T[3] = {0.1, -0.2, 0.3};
    double back[9];

    camera = test_pinhole();
    camera.k1 = RC(-0.3);
    test_random_rotation(R, rng);
    test_transpose(back, R);
    for (int i = 0; i < N; i++) {
        const int is_at_rim = i >= rim && i < rim + AT_RIM;
        const double phi = test_uniform(rng, 0, 6.28), far = test_uniform(rng, 1, 3);
        const double r = is_at_rim ? 1.03 : test_uniform(rng, 0.2, 0.6);
        const double off = is_at_rim ? 0.7045 : r * (1 - 0.3 * r * r);
        const double X_c[3] = {far * r * cos(phi), far * r * sin(phi), far};
        const double uv[2] = {D(camera.cx) + D(camera.fx) * off * cos(phi),
                              D(camera.cy) + D(camera.fy) * off * sin(phi)};
        double from[3], X[3];

        for (int k = 0; k < 3; k++) {
            from[k] = X_c[k] - T[k];
        }
        test_apply(X, back, from, NULL);
        test_to_real(seen[i].X_w, X, 3);
        test_to_real(seen[i].uv, uv, 2);
    }
}

static void test_a_pixel_without_a_ray_is_wrong(void)
{
    test_rng rng = test_seed(13);

    TEST_WANTS_RAM(20000);
    for (int trial = 0; trial < TEST_TRIALS(20); trial++) {
        rigcal_pose poses[RIGCAL_POSES_MAX];
        size_t n_found, n_inliers;
        double R[9], found_R[9], found_t[3];

        observe(R, N - AT_RIM, &rng);
        ASSERT_STATUS(RIGCAL_OK, rigcal_robust_solve(poses, RIGCAL_POSES_MAX, &n_found,
                                                     inliers, &n_inliers, NULL,
                                                     &VIEW(&camera, seen, NULL, N), NULL));
        for (int i = 0; i < N; i++) {
            TEST_ASSERT_EQUAL_INT(i < N - AT_RIM, inliers[i]);
        }
        TEST_ASSERT_EQUAL_size_t(N - AT_RIM, n_inliers);
        test_transform_parts(found_R, found_t, &poses[0].cam_from_world);
        ASSERT_NEAR(0, test_angle_between(R, found_R), TOL(1e-8, 1e-3));
        ASSERT_NEAR(0, D(poses[0].rms_px), TOL(1e-6, 1e-2));
    }
}

/* Wherever the search of triples ends. */
static void test_a_pixel_without_a_ray_is_wrong_after_few_triples(void)
{
    rigcal_robust_options options;
    test_rng rng = test_seed(14);
    double R[9];
    int solved = 0;

    TEST_WANTS_RAM(20000);
    observe(R, 0, &rng);
    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    for (int32_t units = 1; units < 60; units++) {
        rigcal_pose pose;
        size_t n_found, n_inliers;

        options.max_units = units;
        const rigcal_status status =
            rigcal_robust_solve(&pose, 1, &n_found, inliers, &n_inliers, NULL,
                                &VIEW(&camera, seen, NULL, N), &options);
        TEST_ASSERT_NOT_EQUAL(RIGCAL_ERR_NO_RAY, status);
        TEST_ASSERT_NOT_EQUAL(RIGCAL_UNSEEN_POINT, status);
        if (status == RIGCAL_OK) {
            solved++;
            TEST_ASSERT_EQUAL_size_t(N - AT_RIM, n_inliers);
            TEST_ASSERT_EQUAL_INT(0, inliers[0]);
            TEST_ASSERT_EQUAL_INT(0, inliers[1]);
        }
    }
    TEST_ASSERT_GREATER_THAN_INT(10, solved);
}

/* The units of a search with max_units. *tried gets its triples. */
static int units_of(int32_t *tried, const rigcal_view *view, int32_t max_units)
{
    static rigcal_robust_solver solver;
    rigcal_robust_options options;
    int units = 1;

    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    options.max_units = max_units;
    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_begin(&solver, inliers, NULL, view, &options));
    while (rigcal_robust_step(&solver, 1) == RIGCAL_RUNNING) {
        units++;
    }
    *tried = solver.tried;
    return units;
}

/* The rays at last do not count in max_units: where the same triples were tried, the units
 * are the same. */
static void test_only_triples_count_in_max_units(void)
{
    test_rng rng = test_seed(15);
    double R[9];
    int32_t all, tried;
    int same = 0;

    TEST_WANTS_RAM(20000);
    observe(R, 0, &rng);
    const rigcal_view view = VIEW(&camera, seen, NULL, N);
    const int units = units_of(&all, &view, 100000);
    for (int32_t most = 1; most < units; most++) {
        const int now = units_of(&tried, &view, most);

        if (tried == all) {
            TEST_ASSERT_EQUAL_INT(units, now);
            same++;
        }
    }
    TEST_ASSERT_GREATER_THAN_INT(N, same);
}

TEST_MAIN()
{
    RUN_TEST(test_a_pixel_without_a_ray_is_wrong);
    RUN_TEST(test_a_pixel_without_a_ray_is_wrong_after_few_triples);
    RUN_TEST(test_only_triples_count_in_max_units);
}
