/* translation: t for a known rotation (10a), (10b), (16). */
#include <math.h>
#include <string.h>

#include "test_equations.h"
#include "vectors_scenes.h"
#include "vectors_translation.h"

static const rigcal_real IDENTITY[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

/* ---- translation (10a), (10b), (16) -------------------------------------- */

/* One point ahead and another one unit to its right, seen at x = 0 and 1/2: they are at a
 * depth of 2. Their y is the same, so (10b) is left out. */
static void test_a_translation_on_paper(void)
{
    static const rigcal_bearing s[2] = {{{3, 4, 0}, {0, 0, 1}}, {{4, 4, 0}, {1, 0, 2}}};
    static const double expected[3] = {-3, -4, 2};
    rigcal_pair pair;
    rigcal_real t[3];

    ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&pair, s, 2, 0, 1));
    ASSERT_STATUS(RIGCAL_OK, rigcal_translation_from_pairs(t, IDENTITY, s, 2, &pair, 1));
    ASSERT_ARRAY_NEAR(expected, t, 3, TOL(1e-15, 1e-6));
    ASSERT_STATUS(RIGCAL_OK, rigcal_translation_least_squares(t, IDENTITY, s, 2));
    ASSERT_ARRAY_NEAR(expected, t, 3, TOL(1e-14, 1e-5));
}

/* All rays are near the axis: whether they are the same is judged by their own size. */
static void test_a_translation_through_a_telescope(void)
{
    const rigcal_real depth =
        RC(TOL(1e17, 1e9)); /* rays less than the rounding of 1 apart */
    const rigcal_bearing s[2] = {{{3, 4, 0}, {0, 0, 1}}, {{4, 4, 0}, {1, 0, depth}}};
    const double expected[3] = {-3, -4, D(depth)};
    rigcal_real t[3];

    ASSERT_STATUS(RIGCAL_OK, rigcal_translation_least_squares(t, IDENTITY, s, 2));
    ASSERT_NEAR(expected[0], t[0], 1e-3);
    ASSERT_NEAR(expected[1], t[1], 1e-3);
    ASSERT_NEAR(1, D(t[2]) / expected[2], TOL(1e-12, 1e-5));
}

/* At the rotation of the image, and at a rotation far from it. Depths are 3 to 6, the image
 * is about 0.2, and coordinates are up to 3: errors grow about 15 times. */
static void test_translations_are_the_oracles(void)
{
    const double tol = 15 * TOL(1e-13, 1e-5);

    for (int k = 0; k < SCENE_ROWS; k++) {
        double at[2][3];
        rigcal_bearing s[6];
        rigcal_pair pairs[15];

        test_golden_scene(s, at[0], at[1], k);
        test_golden_pairs(pairs, s, 6);
        for (int i = 0; i < 2; i++) {
            rigcal_real R[9], t[3];

            test_rotation_of(R, at[i]);
            ASSERT_STATUS(RIGCAL_OK, rigcal_translation_from_pairs(t, R, s, 4, pairs, 6));
            ASSERT_ARRAY_NEAR(TRANSLATION[k] + 3 * i, t, 3, tol);
            ASSERT_STATUS(RIGCAL_OK, rigcal_translation_least_squares(t, R, s, 6));
            ASSERT_ARRAY_NEAR(TRANSLATION[k] + 6 + 3 * i, t, 3, tol);
        }
    }
}

static void test_translations_of_perfect_images_are_true(void)
{
    test_rng rng = test_seed(46);

    for (int trial = 0; trial < TEST_TRIALS(150); trial++) {
        const int n = 3 + trial % 20;
        test_scene scene;
        rigcal_bearing s[22];
        rigcal_pair pairs[88];
        size_t n_pairs;
        rigcal_real R[9], t[3];

        test_scene_random(&scene, &rng, n, (test_shape)(trial % 3));
        test_bearings(s, &scene);
        for (int i = 0; i < n; i++) { /* rays of any length */
            const double length = test_uniform(&rng, 0.1, 9);

            for (int k = 0; k < 3; k++) {
                s[i].ray[k] *= RC(length);
            }
        }
        test_to_real(R, scene.R, 9);
        ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_choose(pairs, 88, &n_pairs, s, (size_t)n));
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_translation_from_pairs(t, R, s, (size_t)n, pairs, n_pairs));
        /* The error of a pair's equation is the smaller, the more its coordinates
         * differ. */
        ASSERT_ARRAY_NEAR(scene.t, t, 3, TOL(1e-10, 0.05));
        ASSERT_STATUS(RIGCAL_OK, rigcal_translation_least_squares(t, R, s, (size_t)n));
        ASSERT_ARRAY_NEAR(scene.t, t, 3, TOL(1e-11, 5e-3));
    }
}

