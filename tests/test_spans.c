/* spans: the columns to search in every row of an image. The truth: every pixel of the
 * image is tested. */
#include <math.h>
#include <string.h>

#include "rigcal_solvers.h"
#include "test_bands.h"

enum { SIDE = 96, PIXELS = SIDE * SIDE * 11 / 10, SPANS_MAX = 4 * SIDE };

static test_ray rays[PIXELS];
static uint8_t is_seen[PIXELS], is_in[PIXELS], is_found[PIXELS], is_close[PIXELS];
static rigcal_spans_solver solver;
static rigcal_span spans[SPANS_MAX];

/* A pixel this close to the border depends on rounding. */
#define CLOSE TOL(1e-7, 2e-3)

/* ---- brute force ----------------------------------------------------------- */

static void see_pixels(const rigcal_camera *camera)
{
    for (int32_t i = 0; i < camera->width * camera->height; i++) {
        const rigcal_real uv[2] = {RC(i % camera->width), RC(i / camera->width)};

        is_seen[i] = (uint8_t)test_ray_of(&rays[i], camera, uv);
    }
}

/* Marks the pixels that are in the band, and those in the spans. */
static void mark(const test_bands *scene, size_t n)
{
    const int32_t width = scene->b.width, count = width * scene->b.height;
    test_ray a;

    TEST_ASSERT_TRUE(test_ray_of(&a, &scene->a, scene->uv_a));
    memset(is_found, 0, sizeof is_found);
    for (int32_t i = 0; i < count; i++) {
        test_band_truth truth;

        test_band_look(&truth, scene, &a, &rays[i]);
        is_in[i] = (uint8_t)(is_seen[i] && truth.is_inside);
        is_close[i] = (uint8_t)(is_seen[i] && truth.margin < CLOSE);
    }
    for (size_t k = 0; k < n; k++) {
        TEST_ASSERT_TRUE(spans[k].first >= 0 && spans[k].last < width);
        TEST_ASSERT_TRUE(spans[k].first <= spans[k].last);
        for (int32_t u = spans[k].first; u <= spans[k].last; u++) {
            is_found[spans[k].row * width + u]++;
        }
    }
}

/* Every pixel of the band must be in a span, and a span may have at most one more pixel at
 * each end. */
static void assert_spans(const rigcal_camera *camera, size_t n)
{
    const int32_t width = camera->width;

    for (int32_t i = 0; i < width * camera->height; i++) {
        TEST_ASSERT_TRUE(is_found[i] <= 1);
        TEST_ASSERT_TRUE_MESSAGE(is_found[i] || !is_in[i] || is_close[i], "missed");
    }
    for (size_t k = 0; k < n; k++) {
        const int32_t row = spans[k].row * width;

        for (int32_t u = spans[k].first; u <= spans[k].last; u++) {
            const int is_end = u == spans[k].first || u == spans[k].last;
            const int has_next = (u > spans[k].first && is_in[row + u - 1]) ||
                                 (u < spans[k].last && is_in[row + u + 1]);

            TEST_ASSERT_TRUE_MESSAGE(is_in[row + u] || is_close[row + u] ||
                                         (is_end && has_next),
                                     "more than one pixel too many");
        }
        TEST_ASSERT_TRUE(
            k == 0 || spans[k - 1].row < spans[k].row ||
            (spans[k - 1].row == spans[k].row && spans[k - 1].last < spans[k].first));
    }
}

static size_t find(const rigcal_band *band)
{
    size_t n = 0;
    const rigcal_status status = rigcal_spans_find(spans, SPANS_MAX, &n, &solver, band);

    TEST_ASSERT_TRUE(status == RIGCAL_OK || status == RIGCAL_ERR_OUTSIDE);
    return status == RIGCAL_OK ? n : 0;
}

/* Compares the spans of random bands with tests of all pixels. `half` is the largest half
 * width, as a part of the focal length; 0: as test_bands_random makes them. */
static void look_at_bands(int kind, uint64_t seed, double half)
{
    enum { BANDS = 10 };
    test_rng rng = test_seed(seed);
    test_bands scene;
    int found = 0;

    test_bands_random(&scene, &rng, kind, SIDE);
    const rigcal_camera camera = scene.b;

    see_pixels(&camera);
    for (int k = 0; k < BANDS; k++) {
        rigcal_band band;

        test_bands_random(&scene, &rng, kind, SIDE);
        scene.b = camera;
        if (half > 0) {
            scene.pair.sigma_b =
                RC(test_uniform(&rng, 0.01, half)) * camera.fx / scene.pair.k;
        }
        if (rigcal_band_make(&band, &scene.pair, scene.uv_a) == RIGCAL_ERR_EPIPOLE) {
            continue;
        }
        const size_t n = find(&band);

        mark(&scene, n);
        assert_spans(&camera, n);
        found += n > 0;
    }
    TEST_ASSERT_TRUE(found > 1);
}

