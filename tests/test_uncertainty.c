/* uncertainty: how accurate a pose is, compared with the vectors, with differences, and
 * with the scatter of many solved scenes. */
#include <math.h>
#include <string.h>

#include "test_problem.h"
#include "vectors_camera.h"
#include "vectors_refine.h"
#include "vectors_scenes.h"

static const double NOISE = 0.5; /* px */

static void assert_covariance(const double golden[21], double scale,
                              const rigcal_pose_uncertainty *u, double tol)
{
    for (int k = 0; k < 36; k++) {
        const double size =
            sqrt(test_lower(golden, k / 6, k / 6) * test_lower(golden, k % 6, k % 6));

        ASSERT_NEAR(scale * test_lower(golden, k / 6, k % 6), u->Sigma[k],
                    tol * scale * size);
    }
    for (int k = 0; k < 3; k++) {
        const double w = sqrt(scale * test_lower(golden, k, k));
        const double dt = sqrt(scale * test_lower(golden, 3 + k, 3 + k));

        ASSERT_NEAR(w, u->rotation[k], tol * w);
        ASSERT_NEAR(dt, u->translation[k], tol * dt);
    }
}

static void test_covariances_are_those_of_the_oracle(void)
{
    const double f = 800, sigma_px = 0.25;

    for (int i = 0; i < REFINE_PINHOLE_ROWS; i++) {
        const double *v = REFINE_PINHOLE[i], *s = SCENE[(int)v[0]];
        const size_t n = (size_t)v[1];
        const rigcal_transform pose = test_transform(v + 2, v + 11);
        rigcal_camera camera = test_pinhole();
        rigcal_observation o[6];
        rigcal_pose_uncertainty u;
        double noise;

        camera.cx = camera.cy = 0;
        for (size_t k = 0; k < n; k++) {
            test_to_real(o[k].X_w, s + 3 * k, 3);
            o[k].uv[0] = RC(f * s[18 + 2 * k]);
            o[k].uv[1] = RC(f * s[19 + 2 * k]);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_pose_covariance(&u, &VIEW(&camera, o, NULL, n),
                                                        &pose, RC(sigma_px)));
        ASSERT_NEAR(sigma_px, u.sigma_px, 1e-6 * sigma_px);
        assert_covariance(v + 15, sigma_px * sigma_px / (f * f), &u, TOL(1e-8, 2e-2));
        /* estimated */
        noise = f * sqrt(v[14] / (2 * v[1] - 6));
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_pose_covariance(&u, &VIEW(&camera, o, NULL, n), &pose, 0));
        ASSERT_NEAR(noise, u.sigma_px, TOL(1e-7, 5e-2) * noise);
    }
}

static void test_covariances_of_any_lens_are_those_of_the_vectors(void)
{
    for (int i = 0; i < REFINE_LENS_ROWS; i++) {
        const double *v = REFINE_LENS[i], *minimum = v + 2 + 6 * 8 + 6;
        const rigcal_camera camera = test_camera(CAMERA[(int)v[0]]);
        const rigcal_transform pose = test_transform(minimum, minimum + 9);
        const size_t n = (size_t)v[1];
        rigcal_pose_uncertainty u;
        rigcal_observation o[8];
        rigcal_real sigma[8];

        for (size_t k = 0; k < n; k++) {
            test_to_real(o[k].X_w, v + 2 + 6 * k, 3);
            test_to_real(o[k].uv, v + 5 + 6 * k, 2);
            sigma[k] = RC(v[7 + 6 * k]);
        }
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_pose_covariance(&u, &VIEW(&camera, o, sigma, n), &pose, 2));
        assert_covariance(minimum + 13, 4, &u, TOL(1e-8, 2e-2));
    }
}

/* The standard deviation of the centre is that of -R^T t for the covariance of (w, dt), by
 * differences. */
