/* triangulate: depth from two views, points from many, and the bound on the error of a
 * measured point. */
#include <math.h>
#include <string.h>

#include "rc_real.h"
#include "test_two_views.h"
#include "vectors_camera.h"
#include "vectors_transform.h"
#include "vectors_triangulation.h"
#include "vectors_two_views.h"

static const rigcal_transform NOTHING = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};

/* ---- depth from two views (22)..(24) ------------------------------------- */

/* Two 3-4-5 triangles back to back: the cameras are 6 apart, the point is 4 ahead. Camera b
 * is 1/4 lower (y is down), so the rays miss each other by 1/4. */
static const rigcal_transform B_FROM_A = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {-6, RC(-0.25), 0}};
static const rigcal_real M_A[3] = {RC(0.75), 0, 1}, M_B[3] = {RC(-0.75), 0, 1};

static void test_skew_rays_give_both_depths_and_their_miss(void)
{
    rigcal_real depth[2], miss;

    ASSERT_STATUS(RIGCAL_OK, rigcal_depth_two_views(depth, &miss, &B_FROM_A, M_A, M_B));
    ASSERT_NEAR(4, depth[0], TOL(1e-15, 1e-6));
    ASSERT_NEAR(4, depth[1], TOL(1e-15, 1e-6));
    ASSERT_NEAR(0.25, miss, TOL(1e-15, 1e-6));
}

static void test_depth_counts_in_lengths_of_the_ray(void)
{
    /* With unit rays the depth is the hypotenuse, 5. With a ray ten times as long it is a
     * tenth of that. */
    const rigcal_real unit_a[3] = {RC(0.6), 0, RC(0.8)};
    const rigcal_real long_b[3] = {RC(-7.5), 0, 10};
    rigcal_real depth[2], miss;

    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_depth_two_views(depth, &miss, &B_FROM_A, unit_a, long_b));
    ASSERT_NEAR(5, depth[0], TOL(1e-14, 2e-6));
    ASSERT_NEAR(0.4, depth[1], TOL(1e-15, 1e-6));
    ASSERT_NEAR(0.25, miss, TOL(1e-15, 1e-6));
}

/* The error of a depth grows as 1 / sine of the angle between the rays. */
static void test_depths_of_two_views_are_the_oracles(void)
{
    for (int i = 0; i < TWO_VIEWS_ROWS; i++) {
        const double *v = TWO_VIEWS[i];
        const rigcal_transform b_from_a = test_from_ypr(v, v + 3);
        const double tol = TOL(1e-13, 1e-5) / v[16];
        rigcal_real ray_a[3] = {RC(v[6]), RC(v[7]), 1};
        rigcal_real ray_b[3] = {RC(v[8]), RC(v[9]), 1};
        rigcal_real depth[2], miss;

        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_depth_two_views(depth, &miss, &b_from_a, ray_a, ray_b));
        ASSERT_ARRAY_NEAR(v + 10, depth, 2, tol * v[10]);
        ASSERT_NEAR(v[12], miss, tol);
    }
}

static void test_depths_of_perfect_views_are_true_from_either_side(void)
{
    test_rng rng = test_seed(51);

    for (int trial = 0; trial < 200; trial++) {
        const rigcal_transform b_from_a = test_beside(&rng);
        double X_a[3], X_b[3];
        rigcal_transform a_from_b;
        rigcal_real ray_a[3], ray_b[3], depth[2], miss;

        test_point_ahead(X_a, &rng);
        test_move_point(X_b, &b_from_a, X_a);
        test_ray_to(ray_a, X_a);
        test_ray_to(ray_b, X_b);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_depth_two_views(depth, &miss, &b_from_a, ray_a, ray_b));
        ASSERT_NEAR(X_a[2], depth[0], TOL(1e-13, 5e-5));
        ASSERT_NEAR(X_b[2], depth[1], TOL(1e-13, 5e-5));
        ASSERT_NEAR(0, miss, TOL(5e-14, 2e-5));
        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_invert(&a_from_b, &b_from_a));
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_depth_two_views(depth, &miss, &a_from_b, ray_b, ray_a));
        ASSERT_NEAR(X_b[2], depth[0], TOL(1e-13, 5e-5));
        ASSERT_NEAR(X_a[2], depth[1], TOL(1e-13, 5e-5));
    }
}

/* The border is at 0.1 degrees. */
static void test_nearly_parallel_rays_are_refused(void)
{
    static const double degrees[5] = {0, 0.05, 0.0995, 0.1005, 1};
    static const rigcal_transform aside = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {-1, 0, 0}};

    for (int i = 0; i < 5; i++) {
        const rigcal_real ahead[3] = {0, 0, 2};
        const rigcal_real turned[3] = {RC(-tan(degrees[i] * TEST_PI / 180)), 0, 1};
        const rigcal_real away[3] = {-turned[0], 0, -1};
        rigcal_real depth[2], miss;

        if (degrees[i] > 0.1) {
            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_depth_two_views(depth, &miss, &aside, ahead, turned));
            ASSERT_NEAR(1 / tan(degrees[i] * TEST_PI / 180), D(depth[1]), TOL(1e-9, 0.1));
            continue;
        }
        FILL(miss);
        ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, depth,
                       rigcal_depth_two_views(depth, &miss, &aside, ahead, turned));
        ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, depth,
                       rigcal_depth_two_views(depth, &miss, &aside, ahead, away));
        ASSERT_UNTOUCHED(miss);
    }
}

