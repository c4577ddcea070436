/* bench_alarm: how often the alarm of a monitor is false. Nothing moves in simulated rigs.
 *
 *   bench_alarm check                              few frames of few cases, with limits
 *   bench_alarm known FRAMES ARL0 COMMON [CASE]    the alarm alone, its rig being known,
 *                                                  with rows that are made here in double
 *   bench_alarm watched FRAMES ARL0 COMMON [CASE]  the whole monitor, which begins with
 *                                                  0.05 degrees and 2 mm
 *
 * FRAMES is the number of frames in each case; 1e7 take an hour. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rc_alarm.h"
#include "test_watched.h"

#ifndef BENCH_BUILD
#define BENCH_BUILD ""
#endif

enum { CAMERAS_MAX = 8, POOL = 4000 };

static const double SIGMA = 0.3 / 800; /* noise of a pixel, normalised */
static const double WRONG_SPREAD = 50; /* standard deviations: wrong matches are at most
                                          this far off */

typedef enum { NORMAL, LAPLACE, STUDENT_3 } noise_kind;
static const char *const NOISE_NAMES[] = {"normal", "Laplace", "t, 3 dof"};

typedef struct {
    int cameras, matches;
    noise_kind noise;
    double size, wrong;
} quiet;

static const quiet CASES[] = {
    {2, 5, NORMAL, 1, 0},     {2, 10, NORMAL, 1, 0},   {2, 20, NORMAL, 1, 0},
    {2, 50, NORMAL, 1, 0},    {2, 100, NORMAL, 1, 0},  {3, 20, NORMAL, 1, 0},
    {4, 20, NORMAL, 1, 0},    {8, 5, NORMAL, 1, 0},    {8, 20, NORMAL, 1, 0},
    {8, 100, NORMAL, 1, 0},   {2, 20, LAPLACE, 1, 0},  {2, 20, STUDENT_3, 1, 0},
    {2, 20, NORMAL, 0.5, 0},  {2, 20, NORMAL, 2, 0},   {2, 20, NORMAL, 1, 0.1},
    {2, 20, NORMAL, 1, 0.3},  {4, 5, NORMAL, 0.5, 0},  {4, 100, NORMAL, 2, 0.3},
    {4, 20, STUDENT_3, 2, 0}, {2, 100, LAPLACE, 2, 0}, {2, 100, NORMAL, 0.5, 0},
};
enum { N_CASES = sizeof CASES / sizeof CASES[0] };

/* Unity needs these: the arithmetic of the tests uses its checks. */
void setUp(void)
{
}

void tearDown(void)
{
}

/* ---- rows of matches ---------------------------------------------------------- */

typedef struct {
    int a, b;
    rigcal_real h[2][6];
} pool_row;

typedef struct {
    double R[9], t[3], o[3];
} camera;

static pool_row pool[POOL];

/* Two cameras: a parallel pair, 12 cm apart. More: on an arc of 3 m, looking at its
 * middle. */
static void make_rig(camera rig[], int n)
{
    for (int i = 0; i < n; i++) {
        const double angle = n > 1 ? -0.5 + i / (n - 1.0) : 0;
        const double turn = n == 2 ? 0 : -angle;
        const double o[3] = {n == 2 ? 0.12 * i : 3 * sin(angle),
                             n == 2 ? 0 : 0.25 * (i % 2 ? -1 : 1),
                             n == 2 ? 0 : 3 - 3 * cos(angle)};
        double t[3];
        test_rotation(rig[i].R, 0, turn, 0);
        test_apply(t, rig[i].R, o, NULL);
        for (int k = 0; k < 3; k++) {
            rig[i].o[k] = o[k];
            rig[i].t[k] = -t[k];
        }
    }
}

/* Derivatives of Sampson's distance of a match by the errors of its two cameras, in
 * standard deviations. They are difference quotients of the epipolar product. */
static double sampson(const camera *a, const camera *b, double m[2][3])
{
    double da[3], db[3], base[3], Rt[9], n[3], na[3], nb[3], g[3], g2 = 0;
    const camera *const both[2] = {a, b};
    test_transpose(Rt, a->R);
    test_apply(da, Rt, m[0], NULL);
    test_transpose(Rt, b->R);
    test_apply(db, Rt, m[1], NULL);
    for (int k = 0; k < 3; k++) {
        base[k] = a->o[k] - b->o[k];
    }
    test_cross(nb, base, da);
    test_cross(na, db, base);
    for (int side = 0; side < 2; side++) {
        memcpy(n, side ? nb : na, sizeof n);
        test_apply(g, both[side]->R, n, NULL);
        g2 += g[0] * g[0] + g[1] * g[1];
    }
    return -test_dot(db, nb) / (SIGMA * sqrt(g2));
}

