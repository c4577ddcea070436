/* The search for the end of a row ended too early where the border turns in u: a row was
 * short or long by some pixels. */
#include <math.h>

#include "rc_outline.h"
#include "test_support.h"

static rigcal_outline outline;

/* u = 50 + 10 (t - turn)^2 and v = 10 + 0.3 t^2, so t = sqrt((row - 10) / 0.3). The border
 * turns where the search for that row begins: at the same part of t as of v. */
static void test_a_row_ends_at_the_border(void)
{
    for (int32_t row = 11; row < 15; row++) {
        const double turn = 4 * (row - 10) / 4.8, t = sqrt((row - 10) / 0.3);
        rigcal_real u[RIGCAL_SPANS_NODES], v[RIGCAL_SPANS_NODES];
        rigcal_span spans[RIGCAL_SPANS_ROW];

        rc_outline_begin(&outline, 60);
        for (int i = 0; i < RIGCAL_SPANS_NODES; i++) {
            u[i] = RC(50 + 10 * (i - turn) * (i - turn));
            v[i] = RC(10 + 0.3 * i * i);
        }
        rc_outline_add(&outline, u, v);
        for (int i = 0; i < RIGCAL_SPANS_NODES; i++) {
            u[i] = 300;
            v[i] = RC(14.8 - 1.2 * i);
        }
        rc_outline_add(&outline, u, v);
        rc_outline_close(&outline);
        TEST_ASSERT_EQUAL(1, rc_outline_row(spans, &outline, row, 400));
        ASSERT_NEAR(ceil(50 + 10 * (t - turn) * (t - turn) - 0.1), spans[0].first, 0);
        TEST_ASSERT_EQUAL_INT32(300, spans[0].last);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_row_ends_at_the_border);
}
