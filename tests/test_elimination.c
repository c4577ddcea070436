/* elimination: the residual of a pair (13), the eliminated angle (14), (15), the
 * residual over three angles (5). */
#include <math.h>
#include <string.h>

#include "test_equations.h"
#include "vectors_elimination_all.h"
#include "vectors_elimination_two.h"
#include "vectors_pairs.h"
#include "vectors_scenes.h"
#include "vectors_translation.h"

static const rigcal_real IDENTITY[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

/* ---- the residual of a pair ------------------------------------------------ */

static void test_pairs_and_their_residuals_are_the_oracles(void)
{
    for (int k = 0; k < SCENE_ROWS; k++) {
        const double *v = PAIR_TERMS[k];
        double ypr[3], wrong[3];
        rigcal_bearing s[6];
        rigcal_pair pair;
        rigcal_real R[9], e;

        test_golden_scene(s, ypr, wrong, k);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_pair_make(&pair, s, 6, (int32_t)v[0], (int32_t)v[1]));
        ASSERT_ARRAY_NEAR(v + 2, pair.normal, 3, TOL_FORMULA);
        ASSERT_ARRAY_NEAR(v + 5, pair.offset, 3, TOL_FORMULA);
        test_rotation_of(R, wrong);
        ASSERT_STATUS(RIGCAL_OK, rigcal_pair_residual(&e, &pair, R));
        ASSERT_NEAR(v[8], e, TOL_FORMULA);
    }
}

static void test_the_residual_vanishes_at_the_true_rotation(void)
{
    test_rng rng = test_seed(31);

    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        test_scene scene;
        rigcal_bearing s[8];
        rigcal_real R[9];

        test_scene_random(&scene, &rng, 8, (test_shape)(trial % 3));
        test_bearings(s, &scene);
        test_to_real(R, scene.R, 9);
        for (int i = 1; i < 8; i++) {
            const double apart =
                hypot(scene.xy[i][0] - scene.xy[0][0], scene.xy[i][1] - scene.xy[0][1]);
            rigcal_pair pair;
            rigcal_real e;

            if (apart < 0.01) {
                continue;
            }
            ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&pair, s, 8, 0, i));
            ASSERT_STATUS(RIGCAL_OK, rigcal_pair_residual(&e, &pair, R));
            /* The plane of the rays, and the direction, are known to rounding divided by
             * their distance. Coordinates are up to 3 for a size of 1. */
            ASSERT_NEAR(0, e, TOL(2e-15, 1e-6) / apart);
        }
    }
}

static void test_a_residual_of_what_is_no_pair_or_rotation_is_refused(void)
{
    const rigcal_pair good = test_pair_of(1, 0, 0, 0, 1, 0);
    rigcal_real M[9], e;

    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_pair_residual(NULL, &good, IDENTITY));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, e, rigcal_pair_residual(&e, NULL, IDENTITY));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, e, rigcal_pair_residual(&e, &good, NULL));
    for (int k = 0; k < 3; k++) {
        rigcal_pair bad = good;

        bad.normal[k] = TEST_NAN;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, e, rigcal_pair_residual(&e, &bad, IDENTITY));
        bad = good;
        bad.offset[k] = TEST_INF;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, e, rigcal_pair_residual(&e, &bad, IDENTITY));
    }
    for (int k = 0; k < 4; k++) { /* not of unit length */
        static const double lengths[4][2] = {{2, 1}, {1, -1.5}, {0.9, 1}, {1, 0}};
        const rigcal_pair bad = test_pair_of(lengths[k][0], 0, 0, 0, lengths[k][1], 0);
        const rigcal_real angles[2] = {0, 0};
        rigcal_real pqk[3];

        ASSERT_REFUSED(RIGCAL_ERR_RANGE, e, rigcal_pair_residual(&e, &bad, IDENTITY));
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, pqk,
                       rigcal_pair_coefficients(pqk, &bad, RIGCAL_YAW, angles));
    }
    memcpy(M, IDENTITY, sizeof M);
    M[5] = TEST_NAN;
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, e, rigcal_pair_residual(&e, &good, M));
    M[5] = RC(0.5);
    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, e, rigcal_pair_residual(&e, &good, M));
}

/* ---- elimination (14), (15) ---------------------------------------------- */

