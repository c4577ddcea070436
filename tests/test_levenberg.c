/* levenberg: the state machine by itself. Sequences made by hand take it through every
 * transition that rc_levenberg.h names. Then it searches for minima that are known. The
 * constants are in the source; the numbers here are far from them on both sides. */
#include <math.h>

#include "rc_levenberg.h"
#include "test_support.h"

/* Far below what any search could gain, and far above the rounding of a sum of 1. */
#define NOTHING RC(TOL(1e-18, 1e-9))
#define MUCH RC(0.5)

/* ---- hand-made states ------------------------------------------------------ */

/* A search that was begun and evaluated once: the sum is 1, and it wants a step. */
static rigcal_levenberg at_sum_1(void)
{
    rigcal_levenberg lm;
    rc_levenberg_begin(&lm, 0);
    rc_levenberg_evaluated(&lm, RIGCAL_OK, 1);
    return lm;
}

/* The same with Newton's H, as after a step that made the sum rise. */
static rigcal_levenberg with_newton(void)
{
    rigcal_levenberg lm = at_sum_1();
    TEST_ASSERT_FALSE(rc_levenberg_tried(&lm, RIGCAL_OK, 2, MUCH, 0));
    ASSERT_STATUS(RIGCAL_RUNNING, lm.status);
    rc_levenberg_evaluated(&lm, RIGCAL_OK, 1);
    TEST_ASSERT_EQUAL_INT(RC_NEWTON, lm.equations);
    return lm;
}

/* ---- begin, evaluated ------------------------------------------------------ */

static void test_a_search_begins_by_asking_for_equations(void)
{
    for (int is_near = 0; is_near < 2; is_near++) {
        rigcal_levenberg lm;
        FILL(lm);
        rc_levenberg_begin(&lm, is_near);
        TEST_ASSERT_EQUAL_INT(RC_WANT_EQUATIONS, lm.want);
        TEST_ASSERT_EQUAL_INT(RC_GAUSS_NEWTON, lm.equations);
        ASSERT_STATUS(RIGCAL_RUNNING, lm.status);
        ASSERT_NEAR(D(RC_MAX), lm.sum, 0); /* no sum is known */
        ASSERT_NEAR(0, lm.last_gain, 0);
        TEST_ASSERT_TRUE(is_near ? !(lm.lambda > 0) && !(lm.lambda < 0)
                                 : lm.lambda > 0 && D(lm.lambda) < 1e-2);
    }
}

static void test_after_equations_it_asks_for_a_step(void)
{
    const rigcal_levenberg lm = at_sum_1();
    TEST_ASSERT_EQUAL_INT(RC_WANT_STEP, lm.want);
    ASSERT_STATUS(RIGCAL_RUNNING, lm.status);
    ASSERT_NEAR(1, lm.sum, 0);
}

static void test_an_evaluation_that_fails_ends_it(void)
{
    rigcal_levenberg lm;
    rc_levenberg_begin(&lm, 0);
    rc_levenberg_evaluated(&lm, RIGCAL_ERR_BEHIND, 1);
    ASSERT_STATUS(RIGCAL_ERR_BEHIND, lm.status);
}

/* ---- not definite ---------------------------------------------------------- */

static void test_equations_that_are_singular_end_it(void)
{
    rigcal_levenberg lm = at_sum_1();
    rc_levenberg_not_definite(&lm);
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE, lm.status);
}

/* Newton's H is damped more and more. Then it is replaced by J^T J, which must be
 * evaluated. */
