/* bench_monitor: does a monitor know how well it knows, whom does it blame, and how soon.
 * Simulated rigs, 20 matches a frame of 0.3 px.
 *
 *   bench_monitor check            few rigs of few cases, with limits
 *   bench_monitor coverage RIGS    the 95 % ellipsoid of all, after 10 to 1000 frames
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

/* Unity needs these: the arithmetic of the tests uses its checks. */
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
    {2, 1, 0},   {2, 1, 0.1}, {2, 1, 0.3}, {2, 0, 0},   {2, 0, 0.1}, {3, 0, 0},
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

static double coverage(int rigs, const rig_case *c, int most)
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
    printf("| %d cameras, %s, %.0f %% |", c->cameras,
           c->is_parallel ? "parallel pair" : "on an arc", 100 * c->wrong);
    for (int k = 0; k < most; k++) {
        printf(" %.1f (%.2f) |", 100.0 * inside[k] / rigs, nees[k]);
    }
    printf("\n");
    fflush(stdout);
    return (double)inside[most - 1] / rigs;
}

/* ---- after a bump ------------------------------------------------------------------ */

/* A random move: a turn of up to `degrees` about any axis, and a shift. */
static void random_move(double d[6], test_rng *rng, double degrees, double t)
{
    for (int k = 0; k < 6; k++) {
        d[k] = (k < 3 ? 1 : t) * test_normal(rng);
    }
    const double scale = test_uniform(rng, 0, degrees * DEGREE) / test_norm(d);
    for (int k = 0; k < 3; k++) {
        d[k] *= scale;
    }
}

/* Answers a bump, either with the known body opened, or with an alarm that is answered. */
static void bump(int rigs, const rig_case *c, double degrees, int by_alarm)
{
    const double t = c->is_parallel ? 1e-3 : 5e-3;
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
        o.move_rad = (rigcal_real)(3 * DEGREE);
        o.move_t = (rigcal_real)t;
        o.arl0_frames = by_alarm ? RC(1e4) : RC(1e9);
        test_watched_begin(&w, 0, &o);
        for (int f = 0; f < 100; f++) {
            frame(&report, &rng, c, 1);
        }
        random_move(d, &rng, degrees, t);
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
    printf("| %d cameras, %s, %.0f %% | up to %.2f | %s | %d |", c->cameras,
           c->is_parallel ? "parallel pair" : "on an arc", 100 * c->wrong, degrees,
           by_alarm ? "alarm" : "opened", tried);
    for (int k = 0; k < 4; k++) {
        printf(tried > 0 ? " %.1f (%.2f) |" : " - |", 100.0 * inside[k] / tried,
               nees[k] / tried);
    }
    printf("\n");
    fflush(stdout);
}

/* ---- blame --------------------------------------------------------------------- */

typedef struct {
    int cameras, is_parallel, has_tag;
    double degrees, wrong;
} blame_case;

static const blame_case BLAMES[] = {
    {3, 0, 0, 0.05, 0},   {3, 0, 0, 0.05, 0.3}, {3, 0, 0, 0.2, 0},   {3, 0, 0, 0.2, 0.3},
    {3, 0, 0, 1, 0},      {3, 0, 0, 1, 0.3},    {4, 0, 0, 0.05, 0},  {4, 0, 0, 0.05, 0.3},
    {4, 0, 0, 0.2, 0},    {4, 0, 0, 0.2, 0.3},  {4, 0, 0, 1, 0.3},   {8, 0, 0, 0.05, 0},
    {8, 0, 0, 0.05, 0.3}, {8, 0, 0, 0.2, 0},    {8, 0, 0, 0.2, 0.3}, {2, 0, 1, 0.2, 0},
    {2, 1, 1, 0.2, 0},    {2, 1, 1, 1, 0.3},    {2, 0, 0, 0.2, 0},   {2, 1, 0, 1, 0.3},
};
enum { N_BLAMES = sizeof BLAMES / sizeof BLAMES[0] };

static const double TAG[4][3] = {
    {-0.1, -0.1, 0}, {0.1, -0.1, 0}, {0.1, 0.1, 0}, {-0.1, 0.1, 0}};

