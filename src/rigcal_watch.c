#include "rc_monitor.h"

/* ---- constants ----------------------------------------------------------- */

/* s: the longest time between the ends of two frames. */
#define SECONDS_MOST RC(1e6)

/* frames: in this many, an opened body's pose changes after each row. A row is not linear
 * over degrees. */
enum { SETTLING = 10 };

/* ---- the end of a frame ------------------------------------------------------ */

/* (M6) Adds the random walk of every camera. */
static void walk(const rc_monitor *m, rigcal_real seconds)
{
    const rc_filter *const f = &m->filter;
    const rigcal_real q_rad = m->top.head.walk_rad * m->top.head.walk_rad * seconds;
    const rigcal_real q_t = m->top.head.walk_t * m->top.head.walk_t * seconds;
    if (!(q_rad > 0 || q_t > 0)) {
        return;
    }
    rc_filter_multiply(f->UD, f->n);
    for (size_t c = 0; c < f->n_cameras; c++) {
        rc_filter_spread(f, f->UD, c, q_rad, q_t);
    }
    rc_filter_factor(f->UD, f->n);
}

/* (A5) Weighs the frame, and raises the alarm if the evidence suffices. */
static void weigh(rc_monitor *m)
{
    rc_monitor_head *const head = &m->top.head;
    head->evidence = rc_alarm_frame(&head->alarm, m->bodies);
    if (head->evidence >= 0) {
        head->is_alarm = 1;
        head->since = 1;
        head->settling = 0;
        rc_trial_begin(&m->filter, &head->alarm, m->bodies, head->move_rad, head->move_t);
    }
}

static void report_on(rigcal_monitor_report *report, const rc_monitor *m)
{
    const rc_monitor_head *const head = &m->top.head;
    const rc_filter *const f = &m->filter;
    const rigcal_real log_sum =
        head->is_alarm ? 0 : rc_alarm_log_sum(&head->alarm, m->bodies);
    rigcal_real most = -1;
    report->alarm = (int32_t)head->is_alarm;
    report->body = 0;
    report->n_blind = 0;
    report->smallest_rad = 0;
    for (size_t b = 0; b < f->n_bodies; b++) {
        const rigcal_real share = head->is_alarm ? rc_trial_share(f, m->bodies, b)
                                                 : rc_alarm_share(m->bodies, b, log_sum);
        if (!rc_filter_has(f, b)) {
            continue;
        }
        if (share > most) {
            most = share;
            report->body = (int32_t)b;
        }
        if (rc_alarm_is_blind(m->bodies, b)) {
            report->n_blind++;
            continue;
        }
        report->smallest_rad =
            rc_max(report->smallest_rad, rc_alarm_smallest(&head->alarm, m->bodies, b));
    }
    report->smallest_rad = report->n_blind > 0 ? 0 : report->smallest_rad;
    report->confidence = head->is_alarm ? most : 0;
    report->evidence = head->evidence;
    report->noise = rc_alarm_noise(&head->alarm);
    report->frames = head->frames;
    report->rows = head->rows;
    report->doubted = head->doubted;
    report->frames_since = head->since;
}

rigcal_status rigcal_monitor_ask(rigcal_monitor_report *report, const rigcal_real monitor[])
{
    rc_monitor m;
    const rigcal_status status =
        (report == NULL) ? RIGCAL_ERR_NULL : rc_monitor_open(&m, monitor);
    if (status == RIGCAL_OK) {
        report_on(report, &m);
    }
    return status;
}

rigcal_status rigcal_monitor_frame(rigcal_monitor_report *report, rigcal_real monitor[],
                                   rigcal_real seconds)
{
    rc_monitor m;
    const rigcal_status status = rc_monitor_open(&m, monitor);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!rc_is_finite(seconds)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    if (!(seconds >= 0 && seconds <= SECONDS_MOST)) {
        return RIGCAL_ERR_RANGE;
    }
    m.top.head.frames++;
    for (size_t b = 0; b < m.filter.n_bodies; b++) {
        rc_filter_apply(&m.filter, b);
    }
    walk(&m, seconds);
    m.top.head.settling -= (m.top.head.settling > 0) ? 1 : 0;
    if (m.top.head.is_alarm) {
        m.top.head.since++;
        rc_trial_settle(&m.filter, m.bodies);
    } else {
        weigh(&m);
    }
    rc_monitor_close(&m, 1);
    if (report != NULL) {
        report_on(report, &m);
    }
    return RIGCAL_OK;
}

/* ---- answers ------------------------------------------------------------------ */

static void end_alarm(rc_monitor *m)
{
    m->top.head.is_alarm = 0;
    m->top.head.since = 0;
    m->top.head.evidence = 0;
    rc_alarm_again(&m->top.head.alarm, m->bodies);
}

rigcal_status rigcal_monitor_dismiss(rigcal_real monitor[])
{
    rc_monitor m;
    rigcal_status status = rc_monitor_open(&m, monitor);
    if (status == RIGCAL_OK && m.top.head.is_alarm == 0) {
        status = RIGCAL_ERR_STATE;
    }
    if (status == RIGCAL_OK) {
        end_alarm(&m);
        rc_monitor_close_again(&m);
    }
    return status;
}

/* Opens a body: (M9) if there is no alarm, (M15) after one. */
static void open_body(rc_monitor *m, size_t body)
{
    const rc_filter *const f = &m->filter;
    const rigcal_real q_rad = m->top.head.move_rad * m->top.head.move_rad;
    const rigcal_real q_t = m->top.head.move_t * m->top.head.move_t;
    rc_filter_multiply(f->UD, f->n);
    if (m->top.head.is_alarm) {
        rigcal_transform pose;
        rigcal_real Sigma[36];
        rc_trial_result(&pose, Sigma, f, m->bodies, body);
        rc_filter_put(f, body, &pose);
        rc_filter_spread_by(f, f->UD, body, Sigma);
    } else {
        rc_filter_spread(f, f->UD, body, q_rad, rc_trial_shift(f, body, q_rad, q_t));
    }
    rc_filter_factor(f->UD, f->n);
    m->top.head.settling = SETTLING;
    m->top.head.settles = (uint32_t)body;
}

rigcal_status rigcal_monitor_moved(rigcal_real monitor[], size_t body)
{
    rc_monitor m;
    rigcal_status status = rc_monitor_open(&m, monitor);
    if (status == RIGCAL_OK &&
        (body >= m.filter.n_bodies || !rc_filter_has(&m.filter, body))) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK) {
        open_body(&m, body);
        end_alarm(&m);
        rc_monitor_close_again(&m);
    }
    return status;
}
