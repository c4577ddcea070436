/* match: the band as a curve, and the candidates that are in it. */
#include <math.h>
#include <string.h>

#include "rc_real.h"
#include "test_bands.h"

enum { CANDIDATES = 300, ROOM = 12 };

static test_bands scene;
static rigcal_band band;
static rigcal_real uv[2 * CANDIDATES];
static rigcal_ray rays[CANDIDATES];

/* A band, and candidates all over the image of b. */
static void make(uint64_t seed)
{
    for (;; seed += 1000) {
        test_rng rng = test_seed(seed);

        test_bands_random(&scene, &rng, (int)(seed % TEST_LENS_KINDS), 160);
        for (int i = 0; i < CANDIDATES; i++) {
            uv[2 * i] = RC(test_uniform(&rng, 0, scene.b.width - 1));
            uv[2 * i + 1] = RC(test_uniform(&rng, 0, scene.b.height - 1));
            ASSERT_STATUS(RIGCAL_OK, rigcal_ray_make(&rays[i], &scene.b, &uv[2 * i]));
        }
        if (rigcal_band_make(&band, &scene.pair, scene.uv_a) == RIGCAL_OK) {
            return;
        }
    }
}

/* ---- candidates ------------------------------------------------------------ */

static void test_those_inside_come_best_first(void)
{
    int most = 0;

    for (int trial = 0; trial < TEST_TRIALS(40); trial++) {
        static rigcal_match matches[CANDIDATES];
        size_t written, inside, n = 0;
        int32_t at_fault = 7;

        make(4400 + (uint64_t)trial);
        ASSERT_STATUS(RIGCAL_OK, rigcal_band_search(matches, CANDIDATES, &written, &inside,
                                                    &at_fault, &band, uv, CANDIDATES));
        TEST_ASSERT_EQUAL_INT32(-1, at_fault);
        TEST_ASSERT_EQUAL_UINT64(written, inside);
        for (size_t k = 0; k < written; k++) {
            rigcal_match alone;

            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_band_test(&alone, &band, &uv[2 * matches[k].index]));
            alone.index = matches[k].index;
            TEST_ASSERT_TRUE(alone.is_inside);
            TEST_ASSERT_EQUAL_MEMORY(&alone, &matches[k], sizeof alone);
            TEST_ASSERT_TRUE(k == 0 || matches[k - 1].score <= matches[k].score);
        }
        for (int i = 0; i < CANDIDATES; i++) {
            rigcal_match alone;

            n +=
                rigcal_band_test(&alone, &band, &uv[2 * i]) == RIGCAL_OK && alone.is_inside;
        }
        TEST_ASSERT_EQUAL_UINT64(n, inside);
        most = inside > (size_t)most ? (int)inside : most;
    }
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || most > ROOM); /* with few trials there may be few
                                                         inside */
}

static void test_where_room_is_short_the_best_stay(void)
{
    for (int trial = 0; trial < TEST_TRIALS(40); trial++) {
        static rigcal_match all[CANDIDATES];
        rigcal_match few[ROOM];
        size_t n_all, n_few, inside, none = 9;

        make(4400 + (uint64_t)trial);
        ASSERT_STATUS(RIGCAL_OK, rigcal_band_search(all, CANDIDATES, &n_all, &inside, NULL,
                                                    &band, uv, CANDIDATES));
        for (size_t room = 1; room <= ROOM; room += 5) {
            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_band_search_rays(few, room, &n_few, &inside, NULL, &band,
                                                  rays, CANDIDATES));
            TEST_ASSERT_EQUAL_UINT64(n_all, inside);
            TEST_ASSERT_EQUAL_UINT64(n_all < room ? n_all : room, n_few);
            TEST_ASSERT_TRUE(n_few == 0 || memcmp(all, few, n_few * sizeof *few) == 0);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_band_search(NULL, 0, &none, &inside, NULL, &band,
                                                    uv, CANDIDATES));
        TEST_ASSERT_EQUAL_UINT64(0, none);
        TEST_ASSERT_EQUAL_UINT64(n_all, inside);
    }
}

/* Pinholes side by side, with noise in b alone. The pixel of a is (40, 20). */
static void make_beside(void)
{
    static rigcal_camera camera;
    const rigcal_real uv_a[2] = {40, 20};

    test_bands_beside(&scene.pair, &camera, 0.5, 2);
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &scene.pair, uv_a));
}

