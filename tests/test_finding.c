/* finding: the numbers of a fault and the verdict. The truth: the formulas of (H6) to (H14)
 * and quantiles by SciPy. */
#include <math.h>
#include <string.h>

#include "rc_finding.h"
#include "test_support.h"

/* 200 numbers with the sum 260. The poses of the views by themselves leave 120; 100 degrees
 * of freedom. */
static const rc_common COMMON = {260, 100, 200, 150, 30, 120};

static void test_a_step_whose_numbers_overflow_is_not_seen(void)
{
    const rigcal_real one = 1, large = RC(TOL(1e300, 1e38)), tiny = RC(1e-3);
    rigcal_fault fault;

    for (int what = 0; what < 4; what++) {
        rc_one_step step = {1, 1, &one, &tiny, &one, &one, 100, 0};

        memset(&fault, 0, sizeof fault);
        fault.kind = RIGCAL_FAULT_FOCAL;
        fault.camera = 2;
        fault.placement = -1;
        if (what == 1) { /* its effect on the camera */
            step.turn = &large;
            step.variance = &large;
        } else if (what == 2) { /* its value */
            const rigcal_real infinite = TEST_INF;
            step.theta = &infinite;
            rc_finding_of(&fault, &COMMON, &step);
        } else if (what == 3) { /* its sigma */
            const rigcal_real infinite = TEST_INF, nothing = 0;
            step.variance = &infinite;
            step.turn = step.shift = &nothing;
            rc_finding_of(&fault, &COMMON, &step);
        }
        if (what < 2) {
            rc_finding_of(&fault, &COMMON, &step);
        }
        TEST_ASSERT_EQUAL_INT32(what == 0, fault.is_seen);
        TEST_ASSERT_EQUAL_INT32(RIGCAL_FAULT_FOCAL, fault.kind);
        TEST_ASSERT_EQUAL_INT32(2, fault.camera);
        if (what > 0) {
            ASSERT_NEAR(0, fault.value[0], 0);
            ASSERT_NEAR(0, fault.turn, 0);
        }
    }
}

/* Then no step can gain: it is as good as chance, and only costs its parameter. */
static void test_of_exact_pixels_no_step_gains(void)
{
    const rigcal_real one = 1, tiny = RC(1e-3);
    const rc_one_step step = {1, 1, &one, &tiny, &one, &one, 100, 0};
    rc_common exact = COMMON;
    rigcal_fault fault = {.kind = RIGCAL_FAULT_FOCAL};

    exact.sum = exact.own = 0;
    rc_finding_of(&fault, &exact, &step);
    ASSERT_NEAR(0, fault.gain, 0);
    ASSERT_NEAR(1, fault.p, 0);
    ASSERT_NEAR(log(200), fault.bic, TOL(1e-12, 1e-5));
}

/* The first of two parameters has an infinite sigma, and no effect. */
static void test_a_step_with_one_infinite_sigma_is_not_seen(void)
{
    const rigcal_real theta[2] = {1, 1}, variance[2] = {TEST_INF, RC(1e-3)};
    const rigcal_real turn[2] = {0, 1};
    const rc_one_step step = {2, 1, theta, variance, turn, turn, 100, 0};
    rigcal_fault fault = {0};

    rc_finding_of(&fault, &COMMON, &step);
    TEST_ASSERT_EQUAL_INT32(0, fault.is_seen);
    ASSERT_NEAR(0, fault.sigma[0], 0);
    ASSERT_NEAR(0, fault.sigma[1], 0);
}

/* For example the clocks of many cameras: the first ones are named, and all count. */
static void test_of_many_parameters_the_first_are_told(void)
{
    enum { MANY = RIGCAL_FAULT_VALUES + 2 };
    rigcal_real theta[MANY], variance[MANY], turn[MANY];
    rigcal_fault fault = {0};

    for (int i = 0; i < MANY; i++) {
        theta[i] = RC(1 + i);
        variance[i] = 1;
        turn[i] = RC(i);
    }
    const rc_one_step step = {MANY, 1, theta, variance, turn, turn, 100, 0};
    rc_finding_of(&fault, &COMMON, &step);
    TEST_ASSERT_EQUAL_INT32(MANY, fault.n);
    for (int i = 0; i < RIGCAL_FAULT_VALUES; i++) {
        ASSERT_NEAR(1 + i, fault.value[i], 0);
    }
    const double sigma = sqrt((260 - 100) / (150. - MANY));
    ASSERT_NEAR(sigma, fault.sigma[0], TOL(1e-14, 1e-6));
    ASSERT_NEAR(5 * sigma * (MANY - 1), fault.turn, TOL(1e-13, 1e-4));
}

