/* epiline: the line in one image on which the match of a pixel of another must lie. */
#include <math.h>
#include <string.h>

#include "rc_real.h"
#include "test_two_views.h"
#include "vectors_camera.h"
#include "vectors_two_views.h"

#define TOL_FORMULA TOL(1e-12, 1e-4)
#define TOL_PIXEL TOL(2e-9, 4e-3)

static const rigcal_transform NOTHING = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};

static const rigcal_real M_A[3] = {RC(0.75), 0, 1};

/* ---- matching line (25), (26) -------------------------------------------- */

/* Camera b is 1 to the right: matches have the same y. */
static const rigcal_transform RIGHT_OF = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {-1, 0, 0}};

static void test_the_matching_line_of_a_camera_beside_is_level(void)
{
    static const double expected[3] = {0, 1, -0.3};
    const rigcal_real ray[3] = {RC(0.2), RC(0.3), 1};
    rigcal_real line[3];

    ASSERT_STATUS(RIGCAL_OK, rigcal_epiline(line, &RIGHT_OF, ray));
    ASSERT_ARRAY_NEAR(expected, line, 3, TOL(1e-15, 1e-7));
}

static void test_matching_lines_are_the_oracles(void)
{
    for (int i = 0; i < TWO_VIEWS_ROWS; i++) {
        const double *v = TWO_VIEWS[i];
        const rigcal_transform b_from_a = test_from_ypr(v, v + 3);
        rigcal_real ray[3] = {RC(v[6]), RC(v[7]), 1}, line[3];

        ASSERT_STATUS(RIGCAL_OK, rigcal_epiline(line, &b_from_a, ray));
        ASSERT_ARRAY_NEAR(v + 13, line, 3, TOL_FORMULA * fmax(1, fabs(v[15])));
    }
}

/* All points of a ray of a, near and far. Only the direction of the ray matters. */
static void test_a_projected_point_lies_on_its_matching_line(void)
{
    test_rng rng = test_seed(61);

    for (int trial = 0; trial < 200; trial++) {
        const rigcal_transform b_from_a = test_beside(&rng);
        const double length = test_uniform(&rng, 0.1, 50);
        double X_a[3], X_b[3];
        rigcal_real ray[3], line[3];

        test_point_ahead(X_a, &rng);
        for (int k = 0; k < 3; k++) {
            ray[k] = RC(X_a[k] * length);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_epiline(line, &b_from_a, ray));
        ASSERT_NEAR(1, hypot(D(line[0]), D(line[1])), TOL(1e-15, 2e-7));
        for (int d = 0; d < 5; d++) {
            const double depth = 0.7 + 0.4 * d;
            double X_d[3];

            for (int k = 0; k < 3; k++) {
                X_d[k] = depth * X_a[k];
            }
            test_move_point(X_b, &b_from_a, X_d);
            ASSERT_NEAR(
                0, D(line[0]) * X_b[0] / X_b[2] + D(line[1]) * X_b[1] / X_b[2] + D(line[2]),
                TOL(1e-14, 5e-6));
        }
    }
}

static void test_the_image_of_the_other_centre_has_no_matching_line(void)
{
    test_rng rng = test_seed(62);

    for (int trial = 0; trial < 50; trial++) {
        double ypr[3], t[3], forward[3] = {0.1, -0.2, 1}, R[9], o[3];
        rigcal_transform b_from_a;
        rigcal_real ray[3], line[3];

        for (int k = 0; k < 3; k++) {
            ypr[k] = test_uniform(&rng, -0.5, 0.5);
        }
        /* The centre of b is 2 ahead of a: t = -R o. */
        test_rotation(R, ypr[0], ypr[1], ypr[2]);
        for (int k = 0; k < 3; k++) {
            o[k] = -2 * forward[k];
        }
        test_apply(t, R, o, NULL);
        b_from_a = test_transform(R, t);
        for (int sign = -1; sign <= 1; sign += 2) {
            for (int k = 0; k < 3; k++) {
                ray[k] = RC(sign * forward[k]);
            }
            ASSERT_REFUSED(RIGCAL_ERR_EPIPOLE, line, rigcal_epiline(line, &b_from_a, ray));
        }
        ray[0] += RC(0.01);
        ASSERT_STATUS(RIGCAL_OK, rigcal_epiline(line, &b_from_a, ray));
    }
}

static void test_cameras_in_one_place_have_no_matching_lines(void)
{
    test_rng rng = test_seed(63);
    double R[9];
    rigcal_transform turned;
    rigcal_real line[3];

    test_random_rotation(R, &rng);
    turned = test_transform(R, NULL);
    ASSERT_REFUSED(RIGCAL_ERR_EPIPOLE, line, rigcal_epiline(line, &NOTHING, M_A));
    ASSERT_REFUSED(RIGCAL_ERR_EPIPOLE, line, rigcal_epiline(line, &turned, M_A));
}

