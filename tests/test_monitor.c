/* monitor: memory, begin, matches. The truth: simulated rigs, and the same filter in
 * double. */
#include <math.h>
#include <string.h>

#include "rc_monitor.h"
#include "test_watched.h"

static const double DEGREE = TEST_PI / 180, WRONG = 0.05;

static test_watched w;
static rigcal_real copy[sizeof w.monitor / sizeof w.monitor[0]];

#define WANTS_RIG() TEST_WANTS_RAM(sizeof w + 6000)

static void quiet(rigcal_monitor_options *o)
{
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_defaults(o));
    o->arl0_frames = RC(1e9);
}

/* ---- memory ---------------------------------------------------------------------------
 * */

static void test_a_monitor_takes_what_its_macro_says_and_no_more_than_it_may(void)
{
    static const double BYTES[9] = {0, 0, 2000, 0, 4400, 0, 0, 0, 11000}; /* in float */

    for (size_t n = 2; n <= 8; n++) {
        const size_t reals = RIGCAL_MONITOR_SIZE(n, 0);

        TEST_ASSERT_TRUE(rigcal_monitor_size(n, 0) == reals);
        TEST_ASSERT_TRUE(rigcal_monitor_size(n, 2) == RIGCAL_MONITOR_SIZE(n, 2));
        if (BYTES[n] > 0) {
            TEST_ASSERT_TRUE(4.0 * (double)(reals - RIGCAL_MONITOR_LENS * n) <= BYTES[n]);
        }
    }
    TEST_ASSERT_TRUE(rigcal_monitor_size(1, 0) == 0 && rigcal_monitor_size(65, 0) == 0 &&
                     rigcal_monitor_size(2, 17) == 0);
    TEST_ASSERT_TRUE(rigcal_monitor_size(64, 16) == RIGCAL_MONITOR_SIZE(64, 16));
}

/* The FNV-1a hash of the monitor's memory. */
static uint32_t hash_of_monitor(void)
{
    const unsigned char *const bytes = (const unsigned char *)w.monitor;
    uint32_t hash = 2166136261u;

    for (size_t k = 0; k < w.size * sizeof w.monitor[0]; k++) {
        hash = (hash ^ bytes[k]) * 16777619u;
    }
    return hash;
}

static void test_a_monitor_is_the_same_in_memory_of_any_bytes(void)
{
    uint32_t hash[2];

    WANTS_RIG();
    for (int k = 0; k < 2; k++) {
        test_rng rng = test_seed(2);

        test_watched_make(&w, &rng, 2, 1, 1e-3, 2e-3);
        memset(w.monitor, k == 0 ? 0 : 0x5a, sizeof w.monitor);
        test_watched_begin(&w, 1, NULL);
        hash[k] = hash_of_monitor();
    }
    TEST_ASSERT_EQUAL_HEX32(hash[0], hash[1]);
}

static void test_memory_that_was_not_begun_is_refused(void)
{
    test_rng rng = test_seed(1);

    WANTS_RIG();
    for (int trial = 0; trial < 20; trial++) {
        unsigned char *const bytes = (unsigned char *)w.monitor;

        for (size_t k = 0; k < sizeof w.monitor; k++) {
            bytes[k] = (unsigned char)(trial == 0   ? 0
                                       : trial == 1 ? 255
                                                    : test_next(&rng) & 255);
        }
        ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_monitor_frame(NULL, w.monitor, 0));
        ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_monitor_dismiss(w.monitor));
    }
}

/* Any bit between frames; within a frame, any bit of the head. */
static void test_a_bit_that_was_changed_is_noticed(void)
{
    const watched_matches like = {20, 0.3, 0, 0};
    test_rng rng = test_seed(2);
    rigcal_monitor_options o;
    rigcal_monitor_report report;
    unsigned char *const bytes = (unsigned char *)w.monitor;

    WANTS_RIG();
    quiet(&o);
    test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
    test_watched_begin(&w, 0, &o);
    test_watched_match(&w, &rng, &like);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, 0));
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_ask(&report, w.monitor));
    for (int trial = 0; trial < TEST_TRIALS(2000); trial++) {
        const size_t at =
            (size_t)test_uniform(&rng, 0, (double)(w.size * sizeof(rigcal_real)));
        const unsigned char bit = (unsigned char)(1 << (trial % 8));

        bytes[at] ^= bit;
        ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_monitor_ask(&report, w.monitor));
        ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_monitor_frame(NULL, w.monitor, 0));
        bytes[at] ^= bit;
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_ask(&report, w.monitor));
}

/* A seal is no proof. Numbers that would point outside the memory are refused, even with a
 * right seal. */
static void test_a_head_of_wrong_numbers_is_refused_under_a_right_seal(void)
{
    test_rng rng = test_seed(8);
    rc_monitor open;

    WANTS_RIG();
    for (int k = 0; k < 5; k++) {
        rigcal_monitor_report report;

        test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
        test_watched_begin(&w, 0, NULL);
        ASSERT_STATUS(RIGCAL_OK, rc_monitor_open(&open, w.monitor));
        open.top.head.n_targets = k == 1 || k == 4 ? 17 : 0;
        open.top.head.frame = k == 2 ? 2 : 0;
        open.top.head.alarm.n_bodies += k == 3 ? 1 : k == 4 ? 17 : 0;
        rc_monitor_close(&open, 1);
        ASSERT_STATUS(k == 0 ? RIGCAL_OK : RIGCAL_ERR_STATE,
                      rigcal_monitor_ask(&report, w.monitor));
    }
}

