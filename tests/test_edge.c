/* edge: the pixel of a band's border over one place of its line. The truth: the six
 * derivatives of (M3) at that pixel. */
#include <math.h>
#include <string.h>

#include "rc_edge.h"
#include "test_bands.h"

static rigcal_edge edge;

/* The place of the line at this share of the angle between the ends of the depth range. */
static void place_of(rigcal_real p[2], const rigcal_band *band, double share)
{
    rigcal_real ends[2][2];
    rc_band_ends(ends, band);
    const double far = atan2(D(ends[0][1]), D(ends[0][0]));
    const double near = atan2(D(ends[1][1]), D(ends[1][0]));
    const double angle = far + share * (near - far);

    p[0] = RC(cos(angle));
    p[1] = RC(sin(angle));
}

static int is_in_image(const rigcal_camera *camera, const rigcal_real uv[2])
{
    return uv[0] >= 0 && uv[1] >= 0 && uv[0] < RC(camera->width) &&
           uv[1] < RC(camera->height);
}

/* The pixels of the two borders over p must be k standard deviations from the line, one on
 * each side. The last correction is at most 1e-5 px, and it leaves some hundredths of
 * that. Returns how many are in the image, all of which the lens sees. */
static int look_at_place(const test_bands *scene, const rigcal_real p[2])
{
    const double h = TOL(1e-6, 1e-3);
    double s[2] = {0, 0};
    int found = 0;
    test_ray a, b;

    TEST_ASSERT_TRUE(test_ray_of(&a, &scene->a, scene->uv_a));
    for (int side = 0; side < 2; side++) {
        rigcal_real uv[2], J[6];
        test_band_truth truth;

        if (!rc_edge_begin_side(&edge, side, p)) {
            break;
        }
        if (rc_edge_find(uv, J, &edge, p) != RIGCAL_OK || !is_in_image(&scene->b, uv)) {
            continue;
        }
        TEST_ASSERT_TRUE(test_ray_of(&b, &scene->b, uv));
        test_band_look(&truth, scene, &a, &b);
        ASSERT_NEAR(scene->pair.k, sqrt(truth.chi2), TOL(2e-6, 2e-2));
        s[side] = truth.s;
        found++;
        for (int row = 0; row < 2; row++) { /* along the height, by differences */
            rigcal_real low[2], high[2];
            double n[3], J_row[3];

            test_to_double(n, edge.normal, 3);
            test_to_double(J_row, &J[3 * row], 3);
            ASSERT_STATUS(RIGCAL_OK, rc_edge_pixel(low, &edge, p, RC(D(edge.height) - h)));
            ASSERT_STATUS(RIGCAL_OK, rc_edge_pixel(high, &edge, p, RC(D(edge.height) + h)));
            ASSERT_NEAR((D(high[row]) - D(low[row])) / (2 * h), test_dot(J_row, n),
                        TOL(1e-3, 0.05) * (1 + test_norm(J_row)));
        }
    }
    TEST_ASSERT_TRUE(!(s[0] * s[1] > 0));
    return found;
}

static void test_a_border_is_k_standard_deviations_from_the_line(void)
{
    enum { SCENES = 400, PLACES = 5 };
    int found = 0, scenes = 0;

    for (int i = 0; i < TEST_TRIALS(SCENES); i++) {
        test_rng rng = test_seed(4800 + (uint64_t)i);
        test_bands scene;
        rigcal_band band;

        memset(&edge, 0x55, sizeof edge);
        test_bands_random(&scene, &rng, i % TEST_LENS_KINDS, 96);
        if (rigcal_band_make(&band, &scene.pair, scene.uv_a) != RIGCAL_OK ||
            !rc_edge_begin(&edge, &band)) {
            continue;
        }
        scenes++;
        for (int k = 0; k < PLACES; k++) {
            rigcal_real p[2];

            place_of(p, &band, test_uniform(&rng, 0, 1));
            found += look_at_place(&scene, p);
        }
    }
    TEST_ASSERT_TRUE(found > scenes);
}

/* ---- known by hand --------------------------------------------------------- */

/* Camera b is 1 to the right of a, and both are the same pinhole. So the line of pixel (40,
 * 30) is its row. sigma_b is the only noise: the borders are about k sigma_b = 2 rows
 * away. */
static void make_lines(rigcal_band *band, int is_column)
{
    const rigcal_real uv_a[2] = {40, 30};
    rigcal_camera camera;
    rigcal_match_pair pair;

    test_bands_beside(&pair, &camera, 0.5, 4);
    pair.near_a = 2;
    if (is_column) { /* camera b is below a */
        pair.b_from_a.t[1] = pair.b_from_a.t[0];
        pair.b_from_a.t[0] = 0;
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(band, &pair, uv_a));
    TEST_ASSERT_TRUE(rc_edge_begin(&edge, band));
}

