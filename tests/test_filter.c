/* filter: poses and the joint covariance of their errors. The truth is made with dense
 * matrices in double, and with moves that are made and measured. */
#include <math.h>
#include <string.h>

#include "rc_filter.h"
#include "test_support.h"

enum { BODIES = 4, N = 6 * (BODIES - 1) };

typedef struct {
    rigcal_transform poses[BODIES];
    rigcal_real UD[N * (N + 1) / 2], d[N], room[N];
    rc_filter f;
    double P[N][N], mean[N]; /* the truth */
} held;

static held s;

/* ---- a filter, and the same in dense matrices --------------------------------------- */

static void begin(test_rng *rng, size_t frame)
{
    double A[N][N];

    memset(&s, 0, sizeof s);
    for (int b = 0; b < BODIES; b++) {
        s.poses[b] = test_random_transform(rng);
    }
    for (int i = 0; i < N * N; i++) {
        A[i / N][i % N] = 1e-3 * test_normal(rng);
    }
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            s.P[i][j] = i == j ? 1e-6 : 0;
            for (int k = 0; k < N; k++) {
                s.P[i][j] += A[i][k] * A[j][k];
            }
        }
    }
    for (int i = 0; i < N; i++) {
        for (int j = 0; j <= i; j++) {
            s.UD[i * (i + 1) / 2 + j] = (rigcal_real)s.P[i][j];
        }
    }
    s.f.n_bodies = s.f.n_cameras = BODIES;
    s.f.n = N;
    s.f.frame = frame;
    s.f.poses = s.poses;
    s.f.UD = s.UD;
    s.f.d = s.d;
    s.f.room = s.room;
    rc_filter_factor(s.UD, N);
}

static void assert_covariance(double tol)
{
    for (size_t i = 0; i < N; i++) {
        TEST_ASSERT_TRUE(s.UD[i * (i + 3) / 2] > 0); /* D: positive definite */
        for (size_t j = 0; j < N; j++) {
            ASSERT_NEAR(s.P[i][j] / sqrt(s.P[i][i] * s.P[j][j]),
                        D(rc_filter_element(s.UD, N, i, j)) / sqrt(s.P[i][i] * s.P[j][j]),
                        tol);
        }
    }
}

static void random_row(rc_row *row, double h[N], int a, int b, test_rng *rng)
{
    memset(h, 0, N * sizeof h[0]);
    for (int k = 0; k < 6; k++) {
        row->h_a[k] = (rigcal_real)(500 * test_normal(rng));
        row->h_b[k] = (rigcal_real)(500 * test_normal(rng));
        if (a != (int)s.f.frame) {
            h[rc_filter_first(&s.f, (size_t)a) + k] = D(row->h_a[k]);
        }
        if (b != (int)s.f.frame) {
            h[rc_filter_first(&s.f, (size_t)b) + k] = D(row->h_b[k]);
        }
    }
    row->reach = 1;
}

/* (M8) with dense matrices. */
static void learn(const double h[N], double r, double wrong, double *beta, double *z)
{
    double Ph[N], S = 1, nu = r;

    for (int i = 0; i < N; i++) {
        Ph[i] = 0;
        for (int j = 0; j < N; j++) {
            Ph[i] += s.P[i][j] * h[j];
        }
    }
    for (int i = 0; i < N; i++) {
        S += h[i] * Ph[i];
        nu -= h[i] * s.mean[i];
    }
    *z = nu / sqrt(S);
    const double right = (1 - wrong) * exp(-*z * *z / 2) / sqrt(2 * TEST_PI * S);
    *beta = right / (right + wrong / 100);
    const double gain = *beta * (1 - (1 - *beta) * *z * *z);
    for (int i = 0; i < N; i++) {
        s.mean[i] += *beta * nu * Ph[i] / S;
        for (int j = 0; j < N; j++) {
            s.P[i][j] -= gain / S * Ph[i] * Ph[j];
        }
    }
}

/* ---- covariance ------------------------------------------------------------------------
 * */

