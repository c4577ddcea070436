/* Rotations: matrix, yaw-pitch-roll, rotation vector, quaternion. */
#include <math.h>

#include "rc_rotation.h"
#include "test_support.h"
#include "vectors_rotation.h"

/* For entries of a matrix, and for angles, of order 1. */
#define TOL_ENTRY TOL(1e-14, 2e-6)

static const rigcal_real IDENTITY[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
static const rigcal_real MIRROR[9] = {1, 0, 0, 0, 1, 0, 0, 0, -1};

/* R R^T = I to a few units in the last place, and no mirror. */
static void assert_orthonormal(const rigcal_real R[9])
{
    double M[9];

    test_to_double(M, R, 9);
    ASSERT_ROTATION(M, TOL(2e-15, 1e-6));
}

static void assert_same_rotation(const double R[9], const rigcal_real seen[9])
{
    ASSERT_ARRAY_NEAR(R, seen, 9, TOL_ENTRY);
}

/* ---- yaw, pitch, roll ---------------------------------------------------- */

static void test_no_angles_are_the_identity(void)
{
    const rigcal_real ypr[3] = {0, 0, 0};
    rigcal_real R[9];

    ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_yaw_pitch_roll(R, ypr));
    for (int i = 0; i < 9; i++) {
        TEST_ASSERT_TRUE(R[i] == IDENTITY[i]);
    }
}

/* Right-handed: yaw takes x to y, pitch takes z to x, roll takes y to z. */
static void test_a_quarter_turn_takes_each_axis_to_the_next(void)
{
    static const double quarter[3][9] = {
        {0, -1, 0, 1, 0, 0, 0, 0, 1},
        {0, 0, 1, 0, 1, 0, -1, 0, 0},
        {1, 0, 0, 0, 0, -1, 0, 1, 0},
    };

    for (int axis = 0; axis < 3; axis++) {
        rigcal_real ypr[3] = {0, 0, 0}, R[9];

        ypr[axis] = RC(TEST_PI / 2);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_yaw_pitch_roll(R, ypr));
        assert_same_rotation(quarter[axis], R);
    }
}

static void test_matrices_of_angles_are_the_oracles(void)
{
    for (int i = 0; i < ROTATION_YPR_ROWS; i++) {
        rigcal_real ypr[3], R[9];

        test_to_real(ypr, ROTATION_YPR[i], 3);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_yaw_pitch_roll(R, ypr));
        assert_same_rotation(ROTATION_YPR[i] + 3, R);
        assert_orthonormal(R);
    }
}

/* The accuracy of yaw and roll falls with the cosine of pitch. */
static void test_angles_of_matrices_are_the_oracles(void)
{
    for (int i = 0; i < ROTATION_YPR_ROWS; i++) {
        const double tol = TOL_ENTRY / cos(ROTATION_YPR[i][1]);
        rigcal_real ypr[3], R[9];

        test_to_real(R, ROTATION_YPR[i] + 3, 9);
        ASSERT_STATUS(RIGCAL_OK, rigcal_yaw_pitch_roll_from_rotation(ypr, R));
        ASSERT_ARRAY_NEAR(ROTATION_YPR[i], ypr, 3, tol);
    }
}

static void test_gimbal_lock_gives_roll_as_zero(void)
{
    for (int i = 0; i < ROTATION_LOCK_ROWS; i++) {
        rigcal_real ypr[3], R[9], back[9];

        test_to_real(R, ROTATION_LOCK[i] + 3, 9);
        ASSERT_STATUS(RIGCAL_OK, rigcal_yaw_pitch_roll_from_rotation(ypr, R));
        ASSERT_ARRAY_NEAR(ROTATION_LOCK[i], ypr, 2, TOL_ENTRY);
        TEST_ASSERT_TRUE(ypr[2] == 0);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_yaw_pitch_roll(back, ypr));
        assert_same_rotation(ROTATION_LOCK[i] + 3, back);
    }
}

