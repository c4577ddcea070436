/* fuzz_rigs.h - a small rig made from bytes: cameras, placements, views with their
 * poses. */
#ifndef FUZZ_RIGS_H
#define FUZZ_RIGS_H

#include "fuzz.h"

enum {
    RIG_CAMERAS = 3,
    RIG_PLACEMENTS = 5,
    RIG_VIEWS = RIG_CAMERAS * RIG_PLACEMENTS,
    RIG_POINTS = 6,
    RIG_WORK = RIGCAL_JUDGE_WORK(RIG_CAMERAS, RIG_PLACEMENTS) +
               RIGCAL_CLOCKS_WORK(RIG_CAMERAS, RIG_CAMERAS) +
               RIGCAL_CHOOSE_WORK(RIG_CAMERAS, RIG_PLACEMENTS, RIG_VIEWS)
};

typedef struct fuzz_rig {
    rigcal_camera cameras[RIG_CAMERAS];
    rigcal_observation observations[RIG_VIEWS][RIG_POINTS];
    rigcal_rig_view views[RIG_VIEWS];
    rigcal_view_pose poses[RIG_VIEWS], second_poses[RIG_VIEWS];
    rigcal_transform cams_from_rig[RIG_CAMERAS], rig_from_placements[RIG_PLACEMENTS];
    int32_t group[RIG_CAMERAS];
    rigcal_real work[RIG_WORK];
    rigcal_rig rig;
} fuzz_rig;

/* A rig without views, cameras and placements at the origin. Then, for each view in the
 * order of placements: fill made->observations[made->rig.n_views], then add it. Its pose is
 * found by rigcal_pose_solve; a view without one is left out. */
void fuzz_rig_begin(fuzz_rig *made, size_t n_cameras, size_t n_placements);
void fuzz_rig_add(fuzz_rig *made, size_t camera, size_t placement, size_t n);

/* All of it, with cameras and views from the bytes. Returns 0 if no view is left. */
int fuzz_rig_read(fuzz_rig *made, fuzz_bytes *bytes);

/* After a function that writes the rig's poses, all must be rigid. */
void fuzz_rig_check(const rigcal_rig *rig);

#endif /* FUZZ_RIGS_H */