static void test_factors_multiply_to_the_covariance(void)
{
    test_rng rng = test_seed(1);

    begin(&rng, 0);
    assert_covariance(TOL(1e-13, 1e-5));
    rc_filter_multiply(s.UD, N);
    for (int i = 0; i < N; i++) {
        for (int j = 0; j <= i; j++) {
            ASSERT_NEAR(s.P[i][j] / sqrt(s.P[i][i] * s.P[j][j]),
                        D(s.UD[i * (i + 1) / 2 + j]) / sqrt(s.P[i][i] * s.P[j][j]),
                        TOL(1e-13, 1e-5));
        }
    }
}

/* A covariance may be as large as both variances allow. A larger one cannot be, and counts
 * as none. */
static void test_a_covariance_beyond_what_the_variances_allow_is_none(void)
{
    rigcal_real full[3] = {4, 2, 1}, beyond[3] = {4, RC(2.125), 1};

    rc_filter_factor(full, 2);
    rc_filter_multiply(full, 2);
    ASSERT_NEAR(4, full[0], TOL(1e-14, 5e-6));
    ASSERT_NEAR(2, full[1], TOL(1e-15, 1e-6));
    ASSERT_NEAR(1, full[2], TOL(1e-15, 1e-6));
    rc_filter_factor(beyond, 2);
    rc_filter_multiply(beyond, 2);
    ASSERT_NEAR(4, beyond[0], 0);
    ASSERT_NEAR(0, beyond[1], 0);
    ASSERT_NEAR(1, beyond[2], 0);
}

/* A variance whose inverse is not a number counts as 0, so the unknown is known exactly. */
static void test_a_variance_without_an_inverse_is_none(void)
{
    rigcal_real P[3] = {1, 0, RC(TOL(1e-310, 1e-40))};

    rc_filter_factor(P, 2);
    ASSERT_NEAR(1, P[0], 0);
    ASSERT_NEAR(0, P[1], 0);
    ASSERT_NEAR(0, P[2], 0);
}

/* Unknowns 1 and 2 are the same, so unknown 1 tells nothing that unknown 2 does not tell.
 * By rounding its covariance with unknown 0 differs a little. The variance that is left of
 * unknown 0 is 1 - 1/2^2, whatever is left of that difference. */
static void test_an_unknown_that_is_known_by_another_tells_no_more(void)
{
    const double rounding = TOL(1e-9, 3e-5);
    rigcal_real P[6] = {1, RC(0.5 + rounding), 1, RC(0.5), 1, 1};

    rc_filter_factor(P, 3);
    ASSERT_NEAR(0.75, P[0], TOL(1e-15, 1e-6));
    ASSERT_NEAR(0, P[1], 0);
    TEST_ASSERT_TRUE(P[2] > 0 && P[2] < 10 * RC_EPS); /* positive definite all the same */
}

static void test_rows_that_may_be_wrong_agree_with_dense_matrices(void)
{
    for (int trial = 0; trial < TEST_TRIALS(20); trial++) {
        test_rng rng = test_seed(20 + (uint64_t)trial);
        const double wrong = trial % 3 == 0 ? 0 : 0.1 * (trial % 3);
        int is_negative = 0;

        begin(&rng, (size_t)(trial % BODIES));
        for (int i = 0; i < 60; i++) {
            const int a = (int)test_uniform(&rng, 0, BODIES), b = (a + 1 + i % 3) % BODIES;
            double h[N], beta, z;
            rc_row row;
            rc_news news;

            random_row(&row, h, a, b, &rng);
            row.r = (rigcal_real)((i % 5 == 4 ? 6 : 1) * test_normal(&rng));
            learn(h, D(row.r), wrong, &beta, &z);
            TEST_ASSERT_TRUE(rc_filter_row(&news, &s.f, (size_t)a, (size_t)b, &row,
                                           (rigcal_real)wrong, 0));
            ASSERT_NEAR(z, news.z, TOL(1e-9, 1e-3));
            ASSERT_NEAR(beta, news.doubt.beta, TOL(1e-9, 2e-3));
            is_negative += news.doubt.gain < 0;
        }
        TEST_ASSERT_TRUE(wrong == 0 || is_negative > 0);
        assert_covariance(TOL(1e-9, 5e-3));
        for (int i = 0; i < N; i++) {
            ASSERT_NEAR(s.mean[i] / sqrt(s.P[i][i]), D(s.d[i]) / sqrt(s.P[i][i]),
                        TOL(1e-8, 5e-3));
        }
    }
}

