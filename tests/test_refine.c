/* refine: equations compared with differences of the projection and with the oracle's;
 * Levenberg-Marquardt compared with minima that SciPy finds. */
#include <math.h>
#include <string.h>

#include "rc_refine.h"
#include "test_fit.h"
#include "test_problem.h"
#include "vectors_camera.h"
#include "vectors_refine.h"
#include "vectors_scenes.h"

enum { N_MAX = 8, EVALS_MAX = 60 };

static const double ZERO[3] = {0, 0, 0};

/* ---- what several tests need --------------------------------------------- */

/* A camera whose pixels are normalised coordinates. */
static rigcal_camera unit_camera(void)
{
    rigcal_camera camera = {0};

    camera.width = camera.height = 1;
    camera.fx = camera.fy = 1;
    return camera;
}

/* A problem that owns the arrays of its points. */
typedef struct {
    rigcal_camera camera;
    rigcal_observation o[N_MAX];
    rigcal_real sigma[N_MAX];
    rigcal_points points;
} problem;

/* Prepares the points, which count from an origin that the test chooses. */
static void ready(problem *p, int n, int weighted, const double origin[3])
{
    rigcal_real uv_middle[2];
    int32_t at_fault;

    rc_points_of(&p->points, &VIEW(&p->camera, p->o, weighted ? p->sigma : NULL, n), NULL);
    ASSERT_STATUS(RIGCAL_OK, rc_points_survey(&p->points, uv_middle, &at_fault));
    test_to_real(p->points.origin, origin, 3);
}

static test_data data_of(const problem *p)
{
    const test_data data = {&p->camera, p->o, p->points.view.sigma, (int)p->points.view.n};

    return data;
}

/* The first n points of a scene of the vectors, normalised. */
static void of_scene(problem *p, const double *scene, int n)
{
    p->camera = unit_camera();
    for (int i = 0; i < n; i++) {
        test_to_real(p->o[i].X_w, scene + 3 * i, 3);
        test_to_real(p->o[i].uv, scene + 18 + 2 * i, 2);
    }
    ready(p, n, 0, ZERO);
}

/* A row of REFINE_LENS. Its points count from their mean. */
static void of_lens(problem *p, const double *v)
{
    const int n = (int)v[1];
    double middle[3] = {0, 0, 0};

    p->camera = test_camera(CAMERA[(int)v[0]]);
    for (int i = 0; i < n; i++) {
        const double *point = v + 2 + 6 * i;

        test_to_real(p->o[i].X_w, point, 3);
        test_to_real(p->o[i].uv, point + 3, 2);
        p->sigma[i] = RC(point[5]);
        for (int k = 0; k < 3; k++) {
            middle[k] += point[k] / n;
        }
    }
    ready(p, n, 1, middle);
}

static const double *start_of(const double *v)
{
    return v + 2 + 6 * N_MAX;
}

static const double *minimum_of(const double *v)
{
    return start_of(v) + 6;
}

static const double *covariance_of(const double *v)
{
    return minimum_of(v) + 13;
}

/* The cam_from_points of a cam_from_world. */
static rigcal_transform from_points(const problem *p, const double R[9], const double t[3])
{
    double origin[3], shifted[3];

    test_to_double(origin, p->points.origin, 3);
    test_apply(shifted, R, origin, t);
    return test_transform(R, shifted);
}

static void to_world(double R[9], double t[3], const problem *p,
                     const rigcal_transform *cam_from_points)
{
    double origin[3], turned[3];

    test_transform_parts(R, t, cam_from_points);
    test_to_double(origin, p->points.origin, 3);
    test_apply(turned, R, origin, NULL);
    for (int k = 0; k < 3; k++) {
        t[k] -= turned[k];
    }
}

static rigcal_transform start_pose(const problem *p, const double *v)
{
    const double *s = start_of(v);
    double R[9];

    test_rotation(R, s[0], s[1], s[2]);
    return from_points(p, R, s + 3);
}

