/* target: views of a target that is carried about, and of one that stays. The truth: the
 * joint least squares with the target's own unknowns, dense and in double; also simulated
 * rigs. */
#include <math.h>
#include <string.h>

#include "test_watched.h"

static const double DEGREE = TEST_PI / 180, NOISE = 0.3;

enum { POINTS = 8 };

static test_watched w;
static double X_w[POINTS][3];

#define WANTS_RIG() TEST_WANTS_RAM(sizeof w + 30000)

/* A target with points in a box. */
static void hang(test_rng *rng, double shift)
{
    test_watched_hang(&w, rng, 0, shift);
    for (int i = 0; i < POINTS; i++) {
        for (int k = 0; k < 3; k++) {
            X_w[i][k] = D((rigcal_real)test_uniform(rng, -0.3, 0.3));
        }
    }
}

/* Begins a monitor of two cameras, and a target that it does not know yet. */
static void begin_pair(test_rng *rng)
{
    test_watched_make(&w, rng, 2, 1, 0.05 * DEGREE, 2e-3);
    test_watched_begin(&w, 1, NULL);
    hang(rng, 0.1);
}

static void see(rigcal_observation o[POINTS], int camera, test_rng *rng, double noise)
{
    test_watched_see(o, &w, camera, 0, X_w, POINTS, rng, noise);
}

static void show(int camera, test_rng *rng, double noise)
{
    rigcal_observation o[POINTS];
    int32_t at_fault = -2;

    see(o, camera, rng, noise);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_view(w.monitor, &at_fault, (size_t)camera, 0, o,
                                                 POINTS, RC(NOISE)));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
}

/* ---- a placement, against the joint least squares ------------------------------------ */

enum { JOINT = 6 * 3 }; /* cameras 1 and 2, and the target */

static void add_rows(double A[JOINT][JOINT], double g[JOINT], int camera,
                     const rigcal_observation *o, const double R[9], const double t[3],
                     const double T[9], const double s[3])
{
    double in_rig[3], q[3], p[3], J[2][JOINT];
    const double X[3] = {D(o->X_w[0]), D(o->X_w[1]), D(o->X_w[2])};

    test_apply(in_rig, T, X, s); /* rig_from_target */
    test_apply(q, R, in_rig, NULL);
    test_apply(p, R, in_rig, t);
    const double B[2][3] = {{800 / p[2], 0, -800 * p[0] / (p[2] * p[2])},
                            {0, 800 / p[2], -800 * p[1] / (p[2] * p[2])}};
    memset(J, 0, sizeof J);
    for (int k = 0; k < 2; k++) {
        double turned[3], b[3],
            from[3] = {in_rig[0] - s[0], in_rig[1] - s[1], in_rig[2] - s[2]};
        double Rt[9];

        test_cross(turned, q, B[k]);
        test_transpose(Rt, R);
        test_apply(b, Rt, B[k], NULL);
        for (int i = 0; i < 3; i++) {
            if (camera > 0) {
                J[k][6 * (camera - 1) + i] = turned[i] / NOISE;
                J[k][6 * (camera - 1) + 3 + i] = B[k][i] / NOISE;
            }
            J[k][12 + 3 + i] = b[i] / NOISE;
        }
        test_cross(turned, from, b);
        for (int i = 0; i < 3; i++) {
            J[k][12 + i] = turned[i] / NOISE;
        }
        const double r = (D(o->uv[k]) - (k == 0 ? 640 : 480) - 800 * p[k] / p[2]) / NOISE;
        for (int i = 0; i < JOINT; i++) {
            g[i] += J[k][i] * r;
            for (int j = 0; j < JOINT; j++) {
                A[i][j] += J[k][i] * J[k][j];
            }
        }
    }
}

/* A^-1 by elimination, and x = A^-1 g. */
static void invert(double inverse[JOINT][JOINT], double x[JOINT], double A[JOINT][JOINT],
                   const double g[JOINT])
{
    for (int i = 0; i < JOINT; i++) {
        for (int j = 0; j < JOINT; j++) {
            inverse[i][j] = i == j;
        }
    }
    for (int k = 0; k < JOINT; k++) {
        const double pivot = A[k][k];
        for (int j = 0; j < JOINT; j++) {
            A[k][j] /= pivot;
            inverse[k][j] /= pivot;
        }
        for (int i = 0; i < JOINT; i++) {
            const double by = A[i][k];
            for (int j = 0; j < JOINT && i != k; j++) {
                A[i][j] -= by * A[k][j];
                inverse[i][j] -= by * inverse[k][j];
            }
        }
    }
    for (int i = 0; i < JOINT; i++) {
        x[i] = 0;
        for (int j = 0; j < JOINT; j++) {
            x[i] += inverse[i][j] * g[j];
        }
    }
}

