/* times: the input of clocks, and the time of a view. The truth is made by hand. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "rc_times.h"
#include "test_motions.h"

static test_motions m;

#define WANTS_MOTIONS() TEST_WANTS_RAM(sizeof(test_motions) + 60000)

static const motion_scene SCENE = {3, 3, 3, 30, 0.35, 0.8, 10, 0.01, 0, 0, 0.3};

static void make(const motion_scene *scene, uint64_t seed)
{
    test_rng rng = test_seed(seed);

    test_motions_make(&m, &rng, scene);
    test_motions_solve(&m);
}

static rigcal_status adjust(rigcal_rig_fit *fit)
{
    m.rig.clocks = &m.clocks;
    return rigcal_rig_adjust(fit, NULL, &m.rig);
}

static void test_the_frame_is_the_middle_step(void)
{
    rigcal_rig_fit fit;

    WANTS_MOTIONS();
    make(&SCENE, 120);
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    ASSERT_NEAR(1.0 / 30, m.clocks.frame, 1e-6);
}

/* The steps take 1 to 8 hundredths of a second. Their median is the fourth one. */
static void test_the_frame_is_the_median_of_steps_that_differ(void)
{
    WANTS_MOTIONS();
    make(&SCENE, 123);
    TEST_ASSERT_EQUAL_size_t(9, m.rig.n_placements);
    for (int f = 0; f < 9; f++) {
        m.times[f] = RC(0.01 * f * (f + 1) / 2);
    }
    m.rig.clocks = &m.clocks;
    m.clocks.frame = 0;
    ASSERT_STATUS(RIGCAL_OK, rc_times_check(&m.rig));
    ASSERT_NEAR(0.04, m.clocks.frame, 1e-6);
}

static void test_offsets_in_frames(void)
{
    rigcal_real offsets[5] = {RC(0), RC(0.016), RC(0.018), RC(-0.09), RC(-0.01)};
    static const int32_t EXPECTED[5] = {0, 0, 1, -3, 0};
    int32_t frames[5];
    rigcal_rig_clocks clocks;

    ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_defaults(&clocks));
    clocks.offsets = offsets;
    clocks.frame = RC(1.0 / 30);
    ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_frames(frames, &clocks, 5));
    TEST_ASSERT_EQUAL_INT32_ARRAY(EXPECTED, frames, 5);
    offsets[2] = TEST_NAN;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rigcal_clocks_frames(frames, &clocks, 5));
    offsets[2] = RC(1e8);
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_clocks_frames(frames, &clocks, 5));
    clocks.frame = 0;
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_clocks_frames(frames, &clocks, 5));
}

static void test_times_must_rise(void)
{
    rigcal_rig_fit fit;

    WANTS_MOTIONS();
    make(&SCENE, 121);
    const rigcal_real right = m.times[4];
    m.times[4] = m.times[3];
    ASSERT_STATUS(RIGCAL_ERR_TWICE, adjust(&fit));
    m.times[4] = m.times[2];
    ASSERT_STATUS(RIGCAL_ERR_UNSORTED, adjust(&fit));
    m.times[4] = TEST_INF;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, adjust(&fit));
    m.times[4] = RC(TOL(1e31, 1e10));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, adjust(&fit));
    m.times[4] = TEST_NAN; /* not known */
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CLOCK_FREE, m.states[1]);
    m.times[4] = right;
    for (int f = 0; f < 9; f++) { /* their rounding is larger than their steps */
        m.times[f] = (rigcal_real)(TOL(1e14, 1e5) + f);
    }
    ASSERT_STATUS(RIGCAL_ERR_PRECISION, adjust(&fit));
}

/* If no times are known, their middle is 0, and the clocks do not drift. */
static void test_the_middle_of_no_times_is_0(void)
{
    WANTS_MOTIONS();
    make(&SCENE, 122);
    m.rig.clocks = &m.clocks;
    m.clocks.frame = RC(1.0 / 30);
    ASSERT_STATUS(RIGCAL_OK, rc_times_check(&m.rig));
    ASSERT_NEAR((D(m.times[0]) + D(m.times[m.rig.n_placements - 1])) / 2,
                m.clocks.memory.middle, TOL(1e-12, 1e-4));
    for (size_t f = 0; f < m.rig.n_placements; f++) {
        m.times[f] = TEST_NAN;
    }
    ASSERT_STATUS(RIGCAL_OK, rc_times_check(&m.rig));
    ASSERT_NEAR(0, m.clocks.memory.middle, 0);
}

/* ---- by hand ---------------------------------------------------------------- */

enum { PLACES = 4 };

