/* rigcal_rig_choose believed a source of views that gave another number of points when it
 * was asked again. SIZE_MAX points made the estimated noise nearly 0. */
#include <string.h>

#include "test_boards.h"

enum { CAMERAS = 2, PLACES = 4, VIEWS = CAMERAS * PLACES };

static test_boards b;
static size_t calls[VIEWS],
    wrong_from; /* for the views from wrong_from on, at the second call */
static size_t wrong_n;

static rigcal_status pose_whose_count_changes(rigcal_view_pose *pose, size_t index,
                                              void *context)
{
    (void)context;
    *pose = b.own[index];
    if (++calls[index] == 2 && index >= wrong_from) {
        pose->n = wrong_n;
    }
    return RIGCAL_OK;
}

static rigcal_status choose(size_t from, size_t n)
{
    int32_t at_fault;

    memset(calls, 0, sizeof calls);
    wrong_from = from;
    wrong_n = n;
    b.choice.sigma_px = 0;
    return rigcal_rig_choose(&b.choice, &at_fault, &b.rig);
}

static void test_a_count_that_changes_is_no_count(void)
{
    static const size_t COUNTS[] = {SIZE_MAX, SIZE_MAX / 2, (size_t)1 << 30};
    test_rng rng = test_seed(5100);
    rigcal_real truth;

    TEST_WANTS_RAM(sizeof(test_boards) + 20000);
    test_boards_make(&b, &rng, CAMERAS, PLACES, CAMERAS, 0.3, 0);
    test_boards_solve(&b);
    b.rig.view_poses = NULL;
    b.rig.view_pose_source = pose_whose_count_changes;
    ASSERT_STATUS(RIGCAL_OK, choose(VIEWS, 0));
    truth = b.choice.sigma_px;
    TEST_ASSERT_TRUE(truth > RC(0.1) && truth < 1);
    for (int k = 0; k < 3; k++) {
        ASSERT_STATUS(RIGCAL_ERR_TOO_FEW, choose(0, COUNTS[k])); /* no view shows the
                                                                    noise */
        ASSERT_STATUS(RIGCAL_OK, choose(2, COUNTS[k]));          /* two do */
        TEST_ASSERT_TRUE(b.choice.sigma_px > RC(0.1) && b.choice.sigma_px < 1);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_count_that_changes_is_no_count);
}