/* The true noise of the pixels is so small that all is linear. The stated noise is not. */
static void test_rows_of_a_placement_give_the_joint_least_squares(void)
{
    const double tiny = TOL(1e-5, 1e-2);

    if (WATCHED_CAMERAS_MAX < 3) {
        TEST_IGNORE_MESSAGE("wants three cameras");
    }
    for (int trial = 0; trial < TEST_TRIALS(10); trial++) {
        test_rng rng = test_seed(10 + (uint64_t)trial);
        rigcal_observation o[3][POINTS];
        double A[JOINT][JOINT], P[JOINT][JOINT], g[JOINT], x[JOINT], T[9], s[3];
        rigcal_monitor_options options;
        rigcal_transform before[3];

        (void)rigcal_monitor_defaults(&options);
        options.wrong = 0;
        test_watched_make(&w, &rng, 3, 0, 1e-9, 1e-9);
        for (int i = 0; i < 12; i++) {
            w.Sigma[i * (i + 3) / 2] = i % 6 < 3 ? RC(1e-6) : RC(4e-6);
        }
        test_watched_begin(&w, 1, &options);
        hang(&rng, 0.1);
        memset(A, 0, sizeof A);
        memset(g, 0, sizeof g);
        for (int i = 0; i < 12; i++) {
            A[i][i] = 1 / D(w.Sigma[i * (i + 3) / 2]);
        }
        test_transpose(T, w.truth[3].R);
        test_apply(s, T, w.truth[3].t, NULL);
        for (int k = 0; k < 3; k++) {
            s[k] = -s[k];
        }
        for (int c = 0; c < 3; c++) {
            double R[9], t[3];

            see(o[c], c, &rng, tiny);
            ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_view(w.monitor, NULL, (size_t)c, 0,
                                                         o[c], POINTS, RC(NOISE)));
            before[c] = w.cameras[c].cam_from_rig;
            test_transform_parts(R, t, &before[c]);
            for (int i = 0; i < POINTS; i++) {
                add_rows(A, g, c, &o[c][i], R, t, T, s);
            }
        }
        invert(P, x, A, g);
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_rig(&w.rig, w.monitor));
        for (int i = 0; i < 12; i++) {
            for (int j = 0; j <= i; j++) {
                const double scale = sqrt(P[i][i] * P[j][j]);
                ASSERT_NEAR(P[i][j] / scale, D(w.Sigma[i * (i + 1) / 2 + j]) / scale,
                            TOL(1e-6, 2e-2));
            }
        }
        /* and the poses */
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, 0));
        for (int i = 0; i < 12; i++) {
            rigcal_mounted_camera m;
            const int camera = 1 + i / 6;
            double R[9], t[3], R0[9], t0[3], Rt[9], turn[9];

            ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&m, w.monitor, (size_t)camera));
            test_transform_parts(R, t, &m.cam_from_rig);
            test_transform_parts(R0, t0, &before[camera]);
            test_transpose(Rt, R0);
            test_product(turn, R, Rt);
            const double d[6] = {(turn[7] - turn[5]) / 2,
                                 (turn[2] - turn[6]) / 2,
                                 (turn[3] - turn[1]) / 2,
                                 t[0] - t0[0],
                                 t[1] - t0[1],
                                 t[2] - t0[2]};
            ASSERT_NEAR(x[i] / sqrt(P[i][i]), d[i % 6] / sqrt(P[i][i]), TOL(1e-6, 0.02));
        }
    }
}

/* ---- a target that is carried about ----------------------------------------------------
 * */

static double base_sd(void)
{
    rigcal_transform b_from_a;
    rigcal_real Sigma[36];

    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_pair(&b_from_a, Sigma, w.monitor, 0, 1));
    return sqrt(D(Sigma[21])); /* t_x */
}

static void test_a_carried_target_tells_the_length_of_a_base(void)
{
    const int rigs = 40;
    int inside = 0;

    TEST_ON_HOST_ONLY("a rate");
    for (int r = 0; r < rigs; r++) {
        test_rng rng = test_seed(100 + (uint64_t)r);
        rigcal_monitor_options o;
        double e[WATCHED_FREE_MAX];

        (void)rigcal_monitor_defaults(&o);
        o.arl0_frames = RC(1e9);
        test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
        test_watched_begin(&w, 1, &o);
        for (int placement = 0; placement < 10; placement++) {
            hang(&rng, test_uniform(&rng, -0.5, 0.5));
            show(placement % 2, &rng, NOISE);
            show(1 - placement % 2, &rng, NOISE);
            ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, 0));
            ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_lifted(w.monitor, 0));
        }
        TEST_ASSERT_TRUE(base_sd() < 1.5e-3); /* from 2e-3 */
        inside += test_watched_nees(&w, e) < test_chi2_95(6);
    }
    TEST_ASSERT_TRUE(inside >= 34);
}

