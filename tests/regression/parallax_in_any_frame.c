/* The least parallax of a point is 0.1 degree. But the limit depended on the frame in which
 * the cameras are given: between its axes, rays were accepted from 0.058 degree on. And in
 * rigcal_point_measure it grew with the number of views: ten cameras in one place, and one
 * beside them, were refused below 0.17 degree. */
#include <math.h>
#include <string.h>

#include "rigcal_measure.h"
#include "rigcal_point.h"
#include "test_support.h"

enum { N = 11, MANY = TEST_ONE_IN > 1 ? N : 100 };

static rigcal_mounted_camera mounted[MANY];
static rigcal_camera cameras[MANY];
static rigcal_transform poses[MANY];
static rigcal_sighting seen[MANY];
static int32_t group[MANY];
static rigcal_real uv[2 * MANY], noise[MANY], work[RIGCAL_POINT_WORK(MANY)];

/* The last camera is beside the others, which are in one place. The point is straight ahead
 * of these. */
static void place(const double R[9], int n, double degrees)
{
    for (int i = 0; i < n; i++) {
        const int is_last = i == n - 1;
        const double t[3] = {is_last ? -1 : 0, 0, 0};

        cameras[i] = test_pinhole();
        poses[i] = test_transform(R, t);
        uv[2 * i] = cameras[i].cx;
        uv[2 * i + 1] = cameras[i].cy;
        if (is_last) {
            uv[2 * i] =
                RC(D(cameras[i].cx) - D(cameras[i].fx) * tan(degrees * TEST_PI / 180));
        }
        mounted[i].camera = cameras[i];
        mounted[i].cam_from_rig = poses[i];
        seen[i].camera = i;
        seen[i].uv[0] = uv[2 * i];
        seen[i].uv[1] = uv[2 * i + 1];
        noise[i] = 1;
    }
}

/* As many cameras in the one place as in the other. */
static void place_halves(const double R[9], int n, double degrees)
{
    place(R, n, degrees);
    for (int i = n / 2; i < n - 1; i++) {
        poses[i] = poses[n - 1];
        uv[2 * i] = uv[2 * (n - 1)];
    }
}

static rigcal_status triangulate(int n)
{
    rigcal_point point;

    return rigcal_point_triangulate(&point, cameras, poses, uv, (size_t)n, 1);
}

static rigcal_status measure(int n)
{
    rigcal_calibrated_rig rig;
    rigcal_sightings s;
    rigcal_measured_point point;

    memset(&rig, 0, sizeof rig);
    memset(&s, 0, sizeof s);
    memset(&point, 0, sizeof point);
    rig.cameras = mounted;
    rig.group = group;
    rig.n_cameras = rig.capacity = (size_t)n;
    s.rig = &rig;
    s.seen = seen;
    s.n = (size_t)n;
    s.sigma_px = noise;
    s.work = work;
    s.work_capacity = RIGCAL_POINT_WORK(MANY);
    s.keep_all = 1;
    return rigcal_point_measure(&point, NULL, &s);
}

static void random_frame(double R[9], test_rng *rng)
{
    test_rotation(R, test_uniform(rng, -3, 3), test_uniform(rng, -1.5, 1.5),
                  test_uniform(rng, -3, 3));
}

/* In float the pivots of so small an angle are only accurate to some percent. */
static void test_the_least_parallax_is_the_same_in_any_frame(void)
{
    test_rng rng = test_seed(641);

    for (int trial = 0; trial < 40; trial++) {
        double R[9];

        random_frame(R, &rng);
        place(R, 2, TOL(0.0995, 0.08));
        ASSERT_STATUS(RIGCAL_ERR_PARALLEL, triangulate(2));
        place(R, 2, TOL(0.0995, 0.099));
        ASSERT_STATUS(RIGCAL_ERR_PARALLEL, measure(2));
        place(R, 2, TOL(0.1005, 0.12));
        ASSERT_STATUS(RIGCAL_OK, triangulate(2));
        ASSERT_STATUS(RIGCAL_OK, measure(2));
    }
}

/* Only the widest angle counts. */
static void test_further_views_do_not_raise_it(void)
{
    test_rng rng = test_seed(642);

    for (int trial = 0; trial < 40; trial++) {
        double R[9];

        random_frame(R, &rng);
        for (int n = 3; n <= N; n++) {
            place(R, n, TOL(0.1005, 0.15));
            ASSERT_STATUS(RIGCAL_OK, measure(n));
            place(R, n, TOL(0.0995, 0.099));
            ASSERT_STATUS(RIGCAL_ERR_PARALLEL, measure(n));
        }
    }
}

/* In float, rounding of the sum over a hundred rays hides so small an angle in some
 * frames. */
static void test_float_may_refuse_many_rays_at_the_limit(void)
{
    test_rng rng = test_seed(644);
    int n_refused = 0;

    TEST_ON_HOST_ONLY("memory of a hundred cameras");
    for (int trial = 0; trial < 40; trial++) {
        double R[9];

        random_frame(R, &rng);
        place(R, MANY, 0.1005);
        n_refused += measure(MANY) == RIGCAL_ERR_PARALLEL;
    }
    TEST_ASSERT_TRUE(RIGCAL_USE_FLOAT ? n_refused > 0 : n_refused == 0);
}

/* Of two equal bundles of rays the limit is that of two rays. */
static void test_two_bundles_are_as_two_rays(void)
{
    test_rng rng = test_seed(643);

    for (int n = 2; n < N; n += 2) {
        double R[9];

        random_frame(R, &rng);
        place_halves(R, n, TOL(0.0995, 0.07));
        ASSERT_STATUS(RIGCAL_ERR_PARALLEL, triangulate(n));
        place_halves(R, n, TOL(0.1005, 0.14));
        ASSERT_STATUS(RIGCAL_OK, triangulate(n));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_the_least_parallax_is_the_same_in_any_frame);
    RUN_TEST(test_two_bundles_are_as_two_rays);
    RUN_TEST(test_further_views_do_not_raise_it);
    RUN_TEST(test_float_may_refuse_many_rays_at_the_limit);
}
