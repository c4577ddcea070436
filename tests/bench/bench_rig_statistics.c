/* bench_rig_statistics: how far adjusted rigs are from the truth, in units of their
 * covariances. Two to eight cameras stand in an arc; a board, a spatial target or the
 * corners of a tag is in 5 to 50 placements, of which a camera sees 30 to 100 %. Noise is
 * 0.3 px.
 *
 *   bench_rig_statistics RIGS [SEED]
 *       two tables in Markdown: a line a number of cameras, a target, a lens
 *   bench_rig_statistics check
 *       small rigs, for CI: exit status 1 if a figure is not what noise explains
 *
 * A rig counts if the bound of the rotation of each camera is below 1 degree. The pose of a
 * view by itself is that of the minimum near the truth. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_rig_cases.h"
#include "test_fit.h"

enum { EVALS = 201 }; /* more than a search can take */

#define SEED 20240611
#define DEGREE (TEST_PI / 180)
#define CHI2_6 12.5916 /* 95 % of chi square of 6 degrees are below this */

/* Unity needs these: the arithmetic of the tests uses its checks. */
void setUp(void)
{
}

void tearDown(void)
{
}

static void fail(const char *why)
{
    fprintf(stderr, "bench_rig_statistics: %s\n", why);
    exit(2);
}

/* ---- the F distribution -------------------------------------------------- */

/* The continued fraction of the incomplete beta function, by Lentz's method. */
static double beta_fraction(double x, double a, double b)
{
    double c = 1, d = 1 / (1 - (a + b) * x / (a + 1)), product = d;

    for (int m = 1; m < 10000; m++) {
        const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
        const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));

        d = 1 / (1 + even * d);
        c = 1 + even / c;
        product *= c * d;
        d = 1 / (1 + odd * d);
        c = 1 + odd / c;
        product *= c * d;
        if (fabs(c * d - 1) < 1e-14) {
            break;
        }
    }
    return product;
}

static double beta_below(double x, double a, double b)
{
    const double front =
        exp(lgamma(a + b) - lgamma(a) - lgamma(b) + a * log(x) + b * log1p(-x));

    return (x < (a + 1) / (a + b + 2)) ? front * beta_fraction(x, a, b) / a
                                       : 1 - front * beta_fraction(1 - x, b, a) / b;
}

/* f with P(F(d1, d2) < f) = p. */
static double f_quantile(double p, double d1, double d2)
{
    double low = 0, high = 1e4;

    for (int i = 0; i < 100; i++) {
        const double f = 0.5 * (low + high);

        if (beta_below(d1 * f / (d1 * f + d2), 0.5 * d1, 0.5 * d2) < p) {
            low = f;
        } else {
            high = f;
        }
    }
    return low;
}

/* ---- what is measured ---------------------------------------------------- */

/* The quantities for a camera, a pair and a placement: (error / bound)^2, and whether the
 * truth is inside the 95 % ellipsoid of the known and of the estimated sigma. Then F over
 * its mean, and (error / bound)^2 of the cameras of the join. */
enum { ERROR, KNOWN = 3, ESTIMATED = 6, F_RATIO = 9, JOIN, QUANTITIES };
enum { COMPOSED, JOINED, STARTS };

typedef struct {
    double sum[QUANTITIES], n[QUANTITIES];
    int evals[STARTS], is_elsewhere[STARTS];
    double off; /* result of distance_from_minimum */
} figures;

static void add(figures *f, int quantity, double value)
{
    f->sum[quantity] += value;
    f->n[quantity] += 1;
}

/* Sigma is the covariance for the true noise. */
static void add_error(figures *f, int what, const rigcal_transform *found,
                      const rigcal_transform *truth, const rigcal_real Sigma[36],
                      const rigcal_rig_fit *fit)
{
    double d[6], A[36];
    const double more = pow(D(fit->sigma_px) / NOISE, 2);

    test_to_double(A, Sigma, 36);
    test_step_between(d, found, truth);
    const double d2 = test_squared_distance(d, A, 6);
    add(f, ERROR + what, d2 / 6);
    add(f, KNOWN + what, d2 <= CHI2_6);
    add(f, ESTIMATED + what, d2 <= more * 6 * f_quantile(0.95, 6, D(fit->freedom)));
}

static void demand(rigcal_status status)
{
    if (status != RIGCAL_OK) {
        fail(rigcal_status_name(status));
    }
}

