/* Rigid transforms: chained, inverted, applied, averaged; camera to camera. */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "rc_transform.h"
#include "test_support.h"
#include "vectors_transform.h"

/* For entries of a rotation, and for lengths of order 10. */
#define TOL_ENTRY TOL(1e-14, 2e-6)
#define TOL_LENGTH TOL(3e-14, 1e-5)

/* The same for a mean. */
#define TOL_MEAN TOL(3e-14, 5e-6)
#define TOL_MEAN_LENGTH TOL(2e-13, 5e-5)

static const rigcal_transform NOTHING = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};

/* A quarter turn x to y, then 10 along x: exact in any arithmetic. */
static const rigcal_transform QUARTER = {{0, -1, 0, 1, 0, 0, 0, 0, 1}, {10, 0, 0}};

/* ---- on paper ------------------------------------------------------------ */

static void test_a_point_is_turned_then_shifted(void)
{
    static const double expected[3] = {8, 1, 3};
    const rigcal_real X[3] = {1, 2, 3};
    rigcal_real Y[3];

    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_point(Y, &QUARTER, X));
    ASSERT_ARRAY_NEAR(expected, Y, 3, 0);
}

static void test_the_later_transform_stands_left_in_a_chain(void)
{
    static const rigcal_transform shift = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 5}};
    static const rigcal_transform half = {{-1, 0, 0, 0, 1, 0, 0, 0, -1}, {0, 7, 0}};
    /* X goes to X + (0, 0, 5), then to (-x, y + 7, -z). */
    static const double R[9] = {-1, 0, 0, 0, 1, 0, 0, 0, -1};
    static const double t[3] = {0, 7, -5};
    rigcal_transform chain;

    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_compose(&chain, &half, &shift));
    ASSERT_ARRAY_NEAR(R, chain.R, 9, 0);
    ASSERT_ARRAY_NEAR(t, chain.t, 3, 0);
}

static void test_the_inverse_of_a_known_transform(void)
{
    static const double R[9] = {0, 1, 0, -1, 0, 0, 0, 0, 1};
    static const double t[3] = {0, 10, 0};
    rigcal_transform back;

    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_invert(&back, &QUARTER));
    ASSERT_ARRAY_NEAR(R, back.R, 9, 0);
    ASSERT_ARRAY_NEAR(t, back.t, 3, 0);
}

/* o = -R^T t. The camera's x is the world's -y, and it sees the world's origin at 10 on its
 * x axis. So it is at 10 on the world's y axis. */
static void test_the_camera_centre_is_where_the_camera_is(void)
{
    static const double expected[3] = {0, 10, 0};
    rigcal_real o[3], seen[3];

    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_center(o, &QUARTER));
    ASSERT_ARRAY_NEAR(expected, o, 3, 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_point(seen, &QUARTER, o));
    for (int k = 0; k < 3; k++) {
        ASSERT_NEAR(0, seen[k], 0);
    }
}

/* ---- against the oracle -------------------------------------------------- */

static void test_camera_to_camera_is_the_oracles(void)
{
    for (int i = 0; i < TRANSFORM_RELATIVE_ROWS; i++) {
        const double *v = TRANSFORM_RELATIVE[i];
        const rigcal_transform a = test_from_ypr(v, v + 3);
        const rigcal_transform b = test_from_ypr(v + 6, v + 9);
        rigcal_transform b_from_a;

        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_between(&b_from_a, &b, &a));
        ASSERT_ARRAY_NEAR(v + 12, b_from_a.R, 9, TOL_ENTRY);
        ASSERT_ARRAY_NEAR(v + 21, b_from_a.t, 3, TOL_LENGTH);
    }
}

/* ---- properties ---------------------------------------------------------- */

