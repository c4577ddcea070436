/* How often faults of a rig are named rightly, and how often one is named if there is none.
 *
 *     bench_faults none N        no fault: shares of p, of rigs with a name, of scores
 *     bench_faults power N       each fault in the scene of 4 cameras, 8 bursts of 3
 *     bench_faults untestable N  the true fault cannot be tested
 *     bench_faults cost N        evaluations of the adjustments of N rigs; for callgrind
 *     bench_faults check         a few of each, with limits
 *
 * N rigs a line. 4 cameras at 1 m on 80 degrees of arc, f 800 px, a board of 20 points that
 * moves at 0.35 m/s and 0.8 rad/s, at 30 frames a second; 0.3 px of noise. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rigcal_solvers.h"
#include "test_support.h"

/* Unity needs these: the scenes of the tests use its checks. */
void setUp(void)
{
}

void tearDown(void)
{
}

enum { C_MAX = 8, F_MAX = 24, V_MAX = C_MAX * F_MAX, N = 20, FAULTS = 10 * C_MAX + 3 };

typedef struct {
    int kind, camera, placement;
    double size[6];
    int n_cameras, spots, burst, with_times;
    double clock_noise;
} plan;

typedef struct {
    rigcal_camera camera[C_MAX], true_camera[C_MAX];
    rigcal_transform cams[C_MAX], places[F_MAX];
    rigcal_real times[F_MAX], instants[F_MAX], offsets[C_MAX];
    int32_t states[C_MAX], group[C_MAX];
    rigcal_rig_view views[V_MAX];
    rigcal_observation o[V_MAX][N];
    rigcal_real
        work[RIGCAL_RIG_WORK(C_MAX, C_MAX, F_MAX) + RIGCAL_CLOCKS_WORK(C_MAX, C_MAX)];
    rigcal_real room[2 * RIGCAL_FAULTS_WORK(C_MAX, C_MAX)];
    rigcal_rig rig;
    rigcal_rig_clocks clocks;
    rigcal_fault faults[FAULTS];
    rigcal_faults found;
} scene;

static scene s;
static const double NOISE = 0.3, SPEED = 0.35, TURN = 0.8, FPS = 30;

/* A normal number from two uniform ones, because here the tails matter. */
static double normal(test_rng *rng)
{
    const double u = 1 - test_uniform(rng, 0, 1), v = test_uniform(rng, 0, 2 * TEST_PI);

    return sqrt(-2 * log(u)) * cos(v);
}

static rigcal_transform moved(const rigcal_transform *from, const double d[6])
{
    const double angle = test_norm(d);
    double turn[9], R[9], t[3], out[9];

    test_rotation_about(turn, d, angle > 0 ? angle : 0);
    test_transform_parts(R, t, from);
    if (angle > 0) {
        test_product(out, turn, R);
    } else {
        memcpy(out, R, sizeof out);
    }
    for (int k = 0; k < 3; k++) {
        t[k] += d[3 + k];
    }
    return test_transform(out, t);
}

/* ---- the scene -------------------------------------------------------------------- */

typedef struct {
    double rate[6][3], phase[6][3], amp[6][3];
} path;

static path hand(test_rng *rng)
{
    path p;
    double power[2] = {0, 0};

    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < 3; k++) {
            p.rate[i][k] = test_uniform(rng, 0.4, 1.2) * 2 * TEST_PI;
            p.phase[i][k] = test_uniform(rng, 0, 2 * TEST_PI);
            p.amp[i][k] = normal(rng);
            power[i / 3] += p.amp[i][k] * p.rate[i][k] * p.amp[i][k] * p.rate[i][k] / 2;
        }
    }
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < 3; k++) {
            p.amp[i][k] *= (i < 3 ? TURN : SPEED) / sqrt(power[i / 3]);
        }
    }
    return p;
}

static rigcal_transform on_path(const path *p, const rigcal_transform *base, double t)
{
    double d[6] = {0};

    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < 3; k++) {
            d[i] += p->amp[i][k] * sin(p->rate[i][k] * t + p->phase[i][k]);
        }
    }
    return moved(base, d);
}

