/* small: the library with all optional parts left out (rigcal_config_small.h), built here
 * in place of the full one. What is missing is refused with a status that names it; the
 * rest works as before. */
#include <math.h>

#include "test_support.h"

enum { N_MAX = 12 };

typedef struct {
    test_scene scene;
    rigcal_camera camera;
    rigcal_observation o[N_MAX];
    rigcal_pose poses[RIGCAL_POSES_MAX];
    size_t n_found;
} problem;

static void random_problem(problem *p, test_rng *rng, int n, test_shape shape)
{
    test_scene_random(&p->scene, rng, n, shape);
    p->camera = test_pinhole();
    test_observations(p->o, &p->scene, &p->camera);
}

static rigcal_status solve(problem *p, size_t n, const rigcal_pose_options *options)
{
    return rigcal_pose_solve(p->poses, RIGCAL_POSES_MAX, &p->n_found, NULL,
                             &VIEW(&p->camera, p->o, NULL, n), options);
}

static void test_a_fisheye_is_no_camera(void)
{
    rigcal_camera camera = test_pinhole();

    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_check(&camera));
    camera.lens = RIGCAL_LENS_FISHEYE;
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&camera));
}

static void test_three_different_points_are_too_few(void)
{
    test_rng rng = test_seed(501);
    problem p;

    random_problem(&p, &rng, 4, TEST_GENERAL);
    ASSERT_STATUS(RIGCAL_ERR_TOO_FEW, solve(&p, 3, NULL));
    ASSERT_STATUS(RIGCAL_ERR_TOO_FEW, solve(&p, 2, NULL));
    TEST_ASSERT_TRUE(solve(&p, 4, NULL) >= 0);
    p.o[3] = p.o[1];
    ASSERT_STATUS(RIGCAL_ERR_TOO_FEW, solve(&p, 4, NULL));
}

/* Rays of 80 degrees or more off the axis need the poses of three points. */
static void test_a_ray_80_degrees_off_the_axis_is_refused_by_name(void)
{
    enum { POINTS = 6, WIDEST = 4 };
    const rigcal_camera camera = test_pinhole();
    rigcal_observation o[POINTS];
    rigcal_pose poses[RIGCAL_POSES_MAX];
    size_t n_found;
    test_rng rng = test_seed(505);

    for (int trial = 0; trial < TEST_TRIALS(200); trial++) {
        const int is_wide = trial % 2;
        int32_t at_fault = -2;
        double R[9], back[9];

        test_random_rotation(R, &rng);
        test_transpose(back, R);
        for (int i = 0; i < POINTS; i++) {
            const double off =
                (i == WIDEST) ? (is_wide ? 80.5 : 79.5) : test_uniform(&rng, 40, 79);
            const double sine = sin(off * TEST_PI / 180), way = 1.1 * i,
                         far = test_uniform(&rng, 1, 3);
            const double X_c[3] = {far * sine * cos(way), far * sine * sin(way),
                                   far * cos(off * TEST_PI / 180)};
            double X_w[3], uv[2];

            test_apply(X_w, back, X_c, NULL);
            test_project_px(uv, &camera, X_c);
            test_to_real(o[i].X_w, X_w, 3);
            test_to_real(o[i].uv, uv, 2);
        }
        const rigcal_status status =
            rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, &at_fault,
                              &VIEW(&camera, o, NULL, POINTS), NULL);
        if (is_wide) {
            ASSERT_STATUS(RIGCAL_ERR_WIDE_RAY, status);
            TEST_ASSERT_EQUAL_INT(WIDEST, at_fault);
        } else {
            TEST_ASSERT_TRUE(status != RIGCAL_ERR_WIDE_RAY);
        }
    }
}

/* The true pose of exact pixels is among those found, through a lens too. */
static void test_other_poses_are_found_as_ever(void)
{
    static const test_shape SHAPES[3] = {TEST_GENERAL, TEST_PLANAR, TEST_SQUARE};
    test_rng rng = test_seed(503);

    for (int trial = 0; trial < TEST_TRIALS(600); trial++) {
        const int n = (trial % 3 == 2) ? 4 : 4 + trial % 9;
        double least = 1e300;
        problem p;

        test_scene_random(&p.scene, &rng, n, SHAPES[trial % 3]);
        p.camera = test_pinhole();
        if (trial % 2) {
            p.camera.k1 = RC(-0.2);
            p.camera.p1 = RC(1e-3);
        }
        test_observations(p.o, &p.scene, &p.camera);
        TEST_ASSERT_TRUE(solve(&p, (size_t)n, NULL) >= 0);
        for (size_t i = 0; i < p.n_found; i++) {
            double R[9], t[3];

            test_transform_parts(R, t, &p.poses[i].cam_from_world);
            least = fmin(least, test_angle_between(R, p.scene.R));
        }
        TEST_ASSERT_TRUE(least < TOL(1e-6, 0.05));
    }
}

/* The robust search still takes three points at a time. */
static void test_wrong_points_are_told(void)
{
    test_rng rng = test_seed(504);
    uint8_t inliers[N_MAX];
    size_t n_inliers;
    problem p;

    random_problem(&p, &rng, N_MAX, TEST_GENERAL);
    p.o[3].uv[0] += 60;
    p.o[7].uv[1] -= 45;
    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_solve(p.poses, RIGCAL_POSES_MAX, &p.n_found,
                                                 inliers, &n_inliers, NULL,
                                                 &VIEW(&p.camera, p.o, NULL, N_MAX), NULL));
    TEST_ASSERT_EQUAL_UINT(N_MAX - 2, n_inliers);
    TEST_ASSERT_EQUAL_INT(0, inliers[3]);
    TEST_ASSERT_EQUAL_INT(0, inliers[7]);
}

/* The pose no longer looks for mirrored points. Its error and the diagnosis still show
 * them. */
static void test_mirrored_coordinates_are_still_told(void)
{
    enum { POINTS = 10 };
    test_rng rng = test_seed(506);
    int named = 0;

    for (int trial = 0; trial < 40; trial++) {
        rigcal_diagnosis diagnosis;
        rigcal_pose_options options;
        problem p;

        do {
            random_problem(&p, &rng, POINTS, TEST_GENERAL);
        } while (p.scene.Z[0] > 5);
        for (int i = 0; i < POINTS; i++) {
            p.o[i].X_w[0] = -p.o[i].X_w[0];
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_pose_defaults(&options));
        options.sigma_px = RC(0.5);
        const rigcal_status status = solve(&p, POINTS, &options);
        TEST_ASSERT_TRUE(status == RIGCAL_POOR_FIT || status == RIGCAL_ERR_NO_POSE);
        TEST_ASSERT_TRUE(rigcal_pose_diagnose(&diagnosis, NULL,
                                              &VIEW(&p.camera, p.o, NULL, POINTS),
                                              &options) >= 0);
        named += diagnosis.verdict == RIGCAL_DIAGNOSIS_MIRRORED;
    }
    TEST_ASSERT_GREATER_OR_EQUAL_INT(36, named);
}

TEST_MAIN()
{
    RUN_TEST(test_a_fisheye_is_no_camera);
    RUN_TEST(test_three_different_points_are_too_few);
    RUN_TEST(test_a_ray_80_degrees_off_the_axis_is_refused_by_name);
    RUN_TEST(test_other_poses_are_found_as_ever);
    RUN_TEST(test_mirrored_coordinates_are_still_told);
    RUN_TEST(test_wrong_points_are_told);
}