static struct {
    rigcal_rig rig;
    rigcal_rig_clocks clocks;
    rigcal_transform places[PLACES];
    rigcal_real times[PLACES + 1], instants[PLACES], view_times[2], offsets[3], drifts[3];
    int32_t states[2];
} h;

static const rigcal_real MOST = RIGCAL_USE_FLOAT ? RC(1e9) : RC(1e30);

/* Two cameras and up to four placements with these times; the one beyond them is no part of
 * the rig. */
static void by_hand(size_t n, double a, double b, double c, double d)
{
    const double times[PLACES] = {a, b, c, d};

    memset(&h, 0, sizeof h);
    ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_defaults(&h.clocks));
    test_to_real(h.times, times, PLACES);
    h.offsets[2] = h.drifts[2] = TEST_NAN; /* of no camera */
    h.clocks.times = h.times;
    h.clocks.instants = h.instants;
    h.clocks.offsets = h.offsets;
    h.clocks.drifts = h.drifts;
    h.clocks.states = h.states;
    h.rig.clocks = &h.clocks;
    h.rig.n_cameras = 2;
    h.rig.n_placements = n;
    h.rig.rig_from_placements = h.places;
}

static void expect_frame(double frame, size_t n, double a, double b, double c, double d)
{
    by_hand(n, a, b, c, d);
    ASSERT_STATUS(RIGCAL_OK, rc_times_check(&h.rig));
    ASSERT_NEAR(frame, h.clocks.frame, TOL(3e-8, 1e-7));
}

/* The lower of two middle ones. Steps above 0.35 are pauses. */
static void test_the_frame_is_the_median_of_the_steps_up_to_the_longest(void)
{
    const double most = D(RC(0.35)), none = D(TEST_NAN);

    expect_frame(0.35, 4, none, none, none, none);
    expect_frame(0.35, 1, 3, 3.04, 0, 0);
    expect_frame(0.04, 2, 3, 3.04, 3.05, 0); /* the third is no part of it */
    expect_frame(0.02, 3, 3, 3.02, 3.06, 0);
    expect_frame(0.04, 3, 3, none, 3.04, 0);
    expect_frame(0.35, 4, -most, 0, most, most + 0.1);
    expect_frame(0.1, 4, -most - 0.01, 0, most + 0.01, most + 0.11);
    for (int k = 0; k < 40; k++) { /* to 0.35 / 2^24, and not below */
        const double step = 0.01 + 0.0083 * k;

        by_hand(2, 0, step, 0, 0);
        ASSERT_STATUS(RIGCAL_OK, rc_times_check(&h.rig));
        ASSERT_NEAR(D(h.times[1]) + 0.175 / (1 << 24), h.clocks.frame,
                    TOL(0.176 / (1 << 24), 6e-8));
    }
}

static void test_a_frame_that_is_given_stays(void)
{
    by_hand(2, 10, 10.04, 0, 0);
    h.clocks.frame = RC(0.5);
    ASSERT_STATUS(RIGCAL_OK, rc_times_check(&h.rig));
    ASSERT_NEAR(0.5, h.clocks.frame, 0);
    ASSERT_NEAR(10.02, h.clocks.memory.middle, TOL(1e-14, 1e-6));
}

static void expect_check(rigcal_status expected)
{
    ASSERT_STATUS(expected, rc_times_check(&h.rig));
}

static void test_what_clocks_need_is_checked_one_by_one(void)
{
    const rigcal_real up = 1 + RC(TOL(1e-15, 2e-7));

    for (int k = 0; k < 5; k++) {
        by_hand(2, 0, 0.1, 0, 0);
        h.clocks.times = k == 0 ? NULL : h.times;
        h.clocks.instants = k == 1 ? NULL : h.instants;
        h.clocks.states = k == 2 ? NULL : h.states;
        h.clocks.offsets = k == 3 ? NULL : h.offsets;
        h.clocks.drifts = NULL;
        expect_check(k < 4 ? RIGCAL_ERR_NULL : RIGCAL_OK);
    }
    h.clocks.free_drifts = 1;
    expect_check(RIGCAL_ERR_NULL);
    for (int c = 0; c < 2; c++) {
        by_hand(2, 0, 0.1, 0, 0);
        h.offsets[c] = -MOST;
        h.drifts[c] = -1;
        h.clocks.free_drifts = 1;
        expect_check(RIGCAL_OK);
        h.drifts[c] = -up;
        expect_check(RIGCAL_ERR_RANGE);
        h.drifts[c] = TEST_NAN;
        expect_check(RIGCAL_ERR_NOT_FINITE);
        h.drifts[c] = 1;
        h.offsets[c] = MOST * up;
        expect_check(RIGCAL_ERR_RANGE);
        h.offsets[c] = TEST_NAN;
        expect_check(RIGCAL_ERR_NOT_FINITE);
    }
    for (int32_t n = 0; n < 6; n++) {
        by_hand(2, 0, 0.1, 0, 0);
        h.clocks.neighbours = n;
        expect_check(n >= 1 && n <= 4 ? RIGCAL_OK : RIGCAL_ERR_RANGE);
    }
    for (int k = 0; k < 4; k++) {
        by_hand(2, 0, 0.1, 0, 0);
        *(k % 2 ? &h.clocks.frame : &h.clocks.sigma_time) = k < 2 ? RC(-1) : TEST_NAN;
        expect_check(k < 2 ? RIGCAL_ERR_RANGE : RIGCAL_ERR_NOT_FINITE);
    }
}