static void test_coefficients_are_the_oracles(void)
{
    for (int k = 0; k < SCENE_ROWS; k++) {
        double ypr[3], wrong[3];
        rigcal_bearing s[6];
        rigcal_pair pair;

        test_golden_scene(s, ypr, wrong, k);
        ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&pair, s, 6, (int32_t)PAIR_TERMS[k][0],
                                                  (int32_t)PAIR_TERMS[k][1]));
        for (int which = RIGCAL_YAW; which <= RIGCAL_ROLL; which++) {
            rigcal_real angles[2], pqk[3];

            test_other_two(angles, wrong, which);
            ASSERT_STATUS(RIGCAL_OK, rigcal_pair_coefficients(pqk, &pair, which, angles));
            ASSERT_ARRAY_NEAR(PAIR_COEFFICIENTS[k] + 3 * which, pqk, 3, TOL_FORMULA);
        }
    }
}

/* p cos w + q sin w + k is the residual for every w, not only the true one. */
static void test_coefficients_give_the_residual_at_any_angle(void)
{
    test_rng rng = test_seed(44);

    for (int k = 0; k < 120; k++) {
        const int which = k % 3;
        double unused[3], ypr[3];
        rigcal_bearing s[6];
        rigcal_pair pair;
        rigcal_real angles[2], pqk[3], R[9], e;

        test_golden_scene(s, unused, unused, k % SCENE_ROWS);
        ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&pair, s, 6, 0, 1 + k % 5));
        for (int c = 0; c < 3; c++) {
            ypr[c] = test_uniform(&rng, -TEST_PI, TEST_PI);
        }
        test_rotation_of(R, ypr);
        test_other_two(angles, ypr, which);
        ASSERT_STATUS(RIGCAL_OK, rigcal_pair_coefficients(pqk, &pair, which, angles));
        ASSERT_STATUS(RIGCAL_OK, rigcal_pair_residual(&e, &pair, R));
        ASSERT_NEAR(e,
                    D(pqk[0]) * cos(ypr[which]) + D(pqk[1]) * sin(ypr[which]) + D(pqk[2]),
                    TOL(2e-15, 1e-6));
    }
}

/* Yaw is eliminated at pitch = roll = 0, where v = d: p = n1 d1 + n2 d2, q = n2 d1 - n1 d2,
 * k = n3 d3. Two pairs give 0.64 c = 0.36 and 0.64 s = 0.36. So c = s = 0.5625 and w = 45
 * degrees. A third pair has the residual 1 for any w. */
static void test_an_elimination_on_paper(void)
{
    const rigcal_pair pairs[3] = {
        test_pair_of(0.8, 0, 0.6, 0.8, 0, -0.6),
        test_pair_of(0, 0.8, 0.6, 0.8, 0, -0.6),
        test_pair_of(0, 0, 1, 0, 0, 1),
    };
    const rigcal_real angles[2] = {0, 0};
    const double tol = TOL(1e-15, 1e-6);
    rigcal_elimination out;

    ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_eliminate(&out, pairs, 3, 2, RIGCAL_YAW, angles));
    ASSERT_NEAR(0.5625, out.cosine, tol);
    ASSERT_NEAR(0.5625, out.sine, tol);
    ASSERT_NEAR(TEST_PI / 4, out.angle, tol);
    ASSERT_NEAR(1, out.condition, 4 * tol);
    ASSERT_NEAR(2 * 0.5625 * 0.5625 - 1, out.unit, 2 * tol);
    ASSERT_NEAR(1 + 1 - 2 * 0.5625 * 0.5625, out.residual, 4 * tol);

    /* With least squares the third pair is a row of zeros in A, which changes nothing. But
     * now the first two pairs count in the sum, each with 0.64 cos 45 - 0.36. */
    ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_eliminate(&out, pairs, 3, 0, RIGCAL_YAW, angles));
    ASSERT_NEAR(0.5625, out.cosine, tol);
    ASSERT_NEAR(0.5625, out.sine, tol);
    ASSERT_NEAR(2 - 2 * 0.5625 * 0.5625 + 2 * (0.64 * sqrt(0.5) - 0.36), out.residual,
                4 * tol);
}

