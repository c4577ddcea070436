/* watch: the end of a frame, the alarm and its answers. The truth: simulated rigs in which
 * a camera is turned. */
#include <math.h>
#include <string.h>

#include "test_watched.h"

static const double DEGREE = TEST_PI / 180;
static const watched_matches CLEAN = {20, 0.3, 0, 1}, SOME_WRONG = {20, 0.3, 0.1, 1};

static test_watched w;

#define WANTS_RIG() TEST_WANTS_RAM(sizeof w + 6000)

static void options_of(rigcal_monitor_options *o, double arl0)
{
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_defaults(o));
    o->arl0_frames = (rigcal_real)arl0;
}

static void frame(rigcal_monitor_report *report, test_rng *rng, const watched_matches *like)
{
    test_watched_match(&w, rng, like);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(report, w.monitor, RC(1.0 / 30)));
}

/* Turns a camera by this many degrees about a random axis. */
static void turn(int camera, double degrees, test_rng *rng)
{
    double d[6] = {test_normal(rng), test_normal(rng), test_normal(rng), 0, 0, 0};
    const double scale = degrees * DEGREE / test_norm(d);

    for (int k = 0; k < 3; k++) {
        d[k] *= scale;
    }
    test_watched_bump(&w, camera, d);
}

/* ---- poses and their covariance ----------------------------------------------------- */

static void test_the_ellipsoid_of_all_cameras_holds_the_truth(void)
{
    const int rigs = TEST_TRIALS(60);
    int inside = 0, tried = 0;
    double mean = 0;

    TEST_ON_HOST_ONLY("a rate");
    for (int r = 0; r < rigs; r++) {
        test_rng rng = test_seed(100 + (uint64_t)r);
        const int n_cameras = 2 + r % 3;
        rigcal_monitor_options o;
        double e[WATCHED_FREE_MAX];

        options_of(&o, 1e9);
        o.walk_rad = RC(0.005 * DEGREE);
        o.walk_t = RC(5e-5);
        test_watched_make(&w, &rng, n_cameras, r % 3 == 0, 0.05 * DEGREE, 2e-3);
        test_watched_begin(&w, 0, &o);
        for (int f = 0; f < 30; f++) {
            test_watched_walk(&w, &rng, 0.005 * DEGREE / sqrt(30), 5e-5 / sqrt(30));
            frame(NULL, &rng, &SOME_WRONG);
            if (f % 10 == 9) {
                const double x = test_watched_nees(&w, e);
                inside += x < test_chi2_95(6 * (n_cameras - 1));
                mean += x / (6 * (n_cameras - 1));
                tried++;
            }
        }
    }
    ASSERT_NEAR(0.95, (double)inside / tried, 0.05);
    ASSERT_NEAR(1, mean / tried, 0.12);
}

static double variance_of(int camera, int unknown)
{
    rigcal_mounted_camera m;

    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&m, w.monitor, (size_t)camera));
    return D(m.Sigma[7 * unknown]);
}

static void test_time_adds_the_walk_of_both_cameras_and_nothing_without_one(void)
{
    test_rng rng = test_seed(2);
    rigcal_monitor_options o;

    WANTS_RIG();
    for (int has_walk = 0; has_walk < 3; has_walk++) { /* 2: a walk of places alone */
        options_of(&o, 1e9);
        o.walk_rad = has_walk == 1 ? RC(1e-4) : 0;
        o.walk_t = has_walk == 2 ? RC(1e-3) : 0;
        test_watched_make(&w, &rng, 2, 1, 1e-3, 2e-3);
        test_watched_begin(&w, 0, &o);
        for (int f = 0; f < 10; f++) {
            ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, RC(0.5)));
        }
        ASSERT_NEAR(1e-6 + (has_walk == 1) * 2 * 1e-8 * 5, variance_of(1, 0),
                    TOL(1e-15, 1e-11));
        if (has_walk != 1) { /* a turn of camera 0 moves camera 1 too */
            ASSERT_NEAR(4e-6 + (has_walk == 2) * 2 * 1e-6 * 5, variance_of(1, 3),
                        TOL(1e-15, 1e-10));
        }
    }
}

/* ---- an alarm ----------------------------------------------------------------------- */

/* Runs frames until the alarm, at most 300. */
static int wait_for_alarm(rigcal_monitor_report *report, test_rng *rng,
                          const watched_matches *like)
{
    for (int f = 1; f <= 300; f++) {
        frame(report, rng, like);
        if (report->alarm) {
            return f;
        }
    }
    return 300;
}

