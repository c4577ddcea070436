/* tag.c - where a square tag is, seen by one camera, and how sure that is.
 * The truth: the tag is 0.2 m wide. Its middle is at (0.1, 0.05, 1) m: x to the right,
 * y down, z ahead of the camera. It is turned by 36.87 degrees (cosine 0.8, sine 0.6):
 * its left edge is at X = 0.02, Z = 0.94, its right edge at X = 0.18, Z = 1.06. A corner
 * is seen at u = 640 + 800 X / Z, v = 480 + 800 Y / Z, here rounded to 0.1 pixel. */
#include <math.h>
#include <stdio.h>
#include <rigcal.h>

int main(void)
{
    const rigcal_camera camera = {.lens = RIGCAL_LENS_BROWN,
                                  .width = 1280,
                                  .height = 960,
                                  .fx = 800,
                                  .fy = 800,
                                  .cx = 640,
                                  .cy = 480};
    /* Top left, top right, bottom right, bottom left, as the tag is read. */
    const rigcal_real uv[8] = {657.0, 437.4, 775.8, 442.3, 775.8, 593.2, 657.0, 607.7};
    const rigcal_observation corners[4] = {{{-0.1, 0.1}, {uv[0], uv[1]}},
                                           {{0.1, 0.1}, {uv[2], uv[3]}},
                                           {{0.1, -0.1}, {uv[4], uv[5]}},
                                           {{-0.1, -0.1}, {uv[6], uv[7]}}};
    const rigcal_view view = {&camera, corners, NULL, 4};
    rigcal_pose pose;
    rigcal_pose_uncertainty sigma;
    size_t n_found;

    rigcal_status status =
        rigcal_tag_solve(&pose, 1, &n_found, NULL, &camera, uv, 0.2, NULL);
    if (status == RIGCAL_OK) { /* for corners that are good to 0.2 px */
        status = rigcal_pose_covariance(&sigma, &view, &pose.cam_from_world, 0.2);
    }
    if (status != RIGCAL_OK) { /* negative: no result; positive: one with a caveat */
        printf("%s\n", rigcal_status_text(status));
        return 1;
    }
    const rigcal_real *t = pose.cam_from_world.t, *R = pose.cam_from_world.R;
    const rigcal_real *s = sigma.translation;
    printf("The tag is at (%.3f, %.3f, %.3f) m,\n", t[0], t[1], t[2]);
    printf("good to +- (%.4f, %.4f, %.4f) m.\n", s[0], s[1], s[2]);
    printf("It is turned by %.1f degrees.\n", acos(-R[8]) * 57.29578);
    return 0;
}
