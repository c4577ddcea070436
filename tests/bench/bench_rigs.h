/* bench_rigs.h - the simulated rigs that the benchmarks of an adjustment share.
 *
 * Cameras of 800 px with a Brown lens stand in an arc about a target of random points in a
 * box of 1 x 1 x 0.5, 5 away. Every camera sees every placement, with 0.3 px noise. A rig
 * is defined by its numbers of cameras, placements and points, and by a seed. */
#ifndef BENCH_RIGS_H
#define BENCH_RIGS_H

#include "test_support.h"

#define BENCH_RIG_SEED 20240611
#define BENCH_RIG_NOISE_PX 0.3

typedef struct {
    int n_cameras, n_placements, n_points; /* points in each view */
    rigcal_rig rig; /* points to the other arrays; its views are in the order of
                       placements */
    rigcal_camera *cameras;
    rigcal_observation *observations;
    rigcal_rig_view *views;
    rigcal_view_pose *own;
    rigcal_transform *poses, *starts; /* cams_from_rig, then rig_from_placements */
    int32_t *group;
    rigcal_real *work;
} bench_rig;

/* Camera 0 is the frame. The starts are composed from poses of single views: a camera by
 * placement 0, a placement by camera 0. The program ends if it cannot be made. */
void bench_rig_make(bench_rig *b, int n_cameras, int n_placements, int n_points,
                    uint64_t seed);
void bench_rig_free(bench_rig *b);

/* Sets the poses to the starts again. */
void bench_rig_reset(bench_rig *b);

/* What is counted and timed: functions of their own, so that callgrind can find them. `fit`
 * has no F, because no poses of views are given. */
rigcal_status bench_adjust(rigcal_rig_fit *fit, bench_rig *b);
rigcal_status bench_join(bench_rig *b);

#endif /* BENCH_RIGS_H */
