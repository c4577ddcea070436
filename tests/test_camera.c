/* camera: pixels of points, undistorted pixels, and what a camera cannot see. The truth
 * is made in doubles (tests/support). */
#include <math.h>
#include <string.h>

#include "rc_camera.h"
#include "test_lenses.h"
#include "vectors_camera.h"

/* ---- forward ------------------------------------------------------------- */

static void test_points_are_projected_by_the_formulas_of_the_header(void)
{
    test_rng rng = test_seed(1);

    for (int i = 0; i < TEST_N_LENSES; i++) {
        const rigcal_camera camera = test_lens_camera(&TEST_LENSES[i]);

        for (int trial = 0; trial < TEST_TRIALS(300); trial++) {
            const double Z = test_uniform(&rng, 0.1, 20);
            rigcal_real X_real[3], uv[2];
            double X[3], expected[2];
            test_polar at;

            at = test_polar_at(0, test_uniform(&rng, -TEST_PI, TEST_PI));
            at.out = test_turning_point(&camera, at, 2) * test_uniform(&rng, 0, 0.98);
            test_polar_ray(X, &camera, at);
            for (int k = 0; k < 3; k++) {
                X_real[k] = RC(X[k] * Z);
                X[k] = D(X_real[k]);
            }
            ASSERT_STATUS(RIGCAL_OK, rigcal_camera_project(uv, &camera, X_real));
            test_project_px(expected, &camera, X);
            if (fabs(expected[0]) + fabs(expected[1]) < 10000) {
                ASSERT_ARRAY_NEAR(expected, uv, 2, TOL(1e-9, 1e-2));
            }
        }
    }
}

static void test_points_are_projected_as_the_oracle_does(void)
{
    for (int i = 0; i < CAMERA_PROJECTION_ROWS; i++) {
        const double *const row = CAMERA_PROJECTION[i];
        const rigcal_camera camera = test_camera(CAMERA[(int)row[0]]);
        rigcal_real X_c[3], uv[2];

        test_to_real(X_c, row + 1, 3);
        ASSERT_STATUS(RIGCAL_OK, rigcal_camera_project(uv, &camera, X_c));
        ASSERT_ARRAY_NEAR(row + 4, uv, 2, TOL(1e-9, 2e-2));
    }
}

/* The derivative that triangulation goes by, against differences of the
 * formulas in doubles. */
static void test_the_derivative_of_a_pixel_is_that_of_the_formulas(void)
{
    test_rng rng = test_seed(2);

    for (int i = 0; i < TEST_N_LENSES; i++) {
        const rigcal_camera camera = test_lens_camera(&TEST_LENSES[i]);

        for (int trial = 0; trial < TEST_TRIALS(30); trial++) {
            const double distance = test_uniform(&rng, 0.1, 20);
            double X[3], largest = 0, J[6];
            rigcal_real X_c[3], uv[2], J_uv[6];
            test_polar at = test_polar_at(0, test_uniform(&rng, -TEST_PI, TEST_PI));

            at.out = test_turning_point(&camera, at, 2) * test_uniform(&rng, 0, 0.95);
            if (trial == 0) {
                at.out = 0; /* on the axis itself */
            }
            test_polar_ray(X, &camera, at);
            for (int k = 0; k < 3; k++) {
                X_c[k] = RC(X[k] * distance);
                X[k] = D(X_c[k]);
            }
            for (int k = 0; k < 3; k++) {
                const double h = 1e-5 * distance, here = X[k];
                double more[2], less[2];

                X[k] = here + h;
                test_project_px(more, &camera, X);
                X[k] = here - h;
                test_project_px(less, &camera, X);
                X[k] = here;
                for (int j = 0; j < 2; j++) {
                    J[3 * j + k] = (more[j] - less[j]) / (2 * h);
                    largest = fabs(J[3 * j + k]) > largest ? fabs(J[3 * j + k]) : largest;
                }
            }
            ASSERT_STATUS(RIGCAL_OK, rc_project_through(uv, J_uv, &camera,
                                                        rc_lens_is_pinhole(&camera), X_c));
            ASSERT_ARRAY_NEAR(J, J_uv, 6, TOL(1e-6, 1e-3) * largest);
        }
    }
}

