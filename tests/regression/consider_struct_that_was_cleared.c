/* A struct of considered intrinsics that was set to zero and handed in again, while the rig
 * still pointed to it, was called through a pointer that is NULL. And after an error the
 * rig still pointed to what an earlier call had considered. */
#include <string.h>

#include "test_boards.h"

enum { CAMERAS = 2, PLACES = 3, WORK = RIGCAL_CONSIDER_WORK(CAMERAS, CAMERAS) };

static test_boards b;
static rigcal_intrinsics_sigma sigmas[CAMERAS];
static rigcal_real effects[WORK];

static void test_a_struct_may_be_cleared_and_handed_in_again(void)
{
    test_rng rng = test_seed(9401);
    rigcal_rig_fit fit;
    rigcal_real first[36], second[36];
    rigcal_considered considered = {.effects = effects, .capacity = WORK};

    test_boards_make(&b, &rng, CAMERAS, PLACES, CAMERAS, 0.3, 0);
    test_boards_solve(&b);
    sigmas[1].focal = RC(0.003);
    b.rig.intrinsics_sigmas = sigmas;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &b.rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &b.rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(first, &b.rig, RC(0.3), 1));
    considered = (rigcal_considered){.effects = effects, .capacity = WORK};
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &b.rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(second, &b.rig, RC(0.3), 1));
    TEST_ASSERT_EQUAL_MEMORY(first, second, sizeof first);
    considered.capacity = 0;
    ASSERT_STATUS(RIGCAL_ERR_CAPACITY, rigcal_rig_consider(&considered, NULL, &b.rig));
    TEST_ASSERT_NULL(b.rig.considered);
    considered.capacity = WORK;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &b.rig));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rig_estimate(NULL, NULL, &b.rig, RC(0.3)));
    TEST_ASSERT_NULL(b.rig.considered);
}

TEST_MAIN()
{
    RUN_TEST(test_a_struct_may_be_cleared_and_handed_in_again);
}
