/* Why views are left out of the rig, and why there may be no rig. */
#include "cli_calibrate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const rigcal_transform IDENTITY = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};

/* The cause is looked for in at most this many views. Each view needs one pose for each
 * symmetry. */
enum { LOOKED_INTO_MOST = 1000 };

/* The parts of a sentence about a view or a camera: "the points of ", "c", " are numbered
 * in reverse". If `after` is NULL, nothing was found. */
typedef struct {
    const char *before, *name, *after, *advice;
} reason;

static const reason NOTHING = {NULL, NULL, NULL, NULL};

static void set_reason(reason *r, const char *before, const char *name, const char *after,
                       const char *advice)
{
    r->before = before;
    r->name = name;
    r->after = after;
    r->advice = advice;
}

/* ==== from the library's cause to words =================================== */

static void tell_turn(reason *r, const char *of, double deg, int is_mirrored)
{
    if (is_mirrored) {
        set_reason(r, "the points of ", of,
                   " are numbered as in a mirror, or their coordinates are mirrored",
                   "number the points as on the target, not from behind it");
    } else if (deg > 179) {
        set_reason(r, "the points of ", of,
                   " are numbered in reverse, as if the target were turned by 180 degrees",
                   "number the points from the other end of the target");
    } else {
        set_reason(
            r, "the points of ", of,
            cli_text(" are numbered as if the target were turned by %.0f degrees", deg),
            "number the points from the right corner of the target");
    }
}

static void tell_shift(reason *r, const char *of, const rigcal_cause *cause)
{
    set_reason(r, "each view of ", of,
               cause->is_still    ? " is of the frame before or after, between which the "
                                    "target stood still"
               : cause->shift < 0 ? " is of the frame before: the camera is late"
                                  : " is of the frame after: the camera is early",
               "give each image the frame in which it was taken");
}

/* Puts the cause of a view, or of all views of a camera, into words. */
static void tell_cause(reason *r, const calibration *c, const rigcal_cause *cause,
                       const symmetries *by, const char *camera, int is_view)
{
    const char *of = is_view ? camera : cli_text("all views of %s", camera);

    switch (cause->cause) {
    case RIGCAL_CAUSE_TURNED:
        tell_turn(r, of, by->deg[cause->permutation], by->is_mirrored[cause->permutation]);
        break;
    case RIGCAL_CAUSE_SHIFTED:
        tell_shift(r, camera, cause);
        r->before = is_view ? "the view of " : r->before;
        break;
    case RIGCAL_CAUSE_SWAPPED:
        set_reason(r, "the views of ",
                   cli_text("%s and %s", camera, rig_camera_name(c, (size_t)cause->camera)),
                   " are swapped", "give each image the name of the camera that took it");
        break;
    default:
        break;
    }
}

/* ==== a view ============================================================== */

/* For each point: where it is on the target, as the views in the rig have it. */
static const rigcal_real **points_in_rig(const calibration *c)
{
    const rigcal_real **place =
        cli_alloc(c->observations.points.count, sizeof(const rigcal_real *));
    size_t i, k;

    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];

        for (k = 0; v->in_rig && k < v->n_seen; k++) {
            const rigcal_real **at = &place[cli_point(&c->observations, &v->first[k])];

            *at = *at == NULL ? cli_X(&c->observations, &v->first[k]) : *at;
        }
    }
    return place;
}

static double dot(const rigcal_real a[3], const rigcal_real b[3])
{
    return (double)a[0] * (double)b[0] + (double)a[1] * (double)b[1] +
           (double)a[2] * (double)b[2];
}

/* The factor by which the view's coordinates differ from those of the same points in other
 * views; 0: there is no such factor. */
