/* bench_wide: rigcal_pose_solve where every point is 40 to 89 degrees off the optical
 * axis, or to 110 degrees of a fisheye; as Markdown of BENCHMARKS.md.
 *
 *   bench_wide table [SCENES] [--list]
 *       SCENES of each lens (default 100 000); --list: the scenes that went wrong, on
 *       stderr
 *   bench_wide check [SCENES]
 *       some scenes, for CI, SCENES of each lens, shape and number of points (default 100,
 *       the most): exit status 1 if more go wrong than should
 *   bench_wide replay LENS SHAPE N INDEX
 *       one of the scenes: its minima, and what was returned */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_solution.h"
#include "bench_tally.h"

enum { SCENES = 100000, SCENES_MAX = 10000000 };

/* scenes for each lens, shape and number of points */
enum { SCENES_CHECKED = 100 };

#define SIGMA_PX 0.5
#define NEAREST_OFF (40 * BENCH_DEGREE)
#define FARTHEST_OFF (89 * BENCH_DEGREE)
#define FARTHEST_OFF_FISHEYE (110 * BENCH_DEGREE)

/* A flat target is at least this far from edge-on: the sine of 15 degrees. */
#define EDGE_ON 0.26

/* A pose farther from its minimum than this part of the minimum's Cramer-Rao bound is
 * not converged. */
#define CONVERGED 0.1

static const int counts[] = {4, 5, 8};

typedef enum { PINHOLE, BROWN, RATIONAL, FISHEYE, LENSES } lens;
typedef enum { AROUND, GENERAL, PLANAR, SQUARE, SHAPES } shape;
enum { COUNTS = sizeof counts / sizeof counts[0] };

static const char *const lens_names[LENSES] = {"pinhole", "Brown", "rational", "fisheye"};
static const char *const shape_names[SHAPES] = {"around", "general", "planar", "square"};

/* Unity needs these: the arithmetic of the tests uses its checks. */
void setUp(void)
{
}

void tearDown(void)
{
}

/* ---- scenes -------------------------------------------------------------- */

/* Each of these lenses is one to one over the range of the points. */
static rigcal_camera camera_of(lens what, test_rng *rng)
{
    const double f = exp(test_uniform(rng, log(30), log(800)));
    rigcal_camera c;

    memset(&c, 0, sizeof c);
    c.width = c.height = (int32_t)(3 * f) + 1;
    c.fx = RC(f);
    c.fy = RC(f * test_uniform(rng, 0.97, 1.03));
    c.cx = c.cy = RC(1.5 * f);
    if (what == BROWN) {
        c.k1 = RC(test_uniform(rng, 0, 1e-3));
        c.k2 = RC(test_uniform(rng, 0, 1e-7));
        c.p1 = RC(test_uniform(rng, -1e-5, 1e-5));
        c.p2 = RC(test_uniform(rng, -1e-5, 1e-5));
    } else if (what == RATIONAL) {
        const double k1 = test_uniform(rng, 0.05, 0.3);

        c.k1 = RC(k1);
        c.k4 = RC(k1 * test_uniform(rng, 0.5, 2.5));
    } else if (what == FISHEYE) {
        c.lens = RIGCAL_LENS_FISHEYE;
        c.k1 = RC(test_uniform(rng, -0.02, 0.05));
        c.k2 = RC(test_uniform(rng, -0.003, 0.003));
    }
    return c;
}

static double farthest_of(lens what)
{
    return what == FISHEYE ? FARTHEST_OFF_FISHEYE : FARTHEST_OFF;
}

/* A point in the camera's frame, `far` away, anywhere in the ring of angles. */
static void place_in_ring(double X_c[3], lens what, double far, test_rng *rng)
{
    const double off = test_uniform(rng, NEAREST_OFF, farthest_of(what));
    const double way = test_uniform(rng, -TEST_PI, TEST_PI);

    X_c[0] = far * sin(off) * cos(way);
    X_c[1] = far * sin(off) * sin(way);
    X_c[2] = far * cos(off);
}

/* Points all round the camera, each 1 to 3 away. The origin of the world is near the
 * camera. */
static void place_around(double X[][3], bench_scene *s, lens what)
{
    double back[9];

    for (int k = 0; k < 3; k++) {
        s->t[k] = test_uniform(&s->rng, -1, 1);
    }
    test_transpose(back, s->R);
    for (int i = 0; i < s->n; i++) {
        double X_c[3];

        place_in_ring(X_c, what, test_uniform(&s->rng, 1, 3), &s->rng);
        for (int k = 0; k < 3; k++) {
            X_c[k] -= s->t[k];
        }
        test_apply(X[i], back, X_c, NULL);
    }
}

/* A target of size 1, its middle 0.4 to 6 away. Returns 0 if a flat target is seen
 * edge-on. */