/* If b's pixel has the only noise, all widths are equal and the nearest candidate is the
 * best. */
static void test_the_nearest_to_the_line_is_best(void)
{
    static const rigcal_real at[8] = {30, RC(20.9), 25, RC(20.2), 20, RC(22), 28, RC(19.5)};
    rigcal_match matches[4];
    size_t written, inside;

    make_beside();
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_band_search(matches, 4, &written, &inside, NULL, &band, at, 4));
    TEST_ASSERT_EQUAL_UINT64(3, written);
    TEST_ASSERT_EQUAL_INT32(1, matches[0].index);
    TEST_ASSERT_EQUAL_INT32(3, matches[1].index);
    TEST_ASSERT_EQUAL_INT32(0, matches[2].index);
    ASSERT_NEAR(0.2, fabs(D(matches[0].distance_px)), 1e-3); /* to first order */
    TEST_ASSERT_TRUE(matches[0].distance_px * matches[1].distance_px < 0);
    ASSERT_NEAR(1, matches[0].half_width_px, TOL(1e-6, 1e-4));
}

static void test_of_equal_candidates_the_first_stays(void)
{
    static const rigcal_real at[4] = {25, RC(20.2), 25, RC(20.2)};
    rigcal_match match;
    size_t written, inside;

    make_beside();
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_band_search(&match, 1, &written, &inside, NULL, &band, at, 2));
    TEST_ASSERT_EQUAL_UINT64(2, inside);
    TEST_ASSERT_EQUAL_INT32(0, match.index);
}

static void test_a_candidate_that_is_no_number_is_named(void)
{
    rigcal_match matches[2];
    size_t written, inside;
    int32_t at_fault;

    make(4400);
    uv[9] = TEST_NAN;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE,
                  rigcal_band_search(matches, 2, &written, &inside, &at_fault, &band, uv,
                                     CANDIDATES));
    TEST_ASSERT_EQUAL_INT32(4, at_fault);
    rays[17].m[1] = RC(3);
    ASSERT_STATUS(RIGCAL_ERR_RANGE,
                  rigcal_band_search_rays(matches, 2, &written, &inside, &at_fault, &band,
                                          rays, CANDIDATES));
    TEST_ASSERT_EQUAL_INT32(17, at_fault);
}

/* Candidates and room are counted up to 2^28 where a size_t is wide enough. */
static void test_there_is_room_for_at_most_2_to_the_28_matches(void)
{
    static const rigcal_real at[2] = {25, RC(20.2)};
    const size_t most = RC_COUNT_MAX;
    rigcal_match match;
    size_t written, inside;

    if (RC_COUNT_MAX == SIZE_MAX) {
        TEST_IGNORE_MESSAGE("a size_t of 16 bits has no number that is too large");
    }
    make_beside();
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_band_search(&match, most, &written, &inside, NULL, &band, at, 1));
    TEST_ASSERT_EQUAL_UINT64(1, written);
    ASSERT_REFUSED(
        RIGCAL_ERR_RANGE, match,
        rigcal_band_search(&match, most + 1, &written, &inside, NULL, &band, at, 1));
    ASSERT_REFUSED(
        RIGCAL_ERR_RANGE, match,
        rigcal_band_search(&match, 1, &written, &inside, NULL, &band, at, most + 1));
}

/* ---- the curve ------------------------------------------------------------- */

/* To first order, its points are on the line, and its borders at k standard deviations. */
static void test_the_curve_is_the_line_and_its_borders_the_band(void)
{
    int n_points = 0;

    for (int trial = 0; trial < TEST_TRIALS(60); trial++) {
        rigcal_band_point points[9];
        size_t n;

        make(4500 + (uint64_t)trial);
        if (rigcal_band_curve(points, 9, &n, &band) == RIGCAL_ERR_OUTSIDE) {
            continue;
        }
        for (size_t i = 0; i < n; i++) {
            const rigcal_band_point *const p = &points[i];
            rigcal_match match;

            ASSERT_NEAR(1, hypot(D(p->across[0]), D(p->across[1])), TOL(1e-12, 1e-5));
            TEST_ASSERT_TRUE(i == 0 || p->depth_a > points[i - 1].depth_a ||
                             D(p->depth_a) <= 0);
            if (rigcal_band_test(&match, &band, p->uv) != RIGCAL_OK) {
                continue; /* at infinity, or so far out that the lens has no ray */
            }
            ASSERT_NEAR(0, match.distance_px, TOL(1e-6, 2e-2));
            ASSERT_NEAR(D(match.half_width_px), p->half_width,
                        TOL(1e-6, 1e-2) * D(p->half_width));
            for (int side = -1; side <= 1; side += 2) {
                const double off = side * 0.5 * D(p->half_width);
                const rigcal_real half[2] = {RC(D(p->uv[0]) + off * D(p->across[0])),
                                             RC(D(p->uv[1]) + off * D(p->across[1]))};

                if (D(p->half_width) > 0.01 * D(scene.b.fx) ||
                    rigcal_band_test(&match, &band, half) != RIGCAL_OK) {
                    continue; /* too wide for first order */
                }
                ASSERT_NEAR(off, match.distance_px, 0.05 * fabs(off) + TOL(0, 2e-2));
                n_points++;
            }
        }
    }
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || n_points > 60); /* with few trials there may be
                                                           none */
}

