/* bench_pose: the figures of BENCHMARKS.md about rigcal_pose_solve, as Markdown.
 *
 *   bench_pose minima [SCENES] [SIGMA_PX] [--known] [--list]
 *       whether the best minimum is found, and how good it is; --known: the solver knows
 *       the noise; --list: the scenes that went wrong, on stderr
 *   bench_pose replay FAMILY N INDEX [SIGMA_PX]
 *       one of those scenes: its minima, and what was returned
 *   bench_pose coverage [SCENES]
 *       whether the covariance is right
 *   bench_pose answers [SCENES] [SIGMA_PX] | bench_pose compare [SCENES] [SIGMA_PX]
 *       the first of a double build piped to the second of a float build
 *   bench_pose solve FAMILY N COUNT [warm]
 *       only solves, for callgrind (tests/bench/instructions.sh) */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_scenes.h"
#include "bench_solution.h"
#include "bench_tally.h"

enum { SCENES = 10000, SCENES_MAX = 1000000 };

#define SIGMA_PX 0.5

static const int counts[] = {4, 5, 6, 8, 12, 20, 50};

enum { COUNTS = sizeof counts / sizeof counts[0] };

/* Unity needs these: the arithmetic of the tests uses its checks. */
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

/* targets 3 to 10 sizes away */
static bench_view view_of(double sigma)
{
    const bench_view view = {3, 10, sigma};

    return view;
}

/* ---- minima: is the best found? ------------------------------------------ */

typedef struct {
    tally statuses;
    int solved, not_best, unfinished, unlisted; /* not the best minimum: near it,
                                                   elsewhere */
    int with_second, second_missing, second_matters, twice;
    int right, wrong_yet_ok, bounded, evals_most;
    double squares, squares_of_minimum, evals;
} minima_cell;

/* One line of the table. */
typedef struct {
    const bench_family *f;
    int n, stopped;
    minima_cell cell;
} minima_row;

static double mean_square(const bench_scene *s, const double deviation[6],
                          const double R[9], const double t[3])
{
    double squares[2];

    bench_squares(squares, s, deviation, R, t);
    return (squares[0] + squares[1]) / 2;
}

/* Compares the first pose with the best minimum. Returns 0 if the pose is wrong. */
static int judge_first(minima_cell *cell, const bench_solution *found, bench_minima *m)
{
    const int best = bench_minima_ranked(m, 0);
    double R[9], t[3];

    bench_first(R, t, found);
    if (bench_is_best(m, best, BENCH_SUM_TOL) && bench_is_minimum(m, best, R, t)) {
        return 1;
    }
    cell->not_best++;
    cell->unfinished += bench_minimum_of(m, found, 0) == best;
    cell->unlisted += !bench_is_returned(m, best, found);
    return 0;
}

/* The likelihood of the second minimum over that of the best, with unknown noise. */
static double odds_of(const bench_minima *m, int best, int second)
{
    return pow(m->list[best].sse / m->list[second].sse, m->scene->n - 3);
}

static int judge_second(minima_cell *cell, const bench_solution *found, bench_minima *m)
{
    const int second = bench_minima_ranked(m, 1);

    if (second < 0) {
        return 1;
    }
    cell->with_second++;
    if (bench_is_returned(m, second, found)) {
        return 1;
    }
    cell->second_missing++;
    cell->second_matters += odds_of(m, bench_minima_ranked(m, 0), second) > 0.01;
    return 0;
}

/* Whether two of the returned poses are in one minimum. */
static int is_twice(const bench_solution *found, bench_minima *m)
{
    for (size_t i = 1; i < found->n; i++) {
        for (size_t j = 0; j < i; j++) {
            if (bench_minimum_of(m, found, i) == bench_minimum_of(m, found, j)) {
                return 1;
            }
        }
    }
    return 0;
}