static void test_spans_hold_the_band_and_at_most_a_pixel_more_at_each_end(void)
{
    enum { CAMERAS = 24 };

    for (int c = 0; c < TEST_TRIALS(CAMERAS); c++) {
        look_at_bands(c % TEST_LENS_KINDS, 4100 + (uint64_t)c, 0);
    }
}

/* One border of a wide band leaves the image long before the other. */
static void test_spans_hold_bands_of_half_a_focal_length(void)
{
    enum { CAMERAS = 24 };

    for (int c = 0; c < TEST_TRIALS(CAMERAS); c++) {
        look_at_bands(c % 2 ? TEST_PINHOLE : TEST_FISHEYE, 4300 + (uint64_t)c, 0.5);
        look_at_bands(TEST_BROWN, 4400 + (uint64_t)c, 0.15);
    }
}

/* ---- known by hand --------------------------------------------------------- */

static rigcal_camera camera;

/* Camera b is 1 to the right of a, and both are the same pinhole, so lines are rows.
 * sigma_b is the only noise: the band is 2 k sigma_b wide. */
static void beside(rigcal_band *band, double v, double sigma_b, double near_a, double far_a)
{
    const rigcal_real uv_a[2] = {40, RC(v)};
    rigcal_match_pair pair;

    test_bands_beside(&pair, &camera, sigma_b, 2);
    pair.near_a = RC(near_a);
    pair.far_a = RC(far_a);
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(band, &pair, uv_a));
}

static void test_a_level_band_has_level_spans(void)
{
    rigcal_band band;

    beside(&band, 30, 0.7, 0, 0); /* rows 28.6 to 31.4; nearer points are farther left */
    TEST_ASSERT_EQUAL_UINT64(3, find(&band));
    for (int k = 0; k < 3; k++) {
        TEST_ASSERT_EQUAL_INT32(29 + k, spans[k].row);
        TEST_ASSERT_EQUAL_INT32(0, spans[k].first);
        TEST_ASSERT_EQUAL_INT32(40, spans[k].last);
    }
}

/* u = 40 - 50 / Z; 40 is straight ahead of a. */
static void test_a_depth_range_ends_the_spans(void)
{
    rigcal_band band;

    beside(&band, 30, 0.4, 2, 4.05); /* u from 15 to 27.65 */
    TEST_ASSERT_EQUAL_UINT64(1, find(&band));
    TEST_ASSERT_EQUAL_INT32(30, spans[0].row);
    TEST_ASSERT_EQUAL_INT32(15, spans[0].first);
    TEST_ASSERT_EQUAL_INT32(27, spans[0].last);
}

/* The end of the depth range is put where an arc ends, to the bit. The border ends there,
 * although the arc was not begun as the last one. */
static void test_a_depth_range_may_end_where_an_arc_ends(void)
{
    rigcal_band band;
    rigcal_real end[2];

    beside(&band, 30, 0.7, 0, 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_spans_begin(&solver, &band));
    while (solver.node < RIGCAL_SPANS_NODES - 1 || solver.is_last) {
        ASSERT_STATUS(RIGCAL_RUNNING, rigcal_spans_step(&solver, 1));
    }
    const int32_t side = solver.side, way = solver.way;
    const rigcal_real turn = way == 0 ? -solver.stride : solver.stride;

    end[0] = solver.at[0] - turn * solver.at[1];
    end[1] = solver.at[1] + turn * solver.at[0];
    memcpy(solver.ends[way], end, sizeof end);
    ASSERT_STATUS(RIGCAL_RUNNING, rigcal_spans_step(&solver, 1));
    TEST_ASSERT_TRUE(solver.side != side || solver.way != way);
    TEST_ASSERT_EQUAL_INT32(1, solver.corners[side][way].is_of_range);
    ASSERT_STATUS(RIGCAL_OK, rigcal_spans_step(&solver, RIGCAL_SPANS_UNITS));
}

/* b looks away from all that a sees. The solver holds the borders of another band. */
static void test_a_band_behind_the_camera_has_no_pixel(void)
{
    static const double t[3] = {-1, 0, 0}, turn[9] = {-1, 0, 0, 0, 1, 0, 0, 0, -1};
    const rigcal_real uv_a[2] = {40, 30};
    rigcal_match_pair pair;
    rigcal_band band;
    size_t n = 7;

    beside(&band, 30, 0.7, 0, 0);
    TEST_ASSERT_EQUAL_UINT64(3, find(&band));
    test_bands_beside(&pair, &camera, 0.7, 2);
    pair.b_from_a = test_transform(turn, t);
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &pair, uv_a));
    ASSERT_STATUS(RIGCAL_ERR_OUTSIDE,
                  rigcal_spans_find(spans, SPANS_MAX, &n, &solver, &band));
    TEST_ASSERT_EQUAL_UINT64(7, n);
}

