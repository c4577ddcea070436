/* rc_band.h - the band of a matching line (EQUATIONS.md MATCH); see rigcal_match.h. */
#ifndef RC_BAND_H
#define RC_BAND_H

#include "rc_camera.h"

/* Projects the direction m, of any length: its pixel, J = d(u, v) / dm, 2 x 3, and the two
 * columns of D = dm / d(u, v) across m. OK; ERR_NO_RAY, also where the lens shrinks an area
 * to a fiftieth, close to where it folds: there no derivative holds over the width of the
 * noise. It does not prove that the lens sees m: use rc_project_usable. */
rigcal_status rc_band_place(rigcal_real uv[2], rigcal_real J[6], rigcal_real D[2][3],
                            const rigcal_camera *camera, int is_pinhole,
                            const rigcal_real m[3]);

/* Checks a band from a caller: OK, ERR_NULL, ERR_NOT_FINITE, ERR_CAMERA, ERR_RANGE. */
rigcal_status rc_band_check(const rigcal_band *band);

/* Checks a ray from a caller: OK, ERR_NOT_FINITE, ERR_RANGE (m does not have length 1). */
rigcal_status rc_ray_check(const rigcal_ray *ray);

/* Tests a checked ray against a checked band. It writes all that rigcal_band_test_ray
 * writes except the index. With ERR_PARALLEL only the half width is written. */
rigcal_status rc_band_test(rigcal_match *match, const rigcal_band *band,
                           const rigcal_ray *ray);

/* The direction (along, across), in the basis (ray, towards), of the point at `depth` from
 * camera a. It has length 1. */
void rc_band_direction(rigcal_real out[2], const rigcal_band *band, rigcal_real depth);

/* The ends of the depth range, far and near, as such directions. Infinity is (1, 0). */
void rc_band_ends(rigcal_real ends[2][2], const rigcal_band *band);

/* The larger eigenvalue of (a b; b c). */
rigcal_real rc_largest_of(rigcal_real a, rigcal_real b, rigcal_real c);

#endif /* RC_BAND_H */
