/* rectify: two cameras turned until their rows are the matching lines. */
#include <math.h>
#include <string.h>

#include "test_bands.h"

/* The pixel of a direction in the virtual camera, after a turn. */
static void aligned_pixel(double uv[2], const rigcal_rectified *r,
                          const rigcal_real turn[9], const double ray[3])
{
    double R[9], m[3];

    test_to_double(R, turn, 9);
    test_apply(m, R, ray, NULL);
    test_project_px(uv, &r->camera, m);
}

static void test_points_are_on_one_row_and_have_their_depth(void)
{
    test_rng rng = test_seed(4801);
    int n = 0;

    for (int trial = 0; trial < TEST_TRIALS(300); trial++) {
        rigcal_rectified r;
        test_bands scene;
        double R[9], t[3], X_a[3], X_b[3], X[3], uv[2][2];

        test_bands_random(&scene, &rng, trial % TEST_LENS_KINDS, 640);
        if (rigcal_rectify(&r, &scene.a, &scene.b, &scene.pair.b_from_a) != RIGCAL_OK) {
            continue;
        }
        n++;
        test_to_double(R, r.aligned_from_a, 9);
        ASSERT_ROTATION(R, TOL(1e-14, 1e-6));
        test_to_double(R, r.aligned_from_b, 9);
        ASSERT_ROTATION(R, TOL(1e-14, 1e-6));
        X_a[0] = test_uniform(&rng, -1, 1);
        X_a[1] = test_uniform(&rng, -1, 1);
        X_a[2] = test_uniform(&rng, 4, 20);
        test_transform_parts(R, t, &scene.pair.b_from_a);
        test_apply(X_b, R, X_a, t);
        test_to_double(R, r.aligned_from_a, 9);
        test_apply(X, R, X_a, NULL);
        aligned_pixel(uv[0], &r, r.aligned_from_a, X_a);
        aligned_pixel(uv[1], &r, r.aligned_from_b, X_b);
        ASSERT_NEAR(uv[0][1], uv[1][1], TOL(1e-8, 5e-2));

        const double disparity = (uv[0][0] - uv[1][0]) / D(r.camera.fx);
        const double X_left = r.a_is_right ? X[0] + D(r.baseline) : X[0];
        const double depth = D(r.baseline) / fabs(disparity);

        ASSERT_NEAR(X[2], depth, TOL(1e-9, 1e-3) * X[2] * X[2]);
        TEST_ASSERT_EQUAL_INT(r.a_is_right, disparity < 0);
        ASSERT_NEAR(X_left / X[2], (uv[r.a_is_right][0] - D(r.camera.cx)) / D(r.camera.fx),
                    TOL(1e-9, 1e-3));
    }
    TEST_ASSERT_TRUE(n > TEST_TRIALS(300) / 2);
}

/* The rows of aligned_from_a, in frame a: x is the baseline, in the direction of both x
 * axes; z is across it, and y across z and across the sum of both optical axes. */
static void test_the_axes_are_near_those_of_both_cameras(void)
{
    test_rng rng = test_seed(4802);
    int n[2] = {0, 0};

    for (int trial = 0; trial < 200; trial++) {
        rigcal_rectified r;
        test_bands scene;
        double R[9], t[3], axis[3], to_b[3], rows[9], x_axes[3], z_axes[3], R_t[9],
            turned[9];

        test_bands_random(&scene, &rng, TEST_PINHOLE, 640);
        for (int k = 0; k < 3; k++) {
            axis[k] = test_uniform(&rng, -1, 1);
            t[k] = test_uniform(&rng, -1, 1);
        }
        test_rotation_about(R, axis, test_uniform(&rng, -2.5, 2.5));
        scene.pair.b_from_a = test_transform(R, t);
        if (rigcal_rectify(&r, &scene.a, &scene.b, &scene.pair.b_from_a) != RIGCAL_OK) {
            continue;
        }
        for (int k = 0; k < 3; k++) {
            to_b[k] = -(R[k] * t[0] + R[3 + k] * t[1] + R[6 + k] * t[2]);
            x_axes[k] = (k == 0) + R[k];
            z_axes[k] = (k == 2) + R[6 + k];
        }
        TEST_ASSERT_EQUAL_INT(test_dot(to_b, x_axes) < 0, r.a_is_right);
        n[r.a_is_right]++;
        test_to_double(rows, r.aligned_from_a, 9);
        for (int k = 0; k < 3; k++) {
            ASSERT_NEAR((r.a_is_right ? -1 : 1) * to_b[k] / test_norm(to_b), rows[k],
                        TOL(1e-14, 1e-6));
        }
        ASSERT_NEAR(0, test_dot(&rows[3], z_axes), TOL(1e-14, 1e-6));
        TEST_ASSERT_TRUE(test_dot(&rows[6], z_axes) > 0);
        test_transpose(R_t, R);
        test_product(turned, rows, R_t);
        ASSERT_ARRAY_NEAR(turned, r.aligned_from_b, 9, TOL(1e-14, 1e-6));
    }
    TEST_ASSERT_TRUE(n[0] > 20 && n[1] > 20);
}

