/* For three points of which only two pairs give an equation, rigcal_pairs_choose returned
 * ERR_COINCIDENT, but had written those two pairs. A call that fails must write nothing.
 * Far from the origin, the third point is 8 roundings from the first one along each axis.
 * So the points are just not on a line, and the pair just gives no direction. */
#include "test_support.h"

static void test_two_pairs_are_not_written(void)
{
    const double ulp = 1024 * TOL(2.220446049250313e-16, 1.1920928955078125e-7);
    const rigcal_bearing s[3] = {
        {{1024, 1024, 1024}, {0, 0, 1}},
        {{RC(1024 + 8000 * ulp), RC(1024 - 8000 * ulp), 1024}, {RC(0.2), 0, 1}},
        {{RC(1024 + 8 * ulp), RC(1024 + 8 * ulp), RC(1024 + 8 * ulp)}, {0, RC(0.2), 1}}};
    rigcal_pair pairs[3];
    size_t n_pairs;

    FILL(n_pairs);
    ASSERT_REFUSED(RIGCAL_ERR_COINCIDENT, pairs,
                   rigcal_pairs_choose(pairs, 3, &n_pairs, s, 3));
    ASSERT_UNTOUCHED(n_pairs);
}

TEST_MAIN()
{
    RUN_TEST(test_two_pairs_are_not_written);
}
