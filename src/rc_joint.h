/* rc_joint.h - the joint covariance of cameras, and of what depends on them (RIG in
 * EQUATIONS.md). S is packed. Its unknowns are (w, dt) of each camera that is not held. */
#ifndef RC_JOINT_H
#define RC_JOINT_H

#include "rc_transform.h"

/* How 6 numbers depend on cameras: d = sum of W_i^T d_i. Each camera has W, 36 numbers row
 * by row, and its first unknown. The latter is below 0 if the camera is held or does not
 * count. */
typedef struct {
    const rigcal_real *S;
    rigcal_real *W, *at;
    size_t count;
} rc_leverage;

/* Functions that add the errors of the intrinsics to covariances, if rig->considered is
 * set. The layer `consider` fills them in. They add to the covariance of a camera, of a
 * pair, and to S, packed. `placement` computes what it adds to a placement as a matrix of
 * its own. */
struct rigcal_considering {
    void (*camera)(rigcal_real Sigma[36], const rigcal_rig *rig, size_t camera);
    void (*pair)(rigcal_real Sigma[36], const rigcal_transform *b_from_a,
                 const rigcal_rig *rig, size_t a, size_t b);
    void (*joint)(rigcal_real S[], const rigcal_rig *rig);
    rigcal_status (*placement)(rigcal_real Sigma[36], const rigcal_rig *rig, size_t first,
                               size_t count, size_t placement);
};

/* out += A B, or A^T B if is_transposed. 6 x 6, row by row. */
void rc_mat6_add_product(rigcal_real out[36], const rigcal_real A[36],
                         const rigcal_real B[36], int is_transposed);

/* The covariance of the two cameras whose unknowns begin at a and b, row by row. It is 0 if
 * a or b is below 0. */
void rc_joint_block(rigcal_real out[36], const rigcal_real S[], rigcal_real a,
                    rigcal_real b);

/* Z = sum over j of Sigma_ij W_j: the covariance between camera i and the 6 numbers. */
void rc_joint_across(rigcal_real Z[36], const rc_leverage *on, size_t i);

/* Sigma = sum over i and j of W_i^T Sigma_ij W_j: the covariance of the 6 numbers. */
void rc_joint_spread(rigcal_real Sigma[36], const rc_leverage *on);

/* b_from_a and `scale` times its covariance, cross terms included. a and b are the first
 * unknowns of the cameras. */
void rc_joint_pair(rigcal_transform *b_from_a, rigcal_real Sigma[36],
                   const rigcal_transform *a_from_rig, const rigcal_transform *b_from_rig,
                   const rigcal_real S[], rigcal_real a, rigcal_real b, rigcal_real scale);

/* W of both cameras: how b_from_a depends on them. */
void rc_joint_steps_of_pair(rigcal_real W[72], const rigcal_transform *b_from_a,
                            const rigcal_transform *a_from_rig);

/* Scales the lower triangle and mirrors it to the upper one. */
void rc_mat6_make_symmetric(rigcal_real M[36], rigcal_real scale);

#endif /* RC_JOINT_H */
