/* rc_choose.h - finds the pose of a view that the other views support (CHOICE in
 * EQUATIONS.md).
 *
 * A claim is a transform with its covariance. One view claims where a placement is. Two
 * views claim where one camera is from the other. Right claims agree; wrong ones do not
 * repeat. */
#ifndef RC_CHOOSE_H
#define RC_CHOOSE_H

#include "rc_views.h"

/* ---- constants ----------------------------------------------------------- */

/* sigma^2 tau^2: limit of the squared distance of two right claims. It is chi squared with
 * 6 degrees of freedom, which exceeds 30 once in 25000. */
#define RC_CHOOSE_LIMIT RC(30)

/* ---- claims -------------------------------------------------------------- */

typedef struct {
    rigcal_transform b_from_a;
    rigcal_real Sigma[21]; /* of the turn w and of the shift of `pivot` as seen in b, for
                              noise of 1 px */
    rigcal_real pivot[3];  /* in frame a: where the target is */
    rigcal_real extra;     /* px^2: sum of squares, less that of the view's first pose */
    rigcal_real view;      /* the view's number; -1: there is no claim */
    rigcal_real candidate; /* 0 or 1: which pose of the view */
} rc_claim;

/* Reals that one claim takes. Reals that the claims of a placement of n_views views take at
 * most. */
#define RC_CLAIM_REALS 39
#define RC_CLAIMS_WORK(n_views) (2 * RC_CLAIM_REALS * (size_t)(n_views))

/* The claim cam_from_target of one pose of a view. Returns 0 if the pose's information
 * matrix is not positive definite. */
int rc_claim_of_view(rc_claim *claim, const rigcal_view_pose *pose, rigcal_real first_sse,
                     int32_t view, int32_t candidate);

/* The claim rig_from_placement = C^-1 V, of a view's claim V and a camera's claim C. The
 * camera's pivot is a point of the rig. With `with_camera` the covariance contains the
 * errors of both, otherwise that of the view alone. A camera whose Sigma is 0 is exact. */
void rc_claim_place(rc_claim *placement, const rc_claim *view, const rc_claim *camera,
                    int with_camera);

/* The claim b_from_a from two claims about one placement x: b_from_x and a_from_x. Both
 * pivots must be 0. */
void rc_claim_between(rc_claim *b_from_a, const rc_claim *b, const rc_claim *a);

/* Squared distance of two claims of one transform, weighed by the sum of their covariances,
 * for noise of 1 px [px^2]. If both are right it is sigma^2 times chi squared with 6
 * degrees of freedom. */
rigcal_real rc_claims_apart(const rc_claim *p, const rc_claim *q);

/* How far the other claims of a placement support one of them. Each view costs as much as
 * its nearest candidate, at most `limit` [px^2]. A view agrees if its cost is below the
 * limit. */
typedef struct {
    rigcal_real cost;   /* sum over all views */
    rigcal_real spread; /* the claim's variance of rotation; the least one wins ties */
    int32_t agree;      /* number of views that agree, the claim's own included */
    int32_t n;          /* number of views */
} rc_support;

/* Claims must be in the order of their views; the two of a view stand side by side. choice
 * may be NULL. Otherwise each view's entry becomes 0 or 1, the candidate that agrees, or 2
 * if none does. Compares at most n claims. */
void rc_choose_support(rc_support *support, uint8_t choice[], const rc_claim claims[],
                       size_t n, size_t which, rigcal_real limit);

/* Whether a support is better than another: more views agree or, if as many agree, it costs
 * less. */
int rc_choose_is_better(const rc_support *support, const rc_support *than);

/* The index of the claim that the others support best, among the n >= 1 claims of one
 * placement (rc_claim_place). support and choice are as above. limit is 30 sigma^2 tau^2,
 * or 30 times whatever stands for sigma^2 tau^2. O(n^2). */
size_t rc_choose_place(rc_support *support, uint8_t choice[], const rc_claim claims[],
                       size_t n, rigcal_real limit);

#endif /* RC_CHOOSE_H */