static double coordinate_factor(const calibration *c, const view *v,
                                const rigcal_real *const place[])
{
    double squares = 0, products = 0, factor, own = 0, off = 0;
    size_t k, n = 0;
    int i;

    for (k = 0; k < v->n_seen; k++) {
        const rigcal_real *X = cli_X(&c->observations, &v->first[k]);
        const rigcal_real *known = place[cli_point(&c->observations, &v->first[k])];

        if (known != NULL) {
            squares += dot(known, known);
            products += dot(known, X);
            own += dot(X, X);
            n++;
        }
    }
    factor = squares > 0 ? products / squares : 0;
    for (k = 0; k < v->n_seen; k++) {
        const rigcal_real *X = cli_X(&c->observations, &v->first[k]);
        const rigcal_real *known = place[cli_point(&c->observations, &v->first[k])];

        for (i = 0; known != NULL && i < 3; i++) {
            const double apart = (double)X[i] - factor * (double)known[i];

            off += apart * apart;
        }
    }
    return n >= 3 && off < 1e-6 * own ? factor : 0;
}

/* The factor by which the target is farther away than the other views say, in the same
 * direction and with the same rotation; 0: it is not. */
static double distance_factor(const calibration *c, const view *v)
{
    const rigcal_transform found = kept_transform(view_taken(v));
    rigcal_transform there;
    rigcal_real angle = 0;
    double cosine;

    if (v->verdict != RIGCAL_VIEW_CONTRADICTS ||
        rigcal_transform_compose(&there, &c->rig.cams_from_rig[v->rig_camera],
                                 &c->rig.rig_from_placements[v->placement]) < 0) {
        return 0;
    }
    rigcal_rotation_angle(&angle, there.R, found.R);
    cosine = dot(found.t, there.t) / (length_of(found.t) * length_of(there.t));
    return DEGREE * (double)angle < 3 && cosine > 0.9986
               ? length_of(found.t) / length_of(there.t)
               : 0;
}

static void tell_unit(reason *r, const calibration *c, const view *v,
                      const rigcal_real *const place[])
{
    double factor = coordinate_factor(c, v, place);

    factor = factor > 0 ? factor : distance_factor(c, v);
    if (factor > 0 && fabs(log(factor)) > 0.02) {
        set_reason(r, "the target's coordinates for ", view_camera_name(c, v),
                   cli_text(" are %.4g times those of the others: a wrong unit", factor),
                   "give X, Y, Z of all observations in the same unit");
    }
}

/* Solves the mirrored image of the view, upside down or not. Returns whether that pose
 * agrees with where the other views put the target. */
static int fits_mirrored(const calibration *c, const view *v, const rigcal_transform *there,
                         int is_upside_down)
{
    const rigcal_camera *camera = &c->cameras.camera[v->camera];
    rigcal_view seen = view_points(c, v);
    rigcal_pose poses[RIGCAL_POSES_MAX];
    rigcal_real angle = 0;
    size_t i, n = 0;

    for (i = 0; i < seen.n; i++) { /* view_points gathers them again at each call */
        rigcal_real *uv = c->gathered->list[i].uv;

        uv[is_upside_down] =
            (rigcal_real)(is_upside_down ? camera->height : camera->width) - 1 -
            uv[is_upside_down];
    }
    if (rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n, NULL, &seen, &c->pose) < 0) {
        return 0;
    }
    for (i = 0; i < n; i++) {
        const rigcal_real *t = poses[i].cam_from_world.t;
        const rigcal_real off[3] = {t[0] - there->t[0], t[1] - there->t[1],
                                    t[2] - there->t[2]};

        rigcal_rotation_angle(&angle, there->R, poses[i].cam_from_world.R);
        if (DEGREE * (double)angle < 5 && length_of(off) < 0.05 * length_of(there->t)) {
            return 1;
        }
    }
    return 0;
}

static void tell_mirror(reason *r, const calibration *c, const view *v)
{
    rigcal_transform there;

    if (v->verdict == RIGCAL_VIEW_CONTRADICTS &&
        rigcal_transform_compose(&there, &c->rig.cams_from_rig[v->rig_camera],
                                 &c->rig.rig_from_placements[v->placement]) >= 0 &&
        (fits_mirrored(c, v, &there, 0) || fits_mirrored(c, v, &there, 1))) {
        set_reason(r, "the image of ", view_camera_name(c, v), " is mirrored",
                   "u counts to the right and v downwards: do not mirror the image");
    }
}

