/* linalg: cases computed by hand, identities, and plain double arithmetic. */
#include <math.h>
#include <string.h>

#include "rc_linalg.h"
#include "test_support.h"

#define TOL_ROUNDING TOL(1e-14, 1e-5)

static void random_vector(rigcal_real v[], int n, test_rng *rng)
{
    for (int i = 0; i < n; i++) {
        v[i] = RC(test_uniform(rng, -1, 1));
    }
}

static void test_the_cross_product_of_x_and_y_is_z_and_turns_over_when_swapped(void)
{
    const rigcal_real x[3] = {2, 0, 0}, y[3] = {0, 3, 0};
    rigcal_real c[3];
    rc_vec3_cross(c, x, y);
    ASSERT_ARRAY_NEAR(((double[]){0, 0, 6}), c, 3, 0);
    rc_vec3_cross(c, y, x);
    ASSERT_ARRAY_NEAR(((double[]){0, 0, -6}), c, 3, 0);
}

static void test_a_2_3_6_vector_has_length_7(void)
{
    const rigcal_real v[3] = {2, -3, 6};
    rigcal_real unit[3];
    ASSERT_NEAR(7, rc_vec3_norm(v), TOL_ROUNDING);
    ASSERT_NEAR(6, rc_vec3_max_abs(v), 0);
    TEST_ASSERT_TRUE(rc_vec3_unit(unit, v));
    ASSERT_ARRAY_NEAR(((double[]){2.0 / 7, -3.0 / 7, 6.0 / 7}), unit, 3, TOL_ROUNDING);
}

static void test_unit_vectors_survive_lengths_whose_squares_do_not_exist(void)
{
    const rigcal_real sizes[4] = {RC_MAX, RC_MAX / 4, RC(FLT_MIN), RC_TOL(5e-324, 1.5e-45)};
    for (int i = 0; i < 4; i++) {
        const rigcal_real v[3] = {0, sizes[i], -sizes[i]};
        rigcal_real unit[3];
        TEST_ASSERT_TRUE(rc_vec3_unit(unit, v));
        ASSERT_ARRAY_NEAR(((double[]){0, 0.70710678118654752, -0.70710678118654752}), unit,
                          3, TOL_ROUNDING);
    }
}

static void test_the_zero_vector_has_no_direction(void)
{
    const rigcal_real zero[3] = {0, 0, 0};
    rigcal_real unit[3];
    FILL(unit);
    TEST_ASSERT_FALSE(rc_vec3_unit(unit, zero));
    ASSERT_UNTOUCHED(unit);
}

static void test_matrix_products_on_paper(void)
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

static void test_cofactors_times_the_matrix_are_its_determinant(void)
{
    const rigcal_real A[9] = {1, 2, 3, 4, 5, 6, 7, 8, 10};
    rigcal_real cofactors[9], product[9];
    ASSERT_NEAR(-3, rc_mat3_cofactors(cofactors, A), 0);
    rc_mat3_mul_t(product, A, cofactors);
    ASSERT_ARRAY_NEAR(((double[]){-3, 0, 0, 0, -3, 0, 0, 0, -3}), product, 9, 0);
}

static void test_combinations_outer_products_and_symmetric_products_on_paper(void)
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
static void test_a_cholesky_factor_on_paper(void)
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
static void test_solutions_put_back_give_the_right_side(void)
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

static void test_singular_indefinite_and_nan_matrices_have_no_factor(void)
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

/* The pivots of a diagonal matrix are its elements, however much their sizes differ. */
static void test_each_pivot_is_held_against_its_own_element(void)
{
    static const double SIZES[3] = {1, 1e-6, 1e6};

    for (int turn = 0; turn < 3; turn++) {
        rigcal_real L[6], diagonal[3], A[6] = {0, 0, 0, 0, 0, 0};

        for (int k = 0; k < 3; k++) {
            diagonal[k] = RC(SIZES[(k + turn) % 3]);
        }
        A[0] = diagonal[0];
        A[3] = diagonal[1];
        A[5] = diagonal[2];
        TEST_ASSERT_TRUE(rc_sym3_factor(L, A, diagonal, RC(0.5)));
    }
}