/* A direction that is never seen keeps its variance, while others fall by 1e8. */
static void test_it_stays_positive_definite_where_one_direction_is_never_seen(void)
{
    test_rng rng = test_seed(3);
    double unseen[N], norm = 0, variance = 0;

    begin(&rng, 0);
    rc_clear(s.UD, N * (N + 1) / 2);
    for (int i = 0; i < N; i++) {
        s.UD[i * (i + 3) / 2] = RC(1e-4);
        unseen[i] = test_normal(&rng);
        norm += unseen[i] * unseen[i];
    }
    for (int i = 0; i < TEST_TRIALS(40000); i++) {
        const int a = (int)test_uniform(&rng, 0, BODIES), b = (a + 1 + i % 3) % BODIES;
        double h[N], along = 0;
        rc_row row;
        rc_news news;

        random_row(&row, h, a, b, &rng);
        double part = 0;
        for (int k = 0; k < N; k++) {
            along += h[k] * unseen[k];
            part += (h[k] != 0) * unseen[k] * unseen[k];
        }
        for (int k = 0; k < 6; k++) {
            const int32_t at_a = rc_filter_first(&s.f, (size_t)a),
                          at_b = rc_filter_first(&s.f, (size_t)b);
            if (at_a >= 0) {
                row.h_a[k] = (rigcal_real)(h[at_a + k] - along / part * unseen[at_a + k]);
            }
            if (at_b >= 0) {
                row.h_b[k] = (rigcal_real)(h[at_b + k] - along / part * unseen[at_b + k]);
            }
        }
        row.r = (rigcal_real)test_normal(&rng);
        TEST_ASSERT_TRUE(rc_filter_row(&news, &s.f, (size_t)a, (size_t)b, &row, 0, 0));
    }
    for (size_t i = 0; i < N; i++) {
        TEST_ASSERT_TRUE(s.UD[i * (i + 3) / 2] > 0);
        for (size_t j = 0; j < N; j++) {
            variance += unseen[i] * D(rc_filter_element(s.UD, N, i, j)) * unseen[j] / norm;
        }
    }
    ASSERT_NEAR(1e-4, variance, 3e-6);
}

/* ---- poses --------------------------------------------------------------------------- */

/* In float a turn of 1e-9 is below the rounding of R, so it is kept separately. */
static void test_small_steps_add_up(void)
{
    test_rng rng = test_seed(4);
    const double step[6] = {1e-9, -2e-9, 0.5e-9, 1e-9, 2e-9, -1e-9};
    const int steps = TEST_TRIALS(100000);
    double R[9], t[3], before[9], t_before[3], Rt[9], turn[9], w[3], ds[3], expected[3];
    double once[3], twice[3], left[3], rest[3];

    begin(&rng, 0);
    for (int k = 0; k < 3; k++) {
        s.poses[1].t[k] = RC(0.5 + k);
    }
    test_transform_parts(before, t_before, &s.poses[1]);
    for (int i = 0; i < steps; i++) {
        for (int k = 0; k < 6; k++) {
            s.d[k] += (rigcal_real)step[k];
        }
        rc_filter_apply(&s.f, 1);
    }
    test_transform_parts(R, t, &s.poses[1]);
    test_transpose(Rt, before);
    test_product(turn, R, Rt);
    const double sine[3] = {(turn[7] - turn[5]) / 2, (turn[2] - turn[6]) / 2,
                            (turn[3] - turn[1]) / 2};
    const double by = asin(test_norm(sine)) / test_norm(sine);
    for (int k = 0; k < 3; k++) {
        left[k] = D(s.d[k]);
        w[k] = by * sine[k] + left[k];
        ds[k] = steps * step[3 + k];
        ASSERT_NEAR(steps * step[k], w[k], TOL(1e-10, 2e-7));
    }
    /* The pose and its rest: t, turned by what is left, and what is left of the shift. The
     * shifts are turned by the turns that come after them, in the mean by half of all. */
    test_rotation_about(turn, w, test_norm(w));
    test_apply(expected, turn, t_before, ds);
    test_cross(once, w, ds);
    test_cross(twice, w, once);
    test_cross(rest, left, t);
    for (int k = 0; k < 3; k++) {
        ASSERT_NEAR(expected[k] + once[k] / 2 + twice[k] / 6,
                    t[k] + rest[k] + D(s.d[3 + k]), TOL(1e-12, 2e-8));
    }
}

