#include "rc_alarm.h"

#include "rc_logs.h"

/* ---- constants ----------------------------------------------------------- */

/* frames: log of 4. Window i starts anew after 4^i frames and finds moves that show in
 * about as many frames. Powers of 2 needed twice the windows and raised no alarm sooner. */
#define LOG_4 RC(1.38629436111989061883)

/* standard deviations: innovations are clipped here. Huber's value: normal noise loses 5 %
 * of its information, and a wrong match pulls no more than this. */
#define CLIP RC(1.345)

/* 1: rms of normal noise that is clipped at CLIP. */
#define CLIPPED_RMS RC(0.842713)

/* 1: a window expects moves whose precision is (its length / this) times the information of
 * a frame. So it expects moves of sqrt(8) of its own standard deviations. */
#define EXPECTED RC(8)

/* part of the diagonal: a direction that no row sees gets this part of what the others
 * have. */
#define UNSEEN RC(1e-3)

/* 1: A is the mean time between false alarms, times 1 + common, over this. A is a bound
 * that noise does not reach: counted were 0.4 to 1.2 of the stated number of false alarms
 * (BENCHMARKS.md). Matches of real boards err together and need the factor 1 + common. */
#define SLACK RC(2.5)

/* 1: M is measured again when there are this many times as many frames as it was measured
 * by. */
#define GROWTH 4

/* 1: a window counts if its rows are this many times the square of the log that it must
 * reach. With fewer rows it takes its share of the weight and hardly ever raises the alarm.
 * With 5 matches a frame of 8 cameras, false alarms were a tenth of the stated number. */
#define ENOUGH RC(1.5)

/* rows^2: if a body has few rows a frame, even its longest windows lose by them. Its part
 * of the sum is multiplied by 1 + this / rows^2. Without it 5 rows a frame of 4 cameras
 * made a third of the stated alarms. */
#define SPARSE RC(5)

/* rows: a body with fewer a frame counts as having this many. Its part of the sum is
 * multiplied by 1.8 at most. */
#define FEWEST RC(2.5)

/* rows: a body with fewer in the longest window is blind. A move has six unknowns. */
#define SEEING_ROWS 6

/* 1: the least sum whose log is taken. The sum is 0 if no window's Lambda exceeds 1. */
#define LAMBDA_LEAST RC(1e-30)

/* rows: the noise is measured over about this many recent rows. */
#define NOISE_ROWS RC(4096)

/* 1: 2^50. The product of each three inverse roots of W + H is scaled by it, so that the
 * product of all six stays within float. W + H may be 1e18. */
#define SCALE RC(1125899906842624.0)

/* part of an element of the diagonal: a smaller pivot is rounding. */
#define RANK_TOL (8 * RC_EPS)

/* Number of frames of a window. */
#define LENGTH(window) ((int32_t)1 << (2 * (window)))

/* Numbers of a window. The first window is the current frame: its H is without W. */
enum {
    G = 0, /* sum of g */
    H = 6, /* W plus the sum of h */
    SUMS = 27,
    ROOT_W = SUMS /* the root of |W|, over 2^100 */
};

/* Numbers of a body, after those of its windows. */
enum {
    M = RC_ALARM_WINDOWS * RC_ALARM_WINDOW, /* the mean of h of a frame */
    MEASURED = M + 21,                      /* number of frames in the mean M; 0: M is 0 */
    SINCE,                                  /* frames since the longest window began */
    ROWS, /* rows in the longest window; in the one before */
    ROWS_BEFORE,
    SMALLEST, /* smallest turn noticed, as M gives it [parts of the largest move] */
    LOG_SUM   /* log of the body's part of the sum */
};

static rigcal_real *body_of(rigcal_real bodies[], size_t body)
{
    return &bodies[body * RC_ALARM_BODY];
}

static const rigcal_real *body_in(const rigcal_real bodies[], size_t body)
{
    return &bodies[body * RC_ALARM_BODY];
}

/* ---- windows --------------------------------------------------------------- */

