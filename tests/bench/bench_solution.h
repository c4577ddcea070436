/* bench_solution.h - the result of rigcal_pose_solve for a scene, and in which of the
 * scene's minima its poses lie. */
#ifndef BENCH_SOLUTION_H
#define BENCH_SOLUTION_H

#include "bench_minima.h"

typedef struct {
    rigcal_pose poses[RIGCAL_POSES_MAX];
    size_t n;
    rigcal_status status;
    int evals; /* units of rigcal_pose_step */
} bench_solution;

/* Does the same as rigcal_pose_solve, unit by unit, so that units are counted. options
 * NULL: all defaults. */
void bench_solve(bench_solution *found, const bench_scene *s,
                 const rigcal_pose_options *options);

/* The same, and finds the minima of the scene. Minima in which the poses lie are among
 * them. */
void bench_solve_and_find(bench_solution *found, bench_minima *m, const bench_scene *s,
                          const rigcal_pose_options *options);

/* The first pose, in doubles. */
void bench_first(double R[9], double t[3], const bench_solution *found);

/* The minimum in which pose i lies, or -1. */
int bench_minimum_of(bench_minima *m, const bench_solution *found, size_t i);

/* Whether one of the poses lies in a minimum. */
int bench_is_returned(bench_minima *m, int minimum, const bench_solution *found);

#endif /* BENCH_SOLUTION_H */
