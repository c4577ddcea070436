/* bench_pose: the figures of DESIGN.md about rigcal_solve_pose, as Markdown.
 *
 *   bench_pose minima [SCENES] [SIGMA_PX] [--thorough] [--known]
 *       whether the best minimum is found, and how good it is; --known: the noise
 *       is told to the solver
 *   bench_pose coverage [SCENES]
 *       whether the covariance tells the truth
 *   bench_pose solve FAMILY N COUNT [warm]
 *       only solves, for callgrind (tests/bench/instructions.sh) */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_tally.h"
#include "test_fit.h"
#include "test_support.h"

enum { SCENES = 10000, SCENES_MAX = 1000000 };

#define DEGREE (TEST_PI / 180)
#define SIGMA_PX 0.5

/* Unity, which the tests' arithmetic is checked with, wants them. */
void setUp(void)
{
}

void tearDown(void)
{
}

static void fail(const char *why)
{
    fprintf(stderr, "bench_pose: %s\n", why);
    exit(2);
}

/* ---- scenes -------------------------------------------------------------- */

/* All are of size 1, before a camera of 800 px 3 to 10 sizes away. */
typedef struct {
    const char *name;
    double thickness; /* of the box that the points are in */
    double aside;     /* how far the middle may be off the axis, of its depth */
    int is_flat;      /* tilted by up to TILT_MOST, else turned anyhow */
    int is_tag;       /* the corners of a square */
} family;

static const family families[] = {
    {"general", 1, 0.1, 0, 0},
    {"planar", 0, 0.1, 1, 0},
    {"tag", 0, 0.1, 1, 1},
    {"near-planar", 0.05, 0.1, 1, 0},
    {"off-centre", 1, 0.5, 0, 0},
};

enum { FAMILIES = sizeof families / sizeof families[0] };

#define TILT_MOST (60 * DEGREE)

typedef struct {
    rigcal_camera camera;
    rigcal_observation seen[TEST_SCENE_MAX];
    double R[9], t[3]; /* the truth; the target's middle is the world's origin */
    double sigma;      /* px */
    int n;
} scene;

static void place_point(double X[3], test_rng *rng, const family *f, int i)
{
    if (f->is_tag) {
        X[0] = i == 1 || i == 2 ? 0.5 : -0.5;
        X[1] = i >= 2 ? 0.5 : -0.5;
        X[2] = 0;
        return;
    }
    X[0] = test_uniform(rng, -0.5, 0.5);
    X[1] = test_uniform(rng, -0.5, 0.5);
    X[2] = f->thickness * test_uniform(rng, -0.5, 0.5);
}

/* The normal uniform on the cap round the line of sight, any turn about it. */
static void tilt(double R[9], test_rng *rng, const double t[3])
{
    const double across[3] = {-t[1], t[0], 0};
    const double off = atan2(hypot(t[0], t[1]), t[2]);
    const double way = test_uniform(rng, -TEST_PI, TEST_PI);
    const double axis[3] = {cos(way), sin(way), 0};
    const double angle = acos(test_uniform(rng, cos(TILT_MOST), 1));
    double aim[9], lean[9], turn[9], both[9];

    test_rotation(turn, test_uniform(rng, -TEST_PI, TEST_PI), 0, 0);
    test_rotation_about(lean, axis, angle);
    test_product(both, lean, turn);
    test_rotation_about(aim, across, off);
    test_product(R, aim, both);
}

static void place_camera(scene *s, test_rng *rng, const family *f)
{
    s->t[2] = test_uniform(rng, 3, 10);
    s->t[0] = s->t[2] * test_uniform(rng, -f->aside, f->aside);
    s->t[1] = s->t[2] * test_uniform(rng, -f->aside, f->aside);
    if (f->is_flat) {
        tilt(s->R, rng, s->t);
    } else {
        test_random_rotation(s->R, rng);
    }
}