static void test_rays_that_meet_behind_either_camera_are_refused(void)
{
    const rigcal_real out_a[3] = {RC(-0.75), 0, 1}, out_b[3] = {RC(0.75), 0, 1};
    const rigcal_real back_a[3] = {RC(-0.75), 0, -1};
    const rigcal_real back_b[3] = {RC(0.75), 0, -1};
    rigcal_real depth[2], miss;

    FILL(miss);
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, depth,
                   rigcal_depth_two_views(depth, &miss, &B_FROM_A, out_a, out_b));
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, depth,
                   rigcal_depth_two_views(depth, &miss, &B_FROM_A, M_A, back_b));
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, depth,
                   rigcal_depth_two_views(depth, &miss, &B_FROM_A, back_a, M_B));
    /* Both cameras have one centre: the rays meet there, and nothing can be measured. */
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, depth,
                   rigcal_depth_two_views(depth, &miss, &NOTHING, M_A, M_B));
    ASSERT_UNTOUCHED(miss);
}

/* The rays meet in the centre of a, or of b: a depth of 0 is none. */
static void test_a_point_in_the_centre_of_a_camera_is_refused(void)
{
    static const rigcal_real right[3] = {1, 0, 0}, ahead[3] = {0, 0, 1};
    rigcal_transform T = NOTHING;
    rigcal_real depth[2], miss;

    T.t[2] = 2;
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, depth,
                   rigcal_depth_two_views(depth, &miss, &T, right, ahead));
    T.t[2] = 0;
    T.t[0] = -2;
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, depth,
                   rigcal_depth_two_views(depth, &miss, &T, right, ahead));
}

static void test_arguments_of_two_views_are_checked(void)
{
    const rigcal_real none[3] = {0, 0, 0};
    rigcal_real depth[2], miss;

    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_depth_two_views(NULL, &miss, &B_FROM_A, M_A, M_B));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, depth,
                   rigcal_depth_two_views(depth, NULL, &B_FROM_A, M_A, M_B));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, depth,
                   rigcal_depth_two_views(depth, &miss, NULL, M_A, M_B));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, depth,
                   rigcal_depth_two_views(depth, &miss, &B_FROM_A, NULL, M_B));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, depth,
                   rigcal_depth_two_views(depth, &miss, &B_FROM_A, M_A, NULL));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, depth,
                   rigcal_depth_two_views(depth, &miss, &B_FROM_A, none, M_B));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, depth,
                   rigcal_depth_two_views(depth, &miss, &B_FROM_A, M_A, none));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, depth, /* before any number is looked at */
                   rigcal_depth_two_views(depth, &miss, &B_FROM_A, NULL, none));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, depth,
                   rigcal_depth_two_views(depth, &miss, &B_FROM_A, none, NULL));
    for (int k = 0; k < 3; k++) {
        rigcal_transform T = B_FROM_A;
        rigcal_real bad[3] = {0, 0, 1};

        bad[k] = k == 1 ? TEST_INF : TEST_NAN;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, depth,
                       rigcal_depth_two_views(depth, &miss, &B_FROM_A, bad, M_B));
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, depth,
                       rigcal_depth_two_views(depth, &miss, &B_FROM_A, M_A, bad));
        T.t[k] = TEST_NAN;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, depth,
                       rigcal_depth_two_views(depth, &miss, &T, M_A, M_B));
        T = B_FROM_A;
        T.R[4 * k] = -1;
        ASSERT_REFUSED(RIGCAL_ERR_ROTATION, depth,
                       rigcal_depth_two_views(depth, &miss, &T, M_A, M_B));
    }
}

/* ---- aligned stereo (19), (20) ------------------------------------------- */

static void test_disparity_gives_depth_on_paper(void)
{
    static const double expected[3] = {3, 2, 4};
    const rigcal_real left[2] = {RC(0.75), RC(0.5)};
    const rigcal_real right[2] = {RC(-0.75), RC(0.5)};
    rigcal_real X[3];

    ASSERT_STATUS(RIGCAL_OK, rigcal_depth_aligned(X, 6, left, right));
    ASSERT_ARRAY_NEAR(expected, X, 3, TOL(1e-15, 1e-6));
}