/* [1 1; 1 1 + d] has the pivot d for a diagonal element 1 + d. */
static void test_the_rank_tolerance_is_what_a_pivot_must_keep_of_its_diagonal(void)
{
    TEST_ASSERT_TRUE(has_factor(1, 1, 0, 1.02, 0, 1, 0.01));
    TEST_ASSERT_FALSE(has_factor(1, 1, 0, 1.005, 0, 1, 0.01));
    TEST_ASSERT_TRUE(has_factor(1, 0, 1, 1, 0, 1.02, 0.01));
    TEST_ASSERT_FALSE(has_factor(1, 0, 1, 1, 0, 1.005, 0.01));
}

/* The rows m1, m2, m3 are a rotation, also near the poles, where the formula changes its
 * sign. */
static void test_a_direction_is_completed_to_a_rotation(void)
{
    test_rng rng = test_seed(2);
    for (int trial = 0; trial < 300; trial++) {
        const double tilt = (trial % 3 == 0) ? 1e-9 : (trial % 3 == 1) ? 1e-3 : 2;
        const double sign = (trial % 2) ? 1 : -1;
        double m[3], R[9];
        rigcal_real m1[3], m2[3], m3[3];
        for (int k = 0; k < 2; k++) {
            m[k] = tilt * test_uniform(&rng, -1, 1);
        }
        m[2] = sign;
        for (int k = 0; k < 3; k++) {
            m3[k] = RC(m[k] / test_norm(m));
        }
        rc_vec3_complete(m1, m2, m3);
        test_to_double(R, m1, 3);
        test_to_double(R + 3, m2, 3);
        test_to_double(R + 6, m3, 3);
        ASSERT_ROTATION(R, TOL(1e-15, 5e-7));
    }
}

/* ---- the least extent of points ------------------------------------------- */

/* C = sum x x^T of n points. */
static void moments_of(rigcal_real C[6], double x[][3], int n)
{
    for (int k = 0; k < 6; k++) {
        C[k] = 0;
    }
    for (int i = 0; i < n; i++) {
        const rigcal_real at[3] = {RC(x[i][0]), RC(x[i][1]), RC(x[i][2])};
        rc_sym3_add_outer(C, 1, at);
    }
}

static void test_the_normal_of_a_plane_is_found(void)
{
    enum { N = 6 };
    test_rng rng = test_seed(8);
    for (int trial = 0; trial < 300; trial++) {
        double x[N][3], Q[9], n[3];
        rigcal_real C[6], normal[3], thickness = -1;
        test_random_rotation(Q, &rng);
        for (int i = 0; i < N; i++) {
            const double flat[3] = {test_uniform(&rng, -0.5, 0.5),
                                    test_uniform(&rng, -0.5, 0.5), 0};
            test_apply(x[i], Q, flat, NULL);
        }
        moments_of(C, x, N);
        TEST_ASSERT_TRUE(rc_sym3_thinnest(normal, &thickness, C));
        test_to_double(n, normal, 3);
        ASSERT_NEAR(1, test_norm(n), TOL(1e-14, 1e-6));
        for (int i = 0; i < N; i++) {
            /* ill-determined where the points are nearly on a line */
            ASSERT_NEAR(0, test_dot(n, x[i]), TOL(1e-6, 1e-2));
        }
        ASSERT_NEAR(0, thickness, TOL(1e-12, 1e-4));
    }
}

/* Points at +-a, +-b, +-c along turned axes: the mean squares along them are a^2, b^2 and
 * c^2, as parts of their sum. */
