/* sight: what one camera saw of a point: its ray, its derivatives, and what the error of
 * the calibration adds to the covariance of two views. */
#include <math.h>
#include <string.h>

#include "rc_sight.h"
#include "test_support.h"
#include "vectors_camera.h"

static rigcal_mounted_camera mounted;
static rigcal_real noise = RC(0.5);
static rigcal_sighting seen;
static rigcal_calibrated_rig rig;
static rigcal_sightings s;
static rc_sighted v;

/* What a camera sees of X, exactly. */
static void see(const double camera[15], const double ypr[3], const double t[3],
                const double X[3])
{
    double X_c[3], uv[2];

    memset(&rig, 0, sizeof rig);
    memset(&s, 0, sizeof s);
    mounted.camera = test_camera(camera);
    mounted.cam_from_rig = test_from_ypr(ypr, t);
    rig.cameras = &mounted;
    rig.n_cameras = 1;
    s.rig = &rig;
    s.seen = &seen;
    s.n = 1;
    s.sigma_px = &noise;
    test_move_point(X_c, &mounted.cam_from_rig, X);
    test_project_px(uv, &mounted.camera, X_c);
    test_to_real(seen.uv, uv, 2);
}

/* For a pinhole, for mild lenses, and for other lenses, whose rays take a more careful
 * search. */
static void test_the_ray_points_to_what_was_seen(void)
{
    test_rng rng = test_seed(641);

    for (int trial = 0; trial < TEST_TRIALS(300); trial++) {
        const double ypr[3] = {test_uniform(&rng, -3, 3), test_uniform(&rng, -1, 1),
                               test_uniform(&rng, -3, 3)};
        const double zero[3] = {0, 0, 0};
        const double x = test_uniform(&rng, -0.55, 0.55), y = test_uniform(&rng, -0.4, 0.4);
        const double in_camera[3] = {2 * x, 2 * y, 2};
        double R[9], back[9], X[3], unit[3];

        test_rotation(R, ypr[0], ypr[1], ypr[2]);
        test_transpose(back, R);
        test_apply(X, back, in_camera, NULL);
        see(CAMERA[trial % CAMERA_ROWS], ypr, zero, X);
        ASSERT_STATUS(RIGCAL_OK, rc_sight_check(&v, &s, 0));
        for (int k = 0; k < 3; k++) {
            unit[k] = X[k] / test_norm(X);
        }
        ASSERT_ARRAY_NEAR(unit, v.ray, 3, TOL(1e-7, 1e-5));
        ASSERT_NEAR(4, v.weight, TOL(1e-14, 1e-6));
    }
}

static void test_where_a_lens_images_nothing_the_ray_is_zero(void)
{
    static const double ypr[3] = {0, 0, 0}, t[3] = {0, 0, 0}, X[3] = {0, 0, 1};

    see(CAMERA[0], ypr, t, X);
    mounted.camera.k1 = RC(-0.4);
    for (int u = 820; u < 5000; u += 20) {
        seen.uv[0] = RC(u);
        ASSERT_STATUS(RIGCAL_OK, rc_sight_check(&v, &s, 0));
        for (int k = 0; k < 3; k++) {
            ASSERT_NEAR(0, v.ray[k], 0);
        }
    }
}

/* Near the place where a lens turns back, the short search ends too early, and the long one
 * continues. The lens is x - x^3 / 3, which turns back at 1. */
static void test_a_ray_near_the_end_of_a_lens_is_found(void)
{
    static const double ypr[3] = {0, 0, 0}, t[3] = {0, 0, 0}, X[3] = {0, 0, 1};

    see(CAMERA[0], ypr, t, X);
    mounted.camera.k1 = RC(-1.0 / 3);
    for (double x = 0.9; x < 0.985; x += 0.01) {
        const double seen_at = x - x * x * x / 3;

        seen.uv[0] = RC(D(mounted.camera.cx) + seen_at * D(mounted.camera.fx));
        ASSERT_STATUS(RIGCAL_OK, rc_sight_check(&v, &s, 0));
        ASSERT_NEAR(x, v.ray[0] / v.ray[2], TOL(1e-12, 1e-4));
        ASSERT_NEAR(0, v.ray[1], TOL(1e-12, 1e-4));
    }
}

/* The point on the other branch of a lens that folds. It has the same pixel, but it was not
 * seen. */