static void judge_error(minima_cell *cell, const bench_scene *s,
                        const bench_solution *found, bench_minima *m)
{
    double R[9], t[3], deviation[6];

    if (m->truth < 0 || bench_minimum_of(m, found, 0) != m->truth) {
        cell->wrong_yet_ok += found->status == RIGCAL_OK;
        return;
    }
    cell->right++;
    if (bench_bound(deviation, s)) {
        bench_first(R, t, found);
        cell->bounded++;
        cell->squares += mean_square(s, deviation, R, t);
        cell->squares_of_minimum +=
            mean_square(s, deviation, m->list[m->truth].R, m->list[m->truth].t);
    }
}

/* Returns 0 if something is wrong with it. */
static int judge(minima_cell *cell, const bench_scene *s, const bench_solution *found,
                 bench_minima *m, int has_second)
{
    int well;

    tally_add(&cell->statuses, found->status);
    if (found->status < 0) {
        return 0;
    }
    cell->solved++;
    cell->evals += found->evals;
    cell->evals_most = found->evals > cell->evals_most ? found->evals : cell->evals_most;
    well = judge_first(cell, found, m);
    if (has_second) {
        well &= judge_second(cell, found, m);
    }
    cell->twice += is_twice(found, m);
    judge_error(cell, s, found, m);
    return well;
}

static void minima_try(minima_row *row, long index, const bench_view *view,
                       const rigcal_pose_options *options, int list)
{
    bench_scene s;
    bench_solution found;
    bench_minima m;

    bench_scene_make(&s, row->f, row->n, index, view);
    bench_solve_and_find(&found, &m, &s, options);
    if (!judge(&row->cell, &s, &found, &m, row->f->has_second) && list) {
        fprintf(stderr, "%s %d %ld\n", row->f->name, row->n, index);
    }
    row->stopped += m.stopped;
}

static double root(double squares, int n)
{
    return sqrt(squares / (n > 0 ? n : 1));
}

static void minima_print(const minima_row *row)
{
    const minima_cell *const cell = &row->cell;

    printf("| %s |", row->f->name);
    if (row->n > 0) {
        printf(" %d", row->n);
    }
    printf(" | %d | %d | %d |", cell->not_best, cell->unlisted, cell->unfinished);
    if (row->f->has_second) {
        printf(" %d | %d | %d |", cell->with_second, cell->second_missing,
               cell->second_matters);
    } else {
        printf(" - | - | - |");
    }
    printf(" %d | %d | %d | %.3f | %.3f | %.1f | %d | ", cell->twice, cell->right,
           cell->wrong_yet_ok, root(cell->squares, cell->bounded),
           root(cell->squares_of_minimum, cell->bounded),
           cell->evals / (cell->solved > 0 ? cell->solved : 1), cell->evals_most);
    tally_print(&cell->statuses);
    printf(" |\n");
    fflush(stdout);
}

static void cell_add(minima_cell *sum, const minima_cell *cell)
{
    tally_sum(&sum->statuses, &cell->statuses);
    sum->solved += cell->solved;
    sum->not_best += cell->not_best;
    sum->unfinished += cell->unfinished;
    sum->unlisted += cell->unlisted;
    sum->with_second += cell->with_second;
    sum->second_missing += cell->second_missing;
    sum->second_matters += cell->second_matters;
    sum->twice += cell->twice;
    sum->right += cell->right;
    sum->wrong_yet_ok += cell->wrong_yet_ok;
    sum->bounded += cell->bounded;
    sum->evals_most =
        cell->evals_most > sum->evals_most ? cell->evals_most : sum->evals_most;
    sum->squares += cell->squares;
    sum->squares_of_minimum += cell->squares_of_minimum;
    sum->evals += cell->evals;
}

/* Prints the last line: the sum of all. */
static void minima_sum(const minima_row rows[], int n_rows)
{
    static const bench_family all = {"all", {0, 0, 0}, 0, 0, 1, 0};
    minima_row sum;

    memset(&sum, 0, sizeof sum);
    sum.f = &all;
    for (int i = 0; i < n_rows; i++) {
        cell_add(&sum.cell, &rows[i].cell);
    }
    minima_print(&sum);
}

