/* rc_outline.h - the outline of a region of an image, and the spans of its rows. */
#ifndef RC_OUTLINE_H
#define RC_OUTLINE_H

#include "rc_real.h"

/* An outline without arcs, in an image of so many rows. */
void rc_outline_begin(rigcal_outline *outline, int32_t height);

/* Adds the curve through five nodes, even in its parameter; the first is the last node of
 * the curve before it, to the bit. The outline has to come back to where it began. */
void rc_outline_add(rigcal_outline *outline, const rigcal_real u[RIGCAL_SPANS_NODES],
                    const rigcal_real v[RIGCAL_SPANS_NODES]);

/* Sorts the arcs: then rows can be asked for. */
void rc_outline_close(rigcal_outline *outline);

/* The first row that an arc crosses, and the last one. */
int32_t rc_outline_rows(int32_t *last, const rigcal_outline *outline);

/* The spans of a row, 0 .. height - 1, within the columns 0 .. width - 1: their number.
 * Rows that rise are cheap. Of
 * one row after the other, rc_outline_stretch is the cheaper. */
size_t rc_outline_row(rigcal_span spans[RIGCAL_SPANS_ROW], rigcal_outline *outline,
                      int32_t row, int32_t width);

/* The spans of *row and of the rows after it, to `last` at most, as long as there is `room`
 * and the same two arcs are crossed: their number. *row is then the next. For one row room
 * must be RIGCAL_SPANS_ROW. */
size_t rc_outline_stretch(rigcal_span spans[], size_t room, rigcal_outline *outline,
                          int32_t *row, int32_t last, int32_t width);

#endif /* RC_OUTLINE_H */
