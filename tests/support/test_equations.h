/* test_equations.h - what the tests of the calibration equations share: scenes of the
 * vectors, and pairs made by hand. */
#ifndef TEST_EQUATIONS_H
#define TEST_EQUATIONS_H

#include "test_support.h"

/* Tolerance against the oracle for numbers of order 1. */
#define TOL_FORMULA TOL(1e-12, 1e-4)

/* Scene k of the vectors: its noisy bearings, its true rotation, and angles near it. */
void test_golden_scene(rigcal_bearing out[6], double ypr[3], double wrong[3], int k);

/* The pairs of the first n points in the order of the vectors. Returns their number. */
int test_golden_pairs(rigcal_pair pairs[15], const rigcal_bearing s[6], int n);

/* The two angles that are not eliminated, in the order yaw, pitch, roll. */
void test_other_two(rigcal_real out[2], const double ypr[3], int eliminated);

void test_rotation_of(rigcal_real R[9], const double ypr[3]);

rigcal_pair test_pair_of(double n1, double n2, double n3, double d1, double d2, double d3);

#endif /* TEST_EQUATIONS_H */
