#include "rc_moved.h"

/* ---- constants ----------------------------------------------------------- */

/* part of the information of the views from there on: with less of it left when all else is
 * free, a camera's move is not to be told from a rig that stands otherwise. */
#define RANK_TOL RC_TOL(1e-10, 1e-5)

static rigcal_real dot6(const rigcal_real a[6], const rigcal_real b[6])
{
    return rc_vec3_dot(a, b) + rc_vec3_dot(&a[3], &b[3]);
}

/* ---- sums ------------------------------------------------------------------ */

void rc_moved_lay_out(rigcal_moves *m, const rigcal_columns *s, rc_pool *pool)
{
    const size_t n = s->rig->n_cameras;
    m->so_far = rc_pool_take(pool, n);
    m->camera = rc_pool_take(pool, n);
    if (rc_columns_has(s, RIGCAL_FAULT_MOVED)) {
        m->S = rc_pool_take(pool, rc_packed_size(6 * n));
        m->g = rc_pool_take(pool, 6 * n);
        m->best = rc_pool_take(pool, RC_MOVED_SIZE * n);
        m->clocks = rc_pool_take(pool, s->per_clock * 6 * n * n);
    }
}

void rc_moved_begin(rigcal_moves *m, const rigcal_columns *s)
{
    const size_t n_cameras = s->rig->n_cameras;
    rc_clear(m->clocks, s->per_clock * n_cameras * 6 * n_cameras);
    rc_clear(m->S, 6 * n_cameras * (6 * n_cameras + 1) / 2);
    rc_clear(m->g, 6 * n_cameras);
    rc_clear(m->best, RC_MOVED_SIZE * n_cameras);
    rc_clear(m->so_far, n_cameras);
}

void rc_moved_view(rigcal_moves *m, const rc_border *b, size_t camera,
                   const rigcal_real g[6], const rigcal_real H[21])
{
    rigcal_real full[36];
    m->camera[b->count - 1] = (rigcal_real)(int32_t)camera;
    m->so_far[camera] += 1;
    rc_sym6_unpack(full, H);
    for (size_t i = 0; i < 6; i++) {
        rigcal_real *const row = &m->S[rc_packed_at(6 * camera + i, 6 * camera)];
        for (size_t j = 0; j <= i; j++) {
            row[j] += full[6 * i + j];
        }
        m->g[6 * camera + i] += g[i];
    }
}

/* Adds to what a free clock, and its drift, share with unknown i of all cameras. */
static void add_to_clock(const rigcal_moves *m, const rigcal_columns *s, size_t camera,
                         size_t i, rigcal_real x)
{
    const size_t n = 6 * s->rig->n_cameras;
    if (rc_columns_is_free(s, camera)) {
        m->clocks[n * camera + i] += x;
        if (s->per_clock > 1) {
            m->clocks[n * (s->rig->n_cameras + camera) + i] += s->since[camera] * x;
        }
    }
}

void rc_moved_clock(const rigcal_moves *m, const rigcal_columns *s, const rc_evidence *v,
                    const rc_chain *chain, size_t camera)
{
    const rigcal_real *const E = v->E[RC_BY_CLOCK];
    rigcal_real A[6];
    rc_vec3_cross(A, chain->lever, &E[3]);
    rc_vec3_add(A, E);
    rc_vec3_copy(&A[3], &E[3]);
    for (size_t k = 0; k < 6; k++) {
        add_to_clock(m, s, camera, 6 * camera + k, v->left * A[k]);
    }
}

