/* bench_monitor: does a monitor know how well it knows, whom does it blame, and how soon.
 * Simulated rigs, 20 matches a frame of 0.3 px.
 *
 *   bench_monitor check            few rigs of few cases, with limits
 *   bench_monitor coverage RIGS    the 95 % ellipsoid of all unknowns, after 10 to 1000 frames
 *   bench_monitor bump RIGS        the same after a bump
 *   bench_monitor blame BUMPS      who it was
 *   bench_monitor delay MOVES      how soon the alarm comes */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "test_watched.h"

static const double DEGREE = TEST_PI / 180, NOISE = 0.3, SECONDS = 1.0 / 30;

static test_watched w;

/* Unity, which the tests' arithmetic is checked with, wants them. */
void setUp(void)
{
}

void tearDown(void)
{
}

/* ---- coverage ------------------------------------------------------------------- */

typedef struct {
    int cameras, is_parallel;
    double wrong;
} rig_case;

static const rig_case RIGS[] = {
    {2, 1, 0}, {2, 1, 0.1}, {2, 1, 0.3}, {2, 0, 0},   {2, 0, 0.1}, {3, 0, 0},
    {3, 0, 0.1}, {4, 0, 0},   {4, 0, 0.1}, {4, 0, 0.3}, {8, 0, 0},   {8, 0, 0.1},
};
enum { N_RIGS = sizeof RIGS / sizeof RIGS[0] };

static const int AFTER[] = {10, 100, 1000};

static void options_of(rigcal_monitor_options *o, const rig_case *c, double walk)
{
    (void)rigcal_monitor_defaults(o);
    o->wrong = c->wrong > 0 ? RC(0.1) : 0;
    o->walk_rad = (rigcal_real)(walk * 0.005 * DEGREE);
    o->walk_t = (rigcal_real)(walk * 5e-5);
    o->arl0_frames = RC(1e9);
}

static void frame(rigcal_monitor_report *report, test_rng *rng, const rig_case *c,
                  double walk)
{
    const watched_matches like = {20, NOISE, c->wrong, 1};

    test_watched_walk(&w, rng, walk * 0.005 * DEGREE * sqrt(SECONDS),
                      walk * 5e-5 * sqrt(SECONDS));
    test_watched_match(&w, rng, &like);
    (void)rigcal_monitor_frame(report, w.monitor, (rigcal_real)SECONDS);
    if (report->alarm) {
        (void)rigcal_monitor_dismiss(w.monitor);
    }
}

static void coverage(int rigs, const rig_case *c, int most)
{
    const int n = 6 * (c->cameras - 1);
    int inside[3] = {0, 0, 0};
    double nees[3] = {0, 0, 0};

    for (int r = 0; r < rigs; r++) {
        test_rng rng = test_seed(7700 + (uint64_t)r);
        rigcal_monitor_options o;
        rigcal_monitor_report report;
        double e[WATCHED_FREE_MAX];
        int at = 0;

        test_watched_make(&w, &rng, c->cameras, c->is_parallel, 0.05 * DEGREE, 2e-3);
        options_of(&o, c, 1);
        test_watched_begin(&w, 0, &o);
        for (int f = 1; f <= AFTER[most - 1]; f++) {
            frame(&report, &rng, c, 1);
            if (f == AFTER[at]) {
                const double x = test_watched_nees(&w, e);
                inside[at] += x < test_chi2_95(n);
                nees[at] += x / n / rigs;
                at++;
            }
        }
    }
    printf("%d cameras, %s, %2.0f %% wrong:", c->cameras,
           c->is_parallel ? "parallel" : "arc     ", 100 * c->wrong);
    for (int k = 0; k < most; k++) {
        printf("  %5.1f (%.2f)", 100.0 * inside[k] / rigs, nees[k]);
    }
    printf("\n");
    fflush(stdout);
}

/* ---- after a bump ------------------------------------------------------------------ */

static void random_move(double d[6], test_rng *rng, double rad, double t)
{
    for (int k = 0; k < 6; k++) {
        d[k] = (k < 3 ? rad : t) * test_normal(rng);
    }
}

/* The body is known, and opened; or an alarm was answered. */
static void bump(int rigs, const rig_case *c, double degrees, int by_alarm)
{
    static const int FRAMES[] = {1, 3, 10, 30};
    const int n = 6 * (c->cameras - 1);
    int inside[4] = {0, 0, 0, 0}, tried = 0, right = 0;
    double nees[4] = {0, 0, 0, 0};

    for (int r = 0; r < rigs; r++) {
        test_rng rng = test_seed(8800 + (uint64_t)r);
        rigcal_monitor_options o;
        rigcal_monitor_report report;
        double e[WATCHED_FREE_MAX], d[6];
        const int body = r % c->cameras;

        test_watched_make(&w, &rng, c->cameras, c->is_parallel, 0.05 * DEGREE, 2e-3);
        options_of(&o, c, 1);
        o.move_rad = (rigcal_real)(degrees * DEGREE);
        o.move_t = RC(5e-3);
        o.arl0_frames = by_alarm ? RC(1e4) : RC(1e9);
        test_watched_begin(&w, 0, &o);
        for (int f = 0; f < 100; f++) {
            frame(&report, &rng, c, 1);
        }
        random_move(d, &rng, degrees * DEGREE, 5e-3);
        test_watched_bump(&w, body, d);
        if (by_alarm) {
            const watched_matches like = {20, NOISE, c->wrong, 1};
            int since = 0;

            for (int f = 0; f < 100 && since < 15; f++) {
                test_watched_walk(&w, &rng, 0.005 * DEGREE * sqrt(SECONDS),
                                  5e-5 * sqrt(SECONDS));
                test_watched_match(&w, &rng, &like);
                (void)rigcal_monitor_frame(&report, w.monitor, (rigcal_real)SECONDS);
                since = (int)report.frames_since;
            }
            if (since < 15) {
                continue;
            }
            right += report.body == body;
            if (report.body != body) {
                continue;
            }
        }
        tried++;
        (void)rigcal_monitor_moved(w.monitor, (size_t)body);
        int at = 0;
        for (int f = 1; f <= 30; f++) {
            frame(&report, &rng, c, 1);
            if (f == FRAMES[at]) {
                const double x = test_watched_nees(&w, e);
                inside[at] += x < test_chi2_95(n);
                nees[at] += x / n;
                at++;
            }
        }
    }
    printf("%d cameras, %s, %2.0f %% wrong, %.2f degrees, %s %d of %d:", c->cameras,
           c->is_parallel ? "parallel" : "arc     ", 100 * c->wrong, degrees,
           by_alarm ? "alarm " : "opened", tried, rigs);
    for (int k = 0; k < 4; k++) {
        printf("  %5.1f (%.2f)", 100.0 * inside[k] / tried, nees[k] / tried);
    }
    printf(" right %d\n", right);
    fflush(stdout);
}

int main(int argc, char *argv[])
{
    const int many = argc > 2 ? atoi(argv[2]) : 100;

    if (argc > 1 && strcmp(argv[1], "coverage") == 0) {
        const int most = argc > 3 ? atoi(argv[3]) : 3;
        for (int k = 0; k < N_RIGS; k++) {
            coverage(many, &RIGS[k], most);
        }
    } else if (argc > 1 && strcmp(argv[1], "bump") == 0) {
        for (int k = 0; k < N_RIGS; k++) {
            bump(many, &RIGS[k], 3, 0);
            bump(many, &RIGS[k], 3, 1);
            bump(many, &RIGS[k], 0.2, 1);
        }
    }
    return 0;
}
