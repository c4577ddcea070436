/* The chance that wrong points agree was computed for the rectangle of all pixels. One
 * pixel far outside the image made it nearly 0, and four of eight wrong points were
 * believed. */
#include "test_support.h"

enum { N = 8 };

static void test_a_pixel_far_away_lends_no_belief(void)
{
    const rigcal_camera camera = test_pinhole();
    test_rng rng = test_seed(13);
    int believed = 0;

    for (int trial = 0; trial < TEST_TRIALS(60); trial++) {
        rigcal_observation seen[N];
        rigcal_pose poses[RIGCAL_POSES_MAX];
        uint8_t inliers[N];
        test_scene scene;
        size_t n_found, n_inliers;

        test_scene_random(&scene, &rng, N, TEST_GENERAL);
        test_observations(seen, &scene, &camera);
        for (int i = 0; i < N; i++) {
            seen[i].uv[0] = RC(test_uniform(&rng, 280, 360));
            seen[i].uv[1] = RC(test_uniform(&rng, 200, 280));
        }
        seen[3].uv[0] = RC(1e6);
        seen[4].uv[1] = RC(-1e6);
        const rigcal_status status =
            rigcal_robust_solve(poses, RIGCAL_POSES_MAX, &n_found, inliers, &n_inliers,
                                NULL, &VIEW(&camera, seen, NULL, N), NULL);
        believed += status >= 0 && status != RIGCAL_FEW_AGREE;
    }
    TEST_ASSERT_EQUAL_INT(0, believed);
}

TEST_MAIN()
{
    RUN_TEST(test_a_pixel_far_away_lends_no_belief);
}