static void test_a_newtons_h_is_damped_until_it_is_given_up(void)
{
    rigcal_levenberg lm = with_newton();
    int calls = 0;
    while (lm.equations != RC_GAUSS_NEWTON) {
        const rigcal_real before = lm.lambda;
        TEST_ASSERT_EQUAL_INT(RC_WANT_STEP, lm.want); /* with the same equations */
        rc_levenberg_not_definite(&lm);
        ASSERT_STATUS(RIGCAL_RUNNING, lm.status);
        TEST_ASSERT_TRUE(lm.equations == RC_NEWTON_INDEFINITE ? lm.lambda > before
                                                              : D(before) > 1);
        TEST_ASSERT_LESS_THAN_INT(20, ++calls);
    }
    TEST_ASSERT_GREATER_THAN_INT(2, calls);
    TEST_ASSERT_EQUAL_INT(RC_WANT_EQUATIONS, lm.want);
    rc_levenberg_evaluated(&lm, RIGCAL_OK, 1);
    rc_levenberg_not_definite(&lm); /* J^T J is singular too */
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE, lm.status);
}

/* ---- promised -------------------------------------------------------------- */

static void test_a_step_that_promises_much_is_tried(void)
{
    rigcal_levenberg lm = at_sum_1();
    TEST_ASSERT_EQUAL_INT(RC_STEP_TRY, rc_levenberg_promised(&lm, MUCH, NOTHING));
    ASSERT_STATUS(RIGCAL_RUNNING, lm.status);
    TEST_ASSERT_EQUAL_INT(RC_GAUSS_NEWTON, lm.equations);
    ASSERT_NEAR(1, lm.sum, 0); /* no step has gained anything yet */
}

/* The sum is then the one of the quadratic model. A sum is never negative. */
static void test_a_step_that_promises_what_means_nothing_is_the_last(void)
{
    rigcal_levenberg lm = at_sum_1();
    TEST_ASSERT_EQUAL_INT(RC_STEP_LAST, rc_levenberg_promised(&lm, RC(0.25), RC(0.25)));
    ASSERT_STATUS(RIGCAL_OK, lm.status);
    ASSERT_NEAR(0.75, lm.sum, TOL(1e-15, 1e-7));

    lm = at_sum_1();
    TEST_ASSERT_EQUAL_INT(RC_STEP_LAST, rc_levenberg_promised(&lm, 2, 3));
    ASSERT_NEAR(0, lm.sum, 0);
}

static void test_a_step_that_promises_a_trifle_of_the_sum_is_the_last(void)
{
    rigcal_levenberg lm = at_sum_1();
    TEST_ASSERT_EQUAL_INT(RC_STEP_LAST, rc_levenberg_promised(&lm, NOTHING, 0));
    ASSERT_STATUS(RIGCAL_OK, lm.status);
}

/* The same gain after a gain of MUCH, and after one that is hardly larger: the latter
 * continues, because it is in a valley. */
static void test_gains_that_fall_fast_end_it_and_slow_ones_do_not(void)
{
    const rigcal_real gain = RC(TOL(1e-7, 1e-4));
    rigcal_levenberg fast = at_sum_1(), slow = at_sum_1();
    TEST_ASSERT_TRUE(rc_levenberg_tried(&fast, RIGCAL_OK, RC(0.9), MUCH, 0));
    TEST_ASSERT_EQUAL_INT(RC_STEP_LAST, rc_levenberg_promised(&fast, gain, NOTHING));
    ASSERT_STATUS(RIGCAL_OK, fast.status);

    TEST_ASSERT_TRUE(rc_levenberg_tried(&slow, RIGCAL_OK, RC(0.9), gain * RC(1.1), 0));
    TEST_ASSERT_EQUAL_INT(RC_STEP_TRY, rc_levenberg_promised(&slow, gain, NOTHING));
    ASSERT_STATUS(RIGCAL_RUNNING, slow.status);
    TEST_ASSERT_EQUAL_INT(RC_NEWTON, slow.equations); /* from the next evaluation on */
}

/* A gain that is negligible, but more than may be left at the end. If the gain before was a
 * tenth larger, ten times as much is still left. */