/* The lock begins where the cosine of the pitch is four times the rounding. */
static void test_where_gimbal_lock_begins(void)
{
    const double sr = sin(0.3), cr = cos(0.3);

    for (int more = 0; more < 2; more++) {
        const rigcal_real c = RC(4 + more) * RC_EPS;
        const double M[9] = {D(c), sr, cr, 0, cr, -sr, -1, D(c) * sr, D(c) * cr};
        rigcal_real R[9], ypr[3];

        test_to_real(R, M, 9);
        ASSERT_STATUS(RIGCAL_OK, rigcal_yaw_pitch_roll_from_rotation(ypr, R));
        ASSERT_NEAR(more ? 0 : -0.3, ypr[0], TOL_ENTRY);
        ASSERT_NEAR(more ? 0.3 : 0, ypr[2], TOL_ENTRY);
    }
}

/* Near gimbal lock yaw and roll may depend on the last digit, but they must give the same
 * matrix. */
static void test_angles_near_gimbal_lock_still_make_the_same_matrix(void)
{
    test_rng rng = test_seed(11);

    for (int i = 0; i < 400; i++) {
        const double near = pow(10, -(double)(i % 20));
        const double pitch = (i & 1 ? 1 : -1) * (TEST_PI / 2 - near);
        double M[9];
        rigcal_real R[9], ypr[3], back[9];

        test_rotation(M, test_uniform(&rng, -3, 3), pitch, test_uniform(&rng, -3, 3));
        test_to_real(R, M, 9);
        ASSERT_STATUS(RIGCAL_OK, rigcal_yaw_pitch_roll_from_rotation(ypr, R));
        ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_yaw_pitch_roll(back, ypr));
        ASSERT_ARRAY_NEAR(M, back, 9, TOL_ENTRY);
    }
}

static void test_angles_stay_within_their_ranges(void)
{
    static const rigcal_real halves[4][9] = {
        {-1, RC(0.0), 0, RC(-0.0), -1, 0, 0, 0, 1},
        {-1, RC(-0.0), 0, RC(0.0), -1, 0, 0, 0, 1},
        {1, 0, 0, 0, -1, RC(0.0), 0, RC(-0.0), -1},
        {1, 0, 0, 0, -1, RC(-0.0), 0, RC(0.0), -1},
    };
    test_rng rng = test_seed(12);

    for (int i = 0; i < 4; i++) {
        rigcal_real ypr[3];

        /* Half a turn is +pi, whatever the sign of the zero beside it. */
        ASSERT_STATUS(RIGCAL_OK, rigcal_yaw_pitch_roll_from_rotation(ypr, halves[i]));
        ASSERT_NEAR(TEST_PI, ypr[i < 2 ? 0 : 2], TOL(1e-15, 1e-6));
    }
    for (int i = 0; i < 300; i++) {
        double M[9];
        rigcal_real R[9], ypr[3];

        test_random_rotation(M, &rng);
        test_to_real(R, M, 9);
        ASSERT_STATUS(RIGCAL_OK, rigcal_yaw_pitch_roll_from_rotation(ypr, R));
        TEST_ASSERT_TRUE(ypr[0] > RC(-TEST_PI) && ypr[0] <= RC(TEST_PI));
        TEST_ASSERT_TRUE(ypr[1] >= RC(-TEST_PI / 2) && ypr[1] <= RC(TEST_PI / 2));
        TEST_ASSERT_TRUE(ypr[2] > RC(-TEST_PI) && ypr[2] <= RC(TEST_PI));
    }
}

static void test_many_turns_are_accepted_up_to_the_limit(void)
{
    const double most = TOL(1e6, 1e3);
    double M[9];
    rigcal_real ypr[3] = {RC(most), RC(-0.75 * most), RC(0.5 * most)}, R[9];

    test_rotation(M, D(ypr[0]), D(ypr[1]), D(ypr[2]));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_yaw_pitch_roll(R, ypr));
    ASSERT_ARRAY_NEAR(M, R, 9, TOL(1e-14, 1e-6));
    assert_orthonormal(R);
    for (int i = 0; i < 3; i++) {
        rigcal_real far[3] = {0, 0, 0};

        far[i] = RC(i == 1 ? -1.01 * most : 1.01 * most);
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, R, rigcal_rotation_from_yaw_pitch_roll(R, far));
    }
}

