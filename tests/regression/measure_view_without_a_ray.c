/* A pixel just beyond the place where a lens turns back has no ray. But noise may bring it
 * that near to the point of the other views. The view was counted among those that agree,
 * so the point was refused as ERR_NO_RAY. Now the view is left out. */
#include <math.h>
#include <string.h>

#include "rigcal_point.h"
#include "test_support.h"

enum { N = 4 };

static rigcal_mounted_camera cameras[N];
static int32_t group[N];
static rigcal_real noise[N], work[RIGCAL_POINT_WORK(N)];
static rigcal_sighting seen[N];

/* Cameras side by side see (0, 0, 4); the lens of the last one, x - 0.4 x^3, turns back at
 * 0.913, which is 486.9 px from the middle. */
static void test_a_view_without_a_ray_is_left_out(void)
{
    static const double AT[N] = {-1, 0, 1, -0.9 * 4};
    rigcal_calibrated_rig rig;
    rigcal_sightings s;
    rigcal_measured_point point;
    uint8_t used[N];

    memset(&rig, 0, sizeof rig);
    memset(&s, 0, sizeof s);
    memset(&point, 0, sizeof point);
    for (int i = 0; i < N; i++) {
        const double t[3] = {-AT[i], 0, 0};

        cameras[i].camera = test_pinhole();
        cameras[i].cam_from_rig = test_transform(NULL, t);
        seen[i].camera = i;
        seen[i].uv[0] = RC(D(cameras[i].camera.cx) - 200 * AT[i]);
        seen[i].uv[1] = cameras[i].camera.cy;
        noise[i] = RC(0.3);
    }
    cameras[N - 1].camera.k1 = RC(-0.4);
    seen[N - 1].uv[0] = RC(D(cameras[N - 1].camera.cx) + 487.1);
    rig.cameras = cameras;
    rig.group = group;
    rig.n_cameras = rig.capacity = N;
    s.rig = &rig;
    s.seen = seen;
    s.n = N;
    s.sigma_px = noise;
    s.work = work;
    s.work_capacity = RIGCAL_POINT_WORK(N);
    ASSERT_STATUS(RIGCAL_VIEWS_LEFT_OUT, rigcal_point_measure(&point, used, &s));
    TEST_ASSERT_EQUAL_INT(0, used[N - 1]);
    ASSERT_NEAR(0, point.X[0], TOL(1e-9, 1e-4));
    ASSERT_NEAR(4, point.X[2], TOL(1e-9, 1e-3));
    s.keep_all = 1;
    ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, point, rigcal_point_measure(&point, NULL, &s));
}

TEST_MAIN()
{
    RUN_TEST(test_a_view_without_a_ray_is_left_out);
}
