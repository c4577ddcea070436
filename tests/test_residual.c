/* residual: the error of a point, its derivatives, and what it adds to least squares,
 * compared with differences of test_project_px. */
#include <math.h>
#include <string.h>

#include "rc_residual.h"
#include "test_fit.h"

/* ---- lenses and points ------------------------------------------------------- */

enum { PINHOLE, BROWN, FISHEYE, BARE_FISHEYE, CAMERAS };

/* A pinhole; Brown's lens with all its coefficients; a fisheye with coefficients and one
 * without. */
static rigcal_camera camera_of(int which)
{
    rigcal_camera camera = test_pinhole();
    if (which == BROWN) {
        camera.k1 = RC(-0.2), camera.k2 = RC(0.05), camera.k3 = RC(0.01);
        camera.k4 = RC(0.03), camera.k5 = RC(-0.01), camera.k6 = RC(0.004);
        camera.p1 = RC(2e-3), camera.p2 = RC(-1e-3);
    } else if (which != PINHOLE) {
        camera.lens = RIGCAL_LENS_FISHEYE;
        camera.fx = RC(300);
        camera.fy = RC(310);
    }
    if (which == FISHEYE) {
        camera.k1 = RC(0.04), camera.k2 = RC(-0.01), camera.k3 = RC(2e-3);
        camera.k4 = RC(-3e-4);
    }
    return camera;
}

/* A point in front of the camera; for a fisheye up to 115 degrees off its axis. */
static void random_point(double X_c[3], const rigcal_camera *camera, test_rng *rng)
{
    const double way = test_uniform(rng, 0, 2 * TEST_PI), range = test_uniform(rng, 1, 4);
    const double off = test_uniform(rng, 0, camera->lens == RIGCAL_LENS_FISHEYE ? 2 : 0.5);
    X_c[0] = range * sin(off) * cos(way);
    X_c[1] = range * sin(off) * sin(way);
    X_c[2] = range * cos(off);
}

/* d pixel / d X_c, 2 x 3. */
static void differences(double B[6], const rigcal_camera *camera, const double X_c[3])
{
    const double h = 1e-5;
    for (int k = 0; k < 3; k++) {
        double X[3], less[2], more[2];
        memcpy(X, X_c, sizeof X);
        X[k] = X_c[k] - h;
        test_project_px(less, camera, X);
        X[k] = X_c[k] + h;
        test_project_px(more, camera, X);
        for (int row = 0; row < 2; row++) {
            B[3 * row + k] = (more[row] - less[row]) / (2 * h);
        }
    }
}

/* A random point, its pixel and noise; e and B by the formulas of rigcal.h. */
typedef struct {
    rigcal_camera camera;
    double X_c[3], uv[2], e[2], B[6];
    rigcal_real X[3], pixel[2];
} sample;

static void take(sample *s, int which, double noise_px, test_rng *rng)
{
    s->camera = camera_of(which);
    random_point(s->X_c, &s->camera, rng);
    test_to_real(s->X, s->X_c, 3);
    test_to_double(s->X_c, s->X, 3);
    test_project_px(s->uv, &s->camera, s->X_c);
    for (int k = 0; k < 2; k++) {
        s->pixel[k] = RC(s->uv[k] + noise_px * test_uniform(rng, -1, 1));
        s->e[k] = D(s->pixel[k]) - s->uv[k];
    }
    differences(s->B, &s->camera, s->X_c);
}

/* ---- the error ----------------------------------------------------------------- */

static void test_the_error_is_observed_less_projected_with_its_derivative(void)
{
    test_rng rng = test_seed(51);
    for (int trial = 0; trial < 100 * CAMERAS; trial++) {
        rigcal_real e[2], B[6];
        sample s;
        take(&s, trial % CAMERAS, 5, &rng);
        ASSERT_STATUS(RIGCAL_OK, rc_residual(e, B, &s.camera, trial % CAMERAS == PINHOLE,
                                             s.pixel, s.X));
        ASSERT_ARRAY_NEAR(s.e, e, 2, TOL(1e-9, 2e-3));
        ASSERT_ARRAY_NEAR(s.B, B, 6, TOL(1e-5, 5e-2));
    }
}

static void test_a_point_behind_has_no_error(void)
{
    static const rigcal_real X_c[3] = {RC(0.1), RC(0.2), -1}, uv[2] = {300, 200};
    static const rigcal_real in_plane[3] = {RC(0.1), RC(0.2), 0};
    for (int which = PINHOLE; which <= BROWN; which++) {
        const rigcal_camera camera = camera_of(which);
        rigcal_real e[2], B[6];
        ASSERT_STATUS(RIGCAL_ERR_BEHIND,
                      rc_residual(e, B, &camera, which == PINHOLE, uv, X_c));
        ASSERT_STATUS(RIGCAL_ERR_BEHIND,
                      rc_residual(e, B, &camera, which == PINHOLE, uv, in_plane));
    }
}

