#include "rc_trial.h"

#include "rc_logs.h"

/* ---- constants ----------------------------------------------------------- */

/* 1: the least likelihood, so that it has a log even if no match is thought wrong. */
#define LIKELIHOOD_LEAST RC(1e-30)

/* part of a log: a row counts half. Until the alarm the body that moved drags all others
 * along, and the rows of a frame err together. With 1, one in ten of the answers called
 * sure was wrong. */
#define WEIGHT RC(0.5)

/* 1, as a log: shares of the evidence that differ by less count as equal. The windows of
 * bodies do not start together. */
#define SHARES_EQUAL RC(2)

/* ---- trials ---------------------------------------------------------------- */

static rigcal_real *trial_of(rigcal_real bodies[], size_t body)
{
    return rc_alarm_lent(bodies, body);
}

static const rigcal_real *trial_in(const rigcal_real bodies[], size_t body)
{
    return &bodies[body * RC_ALARM_BODY];
}

rigcal_real rc_trial_shift(const rc_filter *f, size_t body, rigcal_real q_rad,
                           rigcal_real q_t)
{
    rigcal_transform body_from_frame;
    if (body < f->n_cameras) {
        return q_t;
    }
    rc_transform_between(&body_from_frame, &f->poses[body], &f->poses[f->frame]);
    rc_vec3_scale(body_from_frame.t, RC_LEVER, body_from_frame.t);
    return q_t + q_rad * rc_vec3_dot(body_from_frame.t, body_from_frame.t);
}

void rc_trial_begin(const rc_filter *f, const rc_alarm *alarm, rigcal_real bodies[],
                    rigcal_real move_rad, rigcal_real move_t)
{
    const rigcal_real log_sum = rc_alarm_log_sum(alarm, bodies);
    const rigcal_real q_rad = move_rad * move_rad, q_t = move_t * move_t;
    rigcal_real most = LIKELIHOOD_LEAST;
    const rigcal_real zero = move_rad - move_rad; /* the compiler must not know that it is
                                                     0: the C library's memset is slow */
    for (size_t b = 0; b < f->n_bodies; b++) {
        most = rc_max(most, rc_alarm_share(bodies, b, log_sum));
    }
    for (size_t b = 0; b < f->n_bodies; b++) {
        rigcal_real *const trial = trial_of(bodies, b);
        const rigcal_real share = rc_alarm_share(bodies, b, log_sum) / most;
        for (int k = 0; k < RC_TRIAL_SIZE; k++) {
            trial[k] = zero;
        }
        trial[RC_TRIAL_LOG] =
            rc_min(SHARES_EQUAL + rc_log(rc_max(share, LIKELIHOOD_LEAST)), 0);
        const rigcal_real shift = rc_trial_shift(f, b, q_rad, q_t);
        for (size_t k = 0; k < 3; k++) {
            trial[RC_TRIAL_UD + rc_packed_at(k, k)] = q_rad;
            trial[RC_TRIAL_UD + rc_packed_at(k + 3, k + 3)] = shift;
        }
    }
}

/* x <- the move by x followed by the move by dx, to second order. */
static void add_move(rigcal_real x[6], const rigcal_real dx[6])
{
    rigcal_real both[3];
    rc_vec3_cross(both, dx, &x[3]);
    rc_vec3_add(&x[3], both);
    rc_vec3_add(&x[3], &dx[3]);
    rc_vec3_cross(both, dx, x);
    rc_vec3_add(x, dx);
    rc_vec3_add_scaled(x, RC(0.5), both);
}

/* Moves a pose by x = (w, ds), as rc_transform_displace does. With v = w / 2 and s = 2 / (1
 * + v^2) the turn is (1 - s v^2) 1 + s v v^T + s [v]x. Multiplying by it takes half the
 * instructions. */
static void move_by(rigcal_transform *out, const rigcal_transform *pose,
                    const rigcal_real x[6])
{
    const rigcal_real v[3] = {RC(0.5) * x[0], RC(0.5) * x[1], RC(0.5) * x[2]};
    const rigcal_real v2 = rc_vec3_dot(v, v), s = 2 / (1 + v2), c = 1 - s * v2;
    const rigcal_real a = s * v[0], b = s * v[1], d = s * v[2];
    const rigcal_real turn[3][3] = {
        {c + a * v[0], a * v[1] - d, a * v[2] + b},
        {a * v[1] + d, c + b * v[1], b * v[2] - a},
        {a * v[2] - b, b * v[2] + a, c + d * v[2]},
    };
    const rigcal_real *const R = pose->R, *const t = pose->t;
    for (int i = 0; i < 3; i++) {
        const rigcal_real e = turn[i][0], f = turn[i][1], g = turn[i][2];
        out->R[3 * i] = e * R[0] + f * R[3] + g * R[6];
        out->R[3 * i + 1] = e * R[1] + f * R[4] + g * R[7];
        out->R[3 * i + 2] = e * R[2] + f * R[5] + g * R[8];
        out->t[i] = e * t[0] + f * t[1] + g * t[2] + x[3 + i];
    }
}

/* Takes one row at the trial's pose. The row's numbers are divided by sd. Returns its
 * likelihood. */
