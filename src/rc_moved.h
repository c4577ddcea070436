/* rc_moved.h - whether a camera moved, at any placement (FAULTS in EQUATIONS.md).
 *
 * A camera that stood otherwise from a placement on shares with the cameras what the
 * placements from there on add to S. So those are summed up from the last placement
 * backwards, and each camera is tested at each of them. */
#ifndef RC_MOVED_H
#define RC_MOVED_H

#include "rc_columns.h"

/* The best of a camera: its gain, 0 if there is none yet; where; how many were tried; and
 * of its six parameters theta, its variance for noise of 1 px, and what a unit of each does
 * to the cameras. */
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

/* Takes memory for what comes below, after that of the columns. */
void rc_moved_lay_out(rigcal_moves *moves, const rigcal_columns *columns, rc_pool *pool);

/* Whether a camera saw the placement. */
int rc_moved_saw(const rigcal_moves *moves, const rigcal_columns *columns, size_t camera);

/* Begins; the columns have been laid out. */
void rc_moved_begin(rigcal_moves *moves, const rigcal_columns *columns);

/* A view of a camera, the next of the placement, by the camera: see rc_border_view. */
void rc_moved_view(rigcal_moves *moves, const rc_border *border, size_t camera,
                   const rigcal_real g[6], const rigcal_real H[21]);

/* The same of its clock, if that is free. */
void rc_moved_clock(const rigcal_moves *moves, const rigcal_columns *columns,
                    const rc_evidence *view, const rc_chain *chain, size_t camera);

/* The placement has been eliminated from the border. */
void rc_moved_eliminate(rigcal_moves *moves, const rigcal_columns *columns);

/* Whether the camera of a view of the placement moved just before it, S_inverse packed:
 * tests it, and keeps the best. column: of each camera, its first unknown; 12 border->n
 * numbers of room. O(n_cameras^2) */
void rc_moved_test(rigcal_moves *moves, const rigcal_columns *columns,
                   const rigcal_real S_inverse[], const rigcal_real column[], size_t camera,
                   size_t placement, rigcal_real room[]);

#endif /* RC_MOVED_H */