static void test_the_verdict_of_what_could_not_be_seen(void)
{
    rigcal_fault faults[3];
    rigcal_faults found;

    memset(faults, 0, sizeof faults);
    memset(&found, 0, sizeof found);
    found.F = rc_F_of(&COMMON, 0, 0, 0);
    ASSERT_NEAR((260 - 100) / 30. / (100 / 120.), found.F, TOL(1e-14, 1e-5));
    found.n = 3;
    rc_finding_judge(&found, faults, &COMMON); /* nothing was seen */
    TEST_ASSERT_EQUAL_INT32(RIGCAL_RIG_UNEXPLAINED, found.verdict);
    TEST_ASSERT_EQUAL_INT32(0, found.bits & RIGCAL_FAULTS_NAMED);
    found.n_seen = 1;
    faults[0].is_seen = 1;
    faults[0].bic = -50;
    faults[1].bic = -50; /* but it was not seen, so it is not alike */
    rc_finding_judge(&found, faults, &COMMON);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_RIG_FOUND, found.verdict);
    TEST_ASSERT_EQUAL_INT32(0, found.n_alike);
    faults[1].is_seen = 1;
    rc_finding_judge(&found, faults, &COMMON);
    TEST_ASSERT_EQUAL_INT32(1, found.n_alike);
    const rc_common exact = {0, 0, 200, 150, 30, 120};
    ASSERT_NEAR(0, rc_F_of(&exact, 0, 0, 0), 0);
}

static void test_residues_of_nothing_have_no_pattern(void)
{
    const rc_common exact = {0, 0, 200, 150, 30, 120};
    rc_residues r = {50, 60, 0, 0, 8, 10, 4};
    rigcal_faults found;

    memset(&found, 0, sizeof found);
    rc_finding_residues(&found, &r, &COMMON);
    ASSERT_NEAR(60 / (100 / 120.) / 100, found.pattern, TOL(1e-14, 1e-6));
    TEST_ASSERT_EQUAL_INT32(RIGCAL_FAULTS_PATTERN, found.bits); /* but not along the
                                                                   motion */
    ASSERT_NEAR(0.8, found.along, TOL(1e-14, 1e-6));
    ASSERT_NEAR(sqrt(2), found.along_time, TOL(1e-14, 1e-6));
    memset(&found, 0, sizeof found);
    r.speed2 = 0; /* the target stood still */
    rc_finding_residues(&found, &r, &exact);
    ASSERT_NEAR(0, found.pattern, 0);
    ASSERT_NEAR(0, found.along, 0);
    TEST_ASSERT_EQUAL_INT32(0, found.bits);
    r.n = 0;
    rc_finding_residues(&found, &r, &COMMON);
    ASSERT_NEAR(0, found.pattern_sigma, 0);
}

/* If F = 5 and a fault leaves F = 2, it explains 3 of 4. */
static void test_what_a_fault_explains_is_its_part_of_F_less_one(void)
{
    rigcal_fault faults[1];
    rigcal_faults found;

    memset(faults, 0, sizeof faults);
    memset(&found, 0, sizeof found);
    found.F = 5;
    found.n = 1;
    found.n_seen = 1;
    faults[0].is_seen = 1;
    faults[0].F_after = 2;
    faults[0].bic = -50;
    rc_finding_judge(&found, faults, &COMMON);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_FAULTS_NAMED, found.bits & RIGCAL_FAULTS_NAMED);
    ASSERT_NEAR(0.75, found.explained, TOL(1e-15, 1e-6));
}

/* Faults with random BIC, seen or not, in random order. The best of them stay, in order;
 * faults that are not seen come last. */
