/* camera: pixels, rays and the lenses between them. The truth is made here,
 * in doubles: the lens formulas of rigcal.h (tests/support), their
 * derivatives, and a march along straight lines from the optical axis that
 * finds where a lens turns back. So every answer of rigcal_camera_ray is
 * held against a lens that is known on both sides of its fold. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "rc_camera.h"
#include "test_support.h"

#define BROWN RIGCAL_LENS_BROWN
#define FISHEYE RIGCAL_LENS_FISHEYE

/* What rigcal.h promises of a ray's projection [px]. */
#define PX TOL(1e-9, 2e-3)

/* ---- lenses -------------------------------------------------------------- */

typedef struct {
    const char *name;
    int lens, width, height;
    double fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6;
} lens_row;

/* clang-format off */
static const lens_row LENSES[] = {
    /* Calibrations of real cameras. */
    {"dlt_cube", BROWN, 2272, 1704, 3136, 3136, 1135.5, 851.5,
     0, 0, 0, 0, 0, 0, 0, 0},
    {"myptv_stepped cam1", BROWN, 1280, 1024, 6258.04381, 6258.04381, 639.5,
     511.5, 0.0743445903, 0, -0.0186826291, 0.0120865969, 0, 0, 0, 0},
    {"myptv_stepped cam2", BROWN, 1280, 1024, 6955.91462, 6955.91462, 639.5,
     511.5, 0.303835703, 0, -0.00794510485, -0.0507388265, 0, 0, 0, 0},
    {"myptv_stepped cam3", BROWN, 1280, 1024, 6243.77321, 6243.77321, 639.5,
     511.5, 0.311168365, 0, -0.0044606639, 0.0457983587, 0, 0, 0, 0},
    {"opencv_stereo left", BROWN, 640, 480, 532.827202, 532.945966, 342.486827,
     233.855749, -0.280881878, 0.0251767621, 0.00121651108, -0.000135518959,
     0.163436932, 0, 0, 0},
    {"opencv_stereo right", BROWN, 640, 480, 537.453128, 536.969026, 327.585658,
     248.881876, -0.297547192, 0.149679574, -0.000759746274, 0.000326442947,
     -0.0660131344, 0, 0, 0},
    {"openptv_cavity cam3", BROWN, 1280, 1024, 5948.36156, 5948.36156, 639.5,
     511.5, -0.987992864, 0, 0.0331262536, -0.0377593593, 0, 0, 0, 0},
    {"openptv_cavity cam4", BROWN, 1280, 1024, 6460.12801, 6460.12801, 639.5,
     511.5, -0.540610269, 0, -0.00674804428, 0.024492262, 0, 0, 0, 0},
    {"openptv_multiplane cam2", BROWN, 1920, 1200, 7460.23261, 7460.23261,
     959.5, 599.5, 0.27629944, 0, -0.0493503136, -0.0119053394, 0, 0, 0, 0},
    {"pose2sim cam01", BROWN, 1088, 1920, 1681.24487, 1681.07544, 532.973694,
     948.13739, -0.046183, 0.139983, 0.000608, 0.00069, 0, 0, 0, 0},
    /* Of the kinds that OpenCV's rational model gives. */
    {"rational, 90 degrees", BROWN, 1280, 720, 611, 610.6, 637.2, 369.4,
     0.455, -2.51, 0.0006, -0.0002, 1.44, 0.336, -2.34, 1.37},
    {"rational, 120 degrees", BROWN, 1024, 1024, 504.4, 504.5, 514.2, 521.9,
     5.2, 2.6, -0.00005, 0.00003, 0.13, 5.5, 4.1, 0.7},
    {"rational, wide", BROWN, 1920, 1080, 950, 955, 940, 560,
     5.1, 2.2, 0.0003, 0.0002, 0.11, 5.4, 4.1, 0.62},
    /* Each way in which a polynomial can bend. */
    {"barrel whose circle ends in the image", BROWN, 1280, 960, 500, 500, 640,
     480, -0.4, 0, 0, 0, 0, 0, 0, 0},
    {"strong barrel held by k2", BROWN, 1280, 960, 420, 425, 631, 488,
     -0.45, 0.2, 0.001, -0.002, 0, 0, 0, 0},
    {"barrel, then k3 pulls out", BROWN, 1280, 960, 600, 600, 650, 470,
     -0.35, 0.12, 0, 0, 0.01, 0, 0, 0},
    {"pincushion", BROWN, 1280, 960, 300, 310, 640, 480,
     0.5, 0.1, 0, 0, 0, 0, 0, 0},
    {"k3 outwards", BROWN, 1280, 960, 450, 450, 640, 480,
     0, 0, 0, 0, 0.5, 0, 0, 0},
    {"k3 inwards", BROWN, 1280, 960, 500, 505, 630, 470,
     0.1, 0.05, 0, 0, -0.12, 0, 0, 0},
    {"outwards, then back", BROWN, 1600, 1200, 600, 600, 800, 600,
     0.4, -0.2, 0.001, 0.001, 0, 0, 0, 0},
    {"a pole of the denominator", BROWN, 1280, 960, 500, 500, 640, 480,
     0, 0, 0, 0, 0, -0.3, 0, 0},
    {"tangential", BROWN, 1280, 960, 700, 700, 640, 480,
     -0.2, 0.05, 0.05, -0.05, 0, 0, 0, 0},
    {"tangential and nothing else", BROWN, 1280, 960, 500, 500, 640, 480,
     0, 0, -0.05, 0.04, 0, 0, 0, 0},
    {"principal point outside", BROWN, 800, 600, 700, 700, -90, 720,
     -0.05, 0.002, 0, 0, 0, 0, 0, 0},
    {"principal point far outside, barrel", BROWN, 800, 600, 900, 900, 1500,
     -400, -0.25, 0.03, 0.001, 0.002, 0, 0, 0, 0},
    {"pixels twice as wide as high", BROWN, 720, 576, 500, 1000, 360, 288,
     -0.3, 0.1, 0.002, 0.001, 0, 0, 0, 0},
    {"4000 pixels", BROWN, 4000, 3000, 2800, 2800, 2011, 1490,
     -0.12, 0.11, 0.0004, -0.0003, -0.02, 0, 0, 0},
    {"fisheye, 180 degrees", FISHEYE, 1280, 960, 380, 381, 640.5, 470,
     -0.02, 0.006, 0, 0, -0.003, 0.0004, 0, 0},
    {"fisheye, 220 degrees", FISHEYE, 1200, 1200, 300, 300, 599.5, 599.5,
     0, 0, 0, 0, 0, 0, 0, 0},
    {"fisheye, circle ends in the image", FISHEYE, 1600, 1200, 420, 420, 800,
     600, -0.1, 0, 0, 0, 0, 0, 0, 0},
    {"fisheye, all round", FISHEYE, 2000, 2000, 250, 250, 1000, 1000,
     0.01, 0.001, 0, 0, 0, 0, 0, 0},
    {"fisheye, outside", FISHEYE, 640, 480, 350, 352, 700, -30,
     0.05, -0.03, 0, 0, 0.01, -0.002, 0, 0},
};
/* clang-format on */
enum { N_LENSES = sizeof LENSES / sizeof LENSES[0] };

