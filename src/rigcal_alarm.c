#include "rc_alarm.h"

#include "rc_chance.h"

/* ---- constants ----------------------------------------------------------- */

/* frames: window i starts anew after 4^i. Each serves moves that are seen in about as
 * many frames; with powers of 2 there were twice the windows, and no sooner alarm. */
#define LENGTH(window) ((int32_t)1 << (2 * (window)))
#define LOG_4 RC(1.38629436111989061883)

/* standard deviations: innovations are clipped here. Huber's value: normal noise loses 5 %
 * of what it says, and a wrong match pulls no more than this. */
#define CLIP RC(1.345)

/* 1: rms of normal noise that is clipped there. */
#define CLIPPED_RMS RC(0.842745)

/* 1: a window expects moves of (this / its length) of the inverse of what a frame says,
 * so moves of sqrt(8) of its own standard deviations. */
#define EXPECTED RC(8)

/* part of the diagonal: directions that no row sees have at least so much of what the
 * others have. */
#define UNSEEN RC(1e-3)

/* 1: A is the mean time between false alarms over this. A is a bound that noise does not
 * reach: with 5 rows a frame alarms are six times as rare as it says, with 100 2.6 times. */
#define SLACK RC(3)

/* 1: what is said of rows is measured again when there are so many times as many frames. */
#define GROWTH 4

/* rows: a body with fewer in the longest window is blind. A move has six unknowns. */
#define SEEING_ROWS 6

/* rows: the noise is told by about so many of late. */
#define NOISE_ROWS RC(4096)

/* 1: 2^50. Three inverse roots of the elements of W + H are scaled by it, so that the
 * product of all six stays within float: W + H may be 1e13. And the log of its square. */
#define SCALE RC(1125899906842624.0)
#define LOG_SCALES RC(69.314718055994531)

/* Numbers of a body, in the order in which they are held. */
enum {
    G = 0, /* of a window: sum of g */
    H = 6, /* of a window: what that sum varies by */
    HALF_LOG_W = 27,
    FRAME = RC_ALARM_WINDOWS * RC_ALARM_WINDOW, /* g, and the sum of p p^T */
    FRAME_H = FRAME + 6,
    M = FRAME + RC_ALARM_SUMS, /* mean of H of a frame */
    MEASURED = M + 21,         /* frames that M is the mean of; 0: M is 0 */
    SINCE,                     /* frames of the longest window */
    ROWS,                      /* rows in the longest window; in the one before */
    ROWS_BEFORE,
    LOG_SUM /* log of the body's part of the sum */
};

static const uint8_t DIAGONAL[6] = {0, 3, 5, 15, 18, 20};

static rigcal_real *body_of(rigcal_real bodies[], size_t body)
{
    return &bodies[body * RC_ALARM_BODY];
}

static const rigcal_real *body_in(const rigcal_real bodies[], size_t body)
{
    return &bodies[body * RC_ALARM_BODY];
}

/* ---- windows --------------------------------------------------------------- */

/* A += s x x^T */
static void add_outer(rigcal_real A[21], rigcal_real s, const rigcal_real x[6])
{
    rc_sym3_add_outer(A, s, x);
    for (int i = 0; i < 3; i++) {
        rc_vec3_add_scaled(&A[RC_SYM6_ACROSS + 3 * i], s * x[i], &x[3]);
    }
    rc_sym3_add_outer(&A[RC_SYM6_SECOND], s, &x[3]);
}

/* A = W + H of a window, H 0 where there is none: W = length / EXPECTED (M + UNSEEN diag M)
 * + 1, in units of the largest move. */
static void precision_of(rigcal_real A[21], const rigcal_real mean[21],
                         const rigcal_real *sum, int window)
{
    const rigcal_real expected = (rigcal_real)LENGTH(window) / EXPECTED;
    for (int k = 0; k < 21; k++) {
        A[k] = expected * mean[k] + (sum ? sum[k] : 0);
    }
    for (int k = 0; k < 6; k++) {
        const int at = DIAGONAL[k];
        A[at] += 1 + expected * UNSEEN * mean[at];
    }
}

/* *half = log |A| / 2, and L its factor. 0: A is not positive definite to rounding, or not
 * finite. */
static int factor(rc_sym6_factor *L, rigcal_real *half, const rigcal_real A[21])
{
    if (!rc_sym6_factor_of(L, A, 0)) {
        return 0;
    }
    const rigcal_real first = SCALE * L->first[0] * L->first[3] * L->first[5];
    const rigcal_real product = SCALE * L->second[0] * L->second[3] * L->second[5] * first;
    if (!(product > 0)) {
        return 0;
    }
    *half = LOG_SCALES - rc_log(product);
    return 1;
}