static void test_faults_are_ranked_in_any_order(void)
{
    enum { OFFERED = 12, ROOM = 7 };
    test_rng rng = test_seed(77);

    for (int trial = 0; trial < 200; trial++) {
        rigcal_fault ranked[ROOM + 1];
        double bic[OFFERED];
        int32_t n = 0;
        int seen = 0;

        memset(ranked, 0, sizeof ranked);
        ranked[ROOM].kind = 99;
        for (int i = 0; i < OFFERED; i++) {
            rigcal_fault fault;

            memset(&fault, 0, sizeof fault);
            fault.is_seen = test_next(&rng) % 3 != 0;
            fault.bic = RC(test_uniform(&rng, -100, 0));
            bic[seen] = D(fault.bic);
            seen += fault.is_seen;
            rc_finding_rank(ranked, &n, ROOM, &fault);
        }
        TEST_ASSERT_EQUAL_INT32(ROOM, n);
        TEST_ASSERT_EQUAL_INT32(99, ranked[ROOM].kind);
        for (int k = 0; k < ROOM; k++) {
            int before = 0;

            TEST_ASSERT_EQUAL_INT32(k < seen, ranked[k].is_seen);
            for (int i = 0; i < seen; i++) {
                before += bic[i] < D(ranked[k].bic);
            }
            TEST_ASSERT_TRUE(k >= seen || before == k);
        }
    }
}

/* F is 5. A fault explains it if at most half of F - 1 is left, that is, if F falls to
 * 3. */
static void test_a_fault_explains_half_of_what_disagrees(void)
{
    const rc_common common = {1505, 1000, 2000, 1101, 101, 1000};
    const rigcal_real one = 1;
    rc_one_step step = {1, 1, &one, &one, &one, &one, 0, 0};
    rigcal_fault fault;

    ASSERT_NEAR(5, rc_F_of(&common, 0, 0, 0), TOL(1e-12, 1e-5));
    for (int less = 0; less < 2; less++) {
        memset(&fault, 0, sizeof fault);
        step.gain = RC(205 - 0.1 * less);
        rc_finding_of(&fault, &common, &step);
        ASSERT_NEAR(3 + 0.001 * less, fault.F_after, TOL(1e-12, 1e-5));
        TEST_ASSERT_EQUAL_INT(!less, fault.explains);
    }
}

/* ---- F ------------------------------------------------------------------------- */

static void test_F_is_between_the_views_over_within(void)
{
    /* (240 - 90) / (30 - 5) / (90 / 120) */
    ASSERT_NEAR(8, rc_F_of(&COMMON, 20, 10, 5), TOL(1e-14, 1e-5));
    ASSERT_NEAR(150 / 2. / 0.75, rc_F_of(&COMMON, 20, 10, 28), TOL(1e-12, 1e-4));
    /* one degree of freedom between them at least */
    for (int k = 29; k < 32; k++) {
        ASSERT_NEAR(150 / 0.75, rc_F_of(&COMMON, 20, 10, RC(k)), TOL(1e-12, 1e-4));
    }
    ASSERT_NEAR((240 - 0.5) / 30 / (0.5 / 120), rc_F_of(&COMMON, 20, RC(99.5), 0),
                TOL(1e-10, 1e-2));
    ASSERT_NEAR(0, rc_F_of(&COMMON, 20, 100, 0), 0);
}

/* Quantiles of F by SciPy, for 0.001 and 20 degrees of freedom within. */
static void test_an_F_of_a_chance_below_a_thousandth_disagrees(void)
{
    static const double LIMIT[5] = {7.096034, 8.098380, 9.952623, 14.818776, 14.818776};
    const rc_common common = {260, 100, 200, 150, 4, 20};

    for (int k = 0; k < 5; k++) {
        TEST_ASSERT_FALSE(rc_F_disagrees(&common, RC(0.999 * LIMIT[k]), RC(k)));
        TEST_ASSERT_TRUE(rc_F_disagrees(&common, RC(1.001 * LIMIT[k]), RC(k)));
    }
}

/* ---- a fault --------------------------------------------------------------------- */

/* The chance that noise exceeds F for 2 and n degrees of freedom. */
static double tail_of_two(double F, double n)
{
    return pow(1 + 2 * F / n, -n / 2);
}