/* A = [0.36 0; 0 0.48]: cond 4/3. */
static void test_the_condition_is_that_of_the_spectral_norm(void)
{
    const rigcal_pair pairs[3] = {
        test_pair_of(0.6, 0, 0.8, 0.6, 0, 0.8),
        test_pair_of(0, 0.6, 0.8, 0.8, 0, 0.6),
        test_pair_of(0, 1, 0, 0, 0.6, 0.8),
    };
    const rigcal_real angles[2] = {0, 0};
    rigcal_elimination out;

    ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_eliminate(&out, pairs, 3, 2, RIGCAL_YAW, angles));
    ASSERT_NEAR(4.0 / 3, out.condition, TOL(1e-14, 1e-5));
    /* With all three pairs the columns (0.36, 0, 0.6) and (0, 0.48, 0) are still
     * orthogonal. */
    ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_eliminate(&out, pairs, 3, 0, RIGCAL_YAW, angles));
    ASSERT_NEAR(sqrt(0.4896) / 0.48, out.condition, TOL(1e-14, 1e-5));
}

/* The offsets of three pairs with one normal are turned by 0, d and -d about the axis of
 * yaw. With 1/2 taken out, A^T A = diag(1 + 2 cos^2 d, 2 sin^2 d): cond(A) = sqrt(3/2) / d
 * for small d. The header says from which cond(A) on all pairs are refused. */
static void test_all_pairs_are_refused_from_the_stated_condition_on(void)
{
    const double conditions[2] = {TOL(1.6e7, 700), TOL(1.8e7, 750)}, h = sqrt(0.5);
    const rigcal_real angles[2] = {0, 0};
    rigcal_elimination out;

    for (int i = 0; i < 2; i++) {
        const double d = sqrt(1.5) / conditions[i];
        const rigcal_pair pairs[3] = {
            test_pair_of(h, 0, h, h, 0, h),
            test_pair_of(h, 0, h, h * cos(d), h * sin(d), h),
            test_pair_of(h, 0, h, h * cos(d), -h * sin(d), h),
        };
        if (i == 0) {
            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_pairs_eliminate(&out, pairs, 3, 0, RIGCAL_YAW, angles));
            ASSERT_NEAR(conditions[0], out.condition, 1e-4 * conditions[0]);
        } else {
            ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, out,
                           rigcal_pairs_eliminate(&out, pairs, 3, 0, RIGCAL_YAW, angles));
        }
    }
}

/* A is well conditioned, but the answer c = s = 0 has no direction. */
static void test_an_elimination_without_a_direction_is_refused(void)
{
    const rigcal_pair pairs[3] = {
        test_pair_of(1, 0, 0, 1, 0, 0),
        test_pair_of(0, 0.6, 0.8, 1, 0, 0),
        test_pair_of(0, 1, 0, 0, 0.6, 0.8),
    };
    const rigcal_real angles[2] = {0, 0};
    rigcal_elimination out;

    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, out,
                   rigcal_pairs_eliminate(&out, pairs, 3, 2, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, out,
                   rigcal_pairs_eliminate(&out, pairs, 3, 0, RIGCAL_YAW, angles));
}

/* 0.48 c = -0.48 and s = 0: half a turn, whatever the sign of the zero. */
static void test_half_a_turn_is_eliminated_as_plus_pi(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        const rigcal_pair pairs[3] = {
            test_pair_of(0.6, 0, 0.8, 0.8, 0, 0.6),
            test_pair_of(0, sign, 0, 1, 0, 0),
            test_pair_of(0, -sign, 0, 1, 0, 0),
        };
        const rigcal_real angles[2] = {0, 0};
        rigcal_elimination out;

        for (int32_t pairs_used = 0; pairs_used <= 2; pairs_used += 2) {
            ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_eliminate(&out, pairs, 3, pairs_used,
                                                            RIGCAL_YAW, angles));
            ASSERT_NEAR(TEST_PI, out.angle, TOL(1e-15, 1e-6));
            ASSERT_NEAR(-1, out.cosine, TOL(1e-15, 1e-6));
        }
    }
}

/* c and s are accurate to cond(A) times rounding, times their size. (15) has their squares.
 * The tolerance says this and no more. */
