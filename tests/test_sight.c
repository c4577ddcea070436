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

/* A lens along a direction in which its tangential distortion acts:
 * x + 3 p x^2 + k1 x^3 + k2 x^5 + k3 x^7, for c = p, k1, k2, k3, and its derivative. */
static double image_of(double *slope, const double c[4], double x)
{
    const double x2 = x * x, x4 = x2 * x2;

    *slope = 1 + 6 * c[0] * x + 3 * c[1] * x2 + 5 * c[2] * x4 + 7 * c[3] * x2 * x4;
    return x * (1 + 3 * c[0] * x + c[1] * x2 + c[2] * x4 + c[3] * x2 * x4);
}

/* How far from `at` the lens images what one step of Newton's method from there finds. */
static double miss_of_step(const double c[4], double at)
{
    double slope;
    const double x = at + (at - image_of(&slope, c, at)) / slope;

    return image_of(&slope, c, x) - at;
}

/* The place between low and high that this step finds exactly: its miss is 0. */
static double found_by_a_step(const double c[4], double low, double high)
{
    const double at_low = miss_of_step(c, low);

    for (int k = 0; k < 40; k++) {
        const double middle = (low + high) / 2;
        const int is_below = at_low * miss_of_step(c, middle) < 0;

        high = is_below ? middle : high;
        low = is_below ? low : middle;
    }
    return low;
}

/* Looks at a place of the lens, in eight directions. It has no ray. */
static void assert_no_ray(const double c[4], double at)
{
    rigcal_camera *const camera = &mounted.camera;

    *camera = test_pinhole();
    camera->k1 = RC(c[1]);
    camera->k2 = RC(c[2]);
    camera->k3 = RC(c[3]);
    for (int k = 0; k < 8; k++) {
        const double way[2] = {cos(k * TEST_PI / 4), sin(k * TEST_PI / 4)};

        camera->p1 = RC(c[0] * way[1]);
        camera->p2 = RC(c[0] * way[0]);
        seen.uv[0] = RC(D(camera->cx) + at * way[0] * D(camera->fx));
        seen.uv[1] = RC(D(camera->cy) + at * way[1] * D(camera->fy));
        ASSERT_STATUS(RIGCAL_OK, rc_sight_check(&v, &s, 0));
        for (int i = 0; i < 3; i++) {
            ASSERT_NEAR(0, v.ray[i], 0);
        }
    }
}

/* These lenses turn back. What is farther out than the place where they do so has no ray,
 * although some of them come there again, on the other side of the axis or after they
 * turned once more. A short search may end there, above all if its first step does. */
static void test_a_ray_is_not_found_beyond_where_a_lens_turns_back(void)
{
    enum { PLACES = 200, STEPS = 4000 };
    static const double LENS[][4] = {
        {-0.12, 0.04, 0, 0}, {-0.4, 0, 0, 0}, {-3, 0, 0, 0},     {-0.3, 0, 0.02, 0},
        {-0.3, 0, 0, 0.002}, {0, -0.3, 0, 0}, {0, -4, 0, 0},     {0, -100, 0, 0},
        {0, 0, -0.3, 0},     {0, 0, -30, 0},  {0, 0, -1e4, 0},   {0, 0, 0, -1e-3},
        {0, 0, 0, -0.3},     {0, 0, 0, -100}, {0, 0, 0, -1e6},   {0, -1, 0.4, 0},
        {0, -1, 0, 0.1},     {0, 0, -1, 0.5}, {0, -0.1, 4e-3, 0}};
    static const double ypr[3] = {0, 0, 0}, t[3] = {0, 0, 0}, X[3] = {0, 0, 1};

    see(CAMERA[0], ypr, t, X);
    for (size_t l = 0; l < sizeof LENS / sizeof LENS[0]; l++) {
        const double *const c = LENS[l];
        double most = 0, slope = 1;

        for (double x = 0; slope > 0; x += TEST_ONE_IN > 1 ? 1e-3 : 1e-4) {
            most = image_of(&slope, c, x);
        }
        for (int i = 0; i < TEST_TRIALS(PLACES); i++) {
            assert_no_ray(c, most * (1.02 + 5.0 * i / PLACES));
        }
        for (int i = 0; i < TEST_TRIALS(STEPS); i++) {
            const double low = most * (1.02 + 5.0 * i / STEPS);
            const double high = low + most * 5 / STEPS;

            if (miss_of_step(c, low) * miss_of_step(c, high) < 0) {
                assert_no_ray(c, found_by_a_step(c, low, high));
            }
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
    RUN_TEST(test_a_ray_is_not_found_beyond_where_a_lens_turns_back);
    RUN_TEST(test_a_ray_near_the_end_of_a_lens_is_found);
    RUN_TEST(test_a_point_beyond_the_lens_is_not_seen);
    RUN_TEST(test_a_point_across_the_image_is_seen);
    RUN_TEST(test_blocks_are_the_products);
}