static void test_a_pinhole_is_exact_where_it_can_be(void)
{
    const rigcal_camera camera = {.lens = RIGCAL_LENS_BROWN,
                                  .width = 640,
                                  .height = 480,
                                  .fx = 512,
                                  .fy = 256,
                                  .cx = 320,
                                  .cy = RC(239.5)};
    const rigcal_real X_c[3] = {RC(0.5), RC(-3), 4};
    const double pixel[2] = {384, 47.5};
    /* (-3, 0, 4) / 5. */
    const rigcal_real uv[2] = {-64, RC(239.5)};
    const double expected[3] = {-0.6, 0, 0.8};
    rigcal_real seen[2], ray[3];

    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_project(seen, &camera, X_c));
    ASSERT_ARRAY_NEAR(pixel, seen, 2, 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_ray(ray, &camera, uv));
    ASSERT_ARRAY_NEAR(expected, ray, 3, TOL(1e-15, 1e-7));
}

static void test_the_principal_point_is_the_image_of_the_axis(void)
{
    static const double axis[3] = {0, 0, 1};

    for (int i = 0; i < TEST_N_LENSES; i++) {
        const rigcal_camera camera = test_lens_camera(&TEST_LENSES[i]);
        const rigcal_real ahead[3] = {0, 0, 3};
        const rigcal_real middle[2] = {camera.cx, camera.cy};
        const double expected[2] = {D(camera.cx), D(camera.cy)};
        rigcal_real uv[2], ray[3];

        ASSERT_STATUS(RIGCAL_OK, rigcal_camera_project(uv, &camera, ahead));
        ASSERT_ARRAY_NEAR(expected, uv, 2, 0);
        ASSERT_STATUS(RIGCAL_OK, rigcal_camera_ray(ray, &camera, middle));
        ASSERT_ARRAY_NEAR(axis, ray, 3, TOL(1e-15, 1e-7));
    }
}

/* ---- undistorted pixels -------------------------------------------------- */

static void test_undistorted_pixels_are_those_of_the_pinhole_and_go_back(void)
{
    test_rng rng = test_seed(10);

    for (int i = 0; i < TEST_N_LENSES; i++) {
        const rigcal_camera camera = test_lens_camera(&TEST_LENSES[i]);

        for (int trial = 0; trial < TEST_TRIALS(200); trial++) {
            double X_c[3], exact[2], straight[2], slack;
            rigcal_real uv[2], seen[2], back[2];
            test_polar at;

            at = test_polar_at(0, test_uniform(&rng, -TEST_PI, TEST_PI));
            at.out = test_turning_point(&camera, at, 1.4) * test_uniform(&rng, 0, 0.98);
            test_polar_ray(X_c, &camera, at);
            test_project_px(exact, &camera, X_c);
            if (!test_is_in_reach(&camera, exact)) {
                continue;
            }
            test_to_real(uv, exact, 2);
            straight[0] = D(camera.fx) * X_c[0] / X_c[2] + D(camera.cx);
            straight[1] = D(camera.fy) * X_c[1] / X_c[2] + D(camera.cy);
            /* The error of a pixel, as the lens magnifies it. */
            slack = 4 * TEST_PX / test_steepness(&camera, at);
            if (camera.lens == RIGCAL_LENS_FISHEYE) {
                slack /= cos(at.out) * cos(at.out);
            }
            ASSERT_STATUS(RIGCAL_OK, rigcal_camera_undistort(seen, &camera, uv));
            ASSERT_ARRAY_NEAR(straight, seen, 2, slack);
            test_to_real(seen, straight, 2);
            ASSERT_STATUS(RIGCAL_OK, rigcal_camera_distort(back, &camera, seen));
            ASSERT_ARRAY_NEAR(exact, back, 2, TOL(1e-9, 1e-2));
        }
    }
}

static void test_a_fisheye_ray_at_90_degrees_has_no_undistorted_pixel(void)
{
    const rigcal_camera camera = test_lens_camera(&TEST_LENSES[TEST_N_LENSES - 4]);
    const double angles[] = {1.58, 1.8, 2.2, 2.8};

    TEST_ASSERT_EQUAL_STRING("fisheye, 220 degrees", TEST_LENSES[TEST_N_LENSES - 4].name);
    for (int i = 0; i < 4; i++) {
        const double u = 300 * angles[i];
        const rigcal_real uv[2] = {RC(599.5 + 0.6 * u), RC(599.5 - 0.8 * u)};
        rigcal_real straight[2], ray[3];

        ASSERT_STATUS(RIGCAL_OK, rigcal_camera_ray(ray, &camera, uv));
        ASSERT_REFUSED(RIGCAL_ERR_WIDE_RAY, straight,
                       rigcal_camera_undistort(straight, &camera, uv));
    }
}

