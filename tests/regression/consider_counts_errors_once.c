/* Errors of intrinsics were counted twice where they were considered. They raise the
 * residuals, so the noise and F of the fit contained a part of them, and both scaled
 * covariances that contain all of them. The truth is the noise that the pixels were given,
 * whatever the intrinsics are, and F = 1. Intrinsics are drawn with the deviations that
 * are stated. */
#include <math.h>
#include <string.h>

#include "test_boards.h"

enum { CAMERAS = 4, PLACES = 8, RIGS = 60, WORK = RIGCAL_CONSIDER_WORK(CAMERAS, CAMERAS) };

static const rigcal_intrinsics_sigma STATED = {RC(0.003), RC(0.001), RC(3), RC(0.01),
                                               RC(0.03)};

static test_boards b;
static rigcal_camera lens[CAMERAS];
static rigcal_intrinsics_sigma sigmas[CAMERAS];
static rigcal_real effects[WORK];

static void calibrate(test_rng *rng, double noise_px, rigcal_rig_fit *fit,
                      rigcal_rig_fit *left)
{
    rigcal_considered considered = {.effects = effects, .capacity = WORK};

    test_boards_make(&b, rng, CAMERAS, PLACES, CAMERAS, noise_px, 0);
    for (int c = 0; c < CAMERAS; c++) {
        lens[c] = test_boards_lens(&b, rng, &STATED);
        sigmas[c] = STATED;
    }
    for (size_t v = 0; v < b.rig.n_views; v++) {
        b.views[v].view.camera = &lens[b.views[v].camera];
    }
    test_boards_solve(&b);
    b.rig.intrinsics_sigmas = sigmas;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(fit, NULL, &b.rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &b.rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_considered_fit(left, fit, &b.rig));
}

/* The means are off by at most four of their own deviations. */
static void check(double noise_px, double off_noise, double off_F)
{
    double noise = 0, noise_left = 0, F = 0, F_left = 0;

    for (int rig = 0; rig < RIGS; rig++) {
        test_rng rng = test_seed(9100 + (uint64_t)rig);
        rigcal_rig_fit fit, left;

        calibrate(&rng, noise_px, &fit, &left);
        noise += pow(D(fit.sigma_px) / noise_px, 2) / RIGS;
        noise_left += pow(D(left.sigma_px) / noise_px, 2) / RIGS;
        F += D(fit.F) / RIGS;
        F_left += D(left.F) / RIGS;
    }
    ASSERT_NEAR(1, RC(noise_left), off_noise);
    ASSERT_NEAR(1, RC(F_left), off_F);
    TEST_ASSERT_TRUE(noise > 1 + off_noise && F > 1 + off_F);
}

static void test_the_fit_is_that_of_exact_intrinsics(void)
{
    TEST_ON_HOST_ONLY("120 rigs of 32 views are adjusted");
    check(0.1, 0.08, 0.45);
    check(0.3, 0.022, 0.09);
}

TEST_MAIN()
{
    RUN_TEST(test_the_fit_is_that_of_exact_intrinsics);
}
