/* rigcal calibrate: observations to poses, rig, targets and pairs. */
#include "cli.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double DEGREE = 57.295779513082320877;

/* Poses less likely than this are not weighed against other frames. */
#define PROBABLE ((rigcal_real)1e-3)

/* One camera in one frame. */
typedef struct {
    size_t camera, frame; /* numbers of their names */
    const cli_observation *first;
    size_t n_seen;
    const uint8_t *agree; /* of each seen: 0, left out by --robust; NULL: all count */
    size_t n;             /* those that count */
    int by_paper;         /* by the published procedure: one pose, no sigma */
    rigcal_status status; /* OK or a caveat */
    rigcal_pose poses[RIGCAL_POSES_MAX]; /* best first */
    size_t n_poses, taken;
    int settled;          /* other frames told which one */
    rigcal_real distance; /* from the camera to the middle of the points */
    int has_sigma;
    rigcal_real sigma_deg, sigma_pos; /* of the rotation; of the centre */
} view;

/* The rig's cameras are those with a view; they are numbered anew for it. */
typedef struct {
    cli_cameras cameras;
    cli_observations observations;
    int by_paper; /* --method paper */
    int is_robust;
    rigcal_robust_options robust;
    int exit_status;

    rigcal_observation *observed; /* work for one view */
    rigcal_sighting *sightings;
    rigcal_pair *pairs;
    size_t n_pairs;

    view *views; /* those solved, by camera and frame */
    size_t n_views;

    size_t *camera; /* of the rig's camera, the number of its name */
    size_t *first;  /* and its first view; n_rig + 1 of them */
    size_t n_rig;
    rigcal_transform *cam_from_rig;
    int32_t *group;
    rigcal_view *rig_views; /* as views */
    rigcal_transform *work;
    rigcal_real *weight;

    rigcal_transform *rig_from_target; /* by frame */
    int *placed;
} calibration;

static const rigcal_pose *taken(const view *v)
{
    return &v->poses[v->taken];
}

/* The best of the poses not taken, or NULL. */
static const rigcal_pose *second(const view *v)
{
    const size_t other = v->taken == 0 ? 1 : 0;

    return other < v->n_poses ? &v->poses[other] : NULL;
}

static const char *camera_name(const calibration *c, size_t rig_camera)
{
    return c->cameras.names.name[c->camera[rig_camera]];
}

/* ==== views =============================================================== */

static double length_of(const rigcal_real x[3])
{
    return sqrt((double)(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]));
}

static rigcal_real distance_to_points(const rigcal_transform *cam_from_target,
                                      const rigcal_observation observed[],
                                      size_t n)
{
    rigcal_real middle[3] = {0, 0, 0}, X_c[3] = {0, 0, 0};
    size_t i;
    int k;

    for (i = 0; i < n; i++) {
        for (k = 0; k < 3; k++) {
            middle[k] += observed[i].X_w[k] / (rigcal_real)n;
        }
    }
    rigcal_transform_point(X_c, cam_from_target, middle);
    return (rigcal_real)length_of(X_c);
}

static void gather(const calibration *c, const view *v)
{
    size_t i, n = 0;

    for (i = 0; i < v->n_seen; i++) {
        if (v->agree == NULL || v->agree[i]) {
            c->observed[n++] = v->first[i].seen;
        }
    }
}

static rigcal_status solve_by_paper(const calibration *c, view *v,
                                    const rigcal_camera *camera, int32_t *bad)
{
    rigcal_paper_pose pose;
    size_t n_pairs = 0;
    rigcal_status status, measured;

    status = rigcal_sightings_from_observations(c->sightings, bad, camera,
                                                c->observed, v->n);
    if (status >= 0) {
        status = rigcal_pairs_choose(c->pairs, &n_pairs, c->n_pairs,
                                     c->sightings, v->n);
    }
    if (status >= 0) {
        status = rigcal_paper_solve(&pose, c->sightings, v->n, c->pairs,
                                    n_pairs, NULL);
    }
    if (status < 0) {
        return status;
    }
    v->n_poses = 1;
    v->poses[0].cam_from_world = pose.cam_from_world;
    measured = rigcal_reprojection_rms(&v->poses[0].rms_px, NULL, camera,
                                       &pose.cam_from_world, c->observed, v->n);
    return measured < 0 ? measured : status;
}

