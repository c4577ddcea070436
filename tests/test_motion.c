/* motion: how a target moves between its placements. The truth: paths whose places and
 * velocities are polynomials of time, about one axis. */
#include <math.h>

#include "rc_motion.h"
#include "test_support.h"

enum { N = 12 };

static rigcal_transform poses[N];
static rigcal_real times[N];

/* Coefficients of the powers of time: of the turn about AXIS, and of the place along each
 * axis. */
static const double TURN[5] = {0.3, 0.9, -0.7, 0.5, 0.4};
static const double PLACE[3][5] = {
    {0.1, 0.4, -0.3, 0.2, 0.6}, {-0.2, 0.1, 0.5, -0.4, 0.3}, {0.9, -0.5, 0.2, 0.3, -0.2}};
static const double AXIS[3] = {0.36, 0.48, 0.8};

/* The value, or the derivative, at t. */
static double polynomial(const double c[5], double t, int is_slope, int degree)
{
    double sum = 0;

    for (int k = degree; k >= is_slope; k--) {
        sum = sum * t + c[k] * (is_slope ? k : 1);
    }
    return sum;
}

static rigcal_transform pose_at(double t, int degree)
{
    double R[9], place[3];

    test_rotation_about(R, AXIS, polynomial(TURN, t, 0, degree));
    for (int k = 0; k < 3; k++) {
        place[k] = polynomial(PLACE[k], t, 0, degree);
    }
    return test_transform(R, place);
}

static rc_path path_of(int n, double longest, int neighbours)
{
    const rc_path path = {poses, times, (size_t)n, RC(longest), neighbours};
    return path;
}

/* At uneven times. */
static void fill(int n, int degree)
{
    for (int i = 0; i < n; i++) {
        times[i] = (rigcal_real)(0.1 * i + 0.02 * sin(7.0 * i));
        poses[i] = pose_at(D(times[i]), degree);
    }
}

static void expect_motion(const rigcal_motion *motion, int f, double after, int degree)
{
    const double t = D(times[f]) + after;
    double d[6], xi[6];
    rigcal_real found[6], speed[6];

    for (int k = 0; k < 3; k++) {
        d[k] = AXIS[k] *
               (polynomial(TURN, t, 0, degree) - polynomial(TURN, D(times[f]), 0, degree));
        xi[k] = AXIS[k] * polynomial(TURN, t, 1, degree);
        d[3 + k] = polynomial(PLACE[k], t, 0, degree) -
                   polynomial(PLACE[k], D(times[f]), 0, degree);
        xi[3 + k] = polynomial(PLACE[k], t, 1, degree);
    }
    rc_motion_at(found, speed, motion, (rigcal_real)after);
    ASSERT_ARRAY_NEAR(d, found, 6, TOL(1e-12, 2e-6));
    ASSERT_ARRAY_NEAR(xi, speed, 6, TOL(1e-10, 2e-4));
}

/* With n neighbours the path is a polynomial of degree n. */
static void test_a_path_of_the_degree_of_its_neighbours_is_found(void)
{
    for (int degree = 1; degree <= 4; degree++) {
        const rc_path path = path_of(N, 0.2, degree);

        fill(N, degree);
        for (int f = 0; f < N; f++) {
            rigcal_motion motion;

            rc_motion_of(&motion, &path, (size_t)f);
            TEST_ASSERT_EQUAL_INT32(degree, motion.n);
            for (double after = -0.05; after < 0.06; after += 0.025) {
                expect_motion(&motion, f, after, degree);
            }
        }
    }
}

static void expect_times(int f, int neighbours, int n, const int of[])
{
    const rc_path path = path_of(N, 0.2, neighbours);
    rigcal_motion motion;

    rc_motion_of(&motion, &path, (size_t)f);
    TEST_ASSERT_EQUAL_INT32(n, motion.n);
    for (int i = 0; i < n; i++) {
        ASSERT_NEAR(D(times[of[i]]) - D(times[f]), motion.t[i], TOL(1e-15, 1e-7));
    }
}

/* Two neighbours on each side, if there are two. */
static void test_the_neighbours_are_the_nearest_of_the_run(void)
{
    static const int MIDDLE[4] = {4, 6, 3, 7}, FIRST[4] = {1, 2, 3, 4},
                     LAST[4] = {N - 2, N - 3, N - 4, N - 5}, SECOND[4] = {0, 2, 3, 4},
                     TWO[2] = {4, 6};

    fill(N, 2);
    expect_times(5, 4, 4, MIDDLE);
    expect_times(0, 4, 4, FIRST);
    expect_times(N - 1, 4, 4, LAST);
    expect_times(1, 4, 4, SECOND);
    expect_times(5, 2, 2, TWO);
}

