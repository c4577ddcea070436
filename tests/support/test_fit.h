/* test_fit.h - the maximum-likelihood pose by other means than the library's: double
 * precision also in a float build, derivatives by differences of test_project_px, a dense
 * solver. It is slow and simple, and used to judge what the library found. */
#ifndef TEST_FIT_H
#define TEST_FIT_H

#include "test_support.h"

typedef struct {
    const rigcal_camera *camera;
    const rigcal_observation *observations;
    const rigcal_real *sigma; /* NULL: all 1 */
    int n;
} test_data;

typedef struct {
    double R[9], t[3], sse;
} test_fitted;

/* Sum of squared pixel errors over sigma. 1e300 if a point is behind the camera (Brown). */
double test_sse(const test_data *data, const double R[9], const double t[3]);

/* Levenberg-Marquardt from fitted->R and t until no step gains anything. Returns 0 if it
 * stopped at its limit of 200 steps. */
int test_fit(test_fitted *fitted, const test_data *data);

/* (w, dt) added: R <- exp([w]x) R, t <- t + dt. */
void test_move(double R[9], double t[3], const double d[6]);

/* The (w, dt) that takes (R_from, t_from) to (R_to, t_to). */
void test_difference(double d[6], const double R_from[9], const double t_from[3],
                     const double R_to[9], const double t_to[3]);

/* The pose for which a flat target far away may be mistaken: its points mirrored in the
 * plane through their middle that faces the camera. */
void test_mirror_tilt(test_fitted *mirrored, const test_data *data, const double R[9],
                      const double t[3]);

/* Solves A x = b, n <= 6, by elimination with pivots. Returns 0 if A is singular. */
int test_solve(double x[], const double A[], const double b[], int n);

/* d^T A^-1 d, n <= 6. */
double test_squared_distance(const double d[], const double A[], int n);

/* Element (i, j) of a symmetric 6 x 6 matrix. The first is for the vectors, with the lower
 * triangle row by row. The second is for the library, with the blocks of rc_sym6_. */
double test_lower(const double H[21], int i, int j);
double test_in_blocks(const rigcal_real H[21], int i, int j);

#endif /* TEST_FIT_H */