static void test_a_step_gives_all_numbers_of_a_fault(void)
{
    static const rigcal_real theta[2] = {3, -4}, variance[2] = {4, 9};
    static const rigcal_real turn[2] = {RC(0.5), RC(0.25)}, shift[2] = {RC(0.125), 2};

    for (int turned = 0; turned < 2; turned++) { /* 1: the second turns most */
        const rc_one_step step = {
            2, 1, theta, variance, turned ? shift : turn, turned ? turn : shift, 60, 10};
        const double s = sqrt(200. / 148);
        rigcal_fault fault = {.kind = RIGCAL_FAULT_CENTRE, .camera = 1, .placement = -1};

        rc_finding_of(&fault, &COMMON, &step);
        TEST_ASSERT_EQUAL_INT32(1, fault.is_seen);
        TEST_ASSERT_EQUAL_INT32(2, fault.n);
        ASSERT_NEAR(60, fault.gain, 0);
        ASSERT_NEAR(1, D(fault.p) / tail_of_two(30 / (s * s), 148), TOL(1e-9, 1e-3));
        ASSERT_NEAR(200 * log(200. / 260) + 2 * log(200.), fault.bic, TOL(1e-12, 1e-4));
        ASSERT_NEAR(110 / 28. / 0.75, fault.F_after, TOL(1e-13, 1e-5));
        for (int i = 0; i < RIGCAL_FAULT_VALUES; i++) {
            ASSERT_NEAR(i > 1 ? 0 : i > 0 ? -4 : 3, fault.value[i], 0);
            ASSERT_NEAR(i > 1 ? 0 : (2 + i) * s, fault.sigma[i], TOL(1e-14, 1e-6));
        }
        ASSERT_NEAR(5 * s * (turned ? 6 : 1), fault.turn, TOL(1e-13, 1e-5));
        ASSERT_NEAR(5 * s * (turned ? 1 : 6), fault.shift, TOL(1e-13, 1e-5));
    }
}

/* The chance is multiplied by the number of tries, and is at most 1. */
static void test_a_chance_counts_each_try(void)
{
    const rigcal_real one[2] = {1, 1};

    for (size_t tries = 1; tries < 20; tries++) {
        const rc_one_step step = {2, tries, one, one, one, one, 10, 0};
        const double p = (double)tries * tail_of_two(5 / (250. / 148), 148);
        rigcal_fault fault = {0};

        rc_finding_of(&fault, &COMMON, &step);
        ASSERT_NEAR(fmin(1, p), fault.p, TOL(1e-9, 1e-4));
    }
}

/* A gain of all that there is, or more, has a logarithm. Exact pixels show no fault. */
static void test_a_fault_that_explains_everything_has_finite_numbers(void)
{
    const rc_common exact = {0, 0, 200, 150, 30, 120};
    const rigcal_real one = 1;

    for (int k = 0; k < 3; k++) {
        const rc_one_step step = {1, 1, &one, &one, &one, &one, RC(130 * k), 0};
        rigcal_fault fault = {0};

        rc_finding_of(&fault, &COMMON, &step);
        TEST_ASSERT_EQUAL_INT32(1, fault.is_seen);
        TEST_ASSERT_TRUE(k < 2 || fault.bic < RC(-2000));
        TEST_ASSERT_TRUE(fault.gain < 260 && fault.gain > RC(129.9 * k) - 1);
        TEST_ASSERT_TRUE(fault.sigma[0] > 0);
    }
    const rc_one_step none = {1, 1, &one, &one, &one, &one, 0, 0};
    rigcal_fault fault = {0};
    rc_finding_of(&fault, &exact, &none);
    TEST_ASSERT_TRUE(isfinite(D(fault.p)) && isfinite(D(fault.bic)));
}

/* Whichever number overflows, what identifies the fault stays, and no number. */
static void test_a_fault_with_one_number_that_overflows_keeps_its_name_alone(void)
{
    const rigcal_real one = 1, none = 0, infinite = TEST_INF;
    const rigcal_fault name = {.kind = 4, .camera = 2, .placement = 7, .n = 1};
    const rc_one_step right = {1, 1, &one, &one, &one, &one, 100, 0};

    for (int what = 0; what < 4; what++) {
        rc_one_step step = right;
        rigcal_fault fault = {.kind = 4, .camera = 2, .placement = 7};

        step.turn = what == 1 ? &infinite : &none;
        step.shift = what == 2 ? &infinite : &none;
        step.theta = what == 3 ? &infinite : &one;
        rc_finding_of(&fault, &COMMON, &step);
        TEST_ASSERT_EQUAL_INT32(what == 0, fault.is_seen);
        if (what > 0) {
            TEST_ASSERT_EQUAL_MEMORY(&name, &fault, sizeof fault);
        }
    }
}

