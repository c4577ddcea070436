/* The rig that the views form. */
#include "cli_calibrate.h"
#include "cli_covariance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const rigcal_transform IDENTITY = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};

const char *rig_camera_name(const calibration *c, size_t rig_camera)
{
    return c->cameras.names.name[c->camera[rig_camera]];
}

const char *view_camera_name(const calibration *c, const view *v)
{
    return c->cameras.names.name[v->camera];
}

const char *view_frame_name(const calibration *c, const view *v)
{
    return c->observations.frames.name[v->frame];
}

const char *rig_frame_name(const calibration *c)
{
    return c->known.path != NULL ? c->known.path : rig_camera_name(c, c->main_camera);
}

/* The first view whose camera is this one or a later one. Views are sorted by camera and
 * frame. */
static const view *first_from(const calibration *c, size_t camera)
{
    size_t low = 0, high = c->n_views;

    while (low < high) {
        const size_t middle = low + (high - low) / 2;

        if (c->views[middle].camera < camera) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return c->views + low;
}

const view *views_of(const view **first, const calibration *c, size_t camera)
{
    *first = first_from(c, camera);
    return first_from(c, camera + 1);
}

/* ==== what the library is given ===========================================
 *
 * It wants the views sorted by placement. Ours are sorted by camera, and stay so. */

/* A view of the rig, and its number in `views`. */
typedef struct {
    uint32_t placement, view;
} place;

static int compare_places(const void *va, const void *vb)
{
    const place *a = va, *b = vb;

    if (a->placement != b->placement) {
        return a->placement < b->placement ? -1 : 1;
    }
    return a->view < b->view ? -1 : a->view > b->view;
}

view *rig_view(const calibration *c, size_t index)
{
    return &c->views[c->view_of[index]];
}

/* Numbers the cameras that have a view anew, in the order of the file. */
static void number_cameras(calibration *c)
{
    size_t i;

    c->camera = cli_alloc(c->cameras.names.count, sizeof *c->camera);
    for (i = 0; i < c->n_views; i++) {
        view *v = &c->views[i];

        if (c->rig.n_cameras == 0 || c->camera[c->rig.n_cameras - 1] != v->camera) {
            c->camera[c->rig.n_cameras++] = v->camera;
        }
        v->rig_camera = (uint32_t)(c->rig.n_cameras - 1);
    }
}

static void gather_views(calibration *c)
{
    place *places = cli_alloc(c->n_views, sizeof *places);
    size_t i, n = 0;

    if (c->view_of == NULL) {
        c->view_of = cli_alloc(c->n_views, sizeof *c->view_of);
    }
    for (i = 0; i < c->n_views; i++) {
        places[i].placement = c->views[i].placement;
        places[i].view = (uint32_t)i;
    }
    qsort(places, c->n_views, sizeof *places, compare_places);
    for (i = 0; i < c->n_views; i++) {
        view *v = &c->views[places[i].view];
        rigcal_view_pose pose;
        const rigcal_status status = make_pose(&pose, c, v, 0);

        v->in_rig = status == RIGCAL_OK;
        if (v->in_rig) {
            v->rig_view = (uint32_t)n;
            c->view_of[n++] = places[i].view;
        } else if (c->n_paired == 0) { /* otherwise the user has been told */
            say_of_view(c, v, TROUBLE_LEFT_OUT, status, 0);
            c->exit_status = CLI_GEOMETRY;
        }
    }
    cli_free(places);
    c->rig.view_source = view_at;
    c->rig.context = c;
    c->rig.view_pose_source = pose_at;
    c->rig.n_views = n;
}

/* The information of all priors together. NULL if the file has no covariances between
 * cameras, or there is only one prior. */
static const rigcal_real *information_of_priors(const calibration *c)
{
    const size_t n_cameras = c->rig.n_cameras;
    size_t *lines = cli_alloc(n_cameras, sizeof *lines), i, n = 0;
    const rigcal_real **own = cli_alloc(n_cameras, sizeof *own);
    rigcal_real *information;

    for (i = 0; i < n_cameras; i++) {
        if (c->known.role[c->camera[i]] == RIGCAL_CAMERA_PRIOR) {
            own[n] = c->known.prior[c->camera[i]].Sigma;
            lines[n++] = c->known.line[c->camera[i]];
        }
    }
    information = n > 1 ? cli_covariance_joint(&c->known.file, lines, own, n) : NULL;
    if (information != NULL && rigcal_priors_information(information, information, n) < 0) {
        cli_fail(
            "%s: the covariances of its cameras, S11 to S66 and those between cameras, "
            "are no covariance together",
            c->known.path);
    }
    return information;
}

/* Gives each camera its role from what is known beforehand. The first fixed camera is the
 * main one. */
static void give_roles(calibration *c)
{
    uint8_t *roles = cli_alloc(c->rig.n_cameras, sizeof *roles);
    rigcal_camera_prior *priors = cli_alloc(c->rig.n_cameras, sizeof *priors);
    int is_any = 0;
    size_t i;

    for (i = 0; i < c->rig.n_cameras; i++) {
        roles[i] = c->known.role[c->camera[i]];
        priors[i] = c->known.prior[c->camera[i]];
        c->rig.cams_from_rig[i] =
            roles[i] == RIGCAL_CAMERA_FREE ? IDENTITY : priors[i].cam_from_rig;
        if (roles[i] != RIGCAL_CAMERA_FREE && !is_any) {
            c->main_camera = i;
            is_any = 1;
        }
    }
    c->rig.roles = is_any ? roles : NULL;
    c->rig.priors = priors;
    c->rig.priors_information = information_of_priors(c);
    c->rig.sigma_px = c->pose.sigma_px;
}

static size_t largest_work(const rigcal_rig *rig, size_t n_views)
{
    const size_t choose = rigcal_choose_work(rig->n_cameras, rig->n_placements, n_views);
    const size_t judge = rigcal_judge_work(rig->n_cameras, rig->n_placements) +
                         rigcal_clocks_work(rig->n_cameras, rig->n_cameras);

    return choose > judge ? choose : judge; /* this is more than an adjustment needs */
}

/* There are at most as many placements without a frame as views. */
static void open_rig(calibration *c)
{
    rigcal_rig *rig = &c->rig;
    const size_t n_frames = c->observations.frames.count;
    size_t i;

    rig->n_placements = n_frames + (c->times.is_free ? c->n_views : 0);
    c->placed = cli_alloc(rig->n_placements, sizeof *c->placed);
    c->paired_by = cli_alloc(rig->n_cameras, sizeof *c->paired_by);
    for (i = 0; i < c->n_views; i++) {
        c->views[i].placement = c->views[i].frame;
    }
    rig->cams_from_rig = cli_alloc(rig->n_cameras, sizeof *rig->cams_from_rig);
    rig->group = cli_alloc(rig->n_cameras, sizeof *rig->group);
    rig->rig_from_placements =
        cli_alloc(rig->n_placements, sizeof *rig->rig_from_placements);
    rig->work_capacity = largest_work(rig, c->n_views);
    rig->work = cli_alloc(rig->work_capacity, sizeof *rig->work);
    c->in_frame = cli_alloc(rig->n_cameras, sizeof *c->in_frame);
    rig->n_placements = n_frames;
}

/* ==== join, adjustment ==================================================== */

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
            const int seen = is_observed(c, camera);

            find(c, ABOUT_CAMERA,
                 cli_text("camera %s is not in the rig: %s", c->cameras.names.name[camera],
                          seen ? "it has no pose in any frame"
                               : "there are no observations of it"),
                 seen ? "the messages below say why, frame by frame"
                      : "check its name in observations.csv, or remove it from cameras.csv")
                ->cameras = c->cameras.names.name[camera];
        }
    }
}