/* Refines to the end. Returns the number of evaluations. The sum must never rise. */
static int run(rigcal_refinement *state, const problem *p, const rigcal_transform *start)
{
    int calls = 0;
    double least = 1e300;

    state->cam_from_points = *start;
    rc_refine_begin(state, 0);
    ASSERT_STATUS(RIGCAL_RUNNING, state->search.status);
    while (state->search.status == RIGCAL_RUNNING) {
        rc_refine_step(state, &p->points, EVALS_MAX);
        TEST_ASSERT_LESS_OR_EQUAL_INT(EVALS_MAX, ++calls);
        if (state->search.status >= 0) {
            TEST_ASSERT_TRUE(D(state->search.sum) <=
                             least * (1 + TOL(1e-12, 1e-5)) + TOL(1e-18, 1e-8));
            least = D(state->search.sum);
        }
    }
    return calls;
}

/* ---- the equations ------------------------------------------------------- */

static rigcal_status equations(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                               const problem *p, const rigcal_transform *pose, int kind)
{
    return rc_refine_equations(sum, g, H, &p->points, p->points.view.n, pose, kind);
}

/* The equations with which a search begins. It may make them by other, faster code. */
static void begin_search(rigcal_refinement *state, const problem *p,
                         const rigcal_transform *pose, int kind)
{
    state->cam_from_points = *pose;
    rc_refine_begin(state, 0);
    state->search.equations = (uint8_t)kind;
    rc_refine_step(state, &p->points, EVALS_MAX);
    ASSERT_STATUS(RIGCAL_RUNNING, state->search.status);
}

static void assert_equations(const double sse0, const double g0[6], const double H0[21],
                             const rigcal_real sse, const rigcal_real g[6],
                             const rigcal_real H[21], double tol)
{
    ASSERT_NEAR(sse0, sse, tol * sse0);
    for (int i = 0; i < 6; i++) {
        const double size = sqrt(test_lower(H0, i, i));

        ASSERT_NEAR(g0[i], g[i], tol * size * sqrt(sse0));
        for (int j = 0; j <= i; j++) {
            ASSERT_NEAR(test_lower(H0, i, j), test_in_blocks(H, i, j),
                        tol * size * sqrt(test_lower(H0, j, j)));
        }
    }
}

static void test_equations_are_those_of_the_oracle(void)
{
    for (int i = 0; i < REFINE_EQUATIONS_ROWS; i++) {
        const double *v = REFINE_EQUATIONS[i], *s = SCENE[(int)v[0]];
        double R[9];
        rigcal_real sse, g[6], H[21];
        rigcal_transform pose;
        problem p;

        of_scene(&p, s, (int)v[1]);
        test_rotation(R, s[36], s[37], s[38]); /* nearby */
        pose = test_transform(R, s + 33);
        ASSERT_STATUS(RIGCAL_OK, equations(&sse, g, H, &p, &pose, RC_GAUSS_NEWTON));
        assert_equations(v[2], v + 3, v + 9, sse, g, H, TOL(1e-11, 1e-4));
    }
}

/* Newton's H is half the second derivative of the sum. Differences of the sum give it, far
 * from the minimum, where the curvature matters. */