/* The largest number is finite, and the largest coordinate is within the range. */
static void test_times_at_their_limits(void)
{
    const rigcal_real scale = RC(TOL(1024. * 1024 * 1024 * 1024, 1024));
    const rigcal_real eps = RC(TOL(DBL_EPSILON, FLT_EPSILON));

    by_hand(2, 0, 0.1, 0, 0);
    h.times[1] = MOST;
    h.clocks.frame = 1;
    expect_check(RIGCAL_ERR_PRECISION);
    h.times[1] = MOST * RC(1.001);
    expect_check(RIGCAL_ERR_RANGE);
    h.times[1] = RC(TOL(DBL_MAX, FLT_MAX));
    expect_check(RIGCAL_ERR_RANGE);
    h.times[1] = TEST_INF;
    expect_check(RIGCAL_ERR_NOT_FINITE);
    for (int sign = -1; sign < 2; sign += 2) { /* rounding of 0.001 frames, and of more */
        for (int more = 0; more < 2; more++) {
            by_hand(2, 0, 0, 0, 0);
            h.clocks.frame = eps * scale;
            h.times[sign > 0] = RC(0.001) * scale * RC(sign) * (more ? RC(1.001) : 1);
            expect_check(more ? RIGCAL_ERR_PRECISION : RIGCAL_OK);
        }
    }
}

/* ---- where a view sees its placement, and its weight --------------------------- */

/* The target moves along x, at 3 a second. The clock is 0.25 late, and drifts by 0.125 from
 * the time 2 on. */
