/* A single pixel beyond the lens's turning point made a whole view of 70 points fail. */
#include <math.h>
#include <string.h>

#include "test_support.h"

enum { N = TEST_MANY };

static void test_the_others_give_the_pose(void)
{
    static const double T[3] = {0.05, 0.02, 3};
    test_rng rng = test_seed(4);
    static rigcal_observation seen[N];
    rigcal_camera camera = test_pinhole();
    rigcal_pose poses[RIGCAL_POSES_MAX];
    rigcal_pose_options options;
    double R[9], found_R[9], found_t[3];

    camera.k1 = RC(-0.3); /* folds at 46 degrees, 622 px from the middle */
    for (int trial = 0; trial < TEST_TRIALS(20); trial++) {
        const int unseen = (int)test_uniform(&rng, 0, N);
        int32_t at_fault = -2;
        size_t n_found;

        test_random_rotation(R, &rng);
        for (int i = 0; i < N; i++) {
            double X[3], X_c[3], uv[2];

            for (int k = 0; k < 3; k++) {
                X[k] = test_uniform(&rng, -0.5, 0.5);
            }
            test_to_real(seen[i].X_w, X, 3);
            test_to_double(X, seen[i].X_w, 3);
            test_apply(X_c, R, X, T);
            test_project_px(uv, &camera, X_c);
            test_to_real(seen[i].uv, uv, 2);
        }
        seen[unseen].uv[0] = RC(1000 + 100 * trial);
        ASSERT_STATUS(RIGCAL_OK, rigcal_pose_defaults(&options));
        options.use_start = trial % 2; /* also from a previous pose */
        options.start = test_transform(R, T);
        ASSERT_STATUS(RIGCAL_UNSEEN_POINT,
                      rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, &at_fault,
                                        &VIEW(&camera, seen, NULL, N), &options));
        TEST_ASSERT_EQUAL_INT32(unseen, at_fault);
        test_transform_parts(found_R, found_t, &poses[0].cam_from_world);
        ASSERT_NEAR(0, test_angle_between(R, found_R), TOL(1e-8, 1e-3));
        TEST_ASSERT_TRUE(D(poses[0].rms_px) < TOL(1e-6, 1e-2));
    }
}

/* Two such pixels are refused. So is one of three. */
static void test_two_are_refused(void)
{
    static const double T[3] = {0, 0, 3};
    test_rng rng = test_seed(5);
    rigcal_camera camera = test_pinhole();
    rigcal_observation seen[6];
    rigcal_pose poses[1];
    size_t n_found;
    int32_t at_fault;

    camera.k1 = RC(-0.3);
    for (int i = 0; i < 6; i++) {
        double X[3], X_c[3], uv[2];

        for (int k = 0; k < 3; k++) {
            X[k] = test_uniform(&rng, -0.5, 0.5);
            X_c[k] = X[k] + T[k];
        }
        test_project_px(uv, &camera, X_c);
        test_to_real(seen[i].X_w, X, 3);
        test_to_real(seen[i].uv, uv, 2);
    }
    seen[1].uv[0] = RC(1500);
    ASSERT_STATUS(RIGCAL_ERR_NO_RAY,
                  rigcal_pose_solve(poses, 1, &n_found, &at_fault,
                                    &VIEW(&camera, seen, NULL, 3), NULL));
    TEST_ASSERT_EQUAL_INT32(1, at_fault);
    seen[4].uv[0] = RC(1500);
    ASSERT_STATUS(RIGCAL_ERR_NO_RAY,
                  rigcal_pose_solve(poses, 1, &n_found, &at_fault,
                                    &VIEW(&camera, seen, NULL, 6), NULL));
    TEST_ASSERT_EQUAL_INT32(4, at_fault);
}

/* If the rays surround the camera, pixels after the first one that was far off were never
 * looked at. A pixel without a ray then used whatever was on the stack. */
static void test_one_of_a_target_that_surrounds_the_camera(void)
{
    enum { AROUND = 40 }; /* more points than the triples use */
    static const double T[3] = {0.1, -0.2, 0.05};
    test_rng rng = test_seed(6);
    rigcal_observation seen[AROUND];
    rigcal_pose poses[RIGCAL_POSES_MAX];
    rigcal_camera camera = test_pinhole();

    camera.lens = RIGCAL_LENS_FISHEYE;
    camera.fx = camera.fy = RC(120);
    for (int trial = 0; trial < TEST_TRIALS(AROUND); trial++) {
        const int unseen = trial % AROUND;
        int32_t at_fault = -2;
        size_t n_found;
        double R[9], back[9], found_R[9], found_t[3];

        test_random_rotation(R, &rng);
        test_transpose(back, R);
        for (int i = 0; i < AROUND; i++) {
            const double theta = test_uniform(&rng, 1, 2.4),
                         phi = test_uniform(&rng, 0, 6.2);
            const double far = test_uniform(&rng, 1, 3);
            const double X_c[3] = {far * sin(theta) * cos(phi), far * sin(theta) * sin(phi),
                                   far * cos(theta)};
            double from[3], X[3], uv[2];

            for (int k = 0; k < 3; k++) {
                from[k] = X_c[k] - T[k];
            }
            test_apply(X, back, from, NULL);
            test_project_px(uv, &camera, X_c);
            test_to_real(seen[i].X_w, X, 3);
            test_to_real(seen[i].uv, uv, 2);
        }
        seen[unseen].uv[0] = camera.cx + RC(120 * 3.2);
        seen[unseen].uv[1] = camera.cy;
        ASSERT_STATUS(RIGCAL_UNSEEN_POINT,
                      rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, &at_fault,
                                        &VIEW(&camera, seen, NULL, AROUND), NULL));
        TEST_ASSERT_EQUAL_INT32(unseen, at_fault);
        test_transform_parts(found_R, found_t, &poses[0].cam_from_world);
        ASSERT_NEAR(0, test_angle_between(R, found_R), TOL(1e-8, 1e-3));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_the_others_give_the_pose);
    RUN_TEST(test_one_of_a_target_that_surrounds_the_camera);
    RUN_TEST(test_two_are_refused);
}