/* Those that disagree do not count any more. */
static rigcal_status solve_robustly(const calibration *c, view *v,
                                    const rigcal_camera *camera, int32_t *bad)
{
    uint8_t *agree = cli_alloc(v->n, sizeof *agree);
    size_t n_agree;
    const rigcal_status status = rigcal_solve_pose_robust(
        v->poses, &v->n_poses, agree, &n_agree, RIGCAL_POSES_MAX, bad, camera,
        c->observed, NULL, v->n, &c->robust);

    if (status >= 0) {
        v->agree = agree;
        v->n = n_agree;
    }
    return status;
}

/* What follows from the pose that is taken. */
static void measure(const calibration *c, view *v)
{
    const rigcal_transform *pose = &taken(v)->cam_from_world;
    rigcal_pose_uncertainty u;

    gather(c, v);
    v->distance = distance_to_points(pose, c->observed, v->n);
    v->has_sigma = !v->by_paper && rigcal_pose_covariance(
                                       &u, &c->cameras.camera[v->camera], pose,
                                       c->observed, NULL, v->n, 0) == RIGCAL_OK;
    if (v->has_sigma) {
        v->sigma_deg = (rigcal_real)(DEGREE * length_of(u.rotation));
        v->sigma_pos = (rigcal_real)length_of(u.center);
    }
}

static rigcal_status solve(const calibration *c, view *v, int32_t *bad)
{
    const rigcal_camera *camera = &c->cameras.camera[v->camera];
    rigcal_status status;

    gather(c, v);
    v->by_paper = c->by_paper;
    if (v->by_paper) {
        status = solve_by_paper(c, v, camera, bad);
    } else if (c->is_robust && v->n >= 5) {
        status = solve_robustly(c, v, camera, bad);
    } else {
        status = rigcal_solve_pose(v->poses, &v->n_poses, RIGCAL_POSES_MAX, bad,
                                   camera, c->observed, NULL, v->n, NULL);
    }
    v->status = status;
    if (status >= 0) {
        measure(c, v);
    }
    return status;
}

/* A view that failed, or that has a caveat the summary does not tell. */
static void name_trouble(const calibration *c, const view *v,
                         rigcal_status status, int32_t bad)
{
    const char *camera = c->cameras.names.name[v->camera];
    const char *frame = c->observations.frames.name[v->frame];
    const char *text = rigcal_status_text(status);
    const char *failed = status < 0 ? " cannot be solved" : "";

    if (status < 0 && bad >= 0) {
        cli_say("camera %s in frame %s%s, point %s: %s", camera, frame, failed,
                c->observations.points.name[v->first[bad].point], text);
    } else {
        cli_say("camera %s in frame %s%s: %s", camera, frame, failed, text);
    }
}

static const char *point_name(const calibration *c, const view *v, size_t i)
{
    return c->observations.points.name[v->first[i].point];
}

/* The points that --robust left out. */
static void name_left_out(const calibration *c, const view *v)
{
    size_t i;

    if (v->n < v->n_seen) {
        cli_say("camera %s in frame %s: %lu of %lu points disagree and are left out",
                c->cameras.names.name[v->camera],
                c->observations.frames.name[v->frame],
                (unsigned long)(v->n_seen - v->n), (unsigned long)v->n_seen);
    }
    for (i = 0; i < v->n_seen; i++) {
        if (v->agree != NULL && !v->agree[i]) {
            cli_say("    point %s", point_name(c, v, i));
        }
    }
}