static rigcal_camera camera_of(const lens_row *row)
{
    rigcal_camera c;

    memset(&c, 0, sizeof c);
    c.lens = row->lens;
    c.width = row->width;
    c.height = row->height;
    c.fx = RC(row->fx);
    c.fy = RC(row->fy);
    c.cx = RC(row->cx);
    c.cy = RC(row->cy);
    c.k1 = RC(row->k1);
    c.k2 = RC(row->k2);
    c.p1 = RC(row->p1);
    c.p2 = RC(row->p2);
    c.k3 = RC(row->k3);
    c.k4 = RC(row->k4);
    c.k5 = RC(row->k5);
    c.k6 = RC(row->k6);
    return c;
}

/* ---- the truth about a lens ---------------------------------------------- */

/* A ray by its way off the axis: `out` = tan(angle) for Brown, the angle for a
 * fisheye, in the direction (c, s) of the image. */
typedef struct {
    double out, c, s;
} polar;

static polar polar_at(double out, double way)
{
    polar at;

    at.out = out;
    at.c = cos(way);
    at.s = sin(way);
    return at;
}

static void ray_of(double X_c[3], const rigcal_camera *camera, polar at)
{
    const int fisheye = camera->lens == FISHEYE;
    const double r = fisheye ? sin(at.out) : at.out;

    X_c[0] = r * at.c;
    X_c[1] = r * at.s;
    X_c[2] = fisheye ? cos(at.out) : 1;
}

static polar polar_of(const rigcal_camera *camera, const double X_c[3])
{
    const double r = hypot(X_c[0], X_c[1]);
    polar at;

    at.out = camera->lens == FISHEYE ? atan2(r, X_c[2]) : r / X_c[2];
    at.c = r > 0 ? X_c[0] / r : 1;
    at.s = r > 0 ? X_c[1] / r : 0;
    return at;
}

/* The eigenvalues of the derivative of (xd, yd), which is symmetric, the
 * smaller first: by (x, y) for Brown, by the angle along and across for a
 * fisheye. Beyond a pole -1. */
static void slopes(double least_most[2], const rigcal_camera *c, polar at)
{
    const double k1 = D(c->k1), k2 = D(c->k2), k3 = D(c->k3);
    const double k4 = D(c->k4), k5 = D(c->k5), k6 = D(c->k6);
    const double p1 = D(c->p1), p2 = D(c->p2), q = at.out * at.out;

    if (c->lens == FISHEYE) {
        const double along =
            1 + q * (3 * k1 + q * (5 * k2 + q * (7 * k3 + q * 9 * k4)));
        const double across = 1 + q * (k1 + q * (k2 + q * (k3 + q * k4)));

        least_most[0] = along < across ? along : across;
        least_most[1] = along < across ? across : along;
    } else {
        const double x = at.out * at.c, y = at.out * at.s;
        const double n = 1 + q * (k1 + q * (k2 + q * k3));
        const double m = 1 + q * (k4 + q * (k5 + q * k6));
        const double dn = k1 + q * (2 * k2 + q * 3 * k3);
        const double dm = k4 + q * (2 * k5 + q * 3 * k6);
        const double d = n / m, dd = (dn * m - n * dm) / (m * m);
        const double xx = d + 2 * x * x * dd + 2 * p1 * y + 6 * p2 * x;
        const double xy = 2 * x * y * dd + 2 * p1 * x + 2 * p2 * y;
        const double yy = d + 2 * y * y * dd + 6 * p1 * y + 2 * p2 * x;
        const double half = sqrt((xx - yy) * (xx - yy) / 4 + xy * xy);

        least_most[0] = m > 0 ? (xx + yy) / 2 - half : -1;
        least_most[1] = m > 0 ? (xx + yy) / 2 + half : -1;
    }
}

static double steepness(const rigcal_camera *camera, polar at)
{
    double least_most[2];

    slopes(least_most, camera, at);
    return least_most[0];
}

#define FAR 300.0 /* as far as the march goes: 89.8 degrees */

/* How far out the lens serves in one direction, at most `most`. */
static double turning_point(const rigcal_camera *camera, polar at, double most)
{
    double good = 0, bad;

    at.out = 0;

    if (camera->lens == FISHEYE && most > TEST_PI) {
        most = TEST_PI;
    }
    while (steepness(camera, at) > 0) {
        good = at.out;
        if (good >= most) {
            return most;
        }
        at.out = good + (good < 1 ? 0.005 : 0.005 * good);
        at.out = at.out < most ? at.out : most;
    }
    bad = at.out;
    for (int i = 0; i < 50; i++) {
        at.out = (good + bad) / 2;
        if (steepness(camera, at) > 0) {
            good = at.out;
        } else {
            bad = at.out;
        }
    }
    return good;
}

/* Whether what turns back there is a pole: the image has no rim. */
static int is_pole(const rigcal_camera *c, polar at)
{
    const double q = at.out * at.out;

    return c->lens == BROWN &&
           1 + q * (D(c->k4) + q * (D(c->k5) + q * D(c->k6))) < 1e-6;
}

/* The image of all that a lens serves, as a polygon: of the turning points,
 * each `share` of the way out. */
enum { N_WAYS = 360 };
#define CHORD 0.1 /* pixels by which the polygon may miss a round rim */

