/* bench_cost: solves of rigcal_pose_solve, a column of a table each, for callgrind
 * (tests/bench/cost.sh).
 *
 *   bench_cost COLUMN COUNT [warm]
 *       only solves; COLUMN is "tag 4", "lens planar 50" and so on
 *   bench_cost check
 *       each column a few times: every pose is found */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_scenes.h"
#include "bench_tally.h"

#define SIGMA_PX 0.5

/* A plane is a grid with this number of columns. */
typedef struct {
    const char *name, *family;
    int n, is_lens, across;
} column;

static const column columns[] = {
    {"tag 4", "tag", 4, 0, 0},
    {"planar 4", "planar", 4, 0, 2},
    {"planar 8", "planar", 8, 0, 4},
    {"planar 50", "planar", 50, 0, 10},
    {"general 4", "general", 4, 0, 0},
    {"general 8", "general", 8, 0, 0},
    {"general 50", "general", 50, 0, 0},
    {"lens tag 4", "tag", 4, 1, 0},
    {"lens planar 8", "planar", 8, 1, 4},
    {"lens planar 50", "planar", 50, 1, 10},
    {"lens general 4", "general", 4, 1, 0},
    {"lens general 8", "general", 8, 1, 0},
    {"lens general 50", "general", 50, 1, 0},
};

enum { COLUMNS = sizeof columns / sizeof columns[0], CHECKED = 20, COUNT_MAX = 100000 };

/* Unity needs these: the arithmetic of the tests uses its checks. */
void setUp(void)
{
}

void tearDown(void)
{
}

/* A lens of a wide camera board: k1, k2, p1, p2, k3. */
static void put_lens(rigcal_camera *camera)
{
    camera->k1 = RC(-0.28);
    camera->k2 = RC(0.025);
    camera->p1 = RC(3e-4);
    camera->p2 = RC(-2e-4);
    camera->k3 = RC(0.16);
}

static void put_on_grid(bench_scene *s, int across)
{
    const int down = s->n / across;

    for (int i = 0; i < s->n; i++) {
        s->seen[i].X_w[0] = RC((double)(i % across) / (across - 1) - 0.5);
        s->seen[i].X_w[1] = RC((double)(i / across) / (down - 1) - 0.5);
        s->seen[i].X_w[2] = 0;
    }
}

/* Makes the points of the column's kind, and what the camera sees of them. */
static void make_scene(bench_scene *s, const column *c, long index)
{
    const bench_view view = {3, 10, SIGMA_PX};

    bench_scene_make(s, bench_family_of(c->family), c->n, index, &view);
    if (c->is_lens) {
        put_lens(&s->camera);
    }
    if (c->across > 0) {
        put_on_grid(s, c->across);
    }
    for (int i = 0; i < s->n; i++) {
        double X[3], X_c[3], uv[2];

        test_to_double(X, s->seen[i].X_w, 3);
        test_apply(X_c, s->R, X, s->t);
        test_project_px(uv, &s->camera, X_c);
        for (int k = 0; k < 2; k++) {
            s->seen[i].uv[k] = RC(uv[k] + SIGMA_PX * test_normal(&s->rng));
        }
    }
}

static void solve(tally *statuses, const column *c, int count, int warm)
{
    rigcal_pose_options options;

    (void)rigcal_pose_defaults(&options);
    options.use_start = warm;
    for (long i = 0; i < count; i++) {
        rigcal_pose poses[RIGCAL_POSES_MAX];
        double R[9], t[3];
        size_t n_found;
        bench_scene s;

        make_scene(&s, c, i);
        bench_disturb(R, t, &s);
        options.start = test_transform(R, t);
        tally_add(statuses,
                  rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL,
                                    &VIEW(&s.camera, s.seen, NULL, s.n), &options));
    }
}

/* Solves every column, without and with a previous pose: each must find a pose that
 * fits. */
static int check(void)
{
    int wrong = 0;

    for (int i = 0; i < 2 * COLUMNS; i++) {
        tally statuses;

        memset(&statuses, 0, sizeof statuses);
        solve(&statuses, &columns[i / 2], CHECKED, i % 2);
        printf("%s, %s: not OK: ", columns[i / 2].name, i % 2 ? "warm" : "cold");
        tally_print(&statuses);
        printf("\n");
        for (int status = STATUS_LEAST; status < 0; status++) {
            wrong += statuses.count[status - STATUS_LEAST];
        }
    }
    return wrong > 0;
}

int main(int argc, char **argv)
{
    if (argc == 2 && strcmp(argv[1], "check") == 0) {
        return check();
    }
    for (int i = 0; argc >= 3 && i < COLUMNS; i++) {
        if (strcmp(argv[1], columns[i].name) == 0) {
            const long count = strtol(argv[2], NULL, 10);
            tally statuses;

            memset(&statuses, 0, sizeof statuses);
            solve(&statuses, &columns[i], count < COUNT_MAX ? (int)count : COUNT_MAX,
                  argc > 3);
            tally_print(&statuses);
            printf("\n");
            return 0;
        }
    }
    fprintf(stderr, "usage: bench_cost COLUMN COUNT [warm] | bench_cost check\n");
    return 2;
}
