/* gate: what the library does on seeded scenes, as counts. A constant of src/ that is
 * halved or doubled changes one of them: constants.py tries it.
 *
 *   gate              prints a line a counter: its name and its value
 *   gate check FILE   compares them with those of FILE; exit status 1 if any differs
 *
 * The library is built with count_hooks.h, so that calls of its math functions measure
 * work. Scenes come from arithmetic and square roots alone: every compiler that rounds each
 * operation gets the same counts. Counters that begin with "stack." are bounds. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "count_hooks.h"
#include "rc_adjust.h"
#include "rc_alarm.h"
#include "rc_chain.h"
#include "rc_chance.h"
#include "rc_direction.h"
#include "rc_finding.h"
#include "rc_levenberg.h"
#include "rc_logs.h"
#include "rc_monitor.h"
#include "rc_neldermead.h"
#include "rc_outline.h"
#include "rc_p3p.h"
#include "rc_pose.h"
#include "rc_sight.h"
#include "rc_store.h"
#include "rc_times.h"
#include "rigcal_paper.h"

#define PI 3.14159265358979323846
#define ANY_OF(double_value, float_value) \
    (RIGCAL_USE_FLOAT ? (float_value) : (double_value))

enum { POINTS_MAX = 160 };

/* ---- counters ------------------------------------------------------------ */

static unsigned long calls;

void hook_called(int hook, const char *function, double x)
{
    (void)hook;
    (void)function;
    (void)x;
    calls++;
}

static char lines[1000][80];
static int n_lines;

static void line(const char *name, const char *format, ...)
{
    va_list arguments;
    char value[32];
    va_start(arguments, format);
    vsnprintf(value, sizeof value, format, arguments);
    va_end(arguments);
    if (n_lines < 1000) {
        snprintf(lines[n_lines++], sizeof lines[0], "%s %s", name, value);
    }
}

/* Counts for the scenes of a group. */
typedef struct {
    const char *name;
    long statuses[64], misses, wrong_ok, found, steps;
    unsigned long calls_before;
} tally;

static void begin(tally *t, const char *name)
{
    memset(t, 0, sizeof *t);
    t->name = name;
    t->calls_before = calls;
}

static void end(const tally *t)
{
    char name[64];
    for (int i = 0; i < 64; i++) {
        if (t->statuses[i] != 0) {
            snprintf(name, sizeof name, "%s.%s", t->name,
                     rigcal_status_name(i - 32) + strlen("RIGCAL_"));
            line(name, "%ld", t->statuses[i]);
        }
    }
    const struct {
        const char *what;
        long value;
    } rest[] = {{"misses", t->misses},
                {"wrong_ok", t->wrong_ok},
                {"found", t->found},
                {"steps", t->steps},
                {"calls", (long)(calls - t->calls_before)}};
    for (size_t i = 0; i < sizeof rest / sizeof rest[0]; i++) {
        if (rest[i].value != 0) {
            snprintf(name, sizeof name, "%s.%s", t->name, rest[i].what);
            line(name, "%ld", rest[i].value);
        }
    }
}

static rigcal_status count(tally *t, rigcal_status status)
{
    t->statuses[status + 32]++;
    return status;
}

/* The largest x between low and high for which `holds` is true, to three digits. It must be
 * true for low and false for high. Bisection of the logarithm. */
typedef int (*predicate)(double x);

static void edge(const char *name, predicate holds, double low, double high)
{
    if (!holds(low) || holds(high)) {
        line(name, "none");
        return;
    }
    for (int i = 0; i < 80; i++) {
        const double middle = sqrt(low * high);
        *(holds(middle) ? &low : &high) = middle;
    }
    line(name, "%.3g", low);
}

/* ---- random numbers (SplitMix64) ----------------------------------------- */

static uint64_t state;

static uint64_t draw(void)
{
    uint64_t z = state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

static double uniform(double low, double high)
{
    return low + (high - low) * ((double)(draw() >> 11) / 9007199254740992.0);
}

static double normal(void)
{
    double sum = -6;
    for (int i = 0; i < 12; i++) {
        sum += uniform(0, 1);
    }
    return sum;
}

/* 10^-k for a random k between 0 and `most`, without a logarithm. */
static double small(int most)
{
    double x = uniform(0.1, 1);
    for (int k = (int)uniform(0, most); k > 0; k--) {
        x /= 10;
    }
    return x;
}

/* ---- geometry in double -------------------------------------------------- */

static void rotation_of(double R[9], const double q[4])
{
    const double s = 2 / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        R[4 * i] = 1 - s * (q[1 + j] * q[1 + j] + q[1 + k] * q[1 + k]);
        R[3 * i + j] = s * (q[1 + i] * q[1 + j] - q[0] * q[1 + k]);
        R[3 * i + k] = s * (q[1 + i] * q[1 + k] + q[0] * q[1 + j]);
    }
}

static void random_rotation(double R[9])
{
    const double q[4] = {normal(), normal(), normal(), normal() + 1e-9};
    rotation_of(R, q);
}

/* Turns R by an angle whose half has the tangent `tangent`, about a random axis. */
static void turn_by(double R[9], double tangent)
{
    double v[3] = {normal(), normal(), normal() + 1e-9}, T[9], out[9];
    const double norm = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    const double q[4] = {norm, tangent * v[0], tangent * v[1], tangent * v[2]};
    rotation_of(T, q);
    for (int i = 0; i < 9; i++) {
        out[i] = 0;
        for (int k = 0; k < 3; k++) {
            out[i] += T[i / 3 * 3 + k] * R[3 * k + i % 3];
        }
    }
    memcpy(R, out, sizeof out);
}

static void move(double y[3], const double R[9], const double t[3], const double x[3])
{
    for (int i = 0; i < 3; i++) {
        y[i] = R[3 * i] * x[0] + R[3 * i + 1] * x[1] + R[3 * i + 2] * x[2] + t[i];
    }
}

static rigcal_transform transform_of(const double R[9], const double t[3])
{
    rigcal_transform T;
    for (int i = 0; i < 9; i++) {
        T.R[i] = RC(R[i]);
    }
    for (int i = 0; i < 3; i++) {
        T.t[i] = RC(t[i]);
    }
    return T;
}

static rigcal_transform identity(void)
{
    const double R[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, t[3] = {0, 0, 0};
    return transform_of(R, t);
}

/* The pixel by the formulas of rigcal.h. Returns 0 if the point is not in front. */
static int project(double uv[2], const rigcal_camera *c, const double X[3])
{
    const double k1 = (double)c->k1, k2 = (double)c->k2, k3 = (double)c->k3;
    const double p1 = (double)c->p1, p2 = (double)c->p2;
    double x = X[0] / X[2], y = X[1] / X[2];
    if (c->lens == RIGCAL_LENS_FISHEYE) {
        const double r = sqrt(X[0] * X[0] + X[1] * X[1]), theta = atan2(r, X[2]);
        const double s = theta * theta;
        const double d =
            theta * (1 + s * (k1 + s * (k2 + s * (k3 + s * (double)c->k4)))) / r;
        uv[0] = (double)c->fx * d * X[0] + (double)c->cx;
        uv[1] = (double)c->fy * d * X[1] + (double)c->cy;
        return r > 0;
    }
    const double s = x * x + y * y;
    const double d = (1 + s * (k1 + s * (k2 + s * k3))) /
                     (1 + s * ((double)c->k4 + s * ((double)c->k5 + s * (double)c->k6)));
    uv[0] = (double)c->fx * (x * d + 2 * p1 * x * y + p2 * (s + 2 * x * x)) + (double)c->cx;
    uv[1] = (double)c->fy * (y * d + p1 * (s + 2 * y * y) + 2 * p2 * x * y) + (double)c->cy;
    return X[2] > 0;
}

/* ---- scenes -------------------------------------------------------------- */

typedef enum { GENERAL, PLANAR, SQUARE, SLAB, NEEDLE, SHAPES } shape;
typedef enum { PINHOLE, BROWN, RATIONAL, FISHEYE, LENSES } lens;

static rigcal_camera camera_of(lens kind, double f)
{
    rigcal_camera c;
    memset(&c, 0, sizeof c);
    c.width = 640;
    c.height = 480;
    c.fx = c.fy = RC(f);
    c.cx = RC(319.5);
    c.cy = RC(239.5);
    if (kind == BROWN) {
        c.k1 = RC(-0.2);
        c.k2 = RC(0.05);
        c.p1 = RC(1e-3);
        c.p2 = RC(-5e-4);
    } else if (kind == RATIONAL) {
        c.k1 = RC(0.2);
        c.k4 = RC(0.3);
    } else if (kind == FISHEYE) {
        c.lens = RIGCAL_LENS_FISHEYE;
        c.k1 = RC(0.01);
        c.k2 = RC(-0.002);
    }
    return c;
}

typedef struct {
    int n;
    double X[POINTS_MAX][3], R[9], t[3], sigma_px;
    rigcal_camera camera;
    rigcal_observation o[POINTS_MAX];
    rigcal_real sigma[POINTS_MAX];
    int use_sigma;
    rigcal_pose_options options;
} scene;

static rigcal_view view_of(const scene *s)
{
    const rigcal_view view = {&s->camera, s->o, s->use_sigma ? s->sigma : NULL,
                              (size_t)s->n};
    return view;
}

static void point_of(double X[3], shape kind, int i)
{
    static const double CORNERS[4][2] = {
        {-0.5, 0.5}, {0.5, 0.5}, {0.5, -0.5}, {-0.5, -0.5}};
    const double thin[SHAPES] = {1, 0, 0, 0.2, 0.05};
    for (int k = 0; k < 3; k++) {
        X[k] = uniform(-0.5, 0.5);
    }
    X[2] *= thin[kind];
    if (kind == NEEDLE) {
        X[1] *= 0.05;
    }
    if (kind == SQUARE && i < 4) {
        X[0] = CORNERS[i][0];
        X[1] = CORNERS[i][1];
    }
}

/* The noisy pixels of the scene. Returns 0 if a point is behind the camera. */
static int observe(scene *s)
{
    for (int i = 0; i < s->n; i++) {
        double X_c[3], uv[2];
        move(X_c, s->R, s->t, s->X[i]);
        if (!project(uv, &s->camera, X_c)) {
            return 0;
        }
        s->sigma[i] = RC(uniform(0.5, 2));
        for (int k = 0; k < 3; k++) {
            s->o[i].X_w[k] = RC(s->X[i][k]);
        }
        for (int k = 0; k < 2; k++) {
            const double by = s->use_sigma ? (double)s->sigma[i] : 1;
            s->o[i].uv[k] = RC(uv[k] + s->sigma_px * by * normal());
        }
    }
    return 1;
}

/* n points before a camera, at a distance of `near` to `far` of their size. */
static void random_scene(scene *s, int n, shape kind, lens through, double sigma_px,
                         double near, double far)
{
    memset(s, 0, sizeof *s);
    s->camera = camera_of(through, 800);
    s->sigma_px = sigma_px;
    s->n = n;
    rigcal_pose_defaults(&s->options);
    do {
        const double z = uniform(near, far);
        random_rotation(s->R);
        s->t[0] = z * uniform(-0.25, 0.25);
        s->t[1] = z * uniform(-0.2, 0.2);
        s->t[2] = z;
        for (int i = 0; i < n; i++) {
            point_of(s->X[i], kind, i);
        }
    } while (!observe(s));
}

/* Points all round a camera with a short focal length, all far off its axis. */
static void scene_around(scene *s, int n, double sigma_px)
{
    memset(s, 0, sizeof *s);
    s->sigma_px = sigma_px;
    s->n = n;
    s->camera = camera_of(PINHOLE, 100);
    rigcal_pose_defaults(&s->options);
    random_rotation(s->R);
    for (int i = 0; i < n; i++) {
        double x = normal(), y = normal();
        const double z = uniform(0.03, 0.5), far = uniform(1, 3), r = sqrt(x * x + y * y);
        const double X_c[3] = {far * x / r - s->t[0], far * y / r - s->t[1],
                               far * z - s->t[2]};
        for (int k = 0; k < 3; k++) { /* X = R^T X_c */
            s->X[i][k] = s->R[k] * X_c[0] + s->R[3 + k] * X_c[1] + s->R[6 + k] * X_c[2];
        }
    }
    observe(s);
}

/* A target far off the axis of a camera with a short focal length. */
static void wide_scene(scene *s, int n, shape kind, lens through, double sigma_px)
{
    memset(s, 0, sizeof *s);
    s->sigma_px = sigma_px;
    s->n = n;
    rigcal_pose_defaults(&s->options);
    do {
        const double f = uniform(40, 400), z = uniform(0.03, 0.8), far = uniform(0.5, 4);
        const double x = uniform(-1, 1), across = sqrt(1 - z * z);
        s->camera = camera_of(through == BROWN ? PINHOLE : through, f);
        random_rotation(s->R);
        s->t[0] = far * across * x;
        s->t[1] = far * across * sqrt(1 - x * x) * (draw() % 2 ? 1 : -1);
        s->t[2] = far * z;
        for (int i = 0; i < n; i++) {
            point_of(s->X[i], kind, i);
        }
    } while (!observe(s));
}

static double rotation_error(const double R[9], const rigcal_real seen[9])
{
    double sum = 0;
    for (int i = 0; i < 9; i++) {
        sum += (R[i] - (double)seen[i]) * (R[i] - (double)seen[i]);
    }
    return sqrt(sum / 2);
}

/* Solves and judges a scene. It is a miss if the true pose is not among those found, and a
 * wrong OK if the first pose is wrong but said to be certain. */
enum { WRONG_TENTHS = 3 }; /* of a radian */

static rigcal_status solve(tally *t, const scene *s)
{
    rigcal_pose_solver solver;
    rigcal_pose poses[RIGCAL_POSES_MAX];
    size_t n_found = 0;
    int32_t at_fault;
    const rigcal_view view = view_of(s);
    rigcal_status status = rigcal_pose_begin(&solver, &at_fault, &view, &s->options);
    if (status == RIGCAL_OK) {
        do {
            t->steps++;
        } while (rigcal_pose_step(&solver, 1) == RIGCAL_RUNNING);
        status = rigcal_pose_result(poses, RIGCAL_POSES_MAX, &n_found, &at_fault, &solver);
    }
    int is_found = 0;
    for (size_t i = 0; i < n_found; i++) {
        const int is_right =
            rotation_error(s->R, poses[i].cam_from_world.R) < 0.1 * WRONG_TENTHS;
        is_found |= is_right;
        t->wrong_ok += i == 0 && !is_right && status == RIGCAL_OK;
    }
    t->misses += !is_found;
    t->found += (long)n_found;
    return count(t, status);
}

/* ---- poses --------------------------------------------------------------- */

static void gate_poses(void)
{
    static const char *const names[SHAPES] = {"pose.general", "pose.planar", "pose.square",
                                              "pose.slab", "pose.needle"};
    static const int sizes[] = {3, 4, 5, 8, 20};
    static const double noise[] = {0, 0.3, 1.5, 6};
    for (int kind = 0; kind < SHAPES; kind++) {
        tally t;
        begin(&t, names[kind]);
        state = 100 + (uint64_t)kind;
        for (int i = 0; i < 600; i++) {
            scene s;
            const int is_far = i % 7 == 3;
            random_scene(&s, sizes[i % 5], (shape)kind, (lens)(i / 5 % LENSES),
                         noise[i / 20 % 4], is_far ? 20 : 1.2, is_far ? 80 : 8);
            s.use_sigma = i % 4 == 1;
            s.options.sigma_px = i % 3 == 2 ? RC(0.5 + s.sigma_px) : 0;
            solve(&t, &s);
        }
        end(&t);
    }
}

static void gate_warm(void)
{
    tally t;
    begin(&t, "warm");
    state = 200;
    for (int i = 0; i < 600; i++) {
        scene s;
        double R[9], from[3];
        random_scene(&s, 4 + i % 9, (shape)(i % 3), (lens)(i / 3 % LENSES), 0.3, 1.5, 8);
        memcpy(R, s.R, sizeof R);
        turn_by(R, small(3));
        for (int k = 0; k < 3; k++) {
            from[k] = s.t[k] * uniform(0.6, 1.6);
        }
        s.options.use_start = 1;
        s.options.start = transform_of(R, from);
        solve(&t, &s);
    }
    end(&t);
}

static void gate_wide(void)
{
    static const char *const names[2] = {"wide.good", "wide.poor"};
    for (int is_poor = 0; is_poor < 2; is_poor++) {
        tally t;
        begin(&t, names[is_poor]);
        state = 300;
        for (int i = 0; i < 500; i++) {
            scene s;
            if (i % 5 == 4) {
                scene_around(&s, 4 + i % 7, 0.5);
            } else {
                wide_scene(&s, 4 + i % 6, (shape)(i / 6 % SHAPES), (lens)(i % LENSES), 0.5);
            }
            if (is_poor) {
                s.o[i % s.n].uv[0] += RC(40);
            }
            solve(&t, &s);
        }
        end(&t);
    }
}

/* Points whose handedness was mistaken, and similar targets. */
static void gate_mirrored(void)
{
    tally t;
    begin(&t, "mirrored");
    state = 400;
    for (int i = 0; i < 400; i++) {
        scene s;
        random_scene(&s, 5 + i % 8, i % 2 ? GENERAL : SLAB, PINHOLE, 0.2 * small(2), 1.5,
                     30);
        for (int k = 0; k < s.n && i % 4 < 3; k++) {
            s.o[k].X_w[2] = -s.o[k].X_w[2];
        }
        solve(&t, &s);
    }
    end(&t);
}

/* ---- where a pose gets a caveat ------------------------------------------- */

static scene probed;
static double shifts[POINTS_MAX][2];
static rigcal_status wanted;

static void draw_shifts(void)
{
    for (int i = 0; i < POINTS_MAX; i++) {
        shifts[i][0] = normal();
        shifts[i][1] = normal();
    }
}

static rigcal_status solve_probed(const scene *s)
{
    tally t;
    memset(&t, 0, sizeof t);
    return solve(&t, s);
}

/* Whether the status is still `wanted` with this noise of `probed`, in pixels. */
static int noise_is_below(double noise_px)
{
    scene s = probed;
    for (int i = 0; i < s.n; i++) {
        for (int k = 0; k < 2; k++) {
            s.o[i].uv[k] += RC(noise_px * shifts[i][k]);
        }
    }
    return solve_probed(&s) != wanted;
}

static int warm_is_kept(double noise_px)
{
    scene s = probed;
    tally t;
    memset(&t, 0, sizeof t);
    for (int i = 0; i < s.n; i++) {
        for (int k = 0; k < 2; k++) {
            s.o[i].uv[k] += RC(noise_px * shifts[i][k]);
        }
    }
    solve(&t, &s);
    return t.steps < 12; /* a search would take more steps */
}

static int distance_is_clear(double z)
{
    scene s = probed;
    s.t[2] = z;
    state = 7;
    observe(&s);
    return solve_probed(&s) != RIGCAL_VAGUE;
}

static void gate_caveats(void)
{
    state = 500;
    draw_shifts();
    random_scene(&probed, 12, GENERAL, PINHOLE, 0, 4, 4.1);
    wanted = RIGCAL_POOR_FIT;
    edge("poor.noise_px", noise_is_below, 0.01, 100);
    probed.options.sigma_px = 1;
    edge("poor.of_stated", noise_is_below, 0.01, 100);
    random_scene(&probed, 12, GENERAL, PINHOLE, 0, 1.6, 1.7);
    edge("poor.coarse_px", noise_is_below, 0.01, 20);
    random_scene(&probed, 12, GENERAL, PINHOLE, 0, 12, 12.1);
    probed.camera = camera_of(PINHOLE, 1);
    probed.camera.cx = probed.camera.cy = 0;
    observe(&probed);
    edge("poor.normalised", noise_is_below, 1e-6, 0.02);

    random_scene(&probed, 12, GENERAL, PINHOLE, 0, 12, 12.1);
    probed.options.use_start = 1;
    probed.options.start = transform_of(probed.R, probed.t);
    edge("warm.noise_px", warm_is_kept, 0.01, 100);

    random_scene(&probed, 6, GENERAL, PINHOLE, 0, 5, 5.1);
    probed.t[0] = probed.t[1] = 0;
    edge("vague.exact", distance_is_clear, 4, 1e5);
    probed.options.sigma_px = 2;
    edge("vague.stated", distance_is_clear, 4, 1e5);
}

/* ---- robust, diagnose, tag ------------------------------------------------ */

static void gate_robust(void)
{
    tally t;
    begin(&t, "robust");
    state = 600;
    for (int i = 0; i < 200; i++) {
        scene s;
        rigcal_robust_options o;
        static rigcal_robust_solver solver;
        rigcal_pose poses[RIGCAL_POSES_MAX];
        uint8_t inliers[POINTS_MAX];
        size_t n_found = 0, n_in = 0;
        int32_t at_fault;
        random_scene(&s, 5 + i % 50, (shape)(i % 2), i % 10 == 9 ? BROWN : PINHOLE, 0.5, 2,
                     6);
        s.use_sigma = i % 6 == 5;
        for (int k = 0; k < s.n; k++) {
            if (uniform(0, 1) < 0.12 * (i % 8)) {
                s.o[k].uv[0] = RC(uniform(0, 640));
                s.o[k].uv[1] = RC(uniform(0, 480));
            }
        }
        rigcal_robust_defaults(&o);
        o.sigma_px = i % 3 == 1 ? RC(0.5) : 0;
        const rigcal_view view = view_of(&s);
        rigcal_status status = rigcal_robust_begin(&solver, inliers, &at_fault, &view, &o);
        while (status >= 0 && rigcal_robust_step(&solver, 1) == RIGCAL_RUNNING) {
            t.steps++;
        }
        if (status >= 0) {
            status =
                rigcal_robust_result(poses, RIGCAL_POSES_MAX, &n_found, &n_in, &solver);
        }
        const int is_right =
            status >= 0 && rotation_error(s.R, poses[0].cam_from_world.R) < 0.3;
        t.misses += !is_right;
        t.wrong_ok += status == RIGCAL_OK && !is_right;
        t.found += (long)n_in;
        count(&t, status);
    }
    end(&t);
}

/* Whether a point that is off by this many pixels still agrees: the threshold. */
static int agrees(double off_px)
{
    scene s = probed;
    rigcal_pose pose;
    uint8_t inliers[POINTS_MAX];
    size_t n_found, n_in = 0;
    int32_t at_fault;
    rigcal_robust_options o;
    rigcal_robust_defaults(&o);
    o.sigma_px = s.options.sigma_px;
    s.o[0].uv[0] += RC(off_px);
    const rigcal_view view = view_of(&s);
    rigcal_robust_solve(&pose, 1, &n_found, inliers, &n_in, &at_fault, &view, &o);
    return n_in == (size_t)s.n;
}

static int samples_are_taken(double samples)
{
    rigcal_pose pose;
    uint8_t inliers[POINTS_MAX];
    size_t n_found, n_in;
    int32_t at_fault;
    rigcal_robust_options o;
    rigcal_robust_defaults(&o);
    o.samples = (int32_t)samples;
    const rigcal_view view = view_of(&probed);
    return rigcal_robust_solve(&pose, 1, &n_found, inliers, &n_in, &at_fault, &view, &o) !=
           RIGCAL_ERR_RANGE;
}

/* Seven points agree, three do not. Whether the seven may be off by this much before chance
 * explains them. */
static int chance_is_below(double off_px)
{
    scene s = probed;
    rigcal_pose pose;
    uint8_t inliers[POINTS_MAX];
    size_t n_found, n_in;
    int32_t at_fault;
    rigcal_robust_options o;
    rigcal_robust_defaults(&o);
    o.threshold_px = 100;
    for (int i = 3; i < s.n; i++) {
        s.o[i].uv[0] += RC(i % 2 == 0 ? off_px : -off_px);
        s.o[i].uv[1] += RC(i % 4 < 2 ? off_px : -off_px);
    }
    const rigcal_view view = view_of(&s);
    const rigcal_status status =
        rigcal_robust_solve(&pose, 1, &n_found, inliers, &n_in, &at_fault, &view, &o);
    return status != RIGCAL_ERR_NO_CONSENSUS && (wanted == 0 || status != RIGCAL_FEW_AGREE);
}

/* Counts what a search with default options spends if no points agree. */
static void search_of_nothing(const char *name)
{
    static rigcal_robust_solver solver;
    uint8_t inliers[POINTS_MAX];
    int32_t at_fault;
    rigcal_robust_options o;
    long steps = 0;
    const rigcal_view view = view_of(&probed);
    rigcal_robust_defaults(&o);
    if (rigcal_robust_begin(&solver, inliers, &at_fault, &view, &o) < 0) {
        return;
    }
    while (rigcal_robust_step(&solver, 1) == RIGCAL_RUNNING) {
        steps++;
    }
    line(name, "%d of %d, %ld units", (int)solver.tried, (int)solver.samples, steps);
}

/* Six of twenty points are right. The others lie among them, so a rival may be nearly as
 * good. */
static void gate_rivals(void)
{
    tally t;
    begin(&t, "rivals");
    state = 630;
    for (int i = 0; i < 300; i++) {
        scene s;
        rigcal_pose pose;
        uint8_t inliers[POINTS_MAX];
        size_t n_found, n_in;
        double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9};
        random_scene(&s, 20, GENERAL, PINHOLE, 1, 3, 6);
        for (int k = 0; k < 2 * s.n; k++) {
            const double u = (double)s.o[k / 2].uv[k % 2];
            low[k % 2] = u < low[k % 2] ? u : low[k % 2];
            high[k % 2] = u > high[k % 2] ? u : high[k % 2];
        }
        for (int k = 0; k < 2 * 14; k++) {
            s.o[k / 2].uv[k % 2] = RC(uniform(low[k % 2], high[k % 2]));
        }
        const rigcal_view view = view_of(&s);
        const rigcal_status status =
            rigcal_robust_solve(&pose, 1, &n_found, inliers, &n_in, NULL, &view, NULL);
        const int is_right =
            status >= 0 && rotation_error(s.R, pose.cam_from_world.R) < 0.3;
        t.misses += !is_right;
        t.wrong_ok += !is_right && (status == RIGCAL_OK || status == RIGCAL_MOST_DISAGREE);
        count(&t, status);
    }
    end(&t);
}