/* A += s x x^T, written out: this takes a third of the instructions of loops over
 * blocks. */
static void add_outer(rigcal_real A[21], rigcal_real s, const rigcal_real x[6])
{
    const rigcal_real x0 = x[0], x1 = x[1], x2 = x[2], x3 = x[3], x4 = x[4], x5 = x[5];
    const rigcal_real s0 = s * x0, s1 = s * x1, s2 = s * x2;
    const rigcal_real s3 = s * x3, s4 = s * x4;
    A[0] += s0 * x0;
    A[1] += s0 * x1;
    A[2] += s0 * x2;
    A[3] += s1 * x1;
    A[4] += s1 * x2;
    A[5] += s2 * x2;
    rigcal_real *const across = &A[RC_SYM6_ACROSS];
    across[0] += s0 * x3;
    across[1] += s0 * x4;
    across[2] += s0 * x5;
    across[3] += s1 * x3;
    across[4] += s1 * x4;
    across[5] += s1 * x5;
    across[6] += s2 * x3;
    across[7] += s2 * x4;
    across[8] += s2 * x5;
    rigcal_real *const second = &A[RC_SYM6_SECOND];
    second[0] += s3 * x3;
    second[1] += s3 * x4;
    second[2] += s3 * x5;
    second[3] += s4 * x4;
    second[4] += s4 * x5;
    second[5] += s * x5 * x5;
}

/* W = length / EXPECTED (M + UNSEEN diag M) + 1, in units of the largest move. */
static void expect(rigcal_real W[21], const rigcal_real body[], rigcal_real length)
{
    static const uint8_t DIAGONAL[6] = {0, 3, 5, 15, 18, 20};
    const rigcal_real share = length / EXPECTED;
    for (int k = 0; k < 21; k++) {
        W[k] = share * body[M + k];
    }
    for (int k = 0; k < 6; k++) {
        W[DIAGONAL[k]] += share * UNSEEN * body[M + DIAGONAL[k]] + 1;
    }
}

/* Replaces a matrix of two blocks by its factor. Returns 0 if it is not finite, or if
 * rounding has made it not positive definite. Otherwise W keeps it positive definite. */
static int factor(rigcal_real A[21])
{
    rigcal_real *const across = &A[RC_SYM6_ACROSS], *const B = &A[RC_SYM6_SECOND];
    const rigcal_real diagonal[6] = {A[0], A[3], A[5], B[0], B[3], B[5]};
    if (!rc_sym3_factor(A, A, diagonal, RANK_TOL)) {
        return 0;
    }
    for (int j = 0; j < 3; j++) {
        rigcal_real x[3] = {across[j], across[3 + j], across[6 + j]};
        rc_sym3_forward(x, A);
        across[j] = x[0];
        across[3 + j] = x[1];
        across[6 + j] = x[2];
    }
    for (int k = 0; k < 9; k += 3) {
        const rigcal_real x = across[k], y = across[k + 1], z = across[k + 2];
        B[0] -= x * x;
        B[1] -= x * y;
        B[2] -= x * z;
        B[3] -= y * y;
        B[4] -= y * z;
        B[5] -= z * z;
    }
    return rc_sym3_factor(B, B, &diagonal[3], RANK_TOL);
}

/* 2^100 / |A|^(1/2) from the factor of A. A is 1 or more, so this does not overflow. */
static rigcal_real inverse_root(const rigcal_real L[21])
{
    const rigcal_real *const B = &L[RC_SYM6_SECOND];
    return SCALE * L[0] * L[3] * L[5] * (SCALE * B[0] * B[3] * B[5]);
}

/* |L^-1 x|^2 */
static rigcal_real square_of(const rigcal_real L[21], const rigcal_real x[6])
{
    rigcal_real y[3], z[3];
    rc_vec3_copy(y, x);
    rc_vec3_copy(z, &x[3]);
    rc_sym3_forward(y, L);
    for (int k = 0; k < 3; k++) {
        rc_vec3_add_scaled(z, -y[k], &L[RC_SYM6_ACROSS + 3 * k]);
    }
    rc_sym3_forward(z, &L[RC_SYM6_SECOND]);
    return rc_vec3_dot(y, y) + rc_vec3_dot(z, z);
}

