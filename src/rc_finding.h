/* rc_finding.h - turns one step of a fault into its numbers and the verdict (FAULTS in
 * EQUATIONS.md, H6 to H9). */
#ifndef RC_FINDING_H
#define RC_FINDING_H

#include "rc_chance.h"

/* Sums of squares [px^2] of all views: where the rig is, and each view at its own pose. */
typedef struct {
    rigcal_real sum, own, n_measured; /* n_measured: 2 for each point */
    rigcal_real freedom, freedom_between, freedom_within;
} rc_common;

/* One Newton step of k parameters of a fault. */
typedef struct {
    size_t k, tries;
    const rigcal_real *theta, *variance; /* k numbers each; variance for noise of 1 px */
    const rigcal_real *turn, *shift;     /* k: what one unit does to a camera at most */
    rigcal_real gain, own_gain;          /* decreases of sum and of own */
} rc_one_step;

rigcal_real rc_F_of(const rc_common *common, rigcal_real gain, rigcal_real own_gain,
                    rigcal_real k);

/* Whether this F is significant at 0.001. */
int rc_F_disagrees(const rc_common *common, rigcal_real F, rigcal_real k);

/* Fills in all numbers of a fault that the views show. */
void rc_finding_of(rigcal_fault *fault, const rc_common *common, const rc_one_step *step);

/* Inserts a fault into a list of *n faults, sorted with the best first. The list can hold
 * `capacity` faults. */
void rc_finding_rank(rigcal_fault faults[], int32_t *n, size_t capacity,
                     const rigcal_fault *fault);

/* Sums over neighbouring residuals, and over residuals along the motion. */
typedef struct {
    rigcal_real n, product, expected, expected2; /* over pairs of neighbours; see
                                                    rc_evidence.h */
    rigcal_real along, disagreement, speed2;
} rc_residues;

/* Sets the numbers of pattern (H12) and of motion (H14). */
void rc_finding_residues(rigcal_faults *found, const rc_residues *residues,
                         const rc_common *common);

/* Sets the verdict, its bits, n_alike and explained. All faults must be ranked before. */
void rc_finding_judge(rigcal_faults *found, const rigcal_fault faults[],
                      const rc_common *common);

#endif /* RC_FINDING_H */