static void gate_robust_edges(void)
{
    state = 620;
    random_scene(&probed, 10, GENERAL, PINHOLE, 0, 3, 3.1);
    for (int i = 0; i < 3; i++) {
        probed.o[i].uv[i % 2] += RC(i == 1 ? -400 : 400);
    }
    wanted = RIGCAL_FEW_AGREE;
    edge("robust.few_px", chance_is_below, 1e-3, 100);
    wanted = 0;
    edge("robust.none_px", chance_is_below, 1e-3, 100);
    for (int n = 3; n <= 11; n++) {
        char name[32];
        rigcal_pose pose;
        uint8_t inliers[POINTS_MAX];
        size_t n_found, n_in;
        int32_t at_fault;
        random_scene(&probed, n, GENERAL, PINHOLE, 0.2, 2, 2.1);
        const rigcal_view view = view_of(&probed);
        snprintf(name, sizeof name, "robust.of_%d_points", n);
        line(name, "%d",
             (int)rigcal_robust_solve(&pose, 1, &n_found, inliers, &n_in, &at_fault, &view,
                                      NULL));
    }
    state = 610;
    random_scene(&probed, 30, GENERAL, PINHOLE, 0, 4, 4.1);
    edge("robust.threshold_px", agrees, 0.1, 100);
    probed.options.sigma_px = RC(0.1);
    edge("robust.threshold_sigmas", agrees, 0.01, 100);
    edge("robust.samples_max", samples_are_taken, 1, 1e9);
    random_scene(&probed, 120, GENERAL, PINHOLE, 0.5, 4, 4.1);
    state = 630;
    for (int i = 0; i < probed.n; i++) {
        probed.o[i].uv[0] = RC(uniform(0, 640));
        probed.o[i].uv[1] = RC(uniform(0, 480));
    }
    search_of_nothing("robust.drawn");
    probed.n = 25;
    search_of_nothing("robust.all");
    rigcal_robust_options o;
    rigcal_robust_defaults(&o);
    line("robust.max_units", "%d", (int)o.max_units);
}

static void gate_diagnose(void)
{
    tally t;
    char name[32];
    long verdicts[3] = {0, 0, 0}, kinds[8] = {0}, handed = 0, units = 0;
    begin(&t, "diagnose");
    state = 700;
    for (int i = 0; i < 300; i++) {
        scene s;
        rigcal_diagnosis d;
        rigcal_real rms[POINTS_MAX];
        random_scene(&s, i % 40 == 39 ? 40 : 5 + i % 6, (shape)(i % 4), PINHOLE, 0.3, 1.5,
                     8);
        if (i % 3 != 0) {
            s.o[i % s.n].uv[0] += RC(40 * small(3));
        }
        for (int k = 0; k < s.n && i % 5 == 2; k++) {
            s.o[k].X_w[2] = -s.o[k].X_w[2];
        }
        for (int k = 0; k < s.n && i % 15 == 3; k++) {
            s.o[k].uv[1] = RC(479) - s.o[k].uv[1];
        }
        s.options.sigma_px = i % 2 ? RC(0.3) : 0;
        if (i % 4 == 1) {
            const double factor = uniform(0.8, 1.25) * (i % 8 == 1 ? 25.4 : 0.01);
            const double from[3] = {factor * s.t[0], factor * s.t[1], factor * s.t[2]};
            s.options.use_start = 1;
            s.options.start = transform_of(s.R, from);
        }
        const rigcal_view view = view_of(&s);
        if (count(&t, rigcal_pose_diagnose(&d, rms, &view, &s.options)) >= 0) {
            verdicts[d.blame.verdict]++;
            kinds[d.verdict]++;
            handed += d.is_handed;
            units += d.units > 0;
            t.found += d.blame.point == i % s.n;
        }
    }
    end(&t);
    for (int k = 0; k < 8; k++) {
        if (kinds[k] > 0) {
            snprintf(name, sizeof name, "diagnose.verdict_%d", k);
            line(name, "%ld", kinds[k]);
        }
    }
    for (int k = 0; k < 3; k++) {
        snprintf(name, sizeof name, "diagnose.blame_%d", k);
        line(name, "%ld", verdicts[k]);
    }
    line("diagnose.handed", "%ld", handed);
    line("diagnose.units", "%ld", units);
}

/* Whether a point that is off by `off_px` gets at most the blame `wanted`. */
static int blame_is_below(double off_px)
{
    scene s = probed;
    rigcal_blame blame;
    s.o[2].uv[0] += RC(off_px);
    const rigcal_view view = view_of(&s);
    return rigcal_pose_blame(&blame, NULL, &view, &s.options) < 0 || blame.verdict < wanted;
}

static int units_are_near(double ratio)
{
    scene s = probed;
    rigcal_diagnosis d;
    const double from[3] = {0.01 * ratio * s.t[0], 0.01 * ratio * s.t[1],
                            0.01 * ratio * s.t[2]};
    s.options.use_start = 1;
    s.options.start = transform_of(s.R, from);
    const rigcal_view view = view_of(&s);
    return rigcal_pose_diagnose(&d, NULL, &view, &s.options) == RIGCAL_OK && d.units > 0;
}

static void gate_blame_edges(void)
{
    state = 710;
    random_scene(&probed, 10, GENERAL, PINHOLE, 0.3, 4, 4.1);
    probed.options.sigma_px = RC(0.3);
    wanted = RIGCAL_BLAME_SURE;
    edge("blame.sure_px", blame_is_below, 0.1, 100);
    wanted = RIGCAL_BLAME_LIKELY;
    edge("blame.likely_px", blame_is_below, 0.1, 100);
    random_scene(&probed, 150, GENERAL, PINHOLE, 0.02, 4, 4.1);
    probed.options.sigma_px = RC(0.3);
    wanted = RIGCAL_BLAME_SURE;
    edge("blame.of_many_px", blame_is_below, 0.1, 100);
    random_scene(&probed, 5, GENERAL, PINHOLE, 0.05, 3, 3.1);
    probed.options.sigma_px = RC(0.3);
    wanted = RIGCAL_BLAME_SURE;
    edge("blame.of_five_px", blame_is_below, 0.1, 1000);
    edge("diagnose.units_near", units_are_near, 1, 3);
    for (int n = 2; n <= 11; n++) {
        char name[32];
        rigcal_blame blame;
        random_scene(&probed, n < 3 ? 3 : n, GENERAL, PINHOLE, 0.2, 2, 2.1);
        const rigcal_view view = view_of(&probed);
        snprintf(name, sizeof name, "blame.of_%d_points", n);
        line(name, "%d", (int)rigcal_pose_blame(&blame, NULL, &view, NULL));
    }
}

static void gate_tags(const char *name, double far, double sigma_px, int is_edge_on)
{
    tally t;
    begin(&t, name);
    state = 800;
    for (int i = 0; i < 1000; i++) {
        scene s;
        rigcal_real uv[8];
        rigcal_pose poses[RIGCAL_POSES_MAX];
        size_t n_found = 0;
        int32_t at_fault;
        random_scene(&s, 4, SQUARE, (lens)(i / 2 % 2), sigma_px, 0.03 * far, far);
        if (is_edge_on) {
            const double q[4] = {1, 1 + 0.1 * normal(), 0, 0};
            rotation_of(s.R, q);
            observe(&s);
        }
        for (int k = 0; k < 4; k++) {
            uv[2 * k] = s.o[k].uv[0];
            uv[2 * k + 1] = s.o[k].uv[1];
        }
        const rigcal_status status =
            count(&t, rigcal_tag_solve(poses, RIGCAL_POSES_MAX, &n_found, &at_fault,
                                       &s.camera, uv, 1, NULL));
        const int is_right =
            status >= 0 && rotation_error(s.R, poses[0].cam_from_world.R) < 0.3;
        t.wrong_ok += status == RIGCAL_OK && !is_right;
        t.misses += !is_right;
        t.found += (long)n_found;
    }
    end(&t);
}

/* ---- triangulation, depth ------------------------------------------------- */

static void gate_triangulate(void)
{
    tally t;
    begin(&t, "triangulate");
    state = 900;
    for (int i = 0; i < 1000; i++) {
        enum { VIEWS = 5 };
        const int n = 2 + i % (VIEWS - 1);
        rigcal_camera cameras[VIEWS];
        rigcal_transform T[VIEWS];
        rigcal_real uv[2 * VIEWS];
        rigcal_point point;
        const double X[3] = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
        const double apart = 2 * small(3), noise = i % 3 == 0 ? 0 : 3 * small(3);
        for (int k = 0; k < n;) {
            const double q[4] = {1, uniform(-0.1, 0.1), uniform(-0.1, 0.1), uniform(-1, 1)};
            const double off[3] = {apart * uniform(-1, 1), apart * uniform(-1, 1),
                                   uniform(1.5, 8)};
            double R[9], X_c[3], pixel[2];
            rotation_of(R, q);
            cameras[k] = camera_of((lens)((i + k) / 3 % LENSES), 800);
            T[k] = transform_of(R, off);
            move(X_c, R, off, X);
            if (project(pixel, &cameras[k], X_c)) {
                uv[2 * k] = RC(pixel[0] + noise * normal());
                uv[2 * k + 1] = RC(pixel[1] + noise * normal());
                k++;
            }
        }
        const rigcal_status status =
            count(&t, rigcal_point_triangulate(&point, cameras, T, uv, (size_t)n, RC(0.5)));
        if (status >= 0) {
            const double dx = (double)point.X[0] - X[0], dz = (double)point.X[2] - X[2];
            t.misses += dx * dx + dz * dz > 0.01;
        }
    }
    end(&t);
}

enum { EYES = 20 };

/* The cameras of a calibrated rig about the origin, the first held, and what they see. */
static struct {
    rigcal_mounted_camera cameras[EYES];
    int32_t group[EYES];
    uint8_t held[EYES];
    rigcal_real Sigma[RIGCAL_CALIBRATED_SIZE(EYES)], noise[EYES];
    rigcal_real work[RIGCAL_POINT_WORK(EYES)];
    rigcal_calibrated_rig rig;
    rigcal_sighting seen[EYES];
    rigcal_sightings s;
} eyes;

static void eyes_begin(int n)
{
    memset(&eyes, 0, sizeof eyes);
    eyes.rig.cameras = eyes.cameras;
    eyes.rig.group = eyes.group;
    eyes.rig.held = eyes.held;
    eyes.rig.Sigma = eyes.Sigma;
    eyes.rig.n_cameras = eyes.rig.capacity = EYES;
    eyes.rig.Sigma_capacity = RIGCAL_CALIBRATED_SIZE(EYES);
    eyes.rig.sigma_px = RC(0.3);
    eyes.held[0] = 1;
    for (size_t i = 0; i < 6 * (EYES - 1); i++) {
        eyes.Sigma[i * (i + 1) / 2 + i] = RC(i % 6 < 3 ? 1e-7 : 2e-6);
    }
    eyes.s.rig = &eyes.rig;
    eyes.s.seen = eyes.seen;
    eyes.s.n = (size_t)n;
    eyes.s.work = eyes.work;
    eyes.s.work_capacity = RIGCAL_POINT_WORK(EYES);
}

/* Camera i sees the point X from a distance of 4. `lenses` says how many cameras have a
 * lens. */
static void eyes_see(int i, double along_arc, int lenses, const double X[3])
{
    const double q[4] = {1, 0, along_arc, 0}, t[3] = {0, 0, 4};
    double R[9], X_c[3], pixel[2];
    rotation_of(R, q);
    eyes.cameras[i].camera = camera_of((lens)(i % lenses), 800);
    eyes.cameras[i].cam_from_rig = transform_of(R, t);
    eyes.seen[i].camera = i;
    move(X_c, R, t, X);
    (void)project(pixel, &eyes.cameras[i].camera, X_c);
    eyes.seen[i].uv[0] = RC(pixel[0]);
    eyes.seen[i].uv[1] = RC(pixel[1]);
}

static void gate_points(void)
{
    tally t;
    begin(&t, "point");
    state = 1700;
    for (int i = 0; i < 400; i++) {
        const int n = 2 + i % (EYES - 1), wrong = (i / 4) % 3;
        const double X[3] = {uniform(-0.3, 0.3), uniform(-0.3, 0.3), uniform(-0.3, 0.3)};
        rigcal_point_solver solver;
        rigcal_measured_point point;
        uint8_t used[EYES];
        memset(&point, 0, sizeof point);
        eyes_begin(n);
        for (int k = 0; k < n; k++) {
            const double off = k < wrong ? 30 * small(2) : 0.3 * normal();
            eyes_see(k, 0.4 * (k + uniform(-0.2, 0.2)) / n - 0.2, LENSES, X);
            eyes.seen[k].uv[0] += RC(off);
            eyes.seen[k].uv[1] += RC(0.3 * normal());
        }
        if (rigcal_point_begin(&solver, &eyes.s) == RIGCAL_OK) {
            while (rigcal_point_step(&solver, 1) == RIGCAL_RUNNING) {
                t.steps++;
            }
        }
        if (count(&t, rigcal_point_result(&point, used, &solver)) >= 0) {
            for (int k = 0; k < n; k++) {
                t.found += used[k] * (k + 1);
            }
            t.misses += fabs((double)point.X[0] - X[0]) > 3 * sqrt((double)point.Sigma[0]);
        }
    }
    end(&t);
}

/* Two or three views, of which the last is off across its matching line by this many
 * pixels: the status says whether they show one point, and whether none is dropped. */