static rigcal_camera camera;

static rigcal_transform stereo(double x, double y, double z)
{
    const double t[3] = {-x, -y, -z};

    memset(&camera, 0, sizeof camera);
    camera.width = 640;
    camera.height = 480;
    camera.fx = 500;
    camera.fy = 520;
    camera.cx = 300;
    camera.cy = 250;
    return test_transform(NULL, t);
}

/* Camera b is beside a: nothing needs to be turned. */
static void test_an_aligned_pair_stays(void)
{
    static const double same[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    const rigcal_transform beside = stereo(0.3, 0, 0), left = stereo(-0.3, 0, 0);
    rigcal_rectified r;

    ASSERT_STATUS(RIGCAL_OK, rigcal_rectify(&r, &camera, &camera, &beside));
    ASSERT_ARRAY_NEAR(same, r.aligned_from_a, 9, TOL(1e-15, 1e-7));
    ASSERT_ARRAY_NEAR(same, r.aligned_from_b, 9, TOL(1e-15, 1e-7));
    ASSERT_NEAR(0.3, r.baseline, TOL(1e-15, 1e-7));
    TEST_ASSERT_EQUAL_INT32(0, r.a_is_right);
    ASSERT_NEAR(510, r.camera.fx, TOL(1e-12, 1e-4));
    /* the middle (319.5, 239.5) stays the middle: 19.5 / 500 off the axis */
    ASSERT_NEAR(319.5 - 510 * 19.5 / 500, r.camera.cx, TOL(1e-9, 1e-3));
    ASSERT_NEAR(239.5 + 510 * 10.5 / 520, r.camera.cy, TOL(1e-9, 1e-3));
    TEST_ASSERT_EQUAL_INT32(640, r.camera.width);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rectify(&r, &camera, &camera, &left));
    TEST_ASSERT_EQUAL_INT32(1, r.a_is_right);
    ASSERT_ARRAY_NEAR(same, r.aligned_from_a, 9, TOL(1e-15, 1e-7));
}

/* Neither camera is to the right of the other. The rows match all the same. */
static void test_a_camera_exactly_above_the_other_is_as_usual(void)
{
    for (int down = 0; down < 2; down++) {
        const rigcal_transform above = stereo(0, down ? 0.5 : -0.5, 0);
        const double expected[9] = {0, down ? 1 : -1, 0, down ? -1 : 1, 0, 0, 0, 0, 1};
        rigcal_rectified r;

        ASSERT_STATUS(RIGCAL_OK, rigcal_rectify(&r, &camera, &camera, &above));
        TEST_ASSERT_EQUAL_INT32(0, r.a_is_right);
        ASSERT_ARRAY_NEAR(expected, r.aligned_from_a, 9, TOL(1e-15, 1e-7));
    }
}

/* A rotation that differs from one within the tolerance of the check: what comes out are
 * rotations. */
static void test_a_rotation_with_few_digits_gives_exact_ones(void)
{
    rigcal_transform beside = stereo(0.3, 0.1, 0);
    rigcal_rectified r;
    double R[9];

    beside.R[0] *= RC(1 + TOL(1e-9, 1e-5));
    beside.R[1] += RC(TOL(1e-9, 1e-5));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rectify(&r, &camera, &camera, &beside));
    test_to_double(R, r.aligned_from_a, 9);
    ASSERT_ROTATION(R, TOL(2e-15, 1e-6));
    test_to_double(R, r.aligned_from_b, 9);
    ASSERT_ROTATION(R, TOL(2e-15, 1e-6));
}