/* Rows x, cross(z, x), z. */
static void looking(double R[9], const double x[3], const double z[3])
{
    double a[3], b[3], y[3];

    for (int k = 0; k < 3; k++) {
        b[k] = z[k] / test_norm(z);
    }
    const double along = test_dot(x, b);

    for (int k = 0; k < 3; k++) {
        a[k] = x[k] - along * b[k];
    }
    const double length = test_norm(a);

    for (int k = 0; k < 3; k++) {
        a[k] /= length;
    }
    test_cross(y, b, a);
    memcpy(&R[0], a, sizeof a);
    memcpy(&R[3], y, sizeof y);
    memcpy(&R[6], b, sizeof b);
}

static rigcal_transform camera_at(test_rng *rng, int c, int n)
{
    const double az = (c - (n - 1) / 2.) * 1.4 / (n > 1 ? n - 1 : 1);
    const double eye[3] = {cos(az), sin(az), 0.3 * test_uniform(rng, -1, 1)};
    const double up[3] = {0, 0, 1}, z[3] = {-eye[0], -eye[1], -eye[2]};
    double x[3], R[9], t[3];

    test_cross(x, z, up);
    looking(R, x, z);
    test_apply(t, R, eye, NULL);
    for (int k = 0; k < 3; k++) {
        t[k] = -t[k];
    }
    return test_transform(R, t);
}

static rigcal_transform board_at(test_rng *rng)
{
    const double z[3] = {1, 0.7 * test_uniform(rng, -1, 1), 0.7 * test_uniform(rng, -1, 1)};
    const double x[3] = {normal(rng), normal(rng), normal(rng)};
    const double t[3] = {0.2 * test_uniform(rng, -1, 1), 0.2 * test_uniform(rng, -1, 1),
                         0.12 * test_uniform(rng, -1, 1)};
    double R[9], Rt[9];

    looking(R, x, z);
    test_transpose(Rt, R);
    return test_transform(Rt, t);
}

/* What a fault does to a camera's intrinsics, a point and a clock. */
static void disturb_camera(rigcal_camera *camera, const plan *p, int c)
{
    if (p->camera != c) {
        return;
    }
    const rigcal_camera k = *camera;
    const double *const size = p->size;

    if (p->kind == RIGCAL_FAULT_FOCAL) {
        camera->fx = RC(D(k.fx) * (1 + size[0]));
        camera->fy = RC(D(k.fy) * (1 + size[0]));
    } else if (p->kind == RIGCAL_FAULT_ASPECT) {
        camera->fx = RC(D(k.fx) * (1 + size[0] / 2));
        camera->fy = RC(D(k.fy) * (1 - size[0] / 2));
    } else if (p->kind == RIGCAL_FAULT_CENTRE) {
        camera->cx = RC(D(k.cx) + size[0]);
        camera->cy = RC(D(k.cy) + size[1]);
    } else if (p->kind == RIGCAL_FAULT_DISTORTION) {
        camera->k1 = RC(D(k.k1) + size[0]);
        camera->k2 = RC(D(k.k2) + size[1]);
    }
}

static void point_at(double X[3], const plan *p, int i)
{
    const double x = i % 5 / 2. - 1, y = i / 5 / 1.5 - 1;

    X[0] = 0.1 * x;
    X[1] = 0.075 * y;
    X[2] = 0;
    if (p->kind == RIGCAL_FAULT_BENT) {
        X[2] = p->size[0] * (1 - x * x) + p->size[1] * (1 - y * y);
    } else if (p->kind == RIGCAL_FAULT_STRETCHED) {
        X[0] *= 1 + p->size[0] / 2;
        X[1] *= 1 - p->size[0] / 2;
    }
}

static void see(double uv[2], const rigcal_camera *camera, const rigcal_transform *cam,
                const rigcal_transform *place, const double X[3])
{
    double X_r[3], X_c[3];

    test_move_point(X_r, place, X);
    test_move_point(X_c, cam, X_r);
    test_project_px(uv, camera, X_c);
}

static void see_view(test_rng *rng, const plan *p, size_t v, const rigcal_transform *cam,
                     const path *motion, const rigcal_transform *base, double t)
{
    const int c = s.views[v].camera;

    for (int i = 0; i < N; i++) {
        double X[3], flat[3], uv[2];
        rigcal_transform place = on_path(motion, base, t);
        const plan none = {-1, -1, 0, {0}, 0, 0, 0, 0, 0};

        point_at(X, p, i);
        point_at(flat, &none, i);
        see(uv, &s.true_camera[c], cam, &place, X);
        for (int k = 0; k < 3 && p->kind == RIGCAL_FAULT_SHUTTER && p->camera == c; k++) {
            place = on_path(motion, base, t + p->size[0] * (uv[1] - 479.5) / 960);
            see(uv, &s.true_camera[c], cam, &place, X);
        }
        test_to_real(s.o[v][i].X_w, flat, 3);
        for (int k = 0; k < 2; k++) {
            s.o[v][i].uv[k] = RC(uv[k] + NOISE * normal(rng));
        }
    }
    s.views[v].view = VIEW(&s.camera[c], s.o[v], NULL, N);
}

