/* rig.c - four cameras in one frame, from a tag in two placements. The truth: all look one
 * way. Each is 0.4 m to the right of, 0.1 m below and 0.2 m ahead of the one before. The
 * tag is 1 m wide. u = 480 + 800 X / Z, v = 480 + 800 Y / Z, here in whole pixels. */
#include <stdio.h>
#include <rigcal.h>

enum { CAMERAS = 4, VIEWS = 5 };
static const struct {
    int32_t camera, placement;
    rigcal_real uv[8];
} SEEN[VIEWS] = {{0, 0, {522, 312, 768, 352, 768, 672, 522, 733}},
                 {1, 0, {339, 245, 654, 306, 654, 654, 339, 715}},
                 {2, 0, {107, 160, 518, 251, 518, 632, 107, 693}},
                 {2, 1, {438, 312, 704, 352, 704, 672, 438, 733}},
                 {3, 1, {245, 245, 584, 306, 584, 654, 245, 715}}};

int main(void)
{
    const rigcal_camera camera = {.lens = RIGCAL_LENS_BROWN,
                                  .width = 960,
                                  .height = 960,
                                  .fx = 800,
                                  .fy = 800,
                                  .cx = 480,
                                  .cy = 480};
    rigcal_view_pose poses[VIEWS];
    rigcal_transform cams_from_rig[CAMERAS], work[VIEWS];
    rigcal_real weight[VIEWS], o[3];
    int32_t group[CAMERAS];
    rigcal_rig rig = {cams_from_rig, group, CAMERAS, poses, VIEWS, work, weight};
    rigcal_status status = RIGCAL_OK;
    for (int i = 0; i < VIEWS && status == RIGCAL_OK; i++) {
        rigcal_pose p = {0};
        size_t n_found;
        status = rigcal_tag_solve(&p, 1, &n_found, NULL, &camera, SEEN[i].uv, 1, NULL);
        poses[i] =
            (rigcal_view_pose){p.cam_from_world, 1, SEEN[i].camera, SEEN[i].placement};
    }
    if (status != RIGCAL_OK || (status = rigcal_rig_join(&rig)) != RIGCAL_OK) {
        printf("%s\n", rigcal_status_text(status));
        return 1;
    }
    for (int i = 1; i < CAMERAS; i++) {
        rigcal_camera_center(o, &cams_from_rig[i]);
        printf("Camera %d is at (%.2f, %.2f, %.2f) m.\n", i, o[0], o[1], o[2]);
    }
    return 0;
}
