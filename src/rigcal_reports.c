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

static void mount(rigcal_mounted_camera *out, const rc_monitor *m, size_t index)
{
    rc_monitor_lens_copy lens;
    out->camera = *rc_monitor_lens(&lens, m, index);
    out->cam_from_rig = m->filter.poses[index];
    rc_filter_block(out->Sigma, &m->filter, index, index);
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

/* The packed covariance of two bodies. */
static void pack_two(rigcal_real S[78], const rc_filter *f, size_t a, size_t b)
{
    const size_t of[2] = {a, b};
    for (size_t i = 0; i < 12; i++) {
        for (size_t j = 0; j <= i; j++) {
            const int32_t row = rc_filter_first(f, of[i / 6]);
            const int32_t column = rc_filter_first(f, of[j / 6]);
            S[rc_packed_at(i, j)] =
                (row < 0 || column < 0)
                    ? 0
                    : rc_filter_element(f->UD, f->n, (size_t)row + i % 6,
                                        (size_t)column + j % 6);
        }
    }
}

rigcal_status rigcal_monitor_pair(rigcal_transform *b_from_a, rigcal_real Sigma[36],
                                  const rigcal_real monitor[], size_t a, size_t b)
{
    rigcal_real S[78];
    rc_monitor m;
    const rigcal_status status =
        (b_from_a == NULL || Sigma == NULL) ? RIGCAL_ERR_NULL : open_for(&m, monitor, a, b);
    if (status == RIGCAL_OK) {
        pack_two(S, &m.filter, a, b);
        rc_joint_pair(b_from_a, Sigma, &m.filter.poses[a], &m.filter.poses[b], S, 0, 6, 1);
    }
    return status;
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
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j <= i; j++) {
            rig->Sigma[rc_packed_at(i, j)] = rc_filter_element(f->UD, f->n, i, j);
        }
    }
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
