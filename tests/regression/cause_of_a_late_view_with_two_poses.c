/* A flat board that is small in the image has two poses that fit nearly alike, and noise
 * may make the wrong one fit better. Only that pose was compared with the placements before
 * and after. So the cause of a late or early view was unknown if its better pose was the
 * wrong one: in 5 of 100 views of boards of 60 px. */
#include <string.h>

#include "test_boards.h"

static const double NOISE = 5; /* px. The board is some 200 px wide */

/* Scenes in which the better pose of the view is the wrong one. */
static const int SCENES[8] = {51, 148, 247, 356, 484, 499, 517, 553};

static test_boards b;

static void test_a_late_or_early_view_is_known_by_either_of_its_poses(void)
{
    TEST_WANTS_RAM(sizeof(test_boards) + 20000);
    for (int trial = 0; trial < TEST_TRIALS(8); trial++) {
        test_rng rng = test_seed(4110 + (uint64_t)SCENES[trial]);
        const int32_t shift = SCENES[trial] % 2 ? 1 : -1, f = 1 + SCENES[trial] % 8;
        rigcal_cause cause;
        rigcal_real angle;

        test_boards_make(&b, &rng, 4, 10, 4, NOISE, 0);
        const int v = test_boards_view(&b, 1, f);
        test_boards_replace(&b, v, test_boards_view(&b, 1, f + shift));
        test_boards_solve(&b);
        memcpy(b.cams, b.true_cams, sizeof b.cams);
        memcpy(b.places, b.true_places, sizeof b.places);
        const rigcal_transform seen =
            test_times(&b.true_cams[1], &b.true_places[f + shift]);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_rotation_angle(&angle, seen.R, b.own[v].cam_from_target.R));
        TEST_ASSERT_TRUE(D(angle) > 0.3);
        b.left_out[v] = 1;
        b.rig.left_out = b.left_out;
        b.judgement.sigma_px = RC(NOISE);
        b.judgement.scale = 1;
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_rig_cause(&cause, &b.rig, &b.judgement, NULL, (size_t)v));
        TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_SHIFTED, cause.cause);
        TEST_ASSERT_EQUAL_INT32(shift, cause.shift);
        TEST_ASSERT_EQUAL_INT32(0, cause.is_still);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_late_or_early_view_is_known_by_either_of_its_poses);
}