static void test_the_curve_runs_from_near_to_far(void)
{
    rigcal_band_point points[5];
    size_t n = 0;

    for (uint64_t seed = 4600; n < 5 || !(band.far_a > 0); seed++) {
        make(seed);
        if (rigcal_band_curve(points, 5, &n, &band) != RIGCAL_OK) {
            n = 0;
        }
    }
    ASSERT_NEAR(D(band.near_a), points[0].depth_a, TOL(1e-9, 1e-3) * D(band.near_a));
    ASSERT_NEAR(D(band.far_a), points[4].depth_a, TOL(1e-9, 1e-3) * D(band.far_a));
}

/* Cameras side by side see what is infinitely far at the same pixel. */
static void test_a_curve_to_infinity_ends_at_the_ray(void)
{
    rigcal_band_point points[3];
    size_t n;

    make_beside();
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_curve(points, 3, &n, &band));
    TEST_ASSERT_GREATER_THAN_size_t(0, n);
    ASSERT_NEAR(40, points[n - 1].uv[0], TOL(1e-9, 1e-4));
    ASSERT_NEAR(20, points[n - 1].uv[1], TOL(1e-9, 1e-4));
    ASSERT_NEAR(0, points[n - 1].depth_a, 0);
}

/* If two places are far and near, often only one is in the image. */
static void test_a_curve_may_have_one_point(void)
{
    int alone = 0;

    for (uint64_t seed = 4500; seed < 4600; seed++) {
        rigcal_band_point points[2];
        size_t n = 0;

        make(seed);
        if (rigcal_band_curve(points, 2, &n, &band) == RIGCAL_OK) {
            TEST_ASSERT_TRUE(n == 1 || n == 2);
            alone += n == 1;
        } else {
            TEST_ASSERT_EQUAL_size_t(0, n);
        }
    }
    TEST_ASSERT_GREATER_THAN_INT(0, alone);
}

/* If a moves along its ray, the near end is behind b and the far end is the epipole.
 * Halfway between the two there is no direction. */
static void test_a_curve_along_the_baseline_has_no_point(void)
{
    rigcal_band_point points[3];
    size_t n = 7;

    memset(&band, 0, sizeof band);
    band.camera_b = test_pinhole();
    band.ray[2] = band.towards[0] = band.line[1] = 1;
    band.along = RC(TOL(-1e20, -1e8));
    band.across = RC(TOL(1e-307, 1e-37)); /* nothing beside `along` */
    band.near_a = band.sigma_b = band.k = 1;
    ASSERT_REFUSED(RIGCAL_ERR_OUTSIDE, points, rigcal_band_curve(points, 3, &n, &band));
    TEST_ASSERT_EQUAL_size_t(7, n);
}

TEST_MAIN()
{
    RUN_TEST(test_those_inside_come_best_first);
    RUN_TEST(test_where_room_is_short_the_best_stay);
    RUN_TEST(test_the_nearest_to_the_line_is_best);
    RUN_TEST(test_of_equal_candidates_the_first_stays);
    RUN_TEST(test_a_candidate_that_is_no_number_is_named);
    RUN_TEST(test_there_is_room_for_at_most_2_to_the_28_matches);
    RUN_TEST(test_the_curve_is_the_line_and_its_borders_the_band);
    RUN_TEST(test_the_curve_runs_from_near_to_far);
    RUN_TEST(test_a_curve_to_infinity_ends_at_the_ray);
    RUN_TEST(test_a_curve_may_have_one_point);
    RUN_TEST(test_a_curve_along_the_baseline_has_no_point);
}