static void moved(camera *out, const camera *c, int k, double step)
{
    double axis[3] = {0, 0, 0}, turn[9], Rt[9], o[3];
    *out = *c;
    if (k < 3) {
        axis[k] = 1;
        test_rotation_about(turn, axis, step);
        test_product(out->R, turn, c->R);
    } else {
        out->t[k - 3] += step;
    }
    test_transpose(Rt, out->R);
    test_apply(o, Rt, out->t, NULL);
    for (int j = 0; j < 3; j++) {
        out->o[j] = -o[j];
    }
}

static void make_pool(int n_cameras)
{
    camera rig[CAMERAS_MAX], near, far;
    test_rng rng = test_seed(77);
    make_rig(rig, n_cameras);
    for (int i = 0; i < POOL; i++) {
        pool_row *const p = &pool[i];
        p->a = (int)test_uniform(&rng, 0, n_cameras);
        p->b = (p->a + 1 + (int)test_uniform(&rng, 0, n_cameras - 1)) % n_cameras;
        const double depth = test_uniform(&rng, 0, 1);
        const double X[3] = {test_uniform(&rng, -1, 1), test_uniform(&rng, -1, 1),
                             2 + 2 * depth};
        double m[2][3];
        for (int side = 0; side < 2; side++) {
            const camera *const c = &rig[side ? p->b : p->a];
            test_project(m[side], c->R, c->t, X);
            m[side][2] = 1;
        }
        for (int k = 0; k < 12; k++) {
            const int side = k / 6;
            const camera *const c = &rig[side ? p->b : p->a];
            const double step = 1e-5;
            moved(&near, c, k % 6, -step);
            moved(&far, c, k % 6, step);
            const double rise =
                side ? sampson(&rig[p->a], &far, m) - sampson(&rig[p->a], &near, m)
                     : sampson(&far, &rig[p->b], m) - sampson(&near, &rig[p->b], m);
            p->h[side][k % 6] = RC(-rise / (2 * step));
        }
    }
}

/* ---- noise ---------------------------------------------------------------------- */

static double normal(test_rng *rng)
{
    const double r = sqrt(-2 * log(1 - test_uniform(rng, 0, 1)));
    return r * cos(2 * TEST_PI * test_uniform(rng, 0, 1));
}

/* Noise of standard deviation 1. That of t has the scale 1. */
static double noise(const quiet *c, test_rng *rng)
{
    if (test_uniform(rng, 0, 1) < c->wrong) {
        return test_uniform(rng, -WRONG_SPREAD, WRONG_SPREAD);
    }
    double z = 0, squares = 0;
    switch (c->noise) {
    case NORMAL:
        z = normal(rng);
        break;
    case LAPLACE:
        z = test_uniform(rng, -1, 1);
        z = (z < 0 ? 1 : -1) * log(1 - fabs(z)) / sqrt(2);
        break;
    case STUDENT_3:
        for (int k = 0; k < 3; k++) {
            const double n = normal(rng);
            squares += n * n / 3;
        }
        z = normal(rng) / sqrt(squares);
        break;
    }
    return c->size * z;
}

/* ---- counting -------------------------------------------------------------------- */

static long count(const quiet *c, double frames, double arl0, double common)
{
    static rigcal_real bodies[CAMERAS_MAX * RC_ALARM_BODY];
    static rc_alarm alarm;
    test_rng rng = test_seed(5);
    long n = 0;
    make_pool(c->cameras);
    rc_alarm_begin(&alarm, bodies, (size_t)c->cameras, RC(arl0), RC(common), RC(0.0524),
                   RC(c->cameras == 2 ? 0.00063 : 0.0157));
    for (double f = 0; f < frames; f++) {
        for (int i = 0; i < c->matches; i++) {
            const pool_row *const p = &pool[(int)test_uniform(&rng, 0, POOL)];
            rc_alarm_row(&alarm, bodies, RC(noise(c, &rng)), 1, (size_t)p->a, p->h[0],
                         (size_t)p->b, p->h[1]);
        }
        if (rc_alarm_frame(&alarm, bodies) >= 0) {
            n++;
            rc_alarm_again(&alarm, bodies);
        }
    }
    return n;
}

/* ---- the whole monitor ----------------------------------------------------------- */

static const double NOISE_PX = 0.3, WRONG_PX = 40;

/* The ray of a noisy pixel of the point. */
static void see(rigcal_real ray[3], const test_watched *w, const quiet *c, int by,
                const double X[3], test_rng *rng)
{
    double uv[2];
    test_watched_pixel(uv, w, by, X);
    ray[0] = RC((uv[0] + NOISE_PX * noise(c, rng) - 640) / 800);
    ray[1] = RC((uv[1] + NOISE_PX * noise(c, rng) - 480) / 800);
    ray[2] = 1;
}

