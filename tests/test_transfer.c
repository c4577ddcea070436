/* transfer: where a third camera must see what two see. The truth: differences of the
 * whole function, by every pixel and every unknown of the cameras. */
#include <math.h>
#include <string.h>

#include "rc_real.h"
#include "test_rigs.h"

enum { N = 3, FREE = 2 };

/* Which cameras are a, b and c. Camera 0 is held. */
static const size_t ORDER[3][N] = {{1, 0, 2}, {0, 2, 1}, {2, 1, 0}};
static size_t ABC[N];
static const rigcal_real NOISE[2] = {RC(0.4), RC(0.25)};

static test_rig r;
static rigcal_mounted_camera cameras[N];
static int32_t group[N];
static uint8_t held[N];
static rigcal_real Sigma[RIGCAL_CALIBRATED_SIZE(FREE)];
static rigcal_calibrated_rig kept;
static double X[3];
static rigcal_real uv[N][2];

#define WANTS_RIG TEST_WANTS_RAM(sizeof(test_rig) + 16000)

/* Clears the memory of a calibrated rig. */
static void clear(void)
{
    memset(&kept, 0, sizeof kept);
    memset(cameras, 0, sizeof cameras);
    kept.cameras = cameras;
    kept.group = group;
    kept.held = held;
    kept.capacity = N;
    kept.Sigma = Sigma;
    kept.Sigma_capacity = RIGCAL_CALIBRATED_SIZE(FREE);
}

/* Computes the exact pixels of X. */
static void see(void)
{
    for (int c = 0; c < N; c++) {
        double X_c[3], px[2];

        test_move_point(X_c, &cameras[ABC[c]].cam_from_rig, X);
        test_project_px(px, &cameras[ABC[c]].camera, X_c);
        test_to_real(uv[c], px, 2);
    }
}

/* An adjusted rig, and a point that all cameras see exactly. */
static void make(uint64_t seed)
{
    test_rng rng = test_seed(seed);
    rigcal_rig_fit fit;

    test_rig_random(&r, &rng, N, 4, 8);
    test_rig_see_all(&r, &rng, 0.3);
    test_rig_solve_views(&r);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    memcpy(ABC, ORDER[seed % 3], sizeof ABC);
    clear();
    for (int c = 0; c < N; c++) {
        cameras[c].camera = r.camera[c];
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_calibrated_take(&kept, &r.rig, &fit, RC(0.3)));
    test_move_point(X, &r.true_places[0], r.X[2]);
    see();
}

static void test_an_exact_pair_shows_the_point(void)
{
    WANTS_RIG;
    for (uint64_t seed = 4901; seed < 4906; seed++) {
        rigcal_transfer out;
        rigcal_real chi2;

        make(seed);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], NOISE));
        ASSERT_ARRAY_NEAR(X, out.X, 3, TOL(1e-9, 2e-4));
        ASSERT_NEAR(D(uv[2][0]), out.uv[0], TOL(1e-6, 2e-2));
        ASSERT_NEAR(D(uv[2][1]), out.uv[1], TOL(1e-6, 2e-2));
        ASSERT_NEAR(0, out.chi2, TOL(1e-9, 1e-3));
        ASSERT_STATUS(RIGCAL_OK, rigcal_transfer_test(&chi2, &out, RC(0.3), uv[2]));
        ASSERT_NEAR(0, chi2, TOL(1e-9, 1e-2));
    }
}

/* The derivative of (uv, X) by one coordinate of a pixel, or by one unknown of a camera. */
static void derivative(double d[5], int what, int camera, int k)
{
    const double h = what == 0 ? TOL(1e-4, 0.5) : TOL(1e-7, 2e-3);
    rigcal_transfer out[2];

    for (int side = 0; side < 2; side++) {
        const rigcal_transform as_it_was = cameras[ABC[camera]].cam_from_rig;
        rigcal_real seen[2][2];
        double step[6] = {0};

        memcpy(seen, uv, sizeof seen);
        if (what == 0) {
            seen[camera][k] += RC(side ? h : -h);
        } else {
            step[k] = side ? h : -h;
            cameras[ABC[camera]].cam_from_rig = test_moved(&as_it_was, step);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_transfer_make(&out[side], &kept, ABC, seen[0],
                                                      seen[1], NOISE));
        cameras[ABC[camera]].cam_from_rig = as_it_was;
    }
    for (int i = 0; i < 2; i++) {
        d[i] = (D(out[1].uv[i]) - D(out[0].uv[i])) / (2 * h);
    }
    for (int i = 0; i < 3; i++) {
        d[2 + i] = (D(out[1].X[i]) - D(out[0].X[i])) / (2 * h);
    }
}

