/* neldermead: compares the simplex search with SciPy's, run by run and point by point
 * (tests/vectors); for any simplexes and functions with a plain transcription of Lagarias
 * et al. (1998) below; and with what rigcal.h says about budgets, costs that are no
 * numbers, and states. */
#include <math.h>
#include <string.h>

#include "test_support.h"
#include "vectors_neldermead.h"

enum { NO_LIMIT = 100000, K_MAX = RIGCAL_NELDERMEAD_DIM_MAX };

/* ---- functions to minimise ----------------------------------------------- */

/* Sums and products are in the order of make_vectors.py, so that even the rounding is the
 * same. */
static rigcal_real rosenbrock(void *context, const rigcal_real x[])
{
    const rigcal_real a = x[1] - x[0] * x[0], b = 1 - x[0];

    (void)context;
    return 100 * a * a + b * b;
}

static rigcal_real powell(void *context, const rigcal_real x[])
{
    const rigcal_real a = x[0] + 10 * x[1], b = x[1] - 2 * x[2];
    const rigcal_real bb = b * b, xx = x[0] * x[0];

    (void)context;
    return a * a + 5 * x[2] * x[2] + bb * bb + 10 * xx * xx;
}

static rigcal_real himmelblau(void *context, const rigcal_real x[])
{
    const rigcal_real a = x[0] * x[0] + x[1] - 11, b = x[0] + x[1] * x[1] - 7;

    (void)context;
    return a * a + b * b;
}

static rigcal_real quartic(void *context, const rigcal_real x[])
{
    const rigcal_real a = x[0] - 2;

    (void)context;
    return a * a * a * a + a * a;
}

static const rigcal_cost CLASSICAL[] = {rosenbrock, powell, himmelblau, quartic};

/* A crooked bowl over its least value, e = x - b:
 *     least + sum a_i e_i^2 + 0.3 sum e_i e_(i-1)
 * and places that are no numbers: where x_0 < wall the cost is `beyond`. */
typedef struct {
    int k;
    rigcal_real a[K_MAX], b[K_MAX], least;
    rigcal_real wall, beyond;
    int evals;
} bowl;

static rigcal_real bowl_cost(void *context, const rigcal_real x[])
{
    bowl *f = context;
    rigcal_real sum = f->least;

    f->evals++;
    if (x[0] < f->wall) {
        return f->beyond;
    }
    for (int i = 0; i < f->k; i++) {
        const rigcal_real e = x[i] - f->b[i];

        sum += f->a[i] * e * e;
        if (i > 0) {
            sum += RC(0.3) * e * (x[i - 1] - f->b[i - 1]);
        }
    }
    return sum;
}

static bowl bowl_random(test_rng *rng, int k)
{
    bowl f;

    memset(&f, 0, sizeof f);
    f.k = k;
    f.least = 1;
    f.wall = RC(-1e30);
    for (int i = 0; i < k; i++) {
        f.a[i] = RC(test_uniform(rng, 0.5, 4));
        f.b[i] = RC(test_uniform(rng, -3, 3));
    }
    return f;
}

static rigcal_real no_number(void *context, const rigcal_real x[])
{
    (void)x;
    return *(const rigcal_real *)context;
}

/* ---- running a search ---------------------------------------------------- */

typedef struct {
    rigcal_status status;
    rigcal_real x[K_MAX], cost;
    int32_t evals;
} outcome;

static outcome result_of(const rigcal_neldermead *nm)
{
    outcome end;

    memset(&end, 0, sizeof end);
    end.status = rigcal_neldermead_result(end.x, &end.cost, &end.evals, nm);
    return end;
}

/* Runs a search by asking and telling, and counts by itself. */
static outcome run(rigcal_neldermead *nm, rigcal_cost cost, void *context)
{
    rigcal_real x[K_MAX] = {0, 0, 0};
    rigcal_status asked, told = RIGCAL_RUNNING;
    const int32_t before = nm->evals;
    outcome end;
    int evals = 0;

    while ((asked = rigcal_neldermead_ask(x, nm)) == RIGCAL_RUNNING) {
        ASSERT_STATUS(RIGCAL_RUNNING, told);
        told = rigcal_neldermead_tell(nm, cost(context, x));
        evals++;
        TEST_ASSERT_TRUE_MESSAGE(evals <= NO_LIMIT, "does not end");
    }
    ASSERT_STATUS(asked, told);
    end = result_of(nm);
    if (end.status >= 0) {
        ASSERT_STATUS(RIGCAL_OK, asked); /* "ask for the result" */
        TEST_ASSERT_EQUAL_INT(evals, end.evals - before);
    }
    return end;
}