static void test_aligned_stereo_agrees_with_two_general_views(void)
{
    test_rng rng = test_seed(52);

    for (int trial = 0; trial < 50; trial++) {
        const rigcal_transform right = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {RC(-0.4), 0, 0}};
        double X[3], X_r[3];
        rigcal_real left_ray[3], right_ray[3], depth[2], miss, seen[3];

        test_point_ahead(X, &rng);
        test_move_point(X_r, &right, X);
        test_ray_to(left_ray, X);
        test_ray_to(right_ray, X_r);
        ASSERT_STATUS(RIGCAL_OK, rigcal_depth_aligned(seen, RC(0.4), left_ray, right_ray));
        ASSERT_ARRAY_NEAR(X, seen, 3, TOL(1e-13, 1e-4));
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_depth_two_views(depth, &miss, &right, left_ray, right_ray));
        ASSERT_NEAR(depth[0], seen[2], TOL(1e-13, 1e-4));
    }
}

static void test_no_or_negative_disparity_is_refused(void)
{
    const rigcal_real left[2] = {RC(0.1), 0}, right[2] = {RC(0.2), 0};
    rigcal_real X[3];

    ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, X, rigcal_depth_aligned(X, 1, left, left));
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, X, rigcal_depth_aligned(X, 1, left, right));
}

/* The baseline is as long as a coordinate may be. The depth is half of that. */
static void test_the_longest_baseline_is_accepted(void)
{
    const rigcal_real left[2] = {2, 0}, right[2] = {0, 0};
    rigcal_real X[3];

    ASSERT_STATUS(RIGCAL_OK, rigcal_depth_aligned(X, RC_COORDINATE_MAX, left, right));
    ASSERT_NEAR(0.5, D(X[2]) / D(RC_COORDINATE_MAX), TOL(1e-9, 1e-4));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, X,
                   rigcal_depth_aligned(X, 2 * RC_COORDINATE_MAX, left, right));
}

/* A disparity of at most 4 roundings of the coordinates is none, nor one that puts the
 * point beyond the range of coordinates. */
static void test_a_disparity_of_rounding_is_refused(void)
{
    const rigcal_real left[2] = {1, 0}, zero[2] = {0, 0}, half[2] = {RC(0.5), 0};
    const rigcal_real low[2] = {1 - 4 * RC_EPS, 0}, lower[2] = {1 - 5 * RC_EPS, 0};
    rigcal_real X[3];

    ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, X, rigcal_depth_aligned(X, 1, left, low));
    ASSERT_STATUS(RIGCAL_OK, rigcal_depth_aligned(X, 1, left, lower));
    ASSERT_NEAR(1, 5 * D(RC_EPS) * D(X[2]), TOL(1e-12, 1e-6));
    ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, X,
                   rigcal_depth_aligned(X, RC_COORDINATE_MAX, half, zero));
    ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, X,
                   rigcal_depth_aligned(X, RC_COORDINATE_MAX, left, zero));
}

/* It grows with the coordinates. */
static void test_what_a_disparity_must_be_goes_with_the_coordinates(void)
{
    for (double size = 0.25; size < 5000; size *= 8) {
        const rigcal_real left[2] = {RC(size), 0};
        const rigcal_real low[2] = {RC(size * (1 - 4 * D(RC_EPS))), 0};
        const rigcal_real lower[2] = {RC(size * (1 - 5 * D(RC_EPS))), 0};
        rigcal_real X[3];

        ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, X,
                       rigcal_depth_aligned(X, RC(0.001), left, low));
        ASSERT_STATUS(RIGCAL_OK, rigcal_depth_aligned(X, RC(0.001), left, lower));
        ASSERT_NEAR(0.001, 5 * size * D(RC_EPS) * D(X[2]), TOL(1e-15, 1e-9));
    }
}

/* A disparity of 5 roundings at x = 1 and at x = -1, of points far above and below. */
static void test_the_height_of_a_point_has_no_part_in_its_disparity(void)
{
    for (int way = 0; way < 4; way++) {
        const rigcal_real y = RC(way % 2 ? 1000 : -1000), e = 5 * RC_EPS;
        const rigcal_real left[2] = {RC(way < 2 ? 1 : -1 + D(e)), y};
        const rigcal_real right[2] = {RC(way < 2 ? 1 - D(e) : -1), y};
        rigcal_real X[3];

        ASSERT_STATUS(RIGCAL_OK, rigcal_depth_aligned(X, 1, left, right));
        ASSERT_NEAR(1, D(e) * D(X[2]), TOL(1e-12, 1e-6));
        ASSERT_NEAR(D(y), D(e) * D(X[1]), TOL(1e-9, 1e-3));
    }
}

static void test_arguments_of_aligned_stereo_are_checked(void)
{
    const rigcal_real left[2] = {RC(0.2), 0}, right[2] = {RC(0.1), 0};
    rigcal_real X[3];

    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_depth_aligned(NULL, 1, left, right));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, X, rigcal_depth_aligned(X, 1, NULL, right));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, X, rigcal_depth_aligned(X, 1, left, NULL));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, X, rigcal_depth_aligned(X, 0, left, right));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, X, rigcal_depth_aligned(X, -1, left, right));
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, X,
                   rigcal_depth_aligned(X, TEST_NAN, left, right));
    for (int k = 0; k < 2; k++) {
        rigcal_real bad[2] = {0, 0};

        bad[k] = TEST_INF;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, X, rigcal_depth_aligned(X, 1, bad, right));
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, X, rigcal_depth_aligned(X, 1, left, bad));
    }
}