static rigcal_status measure_off(int n, int keep_all, double px)
{
    static const double X[3] = {0.1, 0.05, 0.1};
    rigcal_measured_point point;
    memset(&point, 0, sizeof point);
    eyes_begin(n);
    for (int k = 0; k < n; k++) {
        eyes_see(k, 0.2 * k - 0.2, 1, X);
    }
    eyes.seen[n - 1].uv[1] += RC(px);
    eyes.s.keep_all = keep_all;
    return rigcal_point_measure(&point, NULL, &eyes.s);
}

static int two_fit(double px)
{
    return measure_off(2, 1, px) == RIGCAL_OK;
}

static int five_are_kept(double px)
{
    return measure_off(5, 0, px) != RIGCAL_VIEWS_LEFT_OUT;
}

/* One view is this far from the point of the others, through a lens that folds: whether it
 * is refused. */
static int sight_is_proved(double off)
{
    static const double X[3] = {0, 0, 0};
    rc_sighted v;
    rigcal_real there[3] = {0, 0, 0};
    eyes_begin(2);
    eyes_see(0, 0, 1, X);
    eyes.cameras[0].camera.k1 = RC(-0.4);
    eyes.seen[0].uv[0] = eyes.cameras[0].camera.cx + RC(800 * 0.6085);
    memset(&v, 0, sizeof v);
    (void)rc_sight_check(&v, &eyes.s, 0);
    there[0] = RC(4 * (0.913 + off));
    (void)rc_sight_evaluate(&v, &eyes.s, 0, there);
    return rc_sight_move(&v, &eyes.s, 0, there) == RIGCAL_OK;
}

/* The largest errors of rays of a mild lens. */
static void gate_sights(void)
{
    static const double X[3] = {0, 0, 0};
    double most = 0;
    edge("point.chi2_px", two_fit, 0.1, 5);
    edge("point.agrees_px", five_are_kept, 0.1, 5);
    edge("point.proof", sight_is_proved, 1e-4, 0.2);
    for (int i = 0; i < 200; i++) {
        rc_sighted v;
        rigcal_real ray[3];
        double aside = 0;
        eyes_begin(2);
        eyes_see(0, 0, 1, X);
        eyes.cameras[0].camera.k1 = RC(-0.3);
        eyes.seen[0].uv[0] += RC(2 * i);
        memset(&v, 0, sizeof v);
        (void)rc_sight_check(&v, &eyes.s, 0);
        (void)rc_pixel_to_ray(ray, &eyes.cameras[0].camera, eyes.seen[0].uv);
        for (int k = 0; k < 3; k++) {
            aside += pow((double)v.ray[k] - (double)ray[k], 2);
        }
        most = fmax(most, aside);
    }
    line("point.ray", "%.1g", sqrt(most));
}

/* Whether the depths are known of rays from (0, 0, 0) and (1, 0, 0) that meet at the
 * distance `range`. */
static int depths_are_known(double range)
{
    const rigcal_real a[3] = {0, 0, 1}, b[3] = {RC(-1 / range), 0, 1};
    rigcal_transform T = identity();
    rigcal_real depth[2], miss;
    T.t[0] = RC(-1);
    return rigcal_depth_two_views(depth, &miss, &T, a, b) == RIGCAL_OK;
}

static int point_is_known(double range)
{
    const rigcal_camera c[2] = {camera_of(PINHOLE, 800), camera_of(PINHOLE, 800)};
    rigcal_transform T[2] = {identity(), identity()};
    rigcal_point point;
    T[1].t[0] = RC(-1);
    const rigcal_real uv[4] = {c[0].cx, c[0].cy, RC((double)c[0].cx - 800 / range),
                               c[0].cy};
    return rigcal_point_triangulate(&point, c, T, uv, 2, 1) == RIGCAL_OK;
}

static int disparity_is_none(double disparity)
{
    const rigcal_real left[2] = {1, 0}, right[2] = {RC(1) - RC(disparity), 0};
    rigcal_real X[3];
    return rigcal_depth_aligned(X, RC(1e-6), left, right) == RIGCAL_ERR_PARALLEL;
}

/* Whether the pixels of two views fix a depth that they hardly show. `flat` is the focal
 * length along x. */
static int pixels_fix_depth(double flat)
{
    rigcal_camera c[2] = {camera_of(PINHOLE, 800), camera_of(PINHOLE, 800)};
    rigcal_transform T[2] = {identity(), identity()};
    rigcal_point point;
    rigcal_real uv[4];
    for (int k = 0; k < 2; k++) {
        c[k].fx = RC(800 * flat);
        uv[2 * k] = k == 0 ? c[0].cx : c[1].cx - c[1].fx / 4;
        uv[2 * k + 1] = c[k].cy;
    }
    T[1].t[0] = RC(-1);
    return rigcal_point_triangulate(&point, c, T, uv, 2, 1) != RIGCAL_OK;
}

static void gate_depth_edges(void)
{
    edge("depth.range", depths_are_known, 2, 1e7);
    edge("triangulate.range", point_is_known, 2, 1e7);
    edge("depth.disparity", disparity_is_none, ANY_OF(1e-18, 1e-9), 0.1);
    edge("triangulate.rank", pixels_fix_depth, ANY_OF(1.3e-9, 1.3e-9), 1);
}

/* ---- matching lines ------------------------------------------------------- */

static int line_is_unit(double more)
{
    const rigcal_real px[3] = {RC(sqrt(1 + more)), 0, RC(-5)};
    rigcal_real ends[4];
    return rigcal_epiline_clip(ends, px, 100, 100) != RIGCAL_ERR_RANGE;
}

static int is_epipole(double off)
{
    const rigcal_real ray[3] = {RC(off), 0, 1};
    rigcal_transform T = identity();
    rigcal_real found[3];
    T.t[2] = 1;
    return rigcal_epiline(found, &T, ray) == RIGCAL_ERR_EPIPOLE;
}

static int segment_is_behind(double z)
{
    const rigcal_real ray[3] = {1, 0, RC(z)};
    const rigcal_camera camera = camera_of(PINHOLE, 800);
    const rigcal_transform T = identity();
    rigcal_real ends[4];
    return rigcal_epiline_segment(ends, &camera, &T, ray, 1, 2) == RIGCAL_ERR_WIDE_RAY;
}

static void gate_epilines(void)
{
    tally t;
    begin(&t, "epiline");
    state = 1000;
    for (int i = 0; i < 1000; i++) {
        double R[9];
        const double off[3] = {normal(), normal(), normal() * small(3)};
        const rigcal_real ray[3] = {RC(normal()), RC(normal()), RC(1 + small(2))};
        const rigcal_camera camera = camera_of((lens)(i % LENSES), 300);
        rigcal_real px[3], ends[4], curve[40];
        size_t n = 0;
        random_rotation(R);
        const rigcal_transform T = transform_of(R, off);
        if (count(&t, rigcal_epiline_px(px, &camera, &T, ray)) == RIGCAL_OK) {
            count(&t, rigcal_epiline_clip(ends, px, 640, 480));
            count(&t, rigcal_epiline_segment(ends, &camera, &T, ray, RC(0.5), 10));
            count(&t, rigcal_epiline_curve(curve, 20, &n, &camera, &T, ray, RC(0.5), 10));
            t.found += (long)n;
        }
    }
    end(&t);
    edge("epiline.unit", line_is_unit, 1e-12, 1);
    edge("epiline.epipole", is_epipole, ANY_OF(1e-18, 1e-10), 0.1);
    edge("epiline.behind", segment_is_behind, ANY_OF(1e-20, 1e-12), 0.5);
}

/* ---- rotations and rigs --------------------------------------------------- */

static int is_rotation(double off)
{
    rigcal_transform T = identity();
    rigcal_real w[3];
    T.R[1] = RC(off);
    return rigcal_vector_from_rotation(w, T.R) == RIGCAL_OK;
}

static int is_gimbal_lock(double cosine)
{
    const rigcal_real c = RC(cosine);
    const rigcal_real R[9] = {
        c / 2, RC(-0.5), RC(0.8660254037844386), 0, RC(0.8660254037844386), RC(0.5), RC(-1),
        0,     c};
    rigcal_real ypr[3];
    rc_yaw_pitch_roll_from_rotation(ypr, R);
    return !(RC_FABS(ypr[2]) > 0);
}

static int is_singular(double least)
{
    const rigcal_real M[9] = {1, 0, 0, 0, 1, 0, 0, 0, RC(least)};
    rigcal_real R[9];
    return rigcal_rotation_nearest(R, M) != RIGCAL_OK;
}

static int angle_is_taken(double angle)
{
    const rigcal_real ypr[3] = {RC(angle), 0, 0};
    rigcal_real R[9];
    return rigcal_rotation_from_yaw_pitch_roll(R, ypr) == RIGCAL_OK;
}

static void gate_rotations(void)
{
    tally t;
    begin(&t, "rotation");
    state = 1100;
    for (int i = 0; i < 500; i++) {
        rigcal_real M[9], R[9];
        const double scale = small(ANY_OF(14, 5));
        double Q[9];
        random_rotation(Q);
        for (int k = 0; k < 9; k++) {
            M[k] = RC(Q[k] * (k < 3 ? 1 : scale) + 0.2 * scale * normal());
        }
        count(&t, rigcal_rotation_nearest(R, M));
    }
    end(&t);
    begin(&t, "mean");
    for (int i = 0; i < 300; i++) {
        enum { MOST = 6 };
        rigcal_transform list[MOST], mean;
        rigcal_real weight[MOST], sigma[2];
        double Q[9];
        const double t0[3] = {1, 2, 3}, spread = 2 * small(4);
        random_rotation(Q);
        for (int k = 0; k < MOST; k++) {
            double R[9];
            memcpy(R, Q, sizeof R);
            turn_by(R, spread * uniform(0, 1));
            list[k] = transform_of(R, t0);
            weight[k] = RC(uniform(0, 1));
        }
        count(&t, rigcal_transform_mean(&mean, &sigma[0], &sigma[1], list, weight,
                                        (size_t)(2 + i % (MOST - 1))));
    }
    end(&t);
    edge("rotation.off", is_rotation, 1e-12, 0.5);
    edge("rotation.gimbal", is_gimbal_lock, ANY_OF(1e-20, 1e-12), 0.1);
    edge("rotation.singular", is_singular, ANY_OF(1e-20, 1e-12), 0.1);
    edge("rotation.angle", angle_is_taken, 1, 1e12);
}

/* A rig before a target in several placements. One camera does not see some of them. */
enum { RIG_CAMERAS = 4, RIG_PLACEMENTS = 6, RIG_VIEWS = RIG_CAMERAS * RIG_PLACEMENTS };

typedef struct {
    scene seen[RIG_VIEWS];
    rigcal_rig_view views[RIG_VIEWS];
    rigcal_view_pose own[RIG_VIEWS];
    rigcal_transform cams[RIG_CAMERAS], placements[RIG_PLACEMENTS];
    int32_t group[RIG_CAMERAS];
    rigcal_real work[RIGCAL_JUDGE_WORK(RIG_CAMERAS, RIG_PLACEMENTS)];
    rigcal_rig rig;
    rigcal_choice choice;
    rigcal_judged_view judged[RIG_VIEWS];
    uint8_t takes[RIG_VIEWS], left_out[RIG_VIEWS];
    rigcal_judgement judgement;
} rig_scene;

static rig_scene rig_probed;

static void rig_begin(rig_scene *r, size_t n_cameras)
{
    memset(&r->rig, 0, sizeof r->rig);
    r->rig.cams_from_rig = r->cams;
    r->rig.n_cameras = n_cameras;
    r->rig.rig_from_placements = r->placements;
    r->rig.n_placements = RIG_PLACEMENTS;
    r->rig.group = r->group;
    r->rig.views = r->views;
    r->rig.view_poses = r->own;
    r->rig.work = r->work;
    r->rig.work_capacity = sizeof r->work / sizeof r->work[0];
}

/* Adds a view: camera c sees placement f, with R and t, from `aside` to the side. */
static rigcal_status rig_add(rig_scene *r, int c, int f, const scene *placed)
{
    static const double TANGENT[RIG_CAMERAS] = {0, 0.1, -0.15, 0.2};
    const double q[4] = {1, 0, TANGENT[c], 0}, shift[3] = {-0.5 * c, 0.1 * c, 0.2 * c};
    const size_t k = r->rig.n_views;
    double R[9];
    rigcal_pose pose;
    size_t n_found;
    scene *const s = &r->seen[k];
    *s = *placed;
    rotation_of(R, q);
    for (int i = 0; i < 9; i++) {
        s->R[i] = 0;
        for (int m = 0; m < 3; m++) {
            s->R[i] += R[i / 3 * 3 + m] * placed->R[3 * m + i % 3];
        }
    }
    move(s->t, R, shift, placed->t);
    if (!observe(s)) {
        return RIGCAL_ERR_BEHIND;
    }
    const rigcal_rig_view v = {view_of(s), c, f, 0};
    s->options.use_start = 1;
    s->options.start = transform_of(s->R, s->t);
    const rigcal_status status =
        rigcal_pose_solve(&pose, 1, &n_found, NULL, &v.view, &s->options);
    if (status < 0) {
        return status;
    }
    r->views[k] = v;
    r->rig.n_views++;
    return rigcal_view_pose_make(&r->own[k], &r->views[k], &pose.cam_from_world);
}

static void random_rig(rig_scene *r, int n_cameras, double share, double sigma_px)
{
    rig_begin(r, (size_t)n_cameras);
    for (int f = 0; f < RIG_PLACEMENTS; f++) {
        scene placed;
        random_scene(&placed, 5 + f % 3, PLANAR, BROWN, sigma_px, 5, 8);
        for (int c = 0; c < n_cameras; c++) {
            if (uniform(0, 1) < share) {
                (void)rig_add(r, c, f, &placed);
            }
        }
    }
}

/* Camera 1 sees four points that are off one line by `off`. */
static int rig_is_degenerate(double off)
{
    rig_scene *const r = &rig_probed;
    rigcal_rig_fit fit;
    scene placed;
    rig_begin(r, 2);
    r->rig.view_poses = NULL;
    state = 1250;
    random_scene(&placed, 6, PLANAR, PINHOLE, 0, 5, 8);
    placed.t[0] = placed.t[1] = 0;
    (void)rig_add(r, 0, 0, &placed);
    placed.n = 4;
    for (int i = 0; i < 4; i++) {
        placed.X[i][0] = 0.3 * i - 0.45;
        placed.X[i][1] = i % 2 ? off : -off;
    }
    const size_t before = r->rig.n_views;
    (void)rig_add(r, 1, 0, &placed);
    if (r->rig.n_views == before) { /* no view of it has a pose */
        const rigcal_rig_view v = {view_of(&r->seen[before]), 1, 0, 0};
        r->views[before] = v;
        r->rig.n_views++;
    }
    r->cams[0] = identity();
    r->placements[0] = transform_of(placed.R, placed.t);
    rigcal_transform back;
    rc_transform_invert(&back, &r->placements[0]);
    rc_transform_compose(&r->cams[1], &r->seen[before].options.start, &back);
    return rigcal_rig_adjust(&fit, NULL, &r->rig) == RIGCAL_ERR_DEGENERATE;
}

/* One point in five is wrong, by up to eight times the noise. */
static void gate_wrong_points(void)
{
    tally t;
    begin(&t, "rig.robust");
    state = 1270;
    for (int i = 0; i < 30; i++) {
        rig_scene *const r = &rig_probed;
        rigcal_rig_fit fit;
        size_t n_wrong = 0;
        random_rig(r, 3, 0.9, 0.3);
        (void)rigcal_rig_join(&r->rig, NULL);
        for (size_t v = 0; v < r->rig.n_views; v++) {
            r->seen[v].o[v % 5].uv[0] += (rigcal_real)(0.15 * (double)(v % 17));
        }
        r->rig.sigma_px = (rigcal_real)0.3;
        if (count(&t, rigcal_rig_adjust_robust(&fit, &n_wrong, NULL, &r->rig)) >= 0) {
            t.found += (int)n_wrong;
            t.steps += fit.evals;
        }
    }
    end(&t);
}

/* The step of a deviation that is a turn about z by this angle. */
static double deviation_of(double turn)
{
    const rigcal_transform from = identity();
    rigcal_transform to = from;
    rigcal_real d[6];
    to.R[0] = to.R[4] = (rigcal_real)cos(turn);
    to.R[3] = (rigcal_real)sin(turn);
    to.R[1] = -to.R[3];
    rc_deviation(d, &to, &from);
    return (double)d[2];
}

static int half_turn_has_no_axis(double less)
{
    return deviation_of(3.14159265358979 - less) < 1;
}

static void gate_rigs(void)
{
    tally t, joins;
    memset(&joins, 0, sizeof joins);
    begin(&joins, "rig.join");
    begin(&t, "rig.adjust");
    state = 1200;
    for (int i = 0; i < 80; i++) {
        rig_scene *const r = &rig_probed;
        rigcal_rig_fit fit;
        random_rig(r, 2 + i % 3, i % 4 ? 0.8 : 0.4, i % 5 ? 0.3 : 0);
        if (count(&joins, rigcal_rig_join(&r->rig, NULL)) < 0) {
            continue;
        }
        for (size_t c = 0; c < r->rig.n_cameras; c++) {
            joins.found += r->group[c];
        }
        if (count(&t, rigcal_rig_adjust(&fit, NULL, &r->rig)) >= 0) {
            t.steps += fit.evals;
        }
    }
    end(&joins);
    end(&t);
    gate_wrong_points();
    edge("deviation.half", half_turn_has_no_axis, 1e-9, 0.5);
    line("deviation.far", "%.12g", deviation_of(3));
    if (RIGCAL_USE_FLOAT) { /* in double the rounding differs from line to line */
        edge("rig.rank", rig_is_degenerate, 1e-7, 0.1);
    }
}

/* Moves the pixels of view k along its rows. Its pose then differs. */
static void shift_view(rig_scene *r, size_t k, double px)
{
    scene *const s = &r->seen[k];
    rigcal_pose pose;
    size_t n_found;
    for (int i = 0; i < s->n; i++) {
        s->o[i].uv[0] += RC(px);
    }
    if (rigcal_pose_solve(&pose, 1, &n_found, NULL, &r->views[k].view, &s->options) >= 0) {
        (void)rigcal_view_pose_make(&r->own[k], &r->views[k], &pose.cam_from_world);
    }
}

/* Joins all views, whatever is wrong with them. */
static rigcal_status judge(rig_scene *r)
{
    memset(&r->choice, 0, sizeof r->choice);
    memset(r->takes, 0, sizeof r->takes);
    r->choice.takes = r->takes;
    r->choice.sigma_px = RC(0.3);
    r->rig.left_out = NULL;
    const rigcal_status status = rigcal_rig_join(&r->rig, NULL);
    return (status < 0) ? status
                        : rigcal_rig_judge(&r->judgement, NULL, r->judged, r->left_out,
                                           &r->choice, &r->rig);
}

/* Whether one view of 16 that is off by this many pixels stays. */
static int view_fits(double px)
{
    rig_scene *const r = &rig_probed;
    state = 1480;
    random_rig(r, 4, 1, 0.3);
    shift_view(r, 5, px);
    return judge(r) >= 0 && r->judged[5].verdict == RIGCAL_VIEW_FITS;
}

static void gate_judgements(void)
{
    tally t;
    double scale = 0;
    begin(&t, "rig.judge");
    state = 1460;
    for (int i = 0; i < 40; i++) {
        rig_scene *const r = &rig_probed;
        random_rig(r, 4, 1, i % 3 ? 0.3 : 1);
        for (size_t k = 0; k < r->rig.n_views; k++) {
            if (uniform(0, 1) < 0.06 * (i % 4)) {
                shift_view(r, k, uniform(2, 60));
            }
        }
        if (count(&t, judge(r)) >= 0) {
            t.steps += r->judgement.adjustments;
            scale += (double)r->judgement.scale;
            for (size_t k = 0; k < r->rig.n_views; k++) {
                t.found += r->left_out[k] * (long)(k + 1);
            }
        }
    }
    end(&t);
    line("judge.scale", "%.3g", scale);
    edge("judge.px", view_fits, 0.1, 5);
}

