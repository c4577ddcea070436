#include "firmware.h"
#include "line.h"
#include "watch.h"

#include <string.h>

enum { WAITING = 0, SOLVING, JOINING, ADJUSTING, WATCHING, ERASING, PROGRAMMING };

#define R(x) ((rigcal_real)(x))

/* Noise of a corner [px]. A camera is stored anew if it moved by more than five times the
 * standard deviation that this noise gives a pose. */
#define SIGMA_PX R(FIRMWARE_SIGMA_PX)
#define MOVED_DISTANCE R(0.01)
#define MOVED_ANGLE R(0.01)

/* clang-format off */
const rigcal_real FIRMWARE_TARGET[FIRMWARE_POINTS][3] = {
    {R(-0.30), R( 0.20), R( 0.00)}, {R( 0.30), R( 0.20), R( 0.00)},
    {R( 0.30), R(-0.20), R( 0.00)}, {R(-0.30), R(-0.20), R( 0.00)},
    {R(-0.12), R( 0.05), R( 0.10)}, {R( 0.15), R( 0.02), R( 0.15)},
    {R( 0.04), R(-0.14), R( 0.08)}, {R(-0.02), R( 0.15), R( 0.20)}};

const rigcal_camera FIRMWARE_INTRINSICS[FIRMWARE_CAMERAS] = {
    {RIGCAL_LENS_BROWN, 640, 480, R(600), R(601), R(321.5), R(238.25),
     R(-0.12), R(0.03), R(0.0004), R(-0.0003), 0, 0, 0, 0},
    {RIGCAL_LENS_BROWN, 640, 480, R(598), R(597), R(317.0), R(241.5),
     R(-0.11), R(0.025), 0, R(0.0005), 0, 0, 0, 0}};
/* clang-format on */

/* Three points may have several poses, and leave no error to judge them by. */
enum { POINTS_LEAST = 4 };

/* ---- what is sent ------------------------------------------------------------ */

static void begin_frame_line(line *out, const firmware *f, const char *what,
                             rigcal_status status)
{
    out->n = 0;
    put_text(out, what);
    put_count(out, " camera=", (uint32_t)f->camera);
    put_count(out, " frame=", f->frame);
    put_status(out, status);
}

static void report_failure(const firmware *f, rigcal_status status)
{
    line out;
    begin_frame_line(&out, f, "none", status);
    send_line(&out);
}

static void report_pose(const firmware *f, rigcal_status status, const rigcal_pose *found,
                        const rigcal_pose_uncertainty *sigma)
{
    line out;
    rigcal_real center[3], w[3];
    begin_frame_line(&out, f, "pose", status);
    if (rigcal_camera_center(center, &found->cam_from_world) == RIGCAL_OK &&
        rigcal_vector_from_rotation(w, found->cam_from_world.R) == RIGCAL_OK) {
        put_vector(&out, " center=", center);
        put_vector(&out, " turn=", w);
        put_vector(&out, " +-center=", sigma->center);
        put_vector(&out, " +-turn=", sigma->rotation);
    }
    put_text(&out, " rms=");
    put_micro(&out, found->rms_px);
    put_count(&out, " ticks=", (uint32_t)f->ticks);
    send_line(&out);
}

static void report_slot(const char *what, int32_t slot, uint32_t sequence)
{
    line out = {{0}, 0};
    put_text(&out, what);
    put_count(&out, " slot=", (uint32_t)slot);
    put_count(&out, " sequence=", sequence);
    send_line(&out);
}

/* ---- the calibration in flash ---------------------------------------------- */

/* Reads a slot into f. Returns whether it holds a calibration of this machine. */
static int load_slot(firmware *f, int32_t slot, uint32_t *sequence)
{
    firmware_watch *const w = &f->watch;
    rigcal_saved_info info;
    watch_clear(w);
    if (rigcal_store_load_rig(&w->rig, &info, port_flash(slot), PORT_SLOT_BYTES) !=
            RIGCAL_OK ||
        info.n_cameras != FIRMWARE_CAMERAS || info.tag != FIRMWARE_SERIAL) {
        watch_clear(w);
        return 0;
    }
    for (int i = 0; i < FIRMWARE_CAMERAS; i++) {
        f->cameras[i] = w->cameras[i];
        f->stored[i] = w->cameras[i].cam_from_rig;
        f->is_known[i] = 1;
    }
    *sequence = info.sequence;
    return 1;
}

