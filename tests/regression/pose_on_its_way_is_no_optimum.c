/* A refinement in a valley may run out of evaluations. Its pose was kept if it was the best
 * so far. It stayed among the optima when a better pose was found. */
#include <math.h>

#include "test_fit.h"

/* The sum of squared distances after a step of w or dt along the camera's axes. */
static double cost_beside(const rigcal_view *view, const rigcal_transform *cam_from_world,
                          int axis, double step)
{
    double R[9], t[3], d[6] = {0, 0, 0, 0, 0, 0};
    rigcal_real rms_px;

    test_transform_parts(R, t, cam_from_world);
    d[axis] = axis < 3 ? step : step * t[2];
    test_move(R, t, d);
    const rigcal_transform moved = test_transform(R, t);
    if (rigcal_view_rms(&rms_px, NULL, view, &moved) != RIGCAL_OK) {
        return 1e30; /* a point came behind */
    }
    return (double)view->n * D(rms_px) * D(rms_px);
}

enum { N = 4 };

/* X, Y, Z, u, v of exact images, close up */
static const double VIEWS[3][N][5] = {
    {{-0.98120474, 0.385776834, -0.4813463, -448.019245, -1457.29109},
     {-0.799056042, -0.153144263, -0.770659637, 452.833082, -2334.98346},
     {-0.817341639, 0.834077471, -0.22789311, -415.841711, -641.803937},
     {-0.737018725, 0.917247249, -0.178847588, -366.217431, -517.666794}},
    {{0.211957601, 0.41277585, -1.26539816, -2495.78574, 672.244565},
     {0.401378311, 0.598931716, -1.22166466, -2409.70399, 272.054183},
     {0.737115248, 0.843453265, -1.04286106, -2463.27155, -377.448961},
     {1.06677491, 0.721274581, -0.922309354, -4996.49591, -1325.37756}},
    {{-0.0382381017, 0.0878644507, 0.162017502, 380.10444, -2221.96959},
     {-0.0247884552, 0.0429239185, 0.200969041, 342.338199, -2133.52265},
     {-0.00992644201, 0.0715675929, 0.174536953, 385.230997, -2180.20726},
     {0.496059753, -0.297854277, 0.467635187, 390.920231, -1327.88528}}};

static void test_every_pose_is_a_minimum(void)
{
    const rigcal_camera camera = test_pinhole();

    for (int v = 0; v < 3; v++) {
        rigcal_observation seen[N];
        rigcal_pose poses[RIGCAL_POSES_MAX];
        size_t n_found;

        for (int i = 0; i < N; i++) {
            for (int k = 0; k < 3; k++) {
                seen[i].X_w[k] = RC(VIEWS[v][i][k]);
            }
            seen[i].uv[0] = RC(VIEWS[v][i][3]);
            seen[i].uv[1] = RC(VIEWS[v][i][4]);
        }
        const rigcal_view view = VIEW(&camera, seen, NULL, N);
        TEST_ASSERT_TRUE(
            rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL, &view, NULL) >= 0);
        for (size_t i = 0; i < n_found; i++) {
            const rigcal_transform *T = &poses[i].cam_from_world;
            const double cost = cost_beside(&view, T, 0, 0);

            for (int k = 0; k < 12; k++) {
                const double step = k < 6 ? 1e-4 : -1e-4;

                TEST_ASSERT_TRUE(cost_beside(&view, T, k % 6, step) >=
                                 cost - TOL(1e-6, 1e-2) * (1 + cost));
            }
        }
    }
}

TEST_MAIN()
{
    RUN_TEST(test_every_pose_is_a_minimum);
}
