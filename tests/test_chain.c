/* chain: a view as camera times placement. The truth is made by difference quotients of the
 * product in double, and with full matrices. */
#include <math.h>
#include <string.h>

#include "rc_chain.h"
#include "test_rigs.h"

#define STEP TOL(1e-6, 2e-2)
#define TOL_SLOPE TOL(2e-9, 3e-3)

/* Column k of the derivative of cam_from_rig * rig_from_placement, from a unit step. */
static void slope(double column[6], const rigcal_transform *C, const rigcal_transform *P,
                  int of_camera, int k)
{
    double d[6] = {0}, up[6], down[6];

    for (int sign = -1; sign <= 1; sign += 2) {
        const rigcal_transform T = test_times(C, P);
        rigcal_transform moved, T_moved;

        d[k] = sign * STEP;
        moved = test_moved(of_camera ? C : P, d);
        T_moved = of_camera ? test_times(&moved, P) : test_times(C, &moved);
        test_step_between(sign > 0 ? up : down, &T_moved, &T);
    }
    for (int i = 0; i < 6; i++) {
        column[i] = (up[i] - down[i]) / (2 * STEP);
    }
}

/* A or B, 6 x 6, row by row. */
static void slopes(double J[36], const rigcal_transform *C, const rigcal_transform *P,
                   int of_camera)
{
    for (int k = 0; k < 6; k++) {
        double column[6];

        slope(column, C, P, of_camera, k);
        for (int i = 0; i < 6; i++) {
            J[6 * i + k] = column[i];
        }
    }
}

/* out = M^T H N */
static void between(double out[36], const double M[36], const double H[36],
                    const double N[36])
{
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++) {
            double sum = 0;

            for (int a = 0; a < 6; a++) {
                for (int b = 0; b < 6; b++) {
                    sum += M[6 * a + i] * H[6 * a + b] * N[6 * b + j];
                }
            }
            out[6 * i + j] = sum;
        }
    }
}

static void times(double out[6], const double M[36], const double g[6])
{
    for (int i = 0; i < 6; i++) {
        out[i] = 0;
        for (int a = 0; a < 6; a++) {
            out[i] += M[6 * a + i] * g[a];
        }
    }
}

/* The index of an element in the form of rc_linalg.h: the first block, the block across,
 * the second block. */
static int packed_at(int row, int column)
{
    static const int BLOCK[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};

    if ((row < 3) == (column < 3)) {
        return BLOCK[row % 3][column % 3] + (row < 3 ? 0 : RC_SYM6_SECOND);
    }
    return RC_SYM6_ACROSS + (row < 3 ? 3 * row + column - 3 : 3 * column + row - 3);
}

/* A random chain with g and H. H is not close to a multiple of the identity. */
typedef struct {
    rigcal_transform C, P;
    rigcal_real g[6], H[21];
    double g_full[6], H_full[36], A[36], B[36];
} problem;

static void random_problem(problem *p, test_rng *rng)
{
    p->C = test_random_transform(rng);
    p->P = test_random_transform(rng);
    for (int i = 0; i < 6; i++) {
        p->g[i] = RC(test_uniform(rng, -1, 1));
        p->g_full[i] = D(p->g[i]);
        for (int j = 0; j <= i; j++) {
            const int k = packed_at(i, j);

            p->H[k] = RC(test_uniform(rng, -1, 1) + (i == j ? 4 : 0));
            p->H_full[6 * i + j] = p->H_full[6 * j + i] = D(p->H[k]);
        }
    }
    slopes(p->A, &p->C, &p->P, 1);
    slopes(p->B, &p->C, &p->P, 0);
}

static void assert_packed(const double full[36], const rigcal_real packed[21], double tol)
{
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j <= i; j++) {
            ASSERT_NEAR(full[6 * i + j], packed[packed_at(i, j)], tol);
        }
    }
}

static void test_a_chain_is_the_product(void)
{
    test_rng rng = test_seed(301);

    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        const rigcal_transform C = test_random_transform(&rng);
        const rigcal_transform P = test_random_transform(&rng);
        const rigcal_transform T = test_times(&C, &P);
        rc_chain chain;

        rc_chain_of(&chain, &C, &P);
        ASSERT_TRANSFORM(&T, &chain.cam_from_target, TOL(1e-14, 2e-6), TOL(1e-13, 1e-5));
    }
}