static void make_rows(rigcal_band *band)
{
    make_lines(band, 0);
}

/* y of the border at x of (x, y, 1). Its distance s = y / r is 0.04 of the slope of s,
 * where r is the length of (x, y, 1). */
static double border_of_row(double x)
{
    double y = 0;

    for (int i = 0; i < 20; i++) {
        const double r2 = x * x + y * y + 1;

        y = 0.04 * hypot(1 - y * y / r2, x * y / r2);
    }
    return y;
}

static void test_the_borders_of_a_row_are_beside_it(void)
{
    rigcal_band band;

    make_rows(&band);
    for (int side = 0; side < 2; side++) {
        rigcal_real p[2], uv[2], J[6], line[2], again[2];

        place_of(p, &band, 0.5);
        TEST_ASSERT_TRUE(rc_edge_begin_side(&edge, side, p));
        ASSERT_STATUS(RIGCAL_OK, rc_edge_find(uv, J, &edge, p));
        ASSERT_STATUS(RIGCAL_OK, rc_edge_pixel(line, &edge, p, 0));
        ASSERT_STATUS(RIGCAL_OK, rc_edge_pixel(again, &edge, p, edge.height));
        ASSERT_NEAR(30, line[1], TOL(1e-9, 1e-3));
        ASSERT_NEAR(50 * border_of_row(((double)uv[0] - 40) / 50), fabs((double)uv[1] - 30),
                    TOL(1e-6, 2e-3));
        ASSERT_NEAR(uv[0], again[0], TOL(1e-4, 5e-2));
        ASSERT_NEAR(uv[1], again[1], TOL(1e-4, 5e-2));
        TEST_ASSERT_TRUE((edge.height > 0) == (side == 0));
    }
}

static void test_a_border_that_the_lens_does_not_see_leaves_the_edge(void)
{
    rigcal_band band;
    rigcal_real p[2], uv[2], J[6];

    make_rows(&band);
    place_of(p, &band, 0.5);
    edge.slope2 = TEST_NAN; /* a side begins without what was before */
    TEST_ASSERT_TRUE(rc_edge_begin_side(&edge, 0, p));
    ASSERT_STATUS(RIGCAL_OK, rc_edge_find(uv, J, &edge, p));
    const rigcal_edge before = edge;
    const rigcal_real behind[2] = {-p[0], -p[1]};

    ASSERT_STATUS(RIGCAL_ERR_NO_RAY, rc_edge_find(uv, J, &edge, behind));
    TEST_ASSERT_EQUAL_MEMORY(&before, &edge, sizeof edge);
    TEST_ASSERT_FALSE(rc_edge_begin_side(&edge, 0, behind));
    TEST_ASSERT_FALSE(rc_edge_begin_side(&edge, 1, behind));
}

/* The lens folds at 0.7 of its focal length. Where k sigma_b reaches beyond that, the
 * border is the fold. In the image it is at 0.7 (1 - 1/3) of the focal length from the
 * centre, whether the line is a row or a column. */
static void test_where_the_lens_folds_before_the_border_is_the_fold(void)
{
    const double far = 50 * 0.7 * 2 / 3;
    rigcal_band band;

    for (int way = 0; way < 4; way++) {
        const int side = way % 2;

        make_lines(&band, way / 2);
        band.sigma_b = 8;
        band.camera_b.k1 = RC(-1 / (3 * 0.49));
        TEST_ASSERT_TRUE(rc_edge_begin(&edge, &band));
        for (int k = 0; k < 7; k++) {
            rigcal_real p[2] = {RC(cos(0.1 * k)), RC(sin(0.1 * k))}, uv[2], J[6];

            TEST_ASSERT_TRUE(rc_edge_begin_side(&edge, side, p));
            ASSERT_STATUS(RIGCAL_OK, rc_edge_find(uv, J, &edge, p));
            ASSERT_NEAR(far, hypot((double)uv[0] - 40, (double)uv[1] - 30), 0.1);
        }
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_border_is_k_standard_deviations_from_the_line);
    RUN_TEST(test_the_borders_of_a_row_are_beside_it);
    RUN_TEST(test_a_border_that_the_lens_does_not_see_leaves_the_edge);
    RUN_TEST(test_where_the_lens_folds_before_the_border_is_the_fold);
}