/* What would make a bad fit good, where that can be told. */
static void name_cause(const calibration *c, const view *v)
{
    rigcal_real rms_without[RIGCAL_BLAME_POINTS_MAX];
    rigcal_observation work[RIGCAL_BLAME_POINTS_MAX];
    rigcal_diagnosis d;
    const char *camera = c->cameras.names.name[v->camera];

    gather(c, v);
    if (v->n > RIGCAL_BLAME_POINTS_MAX ||
        rigcal_diagnose_pose(&d, rms_without, work, &c->cameras.camera[v->camera],
                             c->observed, NULL, v->n, NULL) != RIGCAL_OK) {
        return;
    }
    if (d.verdict == RIGCAL_DIAGNOSIS_MIRRORED) {
        cli_say("camera %s: are the target's coordinates left-handed, or is the image "
                "mirrored? So it would fit to %.2g px",
                camera,
                (double)(d.rms_mirrored_px >= 0 ? d.rms_mirrored_px
                                                : d.rms_flipped_px));
    } else if (d.blame.verdict != RIGCAL_BLAME_NONE && d.blame.rms_px >= 0) {
        cli_say("camera %s: point %s %s; without it %.2g px instead of %.2g px", camera,
                point_name(c, v, (size_t)d.blame.point),
                d.blame.verdict == RIGCAL_BLAME_SURE ? "disagrees" : "may be wrong",
                (double)d.blame.rms_without_px, (double)d.blame.rms_px);
    } else if (d.blame.verdict != RIGCAL_BLAME_NONE) {
        cli_say("camera %s: point %s disagrees; without it there is a pose, of %.2g px",
                camera, point_name(c, v, (size_t)d.blame.point),
                (double)d.blame.rms_without_px);
    }
}

static void solve_view(calibration *c, const view *v)
{
    view *solved = &c->views[c->n_views];
    int32_t bad = -1;
    rigcal_status status;

    *solved = *v;
    status = solve(c, solved, &bad);
    if (status != RIGCAL_OK && status != RIGCAL_AMBIGUOUS) {
        name_trouble(c, v, status, bad);
    }
    name_left_out(c, solved);
    if ((status == RIGCAL_POOR_FIT || status == RIGCAL_ERR_NO_POSE) &&
        solved->agree == NULL) {
        name_cause(c, solved);
    }
    if (status < 0) {
        c->exit_status = CLI_GEOMETRY;
    } else {
        c->n_views++;
    }
}

static int same_view(const cli_observation *a, const cli_observation *b)
{
    return a->camera == b->camera && a->frame == b->frame;
}

static void solve_views(calibration *c)
{
    const cli_observation *list = c->observations.list;
    const size_t count = c->observations.count;
    size_t begin, end, n_views = 0;

    for (end = 1; end <= count; end++) {
        n_views += end == count || !same_view(&list[end - 1], &list[end]);
    }
    c->n_pairs = rigcal_pairs_for(count < 3 ? 3 : count);
    c->pairs = cli_alloc(c->n_pairs, sizeof *c->pairs);
    c->sightings = cli_alloc(count, sizeof *c->sightings);
    c->observed = cli_alloc(count, sizeof *c->observed);
    c->views = cli_alloc(n_views, sizeof *c->views);
    for (begin = 0; begin < count; begin = end) {
        view v;

        memset(&v, 0, sizeof v);
        v.camera = list[begin].camera;
        v.frame = list[begin].frame;
        v.first = list + begin;
        for (end = begin; end < count && same_view(&list[begin], &list[end]);
             end++) {
            v.n++;
        }
        v.n_seen = v.n;
        solve_view(c, &v);
    }
}

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
                                 const rigcal_transform *b_known,
                                 const rigcal_transform *a,
                                 const rigcal_transform *b)
{
    rigcal_transform known, here;
    rigcal_real angle = 0;

    rigcal_relative_pose(&known, b_known, a_known);
    rigcal_relative_pose(&here, b, a);
    rigcal_rotation_angle(&angle, known.R, here.R);
    return angle;
}

/* Adds up the angles of the view's poses to a second camera, which saw the same
 * placement, from those in frames where both are sure; returns how many. */