static void test_a_trifle_in_a_valley_is_not_the_last(void)
{
    const rigcal_real gain = RC(TOL(0.5e-12, 1.5e-6));
    rigcal_levenberg fast = at_sum_1(), slow = at_sum_1();
    TEST_ASSERT_TRUE(rc_levenberg_tried(&fast, RIGCAL_OK, RC(0.9), 4 * gain, 0));
    TEST_ASSERT_EQUAL_INT(RC_STEP_LAST, rc_levenberg_promised(&fast, gain, 0));
    TEST_ASSERT_TRUE(rc_levenberg_tried(&slow, RIGCAL_OK, RC(0.9), gain * RC(1.1), 0));
    TEST_ASSERT_EQUAL_INT(RC_STEP_TRY, rc_levenberg_promised(&slow, gain, 0));
}

/* The promise of a strongly damped step does not show how much is left to gain. */
static void test_a_step_that_is_damped_much_is_never_the_last(void)
{
    rigcal_levenberg lm = at_sum_1();
    for (int k = 0; k < 6; k++) {
        TEST_ASSERT_FALSE(rc_levenberg_tried(&lm, RIGCAL_OK, 2, MUCH, 0));
        rc_levenberg_evaluated(&lm, RIGCAL_OK, 1);
    }
    TEST_ASSERT_TRUE(D(lm.lambda) > 0.5);
    TEST_ASSERT_EQUAL_INT(RC_STEP_TRY, rc_levenberg_promised(&lm, NOTHING, RC(0.25)));
    ASSERT_STATUS(RIGCAL_RUNNING, lm.status);
}

/* If H is not positive definite the search is not at a minimum, however little is
 * promised. */
static void test_a_saddle_is_no_optimum(void)
{
    rigcal_levenberg lm = with_newton();
    rc_levenberg_not_definite(&lm);
    TEST_ASSERT_EQUAL_INT(RC_NEWTON_INDEFINITE, lm.equations);
    TEST_ASSERT_EQUAL_INT(RC_STEP_NONE, rc_levenberg_promised(&lm, NOTHING, RC(0.25)));
    ASSERT_STATUS(RIGCAL_BUDGET_SPENT, lm.status);
    ASSERT_NEAR(1, lm.sum, 0);

    lm = with_newton();
    rc_levenberg_not_definite(&lm);
    TEST_ASSERT_EQUAL_INT(RC_STEP_TRY, rc_levenberg_promised(&lm, MUCH, NOTHING));
    ASSERT_STATUS(RIGCAL_RUNNING, lm.status);
    TEST_ASSERT_EQUAL_INT(RC_NEWTON, lm.equations);
}

/* ---- tried ----------------------------------------------------------------- */

/* The equations at the end are known, so no further evaluation is wanted. */
static void test_a_step_that_helped_stays(void)
{
    rigcal_levenberg lm = at_sum_1();
    const rigcal_real before = lm.lambda;
    TEST_ASSERT_TRUE(rc_levenberg_tried(&lm, RIGCAL_OK, RC(0.5), MUCH, 0));
    TEST_ASSERT_EQUAL_INT(RC_WANT_STEP, lm.want);
    ASSERT_STATUS(RIGCAL_RUNNING, lm.status);
    ASSERT_NEAR(0.5, lm.sum, 0);
    TEST_ASSERT_TRUE(lm.lambda < before);
}

static void test_a_step_that_did_harm_is_taken_back(void)
{
    rigcal_levenberg lm = at_sum_1();
    const rigcal_real before = lm.lambda;
    TEST_ASSERT_FALSE(rc_levenberg_tried(&lm, RIGCAL_OK, RC(1.5), MUCH, 0));
    TEST_ASSERT_EQUAL_INT(RC_WANT_EQUATIONS, lm.want);
    ASSERT_STATUS(RIGCAL_RUNNING, lm.status);
    ASSERT_NEAR(1, lm.sum, 0);
    TEST_ASSERT_TRUE(lm.lambda > before);
}

