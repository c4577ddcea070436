/* outline: the spans of a closed curve that is given piece by piece. The truth: a
 * circle. */
#include <math.h>
#include <string.h>

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
    add_circle(50, 30, 20, 0.1, 1); /* forgotten by the next one */
    rc_outline_close(&outline);
    rc_outline_begin(&outline, 60);
    rc_outline_close(&outline);
    TEST_ASSERT_EQUAL_INT32(60, rc_outline_rows(&last, &outline));
    TEST_ASSERT_EQUAL_INT32(-1, last);
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

/* A parabola in v is stored as a polynomial: u = 20 + w^2 / 100, where w counts rows from
 * its first one. */
static void test_a_polynomial_of_the_row_is_kept_as_one(void)
{
    static const rigcal_real u[RIGCAL_SPANS_NODES] = {20, 21, 24, 29, 36};
    static const rigcal_real v[RIGCAL_SPANS_NODES] = {5, 15, 25, 35, 45};
    const rigcal_arc *const arc = &outline.arcs[0];

    rc_outline_begin(&outline, 60);
    rc_outline_add(&outline, u, v);
    TEST_ASSERT_EQUAL_INT32(1, outline.n_arcs);
    TEST_ASSERT_TRUE(arc->is_direct);
    ASSERT_NEAR(5, arc->b[0], TOL(1e-12, 1e-4));
    for (int k = 0; k <= LAST; k++) {
        ASSERT_NEAR(k == 0 ? 20 : k == 2 ? 0.01 : 0, arc->a[k], TOL(1e-12, 1e-5));
    }
}

/* ---- arcs that are no quarter of a circle ----------------------------------- */

/* A vertical border at u = `left`. It ends the span that the border before it begins. */
static void add_edge(double u, double from, double to)
{
    rigcal_real at[2][RIGCAL_SPANS_NODES];

    for (int i = 0; i <= LAST; i++) {
        at[0][i] = RC(u);
        at[1][i] = RC(from + (to - from) * i / LAST);
    }
    rc_outline_add(&outline, at[0], at[1]);
}

/* Spans of one row that are 0.05 px apart become one span. If they are 2 px apart, they
 * stay two. */
static void test_spans_that_touch_become_one(void)
{
    for (int apart = 0; apart < 2; apart++) {
        const double right = apart ? 42 : 40.05;
        rigcal_span spans[RIGCAL_SPANS_ROW];

        rc_outline_begin(&outline, 60);
        add_edge(30, 10, 20);
        add_edge(40, 20, 10);
        add_edge(right, 10, 20);
        add_edge(49.98, 20, 10);
        if (!apart) { /* the pixel at its end belongs to both */
            add_edge(49.99, 10, 20);
            add_edge(50.02, 20, 10);
        }
        rc_outline_close(&outline);
        TEST_ASSERT_EQUAL_UINT64(1 + apart, rc_outline_row(spans, &outline, 15, 100));
        TEST_ASSERT_EQUAL_INT32(30, spans[0].first);
        TEST_ASSERT_EQUAL_INT32(50, spans[apart].last);
        if (apart) {
            TEST_ASSERT_EQUAL_INT32(40, spans[0].last);
            TEST_ASSERT_EQUAL_INT32(42, spans[1].first);
        }
    }
}

/* More arcs cross a row than it has room for. Then spans are lost, but no memory is
 * overrun. */
static void test_a_row_has_no_more_spans_than_there_is_room_for(void)
{
    rigcal_span spans[RIGCAL_SPANS_ROW];

    rc_outline_begin(&outline, 60);
    for (int i = 0; i < RIGCAL_SPANS_ACTIVE + 2; i++) {
        add_edge(4 * i, i % 2 ? 20 : 10, i % 2 ? 10 : 20);
    }
    rc_outline_close(&outline);
    TEST_ASSERT_FALSE(outline.is_full);
    TEST_ASSERT_EQUAL_UINT64(RIGCAL_SPANS_ACTIVE / 2,
                             rc_outline_row(spans, &outline, 15, 100));
    for (int i = 0; i < RIGCAL_SPANS_ACTIVE / 2; i++) {
        TEST_ASSERT_EQUAL_INT32(8 * i, spans[i].first);
        TEST_ASSERT_EQUAL_INT32(8 * i + 4, spans[i].last);
    }
}