/* Within a frame the rows change the first part only; what follows it is sealed. */
static void test_a_bit_of_the_head_is_noticed_within_a_frame(void)
{
    const watched_matches like = {3, 0.3, 0, 0};
    const size_t from = offsetof(rc_monitor_head, magic), to = sizeof(rc_monitor_head);
    test_rng rng = test_seed(9);
    unsigned char *const bytes = (unsigned char *)w.monitor;

    WANTS_RIG();
    test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
    test_watched_begin(&w, 0, NULL);
    test_watched_match(&w, &rng, &like);
    for (size_t at = from; at < to; at++) {
        rigcal_monitor_report report;
        const unsigned char bit = (unsigned char)(1 << (at % 8));

        bytes[at] ^= bit;
        ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_monitor_ask(&report, w.monitor));
        bytes[at] ^= bit;
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_ask(&report, w.monitor));
    }
}

/* Whether the monitor is sealed as a whole. */
static int is_sealed(void)
{
    rc_monitor open;

    ASSERT_STATUS(RIGCAL_OK, rc_monitor_open(&open, w.monitor));
    return (open.top.head.seal[0] | open.top.head.seal[1]) != 0;
}

/* The whole is sealed between frames. A row breaks the seal. An answer leaves it as it was,
 * and so does the lifting of a target. */
static void test_the_whole_is_sealed_from_the_end_of_a_frame_to_its_first_row(void)
{
    const watched_matches one = {1, 0.3, 0, 0};
    test_rng rng = test_seed(10);

    WANTS_RIG();
    test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
    test_watched_begin(&w, 1, NULL);
    for (int is_within = 0; is_within < 2; is_within++) {
        for (int what = 0; what < 3; what++) {
            rc_monitor open;

            if (is_within) {
                test_watched_match(&w, &rng, &one);
            }
            TEST_ASSERT_EQUAL_INT(!is_within, is_sealed());
            if (what == 0) {
                ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_moved(w.monitor, 1));
            } else if (what == 1) {
                ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_lifted(w.monitor, 0));
            } else {
                ASSERT_STATUS(RIGCAL_OK, rc_monitor_open(&open, w.monitor));
                open.top.head.is_alarm = 1;
                rc_monitor_close_again(&open);
                ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_dismiss(w.monitor));
            }
            TEST_ASSERT_EQUAL_INT(!is_within, is_sealed());
            ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, 0));
            TEST_ASSERT_TRUE(is_sealed());
        }
    }
}

/* A view breaks the seal, whether it places the target or not. */
static void test_a_view_breaks_the_seal(void)
{
    static double X_w[4][3] = {{-0.3, 0.2, 0}, {0.3, 0.2, 0.1}, {0, -0.3, 0}, {0, 0, -0.2}};
    test_rng rng = test_seed(11);
    rigcal_observation o[4];

    TEST_WANTS_RAM(sizeof w + 30000);
    test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
    test_watched_begin(&w, 1, NULL);
    test_watched_hang(&w, &rng, 0, 0);
    test_watched_see(o, &w, 0, 0, X_w, 4, &rng, 0);
    for (int pass = 0; pass < 2; pass++) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_view(w.monitor, NULL, 0, 0, o, 4, 1));
        TEST_ASSERT_FALSE(is_sealed());
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, 0));
    }
}

static void test_a_monitor_may_be_copied(void)
{
    const watched_matches like = {20, 0.3, 0.1, 0};
    test_rng rng = test_seed(3);

    TEST_WANTS_RAM(sizeof w + sizeof copy + 6000);
    test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
    test_watched_begin(&w, 0, NULL);
    test_watched_match(&w, &rng, &like);
    memcpy(copy, w.monitor, w.size * sizeof copy[0]);
    const test_rng same = rng;
    test_watched_match(&w, &rng, &like);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, 1));
    static rigcal_real first[RIGCAL_MONITOR_SIZE(2, 0)];
    memcpy(first, w.monitor, sizeof first);
    memcpy(w.monitor, copy, w.size * sizeof copy[0]);
    rng = same;
    test_watched_match(&w, &rng, &like);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, 1));
    TEST_ASSERT_EQUAL_MEMORY(first, w.monitor, sizeof first);
}

/* ---- begin -----------------------------------------------------------------------------
 * */

static void test_rigs_that_cannot_be_watched_are_refused(void)
{
    test_rng rng = test_seed(4);

    WANTS_RIG();
    test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
    const size_t size = RIGCAL_MONITOR_SIZE(2, 0);
    ASSERT_STATUS(RIGCAL_ERR_CAPACITY,
                  rigcal_monitor_begin(w.monitor, size - 1, &w.rig, 0, NULL));
    ASSERT_STATUS(RIGCAL_ERR_RANGE,
                  rigcal_monitor_begin(w.monitor, size, &w.rig, 17, NULL));
    w.group[1] = 1;
    ASSERT_STATUS(RIGCAL_DISCONNECTED,
                  rigcal_monitor_begin(w.monitor, size, &w.rig, 0, NULL));
    w.group[1] = 0;
    w.rig.n_cameras = 1;
    ASSERT_STATUS(RIGCAL_ERR_TOO_FEW,
                  rigcal_monitor_begin(w.monitor, size, &w.rig, 0, NULL));
    w.rig.n_cameras = 2;
    w.Sigma[0] = -w.Sigma[0];
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_begin(w.monitor, size, &w.rig, 0, NULL));
    w.Sigma[0] = -w.Sigma[0];
    w.Sigma[1] = 2 * w.Sigma[0];
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_begin(w.monitor, size, &w.rig, 0, NULL));
    w.Sigma[1] = 0;
    w.held[0] = 0; /* no camera is the frame */
    ASSERT_STATUS(w.rig.Sigma_capacity < RIGCAL_CALIBRATED_SIZE(2) ? RIGCAL_ERR_CAPACITY
                                                                   : RIGCAL_ERR_RANGE,
                  rigcal_monitor_begin(w.monitor, size, &w.rig, 0, NULL));
    w.held[0] = w.held[1] = 1; /* the first camera is the frame */
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_begin(w.monitor, size, &w.rig, 0, NULL));
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_rig(&w.rig, w.monitor));
    TEST_ASSERT_TRUE(w.held[0] == 1 && w.held[1] == 0);
    const rigcal_transform kept = w.cameras[1].cam_from_rig;
    w.cameras[1].cam_from_rig = w.cameras[0].cam_from_rig;
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE,
                  rigcal_monitor_begin(w.monitor, size, &w.rig, 0, NULL));
    w.cameras[1].cam_from_rig = kept;
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_begin(w.monitor, size, &w.rig, 0, NULL));
}

