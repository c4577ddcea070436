/* Every camera's pose in every frame, one by one. */
#include "cli_calibrate.h"

#include <math.h>
#include <string.h>

const rigcal_pose *view_taken(const view *v)
{
    return &v->poses[v->taken];
}

/* The best of the poses not taken, or NULL. */
const rigcal_pose *view_second(const view *v)
{
    const size_t other = v->taken == 0 ? 1 : 0;

    return other < v->n_poses ? &v->poses[other] : NULL;
}

double length_of(const rigcal_real x[3])
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

void view_take(const calibration *c, view *v, size_t pose)
{
    const rigcal_transform *cam_from_target = &v->poses[pose].cam_from_world;
    rigcal_pose_uncertainty u;

    v->taken = pose;
    gather(c, v);
    v->distance = distance_to_points(cam_from_target, c->observed, v->n);
    v->has_sigma =
        !v->by_paper &&
        rigcal_pose_covariance(&u, &c->cameras.camera[v->camera],
                               cam_from_target, c->observed, NULL, v->n,
                               0) == RIGCAL_OK;
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
        view_take(c, v, 0);
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

void solve_views(calibration *c)
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
