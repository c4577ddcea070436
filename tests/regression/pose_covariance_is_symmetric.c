/* rigcal_pose_covariance was symmetric only to rounding, but rigcal_store_save keeps only
 * one triangle. */
#include <math.h>
#include <string.h>

#include "test_support.h"

static void test_to_the_last_bit(void)
{
    const rigcal_camera camera = test_pinhole();
    test_rng rng = test_seed(15);

    for (int trial = 0; trial < TEST_TRIALS(200); trial++) {
        rigcal_observation seen[6];
        rigcal_pose_uncertainty u;
        rigcal_transform pose;
        test_scene scene;

        test_scene_random(&scene, &rng, 6, TEST_GENERAL);
        test_observations(seen, &scene, &camera);
        pose = test_transform(scene.R, scene.t);
        ASSERT_STATUS(RIGCAL_OK, rigcal_pose_covariance(&u, &VIEW(&camera, seen, NULL, 6),
                                                        &pose, RC(0.5)));
        for (int i = 0; i < 6; i++) {
            for (int j = 0; j < i; j++) {
                TEST_ASSERT_EQUAL_MEMORY(&u.Sigma[6 * i + j], &u.Sigma[6 * j + i],
                                         sizeof u.Sigma[0]);
            }
        }
    }
}

TEST_MAIN()
{
    RUN_TEST(test_to_the_last_bit);
}