/* However small the unit of length is. */
static void test_a_point_just_in_front_has_its_error(void)
{
    static const rigcal_real uv[2] = {300, 200};
    for (int which = PINHOLE; which <= BROWN; which++) {
        const rigcal_camera camera = camera_of(which);
        rigcal_real e[2], B[6];
        double expected[2];
        for (int k = 0; k < 2; k++) {
            const rigcal_real unit = k ? RC(1e-15) : 1;
            const rigcal_real X_c[3] = {unit / 8, unit / 4, unit};
            ASSERT_STATUS(RIGCAL_OK, rc_residual(e, B, &camera, which == PINHOLE, uv, X_c));
            if (k == 0) {
                test_to_double(expected, e, 2);
            }
        }
        ASSERT_ARRAY_NEAR(expected, e, 2, TOL(1e-10, 1e-3));
    }
}

/* ---- along the ray ------------------------------------------------------------- */

/* For a point next to the ray, divided by its range: the error in pixels, and a remainder
 * that falls with the square of the distance. */
static void test_along_the_ray_it_is_the_error_to_first_order(void)
{
    test_rng rng = test_seed(52);
    for (int trial = 0; trial < 50 * CAMERAS; trial++) {
        sample s;
        double remainder[2], aside[3];
        take(&s, trial % CAMERAS, 0, &rng);
        for (int k = 0; k < 3; k++) {
            aside[k] = test_uniform(&rng, -1, 1);
        }
        for (int i = 0; i < 2; i++) {
            const double by = (i ? 0.25 : 1) * TOL(1e-3, 1e-2);
            rigcal_real X[3], e[2], B[6], ray[3];
            double at[3], uv[2], range;
            for (int k = 0; k < 3; k++) {
                X[k] = RC(s.X_c[k] + by * aside[k]);
                at[k] = D(X[k]);
            }
            ASSERT_STATUS(RIGCAL_OK, rc_pixel_to_ray(ray, &s.camera, s.pixel));
            rc_residual_along_ray(e, B, &s.camera, trial % CAMERAS == PINHOLE, ray, X);
            test_project_px(uv, &s.camera, at);
            range = test_norm(at);
            remainder[i] = hypot(D(e[0]) / range - (D(s.pixel[0]) - uv[0]),
                                 D(e[1]) / range - (D(s.pixel[1]) - uv[1]));
            TEST_ASSERT_TRUE(remainder[i] <
                             0.1 * hypot(D(s.pixel[0]) - uv[0], D(s.pixel[1]) - uv[1]) +
                                 TOL(1e-6, 1e-2));
        }
        TEST_ASSERT_TRUE(remainder[1] < remainder[0] / 8 + TOL(1e-7, 1e-2));
    }
}

/* At the unit ray m: B as it is there, B m = 0, and e = -B X_c, to the last digits. */
static void test_along_the_ray_the_derivative_is_that_at_the_ray(void)
{
    test_rng rng = test_seed(53);
    for (int trial = 0; trial < 50 * CAMERAS; trial++) {
        static const rigcal_real BEHIND[3] = {RC(0.3), RC(-0.4), -2};
        double m[3], of_ray[6], e_exact[2];
        rigcal_real e[2], B[6], ray[3];
        sample s;
        take(&s, trial % CAMERAS, 0, &rng);
        for (int k = 0; k < 3; k++) {
            m[k] = s.X_c[k] / test_norm(s.X_c);
        }
        differences(of_ray, &s.camera, m);
        ASSERT_STATUS(RIGCAL_OK, rc_pixel_to_ray(ray, &s.camera, s.pixel));
        rc_residual_along_ray(e, B, &s.camera, trial % CAMERAS == PINHOLE, ray, BEHIND);
        ASSERT_ARRAY_NEAR(of_ray, B, 6, TOL(1e-5, 2e-1));
        for (int row = 0; row < 2; row++) {
            e_exact[row] = 0;
            for (int k = 0; k < 3; k++) {
                e_exact[row] -= of_ray[3 * row + k] * D(BEHIND[k]);
            }
        }
        ASSERT_ARRAY_NEAR(e_exact, e, 2, TOL(1e-4, 1)); /* of thousands of pixels */
    }
}

/* ---- by a rigid transform ------------------------------------------------------- */