static void test_a_place_that_cannot_be_evaluated_did_harm(void)
{
    rigcal_levenberg lm = at_sum_1();
    TEST_ASSERT_FALSE(rc_levenberg_tried(&lm, RIGCAL_ERR_BEHIND, 0, MUCH, 0));
    ASSERT_STATUS(RIGCAL_RUNNING, lm.status);
    ASSERT_NEAR(1, lm.sum, 0);
}

/* A sum of NaN never counts as better. */
static void test_a_sum_that_is_no_number_did_harm(void)
{
    rigcal_levenberg lm = at_sum_1();
    TEST_ASSERT_FALSE(rc_levenberg_tried(&lm, RIGCAL_OK, TEST_NAN, MUCH, 0));
    ASSERT_NEAR(1, lm.sum, 0);
}

/* A rise of the sum by rounding, or by a negligible amount, is not harm. */
static void test_a_rise_of_the_sum_that_means_nothing_is_none(void)
{
    rigcal_levenberg lm = at_sum_1();
    TEST_ASSERT_TRUE(rc_levenberg_tried(&lm, RIGCAL_OK, 1 + RC_EPS, MUCH, 0));
    lm = at_sum_1();
    TEST_ASSERT_TRUE(rc_levenberg_tried(&lm, RIGCAL_OK, RC(1.2), MUCH, RC(0.25)));
    lm = at_sum_1();
    TEST_ASSERT_FALSE(rc_levenberg_tried(&lm, RIGCAL_OK, RC(1.2), MUCH, RC(0.125)));
}

static void test_a_step_that_was_not_damped_is_damped_after_harm(void)
{
    rigcal_levenberg lm;
    rc_levenberg_begin(&lm, 1);
    rc_levenberg_evaluated(&lm, RIGCAL_OK, 1);
    TEST_ASSERT_FALSE(rc_levenberg_tried(&lm, RIGCAL_OK, 2, MUCH, 0));
    TEST_ASSERT_TRUE(lm.lambda > 0);
}

/* If a step that promised almost nothing makes the sum rise, the rise is rounding: the
 * search ends. */
static void test_harm_by_a_step_that_promised_a_trifle_is_rounding(void)
{
    rigcal_levenberg lm = at_sum_1();
    TEST_ASSERT_FALSE(
        rc_levenberg_tried(&lm, RIGCAL_OK, RC(1.001), RC(TOL(1e-10, 1e-6)), 0));
    ASSERT_STATUS(RIGCAL_OK, lm.status);
    ASSERT_NEAR(1, lm.sum, 0);
}

static void test_harm_again_and_again_ends_it(void)
{
    rigcal_levenberg lm = at_sum_1();
    int times = 0;
    while (lm.status == RIGCAL_RUNNING) {
        if (lm.want == RC_WANT_EQUATIONS) {
            rc_levenberg_evaluated(&lm, RIGCAL_OK, 1);
        }
        TEST_ASSERT_FALSE(rc_levenberg_tried(&lm, RIGCAL_OK, 2, MUCH, 0));
        TEST_ASSERT_LESS_THAN_INT(30, ++times);
    }
    ASSERT_STATUS(RIGCAL_OK, lm.status);
    TEST_ASSERT_GREATER_THAN_INT(5, times);
}

/* Gains before a rise do not show how fast gains fall after it. */
static void test_harm_forgets_the_gains_before_it(void)
{
    const rigcal_real gain = RC(TOL(1e-7, 1e-4));
    rigcal_levenberg lm = at_sum_1();
    TEST_ASSERT_TRUE(rc_levenberg_tried(&lm, RIGCAL_OK, RC(0.9), MUCH, 0));
    TEST_ASSERT_FALSE(rc_levenberg_tried(&lm, RIGCAL_OK, 2, MUCH, 0));
    rc_levenberg_evaluated(&lm, RIGCAL_OK, RC(0.9));
    TEST_ASSERT_EQUAL_INT(RC_STEP_TRY, rc_levenberg_promised(&lm, gain, NOTHING));
}

