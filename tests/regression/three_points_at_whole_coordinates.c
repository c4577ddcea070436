/* In float, a triangle with whole coordinates that is seen from a point with whole
 * coordinates often had no pose: squares of the solutions overflowed where the conics of
 * two sides were lines already, to rounding. */
#include <math.h>

#include "test_support.h"

/* Corners, and where the camera is. */
typedef struct {
    double X[3][3], camera[3];
} seen_from;

static const seen_from WHOLE[] = {
    {{{0, -2, 1}, {-1, -1, 1}, {-1, -2, 2}}, {2, 1, 4}},
    {{{0, -1, 0}, {2, 0, -1}, {1, -2, -2}}, {4, -4, 2}},
    {{{-1, -1, 0}, {2, -1, -1}, {2, 1, -1}}, {3, 3, 4}},
    {{{2, 2, -1}, {1, -2, 2}, {-2, -1, -2}}, {-3, 3, 3}},
    {{{1, -2, 1}, {-2, -2, -2}, {1, 1, -2}}, {3, -4, -4}},
    {{{-1, 1, 0}, {-2, 1, -1}, {-2, 2, 0}}, {0, 3, -2}},
};

/* Solves for a camera with an arbitrary rotation that sees the corners. Returns the error
 * of the pose nearest to the truth: the distance of t. */
static double solve(const seen_from *scene, test_rng *rng)
{
    const rigcal_camera camera = test_pinhole();
    rigcal_observation seen[3];
    rigcal_pose poses[RIGCAL_POSES_MAX];
    double R[9], t[3], least = 1e300;
    size_t n_found;

    for (int i = 0; i < 3;) { /* until all are at most 45 degrees off the axis */
        double X_c[3], uv[2];

        if (i == 0) {
            test_random_rotation(R, rng);
            test_apply(t, R, scene->camera, NULL);
            for (int k = 0; k < 3; k++) {
                t[k] = -t[k];
            }
        }
        test_apply(X_c, R, scene->X[i], t);
        if (X_c[2] < sqrt(0.5) * test_norm(X_c)) {
            i = 0;
            continue;
        }
        test_project_px(uv, &camera, X_c);
        test_to_real(seen[i].X_w, scene->X[i], 3);
        test_to_real(seen[i].uv, uv, 2);
        i++;
    }
    TEST_ASSERT_TRUE(rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL,
                                       &VIEW(&camera, seen, NULL, 3), NULL) >= 0);
    for (size_t i = 0; i < n_found; i++) {
        double found[3], squared = 0;

        test_transform_parts(NULL, found, &poses[i].cam_from_world);
        for (int k = 0; k < 3; k++) {
            squared += (found[k] - t[k]) * (found[k] - t[k]);
        }
        least = fmin(least, sqrt(squared));
    }
    return least;
}

static void test_the_pose_is_among_those_found(void)
{
    enum { SCENES = sizeof WHOLE / sizeof WHOLE[0] };
    test_rng rng = test_seed(31);

    for (int trial = 0; trial < TEST_TRIALS(100 * SCENES); trial++) {
        const double error = solve(&WHOLE[trial % SCENES], &rng);
        TEST_ASSERT_TRUE(error < TOL(1e-9, 1e-2));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_the_pose_is_among_those_found);
}
