/* rc_moved.h - tests whether a camera moved, at each placement (FAULTS in EQUATIONS.md).
 *
 * If a camera moved before a placement, its new pose shares with the cameras what the
 * placements from there on add to S. So these are summed from the last placement backwards,
 * and each camera is tested at each of them. */
#ifndef RC_MOVED_H
#define RC_MOVED_H

#include "rc_columns.h"

/* The best test of a camera: its gain, 0 if there is none yet; its placement; the number of
 * tests. Then theta of the six parameters, their variance for noise of 1 px, and what one
 * unit of each does to the cameras. */
enum {
    RC_MOVED_GAIN = 0,
    RC_MOVED_AT = 1,
    RC_MOVED_TRIES = 2,
    RC_MOVED_THETA = 3,
    RC_MOVED_VARIANCE = 9,
    RC_MOVED_TURN = 15,
    RC_MOVED_SHIFT = 21,
    RC_MOVED_SIZE = 27
};

/* Takes memory for the sums, after that of the columns. */
void rc_moved_lay_out(rigcal_moves *moves, const rigcal_columns *columns, rc_pool *pool);

/* Whether a camera saw the placement. */
int rc_moved_saw(const rigcal_moves *moves, const rigcal_columns *columns, size_t camera);

/* Begins a pass. The columns must have been laid out. */
void rc_moved_begin(rigcal_moves *moves, const rigcal_columns *columns);

/* Adds a view of a camera, the next view of the placement. g and H are by the camera: see
 * rc_border_view. */
void rc_moved_view(rigcal_moves *moves, const rc_border *border, size_t camera,
                   const rigcal_real g[6], const rigcal_real H[21]);

/* Adds the information of the view on the camera's clock, if that is free. */
void rc_moved_clock(const rigcal_moves *moves, const rigcal_columns *columns,
                    const rc_evidence *view, const rc_chain *chain, size_t camera);

/* Eliminates the placement, after rc_border_eliminate. */
void rc_moved_eliminate(rigcal_moves *moves, const rigcal_columns *columns);

/* Tests whether the camera, which saw the placement, moved just before it, and keeps the
 * best test. S_inverse is packed. column has the first unknown of each camera. room has 12
 * border->n reals. O(n_cameras^2) */
void rc_moved_test(rigcal_moves *moves, const rigcal_columns *columns,
                   const rigcal_real S_inverse[], const rigcal_real column[], size_t camera,
                   size_t placement, rigcal_real room[]);

#endif /* RC_MOVED_H */