static void begin(rigcal_neldermead *nm, const rigcal_real x0[], int k, double tol,
                  int max_evals)
{
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_neldermead_begin(nm, x0, k, RC(tol), RC(tol), max_evals));
}

/* Whether every vertex and cost is within tol of the first, which is the best. */
static int has_converged(const rigcal_neldermead *nm, double tol)
{
    for (int v = 1; v <= nm->k; v++) {
        if (fabs(D(nm->vertex[v].cost) - D(nm->vertex[0].cost)) > tol) {
            return 0;
        }
        for (int d = 0; d < nm->k; d++) {
            if (fabs(D(nm->vertex[v].x[d]) - D(nm->vertex[0].x[d])) > tol) {
                return 0;
            }
        }
    }
    return 1;
}

/* ---- SciPy --------------------------------------------------------------- */

static void test_each_run_takes_as_many_evaluations_as_scipys(void)
{
    for (int i = 0; i < NELDERMEAD_RUN_ROWS; i++) {
        const double *row = NELDERMEAD_RUN[i];
        const int which = (int)row[0], k = (int)row[1];
        rigcal_neldermead nm;
        rigcal_real x0[K_MAX];
        outcome end;

        test_to_real(x0, row + 2, K_MAX);
        begin(&nm, x0, k, row[5], (int)row[6]);
        end = run(&nm, CLASSICAL[which], NULL);
        TEST_ASSERT_EQUAL_INT32((int32_t)row[7], end.evals);
        /* SciPy also says "spent" if the last evaluation converged. */
        ASSERT_STATUS(row[12] > 0 && !has_converged(&nm, row[5]) ? RIGCAL_BUDGET_SPENT
                                                                 : RIGCAL_OK,
                      end.status);
        ASSERT_ARRAY_NEAR(row + 8, end.x, k, 1e-12);
        ASSERT_NEAR(row[11], end.cost, 1e-12 * (1 + fabs(row[11])));
    }
}

static void test_every_point_evaluated_is_the_one_scipy_evaluates(void)
{
    const int rows = RIGCAL_USE_FLOAT ? 20 : NELDERMEAD_TRACE_ROWS;
    const rigcal_real x0[2] = {RC(-1.2), 1};
    rigcal_neldermead nm;
    rigcal_real x[2];

    begin(&nm, x0, 2, 1e-4, NO_LIMIT);
    for (int i = 0; i < rows; i++) {
        ASSERT_STATUS(RIGCAL_RUNNING, rigcal_neldermead_ask(x, &nm));
        ASSERT_ARRAY_NEAR(NELDERMEAD_TRACE[i], x, 2, TOL(1e-12, 1e-4));
        rigcal_neldermead_tell(&nm, RC(NELDERMEAD_TRACE[i][2]));
    }
    if (!RIGCAL_USE_FLOAT) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_neldermead_ask(x, &nm));
    }
}

/* Also in float: the least value of each is 0. */
static void test_the_classical_functions_are_minimised(void)
{
    for (int i = 0; i < NELDERMEAD_RUN_ROWS; i++) {
        const double *row = NELDERMEAD_RUN[i];
        rigcal_neldermead nm;
        rigcal_real x0[K_MAX];
        outcome end;

        if ((int)row[6] < NO_LIMIT) {
            continue;
        }
        test_to_real(x0, row + 2, K_MAX);
        begin(&nm, x0, (int)row[1], TOL(1e-8, 1e-4), 5000);
        end = run(&nm, CLASSICAL[(int)row[0]], NULL);
        ASSERT_STATUS(RIGCAL_OK, end.status);
        ASSERT_NEAR(0, end.cost, TOL(1e-13, 1e-5));
    }
}

/* ---- the first simplex --------------------------------------------------- */

static void test_the_first_simplex_is_that_of_fminsearch(void)
{
    const rigcal_real x0[3] = {RC(-2), 0, RC(0.5)};
    const double expected[4][3] = {
        {-2, 0, 0.5}, {-2.1, 0, 0.5}, {-2, 0.00025, 0.5}, {-2, 0, 0.525}};

    for (int k = 1; k <= 3; k++) {
        rigcal_neldermead nm;
        rigcal_real x[3] = {0, 0, 0};

        begin(&nm, x0, k, 1e-6, 100);
        for (int i = 0; i <= k; i++) {
            ASSERT_STATUS(RIGCAL_RUNNING, rigcal_neldermead_ask(x, &nm));
            ASSERT_ARRAY_NEAR(expected[i], x, k, TOL(1e-15, 1e-7));
            ASSERT_STATUS(RIGCAL_RUNNING, rigcal_neldermead_tell(&nm, RC(5 - i)));
        }
    }
}