static void tell_point(reason *r, const calibration *c, const view *v)
{
    const rigcal_view seen = view_points(c, v);
    rigcal_pose_options options = c->pose;
    rigcal_blame blame;

    options.sigma_px = c->judgement.sigma_px;
    if (v->n > 5 && rigcal_pose_blame(&blame, NULL, &seen, &options) >= 0 &&
        blame.verdict == RIGCAL_BLAME_SURE && blame.rms_px >= 0) {
        set_reason(
            r, "of ", view_camera_name(c, v),
            cli_text(" point %s is wrong", view_point_name(c, v, (size_t)blame.point)),
            "correct the point, remove its line, or use --robust");
    }
}

/* The reason why view i of the rig is wrong. */
static reason find_reason(calibration *c, size_t i, const rigcal_real *const place[])
{
    const view *v = rig_view(c, i);
    const char *camera = view_camera_name(c, v);
    const rigcal_view seen = view_points(c, v);
    const symmetries *by = symmetries_of(&seen);
    reason r = NOTHING;
    rigcal_cause cause = {0};

    tell_unit(&r, c, v, place);
    if (r.after == NULL && cause_of_view(&cause, c, i, by) == RIGCAL_OK &&
        !(cause.cause == RIGCAL_CAUSE_SWAPPED && (size_t)cause.camera < v->rig_camera)) {
        tell_cause(&r, c, &cause, by, camera, 1);
    } else if (r.after != NULL || cause.cause == RIGCAL_CAUSE_SWAPPED) {
        return r; /* said already, of the camera before */
    }
    if (r.after == NULL) {
        tell_mirror(&r, c, v);
    }
    if (r.after == NULL) {
        tell_point(&r, c, v);
    }
    return r;
}

/* ==== a placement ========================================================= */

typedef struct {
    const char *name[64]; /* at most this many cameras left out are named */
    size_t n;
    reason reasons[64];
    size_t n_reasons;
    int is_told, is_one_of_two;
    const view *v;
} wrong_views;

static int is_alike(const reason *a, const reason *b)
{
    return strcmp(a->before, b->before) == 0 && strcmp(a->after, b->after) == 0;
}

/* "the points of a and b are numbered in reverse; ..." */
static const char *reasons_joined(const reason reasons[], size_t n, const char *last)
{
    const char **names = cli_alloc(n + 1, sizeof *names), *text = NULL;
    size_t i, k;

    for (i = 0; i < n; i++) {
        size_t n_names = 0;

        for (k = 0; k < n; k++) {
            if (is_alike(&reasons[i], &reasons[k])) {
                if (k < i) {
                    break;
                }
                names[n_names++] = reasons[k].name;
            }
        }
        if (n_names > 0) {
            text = cli_text("%s%s%s%s%s", text != NULL ? text : "",
                            text != NULL ? "; " : "", reasons[i].before,
                            names_joined(names, n_names, last), reasons[i].after);
        }
    }
    cli_free(names);
    return text;
}

static void find_wrong_views(calibration *c, const wrong_views *w)
{
    const char *frame = view_frame_name(c, w->v);
    const char *names = names_joined(w->name, w->n, " and ");
    const char *several = w->n > 1 ? "s" : "";
    const char *why = w->n_reasons > 0 ? reasons_joined(w->reasons, w->n_reasons,
                                                        w->is_one_of_two ? " or " : " and ")
                                       : "why is not known";
    const char *what;
    finding *f;

    if (!w->is_one_of_two) {
        what = cli_text("frame %s: camera%s %s contradict%s the others and %s left out: %s",
                        frame, several, names, w->n > 1 ? "" : "s", w->n > 1 ? "are" : "is",
                        why);
    } else if (w->n == 2) {
        what = cli_text("frame %s: cameras %s contradict each other, one of the two is "
                        "wrong, and both are left out: %s",
                        frame, names, why);
    } else {
        what = cli_text("frame %s: camera%s %s %s left out, no two agree: %s", frame,
                        several, names, w->n > 1 ? "are" : "is", why);
    }
    f = find(c, ABOUT_VIEW, what,
             w->n_reasons > 0
                 ? w->reasons[0].advice
                 : "look at the images: is the camera, the frame and each point right, and "
                   "did the target or a camera move? Correct it, or remove these lines");
    f->cameras = names_with_commas(w->name, w->n);
    f->frames = frame;
}