static void add_errors(figures *f, rig_case *r, const rigcal_rig_fit *fit)
{
    rigcal_real Sigma[36];

    for (int b = 1; b < r->n_cameras; b++) {
        demand(rigcal_rig_covariance(Sigma, &r->rig, RC(NOISE), (size_t)b));
        add_error(f, 0, &r->poses[b], &r->truth[b], Sigma, fit);
        for (int a = 0; a < b; a++) {
            const rigcal_transform rig_from_a = test_inverse(&r->truth[a]);
            const rigcal_transform truth = test_times(&r->truth[b], &rig_from_a);
            rigcal_transform found;

            demand(
                rigcal_rig_pair(&found, Sigma, &r->rig, RC(NOISE), (size_t)a, (size_t)b));
            add_error(f, 1, &found, &truth, Sigma, fit);
        }
    }
    for (int p = 0; p < r->n_placements; p++) {
        demand(rigcal_rig_placement(Sigma, &r->rig, RC(NOISE), (size_t)p));
        add_error(f, 2, &r->poses[CAMERAS + p], &r->truth[CAMERAS + p], Sigma, fit);
    }
}

/* Sum of squares of what a camera sees, in units of the noise, by the arithmetic of the
 * tests. Unknown k of its pose is changed by `step`. */
static double sum_of(const rig_case *r, int camera, int k, double step)
{
    double d[6] = {0}, sum = 0;

    d[k] = step;
    for (size_t i = 0; i < r->rig.n_views; i++) {
        const rigcal_rig_view *const v = &r->views[i];
        double R_c[9], t_c[3], X[3], X_r[3], X_c[3], uv[2];

        if (v->camera != camera) {
            continue;
        }
        test_transform_parts(R_c, t_c, &r->poses[camera]);
        test_move(R_c, t_c, d);
        for (size_t j = 0; j < v->view.n; j++) {
            const rigcal_observation *const o = &v->view.observations[j];

            test_to_double(X, o->X_w, 3);
            test_move_point(X_r, &r->poses[CAMERAS + v->placement], X);
            test_apply(X_c, R_c, X_r, t_c);
            test_project_px(uv, v->view.camera, X_c);
            sum += pow(uv[0] - D(o->uv[0]), 2) + pow(uv[1] - D(o->uv[1]), 2);
        }
    }
    return sum / (NOISE * NOISE);
}

/* How far each unknown of the cameras is from the least sum, the others being as they are:
 * the largest distance, in standard deviations of that unknown alone. */
static double distance_from_minimum(const rig_case *r, rigcal_real Sigma[CAMERAS][36])
{
    double farthest = 0;

    for (int c = 1; c < r->n_cameras; c++) {
        const double sum = sum_of(r, c, 0, 0);

        for (int k = 0; k < 6; k++) {
            const double h = 0.001 * sqrt(D(Sigma[c][7 * k]));
            const double more = sum_of(r, c, k, h), less = sum_of(r, c, k, -h);
            const double slope = (more - less) / (2 * h);
            const double bend = (more + less - 2 * sum) / (h * h);

            farthest = fmax(farthest, fabs(slope) / sqrt(2 * bend));
        }
    }
    return farthest;
}

/* Whether the adjusted rig counts, and the covariances of its cameras. */
static int is_sharp(rigcal_real Sigma[CAMERAS][36], const rig_case *r)
{
    int is_sharp = 1;

    for (int c = 0; c < r->n_cameras; c++) {
        demand(rigcal_rig_covariance(Sigma[c], &r->rig, RC(NOISE), (size_t)c));
        const double trace = D(Sigma[c][0]) + D(Sigma[c][7]) + D(Sigma[c][14]);
        is_sharp = is_sharp && sqrt(trace) < DEGREE;
    }
    return is_sharp;
}

/* Whether the rig is in another minimum than an adjustment from the truth. */
static int is_other(const rigcal_rig_fit *fit, const rigcal_rig_fit *from_truth)
{
    const double tol = 0.1 * NOISE * NOISE + TOL(1e-9, 3e-5) * D(from_truth->sum);

    return fabs(D(fit->sum) - D(from_truth->sum)) > tol;
}

/* Returns 0 if the rig does not count. */
static int measure(figures *f, rig_case *r)
{
    rigcal_real Sigma[CAMERAS][36];
    rigcal_rig_fit from_truth, fit;
    const figures nothing = {0};

    *f = nothing;
    rig_case_start_at_truth(r);
    if (!rig_case_solve_views(r)) {
        fail("the pose of a view cannot be had");
    }
    demand(rigcal_rig_adjust(&from_truth, NULL, &r->rig));
    if (!is_sharp(Sigma, r)) {
        return 0;
    }
    demand(rigcal_rig_join(&r->rig, NULL));
    for (int c = 1; c < r->n_cameras; c++) {
        double d[6], A[36];

        test_to_double(A, Sigma[c], 36);
        test_step_between(d, &r->poses[c], &r->truth[c]);
        add(f, JOIN, test_squared_distance(d, A, 6) / 6);
    }
    demand(rigcal_rig_adjust(&fit, NULL, &r->rig));
    f->evals[JOINED] = (int)fit.evals;
    f->is_elsewhere[JOINED] = is_other(&fit, &from_truth);
    rig_case_start_composed(r);
    demand(rigcal_rig_adjust(&fit, NULL, &r->rig));
    f->evals[COMPOSED] = (int)fit.evals;
    f->is_elsewhere[COMPOSED] = is_other(&fit, &from_truth);
    add_errors(f, r, &fit);
    f->off = distance_from_minimum(r, Sigma);
    if (D(fit.freedom_within) > 10 && D(fit.freedom_between) > 0) {
        add(f, F_RATIO, D(fit.F) * (1 - 2 / D(fit.freedom_within)));
    }
    return 1;
}