static void test_a_target_that_was_lifted_has_no_place(void)
{
    test_rng rng = test_seed(200);
    rigcal_transform b_from_a;
    rigcal_real Sigma[36];

    WANTS_RIG();
    begin_pair(&rng);
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_pair(&b_from_a, Sigma, w.monitor, 0, 2));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_moved(w.monitor, 2));
    show(0, &rng, 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_pair(&b_from_a, Sigma, w.monitor, 0, 2));
    const rigcal_transform expected = test_transform(w.truth[2].R, w.truth[2].t);
    ASSERT_TRANSFORM(&expected, &b_from_a, TOL(1e-6, 2e-3), TOL(1e-5, 5e-3));
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_lifted(w.monitor, 0));
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_lifted(w.monitor, 0));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_pair(&b_from_a, Sigma, w.monitor, 0, 2));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_lifted(w.monitor, 1));
}

/* ---- a target that stays ----------------------------------------------------------------
 * */

static void test_a_target_that_stays_tells_which_of_two_cameras_moved(void)
{
    static const double SHIFTS[3] = {0.05, 0.005, 0};
    const int trials = 18;

    TEST_ON_HOST_ONLY("time");
    for (int r = 0; r < trials; r++) {
        test_rng rng = test_seed(300 + (uint64_t)r);
        const watched_matches like = {20, NOISE, 0.1, 1};
        rigcal_monitor_options o;
        rigcal_monitor_report report;
        const int body = r % 3;
        const double shift = body < 2 ? 0 : SHIFTS[r / 3 % 3]; /* targets shift more */
        const double turn = body < 2 || shift > 0 ? 0.003 : 0.01;
        const double d[6] = {turn * (r % 2 ? 1 : -1), 0.002, 0.002, shift, -shift, shift};

        (void)rigcal_monitor_defaults(&o);
        o.arl0_frames = RC(1e4);
        test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
        test_watched_begin(&w, 1, &o);
        hang(&rng, 0.1);
        for (int f = 0; f < 80; f++) {
            if (f == 50) {
                test_watched_bump(&w, body, d);
            }
            test_watched_match(&w, &rng, &like);
            show(0, &rng, NOISE);
            show(1, &rng, NOISE);
            ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(&report, w.monitor, RC(0.03)));
            TEST_ASSERT_TRUE(f >= 50 || !report.alarm);
        }
        TEST_ASSERT_EQUAL_INT32(1, report.alarm);
        TEST_ASSERT_EQUAL_INT32(body, report.body);
        TEST_ASSERT_TRUE(report.confidence > RC(0.9));
    }
}

/* ---- what is refused
 * ---------------------------------------------------------------------- */

static void test_views_that_cannot_be_are_refused_and_change_nothing(void)
{
    static rigcal_real kept[RIGCAL_MONITOR_SIZE(2, 1)];
    test_rng rng = test_seed(400);
    rigcal_observation o[POINTS];
    int32_t at_fault = 0;

    TEST_WANTS_RAM(sizeof w + 40000);
    begin_pair(&rng);
    see(o, 0, &rng, 0);
    memcpy(kept, w.monitor, sizeof kept);
    ASSERT_STATUS(RIGCAL_ERR_TOO_FEW,
                  rigcal_monitor_view(w.monitor, &at_fault, 0, 0, o, 2, 1));
    ASSERT_STATUS(RIGCAL_ERR_TOO_FEW,
                  rigcal_monitor_view(w.monitor, &at_fault, 0, 0, o, 0, 1));
    ASSERT_STATUS(RIGCAL_ERR_RANGE,
                  rigcal_monitor_view(w.monitor, &at_fault, 2, 0, o, POINTS, 1));
    ASSERT_STATUS(RIGCAL_ERR_RANGE,
                  rigcal_monitor_view(w.monitor, &at_fault, 0, 1, o, POINTS, 1));
    o[3].uv[1] = TEST_NAN;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE,
                  rigcal_monitor_view(w.monitor, &at_fault, 0, 0, o, POINTS, 1));
    TEST_ASSERT_EQUAL_INT32(3, at_fault);
    TEST_ASSERT_EQUAL_MEMORY(kept, w.monitor, sizeof kept);
    show(0, &rng, 0);
    memcpy(kept, w.monitor, sizeof kept);
    for (int i = 0; i < POINTS; i++) {
        see(o, 1, &rng, 0);
        o[i].uv[0] = TEST_INF;
        ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE,
                      rigcal_monitor_view(w.monitor, &at_fault, 1, 0, o, POINTS, 1));
        TEST_ASSERT_EQUAL_INT32(i, at_fault);
        see(o, 1, &rng, 0);
        o[i].X_w[0] = 0;
        o[i].X_w[1] = 0;
        o[i].X_w[2] = -20; /* behind both */
        ASSERT_STATUS(RIGCAL_ERR_BEHIND,
                      rigcal_monitor_view(w.monitor, &at_fault, 1, 0, o, POINTS, 1));
        TEST_ASSERT_EQUAL_INT32(i, at_fault);
        TEST_ASSERT_EQUAL_MEMORY(kept, w.monitor, sizeof kept);
    }
}