static void watch_match(test_watched *w, const quiet *c, test_rng *rng)
{
    quiet right = *c;
    const int a = (int)test_uniform(rng, 0, c->cameras);
    const int b = (a + 1 + (int)test_uniform(rng, 0, c->cameras - 1)) % c->cameras;
    double X[3];
    rigcal_real ray[2][3];
    right.wrong = 0;
    test_watched_point(X, w, rng);
    see(ray[0], w, &right, a, X, rng);
    see(ray[1], w, &right, b, X, rng);
    if (test_uniform(rng, 0, 1) < c->wrong) {
        ray[1][0] += RC(test_uniform(rng, -WRONG_PX, WRONG_PX) / 800);
        ray[1][1] += RC(test_uniform(rng, -WRONG_PX, WRONG_PX) / 800);
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_match_rays(w->monitor, (size_t)a, ray[0],
                                                       (size_t)b, ray[1], RC(NOISE_PX)));
}

static long count_watched(const quiet *c, double frames, double arl0, double common)
{
    static test_watched w;
    test_rng rng = test_seed(6);
    rigcal_monitor_options options;
    rigcal_monitor_report report;
    long n = 0;
    test_watched_make(&w, &rng, c->cameras, c->cameras == 2, 0.05 * TEST_PI / 180, 2e-3);
    (void)rigcal_monitor_defaults(&options);
    options.arl0_frames = RC(arl0);
    options.common = RC(common);
    test_watched_begin(&w, 0, &options);
    for (double f = 0; f < frames; f++) {
        for (int i = 0; i < c->matches; i++) {
            watch_match(&w, c, &rng);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(&report, w.monitor, RC(1.0 / 30)));
        if (report.alarm) {
            n++;
            ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_dismiss(w.monitor));
        }
    }
    return n;
}

/* ---- tables ---------------------------------------------------------------------- */

typedef long counting(const quiet *c, double frames, double arl0, double common);

static void print_head(double frames, double arl0, double common)
{
    printf(
        "%.3g frames a case, ARL0 %.0f: %.0f false alarms stated; common %.1f; %s; %s\n\n",
        frames, arl0, frames / arl0, common,
        sizeof(rigcal_real) == sizeof(float) ? "float" : "double", BENCH_BUILD);
    printf("| cameras | matches a frame | noise | over what is stated | wrong | counted | "
           "counted over stated |\n| ---: | ---: | --- | ---: | ---: | ---: | ---: |\n");
}

static double print_case(counting *count_false, const quiet *c, double frames, double arl0,
                         double common)
{
    const long n = count_false(c, frames, arl0, common);
    const double ratio = (double)n * arl0 / frames;
    printf("| %d | %d | %s | %.1f | %.0f %% | %ld | %.2f |\n", c->cameras, c->matches,
           NOISE_NAMES[c->noise], c->size, 100 * c->wrong, n, ratio);
    (void)fflush(stdout);
    return ratio;
}

/* Each case should give 60 false alarms. Allowed are 0.4 to 1.25 times that, three standard
 * errors more on each side; with `common` no more than the stated number. */
static int check(void)
{
    static const int FEW[] = {0, 2, 7, 15};
    const double frames = 6000, arl0 = 100, error = 3 / sqrt(frames / arl0);
    int failed = 0;
    print_head(frames, arl0, 0);
    for (int i = 0; i < 4; i++) {
        const double ratio = print_case(count, &CASES[FEW[i]], frames, arl0, 0);
        failed |= !(ratio > 0.4 - error * sqrt(0.4) && ratio < 1.25 + error * sqrt(1.25));
    }
    const double ratio = print_case(count_watched, &CASES[2], frames / 2, arl0, 0.5);
    failed |= !(ratio < 1 + error * sqrt(2));
    return failed;
}

int main(int argc, char *argv[])
{
    if (argc == 2 && strcmp(argv[1], "check") == 0) {
        return check();
    }
    if (argc < 5 || (strcmp(argv[1], "known") != 0 && strcmp(argv[1], "watched") != 0)) {
        (void)fprintf(stderr,
                      "bench_alarm check | known|watched FRAMES ARL0 COMMON [CASE]\n");
        return 2;
    }
    counting *const count_false = strcmp(argv[1], "known") == 0 ? count : count_watched;
    const double frames = atof(argv[2]), arl0 = atof(argv[3]), common = atof(argv[4]);
    print_head(frames, arl0, common);
    for (int i = 0; i < N_CASES; i++) {
        if (argc < 6 || atoi(argv[5]) == i) {
            (void)print_case(count_false, &CASES[i], frames, arl0, common);
        }
    }
    return 0;
}