static void make_scene(scene *s, test_rng *rng, const family *f, int n,
                       double sigma)
{
    s->camera = test_pinhole();
    s->n = n;
    s->sigma = sigma;
    place_camera(s, rng, f);
    for (int i = 0; i < n; i++) {
        double X[3], X_c[3], uv[2];

        place_point(X, rng, f, i);
        test_apply(X_c, s->R, X, s->t);
        test_project_px(uv, &s->camera, X_c);
        for (int k = 0; k < 2; k++) {
            uv[k] += sigma * test_normal(rng);
        }
        test_to_real(s->seen[i].X_w, X, 3);
        test_to_real(s->seen[i].uv, uv, 2);
    }
}

static test_rng seed_of(const family *f, int n)
{
    return test_seed((uint64_t)(1000 * (f - families) + n));
}

static test_data data_of(const scene *s)
{
    const test_data data = {&s->camera, s->seen, NULL, s->n};

    return data;
}

/* ---- solutions ----------------------------------------------------------- */

typedef struct {
    rigcal_pose poses[RIGCAL_POSES_MAX];
    size_t n;
    rigcal_status status;
    int evals;
} solution;

/* What rigcal_solve_pose does, evaluation by evaluation, so that they count. */
static void solve(solution *found, const scene *s,
                  const rigcal_pose_options *options)
{
    rigcal_pose_solver solver;

    found->n = 0;
    found->evals = 0;
    found->status = rigcal_pose_begin(&solver, NULL, &s->camera, s->seen, NULL,
                                      (size_t)s->n, options);
    if (found->status != RIGCAL_OK) {
        return;
    }
    do {
        found->evals++;
    } while (rigcal_pose_step(&solver, 1) == RIGCAL_RUNNING);
    found->status =
        rigcal_pose_result(found->poses, &found->n, RIGCAL_POSES_MAX, &solver);
}

/* ---- the bound ----------------------------------------------------------- */

/* d(u, v) by (w, dt) of one point at the truth, by differences. */
static void rows_of(double J[2][6], const scene *s, int i)
{
    const double h = 1e-6;
    double X[3];

    test_to_double(X, s->seen[i].X_w, 3);
    for (int k = 0; k < 6; k++) {
        double uv[2][2];

        for (int side = 0; side < 2; side++) {
            double d[6] = {0}, R[9], t[3], X_c[3];

            memcpy(R, s->R, sizeof R);
            memcpy(t, s->t, sizeof t);
            d[k] = side ? h : -h;
            test_move(R, t, d);
            test_apply(X_c, R, X, t);
            test_project_px(uv[side], &s->camera, X_c);
        }
        J[0][k] = (uv[1][0] - uv[0][0]) / (2 * h);
        J[1][k] = (uv[1][1] - uv[0][1]) / (2 * h);
    }
}

/* The least standard deviations that (w, dt) can have: Cramer-Rao. */
static int bound_of(double deviation[6], const scene *s)
{
    double H[36] = {0};

    for (int i = 0; i < s->n; i++) {
        double J[2][6];

        rows_of(J, s, i);
        for (int k = 0; k < 36; k++) {
            H[k] += J[0][k / 6] * J[0][k % 6] + J[1][k / 6] * J[1][k % 6];
        }
    }
    for (int k = 0; k < 6; k++) {
        double one[6] = {0}, column[6];

        one[k] = 1;
        if (!test_solve(column, H, one, 6) || !(column[k] > 0)) {
            return 0;
        }
        deviation[k] = s->sigma * sqrt(column[k]);
    }
    return 1;
}

/* Mean over the parameters of (error / bound)^2, or -1 where there is none. */
static double squared_by_bound(const scene *s, const rigcal_pose *pose)
{
    double R[9], t[3], d[6], deviation[6], sum = 0;

    if (!bound_of(deviation, s)) {
        return -1;
    }
    test_transform_parts(R, t, &pose->cam_from_world);
    test_difference(d, s->R, s->t, R, t);
    for (int k = 0; k < 6; k++) {
        sum += d[k] / deviation[k] * (d[k] / deviation[k]);
    }
    return sum / 6;
}