typedef struct {
    double uv[N_WAYS][2];
    int ends; /* whether the lens turns back in every direction */
} image_circle;

static void image_circle_of(image_circle *circle, int lens, double share)
{
    static double rim[N_LENSES][N_WAYS]; /* found once; 0: not yet */
    const rigcal_camera camera = camera_of(&LENSES[lens]);

    circle->ends = 1;
    for (int i = 0; i < N_WAYS; i++) {
        polar at = polar_at(0, 2 * TEST_PI * i / N_WAYS);
        double X_c[3];

        if (!(rim[lens][i] > 0)) {
            rim[lens][i] = turning_point(&camera, at, FAR);
        }
        at.out = rim[lens][i];
        if (at.out >= FAR || is_pole(&camera, at)) {
            circle->ends = 0;
        }
        at.out *= share;
        ray_of(X_c, &camera, at);
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
        distance = (w[0] - s * e[0]) * (w[0] - s * e[0]) +
                   (w[1] - s * e[1]) * (w[1] - s * e[1]);
        nearest = distance < nearest ? distance : nearest;
        if ((a[1] > uv[1]) != (b[1] > uv[1]) &&
            uv[0] < a[0] + e[0] * (uv[1] - a[1]) / e[1]) {
            crossings++;
        }
    }
    return crossings % 2 ? sqrt(nearest) : -sqrt(nearest);
}

static double focal(const rigcal_camera *camera, int longer)
{
    const double fx = D(camera->fx), fy = D(camera->fy);

    return (fx < fy) == longer ? fy : fx;
}

/* How far a ray may be off when its projection is PX off [rad]. */
static double angle_tolerance(const rigcal_camera *camera, polar at)
{
    return 3 * PX / (focal(camera, 0) * steepness(camera, at)) +
           TOL(1e-15, 1e-6);
}

/* How far a projection may be off [px]: PX, or what rounding the ray itself
 * makes of it where a lens magnifies absurdly, as next to a pole. */
static double pixel_tolerance(const rigcal_camera *camera, polar at)
{
    const double wide = camera->lens == FISHEYE ? 1 : 1 + at.out * at.out;
    double least_most[2], rounding;

    slopes(least_most, camera, at);
    rounding = TOL(4e-16, 2e-7) * focal(camera, 1) * least_most[1] * wide;
    return rounding > PX ? rounding : PX;
}

/* Where accuracy is asked for: in the image, in double far around it too. */
static int is_in_reach(const rigcal_camera *camera, const double uv[2])
{
    const double margin = RIGCAL_USE_FLOAT ? 0.5 : 4000;

    return uv[0] >= -margin && uv[1] >= -margin &&
           uv[0] <= camera->width + margin && uv[1] <= camera->height + margin;
}

static double angle_between(const double a[3], const double b[3])
{
    double c[3];

    test_cross(c, a, b);
    return atan2(test_norm(c), test_dot(a, b));
}

/* A failure that says which lens and where. */
static void fail_at(const char *what, const char *name, double u, double v)
{
    char message[200];

    snprintf(message, sizeof message, "%s: %s, (%.9g, %.9g)", what, name, u, v);
    TEST_FAIL_MESSAGE(message);
}

/* That a ray is what rigcal.h says of one: unit, imaged at the pixel, and on
 * this side of the lens's turning point. */
static void assert_right_ray(const char *name, const rigcal_camera *camera,
                             const rigcal_real ray[3], const rigcal_real uv[2])
{
    double X_c[3], exact[2], tolerance;
    polar at;

    test_to_double(X_c, ray, 3);
    ASSERT_NEAR(1, test_norm(X_c), TOL(1e-15, 5e-7));
    if (camera->lens == BROWN && !(X_c[2] > 0)) {
        fail_at("a ray to the side", name, D(uv[0]), D(uv[1]));
    }
    test_project_px(exact, camera, X_c);
    at = polar_of(camera, X_c);
    tolerance = pixel_tolerance(camera, at);
    if (!(fabs(exact[0] - D(uv[0])) <= tolerance &&
          fabs(exact[1] - D(uv[1])) <= tolerance)) {
        char what[100];

        snprintf(what, sizeof what, "the ray is imaged (%.3g, %.3g) off",
                 exact[0] - D(uv[0]), exact[1] - D(uv[1]));
        fail_at(what, name, D(uv[0]), D(uv[1]));
    }
    if (!(at.out <=
          turning_point(camera, at, 2 * at.out + 1) * TOL(1 + 1e-9, 1.001))) {
        fail_at("a ray beyond the fold", name, D(uv[0]), D(uv[1]));
    }
}

/* ---- forward ------------------------------------------------------------- */

static void test_points_are_projected_by_the_formulas_of_the_header(void)
{
    test_rng rng = test_seed(1);

    for (int i = 0; i < N_LENSES; i++) {
        const rigcal_camera camera = camera_of(&LENSES[i]);

        for (int trial = 0; trial < TEST_TRIALS(300); trial++) {
            const double Z = test_uniform(&rng, 0.1, 20);
            rigcal_real X_real[3], uv[2];
            double X[3], expected[2];
            polar at;

            at = polar_at(0, test_uniform(&rng, -TEST_PI, TEST_PI));
            at.out =
                turning_point(&camera, at, 2) * test_uniform(&rng, 0, 0.98);
            ray_of(X, &camera, at);
            for (int k = 0; k < 3; k++) {
                X_real[k] = RC(X[k] * Z);
                X[k] = D(X_real[k]);
            }
            ASSERT_STATUS(RIGCAL_OK, rigcal_camera_project(uv, &camera, X_real));
            test_project_px(expected, &camera, X);
            if (fabs(expected[0]) + fabs(expected[1]) < 10000) {
                ASSERT_ARRAY_NEAR(expected, uv, 2, TOL(1e-9, 1e-2));
            }
        }
    }
}

/* The derivative that triangulation goes by, against differences of the
 * formulas in doubles. */