static void test_equations_of_a_placement_are_those_of_differences(void)
{
    test_rng rng = test_seed(302);

    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        rigcal_real g[6] = {0}, H[21] = {0};
        double g_true[6], H_true[36];
        rc_chain chain;
        problem p;

        random_problem(&p, &rng);
        rc_chain_of(&chain, &p.C, &p.P);
        rc_chain_add_placement(g, H, &chain, p.g, p.H);
        times(g_true, p.B, p.g_full);
        between(H_true, p.B, p.H_full, p.B);
        ASSERT_ARRAY_NEAR(g_true, g, 6, 10 * TOL_SLOPE);
        assert_packed(H_true, H, 30 * TOL_SLOPE);
        /* The results are added to what was there. */
        rc_chain_add_placement(g, H, &chain, p.g, p.H);
        for (int k = 0; k < 36; k++) {
            H_true[k] *= 2;
        }
        assert_packed(H_true, H, 60 * TOL_SLOPE);
    }
}

static void test_equations_of_a_camera_are_those_of_differences(void)
{
    test_rng rng = test_seed(303);

    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        double g_true[6], H_true[36], W_true[36];
        rigcal_real W[36];
        rc_chain chain;
        problem p;

        random_problem(&p, &rng);
        rc_chain_of(&chain, &p.C, &p.P);
        times(g_true, p.A, p.g_full);
        between(H_true, p.A, p.H_full, p.A);
        between(W_true, p.A, p.H_full, p.B);
        rc_chain_camera(p.g, p.H, W, &chain);
        ASSERT_ARRAY_NEAR(g_true, p.g, 6, 30 * TOL_SLOPE);
        assert_packed(H_true, p.H, 1000 * TOL_SLOPE);
        ASSERT_ARRAY_NEAR(W_true, W, 36, 200 * TOL_SLOPE);
    }
}

static void test_a_deviation_is_what_moves_one_pose_to_the_other(void)
{
    test_rng rng = test_seed(304);

    for (int trial = 0; trial < TEST_TRIALS(200); trial++) {
        const double size = pow(10, test_uniform(&rng, -4, 0.4));
        const rigcal_transform from = test_random_transform(&rng);
        rigcal_transform to;
        rigcal_real d[6];
        double expected[6];

        for (int k = 0; k < 6; k++) {
            expected[k] = size * test_uniform(&rng, -0.5, 0.5);
        }
        to = test_moved(&from, expected);
        rc_deviation(d, &to, &from);
        test_step_between(expected, &to, &from);
        ASSERT_ARRAY_NEAR(expected, d, 6, TOL(2e-14, 3e-6));
    }
}

/* No step undoes half a turn: it counts as pi, whatever its axis. */
static void test_a_deviation_of_half_a_turn_is_pi(void)
{
    static const double AXES[4][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.6, 0, 0.8}};
    test_rng rng = test_seed(305);

    for (int k = 0; k < 4; k++) {
        const rigcal_transform from = test_random_transform(&rng);
        const double move[6] = {
            AXES[k][0] * TEST_PI, AXES[k][1] * TEST_PI, AXES[k][2] * TEST_PI, 1, -2, 3};
        const double expected[6] = {TEST_PI, 0, 0, 1, -2, 3};
        const rigcal_transform to = test_moved(&from, move);
        rigcal_real d[7];

        FILL(d);
        rc_deviation(d, &to, &from);
        ASSERT_ARRAY_NEAR(expected, d, 6, TOL(2e-14, 3e-6));
        ASSERT_UNTOUCHED(d[6]);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_chain_is_the_product);
    RUN_TEST(test_equations_of_a_placement_are_those_of_differences);
    RUN_TEST(test_equations_of_a_camera_are_those_of_differences);
    RUN_TEST(test_a_deviation_is_what_moves_one_pose_to_the_other);
    RUN_TEST(test_a_deviation_of_half_a_turn_is_pi);
}