static void test_its_covariance_is_that_of_differences(void)
{
    WANTS_RIG;
    for (uint64_t seed = 4901; seed < 4901 + (uint64_t)TEST_TRIALS(5); seed++) {
        double J[N][6][5], V[5][5] = {{0}}, d[5];
        rigcal_transfer out;

        make(seed);
        for (int k = 0; k < 4; k++) {
            const double sigma = D(NOISE[k / 2]);

            derivative(d, 0, k / 2, k % 2);
            for (int i = 0; i < 25; i++) {
                V[i / 5][i % 5] += sigma * sigma * d[i / 5] * d[i % 5];
            }
        }
        for (int k = 0; k < 6 * N; k++) {
            derivative(J[k / 6][k % 6], 1, k / 6, k % 6);
        }
        for (int a = 0; a < N; a++) {
            for (int b = 0; b < N; b++) {
                rigcal_real block[36];

                ASSERT_STATUS(RIGCAL_OK,
                              rigcal_calibrated_covariance(block, &kept, ABC[a], ABC[b]));
                for (int k = 0; k < 36 * 25; k++) {
                    const int p = k / 25 / 6, q = k / 25 % 6, i = k % 25 / 5, j = k % 5;

                    V[i][j] += J[a][p][i] * D(block[6 * p + q]) * J[b][q][j];
                }
            }
        }
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], NOISE));
        for (int i = 0; i < 2; i++) {
            for (int j = 0; j < 2; j++) {
                ASSERT_NEAR(V[i][j], out.Sigma[2 * i + j],
                            TOL(1e-4, 0.03) * sqrt(V[i][i] * V[j][j]));
            }
        }
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                ASSERT_NEAR(V[2 + i][2 + j], out.Sigma_X[3 * i + j],
                            TOL(1e-4, 0.03) * sqrt(V[2 + i][2 + i] * V[2 + j][2 + j]));
            }
        }
    }
}

/* To first order the chi2 of the pair is that of its band. */
static void test_a_pair_that_is_off_has_the_chi2_of_its_band(void)
{
    WANTS_RIG;
    for (uint64_t seed = 4901; seed < 4906; seed++) {
        rigcal_match_pair pair;
        rigcal_transfer out;
        rigcal_match match;
        rigcal_band band;

        make(seed);
        memset(&pair, 0, sizeof pair);
        pair.camera_a = &cameras[ABC[0]].camera;
        pair.camera_b = &cameras[ABC[1]].camera;
        pair.sigma_a = NOISE[0];
        pair.sigma_b = NOISE[1];
        pair.k = 3;
        ASSERT_STATUS(RIGCAL_OK, rigcal_calibrated_pair(&pair.b_from_a, pair.Sigma, &kept,
                                                        ABC[0], ABC[1]));
        for (int k = 0; k < 2; k++) {
            uv[1][k] += RC(seed % 2 ? 0.8 : -1.1 + k);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&band, &pair, uv[0]));
        ASSERT_STATUS(RIGCAL_OK, rigcal_band_test(&match, &band, uv[1]));
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], NOISE));
        ASSERT_NEAR(D(match.chi2), out.chi2, 0.02 * D(match.chi2) + TOL(1e-6, 2e-2));
    }
}

static void test_a_candidate_off_by_so_much_has_that_chi2(void)
{
    rigcal_transfer out;
    const rigcal_real uv_c[2] = {103, 51};
    rigcal_real chi2;

    memset(&out, 0, sizeof out);
    out.uv[0] = 100;
    out.uv[1] = 50;
    out.Sigma[0] = RC(1.75);
    out.Sigma[1] = out.Sigma[2] = 1;
    out.Sigma[3] = RC(0.75);
    /* (3, 1) by the inverse of (2 1; 1 1), which is (1 -1; -1 2) */
    ASSERT_STATUS(RIGCAL_OK, rigcal_transfer_test(&chi2, &out, RC(0.5), uv_c));
    ASSERT_NEAR(9 - 6 + 2, chi2, TOL(1e-12, 1e-4));
    out.Sigma[1] = out.Sigma[2] = 2;
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, chi2,
                   rigcal_transfer_test(&chi2, &out, RC(0.5), uv_c));
}

