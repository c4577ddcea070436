/* trial: which body explains the rows, and where it is then. The truth: a simulated rig in
 * which a body is moved by a known step. */
#include <math.h>
#include <string.h>

#include "rc_trial.h"
#include "test_support.h"

enum { BODIES = 3, N = 6 * (BODIES - 1) };

static rigcal_transform poses[BODIES], truth[BODIES];
static rigcal_real UD[N * (N + 1) / 2], error[N], room[N],
    bodies[(BODIES + 1) * RC_ALARM_BODY];
static rc_filter f;
static rc_alarm alarm;

static void begin(void)
{
    memset(&f, 0, sizeof f);
    memset(UD, 0, sizeof UD);
    memset(error, 0, sizeof error);
    for (int b = 0; b < BODIES; b++) {
        const double axis[3] = {0.1, 1, 0}, t[3] = {-0.6 * b, 0.1 * (b % 2), 0.1 * b};
        double R[9];

        test_rotation_about(R, axis, -0.2 * b);
        poses[b] = truth[b] = test_transform(R, t);
    }
    for (int i = 0; i < N; i++) {
        UD[i * (i + 3) / 2] = RC(1e-12);
    }
    f.n_bodies = f.n_cameras = BODIES;
    f.n = N;
    f.poses = poses;
    f.UD = UD;
    f.d = error;
    f.room = room;
    rc_alarm_begin(&alarm, bodies, BODIES, 1000, 0, RC(0.05), RC(5e-3));
    rc_trial_begin(&f, &alarm, bodies, RC(0.05), RC(5e-3));
    for (int b = 0; b <= BODIES; b++) { /* what is not lent, and past the last body */
        for (int k = b < BODIES ? RC_TRIAL_SIZE : 0; k < RC_ALARM_BODY; k++) {
            bodies[b * RC_ALARM_BODY + k] = 77;
        }
    }
}

/* What is not lent stays. */
static void assert_untouched(void)
{
    for (int b = 0; b <= BODIES; b++) {
        for (int k = b < BODIES ? RC_TRIAL_SIZE : 0; k < RC_ALARM_BODY; k++) {
            ASSERT_NEAR(77, bodies[b * RC_ALARM_BODY + k], 0);
        }
    }
}

/* A match of a random pair. */
static rc_seen match(test_rng *rng, double noise_px)
{
    static const double PINHOLE[15] = {0, 640, 480, 800, 800, 320, 240};
    const rigcal_camera camera = test_camera(PINHOLE);
    const int a = (int)test_uniform(rng, 0, BODIES), b = (a + 1) % BODIES;
    const double X[3] = {test_uniform(rng, -1, 1), test_uniform(rng, -1, 1),
                         test_uniform(rng, 2, 4)};
    rc_seen seen = {.a = (size_t)a, .b = (size_t)b, .n_rows = 1};

    for (int k = 0; k < 2; k++) {
        double R[9], t[3], p[3];

        test_transform_parts(R, t, &truth[k == 0 ? a : b]);
        test_apply(p, R, X, t);
        const rigcal_real ray[3] = {
            (rigcal_real)(p[0] / p[2] + noise_px / 800 * test_normal(rng)),
            (rigcal_real)(p[1] / p[2] + noise_px / 800 * test_normal(rng)), 1};
        ASSERT_STATUS(RIGCAL_OK, rc_sight_of(&seen.sight[k], &camera, ray, RC(0.3)));
    }
    return seen;
}

/* Takes a match of a random pair. Returns whether it is doubted. */
static int take(test_rng *rng, double noise_px)
{
    const rc_seen seen = match(rng, noise_px);

    return rc_trial_take(&f, bodies, &seen, RC(0.1));
}

/* Moves the body: turns it about its own centre by `angle` and the direction `axis`, and
 * shifts it by 2e-3 along y. `moved` and t are its pose then. */
