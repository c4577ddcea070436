/* The test for faults left out the priors of cameras: their part of the sum of squares and
 * of its derivative. Where a prior and the views pulled in different directions, all faults
 * of cameras had wrong sizes, and F was not that of the adjustment. So it is with priors
 * that are independent, and with those that are not. */
#include <math.h>
#include <string.h>

#include "rigcal_faults.h"
#include "test_rigs.h"

enum { CAMERAS = 3, PLACEMENTS = 6, FAULTS = 48 };

static test_rig r;
static rigcal_real information[RIGCAL_CALIBRATED_SIZE(CAMERAS - 1)];
static rigcal_real room[RIGCAL_FAULTS_WORK(CAMERAS, CAMERAS)];
static rigcal_fault faults[FAULTS];

/* Cameras 1 and 2 have priors whose errors are some standard deviations. */
static void make(test_rng *rng)
{
    test_rig_random(&r, rng, CAMERAS, PLACEMENTS, 12);
    test_rig_see_all(&r, rng, 0.3);
    test_rig_start(&r, rng, 0, 0);
    test_rig_solve_views(&r);
    r.rig.view_poses = r.own;
    r.rig.sigma_px = RC(0.3);
    r.rig.roles = r.roles;
    r.rig.priors = r.priors;
    for (int c = 0; c < CAMERAS; c++) {
        const double d[6] = {0.003, -0.002, 0.002, 0.004, -0.003, 0.005};

        r.roles[c] = c == 0 ? RIGCAL_CAMERA_HELD : RIGCAL_CAMERA_PRIOR;
        r.priors[c].cam_from_rig = test_moved(&r.true_cams[c], d);
        for (int k = 0; k < 6; k++) {
            r.priors[c].Sigma[7 * k] = RC(1e-6);
        }
    }
}

/* The priors of cameras 1 and 2 are correlated by 0.8 in each axis. */
static void correlate(void)
{
    memset(information, 0, sizeof information);
    for (size_t i = 0; i < 12; i++) {
        information[i * (i + 1) / 2 + i] = RC(1e-6);
    }
    for (size_t i = 6; i < 12; i++) {
        information[i * (i + 1) / 2 + i - 6] = RC(0.8e-6);
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_priors_information(information, information, 2));
    r.rig.priors_information = information;
}

/* The least sum if fx and fy of camera 1 are larger by this part. */
static double sum_with(double focal)
{
    const rigcal_camera kept = r.camera[1];
    rigcal_rig_fit fit;

    r.camera[1].fx *= (rigcal_real)(1 + focal);
    r.camera[1].fy *= (rigcal_real)(1 + focal);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    r.camera[1] = kept;
    return D(fit.sum);
}

static void finds_what_an_adjustment_finds(int is_joint)
{
    const double step = 2e-3;
    rigcal_faults_options options = {0};
    rigcal_faults found;
    rigcal_rig_fit fit;
    test_rng rng = test_seed(5);

    TEST_WANTS_RAM(sizeof r + sizeof room + sizeof faults + 12000);
    make(&rng);
    if (is_joint) {
        correlate();
    }
    /* the least of the parabola through three sums */
    const double less = sum_with(-step), more = sum_with(step), none = sum_with(0);
    const double bend = (less + more - 2 * none) / (step * step);
    const double slope = (more - less) / (2 * step);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    options.kinds = RIGCAL_FAULTS_OF(RIGCAL_FAULT_FOCAL);
    options.work = room;
    options.work_capacity = sizeof room / sizeof *room;
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_rig_faults(&found, faults, FAULTS, NULL, &options, &r.rig));
    ASSERT_NEAR(fit.F, found.F, 1e-2 * D(fit.F));
    ASSERT_NEAR(fit.sigma_px, found.sigma_px, TOL(1e-4, 1e-3) * D(fit.sigma_px));
    int is_found = 0;
    for (int i = 0; i < found.n; i++) {
        if (faults[i].camera == 1) {
            is_found = faults[i].is_seen;
            ASSERT_NEAR(-slope / bend, faults[i].value[0], 0.1 * D(faults[i].sigma[0]));
            ASSERT_NEAR(slope * slope / (2 * bend), faults[i].gain,
                        0.2 * D(fit.sigma_px) * D(fit.sigma_px));
        }
    }
    TEST_ASSERT_TRUE(is_found);
}

static void test_a_fault_is_what_an_adjustment_with_it_finds(void)
{
    finds_what_an_adjustment_finds(0);
    finds_what_an_adjustment_finds(1);
}

static void test_a_prior_that_is_no_covariance_is_refused(void)
{
    rigcal_faults_options options = {0};
    rigcal_faults found;
    rigcal_rig_fit fit;
    test_rng rng = test_seed(5);

    TEST_WANTS_RAM(sizeof r + sizeof room + sizeof faults + 12000);
    make(&rng);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    options.work = room;
    options.work_capacity = sizeof room / sizeof *room;
    r.priors[2].Sigma[0] = 0;
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE,
                  rigcal_rig_faults(&found, faults, FAULTS, NULL, &options, &r.rig));
    r.rig.priors = NULL;
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_rig_faults(&found, faults, FAULTS, NULL, &options, &r.rig));
}

TEST_MAIN()
{
    RUN_TEST(test_a_fault_is_what_an_adjustment_with_it_finds);
    RUN_TEST(test_a_prior_that_is_no_covariance_is_refused);
}
