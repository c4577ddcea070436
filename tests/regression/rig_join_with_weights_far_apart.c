/* Two weights within their range, 1e-300 and 1e30, gave ERR_ROTATION for two equal poses.
 * Information has replaced the weights. The join accepts any scale, and two scales as far
 * apart as a sum can hold. If they are farther apart, the sum holds only one of them: the
 * result is ERR_DEGENERATE, or the same pose. */
#include <string.h>

#include "test_support.h"

static void give(rigcal_view_pose *pose, double information, int32_t camera)
{
    static const rigcal_transform SAME = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    static const int DIAGONAL[6] = {0, 3, 5, 15, 18, 20};

    memset(pose, 0, sizeof *pose);
    pose->cam_from_target = SAME;
    pose->n = 6;
    pose->camera = camera;
    for (int k = 0; k < 6; k++) {
        pose->information[DIAGONAL[k]] = RC(information);
    }
}

static rigcal_status join(rigcal_transform cams[2], double first, double second)
{
    rigcal_view_pose poses[2];
    rigcal_transform places[1];
    rigcal_real work[RIGCAL_RIG_WORK(1, 2, 1)];
    int32_t group[2], at_fault;
    rigcal_rig rig = {0};

    give(&poses[0], first, 0);
    give(&poses[1], second, 1);
    rig.cams_from_rig = cams;
    rig.n_cameras = 2;
    rig.rig_from_placements = places;
    rig.n_placements = 1;
    rig.group = group;
    rig.n_views = 2;
    rig.view_poses = poses;
    rig.work = work;
    rig.work_capacity = sizeof work / sizeof work[0];
    return rigcal_rig_join(&rig, &at_fault);
}

static void test_two_equal_poses_join(void)
{
    const double pairs[][2] = {{TOL(1e-100, 1e-12), TOL(1e-100, 1e-12)},
                               {TOL(1e30, 1e9), TOL(1e30, 1e9)},
                               {TOL(1e20, 1e5), TOL(1e30, 1e9)},
                               {TOL(1e30, 1e9), TOL(1e20, 1e5)}};

    for (size_t k = 0; k < sizeof pairs / sizeof pairs[0]; k++) {
        rigcal_transform cams[2];

        ASSERT_STATUS(RIGCAL_OK, join(cams, pairs[k][0], pairs[k][1]));
        for (int i = 0; i < 9; i++) {
            ASSERT_NEAR(i % 4 == 0, cams[1].R[i], TOL(1e-14, 1e-6));
        }
    }
}

static void test_information_too_far_apart_gives_no_other_pose(void)
{
    for (int k = 0; k < 2; k++) {
        const double little = TOL(1e-300, 1e-20), much = TOL(1e30, 1e9);
        rigcal_transform cams[2];
        const rigcal_status status = join(cams, k ? little : much, k ? much : little);

        TEST_ASSERT_TRUE(status == RIGCAL_OK || status == RIGCAL_ERR_DEGENERATE);
        for (int i = 0; i < 9; i++) {
            ASSERT_NEAR(i % 4 == 0, cams[1].R[i], TOL(1e-14, 1e-6));
        }
    }
}

TEST_MAIN()
{
    RUN_TEST(test_two_equal_poses_join);
    RUN_TEST(test_information_too_far_apart_gives_no_other_pose);
}
