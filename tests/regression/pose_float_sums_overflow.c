/* In float the rule by which a refinement ends squared a gain of 1e22 px^2. Both sides were
 * infinite, so the search ended where it was, and a wrong pose was returned as the first,
 * with an error of 0. A strong lens makes such sums of pixels far outside the image. The
 * sum of a pose must be that of its pixels. */
#include <math.h>

#include "test_support.h"

static const rigcal_observation SEEN[] = {
    {{RC(0.084914394), RC(-0.35600880), 0}, {RC(3180.0059), RC(2276.3723)}},
    {{RC(0.030678345), RC(-0.11387710), 0}, {RC(1888.4230), RC(1486.1803)}},
    {{RC(-0.46440026), RC(0.0081632277), 0}, {RC(789.61749), RC(1853.4226)}},
    {{RC(-0.068309613), RC(0.46854150), 0}, {RC(832.30621), RC(326.74725)}},
    {{RC(0.26842636), RC(-0.40321213), 0}, {RC(20019.975), RC(4432.1948)}},
    {{RC(0.23443298), RC(-0.21297078), 0}, {RC(4408.0576), RC(1174.8502)}},
    {{RC(0.044475459), RC(0.36219725), 0}, {RC(1202.5840), RC(302.09891)}},
    {{RC(0.14594543), RC(0.41715196), 0}, {RC(1439.0121), RC(-990.88110)}},
    {{RC(0.40309790), RC(0.44863251), 0}, {RC(11892.515), RC(-31442.930)}},
};

static void test_the_error_of_a_pose_is_that_of_its_pixels(void)
{
    const rigcal_camera camera = {RIGCAL_LENS_BROWN,
                                  2998,
                                  3770,
                                  RC(1755.88025),
                                  RC(1773.90588),
                                  RC(1174.48083),
                                  RC(1573.33582),
                                  RC(-0.533697188),
                                  RC(0.889125884),
                                  0,
                                  0,
                                  RC(0.89125222),
                                  0,
                                  0,
                                  0};
    const rigcal_view view = VIEW(&camera, SEEN, NULL, 9);
    rigcal_pose poses[RIGCAL_POSES_MAX];
    size_t n_found;
    const rigcal_status status =
        rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL, &view, NULL);

    TEST_ASSERT_TRUE(status >= 0);
    for (size_t k = 0; k < n_found; k++) {
        rigcal_real rms_px;

        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_view_rms(&rms_px, NULL, &view, &poses[k].cam_from_world));
        TEST_ASSERT_TRUE(D(rms_px) <= D(poses[k].rms_px) * 1.1 + 0.1);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_the_error_of_a_pose_is_that_of_its_pixels);
}