/* ---- triangulation ------------------------------------------------------- */

enum { VIEWS = 6 };

typedef struct {
    rigcal_camera cameras[VIEWS];
    rigcal_transform poses[VIEWS];
    rigcal_real uv[2 * VIEWS];
    double X[3];
} views;

/* Cameras with all lenses on an arc about a point, which they see exactly. */
static void exact_views(views *v, test_rng *rng, int n)
{
    for (int k = 0; k < 3; k++) {
        v->X[k] = test_uniform(rng, -1, 1);
    }
    for (int i = 0; i < n; i++) {
        const double ypr[3] = {test_uniform(rng, -3, 3), 0.5 * i - 0.25 * (n - 1),
                               test_uniform(rng, -0.2, 0.2)};
        double R[9], t[3], X_c[3], uv[2];

        v->cameras[i] = test_camera(CAMERA[(int)(test_next(rng) % CAMERA_ROWS)]);
        test_rotation(R, ypr[0], ypr[1], ypr[2]);
        test_apply(X_c, R, v->X, NULL);
        t[0] = test_uniform(rng, -0.8, 0.8) - X_c[0];
        t[1] = test_uniform(rng, -0.8, 0.8) - X_c[1];
        t[2] = test_uniform(rng, 3, 6) - X_c[2];
        v->poses[i] = test_transform(R, t);
        test_move_point(X_c, &v->poses[i], v->X);
        test_project_px(uv, &v->cameras[i], X_c);
        test_to_real(v->uv + 2 * i, uv, 2);
    }
}

static rigcal_status triangulate(rigcal_point *point, const views *v, int n, double sigma)
{
    return rigcal_point_triangulate(point, v->cameras, v->poses, v->uv, (size_t)n,
                                    RC(sigma));
}

static void test_a_point_of_perfect_views_is_where_it_is(void)
{
    test_rng rng = test_seed(53);

    for (int trial = 0; trial < 150; trial++) {
        const int n = 2 + trial % (VIEWS - 1);
        rigcal_point point;
        views v;

        exact_views(&v, &rng, n);
        ASSERT_STATUS(RIGCAL_OK, triangulate(&point, &v, n, 1));
        ASSERT_ARRAY_NEAR(v.X, point.X, 3, TOL(1e-12, 1e-4));
        ASSERT_NEAR(0, point.rms_px, TOL(1e-9, 1e-2));
    }
}

static void golden_views(views *v, const double *row)
{
    for (int i = 0; i < (int)row[0]; i++) {
        const double *view = row + 1 + 9 * i;

        v->cameras[i] = test_camera(CAMERA[(int)view[0]]);
        v->poses[i] = test_from_ypr(view + 1, view + 4);
        test_to_real(v->uv + 2 * i, view + 7, 2);
    }
}

static void test_points_of_noisy_views_are_scipys_least_squares(void)
{
    for (int k = 0; k < TRIANGULATION_ROWS; k++) {
        const double *row = TRIANGULATION[k], *golden = row + 46;
        double largest = 0;
        rigcal_point point;
        views v;

        golden_views(&v, row);
        ASSERT_STATUS(RIGCAL_OK, triangulate(&point, &v, (int)row[0], 1));
        for (int i = 0; i < 9; i++) {
            largest = fmax(largest, fabs(golden[4 + i]));
        }
        /* The search ends when only a small part of the sum can still be gained: 1e-12, in
         * float 1e-6. That is the square of the remaining step, in standard deviations for
         * the noise of the sum. In float a pixel is also only accurate to 1e-4. */
        ASSERT_ARRAY_NEAR(golden, point.X, 3,
                          TOL(1e-6, 2e-3) * sqrt(largest) * fmax(1, golden[3]));
        ASSERT_NEAR(golden[3], point.rms_px, TOL(1e-9, 2e-3));
        /* The last step is not evaluated. The covariance belongs to the start of that step,
         * up to a thousandth of a standard deviation away. */
        ASSERT_ARRAY_NEAR(golden + 4, point.Sigma, 9, TOL(1e-4, 1e-3) * largest);
    }
}

static void test_the_covariance_goes_with_the_square_of_the_noise(void)
{
    test_rng rng = test_seed(54);
    double once[9];
    rigcal_point point;
    views v;

    exact_views(&v, &rng, 3);
    ASSERT_STATUS(RIGCAL_OK, triangulate(&point, &v, 3, 1));
    for (int i = 0; i < 9; i++) {
        once[i] = 0.0625 * D(point.Sigma[i]);
        ASSERT_NEAR(point.Sigma[i], point.Sigma[i % 3 * 3 + i / 3],
                    TOL(1e-14, 1e-6) * D(point.Sigma[0] + point.Sigma[8]));
    }
    ASSERT_STATUS(RIGCAL_OK, triangulate(&point, &v, 3, 0.25));
    ASSERT_ARRAY_NEAR(once, point.Sigma, 9, TOL(1e-14, 1e-6) * once[0]);
}

