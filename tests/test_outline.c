/* outline: the spans of a closed curve that is given piece by piece. The truth: a
 * circle. */
#include <math.h>

#include "rc_outline.h"
#include "test_support.h"

enum { PIECES = 12, LAST = RIGCAL_SPANS_NODES - 1 };

static rigcal_outline outline;

/* Adds the circle as PIECES arcs of five nodes each, in either direction. */
static void add_circle(double u, double v, double radius, double from, int way)
{
    const double step = way * 2 * TEST_PI / (PIECES * LAST);

    for (int piece = 0; piece < PIECES; piece++) {
        rigcal_real at[2][RIGCAL_SPANS_NODES];

        for (int i = 0; i <= LAST; i++) {
            const int k = (piece * LAST + i) % (PIECES * LAST);

            at[0][i] = RC(u + radius * cos(from + k * step));
            at[1][i] = RC(v + radius * sin(from + k * step));
        }
        rc_outline_add(&outline, at[0], at[1]);
    }
}

static void assert_row(int32_t row, double left, double right, int32_t width)
{
    rigcal_span spans[RIGCAL_SPANS_ROW];
    const size_t n = rc_outline_row(spans, &outline, row, width);
    const double first = fmax(ceil(left), 0), last = fmin(floor(right), width - 1);

    if (fabs(left - round(left)) < 0.02 || fabs(right - round(right)) < 0.02) {
        return; /* here rounding decides */
    }
    TEST_ASSERT_EQUAL_UINT64(first <= last, n);
    if (n > 0) {
        TEST_ASSERT_EQUAL_INT32(row, spans[0].row);
        TEST_ASSERT_TRUE(spans[0].first == first || spans[0].first == first - 1);
        TEST_ASSERT_TRUE(spans[0].last == last || spans[0].last == last + 1);
        TEST_ASSERT_TRUE(spans[0].first >= 0 && spans[0].last < width);
    }
}

static void test_the_rows_of_a_circle_are_its_chords(void)
{
    for (int trial = 0; trial < TEST_TRIALS(200); trial++) {
        test_rng rng = test_seed(4700 + (uint64_t)trial);
        const double u = test_uniform(&rng, -10, 110), v = test_uniform(&rng, -10, 70);
        const double radius = test_uniform(&rng, 0.2, 50);
        int32_t last;

        rc_outline_begin(&outline, 60);
        add_circle(u, v, radius, test_uniform(&rng, 0, 6), trial % 2 ? 1 : -1);
        rc_outline_close(&outline);
        TEST_ASSERT_FALSE(outline.is_full);
        const int32_t begin = rc_outline_rows(&last, &outline);

        for (int32_t row = 0; row < 60; row++) {
            const double half2 = radius * radius - (row - v) * (row - v);

            if (half2 > 0) {
                assert_row(row, u - sqrt(half2), u + sqrt(half2), 100);
            }
            if (fabs(half2) > 0.01) {
                TEST_ASSERT_EQUAL_INT(half2 > 0, row >= begin && row <= last);
            }
        }
    }
}

/* A ring. Its rows have two spans, or one. */
static void test_a_row_may_have_several_spans(void)
{
    rigcal_span spans[RIGCAL_SPANS_ROW];

    rc_outline_begin(&outline, 60);
    add_circle(50, 30, 20, 0.1, 1);
    add_circle(50, 30, 10, 0.1, 1);
    rc_outline_close(&outline);
    TEST_ASSERT_EQUAL_UINT64(2, rc_outline_row(spans, &outline, 30, 100));
    TEST_ASSERT_EQUAL_INT32(30, spans[0].first);
    TEST_ASSERT_EQUAL_INT32(40, spans[0].last);
    TEST_ASSERT_EQUAL_INT32(60, spans[1].first);
    TEST_ASSERT_EQUAL_INT32(70, spans[1].last);
    TEST_ASSERT_EQUAL_UINT64(1, rc_outline_row(spans, &outline, 15, 100));
    TEST_ASSERT_EQUAL_INT32(37, spans[0].first); /* 50 - sqrt(175) = 36.77 */
    TEST_ASSERT_EQUAL_INT32(63, spans[0].last);
}

static void test_an_empty_outline_has_no_rows(void)
{
    rigcal_span spans[RIGCAL_SPANS_ROW];
    int32_t last;

    rc_outline_begin(&outline, 60);
    rc_outline_close(&outline);
    TEST_ASSERT_TRUE(rc_outline_rows(&last, &outline) > last);
    TEST_ASSERT_EQUAL_UINT64(0, rc_outline_row(spans, &outline, 3, 100));
}

static void test_more_arcs_than_there_is_room_for_are_told(void)
{
    rc_outline_begin(&outline, 60);
    for (int i = 0; i < RIGCAL_SPANS_ARCS && !outline.is_full; i++) {
        add_circle(50, 30, 20, 0.1, 1);
    }
    TEST_ASSERT_TRUE(outline.is_full);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_SPANS_ARCS, outline.n_arcs);
}

TEST_MAIN()
{
    RUN_TEST(test_the_rows_of_a_circle_are_its_chords);
    RUN_TEST(test_a_row_may_have_several_spans);
    RUN_TEST(test_an_empty_outline_has_no_rows);
    RUN_TEST(test_more_arcs_than_there_is_room_for_are_told);
}
