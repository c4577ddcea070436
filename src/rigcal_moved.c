#include "rc_moved.h"

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

void rc_moved_clock(const rigcal_moves *m, const rigcal_columns *s, const rc_evidence *v,
                    const rc_chain *chain, size_t camera)
{
    const rigcal_real *const E = v->E[RC_BY_CLOCK];
    rigcal_real A[6];
    rc_vec3_cross(A, chain->lever, &E[3]);
    rc_vec3_add(A, E);
    rc_vec3_copy(&A[3], &E[3]);
    for (size_t k = 0; k < 6; k++) {
        rc_columns_add_clock(s, &m->clocks[6 * camera + k], 6 * s->rig->n_cameras, camera,
                             v->left * A[k]);
    }
}

/* Subtracts from S of two cameras what their views share through the placement. */
static void eliminate_pair(rigcal_moves *m, const rc_border *b, size_t view, size_t other)
{
    const size_t c = (size_t)m->camera[view], d = (size_t)m->camera[other];
    for (size_t i = 0; d <= c && i < 6; i++) {
        const rigcal_real *const Y = &b->W[36 * view + 6 * i];
        rigcal_real *const row = &m->S[rc_packed_at(6 * c + i, 6 * d)];
        for (size_t j = 0; j < ((d < c) ? 6 : i + 1); j++) {
            row[j] -= rc_vec6_dot(Y, &b->W[36 * other + 6 * j]);
        }
    }
}

void rc_moved_eliminate(rigcal_moves *m, const rigcal_columns *s)
{
    const rc_border *const b = &s->border;
    for (size_t slot = 0; slot < 6 * b->count; slot++) {
        const size_t i = 6 * (size_t)m->camera[slot / 6] + slot % 6;
        m->g[i] -= rc_vec6_dot(&b->W[6 * slot], b->gp);
        for (size_t c = 0; s->per_clock > 0 && c < s->rig->n_cameras; c++) {
            rc_columns_add_clock(s, &m->clocks[i], 6 * s->rig->n_cameras, c,
                                 -rc_vec6_dot(&b->Z[6 * c], &b->W[6 * slot]));
        }
    }
    for (size_t view = 0; view < b->count; view++) {
        for (size_t other = 0; other < b->count; other++) {
            eliminate_pair(m, b, view, other);
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

static rigcal_real at(const rigcal_real packed[], size_t i, size_t j)
{
    return packed[rc_packed_of(i, j)];
}

/* T of the six parameters: the six columns of S of the camera, one row for each unknown. */
static void take_columns(rigcal_real T[], const rigcal_columns *s, const rigcal_moves *m,
                         const rigcal_real column[], size_t camera)
{
    const size_t n_cameras = s->rig->n_cameras;
    for (size_t i = s->n; i < s->border.n; i++) {
        const rigcal_real *const row = &m->clocks[6 * (n_cameras * (i - s->n) + camera)];
        for (size_t k = 0; k < 6; k++) {
            T[6 * i + k] = row[k];
        }
    }
    for (size_t c = 0; c < n_cameras; c++) {
        for (size_t i = 0; column[c] >= 0 && i < 6; i++) {
            rigcal_real *const to = &T[6 * ((size_t)column[c] + i)];
            for (size_t k = 0; k < 6; k++) {
                to[k] = at(m->S, 6 * c + i, 6 * camera + k);
            }
        }
    }
}

/* Of six parameters: I -= T^T S^-1 T, and G = S^-1 T. */
static void reduce(rigcal_real I[21], rigcal_real G[], const rigcal_real T[], size_t n,
                   const rigcal_real S_inverse[])
{
    const rigcal_real *row = S_inverse;
    for (size_t i = 0; i < n; i++) { /* S is symmetric: each element of the triangle serves
                                        twice */
        rigcal_real sum[6] = {0}, own[6];
        for (int k = 0; k < 6; k++) {
            own[k] = T[6 * i + (size_t)k];
        }
        for (size_t j = 0; j < i; j++) {
            const rigcal_real x = row[j];
            const rigcal_real *const other = &T[6 * j];
            rigcal_real *const g = &G[6 * j];
            for (int k = 0; k < 6; k++) {
                sum[k] += x * other[k];
            }
            for (int k = 0; k < 6; k++) {
                g[k] += x * own[k];
            }
        }
        for (int k = 0; k < 6; k++) {
            G[6 * i + (size_t)k] = sum[k] + row[i] * own[k];
        }
        row += i + 1;
    }
    for (size_t i = 0; i < n; i++) {
        rigcal_real *next = I;
        for (size_t k = 0; k < 6; k++) {
            const rigcal_real x = T[6 * i + k];
            for (size_t j = 0; j <= k; j++) {
                *next++ -= x * G[6 * i + j];
            }
        }
    }
}

/* The largest turn and shift of a camera by one unit of parameter k. */
static void most(rigcal_real *best, const rigcal_real G[], size_t n, size_t k)
{
    rigcal_real d[6];
    best[RC_MOVED_TURN + k] = best[RC_MOVED_SHIFT + k] = 0;
    for (size_t i = 0; i < n; i++) {
        d[i % 6] = G[6 * i + k];
        if (i % 6 == 5) {
            rc_columns_most(&best[RC_MOVED_TURN + k], &best[RC_MOVED_SHIFT + k], d, 6);
        }
    }
}

void rc_moved_test(rigcal_moves *m, const rigcal_columns *s, const rigcal_real S_inverse[],
                   const rigcal_real column[], size_t camera, size_t placement,
                   rigcal_real room[])
{
    const size_t n = s->border.n, from = 6 * camera;
    rigcal_real best[RC_MOVED_SIZE], I[21];
    rigcal_real *const kept = &m->best[RC_MOVED_SIZE * camera], *const G = room + 6 * n;
    take_columns(room, s, m, column, camera);
    for (size_t k = 0; k < 36; k++) {
        if (k % 6 <= k / 6) {
            I[rc_packed_at(k / 6, k % 6)] = at(m->S, from + k / 6, from + k % 6);
        }
    }
    reduce(I, G, room, n, S_inverse);
    for (size_t i = 0; i < 6; i++) {
        best[RC_MOVED_THETA + i] = m->g[from + i];
        best[RC_MOVED_VARIANCE + i] = at(m->S, from + i, from + i);
    }
    if (!rc_columns_solve(&best[RC_MOVED_GAIN], &best[RC_MOVED_THETA],
                          &best[RC_MOVED_VARIANCE], I, 6)) {
        return;
    }
    kept[RC_MOVED_TRIES] += 1;
    if (best[RC_MOVED_GAIN] > kept[RC_MOVED_GAIN]) {
        best[RC_MOVED_AT] = (rigcal_real)(int32_t)placement;
        best[RC_MOVED_TRIES] = kept[RC_MOVED_TRIES];
        for (size_t k = 0; k < 6; k++) {
            most(best, G, s->n, k);
        }
        for (size_t k = 0; k < RC_MOVED_SIZE; k++) {
            kept[k] = best[k];
        }
    }
}
