/* bench_choose: the choice between two poses of each view, on simulated rigs of square tags
 * (f = 800 px, 0.3 px, cameras over 70 degrees of arc); as Markdown of BENCHMARKS.md.
 *
 *   bench_choose [RIGS]                     the table, so many rigs a line (default 40)
 *   bench_choose one C F DISTANCE SHARE     one rig, for an instruction count: the choice
 *                                           alone, twice as often with a further argument
 *
 * A rig is right when its adjustment ends in the minimum that it ends in from the truth,
 * every view with its true pose: the same sum, to 1e-6 of it. The ceiling is the share of
 * rigs of which that is so when each view starts from its true pose. Views alone in their
 * placement are counted as poses, not in the adjustment. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "test_tags.h"

enum { RIGS = 40, RIGS_MAX = 100000 };

#define SAME_SUM TOL(1e-6, 1e-3)

typedef struct {
    double distance;
    int cameras, placements;
    double share;
} line;

static const line lines[] = {{10, 2, 6, 1},  {10, 4, 10, 1},   {20, 2, 10, 1},
                             {30, 2, 10, 1}, {20, 4, 10, 1},   {30, 4, 10, 1},
                             {20, 8, 50, 1}, {20, 4, 20, 0.5}, {20, 6, 20, 1 / 3.}};

/* Unity needs these: the arithmetic of the tests uses its checks. */
void setUp(void)
{
}

void tearDown(void)
{
}

static void *some(size_t n, size_t size)
{
    void *const memory = calloc(n, size);

    if (!memory) {
        fputs("bench_choose: no memory\n", stderr);
        exit(1);
    }
    return memory;
}

static void make(test_tags *t, size_t C, size_t F)
{
    const size_t V = C * F;

    memset(t, 0, sizeof *t);
    t->true_cams = some(C, sizeof *t->true_cams);
    t->true_places = some(F, sizeof *t->true_places);
    t->right = some(V, 1);
    t->cams = some(C, sizeof *t->cams);
    t->places = some(F, sizeof *t->places);
    t->group = some(C, sizeof *t->group);
    t->views = some(V, sizeof *t->views);
    t->own = some(V, sizeof *t->own);
    t->second = some(V, sizeof *t->second);
    t->o = some(4 * V, sizeof *t->o);
    t->takes = some(V, 1);
    t->rig.work_capacity = TEST_TAGS_WORK(C, F);
    t->work = some(t->rig.work_capacity, sizeof *t->work);
}

static void unmake(test_tags *t)
{
    free(t->true_cams);
    free(t->true_places);
    free(t->right);
    free(t->cams);
    free(t->places);
    free(t->group);
    free(t->views);
    free(t->own);
    free(t->second);
    free(t->o);
    free(t->takes);
    free(t->work);
}

/* The number of other views of this view's placement that are not left out. */
static int company_of(const test_tags *t, const uint8_t *takes, size_t view)
{
    int n = 0;

    for (size_t v = 0; v < t->rig.n_views; v++) {
        n += takes[v] != RIGCAL_TAKES_NONE &&
             t->views[v].placement == t->views[view].placement;
    }
    return n;
}

/* The sum where the adjustment ends; below 0: it failed. Counts only views that are not
 * left out and not alone in their placement. Nothing shows which pose a view has that is
 * alone, and the cameras do not depend on it. */
static double adjusted(test_tags *t, const uint8_t *takes)
{
    rigcal_rig_view *const some_views = some(t->rig.n_views, sizeof *some_views);
    rigcal_rig_fit fit;
    rigcal_rig rig = t->rig;
    double sum = -1;

    rig.view_poses = NULL;
    rig.views = some_views;
    rig.n_views = 0;
    for (size_t v = 0; v < t->rig.n_views; v++) {
        if (takes[v] != RIGCAL_TAKES_NONE && company_of(t, takes, v) > 1) {
            some_views[rig.n_views++] = t->views[v];
        }
    }
    if (rigcal_rig_adjust(&fit, NULL, &rig) >= 0) {
        sum = D(fit.sum);
    }
    free(some_views);
    return sum;
}

/* Joins all views with these poses by rigcal_rig_join. This is the start of an
 * adjustment. */
static double joined(test_tags *t, const uint8_t *poses, const uint8_t *takes)
{
    rigcal_view_pose *const own = some(t->rig.n_views, sizeof *own);
    double sum = -1;

    for (size_t v = 0; v < t->rig.n_views; v++) {
        own[v] = poses && poses[v] ? t->second[v] : t->own[v];
    }
    t->rig.view_poses = own;
    if (rigcal_rig_join(&t->rig, NULL) >= 0) {
        sum = adjusted(t, takes);
    }
    t->rig.view_poses = t->own;
    free(own);
    return sum;
}