/* The plane through both centres and the ray is parallel to b's image plane. All of it is
 * 90 degrees off b's axis, so none of it is in the image. */
static void test_a_matching_line_at_infinity_is_refused(void)
{
    static const rigcal_transform level = {{1, 0, 0, 0, 0, -1, 0, 1, 0}, {-1, 0, 0}};
    const rigcal_camera camera = test_pinhole();
    const rigcal_real ray[3] = {RC(0.2), 0, 1}; /* along b's -y, in its plane */
    rigcal_real line[3];

    ASSERT_REFUSED(RIGCAL_ERR_OUTSIDE, line, rigcal_epiline(line, &level, ray));
    ASSERT_REFUSED(RIGCAL_ERR_OUTSIDE, line, rigcal_epiline_px(line, &camera, &level, ray));
}

static void test_arguments_of_the_matching_line_are_checked(void)
{
    const rigcal_real none[3] = {0, 0, 0};
    const rigcal_camera camera = test_pinhole();
    rigcal_camera broken = camera;
    rigcal_real line[3];

    broken.fy = -1;
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_epiline(NULL, &RIGHT_OF, M_A));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, line, rigcal_epiline(line, NULL, M_A));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, line, rigcal_epiline(line, &RIGHT_OF, NULL));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, line, rigcal_epiline(line, &RIGHT_OF, none));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_epiline_px(NULL, &camera, &RIGHT_OF, M_A));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, line, rigcal_epiline_px(line, NULL, &RIGHT_OF, M_A));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, line, rigcal_epiline_px(line, &camera, NULL, M_A));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, line,
                   rigcal_epiline_px(line, &camera, &RIGHT_OF, NULL));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, line,
                   rigcal_epiline_px(line, &camera, &RIGHT_OF, none));
    ASSERT_REFUSED(RIGCAL_ERR_CAMERA, line,
                   rigcal_epiline_px(line, &broken, &RIGHT_OF, M_A));
    ASSERT_REFUSED(RIGCAL_ERR_EPIPOLE, line,
                   rigcal_epiline_px(line, &camera, &NOTHING, M_A));
    for (int k = 0; k < 3; k++) {
        rigcal_transform T = RIGHT_OF;
        rigcal_real bad[3] = {0, 0, 1};

        bad[k] = TEST_NAN;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, line, rigcal_epiline(line, &RIGHT_OF, bad));
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, line,
                       rigcal_epiline_px(line, &camera, &RIGHT_OF, bad));
        T.t[k] = TEST_INF;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, line, rigcal_epiline(line, &T, M_A));
        T = RIGHT_OF;
        T.R[3 * k] += RC(0.1);
        ASSERT_REFUSED(RIGCAL_ERR_ROTATION, line, rigcal_epiline(line, &T, M_A));
        ASSERT_REFUSED(RIGCAL_ERR_ROTATION, line,
                       rigcal_epiline_px(line, &camera, &T, M_A));
    }
}

/* ---- in pixels ----------------------------------------------------------- */

/* The pixel at which a camera without distortion would see X_b. */
static void straight_pixel(double uv[2], const rigcal_camera *camera, const double X_b[3])
{
    uv[0] = D(camera->fx) * X_b[0] / X_b[2] + D(camera->cx);
    uv[1] = D(camera->fy) * X_b[1] / X_b[2] + D(camera->cy);
}

static void test_a_matching_line_in_pixels_on_paper(void)
{
    /* y = 0.3 is v = 800 * 0.3 + 239.5. */
    static const double expected[3] = {0, 1, -479.5};
    const rigcal_camera camera = test_pinhole();
    const rigcal_real ray[3] = {RC(0.2), RC(0.3), 1};
    rigcal_real line[3];

    ASSERT_STATUS(RIGCAL_OK, rigcal_epiline_px(line, &camera, &RIGHT_OF, ray));
    ASSERT_ARRAY_NEAR(expected, line, 3, TOL(1e-12, 1e-4));
}

