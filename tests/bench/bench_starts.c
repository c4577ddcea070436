#include "bench_starts.h"

#include <math.h>
#include <string.h>

/* Steps of a fit, and tries of a step. A fit in pixels follows and converges fully. */
enum { STEPS = 40, TRIES = 10 };

/* A step turns at most this angle [rad], and moves at most this length [sizes of the
 * target]. */
#define STEP_MOST 0.7

/* A step that gains less than this part of the sum is the last. */
#define GAIN_LEAST 1e-6

/* Ends that are closer than this [rad] are the same. */
#define SAME_END 1e-3

/* The points relative to their middle, and the unit rays of their pixels. */
typedef struct {
    double middle[3], x[TEST_SCENE_MAX][3], ray[TEST_SCENE_MAX][3];
    int n;
} bearings;

static int bearings_of(bearings *b, const bench_scene *s)
{
    memset(b, 0, sizeof *b);
    b->n = s->n;
    for (int i = 0; i < s->n; i++) {
        for (int k = 0; k < 3; k++) {
            b->middle[k] += D(s->seen[i].X_w[k]) / s->n;
        }
    }
    for (int i = 0; i < s->n; i++) {
        rigcal_real ray[3];

        for (int k = 0; k < 3; k++) {
            b->x[i][k] = D(s->seen[i].X_w[k]) - b->middle[k];
        }
        if (rigcal_camera_ray(ray, &s->camera, s->seen[i].uv) != RIGCAL_OK) {
            return 0;
        }
        test_to_double(b->ray[i], ray, 3);
    }
    return 1;
}

/* The difference e of a point's ray from that of its pixel, and, if B is not NULL, the
 * derivative of the point's ray by the point. */
static void difference_of(double e[3], double B[9], const double X_c[3],
                          const double ray[3])
{
    const double length = test_norm(X_c);
    double u[3];

    for (int k = 0; k < 3; k++) {
        u[k] = X_c[k] / length;
        e[k] = ray[k] - u[k];
    }
    for (int k = 0; B && k < 9; k++) {
        B[k] = ((k % 4 == 0) - u[k / 3] * u[k % 3]) / length;
    }
}

static double sum_of(const bearings *b, const double R[9], const double t[3])
{
    double sum = 0;

    for (int i = 0; i < b->n; i++) {
        double X_c[3], e[3];

        test_apply(X_c, R, b->x[i], t);
        difference_of(e, NULL, X_c, b->ray[i]);
        sum += test_dot(e, e);
    }
    return sum;
}

/* The lower triangle of J^T J, J^T e, and the sum. J is by the (w, dt) of test_move. */
static double equations_of(double H[36], double g[6], const bearings *b, const double R[9],
                           const double t[3])
{
    double sum = 0;

    memset(H, 0, 36 * sizeof H[0]);
    memset(g, 0, 6 * sizeof g[0]);
    for (int i = 0; i < b->n; i++) {
        double q[3], X_c[3], e[3], B[9];

        test_apply(q, R, b->x[i], NULL);
        for (int k = 0; k < 3; k++) {
            X_c[k] = q[k] + t[k];
        }
        difference_of(e, B, X_c, b->ray[i]);
        for (int r = 0; r < 3; r++) {
            double row[6];

            test_cross(row, q, &B[3 * r]);
            memcpy(row + 3, &B[3 * r], 3 * sizeof B[0]);
            sum += e[r] * e[r];
            for (int k = 0; k < 6; k++) {
                g[k] += row[k] * e[r];
                for (int j = 0; j <= k; j++) {
                    H[6 * k + j] += row[k] * row[j];
                }
            }
        }
    }
    return sum;
}

/* The damped step that H and g give, of at most STEP_MOST. */
static int step_of(double d[6], const double H[36], const double g[6], double damping)
{
    double A[36], length;

    for (int k = 0; k < 6; k++) {
        for (int j = 0; j <= k; j++) {
            A[6 * k + j] = A[6 * j + k] = H[6 * k + j];
        }
        A[7 * k] += damping * H[7 * k] + 1e-12;
    }
    if (!test_solve(d, A, g, 6)) {
        return 0;
    }
    length = sqrt(test_dot(d, d) + test_dot(d + 3, d + 3));
    for (int k = 0; k < 6 && length > STEP_MOST; k++) {
        d[k] *= STEP_MOST / length;
    }
    return 1;
}

/* Levenberg-Marquardt; t is the place of the middle. */
static void fit_bearings(double R[9], double t[3], const bearings *b)
{
    double damping = 1e-3;
    int done = 0;

    for (int step = 0; step < STEPS && !done; step++) {
        double H[36], g[6];
        const double sum = equations_of(H, g, b, R, t);

        done = 1; /* unless this step gains something */
        for (int tries = 0; tries < TRIES; tries++) {
            double d[6], R2[9], t2[3], sum2;

            if (!step_of(d, H, g, damping)) {
                return;
            }
            memcpy(R2, R, sizeof R2);
            memcpy(t2, t, sizeof t2);
            test_move(R2, t2, d);
            sum2 = sum_of(b, R2, t2);
            if (sum2 < sum) {
                done = sum - sum2 < GAIN_LEAST * sum;
                memcpy(R, R2, sizeof R2);
                memcpy(t, t2, sizeof t2);
                damping *= 0.1;
                break;
            }
            damping = fmax(10 * damping, 1e-6);
        }
    }
}

/* The t that brings the points closest to the lines of the rays, for this R. */
static int translation_of(double t[3], const bearings *b, const double R[9])
{
    double A[9] = {0}, y[3] = {0};

    for (int i = 0; i < b->n; i++) {
        double q[3];

        test_apply(q, R, b->x[i], NULL);
        for (int k = 0; k < 9; k++) {
            const double across = (k % 4 == 0) - b->ray[i][k / 3] * b->ray[i][k % 3];

            A[k] += across;
            y[k / 3] -= across * q[k % 3];
        }
    }
    return test_solve(t, A, y, 3);
}

/* Rotation k of the 24 rotations of a cube: 4 turns of each of its 6 faces. */
static void cube_rotation(double R[9], int k)
{
    static const int FACE[6][2] = {{0, 0}, {0, 1}, {0, 2}, {0, 3}, {1, 0}, {3, 0}};
    const double right_angle = TEST_PI / 2;

    test_rotation(R, k % 4 * right_angle, FACE[k / 4][0] * right_angle,
                  FACE[k / 4][1] * right_angle);
}

static int is_new(const test_fitted starts[], int n, const double R[9])
{
    for (int i = 0; i < n; i++) {
        if (test_angle_between(starts[i].R, R) < SAME_END) {
            return 0;
        }
    }
    return 1;
}

int bench_starts(test_fitted starts[BENCH_STARTS_MAX], const bench_scene *s)
{
    test_rng rng = s->rng;
    double turn[9];
    bearings b;
    int n = 0;

    if (!bearings_of(&b, s)) {
        return 0;
    }
    test_random_rotation(turn, &rng);
    for (int k = 0; k < BENCH_STARTS_MAX; k++) {
        double cube[9], R[9], t[3], shift[3];

        cube_rotation(cube, k);
        test_product(R, cube, turn);
        if (!translation_of(t, &b, R)) {
            continue;
        }
        fit_bearings(R, t, &b);
        if (is_new(starts, n, R)) {
            test_apply(shift, R, b.middle, NULL);
            memcpy(starts[n].R, R, sizeof R);
            for (int j = 0; j < 3; j++) {
                starts[n].t[j] = t[j] - shift[j];
            }
            starts[n].sse = 0;
            n++;
        }
    }
    return n;
}
