/* bench_rig: rigcal_rig_join and rigcal_rig_adjust on simulated rigs (bench_rigs.h). C, F
 * and N are the numbers of cameras, placements and points.
 *
 *   bench_rig adjust C F N [REPEATS]
 *   bench_rig join C F N [REPEATS]
 *       one rig: what came of it, and the least CPU time of REPEATS (default 1) [s]
 *   bench_rig print C F N
 *       the rig as text, then what rigcal_rig_adjust makes of it, for rig_scipy.py
 *   bench_rig check
 *       small rigs, for CI: exit status 1 if one is not adjusted to its noise */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "bench_rigs.h"

/* Unity needs these: the arithmetic of the tests uses its checks. */
void setUp(void)
{
}

void tearDown(void)
{
}

static void fail(const char *why)
{
    fprintf(stderr, "bench_rig: %s\n", why);
    exit(2);
}

static void run(rigcal_rig_fit *fit, bench_rig *b, int is_join)
{
    const rigcal_rig_fit nothing = {0};

    bench_rig_reset(b);
    *fit = nothing;
    const rigcal_status status = is_join ? bench_join(b) : bench_adjust(fit, b);

    if (status != RIGCAL_OK) {
        fail(rigcal_status_name(status));
    }
}

/* Joins again in steps, because their result has the number of evaluations. */
static void count_join(rigcal_rig_fit *fit, bench_rig *b)
{
    rigcal_rig_solver solver;
    rigcal_status status = rigcal_rig_join_begin(&solver, &b->rig);

    status = (status == RIGCAL_OK) ? RIGCAL_RUNNING : status;
    while (status == RIGCAL_RUNNING) {
        status = rigcal_rig_join_step(&solver, 1000);
    }
    if (status == RIGCAL_OK) {
        status = rigcal_rig_result(fit, NULL, &solver);
    }
    if (status != RIGCAL_OK) {
        fail(rigcal_status_name(status));
    }
}

static void bench_one(bench_rig *b, int is_join, int repeats)
{
    rigcal_rig_fit fit;
    double least = HUGE_VAL;

    for (int i = 0; i < repeats; i++) {
        const clock_t begin = clock();

        run(&fit, b, is_join);
        least = fmin(least, (double)(clock() - begin) / CLOCKS_PER_SEC);
    }
    if (is_join) {
        count_join(&fit, b);
        printf("evaluations %d views %d sum %.17g seconds %.6f\n", (int)fit.evals,
               b->n_cameras * b->n_placements, D(fit.sum), least);
    } else {
        printf("evaluations %d points %d sum %.17g sigma %.4f seconds %.6f\n",
               (int)fit.evals, (int)fit.n_points, D(fit.sum), D(fit.sigma_px), least);
    }
}

static void print_poses(const rigcal_transform poses[], int n)
{
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < 9; k++) {
            printf("%.17g ", D(poses[i].R[k]));
        }
        printf("%.17g %.17g %.17g\n", D(poses[i].t[0]), D(poses[i].t[1]), D(poses[i].t[2]));
    }
}

/* Prints the counts; a line for each camera; the starts; a line for each point: camera,
 * placement, X, uv. Then the sum, the poses, and for each camera the sigma of (w, dt) for
 * noise of 1 px. */
static void print_rig(bench_rig *b)
{
    const int n_poses = b->n_cameras + b->n_placements;
    rigcal_rig_fit fit;

    printf("%d %d %d\n", b->n_cameras, b->n_placements, b->n_points);
    for (int c = 0; c < b->n_cameras; c++) {
        const rigcal_camera *const k = &b->cameras[c];

        printf("%.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", D(k->fx),
               D(k->fy), D(k->cx), D(k->cy), D(k->k1), D(k->k2), D(k->p1), D(k->p2),
               D(k->k3));
    }
    print_poses(b->starts, n_poses);
    for (size_t i = 0; i < b->rig.n_views; i++) {
        for (int j = 0; j < b->n_points; j++) {
            const rigcal_observation *const o = &b->views[i].view.observations[j];

            printf("%d %d %.17g %.17g %.17g %.17g %.17g\n", (int)b->views[i].camera,
                   (int)b->views[i].placement, D(o->X_w[0]), D(o->X_w[1]), D(o->X_w[2]),
                   D(o->uv[0]), D(o->uv[1]));
        }
    }
    run(&fit, b, 0);
    printf("%.17g\n", D(fit.sum));
    print_poses(b->poses, n_poses);
    for (int c = 0; c < b->n_cameras; c++) {
        rigcal_real Sigma[36];

        if (rigcal_rig_covariance(Sigma, &b->rig, 1, (size_t)c) != RIGCAL_OK) {
            fail("there is no covariance");
        }
        for (int k = 0; k < 6; k++) {
            printf("%.17g%c", sqrt(D(Sigma[7 * k])), (k < 5) ? ' ' : '\n');
        }
    }
}

/* sigma_px is within 5 standard deviations of the noise. */
static int check(int n_cameras, int n_placements, int n_points)
{
    bench_rig b;
    rigcal_rig_fit fit;

    bench_rig_make(&b, n_cameras, n_placements, n_points, BENCH_RIG_SEED);
    run(&fit, &b, 1);
    run(&fit, &b, 0);
    const double off = D(fit.sigma_px) / BENCH_RIG_NOISE_PX - 1;
    const int is_right = fabs(off) < 5 / sqrt(2 * D(fit.freedom));

    printf("%d x %d x %d: %d evaluations, sigma %.4f px%s\n", n_cameras, n_placements,
           n_points, (int)fit.evals, D(fit.sigma_px), is_right ? "" : ": not the noise");
    bench_rig_free(&b);
    return is_right;
}

static int number(const char *text, int least, int most)
{
    char *end;
    const long n = strtol(text, &end, 10);

    if (end == text || *end != '\0' || n < least || n > most) {
        fprintf(stderr, "bench_rig: %s is no number from %d to %d\n", text, least, most);
        exit(2);
    }
    return (int)n;
}

int main(int argc, char *argv[])
{
    enum { CAMERAS_MAX = 64, MANY = 10000 };
    const char *const what = (argc > 1) ? argv[1] : "";
    const int is_join = strcmp(what, "join") == 0;
    bench_rig b;

    if (strcmp(what, "check") == 0 && argc == 2) {
        const int two = check(2, 7, 20), three = check(3, 8, 12);

        return (two && three) ? 0 : 1;
    }
    if ((argc != 5 && argc != 6) ||
        (!is_join && strcmp(what, "adjust") != 0 && strcmp(what, "print") != 0)) {
        fail("usage: bench_rig adjust C F N [REPEATS] | join C F N [REPEATS] | "
             "print C F N | check");
    }
    bench_rig_make(&b, number(argv[2], 2, CAMERAS_MAX), number(argv[3], 1, MANY),
                   number(argv[4], 4, MANY), BENCH_RIG_SEED);
    if (strcmp(what, "print") == 0) {
        print_rig(&b);
    } else {
        bench_one(&b, is_join, (argc == 6) ? number(argv[5], 1, MANY) : 1);
    }
    bench_rig_free(&b);
    return 0;
}
