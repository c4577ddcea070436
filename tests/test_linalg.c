/* The linear algebra under everything: cases on paper and identities. */
#include "rc_linalg.h"
#include "test_support.h"

#define TOL_ROUNDING TOL(1e-14, 1e-5)

void setUp(void) {}
void tearDown(void) {}

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

/* L L^T with L = [2 0; 3 4] is [4 6; 6 25]. */
void test_a_2_by_2_cholesky_factor_on_paper(void)
{
    rigcal_real A[4] = {4, 99, 6, 25}; /* the upper triangle is not read */
    rigcal_real x[2] = {14, 56};
    TEST_ASSERT_TRUE(rc_cholesky(A, 2, 0));
    ASSERT_ARRAY_NEAR(((double[]){2, 99, 3, 4}), A, 4, 0);
    rc_cholesky_solve(x, A, 2); /* 4 x + 6 y = 14, 6 x + 25 y = 56 */
    ASSERT_ARRAY_NEAR(((double[]){14.0 / 64, 35.0 / 16}), x, 2, TOL_ROUNDING);
}

/* B B^T + I is positive definite, with eigenvalues of 1 at least. */
static void random_positive_definite(rigcal_real A[], int n, test_rng *rng)
{
    rigcal_real B[RC_CHOLESKY_MAX * RC_CHOLESKY_MAX];
    random_vector(B, n * n, rng);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            A[i * n + j] = (i == j) ? 1 : 0;
            for (int k = 0; k < n; k++) {
                A[i * n + j] += B[i * n + k] * B[j * n + k];
            }
        }
    }
}

void test_solutions_put_back_give_the_right_side_in_every_size(void)
{
    test_rng rng = test_seed(1);
    for (int n = 1; n <= RC_CHOLESKY_MAX; n++) {
        for (int trial = 0; trial < 50; trial++) {
            rigcal_real A[36], L[36], x[6], b[6];
            random_positive_definite(A, n, &rng);
            random_vector(b, n, &rng);
            for (int i = 0; i < n * n; i++) {
                L[i] = A[i];
            }
            for (int i = 0; i < n; i++) {
                x[i] = b[i];
            }
            TEST_ASSERT_TRUE(rc_cholesky(L, n, 4 * RC_EPS));
            rc_cholesky_solve(x, L, n);
            for (int i = 0; i < n; i++) {
                double sum = 0;
                for (int j = 0; j < n; j++) {
                    sum += D(A[i * n + j]) * D(x[j]);
                }
                ASSERT_NEAR(b[i], sum, TOL(1e-13, 1e-5));
            }
        }
    }
}

void test_the_inverse_times_the_matrix_is_the_identity(void)
{
    test_rng rng = test_seed(2);
    for (int n = 1; n <= RC_CHOLESKY_MAX; n++) {
        rigcal_real A[36], L[36], inverse[36];
        random_positive_definite(A, n, &rng);
        for (int i = 0; i < n * n; i++) {
            L[i] = A[i];
        }
        TEST_ASSERT_TRUE(rc_cholesky(L, n, 4 * RC_EPS));
        rc_cholesky_inverse(inverse, L, n);
        for (int i = 0; i < n; i++) {
            for (int j = 0; j < n; j++) {
                double sum = 0;
                for (int k = 0; k < n; k++) {
                    sum += D(A[i * n + k]) * D(inverse[k * n + j]);
                }
                ASSERT_NEAR(i == j, sum, TOL(1e-13, 1e-5));
            }
        }
    }
}

void test_singular_indefinite_and_nan_matrices_have_no_factor(void)
{
    rigcal_real singular[4] = {1, 2, 2, 4};
    rigcal_real indefinite[4] = {1, 2, 2, 1};
    rigcal_real negative[1] = {-1};
    rigcal_real zero[1] = {0};
    rigcal_real nan[1] = {TEST_NAN};
    TEST_ASSERT_FALSE(rc_cholesky(singular, 2, 4 * RC_EPS));
    TEST_ASSERT_FALSE(rc_cholesky(indefinite, 2, 4 * RC_EPS));
    TEST_ASSERT_FALSE(rc_cholesky(negative, 1, 4 * RC_EPS));
    TEST_ASSERT_FALSE(rc_cholesky(zero, 1, 4 * RC_EPS));
    TEST_ASSERT_FALSE(rc_cholesky(nan, 1, 4 * RC_EPS));
}

/* [1 1; 1 1 + d] leaves the pivot d of a diagonal 1 + d. */
void test_the_rank_tolerance_is_what_a_pivot_must_keep_of_its_diagonal(void)
{
    rigcal_real kept[4] = {1, 1, 1, RC(1.02)};
    rigcal_real lost[4] = {1, 1, 1, RC(1.005)};
    TEST_ASSERT_TRUE(rc_cholesky(kept, 2, RC(0.01)));
    TEST_ASSERT_FALSE(rc_cholesky(lost, 2, RC(0.01)));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_the_cross_product_of_x_and_y_is_z_and_turns_over_when_swapped);
    RUN_TEST(test_a_2_3_6_vector_has_length_7);
    RUN_TEST(test_unit_vectors_survive_lengths_whose_squares_do_not_exist);
    RUN_TEST(test_the_zero_vector_has_no_direction);
    RUN_TEST(test_matrix_products_on_paper);
    RUN_TEST(test_cofactors_times_the_matrix_are_its_determinant);
    RUN_TEST(test_a_2_by_2_cholesky_factor_on_paper);
    RUN_TEST(test_solutions_put_back_give_the_right_side_in_every_size);
    RUN_TEST(test_the_inverse_times_the_matrix_is_the_identity);
    RUN_TEST(test_singular_indefinite_and_nan_matrices_have_no_factor);
    RUN_TEST(test_the_rank_tolerance_is_what_a_pivot_must_keep_of_its_diagonal);
    return UNITY_END();
}