static void test_the_defaults_are_those_of_the_header(void)
{
    rigcal_monitor_options o;

    FILL(o);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_defaults(&o));
    ASSERT_NEAR(1e6, o.arl0_frames, 0);
    ASSERT_NEAR(0.5, o.common, 0);
    ASSERT_NEAR(D(RC(0.1)), o.wrong, 0);
    ASSERT_NEAR(0, o.walk_rad, 0);
    ASSERT_NEAR(0, o.walk_t, 0);
    ASSERT_NEAR(3 * DEGREE, o.move_rad, TOL(1e-10, 1e-8));
    ASSERT_NEAR(0, o.move_t, 0);
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_defaults(NULL));
}

/* The option of a number, in the order of the header. */
static rigcal_real *option(rigcal_monitor_options *o, int k)
{
    rigcal_real *const options[7] = {&o->arl0_frames, &o->common,   &o->wrong, &o->walk_rad,
                                     &o->walk_t,      &o->move_rad, &o->move_t};

    return options[k];
}

/* Each at its least and largest value, and just beyond. Above 0 only: move_rad. */
static void test_options_are_checked_from_both_sides(void)
{
    const rigcal_real far = RC(TOL(1e30, 1e9)), up = 1 + RC(TOL(1e-15, 2e-7));
    const rigcal_real bounds[7][2] = {{100, RC(1e9)}, {0, 1},       {0, RC(0.9)}, {0, 1},
                                      {0, far},       {0, RC(0.5)}, {0, far}};
    test_rng rng = test_seed(12);

    WANTS_RIG();
    test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
    const size_t size = RIGCAL_MONITOR_SIZE(2, 0);
    for (int k = 0; k < 7; k++) {
        const rigcal_real least = bounds[k][0], most = bounds[k][1];
        const rigcal_real below = least > 0 ? least / up : -RC(1e-20);
        const rigcal_real values[5] = {least, most, below, most * up, TEST_NAN};
        const rigcal_status expected[5] = {k == 5 ? RIGCAL_ERR_RANGE : RIGCAL_OK, RIGCAL_OK,
                                           RIGCAL_ERR_RANGE, RIGCAL_ERR_RANGE,
                                           RIGCAL_ERR_NOT_FINITE};

        for (int i = 0; i < 5; i++) {
            rigcal_monitor_options o;

            ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_defaults(&o));
            *option(&o, k) = values[i];
            ASSERT_STATUS(expected[i],
                          rigcal_monitor_begin(w.monitor, size, &w.rig, 0, &o));
        }
    }
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_begin(NULL, size, &w.rig, 0, NULL));
}

/* What is kept of the options. Shares of wrong matches below 1e-5 count as that. The
 * largest shift is a tenth of the mean distance of the cameras times the turn. */
static void test_options_are_kept(void)
{
    static const double DISTANCE[2] = {0.6, 0.8}; /* of 0 to 1 and to 2; 1 of 1 to 2 */
    const int n = WATCHED_CAMERAS_MAX > 2 ? 3 : 2;
    test_rng rng = test_seed(13);
    rigcal_monitor_options o;
    rc_monitor open;

    WANTS_RIG();
    test_watched_make(&w, &rng, n, 0, 0.05 * DEGREE, 2e-3);
    for (int c = 0; c < n; c++) {
        rigcal_real *const t = w.cameras[c].cam_from_rig.t;

        memset(&w.cameras[c].cam_from_rig, 0, sizeof w.cameras[c].cam_from_rig);
        for (int k = 0; k < 9; k += 4) {
            w.cameras[c].cam_from_rig.R[k] = 1;
        }
        if (c > 0) {
            t[c - 1] = RC(DISTANCE[c - 1]);
        }
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_defaults(&o));
    o.wrong = RC(1e-6);
    o.walk_rad = RC(0.001);
    o.walk_t = RC(0.002);
    o.move_rad = RC(0.25);
    test_watched_begin(&w, 0, &o);
    ASSERT_STATUS(RIGCAL_OK, rc_monitor_open(&open, w.monitor));
    ASSERT_NEAR(1e-5, open.top.head.wrong, TOL(1e-20, 1e-11));
    ASSERT_NEAR(0.001, open.top.head.walk_rad, 1e-9);
    ASSERT_NEAR(0.002, open.top.head.walk_t, 1e-9);
    ASSERT_NEAR(0.25, open.top.head.move_rad, 0);
    ASSERT_NEAR(0.1 * 0.25 * (n > 2 ? 0.8 : 0.6), open.top.head.move_t, TOL(1e-15, 1e-8));
    o.wrong = RC(2e-5);
    o.move_t = RC(0.125);
    test_watched_begin(&w, 0, &o);
    ASSERT_STATUS(RIGCAL_OK, rc_monitor_open(&open, w.monitor));
    ASSERT_NEAR(2e-5, open.top.head.wrong, TOL(1e-20, 1e-11));
    ASSERT_NEAR(0.125, open.top.head.move_t, 0);
}