/* Up to that: any ray that is ahead by more than rounding has one, at the tangent. */
static void test_a_fisheye_ray_below_90_degrees_has_an_undistorted_pixel(void)
{
    rigcal_camera camera = test_lens_camera(&TEST_LENSES[TEST_N_LENSES - 4]);
    const double eps = TOL(2.220446049250313e-16, 1.1920928955078125e-7);
    const double angles[] = {0.5, 1.4, 1.5, 1.55, 1.57};
    int n_rounding = 0;

    for (int i = 0; i < 5; i++) {
        const rigcal_real uv[2] = {RC(599.5 + 300 * angles[i]), RC(599.5)};
        const double slope = 300 * tan((D(uv[0]) - 599.5) / 300);
        rigcal_real straight[2];

        ASSERT_STATUS(RIGCAL_OK, rigcal_camera_undistort(straight, &camera, uv));
        ASSERT_NEAR(599.5 + slope, straight[0], TOL(1e-10, 2e-2) * slope);
        ASSERT_NEAR(599.5, straight[1], TOL(1e-10, 1e-3));
    }
    camera.fx = camera.fy = 1;
    camera.cx = camera.cy = 0;
    for (int k = 0; k < 400; k++) { /* as near to a right angle as numbers are */
        const rigcal_real uv[2] = {RC(TEST_PI / 2 * cos(k)), RC(TEST_PI / 2 * sin(k))};
        rigcal_real straight[2], ray[3];

        ASSERT_STATUS(RIGCAL_OK, rigcal_camera_ray(ray, &camera, uv));
        const rigcal_status status = rigcal_camera_undistort(straight, &camera, uv);
        ASSERT_STATUS(D(ray[2]) > eps ? RIGCAL_OK : RIGCAL_ERR_WIDE_RAY, status);
        n_rounding += D(ray[2]) > 0 && D(ray[2]) <= eps;
    }
    TEST_ASSERT_TRUE(n_rounding > 0);
}

/* A focal length of a millionth of a pixel is the least, in either direction. */
static void test_the_least_focal_length(void)
{
    for (int way = 0; way < 2; way++) {
        rigcal_camera camera = test_pinhole();
        rigcal_real *const f = way ? &camera.fy : &camera.fx;

        *f = RC(1e-6);
        ASSERT_STATUS(RIGCAL_OK, rigcal_camera_check(&camera));
        *f = RC(0.999e-6);
        ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&camera));
        *f = RC(1e9);
        ASSERT_STATUS(RIGCAL_OK, rigcal_camera_check(&camera));
        *f = RC(1.001e9);
        ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&camera));
    }
}

/* Rounding of a large pixel, or beside a principal point that is far off, is more than a
 * part of a pixel. It is no reason to have no ray. */
static void test_large_pixels_have_rays_as_good_as_rounding(void)
{
    static const double LARGE = 5e8;
    test_rng rng = test_seed(41);

    for (int trial = 0; trial < TEST_TRIALS(200); trial++) {
        const int axis = trial % 2, is_centre = trial / 2 % 2;
        const double at = LARGE * test_uniform(&rng, 0.2, 0.9);
        rigcal_camera camera = test_pinhole();
        rigcal_real uv[2] = {0, 0}, ray[3];
        double X[3], again[2];

        camera.k1 = RC(0.05);
        camera.k2 = RC(0.01);
        camera.fx = camera.fy = RC(LARGE);
        camera.cx = camera.cy = 0;
        if (is_centre && axis == 0) {
            camera.cx = RC(at);
        } else if (is_centre) {
            camera.cy = RC(at);
        } else {
            uv[axis] = RC(at);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_camera_ray(ray, &camera, uv));
        test_to_double(X, ray, 3);
        test_project_px(again, &camera, X);
        ASSERT_NEAR(again[0], uv[0], TOL(2e-6, 500));
        ASSERT_NEAR(again[1], uv[1], TOL(2e-6, 500));
    }
}