static void test_the_thickness_is_that_of_the_least_extent(void)
{
    test_rng rng = test_seed(9);
    for (int trial = 0; trial < 200; trial++) {
        double x[6][3], Q[9], extent[3], n[3], axis[3], least = 0;
        rigcal_real C[6], normal[3], thickness = -1;
        extent[0] = test_uniform(&rng, 0.6, 1);
        extent[1] = test_uniform(&rng, 0.6, 1);
        extent[2] = test_uniform(&rng, 0.01, 0.3);
        test_random_rotation(Q, &rng);
        for (int i = 0; i < 6; i++) {
            double along[3] = {0, 0, 0};
            along[i / 2] = i % 2 ? extent[i / 2] : -extent[i / 2];
            test_apply(x[i], Q, along, NULL);
        }
        moments_of(C, x, 6);
        TEST_ASSERT_TRUE(rc_sym3_thinnest(normal, &thickness, C));
        for (int k = 0; k < 3; k++) {
            least += test_dot(extent, extent) / (extent[k] * extent[k]);
            axis[k] = Q[3 * k + 2];
        }
        least = 1 / least;
        ASSERT_NEAR(least, thickness, TOL(1e-12, 1e-4) * least + TOL(0, 1e-6));
        test_to_double(n, normal, 3);
        ASSERT_NEAR(1, fabs(test_dot(n, axis)), 1e-3);
    }
}

/* Then any direction is one of least extent, and the thickness is a ninth. No power of the
 * matrix underflows. */
static void test_points_that_extend_alike_have_some_normal(void)
{
    test_rng rng = test_seed(11);
    for (int trial = 0; trial < 20; trial++) {
        double x[6][3], Q[9], n[3];
        rigcal_real C[6], normal[3] = {0, 0, 0}, thickness = -1;
        test_random_rotation(Q, &rng);
        for (int i = 0; i < 6; i++) {
            double along[3] = {0, 0, 0};
            along[i / 2] = i % 2 ? 1 : -1;
            test_apply(x[i], Q, along, NULL);
        }
        moments_of(C, x, 6);
        TEST_ASSERT_TRUE(rc_sym3_thinnest(normal, &thickness, C));
        test_to_double(n, normal, 3);
        ASSERT_NEAR(1, test_norm(n), TOL(1e-14, 1e-6));
        ASSERT_NEAR(1.0 / 9, thickness, TOL(1e-14, 1e-6));
    }
}

/* In any unit of length. */
static void test_points_on_a_line_have_no_normal(void)
{
    enum { N = 5 };
    test_rng rng = test_seed(10);
    for (int trial = 0; trial < 100; trial++) {
        const double scale = pow(10, test_uniform(&rng, -6, 6));
        double x[N][3], way[9];
        rigcal_real C[6], normal[3], thickness;
        test_random_rotation(way, &rng);
        for (int i = 0; i < N; i++) {
            const double along = scale * test_uniform(&rng, -1, 1);
            for (int k = 0; k < 3; k++) {
                x[i][k] = along * way[k];
            }
        }
        moments_of(C, x, N);
        FILL(normal);
        TEST_ASSERT_FALSE(rc_sym3_thinnest(normal, &thickness, C));
        ASSERT_UNTOUCHED(normal);
        x[0][0] += scale * way[3]; /* one of them is as far off the line as the line is
                                      long */
        x[0][1] += scale * way[4];
        x[0][2] += scale * way[5];
        moments_of(C, x, N);
        TEST_ASSERT_TRUE(rc_sym3_thinnest(normal, &thickness, C));
    }
}

/* ---- 3 x 3, damped -------------------------------------------------------- */

/* A + lambda D: D is the diagonal, but at least a hundredth of its largest element. */
static void test_damping_adds_to_the_diagonal(void)
{
    const rigcal_real A[6] = {2, RC(0.5), -1, 10, 3, RC(0.01)};
    const rigcal_real B[6] = {2, 1, 1, -4, 1, 8};
    rigcal_real damped[6], diagonal[3];
    rc_sym3_damp(damped, diagonal, A, RC(0.5));
    ASSERT_ARRAY_NEAR(((double[]){2, 10, 0.1}), diagonal, 3, TOL(1e-15, 1e-7));
    ASSERT_ARRAY_NEAR(((double[]){3, 0.5, -1, 15, 3, 0.06}), damped, 6, TOL(1e-14, 1e-6));
    rc_sym3_damp(damped, diagonal, B, 100);
    ASSERT_ARRAY_NEAR(((double[]){2, 0.08, 8}), diagonal, 3, TOL(1e-15, 1e-7));
    ASSERT_ARRAY_NEAR(((double[]){202, 1, 1, 4, 1, 808}), damped, 6, TOL(1e-12, 1e-4));
    rc_sym3_damp(damped, diagonal, A, 0);
    TEST_ASSERT_EQUAL_MEMORY(A, damped, sizeof damped);
}

