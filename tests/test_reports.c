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
    w.rig.F = RC(1.5);
    w.rig.freedom_between = 7;
    w.rig.freedom_within = 50;
    test_watched_begin(&w, 0, NULL);
    const rigcal_calibrated_rig rig = w.rig;
    rigcal_mounted_camera cameras[2];
    memcpy(cameras, w.cameras, sizeof cameras);
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
    FILL(w.cameras);
    FILL(w.group);
    FILL(w.held);
    FILL(w.Sigma);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_rig(&w.rig, w.monitor));
    TEST_ASSERT_EQUAL_MEMORY(&rig, &w.rig, sizeof rig);
    for (int c = 0; c < 2; c++) {
        TEST_ASSERT_EQUAL_MEMORY(&cameras[c].camera, &w.cameras[c].camera,
                                 sizeof cameras[c].camera);
        TEST_ASSERT_EQUAL_MEMORY(&cameras[c].cam_from_rig, &w.cameras[c].cam_from_rig,
                                 sizeof cameras[c].cam_from_rig);
        TEST_ASSERT_EQUAL_INT32(0, w.group[c]);
    }
    if (WATCHED_CAMERAS_MAX > 2) { /* what is no part of the rig stays */
        test_assert_untouched(&w.cameras[2], sizeof w.cameras[2], "cameras[2]", __LINE__);
        test_assert_untouched(&w.Sigma[21], sizeof w.Sigma[21], "Sigma[21]", __LINE__);
        test_assert_untouched(&w.held[2], sizeof w.held[2], "held[2]", __LINE__);
    }
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
        /* v . (w, ds / lever) as a product with (w, dt), where ds = dt + t x w */
        double of[6], turned[3];
        test_cross(turned, &v[3], t);
        for (int k = 0; k < 3; k++) {
            of[k] = v[k] + turned[k] / lever;
            of[3 + k] = v[3 + k] / lever;
        }
        for (int k = 0; k < 36; k++) {
            variance += of[k / 6] * of[k % 6] * D(m.Sigma[k]) / length;
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
    w.rig.capacity = 2; /* as many as there are */
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_rig(&w.rig, w.monitor));
    for (int k = 0; k < 4; k++) {
        rigcal_calibrated_rig rig = w.rig;

        rig.cameras = k == 0 ? NULL : rig.cameras;
        rig.group = k == 1 ? NULL : rig.group;
        rig.held = k == 2 ? NULL : rig.held;
        rig.Sigma = k == 3 ? NULL : rig.Sigma;
        ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_rig(&rig, w.monitor));
    }
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_rig(NULL, w.monitor));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_rig(&w.rig, NULL));
}

/* Each output by itself; bodies up to the largest number that a size_t has. */
static void test_questions_that_cannot_be_answered_are_refused(void)
{
    test_rng rng = test_seed(6);
    rigcal_mounted_camera m;
    rigcal_body_report report;
    rigcal_transform b_from_a;
    rigcal_real Sigma[36];

    WANTS_RIG();
    watch(&rng, 2, 1);
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_camera(NULL, w.monitor, 0));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_camera(&m, NULL, 0));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_pair(NULL, Sigma, w.monitor, 0, 1));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_pair(&b_from_a, NULL, w.monitor, 0, 1));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_pair(&b_from_a, Sigma, NULL, 0, 1));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_body(NULL, w.monitor, 0));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_body(&report, NULL, 0));
    for (size_t k = 0; k < 2; k++) {
        const size_t body = k == 0 ? 2 : SIZE_MAX;

        ASSERT_REFUSED(RIGCAL_ERR_RANGE, m, rigcal_monitor_camera(&m, w.monitor, body));
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, report,
                       rigcal_monitor_body(&report, w.monitor, body));
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, Sigma,
                       rigcal_monitor_pair(&b_from_a, Sigma, w.monitor, 1, body));
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, b_from_a,
                       rigcal_monitor_pair(&b_from_a, Sigma, w.monitor, body, 1));
    }
}

/* Sets the covariance of camera 1: in units of 1 rad and of `lever`, that of (w, ds) is U
 * diag U^T, with the variances `diag` along the columns of U, an orthogonal matrix. The rig
 * has that of (w, dt), dt = ds + w x t. */