/* ---- rotation vector ----------------------------------------------------- */

static void test_matrices_of_rotation_vectors_are_scipys(void)
{
    for (int i = 0; i < ROTATION_VECTOR_ROWS; i++) {
        rigcal_real w[3], R[9];

        test_to_real(w, ROTATION_VECTOR[i], 3);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_vector(R, w));
        assert_same_rotation(ROTATION_VECTOR[i] + 3, R);
        assert_orthonormal(R);
    }
}

/* To as many digits as the vector has, even if it is very small. */
static void test_a_rotation_vector_comes_back_from_its_matrix(void)
{
    test_rng rng = test_seed(13);

    for (int i = 0; i < 300; i++) {
        const double angle = i % 2 ? test_uniform(&rng, 0, 3.0)
                                   : pow(10, test_uniform(&rng, TOL(-30, -15), 0));
        double axis[3], M[9], w_true[3];
        rigcal_real R[9], w[3];

        for (int k = 0; k < 3; k++) {
            axis[k] = test_normal(&rng);
        }
        for (int k = 0; k < 3; k++) {
            w_true[k] = axis[k] / test_norm(axis) * angle;
        }
        test_rotation_about(M, axis, angle);
        test_to_real(R, M, 9);
        ASSERT_STATUS(RIGCAL_OK, rigcal_vector_from_rotation(w, R));
        /* The error of the axis of a large turn is eps / sin(angle). */
        ASSERT_ARRAY_NEAR(w_true, w, 3, TOL(1e-14, 5e-6) * (angle > 2 ? 30 : angle));
    }
}

static void test_a_tiny_rotation_vector_survives_both_ways(void)
{
    const rigcal_real w[3] = {RC(1e-12), RC(-2e-12), RC(3e-12)};
    rigcal_real R[9], back[3];

    ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_vector(R, w));
    ASSERT_STATUS(RIGCAL_OK, rigcal_vector_from_rotation(back, R));
    for (int k = 0; k < 3; k++) {
        ASSERT_NEAR(w[k], back[k], TOL(1e-24, 1e-17));
    }
}

static void test_no_rotation_vector_is_the_identity_and_back(void)
{
    const rigcal_real none[3] = {0, 0, 0};
    rigcal_real R[9], w[3];

    ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_vector(R, none));
    for (int i = 0; i < 9; i++) {
        TEST_ASSERT_TRUE(R[i] == IDENTITY[i]);
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_vector_from_rotation(w, IDENTITY));
    for (int k = 0; k < 3; k++) {
        TEST_ASSERT_TRUE(w[k] == 0);
    }
}

/* R = 2 a a^T - I. The antisymmetric part, which otherwise gives the axis, is 0. Either
 * sign of the axis is right. */
static void test_half_turns_about_any_axis_give_their_axis(void)
{
    static const double axes[7][3] = {
        {1, 0, 0},
        {0, 1, 0},
        {0, 0, 1},
        {0.6, 0.8, 0},
        {0, -0.6, 0.8},
        {-0.8, 0, 0.6},
        {2.0 / 3, -2.0 / 3, 1.0 / 3},
    };

    for (int i = 0; i < 7; i++) {
        const double *a = axes[i];
        double along, w_seen[3];
        rigcal_real R[9], w[3];

        for (int k = 0; k < 9; k++) {
            R[k] = RC(2 * a[k / 3] * a[k % 3] - (k % 4 == 0));
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_vector_from_rotation(w, R));
        test_to_double(w_seen, w, 3);
        ASSERT_NEAR(TEST_PI, test_norm(w_seen), TOL(1e-14, 1e-6));
        along = test_dot(w_seen, a) < 0 ? -1 : 1;
        for (int k = 0; k < 3; k++) {
            ASSERT_NEAR(along * TEST_PI * a[k], w[k], TOL(1e-14, 2e-6));
        }
    }
}