/* ---- symmetric matrices of any size, in doubles ---------------------------- */

enum { ORDER_MAX = 12 };

/* A = B B^T + I, of random B: positive definite, with eigenvalues of 1 at least. */
static void random_matrix(double A[], int n, test_rng *rng)
{
    double B[ORDER_MAX * ORDER_MAX];
    for (int k = 0; k < n * n; k++) {
        B[k] = test_uniform(rng, -1, 1);
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            A[n * i + j] = i == j;
            for (int k = 0; k < n; k++) {
                A[n * i + j] += B[n * i + k] * B[n * j + k];
            }
        }
    }
}

/* By the Gauss-Jordan method without pivots, which such a matrix does not need. */
static void plain_inverse(double inverse[], const double A[], int n)
{
    double M[ORDER_MAX * ORDER_MAX];
    memcpy(M, A, (size_t)(n * n) * sizeof M[0]);
    for (int k = 0; k < n * n; k++) {
        inverse[k] = k / n == k % n;
    }
    for (int p = 0; p < n; p++) {
        const double by = 1 / M[n * p + p];
        for (int j = 0; j < n; j++) {
            M[n * p + j] *= by;
            inverse[n * p + j] *= by;
        }
        for (int i = 0; i < n; i++) {
            const double f = i == p ? 0 : M[n * i + p];
            for (int j = 0; j < n; j++) {
                M[n * i + j] -= f * M[n * p + j];
                inverse[n * i + j] -= f * inverse[n * p + j];
            }
        }
    }
}

/* ---- 6 x 6, in blocks ------------------------------------------------------ */

/* The index in H[21] of element (i, j), in the form of rc_linalg.h. */
static int block_place(int i, int j)
{
    static const int SYMMETRIC[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    if (i > 2 && j > 2) {
        return 15 + SYMMETRIC[i - 3][j - 3];
    }
    if (i < 3 && j < 3) {
        return SYMMETRIC[i][j];
    }
    return (i < 3) ? 6 + 3 * i + (j - 3) : 6 + 3 * j + (i - 3);
}

static void to_blocks(rigcal_real H[21], const double A[36])
{
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j <= i; j++) {
            H[block_place(i, j)] = RC(A[6 * i + j]);
        }
    }
}

static void test_six_equations_are_solved(void)
{
    static const double DAMPING[4] = {0, 1e-5, 0.3, 100};
    test_rng rng = test_seed(11);
    for (int trial = 0; trial < 200; trial++) {
        const double lambda = DAMPING[trial % 4];
        double A[36], b[6];
        rigcal_real H[21], x[6];
        rc_sym6_factor L;
        random_matrix(A, 6, &rng);
        to_blocks(H, A);
        for (int k = 0; k < 6; k++) {
            x[k] = RC(test_uniform(&rng, -1, 1));
            b[k] = D(x[k]);
            A[7 * k] *= 1 + lambda; /* all elements are of similar size */
        }
        TEST_ASSERT_TRUE(rc_sym6_factor_of(&L, H, RC(lambda)));
        rc_sym6_solve(x, &L);
        for (int i = 0; i < 6; i++) {
            double back = 0;
            for (int j = 0; j < 6; j++) {
                back += A[6 * i + j] * D(x[j]);
            }
            ASSERT_NEAR(b[i], back, TOL(1e-13, 2e-5));
        }
    }
}