static void move(double moved[9], double t[3], size_t body, const double axis[3],
                 double angle)
{
    double turn[9], R[9], before[3];

    test_rotation_about(turn, axis, angle);
    test_transform_parts(R, before, &truth[body]);
    test_product(moved, turn, R);
    test_apply(t, turn, before, NULL);
    t[1] += 2e-3;
    truth[body] = test_transform(moved, t);
}

static void test_the_body_that_moved_is_named_and_found(void)
{
    for (size_t body = 0; body < BODIES; body++) {
        test_rng rng = test_seed(10 + body);
        const double axis[3] = {1, -2, 1};
        double sum = 0, t[3], moved[9];
        rigcal_transform pose;
        rigcal_real Sigma[36];

        begin();
        move(moved, t, body, axis, 0.02);
        for (int i = 0; i < 200; i++) {
            (void)take(&rng, 0.3);
            if (i % 20 == 19) {
                rc_trial_settle(&f, bodies);
            }
        }
        for (size_t b = 0; b < BODIES; b++) {
            sum += D(rc_trial_share(&f, bodies, b));
        }
        ASSERT_NEAR(1, sum, 1e-5);
        assert_untouched();
        TEST_ASSERT_TRUE(rc_trial_share(&f, bodies, body) > RC(0.999));
        rc_trial_result(&pose, Sigma, &f, bodies, body);
        double seen_R[9], seen_t[3], Rt[9], rest[9], turned[3];
        test_transform_parts(seen_R, seen_t, &pose);
        test_transpose(Rt, seen_R);
        test_product(rest, moved, Rt);
        test_apply(turned, rest, seen_t, NULL);
        ASSERT_NEAR(0, test_angle_between(moved, seen_R),
                    4 * sqrt(D(Sigma[0]) + D(Sigma[7]) + D(Sigma[14])));
        for (int k = 0; k < 3; k++) {
            TEST_ASSERT_TRUE(D(Sigma[7 * k]) > 0 && D(Sigma[7 * k]) < 1e-6);
            ASSERT_NEAR(t[k], turned[k], 5 * sqrt(D(Sigma[21 + 7 * k])));
        }
    }
}

/* Without noise the pose is found to a small part of its step, because each row is computed
 * where the trial then has the body. */
static void test_without_noise_the_step_is_found(void)
{
    for (size_t body = 0; body < BODIES; body++) {
        test_rng rng = test_seed(20 + body);
        const double axis[3] = {2, -1, 1};
        double R[9], t[3], moved[9];
        rigcal_transform pose;
        rigcal_real Sigma[36];

        begin();
        move(moved, t, body, axis, 0.05);
        for (int i = 0; i < 300; i++) {
            (void)take(&rng, 0);
        }
        rc_trial_result(&pose, Sigma, &f, bodies, body);
        test_transform_parts(R, t, &pose);
        ASSERT_NEAR(0, test_angle_between(moved, R), 1e-4);
    }
}

/* An error that the filter has found, but not yet put into a body's pose, is no move. The
 * rows say nothing new, so all bodies stay equally likely. */
static void test_an_error_that_is_known_is_no_move(void)
{
    static const double W[3] = {1e-4, -2e-4, 1e-4};

    for (int body = 1; body < BODIES; body++) {
        test_rng rng = test_seed(30 + (uint64_t)body);
        double turn[9], R[9], t[3], moved[9], before[3];

        begin();
        test_rotation_about(turn, W, test_norm(W));
        test_transform_parts(R, before, &truth[body]);
        test_product(moved, turn, R);
        test_apply(t, turn, before, NULL);
        for (int k = 0; k < 3; k++) {
            error[6 * (body - 1) + k] = RC(W[k]);
            error[6 * (body - 1) + 3 + k] = RC(1e-4 * (k + 1));
            t[k] += 1e-4 * (k + 1);
        }
        truth[body] = test_transform(moved, t);
        for (int i = 0; i < 60; i++) {
            (void)take(&rng, 0);
        }
        for (size_t b = 0; b < BODIES; b++) {
            const rigcal_real *const move = &bodies[b * RC_ALARM_BODY + RC_TRIAL_MOVE];
            for (int k = 0; k < 6; k++) {
                ASSERT_NEAR(0, move[k], 2e-6);
            }
        }
    }
}

