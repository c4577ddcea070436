/* The covariance of a monitor became NaN: its factor was made by dividing the rounding of
 * covariances by the rounding of a variance, which multiplied the other variances by 1e15,
 * frame after frame. So did a view that hardly fixes its target: the target got a place. A
 * unit of length so small that its square is 0 made NaN of the direction known worst. */
#include <math.h>
#include <string.h>

#include "rc_filter.h"
#include "test_watched.h"

static test_watched w;

static void assert_finite(size_t camera)
{
    rigcal_mounted_camera now;
    rigcal_body_report report;

    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&now, w.monitor, camera));
    for (int i = 0; i < 36; i++) {
        TEST_ASSERT_TRUE(isfinite(D(now.Sigma[i])));
        TEST_ASSERT_TRUE(i % 7 != 0 || now.Sigma[i] >= 0);
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_body(&report, w.monitor, camera));
    TEST_ASSERT_TRUE(isfinite(D(report.weakest[0])) && isfinite(D(report.weakest_sigma)));
}

/* P = U D U^T with unknowns that determine each other to 1e-20, which is below rounding.
 * Factored and multiplied again it may differ by rounding times a condition, but its
 * variances may not grow by more than their number. */
static void test_factors_of_rounding(void)
{
    enum { N = 12 };
    rigcal_real P[N * (N + 1) / 2], before[N * (N + 1) / 2];
    test_rng rng = test_seed(41);

    for (int trial = 0; trial < TEST_TRIALS(500); trial++) {
        const double size = pow(10, test_uniform(&rng, 0, 4));
        const double least = test_uniform(&rng, -20, 0);

        for (size_t i = 0, k = 0; i < N; i++) {
            for (size_t j = 0; j <= i; j++, k++) {
                P[k] = RC(i == j ? pow(10, least * test_uniform(&rng, 0, 1))
                                 : size * test_uniform(&rng, -1, 1));
            }
        }
        rc_filter_multiply(P, N);
        memcpy(before, P, sizeof P);
        rc_filter_factor(P, N);
        rc_filter_multiply(P, N);
        for (size_t i = 0; i < N; i++) {
            const size_t at = i * (i + 1) / 2 + i;

            TEST_ASSERT_TRUE(P[at] >= 0 && P[at] <= N * before[at]);
        }
    }
}

/* Three points so far away that their pixels are nearly one. */
static void test_a_target_that_is_hardly_fixed(void)
{
    test_rng rng = test_seed(42);
    int n_vague = 0;

    test_watched_make(&w, &rng, 2, 1, 1e-4, 1e-4);
    test_watched_begin(&w, 1, NULL);
    for (int k = 0; k < 40; k++) {
        rigcal_observation seen[3];

        for (int i = 0; i < 3; i++) {
            const double X[3] = {i == 1, i == 2, 0};

            test_to_real(seen[i].X_w, X, 3);
            seen[i].uv[0] = RC(300 + 8 * (i == 1) * pow(0.5, k));
            seen[i].uv[1] = RC(200 + 8 * (i == 2) * pow(0.5, k));
        }
        n_vague +=
            rigcal_monitor_view(w.monitor, NULL, 0, 0, seen, 3, RC(0.3)) == RIGCAL_VAGUE;
        ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_moved(w.monitor, 2)); /* no place */
        assert_finite(1);
    }
    TEST_ASSERT_TRUE(n_vague > 0);
}

static void test_a_unit_of_length_without_a_square(void)
{
    test_rng rng = test_seed(43);
    rigcal_monitor_options options;

    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_defaults(&options));
    options.move_t = RC(TOL(1e-200, 1e-30));
    test_watched_make(&w, &rng, 2, 1, 1e-4, 1e-4);
    test_watched_begin(&w, 0, &options);
    assert_finite(1);
}

TEST_MAIN()
{
    RUN_TEST(test_factors_of_rounding);
    RUN_TEST(test_a_target_that_is_hardly_fixed);
    RUN_TEST(test_a_unit_of_length_without_a_square);
}
