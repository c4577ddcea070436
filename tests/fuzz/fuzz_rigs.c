#include "fuzz_rigs.h"

#include <string.h>

static const rigcal_transform IDENTITY = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};

/* Finds the best pose of a view, and the second one if there is one. */
static int solve(fuzz_rig *made, size_t index)
{
    const rigcal_rig_view *view = &made->views[index];
    rigcal_pose poses[RIGCAL_POSES_MAX];
    int32_t at_fault;
    size_t n_found;

    if (rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, &at_fault, &view->view, NULL) <
            0 ||
        rigcal_view_pose_make(&made->poses[index], view, &poses[0].cam_from_world) < 0) {
        return 0;
    }
    memset(&made->second_poses[index], 0, sizeof made->second_poses[index]);
    if (n_found > 1 && rigcal_view_pose_make(&made->second_poses[index], view,
                                             &poses[1].cam_from_world) < 0) {
        made->second_poses[index].n = 0;
    }
    made->second_poses[index].camera = view->camera;
    made->second_poses[index].placement = view->placement;
    return 1;
}

void fuzz_rig_begin(fuzz_rig *made, size_t n_cameras, size_t n_placements)
{
    rigcal_rig *rig = &made->rig;
    size_t i;

    memset(made, 0, sizeof *made);
    for (i = 0; i < n_cameras; i++) {
        made->cams_from_rig[i] = IDENTITY;
    }
    for (i = 0; i < n_placements; i++) {
        made->rig_from_placements[i] = IDENTITY;
    }
    rig->n_cameras = n_cameras;
    rig->n_placements = n_placements;
    rig->cams_from_rig = made->cams_from_rig;
    rig->rig_from_placements = made->rig_from_placements;
    rig->group = made->group;
    rig->views = made->views;
    rig->view_poses = made->poses;
    rig->work = made->work;
    rig->work_capacity = RIG_WORK;
}

void fuzz_rig_add(fuzz_rig *made, size_t camera, size_t placement, size_t n)
{
    rigcal_rig_view *view = &made->views[made->rig.n_views];

    view->view.camera = &made->cameras[camera];
    view->view.observations = made->observations[made->rig.n_views];
    view->view.sigma = NULL;
    view->view.n = n;
    view->camera = (int32_t)camera;
    view->placement = (int32_t)placement;
    made->rig.n_views += (size_t)solve(made, made->rig.n_views);
}

int fuzz_rig_read(fuzz_rig *made, fuzz_bytes *bytes)
{
    const size_t n_cameras = 1 + (size_t)fuzz_below(bytes, RIG_CAMERAS + 1) % RIG_CAMERAS;
    const size_t n_placements =
        1 + (size_t)fuzz_below(bytes, RIG_PLACEMENTS + 1) % RIG_PLACEMENTS;
    size_t c, p, k;

    fuzz_rig_begin(made, n_cameras, n_placements);
    for (c = 0; c < n_cameras; c++) {
        fuzz_camera(&made->cameras[c], bytes);
    }
    for (p = 0; p < n_placements; p++) {
        for (c = 0; c < n_cameras; c++) {
            rigcal_observation *observations = made->observations[made->rig.n_views];
            const size_t n = (size_t)fuzz_below(bytes, RIG_POINTS + 1);

            for (k = 0; k < n; k++) {
                fuzz_reals(observations[k].X_w, 3, bytes);
                fuzz_reals(observations[k].uv, 2, bytes);
            }
            fuzz_rig_add(made, c, p, n);
        }
    }
    return made->rig.n_views > 0;
}

void fuzz_rig_check(const rigcal_rig *rig)
{
    size_t i;

    for (i = 0; i < rig->n_cameras; i++) {
        PROMISE(fuzz_is_transform(&rig->cams_from_rig[i]));
        PROMISE(rig->group[i] >= 0 && rig->group[i] < (int32_t)rig->n_cameras);
    }
    for (i = 0; i < rig->n_placements; i++) {
        PROMISE(fuzz_is_transform(&rig->rig_from_placements[i]));
    }
}