/* Right matches are believed. Matches that are off by hundreds of pixels are not. */
static void test_wrong_matches_are_doubted(void)
{
    test_rng rng = test_seed(40);
    int doubted = 0;

    begin();
    for (int i = 0; i < 40; i++) {
        TEST_ASSERT_FALSE(take(&rng, 0));
    }
    for (int i = 0; i < 40; i++) {
        doubted += take(&rng, 300);
    }
    TEST_ASSERT_GREATER_THAN_INT(30, doubted);
}

static void test_without_rows_all_bodies_are_equally_likely(void)
{
    begin();
    for (size_t b = 0; b < BODIES; b++) {
        ASSERT_NEAR(1.0 / 3, rc_trial_share(&f, bodies, b), 1e-5);
    }
    f.n_cameras = 2; /* the third is a target without a place */
    ASSERT_NEAR(0.5, rc_trial_share(&f, bodies, 0), 1e-5);
    ASSERT_NEAR(0, rc_trial_share(&f, bodies, 2), 0);
}

/* A trial begins with the body's share of the evidence, up to a factor of e^2 less than the
 * largest, and not less than 1e-30. Of the alarm's memory it takes what is lent. The body
 * that was moved most has all its numbers at 0, the others at less. */
static void test_a_trial_begins_with_the_share_of_the_evidence(void)
{
    /* logs of shares, relative to the largest: equal, just beyond e^-2, nearly no share */
    static const double LOGS[BODIES] = {0, -5, -200}, LOG_LEAST = -69.07755;
    static rigcal_real dirty[(BODIES + 1) * RC_ALARM_BODY];

    for (int first = 0; first < BODIES; first++) {
        begin();
        for (int b = 0; b <= BODIES; b++) {
            for (int k = 0; k < RC_ALARM_BODY; k++) { /* past the last: no body */
                dirty[b * RC_ALARM_BODY + k] =
                    b < BODIES ? RC(LOGS[(b + first) % BODIES]) : RC(30);
            }
        }
        f.n_cameras = BODIES - 1; /* the last body is a target */
        rc_trial_begin(&f, &alarm, dirty, RC(0.25), RC(0.5));
        double R[9], t[3];
        test_transform_parts(R, t, &poses[BODIES - 1]); /* the frame is at 0 */
        for (int b = 0; b < BODIES; b++) {
            const rigcal_real *const trial = &dirty[b * RC_ALARM_BODY];
            const double shift =
                b < BODIES - 1 ? 0.25 : 0.25 + 0.0625 * 0.01 * test_dot(t, t);
            const double log = LOGS[(b + first) % BODIES];
            rigcal_transform pose;
            rigcal_real Sigma[36];

            rc_trial_result(&pose, Sigma, &f, dirty, (size_t)b);
            ASSERT_TRANSFORM(&poses[b], &pose, TOL(1e-15, 1e-6), TOL(1e-15, 1e-6));
            for (int k = 0; k < 36; k++) {
                const double variance = k < 18 ? 0.0625 : shift;

                ASSERT_NEAR(k % 7 == 0 ? variance : 0, Sigma[k],
                            b < BODIES - 1 ? 0 : TOL(1e-15, 1e-7));
            }
            ASSERT_NEAR(fmin(fmax(log, LOG_LEAST) + 2, 0), trial[RC_TRIAL_LOG],
                        TOL(1e-5, 1e-4));
            for (int k = RC_ALARM_WINDOW; k < RC_ALARM_BODY; k++) {
                ASSERT_NEAR(log, trial[k], 0);
            }
        }
        ASSERT_NEAR(30, dirty[BODIES * RC_ALARM_BODY], 0);
    }
}

/* ---- the equations ------------------------------------------------------------- */