/* Leaves each camera by itself, after joining them failed. */
static void stand_alone(calibration *c)
{
    size_t i;

    for (i = 0; i < c->rig.n_cameras; i++) {
        c->rig.cams_from_rig[i] = IDENTITY;
        c->rig.group[i] = (int32_t)i;
        c->in_frame[i] = i == c->main_camera;
    }
}

void name_rig_trouble(calibration *c, const char *what, rigcal_status status,
                      int32_t at_fault)
{
    c->exit_status = CLI_GEOMETRY;
    if (at_fault >= 0) {
        const view *v = rig_view(c, (size_t)at_fault);

        cli_say("%s because of camera %s in frame %s: %s", what,
                c->cameras.names.name[v->camera], c->observations.frames.name[v->frame],
                rigcal_status_text(status));
    } else {
        cli_say("%s: %s", what, rigcal_status_text(status));
    }
}

/* Finds the groups that are in the rig's frame: those with the main camera, or with a
 * camera whose pose in that frame --prior gives. */
static void find_those_in_frame(calibration *c)
{
    size_t i, k;

    for (i = 0; i < c->rig.n_cameras; i++) {
        for (k = 0; k < c->rig.n_cameras; k++) {
            if (c->rig.group[k] == c->rig.group[i] &&
                (k == c->main_camera || c->known.role[c->camera[k]] != 0)) {
                c->in_frame[i] = 1;
            }
        }
    }
}