static void minima_head(void)
{
    printf("\n| target | points | not best | not returned | not converged "
           "| second | not returned | though likely | twice | right | wrong, yet OK | "
           "error / bound "
           "| of the minimum | units | most | not OK |\n");
    printf("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: "
           "| ---: | ---: | ---: | ---: | ---: | ---: | --- |\n");
}

static void minima_explain(int scenes, const bench_view *view,
                           const rigcal_pose_options *options)
{
    printf("%d scenes a line, %g px noise, f = 800 px, %g to %g sizes away%s.\n"
           "Minima are those that a fit of the test's own finds from the truth, "
           "from the truth mirrored\nin the line of sight, from 24 rotations all "
           "over the sphere, and from the poses returned.\nNot best: the first "
           "pose is not the minimum of the least sum, or its sum is more than "
           "%g\nabove; of these, none of the poses returned is in that minimum, "
           "or the first is but is not\nconverged. Second: scenes that have a "
           "second minimum, where it was not returned, and where it\nwas not "
           "though it is more than 0.01 times as likely as the best, the noise "
           "not being known.\nTwice: two of the poses are in one minimum. Right: "
           "the first is in the minimum that the truth\nlies in; wrong, yet the "
           "status was OK. Error: rms over the right ones of the six "
           "parameters'\nerrors, each over its Cramer-Rao bound (derivatives by "
           "the test's own differences at the truth,\ntrue sigma), and what the "
           "minimum itself has.\n",
           scenes, view->sigma, view->nearest, view->farthest,
           options->sigma_px > 0 ? ", sigma_px told" : "", BENCH_SUM_TOL);
}

static void bench_minima_table(int scenes, double sigma, const rigcal_pose_options *options,
                               int list)
{
    static minima_row rows[BENCH_FAMILIES * COUNTS];
    const bench_view view = view_of(sigma);
    int n_rows = 0, stopped = 0;

    minima_explain(scenes, &view, options);
    minima_head();
    for (int i = 0; i < BENCH_FAMILIES * COUNTS; i++) {
        minima_row *const row = &rows[n_rows];

        row->f = &bench_families[i / COUNTS];
        row->n = counts[i % COUNTS];
        if (bench_has(row->f, row->n)) {
            for (long index = 0; index < scenes; index++) {
                minima_try(row, index, &view, options, list);
            }
            minima_print(row);
            stopped += row->stopped;
            n_rows++;
        }
    }
    minima_sum(rows, n_rows);
    printf("\nFits that stopped before they converged, and count as no second "
           "minimum: %d.\n",
           stopped);
}

/* ---- replay -------------------------------------------------------------- */

static void replay_print(const bench_solution *found, bench_minima *m)
{
    printf("%s, %d evaluations\n", rigcal_status_name(found->status), found->evals);
    for (size_t i = 0; i < found->n; i++) {
        printf("  pose %d: sum %.9g, probability %.4f, in minimum %d\n", (int)i,
               D(found->poses[i].sse), D(found->poses[i].probability),
               bench_minimum_of(m, found, i));
    }
}

static void bench_replay(const bench_family *f, int n, long index, double sigma)
{
    const bench_view view = view_of(sigma);
    rigcal_pose_options options;
    bench_solution found;
    bench_minima m;
    bench_scene s;

    (void)rigcal_pose_defaults(&options);
    bench_scene_make(&s, f, n, index, &view);
    bench_solve_and_find(&found, &m, &s, &options);
    for (int i = 0; i < m.n; i++) {
        printf("minimum %d: sum %.9g, %.3f degrees from the truth%s\n", i, m.list[i].sse,
               test_angle_between(m.list[i].R, s.R) / BENCH_DEGREE,
               i == m.truth ? ", which lies in it" : "");
    }
    printf("fits that stopped: %d\n", m.stopped);
    replay_print(&found, &m);
}

/* ---- coverage ------------------------------------------------------------ */

/* 95 % of chi squared with 6 degrees of freedom. */
#define CHI_SQUARED_95 12.591587243743977

