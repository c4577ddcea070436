/* rc_lens.h - a lens as a map of the plane; see rigcal.h for the models, and "Lens" in
 * EQUATIONS.md for the symbols.
 *
 * Both models are one map F of the plane. With s = |x|^2,
 *
 *     F(x) = N(s) / D(s) x + 2 (g.x) x + g s,        g = (p2, p1)
 *
 * Brown: x = (X, Y) / Z. Fisheye: x = theta (X, Y) / r, D = 1, g = 0. F is the gradient of
 * a potential, so its Jacobian is symmetric. */
#ifndef RC_LENS_H
#define RC_LENS_H

#include "rc_linalg.h"

inline int rc_lens_is_fisheye(const rigcal_camera *camera)
{
    return RIGCAL_WITH_FISHEYE && camera->lens == RIGCAL_LENS_FISHEYE;
}

/* A camera's numbers from one of them on, in their order: fx to k6. */
inline const rigcal_real *rc_camera_numbers(const rigcal_camera *camera, size_t offset)
{
    return (const rigcal_real *)(const void *)((const char *)camera + offset);
}

/* Whether all eight coefficients are 0, of Brown's lens. */
int rc_lens_is_pinhole(const rigcal_camera *camera);

/* F(x) and its Jacobian J = (xx, xy, yy). 0 where F has a pole. */
int rc_lens_map(rigcal_real F[2], rigcal_real J[3], const rigcal_camera *camera,
                const rigcal_real x[2]);

/* Whether J is positive definite all the way from the axis to x: on this part of the plane
 * F does not fold. A proof by interval bounds, not by samples; at most 1024 steps. */
int rc_lens_is_usable(const rigcal_camera *camera, const rigcal_real x[2]);

/* Proves the same of a disc about the axis at once, into which the lens maps all within
 * `reach` of the axis and some more. Returns its radius squared; 0: no proof was found. At
 * most 8 steps. Brown's lens. */
rigcal_real rc_lens_proved(const rigcal_camera *camera, rigcal_real reach);

/* x with F(x) = target, within 1e-10 of it, in a disc so proved; 0: not found there, in 5
 * steps of Newton's method. */
int rc_lens_invert_within(rigcal_real x[2], const rigcal_camera *camera,
                          const rigcal_real target[2], rigcal_real proved2);

/* x with |F(x) - target| <= tolerance, where the lens is usable; 0: there is none. At most
 * 127 Newton solves of 60 steps, and 7 proofs. */
int rc_lens_invert(rigcal_real x[2], const rigcal_camera *camera,
                   const rigcal_real target[2], rigcal_real tolerance);

#endif /* RC_LENS_H */
