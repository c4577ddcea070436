/* chance: quantiles compared with SciPy's; odds with an integral over the noise; expected
 * sets with binomial coefficients, and with random draws that are counted. */
#include <math.h>

#include "rc_chance.h"
#include "rc_logs.h"
#include "test_support.h"
#include "vectors_chance.h"

/* ---- degrees of freedom ---------------------------------------------------- */

static void test_a_pose_takes_six_degrees_of_freedom_and_leaves_one_at_least(void)
{
    ASSERT_NEAR(1, rc_freedom(3), 0);
    ASSERT_NEAR(2, rc_freedom(4), 0);
    ASSERT_NEAR(4, rc_freedom(5), 0);
    ASSERT_NEAR(194, rc_freedom(100), 0);
    ASSERT_NEAR(2e6 - 6, rc_freedom(1000000), 0);
}

/* ---- chi squared ----------------------------------------------------------- */

/* The relative error of the approximation falls as 1 / freedom. */
static void test_the_limit_is_the_quantile_of_chi_squared(void)
{
    for (int k = 0; k < CHANCE_CHI2_ROWS; k++) {
        const double freedom = CHANCE_CHI2[k][0], deviations = CHANCE_CHI2[k][1];
        const double exact = CHANCE_CHI2[k][2];
        const double part = (deviations > 4 ? 0.25 : 0.07) / freedom + TOL(1e-12, 1e-5);
        ASSERT_NEAR(exact, rc_chi2_limit(RC(freedom), RC(deviations)), part * exact);
    }
}

/* Sums of squares of random normal numbers, by Box and Muller. */
static double chi_squared(int freedom, test_rng *rng)
{
    double sum = 0;
    for (int i = 0; i < freedom; i++) {
        const double r2 = -2 * log(1 - test_uniform(rng, 0, 1));
        const double c = cos(2 * TEST_PI * test_uniform(rng, 0, 1));
        sum += r2 * c * c;
    }
    return sum;
}

/* A normal variable exceeds 2 standard deviations with a chance of 0.02275. */
static void test_a_limit_of_two_deviations_is_exceeded_in_2_3_percent_of_draws(void)
{
    enum { DRAWS = 40000 };
    const double p = 0.02275, share = 5 * sqrt(DRAWS * p * (1 - p));
    test_rng rng = test_seed(31);
    TEST_ON_HOST_ONLY("a share of few draws says nothing");
    for (int n = 5; n <= 20; n += 5) {
        const rigcal_real freedom = rc_freedom((size_t)n);
        const double limit = D(rc_chi2_limit(freedom, 2));
        int beyond = 0;
        for (int i = 0; i < DRAWS; i++) {
            beyond += chi_squared((int)freedom, &rng) > limit;
        }
        ASSERT_NEAR(DRAWS * p, beyond, share);
    }
}

/* ---- odds ------------------------------------------------------------------ */

/* A series of 8 terms for a 256th part p of the exponent has an error of about p^9 / 9!. In
 * float the sums are rounded too, by 1e-5 of an exponent. */
static void test_odds_with_known_noise_are_the_ratio_of_normal_likelihoods(void)
{
    test_rng rng = test_seed(32);
    for (int trial = 0; trial < 1000; trial++) {
        const double sigma = pow(10, test_uniform(&rng, -1, 1)), s2 = sigma * sigma;
        const rigcal_real sse = RC(s2 * test_uniform(&rng, 0, 150));
        const rigcal_real other = RC(s2 * test_uniform(&rng, 0, 150));
        const double s = D(RC(sigma)), exponent = (D(other) - D(sse)) / (2 * s * s);
        const double left = 256 * pow(fabs(exponent) / 256, 9) / 362880;
        ASSERT_NEAR(exp(exponent), rc_odds(sse, other, RC(sigma), 1, 10),
                    exp(exponent) * (2 * left + TOL(1e-12, 1e-4)));
    }
}

static void test_odds_beyond_the_range_of_float_are_clipped(void)
{
    TEST_ASSERT_TRUE(D(rc_odds(0, 1000, 1, 1, 10)) > 1e34);
    TEST_ASSERT_TRUE(D(rc_odds(0, 1000, 1, 1, 10)) < 1e38);
    TEST_ASSERT_TRUE(D(rc_odds(1000, 0, 1, 1, 10)) < 1e-34);
}