static void test_a_band_between_two_rows_has_no_pixel(void)
{
    size_t n;
    rigcal_band band;

    beside(&band, 30.5, 0.2, 0, 0); /* v from 30.1 to 30.9 */
    ASSERT_REFUSED(RIGCAL_ERR_OUTSIDE, n,
                   rigcal_spans_find(spans, SPANS_MAX, &n, &solver, &band));
}

static void test_a_band_outside_the_image_has_no_pixel(void)
{
    size_t n;
    rigcal_band band;

    beside(&band, 70, 1, 0, 0);
    ASSERT_REFUSED(RIGCAL_ERR_OUTSIDE, n,
                   rigcal_spans_find(spans, SPANS_MAX, &n, &solver, &band));
}

/* ---- steps and rows -------------------------------------------------------- */

static void wide_band(rigcal_band *band)
{
    test_bands scene;

    for (uint64_t seed = 4200;; seed++) {
        test_rng rng = test_seed(seed);

        test_bands_random(&scene, &rng, TEST_BROWN, SIDE);
        if (rigcal_band_make(band, &scene.pair, scene.uv_a) == RIGCAL_OK &&
            find(band) > 20) {
            return;
        }
    }
}

static void test_the_spans_are_the_same_whatever_the_budgets(void)
{
    static rigcal_span once[SPANS_MAX];
    rigcal_band band;
    size_t n;

    wide_band(&band);
    const size_t n_once = find(&band);

    memcpy(once, spans, sizeof once);
    for (int32_t budget = 1; budget <= 7; budget += 3) {
        int32_t units = 0;
        rigcal_status status;

        ASSERT_STATUS(RIGCAL_OK, rigcal_spans_begin(&solver, &band));
        do {
            ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_spans_row(spans, &n, &solver, 0));
            status = rigcal_spans_step(&solver, budget);
            units += budget;
        } while (status == RIGCAL_RUNNING);
        ASSERT_STATUS(RIGCAL_OK, status);
        TEST_ASSERT_TRUE(units <= RIGCAL_SPANS_UNITS);
        ASSERT_STATUS(RIGCAL_OK, rigcal_spans_result(spans, SPANS_MAX, &n, &solver));
        TEST_ASSERT_EQUAL_UINT64(n_once, n);
        TEST_ASSERT_EQUAL_MEMORY(once, spans, n * sizeof *spans);
    }
}

static void test_rows_may_come_in_any_order(void)
{
    rigcal_span row[RIGCAL_SPANS_ROW];
    rigcal_band band;
    size_t at = 0, n;

    wide_band(&band);
    const size_t all = find(&band);

    for (size_t k = all; k > 0; k -= n, at += n) { /* from the last to the first */
        const int32_t v = spans[k - 1].row;

        ASSERT_STATUS(RIGCAL_OK, rigcal_spans_row(row, &n, &solver, v));
        TEST_ASSERT_TRUE(n >= 1 && n <= k);
        TEST_ASSERT_EQUAL_MEMORY(&spans[k - n], row, n * sizeof *row);
    }
    TEST_ASSERT_EQUAL_UINT64(all, at);
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_spans_row(row, &n, &solver, -1));
    ASSERT_STATUS(RIGCAL_ERR_RANGE,
                  rigcal_spans_row(row, &n, &solver, band.camera_b.height));
}

/* Room for all spans and no more is enough. What was there before does not matter. */
static void test_too_little_room_is_refused(void)
{
    static rigcal_span exact[SPANS_MAX];
    rigcal_band band;
    size_t n;

    wide_band(&band);
    const size_t all = find(&band);

    FILL(exact);
    ASSERT_STATUS(RIGCAL_OK, rigcal_spans_result(exact, all, &n, &solver));
    TEST_ASSERT_EQUAL_UINT64(all, n);
    TEST_ASSERT_EQUAL_MEMORY(spans, exact, all * sizeof *exact);
    ASSERT_UNTOUCHED(exact[all]);
    ASSERT_REFUSED(RIGCAL_ERR_CAPACITY, n,
                   rigcal_spans_result(spans, all - 1, &n, &solver));
}