/* Names the cameras whose relative position only --prior gives. */
static void name_those_by_prior(calibration *c)
{
    size_t i;

    for (i = 0; i < c->rig.n_cameras; i++) {
        if (c->in_frame[i] && c->rig.group[i] != c->rig.group[c->main_camera]) {
            cli_say("camera %s shares no frame with %s, nor with a camera that does: "
                    "only %s says how they lie, and pairs.csv leaves the pair out",
                    rig_camera_name(c, i), rig_camera_name(c, c->main_camera),
                    c->known.path);
            c->exit_status = CLI_GEOMETRY;
        }
    }
}

/* Joins the rig. With the published procedure there is no adjustment. */
static int join_rig(calibration *c)
{
    int32_t at_fault = -1;
    rigcal_status status;

    cli_progress(c->rig.n_views, "joining %lu views", (unsigned long)c->rig.n_views);
    status = rigcal_rig_join(&c->rig, &at_fault);
    if (status < 0) {
        name_rig_trouble(c, "the cameras cannot be joined", status, at_fault);
        return 0;
    }
    if (status != RIGCAL_OK && status != RIGCAL_DISCONNECTED) {
        name_rig_trouble(c, "joining the cameras", status, -1);
    }
    return 1;
}

/* Finds the noise that the sigmas of the rig are computed for, and how many times more than
 * it the views disagree. Without --sigma, the noise is that of the views at their own
 * poses. */
void find_noise(calibration *c)
{
    const rigcal_rig_fit *fit = &c->fit;
    double own = 0, within = (double)fit->freedom_within;
    size_t i;

    for (i = 0; i < c->rig.n_views; i++) {
        own += c->rig.left_out != NULL && c->rig.left_out[i]
                   ? 0
                   : (double)pose_in_rig(c, i).sse;
    }
    c->own_rms_px = sqrt(own / (double)fit->n_points);
    if (c->pose.sigma_px > 0) {
        c->noise_px = (double)c->pose.sigma_px;
    } else {
        c->noise_px = within > 0 ? sqrt(own / within) : (double)fit->sigma_px;
    }
    c->root_F = sqrt((double)fit->F);
    c->factor = c->root_F > 1 ? c->root_F : 1;
}

static void find_noise_of_cameras(calibration *c)
{
    const size_t n = c->rig.n_cameras;
    rigcal_real *freedom = cli_alloc(n, sizeof *freedom);

    c->sigma_px = cli_alloc(n, sizeof *c->sigma_px);
    if (rigcal_rig_noise(c->sigma_px, freedom, &c->rig) != RIGCAL_OK) {
        memset(c->sigma_px, 0, n * sizeof *c->sigma_px);
    }
}

/* ==== placements ========================================================== */

