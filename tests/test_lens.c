/* lens: the lens as a map of the plane, and the place where it folds. Every answer of
 * rigcal_camera_ray is compared with a lens that is known on both sides of its fold. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "rc_lens.h"
#include "test_lenses.h"

/* The image of all rays that a lens sees, as a polygon: through the places where the lens
 * folds, each moved to `share` of its distance. */
enum { N_WAYS = 360 };
#define CHORD 0.1 /* pixels by which the polygon may miss a round rim */

typedef struct {
    double uv[N_WAYS][2];
    int ends; /* whether the lens folds in every direction */
} image_circle;

static void image_circle_of(image_circle *circle, int lens, double share)
{
    static double rim[TEST_N_LENSES][N_WAYS]; /* computed once; 0: not yet */
    const rigcal_camera camera = test_lens_camera(&TEST_LENSES[lens]);

    circle->ends = 1;
    for (int i = 0; i < N_WAYS; i++) {
        test_polar at = test_polar_at(0, 2 * TEST_PI * i / N_WAYS);
        double X_c[3];

        if (!(rim[lens][i] > 0)) {
            rim[lens][i] = test_turning_point(&camera, at, TEST_FAR);
        }
        at.out = rim[lens][i];
        if (at.out >= TEST_FAR || test_is_pole(&camera, at)) {
            circle->ends = 0;
        }
        at.out *= share;
        test_polar_ray(X_c, &camera, at);
        test_project_px(circle->uv[i], &camera, X_c);
    }
}

/* Distance of a pixel from the polygon [px]; positive inside. */
static double depth_inside(const image_circle *circle, const double uv[2])
{
    double nearest = 1e300; /* squared */
    int crossings = 0;

    for (int i = 0; i < N_WAYS; i++) {
        const double *a = circle->uv[i], *b = circle->uv[(i + 1) % N_WAYS];
        const double e[2] = {b[0] - a[0], b[1] - a[1]};
        const double w[2] = {uv[0] - a[0], uv[1] - a[1]};
        const double ee = e[0] * e[0] + e[1] * e[1];
        double s = ee > 0 ? (w[0] * e[0] + w[1] * e[1]) / ee : 0, distance;

        s = s < 0 ? 0 : s > 1 ? 1 : s;
        distance =
            (w[0] - s * e[0]) * (w[0] - s * e[0]) + (w[1] - s * e[1]) * (w[1] - s * e[1]);
        nearest = distance < nearest ? distance : nearest;
        if ((a[1] > uv[1]) != (b[1] > uv[1]) &&
            uv[0] < a[0] + e[0] * (uv[1] - a[1]) / e[1]) {
            crossings++;
        }
    }
    return crossings % 2 ? sqrt(nearest) : -sqrt(nearest);
}

/* Fails with the name of the lens and the place. */
static void fail_at(const char *what, const char *name, double u, double v)
{
    char message[200];

    snprintf(message, sizeof message, "%s: %s, (%.9g, %.9g)", what, name, u, v);
    TEST_FAIL_MESSAGE(message);
}

/* Checks that a ray is as rigcal.h says: of unit length, with this pixel, and before the
 * fold of the lens. */
static void assert_right_ray(const char *name, const rigcal_camera *camera,
                             const rigcal_real ray[3], const rigcal_real uv[2])
{
    double X_c[3], exact[2], tolerance;
    test_polar at;

    test_to_double(X_c, ray, 3);
    ASSERT_NEAR(1, test_norm(X_c), TOL(1e-15, 5e-7));
    if (camera->lens == RIGCAL_LENS_BROWN && !(X_c[2] > 0)) {
        fail_at("a ray to the side", name, D(uv[0]), D(uv[1]));
    }
    test_project_px(exact, camera, X_c);
    at = test_polar_of(camera, X_c);
    tolerance = test_pixel_tolerance(camera, at);
    if (!(fabs(exact[0] - D(uv[0])) <= tolerance &&
          fabs(exact[1] - D(uv[1])) <= tolerance)) {
        char what[100];

        snprintf(what, sizeof what, "the ray is imaged (%.3g, %.3g) off",
                 exact[0] - D(uv[0]), exact[1] - D(uv[1]));
        fail_at(what, name, D(uv[0]), D(uv[1]));
    }
    if (!(at.out <=
          test_turning_point(camera, at, 2 * at.out + 1) * TOL(1 + 1e-9, 1.001))) {
        fail_at("a ray beyond the fold", name, D(uv[0]), D(uv[1]));
    }
}

/* ---- the map ------------------------------------------------------------- */

/* F of a lens at x, from the pixel of a camera with normalised pixels. */
static void map_by_formulas(double F[2], const rigcal_camera *camera, const double x[2])
{
    rigcal_camera unit = *camera;
    const double out = hypot(x[0], x[1]);
    double X_c[3];

    unit.fx = unit.fy = 1;
    unit.cx = unit.cy = 0;
    test_polar_ray(X_c, camera, test_polar_at(out, atan2(x[1], x[0])));
    test_project_px(F, &unit, X_c);
}