/* Newton's H may be like this: negative on its diagonal, but damped. */
static void test_damping_acts_on_an_element_that_is_negative(void)
{
    double A[36] = {0};
    rigcal_real H[21], x[6] = {0, 0, 0, 0, 1, 0};
    rc_sym6_factor L;
    for (int k = 0; k < 6; k++) {
        A[7 * k] = 10;
    }
    A[7 * 4] = -1;
    to_blocks(H, A);
    TEST_ASSERT_FALSE(rc_sym6_factor_of(&L, H, 0));
    TEST_ASSERT_FALSE(rc_sym6_factor_of(&L, H, 9)); /* -1 + 9 * 10 / 100 < 0 */
    TEST_ASSERT_TRUE(rc_sym6_factor_of(&L, H, 30)); /* -1 + 30 * 0.1 = 2 */
    rc_sym6_solve(x, &L);
    ASSERT_NEAR(0.5, x[4], TOL(1e-14, 1e-5));
}

static void test_a_matrix_of_six_is_inverted(void)
{
    test_rng rng = test_seed(12);
    for (int trial = 0; trial < 200; trial++) {
        double A[36], inverse[36];
        rigcal_real H[21], Sigma[36], trace;
        random_matrix(A, 6, &rng);
        plain_inverse(inverse, A, 6);
        to_blocks(H, A);
        TEST_ASSERT_TRUE(rc_sym6_invert(Sigma, H));
        ASSERT_ARRAY_NEAR(inverse, Sigma, 36, TOL(1e-13, 1e-5));
        TEST_ASSERT_TRUE(rc_sym6_inverse_trace(&trace, H));
        ASSERT_NEAR(inverse[0] + inverse[7] + inverse[14], trace, TOL(1e-13, 1e-5));
    }
}

/* The last row is a multiple of the first, or of another row. */
static void test_a_singular_matrix_of_six_is_told(void)
{
    test_rng rng = test_seed(13);
    for (int trial = 0; trial < 36; trial++) {
        const int from = trial % 6, to = trial / 6;
        double A[36], f[36] = {0}, B[36] = {0};
        rigcal_real H[21], Sigma[36], trace;
        rc_sym6_factor L;
        if (from == to) {
            continue;
        }
        random_matrix(A, 6, &rng);
        for (int k = 0; k < 6; k++) { /* B = f^T A f, in which row `to` becomes row
                                         `from` */
            f[6 * k + (k == to ? from : k)] = 1;
        }
        for (int k = 0; k < 36; k++) {
            for (int a = 0; a < 6; a++) {
                for (int b = 0; b < 6; b++) {
                    B[k] += f[6 * (k / 6) + a] * A[6 * a + b] * f[6 * (k % 6) + b];
                }
            }
        }
        to_blocks(H, B);
        TEST_ASSERT_FALSE(rc_sym6_factor_of(&L, H, 0));
        TEST_ASSERT_FALSE(rc_sym6_invert(Sigma, H));
        TEST_ASSERT_FALSE(rc_sym6_inverse_trace(&trace, H));
        TEST_ASSERT_TRUE(rc_sym6_factor_of(&L, H, RC(0.1)));
    }
}

/* ---- packed ---------------------------------------------------------------- */

enum { PACKED_MAX = ORDER_MAX * (ORDER_MAX + 1) / 2 };

static void to_packed(rigcal_real P[], const double A[], int n)
{
    for (int i = 0, at = 0; i < n; i++) {
        for (int j = 0; j <= i; j++, at++) {
            P[at] = RC(A[n * i + j]);
        }
    }
}

static void test_a_packed_matrix_is_the_lower_triangle_row_by_row(void)
{
    size_t at = 0;
    for (size_t i = 0; i < 20; i++) {
        for (size_t j = 0; j <= i; j++, at++) {
            TEST_ASSERT_EQUAL_size_t(at, rc_packed_at(i, j));
        }
    }
}

static int factor_packed(rigcal_real P[], int n, double least)
{
    int is_definite = 1;
    for (int i = 0; i < n && is_definite; i++) {
        is_definite = rc_packed_factor_row(P, (size_t)i, RC(least));
    }
    return is_definite;
}

