/* The robust pose beside other programs on the same scenes: a general target of 3 to 10
 * sizes away, half a pixel of noise, and wrong pixels anywhere in the image or near the
 * target. robust_poselib.py runs it, and PoseLib on the scenes that it writes.
 *
 *   bench_beside N PERCENT image|near COUNT [FILE]
 *
 * Prints: right, wrong yet believed, refused, with few that agree; processor seconds. FILE
 * gets, as doubles: of each scene n points x, y, z, u, v, then the true R and t, then by
 * how far a pose may be off to be right: radians, and part of the distance. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "test_support.h"

void setUp(void)
{
}

void tearDown(void)
{
}

enum { N_MOST = 10000 };

static const double NOISE = 0.5; /* px */

typedef struct {
    rigcal_camera camera;
    rigcal_observation seen[N_MOST], rest[N_MOST]; /* only the right observations */
    double R[9], t[3];
    int n, n_rest;
} spoilt;

/* Makes those with the lowest numbers wrong, which is as random as any other choice. Then
 * all are shuffled. */
static void place(spoilt *p, test_rng *rng)
{
    p->t[2] = test_uniform(rng, 3, 10);
    p->t[0] = p->t[2] * test_uniform(rng, -0.1, 0.1);
    p->t[1] = p->t[2] * test_uniform(rng, -0.1, 0.1);
    test_random_rotation(p->R, rng);
    for (int i = 0; i < p->n; i++) {
        double X[3], X_c[3], uv[2];
        for (int k = 0; k < 3; k++) {
            X[k] = test_uniform(rng, -0.5, 0.5);
        }
        test_apply(X_c, p->R, X, p->t);
        test_project_px(uv, &p->camera, X_c);
        for (int k = 0; k < 2; k++) {
            p->seen[i].uv[k] = RC(uv[k] + NOISE * test_normal(rng));
        }
        test_to_real(p->seen[i].X_w, X, 3);
    }
}

static void shuffle(spoilt *p, test_rng *rng)
{
    for (int i = p->n - 1; i > 0; i--) {
        const int j = (int)(test_next(rng) % (uint64_t)(i + 1));
        const rigcal_observation o = p->seen[i];
        p->seen[i] = p->seen[j];
        p->seen[j] = o;
    }
}

static void make(spoilt *p, int n, int percent, int is_near, long index)
{
    const uint64_t line = (uint64_t)(n * 1000 + percent * 2 + is_near);
    test_rng rng = test_seed((line << 32) + (uint64_t)index);
    double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9};
    const int n_wrong = n * percent / 100;

    p->camera = test_pinhole();
    p->n = n;
    place(p, &rng);
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < n && is_near; i++) {
            low[k] = fmin(low[k], D(p->seen[i].uv[k]));
            high[k] = fmax(high[k], D(p->seen[i].uv[k]));
        }
        if (!is_near) {
            low[k] = 0;
            high[k] = k == 0 ? p->camera.width : p->camera.height;
        }
    }
    for (int i = 0; i < n_wrong; i++) {
        for (int k = 0; k < 2; k++) {
            p->seen[i].uv[k] = RC(test_uniform(&rng, low[k], high[k]));
        }
    }
    p->n_rest = n - n_wrong;
    memcpy(p->rest, p->seen + n_wrong, (size_t)p->n_rest * sizeof p->rest[0]);
    shuffle(p, &rng);
}

/* The error of the pose nearest to the truth: the angle, and the length over the
 * distance. */
static void nearest(double error[2], const spoilt *p, const rigcal_pose poses[], size_t n)
{
    error[0] = error[1] = 1e300;
    for (size_t i = 0; i < n; i++) {
        double R[9], t[3], d[3];
        test_transform_parts(R, t, &poses[i].cam_from_world);
        const double angle = test_angle_between(R, p->R);
        for (int k = 0; k < 3; k++) {
            d[k] = t[k] - p->t[k];
        }
        if (angle < error[0]) {
            error[0] = angle;
            error[1] = test_norm(d) / test_norm(p->t);
        }
    }
}

/* The largest error of a right pose: three times that of the pose of the right points
 * alone, plus 2 degrees and 2 %. */
static void allowed(double error[2], const spoilt *p)
{
    rigcal_pose poses[RIGCAL_POSES_MAX];
    size_t n_found = 0;
    if (p->n_rest < 3 ||
        rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL,
                          &VIEW(&p->camera, p->rest, NULL, (size_t)p->n_rest), NULL) < 0) {
        error[0] = error[1] = -1;
        return;
    }
    nearest(error, p, poses, n_found);
    error[0] = 3 * error[0] + 2 * TEST_PI / 180;
    error[1] = 3 * error[1] + 0.02;
}

static void write(FILE *file, const spoilt *p, const double error[2])
{
    for (int i = 0; i < p->n; i++) {
        double numbers[5];
        test_to_double(numbers, p->seen[i].X_w, 3);
        test_to_double(numbers + 3, p->seen[i].uv, 2);
        fwrite(numbers, sizeof numbers[0], 5, file);
    }
    fwrite(p->R, sizeof p->R[0], 9, file);
    fwrite(p->t, sizeof p->t[0], 3, file);
    fwrite(error, sizeof error[0], 2, file);
}

static double seconds(void)
{
    return (double)clock() / CLOCKS_PER_SEC;
}

static void run(int n, int percent, int is_near, long count, FILE *file)
{
    static spoilt p;
    static uint8_t inliers[N_MOST];
    long right = 0, believed = 0, refused = 0, few = 0;
    double spent = 0;

    for (long index = 0; index < count; index++) {
        rigcal_pose poses[RIGCAL_POSES_MAX];
        size_t n_found = 0, n_inliers;
        double error[2], most[2];

        make(&p, n, percent, is_near, index);
        spent -= seconds();
        const rigcal_status status =
            rigcal_robust_solve(poses, RIGCAL_POSES_MAX, &n_found, inliers, &n_inliers,
                                NULL, &VIEW(&p.camera, p.seen, NULL, (size_t)n), NULL);
        spent += seconds();
        allowed(most, &p);
        nearest(error, &p, poses, n_found);
        const int is_sure = status >= 0 && status != RIGCAL_FEW_AGREE;
        const int is_right = error[0] <= most[0] && error[1] <= most[1];
        right += is_sure && is_right;
        believed += is_sure && !is_right;
        refused += status < 0;
        few += status == RIGCAL_FEW_AGREE;
        if (file != NULL) {
            write(file, &p, most);
        }
    }
    printf("%ld %ld %ld %ld %.9f\n", right, believed, refused, few, spent);
}

int main(int argc, char **argv)
{
    const int n = argc > 4 ? atoi(argv[1]) : 0;
    FILE *file = argc > 5 ? fopen(argv[5], "wb") : NULL;

    if (n < 5 || n > N_MOST || (argc > 5 && file == NULL)) {
        fprintf(stderr, "bench_beside N PERCENT image|near COUNT [FILE]\n");
        return 2;
    }
    run(n, atoi(argv[2]), strcmp(argv[3], "near") == 0, atol(argv[4]), file);
    return file != NULL && fclose(file) != 0;
}