/* ln of the integral over the noise s, with the prior 1 / s, of the likelihood of 2 n
 * coordinates: s^-2n exp(-sum / (2 s^2)), times s^6 for the volume of the pose. */
static double log_evidence(double sum, int n)
{
    const double middle = log(sqrt(sum / (2 * n - 6))), step = 1e-2;
    double highest, total = 0;
    highest = -(2 * n - 6) * middle - sum / 2 * exp(-2 * middle);
    for (int i = -800; i <= 800; i++) {
        const double u = middle + i * step;
        total += step * exp(-(2 * n - 6) * u - sum / 2 * exp(-2 * u) - highest);
    }
    return log(total) + highest;
}

static void test_odds_with_unknown_noise_are_integrated_over_it(void)
{
    for (int n = 4; n <= 12; n += 4) {
        for (double ratio = 0.5; ratio < 10; ratio *= 3) {
            const double sse = 50, other = ratio * sse;
            const double exact = exp(log_evidence(sse, n) - log_evidence(other, n));
            /* The least noise adds 1e-4 (2 n - 6) to each sum, which is below 4e-5 of
             * it. */
            ASSERT_NEAR(exact, rc_odds(RC(sse), RC(other), 0, 1, (size_t)n),
                        exact * (n - 3) * 1e-4);
        }
    }
}

/* The noise is taken as 0.01 pixels at least, so sums far below that show nothing. */
static void test_sums_below_the_least_noise_are_no_evidence(void)
{
    const rigcal_real tiny = RC(1e-12);
    ASSERT_NEAR(1, rc_odds(0, 0, 0, 1, 10), 0);
    ASSERT_NEAR(1, rc_odds(0, tiny, 0, 1, 10), 1e-6);
    ASSERT_NEAR(1, rc_odds(tiny, 0, 0, 1, 10), 1e-6);
    /* 14 degrees of freedom: the least noise gives 14e-4 to the sum 0, and twice that to
     * this sum */
    ASSERT_NEAR(128, rc_odds(0, RC(14e-4), 0, 1, 10), 128 * TOL(1e-12, 1e-5));
    /* with pixels a hundredth as large: a ten-thousandth */
    ASSERT_NEAR(128, rc_odds(0, RC(14e-8), 0, RC(0.01), 10), 128 * TOL(1e-12, 1e-5));
}

static void test_three_points_are_no_evidence_where_the_noise_is_unknown(void)
{
    ASSERT_NEAR(1, rc_odds(RC(0.1), 1000, 0, 1, 3), 0);
}

static void test_odds_are_never_nan(void)
{
    static const double SUM[4] = {0, 1e-30, 1, 1e30};
    for (int i = 0; i < 16; i++) {
        for (size_t n = 3; n <= 100000; n = 3 * n + 1) {
            for (int k = 0; k < 2; k++) {
                const rigcal_real odds =
                    rc_odds(RC(SUM[i / 4]), RC(SUM[i % 4]), RC(k), 1, n);
                TEST_ASSERT_TRUE(odds >= 0);
            }
        }
    }
    TEST_ASSERT_FALSE(rc_odds(0, RC(1e30), 0, 1, 1000) < TEST_INF);
    ASSERT_NEAR(0, rc_odds(RC(1e30), 0, 0, 1, 1000), 0);
}

/* ---- sets that agree ------------------------------------------------------- */

static double binomial(int n, int k)
{
    double ways = 1;
    for (int i = 1; i <= k; i++) {
        ways = ways * (n - k + i) / i;
    }
    return ways;
}

static void test_expected_sets_are_binomial(void)
{
    static const double NEAR[3] = {0.001, 0.03, 0.5};
    for (int n = 5; n <= 60; n += 11) {
        for (int count = 3; count <= n; count++) {
            for (int k = 0; k < 3; k++) {
                const double near = D(RC(NEAR[k]));
                const double exact =
                    2 * binomial(n, 3) * binomial(n - 3, count - 3) * pow(near, count - 3);
                if (exact < 1e25 && exact > 1e-30) {
                    ASSERT_NEAR(exact, rc_expected_sets((size_t)n, (size_t)count, RC(near)),
                                exact * TOL(1e-13, 1e-5));
                }
            }
        }
    }
}