static void collect_placement(wrong_views *w, calibration *c, size_t first, size_t end,
                              const rigcal_real *const place[])
{
    static size_t n_looked_into;
    size_t i;

    memset(w, 0, sizeof *w);
    for (i = first; i < end; i++) {
        view *v = rig_view(c, i);

        if (!v->is_left_out) {
            continue;
        }
        w->is_one_of_two |= v->verdict == RIGCAL_VIEW_ONE_OF_TWO;
        if (v->is_told || v->is_repeated || c->camera_is_told[v->camera]) {
            w->is_told = 1;
            continue;
        }
        w->v = v;
        if (w->n < sizeof w->name / sizeof w->name[0]) {
            w->name[w->n++] = view_camera_name(c, v);
        }
        if (n_looked_into++ < LOOKED_INTO_MOST) {
            const reason r = find_reason(c, i, place);

            if (r.after != NULL && w->n_reasons < w->n) {
                w->reasons[w->n_reasons++] = r;
            }
        }
    }
}

/* Names the views without a message so far. Views that contradict a view with a message are
 * not named. */
static void find_wrong_placements(calibration *c)
{
    const rigcal_real **place = points_in_rig(c);
    size_t first, end;

    for (first = 0; first < c->rig.n_views; first = end) {
        wrong_views w;

        for (end = first; end < c->rig.n_views &&
                          rig_view(c, end)->placement == rig_view(c, first)->placement;
             end++) {
        }
        collect_placement(&w, c, first, end, place);
        if (w.n > 0 && !(w.is_told && w.is_one_of_two)) {
            find_wrong_views(c, &w);
        }
    }
    cli_free(place);
}

/* ==== a camera ============================================================ */

/* Why most views of the rig's camera contradict the others. The first view, of those with
 * most points, gives the symmetries. If there is no rig, it is not known how much more than
 * noise right views differ. Then `scales` limits are tried, each four times the one
 * before. */
static reason find_camera_reason(calibration *c, size_t camera, int scales)
{
    rigcal_judgement judgement = c->judgement;
    const view *most = NULL;
    const symmetries *by;
    rigcal_view seen;
    reason r = NOTHING;
    rigcal_cause cause;
    rig_part part;
    size_t i;
    int k;

    for (i = 0; i < c->rig.n_views; i++) {
        const view *v = rig_view(c, i);

        if (v->rig_camera == camera && (most == NULL || v->n > most->n)) {
            most = v;
        }
    }
    if (most == NULL) {
        return r;
    }
    seen = view_points(c, most);
    by = symmetries_of(&seen);
    open_part_of_camera(&part, c, camera);
    for (k = 0; k < scales && r.after == NULL; k++) {
        if (rigcal_camera_cause(&cause, &part.rig, &judgement, &by->of, camera) ==
            RIGCAL_OK) {
            tell_cause(&r, c, &cause, by, rig_camera_name(c, camera), 0);
        }
        judgement.scale *= 4;
    }
    close_part(&part);
    return r;
}

/* Tells whether the camera's views fit much worse by themselves than the views of the other
 * cameras. */
static void tell_intrinsics(reason *r, const calibration *c, size_t camera)
{
    const double noise = camera_noise(c, c->camera[camera]);
    double least = 0;
    size_t i;

    for (i = 0; i < c->rig.n_cameras; i++) {
        const double other = i == camera ? 0 : camera_noise(c, c->camera[i]);

        least = other > 0 && (other < least || least <= 0) ? other : least;
    }
    if (least > 0 && noise > 2 * least) {
        set_reason(r, "", "",
                   cli_text("its intrinsics are wrong, its views fit by themselves to %.3g "
                            "px, those of other cameras to %.3g px",
                            noise, least),
                   "check its line of cameras.csv, or calibrate its lens again: focal "
                   "lengths, centre, distortion, image size");
    }
}

