/* Lens coefficients of 1e308 passed the check of a camera, and caused an overflow later. */
#include <math.h>
#include <string.h>

#include "test_support.h"

static void test_the_camera_is_refused(void)
{
    for (int k = 0; k < 8; k++) {
        rigcal_camera camera = test_pinhole();
        rigcal_real *const coefficient = &camera.k1 + k;

        *coefficient = RC(1e9);
        ASSERT_STATUS(RIGCAL_OK, rigcal_camera_check(&camera));
        *coefficient = RC(-1.1e9);
        ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&camera));
        *coefficient = RC(TOL(1e308, 1e38));
        ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&camera));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_the_camera_is_refused);
}