/* Loads the newer of two valid slots. A number that wrapped round to 0 is newer. */
static void load_newest(firmware *f)
{
    uint32_t sequence[PORT_SLOTS];
    const int has_first = load_slot(f, 0, &sequence[0]);
    const int has_second = load_slot(f, 1, &sequence[1]);
    if (has_first && has_second) {
        f->slot = ((int32_t)(sequence[1] - sequence[0]) > 0) ? 1 : 0;
    } else {
        f->slot = has_first ? 0 : has_second ? 1 : -1;
    }
    if (f->slot >= 0) {
        (void)load_slot(f, f->slot, &sequence[f->slot]);
    }
    f->sequence = (f->slot >= 0) ? sequence[f->slot] : 0;
}

static int has_moved(const rigcal_transform *now, const rigcal_transform *stored)
{
    rigcal_real angle, a[3], b[3], square = 0;
    if (rigcal_rotation_angle(&angle, now->R, stored->R) != RIGCAL_OK ||
        rigcal_camera_center(a, now) != RIGCAL_OK ||
        rigcal_camera_center(b, stored) != RIGCAL_OK) {
        return 1;
    }
    for (int i = 0; i < 3; i++) {
        square += (a[i] - b[i]) * (a[i] - b[i]);
    }
    return angle > MOVED_ANGLE || square > MOVED_DISTANCE * MOVED_DISTANCE;
}

/* Whether every camera has a new pose that differs from the one in flash. If a single new
 * pose were enough, a bump of the whole rig would be saved once for each camera. */
static int wants_saving(const firmware *f)
{
    int moved = f->slot < 0;
    for (int i = 0; i < FIRMWARE_CAMERAS; i++) {
        if (!f->is_fresh[i]) {
            return 0;
        }
        moved = moved || has_moved(&f->cameras[i].cam_from_rig, &f->stored[i]);
    }
    return moved && f->tries_left > 0;
}

/* The slot that is not in use. Whatever happens to it, the other one is left. */
static int32_t spare_slot(const firmware *f)
{
    return (f->slot == 0) ? 1 : 0;
}

static void save_failed(firmware *f)
{
    f->tries_left--;
    f->state = WAITING;
    report_slot("failed", spare_slot(f), f->sequence + 1);
}

static void begin_saving(firmware *f)
{
    memset(f->is_fresh, 0, sizeof f->is_fresh);
    memset(f->image, 0xff, sizeof f->image);
    const rigcal_calibrated_rig *const rig = &f->watch.rig;
    const rigcal_status status =
        rig->sigma_px > 0
            ? rigcal_store_save_rig(f->image, sizeof f->image, &f->image_bytes, rig,
                                    f->sequence + 1, FIRMWARE_SERIAL)
            : rigcal_store_save(f->image, sizeof f->image, &f->image_bytes, f->cameras,
                                FIRMWARE_CAMERAS, f->sequence + 1, FIRMWARE_SERIAL);
    if (status != RIGCAL_OK) {
        save_failed(f);
        return;
    }
    f->written = 0;
    f->state = ERASING;
}

static void erase(firmware *f)
{
    if (port_flash_erase(spare_slot(f))) {
        f->state = PROGRAMMING;
    } else {
        save_failed(f);
    }
}

static void finish_saving(firmware *f)
{
    const int32_t slot = spare_slot(f);
    if (memcmp(port_flash(slot), f->image, f->image_bytes) != 0) {
        save_failed(f);
        return;
    }
    f->slot = slot;
    f->sequence++;
    for (int i = 0; i < FIRMWARE_CAMERAS; i++) {
        f->stored[i] = f->cameras[i].cam_from_rig;
    }
    f->tries_left = FIRMWARE_SAVE_TRIES;
    f->state = WAITING;
    report_slot("saved", f->slot, f->sequence);
}

/* Programs one page in each tick: the flash needs about that time for a page. */
static void program(firmware *f)
{
    if (!port_flash_program(spare_slot(f), f->written, f->image + f->written)) {
        save_failed(f);
        return;
    }
    f->written += PORT_PAGE_BYTES;
    if (f->written >= f->image_bytes) {
        finish_saving(f);
    }
}

/* ---- a frame ---------------------------------------------------------------- */

