/* A Sigma with a correlation beyond 1 gave a band with a negative variance of the epipole,
 * which rigcal_spans_begin and rigcal_band_test then refused. */
#include "test_support.h"

static void test_a_band_is_one_that_others_take(void)
{
    static rigcal_spans_solver solver;
    const rigcal_camera camera = test_pinhole();
    test_rng rng = test_seed(51);
    int n_made = 0;

    TEST_WANTS_RAM(sizeof solver + 8000);
    for (int trial = 0; trial < TEST_TRIALS(400); trial++) {
        rigcal_match_pair pair = {
            .camera_a = &camera,
            .camera_b = &camera,
            .b_from_a = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {RC(-0.1), RC(-0.1), RC(-0.1)}},
            .sigma_a = RC(0.2),
            .sigma_b = RC(0.2),
            .k = 2};
        const rigcal_real uv_a[2] = {RC(test_uniform(&rng, 0, 640)),
                                     RC(test_uniform(&rng, 0, 480))};
        rigcal_band band;

        for (int i = 3; i < 6; i++) {
            for (int j = 3; j < 6; j++) {
                pair.Sigma[6 * i + j] = RC(i == j ? 1e-12 : test_uniform(&rng, 0, 1e-8));
            }
        }
        if (rigcal_band_make(&band, &pair, uv_a) == RIGCAL_OK) {
            TEST_ASSERT_TRUE(band.epipole2 >= 0 && band.epipole2 < RC(1e-6));
            ASSERT_STATUS(RIGCAL_OK, rigcal_spans_begin(&solver, &band));
            n_made++;
        }
    }
    TEST_ASSERT_TRUE(n_made > 0);
}

TEST_MAIN()
{
    RUN_TEST(test_a_band_is_one_that_others_take);
}