/* 400 draws give a variance to 7 % (one standard deviation). The trace sums three. */
static void test_the_covariance_is_the_scatter_of_noisy_measurements(void)
{
    enum { DRAWS = 400 };
    const double sigma = 0.5;
    test_rng rng = test_seed(55);
    double scatter[9] = {0}, trace = 0;
    rigcal_point exact, noisy;
    views v;

    exact_views(&v, &rng, 3);
    ASSERT_STATUS(RIGCAL_OK, triangulate(&exact, &v, 3, sigma));
    for (int draw = 0; draw < DRAWS; draw++) {
        views shaken = v;

        for (int i = 0; i < 6; i++) {
            shaken.uv[i] += RC(sigma * test_normal(&rng));
        }
        ASSERT_STATUS(RIGCAL_OK, triangulate(&noisy, &shaken, 3, sigma));
        for (int i = 0; i < 9; i++) {
            scatter[i] +=
                (D(noisy.X[i / 3]) - v.X[i / 3]) * (D(noisy.X[i % 3]) - v.X[i % 3]) / DRAWS;
        }
    }
    for (int i = 0; i < 3; i++) {
        trace += D(exact.Sigma[4 * i]);
        ASSERT_NEAR(1, scatter[4 * i] / D(exact.Sigma[4 * i]), 0.25);
    }
    for (int i = 0; i < 9; i++) {
        ASSERT_NEAR(exact.Sigma[i], scatter[i], 0.15 * trace);
    }
}

/* A fisheye sees it 100 degrees off its axis: behind its image plane and not
 * behind the camera. */
static void test_a_point_beside_a_fisheye_is_measured(void)
{
    static const double X[3] = {4, 0.3, -0.7};
    test_rng rng = test_seed(56);
    double X_c[3], uv[2];
    rigcal_point point;
    views v;

    exact_views(&v, &rng, 2);
    for (int i = 0; i < 2; i++) {
        const double t[3] = {0, i ? -1.5 : 0, i ? 0.2 : 0};

        v.cameras[i] = test_camera(CAMERA[4]);
        v.poses[i] = test_transform(NULL, t);
        test_move_point(X_c, &v.poses[i], X);
        TEST_ASSERT_TRUE(X_c[2] < 0);
        test_project_px(uv, &v.cameras[i], X_c);
        test_to_real(v.uv + 2 * i, uv, 2);
    }
    ASSERT_STATUS(RIGCAL_OK, triangulate(&point, &v, 2, 1));
    ASSERT_ARRAY_NEAR(X, point.X, 3, TOL(1e-11, 1e-3));
}

/* Matches that are hundreds of pixels wrong. Steps overshoot and have to be shortened. The
 * result must still have the least sum of squares among its neighbours. */
static void test_wrong_matches_still_give_the_least_squares(void)
{
    const double aside = 1e-3;
    test_rng rng = test_seed(59);
    int measured = 0;

    for (int trial = 0; trial < 400; trial++) {
        double least = 0;
        rigcal_point point;
        views v;

        exact_views(&v, &rng, 3);
        for (int i = 0; i < 3; i++) {
            v.cameras[i] = test_pinhole();
        }
        for (int i = 0; i < 6; i++) {
            v.uv[i] = RC((i % 2 ? 240 : 320) + 300 * test_normal(&rng));
        }
        if (triangulate(&point, &v, 3, 1) != RIGCAL_OK) {
            continue; /* rays that meet behind a camera */
        }
        measured++;
        for (int way = -1; way < 6; way++) {
            double sum = 0, X[3];

            test_to_double(X, point.X, 3);
            if (way >= 0) {
                X[way / 2] += way % 2 ? aside : -aside;
            }
            for (int i = 0; i < 3; i++) {
                double X_c[3], uv[2];

                test_move_point(X_c, &v.poses[i], X);
                test_project_px(uv, &v.cameras[i], X_c);
                sum += pow(uv[0] - D(v.uv[2 * i]), 2) + pow(uv[1] - D(v.uv[2 * i + 1]), 2);
            }
            if (way < 0) {
                least = sum;
                /* The last step is not evaluated: its sum is that of the quadratic
                 * model. */
                ASSERT_NEAR(sqrt(sum / 3), point.rms_px,
                            TOL(1e-9, 1e-2) + TOL(1e-9, 1e-5) * sqrt(sum));
            } else {
                TEST_ASSERT_TRUE(sum > least * (1 - TOL(1e-5, 1e-3)));
            }
        }
    }
    TEST_ASSERT_TRUE(measured > 50);
}