static void test_a_camera_that_was_turned_is_noticed_named_and_mended(void)
{
    const int trials = TEST_TRIALS(24);
    int right = 0, inside = 0;

    TEST_WANTS_RAM(sizeof w + 30000);
    for (int r = 0; r < trials; r++) {
        test_rng rng = test_seed(300 + (uint64_t)r);
        rigcal_monitor_options o;
        rigcal_monitor_report report;
        double e[WATCHED_FREE_MAX];
        const int n_cameras = 3 + r % 2, camera = r % n_cameras;

        options_of(&o, 1e4);
        test_watched_make(&w, &rng, n_cameras, 0, 0.05 * DEGREE, 2e-3);
        test_watched_begin(&w, 0, &o);
        for (int f = 0; f < 60; f++) {
            frame(&report, &rng, &SOME_WRONG);
            TEST_ASSERT_EQUAL_INT32(0, report.alarm);
        }
        turn(camera, r % 3 == 0 ? 2 : 0.3, &rng);
        TEST_ASSERT_TRUE(wait_for_alarm(&report, &rng, &SOME_WRONG) < 40);
        TEST_ASSERT_TRUE(report.evidence >= 0 && report.frames_since == 1);
        for (int f = 0; f < 15; f++) {
            frame(&report, &rng, &SOME_WRONG);
        }
        TEST_ASSERT_EQUAL_INT32(1, report.alarm);
        TEST_ASSERT_TRUE(report.frames_since == 16);
        right += report.body == camera && report.confidence > RC(0.9);
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_moved(w.monitor, (size_t)camera));
        for (int f = 0; f < 20; f++) {
            frame(&report, &rng, &SOME_WRONG);
        }
        TEST_ASSERT_EQUAL_INT32(0, report.alarm);
        inside += test_watched_nees(&w, e) < 1.5 * test_chi2_95(6 * (n_cameras - 1));
    }
    TEST_ASSERT_TRUE(right >= trials - 1);
    TEST_ASSERT_TRUE(inside >= trials - trials / 8);
}

static void test_of_two_cameras_with_matches_alone_either_may_have_moved(void)
{
    WANTS_RIG();
    for (int camera = 0; camera < 2; camera++) {
        test_rng rng = test_seed(400);
        rigcal_monitor_options o;
        rigcal_monitor_report report;
        rigcal_body_report bodies[2];

        options_of(&o, 1e4);
        test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
        test_watched_begin(&w, 0, &o);
        for (int f = 0; f < 30; f++) {
            frame(&report, &rng, &CLEAN);
        }
        turn(camera, 0.5, &rng);
        TEST_ASSERT_TRUE(wait_for_alarm(&report, &rng, &CLEAN) < 40);
        for (int f = 0; f < 15; f++) {
            frame(&report, &rng, &CLEAN);
        }
        for (size_t b = 0; b < 2; b++) {
            ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_body(&bodies[b], w.monitor, b));
            ASSERT_NEAR(0.5, bodies[b].blame, 0.1);
        }
        ASSERT_NEAR(1, D(bodies[0].blame) + D(bodies[1].blame), 1e-5);
        /* either answer corrects what can be seen: the relative pose of the two */
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_moved(w.monitor, (size_t)(1 - camera)));
        double e[WATCHED_FREE_MAX];
        for (int f = 0; f < 20; f++) {
            frame(&report, &rng, &CLEAN);
        }
        TEST_ASSERT_TRUE(test_watched_nees(&w, e) < 2 * test_chi2_95(6));
    }
}

/* Between an alarm and its answer no pose changes. */
static void test_poses_rest_until_an_alarm_is_answered(void)
{
    test_rng rng = test_seed(500);
    rigcal_monitor_options o;
    rigcal_monitor_report report;
    rigcal_mounted_camera before, after;

    WANTS_RIG();
    options_of(&o, 1e4);
    test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
    test_watched_begin(&w, 0, &o);
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_monitor_dismiss(w.monitor));
    for (int f = 0; f < 30; f++) {
        frame(&report, &rng, &CLEAN);
    }
    turn(1, 1, &rng);
    (void)wait_for_alarm(&report, &rng, &CLEAN);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&before, w.monitor, 1));
    for (int f = 0; f < 5; f++) {
        frame(&report, &rng, &CLEAN);
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&after, w.monitor, 1));
    ASSERT_TRANSFORM(&before.cam_from_rig, &after.cam_from_rig, TOL(1e-13, 3e-7),
                     TOL(1e-13, 3e-7));
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_dismiss(w.monitor));
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_ask(&report, w.monitor));
    TEST_ASSERT_EQUAL_INT32(0, report.alarm);
}

/* ---- a body that is opened without an alarm
 * ---------------------------------------------- */

