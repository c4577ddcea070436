/* matching_line.c - a pixel of camera a, and where in camera b the same point can be.
 *
 * Given: both cameras, where b is from a, and a pixel of camera a.
 * Asked: the line of camera b on which the point must be, and how far pixels are off it.
 * Truth: camera b is 0.25 m right of camera a, 0.1 m below it. Both look one way,
 *        u = 640 + 800 X / Z, v = 480 + 800 Y / Z. A point that a sees at (720, 520) is
 *        seen by b at (720, 520) if it is far away, at (520, 440) if Z = 1 m, and at
 *        (220, 320) if Z = 0.4 m: all on one line, of slope 0.4. */
#include <math.h>
#include <stdio.h>
#include <rigcal.h>

int main(void)
{
    rigcal_camera camera = {.fx = 800, .fy = 800, .cx = 640, .cy = 480}; /* a pinhole */
    camera.width = 1280;
    camera.height = 960;
    const rigcal_transform b_from_a = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {-0.25, -0.1, 0}};
    const rigcal_real uv_a[2] = {720, 520}, uv_b[2][2] = {{521, 439}, {520, 470}};
    rigcal_real ray[3], line[3], ends[4], off[2];

    rigcal_status status = rigcal_camera_ray(ray, &camera, uv_a);
    if (status == RIGCAL_OK) {
        status = rigcal_epiline_px(line, &camera, &b_from_a, ray);
    }
    if (status == RIGCAL_OK) { /* its part inside the image */
        status = rigcal_epiline_clip(ends, line, camera.width, camera.height);
    }
    for (int i = 0; i < 2 && status == RIGCAL_OK; i++) {
        status = rigcal_epiline_distance(&off[i], line, &camera, uv_b[i]);
    }
    if (status != RIGCAL_OK) {
        printf("%s\n", rigcal_status_text(status));
        return 1;
    }
    printf("The line: (%.1f, %.1f) to (%.1f, %.1f)\n", ends[0], ends[1], ends[2], ends[3]);
    printf("(521, 439) is %.1f px off it, ", fabs(off[0]));
    printf("(520, 470) is %.1f px off it.\n", fabs(off[1]));
    return 0;
}