/* Names in one line the frames in which no camera of the rig has a pose. */
static void name_not_placed(const calibration *c, const int hidden[], size_t count)
{
    enum { NAMED = 5 };
    size_t frame, n_named = 0;

    cli_say_part("rigcal: frame%s", count == 1 ? "" : "s");
    for (frame = 0; n_named < NAMED && n_named < count; frame++) {
        const size_t placement = c->placement_of[frame];

        if (!c->placed[placement] && !hidden[placement]) {
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
                 count == 1 ? "has" : "have", rig_frame_name(c));
}

static int has_views(const calibration *c, size_t placement)
{
    size_t i;

    for (i = 0; i < c->n_views; i++) {
        if (c->views[i].placement == placement) {
            return 1;
        }
    }
    return 0;
}

/* Finds the placements that have a pose. Frames with a view that is left out are reported
 * there. So are frames whose only pictures are now paired with other frames. */
static void find_placed(calibration *c)
{
    int *hidden = cli_alloc(c->rig.n_placements, sizeof *hidden);
    size_t i, n_apart = 0;

    for (i = 0; i < c->observations.frames.count; i++) {
        hidden[c->placement_of[i]] = c->n_paired > 0 && !has_views(c, c->placement_of[i]);
    }
    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];

        if (v->in_rig && c->in_frame[v->rig_camera]) {
            c->placed[v->placement] = 1;
        }
        hidden[v->placement] |= v->is_left_out;
    }
    for (i = 0; i < c->observations.frames.count; i++) {
        const size_t placement = c->placement_of[i];

        n_apart += !c->placed[placement] && !hidden[placement];
    }
    if (n_apart > 0) {
        name_not_placed(c, hidden, n_apart);
        c->exit_status = CLI_GEOMETRY;
    }
}

/* After joining failed: the placements get the poses of the first camera. */
static void place_alone(calibration *c)
{
    size_t i;

    for (i = 0; i < c->n_views; i++) {
        view *v = &c->views[i];

        v->in_rig = v->in_rig && v->rig_camera == c->main_camera;
        if (v->in_rig) {
            c->rig.rig_from_placements[v->placement] = kept_transform(view_taken(v));
        }
    }
}

/* ==== what follows ======================================================== */

rigcal_transform view_in_rig(const calibration *c, const view *v)
{
    rigcal_transform pose = kept_transform(view_taken(v));

    if (v->in_rig) {
        rigcal_transform_compose(&pose, &c->rig.cams_from_rig[v->rig_camera],
                                 &c->rig.rig_from_placements[v->placement]);
    }
    return pose;
}

view_residuals residuals_in_rig(const calibration *c, const view *v)
{
    static rigcal_real *duv;
    static size_t room;
    view_residuals of = {v, view_in_rig(c, v), NULL, 0, 1};

    if (c->rig.clocks != NULL && c->is_adjusted && v->in_rig) {
        size_t n;

        if (duv == NULL || 2 * (size_t)v->n > room) {
            room = 2 * (size_t)v->n;
            duv = duv == NULL ? cli_alloc(room, sizeof *duv)
                              : cli_resize(duv, room, sizeof *duv);
        }
        of.is_known =
            rigcal_rig_residuals(duv, room, &n, &c->rig, v->rig_view) == RIGCAL_OK;
        of.duv = duv;
    }
    return of;
}

residual next_residual(view_residuals *of, const calibration *c, size_t k)
{
    residual r;

    r.is_known = pose_residual(&r, c, of->v, k, &of->pose) && of->is_known;
    if (of->is_known && of->duv != NULL && !view_leaves_out(of->v, k)) {
        memcpy(r.duv, &of->duv[2 * of->n_counted++], sizeof r.duv);
        r.error_px = (rigcal_real)hypot((double)r.duv[0], (double)r.duv[1]);
    }
    return r;
}

/* Standard deviations of a pose with covariance Sigma: of the rotation, and of the centre,
 * which moves by -R^T (t x w + dt). */
static void fill_sigma(rig_sigma *s, const rigcal_real t[3])
{
    static const int NEXT[3] = {1, 2, 0};
    double rotation = 0, centre = 0;
    int i, j, k;

    for (i = 0; i < 3; i++) {
        double row[6] = {0};
        const int y = NEXT[i], z = NEXT[NEXT[i]];

        row[z] = (double)t[y];
        row[y] = -(double)t[z];
        row[3 + i] = 1;
        rotation += (double)s->Sigma[7 * i];
        for (j = 0; j < 6; j++) {
            for (k = 0; k < 6; k++) {
                centre += row[j] * (double)s->Sigma[6 * j + k] * row[k];
            }
        }
    }
    s->deg = DEGREE * sqrt(fmax(rotation, 0));
    s->position = sqrt(fmax(centre, 0));
}