static rigcal_real learn_row(rigcal_real trial[], rigcal_real nu, const rigcal_real h[6],
                             rigcal_real reach, rigcal_real sd, rigcal_real wrong)
{
    rigcal_real scaled[6], room[6], dx[6];
    rc_doubt doubt;
    const rigcal_real by = 1 / sd;
    nu *= by;
    rc_vec3_scale(scaled, by, h);
    rc_vec3_scale(&scaled[3], by, &h[3]);
    const rc_part part = {{0, -1}, {scaled, NULL}};
    const rigcal_real hPh = rc_filter_seen(room, &trial[RC_TRIAL_UD], 6, &part);
    const rigcal_real S = 1 + hPh + hPh * rc_filter_bend(&trial[RC_TRIAL_UD], 6, 0, reach);
    if (!(S <= RC_MAX && rc_is_finite(nu))) {
        return LIKELIHOOD_LEAST;
    }
    rc_filter_doubt(&doubt, nu, S, wrong);
    rc_filter_learn(&trial[RC_TRIAL_UD], room, 6, hPh, S, doubt.gain);
    const rigcal_real step = doubt.beta * nu / S;
    rc_vec3_scale(dx, step, room);
    rc_vec3_scale(&dx[3], step, &room[3]);
    add_move(&trial[RC_TRIAL_MOVE], dx);
    return doubt.likelihood;
}

/* h . d of a body: d is its estimated error, which is not yet in its pose. */
static rigcal_real part_of_error(const rc_filter *f, size_t body, const rigcal_real h[6])
{
    const int32_t first = rc_filter_first(f, body);
    return first < 0 ? 0 : rc_vec6_dot(h, &f->d[first]);
}

/* Takes row `index` of what was seen into the trial of one of its two bodies. Returns its
 * likelihood. */
static rigcal_real take_moved(const rc_filter *f, rigcal_real trial[], const rc_seen *seen,
                              int is_b, int index, rigcal_real sd, rigcal_real wrong)
{
    rigcal_transform moved;
    rc_row rows[2];
    move_by(&moved, &f->poses[is_b ? seen->b : seen->a], &trial[RC_TRIAL_MOVE]);
    const rigcal_status status = rc_rows_of(rows, seen, is_b ? &f->poses[seen->a] : &moved,
                                            is_b ? &moved : &f->poses[seen->b]);
    if (status != RIGCAL_OK) {
        return LIKELIHOOD_LEAST;
    }
    const rc_row *const row = &rows[index];
    const rigcal_real nu =
        row->r - part_of_error(f, seen->a, row->h_a) - part_of_error(f, seen->b, row->h_b);
    return learn_row(trial, nu, is_b ? row->h_b : row->h_a, row->reach, sd, wrong);
}

/* Only differences of the sums count. So what the row adds to the trials of other bodies is
 * subtracted from its two instead. */
int rc_trial_take(const rc_filter *f, rigcal_real bodies[], const rc_seen *seen,
                  rigcal_real wrong)
{
    rc_row rows[2];
    rigcal_real best = 0;
    if (rc_rows_of(rows, seen, &f->poses[seen->a], &f->poses[seen->b]) != RIGCAL_OK) {
        return 0;
    }
    for (int index = 0; index < seen->n_rows; index++) {
        rc_news news;
        rc_doubt held;
        if (!rc_filter_ask(&news, f, seen->a, seen->b, &rows[index], wrong)) {
            continue;
        }
        rc_filter_doubt(&held, news.z, 1, wrong);
        best = rc_max(best, held.beta);
        const rigcal_real log_held = rc_log(rc_max(held.likelihood, LIKELIHOOD_LEAST));
        for (int k = 0; k < 2; k++) {
            rigcal_real *const trial = trial_of(bodies, k ? seen->b : seen->a);
            const rigcal_real likelihood =
                take_moved(f, trial, seen, k, index, news.sd, wrong);
            trial[RC_TRIAL_LOG] +=
                WEIGHT * (rc_log(rc_max(likelihood, LIKELIHOOD_LEAST)) - log_held);
        }
    }
    return best < RC(0.5);
}

/* ---- what they say ----------------------------------------------------------- */

static rigcal_real most_of(const rc_filter *f, const rigcal_real bodies[])
{
    rigcal_real most = -RC_MAX;
    for (size_t b = 0; b < f->n_bodies; b++) {
        if (rc_filter_has(f, b)) {
            most = rc_max(most, trial_in(bodies, b)[RC_TRIAL_LOG]);
        }
    }
    return most;
}

rigcal_real rc_trial_share(const rc_filter *f, const rigcal_real bodies[], size_t body)
{
    const rigcal_real most = most_of(f, bodies);
    rigcal_real sum = 0;
    for (size_t b = 0; b < f->n_bodies; b++) {
        if (rc_filter_has(f, b)) {
            sum += rc_exp(trial_in(bodies, b)[RC_TRIAL_LOG] - most);
        }
    }
    return rc_filter_has(f, body)
               ? rc_exp(trial_in(bodies, body)[RC_TRIAL_LOG] - most) / sum
               : 0;
}

void rc_trial_settle(const rc_filter *f, rigcal_real bodies[])
{
    const rigcal_real most = most_of(f, bodies);
    for (size_t b = 0; b < f->n_bodies; b++) {
        trial_of(bodies, b)[RC_TRIAL_LOG] -= most;
    }
}

void rc_trial_result(rigcal_transform *pose, rigcal_real Sigma[36], const rc_filter *f,
                     const rigcal_real bodies[], size_t body)
{
    const rigcal_real *const trial = trial_in(bodies, body);
    move_by(pose, &f->poses[body], &trial[RC_TRIAL_MOVE]);
    rc_rotation_tidy(pose->R);
    for (size_t k = 0; k < 36; k++) {
        Sigma[k] = rc_filter_element(&trial[RC_TRIAL_UD], 6, k / 6, k % 6);
    }
}
