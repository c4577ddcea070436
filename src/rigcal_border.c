#include "rc_border.h"

#include "rc_residual.h"

static rigcal_real dot(const rigcal_real a[], const rigcal_real b[], size_t n)
{
    rigcal_real sum = 0;
    for (size_t i = 0; i < n; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

/* ---- where things are ----------------------------------------------------- */

static size_t first_of(const rc_border *b, size_t row)
{
    return (b->first == NULL) ? 0 : b->first[row];
}

size_t rc_border_at(const rc_border *b, size_t i, size_t j)
{
    size_t at = 0;
    for (size_t row = 0; row < i; row++) {
        at += row + 1 - first_of(b, row);
    }
    return at + j - first_of(b, i);
}

size_t rc_border_size(const rc_border *b)
{
    return (b->k == 0) ? 0 : rc_border_at(b, b->k - 1, b->k - 1) + 1;
}

/* ---- a pass over the placements ------------------------------------------- */

void rc_border_next(rc_border *b)
{
    rc_rigid_clear(b->gp, b->Hp);
    rc_clear(b->Z, 6 * b->k);
    b->count = 0;
}

void rc_border_begin(rc_border *b)
{
    rc_clear(b->T, b->n * b->k);
    if (b->q != NULL) {
        rc_clear(b->q, b->k);
        rc_clear(b->Q, rc_border_size(b));
    }
    rc_border_next(b);
}

void rc_border_view(rc_border *b, const rc_chain *chain, rigcal_real at, rigcal_real g[6],
                    rigcal_real H[21])
{
    rc_chain_add_placement(b->gp, b->Hp, chain, g, H);
    rc_chain_camera(g, H, &b->W[36 * b->count], chain);
    b->slot[b->count++] = at;
}

void rc_border_add(rc_border *b, const rc_chain *chain, size_t column,
                   const rigcal_real E[6])
{
    const rigcal_real at = b->slot[b->count - 1];
    rigcal_real v[3];
    for (int half = 0; half < 6; half += 3) { /* B^T E */
        rc_mat3_tmul_vec3(v, chain->R_c, &E[half]);
        rc_vec3_add(&b->Z[6 * column + (size_t)half], v);
    }
    if (b->T != NULL && at >= 0) { /* A^T E */
        rigcal_real *const T = &b->T[b->n * column + (size_t)at];
        rc_vec3_cross(v, chain->lever, &E[3]);
        rc_vec3_add(v, &E[0]);
        rc_vec3_add(&T[0], v);
        rc_vec3_add(&T[3], &E[3]);
    }
}

/* Eliminates the placement from column i. The columns before it must have been
 * eliminated. */
static void eliminate_column(rc_border *b, const rc_sym6_factor *L, size_t i,
                             rigcal_real **Q)
{
    rigcal_real *const Y = &b->Z[6 * i];
    rc_sym6_forward(Y, L);
    for (size_t slot = 0; slot < b->count; slot++) {
        if (b->slot[slot] >= 0) {
            rigcal_real *const T = &b->T[b->n * i + (size_t)b->slot[slot]];
            for (size_t row = 0; row < 6; row++) {
                T[row] -= rc_vec6_dot(&b->W[36 * slot + 6 * row], Y);
            }
        }
    }
    if (b->q != NULL) {
        b->q[i] -= rc_vec6_dot(Y, b->gp);
        for (size_t j = first_of(b, i); j <= i; j++) {
            *(*Q)++ -= rc_vec6_dot(Y, &b->Z[6 * j]);
        }
    }
}

int rc_border_eliminate(rc_border *b)
{
    rc_sym6_factor *const L = (rc_sym6_factor *)(void *)b->Hp;
    rigcal_real *Q = b->Q;
    if (!rc_sym6_factor_of(L, b->Hp, 0)) {
        return 0;
    }
    rc_sym6_forward(b->gp, L);
    for (size_t row = 0; row < 6 * b->count; row++) {
        rc_sym6_forward(&b->W[6 * row], L);
    }
    for (size_t i = 0; i < b->k; i++) {
        eliminate_column(b, L, i, &Q);
    }
    return 1;
}

/* ---- what has been found --------------------------------------------------- */

void rc_border_effect(rigcal_real G[], const rc_border *b, const rigcal_real S_inverse[],
                      size_t column)
{
    const rigcal_real *const T = &b->T[b->n * column], *row = S_inverse;
    for (size_t i = 0; i < b->n; i++) { /* S is symmetric: each element of the triangle
                                           serves twice */
        rigcal_real sum = 0;
        for (size_t j = 0; j < i; j++) {
            sum += row[j] * T[j];
            G[j] += row[j] * T[i];
        }
        G[i] = sum + row[i] * T[i];
        row += i + 1;
    }
}

rigcal_real rc_border_information(const rc_border *b, size_t i, size_t j,
                                  const rigcal_real G_j[])
{
    return b->Q[rc_border_at(b, i, j)] - dot(&b->T[b->n * i], G_j, b->n);
}

rigcal_real rc_border_slope(const rc_border *b, size_t i, const rigcal_real G_i[],
                            const rigcal_real g[])
{
    return b->q[i] - ((g == NULL) ? 0 : dot(G_i, g, b->n));
}

void rc_border_mix(rigcal_real rows[], size_t width, const rigcal_real L[], size_t k)
{
    for (size_t i = 0; i < k; i++) {
        const rigcal_real *const l = &L[rc_packed_at(i, 0)];
        for (size_t column = 0; column < width; column++) {
            rigcal_real left = rows[width * i + column];
            for (size_t j = 0; j < i; j++) {
                left -= l[j] * rows[width * j + column];
            }
            rows[width * i + column] = left * l[i];
        }
    }
}
