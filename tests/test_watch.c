/* watch: the end of a frame, the alarm and its answers. The truth: simulated rigs in which
 * a camera is turned. */
#include <math.h>
#include <string.h>

#include "rc_monitor.h"
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
    const int rigs = 60;
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

/* A turn of one camera looks like a turn and a shift of the other. If the shift is within
 * what is expected, here 0.2 of 0.6 mm, neither is ruled out. */
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
        turn(camera, 0.1, &rng);
        TEST_ASSERT_TRUE(wait_for_alarm(&report, &rng, &CLEAN) < 40);
        for (int f = 0; f < 15; f++) {
            frame(&report, &rng, &CLEAN);
        }
        for (size_t b = 0; b < 2; b++) {
            ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_body(&bodies[b], w.monitor, b));
            TEST_ASSERT_TRUE(bodies[b].blame > RC(0.1));
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
/* A large turn of one camera looks like a turn and a shift of the other by up to 6 mm, ten
 * times what is expected. */
static void test_of_two_cameras_the_one_that_turned_far_is_named(void)
{
    const int trials = TEST_TRIALS(20);
    int right = 0, sure = 0;

    WANTS_RIG();
    for (int r = 0; r < trials; r++) {
        test_rng rng = test_seed(450 + (uint64_t)r);
        rigcal_monitor_options o;
        rigcal_monitor_report report;

        options_of(&o, 1e4);
        test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
        test_watched_begin(&w, 0, &o);
        for (int f = 0; f < 30; f++) {
            frame(&report, &rng, &CLEAN);
        }
        turn(r % 2, 3, &rng);
        TEST_ASSERT_TRUE(wait_for_alarm(&report, &rng, &CLEAN) < 40);
        for (int f = 0; f < 15; f++) {
            frame(&report, &rng, &CLEAN);
        }
        right += report.body == r % 2;
        sure += report.confidence > RC(0.9);
    }
    TEST_ASSERT_TRUE(right >= trials - trials / 5);
    TEST_ASSERT_TRUE(sure >= trials - trials / 3);
}

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

/* ---- the limit of the evidence ------------------------------------------------ */

/* Sets the limit of the evidence, between frames. */
static void set_limit(rigcal_real log_limit)
{
    rc_monitor open;

    ASSERT_STATUS(RIGCAL_OK, rc_monitor_open(&open, w.monitor));
    open.top.head.alarm.log_limit = log_limit;
    rc_monitor_close(&open, 1);
}

static void begin_pair(uint64_t seed, int n_targets)
{
    test_rng rng = test_seed(seed);

    test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
    test_watched_begin(&w, n_targets, NULL);
}

static void end_frame(rigcal_monitor_report *report)
{
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(report, w.monitor, 0));
}

/* Evidence of 0 raises it. */
static void test_evidence_at_its_limit_raises_the_alarm(void)
{
    const watched_matches one = {1, 0.3, 0, 1};
    rigcal_monitor_report report;
    rigcal_real sum = 0;

    WANTS_RIG();
    for (int k = 0; k < 3; k++) {
        test_rng rng = test_seed(901);

        begin_pair(900, 0);
        test_watched_match(&w, &rng, &one);
        set_limit(k == 0 ? RC(0) : k == 1 ? sum : sum + RC(0.25));
        end_frame(&report);
        sum = k == 0 ? report.evidence : sum; /* less a limit of 0 */
        TEST_ASSERT_TRUE(k == 0 || report.alarm == (k == 1));
        ASSERT_NEAR(k == 1   ? 0
                    : k == 2 ? -0.25
                             : D(sum),
                    report.evidence, k == 2 ? 1e-6 : 0);
    }
}

/* The report before an alarm, with it and after the answer. */
static void test_an_answer_ends_all_of_an_alarm(void)
{
    rigcal_monitor_report report;

    WANTS_RIG();
    for (int has_moved = 0; has_moved < 2; has_moved++) {
        begin_pair(902, 0);
        end_frame(&report);
        TEST_ASSERT_TRUE(report.alarm == 0 && report.frames_since == 0);
        ASSERT_NEAR(0, report.confidence, 0);
        TEST_ASSERT_EQUAL_INT32(0, report.body);
        set_limit(-1000);
        for (uint32_t f = 1; f < 4; f++) {
            end_frame(&report);
            TEST_ASSERT_EQUAL_INT32(1, report.alarm);
            TEST_ASSERT_EQUAL_UINT32(f, report.frames_since);
            TEST_ASSERT_TRUE(report.confidence > 0 && report.evidence > 900);
        }
        ASSERT_STATUS(RIGCAL_OK, has_moved ? rigcal_monitor_moved(w.monitor, 1)
                                           : rigcal_monitor_dismiss(w.monitor));
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_ask(&report, w.monitor));
        TEST_ASSERT_TRUE(report.alarm == 0 && report.frames_since == 0);
        TEST_ASSERT_EQUAL_UINT32(4, report.frames);
        ASSERT_NEAR(0, report.evidence, 0);
        ASSERT_NEAR(0, report.confidence, 0);
        ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_monitor_dismiss(w.monitor));
    }
}