/* The case computed by hand above, packed. */
static void test_a_packed_factor_on_paper(void)
{
    rigcal_real P[6] = {4, 12, 37, -16, -43, 105};
    rigcal_real x[3] = {2, 7, -1};
    TEST_ASSERT_TRUE(factor_packed(P, 3, 0));
    ASSERT_ARRAY_NEAR(((double[]){0.5, 6, 1, -8, 5, 0.25}), P, 6, 0);
    rc_packed_forward(x, P, 3);
    ASSERT_ARRAY_NEAR(((double[]){1, 1, 0.5}), x, 3, 0);
    rc_packed_backward(x, P, 3);
    ASSERT_ARRAY_NEAR(((double[]){-0.125, 0.375, 0.125}), x, 3, 0);
}

/* L L^T = A, and computing a row changes no other row. */
static void test_a_packed_factor_of_any_size_is_one(void)
{
    test_rng rng = test_seed(14);
    for (int n = 1; n <= ORDER_MAX; n++) {
        double A[ORDER_MAX * ORDER_MAX], L[ORDER_MAX * ORDER_MAX] = {0};
        rigcal_real P[PACKED_MAX], before[PACKED_MAX];
        random_matrix(A, n, &rng);
        to_packed(P, A, n);
        for (int i = 0; i < n; i++) {
            const size_t from = rc_packed_at((size_t)i, 0), to = from + (size_t)i + 1;
            memcpy(before, P, sizeof P);
            TEST_ASSERT_TRUE(rc_packed_factor_row(P, (size_t)i, 0));
            for (size_t k = 0; k < rc_packed_at((size_t)n, 0); k++) {
                TEST_ASSERT_TRUE((k >= from && k < to) || before[k] == P[k]);
            }
        }
        for (int i = 0; i < n; i++) {
            for (int j = 0; j <= i; j++) {
                const double l = D(P[rc_packed_at((size_t)i, (size_t)j)]);
                L[n * i + j] = i == j ? 1 / l : l;
            }
        }
        for (int k = 0; k < n * n; k++) {
            double product = 0;
            for (int m = 0; m < n; m++) {
                product += L[n * (k / n) + m] * L[n * (k % n) + m];
            }
            ASSERT_NEAR(A[k], product, TOL(1e-13, 1e-5));
        }
    }
}

static void test_packed_equations_are_solved(void)
{
    test_rng rng = test_seed(15);
    for (int trial = 0; trial < 10 * ORDER_MAX; trial++) {
        const int n = 1 + trial % ORDER_MAX;
        double A[ORDER_MAX * ORDER_MAX], b[ORDER_MAX];
        rigcal_real P[PACKED_MAX], x[ORDER_MAX];
        random_matrix(A, n, &rng);
        to_packed(P, A, n);
        random_vector(x, n, &rng);
        test_to_double(b, x, (size_t)n);
        TEST_ASSERT_TRUE(factor_packed(P, n, 0));
        rc_packed_forward(x, P, (size_t)n);
        rc_packed_backward(x, P, (size_t)n);
        for (int i = 0; i < n; i++) {
            double back = 0;
            for (int j = 0; j < n; j++) {
                back += A[n * i + j] * D(x[j]);
            }
            ASSERT_NEAR(b[i], back, TOL(1e-13, 5e-5));
        }
    }
}

/* A diagonal that is 0, negative or no number; an indefinite matrix; one whose second row
 * is the first to rounding. */
static void test_a_packed_matrix_without_an_inverse_is_refused(void)
{
    static const double BAD[5][3] = {
        {0, 0, 1}, {1, 0, -1}, {1, 0, 0}, {1, 2, 1}, {1, 1, 1}};

    for (int k = 0; k < 5; k++) {
        rigcal_real P[3] = {RC(BAD[k][0]), RC(BAD[k][1]), RC(BAD[k][2])};

        TEST_ASSERT_FALSE(rc_packed_invert(P, 2));
    }
    rigcal_real P[3] = {4, 2, TEST_NAN};
    TEST_ASSERT_FALSE(rc_packed_invert(P, 2));
    P[0] = 4;
    P[1] = 2;
    P[2] = 2;
    TEST_ASSERT_TRUE(rc_packed_invert(P, 2));
    ASSERT_NEAR(0.5, P[0], TOL(1e-15, 1e-6)); /* of (4 2; 2 2) */
    ASSERT_NEAR(-0.5, P[1], TOL(1e-15, 1e-6));
    ASSERT_NEAR(1, P[2], TOL(1e-15, 1e-6));
}