/* A tag 2.5 before the cameras, with a random orientation. */
static void hang_tag(test_rng *rng)
{
    watched_pose *const pose = &w.truth[w.n_cameras];
    const double axis[3] = {test_normal(rng), test_normal(rng), 0};
    const double at[3] = {0.1, -0.1, 2.5};
    double minus[3];

    test_rotation_about(pose->R, axis, 0.6);
    test_apply(minus, pose->R, at, NULL);
    for (int k = 0; k < 3; k++) {
        pose->t[k] = -minus[k];
    }
}

static void see_tag(test_rng *rng)
{
    for (int c = 0; c < w.n_cameras; c++) {
        rigcal_observation o[4];

        for (int k = 0; k < 4; k++) {
            double X[3], uv[2];

            test_watched_target_point(X, &w, 0, TAG[k]);
            test_watched_pixel(uv, &w, c, X);
            test_to_real(o[k].X_w, TAG[k], 3);
            o[k].uv[0] = (rigcal_real)(uv[0] + NOISE * test_normal(rng));
            o[k].uv[1] = (rigcal_real)(uv[1] + NOISE * test_normal(rng));
        }
        (void)rigcal_monitor_view(w.monitor, NULL, (size_t)c, 0, o, 4, (rigcal_real)NOISE);
    }
}

static void seen_frame(rigcal_monitor_report *report, test_rng *rng, double wrong, int tag)
{
    const watched_matches like = {20, NOISE, wrong, 1};

    test_watched_match(&w, rng, &like);
    if (tag) {
        see_tag(rng);
    }
    (void)rigcal_monitor_frame(report, w.monitor, (rigcal_real)SECONDS);
}

/* Turns a body after a number of frames at rest, and answers 15 frames after the alarm. */
static int blame_one(int *body, int *sure, double *confidence, const blame_case *c, int r)
{
    test_rng rng = test_seed(9900 + (uint64_t)r);
    rigcal_monitor_options o;
    rigcal_monitor_report report;
    double d[6] = {0, 0, 0, 0, 0, 0};

    *body = r % (c->cameras + c->has_tag);
    test_watched_make(&w, &rng, c->cameras, c->is_parallel, 0.05 * DEGREE, 2e-3);
    (void)rigcal_monitor_defaults(&o);
    o.arl0_frames = RC(1e4);
    o.wrong = c->wrong > 0.2 ? RC(0.3) : RC(0.1);
    test_watched_begin(&w, c->has_tag, &o);
    if (c->has_tag) {
        hang_tag(&rng);
    }
    for (int f = 0; f < 200; f++) {
        seen_frame(&report, &rng, c->wrong, c->has_tag);
        if (report.alarm) {
            (void)rigcal_monitor_dismiss(w.monitor);
        }
    }
    for (int k = 0; k < 3; k++) {
        d[k] = test_normal(&rng);
    }
    const double scale = c->degrees * DEGREE / test_norm(d);
    for (int k = 0; k < 3; k++) {
        d[k] *= scale;
    }
    test_watched_bump(&w, *body, d);
    int f = 0;
    for (f = 0; f < 600 && report.frames_since < 16; f++) {
        seen_frame(&report, &rng, c->wrong, c->has_tag);
    }
    if (report.frames_since < 16) {
        return 0;
    }
    rigcal_body_report of_body;
    (void)rigcal_monitor_body(&of_body, w.monitor, (size_t)*body);
    *confidence = D(of_body.blame);
    *sure = report.confidence > RC(0.99);
    *body = report.body == *body;
    return 1;
}

static double blame(int bumps, const blame_case *c)
{
    int alarms = 0, right = 0, sure = 0, sure_right = 0;
    double mean = 0;

    for (int r = 0; r < bumps; r++) {
        int is_right, is_sure;
        double confidence;

        if (blame_one(&is_right, &is_sure, &confidence, c, r)) {
            alarms++;
            right += is_right;
            sure += is_sure;
            sure_right += is_sure && is_right;
            mean += confidence;
        }
    }
    printf(
        "| %d cameras%s%s | %.2f | %.0f %% | %d | %.1f %% | %.1f %% | %.1f %% | %.3f |\n",
        c->cameras, c->is_parallel ? " parallel" : "", c->has_tag ? " and a tag" : "",
        c->degrees, 100 * c->wrong, alarms, 100.0 * right / alarms, 100.0 * sure / alarms,
        sure ? 100.0 * sure_right / sure : 0, mean / alarms);
    fflush(stdout);
    return (double)right / bumps;
}