/* A trial in double, with its covariance multiplied out. */
typedef struct {
    double x[6], P[36], log;
} plain;

static void plain_of(plain *out, size_t body)
{
    const rigcal_real *const trial = &bodies[body * RC_ALARM_BODY];
    rigcal_transform pose;
    rigcal_real Sigma[36];

    rc_trial_result(&pose, Sigma, &f, bodies, body);
    test_to_double(out->x, &trial[RC_TRIAL_MOVE], 6);
    test_to_double(out->P, Sigma, 36);
    out->log = D(trial[RC_TRIAL_LOG]);
}

/* What the known errors of the bodies explain of a row, and the variance they give it. The
 * filter's covariance is diagonal. */
static double known(double *variance, const rc_seen *seen, const rc_row *row)
{
    double sum = 0;

    *variance = 0;
    for (int k = 0; k < 2; k++) {
        const size_t body = k ? seen->b : seen->a;

        for (int i = 0; i < 6 && body > 0; i++) { /* body 0 is the frame */
            const double h = D(k ? row->h_b[i] : row->h_a[i]);
            const int at = 6 * ((int)body - 1) + i;

            sum += h * D(error[at]);
            *variance += h * h * D(UD[at * (at + 3) / 2]);
        }
    }
    return sum;
}

/* (M15) by textbook: Kalman's equations for the six numbers of one trial. */
static void learn(plain *trial, const rc_seen *seen, int is_b, double sd, double log_held)
{
    const size_t body = is_b ? seen->b : seen->a;
    const rigcal_real w[6] = {RC(trial->x[0]), RC(trial->x[1]), RC(trial->x[2]), 0, 0, 0};
    rigcal_transform turn = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    rc_row row;
    rc_doubt doubt;
    double h[6], Ph[6] = {0}, hPh = 0, variance, both[3], with_shift[3];

    rc_transform_move(&turn, w);
    test_to_real(turn.t, &trial->x[3], 3);
    const rigcal_transform moved = test_times(&turn, &poses[body]);
    ASSERT_STATUS(RIGCAL_OK, rc_rows_of(&row, seen, is_b ? &poses[seen->a] : &moved,
                                        is_b ? &moved : &poses[seen->b]));
    const double nu = (D(row.r) - known(&variance, seen, &row)) / sd;
    test_to_double(h, is_b ? row.h_b : row.h_a, 6);
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++) {
            Ph[i] += trial->P[6 * i + j] * h[j] / sd;
        }
        hPh += h[i] / sd * Ph[i];
    }
    const double bend =
        D(rc_filter_bend(&bodies[body * RC_ALARM_BODY + RC_TRIAL_UD], 6, 0, row.reach));
    const double S = 1 + hPh * (1 + bend);
    rc_filter_doubt(&doubt, RC(nu), RC(S), RC(0.1));
    for (int i = 0; i < 36; i++) {
        trial->P[i] -= D(doubt.gain) / S * Ph[i / 6] * Ph[i % 6];
    }
    const double by = D(doubt.beta) * nu / S;
    test_cross(both, Ph, trial->x);
    test_cross(with_shift, Ph, &trial->x[3]);
    for (int i = 0; i < 6; i++) {
        trial->x[i] += by * Ph[i] + (i < 3 ? by / 2 * both[i] : by * with_shift[i - 3]);
    }
    trial->log += (log(D(doubt.likelihood)) - log_held) / 2;
}

/* Rows that are right, doubtful and wrong, while the trials have moved by some degrees. The
 * filter is not sure of the poses either. */