/* For 99 and 1000 degrees of freedom the quantile of 0.001 is 1.535, by SciPy: 1.58
 * disagrees, and 1.42 does not. Both are more than half of F - 1 = 0.6. */
static void test_a_fault_explains_too_if_what_is_left_may_be_noise(void)
{
    const rc_common common = {1160, 1000, 2000, 1101, 100, 1000};
    const rigcal_real one = 1;

    for (int less = 0; less < 2; less++) {
        const rc_one_step step = {1, 1, &one, &one, &one, &one, less ? 4 : RC(19.42), 0};
        rigcal_fault fault = {0};

        rc_finding_of(&fault, &common, &step);
        ASSERT_NEAR(less ? 156 / 99. : 1.42, fault.F_after, TOL(1e-12, 1e-5));
        TEST_ASSERT_EQUAL_INT(!less, fault.explains);
    }
}

/* ---- the order --------------------------------------------------------------------- */

/* Those that are not seen come in the order of their kinds. Of equals the first offered
 * stays first. */
static void test_faults_that_are_not_seen_are_in_the_order_of_their_kinds(void)
{
    static const int32_t KINDS[6] = {5, 2, 9, 0, 2, 7}, SORTED[5] = {0, 2, 2, 5, 7};
    rigcal_fault ranked[6];
    int32_t n = 0;

    memset(ranked, 0, sizeof ranked);
    ranked[5].kind = 99;
    for (int i = 0; i < 6; i++) {
        const rigcal_fault fault = {.kind = KINDS[i], .camera = i, .bic = RC(-i)};

        rc_finding_rank(ranked, &n, 5, &fault);
        TEST_ASSERT_EQUAL_INT32(i < 5 ? i + 1 : 5, n);
    }
    for (int i = 0; i < 5; i++) {
        TEST_ASSERT_EQUAL_INT32(SORTED[i], ranked[i].kind);
    }
    TEST_ASSERT_TRUE(ranked[1].camera == 1 && ranked[2].camera == 4);
    TEST_ASSERT_EQUAL_INT32(99, ranked[5].kind);
    n = 0;
    for (int i = 0; i < 4; i++) {
        const rigcal_fault fault = {.is_seen = 1, .kind = 3 - i, .bic = i < 2 ? -1 : -2};

        rc_finding_rank(ranked, &n, 3, &fault);
    }
    TEST_ASSERT_TRUE(ranked[0].kind == 1 && ranked[1].kind == 0 && ranked[2].kind == 3);
}

/* ---- the verdict --------------------------------------------------------------------- */

/* Three faults that are seen. The rig disagrees if F is 6.4, as COMMON says. */
static void judge(rigcal_faults *found, const double p[3], const double bic[3],
                  int explains, double F)
{
    rigcal_fault faults[4];

    memset(faults, 0, sizeof faults);
    memset(found, 0, sizeof *found);
    for (int i = 0; i < 4; i++) {
        faults[i].is_seen = 1;
        faults[i].p = RC(i < 3 ? p[i] : 0);
        faults[i].bic = RC(i < 3 ? bic[i] : bic[0]);
        faults[i].explains = i == 0 ? explains : !explains;
        faults[i].F_after = RC(1 + i);
    }
    found->n = 3; /* the fourth is not in the list */
    found->n_seen = 3;
    found->F = RC(F);
    rc_finding_judge(found, faults, &COMMON);
}

