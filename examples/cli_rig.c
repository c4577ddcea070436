/* The rig that the views form. */
#include "cli_calibrate.h"

#include <stdlib.h>
#include <string.h>

/* Poses less likely than this are not weighed against other frames. */
#define PROBABLE ((rigcal_real)1e-3)

/* ==== ambiguous views =====================================================
 *
 * One view cannot tell which of two poses of a flat target is right, but a rig
 * is rigid: with the right one, the rotation to another camera that saw the same
 * placement is that of other frames, where both cameras are sure. With the wrong
 * one it is off by twice the tilt. A pose is taken if its sum of angles to all
 * such rotations is less than half of every other's; else the likeliest stays. */

/* Views are sorted so. */
static int compare_views(const void *va, const void *vb)
{
    const view *a = va, *b = vb;

    if (a->camera != b->camera) {
        return a->camera < b->camera ? -1 : 1;
    }
    return a->frame < b->frame ? -1 : a->frame > b->frame;
}

static const view *find_view(const calibration *c, size_t camera, size_t frame)
{
    view key;

    memset(&key, 0, sizeof key);
    key.camera = camera;
    key.frame = frame;
    return bsearch(&key, c->views, c->n_views, sizeof key, compare_views);
}

static int is_sure(const view *v)
{
    return v != NULL && v->status == RIGCAL_OK && !v->by_paper;
}

static rigcal_real angle_between(const rigcal_transform *a_known,
                                 const rigcal_transform *b_known, const rigcal_transform *a,
                                 const rigcal_transform *b)
{
    rigcal_transform known, here;
    rigcal_real angle = 0;

    rigcal_transform_between(&known, b_known, a_known);
    rigcal_transform_between(&here, b, a);
    rigcal_rotation_angle(&angle, known.R, here.R);
    return angle;
}

/* Adds up the angles of the view's poses to a second camera, which saw the same
 * placement, from those in frames where both are sure; returns how many. */
static size_t add_angles(rigcal_real sum[RIGCAL_POSES_MAX], const calibration *c,
                         const view *v, const view *b)
{
    size_t i, k, n_known = 0;

    for (i = 0; i < c->n_views; i++) {
        const view *known = &c->views[i];
        const view *b_known;

        if (known->camera != v->camera || !is_sure(known)) {
            continue;
        }
        b_known = find_view(c, b->camera, known->frame);
        if (!is_sure(b_known)) {
            continue;
        }
        n_known++;
        for (k = 0; k < v->n_poses; k++) {
            sum[k] += angle_between(
                &view_taken(known)->cam_from_world, &view_taken(b_known)->cam_from_world,
                &v->poses[k].cam_from_world, &view_taken(b)->cam_from_world);
        }
    }
    return n_known;
}

static void settle(const calibration *c, view *v)
{
    rigcal_real sum[RIGCAL_POSES_MAX] = {0};
    size_t i, k, n_known = 0, best = 0;

    for (i = 0; i < c->n_views; i++) {
        const view *b = &c->views[i];

        if (b->frame == v->frame && b->camera != v->camera && is_sure(b)) {
            n_known += add_angles(sum, c, v, b);
        }
    }
    if (n_known == 0) {
        return;
    }
    for (k = 1; k < v->n_poses; k++) {
        if (v->poses[k].probability >= PROBABLE && sum[k] < sum[best]) {
            best = k;
        }
    }
    for (k = 0; k < v->n_poses; k++) {
        if (k != best && v->poses[k].probability >= PROBABLE && 2 * sum[best] > sum[k]) {
            return;
        }
    }
    v->settled = 1;
    view_take(c, v, best);
}

void settle_ambiguous_views(calibration *c)
{
    size_t i;

    for (i = 0; i < c->n_views; i++) {
        if (c->views[i].status == RIGCAL_AMBIGUOUS) {
            settle(c, &c->views[i]);
        }
    }
}

/* ==== rig ================================================================= */

const char *rig_camera_name(const calibration *c, size_t rig_camera)
{
    return c->cameras.names.name[c->camera[rig_camera]];
}

static void number_rig(calibration *c)
{
    rigcal_view_pose *poses = cli_alloc(c->n_views, sizeof *poses);
    size_t i;

    c->camera = cli_alloc(c->n_views, sizeof *c->camera);
    c->first = cli_alloc(c->n_views + 1, sizeof *c->first);
    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];

        if (c->rig.n_cameras == 0 || c->camera[c->rig.n_cameras - 1] != v->camera) {
            c->first[c->rig.n_cameras] = i;
            c->camera[c->rig.n_cameras++] = v->camera;
        }
        poses[i].cam_from_target = view_taken(v)->cam_from_world;
        poses[i].weight = (rigcal_real)v->n;
        poses[i].camera = (int32_t)(c->rig.n_cameras - 1);
        poses[i].placement = (int32_t)v->frame;
    }
    c->rig.views = poses;
    c->rig.n_views = c->n_views;
    c->first[c->rig.n_cameras] = c->n_views;
}