rigcal_real rig_noise_px(const calibration *c)
{
    return c->is_adjusted ? (rigcal_real)(c->noise_px * c->factor) : 0;
}

int rig_camera_sigma(rig_sigma *s, const calibration *c, size_t rig_camera)
{
    const rigcal_real noise_px = rig_noise_px(c);

    memset(s, 0, sizeof *s);
    if (!(noise_px > 0) ||
        rigcal_rig_covariance(s->Sigma, &c->rig, noise_px, rig_camera) != RIGCAL_OK) {
        return 0;
    }
    fill_sigma(s, c->rig.cams_from_rig[rig_camera].t);
    return 1;
}

int rig_pair(rigcal_transform *b_from_a, rig_sigma *s, const calibration *c, size_t a,
             size_t b)
{
    const rigcal_real noise_px = rig_noise_px(c);
    rigcal_status status;

    memset(s, 0, sizeof *s);
    status = rigcal_transform_between(b_from_a, &c->rig.cams_from_rig[b],
                                      &c->rig.cams_from_rig[a]);
    if (status < 0) {
        cli_fail("%s from %s: %s", rig_camera_name(c, b), rig_camera_name(c, a),
                 rigcal_status_text(status));
    }
    if (!(noise_px > 0) ||
        rigcal_rig_pair(b_from_a, s->Sigma, &c->rig, noise_px, a, b) != RIGCAL_OK) {
        return 0;
    }
    fill_sigma(s, b_from_a->t);
    return 1;
}

rigcal_real rig_camera_noise(const calibration *c, size_t rig_camera)
{
    const rigcal_real own = c->sigma_px != NULL ? c->sigma_px[rig_camera] : 0;

    if (!c->is_adjusted) {
        return 0;
    }
    return own > 0 ? own : (rigcal_real)c->noise_px;
}

rigcal_calibrated_rig rig_kept(const calibration *c)
{
    const size_t n = c->rig.n_cameras, size = rigcal_calibrated_size(n);
    rigcal_calibrated_rig kept;

    memset(&kept, 0, sizeof kept);
    if (!(rig_noise_px(c) > 0)) {
        return kept;
    }
    kept.cameras = cli_alloc(n, sizeof *kept.cameras);
    kept.group = cli_alloc(n, sizeof *kept.group);
    kept.held = cli_alloc(n, sizeof *kept.held);
    kept.capacity = n;
    kept.Sigma = cli_alloc(size, sizeof *kept.Sigma);
    kept.Sigma_capacity = size;
    if (rigcal_calibrated_take(&kept, &c->rig, &c->fit, rig_noise_px(c)) != RIGCAL_OK) {
        kept.n_cameras = 0;
    }
    return kept;
}

/* Sorts the views by placement and makes their rig. Repeats this if frames are paired
 * anew. */
static int join_or_judge(calibration *c)
{
    int outcome;

    do {
        gather_views(c);
        if (c->rig.n_views == 0) {
            return 0;
        }
        outcome = c->by_paper ? join_rig(c) : judge_rig(c);
    } while (outcome == RIG_PAIRED_ANEW);
    return outcome;
}

void form_rig(calibration *c)
{
    int is_joined;
    size_t i;

    number_cameras(c);
    name_cameras_without_pose(c);
    c->placement_of = cli_alloc(c->observations.frames.count, sizeof *c->placement_of);
    for (i = 0; i < c->observations.frames.count; i++) {
        c->placement_of[i] = (uint32_t)i;
    }
    if (c->n_views == 0) {
        return;
    }
    open_rig(c);
    give_roles(c);
    is_joined = join_or_judge(c);
    if (!is_joined) {
        stand_alone(c);
        place_alone(c);
    } else {
        find_those_in_frame(c);
        name_those_by_prior(c);
        find_groups(c);
    }
    if (c->is_adjusted) {
        find_noise(c);
        consider_intrinsics(c);
        find_noise_of_cameras(c);
    }
    find_placed(c);
}
