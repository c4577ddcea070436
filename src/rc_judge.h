/* rc_judge.h - whether a view by itself can be where others have it. */
#ifndef RC_JUDGE_H
#define RC_JUDGE_H

#include "rc_chain.h"

/* ---- constants ----------------------------------------------------------- */

/* sigma^2: what the pose of a view may disagree with a placement. Chance makes it more in
 * 4e-5 of right views: chi square of 6. */
#define RC_DISAGREEMENT_LIMIT RC(30)

/* ---- functions ----------------------------------------------------------- */

/* d^T (H_placement^-1 + H_own^-1)^-1 d, d by which the view's own pose differs from that of
 * the chain, in the placement's frame [px^2]; both informations for noise of 1 px. RC_MAX:
 * they are not positive definite. */
rigcal_real rc_disagreement(const rigcal_view_pose *own,
                            const rigcal_transform *cam_from_rig,
                            const rigcal_transform *rig_from_placement,
                            const rigcal_real H_placement[21]);

/* The placement as one view has it by itself, and its information there. */
void rc_place_by(rigcal_transform *rig_from_placement, rigcal_real H_placement[21],
                 const rigcal_view_pose *own, const rigcal_transform *cam_from_rig);

#endif /* RC_JUDGE_H */