static void test_where_there_is_no_point_there_is_no_transfer(void)
{
    static const size_t twice[N] = {1, 0, 1}, beyond[N] = {1, 0, 3};
    rigcal_transfer out;

    WANTS_RIG;
    make(4902); /* the order 1, 0, 2 */
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, out,
                   rigcal_transfer_make(&out, &kept, twice, uv[0], uv[1], NOISE));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, out,
                   rigcal_transfer_make(&out, &kept, beyond, uv[0], uv[1], NOISE));
    group[2] = 1;
    ASSERT_REFUSED(RIGCAL_DISCONNECTED, out,
                   rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], NOISE));
    group[2] = 0;
    cameras[2].cam_from_rig.t[2] -= 100; /* the point is behind camera c */
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, out,
                   rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], NOISE));
    cameras[1].cam_from_rig = cameras[0].cam_from_rig; /* a and b are at the same place */
    ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, out,
                   rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[0], NOISE));
}

static void test_each_argument_is_needed(void)
{
    rigcal_transfer out;

    WANTS_RIG;
    make(4907);
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_transfer_make(NULL, &kept, ABC, uv[0], uv[1], NOISE));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, out,
                   rigcal_transfer_make(&out, NULL, ABC, uv[0], uv[1], NOISE));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, out,
                   rigcal_transfer_make(&out, &kept, NULL, uv[0], uv[1], NOISE));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, out,
                   rigcal_transfer_make(&out, &kept, ABC, NULL, uv[1], NOISE));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, out,
                   rigcal_transfer_make(&out, &kept, ABC, uv[0], NULL, NOISE));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, out,
                   rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], NULL));
}

/* The pose and the lens of each of the three cameras. */
static void test_each_camera_is_checked(void)
{
    rigcal_transfer out;

    WANTS_RIG;
    for (int c = 0; c < N; c++) {
        make(4908);
        cameras[ABC[c]].cam_from_rig.t[1] = TEST_INF;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, out,
                       rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], NOISE));
        make(4908);
        cameras[ABC[c]].cam_from_rig.R[4] += RC(0.5);
        ASSERT_REFUSED(RIGCAL_ERR_ROTATION, out,
                       rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], NOISE));
        make(4908);
        cameras[ABC[c]].camera.fy = 0;
        ASSERT_REFUSED(RIGCAL_ERR_CAMERA, out,
                       rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], NOISE));
    }
}

/* ---- a Sigma that is no covariance ------------------------------------------------- */

/* Three cameras of 1024 px look along z. Camera 0 is held, 1 is one to its left, 2 is
 * anywhere. Cameras 1 and 0 see (x, 0, 4). Sigma is 0. */
static void stand(double x, const double t_c[3])
{
    static const double t[2][3] = {{0, 0, 0}, {1, 0, 0}};

    memcpy(ABC, ORDER[0], sizeof ABC);
    clear();
    memset(Sigma, 0, sizeof Sigma);
    memset(group, 0, sizeof group);
    memset(held, 0, sizeof held);
    held[0] = 1;
    kept.n_cameras = N;
    kept.sigma_px = kept.F = 1;
    kept.freedom_between = kept.freedom_within = 10;
    for (int c = 0; c < N; c++) {
        cameras[c].camera = test_pinhole();
        cameras[c].camera.fx = cameras[c].camera.fy = 1024;
        cameras[c].cam_from_rig = test_transform(NULL, c < 2 ? t[c] : t_c);
    }
    X[0] = x;
    X[1] = 0;
    X[2] = 4;
    see();
}

/* Sets the variance of an unknown of camera 1 or 2. */
static void vary(int camera, int unknown, double variance)
{
    const int i = 6 * (camera - 1) + unknown;

    Sigma[i * (i + 1) / 2 + i] = RC(variance);
}

/* The dt of camera 2 shifts only its pixel. The dt of camera 1 shifts the point: dt_x
 * shifts x and z, on the axis of camera 0 only z; dt_y shifts y. */
