/* rc_view.h - the search over the direction of the optical axis: yaw and
 * translation are eliminated together (EQUATIONS.md A). */
#ifndef RC_VIEW_H
#define RC_VIEW_H

#include "rc_transform.h"

/* Sums over the points, from which the cost of any direction follows in the same
 * time whatever n is. x is a point counted from the points' mean, uc = u + i v its
 * normalised image in the virtual camera, whose axis runs through the middle of
 * the image of the target. Symmetric matrices: xx, xy, xz, yy, yz, zz. */
typedef struct {
    rigcal_real n;
    rigcal_real u_mean[2];    /* mean of uc: real, imaginary part */
    rigcal_real V_mean[2][3]; /* mean of uc x */
    rigcal_real S;            /* sum |uc - mean|^2 */
    rigcal_real h[3];         /* Re sum conj(V) du */
    rigcal_real Q[6];         /* K - C */
    rigcal_real trace_C;      /* sum |x|^2 */
    rigcal_real G[2][6];      /* sum conj(uc) x x^T */
} rc_view;

void rc_view_begin(rc_view *view);
void rc_view_add(rc_view *view, const rigcal_real x[3], const rigcal_real u[2]);

/* 0 when the image has no extent. */
int rc_view_finish(rc_view *view);

/* Object-space cost of the direction m3 (the optical axis, seen from the target;
 * unit length), least over yaw and translation with the points' mean in front.
 * RC_MAX where it cannot be in front. */
rigcal_real rc_view_cost(const rc_view *view, const rigcal_real m3[3]);

/* The pose that has that cost: of the virtual camera from the points counted from
 * their mean. */
void rc_view_pose(rigcal_transform *virtual_from_points, const rc_view *view,
                  const rigcal_real m3[3]);

#endif /* RC_VIEW_H */