static void test_the_derivative_of_a_pixel_is_that_of_the_formulas(void)
{
    test_rng rng = test_seed(2);

    for (int i = 0; i < N_LENSES; i++) {
        const rigcal_camera camera = camera_of(&LENSES[i]);

        for (int trial = 0; trial < TEST_TRIALS(30); trial++) {
            const double distance = test_uniform(&rng, 0.1, 20);
            double X[3], largest = 0, J[6];
            rigcal_real X_c[3], uv[2], J_uv[6];
            rigcal_lens lens;
            polar at = polar_at(0, test_uniform(&rng, -TEST_PI, TEST_PI));

            at.out =
                turning_point(&camera, at, 2) * test_uniform(&rng, 0, 0.95);
            if (trial == 0) {
                at.out = 0; /* on the axis itself */
            }
            ray_of(X, &camera, at);
            for (int k = 0; k < 3; k++) {
                X_c[k] = RC(X[k] * distance);
                X[k] = D(X_c[k]);
            }
            for (int k = 0; k < 3; k++) {
                const double h = 1e-5 * distance, here = X[k];
                double more[2], less[2];

                X[k] = here + h;
                test_project_px(more, &camera, X);
                X[k] = here - h;
                test_project_px(less, &camera, X);
                X[k] = here;
                for (int j = 0; j < 2; j++) {
                    J[3 * j + k] = (more[j] - less[j]) / (2 * h);
                    largest = fabs(J[3 * j + k]) > largest ? fabs(J[3 * j + k])
                                                           : largest;
                }
            }
            rc_lens_of(&lens, &camera);
            ASSERT_STATUS(RIGCAL_OK,
                          rc_project_through(uv, J_uv, &lens, &camera, X_c));
            ASSERT_ARRAY_NEAR(J, J_uv, 6, TOL(1e-6, 1e-3) * largest);
        }
    }
}

static void test_a_pinhole_is_exact_where_it_can_be(void)
{
    const rigcal_camera camera = {.lens = BROWN,
                                  .width = 640,
                                  .height = 480,
                                  .fx = 512,
                                  .fy = 256,
                                  .cx = 320,
                                  .cy = RC(239.5)};
    const rigcal_real X_c[3] = {RC(0.5), RC(-3), 4};
    const double pixel[2] = {384, 47.5};
    /* (-3, 0, 4) / 5. */
    const rigcal_real uv[2] = {-64, RC(239.5)};
    const double expected[3] = {-0.6, 0, 0.8};
    rigcal_real seen[2], ray[3];

    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_project(seen, &camera, X_c));
    ASSERT_ARRAY_NEAR(pixel, seen, 2, 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_ray(ray, &camera, uv));
    ASSERT_ARRAY_NEAR(expected, ray, 3, TOL(1e-15, 1e-7));
}

static void test_the_principal_point_is_the_image_of_the_axis(void)
{
    static const double axis[3] = {0, 0, 1};

    for (int i = 0; i < N_LENSES; i++) {
        const rigcal_camera camera = camera_of(&LENSES[i]);
        const rigcal_real ahead[3] = {0, 0, 3};
        const rigcal_real middle[2] = {camera.cx, camera.cy};
        const double expected[2] = {D(camera.cx), D(camera.cy)};
        rigcal_real uv[2], ray[3];

        ASSERT_STATUS(RIGCAL_OK, rigcal_camera_project(uv, &camera, ahead));
        ASSERT_ARRAY_NEAR(expected, uv, 2, 0);
        ASSERT_STATUS(RIGCAL_OK, rigcal_camera_ray(ray, &camera, middle));
        ASSERT_ARRAY_NEAR(axis, ray, 3, TOL(1e-15, 1e-7));
    }
}

/* ---- pixel to ray -------------------------------------------------------- */

/* Pixel column or row `i` of n, both borders of the image included. */
static double across(int i, int n, int size)
{
    return -0.5 + (double)size * i / (n - 1);
}

static void test_each_pixel_of_each_lens_has_its_ray_or_none(void)
{
    enum { NX = 33, NY = 25 };
    static image_circle inner, outer;

    TEST_ON_HOST_ONLY("the polygon takes 100 KB and minutes");
    for (int i = 0; i < N_LENSES; i++) {
        const rigcal_camera camera = camera_of(&LENSES[i]);
        const char *name = LENSES[i].name;

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
                    fail_at("a ray where the lens has none", name, at[0],
                            at[1]);
                }
            } else {
                ASSERT_STATUS(RIGCAL_ERR_NO_RAY, status);
                ASSERT_UNTOUCHED(ray);
                if (depth_inside(&inner, at) > CHORD) {
                    fail_at("no ray where the lens has one", name, at[0],
                            at[1]);
                }
            }
        }
    }
}

/* From the axis to 0.1 % before the turning point. */
static void test_every_ray_before_the_turning_point_is_found_from_its_pixel(
    void)
{
    static const double shares[] = {1e-8, 1e-3, 0.1,  0.3,  0.5,
                                    0.7,  0.9,  0.97, 0.99, 0.999};

    for (int i = 0; i < N_LENSES; i++) {
        const rigcal_camera camera = camera_of(&LENSES[i]);

        for (int w = 0; w < 48; w += TEST_ONE_IN) {
            for (size_t s = 0; s < sizeof shares / sizeof shares[0]; s++) {
                double X_c[3], seen[3], exact[2];
                rigcal_real uv[2], ray[3];
                polar at;

                at = polar_at(0, 2 * TEST_PI * (w + 0.25) / 48);
                at.out = turning_point(&camera, at, 3) * shares[s];
                ray_of(X_c, &camera, at);
                test_project_px(exact, &camera, X_c);
                /* Of float it is asked to 1 %: closer, its pixel may lie
                 * beyond. */
                if (!is_in_reach(&camera, exact) ||
                    (RIGCAL_USE_FLOAT && shares[s] > 0.99)) {
                    continue;
                }
                test_to_real(uv, exact, 2);
                if (rigcal_camera_ray(ray, &camera, uv) != RIGCAL_OK) {
                    fail_at("no ray found", LENSES[i].name, exact[0], exact[1]);
                }
                test_to_double(seen, ray, 3);
                if (!(angle_between(X_c, seen) <=
                      angle_tolerance(&camera, at))) {
                    fail_at("not the ray", LENSES[i].name, exact[0], exact[1]);
                }
            }
        }
    }
}

/* Rays beyond the turning point are imaged too, by the formula: outside of the
 * image of all rays before it, where the lens has none, or inside, where the
 * right ray is another. */