static void assert_elimination(const double expected[6], const rigcal_elimination *seen)
{
    const double size = hypot(expected[1], expected[2]);
    const double tol = TOL(1e-14, 2e-6) * expected[3] * (1 + size);
    double turn = D(seen->angle) - expected[0];

    turn -= 2 * TEST_PI * floor(turn / (2 * TEST_PI) + 0.5);
    TEST_ASSERT_TRUE(D(seen->angle) <= D(RC(TEST_PI)) && D(seen->angle) > -D(RC(TEST_PI)));
    ASSERT_NEAR(0, turn, tol / size);
    ASSERT_NEAR(expected[1], seen->cosine, tol);
    ASSERT_NEAR(expected[2], seen->sine, tol);
    /* A singular value is accurate to rounding; the least is cond times smaller. */
    ASSERT_NEAR(expected[3], seen->condition, TOL(1e-14, 2e-6) * expected[3] * expected[3]);
    ASSERT_NEAR(expected[4], seen->unit, tol * 2 * (1 + size));
    /* The sum contains up to 15 residuals at that angle. */
    ASSERT_NEAR(expected[5], seen->residual, tol * 2 * (1 + size) + 15 * tol / size);
}

static void check_golden_eliminations(const double golden[][18], int32_t pairs_used)
{
    int well_conditioned = 0;

    for (int k = 0; k < SCENE_ROWS; k++) {
        double ypr[3], wrong[3];
        rigcal_bearing s[6];
        rigcal_pair pairs[15];
        int n_pairs;

        test_golden_scene(s, ypr, wrong, k);
        n_pairs = test_golden_pairs(pairs, s, 3 + k % 4);
        for (int which = RIGCAL_YAW; which <= RIGCAL_ROLL; which++) {
            const double *expected = golden[k] + 6 * which;
            rigcal_real angles[2];
            rigcal_elimination out;

            if (expected[3] > TOL(1e7, 300)) {
                continue; /* practically singular */
            }
            test_other_two(angles, wrong, which);
            ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_eliminate(&out, pairs, (size_t)n_pairs,
                                                            pairs_used, which, angles));
            assert_elimination(expected, &out);
            if (expected[3] < 20) { /* the ordinary tolerance */
                well_conditioned++;
                ASSERT_NEAR(expected[5], out.residual, TOL_FORMULA * fmax(1, expected[5]));
            }
        }
    }
    TEST_ASSERT_TRUE(well_conditioned > 2 * SCENE_ROWS);
}

static void test_elimination_by_two_pairs_is_the_oracles(void)
{
    check_golden_eliminations(ELIMINATION_TWO, 2);
}

static void test_elimination_by_all_pairs_is_numpys_least_squares(void)
{
    check_golden_eliminations(ELIMINATION_ALL, 0);
}

static void test_elimination_finds_the_true_angle_of_perfect_images(void)
{
    test_rng rng = test_seed(45);
    int tried = 0;

    for (int trial = 0; trial < TEST_TRIALS(200); trial++) {
        test_scene scene;
        rigcal_bearing s[6];
        rigcal_pair pairs[15];
        size_t n_pairs;

        test_scene_random(&scene, &rng, 3 + trial % 4, TEST_GENERAL);
        test_bearings(s, &scene);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_pairs_choose(pairs, 15, &n_pairs, s, (size_t)scene.n));
        for (int which = RIGCAL_YAW; which <= RIGCAL_ROLL; which++) {
            for (int32_t pairs_used = 0; pairs_used <= 2; pairs_used += 2) {
                rigcal_real angles[2];
                rigcal_elimination out;
                rigcal_status status;
                double tol, turn;

                test_other_two(angles, scene.ypr, which);
                status =
                    rigcal_pairs_eliminate(&out, pairs, n_pairs, pairs_used, which, angles);
                if (status == RIGCAL_ERR_DEGENERATE || D(out.condition) > TOL(1e4, 300)) {
                    continue; /* this angle cannot be eliminated in this view; there are few
                                 such views */
                }
                ASSERT_STATUS(RIGCAL_OK, status);
                tried++;
                /* The rounding of rays that are a tenth of the image apart, times cond. */
                tol = TOL(1e-13, 5e-5) * D(out.condition);
                turn = D(out.angle) - scene.ypr[which];
                turn -= 2 * TEST_PI * floor(turn / (2 * TEST_PI) + 0.5);
                ASSERT_NEAR(0, turn, tol);
                ASSERT_NEAR(0, out.unit, 2 * tol);
                ASSERT_NEAR(0, out.residual, 20 * tol);
            }
        }
    }
    TEST_ASSERT_TRUE(tried > TEST_TRIALS(1000));
}