static void test_a_chain_takes_points_where_its_links_take_them(void)
{
    test_rng rng = test_seed(21);

    for (int i = 0; i < 100; i++) {
        const rigcal_transform b_from_a = test_random_transform(&rng);
        const rigcal_transform c_from_b = test_random_transform(&rng);
        const rigcal_real X[3] = {RC(test_uniform(&rng, -5, 5)),
                                  RC(test_uniform(&rng, -5, 5)),
                                  RC(test_uniform(&rng, -5, 5))};
        double by_links[3];
        rigcal_transform c_from_a;
        rigcal_real X_b[3], X_c[3], X_once[3];

        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_compose(&c_from_a, &c_from_b, &b_from_a));
        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_point(X_b, &b_from_a, X));
        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_point(X_c, &c_from_b, X_b));
        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_point(X_once, &c_from_a, X));
        test_to_double(by_links, X_c, 3);
        ASSERT_ARRAY_NEAR(by_links, X_once, 3, TOL_LENGTH);
    }
}

static void test_a_transform_and_its_inverse_cancel_either_way(void)
{
    test_rng rng = test_seed(22);

    for (int i = 0; i < 100; i++) {
        const rigcal_transform there = test_random_transform(&rng);
        rigcal_transform back, both, again;

        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_invert(&back, &there));
        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_compose(&both, &back, &there));
        ASSERT_TRANSFORM(&NOTHING, &both, TOL_ENTRY, TOL_LENGTH);
        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_compose(&both, &there, &back));
        ASSERT_TRANSFORM(&NOTHING, &both, TOL_ENTRY, TOL_LENGTH);
        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_invert(&again, &back));
        ASSERT_TRANSFORM(&there, &again, TOL_ENTRY, TOL_LENGTH);
    }
}

static void test_chaining_with_nothing_changes_nothing(void)
{
    test_rng rng = test_seed(23);
    const rigcal_transform T = test_random_transform(&rng);
    rigcal_transform seen;

    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_compose(&seen, &T, &NOTHING));
    ASSERT_TRANSFORM(&T, &seen, TOL_ENTRY, TOL_LENGTH);
    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_compose(&seen, &NOTHING, &T));
    ASSERT_TRANSFORM(&T, &seen, TOL_ENTRY, TOL_LENGTH);
}

/* c_from_b * b_from_a = c_from_a. Around a loop of six cameras the product is the
 * identity. */
static void test_camera_to_camera_closes_round_a_loop(void)
{
    test_rng rng = test_seed(24);
    rigcal_transform cams[6], loop = NOTHING;

    for (int i = 0; i < 6; i++) {
        cams[i] = test_random_transform(&rng);
    }
    for (int i = 0; i < 6; i++) {
        const rigcal_transform so_far = loop;
        rigcal_transform next;

        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_transform_between(&next, &cams[(i + 1) % 6], &cams[i]));
        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_compose(&loop, &next, &so_far));
    }
    ASSERT_TRANSFORM(&NOTHING, &loop, TOL_ENTRY, TOL_LENGTH);
}

static void test_a_camera_seen_from_itself_is_at_home(void)
{
    test_rng rng = test_seed(25);
    const rigcal_transform T = test_random_transform(&rng);
    rigcal_transform self;

    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_between(&self, &T, &T));
    ASSERT_TRANSFORM(&NOTHING, &self, TOL_ENTRY, TOL_LENGTH);
}

/* Another world W', with X = Q X' + s, changes both poses but not b_from_a. */
static void test_camera_to_camera_does_not_depend_on_the_world(void)
{
    test_rng rng = test_seed(26);

    for (int i = 0; i < 50; i++) {
        const rigcal_transform a = test_random_transform(&rng);
        const rigcal_transform b = test_random_transform(&rng);
        const rigcal_transform w_from_other = test_random_transform(&rng);
        rigcal_transform a_other, b_other, first, second;

        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_compose(&a_other, &a, &w_from_other));
        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_compose(&b_other, &b, &w_from_other));
        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_between(&first, &b, &a));
        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_between(&second, &b_other, &a_other));
        ASSERT_TRANSFORM(&first, &second, TOL_ENTRY, TOL_LENGTH);
    }
}

