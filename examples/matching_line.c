/* matching_line.c - a pixel of camera a, and where in camera b the same point can be.
 * The truth: camera b is 0.25 m to the right of camera a and 0.1 m below it. Both look
 * one way, with u = 640 + 800 X / Z, v = 480 + 800 Y / Z. Camera a sees a point at
 * (720, 520). Camera b sees it there too if it is far away, at (520, 440) if Z = 1 m, and
 * at (220, 320) if Z = 0.4 m. All these are on one line, of slope 0.4. */
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
    const rigcal_transform b_from_a = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {-0.25, -0.1, 0}};
    const rigcal_real uv_a[2] = {720, 520};
    const rigcal_real uv_b[3][2] = {{520, 439.6}, {520, 470}, {220, 320.3}};
    rigcal_real ray[3], line[3], ends[4], off;

    rigcal_status status = rigcal_camera_ray(ray, &camera, uv_a);
    if (status == RIGCAL_OK) {
        status = rigcal_epiline_px(line, &camera, &b_from_a, ray);
    }
    if (status == RIGCAL_OK) {
        status = rigcal_epiline_clip(ends, line, camera.width, camera.height);
    }
    if (status != RIGCAL_OK) {
        printf("%s\n", rigcal_status_text(status));
        return 1;
    }
    printf("The line runs from (%.1f, %.1f) to (%.1f, %.1f).\n", ends[0], ends[1], ends[2],
           ends[3]);
    for (int i = 0; i < 3; i++) {
        if (rigcal_epiline_distance(&off, line, &camera, uv_b[i]) == RIGCAL_OK) {
            printf("(%.1f, %.1f) is %.1f px off it.\n", uv_b[i][0], uv_b[i][1], fabs(off));
        }
    }
    return 0;
}