static size_t add_angles(rigcal_real sum[RIGCAL_POSES_MAX],
                         const calibration *c, const view *v, const view *b)
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
                &taken(known)->cam_from_world, &taken(b_known)->cam_from_world,
                &v->poses[k].cam_from_world, &taken(b)->cam_from_world);
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
        if (k != best && v->poses[k].probability >= PROBABLE &&
            2 * sum[best] > sum[k]) {
            return;
        }
    }
    v->settled = 1;
    v->taken = best;
    measure(c, v);
}

static void settle_ambiguous_views(calibration *c)
{
    size_t i;

    for (i = 0; i < c->n_views; i++) {
        if (c->views[i].status == RIGCAL_AMBIGUOUS) {
            settle(c, &c->views[i]);
        }
    }
}

/* ==== rig ================================================================= */

static void number_rig(calibration *c)
{
    size_t i;

    c->camera = cli_alloc(c->n_views, sizeof *c->camera);
    c->first = cli_alloc(c->n_views + 1, sizeof *c->first);
    c->rig_views = cli_alloc(c->n_views, sizeof *c->rig_views);
    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];

        if (c->n_rig == 0 || c->camera[c->n_rig - 1] != v->camera) {
            c->first[c->n_rig] = i;
            c->camera[c->n_rig++] = v->camera;
        }
        c->rig_views[i].cam_from_target = taken(v)->cam_from_world;
        c->rig_views[i].weight = (rigcal_real)v->n;
        c->rig_views[i].camera = (int32_t)(c->n_rig - 1);
        c->rig_views[i].placement = (int32_t)v->frame;
    }
    c->first[c->n_rig] = c->n_views;
}

static void name_cameras_without_pose(calibration *c)
{
    size_t camera, i = 0;

    for (camera = 0; camera < c->cameras.names.count; camera++) {
        if (i < c->n_rig && c->camera[i] == camera) {
            i++;
        } else {
            cli_say("camera %s has no pose and is not in the rig",
                    c->cameras.names.name[camera]);
            c->exit_status = CLI_GEOMETRY;
        }
    }
}

/* Every camera by itself: what is known when joining them failed. */
static void stand_alone(calibration *c)
{
    static const rigcal_transform IDENTITY = {{1, 0, 0, 0, 1, 0, 0, 0, 1},
                                              {0, 0, 0}};
    size_t i;

    for (i = 0; i < c->n_rig; i++) {
        c->cam_from_rig[i] = IDENTITY;
        c->group[i] = (int32_t)i;
    }
}

static void join_rig(calibration *c)
{
    rigcal_status status;
    size_t i;

    c->cam_from_rig = cli_alloc(c->n_rig, sizeof *c->cam_from_rig);
    c->group = cli_alloc(c->n_rig, sizeof *c->group);
    c->work = cli_alloc(c->n_views, sizeof *c->work);
    c->weight = cli_alloc(c->n_views, sizeof *c->weight);
    status = rigcal_rig_join(c->cam_from_rig, c->group, c->n_rig, c->rig_views,
                             c->n_views, c->work, c->weight);
    if (status == RIGCAL_OK) {
        return;
    }
    c->exit_status = CLI_GEOMETRY;
    if (status < 0) {
        cli_say("the cameras cannot be joined: %s", rigcal_status_text(status));
        stand_alone(c);
        return;
    }
    for (i = 0; i < c->n_rig; i++) {
        if (c->group[i] != 0) {
            cli_say("camera %s shares no placement with %s%s",
                    camera_name(c, i), camera_name(c, 0),
                    " nor with a camera joined to it; the files leave it out");
        }
    }
}