static void test_a_stretch_ends_where_the_room_does(void)
{
    rigcal_span spans[RIGCAL_SPANS_ROW + 1];
    int32_t row = 12;

    rc_outline_begin(&outline, 60);
    add_edge(30, 10, 50);
    add_edge(40, 50, 10);
    rc_outline_close(&outline);
    TEST_ASSERT_EQUAL_UINT64(RIGCAL_SPANS_ROW, rc_outline_stretch(spans, RIGCAL_SPANS_ROW,
                                                                  &outline, &row, 49, 100));
    TEST_ASSERT_EQUAL_INT32(12 + RIGCAL_SPANS_ROW, row);
    TEST_ASSERT_EQUAL_INT32(row - 1, spans[RIGCAL_SPANS_ROW - 1].row);
}

/* v = 100 t^4 - `below` hardly rises where it begins. There Newton's method goes too far,
 * and comes back slowly. u = width t. */
static void add_flat(double below, double width)
{
    rigcal_real u[RIGCAL_SPANS_NODES], v[RIGCAL_SPANS_NODES];

    for (int i = 0; i <= LAST; i++) {
        u[i] = RC(width * i);
        v[i] = RC(i > 0 ? 100 * i * i * i * i : -below);
    }
    rc_outline_begin(&outline, 60);
    rc_outline_add(&outline, u, v);
    add_edge(4 * width, 25600, -below);
    rc_outline_close(&outline);
}

static void test_a_flat_start_of_an_arc_is_crossed(void)
{
    rigcal_span spans[RIGCAL_SPANS_ROW];

    add_flat(0, 16);
    for (int32_t row = 1; row < 60; row += 7) {
        TEST_ASSERT_EQUAL_UINT64(1, rc_outline_row(spans, &outline, row, 100));
        ASSERT_NEAR(ceil(16 * pow(row / 100.0, 0.25) - 0.1), spans[0].first, 0);
        TEST_ASSERT_EQUAL_INT32(64, spans[0].last);
    }
    add_flat(1e-18, 2000); /* too slow for the allowed steps, but still on the arc */
    TEST_ASSERT_EQUAL_UINT64(1, rc_outline_row(spans, &outline, 0, 100));
    TEST_ASSERT_TRUE(spans[0].first <= 3);
    TEST_ASSERT_EQUAL_INT32(99, spans[0].last);
}

/* Begins an outline with the curve u = step t, v = f(t), and joins its ends. */
static void close_curve(double (*f)(double), double step, int32_t height)
{
    rigcal_real u[RIGCAL_SPANS_NODES], v[RIGCAL_SPANS_NODES];

    for (int i = 0; i <= LAST; i++) {
        u[i] = RC(step * i);
        v[i] = RC(f(i));
    }
    rc_outline_begin(&outline, height);
    rc_outline_add(&outline, u, v);
    add_edge(step * LAST, D(v[LAST]), D(v[0]));
    rc_outline_close(&outline);
}

/* Where f, which rises or falls from low to high, is at the row. */
static double where(double (*f)(double), double row, double low, double high)
{
    const int rises = f(low) < f(high);

    for (int i = 0; i < 50; i++) {
        const double middle = (low + high) / 2;

        *((f(middle) < row) == rises ? &low : &high) = middle;
    }
    return low;
}

/* A curve that turns back twice between two nodes, by 0.08 px. */
static double folded(double t)
{
    return 10.04 + t * (0.045 + t * (-0.205 + t * (-1.0 / 6 + t / 4)));
}