/* Starts window i >= 1 with the next frame. */
static void start_window(rigcal_real body[], int i)
{
    rc_clear(&body[i * RC_ALARM_WINDOW], H);
    expect(&body[i * RC_ALARM_WINDOW + H], body, (rigcal_real)LENGTH(i));
}

/* Starts all windows with the next frame. Returns 0 if rounding leaves a W that cannot be
 * factored. */
static int start_windows(rigcal_real body[])
{
    rigcal_real W[21];
    int is_right = 1;
    rc_clear(body, SUMS);
    for (int i = 0; i < RC_ALARM_WINDOWS; i++) {
        expect(W, body, (rigcal_real)LENGTH(i));
        const int is_factored = factor(W);
        const rigcal_real root = is_factored ? inverse_root(W) : 0;
        is_right &= is_factored;
        body[i * RC_ALARM_WINDOW + ROOT_W] = RC_MAX * root > 1 ? 1 / root : 0;
        if (i > 0) {
            start_window(body, i);
        }
    }
    body[SINCE] = 0;
    return is_right;
}

/* ---- begin ----------------------------------------------------------------- */

void rc_alarm_begin(rc_alarm *alarm, rigcal_real bodies[], size_t n_bodies,
                    rigcal_real arl0_frames, rigcal_real common, rigcal_real move_rad,
                    rigcal_real move_t)
{
    RIGCAL_ASSERT(n_bodies >= 2 && n_bodies <= INT16_MAX);
    RIGCAL_ASSERT(arl0_frames >= 100 && common >= 0 && common <= 1);
    RIGCAL_ASSERT(move_rad > 0 && move_t > 0);
    alarm->n_bodies = (int32_t)n_bodies;
    alarm->common = common;
    alarm->log_limit = rc_log(arl0_frames * (1 + common) / SLACK * (rigcal_real)n_bodies *
                              RC_ALARM_WINDOWS);
    alarm->move_rad = move_rad;
    alarm->move_t = move_t;
    alarm->rows = alarm->squares = 0;
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
    (void)start_windows(at);
}

void rc_alarm_again(rc_alarm *alarm, rigcal_real bodies[])
{
    for (size_t b = 0; b < (size_t)alarm->n_bodies; b++) {
        rigcal_real *const at = body_of(bodies, b);
        (void)start_windows(at);
    }
}

rigcal_real *rc_alarm_lent(rigcal_real bodies[], size_t body)
{
    return body_of(bodies, body);
}

/* ---- a row ----------------------------------------------------------------- */

/* Adds p to g and p p^T to H of the frame. p = D h psi / sd; turn and shift are the factors
 * of its two halves. */
static void add_row(rigcal_real body[], rigcal_real turn, rigcal_real shift,
                    const rigcal_real h[6])
{
    const rigcal_real p[6] = {turn * h[0],  turn * h[1],  turn * h[2],
                              shift * h[3], shift * h[4], shift * h[5]};
    rigcal_real *const g = &body[G];
    g[0] += p[0];
    g[1] += p[1];
    g[2] += p[2];
    g[3] += p[3];
    g[4] += p[4];
    g[5] += p[5];
    body[ROWS] += 1;
    add_outer(&body[H], 1, p);
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
    const rigcal_real by = psi / sd;
    const rigcal_real turn = by * alarm->move_rad, shift = by * alarm->move_t;
    add_row(body_of(bodies, a), turn, shift, h_a);
    add_row(body_of(bodies, b), turn, shift, h_b);
}

/* ---- the end of a frame ------------------------------------------------------ */

