/* reports: what a monitor returns. The truth: what it was begun with, dense matrices in
 * double, and what storage keeps of it. */
#include <math.h>
#include <string.h>

#include "test_watched.h"

static const double DEGREE = TEST_PI / 180;

static test_watched w;

#define WANTS_RIG() TEST_WANTS_RAM(sizeof w + 6000)

static void watch(test_rng *rng, int n_cameras, int frames)
{
    const watched_matches like = {20, 0.3, 0, 1};
    rigcal_monitor_options o;

    (void)rigcal_monitor_defaults(&o);
    o.arl0_frames = RC(1e9);
    o.walk_rad = RC(1e-5);
    test_watched_make(&w, rng, n_cameras, 0, 0.05 * DEGREE, 2e-3);
    test_watched_begin(&w, 0, &o);
    for (int f = 0; f < frames; f++) {
        test_watched_match(&w, rng, &like);
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, RC(0.03)));
    }
}

static void test_a_monitor_gives_back_what_it_was_begun_with(void)
{
    test_rng rng = test_seed(1);
    rigcal_mounted_camera m;

    WANTS_RIG();
    watch(&rng, 2, 0);
    const rigcal_calibrated_rig rig = w.rig;
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&m, w.monitor, 1));
    TEST_ASSERT_EQUAL_MEMORY(&w.cameras[1].camera, &m.camera, sizeof m.camera);
    TEST_ASSERT_EQUAL_MEMORY(&w.cameras[1].cam_from_rig, &m.cam_from_rig,
                             sizeof m.cam_from_rig);
    TEST_ASSERT_EQUAL_INT32(1, m.has_Sigma);
    for (int k = 0; k < 6; k++) {
        ASSERT_NEAR(1, D(m.Sigma[7 * k]) / D(w.Sigma[k * (k + 3) / 2]), TOL(1e-12, 1e-6));
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&m, w.monitor, 0));
    for (int k = 0; k < 36; k++) {
        ASSERT_NEAR(0, m.Sigma[k], 0);
    }
    w.rig.n_cameras = 0;
    w.rig.sigma_px = w.rig.F = w.rig.freedom_between = w.rig.freedom_within = -1;
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_rig(&w.rig, w.monitor));
    TEST_ASSERT_EQUAL_MEMORY(&rig, &w.rig, sizeof rig);
    TEST_ASSERT_TRUE(w.held[0] == 1 && w.held[1] == 0 && w.group[1] == 0);
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_camera(&m, w.monitor, 2));
}

/* After storing and loading, a monitor begins again where it was. */
static void test_a_monitor_goes_on_from_what_was_stored(void)
{
    static uint8_t bytes[RIGCAL_STORE_RIG_SIZE(2, 1)];
    test_rng rng = test_seed(2);
    rigcal_mounted_camera before, after;
    rigcal_saved_info info;
    size_t n_bytes;

    WANTS_RIG();
    watch(&rng, 2, 10);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&before, w.monitor, 1));
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_rig(&w.rig, w.monitor));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_store_save_rig(bytes, sizeof bytes, &n_bytes, &w.rig, 1, 7));
    memset(w.cameras, 0, sizeof w.cameras);
    memset(w.Sigma, 0, sizeof w.Sigma);
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_load_rig(&w.rig, &info, bytes, n_bytes));
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_begin(w.monitor, w.size, &w.rig, 0, NULL));
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&after, w.monitor, 1));
    TEST_ASSERT_EQUAL_MEMORY(&before.cam_from_rig, &after.cam_from_rig,
                             sizeof before.cam_from_rig);
    for (int k = 0; k < 36; k++) {
        const double scale =
            sqrt(D(before.Sigma[7 * (k / 6)]) * D(before.Sigma[7 * (k % 6)]));
        ASSERT_NEAR(D(before.Sigma[k]) / scale, D(after.Sigma[k]) / scale, TOL(1e-9, 1e-4));
    }
}