static void test_a_simplex_of_the_callers_is_evaluated_as_it_stands(void)
{
    static const rigcal_real simplex[12] = {3, 1, 4, 1, 5, 9, 2, 6, -5, 3, 5, -8};

    for (int k = 1; k <= 3; k++) {
        rigcal_neldermead nm;
        rigcal_real x[3];

        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_neldermead_begin_simplex(&nm, simplex, k, 0, 0, 100));
        for (int i = 0; i <= k; i++) {
            ASSERT_STATUS(RIGCAL_RUNNING, rigcal_neldermead_ask(x, &nm));
            TEST_ASSERT_EQUAL_MEMORY(simplex + k * i, x, sizeof(rigcal_real) * (size_t)k);
            rigcal_neldermead_tell(&nm, RC(i));
        }
    }
}

/* ---- the rules, transcribed ---------------------------------------------- */

/* Lagarias et al. (1998), section 2, in double. It keeps what it evaluates. NaN and
 * infinities of either sign count as the worst cost. */
enum { TRACE_MAX = 120 };

typedef struct {
    int k, n;
    double v[K_MAX + 1][K_MAX], f[K_MAX + 1];
    double trace[TRACE_MAX][K_MAX];
    bowl *cost;
} textbook;

static double textbook_eval(textbook *s, const double x[])
{
    rigcal_real x_real[K_MAX];
    double f;

    if (s->n < TRACE_MAX) {
        memcpy(s->trace[s->n], x, sizeof(double) * (size_t)s->k);
    }
    s->n++;
    test_to_real(x_real, x, (size_t)s->k);
    f = D(bowl_cost(s->cost, x_real));
    return isfinite(f) ? f : test_infinity();
}

/* Sorts the vertices by cost. A new one goes after those with equal cost. */
static void textbook_sort(textbook *s)
{
    for (int i = 1; i <= s->k; i++) {
        for (int j = i; j > 0 && s->f[j] < s->f[j - 1]; j--) {
            double v[K_MAX], f = s->f[j];

            memcpy(v, s->v[j], sizeof v);
            memcpy(s->v[j], s->v[j - 1], sizeof v);
            memcpy(s->v[j - 1], v, sizeof v);
            s->f[j] = s->f[j - 1];
            s->f[j - 1] = f;
        }
    }
}

/* Evaluates x = centroid + c (worst - centroid). */
static double textbook_try(textbook *s, double x[], double c)
{
    for (int d = 0; d < s->k; d++) {
        double mean = 0;

        for (int i = 0; i < s->k; i++) {
            mean += s->v[i][d] / s->k;
        }
        x[d] = mean + c * (s->v[s->k][d] - mean);
    }
    return textbook_eval(s, x);
}

static void textbook_iterate(textbook *s)
{
    const int k = s->k;
    double xr[K_MAX], x[K_MAX], f;
    const double fr = textbook_try(s, xr, -1);
    int accept = 1;

    memcpy(x, xr, sizeof x);
    f = fr;
    if (fr < s->f[0]) {
        f = textbook_try(s, x, -2);
        if (!(f < fr)) {
            memcpy(x, xr, sizeof x);
            f = fr;
        }
    } else if (!(fr < s->f[k - 1])) {
        if (fr < s->f[k]) {
            f = textbook_try(s, x, -0.5);
            accept = f <= fr;
        } else {
            f = textbook_try(s, x, 0.5);
            accept = f < s->f[k];
        }
    }
    if (accept) {
        memcpy(s->v[k], x, sizeof x);
        s->f[k] = f;
    } else {
        for (int i = 1; i <= k; i++) {
            for (int d = 0; d < k; d++) {
                s->v[i][d] = s->v[0][d] + 0.5 * (s->v[i][d] - s->v[0][d]);
            }
            s->f[i] = textbook_eval(s, s->v[i]);
        }
    }
    textbook_sort(s);
}

/* Random bowls from random simplexes, some with a wall. Compares the first evaluations,
 * before rounding can decide; in float these are few. */