static void test_the_map_and_its_derivative_are_those_of_the_formulas(void)
{
    const double h = 1e-6;
    test_rng rng = test_seed(10);

    for (int i = 0; i < TEST_N_LENSES; i++) {
        const rigcal_camera camera = test_lens_camera(&TEST_LENSES[i]);

        for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
            test_polar at = test_polar_at(0, test_uniform(&rng, -TEST_PI, TEST_PI));
            double exact[2], dx[2], dy[2], size;
            rigcal_real F[2], J[3], x_real[2];

            at.out = test_turning_point(&camera, at, 2) * test_uniform(&rng, 0, 0.9);
            x_real[0] = RC(at.out * at.c);
            x_real[1] = RC(at.out * at.s);
            for (int k = 0; k < 2; k++) {
                double less[2], more[2], x[2] = {D(x_real[0]), D(x_real[1])};

                map_by_formulas(exact, &camera, x);
                x[k] -= h;
                map_by_formulas(less, &camera, x);
                x[k] += 2 * h;
                map_by_formulas(more, &camera, x);
                for (int row = 0; row < 2; row++) {
                    (k ? dy : dx)[row] = (more[row] - less[row]) / (2 * h);
                }
            }
            TEST_ASSERT_TRUE(rc_lens_map(F, J, &camera, x_real));
            size = 1 + fabs(dx[0]) + fabs(dx[1]) + fabs(dy[1]);
            ASSERT_ARRAY_NEAR(exact, F, 2, TOL(1e-14, 1e-5) * size);
            ASSERT_NEAR(dx[0], J[0], TOL(1e-6, 1e-3) * size);
            ASSERT_NEAR(dx[1], J[1], TOL(1e-6, 1e-3) * size);
            ASSERT_NEAR(dy[0], J[1], TOL(1e-6, 1e-3) * size); /* symmetric */
            ASSERT_NEAR(dy[1], J[2], TOL(1e-6, 1e-3) * size);
        }
    }
}

/* The denominator 1 - 4 s is 0 at |x| = 0.5. */
static void test_a_pole_has_no_map(void)
{
    static const rigcal_real WITHIN[2] = {RC(0.3), RC(0.39)}, AT[2] = {0, RC(0.5)};
    static const rigcal_real BEYOND[2] = {RC(-0.5), RC(0.1)};
    rigcal_camera camera = test_pinhole();
    rigcal_real F[2], J[3];

    camera.k4 = -4;
    TEST_ASSERT_TRUE(rc_lens_map(F, J, &camera, WITHIN));
    TEST_ASSERT_FALSE(rc_lens_map(F, J, &camera, AT));
    TEST_ASSERT_FALSE(rc_lens_map(F, J, &camera, BEYOND));
}

static void test_only_browns_lens_without_coefficients_is_a_pinhole(void)
{
    const rigcal_camera pinhole = test_pinhole();
    rigcal_camera camera = pinhole;

    TEST_ASSERT_TRUE(rc_lens_is_pinhole(&pinhole));
    camera.lens = RIGCAL_LENS_FISHEYE;
    TEST_ASSERT_FALSE(rc_lens_is_pinhole(&camera));
    for (int k = 0; k < 8; k++) {
        rigcal_real *coefficient;

        camera = pinhole;
        coefficient = k == 0   ? &camera.k1
                      : k == 1 ? &camera.k2
                      : k == 2 ? &camera.p1
                      : k == 3 ? &camera.p2
                      : k == 4 ? &camera.k3
                      : k == 5 ? &camera.k4
                      : k == 6 ? &camera.k5
                               : &camera.k6;
        *coefficient = RC(-1e-20);
        TEST_ASSERT_FALSE(rc_lens_is_pinhole(&camera));
    }
}

/* ---- pixel to ray -------------------------------------------------------- */

/* Column or row `i` of n, from one border of the image to the other. */
static double across(int i, int n, int size)
{
    return -0.5 + (double)size * i / (n - 1);
}

static void test_each_pixel_of_each_lens_has_its_ray_or_none(void)
{
    enum { NX = 33, NY = 25 };
    static image_circle inner, outer;

    TEST_ON_HOST_ONLY("the polygon takes 100 KB and minutes");
    for (int i = 0; i < TEST_N_LENSES; i++) {
        const rigcal_camera camera = test_lens_camera(&TEST_LENSES[i]);
        const char *name = TEST_LENSES[i].name;

        image_circle_of(&inner, i, 0.99);
        image_circle_of(&outer, i, 1);
        for (int p = 0; p < NX * NY; p++) {
            const rigcal_real uv[2] = {RC(across(p % NX, NX, camera.width)),
                                       RC(across(p / NX, NY, camera.height))};
            const double at[2] = {D(uv[0]), D(uv[1])};
            rigcal_real ray[3];
            rigcal_status status;

            FILL(ray);
            status = rigcal_camera_ray(ray, &camera, uv);
            if (status == RIGCAL_OK) {
                assert_right_ray(name, &camera, ray, uv);
                if (outer.ends && depth_inside(&outer, at) < -CHORD) {
                    fail_at("a ray where the lens has none", name, at[0], at[1]);
                }
            } else {
                ASSERT_STATUS(RIGCAL_ERR_NO_RAY, status);
                ASSERT_UNTOUCHED(ray);
                if (depth_inside(&inner, at) > CHORD) {
                    fail_at("no ray where the lens has one", name, at[0], at[1]);
                }
            }
        }
    }
}

