/* joint: the covariance of cameras, and of what depends on them. The truth is made with
 * full matrices in double, and difference quotients of b_from_a. */
#include <math.h>
#include <string.h>

#include "rc_joint.h"
#include "test_rigs.h"

#define TOL_ENTRY TOL(1e-12, 2e-5)
#define STEP 1e-4

enum { N = 12 }; /* unknowns: two cameras */

/* A covariance: M M^T of a random M. */
static void random_covariance(double full[N][N], rigcal_real packed[N * (N + 1) / 2],
                              test_rng *rng)
{
    double M[N][N];

    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            M[i][j] = test_normal(rng) * (i < 6 ? 1 : 0.3);
        }
    }
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            full[i][j] = 0;
            for (int k = 0; k < N; k++) {
                full[i][j] += M[i][k] * M[j][k];
            }
            if (j <= i) {
                packed[i * (i + 1) / 2 + j] = RC(full[i][j]);
            }
        }
    }
}

static void test_blocks_are_those_of_the_full_matrix(void)
{
    test_rng rng = test_seed(371);
    double full[N][N];
    rigcal_real packed[N * (N + 1) / 2], block[36];

    random_covariance(full, packed, &rng);
    for (int a = 0; a < N; a += 6) {
        for (int b = 0; b < N; b += 6) {
            rc_joint_block(block, packed, RC(a), RC(b));
            for (int k = 0; k < 36; k++) {
                ASSERT_NEAR(full[a + k / 6][b + k % 6], block[k], TOL_ENTRY * 10);
            }
        }
    }
    rc_joint_block(block, packed, -1, 6);
    for (int k = 0; k < 36; k++) {
        ASSERT_NEAR(0, block[k], 0);
    }
}

/* d = sum of W_i^T d_i, for two cameras, for one that is held, and for one that occurs
 * twice. */
static void test_what_hangs_on_cameras_has_their_covariance(void)
{
    static const int AT[4] = {6, -1, 0, 6};
    test_rng rng = test_seed(372);
    double full[N][N], J[6][N] = {{0}};
    rigcal_real packed[N * (N + 1) / 2], W[4 * 36], at[4], Sigma[36], Z[36];
    const rc_leverage on = {packed, W, at, 4};

    random_covariance(full, packed, &rng);
    for (int i = 0; i < 4; i++) {
        at[i] = RC(AT[i]);
        for (int k = 0; k < 36; k++) {
            const double w = test_normal(&rng);

            W[36 * i + k] = RC(w);
            if (AT[i] >= 0) {
                J[k % 6][AT[i] + k / 6] += w;
            }
        }
    }
    rc_joint_spread(Sigma, &on);
    rc_joint_across(Z, &on, 2);
    for (int r = 0; r < 6; r++) {
        for (int c = 0; c < 6; c++) {
            double sum = 0, across = 0;

            for (int i = 0; i < N; i++) {
                for (int j = 0; j < N; j++) {
                    sum += J[r][i] * full[i][j] * J[c][j];
                }
                across += full[r][i] * J[c][i];
            }
            ASSERT_NEAR(sum, Sigma[6 * r + c], TOL_ENTRY * 1000);
            ASSERT_NEAR(across, Z[6 * r + c], TOL_ENTRY * 100);
        }
    }
}

/* The derivative of b_from_a by the two cameras, column by column. */
static void slopes(double J[6][N], const rigcal_transform *a, const rigcal_transform *b)
{
    const rigcal_transform rig_from_a = test_inverse(a);
    const rigcal_transform origin = test_times(b, &rig_from_a);

    for (int k = 0; k < N; k++) {
        double moved[2][6];

        for (int side = 0; side < 2; side++) {
            double d[6] = {0};
            rigcal_transform A = *a, B = *b, back, pair;

            d[k % 6] = side ? STEP : -STEP;
            if (k < 6) {
                A = test_moved(a, d);
            } else {
                B = test_moved(b, d);
            }
            back = test_inverse(&A);
            pair = test_times(&B, &back);
            test_step_between(moved[side], &pair, &origin);
        }
        for (int i = 0; i < 6; i++) {
            J[i][k] = (moved[1][i] - moved[0][i]) / (2 * STEP);
        }
    }
}

static void test_a_pair_has_the_covariance_of_its_derivatives(void)
{
    test_rng rng = test_seed(373);
    static test_rig r;
    double full[N][N], J[6][N];
    rigcal_real packed[N * (N + 1) / 2], Sigma[36];
    rigcal_transform b_from_a;

    TEST_WANTS_RAM(sizeof r + 4000);
    test_rig_random(&r, &rng, 3, 1, 6);
    random_covariance(full, packed, &rng);
    slopes(J, &r.true_cams[1], &r.true_cams[2]);
    rc_joint_pair(&b_from_a, Sigma, &r.true_cams[1], &r.true_cams[2], packed, 0, 6, 2);
    for (int row = 0; row < 6; row++) {
        for (int column = 0; column < 6; column++) {
            double sum = 0;

            for (int i = 0; i < N; i++) {
                for (int j = 0; j < N; j++) {
                    sum += 2 * J[row][i] * full[i][j] * J[column][j];
                }
            }
            ASSERT_NEAR(sum, Sigma[6 * row + column], TOL(1e-4, 0.5));
        }
    }
}

TEST_MAIN()
{
    RUN_TEST(test_blocks_are_those_of_the_full_matrix);
    RUN_TEST(test_what_hangs_on_cameras_has_their_covariance);
    RUN_TEST(test_a_pair_has_the_covariance_of_its_derivatives);
}
