/* The linear algebra under everything: cases on paper and identities. */
#include "rc_linalg.h"
#include "test_support.h"

#define TOL_ROUNDING TOL(1e-14, 1e-5)

static void random_vector(rigcal_real v[], int n, test_rng *rng)
{
    for (int i = 0; i < n; i++) {
        v[i] = RC(test_uniform(rng, -1, 1));
    }
}

void test_the_cross_product_of_x_and_y_is_z_and_turns_over_when_swapped(void)
{
    const rigcal_real x[3] = {2, 0, 0}, y[3] = {0, 3, 0};
    rigcal_real c[3];
    rc_vec3_cross(c, x, y);
    ASSERT_ARRAY_NEAR(((double[]){0, 0, 6}), c, 3, 0);
    rc_vec3_cross(c, y, x);
    ASSERT_ARRAY_NEAR(((double[]){0, 0, -6}), c, 3, 0);
}

void test_a_2_3_6_vector_has_length_7(void)
{
    const rigcal_real v[3] = {2, -3, 6};
    rigcal_real unit[3];
    ASSERT_NEAR(7, rc_vec3_norm(v), TOL_ROUNDING);
    ASSERT_NEAR(6, rc_vec3_max_abs(v), 0);
    TEST_ASSERT_TRUE(rc_vec3_unit(unit, v));
    ASSERT_ARRAY_NEAR(((double[]){2.0 / 7, -3.0 / 7, 6.0 / 7}), unit, 3,
                      TOL_ROUNDING);
}

void test_unit_vectors_survive_lengths_whose_squares_do_not_exist(void)
{
    const rigcal_real sizes[4] = {RC_MAX, RC_MAX / 4, RC(FLT_MIN),
                                  RC_TOL(5e-324, 1.5e-45)};
    for (int i = 0; i < 4; i++) {
        const rigcal_real v[3] = {0, sizes[i], -sizes[i]};
        rigcal_real unit[3];
        TEST_ASSERT_TRUE(rc_vec3_unit(unit, v));
        ASSERT_ARRAY_NEAR(((double[]){0, 0.70710678118654752,
                                      -0.70710678118654752}),
                          unit, 3, TOL_ROUNDING);
    }
}

void test_the_zero_vector_has_no_direction(void)
{
    const rigcal_real zero[3] = {0, 0, 0};
    rigcal_real unit[3];
    FILL(unit);
    TEST_ASSERT_FALSE(rc_vec3_unit(unit, zero));
    ASSERT_UNTOUCHED(unit);
}

void test_matrix_products_on_paper(void)
{
    const rigcal_real A[9] = {1, 2, 3, 4, 5, 6, 7, 8, 10};
    const rigcal_real B[9] = {0, 1, 0, 0, 0, 1, 2, 0, 0};
    const rigcal_real v[3] = {1, -1, 2};
    rigcal_real out[9];
    rc_mat3_mul_vec3(out, A, v);
    ASSERT_ARRAY_NEAR(((double[]){5, 11, 19}), out, 3, 0);
    rc_mat3_tmul_vec3(out, A, v);
    ASSERT_ARRAY_NEAR(((double[]){11, 13, 17}), out, 3, 0);
    rc_mat3_mul(out, A, B);
    ASSERT_ARRAY_NEAR(((double[]){6, 1, 2, 12, 4, 5, 20, 7, 8}), out, 9, 0);
    rc_mat3_mul_t(out, A, B);
    ASSERT_ARRAY_NEAR(((double[]){2, 3, 2, 5, 6, 8, 8, 10, 14}), out, 9, 0);
}

void test_cofactors_times_the_matrix_are_its_determinant(void)
{
    const rigcal_real A[9] = {1, 2, 3, 4, 5, 6, 7, 8, 10};
    rigcal_real cofactors[9], product[9];
    ASSERT_NEAR(-3, rc_mat3_cofactors(cofactors, A), 0);
    rc_mat3_mul_t(product, A, cofactors);
    ASSERT_ARRAY_NEAR(((double[]){-3, 0, 0, 0, -3, 0, 0, 0, -3}), product, 9, 0);
}

void test_combinations_outer_products_and_symmetric_products_on_paper(void)
{
    const rigcal_real a[3] = {1, -2, 3}, b[3] = {4, 0, -1};
    rigcal_real A[6] = {1, 0, 2, 0, 5, 1}, out[3];
    rc_vec3_combine(out, 2, a, -1, b);
    ASSERT_ARRAY_NEAR(((double[]){-2, -4, 7}), out, 3, 0);
    rc_sym3_add_outer(A, 2, a);
    ASSERT_ARRAY_NEAR(((double[]){3, -4, 8, 8, -7, 19}), A, 6, 0);
    rc_sym3_mul_vec3(out, A, b);
    ASSERT_ARRAY_NEAR(((double[]){4, -9, 13}), out, 3, 0);
}

/* L L^T with L = [2 0 0; 6 1 0; -8 5 4] is [4 12 -16; 12 37 -43; -16 -43 105]. */
void test_a_cholesky_factor_on_paper(void)
{
    const rigcal_real diagonal[3] = {4, 37, 105};
    rigcal_real A[6] = {4, 12, -16, 37, -43, 105};
    rigcal_real x[3] = {2, 7, -1};
    TEST_ASSERT_TRUE(rc_sym3_factor(A, A, diagonal, 0));
    ASSERT_ARRAY_NEAR(((double[]){0.5, 6, -8, 1, 5, 0.25}), A, 6, 0);
    rc_sym3_forward(x, A); /* 2 x = 2, 6 x + y = 7, -8 x + 5 y + 4 z = -1 */
    ASSERT_ARRAY_NEAR(((double[]){1, 1, 0.5}), x, 3, 0);
    rc_sym3_backward(x, A); /* 4 z = 0.5, y + 5 z = 1, 2 x + 6 y - 8 z = 1 */
    ASSERT_ARRAY_NEAR(((double[]){-0.125, 0.375, 0.125}), x, 3, 0);
}