/* Each step rounds the rotation, whether the body moves itself or the frame is put
 * elsewhere. The roundings of many steps do not add up. */
static void test_a_pose_that_is_moved_often_stays_a_rotation(void)
{
    for (int is_frame = 0; is_frame < 2; is_frame++) {
        test_rng rng = test_seed(79);
        double R[9], t[3], Rt[9], one[9];

        begin(&rng, 0);
        for (int i = 0; i < TEST_TRIALS(40000); i++) {
            rigcal_real d[6] = {0, 0, 0, 0, 0, 0};

            for (int k = 0; k < 3; k++) {
                d[k] = RC(0.1 * test_normal(&rng));
            }
            if (is_frame) {
                rigcal_transform moved = s.poses[0];

                rc_transform_move(&moved, d);
                rc_filter_put(&s.f, 0, &moved);
            } else {
                memcpy(s.d, d, sizeof d);
                rc_filter_apply(&s.f, 1);
            }
        }
        test_transform_parts(R, t, &s.poses[1]);
        test_transpose(Rt, R);
        test_product(one, Rt, R);
        for (int k = 0; k < 9; k++) {
            ASSERT_NEAR(k % 4 == 0, one[k], 8 * D(RC_EPS));
        }
    }
}

/* e = (w, ds) of all bodies but the frame: by how much they turned about their own centres,
 * and shifted. */
static void measure(double e[N], const rigcal_transform from[BODIES])
{
    for (size_t b = 0; b < BODIES; b++) {
        const int32_t first = rc_filter_first(&s.f, b);
        double R[9], t[3], R0[9], t0[3], Rt[9], turn[9], turned[3];

        if (first < 0) {
            continue;
        }
        test_transform_parts(R, t, &s.poses[b]);
        test_transform_parts(R0, t0, &from[b]);
        test_transpose(Rt, R0);
        test_product(turn, R, Rt);
        e[first] = (turn[7] - turn[5]) / 2;
        e[first + 1] = (turn[2] - turn[6]) / 2;
        e[first + 2] = (turn[3] - turn[1]) / 2;
        test_apply(turned, turn, t0, NULL);
        for (int k = 0; k < 3; k++) {
            e[first + 3 + k] = t[k] - turned[k];
        }
    }
}

/* (M7) The frame moves by d. All other bodies move as P says, and the frame stays. */
static void test_a_move_of_the_frame_is_one_of_all_others(void)
{
    for (size_t frame = 0; frame < 3; frame++) {
        test_rng rng = test_seed(50 + frame);
        const double size = TOL(1e-5, 1e-2);
        double d[6], e[N];
        rigcal_transform before[BODIES], moved;
        rigcal_real Q[36], step[6], dt[3], P[N * (N + 1) / 2];

        begin(&rng, frame);
        memcpy(before, s.poses, sizeof before);
        for (int k = 0; k < 6; k++) {
            d[k] = size * test_normal(&rng);
            step[k] = (rigcal_real)d[k];
        }
        for (int k = 0; k < 36; k++) {
            Q[k] = (rigcal_real)(d[k / 6] * d[k % 6]);
        }
        moved = s.poses[frame];
        rc_transform_displace(&moved, dt, step);
        rc_clear(P, N * (N + 1) / 2);
        rc_filter_spread_by(&s.f, P, frame, Q);
        rc_filter_put(&s.f, frame, &moved);
        TEST_ASSERT_EQUAL_MEMORY(&before[frame], &s.poses[frame], sizeof before[0]);
        const rigcal_transform inverse = test_inverse(&moved),
                               relative = test_times(&before[3], &inverse),
                               expected = test_times(&relative, &before[frame]);
        ASSERT_TRANSFORM(&expected, &s.poses[3], TOL(1e-12, 2e-6), TOL(1e-12, 1e-5));
        measure(e, before);
        for (int i = 0; i < N; i++) {
            for (int j = 0; j <= i; j++) {
                const double expected_ij = e[i] * e[j] / (size * size);
                ASSERT_NEAR(expected_ij, D(P[i * (i + 1) / 2 + j]) / (size * size),
                            TOL(5e-4, 0.3) * (1 + fabs(expected_ij)));
            }
        }
    }
}

