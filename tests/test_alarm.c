/* alarm: compared with determinants and solutions of dense matrices in double, for windows
 * that store their frames. Also noise of several kinds, moves, bodies that see nothing, and
 * float. */
#include <math.h>
#include <string.h>

#include "rc_alarm.h"
#include "test_support.h"

enum { BODIES = 3, WINDOWS = RC_ALARM_WINDOWS };

#define ARL0 1000.0
#define LIMIT (ARL0 * (1 + common) / 2.5) /* A */
#define MOVE_RAD 0.0524
#define MOVE_T 0.01

static rc_alarm alarm;
static rigcal_real bodies[BODIES * RC_ALARM_BODY];

/* ---- rows ------------------------------------------------------------------- */

typedef struct {
    double z, sd, h[2][6];
    size_t body[2];
} row;

/* A row between two bodies. It shows some hundred standard deviations for a radian, and one
 * direction badly. */
static row row_of(test_rng *rng, double noise)
{
    row r;
    r.body[0] = (size_t)test_uniform(rng, 0, BODIES);
    r.body[1] = (r.body[0] + 1 + (size_t)test_uniform(rng, 0, BODIES - 1)) % BODIES;
    r.z = noise * test_normal(rng);
    r.sd = test_uniform(rng, 1, 1.5);
    for (int side = 0; side < 2; side++) {
        for (int k = 0; k < 6; k++) {
            r.h[side][k] = test_normal(rng) * (k < 3 ? 500 : 2000) * (k == 1 ? 0.05 : 1);
        }
    }
    return r;
}

static rigcal_real share_of(size_t body)
{
    return rc_alarm_share(bodies, body, rc_alarm_log_sum(&alarm, bodies));
}

/* From now on the body's move d is in the rows. */
static void shift(row *r, size_t body, const double d[6])
{
    for (int side = 0; side < 2; side++) {
        for (int k = 0; k < 6 && r->body[side] == body; k++) {
            r->z += r->h[side][k] * d[k] / r->sd;
        }
    }
}

static void feed(const row *r)
{
    rigcal_real h[2][6];
    test_to_real(h[0], r->h[0], 6);
    test_to_real(h[1], r->h[1], 6);
    rc_alarm_row(&alarm, bodies, RC(r->z), RC(r->sd), r->body[0], h[0], r->body[1], h[1]);
}

static void begin(double common)
{
    rc_alarm_begin(&alarm, bodies, BODIES, RC(ARL0), RC(common), RC(MOVE_RAD), RC(MOVE_T));
}

/* Runs frames of n rows. Returns the evidence of the last one; *most is the largest of
 * all. */
static double run(double *most, test_rng *rng, int frames, int n, double noise)
{
    double evidence = 0;
    *most = -1e9;
    for (int f = 0; f < frames; f++) {
        for (int i = 0; i < n; i++) {
            const row r = row_of(rng, noise);
            feed(&r);
        }
        evidence = D(rc_alarm_frame(&alarm, bodies));
        *most = fmax(*most, evidence);
    }
    return evidence;
}

/* ---- the same, densely ------------------------------------------------------ */

typedef struct {
    double G[6], H[6][6], W[6][6];
} window;

typedef struct {
    double g[6], h[6][6], M[6][6];
    window w[WINDOWS];
    int since, measured, rows, rows_before;
} dense;

static dense reference[BODIES];

/* log of the determinant of A, and x A^-1 x, by elimination with pivots. */
static double eliminate(double *square, double A[6][6], const double x[6])
{
    double U[6][7], y[6], log_det = 0;
    for (int i = 0; i < 6; i++) {
        memcpy(U[i], A[i], 6 * sizeof(double));
        U[i][6] = x[i];
    }
    for (int k = 0; k < 6; k++) {
        int best = k;
        for (int i = k + 1; i < 6; i++) {
            best = fabs(U[i][k]) > fabs(U[best][k]) ? i : best;
        }
        for (int j = 0; j < 7; j++) {
            const double swapped = U[k][j];
            U[k][j] = U[best][j];
            U[best][j] = swapped;
        }
        log_det += log(fabs(U[k][k]));
        for (int i = k + 1; i < 6; i++) {
            const double by = U[i][k] / U[k][k];
            for (int j = k; j < 7; j++) {
                U[i][j] -= by * U[k][j];
            }
        }
    }
    *square = 0;
    for (int i = 5; i >= 0; i--) {
        y[i] = U[i][6];
        for (int j = i + 1; j < 6; j++) {
            y[i] -= U[i][j] * y[j];
        }
        y[i] /= U[i][i];
        *square += x[i] * y[i];
    }
    return log_det;
}

