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

static void test_a_pair_without_rows_is_refused(void)
{
    const rigcal_transform none = stereo(0, 0, 0), ahead = stereo(0.1, 0, 1);
    const rigcal_transform aside = stereo(0.2, 0, 1);
    rigcal_rectified r;

    ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, r, rigcal_rectify(&r, &camera, &camera, &none));
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
    RUN_TEST(test_an_aligned_pair_stays);
    RUN_TEST(test_a_pair_without_rows_is_refused);
    RUN_TEST(test_an_image_that_is_beyond_all_pixels_is_refused);
}