/* Many cameras, and two poses of each view. The scene consists of poses alone. */
enum { CHOICE_CAMERAS = 10, CHOICE_VIEWS = CHOICE_CAMERAS * RIG_PLACEMENTS };

typedef struct {
    rigcal_view_pose own[CHOICE_VIEWS], second[CHOICE_VIEWS];
    rigcal_transform cams[CHOICE_CAMERAS], placements[RIG_PLACEMENTS];
    int32_t group[CHOICE_CAMERAS];
    uint8_t takes[CHOICE_VIEWS];
    rigcal_real work[RIGCAL_CHOOSE_WORK(CHOICE_CAMERAS, RIG_PLACEMENTS, CHOICE_VIEWS) +
                     RIGCAL_RIG_WORK(CHOICE_CAMERAS, CHOICE_CAMERAS, RIG_PLACEMENTS)];
    rigcal_rig rig;
    rigcal_choice choice;
} choice_scene;

static choice_scene choice_probed;

static void choice_begin(choice_scene *r, size_t n_cameras)
{
    memset(r, 0, sizeof *r);
    r->rig.cams_from_rig = r->cams;
    r->rig.n_cameras = n_cameras;
    r->rig.rig_from_placements = r->placements;
    r->rig.n_placements = RIG_PLACEMENTS;
    r->rig.group = r->group;
    r->rig.view_poses = r->own;
    r->rig.work = r->work;
    r->rig.work_capacity = sizeof r->work / sizeof r->work[0];
    r->choice.second_poses = r->second;
    r->choice.takes = r->takes;
}

/* Adds a view. Its pose is off by a number of standard deviations, and another pose is
 * turned. */
static void choice_add(choice_scene *r, int c, int f, const rigcal_transform *truth,
                       double off, int is_wrong)
{
    static const int DIAGONAL[6] = {0, 3, 5, 15, 18, 20};
    const size_t k = r->rig.n_views++;
    rigcal_view_pose *const own = &r->own[k];
    rigcal_real step[6], turned[6] = {RC(0.3), RC(-0.5), 0, 0, 0, 0};
    own->cam_from_target = *truth;
    for (int i = 0; i < 6; i++) {
        const double strength = uniform(400, 2000);
        own->information[DIAGONAL[i]] = RC(strength);
        step[i] =
            RC((off * 0.3 * normal() + (is_wrong ? 10 * normal() : 0)) / sqrt(strength));
    }
    own->sse = RC(0.3 * uniform(0, 1));
    own->n = 4;
    own->camera = c;
    own->placement = f;
    rc_transform_move(&own->cam_from_target, step);
    r->second[k] = *own;
    rc_transform_move(&r->second[k].cam_from_target, turned);
    if (uniform(0, 1) < 0.2) {
        const rigcal_view_pose first = *own;
        *own = r->second[k];
        r->second[k] = first;
    }
    r->second[k].sse += RC(0.1);
}

static void random_choice(choice_scene *r, int n_cameras, double off, double wrong)
{
    static const double ahead[3] = {0, 0, 5};
    choice_begin(r, (size_t)n_cameras);
    for (int c = 0; c < n_cameras; c++) {
        double R[9];
        const double t[3] = {0.3 * c, 0.1 * c, 0};
        random_rotation(R);
        r->cams[c] = transform_of(R, t);
    }
    for (int f = 0; f < RIG_PLACEMENTS; f++) {
        double R[9];
        random_rotation(R);
        const rigcal_transform placed = transform_of(R, ahead);
        for (int c = 0; c < n_cameras; c++) {
            rigcal_transform truth;
            rc_transform_compose(&truth, &r->cams[c], &placed);
            choice_add(r, c, f, &truth, off, uniform(0, 1) < wrong);
        }
    }
}

/* Whether two placements agree, if the second is off by this many pixels, with noise of 1
 * px. */
static int choice_agrees(double off)
{
    choice_scene *const r = &choice_probed;
    rigcal_transform truth = identity();
    choice_begin(r, 2);
    state = 1450;
    for (int k = 0; k < 4; k++) {
        choice_add(r, k % 2, k / 2, &truth, 0, 0);
        r->own[k].cam_from_target = truth;
        r->own[k].information[20] = 2;
        r->second[k].n = 0;
    }
    r->own[3].cam_from_target.t[2] = RC(off * sqrt(2.0));
    r->rig.n_placements = 2;
    r->rig.sigma_px = 1;
    return rigcal_rig_choose(&r->choice, NULL, &r->rig) >= 0 && r->choice.tau2 < 2 &&
           r->choice.share > RC(0.9);
}

static void gate_choices(void)
{
    tally t;
    begin(&t, "rig.choose");
    state = 1400;
    for (int i = 0; i < 90; i++) {
        choice_scene *const r = &choice_probed;
        random_choice(r, 2 + 4 * (i % 3), i % 4 ? 1 : 4, 0.08 * (i % 10));
        r->rig.sigma_px = RC(i % 2 ? 0.3 : 0);
        count(&t, rigcal_rig_choose(&r->choice, NULL, &r->rig));
        t.steps += (long)r->choice.tau2;
        for (size_t v = 0; v < r->rig.n_views; v++) {
            t.found += r->takes[v] * (long)(v + 1);
        }
    }
    end(&t);
    edge("choose.limit", choice_agrees, 0.1, 100);
    random_choice(&choice_probed, 3, 0.1, 0);
    for (size_t v = 0; v < choice_probed.rig.n_views; v++) {
        choice_probed.own[v].sse = 0;
    }
    (void)rigcal_rig_choose(&choice_probed.choice, NULL, &choice_probed.rig);
    line("choose.noise_px", "%.3g", (double)choice_probed.choice.sigma_px);
}

/* ---- lenses --------------------------------------------------------------- */

static void gate_lenses(void)
{
    tally t;
    begin(&t, "lens.usual");
    for (int kind = 0; kind < LENSES; kind++) {
        const rigcal_camera camera = camera_of((lens)kind, 300);
        for (int i = 0; i < 1000; i++) {
            const rigcal_real uv[2] = {RC(20 * (i % 32)), RC(15 * (i / 32))};
            rigcal_real ray[3], back[2];
            if (count(&t, rigcal_camera_ray(ray, &camera, uv)) == RIGCAL_OK) {
                count(&t, rigcal_camera_project(back, &camera, ray));
            }
        }
    }
    end(&t);
    begin(&t, "lens.any");
    state = 1300;
    for (int i = 0; i < 2000; i++) {
        rigcal_camera camera = camera_of(PINHOLE, 300);
        rigcal_real ray[3], uv[2];
        rigcal_real *const k[8] = {&camera.k1, &camera.k2, &camera.k3, &camera.k4,
                                   &camera.p1, &camera.p2, &camera.k5, &camera.k6};
        camera.lens = i % 2 ? RIGCAL_LENS_FISHEYE : RIGCAL_LENS_BROWN;
        for (int j = 0; j < (i % 2 ? 4 : 8); j++) {
            *k[j] = RC(normal() * (j == 4 || j == 5 ? 0.1 : 1) * 10 * small(4));
        }
        uv[0] = RC(320 + 300 * normal());
        uv[1] = RC(240 + 300 * normal());
        count(&t, rigcal_camera_ray(ray, &camera, uv));
        for (int j = 0; j < 3; j++) {
            ray[j] = RC(normal());
        }
        count(&t, rigcal_camera_project(uv, &camera, ray));
    }
    end(&t);
}

/* The pixel of this ray lies beyond the place where the lens folds, r = 1 / sqrt(3 *
 * 0.2). */
static double principal_point;

static int pixel_has_ray(double beyond_px)
{
    rigcal_camera camera = camera_of(PINHOLE, 300);
    const double r = 1 / sqrt(0.6), farthest = 300 * (r - 0.2 * r * r * r);
    rigcal_real ray[3];
    camera.k1 = RC(-0.2);
    camera.cx = RC(principal_point);
    const rigcal_real uv[2] = {RC(farthest + beyond_px) + camera.cx, camera.cy};
    return rigcal_camera_ray(ray, &camera, uv) == RIGCAL_OK;
}

static void gate_lens_edges(void)
{
    principal_point = 0;
    edge("lens.miss_px", pixel_has_ray, ANY_OF(1e-12, 1e-4), 1);
    principal_point = ANY_OF(1e8, 1e5);
    edge("lens.miss_far_px", pixel_has_ray, ANY_OF(1e-9, 1e-3), 1);
    line("points.negligible", "%.2e", (double)rc_negligible(1, 0));
    line("points.negligible_far", "%.2e", (double)rc_negligible(1, RC(1e7)));
}

/* The errors of the series: of a fisheye's ray at the pixel of `theta`, and back. */
static void gate_series(void)
{
    rigcal_camera camera = camera_of(FISHEYE, 100);
    double ray_error = 0, angle_error = 0, odds_error = 0;
    camera.k1 = camera.k2 = 0;
    for (int i = 1; i < 314; i++) {
        const double theta = 0.01 * i;
        const rigcal_real uv[2] = {RC(100 * theta) + camera.cx, camera.cy};
        const rigcal_real X[3] = {RC(sin(theta)), 0, RC(cos(theta))};
        rigcal_real ray[3], back[2];
        rigcal_camera_ray(ray, &camera, uv);
        const double seen = atan2((double)ray[0], (double)ray[2]);
        ray_error = fmax(ray_error, fabs(seen - theta));
        rigcal_camera_project(back, &camera, X);
        angle_error = fmax(angle_error, fabs((double)(back[0] - camera.cx) / 100 - theta));
    }
    for (int i = -100; i <= 100; i++) {
        const double exponent = 0.79 * i;
        const double seen = (double)rc_odds(RC(100 - exponent), 100, 1, 1, 5);
        odds_error = fmax(odds_error, fabs(seen / exp(exponent / 2) - 1));
    }
    line("series.ray", "%.0e", ray_error);
    line("series.angle", "%.0e", angle_error);
    line("series.odds", "%.1e", odds_error);
}

static int exponent_is_free(double exponent)
{
    return rc_odds(0, RC(2 * exponent), 1, 1, 5) <
           rc_odds(0, RC(2.001 * exponent), 1, 1, 5);
}

static int noise_is_believed(double sse)
{
    return rc_odds(0, RC(sse * sse), 0, 1, 7) < 2;
}

/* Whether half of all F of (n, n) degrees of freedom are below 1. */
static int half_is_below_1(double n)
{
    return fabs((double)rc_f_tail(1, RC(n), RC(n)) - 0.5) < ANY_OF(1e-6, 1e-2);
}

/* How many logarithms are rounded correctly. */
static int nearest_logs(void)
{
    int n = 0;
    for (int i = 0; i < 20000; i++) {
        const rigcal_real x = RC(0.7072 + 0.0000353 * i);
        n += !(RC_FABS(rc_log(x) - RC(log((double)x))) > 0);
    }
    return n;
}

static void gate_chance(void)
{
    edge("chance.exponent", exponent_is_free, 1, 500);
    edge("chance.noise_px", noise_is_believed, 1e-6, 10);
    line("chance.sets_most", "%.1e", (double)rc_expected_sets(100000, 1000, 1));
    double within = 0;
    for (int i = 1; i < 10; i++) {
        within += (double)rc_normal_within(RC(0.1 * i));
    }
    line("chance.within", ANY_OF("%.10g", "%.5g"), within);
    line("chance.f_tail", ANY_OF("%.11g", "%.4g"), (double)rc_f_tail(4, 1, 1));
    edge("chance.fraction", half_is_below_1, 10, 1e10);
    line("log.nearest", "%d", nearest_logs());
}

/* ---- the published procedure ---------------------------------------------- */

static int bearings_of(rigcal_bearing b[], const scene *s)
{
    const rigcal_view view = view_of(s);
    return rigcal_bearings_of_view(b, NULL, &view) == RIGCAL_OK;
}

static rigcal_status choose(size_t *n_pairs, const rigcal_bearing b[], int n)
{
    rigcal_pair pairs[4 * POINTS_MAX];
    return rigcal_pairs_choose(pairs, 4 * POINTS_MAX, n_pairs, b, (size_t)n);
}

static void gate_paper(void)
{
    tally t;
    begin(&t, "pairs");
    state = 1400;
    for (int i = 0; i < 200; i++) {
        scene s;
        rigcal_bearing b[POINTS_MAX];
        size_t n_pairs = 0;
        random_scene(&s, 3 + i % 40, (shape)(i % SHAPES), PINHOLE, 0.2, 2, 8);
        for (int k = 4; k < s.n && i % 3 == 2; k++) { /* these are all near to each other */
            for (int j = 0; j < 3; j++) {
                s.X[k][j] = 0.01 * s.X[k][j];
            }
        }
        if (observe(&s) && bearings_of(b, &s)) {
            count(&t, choose(&n_pairs, b, s.n));
            t.found += (long)n_pairs;
        }
    }
    end(&t);
    begin(&t, "paper");
    for (int i = 0; i < 24; i++) {
        scene s;
        rigcal_bearing b[POINTS_MAX];
        rigcal_pair pairs[4 * POINTS_MAX];
        rigcal_paper_pose pose;
        rigcal_paper_options o;
        size_t n_pairs;
        rigcal_paper_defaults(&o);
        random_scene(&s, 4 + i % 6, (shape)(i % 3), PINHOLE, 0.2, 2, 8);
        o.use_guess = i % 4 == 3;
        o.angles = i % 8 == 7 ? 3 : 2;
        o.pairs_used = i % 3 == 2 ? 2 : 0;
        if (!bearings_of(b, &s) || rigcal_pairs_choose(pairs, 4 * POINTS_MAX, &n_pairs, b,
                                                       (size_t)s.n) != RIGCAL_OK) {
            continue;
        }
        const rigcal_status status =
            count(&t, rigcal_paper_solve(&pose, b, (size_t)s.n, pairs, n_pairs, &o));
        if (status >= 0) {
            t.steps += pose.evals;
            t.found += pose.starts;
            t.misses += rotation_error(s.R, pose.cam_from_world.R) > 0.3;
        }
    }
    end(&t);
}

static rigcal_bearing three[3];

static void set_three(void)
{
    static const double X[3][2] = {{0, 0}, {1, 0}, {0, 1}};
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            three[i].X_w[k] = k < 2 ? RC(X[i][k]) : 0;
            three[i].ray[k] = k < 2 ? RC(0.1 * X[i][k]) : 1;
        }
    }
}

static int points_are_line(double off)
{
    size_t n_pairs;
    set_three();
    three[2].X_w[0] = RC(0.5);
    three[2].X_w[1] = RC(off);
    return choose(&n_pairs, three, 3) == RIGCAL_ERR_COLLINEAR;
}

static int rays_are_same(double off)
{
    size_t n_pairs;
    set_three();
    three[1].ray[0] = RC(off);
    three[2].ray[0] = RC(0.1);
    three[2].ray[1] = 0;
    return choose(&n_pairs, three, 3) == RIGCAL_ERR_COINCIDENT;
}

static int shape_is_kept(double far)
{
    size_t n_pairs;
    set_three();
    for (int i = 0; i < 3; i++) {
        three[i].X_w[2] = RC(far);
    }
    return choose(&n_pairs, three, 3) != RIGCAL_ERR_PRECISION;
}

static int ray_is_behind(double z)
{
    size_t n_pairs;
    set_three();
    three[1].ray[0] = 1;
    three[1].ray[2] = RC(z);
    return choose(&n_pairs, three, 3) == RIGCAL_ERR_WIDE_RAY;
}

static rigcal_pair pair_of(double normal_x, double normal_y, double offset_z)
{
    rigcal_pair p = {{RC(normal_x), RC(normal_y), 0}, {0, 0, RC(offset_z)}, 0, 1};
    return p;
}

static int pair_is_unit(double more)
{
    const rigcal_pair p = pair_of(sqrt(1 + more), 0, 1);
    const rigcal_transform T = identity();
    rigcal_real e;
    return rigcal_pair_residual(&e, &p, T.R) == RIGCAL_OK;
}

/* Pairs whose equations of pitch differ by no more than this. */
static rigcal_status eliminate(double off, int32_t pairs_used)
{
    rigcal_pair p[3];
    rigcal_elimination out;
    const rigcal_real angles[2] = {0, 0};
    for (int i = 0; i < 3; i++) {
        p[i] = pair_of(0.6, 0.8, 0.8);
        p[i].offset[1] = RC(0.6);
    }
    p[1].offset[0] = RC(off);
    return rigcal_pairs_eliminate(&out, p, 3, pairs_used, RIGCAL_PITCH, angles);
}

static int two_are_singular(double off)
{
    return eliminate(off, 2) == RIGCAL_ERR_DEGENERATE;
}

static int all_are_singular(double off)
{
    return eliminate(off, 0) == RIGCAL_ERR_DEGENERATE;
}

static rigcal_status translate(double off, int by_pairs)
{
    const rigcal_transform T = identity();
    rigcal_pair p = pair_of(1, 0, 1);
    rigcal_real t[3];
    set_three();
    three[0].ray[0] = 1;
    three[1].ray[0] = RC(1 + off);
    three[1].ray[1] = 0;
    return by_pairs ? rigcal_translation_from_pairs(t, T.R, three, 2, &p, 1)
                    : rigcal_translation_least_squares(t, T.R, three, 2);
}

static int spread_is_none(double off)
{
    return translate(off, 1) == RIGCAL_ERR_DEGENERATE;
}

/* The u of the rays are 1 and 1 + off. Only rounding is left of their deviations. */
static int rays_differ_not(double off)
{
    return translate(off, 0) == RIGCAL_ERR_DEGENERATE;
}

static int guess_is_taken(double angle)
{
    rigcal_paper_solver s;
    rigcal_paper_options o;
    rigcal_pair p[3];
    set_three();
    for (int i = 0; i < 3; i++) {
        p[i] = pair_of(1, 0, 1);
    }
    rigcal_paper_defaults(&o);
    o.use_guess = 1;
    o.guess_ypr[0] = RC(angle);
    return rigcal_paper_begin(&s, three, 3, p, 3, &o) == RIGCAL_OK;
}

static void gate_paper_edges(void)
{
    edge("pairs.line", points_are_line, ANY_OF(1e-14, 1e-8), 0.1);
    edge("pairs.same_ray", rays_are_same, ANY_OF(1e-18, 1e-10), 0.05);
    edge("pairs.precision", shape_is_kept, 1, ANY_OF(1e20, 1e8));
    edge("pairs.behind", ray_is_behind, ANY_OF(1e-20, 1e-12), 1);
    edge("pairs.unit", pair_is_unit, 1e-9, 1);
    edge("eliminate.two", two_are_singular, ANY_OF(1e-20, 1e-12), 0.01);
    edge("eliminate.all", all_are_singular, ANY_OF(1e-20, 1e-12), 0.01);
    edge("translation.spread", spread_is_none, ANY_OF(1e-15, 1.2e-7), 0.1);
    edge("translation.same", rays_differ_not, ANY_OF(2.3e-16, 1.2e-7), 0.1);
    edge("paper.guess", guess_is_taken, 1, 1e20);
}

/* ---- searches ------------------------------------------------------------- */

static rigcal_real valley(void *context, const rigcal_real x[])
{
    const rigcal_real a = 1 - x[0], b = x[1] - x[0] * x[0];
    (void)context;
    return a * a + 100 * b * b;
}

static void gate_neldermead(void)
{
    static const double tolerances[] = {1e-3, 1e-6, 0};
    tally t;
    begin(&t, "neldermead");
    state = 1500;
    for (int i = 0; i < 60; i++) {
        rigcal_neldermead nm;
        rigcal_real x[2];
        int32_t evals = 0;
        const rigcal_real tol = RC(tolerances[i % 3]);
        x[0] = i % 5 == 0 ? 0 : RC(normal());
        x[1] = i % 7 == 0 ? 0 : RC(normal());
        rigcal_neldermead_begin(&nm, x, 2, tol, tol, 1000);
        rigcal_neldermead_step(&nm, valley, NULL, 10000);
        count(&t, rigcal_neldermead_result(x, NULL, &evals, &nm));
        t.steps += evals;
    }
    end(&t);
}