/* Whether the truth is in the ellipsoid about a pose. */
static int is_covered(const bench_scene *s, const rigcal_pose *pose, double sigma)
{
    rigcal_pose_uncertainty u;
    double R[9], t[3], d[6], Sigma[36];

    if (rigcal_pose_covariance(&u, &VIEW(&s->camera, s->seen, NULL, s->n),
                               &pose->cam_from_world, RC(sigma)) != RIGCAL_OK) {
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
    const bench_family *const f = &bench_families[0];
    const bench_view view = view_of(SIGMA_PX);
    int solved = 0, known = 0, estimated = 0;
    tally statuses;

    memset(&statuses, 0, sizeof statuses);
    for (long i = 0; i < scenes; i++) {
        bench_scene s;
        bench_solution found;

        bench_scene_make(&s, f, POINTS, i, &view);
        bench_solve(&found, &s, NULL);
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
           "it from.\n\n",
           scenes, f->name, POINTS, SIGMA_PX, CHI_SQUARED_95, 2 * POINTS - 6);
    printf("| sigma | solved | truth inside 95 %% | standard error |\n"
           "| --- | ---: | ---: | ---: |\n");
    coverage_print("known", known, solved);
    coverage_print("estimated", estimated, solved);
    printf("\nNot OK: ");
    tally_print(&statuses);
    printf("\n");
}

/* ---- float against double ------------------------------------------------ */

/* What one build writes about a scene for the other build. */
typedef struct {
    double R[9], t[3];
    rigcal_status status;
} answer;

static void write_answers(int scenes, double sigma)
{
    const bench_view view = view_of(sigma);

    for (int i = 0; i < BENCH_FAMILIES * COUNTS; i++) {
        const bench_family *const f = &bench_families[i / COUNTS];

        for (long index = 0; bench_has(f, counts[i % COUNTS]) && index < scenes; index++) {
            bench_scene s;
            bench_solution found;
            answer a;

            memset(&a, 0, sizeof a);
            bench_scene_make(&s, f, counts[i % COUNTS], index, &view);
            bench_solve(&found, &s, NULL);
            a.status = found.status;
            if (found.status >= 0) {
                bench_first(a.R, a.t, &found);
            }
            if (fwrite(&a, sizeof a, 1, stdout) != 1) {
                fail("the answers cannot be written");
            }
        }
    }
}

typedef struct {
    tally statuses;
    int right[2], alike, bounded; /* right there, right here; another pose here that fits
                                     alike */
    double squares[2], between;
} compare_cell;

/* Sums that differ by less may be the same in two precisions. */
#define ALIKE_TOL 0.01

static void compare_errors(compare_cell *cell, const bench_scene *s, const answer *there,
                           const bench_solution *here)
{
    double R[9], t[3], d[6], deviation[6];

    if (!bench_bound(deviation, s)) {
        return;
    }
    bench_first(R, t, here);
    test_difference(d, there->R, there->t, R, t);
    cell->bounded++;
    cell->squares[0] += mean_square(s, deviation, there->R, there->t);
    cell->squares[1] += mean_square(s, deviation, R, t);
    for (int k = 0; k < 6; k++) {
        cell->between += d[k] / deviation[k] * (d[k] / deviation[k]) / 6;
    }
}

/* Whether this build's first pose lies in the best minimum, if that of the other build
 * does. 0: it does not. */
static int compare_try(compare_cell *cell, const bench_scene *s, const answer *there)
{
    bench_solution here;
    rigcal_pose_options options;
    bench_minima m;
    int first;

    (void)rigcal_pose_defaults(&options);
    bench_solve_and_find(&here, &m, s, &options);
    tally_add(&cell->statuses, here.status);
    if (there->status < 0) {
        return 1;
    }
    first = bench_minima_add(&m, there->R, there->t);
    if (!bench_is_best(&m, first, BENCH_SUM_TOL)) {
        return 1;
    }
    cell->right[0]++;
    first = here.status < 0 ? -1 : bench_minimum_of(&m, &here, 0);
    if (!bench_is_best(&m, first, BENCH_SUM_TOL)) {
        const int alike = bench_is_best(&m, first, ALIKE_TOL);

        cell->alike += alike;
        return alike;
    }
    cell->right[1]++;
    if (first == m.truth) {
        compare_errors(cell, s, there, &here);
    }
    return 1;
}

static void compare_print(const compare_cell *cell)
{
    printf(" | %d | %d | %d | %.4f | %.4f | %.4f | ", cell->right[0],
           cell->right[0] - cell->right[1], cell->alike,
           root(cell->squares[0], cell->bounded), root(cell->squares[1], cell->bounded),
           root(cell->between, cell->bounded));
    tally_print(&cell->statuses);
    printf(" |\n");
    fflush(stdout);
}

static void compare_add(compare_cell *sum, const compare_cell *cell)
{
    tally_sum(&sum->statuses, &cell->statuses);
    for (int i = 0; i < 2; i++) {
        sum->right[i] += cell->right[i];
        sum->squares[i] += cell->squares[i];
    }
    sum->alike += cell->alike;
    sum->bounded += cell->bounded;
    sum->between += cell->between;
}

static void compare_row(compare_cell *cell, const bench_family *f, int n, int scenes,
                        const bench_view *view)
{
    for (long index = 0; index < scenes; index++) {
        bench_scene s;
        answer there;

        if (fread(&there, sizeof there, 1, stdin) != 1) {
            fail("stdin has too few answers");
        }
        bench_scene_make(&s, f, n, index, view);
        if (!compare_try(cell, &s, &there)) {
            fprintf(stderr, "%s %d %ld\n", f->name, n, index);
        }
    }
    printf("| %s | %d", f->name, n);
    compare_print(cell);
}

static void bench_compare(int scenes, double sigma)
{
    const bench_view view = view_of(sigma);
    compare_cell all;

    printf("%d scenes a line, %g px noise, f = 800 px, %g to %g sizes away, with "
           "the answers of another build,\ncalled there. Right: its first pose "
           "lies in the best minimum. Wrong here: this build's does not;\nof "
           "these, the sum of the one it lies in is within %g. Errors: rms of the "
           "six parameters over\ntheir Cramer-Rao bounds, where both are right "
           "and so is the minimum; then the two answers'\ndifference over the "
           "bound. Scenes that go wrong here, and not by a hair, are on "
           "stderr.\n\n",
           scenes, sigma, view.nearest, view.farthest, ALIKE_TOL);
    printf("| target | points | right there | wrong here | by a hair "
           "| error / bound there | here | difference / bound | not OK here |\n"
           "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | --- |\n");
    memset(&all, 0, sizeof all);
    for (int i = 0; i < BENCH_FAMILIES * COUNTS; i++) {
        if (bench_has(&bench_families[i / COUNTS], counts[i % COUNTS])) {
            compare_cell cell;

            memset(&cell, 0, sizeof cell);
            compare_row(&cell, &bench_families[i / COUNTS], counts[i % COUNTS], scenes,
                        &view);
            compare_add(&all, &cell);
        }
    }
    printf("| all |");
    compare_print(&all);
}

/* ---- solve: for callgrind ------------------------------------------------ */

static rigcal_status solve_one(const bench_scene *s, const rigcal_pose_options *options)
{
    rigcal_pose poses[RIGCAL_POSES_MAX];
    size_t n_found;

    return rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL,
                             &VIEW(&s->camera, s->seen, NULL, s->n), options);
}