/* Fills the covariance of n unknowns with a random one. */
static void make_dense(test_rng *rng, int n)
{
    double L[12][12];

    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            L[i][j] = test_normal(rng);
        }
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            double sum = 0;

            for (int k = 0; k < n; k++) {
                sum += 1e-3 * L[i][k] * L[j][k] * (i % 6 < 3 ? 1e-2 : 1e-1) *
                       (j % 6 < 3 ? 1e-2 : 1e-1);
            }
            w.Sigma[i * (i + 1) / 2 + j] = (rigcal_real)sum;
        }
    }
}

/* Whichever cameras are held: the first of them is the frame, and each other one has its
 * rows of the covariance. */
static void test_each_camera_gets_its_part_of_the_covariance(void)
{
    enum { N = 3 };
    test_rng rng = test_seed(14);

    if (WATCHED_CAMERAS_MAX < 3) {
        TEST_IGNORE_MESSAGE("wants three cameras");
    }
    for (int held = 1; held < 7; held++) { /* its bits */
        rigcal_real kept[78];
        int of[N], n_free = 0;

        test_watched_make(&w, &rng, N, 0, 0.05 * DEGREE, 2e-3);
        for (int c = 0; c < N; c++) {
            w.held[c] = (uint8_t)(held >> c & 1);
            of[c] = w.held[c] ? -1 : 6 * n_free;
            n_free += !w.held[c];
        }
        make_dense(&rng, 6 * n_free);
        memcpy(kept, w.Sigma, sizeof kept);
        test_watched_begin(&w, 0, NULL);
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_rig(&w.rig, w.monitor));
        const int frame = held & 1 ? 0 : held & 2 ? 1 : 2;
        for (int i = 0; i < 12; i++) {
            for (int j = 0; j <= i; j++) {
                const int a = of[i / 6 + (i / 6 >= frame)],
                          b = of[j / 6 + (j / 6 >= frame)];
                const int row = a + i % 6, column = b + j % 6;
                const double expected =
                    a < 0 || b < 0 ? 0 : D(kept[row * (row + 1) / 2 + column]);

                ASSERT_NEAR(expected, w.Sigma[i * (i + 1) / 2 + j], TOL(1e-15, 1e-9));
            }
        }
        for (int c = 0; c < N; c++) {
            TEST_ASSERT_EQUAL_INT(c == frame, w.held[c]);
        }
    }
}

/* A variance may be 0 up to the largest square of a length, and a correlation 1. */
static void test_a_covariance_is_checked_from_both_sides(void)
{
    const rigcal_real most = RC(TOL(1e30, 1e9)), up = 1 + RC(TOL(1e-8, 1e-4));
    test_rng rng = test_seed(15);
    const struct {
        rigcal_real first, across, second;
        rigcal_status status;
    } cases[] = {
        {0, 0, RC(1e-6), RIGCAL_OK},
        {0, RC(1e-9), RC(1e-6), RIGCAL_ERR_RANGE},
        {most, 0, RC(1e-6), RIGCAL_OK},
        {RC(1e-6), 0, most, RIGCAL_OK},
        {most * up, 0, RC(1e-6), RIGCAL_ERR_RANGE},
        {RC(1e-6), 0, most * up, RIGCAL_ERR_RANGE},
        {RC(4e-6), RC(-4e-6), RC(4e-6), RIGCAL_OK},
        {RC(4e-6), RC(-4e-6) * up, RC(4e-6), RIGCAL_ERR_RANGE},
        {RC(4e-6), RC(4e-6) * up, RC(4e-6), RIGCAL_ERR_RANGE},
        {TEST_NAN, 0, RC(1e-6), RIGCAL_ERR_NOT_FINITE},
        {RC(1e-6), TEST_NAN, RC(1e-6), RIGCAL_ERR_NOT_FINITE},
        {RC(1e-6), 0, TEST_INF, RIGCAL_ERR_NOT_FINITE},
        {RC(-1e-6), 0, RC(1e-6), RIGCAL_ERR_RANGE},
        {RC(1e-6), 0, RC(-1e-6), RIGCAL_ERR_RANGE},
    };

    WANTS_RIG();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        for (int at = 0; at < 5; at++) { /* two numbers that follow each other */
            test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
            w.Sigma[at * (at + 3) / 2] = cases[i].first;
            w.Sigma[(at + 1) * (at + 4) / 2 - 1] = cases[i].across;
            w.Sigma[(at + 1) * (at + 4) / 2] = cases[i].second;
            for (size_t k = 21; k < w.rig.Sigma_capacity; k++) {
                w.Sigma[k] = TEST_NAN; /* no part of it */
            }
            ASSERT_STATUS(cases[i].status,
                          rigcal_monitor_begin(w.monitor, RIGCAL_MONITOR_SIZE(2, 0), &w.rig,
                                               0, NULL));
        }
    }
}

/* ---- a still rig ------------------------------------------------------------------------
 * */

