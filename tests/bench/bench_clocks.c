/* bench_clocks: rigs of four cameras with clocks of their own, adjusted without them and
 * with them free. Boards of 20 points at 1 m, 0.3 px of noise; the path of a hand.
 *
 * Then clocks that drift, adjusted with offsets alone and with drifts, too; and stamps of
 * views that have noise, adjusted without that and with it.
 *
 *   bench_clocks [RIGS]    the tables, so many rigs a line (default 40)
 *   bench_clocks check     few rigs, against limits */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rigcal_solvers.h"
#include "test_motions.h"

static const double NOISE = 0.3;

enum { RIGS_MAX = 1000, RIGS_CHECKED = 6 };

typedef struct {
    const char *what;
    motion_scene scene;
    double limit; /* limit of the error over the bound */
} campaign;

static const campaign CAMPAIGNS[] = {
    {"7 runs of 3, 0.2 m/s", {4, 7, 3, 30, 0.2, 0.8, 10, 0.015, 0, 0, 0.3}, 1.12},
    {"7 runs of 3, 0.35 m/s", {4, 7, 3, 30, 0.35, 0.8, 10, 0.015, 0, 0, 0.3}, 1.12},
    {"7 runs of 3, 0.5 m/s", {4, 7, 3, 30, 0.5, 0.8, 10, 0.015, 0, 0, 0.3}, 1.12},
    {"one run of 20", {4, 1, 20, 30, 0.35, 0.8, 10, 0.015, 0, 0, 0.3}, 1.12},
    {"2 runs of 10", {4, 2, 10, 30, 0.35, 0.8, 10, 0.015, 0, 0, 0.3}, 1.12},
    {"4 runs of 5 at 10 fps", {4, 4, 5, 10, 0.35, 0.8, 10, 0.015, 0, 0, 0.3}, 1.2},
    {"2 runs of 10 at 6 fps, 60 ms, 0.2 m/s",
     {4, 2, 10, 6, 0.2, 0.8, 10, 0.06, 0, 0, 0.3},
     0},
    {"7 runs of 3, 3 cameras", {3, 7, 3, 30, 0.35, 0.8, 10, 0.015, 0, 0, 0.3}, 1.12},
    {"7 runs of 3, 2 cameras", {2, 7, 3, 30, 0.35, 0.8, 10, 0.015, 0, 0, 0.3}, 1.12},
    {"7 runs of 3, synchronous", {4, 7, 3, 30, 0.35, 0.8, 10, 0, 0, 0, 0.3}, 1.12},
};
static const motion_scene STAMPED = {4, 7, 3, 30, 0.35, 0.8, 10, 0, 0, 0.004, 0.3};

enum { N_CAMPAIGNS = sizeof CAMPAIGNS / sizeof CAMPAIGNS[0] };

static test_motions m;

/* Adjusts from the start. Returns the number of steps. */
static int adjust(rigcal_rig_fit *fit, rigcal_rig_clocks *clocks)
{
    test_motions_reset(&m);
    m.rig.clocks = clocks;
    const rigcal_status status = rigcal_rig_adjust(fit, NULL, &m.rig);
    return status == RIGCAL_OK ? fit->evals / 2 : -1;
}

static int compare(const void *a, const void *b)
{
    return *(const int *)a - *(const int *)b;
}

typedef struct {
    double without2, with2, clocks2, F; /* sums */
    int rigs, failed, n_clocks, steps[RIGS_MAX];
} tally;

static void run_one(tally *t, const campaign *c, uint64_t seed)
{
    test_rng rng = test_seed(seed);
    double bound[6 * 6 * 9], without2;
    rigcal_rig_fit fit;

    test_motions_make(&m, &rng, &c->scene);
    test_motions_solve(&m);
    const int is_adjusted = adjust(&fit, NULL) >= 0;
    double errors[1];
    rigcal_transform plain[MOTION_CAMERAS_MAX];
    memcpy(plain, m.cams, sizeof plain);
    const int steps = adjust(&fit, &m.clocks);
    if (!is_adjusted || steps < 0) {
        t->failed++;
        return;
    }
    test_motions_information(bound, &m, NOISE);
    errors[0] = test_motions_error2(&m, bound);
    for (size_t i = 1; i < m.rig.n_cameras; i++) {
        const double off = D(m.offsets[i]) - m.true_offsets[i];
        t->clocks2 += off * off;
        t->n_clocks++;
    }
    memcpy(m.cams, plain, sizeof plain);
    without2 = test_motions_error2(&m, bound);
    t->without2 += without2;
    t->with2 += errors[0];
    t->F += D(fit.F);
    t->steps[t->rigs++] = steps;
}

static int run(const campaign *c, int number, int rigs)
{
    tally t;

    memset(&t, 0, sizeof t);
    for (int trial = 0; trial < rigs; trial++) {
        run_one(&t, c, 20000 + 1000 * (uint64_t)number + (uint64_t)trial);
    }
    qsort(t.steps, (size_t)t.rigs, sizeof t.steps[0], compare);
    const double with = sqrt(t.with2 / t.rigs);
    printf("| %s | %.1f | %.3f | %.2f ms | %.3f | %d | %d | %d |\n", c->what,
           sqrt(t.without2 / t.rigs), with, 1e3 * sqrt(t.clocks2 / t.n_clocks),
           sqrt(t.F / t.rigs), t.steps[t.rigs / 2], t.steps[t.rigs - 1], t.failed);
    return t.failed == 0 && t.steps[t.rigs / 2] <= 25 &&
           (!(c->limit > 0) || with < 1.3 * c->limit); /* of few rigs */
}