static void place_targets(calibration *c)
{
    const size_t n_frames = c->observations.frames.count;
    size_t frame;

    c->rig_from_target = cli_alloc(n_frames, sizeof *c->rig_from_target);
    c->placed = cli_alloc(n_frames, sizeof *c->placed);
    for (frame = 0; frame < n_frames; frame++) {
        const rigcal_status status = rigcal_rig_place(
            &c->rig_from_target[frame], (int32_t)frame, 0, c->cam_from_rig,
            c->group, c->n_rig, c->rig_views, c->n_views, c->work, c->weight);

        c->placed[frame] = status >= 0;
        if (status == RIGCAL_ERR_TOO_FEW) {
            cli_say("frame %s is not placed: no camera joined to %s has a pose "
                    "in it",
                    c->observations.frames.name[frame], camera_name(c, 0));
        } else if (status < 0) {
            cli_say("frame %s is not placed: %s",
                    c->observations.frames.name[frame],
                    rigcal_status_text(status));
        }
        c->exit_status = status < 0 ? CLI_GEOMETRY : c->exit_status;
    }
}

static void relative(rigcal_transform *b_from_a, const calibration *c, size_t a,
                     size_t b)
{
    const rigcal_status status = rigcal_relative_pose(
        b_from_a, &c->cam_from_rig[b], &c->cam_from_rig[a]);

    if (status < 0) {
        cli_fail("%s from %s: %s", camera_name(c, b), camera_name(c, a),
                 rigcal_status_text(status));
    }
}

/* ==== summary for a person ================================================ */

static int widest(const cli_names *names)
{
    size_t i, most = 6;

    for (i = 0; i < names->count; i++) {
        const size_t length = strlen(names->name[i]);

        most = length > most ? length : most;
    }
    return (int)most;
}

static void print_sigma(const view *v)
{
    if (v->has_sigma) {
        printf("  %8.2g  %11.2g", (double)v->sigma_deg, (double)v->sigma_pos);
    } else {
        printf("  %8s  %11s", "-", "-");
    }
}

static void print_caveat(const view *v)
{
    const rigcal_pose *other = second(v);

    if (v->by_paper && v->n == 3) {
        printf("  three points fit several poses; one, by --method paper");
    } else if (v->status == RIGCAL_AMBIGUOUS && other != NULL) {
        printf("  ambiguous: 2nd pose %.2f px, p %.2g%s", (double)other->rms_px,
               (double)other->probability,
               v->settled ? ", settled by other frames" : "");
    }
}

static void print_views(const calibration *c)
{
    const int wide_camera = widest(&c->cameras.names);
    const int wide_frame = widest(&c->observations.frames);
    size_t i;

    printf("%-*s  %-*s  points  rms [px]  distance  +- [deg]  +- position\n",
           wide_camera, "camera", wide_frame, "frame");
    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];

        printf("%-*s  %-*s  %6lu  %8.3f  %8.5g", wide_camera,
               c->cameras.names.name[v->camera], wide_frame,
               c->observations.frames.name[v->frame], (unsigned long)v->n,
               (double)taken(v)->rms_px, (double)v->distance);
        print_sigma(v);
        print_caveat(v);
        printf("\n");
    }
}

static void print_cameras(const calibration *c, int32_t group, size_t first)
{
    const int wide = widest(&c->cameras.names);
    size_t i;

    printf("\n%-*s  centre in the frame of %s\n", wide, "camera",
           camera_name(c, first));
    for (i = first; i < c->n_rig; i++) {
        rigcal_real o[3] = {0, 0, 0};

        if (c->group[i] == group) {
            rigcal_camera_center(o, &c->cam_from_rig[i]);
            printf("%-*s  %10.5g %10.5g %10.5g\n", wide, camera_name(c, i),
                   (double)o[0] + 0, (double)o[1] + 0, (double)o[2] + 0);
        }
    }
}

/* b_from_a from each placement that both saw, into work; returns how many. */
static size_t shared_placements(const calibration *c, size_t a, size_t b)
{
    const rigcal_view *va = c->rig_views + c->first[a];
    const rigcal_view *vb = c->rig_views + c->first[b];
    const rigcal_view *end_a = c->rig_views + c->first[a + 1];
    const rigcal_view *end_b = c->rig_views + c->first[b + 1];
    size_t count = 0;

    while (va < end_a && vb < end_b) {
        if (va->placement == vb->placement &&
            rigcal_relative_pose(&c->work[count], &vb->cam_from_target,
                                 &va->cam_from_target) == RIGCAL_OK) {
            count++;
        }
        if (va->placement <= vb->placement) {
            va++;
        } else {
            vb++;
        }
    }
    return count;
}