/* ---- whole searches -------------------------------------------------------- */

/* Two residuals of two unknowns, and J. */
typedef void (*residuals)(double e[2], double J[4], const double x[2]);

static void rosenbrock(double e[2], double J[4], const double x[2])
{
    e[0] = 10 * (x[1] - x[0] * x[0]);
    e[1] = 1 - x[0];
    J[0] = -20 * x[0];
    J[1] = 10;
    J[2] = -1;
    J[3] = 0;
}

static void line(double e[2], double J[4], const double x[2])
{
    e[0] = 3 * x[0] + x[1] - 5;
    e[1] = x[0] - 2 * x[1] + 3;
    J[0] = 3;
    J[1] = 1;
    J[2] = 1;
    J[3] = -2;
}

typedef struct {
    rigcal_levenberg lm;
    double x[2], g[2], H[3]; /* g = -J^T e, so that H d = g */
    int evals;
} search;

static double evaluate(search *s, residuals f)
{
    double e[2], J[4];
    f(e, J, s->x);
    for (int k = 0; k < 2; k++) {
        s->g[k] = -(J[k] * e[0] + J[2 + k] * e[1]);
    }
    s->H[0] = J[0] * J[0] + J[2] * J[2];
    s->H[1] = J[0] * J[1] + J[2] * J[3];
    s->H[2] = J[1] * J[1] + J[3] * J[3];
    s->evals++;
    return e[0] * e[0] + e[1] * e[1];
}

/* One pass of the loop of rc_levenberg.h. */
static void turn(search *s, residuals f)
{
    const double lambda = D(s->lm.lambda), before[2] = {s->x[0], s->x[1]};
    if (s->lm.want == RC_WANT_EQUATIONS) {
        const double sum = evaluate(s, f);
        rc_levenberg_evaluated(&s->lm, RIGCAL_OK, RC(sum));
        return;
    }
    const double a = s->H[0] * (1 + lambda), b = s->H[1], c = s->H[2] * (1 + lambda);
    const double d[2] = {(c * s->g[0] - b * s->g[1]) / (a * c - b * b),
                         (a * s->g[1] - b * s->g[0]) / (a * c - b * b)};
    const double gain = d[0] * s->g[0] + d[1] * s->g[1];
    const int taken = rc_levenberg_promised(&s->lm, RC(gain), 0);
    if (taken != RC_STEP_NONE) {
        s->x[0] += d[0];
        s->x[1] += d[1];
    }
    if (taken == RC_STEP_TRY) {
        const double sum = evaluate(s, f);
        if (!rc_levenberg_tried(&s->lm, RIGCAL_OK, RC(sum), RC(gain), 0)) {
            s->x[0] = before[0];
            s->x[1] = before[1];
        }
    }
}

static void begin(search *s, double x, double y)
{
    s->x[0] = x;
    s->x[1] = y;
    s->evals = 0;
    rc_levenberg_begin(&s->lm, 0);
}

/* Two linear equations: one step, after which the end is recognised at once. */
static void test_a_linear_problem_takes_few_evaluations(void)
{
    search s;
    begin(&s, 100, -70);
    while (s.lm.status == RIGCAL_RUNNING) {
        turn(&s, line);
        TEST_ASSERT_LESS_OR_EQUAL_INT(5, s.evals);
    }
    ASSERT_STATUS(RIGCAL_OK, s.lm.status);
    ASSERT_NEAR(1, s.x[0], TOL(1e-9, 1e-4));
    ASSERT_NEAR(2, s.x[1], TOL(1e-9, 1e-4));
}

