/* rigcal_rig.h - several cameras in one frame. Included by rigcal.h, whose first page holds
 * here too. */
#ifndef RIGCAL_RIG_H
#define RIGCAL_RIG_H

#include "rigcal.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One camera's pose against one placement of the target. */
typedef struct rigcal_view_pose {
    rigcal_transform cam_from_target;
    rigcal_real weight; /* > 0; e.g. the number of points */
    int32_t camera;     /* 0 .. n_cameras - 1 */
    int32_t placement;  /* >= 0; equal numbers saw the target in one place */
} rigcal_view_pose;

/* Cameras to be joined, and what they saw. */
typedef struct rigcal_rig {
    rigcal_transform *cams_from_rig; /* n_cameras; the rig frame is camera 0's */
    int32_t *group;                  /* n_cameras; the number of the group that a camera
                                        connects in, counted from 0 in the order of their
                                        first cameras: 0 is camera 0's. Cameras of another
                                        group stand in the frame of its first camera */
    size_t n_cameras;                /* >= 1 */
    const rigcal_view_pose *views;   /* n_views, in any order */
    size_t n_views;
    rigcal_transform *work; /* n_views: memory to work in */
    rigcal_real *weight;    /* n_views: the same */
} rigcal_rig;

/* Puts the cameras into the frame of camera 0: from the poses to common placements (17),
 * (18), averaged over placements; a camera that shares none with camera 0 is joined through
 * others that do, the best-shared first. A placement counts by both its weights, w and W,
 * as 1 / (1/w + 1/W). Writes rig->cams_from_rig and rig->group, and the memory to work in.
 * OK, RIGCAL_DISCONNECTED, ERR_NULL, ERR_NOT_FINITE, ERR_ROTATION, ERR_RANGE, ERR_TOO_FEW
 * (no camera). ERR_ROTATION also when the poses contradict each other so far that they have
 * no mean; the outputs are then undefined. Time O(n_cameras^2 n_views^2), stack
 * constant. */
RIGCAL_API rigcal_status rigcal_rig_join(rigcal_rig *rig);

/* Where a placement of the target is in a joined rig: the mean over the cameras that saw
 * it. Only views of `placement` by cameras of `in_group` count; ERR_TOO_FEW when there is
 * none. Writes the memory to work in. The other statuses are those of rigcal_rig_join. */
RIGCAL_API rigcal_status rigcal_rig_place(rigcal_transform *rig_from_target,
                                          rigcal_rig *rig, int32_t placement,
                                          int32_t in_group);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_RIG_H */
