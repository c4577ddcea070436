/* tag.c - where a square tag is, seen by one camera.
 *
 * Given: the camera, the tag's size, and the pixels of the tag's four corners.
 * Asked: where the tag is in the camera's frame: x to the right, y down, z ahead.
 * Truth: its middle is at (0.1, 0.05, 1) m. It is turned by 36.87 degrees (cosine 0.8, sine
 *        0.6) about the vertical: its right edge, at X = 0.18, Z = 1.06, is farther away.
 *        A corner is seen at u = 640 + 800 X / Z, v = 480 + 800 Y / Z, here to 0.1 px. */
#include <math.h>
#include <stdio.h>
#include <rigcal.h>

int main(void)
{
    rigcal_camera camera = {.fx = 800, .fy = 800, .cx = 640, .cy = 480}; /* a pinhole */
    camera.width = 1280;
    camera.height = 960;
    /* Top left, top right, bottom right, bottom left, as the tag is read. */
    const rigcal_real uv[8] = {657.0, 437.4, 775.8, 442.3, 775.8, 593.2, 657.0, 607.7};
    const rigcal_real size = 0.2; /* its edge [m]: the answer is in metres too */
    rigcal_pose poses[RIGCAL_POSES_MAX];
    size_t n_found;

    rigcal_status status =
        rigcal_tag_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL, &camera, uv, size, NULL);
    if (status < 0) { /* there is no pose */
        printf("%s\n", rigcal_status_text(status));
        return 1;
    }
    if (status > 0) { /* poses[0] is the best one, but read what the text says */
        printf("Caution: %s\n", rigcal_status_text(status));
    }
    const rigcal_real *t = poses[0].cam_from_world.t, *R = poses[0].cam_from_world.R;
    printf("The tag is at (%.3f, %.3f, %.3f) m, ", t[0], t[1], t[2]);
    printf("turned by %.1f degrees.\n", acos(-R[8]) * 57.29578);
    printf("Its corners are %.2f px from their pixels.\n", poses[0].rms_px);
    printf("It is the right pose with probability %.2f.\n", poses[0].probability);
    return 0;
}
