/* bearings: the rays of observed pixels, and the checks of points with rays. */
#include <math.h>
#include <string.h>

#include "rc_bearings.h"
#include "test_lenses.h"

static void test_observations_become_bearings_one_by_one(void)
{
    test_scene scene;
    rigcal_camera camera;
    rigcal_observation observations[20];
    rigcal_bearing bearings[20];
    int32_t at_fault;

    test_scene_seen(&scene, &camera, observations, 11);
    FILL(at_fault);
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_bearings_of_view(bearings, &at_fault,
                                          &VIEW(&camera, observations, NULL, 20)));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
    for (int i = 0; i < 20; i++) {
        const double exact[3] = {scene.xy[i][0], scene.xy[i][1], 1};
        double ray[3];

        TEST_ASSERT_EQUAL_MEMORY(observations[i].X_w, bearings[i].X_w,
                                 sizeof bearings[i].X_w);
        test_to_double(ray, bearings[i].ray, 3);
        ASSERT_NEAR(1, test_norm(ray), TOL(1e-15, 5e-7));
        ASSERT_NEAR(0, test_ray_angle(exact, ray), TOL(1e-11, 1e-5));
    }
}

static void test_the_observation_at_fault_is_told(void)
{
    static const int places[] = {0, 7, 19};
    test_scene scene;
    rigcal_camera camera;
    rigcal_observation good[20], observations[20];
    rigcal_bearing bearings[20];
    int32_t at_fault;

    test_scene_seen(&scene, &camera, good, 12);
    camera.k1 = RC(-0.4);
    camera.k2 = camera.k3 = 0;
    for (int i = 0; i < 20; i++) { /* all within the circle */
        good[i].uv[0] = RC(D(camera.cx) + 10 * i);
        good[i].uv[1] = RC(D(camera.cy) - 7 * i);
    }
    for (int p = 0; p < 3; p++) {
        const int i = places[p];

        memcpy(observations, good, sizeof good);
        observations[i].uv[0] = 5000;
        at_fault = -7;
        ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, bearings,
                       rigcal_bearings_of_view(bearings, &at_fault,
                                               &VIEW(&camera, observations, NULL, 20)));
        TEST_ASSERT_EQUAL_INT32(i, at_fault);

        memcpy(observations, good, sizeof good);
        observations[i].X_w[2] = TEST_NAN;
        at_fault = -7;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, bearings,
                       rigcal_bearings_of_view(bearings, &at_fault,
                                               &VIEW(&camera, observations, NULL, 20)));
        TEST_ASSERT_EQUAL_INT32(i, at_fault);
    }
    camera.fx = -1;
    at_fault = -7;
    ASSERT_REFUSED(
        RIGCAL_ERR_CAMERA, bearings,
        rigcal_bearings_of_view(bearings, &at_fault, &VIEW(&camera, good, NULL, 20)));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
}

/* The first point is wrong, so no other is read. */
static void test_the_most_points_are_2_to_the_28(void)
{
    rigcal_camera camera = test_pinhole();
    rigcal_observation first = {{0, 0, 1}, {TEST_NAN, 0}};
    rigcal_bearing bearing;
    rigcal_view view = VIEW(&camera, &first, NULL, 0);

    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, bearing,
                   rigcal_bearings_of_view(&bearing, NULL, &view));
    view.n = RC_COUNT_MAX;
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, bearing,
                   rigcal_bearings_of_view(&bearing, NULL, &view));
    view.n++; /* 0 where a size has few bits */
    ASSERT_REFUSED(view.n > 0 ? RIGCAL_ERR_RANGE : RIGCAL_ERR_TOO_FEW, bearing,
                   rigcal_bearings_of_view(&bearing, NULL, &view));
}

/* A ray has a pixel of a camera without distortion if its z is above the rounding of its
 * largest coordinate. */
static void test_a_ray_across_the_axis_has_no_tangents(void)
{
    for (int k = 0; k < 8; k++) {
        static const double EPS[4] = {-1, 0, 1, 1.5};
        const rigcal_real z = RC(EPS[k / 2] * D(RC_EPS) * 4);
        const rigcal_bearing bearing = {{1, 2, 3},
                                        {RC(k % 2 ? 4 : 0), RC(k % 2 ? 0 : -4), z}};

        ASSERT_STATUS(k < 6 ? RIGCAL_ERR_WIDE_RAY : RIGCAL_OK,
                      rc_check_bearings(&bearing, 1, 1));
        ASSERT_STATUS(RIGCAL_OK, rc_check_bearings(&bearing, 1, 0));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_ray_across_the_axis_has_no_tangents);
    RUN_TEST(test_observations_become_bearings_one_by_one);
    RUN_TEST(test_the_observation_at_fault_is_told);
    RUN_TEST(test_the_most_points_are_2_to_the_28);
}
