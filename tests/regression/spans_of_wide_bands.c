/* The spans of a band some hundred pixels wide missed pixels at a corner of the image: one
 * border had left the image, and a straight line joined its end with the other border. */
#include "rigcal_solvers.h"
#include "test_bands.h"

enum { WIDTH = 80, HEIGHT = 60 };

static rigcal_spans_solver solver;

/* Camera b is 1 to the left of and 1 above a. The match of uv_a is uv_a at infinity; the
 * nearer the point, the farther it is to the lower right. */
static void assert_band(const rigcal_real uv_a[2])
{
    static const double t[3] = {1, 1, 0};
    rigcal_camera camera;
    rigcal_match_pair pair;
    rigcal_match match;
    rigcal_band band;

    test_bands_beside(&pair, &camera, 15, 2);
    pair.b_from_a = test_transform(NULL, t);
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &pair, uv_a));
    ASSERT_STATUS(RIGCAL_OK, rigcal_spans_begin(&solver, &band));
    ASSERT_STATUS(RIGCAL_OK, rigcal_spans_step(&solver, RIGCAL_SPANS_UNITS));
    for (int32_t v = 0; v < HEIGHT; v++) {
        rigcal_span spans[RIGCAL_SPANS_ROW];
        size_t n, k = 0;

        ASSERT_STATUS(RIGCAL_OK, rigcal_spans_row(spans, &n, &solver, v));
        for (int32_t u = 0; u < WIDTH; u++) {
            const rigcal_real uv[2] = {RC(u), RC(v)};

            k += k < n && u > spans[k].last;
            TEST_ASSERT_TRUE(rigcal_band_test(&match, &band, uv) != RIGCAL_OK ||
                             !match.is_inside || (k < n && u >= spans[k].first));
        }
    }
}

static void test_a_band_has_the_corners_of_its_image(void)
{
    for (int along = -60; along <= 60; along += 5) {
        const rigcal_real uv_a[2] = {RC(along > 0 ? along : -5),
                                     RC(along > 0 ? -5 : -along)};

        assert_band(uv_a);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_band_has_the_corners_of_its_image);
}
