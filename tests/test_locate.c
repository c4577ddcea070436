/* locate: a point from the views that are used, view by view: its equations after a search
 * with detours, and where it ends. */
#include <math.h>
#include <string.h>

#include "rc_locate.h"
#include "test_two_views.h"
#include "vectors_camera.h"

enum { N = 3 };

static rigcal_mounted_camera cameras[N];
static int32_t group[N];
static uint8_t held[N] = {1, 1, 1};
static rigcal_sighting seen[N];
static rigcal_real work[RIGCAL_POINT_WORK(N)], noise[N];
static rigcal_calibrated_rig rig;
static rigcal_sightings s;
static rigcal_point_solver solver;

static void hand_in(int n)
{
    rig.cameras = cameras;
    rig.group = group;
    rig.held = held;
    rig.n_cameras = rig.capacity = (size_t)n;
    s.rig = &rig;
    s.seen = seen;
    s.n = (size_t)n;
    s.sigma_px = noise;
    s.work = work;
    s.work_capacity = RIGCAL_POINT_WORK(N);
    for (int i = 0; i < n; i++) {
        seen[i].camera = i;
        noise[i] = 1;
    }
}

/* Cameras about the origin. Each sees a random pixel. */
static void build(test_rng *rng, double spread_px)
{
    hand_in(N);
    for (int i = 0; i < N; i++) {
        const double t[3] = {0, 0, 5};
        double R[9];

        cameras[i].camera = test_camera(CAMERA[i == 2 ? 4 : i]);
        test_rotation(R, test_uniform(rng, -3, 3), 0.6 * (i - 1),
                      test_uniform(rng, -0.3, 0.3));
        cameras[i].cam_from_rig = test_transform(R, t);
        seen[i].uv[0] = RC(D(cameras[i].camera.cx) + spread_px * test_normal(rng));
        seen[i].uv[1] = RC(D(cameras[i].camera.cy) + spread_px * test_normal(rng));
    }
}

static void build_views(const test_views *v)
{
    hand_in(v->n);
    for (int i = 0; i < v->n; i++) {
        cameras[i].camera = v->cameras[i];
        cameras[i].cam_from_rig = v->cams_from_world[i];
        seen[i].uv[0] = v->uv[2 * i];
        seen[i].uv[1] = v->uv[2 * i + 1];
    }
}

static rigcal_status locate(void)
{
    rigcal_status status = RIGCAL_RUNNING;

    ASSERT_STATUS(RIGCAL_OK, rigcal_point_begin(&solver, &s));
    ASSERT_STATUS(RIGCAL_RUNNING, rigcal_point_step(&solver, (int32_t)s.n)); /* checked */
    solver.aside = 1; /* a point begins without what was before */
    rc_locate_begin(&solver, s.n);
    for (int units = 0; status == RIGCAL_RUNNING; units++) {
        TEST_ASSERT_TRUE(units < 60 * N);
        status = rc_locate_step(&solver);
    }
    return status;
}

static double sum_at(const double X[3])
{
    double sum = 0;

    for (int i = 0; i < N; i++) {
        double X_c[3], uv[2];

        test_move_point(X_c, &cameras[i].cam_from_rig, X);
        test_project_px(uv, &cameras[i].camera, X_c);
        sum += pow(uv[0] - D(seen[i].uv[0]), 2) + pow(uv[1] - D(seen[i].uv[1]), 2);
    }
    return sum;
}

/* Whatever path the search took, the matrices A of the views belong to its final point:
 * N^-1 must equal A^T A, by differences of the projections. */
