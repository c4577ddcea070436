/* The symmetries of a flat target: turns in its plane that map it onto itself. */
#include "cli_calibrate.h"

#include <math.h>
#include <string.h>

/* Larger targets are not examined: the work grows with n^2. */
enum { POINTS_MOST = 2000 };

/* The points in the plane of the target, relative to their mean. */
typedef struct {
    double (*at)[2];
    size_t n, far; /* far: number of the farthest point */
    double radius;
} flat;

static void cross(double out[3], const double a[3], const double b[3])
{
    int i;

    for (i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;

        out[i] = a[j] * b[k] - a[k] * b[j];
    }
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Sets the points relative to their mean, and finds the farthest. */
static void centre(flat *f, double (*X)[3], const rigcal_observation seen[])
{
    double middle[3] = {0, 0, 0};
    size_t i;
    int k;

    for (i = 0; i < f->n; i++) {
        for (k = 0; k < 3; k++) {
            middle[k] += (double)seen[i].X_w[k] / (double)f->n;
        }
    }
    f->radius = 0;
    f->far = 0;
    for (i = 0; i < f->n; i++) {
        for (k = 0; k < 3; k++) {
            X[i][k] = (double)seen[i].X_w[k] - middle[k];
        }
        if (sqrt(dot(X[i], X[i])) > f->radius) {
            f->radius = sqrt(dot(X[i], X[i]));
            f->far = i;
        }
    }
}

/* Returns 0 if the points are not in one plane, or are on one line. */
static int flatten(flat *f, const rigcal_view *seen)
{
    double(*X)[3] = cli_alloc(seen->n, sizeof *X);
    double normal[3] = {0, 0, 0}, x[3], y[3], largest = 0, off = 0;
    size_t i;
    int k;

    f->n = seen->n;
    f->at = cli_alloc(f->n, sizeof *f->at);
    centre(f, X, seen->observations);
    for (i = 0; i < f->n; i++) {
        cross(x, X[f->far], X[i]);
        if (sqrt(dot(x, x)) > largest) {
            largest = sqrt(dot(x, x));
            memcpy(normal, x, sizeof normal);
        }
    }
    if (largest > 1e-3 * f->radius * f->radius) {
        for (k = 0; k < 3; k++) {
            normal[k] /= largest;
            x[k] = X[f->far][k] / f->radius;
        }
        cross(y, normal, x);
        for (i = 0; i < f->n; i++) {
            f->at[i][0] = dot(X[i], x);
            f->at[i][1] = dot(X[i], y);
            off = fmax(off, fabs(dot(X[i], normal)));
        }
    }
    cli_free(X);
    return largest > 1e-3 * f->radius * f->radius && off < 0.01 * f->radius;
}

/* For each point, the number of the point at the place to which the turn takes it. Returns
 * 0 if a point has none. */
static int permute(int32_t number[], const flat *f, double angle, int is_mirrored)
{
    const double tolerance = 0.1 * f->radius / sqrt((double)f->n);
    const double c = cos(angle), s = sin(angle);
    size_t i, j;

    for (i = 0; i < f->n; i++) {
        const double v = is_mirrored ? -f->at[i][1] : f->at[i][1];
        const double x = c * f->at[i][0] - s * v;
        const double y = s * f->at[i][0] + c * v;

        for (j = 0; j < f->n; j++) {
            if (hypot(f->at[j][0] - x, f->at[j][1] - y) < tolerance) {
                break;
            }
        }
        if (j == f->n) {
            return 0;
        }
        number[i] = (int32_t)j;
    }
    return 1;
}

static int same_points(const rigcal_observation a[], const rigcal_observation b[], size_t n)
{
    size_t i;
    int k;

    for (i = 0; i < n; i++) {
        for (k = 0; k < 3; k++) {
            if (a[i].X_w[k] < b[i].X_w[k] || a[i].X_w[k] > b[i].X_w[k]) {
                return 0;
            }
        }
    }
    return 1;
}

/* Each turn takes the farthest point to a point that is equally far. */
static void find_turns(symmetries *s, int32_t *permutations, const flat *f, int is_mirrored)
{
    const double tolerance = 0.1 / sqrt((double)f->n);
    size_t j;

    for (j = 0; j < f->n && s->of.n_permutations < SYMMETRIES_MOST; j++) {
        const double angle = atan2(f->at[j][1], f->at[j][0]);
        const double far = hypot(f->at[j][0], f->at[j][1]);

        if ((is_mirrored || fabs(angle) > tolerance) && far > (1 - tolerance) * f->radius &&
            permute(permutations + s->of.n_permutations * f->n, f, angle, is_mirrored)) {
            s->is_mirrored[s->of.n_permutations] = is_mirrored;
            s->deg[s->of.n_permutations++] = fabs(DEGREE * angle);
        }
    }
}

const symmetries *symmetries_of(const rigcal_view *seen)
{
    static symmetries s;
    static rigcal_observation *target; /* the points that are permuted */
    static int32_t *permutations;
    flat f;

    if (target != NULL && s.of.n_points == seen->n &&
        same_points(target, seen->observations, seen->n)) {
        return &s;
    }
    if (target != NULL) {
        cli_free(target);
        cli_free(permutations);
        cli_free(s.of.room);
    }
    memset(&s, 0, sizeof s);
    s.of.n_points = seen->n;
    s.of.room = cli_alloc(seen->n, sizeof *s.of.room);
    target = cli_alloc(seen->n, sizeof *target);
    memcpy(target, seen->observations, seen->n * sizeof *target);
    permutations = cli_alloc(SYMMETRIES_MOST * seen->n, sizeof *permutations);
    s.of.permutations = permutations;
    if (seen->n >= 3 && seen->n <= POINTS_MOST) {
        if (flatten(&f, seen)) {
            find_turns(&s, permutations, &f, 0);
            find_turns(&s, permutations, &f, 1);
        }
        cli_free(f.at);
    }
    return &s;
}