/* ---- drifts, stamps --------------------------------------------------------- */

/* The squared error over the bound, and its sigma. -1: the rig was not adjusted. */
static double error2_of(double *sigma, rigcal_rig_clocks *clocks, const double bound[])
{
    rigcal_rig_fit fit;

    if (adjust(&fit, clocks) < 0) {
        return -1;
    }
    *sigma += D(fit.sigma_px);
    return test_motions_error2(&m, bound);
}

/* Clocks that drift by at most 50 ppm. In the middle of the recording they agree. */
static int run_drifts(int rigs, double noise_px)
{
    const motion_scene scene = {4, 7, 3, 30, 0.35, 0.8, 10, 0, 5e-5, 0, noise_px};
    double bound[6 * 6 * 9], errors[3] = {0, 0, 0}, sigma = 0;
    rigcal_rig_fit fit;
    int failed = 0;

    for (int trial = 0; trial < rigs; trial++) {
        test_rng rng = test_seed(40000 + (uint64_t)trial);

        test_motions_make(&m, &rng, &scene);
        test_motions_solve(&m);
        m.clocks.drifts = m.drifts;
        m.clocks.free_drifts = 1;
        failed += adjust(&fit, &m.clocks) < 0;
        test_motions_information(bound, &m, noise_px);
        for (int k = 2; k >= 0; k--) {
            m.clocks.free_drifts = k > 1;
            const double error2 = error2_of(&sigma, k > 0 ? &m.clocks : NULL, bound);
            failed += error2 < 0;
            errors[k] += error2 / rigs;
        }
    }
    printf("| %.3f px | %.2f | %.2f | %.3f | %d |\n", noise_px, sqrt(errors[0]),
           sqrt(errors[1]), sqrt(errors[2]), failed);
    return failed == 0 && (noise_px < NOISE ? sqrt(errors[2] / errors[0]) < 0.1
                                            : sqrt(errors[2]) < 1.3 * 1.12);
}

/* Stamps with noise of 4 ms, which the adjustment knows or not. */
static int run_stamps(int rigs)
{
    double bound[6 * 6 * 9], errors[2] = {0, 0}, sigmas[2] = {0, 0};
    rigcal_rig_fit fit;
    int failed = 0;

    for (int trial = 0; trial < rigs; trial++) {
        test_rng rng = test_seed(50000 + (uint64_t)trial);

        test_motions_make(&m, &rng, &STAMPED);
        test_motions_solve(&m);
        m.clocks.free_offsets = 0;
        m.clocks.sigma_time = RC(0.004);
        failed += adjust(&fit, &m.clocks) < 0;
        test_motions_information(bound, &m, NOISE);
        for (int k = 1; k >= 0; k--) {
            m.clocks.sigma_time = k > 0 ? RC(0.004) : 0;
            const double error2 = error2_of(&sigmas[k], &m.clocks, bound);
            failed += error2 < 0;
            errors[k] += error2 / rigs;
        }
    }
    puts("\n| stamps with 4 ms of noise | sigma_px found | error over bound | not adjusted "
         "|\n| --- | ---: | ---: | ---: |");
    printf("| without sigma_time | %.4f px | %.2f | %d |\n"
           "| with sigma_time | %.4f px | %.3f | %d |\n",
           sigmas[0] / rigs, sqrt(errors[0]), failed, sigmas[1] / rigs, sqrt(errors[1]),
           failed);
    return failed == 0 && fabs(sigmas[1] / rigs / NOISE - 1) < 0.03;
}

int main(int argc, char *argv[])
{
    const int is_check = argc > 1 && strcmp(argv[1], "check") == 0;
    const int rigs = is_check ? RIGS_CHECKED : argc > 1 ? atoi(argv[1]) : 40;

    if (argc > 2 || rigs < 1 || rigs > RIGS_MAX) {
        fputs("usage: bench_clocks [RIGS | check]\n", stderr);
        return 2;
    }
    UNITY_BEGIN();
    if (!TEST_PROTECT()) {
        return 1;
    }
    puts("| 4 cameras, clocks within 15 ms, 30 fps | error over bound, not handled | freed "
         "| "
         "clocks to | sqrt F | steps, median | most | not adjusted |\n"
         "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |");
    int is_good = 1;
    for (int i = 0; i < N_CAMPAIGNS; i++) {
        is_good &= run(&CAMPAIGNS[i], i, rigs);
    }
    puts("\n| noise; clocks drift within 50 ppm | error over bound, no clocks | offsets "
         "| drifts | not adjusted |\n| --- | ---: | ---: | ---: | ---: |");
    is_good &= run_drifts(rigs, NOISE);
    is_good &= run_drifts(rigs, NOISE / 20);
    is_good &= run_stamps(rigs);
    return is_check && !is_good;
}

void setUp(void)
{
}

void tearDown(void)
{
}
