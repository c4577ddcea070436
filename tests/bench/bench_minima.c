#include "bench_minima.h"

#include <math.h>
#include <string.h>

#include "bench_starts.h"

/* fits of 200 steps each; long valleys need several. */
enum { FITS_MOST = 20 };

/* A sum of squares is below this unless a point is behind the camera. */
#define FAR 1e299

static test_data data_of(const bench_scene *s)
{
    const test_data data = {&s->camera, s->seen, NULL, s->n};

    return data;
}

static int is_near(const bench_minima *m, int i, const double R[9])
{
    return test_angle_between(m->list[i].R, R) < BENCH_SAME_ROTATION;
}

int bench_is_minimum(const bench_minima *m, int i, const double R[9], const double t[3])
{
    const test_data data = data_of(m->scene);

    return is_near(m, i, R) &&
           test_sse(&data, R, t) <= m->list[i].sse * (1 + BENCH_SUM_TOL);
}

/* The projection of the fits continues beyond the turning point of a lens. The camera does
 * not. */
static int is_seen(const bench_scene *s, const test_fitted *fitted)
{
    for (int i = 0; i < s->n; i++) {
        double X[3], X_c[3];
        rigcal_real x[3], uv[2];

        test_to_double(X, s->seen[i].X_w, 3);
        test_apply(X_c, fitted->R, X, fitted->t);
        test_to_real(x, X_c, 3);
        if (rigcal_camera_project(uv, &s->camera, x) != RIGCAL_OK) {
            return 0;
        }
    }
    return 1;
}

/* Returns its place in the list. */
static int keep(bench_minima *m, const test_fitted *fitted)
{
    for (int i = 0; i < m->n; i++) {
        if (is_near(m, i, fitted->R)) {
            if (fitted->sse < m->list[i].sse) {
                m->list[i] = *fitted;
            }
            return i;
        }
    }
    if (m->n == BENCH_MINIMA_MAX) {
        m->stopped++;
        return -1;
    }
    m->list[m->n] = *fitted;
    return m->n++;
}

int bench_minima_add(bench_minima *m, const double R[9], const double t[3])
{
    const test_data data = data_of(m->scene);
    test_fitted fitted;
    int done = 0;

    for (int i = 0; i < m->n; i++) {
        if (bench_is_minimum(m, i, R, t)) {
            return i;
        }
    }
    memcpy(fitted.R, R, sizeof fitted.R);
    memcpy(fitted.t, t, sizeof fitted.t);
    for (int i = 0; i < FITS_MOST && !done; i++) {
        done = test_fit(&fitted, &data);
    }
    if (!is_seen(m->scene, &fitted)) {
        return -1;
    }
    m->least = fitted.sse < m->least ? fitted.sse : m->least;
    if (!done) {
        m->stopped++;
        return -1;
    }
    return keep(m, &fitted);
}

void bench_minima_begin(bench_minima *m, const bench_scene *s)
{
    const test_data data = data_of(s);
    test_fitted mirrored, starts[BENCH_STARTS_MAX];
    int n_starts;

    m->n = m->stopped = 0;
    m->least = HUGE_VAL;
    m->scene = s;
    m->truth = bench_minima_add(m, s->R, s->t);
    test_mirror_tilt(&mirrored, &data, s->R, s->t);
    (void)bench_minima_add(m, mirrored.R, mirrored.t);
    n_starts = bench_starts(starts, s);
    for (int i = 0; i < n_starts; i++) {
        if (test_sse(&data, starts[i].R, starts[i].t) < FAR) {
            (void)bench_minima_add(m, starts[i].R, starts[i].t);
        }
    }
}

static int rank_of(const bench_minima *m, int i)
{
    int rank = 0;

    for (int j = 0; j < m->n; j++) {
        rank += m->list[j].sse < m->list[i].sse ||
                (j < i && !(m->list[i].sse < m->list[j].sse));
    }
    return rank;
}

int bench_minima_ranked(const bench_minima *m, int rank)
{
    for (int i = 0; i < m->n; i++) {
        if (rank_of(m, i) == rank) {
            return i;
        }
    }
    return -1;
}

int bench_is_best(const bench_minima *m, int i, double tol)
{
    return i >= 0 && m->list[i].sse <= m->least * (1 + tol);
}