static void test_the_first_fault_is_found_if_its_chance_among_all_is_below_a_percent(void)
{
    static const double FAR[3] = {-50, -10, 0}, P[3] = {0.0033, 0.5, 0.5},
                        P_MORE[3] = {0.0034, 0, 0};
    rigcal_faults found;

    for (int explains = 0; explains < 2; explains++) {
        for (int disagrees = 0; disagrees < 2; disagrees++) {
            judge(&found, P, FAR, explains, disagrees ? 6.4 : 1.5);
            TEST_ASSERT_EQUAL_INT32(!disagrees ? RIGCAL_RIG_AGREES
                                    : explains ? RIGCAL_RIG_EXPLAINED
                                               : RIGCAL_RIG_FOUND,
                                    found.verdict);
            TEST_ASSERT_EQUAL_INT32(RIGCAL_FAULTS_NAMED, found.bits);
            TEST_ASSERT_EQUAL_INT32(0, found.n_alike);
            ASSERT_NEAR(1, found.explained, 0); /* F afterwards is 1 */
            judge(&found, P_MORE, FAR, explains, disagrees ? 6.4 : 1.5);
            TEST_ASSERT_EQUAL_INT32(disagrees ? RIGCAL_RIG_UNEXPLAINED : RIGCAL_RIG_AGREES,
                                    found.verdict);
            TEST_ASSERT_EQUAL_INT32(0, found.bits);
            ASSERT_NEAR(0, found.explained, 0);
        }
    }
    judge(&found, P, FAR, 1, 1); /* nothing disagrees that could be explained */
    ASSERT_NEAR(0, found.explained, 0);
}

/* The limits themselves are beyond. The quantile of F is 2.26 for 30 and 120 degrees of
 * freedom, and 2.28 for 29. */
static void test_the_limits_of_a_verdict(void)
{
    static const double P[3] = {0, 0, 0}, BIC[3] = {0, 9.2, 9.3};
    rigcal_fault fault = {.is_seen = 1, .p = RC(0.01), .F_after = 1};
    rigcal_faults found;

    for (int less = 0; less < 2; less++) {
        memset(&found, 0, sizeof found);
        found.n = found.n_seen = 1;
        fault.p = RC(0.01) * (less ? RC(0.999) : 1);
        rc_finding_judge(&found, &fault, &COMMON);
        TEST_ASSERT_EQUAL_INT32(less ? RIGCAL_FAULTS_NAMED : 0, found.bits);
    }
    judge(&found, P, BIC, 1, 2.27);
    TEST_ASSERT_EQUAL_INT32(0, found.n_alike);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_RIG_EXPLAINED, found.verdict);
    judge(&found, P, BIC, 1, 2.255);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_RIG_AGREES, found.verdict);
}

/* Criteria within 9.2 of the first. */
static void test_faults_whose_criteria_differ_little_are_alike(void)
{
    static const double P[3] = {0, 0, 0}, NONE[3] = {-50, -40.75, -40.7},
                        ONE[3] = {-50, -40.85, -40.75}, BOTH[3] = {-50, -50, -40.85};
    rigcal_faults found;

    judge(&found, P, NONE, 1, 6.4);
    TEST_ASSERT_EQUAL_INT32(0, found.n_alike);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_FAULTS_NAMED, found.bits);
    judge(&found, P, ONE, 1, 6.4);
    TEST_ASSERT_EQUAL_INT32(1, found.n_alike);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_FAULTS_NAMED | RIGCAL_FAULTS_ALIKE, found.bits);
    judge(&found, P, BOTH, 1, 6.4);
    TEST_ASSERT_EQUAL_INT32(2, found.n_alike);
}

/* ---- residuals ---------------------------------------------------------------- */

/* The variance is 1, so that limits are met exactly: a pattern is over 0.1 and over four of
 * its standard deviations; motion has over 0.3 of the disagreement. */
static void test_a_pattern_is_over_both_limits(void)
{
    static const rc_common UNIT = {260, 128, 400, 200, 30, 128};
    /* n, sum of products, expected2, and what is a pattern */
    static const double CASES[8][4] = {
        {4096, 0.1 * 4096, 0, 0},   {4096, 0.1001 * 4096, 0, 1}, {64, 0.5 * 64, 0, 0},
        {64, 0.5001 * 64, 0, 1},    {64, 0.4375 * 64, 45, 0},    {64, 0.438 * 64, 45, 1},
        {64, 0.101 * 64, 189.5, 1}, {64, 0.0625 * 64, 1e5, 0}};
    rigcal_faults found;

    for (int i = 0; i < 8; i++) {
        const double n = CASES[i][0], sum = CASES[i][1];
        rc_residues r = {RC(n / 2), RC(sum), 0, RC(CASES[i][2]), 0, 0, 0};

        r.product += 5;
        r.expected = 5;
        r.product = i == 0 ? RC(0.1) * 4096 : r.product;
        r.expected = i == 0 ? 0 : r.expected;
        memset(&found, 0, sizeof found);
        rc_finding_residues(&found, &r, &UNIT);
        ASSERT_NEAR(sum / n, found.pattern, TOL(1e-13, 1e-6));
        ASSERT_NEAR(sqrt(fmax(n - CASES[i][2] / 3, 1)) / n, found.pattern_sigma,
                    TOL(1e-14, 1e-7));
        TEST_ASSERT_EQUAL_INT32(CASES[i][3] > 0 ? RIGCAL_FAULTS_PATTERN : 0, found.bits);
    }
}

