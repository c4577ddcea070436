/* rc_evidence.h - the evidence of one view for faults of its camera, its clock and its
 * board (FAULTS in EQUATIONS.md, H4). */
#ifndef RC_EVIDENCE_H
#define RC_EVIDENCE_H

#include "rc_chain.h"
#include "rc_intrinsics.h"
#include "rc_points.h"

/* The parameters of a view. The last three belong to the board. */
enum {
    RC_BY_CLOCK,
    RC_BY_DRIFT,
    RC_BY_SHUTTER,
    RC_BY_INTRINSICS, /* RC_INTRINSICS of them, in the order of rc_intrinsics.h */
    RC_BY_BENT = RC_BY_INTRINSICS + RC_INTRINSICS, /* two of them */
    RC_BY_STRETCHED = RC_BY_BENT + 2,
    RC_COLUMNS,
    RC_OF_CAMERA = RC_BY_BENT
};

/* Pairs of parameters that are tested together: the principal point, k1 and k2, the bend.
 * rc_pair_first has the first parameter of each pair. */
enum { RC_PAIRS = 3 };
extern const uint8_t rc_pair_first[RC_PAIRS];

/* How far the points reach, and which of them count. */
typedef struct {
    rigcal_real middle[2], half[2]; /* middle and half extent of the points' X and Y, over
                                       all views */
    rigcal_real limit2;             /* px^2: limit of the squared error over sigma_i^2; 0:
                                       none */
    const rigcal_real *reference;   /* 3, of the camera: see below */
} rc_scan;

/* A change of the principal point acts nearly like a turn of the camera, and one of the
 * focal length like a shift along its axis. This turn or shift is subtracted from their
 * columns, so that no digits are lost. The camera's own pose takes it up. reference has, of
 * a camera, the turns by 1 px of cx and of cy [rad], and the shift by all of f [length].
 * Zeros: nothing is subtracted.
 *
 * Writes the turn w about the camera's centre, and the shift v, that one unit of a
 * parameter has subtracted. Returns 0 if it has none. */
int rc_evidence_reference(rigcal_real w[3], rigcal_real v[3],
                          const rigcal_real reference[3], size_t parameter);

/* Sums over the points of a view. E = J^T D of each column; Q = D^T D and q = D^T e of each
 * column alone; `pairs` is Q across the two columns of a pair. */
typedef struct {
    size_t n; /* number of points that count */
    rigcal_real sum, g[6], H[21];
    rigcal_real E[RC_COLUMNS][6], Q[RC_COLUMNS], q[RC_COLUMNS], pairs[RC_PAIRS];

    /* Over neighbours i, j: sums of e_i . e_j, of J_i^T e_j + J_j^T e_i, and of J_i^T
     * J_j. */
    rigcal_real product, mixed[6], M[36];
    size_t n_neighbours;

    rigcal_real m[6];        /* motion of the view */
    rigcal_real stamp, left; /* (H11): 1 / s, and the part of m^T H m that is left */
} rc_evidence;

/* Computes all of it for a view with this chain. m is the motion by cam_from_target in a
 * unit of time, `since` the time after the middle of the recording. OK, ERR_BEHIND,
 * ERR_NO_RAY. */
rigcal_status rc_evidence_of(rc_evidence *out, const rc_scan *scan,
                             const rigcal_rig_view *view, const rc_chain *chain,
                             const rigcal_real m[6], rigcal_real since);

/* (H11): sets the noise of the stamp. ratio2 is (noise of a pixel / noise of the view's
 * stamp)^2; 0: the stamp is exact. The sums stay: a view whose own pose is free does not
 * need its stamp. */
void rc_evidence_stamp(rc_evidence *v, rigcal_real ratio2);

/* E, Q and q of a parameter, after the noise of the stamp was eliminated. *along is m^T E
 * before that. */
void rc_evidence_weighed(rigcal_real E[6], rigcal_real *Q, rigcal_real *q,
                         rigcal_real *along, const rc_evidence *v, size_t parameter);

/* Frees the view's own pose: sum, E, Q, q and pairs become what is left, and d is how far
 * this pose is off. g and H stay. Returns 0 if H is not positive definite to rounding. */
int rc_evidence_alone(rc_evidence *v, rigcal_real d[6]);

/* Sum over neighbours of r_i . r_j, where r are the residuals with the view's own pose
 * free. d is this pose. *expected is what white noise of variance 1 makes of the sum. */
rigcal_real rc_evidence_pattern(rigcal_real *expected, const rc_evidence *v,
                                const rigcal_real d[6]);

#endif /* RC_EVIDENCE_H */
