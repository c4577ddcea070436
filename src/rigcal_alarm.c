#include "rc_alarm.h"

#include "rc_logs.h"

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

/* 1: the least sum that a log is taken of, where all windows were refused. */
#define LAMBDA_LEAST RC(1e-30)

/* rows: the noise is told by about so many of late. */
#define NOISE_ROWS RC(4096)

/* 1: 2^50. Three inverse roots of the elements of W + H are scaled by it, so that the
 * product of all six stays within float: W + H may be 1e18. */
#define SCALE RC(1125899906842624.0)

/* part of an element of the diagonal: a smaller pivot is rounding. */
#define RANK_TOL (8 * RC_EPS)

/* Numbers of a body, in the order in which they are held. */
enum {
    G = 0,                                      /* of a window: sum of g */
    H = 6,                                      /* of a window: what that sum varies by */
    ROOT_W = 27,                                /* |W|^(1/2), scaled */
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

/* What body[M] says of moves, in units of the largest: W of a window of length L is
 * L base + 1. */
static void base_of(rigcal_real base[21], const rigcal_real body[])
{
    for (int k = 0; k < 21; k++) {
        base[k] = body[M + k] / EXPECTED;
    }
    for (int k = 0; k < 6; k++) {
        base[DIAGONAL[k]] *= 1 + UNSEEN;
    }
}

/* L L^T of W + H, H standing in L: W is positive definite, so only rounding can refuse.
 * *scaled: 2^100 / |L|. 0: refused, not finite, or *scaled underflows. */
static int factor(rc_sym6_factor *L, rigcal_real *scaled)
{
    rigcal_real *const A = L->first, *const B = L->second;
    const rigcal_real diagonal[6] = {++A[0], ++A[3], ++A[5], ++B[0], ++B[3], ++B[5]};
    if (!rc_sym3_factor(A, A, diagonal, RANK_TOL)) {
        return 0;
    }
    for (int column = 0; column < 3; column++) {
        rigcal_real x[3] = {L->across[0][column], L->across[1][column],
                            L->across[2][column]};
        rc_sym3_forward(x, A);
        for (int k = 0; k < 3; k++) {
            L->across[k][column] = x[k];
        }
    }
    for (int k = 0; k < 3; k++) {
        rc_sym3_add_outer(B, -1, L->across[k]);
    }
    if (!rc_sym3_factor(B, B, &diagonal[3], RANK_TOL)) {
        return 0;
    }
    *scaled = SCALE * A[0] * A[3] * A[5] * (SCALE * B[0] * B[3] * B[5]);
    return *scaled > 0 && *scaled <= RC_MAX;
}
/* A window takes a frame in, of which it is sums of n numbers; out = W + H, but for the 1. */
static void take(rigcal_real out[], rigcal_real sum[], const rigcal_real frame[],
                 const rigcal_real base[], rigcal_real length, int n)
{
    for (int k = 0; k < n; k++) {
        sum[k] += frame[k];
        out[k] = sum[k] + length * base[k];
    }
}

/* The same of H whole, out being W + H. */
static void take_matrix(rc_sym6_factor *out, rigcal_real sum[21],
                        const rigcal_real frame[21], const rigcal_real base[21],
                        rigcal_real length)
{
    enum { A = RC_SYM6_ACROSS, S = RC_SYM6_SECOND };
    take(out->first, sum, frame, base, length, A);
    take(out->across[0], &sum[A], &frame[A], &base[A], length, S - A);
    take(out->second, &sum[S], &frame[S], &base[S], length, 21 - S);
}

/* All windows of a body start, with W of its M. */
static void start_windows(rigcal_real body[])
{
    rigcal_real base[21];
    base_of(base, body);
    for (int window = 0; window < RC_ALARM_WINDOWS; window++) {
        rigcal_real *const at = &body[window * RC_ALARM_WINDOW];
        rc_sym6_factor L;
        rigcal_real scaled;
        rc_clear(at, RC_ALARM_WINDOW);
        take_matrix(&L, &at[H], &at[H], base, (rigcal_real)LENGTH(window));
        at[ROOT_W] = factor(&L, &scaled) ? 1 / scaled : 0;
    }
    body[SINCE] = 0;
}

/* Lambda of a window is *factor exp(*exponent) once the frame is in. */
static void add_frame(rigcal_real *root, rigcal_real *exponent, rigcal_real window[],
                      const rigcal_real frame[RC_ALARM_SUMS], const rigcal_real base[21],
                      rigcal_real length)
{
    rigcal_real x[6], scaled;
    rc_sym6_factor L;
    for (int k = 0; k < 6; k++) {
        window[G + k] += frame[k];
        x[k] = window[G + k];
    }
    take_matrix(&L, &window[H], &frame[6], base, length);
    *root = *exponent = 0;
    if (factor(&L, &scaled)) {
        rc_sym6_forward(x, &L);
        *exponent = (rc_vec3_dot(x, x) + rc_vec3_dot(&x[3], &x[3])) / 2;
        *root = length * scaled * window[ROOT_W];
    }
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
    alarm->log_limit =
        rc_log(arl0_frames / SLACK * (rigcal_real)n_bodies * RC_ALARM_WINDOWS);
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

/* log of the sum over bodies. */
static rigcal_real log_of_all(const rigcal_real bodies[], size_t n)
{
    rigcal_real most = body_in(bodies, 0)[LOG_SUM], sum = 0;
    for (size_t b = 1; b < n; b++) {
        most = rc_max(most, body_in(bodies, b)[LOG_SUM]);
    }
    for (size_t b = 0; b < n; b++) {
        sum += rc_exp(body_in(bodies, b)[LOG_SUM] - most);
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

/* Measures M by the longest window and starts all windows with it. */
static void measure(rigcal_real body[])
{
    const rigcal_real *const sum = &body[(RC_ALARM_WINDOWS - 1) * RC_ALARM_WINDOW + H];
    for (int k = 0; k < 21; k++) {
        body[M + k] = sum[k] / body[SINCE];
    }
    if (!rc_all_finite(&body[M], 21)) {
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
            rc_clear(&body[window * RC_ALARM_WINDOW], ROOT_W);
        }
    }
}

/* A body's windows take the frame in; its part of the sum. */
static void end_body(rigcal_real body[], const rc_alarm *alarm)
{
    rigcal_real base[21], root[RC_ALARM_WINDOWS], exponent[RC_ALARM_WINDOWS];
    rigcal_real most = 0, sum = 0;
    base_of(base, body);
    weigh_frame(body, alarm->common);
    for (int i = 0; i < RC_ALARM_WINDOWS; i++) {
        add_frame(&root[i], &exponent[i], &body[i * RC_ALARM_WINDOW], &body[FRAME], base,
                  (rigcal_real)LENGTH(i));
        most = rc_max(most, exponent[i]);
    }
    for (int i = 0; i < RC_ALARM_WINDOWS; i++) {
        sum += root[i] * rc_exp(exponent[i] - most);
    }
    rc_clear(&body[FRAME], RC_ALARM_SUMS);
    body[LOG_SUM] = most + rc_log(rc_max(sum, LAMBDA_LEAST));
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
    alarm->log_sum = log_of_all(bodies, (size_t)alarm->n_bodies);
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
    const rigcal_real wanted = 2 * (alarm->log_limit - rc_log(longest));
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