static void test_true_matches_lie_on_their_line_in_any_lens(void)
{
    test_rng rng = test_seed(64);

    for (int trial = 0; trial < 200; trial++) {
        const rigcal_transform b_from_a = test_beside(&rng);
        rigcal_camera camera = test_camera(CAMERA[trial % CAMERA_ROWS]);
        double X_a[3], X_b[3], straight[2], distorted[2], along, off;
        rigcal_real ray[3], line[3], uv[2], distance;

        camera.fx *= RC(1.25); /* pixels that are not square */
        test_point_ahead(X_a, &rng);
        test_move_point(X_b, &b_from_a, X_a);
        test_ray_to(ray, X_a);
        ASSERT_STATUS(RIGCAL_OK, rigcal_epiline_px(line, &camera, &b_from_a, ray));
        ASSERT_NEAR(1, hypot(D(line[0]), D(line[1])), TOL(1e-14, 1e-6));
        straight_pixel(straight, &camera, X_b);
        ASSERT_NEAR(0, D(line[0]) * straight[0] + D(line[1]) * straight[1] + D(line[2]),
                    TOL(1e-10, 1e-2));

        /* The distorted pixel of the point, and of a point beside it: its distance is how
         * far it is off in undistorted pixels, with the sign. */
        for (int beside_it = 0; beside_it < 2; beside_it++) {
            X_b[0] += beside_it * 0.01 * X_b[2];
            X_b[1] -= beside_it * 0.02 * X_b[2];
            test_project_px(distorted, &camera, X_b);
            straight_pixel(straight, &camera, X_b);
            along = D(line[0]) * straight[0] + D(line[1]) * straight[1];
            off = along + D(line[2]);
            test_to_real(uv, distorted, 2);
            ASSERT_STATUS(RIGCAL_OK, rigcal_epiline_distance(&distance, line, &camera, uv));
            ASSERT_NEAR(off, distance, 10 * TOL_PIXEL);
        }
    }
}

static void test_the_distance_from_a_line_is_in_pixels_with_its_sign(void)
{
    const rigcal_camera camera = test_pinhole();
    const rigcal_real line[3] = {RC(0.6), RC(-0.8), RC(-20)};
    const rigcal_real on[2] = {100, 50}, off[2] = {106, 42};
    rigcal_real distance;

    ASSERT_STATUS(RIGCAL_OK, rigcal_epiline_distance(&distance, line, &camera, on));
    ASSERT_NEAR(0, distance, TOL(1e-12, 1e-4));
    ASSERT_STATUS(RIGCAL_OK, rigcal_epiline_distance(&distance, line, &camera, off));
    ASSERT_NEAR(10, distance, TOL(1e-12, 1e-4));
}

static void test_arguments_of_the_distance_are_checked(void)
{
    const rigcal_camera camera = test_pinhole(), fisheye = test_camera(CAMERA[4]);
    const rigcal_real line[3] = {RC(0.6), RC(-0.8), RC(-20)};
    const rigcal_real uv[2] = {100, 50}, beyond[2] = {5000, 50};
    const double beside_it[3] = {1, 0.1, -0.1};
    rigcal_camera barrel = camera, broken = camera;
    double wide[2];
    rigcal_real wide_uv[2], distance;

    barrel.k1 = RC(-0.4);
    broken.width = 0;
    test_project_px(wide, &fisheye, beside_it);
    test_to_real(wide_uv, wide, 2);
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_epiline_distance(NULL, line, &camera, uv));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, distance,
                   rigcal_epiline_distance(&distance, NULL, &camera, uv));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, distance,
                   rigcal_epiline_distance(&distance, line, NULL, uv));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, distance,
                   rigcal_epiline_distance(&distance, line, &camera, NULL));
    ASSERT_REFUSED(RIGCAL_ERR_CAMERA, distance,
                   rigcal_epiline_distance(&distance, line, &broken, uv));
    ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, distance,
                   rigcal_epiline_distance(&distance, line, &barrel, beyond));
    ASSERT_REFUSED(RIGCAL_ERR_WIDE_RAY, distance,
                   rigcal_epiline_distance(&distance, line, &fisheye, wide_uv));
    for (int k = 0; k < 3; k++) {
        rigcal_real bad[3] = {RC(0.6), RC(-0.8), RC(-20)};

        bad[k] = TEST_NAN;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, distance,
                       rigcal_epiline_distance(&distance, bad, &camera, uv));
        if (k < 2) {
            rigcal_real nowhere[2] = {1, 1};

            bad[k] = RC(0.5);
            ASSERT_REFUSED(RIGCAL_ERR_RANGE, distance,
                           rigcal_epiline_distance(&distance, bad, &camera, uv));
            nowhere[k] = TEST_INF;
            ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, distance,
                           rigcal_epiline_distance(&distance, line, &camera, nowhere));
        }
    }
}

/* ---- clipped to the image ------------------------------------------------ */

