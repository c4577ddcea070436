/* rc_finding.h - from one step of a fault to its numbers, and the verdict (FAULTS in
 * EQUATIONS.md, H6 to H9). */
#ifndef RC_FINDING_H
#define RC_FINDING_H

#include "rc_chance.h"

/* What a rig's views have in common: sums of squares of all, and of each view by itself. */
typedef struct {
    rigcal_real sum, own, n_measured; /* 2 for each point */
    rigcal_real freedom, freedom_between, freedom_within;
} rc_common;

/* One step of k parameters. */
typedef struct {
    size_t k, tries;
    const rigcal_real *theta, *variance; /* k; of noise of 1 px */
    const rigcal_real *turn, *shift;     /* k: what one unit does to a camera, at most */
    rigcal_real gain, own_gain;          /* of the rig; of each view by itself */
} rc_one_step;

rigcal_real rc_F_of(const rc_common *common, rigcal_real gain, rigcal_real own_gain,
                    rigcal_real k);

/* Whether that F is significant at 0.001. */
int rc_F_disagrees(const rc_common *common, rigcal_real F, rigcal_real k);

/* Fills in all numbers of a fault that is seen. */
void rc_finding_of(rigcal_fault *fault, const rc_common *common, const rc_one_step *step);

/* Puts a fault into its place in a list of *n faults, the best first; `capacity` is the
 * most that the list can hold. */
void rc_finding_rank(rigcal_fault faults[], int32_t *n, size_t capacity,
                     const rigcal_fault *fault);

/* Sums over neighbouring residuals and along the motion. */
typedef struct {
    rigcal_real n, product, expected, expected2; /* pairs of points; see rc_evidence.h */
    rigcal_real along, disagreement, speed2;
} rc_residues;

/* Pattern and motion (H12), (H14). */
void rc_finding_residues(rigcal_faults *found, const rc_residues *residues,
                         const rc_common *common);

/* The verdict, the bits that go with it, n_alike and explained, once all are ranked. */
void rc_finding_judge(rigcal_faults *found, const rigcal_fault faults[],
                      const rc_common *common);

#endif /* RC_FINDING_H */