static void start(dense *d, int i)
{
    const double length = pow(4, i);
    memset(&d->w[i], 0, sizeof d->w[i]);
    for (int j = 0; j < 6; j++) {
        for (int k = 0; k < 6; k++) {
            d->w[i].W[j][k] = length / 8 * d->M[j][k] * (j == k ? 1.001 : 1) + (j == k);
        }
    }
}

static void begin_reference(void)
{
    memset(reference, 0, sizeof reference);
    for (int b = 0; b < BODIES; b++) {
        for (int i = 0; i < WINDOWS; i++) {
            start(&reference[b], i);
        }
    }
}

static void feed_reference(const row *r)
{
    const double psi = fmax(-1.345, fmin(1.345, r->z));
    for (int side = 0; side < 2; side++) {
        dense *const d = &reference[r->body[side]];
        double p[6];
        d->rows++;
        for (int k = 0; k < 6; k++) {
            p[k] = r->h[side][k] * (k < 3 ? MOVE_RAD : MOVE_T) * psi / r->sd;
            d->g[k] += p[k];
        }
        for (int j = 0; j < 6; j++) {
            for (int k = 0; k < 6; k++) {
                d->h[j][k] += p[j] * p[k];
            }
        }
    }
}

/* Adds a frame to a window. Returns log Lambda. */
static double add_frame(window *w, const dense *d, double common)
{
    double A[6][6], square;
    double zero[6] = {0, 0, 0, 0, 0, 0};
    for (int j = 0; j < 6; j++) {
        w->G[j] += d->g[j];
        for (int k = 0; k < 6; k++) {
            w->H[j][k] += (1 - common) * d->h[j][k] + common * d->g[j] * d->g[k];
            A[j][k] = w->W[j][k] + w->H[j][k];
        }
    }
    const double log_W = eliminate(&square, w->W, zero);
    const double log_A = eliminate(&square, A, w->G);
    return (log_W - log_A + square) / 2;
}

/* A body's part of the sum. Windows count whose rows are 1.5 times the square of the log
 * that they must reach, or more; the longest one always counts. Before M is measured it
 * alone counts. */
static double end_reference_body(dense *d, double common)
{
    double sum = 0, n = 0;
    const double rows = d->measured ? (double)d->rows_before / d->measured : 0;
    for (int i = 0; i < WINDOWS; i++) {
        const double length = pow(4, i), wanted = log(LIMIT * BODIES * WINDOWS / length);
        const double log_lambda = add_frame(&d->w[i], d, common);
        if (length * rows >= 1.5 * wanted * wanted || i + 1 == WINDOWS) {
            sum += length / BODIES * fmax(0, exp(log_lambda) - 1);
            n++;
        }
    }
    memset(d->g, 0, sizeof d->g);
    memset(d->h, 0, sizeof d->h);
    d->since++;
    return sum / n * (1 + 5 / pow(d->measured ? fmax(rows, 2.5) : 2.5, 2));
}

/* Starts the windows of a body that end with a frame. Returns 1 if its M was measured. */
static int restart_reference(dense *d, int may_measure)
{
    if (may_measure && (d->since >= 4 * d->measured || d->since >= 256)) {
        for (int j = 0; j < 6; j++) {
            for (int k = 0; k < 6; k++) {
                d->M[j][k] = d->w[WINDOWS - 1].H[j][k] / d->since;
            }
        }
        d->measured = d->since;
        d->since = 0;
        d->rows_before = d->rows;
        d->rows = 0;
        for (int i = 0; i < WINDOWS; i++) {
            start(d, i);
        }
        return 1;
    }
    for (int i = 0; i + 1 < WINDOWS; i++) {
        if (d->since % (1 << (2 * i)) == 0) {
            start(d, i);
        }
    }
    return 0;
}

static double end_reference(double share[BODIES], double common)
{
    double sum = 0;
    int has_measured = 0;
    for (int b = 0; b < BODIES; b++) {
        share[b] = end_reference_body(&reference[b], common);
        sum += share[b];
        has_measured |= restart_reference(&reference[b], !has_measured);
    }
    for (int b = 0; b < BODIES; b++) {
        share[b] /= sum > 0 ? sum : 1;
    }
    return sum;
}