/* From the axis to 0.1 % before the fold. */
static void test_every_ray_before_the_turning_point_is_found_from_its_pixel(void)
{
    static const double shares[] = {1e-8, 1e-3, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97, 0.99, 0.999};

    for (int i = 0; i < TEST_N_LENSES; i++) {
        const rigcal_camera camera = test_lens_camera(&TEST_LENSES[i]);

        for (int w = 0; w < 48; w += TEST_ONE_IN) {
            for (size_t s = 0; s < sizeof shares / sizeof shares[0]; s++) {
                double X_c[3], seen[3], exact[2];
                rigcal_real uv[2], ray[3];
                test_polar at;

                at = test_polar_at(0, 2 * TEST_PI * (w + 0.25) / 48);
                at.out = test_turning_point(&camera, at, 3) * shares[s];
                test_polar_ray(X_c, &camera, at);
                test_project_px(exact, &camera, X_c);
                /* In float only to 1 %: closer to the fold the pixel may lie beyond. */
                if (!test_is_in_reach(&camera, exact) ||
                    (RIGCAL_USE_FLOAT && shares[s] > 0.99)) {
                    continue;
                }
                test_to_real(uv, exact, 2);
                if (rigcal_camera_ray(ray, &camera, uv) != RIGCAL_OK) {
                    fail_at("no ray found", TEST_LENSES[i].name, exact[0], exact[1]);
                }
                test_to_double(seen, ray, 3);
                if (!(test_ray_angle(X_c, seen) <= test_angle_tolerance(&camera, at))) {
                    fail_at("not the ray", TEST_LENSES[i].name, exact[0], exact[1]);
                }
            }
        }
    }
}

/* Rays beyond the fold have pixels too, by the formula. These are outside the image of all
 * rays before the fold, where the lens has no ray, or inside, where the right ray is
 * another one. */
static void test_a_ray_beyond_the_turning_point_never_comes_out(void)
{
    static const double shares[] = {1.02, 1.05, 1.1, 1.2, 1.5, 2, 3, 5};
    static image_circle circle;
    int outside = 0, inside = 0;

    TEST_ON_HOST_ONLY("the polygon takes 100 KB and minutes");
    for (int i = 0; i < TEST_N_LENSES; i++) {
        const rigcal_camera camera = test_lens_camera(&TEST_LENSES[i]);
        const char *name = TEST_LENSES[i].name;

        image_circle_of(&circle, i, 1);
        for (int w = 0; circle.ends && w < 48; w++) {
            for (size_t s = 0; s < sizeof shares / sizeof shares[0]; s++) {
                double X_c[3], exact[2], depth;
                rigcal_real uv[2], ray[3], X_real[3];
                rigcal_status status;
                test_polar at;

                at = test_polar_at(0, 2 * TEST_PI * (w + 0.25) / 48);
                at.out = test_turning_point(&camera, at, TEST_FAR) * shares[s];
                if (camera.lens == RIGCAL_LENS_FISHEYE && at.out > 3.1) {
                    continue;
                }
                test_polar_ray(X_c, &camera, at);
                test_to_real(X_real, X_c, 3);
                ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, uv,
                               rigcal_camera_project(uv, &camera, X_real));

                test_project_px(exact, &camera, X_c);
                if (!(fabs(exact[0]) < 1e6 && fabs(exact[1]) < 1e6)) {
                    continue;
                }
                test_to_real(uv, exact, 2);
                exact[0] = D(uv[0]);
                exact[1] = D(uv[1]);
                depth = depth_inside(&circle, exact);
                status = rigcal_camera_ray(ray, &camera, uv);
                if (depth < -CHORD) {
                    outside++;
                    if (status != RIGCAL_ERR_NO_RAY) {
                        fail_at("a ray from nowhere", name, exact[0], exact[1]);
                    }
                } else if (depth > CHORD) {
                    inside++;
                    if (status != RIGCAL_OK) {
                        fail_at("no ray", name, exact[0], exact[1]);
                    }
                    if (test_is_in_reach(&camera, exact)) {
                        assert_right_ray(name, &camera, ray, uv);
                    }
                }
            }
        }
    }
    /* Both cases happen often with these lenses. */
    TEST_ASSERT_TRUE(outside > 300);
    TEST_ASSERT_TRUE(inside > 300);
}

static void test_projection_ends_at_the_turning_point(void)
{
    for (int i = 0; i < TEST_N_LENSES; i++) {
        const rigcal_camera camera = test_lens_camera(&TEST_LENSES[i]);

        for (int w = 0; w < 60; w += TEST_ONE_IN) {
            const double way = 2 * TEST_PI * w / 60;
            const double end = test_turning_point(&camera, test_polar_at(0, way), TEST_FAR);
            const double within = TOL(1e-6, 1e-3);
            const test_polar before = test_polar_at(end * (1 - within), way);
            const test_polar beyond = test_polar_at(end * (1 + within), way);
            double X[3];
            rigcal_real X_c[3], uv[2];

            /* For a Brown lens not beyond 88.8 degrees. */
            if (end >= (camera.lens == RIGCAL_LENS_FISHEYE ? TEST_PI : 50)) {
                continue;
            }
            test_polar_ray(X, &camera, before);
            test_to_real(X_c, X, 3);
            ASSERT_STATUS(RIGCAL_OK, rigcal_camera_project(uv, &camera, X_c));
            test_polar_ray(X, &camera, beyond);
            test_to_real(X_c, X, 3);
            ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, uv, rigcal_camera_project(uv, &camera, X_c));
        }
    }
}

/* ---- the iteration that is not used -------------------------------------- */

/* x <- (xd - tangential) / d, the common method. Returns by how many pixels its projection
 * is off after `steps`. */
