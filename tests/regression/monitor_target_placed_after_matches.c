/* A target that got its place after the matches of a frame stood by the pose that its
 * camera had before them. At the end of the frame the camera moved by what the matches
 * said, and the target did not. The next views then contradicted this: the rig was wrong by
 * many sigma, and there were alarms without a move. */
#include <math.h>

#include "test_fit.h"
#include "test_watched.h"

enum { POINTS = 8 };

static const double DEGREE = TEST_PI / 180;

static test_watched w;

/* The pose of the target against the camera is that of the one view, without noise, which
 * placed it. What matches tell about the camera cannot change it. */
static void test_a_target_moves_with_the_camera_that_placed_it(void)
{
    const watched_matches like = {30, 0.3, 0, 0};
    double X_w[POINTS][3], R[9], t[3], R_c[9], moved[6], off[6];
    rigcal_observation o[POINTS];
    rigcal_mounted_camera before, after;
    rigcal_transform pair;
    rigcal_real Sigma[36];
    test_rng rng = test_seed(31);

    TEST_WANTS_RAM(sizeof w + 30000);
    test_watched_make(&w, &rng, 2, 0, 0.2 * DEGREE, 5e-3);
    test_watched_begin(&w, 1, NULL);
    test_watched_hang(&w, &rng, 0, 0.1);
    for (int i = 0; i < 3 * POINTS; i++) {
        X_w[i / 3][i % 3] = D((rigcal_real)test_uniform(&rng, -0.3, 0.3));
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&before, w.monitor, 1));
    test_watched_match(&w, &rng, &like);
    test_watched_see(o, &w, 1, 0, X_w, POINTS, &rng, 0);
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_monitor_view(w.monitor, NULL, 1, 0, o, POINTS, RC(0.3)));
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, 0));
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&after, w.monitor, 1));
    test_transform_parts(R, t, &before.cam_from_rig);
    test_transform_parts(R_c, moved, &after.cam_from_rig);
    test_difference(off, R, t, R_c, moved);
    TEST_ASSERT_TRUE(sqrt(off[0] * off[0] + off[1] * off[1] + off[2] * off[2]) > 1e-3);

    /* target_from_rig = target_from_camera camera_from_rig, of the truth */
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_pair(&pair, Sigma, w.monitor, 1, 2));
    double R_t[9], expected[3], seen_R[9], seen[3];
    test_transpose(R_c, w.truth[1].R);
    test_product(R_t, w.truth[2].R, R_c);
    test_apply(expected, R_t, w.truth[1].t, NULL);
    for (int i = 0; i < 3; i++) {
        expected[i] = w.truth[2].t[i] - expected[i];
    }
    test_transform_parts(seen_R, seen, &pair);
    test_difference(off, seen_R, seen, R_t, expected);
    for (int i = 0; i < 6; i++) {
        ASSERT_NEAR(0, off[i], TOL(1e-4, 2e-4));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_target_moves_with_the_camera_that_placed_it);
}