static int place_target(double X[][3], bench_scene *s, lens what, shape form)
{
    const double far = exp(test_uniform(&s->rng, log(0.4), log(6)));
    const double normal[3] = {s->R[2], s->R[5], s->R[8]};

    place_in_ring(s->t, what, far, &s->rng);
    for (int i = 0; i < s->n; i++) {
        for (int k = 0; k < 3; k++) {
            X[i][k] = test_uniform(&s->rng, -0.5, 0.5);
        }
        if (form != GENERAL) {
            X[i][2] = 0;
        }
        if (form == SQUARE && i < 4) {
            X[i][0] = i == 1 || i == 2 ? 0.5 : -0.5;
            X[i][1] = i < 2 ? 0.5 : -0.5;
        }
    }
    return form == GENERAL || fabs(test_dot(normal, s->t)) >= EDGE_ON * far;
}

/* Whether all points are in the ring, and all their noisy pixels have a ray. */
static int see_points(bench_scene *s, double X[][3], lens what)
{
    for (int i = 0; i < s->n; i++) {
        double X_c[3], uv[2], off;
        rigcal_real ray[3];

        test_apply(X_c, s->R, X[i], s->t);
        off = atan2(hypot(X_c[0], X_c[1]), X_c[2]);
        if (off < NEAREST_OFF || off > farthest_of(what)) {
            return 0;
        }
        test_project_px(uv, &s->camera, X_c);
        for (int k = 0; k < 2; k++) {
            uv[k] += SIGMA_PX * test_normal(&s->rng);
        }
        test_to_real(s->seen[i].X_w, X[i], 3);
        test_to_real(s->seen[i].uv, uv, 2);
        if (rigcal_camera_ray(ray, &s->camera, s->seen[i].uv) != RIGCAL_OK) {
            return 0;
        }
    }
    return 1;
}

static void scene_make(bench_scene *s, lens what, shape form, int n, long index)
{
    const uint64_t row = 100 * (10 * (uint64_t)what + (uint64_t)form) + (uint64_t)n;
    double X[TEST_SCENE_MAX][3];
    int is_placed;

    memset(s, 0, sizeof *s);
    s->rng = test_seed((row << 32) + (uint64_t)index);
    s->n = n;
    s->sigma = SIGMA_PX;
    do {
        s->camera = camera_of(what, &s->rng);
        test_random_rotation(s->R, &s->rng);
        if (form == AROUND) {
            place_around(X, s, what);
            is_placed = 1;
        } else {
            is_placed = place_target(X, s, what, form);
        }
    } while (!is_placed || !see_points(s, X, what));
}

/* ---- one scene judged ---------------------------------------------------- */

typedef struct {
    tally statuses;
    long scenes, solved, not_best, not_converged;
    long wrong_yet_ok, missed_yet_ok; /* missed: also not the least minimum */
    double evals;
    int evals_most;
} cell;

/* Whether the first pose is as good as minimum i. */
static int is_converged(const bench_minima *m, int i, const double R[9], const double t[3])
{
    bench_scene at = *m->scene;
    double d[6], deviation[6], sum = 0;

    memcpy(at.R, m->list[i].R, sizeof at.R);
    memcpy(at.t, m->list[i].t, sizeof at.t);
    if (!bench_bound(deviation, &at)) {
        return 0;
    }
    test_difference(d, at.R, at.t, R, t);
    for (int k = 0; k < 6; k++) {
        sum += d[k] / deviation[k] * (d[k] / deviation[k]) / 6;
    }
    return sum <= CONVERGED * CONVERGED;
}

/* Returns 0 if something is wrong with it. */
static int judge(cell *c, const bench_solution *found, bench_minima *m)
{
    double R[9], t[3];
    int first, is_best, well;

    c->scenes++;
    tally_add(&c->statuses, found->status);
    c->evals += found->evals;
    c->evals_most = found->evals > c->evals_most ? found->evals : c->evals_most;
    if (found->status < 0) {
        return 0;
    }
    c->solved++;
    bench_first(R, t, found);
    first = bench_minimum_of(m, found, 0);
    is_best = bench_is_best(m, first, BENCH_SUM_TOL);
    well = is_best && is_converged(m, first, R, t);
    c->not_best += !is_best;
    c->not_converged += is_best && !well;
    if (found->status == RIGCAL_OK && (first < 0 || first != m->truth)) {
        c->wrong_yet_ok++;
        c->missed_yet_ok += !is_best;
        well = 0;
    }
    return well;
}