void rc_moved_eliminate(rigcal_moves *m, const rigcal_columns *s)
{
    const rc_border *const b = &s->border;
    for (size_t slot = 0; s->per_clock > 0 && slot < 6 * b->count; slot++) {
        const size_t i = 6 * (size_t)m->camera[slot / 6] + slot % 6;
        for (size_t c = 0; c < s->rig->n_cameras; c++) {
            add_to_clock(m, s, c, i, -dot6(&b->Z[6 * c], &b->W[6 * slot]));
        }
    }
    for (size_t slot = 0; slot < 6 * b->count; slot++) {
        const rigcal_real *const Y = &b->W[6 * slot];
        const size_t i = 6 * (size_t)m->camera[slot / 6] + slot % 6;
        m->g[i] -= dot6(Y, b->gp);
        for (size_t other = 0; other < 6 * b->count; other++) {
            const size_t j = 6 * (size_t)m->camera[other / 6] + other % 6;
            if (j <= i) {
                m->S[rc_packed_at(i, j)] -= dot6(Y, &b->W[6 * other]);
            }
        }
    }
}

int rc_moved_saw(const rigcal_moves *m, const rigcal_columns *s, size_t camera)
{
    for (size_t slot = 0; slot < s->border.count; slot++) {
        if ((size_t)m->camera[slot] == camera) {
            return 1;
        }
    }
    return 0;
}

/* ---- the test -------------------------------------------------------------- */

static rigcal_real S_at(const rigcal_moves *m, size_t i, size_t j)
{
    return m->S[(i >= j) ? rc_packed_at(i, j) : rc_packed_at(j, i)];
}

/* T of the six parameters: the columns of S that are the camera's, by the unknowns. */
static void take_columns(rigcal_real T[], const rigcal_columns *s, const rigcal_moves *m,
                         const rigcal_real column[], size_t camera)
{
    const size_t n = s->border.n, n_cameras = s->rig->n_cameras;
    for (size_t at = s->n; at < n; at++) {
        for (size_t k = 0; k < 6; k++) {
            T[k * n + at] = m->clocks[6 * n_cameras * (at - s->n) + 6 * camera + k];
        }
    }
    for (size_t c = 0; c < n_cameras; c++) {
        for (size_t k = 0; column[c] >= 0 && k < 36; k++) {
            T[(k / 6) * n + (size_t)column[c] + k % 6] =
                S_at(m, 6 * c + k % 6, 6 * camera + k / 6);
        }
    }
}

void rc_moved_test(rigcal_moves *m, const rigcal_columns *s, const rigcal_real S_inverse[],
                   const rigcal_real column[], size_t camera, size_t placement,
                   rigcal_real room[])
{
    const rc_border *const b = &s->border;
    rc_border of_six = {0};
    rigcal_real best[RC_MOVED_SIZE], I[21];
    rigcal_real *const kept = &m->best[RC_MOVED_SIZE * camera], *const G = room + 6 * b->n;
    const size_t from = 6 * camera;
    of_six.n = b->n;
    of_six.T = room;
    take_columns(room, s, m, column, camera);
    for (size_t j = 0; j < 6; j++) {
        rc_border_effect(&G[b->n * j], &of_six, S_inverse, j);
        rc_columns_most(&best[RC_MOVED_TURN + j], &best[RC_MOVED_SHIFT + j], &G[b->n * j],
                        s->n);
        for (size_t i = j; i < 6; i++) {
            rigcal_real *const at = &I[rc_packed_at(i, j)];
            *at = S_at(m, from + i, from + j);
            for (size_t k = 0; k < b->n; k++) {
                *at -= room[b->n * i + k] * G[b->n * j + k];
            }
        }
        best[RC_MOVED_THETA + j] = m->g[from + j];
    }
    for (size_t i = 0; i < 6; i++) {
        const rigcal_real raw = S_at(m, from + i, from + i);
        if (!(raw > 0) || !rc_packed_factor_row(I, i, RANK_TOL * raw)) {
            return;
        }
    }
    rc_columns_solve(&best[RC_MOVED_GAIN], &best[RC_MOVED_THETA], &best[RC_MOVED_VARIANCE],
                     I, 6);
    best[RC_MOVED_AT] = (rigcal_real)(int32_t)placement;
    best[RC_MOVED_TRIES] = kept[RC_MOVED_TRIES] += 1;
    if (best[RC_MOVED_GAIN] > kept[RC_MOVED_GAIN]) {
        for (size_t k = 0; k < RC_MOVED_SIZE; k++) {
            kept[k] = best[k];
        }
    }
}