static void solve_some(const bench_family *f, int n, int count, int warm)
{
    const bench_view view = view_of(SIGMA_PX);
    rigcal_pose_options options;
    tally statuses;

    memset(&statuses, 0, sizeof statuses);
    (void)rigcal_pose_defaults(&options);
    options.use_start = warm;
    for (long i = 0; i < count; i++) {
        bench_scene s;

        bench_scene_make(&s, f, n, i, &view);
        if (warm) {
            double R[9], t[3];

            bench_disturb(R, t, &s);
            options.start = test_transform(R, t);
        }
        tally_add(&statuses, solve_one(&s, &options));
    }
    printf("%s, %d points, %g px noise%s: %d solved; not OK: ", f->name, n, SIGMA_PX,
           warm ? ", warm" : "", count);
    tally_print(&statuses);
    printf("\n");
}

/* ---- the program --------------------------------------------------------- */

static void usage(void)
{
    fail("usage: bench_pose minima [SCENES] [SIGMA_PX] [--known] [--list] | "
         "replay FAMILY N INDEX [SIGMA_PX] | coverage [SCENES] | "
         "answers [SCENES] [SIGMA_PX] | compare [SCENES] [SIGMA_PX] | "
         "solve FAMILY N COUNT [warm]");
}

static int whole_number(const char *text, int least, int most)
{
    char *end;
    const long number = strtol(text, &end, 10);

    if (end == text || *end != '\0' || number < least || number > most) {
        fprintf(stderr, "bench_pose: %s is no number from %d to %d\n", text, least, most);
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

static const bench_family *family_of(const char *name)
{
    const bench_family *f = bench_family_of(name);

    if (!f) {
        fprintf(stderr, "bench_pose: FAMILY is one of");
        for (int i = 0; i < BENCH_FAMILIES; i++) {
            fprintf(stderr, " %s", bench_families[i].name);
        }
        fprintf(stderr, "\n");
        exit(2);
    }
    return f;
}

/* The first line, which says what was measured. */
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
    int scenes = SCENES, known = 0, list = 0, given = 0;

    (void)rigcal_pose_defaults(&options);
    for (int i = 2; i < argc; i++) {
        if (strcmp(argv[i], "--known") == 0) {
            known = 1;
        } else if (strcmp(argv[i], "--list") == 0) {
            list = 1;
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
    bench_minima_table(scenes, sigma, &options, list);
}

static int points_of(const char *text, const bench_family *f)
{
    return whole_number(text, 4, f->is_tag ? 4 : TEST_SCENE_MAX);
}

static void run_replay(int argc, char **argv)
{
    const bench_family *f;

    if (argc != 5 && argc != 6) {
        usage();
    }
    f = family_of(argv[2]);
    print_build();
    bench_replay(f, points_of(argv[3], f), whole_number(argv[4], 0, SCENES_MAX),
                 argc > 5 ? sigma_of(argv[5]) : SIGMA_PX);
}

static void run_float(int argc, char **argv, int compares)
{
    const int scenes = argc > 2 ? whole_number(argv[2], 1, SCENES_MAX) : SCENES;
    const double sigma = argc > 3 ? sigma_of(argv[3]) : SIGMA_PX;

    if (argc > 4) {
        usage();
    }
    if (compares) {
        print_build();
        bench_compare(scenes, sigma);
    } else {
        write_answers(scenes, sigma);
    }
}

static void run_solve(int argc, char **argv)
{
    const int warm = argc == 6 && strcmp(argv[5], "warm") == 0;
    const bench_family *f;

    if (argc != 5 + warm) {
        usage();
    }
    f = family_of(argv[2]);
    print_build();
    solve_some(f, points_of(argv[3], f), whole_number(argv[4], 1, SCENES_MAX), warm);
}

int main(int argc, char **argv)
{
    const char *const what = argc > 1 ? argv[1] : "";

    if (strcmp(what, "minima") == 0) {
        run_minima(argc, argv);
    } else if (strcmp(what, "replay") == 0) {
        run_replay(argc, argv);
    } else if (strcmp(what, "coverage") == 0 && argc <= 3) {
        print_build();
        bench_coverage(argc > 2 ? whole_number(argv[2], 1, SCENES_MAX) : SCENES);
    } else if (strcmp(what, "answers") == 0 || strcmp(what, "compare") == 0) {
        run_float(argc, argv, strcmp(what, "compare") == 0);
    } else if (strcmp(what, "solve") == 0) {
        run_solve(argc, argv);
    } else {
        usage();
    }
    return 0;
}
