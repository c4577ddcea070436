/* intrinsics: how a projection changes with the camera's intrinsics. The truth is the
 * projection by the formulas of rigcal.h with other intrinsics. It is linear in each of
 * them, so a difference quotient is exact. */
#include <math.h>

#include "rc_intrinsics.h"
#include "test_lenses.h"

/* The camera with parameter `which` larger by `step`. */
static rigcal_camera changed(const rigcal_camera *camera, int which, double step)
{
    rigcal_camera c = *camera;

    switch (which) {
    case RC_BY_FOCAL:
        c.fx = RC(D(c.fx) * (1 + step));
        c.fy = RC(D(c.fy) * (1 + step));
        break;
    case RC_BY_ASPECT:
        c.fx = RC(D(c.fx) * (1 + step / 2));
        c.fy = RC(D(c.fy) * (1 - step / 2));
        break;
    case RC_BY_CENTRE:
        c.cx = RC(D(c.cx) + step);
        break;
    case RC_BY_CENTRE + 1:
        c.cy = RC(D(c.cy) + step);
        break;
    case RC_BY_K1:
        c.k1 = RC(D(c.k1) + step);
        break;
    default:
        c.k2 = RC(D(c.k2) + step);
        break;
    }
    return c;
}

static void test_the_derivatives_are_differences(void)
{
    int n = 0;

    for (int lens = 0; lens < TEST_N_LENSES; lens++) {
        const rigcal_camera camera = test_lens_camera(&TEST_LENSES[lens]);
        test_rng rng = test_seed(7100 + (uint64_t)lens);

        for (int trial = 0; trial < TEST_TRIALS(40); trial++) {
            const test_polar at =
                test_polar_at(test_uniform(&rng, 0, 1), test_uniform(&rng, 0, 2 * TEST_PI));
            double ray[3], uv_seen[2];
            rigcal_real X_c[3], x[2], uv[2], B[6], seen[2 * RC_INTRINSICS];

            test_polar_ray(ray, &camera, at);
            test_to_real(X_c, ray, 3);
            test_to_double(ray, X_c, 3);
            if (rigcal_camera_project(uv, &camera, X_c) != RIGCAL_OK) {
                continue;
            }
            test_project_px(uv_seen, &camera, ray);
            if (!test_is_in_reach(&camera, uv_seen)) {
                continue;
            }
            ASSERT_STATUS(RIGCAL_OK, rc_project_by(x, uv, B, &camera, X_c));
            ASSERT_ARRAY_NEAR(uv_seen, uv, 2, 10 * TEST_PX);
            rc_intrinsics(seen, &camera, x, uv);
            for (int which = 0; which < RC_INTRINSICS; which++) {
                const rigcal_camera more = changed(&camera, which, 0.5);
                double there[2];

                test_project_px(there, &more, ray);
                for (int row = 0; row < 2; row++) {
                    const double slope = (there[row] - uv_seen[row]) / 0.5;

                    ASSERT_NEAR(slope, seen[RC_INTRINSICS * row + which],
                                TOL(1e-9, 1e-4) * (10 + fabs(slope)));
                }
            }
            n++;
        }
    }
    TEST_ASSERT_TRUE(n > TEST_TRIALS(40) * TEST_N_LENSES / 2);
}

TEST_MAIN()
{
    RUN_TEST(test_the_derivatives_are_differences);
}
