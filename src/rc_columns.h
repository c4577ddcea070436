/* rc_columns.h - the parameters of the faults that are tested in one pass over the views,
 * as a border of the rig's equations (FAULTS in EQUATIONS.md, H5 to H8).
 *
 * Columns: the clock of each camera, the other parameters of each camera, those of the
 * board. */
#ifndef RC_COLUMNS_H
#define RC_COLUMNS_H

#include "rc_border.h"
#include "rc_evidence.h"
#include "rc_finding.h"
#include "rc_views.h"

/* What is left of two pieces of memory. */
typedef struct {
    rigcal_real *at[2];
    size_t left[2];
    int is_enough;
} rc_pool;

/* n reals of the first piece that has them; NULL, and not enough. */
rigcal_real *rc_pool_take(rc_pool *pool, size_t n);

/* Elements of a packed matrix of n rows. */
inline size_t rc_packed_size(size_t n)
{
    return n * (n + 1) / 2;
}

int rc_columns_has(const rigcal_columns *columns, int32_t kind);

/* Whether a kind has parameters of each camera. */
int rc_is_of_camera(int32_t kind);

/* Numbers the columns of columns->kinds, and takes memory for them; `room` reals at least
 * for Z. */
void rc_columns_lay_out(rigcal_columns *columns, rc_pool *pool, size_t room);

/* A pass begins: all sums are 0. */
void rc_columns_begin(rigcal_columns *columns);

/* Whether a clock is an unknown of the adjustment; all unknowns of clocks. */
int rc_columns_is_free(const rigcal_columns *columns, size_t camera);
size_t rc_columns_n_free(const rigcal_columns *columns);

/* What a view of a camera tells, after rc_border_view with its g and H by the camera. */
void rc_columns_add(rigcal_columns *columns, const rc_evidence *view, const rc_chain *chain,
                    size_t camera, rigcal_real since, const rigcal_real g[6]);

/* The same of the view by itself: after rc_evidence_alone. */
void rc_columns_add_alone(rigcal_columns *columns, const rc_evidence *view, size_t camera);

/* The placement has been eliminated from the border. */
void rc_columns_eliminate(rigcal_columns *columns);

/* All views have been added. */
void rc_columns_end(rigcal_columns *columns);

/* Tests a fault of fault->kind and fault->camera. clocks: NULL, or where CLOCKS go. */
void rc_columns_test(rigcal_fault *fault, const rigcal_columns *columns,
                     const rc_common *common, rigcal_real clocks[]);

/* Adds what a free clock shares to its element of a row, and `since` times that to the
 * element of its drift; `of`: the element of camera 0, `stride` from one to the next. */
void rc_columns_add_clock(const rigcal_columns *columns, rigcal_real of[], size_t stride,
                          size_t camera, rigcal_real x);

/* theta = I^-1 u in the place of u, its variance diag(I^-1), and the gain u . theta; I of k
 * rows is factored, and spent. `variance` has the diagonal before anything was eliminated.
 * 0: with so little of it left, the parameters cannot be seen. */
int rc_columns_solve(rigcal_real *gain, rigcal_real theta[], rigcal_real variance[],
                     rigcal_real I[], size_t k);

/* The longest of the turns, and of the shifts, of the cameras in G; of those so far. */
void rc_columns_most(rigcal_real *turn, rigcal_real *shift, const rigcal_real G[],
                     size_t n);

#endif /* RC_COLUMNS_H */
