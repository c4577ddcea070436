/* In float, ends of a line clipped to an image of 2e9 pixels were up to 2300 px off it:
 * the image's size was not bounded as a camera's is. rigcal_epiline_curve lost its far
 * end where near / far underflows. */
#include <math.h>
#include <string.h>

#include "test_support.h"

static void test_an_image_too_large_is_refused(void)
{
    const rigcal_real line[3] = {RC(0.6), RC(-0.8), 100};
    rigcal_real ends[4];

    ASSERT_REFUSED(RIGCAL_ERR_RANGE, ends,
                   rigcal_epiline_clip(ends, line, 2000000000, 480));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, ends, rigcal_epiline_clip(ends, line, 640, 1000001));
}

static void test_ends_are_on_the_line(void)
{
    test_rng rng = test_seed(14);

    for (int trial = 0; trial < TEST_TRIALS(2000); trial++) {
        const double angle = test_uniform(&rng, -TEST_PI, TEST_PI);
        const int32_t width = (int32_t)test_uniform(&rng, 1, 1000000);
        const int32_t height = (int32_t)test_uniform(&rng, 1, 1000000);
        const double size = width > height ? width : height;
        const rigcal_real line[3] = {RC(cos(angle)), RC(sin(angle)),
                                     RC(-cos(angle) * test_uniform(&rng, 0, width) -
                                        sin(angle) * test_uniform(&rng, 0, height))};
        rigcal_real ends[4];

        if (rigcal_epiline_clip(ends, line, width, height) == RIGCAL_OK) {
            for (int k = 0; k < 4; k += 2) {
                ASSERT_NEAR(
                    0, D(line[0]) * D(ends[k]) + D(line[1]) * D(ends[k + 1]) + D(line[2]),
                    TOL(1e-15, 5e-7) * size);
            }
        }
    }
}

static void test_the_far_end_is_there(void)
{
    const rigcal_camera camera = test_pinhole();
    const rigcal_transform b_from_a = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {-1, 0, 0}};
    const rigcal_real ray[3] = {0, 0, 1};
    const double far_a = TOL(1e30, 1e9);
    rigcal_real uv[6];
    size_t n;

    ASSERT_STATUS(RIGCAL_OK, rigcal_epiline_curve(uv, 3, &n, &camera, &b_from_a, ray,
                                                  RC(TOL(1e-300, 1e-37)), RC(far_a)));
    /* At infinity the match has the direction of the ray. */
    ASSERT_NEAR(camera.cx, uv[2 * n - 2], 1e-3);
    ASSERT_NEAR(camera.cy, uv[2 * n - 1], 1e-3);
}

TEST_MAIN()
{
    RUN_TEST(test_an_image_too_large_is_refused);
    RUN_TEST(test_ends_are_on_the_line);
    RUN_TEST(test_the_far_end_is_there);
}