static void set_cameras(const plan *p)
{
    for (int c = 0; c < p->n_cameras; c++) {
        const double lens[15] = {0,    1280,   960,     800, 800, 639.5, 479.5, -0.12,
                                 0.05, 0.0005, -0.0004, 0,   0,   0,     0};

        s.camera[c] = s.true_camera[c] = test_camera(lens);
        disturb_camera(&s.true_camera[c], p, c);
    }
}

static void set_rig(const plan *p)
{
    s.rig.cams_from_rig = s.cams;
    s.rig.n_cameras = (size_t)p->n_cameras;
    s.rig.rig_from_placements = s.places;
    s.rig.n_placements = (size_t)(p->spots * p->burst);
    s.rig.group = s.group;
    s.rig.n_views = s.rig.n_cameras * s.rig.n_placements;
    s.rig.views = s.views;
    s.rig.work = s.work;
    s.rig.work_capacity = sizeof s.work / sizeof *s.work;
    (void)rigcal_clocks_defaults(&s.clocks);
    s.clocks.times = s.times;
    s.clocks.instants = s.instants;
    s.clocks.offsets = s.offsets;
    s.clocks.states = s.states;
    s.clocks.frame = RC(1 / FPS);
    s.rig.clocks = p->with_times ? &s.clocks : NULL;
}

static void make(const plan *p, uint64_t seed)
{
    test_rng rng = test_seed(seed);
    rigcal_transform cams[C_MAX];
    size_t v = 0;

    memset(&s, 0, sizeof s);
    set_cameras(p);
    set_rig(p);
    for (int c = 0; c < p->n_cameras; c++) {
        cams[c] = camera_at(&rng, c, p->n_cameras);
    }
    const rigcal_transform rig_from_world = cams[0];
    const rigcal_transform back = test_inverse(&rig_from_world);

    for (int c = 0; c < p->n_cameras; c++) {
        cams[c] = test_times(&cams[c], &back);
        s.cams[c] = cams[c];
    }
    for (int f = 0; f < p->spots * p->burst; f++) {
        static path motion;
        static rigcal_transform base;
        const double t = (f % p->burst - (p->burst - 1) / 2.) / FPS;

        if (f % p->burst == 0) {
            const rigcal_transform in_world = board_at(&rng);

            base = test_times(&rig_from_world, &in_world);
            motion = hand(&rng);
        }
        s.times[f] = RC(10 * (f / p->burst) + t);
        s.places[f] = on_path(&motion, &base, t);
        for (int c = 0; c < p->n_cameras; c++, v++) {
            const int is_it = p->camera == c;
            const rigcal_transform shifted = moved(&cams[c], p->size);
            const int is_moved =
                is_it && p->kind == RIGCAL_FAULT_MOVED && f >= p->placement;

            s.views[v].camera = c;
            s.views[v].placement = f;
            see_view(&rng, p, v, is_moved ? &shifted : &cams[c], &motion, &base,
                     t + (is_it && p->kind == RIGCAL_FAULT_CLOCK ? p->size[0] : 0));
        }
    }
}

static long evaluations; /* of all adjustments */

/* Returns 0 if the rig could not be adjusted. */
static int test_it(const uint8_t *breaks)
{
    rigcal_rig_fit fit = {0};
    rigcal_faults_options options;

    memset(&options, 0, sizeof options);
    options.work = s.room;
    options.work_capacity = sizeof s.room / sizeof *s.room;
    options.breaks = breaks;
    const rigcal_status status = rigcal_rig_adjust(&fit, NULL, &s.rig);
    evaluations += fit.evals;
    return status == RIGCAL_OK && rigcal_rig_faults(&s.found, s.faults, FAULTS, NULL,
                                                    &options, &s.rig) == RIGCAL_OK;
}

/* ---- no fault --------------------------------------------------------------------- */