/* B B^T + I is positive definite, with eigenvalues of 1 at least. */
void test_solutions_put_back_give_the_right_side(void)
{
    test_rng rng = test_seed(1);
    for (int trial = 0; trial < 200; trial++) {
        rigcal_real A[6] = {1, 0, 0, 1, 0, 1}, L[6], x[3], b[3], back[3];
        for (int k = 0; k < 3; k++) {
            random_vector(x, 3, &rng);
            rc_sym3_add_outer(A, 1, x);
        }
        const rigcal_real diagonal[3] = {A[0], A[3], A[5]};
        random_vector(b, 3, &rng);
        rc_vec3_copy(x, b);
        TEST_ASSERT_TRUE(rc_sym3_factor(L, A, diagonal, 4 * RC_EPS));
        rc_sym3_forward(x, L);
        rc_sym3_backward(x, L);
        rc_sym3_mul_vec3(back, A, x);
        ASSERT_ARRAY_NEAR(((double[]){D(b[0]), D(b[1]), D(b[2])}), back, 3,
                          TOL(1e-13, 1e-5));
    }
}

static int has_factor(double xx, double xy, double xz, double yy, double yz, double zz,
                      double rank_tol)
{
    const rigcal_real A[6] = {RC(xx), RC(xy), RC(xz), RC(yy), RC(yz), RC(zz)};
    const rigcal_real diagonal[3] = {A[0], A[3], A[5]};
    rigcal_real L[6];
    return rc_sym3_factor(L, A, diagonal, RC(rank_tol));
}

void test_singular_indefinite_and_nan_matrices_have_no_factor(void)
{
    const double eps = 4 * D(RC_EPS);
    TEST_ASSERT_TRUE(has_factor(1, 0, 0, 1, 0, 1, eps));
    TEST_ASSERT_FALSE(has_factor(1, 2, 0, 4, 0, 1, eps)); /* singular */
    TEST_ASSERT_FALSE(has_factor(1, 0, 2, 1, 0, 4, eps));
    TEST_ASSERT_FALSE(has_factor(1, 0, 0, 1, 2, 4, eps));
    TEST_ASSERT_FALSE(has_factor(0, 0, 0, 1, 0, 1, eps));
    TEST_ASSERT_FALSE(has_factor(1, 2, 0, 1, 0, 1, eps)); /* indefinite */
    TEST_ASSERT_FALSE(has_factor(-1, 0, 0, 1, 0, 1, eps));
    TEST_ASSERT_FALSE(has_factor(1, 0, 0, 1, 0, -1, eps));
    TEST_ASSERT_FALSE(has_factor(test_nan(), 0, 0, 1, 0, 1, eps));
    TEST_ASSERT_FALSE(has_factor(1, test_nan(), 0, 1, 0, 1, eps));
    TEST_ASSERT_FALSE(has_factor(1, 0, 0, 1, test_nan(), 1, eps));
}

/* [1 1; 1 1 + d] leaves the pivot d of a diagonal 1 + d. */
void test_the_rank_tolerance_is_what_a_pivot_must_keep_of_its_diagonal(void)
{
    TEST_ASSERT_TRUE(has_factor(1, 1, 0, 1.02, 0, 1, 0.01));
    TEST_ASSERT_FALSE(has_factor(1, 1, 0, 1.005, 0, 1, 0.01));
    TEST_ASSERT_TRUE(has_factor(1, 0, 1, 1, 0, 1.02, 0.01));
    TEST_ASSERT_FALSE(has_factor(1, 0, 1, 1, 0, 1.005, 0.01));
}

/* What is wrong with numbers: the first of NULL, not finite, too large. */
void test_numbers_are_checked(void)
{
    const rigcal_real good[3] = {1, -2, 2}, large[3] = {1, RC(-2.5), 2};
    const rigcal_real infinite[3] = {3, 0, TEST_INF}, nan[3] = {TEST_NAN, 3, 0};
    ASSERT_STATUS(RIGCAL_OK, rc_check_numbers(good, 3, 2));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rc_check_numbers(NULL, 3, 2));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rc_check_numbers(large, 3, 2));
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rc_check_numbers(infinite, 3, 2));
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rc_check_numbers(nan, 3, 2));
}

TEST_MAIN()
{
    RUN_TEST(test_the_cross_product_of_x_and_y_is_z_and_turns_over_when_swapped);
    RUN_TEST(test_a_2_3_6_vector_has_length_7);
    RUN_TEST(test_unit_vectors_survive_lengths_whose_squares_do_not_exist);
    RUN_TEST(test_the_zero_vector_has_no_direction);
    RUN_TEST(test_matrix_products_on_paper);
    RUN_TEST(test_cofactors_times_the_matrix_are_its_determinant);
    RUN_TEST(test_combinations_outer_products_and_symmetric_products_on_paper);
    RUN_TEST(test_a_cholesky_factor_on_paper);
    RUN_TEST(test_solutions_put_back_give_the_right_side);
    RUN_TEST(test_singular_indefinite_and_nan_matrices_have_no_factor);
    RUN_TEST(test_the_rank_tolerance_is_what_a_pivot_must_keep_of_its_diagonal);
    RUN_TEST(test_numbers_are_checked);
}