/* ---- minima: the multi-start --------------------------------------------- */

/* What counts as the same sum, and as the same rotation [rad]. */
#define SUM_TOL 1e-4
#define SAME_ROTATION 0.01

enum { STARTS = 2 + RIGCAL_POSES_MAX };

typedef struct {
    test_fitted list[STARTS]; /* distinct minima, in no order */
    int n, stopped;           /* fits that did not converge */
    test_fitted from_truth, best;
} minima;

static void keep_minimum(minima *m, const test_fitted *fitted)
{
    for (int i = 0; i < m->n; i++) {
        if (test_angle_between(m->list[i].R, fitted->R) < SAME_ROTATION) {
            if (fitted->sse < m->list[i].sse) {
                m->list[i] = *fitted;
            }
            return;
        }
    }
    m->list[m->n++] = *fitted;
}

/* Fits from where `fitted` is. */
static void add_start(minima *m, test_fitted *fitted, const test_data *data)
{
    if (test_fit(fitted, data)) {
        keep_minimum(m, fitted);
    } else {
        m->stopped++;
    }
    if (fitted->sse < m->best.sse) {
        m->best = *fitted;
    }
}

static void find_minima(minima *m, const scene *s, const solution *found)
{
    const test_data data = data_of(s);
    test_fitted fitted;

    m->n = m->stopped = 0;
    m->best.sse = HUGE_VAL;
    memcpy(m->from_truth.R, s->R, sizeof s->R);
    memcpy(m->from_truth.t, s->t, sizeof s->t);
    add_start(m, &m->from_truth, &data);
    test_mirror_tilt(&fitted, &data, s->R, s->t);
    add_start(m, &fitted, &data);
    for (size_t i = 0; i < found->n; i++) {
        test_transform_parts(fitted.R, fitted.t,
                             &found->poses[i].cam_from_world);
        add_start(m, &fitted, &data);
    }
}

/* The second best, or NULL. */
static const test_fitted *second_of(const minima *m)
{
    int best = 0, second = -1;

    for (int i = 1; i < m->n; i++) {
        best = m->list[i].sse < m->list[best].sse ? i : best;
    }
    for (int i = 0; i < m->n; i++) {
        if (i != best &&
            (second < 0 || m->list[i].sse < m->list[second].sse)) {
            second = i;
        }
    }
    return second < 0 ? NULL : &m->list[second];
}

static double angle_to(const test_fitted *fitted, const rigcal_pose *pose)
{
    double R[9];

    test_transform_parts(R, NULL, &pose->cam_from_world);
    return test_angle_between(fitted->R, R);
}

static int is_reported(const test_fitted *fitted, const solution *found)
{
    for (size_t i = 0; i < found->n; i++) {
        if (angle_to(fitted, &found->poses[i]) < SAME_ROTATION) {
            return 1;
        }
    }
    return 0;
}

/* ---- minima: the table --------------------------------------------------- */

typedef struct {
    tally statuses;
    int solved, not_best, unfinished, unlisted; /* best: same place, elsewhere */
    int with_second, second_missing;
    int right, wrong_yet_ok, bounded, stopped, evals_most;
    double squares, evals;
} minima_cell;

/* How the first solution stands to the best minimum. */
static void judge_first(minima_cell *cell, const scene *s,
                        const solution *found, const minima *m)
{
    const test_data data = data_of(s);
    double R[9], t[3];

    test_transform_parts(R, t, &found->poses[0].cam_from_world);
    if (test_sse(&data, R, t) > m->best.sse * (1 + SUM_TOL)) {
        cell->not_best++;
        cell->unfinished += angle_to(&m->best, &found->poses[0]) < SAME_ROTATION;
        cell->unlisted += !is_reported(&m->best, found);
    }
}

static void judge_second(minima_cell *cell, const solution *found,
                         const minima *m)
{
    const test_fitted *second = second_of(m);

    if (second) {
        cell->with_second++;
        cell->second_missing += !is_reported(second, found);
    }
}

