/* rigcal_match.h - where in another image the match of a pixel can be, and how surely.
 * Included by rigcal.h, whose first page holds here too.
 *
 * With a calibrated pair of cameras, the match of a pixel is searched along a line instead
 * of the whole image. The line has a width, because the pixels of both cameras are noisy
 * and the calibration is not exact.
 *
 *   rigcal_match_k          how many standard deviations hold a given share of matches
 *   rigcal_band_make        the band in image b of one pixel of image a
 *   rigcal_band_curve       the band as a curve with two borders, to draw
 *   rigcal_band_test        whether one pixel of b is in it
 *   rigcal_band_search      which of many pixels are in it, best first
 *   rigcal_spans_begin      the columns to search, for every row of image b
 *   rigcal_transfer_make    where a third camera must see what a and b see
 *   rigcal_rectify          turns two cameras so that the matching lines are rows
 *
 * EQUATIONS.md MATCH has the mathematics: (M1) and so on. */
#ifndef RIGCAL_H
#include "rigcal.h" /* rigcal.h includes this header too */
#endif

#ifndef RIGCAL_MATCH_H
#define RIGCAL_MATCH_H

#ifdef __cplusplus
extern "C" {
#endif

/* ==== how wide =============================================================== */

/* What a band of given probability is for. */
enum rigcal_match_purposes {
    RIGCAL_MATCH_SEARCH = 1, /* the band holds the true match with that probability: chi
                                square with 1 degree of freedom, k = 2.576 for 0.99 */
    RIGCAL_MATCH_DRAW = 2    /* the band holds the whole true line with that probability:
                                chi square with 2 degrees, k = 3.035 */
};

/* k, the number of standard deviations, for a probability in [0.001, 0.999999]. The
 * nearest float to 0.999999 is 6 % off in the share of matches that it leaves out.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE. */
RIGCAL_API rigcal_status rigcal_match_k(rigcal_real *k, rigcal_real probability,
                                        int32_t purpose);

/* ==== the band =============================================================== */

/* The ray of a pixel, and how it turns with the pixel. */
typedef struct rigcal_ray {
    rigcal_real m[3]; /* of length 1 */
    rigcal_real D[6]; /* dm / d(u, v), 3 x 2 row by row */
} rigcal_ray;

/* The ray of a pixel of `camera`. Make it once for each pixel, and use it for all bands.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_RANGE, ERR_NO_RAY. */
RIGCAL_API rigcal_status rigcal_ray_make(rigcal_ray *ray, const rigcal_camera *camera,
                                         const rigcal_real uv[2]);

/* Two cameras, and what is known of them. */
typedef struct rigcal_match_pair {
    const rigcal_camera *camera_a, *camera_b;
    rigcal_transform b_from_a;
    rigcal_real Sigma[36]; /* covariance of (w, dt) of b_from_a, as rigcal_calibrated_pair
                              and rigcal_rig_pair write it. Ask them for the noise of the
                              rig, times sqrt(F) if F is above 1. All 0: the pair is
                              exact */
    rigcal_real sigma_a, sigma_b; /* noise of one coordinate of a pixel of each camera [px]:
                                     rigcal_rig_noise. 0 .. 1e6, sigma_b above 0 */
    rigcal_real k;                /* half width of the band in standard deviations, > 0 ..
                                     100: rigcal_match_k */
    rigcal_real near_a, far_a;    /* range of the distance from camera a along the ray, 0 <=
                                     near_a < far_a; far_a 0: no limit */
} rigcal_match_pair;

/* The band of one pixel of a. Flat: it keeps no pointer and may be copied. */
typedef struct rigcal_band {
    rigcal_camera camera_b;
    rigcal_real ray[3];        /* R m_a, of length 1: the ray of a in frame b */
    rigcal_real towards[3];    /* of length 1, across the ray, towards the centre of a */
    rigcal_real along, across; /* t = along ray + across towards, across > 0 */
    rigcal_real line[3];       /* t x ray: m_b . line is 0 for exact matches (25), (26) */
    rigcal_real Sigma_line[6]; /* its covariance in the axes ray, towards, line / across:
                                  xx, xy, xz, yy, yz, zz */
    rigcal_real epipole2;      /* variance of the direction of t [rad^2] */
    rigcal_real sigma_b, k, near_a, far_a;
} rigcal_band;

/* The band of pixel uv_a. Time O(1).
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_ROTATION, ERR_RANGE, ERR_NO_RAY (of uv_a),
 * ERR_EPIPOLE (uv_a is within max(3, k) standard deviations of the image of the centre of
 * b, or the centres coincide: the line has no direction). */
RIGCAL_API rigcal_status rigcal_band_make(rigcal_band *band, const rigcal_match_pair *pair,
                                          const rigcal_real uv_a[2]);

/* The same from the ray of that pixel. Also returns ERR_RANGE (m does not have length
 * 1). */
RIGCAL_API rigcal_status rigcal_band_make_ray(rigcal_band *band,
                                              const rigcal_match_pair *pair,
                                              const rigcal_ray *ray_a);

/* One place of the band. */
typedef struct rigcal_band_point {
    rigcal_real uv[2];      /* on the matching line, in the real, distorted image */
    rigcal_real across[2];  /* of length 1: the direction across the line there */
    rigcal_real half_width; /* [px]: the borders are uv -+ half_width across */
    rigcal_real depth_a;    /* distance from camera a along its ray; 0: at infinity */
} rigcal_band_point;

/* The band along the depth range: `capacity` >= 2 places from near to far, evenly spaced in
 * the angle between the two rays. Places that camera b cannot see, behind it or beyond its
 * lens, are left out: *n_written are written. OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA,
 * ERR_RANGE, ERR_OUTSIDE (none left). O(capacity) */
RIGCAL_API rigcal_status rigcal_band_curve(rigcal_band_point points[], size_t capacity,
                                           size_t *n_written, const rigcal_band *band);

/* ==== candidates ============================================================= */

/* What a band says of one candidate. */
typedef struct rigcal_match {
    int32_t index;     /* of the candidate in its array; of rigcal_band_test 0 */
    int32_t is_inside; /* 1: within k standard deviations, and the depth is in range */
    rigcal_real chi2;  /* s^2 / var(s): chi square of 1 for a true match */
    rigcal_real distance_px;   /* from the line in the real image, signed */
    rigcal_real half_width_px; /* of the band there */
    rigcal_real score;         /* chi2 + ln(var(s) / |ds/du_b|^2): the least is the best */
    rigcal_real depth_a; /* distance from camera a of the point of its ray that is seen at
                            the place of the line nearest to the candidate */
} rigcal_match;

/* Tests a pixel of b, or its ray, against the band.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_RANGE, ERR_NO_RAY, and for the geometry
 * ERR_EPIPOLE (within 3 standard deviations of the image of the centre of a, where the
 * depth has no sign), ERR_PARALLEL (the rays are parallel, to rounding), ERR_BEHIND (the
 * rays meet behind a camera), ERR_DEGENERATE (the candidate is 90 degrees off the line,
 * where the first-order test fails). */
RIGCAL_API rigcal_status rigcal_band_test(rigcal_match *match, const rigcal_band *band,
                                          const rigcal_real uv_b[2]);
RIGCAL_API rigcal_status rigcal_band_test_ray(rigcal_match *match, const rigcal_band *band,
                                              const rigcal_ray *ray_b);

/* Finds those of n candidates that are inside, best first. They are the first *n_written
 * of matches[capacity]. *n_inside is how many there are, even beyond the capacity. A
 * candidate that rigcal_band_test refuses for its geometry is not inside. There is one
 * pass, and each candidate that is inside is sorted in: O(n + n_inside capacity).
 *
 *   uv_b      in   n pairs
 *   rays_b    in   n, of rigcal_ray_make
 *
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_RANGE. *at_fault: the candidate, or -1. */
RIGCAL_API rigcal_status rigcal_band_search(rigcal_match matches[], size_t capacity,
                                            size_t *n_written, size_t *n_inside,
                                            int32_t *at_fault, const rigcal_band *band,
                                            const rigcal_real uv_b[], size_t n);
RIGCAL_API rigcal_status rigcal_band_search_rays(rigcal_match matches[], size_t capacity,
                                                 size_t *n_written, size_t *n_inside,
                                                 int32_t *at_fault, const rigcal_band *band,
                                                 const rigcal_ray rays_b[], size_t n);

/* ==== spans ==================================================================
 *
 * The pixels of image b in which to search. A span has every pixel whose centre is in the
 * band by the test above, and at most one more at each end. Where the band crosses a row
 * several times, the row has several spans. Pixels near the image of the centre of a,
 * which the test refuses, count as inside. A match lies between the centres of pixels: the
 * pixel nearest to it may be beside the band. Whoever searches at whole pixels for one of
 * them searches the neighbours of the spans too.
 *
 * All this holds while the half width of the band is below a fiftieth of fx and of fy, 1.1
 * degrees; p1 and p2 are within 0.05; nowhere in the image the lens shrinks an area to a
 * quarter of fx fy; and the image reaches at most 10 fx and 10 fy from its centre. For a
 * pinhole or a fisheye the half width may be up to half of fx and of fy. The spans of other
 * bands may lack pixels. */
typedef struct rigcal_span {
    int32_t row, first, last; /* columns first to last, within the image */
} rigcal_span;

enum rigcal_spans_limits {
    RIGCAL_SPANS_ROW = 8,     /* spans of one row at most */
    RIGCAL_SPANS_UNITS = 2000 /* units of rigcal_spans_step at most */
};

typedef struct rigcal_spans_solver rigcal_spans_solver; /* see rigcal_solvers.h */

/* All spans of the image of b, row by row, and from left to right in each row. It calls
 * begin, step to the end, and result. The solver is memory to work in; it is too large for
 * a small stack. */
RIGCAL_API rigcal_status rigcal_spans_find(rigcal_span spans[], size_t capacity,
                                           size_t *n_found, rigcal_spans_solver *solver,
                                           const rigcal_band *band);

/* OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_RANGE (a field of the band). */
RIGCAL_API rigcal_status rigcal_spans_begin(rigcal_spans_solver *solver,
                                            const rigcal_band *band);

/* Spends at most `budget` >= 1 units. A unit is one place of the borders; there are at
 * most RIGCAL_SPANS_UNITS. It usually takes one or two projections. Beside a fold of the
 * lens it takes up to 24, and each is proved by up to 1024 steps along the lens. RUNNING:
 * call again. The budgets do not change one bit of the result. OK: ask for the spans.
 * ERR_NULL, ERR_RANGE, ERR_STATE; ERR_DEGENERATE: the borders have more arcs than the
 * solver has room for. */
RIGCAL_API rigcal_status rigcal_spans_step(rigcal_spans_solver *solver, int32_t budget);

/* The spans of one row, 0 to height - 1: the first *n_found of spans[RIGCAL_SPANS_ROW].
 * Rows may come in any order. OK (also if there are none), ERR_NULL, ERR_RANGE,
 * ERR_STATE. */
RIGCAL_API rigcal_status rigcal_spans_row(rigcal_span spans[], size_t *n_found,
                                          rigcal_spans_solver *solver, int32_t row);

/* All rows. OK, ERR_NULL, ERR_STATE, ERR_OUTSIDE (no pixel of the image is in the band),
 * ERR_CAPACITY. Rows: at most the height of the image. */
RIGCAL_API rigcal_status rigcal_spans_result(rigcal_span spans[], size_t capacity,
                                             size_t *n_found, rigcal_spans_solver *solver);

/* ==== a third camera ========================================================= */

/* Where camera c must see the point that camera a sees at uv_a and camera b at uv_b. */
typedef struct rigcal_transfer {
    rigcal_real uv[2];      /* pixel of c */
    rigcal_real Sigma[4];   /* its covariance [px^2], without the noise of c's pixels */
    rigcal_real X[3];       /* the point, in the frame of the rig */
    rigcal_real Sigma_X[9]; /* its covariance, with the calibration's share */
    rigcal_real chi2;       /* of the match of uv_a and uv_b: chi square with 1 degree */
} rigcal_transfer;

/* Makes a transfer from a calibrated rig, with the joint covariance of its three cameras.
 *
 *   abc          in   three different cameras of the rig, of one group
 *   uv_a, uv_b   in   pixels
 *   sigma_ab     in   noise of one coordinate of a pixel of a and of b, > 0
 *
 * OK, RIGCAL_DISCONNECTED, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_ROTATION, ERR_RANGE,
 * ERR_TOO_FEW, ERR_CAPACITY, ERR_STATE (no joint covariance), ERR_NO_RAY, ERR_PARALLEL,
 * ERR_BEHIND (a, b or c), ERR_DEGENERATE (also: the joint covariance is not a
 * covariance). */
RIGCAL_API rigcal_status rigcal_transfer_make(
    rigcal_transfer *transfer, const rigcal_calibrated_rig *rig, const size_t abc[3],
    const rigcal_real uv_a[2], const rigcal_real uv_b[2], const rigcal_real sigma_ab[2]);

/* chi2 of a candidate pixel of c, whose noise is sigma_c >= 0. For a true match it is chi
 * square with 2 degrees, which is below 9.21 with probability 0.99 (k^2 of
 * RIGCAL_MATCH_DRAW).
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE, ERR_DEGENERATE (no covariance). */
RIGCAL_API rigcal_status rigcal_transfer_test(rigcal_real *chi2,
                                              const rigcal_transfer *transfer,
                                              rigcal_real sigma_c,
                                              const rigcal_real uv_c[2]);

/* ==== an aligned pair ======================================================== */

/* Two cameras turned about their centres until their rows are the matching lines: aligned
 * stereo, as rigcal_depth_aligned (19), (20) takes it. */
typedef struct rigcal_rectified {
    rigcal_real
        aligned_from_a[9]; /* rotation of rays of a; its transpose turns them back */
    rigcal_real aligned_from_b[9];
    rigcal_real baseline; /* between the centres, > 0 */
    int32_t a_is_right;   /* 1: a is the right camera, b the left one; 0: as usual, or one
                             is exactly above the other */
    rigcal_camera camera; /* virtual pinhole of both: its pixel is seen by a along
                             aligned_from_a^T (x, y, 1), and by b alike */
} rigcal_rectified;

/* The aligned x axis is the baseline. The z axis is as near as possible to the mean of
 * both optical axes. The virtual camera has the mean focal length and the size of image a.
 * Its principal point is such that the middles of both images come to lie around the
 * middle of its own image. The band says how far a match may be off its row.
 * OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_ROTATION, ERR_RANGE, ERR_PARALLEL (the
 * centres coincide), ERR_EPIPOLE (the baseline is within 10 degrees of the optical axes),
 * ERR_NO_RAY, ERR_WIDE_RAY (the middle of an image is behind the aligned camera). */
RIGCAL_API rigcal_status rigcal_rectify(rigcal_rectified *rectified,
                                        const rigcal_camera *camera_a,
                                        const rigcal_camera *camera_b,
                                        const rigcal_transform *b_from_a);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_MATCH_H */