/* Coordinates of a map projection: easting, northing, height. */
static void test_a_world_far_away_keeps_the_digits_that_are_left(void)
{
    static const double X[3] = {512000.25, 5154500.5, 1200.125};
    double R[9], t[3], expected[3], o_seen[3];
    test_rng rng = test_seed(27);
    rigcal_transform T;
    rigcal_real X_w[3], X_c[3], o[3];

    test_random_rotation(R, &rng);
    test_apply(t, R, X, NULL);
    for (int k = 0; k < 3; k++) {
        t[k] = -t[k] + k; /* the point lies at (0, 1, 2) of the camera */
        expected[k] = k;
    }
    T = test_transform(R, t);
    test_to_real(X_w, X, 3);
    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_point(X_c, &T, X_w));
    ASSERT_ARRAY_NEAR(expected, X_c, 3, TOL(4e-9, 3));
    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_center(o, &T));
    test_to_double(o_seen, o, 3);
    for (int k = 0; k < 3; k++) {
        o_seen[k] -= X[k];
    }
    ASSERT_NEAR(sqrt(5), test_norm(o_seen), TOL(4e-9, 3));
}

/* ---- what is refused ----------------------------------------------------- */

static void test_null_is_refused_in_every_place(void)
{
    const rigcal_real X[3] = {1, 2, 3};
    rigcal_transform T;
    rigcal_real Y[3];

    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_transform_compose(NULL, &QUARTER, &QUARTER));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, T, rigcal_transform_compose(&T, NULL, &QUARTER));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, T, rigcal_transform_compose(&T, &QUARTER, NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_transform_invert(NULL, &QUARTER));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, T, rigcal_transform_invert(&T, NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_transform_point(NULL, &QUARTER, X));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, Y, rigcal_transform_point(Y, NULL, X));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, Y, rigcal_transform_point(Y, &QUARTER, NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_camera_center(NULL, &QUARTER));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, Y, rigcal_camera_center(Y, NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_transform_between(NULL, &QUARTER, &QUARTER));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, T, rigcal_transform_between(&T, NULL, &QUARTER));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, T, rigcal_transform_between(&T, &QUARTER, NULL));
}

static void assert_all_refuse(rigcal_status status, const rigcal_transform *bad)
{
    const rigcal_real X[3] = {1, 2, 3};
    rigcal_transform T;
    rigcal_real Y[3];

    ASSERT_REFUSED(status, T, rigcal_transform_compose(&T, bad, &QUARTER));
    ASSERT_REFUSED(status, T, rigcal_transform_compose(&T, &QUARTER, bad));
    ASSERT_REFUSED(status, T, rigcal_transform_invert(&T, bad));
    ASSERT_REFUSED(status, Y, rigcal_transform_point(Y, bad, X));
    ASSERT_REFUSED(status, Y, rigcal_camera_center(Y, bad));
    ASSERT_REFUSED(status, T, rigcal_transform_between(&T, bad, &QUARTER));
    ASSERT_REFUSED(status, T, rigcal_transform_between(&T, &QUARTER, bad));
}

static void test_a_number_that_is_not_finite_is_refused_in_every_place(void)
{
    const rigcal_real bad[3] = {TEST_NAN, TEST_INF, -TEST_INF};

    for (int i = 0; i < 12; i++) {
        rigcal_transform T = QUARTER;
        rigcal_real X[3] = {1, 2, 3}, Y[3];

        if (i < 9) {
            T.R[i] = bad[i % 3];
        } else {
            T.t[i - 9] = bad[i % 3];
            X[i - 9] = bad[i % 3];
            ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, Y,
                           rigcal_transform_point(Y, &QUARTER, X));
        }
        assert_all_refuse(RIGCAL_ERR_NOT_FINITE, &T);
    }
}

static void test_a_matrix_that_is_no_rotation_is_refused(void)
{
    rigcal_transform T = QUARTER;

    T.R[8] = -1; /* a mirror */
    assert_all_refuse(RIGCAL_ERR_ROTATION, &T);
    T.R[8] = RC(1 + TOL(1e-5, 1e-2));
    assert_all_refuse(RIGCAL_ERR_ROTATION, &T);
    for (int k = 0; k < 9; k++) {
        T.R[k] = 0;
    }
    assert_all_refuse(RIGCAL_ERR_ROTATION, &T);
}