/* The detections of known points, each point once. Returns their number. */
static size_t observe(rigcal_observation seen[FIRMWARE_POINTS], const port_frame *frame)
{
    int was_seen[FIRMWARE_POINTS] = {0};
    size_t n = 0;
    for (int k = 0; k < frame->n && k < PORT_CORNERS_MAX; k++) {
        const int32_t id = frame->id[k];
        if (id < 0 || id >= FIRMWARE_POINTS || was_seen[id]) {
            continue;
        }
        was_seen[id] = 1;
        for (int i = 0; i < 3; i++) {
            seen[n].X_w[i] = FIRMWARE_TARGET[id][i];
        }
        for (int i = 0; i < 2; i++) {
            seen[n].uv[i] = (rigcal_real)frame->uv[k][i];
        }
        n++;
    }
    return n;
}

static void take_frame(firmware *f)
{
    port_frame frame;
    rigcal_pose_options options;
    if (!port_take_frame(&frame) || frame.camera < 0 || frame.camera >= FIRMWARE_CAMERAS ||
        frame.placement < PORT_AT_WORK || frame.placement > FIRMWARE_PLACEMENTS) {
        return;
    }
    f->camera = frame.camera;
    f->placement = frame.placement;
    f->frame++;
    f->ticks = 0;
    const rigcal_mounted_camera *const mounted = &f->cameras[f->camera];
    f->view.camera = &mounted->camera;
    f->view.observations = f->seen;
    f->view.sigma = NULL;
    f->view.n = observe(f->seen, &frame);
    if (f->view.n < POINTS_LEAST) {
        report_failure(f, RIGCAL_ERR_TOO_FEW);
        return;
    }
    if (f->placement == PORT_AT_WORK) {
        f->state = WATCHING;
        return;
    }
    rigcal_status status = rigcal_pose_defaults(&options);
    options.sigma_px = SIGMA_PX;
    if (f->is_known[f->camera] && f->placement == 0) {
        options.use_start = 1;
        options.start = mounted->cam_from_rig;
    }
    if (status == RIGCAL_OK) {
        status = rigcal_pose_begin(&f->solver, NULL, &f->view, &options);
    }
    if (status == RIGCAL_OK) {
        f->state = SOLVING;
    } else {
        report_failure(f, status);
    }
}

/* ---- the rig ---------------------------------------------------------------- */

static void report_rig_failure(firmware *f, const char *what, rigcal_status status)
{
    line out = {{0}, 0};
    f->state = WAITING;
    put_text(&out, what);
    put_status(&out, status);
    send_line(&out);
}

/* Reports where the first point of the last placement is, from both cameras, and the line
 * in camera 1 on which it must be by camera 0. */
static void report_measured(const firmware *f, rigcal_real sigma_px)
{
    const firmware_rig *const r = &f->rig;
    const rigcal_rig_view *const a = &r->views[FIRMWARE_VIEWS - 2];
    rigcal_point point;
    rigcal_camera cameras[2];
    rigcal_real uv[4], ray[3], matching[3];
    rigcal_transform b_from_a;
    line out = {{0}, 0};
    for (int c = 0; c < 2; c++) {
        cameras[c] = *a[c].view.camera;
        uv[2 * c] = a[c].view.observations[0].uv[0];
        uv[2 * c + 1] = a[c].view.observations[0].uv[1];
    }
    if (rigcal_point_triangulate(&point, cameras, r->cams_from_rig, uv, 2, sigma_px) !=
            RIGCAL_OK ||
        rigcal_transform_between(&b_from_a, &r->cams_from_rig[1], &r->cams_from_rig[0]) !=
            RIGCAL_OK ||
        rigcal_camera_ray(ray, &cameras[0], uv) != RIGCAL_OK ||
        rigcal_epiline_px(matching, &cameras[1], &b_from_a, ray) != RIGCAL_OK) {
        return;
    }
    put_vector(&out, "point at=", point.X);
    put_text(&out, " rms=");
    put_micro(&out, point.rms_px);
    send_line(&out);
    out.n = 0;
    put_vector(&out, "line camera=1 abc=", matching);
    send_line(&out);
}

