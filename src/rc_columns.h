/* rc_columns.h - the parameters of the faults that one pass over the views tests, as a
 * border of the rig's equations (FAULTS in EQUATIONS.md, H5 to H8).
 *
 * The columns are the clock of each camera, then the other parameters of each camera, then
 * those of the board. */
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

/* Takes n reals of the first piece that has them. Otherwise it returns NULL, and is_enough
 * becomes 0. */
rigcal_real *rc_pool_take(rc_pool *pool, size_t n);

/* Number of elements of a packed matrix of n rows. */
inline size_t rc_packed_size(size_t n)
{
    return n * (n + 1) / 2;
}

int rc_columns_has(const rigcal_columns *columns, int32_t kind);

/* Whether each camera has its own parameters of this kind. */
int rc_is_of_camera(int32_t kind);

/* Numbers the columns of columns->kinds and takes memory for them. Z gets at least `room`
 * reals for each unknown of the rig. */
void rc_columns_lay_out(rigcal_columns *columns, rc_pool *pool, size_t room);

/* Begins a pass: sets all sums to 0. */
void rc_columns_begin(rigcal_columns *columns);

/* Whether the adjustment has this camera's clock as an unknown. rc_columns_n_free: the
 * number of such unknowns. */
int rc_columns_is_free(const rigcal_columns *columns, size_t camera);
size_t rc_columns_n_free(const rigcal_columns *columns);

/* Adds g of a camera, whose first unknown is `at`. Below 0: the camera has none. */
void rc_columns_add_gradient(rigcal_columns *columns, rigcal_real at,
                             const rigcal_real g[6]);

/* Adds a view of a camera, after rc_border_view. g is by the camera, as that leaves it. */
void rc_columns_add(rigcal_columns *columns, const rc_evidence *view, const rc_chain *chain,
                    size_t camera, rigcal_real since, const rigcal_real g[6]);

/* Adds the view with its own pose free, after rc_evidence_alone. */
void rc_columns_add_alone(rigcal_columns *columns, const rc_evidence *view, size_t camera);

/* Eliminates the placement from the columns, after rc_border_eliminate. */
void rc_columns_eliminate(rigcal_columns *columns);

/* Tests the fault of fault->kind and fault->camera. clocks may be NULL; otherwise CLOCKS
 * writes its values there. */
void rc_columns_test(rigcal_fault *fault, const rigcal_columns *columns,
                     const rc_common *common, rigcal_real clocks[]);

/* Adds x to the element of a free clock in a row, and `since` times x to the element of its
 * drift. `of` is the element of camera 0; elements are `stride` apart. */
void rc_columns_add_clock(const rigcal_columns *columns, rigcal_real of[], size_t stride,
                          size_t camera, rigcal_real x);

/* Solves theta = I^-1 u, with u in theta at first. variance becomes diag(I^-1), and gain u
 * . theta. I has k rows and is overwritten. `variance` must hold the diagonal before
 * anything was eliminated. Returns 0 if so little of it is left that the parameters cannot
 * be seen. */
int rc_columns_solve(rigcal_real *gain, rigcal_real theta[], rigcal_real variance[],
                     rigcal_real I[], size_t k);

/* Raises *turn to the largest turn, and *shift to the largest shift, of the cameras in
 * G. */
void rc_columns_most(rigcal_real *turn, rigcal_real *shift, const rigcal_real G[],
                     size_t n);

#endif /* RC_COLUMNS_H */