enum { POINTS = 7 };

/* Points in their own frame, their pose, weights, and their pixels in each camera. */
typedef struct {
    rigcal_camera camera;
    int which;
    double R[9], t[3], x[POINTS][3], uv[POINTS][2], weight[POINTS];
    rigcal_real g[6], H[21];
} target;

static void random_target(target *T, int which, double noise_px, test_rng *rng)
{
    T->camera = camera_of(which);
    T->which = which;
    test_random_rotation(T->R, rng);
    for (int k = 0; k < 3; k++) {
        T->t[k] = k < 2 ? test_uniform(rng, -0.5, 0.5) : test_uniform(rng, 3, 5);
    }
    for (int i = 0; i < POINTS; i++) {
        double X_c[3];
        for (int k = 0; k < 3; k++) {
            T->x[i][k] = test_uniform(rng, -0.7, 0.7);
        }
        test_apply(X_c, T->R, T->x[i], T->t);
        test_project_px(T->uv[i], &T->camera, X_c);
        T->uv[i][0] += noise_px * test_uniform(rng, -1, 1);
        T->uv[i][1] += noise_px * test_uniform(rng, -1, 1);
        T->weight[i] = test_uniform(rng, 0.2, 3);
    }
}

/* The errors times the root of the weight, after the pose moved by d. Returns half their
 * sum of squares. */
static double errors(double e[2 * POINTS], const target *T, const double d[6])
{
    double R[9], t[3], half = 0;
    memcpy(R, T->R, sizeof R);
    memcpy(t, T->t, sizeof t);
    test_move(R, t, d);
    for (int i = 0; i < POINTS; i++) {
        double X_c[3], uv[2];
        test_apply(X_c, R, T->x[i], t);
        test_project_px(uv, &T->camera, X_c);
        for (int k = 0; k < 2; k++) {
            e[2 * i + k] = sqrt(T->weight[i]) * (T->uv[i][k] - uv[k]);
            half += e[2 * i + k] * e[2 * i + k] / 2;
        }
    }
    return half;
}

/* Adds all points to the library's sums. */
static void add_all(target *T, int with_curvature)
{
    rc_rigid_clear(T->g, T->H);
    for (int i = 0; i < POINTS; i++) {
        double q_c[3], X_c[3];
        rigcal_real q[3], X[3], e[2], B[6], uv[2];
        test_apply(q_c, T->R, T->x[i], NULL);
        test_apply(X_c, T->R, T->x[i], T->t);
        test_to_real(q, q_c, 3);
        test_to_real(X, X_c, 3);
        test_to_real(uv, T->uv[i], 2);
        ASSERT_STATUS(RIGCAL_OK, rc_residual(e, B, &T->camera, T->which == PINHOLE, uv, X));
        rc_rigid_add(T->g, T->H, B, q, e, RC(T->weight[i]), with_curvature ? X : NULL,
                     rc_lens_is_fisheye(&T->camera));
    }
}

/* The derivative of -e by each element of (w, dt). */
static void jacobian(double J[6][2 * POINTS], const target *T)
{
    const double h = 1e-5;
    for (int k = 0; k < 6; k++) {
        double d[6] = {0}, less[2 * POINTS], more[2 * POINTS];
        d[k] = -h;
        (void)errors(less, T, d);
        d[k] = h;
        (void)errors(more, T, d);
        for (int i = 0; i < 2 * POINTS; i++) {
            J[k][i] = (less[i] - more[i]) / (2 * h);
        }
    }
}

