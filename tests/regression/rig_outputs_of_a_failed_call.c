/* rigcal_rig_weakest, _noise and _residuals wrote a part of their outputs before they found
 * an error. The manual promises that a failed call writes none. */
#include <string.h>

#include "test_rigs.h"

static test_rig r;

#define WANTS_RIG TEST_WANTS_RAM(sizeof(test_rig) + 12000)

/* An adjusted rig. Then the last point of the last view is moved behind its camera. */
static void make_rig_that_fails(void)
{
    test_rng rng = test_seed(22);
    rigcal_rig_fit fit;
    rigcal_transform target_from_cam;
    const rigcal_real behind[3] = {0, 0, -2};

    test_rig_random(&r, &rng, 2, 2, 6);
    test_rig_see_all(&r, &rng, 0.3);
    test_rig_solve_views(&r);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));

    const size_t last = r.rig.n_views - 1;
    const rigcal_transform chain = test_rig_chain(&r, r.views[last].camera, 1);
    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_invert(&target_from_cam, &chain));
    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_point(r.o[last][r.n_points - 1].X_w,
                                                    &target_from_cam, behind));
}

static void test_noise_of_a_view_that_fails(void)
{
    rigcal_real sigma_px[2], freedom[2], kept[2];

    WANTS_RIG;
    make_rig_that_fails();
    memset(freedom, 0x5A, sizeof freedom);
    memcpy(kept, freedom, sizeof kept);
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, sigma_px,
                   rigcal_rig_noise(sigma_px, freedom, &r.rig));
    TEST_ASSERT_EQUAL_MEMORY(kept, freedom, sizeof kept);
}

static void test_residuals_of_a_point_that_fails(void)
{
    rigcal_real duv[2 * RIG_POINTS_MAX];
    size_t n_written;

    WANTS_RIG;
    make_rig_that_fails();
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, duv,
                   rigcal_rig_residuals(duv, 2 * RIG_POINTS_MAX, &n_written, &r.rig,
                                        r.rig.n_views - 1));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_rig_residuals(duv, 2 * RIG_POINTS_MAX, &n_written, &r.rig, 0));
    TEST_ASSERT_EQUAL(r.n_points, n_written);
}

static void test_the_weakest_of_one_camera(void)
{
    test_rng rng = test_seed(23);
    rigcal_rig_fit fit;
    rigcal_weakest weakest;

    WANTS_RIG;
    test_rig_random(&r, &rng, 1, 2, 6);
    test_rig_see_all(&r, &rng, 0.3);
    test_rig_solve_views(&r);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, weakest, rigcal_rig_weakest(&weakest, &r.rig, 1));
}

TEST_MAIN()
{
    RUN_TEST(test_noise_of_a_view_that_fails);
    RUN_TEST(test_residuals_of_a_point_that_fails);
    RUN_TEST(test_the_weakest_of_one_camera);
}