static void try_scenes(cell *c, lens what, shape form, int n, long scenes, int list)
{
    for (long index = 0; index < scenes; index++) {
        bench_scene s;
        bench_solution found;
        bench_minima m;

        scene_make(&s, what, form, n, index);
        bench_solve_and_find(&found, &m, &s, NULL);
        if (!judge(c, &found, &m) && list) {
            fprintf(stderr, "%s %s %d %ld: %s\n", lens_names[what], shape_names[form], n,
                    index, rigcal_status_name(found.status));
        }
    }
}

static void cell_add(cell *sum, const cell *c)
{
    tally_sum(&sum->statuses, &c->statuses);
    sum->scenes += c->scenes;
    sum->solved += c->solved;
    sum->not_best += c->not_best;
    sum->not_converged += c->not_converged;
    sum->wrong_yet_ok += c->wrong_yet_ok;
    sum->missed_yet_ok += c->missed_yet_ok;
    sum->evals += c->evals;
    sum->evals_most = c->evals_most > sum->evals_most ? c->evals_most : sum->evals_most;
}

/* ---- the table ----------------------------------------------------------- */

static void cell_print(const cell *c, const char *what, const char *form)
{
    printf("| %s | %s | %ld | %ld | %ld | %ld | %ld | %ld | %.1f | %d | ", what, form,
           c->scenes, c->not_best, c->not_converged, c->wrong_yet_ok, c->missed_yet_ok,
           c->scenes - c->solved, c->evals / (double)c->scenes, c->evals_most);
    tally_print(&c->statuses);
    printf(" |\n");
    fflush(stdout);
}

static void explain(void)
{
    printf("rigcal %d.%d.%d, %s, rigcal_real %s\n\n", RIGCAL_VERSION_MAJOR,
           RIGCAL_VERSION_MINOR, RIGCAL_VERSION_PATCH, BENCH_BUILD,
           rigcal_sizeof_real() == sizeof(double) ? "double" : "float");
    printf("Every point is 40 to 89 degrees off the axis, or to 110 degrees of a "
           "fisheye. f = 30 to 800 px, %g px\nnoise; 4, 5 and 8 points. Around: "
           "points all round the camera, each 1 to 3 away. The others: a target\n"
           "of size 1, 0.4 to 6 away; a flat one at least 15 degrees from "
           "edge-on. Minima are those that a fit\nof the test's own finds from the "
           "truth, from the truth mirrored in the line of sight, from 24 "
           "rotations\nall over the sphere, and from the poses returned. Not "
           "best: a fit from the first pose does not end in\nthe least minimum. "
           "Not converged: it does, but the pose is farther from it than %g of "
           "its Cramer-Rao\nbound, rms over the six parameters. Wrong, yet OK: the "
           "status is OK and the first pose is in another\nminimum than the truth "
           "lies in; of these, that minimum is not the least one. Units are those "
           "of\nrigcal_pose_step.\n\n",
           SIGMA_PX, CONVERGED);
}

static void bench_table(long scenes_of_lens, int list)
{
    const long scenes = (scenes_of_lens + SHAPES * COUNTS - 1) / (SHAPES * COUNTS);

    explain();
    printf("| lens | target | scenes | not best | not converged | wrong, yet OK "
           "| of these not best | not solved | units | most | not OK |\n"
           "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: "
           "| --- |\n");
    for (int what = 0; what < LENSES; what++) {
        cell of_lens;

        memset(&of_lens, 0, sizeof of_lens);
        for (int form = 0; form < SHAPES; form++) {
            cell c;

            memset(&c, 0, sizeof c);
            for (int i = 0; i < COUNTS; i++) {
                try_scenes(&c, (lens)what, (shape)form, counts[i], scenes, list);
            }
            cell_print(&c, lens_names[what], shape_names[form]);
            cell_add(&of_lens, &c);
        }
        cell_print(&of_lens, lens_names[what], "all");
    }
}

/* ---- check --------------------------------------------------------------- */

/* How many scenes of a lens may go wrong; the scenes that are checked are always the same.
 * Never allowed: OK with a pose that is not in the least minimum. Allowed: in two scenes
 * the noise makes another minimum the least, whose sum is a twelfth of that at the truth's
 * minimum. In float, and with Brown's polynomial, the search of some scenes uses up its
 * evaluations. */
typedef struct {
    long not_best, not_converged, wrong_yet_ok, missed_yet_ok, not_solved;
} limits;

static const limits limits_double[LENSES] = {[RATIONAL] = {0, 0, 2, 0, 0}};
static const limits limits_float[LENSES] = {
    [BROWN] = {1, 6, 0, 0, 1}, [RATIONAL] = {0, 0, 2, 0, 0}};

/* Returns 0 if there are more than the limit. */
static int is_within(const char *what, const char *count, long number, long limit)
{
    printf("%s: %ld %s, at most %ld\n", what, number, count, limit);
    return number <= limit;
}