static void test_any_simplex_follows_the_published_rules(void)
{
    test_rng rng = test_seed(3);
    const double beyond[4] = {test_nan(), test_infinity(), -test_infinity(), 1e30};

    for (int trial = 0; trial < 400; trial++) {
        const int k = 1 + trial % 3, compared = RIGCAL_USE_FLOAT ? 15 : 60;
        bowl f = bowl_random(&rng, k);
        textbook book;
        rigcal_neldermead nm;
        rigcal_real simplex[12], x[K_MAX];

        if (trial % 2) {
            f.wall = RC(test_uniform(&rng, -4, 4));
            f.beyond = RC(beyond[trial / 2 % 4]);
        }
        memset(&book, 0, sizeof book);
        book.k = k;
        book.cost = &f;
        for (int i = 0; i <= k; i++) {
            for (int d = 0; d < k; d++) {
                simplex[k * i + d] = RC(test_uniform(&rng, -5, 5));
                book.v[i][d] = D(simplex[k * i + d]);
            }
            book.f[i] = textbook_eval(&book, book.v[i]);
        }
        textbook_sort(&book);
        while (book.n < compared && isfinite(book.f[0])) {
            textbook_iterate(&book);
        }
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_neldermead_begin_simplex(&nm, simplex, k, 0, 0, NO_LIMIT));
        for (int i = 0; i < book.n && i < compared; i++) {
            ASSERT_STATUS(RIGCAL_RUNNING, rigcal_neldermead_ask(x, &nm));
            ASSERT_ARRAY_NEAR(book.trace[i], x, k, TOL(1e-10, 1e-3));
            rigcal_neldermead_tell(&nm, bowl_cost(&f, x));
        }
    }
}

/* The simplex (0, 0), (1, 0), (0, 1) with the costs 0, 1, 2. Checks what is asked after the
 * given costs, in the order of SciPy's comparisons. */
static void assert_asked(double x, double y, int n, const double costs[])
{
    static const rigcal_real simplex[6] = {0, 0, 1, 0, 0, 1};
    const double expected[2] = {x, y};
    rigcal_neldermead nm;
    rigcal_real at[2];

    ASSERT_STATUS(RIGCAL_OK, rigcal_neldermead_begin_simplex(&nm, simplex, 2, 0, 0, 100));
    for (int i = 0; i < 3; i++) {
        rigcal_neldermead_tell(&nm, RC(i));
    }
    for (int i = 0; i < n; i++) {
        rigcal_neldermead_tell(&nm, RC(costs[i]));
    }
    ASSERT_STATUS(RIGCAL_RUNNING, rigcal_neldermead_ask(at, &nm));
    ASSERT_ARRAY_NEAR(expected, at, 2, 0);
}

static void test_equal_costs_are_judged_as_scipy_judges_them(void)
{
    const double as_best[1] = {0}, as_second[1] = {1}, as_worst[1] = {2};
    const double expanded_equal[2] = {-1, -1}, expanded[2] = {-1, -2};
    const double outside_equal[2] = {1.5, 1.5}, outside_worse[2] = {1.5, 1.75};
    const double inside_equal[2] = {3, 2}, inside_better[2] = {3, 1.75};

    /* (0, 1) is reflected to (1, -1). */
    assert_asked(1, -1, 0, NULL);
    /* A cost equal to the best is not better: it is accepted without expansion. Of equal
     * costs the older one stays first, so (1, 0) is now the worst. */
    assert_asked(0, -1, 1, as_best);
    /* A cost equal to the second: outside contraction. Equal to the worst: inside
     * contraction. */
    assert_asked(0.75, -0.5, 1, as_second);
    assert_asked(0.25, 0.5, 1, as_worst);
    /* An expansion that is only as good as the reflection is not accepted. */
    assert_asked(0, -1, 2, expanded_equal);
    assert_asked(0.5, -2, 2, expanded);
    /* An outside contraction as good as the reflection is accepted; a worse one leads to a
     * shrink. */
    assert_asked(0.25, 0.5, 2, outside_equal);
    assert_asked(0.5, 0, 2, outside_worse);
    /* An inside contraction that is only as good as the worst leads to a shrink. */
    assert_asked(0.5, 0, 2, inside_equal);
    assert_asked(0.75, -0.5, 2, inside_better);
}

/* ---- where it ends ------------------------------------------------------- */

static void test_bowls_of_one_to_three_variables_are_minimised(void)
{
    test_rng rng = test_seed(1);

    for (int trial = 0; trial < 300; trial++) {
        const int k = 1 + trial % 3;
        bowl f = bowl_random(&rng, k);
        rigcal_real x0[K_MAX];
        rigcal_neldermead nm;
        outcome end;
        double b[K_MAX];

        for (int i = 0; i < k; i++) {
            x0[i] = trial % 5 == i ? 0 : RC(test_uniform(&rng, -4, 4));
        }
        begin(&nm, x0, k, TOL(1e-8, 1e-4), NO_LIMIT);
        end = run(&nm, bowl_cost, &f);
        ASSERT_STATUS(RIGCAL_OK, end.status);
        /* Mostly about 100. From a start with a zero, whose first simplex is 0.00025 thin,
         * the method may need some 2000. */
        TEST_ASSERT_TRUE(end.evals < 3000);
        TEST_ASSERT_EQUAL_INT(f.evals, end.evals);
        test_to_double(b, f.b, (size_t)k);
        ASSERT_ARRAY_NEAR(b, end.x, k, TOL(1e-6, 5e-3));
        ASSERT_NEAR(1, end.cost, TOL(1e-12, 1e-5));
    }
}