static double base_variance(void)
{
    rigcal_transform b_from_a;
    rigcal_real Sigma[36];
    double sum = 0, length;

    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_pair(&b_from_a, Sigma, w.monitor, 0, 1));
    const double t[3] = {D(b_from_a.t[0]), D(b_from_a.t[1]), D(b_from_a.t[2])};
    length = test_norm(t);
    for (int k = 0; k < 9; k++) {
        sum += t[k / 3] * t[k % 3] * D(Sigma[6 * (3 + k / 3) + 3 + k % 3]);
    }
    return sum / (length * length);
}

/* bench_monitor has a million frames; here a fifth of that. */
static void test_matches_of_a_still_pair_do_not_learn_the_length_of_its_base(void)
{
    const watched_matches like = {100, 0.3, 0, 1};

    WANTS_RIG();
    for (int is_parallel = 0; is_parallel < 2; is_parallel++) {
        test_rng rng = test_seed(5);
        rigcal_monitor_options o;

        quiet(&o);
        o.wrong = 0;
        test_watched_make(&w, &rng, 2, is_parallel, 0.05 * DEGREE, 2e-3);
        test_watched_begin(&w, 0, &o);
        for (int f = 0; f < TEST_TRIALS(1000); f++) {
            test_watched_match(&w, &rng, &like);
            ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, 0));
        }
        TEST_ASSERT_TRUE(base_variance() > 0.9 * 4e-6);
        TEST_ASSERT_TRUE(base_variance() < 1.1 * 4e-6);
    }
}

/* ---- float against double
 * ------------------------------------------------------------------ */

/* The same filter for two cameras and the matches that the monitor gets, in double: (M1) to
 * (M3), (M8) with P itself. */
typedef struct {
    double R[9], t[3], P[6][6], d[6];
} reference;

static void reference_row(double h[6], double *r, const reference *ref, const double ma[3],
                          const double mb[3], double sigma)
{
    double q[3], gb[3], na[3], Rt[9], ga[3], c[3], a[3], b[3];

    memcpy(a, ma, sizeof a);
    memcpy(b, mb, sizeof b);
    test_transpose(Rt, ref->R);
    for (int pass = 0; pass < 2; pass++) {
        test_apply(q, ref->R, a, NULL);
        test_cross(gb, ref->t, q);
        test_cross(na, b, ref->t);
        test_apply(ga, Rt, na, NULL);
        test_cross(c, q, b);
        if (pass == 0) {
            const double e = test_dot(b, gb);
            const double g2 = ga[0] * ga[0] + ga[1] * ga[1] + gb[0] * gb[0] + gb[1] * gb[1];
            *r = -e / (sigma * sqrt(g2));
            for (int k = 0; k < 2; k++) {
                a[k] -= e / g2 * ga[k];
                b[k] -= e / g2 * gb[k];
            }
            h[0] = sigma * sqrt(g2);
        }
    }
    const double s = h[0];
    double turned[3], shifted[3];
    test_cross(turned, b, gb);
    test_cross(shifted, ref->t, c);
    for (int k = 0; k < 3; k++) {
        h[k] = (-turned[k] - shifted[k]) / s;
        h[3 + k] = c[k] / s;
    }
}

static void reference_take(reference *ref, const double ma[3], const double mb[3])
{
    double h[6], r, Ph[6], S = 1, nu;

    reference_row(h, &r, ref, ma, mb, 0.3 / 800);
    nu = r;
    for (int i = 0; i < 6; i++) {
        Ph[i] = 0;
        for (int j = 0; j < 6; j++) {
            Ph[i] += ref->P[i][j] * h[j];
        }
    }
    for (int i = 0; i < 6; i++) {
        S += h[i] * Ph[i];
        nu -= h[i] * ref->d[i];
    }
    const double z2 = nu * nu / S,
                 right = (1 - WRONG) * exp(-z2 / 2) / sqrt(2 * TEST_PI * S),
                 beta = right / (right + WRONG / 100);
    for (int i = 0; i < 6; i++) {
        ref->d[i] += beta * nu * Ph[i] / S;
        for (int j = 0; j < 6; j++) {
            ref->P[i][j] -= beta * (1 - (1 - beta) * z2) * Ph[i] * Ph[j] / S;
        }
    }
}

static void reference_apply(reference *ref)
{
    double turn[9], R[9];

    if (test_norm(ref->d) > 0) {
        test_rotation_about(turn, ref->d, test_norm(ref->d));
        test_product(R, turn, ref->R);
        memcpy(ref->R, R, sizeof R);
    }
    for (int k = 0; k < 3; k++) {
        ref->t[k] += ref->d[3 + k];
    }
    memset(ref->d, 0, sizeof ref->d);
}