static rigcal_levenberg begun(void)
{
    rigcal_levenberg lm;
    rc_levenberg_begin(&lm, 0);
    rc_levenberg_evaluated(&lm, RIGCAL_OK, 1);
    return lm;
}

static int damped_step_is_last(double lambda)
{
    rigcal_levenberg lm = begun();
    lm.lambda = RC(lambda);
    return rc_levenberg_promised(&lm, 0, 0) == RC_STEP_LAST;
}

static int gain_is_least(double gain)
{
    rigcal_levenberg lm = begun();
    return rc_levenberg_promised(&lm, RC(gain), 0) == RC_STEP_LAST;
}

static int little_is_left(double gain)
{
    rigcal_levenberg lm = begun();
    lm.last_gain = 1;
    return rc_levenberg_promised(&lm, RC(gain), 0) == RC_STEP_LAST;
}

static int gains_fall(double gain)
{
    rigcal_levenberg lm = begun();
    lm.last_gain = 1;
    rc_levenberg_promised(&lm, RC(gain), 0);
    return lm.equations == RC_GAUSS_NEWTON;
}

static int rise_is_rounding(double rise)
{
    rigcal_levenberg lm = begun();
    return rc_levenberg_tried(&lm, RIGCAL_OK, RC(1) + RC(rise), 1, 0);
}

static int damping_helps(double lambda)
{
    rigcal_levenberg lm = begun();
    lm.lambda = RC(lambda);
    rc_levenberg_tried(&lm, RIGCAL_OK, 2, 1, 0);
    return lm.status == RIGCAL_RUNNING;
}

static int harm_is_rounding(double gain)
{
    rigcal_levenberg lm = begun();
    rc_levenberg_tried(&lm, RIGCAL_OK, 2, RC(gain), 0);
    return lm.status == RIGCAL_OK;
}

static void gate_levenberg(void)
{
    edge("levenberg.near", damped_step_is_last, 1e-9, 1e3);
    edge("levenberg.gain", gain_is_least, 1e-20, 1);
    edge("levenberg.left", little_is_left, 1e-20, 1);
    edge("levenberg.slow", gains_fall, 1e-4, 1);
    edge("levenberg.rise", rise_is_rounding, ANY_OF(2.3e-16, 1.2e-7), 0.1);
    edge("levenberg.last", damping_helps, 1, 1e12);
    edge("levenberg.rounding", harm_is_rounding, 1e-12, 1);

    rigcal_levenberg lm = begun();
    line("levenberg.first", "%.1e", (double)lm.lambda);
    rc_levenberg_tried(&lm, RIGCAL_OK, RC(0.5), 1, 0);
    line("levenberg.less", "%.1e", (double)lm.lambda);
    lm.lambda = 1;
    rc_levenberg_tried(&lm, RIGCAL_OK, 2, 1, 0);
    line("levenberg.more", "%.1e", (double)lm.lambda);
    long tries = 0;
    for (lm = begun(); lm.status == RIGCAL_RUNNING && tries < 1000; tries++) {
        rc_levenberg_tried(&lm, RIGCAL_OK, 2, 1, 0);
    }
    line("levenberg.tries", "%ld %.1e", tries, (double)lm.lambda);
    lm = begun();
    lm.equations = RC_NEWTON;
    lm.lambda = 0;
    rc_levenberg_not_definite(&lm);
    line("levenberg.indefinite", "%.1e", (double)lm.lambda);
    while (lm.equations != RC_GAUSS_NEWTON && lm.lambda < RC(1e20)) {
        rc_levenberg_not_definite(&lm);
        lm.lambda *= RC(1.01); /* so that it is no power of ten */
    }
    line("levenberg.given_up", "%.1e", (double)lm.lambda);
}

/* ---- three points, directions, matrices ----------------------------------- */

static int triangle_poses(double x2, double y2, const double rays[3][2])
{
    const rigcal_real x[3][3] = {{0, 0, 0}, {1, 0, 0}, {RC(x2), RC(y2), 0}};
    rigcal_real ray[3][3];
    rigcal_transform poses[RC_P3P_MAX];
    for (int i = 0; i < 3; i++) {
        const rigcal_real m[3] = {RC(rays[i][0]), RC(rays[i][1]), 1};
        (void)rc_vec3_unit(ray[i], m);
    }
    return rc_p3p(poses, x, (const rigcal_real(*)[3])ray);
}

/* Points that are off a line by `off`, seen from a distance of 5. */
static int triangle_is_line(double off)
{
    const double rays[3][2] = {{0, 0}, {0.2, 0}, {0.1, 0.2 * off}};
    return triangle_poses(0.5, off, rays) == 0;
}

static int rays_are_one(double off)
{
    const double rays[3][2] = {{0, 0}, {off, 0}, {0, off}};
    return triangle_poses(0, 1, rays) == 0;
}

static void gate_p3p(void)
{
    tally t;
    begin(&t, "p3p");
    state = 1600;
    for (int i = 0; i < 4000; i++) {
        double R[9], X[3][3], X_c[3],
            t0[3] = {uniform(-1, 1), uniform(-1, 1), uniform(0.6, 6)};
        rigcal_real x[3][3], ray[3][3];
        rigcal_transform poses[RC_P3P_MAX];
        const double noise = i % 2 ? 0.02 * small(5) : 0;
        int is_near = 0;
        random_rotation(R);
        for (int k = 0; k < 3; k++) {
            point_of(X[k], GENERAL, k);
            move(X_c, R, t0, X[k]);
            for (int j = 0; j < 3; j++) {
                x[k][j] = RC(X[k][j]);
                ray[k][j] = RC(X_c[j] + noise * normal());
            }
            (void)rc_vec3_unit(ray[k], ray[k]);
        }
        const int n =
            rc_p3p(poses, (const rigcal_real(*)[3])x, (const rigcal_real(*)[3])ray);
        for (int k = 0; k < n; k++) {
            is_near |= rotation_error(R, poses[k].R) < 0.1;
        }
        t.misses += !is_near;
        t.found += n;
    }
    end(&t);
    edge("p3p.line", triangle_is_line, ANY_OF(1e-20, 1e-12), 0.1);
    edge("p3p.same_ray", rays_are_one, ANY_OF(1e-20, 1e-12), 0.05);
}

static rigcal_moments moments_of(double thickness, double extent)
{
    rigcal_moments sums;
    rc_moments_begin(&sums);
    for (int i = 0; i < 4; i++) {
        const rigcal_real x[3] = {i % 2 ? 1 : -1, i / 2 ? 1 : -1,
                                  RC(i == 0 || i == 3 ? thickness : -thickness)};
        const rigcal_real u[2] = {RC(1) + (rigcal_real)extent * x[0],
                                  (rigcal_real)extent * x[1]};
        rc_moments_add(&sums, 1, x, u);
    }
    return sums;
}

static int image_is_point(double extent)
{
    rigcal_moments sums = moments_of(1, extent);
    return !rc_moments_finish(&sums);
}

static int moments_are_line(double ratio)
{
    const rigcal_real C[6] = {1, 0, 0, RC(ratio), 0, RC(ratio)};
    rigcal_real normal3[3], thickness;
    return !rc_sym3_thinnest(normal3, &thickness, C);
}

static int pivot_is_rounding(double left)
{
    rc_sym6_factor L;
    rigcal_real H[21] = {0};
    for (int at = 0; at < 21; at += 15) {
        H[at] = H[at + 3] = H[at + 5] = 1;
    }
    H[1] = RC(1) - RC(left / 2); /* so that the pivot is about `left` */
    return !rc_sym6_factor_of(&L, H, 0);
}

static int diagonal_is_least(double element)
{
    const rigcal_real A[6] = {1, 0, 0, RC(element), 0, 1};
    rigcal_real damped[6], least[3];
    rc_sym3_damp(damped, least, A, 1);
    return least[1] > A[3];
}

static void gate_directions(void)
{
    tally t;
    begin(&t, "direction");
    state = 1700;
    for (int i = 0; i < 300; i++) {
        scene s;
        rigcal_moments sums;
        random_scene(&s, 4 + i % 5, (shape)(i % 3), PINHOLE, 0.3, 1.2, 10);
        rc_moments_begin(&sums);
        for (int k = 0; k < s.n; k++) {
            const rigcal_real u[2] = {(s.o[k].uv[0] - s.camera.cx) / s.camera.fx,
                                      (s.o[k].uv[1] - s.camera.cy) / s.camera.fy};
            rc_moments_add(&sums, 1, s.o[k].X_w, u);
        }
        if (!rc_moments_finish(&sums)) {
            continue;
        }
        for (int k = 0; k < 10; k++) {
            double R[9];
            random_rotation(R);
            const rigcal_transform T = transform_of(R, s.t);
            t.found += rc_direction_cost(&sums, T.R) < RC_MAX;
        }
    }
    end(&t);
    double worst = 0;
    for (int i = 0; i < 500; i++) {
        double R[9];
        rigcal_real C[6] = {0}, normal3[3], thickness;
        random_rotation(R);
        const double part[3] = {1, 1.2, uniform(0.5, 0.9)};
        const double none[3] = {0, 0, 0};
        const rigcal_transform T = transform_of(R, none);
        for (int k = 0; k < 3; k++) {
            rc_sym3_add_outer(C, RC(part[k]), &T.R[3 * k]);
        }
        if (rc_sym3_thinnest(normal3, &thickness, C)) {
            worst = fmax(worst, 1 - fabs((double)rc_vec3_dot(normal3, &T.R[6])));
        }
    }
    line("linalg.thinnest", "%.1e", worst);
    edge("linalg.line", moments_are_line, 1e-20, 1);
    edge("linalg.rank", pivot_is_rounding, ANY_OF(4.5e-16, 2.4e-7), 0.1);
    edge("linalg.least", diagonal_is_least, 1e-9, 0.9);
    edge("direction.extent", image_is_point, ANY_OF(1e-14, 1e-6), 0.5);
}

/* ---- targets at the edge of what there is a pose of ----------------------- */

static int points_are_one(double apart)
{
    scene s = probed;
    for (int k = 0; k < 3; k++) {
        s.X[1][k] = s.X[0][k] + (k == 0 ? apart : 0);
    }
    state = 7;
    observe(&s);
    return solve_probed(&s) == RIGCAL_ERR_COINCIDENT;
}

static int target_keeps_shape(double far)
{
    scene s = probed;
    for (int i = 0; i < s.n; i++) {
        s.o[i].X_w[2] += RC(far);
    }
    return solve_probed(&s) != RIGCAL_ERR_PRECISION;
}

/* The number of poses of a scene. */
static long found_of(const scene *s)
{
    tally t;
    memset(&t, 0, sizeof t);
    solve(&t, s);
    return t.found;
}

/* Whether the two poses of a square that is far away count as one. `tangent` is that of its
 * small tilt. */
static int poses_are_one(double tangent)
{
    scene s = probed;
    const double q[4] = {1, tangent, 0, 0};
    rotation_of(s.R, q);
    observe(&s);
    return found_of(&s) < 2;
}

/* Three points on the unit circle; the camera is on the cylinder through it, or near. There
 * two poses merge. */
static void cylinder_scene(double off, double pixel)
{
    const double turn[9] = {1, 0, 0, 0, -1, 0, 0, 0, -1};
    random_scene(&probed, 3, GENERAL, PINHOLE, 0, 3, 3.1);
    memcpy(probed.R, turn, sizeof turn);
    for (int i = 0; i < 3; i++) {
        probed.X[i][0] = i == 0 ? 1 : -0.5;
        probed.X[i][1] = i == 0 ? 0 : i == 1 ? 0.8660254037844386 : -0.8660254037844386;
        probed.X[i][2] = 0;
    }
    probed.t[0] = -0.8 * (1 + off); /* centre (0.8, 0.6, 4) (1 + off) */
    probed.t[1] = 0.6 * (1 + off);
    probed.t[2] = 4;
    observe(&probed);
    probed.o[0].uv[0] += RC(pixel);
    probed.o[0].uv[1] += RC(pixel / 2);
}

static long cylinder_found;

static int exact_are_one(double off)
{
    cylinder_scene(off, 0);
    return found_of(&probed) == cylinder_found;
}

static int noise_is_exact(double pixel)
{
    cylinder_scene(0, pixel);
    return found_of(&probed) == cylinder_found;
}

static void gate_near_poses(void)
{
    state = 1850;
    random_scene(&probed, 4, SQUARE, PINHOLE, 0, 3, 3.1);
    probed.camera = camera_of(PINHOLE, ANY_OF(1e7, 1e6));
    probed.t[0] = probed.t[1] = 0;
    probed.t[2] = ANY_OF(1e5, 1e4);
    edge("pose.same", poses_are_one, 1e-5, 0.1);
    cylinder_scene(0, 0);
    cylinder_found = found_of(&probed);
    line("pose.merged", "%ld", cylinder_found);
    edge("pose.same_exact", exact_are_one, 1e-9, 0.1);
    edge("pose.exact_px", noise_is_exact, 1e-9, 10);
}

/* Counts the starts that the optima of a thicker or thinner target need. */
static void gate_thickness(void)
{
    tally t;
    begin(&t, "thickness");
    state = 1800;
    for (int i = 0; i < 300; i++) {
        scene s;
        const double thick = 0.7 * small(5);
        random_scene(&s, 6 + i % 4, GENERAL, PINHOLE, 0.5, 2, 40);
        for (int k = 0; k < s.n; k++) {
            s.X[k][2] *= thick;
            s.X[k][0] = i % 10 == 9 ? s.X[k][2] : s.X[k][0];
        }
        if (observe(&s)) {
            for (int k = 0; k < s.n && i % 3 == 0; k++) {
                s.o[k].X_w[2] = -s.o[k].X_w[2];
            }
            solve(&t, &s);
        }
    }
    end(&t);
    begin(&t, "head_on");
    for (int i = 0; i < 300; i++) {
        scene s;
        const double q[4] = {1, small(9), 0, uniform(-1, 1)};
        random_scene(&s, 4 + i % 3, SQUARE, PINHOLE, i % 2 ? 0.2 : 0, 2, 20);
        s.t[0] = s.t[1] = 0;
        rotation_of(s.R, q);
        if (observe(&s)) {
            solve(&t, &s);
        }
    }
    end(&t);
    begin(&t, "three");
    for (int i = 0; i < 600; i++) {
        scene s;
        random_scene(&s, 3, GENERAL, PINHOLE, i % 3 ? small(6) : 0, 1.2, 6);
        s.options.sigma_px = i % 5 == 0 ? 1 : 0;
        solve(&t, &s);
    }
    end(&t);
    random_scene(&probed, 3, GENERAL, PINHOLE, 0, 3, 3.1);
    edge("pose.same_point", points_are_one, ANY_OF(1e-14, 1e-7), 0.3);
    random_scene(&probed, 6, GENERAL, PINHOLE, 0, 3, 3.1);
    edge("pose.precision", target_keeps_shape, 1, ANY_OF(1e20, 1e8));
}

/* ---- numbers at the edge of their range ----------------------------------- */

static rigcal_real *field;
static rigcal_camera camera_probed;

static int field_is_taken(double x)
{
    *field = RC(x);
    return rigcal_camera_check(&camera_probed) == RIGCAL_OK;
}

static int focal_is_short(double x)
{
    return !field_is_taken(x);
}

static int width_is_taken(double x)
{
    camera_probed.width = (int32_t)x;
    return rigcal_camera_check(&camera_probed) == RIGCAL_OK;
}

static int coordinate_is_taken(double x)
{
    rigcal_transform T = identity();
    rigcal_real center[3];
    T.t[0] = RC(x);
    return rigcal_camera_center(center, &T) == RIGCAL_OK;
}

static int sigma_is_taken(double x)
{
    scene s = probed;
    s.options.sigma_px = RC(x);
    return solve_probed(&s) >= 0;
}

static int sigma_is_small(double x)
{
    return !sigma_is_taken(x);
}

/* The first of `n` pairs is no number. It is not looked at if there are too many pairs. */
static int count_is_taken(double n)
{
    rigcal_pair p = pair_of(1, 0, 1);
    const rigcal_real ypr[3] = {0, 0, 0};
    rigcal_real residual;
    p.normal[0] = RC(NAN);
    return rigcal_pairs_residual(&residual, &p, (size_t)n, ypr) == RIGCAL_ERR_NOT_FINITE;
}

static void gate_ranges(void)
{
    camera_probed = camera_of(PINHOLE, 800);
    field = &camera_probed.k1;
    edge("camera.coefficient", field_is_taken, 1, 1e20);
    camera_probed = camera_of(PINHOLE, 800);
    field = &camera_probed.fx;
    edge("camera.focal", focal_is_short, 1e-12, 1);
    camera_probed = camera_of(PINHOLE, 800);
    edge("camera.width", width_is_taken, 1, 2e9);
    edge("transform.coordinate", coordinate_is_taken, 1, ANY_OF(1e60, 1e30));
    state = 1900;
    random_scene(&probed, 6, GENERAL, PINHOLE, 0.1, 3, 3.1);
    edge("pose.sigma_most", sigma_is_taken, 1, 1e12);
    edge("pose.sigma_least", sigma_is_small, 1e-12, 1);
    edge("pairs.count", count_is_taken, 3, 1e15);
}

/* ---- stored calibrations -------------------------------------------------- */

static int is_stored(double correlation)
{
    uint8_t bytes[RIGCAL_STORE_SIZE(1)];
    size_t n_bytes;
    rigcal_mounted_camera m;
    memset(&m, 0, sizeof m);
    m.camera = camera_of(PINHOLE, 800);
    m.cam_from_rig = identity();
    m.has_Sigma = 1;
    for (int i = 0; i < 6; i++) {
        m.Sigma[7 * i] = 1;
    }
    m.Sigma[1] = m.Sigma[6] = RC(1) + RC(correlation);
    return rigcal_store_save(bytes, sizeof bytes, &n_bytes, &m, 1, 1, 1) == RIGCAL_OK;
}

static void put_u32(uint8_t *at, uint32_t x)
{
    for (int i = 0; i < 4; i++) {
        at[i] = (uint8_t)(x >> 8 * i);
    }
}

/* Whether a rotation stored by a float build, with an error in one element, is made a
 * rotation in double. */
static int float_rotation_is_taken(double off)
{
    enum { HEADER = RIGCAL_STORE_HEADER_BYTES, REALS = 12 + 12 + 21 };
    uint8_t bytes[RIGCAL_STORE_SIZE_OF(1, 4)], doubles[RIGCAL_STORE_SIZE(1)];
    size_t n_bytes;
    rigcal_mounted_camera m;
    rigcal_saved_info info;
    memset(&m, 0, sizeof m);
    m.camera = camera_of(PINHOLE, 800);
    m.cam_from_rig = identity();
    if (rigcal_store_save(doubles, sizeof doubles, &n_bytes, &m, 1, 1, 1) != RIGCAL_OK) {
        return 0;
    }
    memcpy(bytes, doubles, HEADER + 16);
    for (int i = 0; i < REALS; i++) {
        rigcal_real x;
        uint32_t bits;
        memcpy(&x, &doubles[HEADER + 16 + (size_t)i * sizeof x], sizeof x);
        const float f = (float)x + (i == 12 ? (float)off : 0);
        memcpy(&bits, &f, sizeof bits);
        put_u32(&bytes[HEADER + 16 + 4 * i], bits);
    }
    bytes[6] = 4;
    put_u32(bytes + 20, sizeof bytes);
    put_u32(bytes + 24, rc_crc32(bytes + HEADER, sizeof bytes - HEADER));
    put_u32(bytes + 28, rc_crc32(bytes, 28));
    return rigcal_store_load(&m, 1, &info, bytes, sizeof bytes) == RIGCAL_OK;
}

static void gate_store(void)
{
    edge("store.correlation", is_stored, ANY_OF(2.3e-16, 1.2e-7), 0.1);
    edge("store.float_rotation", float_rotation_is_taken, 1e-7, 0.1);
}

