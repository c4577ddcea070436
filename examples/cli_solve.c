/* The pose of every camera in every frame, each by itself. */
#include "cli_calibrate.h"

#include <math.h>
#include <string.h>

/* Points that a pose takes, and that rigcal_robust_solve takes. */
enum { POSE_LEAST = 3, ROBUST_LEAST = 5 };

/* By the published procedure, a view gives at most this many pairs. In a view of more than
 * a quarter as many points, each point is in fewer pairs. Otherwise the pairs of a million
 * points would take five times the memory of their lines. */
enum { PAIRS_MOST = 16384 };

/* At most this many views that fit badly are diagnosed. A view of 50 points takes about 3
 * ms, and if most views are bad, they have one cause. */
enum { DIAGNOSED_MOST = 100 };

const kept_pose *view_taken(const view *v)
{
    return &v->poses[v->taken];
}

const kept_pose *view_second(const view *v)
{
    const size_t other = v->taken == 0 ? 1 : 0;

    return other < v->n_poses ? &v->poses[other] : NULL;
}

rigcal_transform kept_transform(const kept_pose *kept)
{
    rigcal_transform cam_from_target;

    rigcal_rotation_from_quaternion(cam_from_target.R, kept->q_wxyz);
    memcpy(cam_from_target.t, kept->t, sizeof kept->t);
    return cam_from_target;
}

void keep_transform(kept_pose *kept, const rigcal_transform *cam_from_target)
{
    rigcal_quaternion_from_rotation(kept->q_wxyz, cam_from_target->R);
    memcpy(kept->t, cam_from_target->t, sizeof kept->t);
}

double length_of(const rigcal_real x[3])
{
    return sqrt((double)(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]));
}

const char *view_point_name(const calibration *c, const view *v, size_t k)
{
    return c->observations.points.name[cli_point(&c->observations, &v->first[k])];
}

int view_leaves_out(const view *v, size_t k)
{
    return v->agree != NULL && v->agree[k] != POINT_COUNTS;
}

int view_disagrees(const view *v, size_t k)
{
    return v->agree != NULL && v->agree[k] == POINT_DISAGREES;
}

int view_residual(residual *r, const calibration *c, const view *v, size_t k)
{
    const rigcal_transform cam_from_target = kept_transform(view_taken(v));

    return pose_residual(r, c, v, k, &cam_from_target);
}

int pose_residual(residual *r, const calibration *c, const view *v, size_t k,
                  const rigcal_transform *cam_from_target)
{
    const cli_observation *seen = &v->first[k];
    rigcal_real X_c[3], uv[2];

    memset(r, 0, sizeof *r);
    if (rigcal_transform_point(X_c, cam_from_target, cli_X(&c->observations, seen)) < 0 ||
        rigcal_camera_project(uv, &c->cameras.camera[v->camera], X_c) < 0) {
        return 0;
    }
    r->duv[0] = seen->uv[0] - uv[0];
    r->duv[1] = seen->uv[1] - uv[1];
    r->error_px = (rigcal_real)hypot((double)r->duv[0], (double)r->duv[1]);
    return 1;
}

static rigcal_real distance_to_points(const rigcal_transform *cam_from_target,
                                      const rigcal_observation observed[], size_t n)
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

/* ==== the points of a view ================================================ */

static gathered_points *new_points(const calibration *c, size_t room)
{
    gathered_points *points = cli_alloc(1, sizeof *points);

    points->room = room;
    points->list = cli_alloc(room, sizeof *points->list);
    points->sigma = c->is_weighing ? cli_alloc(room, sizeof *points->sigma) : NULL;
    return points;
}

static rigcal_view view_with(const gathered_points *points, const calibration *c,
                             const view *v)
{
    const rigcal_view seen = {&c->cameras.camera[v->camera], points->list, points->sigma,
                              v->n};

    return seen;
}

