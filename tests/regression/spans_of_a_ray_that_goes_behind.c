/* No part of a ray is in front of camera b if it begins beside it and goes backwards. Its
 * beginning is infinitely far in b's image, and rounding decides on which side. Spans over
 * half of the image were returned.
 *
 * If it begins in front of b, nearly across its axis, its only place there is a hundred
 * focal lengths or more from the axis. The borders of the band are farther from each other
 * there than a polynomial can tell. It crossed the image, and spans over half of it were
 * returned. */
#include <math.h>
#include <string.h>

#include "test_support.h"

/* The ray of the principal point. Camera b is turned by `angle` about an axis of its image
 * plane. Returns 0 if there is no band; if there is one, nothing is to be searched. */
static int is_outside(const rigcal_camera *camera, double angle, double about,
                      const double t[3])
{
    static rigcal_spans_solver solver;
    rigcal_span spans[8];
    const rigcal_real principal[2] = {camera->cx, camera->cy};
    const rigcal_real w[3] = {RC(angle * cos(about)), RC(angle * sin(about)), 0};
    rigcal_match_pair pair;
    rigcal_band band;
    size_t n_found;

    memset(&pair, 0, sizeof pair);
    pair.camera_a = pair.camera_b = camera;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_vector(pair.b_from_a.R, w));
    test_to_real(pair.b_from_a.t, t, 3);
    for (int i = 0; i < 6; i++) {
        pair.Sigma[7 * i] = RC(1e-6);
    }
    pair.sigma_a = pair.sigma_b = RC(0.3);
    pair.k = 3;
    if (rigcal_band_make(&band, &pair, principal) != RIGCAL_OK) {
        return 0;
    }
    ASSERT_STATUS(RIGCAL_ERR_OUTSIDE,
                  rigcal_spans_find(spans, 8, &n_found, &solver, &band));
    return 1;
}

static rigcal_camera centred(double k1, double k2)
{
    rigcal_camera camera = test_pinhole();

    camera.cx = 320;
    camera.cy = 240;
    camera.k1 = RC(k1);
    camera.k2 = RC(k2);
    return camera;
}

static void test_a_ray_that_begins_beside_the_camera(void)
{
    test_rng rng = test_seed(15);
    int n_bands = 0;

    for (int trial = 0; trial < TEST_TRIALS(2000); trial++) {
        const rigcal_camera camera = centred((trial % 2 == 0) ? 0 : -0.05, 0);
        const double angle = test_uniform(&rng, 1.7, 3);
        const double about = test_uniform(&rng, -3.14, 3.14);
        double t[3] = {0, 0, 0};

        for (int k = 0; k < 2; k++) {
            t[k] = test_uniform(&rng, -2, 2);
        }
        n_bands += is_outside(&camera, angle, about, t);
    }
    TEST_ASSERT_GREATER_THAN_INT(TEST_TRIALS(1000), n_bands);
}

static void test_a_ray_nearly_across_the_axis(void)
{
    const rigcal_camera camera = centred(-0.02, 0.05);
    test_rng rng = test_seed(23);
    int n_bands = 0;

    for (int trial = 0; trial < TEST_TRIALS(2000); trial++) {
        const double angle = acos(test_uniform(&rng, 1e-3, 1e-2));
        const double about = test_uniform(&rng, -3.14, 3.14);
        double t[3];

        for (int k = 0; k < 3; k++) {
            t[k] = test_uniform(&rng, -1, k < 2 ? 1 : -0.1);
        }
        n_bands += is_outside(&camera, angle, about, t);
    }
    TEST_ASSERT_GREATER_THAN_INT(TEST_TRIALS(1000), n_bands);
}

TEST_MAIN()
{
    RUN_TEST(test_a_ray_that_begins_beside_the_camera);
    RUN_TEST(test_a_ray_nearly_across_the_axis);
}