static int bench_check(long scenes)
{
    const limits *const all = RIGCAL_USE_FLOAT ? limits_float : limits_double;
    int well = 1;

    for (int what = 0; what < LENSES; what++) {
        const char *const name = lens_names[what];
        cell c;

        memset(&c, 0, sizeof c);
        for (int form = 0; form < SHAPES; form++) {
            for (int i = 0; i < COUNTS; i++) {
                try_scenes(&c, (lens)what, (shape)form, counts[i], scenes, 1);
            }
        }
        well &= is_within(name, "not best", c.not_best, all[what].not_best);
        well &= is_within(name, "not converged", c.not_converged, all[what].not_converged);
        well &= is_within(name, "wrong, yet OK", c.wrong_yet_ok, all[what].wrong_yet_ok);
        well &= is_within(name, "not the least minimum, yet OK", c.missed_yet_ok,
                          all[what].missed_yet_ok);
        well &= is_within(name, "not solved", c.scenes - c.solved, all[what].not_solved);
    }
    return well;
}

/* ---- replay -------------------------------------------------------------- */

static void bench_replay(lens what, shape form, int n, long index)
{
    bench_scene s;
    bench_solution found;
    bench_minima m;

    scene_make(&s, what, form, n, index);
    bench_solve_and_find(&found, &m, &s, NULL);
    for (int i = 0; i < s.n; i++) {
        double X[3], X_c[3];

        test_to_double(X, s.seen[i].X_w, 3);
        test_apply(X_c, s.R, X, s.t);
        printf("point %d: %.2f degrees off the axis, at (%.3f, %.3f)\n", i,
               atan2(hypot(X_c[0], X_c[1]), X_c[2]) / BENCH_DEGREE, D(s.seen[i].uv[0]),
               D(s.seen[i].uv[1]));
    }
    printf("f = %.1f px; fits that stopped: %d\n", D(s.camera.fx), m.stopped);
    for (int i = 0; i < m.n; i++) {
        printf("minimum %d: sum %.9g, %.3f degrees from the truth%s\n", i, m.list[i].sse,
               test_angle_between(m.list[i].R, s.R) / BENCH_DEGREE,
               i == m.truth ? ", which lies in it" : "");
    }
    printf("%s, %d units\n", rigcal_status_name(found.status), found.evals);
    for (size_t i = 0; i < found.n; i++) {
        printf("pose %d: sum %.9g, probability %.4f, in minimum %d\n", (int)i,
               D(found.poses[i].sse), D(found.poses[i].probability),
               bench_minimum_of(&m, &found, i));
    }
}

/* ---- the program --------------------------------------------------------- */

static void usage(void)
{
    fprintf(stderr,
            "bench_wide: usage: bench_wide table [SCENES] [--list] | check [SCENES] | "
            "replay LENS SHAPE N INDEX\n");
    exit(2);
}

static long whole_number(const char *text, long least, long most)
{
    char *end;
    const long number = strtol(text, &end, 10);

    if (end == text || *end != '\0' || number < least || number > most) {
        fprintf(stderr, "bench_wide: %s is no number from %ld to %ld\n", text, least, most);
        exit(2);
    }
    return number;
}

static int index_of(const char *name, const char *const names[], int n)
{
    for (int i = 0; i < n; i++) {
        if (strcmp(name, names[i]) == 0) {
            return i;
        }
    }
    fprintf(stderr, "bench_wide: there is no %s; there are", name);
    for (int i = 0; i < n; i++) {
        fprintf(stderr, " %s", names[i]);
    }
    fprintf(stderr, "\n");
    exit(2);
}

static void run_table(int argc, char **argv)
{
    long scenes = SCENES;
    int list = 0;

    for (int i = 2; i < argc; i++) {
        if (strcmp(argv[i], "--list") == 0) {
            list = 1;
        } else {
            scenes = whole_number(argv[i], 1, SCENES_MAX);
        }
    }
    bench_table(scenes, list);
}

int main(int argc, char **argv)
{
    const char *const what = argc > 1 ? argv[1] : "";

    if (strcmp(what, "table") == 0) {
        run_table(argc, argv);
    } else if (strcmp(what, "check") == 0 && argc <= 3) {
        return bench_check(argc == 3 ? whole_number(argv[2], 1, SCENES_CHECKED)
                                     : SCENES_CHECKED)
                   ? 0
                   : 1;
    } else if (strcmp(what, "replay") == 0 && argc == 6) {
        bench_replay((lens)index_of(argv[2], lens_names, LENSES),
                     (shape)index_of(argv[3], shape_names, SHAPES),
                     (int)whole_number(argv[4], 4, TEST_SCENE_MAX),
                     whole_number(argv[5], 0, SCENES_MAX));
    } else {
        usage();
    }
    return 0;
}