static void test_equations_are_those_of_the_point_that_is_found(void)
{
    test_rng rng = test_seed(631);
    const double h = 1e-5;
    int found = 0;

    for (int trial = 0; trial < TEST_TRIALS(300); trial++) {
        double X[3], H[9] = {0};

        build(&rng, trial % 2 ? 30 : 120);
        if (locate() != RIGCAL_OK) {
            continue;
        }
        found++;
        test_to_double(X, solver.X, 3);
        for (int i = 0; i < N; i++) {
            double J[2][3];

            for (int k = 0; k < 3; k++) {
                double side[2][3], X_c[3], uv[2][2];

                for (int way = 0; way < 2; way++) {
                    memcpy(side[way], X, sizeof X);
                    side[way][k] += way ? h : -h;
                    test_move_point(X_c, &cameras[i].cam_from_rig, side[way]);
                    test_project_px(uv[way], &cameras[i].camera, X_c);
                }
                J[0][k] = (uv[1][0] - uv[0][0]) / (2 * h);
                J[1][k] = (uv[1][1] - uv[0][1]) / (2 * h);
            }
            for (int k = 0; k < 9; k++) {
                H[k] += J[0][k / 3] * J[0][k % 3] + J[1][k / 3] * J[1][k % 3];
            }
        }
        for (int k = 0; k < 9; k++) { /* H N = 1 */
            static const int AT[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};
            double product = 0;

            for (int j = 0; j < 3; j++) {
                product += H[3 * (k / 3) + j] * D(solver.sums.N[AT[3 * j + k % 3]]);
            }
            /* The last step is not evaluated. In float, with such residuals, it is
             * longer. */
            ASSERT_NEAR(k % 4 == 0, product, TOL(1e-3, 6e-2));
        }
    }
    TEST_ASSERT_TRUE(found > TEST_TRIALS(300) / 3);
}

static void test_no_point_nearby_is_better(void)
{
    test_rng rng = test_seed(632);

    for (int trial = 0; trial < TEST_TRIALS(200); trial++) {
        double X[3];

        build(&rng, 60);
        if (locate() != RIGCAL_OK) {
            continue;
        }
        test_to_double(X, solver.X, 3);
        const double least = sum_at(X);
        for (int way = 0; way < 6; way++) {
            double aside[3];

            memcpy(aside, X, sizeof X);
            aside[way / 2] += way % 2 ? 1e-2 : -1e-2;
            TEST_ASSERT_TRUE(sum_at(aside) > least * (1 - TOL(1e-5, 1e-3)));
        }
    }
}

/* Noise of a power of two times another in all views scales all sums and equations exactly.
 * So the search takes the same way to the same point, bit by bit. */
static void test_how_large_the_noise_is_does_not_move_the_point(void)
{
    const rigcal_real times = TOL(524288, 1024);
    test_rng rng = test_seed(636);
    int found = 0;

    for (int trial = 0; trial < TEST_TRIALS(200); trial++) {
        rigcal_real X[3];

        build(&rng, 60);
        const rigcal_status status = locate();
        memcpy(X, solver.X, sizeof X);
        for (int i = 0; i < N; i++) {
            noise[i] = times;
        }
        ASSERT_STATUS(status, locate());
        if (status == RIGCAL_OK) {
            TEST_ASSERT_EQUAL_MEMORY(X, solver.X, sizeof X);
            found++;
        }
    }
    TEST_ASSERT_TRUE(found > TEST_TRIALS(200) / 3);
}

/* The rays are far from meeting. So a search takes long, goes back, or goes away to
 * infinity. There no step is fixed any more, and the search ends before its evaluations
 * are spent. */
static void test_no_point_near_one_of_wild_views_is_better(void)
{
    test_rng rng = test_seed(633);
    int counts[3] = {0, 0, 0}, far = 0, spent = 0;

    for (int trial = 0; trial < TEST_TRIALS(20000); trial++) {
        double X[3];
        test_views v;

        test_wild_views(&v, &rng);
        build_views(&v);
        const rigcal_status status = locate();
        test_to_double(X, solver.X, 3);
        TEST_ASSERT_TRUE(solver.evals <= RC_TRIANGULATION_EVALS);
        if (test_norm(X) > TOL(1e6, 1e3)) {
            far++;
            spent += solver.evals == RC_TRIANGULATION_EVALS;
        }
        if (status == RIGCAL_OK) {
            const double least = test_views_sum(&v, X), step = 1e-3 * (1 + test_norm(X));

            counts[0]++;
            for (int way = 0; way < 6; way++) {
                double aside[3] = {X[0], X[1], X[2]};

                aside[way / 2] += way % 2 ? step : -step;
                TEST_ASSERT_TRUE(test_views_sum(&v, aside) > least * (1 - TOL(1e-5, 1e-3)));
            }
        } else if (status == RIGCAL_BUDGET_SPENT) {
            counts[1]++;
            TEST_ASSERT_TRUE(test_views_sum(&v, X) < test_infinity()); /* seen by all */
        } else {
            counts[2] += status == RIGCAL_ERR_PARALLEL;
            TEST_ASSERT_TRUE(status == RIGCAL_ERR_PARALLEL || status == RIGCAL_ERR_BEHIND ||
                             status == RIGCAL_ERR_DEGENERATE);
        }
    }
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || (far > 100 && spent < far / 10));
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || counts[i] > 20);
    }
}