static void test_the_order_of_pairs_does_not_matter_to_least_squares(void)
{
    double ypr[3], wrong[3];
    rigcal_bearing s[6];
    rigcal_pair pairs[15], reversed[15];
    rigcal_real angles[2];
    rigcal_elimination first, second;

    test_golden_scene(s, ypr, wrong, 3);
    test_golden_pairs(pairs, s, 6);
    for (int k = 0; k < 15; k++) {
        reversed[k] = pairs[14 - k];
    }
    test_other_two(angles, wrong, RIGCAL_PITCH);
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_pairs_eliminate(&first, pairs, 15, 0, RIGCAL_PITCH, angles));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_pairs_eliminate(&second, reversed, 15, 0, RIGCAL_PITCH, angles));
    ASSERT_NEAR(first.angle, second.angle, TOL(1e-14, 1e-5));
    ASSERT_NEAR(first.condition, second.condition, TOL(1e-13, 1e-4));
    ASSERT_NEAR(first.residual, second.residual, TOL(1e-13, 1e-4));
}

static void test_a_singular_elimination_is_refused(void)
{
    const rigcal_pair twice[3] = {
        test_pair_of(0.8, 0, 0.6, 0.8, 0, -0.6),
        test_pair_of(0.8, 0, 0.6, 0.8, 0, -0.6),
        test_pair_of(0, 0.8, 0.6, 0.8, 0, -0.6),
    };
    /* Planes of rays that contain no x or y, or offsets along the axis: yaw does not change
     * them. */
    const rigcal_pair blind[3] = {
        test_pair_of(0, 0, 1, 0.6, 0.8, 0),
        test_pair_of(0, 0, 1, 0.6, 0, 0.8),
        test_pair_of(0.6, 0.8, 0, 0, 0, 1),
    };
    const rigcal_real angles[2] = {0, 0};
    rigcal_elimination out;

    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, out,
                   rigcal_pairs_eliminate(&out, twice, 3, 2, RIGCAL_YAW, angles));
    ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_eliminate(&out, twice, 3, 0, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, out,
                   rigcal_pairs_eliminate(&out, blind, 3, 2, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, out,
                   rigcal_pairs_eliminate(&out, blind, 3, 0, RIGCAL_YAW, angles));
}

/* Behind the two angles, or the three, nothing is looked at. */
static void test_no_more_angles_are_checked_than_there_are(void)
{
    const rigcal_real two[3] = {0, 0, TEST_NAN}, three[4] = {0, 0, 0, RC(1e30)};
    const rigcal_pair pairs[3] = {
        test_pair_of(1, 0, 0, 0, 1, 0),
        test_pair_of(0, 1, 0, 1, 0, 0),
        test_pair_of(0, 0, 1, 1, 0, 0),
    };
    rigcal_real pqk[3], residual;

    ASSERT_STATUS(RIGCAL_OK, rigcal_pair_coefficients(pqk, pairs, RIGCAL_YAW, two));
    ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_residual(&residual, pairs, 3, three));
    ASSERT_NEAR(0, residual, 0);
}

static void test_arguments_of_the_elimination_are_checked(void)
{
    double ypr[3], wrong[3];
    rigcal_bearing s[6];
    rigcal_pair pairs[15], bad[3];
    rigcal_real angles[2] = {0, 0}, odd[2], pqk[3];
    rigcal_elimination out;

    test_golden_scene(s, ypr, wrong, 0);
    test_golden_pairs(pairs, s, 6);
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_pairs_eliminate(NULL, pairs, 3, 2, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, out,
                   rigcal_pairs_eliminate(&out, NULL, 3, 2, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, out,
                   rigcal_pairs_eliminate(&out, pairs, 3, 2, RIGCAL_YAW, NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_pair_coefficients(NULL, pairs, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, pqk,
                   rigcal_pair_coefficients(pqk, NULL, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, pqk,
                   rigcal_pair_coefficients(pqk, pairs, RIGCAL_YAW, NULL));
    for (int32_t which = -1; which <= 4; which++) {
        if (which >= RIGCAL_YAW && which <= RIGCAL_ROLL) {
            continue;
        }
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, out,
                       rigcal_pairs_eliminate(&out, pairs, 3, 2, which, angles));
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, pqk,
                       rigcal_pair_coefficients(pqk, pairs, which, angles));
    }
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, out,
                   rigcal_pairs_eliminate(&out, pairs, 3, 1, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, out,
                   rigcal_pairs_eliminate(&out, pairs, 3, 3, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, out,
                   rigcal_pairs_eliminate(&out, pairs, 3, -2, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, out,
                   rigcal_pairs_eliminate(&out, pairs, 2, 2, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, out,
                   rigcal_pairs_eliminate(&out, pairs, 0, 0, RIGCAL_YAW, angles));
    for (int k = 0; k < 2; k++) {
        odd[k] = TEST_NAN;
        odd[1 - k] = 0;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, out,
                       rigcal_pairs_eliminate(&out, pairs, 3, 2, RIGCAL_YAW, odd));
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, pqk,
                       rigcal_pair_coefficients(pqk, pairs, RIGCAL_YAW, odd));
        odd[k] = -TEST_INF;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, out,
                       rigcal_pairs_eliminate(&out, pairs, 3, 0, RIGCAL_YAW, odd));
    }
    for (int k = 0; k < 3; k++) {
        memcpy(bad, pairs, sizeof bad);
        bad[k].normal[k] = TEST_NAN;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, out,
                       rigcal_pairs_eliminate(&out, bad, 3, 0, RIGCAL_YAW, angles));
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, pqk,
                       rigcal_pair_coefficients(pqk, &bad[k], RIGCAL_YAW, angles));
        memcpy(bad, pairs, sizeof bad);
        bad[k].offset[k] = TEST_INF;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, out,
                       rigcal_pairs_eliminate(&out, bad, 3, 2, RIGCAL_YAW, angles));
    }
}

