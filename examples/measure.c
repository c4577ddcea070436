/* measure.c - a point in space from its pixels in two cameras, and how sure it is.
 * The truth: camera b is 0.25 m to the right of camera a and 0.1 m below it. Both look
 * one way. The point is at (0.1, 0.05, 1) m in the frame of camera a: x to the right,
 * y down, z ahead. With u = 640 + 800 X / Z, v = 480 + 800 Y / Z camera a sees it at
 * (720, 520), camera b at (520, 440). The pixels below are off by up to 0.4. */
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
    const rigcal_camera cameras[2] = {camera, camera};
    const rigcal_transform cams_from_a[2] = {
        {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}},         /* camera a itself */
        {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {-0.25, -0.1, 0}}}; /* camera b */
    const rigcal_real uv[4] = {720.3, 519.8, 519.9, 440.4};
    rigcal_point point;

    /* For pixels that are good to 0.3. */
    rigcal_status status =
        rigcal_point_triangulate(&point, cameras, cams_from_a, uv, 2, 0.3);
    if (status != RIGCAL_OK) {
        printf("%s\n", rigcal_status_text(status));
        return 1;
    }
    printf("The point is at (%.4f, %.4f, %.4f) m,\n", point.X[0], point.X[1], point.X[2]);
    printf("good to +- (%.4f, %.4f, %.4f) m.\n", sqrt(point.Sigma[0]), sqrt(point.Sigma[4]),
           sqrt(point.Sigma[8]));
    printf("Its pixels are %.1f px from where it should be seen.\n", point.rms_px);
    return 0;
}