static void test_a_ray_beyond_the_turning_point_never_comes_out(void)
{
    static const double shares[] = {1.02, 1.05, 1.1, 1.2, 1.5, 2, 3, 5};
    static image_circle circle;
    int outside = 0, inside = 0;

    TEST_ON_HOST_ONLY("the polygon takes 100 KB and minutes");
    for (int i = 0; i < N_LENSES; i++) {
        const rigcal_camera camera = camera_of(&LENSES[i]);
        const char *name = LENSES[i].name;

        image_circle_of(&circle, i, 1);
        for (int w = 0; circle.ends && w < 48; w++) {
            for (size_t s = 0; s < sizeof shares / sizeof shares[0]; s++) {
                double X_c[3], exact[2], depth;
                rigcal_real uv[2], ray[3], X_real[3];
                rigcal_status status;
                polar at;

                at = polar_at(0, 2 * TEST_PI * (w + 0.25) / 48);
                at.out = turning_point(&camera, at, FAR) * shares[s];
                if (camera.lens == FISHEYE && at.out > 3.1) {
                    continue;
                }
                ray_of(X_c, &camera, at);
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
                    if (is_in_reach(&camera, exact)) {
                        assert_right_ray(name, &camera, ray, uv);
                    }
                }
            }
        }
    }
    /* The lenses of the table are such that both happens often. */
    TEST_ASSERT_TRUE(outside > 300);
    TEST_ASSERT_TRUE(inside > 300);
}

static void test_projection_ends_at_the_turning_point(void)
{
    for (int i = 0; i < N_LENSES; i++) {
        const rigcal_camera camera = camera_of(&LENSES[i]);

        for (int w = 0; w < 60; w += TEST_ONE_IN) {
            const double way = 2 * TEST_PI * w / 60;
            const double end = turning_point(&camera, polar_at(0, way), FAR);
            const double within = TOL(1e-6, 1e-3);
            const polar before = polar_at(end * (1 - within), way);
            const polar beyond = polar_at(end * (1 + within), way);
            double X[3];
            rigcal_real X_c[3], uv[2];

            /* Not of a Brown lens beyond 88.8 degrees. */
            if (end >= (camera.lens == FISHEYE ? TEST_PI : 50)) {
                continue;
            }
            ray_of(X, &camera, before);
            test_to_real(X_c, X, 3);
            ASSERT_STATUS(RIGCAL_OK, rigcal_camera_project(uv, &camera, X_c));
            ray_of(X, &camera, beyond);
            test_to_real(X_c, X, 3);
            ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, uv,
                           rigcal_camera_project(uv, &camera, X_c));
        }
    }
}

/* ---- the iteration that is not used -------------------------------------- */

/* x <- (xd - tangential) / d, as commonly done; how far off in pixels its
 * projection is after `steps`. */
static double fixed_point_error(const rigcal_camera *c, const double uv[2],
                                int steps)
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