static void test_a_length_beyond_the_range_is_refused(void)
{
    const double most = TOL(1e30, 1e9);

    for (int k = 0; k < 3; k++) {
        rigcal_transform T = QUARTER;
        rigcal_real X[3] = {1, 2, 3}, Y[3];

        T.t[k] = RC(k == 1 ? -1.01 * most : 1.01 * most);
        X[k] = RC(k == 2 ? -1.01 * most : 1.01 * most);
        assert_all_refuse(RIGCAL_ERR_RANGE, &T);
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, Y, rigcal_transform_point(Y, &QUARTER, X));
        T.t[k] = RC(0.99 * most);
        X[k] = RC(-0.99 * most);
        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_point(Y, &T, X));
    }
}

/* ---- the mean ------------------------------------------------------------ */

static void test_the_mean_is_scipys_karcher_mean(void)
{
    for (int i = 0; i < TRANSFORM_MEAN_ROWS; i++) {
        const double *v = TRANSFORM_MEAN[i];
        rigcal_transform transforms[5], mean;
        rigcal_real weight[5], sigma_rad, sigma_t;

        for (int k = 0; k < 5; k++) {
            weight[k] = RC(v[7 * k]);
            transforms[k] = test_from_ypr(v + 7 * k + 1, v + 7 * k + 4);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_mean(&mean, &sigma_rad, &sigma_t,
                                                       transforms, weight, 5));
        ASSERT_ARRAY_NEAR(v + 35, mean.R, 9, TOL(1e-12, 5e-6));
        ASSERT_ARRAY_NEAR(v + 44, mean.t, 3, TOL(1e-14, 2e-6));
        ASSERT_NEAR(v[47], sigma_rad, TOL(1e-12, 5e-6));
        ASSERT_NEAR(v[48], sigma_t, TOL(1e-14, 3e-6));
    }
}

static void test_the_mean_of_one_is_that_one(void)
{
    test_rng rng = test_seed(71);
    const rigcal_transform one = test_random_transform(&rng);
    rigcal_transform mean;
    rigcal_real sigma_rad, sigma_t;

    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_transform_mean(&mean, &sigma_rad, &sigma_t, &one, NULL, 1));
    ASSERT_TRANSFORM(&one, &mean, TOL(1e-15, 1e-6), 0);
    ASSERT_NEAR(0, sigma_rad, TOL(1e-15, 1e-6));
    ASSERT_NEAR(0, sigma_t, 0);
}

/* Turned by +w and -w, shifted by +d and -d: the mean is known, and so is the deviation. */
static void test_deviations_that_balance_leave_the_middle(void)
{
    test_rng rng = test_seed(72);

    for (int trial = 0; trial < 60; trial++) {
        const double angle = trial % 2 ? 0.9 : 1e-3;
        const rigcal_transform middle = test_random_transform(&rng);
        double axis[3], d[3], length;
        rigcal_transform six[6], mean;
        rigcal_real sigma_rad, sigma_t;

        for (int k = 0; k < 3; k++) {
            d[k] = test_uniform(&rng, -1, 1);
        }
        length = test_norm(d);
        for (int i = 0; i < 6; i += 2) {
            for (int k = 0; k < 3; k++) {
                axis[k] = test_normal(&rng);
            }
            for (int side = 0; side < 2; side++) {
                const rigcal_transform turn =
                    test_turned_about(axis, side ? angle : -angle);

                six[i + side] = test_times(&turn, &middle);
                for (int k = 0; k < 3; k++) {
                    six[i + side].t[k] = middle.t[k] + (side ? RC(d[k]) : -RC(d[k]));
                }
            }
        }
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_transform_mean(&mean, &sigma_rad, &sigma_t, six, NULL, 6));
        ASSERT_TRANSFORM(&middle, &mean, TOL(1e-14, 3e-6), TOL(1e-14, 3e-6));
        ASSERT_NEAR(angle, sigma_rad, TOL(1e-14, 3e-6));
        ASSERT_NEAR(length, sigma_t, TOL(1e-14, 3e-6));
    }
}

/* About one axis the mean angle is the mean of the angles. The mean of the entries (the
 * chordal mean) of 0, 0 and 1.5 would give 0.45. */
