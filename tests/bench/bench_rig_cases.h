/* bench_rig_cases.h - rigs at random for bench_rig_statistics: cameras in an arc, of which
 * each sees 30 to 100 % of the placements, with noise of 0.3 px. */
#ifndef BENCH_RIG_CASES_H
#define BENCH_RIG_CASES_H

#include "test_rigs.h"

enum {
    CAMERAS = 8,
    PLACEMENTS = 50,
    POSES = CAMERAS + PLACEMENTS,
    VIEWS = CAMERAS * PLACEMENTS,
    POINTS = 20
};

#define NOISE 0.3 /* px */

typedef enum { BOARD, SPATIAL, TAG, TARGETS } target_kind;
typedef enum { BROWN, RATIONAL, FISHEYE, MIXED, LENSES } lens_kind;

typedef struct {
    int n_cameras, n_placements, n_points, is_apart;
    target_kind target;
    lens_kind lens;
    double far;
    double X[POINTS][3];
    uint8_t sees[PLACEMENTS][CAMERAS];
    rigcal_camera camera[CAMERAS];
    rigcal_transform truth[POSES]; /* cams_from_rig; from index CAMERAS on
                                      rig_from_placements */
    rigcal_transform poses[POSES]; /* poses of the rig, in the same order */
    rigcal_rig_view views[VIEWS];
    rigcal_view_pose own[VIEWS];
    rigcal_observation seen[VIEWS][POINTS];
    int32_t group[CAMERAS];
    rigcal_real work[RIGCAL_RIG_WORK(CAMERAS, CAMERAS, PLACEMENTS)];
    rigcal_rig rig;
} rig_case;

/* A rig of 5 to placements_max placements, whose cameras are connected. Its view_poses are
 * not made yet. The program ends if there is none. */
void rig_case_make(rig_case *r, test_rng *rng, int placements_max);

/* Solves each view by itself, in the minimum near the truth. Returns 0 if a view has no
 * pose. */
int rig_case_solve_views(rig_case *r);

void rig_case_start_at_truth(rig_case *r);
/* Starts each camera and placement from a single view, along a tree that begins at camera
 * 0. */
void rig_case_start_composed(rig_case *r);

#endif /* BENCH_RIG_CASES_H */