static void test_a_point_beyond_the_lens_is_not_seen(void)
{
    static const double ypr[3] = {0, 0, 0}, t[3] = {0, 0, 0}, X[3] = {0.5, 0, 1};
    rigcal_real beyond[3] = {RC(1.4), 0, 1};
    const double r = 0.5 * (1 - 0.4 * 0.25);
    double x = 1.4;

    see(CAMERA[0], ypr, t, X);
    mounted.camera.k1 = RC(-0.4);
    seen.uv[0] = RC(319.5 + 800 * r);
    for (int i = 0; i < 50; i++) { /* x - 0.4 x^3 = r, on the far side of 0.91 */
        x -= (x - 0.4 * x * x * x - r) / (1 - 1.2 * x * x);
    }
    beyond[0] = RC(x);
    ASSERT_STATUS(RIGCAL_OK, rc_sight_check(&v, &s, 0));
    ASSERT_STATUS(RIGCAL_OK, rc_sight_evaluate(&v, &s, 0, beyond));
    ASSERT_NEAR(0, v.e[0], TOL(1e-9, 1e-2));
    ASSERT_STATUS(RIGCAL_ERR_NO_RAY, rc_sight_move(&v, &s, 0, beyond));
    const rigcal_real there[3] = {RC(0.5), 0, 1};
    ASSERT_STATUS(RIGCAL_OK, rc_sight_evaluate(&v, &s, 0, there));
    ASSERT_NEAR(0, v.e[0], TOL(1e-9, 1e-3));
    ASSERT_STATUS(RIGCAL_OK, rc_sight_move(&v, &s, 0, there));
}

/* A point that is more than a right angle from the observed ray is seen too, if it is in
 * front of the camera. */
static void test_a_point_across_the_image_is_seen(void)
{
    static const double ypr[3] = {0, 0, 0}, t[3] = {0, 0, 0}, X[3] = {2, 0, 1};
    const rigcal_real across[3] = {-2, 0, 1}, behind[3] = {-2, 0, -1};

    see(CAMERA[0], ypr, t, X);
    mounted.camera = test_pinhole();
    seen.uv[0] = RC(D(mounted.camera.cx) + 2 * D(mounted.camera.fx));
    ASSERT_STATUS(RIGCAL_OK, rc_sight_check(&v, &s, 0));
    ASSERT_STATUS(RIGCAL_OK, rc_sight_evaluate(&v, &s, 0, across));
    ASSERT_NEAR(4 * D(mounted.camera.fx), v.e[0], TOL(1e-9, 1e-3));
    ASSERT_STATUS(RIGCAL_OK, rc_sight_move(&v, &s, 0, across));
    ASSERT_STATUS(RIGCAL_ERR_BEHIND, rc_sight_evaluate(&v, &s, 0, behind));
}

/* C = B_a Sigma_ab B_b^T, element by element, for cameras in any order, for one camera
 * twice, and for held ones. */
static void test_blocks_are_the_products(void)
{
    enum { FREE = 18 };
    double Sigma[FREE][FREE], expected[4];
    rigcal_real packed[FREE * (FREE + 1) / 2], C[4];
    rc_sighted a, b;
    test_rng rng = test_seed(642);

    for (int i = 0; i < FREE; i++) {
        for (int j = 0; j <= i; j++) {
            Sigma[i][j] = Sigma[j][i] = test_uniform(&rng, -1, 1);
            packed[i * (i + 1) / 2 + j] = RC(Sigma[i][j]);
        }
    }
    for (int k = 0; k < 12; k++) {
        a.B[k] = RC(test_uniform(&rng, -1, 1));
        b.B[k] = RC(test_uniform(&rng, -1, 1));
    }
    for (int pair = 0; pair < 9; pair++) {
        const int first = 6 * (pair / 3), other = 6 * (pair % 3);

        a.first = RC(first);
        b.first = RC(other);
        rc_sight_block(C, &a, &b, packed);
        for (int k = 0; k < 4; k++) {
            expected[k] = 0;
            for (int ij = 0; ij < 36; ij++) {
                expected[k] += D(a.B[6 * (k / 2) + ij / 6]) *
                               Sigma[first + ij / 6][other + ij % 6] *
                               D(b.B[6 * (k % 2) + ij % 6]);
            }
        }
        ASSERT_ARRAY_NEAR(expected, C, 4, TOL(1e-14, 1e-5));
    }
    b.first = -1;
    rc_sight_block(C, &a, &b, packed);
    for (int k = 0; k < 4; k++) {
        ASSERT_NEAR(0, C[k], 0);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_the_ray_points_to_what_was_seen);
    RUN_TEST(test_where_a_lens_images_nothing_the_ray_is_zero);
    RUN_TEST(test_a_ray_near_the_end_of_a_lens_is_found);
    RUN_TEST(test_a_point_beyond_the_lens_is_not_seen);
    RUN_TEST(test_a_point_across_the_image_is_seen);
    RUN_TEST(test_blocks_are_the_products);
}