static void test_a_packed_matrix_is_inverted_in_place(void)
{
    test_rng rng = test_seed(16);
    for (int trial = 0; trial < 10 * ORDER_MAX; trial++) {
        const int n = 1 + trial % ORDER_MAX;
        double A[ORDER_MAX * ORDER_MAX], inverse[ORDER_MAX * ORDER_MAX];
        rigcal_real P[PACKED_MAX];
        random_matrix(A, n, &rng);
        plain_inverse(inverse, A, n);
        to_packed(P, A, n);
        TEST_ASSERT_TRUE(factor_packed(P, n, 0));
        for (int i = 0; i < n; i++) {
            rc_packed_invert_row(P, (size_t)i);
        }
        for (int i = 0; i < n; i++) {
            rc_packed_square_row(P, (size_t)i, (size_t)n);
        }
        for (int i = 0; i < n; i++) {
            for (int j = 0; j <= i; j++) {
                ASSERT_NEAR(inverse[n * i + j], P[rc_packed_at((size_t)i, (size_t)j)],
                            TOL(1e-13, 2e-5));
            }
        }
    }
}

/* The pivot of the last row is the difference of its element from that of a singular
 * matrix. */
static void test_a_packed_pivot_is_refused_up_to_the_least(void)
{
    const rigcal_real A[6] = {1, 1, 2, 1, 2, RC(3.25)}; /* pivots 1, 1, 1.25 */
    rigcal_real P[6];
    memcpy(P, A, sizeof P);
    TEST_ASSERT_TRUE(factor_packed(P, 3, 0.5));
    memcpy(P, A, sizeof P);
    TEST_ASSERT_FALSE(factor_packed(P, 3, 1));
    memcpy(P, A, sizeof P);
    P[5] = 2; /* the last pivot is 0 */
    TEST_ASSERT_TRUE(rc_packed_factor_row(P, 0, 0) && rc_packed_factor_row(P, 1, 0));
    TEST_ASSERT_FALSE(rc_packed_factor_row(P, 2, 0));
    memcpy(P, A, sizeof P);
    P[5] = TEST_NAN;
    TEST_ASSERT_FALSE(factor_packed(P, 3, 0));
    P[0] = -1;
    TEST_ASSERT_FALSE(rc_packed_factor_row(P, 0, 0));
}

/* ---- checks ---------------------------------------------------------------- */

/* The status of wrong numbers: the first of NULL, not finite, too large. */
static void test_numbers_are_checked(void)
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
    RUN_TEST(test_each_pivot_is_held_against_its_own_element);
    RUN_TEST(test_the_rank_tolerance_is_what_a_pivot_must_keep_of_its_diagonal);
    RUN_TEST(test_a_direction_is_completed_to_a_rotation);
    RUN_TEST(test_the_normal_of_a_plane_is_found);
    RUN_TEST(test_the_thickness_is_that_of_the_least_extent);
    RUN_TEST(test_points_that_extend_alike_have_some_normal);
    RUN_TEST(test_points_on_a_line_have_no_normal);
    RUN_TEST(test_damping_adds_to_the_diagonal);
    RUN_TEST(test_six_equations_are_solved);
    RUN_TEST(test_damping_acts_on_an_element_that_is_negative);
    RUN_TEST(test_a_matrix_of_six_is_inverted);
    RUN_TEST(test_a_singular_matrix_of_six_is_told);
    RUN_TEST(test_a_packed_matrix_is_the_lower_triangle_row_by_row);
    RUN_TEST(test_a_packed_factor_on_paper);
    RUN_TEST(test_a_packed_factor_of_any_size_is_one);
    RUN_TEST(test_packed_equations_are_solved);
    RUN_TEST(test_a_packed_matrix_without_an_inverse_is_refused);
    RUN_TEST(test_a_packed_matrix_is_inverted_in_place);
    RUN_TEST(test_a_packed_pivot_is_refused_up_to_the_least);
    RUN_TEST(test_numbers_are_checked);
}