rigcal_real rc_alarm_log_sum(const rc_alarm *alarm, const rigcal_real bodies[])
{
    const size_t n = (size_t)alarm->n_bodies;
    rigcal_real most = body_in(bodies, 0)[LOG_SUM], sum = 0;
    for (size_t b = 1; b < n; b++) {
        most = rc_max(most, body_in(bodies, b)[LOG_SUM]);
    }
    for (size_t b = 0; b < n; b++) {
        sum += rc_exp(body_in(bodies, b)[LOG_SUM] - most);
    }
    return most + rc_log(sum);
}

/* Replaces the part `common` of the frame's H by g g^T, because this share of the errors is
 * the same in all rows of a frame. */
static void weigh_frame(rigcal_real body[], rigcal_real common)
{
    for (int k = 0; k < 21; k++) {
        body[H + k] *= 1 - common;
    }
    add_outer(&body[H], common, &body[G]);
}

/* The smallest turn that the longest window would notice with M, over the largest move: x^2
 * = 2 log(A K B / L) / (e . H e), for the axis e of least e . H e. 0: it notices none. A K
 * B is at least 100 / SLACK 5 2, which is more than L = 256. */
static rigcal_real smallest_of(const rigcal_real turns[6], rigcal_real log_limit)
{
    const rigcal_real longest = RC_ALARM_LONGEST;
    const rigcal_real wanted = 2 * (log_limit - rc_log(longest));
    rigcal_real axis[3], seen[3], thickness;
    if (!rc_sym3_thinnest(axis, &thickness, turns)) {
        return 0;
    }
    rc_sym3_mul_vec3(seen, turns, axis);
    const rigcal_real least = longest * rc_vec3_dot(axis, seen);
    return least > 0 ? RC_SQRT(wanted / least) : 0;
}

/* Measures M from the longest window and starts all windows with it. M becomes 0 if
 * rounding leaves a W that cannot be factored. */
static void measure(rigcal_real body[], rigcal_real log_limit)
{
    const int longest = RC_ALARM_WINDOWS - 1;
    const rigcal_real *const sum = &body[longest * RC_ALARM_WINDOW + H];
    rigcal_real W[21];
    expect(W, body, (rigcal_real)LENGTH(longest));
    for (int k = 0; k < 21; k++) {
        body[M + k] = (sum[k] - W[k]) / body[SINCE];
    }
    body[MEASURED] = body[SINCE];
    if (!start_windows(body)) {
        rc_clear(&body[M], 21);
        (void)start_windows(body);
    }
    body[SMALLEST] = smallest_of(&body[M], log_limit);
    body[ROWS_BEFORE] = body[ROWS];
    body[ROWS] = 0;
}

/* Lambda of a window is *root exp(*exponent). A is W + H, and is overwritten by its
 * factor. */
static void evaluate(rigcal_real *root, rigcal_real *exponent, rigcal_real A[21],
                     const rigcal_real window[])
{
    *root = *exponent = 0;
    if (factor(A)) {
        *exponent = square_of(A, &window[G]) / 2;
        *root = inverse_root(A) * window[ROOT_W];
    }
}

/* Lambda of the first window, the frame. */
static void evaluate_frame(rigcal_real *root, rigcal_real *exponent,
                           const rigcal_real body[])
{
    rigcal_real A[21];
    expect(A, body, 1);
    for (int k = 0; k < 21; k++) {
        A[k] += body[H + k];
    }
    evaluate(root, exponent, A, body);
}

/* Adds the frame to another window, then Lambda of this window. */
static void evaluate_window(rigcal_real *root, rigcal_real *exponent, rigcal_real window[],
                            const rigcal_real frame[])
{
    rigcal_real A[21];
    for (int k = 0; k < H; k++) {
        window[k] += frame[k];
    }
    for (int k = 0; k < 21; k++) {
        const rigcal_real sum = window[H + k] + frame[H + k];
        window[H + k] = sum;
        A[k] = sum;
    }
    evaluate(root, exponent, A, window);
}

/* Number of rows a frame, in the time in which M was measured. */
static rigcal_real rows_of(const rigcal_real body[])
{
    return body[ROWS_BEFORE] / rc_max(body[MEASURED], 1);
}

/* The first window of a body that counts: it and all longer ones have enough rows. Before M
 * is measured all windows are alike, and only the longest counts. */
