/* The sigma of the points are relative to each other. If all were 0.1 in float, or 1e-4 in
 * double, exact poses of three points were dropped: in one scene of four the true one. */
#include <math.h>

#include "test_support.h"

static void assert_the_true_pose_is_found(double sigma)
{
    const rigcal_real sigmas[3] = {RC(sigma), RC(sigma), RC(sigma)};
    rigcal_camera camera = test_pinhole();
    test_rng rng = test_seed(14);

    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        rigcal_observation seen[3];
        rigcal_pose poses[RIGCAL_POSES_MAX];
        size_t n_found = 0;
        double R[9], least = 9;
        const double t[3] = {test_uniform(&rng, -1, 1), test_uniform(&rng, -0.5, 0.5),
                             test_uniform(&rng, 3, 8)};

        test_random_rotation(R, &rng);
        for (int i = 0; i < 3; i++) {
            double X[3], X_c[3], uv[2];

            for (int k = 0; k < 3; k++) {
                X[k] = test_uniform(&rng, -0.5, 0.5);
            }
            test_apply(X_c, R, X, t);
            test_project_px(uv, &camera, X_c);
            test_to_real(seen[i].X_w, X, 3);
            test_to_real(seen[i].uv, uv, 2);
        }
        TEST_ASSERT_TRUE(rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL,
                                           &VIEW(&camera, seen, sigmas, 3), NULL) >= 0);
        for (size_t i = 0; i < n_found; i++) {
            double found_R[9], found_t[3];

            test_transform_parts(found_R, found_t, &poses[i].cam_from_world);
            least = fmin(least, test_angle_between(R, found_R));
        }
        ASSERT_NEAR(0, least, 0.05);
    }
}

static void test_small_sigma(void)
{
    assert_the_true_pose_is_found(0.1);
    assert_the_true_pose_is_found(1e-4);
}

static void test_large_sigma(void)
{
    assert_the_true_pose_is_found(1000);
}

TEST_MAIN()
{
    RUN_TEST(test_small_sigma);
    RUN_TEST(test_large_sigma);
}