static void test_lines_on_paper_are_clipped_at_pixel_borders(void)
{
    /* A 640 x 480 image reaches from (-0.5, -0.5) to (639.5, 479.5). The ends
     * run along (beta, -alpha). */
    static const double s = 0.70710678118654752440;
    const struct {
        double line[3], ends[4];
    } cases[] = {
        {{0, 1, -100}, {-0.5, 100, 639.5, 100}},
        {{0, -1, 100}, {639.5, 100, -0.5, 100}},
        {{1, 0, -320}, {320, 479.5, 320, -0.5}},
        {{-1, 0, 320}, {320, -0.5, 320, 479.5}},
        /* u - v = 0 from the corner; u + v = 479 through two borders. */
        {{-s, s, 0}, {-0.5, -0.5, 479.5, 479.5}},
        {{s, s, -479 * s}, {-0.5, 479.5, 479.5, -0.5}},
        /* The other corner: u + v = 1 cuts it off. */
        {{s, s, -s}, {-0.5, 1.5, 1.5, -0.5}},
        {{-0.6, 0.8, 0}, {-0.5, -0.375, 639.3333333333333333, 479.5}},
        /* The borders themselves belong to the image. */
        {{0, 1, 0.5}, {-0.5, -0.5, 639.5, -0.5}},
        {{0, 1, -479.5}, {-0.5, 479.5, 639.5, 479.5}},
        {{1, 0, 0.5}, {-0.5, 479.5, -0.5, -0.5}},
        {{1, 0, -639.5}, {639.5, 479.5, 639.5, -0.5}},
    };

    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        rigcal_real line[3], ends[4];

        test_to_real(line, cases[i].line, 3);
        ASSERT_STATUS(RIGCAL_OK, rigcal_epiline_clip(ends, line, 640, 480));
        ASSERT_ARRAY_NEAR(cases[i].ends, ends, 4, TOL(1e-12, 5e-4));
    }
}

/* Random lines: both ends are on the line and on the border, in the right order. A line is
 * refused only if all corners lie on one side of it. */
static void test_clipped_ends_lie_on_the_line_and_on_the_border(void)
{
    const double right = 639.5, bottom = 479.5, tol = TOL(1e-9, 1e-2);
    test_rng rng = test_seed(65);
    int crossing = 0;

    for (int trial = 0; trial < 500; trial++) {
        const double way = test_uniform(&rng, -TEST_PI, TEST_PI);
        const double a = cos(way), b = sin(way);
        const double c =
            -a * test_uniform(&rng, -300, 900) - b * test_uniform(&rng, -300, 700);
        const rigcal_real line[3] = {RC(a), RC(b), RC(c)};
        double least = 1e9, most = -1e9, e[4];
        rigcal_real ends[4];
        rigcal_status status;

        for (int corner = 0; corner < 4; corner++) {
            const double d =
                a * (corner & 1 ? right : -0.5) + b * (corner & 2 ? bottom : -0.5) + c;

            least = fmin(least, d);
            most = fmax(most, d);
        }
        FILL(ends);
        status = rigcal_epiline_clip(ends, line, 640, 480);
        if (least > tol || most < -tol) {
            ASSERT_STATUS(RIGCAL_ERR_OUTSIDE, status);
            ASSERT_UNTOUCHED(ends);
            continue;
        }
        if (least > -tol || most < tol) {
            continue; /* the line touches a corner: with rounding either answer is right */
        }
        crossing++;
        ASSERT_STATUS(RIGCAL_OK, status);
        test_to_double(e, ends, 4);
        for (int k = 0; k < 4; k += 2) {
            const double u = e[k], v = e[k + 1];

            ASSERT_NEAR(0, a * u + b * v + c, tol);
            TEST_ASSERT_TRUE(u >= -0.5 && u <= right && v >= -0.5 && v <= bottom);
            TEST_ASSERT_TRUE(fabs(u + 0.5) < tol || fabs(u - right) < tol ||
                             fabs(v + 0.5) < tol || fabs(v - bottom) < tol);
        }
        TEST_ASSERT_TRUE((e[2] - e[0]) * b - (e[3] - e[1]) * a > 0);
    }
    TEST_ASSERT_TRUE(crossing > 150);
}

static void test_lines_beside_the_image_are_refused(void)
{
    const double s = 0.70710678118654752440;
    const double lines[5][3] = {
        {0, 1, -479.6}, {0, 1, 0.6}, {1, 0, -639.6}, {1, 0, 0.6}, {s, s, 2}};

    for (int i = 0; i < 5; i++) {
        rigcal_real line[3], ends[4];

        test_to_real(line, lines[i], 3);
        ASSERT_REFUSED(RIGCAL_ERR_OUTSIDE, ends, rigcal_epiline_clip(ends, line, 640, 480));
    }
}