/* log of Lambda of a window. */
static rigcal_real log_lambda(const rigcal_real body[], int window)
{
    const rigcal_real *const at = &body[window * RC_ALARM_WINDOW];
    rigcal_real A[21], x[6], half;
    rc_sym6_factor L;
    precision_of(A, &body[M], &at[H], window);
    if (!factor(&L, &half, A)) {
        return -RC_MAX;
    }
    rc_vec3_copy(x, &at[G]);
    rc_vec3_copy(&x[3], &at[G + 3]);
    rc_sym6_forward(x, &L);
    const rigcal_real squares = rc_vec3_dot(x, x) + rc_vec3_dot(&x[3], &x[3]);
    const rigcal_real log_of = at[HALF_LOG_W] - half + squares / 2;
    return rc_is_finite(log_of) ? log_of : -RC_MAX;
}

/* All windows of a body start, with W of its M. */
static void start_windows(rigcal_real body[])
{
    rigcal_real A[21];
    rc_sym6_factor L;
    for (int window = 0; window < RC_ALARM_WINDOWS; window++) {
        rigcal_real *const at = &body[window * RC_ALARM_WINDOW];
        rc_clear(at, RC_ALARM_WINDOW);
        precision_of(A, &body[M], NULL, window);
        (void)factor(&L, &at[HALF_LOG_W], A);
    }
    body[SINCE] = 0;
}

/* ---- begin ----------------------------------------------------------------- */

void rc_alarm_begin(rc_alarm *alarm, rigcal_real bodies[], size_t n_bodies,
                    rigcal_real arl0_frames, rigcal_real common, rigcal_real move_rad,
                    rigcal_real move_t)
{
    RIGCAL_ASSERT(n_bodies > 0 && n_bodies <= INT16_MAX);
    RIGCAL_ASSERT(arl0_frames > 0 && common >= 0 && common <= 1);
    RIGCAL_ASSERT(move_rad > 0 && move_t > 0);
    alarm->n_bodies = (int32_t)n_bodies;
    alarm->common = common;
    alarm->log_limit = rc_log(arl0_frames / SLACK);
    alarm->move_rad = move_rad;
    alarm->move_t = move_t;
    alarm->rows = alarm->squares = alarm->log_sum = 0;
    for (size_t b = 0; b < n_bodies; b++) {
        rc_alarm_forget(alarm, bodies, b);
    }
}

void rc_alarm_forget(rc_alarm *alarm, rigcal_real bodies[], size_t body)
{
    rigcal_real *const at = body_of(bodies, body);
    RIGCAL_ASSERT(body < (size_t)alarm->n_bodies);
    (void)alarm;
    rc_clear(at, RC_ALARM_BODY);
    start_windows(at);
}

void rc_alarm_again(rc_alarm *alarm, rigcal_real bodies[])
{
    for (size_t b = 0; b < (size_t)alarm->n_bodies; b++) {
        rigcal_real *const at = body_of(bodies, b);
        rc_clear(&at[FRAME], RC_ALARM_SUMS);
        start_windows(at);
    }
    alarm->log_sum = 0;
}

rigcal_real *rc_alarm_lent(rigcal_real bodies[], size_t body)
{
    return body_of(bodies, body);
}

/* ---- a row ----------------------------------------------------------------- */

/* g += p, and the sum of p p^T, for p = by D h. */
static void add_row(rigcal_real body[], const rc_alarm *alarm, rigcal_real by,
                    const rigcal_real h[6])
{
    rigcal_real p[6];
    rc_vec3_scale(p, by * alarm->move_rad, h);
    rc_vec3_scale(&p[3], by * alarm->move_t, &h[3]);
    rc_vec3_add(&body[FRAME], p);
    rc_vec3_add(&body[FRAME + 3], &p[3]);
    add_outer(&body[FRAME_H], 1, p);
    body[ROWS] += 1;
}

void rc_alarm_row(rc_alarm *alarm, rigcal_real bodies[], rigcal_real z, rigcal_real sd,
                  size_t a, const rigcal_real h_a[6], size_t b, const rigcal_real h_b[6])
{
    RIGCAL_ASSERT(a != b && a < (size_t)alarm->n_bodies && b < (size_t)alarm->n_bodies);
    RIGCAL_ASSERT(sd > 0);
    const rigcal_real psi = rc_min(rc_max(z, -CLIP), CLIP);
    if (alarm->rows >= NOISE_ROWS) {
        alarm->rows /= 2;
        alarm->squares /= 2;
    }
    alarm->rows += 1;
    alarm->squares += psi * psi;
    add_row(body_of(bodies, a), alarm, psi / sd, h_a);
    add_row(body_of(bodies, b), alarm, psi / sd, h_b);
}

/* ---- the end of a frame ------------------------------------------------------ */

/* log of a sum of n >= 1 numbers whose logs these are. */
static rigcal_real log_of_sum(const rigcal_real logs[], size_t n, size_t step)
{
    rigcal_real most = logs[0], sum = 0;
    for (size_t k = 1; k < n; k++) {
        most = rc_max(most, logs[k * step]);
    }
    for (size_t k = 0; k < n; k++) {
        sum += rc_exp(logs[k * step] - most);
    }
    return most + rc_log(sum);
}

