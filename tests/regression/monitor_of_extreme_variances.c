/* Variances at the ends of the range. A variance below the smallest normal number has no
 * finite inverse: a monitor began with covariances of NaN. After an answer to an alarm, a
 * body's share of the evidence was above 1. For two centres so close that the square of
 * their distance is 0, the baseline of the aligned pair was 0. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "test_watched.h"

static test_watched w;

static void test_variances_that_are_denormal(void)
{
    test_rng rng = test_seed(22);
    rigcal_mounted_camera camera;

    test_watched_make(&w, &rng, 2, 1, 1e-4, 1e-4);
    for (int i = 0; i < 6; i++) {
        w.Sigma[i * (i + 1) / 2 + i] = RC(TOL(DBL_MIN, (double)FLT_MIN) / 8);
    }
    test_watched_begin(&w, 0, NULL);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&camera, w.monitor, 1));
    for (int i = 0; i < 36; i++) {
        TEST_ASSERT_TRUE(fabs(D(camera.Sigma[i])) <= 1e-30);
    }
}

static void test_shares_after_an_answer(void)
{
    const watched_matches like = {20, 0.3, 0, 0};
    const double bump[6] = {0.02, 0.02, 0, 0, 0, 0};
    test_rng rng = test_seed(24);
    rigcal_monitor_report report = {0};
    rigcal_body_report body;

    test_watched_make(&w, &rng, 2, 1, 1e-4, 1e-4);
    test_watched_begin(&w, 0, NULL);
    for (int frame = 0; frame < 60 && !report.alarm; frame++) {
        if (frame == 30) {
            test_watched_bump(&w, 1, bump);
        }
        test_watched_match(&w, &rng, &like);
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(&report, w.monitor, RC(0.1)));
    }
    TEST_ASSERT_EQUAL(1, report.alarm);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_moved(w.monitor, 1));
    double sum = 0;
    for (size_t b = 0; b < 2; b++) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_body(&body, w.monitor, b));
        TEST_ASSERT_TRUE(body.share >= 0 && body.share <= 1);
        sum += D(body.share);
    }
    ASSERT_NEAR(1, sum, TOL(1e-9, 1e-5));
}

static void test_centres_that_nearly_coincide(void)
{
    const rigcal_camera camera = test_pinhole();
    rigcal_transform b_from_a = {{1, 0, 0, 0, 1, 0, 0, 0, 1},
                                 {RC(TOL(1e-200, 1e-30)), 0, 0}};
    rigcal_rectified rectified;

    ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, rectified,
                   rigcal_rectify(&rectified, &camera, &camera, &b_from_a));
    b_from_a.t[0] = RC(-0.1);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rectify(&rectified, &camera, &camera, &b_from_a));
}

/* A match whose variance overflows was refused, but had already changed the sealed memory,
 * so that each later call was refused too. Here the centres come closer and closer, so that
 * a pixel is a larger and larger part of their distance. */
static void test_variances_that_overflow(void)
{
    static rigcal_real kept[RIGCAL_MONITOR_SIZE(2, 0)];
    const rigcal_real ray_a[3] = {RC(0.1), RC(0.2), 1}, ray_b[3] = {RC(-0.1), RC(0.1), 1};
    test_rng rng = test_seed(25);
    rigcal_monitor_report report;
    int refused = 0;

    TEST_WANTS_RAM(sizeof w + sizeof kept + 6000);
    test_watched_make(&w, &rng, 2, 1, 1e-4, 1e-4);
    test_watched_begin(&w, 0, NULL);
    for (int halvings = 0; halvings < TOL(1000, 100); halvings++) {
        for (int k = 0; k < 3; k++) {
            w.cameras[1].cam_from_rig.t[k] /= 2;
            w.Sigma[(3 + k) * (4 + k) / 2 + 3 + k] = RC(TOL(1e30, 1e9));
        }
        if (rigcal_monitor_begin(w.monitor, w.size, &w.rig, 0, NULL) != RIGCAL_OK) {
            break; /* one centre */
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(&report, w.monitor, RC(0.1)));
        memcpy(kept, w.monitor, sizeof kept);
        if (rigcal_monitor_match_rays(w.monitor, 0, ray_a, 1, ray_b, RC(1e-5)) < 0) {
            TEST_ASSERT_EQUAL_MEMORY(kept, w.monitor, sizeof kept);
            ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(&report, w.monitor, RC(0.1)));
            refused++;
        }
    }
    TEST_ASSERT_TRUE(refused > 0);
}

TEST_MAIN()
{
    RUN_TEST(test_variances_that_are_denormal);
    RUN_TEST(test_variances_that_overflow);
    RUN_TEST(test_shares_after_an_answer);
    RUN_TEST(test_centres_that_nearly_coincide);
}