static void test_a_spread_of_equal_axes_is_that_of_its_covariance(void)
{
    for (size_t body = 0; body < BODIES; body++) {
        test_rng rng = test_seed(60);
        rigcal_real Q[36], P[N * (N + 1) / 2], other[N * (N + 1) / 2];

        begin(&rng, 1);
        rc_clear(Q, 36);
        for (int k = 0; k < 6; k++) {
            Q[7 * k] = k < 3 ? RC(2) : RC(3);
        }
        rc_clear(P, N * (N + 1) / 2);
        rc_clear(other, N * (N + 1) / 2);
        rc_filter_spread(&s.f, P, body, 2, 3);
        rc_filter_spread_by(&s.f, other, body, Q);
        for (int k = 0; k < N * (N + 1) / 2; k++) {
            ASSERT_NEAR(other[k], P[k], TOL(1e-13, 1e-5) * (1 + fabs(D(other[k]))));
        }
        TEST_ASSERT_TRUE(P[0] > 1 || body > 1); /* the first camera moves with the frame */
    }
}

/* The error of body 3 depends on that of body 1, plus noise; or that of body 1 on body 3,
 * whose unknowns come later. */
static void test_a_body_comes_with_its_covariance_and_leaves(void)
{
    static rigcal_real P[N * (N + 1) / 2 + N];
    for (int turned = 0; turned < 2; turned++) {
        test_rng rng = test_seed(70);
        const int new_at = turned ? 0 : 12, from = turned ? 12 : 0;
        double by[6][6], expected;
        rigcal_real T[36], Q[36];

        begin(&rng, 0);
        for (int k = 0; k < 36; k++) {
            by[k / 6][k % 6] = test_normal(&rng);
            T[k] = (rigcal_real)by[k / 6][k % 6];
            by[k / 6][k % 6] = D(T[k]);
            Q[k] = k % 7 == 0 ? RC(1e-6) : 0;
        }
        for (int i = 0; i < N; i++) {
            s.f.d[i] = RC(0.001 * (i + 1));
        }
        rc_filter_multiply(s.UD, N);
        rc_filter_come(&s.f, s.UD, turned ? 1 : 3, turned ? 3 : 1, T, Q);
        /* An estimated error of the one is an error of the other. */
        for (int i = 0; i < N; i++) {
            expected = 0.001 * (i + 1);
            if (i >= new_at && i < new_at + 6) {
                expected = 0;
                for (int k = 0; k < 6; k++) {
                    expected += by[i - new_at][k] * 0.001 * (from + k + 1);
                }
            }
            ASSERT_NEAR(expected, s.f.d[i], TOL(1e-15, 1e-7));
        }
        for (int i = 0; i < 6; i++) {
            for (int j = 0; j < N; j++) {
                const int is_own = j >= new_at && j < new_at + 6;
                const int row = j > new_at + i ? j : new_at + i;
                const int column = j > new_at + i ? new_at + i : j;
                expected = j == new_at + i ? 1e-6 : 0;
                for (int k = 0; k < 36; k++) {
                    expected += is_own ? by[i][k / 6] * s.P[from + k / 6][from + k % 6] *
                                             by[j - new_at][k % 6]
                                       : (k < 6) * by[i][k % 6] * s.P[from + k % 6][j];
                }
                ASSERT_NEAR(expected, s.UD[row * (row + 1) / 2 + column], TOL(1e-15, 1e-9));
            }
        }
        memcpy(P, s.UD, sizeof s.UD);
        for (int i = 0; i < N; i++) {
            P[N * (N + 1) / 2 + i] = 77;
        }
        rc_filter_leave(&s.f, P, 2);
        memcpy(s.UD, P, sizeof s.UD);
        for (int i = 0; i < N; i++) { /* what lies behind the covariance stays */
            ASSERT_NEAR(77, P[N * (N + 1) / 2 + i], 0);
        }
        for (int i = 6; i < 12; i++) {
            for (int j = 0; j < N; j++) {
                const int row = i > j ? i : j, column = i > j ? j : i;
                ASSERT_NEAR(0, s.UD[row * (row + 1) / 2 + column], 0);
            }
        }
        const int kept = from * (from + 3) / 2;
        ASSERT_NEAR(s.P[from][from], s.UD[kept], TOL(1e-15, 1e-10));
    }
}