static void test_each_row_is_taken_as_the_equations_say(void)
{
    test_rng rng = test_seed(50);
    int doubted = 0;

    for (int trial = 0; trial < 20; trial++) {
        begin();
        for (int i = 0; i < N; i++) {
            UD[i * (i + 3) / 2] = RC(1e-6 * test_uniform(&rng, 0.1, 1));
            error[i] = RC(1e-3 * test_uniform(&rng, -1, 1));
        }
        for (int b = 0; b < BODIES; b++) {
            for (int k = 0; k < 3; k++) {
                bodies[b * RC_ALARM_BODY + k] = RC(test_uniform(&rng, -0.1, 0.1));
            }
        }
        for (int n = 0; n < 10; n++) {
            const rc_seen seen = match(&rng, 3);
            plain expected[BODIES], now;
            rc_row row;
            rc_doubt held;
            double variance;

            for (size_t b = 0; b < BODIES; b++) {
                plain_of(&expected[b], b);
            }
            ASSERT_STATUS(RIGCAL_OK,
                          rc_rows_of(&row, &seen, &poses[seen.a], &poses[seen.b]));
            const double nu = D(row.r) - known(&variance, &seen, &row);
            rc_filter_doubt(&held, RC(nu / sqrt(1 + variance)), 1, RC(0.1));
            for (int k = 0; k < 2; k++) {
                learn(&expected[k ? seen.b : seen.a], &seen, k, sqrt(1 + variance),
                      log(D(held.likelihood)));
            }
            TEST_ASSERT_EQUAL_INT(D(held.beta) < 0.5,
                                  rc_trial_take(&f, bodies, &seen, RC(0.1)));
            doubted += D(held.beta) < 0.5;
            for (size_t b = 0; b < BODIES; b++) {
                plain_of(&now, b);
                ASSERT_NEAR(expected[b].log, now.log, TOL(1e-7, 0.1));
                for (int k = 0; k < 6; k++) {
                    ASSERT_NEAR(expected[b].x[k], now.x[k], TOL(1e-9, 1e-3));
                }
                for (int k = 0; k < 36; k++) {
                    ASSERT_NEAR(expected[b].P[k], now.P[k], TOL(1e-11, 1e-5));
                }
            }
        }
    }
    TEST_ASSERT_TRUE(doubted > 20 && doubted < 180);
}

/* After any number of rows only the differences of the logs count. */
static void test_logs_of_any_size_give_shares(void)
{
    static const double LOGS[BODIES] = {1500, 1499, 1400};

    for (int first = 0; first < BODIES; first++) {
        begin();
        for (int b = 0; b < BODIES; b++) {
            bodies[b * RC_ALARM_BODY + RC_TRIAL_LOG] = RC(LOGS[(b + first) % BODIES]);
        }
        for (int settled = 0; settled < 2; settled++) {
            for (int b = 0; b < BODIES; b++) {
                const double log = LOGS[(b + first) % BODIES] - 1500;

                ASSERT_NEAR(exp(log) / (1 + exp(-1)), rc_trial_share(&f, bodies, (size_t)b),
                            TOL(1e-7, 1e-5));
                if (settled) {
                    ASSERT_NEAR(log, bodies[b * RC_ALARM_BODY + RC_TRIAL_LOG], 0);
                }
            }
            rc_trial_settle(&f, bodies);
        }
    }
}

/* ---- rows that tell nothing ---------------------------------------------------- */

/* Camera 1 is at a distance of 2 from a target, body 2. It sees a point of the target 0.1
 * off the axis. In its trial the camera is moved by `closer` towards the target. */