static void test_a_point_that_views_do_not_fix_is_refused(void)
{
    test_rng rng = test_seed(57);
    rigcal_point point;
    views v, other;

    exact_views(&v, &rng, 2);
    other = v;
    for (int i = 0; i < 2; i++) { /* all cameras at one place */
        other.cameras[i] = v.cameras[0];
        other.poses[i] = v.poses[0];
        memcpy(other.uv + 2 * i, v.uv, 2 * sizeof v.uv[0]);
    }
    ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, point, triangulate(&point, &other, 2, 1));

    other = v;
    for (int i = 0; i < 2; i++) { /* side by side, and the rays do not meet */
        const double t[3] = {i ? -1 : 0, 0, 0};

        other.cameras[i] = test_pinhole();
        other.poses[i] = test_transform(NULL, t);
        other.uv[2 * i] = RC(i ? 500 : 100);
        other.uv[2 * i + 1] = 200;
    }
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, point, triangulate(&point, &other, 2, 1));
    other.uv[2] = other.uv[0]; /* exactly parallel */
    ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, point, triangulate(&point, &other, 2, 1));
}

static void test_arguments_of_the_triangulation_are_checked(void)
{
    test_rng rng = test_seed(58);
    rigcal_point point;
    views good, v;

    exact_views(&good, &rng, 3);
    ASSERT_STATUS(RIGCAL_ERR_NULL, triangulate(NULL, &good, 3, 1));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, point,
                   rigcal_point_triangulate(&point, NULL, good.poses, good.uv, 3, 1));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, point,
                   rigcal_point_triangulate(&point, good.cameras, NULL, good.uv, 3, 1));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, point,
                   rigcal_point_triangulate(&point, good.cameras, good.poses, NULL, 3, 1));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, point, /* before any number is looked at */
                   rigcal_point_triangulate(&point, NULL, good.poses, good.uv, 0, -1));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, point,
                   rigcal_point_triangulate(&point, good.cameras, NULL, good.uv, 0, -1));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, point,
                   rigcal_point_triangulate(&point, good.cameras, good.poses, NULL, 0, -1));
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, point, triangulate(&point, &good, 1, 1));
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, point, triangulate(&point, &good, 0, 1));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, point, triangulate(&point, &good, 3, 0));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, point, triangulate(&point, &good, 3, -1));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, point,
                   rigcal_point_triangulate(&point, good.cameras, good.poses, good.uv,
                                            ((size_t)1 << 28) + 1, 1));
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, point, triangulate(&point, &good, 3, test_nan()));
    for (int i = 0; i < 3; i++) {
        v = good;
        v.cameras[i].fx = 0;
        ASSERT_REFUSED(RIGCAL_ERR_CAMERA, point, triangulate(&point, &v, 3, 1));
        v = good;
        v.cameras[i].cy = TEST_NAN;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, point, triangulate(&point, &v, 3, 1));
        v = good;
        v.poses[i].R[4] += RC(0.5);
        ASSERT_REFUSED(RIGCAL_ERR_ROTATION, point, triangulate(&point, &v, 3, 1));
        v = good;
        v.poses[i].t[1] = TEST_INF;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, point, triangulate(&point, &v, 3, 1));
        v = good;
        v.uv[2 * i + 1] = TEST_NAN;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, point, triangulate(&point, &v, 3, 1));
        v.uv[2 * i + 1] = RC(2e9);
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, point, triangulate(&point, &v, 3, 1));
        v = good; /* barrel distortion ends 490 pixels from the middle */
        v.cameras[i] = test_pinhole();
        v.cameras[i].k1 = RC(-0.4);
        v.uv[2 * i] = 5000;
        ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, point, triangulate(&point, &v, 3, 1));
    }
}

/* ---- Section VI-C -------------------------------------------------------- */

static void test_the_bound_is_the_oracles_with_the_spectral_norm(void)
{
    for (int i = 0; i < TRANSFORM_BOUND_ROWS; i++) {
        const double *v = TRANSFORM_BOUND[i];
        const rigcal_transform used = test_from_ypr(v, v + 3);
        const rigcal_transform truth = test_from_ypr(v + 6, v + 9);
        rigcal_real X[3], bound;

        test_to_real(X, v + 12, 3);
        ASSERT_STATUS(RIGCAL_OK, rigcal_point_bound(&bound, &used, &truth, X));
        ASSERT_NEAR(v[15], bound, TOL(1e-13, 2e-5));
    }
}