/* ---- stack ---------------------------------------------------------------- */

enum { PAINTED = 48 * 1024 };

__attribute__((noinline)) static long stack_of(void (*call)(void), int is_painting)
{
    volatile unsigned char painted[PAINTED];
    volatile unsigned char *volatile area =
        painted; /* the sanitizer does not know that it was painted */
    if (is_painting) {
        for (size_t i = 0; i < PAINTED; i++) {
            area[i] = 0xa5;
        }
        return 0;
    }
    size_t clean = 0;
    while (clean < PAINTED && area[clean] == 0xa5) {
        clean++;
    }
    (void)call;
    return (long)(PAINTED - clean);
}

static rigcal_pose_solver solver_kept;

static void call_pose(void)
{
    rigcal_pose pose;
    size_t n_found;
    int32_t at_fault;
    const rigcal_view view = {&probed.camera, probed.o, NULL, (size_t)probed.n};
    if (rigcal_pose_begin(&solver_kept, &at_fault, &view, NULL) == RIGCAL_OK) {
        rigcal_pose_step(&solver_kept, INT32_MAX);
        rigcal_pose_result(&pose, 1, &n_found, &at_fault, &solver_kept);
    }
}

static void call_diagnose(void)
{
    rigcal_diagnosis d;
    const rigcal_view view = {&probed.camera, probed.o, NULL, (size_t)probed.n};
    rigcal_pose_diagnose(&d, NULL, &view, NULL);
}

static void measure_stack(const char *name, void (*call)(void))
{
    call(); /* what is linked at first use does not belong to the library */
    stack_of(call, 1);
    call();
    line(name, "%ld", stack_of(call, 0));
}

static void gate_memory(void)
{
    state = 2000;
    random_scene(&probed, 12, GENERAL, BROWN, 0.3, 3, 3.1);
    line("size.pose_solver", "%ld", (long)sizeof(rigcal_pose_solver));
    line("size.robust_solver", "%ld", (long)sizeof(rigcal_robust_solver));
    line("size.paper_solver", "%ld", (long)sizeof(rigcal_paper_solver));
    measure_stack("stack.pose", call_pose);
    measure_stack("stack.diagnose", call_diagnose);
}

/* ---- alarm ----------------------------------------------------------------- */

enum { ALARM_BODIES = 3 };

static rc_alarm alarm;
static rigcal_real alarm_bodies[ALARM_BODIES * RC_ALARM_BODY];

/* Adds a row of two random bodies. The third body has rows until `blind`. size: how much
 * information a row has. */
static void alarm_row(int is_blind, double size, double shift)
{
    const size_t a = is_blind ? 0 : (size_t)uniform(0, ALARM_BODIES);
    const size_t b = is_blind ? 1 : (a + 1 + (size_t)uniform(0, 2)) % ALARM_BODIES;
    rigcal_real h[2][6];
    double z = 1.2 * normal();
    for (int k = 0; k < 12; k++) {
        h[k / 6][k % 6] = (rigcal_real)(size * normal() * (k % 6 == 1 ? 0.02 : 1));
    }
    z += shift * (double)h[0][0] / size;
    rc_alarm_row(&alarm, alarm_bodies, (rigcal_real)z, 1, a, h[0], b, h[1]);
}

/* Runs frames of n rows: counts alarms, the evidence at some frames, and blind bodies. */
static void alarm_run(const char *name, int frames, int n, double common, double size)
{
    tally t;
    char counter[64];
    double sum = 0;
    begin(&t, name);
    rc_alarm_begin(&alarm, alarm_bodies, ALARM_BODIES, 200, (rigcal_real)common, RC(0.05),
                   RC(0.02));
    for (int f = 0; f < frames; f++) {
        for (int i = 0; i < n; i++) {
            alarm_row(f > frames / 2, size, f % 1000 > 900 ? 0.3 : 0);
        }
        const double evidence = (double)rc_alarm_frame(&alarm, alarm_bodies);
        sum += evidence > -9 ? evidence + 9 : 0;
        t.misses += rc_alarm_is_blind(alarm_bodies, 2);
        if (evidence >= 0) {
            t.found++;
            rc_alarm_again(&alarm, alarm_bodies);
        }
    }
    end(&t);
    snprintf(counter, sizeof counter, "%s.evidence", name);
    line(counter, "%.4g", sum);
    snprintf(counter, sizeof counter, "%s.smallest", name);
    line(counter, "%.3g", (double)rc_alarm_smallest(&alarm, alarm_bodies, 0));
    snprintf(counter, sizeof counter, "%s.noise", name);
    line(counter, "%.5g", (double)rc_alarm_noise(&alarm));
}

/* A frame of one body with 60 rows in each of several directions. size: information of a
 * row. */
static double alarm_frame_of(int n, const double direction[][6], double size)
{
    const rigcal_real none[6] = {0};
    for (int i = 0; i < 60 * n; i++) {
        rigcal_real h[6];
        for (int k = 0; k < 6; k++) {
            h[k] = (rigcal_real)(size * direction[i % n][k]);
        }
        rc_alarm_row(&alarm, alarm_bodies, 2, 1, 0, h, 1, none);
    }
    return (double)rc_alarm_frame(&alarm, alarm_bodies);
}

/* Whether rows of one direction count as one: across it only the expected part is left. */
static int rows_are_one(double size)
{
    static const double ASKEW[1][6] = {{1, 1}};
    rc_alarm_begin(&alarm, alarm_bodies, 2, 200, 0, 1, 1);
    return alarm_frame_of(1, ASKEW, size) > -50;
}

/* Whether the second frame is evidence, if its rows have as much information as those of
 * the first. */
static int rows_are_within_range(double size)
{
    static const double AXES[6][6] = {{1},          {0, 1},          {0, 0, 1},
                                      {0, 0, 0, 1}, {0, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 1}};
    rc_alarm_begin(&alarm, alarm_bodies, 2, 200, 0, 1, 1);
    (void)alarm_frame_of(6, AXES, size);
    return alarm_frame_of(6, AXES, size) > 120;
}

static void gate_alarm(void)
{
    state = 3100;
    alarm_run("alarm.few", 3000, 3, 0, 500);
    alarm_run("alarm.common", 3000, 20, 0.5, 500);
    alarm_run("alarm.many", 1500, 60, 0, 1e7);
    rc_alarm_begin(&alarm, alarm_bodies, ALARM_BODIES, 200, 0, 1, 1);
    line("alarm.nothing", "%.4g", (double)rc_alarm_frame(&alarm, alarm_bodies));
    edge("alarm.rank", rows_are_one, 1, 1e12);
    edge("alarm.largest", rows_are_within_range, 1e3, ANY_OF(1e70, 1e14));
    line("log", "%.6g", (double)rc_log(RC(3.7e-20)));
    line("exp", "%.4g", (double)rc_exp(-1000));
    line("exp.series", "%.4g", (double)rc_exp(RC(61.7)));
}

/* ---- monitor ----------------------------------------------------------------- */

enum { WATCHED = 3, WATCHED_FREE = 6 * (WATCHED - 1) };

static struct {
    rigcal_mounted_camera cameras[WATCHED];
    int32_t group[WATCHED];
    uint8_t held[WATCHED];
    rigcal_real Sigma[RIGCAL_CALIBRATED_SIZE(WATCHED - 1)];
    rigcal_calibrated_rig rig;
    rigcal_monitor_options options;
    rigcal_real monitor[RIGCAL_MONITOR_SIZE(WATCHED, 1)];
    double turned; /* turn of camera 1, rad */
} watched;

static rigcal_status watched_begin(void)
{
    return rigcal_monitor_begin(watched.monitor, RIGCAL_MONITOR_SIZE(WATCHED, 1),
                                &watched.rig, 1, &watched.options);
}

static void set_watched(void)
{
    memset(&watched, 0, sizeof watched);
    for (int c = 0; c < WATCHED; c++) {
        const double q[4] = {1, 0.01 * c, 0.1 * c, 0.02};
        double R[9];
        rigcal_mounted_camera *const m = &watched.cameras[c];
        rotation_of(R, q);
        for (int k = 0; k < 9; k++) {
            m->cam_from_rig.R[k] = (rigcal_real)R[k];
        }
        m->cam_from_rig.t[0] = (rigcal_real)(-0.5 * c);
        m->cam_from_rig.t[1] = (rigcal_real)(0.1 * (c % 2));
        m->camera.width = m->camera.height = 800;
        m->camera.fx = m->camera.fy = 800;
        m->camera.cx = m->camera.cy = 400;
        watched.held[c] = c == 0;
    }
    for (size_t i = 0; i < WATCHED_FREE; i++) {
        watched.Sigma[i * (i + 3) / 2] = (rigcal_real)(i % 6 < 3 ? 1e-6 : 4e-6);
    }
    const rigcal_calibrated_rig rig = {watched.cameras,
                                       watched.group,
                                       watched.held,
                                       WATCHED,
                                       watched.Sigma,
                                       sizeof watched.Sigma / sizeof watched.Sigma[0],
                                       WATCHED,
                                       RC(0.3),
                                       0,
                                       0,
                                       0};
    watched.rig = rig;
    (void)rigcal_monitor_defaults(&watched.options);
    watched.options.arl0_frames = 1000;
}

/* The ray of a point in a camera, with noise of 0.3 px. */
static void watched_ray(rigcal_real ray[3], int c, const double X[3])
{
    double p[3];
    for (int i = 0; i < 3; i++) {
        const rigcal_transform *const T = &watched.cameras[c].cam_from_rig;
        p[i] = (double)T->R[3 * i] * X[0] + (double)T->R[3 * i + 1] * X[1] +
               (double)T->R[3 * i + 2] * X[2] + (double)T->t[i];
    }
    ray[0] = (rigcal_real)(p[0] / p[2] + 3.75e-4 * normal());
    ray[1] =
        (rigcal_real)(p[1] / p[2] + 3.75e-4 * normal() + (c == 1 ? watched.turned : 0));
    ray[2] = 1;
}

/* A frame of n matches, one in ten of which is wrong. */
static rigcal_monitor_report watched_frame(tally *t, int n)
{
    rigcal_monitor_report report;
    for (int i = 0; i < n; i++) {
        const double X[3] = {uniform(-1, 1), uniform(-1, 1), uniform(3, 5)};
        const int a = (int)uniform(0, WATCHED);
        const int b = (a + 1 + (int)uniform(0, WATCHED - 1)) % WATCHED;
        rigcal_real ray_a[3], ray_b[3];
        watched_ray(ray_a, a, X);
        watched_ray(ray_b, b, X);
        ray_b[1] += (rigcal_real)(uniform(0, 1) < 0.1 ? uniform(-0.05, 0.05) : 0);
        (void)count(t, rigcal_monitor_match_rays(watched.monitor, (size_t)a, ray_a,
                                                 (size_t)b, ray_b, RC(0.3)));
    }
    (void)rigcal_monitor_frame(&report, watched.monitor, RC(0.03));
    t->found += report.alarm;
    return report;
}

/* Counts where the cameras are, and how accurately that is known. */
static void watched_lines(const char *name)
{
    double sum = 0, variance = 0;
    char counter[64];
    rigcal_mounted_camera m;
    for (size_t c = 0; c < WATCHED; c++) {
        (void)rigcal_monitor_camera(&m, watched.monitor, c);
        for (int k = 0; k < 9; k++) {
            sum += (double)m.cam_from_rig.R[k];
        }
        for (int k = 0; k < 3; k++) {
            sum += (double)m.cam_from_rig.t[k];
        }
        for (int k = 0; k < 36; k += 7) {
            variance += (double)m.Sigma[k];
        }
    }
    snprintf(counter, sizeof counter, "%s.poses", name);
    line(counter, "%.5g", sum);
    snprintf(counter, sizeof counter, "%s.variance", name);
    line(counter, "%.3g", variance);
}

/* A rig at rest, a bump, its alarm, and the answer. */
static void watched_run(const char *name, double wrong, double turned)
{
    rigcal_monitor_report report;
    rigcal_body_report body;
    char counter[64];
    tally t;
    begin(&t, name);
    set_watched();
    watched.options.wrong = (rigcal_real)wrong;
    watched.options.walk_rad = RC(1e-5);
    (void)watched_begin();
    for (int f = 0; f < 40; f++) {
        (void)watched_frame(&t, 20);
    }
    watched.turned = turned;
    do {
        report = watched_frame(&t, 20);
    } while (report.frames_since < 2 && report.frames < 100);
    (void)rigcal_monitor_body(&body, watched.monitor, 2);
    snprintf(counter, sizeof counter, "%s.blame", name);
    line(counter, "%.3g", (double)body.blame);
    (void)rigcal_monitor_moved(watched.monitor, (size_t)report.body);
    for (int f = 0; f < 3; f++) {
        report = watched_frame(&t, 20);
    }
    t.misses = (long)report.doubted;
    end(&t);
    watched_lines(name);
    (void)rigcal_monitor_moved(watched.monitor, 2);
    watched.turned = 0;
    (void)watched_frame(&t, 1); /* this is a row of a body that is open */
    snprintf(counter, sizeof counter, "%s.opened", name);
    watched_lines(counter);
}

/* A target gets its place, is seen again, and is removed. */
static void watched_target(void)
{
    rigcal_observation seen[8];
    tally t;
    begin(&t, "monitor.target");
    set_watched();
    (void)watched_begin();
    for (size_t c = 0; c < WATCHED; c++) {
        for (int i = 0; i < 8; i++) {
            const double X[3] = {i % 2 - 0.5, i / 2 % 2 - 0.5, 3 + 0.3 * (i / 4)};
            rigcal_real ray[3];
            watched_ray(ray, (int)c, X);
            for (int k = 0; k < 3; k++) {
                seen[i].X_w[k] = (rigcal_real)(X[k] - (k == 2 ? 3 : 0));
            }
            seen[i].uv[0] = 800 * ray[0] + 400;
            seen[i].uv[1] = 800 * ray[1] + 400;
        }
        (void)count(&t, rigcal_monitor_view(watched.monitor, NULL, c, 0, seen, 8, RC(0.3)));
    }
    (void)rigcal_monitor_frame(NULL, watched.monitor, 1);
    end(&t);
    watched_lines("monitor.target");
}

static int holds_arl0(double x)
{
    watched.options.arl0_frames = (rigcal_real)x;
    return watched_begin() == RIGCAL_OK;
}

static int holds_arl0_least(double x)
{
    return holds_arl0(1 / x);
}

static int holds_wrong(double x)
{
    watched.options.wrong = (rigcal_real)x;
    return watched_begin() == RIGCAL_OK;
}

static int holds_move(double x)
{
    watched.options.move_rad = (rigcal_real)x;
    return watched_begin() == RIGCAL_OK;
}

static int holds_walk(double x)
{
    watched.options.walk_rad = (rigcal_real)x;
    return watched_begin() == RIGCAL_OK;
}

static int holds_correlation(double x)
{
    watched.Sigma[1] = watched.Sigma[0] * (rigcal_real)(1 + x);
    return watched_begin() == RIGCAL_OK;
}

static int holds_noise(double x)
{
    const rigcal_real a[3] = {0, 0, 1}, b[3] = {RC(-0.1), 0, 1};
    return rigcal_monitor_match_rays(watched.monitor, 0, a, 1, b, (rigcal_real)x) !=
           RIGCAL_ERR_RANGE;
}

static int holds_noise_least(double x)
{
    return holds_noise(1 / x);
}

static int holds_seconds(double x)
{
    return rigcal_monitor_frame(NULL, watched.monitor, (rigcal_real)x) == RIGCAL_OK;
}

/* A match at this angle from the line through both centres. */
static int off_line(double angle, double sigma_px)
{
    const rigcal_transform a = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    const rigcal_transform b = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 1}};
    const rigcal_real ray[3] = {(rigcal_real)angle, 0, 1};
    rc_row rows[2];
    rc_seen seen;
    memset(&seen, 0, sizeof seen);
    seen.n_rows = 1;
    seen.b = 1;
    for (int k = 0; k < 2; k++) {
        (void)rc_sight_of(&seen.sight[k], &watched.cameras[0].camera, ray,
                          (rigcal_real)sigma_px);
    }
    return rc_rows_of(rows, &seen, &a, &b) == RIGCAL_OK;
}

static int holds_off_noise(double x)
{
    return off_line(1 / x, 0.3);
}

static int holds_off_rounding(double x)
{
    return off_line(1 / x, ANY_OF(1e-14, 1e-6));
}

/* Whether the part of a turn that rounding leaves is kept. */
static int holds_left(double x)
{
    const rc_filter f = {2,    0,
                         6,    2,
                         0,    (rigcal_transform[2]){{{0}, {0}}, {{0}, {0}}},
                         NULL, (rigcal_real[6]){0},
                         NULL};
    f.poses[1] = watched.cameras[1].cam_from_rig;
    for (int k = 0; k < 3; k++) {
        f.d[k] = (rigcal_real)(x * (1 - 0.3 * k));
    }
    rc_filter_apply(&f, 1);
    return f.d[0] != 0 || f.d[1] != 0 || f.d[2] != 0;
}

static void watched_edges(void)
{
    set_watched();
    edge("monitor.arl0_most", holds_arl0, 1e3, 1e12);
    edge("monitor.arl0_least", holds_arl0_least, 1e-3, 1);
    set_watched();
    edge("monitor.wrong_most", holds_wrong, 0.1, 10);
    set_watched();
    edge("monitor.move_most", holds_move, 0.1, 10);
    set_watched();
    edge("monitor.walk_most", holds_walk, 0.1, 10);
    set_watched();
    watched.Sigma[2] = watched.Sigma[0];
    edge("monitor.correlation", holds_correlation, ANY_OF(1e-14, 1e-6), 1);
    set_watched();
    (void)watched_begin();
    edge("monitor.noise_most", holds_noise, 1, 1e9);
    edge("monitor.noise_least", holds_noise_least, 1, 1e9);
    edge("monitor.seconds_most", holds_seconds, 1, 1e9);
    edge("rows.noise", holds_off_noise, 1, 1e9);
    edge("rows.rounding", holds_off_rounding, 1, 1e20);
    edge("filter.left_turn", holds_left, ANY_OF(1e-7, 1e-4), 0.5);
}

/* The defaults, and numbers of the layers themselves. */
static void watched_numbers(void)
{
    rigcal_monitor_options o;
    rigcal_body_report body;
    rc_monitor m;
    rigcal_real P[3] = {1, 1, 1}, ray[3] = {1, 0, 1};
    rc_doubt doubt;
    rc_sight sight;
    set_watched();
    (void)rigcal_monitor_defaults(&o);
    line("monitor.arl0", "%.4g", (double)o.arl0_frames);
    line("monitor.common", "%.4g", (double)o.common);
    line("monitor.wrong", "%.4g", (double)o.wrong);
    line("monitor.move", "%.4g", (double)o.move_rad);
    watched.options.wrong = 0;
    watched.Sigma[0] = watched.Sigma[2] = watched.Sigma[5] = 0; /* no turn, so no lever */
    watched.Sigma[13] = RC(0.0003) * watched.Sigma[9];
    (void)watched_begin();
    (void)rigcal_monitor_moved(watched.monitor, 2);
    (void)rc_monitor_open(&m, watched.monitor);
    line("monitor.magic", "%lx", (unsigned long)m.top.head.magic);
    line("monitor.seal", "%lx", (unsigned long)m.top.head.head_seal);
    for (ray[0] = 1;
         rc_sight_of(&sight, &watched.cameras[0].camera, ray, 1) == RIGCAL_OK;) {
        ray[0] *= RC(1.5);
    }
    line("rows.tangent", "%.3g", (double)ray[0]);
    line("monitor.wrong_least", "%.4g", (double)m.top.head.wrong);
    line("monitor.lever", "%.4g", (double)(m.top.head.move_t / m.top.head.move_rad));
    line("monitor.settling", "%lu", (unsigned long)m.top.head.settling);
    (void)rigcal_monitor_body(&body, watched.monitor, 1);
    line("monitor.weakest", "%.3g", fabs((double)body.weakest[4]));
    rc_filter_factor(P, 2);
    line("filter.pivot", "%.3g", (double)P[0]);
    rc_filter_doubt(&doubt, 0, 1, RC(0.5));
    line("filter.likelihood", "%.4g", (double)doubt.likelihood);
    line("filter.beta", "%.4g", (double)doubt.beta);
    rc_alarm_begin(&m.top.head.alarm, m.bodies, 2, 1000, 0, 1, 1);
    m.bodies[RC_ALARM_BODY - 1] = 0;
    m.bodies[2 * RC_ALARM_BODY - 1] = -1000;
    m.filter.n_bodies = 2;
    rc_trial_begin(&m.filter, &m.top.head.alarm, m.bodies, 1, 1);
    line("trial.none", "%.4g", (double)rc_alarm_lent(m.bodies, 1)[RC_TRIAL_LOG]);
}