static double angle_of(const rigcal_transform *b_from_a)
{
    static const rigcal_real NONE[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    rigcal_real angle = 0;

    rigcal_rotation_angle(&angle, NONE, b_from_a->R);
    return DEGREE * (double)angle;
}

static void print_pair(const calibration *c, size_t a, size_t b, int wide)
{
    const size_t shared = shared_placements(c, a, b);
    rigcal_transform b_from_a, mean;
    rigcal_real sigma_rad, sigma_t;

    relative(&b_from_a, c, a, b);
    printf("%-*s  %-*s  %8.5g  %11.4f", wide, camera_name(c, a), wide,
           camera_name(c, b), length_of(b_from_a.t), angle_of(&b_from_a));
    if (shared > 1 &&
        rigcal_transform_mean(&mean, &sigma_rad, &sigma_t, c->work, NULL,
                              shared) == RIGCAL_OK) {
        printf("  +- %.2g, %.2g deg over %lu placements", (double)sigma_t,
               DEGREE * (double)sigma_rad, (unsigned long)shared);
    }
    printf("\n");
}

static void print_pairs(const calibration *c)
{
    const int wide = widest(&c->cameras.names);
    int header = 0;
    size_t a, b;

    for (a = 0; a < c->n_rig; a++) {
        for (b = a + 1; b < c->n_rig; b++) {
            if (c->group[a] != c->group[b]) {
                continue;
            }
            if (!header++) {
                printf("\n%-*s  %-*s  distance  angle [deg]\n", wide, "camera",
                       wide, "camera");
            }
            print_pair(c, a, b, wide);
        }
    }
}

static void print_summary(const calibration *c)
{
    int32_t group = 0;
    size_t i;

    print_views(c);
    for (i = 0; i < c->n_rig; i++) {
        if (c->group[i] == group) {
            print_cameras(c, group++, i);
        }
    }
    print_pairs(c);
}

/* ==== files =============================================================== */

static void write_poses(FILE *file, const calibration *c)
{
    size_t i;

    fprintf(file, "camera,frame,n,%s,rms_px,%s\n", CLI_TRANSFORM_COLUMNS,
            "sigma_rot_deg,sigma_pos,second_rms_px,probability");
    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];
        const rigcal_pose *other = second(v);

        fprintf(file, "%s,%s,%lu", c->cameras.names.name[v->camera],
                c->observations.frames.name[v->frame], (unsigned long)v->n);
        cli_write_transform(file, &taken(v)->cam_from_world);
        cli_write_numbers(file, &taken(v)->rms_px, 1);
        cli_write_known(file, v->sigma_deg, v->has_sigma);
        cli_write_known(file, v->sigma_pos, v->has_sigma);
        cli_write_known(file, other ? other->rms_px : 0, other != NULL);
        cli_write_known(file, taken(v)->probability, !v->by_paper);
        fprintf(file, "\n");
    }
}

static void write_rig(FILE *file, const calibration *c)
{
    size_t i;

    fprintf(file, "camera,%s\n", CLI_TRANSFORM_COLUMNS);
    for (i = 0; i < c->n_rig; i++) {
        if (c->group[i] == 0) {
            fprintf(file, "%s", camera_name(c, i));
            cli_write_transform(file, &c->cam_from_rig[i]);
            fprintf(file, "\n");
        }
    }
}

static void write_targets(FILE *file, const calibration *c)
{
    size_t frame;

    fprintf(file, "frame,%s\n", CLI_TRANSFORM_COLUMNS);
    for (frame = 0; frame < c->observations.frames.count; frame++) {
        if (c->placed[frame]) {
            fprintf(file, "%s", c->observations.frames.name[frame]);
            cli_write_transform(file, &c->rig_from_target[frame]);
            fprintf(file, "\n");
        }
    }
}

