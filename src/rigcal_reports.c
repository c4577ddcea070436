#include "rc_joint.h"
#include "rc_monitor.h"

#include <string.h>

/* ---- constants ----------------------------------------------------------- */

/* squarings: the direction known worst comes from P^1024. It is exact to rounding, unless
 * the two largest variances differ by less than a percent. */
enum { SQUARINGS = 10 };

/* ---- poses ---------------------------------------------------------------------- */

/* Opens a monitor for a question about bodies a and b. */
static rigcal_status open_for(rc_monitor *m, const rigcal_real monitor[], size_t a,
                              size_t b)
{
    const rigcal_status status = rc_monitor_open(m, monitor);
    if (status == RIGCAL_OK &&
        (a >= m->filter.n_bodies || b >= m->filter.n_bodies ||
         !rc_filter_has(&m->filter, a) || !rc_filter_has(&m->filter, b))) {
        return RIGCAL_ERR_RANGE;
    }
    return status;
}

/* Column k of U, as an error (w, ds) of a body. The frame has none. */
static void column_of(rigcal_real d[6], const rc_filter *f, size_t body, size_t k)
{
    const int32_t first = rc_filter_first(f, body);
    const rigcal_real *const column = &f->UD[rc_packed_at(k, 0)];
    rc_clear(d, 6);
    for (size_t i = 0; i < 6 && first >= 0; i++) {
        const size_t row = (size_t)first + i;
        d[i] = row < k ? column[row] : row == k ? 1 : 0;
    }
}

/* The same as (w, dt): t becomes t + dt. */
static void step_of(rigcal_real d[6], const rc_filter *f, size_t body, size_t k)
{
    rigcal_real turned[3];
    column_of(d, f, body, k);
    rc_vec3_cross(turned, d, f->poses[body].t);
    rc_vec3_add(&d[3], turned);
}

/* Sigma += D_k a b^T */
static void add_column(rigcal_real Sigma[36], const rc_filter *f, size_t k,
                       const rigcal_real a[6], const rigcal_real b[6])
{
    const rigcal_real D = f->UD[rc_packed_at(k, k)];
    for (int i = 0; i < 36; i++) {
        Sigma[i] += D * (a[i / 6] * b[i % 6]);
    }
}

/* The covariance of (w, dt) of two bodies. As a sum of products, column by column, its
 * variances are never below 0. */
static void block_of(rigcal_real Sigma[36], const rc_filter *f, size_t a, size_t b)
{
    rc_clear(Sigma, 36);
    for (size_t k = 0; k < f->n; k++) {
        rigcal_real d_a[6], d_b[6];
        step_of(d_a, f, a, k);
        step_of(d_b, f, b, k);
        add_column(Sigma, f, k, d_a, d_b);
    }
}

static void mount(rigcal_mounted_camera *out, const rc_monitor *m, size_t index)
{
    rc_monitor_lens_copy lens;
    out->camera = *rc_monitor_lens(&lens, m, index);
    out->cam_from_rig = m->filter.poses[index];
    block_of(out->Sigma, &m->filter, index, index);
    out->has_Sigma = 1;
}

rigcal_status rigcal_monitor_camera(rigcal_mounted_camera *camera,
                                    const rigcal_real monitor[], size_t index)
{
    rc_monitor m;
    rigcal_status status =
        (camera == NULL) ? RIGCAL_ERR_NULL : open_for(&m, monitor, index, index);
    if (status == RIGCAL_OK && index >= m.filter.n_cameras) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK) {
        mount(camera, &m, index);
    }
    return status;
}

/* The errors d_a, d_b of the bodies give b_from_a = (R, t) the error w = w_b - R w_a, dt =
 * ds_b - R ds_a + w_b x t. */
rigcal_status rigcal_monitor_pair(rigcal_transform *b_from_a, rigcal_real Sigma[36],
                                  const rigcal_real monitor[], size_t a, size_t b)
{
    rc_monitor m;
    const rigcal_status status =
        (b_from_a == NULL || Sigma == NULL) ? RIGCAL_ERR_NULL : open_for(&m, monitor, a, b);
    if (status != RIGCAL_OK) {
        return status;
    }
    const rc_filter *const f = &m.filter;
    rc_transform_between(b_from_a, &f->poses[b], &f->poses[a]);
    rc_clear(Sigma, 36);
    for (size_t k = 0; k < f->n; k++) {
        rigcal_real d_a[6], d_b[6], turned[3];
        column_of(d_a, f, a, k);
        column_of(d_b, f, b, k);
        rc_vec3_cross(turned, d_b, b_from_a->t);
        rc_vec3_add(&d_b[3], turned);
        for (int half = 0; half < 6; half += 3) {
            rc_mat3_mul_vec3(turned, b_from_a->R, &d_a[half]);
            rc_vec3_sub(&d_b[half], &d_b[half], turned);
        }
        add_column(Sigma, f, k, d_b, d_b);
    }
    return RIGCAL_OK;
}