static void test_an_arc_that_folds_between_nodes_keeps_its_rows(void)
{
    rigcal_span spans[RIGCAL_SPANS_ROW];

    TEST_ASSERT_TRUE(folded(1) < folded(0));
    close_curve(folded, 16, 70);
    for (int32_t row = 11; row < folded(LAST); row++) {
        const double left = 16 * where(folded, row, 1, LAST);

        TEST_ASSERT_EQUAL_UINT64(1, rc_outline_row(spans, &outline, row, 100));
        ASSERT_NEAR(ceil(left - 0.1), spans[0].first, 0);
        TEST_ASSERT_EQUAL_INT32(64, spans[0].last);
    }
}

/* A hill at t = 1.5 and a valley at t = 2.75, v' = 72 (t - 1.5) (t - 2.75). The rows
 * between them have two spans. */
static double hill(double t)
{
    return 20 + t * (297 + t * (-153 + t * 24));
}

static void test_a_hill_beside_a_valley_keeps_its_top(void)
{
    rigcal_span spans[RIGCAL_SPANS_ROW];
    const double top = hill(1.5), bottom = hill(2.75);

    close_curve(hill, 50, 400);
    for (int32_t row = (int32_t)bottom + 2; row < top - 1; row++) {
        TEST_ASSERT_EQUAL_UINT64(2, rc_outline_row(spans, &outline, row, 400));
        ASSERT_NEAR(50 * where(hill, row, 0, 1.5), spans[0].first, 1.1);
        ASSERT_NEAR(50 * where(hill, row, 1.5, 2.75), spans[0].last, 1.1);
        ASSERT_NEAR(50 * where(hill, row, 2.75, LAST), spans[1].first, 1.1);
    }
}

/* A valley of the curve, u = 20 t and v = 10 + 40 (t - bottom)^2, closed by a border. Its
 * bottom may be anywhere between two nodes. */
static void test_rows_near_the_turn_of_a_curve_are_its_chords(void)
{
    for (int k = 1; k < 80; k++) {
        const double bottom = k / 20.0, least = 10, steep = 40;
        rigcal_real u[RIGCAL_SPANS_NODES], v[RIGCAL_SPANS_NODES];

        for (int i = 0; i <= LAST; i++) {
            u[i] = RC(20 * i);
            v[i] = RC(least + steep * (i - bottom) * (i - bottom));
        }
        rc_outline_begin(&outline, 900);
        rc_outline_add(&outline, u, v);
        add_edge(80, D(v[LAST]), D(v[0]));
        rc_outline_close(&outline);
        for (int32_t row = 11; row < 50; row++) {
            const double half = 20 * sqrt((row - least) / steep), left = 20 * bottom - half;

            if (left > 0 && left + 2 * half < 80) {
                assert_row(row, left, left + 2 * half, 100);
            }
        }
    }
}

/* v = 3 t^2 + t / 2 rises all the way. */
static double rise(double t)
{
    return t * (3 * t + 0.5);
}

/* How far t^power is, at this t, from the polynomial in v that is the same at the nodes. */
static double off_direct(int power, double t)
{
    double off = pow(t, power);

    for (int i = 0; i <= LAST; i++) {
        double part = pow(i, power);

        for (int j = 0; j <= LAST; j++) {
            part *= (j == i) ? 1 : (rise(t) - rise(j)) / (rise(i) - rise(j));
        }
        off -= part;
    }
    return off;
}

/* u = 40 (t + k t^3) is near a polynomial in v at one end of the arc only: k makes it one
 * exactly, half-way between the first two nodes or the last two. */
static void test_an_arc_with_one_end_like_a_polynomial_keeps_its_rows(void)
{
    for (int end = 0; end < 2; end++) {
        const double fits = end ? 3.5 : 0.5, k = -off_direct(1, fits) / off_direct(3, fits);
        rigcal_real u[RIGCAL_SPANS_NODES], v[RIGCAL_SPANS_NODES];

        TEST_ASSERT_TRUE(40 * fabs(off_direct(1, 4 - fits) + k * off_direct(3, 4 - fits)) >
                         2);
        for (int i = 0; i <= LAST; i++) {
            u[i] = RC(40 * (i + k * i * i * i));
            v[i] = RC(rise(i));
        }
        rc_outline_begin(&outline, 60);
        rc_outline_add(&outline, u, v);
        add_edge(D(u[LAST]), D(v[LAST]), 0);
        rc_outline_close(&outline);
        for (int32_t row = 1; row < 50; row++) {
            const double t = (sqrt(0.25 + 12 * row) - 0.5) / 6;

            assert_row(row, 40 * (t + k * t * t * t), D(u[LAST]), 10000);
        }
    }
}

