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

#endif /* TEST_TWO_VIEWS_H */