static void test_no_point_is_farther_off_than_the_bound(void)
{
    test_rng rng = test_seed(88);

    for (int i = 0; i < 200; i++) {
        const rigcal_transform used = test_random_transform(&rng);
        const rigcal_transform truth = test_random_transform(&rng);
        double R[9], t[3], X[3], Y[3], Y_true[3], off[3];
        rigcal_real X_a[3], bound;

        for (int k = 0; k < 3; k++) {
            X[k] = test_uniform(&rng, -5, 5);
        }
        test_transform_parts(R, t, &used);
        test_apply(Y, R, X, t);
        test_transform_parts(R, t, &truth);
        test_apply(Y_true, R, X, t);
        for (int k = 0; k < 3; k++) {
            off[k] = Y[k] - Y_true[k];
        }
        test_to_real(X_a, X, 3);
        ASSERT_STATUS(RIGCAL_OK, rigcal_point_bound(&bound, &used, &truth, X_a));
        TEST_ASSERT_TRUE(test_norm(off) <= D(bound) * (1 + TOL(1e-14, 1e-6)));
    }
}

/* A point across the axis of the rotation error, with the shift in the direction in which
 * it moves: 60 degrees move it by its own distance, 10, and the shift adds 3. */
static void test_the_bound_is_reached_on_paper(void)
{
    static const double axis[3] = {0, 0, 1};
    const rigcal_transform truth = NOTHING;
    const rigcal_real X[3] = {10, 0, 0};
    rigcal_transform used = test_turned_about(axis, TEST_PI / 3);
    rigcal_real bound;

    used.t[0] = RC(-1.5);
    used.t[1] = RC(3 * sqrt(0.75));
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_bound(&bound, &used, &truth, X));
    ASSERT_NEAR(13, bound, TOL(1e-14, 5e-6));
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_bound(&bound, &used, &used, X));
    ASSERT_NEAR(0, bound, TOL(1e-14, 1e-5));
}

static void test_arguments_of_the_bound_are_checked(void)
{
    const rigcal_real X[3] = {1, 2, 3};
    rigcal_real bound;

    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_point_bound(NULL, &NOTHING, &NOTHING, X));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, bound, rigcal_point_bound(&bound, NULL, &NOTHING, X));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, bound, rigcal_point_bound(&bound, &NOTHING, NULL, X));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, bound,
                   rigcal_point_bound(&bound, &NOTHING, &NOTHING, NULL));
    for (int k = 0; k < 3; k++) {
        rigcal_transform bad = NOTHING;
        rigcal_real odd[3] = {1, 2, 3};

        odd[k] = TEST_NAN;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, bound,
                       rigcal_point_bound(&bound, &NOTHING, &NOTHING, odd));
        odd[k] = RC(TOL(2e30, 2e9));
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, bound,
                       rigcal_point_bound(&bound, &NOTHING, &NOTHING, odd));
        bad.t[k] = TEST_INF;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, bound,
                       rigcal_point_bound(&bound, &bad, &NOTHING, X));
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, bound,
                       rigcal_point_bound(&bound, &NOTHING, &bad, X));
        bad = NOTHING;
        bad.R[4 * k] = -1;
        ASSERT_REFUSED(RIGCAL_ERR_ROTATION, bound,
                       rigcal_point_bound(&bound, &bad, &NOTHING, X));
        ASSERT_REFUSED(RIGCAL_ERR_ROTATION, bound,
                       rigcal_point_bound(&bound, &NOTHING, &bad, X));
    }
}

/* ---- views that contradict each other ---------------------------------------- */

/* What an answer is worth: the views see it, and no place nearby is better. */
static void assert_best(const test_views *v, const rigcal_point *point)
{
    double X[3];

    test_to_double(X, point->X, 3);
    const double least = test_views_sum(v, X), step = 1e-3 * (1 + test_norm(X));
    for (int way = 0; way < 6; way++) {
        double aside[3] = {X[0], X[1], X[2]};

        aside[way / 2] += way % 2 ? step : -step;
        TEST_ASSERT_TRUE(test_views_sum(v, aside) > least * (1 - TOL(1e-5, 1e-3)));
    }
}

/* Whether the point nearest to all rays is in front of all cameras: X of
 * sum (I - d d^T) (X - o) = 0, for rays from o along the unit vector d, by Cramer. */
static int is_nearest_in_front(const test_views *v)
{
    double A[9] = {0}, b[3] = {0}, X[3], X_c[3];

    for (int i = 0; i < v->n; i++) {
        const double ray[3] = {
            (D(v->uv[2 * i]) - D(v->cameras[i].cx)) / D(v->cameras[i].fx),
            (D(v->uv[2 * i + 1]) - D(v->cameras[i].cy)) / D(v->cameras[i].fy), 1};
        double R[9], Rt[9], t[3], d[3], o[3];

        test_transform_parts(R, t, &v->cams_from_world[i]);
        test_transpose(Rt, R);
        test_apply(d, Rt, ray, NULL);
        test_apply(o, Rt, t, NULL); /* the centre is -o */
        for (int k = 0; k < 9; k++) {
            const double a = (k % 4 == 0) - d[k / 3] * d[k % 3] / test_dot(d, d);

            A[k] += a;
            b[k / 3] -= a * o[k % 3];
        }
    }
    for (int k = 0; k < 3; k++) {
        double replaced[9];

        memcpy(replaced, A, sizeof A);
        for (int row = 0; row < 3; row++) {
            replaced[3 * row + k] = b[row];
        }
        X[k] = test_determinant(replaced) / test_determinant(A);
    }
    for (int i = 0; i < v->n; i++) {
        test_move_point(X_c, &v->cams_from_world[i], X);
        if (!(X_c[2] > TOL(1e-9, 1e-3))) {
            return 0;
        }
    }
    return 1;
}