static void test_newtons_equations_are_second_differences(void)
{
    const double h = 2e-4;
    test_rng rng = test_seed(7);

    for (int trial = 0; trial < 40; trial++) {
        double R[9], t[3], size[6];
        rigcal_real sse, g[6], H[21], gauss[21];
        rigcal_refinement state;
        rigcal_transform pose;
        test_scene scene;
        test_data data;
        problem p;

        test_scene_random(&scene, &rng, N_MAX, TEST_GENERAL);
        p.camera = test_pinhole();
        test_observations(p.o, &scene, &p.camera);
        for (int i = 0; i < N_MAX; i++) {
            p.o[i].uv[0] += RC(20 * test_normal(&rng));
            p.o[i].uv[1] += RC(20 * test_normal(&rng));
        }
        ready(&p, N_MAX, 0, ZERO);
        data = data_of(&p);
        pose = test_transform(scene.R, scene.t);
        ASSERT_STATUS(RIGCAL_OK, equations(&sse, g, H, &p, &pose, RC_NEWTON));
        ASSERT_STATUS(RIGCAL_OK, equations(&sse, g, gauss, &p, &pose, RC_GAUSS_NEWTON));
        begin_search(&state, &p, &pose, RC_NEWTON);
        for (int i = 0; i < 6; i++) {
            size[i] = sqrt(test_in_blocks(gauss, i, i));
        }
        for (int i = 0; i < 6; i++) {
            for (int j = 0; j <= i; j++) {
                double second = 0;

                for (int corner = 0; corner < 4; corner++) {
                    const double a = corner / 2 ? 1 : -1, b = corner % 2 ? 1 : -1;
                    double d[6] = {0};

                    d[i] += a * h;
                    d[j] += b * h;
                    memcpy(R, scene.R, sizeof R);
                    memcpy(t, scene.t, sizeof t);
                    test_move(R, t, d);
                    second += a * b * test_sse(&data, R, t);
                }
                ASSERT_NEAR(second / (8 * h * h), test_in_blocks(H, i, j),
                            TOL(1e-5, 1e-3) * size[i] * size[j]);
                ASSERT_NEAR(second / (8 * h * h), test_in_blocks(state.H, i, j),
                            TOL(1e-5, 1e-3) * size[i] * size[j]);
            }
        }
    }
}

/* For every lens, with and without sigma. */
static void test_equations_are_those_of_differences(void)
{
    const double h = 1e-5;

    for (int row = 0; row < REFINE_LENS_ROWS; row++) {
        double J[6][2 * N_MAX], e[2 * N_MAX], R[9], t[3], sum = 0, g0[6], H0[21];
        rigcal_real sse, g[6], H[21];
        rigcal_refinement state;
        rigcal_transform pose;
        problem p;
        int n;

        of_lens(&p, REFINE_LENS[row]);
        n = (int)p.points.view.n;
        if (row % 3 == 0) {
            p.points.view.sigma = NULL;
        }
        pose = start_pose(&p, REFINE_LENS[row]);
        for (int k = 0; k < 6; k++) {
            for (int side = -1; side <= 1; side++) {
                double d[6] = {0, 0, 0, 0, 0, 0};

                d[k] = h * side;
                test_transform_parts(R, t, &pose);
                test_move(R, t, d);
                for (int i = 0; i < n; i++) {
                    const double by = p.points.view.sigma ? 1 / D(p.sigma[i]) : 1;
                    double x[3], X_c[3], uv[2];

                    for (int c = 0; c < 3; c++) {
                        x[c] = D(p.o[i].X_w[c]) - D(p.points.origin[c]);
                    }
                    test_apply(X_c, R, x, t);
                    test_project_px(uv, &p.camera, X_c);
                    for (int c = 0; c < 2; c++) {
                        const double off = by * (D(p.o[i].uv[c]) - uv[c]);

                        if (side == 0) {
                            e[2 * i + c] = off;
                        } else if (side < 0) {
                            J[k][2 * i + c] = off / (2 * h);
                        } else {
                            J[k][2 * i + c] -= off / (2 * h);
                        }
                    }
                }
            }
        }
        for (int i = 0; i < 2 * n; i++) {
            sum += e[i] * e[i];
        }
        for (int a = 0, at = 0; a < 6; a++) {
            g0[a] = 0;
            for (int i = 0; i < 2 * n; i++) {
                g0[a] += J[a][i] * e[i];
            }
            for (int b = 0; b <= a; b++, at++) {
                H0[at] = 0;
                for (int i = 0; i < 2 * n; i++) {
                    H0[at] += J[a][i] * J[b][i];
                }
            }
        }
        ASSERT_STATUS(RIGCAL_OK, equations(&sse, g, H, &p, &pose, RC_GAUSS_NEWTON));
        assert_equations(sum, g0, H0, sse, g, H, TOL(1e-7, 1e-3));
        begin_search(&state, &p, &pose, RC_GAUSS_NEWTON);
        assert_equations(sum, g0, H0, state.search.sum, state.g, state.H, TOL(1e-7, 1e-3));
    }
}