static void gather(gathered_points *points, const calibration *c, const view *v)
{
    size_t i, n = 0;

    if (v->n > points->room) {
        points->room = v->n;
        points->list = cli_resize(points->list, v->n, sizeof *points->list);
        if (points->sigma != NULL) {
            points->sigma = cli_resize(points->sigma, v->n, sizeof *points->sigma);
        }
    }
    for (i = 0; i < v->n_seen; i++) {
        if (!view_leaves_out(v, i)) {
            if (points->sigma != NULL) {
                points->sigma[n] = cli_sigma_of(&c->observations, &v->first[i]);
            }
            points->list[n++] = cli_seen(&c->observations, &v->first[i]);
        }
    }
    points->of = 0;
}

rigcal_view view_points(const calibration *c, const view *v)
{
    gather(c->gathered, c, v);
    return view_with(c->gathered, c, v);
}

static rigcal_rig_view in_rig(const rigcal_view *seen, const view *v)
{
    rigcal_rig_view of_rig;

    memset(&of_rig, 0, sizeof of_rig);
    of_rig.view = *seen;
    of_rig.camera = (int32_t)v->rig_camera;
    of_rig.placement = (int32_t)v->placement;
    return of_rig;
}

rigcal_status view_at(rigcal_rig_view *seen, size_t index, void *context)
{
    const calibration *c = context;
    const view *v = rig_view(c, index);
    const rigcal_view points = view_points(c, v);

    c->gathered->of = 1 + c->view_of[index];
    *seen = in_rig(&points, v);
    return RIGCAL_OK;
}

/* What the best pose of a view of many points takes long to compute. It stands behind the
 * poses of the view. In a view of few points it would be as large as their lines. */
enum { MANY_POINTS = 8 };
typedef struct {
    rigcal_real information[21], sse;
} known_information;

static known_information *room_for_information(const view *v)
{
    return v->n >= MANY_POINTS ? (known_information *)(void *)(v->poses + v->n_poses)
                               : NULL;
}

static void keep_poses(view *v, const rigcal_pose found[], size_t n_found)
{
    size_t size, k;

    v->n_poses = (uint8_t)(n_found < POSES_KEPT ? n_found : POSES_KEPT);
    size = v->n_poses * sizeof *v->poses;
    v->poses = cli_keep(size + (v->n >= MANY_POINTS ? sizeof(known_information) : 0));
    for (k = 0; k < v->n_poses; k++) {
        keep_transform(&v->poses[k], &found[k].cam_from_world);
        v->poses[k].rms_px = found[k].rms_px;
        v->poses[k].probability = found[k].probability;
    }
}

/* Views that the library has got from view_at stay as they are. */
static rigcal_status compute_pose(rigcal_view_pose *pose, const calibration *c,
                                  const view *v, size_t which)
{
    const size_t of = 1 + (size_t)(v - c->views);
    const rigcal_transform cam_from_target = kept_transform(&v->poses[which]);
    gathered_points *points = c->gathered;
    rigcal_view seen;
    rigcal_rig_view of_rig;

    if (points->of != 0 && points->of != of) {
        points = c->aside;
    }
    if (points->of != of) {
        gather(points, c, v);
        points->of = of;
    }
    seen = view_with(points, c, v);
    of_rig = in_rig(&seen, v);
    return rigcal_view_pose_make(pose, &of_rig, &cam_from_target);
}

rigcal_status make_pose(rigcal_view_pose *pose, const calibration *c, view *v, size_t which)
{
    known_information *known = which == 0 ? room_for_information(v) : NULL;
    rigcal_status status = RIGCAL_OK;

    memset(pose, 0, sizeof *pose);
    if (which >= v->n_poses) {
        return RIGCAL_ERR_NO_POSE;
    }
    if (known != NULL && v->has_information) {
        pose->cam_from_target = kept_transform(&v->poses[0]);
        memcpy(pose->information, known->information, sizeof pose->information);
        pose->sse = known->sse;
        pose->n = v->n;
        pose->camera = (int32_t)v->rig_camera;
        pose->placement = (int32_t)v->placement;
        return RIGCAL_OK;
    }
    status = compute_pose(pose, c, v, which);
    if (status != RIGCAL_OK) {
        pose->n = 0;
    } else if (known != NULL) {
        memcpy(known->information, pose->information, sizeof pose->information);
        known->sse = pose->sse;
        v->has_information = 1;
    }
    return status;
}

