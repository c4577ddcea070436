/* For pixels without any error the sum of squares is 0. The part of it that a fault
 * explains was 0 / 0. With assertions the test for faults ended the program; without them
 * the bic of a fault meant nothing. */
#include <math.h>
#include <string.h>

#include "rigcal_faults.h"
#include "test_rigs.h"

enum { CAMERAS = 2, PLACEMENTS = 3, FAULTS = 24 };

static test_rig r;
static rigcal_real room[RIGCAL_FAULTS_WORK(CAMERAS, CAMERAS)];
static rigcal_fault faults[FAULTS];

/* All numbers have few bits, so that no pixel is rounded. */
static void make_exact(void)
{
    test_rng rng = test_seed(1);

    test_rig_random(&r, &rng, CAMERAS, PLACEMENTS, 4);
    for (int c = 0; c < CAMERAS; c++) {
        const double t[3] = {-c, 0, 0};

        r.camera[c].cx = r.camera[c].cy = 320;
        r.camera[c].k1 = 0;
        r.true_cams[c] = test_transform(NULL, t);
    }
    for (int p = 0; p < PLACEMENTS; p++) {
        const double t[3] = {0, 0, 8 << p};

        r.true_places[p] = test_transform(NULL, t);
    }
    for (int i = 0; i < 4; i++) {
        r.X[i][0] = i % 2 ? 1 : -1;
        r.X[i][1] = i / 2 ? 1 : -1;
        r.X[i][2] = 0;
    }
    memcpy(r.cams, r.true_cams, sizeof r.cams);
    memcpy(r.places, r.true_places, sizeof r.places);
    test_rig_see_all(&r, &rng, 0);
}

static void test_exact_pixels_show_that_there_is_no_fault(void)
{
    rigcal_faults_options options = {0};
    rigcal_faults found;
    rigcal_rig_fit fit;

    TEST_WANTS_RAM(sizeof r + sizeof room + sizeof faults + 12000);
    make_exact();
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    ASSERT_NEAR(0, fit.sum, 0);
    options.work = room;
    options.work_capacity = sizeof room / sizeof *room;
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_rig_faults(&found, faults, FAULTS, NULL, &options, &r.rig));
    TEST_ASSERT_TRUE((found.bits & RIGCAL_FAULTS_NO_LOOP) != 0);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_RIG_AGREES, found.verdict);
    ASSERT_NEAR(0, found.sigma_px, 0);
    TEST_ASSERT_EQUAL_INT32(0, found.bits & RIGCAL_FAULTS_NAMED);
    TEST_ASSERT_TRUE(found.n_seen > 0);
    for (int i = 0; i < found.n_seen; i++) {
        TEST_ASSERT_EQUAL_INT32(1, faults[i].is_seen);
        ASSERT_NEAR(0, faults[i].gain, 0);
        ASSERT_NEAR(0, faults[i].sigma[0], 0);
        ASSERT_NEAR(1, faults[i].p, 0);
        /* n log(1 - 0) + k log(n) for 48 numbers */
        ASSERT_NEAR(faults[i].n * log(48), faults[i].bic, TOL(1e-12, 1e-4));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_exact_pixels_show_that_there_is_no_fault);
}