/* Gives camera 1 its pose and covariance by the rig, and writes both to flash. */
static void finish_rig(firmware *f)
{
    firmware_rig *const r = &f->rig;
    rigcal_rig_fit fit;
    rigcal_transform pair;
    rigcal_real Sigma[36];
    line out = {{0}, 0};
    f->state = WAITING;
    r->n_views = 0;
    rigcal_status status = rigcal_rig_result(&fit, NULL, &r->solver);
    if (status == RIGCAL_OK) {
        status = rigcal_rig_pair(&pair, Sigma, &r->rig, SIGMA_PX, 0, 1);
    }
    if (status == RIGCAL_OK) {
        watch_clear(&f->watch);
        status = rigcal_calibrated_take(&f->watch.rig, &r->rig, &fit, SIGMA_PX);
    }
    if (status != RIGCAL_OK) {
        report_rig_failure(f, "no rig", status);
        return;
    }
    for (int c = 0; c < FIRMWARE_CAMERAS; c++) {
        f->watch.cameras[c].camera = f->cameras[c].camera;
        f->cameras[c] = f->watch.cameras[c];
        f->is_known[c] = f->is_fresh[c] = 1;
    }
    const rigcal_real mm2[3] = {R(1e6) * Sigma[21], R(1e6) * Sigma[28], R(1e6) * Sigma[35]};
    put_vector(&out, "rig t=", pair.t);
    put_vector(&out, " variance_mm2=", mm2);
    put_text(&out, " sigma=");
    put_micro(&out, fit.sigma_px);
    put_count(&out, " ticks=", (uint32_t)r->ticks);
    send_line(&out);
    report_measured(f, SIGMA_PX);
    if (f->tries_left > 0) {
        begin_saving(f);
    }
}

static void join(firmware *f)
{
    rigcal_rig_fit fit;
    firmware_rig *const r = &f->rig;
    r->ticks++;
    rigcal_status status = rigcal_rig_join_step(&r->solver, FIRMWARE_UNITS_PER_TICK);
    if (status == RIGCAL_RUNNING) {
        return;
    }
    status = rigcal_rig_result(&fit, NULL, &r->solver);
    if (status == RIGCAL_OK) {
        status = rigcal_rig_begin(&r->solver, &r->rig);
    }
    if (status == RIGCAL_OK) {
        f->state = ADJUSTING;
    } else {
        report_rig_failure(f, "no rig", status);
    }
}

static void adjust(firmware *f)
{
    f->rig.ticks++;
    const rigcal_status status = rigcal_rig_step(&f->rig.solver, FIRMWARE_UNITS_PER_TICK);
    if (status == RIGCAL_OK) {
        finish_rig(f);
    } else if (status != RIGCAL_RUNNING) {
        report_rig_failure(f, "no rig", status);
    }
}

/* Joins the poses of all views. The adjustment starts from the result. */
static void begin_rig(firmware *f)
{
    static const uint8_t ROLES[FIRMWARE_CAMERAS] = {RIGCAL_CAMERA_HELD, RIGCAL_CAMERA_FREE};
    firmware_rig *const r = &f->rig;
    rigcal_rig rig = {0};
    rig.cams_from_rig = r->cams_from_rig;
    rig.n_cameras = FIRMWARE_CAMERAS;
    rig.rig_from_placements = r->rig_from_placements;
    rig.n_placements = FIRMWARE_PLACEMENTS;
    rig.group = r->group;
    rig.n_views = FIRMWARE_VIEWS;
    rig.views = r->views;
    rig.view_poses = r->poses;
    rig.roles = ROLES;
    rig.work = r->work;
    rig.work_capacity = sizeof r->work / sizeof r->work[0];
    r->rig = rig;
    r->ticks = 0;
    r->cams_from_rig[0] = f->cameras[0].cam_from_rig;
    for (int i = 0; i < 9 && !f->is_known[0]; i++) {
        r->cams_from_rig[0].R[i] = (i % 4 == 0) ? 1 : 0;
    }
    const rigcal_status status = rigcal_rig_join_begin(&r->solver, &r->rig);
    if (status == RIGCAL_OK) {
        f->state = JOINING;
    } else {
        r->n_views = 0;
        report_rig_failure(f, "no rig", status);
    }
}

/* Keeps a view of the board. Placements come one after the other, camera 0 before camera
 * 1. */
static void keep_view(firmware *f, const rigcal_transform *cam_from_target)
{
    firmware_rig *const r = &f->rig;
    const int32_t k = FIRMWARE_CAMERAS * (f->placement - 1) + f->camera;
    if (k != r->n_views) { /* a view is missing: starts again from the first placement */
        r->n_views = 0;
        if (k != 0) {
            return;
        }
    }
    rigcal_rig_view *const v = &r->views[k];
    memcpy(r->seen[k], f->seen, sizeof f->seen);
    v->view = f->view;
    v->view.observations = r->seen[k];
    v->camera = f->camera;
    v->placement = f->placement - 1;
    v->target = 0;
    if (rigcal_view_pose_make(&r->poses[k], v, cam_from_target) != RIGCAL_OK) {
        r->n_views = 0;
        return;
    }
    r->n_views = k + 1;
    if (r->n_views == FIRMWARE_VIEWS) {
        begin_rig(f);
    }
}

