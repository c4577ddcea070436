/* rc_score.h - where a camera may be, by two poses each of what it saw: hypotheses, scored
 * against each other (CHOICE in EQUATIONS.md). */
#ifndef RC_SCORE_H
#define RC_SCORE_H

#include "rc_choose.h"

enum { RC_SCORE_PLACEMENTS = RIGCAL_CHOOSE_PLACEMENTS };

/* tau^2 at a rung of the ladder: two claims agree below a limit of sigma^2 times this. */
rigcal_real rc_score_tau2(int rung);

/* The score of a hypothesis that is none, below all others. */
#define RC_SCORE_NONE RC(-2 * RC_SCORE_PLACEMENTS)

/* Of a camera that grows with the rig: it waits; it is in; it is to be scored again. */
enum { RC_WAITS = 0, RC_JOINED = 1, RC_CHANGED = 2 };

/* Of a placement: no joined camera saw it; it is to be placed; its views disagree; they
 * agree, or it is one view. */
enum { RC_UNSEEN = 0, RC_STALE = 1, RC_DOUBTFUL = 2, RC_KNOWN = 3 };

/* Where the parts of rig->work begin. Numbers are held as reals. */
typedef struct {
    rigcal_real *first;          /* of each placement and one more: its first view, */
    rigcal_real *placed;         /* the view that placed it: 2 view + candidate, */
    rigcal_real *strength;       /* and how well */
    rigcal_real *camera, *told;  /* of each view; -1: left out. What it tells */
    rigcal_real *links;          /* of two cameras */
    rigcal_real *score, *number; /* of each camera, its best hypothesis */
    rigcal_real *state;          /* of each camera */
    rc_claim *cams;              /* cam_from_rig of the joined ones */
    rigcal_real *list, *scores;  /* of placements, and the hypotheses there */
    rc_claim *rows;              /* hypotheses of two placements, 4 each */
    rc_claim *claims;            /* in the same memory: of one placement */
} rc_score_parts;

void rc_score_parts_of(rc_score_parts *parts, const rigcal_rig *rig);

/* Pose 0 or 1 of a view; n is 0 where there is none. */
rigcal_status rc_candidate_at(rigcal_view_pose *pose, const rigcal_choice *choice,
                              const rigcal_rig *rig, size_t view, int candidate);

/* Both poses of a view as claims; those that are not there have view -1. */
rigcal_status rc_candidates(rc_claim claims[2], const rigcal_choose_solver *s, size_t view);

/* sigma^2 [px^2], stated or, where told[] has what each view's own fit leaves of it, the
 * median of those that are not below 0. 0: it cannot be known. */
rigcal_real rc_score_variance(const rigcal_rig *rig, const rc_score_parts *parts);

/* The view of a camera in a placement, or n_views. */
size_t rc_score_view_of(const rigcal_rig *rig, const rc_score_parts *parts, size_t camera,
                        size_t placement);

/* Hypotheses of camera s->b from s->a or, where that is -1, from the placed placements: a
 * list of the placements that tell most, s->n of them. 0: there is none. */
int rc_score_begin(rigcal_choose_solver *s, const rc_score_parts *parts);

/* Two placements of the list against each other. RUNNING until all are scored. */
rigcal_status rc_score_step(rigcal_choose_solver *s, const rc_score_parts *parts);

/* After the last: the best hypothesis at a rung, and its number. */
rigcal_real rc_score_best(int32_t *number, const rigcal_choose_solver *s,
                          const rc_score_parts *parts, int rung);

/* How many placements agree with a hypothesis of that score, its own included. */
int32_t rc_score_agree(rigcal_real score);

/* A hypothesis by its number. */
rigcal_status rc_score_claim(rc_claim *b_from_a, const rigcal_choose_solver *s,
                             const rc_score_parts *parts, size_t number);

#endif /* RC_SCORE_H */
