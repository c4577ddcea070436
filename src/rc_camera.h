/* rc_camera.h - the lens as a map of the plane; see rigcal.h for the models. */
#ifndef RC_CAMERA_H
#define RC_CAMERA_H

#include "rc_transform.h"

/* Focal lengths, principal points, coefficients and pixels beyond this are mistakes, and
 * would overflow in products. */
#define RC_PIXEL_MAX RC(1e9)

/* Pixels along a side of an image. */
enum { RC_IMAGE_MAX = 1000000 };

/* Both lens models as one map F of the plane. With s = |x|^2,
 *
 *     F(x) = N(s) / D(s) x + 2 (q.x) x + q s
 *
 * Brown: x = (X, Y) / Z, q = (p2, p1). Fisheye: x = theta (X, Y) / r, D = 1, q = 0.
 * F is the gradient of a potential, so its Jacobian is symmetric. rigcal_lens holds the
 * coefficients of N and D by ascending powers of s, and q. */

/* OK, ERR_NULL, ERR_NOT_FINITE or ERR_CAMERA. */
rigcal_status rc_check_camera(const rigcal_camera *camera);

/* OK, ERR_NULL, ERR_NOT_FINITE or ERR_RANGE. */
rigcal_status rc_check_pixel(const rigcal_real uv[2]);
rigcal_status rc_check_observation(const rigcal_observation *o);

/* What a pixel is, in the unit of uv, where an error is assumed in pixels: 1, but less
 * where the focal length is so short that the unit cannot be a pixel. */
rigcal_real rc_pixel_size(const rigcal_camera *camera);

/* The observation at fault, -1: none, for who wants it. */
void rc_write_fault(int32_t *bad, int32_t index);

void rc_lens_of(rigcal_lens *lens, const rigcal_camera *camera);

/* F(x) and its Jacobian J = (xx, xy, yy). 0 where F has a pole. */
int rc_lens_map(rigcal_real F[2], rigcal_real J[3], const rigcal_lens *lens,
                const rigcal_real x[2]);

/* Whether J is positive definite all the way from the axis to x: on this part of
 * the plane F does not fold. A proof by interval bounds, not by samples. */
int rc_lens_is_usable(const rigcal_lens *lens, const rigcal_real x[2]);

/* Pixel of X_c and d uv / d X_c, 2 x 3. Says nothing of the turning point. OK,
 * ERR_BEHIND, ERR_NO_RAY (not finite), ERR_DEGENERATE. */
rigcal_status rc_project_through(rigcal_real uv[2], rigcal_real J_uv[6],
                                 const rigcal_lens *lens,
                                 const rigcal_camera *camera,
                                 const rigcal_real X_c[3]);

/* The pixel of X_c, and the proof that the lens sees it there: as rigcal_project. */
rigcal_status rc_project_usable(rigcal_real uv[2], const rigcal_camera *camera,
                                const rigcal_real X_c[3]);

/* Unit ray of a pixel, camera and pixel already checked: OK or ERR_NO_RAY. */
rigcal_status rc_pixel_to_ray(rigcal_real ray[3], const rigcal_camera *camera,
                              const rigcal_real uv[2]);

#endif /* RC_CAMERA_H */
