/* Right views of a flat board were left out if their own poses are uncertain: noise turns
 * such a pose by 0.2 rad or more, or flips it. The cost of a view that the choice left out
 * was the distance of its pose, which takes errors for linear. So the cost was above the
 * limit, although the view's points fit where the others put the board. */
#include "test_boards.h"

static const double NOISE = 6; /* px. The board is some 200 px wide */

static test_boards b;

static void test_right_views_of_uncertain_poses_stay(void)
{
    size_t doubted = 0;

    TEST_WANTS_RAM(sizeof(test_boards) + 20000);
    for (int trial = 0; trial < TEST_TRIALS(40); trial++) {
        test_rng rng = test_seed(3110 + (uint64_t)trial);
        int32_t at_fault;

        test_boards_make(&b, &rng, 4, 10, 4, NOISE, 0);
        test_boards_solve(&b);
        b.rig.sigma_px = RC(NOISE);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_choose(&b.choice, &at_fault, &b.rig));
        doubted += b.choice.n_left_out;
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_judge(&b.judgement, &at_fault, b.judged,
                                                  b.left_out, &b.choice, &b.rig));
        TEST_ASSERT_EQUAL_INT32((int32_t)b.rig.n_views, b.judgement.n_fit);
        for (size_t v = 0; v < b.rig.n_views; v++) {
            TEST_ASSERT_TRUE(b.left_out[v] == 0 && b.judged[v].cost < 1);
            TEST_ASSERT_TRUE(b.takes[v] != RIGCAL_TAKES_NONE);
        }
        TEST_ASSERT_TRUE(test_boards_error(&b, RC(NOISE)) < 2);
    }
    TEST_ASSERT_TRUE(doubted > 0 || TEST_TRIALS(40) < 40);
}

TEST_MAIN()
{
    RUN_TEST(test_right_views_of_uncertain_poses_stay);
}