/* For a doubled target the camera is twice as far away. */
static void test_translation_scales_with_the_target(void)
{
    double ypr[3], wrong[3], t_once[3];
    rigcal_bearing s[6];
    rigcal_real R[9], t[3];

    test_golden_scene(s, ypr, wrong, 9);
    test_rotation_of(R, wrong);
    ASSERT_STATUS(RIGCAL_OK, rigcal_translation_least_squares(t, R, s, 6));
    test_to_double(t_once, t, 3);
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < 3; k++) {
            s[i].X_w[k] *= 1024;
        }
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_translation_least_squares(t, R, s, 6));
    for (int k = 0; k < 3; k++) {
        ASSERT_NEAR(1024 * t_once[k], t[k], TOL(1e-9, 0.5));
    }
}

static void test_a_translation_far_from_the_origin_keeps_its_digits(void)
{
    test_rng rng = test_seed(47);
    const double far[3] = {512000, 5154500, 1200};
    double back[3];
    test_scene scene;
    rigcal_bearing s[6];
    rigcal_real R[9], t[3];

    if (RIGCAL_USE_FLOAT) {
        return; /* the rounding is half a metre, so no digits are left */
    }
    test_scene_random(&scene, &rng, 6, TEST_GENERAL);
    test_bearings(s, &scene);
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < 3; k++) {
            s[i].X_w[k] += RC(far[k]);
        }
    }
    test_to_real(R, scene.R, 9);
    ASSERT_STATUS(RIGCAL_OK, rigcal_translation_least_squares(t, R, s, 6));
    /* Seen from the target again, t + R far is the camera's own. The rounding is a
     * nanometre, times distance over size. */
    test_apply(back, scene.R, far, NULL);
    for (int k = 0; k < 3; k++) {
        ASSERT_NEAR(scene.t[k], D(t[k]) + back[k], 2e-7);
    }
}

static void test_rays_that_fix_no_translation_are_refused(void)
{
    rigcal_bearing s[3] = {{{0, 0, 0}, {RC(0.1), RC(0.2), 1}},
                           {{1, 0, 0}, {RC(0.2), RC(0.4), 2}},
                           {{0, 1, 0}, {RC(0.1), RC(0.2), 1}}};
    rigcal_pair pairs[2] = {test_pair_of(1, 0, 0, 0, 1, 0), test_pair_of(0, 1, 0, 1, 0, 0)};
    rigcal_real t[3];

    pairs[1].j = 2;
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, t,
                   rigcal_translation_from_pairs(t, IDENTITY, s, 3, pairs, 2));
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, t,
                   rigcal_translation_least_squares(t, IDENTITY, s, 3));
    s[1].ray[1] = 1; /* now they differ in y, which is enough */
    ASSERT_STATUS(RIGCAL_OK, rigcal_translation_from_pairs(t, IDENTITY, s, 3, pairs, 2));
    ASSERT_STATUS(RIGCAL_OK, rigcal_translation_least_squares(t, IDENTITY, s, 3));
}

/* Directions of rays are compared with the largest of them, and that one with 1: two rays
 * are the same up to rounding squared. 2 h^2 is exactly the limit for h = (8 eps)^2. */
static void test_the_least_difference_of_rays(void)
{
    const rigcal_real h = RC(64 * TOL(pow(2, -104), pow(2, -46)));
    rigcal_bearing s[2] = {{{0, 0, 0}, {0, 0, 1}}, {{1, 0, 0}, {0, 0, 1}}};
    rigcal_pair pair = test_pair_of(1, 0, 0, 1, 0, 0);
    rigcal_real t[3];

    s[1].ray[0] = 2 * h;
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, t,
                   rigcal_translation_least_squares(t, IDENTITY, s, 2));
    s[1].ray[0] = 4 * h;
    ASSERT_STATUS(RIGCAL_OK, rigcal_translation_least_squares(t, IDENTITY, s, 2));
    ASSERT_NEAR(1, D(t[2]) * D(s[1].ray[0]), TOL(1e-14, 1e-5));
    /* a pair divides by the difference: it must be more than 1e-9 */
    s[1].ray[0] = RC(TOL(1e-9, 1e-4));
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, t,
                   rigcal_translation_from_pairs(t, IDENTITY, s, 2, &pair, 1));
    s[1].ray[0] *= 2;
    ASSERT_STATUS(RIGCAL_OK, rigcal_translation_from_pairs(t, IDENTITY, s, 2, &pair, 1));
    ASSERT_NEAR(1, D(t[2]) * D(s[1].ray[0]), TOL(1e-14, 1e-5));
}