static void test_pixels_on_which_the_fixed_point_iteration_fails_have_a_ray(
    void)
{
    int failed = 0;

    TEST_ON_HOST_ONLY("a rate wants all pixels");
    for (int i = 0; i < N_LENSES; i++) {
        const rigcal_camera camera = camera_of(&LENSES[i]);

        for (int w = 0; camera.lens == BROWN && w < 24; w++) {
            for (int s = 1; s < 50; s++) {
                double X_c[3], exact[2];
                rigcal_real uv[2], ray[3];
                polar at;

                at = polar_at(0, 2 * TEST_PI * w / 24);
                at.out = turning_point(&camera, at, 2) * s / 50;
                ray_of(X_c, &camera, at);
                test_project_px(exact, &camera, X_c);
                if (!is_in_reach(&camera, exact) ||
                    fixed_point_error(&camera, exact, 200) < 1) {
                    continue;
                }
                failed++;
                test_to_real(uv, exact, 2);
                ASSERT_STATUS(RIGCAL_OK, rigcal_camera_ray(ray, &camera, uv));
                assert_right_ray(LENSES[i].name, &camera, ray, uv);
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
    c.lens = fisheye ? FISHEYE : BROWN;
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

static void random_pixel(rigcal_real uv[2], const rigcal_camera *camera,
                         test_rng *rng)
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
            /* And the library's own projection takes it. In float a ray may
             * round across the turning point. */
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
            polar at;

            at = polar_at(0, test_uniform(&rng, -TEST_PI, TEST_PI));
            at.out =
                turning_point(&camera, at, 3) * test_uniform(&rng, 0, 0.99);
            ray_of(X_c, &camera, at);
            test_project_px(exact, &camera, X_c);
            if (!is_in_reach(&camera, exact)) {
                continue;
            }
            test_to_real(uv, exact, 2);
            if (rigcal_camera_ray(ray, &camera, uv) != RIGCAL_OK) {
                fail_at("no ray found", name, exact[0], exact[1]);
            }
            test_to_double(seen, ray, 3);
            if (!(angle_between(X_c, seen) <=
                  2 * angle_tolerance(&camera, at))) {
                fail_at("not the ray", name, exact[0], exact[1]);
            }
        }
    }
}

/* The least steepness on the way out to `share` of a place. Where it nearly
 * vanishes a march in steps may have passed a turning point unseen. */
static double least_steepness(const rigcal_camera *camera, polar at,
                              double share)
{
    double least = 1;

    for (int i = 0; i < 400; i++) {
        polar there = at;
        double here;

        there.out = at.out * share * i / 400;
        here = steepness(camera, there);
        least = here < least ? here : least;
    }
    return least;
}

static void test_any_lens_projects_up_to_its_turning_point_and_not_beyond(void)
{
    /* Of the strangest of them the library leaves the last 0.2 % out. */
    const double within = TOL(5e-3, 1e-2);
    const double shares[] = {0.3, 1 - within, 1 + within, 1.1, 1.5, 3, 10};
    test_rng rng = test_seed(12);

    for (int trial = 0; trial < TEST_TRIALS(1000); trial++) {
        const rigcal_camera camera = random_camera(&rng, trial % 4 == 0);

        for (int i = 0; i < 4; i++) {
            polar at = polar_at(0, test_uniform(&rng, -TEST_PI, TEST_PI));
            /* Closer to 90 degrees the library may end a little early. */
            const double far = camera.lens == BROWN ? 4 : TEST_PI;
            const double end = turning_point(&camera, at, far);

            for (int k = 0; k < 7; k++) {
                double X[3];
                rigcal_real X_c[3], uv[2];

                at.out = end * shares[k];
                if ((camera.lens == FISHEYE && at.out > 3.14) ||
                    (camera.lens == BROWN && end >= far && shares[k] > 1) ||
                    (shares[k] < 1 &&
                     least_steepness(&camera, at, 0.97) < 0.01)) {
                    continue;
                }
                ray_of(X, &camera, at);
                test_to_real(X_c, X, 3);
                if (rigcal_camera_project(uv, &camera, X_c) !=
                    (shares[k] < 1 ? RIGCAL_OK : RIGCAL_ERR_NO_RAY)) {
                    char name[40];

                    snprintf(name, sizeof name, "random lens %d", trial);
                    fail_at(shares[k] < 1 ? "not projected" : "projected", name,
                            at.out, shares[k]);
                }
            }
        }
    }
}

/* Without tangential distortion the image of a lens is a disc, whose radius the
 * march tells exactly. */
static void test_a_radial_lens_has_rays_exactly_inside_its_circle(void)
{
    test_rng rng = test_seed(9);
    int none = 0;

    for (int trial = 0; trial < TEST_TRIALS(1000); trial++) {
        rigcal_camera camera = random_camera(&rng, 1);
        double X_c[3], rim[2], radius;
        polar edge = polar_at(0, 0);

        camera.fy = camera.fx;
        edge.out = turning_point(&camera, edge, FAR);
        if (RIGCAL_USE_FLOAT && is_pole(&camera, edge)) {
            continue;
        }
        ray_of(X_c, &camera, edge);
        test_project_px(rim, &camera, X_c);
        radius = rim[0] - D(camera.cx);
        for (int i = 0; i < 8; i++) {
            rigcal_real uv[2], ray[3];
            double out;
            rigcal_status status;

            random_pixel(uv, &camera, &rng);
            out = hypot(D(uv[0]) - D(camera.cx), D(uv[1]) - D(camera.cy));
            status = rigcal_camera_ray(ray, &camera, uv);
            if (edge.out < FAR && out > radius * (1 + TOL(1e-9, 1e-4))) {
                none++;
                ASSERT_STATUS(RIGCAL_ERR_NO_RAY, status);
            } else if (out < radius * (1 - TOL(1e-6, 1e-3))) {
                ASSERT_STATUS(RIGCAL_OK, status);
            }
        }
    }
    TEST_ASSERT_TRUE(none > TEST_TRIALS(1000));
}

/* ---- undistorted pixels -------------------------------------------------- */

static void test_undistorted_pixels_are_those_of_the_pinhole_and_go_back(void)
{
    test_rng rng = test_seed(10);

    for (int i = 0; i < N_LENSES; i++) {
        const rigcal_camera camera = camera_of(&LENSES[i]);

        for (int trial = 0; trial < TEST_TRIALS(200); trial++) {
            double X_c[3], exact[2], straight[2], slack;
            rigcal_real uv[2], seen[2], back[2];
            polar at;

            at = polar_at(0, test_uniform(&rng, -TEST_PI, TEST_PI));
            at.out =
                turning_point(&camera, at, 1.4) * test_uniform(&rng, 0, 0.98);
            ray_of(X_c, &camera, at);
            test_project_px(exact, &camera, X_c);
            if (!is_in_reach(&camera, exact)) {
                continue;
            }
            test_to_real(uv, exact, 2);
            straight[0] = D(camera.fx) * X_c[0] / X_c[2] + D(camera.cx);
            straight[1] = D(camera.fy) * X_c[1] / X_c[2] + D(camera.cy);
            /* A pixel's error, as the lens magnifies it. */
            slack = 4 * PX / steepness(&camera, at);
            if (camera.lens == FISHEYE) {
                slack /= cos(at.out) * cos(at.out);
            }
            ASSERT_STATUS(RIGCAL_OK, rigcal_camera_undistort(seen, &camera, uv));
            ASSERT_ARRAY_NEAR(straight, seen, 2, slack);
            test_to_real(seen, straight, 2);
            ASSERT_STATUS(RIGCAL_OK, rigcal_camera_distort(back, &camera, seen));
            ASSERT_ARRAY_NEAR(exact, back, 2, TOL(1e-9, 1e-2));
        }
    }
}

static void test_a_fisheye_ray_at_90_degrees_has_no_undistorted_pixel(void)
{
    const rigcal_camera camera = camera_of(&LENSES[N_LENSES - 4]);
    const double angles[] = {1.58, 1.8, 2.2, 2.8};

    TEST_ASSERT_EQUAL_STRING("fisheye, 220 degrees", LENSES[N_LENSES - 4].name);
    for (int i = 0; i < 4; i++) {
        const double u = 300 * angles[i];
        const rigcal_real uv[2] = {RC(599.5 + 0.6 * u), RC(599.5 - 0.8 * u)};
        rigcal_real straight[2], ray[3];

        ASSERT_STATUS(RIGCAL_OK, rigcal_camera_ray(ray, &camera, uv));
        ASSERT_REFUSED(RIGCAL_ERR_WIDE_RAY, straight,
                       rigcal_camera_undistort(straight, &camera, uv));
    }
}

static void test_pixels_without_a_ray_are_not_undistorted_either(void)
{
    /* 1 - 3 * 0.4 r^2 = 0 at r = 0.91287, imaged 304.3 pixels off. */
    const lens_row row = {"",   BROWN, 1280, 960, 500, 500, 640, 480,
                          -0.4, 0,     0,    0,   0,   0,   0,   0};
    const rigcal_camera camera = camera_of(&row);
    const rigcal_real inside[2] = {640, 480 - 304};
    const rigcal_real outside[2] = {640 + 305, 480};
    const rigcal_real straight_inside[2] = {640, RC(480 + 500 * 0.912)};
    const rigcal_real straight_outside[2] = {RC(640 + 500 * 0.914), 480};
    rigcal_real uv[2], ray[3];

    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_undistort(uv, &camera, inside));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_camera_distort(uv, &camera, straight_inside));
    ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, ray,
                   rigcal_camera_ray(ray, &camera, outside));
    ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, uv,
                   rigcal_camera_undistort(uv, &camera, outside));
    ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, uv,
                   rigcal_camera_distort(uv, &camera, straight_outside));
}