static void test_a_view_sees_its_placement_by_the_clock_of_its_camera(void)
{
    static const double ONE[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, AT[3] = {5, 6, 7};

    for (int k = 0; k < 6; k++) {
        rigcal_transform seen = test_transform(ONE, AT);
        rigcal_clock_memory *const memory = &h.clocks.memory;
        double stamp = 4;

        by_hand(4, 0, 4, 5, 6);
        memory->placement = 1;
        memory->middle = 2;
        memory->motion.n = k == 1 ? 0 : 1;
        memory->motion.c[0][3] = 3;
        memory->since = memory->after = 9;
        h.instants[1] = RC(4.5);
        h.offsets[1] = RC(0.25);
        h.drifts[1] = RC(0.125);
        h.clocks.view_times = k >= 3 ? h.view_times : NULL;
        h.view_times[1] = k == 3 ? RC(4.5) : k == 4 ? MOST : TEST_NAN;
        stamp = k == 3 ? 4.5 : k == 4 ? D(MOST) : 4;
        h.clocks.drifts = k == 2 ? NULL : h.drifts;
        rc_times_place(&seen, &h.rig, 1, 1, 1);
        const double since = k == 1 ? 0 : stamp - 2;
        const double after = k == 1 ? 0 : stamp - 4.5 + 0.25 + (k == 2 ? 0 : 0.125 * since);
        ASSERT_NEAR(since, memory->since, D(MOST) * 1e-6 * (k == 4));
        ASSERT_NEAR(after, memory->after, D(MOST) * 1e-6 * (k == 4));
        if (k != 4) {
            ASSERT_NEAR(5 + 3 * after, seen.t[0], TOL(1e-14, 1e-6));
        }
        ASSERT_NEAR(6, seen.t[1], 0);
        TEST_ASSERT_EQUAL_INT32(k == 0 || k == 1 || k == 5 ? after != 0 : 1,
                                memory->is_moved);
    }
}

/* (H11): without the stamp's noise nothing changes. */
static void test_noise_of_a_stamp_takes_the_motion_out_of_a_view(void)
{
    test_rng rng = test_seed(130);

    for (int trial = 0; trial < 6; trial++) {
        const double ratio2 = trial == 0 ? 0 : trial == 1 ? 0.5 : 20;
        const rigcal_transform to_camera = test_random_transform(&rng);
        const rigcal_transform at = test_random_transform(&rng);
        double H[36], g[6], mv[6], Hm[6] = {0}, mHm = 0, along = 0, L[36], xi[6];
        rigcal_real full[36], H_real[21], g_real[6], sum = 50;
        rc_chain chain;

        by_hand(2, 0, 0.1, 0, 0);
        rc_chain_of(&chain, &to_camera, &at);
        for (int i = 0; i < 36; i++) {
            L[i] = test_normal(&rng);
        }
        for (int i = 0; i < 6; i++) {
            g[i] = D(RC(test_normal(&rng)));
            xi[i] = test_normal(&rng);
            h.clocks.memory.velocity[i] = RC(xi[i]);
            for (int j = 0; j < 6; j++) {
                H[6 * i + j] = i == j;
                for (int k = 0; k < 6; k++) {
                    H[6 * i + j] += L[6 * i + k] * L[6 * j + k];
                }
            }
        }
        double R[9];
        test_transform_parts(R, NULL, &to_camera);
        test_apply(mv, R, xi, NULL);
        test_apply(&mv[3], R, &xi[3], NULL);
        for (int i = 0; i < 6; i++) {
            for (int j = 0; j < 6; j++) {
                Hm[i] += H[6 * i + j] * mv[j];
            }
            mHm += mv[i] * Hm[i];
            along += mv[i] * g[i];
        }
        test_to_real(full, H, 36);
        test_to_real(g_real, g, 6);
        rc_sym6_pack(H_real, full);
        h.clocks.memory.ratio2 = RC(ratio2);
        rc_times_weigh(&sum, g_real, H_real, &chain, &h.rig);
        const double s = ratio2 > 0 ? 1 / (mHm + ratio2) : 0;
        rc_sym6_unpack(full, H_real);
        for (int i = 0; i < 36; i++) {
            ASSERT_NEAR(H[i] - s * Hm[i / 6] * Hm[i % 6], full[i], TOL(1e-11, 1e-3));
        }
        for (int i = 0; i < 6; i++) {
            ASSERT_NEAR(g[i] - s * Hm[i] * along, g_real[i], TOL(1e-11, 1e-3));
        }
        ASSERT_NEAR(50 - s * along * along, sum, TOL(1e-12, 1e-4));
    }
}

/* ---- offsets in frames ---------------------------------------------------------- */

static void test_offsets_in_frames_at_their_limits(void)
{
    const size_t most = RC_COUNT_MAX;
    int32_t frames[3] = {0, 0, 99};

    by_hand(2, 0, 0.1, 0, 0);
    h.clocks.frame = RC(0.5);
    h.offsets[0] = RC(500000);
    h.offsets[1] = RC(-500000);
    ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_frames(frames, &h.clocks, 2));
    TEST_ASSERT_TRUE(frames[0] == 1000000 && frames[1] == -1000000 && frames[2] == 99);
    for (int c = 0; c < 2; c++) {
        h.offsets[c] += h.offsets[c] < 0 ? RC(-0.25) : RC(0.25);
        FILL(frames);
        ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_clocks_frames(frames, &h.clocks, 2));
        ASSERT_UNTOUCHED(frames);
        h.offsets[c] = 0;
    }
    h.clocks.frame = 0;
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_clocks_frames(frames, &h.clocks, 2));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_clocks_frames(frames, &h.clocks, 0));
    h.clocks.frame = TEST_NAN;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rigcal_clocks_frames(frames, &h.clocks, 2));
    h.clocks.frame = RC(0.5);
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_clocks_frames(NULL, &h.clocks, 2));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_clocks_frames(frames, NULL, 2));
    h.offsets[0] = TEST_NAN; /* no further one is read */
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rigcal_clocks_frames(frames, &h.clocks, most));
    if (most < SIZE_MAX) {
        ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_clocks_frames(frames, &h.clocks, most + 1));
    }
    h.clocks.offsets = NULL;
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_clocks_frames(frames, &h.clocks, 2));
}

TEST_MAIN()
{
    RUN_TEST(test_the_frame_is_the_middle_step);
    RUN_TEST(test_the_frame_is_the_median_of_steps_that_differ);
    RUN_TEST(test_offsets_in_frames);
    RUN_TEST(test_times_must_rise);
    RUN_TEST(test_the_middle_of_no_times_is_0);
    RUN_TEST(test_the_frame_is_the_median_of_the_steps_up_to_the_longest);
    RUN_TEST(test_a_frame_that_is_given_stays);
    RUN_TEST(test_what_clocks_need_is_checked_one_by_one);
    RUN_TEST(test_times_at_their_limits);
    RUN_TEST(test_a_view_sees_its_placement_by_the_clock_of_its_camera);
    RUN_TEST(test_noise_of_a_stamp_takes_the_motion_out_of_a_view);
    RUN_TEST(test_offsets_in_frames_at_their_limits);
}
