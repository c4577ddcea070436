/* AMBIGUOUS meant two different things: another pose fits nearly as well, or the data
 * hardly fix the pose. */
#include <math.h>
#include <string.h>

#include "test_support.h"

static void test_a_long_thin_target_far_away_is_vague(void)
{
    enum { N = 6 };
    static const double T[3] = {0, 0, 60};
    const rigcal_camera camera = test_pinhole();
    test_rng rng = test_seed(8);
    int vague = 0;

    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        rigcal_observation seen[N];
        rigcal_pose poses[RIGCAL_POSES_MAX];
        rigcal_pose_options options;
        size_t n_found;
        double R[9];

        test_rotation(R, 0, 0.3, 0.2);
        for (int i = 0; i < N; i++) {
            const double X[3] = {test_uniform(&rng, -0.5, 0.5),
                                 test_uniform(&rng, -0.005, 0.005),
                                 test_uniform(&rng, -0.005, 0.005)};
            double X_c[3], uv[2];

            test_apply(X_c, R, X, T);
            test_project_px(uv, &camera, X_c);
            for (int k = 0; k < 2; k++) {
                uv[k] += 0.3 * test_normal(&rng);
            }
            test_to_real(seen[i].X_w, X, 3);
            test_to_real(seen[i].uv, uv, 2);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_pose_defaults(&options));
        options.sigma_px = RC(0.3);
        vague += rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL,
                                   &VIEW(&camera, seen, NULL, N), &options) == RIGCAL_VAGUE;
    }
    TEST_ASSERT_TRUE(vague > TEST_TRIALS(100) * 9 / 10);
}

static void test_a_far_tag_is_ambiguous_with_two_poses(void)
{
    const rigcal_camera camera = test_pinhole();
    test_rng rng = test_seed(9);
    int ambiguous = 0;

    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        rigcal_real uv[8];
        rigcal_pose poses[RIGCAL_POSES_MAX];
        rigcal_pose_options options;
        size_t n_found;
        rigcal_status status;
        double R[9];
        static const double T[3] = {0.1, 0.2, 20};

        test_rotation(R, 0.5, 0.3, TEST_PI - 0.2);
        for (int i = 0; i < 4; i++) {
            const double X[3] = {i == 1 || i == 2 ? 0.5 : -0.5, i < 2 ? 0.5 : -0.5, 0};
            double X_c[3], pixel[2];

            test_apply(X_c, R, X, T);
            test_project_px(pixel, &camera, X_c);
            for (int k = 0; k < 2; k++) {
                uv[2 * i + k] = RC(pixel[k] + 0.3 * test_normal(&rng));
            }
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_pose_defaults(&options));
        options.sigma_px = RC(0.3);
        status = rigcal_tag_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL, &camera, uv, 1,
                                  &options);
        TEST_ASSERT_TRUE(status != RIGCAL_AMBIGUOUS || n_found == 2);
        ambiguous += status == RIGCAL_AMBIGUOUS;
    }
    TEST_ASSERT_TRUE(ambiguous > TEST_TRIALS(100) / 2);
}

TEST_MAIN()
{
    RUN_TEST(test_a_long_thin_target_far_away_is_vague);
    RUN_TEST(test_a_far_tag_is_ambiguous_with_two_poses);
}
