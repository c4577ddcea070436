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

/* A camera's numbers from one of them on, in the order fx to k6. */
inline const rigcal_real *rc_camera_numbers(const rigcal_camera *camera, size_t offset)
{
    return (const rigcal_real *)(const void *)((const char *)camera + offset);
}

/* Whether all eight coefficients of Brown's lens are 0. */
int rc_lens_is_pinhole(const rigcal_camera *camera);

/* Computes F(x) and its Jacobian J = (xx, xy, yy). Returns 0 if F has a pole there. */
int rc_lens_map(rigcal_real F[2], rigcal_real J[3], const rigcal_camera *camera,
                const rigcal_real x[2]);

/* Whether J is positive definite all the way from the axis to x. There F does not fold.
 * Interval bounds prove it, not samples, in at most 1024 steps. */
int rc_lens_is_usable(const rigcal_camera *camera, const rigcal_real x[2]);

/* Proves the same for a disc about the axis at once. It tries the disc that the lens maps
 * onto all within `reach` of the axis and some more. Returns the squared radius of the disc
 * proved, or 0 if there is none. Takes at most 8 steps. For Brown's lens. */
rigcal_real rc_lens_proved(const rigcal_camera *camera, rigcal_real reach);

/* Finds x with F(x) = target, within 1e-10 of it, in a disc so proved. Returns 0 if 5 steps
 * of Newton's method do not find it. */
int rc_lens_invert_within(rigcal_real x[2], const rigcal_camera *camera,
                          const rigcal_real target[2], rigcal_real proved2);

/* Finds x with |F(x) - target| <= tolerance, where the lens is usable. Returns 0 if there
 * is none. At most 127 Newton solves of 60 steps, and 7 proofs. */
int rc_lens_invert(rigcal_real x[2], const rigcal_camera *camera,
                   const rigcal_real target[2], rigcal_real tolerance);

#endif /* RC_LENS_H */