static double quartic(const double c[RIGCAL_SPANS_NODES], double t)
{
    return c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * c[4])));
}

/* A random curve of degree 4, without two turns of v between two nodes. */
static void random_quartic(double c[2][RIGCAL_SPANS_NODES], test_rng *rng)
{
    enum { FINE = 100 };
    int is_folded;

    do {
        int turns[LAST] = {0};

        for (int axis = 0; axis < 2; axis++) {
            for (int k = 0; k <= LAST; k++) {
                c[axis][k] = test_uniform(rng, -40, 40) / pow(2, k);
            }
            c[axis][0] += 60;
        }
        is_folded = 0;
        for (int i = 1; i < LAST * FINE; i++) {
            const double t = i / (double)FINE;
            const double before = quartic(c[1], t - 0.01), at = quartic(c[1], t);

            turns[i / FINE] += (at - before) * (quartic(c[1], t + 0.01) - at) <= 0;
        }
        for (int i = 0; i < LAST; i++) {
            is_folded |= turns[i] > 1;
        }
    } while (is_folded);
}

/* A point is inside the outline if a line from it to the left crosses the outline an odd
 * number of times. The curve is followed in small straight steps. Rows that it grazes are
 * left out: far from the image its nodes are large, and in float rounded to 1e-4. */
static void test_the_rows_of_any_curve_are_what_is_inside(void)
{
    enum { WIDTH = 120, HEIGHT = 120, STEPS = 800 };
    static double at[STEPS + 4][2];
    test_rng rng = test_seed(4712);

    TEST_WANTS_RAM(sizeof at + 20000);
    for (int trial = 0; trial < TEST_TRIALS(300); trial++) {
        double c[2][RIGCAL_SPANS_NODES], corner[2];
        rigcal_real u[RIGCAL_SPANS_NODES], v[RIGCAL_SPANS_NODES];
        int n = 0;

        random_quartic(c, &rng);
        corner[0] = test_uniform(&rng, 0, 120);
        corner[1] = test_uniform(&rng, 0, 120);
        for (; n <= STEPS; n++) {
            at[n][0] = quartic(c[0], LAST * n / (double)STEPS);
            at[n][1] = quartic(c[1], LAST * n / (double)STEPS);
        }
        memcpy(at[n++], corner, sizeof corner);
        memcpy(at[n++], at[0], sizeof corner);
        rc_outline_begin(&outline, HEIGHT);
        for (int side = 0; side < 3; side++) {
            for (int i = 0; i <= LAST; i++) {
                const double part = i / (double)LAST;
                const double *const p = at[side == 0 ? 0 : STEPS + side - 1];
                const double *const q = at[STEPS + side];

                u[i] = RC(side ? p[0] + part * (q[0] - p[0]) : quartic(c[0], i));
                v[i] = RC(side ? p[1] + part * (q[1] - p[1]) : quartic(c[1], i));
            }
            rc_outline_add(&outline, u, v);
        }
        rc_outline_close(&outline);
        TEST_ASSERT_FALSE(outline.is_full);
        for (int32_t row = 0; row < HEIGHT; row++) {
            double crossing[16];
            int n_crossings = 0, is_grazed = 0;
            rigcal_span spans[RIGCAL_SPANS_ROW];
            const size_t n_spans = rc_outline_row(spans, &outline, row, WIDTH);

            for (int i = 1; i < n && n_crossings < 16; i++) {
                const double *const p = at[i - 1], *const q = at[i];

                is_grazed |= fabs(p[1] - row) < 0.05 && fabs(q[1] - row) < 0.05;
                if ((p[1] < row) != (q[1] < row)) {
                    is_grazed |= fabs(q[0] - p[0]) > TOL(100, 15) * fabs(q[1] - p[1]);
                    crossing[n_crossings++] =
                        p[0] + (row - p[1]) / (q[1] - p[1]) * (q[0] - p[0]);
                }
            }
            for (int column = 0; column < WIDTH && !is_grazed; column++) {
                int is_inside = 0, is_near = 0, is_told = 0;

                for (int k = 0; k < n_crossings; k++) {
                    is_inside ^= crossing[k] < column;
                    is_near |= fabs(crossing[k] - column) < 0.2;
                }
                for (size_t k = 0; k < n_spans; k++) {
                    is_told |= spans[k].first <= column && column <= spans[k].last;
                }
                TEST_ASSERT_TRUE(is_near || is_told == is_inside);
            }
        }
    }
}