static void test_a_point_that_the_camera_cannot_see_is_told(void)
{
    rigcal_real sse, g[6], H[21];
    rigcal_transform pose;
    problem p;
    double R[9];

    of_scene(&p, SCENE[0], 6);
    test_rotation(R, SCENE[0][30], SCENE[0][31], SCENE[0][32]);
    pose = test_transform(R, SCENE[0] + 33);
    pose.t[2] = RC(-3);
    ASSERT_STATUS(RIGCAL_ERR_BEHIND, equations(&sse, g, H, &p, &pose, RC_GAUSS_NEWTON));
}

/* ---- Levenberg-Marquardt ------------------------------------------------- */

/* Checks that a pose is within `part` standard deviations of the golden minimum. */
static void assert_at_minimum(const double minimum[13], const double covariance[21],
                              const double R[9], const double t[3], double sse,
                              double noise, double part)
{
    double Sigma[36], d[6];

    for (int i = 0; i < 36; i++) {
        Sigma[i] = test_lower(covariance, i / 6, i % 6) * noise * noise;
    }
    test_difference(d, minimum, minimum + 9, R, t);
    TEST_ASSERT_TRUE_MESSAGE(test_squared_distance(d, Sigma, 6) < part * part,
                             "not at the minimum");
    ASSERT_NEAR(minimum[12], sse, TOL(1e-7, 1e-2) * minimum[12]);
}

static void test_the_minimum_is_that_of_scipy_for_any_lens_and_weights(void)
{
    for (int i = 0; i < REFINE_LENS_ROWS; i++) {
        const double *v = REFINE_LENS[i];
        const double noise = sqrt(minimum_of(v)[12] / (2 * v[1] - 6));
        rigcal_refinement state;
        rigcal_transform start;
        double R[9], t[3];
        problem p;

        of_lens(&p, v);
        start = start_pose(&p, v);
        TEST_ASSERT_LESS_OR_EQUAL_INT(20, run(&state, &p, &start));
        ASSERT_STATUS(RIGCAL_OK, state.search.status);
        to_world(R, t, &p, &state.cam_from_points);
        assert_at_minimum(minimum_of(v), covariance_of(v), R, t, D(state.search.sum), noise,
                          TOL(1e-3, 0.05));
    }
}

/* In normalised coordinates, from starts 2 to 5 degrees off. */
static void test_the_minimum_is_that_of_the_oracle(void)
{
    test_rng rng = test_seed(1);

    for (int i = 0; i < REFINE_PINHOLE_ROWS; i++) {
        const double *v = REFINE_PINHOLE[i], *minimum = v + 2;
        const double noise = sqrt(minimum[12] / (2 * v[1] - 6));
        const double off = test_uniform(&rng, 2, 5) * TEST_PI / 180;
        double R[9], t[3], turn[9], axis[9], middle[3] = {0, 0, 0};
        rigcal_refinement state;
        rigcal_transform start;
        problem p;

        of_scene(&p, SCENE[(int)v[0]], (int)v[1]);
        for (int k = 0; k < (int)v[1]; k++) {
            for (int c = 0; c < 3; c++) {
                middle[c] += SCENE[(int)v[0]][3 * k + c] / v[1];
            }
        }
        test_to_real(p.points.origin, middle, 3);
        start = from_points(&p, minimum, minimum + 9);
        test_random_rotation(axis, &rng);
        test_rotation_about(turn, axis, off);
        test_product(R, turn, minimum);
        test_to_real(start.R, R, 9);
        (void)run(&state, &p, &start);
        /* four points may lead to another minimum, or to one with a larger sum */
        to_world(R, t, &p, &state.cam_from_points);
        if (v[1] > 4 || test_angle_between(R, minimum) < 0.01) {
            ASSERT_STATUS(RIGCAL_OK, state.search.status);
            /* in these units the rounding of float is as large as the noise */
            assert_at_minimum(minimum, v + 15, R, t, TOL(D(state.search.sum), minimum[12]),
                              noise, TOL(1e-2, 1));
        }
    }
}

