/* A Sigma that is not a covariance, with a small negative variance, gave a chi2 of the pair
 * below 0, and RIGCAL_OK. */
#include <string.h>

#include "test_support.h"

enum { N = 3, FREE = 2 };

static void test_a_chi2_below_0_is_no_transfer(void)
{
    static const size_t abc[N] = {1, 0, 2};
    static const double t[N][3] = {{0, 0, 0}, {1, 0, 0}, {-1, 0, 0}};
    const rigcal_real noise[2] = {RC(0.5), RC(0.125)};
    static rigcal_mounted_camera cameras[N];
    static int32_t group[N];
    static uint8_t held[N] = {1, 0, 0};
    static rigcal_real Sigma[RIGCAL_CALIBRATED_SIZE(FREE)];
    rigcal_calibrated_rig rig;
    rigcal_transfer out;
    rigcal_real uv[2][2];

    memset(&rig, 0, sizeof rig);
    rig.cameras = cameras;
    rig.group = group;
    rig.held = held;
    rig.Sigma = Sigma;
    rig.capacity = rig.n_cameras = N;
    rig.Sigma_capacity = RIGCAL_CALIBRATED_SIZE(FREE);
    rig.sigma_px = rig.F = 1;
    rig.freedom_between = rig.freedom_within = 10;
    for (int c = 0; c < N; c++) {
        cameras[c].camera = test_pinhole();
        cameras[c].camera.fx = cameras[c].camera.fy = 1024;
        cameras[c].cam_from_rig = test_transform(NULL, t[c]);
    }
    /* the point (0, 0, 4), 20 px too low in camera 1 */
    uv[0][0] = cameras[1].camera.cx + 256;
    uv[0][1] = cameras[1].camera.cy + 20;
    uv[1][0] = cameras[0].camera.cx;
    uv[1][1] = cameras[0].camera.cy;
    ASSERT_STATUS(RIGCAL_OK, rigcal_transfer_make(&out, &rig, abc, uv[0], uv[1], noise));
    ASSERT_NEAR(20 * 20 / (0.5 * 0.5 + 0.125 * 0.125), out.chi2, 20);
    /* dt_y of camera 1 moves the point by 4 parts in 68: its own variance stays above 0.
     * That of the residual, (0.5^2 + 0.125^2 + 256^2 v) px^2, does not. */
    Sigma[4 * 5 / 2 + 4] = RC(-1e-5);
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, out,
                   rigcal_transfer_make(&out, &rig, abc, uv[0], uv[1], noise));
}

TEST_MAIN()
{
    RUN_TEST(test_a_chi2_below_0_is_no_transfer);
}