/* The rays are far from meeting. So a search takes long, or goes away to infinity. It
 * begins at the point nearest to the rays, and does not go behind a camera from there. */
static void test_no_point_near_one_of_wild_views_is_better(void)
{
    test_rng rng = test_seed(57);
    int counts[3] = {0, 0, 0};

    for (int trial = 0; trial < TEST_TRIALS(20000); trial++) {
        rigcal_point point;
        test_views v;

        test_wild_views(&v, &rng);
        const rigcal_status status = rigcal_point_triangulate(
            &point, v.cameras, v.cams_from_world, v.uv, (size_t)v.n, 1);
        if (status == RIGCAL_OK) {
            counts[0]++;
            assert_best(&v, &point);
        } else if (status == RIGCAL_BUDGET_SPENT) {
            double X[3];

            counts[1]++;
            test_to_double(X, point.X, 3);
            TEST_ASSERT_TRUE(test_views_sum(&v, X) < test_infinity()); /* seen by all */
            ASSERT_NEAR(1, D(point.rms_px) / sqrt(test_views_sum(&v, X) / v.n),
                        TOL(1e-6, 1e-2)); /* the point is the one whose errors are told */
        } else {
            counts[2] += status == RIGCAL_ERR_PARALLEL;
            TEST_ASSERT_TRUE(status == RIGCAL_ERR_PARALLEL ||
                             (status == RIGCAL_ERR_BEHIND && !is_nearest_in_front(&v)));
        }
    }
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || counts[i] > 20);
    }
}

/* The point is so near to the plane of a camera that its pixel, or the pixel's derivative,
 * overflows. */
static void test_a_point_that_grazes_a_camera_is_refused(void)
{
    rigcal_point point;
    test_views v;

    test_grazing_views(&v, 0);
    ASSERT_REFUSED(
        RIGCAL_ERR_PARALLEL, point,
        rigcal_point_triangulate(&point, v.cameras, v.cams_from_world, v.uv, 3, 1));
    test_grazing_views(&v, 1);
    ASSERT_REFUSED(
        RIGCAL_ERR_NO_RAY, point,
        rigcal_point_triangulate(&point, v.cameras, v.cams_from_world, v.uv, 3, 1));
}

TEST_MAIN()
{
    RUN_TEST(test_skew_rays_give_both_depths_and_their_miss);
    RUN_TEST(test_depth_counts_in_lengths_of_the_ray);
    RUN_TEST(test_depths_of_two_views_are_the_oracles);
    RUN_TEST(test_depths_of_perfect_views_are_true_from_either_side);
    RUN_TEST(test_nearly_parallel_rays_are_refused);
    RUN_TEST(test_rays_that_meet_behind_either_camera_are_refused);
    RUN_TEST(test_a_point_in_the_centre_of_a_camera_is_refused);
    RUN_TEST(test_arguments_of_two_views_are_checked);
    RUN_TEST(test_disparity_gives_depth_on_paper);
    RUN_TEST(test_aligned_stereo_agrees_with_two_general_views);
    RUN_TEST(test_no_or_negative_disparity_is_refused);
    RUN_TEST(test_the_longest_baseline_is_accepted);
    RUN_TEST(test_a_disparity_of_rounding_is_refused);
    RUN_TEST(test_what_a_disparity_must_be_goes_with_the_coordinates);
    RUN_TEST(test_the_height_of_a_point_has_no_part_in_its_disparity);
    RUN_TEST(test_arguments_of_aligned_stereo_are_checked);
    RUN_TEST(test_a_point_of_perfect_views_is_where_it_is);
    RUN_TEST(test_points_of_noisy_views_are_scipys_least_squares);
    RUN_TEST(test_the_covariance_goes_with_the_square_of_the_noise);
    RUN_TEST(test_the_covariance_is_the_scatter_of_noisy_measurements);
    RUN_TEST(test_a_point_beside_a_fisheye_is_measured);
    RUN_TEST(test_wrong_matches_still_give_the_least_squares);
    RUN_TEST(test_a_point_that_views_do_not_fix_is_refused);
    RUN_TEST(test_arguments_of_the_triangulation_are_checked);
    RUN_TEST(test_the_bound_is_the_oracles_with_the_spectral_norm);
    RUN_TEST(test_no_point_is_farther_off_than_the_bound);
    RUN_TEST(test_the_bound_is_reached_on_paper);
    RUN_TEST(test_arguments_of_the_bound_are_checked);
    RUN_TEST(test_no_point_near_one_of_wild_views_is_better);
    RUN_TEST(test_a_point_that_grazes_a_camera_is_refused);
}
