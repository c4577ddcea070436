/* rc_camera.h - cameras without argument checks; see rigcal.h for the models. */
#ifndef RC_CAMERA_H
#define RC_CAMERA_H

#include "rc_lens.h"
#include "rc_transform.h"

/* ---- constants ----------------------------------------------------------- */

/* px, and 1 of coefficients: focal lengths, principal points, coefficients and pixels
 * beyond this are mistakes, and would overflow in products. */
#define RC_PIXEL_MAX RC(1e9)

/* pixels: a longer side of an image is a mistake. */
enum { RC_IMAGE_MAX = 1000000 };

/* part of a ray's largest coordinate: z of a ray in front is at least this, to rounding. */
#define RC_FORWARD_LEAST RC_EPS

/* ---- functions ----------------------------------------------------------- */

/* Returns OK, ERR_NULL, ERR_NOT_FINITE or ERR_CAMERA. */
rigcal_status rc_check_camera(const rigcal_camera *camera);

/* Return OK, ERR_NULL, ERR_NOT_FINITE or ERR_RANGE. */
rigcal_status rc_check_pixel(const rigcal_real uv[2]);
rigcal_status rc_check_observation(const rigcal_observation *o);

/* Sets *at_fault = index, unless at_fault is NULL. */
void rc_write_fault(int32_t *at_fault, int32_t index);

/* The size of a pixel in the unit of uv, for errors that are assumed in pixels. It is 1, or
 * less if the focal length is so short that the unit cannot be a pixel. */
rigcal_real rc_pixel_size(const rigcal_camera *camera);

/* Computes the pixel of X_c and d uv / d X_c, 2 x 3. `is_pinhole` is
 * rc_lens_is_pinhole(camera). Does not check whether X_c lies beyond the lens's turning
 * point; rc_project_usable does. Returns OK, ERR_BEHIND, ERR_NO_RAY (not finite) or
 * ERR_DEGENERATE. */
rigcal_status rc_project_through(rigcal_real uv[2], rigcal_real J_uv[6],
                                 const rigcal_camera *camera, int is_pinhole,
                                 const rigcal_real X_c[3]);

/* The same for any lens, a pinhole too. Also gives the place x in the plane of the lens
 * map. */
rigcal_status rc_project_by(rigcal_real x[2], rigcal_real uv[2], rigcal_real J_uv[6],
                            const rigcal_camera *camera, const rigcal_real X_c[3]);

/* Computes the pixel of X_c and proves that the lens sees it there, like
 * rigcal_camera_project. */
rigcal_status rc_project_usable(rigcal_real uv[2], const rigcal_camera *camera,
                                const rigcal_real X_c[3]);

/* Computes the unit ray of a pixel. Camera and pixel are already checked. Returns OK or
 * ERR_NO_RAY. */
rigcal_status rc_pixel_to_ray(rigcal_real ray[3], const rigcal_camera *camera,
                              const rigcal_real uv[2]);

#endif /* RC_CAMERA_H */