static void test_angles_are_averaged_and_not_entries(void)
{
    static const double axis[3] = {1, 2, -2};
    const rigcal_transform three[3] = {test_turned_about(axis, 0),
                                       test_turned_about(axis, 0),
                                       test_turned_about(axis, 1.5)};
    const rigcal_transform expected = test_turned_about(axis, 0.5);
    rigcal_transform mean;

    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_mean(&mean, NULL, NULL, three, NULL, 3));
    ASSERT_TRANSFORM(&expected, &mean, TOL(1e-14, 2e-6), 0);
}

static void test_a_weight_counts_as_so_many_repetitions(void)
{
    test_rng rng = test_seed(73);
    const rigcal_real weight[3] = {3, 0, 2};
    const double scale[3] = {16, TOL(1e29, 1e8), TOL(1e-200, 1e-30)};
    const double base[3] = {0.4, -0.3, 1.2};
    rigcal_transform three[3], five[5], by_weight, by_scaled, by_repetition;
    rigcal_real sigma[3][2];

    for (int i = 0; i < 3; i++) {
        double ypr[3], t[3];

        for (int k = 0; k < 3; k++) {
            ypr[k] = base[k] + test_uniform(&rng, -0.4, 0.4);
            t[k] = test_uniform(&rng, -2, 2);
        }
        three[i] = test_from_ypr(ypr, t);
    }
    for (int i = 0; i < 5; i++) {
        five[i] = three[i < 3 ? 0 : 2];
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_mean(&by_weight, &sigma[0][0], &sigma[0][1],
                                                   three, weight, 3));
    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_mean(&by_repetition, &sigma[2][0],
                                                   &sigma[2][1], five, NULL, 5));
    ASSERT_TRANSFORM(&by_weight, &by_repetition, TOL_MEAN, TOL_MEAN_LENGTH);
    for (int k = 0; k < 2; k++) {
        ASSERT_NEAR(sigma[0][k], sigma[2][k], TOL_MEAN);
    }
    for (int i = 0; i < 3; i++) { /* only ratios of weights count */
        rigcal_real scaled[3];

        for (int k = 0; k < 3; k++) {
            scaled[k] = RC(scale[i]) * weight[k];
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_mean(&by_scaled, &sigma[1][0],
                                                       &sigma[1][1], three, scaled, 3));
        ASSERT_TRANSFORM(&by_weight, &by_scaled, TOL_MEAN, TOL_MEAN_LENGTH);
        for (int k = 0; k < 2; k++) {
            ASSERT_NEAR(sigma[0][k], sigma[1][k], TOL_MEAN);
        }
    }
}

/* The mean does not depend on the frame of the rotations. */
static void test_the_mean_turns_with_its_frame(void)
{
    test_rng rng = test_seed(74);
    const rigcal_transform turn = test_random_transform(&rng);
    const rigcal_transform after = test_random_transform(&rng);
    rigcal_transform plain[4], turned[4], mean, mean_turned, expected;

    for (int i = 0; i < 4; i++) {
        const double ypr[3] = {0.3 * i, 0.2 - 0.2 * i, 0.1 * i * i};
        double R[9];

        test_rotation(R, ypr[0], ypr[1], ypr[2]);
        plain[i] = test_transform(R, NULL);
        turned[i] = test_times(&turn, &plain[i]);
        turned[i] = test_times(&turned[i], &after);
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_mean(&mean, NULL, NULL, plain, NULL, 4));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_transform_mean(&mean_turned, NULL, NULL, turned, NULL, 4));
    expected = test_times(&turn, &mean);
    expected = test_times(&expected, &after);
    for (int i = 0; i < 9; i++) {
        ASSERT_NEAR(expected.R[i], mean_turned.R[i], TOL_MEAN);
    }
}

/* The rotations are so far apart that the steps to their mean shrink slowly. Still the
 * steps are few, and the mean of the deviations, which would be 0 at the end, is small. */