/* Replaces the earlier pose only by one that is certain. */
static void finish_frame(firmware *f)
{
    rigcal_pose poses[RIGCAL_POSES_MAX];
    rigcal_pose_uncertainty sigma;
    size_t n_found;
    rigcal_mounted_camera *const mounted = &f->cameras[f->camera];
    f->state = WAITING;
    const rigcal_status status =
        rigcal_pose_result(poses, RIGCAL_POSES_MAX, &n_found, NULL, &f->solver);
    if (status < 0) {
        report_failure(f, status);
        return;
    }
    const rigcal_status covariance =
        rigcal_pose_covariance(&sigma, &f->view, &poses[0].cam_from_world, SIGMA_PX);
    if (covariance != RIGCAL_OK) {
        report_failure(f, covariance);
        return;
    }
    report_pose(f, status, &poses[0], &sigma);
    if (status != RIGCAL_OK) {
        return;
    }
    if (f->placement > 0) {
        keep_view(f, &poses[0].cam_from_world);
        return;
    }
    mounted->cam_from_rig = poses[0].cam_from_world;
    memcpy(mounted->Sigma, sigma.Sigma, sizeof mounted->Sigma);
    mounted->has_Sigma = 1;
    f->is_known[f->camera] = 1;
    f->is_fresh[f->camera] = 1;
    if (wants_saving(f)) {
        watch_clear(&f->watch); /* poses that were found one by one have no joint
                                   covariance */
        begin_saving(f);
    }
}

/* ---- at work ------------------------------------------------------------------ */

/* Takes a view at work. A rig that moved far enough since it was stored is stored again. */
static void watch(firmware *f)
{
    const firmware_watch *const w = &f->watch;
    f->state = WAITING;
    if (!watch_view(&f->watch, f->camera, &f->view)) {
        return;
    }
    int moved = 0;
    for (int c = 0; c < FIRMWARE_CAMERAS; c++) {
        f->cameras[c] = w->cameras[c];
        moved = moved || has_moved(&f->cameras[c].cam_from_rig, &f->stored[c]);
    }
    if (moved && f->tries_left > 0) {
        begin_saving(f);
    }
}

static void solve(firmware *f)
{
    f->ticks++;
    const rigcal_status status = rigcal_pose_step(&f->solver, FIRMWARE_EVALS_PER_TICK);
    if (status == RIGCAL_OK) {
        finish_frame(f);
    } else if (status != RIGCAL_RUNNING) {
        f->state = WAITING;
        report_failure(f, status);
    }
}

/* ---- the superloop ----------------------------------------------------------- */

void firmware_boot(firmware *f)
{
    line out = {{0}, 0};
    memset(f, 0, sizeof *f);
    for (int i = 0; i < FIRMWARE_CAMERAS; i++) {
        f->cameras[i].camera = FIRMWARE_INTRINSICS[i];
    }
    f->tries_left = FIRMWARE_SAVE_TRIES;
    f->state = WAITING;
    load_newest(f);
    if (f->slot >= 0) {
        report_slot("loaded", f->slot, f->sequence);
    } else {
        put_text(&out, "uncalibrated");
        send_line(&out);
    }
    port_feed_watchdog();
}

/* Listens for "how are you?" at the end of a line. */
static void listen(firmware *f)
{
    static const char QUESTION[] = "how are you?";
    for (int c = port_receive(); c >= 0; c = port_receive()) {
        if (c == '\r' || c == '\n') {
            if (f->n_heard == sizeof QUESTION - 1) {
                watch_answer(&f->watch);
            }
            f->n_heard = 0;
        } else {
            const int fits = f->n_heard < sizeof QUESTION - 1 && c == QUESTION[f->n_heard];
            f->n_heard = fits ? f->n_heard + 1 : sizeof QUESTION; /* one more than fits */
        }
    }
}

void firmware_tick(firmware *f)
{
    listen(f);
    switch (f->state) {
    case SOLVING:
        solve(f);
        break;
    case JOINING:
        join(f);
        break;
    case ADJUSTING:
        adjust(f);
        break;
    case WATCHING:
        watch(f);
        break;
    case ERASING:
        erase(f);
        break;
    case PROGRAMMING:
        program(f);
        break;
    default:
        take_frame(f);
        break;
    }
    port_feed_watchdog();
}