static void test_a_correlation_is_within_one(void)
{
    rigcal_faults found;

    for (int sign = -1; sign < 2; sign += 2) {
        const rc_residues r = {RC(0.5), RC(sign * 0.75), 0, 0, 0, 0, 0};
        const rc_residues much = {RC(0.5), RC(sign * 60), 0, 0, 0, 0, 0};

        memset(&found, 0, sizeof found);
        rc_finding_residues(&found, &r, &COMMON);
        ASSERT_NEAR(sign * 0.9, found.pattern, TOL(1e-14, 1e-6));
        ASSERT_NEAR(1, found.pattern_sigma, 0);
        rc_finding_residues(&found, &much, &COMMON);
        ASSERT_NEAR(sign, found.pattern, 0);
    }
}

static void test_what_lies_along_the_motion_is_over_its_limit(void)
{
    for (int is_over = 0; is_over < 2; is_over++) {
        const rigcal_real along = RC(0.3) * RC(0.5) + (is_over ? RC(0.001) : 0);
        const rc_residues r = {0, 0, 0, 0, along, RC(0.5), RC(0.25)};
        rigcal_faults found;

        memset(&found, 0, sizeof found);
        rc_finding_residues(&found, &r, &COMMON);
        ASSERT_NEAR(2 * D(along), found.along, 0);
        ASSERT_NEAR(sqrt(4 * D(along)), found.along_time, TOL(1e-15, 1e-7));
        TEST_ASSERT_EQUAL_INT32(is_over ? RIGCAL_FAULTS_ALONG_MOTION : 0, found.bits);
        const rc_residues none = {0, 0, 0, 0, along, 0, RC(0.25)};
        memset(&found, 0, sizeof found);
        rc_finding_residues(&found, &none, &COMMON);
        ASSERT_NEAR(0, found.along, 0);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_step_whose_numbers_overflow_is_not_seen);
    RUN_TEST(test_of_exact_pixels_no_step_gains);
    RUN_TEST(test_a_step_with_one_infinite_sigma_is_not_seen);
    RUN_TEST(test_of_many_parameters_the_first_are_told);
    RUN_TEST(test_the_verdict_of_what_could_not_be_seen);
    RUN_TEST(test_residues_of_nothing_have_no_pattern);
    RUN_TEST(test_what_a_fault_explains_is_its_part_of_F_less_one);
    RUN_TEST(test_faults_are_ranked_in_any_order);
    RUN_TEST(test_a_fault_explains_half_of_what_disagrees);
    RUN_TEST(test_F_is_between_the_views_over_within);
    RUN_TEST(test_an_F_of_a_chance_below_a_thousandth_disagrees);
    RUN_TEST(test_a_step_gives_all_numbers_of_a_fault);
    RUN_TEST(test_a_chance_counts_each_try);
    RUN_TEST(test_a_fault_that_explains_everything_has_finite_numbers);
    RUN_TEST(test_a_fault_with_one_number_that_overflows_keeps_its_name_alone);
    RUN_TEST(test_a_fault_explains_too_if_what_is_left_may_be_noise);
    RUN_TEST(test_faults_that_are_not_seen_are_in_the_order_of_their_kinds);
    RUN_TEST(test_the_first_fault_is_found_if_its_chance_among_all_is_below_a_percent);
    RUN_TEST(test_the_limits_of_a_verdict);
    RUN_TEST(test_faults_whose_criteria_differ_little_are_alike);
    RUN_TEST(test_a_pattern_is_over_both_limits);
    RUN_TEST(test_a_correlation_is_within_one);
    RUN_TEST(test_what_lies_along_the_motion_is_over_its_limit);
}