/* ---- three angles (5) ---------------------------------------------------- */

static void test_the_three_angle_residual_is_the_oracles(void)
{
    for (int k = 0; k < SCENE_ROWS; k++) {
        double ypr[3], wrong[3];
        rigcal_bearing s[6];
        rigcal_pair pairs[15];
        rigcal_real angles[3], residual;

        test_golden_scene(s, ypr, wrong, k);
        test_golden_pairs(pairs, s, 6);
        test_to_real(angles, wrong, 3);
        ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_residual(&residual, pairs, 15, angles));
        ASSERT_NEAR(TRANSLATION[k][12], residual, 4 * TOL_FORMULA);
    }
}

static void test_the_three_angle_residual_is_the_sum_over_its_pairs(void)
{
    const rigcal_real angles[3] = {RC(0.3), RC(-0.2), RC(1.1)};
    double ypr[3], wrong[3], sum = 0;
    rigcal_bearing s[6];
    rigcal_pair pairs[15];
    rigcal_real R[9], e, residual;

    test_golden_scene(s, ypr, wrong, 7);
    test_golden_pairs(pairs, s, 6);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_yaw_pitch_roll(R, angles));
    for (int k = 0; k < 3; k++) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_pair_residual(&e, &pairs[k], R));
        sum += fabs(D(e));
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_residual(&residual, pairs, 3, angles));
    ASSERT_NEAR(sum, residual, TOL(1e-15, 1e-6));
}

static void test_arguments_of_the_three_angle_residual_are_checked(void)
{
    const rigcal_real zero[3] = {0, 0, 0};
    double ypr[3], wrong[3];
    rigcal_bearing s[6];
    rigcal_pair pairs[15];
    rigcal_real residual;

    test_golden_scene(s, ypr, wrong, 7);
    test_golden_pairs(pairs, s, 6);
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_pairs_residual(NULL, pairs, 3, zero));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, residual,
                   rigcal_pairs_residual(&residual, NULL, 3, zero));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, residual,
                   rigcal_pairs_residual(&residual, pairs, 3, NULL));
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, residual,
                   rigcal_pairs_residual(&residual, pairs, 2, zero));
    for (int k = 0; k < 3; k++) {
        rigcal_real bad[3] = {0, 0, 0};

        bad[k] = TEST_INF;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, residual,
                       rigcal_pairs_residual(&residual, pairs, 3, bad));
        bad[k] = RC(TOL(1.1e6, 1.1e3));
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, residual,
                       rigcal_pairs_residual(&residual, pairs, 3, bad));
    }
    pairs[1].offset[2] = TEST_NAN;
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, residual,
                   rigcal_pairs_residual(&residual, pairs, 3, zero));
}

/* Rays and offsets are nearly along the axis of yaw and across it. Then all equations are
 * small, but as well conditioned as others: h c = h and h s = h, twice. */