/* ---- delay ----------------------------------------------------------------------- */

/* The CUSUM's mean delay for a shift of mu standard deviations a frame (Siegmund 1985). */
static double limit_of(double mu, double arl0)
{
    double low = 1e-6, high = 60 / mu + 2;

    for (int i = 0; i < 200; i++) {
        const double b = (low + high) / 2, x = fmin(mu * b, 700);
        if (2 * (exp(x) - 1 - mu * b) / (mu * mu) < arl0) {
            low = b;
        } else {
            high = b;
        }
    }
    return fmax(1, 2 * (exp(-mu * low) - 1 + mu * low) / (mu * mu));
}

/* Sampson's distance of an exact match by inexact poses, in standard deviations. */
static double distance_of(const watched_pose *a, const watched_pose *b, const double ua[2],
                          const double ub[2])
{
    double At[9], R[9], t[3], q[3], n[3], ga[3], gaa[3];
    const double ma[3] = {(ua[0] - 640) / 800, (ua[1] - 480) / 800, 1};
    const double mb[3] = {(ub[0] - 640) / 800, (ub[1] - 480) / 800, 1};

    test_transpose(At, a->R);
    test_product(R, b->R, At);
    test_apply(t, R, a->t, NULL);
    for (int k = 0; k < 3; k++) {
        t[k] = b->t[k] - t[k];
    }
    test_apply(q, R, ma, NULL);
    test_cross(n, t, q);
    test_cross(ga, mb, t);
    test_transpose(At, R);
    test_apply(gaa, At, ga, NULL);
    return test_dot(mb, n) / (NOISE / 800) /
           sqrt(gaa[0] * gaa[0] + gaa[1] * gaa[1] + n[0] * n[0] + n[1] * n[1]);
}

/* The shift, in standard deviations a frame, between the true poses now and `before`. */
static double shift_of(const test_watched *before, test_rng *rng)
{
    double sum = 0;
    const int n = 4000;

    for (int i = 0; i < n; i++) {
        const int a = (int)test_uniform(rng, 0, w.n_cameras);
        const int b = (a + 1 + (int)test_uniform(rng, 0, w.n_cameras - 1)) % w.n_cameras;
        double X[3], ua[2], ub[2];

        test_watched_point(X, &w, rng);
        test_watched_pixel(ua, &w, a, X);
        test_watched_pixel(ub, &w, b, X);
        const double x = distance_of(&before->truth[a], &before->truth[b], ua, ub);
        sum += x * x;
    }
    return sqrt(20 * sum / n);
}

static test_watched before;

/* A body moves in any direction of (w, dt / lever), by mu_least to mu_most standard
 * deviations a frame, after 200 to 456 frames. */
static void delay(int moves, const rig_case *c, double common, double mu_least,
                  double mu_most)
{
    double ratio = 0, frames = 0;
    int found = 0, tried = 0;

    for (int r = 0; r < moves; r++) {
        test_rng rng = test_seed(5500 + (uint64_t)r);
        rigcal_monitor_options o;
        rigcal_monitor_report report = {0};
        double d[6];
        const int quiet = 200 + (int)test_uniform(&rng, 0, 256);

        test_watched_make(&w, &rng, c->cameras, c->is_parallel, 0.05 * DEGREE, 2e-3);
        (void)rigcal_monitor_defaults(&o);
        o.arl0_frames = RC(1e4);
        o.common = (rigcal_real)common;
        o.wrong = c->wrong > 0.2 ? RC(0.3) : RC(0.1);
        test_watched_begin(&w, 0, &o);
        int f = 0;
        for (f = 0; f < quiet && !report.alarm; f++) {
            seen_frame(&report, &rng, c->wrong, 0);
        }
        if (report.alarm) { /* a false one */
            continue;
        }
        before = w;
        for (int k = 0; k < 6; k++) {
            d[k] = (k < 3 ? 1 : 0.1) * test_normal(&rng);
        }
        /* scales the move to the wanted size by its effect when it is small */
        double wanted = test_uniform(&rng, mu_least, mu_most), e[6];
        for (int k = 0; k < 6; k++) {
            e[k] = d[k] * 1e-4;
        }
        const int body = r % c->cameras;
        test_watched_bump(&w, body, e);
        const double scale = 1e-4 * wanted / shift_of(&before, &rng);
        memcpy(w.truth, before.truth, sizeof w.truth);
        for (int k = 0; k < 6; k++) {
            d[k] *= scale;
        }
        const double turn = test_norm(d);
        if (mu_most > 4 && turn > 10 * DEGREE) {
            for (int k = 0; k < 6; k++) {
                d[k] *= 10 * DEGREE / turn;
            }
        }
        test_watched_bump(&w, body, d);
        for (f = 0; f < 600 && !report.alarm; f++) {
            seen_frame(&report, &rng, c->wrong, 0);
        }
        tried++;
        found += report.alarm;
        frames += f;
        ratio += f / limit_of(wanted, 1e4);
    }
    printf("| %d cameras%s | %.1f | %.0f %% | %.1f to %.1f | %.1f %% | %.1f | %.2f |\n",
           c->cameras, c->is_parallel ? " parallel" : "", common, 100 * c->wrong, mu_least,
           mu_most, 100.0 * found / tried, frames / tried, ratio / tried);
    fflush(stdout);
}

