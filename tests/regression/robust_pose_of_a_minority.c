/* If 10 of 40 points agree on the pose of a grid of tags that is shifted by one tag, the
 * status was OK, although most points disagree. */
#include <math.h>
#include <string.h>

#include "test_support.h"

enum { SIDE = 5, TAGS = 10, N = 4 * TAGS };

/* Ten tags in two rows of five. The names of all tags except the last two of each row are
 * shifted by one. Those two are right. */
static void test_most_disagree_is_told(void)
{
    const rigcal_camera camera = test_pinhole();
    static rigcal_observation seen[N];
    static uint8_t inliers[N];
    static const double T[3] = {0.1, 0, 8};
    rigcal_pose poses[RIGCAL_POSES_MAX];
    rigcal_robust_options options;
    size_t n_found, n_inliers;
    double R[9];
    test_rng rng = test_seed(10);

    TEST_WANTS_RAM(20000);
    test_rotation(R, 0.2, 0.4, 0.3);
    for (int i = 0; i < N; i++) {
        const int tag = i / 4, column = tag % SIDE, row = tag / SIDE, corner = i % 4;
        const double x = column + (corner == 1 || corner == 2 ? 0.5 : 0);
        const double y = row + (corner >= 2 ? 0.5 : 0);
        const double bump = 0.3 * sin(2.0 * tag + corner); /* not a plane */
        const double X[3] = {x, y, bump};
        double X_c[3], uv[2], X_named[3] = {x, y, bump};

        test_apply(X_c, R, X, T);
        test_project_px(uv, &camera, X_c);
        for (int k = 0; k < 2; k++) {
            uv[k] += 0.3 * test_normal(&rng);
        }
        if (tag >= 2 + 1) { /* seven wrong tags, each at another wrong place */
            X_named[0] += 0.7 + 0.31 * tag;
            X_named[2] -= 0.2 * tag;
        }
        test_to_real(seen[i].X_w, X_named, 3);
        test_to_real(seen[i].uv, uv, 2);
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&options));
    options.samples = 5000;
    ASSERT_STATUS(RIGCAL_MOST_DISAGREE,
                  rigcal_robust_solve(poses, RIGCAL_POSES_MAX, &n_found, inliers,
                                      &n_inliers, NULL, &VIEW(&camera, seen, NULL, N),
                                      &options));
    TEST_ASSERT_TRUE(n_inliers >= 12 && n_inliers < N / 2);
}

/* A real shift: every tag except the last has the coordinates of its neighbour. */
static void test_half_that_agree_are_enough(void)
{
    const rigcal_camera camera = test_pinhole();
    test_rng rng = test_seed(11);
    rigcal_observation seen[20];
    uint8_t inliers[20];
    rigcal_pose poses[RIGCAL_POSES_MAX];
    test_scene scene;
    size_t n_found, n_inliers;

    test_scene_random(&scene, &rng, 20, TEST_GENERAL);
    test_observations(seen, &scene, &camera);
    for (int i = 0; i < 8; i++) {
        seen[i].uv[0] = RC(test_uniform(&rng, 0, 639));
        seen[i].uv[1] = RC(test_uniform(&rng, 0, 479));
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_solve(poses, RIGCAL_POSES_MAX, &n_found, inliers,
                                                 &n_inliers, NULL,
                                                 &VIEW(&camera, seen, NULL, 20), NULL));
}

TEST_MAIN()
{
    RUN_TEST(test_most_disagree_is_told);
    RUN_TEST(test_half_that_agree_are_enough);
}