static int first_of_use(const rigcal_real body[], const rc_alarm *alarm)
{
    const rigcal_real rows = rows_of(body);
    rigcal_real wanted = alarm->log_limit;
    int i = 0;
    while (i + 1 < RC_ALARM_WINDOWS &&
           (rigcal_real)LENGTH(i) * rows < ENOUGH * wanted * wanted) {
        wanted -= LOG_4;
        i++;
    }
    return body[MEASURED] > 0 ? i : RC_ALARM_WINDOWS - 1;
}

/* The factor of a body's sum if n_windows windows count. */
static rigcal_real weight_of(const rigcal_real body[], int n_windows)
{
    const rigcal_real rows = rc_max(rows_of(body), FEWEST);
    return RC_ALARM_WINDOWS / (rigcal_real)n_windows * (1 + SPARSE / (rows * rows));
}

/* Adds the frame to a body's windows and computes its part of the sum. Windows that do not
 * count stay as they are. Which ones count changes only with M, when all windows start
 * anew. */
static void end_body(rigcal_real body[], const rc_alarm *alarm)
{
    rigcal_real root[RC_ALARM_WINDOWS] = {0}, exponent[RC_ALARM_WINDOWS] = {0};
    const int first = first_of_use(body, alarm);
    rigcal_real most = 0, sum = 0;
    weigh_frame(body, alarm->common);
    for (int i = first; i < RC_ALARM_WINDOWS; i++) {
        if (i == 0) {
            evaluate_frame(&root[i], &exponent[i], body);
        } else {
            evaluate_window(&root[i], &exponent[i], &body[i * RC_ALARM_WINDOW], body);
        }
        most = rc_max(most, exponent[i]);
    }
    const rigcal_real one = rc_exp(-most);
    for (int i = first; i < RC_ALARM_WINDOWS; i++) {
        sum +=
            (rigcal_real)LENGTH(i) * rc_max(0, root[i] * rc_exp(exponent[i] - most) - one);
    }
    sum *= weight_of(body, RC_ALARM_WINDOWS - first);
    body[LOG_SUM] = most + rc_log(rc_max(sum, LAMBDA_LEAST));
    body[SINCE] += 1;
}

/* Starts the windows anew that end with this frame, except the longest. `zero` is 0; the
 * compiler must not know it, or it calls the C library's memset, which is slow. */
static void end_windows(rigcal_real body[], rigcal_real zero)
{
    const int32_t frames = (int32_t)body[SINCE];
    for (int i = 1; i + 1 < RC_ALARM_WINDOWS && frames % LENGTH(i) == 0; i++) {
        start_window(body, i);
    }
    for (int k = 0; k < SUMS; k++) {
        body[k] = zero;
    }
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
            measure(body, alarm->log_limit);
            has_measured = 1;
        } else {
            end_windows(body, alarm->rows - alarm->rows);
        }
    }
    return rc_alarm_log_sum(alarm, bodies) - alarm->log_limit;
}

/* ---- what it says ------------------------------------------------------------ */

rigcal_real rc_alarm_share(const rigcal_real bodies[], size_t body, rigcal_real log_sum)
{
    return rc_min(1, rc_exp(body_in(bodies, body)[LOG_SUM] - log_sum));
}

int rc_alarm_is_blind(const rigcal_real bodies[], size_t body)
{
    const rigcal_real *const at = body_in(bodies, body);
    return rc_max(at[ROWS], at[ROWS_BEFORE]) < SEEING_ROWS;
}

rigcal_real rc_alarm_smallest(const rc_alarm *alarm, const rigcal_real bodies[],
                              size_t body)
{
    return rc_alarm_is_blind(bodies, body)
               ? 0
               : alarm->move_rad * body_in(bodies, body)[SMALLEST];
}

rigcal_real rc_alarm_noise(const rc_alarm *alarm)
{
    return alarm->rows > 0 ? RC_SQRT(alarm->squares / alarm->rows) / CLIPPED_RMS : 0;
}