static int none(int n)
{
    static const char *const NAMES[RIGCAL_FAULT_KINDS] = {
        "clock",  "drift",      "clocks", "shutter", "focal",    "aspect",
        "centre", "distortion", "moved",  "bent",    "stretched"};
    double below5[RIGCAL_FAULT_KINDS] = {0}, below1[RIGCAL_FAULT_KINDS] = {0};
    double all[RIGCAL_FAULT_KINDS] = {0}, named = 0, score = 0, score2 = 0;
    double total = 0, total5 = 0, total1 = 0;
    uint8_t breaks[F_MAX];

    for (int i = 0; i < n; i++) {
        plan p = {-1, -1, 0, {0}, 2 + i % 7, 8, 3, 1, 0};

        make(&p, 1000 + (uint64_t)i);
        memset(breaks, 0, sizeof breaks);
        breaks[3 + (i / 7) % 18] = 1; /* a single instant, so that p belongs to one test */
        if (!test_it(breaks)) {
            return 1;
        }
        for (int k = 0; k < s.found.n; k++) {
            const rigcal_fault *const f = &s.faults[k];

            if (f->is_seen) {
                all[f->kind]++;
                below5[f->kind] += D(f->p) < 0.05;
                below1[f->kind] += D(f->p) < 0.01;
            }
        }
        const double z = D(s.found.pattern) / D(s.found.pattern_sigma);

        score += z / n;
        score2 += z * z / n;
        if (!test_it(NULL)) {
            return 1;
        }
        named += (s.found.bits & RIGCAL_FAULTS_NAMED) != 0;
    }
    printf("| fault | tests | below 0.05 | below 0.01 |\n| --- | ---: | ---: | ---: |\n");
    for (int k = 0; k < RIGCAL_FAULT_KINDS; k++) {
        printf("| %s | %.0f | %.2f %% | %.2f %% |\n", NAMES[k], all[k],
               100 * below5[k] / all[k], 100 * below1[k] / all[k]);
        total += all[k];
        total5 += below5[k];
        total1 += below1[k];
    }
    const double deviation = sqrt(score2 - score * score);

    printf("| all | %.0f | %.2f %% | %.2f %% |\n", total, 100 * total5 / total,
           100 * total1 / total);
    puts("\n| rigs without a fault | a fault named | pattern's score, mean | its deviation "
         "|\n"
         "| ---: | ---: | ---: | ---: |");
    printf("| %d | %.2f %% | %.3f | %.3f |\n", n, 100 * named / n, score, deviation);
    return !(fabs(total5 / total - 0.05) < 0.005 + 1 / sqrt(total) &&
             named / n < 0.015 + 2 / (double)n && fabs(score) < 0.1 + 3 / sqrt(n));
}

/* ---- power ------------------------------------------------------------------------ */

typedef struct {
    const char *name;
    plan p;
    double least, other; /* percent: named rightly, another named first */
} line;

#define SCENE4 4, 8, 3, 1, 0
static const line LINES[] = {
    {"clock 1 ms", {0, 2, 0, {0.001}, SCENE4}, 98, 4},
    {"clock 5 ms", {0, 2, 0, {0.005}, SCENE4}, 98, 4},
    {"clock 10 ms", {0, 2, 0, {0.01}, SCENE4}, 98, 4},
    {"shutter 15 ms", {3, 1, 0, {0.015}, SCENE4}, 98, 4},
    {"f 1 %", {4, 1, 0, {0.01}, SCENE4}, 97, 4},
    {"aspect 0.3 %", {5, 1, 0, {0.003}, SCENE4}, 97, 4},
    {"centre 10 px", {6, 1, 0, {7.07, 7.07}, SCENE4}, 92, 4},
    {"centre 5 px", {6, 1, 0, {3.54, 3.54}, SCENE4}, 0, 8},
    {"k1 0.03", {7, 1, 0, {0.03, 0}, SCENE4}, 87, 4},
    {"bend 0.2 mm", {9, -1, 0, {0.0002, 0}, SCENE4}, 92, 4},
    {"bend 0.5 mm", {9, -1, 0, {0.0005, 0}, SCENE4}, 98, 4},
    {"stretch 0.3 %", {10, -1, 0, {0.003}, SCENE4}, 97, 4},
    {"moved 0.1 degrees, 1 mm", {8, 1, 12, {0.00175, 0, 0, 0, 0.001, 0}, SCENE4}, 98, 4},
    {"two cameras, clock 5 ms", {0, 1, 0, {0.005}, 2, 8, 3, 1, 0}, 98, 4},
    {"two cameras, moved 0.3 degrees",
     {8, 1, 12, {0.0052, 0, 0, 0, 0, 0}, 2, 8, 3, 1, 0},
     98,
     4}};

