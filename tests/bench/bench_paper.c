/* bench_paper: the figures of BENCHMARKS.md about the published method, as Markdown.
 *
 *   bench_paper grid [SCENES]  the search without a guess, on random scenes
 *   bench_paper data [DIR]...  what the elimination does, on real cameras
 *   bench_paper pairs [DIR]... what the choice of pairs does, on real cameras
 *
 * A DIR holds cameras.csv, observations.csv and reference_poses.csv, as told in
 * examples/data/FORMAT.md; all the sets of this tree when none is given. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_tally.h"
#include "cli_input.h"
#include "test_support.h"

#define DEGREE (TEST_PI / 180)

/* Unity needs these: the scenes of the tests use its checks. */
void setUp(void)
{
}

void tearDown(void)
{
}

/* ---- grid: the search without a guess ------------------------------------ */

enum { SCENES = 1000, SCENES_MAX = 1000000, PAIRS_MAX = 4 * TEST_SCENE_MAX };

#define NOISE_PX 0.5
#define FOCAL_PX 800.0

/* What counts as the true pose of exact images, and as fitting noisy ones as well
 * as the optimum that the truth lies in. */
#define RIGHT_DEGREES TOL(0.001, 0.05)
#define RIGHT_RMS 1.05

typedef struct {
    tally statuses;
    int right, solved;
    double evals;
    int truth_failed; /* noisy scenes in which the search from the truth gave no pose */
} grid_cell;

typedef struct {
    rigcal_bearing bearings[TEST_SCENE_MAX];
    rigcal_pair pairs[PAIRS_MAX];
    size_t n, n_pairs;
} problem;

static rigcal_status see(problem *p, const test_scene *scene)
{
    p->n = (size_t)scene->n;
    test_bearings(p->bearings, scene);
    return rigcal_pairs_choose(p->pairs, rigcal_pairs_for(p->n), &p->n_pairs, p->bearings,
                               p->n);
}

static rigcal_status solve(rigcal_paper_pose *pose, const problem *p,
                           const rigcal_paper_options *options)
{
    return rigcal_paper_solve(pose, p->bearings, p->n, p->pairs, p->n_pairs, options);
}

/* The angle in degrees between a pose's rotation and the true one. */
static double turned(const rigcal_transform *found, const double R_true[9])
{
    double R[9];

    test_transform_parts(R, NULL, found);
    return test_angle_between(R, R_true) / DEGREE;
}

/* The rms distance of the scene's points from their images at the true pose. */
static double rms_of_truth(const test_scene *scene)
{
    double sum = 0;

    for (int i = 0; i < scene->n; i++) {
        double xy[2];

        test_project(xy, scene->R, scene->t, scene->X[i]);
        sum += pow(xy[0] - scene->xy[i][0], 2) + pow(xy[1] - scene->xy[i][1], 2);
    }
    return sqrt(sum / scene->n);
}

/* The rms that a search must reach. The other optimum of a flat target may fit better than
 * the one at the truth, and then it is right. */
static double rms_from_truth(grid_cell *cell, const problem *p, const test_scene *scene)
{
    rigcal_paper_options options;
    rigcal_paper_pose pose;

    (void)rigcal_paper_defaults(&options);
    options.use_guess = 1;
    test_to_real(options.guess_ypr, scene->ypr, 3);
    if (solve(&pose, p, &options) < 0) {
        cell->truth_failed++;
        return rms_of_truth(scene);
    }
    return D(pose.rms);
}

static int is_right(grid_cell *cell, const rigcal_paper_pose *pose, const problem *p,
                    const test_scene *scene, int noisy)
{
    if (noisy) {
        return D(pose->rms) <= RIGHT_RMS * rms_from_truth(cell, p, scene);
    }
    return turned(&pose->cam_from_world, scene->R) <= RIGHT_DEGREES;
}

