/* rc_score.h - scores hypotheses of where a camera is. Each comes from the two poses that
 * each view has. Hypotheses are scored against each other (CHOICE in EQUATIONS.md). */
#ifndef RC_SCORE_H
#define RC_SCORE_H

#include "rc_choose.h"

/* ---- constants ----------------------------------------------------------- */

/* halvings: an interval that holds a median is halved this many times. The error is then
 * 2^-60 of the largest number. */
enum { RC_HALVINGS = 60 };

/* ---- scores -------------------------------------------------------------- */

enum { RC_SCORE_PLACEMENTS = RIGCAL_CHOOSE_PLACEMENTS };

/* tau^2 at a rung of the ladder. Two claims agree if their squared distance is below a
 * limit of sigma^2 times this. */
rigcal_real rc_score_tau2(int rung);

/* The score where there is no hypothesis. It is below all others. */
#define RC_SCORE_NONE RC(-2 * RC_SCORE_PLACEMENTS)

/* States of a camera while the rig grows: it waits, it has joined, or it must be scored
 * again. */
enum { RC_WAITS = 0, RC_JOINED = 1, RC_CHANGED = 2 };

/* States of a placement: no joined camera saw it; it must be placed anew; its views
 * disagree; its views agree, or only one view is left. */
enum { RC_UNSEEN = 0, RC_STALE = 1, RC_DOUBTFUL = 2, RC_KNOWN = 3 };

/* Where the parts of rig->work begin. Whole numbers are held as reals. */
typedef struct {
    rigcal_real *first;          /* the first view of each placement; one more at the end */
    rigcal_real *placed;         /* the view that placed it: 2 view + candidate */
    rigcal_real *strength;       /* the state of each placement */
    rigcal_real *camera, *told;  /* camera of each view (-1: left out); its information */
    rigcal_real *links;          /* information that each two cameras share */
    rigcal_real *score, *number; /* of each camera: its best hypothesis */
    rigcal_real *state;          /* of each camera: its state */
    rc_claim *cams;              /* cam_from_rig of the joined cameras */
    rigcal_real *list, *scores;  /* the list of placements; scores of hypotheses */
    rc_claim *rows;              /* hypotheses of two placements, 4 of each */
    rc_claim *claims;            /* the claims of one placement, in the memory of list */
} rc_score_parts;

void rc_score_parts_of(rc_score_parts *parts, const rigcal_rig *rig);

/* Pose 0 or 1 of a view. If there is none, pose->n is 0. */
rigcal_status rc_candidate_at(rigcal_view_pose *pose, const rigcal_choice *choice,
                              const rigcal_rig *rig, size_t view, int candidate);

/* Both poses of a view as claims. Where a pose is missing, its claim has view -1. */
rigcal_status rc_candidates(rc_claim claims[2], const rigcal_choose_solver *s, size_t view);

/* sigma^2 [px^2]. It is the stated one, or else the median of the variances in told[] that
 * are not below 0. These come from each view's own fit. Returns 0 if none is known. */
rigcal_real rc_score_variance(const rigcal_rig *rig, const rc_score_parts *parts);

/* The view that a camera has of a placement, or n_views if there is none. */
size_t rc_score_view_of(const rigcal_rig *rig, const rc_score_parts *parts, size_t camera,
                        size_t placement);

/* Lists the s->n placements with most information on the pose of camera s->b. They are
 * those that s->b shares with camera s->a or, if s->a is -1, the placements that are
 * placed. Returns 0 if there is none. */
int rc_score_begin(rigcal_choose_solver *s, const rc_score_parts *parts);

/* Scores the hypotheses of two placements of the list against each other. Returns RUNNING
 * until all pairs are scored. */
rigcal_status rc_score_step(rigcal_choose_solver *s, const rc_score_parts *parts);

/* After the last step: the score of the best hypothesis at a rung. *number is its
 * number. */
rigcal_real rc_score_best(int32_t *number, const rigcal_choose_solver *s,
                          const rc_score_parts *parts, int rung);

/* How many placements agree with a hypothesis of this score, its own included. */
int32_t rc_score_agree(rigcal_real score);

/* Computes the hypothesis of this number. */
rigcal_status rc_score_claim(rc_claim *b_from_a, const rigcal_choose_solver *s,
                             const rc_score_parts *parts, size_t number);

#endif /* RC_SCORE_H */