/* One pose for each triple gives half of what is expected with two. Each other point agrees
 * by its own random draw. */
static void test_expected_sets_are_the_mean_of_draws(void)
{
    enum { N = 7, COUNT = 5, DRAWS = 4000 };
    const double near = 0.2;
    test_rng rng = test_seed(33);
    double sum = 0, squares = 0, mean;
    TEST_ON_HOST_ONLY("a mean of few draws says nothing");
    for (int draw = 0; draw < DRAWS; draw++) {
        double sets = 0;
        for (int triple = 0; triple < N * (N - 1) * (N - 2) / 6; triple++) {
            int agree = 0;
            for (int i = 3; i < N; i++) {
                agree += test_uniform(&rng, 0, 1) < near;
            }
            sets += binomial(agree, COUNT - 3);
        }
        sum += sets;
        squares += sets * sets;
    }
    mean = sum / DRAWS;
    ASSERT_NEAR(D(rc_expected_sets(N, COUNT, RC(near))) / 2, mean,
                5 * sqrt((squares / DRAWS - mean * mean) / DRAWS));
}

static void test_expected_sets_are_clipped_and_not_infinite(void)
{
    ASSERT_NEAR(1e30, rc_expected_sets(1000, 500, 1), 1e24);
    ASSERT_NEAR(0, rc_expected_sets(1000, 500, 0), 0);
    ASSERT_NEAR(1000.0 * 999 * 998 / 3, rc_expected_sets(1000, 3, 0), TOL(0, 40));
}

/* For very many points the number rises far above the clip before it falls. */
static void test_expected_sets_are_not_clipped_on_the_way(void)
{
    enum { MANY = 10000, COUNT = 290 };
    double log_expected = log(2) + log(MANY) + log(MANY - 1) + log(MANY - 2) - log(6);
    for (int i = 1; i <= COUNT - 3; i++) {
        log_expected += log(MANY - 3 - i + 1) - log(i) + log(0.01);
    }
    TEST_ASSERT_TRUE(log_expected < log(1e20) && log_expected > log(1e-20));
    ASSERT_NEAR(1, RC(D(rc_expected_sets(MANY, COUNT, RC(0.01))) / exp(log_expected)),
                TOL(1e-9, 1e-3));
}

/* ---- the F distribution ----------------------------------------------------- */

/* F, its degrees of freedom, and the tail by scipy.stats.f.sf. */
static void test_the_tail_of_F_is_that_of_scipy(void)
{
    static const double TAILS[9][4] = {
        {0.5, 1, 20, 0.487658095051},     {3.9, 1, 3800, 0.0483583843531},
        {30, 1, 3800, 4.60040051933e-08}, {2, 2, 150, 0.138928186422},
        {5, 6, 3800, 4.11044870604e-05},  {1.1, 200, 4000, 0.164970063924},
        {1.5, 63, 800, 0.00883795158976}, {0.9, 18, 40, 0.582106834561},
        {8, 7, 3, 0.0576655485597}};

    for (int i = 0; i < 9; i++) {
        const double *const x = TAILS[i];

        ASSERT_NEAR(x[3], rc_f_tail(RC(x[0]), RC(x[1]), RC(x[2])), TOL(1e-8, 2e-3) * x[3]);
    }
    ASSERT_NEAR(1, rc_f_tail(0, 3, 100), 0);
    ASSERT_NEAR(0, rc_f_tail(RC(1e6), 3, 4000), 1e-34);
    ASSERT_NEAR(1, rc_f_tail(RC(TOL(1e-310, 1e-40)), 3, 4000), 0); /* 1 / F overflows */
}

/* It is half, by symmetry. In double the steps of the fraction are enough for 1e-5. In
 * float, and in double with more degrees than any data have, rounding leaves only some
 * number between 0 and 1. */