static void see_target(rc_seen *seen, const rigcal_camera *camera, double above,
                       double closer, double step_t)
{
    const double I[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, o[3] = {0, 0, 0}, t[3] = {0, 0, 2};

    begin();
    f.n_cameras = 2;
    f.placed = 1;
    poses[1] = test_transform(I, t);
    poses[2] = test_transform(I, o);
    rc_trial_begin(&f, &alarm, bodies, RC(step_t), RC(step_t));
    bodies[RC_ALARM_BODY + RC_TRIAL_MOVE + 5] = RC(-closer);
    *seen = (rc_seen){.a = 1, .b = 2, .n_rows = 2, .sigma_px = 1};
    seen->camera = camera;
    seen->X[0] = RC(0.1);
    seen->X[2] = RC(above);
    seen->uv[0] = 360;
    seen->uv[1] = 240;
}

/* If the trial has no row, the move explains nothing. The body's log falls but stays
 * finite, and the move does not change. */
static void assert_explains_nothing(const rc_seen *seen)
{
    const rigcal_real *const trial = &bodies[RC_ALARM_BODY];
    const double log_before = D(trial[RC_TRIAL_LOG]), before = D(trial[RC_TRIAL_MOVE + 5]);

    TEST_ASSERT_FALSE(rc_trial_take(&f, bodies, seen, RC(0.1)));
    TEST_ASSERT_TRUE(D(trial[RC_TRIAL_LOG]) < log_before - 30);
    TEST_ASSERT_TRUE(rc_is_finite(trial[RC_TRIAL_LOG]));
    ASSERT_NEAR(before, trial[RC_TRIAL_MOVE + 5], 0);
    TEST_ASSERT_TRUE(rc_trial_share(&f, bodies, 1) < RC(1e-6));
}

static void test_a_move_that_hides_the_point_explains_nothing(void)
{
    const rigcal_camera camera = test_pinhole();
    rc_seen seen;

    see_target(&seen, &camera, 0, 3, 0.05); /* behind the camera */
    assert_explains_nothing(&seen);
    /* so near to the camera's plane that the pixel's variance overflows */
    see_target(&seen, &camera, TOL(1e-100, 1e-15), 2, 0.05);
    assert_explains_nothing(&seen);
}

/* The body's own error, moved as far, overflows too. */
static void test_an_error_that_overflows_in_the_trial_explains_nothing(void)
{
    const rigcal_camera camera = test_pinhole();
    rc_seen seen;

    see_target(&seen, &camera, TOL(1e-100, 1e-15), 2, 0);
    error[5] = RC(TOL(1e150, 1e10));
    (void)rc_trial_take(&f, bodies, &seen, RC(0.1));
    TEST_ASSERT_TRUE(rc_is_finite(bodies[RC_ALARM_BODY + RC_TRIAL_LOG]));
    ASSERT_NEAR(-2, bodies[RC_ALARM_BODY + RC_TRIAL_MOVE + 5], 0);
}

/* A row that the filter itself cannot evaluate changes no trial. */
static void test_rows_that_the_filter_cannot_take_are_left_out(void)
{
    static rigcal_real before[(BODIES + 1) * RC_ALARM_BODY];
    const rigcal_camera camera = test_pinhole();
    rc_seen seen;

    see_target(&seen, &camera, -3, 0, 0.05); /* behind the camera */
    memcpy(before, bodies, sizeof before);
    TEST_ASSERT_FALSE(rc_trial_take(&f, bodies, &seen, RC(0.1)));
    TEST_ASSERT_EQUAL_MEMORY(before, bodies, sizeof before);
    see_target(&seen, &camera, 0, 0, 0.05);
    error[3] = error[5] = TEST_INF;
    memcpy(before, bodies, sizeof before);
    TEST_ASSERT_TRUE(rc_trial_take(&f, bodies, &seen, RC(0.1)));
    TEST_ASSERT_EQUAL_MEMORY(before, bodies, sizeof before);
}

TEST_MAIN()
{
    RUN_TEST(test_the_body_that_moved_is_named_and_found);
    RUN_TEST(test_without_rows_all_bodies_are_equally_likely);
    RUN_TEST(test_a_trial_begins_with_the_share_of_the_evidence);
    RUN_TEST(test_each_row_is_taken_as_the_equations_say);
    RUN_TEST(test_logs_of_any_size_give_shares);
    RUN_TEST(test_without_noise_the_step_is_found);
    RUN_TEST(test_an_error_that_is_known_is_no_move);
    RUN_TEST(test_wrong_matches_are_doubted);
    RUN_TEST(test_a_move_that_hides_the_point_explains_nothing);
    RUN_TEST(test_an_error_that_overflows_in_the_trial_explains_nothing);
    RUN_TEST(test_rows_that_the_filter_cannot_take_are_left_out);
}