static double fixed_point_error(const rigcal_camera *c, const double uv[2], int steps)
{
    const double xd = (uv[0] - D(c->cx)) / D(c->fx);
    const double yd = (uv[1] - D(c->cy)) / D(c->fy);
    double x = xd, y = yd, X_c[3], seen[2];

    for (int i = 0; i < steps; i++) {
        const double q = x * x + y * y;
        const double d = (1 + q * (D(c->k1) + q * (D(c->k2) + q * D(c->k3)))) /
                         (1 + q * (D(c->k4) + q * (D(c->k5) + q * D(c->k6))));
        const double tx = 2 * D(c->p1) * x * y + D(c->p2) * (q + 2 * x * x);
        const double ty = D(c->p1) * (q + 2 * y * y) + 2 * D(c->p2) * x * y;

        x = (xd - tx) / d;
        y = (yd - ty) / d;
    }
    X_c[0] = x;
    X_c[1] = y;
    X_c[2] = 1;
    test_project_px(seen, c, X_c);
    return hypot(seen[0] - uv[0], seen[1] - uv[1]);
}

static void test_pixels_on_which_the_fixed_point_iteration_fails_have_a_ray(void)
{
    int failed = 0;

    TEST_ON_HOST_ONLY("a rate wants all pixels");
    for (int i = 0; i < TEST_N_LENSES; i++) {
        const rigcal_camera camera = test_lens_camera(&TEST_LENSES[i]);

        for (int w = 0; camera.lens == RIGCAL_LENS_BROWN && w < 24; w++) {
            for (int s = 1; s < 50; s++) {
                double X_c[3], exact[2];
                rigcal_real uv[2], ray[3];
                test_polar at;

                at = test_polar_at(0, 2 * TEST_PI * w / 24);
                at.out = test_turning_point(&camera, at, 2) * s / 50;
                test_polar_ray(X_c, &camera, at);
                test_project_px(exact, &camera, X_c);
                if (!test_is_in_reach(&camera, exact) ||
                    fixed_point_error(&camera, exact, 200) < 1) {
                    continue;
                }
                failed++;
                test_to_real(uv, exact, 2);
                ASSERT_STATUS(RIGCAL_OK, rigcal_camera_ray(ray, &camera, uv));
                assert_right_ray(TEST_LENSES[i].name, &camera, ray, uv);
            }
        }
    }
    TEST_ASSERT_TRUE(failed > (RIGCAL_USE_FLOAT ? 100 : 500));
}

/* ---- lenses of all kinds ------------------------------------------------- */

static rigcal_camera random_camera(test_rng *rng, int radial)
{
    rigcal_camera c;
    const int fisheye = test_next(rng) % 4 == 0;
    const int rational = !fisheye && test_next(rng) % 3 == 0;
    const double k = fisheye ? 0.1 : 0.5, p = radial || fisheye ? 0 : 0.05;

    memset(&c, 0, sizeof c);
    c.lens = fisheye ? RIGCAL_LENS_FISHEYE : RIGCAL_LENS_BROWN;
    c.width = (int32_t)test_uniform(rng, 300, 4000);
    c.height = (int32_t)test_uniform(rng, 300, 4000);
    c.fx = RC(test_uniform(rng, 0.3, 2) * c.width);
    c.fy = RC(D(c.fx) * test_uniform(rng, 0.9, 1.1));
    c.cx = RC(test_uniform(rng, -0.2, 1.2) * c.width);
    c.cy = RC(test_uniform(rng, -0.2, 1.2) * c.height);
    c.k1 = RC(test_uniform(rng, -k, k));
    c.k2 = RC(test_uniform(rng, -k, k) / 2);
    c.k3 = RC(test_uniform(rng, -k, k) / 4);
    c.p1 = RC(test_uniform(rng, -p, p));
    c.p2 = RC(test_uniform(rng, -p, p));
    if (fisheye) {
        c.k4 = RC(test_uniform(rng, -k, k) / 8);
    } else if (rational) {
        c.k4 = RC(test_uniform(rng, -0.5, 0.5));
        c.k5 = RC(test_uniform(rng, -0.3, 0.3));
        c.k6 = RC(test_uniform(rng, -0.1, 0.1));
    }
    return c;
}

static void random_pixel(rigcal_real uv[2], const rigcal_camera *camera, test_rng *rng)
{
    uv[0] = RC(test_uniform(rng, -0.5, camera->width - 0.5));
    uv[1] = RC(test_uniform(rng, -0.5, camera->height - 0.5));
}

static void test_any_lens_gives_right_rays_only(void)
{
    test_rng rng = test_seed(7);

    for (int trial = 0; trial < TEST_TRIALS(1000); trial++) {
        const rigcal_camera camera = random_camera(&rng, trial % 2);
        char name[40];

        snprintf(name, sizeof name, "random lens %d", trial);
        for (int i = 0; i < 8; i++) {
            rigcal_real uv[2], ray[3], again[2];
            rigcal_status status;

            random_pixel(uv, &camera, &rng);
            status = rigcal_camera_ray(ray, &camera, uv);
            if (status != RIGCAL_OK) {
                ASSERT_STATUS(RIGCAL_ERR_NO_RAY, status);
                continue;
            }
            assert_right_ray(name, &camera, ray, uv);
            /* The library projects the ray. In float a ray may round to beyond the fold. */
            status = rigcal_camera_project(again, &camera, ray);
            if (!RIGCAL_USE_FLOAT || status == RIGCAL_OK) {
                const double expected[2] = {D(uv[0]), D(uv[1])};

                ASSERT_STATUS(RIGCAL_OK, status);
                ASSERT_ARRAY_NEAR(expected, again, 2, TOL(2e-9, 1e-2));
            }
        }
    }
}