/* A target without a place has no pose and no share, and is blind. It is not a camera. */
static void test_a_target_without_a_place_has_no_report(void)
{
    test_rng rng = test_seed(201);
    rigcal_mounted_camera m;
    rigcal_body_report report;

    WANTS_RIG();
    begin_pair(&rng);
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_camera(&m, w.monitor, 2));
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_body(&report, w.monitor, 2));
    TEST_ASSERT_TRUE(report.is_blind != 0);
    ASSERT_NEAR(0, report.share, 0);
    ASSERT_NEAR(0, report.smallest_rad, 0);
    show(0, &rng, 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_body(&report, w.monitor, 2));
    TEST_ASSERT_TRUE(report.weakest_sigma > 0);
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, m, rigcal_monitor_camera(&m, w.monitor, 2));
}

/* A square far away has two poses that fit. */
static void test_a_view_of_two_poses_places_nothing(void)
{
    static const double SIDE[4][2] = {{-1, 1}, {1, 1}, {1, -1}, {-1, -1}};
    static const double axis[3] = {1, 0.3, 0};
    test_rng rng = test_seed(202);
    rigcal_observation o[4];
    rigcal_transform b_from_a;
    rigcal_real Sigma[36];
    double R[9];
    int32_t at_fault = 0;

    WANTS_RIG();
    test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
    test_watched_begin(&w, 1, NULL);
    test_rotation_about(R, axis, 0.5);
    for (int i = 0; i < 4; i++) {
        const double X[3] = {0.02 * SIDE[i][0], 0.02 * SIDE[i][1], 0}, far[3] = {0, 0, 3};
        double X_c[3], uv[2];

        test_apply(X_c, R, X, far);
        test_project_px(uv, &w.cameras[0].camera, X_c);
        test_to_real(o[i].X_w, X, 3);
        test_to_real(o[i].uv, uv, 2);
    }
    ASSERT_STATUS(RIGCAL_AMBIGUOUS,
                  rigcal_monitor_view(w.monitor, &at_fault, 0, 0, o, 4, RC(NOISE)));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_pair(&b_from_a, Sigma, w.monitor, 0, 2));
}

/* A target of three points is seen from their danger cylinder. It has two poses, or one
 * that the view hardly fixes. Some of these have no covariance, to rounding. */
static void test_a_pose_without_a_covariance_places_nothing(void)
{
    test_rng rng = test_seed(204);
    int n_refused = 0;

    WANTS_RIG();
    begin_pair(&rng);
    for (int k = 0; k < 60; k++) {
        const double turn = 0.3 + 0.19 * k;
        rigcal_observation o[3];
        int32_t at_fault;

        for (int i = 0; i < 3; i++) {
            const double X[3] = {cos(2.9 * i), sin(2.9 * i), 0};
            const double X_c[3] = {X[0] - cos(turn), X[1] - sin(turn), 4};
            double uv[2];

            test_project_px(uv, &w.cameras[0].camera, X_c);
            test_to_real(o[i].X_w, X, 3);
            test_to_real(o[i].uv, uv, 2);
        }
        const rigcal_status status =
            rigcal_monitor_view(w.monitor, &at_fault, 0, 0, o, 3, RC(NOISE));
        n_refused += status == RIGCAL_ERR_DEGENERATE || status == RIGCAL_VAGUE;
        TEST_ASSERT_TRUE(status == RIGCAL_ERR_DEGENERATE || status == RIGCAL_VAGUE ||
                         status == RIGCAL_AMBIGUOUS);
        ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_moved(w.monitor, 2)); /* no place */
    }
    TEST_ASSERT_TRUE(n_refused > 0);
}