static void test_the_deviation_of_the_centre_follows(void)
{
    test_rng rng = test_seed(80);

    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        const double h = 1e-6;
        double J[3][6], Sigma[36];
        rigcal_pose_uncertainty u;
        rigcal_transform pose;
        test_problem p;

        test_random_problem(&p, &rng, 8, (test_shape)(trial % 3));
        pose = test_transform(p.scene.R, p.scene.t);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_pose_covariance(&u, &VIEW(&p.camera, p.o, NULL, 8), &pose, 1));
        test_to_double(Sigma, u.Sigma, 36);
        for (int k = 0; k < 6; k++) {
            double side[2][3];

            for (int s = 0; s < 2; s++) {
                double R[9], t[3], Rt[9], d[6] = {0, 0, 0, 0, 0, 0};

                memcpy(R, p.scene.R, sizeof R);
                memcpy(t, p.scene.t, sizeof t);
                d[k] = s ? h : -h;
                test_move(R, t, d);
                test_transpose(Rt, R);
                test_apply(side[s], Rt, t, NULL);
            }
            for (int r = 0; r < 3; r++) {
                J[r][k] = (side[0][r] - side[1][r]) / (2 * h);
            }
        }
        for (int r = 0; r < 3; r++) {
            double variance = 0;

            for (int k = 0; k < 36; k++) {
                variance += J[r][k / 6] * Sigma[k] * J[r][k % 6];
            }
            ASSERT_NEAR(sqrt(variance), u.center[r], TOL(1e-6, 5e-2) * sqrt(variance));
        }
    }
}

/* 95 % of the ellipsoids must hold the truth. The estimated noise must be the true
 * noise. */
static void test_the_covariance_holds_the_truth_as_often_as_it_says(void)
{
    enum { TRIALS = 2000 };
    const double chi2_of_6_at_95 = 12.5916;
    const rigcal_pose_options options = test_options(NOISE);
    test_rng rng = test_seed(81);
    double noise2 = 0;
    int held = 0;

    TEST_ON_HOST_ONLY("a rate wants all scenes");
    for (int trial = 0; trial < TRIALS; trial++) {
        double R[9], t[3], d[6], Sigma[36];
        rigcal_pose_uncertainty u;
        test_problem p;

        test_random_problem(&p, &rng, 8, TEST_GENERAL);
        test_add_noise(&p, &rng, NOISE);
        TEST_ASSERT_TRUE(test_solve_pose(&p, &options) >= 0);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_pose_covariance(&u, &VIEW(&p.camera, p.o, NULL, 8),
                                             &p.poses[0].cam_from_world, RC(NOISE)));
        test_transform_parts(R, t, &p.poses[0].cam_from_world);
        test_difference(d, R, t, p.scene.R, p.scene.t);
        test_to_double(Sigma, u.Sigma, 36);
        held += test_squared_distance(d, Sigma, 6) < chi2_of_6_at_95;
        ASSERT_STATUS(RIGCAL_OK, rigcal_pose_covariance(&u, &VIEW(&p.camera, p.o, NULL, 8),
                                                        &p.poses[0].cam_from_world, 0));
        noise2 += D(u.sigma_px) * D(u.sigma_px) / TRIALS;
    }
    TEST_ASSERT_TRUE(held >= TRIALS * 93.5 / 100);
    TEST_ASSERT_TRUE(held <= TRIALS * 96.5 / 100);
    ASSERT_NEAR(NOISE * NOISE, noise2, 0.03 * NOISE * NOISE);
}

static void test_a_covariance_that_does_not_exist_is_refused_by_name(void)
{
    rigcal_pose_uncertainty u;
    rigcal_transform pose;
    test_rng rng = test_seed(82);
    test_problem p;

    test_random_problem(&p, &rng, 6, TEST_GENERAL);
    pose = test_transform(p.scene.R, p.scene.t);
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_pose_covariance(&u, &VIEW(&p.camera, p.o, NULL, 3), &pose, 1));
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, u,
                   rigcal_pose_covariance(&u, &VIEW(&p.camera, p.o, NULL, 3), &pose, 0));
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, u,
                   rigcal_pose_covariance(&u, &VIEW(&p.camera, p.o, NULL, 2), &pose, 1));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, u,
                   rigcal_pose_covariance(&u, &VIEW(&p.camera, p.o, NULL, 6), &pose, -1));
    ASSERT_REFUSED(
        RIGCAL_ERR_NOT_FINITE, u,
        rigcal_pose_covariance(&u, &VIEW(&p.camera, p.o, NULL, 6), &pose, TEST_NAN));
    pose.t[2] = -pose.t[2] - 10;
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, u,
                   rigcal_pose_covariance(&u, &VIEW(&p.camera, p.o, NULL, 6), &pose, 1));
    pose = test_transform(p.scene.R, p.scene.t);
    for (int i = 0; i < 6; i++) { /* all on one line */
        for (int k = 0; k < 3; k++) {
            p.scene.X[i][k] = 0.25 * i * (k == 0) + p.scene.X[0][k];
        }
    }
    test_observe(&p);
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, u,
                   rigcal_pose_covariance(&u, &VIEW(&p.camera, p.o, NULL, 6), &pose, 1));
}