/* The first unknowns of body 2 are known exactly. They stay, and the others are
 * estimated. */
static void test_unknowns_that_are_known_exactly_learn_nothing(void)
{
    for (int n_known = 1; n_known <= 6; n_known++) {
        test_rng rng = test_seed(75);
        double h[N], beta, z;
        rc_row row;
        rc_news news;

        begin(&rng, 0);
        rc_filter_multiply(s.UD, N);
        for (int i = 0; i < N; i++) {
            for (int j = 0; j < N; j++) {
                const int is_known =
                    (i >= 6 && i < 6 + n_known) || (j >= 6 && j < 6 + n_known);
                s.P[i][j] *= !is_known;
                if (j <= i) {
                    s.UD[i * (i + 1) / 2 + j] *= RC(!is_known);
                }
            }
        }
        rc_filter_factor(s.UD, N);
        random_row(&row, h, 1, 2, &rng);
        row.r = 1;
        learn(h, 1, 0, &beta, &z);
        TEST_ASSERT_TRUE(rc_filter_row(&news, &s.f, 1, 2, &row, 0, 0));
        ASSERT_NEAR(z, news.z, TOL(1e-12, 1e-4));
        for (size_t i = 0; i < N; i++) {
            ASSERT_NEAR(s.mean[i], s.d[i], TOL(1e-15, 1e-8));
            for (size_t j = 0; j <= i; j++) {
                ASSERT_NEAR(s.P[i][j], rc_filter_element(s.UD, N, i, j), TOL(1e-17, 1e-9));
            }
        }
    }
}

/* Each of twelve unknowns is seen by itself. The first shares a half of its error. */
static void test_one_unknown_that_is_seen_tells_of_the_one_that_shares_its_error(void)
{
    enum { TWO = 12 };
    for (size_t c = 6; c < TWO; c++) {
        rigcal_real UD[TWO * (TWO + 1) / 2] = {0}, room[TWO] = {0}, h[6] = {0};
        const rc_part part = {{6, -1}, {h, NULL}};

        for (size_t i = 0; i < TWO; i++) {
            UD[i * (i + 3) / 2] = 1;
        }
        UD[c * (c + 1) / 2] = RC(0.5);
        h[c - 6] = 1;
        ASSERT_NEAR(1, rc_filter_seen(room, UD, TWO, &part), 0);
        rc_filter_learn(UD, room, TWO, 1, 2, 1);
        for (size_t i = 0; i < TWO; i++) {
            const double Ph = i == c ? 1 : i == 0 ? 0.5 : 0;

            ASSERT_NEAR(Ph, room[i], 0);
            for (size_t j = 0; j <= i; j++) {
                const double Ph_j = j == c ? 1 : j == 0 ? 0.5 : 0;
                const double before = (i == j) + 0.25 * (i == 0) + 0.5 * (i == c && j == 0);

                ASSERT_NEAR(before - Ph * Ph_j / 2, rc_filter_element(UD, TWO, i, j),
                            TOL(1e-15, 1e-6));
            }
        }
    }
}

/* An innovation that overflows: the row is not taken and leaves no trace. */
static void test_a_row_that_overflows_leaves_no_trace(void)
{
    test_rng rng = test_seed(76);
    double h[N];
    rc_row row;
    rc_news news;
    static held before;

    begin(&rng, 0);
    random_row(&row, h, 1, 2, &rng);
    s.d[0] = RC(TOL(1e300, 1e38));
    row.h_a[0] = RC(TOL(1e10, 1e6));
    row.r = 0;
    before = s;
    TEST_ASSERT_FALSE(rc_filter_row(&news, &s.f, 1, 2, &row, 0, 0));
    TEST_ASSERT_EQUAL_MEMORY(&before, &s, sizeof s);
}