/* ---- what a camera cannot see -------------------------------------------- */

static void test_what_is_not_in_front_is_not_imaged(void)
{
    static const double places[][3] = {
        {0, 0, -1}, {1, 2, -3}, {1, 0, 0}, {0.3, -0.2, 0}, {0, 0, -1e-9}};
    const rigcal_camera camera = test_pinhole();
    const rigcal_real centre[3] = {0, 0, 0};
    rigcal_real uv[2], X_c[3];

    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        test_to_real(X_c, places[i], 3);
        ASSERT_REFUSED(RIGCAL_ERR_BEHIND, uv, rigcal_camera_project(uv, &camera, X_c));
    }
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, uv,
                   rigcal_camera_project(uv, &camera, centre));
}

static void test_a_fisheye_sees_behind_itself_but_not_its_own_centre(void)
{
    const rigcal_camera camera = camera_of(&LENSES[N_LENSES - 4]);
    const rigcal_real side[3] = {2, 0, 0}, behind[3] = {0, 3, -3};
    const rigcal_real centre[3] = {0, 0, 0};
    const double quarter[2] = {599.5 + 150 * TEST_PI, 599.5};
    const double back[2] = {599.5, 599.5 + 225 * TEST_PI};
    rigcal_real uv[2];

    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_project(uv, &camera, side));
    ASSERT_ARRAY_NEAR(quarter, uv, 2, TOL(1e-10, 1e-3));
    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_project(uv, &camera, behind));
    ASSERT_ARRAY_NEAR(back, uv, 2, TOL(1e-10, 1e-3));
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, uv,
                   rigcal_camera_project(uv, &camera, centre));
}

/* A point 180 degrees off the axis would be imaged on a whole circle. */
static void test_a_fisheye_does_not_see_straight_back(void)
{
    const rigcal_camera camera = camera_of(&LENSES[N_LENSES - 4]);
    const rigcal_real back[3] = {0, 0, -2};
    rigcal_real uv[2];
    rigcal_status status;

    FILL(uv);
    status = rigcal_camera_project(uv, &camera, back);
    TEST_ASSERT_TRUE(status == RIGCAL_ERR_BEHIND ||
                     status == RIGCAL_ERR_NO_RAY);
    ASSERT_UNTOUCHED(uv);
}

static void test_intrinsics_that_cannot_be_are_refused(void)
{
    const rigcal_camera good = test_pinhole();
    rigcal_camera c;

    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_check(&good));
    c = good;
    c.lens = 2;
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&c));
    c = good;
    c.fx = 0;
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&c));
    c = good;
    c.fy = -1;
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&c));
    c = good;
    c.width = 0;
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&c));
    c = good;
    c.width = c.height = 1000000;
    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_check(&c));
    c.height = 1000001;
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&c));
    c = good;
    c.k6 = TEST_NAN;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rigcal_camera_check(&c));
    c = good;
    c.cx = RC(-1e5);
    c.width = c.height = 1;
    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_check(&c));
}

static void test_a_fisheye_has_no_coefficients_but_its_four(void)
{
    rigcal_camera good = test_pinhole(), c;

    good.lens = FISHEYE;
    good.k1 = good.k2 = good.k3 = good.k4 = RC(0.01);
    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_check(&good));
    c = good;
    c.p1 = RC(1e-9);
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&c));
    c = good;
    c.p2 = RC(0.1);
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&c));
    c = good;
    c.k5 = RC(-0.1);
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&c));
    c = good;
    c.k6 = RC(0.1);
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_check(&c));
    c = good;
    c.p1 = RC(-0.0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_check(&c));
}

/* ---- many observations --------------------------------------------------- */

/* Points seen by the left camera of opencv_stereo. */
static void scene_seen(test_scene *scene, rigcal_camera *camera,
                       rigcal_observation observations[], uint64_t seed)
{
    test_rng rng = test_seed(seed);

    *camera = camera_of(&LENSES[4]);
    test_scene_random(scene, &rng, 20, TEST_GENERAL);
    test_observations(observations, scene, camera);
}

static void test_observations_become_bearings_one_by_one(void)
{
    test_scene scene;
    rigcal_camera camera;
    rigcal_observation observations[20];
    rigcal_bearing bearings[20];
    int32_t at_fault;

    scene_seen(&scene, &camera, observations, 11);
    FILL(at_fault);
    ASSERT_STATUS(RIGCAL_OK, rigcal_bearings_of_view(bearings, &at_fault, &VIEW(&camera, observations, NULL, 20)));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
    for (int i = 0; i < 20; i++) {
        const double exact[3] = {scene.xy[i][0], scene.xy[i][1], 1};
        double ray[3];

        TEST_ASSERT_EQUAL_MEMORY(observations[i].X_w, bearings[i].X_w,
                                 sizeof bearings[i].X_w);
        test_to_double(ray, bearings[i].ray, 3);
        ASSERT_NEAR(1, test_norm(ray), TOL(1e-15, 5e-7));
        ASSERT_NEAR(0, angle_between(exact, ray), TOL(1e-11, 1e-5));
    }
}

static void test_the_observation_at_fault_is_told(void)
{
    static const int places[] = {0, 7, 19};
    test_scene scene;
    rigcal_camera camera;
    rigcal_observation good[20], observations[20];
    rigcal_bearing bearings[20];
    int32_t at_fault;

    scene_seen(&scene, &camera, good, 12);
    camera.k1 = RC(-0.4);
    camera.k2 = camera.k3 = 0;
    for (int i = 0; i < 20; i++) { /* all inside of the circle */
        good[i].uv[0] = RC(D(camera.cx) + 10 * i);
        good[i].uv[1] = RC(D(camera.cy) - 7 * i);
    }
    for (int p = 0; p < 3; p++) {
        const int i = places[p];

        memcpy(observations, good, sizeof good);
        observations[i].uv[0] = 5000;
        at_fault = -7;
        ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, bearings,
                       rigcal_bearings_of_view(bearings, &at_fault, &VIEW(&camera, observations, NULL, 20)));
        TEST_ASSERT_EQUAL_INT32(i, at_fault);

        memcpy(observations, good, sizeof good);
        observations[i].X_w[2] = TEST_NAN;
        at_fault = -7;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, bearings,
                       rigcal_bearings_of_view(bearings, &at_fault, &VIEW(&camera, observations, NULL, 20)));
        TEST_ASSERT_EQUAL_INT32(i, at_fault);
    }
    camera.fx = -1;
    at_fault = -7;
    ASSERT_REFUSED(
        RIGCAL_ERR_CAMERA, bearings,
        rigcal_bearings_of_view(bearings, &at_fault, &VIEW(&camera, good, NULL, 20)));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
}