static void test_any_lens_gives_every_ray_before_its_turning_point(void)
{
    test_rng rng = test_seed(8);

    for (int trial = 0; trial < TEST_TRIALS(1000); trial++) {
        const rigcal_camera camera = random_camera(&rng, trial % 2);
        char name[40];

        snprintf(name, sizeof name, "random lens %d", trial);
        for (int i = 0; i < 4; i++) {
            double X_c[3], seen[3], exact[2];
            rigcal_real uv[2], ray[3];
            test_polar at;

            at = test_polar_at(0, test_uniform(&rng, -TEST_PI, TEST_PI));
            at.out = test_turning_point(&camera, at, 3) * test_uniform(&rng, 0, 0.99);
            test_polar_ray(X_c, &camera, at);
            test_project_px(exact, &camera, X_c);
            if (!test_is_in_reach(&camera, exact)) {
                continue;
            }
            test_to_real(uv, exact, 2);
            if (rigcal_camera_ray(ray, &camera, uv) != RIGCAL_OK) {
                fail_at("no ray found", name, exact[0], exact[1]);
            }
            test_to_double(seen, ray, 3);
            if (!(test_ray_angle(X_c, seen) <= 2 * test_angle_tolerance(&camera, at))) {
                fail_at("not the ray", name, exact[0], exact[1]);
            }
        }
    }
}

/* The least test_steepness on the way to `share` of a place. If it is nearly 0, a march in
 * steps may have missed a fold. */
static double least_steepness(const rigcal_camera *camera, test_polar at, double share)
{
    double least = 1;

    for (int i = 0; i < 400; i++) {
        test_polar there = at;
        double here;

        there.out = at.out * share * i / 400;
        here = test_steepness(camera, there);
        least = here < least ? here : least;
    }
    return least;
}

static void test_any_lens_projects_up_to_its_turning_point_and_not_beyond(void)
{
    /* For the strangest lenses the library leaves out the last 0.2 %. */
    const double within = TOL(5e-3, 1e-2);
    const double shares[] = {0.3, 1 - within, 1 + within, 1.1, 1.5, 3, 10};
    test_rng rng = test_seed(12);

    for (int trial = 0; trial < TEST_TRIALS(1000); trial++) {
        const rigcal_camera camera = random_camera(&rng, trial % 4 == 0);

        for (int i = 0; i < 4; i++) {
            test_polar at = test_polar_at(0, test_uniform(&rng, -TEST_PI, TEST_PI));
            /* Closer to 90 degrees the library may end a little early. */
            const double far = camera.lens == RIGCAL_LENS_BROWN ? 4 : TEST_PI;
            const double end = test_turning_point(&camera, at, far);

            for (int k = 0; k < 7; k++) {
                double X[3];
                rigcal_real X_c[3], uv[2];

                at.out = end * shares[k];
                if ((camera.lens == RIGCAL_LENS_FISHEYE && at.out > 3.14) ||
                    (camera.lens == RIGCAL_LENS_BROWN && end >= far && shares[k] > 1) ||
                    (shares[k] < 1 && least_steepness(&camera, at, 0.97) < 0.01)) {
                    continue;
                }
                test_polar_ray(X, &camera, at);
                test_to_real(X_c, X, 3);
                if (rigcal_camera_project(uv, &camera, X_c) !=
                    (shares[k] < 1 ? RIGCAL_OK : RIGCAL_ERR_NO_RAY)) {
                    char name[40];

                    snprintf(name, sizeof name, "random lens %d", trial);
                    fail_at(shares[k] < 1 ? "not projected" : "projected", name, at.out,
                            shares[k]);
                }
            }
        }
    }
}

/* Without tangential distortion the image of a lens is a disc. The march finds its radius
 * exactly. */
static void test_a_radial_lens_has_rays_exactly_inside_its_circle(void)
{
    test_rng rng = test_seed(9);
    int none = 0;

    for (int trial = 0; trial < TEST_TRIALS(1000); trial++) {
        rigcal_camera camera = random_camera(&rng, 1);
        double X_c[3], rim[2], radius;
        test_polar edge = test_polar_at(0, 0);

        camera.fy = camera.fx;
        edge.out = test_turning_point(&camera, edge, TEST_FAR);
        if (RIGCAL_USE_FLOAT && test_is_pole(&camera, edge)) {
            continue;
        }
        test_polar_ray(X_c, &camera, edge);
        test_project_px(rim, &camera, X_c);
        radius = rim[0] - D(camera.cx);
        for (int i = 0; i < 8; i++) {
            rigcal_real uv[2], ray[3];
            double out;
            rigcal_status status;

            random_pixel(uv, &camera, &rng);
            out = hypot(D(uv[0]) - D(camera.cx), D(uv[1]) - D(camera.cy));
            status = rigcal_camera_ray(ray, &camera, uv);
            if (edge.out < TEST_FAR && out > radius * (1 + TOL(1e-9, 1e-4))) {
                none++;
                ASSERT_STATUS(RIGCAL_ERR_NO_RAY, status);
            } else if (out < radius * (1 - TOL(1e-6, 1e-3))) {
                ASSERT_STATUS(RIGCAL_OK, status);
            }
        }
    }
    TEST_ASSERT_TRUE(none > (TEST_ONE_IN > 1 ? 0 : 1000)); /* few trials may have few */
}