/* What varies, of a frame: with `common` the rows of one frame err together. */
static void weigh_frame(rigcal_real body[], rigcal_real common)
{
    for (int k = 0; k < 21; k++) {
        body[FRAME_H + k] *= 1 - common;
    }
    add_outer(&body[FRAME_H], common, &body[FRAME]);
}

/* Adds the frame to a window, G and H alike. */
static void add_frame(rigcal_real window[], const rigcal_real frame[RC_ALARM_SUMS])
{
    for (int k = 0; k < RC_ALARM_SUMS; k++) {
        window[k] += frame[k];
    }
}

/* Measures M by the longest window and starts all windows with it. */
static void measure(rigcal_real body[])
{
    const rigcal_real *const sum = &body[(RC_ALARM_WINDOWS - 1) * RC_ALARM_WINDOW + H];
    for (int k = 0; k < 21; k++) {
        body[M + k] = sum[k] / body[SINCE];
    }
    if (!rc_all_within(&body[M], 21, RC_MAX)) {
        rc_clear(&body[M], 21);
    }
    body[MEASURED] = body[SINCE];
    body[ROWS_BEFORE] = body[ROWS];
    body[ROWS] = 0;
    start_windows(body);
}

/* Starts the windows anew whose last frame this was, but for the longest. */
static void end_windows(rigcal_real body[])
{
    const int32_t frames = (int32_t)body[SINCE];
    for (int window = 0; window + 1 < RC_ALARM_WINDOWS; window++) {
        if (frames % LENGTH(window) == 0) {
            rc_clear(&body[window * RC_ALARM_WINDOW], HALF_LOG_W);
        }
    }
}

/* A body's windows take the frame in; its part of the sum. */
static void end_body(rigcal_real body[], const rc_alarm *alarm)
{
    rigcal_real logs[RC_ALARM_WINDOWS];
    const rigcal_real parts = (rigcal_real)(alarm->n_bodies * RC_ALARM_WINDOWS);
    weigh_frame(body, alarm->common);
    for (int window = 0; window < RC_ALARM_WINDOWS; window++) {
        add_frame(&body[window * RC_ALARM_WINDOW], &body[FRAME]);
        logs[window] = log_lambda(body, window) + (rigcal_real)window * LOG_4;
    }
    rc_clear(&body[FRAME], RC_ALARM_SUMS);
    body[LOG_SUM] = log_of_sum(logs, RC_ALARM_WINDOWS, 1) - rc_log(parts);
    body[SINCE] += 1;
}

rigcal_real rc_alarm_frame(rc_alarm *alarm, rigcal_real bodies[])
{
    int has_measured = 0;
    for (size_t b = 0; b < (size_t)alarm->n_bodies; b++) {
        rigcal_real *const body = body_of(bodies, b);
        end_body(body, alarm);
        const int is_time =
            body[SINCE] >= GROWTH * body[MEASURED] || body[SINCE] >= RC_ALARM_LONGEST;
        if (is_time && !has_measured) {
            measure(body);
            has_measured = 1;
        } else {
            end_windows(body);
        }
    }
    alarm->log_sum = log_of_sum(&bodies[LOG_SUM], (size_t)alarm->n_bodies, RC_ALARM_BODY);
    return alarm->log_sum - alarm->log_limit;
}

/* ---- what it says ------------------------------------------------------------ */

rigcal_real rc_alarm_share(const rc_alarm *alarm, const rigcal_real bodies[], size_t body)
{
    return rc_exp(body_in(bodies, body)[LOG_SUM] - alarm->log_sum);
}

int rc_alarm_is_blind(const rigcal_real bodies[], size_t body)
{
    const rigcal_real *const at = body_in(bodies, body);
    return rc_max(at[ROWS], at[ROWS_BEFORE]) < SEEING_ROWS;
}

/* x^2 = 2 log(A K B / L) / (e . H e), for the e of least e . H e. */
rigcal_real rc_alarm_smallest(const rc_alarm *alarm, const rigcal_real bodies[],
                              size_t body)
{
    const rigcal_real *const at = body_in(bodies, body), *const turns = &at[M];
    const rigcal_real longest = RC_ALARM_LONGEST;
    const rigcal_real parts = (rigcal_real)(alarm->n_bodies * RC_ALARM_WINDOWS) / longest;
    const rigcal_real wanted = 2 * (alarm->log_limit + rc_log(parts));
    rigcal_real axis[3], seen[3], thickness;
    if (rc_alarm_is_blind(bodies, body) || !(wanted > 0) ||
        !rc_sym3_thinnest(axis, &thickness, turns)) {
        return 0;
    }
    rc_sym3_mul_vec3(seen, turns, axis);
    const rigcal_real least = longest * rc_vec3_dot(axis, seen);
    return least > 0 ? alarm->move_rad * RC_SQRT(wanted / least) : 0;
}

rigcal_real rc_alarm_noise(const rc_alarm *alarm)
{
    return alarm->rows > 0 ? RC_SQRT(alarm->squares / alarm->rows) / CLIPPED_RMS : 0;
}