static void test_the_error_of_exact_pixels_is_zero(void)
{
    test_scene scene;
    rigcal_camera camera;
    rigcal_observation observations[20];
    rigcal_transform cam_from_world;
    rigcal_real rms;

    scene_seen(&scene, &camera, observations, 13);
    cam_from_world = test_transform(scene.R, scene.t);
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_view_rms(&rms, NULL, &VIEW(&camera, observations, NULL, 20), &cam_from_world));
    ASSERT_NEAR(0, rms, TOL(1e-10, 1e-3));
}

static void test_the_error_is_the_root_of_the_mean_squared_distance(void)
{
    test_rng rng = test_seed(14);
    test_scene scene;
    rigcal_camera camera;
    rigcal_observation observations[20];
    rigcal_transform cam_from_world;

    for (int trial = 0; trial < TEST_TRIALS(50); trial++) {
        const size_t n = 1 + (size_t)trial % 20;
        double sum = 0, largest = -1;
        int32_t expected_worst = -1, worst;
        rigcal_real rms;

        scene_seen(&scene, &camera, observations, (uint64_t)(100 + trial));
        cam_from_world = test_transform(scene.R, scene.t);
        for (size_t i = 0; i < n; i++) {
            const double du = test_uniform(&rng, -5, 5);
            const double dv = test_uniform(&rng, -5, 5);

            observations[i].uv[0] = RC(D(observations[i].uv[0]) + du);
            observations[i].uv[1] = RC(D(observations[i].uv[1]) + dv);
            sum += du * du + dv * dv;
            if (du * du + dv * dv > largest) {
                largest = du * du + dv * dv;
                expected_worst = (int32_t)i;
            }
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_view_rms(&rms, &worst, &VIEW(&camera, observations, NULL, n), &cam_from_world));
        ASSERT_NEAR(sqrt(sum / (double)n), rms, TOL(1e-9, 2e-3));
        TEST_ASSERT_EQUAL_INT32(expected_worst, worst);
    }
}

static void test_no_error_is_told_of_points_that_cannot_be_seen(void)
{
    test_scene scene;
    rigcal_camera camera;
    rigcal_observation observations[20];
    rigcal_transform cam_from_world;
    rigcal_real rms;
    int32_t worst;

    scene_seen(&scene, &camera, observations, 15);
    cam_from_world = test_transform(scene.R, scene.t);
    FILL(worst);
    /* The camera's own centre, carried 1 back, then 3 to the side of 1 ahead:
     * beyond the fold of a lens with k1 = -0.4 alone. */
    for (int k = 0; k < 3; k++) {
        double o = 0;

        for (int j = 0; j < 3; j++) {
            o += scene.R[3 * j + k] * ((j == 2 ? -1 : 0) - scene.t[j]);
        }
        observations[8].X_w[k] = RC(o);
    }
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, rms,
                   rigcal_view_rms(&rms, &worst, &VIEW(&camera, observations, NULL, 20), &cam_from_world));
    ASSERT_UNTOUCHED(worst);
    camera.k1 = RC(-0.4);
    camera.k2 = camera.k3 = 0;
    for (int k = 0; k < 3; k++) {
        double o = 0;

        for (int j = 0; j < 3; j++) {
            o += scene.R[3 * j + k] * ((j == 2   ? 1
                                        : j == 0 ? 3
                                                 : 0) -
                                       scene.t[j]);
        }
        observations[8].X_w[k] = RC(o);
    }
    ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, rms,
                   rigcal_view_rms(&rms, &worst, &VIEW(&camera, observations, NULL, 20), &cam_from_world));
    ASSERT_UNTOUCHED(worst);
}

TEST_MAIN()
{
    RUN_TEST(test_points_are_projected_by_the_formulas_of_the_header);
    RUN_TEST(test_the_derivative_of_a_pixel_is_that_of_the_formulas);
    RUN_TEST(test_a_pinhole_is_exact_where_it_can_be);
    RUN_TEST(test_the_principal_point_is_the_image_of_the_axis);
    RUN_TEST(test_each_pixel_of_each_lens_has_its_ray_or_none);
    RUN_TEST(test_every_ray_before_the_turning_point_is_found_from_its_pixel);
    RUN_TEST(test_a_ray_beyond_the_turning_point_never_comes_out);
    RUN_TEST(test_projection_ends_at_the_turning_point);
    RUN_TEST(test_pixels_on_which_the_fixed_point_iteration_fails_have_a_ray);
    RUN_TEST(test_any_lens_gives_right_rays_only);
    RUN_TEST(test_any_lens_gives_every_ray_before_its_turning_point);
    RUN_TEST(test_any_lens_projects_up_to_its_turning_point_and_not_beyond);
    RUN_TEST(test_a_radial_lens_has_rays_exactly_inside_its_circle);
    RUN_TEST(test_undistorted_pixels_are_those_of_the_pinhole_and_go_back);
    RUN_TEST(test_a_fisheye_ray_at_90_degrees_has_no_undistorted_pixel);
    RUN_TEST(test_pixels_without_a_ray_are_not_undistorted_either);
    RUN_TEST(test_what_is_not_in_front_is_not_imaged);
    RUN_TEST(test_a_fisheye_sees_behind_itself_but_not_its_own_centre);
    RUN_TEST(test_a_fisheye_does_not_see_straight_back);
    RUN_TEST(test_intrinsics_that_cannot_be_are_refused);
    RUN_TEST(test_a_fisheye_has_no_coefficients_but_its_four);
    RUN_TEST(test_observations_become_bearings_one_by_one);
    RUN_TEST(test_the_observation_at_fault_is_told);
    RUN_TEST(test_the_error_of_exact_pixels_is_zero);
    RUN_TEST(test_the_error_is_the_root_of_the_mean_squared_distance);
    RUN_TEST(test_no_error_is_told_of_points_that_cannot_be_seen);
}
