/* bench_minima.h - the minima of a scene's reprojection error that a multi-start
 * finds: what a solver ought to have returned. The truth is among the starts, and
 * rotations all over the sphere. The fits are test_fit's, which shares nothing with the
 * library. */
#ifndef BENCH_MINIMA_H
#define BENCH_MINIMA_H

#include "bench_scenes.h"
#include "test_fit.h"

/* What counts as the same sum of squares, and as the same rotation [rad]. */
#define BENCH_SUM_TOL 1e-4
#define BENCH_SAME_ROTATION 0.01

enum { BENCH_MINIMA_MAX = 16 };

typedef struct {
    test_fitted list[BENCH_MINIMA_MAX]; /* distinct, in no order */
    int n;
    int stopped;  /* fits that did not converge, and are in no list */
    double least; /* sum that any fit came to, these too */
    int truth;    /* the one that the true pose lies in, or -1 */
    const bench_scene *scene;
} bench_minima;

/* From the truth, from the truth mirrored in the line of sight, and from the starts of
 * bench_starts. */
void bench_minima_begin(bench_minima *m, const bench_scene *s);

/* The minimum that a pose lies in: where a fit from it ends, or -1. One not yet
 * known joins the list. A fit that ends where the lens does not see a point is none. */
int bench_minima_add(bench_minima *m, const double R[9], const double t[3]);

/* Rank 0 is the best, 1 the second; -1 when there are not so many. */
int bench_minima_ranked(const bench_minima *m, int rank);

/* Whether minimum i fits as well as the best does, a part `tol` of the sum off. */
int bench_is_best(const bench_minima *m, int i, double tol);

/* Whether a pose is as good as minimum i, but for rounding. */
int bench_is_minimum(const bench_minima *m, int i, const double R[9], const double t[3]);

#endif /* BENCH_MINIMA_H */