/* v at t. As a function of v, t is no polynomial. */
static double bent(double t)
{
    return t * (20 + 2 * t);
}

/* An arc that is no polynomial of the row is divided into four parts at even steps of t,
 * each of which begins where the one before ends. Most of them are near a polynomial. */
static void test_a_long_arc_is_divided_into_parts(void)
{
    for (int way = 0; way < 2; way++) {
        rigcal_real u[RIGCAL_SPANS_NODES], v[RIGCAL_SPANS_NODES];
        int n_direct = 0;

        for (int i = 0; i <= LAST; i++) {
            u[i] = RC(10 * i);
            v[i] = RC(bent(way ? LAST - i : i));
        }
        rc_outline_begin(&outline, 300);
        rc_outline_add(&outline, u, v);
        TEST_ASSERT_EQUAL_INT32(LAST, outline.n_arcs);
        for (int i = 0; i < LAST; i++) {
            const rigcal_arc *const arc = &outline.arcs[i];
            const int least = way ? LAST - 1 - i : i;

            n_direct += arc->is_direct;
            ASSERT_NEAR(bent(least), arc->low, TOL(1e-12, 1e-4));
            ASSERT_NEAR(bent(least + 1), arc->high, TOL(1e-12, 1e-4));
            ASSERT_NEAR(way ? i + 1 : i, arc->t_low, 0);
            ASSERT_NEAR(way ? i : i + 1, arc->t_high, 0);
            if (i > 0) { /* to the bit */
                ASSERT_NEAR(D(way ? arc[-1].low : arc[-1].high), way ? arc->high : arc->low,
                            0);
            }
        }
        TEST_ASSERT_GREATER_OR_EQUAL_INT(3, n_direct);
    }
}

/* Curves that end exactly in a row, 50, where a border goes on. Whatever rounding does,
 * each row has one span: none ends twice or not at all. */
static void test_a_corner_exactly_in_a_row_leaves_no_gap(void)
{
    test_rng rng = test_seed(4711);

    for (int trial = 0; trial < 200; trial++) {
        const double power = test_uniform(&rng, 1.2, 2.8),
                     far = test_uniform(&rng, 50, 4000);
        const int is_up = trial % 2;
        rigcal_real u[RIGCAL_SPANS_NODES], v[RIGCAL_SPANS_NODES];
        rigcal_span spans[RIGCAL_SPANS_ROW];

        for (int i = 0; i <= LAST; i++) {
            const double part = (is_up ? LAST - i : i) / (double)LAST;

            u[i] = RC(far * part);
            v[i] = RC(50 * pow(part, power));
        }
        rc_outline_begin(&outline, 60);
        add_edge(far, is_up ? 59 : 50, is_up ? 50 : 59);
        rc_outline_add(&outline, u, v);
        add_edge(5000, is_up ? 0 : 59, is_up ? 59 : 0);
        rc_outline_close(&outline);
        for (int32_t row = 0; row < 59; row++) {
            TEST_ASSERT_EQUAL_UINT64(1, rc_outline_row(spans, &outline, row, 6000));
            TEST_ASSERT_EQUAL_INT32(5000, spans[0].last);
            TEST_ASSERT_TRUE(row < 50 || fabs(spans[0].first - far) < 1.1);
        }
    }
}

