/* bench_minima.h - the minima of a scene's reprojection error that a multi-start
 * finds: what a solver should have returned. It starts from the truth and from rotations
 * all over the sphere. The fits are those of test_fit, which shares no code with the
 * library. */
#ifndef BENCH_MINIMA_H
#define BENCH_MINIMA_H

#include "bench_scenes.h"
#include "test_fit.h"

/* Sums of squares, and rotations [rad], that differ by less count as the same. */
#define BENCH_SUM_TOL 1e-4
#define BENCH_SAME_ROTATION 0.01

enum { BENCH_MINIMA_MAX = 16 };

typedef struct {
    test_fitted list[BENCH_MINIMA_MAX]; /* different minima, in no order */
    int n;
    int stopped;  /* number of fits that did not converge, and are not in the list */
    double least; /* the least sum of any fit, these included */
    int truth;    /* the minimum in which the true pose lies; -1: unknown */
    const bench_scene *scene;
} bench_minima;

/* Finds the minima, from the truth, from the truth mirrored in the line of sight, and from
 * the starts of bench_starts. */
void bench_minima_begin(bench_minima *m, const bench_scene *s);

/* The minimum in which a pose lies: where a fit that starts there ends; -1: there is none.
 * A new minimum joins the list. An end at which the lens does not see a point is no
 * minimum. */
int bench_minima_add(bench_minima *m, const double R[9], const double t[3]);

/* The minimum of this rank: 0 is the best, 1 the second; -1: there are fewer. */
int bench_minima_ranked(const bench_minima *m, int rank);

/* Whether minimum i fits as well as the best one, to a part `tol` of the sum. */
int bench_is_best(const bench_minima *m, int i, double tol);

/* Whether a pose is as good as minimum i, to rounding. */
int bench_is_minimum(const bench_minima *m, int i, const double R[9], const double t[3]);

#endif /* BENCH_MINIMA_H */
