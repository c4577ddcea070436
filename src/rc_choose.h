/* rc_choose.h - which of the poses of a view the others support (CHOICE in EQUATIONS.md).
 *
 * A claim is a transform with what is known of it. A view claims where a placement is, two
 * views where one camera is from the other. Right claims agree, wrong ones do not repeat.
 */
#ifndef RC_CHOOSE_H
#define RC_CHOOSE_H

#include "rc_views.h"

/* ---- constants ----------------------------------------------------------- */

/* sigma^2 tau^2: what two right claims are apart at most: chi squared of 6 degrees of
 * freedom, which exceeds this once in 25000. */
#define RC_CHOOSE_LIMIT RC(30)

/* ---- claims -------------------------------------------------------------- */

typedef struct {
    rigcal_transform b_from_a;
    rigcal_real Sigma[21]; /* of its turn w, and of the shift of `pivot` as seen in b, for
                              noise of 1 px */
    rigcal_real pivot[3];  /* in frame a: where the target is */
    rigcal_real extra;     /* px^2: sum of squares, less that of the view's first pose */
    rigcal_real view;      /* its number; -1: there is no such claim */
    rigcal_real candidate; /* 0 or 1: which pose of the view */
} rc_claim;

/* Reals that a claim takes, and that the claims of a placement of so many views take at
 * most. */
#define RC_CLAIM_REALS 39
#define RC_CLAIMS_WORK(n_views) (2 * RC_CLAIM_REALS * (size_t)(n_views))

/* A pose of a view: cam_from_target. 0: its information is not positive definite. */
int rc_claim_of_view(rc_claim *claim, const rigcal_view_pose *pose, rigcal_real first_sse,
                     int32_t view, int32_t candidate);

/* rig_from_placement from that and cam_from_rig: T = C^-1 V, both poses' errors together.
 * The camera is a claim of its own, whose pivot is in the rig; exact where it is 0. Without
 * `with_camera` only the view's error is in it. */
void rc_claim_place(rc_claim *placement, const rc_claim *view, const rc_claim *camera,
                    int with_camera);

/* b_from_a from two claims about one thing: b_from_x and a_from_x, both pivots 0. */
void rc_claim_between(rc_claim *b_from_a, const rc_claim *b, const rc_claim *a);

/* Squared distance of two claims of one transform in units of what both leave open, for
 * noise of 1 px [px^2]: chi squared of 6 times sigma^2, if both are right. */
rigcal_real rc_claims_apart(const rc_claim *p, const rc_claim *q);

/* What the other claims of a placement make of one of them: each view costs that of its
 * candidates which is nearest, at most `limit` [px^2]; it agrees if that is less. */
typedef struct {
    rigcal_real cost;   /* of all views */
    rigcal_real spread; /* of the claim: its variance of rotation. Ties go to the least */
    int32_t agree;      /* views that do, its own included */
    int32_t n;          /* views */
} rc_support;

/* Claims are in the order of their views, those of one view one after the other. choice:
 * NULL, or of each view by its number: 0 or 1, the candidate that agrees, or 2: none.
 * Compares at most n claims. */
void rc_choose_support(rc_support *support, uint8_t choice[], const rc_claim claims[],
                       size_t n, size_t which, rigcal_real limit);

/* Whether that is better: more agree, or at less cost. */
int rc_choose_is_better(const rc_support *support, const rc_support *than);

/* One placement: of its n >= 1 claims (rc_claim_place) the one that the others support
 * best. Returns its index; support and choice as above. Limit: 30 sigma^2 tau^2, or
 * whatever stands for sigma^2 tau^2. O(n^2). */
size_t rc_choose_place(rc_support *support, uint8_t choice[], const rc_claim claims[],
                       size_t n, rigcal_real limit);

#endif /* RC_CHOOSE_H */
