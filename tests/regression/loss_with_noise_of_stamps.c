/* An adjustment by a loss, of a rig whose stamps have noise: the noise of the stamps was
 * taken off twice. Where no point is wrong, the truncated loss is the sum of squares, so
 * its answer is that of rigcal_rig_adjust. */
#include "rigcal_solvers.h"
#include "test_motions.h"
#include "test_rigs.h"

static test_motions m;

static const motion_scene SCENE = {3, 3, 3, 30, 0.35, 0.8, 10, 0.01, 0, 0.001, 0.3};

static void make(void)
{
    test_rng rng = test_seed(712);

    test_motions_make(&m, &rng, &SCENE);
    test_motions_solve(&m);
    m.clocks.sigma_time = RC(0.001);
    m.rig.clocks = &m.clocks;
    m.rig.sigma_px = 1; /* no error reaches 4 of these */
}

static void test_without_wrong_points_it_is_least_squares(void)
{
    static rigcal_rig_solver solver;
    rigcal_transform cams[MOTION_CAMERAS_MAX];
    rigcal_real offsets[MOTION_CAMERAS_MAX];
    rigcal_rig_fit fit, by_loss;
    size_t n_wrong = 99;
    const double tol = TOL(1e-9, 1e-4);

    TEST_WANTS_RAM(sizeof(test_motions) + 60000);
    make();
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &m.rig));
    for (size_t c = 0; c < m.rig.n_cameras; c++) {
        cams[c] = m.cams[c];
        offsets[c] = m.offsets[c];
    }
    test_motions_reset(&m);
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_rig_robust_begin(&solver, &m.rig, RIGCAL_LOSS_TRUNCATED));
    while (rigcal_rig_step(&solver, 100) == RIGCAL_RUNNING) {
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_robust_result(&by_loss, &n_wrong, NULL, &solver));
    TEST_ASSERT_EQUAL_UINT64(0, n_wrong);
    ASSERT_NEAR(1, by_loss.sum / fit.sum, tol);
    ASSERT_NEAR(fit.freedom, by_loss.freedom, 0);
    for (size_t c = 0; c < m.rig.n_cameras; c++) {
        double d[6];

        test_step_between(d, &cams[c], &m.cams[c]);
        for (int k = 0; k < 6; k++) {
            ASSERT_NEAR(0, d[k], tol);
        }
        ASSERT_NEAR(offsets[c], m.offsets[c], tol);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_without_wrong_points_it_is_least_squares);
}
