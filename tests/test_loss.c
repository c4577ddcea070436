/* loss: the adjustment of a rig with some wrong points. The truth: the adjustment of the
 * right points alone, and the formulas of the losses. */
#include <math.h>
#include <string.h>

#include "rigcal_solvers.h"
#include "test_rigs.h"

#define NOISE 0.3

static test_rig r;
static uint8_t is_wrong[RIG_VIEWS_MAX][RIG_POINTS_MAX];

#define WANTS_RIG TEST_WANTS_RAM(sizeof r + sizeof is_wrong + 14000)

/* A rig with noise. A share of its points is off by up to 60 px. */
static void make(test_rng *rng, double share)
{
    test_rig_random(&r, rng, 3, 6, 10);
    test_rig_see_all(&r, rng, NOISE);
    r.rig.sigma_px = RC(NOISE);
    memset(is_wrong, 0, sizeof is_wrong);
    for (size_t v = 0; v < r.rig.n_views; v++) {
        for (int i = 0; i < 10; i++) {
            if (test_uniform(rng, 0, 1) < share) {
                const double angle = test_uniform(rng, -3.1, 3.1);
                const double far = test_uniform(rng, 4, 60);

                r.o[v][i].uv[0] += RC(far * cos(angle));
                r.o[v][i].uv[1] += RC(far * sin(angle));
                is_wrong[v][i] = 1;
            }
        }
    }
}

/* Removes the wrong points. */
static void keep_right(void)
{
    for (size_t v = 0; v < r.rig.n_views; v++) {
        size_t n = 0;

        for (size_t i = 0; i < 10; i++) {
            if (!is_wrong[v][i]) {
                r.o[v][n++] = r.o[v][i];
            }
        }
        r.views[v].view.n = n;
    }
}

static size_t count_wrong(void)
{
    size_t n = 0;

    for (size_t v = 0; v < r.rig.n_views; v++) {
        for (int i = 0; i < 10; i++) {
            n += is_wrong[v][i];
        }
    }
    return n;
}

/* The squared error of the cameras, of turns and shifts. */
static double off_truth(void)
{
    double sum = 0;

    for (size_t c = 1; c < r.rig.n_cameras; c++) {
        double d[6];

        test_step_between(d, &r.cams[c], &r.true_cams[c]);
        for (int k = 0; k < 6; k++) {
            sum += d[k] * d[k];
        }
    }
    return sum;
}

static void test_wrong_points_do_no_harm(void)
{
    test_rng rng = test_seed(381);
    double robust = 0, right = 0;
    size_t found = 0, there = 0;

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        rigcal_rig_fit fit;
        size_t n_wrong;

        make(&rng, 0.05);
        test_rig_start(&r, &rng, 0.01, 0.02);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust_robust(&fit, &n_wrong, NULL, &r.rig));
        TEST_ASSERT_EQUAL_UINT64(180, fit.n_points + n_wrong);
        ASSERT_NEAR(2 * D(fit.n_points) - 6 * (2 + 6), fit.freedom, 0);
        ASSERT_NEAR(NOISE, fit.sigma_px, 0.1);
        robust += off_truth();
        found += n_wrong;
        there += count_wrong();
        keep_right();
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
        right += off_truth();
    }
    TEST_ASSERT_TRUE(sqrt(robust / right) < 1.03 || TEST_ONE_IN > 1);
    /* Of 17000 right points six are beyond 4 sigma: a share of exp(-8). */
    TEST_ASSERT_TRUE(found + 5 >= there && found <= there + 25);
}

/* The distances of all points of view v, in pixels. Returns their number. */
static size_t errors_of(double errors[RIG_POINTS_MAX], size_t v)
{
    rigcal_real duv[2 * RIG_POINTS_MAX];
    size_t n;

    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_residuals(duv, 2 * RIG_POINTS_MAX, &n, &r.rig, v));
    for (size_t i = 0; i < n; i++) {
        errors[i] = hypot(D(duv[2 * i]), D(duv[2 * i + 1]));
    }
    return n;
}

/* The fit is that of the points within 4 sigma, and there is no test of the rig. */
static void test_the_fit_is_that_of_the_points_that_count(void)
{
    test_rng rng = test_seed(388);
    rigcal_rig_fit fit;
    size_t n_wrong, beyond = 0;
    double sum = 0;

    WANTS_RIG;
    make(&rng, 0.05);
    test_rig_solve_views(&r); /* with their own poses there could be a test */
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust_robust(&fit, &n_wrong, NULL, &r.rig));
    for (size_t v = 0; v < r.rig.n_views; v++) {
        double errors[RIG_POINTS_MAX];
        const size_t n = errors_of(errors, v);

        for (size_t i = 0; i < n; i++) {
            const double e = errors[i];

            sum += e <= 4 * NOISE ? e * e : 0;
            beyond += !(e <= 4 * NOISE);
        }
    }
    TEST_ASSERT_TRUE(beyond > 0);
    TEST_ASSERT_EQUAL_size_t(beyond, n_wrong);
    ASSERT_NEAR(sum, fit.sum, TOL(1e-6, 1e-3) * sum);
    ASSERT_NEAR(sqrt(sum / D(fit.freedom)), fit.sigma_px, TOL(1e-6, 1e-3));
    ASSERT_NEAR(0, fit.F, 0);
    ASSERT_NEAR(0, fit.freedom_between, 0);
    ASSERT_NEAR(0, fit.freedom_within, 0);
}

