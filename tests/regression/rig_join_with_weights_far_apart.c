/* Two weights in their range, 1e-300 and 1e30, made ERR_ROTATION of two equal poses. */
#include <math.h>
#include <string.h>

#include "test_support.h"

static void test_two_equal_poses_join(void)
{
    static const rigcal_transform SAME = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    const rigcal_real little = RC(TOL(1e-300, 1e-37)), much = RC(TOL(1e30, 1e9));

    for (int k = 0; k < 2; k++) {
        rigcal_view_pose views[2] = {{SAME, k ? little : much, 0, 0},
                                     {SAME, k ? much : little, 1, 0}};
        rigcal_transform cams[2], work[2];
        rigcal_real weight[2];
        int32_t group[2];
        rigcal_rig rig = {cams, group, 2, views, 2, work, weight};

        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_join(&rig));
        for (int i = 0; i < 9; i++) {
            ASSERT_NEAR(i % 4 == 0, cams[1].R[i], TOL(1e-14, 1e-6));
        }
    }
}

TEST_MAIN()
{
    RUN_TEST(test_two_equal_poses_join);
}