static void grid_try(grid_cell *cell, const test_scene *scene, int noisy)
{
    problem p;
    rigcal_paper_pose pose;
    rigcal_status status = see(&p, scene);

    if (status == RIGCAL_OK) {
        status = solve(&pose, &p, NULL);
    }
    tally_add(&cell->statuses, status);
    if (status >= 0) {
        cell->solved++;
        cell->evals += (double)pose.evals;
        cell->right += is_right(cell, &pose, &p, scene, noisy);
    }
}

static void add_noise(test_scene *scene, test_rng *rng)
{
    for (int i = 0; i < scene->n; i++) {
        for (int k = 0; k < 2; k++) {
            scene->xy[i][k] += NOISE_PX / FOCAL_PX * test_normal(rng);
        }
    }
}

static void print_cell(const grid_cell *cell, int scenes)
{
    printf(" %.1f %% | %.0f | ", 100.0 * cell->right / scenes,
           cell->solved > 0 ? cell->evals / cell->solved : 0.0);
    tally_print(&cell->statuses);
    printf(" |");
}

/* Prints one line: the same scenes with exact and with noisy images. Returns how often the
 * search from the truth failed. */
static int grid_row(test_shape shape, const char *name, int n, int scenes)
{
    test_rng rng = test_seed((uint64_t)(1000 * (int)shape + n));
    test_scene scene;
    grid_cell exact, noisy;

    memset(&exact, 0, sizeof exact);
    memset(&noisy, 0, sizeof noisy);
    for (int i = 0; i < scenes; i++) {
        test_scene_random(&scene, &rng, n, shape);
        grid_try(&exact, &scene, 0);
        add_noise(&scene, &rng);
        grid_try(&noisy, &scene, 1);
    }
    printf("| %s | %d |", name, n);
    print_cell(&exact, scenes);
    print_cell(&noisy, scenes);
    printf("\n");
    fflush(stdout);
    return noisy.truth_failed;
}

static void bench_grid(int scenes)
{
    static const int counts[] = {4, 5, 6, 8, 12, 20, 50};
    static const char *const names[] = {"general", "planar", "square"};
    int truth_failed = 0;

    printf("%d scenes a line. Right: exact, rotation within %g degrees; "
           "noisy, rms within\n%g times that of the search from the truth.\n\n",
           scenes, RIGHT_DEGREES, RIGHT_RMS);
    printf("| target | points | exact: right | evaluations | not OK "
           "| %g px noise: right | evaluations | not OK |\n",
           NOISE_PX);
    printf("| --- | ---: | ---: | ---: | --- | ---: | ---: | --- |\n");
    for (int shape = TEST_GENERAL; shape <= TEST_SQUARE; shape++) {
        for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
            truth_failed += grid_row((test_shape)shape, names[shape], counts[i], scenes);
        }
    }
    printf("\nNoisy scenes where the search from the truth gave no pose, and the "
           "rms of the true pose\ncounts: %d.\n",
           truth_failed);
}

/* ---- real views ---------------------------------------------------------- */

typedef struct {
    const char *set;
    rigcal_bearing *bearings;
    size_t n;
    rigcal_transform reference;
} real_view;

/* Results of one set, or of all sets. */
typedef struct {
    real_view *list;
    size_t count;
} real_views;

static const char *join(const char *folder, const char *file)
{
    const size_t size = strlen(folder) + strlen(file) + 2;
    char *const path = cli_alloc(size, 1);

    snprintf(path, size, "%s/%s", folder, file);
    return path;
}

/* The last part of a path. The path may end with a slash. */
static const char *name_of(const char *folder)
{
    size_t end = strlen(folder), begin;
    char *name;

    while (end > 1 && folder[end - 1] == '/') {
        end--;
    }
    for (begin = end; begin > 0 && folder[begin - 1] != '/'; begin--) {
    }
    name = cli_alloc(end - begin + 1, 1);
    memcpy(name, folder + begin, end - begin);
    return name;
}