static void write_pairs(FILE *file, const calibration *c)
{
    rigcal_transform b_from_a;
    size_t a, b;

    fprintf(file, "camera_a,camera_b,%s\n", CLI_TRANSFORM_COLUMNS);
    for (a = 0; a < c->n_rig; a++) {
        for (b = a + 1; b < c->n_rig; b++) {
            if (c->group[a] == 0 && c->group[b] == 0) {
                relative(&b_from_a, c, a, b);
                fprintf(file, "%s,%s", camera_name(c, a), camera_name(c, b));
                cli_write_transform(file, &b_from_a);
                fprintf(file, "\n");
            }
        }
    }
}

static void write_files(const calibration *c, const char *folder)
{
    cli_output output;

    cli_output_begin(&output, folder);
    write_poses(cli_output_file(&output, "poses.csv"), c);
    write_rig(cli_output_file(&output, "rig.csv"), c);
    write_targets(cli_output_file(&output, "targets.csv"), c);
    write_pairs(cli_output_file(&output, "pairs.csv"), c);
    cli_output_finish(&output);
}

/* ==== the command ========================================================= */

/* Whether it is the published procedure. */
static int choose_method(const char *text)
{
    const int by_paper = text != NULL && strcmp(text, "paper") == 0;

    if (text != NULL && !by_paper && strcmp(text, "ml") != 0) {
        cli_fail("--method is ml or paper, not \"%s\"", text);
    }
    return by_paper;
}

static void choose_robust(calibration *c, const char *const option[OPTION_COUNT])
{
    double threshold, seed;

    c->is_robust = option[OPTION_ROBUST] != NULL;
    rigcal_robust_defaults(&c->robust);
    if (c->is_robust && c->by_paper) {
        cli_fail("--robust goes with --method ml");
    }
    if (!c->is_robust &&
        (option[OPTION_THRESHOLD] != NULL || option[OPTION_SEED] != NULL)) {
        cli_fail("--threshold and --seed go with --robust");
    }
    if (option[OPTION_THRESHOLD] != NULL) {
        cli_numbers(&threshold, 1, "--threshold", option[OPTION_THRESHOLD]);
        if (!(threshold >= 1e-3 && threshold <= 1e6)) {
            cli_fail("--threshold is from 0.001 to 1000000 pixels, not \"%s\"",
                     option[OPTION_THRESHOLD]);
        }
        c->robust.threshold_px = (rigcal_real)threshold;
    }
    if (option[OPTION_SEED] != NULL) {
        cli_numbers(&seed, 1, "--seed", option[OPTION_SEED]);
        if (!(seed >= 0 && seed <= UINT32_MAX && floor(seed) >= seed)) {
            cli_fail("--seed is a whole number from 0 to %lu, not \"%s\"",
                     (unsigned long)UINT32_MAX, option[OPTION_SEED]);
        }
        c->robust.seed = (uint32_t)seed;
    }
}

int cli_calibrate(const char *const option[OPTION_COUNT])
{
    calibration c;

    memset(&c, 0, sizeof c);
    c.by_paper = choose_method(option[OPTION_METHOD]);
    choose_robust(&c, option);
    cli_cameras_read(&c.cameras, option[OPTION_CAMERAS]);
    cli_observations_read(&c.observations, option[OPTION_OBSERVATIONS],
                          &c.cameras, 1);
    cli_observations_by_view(&c.observations);
    solve_views(&c);
    settle_ambiguous_views(&c);
    number_rig(&c);
    name_cameras_without_pose(&c);
    if (c.n_views > 0) {
        join_rig(&c);
        place_targets(&c);
        print_summary(&c);
        if (option[OPTION_OUT] != NULL) {
            write_files(&c, option[OPTION_OUT]);
        }
    }
    return c.exit_status;
}
