/* rc_edge.h - a border of a band (EQUATIONS.md MATCH): its pixel over a place of the line.
 * A place of the line is p = (along, across) in the basis (ray, towards) of the band. A
 * height over it is a tangent, along the normal of the plane of the line. */
#ifndef RC_EDGE_H
#define RC_EDGE_H

#include "rc_band.h"

/* Takes a checked band. Returns 0 if it has no two borders (M6). */
int rc_edge_begin(rigcal_edge *edge, const rigcal_band *band);

/* Begins the border above the line (side 0) or below it (side 1), near p. Side 0 comes
 * first. Returns 0 if the lens does not see the line at p. */
int rc_edge_begin_side(rigcal_edge *edge, int side, const rigcal_real p[2]);

/* Finds the pixel of the border over p, and J = d(u, v) / dm there, 2 x 3. p is near the
 * place found last. It writes edge->height. OK; ERR_NO_RAY, and then the edge stays as it
 * was: the lens does not see the line at p. */
rigcal_status rc_edge_find(rigcal_real uv[2], rigcal_real J[6], rigcal_edge *edge,
                           const rigcal_real p[2]);

/* The pixel at this height over p. OK; ERR_NO_RAY: the lens does not see it. */
rigcal_status rc_edge_pixel(rigcal_real uv[2], const rigcal_edge *edge,
                            const rigcal_real p[2], rigcal_real height);

#endif /* RC_EDGE_H */
