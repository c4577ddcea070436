/* rig.c - four cameras in one frame, from a tag, 1 m wide, that was put in two places.
 * Given: X, Y and u, v of its corners in five views. Asked: where the cameras are.
 * Truth: each is 0.4 m right of, 0.1 m below and 0.2 m ahead of the one before. */
#include <math.h>
#include <stdio.h>
#include <rigcal.h>
static const rigcal_observation SEEN[5][4] = {
    {{{0, 1}, {522, 312}}, {{1, 1}, {768, 352}}, {{1, 0}, {768, 672}}, {{0}, {522, 733}}},
    {{{0, 1}, {339, 245}}, {{1, 1}, {654, 306}}, {{1, 0}, {654, 654}}, {{0}, {339, 715}}},
    {{{0, 1}, {107, 160}}, {{1, 1}, {518, 251}}, {{1, 0}, {518, 632}}, {{0}, {107, 693}}},
    {{{0, 1}, {438, 312}}, {{1, 1}, {704, 352}}, {{1, 0}, {704, 672}}, {{0}, {438, 733}}},
    {{{0, 1}, {245, 245}}, {{1, 1}, {584, 306}}, {{1, 0}, {584, 654}}, {{0}, {245, 715}}}};
static const rigcal_camera LENS = {0, 960, 960, 800, 800, 480, 480, 0, 0, 0, 0, 0, 0, 0, 0};
static const int32_t CAMERA[5] = {0, 1, 2, 2, 3}, PLACEMENT[5] = {0, 0, 0, 1, 1};
int main(void)
{
    rigcal_transform cams[4], tags[2], T;
    rigcal_real S[36], work[RIGCAL_RIG_WORK(3, 4, 2)];
    rigcal_rig_view views[5];
    rigcal_view_pose poses[5];
    int32_t group[4];
    rigcal_rig rig = {cams, 4, tags, 2, group, 5, views, .view_poses = poses, .work = work};
    rigcal_rig_fit fit;
    rigcal_status status = RIGCAL_OK;
    for (size_t i = 0, n; i < 5 && status == RIGCAL_OK; i++) { /* each view by itself */
        rigcal_pose pose = {0};
        views[i] = (rigcal_rig_view){{&LENS, SEEN[i], NULL, 4}, CAMERA[i], PLACEMENT[i], 0};
        status = rigcal_pose_solve(&pose, 1, &n, NULL, &views[i].view, NULL);
        (void)rigcal_view_pose_make(&poses[i], &views[i], &pose.cam_from_world);
    }
    rig.work_capacity = sizeof work / sizeof work[0];
    status = (status == RIGCAL_OK) ? rigcal_rig_join(&rig, NULL) : status;
    status = (status == RIGCAL_OK) ? rigcal_rig_adjust(&fit, NULL, &rig) : status;
    for (size_t i = 1; i < 4 && status == RIGCAL_OK; i++) { /* T: from camera i to 0 */
        status = rigcal_rig_pair(&T, S, &rig, 0.5, i, 0);   /* for noise of 0.5 px */
        printf("(%.2f, %.2f, %.2f) m, +- %.3f m\n", T.t[0], T.t[1], T.t[2], sqrt(S[35]));
    }
    printf("%s\n", rigcal_status_text(status));
    return status == RIGCAL_OK ? 0 : 1;
}