static void test_nearly_half_turns_make_the_same_matrix_again(void)
{
    test_rng rng = test_seed(14);

    for (int i = 0; i < 400; i++) {
        const double angle = TEST_PI - pow(10, -(double)(i % 17));
        double axis[3], M[9], w_seen[3];
        rigcal_real R[9], w[3], back[9];

        for (int k = 0; k < 3; k++) {
            axis[k] = test_normal(&rng) * (i % 3 == k ? 1 : pow(10, -(i % 7)));
        }
        test_rotation_about(M, axis, angle);
        test_to_real(R, M, 9);
        ASSERT_STATUS(RIGCAL_OK, rigcal_vector_from_rotation(w, R));
        test_to_double(w_seen, w, 3);
        TEST_ASSERT_TRUE(test_norm(w_seen) <= TEST_PI * (1 + TOL(4e-16, 3e-7)));
        ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_vector(back, w));
        ASSERT_ARRAY_NEAR(M, back, 9, TOL(2e-14, 3e-6));
    }
}

/* The square of these angles is 0 in this precision. */
static void test_a_turn_too_small_to_be_squared_is_not_lost(void)
{
    const double tiny = TOL(1e-200, 1e-30);
    const rigcal_real R[9] = {1, RC(-3 * tiny), RC(2 * tiny),  RC(3 * tiny),
                              1, RC(-tiny),     RC(-2 * tiny), RC(tiny),
                              1};
    rigcal_real w[3];

    ASSERT_STATUS(RIGCAL_OK, rigcal_vector_from_rotation(w, R));
    for (int k = 0; k < 3; k++) {
        ASSERT_NEAR(k + 1, D(w[k]) / tiny, TOL(1e-12, 1e-5));
    }
}

static void test_a_rotation_vector_beyond_the_limit_is_refused(void)
{
    const double most = TOL(1e6, 1e3);
    const rigcal_real far[3] = {RC(0.6 * most), RC(-0.6 * most), RC(0.6 * most)};
    const rigcal_real near[3] = {RC(0.5 * most), RC(-0.5 * most), RC(0.5 * most)};
    const rigcal_real huge[3] = {RC(TOL(1e300, 1e30)), 0, 0};
    rigcal_real R[9];

    ASSERT_REFUSED(RIGCAL_ERR_RANGE, R, rigcal_rotation_from_vector(R, far));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, R, rigcal_rotation_from_vector(R, huge));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_vector(R, near));
    assert_orthonormal(R);
}

/* ---- quaternion ---------------------------------------------------------- */

static void test_quaternions_of_quarter_and_half_turns_are_known(void)
{
    static const rigcal_real q[5][4] = {
        {3, 0, 0, 0}, {0, 2, 0, 0}, {1, 1, 0, 0}, {1, 0, 0, 1}, {0, 0, 0, -5}};
    static const double R_of_q[5][9] = {
        {1, 0, 0, 0, 1, 0, 0, 0, 1},   {1, 0, 0, 0, -1, 0, 0, 0, -1},
        {1, 0, 0, 0, 0, -1, 0, 1, 0},  {0, -1, 0, 1, 0, 0, 0, 0, 1},
        {-1, 0, 0, 0, -1, 0, 0, 0, 1},
    };

    for (int i = 0; i < 5; i++) {
        rigcal_real R[9];

        ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_quaternion(R, q[i]));
        assert_same_rotation(R_of_q[i], R);
    }
}

static void test_quaternions_and_their_opposites_agree_with_scipy(void)
{
    for (int i = 0; i < ROTATION_QUATERNION_ROWS; i++) {
        rigcal_real q[4], opposite[4], R[9];

        test_to_real(q, ROTATION_QUATERNION[i], 4);
        for (int k = 0; k < 4; k++) {
            opposite[k] = -q[k];
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_quaternion(R, q));
        assert_same_rotation(ROTATION_QUATERNION[i] + 4, R);
        assert_orthonormal(R);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_quaternion(R, opposite));
        assert_same_rotation(ROTATION_QUATERNION[i] + 4, R);
    }
}

