#include "bench_scenes.h"

#include <math.h>
#include <string.h>

#include "test_fit.h"

const bench_family bench_families[BENCH_FAMILIES] = {
    {"general", {1, 1, 1}, 0.1, 0, 0, 0},
    {"planar", {1, 1, 0}, 0.1, 1, 1, 0},
    {"tag", {1, 1, 0}, 0.1, 1, 1, 1},
    {"near-planar", {1, 1, 0.05}, 0.1, 1, 1, 0},
    {"quasi-linear", {1, 0.05, 0.05}, 0.1, 1, 0, 0},
    {"off-centre", {1, 1, 1}, 0.5, 0, 0, 0},
};

#define TILT_MOST (60 * BENCH_DEGREE)

/* The standard deviation of rounding to whole numbers, 1 / sqrt(12). */
#define ROUNDING 0.28867513459481287

const bench_family *bench_family_of(const char *name)
{
    for (int f = 0; f < BENCH_FAMILIES; f++) {
        if (strcmp(name, bench_families[f].name) == 0) {
            return &bench_families[f];
        }
    }
    return NULL;
}

int bench_has(const bench_family *f, int n)
{
    return n <= TEST_SCENE_MAX && (!f->is_tag || n == 4);
}

/* The corners of a tag begin at its upper left and go clockwise, for a viewer who sees y
 * up. */
static void place_point(double X[3], test_rng *rng, const bench_family *f, int i)
{
    if (f->is_tag) {
        X[0] = i == 1 || i == 2 ? 0.5 : -0.5;
        X[1] = i >= 2 ? -0.5 : 0.5;
        X[2] = 0;
        return;
    }
    for (int k = 0; k < 3; k++) {
        X[k] = f->box[k] * test_uniform(rng, -0.5, 0.5);
    }
}

/* A rotation whose z axis is uniform in a cap about the line of sight, with any turn about
 * it. */
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

static void place_camera(bench_scene *s, const bench_family *f, const bench_view *view)
{
    s->t[2] = test_uniform(&s->rng, view->nearest, view->farthest);
    s->t[0] = s->t[2] * test_uniform(&s->rng, -f->aside, f->aside);
    s->t[1] = s->t[2] * test_uniform(&s->rng, -f->aside, f->aside);
    if (f->is_tilted) {
        tilt(s->R, &s->rng, s->t);
    } else {
        test_random_rotation(s->R, &s->rng);
    }
}

/* Whether the whole target is in the image. */
static int see_target(bench_scene *s, const bench_family *f, const bench_view *view)
{
    int inside = 1;

    for (int i = 0; i < s->n; i++) {
        double X[3], X_c[3], uv[2];

        place_point(X, &s->rng, f, i);
        test_apply(X_c, s->R, X, s->t);
        test_project_px(uv, &s->camera, X_c);
        for (int k = 0; k < 2; k++) {
            uv[k] += view->sigma * test_normal(&s->rng);
            if (!(view->sigma > 0)) {
                uv[k] = floor(uv[k] + 0.5);
            }
            inside &= uv[k] >= 0 && uv[k] < s->camera.width;
        }
        test_to_real(s->seen[i].X_w, X, 3);
        test_to_real(s->seen[i].uv, uv, 2);
    }
    return inside;
}

void bench_scene_make(bench_scene *s, const bench_family *f, int n, long index,
                      const bench_view *view)
{
    const uint64_t row = 1000 * (uint64_t)(f - bench_families) + (uint64_t)n;
    int inside;

    memset(s, 0, sizeof *s);
    s->rng = test_seed((row << 32) + (uint64_t)index);
    s->camera = test_pinhole();
    s->n = n;
    s->sigma = view->sigma;
    if (!(view->sigma > 0)) {
        s->sigma = ROUNDING;
        s->camera.width = s->camera.height = 512;
        s->camera.cx = s->camera.cy = RC(255.5);
    }
    do {
        place_camera(s, f, view);
        inside = see_target(s, f, view);
    } while (!inside && !(view->sigma > 0));
}

void bench_beside(double R[9], double t[3], test_rng *rng, const double R_true[9],
                  const double t_true[3])
{
    double turn[9], way[2][9];

    test_random_rotation(way[0], rng);
    test_random_rotation(way[1], rng);
    test_rotation_about(turn, way[0] + 6, 2 * BENCH_DEGREE);
    test_product(R, turn, R_true);
    for (int k = 0; k < 3; k++) {
        t[k] = t_true[k] + 0.02 * test_norm(t_true) * way[1][6 + k];
    }
}

void bench_disturb(double R[9], double t[3], bench_scene *s)
{
    bench_beside(R, t, &s->rng, s->R, s->t);
}

/* ---- the bound ----------------------------------------------------------- */

/* d(u, v) by (w, dt) of one point at the truth. */
static void rows_of(double J[2][6], const bench_scene *s, int i)
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

int bench_bound(double deviation[6], const bench_scene *s)
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

void bench_squares(double squares[2], const bench_scene *s, const double deviation[6],
                   const double R[9], const double t[3])
{
    double d[6];

    test_difference(d, s->R, s->t, R, t);
    squares[0] = squares[1] = 0;
    for (int k = 0; k < 6; k++) {
        const double ratio = d[k] / deviation[k];

        squares[k / 3] += ratio * ratio / 3;
    }
}