static void set_axes(double U[6][6], test_rng *rng, const double diag[6], double lever)
{
    for (int k = 0; k < 6; k++) { /* Gram and Schmidt */
        for (int i = 0; i < 6; i++) {
            U[k][i] = test_normal(rng);
        }
        for (int pass = 0; pass < 2; pass++) {
            for (int before = 0; before < k; before++) {
                double along = 0;

                for (int i = 0; i < 6; i++) {
                    along += U[k][i] * U[before][i];
                }
                for (int i = 0; i < 6; i++) {
                    U[k][i] -= along * U[before][i];
                }
            }
        }
        double length = 0;
        for (int i = 0; i < 6; i++) {
            length += U[k][i] * U[k][i];
        }
        for (int i = 0; i < 6; i++) {
            U[k][i] /= sqrt(length);
        }
    }
    double columns[6][6], R[9], t[3];
    test_transform_parts(R, t, &w.cameras[1].cam_from_rig);
    for (int k = 0; k < 6; k++) {
        double turned[3];

        test_cross(turned, U[k], t);
        for (int i = 0; i < 3; i++) {
            columns[k][i] = U[k][i];
            columns[k][3 + i] = lever * U[k][3 + i] + turned[i];
        }
    }
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j <= i; j++) {
            double sum = 0;

            for (int k = 0; k < 6; k++) {
                sum += diag[k] * columns[k][i] * columns[k][j];
            }
            w.Sigma[i * (i + 1) / 2 + j] = (rigcal_real)sum;
        }
    }
}

/* Axes of any direction, and variances that may differ by only a percent. Then the power of
 * the next axis is 0.99^1024. */
static void test_the_direction_known_worst_is_that_of_a_matrix_with_known_axes(void)
{
    static const double WIDE[6] = {4e-6, 1e-6, 9e-7, 2e-7, 3e-7, 1e-8},
                        NEAR[6] = {1e-6, 9.9e-7, 9e-7, 5e-7, 1e-7, 1e-7};
    test_rng rng = test_seed(7);

    WANTS_RIG();
    for (int trial = 0; trial < TEST_TRIALS(60); trial++) {
        const double *const diag = trial % 2 ? NEAR : WIDE, lever = 0.25;
        rigcal_monitor_options o;
        rigcal_body_report report;
        double U[6][6], along = 0;

        (void)rigcal_monitor_defaults(&o);
        o.move_rad = RC(0.125);
        o.move_t = RC(0.125 * lever);
        test_watched_make(&w, &rng, 2, 0, 1e-3, 1e-3);
        set_axes(U, &rng, diag, lever);
        test_watched_begin(&w, 0, &o);
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_body(&report, w.monitor, 1));
        for (int i = 0; i < 6; i++) {
            along += U[0][i] * D(report.weakest[i]);
        }
        for (int i = 0; i < 6; i++) {
            ASSERT_NEAR(U[0][i], (along < 0 ? -1 : 1) * D(report.weakest[i]),
                        TOL(2e-4, 1e-3));
        }
        ASSERT_NEAR(sqrt(diag[0]), report.weakest_sigma, TOL(1e-7, 1e-5) * sqrt(diag[0]));
    }
}

/* Turns are known exactly, so that five of six rows have nothing of the direction. */
static void test_the_direction_known_worst_may_be_an_axis(void)
{
    test_rng rng = test_seed(9);

    WANTS_RIG();
    for (int worst = 3; worst < 6; worst++) {
        rigcal_body_report report;

        test_watched_make(&w, &rng, 2, 0, 1e-3, 1e-3);
        memset(w.Sigma, 0, sizeof w.Sigma);
        for (int k = 3; k < 6; k++) {
            w.Sigma[k * (k + 1) / 2 + k] = RC(k == worst ? 4e-6 : 1e-6);
        }
        test_watched_begin(&w, 0, NULL);
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_body(&report, w.monitor, 1));
        for (int k = 0; k < 6; k++) {
            ASSERT_NEAR(k == worst, fabs(D(report.weakest[k])), TOL(1e-9, 1e-6));
        }
    }
}

/* The frame is exact, and has no direction that is known worst. */
static void test_an_exact_body_has_no_direction_known_worst(void)
{
    test_rng rng = test_seed(8);
    rigcal_body_report report;

    WANTS_RIG();
    watch(&rng, 2, 30);
    FILL(report);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_body(&report, w.monitor, 0));
    for (int k = 0; k < 6; k++) {
        ASSERT_NEAR(0, report.weakest[k], 0);
    }
    ASSERT_NEAR(0, report.weakest_sigma, 0);
    ASSERT_NEAR(0, report.blame, 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_body(&report, w.monitor, 1));
    TEST_ASSERT_TRUE(report.share > 0 && report.share < 1 && report.is_blind == 0);
}

TEST_MAIN()
{
    RUN_TEST(test_a_monitor_gives_back_what_it_was_begun_with);
    RUN_TEST(test_a_monitor_goes_on_from_what_was_stored);
    RUN_TEST(test_a_pair_has_its_cross_terms);
    RUN_TEST(test_the_direction_known_worst_is_the_largest_axis_of_the_ellipsoid);
    RUN_TEST(test_arrays_that_are_too_small_are_not_written);
    RUN_TEST(test_questions_that_cannot_be_answered_are_refused);
    RUN_TEST(test_the_direction_known_worst_is_that_of_a_matrix_with_known_axes);
    RUN_TEST(test_the_direction_known_worst_may_be_an_axis);
    RUN_TEST(test_an_exact_body_has_no_direction_known_worst);
}