static void test_poses_after_many_rows_are_those_of_double_arithmetic(void)
{
    const int frames = TEST_TRIALS(1000);
    test_rng rng = test_seed(6);
    rigcal_monitor_options o;
    rigcal_mounted_camera m;
    reference ref;
    double R[9], t[3], Rt[9], turn[9];

    WANTS_RIG();
    quiet(&o);
    o.wrong = (rigcal_real)WRONG;
    test_watched_make(&w, &rng, 2, 0, 0.05 * DEGREE, 2e-3);
    test_watched_begin(&w, 0, &o);
    memset(&ref, 0, sizeof ref);
    test_transform_parts(ref.R, ref.t, &w.cameras[1].cam_from_rig);
    for (int k = 0; k < 6; k++) {
        ref.P[k][k] = D(w.Sigma[k * (k + 3) / 2]);
    }
    for (int i = 0; i < frames * 100; i++) {
        double X[3], uv[2];
        rigcal_real rays[2][3];
        double m_of[2][3];

        test_watched_point(X, &w, &rng);
        for (int c = 0; c < 2; c++) {
            test_watched_pixel(uv, &w, c, X);
            rays[c][0] = (rigcal_real)((uv[0] - 640 + 0.3 * test_normal(&rng)) / 800);
            rays[c][1] = (rigcal_real)((uv[1] - 480 + 0.3 * test_normal(&rng)) / 800);
            rays[c][2] = 1;
            test_to_double(m_of[c], rays[c], 3);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_match_rays(w.monitor, 0, rays[0], 1,
                                                           rays[1], RC(0.3)));
        reference_take(&ref, m_of[0], m_of[1]);
        if (i % 100 == 99) {
            reference_apply(&ref);
            ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, 0));
        }
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&m, w.monitor, 1));
    test_transform_parts(R, t, &m.cam_from_rig);
    test_transpose(Rt, ref.R);
    test_product(turn, R, Rt);
    const double w3[3] = {turn[7] - turn[5], turn[2] - turn[6], turn[3] - turn[1]};
    for (int k = 0; k < 3; k++) {
        const double tol = TEST_ONE_IN > 1 ? 0.05 : 0.01;
        ASSERT_NEAR(0, w3[k] / 2 / sqrt(ref.P[k][k]), tol);
        ASSERT_NEAR(0, (t[k] - ref.t[k]) / sqrt(ref.P[3 + k][3 + k]), tol);
    }
    for (int k = 0; k < 6; k++) {
        ASSERT_NEAR(1, D(m.Sigma[7 * k]) / ref.P[k][k], TOL(1e-3, 1e-3));
    }
}

/* ---- matches that are doubted ---- */

/* Of the rows of a monitor that knows its cameras, those of wrong matches are doubted. A
 * wrong one is off by up to 40 px, some by too little to be noticed. */
static void test_wrong_matches_are_counted(void)
{
    const watched_matches right = {200, 0.3, 0, 0}, wrong = {100, 0.3, 1, 0};
    rigcal_monitor_report before, after;
    rigcal_monitor_options o;
    test_rng rng = test_seed(8);

    WANTS_RIG();
    quiet(&o);
    o.wrong = (rigcal_real)WRONG;
    test_watched_make(&w, &rng, 2, 1, 0.02 * DEGREE, 2e-4);
    test_watched_begin(&w, 0, &o);
    test_watched_match(&w, &rng, &right);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, 1));
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_ask(&before, w.monitor));
    TEST_ASSERT_EQUAL_UINT32(200, before.rows);
    TEST_ASSERT_LESS_THAN_UINT32(20, before.doubted);
    test_watched_match(&w, &rng, &wrong);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, 1));
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_ask(&after, w.monitor));
    TEST_ASSERT_EQUAL_UINT32(300, after.rows);
    TEST_ASSERT_GREATER_THAN_UINT32(60, after.doubted - before.doubted);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(120, after.doubted);
}

/* Two rays of parallel cameras that miss each other by `deviations` of their noise, in the
 * image's vertical. */
static void miss(rigcal_real rays[2][3], double deviations)
{
    for (int c = 0; c < 2; c++) {
        rays[c][0] = RC(0.1 - 0.1 * c);
        rays[c][1] = RC(c * deviations * sqrt(2) * 0.3 / 800);
        rays[c][2] = 1;
    }
}

/* With exact poses, and 5 % wrong over 100 deviations, half the rows that are off by 3.64
 * deviations are wrong: 0.95 exp(-z^2 / 2) / sqrt(2 pi) is 0.05 / 100 there. That holds
 * before an alarm and after it. */
static void test_a_row_is_doubted_if_it_is_more_likely_wrong_than_right(void)
{
    test_rng rng = test_seed(17);
    rigcal_monitor_options o;
    rc_monitor open;
    uint32_t rows = 0, doubted = 0;

    WANTS_RIG();
    quiet(&o);
    o.wrong = (rigcal_real)WRONG;
    test_watched_make(&w, &rng, 2, 1, 0, 0);
    test_watched_begin(&w, 0, &o);
    for (int has_alarm = 0; has_alarm < 2; has_alarm++) {
        for (int is_far = 0; is_far < 2; is_far++) {
            rigcal_monitor_report report;
            rigcal_real rays[2][3];

            miss(rays, is_far ? 3.70 : 3.58);
            ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_match_rays(w.monitor, 0, rays[0], 1,
                                                               rays[1], RC(0.3)));
            rows++;
            doubted += (uint32_t)is_far;
            ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_ask(&report, w.monitor));
            TEST_ASSERT_EQUAL_UINT32(rows, report.rows);
            TEST_ASSERT_EQUAL_UINT32(doubted, report.doubted);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, 0));
        ASSERT_STATUS(RIGCAL_OK, rc_monitor_open(&open, w.monitor));
        open.top.head.alarm.log_limit = -1000; /* the next frame raises the alarm */
        rc_monitor_close(&open, 1);
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, 0));
    }
}

/* ---- what is not used ---- */

/* A target without a place has the identity as its pose. The head's room beyond the head is
 * 0. */