static void test_arguments_of_the_clipping_are_checked(void)
{
    const rigcal_real line[3] = {RC(0.6), RC(0.8), RC(-200)};
    rigcal_real ends[4];

    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_epiline_clip(NULL, line, 640, 480));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, ends, rigcal_epiline_clip(ends, NULL, 640, 480));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, ends, rigcal_epiline_clip(ends, line, 0, 480));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, ends, rigcal_epiline_clip(ends, line, 640, -1));
    for (int k = 0; k < 3; k++) {
        rigcal_real bad[3] = {RC(0.6), RC(0.8), RC(-200)};

        bad[k] = TEST_INF;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, ends,
                       rigcal_epiline_clip(ends, bad, 640, 480));
        if (k < 2) {
            bad[k] = 0;
            ASSERT_REFUSED(RIGCAL_ERR_RANGE, ends,
                           rigcal_epiline_clip(ends, bad, 640, 480));
        }
    }
}

/* ---- between two depths -------------------------------------------------- */

/* The X_b of the point at that depth along ray_a. */
static void at_depth(double X_b[3], const rigcal_transform *b_from_a,
                     const rigcal_real ray_a[3], double depth)
{
    double X_a[3];

    for (int k = 0; k < 3; k++) {
        X_a[k] = depth * D(ray_a[k]);
    }
    test_move_point(X_b, b_from_a, X_a);
}

static void test_the_segment_ends_where_the_nearest_and_farthest_would_be(void)
{
    test_rng rng = test_seed(66);

    for (int trial = 0; trial < 100; trial++) {
        const rigcal_transform b_from_a = test_beside(&rng);
        const rigcal_camera camera = test_camera(CAMERA[trial % CAMERA_ROWS]);
        double X_a[3], X_b[3], expected[4];
        rigcal_real ray[3], ends[4], line[3];

        test_point_ahead(X_a, &rng);
        test_to_real(ray, X_a, 3); /* with this ray the depth 1 is the point */
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_epiline_segment(ends, &camera, &b_from_a, ray, RC(0.5), 4));
        at_depth(X_b, &b_from_a, ray, 0.5);
        straight_pixel(expected, &camera, X_b);
        at_depth(X_b, &b_from_a, ray, 4);
        straight_pixel(expected + 2, &camera, X_b);
        ASSERT_ARRAY_NEAR(expected, ends, 4, TOL(1e-10, 5e-3));
        ASSERT_STATUS(RIGCAL_OK, rigcal_epiline_px(line, &camera, &b_from_a, ray));
        for (int k = 0; k < 4; k += 2) {
            ASSERT_NEAR(0,
                        D(line[0]) * D(ends[k]) + D(line[1]) * D(ends[k + 1]) + D(line[2]),
                        TOL(1e-10, 2e-2));
        }
    }
}

static void test_the_curve_leaves_out_what_the_camera_cannot_see(void)
{
    /* b's axis is a's axis turned back (half a turn about y), 2 ahead of a. A point at
     * depth Z of a is at 2 - Z of b. */
    static const rigcal_transform facing = {{-1, 0, 0, 0, 1, 0, 0, 0, -1}, {0, RC(0.5), 2}};
    const rigcal_camera camera = test_pinhole();
    const rigcal_real ray[3] = {RC(0.1), 0, 1};
    double seen[3];
    rigcal_real uv[2 * 7 + 1], ends[4];
    rigcal_real *guard = &uv[14];
    size_t n_written;

    /* 1 / depth = 1, 7/8, .. 1/4: depths 1, 8/7, 4/3, 8/5, 2, 8/3, 4. Four of these are in
     * front of b. */
    FILL(uv);
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_epiline_curve(uv, 7, &n_written, &camera, &facing, ray, 1, 4));
    TEST_ASSERT_EQUAL_size_t(4, n_written);
    ASSERT_UNTOUCHED(*guard);
    for (int k = 0; k < 4; k++) {
        double expected[2];

        at_depth(seen, &facing, ray, 1 / (1 - k / 8.0));
        test_project_px(expected, &camera, seen);
        ASSERT_ARRAY_NEAR(expected, uv + 2 * k, 2, TOL(1e-9, 1e-2));
    }
    ASSERT_REFUSED(RIGCAL_ERR_WIDE_RAY, ends,
                   rigcal_epiline_segment(ends, &camera, &facing, ray, 1, 4));
    ASSERT_REFUSED(RIGCAL_ERR_WIDE_RAY, ends,
                   rigcal_epiline_segment(ends, &camera, &facing, ray, 3, 4));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_epiline_segment(ends, &camera, &facing, ray, 1, RC(1.5)));
    FILL(n_written);
    ASSERT_REFUSED(RIGCAL_ERR_OUTSIDE, uv,
                   rigcal_epiline_curve(uv, 7, &n_written, &camera, &facing, ray, 3, 4));
    ASSERT_UNTOUCHED(n_written);
}