/* Reads the pose of a row. Its digits make a rotation except for rounding. */
static void read_pose(rigcal_transform *pose, const csv_table *table, size_t row)
{
    char name[] = "R11", axis[] = "tx";
    rigcal_real M[9];

    for (int i = 0; i < 9; i++) {
        name[1] = (char)('1' + i / 3);
        name[2] = (char)('1' + i % 3);
        M[i] = csv_real(table, row, csv_column(table, name));
    }
    for (int i = 0; i < 3; i++) {
        axis[1] = (char)('x' + i);
        pose->t[i] = csv_real(table, row, csv_column(table, axis));
    }
    if (rigcal_rotation_nearest(pose->R, M) != RIGCAL_OK) {
        csv_fail(table, row, "R11 to R33 are not a rotation");
    }
}

static void read_bearings(real_view *view, const cli_cameras *cameras,
                          const cli_observations *seen, size_t camera, size_t frame)
{
    rigcal_observation *const observed = cli_alloc(seen->count, sizeof *observed);
    rigcal_status status;

    for (size_t i = 0; i < seen->count; i++) {
        if (seen->list[i].camera == camera && seen->list[i].frame == frame) {
            observed[view->n++] = cli_seen(seen, &seen->list[i]);
        }
    }
    if (view->n == 0) {
        cli_fail("%s: a reference pose has no observations", view->set);
    }
    view->bearings = cli_alloc(view->n, sizeof *view->bearings);
    status = rigcal_bearings_of_view(
        view->bearings, NULL, &VIEW(&cameras->camera[camera], observed, NULL, view->n));
    if (status != RIGCAL_OK) {
        cli_fail("%s: a view has no rays: %s", view->set, rigcal_status_text(status));
    }
}

/* Reads a set: a view for each reference pose. */
static real_views read_set(const char *folder)
{
    cli_cameras cameras;
    cli_observations seen;
    csv_table poses;
    real_views views;

    cli_cameras_read(&cameras, join(folder, "cameras.csv"));
    cli_observations_read(&seen, join(folder, "observations.csv"), &cameras, 1);
    cli_observations_by_view(&seen);
    csv_read(&poses, join(folder, "reference_poses.csv"));
    views.count = poses.n_rows;
    views.list = cli_alloc(poses.n_rows, sizeof *views.list);
    for (size_t row = 0; row < poses.n_rows; row++) {
        const char *camera = csv_id(&poses, row, csv_column(&poses, "camera"));
        const char *frame = csv_id(&poses, row, csv_column(&poses, "frame"));

        views.list[row].set = name_of(folder);
        read_pose(&views.list[row].reference, &poses, row);
        read_bearings(&views.list[row], &cameras, &seen,
                      cli_names_find(&cameras.names, camera),
                      cli_names_find(&seen.frames, frame));
    }
    return views;
}

/* ---- errors of real views ------------------------------------------------ */

typedef struct {
    tally statuses;
    double *degrees, *percent; /* of the views that were solved */
    size_t solved;
    double evals;
} errors;

static errors errors_for(size_t count)
{
    errors e;

    memset(&e, 0, sizeof e);
    e.degrees = cli_alloc(count, sizeof *e.degrees);
    e.percent = cli_alloc(count, sizeof *e.percent);
    return e;
}

