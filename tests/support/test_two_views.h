/* test_two_views.h - two cameras side by side and points before both, for the tests of
 * measuring. */
#ifndef TEST_TWO_VIEWS_H
#define TEST_TWO_VIEWS_H

#include "test_support.h"

/* A second camera that looks roughly in the direction of the first, at a distance of 1. */
rigcal_transform test_beside(test_rng *rng);

/* A point at some distance in front of both cameras. */
void test_point_ahead(double X[3], test_rng *rng);

/* (X / Z, Y / Z, 1) */
void test_ray_to(rigcal_real ray[3], const double X[3]);

/* Views of one point by pinholes. */
typedef struct {
    rigcal_camera cameras[3];
    rigcal_transform cams_from_world[3];
    rigcal_real uv[6];
    int n;
} test_views;

/* Two or three cameras at a distance of 5 from the origin, which look at it, and a random
 * pixel in each. So the rays are far from meeting. */
void test_wild_views(test_views *v, test_rng *rng);

/* Cameras 0 and 1 see a point at (0, 0, e), with a tiny e, from the side. Camera 2 looks
 * along z from (-aside, -aside, 0), and sees another point there. */
void test_grazing_views(test_views *v, double aside);

/* The sum of the squared errors [px^2], infinite if a camera does not see X. */
double test_views_sum(const test_views *v, const double X[3]);

#endif /* TEST_TWO_VIEWS_H */
