/* Points in normalised coordinates, with focal length 1, were always AMBIGUOUS, because the
 * assumed noise was in pixels. Good and bad fits were both OK. */
#include <math.h>
#include <string.h>

#include "test_support.h"

static void scaled(rigcal_camera *camera, rigcal_observation out[],
                   const rigcal_observation in[], int n, double by)
{
    camera->fx = RC(D(camera->fx) * by);
    camera->fy = RC(D(camera->fy) * by);
    camera->cx = RC(D(camera->cx) * by);
    camera->cy = RC(D(camera->cy) * by);
    for (int i = 0; i < n; i++) {
        out[i] = in[i];
        for (int k = 0; k < 2; k++) {
            out[i].uv[k] = RC(D(in[i].uv[k]) * by);
        }
    }
}

/* The same scene in pixels and in normalised coordinates. */
static void test_the_statuses_are_those_of_pixels(void)
{
    enum { N = 8 };
    test_rng rng = test_seed(6);
    int same = 0, ok = 0;

    for (int trial = 0; trial < TEST_TRIALS(300); trial++) {
        rigcal_camera camera = test_pinhole();
        rigcal_observation seen[N], small[N];
        rigcal_pose poses[RIGCAL_POSES_MAX];
        test_scene scene;
        size_t n_found;
        rigcal_status status[2];

        test_scene_random(&scene, &rng, N, trial % 2 ? TEST_PLANAR : TEST_GENERAL);
        test_observations(seen, &scene, &camera);
        for (int i = 0; i < N; i++) {
            for (int k = 0; k < 2; k++) {
                seen[i].uv[k] = RC(D(seen[i].uv[k]) + 0.3 * test_normal(&rng));
            }
        }
        for (int k = 0; k < 2; k++) {
            if (k == 1) {
                scaled(&camera, small, seen, N, 1 / D(camera.fx));
            }
            status[k] = rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL,
                                          &VIEW(&camera, k ? small : seen, NULL, N), NULL);
            TEST_ASSERT_TRUE(status[k] >= 0);
        }
        same += status[0] == status[1];
        ok += status[1] == RIGCAL_OK;
    }
    TEST_ASSERT_TRUE(ok > TEST_TRIALS(300) * 3 / 4);
    TEST_ASSERT_TRUE(same >= TEST_TRIALS(300) - 3); /* some are near the limits of a
                                                       verdict */
}

static void test_a_bad_fit_is_poor(void)
{
    enum { N = 8 };
    test_rng rng = test_seed(7);
    rigcal_camera camera = test_pinhole();
    rigcal_observation seen[N], small[N];
    rigcal_pose poses[RIGCAL_POSES_MAX];
    test_scene scene;
    size_t n_found;

    test_scene_random(&scene, &rng, N, TEST_GENERAL);
    test_observations(seen, &scene, &camera);
    seen[3].uv[1] += 60;
    scaled(&camera, small, seen, N, 1 / D(camera.fx));
    ASSERT_STATUS(RIGCAL_POOR_FIT,
                  rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL,
                                    &VIEW(&camera, small, NULL, N), NULL));
}

TEST_MAIN()
{
    RUN_TEST(test_the_statuses_are_those_of_pixels);
    RUN_TEST(test_a_bad_fit_is_poor);
}