/* ---- families ------------------------------------------------------------ */

/* Sums over rigs. Errors of one rig are correlated. So the standard error of a mean is that
 * of a ratio of sums, in which a rig is one draw. */
typedef struct {
    const char *name;
    int rigs;
    double s[QUANTITIES], n[QUANTITIES], ss[QUANTITIES], sn[QUANTITIES], nn[QUANTITIES];
    int evals[STARTS][EVALS], elsewhere[STARTS];
    double off; /* the largest */
} family;

enum { ALL, OF_TARGET = CAMERAS, OF_LENS = OF_TARGET + TARGETS, APART = OF_LENS + LENSES };
enum { FAMILIES = APART + 1 };

static family families[FAMILIES] = {
    {.name = "all"},         {.name = "2 cameras"}, {.name = "3 cameras"},
    {.name = "4 cameras"},   {.name = "5 cameras"}, {.name = "6 cameras"},
    {.name = "7 cameras"},   {.name = "8 cameras"}, {.name = "board"},
    {.name = "spatial"},     {.name = "tag"},       {.name = "Brown"},
    {.name = "rational"},    {.name = "fisheye"},   {.name = "all lenses"},
    {.name = "a pair apart"}};

static void count(family *to, const figures *f)
{
    to->rigs++;
    for (int q = 0; q < QUANTITIES; q++) {
        to->s[q] += f->sum[q];
        to->n[q] += f->n[q];
        to->ss[q] += f->sum[q] * f->sum[q];
        to->sn[q] += f->sum[q] * f->n[q];
        to->nn[q] += f->n[q] * f->n[q];
    }
    to->off = fmax(to->off, f->off);
    for (int k = 0; k < STARTS; k++) {
        to->evals[k][(f->evals[k] < EVALS) ? f->evals[k] : EVALS - 1]++;
        to->elsewhere[k] += f->is_elsewhere[k];
    }
}

static double mean(const family *f, int q)
{
    return f->s[q] / f->n[q];
}

static double standard_error(const family *f, int q)
{
    const double m = mean(f, q);

    return sqrt(fmax(0, f->ss[q] - 2 * m * f->sn[q] + m * m * f->nn[q])) / f->n[q];
}

static int quantile(const int counts[EVALS], double share, int n)
{
    double below = 0;

    for (int i = 0; i < EVALS; i++) {
        below += counts[i];
        if (below >= share * n) {
            return i;
        }
    }
    return EVALS;
}

/* Makes rigs until RIGS of them count. Returns the number that did not. */
static int run(rig_case *r, int rigs, uint64_t seed, int placements_max)
{
    figures f;
    int left_out = 0;

    for (uint64_t i = 0; families[ALL].rigs < rigs; i++) {
        test_rng rng = test_seed(seed + (i << 32));

        rig_case_make(r, &rng, placements_max);
        if (!measure(&f, r)) {
            if (left_out++ > 10 + rigs) {
                fail("most rigs do not count");
            }
            continue;
        }
        count(&families[ALL], &f);
        count(&families[r->n_cameras - 1], &f);
        count(&families[OF_TARGET + (int)r->target], &f);
        count(&families[OF_LENS + (int)r->lens], &f);
        if (r->is_apart) {
            count(&families[APART], &f);
        }
    }
    return left_out;
}

/* ---- output -------------------------------------------------------------- */

static void print_root(const family *f, int q)
{
    const double root = sqrt(mean(f, q));

    printf(" %.3f +- %.3f |", root, standard_error(f, q) / (2 * root));
}