/* ---- tests ------------------------------------------------------------------ */

/* The least eigenvalue of the first block of A, as a root of its cubic. */
static double least_eigenvalue(double A[6][6])
{
    const double q = (A[0][0] + A[1][1] + A[2][2]) / 3;
    double squares = 0, B[9];
    for (int k = 0; k < 9; k++) {
        B[k] = A[k / 3][k % 3] - (k % 4 == 0 ? q : 0);
        squares += B[k] * B[k];
    }
    const double p = sqrt(squares / 6);
    const double angle = acos(test_determinant(B) / (2 * p * p * p)) / 3;
    return q + 2 * p * cos(angle + 2 * TEST_PI / 3);
}

/* Only each frame of this number, counted from 1, has rows. */
static int rows_every = 1;

/* Compares three runs of frames of n rows. An answer between the runs ends all windows at
 * once. Single frames are off, so that the shortest window says most. */
static void compare(double common, double size, int n, int from, uint64_t seed)
{
    test_rng rng = test_seed(seed);
    const double move[6] = {0.0003 / size, 0, 0.0003 / size, 0, 0, 0};
    const double jump[6] = {0.003 / size, 0, 0.001 / size, 0.0005 / size, 0, 0};
    begin(common);
    begin_reference();
    /* exp of what many rows say of a move would be beyond double */
    const int frames = TEST_ONE_IN > 1 ? 300 : n > 100 && !(common > 0) ? 580 : 900;
    for (int f = 0; f < frames; f++) {
        for (int i = 0; i < n && (f + 1) % rows_every == 0; i++) {
            row r = row_of(&rng, 1);
            for (int k = 0; k < 12; k++) {
                r.h[k / 6][k % 6] *= size;
            }
            if (f >= 600) {
                shift(&r, 1, move);
            } else if (f % 40 == 39 || f == 3) {
                shift(&r, (size_t)(f / 40 % BODIES), jump);
            }
            feed(&r);
            feed_reference(&r);
        }
        double share[BODIES];
        const double expected = end_reference(share, common);
        const double evidence = D(rc_alarm_frame(&alarm, bodies));
        for (size_t b = 0; b < BODIES && f >= from; b++) {
            ASSERT_NEAR(log(1 + expected), log(1 + exp(evidence) * LIMIT), TOL(1e-7, 4e-3));
            if (expected > 1) {
                ASSERT_NEAR(share[b], share_of(b), TOL(1e-6, 1e-2));
            }
        }
        /* all windows are on their way; in the second case all longest ones end at once */
        if (f == 102 || f == 402) {
            rc_alarm_again(&alarm, bodies);
            for (int b = 0; b < BODIES; b++) {
                for (int i = 0; i < WINDOWS; i++) {
                    start(&reference[b], i);
                }
                reference[b].since = 0;
            }
        }
    }
    for (size_t b = 0; b < BODIES; b++) {
        const double wanted = 2 * log(LIMIT * BODIES * WINDOWS / 256);
        const double least = 256 * least_eigenvalue(reference[b].M);
        const double smallest = MOVE_RAD * sqrt(wanted / least);
        ASSERT_NEAR(1, D(rc_alarm_smallest(&alarm, bodies, b)) / smallest, TOL(1e-6, 1e-2));
    }
}

static void test_the_evidence_is_that_of_dense_determinants(void)
{
    compare(0, 1, 8, 0, 1);
    compare(0.5, 1, 8, 0, 2);
    compare(1, 1, 8, 0, 3);
}

/* With this many rows one frame alone may raise the alarm, so all windows count. */
static void test_the_evidence_is_right_where_a_frame_has_many_rows(void)
{
    TEST_ON_HOST_ONLY("480000 rows");
    compare(0.5, 1, 250, 0, 11);
    compare(0, 1, 250, 0, 15);
    compare(0, 1, 60, 0, 13); /* the window of four frames is the first one */
    compare(0, 1, 60, 0, 14);
}

/* One row in four frames: no window has enough of them, and the longest alone counts. */
static void test_the_evidence_is_right_where_rows_are_rare(void)
{
    rows_every = 4;
    compare(0.5, 30, 1, 20, 16);
    rows_every = 1;
}

/* Rows with two thousand times the information: the determinants are beyond the range of
 * float. Before M is measured, float cannot hold the 1 of W beside H. */
static void test_the_evidence_is_right_where_rows_say_very_much(void)
{
    compare(0.5, 2000, 8, 20, 4);
}