/* A ray is in front of b if its z is above the rounding of its largest coordinate. */
static void test_a_segment_ends_at_the_plane_of_b(void)
{
    static const double LOW[3] = {0.5, 1, 1.5};
    const rigcal_camera camera = test_pinhole();
    const rigcal_real ray[3] = {0, 0, 1};
    rigcal_transform T = RIGHT_OF;
    rigcal_real ends[4];

    for (int k = 0; k < 3; k++) {
        const double z = LOW[k] * D(RC_EPS);

        T.t[0] = 1;
        T.t[1] = T.t[2] = 0;
        if (k < 2) {
            ASSERT_REFUSED(RIGCAL_ERR_WIDE_RAY, ends,
                           rigcal_epiline_segment(ends, &camera, &T, ray, RC(z), 2));
        } else {
            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_epiline_segment(ends, &camera, &T, ray, RC(z), 2));
            ASSERT_NEAR(1, D(ends[0]) * z / D(camera.fx), TOL(1e-9, 1e-5));
        }
    }
    T.t[2] = -1; /* in the plane of b, then behind it */
    for (int near = 1; near <= 2; near++) {
        ASSERT_REFUSED(RIGCAL_ERR_WIDE_RAY, ends,
                       rigcal_epiline_segment(ends, &camera, &T, ray, RC(near) / 2,
                                              RC(near) / 2 + RC(0.5)));
    }
}

/* Samples are even in 1 / depth from near to far. The sixth of eleven samples is the true
 * point, so the curve passes through its true pixel. */
static void test_the_curve_runs_through_the_true_match_in_any_lens(void)
{
    enum { COUNT = 11 };
    const double near = 0.6, far = 1 / (2 - 1 / near);
    test_rng rng = test_seed(67);

    for (int trial = 0; trial < 100; trial++) {
        const rigcal_transform b_from_a = test_beside(&rng);
        const rigcal_camera camera = test_camera(CAMERA[trial % CAMERA_ROWS]);
        double X_a[3], X_b[3], expected[2];
        rigcal_real ray[3], uv[2 * COUNT + 1];
        rigcal_real *guard = &uv[2 * COUNT];
        size_t n_written;

        test_point_ahead(X_a, &rng);
        test_to_real(ray, X_a, 3);
        FILL(uv);
        ASSERT_STATUS(RIGCAL_OK, rigcal_epiline_curve(uv, COUNT, &n_written, &camera,
                                                      &b_from_a, ray, RC(near), RC(far)));
        TEST_ASSERT_EQUAL_size_t(COUNT, n_written);
        ASSERT_UNTOUCHED(*guard);
        for (int k = 0; k < COUNT; k++) {
            const double inverse = 1 / near + (1 / far - 1 / near) * k / 10.0;

            at_depth(X_b, &b_from_a, ray, 1 / inverse);
            test_project_px(expected, &camera, X_b);
            ASSERT_ARRAY_NEAR(expected, uv + 2 * k, 2, TOL(1e-9, 1e-2));
        }
        test_move_point(X_b, &b_from_a, X_a);
        test_project_px(expected, &camera, X_b);
        ASSERT_ARRAY_NEAR(expected, uv + COUNT - 1, 2, TOL(1e-9, 1e-2));
    }
}

static void test_a_curve_of_two_points_is_the_segment_without_distortion(void)
{
    const rigcal_camera camera = test_pinhole();
    double expected[4];
    rigcal_real ends[4], uv[4];
    size_t n_written;

    ASSERT_STATUS(RIGCAL_OK, rigcal_epiline_segment(ends, &camera, &RIGHT_OF, M_A, 2, 9));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_epiline_curve(uv, 2, &n_written, &camera, &RIGHT_OF, M_A, 2, 9));
    TEST_ASSERT_EQUAL_size_t(2, n_written);
    test_to_double(expected, ends, 4);
    ASSERT_ARRAY_NEAR(expected, uv, 4, TOL(1e-11, 1e-3));
}

/* The rays of the barrel lens end some 43 degrees off its axis. Farther samples are left
 * out, not put on the folded branch. */