static void test_at_the_end_every_vertex_is_within_the_tolerances(void)
{
    static const double tolerances[][2] = {
        {1e-3, 1}, {10, 1e-3}, {1e-2, 1e-2}, {1e-4, 1e-1}};

    for (size_t i = 0; i < sizeof tolerances / sizeof tolerances[0]; i++) {
        const double xtol = tolerances[i][0], ftol = tolerances[i][1];
        const rigcal_real x0[2] = {RC(-1.2), 1};
        rigcal_neldermead nm;
        outcome end;

        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_neldermead_begin(&nm, x0, 2, RC(xtol), RC(ftol), NO_LIMIT));
        end = run(&nm, rosenbrock, NULL);
        ASSERT_STATUS(RIGCAL_OK, end.status);
        for (int v = 0; v < 3; v++) {
            TEST_ASSERT_TRUE(D(nm.vertex[v].cost) - D(end.cost) <= ftol);
            TEST_ASSERT_TRUE(nm.vertex[v].cost >= end.cost);
            for (int d = 0; d < 2; d++) {
                TEST_ASSERT_TRUE(fabs(D(nm.vertex[v].x[d]) - D(end.x[d])) <= xtol);
            }
        }
    }
}

static void test_it_goes_on_while_any_vertex_is_outside_the_tolerances(void)
{
    test_rng rng = test_seed(11);

    for (int trial = 0; trial < 300; trial++) {
        const int k = 1 + trial % 3;
        const double ftol = trial % 2 ? 0.05 : 50, xtol = trial % 2 ? 50 : 0.02;
        bowl f = bowl_random(&rng, k);
        rigcal_real simplex[12];
        rigcal_neldermead nm;
        outcome end;

        for (int i = 0; i < (k + 1) * k; i++) {
            simplex[i] = RC(test_uniform(&rng, -5, 5));
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_neldermead_begin_simplex(&nm, simplex, k, RC(xtol),
                                                                 RC(ftol), NO_LIMIT));
        end = run(&nm, bowl_cost, &f);
        ASSERT_STATUS(RIGCAL_OK, end.status);
        for (int v = 0; v <= k; v++) {
            TEST_ASSERT_TRUE(nm.vertex[v].cost >= end.cost);
            TEST_ASSERT_TRUE(D(nm.vertex[v].cost) - D(end.cost) <= ftol);
            for (int d = 0; d < k; d++) {
                TEST_ASSERT_TRUE(fabs(D(nm.vertex[v].x[d]) - D(end.x[d])) <= xtol);
            }
        }
    }
}

static void test_tolerances_of_zero_end_at_the_rounding_of_the_numbers(void)
{
    static const double least[3] = {1, -1000, 1e6};
    test_rng rng = test_seed(2);

    for (int trial = 0; trial < 90; trial++) {
        const int k = 1 + trial % 3;
        bowl f = bowl_random(&rng, k);
        const rigcal_real x0[K_MAX] = {1, 1, 1};
        const double value = least[trial / 3 % 3];
        rigcal_neldermead nm;
        outcome end;

        f.least = RC(value);
        begin(&nm, x0, k, 0, NO_LIMIT);
        end = run(&nm, bowl_cost, &f);
        ASSERT_STATUS(RIGCAL_OK, end.status);
        TEST_ASSERT_TRUE(end.evals < 2000);
        ASSERT_NEAR(value, end.cost, TOL(1e-14, 1e-5) * fabs(value));
    }
}

/* ---- costs that are no numbers ------------------------------------------- */

static void test_places_without_a_finite_cost_are_moved_away_from(void)
{
    const double beyond[3] = {test_nan(), test_infinity(), -test_infinity()};
    test_rng rng = test_seed(4);

    for (int trial = 0; trial < 300; trial++) {
        const int k = 1 + trial % 3;
        bowl f = bowl_random(&rng, k);
        rigcal_real x0[K_MAX];
        rigcal_neldermead nm;
        outcome end;
        double b[K_MAX];

        /* The start is just inside the wall. So is the least value. */
        f.beyond = RC(beyond[trial % 9 / 3]);
        f.wall = RC(D(f.b[0]) - 0.5);
        x0[0] = RC(D(f.wall) + 0.01);
        for (int i = 1; i < k; i++) {
            x0[i] = RC(test_uniform(&rng, -4, 4));
        }
        begin(&nm, x0, k, TOL(1e-8, 1e-4), NO_LIMIT);
        end = run(&nm, bowl_cost, &f);
        ASSERT_STATUS(RIGCAL_OK, end.status);
        test_to_double(b, f.b, (size_t)k);
        ASSERT_ARRAY_NEAR(b, end.x, k, TOL(1e-6, 5e-3));
        ASSERT_NEAR(1, end.cost, TOL(1e-12, 1e-5));
    }
}