static void test_a_negative_variance_gives_no_transfer(void)
{
    static const double aside[3] = {-1, 0, 0};
    static const struct {
        double x;
        int camera, unknown;
    } at[5] = {{0.5, 2, 3}, {0.5, 2, 4}, {0.5, 1, 3}, {0.5, 1, 4}, {0, 1, 3}};

    for (int k = 0; k < 5; k++) {
        rigcal_transfer out;

        stand(at[k].x, aside);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], NOISE));
        if (at[k].camera == 1) { /* and the pixel of camera 2 has the largest variance */
            vary(2, 3, 1e9);
            vary(2, 4, 1e9);
        }
        vary(at[k].camera, at[k].unknown, 100);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], NOISE));
        vary(at[k].camera, at[k].unknown, -100);
        ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, out,
                       rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], NOISE));
    }
}

/* How far a and b miss each other has nothing to do with where c is. */
static void test_the_chi2_of_a_pair_does_not_depend_on_the_third_camera(void)
{
    static const double aside[3] = {-1, 0, 0};

    for (int k = 0; k < 6; k++) {
        rigcal_transfer sure, out;

        stand(2, aside);
        vary(1, 4, 1e-4);
        uv[1][1] += 3;
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_transfer_make(&sure, &kept, ABC, uv[0], uv[1], NOISE));
        vary(2, k, 1e4);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], NOISE));
        TEST_ASSERT_TRUE(D(sure.chi2) > 1);
        ASSERT_NEAR(sure.chi2, out.chi2, TOL(1e-12, 1e-5) * D(sure.chi2));
    }
}

/* A dt_x of camera 2 is 256 px, one of camera 1 is 4 in z. So the variance of the pixel, or
 * of the point, is beyond the largest number. On the axis, camera 2 does not see z. */
static void test_a_variance_beyond_all_numbers_gives_no_transfer(void)
{
    static const double aside[3] = {-1, 0, 0}, behind[3] = {0, 0, 1};
    const double most = D(RC_MAX);
    rigcal_transfer out;

    stand(0.5, aside);
    vary(2, 3, most / 8);
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, out,
                   rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], NOISE));
    vary(2, 3, 0.75 * most / (256.0 * 256)); /* twice that is not finite */
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, out,
                   rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], NOISE));
    stand(0, behind);
    vary(1, 3, 0.75 * most / 16);
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, out,
                   rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], NOISE));
}

/* The pixels are 1 above and 1 below the point, with a noise of 1. So the variance of their
 * residual is 2. dt_y of camera 1 moves its pixel by 256 px, so its variance of -2 / 256^2
 * cancels that. */
static void test_a_residual_without_variance_gives_no_transfer(void)
{
    static const double behind[3] = {0, 0, 1};
    const rigcal_real noise[2] = {1, 1};
    rigcal_transfer out;

    stand(0, behind);
    uv[0][1] += 1;
    uv[1][1] -= 1;
    ASSERT_STATUS(RIGCAL_OK, rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], noise));
    ASSERT_NEAR(2, out.chi2, TOL(1e-12, 1e-5));
    vary(1, 4, -2.0 / (256 * 256));
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, out,
                   rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], noise));
}

static void test_a_candidate_beyond_all_numbers_has_no_chi2(void)
{
    const rigcal_real uv_c[2] = {RC(1e8), 0};
    rigcal_transfer out;
    rigcal_real chi2;

    memset(&out, 0, sizeof out);
    out.Sigma[0] = RC(TOL(1e-100, 1e-10)); /* vv du^2 overflows, and in float chi2 too */
    out.Sigma[3] = RC(TOL(1e295, 1e25));
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, chi2, rigcal_transfer_test(&chi2, &out, 0, uv_c));
}

/* The point nearest to the ray of a is behind b: b looks along x, and its ray passes 2 in
 * front of it, on the other side of the ray of a. */
static void test_a_point_behind_b_gives_no_transfer(void)
{
    static const double aside[3] = {-1, 0, 0};
    static const double along_x[9] = {0, 0, -1, 0, 1, 0, 1, 0, 0}; /* rows: -z, y, x */
    const double b_from_rig[3] = {7, 20, -1};                      /* at (1, -20, 7) */
    static const size_t abc[N] = {0, 1, 2};
    rigcal_transfer out;

    stand(0, aside);
    cameras[1].cam_from_rig = test_transform(along_x, b_from_rig);
    uv[0][0] = cameras[0].camera.cx;
    uv[0][1] = cameras[0].camera.cy;
    uv[1][0] = cameras[1].camera.cx;
    uv[1][1] = cameras[1].camera.cy + 20 * 1024;
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, out,
                   rigcal_transfer_make(&out, &kept, abc, uv[0], uv[1], NOISE));
}