static void test_an_exact_image_is_fitted_to_rounding(void)
{
    test_rng rng = test_seed(2);

    for (int trial = 0; trial < 200; trial++) {
        double R[9], t[3], d[6], turn[9], axis[9], distance;
        rigcal_refinement state;
        rigcal_transform start;
        test_scene scene;
        problem p;

        test_scene_random(&scene, &rng, N_MAX, (test_shape)(trial % 3));
        p.camera = test_pinhole();
        test_observations(p.o, &scene, &p.camera);
        ready(&p, N_MAX, 0, scene.X[0]);
        start = from_points(&p, scene.R, scene.t);
        test_random_rotation(axis, &rng);
        test_rotation_about(turn, axis, 2 * TEST_PI / 180);
        test_product(R, turn, scene.R);
        test_to_real(start.R, R, 9);
        (void)run(&state, &p, &start);
        ASSERT_STATUS(RIGCAL_OK, state.search.status);
        to_world(R, t, &p, &state.cam_from_points);
        test_difference(d, scene.R, scene.t, R, t);
        distance = test_norm(scene.t);
        ASSERT_NEAR(0, test_norm(d), TOL(1e-9, 2e-3));
        ASSERT_NEAR(0, test_norm(d + 3), TOL(1e-9, 5e-3) * distance);
        ASSERT_ROTATION(R, TOL(1e-14, 2e-6));
    }
}

/* From any start it ends within the bound, with a sum no larger than at the start. */
static void test_wild_starts_end_no_worse_than_they_began(void)
{
    test_rng rng = test_seed(3);
    int ended = 0;

    for (int trial = 0; trial < TEST_TRIALS(500); trial++) {
        const double *v = REFINE_LENS[trial % REFINE_LENS_ROWS];
        rigcal_refinement state;
        rigcal_transform start;
        rigcal_real before, g[6], H[21];
        double R[9];
        problem p;

        of_lens(&p, v);
        start = start_pose(&p, v);
        test_random_rotation(R, &rng);
        test_to_real(start.R, R, 9);
        if (equations(&before, g, H, &p, &start, RC_GAUSS_NEWTON) != RIGCAL_OK) {
            state.cam_from_points = start;
            rc_refine_begin(&state, 0);
            rc_refine_step(&state, &p.points, EVALS_MAX);
            TEST_ASSERT_TRUE(state.search.status < 0);
            continue;
        }
        (void)run(&state, &p, &start);
        if (state.search.status >= 0) {
            const test_data data = data_of(&p);
            double t[3];

            ended++;
            TEST_ASSERT_TRUE(D(state.search.sum) <= D(before));
            to_world(R, t, &p, &state.cam_from_points);
            /* it may end where a point nearly touches the camera */
            ASSERT_NEAR(test_sse(&data, R, t), state.search.sum,
                        TOL(1e-6, 1e-2) * D(state.search.sum) + TOL(1e-12, 1e-3));
        }
    }
    TEST_ASSERT_GREATER_THAN_INT(TEST_ONE_IN > 1 ? 0 : 400, ended);
}

/* From a start 0.02 rad beside the truth four evaluations are usually enough, and nearly
 * all refinements take no more than five. */
