/* An example of a user's program: it calls functions of the library, one of which needs
 * libm. */
#include <stdio.h>

#include "rigcal.h"
#include "rigcal_paper.h"

int main(void)
{
    const rigcal_real ypr[3] = {(rigcal_real)0.1, (rigcal_real)0.2, (rigcal_real)0.3};
    rigcal_real R[9];
    rigcal_camera camera = {0};
    const int32_t version =
        RIGCAL_VERSION_MAJOR * 10000 + RIGCAL_VERSION_MINOR * 100 + RIGCAL_VERSION_PATCH;

    if (rigcal_version() != version) {
        printf("the library is not the header's version\n");
        return 1;
    }
    if (rigcal_sizeof_real() != (int32_t)sizeof(rigcal_real)) {
        printf("the library's rigcal_real is not ours\n");
        return 1;
    }
    if (rigcal_pairs_for(4) != 6) {
        printf("no pairs of the published procedure\n");
        return 1;
    }
    if (rigcal_rotation_from_yaw_pitch_roll(R, ypr) != RIGCAL_OK) {
        printf("no rotation\n");
        return 1;
    }
    camera.lens = RIGCAL_LENS_FISHEYE;
    camera.width = camera.height = 1;
    camera.fx = camera.fy = 1;
    printf("rigcal %ld, rigcal_real of %d bytes, %s fisheyes\n", (long)version,
           (int)sizeof(rigcal_real),
           rigcal_camera_check(&camera) == RIGCAL_OK ? "with" : "without");
    return 0;
}