static void test_pixels_without_a_ray_are_not_undistorted_either(void)
{
    /* 1 - 3 * 0.4 r^2 = 0 at r = 0.91287, imaged 304.3 pixels off. */
    const test_lens_row row = {
        "", RIGCAL_LENS_BROWN, 1280, 960, 500, 500, 640, 480, -0.4, 0, 0, 0, 0, 0, 0, 0};
    const rigcal_camera camera = test_lens_camera(&row);
    const rigcal_real inside[2] = {640, 480 - 304};
    const rigcal_real outside[2] = {640 + 305, 480};
    const rigcal_real straight_inside[2] = {640, RC(480 + 500 * 0.912)};
    const rigcal_real straight_outside[2] = {RC(640 + 500 * 0.914), 480};
    rigcal_real uv[2], ray[3];

    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_undistort(uv, &camera, inside));
    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_distort(uv, &camera, straight_inside));
    ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, ray, rigcal_camera_ray(ray, &camera, outside));
    ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, uv, rigcal_camera_undistort(uv, &camera, outside));
    ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, uv,
                   rigcal_camera_distort(uv, &camera, straight_outside));
}

/* ---- what a camera cannot see -------------------------------------------- */

static void test_what_is_not_in_front_is_not_imaged(void)
{
    static const double places[][3] = {
        {0, 0, -1}, {1, 2, -3}, {1, 0, 0}, {0.3, -0.2, 0}, {0, 0, -1e-9}};
    const rigcal_camera camera = test_pinhole();
    const rigcal_real centre[3] = {0, 0, 0};
    rigcal_real uv[2], X_c[3];

    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        test_to_real(X_c, places[i], 3);
        ASSERT_REFUSED(RIGCAL_ERR_BEHIND, uv, rigcal_camera_project(uv, &camera, X_c));
    }
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, uv, rigcal_camera_project(uv, &camera, centre));
}

/* With a lens, and by the way of a pinhole: in the plane of the camera's centre no point
 * has a pixel, not even on an axis; nor has one behind it, whose ray would have one. */
static void test_no_lens_images_what_is_not_in_front(void)
{
    static const double places[][3] = {{0, 0, -1},  {0.1, -0.2, -1}, {1, 0, 0}, {0, 1, 0},
                                       {-1, -1, 0}, {0, 0, -1e-30},  {0, 0, 0}};
    rigcal_real uv[2], x[2], J[6], X_c[3];

    for (int with_lens = 0; with_lens < 2; with_lens++) {
        rigcal_camera camera = test_pinhole();
        camera.k1 = RC(with_lens ? 0.01 : 0);
        for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
            const int is_centre = i == sizeof places / sizeof places[0] - 1;
            const rigcal_status why = is_centre ? RIGCAL_ERR_DEGENERATE : RIGCAL_ERR_BEHIND;
            test_to_real(X_c, places[i], 3);
            ASSERT_REFUSED(why, uv, rigcal_camera_project(uv, &camera, X_c));
            ASSERT_STATUS(why, rc_project_by(x, uv, J, &camera, X_c));
            ASSERT_REFUSED(with_lens ? why : RIGCAL_ERR_BEHIND, uv,
                           rc_project_through(uv, J, &camera, !with_lens, X_c));
        }
        X_c[2] = RC(1e-30); /* on the axis, however near */
        ASSERT_STATUS(RIGCAL_OK, rc_project_through(uv, J, &camera, !with_lens, X_c));
        ASSERT_NEAR(D(camera.cx), uv[0], 0);
        ASSERT_NEAR(D(camera.cy), uv[1], 0);
    }
}

static void test_a_fisheye_sees_behind_itself_but_not_its_own_centre(void)
{
    const rigcal_camera camera = test_lens_camera(&TEST_LENSES[TEST_N_LENSES - 4]);
    const rigcal_real side[3] = {2, 0, 0}, behind[3] = {0, 3, -3};
    const rigcal_real centre[3] = {0, 0, 0};
    const double quarter[2] = {599.5 + 150 * TEST_PI, 599.5};
    const double back[2] = {599.5, 599.5 + 225 * TEST_PI};
    rigcal_real uv[2];

    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_project(uv, &camera, side));
    ASSERT_ARRAY_NEAR(quarter, uv, 2, TOL(1e-10, 1e-3));
    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_project(uv, &camera, behind));
    ASSERT_ARRAY_NEAR(back, uv, 2, TOL(1e-10, 1e-3));
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, uv, rigcal_camera_project(uv, &camera, centre));
}