/* Of parallel cameras, one is ahead of the other: the baseline is 9.9 or 10.1 degrees off
 * the axes. */
static void test_the_baseline_is_10_degrees_off_the_axes(void)
{
    static const double DEGREES[2] = {9.9, 10.1};

    for (int k = 0; k < 2; k++) {
        const double angle = DEGREES[k] * TEST_PI / 180;
        const rigcal_transform ahead = stereo(sin(angle), 0, cos(angle));
        rigcal_rectified r;

        camera.fx = camera.fy = 10000; /* a narrow view: the middle is at the axis */
        camera.cx = RC(319.5);
        camera.cy = RC(239.5);
        ASSERT_STATUS(k ? RIGCAL_OK : RIGCAL_ERR_EPIPOLE,
                      rigcal_rectify(&r, &camera, &camera, &ahead));
    }
}

static void test_each_argument_is_checked(void)
{
    rigcal_transform beside = stereo(0.3, 0, 0);
    rigcal_camera bad = camera;
    rigcal_rectified r;

    bad.fx = 0;
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rectify(NULL, &camera, &camera, &beside));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, r, rigcal_rectify(&r, NULL, &camera, &beside));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, r, rigcal_rectify(&r, &camera, NULL, &beside));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, r, rigcal_rectify(&r, &camera, &camera, NULL));
    ASSERT_REFUSED(RIGCAL_ERR_CAMERA, r, rigcal_rectify(&r, &bad, &camera, &beside));
    ASSERT_REFUSED(RIGCAL_ERR_CAMERA, r, rigcal_rectify(&r, &camera, &bad, &beside));
    beside.R[4] = 2;
    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, r, rigcal_rectify(&r, &camera, &camera, &beside));
}

static void test_a_pair_without_rows_is_refused(void)
{
    const rigcal_transform none = stereo(0, 0, 0), ahead = stereo(0.1, 0, 1);
    const rigcal_transform aside = stereo(0.2, 0, 1);
    const rigcal_transform near = stereo(TOL(1e-200, 1e-30), 0, 0); /* its square is 0 */
    rigcal_rectified r;

    ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, r, rigcal_rectify(&r, &camera, &camera, &none));
    ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, r, rigcal_rectify(&r, &camera, &camera, &near));
    ASSERT_REFUSED(RIGCAL_ERR_EPIPOLE, r, rigcal_rectify(&r, &camera, &camera, &ahead));
    camera.cx = 0; /* the middle of the image looks along the baseline, to the right */
    ASSERT_REFUSED(RIGCAL_ERR_WIDE_RAY, r, rigcal_rectify(&r, &camera, &camera, &aside));
}

/* The middle of b's image is nearly along the baseline, far outside an image with a's focal
 * length: its place is beyond the range of pixels. */
static void test_an_image_that_is_beyond_all_pixels_is_refused(void)
{
    const rigcal_transform beside = stereo(0.3, 0, 0);
    rigcal_camera wide = camera;
    rigcal_rectified r;

    camera.fx = camera.fy = RC(1e8);
    wide.cx = -20000; /* 40 focal lengths: 1e8 / 4 * 2 * 40 / 2 pixels */
    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_check(&wide));
    ASSERT_REFUSED(RIGCAL_ERR_WIDE_RAY, r, rigcal_rectify(&r, &camera, &wide, &beside));
    wide.cx = -2000;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rectify(&r, &camera, &wide, &beside));
}

TEST_MAIN()
{
    RUN_TEST(test_points_are_on_one_row_and_have_their_depth);
    RUN_TEST(test_the_axes_are_near_those_of_both_cameras);
    RUN_TEST(test_an_aligned_pair_stays);
    RUN_TEST(test_a_camera_exactly_above_the_other_is_as_usual);
    RUN_TEST(test_a_rotation_with_few_digits_gives_exact_ones);
    RUN_TEST(test_the_baseline_is_10_degrees_off_the_axes);
    RUN_TEST(test_each_argument_is_checked);
    RUN_TEST(test_a_pair_without_rows_is_refused);
    RUN_TEST(test_an_image_that_is_beyond_all_pixels_is_refused);
}