static void test_a_unit_quaternion_comes_back_with_w_not_negative(void)
{
    for (int i = 0; i < ROTATION_QUATERNION_ROWS; i++) {
        const double *v = ROTATION_QUATERNION[i];
        const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3]);
        rigcal_real q[4], R[9];

        test_to_real(R, v + 4, 9);
        ASSERT_STATUS(RIGCAL_OK, rigcal_quaternion_from_rotation(q, R));
        TEST_ASSERT_TRUE(q[0] >= 0);
        for (int k = 0; k < 4; k++) {
            ASSERT_NEAR(v[k] / length, q[k], TOL(1e-14, 2e-6));
        }
    }
}

/* w = 0, and each of x, y, z is the largest in turn. */
static void test_half_turns_have_quaternions_too(void)
{
    static const double axes[4][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.48, 0.64, -0.6}};

    for (int i = 0; i < 4; i++) {
        const double *a = axes[i];
        double sign;
        rigcal_real R[9], q[4];

        for (int k = 0; k < 9; k++) {
            R[k] = RC(2 * a[k / 3] * a[k % 3] - (k % 4 == 0));
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_quaternion_from_rotation(q, R));
        TEST_ASSERT_TRUE(q[0] >= 0);
        ASSERT_NEAR(0, q[0], TOL(1e-15, 1e-6));
        sign = D(q[1]) * a[0] + D(q[2]) * a[1] + D(q[3]) * a[2] < 0 ? -1 : 1;
        for (int k = 0; k < 3; k++) {
            ASSERT_NEAR(sign * a[k], q[k + 1], TOL(1e-14, 1e-6));
        }
    }
}

/* The quaternion is (w, a sqrt(1 - w^2)), its matrix the one of the textbook. Two parts of
 * the axis are as large, and w is so small that its square is rounding. */
static void test_nearly_half_turns_keep_the_digits_of_their_quaternions(void)
{
    static const double w[3] = {1e-3, 1e-6, 1e-9};

    for (int i = 0; i < 3 * 12; i++) {
        const int none = i / 4 % 3; /* the part that is 0 */
        double q[4] = {w[i / 12], 0, 0, 0};
        rigcal_real R[9], seen[4];

        q[1 + (none + 1) % 3] = (i & 1) ? -sqrt(0.5) : sqrt(0.5);
        q[1 + (none + 2) % 3] = (i & 2) ? -sqrt(0.5) : sqrt(0.5);
        for (int k = 1; k < 4; k++) {
            q[k] *= sqrt(1 - q[0] * q[0]);
        }
        for (int row = 0; row < 3; row++) {
            for (int c = 0; c < 3; c++) {
                const int third = 3 - row - c; /* where row and c differ */
                const double turn = (c == (row + 1) % 3) ? -q[0] : q[0];

                R[3 * row + c] =
                    RC(row == c ? 2 * (q[0] * q[0] + q[1 + c] * q[1 + c]) - 1
                                : 2 * (q[1 + row] * q[1 + c] + turn * q[1 + third]));
            }
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_quaternion_from_rotation(seen, R));
        for (int k = 0; k < 4; k++) {
            ASSERT_NEAR(q[k], seen[k], TOL(1e-15, 5e-7));
        }
    }
}

static void test_a_quaternion_may_have_any_length_but_zero(void)
{
    static const rigcal_real none[4] = {0, 0, 0, 0};
    const double lengths[4] = {TOL(1e300, 1e37), TOL(1e-300, 1e-37), 1e5, 1e-5};
    rigcal_real R[9];

    for (int i = 0; i < 4; i++) {
        rigcal_real q[4];

        for (int k = 0; k < 4; k++) {
            q[k] = RC(ROTATION_QUATERNION[0][k] * lengths[i]);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_quaternion(R, q));
        assert_same_rotation(ROTATION_QUATERNION[0] + 4, R);
    }
    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, R, rigcal_rotation_from_quaternion(R, none));
}

/* ---- nearest ------------------------------------------------------------- */

static void test_the_nearest_rotation_is_the_svds(void)
{
    for (int i = 0; i < ROTATION_NEAREST_ROWS; i++) {
        rigcal_real M[9], R[9];

        test_to_real(M, ROTATION_NEAREST[i], 9);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_nearest(R, M));
        /* M's least singular value is at least a twentieth of its largest. */
        ASSERT_ARRAY_NEAR(ROTATION_NEAREST[i] + 9, R, 9, TOL(1e-13, 2e-5));
        assert_orthonormal(R);
    }
}

