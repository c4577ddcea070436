/* test_bands.h - two cameras of any lens at random, and what is true of a pixel of each, in
 * doubles: by the six derivatives of (G24), one after the other, where the library has one
 * covariance of the line. */
#ifndef TEST_BANDS_H
#define TEST_BANDS_H

#include "test_support.h"

enum { TEST_PINHOLE, TEST_BROWN, TEST_RATIONAL, TEST_FISHEYE, TEST_LENS_KINDS };

/* An image up to `size` pixels wide, every pixel of which the lens sees. */
rigcal_camera test_lens_random(test_rng *rng, int kind, double size);

typedef struct {
    rigcal_camera a, b;
    rigcal_match_pair pair; /* of a and b */
    rigcal_real uv_a[2];    /* in the image of a */
} test_bands;

/* Cameras beside, above and before each other, turned by up to 0.6 rad; a covariance with
 * all its cross terms; a depth range with both ends, with one, or with none. */
void test_bands_random(test_bands *scene, test_rng *rng, int kind, double size);

/* A pixel's ray, as the library has it, and its derivative by differences of the pixel of
 * the ray. 0: no ray. */
typedef struct {
    double m[3], D[2][3];
} test_ray;
int test_ray_of(test_ray *ray, const rigcal_camera *camera, const rigcal_real uv[2]);

/* What a band knows of a pixel of b. */
typedef struct {
    double s, variance, slope; /* |ds/du_b| */
    double chi2, depth_a;
    double ahead; /* of the rays' meeting, along both; not above 0: behind one of them */
    int is_inside;
    double margin; /* how far from being otherwise, in parts */
} test_band_truth;
void test_band_look(test_band_truth *truth, const test_bands *scene, const test_ray *a,
                    const test_ray *b);

#endif /* TEST_BANDS_H */
