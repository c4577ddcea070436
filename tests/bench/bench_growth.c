/* bench_growth: solves of one number of points, for callgrind (tests/bench/growth.py).
 *
 *   bench_growth LENS N HOW COUNT
 *       LENS pinhole, brown or fisheye; N 3 .. 10000; HOW cold, warm or robust, where three
 *       in ten pixels are wrong
 *   bench_growth check
 *       each lens and way with a few points: all are solved
 *
 * Random points in a cube of size 1, 3 to 10 away, 0.5 px noise. Of three points the noise
 * is stated. All others are solved by defaults. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench_scenes.h"

enum { POINTS_MOST = 10000, ROBUST_LEAST = 10 };

static const double SIGMA_PX = 0.5, WRONG = 0.3;
static rigcal_observation seen[POINTS_MOST];
static uint8_t inliers[POINTS_MOST];

/* Unity needs these: the arithmetic of the tests uses its checks. */
void setUp(void)
{
}

void tearDown(void)
{
}

/* Returns 1 if there is such a lens. */
static int put_lens(rigcal_camera *camera, const char *name)
{
    *camera = test_pinhole();
    if (strcmp(name, "brown") == 0) {
        camera->k1 = RC(-0.28);
        camera->k2 = RC(0.025);
        camera->p1 = RC(3e-4);
        camera->k3 = RC(0.16);
    } else if (strcmp(name, "fisheye") == 0) {
        camera->lens = RIGCAL_LENS_FISHEYE;
        camera->k1 = RC(-0.02);
        camera->k2 = RC(0.003);
    }
    return strcmp(name, "pinhole") == 0 || camera->k1 < 0;
}

static void make_scene(double R[9], double t[3], test_rng *rng, const rigcal_camera *camera,
                       int n, double wrong)
{
    test_random_rotation(R, rng);
    t[2] = test_uniform(rng, 3, 10);
    t[0] = 0.1 * t[2] * test_uniform(rng, -1, 1);
    t[1] = 0.1 * t[2] * test_uniform(rng, -1, 1);
    for (int i = 0; i < n; i++) {
        double X[3], X_c[3], uv[2];
        for (int k = 0; k < 3; k++) {
            X[k] = test_uniform(rng, -0.5, 0.5);
        }
        test_to_real(seen[i].X_w, X, 3);
        test_to_double(X, seen[i].X_w, 3);
        test_apply(X_c, R, X, t);
        test_project_px(uv, camera, X_c);
        for (int k = 0; k < 2; k++) {
            uv[k] += SIGMA_PX * test_normal(rng);
            if (i < wrong * n) {
                uv[k] = test_uniform(rng, 0, k == 0 ? camera->width : camera->height);
            }
        }
        test_to_real(seen[i].uv, uv, 2);
    }
}

/* The number of scenes that have no pose. */
static int solve(const rigcal_camera *camera, int n, const char *how, int count)
{
    test_rng rng = test_seed(20);
    int failed = 0;
    for (int trial = 0; trial < count; trial++) {
        const int is_robust = strcmp(how, "robust") == 0;
        rigcal_pose poses[RIGCAL_POSES_MAX];
        rigcal_pose_options options;
        double R[9], t[3], R_start[9], t_start[3];
        size_t n_found, n_agree;
        make_scene(R, t, &rng, camera, n, is_robust ? WRONG : 0);
        const rigcal_view view = {camera, seen, NULL, (size_t)n};
        (void)rigcal_pose_defaults(&options);
        options.sigma_px = (n == 3) ? (rigcal_real)SIGMA_PX : 0;
        options.use_start = strcmp(how, "warm") == 0;
        bench_beside(R_start, t_start, &rng, R, t);
        options.start = test_transform(R_start, t_start);
        failed += (is_robust ? rigcal_robust_solve(poses, RIGCAL_POSES_MAX, &n_found,
                                                   inliers, &n_agree, NULL, &view, NULL)
                             : rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL,
                                                 &view, &options)) < 0;
    }
    return failed;
}

static int check(void)
{
    static const char *const lenses[] = {"pinhole", "brown", "fisheye"};
    static const char *const ways[] = {"cold", "warm", "robust"};
    int failed = 0;
    for (int i = 0; i < 9; i++) {
        rigcal_camera camera;
        (void)put_lens(&camera, lenses[i / 3]);
        failed += solve(&camera, ROBUST_LEAST, ways[i % 3], 10);
        failed += solve(&camera, 200, ways[i % 3], 2);
    }
    return failed > 0;
}

int main(int argc, char *argv[])
{
    rigcal_camera camera;
    if (argc == 2 && strcmp(argv[1], "check") == 0) {
        return check();
    }
    const int n = argc == 5 ? atoi(argv[2]) : 0, count = argc == 5 ? atoi(argv[4]) : 0;
    if (argc != 5 || !put_lens(&camera, argv[1]) || n < 3 || n > POINTS_MOST || count < 1) {
        fprintf(stderr,
                "usage: bench_growth pinhole|brown|fisheye N cold|warm|robust COUNT | "
                "check\n");
        return 2;
    }
    printf("%d of %d not solved\n", solve(&camera, n, argv[3], count), count);
    return 0;
}
