/* rc_evidence.h - what one view tells of what may be wrong with its camera, its clock and
 * its board (FAULTS in EQUATIONS.md, H4). */
#ifndef RC_EVIDENCE_H
#define RC_EVIDENCE_H

#include "rc_chain.h"
#include "rc_intrinsics.h"
#include "rc_points.h"

/* The parameters of a view, in their order. The last three are of the board. */
enum {
    RC_BY_CLOCK,
    RC_BY_DRIFT,
    RC_BY_SHUTTER,
    RC_BY_INTRINSICS, /* RC_INTRINSICS of them, in the order of rc_intrinsics.h */
    RC_BY_BENT = RC_BY_INTRINSICS + RC_INTRINSICS, /* and the next */
    RC_BY_STRETCHED = RC_BY_BENT + 2,
    RC_COLUMNS,
    RC_OF_CAMERA = RC_BY_BENT
};

/* Two parameters that are tested together: the principal point, k1 and k2, the bend. */
enum { RC_PAIRS = 3 };
extern const uint8_t rc_pair_first[RC_PAIRS];

/* Where the points are, and which of them count. */
typedef struct {
    rigcal_real middle[2], half[2]; /* of the points' X and Y, over all views */
    rigcal_real limit2;             /* px^2: of the squared error over sigma_i^2; 0: none */
    const rigcal_real *reference;   /* 3, of the camera: see below */
} rc_scan;

/* A principal point nearly acts as a turn of the camera, and a focal length as a shift
 * along its axis. The columns of these are taken against that turn and shift, which keeps
 * the digits; the camera's own pose takes it up. Of a camera: turns by 1 px of cx and of cy
 * [rad], and the shift by all of f [length]; zeros: none is taken off.
 *
 * (w, v): a turn about the camera's centre, and a shift, by a unit of a parameter. 0: it
 * has none. */
int rc_evidence_reference(rigcal_real w[3], rigcal_real v[3],
                          const rigcal_real reference[3], size_t parameter);

/* Sums over the points of a view. E = J^T D by column; Q = D^T D and q = D^T e of columns
 * alone; `pairs` is Q across the two of a pair. */
typedef struct {
    size_t n; /* points that count */
    rigcal_real sum, g[6], H[21];
    rigcal_real E[RC_COLUMNS][6], Q[RC_COLUMNS], q[RC_COLUMNS], pairs[RC_PAIRS];

    /* Over neighbours i, j: sum of e_i . e_j; of J_i^T e_j + J_j^T e_i; of J_i^T J_j. */
    rigcal_real product, mixed[6], M[36];
    size_t n_neighbours;

    rigcal_real m[6];        /* its motion */
    rigcal_real stamp, left; /* (H11): 1 / s, and the part of m^T H m that is left */
} rc_evidence;

/* All of it, of a view whose chain this is, with its motion m by cam_from_target in a unit
 * of time, and the time `since` the middle of the recording. OK, ERR_BEHIND, ERR_NO_RAY. */
rigcal_status rc_evidence_of(rc_evidence *out, const rc_scan *scan,
                             const rigcal_rig_view *view, const rc_chain *chain,
                             const rigcal_real m[6], rigcal_real since);

/* (H11): ratio2 is (noise of a pixel / noise of the view's stamp)^2; 0: the stamp is exact.
 * The sums stay: a view whose own pose is free has no use for its stamp. */
void rc_evidence_stamp(rc_evidence *v, rigcal_real ratio2);

/* E, Q and q of a parameter with the noise of the stamp out; `along` is m^T E before. */
void rc_evidence_weighed(rigcal_real E[6], rigcal_real *Q, rigcal_real *q,
                         rigcal_real *along, const rc_evidence *v, size_t parameter);

/* The same where the view's own pose is free: sum, E, Q, q and pairs are what is left, and
 * d is how far that pose is. g and H stay. 0: H is not positive definite to rounding. */
int rc_evidence_alone(rc_evidence *v, rigcal_real d[6]);

/* Sum over neighbours of r_i . r_j, the residuals without the view's own pose d; *expected
 * is what white noise of variance 1 leaves of it. */
rigcal_real rc_evidence_pattern(rigcal_real *expected, const rc_evidence *v,
                                const rigcal_real d[6]);

#endif /* RC_EVIDENCE_H */