static void test_the_nearest_to_a_scaled_rotation_is_that_rotation(void)
{
    const double scales[7] = {1, 1e-3, 1e3, TOL(1e-100, 1e-12), TOL(1e100, 1e12), 7, 0.3};

    for (int i = 0; i < 7; i++) {
        const double *R_true = ROTATION_YPR[20 + i] + 3;
        rigcal_real M[9], R[9];

        for (int k = 0; k < 9; k++) {
            M[k] = RC(R_true[k] * scales[i]);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_nearest(R, M));
        assert_same_rotation(R_true, R);
    }
}

static void test_a_singular_matrix_has_no_nearest_rotation(void)
{
    static const rigcal_real zero[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
    static const rigcal_real rank_two[9] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
    static const rigcal_real flat[9] = {1, 0, 0, 0, 1, 0, 0, 0, 0};
    rigcal_real R[9];

    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, R, rigcal_rotation_nearest(R, zero));
    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, R, rigcal_rotation_nearest(R, rank_two));
    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, R, rigcal_rotation_nearest(R, flat));
}

static void test_a_mirror_has_no_nearest_rotation(void)
{
    rigcal_real M[9], R[9];

    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, R, rigcal_rotation_nearest(R, MIRROR));
    for (int k = 0; k < 9; k++) {
        M[k] = RC(-ROTATION_YPR[30][3 + k]);
    }
    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, R, rigcal_rotation_nearest(R, M));
}

/* ---- tidy ---------------------------------------------------------------- */

/* Elements with errors as large as many roundings leave. */
static void test_a_tidied_rotation_is_one_and_where_it_was(void)
{
    const double off = TOL(1e-12, 1e-4);
    test_rng rng = test_seed(17);

    for (int trial = 0; trial < TEST_TRIALS(2000); trial++) {
        double M[9];
        rigcal_real R[9], first[3];

        test_random_rotation(M, &rng);
        for (int k = 0; k < 9; k++) {
            R[k] = RC(M[k] + test_uniform(&rng, -off, off));
        }
        for (int k = 0; k < 3; k++) {
            first[k] = R[k];
        }
        rc_rotation_tidy(R);
        assert_orthonormal(R);
        for (int k = 0; k < 9; k++) {
            ASSERT_NEAR(M[k], R[k], 6 * off);
        }
        for (int k = 0; k < 3; k++) {
            ASSERT_NEAR(0, R[k] * first[(k + 1) % 3] - R[(k + 1) % 3] * first[k],
                        TOL(1e-15, 3e-7));
        }
    }
}

/* ---- angle --------------------------------------------------------------- */

static void test_the_angle_between_rotations_is_what_was_turned(void)
{
    test_rng rng = test_seed(15);

    for (int i = 0; i < 300; i++) {
        const double angle =
            i % 3 ? test_uniform(&rng, 0, TEST_PI) : TEST_PI - pow(10, -(double)(i % 15));
        double A[9], turn[9], B[9], axis[3];
        rigcal_real Ra[9], Rb[9], there, back;

        for (int k = 0; k < 3; k++) {
            axis[k] = test_normal(&rng);
        }
        test_random_rotation(A, &rng);
        test_rotation_about(turn, axis, angle);
        test_product(B, turn, A);
        test_to_real(Ra, A, 9);
        test_to_real(Rb, B, 9);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_angle(&there, Ra, Rb));
        ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_angle(&back, Rb, Ra));
        /* Near pi the cosine is flat: a rounding of eps moves the angle by sqrt(eps),
         * unless the sine is used too. */
        ASSERT_NEAR(angle, there, TOL(2e-15, 1e-6));
        ASSERT_NEAR(there, back, TOL(1e-15, 5e-7));
        TEST_ASSERT_TRUE(there >= 0 && D(there) <= TEST_PI * (1 + TOL(0, 1e-7)));
    }
}