/* ---- where bounds do not decide -------------------------------------------- */

/* With k4 = -1 the denominator is 1 - r^2, so the lens has a pole at r = 1. */
static void test_nothing_is_proved_beyond_a_pole(void)
{
    const rigcal_camera camera = {.fx = 1, .fy = 1, .k4 = -1};
    const rigcal_real before[2] = {RC(0.6), RC(0.5)}, beyond[2] = {2, RC(0.5)};

    TEST_ASSERT_TRUE(rc_lens_is_usable(&camera, before));
    TEST_ASSERT_FALSE(rc_lens_is_usable(&camera, beyond));
#if RIGCAL_FOR_SPEED
    const rigcal_real proved2 = rc_lens_proved(&camera, RC(1.1));
    rigcal_real x[2];

    TEST_ASSERT_TRUE(proved2 > 0 && proved2 < 1);
    TEST_ASSERT_FALSE(rc_lens_invert_within(x, &camera, beyond, 9)); /* not proved */
#endif
}

/* With k3 = -5/7 and k6 = -1 the denominator is 1 - r^6. The slope of the map is 1 + 5/7
 * r^12, divided by its square. So only the denominator shows the pole at r = 1. Just behind
 * the pole, the last term of its bound decides. */
static void test_a_pole_that_the_slope_does_not_show_ends_what_is_usable(void)
{
    const rigcal_camera camera = {.fx = 1, .fy = 1, .k3 = RC(-5.0 / 7), .k6 = -1};

    for (int way = 0; way < 8; way++) {
        const double c = cos(TEST_PI / 4 * way), s = sin(TEST_PI / 4 * way);
        const double before = sqrt(0.98), beyond = sqrt(1.02);
        const rigcal_real seen[2] = {RC(before * c), RC(before * s)};
        const rigcal_real unseen[2] = {RC(beyond * c), RC(beyond * s)};

        TEST_ASSERT_TRUE(rc_lens_is_usable(&camera, seen));
        TEST_ASSERT_FALSE(rc_lens_is_usable(&camera, unseen));
    }
}

/* F = r - r^3 / 3 turns back at r = 1. Near that place a step of Newton's method only
 * halves the error. From F(0.999) the first error is a third. */
static void test_a_place_near_the_turn_takes_more_than_a_few_steps(void)
{
#if RIGCAL_FOR_SPEED
    const rigcal_camera camera = {.fx = 1, .fy = 1, .k1 = RC(-1.0 / 3)};
    const rigcal_real target[2] = {RC(0.999 - 0.999 * 0.999 * 0.999 / 3), 0};
    rigcal_real x[2];

    TEST_ASSERT_FALSE(rc_lens_invert_within(x, &camera, target, RC(0.9999)));
    TEST_ASSERT_TRUE(rc_lens_invert(x, &camera, target, RC(TOL(1e-12, 1e-6))));
    ASSERT_NEAR(0.999, x[0], TOL(1e-9, 2e-3));
#endif
}

/* The lens turns back at r = 1. Newton's method, written out here along the radius, tells
 * how near it is before each step. Its last step begins within 1e-5 of the target, in float
 * within 1e-4. A place is found if the fifth step can be the last. */
static void test_a_place_is_found_if_five_steps_reach_it(void)
{
#if RIGCAL_FOR_SPEED
    enum { STEPS = 5 };
    const rigcal_camera camera = {.fx = 1, .fy = 1, .k1 = RC(-1.0 / 3)};
    const double near = TOL(1e-5, 1e-4);
    int n_last = 0, n_more = 0;

    for (int i = 500; i < 999; i++) {
        const double place = i / 1000.0, wanted = place - place * place * place / 3;
        const rigcal_real target[2] = {RC(0.6 * wanted), RC(-0.8 * wanted)};
        double r = wanted, miss[STEPS];
        rigcal_real x[2];

        for (int k = 0; k < STEPS; k++) {
            miss[k] = fabs(wanted - (r - r * r * r / 3));
            r += (wanted - (r - r * r * r / 3)) / (1 - r * r);
        }
        const int is_found = rc_lens_invert_within(x, &camera, target, RC(0.9999));
        if (miss[STEPS - 1] > 1.1 * near) {
            TEST_ASSERT_FALSE(is_found);
            n_more++;
        } else if (miss[STEPS - 1] < 0.9 * near) {
            TEST_ASSERT_TRUE(is_found);
            ASSERT_NEAR(place, hypot(D(x[0]), D(x[1])), TOL(1e-7, 1e-3));
            n_last += miss[STEPS - 2] > 1.1 * near;
        }
    }
    TEST_ASSERT_TRUE(n_last > 0 && n_more > 0);
#endif
}

/* The slope is a thousand and more just before a pole. There the way to a pixel is followed
 * in 32 parts or 64. */