static rigcal_status pose_of(rigcal_view_pose *pose, const calibration *c, size_t index)
{
    if (c->rig.view_poses != NULL) {
        *pose = c->rig.view_poses[index];
        return RIGCAL_OK;
    }
    return make_pose(pose, c, rig_view(c, index), 0);
}

rigcal_status pose_at(rigcal_view_pose *pose, size_t index, void *context)
{
    return pose_of(pose, context, index);
}

rigcal_status second_pose_at(rigcal_view_pose *pose, size_t index, void *context)
{
    const calibration *c = context;

    make_pose(pose, c, rig_view(c, index), 1);
    return RIGCAL_OK;
}

rigcal_view_pose pose_in_rig(const calibration *c, size_t index)
{
    rigcal_view_pose pose;

    pose_of(&pose, c, index);
    return pose;
}

/* ==== one pose ============================================================ */

/* The bearings of the points that count. Gathers only some of the points at a time. */
static rigcal_status find_bearings(rigcal_bearing bearings[], const calibration *c,
                                   const view *v, int32_t *at_fault)
{
    enum { PART = 256 };
    rigcal_observation part[PART];
    rigcal_view seen = {&c->cameras.camera[v->camera], part, NULL, 0};
    rigcal_status status = RIGCAL_ERR_TOO_FEW;
    size_t k, n = 0;

    for (k = 0; k < v->n_seen; k++) {
        if (!view_leaves_out(v, k)) {
            part[seen.n++] = cli_seen(&c->observations, &v->first[k]);
        }
        if (seen.n == PART || (seen.n > 0 && k + 1 == v->n_seen)) {
            status = rigcal_bearings_of_view(bearings + n, at_fault, &seen);
            if (status < 0) {
                *at_fault += *at_fault >= 0 ? (int32_t)n : 0;
                return status;
            }
            n += seen.n;
            seen.n = 0;
        }
    }
    return status;
}

static rigcal_status solve_by_paper(const calibration *c, const view *v, int32_t *at_fault)
{
    rigcal_bearing *bearings = cli_alloc(v->n, sizeof *bearings);
    rigcal_paper_pose pose;
    size_t n_pairs = 0;
    rigcal_status status, measured;
    rigcal_view seen;

    status = find_bearings(bearings, c, v, at_fault);
    if (status >= 0) {
        status = rigcal_pairs_choose(c->pairs, c->n_pairs, &n_pairs, bearings, v->n);
    }
    if (status >= 0) {
        status = rigcal_paper_solve(&pose, bearings, v->n, c->pairs, n_pairs, NULL);
    }
    cli_free(bearings);
    if (status < 0) {
        return status;
    }
    seen = view_points(c, v);
    memset(c->found, 0, sizeof *c->found);
    c->found[0].cam_from_world = pose.cam_from_world;
    measured = rigcal_view_rms(&c->found[0].rms_px, NULL, &seen, &pose.cam_from_world);
    return measured < 0 ? measured : status;
}

/* Lets all points count, until some are left out. */
static void note_points(view *v)
{
    if (v->agree == NULL) {
        v->agree = cli_keep(v->n_seen * sizeof *v->agree);
        memset(v->agree, POINT_COUNTS, v->n_seen);
    }
}

/* Pixels beyond the turning point of a lens say nothing about the pose. Such points do not
 * count. */
static void leave_out_unseen(const calibration *c, view *v)
{
    const rigcal_camera *camera = &c->cameras.camera[v->camera];
    rigcal_real ray[3];
    size_t i;

    for (i = 0; i < v->n_seen; i++) {
        if (rigcal_camera_ray(ray, camera, v->first[i].uv) == RIGCAL_ERR_NO_RAY) {
            note_points(v);
            v->agree[i] = POINT_UNSEEN;
            v->n--;
            v->n_unseen++;
        }
    }
}

