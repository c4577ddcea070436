/* If fx was much larger than fy, or smaller, pixels of a lens with distortion had no ray:
 * rounding of the shorter side, counted in pixels of the longer one, was above the
 * tolerance. A pose that took these pixels for seen then read rays that were never
 * written. */
#include <math.h>

#include "test_support.h"

static void test_pixels_of_unequal_focal_lengths_have_rays(void)
{
    static const double FOCAL[3][2] = {{1e9, 2487}, {800, 1e9}, {1e5, 500}};

    for (int k = 0; k < 3; k++) {
        const double least = fmin(FOCAL[k][0], FOCAL[k][1]); /* all pixels are near */
        test_rng rng = test_seed(77 + (uint64_t)k);
        rigcal_camera camera = test_pinhole();

        camera.fx = RC(FOCAL[k][0]);
        camera.fy = RC(FOCAL[k][1]);
        camera.k1 = RC(-0.05);
        camera.p1 = RC(3e-4);
        for (int trial = 0; trial < TEST_TRIALS(200); trial++) {
            const double x = test_uniform(&rng, -0.6, 0.6) * least / FOCAL[k][0];
            const double y = test_uniform(&rng, -0.6, 0.6) * least / FOCAL[k][1];
            const double X_c[3] = {x, y, 1};
            const double length = sqrt(X_c[0] * X_c[0] + X_c[1] * X_c[1] + 1);
            double uv[2];
            rigcal_real seen[2], ray[3];

            test_project_px(uv, &camera, X_c);
            test_to_real(seen, uv, 2);
            ASSERT_STATUS(RIGCAL_OK, rigcal_camera_ray(ray, &camera, seen));
            for (int i = 0; i < 3; i++) {
                ASSERT_NEAR(X_c[i] / length, ray[i], TOL(1e-12, 1e-5));
            }
        }
    }
}

TEST_MAIN()
{
    RUN_TEST(test_pixels_of_unequal_focal_lengths_have_rays);
}