static void test_a_place_before_a_pole_is_reached_in_many_parts(void)
{
#if !RIGCAL_USE_FLOAT
    static const double K[4][6] = {{2.25, -0.3, 2, -0.25, -3.16, 2.46},
                                   {1.41, 0.67, 1.28, -2.16, -0.09, 1.7},
                                   {-0.08, 0.14, 0.06, -0.11, -0.28, 0.07},
                                   {0.2, 0.21, 0.06, -0.16, -0.1, 0.02}};
    static const double RADIUS[4] = {0.88, 0.78, 1.64, 1.97};

    for (int i = 0; i < 4; i++) {
        const rigcal_camera camera = {.fx = 1,
                                      .fy = 1,
                                      .k1 = RC(K[i][0]),
                                      .k2 = RC(K[i][1]),
                                      .k3 = RC(K[i][2]),
                                      .k4 = RC(K[i][3]),
                                      .k5 = RC(K[i][4]),
                                      .k6 = RC(K[i][5])};
        const rigcal_real place[2] = {RC(RADIUS[i]), 0};
        rigcal_real F[2], J[3], x[2];

        TEST_ASSERT_TRUE(rc_lens_map(F, J, &camera, place));
        TEST_ASSERT_TRUE(rc_lens_is_usable(&camera, place));
        TEST_ASSERT_TRUE(rc_lens_invert(x, &camera, F, RC(1e-10)));
        ASSERT_NEAR(RADIUS[i], x[0], 1e-9);
        ASSERT_NEAR(0, x[1], 1e-12);
    }
#endif
}

/* Newton's method in a disc that is proved ends in the disc, to the edge and no farther.
 * What the place was before is not looked at, nor what lies behind its two numbers. */
static void test_a_place_in_a_disc_is_found_if_it_is_in_it(void)
{
#if RIGCAL_FOR_SPEED
    const rigcal_camera camera = {.fx = 1, .fy = 1, .k1 = RC(0.1)};
    const double radius = hypot(0.3, -0.4), scale = 1 + 0.1 * radius * radius;
    const rigcal_real target[2] = {RC(0.3 * scale), RC(-0.4 * scale)};
    rigcal_real x[3] = {TEST_NAN, TEST_NAN, TEST_NAN};

    TEST_ASSERT_TRUE(rc_lens_invert_within(x, &camera, target, 1));
    ASSERT_NEAR(0.3, x[0], TOL(1e-12, 1e-6));
    ASSERT_NEAR(-0.4, x[1], TOL(1e-12, 1e-6));
    TEST_ASSERT_TRUE(rc_lens_invert_within(x, &camera, target, RC(0.27)));
    TEST_ASSERT_FALSE(rc_lens_invert_within(x, &camera, target, RC(0.249)));
#endif
}

#if RIGCAL_FOR_SPEED
/* F of a lens of second degree with tangential distortion. */
static void seen_at(double F[2], const double k[2], const double p[2], const double x[2])
{
    const double s = x[0] * x[0] + x[1] * x[1], radial = 1 + k[0] * s + k[1] * s * s;

    F[0] = x[0] * radial + 2 * p[0] * x[0] * x[1] + p[1] * (s + 2 * x[0] * x[0]);
    F[1] = x[1] * radial + p[0] * (s + 2 * x[1] * x[1]) + 2 * p[1] * x[0] * x[1];
}

/* Whether F has a slope in all directions at x, by differences. */
static int has_slope(const double k[2], const double p[2], const double x[2])
{
    const double h = 1e-5;
    double J[3][2];

    for (int i = 0; i < 2; i++) {
        double low[2] = {x[0], x[1]}, high[2] = {x[0], x[1]}, F[2][2];

        low[i] -= h;
        high[i] += h;
        seen_at(F[0], k, p, low);
        seen_at(F[1], k, p, high);
        J[i][0] = (F[1][0] - F[0][0]) / (2 * h);
        J[i][1] = (F[1][1] - F[0][1]) / (2 * h);
    }
    return J[0][0] > 0 && J[1][1] > 0 && J[0][0] * J[1][1] > J[0][1] * J[0][1];
}

/* The radius within which all places lie that are seen within `reach`. p moves a place
 * towards the axis by up to 3 |p| r^2, on one side of it. */
static double radius_seen(const double k[2], const double p[2], double reach)
{
    double low = 0, high = 2 * reach;

    for (int i = 0; i < 60; i++) {
        const double r = (low + high) / 2, s = r * r;
        const double seen = r * (1 + k[0] * s + k[1] * s * s) - 3 * hypot(p[0], p[1]) * s;

        low = seen < reach ? r : low;
        high = seen < reach ? high : r;
    }
    return low;
}
#endif

/* Every place of a proved disc has a slope. If the lens bends little, the disc holds all
 * places that are seen within its reach, and is a tenth wider. */
static void test_a_proved_disc_holds_what_is_seen_within_its_reach(void)
{
#if RIGCAL_FOR_SPEED
    test_rng rng = test_seed(415);
    double from = 2, to = 0;
    int n_less = 0;

    for (int trial = 0; trial < TEST_TRIALS(4000); trial++) {
        const int is_strong = trial % 2;
        const double most = is_strong ? 0.5 : 0.1, reach = test_uniform(&rng, 0.05, 0.3);
        const double wide = is_strong ? 8 * reach : reach;
        const double k[2] = {test_uniform(&rng, -most, most),
                             test_uniform(&rng, -most, most)};
        const double p[2] = {test_uniform(&rng, -most, most),
                             test_uniform(&rng, -most, most)};
        const rigcal_camera camera = {.fx = 1,
                                      .fy = 1,
                                      .k1 = RC(k[0]),
                                      .k2 = RC(k[1]),
                                      .p1 = RC(p[0]),
                                      .p2 = RC(p[1])};
        const double proved2 = D(rc_lens_proved(&camera, RC(wide)));

        for (int i = 0; i < 12; i++) {
            const double way = TEST_PI / 6 * i, r = sqrt(proved2);
            double x[2] = {r * cos(way), r * sin(way)}, F[2];

            if (is_strong) {
                TEST_ASSERT_TRUE(has_slope(k, p, x) || RIGCAL_USE_FLOAT);
            } else {
                seen_at(F, k, p, x);
                TEST_ASSERT_TRUE(hypot(F[0], F[1]) >= reach);
            }
        }
        n_less += is_strong && proved2 < wide * wide;
        if (!is_strong) {
            const double more = sqrt(proved2) / radius_seen(k, p, reach);

            from = fmin(from, more);
            to = fmax(to, more);
        }
    }
    TEST_ASSERT_TRUE(from > 1.099 && to < 1.1 + TOL(1e-9, 1e-5));
    TEST_ASSERT_TRUE(n_less > TEST_TRIALS(100));
#endif
}