static void test_what_is_not_used_yet_is_set(void)
{
    static const double ONE[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, NONE[3] = {0, 0, 0};
    const rigcal_transform identity = test_transform(ONE, NONE);
    const unsigned char *const bytes = (const unsigned char *)w.monitor;
    test_rng rng = test_seed(18);
    rc_monitor open;

    WANTS_RIG();
    test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
    test_watched_begin(&w, 1, NULL);
    ASSERT_STATUS(RIGCAL_OK, rc_monitor_open(&open, w.monitor));
    TEST_ASSERT_EQUAL_MEMORY(&identity, &open.filter.poses[2], sizeof identity);
    for (size_t k = sizeof(rc_monitor_head); k < RIGCAL_MONITOR_HEAD * sizeof(rigcal_real);
         k++) {
        TEST_ASSERT_EQUAL_UINT8(0, bytes[k]);
    }
}

/* ---- a body that settles ---- */

/* Sets what camera a saw of a point, and camera b. */
static void see_match(rc_seen *seen, size_t a, size_t b, test_rng *rng)
{
    const size_t of[2] = {a, b};
    double X[3];

    memset(seen, 0, sizeof *seen);
    seen->a = a;
    seen->b = b;
    seen->n_rows = 1;
    test_watched_point(X, &w, rng);
    for (int k = 0; k < 2; k++) {
        double uv[2];

        test_watched_pixel(uv, &w, (int)of[k], X);
        const rigcal_real ray[3] = {RC((uv[0] - 640) / 800), RC((uv[1] - 480) / 800), 1};
        ASSERT_STATUS(RIGCAL_OK,
                      rc_sight_of(&seen->sight[k], &w.cameras[of[k]].camera, ray, RC(0.3)));
    }
}

/* Of a match of a and b: learns its row with these open bodies, and says which poses move
 * at once. */
static void expect_match(size_t frame, size_t moved, size_t a, size_t b, int bits,
                         test_rng *rng)
{
    rigcal_transform before[3];
    rc_monitor here, there;
    rc_seen seen;
    rc_news news;
    rc_row row;

    test_watched_make(&w, rng, 3, 0, 1 * DEGREE, 2e-2);
    w.held[0] = 0;
    w.held[frame] = 1;
    test_watched_begin(&w, 0, NULL);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_moved(w.monitor, moved));
    memcpy(copy, w.monitor, sizeof copy);
    ASSERT_STATUS(RIGCAL_OK, rc_monitor_open(&here, w.monitor));
    ASSERT_STATUS(RIGCAL_OK, rc_monitor_open(&there, copy));
    memcpy(before, here.filter.poses, sizeof before);
    see_match(&seen, a, b, rng);
    ASSERT_STATUS(RIGCAL_OK, rc_monitor_take(&here, &seen));
    const rc_filter *const f = &there.filter;
    ASSERT_STATUS(RIGCAL_OK, rc_rows_of(&row, &seen, &f->poses[a], &f->poses[b]));
    TEST_ASSERT_TRUE(rc_filter_row(&news, f, a, b, &row, there.top.head.wrong, bits));
    TEST_ASSERT_EQUAL_MEMORY(f->UD, here.filter.UD, f->n * (f->n + 1) / 2 * sizeof *f->UD);
    for (size_t c = 0; c < 3; c++) {
        const int moves = memcmp(&before[c], &here.filter.poses[c], sizeof before[c]) != 0;
        TEST_ASSERT_EQUAL_INT(bits != 0 && (moved == frame ? c != frame : c == moved),
                              moves);
    }
}

/* A row of the body that settles is learned as one of a body that may be off by degrees,
 * and its pose moves at once. If it is the frame, all rows are, and all others move. */
static void test_the_body_that_settles_is_open_in_its_rows(void)
{
    test_rng rng = test_seed(19);

    if (WATCHED_CAMERAS_MAX < 3) {
        TEST_IGNORE_MESSAGE("wants three cameras");
    }
    expect_match(0, 1, 1, 2, 1, &rng);
    expect_match(0, 1, 2, 1, 2, &rng);
    expect_match(0, 1, 2, 0, 0, &rng);
    expect_match(0, 2, 1, 2, 2, &rng);
    expect_match(0, 0, 1, 2, 3, &rng);
    expect_match(0, 0, 0, 2, 3, &rng);
    expect_match(1, 1, 0, 2, 3, &rng);
    expect_match(2, 0, 0, 1, 1, &rng);
}

/* ---- what is refused
 * ---------------------------------------------------------------------- */

static void test_a_failed_match_changes_nothing(void)
{
    static rigcal_real kept[RIGCAL_MONITOR_SIZE(2, 0)];
    const rigcal_real ray[3] = {0, 0, 1}, along[3] = {1, 0, 0}, behind[3] = {0, 0, -1};
    test_rng rng = test_seed(7);

    TEST_WANTS_RAM(sizeof w + sizeof kept + 6000);
    test_watched_make(&w, &rng, 2, 0, 0.05 * DEGREE, 2e-3);
    test_watched_begin(&w, 0, NULL);
    const rigcal_transform back = test_inverse(&w.cameras[1].cam_from_rig);
    const rigcal_real *const to_other = back.t;
    memcpy(kept, w.monitor, sizeof kept);
    ASSERT_STATUS(RIGCAL_ERR_BEHIND,
                  rigcal_monitor_match_rays(w.monitor, 0, ray, 1, behind, 1));
    ASSERT_STATUS(RIGCAL_ERR_BEHIND,
                  rigcal_monitor_match_rays(w.monitor, 0, ray, 1, along, 1));
    /* each camera sees the other */
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE,
                  rigcal_monitor_match_rays(w.monitor, 0, to_other, 1,
                                            w.cameras[1].cam_from_rig.t, 1));
    ASSERT_STATUS(RIGCAL_ERR_RANGE,
                  rigcal_monitor_match_rays(w.monitor, 0, ray, 0, ray, 1));
    ASSERT_STATUS(RIGCAL_ERR_RANGE,
                  rigcal_monitor_match_rays(w.monitor, 0, ray, 2, ray, 1));
    ASSERT_STATUS(RIGCAL_ERR_RANGE,
                  rigcal_monitor_match_rays(w.monitor, 0, ray, 1, ray, 0));
    TEST_ASSERT_EQUAL_MEMORY(kept, w.monitor, sizeof kept);
}

