/* test_lenses.h - many kinds of lenses, and the truth about them, in double: derivatives of
 * the formulas of rigcal.h, and a march along straight lines from the optical axis that
 * finds where a lens folds. */
#ifndef TEST_LENSES_H
#define TEST_LENSES_H

#include "test_support.h"

/* What rigcal.h promises of a ray's projection [px]. */
#define TEST_PX TOL(1e-9, 2e-3)

typedef struct {
    const char *name;
    int lens, width, height;
    double fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6;
} test_lens_row;

enum { TEST_N_LENSES = 32 };
extern const test_lens_row TEST_LENSES[TEST_N_LENSES];

rigcal_camera test_lens_camera(const test_lens_row *row);

/* A ray at a distance from the axis: `out` = tan(angle) for Brown, the angle for a fisheye,
 * in the direction (c, s) of the image. */
typedef struct {
    double out, c, s;
} test_polar;

test_polar test_polar_at(double out, double way);
test_polar test_polar_of(const rigcal_camera *camera, const double X_c[3]);
void test_polar_ray(double X_c[3], const rigcal_camera *camera, test_polar at);

/* The eigenvalues of the derivative of (xd, yd), which is symmetric; the smaller first. The
 * derivative is by (x, y) for Brown, by the angle along and across for a fisheye. Beyond a
 * pole they are -1. */
void test_slopes(double least_most[2], const rigcal_camera *camera, test_polar at);
double test_steepness(const rigcal_camera *camera, test_polar at); /* the smaller */

#define TEST_FAR 300.0 /* as far as the march goes: 89.8 degrees */

/* The largest distance from the axis at which the lens is usable in one direction, at most
 * `most`. */
double test_turning_point(const rigcal_camera *camera, test_polar at, double most);

/* Whether the lens has a pole there: then the image has no rim. */
int test_is_pole(const rigcal_camera *camera, test_polar at);

/* Tolerance of a ray whose projection is off by TEST_PX [rad]. */
double test_angle_tolerance(const rigcal_camera *camera, test_polar at);

/* Tolerance of a projection [px]: TEST_PX, or what rounding of the ray makes of it where a
 * lens magnifies very much, such as next to a pole. */
double test_pixel_tolerance(const rigcal_camera *camera, test_polar at);

/* Whether accuracy is demanded here: in the image; in double also far around it. */
int test_is_in_reach(const rigcal_camera *camera, const double uv[2]);

/* Angle between two rays, accurate for the smallest too. */
double test_ray_angle(const double a[3], const double b[3]);

/* 20 points seen by the left camera of opencv_stereo. */
void test_scene_seen(test_scene *scene, rigcal_camera *camera,
                     rigcal_observation observations[], uint64_t seed);

#endif /* TEST_LENSES_H */