static void test_a_start_that_has_no_cost_is_left_for_a_vertex_that_has(void)
{
    const rigcal_real x0[2] = {1, 1};
    test_rng rng = test_seed(5);
    bowl f = bowl_random(&rng, 2);
    rigcal_neldermead nm;
    outcome end;

    f.b[0] = 3;
    f.b[1] = 2;
    f.wall = RC(1.01); /* only the vertex at 1.05 lies inside */
    f.beyond = TEST_NAN;
    begin(&nm, x0, 2, TOL(1e-8, 1e-4), NO_LIMIT);
    end = run(&nm, bowl_cost, &f);
    ASSERT_STATUS(RIGCAL_OK, end.status);
    ASSERT_NEAR(3, end.x[0], TOL(1e-6, 5e-3));
    ASSERT_NEAR(2, end.x[1], TOL(1e-6, 5e-3));
}

static void test_no_finite_cost_anywhere_is_an_error_within_the_budget(void)
{
    const rigcal_real beyond[3] = {TEST_NAN, TEST_INF, -TEST_INF};

    for (int i = 0; i < 9; i++) {
        const int k = 1 + i % 3, max_evals = 500;
        rigcal_real context = beyond[i / 3], x[K_MAX], cost;
        const rigcal_real x0[K_MAX] = {1, 0, -2};
        rigcal_neldermead nm;
        rigcal_status status = RIGCAL_RUNNING;
        int32_t told = 0, evals;

        begin(&nm, x0, k, 1e-6, max_evals);
        while (rigcal_neldermead_ask(x, &nm) == RIGCAL_RUNNING) {
            for (int d = 0; d < k; d++) {
                TEST_ASSERT_TRUE(isfinite(D(x[d])));
            }
            status = rigcal_neldermead_tell(&nm, no_number(&context, x));
            told++;
            TEST_ASSERT_TRUE(told <= max_evals);
        }
        TEST_ASSERT_TRUE(status == RIGCAL_OK || status == RIGCAL_BUDGET_SPENT);
        FILL(cost);
        FILL(evals);
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, x,
                       rigcal_neldermead_result(x, &cost, &evals, &nm));
        ASSERT_UNTOUCHED(cost);
        ASSERT_UNTOUCHED(evals);
    }
}

/* ---- budgets ------------------------------------------------------------- */

static void assert_same(const outcome *a, const outcome *b)
{
    ASSERT_STATUS(a->status, b->status);
    TEST_ASSERT_EQUAL_INT32(a->evals, b->evals);
    TEST_ASSERT_EQUAL_MEMORY(a->x, b->x, sizeof a->x);
    TEST_ASSERT_EQUAL_MEMORY(&a->cost, &b->cost, sizeof a->cost);
}

static void test_the_same_bits_come_out_whatever_the_budgets(void)
{
    static const int32_t budgets[] = {1, 2, 7, 1000, INT32_MAX};
    test_rng rng = test_seed(6);

    for (int trial = 0; trial < 30; trial++) {
        const int k = 1 + trial % 3;
        const rigcal_real x0[K_MAX] = {2, 0, -1};
        bowl f = bowl_random(&rng, k);
        rigcal_neldermead nm;
        outcome asked;

        begin(&nm, x0, k, TOL(1e-9, 1e-4), trial % 2 ? 40 : NO_LIMIT);
        asked = run(&nm, bowl_cost, &f);
        for (size_t b = 0; b < sizeof budgets / sizeof budgets[0]; b++) {
            rigcal_status status;
            outcome stepped;

            f.evals = 0;
            begin(&nm, x0, k, TOL(1e-9, 1e-4), trial % 2 ? 40 : NO_LIMIT);
            do {
                const int before = f.evals;

                status = rigcal_neldermead_step(&nm, bowl_cost, &f, budgets[b]);
                TEST_ASSERT_TRUE(f.evals - before <= budgets[b]);
                TEST_ASSERT_TRUE(status != RIGCAL_RUNNING ||
                                 f.evals - before == budgets[b]);
            } while (status == RIGCAL_RUNNING);
            stepped = result_of(&nm);
            ASSERT_STATUS(RIGCAL_OK, status);
            TEST_ASSERT_EQUAL_INT(f.evals, stepped.evals);
            assert_same(&asked, &stepped);
        }
    }
}