static void assert_both_translations_refuse(rigcal_status status, const rigcal_real R[9],
                                            const rigcal_bearing s[], size_t n,
                                            const rigcal_pair pairs[])
{
    rigcal_real t[3];

    ASSERT_REFUSED(status, t, rigcal_translation_from_pairs(t, R, s, n, pairs, 3));
    ASSERT_REFUSED(status, t, rigcal_translation_least_squares(t, R, s, n));
}

static void test_arguments_of_the_translation_are_checked(void)
{
    double ypr[3], wrong[3];
    rigcal_bearing good[6], s[6];
    rigcal_pair pairs[15], bad[3];
    rigcal_real M[9], t[3];

    test_golden_scene(good, ypr, wrong, 0);
    test_golden_pairs(pairs, good, 3);
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_translation_from_pairs(NULL, IDENTITY, good, 6, pairs, 3));
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_translation_least_squares(NULL, IDENTITY, good, 6));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, t,
                   rigcal_translation_from_pairs(t, IDENTITY, good, 6, NULL, 3));
    assert_both_translations_refuse(RIGCAL_ERR_NULL, NULL, good, 6, pairs);
    assert_both_translations_refuse(RIGCAL_ERR_NULL, IDENTITY, NULL, 6, pairs);
    assert_both_translations_refuse(RIGCAL_ERR_TOO_FEW, IDENTITY, good, 1, pairs);
    assert_both_translations_refuse(RIGCAL_ERR_TOO_FEW, IDENTITY, good, 0, pairs);
    assert_both_translations_refuse(RIGCAL_ERR_RANGE, IDENTITY, good, ((size_t)1 << 28) + 1,
                                    pairs);
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, t,
                   rigcal_translation_from_pairs(t, IDENTITY, good, 6, pairs, 0));
    for (int k = 0; k < 9; k++) {
        memcpy(M, IDENTITY, sizeof M);
        M[k] = TEST_NAN;
        assert_both_translations_refuse(RIGCAL_ERR_NOT_FINITE, M, good, 6, pairs);
        M[k] = RC(0.3);
        assert_both_translations_refuse(RIGCAL_ERR_ROTATION, M, good, 6, pairs);
    }
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            memcpy(s, good, sizeof s);
            s[i].X_w[k] = TEST_INF;
            assert_both_translations_refuse(RIGCAL_ERR_NOT_FINITE, IDENTITY, s, 6, pairs);
            memcpy(s, good, sizeof s);
            s[i].ray[k] = TEST_NAN;
            assert_both_translations_refuse(RIGCAL_ERR_NOT_FINITE, IDENTITY, s, 6, pairs);
        }
        memcpy(s, good, sizeof s);
        s[i].ray[0] = s[i].ray[1] = s[i].ray[2] = 0;
        assert_both_translations_refuse(RIGCAL_ERR_RANGE, IDENTITY, s, 6, pairs);
        s[i].ray[1] = 1;
        assert_both_translations_refuse(RIGCAL_ERR_WIDE_RAY, IDENTITY, s, 6, pairs);
        memcpy(bad, pairs, sizeof bad);
        bad[i].i = 6;
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, t,
                       rigcal_translation_from_pairs(t, IDENTITY, good, 6, bad, 3));
        bad[i].i = 0;
        bad[i].j = 6;
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, t,
                       rigcal_translation_from_pairs(t, IDENTITY, good, 6, bad, 3));
        bad[i].j = -1;
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, t,
                       rigcal_translation_from_pairs(t, IDENTITY, good, 6, bad, 3));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_translation_on_paper);
    RUN_TEST(test_a_translation_through_a_telescope);
    RUN_TEST(test_translations_are_the_oracles);
    RUN_TEST(test_translations_of_perfect_images_are_true);
    RUN_TEST(test_translation_scales_with_the_target);
    RUN_TEST(test_a_translation_far_from_the_origin_keeps_its_digits);
    RUN_TEST(test_rays_that_fix_no_translation_are_refused);
    RUN_TEST(test_the_least_difference_of_rays);
    RUN_TEST(test_arguments_of_the_translation_are_checked);
}