static void judge_error(minima_cell *cell, const scene *s,
                        const solution *found, const minima *m)
{
    double square;

    if (angle_to(&m->from_truth, &found->poses[0]) >= SAME_ROTATION) {
        cell->wrong_yet_ok += found->status == RIGCAL_OK;
        return;
    }
    cell->right++;
    square = squared_by_bound(s, &found->poses[0]);
    if (square >= 0) {
        cell->bounded++;
        cell->squares += square;
    }
}

static void minima_try(minima_cell *cell, const scene *s,
                       const rigcal_pose_options *options)
{
    solution found;
    minima m;

    solve(&found, s, options);
    tally_add(&cell->statuses, found.status);
    if (found.status < 0) {
        return;
    }
    cell->solved++;
    cell->evals += found.evals;
    cell->evals_most =
        found.evals > cell->evals_most ? found.evals : cell->evals_most;
    find_minima(&m, s, &found);
    cell->stopped += m.stopped;
    judge_first(cell, s, &found, &m);
    judge_second(cell, &found, &m);
    judge_error(cell, s, &found, &m);
}

static void minima_print(const minima_cell *cell, const family *f, int n)
{
    printf("| %s | %d | %d | %d | %d |", f->name, n, cell->not_best,
           cell->unlisted, cell->unfinished);
    if (f->is_flat) {
        printf(" %d | %d |", cell->with_second, cell->second_missing);
    } else {
        printf(" - | - |");
    }
    printf(" %d | %d | %.3f | %.1f | %d | ", cell->right, cell->wrong_yet_ok,
           sqrt(cell->squares / (cell->bounded > 0 ? cell->bounded : 1)),
           cell->evals / (cell->solved > 0 ? cell->solved : 1),
           cell->evals_most);
    tally_print(&cell->statuses);
    printf(" |\n");
    fflush(stdout);
}

/* One line. Returns how many of the fits stopped at their bound. */
static int minima_row(const family *f, int n, int scenes, double sigma,
                      const rigcal_pose_options *options)
{
    test_rng rng = seed_of(f, n);
    minima_cell cell;

    memset(&cell, 0, sizeof cell);
    for (int i = 0; i < scenes; i++) {
        scene s;

        make_scene(&s, &rng, f, n, sigma);
        minima_try(&cell, &s, options);
    }
    minima_print(&cell, f, n);
    return cell.stopped;
}

static void minima_head(int scenes, double sigma,
                        const rigcal_pose_options *options)
{
    printf("%d scenes a line, %g px noise, f = 800 px, 3 to 10 sizes away%s%s.\n"
           "Minima are those that a fit of the test's own finds from the truth, "
           "from the truth mirrored\nin the line of sight, and from the poses "
           "returned. Not best: the first pose's sum is more than\n%g above the "
           "least; of these, none of the poses returned is that minimum, or the "
           "first is but\nis not converged. Second: scenes that have a second "
           "minimum, and where it was not returned.\nRight: the first is the "
           "minimum that the truth lies in; wrong, yet the status was OK. "
           "Error: rms\nover the right ones of the six parameters' errors, each "
           "over its Cramer-Rao bound (derivatives\nby the test's own "
           "differences at the truth, true sigma).\n\n",
           scenes, sigma, options->thorough ? ", thorough" : "",
           options->sigma_px > 0 ? ", sigma_px told" : "", SUM_TOL);
    printf("| target | points | not best | not returned | not converged "
           "| second | not returned | right | wrong, yet OK | error / bound "
           "| evaluations | most | not OK |\n");
    printf("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: "
           "| ---: | ---: | ---: | --- |\n");
}

static void bench_minima(int scenes, double sigma,
                         const rigcal_pose_options *options)
{
    static const int counts[] = {4, 5, 6, 8, 20, 50};
    int stopped = 0;

    minima_head(scenes, sigma, options);
    for (int f = 0; f < FAMILIES; f++) {
        for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
            if (!families[f].is_tag || counts[i] == 4) {
                stopped += minima_row(&families[f], counts[i], scenes, sigma,
                                      options);
            }
        }
    }
    printf("\nFits that stopped before they converged, and count as no second "
           "minimum: %d.\n", stopped);
}