static void name_unseen(const calibration *c, const view *v)
{
    enum { NAMED = 5 };
    const char *several = v->n_unseen == 1 ? "" : "s";
    size_t k, named = 0;

    cli_say_part("rigcal: camera %s in frame %s: the lens model images no ray at the "
                 "pixel%s of %lu of %lu points:",
                 c->cameras.names.name[v->camera], c->observations.frames.name[v->frame],
                 several, (unsigned long)v->n_unseen, (unsigned long)v->n_seen);
    for (k = 0; k < v->n_seen && named < NAMED; k++) {
        if (view_leaves_out(v, k)) {
            cli_say_part("%s %s", named++ > 0 ? "," : "", view_point_name(c, v, k));
        }
    }
    if (v->n_unseen > named) {
        cli_say_part(" and %lu more", (unsigned long)(v->n_unseen - named));
    }
    cli_say_part("; the other points are used. Check the pixel%s, and the "
                 "distortion coefficients of the camera\n",
                 several);
}

/* Solves with wrong points. Points that disagree do not count any more. */
static rigcal_status solve_robustly(size_t *n_found, const calibration *c, view *v,
                                    const rigcal_view *seen, int32_t *at_fault)
{
    size_t n_agree, k, i = 0;
    const rigcal_status status =
        rigcal_robust_solve(c->found, RIGCAL_POSES_MAX, n_found, c->agree, &n_agree,
                            at_fault, seen, &c->robust);

    if (status < 0) {
        return status;
    }
    note_points(v);
    for (k = 0; k < v->n_seen; k++) {
        if (v->agree[k] == POINT_COUNTS) {
            v->agree[k] = c->agree[i++] ? POINT_COUNTS : POINT_DISAGREES;
        }
    }
    v->n = (uint32_t)n_agree;
    return status;
}

void view_take(const calibration *c, view *v, size_t pose)
{
    const rigcal_transform cam_from_target = kept_transform(&v->poses[pose]);
    const rigcal_view seen = view_points(c, v);
    rigcal_pose_uncertainty u;

    v->taken = (uint8_t)pose;
    v->distance = distance_to_points(&cam_from_target, seen.observations, v->n);
    v->has_sigma = !v->by_paper && rigcal_pose_covariance(&u, &seen, &cam_from_target,
                                                          c->pose.sigma_px) == RIGCAL_OK;
    if (v->has_sigma) {
        v->sigma_deg = (rigcal_real)(DEGREE * length_of(u.rotation));
        v->sigma_pos = (rigcal_real)length_of(u.center);
    }
}

/* The number, among all points of the view, of the point that has this number among those
 * that count. */
static int32_t number_of_point(const view *v, int32_t that_counts)
{
    int32_t k = 0;

    for (; view_leaves_out(v, (size_t)k) || that_counts-- > 0; k++) {
    }
    return k;
}

static rigcal_status solve(const calibration *c, view *v, int32_t *at_fault)
{
    rigcal_view seen;
    rigcal_status status;
    size_t n_found = 1;

    v->by_paper = c->by_paper != 0;
    if (v->by_paper) {
        status = solve_by_paper(c, v, at_fault);
    } else if (c->is_robust && v->n >= ROBUST_LEAST) {
        seen = view_points(c, v);
        status = solve_robustly(&n_found, c, v, &seen, at_fault);
    } else {
        seen = view_points(c, v);
        status = rigcal_pose_solve(c->found, RIGCAL_POSES_MAX, &n_found, at_fault, &seen,
                                   &c->pose);
    }
    v->status = status;
    if (status < 0 && *at_fault >= 0) {
        *at_fault = number_of_point(v, *at_fault);
    }
    if (status >= 0) {
        keep_poses(v, c->found, n_found);
        view_take(c, v, 0);
    }
    return status;
}