/* Whether the pose of a camera moves at a match, before the frame ends. */
static int moves_at_once(size_t camera, test_rng *rng)
{
    const watched_matches some = {6, 0.3, 0, 1};
    rigcal_mounted_camera before, after;

    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&before, w.monitor, camera));
    test_watched_match(&w, rng, &some);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&after, w.monitor, camera));
    return memcmp(&before.cam_from_rig, &after.cam_from_rig, sizeof before.cam_from_rig) !=
           0;
}

/* Of three cameras, the opened one alone follows its rows. An alarm ends that. */
static void test_a_camera_settles_by_itself_until_an_alarm(void)
{
    test_rng rng = test_seed(903);

    if (WATCHED_CAMERAS_MAX < 3) {
        TEST_IGNORE_MESSAGE("wants three cameras");
    }
    for (size_t opened = 1; opened < 3; opened++) {
        test_watched_make(&w, &rng, 3, 0, 0.05 * DEGREE, 2e-3);
        test_watched_begin(&w, 0, NULL);
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_moved(w.monitor, opened));
        TEST_ASSERT_TRUE(moves_at_once(opened, &rng));
        TEST_ASSERT_FALSE(moves_at_once(3 - opened, &rng));
        end_frame(NULL);
        set_limit(-1000);
        end_frame(NULL);
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_dismiss(w.monitor));
        TEST_ASSERT_FALSE(moves_at_once(opened, &rng));
    }
}

/* After each frame of an alarm the trial that explains most has a sum of 0. */
static void test_sums_of_trials_do_not_grow(void)
{
    const watched_matches some = {10, 3, 0, 1};
    test_rng rng = test_seed(904);

    WANTS_RIG();
    begin_pair(905, 0);
    set_limit(-1000);
    end_frame(NULL);
    for (int f = 0; f < 3; f++) {
        rc_monitor open;

        test_watched_match(&w, &rng, &some);
        end_frame(NULL);
        ASSERT_STATUS(RIGCAL_OK, rc_monitor_open(&open, w.monitor));
        const double a = D(open.bodies[RC_TRIAL_LOG]);
        const double b = D(open.bodies[RC_ALARM_BODY + RC_TRIAL_LOG]);
        ASSERT_NEAR(0, fmax(a, b), 0);
    }
}

/* ---- who is blind ---------------------------------------------------------------- */

/* Of three cameras two see each other. One that is blind hides what would be noticed. */
static void test_one_camera_that_is_blind_is_counted(void)
{
    const rigcal_real ray[3] = {0, 0, 1};
    test_rng rng = test_seed(906);
    rigcal_monitor_report report = {0};
    rigcal_body_report body[3];

    if (WATCHED_CAMERAS_MAX < 3) {
        TEST_IGNORE_MESSAGE("wants three cameras");
    }
    test_watched_make(&w, &rng, 3, 0, 0.05 * DEGREE, 2e-3);
    test_watched_begin(&w, 0, NULL);
    for (int f = 0; f < 40; f++) {
        for (int i = 0; i < 8; i++) {
            rigcal_real rays[2][3] = {{0, 0, 1}, {0, 0, 1}};
            double X[3], uv[2];

            test_watched_point(X, &w, &rng);
            for (int c = 0; c < 2; c++) {
                test_watched_pixel(uv, &w, c, X);
                rays[c][0] = RC((uv[0] - 640 + 0.3 * test_normal(&rng)) / 800);
                rays[c][1] = RC((uv[1] - 480 + 0.3 * test_normal(&rng)) / 800);
            }
            ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_match_rays(w.monitor, 0, rays[0], 1,
                                                               rays[1], RC(0.3)));
        }
        end_frame(&report);
    }
    TEST_ASSERT_EQUAL_INT32(1, report.n_blind);
    ASSERT_NEAR(0, report.smallest_rad, 0);
    for (size_t b = 0; b < 3; b++) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_body(&body[b], w.monitor, b));
        TEST_ASSERT_EQUAL_INT32(b == 2, body[b].is_blind);
        TEST_ASSERT_EQUAL_INT(b<2, body[b].smallest_rad> 0);
    }
    for (int i = 0; i < 6; i++) { /* six rows are enough */
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_monitor_match_rays(w.monitor, 2, ray, 1, ray, RC(0.3)));
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_ask(&report, w.monitor));
        TEST_ASSERT_EQUAL_INT32(i < 5, report.n_blind);
    }
    const double worst = fmax(D(body[0].smallest_rad), D(body[1].smallest_rad));
    TEST_ASSERT_TRUE(report.smallest_rad == 0 || D(report.smallest_rad) >= worst);
}