/* ---- coverage ------------------------------------------------------------ */

/* 95 % of chi squared with 6 degrees of freedom. */
#define CHI_SQUARED_95 12.591587243743977

/* Whether the truth is in the ellipsoid round a pose. */
static int is_covered(const scene *s, const rigcal_pose *pose, double sigma)
{
    rigcal_pose_uncertainty u;
    double R[9], t[3], d[6], Sigma[36];

    if (rigcal_pose_covariance(&u, &s->camera, &pose->cam_from_world, s->seen,
                               NULL, (size_t)s->n, RC(sigma)) != RIGCAL_OK) {
        return 0;
    }
    test_transform_parts(R, t, &pose->cam_from_world);
    test_difference(d, R, t, s->R, s->t);
    test_to_double(Sigma, u.Sigma, 36);
    return test_squared_distance(d, Sigma, 6) <= CHI_SQUARED_95;
}

static void coverage_print(const char *sigma, int inside, int solved)
{
    const double part = solved > 0 ? (double)inside / solved : 0;

    printf("| %s | %d | %.2f %% | %.2f %% |\n", sigma, solved, 100 * part,
           100 * sqrt(part * (1 - part) / (solved > 0 ? solved : 1)));
}

static void bench_coverage(int scenes)
{
    enum { POINTS = 8 };
    const family *const f = &families[0];
    test_rng rng = seed_of(f, POINTS);
    int solved = 0, known = 0, estimated = 0;
    tally statuses;

    memset(&statuses, 0, sizeof statuses);
    for (int i = 0; i < scenes; i++) {
        scene s;
        solution found;

        make_scene(&s, &rng, f, POINTS, SIGMA_PX);
        solve(&found, &s, NULL);
        tally_add(&statuses, found.status);
        if (found.status >= 0) {
            solved++;
            known += is_covered(&s, &found.poses[0], SIGMA_PX);
            estimated += is_covered(&s, &found.poses[0], 0);
        }
    }
    printf("%d scenes, %s, %d points, %g px noise; the first pose, right or "
           "not, and the covariance\nat it. The ellipsoid is that of chi squared "
           "with 6 degrees of freedom, %.3f, for the estimated\nsigma too, which "
           "makes it too small there: %d degrees of freedom were left to estimate "
           "it from.\n\n", scenes, f->name, POINTS, SIGMA_PX, CHI_SQUARED_95,
           2 * POINTS - 6);
    printf("| sigma | solved | truth inside 95 %% | standard error |\n"
           "| --- | ---: | ---: | ---: |\n");
    coverage_print("known", known, solved);
    coverage_print("estimated", estimated, solved);
    printf("\nNot OK: ");
    tally_print(&statuses);
    printf("\n");
}

/* ---- solve: for callgrind ------------------------------------------------ */

/* The truth, off by 2 degrees and 2 % of the distance, each any way. */
static void disturb(rigcal_transform *start, const scene *s, test_rng *rng)
{
    double R[9], t[3], turn[9], way[2][9];

    test_random_rotation(way[0], rng);
    test_random_rotation(way[1], rng);
    test_rotation_about(turn, way[0] + 6, 2 * DEGREE);
    test_product(R, turn, s->R);
    for (int k = 0; k < 3; k++) {
        t[k] = s->t[k] + 0.02 * test_norm(s->t) * way[1][6 + k];
    }
    *start = test_transform(R, t);
}

static rigcal_status solve_one(const scene *s,
                               const rigcal_pose_options *options)
{
    rigcal_pose poses[RIGCAL_POSES_MAX];
    size_t n_found;

    return rigcal_solve_pose(poses, &n_found, RIGCAL_POSES_MAX, NULL,
                             &s->camera, s->seen, NULL, (size_t)s->n, options);
}