static int is_observed(const calibration *c, size_t camera)
{
    size_t i;

    for (i = 0; i < c->observations.count; i++) {
        if (c->observations.list[i].camera == camera) {
            return 1;
        }
    }
    return 0;
}

static void name_cameras_without_pose(calibration *c)
{
    size_t camera, i = 0;

    for (camera = 0; camera < c->cameras.names.count; camera++) {
        if (i < c->rig.n_cameras && c->camera[i] == camera) {
            i++;
        } else {
            cli_say("camera %s is not in the rig: %s", c->cameras.names.name[camera],
                    is_observed(c, camera) ? "it has no pose in any frame"
                                           : "there are no observations of it");
            c->exit_status = CLI_GEOMETRY;
        }
    }
}

/* Every camera by itself: what is known when joining them failed. */
static void stand_alone(calibration *c)
{
    static const rigcal_transform IDENTITY = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    size_t i;

    for (i = 0; i < c->rig.n_cameras; i++) {
        c->rig.cams_from_rig[i] = IDENTITY;
        c->rig.group[i] = (int32_t)i;
    }
}

static void join_rig(calibration *c)
{
    rigcal_status status;
    size_t i;

    c->rig.cams_from_rig = cli_alloc(c->rig.n_cameras, sizeof *c->rig.cams_from_rig);
    c->rig.group = cli_alloc(c->rig.n_cameras, sizeof *c->rig.group);
    c->rig.work = cli_alloc(c->n_views, sizeof *c->rig.work);
    c->rig.weight = cli_alloc(c->n_views, sizeof *c->rig.weight);
    status = rigcal_rig_join(&c->rig);
    if (status == RIGCAL_OK) {
        return;
    }
    c->exit_status = CLI_GEOMETRY;
    if (status < 0) {
        cli_say("the cameras cannot be joined: %s", rigcal_status_text(status));
        stand_alone(c);
        return;
    }
    for (i = 0; i < c->rig.n_cameras; i++) {
        if (c->rig.group[i] != 0) {
            cli_say("camera %s shares no frame with %s, nor with a camera that does: "
                    "rig.csv and pairs.csv leave it out. Add a frame in which both "
                    "see the target",
                    rig_camera_name(c, i), rig_camera_name(c, 0));
        }
    }
}

/* Frames in which no camera of the rig has a pose, in one line. */
static void name_not_placed(const calibration *c, const int is_apart[], size_t count)
{
    enum { NAMED = 5 };
    size_t frame, n_named = 0;

    cli_say_part("rigcal: frame%s", count == 1 ? "" : "s");
    for (frame = 0; n_named < NAMED && n_named < count; frame++) {
        if (is_apart[frame]) {
            cli_say_part("%s %s", n_named > 0 ? "," : "",
                         c->observations.frames.name[frame]);
            n_named++;
        }
    }
    if (count > n_named) {
        cli_say_part(" and %lu more", (unsigned long)(count - n_named));
    }
    cli_say_part(" %s no place in the frame of %s: no camera joined to it has a pose "
                 "there\n",
                 count == 1 ? "has" : "have", rig_camera_name(c, 0));
}

static void place_targets(calibration *c)
{
    const size_t n_frames = c->observations.frames.count;
    int *is_apart = cli_alloc(n_frames, sizeof *is_apart);
    size_t frame, n_apart = 0;

    c->rig_from_target = cli_alloc(n_frames, sizeof *c->rig_from_target);
    c->placed = cli_alloc(n_frames, sizeof *c->placed);
    for (frame = 0; frame < n_frames; frame++) {
        const rigcal_status status =
            rigcal_rig_place(&c->rig_from_target[frame], &c->rig, (int32_t)frame, 0);

        c->placed[frame] = status >= 0;
        if (status == RIGCAL_ERR_TOO_FEW) {
            is_apart[frame] = 1;
            n_apart++;
        } else if (status < 0) {
            cli_say("frame %s has no place: %s", c->observations.frames.name[frame],
                    rigcal_status_text(status));
        }
        c->exit_status = status < 0 ? CLI_GEOMETRY : c->exit_status;
    }
    if (n_apart > 0) {
        name_not_placed(c, is_apart, n_apart);
    }
}

void rig_relative(rigcal_transform *b_from_a, const calibration *c, size_t a, size_t b)
{
    const rigcal_status status = rigcal_transform_between(
        b_from_a, &c->rig.cams_from_rig[b], &c->rig.cams_from_rig[a]);

    if (status < 0) {
        cli_fail("%s from %s: %s", rig_camera_name(c, b), rig_camera_name(c, a),
                 rigcal_status_text(status));
    }
}

void form_rig(calibration *c)
{
    number_rig(c);
    name_cameras_without_pose(c);
    if (c->n_views > 0) {
        join_rig(c);
        place_targets(c);
    }
}