/* Writes the joint covariance of all cameras but the frame. */
static void write_joint(rigcal_real Sigma[], const rc_filter *f)
{
    const size_t n = 6 * (f->n_cameras - 1);
    rc_clear(Sigma, n * (n + 1) / 2);
    for (size_t a = 0; a < f->n_cameras; a++) {
        for (size_t b = 0; b <= a; b++) {
            rigcal_real block[36];
            if (a != f->frame && b != f->frame) {
                block_of(block, f, a, b);
                rc_filter_add(f, Sigma, a, b, block);
            }
        }
    }
}

rigcal_status rigcal_monitor_rig(rigcal_calibrated_rig *rig, const rigcal_real monitor[])
{
    rc_monitor m;
    if (rig == NULL || rig->cameras == NULL || rig->group == NULL || rig->held == NULL ||
        rig->Sigma == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = rc_monitor_open(&m, monitor);
    if (status != RIGCAL_OK) {
        return status;
    }
    const rc_filter *const f = &m.filter;
    const size_t n = 6 * (f->n_cameras - 1);
    if (f->n_cameras > rig->capacity || n * (n + 1) / 2 > rig->Sigma_capacity) {
        return RIGCAL_ERR_CAPACITY;
    }
    for (size_t c = 0; c < f->n_cameras; c++) {
        mount(&rig->cameras[c], &m, c);
        rig->group[c] = 0;
        rig->held[c] = c == f->frame;
    }
    write_joint(rig->Sigma, f);
    rig->n_cameras = f->n_cameras;
    rig->sigma_px = m.top.head.numbers[0];
    rig->F = m.top.head.numbers[1];
    rig->freedom_between = m.top.head.numbers[2];
    rig->freedom_within = m.top.head.numbers[3];
    return RIGCAL_OK;
}

/* ---- the direction known worst ------------------------------------------------- */

/* Divides P by its trace. Returns the trace. */
static rigcal_real scale_down(rigcal_real P[36])
{
    rigcal_real trace = 0;
    for (int k = 0; k < 36; k += 7) {
        trace += P[k];
    }
    for (int k = 0; k < 36 && trace > 0; k++) {
        P[k] /= trace;
    }
    return trace;
}

/* The eigenvector of the largest eigenvalue, as a column of a high power of P. Returns the
 * root of the eigenvalue. Both are 0 if the body is known exactly, or if the square of
 * `lever` underflows. */
static rigcal_real worst_of(rigcal_real direction[6], const rigcal_real Sigma[36],
                            rigcal_real lever)
{
    rigcal_real P[36], A[36], squared[36], norm = 0, variance = 0;
    int best = 0;
    for (int k = 0; k < 36; k++) {
        P[k] = Sigma[k] / ((k / 6 < 3 ? 1 : lever) * (k % 6 < 3 ? 1 : lever));
    }
    rc_clear(direction, 6);
    const rigcal_real trace = scale_down(P);
    if (!(trace > 0 && trace <= RC_MAX)) {
        return 0;
    }
    memcpy(A, P, sizeof A);
    for (int s = 0; s < SQUARINGS; s++) {
        rc_clear(squared, 36);
        rc_mat6_add_product(squared, A, A, 0);
        (void)scale_down(squared);
        memcpy(A, squared, sizeof A);
    }
    for (int k = 1; k < 6; k++) {
        best = A[7 * k] > A[7 * best] ? k : best;
    }
    for (int k = 0; k < 6; k++) {
        norm += A[6 * best + k] * A[6 * best + k];
    }
    norm = RC_SQRT(norm);
    for (int k = 0; k < 6; k++) {
        direction[k] = A[6 * best + k] / norm;
    }
    for (int k = 0; k < 36; k++) {
        variance += direction[k / 6] * P[k] * direction[k % 6];
    }
    return RC_SQRT(rc_max(variance, 0) * trace);
}

/* For the frame weakest_sigma is 0: its own pose is exact. The report does not say how well
 * other bodies are known relative to it. */
rigcal_status rigcal_monitor_body(rigcal_body_report *report, const rigcal_real monitor[],
                                  size_t body)
{
    rigcal_real Sigma[36];
    rc_monitor m;
    const rigcal_status status =
        (report == NULL) ? RIGCAL_ERR_NULL : rc_monitor_open(&m, monitor);
    if (status != RIGCAL_OK) {
        return status;
    }
    const rc_filter *const f = &m.filter;
    if (body >= f->n_bodies) {
        return RIGCAL_ERR_RANGE;
    }
    memset(report, 0, sizeof *report);
    rc_filter_block(Sigma, f, body, body);
    report->weakest_sigma =
        worst_of(report->weakest, Sigma, m.top.head.move_t / m.top.head.move_rad);
    report->is_blind = !rc_filter_has(f, body) || rc_alarm_is_blind(m.bodies, body);
    if (report->is_blind == 0) {
        report->smallest_rad = rc_alarm_smallest(&m.top.head.alarm, m.bodies, body);
    }
    if (m.top.head.is_alarm) {
        report->blame = rc_trial_share(f, m.bodies, body);
    } else if (rc_filter_has(f, body)) {
        report->share =
            rc_alarm_share(m.bodies, body, rc_alarm_log_sum(&m.top.head.alarm, m.bodies));
    }
    return RIGCAL_OK;
}
