/* test_bands.h - two random cameras with any lens, and the truth about a pixel of each, in
 * double. It uses the six derivatives of (M3), one after the other. The library has one
 * covariance of the line instead. */
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

/* Cameras beside, above and before each other, turned by up to 0.6 rad. The covariance has
 * all cross terms. The depth range has both ends, one, or none. */
void test_bands_random(test_bands *scene, test_rng *rng, int kind, double size);

/* The same, but camera b has a lens that nearly folds in a ring: 1 + 3 k1 s + 5 k2 s^2 has
 * its least value, a few thousandths, at s = r^2 = -3 k1 / (10 k2). Bands as wide as the
 * ring and wider: nothing is promised. */
void test_bands_wild(test_bands *scene, test_rng *rng, double size);

/* Camera b is 1 to the right of a. Both are the same pinhole of 80 x 60 px, so lines are
 * rows. sigma_b is the only noise. The pair keeps a pointer to the camera. */
void test_bands_beside(rigcal_match_pair *pair, rigcal_camera *camera, double sigma_b,
                       double k);

/* The ray of a pixel, as the library computes it, and its derivative by differences of the
 * pixel of the ray. Returns 0 if there is no ray. */
typedef struct {
    double m[3], D[2][3];
} test_ray;
int test_ray_of(test_ray *ray, const rigcal_camera *camera, const rigcal_real uv[2]);

/* What a band says about a pixel of b. */
typedef struct {
    double s, variance, slope; /* |ds/du_b| */
    double chi2, depth_a;
    double ahead; /* depth of the place where the rays meet, along both; at most 0: behind a
                     camera */
    int is_inside;
    double margin; /* how far it is from the opposite answer, as a part */
} test_band_truth;
void test_band_look(test_band_truth *truth, const test_bands *scene, const test_ray *a,
                    const test_ray *b);

#endif /* TEST_BANDS_H */