static void test_without_wrong_points_it_is_least_squares(void)
{
    test_rng rng = test_seed(382);
    double robust = 0, squares = 0;

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(60); trial++) {
        rigcal_rig_fit fit;
        size_t n_wrong;

        make(&rng, 0);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
        squares += off_truth();
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust_robust(&fit, &n_wrong, NULL, &r.rig));
        robust += off_truth();
    }
    TEST_ASSERT_TRUE(fabs(sqrt(robust / squares) - 1) < 0.01 || TEST_ONE_IN > 1);
}

/* The losses of all points: Huber's, and squares that end at 4 sigma. */
static void sums_of_losses(double sum[2])
{
    sum[0] = sum[1] = 0;
    for (size_t v = 0; v < r.rig.n_views; v++) {
        double errors[RIG_POINTS_MAX];
        const size_t n = errors_of(errors, v);

        for (size_t i = 0; i < n; i++) {
            const double e = errors[i];

            sum[0] += e < 2 * NOISE ? e * e : 2 * NOISE * (2 * e - 2 * NOISE);
            sum[1] += e < 4 * NOISE ? e * e : 16 * NOISE * NOISE;
        }
    }
}

/* After one evaluation the sum of a search must be that of the losses. */
static void test_the_sum_is_that_of_the_loss(void)
{
    static const int32_t LOSSES[2] = {RIGCAL_LOSS_HUBER, RIGCAL_LOSS_TRUNCATED};
    test_rng rng = test_seed(383);
    double sum[2];

    WANTS_RIG;
    make(&rng, 0.2);
    sums_of_losses(sum);
    for (int k = 0; k < 2; k++) {
        rigcal_rig_solver solver;

        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_robust_begin(&solver, &r.rig, LOSSES[k]));
        while (solver.search.want == 0) { /* the equations of the first pass */
            (void)rigcal_rig_step(&solver, 1);
        }
        ASSERT_NEAR(sum[k], solver.search.sum, TOL(1e-10, 1e-4) * sum[k]);
    }
}

/* If a camera is moved either way from where Huber's loss put it, the sum grows: the least
 * value of the parabola through the three sums is within 0.03 deviations of that place. In
 * float, rounding of a sum of 7000 sigma^2 hides gains of 0.01 sigma^2, by steps of 0.1. */
static void test_the_answer_is_the_least_of_the_loss(void)
{
    test_rng rng = test_seed(386);
    rigcal_rig_solver solver;
    const double step = TOL(1e-5, 1e-3);

    WANTS_RIG;
    make(&rng, 0.2);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_robust_begin(&solver, &r.rig, RIGCAL_LOSS_HUBER));
    while (rigcal_rig_step(&solver, 1000) == RIGCAL_RUNNING) {
    }
    for (int k = 0; k < 6; k++) {
        rigcal_real *const t = &r.cams[1 + k / 3].t[k % 3];
        const rigcal_real found = *t;
        double sum[3][2];

        for (int i = 0; i < 3; i++) {
            *t = (rigcal_real)(D(found) + (i - 1) * step);
            sums_of_losses(sum[i]);
        }
        *t = found;
        const double slope = (sum[2][0] - sum[0][0]) / 2,
                     bend = sum[2][0] + sum[0][0] - 2 * sum[1][0];
        TEST_ASSERT_TRUE(bend > 0);
        ASSERT_NEAR(0, slope / sqrt(bend) / NOISE, TOL(0.03, 0.15));
    }
}

static void test_the_budget_changes_no_bit(void)
{
    static const int32_t BUDGETS[] = {1, 7, 1000};
    test_rng rng = test_seed(384);
    rigcal_transform cams[3][RIG_CAMERAS_MAX];

    WANTS_RIG;
    for (int k = 0; k < 3; k++) {
        rigcal_rig_solver solver;
        rigcal_rig_fit fit;
        size_t n_wrong;

        rng = test_seed(384);
        make(&rng, 0.05);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_rig_robust_begin(&solver, &r.rig, RIGCAL_LOSS_TRUNCATED));
        ASSERT_STATUS(RIGCAL_ERR_STATE,
                      rigcal_rig_robust_result(&fit, &n_wrong, NULL, &solver));
        while (rigcal_rig_step(&solver, BUDGETS[k]) == RIGCAL_RUNNING) {
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_robust_result(&fit, &n_wrong, NULL, &solver));
        memcpy(cams[k], r.cams, sizeof cams[k]);
        TEST_ASSERT_EQUAL_MEMORY(cams[0], cams[k], 3 * sizeof cams[0][0]);
    }
}