/* exp(900) is beyond the range of double, exp(90) beyond that of float. */
static void test_evidence_beyond_all_exponents_is_a_number(void)
{
    test_rng rng = test_seed(4);
    const double move[6] = {0.02, 0.01, 0.02, 0, 0, 0};
    double most;
    begin(0);
    (void)run(&most, &rng, 400, 20, 1);
    rc_alarm_again(&alarm, bodies);
    for (int f = 0; f < 200; f++) {
        for (int i = 0; i < 40; i++) {
            row r = row_of(&rng, 1);
            shift(&r, 2, move);
            feed(&r);
        }
        most = D(rc_alarm_frame(&alarm, bodies));
        TEST_ASSERT_TRUE(most < 1e5);
    }
    TEST_ASSERT_TRUE(most > 750);
    ASSERT_NEAR(1, share_of(2), 1e-3);
    ASSERT_NEAR(0, share_of(0), 1e-3);
    ASSERT_NEAR(0, share_of(1), 1e-3);
}

/* Numbers whose squares overflow, or only whose determinant overflows, raise no alarm, and
 * are forgotten when their window ends. */
static void test_rows_that_overflow_raise_no_alarm_and_are_forgotten(void)
{
    const double sizes[2] = {TOL(1e200, 1e25), TOL(1e120, 1e16)};
    for (int trial = 0; trial < 2; trial++) {
        test_rng rng = test_seed(5);
        double most;
        begin(0.5);
        (void)run(&most, &rng, 30, 10, 1);
        row r = row_of(&rng, 1);
        for (int k = 0; k < 6; k++) {
            r.h[0][k] = sizes[trial];
        }
        feed(&r);
        for (int f = 0; f < 600; f++) {
            (void)run(&most, &rng, 1, 10, 1);
            TEST_ASSERT_TRUE(most < 0);
        }
        for (size_t b = 0; b < BODIES; b++) {
            TEST_ASSERT_TRUE(rc_alarm_smallest(&alarm, bodies, b) > 0);
        }
    }
}

/* A window whose determinant overflows counts for nothing, as one without rows does: here
 * that of all bodies, in each of their windows. */
static void test_a_window_that_overflows_says_nothing(void)
{
    test_rng rng = test_seed(17);
    begin(0.5);
    for (size_t b = 0; b < BODIES; b++) {
        row r = row_of(&rng, 1);
        r.body[0] = b;
        r.body[1] = (b + 1) % BODIES;
        for (int k = 0; k < 12; k++) {
            r.h[k / 6][k % 6] = TOL(1e200, 1e25);
        }
        feed(&r);
    }
    TEST_ASSERT_TRUE(rc_alarm_frame(&alarm, bodies) < -50);
    for (size_t b = 0; b < BODIES; b++) {
        ASSERT_NEAR(1.0 / BODIES, share_of(b), TOL(1e-12, 1e-5));
    }
}

/* Turns about the second axis, or about two or all three, change no row. */
static void test_no_turn_about_an_axis_that_is_not_seen_would_be_noticed(void)
{
    static const int UNSEEN[3][3] = {{0, 1, 0}, {0, 1, 1}, {1, 1, 1}};

    for (int k = 0; k < 3; k++) {
        test_rng rng = test_seed(12);
        begin(0);
        for (int f = 0; f < 300; f++) {
            for (int i = 0; i < 10; i++) {
                row r = row_of(&rng, 1);
                for (int axis = 0; axis < 3; axis++) {
                    if (UNSEEN[k][axis]) {
                        r.h[0][axis] = r.h[1][axis] = 0;
                    }
                }
                feed(&r);
            }
            (void)rc_alarm_frame(&alarm, bodies);
        }
        for (size_t b = 0; b < BODIES; b++) {
            TEST_ASSERT_FALSE(rc_alarm_is_blind(bodies, b));
            ASSERT_NEAR(0, rc_alarm_smallest(&alarm, bodies, b), 0);
        }
    }
}

static void test_a_frame_without_rows_says_nothing(void)
{
    begin(0.5);
    for (int f = 0; f < 300; f++) {
        TEST_ASSERT_TRUE(rc_alarm_frame(&alarm, bodies) < -50);
        ASSERT_NEAR(1.0 / BODIES, share_of(1), TOL(1e-12, 1e-5));
        TEST_ASSERT_TRUE(rc_alarm_is_blind(bodies, 0));
        ASSERT_NEAR(0, rc_alarm_smallest(&alarm, bodies, 0), 0);
    }
    ASSERT_NEAR(0, rc_alarm_noise(&alarm), 0);
}

