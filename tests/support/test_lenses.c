#include "test_lenses.h"

#include <math.h>
#include <string.h>

#define BROWN RIGCAL_LENS_BROWN
#define FISHEYE RIGCAL_LENS_FISHEYE

/* clang-format off */
const test_lens_row TEST_LENSES[TEST_N_LENSES] = {
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
    /* Kinds of lens that OpenCV's rational model describes. */
    {"rational, 90 degrees", BROWN, 1280, 720, 611, 610.6, 637.2, 369.4,
     0.455, -2.51, 0.0006, -0.0002, 1.44, 0.336, -2.34, 1.37},
    {"rational, 120 degrees", BROWN, 1024, 1024, 504.4, 504.5, 514.2, 521.9,
     5.2, 2.6, -0.00005, 0.00003, 0.13, 5.5, 4.1, 0.7},
    {"rational, wide", BROWN, 1920, 1080, 950, 955, 940, 560,
     5.1, 2.2, 0.0003, 0.0002, 0.11, 5.4, 4.1, 0.62},
    /* All ways in which a polynomial can bend. */
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

rigcal_camera test_lens_camera(const test_lens_row *row)
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

test_polar test_polar_at(double out, double way)
{
    test_polar at;

    at.out = out;
    at.c = cos(way);
    at.s = sin(way);
    return at;
}

void test_polar_ray(double X_c[3], const rigcal_camera *camera, test_polar at)
{
    const int fisheye = camera->lens == FISHEYE;
    const double r = fisheye ? sin(at.out) : at.out;

    X_c[0] = r * at.c;
    X_c[1] = r * at.s;
    X_c[2] = fisheye ? cos(at.out) : 1;
}

test_polar test_polar_of(const rigcal_camera *camera, const double X_c[3])
{
    const double r = hypot(X_c[0], X_c[1]);
    test_polar at;

    at.out = camera->lens == FISHEYE ? atan2(r, X_c[2]) : r / X_c[2];
    at.c = r > 0 ? X_c[0] / r : 1;
    at.s = r > 0 ? X_c[1] / r : 0;
    return at;
}

void test_slopes(double least_most[2], const rigcal_camera *c, test_polar at)
{
    const double k1 = D(c->k1), k2 = D(c->k2), k3 = D(c->k3);
    const double k4 = D(c->k4), k5 = D(c->k5), k6 = D(c->k6);
    const double p1 = D(c->p1), p2 = D(c->p2), q = at.out * at.out;

    if (c->lens == FISHEYE) {
        const double along = 1 + q * (3 * k1 + q * (5 * k2 + q * (7 * k3 + q * 9 * k4)));
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

double test_steepness(const rigcal_camera *camera, test_polar at)
{
    double least_most[2];

    test_slopes(least_most, camera, at);
    return least_most[0];
}

double test_turning_point(const rigcal_camera *camera, test_polar at, double most)
{
    double good = 0, bad;

    at.out = 0;

    if (camera->lens == FISHEYE && most > TEST_PI) {
        most = TEST_PI;
    }
    while (test_steepness(camera, at) > 0) {
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
        if (test_steepness(camera, at) > 0) {
            good = at.out;
        } else {
            bad = at.out;
        }
    }
    return good;
}

int test_is_pole(const rigcal_camera *c, test_polar at)
{
    const double q = at.out * at.out;

    return c->lens == BROWN && 1 + q * (D(c->k4) + q * (D(c->k5) + q * D(c->k6))) < 1e-6;
}

static double focal(const rigcal_camera *camera, int longer)
{
    const double fx = D(camera->fx), fy = D(camera->fy);

    return (fx < fy) == longer ? fy : fx;
}

double test_angle_tolerance(const rigcal_camera *camera, test_polar at)
{
    return 3 * TEST_PX / (focal(camera, 0) * test_steepness(camera, at)) + TOL(1e-15, 1e-6);
}

double test_pixel_tolerance(const rigcal_camera *camera, test_polar at)
{
    const double wide = camera->lens == FISHEYE ? 1 : 1 + at.out * at.out;
    double least_most[2], rounding;

    test_slopes(least_most, camera, at);
    rounding = TOL(4e-16, 2e-7) * focal(camera, 1) * least_most[1] * wide;
    return rounding > TEST_PX ? rounding : TEST_PX;
}

int test_is_in_reach(const rigcal_camera *camera, const double uv[2])
{
    const double margin = RIGCAL_USE_FLOAT ? 0.5 : 4000;

    return uv[0] >= -margin && uv[1] >= -margin && uv[0] <= camera->width + margin &&
           uv[1] <= camera->height + margin;
}

double test_ray_angle(const double a[3], const double b[3])
{
    double c[3];

    test_cross(c, a, b);
    return atan2(test_norm(c), test_dot(a, b));
}

void test_scene_seen(test_scene *scene, rigcal_camera *camera,
                     rigcal_observation observations[], uint64_t seed)
{
    test_rng rng = test_seed(seed);

    *camera = test_lens_camera(&TEST_LENSES[4]);
    test_scene_random(scene, &rng, 20, TEST_GENERAL);
    test_observations(observations, scene, camera);
}