static void test_a_near_start_takes_few_evaluations(void)
{
    enum { TRIALS = TEST_TRIALS(400) };
    static const double AXIS[3] = {1, 0, 0};
    test_rng rng = test_seed(7);
    int quick = 0;

    for (int trial = 0; trial < TRIALS; trial++) {
        double turn[9], R[9];
        rigcal_refinement state;
        rigcal_transform start;
        test_problem random;
        problem p;

        test_random_problem(&random, &rng, N_MAX, trial % 2 ? TEST_PLANAR : TEST_GENERAL);
        test_add_noise(&random, &rng, 0.5);
        p.camera = random.camera;
        p.camera.k1 = RC(trial % 4 > 1 ? 1e-6 : 0); /* it takes the way of a lens */
        memcpy(p.o, random.o, sizeof p.o);
        ready(&p, N_MAX, 0, ZERO);
        test_rotation_about(turn, AXIS, 0.02);
        test_product(R, turn, random.scene.R);
        start = test_transform(R, random.scene.t);
        quick += run(&state, &p, &start) <= 5;
        TEST_ASSERT_TRUE(state.search.status >= 0);
    }
    TEST_ASSERT_GREATER_THAN_INT(TRIALS * 9 / 10, quick);
}

static void test_a_small_bound_is_kept_and_told(void)
{
    const double *v = REFINE_LENS[1];
    rigcal_refinement state;
    rigcal_transform start;
    problem p;
    int calls = 0;

    of_lens(&p, v);
    start = start_pose(&p, v);
    state.cam_from_points = start;
    rc_refine_begin(&state, 0);
    while (state.search.status == RIGCAL_RUNNING && calls < 10) {
        rc_refine_step(&state, &p.points, 2);
        calls++;
    }
    ASSERT_STATUS(RIGCAL_BUDGET_SPENT, state.search.status);
    TEST_ASSERT_EQUAL_INT(2, calls);
}

/* A point with a hundred times the sigma, and with that error, has almost no effect. */
static void test_a_point_of_large_sigma_hardly_counts(void)
{
    test_rng rng = test_seed(4);

    for (int trial = 0; trial < 100; trial++) {
        rigcal_refinement state;
        rigcal_transform start;
        test_scene scene;
        double R[9], t[3];
        problem p;

        test_scene_random(&scene, &rng, N_MAX, TEST_GENERAL);
        p.camera = test_pinhole();
        test_observations(p.o, &scene, &p.camera);
        for (int i = 0; i < N_MAX; i++) {
            p.sigma[i] = i == 3 ? 1000 : 1;
        }
        p.o[3].uv[0] += 20;
        ready(&p, N_MAX, 1, ZERO);
        start = from_points(&p, scene.R, scene.t);
        (void)run(&state, &p, &start);
        ASSERT_STATUS(RIGCAL_OK, state.search.status);
        to_world(R, t, &p, &state.cam_from_points);
        ASSERT_NEAR(0, test_angle_between(R, scene.R), TOL(2e-5, 3e-3));
        ASSERT_NEAR(4e-4, state.search.sum, TOL(1e-5, 1e-4));
    }
}

/* ---- covariance ---------------------------------------------------------- */

static void test_the_covariance_is_the_inverse(void)
{
    for (int i = 0; i < REFINE_LENS_ROWS; i++) {
        const double *v = REFINE_LENS[i], *golden = covariance_of(v);
        rigcal_real sse, g[6], H[21], Sigma[36];
        rigcal_transform pose;
        problem p;

        of_lens(&p, v);
        memset(p.points.origin, 0, sizeof p.points.origin); /* as in the vectors */
        pose = test_transform(minimum_of(v), minimum_of(v) + 9);
        ASSERT_STATUS(RIGCAL_OK, equations(&sse, g, H, &p, &pose, RC_GAUSS_NEWTON));
        TEST_ASSERT_TRUE(rc_sym6_invert(Sigma, H));
        for (int k = 0; k < 36; k++) {
            const double size =
                sqrt(test_lower(golden, k / 6, k / 6) * test_lower(golden, k % 6, k % 6));

            ASSERT_NEAR(test_lower(golden, k / 6, k % 6), Sigma[k], TOL(1e-8, 0.2) * size);
        }
    }
}

/* If the line is nearly at a right angle to an axis, rounding may hide it, as in 7 of 500
 * scenes. Then the standard deviation is above one radian for a pixel, which says the
 * same. */
