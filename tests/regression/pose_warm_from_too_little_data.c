/* From a previous pose, two different points, or points on one line, gave AMBIGUOUS with
 * probability 1. A search says COLLINEAR. rigcal_pose_blame said OK. */
#include <math.h>
#include <string.h>

#include "test_support.h"

enum { N = 8 };

static rigcal_camera camera;
static rigcal_observation seen[N];
static rigcal_pose_options options;

/* Points on a line, or at two places of it, and a previous pose that is nearly right. */
static void make(int at_two_places, int trial)
{
    const double a = trial * 0.37, w[3] = {0.3 * sin(a), 0.4 * cos(a), 0.2};
    const double t[3] = {0.1, 0.1, 3 + 0.01 * (trial % 3)};
    double R[9];

    camera = test_pinhole();
    test_rotation_about(R, w, test_norm(w));
    for (int i = 0; i < N; i++) {
        const double s = at_two_places ? (i == 3) : i / 8.0 - 0.4;
        const double X[3] = {s, 0.5 * s, 0.25 * s};
        double X_c[3], uv[2];

        test_to_real(seen[i].X_w, X, 3);
        test_apply(X_c, R, X, t);
        test_project_px(uv, &camera, X_c);
        test_to_real(seen[i].uv, uv, 2);
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_pose_defaults(&options));
    options.use_start = 1;
    options.start = test_transform(R, t);
    options.start.t[0] += RC(0.01 * (trial % 2));
    options.sigma_px = RC(trial % 4 < 2 ? 0.3 : 0);
}

static void expect(rigcal_status expected)
{
    rigcal_pose poses[RIGCAL_POSES_MAX];
    rigcal_blame blame;
    size_t n_found;

    ASSERT_STATUS(expected, rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL,
                                              &VIEW(&camera, seen, NULL, N), &options));
    ASSERT_STATUS(expected,
                  rigcal_pose_blame(&blame, NULL, &VIEW(&camera, seen, NULL, N), &options));
    options.use_start = 0;
    ASSERT_STATUS(expected, rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL,
                                              &VIEW(&camera, seen, NULL, N), &options));
}

static void test_points_on_a_line_are_collinear(void)
{
    for (int trial = 0; trial < TEST_TRIALS(200); trial++) {
        make(0, trial);
        expect(RIGCAL_ERR_COLLINEAR);
    }
}

static void test_two_different_points_are_too_few(void)
{
    for (int trial = 0; trial < TEST_TRIALS(200); trial++) {
        make(1, trial);
        expect(RIGCAL_ERR_COINCIDENT);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_points_on_a_line_are_collinear);
    RUN_TEST(test_two_different_points_are_too_few);
}
