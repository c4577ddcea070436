/* rig.c - four cameras in one frame, from a tag that was put in two places.
 *
 * Given: the pixels of the corners of a tag, 1 m wide, in five views; whose each view is.
 * Asked: where cameras 1 to 3 are in the frame of camera 0.
 * Truth: each is 0.4 m right of, 0.1 m below and 0.2 m ahead of the one before. */
#include <stdio.h>
#include <rigcal.h>

enum { CAMERAS = 4, VIEWS = 5 };
static const int32_t CAMERA[VIEWS] = {0, 1, 2, 2, 3}, PLACEMENT[VIEWS] = {0, 0, 0, 1, 1};
static const rigcal_real UV[VIEWS][8] = {{522, 312, 768, 352, 768, 672, 522, 733},
                                         {339, 245, 654, 306, 654, 654, 339, 715},
                                         {107, 160, 518, 251, 518, 632, 107, 693},
                                         {438, 312, 704, 352, 704, 672, 438, 733},
                                         {245, 245, 584, 306, 584, 654, 245, 715}};

int main(void)
{
    rigcal_camera camera = {.fx = 800, .fy = 800, .cx = 480, .cy = 480}; /* all alike */
    camera.width = camera.height = 960;
    rigcal_view_pose views[VIEWS];
    rigcal_transform cams_from_rig[CAMERAS], work[VIEWS];
    rigcal_real weight[VIEWS], o[3];
    int32_t group[CAMERAS];
    rigcal_rig rig = {cams_from_rig, group, CAMERAS, views, VIEWS, work, weight};
    rigcal_status status = RIGCAL_OK;
    for (int i = 0; i < VIEWS && status == RIGCAL_OK; i++) {
        rigcal_pose pose = {0};
        size_t n_found;
        status = rigcal_tag_solve(&pose, 1, &n_found, NULL, &camera, UV[i], 1, NULL);
        views[i] = (rigcal_view_pose){pose.cam_from_world, 1, CAMERA[i], PLACEMENT[i]};
    }
    status = (status == RIGCAL_OK) ? rigcal_rig_join(&rig) : status;
    for (int i = 1; i < CAMERAS && status == RIGCAL_OK; i++) {
        status = rigcal_camera_center(o, &cams_from_rig[i]);
        printf("Camera %d is at (%.2f, %.2f, %.2f) m.\n", i, o[0], o[1], o[2]);
    }
    printf("%s\n", rigcal_status_text(status));
    return status == RIGCAL_OK ? 0 : 1;
}