static void gate_monitor(void)
{
    state = 3200;
    watched_run("monitor.small", 0.1, 3e-4);
    watched_run("monitor.large", 0.3, 0.02);
    watched_run("monitor.trusting", 0, 1e-3);
    watched_target();
    watched_edges();
    watched_numbers();
}

/* ---- all of them ---------------------------------------------------------- */

/* ---- bands, candidates, spans ----------------------------------------------- */

/* A Brown lens, every third time a fisheye, of 160 x 120 pixels. */
static void set_match_camera(rigcal_camera *c, int n)
{
    memset(c, 0, sizeof *c);
    c->width = 160;
    c->height = 120;
    c->fx = c->fy = (rigcal_real)uniform(90, 200);
    c->cx = 80;
    c->cy = 60;
    c->k1 = (rigcal_real)uniform(-0.3, 0.1);
    if (n % 3 == 2) {
        c->lens = RIGCAL_LENS_FISHEYE;
    } else {
        c->p1 = (rigcal_real)uniform(-2e-3, 2e-3);
    }
}

static void set_match_pair(rigcal_match_pair *pair, const rigcal_camera cameras[2], int n)
{
    rigcal_real q[4] = {1, 0, 0, 0};
    memset(pair, 0, sizeof *pair);
    pair->camera_a = &cameras[0];
    pair->camera_b = &cameras[1];
    for (int i = 0; i < 3; i++) {
        q[1 + i] = (rigcal_real)uniform(-0.2, 0.2);
        pair->b_from_a.t[i] = (rigcal_real)uniform(-1, 1);
        pair->Sigma[7 * i] = (rigcal_real)uniform(1e-6, 1e-4);
        pair->Sigma[7 * i + 21] = (rigcal_real)uniform(1e-6, 1e-4);
    }
    (void)rigcal_rotation_from_quaternion(pair->b_from_a.R, q);
    pair->sigma_a = pair->sigma_b = (rigcal_real)uniform(0.1, 1);
    (void)rigcal_match_k(&pair->k, (rigcal_real)uniform(0.5, 0.999), 1 + n % 2);
    pair->near_a = (rigcal_real)(n % 4 ? uniform(0.5, 3) : 0);
}

static void gate_matching(void)
{
    static rigcal_spans_solver solver;
    static rigcal_span spans[600];
    unsigned long made[4] = {0}, tested[6] = {0}, inside = 0, units = 0, rows = 0,
                  pixels = 0;
    unsigned long arcs = 0, direct = 0, places = 0;
    tally t;
    begin(&t, "match");
    state = 171;
    for (int n = 0; n < 240; n++) {
        rigcal_camera cameras[2];
        rigcal_match_pair pair;
        rigcal_band band;
        rigcal_band_point points[8];
        size_t found = 0;
        rigcal_real uv[2];
        set_match_camera(&cameras[0], n);
        set_match_camera(&cameras[1], n);
        set_match_pair(&pair, cameras, n);
        uv[0] = (rigcal_real)uniform(0, 159);
        uv[1] = (rigcal_real)uniform(0, 119);
        const rigcal_status status = rigcal_band_make(&band, &pair, uv);
        made[status == RIGCAL_OK ? 0 : status == RIGCAL_ERR_EPIPOLE ? 1 : 2]++;
        if (status != RIGCAL_OK) {
            continue;
        }
        for (int i = 0; i < 60; i++) {
            rigcal_match match;
            uv[0] = (rigcal_real)uniform(0, 159);
            uv[1] = (rigcal_real)uniform(0, 119);
            const rigcal_status told = rigcal_band_test(&match, &band, uv);
            tested[told == RIGCAL_OK            ? 0
                   : told == RIGCAL_ERR_EPIPOLE ? 1
                   : told == RIGCAL_ERR_BEHIND  ? 2
                                                : 3]++;
            inside += told == RIGCAL_OK && match.is_inside;
        }
        if (rigcal_band_curve(points, 8, &found, &band) == RIGCAL_OK) {
            places += found;
        }
        if (rigcal_spans_begin(&solver, &band) != RIGCAL_OK) {
            continue;
        }
        do {
            units++;
        } while (rigcal_spans_step(&solver, 1) == RIGCAL_RUNNING);
        if (rigcal_spans_result(spans, 600, &found, &solver) == RIGCAL_OK) {
            rows += found;
            for (size_t k = 0; k < found; k++) {
                pixels += (unsigned long)(spans[k].last - spans[k].first + 1);
            }
        }
        arcs += (unsigned long)solver.outline.n_arcs;
        for (int32_t k = 0; k < solver.outline.n_arcs; k++) {
            direct += (unsigned long)solver.outline.arcs[k].is_direct;
        }
    }
    end(&t);
    line("match.made", "%lu", made[0]);
    line("match.epipole_a", "%lu", made[1]);
    line("match.no_ray", "%lu", made[2]);
    line("match.tested", "%lu", tested[0]);
    line("match.epipole_b", "%lu", tested[1]);
    line("match.behind", "%lu", tested[2]);
    line("match.refused", "%lu", tested[3]);
    line("match.inside", "%lu", inside);
    line("match.places", "%lu", places);
    line("spans.units", "%lu", units);
    line("spans.arcs", "%lu", arcs);
    line("spans.direct", "%lu", direct);
    line("spans.rows", "%lu", rows);
    line("spans.pixels", "%lu", pixels);
}

/* Borders in large images of lenses with strong distortion: some have many arcs. */
static void gate_long_borders(void)
{
    static rigcal_spans_solver solver;
    unsigned long units = 0, arcs = 0;
    state = 172;
    for (int n = 0; n < 60; n++) {
        rigcal_camera cameras[2];
        rigcal_match_pair pair;
        rigcal_band band;
        rigcal_real uv[2];
        set_match_camera(&cameras[0], 0);
        cameras[1] = camera_of(PINHOLE, uniform(2000, 6000));
        cameras[1].width = 8000;
        cameras[1].height = 6000;
        cameras[1].cx = 4000;
        cameras[1].cy = 3000;
        cameras[1].k1 = RC(uniform(-0.3, 0.3));
        cameras[1].k2 = RC(uniform(-0.3, 0.3));
        cameras[1].k3 = RC(uniform(-0.2, 0.2));
        cameras[1].p1 = RC(uniform(-0.02, 0.02));
        set_match_pair(&pair, cameras, n);
        uv[0] = RC(uniform(0, 159));
        uv[1] = RC(uniform(0, 119));
        if (rigcal_band_make(&band, &pair, uv) == RIGCAL_OK &&
            rigcal_spans_begin(&solver, &band) == RIGCAL_OK) {
            do {
                units++;
            } while (rigcal_spans_step(&solver, 1) == RIGCAL_RUNNING);
            arcs += (unsigned long)solver.outline.n_arcs;
        }
    }
    line("spans.long.units", "%lu", units);
    line("spans.long.arcs", "%lu", arcs);
}

/* Bands up to half a focal length wide, whose borders leave the image and fold. */
static void gate_wide_bands(void)
{
    static rigcal_spans_solver solver;
    static rigcal_span spans[600];
    unsigned long units = 0, arcs = 0, rows = 0, pixels = 0;
    state = 173;
    for (int n = 0; n < 240; n++) {
        rigcal_camera cameras[2];
        rigcal_match_pair pair;
        rigcal_band band;
        size_t found = 0;
        rigcal_real uv[2];
        set_match_camera(&cameras[0], 0);
        set_match_camera(&cameras[1], n);
        set_match_pair(&pair, cameras, n);
        pair.sigma_b = RC(uniform(0.01, 0.5)) * cameras[1].fx / pair.k;
        uv[0] = RC(uniform(0, 159));
        uv[1] = RC(uniform(0, 119));
        if (rigcal_band_make(&band, &pair, uv) != RIGCAL_OK ||
            rigcal_spans_begin(&solver, &band) != RIGCAL_OK) {
            continue;
        }
        do {
            units++;
        } while (rigcal_spans_step(&solver, 1) == RIGCAL_RUNNING);
        arcs += (unsigned long)solver.outline.n_arcs;
        if (rigcal_spans_result(spans, 600, &found, &solver) == RIGCAL_OK) {
            rows += found;
            for (size_t k = 0; k < found; k++) {
                pixels += (unsigned long)(spans[k].last - spans[k].first + 1);
            }
        }
    }
    line("spans.wide.units", "%lu", units);
    line("spans.wide.arcs", "%lu", arcs);
    line("spans.wide.rows", "%lu", rows);
    line("spans.wide.pixels", "%lu", pixels);
}

/* Two cameras side by side with exact intrinsics and poses. */
static rigcal_camera pinholes[2];
static rigcal_match_pair pair_probed;

static void begin_pair(void)
{
    memset(&pair_probed, 0, sizeof pair_probed);
    for (int c = 0; c < 2; c++) {
        pinholes[c] = camera_of(PINHOLE, 800);
    }
    pair_probed.camera_a = &pinholes[0];
    pair_probed.camera_b = &pinholes[1];
    pair_probed.b_from_a = identity();
    pair_probed.b_from_a.t[0] = -1;
    pair_probed.sigma_b = 1;
    pair_probed.k = 3;
}

static int band_is_made(void)
{
    const rigcal_real uv[2] = {pinholes[0].cx, pinholes[0].cy};
    rigcal_band band;
    return rigcal_band_make(&band, &pair_probed, uv) == RIGCAL_OK;
}

static int band_takes_noise(double sigma)
{
    pair_probed.sigma_b = RC(sigma);
    return band_is_made();
}

static int band_takes_k(double k)
{
    pair_probed.k = RC(k);
    return band_is_made();
}

/* Tests the ray (x, y, 1) of b, which turns by `turn` a pixel, against the band of (0, 0,
 * 1). */
static rigcal_status band_told(double x, double y, double turn)
{
    const rigcal_real uv[2] = {pinholes[0].cx, pinholes[0].cy};
    const rigcal_real m[3] = {RC(x), RC(y), 1};
    rigcal_band band;
    rigcal_match match;
    rigcal_ray ray = {{0, 0, 0}, {RC(turn), 0, 0, RC(turn), 0, 0}};
    (void)rc_vec3_unit(ray.m, m);
    const rigcal_status status = rigcal_band_make(&band, &pair_probed, uv);
    return status == RIGCAL_OK ? rigcal_band_test_ray(&match, &band, &ray) : status;
}

static int rays_are_parallel(double x)
{
    return band_told(-x, 0, 1. / 800) == RIGCAL_ERR_PARALLEL;
}

static int ray_is_near_enough(double pixels)
{
    return band_told(-0.1, 0.1, 0.1 / pixels) == RIGCAL_OK;
}

static int match_k_is_given(double probability)
{
    rigcal_real k;
    return rigcal_match_k(&k, RC(probability), RIGCAL_MATCH_SEARCH) == RIGCAL_OK;
}

static int probability_is_seldom(double one_in)
{
    return match_k_is_given(1 / one_in);
}

static int probability_is_not_all(double one_in)
{
    return match_k_is_given(1 - 1 / one_in);
}

static int baseline_is_ahead(double aside)
{
    rigcal_rectified r;
    begin_pair();
    pair_probed.b_from_a.t[0] = RC(-aside);
    pair_probed.b_from_a.t[2] = -1;
    return rigcal_rectify(&r, &pinholes[0], &pinholes[1], &pair_probed.b_from_a) ==
           RIGCAL_ERR_EPIPOLE;
}

static void gate_bands(void)
{
    begin_pair();
    edge("band.noise_most", band_takes_noise, 1, 1e12);
    begin_pair();
    edge("band.k_most", band_takes_k, 1, 1e6);
    begin_pair();
    edge("band.parallel", rays_are_parallel, ANY_OF(1e-20, 1e-12), 0.1);
    edge("band.width_px", ray_is_near_enough, 1, ANY_OF(1e20, 1e15));
    edge("band.one_in", probability_is_seldom, 2, 1e9);
    edge("band.all_but_one_in", probability_is_not_all, 2, 1e7);
    edge("rectify.aside", baseline_is_ahead, 1e-3, 10);
}

/* ---- outlines --------------------------------------------------------------- */

static rigcal_outline outline_probed;

/* A border from row v[0] to row v[4]. */
static void outline_add(const double u[5], const double v[5])
{
    rigcal_real by_u[5], by_v[5];
    for (int i = 0; i < 5; i++) {
        by_u[i] = RC(u[i]);
        by_v[i] = RC(v[i]);
    }
    rc_outline_add(&outline_probed, by_u, by_v);
}

/* Whether a strip of columns that ends this far left of the image is seen. */
static int strip_is_seen(double beside)
{
    const double left[5] = {-9, -9, -9, -9, -9}, down[5] = {0, 4, 8, 12, 16};
    const double right[5] = {-beside, -beside, -beside, -beside, -beside};
    rigcal_span spans[RIGCAL_SPANS_ROW];
    rc_outline_begin(&outline_probed, 100);
    outline_add(left, down);
    outline_add(right, down);
    rc_outline_close(&outline_probed);
    return rc_outline_row(spans, &outline_probed, 5, 100) > 0;
}

/* A border that hardly leaves row 5. There a step of Newton's method gains only a
 * quarter. */
static long level_crossing(void)
{
    const double left[5] = {0, 0, 0, 0, 0};
    double right[5], down[5];
    rigcal_span spans[RIGCAL_SPANS_ROW];
    for (int i = 0; i < 5; i++) {
        right[i] = 1e6 * i;
        down[i] = 5 - 1e-13 + i * i * i * i;
    }
    rc_outline_begin(&outline_probed, 100);
    outline_add(left, down);
    outline_add(right, down);
    rc_outline_close(&outline_probed);
    return rc_outline_row(spans, &outline_probed, 5, 1000000) > 0 ? (long)spans[0].last
                                                                  : -1;
}

static void gate_outlines(void)
{
    const double right[5] = {0, 10, 20, 30, 40}, down[5] = {0, 5, 20, 45, 80};
    edge("outline.beside", strip_is_seen, ANY_OF(1e-9, 1e-6), 1);
    line("outline.level", "%ld", level_crossing());
    rc_outline_begin(&outline_probed, 100);
    for (int i = 0; i < 60; i++) {
        outline_add(right, down);
    }
    line("outline.parts", "%ld", (long)outline_probed.n_arcs);
}

/* ---- a third camera --------------------------------------------------------- */

static const size_t WATCHED_ABC[3] = {0, 1, 2};

/* The transfer of a point whose pixel in b is off by this many pixels. */
static rigcal_status transfer_of(rigcal_transfer *out, double off)
{
    const double X[3] = {0.2, -0.1, 4};
    const rigcal_real sigma[2] = {RC(0.3), RC(0.3)};
    rigcal_real uv[2][2];
    for (int c = 0; c < 2; c++) {
        double p[3];
        for (int i = 0; i < 3; i++) {
            const rigcal_transform *const T = &watched.cameras[c].cam_from_rig;
            p[i] = (double)T->R[3 * i] * X[0] + (double)T->R[3 * i + 1] * X[1] +
                   (double)T->R[3 * i + 2] * X[2] + (double)T->t[i];
        }
        uv[c][0] = RC(400 + 800 * p[0] / p[2]);
        uv[c][1] = RC(400 + 800 * p[1] / p[2] + (c == 1 ? off : 0));
    }
    return rigcal_transfer_make(out, &watched.rig, WATCHED_ABC, uv[0], uv[1], sigma);
}

static int miss_is_rounding(double off)
{
    rigcal_transfer out;
    return transfer_of(&out, off) == RIGCAL_OK && !(out.chi2 > 0);
}

/* A covariance that is nearly of rank one. */
static int covariance_is_none(double across)
{
    rigcal_transfer out;
    const rigcal_real at[2] = {0, 0};
    rigcal_real chi2;
    memset(&out, 0, sizeof out);
    out.Sigma[0] = out.Sigma[3] = 1;
    out.Sigma[1] = out.Sigma[2] = RC(1) - RC(across);
    return rigcal_transfer_test(&chi2, &out, 0, at) == RIGCAL_ERR_DEGENERATE;
}

static void gate_transfers(void)
{
    rigcal_transfer out;
    set_watched();
    edge("transfer.miss_px", miss_is_rounding, ANY_OF(1e-12, 1e-4), 1);
    edge("transfer.rank", covariance_is_none, ANY_OF(1.2e-16, 6e-8), 0.1);
    for (int k = 0; k < 3; k++) {
        static const double OFF[3] = {1, 30, 150};
        char name[32];
        snprintf(name, sizeof name, "transfer.off_%.0f_px", OFF[k]);
        (void)transfer_of(&out, OFF[k]);
        line(name, ANY_OF("%.12g", "%.5g"), (double)out.X[2]);
    }
}

/* ---- clocks ----------------------------------------------------------------- */

/* The rig of rig_probed with a clock for each camera. */
static rigcal_rig_clocks clocks_probed;
static rigcal_real clock_times[RIG_PLACEMENTS], clock_instants[RIG_PLACEMENTS],
    clock_offsets[RIG_CAMERAS], clock_drifts[RIG_CAMERAS],
    clock_work[RIGCAL_JUDGE_WORK(RIG_CAMERAS, RIG_PLACEMENTS) +
               RIGCAL_CLOCKS_WORK(RIG_CAMERAS, RIG_CAMERAS)];
static int32_t clock_states[RIG_CAMERAS];

/* Placements `step` apart in time, from `first` on. */
static void begin_clocks(rig_scene *r, double first, double step)
{
    (void)rigcal_clocks_defaults(&clocks_probed);
    for (int f = 0; f < RIG_PLACEMENTS; f++) {
        clock_times[f] = clock_instants[f] = RC(first + step * f);
    }
    for (int c = 0; c < RIG_CAMERAS; c++) {
        clock_offsets[c] = clock_drifts[c] = 0;
    }
    clocks_probed.times = clock_times;
    clocks_probed.instants = clock_instants;
    clocks_probed.offsets = clock_offsets;
    clocks_probed.drifts = clock_drifts;
    clocks_probed.states = clock_states;
    clocks_probed.free_offsets = 1;
    r->rig.clocks = &clocks_probed;
    r->rig.work = clock_work;
    r->rig.work_capacity = sizeof clock_work / sizeof clock_work[0];
}

/* A board that moves, seen by cameras of which c is late by `late` times c. */
static void moving_rig(rig_scene *r, int n_cameras, double speed, double late,
                       double sigma_px)
{
    scene placed;
    rig_begin(r, (size_t)n_cameras);
    begin_clocks(r, 0, 0.033);
    random_scene(&placed, 8, PLANAR, BROWN, sigma_px, 5, 8);
    for (int f = 0; f < RIG_PLACEMENTS; f++) {
        for (int c = 0; c < n_cameras; c++) {
            const double t = 0.033 * f + late * c;
            const double q[4] = {1, 0.1 * speed * t, 0.2 * speed * t * t, 0.1 * speed * t};
            const double shift[3] = {speed * t, speed * t * t, -0.5 * speed * t};
            double R[9];
            scene moved = placed;
            rotation_of(R, q);
            for (int i = 0; i < 9; i++) {
                moved.R[i] = 0;
                for (int k = 0; k < 3; k++) {
                    moved.R[i] += placed.R[i / 3 * 3 + k] * R[3 * k + i % 3];
                }
            }
            for (int k = 0; k < 3; k++) {
                moved.t[k] += shift[k];
            }
            (void)rig_add(r, c, f, &moved);
        }
    }
}