/* ---- where the frame is ------------------------------------------------------------ */

/* Camera 1 is the frame, so camera 0 is followed. */
static void test_each_camera_but_the_frame_is_followed(void)
{
    const watched_matches some = {20, 0.3, 0, 1};
    test_rng rng = test_seed(907);
    rigcal_mounted_camera before[2], after[2];

    WANTS_RIG();
    test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
    w.held[0] = 0;
    w.held[1] = 1;
    test_watched_begin(&w, 0, NULL);
    for (size_t c = 0; c < 2; c++) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&before[c], w.monitor, c));
    }
    test_watched_match(&w, &rng, &some);
    end_frame(NULL);
    for (size_t c = 0; c < 2; c++) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&after[c], w.monitor, c));
        TEST_ASSERT_EQUAL_INT(c == 0,
                              memcmp(&before[c].cam_from_rig, &after[c].cam_from_rig,
                                     sizeof before[c].cam_from_rig) != 0);
    }
}

/* ---- what becomes uncertain ------------------------------------------------------ */

/* All elements of a body's covariance, as standard deviations and correlations. */
static void covariance_of(rigcal_real Sigma[36], size_t body)
{
    rigcal_transform b_from_a;

    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_pair(&b_from_a, Sigma, w.monitor, 0, body));
}

/* What a walk adds to the covariance of a body (w, ds). A turn of the frame by e moves the
 * body with pose (R, t) by (R e, t x R e), a shift of the frame by (0, R e). The variances
 * are the same for all e of length 1, so the axes of the body may be taken for R e. */
static double walked(int element, size_t body, const double t[3], double q_rad, double q_t)
{
    const int i = element / 6, j = element % 6;
    double sum = body == 1 && i == j ? (i < 3 ? q_rad : q_t) : 0; /* a camera's own walk */

    for (int k = 0; k < 3; k++) {
        double turned[6] = {k == 0, k == 1, k == 2, 0, 0, 0};

        test_cross(&turned[3], t, turned);
        sum += q_rad * turned[i] * turned[j] + (i == 3 + k && j == 3 + k ? q_t : 0);
    }
    return sum;
}

/* Time moves cameras, not targets. The frame's walk moves all others. With no walk not one
 * bit of the covariance changes. */
static void test_time_moves_cameras_and_not_targets(void)
{
    static double X_w[4][3] = {{-0.3, 0.2, 0}, {0.3, 0.2, 0.1}, {0, -0.3, 0}, {0, 0, -0.2}};

    TEST_WANTS_RAM(sizeof w + 30000);
    for (int has_walk = 0; has_walk < 2; has_walk++) {
        test_rng rng = test_seed(908);
        rigcal_monitor_options o;
        rigcal_observation seen[4];
        rigcal_real before[2][36], after[36];

        options_of(&o, 1e9);
        o.walk_rad = has_walk ? RC(0.25) : 0;
        o.walk_t = has_walk ? RC(0.5) : 0;
        test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
        test_watched_begin(&w, 1, &o);
        test_watched_hang(&w, &rng, 0, 0);
        for (int c = 0; c < 2; c++) {
            test_watched_see(seen, &w, c, 0, X_w, 4, &rng, 0);
            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_monitor_view(w.monitor, NULL, (size_t)c, 0, seen, 4, 1));
        }
        rc_monitor open;
        ASSERT_STATUS(RIGCAL_OK, rc_monitor_open(&open, w.monitor));
        for (size_t b = 0; b < 2; b++) {
            rc_filter_block(before[b], &open.filter, 1 + b, 1 + b);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, RC(0.125)));
        ASSERT_STATUS(RIGCAL_OK, rc_monitor_open(&open, w.monitor));
        for (size_t b = 0; b < 2; b++) {
            rc_filter_block(after, &open.filter, 1 + b, 1 + b);
            double R[9], t[3];

            test_transform_parts(R, t, &open.filter.poses[1 + b]); /* the frame is at 0 */
            for (int k = 0; k < 36 && has_walk; k++) {
                ASSERT_NEAR(D(before[b][k]) + 0.125 * walked(k, 1 + b, t, 0.0625, 0.25),
                            after[k], TOL(1e-12, 1e-6));
            }
            if (!has_walk) {
                TEST_ASSERT_EQUAL_MEMORY(before[b], after, sizeof after);
            }
        }
    }
}