static void test_the_curve_stops_at_the_turning_point_of_the_lens(void)
{
    static const rigcal_transform beside_by_three = {{1, 0, 0, 0, 1, 0, 0, 0, 1},
                                                     {3, 0, 0}};
    rigcal_camera camera = test_pinhole();
    const rigcal_real ray[3] = {0, 0, 1};
    rigcal_real uv[40];
    size_t n_written;
    /* x d(x) = x - 0.4 x^3 rises up to x = sqrt(1 / 1.2). */
    const double turn = sqrt(1 / 1.2);

    camera.k1 = RC(-0.4);
    ASSERT_STATUS(RIGCAL_OK, rigcal_epiline_curve(uv, 20, &n_written, &camera,
                                                  &beside_by_three, ray, 1, 100));
    TEST_ASSERT_TRUE(n_written > 2 && n_written < 20);
    for (int k = 0; k < 20; k++) {
        const double x = 3 * (1 + (0.01 - 1) * k / 19);
        const size_t from_end = 20 - (size_t)k;

        if (x < turn - 1e-3) {
            TEST_ASSERT_TRUE(from_end <= n_written);
            ASSERT_NEAR(800 * x * (1 - 0.4 * x * x) + 319.5, uv[2 * (n_written - from_end)],
                        TOL(1e-9, 1e-2));
        } else {
            TEST_ASSERT_TRUE(from_end > n_written);
        }
    }
}

static rigcal_status segment(rigcal_real ends[4], const rigcal_camera *camera,
                             const rigcal_transform *T, const rigcal_real ray[3],
                             double near, double far)
{
    return rigcal_epiline_segment(ends, camera, T, ray, RC(near), RC(far));
}

static rigcal_status curve(rigcal_real uv[], size_t *n, size_t count,
                           const rigcal_camera *camera, const rigcal_transform *T,
                           const rigcal_real ray[3], double near, double far)
{
    return rigcal_epiline_curve(uv, count, n, camera, T, ray, RC(near), RC(far));
}

static void test_arguments_of_segment_and_curve_are_checked(void)
{
    const rigcal_transform *const T = &RIGHT_OF;
    const rigcal_real none[3] = {0, 0, 0};
    const rigcal_camera cam = test_pinhole();
    rigcal_camera broken = cam;
    rigcal_real ends[4], uv[8];
    size_t n;

    broken.lens = 7;
    FILL(n);
    ASSERT_STATUS(RIGCAL_ERR_NULL, segment(NULL, &cam, T, M_A, 1, 2));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, ends, segment(ends, NULL, T, M_A, 1, 2));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, ends, segment(ends, &cam, NULL, M_A, 1, 2));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, ends, segment(ends, &cam, T, NULL, 1, 2));
    ASSERT_STATUS(RIGCAL_ERR_NULL, curve(NULL, &n, 4, &cam, T, M_A, 1, 2));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, uv, curve(uv, NULL, 4, &cam, T, M_A, 1, 2));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, uv, curve(uv, &n, 4, NULL, T, M_A, 1, 2));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, uv, curve(uv, &n, 4, &cam, NULL, M_A, 1, 2));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, uv, curve(uv, &n, 4, &cam, T, NULL, 1, 2));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, uv, curve(uv, &n, 1, &cam, T, M_A, 1, 2));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, uv, curve(uv, &n, 0, &cam, T, M_A, 1, 2));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, uv,
                   curve(uv, &n, ((size_t)1 << 28) + 1, &cam, T, M_A, 1, 2));
    ASSERT_REFUSED(RIGCAL_ERR_CAMERA, ends, segment(ends, &broken, T, M_A, 1, 2));
    ASSERT_REFUSED(RIGCAL_ERR_CAMERA, uv, curve(uv, &n, 4, &broken, T, M_A, 1, 2));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, ends, segment(ends, &cam, T, none, 1, 2));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, uv, curve(uv, &n, 4, &cam, T, none, 1, 2));
    for (int i = 0; i < 4; i++) {
        static const double near_far[4][2] = {{0, 2}, {-1, 2}, {2, 2}, {3, 2}};
        const double near = near_far[i][0], far = near_far[i][1];

        ASSERT_REFUSED(RIGCAL_ERR_RANGE, ends, segment(ends, &cam, T, M_A, near, far));
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, uv, curve(uv, &n, 4, &cam, T, M_A, near, far));
    }
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, ends,
                   segment(ends, &cam, T, M_A, 1, test_infinity()));
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, uv,
                   curve(uv, &n, 4, &cam, T, M_A, test_nan(), 2));
    for (int k = 0; k < 3; k++) {
        rigcal_transform bad = RIGHT_OF;
        rigcal_real ray[3] = {0, 0, 1};

        ray[k] = TEST_NAN;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, ends, segment(ends, &cam, T, ray, 1, 2));
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, uv, curve(uv, &n, 4, &cam, T, ray, 1, 2));
        bad.t[k] = TEST_NAN;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, ends, segment(ends, &cam, &bad, M_A, 1, 2));
        bad = RIGHT_OF;
        bad.R[4 * k] = -1;
        ASSERT_REFUSED(RIGCAL_ERR_ROTATION, ends, segment(ends, &cam, &bad, M_A, 1, 2));
        ASSERT_REFUSED(RIGCAL_ERR_ROTATION, uv, curve(uv, &n, 4, &cam, &bad, M_A, 1, 2));
    }
    ASSERT_UNTOUCHED(n);
}

