/* A ray that is nearly across the axis of camera b, and goes backwards, has its only place
 * in front of b a hundred focal lengths or more from the axis. The borders of the band are
 * farther from each other there than a polynomial can tell. It crossed the image, and spans
 * over half of it were returned. */
#include <math.h>
#include <string.h>

#include "test_support.h"

static void test_nothing_is_to_be_searched(void)
{
    test_rng rng = test_seed(23);
    int n_bands = 0;

    for (int trial = 0; trial < TEST_TRIALS(2000); trial++) {
        static rigcal_spans_solver solver;
        rigcal_span spans[8];
        const rigcal_real principal[2] = {320, 240};
        const double angle = acos(test_uniform(&rng, 1e-3, 1e-2));
        const double about = test_uniform(&rng, -3.14, 3.14);
        rigcal_camera camera = test_pinhole();
        rigcal_match_pair pair;
        rigcal_band band;
        size_t n_found;

        camera.cx = principal[0];
        camera.cy = principal[1];
        camera.k1 = RC(-0.02);
        camera.k2 = RC(0.05);
        memset(&pair, 0, sizeof pair);
        pair.camera_a = pair.camera_b = &camera;
        const rigcal_real w[3] = {RC(angle * cos(about)), RC(angle * sin(about)), 0};
        ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_vector(pair.b_from_a.R, w));
        pair.b_from_a.t[0] = RC(test_uniform(&rng, -1, 1));
        pair.b_from_a.t[1] = RC(test_uniform(&rng, -1, 1));
        pair.b_from_a.t[2] = RC(test_uniform(&rng, -1, -0.1));
        for (int i = 0; i < 6; i++) {
            pair.Sigma[7 * i] = RC(1e-6);
        }
        pair.sigma_a = pair.sigma_b = RC(0.3);
        pair.k = 3;
        if (rigcal_band_make(&band, &pair, principal) != RIGCAL_OK) {
            continue;
        }
        n_bands++;
        ASSERT_STATUS(RIGCAL_ERR_OUTSIDE,
                      rigcal_spans_find(spans, 8, &n_found, &solver, &band));
    }
    TEST_ASSERT_GREATER_THAN_INT(TEST_TRIALS(1000), n_bands);
}

TEST_MAIN()
{
    RUN_TEST(test_nothing_is_to_be_searched);
}