/* The image of a point 180 degrees off the axis would be a whole circle. */
static void test_a_fisheye_does_not_see_straight_back(void)
{
    const rigcal_camera camera = test_lens_camera(&TEST_LENSES[TEST_N_LENSES - 4]);
    const rigcal_real backs[2][3] = {{0, 0, -2}, {RC(1e-20), RC(-3e-20), -2}};

    for (int i = 0; i < 2; i++) { /* to rounding: the azimuth may have lost its digits */
        rigcal_real uv[2];
        FILL(uv);
        const rigcal_status status = rigcal_camera_project(uv, &camera, backs[i]);
        TEST_ASSERT_TRUE(status == RIGCAL_ERR_BEHIND || status == RIGCAL_ERR_NO_RAY);
        ASSERT_UNTOUCHED(uv);
    }
}

static void test_intrinsics_that_cannot_be_are_refused(void)
{
    const rigcal_camera good = test_pinhole();
    rigcal_camera c;

    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_check(&good));
    c = good;
    c.lens = 2;
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&c));
    c = good;
    c.fx = 0;
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&c));
    c = good;
    c.fy = -1;
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&c));
    c = good;
    c.width = 0;
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&c));
    c = good;
    c.width = c.height = 1000000;
    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_check(&c));
    c.height = 1000001;
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&c));
    c = good;
    c.k6 = TEST_NAN;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rigcal_camera_check(&c));
    c = good;
    c.cx = RC(-1e5);
    c.width = c.height = 1;
    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_check(&c));
}

static void test_a_fisheye_has_no_coefficients_but_its_four(void)
{
    rigcal_camera good = test_pinhole(), c;

    good.lens = RIGCAL_LENS_FISHEYE;
    good.k1 = good.k2 = good.k3 = good.k4 = RC(0.01);
    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_check(&good));
    c = good;
    c.p1 = RC(1e-9);
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&c));
    c = good;
    c.p2 = RC(0.1);
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&c));
    c = good;
    c.k5 = RC(-0.1);
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&c));
    c = good;
    c.k6 = RC(0.1);
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&c));
    c = good;
    c.p1 = RC(-0.0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_check(&c));
}

/* ---- the error of a view --------------------------------------------------- */

static void test_the_error_of_exact_pixels_is_zero(void)
{
    test_scene scene;
    rigcal_camera camera;
    rigcal_observation observations[20];
    rigcal_transform cam_from_world;
    rigcal_real rms;

    test_scene_seen(&scene, &camera, observations, 13);
    cam_from_world = test_transform(scene.R, scene.t);
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_view_rms(&rms, NULL, &VIEW(&camera, observations, NULL, 20),
                                  &cam_from_world));
    ASSERT_NEAR(0, rms, TOL(1e-10, 1e-3));
}

static void test_the_error_is_the_root_of_the_mean_squared_distance(void)
{
    test_rng rng = test_seed(14);
    test_scene scene;
    rigcal_camera camera;
    rigcal_observation observations[20];
    rigcal_transform cam_from_world;

    for (int trial = 0; trial < TEST_TRIALS(50); trial++) {
        const size_t n = 1 + (size_t)trial % 20;
        double sum = 0, largest = -1;
        int32_t expected_worst = -1, worst;
        rigcal_real rms;

        test_scene_seen(&scene, &camera, observations, (uint64_t)(100 + trial));
        cam_from_world = test_transform(scene.R, scene.t);
        for (size_t i = 0; i < n; i++) {
            const double du = test_uniform(&rng, -5, 5);
            const double dv = test_uniform(&rng, -5, 5);

            observations[i].uv[0] = RC(D(observations[i].uv[0]) + du);
            observations[i].uv[1] = RC(D(observations[i].uv[1]) + dv);
            sum += du * du + dv * dv;
            if (du * du + dv * dv > largest) {
                largest = du * du + dv * dv;
                expected_worst = (int32_t)i;
            }
        }
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_view_rms(&rms, &worst, &VIEW(&camera, observations, NULL, n),
                                      &cam_from_world));
        ASSERT_NEAR(sqrt(sum / (double)n), rms, TOL(1e-9, 2e-3));
        TEST_ASSERT_EQUAL_INT32(expected_worst, worst);
    }
}