/* The sum of what was kept may be below 1 px^2. */
static void test_small_noise_is_found_beside_wrong_points(void)
{
    test_rng rng = test_seed(387);
    const double noise = TOL(1e-3, 1e-2);
    rigcal_rig_fit fit;
    size_t n_wrong;

    WANTS_RIG;
    make(&rng, 0);
    test_rig_see_all(&r, &rng, noise);
    r.rig.sigma_px = RC(noise);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    for (size_t v = 0; v < r.rig.n_views; v += 3) {
        r.o[v][v % 10].uv[0] += 20;
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust_robust(&fit, &n_wrong, NULL, &r.rig));
    TEST_ASSERT_EQUAL_size_t(6, n_wrong);
    TEST_ASSERT_TRUE(fit.sum < 1);
    ASSERT_NEAR(noise, fit.sigma_px, 0.15 * noise);
    ASSERT_NEAR(D(fit.sigma_px) * D(fit.sigma_px) * D(fit.freedom), fit.sum,
                TOL(1e-9, 1e-4) * D(fit.sum));
}

/* Three points of one view leave no degree of freedom, so no noise is found. */
static void test_without_freedom_no_noise_is_found(void)
{
    test_rng rng = test_seed(386);
    rigcal_rig_fit fit;
    size_t n_wrong = 9;

    WANTS_RIG;
    test_rig_random(&r, &rng, 1, 1, 8);
    test_rig_see_all(&r, &rng, NOISE);
    r.rig.sigma_px = RC(NOISE);
    r.views[0].view.n = 3;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust_robust(&fit, &n_wrong, NULL, &r.rig));
    TEST_ASSERT_EQUAL_size_t(0, n_wrong);
    ASSERT_NEAR(0, fit.freedom, 0);
    ASSERT_NEAR(0, fit.sigma_px, 0);
}

static void test_a_loss_wants_the_noise(void)
{
    test_rng rng = test_seed(385);
    rigcal_rig_solver solver;

    WANTS_RIG;
    make(&rng, 0);
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_rig_robust_begin(&solver, &r.rig, 0));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_rig_robust_begin(&solver, &r.rig, 3));
    r.rig.sigma_px = 0;
    ASSERT_STATUS(RIGCAL_ERR_RANGE,
                  rigcal_rig_robust_begin(&solver, &r.rig, RIGCAL_LOSS_HUBER));
}

/* Huber's loss needs all points. If one cannot be seen, the second loss is not begun. */
static void test_a_placement_behind_the_cameras_is_refused(void)
{
    test_rng rng = test_seed(388);
    rigcal_rig_fit fit;
    size_t n_wrong;
    int32_t at_fault = -2;

    WANTS_RIG;
    make(&rng, 0);
    const int32_t v = (int32_t)r.rig.n_views - 1, f = r.views[v].placement;
    const rigcal_transform cam = r.cams[r.views[v].camera], back = test_inverse(&cam);
    rigcal_transform T = test_times(&cam, &r.places[f]);

    T.t[2] = -T.t[2];
    r.places[f] = test_times(&back, &T);
    ASSERT_STATUS(RIGCAL_ERR_BEHIND,
                  rigcal_rig_adjust_robust(&fit, &n_wrong, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_INT32(f, r.views[at_fault].placement);
}

static void test_without_room_for_the_answer_nothing_moves(void)
{
    static rigcal_transform before[RIG_CAMERAS_MAX];
    test_rng rng = test_seed(387);
    rigcal_rig_fit fit;
    static rigcal_rig_solver solver;
    int32_t at_fault = -2;
    size_t n_wrong;

    WANTS_RIG;
    make(&rng, 0.05);
    memcpy(before, r.cams, sizeof before);
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_rig_adjust_robust(NULL, &n_wrong, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault); /* no view */
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rig_adjust_robust(&fit, NULL, NULL, &r.rig));
    at_fault = -2;
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_rig_robust_result(NULL, &n_wrong, &at_fault, &solver));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
    TEST_ASSERT_EQUAL_MEMORY(before, r.cams, sizeof before);
}

TEST_MAIN()
{
    RUN_TEST(test_wrong_points_do_no_harm);
    RUN_TEST(test_the_fit_is_that_of_the_points_that_count);
    RUN_TEST(test_without_wrong_points_it_is_least_squares);
    RUN_TEST(test_the_sum_is_that_of_the_loss);
    RUN_TEST(test_the_answer_is_the_least_of_the_loss);
    RUN_TEST(test_the_budget_changes_no_bit);
    RUN_TEST(test_small_noise_is_found_beside_wrong_points);
    RUN_TEST(test_without_freedom_no_noise_is_found);
    RUN_TEST(test_a_loss_wants_the_noise);
    RUN_TEST(test_a_placement_behind_the_cameras_is_refused);
    RUN_TEST(test_without_room_for_the_answer_nothing_moves);
}
