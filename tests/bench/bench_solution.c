#include "bench_solution.h"

void bench_solve(bench_solution *found, const bench_scene *s,
                 const rigcal_pose_options *options)
{
    rigcal_pose_solver solver;

    found->n = 0;
    found->evals = 0;
    found->status =
        rigcal_pose_begin(&solver, NULL, &VIEW(&s->camera, s->seen, NULL, s->n), options);
    if (found->status != RIGCAL_OK) {
        return;
    }
    do {
        found->evals++;
    } while (rigcal_pose_step(&solver, 1) == RIGCAL_RUNNING);
    found->status =
        rigcal_pose_result(found->poses, RIGCAL_POSES_MAX, &found->n, NULL, &solver);
}

void bench_solve_and_find(bench_solution *found, bench_minima *m, const bench_scene *s,
                          const rigcal_pose_options *options)
{
    bench_minima_begin(m, s);
    bench_solve(found, s, options);
    for (size_t i = 0; i < found->n; i++) {
        (void)bench_minimum_of(m, found, i);
    }
}

void bench_first(double R[9], double t[3], const bench_solution *found)
{
    test_transform_parts(R, t, &found->poses[0].cam_from_world);
}

int bench_minimum_of(bench_minima *m, const bench_solution *found, size_t i)
{
    double R[9], t[3];

    test_transform_parts(R, t, &found->poses[i].cam_from_world);
    return bench_minima_add(m, R, t);
}

int bench_is_returned(bench_minima *m, int minimum, const bench_solution *found)
{
    for (size_t i = 0; i < found->n; i++) {
        if (bench_minimum_of(m, found, i) == minimum) {
            return 1;
        }
    }
    return 0;
}