/* Names a view that failed, or that has a caveat which the summary does not show. */
static void name_trouble(calibration *c, const view *v, int32_t at_fault)
{
    size_t point = 0;
    trouble_kind kind = TROUBLE_CAVEAT;

    if (v->status == RIGCAL_ERR_TOO_FEW) {
        kind = TROUBLE_TOO_FEW;
    } else if (v->status < 0 && at_fault >= 0) {
        kind = TROUBLE_POINT;
        point = cli_point(&c->observations, &v->first[at_fault]);
    } else if (v->status < 0) {
        kind = TROUBLE_NO_POSE;
    }
    say_of_view(c, v, kind, v->status, point);
}

/* Tells what the pose function returned for a view. A view without a pose is not kept. A
 * view that only fits badly is kept, and the exit status does not change. */
static void find_of(calibration *c, const view *v, const char *what, const char *advice)
{
    const int exit_status = c->exit_status;
    finding *f = find(c, ABOUT_VIEW, what, advice);

    f->v = v->status >= 0 ? v : NULL;
    f->cameras = view_camera_name(c, v);
    f->frames = view_frame_name(c, v);
    if (v->status >= 0) {
        c->exit_status = exit_status;
    }
}

void find_point(calibration *c, const view *v, const rigcal_blame *blame)
{
    const char *camera = view_camera_name(c, v), *frame = view_frame_name(c, v);
    const char *point = view_point_name(c, v, (size_t)blame->point);
    const char *verdict = blame->verdict == RIGCAL_BLAME_SURE ? "is wrong" : "may be wrong";
    const char *what;

    if (blame->rms_px >= 0) {
        what = cli_text("camera %s in frame %s: point %s %s: without it the others fit to "
                        "%.3g px rms, with it to %.3g px",
                        camera, frame, point, verdict, (double)blame->rms_without_px,
                        (double)blame->rms_px);
    } else {
        what = cli_text("camera %s in frame %s: point %s %s: without it there is a pose, "
                        "with %.3g px rms",
                        camera, frame, point, verdict, (double)blame->rms_without_px);
    }
    find_of(c, v, what,
            c->is_robust ? "correct it, or remove its line"
                         : "correct it, remove its line, or use --robust");
}

/* What would make a bad fit good; 0: the data do not show it. */
static int find_cause(calibration *c, const view *v)
{
    const rigcal_view seen = view_points(c, v);
    rigcal_diagnosis d;

    if (rigcal_pose_diagnose(&d, NULL, &seen, &c->pose) != RIGCAL_OK) {
        return 0;
    }
    if (d.verdict == RIGCAL_DIAGNOSIS_MIRRORED) {
        find_of(c, v,
                cli_text("camera %s in frame %s: mirrored, the points fit to %.3g px rms",
                         view_camera_name(c, v), view_frame_name(c, v),
                         (double)(d.rms_mirrored_px >= 0 ? d.rms_mirrored_px
                                                         : d.rms_flipped_px)),
                "are the target's coordinates left-handed, does v count upwards, or is the "
                "image mirrored?");
        return 1;
    }
    if (d.blame.verdict != RIGCAL_BLAME_NONE &&
        (!d.blame.is_rest_poor || 2 * d.blame.rms_without_px < d.blame.rms_px)) {
        find_point(c, v, &d.blame);
        return 1;
    }
    return 0;
}

static void find_bad_fit(calibration *c, view *v)
{
    const int is_looked_into = v->n == v->n_seen - v->n_unseen &&
                               c->n_bad_fits++ < DIAGNOSED_MOST && find_cause(c, v);

    v->is_told = 1;
    if (!is_looked_into && v->status == RIGCAL_POOR_FIT) {
        find_of(c, v,
                cli_text("camera %s in frame %s: the error of its fit, %.3g px rms, is too "
                         "large for noise",
                         view_camera_name(c, v), view_frame_name(c, v),
                         (double)view_taken(v)->rms_px),
                "check which point is which, the target's coordinates and the intrinsics");
    }
}