static void test_a_search_copied_halfway_goes_on_the_same(void)
{
    const rigcal_real x0[2] = {RC(-1.2), 1};
    rigcal_neldermead nm, copy;
    outcome one, two;

    begin(&nm, x0, 2, TOL(1e-9, 1e-4), NO_LIMIT);
    ASSERT_STATUS(RIGCAL_RUNNING, rigcal_neldermead_step(&nm, rosenbrock, NULL, 33));
    copy = nm;
    one = run(&nm, rosenbrock, NULL);
    two = result_of(&nm);
    assert_same(&one, &two);
    while (rigcal_neldermead_step(&copy, rosenbrock, NULL, 5) == RIGCAL_RUNNING) {
    }
    two = result_of(&copy);
    assert_same(&one, &two);
}

static void test_no_more_evaluations_are_made_than_allowed(void)
{
    const rigcal_real x0[3] = {3, -1, 0};
    double least = 1e30;

    for (int32_t max_evals = 1; max_evals <= 80; max_evals++) {
        rigcal_neldermead nm;
        rigcal_real x[3];
        rigcal_status status = RIGCAL_RUNNING;
        int32_t told = 0;
        outcome end;

        begin(&nm, x0, 3, 0, max_evals);
        while (rigcal_neldermead_ask(x, &nm) == RIGCAL_RUNNING) {
            status = rigcal_neldermead_tell(&nm, powell(NULL, x));
            told++;
        }
        ASSERT_STATUS(RIGCAL_OK, status);
        TEST_ASSERT_EQUAL_INT32(max_evals, told);
        end = result_of(&nm);
        ASSERT_STATUS(RIGCAL_BUDGET_SPENT, end.status);
        TEST_ASSERT_EQUAL_INT32(max_evals, end.evals);
        TEST_ASSERT_TRUE(D(end.cost) <= least);
        ASSERT_NEAR(powell(NULL, end.x), end.cost, 0);
        least = D(end.cost);
    }
}

/* ---- states -------------------------------------------------------------- */

static void test_asking_twice_gives_the_same_point(void)
{
    const rigcal_real x0[2] = {0, 0};
    rigcal_neldermead nm;
    rigcal_real x[2], again[2];

    begin(&nm, x0, 2, 1e-4, 200);
    while (rigcal_neldermead_ask(x, &nm) == RIGCAL_RUNNING) {
        ASSERT_STATUS(RIGCAL_RUNNING, rigcal_neldermead_ask(again, &nm));
        TEST_ASSERT_EQUAL_MEMORY(x, again, sizeof x);
        rigcal_neldermead_tell(&nm, himmelblau(NULL, x));
    }
}

static void test_a_search_that_is_done_asks_nothing_and_hears_nothing(void)
{
    const rigcal_real x0[2] = {1, 1};

    for (int32_t max_evals = 10; max_evals <= 10000; max_evals *= 1000) {
        const rigcal_status done = max_evals == 10 ? RIGCAL_BUDGET_SPENT : RIGCAL_OK;
        rigcal_neldermead nm;
        rigcal_real x[2];
        outcome before, after;

        begin(&nm, x0, 2, TOL(1e-6, 1e-3), max_evals);
        before = run(&nm, himmelblau, NULL);
        ASSERT_STATUS(done, before.status);
        FILL(x);
        ASSERT_STATUS(RIGCAL_OK, rigcal_neldermead_ask(x, &nm));
        ASSERT_UNTOUCHED(x);
        ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_neldermead_tell(&nm, -1));
        ASSERT_STATUS(RIGCAL_OK, rigcal_neldermead_step(&nm, himmelblau, NULL, 9));
        after = result_of(&nm);
        assert_same(&before, &after);
    }
}

static void test_a_search_that_was_not_begun_is_refused(void)
{
    rigcal_neldermead nm;
    rigcal_real x[3];

    memset(&nm, 0, sizeof nm);
    ASSERT_REFUSED(RIGCAL_ERR_STATE, x, rigcal_neldermead_ask(x, &nm));
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_neldermead_tell(&nm, 1));
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_neldermead_step(&nm, rosenbrock, NULL, 1));
    ASSERT_REFUSED(RIGCAL_ERR_STATE, x, rigcal_neldermead_result(x, NULL, NULL, &nm));
}