/* A camera with almost no information beside the other gives no depth. The line on which
 * the point lies by the other camera may be across an axis of the rig's frame, or across
 * none. In few frames rounding looks like information. */
static void test_a_pair_of_one_camera_that_counts_has_no_depth(void)
{
    static const double aside[3] = {-1, 0, 0}, up[3] = {0, 0, 1};
    const rigcal_real noise[2] = {RC(1e-6), RC(1e6)};
    const int trials = TEST_TRIALS(200);
    test_rng rng = test_seed(4910);
    int missed = 0;
    rigcal_transfer out;

    stand(0.5, aside);
    ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, out,
                   rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], noise));
    cameras[2].camera.fx = 0;
    ASSERT_REFUSED(RIGCAL_ERR_CAMERA, out,
                   rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], NOISE));
    for (int trial = 0; trial < trials; trial++) {
        const double a = trial % 4 * TEST_PI / 2 + test_uniform(&rng, 0.1, 1.4);
        const double b = trial % 8 < 4 ? test_uniform(&rng, 0.1, 1.4) : 0;
        const double axis[3] = {cos(a) * cos(b), sin(a) * cos(b), sin(b)};
        double R[9], t[3];

        stand(0, aside);
        test_axes_of(R, up, axis);
        for (int c = 0; c < N; c++) {
            test_transform_parts(NULL, t, &cameras[c].cam_from_rig);
            cameras[c].cam_from_rig = test_transform(R, t);
        }
        missed += rigcal_transfer_make(&out, &kept, ABC, uv[0], uv[1], noise) !=
                  RIGCAL_ERR_PARALLEL;
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT((trials + 19) / 20, missed);
}

/* Sigma^-1 = (2, -1; -1, 2) / (3 unit^2), the offset is (1, 2) units, however small the
 * unit is. Coordinates of which one determines the other are degenerate in any unit. */
static void test_a_candidate_has_any_unit_of_pixels(void)
{
    for (int k = -1; k <= 1; k++) {
        const double unit = pow(TOL(1e6, 1e3), k);
        const rigcal_real uv_c[2] = {RC(unit), RC(2 * unit)};
        rigcal_transfer out;
        rigcal_real chi2;

        memset(&out, 0, sizeof out);
        out.Sigma[0] = out.Sigma[3] = RC(2 * unit * unit);
        out.Sigma[1] = out.Sigma[2] = RC(unit * unit);
        ASSERT_STATUS(RIGCAL_OK, rigcal_transfer_test(&chi2, &out, 0, uv_c));
        ASSERT_NEAR(2, chi2, TOL(1e-12, 1e-5));
        out.Sigma[1] = out.Sigma[2] = out.Sigma[0];
        ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, chi2,
                       rigcal_transfer_test(&chi2, &out, 0, uv_c));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_candidate_has_any_unit_of_pixels);
    RUN_TEST(test_an_exact_pair_shows_the_point);
    RUN_TEST(test_its_covariance_is_that_of_differences);
    RUN_TEST(test_a_pair_that_is_off_has_the_chi2_of_its_band);
    RUN_TEST(test_a_candidate_off_by_so_much_has_that_chi2);
    RUN_TEST(test_where_there_is_no_point_there_is_no_transfer);
    RUN_TEST(test_each_argument_is_needed);
    RUN_TEST(test_each_camera_is_checked);
    RUN_TEST(test_a_negative_variance_gives_no_transfer);
    RUN_TEST(test_the_chi2_of_a_pair_does_not_depend_on_the_third_camera);
    RUN_TEST(test_a_variance_beyond_all_numbers_gives_no_transfer);
    RUN_TEST(test_a_residual_without_variance_gives_no_transfer);
    RUN_TEST(test_a_candidate_beyond_all_numbers_has_no_chi2);
    RUN_TEST(test_a_point_behind_b_gives_no_transfer);
    RUN_TEST(test_a_pair_of_one_camera_that_counts_has_no_depth);
}
