/* rigcal calibrate: observations to poses, rig, targets and pairs. */
#include "cli.h"

#include <math.h>
#include <string.h>

static const double DEGREE = 57.295779513082320877;

/* One camera in one frame. */
typedef struct {
    size_t camera, frame; /* numbers of their names */
    const cli_observation *first;
    size_t n;
    rigcal_transform cam_from_target;
    rigcal_real rms_px;
    rigcal_real distance; /* from the camera to the middle of the points */
} view;

/* The rig's cameras are those with a view; they are numbered anew for it. */
typedef struct {
    cli_cameras cameras;
    cli_observations observations;
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

static const char *camera_name(const calibration *c, size_t rig_camera)
{
    return c->cameras.names.name[c->camera[rig_camera]];
}

/* ==== views =============================================================== */

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
    return (rigcal_real)sqrt(
        (double)(X_c[0] * X_c[0] + X_c[1] * X_c[1] + X_c[2] * X_c[2]));
}

static rigcal_status solve(const calibration *c, view *v, int32_t *bad)
{
    rigcal_status status;
    size_t i;

    for (i = 0; i < v->n; i++) {
        c->observed[i] = v->first[i].seen;
    }
    status = rigcal_solve_pose(
        &v->cam_from_target, &v->rms_px, bad, c->sightings, c->pairs,
        c->n_pairs, &c->cameras.camera[v->camera], c->observed, v->n);
    if (status >= 0) {
        v->distance =
            distance_to_points(&v->cam_from_target, c->observed, v->n);
    }
    return status;
}

/* A view that failed, or that has a caveat. */
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

static void solve_view(calibration *c, const view *v)
{
    view *solved = &c->views[c->n_views];
    int32_t bad = -1;
    rigcal_status status;

    *solved = *v;
    status = solve(c, solved, &bad);
    if (status != RIGCAL_OK) {
        name_trouble(c, v, status, bad);
    }
    if (status < 0) {
        c->exit_status = CLI_GEOMETRY;
    } else {
        c->n_views++;
    }
}

static void solve_views(calibration *c)
{
    const cli_observation *list = c->observations.list;
    const size_t count = c->observations.count;
    size_t begin, end;

    c->n_pairs = rigcal_pairs_for(count < 3 ? 3 : count);
    c->pairs = cli_alloc(c->n_pairs, sizeof *c->pairs);
    c->sightings = cli_alloc(count, sizeof *c->sightings);
    c->observed = cli_alloc(count, sizeof *c->observed);
    c->views = cli_alloc(count, sizeof *c->views);
    for (begin = 0; begin < count; begin = end) {
        view v;

        memset(&v, 0, sizeof v);
        v.camera = list[begin].camera;
        v.frame = list[begin].frame;
        v.first = list + begin;
        for (end = begin; end < count && list[end].camera == v.camera &&
                          list[end].frame == v.frame;
             end++) {
            v.n++;
        }
        solve_view(c, &v);
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
        c->rig_views[i].cam_from_target = v->cam_from_target;
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

static void print_views(const calibration *c)
{
    const int wide_camera = widest(&c->cameras.names);
    const int wide_frame = widest(&c->observations.frames);
    size_t i;

    printf("%-*s  %-*s  points  rms [px]  distance\n", wide_camera, "camera",
           wide_frame, "frame");
    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];

        printf("%-*s  %-*s  %6lu  %8.3f  %8.5g\n", wide_camera,
               c->cameras.names.name[v->camera], wide_frame,
               c->observations.frames.name[v->frame], (unsigned long)v->n,
               (double)v->rms_px, (double)v->distance);
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

static double distance_of(const rigcal_transform *b_from_a)
{
    const double x = (double)b_from_a->t[0], y = (double)b_from_a->t[1],
                 z = (double)b_from_a->t[2];

    return sqrt(x * x + y * y + z * z);
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
           camera_name(c, b), distance_of(&b_from_a), angle_of(&b_from_a));
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

    fprintf(file, "camera,frame,n,%s,rms_px\n", CLI_TRANSFORM_COLUMNS);
    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];

        fprintf(file, "%s,%s,%lu", c->cameras.names.name[v->camera],
                c->observations.frames.name[v->frame], (unsigned long)v->n);
        cli_write_transform(file, &v->cam_from_target);
        cli_write_numbers(file, &v->rms_px, 1);
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

int cli_calibrate(const char *const option[OPTION_COUNT])
{
    calibration c;

    memset(&c, 0, sizeof c);
    cli_cameras_read(&c.cameras, option[OPTION_CAMERAS]);
    cli_observations_read(&c.observations, option[OPTION_OBSERVATIONS],
                          &c.cameras, 1);
    cli_observations_by_view(&c.observations);
    solve_views(&c);
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
