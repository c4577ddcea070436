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

/* What a step came to. */
enum {
    RC_SEEDS_BUSY,         /* nothing yet */
    RC_SEEDS_START,        /* a start: search->work.refinement.cam_from_points */
    RC_SEEDS_UNSEEN,       /* the lens images no ray at the pixel of point search->point */
    RC_SEEDS_TRIPLE_SPENT, /* the poses of a triple of points have been handed out: enough,
                              or rc_seeds_pick */
    RC_SEEDS_SPENT         /* there is no other start */
};

/* Begins a search, all 0 at first, over the points surveyed in s->points. The virtual
 * camera looks along the ray of uv_middle; where that has none, along the camera's own
 * axis. */
void rc_seeds_begin(rigcal_search *s, const rigcal_real uv_middle[2]);

/* One ray (of a pinhole, whose rays cost next to nothing, up to 16), one cost of a
 * direction, all poses of three points, or one choice. Returns RC_SEEDS_, or a failure:
 * ERR_COINCIDENT, ERR_COLLINEAR, ERR_TOO_FEW (three points, in a build without),
 * ERR_WIDE_RAY (of point s->point, in such a build). */
int32_t rc_seeds_step(rigcal_search *s);

/* Goes on to another triple. 0: enough have been tried. */
int rc_seeds_pick(rigcal_search *s);

/* The search being spent: whether mirrored points may fit as well as the first optimum
 * does. Their start is then in search->work.refinement.cam_from_points. */
int rc_seeds_mirrored(rigcal_search *s);

/* The search being spent: begins that of the lattice. 0: it has been, or there is none. */
int rc_seeds_scan(rigcal_search *s);

#endif /* RC_SEEDS_H */