/* Body 2 is no longer seen: after two of the longest windows it is blind. Soon after it is
 * seen again, it is not. */
static void test_a_body_without_rows_is_blind_and_sees_again(void)
{
    test_rng rng = test_seed(6);
    double most;
    begin(0.5);
    for (int f = 0; f < 300; f++) {
        (void)run(&most, &rng, 1, 6, 1);
        for (size_t b = 0; b < BODIES; b++) {
            TEST_ASSERT_TRUE(f < 5 || !rc_alarm_is_blind(bodies, b));
        }
    }
    for (int f = 0; f < 520; f++) {
        row r = row_of(&rng, 1);
        r.body[0] = 0;
        r.body[1] = 1;
        feed(&r);
        (void)rc_alarm_frame(&alarm, bodies);
    }
    TEST_ASSERT_FALSE(rc_alarm_is_blind(bodies, 0));
    TEST_ASSERT_FALSE(rc_alarm_is_blind(bodies, 1));
    TEST_ASSERT_TRUE(rc_alarm_is_blind(bodies, 2));
    ASSERT_NEAR(0, rc_alarm_smallest(&alarm, bodies, 2), 0);
    (void)run(&most, &rng, 5, 20, 1);
    TEST_ASSERT_FALSE(rc_alarm_is_blind(bodies, 2));
}

/* The rms of min(|z|, 1.345) of a normal z, integrated here, is 1. */
static double clipped_rms(double noise)
{
    double sum = 0;
    const double step = 1e-3;
    for (double z = -12 + step / 2; z < 12; z += step) {
        const double psi = fmin(1.345, noise * fabs(z));
        sum += step * exp(-z * z / 2) / sqrt(2 * TEST_PI) * psi * psi;
    }
    return sqrt(sum);
}

static void test_one_row_has_a_noise(void)
{
    test_rng rng = test_seed(18);
    row r = row_of(&rng, 1);
    begin(0.5);
    r.z = 0.5;
    feed(&r);
    (void)rc_alarm_frame(&alarm, bodies);
    ASSERT_NEAR(0.5 / clipped_rms(1), rc_alarm_noise(&alarm), TOL(1e-5, 1e-5));
}

static void test_noise_is_the_clipped_rms_over_that_of_normal_noise_as_stated(void)
{
    TEST_ON_HOST_ONLY("a rms of few rows says nothing");
    for (int k = 0; k < 3; k++) {
        const double noise = 0.5 * (1 << k);
        test_rng rng = test_seed(7);
        double most;
        begin(0.5);
        (void)run(&most, &rng, 400, 20, noise);
        ASSERT_NEAR(clipped_rms(noise) / clipped_rms(1), rc_alarm_noise(&alarm), 0.02);
    }
}

/* A turn of twice the stated size, about the axis that is seen worst, raises the alarm
 * within the longest window. A turn of a fifth of it does not. */
static void test_the_smallest_turn_is_noticed_where_it_is_twice_as_large(void)
{
    TEST_ON_HOST_ONLY("thousands of frames");
    int found[2] = {0, 0};
    for (int trial = 0; trial < 40; trial++) {
        test_rng rng = test_seed(100 + (uint64_t)trial);
        double most, smallest, move[6] = {0, 0, 0, 0, 0, 0};
        rc_alarm_begin(&alarm, bodies, BODIES, RC(1e5), 0, RC(MOVE_RAD), RC(MOVE_T));
        (void)run(&most, &rng, 700, 20, 1);
        rc_alarm_again(&alarm, bodies);
        smallest = D(rc_alarm_smallest(&alarm, bodies, 1));
        move[1] = smallest * (trial % 2 ? 0.2 : 2); /* the rows of row_of show turns about
                                                       this axis worst */
        double evidence = -1;
        for (int f = 0; f < 256 && evidence < 0; f++) {
            for (int i = 0; i < 20; i++) {
                row r = row_of(&rng, 1);
                shift(&r, 1, move);
                feed(&r);
            }
            evidence = D(rc_alarm_frame(&alarm, bodies));
        }
        found[trial % 2] += evidence >= 0;
    }
    TEST_ASSERT_TRUE(found[0] >= 19);
    TEST_ASSERT_TRUE(found[1] <= 1);
}