/* As tangents there is a line, to 64 roundings. In pixels of a long lens it is too far away
 * to be computed. */
static void test_a_line_too_far_off_for_its_pixels_is_refused(void)
{
    const rigcal_transform beside = {{1, 0, 0, 0, 1, 0, 0, 0, 1},
                                     {1, 0, 64 * RC(TOL(2.3e-16, 1.2e-7))}};
    const rigcal_real ray[3] = {0, 1, 0};
    rigcal_camera camera = test_pinhole();
    rigcal_real line[3];

    camera.fx = camera.fy = 1000;
    ASSERT_STATUS(RIGCAL_OK, rigcal_epiline(line, &beside, ray));
    ASSERT_REFUSED(RIGCAL_ERR_OUTSIDE, line,
                   rigcal_epiline_px(line, &camera, &beside, ray));
}

/* The angle between t and the ray, and the slope of a line, must be more than 16
 * roundings. */
static void test_the_limits_of_a_matching_line(void)
{
    for (int more = 0; more < 2; more++) {
        const rigcal_real least = RC(16 + more) * RC_EPS;
        const rigcal_real near_t[3] = {least, 0, 1}, up[3] = {0, 1, 0};
        rigcal_transform T = RIGHT_OF;
        rigcal_real line[3];

        T.t[0] = T.t[1] = 0;
        T.t[2] = 1;
        ASSERT_STATUS(more ? RIGCAL_OK : RIGCAL_ERR_EPIPOLE,
                      rigcal_epiline(line, &T, near_t));
        T.t[0] = 1;
        T.t[2] = least;
        ASSERT_STATUS(more ? RIGCAL_OK : RIGCAL_ERR_OUTSIDE, rigcal_epiline(line, &T, up));
    }
}

static void test_the_largest_image_is_clipped(void)
{
    const rigcal_real level[3] = {0, 1, 0};
    const int32_t most = 1000000;
    rigcal_real ends[4];

    ASSERT_STATUS(RIGCAL_OK, rigcal_epiline_clip(ends, level, most, most));
    ASSERT_NEAR(-0.5, ends[0] < ends[2] ? ends[0] : ends[2], 0.1);
    ASSERT_NEAR(most - 0.5, ends[0] < ends[2] ? ends[2] : ends[0], 0.1);
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, ends, rigcal_epiline_clip(ends, level, most + 1, 1));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, ends, rigcal_epiline_clip(ends, level, 1, most + 1));
    ASSERT_STATUS(RIGCAL_OK, rigcal_epiline_clip(ends, level, 1, 1));
}

TEST_MAIN()
{
    RUN_TEST(test_the_largest_image_is_clipped);
    RUN_TEST(test_the_matching_line_of_a_camera_beside_is_level);
    RUN_TEST(test_matching_lines_are_the_oracles);
    RUN_TEST(test_a_projected_point_lies_on_its_matching_line);
    RUN_TEST(test_the_image_of_the_other_centre_has_no_matching_line);
    RUN_TEST(test_cameras_in_one_place_have_no_matching_lines);
    RUN_TEST(test_a_matching_line_at_infinity_is_refused);
    RUN_TEST(test_arguments_of_the_matching_line_are_checked);
    RUN_TEST(test_a_matching_line_in_pixels_on_paper);
    RUN_TEST(test_true_matches_lie_on_their_line_in_any_lens);
    RUN_TEST(test_the_distance_from_a_line_is_in_pixels_with_its_sign);
    RUN_TEST(test_arguments_of_the_distance_are_checked);
    RUN_TEST(test_lines_on_paper_are_clipped_at_pixel_borders);
    RUN_TEST(test_clipped_ends_lie_on_the_line_and_on_the_border);
    RUN_TEST(test_lines_beside_the_image_are_refused);
    RUN_TEST(test_arguments_of_the_clipping_are_checked);
    RUN_TEST(test_the_segment_ends_where_the_nearest_and_farthest_would_be);
    RUN_TEST(test_the_curve_leaves_out_what_the_camera_cannot_see);
    RUN_TEST(test_a_segment_ends_at_the_plane_of_b);
    RUN_TEST(test_the_curve_runs_through_the_true_match_in_any_lens);
    RUN_TEST(test_a_curve_of_two_points_is_the_segment_without_distortion);
    RUN_TEST(test_the_curve_stops_at_the_turning_point_of_the_lens);
    RUN_TEST(test_arguments_of_segment_and_curve_are_checked);
    RUN_TEST(test_a_line_too_far_off_for_its_pixels_is_refused);
    RUN_TEST(test_the_limits_of_a_matching_line);
}