static int target_is_still(double speed)
{
    rigcal_rig_fit fit;
    state = 3300;
    moving_rig(&rig_probed, 2, speed, 0, 0.3);
    return rigcal_rig_join(&rig_probed.rig, NULL) == RIGCAL_OK &&
           rigcal_rig_adjust(&fit, NULL, &rig_probed.rig) >= 0 &&
           clock_states[1] == RIGCAL_CLOCK_STILL;
}

static int step_is_frame(double step)
{
    begin_clocks(&rig_probed, 0, step);
    (void)rc_times_check(&rig_probed.rig);
    return (double)clocks_probed.frame > 0.99 * step;
}

static int step_is_run(double frames)
{
    rigcal_motion motion;
    begin_clocks(&rig_probed, 0, frames);
    clocks_probed.frame = 1;
    rc_times_motion(&motion, &rig_probed.rig, rig_probed.placements, 2);
    return motion.n > 0;
}

static int times_are_exact(double first)
{
    begin_clocks(&rig_probed, first, 0.1 * first);
    clocks_probed.frame = RC(0.033);
    return rc_times_check(&rig_probed.rig) == RIGCAL_OK;
}

static int frames_are_taken(double frames)
{
    int32_t off[2];
    begin_clocks(&rig_probed, 0, 1);
    clocks_probed.frame = RC(0.5);
    clock_offsets[1] = RC(0.5 * frames);
    return rigcal_clocks_frames(off, &clocks_probed, 2) == RIGCAL_OK;
}

/* Whether a search counts as converged whose last step promised this many times the
 * negligible part. */
static int end_is_converged(double left)
{
    rigcal_rig_solver s;
    rigcal_rig_fit fit;
    state = 3300;
    moving_rig(&rig_probed, 2, 1, 0, 0.3);
    if (rigcal_rig_join(&rig_probed.rig, NULL) != RIGCAL_OK ||
        rigcal_rig_begin(&s, &rig_probed.rig) != RIGCAL_OK) {
        return 0;
    }
    while (rigcal_rig_step(&s, 1) == RIGCAL_RUNNING) {
        s.promised =
            s.phase == RC_RIG_SQUARING ? (rigcal_real)left * s.negligible : s.promised;
    }
    return rigcal_rig_result(&fit, NULL, &s) == RIGCAL_OK;
}

static void count_clocks(tally *t, int n_cameras, double late, const rigcal_rig_fit *fit)
{
    t->steps += fit->evals;
    for (int c = 1; c < n_cameras; c++) {
        t->found += clock_states[c] == RIGCAL_CLOCK_FREE;
        t->misses += fabs((double)clock_offsets[c] - late * c) > 0.002;
    }
}

static void gate_clocks(void)
{
    tally t;
    begin(&t, "clocks");
    state = 3200;
    for (int i = 0; i < 40; i++) {
        rigcal_rig_fit fit;
        const int n = 2 + i % 3;
        const double late = uniform(-0.01, 0.01), speed = uniform(0.05, 3);
        moving_rig(&rig_probed, n, speed, late, i % 4 ? 0.3 : 0);
        clocks_probed.free_drifts = i % 5 == 1;
        clocks_probed.sigma_time = i % 4 == 1 ? RC(0.002) : 0;
        if (rigcal_rig_join(&rig_probed.rig, NULL) == RIGCAL_OK &&
            count(&t, rigcal_rig_adjust(&fit, NULL, &rig_probed.rig)) >= 0) {
            count_clocks(&t, n, late, &fit);
        }
        if (i == 6) {
            line("clocks.offset", ANY_OF("%.12g", "%.7g"), (double)clock_offsets[1]);
        }
    }
    end(&t);
    edge("clocks.still", target_is_still, 1e-3, 10);
    edge("clocks.left", end_is_converged, 1, 1e6);
    rig_begin(&rig_probed, 2);
    edge("times.frame", step_is_frame, 0.05, 2);
    edge("times.run", step_is_run, 0.5, 10);
    edge("times.exact", times_are_exact, 1, 1e15);
    edge("times.frames", frames_are_taken, 1, 1e8);
    begin_clocks(&rig_probed, 0, 0.0331234);
    (void)rc_times_check(&rig_probed.rig);
    line("times.middle", "%.12g", (double)clocks_probed.frame);
}

/* ---- what is wrong with a rig ----------------------------------------------- */

/* The numbers 3000 and 100 views, 50 of which agree or not, with this F. */
static rc_common common_of_F(double F)
{
    const double own = 250;
    return (rc_common){
        (rigcal_real)(own * (1 + F * 300 / 2400)), (rigcal_real)own, 3000, 2700, 300, 2400};
}

static int F_is_noise(double F)
{
    const rc_common c = common_of_F(F);
    return !rc_F_disagrees(&c, (rigcal_real)F, 0);
}

/* Judges a set of faults. F is 4. The first of 10 faults leaves F_after and has the chance
 * p. A second one fits worse by `worse`. */
static rigcal_faults judged(double p, double worse)
{
    const rc_common c = common_of_F(4);
    rigcal_faults found = {0};
    rigcal_fault faults[2] = {{0}, {0}};
    for (int i = 0; i < 2; i++) {
        faults[i].is_seen = 1;
        faults[i].p = (rigcal_real)p;
        faults[i].bic = (rigcal_real)(-100 + i * worse);
    }
    found.n = 2;
    found.n_seen = 10;
    found.F = 4;
    rc_finding_judge(&found, faults, &c);
    return found;
}

static int fault_is_found(double p)
{
    return (judged(p, 0).bits & RIGCAL_FAULTS_NAMED) != 0;
}

static int faults_are_alike(double worse)
{
    return judged(0, worse).n_alike == 1;
}

/* Whether a fault that leaves this part of F - 1 = 3 explains the disagreement. */
static int fault_explains(double left)
{
    static const rigcal_real ONE[1] = {1};
    const rc_common c = common_of_F(4);
    const double own = 250;
    const rc_one_step step = {
        1, 1, ONE, ONE, ONE, ONE, (rigcal_real)(own * 3 * (1 - left) * 300 / 2400), 0};
    rigcal_fault fault = {0};
    rc_finding_of(&fault, &c, &step);
    return fault.explains;
}

static rigcal_faults with_residues(double pattern, double n, double along)
{
    const rc_common c = common_of_F(1);
    const double variance = 250. / 2400;
    const rc_residues r = {(rigcal_real)n,
                           (rigcal_real)(pattern * 2 * n * variance),
                           0,
                           (rigcal_real)(n / 2),
                           (rigcal_real)along,
                           1,
                           1};
    rigcal_faults found = {0};
    rc_finding_residues(&found, &r, &c);
    return found;
}

static int is_no_pattern(double pattern)
{
    return (with_residues(pattern, 1e6, 0).bits & RIGCAL_FAULTS_PATTERN) == 0;
}

static int is_too_few_for_a_pattern(double n)
{
    return (with_residues(0.2, n, 0).bits & RIGCAL_FAULTS_PATTERN) == 0;
}

static int is_not_along(double along)
{
    return (with_residues(0, 100, along).bits & RIGCAL_FAULTS_ALONG_MOTION) == 0;
}

/* The number of bytes of a fault's sentences. */
static size_t said(int kind, double value, double sigma)
{
    rigcal_faults found = {0};
    rigcal_fault fault = {0};
    const rigcal_faults_words words = {0};
    char text[1];
    size_t n = 0;
    found.verdict = RIGCAL_RIG_FOUND;
    found.bits = RIGCAL_FAULTS_NAMED;
    found.n = found.n_cameras = 1;
    found.F = 4;
    found.own_px = 1;
    fault.kind = kind;
    fault.n = fault.is_seen = 1;
    fault.value[0] = (rigcal_real)value;
    fault.sigma[0] = (rigcal_real)sigma;
    rigcal_faults_text(text, 1, &n, &found, &fault, &words);
    return n;
}

static int takes_two_digits(double sigma)
{
    return said(RIGCAL_FAULT_CENTRE, 8, sigma) > said(RIGCAL_FAULT_CENTRE, 8, 3);
}

/* The sigma of a fault that explains more than everything. */
static double sigma_of_all(void)
{
    static const rigcal_real ONE[1] = {1};
    const rc_common c = common_of_F(4);
    const rc_one_step step = {1, 1, ONE, ONE, ONE, ONE, 2 * c.sum, 0};
    rigcal_fault fault = {0};
    rc_finding_of(&fault, &c, &step);
    return (double)fault.sigma[0];
}

/* Whether this turn, in radian, is printed with a digit after the point. */
static int turn_takes_two_digits(double turn)
{
    return said(RIGCAL_FAULT_MOVED, turn, 0) > said(RIGCAL_FAULT_MOVED, 0.1, 0);
}

/* Tests the rig of rig_probed for faults. */
static rigcal_faults_solver faults_solver;
static rigcal_fault faults_probed[4];

static rigcal_faults faults_of(int kind, const uint8_t *breaks, int is_truncated)
{
    static rigcal_real room[RIGCAL_FAULTS_WORK(RIG_CAMERAS, RIG_CAMERAS)];
    rigcal_faults_options options = {0};
    rigcal_faults found = {0};
    options.kinds = RIGCAL_FAULTS_OF(kind);
    options.breaks = breaks;
    options.is_truncated = is_truncated;
    options.work = room;
    options.work_capacity = sizeof room / sizeof room[0];
    if (rigcal_faults_begin(&faults_solver, faults_probed, 4, &options, &rig_probed.rig) ==
        RIGCAL_OK) {
        (void)rigcal_faults_step(&faults_solver, INT32_MAX);
        (void)rigcal_faults_result(&found, NULL, &faults_solver);
    }
    return found;
}

/* Eight points of a target 5 ahead, x and y of each. */
static void place_eight(scene *s, double at[8][2], double sigma_px)
{
    static const double AHEAD[9] = {1, 0, 0, 0, -1, 0, 0, 0, -1};
    random_scene(s, 8, PLANAR, PINHOLE, sigma_px, 5, 5.1);
    memcpy(s->R, AHEAD, sizeof AHEAD);
    s->t[0] = s->t[1] = 0;
    s->t[2] = 5;
    for (int i = 0; i < 8; i++) {
        s->X[i][0] = at[i][0];
        s->X[i][1] = at[i][1];
    }
}

/* Adjusts three times. The equations are then those at the final poses. */
static int adjust_probed(void)
{
    rigcal_rig_fit fit;
    int is_adjusted = rigcal_rig_join(&rig_probed.rig, NULL) == RIGCAL_OK;
    for (int i = 0; i < 3; i++) {
        is_adjusted =
            is_adjusted && rigcal_rig_adjust(&fit, NULL, &rig_probed.rig) >= RIGCAL_OK;
    }
    return is_adjusted;
}

/* Points on three circles that are this far apart. Seen from straight ahead, k1, k2 and the
 * distance have the same effect. */
static int ring_hides_distortion(double apart)
{
    double at[8][2];
    scene s;
    for (int i = 0; i < 8; i++) {
        static const double CIRCLE[4][2] = {{1, 0}, {0.6, 0.8}, {0, 1}, {-0.8, 0.6}};
        const double r = (1 + i % 3 * apart) * (i < 4 ? 1 : -1);
        at[i][0] = r * CIRCLE[i % 4][0];
        at[i][1] = r * CIRCLE[i % 4][1];
    }
    state = 3400;
    place_eight(&s, at, 0);
    rig_begin(&rig_probed, 1);
    (void)rig_add(&rig_probed, 0, 0, &s);
    return adjust_probed() && faults_of(RIGCAL_FAULT_DISTORTION, NULL, 0).n_seen == 0;
}

/* Cameras 0 and 1 at placements 0 and 1. The points of placement 0 have this many times the
 * noise. Whether a move of camera 1 between the two is seen. */
static int move_is_seen(double noise)
{
    static const uint8_t BREAKS[RIG_PLACEMENTS] = {0, 1};
    rig_begin(&rig_probed, 2);
    state = 3410;
    for (int f = 0; f < 2; f++) {
        scene s;
        random_scene(&s, 8, GENERAL, PINHOLE, 0.3, 5, 6);
        for (int c = 0; c < 2; c++) {
            (void)rig_add(&rig_probed, c, f, &s);
        }
    }
    for (size_t k = 0; k < rig_probed.rig.n_views; k++) {
        scene *const s = &rig_probed.seen[k];
        for (int i = 0; i < s->n; i++) {
            s->sigma[i] = RC(rig_probed.views[k].placement == 0 ? noise : 1);
        }
        rig_probed.views[k].view.sigma = s->sigma;
        (void)rigcal_view_pose_make(&rig_probed.own[k], &rig_probed.views[k],
                                    &s->options.start);
    }
    return adjust_probed() && faults_of(RIGCAL_FAULT_MOVED, BREAKS, 0).n_seen > 0;
}

/* Whether a point counts that is off by this many sigma, in four exact views. */
static int point_counts(double off)
{
    rig_begin(&rig_probed, 2);
    state = 3420;
    for (int f = 0; f < 2; f++) {
        scene s;
        random_scene(&s, 8, GENERAL, PINHOLE, 0, 5, 6);
        for (int c = 0; c < 2; c++) {
            (void)rig_add(&rig_probed, c, f, &s);
        }
    }
    rig_probed.rig.sigma_px = RC(0.3);
    if (!adjust_probed()) {
        return 0;
    }
    rig_probed.seen[1].o[3].uv[0] += RC(0.3 * off);
    (void)faults_of(RIGCAL_FAULT_FOCAL, NULL, 1);
    return faults_solver.n_points == 32;
}

/* Whether a point counts as a neighbour of the last corner of a square, at this many sides
 * from it. */
static int step_is_to_a_neighbour(double step)
{
    double at[8][2] = {{0, 0}, {0.1, 0}, {0.1, 0.1}, {0, 0.1}, {0, 0.1 + 0.1 * step}};
    scene s;
    state = 3430;
    place_eight(&s, at, 0.3);
    s.n = 5;
    rig_begin(&rig_probed, 1);
    (void)rig_add(&rig_probed, 0, 0, &s);
    if (!adjust_probed()) {
        return 0;
    }
    (void)faults_of(RIGCAL_FAULT_FOCAL, NULL, 0);
    return faults_solver.n_neighbours == 4;
}

static void gate_fault_edges(void)
{
    line("faults.sigma_of_all", "%.3g", sigma_of_all());
    edge("faults.degrees", turn_takes_two_digits, 0.01, 0.09);
    edge("faults.ring", ring_hides_distortion, ANY_OF(1e-9, 1e-5), 0.5);
    edge("faults.before", move_is_seen, 1, ANY_OF(1e7, 1e4));
    edge("faults.point_counts", point_counts, 0.1, 100);
    edge("faults.neighbour", step_is_to_a_neighbour, 1.05, 4);
}

static void gate_faults(void)
{
    edge("faults.F_noise", F_is_noise, 1, 10);
    edge("faults.found", fault_is_found, 1e-6, 1);
    edge("faults.alike", faults_are_alike, 0.1, 100);
    edge("faults.explains", fault_explains, 0.001, 1);
    edge("faults.no_pattern", is_no_pattern, 0.001, 1);
    edge("faults.few_for_pattern", is_too_few_for_a_pattern, 1, 1e6);
    edge("faults.not_along", is_not_along, 0.001, 1);
    line("faults.pattern_sigma", "%.4g", (double)with_residues(0, 1000, 0).pattern_sigma);
    edge("faults.two_digits", takes_two_digits, 1, 9);
    line("faults.digits", "%zu", said(RIGCAL_FAULT_CENTRE, 1, 1e-12));
    line("faults.most", "%zu", said(RIGCAL_FAULT_CENTRE, 4e9, 1e9));
    for (int percent = 0; percent < 2; percent++) {
        const int kind = percent ? RIGCAL_FAULT_FOCAL : RIGCAL_FAULT_DRIFT;
        unsigned long bytes = 0;
        for (int k = 0; k < 40; k++) {
            bytes += (unsigned long)said(kind, 1, 1e-6 * (1 + k) * (percent ? 1e4 : 1));
        }
        line(percent ? "faults.percent" : "faults.millionths", "%lu", bytes);
    }
}

static void run(void)
{
    gate_poses();
    gate_warm();
    gate_wide();
    gate_mirrored();
    gate_caveats();
    gate_robust();
    gate_robust_edges();
    gate_rivals();
    gate_diagnose();
    gate_blame_edges();
    gate_tags("tag", 60, 0.4, 0);
    gate_tags("tag.edge_on", 30, 1, 1);
    gate_triangulate();
    gate_depth_edges();
    gate_points();
    gate_sights();
    gate_epilines();
    gate_rotations();
    gate_rigs();
    gate_judgements();
    gate_choices();
    gate_lenses();
    gate_lens_edges();
    gate_series();
    gate_chance();
    gate_faults();
    gate_fault_edges();
    gate_paper();
    gate_paper_edges();
    gate_neldermead();
    gate_levenberg();
    gate_p3p();
    gate_directions();
    gate_thickness();
    gate_near_poses();
    gate_ranges();
    gate_store();
    gate_matching();
    gate_long_borders();
    gate_wide_bands();
    gate_bands();
    gate_outlines();
    gate_transfers();
    gate_memory();
    gate_alarm();
    gate_clocks();
    gate_monitor();
}

/* The value of a line: the text after its name. NULL: the line belongs to another
 * counter. */
static const char *value_of(const char *counter, const char *name, size_t length)
{
    return strncmp(counter, name, length) == 0 && counter[length] == ' '
               ? counter + length + 1
               : NULL;
}

/* Whether two values agree. The stack depends on the compiler, so it may be up to 1.25
 * times the recorded one. */
static int agree(const char *name, const char *seen, const char *expected)
{
    return strncmp(name, "stack.", 6) == 0 ? atol(seen) * 4 <= atol(expected) * 5
                                           : strcmp(seen, expected) == 0;
}

/* Whether an expected line differs from what was seen. *is_seen: whether the counter
 * exists. */
static int differs(const char *expected, int *is_seen)
{
    const size_t length = strcspn(expected, " ");
    const char *seen = NULL;
    for (int i = 0; i < n_lines && seen == NULL; i++) {
        seen = value_of(lines[i], expected, length);
    }
    *is_seen = seen != NULL;
    if (seen != NULL && agree(expected, seen, expected + length + 1)) {
        return 0;
    }
    printf("%s, now %s\n", expected, seen != NULL ? seen : "nothing");
    return 1;
}

static int check(const char *path)
{
    char expected[100];
    int n_differ = 0, n_seen = 0;
    FILE *const file = fopen(path, "r");
    if (file == NULL) {
        fprintf(stderr, "gate: %s cannot be read\n", path);
        return 1;
    }
    while (fgets(expected, sizeof expected, file) != NULL) {
        int is_seen;
        expected[strcspn(expected, "\r\n")] = 0;
        if (expected[0] != '#' && expected[0] != 0) {
            n_differ += differs(expected, &is_seen);
            n_seen += is_seen;
        }
    }
    fclose(file);
    const int n_new = n_lines - n_seen;
    printf("gate: %d counters, %d differ, %d are not in %s\n", n_lines, n_differ, n_new,
           path);
    return n_differ > 0 || n_new > 0;
}

int main(int argc, char *argv[])
{
    if (argc != 1 && (argc != 3 || strcmp(argv[1], "check") != 0)) {
        fprintf(stderr, "usage: gate [check FILE]\n");
        return 2;
    }
    run();
    if (argc == 3) {
        return check(argv[2]);
    }
    for (int i = 0; i < n_lines; i++) {
        printf("%s\n", lines[i]);
    }
    return 0;
}
