#include "rc_border.h"
#include "rc_intrinsics.h"
#include "rc_views.h"

size_t rigcal_estimate_work(size_t n_free, size_t n_cameras)
{
    return RIGCAL_ESTIMATE_WORK(n_free, n_cameras);
}

/* ---- a camera's own numbers -------------------------------------------------- */

/* The six numbers in the order of RC_BY_FOCAL and so on. */
static void numbers_of(rigcal_real x[RC_INTRINSICS], const rigcal_intrinsics_change *change)
{
    x[RC_BY_FOCAL] = change->focal;
    x[RC_BY_ASPECT] = change->aspect;
    x[RC_BY_CENTRE] = change->cx;
    x[RC_BY_CENTRE + 1] = change->cy;
    x[RC_BY_K1] = change->k1;
    x[RC_BY_K2] = change->k2;
}

static rigcal_intrinsics_change change_of(const rigcal_real x[RC_INTRINSICS])
{
    const rigcal_intrinsics_change change = {x[RC_BY_FOCAL],  x[RC_BY_ASPECT],
                                             x[RC_BY_CENTRE], x[RC_BY_CENTRE + 1],
                                             x[RC_BY_K1],     x[RC_BY_K2]};
    return change;
}

rigcal_status rigcal_camera_change(rigcal_camera *out, const rigcal_camera *camera,
                                   const rigcal_intrinsics_change *change)
{
    if (out == NULL || camera == NULL || change == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_real x[RC_INTRINSICS];
    numbers_of(x, change);
    if (!rc_all_finite(x, RC_INTRINSICS)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    rigcal_status status = rigcal_camera_check(camera);
    if (status != RIGCAL_OK) {
        return status;
    }
    rigcal_camera changed = *camera;
    changed.fx *= 1 + x[RC_BY_FOCAL] + x[RC_BY_ASPECT] / 2;
    changed.fy *= 1 + x[RC_BY_FOCAL] - x[RC_BY_ASPECT] / 2;
    changed.cx += x[RC_BY_CENTRE];
    changed.cy += x[RC_BY_CENTRE + 1];
    changed.k1 += x[RC_BY_K1];
    changed.k2 += x[RC_BY_K2];
    status = rigcal_camera_check(&changed);
    if (status == RIGCAL_OK) {
        *out = changed;
    }
    return status;
}

/* Writes the deviations of a camera. Returns the number of its first column. */
static size_t columns_of(rigcal_real sigma[RC_INTRINSICS], const rigcal_rig *rig,
                         size_t camera)
{
    size_t n = 0;
    rc_clear(sigma, RC_INTRINSICS);
    for (size_t c = 0; c <= camera && rig->intrinsics_sigmas != NULL; c++) {
        const rigcal_intrinsics_sigma *const s = &rig->intrinsics_sigmas[c];
        for (int i = 0; i < RC_INTRINSICS; i++) {
            n += sigma[i] > 0; /* columns of the camera before */
        }
        const rigcal_intrinsics_change all = {s->focal,  s->aspect, s->centre,
                                              s->centre, s->k1,     s->k2};
        numbers_of(sigma, &all);
    }
    return n;
}

/* ---- what the views say of the intrinsics alone -------------------------------- */

/* Adds a point to Q = D^T D and q = D^T e of its camera's columns. */
static void add_point(const rc_border *b, size_t column,
                      const rigcal_real sigma[RC_INTRINSICS],
                      const rigcal_real D[2 * RC_INTRINSICS], const rigcal_real e[2],
                      rigcal_real weight)
{
    size_t i = column;
    for (int p = 0; p < RC_INTRINSICS; p++) {
        const rigcal_real x = weight * sigma[p] * D[p];
        const rigcal_real y = weight * sigma[p] * D[RC_INTRINSICS + p];
        size_t j = column;
        for (int o = 0; o <= p && sigma[p] > 0; o++) {
            if (sigma[o] > 0) {
                b->Q[rc_packed_at(i, j++)] +=
                    sigma[o] * (x * D[o] + y * D[RC_INTRINSICS + o]);
            }
        }
        if (sigma[p] > 0) {
            b->q[i++] += x * e[0] + y * e[1];
        }
    }
}

/* Points count as by the loss of the adjustment. */
static rigcal_status add_view(const rc_border *b, const rigcal_rig *rig, size_t index,
                              int32_t loss)
{
    rigcal_rig_view v;
    rigcal_points points;
    rc_chain chain;
    rigcal_real sigma[RC_INTRINSICS];
    rigcal_status status = rc_rig_view_at(&v, rig, index);
    if (status == RIGCAL_OK) {
        status = rc_rig_points(&points, &v);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_rig_chain(&chain, rig, v.camera, (size_t)v.placement, index);
    const size_t column = columns_of(sigma, rig, (size_t)v.camera);
    for (size_t i = 0; i < v.view.n && status == RIGCAL_OK; i++) {
        rigcal_real x[2], uv[2], B[6], q[3], X_c[3], D[2 * RC_INTRINSICS];
        const rigcal_real *const seen = v.view.observations[i].uv;
        const rigcal_real weight =
            rc_rig_weight(&points, &chain.cam_from_target, i, loss, rig->sigma_px);
        if (!(weight > 0)) {
            continue;
        }
        rc_points_place(q, X_c, &points, &chain.cam_from_target, i);
        status = rc_project_by(x, uv, B, v.view.camera, X_c);
        if (status == RIGCAL_OK) {
            const rigcal_real e[2] = {seen[0] - uv[0], seen[1] - uv[1]};
            rc_intrinsics(D, v.view.camera, x, uv);
            add_point(b, column, sigma, D, e, weight);
        }
    }
    return status;
}

/* ---- with the rig -------------------------------------------------------------- */

static rigcal_real dot(const rigcal_real a[], const rigcal_real b[], size_t n)
{
    rigcal_real sum = 0;
    for (size_t i = 0; i < n; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

/* Eliminates all placements. Then it turns each row of T into a row of G and subtracts T^T
 * G from Q. */
static rigcal_status eliminate(rigcal_consider_solver *s, int32_t *at_fault,
                               const rigcal_rig *rig, rigcal_real T[])
{
    rc_border *const b = &s->border;
    rigcal_status status = RIGCAL_RUNNING;
    while (status == RIGCAL_RUNNING && s->placement < rig->n_placements) {
        status = rigcal_consider_step(s, 1);
    }
    while (status == RIGCAL_RUNNING) {
        const size_t j = s->column;
        for (size_t row = 0; j < b->k && row < b->n; row++) {
            T[row] = b->T[b->n * j + row];
        }
        status = rigcal_consider_step(s, 1);
        for (size_t i = j; i < b->k; i++) {
            const rigcal_real *const T_i = (i == j) ? T : &b->T[b->n * i];
            b->Q[rc_packed_at(i, j)] -= dot(T_i, &b->T[b->n * j], b->n);
        }
    }
    return rigcal_consider_result(at_fault, s);
}

/* Q <- L of Q / sigma_px^2 + 1, and q <- the most likely change in deviations. Before, q is
 * D^T e. The change that was already made is subtracted. */
static rigcal_status solve(const rc_border *b, const rigcal_real made[],
                           rigcal_real sigma_px)
{
    const rigcal_real weight = 1 / (sigma_px * sigma_px);
    for (size_t i = 0; i < b->k; i++) {
        for (size_t j = 0; j <= i; j++) {
            b->Q[rc_packed_at(i, j)] *= weight;
        }
        b->Q[rc_packed_at(i, i)] += 1;
        b->q[i] = weight * b->q[i] - made[i];
    }
    for (size_t i = 0; i < b->k; i++) {
        if (!rc_packed_factor_row(b->Q, i, 0)) {
            return RIGCAL_ERR_DEGENERATE;
        }
    }
    rc_packed_forward(b->q, b->Q, b->k);
    rc_packed_backward(b->q, b->Q, b->k);
    return RIGCAL_OK;
}

/* Computes column i of L^-1. Returns its length: the deviation afterwards as a part of the
 * one before. */
static rigcal_real deviation(rigcal_real x[], const rc_border *b, size_t i)
{
    rc_clear(x, b->k);
    x[i] = 1;
    rc_packed_forward(x, b->Q, b->k);
    return RC_SQRT(dot(x, x, b->k));
}

/* Writes the results of each camera. x is memory for k numbers. */
static void tell(rigcal_estimated *out, const rc_border *b, const rigcal_rig *rig,
                 rigcal_real x[])
{
    out->step = 0;
    for (size_t c = 0; c < rig->n_cameras; c++) {
        rigcal_real sigma[RC_INTRINSICS], change[RC_INTRINSICS];
        size_t column = columns_of(sigma, rig, c);
        numbers_of(change, &out->made[c]);
        for (int p = 0; p < RC_INTRINSICS; p++) {
            if (sigma[p] > 0) {
                const rigcal_real left = deviation(x, b, column);
                const rigcal_real step = b->q[column++];
                change[p] += sigma[p] * step;
                sigma[p] *= rc_min(left, 1); /* more is rounding */
                if (RC_FABS(step) > out->step * left) {
                    out->step = RC_FABS(step) / left;
                }
            }
        }
        out->change[c] = change_of(change);
        out->sigma[c] = change_of(sigma);
    }
}

/* ---- the whole ------------------------------------------------------------------- */

static rigcal_status check(const rigcal_estimated *estimated, const rigcal_rig *rig,
                           int32_t *at_fault, rigcal_real sigma_px)
{
    if (estimated == NULL || rig == NULL || estimated->made == NULL ||
        estimated->change == NULL || estimated->sigma == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_noise(&sigma_px);
    if (status == RIGCAL_OK && !(sigma_px > 0)) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK && rig->clocks != NULL) {
        status = RIGCAL_ERR_STATE;
    }
    if (status == RIGCAL_OK) {
        status = rc_rig_check(rig);
    }
    for (size_t c = 0; c < rig->n_cameras && status == RIGCAL_OK; c++) {
        rigcal_real made[RC_INTRINSICS];
        numbers_of(made, &estimated->made[c]);
        status = rc_check_numbers(made, RC_INTRINSICS, RC_PIXEL_MAX);
        *at_fault = (status == RIGCAL_OK) ? -1 : (int32_t)c;
    }
    return status;
}

/* Sets Q, q and room for a row, behind the memory that `consider` needs. Checks the
 * capacity. */
static rigcal_status open(rc_border *b, const rigcal_considered *considered)
{
    const size_t used = (b->n + 6) * b->k, size = rc_packed_at(b->k, 0);
    const size_t row = (b->n > b->k) ? b->n : b->k;
    b->Q = &considered->effects[used];
    b->q = &b->Q[size];
    return (considered->capacity < used + size + b->k + row) ? RIGCAL_ERR_CAPACITY
                                                             : RIGCAL_OK;
}

/* The changes that were already made, divided by their deviations. */
static void scale_made(rigcal_real x[], const rigcal_estimated *estimated,
                       const rigcal_rig *rig)
{
    for (size_t c = 0; c < rig->n_cameras; c++) {
        rigcal_real sigma[RC_INTRINSICS], made[RC_INTRINSICS];
        size_t column = columns_of(sigma, rig, c);
        numbers_of(made, &estimated->made[c]);
        for (int p = 0; p < RC_INTRINSICS; p++) {
            if (sigma[p] > 0) {
                x[column++] = made[p] / sigma[p];
            }
        }
    }
}

static rigcal_status estimate(rigcal_estimated *out, int32_t *at_fault, rigcal_rig *rig,
                              rigcal_real sigma_px)
{
    rigcal_consider_solver s;
    rc_border *const b = &s.border;
    rigcal_status status = rigcal_consider_begin(&s, &out->considered, rig);
    if (status == RIGCAL_OK) {
        status = open(b, &out->considered);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    rigcal_real *const row = &b->q[b->k];
    rc_clear(b->q, b->k);
    rc_clear(b->Q, rc_border_size(b));
    for (size_t i = 0; i < rig->n_views; i++) {
        if (!rc_rig_is_left_out(rig, i)) {
            status = add_view(b, rig, i, out->considered.loss);
        }
        if (status != RIGCAL_OK) {
            *at_fault = (int32_t)i;
            return status;
        }
    }
    status = eliminate(&s, at_fault, rig, row);
    if (status != RIGCAL_OK) {
        return status;
    }
    rig->considered = NULL;
    scale_made(row, out, rig);
    status = solve(b, row, sigma_px);
    if (status == RIGCAL_OK) {
        tell(out, b, rig, row);
        rc_border_mix(b->T, b->n, b->Q, b->k);
        out->considered.factor = b->Q;
        out->considered.sum = out->considered.own_sum = 0;
        rig->considered = &out->considered;
    }
    return status;
}

rigcal_status rigcal_rig_estimate(rigcal_estimated *estimated, int32_t *at_fault,
                                  rigcal_rig *rig, rigcal_real sigma_px)
{
    int32_t at = -1;
    if (rig != NULL) {
        rig->considered = NULL;
    }
    rigcal_status status = check(estimated, rig, &at, sigma_px);
    if (status == RIGCAL_OK) {
        status = estimate(estimated, &at, rig, sigma_px);
    }
    if (at_fault != NULL) {
        *at_fault = at;
    }
    return status;
}