static void test_the_smallest_angles_keep_their_digits(void)
{
    static const double axis[3] = {1, -2, 2};

    for (int i = 1; i < 15; i++) {
        const double angle = pow(10, -i);
        double M[9];
        rigcal_real R[9], seen;

        test_rotation_about(M, axis, angle);
        test_to_real(R, M, 9);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_angle(&seen, IDENTITY, R));
        ASSERT_NEAR(angle, seen, TOL(1e-14, 1e-6) * angle);
    }
}

static void test_a_rotation_is_no_angle_from_itself(void)
{
    for (int i = 0; i < ROTATION_YPR_ROWS; i++) {
        rigcal_real R[9], seen;

        test_to_real(R, ROTATION_YPR[i] + 3, 9);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_angle(&seen, R, R));
        ASSERT_NEAR(0, seen, TOL(1e-15, 5e-7));
    }
}

/* ---- what is refused ----------------------------------------------------- */

static void test_null_is_refused_in_every_place(void)
{
    const rigcal_real ypr[3] = {0, 0, 0}, q[4] = {1, 0, 0, 0};
    rigcal_real R[9], v[3], p[4], angle;

    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rotation_from_yaw_pitch_roll(NULL, ypr));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, R, rigcal_rotation_from_yaw_pitch_roll(R, NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_yaw_pitch_roll_from_rotation(NULL, IDENTITY));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, v, rigcal_yaw_pitch_roll_from_rotation(v, NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rotation_from_vector(NULL, ypr));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, R, rigcal_rotation_from_vector(R, NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_vector_from_rotation(NULL, IDENTITY));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, v, rigcal_vector_from_rotation(v, NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rotation_from_quaternion(NULL, q));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, R, rigcal_rotation_from_quaternion(R, NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_quaternion_from_rotation(NULL, IDENTITY));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, p, rigcal_quaternion_from_rotation(p, NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rotation_nearest(NULL, IDENTITY));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, R, rigcal_rotation_nearest(R, NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rotation_angle(NULL, IDENTITY, IDENTITY));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, angle, rigcal_rotation_angle(&angle, NULL, IDENTITY));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, angle, rigcal_rotation_angle(&angle, IDENTITY, NULL));
}

static void test_a_number_that_is_not_finite_is_refused_in_every_place(void)
{
    const rigcal_real bad[3] = {TEST_NAN, TEST_INF, -TEST_INF};

    for (int i = 0; i < 27; i++) {
        rigcal_real M[9], w[3] = {0, 0, 0}, q[4] = {1, 0, 0, 0};
        rigcal_real R[9], v[3], p[4], angle;

        for (int k = 0; k < 9; k++) {
            M[k] = k == i / 3 ? bad[i % 3] : IDENTITY[k];
        }
        w[i / 9] = bad[i % 3];
        q[i / 3 % 4] = bad[i % 3];
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, R, rigcal_rotation_from_yaw_pitch_roll(R, w));
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, R, rigcal_rotation_from_vector(R, w));
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, R, rigcal_rotation_from_quaternion(R, q));
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, v, rigcal_yaw_pitch_roll_from_rotation(v, M));
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, v, rigcal_vector_from_rotation(v, M));
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, p, rigcal_quaternion_from_rotation(p, M));
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, R, rigcal_rotation_nearest(R, M));
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, angle,
                       rigcal_rotation_angle(&angle, M, IDENTITY));
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, angle,
                       rigcal_rotation_angle(&angle, IDENTITY, M));
    }
}

static void assert_not_taken_for_a_rotation(const rigcal_real M[9])
{
    rigcal_real v[3], p[4], angle;

    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, v, rigcal_yaw_pitch_roll_from_rotation(v, M));
    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, v, rigcal_vector_from_rotation(v, M));
    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, p, rigcal_quaternion_from_rotation(p, M));
    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, angle, rigcal_rotation_angle(&angle, M, IDENTITY));
    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, angle, rigcal_rotation_angle(&angle, IDENTITY, M));
}

