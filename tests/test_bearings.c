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

static void test_a_view_of_one_point_has_one_bearing(void)
{
    const rigcal_camera camera = test_pinhole();
    const rigcal_observation o = {{1, 2, 3}, {camera.cx, camera.cy}};
    const double ahead[3] = {0, 0, 1};
    rigcal_bearing bearing;
    int32_t at_fault = -7;

    ASSERT_STATUS(RIGCAL_OK, rigcal_bearings_of_view(&bearing, &at_fault,
                                                     &VIEW(&camera, &o, NULL, 1)));
    ASSERT_ARRAY_NEAR(ahead, bearing.ray, 3, 0);
    TEST_ASSERT_EQUAL_MEMORY(o.X_w, bearing.X_w, sizeof o.X_w);
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
}

/* Each number in turn, in each bearing of three. */
static void test_bearings_are_checked_one_by_one(void)
{
    static const rigcal_bearing good = {{1, -2, 3}, {RC(0.1), RC(-0.2), 1}};
    rigcal_bearing s[3];

    ASSERT_STATUS(RIGCAL_ERR_NULL, rc_check_bearings(NULL, 3, 1));
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 6; k++) {
            s[0] = s[1] = s[2] = good;
            rigcal_real *const x = k < 3 ? &s[i].X_w[k] : &s[i].ray[k - 3];
            *x = TEST_INF;
            ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rc_check_bearings(s, 3, 1));
            ASSERT_STATUS(i < 2 ? RIGCAL_ERR_NOT_FINITE : RIGCAL_OK,
                          rc_check_bearings(s, 2, 1));
            *x = RC(TOL(1.1e30, 1.1e9)); /* a ray may have any length */
            ASSERT_STATUS(k < 3 ? RIGCAL_ERR_RANGE : RIGCAL_OK, rc_check_bearings(s, 3, 0));
        }
        s[0] = s[1] = s[2] = good;
        rc_clear(s[i].ray, 3);
        ASSERT_STATUS(RIGCAL_ERR_RANGE, rc_check_bearings(s, 3, 0));
        s[i].ray[1] = RC(-1e-30);
        ASSERT_STATUS(RIGCAL_OK, rc_check_bearings(s, 3, 0));
        ASSERT_STATUS(RIGCAL_ERR_WIDE_RAY, rc_check_bearings(s, 3, 1));
    }
}

/* z must be above rounding of the ray's length: not at it, and not behind. */
static void test_a_ray_ahead_is_more_than_rounding_ahead(void)
{
    const rigcal_real eps = RC(TOL(2.220446049250313e-16, 1.1920928955078125e-7));
    rigcal_bearing s = {{0, 0, 0}, {-2, 0, 2 * eps}};

    ASSERT_STATUS(RIGCAL_ERR_WIDE_RAY, rc_check_bearing(&s, 1));
    ASSERT_STATUS(RIGCAL_OK, rc_check_bearing(&s, 0));
    s.ray[2] = 3 * eps;
    ASSERT_STATUS(RIGCAL_OK, rc_check_bearing(&s, 1));
    s.ray[2] = -1;
    ASSERT_STATUS(RIGCAL_ERR_WIDE_RAY, rc_check_bearing(&s, 1));
    ASSERT_STATUS(RIGCAL_OK, rc_check_bearing(&s, 0));
}

/* The first bearing is wrong, so no other is read. */
static void test_the_most_bearings_are_2_to_the_28(void)
{
    const rigcal_bearing first = {{0, 0, TEST_NAN}, {0, 0, 1}};
    const size_t most = RC_COUNT_MAX;

    ASSERT_STATUS(RIGCAL_OK, rc_check_bearings(&first, 0, 1));
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rc_check_bearings(&first, most, 1));
    ASSERT_STATUS(most + 1 > 0 ? RIGCAL_ERR_RANGE : RIGCAL_OK,
                  rc_check_bearings(&first, most + 1, 1));
}

TEST_MAIN()
{
    RUN_TEST(test_observations_become_bearings_one_by_one);
    RUN_TEST(test_the_observation_at_fault_is_told);
    RUN_TEST(test_the_most_points_are_2_to_the_28);
    RUN_TEST(test_a_view_of_one_point_has_one_bearing);
    RUN_TEST(test_bearings_are_checked_one_by_one);
    RUN_TEST(test_a_ray_ahead_is_more_than_rounding_ahead);
    RUN_TEST(test_the_most_bearings_are_2_to_the_28);
}