static void test_the_steps_to_a_mean_are_bounded(void)
{
    static const rigcal_real Q[7][4] = {
        {-2, 8, -7, 37},    {-30, 6, -1, -8},   {24, -37, -33, 2}, {-38, -31, 43, 37},
        {-5, -31, 43, -26}, {-22, 19, -33, 16}, {9, 50, 45, 18}};
    rigcal_transform seven[7], mean, back, between;
    double left[3] = {0, 0, 0};

    for (int i = 0; i < 7; i++) {
        seven[i] = NOTHING;
        ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_quaternion(seven[i].R, Q[i]));
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_mean(&mean, NULL, NULL, seven, NULL, 7));
    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_invert(&back, &mean));
    for (int i = 0; i < 7; i++) {
        rigcal_real w[3];

        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_compose(&between, &back, &seven[i]));
        ASSERT_STATUS(RIGCAL_OK, rigcal_vector_from_rotation(w, between.R));
        for (int k = 0; k < 3; k++) {
            left[k] += D(w[k]) / 7;
        }
    }
    TEST_ASSERT_TRUE(test_norm(left) < 1e-5);
}

static void test_rotations_that_cancel_have_no_mean(void)
{
    static const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    rigcal_transform four[4] = {NOTHING, NOTHING, NOTHING, NOTHING}, mean;
    rigcal_real sigma_rad, sigma_t;

    FILL(sigma_rad);
    FILL(sigma_t);
    /* Rotations that are half a turn apart. */
    four[1] = test_turned_about(axes[2], TEST_PI);
    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, mean,
                   rigcal_transform_mean(&mean, &sigma_rad, &sigma_t, four, NULL, 2));
    /* Rotations spread over the full circle. */
    for (int i = 0; i < 4; i++) {
        four[i] = test_turned_about(axes[1], i * TEST_PI / 2);
    }
    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, mean,
                   rigcal_transform_mean(&mean, &sigma_rad, &sigma_t, four, NULL, 4));
    /* Half turns about all three axes: the matrices add up to zero. */
    for (int i = 0; i < 3; i++) {
        four[i] = test_turned_about(axes[i], TEST_PI);
    }
    four[3] = NOTHING;
    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, mean,
                   rigcal_transform_mean(&mean, &sigma_rad, &sigma_t, four, NULL, 4));
    ASSERT_UNTOUCHED(sigma_rad);
    ASSERT_UNTOUCHED(sigma_t);
}

static void test_arguments_of_the_mean_are_checked(void)
{
    const rigcal_transform two[2] = {NOTHING, NOTHING};
    const rigcal_real none[2] = {0, 0}, negative[2] = {2, -1};
    const rigcal_real odd[2] = {1, TEST_NAN}, endless[2] = {TEST_INF, 1};
    const rigcal_real most[2] = {RC(TOL(1e30, 1e9)), 1};
    const rigcal_real beyond[2] = {1, RC(TOL(1.01e30, 1.01e9))};
    rigcal_transform mean, bad[2];
    rigcal_real a, b;

    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_mean(&mean, &a, &b, two, most, 2));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, mean,
                   rigcal_transform_mean(&mean, &a, &b, two, beyond, 2));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_transform_mean(NULL, &a, &b, two, NULL, 2));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, mean,
                   rigcal_transform_mean(&mean, &a, &b, NULL, NULL, 2));
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, mean,
                   rigcal_transform_mean(&mean, &a, &b, two, NULL, 0));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, mean,
                   rigcal_transform_mean(&mean, &a, &b, two, NULL, ((size_t)1 << 28) + 1));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, mean,
                   rigcal_transform_mean(&mean, &a, &b, two, none, 2));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, mean,
                   rigcal_transform_mean(&mean, &a, &b, two, negative, 2));
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, mean,
                   rigcal_transform_mean(&mean, &a, &b, two, odd, 2));
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, mean,
                   rigcal_transform_mean(&mean, &a, &b, two, endless, 2));
    for (int i = 0; i < 2; i++) {
        memcpy(bad, two, sizeof bad);
        bad[i].R[4] = -1;
        ASSERT_REFUSED(RIGCAL_ERR_ROTATION, mean,
                       rigcal_transform_mean(&mean, &a, &b, bad, NULL, 2));
        bad[i].R[4] = TEST_NAN;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, mean,
                       rigcal_transform_mean(&mean, &a, &b, bad, NULL, 2));
        memcpy(bad, two, sizeof bad);
        bad[i].t[2] = RC(TOL(1e31, 1e10));
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, mean,
                       rigcal_transform_mean(&mean, &a, &b, bad, NULL, 2));
    }
}