static void test_small_equations_are_as_good(void)
{
    const double h = TOL(1e-7, 1e-3);
    const rigcal_pair pairs[4] = {
        test_pair_of(h, 0, 1, 1, 0, -h),
        test_pair_of(0, h, 1, 1, 0, -h),
        test_pair_of(h, 0, 1, 1, 0, -h),
        test_pair_of(0, h, 1, 1, 0, -h),
    };
    const rigcal_real angles[2] = {0, 0};
    rigcal_elimination out;

    for (int used = 0; used <= 2; used += 2) {
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_pairs_eliminate(&out, pairs, 4, used, RIGCAL_YAW, angles));
        ASSERT_NEAR(1, out.cosine, TOL(1e-9, 1e-4));
        ASSERT_NEAR(1, out.sine, TOL(1e-9, 1e-4));
        ASSERT_NEAR(1, out.condition, TOL(1e-9, 1e-3));
    }
}

/* Rays and offsets along the axis of yaw say nothing of it. */
static void test_equations_of_zeros_are_refused(void)
{
    const rigcal_pair pairs[3] = {
        test_pair_of(0, 0, 1, 0, 0, 1),
        test_pair_of(0, 0, 1, 0, 0, -1),
        test_pair_of(0, 0, 1, 0, 0, 1),
    };
    const rigcal_real angles[2] = {0, 0};
    rigcal_elimination out;

    for (int used = 0; used <= 2; used += 2) {
        ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, out,
                       rigcal_pairs_eliminate(&out, pairs, 3, used, RIGCAL_YAW, angles));
    }
}

/* h c = 1 and h s = 1, twice. The determinant of two equations is of the size of h^2, that
 * of their sums of h^4. Where it is below all numbers, the equations are refused. */
static void test_equations_whose_determinant_underflows_are_refused(void)
{
    static const double SMALL[2] = {TOL(1e-100, 1e-15), TOL(1e-200, 1e-30)};

    for (int k = 0; k < 2; k++) {
        const double h = SMALL[k], u = sqrt(0.5);
        const rigcal_pair pairs[4] = {
            test_pair_of(h, 0, 1, u, 0, -u),
            test_pair_of(0, h, 1, u, 0, -u),
            test_pair_of(h, 0, 1, u, 0, -u),
            test_pair_of(0, h, 1, u, 0, -u),
        };
        const rigcal_real angles[2] = {0, 0};
        rigcal_elimination out;

        ASSERT_REFUSED(
            RIGCAL_ERR_DEGENERATE, out,
            rigcal_pairs_eliminate(&out, pairs, 4, k == 0 ? 0 : 2, RIGCAL_YAW, angles));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_equations_of_zeros_are_refused);
    RUN_TEST(test_equations_whose_determinant_underflows_are_refused);
    RUN_TEST(test_small_equations_are_as_good);
    RUN_TEST(test_pairs_and_their_residuals_are_the_oracles);
    RUN_TEST(test_the_residual_vanishes_at_the_true_rotation);
    RUN_TEST(test_a_residual_of_what_is_no_pair_or_rotation_is_refused);
    RUN_TEST(test_coefficients_are_the_oracles);
    RUN_TEST(test_coefficients_give_the_residual_at_any_angle);
    RUN_TEST(test_an_elimination_on_paper);
    RUN_TEST(test_the_condition_is_that_of_the_spectral_norm);
    RUN_TEST(test_all_pairs_are_refused_from_the_stated_condition_on);
    RUN_TEST(test_an_elimination_without_a_direction_is_refused);
    RUN_TEST(test_half_a_turn_is_eliminated_as_plus_pi);
    RUN_TEST(test_elimination_by_two_pairs_is_the_oracles);
    RUN_TEST(test_elimination_by_all_pairs_is_numpys_least_squares);
    RUN_TEST(test_elimination_finds_the_true_angle_of_perfect_images);
    RUN_TEST(test_the_order_of_pairs_does_not_matter_to_least_squares);
    RUN_TEST(test_a_singular_elimination_is_refused);
    RUN_TEST(test_no_more_angles_are_checked_than_there_are);
    RUN_TEST(test_arguments_of_the_elimination_are_checked);
    RUN_TEST(test_the_three_angle_residual_is_the_oracles);
    RUN_TEST(test_the_three_angle_residual_is_the_sum_over_its_pairs);
    RUN_TEST(test_arguments_of_the_three_angle_residual_are_checked);
}
