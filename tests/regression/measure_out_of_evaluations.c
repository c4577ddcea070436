/* A point whose search ran out of evaluations just after a step that did harm: the place
 * before that step, evaluated again, was taken for a step tried. The result was the same,
 * but where RIGCAL_ASSERTS is on an assertion failed. */
#include "test_two_views.h"

static void test_a_search_that_ends_after_a_refused_step_gives_its_point(void)
{
    static const uint64_t SEEDS[3] = {14, 23, 350};
    static const rigcal_real NOISE[3] = {1, 1, 1};
    static rigcal_mounted_camera cameras[3];
    static rigcal_real work[RIGCAL_POINT_WORK(3)];
    int32_t group[3] = {0, 0, 0};
    uint8_t held[3] = {1, 1, 1}, used[3];

    for (int trial = 0; trial < 3; trial++) {
        test_rng rng = test_seed(SEEDS[trial]);
        rigcal_calibrated_rig rig = {.cameras = cameras, .group = group, .held = held};
        rigcal_sighting seen[3];
        rigcal_sightings s = {.rig = &rig, .seen = seen, .sigma_px = NOISE, .keep_all = 1};
        rigcal_measured_point point = {.gains = NULL};
        test_views v;
        double X[3];

        test_wild_views(&v, &rng);
        rig.n_cameras = rig.capacity = s.n = (size_t)v.n;
        s.work = work;
        s.work_capacity = RIGCAL_POINT_WORK(3);
        for (int i = 0; i < v.n; i++) {
            cameras[i].camera = v.cameras[i];
            cameras[i].cam_from_rig = v.cams_from_world[i];
            seen[i] = (rigcal_sighting){i, {v.uv[2 * i], v.uv[2 * i + 1]}};
        }
        const rigcal_status status = rigcal_point_measure(&point, used, &s);
        TEST_ASSERT_TRUE(status > 0 || RIGCAL_USE_FLOAT); /* a poor fit */
        if (status < 0) {
            continue; /* in float the search takes another way, which each libm decides */
        }
        test_to_double(X, point.X, 3);
        TEST_ASSERT_TRUE(test_views_sum(&v, X) < test_infinity()); /* seen by all */
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_search_that_ends_after_a_refused_step_gives_its_point);
}