static void test_the_identity_leaves_a_point_where_it_is(void)
{
    const rigcal_real X[3] = {RC(1.5), RC(-2.25), RC(0.75)};
    rigcal_transform T;
    rigcal_real moved[3];

    rc_transform_identity(&T);
    rc_transform_point(moved, &T, X);
    TEST_ASSERT_EQUAL_MEMORY(X, moved, sizeof X);
}

/* ---- errors ----------------------------------------------------------------- */

/* E is a small turn about the centre of a, and a shift. If b is fixed to a, the same move
 * in the axes of b is T E T^-1, with T = b_from_a. */
static void test_an_error_is_carried_to_a_body_that_is_fixed_to_it(void)
{
    test_rng rng = test_seed(77);

    for (int trial = 0; trial < TEST_TRIALS(20); trial++) {
        const rigcal_transform T = test_random_transform(&rng), back = test_inverse(&T);
        rigcal_real carry[36];

        rc_transform_carry(carry, &T);
        for (int j = 0; j < 6; j++) {
            const double step = TOL(1e-5, 1e-2);
            const double axis[3] = {j == 0, j == 1, j == 2};
            double d[3] = {0, 0, 0}, R[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, w[3], t[3];

            if (j < 3) {
                test_rotation_about(R, axis, step);
            } else {
                d[j - 3] = step;
            }
            const rigcal_transform E = test_transform(R, d), TE = test_times(&T, &E),
                                   moved = test_times(&TE, &back);
            test_transform_parts(R, t, &moved);
            w[0] = (R[7] - R[5]) / 2;
            w[1] = (R[2] - R[6]) / 2;
            w[2] = (R[3] - R[1]) / 2;
            for (int i = 0; i < 6; i++) {
                ASSERT_NEAR((i < 3 ? w[i] : t[i - 3]) / step, carry[6 * i + j],
                            TOL(1e-4, 0.1));
            }
        }
    }
}

TEST_MAIN()
{
    RUN_TEST(test_the_identity_leaves_a_point_where_it_is);
    RUN_TEST(test_a_point_is_turned_then_shifted);
    RUN_TEST(test_the_later_transform_stands_left_in_a_chain);
    RUN_TEST(test_the_inverse_of_a_known_transform);
    RUN_TEST(test_the_camera_centre_is_where_the_camera_is);
    RUN_TEST(test_camera_to_camera_is_the_oracles);
    RUN_TEST(test_a_chain_takes_points_where_its_links_take_them);
    RUN_TEST(test_a_transform_and_its_inverse_cancel_either_way);
    RUN_TEST(test_chaining_with_nothing_changes_nothing);
    RUN_TEST(test_camera_to_camera_closes_round_a_loop);
    RUN_TEST(test_a_camera_seen_from_itself_is_at_home);
    RUN_TEST(test_camera_to_camera_does_not_depend_on_the_world);
    RUN_TEST(test_a_world_far_away_keeps_the_digits_that_are_left);
    RUN_TEST(test_null_is_refused_in_every_place);
    RUN_TEST(test_a_number_that_is_not_finite_is_refused_in_every_place);
    RUN_TEST(test_a_matrix_that_is_no_rotation_is_refused);
    RUN_TEST(test_a_length_beyond_the_range_is_refused);
    RUN_TEST(test_the_mean_is_scipys_karcher_mean);
    RUN_TEST(test_the_mean_of_one_is_that_one);
    RUN_TEST(test_deviations_that_balance_leave_the_middle);
    RUN_TEST(test_angles_are_averaged_and_not_entries);
    RUN_TEST(test_a_weight_counts_as_so_many_repetitions);
    RUN_TEST(test_the_mean_turns_with_its_frame);
    RUN_TEST(test_the_steps_to_a_mean_are_bounded);
    RUN_TEST(test_rotations_that_cancel_have_no_mean);
    RUN_TEST(test_arguments_of_the_mean_are_checked);
    RUN_TEST(test_an_error_is_carried_to_a_body_that_is_fixed_to_it);
}
