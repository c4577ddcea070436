#include "rc_monitor.h"

/* ---- a target has a place ----------------------------------------------------- */

/* Sets the point and its pixel from an observation. */
static void see(rc_seen *seen, const rigcal_observation *o)
{
    rc_vec3_copy(seen->X, o->X_w);
    seen->uv[0] = o->uv[0];
    seen->uv[1] = o->uv[1];
}

/* Checks that all points have rows at the bodies' poses, before one of them is taken. */
static rigcal_status check_rows(int32_t *at_fault, const rc_monitor *m, rc_seen *seen,
                                const rigcal_observation observations[], size_t n)
{
    const rc_filter *const f = &m->filter;
    for (size_t i = 0; i < n; i++) {
        rc_row rows[2];
        see(seen, &observations[i]);
        const rigcal_status status =
            rc_rows_of(rows, seen, &f->poses[seen->a], &f->poses[seen->b]);
        if (status != RIGCAL_OK) {
            rc_write_fault(at_fault, (int32_t)i);
            return status;
        }
    }
    return RIGCAL_OK;
}

static rigcal_status take_view(int32_t *at_fault, rc_monitor *m, rc_seen *seen,
                               const rigcal_observation observations[], size_t n)
{
    const rigcal_status status = check_rows(at_fault, m, seen, observations, n);
    if (status != RIGCAL_OK) {
        return status;
    }
    for (size_t i = 0; i < n; i++) {
        see(seen, &observations[i]);
        /* While a body settles, a point may come behind its camera: then it does not
         * count. */
        (void)rc_monitor_take(m, seen);
    }
    return RIGCAL_OK;
}

/* ---- a target gets its place -------------------------------------------------- */

/* Whether a pose fixes the place of a target. One that is ambiguous, vague or does not fit
 * does not. */
static int is_placed(rigcal_status status)
{
    return status >= 0 && status != RIGCAL_AMBIGUOUS && status != RIGCAL_POOR_FIT &&
           status != RIGCAL_VAGUE;
}

/* (M4) Places a target by its first view, with the covariances of the view's and the
 * camera's pose. */
static rigcal_status place(int32_t *at_fault, rc_monitor *m, const rc_seen *seen,
                           const rigcal_observation observations[], size_t n)
{
    const rc_filter *const f = &m->filter;
    const rigcal_view view = {seen->camera, observations, NULL, n};
    rigcal_pose_options options;
    rigcal_pose pose;
    rigcal_pose_uncertainty sure;
    size_t n_found;
    if (m->top.head.is_alarm) {
        return RIGCAL_ERR_STATE;
    }
    (void)rigcal_pose_defaults(&options);
    options.sigma_px = seen->sigma_px;
    const rigcal_status found =
        rigcal_pose_solve(&pose, 1, &n_found, at_fault, &view, &options);
    if (!is_placed(found)) {
        return found;
    }
    const rigcal_status status =
        rigcal_pose_covariance(&sure, &view, &pose.cam_from_world, seen->sigma_px);
    if (status != RIGCAL_OK) {
        return status;
    }
    rigcal_real by_camera[36], by_view[36], Q[36];
    rigcal_transform target;
    rc_rows_place(&target, by_camera, by_view, &f->poses[seen->a], &pose.cam_from_world);
    rc_filter_through(Q, by_view, sure.Sigma, by_view);
    rc_filter_multiply(f->UD, f->n);
    rc_filter_come(f, f->UD, seen->b, seen->a, by_camera, Q);
    rc_filter_factor(f->UD, f->n);
    f->poses[seen->b] = target;
    rc_alarm_forget(&m->top.head.alarm, m->bodies, seen->b);
    m->filter.placed |= (uint32_t)1 << (seen->b - f->n_cameras);
    return found;
}

/* ---- what is handed in -------------------------------------------------------- */

static rigcal_status check_observations(int32_t *at_fault,
                                        const rigcal_observation observations[], size_t n)
{
    if (observations == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (n < 1) {
        return RIGCAL_ERR_TOO_FEW;
    }
    if (n > RC_COUNT_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    for (size_t i = 0; i < n; i++) {
        const rigcal_status status = rc_check_observation(&observations[i]);
        if (status != RIGCAL_OK) {
            rc_write_fault(at_fault, (int32_t)i);
            return status;
        }
    }
    return RIGCAL_OK;
}

rigcal_status rigcal_monitor_view(rigcal_real monitor[], int32_t *at_fault, size_t camera,
                                  size_t target, const rigcal_observation observations[],
                                  size_t n, rigcal_real sigma_px)
{
    rc_monitor m;
    rc_seen seen;
    rc_monitor_lens_copy lens;
    rc_write_fault(at_fault, -1);
    rigcal_status status = rc_monitor_open(&m, monitor);
    if (status == RIGCAL_OK) {
        status = rc_monitor_check_noise(sigma_px);
    }
    if (status == RIGCAL_OK &&
        (camera >= m.filter.n_cameras || target >= m.top.head.n_targets)) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK) {
        status = check_observations(at_fault, observations, n);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    seen.a = camera;
    seen.b = m.filter.n_cameras + target;
    seen.n_rows = 2;
    seen.camera = rc_monitor_lens(&lens, &m, camera);
    seen.sigma_px = sigma_px;
    status = rc_filter_has(&m.filter, seen.b)
                 ? take_view(at_fault, &m, &seen, observations, n)
                 : place(at_fault, &m, &seen, observations, n);
    if (is_placed(status)) {
        rc_monitor_close(&m, 0);
    }
    return status;
}

rigcal_status rigcal_monitor_lifted(rigcal_real monitor[], size_t target)
{
    rc_monitor m;
    rigcal_status status = rc_monitor_open(&m, monitor);
    if (status == RIGCAL_OK && target >= m.top.head.n_targets) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    const rc_filter *const f = &m.filter;
    const size_t body = f->n_cameras + target;
    if (rc_filter_has(f, body)) {
        rc_filter_multiply(f->UD, f->n);
        rc_filter_leave(f, f->UD, body);
        rc_filter_factor(f->UD, f->n);
        m.filter.placed &= ~((uint32_t)1 << target);
        if (m.top.head.settles == body) {
            m.top.head.settling = 0;
        }
    }
    rc_monitor_close_again(&m);
    return RIGCAL_OK;
}