static const rig_case MOVED[] = {{2, 1, 0},   {4, 0, 0},   {2, 1, 0.1},
                                 {4, 0, 0.1}, {2, 1, 0.3}, {4, 0, 0.3}};

int main(int argc, char *argv[])
{
    const int many = argc > 2 ? atoi(argv[2]) : 100;

    if (argc > 1 && strcmp(argv[1], "check") == 0) {
        const blame_case turned = {4, 0, 0, 0.2, 0.3};
        const int holds =
            coverage(100, &RIGS[4], 1) > 0.88 && coverage(60, &RIGS[8], 1) > 0.86;
        const int named = blame(16, &turned) > 0.85;

        return holds && named ? 0 : 1;
    }

    if (argc > 1 && strcmp(argv[1], "coverage") == 0) {
        const int most = argc > 3 ? atoi(argv[3]) : 3;
        printf("| rig, wrong matches |");
        for (int k = 0; k < most; k++) {
            printf(" frame %d |", AFTER[k]);
        }
        printf("\n| --- |%s\n", most == 1   ? " ---: |"
                                : most == 2 ? " ---: | ---: |"
                                            : " ---: | ---: | ---: |");
        for (int k = 0; k < N_RIGS; k++) {
            coverage(many, &RIGS[k], most);
        }
    } else if (argc > 1 && strcmp(argv[1], "bump") == 0) {
        const int only = argc > 3 ? atoi(argv[3]) : -1;
        printf("| rig, wrong matches | turn | | bumps | frame 1 | 3 | 10 | 30 |\n"
               "| --- | --- | --- | ---: | ---: | ---: | ---: | ---: |\n");
        for (int k = 0; k < N_RIGS; k++) {
            if (only >= 0 && k != only) {
                continue;
            }
            bump(many, &RIGS[k], 3, 0);
            bump(many, &RIGS[k], 3, 1);
            bump(many, &RIGS[k], 0.2, 1);
        }
    }
    if (argc > 1 && strcmp(argv[1], "blame") == 0) {
        const int only = argc > 3 ? atoi(argv[3]) : -1;
        printf(
            "| rig | turn, degrees | wrong | alarms | right | sure (> 0.99) | right when "
            "sure | mean probability of the right one |\n"
            "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
        for (int k = 0; k < N_BLAMES; k++) {
            if (only >= 0 && k != only) {
                continue;
            }
            blame(many, &BLAMES[k]);
        }
    } else if (argc > 1 && strcmp(argv[1], "delay") == 0) {
        printf(
            "| rig | common | wrong | move | found in 600 frames | frames | over the limit "
            "|\n| --- | ---: | ---: | --- | ---: | ---: | ---: |\n");
        for (int k = 0; k < 6; k++) {
            if (k < 2) {
                delay(many, &MOVED[k], 0, 0.8, 2);
                delay(many, &MOVED[k], 0, 4, 100);
            }
            delay(many, &MOVED[k], 0.5, 0.8, 2);
            delay(many, &MOVED[k], 0.5, 4, 100);
        }
    }
    return 0;
}