/* Along x the slope of the map is m at r = 1, and its next three derivatives are 0 there.
 * So the slope is nearly 0 over a long part, and a proof would take more steps than are
 * allowed. */
static void test_a_proof_that_takes_too_long_is_none(void)
{
    const double m = 1e-4, e = (1 - m) / 5;
    const rigcal_camera camera = {.fx = 1,
                                  .fy = 1,
                                  .p2 = RC(-16 * e / 6),
                                  .k1 = RC(5 * e),
                                  .k2 = RC(-e),
                                  .k3 = RC(e / 7)};
    const rigcal_real near[2] = {RC(0.5), 0}, far[2] = {2, 0};

    for (int i = 0; i <= 400; i++) {
        const rigcal_real x[2] = {RC(2 * i / 400.0), 0};
        rigcal_real F[2], J[3];

        TEST_ASSERT_TRUE(rc_lens_map(F, J, &camera, x));
        TEST_ASSERT_TRUE(J[0] > 0 && J[2] > RC(0.5));
        ASSERT_NEAR(0, J[1], 0);
    }
    TEST_ASSERT_TRUE(rc_lens_is_usable(&camera, near));
    TEST_ASSERT_FALSE(rc_lens_is_usable(&camera, far));
}

/* With p1 alone, rays along x are bent only sideways. There J = (1, 2 p1 r; 2 p1 r, 1), so
 * the lens turns back at r = 1 / (2 p1). */
static void test_a_lens_that_bends_only_sideways_is_proved_to_its_turn(void)
{
    const rigcal_camera camera = {.fx = 1, .fy = 1, .p1 = RC(0.25)};
    const rigcal_real before[2] = {RC(1.99), 0}, beyond[2] = {RC(2.01), 0};

    TEST_ASSERT_TRUE(rc_lens_is_usable(&camera, before));
    TEST_ASSERT_FALSE(rc_lens_is_usable(&camera, beyond));
}

static void test_a_place_whose_square_overflows_is_not_usable(void)
{
    const rigcal_camera camera = {.fx = 1, .fy = 1, .k1 = RC(0.1)};
    const rigcal_real far[2] = {RC(TOL(1e200, 1e30)), 0};

    TEST_ASSERT_FALSE(rc_lens_is_usable(&camera, far));
}

/* What is exact needs no tolerance. */
static void test_the_answer_of_an_exact_lens_has_no_error(void)
{
    const rigcal_camera camera = {.fx = 1, .fy = 1};
    const rigcal_real target[2] = {RC(0.5), RC(-0.25)};
    rigcal_real x[2];

    TEST_ASSERT_TRUE(rc_lens_invert(x, &camera, target, 0));
    ASSERT_NEAR(0.5, x[0], 0);
    ASSERT_NEAR(-0.25, x[1], 0);
}

TEST_MAIN()
{
    RUN_TEST(test_the_answer_of_an_exact_lens_has_no_error);
    RUN_TEST(test_the_map_and_its_derivative_are_those_of_the_formulas);
    RUN_TEST(test_a_pole_has_no_map);
    RUN_TEST(test_only_browns_lens_without_coefficients_is_a_pinhole);
    RUN_TEST(test_each_pixel_of_each_lens_has_its_ray_or_none);
    RUN_TEST(test_every_ray_before_the_turning_point_is_found_from_its_pixel);
    RUN_TEST(test_a_ray_beyond_the_turning_point_never_comes_out);
    RUN_TEST(test_projection_ends_at_the_turning_point);
    RUN_TEST(test_pixels_on_which_the_fixed_point_iteration_fails_have_a_ray);
    RUN_TEST(test_any_lens_gives_right_rays_only);
    RUN_TEST(test_any_lens_gives_every_ray_before_its_turning_point);
    RUN_TEST(test_any_lens_projects_up_to_its_turning_point_and_not_beyond);
    RUN_TEST(test_a_radial_lens_has_rays_exactly_inside_its_circle);
    RUN_TEST(test_nothing_is_proved_beyond_a_pole);
    RUN_TEST(test_a_pole_that_the_slope_does_not_show_ends_what_is_usable);
    RUN_TEST(test_a_place_near_the_turn_takes_more_than_a_few_steps);
    RUN_TEST(test_a_place_is_found_if_five_steps_reach_it);
    RUN_TEST(test_a_place_before_a_pole_is_reached_in_many_parts);
    RUN_TEST(test_a_place_in_a_disc_is_found_if_it_is_in_it);
    RUN_TEST(test_a_proved_disc_holds_what_is_seen_within_its_reach);
    RUN_TEST(test_a_proof_that_takes_too_long_is_none);
    RUN_TEST(test_a_lens_that_bends_only_sideways_is_proved_to_its_turn);
    RUN_TEST(test_a_place_whose_square_overflows_is_not_usable);
}
