/* rc_roots.h - where few points may be, from three of them (EQUATIONS.md D). */
#ifndef RC_ROOTS_H
#define RC_ROOTS_H

#include "rc_optima.h"
#include "rc_p3p.h"
#include "rc_points.h"

/* (D) Computes all poses of three of the points from their unit rays. Returns how many,
 * like rc_p3p. */
int32_t rc_poses_of_three(rigcal_transform cam_from_points[RC_P3P_MAX],
                          const rigcal_points *points, const int32_t index[3],
                          const rigcal_real ray[3][3]);

/* (D) The same for a triple's points and rays, with less stack. */
int32_t rc_triple_poses(rigcal_transform cam_from_points[RC_P3P_MAX], rigcal_triple *triple,
                        const rigcal_points *points);

/* (D4) The search for the poses of the widest triple that the other points do not rule out.
 * A step is the triple, the ray of one of its points, its poses, or the score of one pose:
 * O(n). triple->count, 0 at first, counts the steps. Returns 1 when it is done.
 *
 *   optima   out     the poses stand in list[], best first; n is 0 and stays 0: read a pose
 *                    before optima that are found overwrite it
 *   n_roots  in/out  their number, 0 at first. 0 also where the triple is narrow, or the
 *                    lens images no ray at one of its points */
int rc_roots_step(rigcal_optima *optima, uint8_t *n_roots, rigcal_triple *triple,
                  const rigcal_points *points);

#endif /* RC_ROOTS_H */
