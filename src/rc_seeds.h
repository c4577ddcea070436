/* rc_seeds.h - where the refinement of a pose may start: the poses of three points, the
 * best directions of a lattice after a descent, and those that lean other than the first
 * optimum (EQUATIONS.md A, D).
 *
 * A search hands out one start after the other; its owner refines each, and keeps the
 * optima in search->optima, from which the next starts follow. */
#ifndef RC_SEEDS_H
#define RC_SEEDS_H

#include "rc_direction.h"
#include "rc_neldermead.h"
#include "rc_refine.h"
#include "rc_roots.h"

/* What a step returns. */
enum {
    RC_SEEDS_BUSY,         /* nothing yet */
    RC_SEEDS_START,        /* a start: search->work.refinement.cam_from_points */
    RC_SEEDS_UNSEEN,       /* the lens images no ray at the pixel of point search->point */
    RC_SEEDS_TRIPLE_SPENT, /* the poses of a triple of points have been handed out: enough,
                              or rc_seeds_pick */
    RC_SEEDS_SPENT         /* there is no other start */
};

/* Begins a search over the points surveyed in s->points. The caller has set all else in *s
 * to 0. The virtual camera looks along the ray of uv_middle or, if that pixel has no ray,
 * along the camera's own axis. */
void rc_seeds_begin(rigcal_search *s, const rigcal_real uv_middle[2]);

/* Does one piece of work: one ray (up to 16 of a pinhole, whose rays cost nearly nothing),
 * one cost of a direction, all poses of three points, or one choice. Returns RC_SEEDS_ or a
 * failure: ERR_COINCIDENT, ERR_COLLINEAR, ERR_TOO_FEW (three points) or ERR_WIDE_RAY (of
 * point s->point). The last two come in builds without poses of three points. */
int32_t rc_seeds_step(rigcal_search *s);

/* Goes on to another triple. Returns 0 if enough have been tried. */
int rc_seeds_pick(rigcal_search *s);

/* For a search that is spent: whether mirrored points may fit as well as the first optimum
 * does. If so, search->work.refinement.cam_from_points is their start. */
int rc_seeds_mirrored(rigcal_search *s);

/* Begins the search of the lattice, for a search that has no starts left. Returns 0 if the
 * lattice has been searched already, or if there is none. */
int rc_seeds_scan(rigcal_search *s);

#endif /* RC_SEEDS_H */
