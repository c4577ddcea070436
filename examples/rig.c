/* rig.c - four cameras in one frame, from a tag, 1 m wide, that was put in two places.
 * Given: the pixels of its corners in five views, good to 0.5 px. Asked: where cameras are.
 * Truth: each is 0.4 m right of, 0.1 m below and 0.2 m ahead of the one before. */
#include <math.h>
#include <stdio.h>
#include <rigcal.h>
#define TAG(left, right, a, b, c, d) /* its corners: X, Y [m], and u, v [px] */ \
    { \
        {{-.5, .5}, {left, a}}, {{.5, .5}, {right, b}}, {{.5, -.5}, {right, c}}, \
        { \
            {-.5, -.5}, \
            { \
                left, d \
            } \
        } \
    }
static const rigcal_observation SEEN[5][4] = {
    TAG(522, 768, 312, 352, 672, 733), TAG(339, 654, 245, 306, 654, 715),
    TAG(107, 518, 160, 251, 632, 693), TAG(438, 704, 312, 352, 672, 733),
    TAG(245, 584, 245, 306, 654, 715)};
static const rigcal_camera LENS = {0, 960, 960, 800, 800, 480, 480, 0, 0, 0, 0, 0, 0, 0, 0};
static const rigcal_rig_view VIEW[5] = {/* points, whose: camera, placement, target */
                                        {{&LENS, SEEN[0], NULL, 4}, 0, 0, 0},
                                        {{&LENS, SEEN[1], NULL, 4}, 1, 0, 0},
                                        {{&LENS, SEEN[2], NULL, 4}, 2, 0, 0},
                                        {{&LENS, SEEN[3], NULL, 4}, 2, 1, 0},
                                        {{&LENS, SEEN[4], NULL, 4}, 3, 1, 0}};

int main(void)
{
    rigcal_transform cams[4], tags[2], T;
    rigcal_real S[36], work[RIGCAL_RIG_WORK(3, 4, 2)];
    rigcal_view_pose poses[5];
    int32_t group[4];
    rigcal_rig rig = {cams, 4, tags, 2, group, 5, VIEW, .view_poses = poses, .work = work};
    rigcal_status status = RIGCAL_OK;
    rigcal_rig_fit fit;
    for (size_t i = 0, n; i < 5 && status == RIGCAL_OK; i++) {
        rigcal_pose pose = {0};
        status = rigcal_pose_solve(&pose, 1, &n, NULL, &VIEW[i].view, NULL);
        (void)rigcal_view_pose_make(&poses[i], &VIEW[i], &pose.cam_from_world);
    }
    rig.work_capacity = sizeof work / sizeof work[0];
    status = (status == RIGCAL_OK) ? rigcal_rig_join(&rig, NULL) : status;
    status = (status == RIGCAL_OK) ? rigcal_rig_adjust(&fit, NULL, &rig) : status;
    for (int i = 1; i < 4 && status == RIGCAL_OK; i++) { /* T: from i to camera 0 */
        status = rigcal_rig_pair(&T, S, &rig, 0.5, (size_t)i, 0);
        printf("%d: (%.2f, %.2f, %.2f) m\n", i, T.t[0], T.t[1], T.t[2]);
    }
    printf("%s\n", rigcal_status_text(status));
    return status == RIGCAL_OK ? 0 : 1;
}