/* Whether fault i is the one that was made. If two cameras are possible, either is
 * right. */
static int is_right(const plan *p, int i)
{
    return s.faults[i].kind == p->kind &&
           (s.faults[i].camera == p->camera || p->n_cameras == 2);
}

static int power(int n, int with_limits)
{
    int bad = 0;

    printf("| fault | sqrt F | named first | none | another | explains | one or the other "
           "|\n| --- | ---: | ---: | ---: | ---: | ---: | ---: |\n");
    for (size_t k = 0; k < sizeof LINES / sizeof *LINES; k++) {
        const line *const l = &LINES[k];
        double F = 0, right = 0, no = 0, explains = 0, both = 0;

        for (int i = 0; i < n; i++) {
            make(&l->p, 5000 + 1000 * (uint64_t)k + (uint64_t)i);
            if (!test_it(NULL)) {
                return 1;
            }
            const int is_named = (s.found.bits & RIGCAL_FAULTS_NAMED) != 0;

            F += sqrt(D(s.found.F)) / n;
            no += !is_named;
            right += is_named && is_right(&l->p, 0);
            explains += is_named && is_right(&l->p, 0) && s.faults[0].explains;
            both +=
                is_named && is_right(&l->p, 0) && s.found.n_alike > 0 && is_right(&l->p, 1);
        }
        const double other = n - right - no;

        printf("| %s | %.2f | %.1f %% | %.1f %% | %.1f %% | %.1f %% | %.1f %% |\n", l->name,
               F, 100 * right / n, 100 * no / n, 100 * other / n, 100 * explains / n,
               100 * both / n);
        fflush(stdout);
        bad |= with_limits &&
               (right < l->least / 100 * n - 2 || other > l->other / 100 * n + 1);
    }
    return bad;
}

/* ---- the true fault cannot be tested ------------------------------------------------- */

static int untestable(int n)
{
    double explained = 0, told = 0, found = 0;

    for (int i = 0; i < n; i++) {
        const plan p = {0, 2, 0, {0.005}, 4, 24, 1, 1, 0};

        make(&p, 90000 + (uint64_t)i);
        if (!test_it(NULL)) {
            return 1;
        }
        explained += s.found.verdict == RIGCAL_RIG_EXPLAINED;
        found += (s.found.bits & RIGCAL_FAULTS_NAMED) != 0;
        told += (s.found.bits & RIGCAL_FAULTS_NO_NEIGHBOUR) != 0;
    }
    puts("| clock 5 ms, single pictures | something found | explained | clocks not tested "
         "|\n"
         "| ---: | ---: | ---: | ---: |");
    printf("| %d | %.1f %% | %.1f %% | %.1f %% |\n", n, 100 * found / n,
           100 * explained / n, 100 * told / n);
    return explained > 0.03 * n + 1 || told < n;
}

/* ---- what it costs ----------------------------------------------------------------- */

static int cost(int n)
{
    for (int i = 0; i < n; i++) {
        const plan p = {-1, -1, 0, {0}, 4, 8, 3, 1, 0};

        make(&p, 70000 + (uint64_t)i);
        if (!test_it(NULL)) {
            return 1;
        }
    }
    printf("%ld\n", evaluations);
    return 0;
}

int main(int argc, char *argv[])
{
    const int n = (argc > 2) ? atoi(argv[2]) : 0;

    if (argc > 2 && n > 0 && strcmp(argv[1], "none") == 0) {
        return none(n);
    }
    if (argc > 2 && n > 0 && strcmp(argv[1], "power") == 0) {
        return power(n, 1);
    }
    if (argc > 2 && n > 0 && strcmp(argv[1], "untestable") == 0) {
        return untestable(n);
    }
    if (argc > 2 && n > 0 && strcmp(argv[1], "cost") == 0) {
        return cost(n);
    }
    if (argc == 2 && strcmp(argv[1], "check") == 0) {
        return none(14) | power(2, 1) | untestable(4);
    }
    fprintf(stderr, "bench_faults none | power | untestable | cost N, or check\n");
    return 2;
}