static void test_no_error_is_told_of_points_that_cannot_be_seen(void)
{
    test_scene scene;
    rigcal_camera camera;
    rigcal_observation observations[20];
    rigcal_transform cam_from_world;
    rigcal_real rms;
    int32_t worst;

    test_scene_seen(&scene, &camera, observations, 15);
    cam_from_world = test_transform(scene.R, scene.t);
    FILL(worst);
    /* The camera's own centre, moved back by 1, then to the side by 3 at 1 ahead: beyond
     * the fold of a lens with k1 = -0.4 alone. */
    for (int k = 0; k < 3; k++) {
        double o = 0;

        for (int j = 0; j < 3; j++) {
            o += scene.R[3 * j + k] * ((j == 2 ? -1 : 0) - scene.t[j]);
        }
        observations[8].X_w[k] = RC(o);
    }
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, rms,
                   rigcal_view_rms(&rms, &worst, &VIEW(&camera, observations, NULL, 20),
                                   &cam_from_world));
    ASSERT_UNTOUCHED(worst);
    camera.k1 = RC(-0.4);
    camera.k2 = camera.k3 = 0;
    for (int k = 0; k < 3; k++) {
        double o = 0;

        for (int j = 0; j < 3; j++) {
            o += scene.R[3 * j + k] * ((j == 2 ? 1 : j == 0 ? 3 : 0) - scene.t[j]);
        }
        observations[8].X_w[k] = RC(o);
    }
    ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, rms,
                   rigcal_view_rms(&rms, &worst, &VIEW(&camera, observations, NULL, 20),
                                   &cam_from_world));
    ASSERT_UNTOUCHED(worst);
}

/* The first point is wrong, so no other is read. */
static void test_the_error_is_that_of_2_to_the_28_points_at_most(void)
{
    const rigcal_transform same = test_transform(NULL, NULL);
    const rigcal_camera camera = test_pinhole();
    const rigcal_observation first = {{0, 0, 1}, {TEST_NAN, 0}};
    rigcal_view view = VIEW(&camera, &first, NULL, 0);
    rigcal_real rms;

    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, rms, rigcal_view_rms(&rms, NULL, &view, &same));
    view.n = RC_COUNT_MAX;
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, rms, rigcal_view_rms(&rms, NULL, &view, &same));
    view.n++; /* 0 where a size has few bits */
    ASSERT_REFUSED(view.n > 0 ? RIGCAL_ERR_RANGE : RIGCAL_ERR_TOO_FEW, rms,
                   rigcal_view_rms(&rms, NULL, &view, &same));
}

/* Of points that are off by the same, the first is the worst. All numbers are exact. */
static void test_the_worst_point_is_the_first_that_is_off_by_the_most(void)
{
    const rigcal_transform same = test_transform(NULL, NULL);
    rigcal_camera camera = test_pinhole();
    rigcal_observation o[4] = {
        {{0, 0, 1}, {0, 0}}, {{0, 0, 2}, {0, 0}}, {{0, 0, 4}, {0, 0}}, {{0, 0, 1}, {0, 0}}};
    rigcal_real rms;
    int32_t worst;

    camera.cx = camera.cy = 64;
    for (int first = 0; first < 3; first++) {
        for (int i = 0; i < 4; i++) {
            o[i].uv[0] = RC(64 + (i >= first ? 3 : 0));
            o[i].uv[1] = RC(64 - (i >= first ? 4 : 0));
        }
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_view_rms(&rms, &worst, &VIEW(&camera, o, NULL, 4), &same));
        TEST_ASSERT_EQUAL_INT32(first, worst);
        ASSERT_NEAR(sqrt(25.0 * (4 - first) / 4), rms, TOL(1e-15, 1e-6));
    }
}

/* Two numbers are a pixel; what follows them in memory is none of it. */
static void test_a_pixel_is_two_numbers(void)
{
    rigcal_real uv[3] = {1, 2, TEST_NAN};

    ASSERT_STATUS(RIGCAL_OK, rc_check_pixel(uv));
    uv[1] = TEST_NAN;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rc_check_pixel(uv));
    uv[1] = RC(1e9);
    ASSERT_STATUS(RIGCAL_OK, rc_check_pixel(uv));
    uv[1] = RC(-1.001e9);
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rc_check_pixel(uv));
}

/* 1 px of an image with at least 800 px of focal length; of a shorter one, or one whose
 * unit is its focal length, f^2 / 800. */