static void test_of_very_many_degrees_of_freedom_the_tail_is_a_chance(void)
{
    if (!RIGCAL_USE_FLOAT) {
        ASSERT_NEAR(0.5, rc_f_tail(1, RC(1e8), RC(1e8)), 1e-5);
    }
    for (int i = 0; i < 6; i++) {
        const double n = 1e7 * pow(10, 0.5 * i);
        const rigcal_real tail = rc_f_tail(1, RC(n), RC(n));

        TEST_ASSERT_TRUE(tail >= 0 && tail <= 1);
    }
    for (int i = 0; i < TEST_TRIALS(13 * 13 * 9); i++) {
        const double k = TOL(1e16, 1e7) * pow(10, 0.25 * (i % 13));
        const double n = TOL(1e16, 1e7) * pow(10, 0.25 * (i / 13 % 13));
        const rigcal_real F = 1 + (rigcal_real)(i / 169) * RC_EPS;
        const rigcal_real tail = rc_f_tail(F, RC(k), RC(n));

        TEST_ASSERT_TRUE(tail >= 0 && tail <= 1);
    }
}

static void test_the_logarithm_is_that_of_the_C_library(void)
{
    for (int i = -4; i < 20; i++) {
        const double x = i < 0 ? -1 + pow(10, i) : pow(3, i) - 1;

        ASSERT_NEAR(log1p(D(RC(x))), rc_log1p(RC(x)),
                    TOL(1e-14, 1e-5) * (1 + fabs(log1p(D(RC(x))))));
    }
    ASSERT_NEAR(1e-9, rc_log1p(RC(1e-9)), 1e-15);
    ASSERT_NEAR(log(D(RC_MAX)), rc_log1p(RC_MAX), TOL(1e-11, 1e-4));
    ASSERT_NEAR(log(D(RC_EPS) / 2), rc_log1p(RC_EPS / 2 - 1), TOL(1e-12, 1e-5));
}

/* By logarithms, for every count of 100 points: from small numbers to those that are
 * clipped at 1e30. */
static void test_expected_sets_of_every_size(void)
{
    int n_large = 0;

    for (int step = 0; step < 4; step++) {
        const double near = pow(0.25, step);
        double log_sets = log(100.0 * 99 * 98 / 3);

        for (int count = 4; count <= 100; count++) {
            log_sets += log(near * (101 - count) / (count - 3));
            const double exact = fmin(exp(log_sets), 1e30);
            ASSERT_NEAR(exact, rc_expected_sets(100, (size_t)count, RC(near)),
                        TOL(1e-10, 1e-4) * exact + 1e-30);
            n_large += exact > 2e27 && exact < 5e29;
        }
    }
    TEST_ASSERT_TRUE(n_large > 2); /* next to the limit */
}

TEST_MAIN()
{
    RUN_TEST(test_a_pose_takes_six_degrees_of_freedom_and_leaves_one_at_least);
    RUN_TEST(test_the_limit_is_the_quantile_of_chi_squared);
    RUN_TEST(test_a_limit_of_two_deviations_is_exceeded_in_2_3_percent_of_draws);
    RUN_TEST(test_odds_with_known_noise_are_the_ratio_of_normal_likelihoods);
    RUN_TEST(test_odds_beyond_the_range_of_float_are_clipped);
    RUN_TEST(test_odds_with_unknown_noise_are_integrated_over_it);
    RUN_TEST(test_sums_below_the_least_noise_are_no_evidence);
    RUN_TEST(test_three_points_are_no_evidence_where_the_noise_is_unknown);
    RUN_TEST(test_odds_are_never_nan);
    RUN_TEST(test_expected_sets_are_binomial);
    RUN_TEST(test_expected_sets_are_the_mean_of_draws);
    RUN_TEST(test_expected_sets_are_clipped_and_not_infinite);
    RUN_TEST(test_expected_sets_are_not_clipped_on_the_way);
    RUN_TEST(test_the_tail_of_F_is_that_of_scipy);
    RUN_TEST(test_of_very_many_degrees_of_freedom_the_tail_is_a_chance);
    RUN_TEST(test_the_logarithm_is_that_of_the_C_library);
    RUN_TEST(test_expected_sets_of_every_size);
}