static void solve_view(calibration *c, const view *v)
{
    view *solved = &c->views[c->n_views];
    int32_t at_fault = -1;
    rigcal_status status;

    *solved = *v;
    leave_out_unseen(c, solved);
    if (solved->n_unseen > 0) {
        name_unseen(c, solved);
        c->exit_status = CLI_GEOMETRY;
    }
    status = solve(c, solved, &at_fault);
    solved->verdict = -1;
    if (status != RIGCAL_OK && status != RIGCAL_AMBIGUOUS && status != RIGCAL_POOR_FIT) {
        name_trouble(c, solved, at_fault);
    }
    if (status == RIGCAL_POOR_FIT || status == RIGCAL_ERR_NO_POSE) {
        find_bad_fit(c, solved);
    }
    if (status < 0) {
        c->exit_status = CLI_GEOMETRY;
    } else {
        c->n_views++;
    }
}

static void name_not_diagnosed(const calibration *c)
{
    if (c->n_bad_fits > DIAGNOSED_MOST) {
        cli_say("%lu views fit badly: a cause was looked for in the first %d. Where most "
                "views do, look at cameras.csv and the target's coordinates first",
                (unsigned long)c->n_bad_fits, DIAGNOSED_MOST);
    }
}

/* Names views with too few points for --robust to tell which are wrong. */
static void name_not_robust(const calibration *c)
{
    size_t i, count = 0;

    for (i = 0; i < c->n_views; i++) {
        count += c->views[i].n_seen < ROBUST_LEAST;
    }
    if (c->is_robust && count > 0) {
        cli_say("--robust takes %d points in a view: in %lu view%s of fewer all "
                "points count",
                ROBUST_LEAST, (unsigned long)count, count == 1 ? "" : "s");
    }
}

static int same_view(const cli_observation *a, const cli_observation *b)
{
    return a->camera == b->camera && a->frame == b->frame;
}

/* The number of views in the list, the number of points of the largest, and the number of
 * views that have points enough for a pose. */
static size_t count_views(const cli_observations *observations, size_t *most,
                          size_t *n_with_pose)
{
    const cli_observation *list = observations->list;
    size_t begin = 0, end, n_views = 0;

    *most = 3;
    *n_with_pose = 0;
    for (end = 1; end <= observations->count; end++) {
        if (end == observations->count || !same_view(&list[end - 1], &list[end])) {
            *most = end - begin > *most ? end - begin : *most;
            *n_with_pose += end - begin >= POSE_LEAST;
            begin = end;
            n_views++;
        }
    }
    return n_views;
}

void solve_views(calibration *c)
{
    const cli_observation *list = c->observations.list;
    const size_t count = c->observations.count;
    size_t begin, end, most, n_with_pose, n_done = 0;
    const size_t n_views = count_views(&c->observations, &most, &n_with_pose);

    if (c->by_paper) {
        c->n_pairs = rigcal_pairs_for(most);
        c->n_pairs = c->n_pairs < PAIRS_MOST ? c->n_pairs : PAIRS_MOST;
        c->pairs = cli_alloc(c->n_pairs, sizeof *c->pairs);
    }
    c->gathered = new_points(c, c->by_paper ? 1 : most);
    c->aside = new_points(c, 1);
    c->found = cli_alloc(RIGCAL_POSES_MAX, sizeof *c->found);
    c->agree = c->is_robust ? cli_alloc(most, sizeof *c->agree) : NULL;
    c->views = cli_alloc(n_with_pose + 1, sizeof *c->views); /* and the one in work */
    for (begin = 0; begin < count; begin = end) {
        view v;

        memset(&v, 0, sizeof v);
        v.camera = list[begin].camera;
        v.frame = list[begin].frame;
        v.first = list + begin;
        for (end = begin; end < count && same_view(&list[begin], &list[end]); end++) {
            v.n++;
        }
        v.n_seen = v.n;
        cli_progress(n_views, "view %lu of %lu", (unsigned long)++n_done,
                     (unsigned long)n_views);
        solve_view(c, &v);
    }
    name_not_robust(c);
    name_not_diagnosed(c);
}