/* The points and the camera are so far from the origin that rounding nearly destroys the
 * shape. These points are exact there, so the rotation is as sure as at the origin. */
static void test_far_from_the_origin_the_turns_are_as_sure(void)
{
    const double far = TOL(1099511627776.0, 2048); /* 2^40, 2^11 */
    const rigcal_camera camera = test_pinhole();
    rigcal_pose_uncertainty u[2];

    for (int k = 0; k < 2; k++) {
        const double t[3] = {-k * far, 0.25, 4};
        const rigcal_transform pose = test_transform(NULL, t);
        rigcal_observation o[5];

        for (int i = 0; i < 5; i++) {
            const double X[3] = {(i % 2 - 0.5) * (1 + 0.25 * i), (i / 2 - 1) * 0.5, i % 3};
            const double X_c[3] = {X[0], X[1] + 0.25, X[2] + 4};
            const double there[3] = {X[0] + k * far, X[1], X[2]};
            double uv[2];

            test_project_px(uv, &camera, X_c);
            test_to_real(o[i].X_w, there, 3);
            test_to_real(o[i].uv, uv, 2);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_pose_covariance(&u[k], &VIEW(&camera, o, NULL, 5),
                                                        &pose, RC(0.5)));
    }
    for (int i = 0; i < 3; i++) {
        ASSERT_NEAR(D(u[0].rotation[i]), u[1].rotation[i],
                    TOL(1e-9, 1e-3) * D(u[0].rotation[i]));
    }
}

/* If the camera is on the cylinder through three points, upright on their plane, it can
 * move a little without a change of their pixels: the danger cylinder of three points. */
static void test_on_the_danger_cylinder_of_three_points_there_is_no_covariance(void)
{
    const rigcal_camera camera = test_pinhole();
    rigcal_pose_uncertainty out;
    int n_refused = 0;

    for (int k = 0; k < 20; k++) {
        const double turn = 0.3 + 0.31 * k;
        const double centre[3] = {cos(turn), sin(turn), -2};
        const double t[3] = {-centre[0], -centre[1], -centre[2]};
        const rigcal_transform cam_from_world = test_transform(NULL, t);
        rigcal_observation o[3];

        for (int i = 0; i < 3; i++) {
            const double X[3] = {cos(2.1 * i), sin(2.1 * i), 0};
            double X_c[3], uv[2];

            test_apply(X_c, (const double[9]){1, 0, 0, 0, 1, 0, 0, 0, 1}, X, t);
            test_project_px(uv, &camera, X_c);
            test_to_real(o[i].X_w, X, 3);
            test_to_real(o[i].uv, uv, 2);
        }
        const rigcal_view view = VIEW(&camera, o, NULL, 3);
        const rigcal_status status =
            rigcal_pose_covariance(&out, &view, &cam_from_world, RC(0.5));

        if (status == RIGCAL_ERR_DEGENERATE) {
            n_refused++;
        } else { /* by rounding it is beside the cylinder: then almost nothing is known */
            ASSERT_STATUS(RIGCAL_OK, status);
            TEST_ASSERT_TRUE(D(out.center[0]) + D(out.center[1]) + D(out.center[2]) > 10);
        }
    }
    TEST_ASSERT_TRUE(n_refused > 0);
}

TEST_MAIN()
{
    RUN_TEST(test_covariances_are_those_of_the_oracle);
    RUN_TEST(test_covariances_of_any_lens_are_those_of_the_vectors);
    RUN_TEST(test_the_deviation_of_the_centre_follows);
    RUN_TEST(test_the_covariance_holds_the_truth_as_often_as_it_says);
    RUN_TEST(test_a_covariance_that_does_not_exist_is_refused_by_name);
    RUN_TEST(test_far_from_the_origin_the_turns_are_as_sure);
    RUN_TEST(test_on_the_danger_cylinder_of_three_points_there_is_no_covariance);
}