static void test_rows_of_a_body_that_is_open_count_for_less(void)
{
    test_rng rng = test_seed(80);
    rc_row row;
    rc_news held_news, closed, open;
    double h[N];
    rc_filter f;

    begin(&rng, 0);
    random_row(&row, h, 1, 2, &rng);
    row.r = 1;
    f = s.f;
    TEST_ASSERT_TRUE(rc_filter_ask(&held_news, &f, 1, 2, &row, 0));
    rc_filter_multiply(s.UD, N);
    rc_filter_spread(&s.f, s.UD, 1, RC(0.01), 0);
    rc_filter_factor(s.UD, N);
    rigcal_real kept[N * (N + 1) / 2];
    memcpy(kept, s.UD, sizeof kept);
    TEST_ASSERT_TRUE(rc_filter_row(&closed, &f, 1, 2, &row, 0, 2));
    memcpy(s.UD, kept, sizeof kept);
    memset(s.d, 0, sizeof s.d);
    TEST_ASSERT_TRUE(rc_filter_row(&open, &f, 1, 2, &row, 0, 1));
    double first_order = 1 + D(held_news.sd) * D(held_news.sd) - 1;
    for (int k = 0; k < 3; k++) {
        first_order += 0.01 * D(row.h_a[k]) * D(row.h_a[k]);
    }
    /* the open body is held, so nothing is added */
    ASSERT_NEAR(1, D(closed.sd) * D(closed.sd) / first_order, 1e-2);
    /* 64 times the variance of the turn, 0.03, and the rest */
    TEST_ASSERT_TRUE(D(open.sd) * D(open.sd) > 2.8 * first_order);
    TEST_ASSERT_TRUE(D(open.sd) * D(open.sd) < 3.2 * first_order);
}

/* The bend of a body is in proportion to the traces of the two blocks of its covariance.
 * That of the shift counts over the square of the reach. */
static void test_a_bend_is_that_of_the_variances_of_a_body(void)
{
    test_rng rng = test_seed(31);
    double unit = 0;

    for (int trial = 0; trial < TEST_TRIALS(60); trial++) {
        const size_t first = (size_t)(6 * (trial % (BODIES - 1)));
        const double reach = pow(10, test_uniform(&rng, -1, 1));
        double spread = 0;

        begin(&rng, 0);
        for (size_t i = 0; i < 6; i++) {
            spread += s.P[first + i][first + i] / ((i < 3) ? 1 : reach * reach);
        }
        const double bend = D(rc_filter_bend(s.UD, N, first, RC(reach)));

        unit = (trial == 0) ? bend / spread : unit;
        TEST_ASSERT_TRUE(unit > 0);
        ASSERT_NEAR(unit * spread, bend, TOL(1e-9, 1e-4) * bend);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_factors_multiply_to_the_covariance);
    RUN_TEST(test_a_covariance_beyond_what_the_variances_allow_is_none);
    RUN_TEST(test_a_variance_without_an_inverse_is_none);
    RUN_TEST(test_an_unknown_that_is_known_by_another_tells_no_more);
    RUN_TEST(test_rows_that_may_be_wrong_agree_with_dense_matrices);
    RUN_TEST(test_it_stays_positive_definite_where_one_direction_is_never_seen);
    RUN_TEST(test_small_steps_add_up);
    RUN_TEST(test_a_pose_that_is_moved_often_stays_a_rotation);
    RUN_TEST(test_a_move_of_the_frame_is_one_of_all_others);
    RUN_TEST(test_a_spread_of_equal_axes_is_that_of_its_covariance);
    RUN_TEST(test_a_body_comes_with_its_covariance_and_leaves);
    RUN_TEST(test_unknowns_that_are_known_exactly_learn_nothing);
    RUN_TEST(test_one_unknown_that_is_seen_tells_of_the_one_that_shares_its_error);
    RUN_TEST(test_a_row_that_overflows_leaves_no_trace);
    RUN_TEST(test_rows_of_a_body_that_is_open_count_for_less);
    RUN_TEST(test_a_bend_is_that_of_the_variances_of_a_body);
}
