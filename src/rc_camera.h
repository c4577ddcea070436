/* rc_camera.h - cameras without argument checks; see rigcal.h for the models. */
#ifndef RC_CAMERA_H
#define RC_CAMERA_H

#include "rc_lens.h"
#include "rc_transform.h"

/* ---- constants ----------------------------------------------------------- */

/* px, and 1 of coefficients: focal lengths, principal points, coefficients and pixels
 * beyond this are mistakes, and would overflow in products. */
#define RC_PIXEL_MAX RC(1e9)

/* pixels along a side of an image: more are a mistake. */
enum { RC_IMAGE_MAX = 1000000 };

/* part of a ray's largest coordinate: z of a ray in front, to rounding. */
#define RC_FORWARD_LEAST RC_EPS

/* ---- functions ----------------------------------------------------------- */

/* OK, ERR_NULL, ERR_NOT_FINITE or ERR_CAMERA. */
rigcal_status rc_check_camera(const rigcal_camera *camera);

/* OK, ERR_NULL, ERR_NOT_FINITE or ERR_RANGE. */
rigcal_status rc_check_pixel(const rigcal_real uv[2]);
rigcal_status rc_check_observation(const rigcal_observation *o);

/* *at_fault = index, for who wants it. */
void rc_write_fault(int32_t *at_fault, int32_t index);

/* What a pixel is, in the unit of uv, where an error is assumed in pixels: 1, but less
 * where the focal length is so short that the unit cannot be a pixel. */
rigcal_real rc_pixel_size(const rigcal_camera *camera);

/* Pixel of X_c and d uv / d X_c, 2 x 3; `is_pinhole` as of rc_lens_is_pinhole. Does not
 * check whether X_c lies beyond the lens's turning point; rc_project_usable does. OK,
 * ERR_BEHIND, ERR_NO_RAY (not finite), ERR_DEGENERATE. */
rigcal_status rc_project_through(rigcal_real uv[2], rigcal_real J_uv[6],
                                 const rigcal_camera *camera, int is_pinhole,
                                 const rigcal_real X_c[3]);

/* The same through any lens, a pinhole too. Also gives the place x in the plane of the lens
 * map. */
rigcal_status rc_project_by(rigcal_real x[2], rigcal_real uv[2], rigcal_real J_uv[6],
                            const rigcal_camera *camera, const rigcal_real X_c[3]);

/* The pixel of X_c, and the proof that the lens sees it there: as rigcal_camera_project. */
rigcal_status rc_project_usable(rigcal_real uv[2], const rigcal_camera *camera,
                                const rigcal_real X_c[3]);

/* Unit ray of a pixel, camera and pixel already checked: OK or ERR_NO_RAY. */
rigcal_status rc_pixel_to_ray(rigcal_real ray[3], const rigcal_camera *camera,
                              const rigcal_real uv[2]);

#endif /* RC_CAMERA_H */
