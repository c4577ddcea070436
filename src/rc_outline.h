/* rc_outline.h - the outline of a region of an image, and the spans of its rows. */
#ifndef RC_OUTLINE_H
#define RC_OUTLINE_H

#include "rc_real.h"

/* Begins an outline without arcs, in an image of `height` rows. */
void rc_outline_begin(rigcal_outline *outline, int32_t height);

/* Adds the curve through five nodes, at even steps of its parameter. The first node must be
 * the last one of the curve before, to the bit. The outline must end where it began. */
void rc_outline_add(rigcal_outline *outline, const rigcal_real u[RIGCAL_SPANS_NODES],
                    const rigcal_real v[RIGCAL_SPANS_NODES]);

/* Sorts the arcs. Rows can be asked for after it. */
void rc_outline_close(rigcal_outline *outline);

/* The first row that an arc crosses, and the last one. */
int32_t rc_outline_rows(int32_t *last, const rigcal_outline *outline);

/* Finds the spans of a row, 0 .. height - 1, within the columns 0 .. width - 1. Returns
 * their number. It is cheap if each row is below the last one. For consecutive rows
 * rc_outline_stretch is cheaper. */
size_t rc_outline_row(rigcal_span spans[RIGCAL_SPANS_ROW], rigcal_outline *outline,
                      int32_t row, int32_t width);

/* Finds the spans of *row and the rows after it, up to `last`. It goes on while there is
 * `room` and the same two arcs are crossed. Returns the number of spans; *row is then the
 * next row. room must be at least RIGCAL_SPANS_ROW. */
size_t rc_outline_stretch(rigcal_span spans[], size_t room, rigcal_outline *outline,
                          int32_t *row, int32_t last, int32_t width);

#endif /* RC_OUTLINE_H */