/* A run ends where a step is too long, or 0. Unknown times are skipped. */
static void test_a_run_ends_at_a_gap(void)
{
    static const int SHORT[2] = {4, 3}, OTHER[4] = {7, 8, 9, 10}, OVER[4] = {5, 8, 4, 9};

    fill(N, 2);
    for (int i = 3; i < N; i++) {
        times[i] += 3;
    }
    for (int i = 6; i < N; i++) {
        times[i] += 3;
    }
    expect_times(5, 4, 2, SHORT);
    expect_times(6, 4, 4, OTHER);
    fill(N, 2);
    times[6] = TEST_NAN; /* 5 and 7 are slightly more than 0.2 apart */
    times[7] = times[5] + RC(0.19);
    expect_times(7, 4, 4, OVER);
    expect_times(6, 4, 0, NULL);
    times[6] = times[5];
    expect_times(6, 1, 1, (const int[1]){7}); /* between equal times there is no step */
    times[0] = TEST_INF;
    expect_times(0, 4, 0, NULL);
    expect_times(1, 1, 1, (const int[1]){2});
}

static void test_a_placement_by_itself_has_no_motion(void)
{
    const rc_path path = path_of(1, 0.2, 4);
    rigcal_motion motion;
    rigcal_real d[6], xi[6];

    fill(1, 2);
    rc_motion_of(&motion, &path, 0);
    rc_motion_at(d, xi, &motion, RC(0.1));
    for (int k = 0; k < 6; k++) {
        ASSERT_NEAR(0, d[k], 0);
        ASSERT_NEAR(0, xi[k], 0);
    }
}

/* Compares m with the change of cam_from_target in a short time. */
static void test_a_camera_sees_the_velocity_of_the_target(void)
{
    const double h = TOL(1e-5, 1e-2);
    test_rng rng = test_seed(3);
    const rigcal_transform camera = test_random_transform(&rng);
    rigcal_motion motion;
    rigcal_real d[6], xi[6], m[6];
    rc_chain chain, ends[2];
    const rc_path path = path_of(N, 0.2, 4);

    fill(N, 4);
    rc_motion_of(&motion, &path, 5);
    rc_motion_at(d, xi, &motion, 0);
    rc_chain_of(&chain, &camera, &poses[5]);
    rc_motion_seen(m, &chain, xi);
    for (int i = 0; i < 2; i++) {
        const rigcal_transform moved = pose_at(D(times[5]) + (i > 0 ? h : -h), 4);
        rc_chain_of(&ends[i], &camera, &moved);
    }
    rc_deviation(d, &ends[1].cam_from_target, &ends[0].cam_from_target);
    for (int k = 0; k < 6; k++) {
        ASSERT_NEAR(D(d[k]) / (2 * h), m[k], TOL(1e-8, 2e-3));
    }
}

/* A step of just the longest length is within a run. The largest coordinate is a known
 * time. */
static void test_the_limits_of_a_run_are_within_it(void)
{
    const rigcal_real far = RC(TOL(1e30, 1e9)); /* RC_COORDINATE_MAX */

    for (int k = 0; k < 5; k++) {
        const double longest = k == 0 ? 0.25 : k == 1 ? 0.2499 : k == 4 ? 0.25 : 2 * D(far);
        const rc_path path = path_of(2, longest, 4);
        rigcal_motion motion;

        fill(2, 1);
        times[0] = 0;
        times[1] = k < 2 ? RC(0.25) : k == 2 ? far : k == 3 ? far * RC(1.001) : 0;
        rc_motion_of(&motion, &path, 0);
        TEST_ASSERT_EQUAL_INT32(k == 0 || k == 2, motion.n);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_path_of_the_degree_of_its_neighbours_is_found);
    RUN_TEST(test_the_neighbours_are_the_nearest_of_the_run);
    RUN_TEST(test_a_run_ends_at_a_gap);
    RUN_TEST(test_a_placement_by_itself_has_no_motion);
    RUN_TEST(test_a_camera_sees_the_velocity_of_the_target);
    RUN_TEST(test_the_limits_of_a_run_are_within_it);
}