static void test_points_on_a_line_leave_the_equations_singular(void)
{
    test_rng rng = test_seed(5);
    int missed = 0;

    for (int trial = 0; trial < 500; trial++) {
        rigcal_real sse, g[6], H[21], Sigma[36];
        rigcal_transform pose;
        test_scene scene;
        double way[9];
        problem p;

        test_scene_random(&scene, &rng, N_MAX, TEST_GENERAL);
        test_random_rotation(way, &rng);
        for (int i = 0; i < N_MAX; i++) {
            for (int k = 0; k < 3; k++) {
                scene.X[i][k] = scene.X[0][k] + i * 0.25 * way[k];
            }
        }
        p.camera = test_pinhole();
        test_observations(p.o, &scene, &p.camera);
        ready(&p, N_MAX, 0, scene.X[0]);
        pose = from_points(&p, scene.R, scene.t);
        ASSERT_STATUS(RIGCAL_OK, equations(&sse, g, H, &p, &pose, RC_GAUSS_NEWTON));
        if (rc_sym6_invert(Sigma, H)) {
            TEST_ASSERT_TRUE(D(Sigma[0]) + D(Sigma[7]) + D(Sigma[14]) > 1);
            missed++;
        }
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(20, missed);
}

/* ---- starts from which nothing can be seen ------------------------------------ */

/* Begins at a pose without rotation, with t in front of the camera. The first step uses a
 * part of the points, if there are enough. */
static void begin_at(rigcal_refinement *state, const problem *p, double t)
{
    const double I[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, place[3] = {0, 0, t};

    state->cam_from_points = test_transform(I, place);
    rc_refine_begin(state, 0);
    rc_refine_begin_part(state, &p->points);
}

/* With k4 = -1 the lens has a pole 45 degrees off its axis. At depth 1 most points are
 * beyond the pole. A flat target is not seen either, if it is so near to the plane of a
 * pinhole that its sum of squares overflows. */
static void test_a_start_that_the_lens_does_not_see_is_told(void)
{
    for (int is_pole = 0; is_pole < 2; is_pole++) {
        rigcal_refinement state;
        problem p;

        p.camera = test_pinhole();
        p.camera.k4 = is_pole ? -1 : 0;
        for (int i = 0; i < 4; i++) {
            p.o[i] = (rigcal_observation){{RC(i % 2 ? 1 : -1), RC(i / 2 ? 1 : -1), 0},
                                          {RC(300 + 40 * (i % 2)), RC(220 + 40 * (i / 2))}};
        }
        ready(&p, 4, 0, ZERO);
        begin_at(&state, &p, is_pole ? 1 : TOL(1e-160, 1e-20));
        rc_refine_step(&state, &p.points, EVALS_MAX);
        ASSERT_STATUS(RIGCAL_ERR_NO_RAY, state.search.status);
        begin_at(&state, &p, 0); /* exactly in the plane */
        rc_refine_step(&state, &p.points, EVALS_MAX);
        ASSERT_STATUS(RIGCAL_ERR_BEHIND, state.search.status);
    }
}

enum { MANY = 24 };

/* Points on the plane z = 1 about the axis, except the first one, which is the origin. */
static void many(problem *p, rigcal_observation o[MANY])
{
    rigcal_real uv_middle[2];
    int32_t at_fault;

    for (int i = 0; i < MANY; i++) {
        const double x = i % 5 - 2, y = i / 5 - 2;

        o[i] = (rigcal_observation){{RC(x), RC(y), 1},
                                    {RC(320 + 800 * x / 5), RC(240 + 800 * y / 5)}};
    }
    o[0] = (rigcal_observation){{0, 0, 0}, {320, 240}};
    rc_points_of(&p->points, &VIEW(&p->camera, o, NULL, MANY), NULL);
    ASSERT_STATUS(RIGCAL_OK, rc_points_survey(&p->points, uv_middle, &at_fault));
    test_to_real(p->points.origin, ZERO, 3);
}

/* If a first step by a part of the points is impossible, it is left out. Then all points
 * show what is wrong: they are behind the camera, or one of them is nearly in its centre,
 * where the derivative of its pixel overflows. */
static void test_a_part_without_a_step_is_left_out(void)
{
#if RIGCAL_FOR_SPEED
    const double places[2] = {-5, TOL(1e-160, 1e-25)};
    const rigcal_status ends[2] = {RIGCAL_ERR_BEHIND, RIGCAL_ERR_DEGENERATE};

    for (int i = 0; i < 2; i++) {
        rigcal_observation o[MANY];
        rigcal_refinement state;
        problem p;

        p.camera = test_pinhole();
        many(&p, o);
        begin_at(&state, &p, places[i]);
        TEST_ASSERT_TRUE(state.is_part);
        rc_refine_step(&state, &p.points, EVALS_MAX);
        TEST_ASSERT_FALSE(state.is_part);
        ASSERT_STATUS(RIGCAL_RUNNING, state.search.status);
        ASSERT_NEAR(RC(places[i]), state.cam_from_points.t[2], 0);
        while (state.search.status == RIGCAL_RUNNING) {
            rc_refine_step(&state, &p.points, EVALS_MAX);
        }
        ASSERT_STATUS(ends[i], state.search.status);
    }
#endif
}

/* The points are seen exactly from t = (0, 0, 4). From 4.4 a step of Newton's by any of
 * them goes most of the way. */
static void test_a_first_step_by_a_part_goes_most_of_the_way(void)
{
#if RIGCAL_FOR_SPEED
    rigcal_observation o[MANY];
    rigcal_refinement state;
    problem p;

    p.camera = test_pinhole();
    many(&p, o);
    begin_at(&state, &p, 4.4);
    rc_refine_step(&state, &p.points, EVALS_MAX);
    TEST_ASSERT_FALSE(state.is_part);
    ASSERT_NEAR(4, state.cam_from_points.t[2], 0.1);
#endif
}

static void test_of_a_fisheye_all_points_make_the_first_step(void)
{
    rigcal_observation o[MANY];
    rigcal_refinement state;
    problem p;

    p.camera = test_pinhole();
    p.camera.lens = RIGCAL_LENS_FISHEYE;
    many(&p, o);
    begin_at(&state, &p, 4);
#if RIGCAL_FOR_SPEED
    TEST_ASSERT_FALSE(state.is_part);
#endif
    rc_refine_step(&state, &p.points, EVALS_MAX);
    TEST_ASSERT_TRUE(state.search.sum < RC_MAX); /* evaluated */
}

TEST_MAIN()
{
    RUN_TEST(test_equations_are_those_of_the_oracle);
    RUN_TEST(test_newtons_equations_are_second_differences);
    RUN_TEST(test_equations_are_those_of_differences);
    RUN_TEST(test_a_point_that_the_camera_cannot_see_is_told);
    RUN_TEST(test_the_minimum_is_that_of_scipy_for_any_lens_and_weights);
    RUN_TEST(test_the_minimum_is_that_of_the_oracle);
    RUN_TEST(test_an_exact_image_is_fitted_to_rounding);
    RUN_TEST(test_wild_starts_end_no_worse_than_they_began);
    RUN_TEST(test_a_near_start_takes_few_evaluations);
    RUN_TEST(test_a_small_bound_is_kept_and_told);
    RUN_TEST(test_a_point_of_large_sigma_hardly_counts);
    RUN_TEST(test_the_covariance_is_the_inverse);
    RUN_TEST(test_points_on_a_line_leave_the_equations_singular);
    RUN_TEST(test_a_start_that_the_lens_does_not_see_is_told);
    RUN_TEST(test_a_part_without_a_step_is_left_out);
    RUN_TEST(test_a_first_step_by_a_part_goes_most_of_the_way);
    RUN_TEST(test_of_a_fisheye_all_points_make_the_first_step);
}