static double dot(const double a[], const double b[], int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

static void test_sums_by_a_transform_are_those_of_differences(void)
{
    static const double NONE[6] = {0};
    test_rng rng = test_seed(54);
    for (int trial = 0; trial < 20 * CAMERAS; trial++) {
        double J[6][2 * POINTS], e[2 * POINTS], norm;
        target T;
        random_target(&T, trial % CAMERAS, 3, &rng);
        add_all(&T, 0);
        jacobian(J, &T);
        (void)errors(e, &T, NONE);
        norm = sqrt(dot(e, e, 2 * POINTS));
        for (int i = 0; i < 6; i++) {
            const double size = sqrt(dot(J[i], J[i], 2 * POINTS));
            ASSERT_NEAR(dot(J[i], e, 2 * POINTS), T.g[i], TOL(1e-7, 1e-3) * size * norm);
            for (int j = 0; j < 6; j++) {
                ASSERT_NEAR(dot(J[i], J[j], 2 * POINTS), test_in_blocks(T.H, i, j),
                            TOL(1e-7, 1e-4) * size * sqrt(dot(J[j], J[j], 2 * POINTS)));
            }
        }
    }
}

/* The second derivative of half the sum of squares by (w, dt). For a pinhole it is exact.
 * For another lens less than a tenth of what the curvature adds to J^T J is missing. Errors
 * of 30 pixels make the curvature matter. */
static void test_sums_with_curvature_are_the_second_derivative(void)
{
    static const double MISSING[CAMERAS] = {0, 0.1, 0.06, 0.04};
    const double h = 1e-3;
    test_rng rng = test_seed(55);
    for (int trial = 0; trial < 20 * CAMERAS; trial++) {
        double J[6][2 * POINTS], e[2 * POINTS], curved = 0, missed = 0;
        target T;
        random_target(&T, trial % CAMERAS, 30, &rng);
        add_all(&T, 1);
        jacobian(J, &T);
        for (int k = 0; k < 36; k++) {
            const int i = k / 6, j = k % 6;
            const double of_i = sqrt(dot(J[i], J[i], 2 * POINTS));
            const double size = of_i * sqrt(dot(J[j], J[j], 2 * POINTS));
            double second = 0;
            for (int corner = 0; corner < 4; corner++) {
                const double a = corner / 2 ? h : -h, b = corner % 2 ? h : -h;
                double d[6] = {0};
                d[i] += a;
                d[j] += b;
                second += (a > 0 ? 1 : -1) * (b > 0 ? 1 : -1) * errors(e, &T, d);
            }
            second /= 4 * h * h;
            curved = fmax(curved, fabs(second - dot(J[i], J[j], 2 * POINTS)) / size);
            missed = fmax(missed, fabs(second - test_in_blocks(T.H, i, j)) / size);
        }
        TEST_ASSERT_TRUE(curved > 0.01); /* the test can see it */
        ASSERT_NEAR(0, missed, MISSING[trial % CAMERAS] * curved + TOL(1e-5, 1e-4));
    }
}

/* ---- by a point ------------------------------------------------------------------ */

static void test_sums_by_a_point_are_those_of_differences(void)
{
    const double h = 1e-5;
    test_rng rng = test_seed(56);
    for (int trial = 0; trial < 50 * CAMERAS; trial++) {
        rigcal_real g[3] = {1, 2, 3}, H[6] = {1, 2, 3, 4, 5, 6}, R_ca[9], e[2], B[6];
        double R[9], back[9], J[3][2], size = 0;
        sample s;
        take(&s, trial % CAMERAS, 5, &rng);
        test_random_rotation(R, &rng);
        test_to_real(R_ca, R, 9);
        test_transpose(back, R);
        for (int k = 0; k < 3; k++) { /* X_a moves along its own axes */
            double less[2], more[2], a[3], X[3];
            for (int side = -1; side <= 1; side += 2) {
                test_apply(a, back, s.X_c, NULL);
                a[k] += side * h;
                test_apply(X, R, a, NULL);
                test_project_px(side < 0 ? less : more, &s.camera, X);
            }
            J[k][0] = (more[0] - less[0]) / (2 * h);
            J[k][1] = (more[1] - less[1]) / (2 * h);
            size = fmax(size, dot(J[k], J[k], 2));
        }
        ASSERT_STATUS(RIGCAL_OK, rc_residual(e, B, &s.camera, trial % CAMERAS == PINHOLE,
                                             s.pixel, s.X));
        rc_point_add(g, H, B, R_ca, e);
        for (int i = 0, at = 0; i < 3; i++) {
            ASSERT_NEAR(1 + i + dot(J[i], s.e, 2), g[i],
                        TOL(1e-7, 1e-3) * (1 + sqrt(size) * hypot(s.e[0], s.e[1])));
            for (int j = i; j < 3; j++, at++) {
                ASSERT_NEAR(1 + at + dot(J[i], J[j], 2), H[at], TOL(1e-7, 1e-4) * size);
            }
        }
    }
}

TEST_MAIN()
{
    RUN_TEST(test_the_error_is_observed_less_projected_with_its_derivative);
    RUN_TEST(test_a_point_behind_has_no_error);
    RUN_TEST(test_a_point_just_in_front_has_its_error);
    RUN_TEST(test_along_the_ray_it_is_the_error_to_first_order);
    RUN_TEST(test_along_the_ray_the_derivative_is_that_at_the_ray);
    RUN_TEST(test_sums_by_a_transform_are_those_of_differences);
    RUN_TEST(test_sums_with_curvature_are_the_second_derivative);
    RUN_TEST(test_sums_by_a_point_are_those_of_differences);
}