static void bench_solve(const family *f, int n, int count, int warm)
{
    test_rng rng = seed_of(f, n);
    rigcal_pose_options options;
    tally statuses;

    memset(&statuses, 0, sizeof statuses);
    (void)rigcal_pose_defaults(&options);
    options.use_start = warm;
    for (int i = 0; i < count; i++) {
        scene s;

        make_scene(&s, &rng, f, n, SIGMA_PX);
        if (warm) {
            disturb(&options.start, &s, &rng);
        }
        tally_add(&statuses, solve_one(&s, &options));
    }
    printf("%s, %d points, %g px noise%s: %d solved; not OK: ", f->name, n,
           SIGMA_PX, warm ? ", warm" : "", count);
    tally_print(&statuses);
    printf("\n");
}

/* ---- the program --------------------------------------------------------- */

static void usage(void)
{
    fail("usage: bench_pose minima [SCENES] [SIGMA_PX] [--thorough] "
         "[--known] | coverage [SCENES] | solve FAMILY N COUNT [warm]");
}

static int whole_number(const char *text, int least, int most)
{
    char *end;
    const long number = strtol(text, &end, 10);

    if (end == text || *end != '\0' || number < least || number > most) {
        fprintf(stderr, "bench_pose: %s is no number from %d to %d\n", text,
                least, most);
        exit(2);
    }
    return (int)number;
}

static double sigma_of(const char *text)
{
    char *end;
    const double sigma = strtod(text, &end);

    if (end == text || *end != '\0' || !(sigma > 0 && sigma <= 100)) {
        fail("SIGMA_PX must be above 0 and at most 100");
    }
    return sigma;
}

static const family *family_of(const char *name)
{
    for (int f = 0; f < FAMILIES; f++) {
        if (strcmp(name, families[f].name) == 0) {
            return &families[f];
        }
    }
    fail("FAMILY must be general, planar, tag, near-planar or off-centre");
    return NULL;
}

/* The first line tells what was measured. */
static void print_build(void)
{
    printf("rigcal %d.%d.%d, %s, rigcal_real %s\n\n", RIGCAL_VERSION_MAJOR,
           RIGCAL_VERSION_MINOR, RIGCAL_VERSION_PATCH, BENCH_BUILD,
           rigcal_sizeof_real() == sizeof(double) ? "double" : "float");
}

static void run_minima(int argc, char **argv)
{
    rigcal_pose_options options;
    double sigma = SIGMA_PX;
    int scenes = SCENES, known = 0, given = 0;

    (void)rigcal_pose_defaults(&options);
    for (int i = 2; i < argc; i++) {
        if (strcmp(argv[i], "--thorough") == 0) {
            options.thorough = 1;
        } else if (strcmp(argv[i], "--known") == 0) {
            known = 1;
        } else if (++given == 1) {
            scenes = whole_number(argv[i], 1, SCENES_MAX);
        } else if (given == 2) {
            sigma = sigma_of(argv[i]);
        } else {
            usage();
        }
    }
    options.sigma_px = RC(known ? sigma : 0);
    print_build();
    bench_minima(scenes, sigma, &options);
}

static void run_solve(int argc, char **argv)
{
    const int warm = argc == 6 && strcmp(argv[5], "warm") == 0;
    const family *f;
    int n;

    if (argc != 5 + warm) {
        usage();
    }
    f = family_of(argv[2]);
    n = whole_number(argv[3], 4, f->is_tag ? 4 : TEST_SCENE_MAX);
    print_build();
    bench_solve(f, n, whole_number(argv[4], 1, SCENES_MAX), warm);
}

int main(int argc, char **argv)
{
    const char *const what = argc > 1 ? argv[1] : "";

    if (strcmp(what, "minima") == 0) {
        run_minima(argc, argv);
    } else if (strcmp(what, "coverage") == 0 && argc <= 3) {
        print_build();
        bench_coverage(argc > 2 ? whole_number(argv[2], 1, SCENES_MAX)
                                : SCENES);
    } else if (strcmp(what, "solve") == 0) {
        run_solve(argc, argv);
    } else {
        usage();
    }
    return 0;
}