static void print_tables(int left_out, uint64_t seed)
{
    printf("%s, %s, seed %llu; left out: %d rigs, of a bound above 1 degree; farthest "
           "from a minimum: %.2g standard deviations\n\n",
           BENCH_BUILD, (sizeof(rigcal_real) == 4) ? "float" : "double",
           (unsigned long long)seed, left_out, families[ALL].off);
    printf("| error over bound | rigs | cameras | pairs | placements | cameras, of the "
           "join |\n"
           "| --- | ---: | ---: | ---: | ---: | ---: |\n");
    for (const family *f = families; f < families + FAMILIES; f++) {
        printf("| %s | %d |", f->name, f->rigs);
        for (int k = 0; k < 3; k++) {
            print_root(f, ERROR + k);
        }
        print_root(f, JOIN);
        printf("\n");
    }
    printf("\n| rigs | inside, sigma known: %%, of the three | sigma estimated: %% | "
           "F over its mean | evaluations, composed: median, 99 %%, most | joined | "
           "elsewhere |\n"
           "| --- | ---: | ---: | ---: | ---: | ---: | ---: |\n");
    for (const family *f = families; f < families + FAMILIES; f++) {
        printf("| %s |", f->name);
        for (int q = KNOWN; q < F_RATIO; q += 3) {
            printf(" %.1f, %.1f, %.1f |", 100 * mean(f, q), 100 * mean(f, q + 1),
                   100 * mean(f, q + 2));
        }
        printf(" %.3f +- %.3f |", mean(f, F_RATIO), standard_error(f, F_RATIO));
        for (int k = 0; k < STARTS; k++) {
            printf(" %d, %d, %d |", quantile(f->evals[k], 0.5, f->rigs),
                   quantile(f->evals[k], 0.99, f->rigs), quantile(f->evals[k], 1, f->rigs));
        }
        printf(" %d, %d |\n", f->elsewhere[COMPOSED], f->elsewhere[JOINED]);
    }
}

/* ---- check --------------------------------------------------------------- */

/* Limits of means over CHECKED small rigs: 6 standard errors and more from what noise alone
 * gives. A right program passes them whatever the seed but once in a million. */
enum { CHECKED = 400, CHECKED_PLACEMENTS = 12, CHECKED_EVALS = 30 };

#define OFF_MOST TOL(1e-3, 0.02)

static const struct {
    const char *name;
    double low, high;
} limits[QUANTITIES] = {{"(error / bound)^2 of cameras", 0.84, 1.16},
                        {"of pairs", 0.84, 1.16},
                        {"of placements", 0.86, 1.16},
                        {"share inside, cameras", 0.89, 1},
                        {"pairs", 0.9, 1},
                        {"placements", 0.9, 1},
                        {"share inside by the estimated sigma, cameras", 0.89, 1},
                        {"pairs", 0.9, 1},
                        {"placements", 0.9, 1},
                        {"F over its mean", 0.9, 1.1},
                        {"(error / bound)^2 of cameras of the join", 0.84, 1.3}};

static int check(rig_case *r)
{
    const family *const f = &families[ALL];
    int is_right = 1;

    /* by scipy.stats.f.ppf(0.95, 6, d2) */
    is_right = fabs(f_quantile(0.95, 6, 10) - 3.2171745) < 1e-6 &&
               fabs(f_quantile(0.95, 6, 1428) - 2.1049) < 1e-4;
    if (!is_right) {
        printf("the quantile of F is wrong\n");
    }
    (void)run(r, CHECKED, SEED, CHECKED_PLACEMENTS);
    for (int q = 0; q < QUANTITIES; q++) {
        const double m = mean(f, q);
        const int is_so = m >= limits[q].low && m <= limits[q].high;

        printf("%s: %.3f +- %.3f%s\n", limits[q].name, m, standard_error(f, q),
               is_so ? "" : ": not by noise alone");
        is_right = is_right && is_so;
    }
    for (int k = 0; k < STARTS; k++) {
        const int most = quantile(f->evals[k], 0.95, f->rigs);
        const int is_so = most <= CHECKED_EVALS && f->elsewhere[k] <= CHECKED / 50;

        printf("%s: %d evaluations in 95 %%, %d rigs elsewhere%s\n",
               (k == JOINED) ? "joined" : "composed", most, f->elsewhere[k],
               is_so ? "" : ": too many");
        is_right = is_right && is_so;
    }
    is_right = is_right && f->off < OFF_MOST;
    printf("farthest from a minimum: %.5f standard deviations%s\n", f->off,
           (f->off < OFF_MOST) ? "" : ": too far");
    return is_right;
}

int main(int argc, char *argv[])
{
    static rig_case r;
    char *end = NULL;

    if (argc == 2 && strcmp(argv[1], "check") == 0) {
        return check(&r) ? 0 : 1;
    }
    const long rigs = (argc == 2 || argc == 3) ? strtol(argv[1], &end, 10) : 0;
    if (end == NULL || *end != '\0' || rigs < 1 || rigs > 1000000) {
        fail("usage: bench_rig_statistics RIGS [SEED] | check; 1 to 1000000 rigs");
    }
    const uint64_t seed = (argc == 3) ? (uint64_t)strtoull(argv[2], &end, 10) : SEED;
    if (*end != '\0') {
        fail("SEED is not a number");
    }
    print_tables(run(&r, (int)rigs, seed, PLACEMENTS), seed);
    return 0;
}