static int is_same(double sum, double truth)
{
    return sum >= 0 && fabs(sum - truth) <= SAME_SUM * truth;
}

static void row(const line *l, int rigs, test_rng *rng)
{
    double views = 0, first = 0, wrong = 0, out = 0, failed = 0;
    int right_first = 0, right_chosen = 0, ceiling = 0;
    test_tags t;

    make(&t, (size_t)l->cameras, (size_t)l->placements);
    t.distance = l->distance;
    t.share_seen = l->share;
    t.noise_px = 0.3;
    for (int i = 0; i < rigs; i++) {
        double truth, sum;
        rigcal_status status;

        test_tags_random(&t, rng, l->cameras, l->placements);
        test_tags_solve(&t);
        status = rigcal_rig_choose(&t.choice, NULL, &t.rig);
        failed += status < 0;
        if (status >= 0) {
            views += (double)t.rig.n_views;
            first += test_tags_wrong_first(&t);
            wrong += test_tags_wrong(&t);
            out += test_tags_left_out(&t);
        }
        /* of the adjusted views: from the choice, from the truth */
        sum = status >= 0 ? adjusted(&t, t.takes) : -1;
        for (int c = 0; c < l->cameras; c++) {
            t.cams[c] = t.true_cams[c];
        }
        for (int f = 0; f < l->placements; f++) {
            t.places[f] = t.true_places[f];
        }
        truth = adjusted(&t, t.takes);
        right_chosen += is_same(sum, truth);
        ceiling += is_same(joined(&t, t.right, t.takes), truth);
        right_first += is_same(joined(&t, NULL, t.takes), truth);
    }
    printf("| %g | %d x %d", l->distance, l->cameras, l->placements);
    if (l->share < 1) {
        printf(" (%.0f %% seen)", 100 * l->share);
    }
    printf(" | %.1f %% | %.2f %% | %.2f %% | %.0f %% | %.0f %% | %.0f %% | %.0f |\n",
           100 * first / views, 100 * wrong / views, 100 * out / views,
           100.0 * right_first / rigs, 100.0 * right_chosen / rigs, 100.0 * ceiling / rigs,
           failed);
    fflush(stdout);
    unmake(&t);
}

static int one(char **argv, int is_twice)
{
    test_tags t;
    test_rng rng = test_seed(5);
    const int C = atoi(argv[0]), F = atoi(argv[1]);
    rigcal_status status = 0;

    if (C < 1 || F < 1 || C > 1000 || F > 10000) {
        fputs("bench_choose: cameras 1 .. 1000, placements 1 .. 10000\n", stderr);
        return 2;
    }
    make(&t, (size_t)C, (size_t)F);
    t.distance = atof(argv[2]);
    t.share_seen = atof(argv[3]);
    t.noise_px = 0.3;
    test_tags_random(&t, &rng, C, F);
    test_tags_solve(&t);
    for (int i = 0; i < 1 + is_twice; i++) {
        status = rigcal_rig_choose(&t.choice, NULL, &t.rig);
    }
    printf("%s: %zu views, %d wrong first, %d wrong, %d left out, tau2 %g, share %.3f, "
           "sigma %.3f px\n",
           rigcal_status_name(status), t.rig.n_views, test_tags_wrong_first(&t),
           test_tags_wrong(&t), test_tags_left_out(&t), D(t.choice.tau2), D(t.choice.share),
           D(t.choice.sigma_px));
    unmake(&t);
    return status < 0;
}

int main(int argc, char *argv[])
{
    test_rng rng = test_seed(1);
    int rigs = argc > 1 ? atoi(argv[1]) : RIGS;

    if (argc >= 6 && !strcmp(argv[1], "one")) {
        return one(argv + 2, argc > 6);
    }
    if (argc > 2 || rigs < 1 || rigs > RIGS_MAX) {
        fputs("usage: bench_choose [RIGS]\n"
              "       bench_choose one C F DISTANCE SHARE [TWICE]\n",
              stderr);
        return 2;
    }
    printf("| distance [sizes] | cameras x placements | wrong first | wrong after | left "
           "out | rigs right: first poses | chosen | ceiling | refused |\n"
           "| ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        row(&lines[i], rigs, &rng);
    }
    return 0;
}
