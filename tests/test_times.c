/* times: the input of clocks, and the time of a view. The truth is made by hand. */
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

/* Of steps of 1 to 8 hundredths of a second the middle is the fourth. */
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

TEST_MAIN()
{
    RUN_TEST(test_the_frame_is_the_middle_step);
    RUN_TEST(test_offsets_in_frames);
    RUN_TEST(test_times_must_rise);
    RUN_TEST(test_the_middle_of_no_times_is_0);
    RUN_TEST(test_the_frame_is_the_median_of_steps_that_differ);
}