static void test_the_best_vertex_is_known_from_the_first_cost_on(void)
{
    const rigcal_real x0[3] = {3, -1, 1}, costs[4] = {4, 2, 3, 1};
    const double least[4] = {4, 2, 2, 1};

    for (int k = 1; k <= 3; k++) {
        rigcal_neldermead nm;
        rigcal_real x[3], best[3] = {0, 0, 0}, cost;
        int32_t evals;

        begin(&nm, x0, k, 1e-6, 100);
        ASSERT_REFUSED(RIGCAL_ERR_STATE, x, rigcal_neldermead_result(x, NULL, NULL, &nm));
        for (int i = 0; i <= k; i++) {
            ASSERT_STATUS(RIGCAL_RUNNING, rigcal_neldermead_ask(x, &nm));
            if (D(costs[i]) <= least[i]) {
                memcpy(best, x, sizeof best);
            }
            rigcal_neldermead_tell(&nm, costs[i]);
            ASSERT_STATUS(RIGCAL_RUNNING, rigcal_neldermead_result(x, &cost, &evals, &nm));
            TEST_ASSERT_EQUAL_MEMORY(best, x, sizeof(rigcal_real) * (size_t)k);
            TEST_ASSERT_EQUAL_INT32(i + 1, evals);
            ASSERT_NEAR(least[i], cost, 0);
        }
    }
}

/* Contents of memory that a search never leaves. */
static void test_a_search_with_a_field_out_of_range_is_refused(void)
{
    const rigcal_real x0[3] = {3, -1, 1};
    rigcal_neldermead nm, whole;
    rigcal_real x[3];

    begin(&whole, x0, 3, TOL(1e-6, 1e-3), 100);
    for (int field = 0; field < 6; field++) {
        nm = whole;
        switch (field) {
        case 0:
            nm.phase = 99;
            break;
        case 1:
            nm.phase = -1;
            break;
        case 2:
            nm.k = 0;
            break;
        case 3:
            nm.k = RIGCAL_NELDERMEAD_DIM_MAX + 1;
            break;
        case 4:
            nm.vertex_next = -1;
            break;
        default:
            nm.vertex_next = nm.k + 1;
            break;
        }
        const rigcal_neldermead before = nm;

        ASSERT_REFUSED(RIGCAL_ERR_STATE, x, rigcal_neldermead_ask(x, &nm));
        ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_neldermead_tell(&nm, 1));
        ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_neldermead_step(&nm, rosenbrock, NULL, 1));
        ASSERT_REFUSED(RIGCAL_ERR_STATE, x, rigcal_neldermead_result(x, NULL, NULL, &nm));
        TEST_ASSERT_EQUAL_MEMORY(&before, &nm, sizeof nm);
    }
}

TEST_MAIN()
{
    if (!RIGCAL_USE_FLOAT) { /* float has other rounding */
        RUN_TEST(test_each_run_takes_as_many_evaluations_as_scipys);
    }
    RUN_TEST(test_every_point_evaluated_is_the_one_scipy_evaluates);
    RUN_TEST(test_the_classical_functions_are_minimised);
    RUN_TEST(test_the_first_simplex_is_that_of_fminsearch);
    RUN_TEST(test_a_simplex_of_the_callers_is_evaluated_as_it_stands);
    RUN_TEST(test_any_simplex_follows_the_published_rules);
    RUN_TEST(test_equal_costs_are_judged_as_scipy_judges_them);
    RUN_TEST(test_bowls_of_one_to_three_variables_are_minimised);
    RUN_TEST(test_at_the_end_every_vertex_is_within_the_tolerances);
    RUN_TEST(test_it_goes_on_while_any_vertex_is_outside_the_tolerances);
    RUN_TEST(test_tolerances_of_zero_end_at_the_rounding_of_the_numbers);
    RUN_TEST(test_places_without_a_finite_cost_are_moved_away_from);
    RUN_TEST(test_a_start_that_has_no_cost_is_left_for_a_vertex_that_has);
    RUN_TEST(test_no_finite_cost_anywhere_is_an_error_within_the_budget);
    RUN_TEST(test_the_same_bits_come_out_whatever_the_budgets);
    RUN_TEST(test_a_search_copied_halfway_goes_on_the_same);
    RUN_TEST(test_no_more_evaluations_are_made_than_allowed);
    RUN_TEST(test_asking_twice_gives_the_same_point);
    RUN_TEST(test_a_search_that_is_done_asks_nothing_and_hears_nothing);
    RUN_TEST(test_a_search_that_was_not_begun_is_refused);
    RUN_TEST(test_the_best_vertex_is_known_from_the_first_cost_on);
    RUN_TEST(test_a_search_with_a_field_out_of_range_is_refused);
}