/* Tells what is wrong with a camera if most of its views are left out. */
static void find_wrong_camera(calibration *c, size_t camera, size_t n_out, size_t n)
{
    const char *name = rig_camera_name(c, camera);
    reason r = find_camera_reason(c, camera, 1);

    if (r.after == NULL) {
        tell_intrinsics(&r, c, camera);
    }
    c->camera_is_told[c->camera[camera]] = 1;
    find(c, ABOUT_CAMERA,
         cli_text("camera %s contradicts the others in %lu of %lu frames, where it is left "
                  "out: %s",
                  name, (unsigned long)n_out, (unsigned long)n,
                  r.after != NULL ? reasons_joined(&r, 1, "") : "why is not known"),
         r.advice != NULL
             ? r.advice
             : "check its intrinsics and the names of its frames. Did it move?")
        ->cameras = name;
}

static void find_wrong_cameras(calibration *c)
{
    size_t *n_out = cli_alloc(c->rig.n_cameras, sizeof *n_out);
    size_t *n = cli_alloc(c->rig.n_cameras, sizeof *n);
    size_t i;

    for (i = 0; i < c->rig.n_views; i++) {
        const view *v = rig_view(c, i);

        n[v->rig_camera] += v->verdict != RIGCAL_VIEW_UNCHECKED;
        n_out[v->rig_camera] += v->verdict == RIGCAL_VIEW_CONTRADICTS;
    }
    for (i = 0; i < c->rig.n_cameras; i++) {
        if (n_out[i] > 1 && 2 * n_out[i] > n[i] && !c->camera_is_told[c->camera[i]]) {
            find_wrong_camera(c, i, n_out[i], n[i]);
        }
    }
    cli_free(n_out);
    cli_free(n);
}

void find_causes(calibration *c)
{
    if (c->n_left_out > 0) {
        c->exit_status = CLI_GEOMETRY;
        find_wrong_cameras(c);
        find_wrong_placements(c);
    }
}

/* ==== no rig ============================================================== */

/* The rig of two cameras is then the other camera alone. Its views give the placements of
 * the target. */
static void place_nowhere(calibration *c, uint8_t left_out[])
{
    size_t i;

    memset(left_out, 1, c->rig.n_views);
    c->rig.left_out = left_out;

    for (i = 0; i < c->rig.n_cameras; i++) {
        c->rig.cams_from_rig[i] = IDENTITY;
    }
    for (i = 0; i < c->rig.n_placements; i++) {
        c->rig.rig_from_placements[i] = IDENTITY;
    }
}

static double noise_of_rig(const calibration *c)
{
    double sum = 0, n = 0;
    size_t i;

    if (c->choice.sigma_px > 0) {
        return (double)c->choice.sigma_px;
    }
    for (i = 0; i < c->rig.n_views; i++) {
        const rigcal_view_pose pose = pose_in_rig(c, i);

        sum += (double)pose.sse;
        n += 2 * (double)pose.n - 6;
    }
    return c->pose.sigma_px > 0 ? (double)c->pose.sigma_px : sqrt(sum / fmax(n, 1)) + 1e-9;
}

/* Of two cameras, each is tested as a whole. If there are more, nothing says where the
 * others are. */
void find_contradiction(calibration *c)
{
    uint8_t *left_out = cli_alloc(c->rig.n_views, sizeof *left_out);
    reason reasons[2];
    const char *why;
    size_t i, n = 0;

    c->judgement.sigma_px = (rigcal_real)noise_of_rig(c);
    for (i = 0; i < c->rig.n_cameras && c->rig.n_cameras == 2; i++) {
        place_nowhere(c, left_out);
        c->judgement.scale = 1;
        reasons[n] = find_camera_reason(c, i, 4);
        n += reasons[n].after != NULL;
    }
    c->rig.left_out = NULL;
    why = reasons_joined(reasons, n, " or ");
    find(c, ABOUT_RIG,
         cli_text("there is no rig: most views contradict each other%s%s",
                  why != NULL ? ": " : "", why != NULL ? why : ""),
         why != NULL ? reasons[0].advice
                     : "check which image is of which camera and frame, the target's "
                       "coordinates, and the intrinsics");
}