static void test_a_camera_that_is_opened_is_solved_anew_by_the_next_rows(void)
{
    const int trials = TEST_TRIALS(40);
    int inside = 0;

    WANTS_RIG();
    for (int r = 0; r < trials; r++) {
        test_rng rng = test_seed(600 + (uint64_t)r);
        rigcal_monitor_options o;
        rigcal_monitor_report report;
        double e[WATCHED_FREE_MAX], d[6];
        const int n_cameras = r % 2 && WATCHED_CAMERAS_MAX > 2 ? 3 : 2,
                  camera = r / 2 % n_cameras;

        options_of(&o, 1e9);
        o.move_t = RC(5e-3);
        test_watched_make(&w, &rng, n_cameras, 0, 0.05 * DEGREE, 2e-3);
        test_watched_begin(&w, 0, &o);
        for (int f = 0; f < 20; f++) {
            frame(&report, &rng, &CLEAN);
        }
        for (int k = 0; k < 6; k++) {
            d[k] = (k < 3 ? 1.5 * DEGREE : 5e-3) * test_normal(&rng);
        }
        test_watched_bump(&w, camera, d);
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_moved(w.monitor, (size_t)camera));
        for (int f = 0; f < 3; f++) {
            frame(&report, &rng, &CLEAN);
        }
        inside += test_watched_nees(&w, e) < test_chi2_95(6 * (n_cameras - 1));
    }
    if (TEST_ONE_IN == 1) {
        TEST_ASSERT_TRUE(inside >= 35); /* 38 +- 1.4 */
    }
}

/* In the ten frames after it was opened, a camera's pose follows each row. After these
 * frames the pose rests until the end of the frame, like the others. */
static void test_an_opened_camera_follows_its_rows_for_ten_frames(void)
{
    test_rng rng = test_seed(700);
    rigcal_monitor_options o;

    WANTS_RIG();
    options_of(&o, 1e9);
    test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
    test_watched_begin(&w, 0, &o);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_moved(w.monitor, 1));
    for (int f = 0; f < 12; f++) {
        rigcal_mounted_camera before, after;

        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&before, w.monitor, 1));
        test_watched_match(&w, &rng, &CLEAN);
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&after, w.monitor, 1));
        TEST_ASSERT_EQUAL_INT(f < 10, memcmp(before.cam_from_rig.t, after.cam_from_rig.t,
                                             sizeof after.cam_from_rig.t) != 0);
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, RC(1.0 / 30)));
    }
}

static void test_an_empty_scene_is_blind_not_well(void)
{
    test_rng rng = test_seed(700);
    rigcal_monitor_report report;

    WANTS_RIG();
    test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
    test_watched_begin(&w, 0, NULL);
    for (int f = 0; f < 20; f++) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(&report, w.monitor, RC(0.03)));
    }
    TEST_ASSERT_EQUAL_INT32(2, report.n_blind);
    ASSERT_NEAR(0, report.smallest_rad, 0);
    ASSERT_NEAR(0, report.noise, 0);
    for (int f = 0; f < 300; f++) {
        frame(&report, &rng, &CLEAN);
    }
    TEST_ASSERT_EQUAL_INT32(0, report.n_blind);
    TEST_ASSERT_TRUE(report.smallest_rad > RC(1e-5) && report.smallest_rad < RC(1e-2));
    ASSERT_NEAR(1, report.noise, 0.05);
    TEST_ASSERT_TRUE(report.frames == 320 && report.rows == 6000);
}

static void test_frames_that_cannot_be_are_refused(void)
{
    test_rng rng = test_seed(800);

    WANTS_RIG();
    test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
    test_watched_begin(&w, 0, NULL);
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_frame(NULL, w.monitor, RC(-0.1)));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_frame(NULL, w.monitor, RC(1.1e6)));
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rigcal_monitor_frame(NULL, w.monitor, TEST_NAN));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_moved(w.monitor, 2));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_frame(NULL, NULL, 0));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_ask(NULL, w.monitor));
}

TEST_MAIN()
{
    RUN_TEST(test_the_ellipsoid_of_all_cameras_holds_the_truth);
    RUN_TEST(test_time_adds_the_walk_of_both_cameras_and_nothing_without_one);
    RUN_TEST(test_a_camera_that_was_turned_is_noticed_named_and_mended);
    RUN_TEST(test_of_two_cameras_with_matches_alone_either_may_have_moved);
    RUN_TEST(test_poses_rest_until_an_alarm_is_answered);
    RUN_TEST(test_a_camera_that_is_opened_is_solved_anew_by_the_next_rows);
    RUN_TEST(test_an_opened_camera_follows_its_rows_for_ten_frames);
    RUN_TEST(test_an_empty_scene_is_blind_not_well);
    RUN_TEST(test_frames_that_cannot_be_are_refused);
}