/* The pose leaves out a pixel of which the lens has no ray. Its point is behind the camera
 * here, so the view has no covariance. */
static void test_a_view_without_a_covariance_places_nothing(void)
{
    static const double far[3] = {0.1, -0.1, 2.5};
    test_rng rng = test_seed(205);
    rigcal_observation o[POINTS];
    rigcal_camera *const camera = &w.cameras[0].camera;
    int32_t at_fault = -2;

    WANTS_RIG();
    test_watched_make(&w, &rng, 2, 1, 0.05 * DEGREE, 2e-3);
    camera->k1 = RC(-0.3); /* folds 622 px from the middle */
    test_watched_begin(&w, 1, NULL);
    for (int i = 0; i < POINTS; i++) {
        double X[3], X_c[3], uv[2];

        for (int k = 0; k < 3; k++) {
            X[k] = test_uniform(&rng, -0.3, 0.3);
            X_c[k] = X[k] + far[k];
        }
        test_project_px(uv, camera, X_c);
        test_to_real(o[i].X_w, X, 3);
        test_to_real(o[i].uv, uv, 2);
    }
    o[3].X_w[2] = -4;
    o[3].uv[0] = RC(D(camera->cx) + 1500);
    ASSERT_STATUS(RIGCAL_ERR_BEHIND,
                  rigcal_monitor_view(w.monitor, &at_fault, 0, 0, o, POINTS, RC(NOISE)));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_moved(w.monitor, 2)); /* no place */
}

/* While an alarm waits for its answer the poses of the cameras are in doubt, so a target
 * gets no place. */
static void test_a_target_gets_no_place_while_an_alarm_waits(void)
{
    const watched_matches like = {60, 0.3, 0, 0};
    const double d[6] = {0, 2 * DEGREE, 0.5 * DEGREE, 0, 0, 0};
    test_rng rng = test_seed(203);
    rigcal_monitor_report report = {0};
    rigcal_observation o[POINTS];
    int32_t at_fault = 0;

    WANTS_RIG();
    begin_pair(&rng);
    for (int f = 0; f < 330 && !report.alarm; f++) {
        test_watched_match(&w, &rng, &like);
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(&report, w.monitor, RC(0.03)));
        if (f == 30) {
            test_watched_bump(&w, 1, d);
        }
    }
    TEST_ASSERT_EQUAL_INT32(1, report.alarm);
    see(o, 0, &rng, 0);
    ASSERT_STATUS(RIGCAL_ERR_STATE,
                  rigcal_monitor_view(w.monitor, &at_fault, 0, 0, o, POINTS, RC(NOISE)));
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_dismiss(w.monitor));
    show(0, &rng, 0);
}

/* A target that moved and was then lifted has no place at which to settle. */
static void test_a_target_that_settles_may_be_lifted(void)
{
    test_rng rng = test_seed(204);
    rigcal_transform b_from_a;
    rigcal_real Sigma[36];

    WANTS_RIG();
    begin_pair(&rng);
    show(0, &rng, 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_moved(w.monitor, 2));
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_lifted(w.monitor, 0));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_pair(&b_from_a, Sigma, w.monitor, 0, 2));
    hang(&rng, -0.2);
    show(0, &rng, 0); /* at another place, by its first view alone */
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_pair(&b_from_a, Sigma, w.monitor, 0, 2));
    const rigcal_transform expected = test_transform(w.truth[2].R, w.truth[2].t);
    ASSERT_TRANSFORM(&expected, &b_from_a, TOL(1e-6, 2e-3), TOL(1e-5, 5e-3));
}

TEST_MAIN()
{
    RUN_TEST(test_rows_of_a_placement_give_the_joint_least_squares);
    RUN_TEST(test_a_carried_target_tells_the_length_of_a_base);
    RUN_TEST(test_a_target_that_was_lifted_has_no_place);
    RUN_TEST(test_a_target_that_stays_tells_which_of_two_cameras_moved);
    RUN_TEST(test_views_that_cannot_be_are_refused_and_change_nothing);
    RUN_TEST(test_a_target_without_a_place_has_no_report);
    RUN_TEST(test_a_view_of_two_poses_places_nothing);
    RUN_TEST(test_a_pose_without_a_covariance_places_nothing);
    RUN_TEST(test_a_view_without_a_covariance_places_nothing);
    RUN_TEST(test_a_target_gets_no_place_while_an_alarm_waits);
    RUN_TEST(test_a_target_that_settles_may_be_lifted);
}