/* Rosenbrock's valley, from his own start and from the side. */
static void test_a_valley_is_followed_to_its_end(void)
{
    static const double START[4][2] = {{-1.2, 1}, {3, -2}, {-5, 8}, {0, 0}};
    for (int i = 0; i < 4; i++) {
        search s;
        begin(&s, START[i][0], START[i][1]);
        while (s.lm.status == RIGCAL_RUNNING) {
            turn(&s, rosenbrock);
            TEST_ASSERT_LESS_OR_EQUAL_INT(100, s.evals);
        }
        ASSERT_STATUS(RIGCAL_OK, s.lm.status);
        ASSERT_NEAR(1, s.x[0], TOL(1e-6, 1e-3));
        ASSERT_NEAR(1, s.x[1], TOL(1e-6, 2e-3));
    }
}

/* A search that is copied at any pass continues in the same way. */
static void test_a_search_may_pause_at_any_turn(void)
{
    search s, copy;
    begin(&s, -1.2, 1);
    while (s.lm.status == RIGCAL_RUNNING) {
        copy = s;
        FILL(s);
        s = copy;
        turn(&s, rosenbrock);
        turn(&copy, rosenbrock);
        TEST_ASSERT_EQUAL_MEMORY(&copy.x, &s.x, sizeof s.x);
        TEST_ASSERT_EQUAL_INT(copy.lm.want, s.lm.want);
    }
    ASSERT_NEAR(1, s.x[0], TOL(1e-6, 1e-3));
}

/* ---- the limits themselves ---------------------------------------------------
 * With a sum of 1 each limit is met exactly. Just beyond it the other way is taken. */

static void test_the_limits_of_the_damping(void)
{
    static const double BEFORE[6] = {0, 1e-5, 1e-4, 1, 10, 10.01};
    static const double INDEFINITE[6] = {1e-4, 1e-4, 1e-3, 10, 100, 10.01};
    static const double HARM[6] = {1e-5, 1e-4, 1e-3, 10, 100, 100.1};

    for (int k = 0; k < 6; k++) {
        rigcal_levenberg lm = with_newton();
        lm.lambda = RC(BEFORE[k]);
        rc_levenberg_not_definite(&lm);
        ASSERT_NEAR(INDEFINITE[k], lm.lambda, TOL(1e-15, 1e-6) * (1 + INDEFINITE[k]));
        TEST_ASSERT_EQUAL_INT(k < 5 ? RC_NEWTON_INDEFINITE : RC_GAUSS_NEWTON, lm.equations);

        lm = at_sum_1();
        ASSERT_NEAR(1e-5, lm.lambda, TOL(1e-20, 1e-11));
        lm.lambda = RC(BEFORE[k]);
        TEST_ASSERT_FALSE(rc_levenberg_tried(&lm, RIGCAL_OK, 2, MUCH, 0));
        ASSERT_NEAR(HARM[k], lm.lambda, TOL(1e-15, 1e-6) * (1 + HARM[k]));

        lm = at_sum_1();
        lm.lambda = RC(BEFORE[k]);
        TEST_ASSERT_TRUE(rc_levenberg_tried(&lm, RIGCAL_OK, RC(0.5), MUCH, 0));
        ASSERT_NEAR(BEFORE[k] / 10, lm.lambda, TOL(1e-15, 1e-6) * (1 + BEFORE[k]));
    }
}

static void test_the_limits_of_the_last_step(void)
{
    for (int more = 0; more < 2; more++) {
        const rigcal_real by = more ? RC(1.001) : 1;
        const int last = more ? RC_STEP_TRY : RC_STEP_LAST;
        rigcal_levenberg lm = at_sum_1();
        lm.lambda = RC(1e-2) * by;
        TEST_ASSERT_EQUAL_INT(last, rc_levenberg_promised(&lm, RC(0.25), RC(0.25)));

        lm = at_sum_1();
        TEST_ASSERT_EQUAL_INT(last, rc_levenberg_promised(&lm, RC(0.25) * by, RC(0.25)));
        lm = at_sum_1();
        TEST_ASSERT_EQUAL_INT(last,
                              rc_levenberg_promised(&lm, RC(TOL(1e-13, 1e-6)) * by, 0));

        lm = at_sum_1(); /* slow */
        lm.last_gain = 1;
        TEST_ASSERT_EQUAL_INT(RC_STEP_TRY, rc_levenberg_promised(&lm, RC(0.1) * by, 0));
        TEST_ASSERT_EQUAL_INT(more ? RC_NEWTON : RC_GAUSS_NEWTON, lm.equations);
        if (!RIGCAL_USE_FLOAT) { /* g^2 / sum = 1e-12 (g_before - g), exact in binary */
            const rigcal_real gain = RC(1e-12), fell = RC(ldexp(1, -42));
            lm = at_sum_1();
            lm.sum = gain / fell;
            lm.last_gain = gain + fell;
            TEST_ASSERT_EQUAL_INT(last, rc_levenberg_promised(&lm, gain * by, 0));
        }
    }
}