static void test_the_size_of_a_pixel_follows_the_focal_length(void)
{
    static const double SIZE[5][2] = {
        {1, 1 / 800.0}, {20, 0.5}, {0.5, 1 / 3200.0}, {40, 1}, {800, 1}};
    rigcal_camera camera = test_pinhole();

    for (int i = 0; i < 5; i++) {
        camera.fx = RC(SIZE[i][0]);
        ASSERT_NEAR(SIZE[i][1], rc_pixel_size(&camera), TOL(1e-18, 1e-9));
    }
}

/* A pixel that is no number is reported before a point that is out of range. */
static void test_what_is_no_number_is_told_first(void)
{
    const rigcal_transform same = test_transform(NULL, NULL);
    const rigcal_camera camera = test_pinhole();
    rigcal_observation o = {{RC(TOL(1e31, 1e10)), 0, 1}, {TEST_NAN, 0}};
    rigcal_real rms;

    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, rms,
                   rigcal_view_rms(&rms, NULL, &VIEW(&camera, &o, NULL, 1), &same));
    o.uv[0] = 0;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, rms,
                   rigcal_view_rms(&rms, NULL, &VIEW(&camera, &o, NULL, 1), &same));
}

/* Points beside the camera, only slightly in front. The square of the pixel overflows or,
 * with a lens, the pixel itself. */
static void test_a_pixel_that_overflows_is_none(void)
{
    const double little = TOL(1e-150, 1e-18);
    const double t[3] = {0, 0, little};
    const rigcal_transform ahead = test_transform(NULL, t);
    const rigcal_real X_c[3] = {1, 0, RC(little)};
    const rigcal_observation o = {{1, 0, 0}, {0, 0}};
    rigcal_camera camera = test_pinhole();
    rigcal_real uv[2], rms;

    camera.fx = camera.fy = RC(1e9);
    ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, rms,
                   rigcal_view_rms(&rms, NULL, &VIEW(&camera, &o, NULL, 1), &ahead));
    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_project(uv, &camera, X_c));
    camera.k1 = RC(TOL(1e-148, 1e-18));
    ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, uv, rigcal_camera_project(uv, &camera, X_c));
    rigcal_real x[2], J[6];
    ASSERT_STATUS(RIGCAL_ERR_NO_RAY, rc_project_by(x, uv, J, &camera, X_c));
}

TEST_MAIN()
{
    RUN_TEST(test_points_are_projected_by_the_formulas_of_the_header);
    RUN_TEST(test_points_are_projected_as_the_oracle_does);
    RUN_TEST(test_the_derivative_of_a_pixel_is_that_of_the_formulas);
    RUN_TEST(test_a_pinhole_is_exact_where_it_can_be);
    RUN_TEST(test_the_principal_point_is_the_image_of_the_axis);
    RUN_TEST(test_undistorted_pixels_are_those_of_the_pinhole_and_go_back);
    RUN_TEST(test_a_fisheye_ray_at_90_degrees_has_no_undistorted_pixel);
    RUN_TEST(test_a_fisheye_ray_below_90_degrees_has_an_undistorted_pixel);
    RUN_TEST(test_the_least_focal_length);
    RUN_TEST(test_large_pixels_have_rays_as_good_as_rounding);
    RUN_TEST(test_pixels_without_a_ray_are_not_undistorted_either);
    RUN_TEST(test_what_is_not_in_front_is_not_imaged);
    RUN_TEST(test_no_lens_images_what_is_not_in_front);
    RUN_TEST(test_a_fisheye_sees_behind_itself_but_not_its_own_centre);
    RUN_TEST(test_a_fisheye_does_not_see_straight_back);
    RUN_TEST(test_intrinsics_that_cannot_be_are_refused);
    RUN_TEST(test_a_fisheye_has_no_coefficients_but_its_four);
    RUN_TEST(test_the_error_of_exact_pixels_is_zero);
    RUN_TEST(test_the_error_is_the_root_of_the_mean_squared_distance);
    RUN_TEST(test_no_error_is_told_of_points_that_cannot_be_seen);
    RUN_TEST(test_what_is_no_number_is_told_first);
    RUN_TEST(test_the_error_is_that_of_2_to_the_28_points_at_most);
    RUN_TEST(test_the_worst_point_is_the_first_that_is_off_by_the_most);
    RUN_TEST(test_a_pixel_is_two_numbers);
    RUN_TEST(test_the_size_of_a_pixel_follows_the_focal_length);
    RUN_TEST(test_a_pixel_that_overflows_is_none);
}
