/* logs: against libm's exp and log. */
#include <math.h>

#include "rc_logs.h"
#include "test_support.h"

static void test_exp_is_that_of_libm_within_its_range(void)
{
    for (int k = -8000; k <= 8000; k += 37 * TEST_ONE_IN) {
        const double x = D(RC(k / 100.0)), part = fabs(x) / 256;
        const double left = 256 * pow(part, RIGCAL_USE_FLOAT ? 7 : 10) /
                            (RIGCAL_USE_FLOAT ? 5040 : 3628800);
        ASSERT_NEAR(1, D(rc_exp(RC(x))) / exp(x), 2 * left + TOL(1e-13, 4e-5));
    }
    ASSERT_NEAR(1, rc_exp(0), 0);
}

static void test_exp_is_clipped_beyond_80(void)
{
    ASSERT_NEAR(D(rc_exp(80)), D(rc_exp(RC(1e9))), 0);
    ASSERT_NEAR(D(rc_exp(-80)), D(rc_exp(RC(-1e9))), 0);
    TEST_ASSERT_TRUE(rc_exp(-80) > 0);
}

static void test_log_is_that_of_libm_over_the_whole_range(void)
{
    const double most = D(RC_MAX);
    for (int k = -300; k <= 300; k++) {
        const double x = pow(10, k / 8.0 * TOL(8, 1)) * 1.2345;
        if (x < most && x > 1 / most) {
            const double given = D(RC(x)), expected = log(given);
            ASSERT_NEAR(expected, rc_log(RC(x)), fmax(1, fabs(expected)) * 8 * D(RC_EPS));
        }
    }
    for (int k = 1; k < 2000; k++) {
        const double x = D(RC(k / 500.0));
        ASSERT_NEAR(log(x), rc_log(RC(x)), fmax(1, fabs(log(x))) * 4 * D(RC_EPS));
    }
    /* Near 1 the log is small, and as exact for its size: a few roundings. */
    for (int k = -290; k <= 400; k++) {
        const double x = D(RC(1 + k / 1000.0));
        ASSERT_NEAR(log(x), rc_log(RC(x)), fabs(log(x)) * 3 * D(RC_EPS));
    }
    ASSERT_NEAR(0, rc_log(1), 0);
    ASSERT_NEAR(log(most), rc_log(RC_MAX), log(most) * 8 * D(RC_EPS));
}

TEST_MAIN()
{
    RUN_TEST(test_exp_is_that_of_libm_within_its_range);
    RUN_TEST(test_exp_is_clipped_beyond_80);
    RUN_TEST(test_log_is_that_of_libm_over_the_whole_range);
}