static void test_a_missing_argument_or_a_step_too_early_is_named(void)
{
    rigcal_band band;
    size_t n;

    wide_band(&band);
    FILL(n);
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_spans_begin(NULL, &band));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_spans_begin(&solver, NULL));
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_spans_step(&solver, 1));
    ASSERT_STATUS(RIGCAL_OK, rigcal_spans_begin(&solver, &band));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_spans_step(NULL, 1));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_spans_step(&solver, 0));
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_spans_result(spans, SPANS_MAX, &n, &solver));
    ASSERT_STATUS(RIGCAL_OK, rigcal_spans_step(&solver, RIGCAL_SPANS_UNITS));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_spans_row(NULL, &n, &solver, 0));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_spans_row(spans, NULL, &solver, 0));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_spans_row(spans, &n, NULL, 0));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_spans_result(NULL, SPANS_MAX, &n, &solver));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_spans_result(spans, SPANS_MAX, NULL, &solver));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_spans_result(spans, SPANS_MAX, &n, NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_spans_find(NULL, SPANS_MAX, &n, &solver, &band));
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_spans_find(spans, SPANS_MAX, NULL, &solver, &band));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_spans_find(spans, SPANS_MAX, &n, NULL, &band));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_spans_find(spans, SPANS_MAX, &n, &solver, NULL));
    ASSERT_UNTOUCHED(n);
}

/* The direction of t is so uncertain that no place is k standard deviations off the
 * line. */
static void test_a_band_without_borders_is_refused(void)
{
    rigcal_band band;
    size_t n;

    wide_band(&band);
    band.Sigma_line[5] = band.across * band.across / band.k / band.k * RC(1.01);
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_spans_begin(&solver, &band));
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_spans_step(&solver, 1));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, n,
                   rigcal_spans_find(spans, SPANS_MAX, &n, &solver, &band));
}

/* ---- lenses for which nothing is promised ---------------------------------- */

/* The spans of each row are in order and in the image. */
static void assert_rows_in_order(const rigcal_camera *lens)
{
    for (int32_t row = 0; row < lens->height; row++) {
        size_t n = 0;

        ASSERT_STATUS(RIGCAL_OK, rigcal_spans_row(spans, &n, &solver, row));
        TEST_ASSERT_TRUE(n <= RIGCAL_SPANS_ROW);
        for (size_t i = 0; i < n; i++) {
            TEST_ASSERT_EQUAL_INT32(row, spans[i].row);
            TEST_ASSERT_TRUE(0 <= spans[i].first && spans[i].first <= spans[i].last);
            TEST_ASSERT_TRUE(spans[i].last < lens->width);
            TEST_ASSERT_TRUE(i == 0 || spans[i].first > spans[i - 1].last);
        }
    }
}

static void assert_no_row_has_an_answer(void)
{
    size_t n = 7;

    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_spans_row(spans, &n, &solver, 0));
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_spans_result(spans, SPANS_MAX, &n, &solver));
    TEST_ASSERT_EQUAL_UINT64(7, n);
}

/* Such a band has rows in order, or more arcs than there is room for. */
static void test_a_lens_that_nearly_folds_ends_the_search_all_the_same(void)
{
    enum { SCENES = 600 };
    int too_many = 0;

    for (int i = 0; i < TEST_TRIALS(SCENES); i++) {
        test_rng rng = test_seed(4900 + (uint64_t)i);
        test_bands scene;
        rigcal_band band;

        test_bands_wild(&scene, &rng, 16 * SIDE);
        if (rigcal_band_make(&band, &scene.pair, scene.uv_a) != RIGCAL_OK ||
            rigcal_spans_begin(&solver, &band) != RIGCAL_OK) {
            continue; /* no line, or a band without two borders */
        }
        const rigcal_status status = rigcal_spans_step(&solver, RIGCAL_SPANS_UNITS);
        if (status == RIGCAL_ERR_DEGENERATE) {
            assert_no_row_has_an_answer();
            too_many++;
        } else {
            ASSERT_STATUS(RIGCAL_OK, status);
            assert_rows_in_order(&scene.b);
        }
    }
    TEST_ASSERT_TRUE(TEST_TRIALS(SCENES) < SCENES || too_many > 0);
}

TEST_MAIN()
{
    RUN_TEST(test_spans_hold_the_band_and_at_most_a_pixel_more_at_each_end);
    RUN_TEST(test_spans_hold_bands_of_half_a_focal_length);
    RUN_TEST(test_a_level_band_has_level_spans);
    RUN_TEST(test_a_depth_range_ends_the_spans);
    RUN_TEST(test_a_depth_range_may_end_where_an_arc_ends);
    RUN_TEST(test_a_band_behind_the_camera_has_no_pixel);
    RUN_TEST(test_a_band_between_two_rows_has_no_pixel);
    RUN_TEST(test_a_band_outside_the_image_has_no_pixel);
    RUN_TEST(test_the_spans_are_the_same_whatever_the_budgets);
    RUN_TEST(test_rows_may_come_in_any_order);
    RUN_TEST(test_too_little_room_is_refused);
    RUN_TEST(test_a_band_without_borders_is_refused);
    RUN_TEST(test_a_missing_argument_or_a_step_too_early_is_named);
    RUN_TEST(test_a_lens_that_nearly_folds_ends_the_search_all_the_same);
}
