/* If the wrong points of a wide target came first, nearly every robust pose was
 * RIGCAL_ERR_NO_POSE: the triples from which the last search starts held one
 * point twice. */
#include <math.h>
#include <string.h>

#include "test_support.h"

enum { N = 40, WRONG = 24 };

/* Points all around the camera, as a fisheye sees them. The first WRONG pixels are those of
 * no point. */
static void observe(rigcal_observation seen[N], const rigcal_camera *camera,
                    const double R[9], const double t[3], test_rng *rng)
{
    double back[9];

    test_transpose(back, R);
    for (int i = 0; i < N; i++) {
        const double theta = test_uniform(rng, 0.2, 1.8), phi = test_uniform(rng, 0, 6.28);
        const double far = test_uniform(rng, 0.5, 2);
        const double X_c[3] = {far * sin(theta) * cos(phi), far * sin(theta) * sin(phi),
                               far * cos(theta)};
        double from[3], X[3], uv[2];

        for (int k = 0; k < 3; k++) {
            from[k] = X_c[k] - t[k];
        }
        test_apply(X, back, from, NULL);
        test_project_px(uv, camera, X_c);
        for (int k = 0; k < 2; k++) {
            uv[k] =
                (i < WRONG) ? test_uniform(rng, 100, 900) : uv[k] + 0.2 * test_normal(rng);
        }
        test_to_real(seen[i].X_w, X, 3);
        test_to_real(seen[i].uv, uv, 2);
    }
}

static void test_wrong_points_that_come_first(void)
{
    static rigcal_observation seen[N];
    static uint8_t inliers[N];
    rigcal_camera camera = test_pinhole();
    test_rng rng = test_seed(12);

    TEST_WANTS_RAM(20000);
    camera.lens = RIGCAL_LENS_FISHEYE;
    camera.width = camera.height = 1000;
    camera.fx = camera.fy = RC(300);
    camera.cx = camera.cy = RC(500);
    for (int trial = 0; trial < TEST_TRIALS(20); trial++) {
        rigcal_pose poses[RIGCAL_POSES_MAX];
        size_t n_found, n_inliers;
        double R[9], t[3], found_R[9], found_t[3];

        test_random_rotation(R, &rng);
        for (int k = 0; k < 3; k++) {
            t[k] = test_uniform(&rng, -0.3, 0.3);
        }
        observe(seen, &camera, R, t, &rng);
        ASSERT_STATUS(RIGCAL_MOST_DISAGREE,
                      rigcal_robust_solve(poses, RIGCAL_POSES_MAX, &n_found, inliers,
                                          &n_inliers, NULL, &VIEW(&camera, seen, NULL, N),
                                          NULL));
        TEST_ASSERT_TRUE(n_inliers >= N - WRONG);
        test_transform_parts(found_R, found_t, &poses[0].cam_from_world);
        ASSERT_NEAR(0, test_angle_between(R, found_R), 0.003);
        for (int k = 0; k < 3; k++) {
            ASSERT_NEAR(t[k], found_t[k], 0.005);
        }
    }
}

TEST_MAIN()
{
    RUN_TEST(test_wrong_points_that_come_first);
}
