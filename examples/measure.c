/* measure.c - a point in space from its pixels in two cameras.
 *
 * Given: both cameras and where they are; the pixel of the point in each.
 * Asked: where the point is in the frame of camera a, and how sure that is.
 * Truth: camera b is 0.25 m to the right of camera a and 0.1 m below it. Both look one way.
 *        The point is at (0.1, 0.05, 1) m: x to the right, y down, z ahead. With
 *        u = 640 + 800 X / Z, v = 480 + 800 Y / Z camera a sees it at (720, 520), camera b
 *        at (520, 440). The pixels below are off by up to 0.4. */
#include <math.h>
#include <stdio.h>
#include <rigcal.h>

int main(void)
{
    rigcal_camera camera = {.fx = 800, .fy = 800, .cx = 640, .cy = 480}; /* a pinhole */
    camera.width = 1280;
    camera.height = 960;
    const rigcal_camera cameras[2] = {camera, camera};
    const rigcal_transform cams_from_a[2] = {
        {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}},         /* camera a itself */
        {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {-0.25, -0.1, 0}}}; /* camera b */
    const rigcal_real uv[4] = {720.3, 519.8, 519.9, 440.4};
    const rigcal_real sigma_px = 0.3; /* how good the pixels are */
    rigcal_point point;

    rigcal_status status =
        rigcal_point_triangulate(&point, cameras, cams_from_a, uv, 2, sigma_px);
    if (status != RIGCAL_OK) {
        printf("%s\n", rigcal_status_text(status));
        return 1;
    }
    const rigcal_real *X = point.X, *S = point.Sigma;
    printf("The point is at (%.4f, %.4f, %.4f) m,\n", X[0], X[1], X[2]);
    printf("good to +- (%.4f, %.4f, %.4f) m.\n", sqrt(S[0]), sqrt(S[4]), sqrt(S[8]));
    printf("Its pixels are %.1f px from where it should be seen.\n", point.rms_px);
    return 0;
}