/* As for the calibrated rig with the same numbers. */
static void test_a_pair_has_its_cross_terms(void)
{
    test_rng rng = test_seed(3);
    rigcal_transform b_from_a, expected;
    rigcal_real Sigma[36], of_rig[36];

    if (WATCHED_CAMERAS_MAX < 3) {
        TEST_IGNORE_MESSAGE("wants three cameras");
    }
    watch(&rng, 3, 10);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_rig(&w.rig, w.monitor));
    for (size_t a = 0; a < 3; a++) {
        const size_t b = (a + 1) % 3;

        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_pair(&b_from_a, Sigma, w.monitor, a, b));
        ASSERT_STATUS(RIGCAL_OK, rigcal_calibrated_pair(&expected, of_rig, &w.rig, a, b));
        ASSERT_TRANSFORM(&expected, &b_from_a, 0, 0);
        for (int k = 0; k < 36; k++) {
            const double scale = sqrt(D(of_rig[7 * (k / 6)]) * D(of_rig[7 * (k % 6)]));
            ASSERT_NEAR(D(of_rig[k]) / scale, D(Sigma[k]) / scale, TOL(1e-9, 1e-3));
        }
    }
}

/* For matches this axis is the length of the base. */
static void test_the_direction_known_worst_is_the_largest_axis_of_the_ellipsoid(void)
{
    test_rng rng = test_seed(4);
    rigcal_body_report report;
    rigcal_mounted_camera m;
    double lever, best = 0, norm = 0;

    WANTS_RIG();
    watch(&rng, 2, 60);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_body(&report, w.monitor, 1));
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&m, w.monitor, 1));
    /* a tenth of the base */
    const double t[3] = {D(m.cam_from_rig.t[0]), D(m.cam_from_rig.t[1]),
                         D(m.cam_from_rig.t[2])};
    lever = 0.1 * test_norm(t);
    for (int trial = 0; trial < 3000; trial++) {
        double v[6], variance = 0, length = 0;

        for (int k = 0; k < 6; k++) {
            v[k] = test_normal(&rng);
            length += v[k] * v[k];
        }
        for (int k = 0; k < 36; k++) {
            variance += v[k / 6] * v[k % 6] * D(m.Sigma[k]) / (k / 6 < 3 ? 1 : lever) /
                        (k % 6 < 3 ? 1 : lever) / length;
        }
        best = fmax(best, sqrt(variance));
    }
    double along = 0;
    for (int k = 0; k < 6; k++) {
        norm += D(report.weakest[k]) * D(report.weakest[k]);
    }
    for (int k = 0; k < 3; k++) {
        along += D(report.weakest[3 + k]) * t[k] / test_norm(t);
    }
    ASSERT_NEAR(1, norm, 1e-4);
    TEST_ASSERT_TRUE(D(report.weakest_sigma) >= best);
    TEST_ASSERT_TRUE(D(report.weakest_sigma) < 1.5 * best);
    TEST_ASSERT_TRUE(fabs(along) > 0.98);
    ASSERT_NEAR(2e-3 / lever, report.weakest_sigma, 0.05 * 2e-3 / lever);
    TEST_ASSERT_TRUE(report.is_blind == 0 && report.smallest_rad > 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_body(&report, w.monitor, 0));
    ASSERT_NEAR(0, report.weakest_sigma, 0); /* the frame */
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_body(&report, w.monitor, 2));
}

static void test_arrays_that_are_too_small_are_not_written(void)
{
    test_rng rng = test_seed(5);

    WANTS_RIG();
    watch(&rng, 2, 1);
    w.rig.Sigma_capacity = 20;
    FILL(w.held);
    ASSERT_STATUS(RIGCAL_ERR_CAPACITY, rigcal_monitor_rig(&w.rig, w.monitor));
    ASSERT_UNTOUCHED(w.held);
    w.rig.Sigma_capacity = 21;
    w.rig.capacity = 1;
    ASSERT_STATUS(RIGCAL_ERR_CAPACITY, rigcal_monitor_rig(&w.rig, w.monitor));
    w.rig.group = NULL;
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_rig(&w.rig, w.monitor));
}

TEST_MAIN()
{
    RUN_TEST(test_a_monitor_gives_back_what_it_was_begun_with);
    RUN_TEST(test_a_monitor_goes_on_from_what_was_stored);
    RUN_TEST(test_a_pair_has_its_cross_terms);
    RUN_TEST(test_the_direction_known_worst_is_the_largest_axis_of_the_ellipsoid);
    RUN_TEST(test_arrays_that_are_too_small_are_not_written);
}