static void test_a_matrix_that_is_no_rotation_is_refused(void)
{
    static const rigcal_real zero[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
    const rigcal_real off = RC(TOL(1e-5, 1e-2));
    rigcal_real M[9];

    assert_not_taken_for_a_rotation(zero);
    assert_not_taken_for_a_rotation(MIRROR);
    for (int i = 0; i < 9; i++) {
        for (int k = 0; k < 9; k++) {
            M[k] = IDENTITY[k] + (k == i ? off : 0);
        }
        assert_not_taken_for_a_rotation(M);
    }
    for (int k = 0; k < 9; k++) {
        M[k] = IDENTITY[k] * RC(TOL(1e200, 1e30));
    }
    assert_not_taken_for_a_rotation(M);
}

static void test_a_matrix_off_by_less_than_allowed_is_taken(void)
{
    const rigcal_real off = RC(TOL(1e-7, 1e-4));
    rigcal_real M[9], v[3], p[4], angle;

    for (int i = 0; i < 9; i++) {
        for (int k = 0; k < 9; k++) {
            M[k] = IDENTITY[k] + (k == i ? off : 0);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_yaw_pitch_roll_from_rotation(v, M));
        ASSERT_STATUS(RIGCAL_OK, rigcal_vector_from_rotation(v, M));
        ASSERT_STATUS(RIGCAL_OK, rigcal_quaternion_from_rotation(p, M));
        ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_angle(&angle, M, IDENTITY));
        ASSERT_NEAR(0, angle, TOL(2e-7, 2e-4));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_no_angles_are_the_identity);
    RUN_TEST(test_a_quarter_turn_takes_each_axis_to_the_next);
    RUN_TEST(test_matrices_of_angles_are_the_oracles);
    RUN_TEST(test_angles_of_matrices_are_the_oracles);
    RUN_TEST(test_gimbal_lock_gives_roll_as_zero);
    RUN_TEST(test_where_gimbal_lock_begins);
    RUN_TEST(test_angles_near_gimbal_lock_still_make_the_same_matrix);
    RUN_TEST(test_angles_stay_within_their_ranges);
    RUN_TEST(test_many_turns_are_accepted_up_to_the_limit);
    RUN_TEST(test_matrices_of_rotation_vectors_are_scipys);
    RUN_TEST(test_a_rotation_vector_comes_back_from_its_matrix);
    RUN_TEST(test_a_tiny_rotation_vector_survives_both_ways);
    RUN_TEST(test_no_rotation_vector_is_the_identity_and_back);
    RUN_TEST(test_half_turns_about_any_axis_give_their_axis);
    RUN_TEST(test_nearly_half_turns_make_the_same_matrix_again);
    RUN_TEST(test_a_turn_too_small_to_be_squared_is_not_lost);
    RUN_TEST(test_a_rotation_vector_beyond_the_limit_is_refused);
    RUN_TEST(test_quaternions_of_quarter_and_half_turns_are_known);
    RUN_TEST(test_quaternions_and_their_opposites_agree_with_scipy);
    RUN_TEST(test_a_unit_quaternion_comes_back_with_w_not_negative);
    RUN_TEST(test_half_turns_have_quaternions_too);
    RUN_TEST(test_nearly_half_turns_keep_the_digits_of_their_quaternions);
    RUN_TEST(test_a_quaternion_may_have_any_length_but_zero);
    RUN_TEST(test_the_nearest_rotation_is_the_svds);
    RUN_TEST(test_the_nearest_to_a_scaled_rotation_is_that_rotation);
    RUN_TEST(test_a_singular_matrix_has_no_nearest_rotation);
    RUN_TEST(test_a_mirror_has_no_nearest_rotation);
    RUN_TEST(test_a_tidied_rotation_is_one_and_where_it_was);
    RUN_TEST(test_the_angle_between_rotations_is_what_was_turned);
    RUN_TEST(test_the_smallest_angles_keep_their_digits);
    RUN_TEST(test_a_rotation_is_no_angle_from_itself);
    RUN_TEST(test_null_is_refused_in_every_place);
    RUN_TEST(test_a_number_that_is_not_finite_is_refused_in_every_place);
    RUN_TEST(test_a_matrix_that_is_no_rotation_is_refused);
    RUN_TEST(test_a_matrix_off_by_less_than_allowed_is_taken);
}