/* The point is so near to the plane of a camera that its pixel, or the pixel's derivative,
 * overflows. */
static void test_a_point_that_grazes_a_camera_is_refused(void)
{
    test_views v;

    test_grazing_views(&v, 0);
    build_views(&v);
    ASSERT_STATUS(RIGCAL_ERR_PARALLEL, locate());
    test_grazing_views(&v, 1);
    build_views(&v);
    ASSERT_STATUS(RIGCAL_ERR_NO_RAY, locate());
}

/* A camera may be anywhere, so the point's covariance overflows. */
static void test_a_covariance_that_overflows_is_told(void)
{
    static rigcal_real Sigma[RIGCAL_CALIBRATED_SIZE(1)];
    test_rng rng = test_seed(634);

    build(&rng, 0);
    Sigma[3 * (3 + 3) / 2] = RC(TOL(1e306, 1e36)); /* of its place along x */
    rig.Sigma = Sigma;
    rig.Sigma_capacity = RIGCAL_CALIBRATED_SIZE(1);
    rig.sigma_px = 1;
    held[0] = 0;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, locate());
    held[0] = 1;
    rig.sigma_px = 0;
}

static void test_the_parallax_is_the_widest_angle_of_two_rays(void)
{
    test_rng rng = test_seed(637);

    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        double rays[N][3], widest = 0;

        build(&rng, 30);
        (void)locate();
        for (int i = 0; i < N; i++) {
            rigcal_real ray[3];
            double X_c[3], R[9], t[3], Rt[9];

            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_camera_ray(ray, &cameras[i].camera, seen[i].uv));
            test_to_double(X_c, ray, 3);
            test_transform_parts(R, t, &cameras[i].cam_from_rig);
            test_transpose(Rt, R);
            test_apply(rays[i], Rt, X_c, NULL);
            for (int k = 0; k < i; k++) {
                widest = fmax(widest, acos(test_dot(rays[i], rays[k])));
            }
        }
        ASSERT_NEAR(widest, rc_locate_parallax(&solver), TOL(1e-7, 1e-3));
    }
}

/* A squared sine may be above 1 by rounding. */
static void test_the_angle_of_rays_is_at_most_90_degrees(void)
{
    solver.aside = 1 + 4 * RC_EPS;
    ASSERT_NEAR(TEST_PI / 2, rc_locate_parallax(&solver), TOL(1e-15, 1e-6));
    solver.aside = RC(0.25);
    ASSERT_NEAR(TEST_PI / 6, rc_locate_parallax(&solver), TOL(1e-15, 1e-7));
}

/* The nearest point to the rays is a start like any other: its first step is damped. */
static void test_the_first_step_is_damped(void)
{
    test_rng rng = test_seed(635);

    build(&rng, 30);
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_begin(&solver, &s));
    ASSERT_STATUS(RIGCAL_RUNNING, rigcal_point_step(&solver, N));
    rc_locate_begin(&solver, N);
    for (int i = 0; i < N; i++) {
        ASSERT_STATUS(RIGCAL_RUNNING, rc_locate_step(&solver));
    }
    ASSERT_NEAR(1e-5, solver.search.lambda, TOL(1e-20, 1e-11));
    TEST_ASSERT_EQUAL_INT(1, solver.evals);
}

TEST_MAIN()
{
    RUN_TEST(test_the_first_step_is_damped);
    RUN_TEST(test_equations_are_those_of_the_point_that_is_found);
    RUN_TEST(test_no_point_nearby_is_better);
    RUN_TEST(test_how_large_the_noise_is_does_not_move_the_point);
    RUN_TEST(test_no_point_near_one_of_wild_views_is_better);
    RUN_TEST(test_a_point_that_grazes_a_camera_is_refused);
    RUN_TEST(test_the_parallax_is_the_widest_angle_of_two_rays);
    RUN_TEST(test_the_angle_of_rays_is_at_most_90_degrees);
    RUN_TEST(test_a_covariance_that_overflows_is_told);
}