/* Each camera, each ray and the noise, at its bounds and beyond. A match with the largest
 * noise may lie on the line through both centres. */
static void test_arguments_of_a_match_are_checked_from_both_sides(void)
{
    const rigcal_real ray[3] = {0, 0, 1}, uv[2] = {640, 480}, far = RC(TOL(1e30, 1e9));
    const rigcal_real up = 1 + RC(TOL(1e-15, 2e-7));
    const rigcal_real rays[8][3] = {{0, 0, 0},
                                    {TEST_NAN, 0, 1},
                                    {0, TEST_INF, 1},
                                    {0, 0, 2 * far},
                                    {0, 0, far},
                                    {0, 0, RC(1e-3)},
                                    {0, RC(1.5) * far, RC(2.2) * far},
                                    {RC(2.2) * far, 0, RC(1.5) * far}};
    const rigcal_status of_ray[8] = {RIGCAL_ERR_RANGE,
                                     RIGCAL_ERR_NOT_FINITE,
                                     RIGCAL_ERR_NOT_FINITE,
                                     RIGCAL_ERR_RANGE,
                                     RIGCAL_OK,
                                     RIGCAL_OK,
                                     RIGCAL_ERR_RANGE,
                                     RIGCAL_ERR_RANGE};
    const rigcal_real noise[5] = {RC(1e-6), RC(1e6), RC(1e-6) / up, RC(1e6) * up, TEST_NAN};
    const rigcal_status of_noise[5] = {RIGCAL_OK, RIGCAL_ERR_DEGENERATE, RIGCAL_ERR_RANGE,
                                       RIGCAL_ERR_RANGE, RIGCAL_ERR_NOT_FINITE};
    test_rng rng = test_seed(16);

    WANTS_RIG();
    test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
    test_watched_begin(&w, 1, NULL);
    for (int i = 0; i < 8; i++) {
        ASSERT_STATUS(of_ray[i],
                      rigcal_monitor_match_rays(w.monitor, 0, rays[i], 1, ray, 1));
        ASSERT_STATUS(of_ray[i],
                      rigcal_monitor_match_rays(w.monitor, 0, ray, 1, rays[i], 1));
    }
    for (int i = 0; i < 5; i++) {
        ASSERT_STATUS(of_noise[i],
                      rigcal_monitor_match_rays(w.monitor, 1, ray, 0, ray, noise[i]));
        ASSERT_STATUS(of_noise[i], rigcal_monitor_match(w.monitor, 1, uv, 0, uv, noise[i]));
    }
    for (size_t a = 0; a < 4; a++) {
        for (size_t b = 0; b < 4; b++) { /* body 2 is no camera */
            const rigcal_status status =
                a < 2 && b < 2 && a != b ? RIGCAL_OK : RIGCAL_ERR_RANGE;

            ASSERT_STATUS(status, rigcal_monitor_match_rays(w.monitor, a, ray, b, ray, 1));
            ASSERT_STATUS(status, rigcal_monitor_match(w.monitor, a, uv, b, uv, 1));
        }
    }
    const rigcal_real wild[2] = {480, TEST_NAN};
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_match(w.monitor, 0, NULL, 1, uv, 1));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_monitor_match(w.monitor, 0, uv, 1, NULL, 1));
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_monitor_match_rays(w.monitor, 0, NULL, 1, ray, 1));
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_monitor_match_rays(w.monitor, 0, ray, 1, NULL, 1));
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE,
                  rigcal_monitor_match(w.monitor, 0, wild, 1, uv, 1));
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE,
                  rigcal_monitor_match(w.monitor, 0, uv, 1, wild, 1));
}

TEST_MAIN()
{
    RUN_TEST(test_a_monitor_takes_what_its_macro_says_and_no_more_than_it_may);
    RUN_TEST(test_a_monitor_is_the_same_in_memory_of_any_bytes);
    RUN_TEST(test_memory_that_was_not_begun_is_refused);
    RUN_TEST(test_a_bit_that_was_changed_is_noticed);
    RUN_TEST(test_a_head_of_wrong_numbers_is_refused_under_a_right_seal);
    RUN_TEST(test_a_bit_of_the_head_is_noticed_within_a_frame);
    RUN_TEST(test_the_whole_is_sealed_from_the_end_of_a_frame_to_its_first_row);
    RUN_TEST(test_a_view_breaks_the_seal);
    RUN_TEST(test_a_monitor_may_be_copied);
    RUN_TEST(test_rigs_that_cannot_be_watched_are_refused);
    RUN_TEST(test_the_defaults_are_those_of_the_header);
    RUN_TEST(test_options_are_checked_from_both_sides);
    RUN_TEST(test_options_are_kept);
    RUN_TEST(test_each_camera_gets_its_part_of_the_covariance);
    RUN_TEST(test_a_covariance_is_checked_from_both_sides);
    RUN_TEST(test_matches_of_a_still_pair_do_not_learn_the_length_of_its_base);
    RUN_TEST(test_poses_after_many_rows_are_those_of_double_arithmetic);
    RUN_TEST(test_wrong_matches_are_counted);
    RUN_TEST(test_a_row_is_doubted_if_it_is_more_likely_wrong_than_right);
    RUN_TEST(test_what_is_not_used_yet_is_set);
    RUN_TEST(test_the_body_that_settles_is_open_in_its_rows);
    RUN_TEST(test_a_failed_match_changes_nothing);
    RUN_TEST(test_arguments_of_a_match_are_checked_from_both_sides);
}