/* After the answer the evidence is as at first, whatever the trials wrote into the memory.
 * What was measured of the rows stays. */
static void test_after_the_answer_windows_start_with_what_was_measured(void)
{
    test_rng rng = test_seed(8);
    double most;
    begin(0.5);
    (void)run(&most, &rng, 500, 10, 1);
    const double smallest = D(rc_alarm_smallest(&alarm, bodies, 0));
    for (size_t b = 0; b < BODIES; b++) {
        memset(rc_alarm_lent(bodies, b), 0xa5, RC_ALARM_WINDOW * sizeof(rigcal_real));
    }
    rc_alarm_again(&alarm, bodies);
    ASSERT_NEAR(smallest, rc_alarm_smallest(&alarm, bodies, 0), 0);
    TEST_ASSERT_TRUE(rc_alarm_frame(&alarm, bodies) < -50);
    rc_alarm_forget(&alarm, bodies, 0);
    TEST_ASSERT_TRUE(rc_alarm_is_blind(bodies, 0));
    TEST_ASSERT_FALSE(rc_alarm_is_blind(bodies, 1));
}

/* A copy continues in the same way as the original. */
static void test_the_state_can_be_copied(void)
{
    static rigcal_real kept[BODIES * RC_ALARM_BODY];
    test_rng rng = test_seed(9);
    double most;
    begin(0.5);
    (void)run(&most, &rng, 100, 10, 1);
    memcpy(kept, bodies, sizeof kept);
    const rc_alarm alarm_kept = alarm;
    const test_rng rng_kept = rng;
    const double evidence = run(&most, &rng, 20, 10, 1);
    memcpy(bodies, kept, sizeof kept);
    alarm = alarm_kept;
    rng = rng_kept;
    ASSERT_NEAR(evidence, run(&most, &rng, 20, 10, 1), 0);
}

/* If positive and negative errors are equally likely, no noise raises more alarms than
 * stated, plus three standard errors. The noise is a hundred times the stated one, or has
 * Cauchy's distribution. */
static void test_false_alarms_are_no_more_than_stated_whatever_the_noise(void)
{
    TEST_ON_HOST_ONLY("a rate of few frames says nothing");
    for (int heavy = 0; heavy < 2; heavy++) {
        test_rng rng = test_seed(10);
        const int frames = 8000, stated = 40;
        int counted = 0;
        rc_alarm_begin(&alarm, bodies, BODIES, RC(frames / stated), 0, RC(MOVE_RAD),
                       RC(MOVE_T));
        for (int f = 0; f < frames; f++) {
            for (int i = 0; i < 10; i++) {
                row r = row_of(&rng, 100);
                r.z = heavy ? tan(TEST_PI * test_uniform(&rng, -0.5, 0.5)) : r.z;
                feed(&r);
            }
            if (rc_alarm_frame(&alarm, bodies) >= 0) {
                counted++;
                rc_alarm_again(&alarm, bodies);
            }
        }
        TEST_ASSERT_TRUE(counted <= stated + 3 * sqrt(stated));
        TEST_ASSERT_TRUE(counted >= stated * 0.4 - 3 * sqrt(stated * 0.4));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_the_evidence_is_that_of_dense_determinants);
    RUN_TEST(test_the_evidence_is_right_where_a_frame_has_many_rows);
    RUN_TEST(test_the_evidence_is_right_where_rows_are_rare);
    RUN_TEST(test_the_evidence_is_right_where_rows_say_very_much);
    RUN_TEST(test_evidence_beyond_all_exponents_is_a_number);
    RUN_TEST(test_rows_that_overflow_raise_no_alarm_and_are_forgotten);
    RUN_TEST(test_a_window_that_overflows_says_nothing);
    RUN_TEST(test_no_turn_about_an_axis_that_is_not_seen_would_be_noticed);
    RUN_TEST(test_a_frame_without_rows_says_nothing);
    RUN_TEST(test_a_body_without_rows_is_blind_and_sees_again);
    RUN_TEST(test_one_row_has_a_noise);
    RUN_TEST(test_noise_is_the_clipped_rms_over_that_of_normal_noise_as_stated);
    RUN_TEST(test_the_smallest_turn_is_noticed_where_it_is_twice_as_large);
    RUN_TEST(test_after_the_answer_windows_start_with_what_was_measured);
    RUN_TEST(test_the_state_can_be_copied);
    RUN_TEST(test_false_alarms_are_no_more_than_stated_whatever_the_noise);
}