/* A border above another one, which begins in the row in which the first one ends. Rows in
 * order, and rows at random. */
static void test_an_arc_ends_before_the_row_of_its_end(void)
{
    test_rng rng = test_seed(4710);

    rc_outline_begin(&outline, 60);
    add_edge(30, 10, 20);
    add_edge(40, 20, 10);
    add_edge(60, 20, 30);
    add_edge(70, 30, 20);
    rc_outline_close(&outline);
    for (int trial = 0; trial < 200; trial++) {
        const int32_t row = trial < 40 ? trial : (int32_t)(test_next(&rng) % 40);
        rigcal_span spans[RIGCAL_SPANS_ROW];
        const size_t n = rc_outline_row(spans, &outline, row, 100);

        TEST_ASSERT_EQUAL_UINT64(row >= 10 && row < 30, n);
        if (n > 0) {
            TEST_ASSERT_EQUAL_INT32(row < 20 ? 30 : 60, spans[0].first);
            TEST_ASSERT_EQUAL_INT32(row < 20 ? 40 : 70, spans[0].last);
        }
    }
}

/* The lowest and the highest row, whichever arc comes first. */
static void test_the_rows_of_an_outline_are_those_of_all_its_arcs(void)
{
    for (int lowest = 0; lowest < 3; lowest++) {
        int32_t last;

        rc_outline_begin(&outline, 60);
        for (int i = 0; i < 3; i++) {
            add_edge(30, i == lowest ? 3.5 : 10, i == (lowest + 1) % 3 ? 51 : 20);
        }
        rc_outline_close(&outline);
        TEST_ASSERT_EQUAL_INT32(4, rc_outline_rows(&last, &outline));
        TEST_ASSERT_EQUAL_INT32(50, last);
    }
}

static void test_a_curve_above_the_image_has_no_rows(void)
{
    rigcal_real u[RIGCAL_SPANS_NODES], v[RIGCAL_SPANS_NODES];
    rigcal_outline curve;
    int32_t last;

    for (int i = 0; i < RIGCAL_SPANS_NODES; i++) {
        u[i] = RC(i);
        v[i] = RC(i - 20);
    }
    rc_outline_begin(&curve, 100);
    rc_outline_add(&curve, u, v);
    rc_outline_close(&curve);
    const int32_t first = rc_outline_rows(&last, &curve);
    TEST_ASSERT_TRUE(last < first);
}

TEST_MAIN()
{
    RUN_TEST(test_a_curve_above_the_image_has_no_rows);
    RUN_TEST(test_the_rows_of_a_circle_are_its_chords);
    RUN_TEST(test_a_row_may_have_several_spans);
    RUN_TEST(test_an_empty_outline_has_no_rows);
    RUN_TEST(test_more_arcs_than_there_is_room_for_are_told);
    RUN_TEST(test_a_polynomial_of_the_row_is_kept_as_one);
    RUN_TEST(test_spans_that_touch_become_one);
    RUN_TEST(test_a_row_has_no_more_spans_than_there_is_room_for);
    RUN_TEST(test_a_stretch_ends_where_the_room_does);
    RUN_TEST(test_a_flat_start_of_an_arc_is_crossed);
    RUN_TEST(test_an_arc_that_folds_between_nodes_keeps_its_rows);
    RUN_TEST(test_a_hill_beside_a_valley_keeps_its_top);
    RUN_TEST(test_rows_near_the_turn_of_a_curve_are_its_chords);
    RUN_TEST(test_an_arc_with_one_end_like_a_polynomial_keeps_its_rows);
    RUN_TEST(test_the_rows_of_any_curve_are_what_is_inside);
    RUN_TEST(test_a_long_arc_is_divided_into_parts);
    RUN_TEST(test_a_corner_exactly_in_a_row_leaves_no_gap);
    RUN_TEST(test_an_arc_ends_before_the_row_of_its_end);
    RUN_TEST(test_the_rows_of_an_outline_are_those_of_all_its_arcs);
}