/* Without an alarm an opened camera is uncertain by the largest move, and others stay. A
 * turn by e about its own centre changes its t by e x t. */
static void test_an_opened_camera_is_uncertain_by_the_largest_move(void)
{
    const watched_matches some = {20, 0.3, 0, 1};
    test_rng rng = test_seed(909);
    rigcal_monitor_options o;
    rigcal_real before[36], after[36];

    WANTS_RIG();
    options_of(&o, 1e9);
    o.move_rad = RC(0.25);
    o.move_t = RC(0.5);
    for (size_t opened = 0; opened < 2; opened++) { /* 0: the frame, so camera 1 moves */
        test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
        test_watched_begin(&w, 0, &o);
        test_watched_match(&w, &rng, &some);
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, 0));
        covariance_of(before, 1);
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_moved(w.monitor, opened));
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_monitor_ask(&(rigcal_monitor_report){0}, w.monitor));
        covariance_of(after, 1);
        double q[36] = {0}, R[9], t[3];
        rigcal_mounted_camera camera;
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&camera, w.monitor, 1));
        test_transform_parts(R, t, &camera.cam_from_rig);
        for (int axis = 0; axis < 3; axis++) {
            double turn[6] = {axis == 0, axis == 1, axis == 2, 0, 0, 0};

            test_cross(&turn[3], turn, t);
            for (int k = 0; k < 36; k++) {
                q[k] += 0.0625 * turn[k / 6] * turn[k % 6];
            }
            q[21 + 7 * axis] += 0.25;
        }
        for (int k = 0; k < 36; k++) {
            if (opened == 1) { /* in its own axes */
                ASSERT_NEAR(D(before[k]) + q[k], after[k], TOL(1e-14, 1e-7));
            } else if (k % 7 == 0 && k < 18) { /* a turn, in any axes */
                TEST_ASSERT_TRUE(D(after[k]) > D(before[k]) + 0.06);
            }
        }
    }
}

/* Up to 1e6 seconds. */
static void test_a_frame_may_be_long(void)
{
    WANTS_RIG();
    begin_pair(910, 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, RC(1e6)));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_frame(NULL, w.monitor, RC(1000001)));
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rigcal_monitor_frame(NULL, w.monitor, TEST_INF));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_ask(NULL, NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_dismiss(NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_moved(NULL, 0));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_moved(w.monitor, SIZE_MAX));
}

TEST_MAIN()
{
    RUN_TEST(test_the_ellipsoid_of_all_cameras_holds_the_truth);
    RUN_TEST(test_time_adds_the_walk_of_both_cameras_and_nothing_without_one);
    RUN_TEST(test_a_camera_that_was_turned_is_noticed_named_and_mended);
    RUN_TEST(test_of_two_cameras_with_matches_alone_either_may_have_moved);
    RUN_TEST(test_of_two_cameras_the_one_that_turned_far_is_named);
    RUN_TEST(test_poses_rest_until_an_alarm_is_answered);
    RUN_TEST(test_a_camera_that_is_opened_is_solved_anew_by_the_next_rows);
    RUN_TEST(test_an_opened_camera_follows_its_rows_for_ten_frames);
    RUN_TEST(test_an_empty_scene_is_blind_not_well);
    RUN_TEST(test_frames_that_cannot_be_are_refused);
    RUN_TEST(test_evidence_at_its_limit_raises_the_alarm);
    RUN_TEST(test_an_answer_ends_all_of_an_alarm);
    RUN_TEST(test_a_camera_settles_by_itself_until_an_alarm);
    RUN_TEST(test_sums_of_trials_do_not_grow);
    RUN_TEST(test_one_camera_that_is_blind_is_counted);
    RUN_TEST(test_each_camera_but_the_frame_is_followed);
    RUN_TEST(test_time_moves_cameras_and_not_targets);
    RUN_TEST(test_an_opened_camera_is_uncertain_by_the_largest_move);
    RUN_TEST(test_a_frame_may_be_long);
}