static void errors_add(errors *e, const rigcal_paper_pose *pose,
                       const rigcal_transform *reference)
{
    double R[9], t[3], t_found[3], dt[3];

    test_transform_parts(R, t, reference);
    test_transform_parts(NULL, t_found, &pose->cam_from_world);
    for (int k = 0; k < 3; k++) {
        dt[k] = t_found[k] - t[k];
    }
    e->degrees[e->solved] = turned(&pose->cam_from_world, R);
    e->percent[e->solved] = 100 * test_norm(dt) / test_norm(t);
    e->solved++;
    e->evals += (double)pose->evals;
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

/* Prints "worst | median": the last and the middle of the sorted errors. */
static void print_spread(double error[], size_t n)
{
    if (n == 0) {
        printf(" - | - |");
        return;
    }
    qsort(error, n, sizeof *error, by_size);
    printf(" %.3f | %.3f |", error[n - 1], (error[(n - 1) / 2] + error[n / 2]) / 2);
}

static void errors_print(errors *e)
{
    print_spread(e->degrees, e->solved);
    print_spread(e->percent, e->solved);
    printf(" %.0f | ", e->solved > 0 ? e->evals / (double)e->solved : 0.0);
    tally_print(&e->statuses);
    printf(" |\n");
    fflush(stdout);
}

#define ERROR_COLUMNS \
    " rotation [deg]: worst | median | translation [%%]: worst | median " \
    "| evaluations | not OK |\n"
#define ERROR_RULE " ---: | ---: | ---: | ---: | ---: | --- |\n"

/* Options whose guess is the reference pose with an error. */
static rigcal_paper_options options_near(const real_view *view)
{
    static const double off[3] = {3, -3, 3};
    rigcal_paper_options options;

    (void)rigcal_paper_defaults(&options);
    options.use_guess = 1;
    if (rigcal_yaw_pitch_roll_from_rotation(options.guess_ypr, view->reference.R) < 0) {
        cli_fail("%s: a reference pose has no angles", view->set);
    }
    for (int k = 0; k < 3; k++) {
        options.guess_ypr[k] += RC(off[k] * DEGREE);
    }
    return options;
}

static void solve_view(errors *e, const real_view *view, const rigcal_pair pairs[],
                       size_t n_pairs, int32_t pairs_used, int32_t eliminated)
{
    rigcal_paper_options options = options_near(view);
    rigcal_paper_pose pose;
    rigcal_status status;

    options.pairs_used = pairs_used;
    options.eliminated = eliminated;
    status = rigcal_paper_solve(&pose, view->bearings, view->n, pairs, n_pairs, &options);
    tally_add(&e->statuses, status);
    if (status >= 0) {
        errors_add(e, &pose, &view->reference);
    }
}

static void print_set(const char *set, const real_views *views)
{
    printf("| %s | %lu |", set, (unsigned long)views->count);
}

/* ---- data: what eliminates, and what is eliminated ----------------------- */

static rigcal_pair *choose(size_t *n_pairs, const real_view *view, size_t capacity)
{
    rigcal_pair *const pairs = cli_alloc(capacity, sizeof *pairs);
    const rigcal_status status =
        rigcal_pairs_choose(pairs, capacity, n_pairs, view->bearings, view->n);

    if (status != RIGCAL_OK) {
        cli_fail("%s: a view has no pairs: %s", view->set, rigcal_status_text(status));
    }
    return pairs;
}

static void data_row(const char *set, const real_views *views, int32_t pairs_used,
                     int32_t eliminated)
{
    static const char *const angle[] = {"yaw", "pitch", "roll", "best conditioned"};
    errors e = errors_for(views->count);

    for (size_t i = 0; i < views->count; i++) {
        const real_view *view = &views->list[i];
        size_t n_pairs;
        const rigcal_pair *pairs = choose(&n_pairs, view, rigcal_pairs_for(view->n));

        solve_view(&e, view, pairs, n_pairs, pairs_used, eliminated);
    }
    print_set(set, views);
    printf(" %s | %s |", pairs_used == 2 ? "two pairs" : "all pairs", angle[eliminated]);
    errors_print(&e);
}

static void data_rows(const char *set, const real_views *views)
{
    for (int32_t pairs_used = 2; pairs_used >= 0; pairs_used -= 2) {
        for (int32_t e = RIGCAL_YAW; e <= RIGCAL_BEST_CONDITIONED; e++) {
            data_row(set, views, pairs_used, e);
        }
    }
}

static void data_head(void)
{
    printf("| set | views | eliminating | eliminated |" ERROR_COLUMNS);
    printf("| --- | ---: | --- | --- |" ERROR_RULE);
}

/* ---- pairs: which are taken ---------------------------------------------- */

typedef struct {
    rigcal_pair *pairs;
    size_t n;
} pair_list;

/* Adds a pair to the list, unless it has no equation. */
static void add_pair(pair_list *list, const real_view *view, size_t i, size_t j)
{
    if (rigcal_pair_make(&list->pairs[list->n], view->bearings, view->n, (int32_t)i,
                         (int32_t)j) == RIGCAL_OK) {
        list->n++;
    }
}

/* Adds the pairs (i, i + stride) round the circle of indices, each pair once. */
static void add_stride(pair_list *list, const real_view *view, size_t stride)
{
    const size_t n = view->n;

    for (size_t i = 0; i < (2 * stride == n ? stride : n); i++) {
        add_pair(list, view, i, (i + stride) % n);
    }
}

static pair_list list_for(const real_view *view)
{
    pair_list list = {NULL, 0};

    list.pairs = cli_alloc(4 * view->n, sizeof *list.pairs);
    return list;
}

static pair_list chosen(const real_view *view, size_t capacity)
{
    pair_list list;

    list.pairs = choose(&list.n, view, capacity);
    return list;
}

static pair_list take_chosen(const real_view *view)
{
    return chosen(view, rigcal_pairs_for(view->n));
}

static pair_list take_quarter(const real_view *view)
{
    return chosen(view, view->n);
}

static pair_list take_stride(const real_view *view, size_t stride)
{
    pair_list list = list_for(view);

    add_stride(&list, view, stride);
    return list;
}

static pair_list take_neighbours(const real_view *view)
{
    return take_stride(view, 1);
}

static pair_list take_halves(const real_view *view)
{
    return take_stride(view, view->n / 2);
}

static pair_list take_thirds(const real_view *view)
{
    return take_stride(view, view->n / 3);
}

static pair_list take_quarters(const real_view *view)
{
    return take_stride(view, view->n / 4);
}

static pair_list take_all_strides(const real_view *view)
{
    const size_t stride[4] = {1, view->n / 2, view->n / 3, view->n / 4};
    pair_list list = list_for(view);

    for (int s = 0; s < 4; s++) {
        int new = 1;

        for (int before = 0; before < s; before++) {
            new = new &&stride[before] != stride[s];
        }
        if (new) {
            add_stride(&list, view, stride[s]);
        }
    }
    return list;
}

static double between_rays(const rigcal_bearing *a, const rigcal_bearing *b)
{
    double m_a[3], m_b[3], across[3];

    test_to_double(m_a, a->ray, 3);
    test_to_double(m_b, b->ray, 3);
    test_cross(across, m_a, m_b);
    return atan2(test_norm(across), test_dot(m_a, m_b));
}

/* The bearing whose distance from the nearest of the `count` bearings in `of` is
 * largest. */
static size_t farthest(const real_view *view, const size_t of[], int count)
{
    size_t far = 0;
    double most = -1;

    for (size_t i = 0; i < view->n; i++) {
        double least = TEST_PI;

        for (int k = 0; k < count; k++) {
            least = fmin(least, between_rays(&view->bearings[i], &view->bearings[of[k]]));
        }
        if (least > most) {
            most = least;
            far = i;
        }
    }
    return far;
}

/* The six pairs of four points that are far apart in the image. */
static pair_list take_four_points(const real_view *view)
{
    pair_list list = list_for(view);
    size_t point[4] = {0, 0, 0, 0};

    point[0] = farthest(view, point, 1);
    for (int k = 1; k < 4; k++) {
        point[k] = farthest(view, point, k);
        for (int before = 0; before < k; before++) {
            add_pair(&list, view, point[before], point[k]);
        }
    }
    return list;
}

static const struct {
    const char *name;
    pair_list (*take)(const real_view *view);
} takes[] = {
    {"rigcal_pairs_choose", take_chosen},
    {"rigcal_pairs_choose, capacity n", take_quarter},
    {"(i, i + 1)", take_neighbours},
    {"(i, i + n/2)", take_halves},
    {"(i, i + n/3)", take_thirds},
    {"(i, i + n/4)", take_quarters},
    {"these four strides together", take_all_strides},
    {"four far-apart points", take_four_points},
};

static void pairs_row(const char *set, const real_views *views, size_t take)
{
    errors e = errors_for(views->count);
    double pairs = 0;

    for (size_t i = 0; i < views->count; i++) {
        const real_view *view = &views->list[i];
        const pair_list list = takes[take].take(view);

        solve_view(&e, view, list.pairs, list.n, 0, RIGCAL_BEST_CONDITIONED);
        pairs += (double)list.n;
    }
    print_set(set, views);
    printf(" %s | %.0f |", takes[take].name, pairs / (double)views->count);
    errors_print(&e);
}

static void pairs_rows(const char *set, const real_views *views)
{
    for (size_t take = 0; take < sizeof takes / sizeof takes[0]; take++) {
        pairs_row(set, views, take);
    }
}

static void pairs_head(void)
{
    printf("| set | views | pairs | mean number |" ERROR_COLUMNS);
    printf("| --- | ---: | --- | ---: |" ERROR_RULE);
}

/* ---- the program --------------------------------------------------------- */

static void append(real_views *all, const real_views *more)
{
    real_view *const list = cli_alloc(all->count + more->count, sizeof *list);

    if (all->count > 0) {
        memcpy(list, all->list, all->count * sizeof *list);
    }
    memcpy(list + all->count, more->list, more->count * sizeof *list);
    all->list = list;
    all->count += more->count;
}

static void bench_sets(void head(void), void rows(const char *set, const real_views *views),
                       const char *const folders[], int count)
{
    real_views all = {NULL, 0};

    printf("Guess: the reference, its yaw, pitch, roll off by (3, -3, 3) "
           "degrees. Errors are against\nthe reference; translation in percent "
           "of its length. Evaluations are a mean.\n\n");
    head();
    for (int i = 0; i < count; i++) {
        const real_views views = read_set(folders[i]);

        rows(views.list[0].set, &views);
        append(&all, &views);
    }
    if (count > 1) {
        rows("all", &all);
    }
}

static int scenes_of(const char *text)
{
    char *end;
    const long scenes = strtol(text, &end, 10);

    if (end == text || *end != '\0' || scenes < 1 || scenes > SCENES_MAX) {
        cli_fail("SCENES must be a number from 1 to %d", SCENES_MAX);
    }
    return (int)scenes;
}

/* The first line, which says what was measured. */
static void print_build(void)
{
    printf("rigcal %d.%d.%d, %s, rigcal_real %s\n\n", RIGCAL_VERSION_MAJOR,
           RIGCAL_VERSION_MINOR, RIGCAL_VERSION_PATCH, BENCH_BUILD,
           rigcal_sizeof_real() == sizeof(double) ? "double" : "float");
}

int main(int argc, char **argv)
{
    static const char *const sets[] = {BENCH_SETS};
    const char *const what = argc > 1 ? argv[1] : "";
    const int given = argc > 2;
    const char *const *const folders = given ? (const char *const *)(argv + 2) : sets;
    const int count = given ? argc - 2 : (int)(sizeof sets / sizeof sets[0]);

    if (strcmp(what, "grid") == 0 && argc <= 3) {
        const int scenes = given ? scenes_of(argv[2]) : SCENES;

        print_build();
        bench_grid(scenes);
    } else if (strcmp(what, "data") == 0) {
        print_build();
        bench_sets(data_head, data_rows, folders, count);
    } else if (strcmp(what, "pairs") == 0) {
        print_build();
        bench_sets(pairs_head, pairs_rows, folders, count);
    } else {
        cli_fail("usage: bench_paper grid [SCENES] | data [DIR]... | "
                 "pairs [DIR]...");
    }
    return 0;
}