static void test_the_limits_of_harm(void)
{
    for (int more = 0; more < 2; more++) {
        const rigcal_real by = more ? RC(1.001) : 1;
        rigcal_levenberg lm = at_sum_1();
        TEST_ASSERT_EQUAL_INT(
            !more, rc_levenberg_tried(&lm, RIGCAL_OK, 1 + RC(16 + more) * RC_EPS, MUCH, 0));
        lm = at_sum_1();
        TEST_ASSERT_FALSE(
            rc_levenberg_tried(&lm, RIGCAL_OK, 2, RC(TOL(1e-7, 1e-4)) * by, 0));
        ASSERT_STATUS(more ? RIGCAL_RUNNING : RIGCAL_OK, lm.status);
        lm = at_sum_1();
        lm.lambda = RC(1e7) * by;
        TEST_ASSERT_FALSE(rc_levenberg_tried(&lm, RIGCAL_OK, 2, MUCH, 0));
        ASSERT_STATUS(more ? RIGCAL_OK : RIGCAL_RUNNING, lm.status);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_search_begins_by_asking_for_equations);
    RUN_TEST(test_after_equations_it_asks_for_a_step);
    RUN_TEST(test_an_evaluation_that_fails_ends_it);
    RUN_TEST(test_equations_that_are_singular_end_it);
    RUN_TEST(test_a_newtons_h_is_damped_until_it_is_given_up);
    RUN_TEST(test_a_step_that_promises_much_is_tried);
    RUN_TEST(test_a_step_that_promises_what_means_nothing_is_the_last);
    RUN_TEST(test_a_step_that_promises_a_trifle_of_the_sum_is_the_last);
    RUN_TEST(test_gains_that_fall_fast_end_it_and_slow_ones_do_not);
    RUN_TEST(test_a_trifle_in_a_valley_is_not_the_last);
    RUN_TEST(test_a_step_that_is_damped_much_is_never_the_last);
    RUN_TEST(test_a_saddle_is_no_optimum);
    RUN_TEST(test_a_step_that_helped_stays);
    RUN_TEST(test_a_step_that_did_harm_is_taken_back);
    RUN_TEST(test_a_place_that_cannot_be_evaluated_did_harm);
    RUN_TEST(test_a_sum_that_is_no_number_did_harm);
    RUN_TEST(test_a_rise_of_the_sum_that_means_nothing_is_none);
    RUN_TEST(test_a_step_that_was_not_damped_is_damped_after_harm);
    RUN_TEST(test_harm_by_a_step_that_promised_a_trifle_is_rounding);
    RUN_TEST(test_harm_again_and_again_ends_it);
    RUN_TEST(test_harm_forgets_the_gains_before_it);
    RUN_TEST(test_a_linear_problem_takes_few_evaluations);
    RUN_TEST(test_a_valley_is_followed_to_its_end);
    RUN_TEST(test_a_search_may_pause_at_any_turn);
    RUN_TEST(test_the_limits_of_the_damping);
    RUN_TEST(test_the_limits_of_the_last_step);
    RUN_TEST(test_the_limits_of_harm);
}
