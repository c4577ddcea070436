/* The monitor, with any calibrated rig and any sequence of calls. */
#include <math.h>
#include <string.h>

#include "fuzz.h"

enum {
    CAMERAS_MOST = 3,
    TARGETS_MOST = 2,
    POINTS_MOST = 6,
    SIZE = RIGCAL_MONITOR_SIZE(CAMERAS_MOST, TARGETS_MOST),
    CALLS_MOST = 200
};

typedef struct {
    rigcal_mounted_camera cameras[CAMERAS_MOST];
    int32_t group[CAMERAS_MOST];
    uint8_t held[CAMERAS_MOST];
    rigcal_real Sigma[RIGCAL_CALIBRATED_SIZE(CAMERAS_MOST)];
    rigcal_calibrated_rig rig;
} calibrated;

static void open_rig(calibrated *c)
{
    memset(c, 0, sizeof *c);
    c->rig.cameras = c->cameras;
    c->rig.group = c->group;
    c->rig.held = c->held;
    c->rig.capacity = CAMERAS_MOST;
    c->rig.Sigma = c->Sigma;
    c->rig.Sigma_capacity = RIGCAL_CALIBRATED_SIZE(CAMERAS_MOST);
}

static void read_rig(calibrated *c, size_t n, fuzz_bytes *bytes)
{
    rigcal_real variance;
    size_t i;

    open_rig(c);
    c->rig.n_cameras = n;
    c->held[0] = 1;
    for (i = 0; i < n; i++) {
        fuzz_camera(&c->cameras[i].camera, bytes);
        fuzz_transform(&c->cameras[i].cam_from_rig, bytes);
    }
    variance = fuzz_real(bytes);
    for (i = 0; i < 6 * (n - 1); i++) {
        c->Sigma[i * (i + 1) / 2 + i] = variance;
    }
    c->rig.sigma_px = fuzz_real(bytes);
}

/* A copy of the memory: a call that failed must change nothing. */
static rigcal_real saved[SIZE];

static void check_call(rigcal_status status, const rigcal_real monitor[])
{
    PROMISE(fuzz_is_status(status) && status != RIGCAL_RUNNING);
    PROMISE(status >= 0 || memcmp(saved, monitor, sizeof saved) == 0);
}

static rigcal_status see_target(rigcal_real monitor[], size_t camera, fuzz_bytes *bytes)
{
    rigcal_observation observations[POINTS_MOST];
    const size_t n = (size_t)fuzz_below(bytes, POINTS_MOST + 1);
    const size_t target = (size_t)fuzz_below(bytes, TARGETS_MOST + 1);
    int32_t at_fault;
    size_t i;
    rigcal_status status;

    for (i = 0; i < n; i++) {
        fuzz_reals(observations[i].X_w, 3, bytes);
        fuzz_reals(observations[i].uv, 2, bytes);
    }
    status = rigcal_monitor_view(monitor, &at_fault, camera, target, observations, n,
                                 fuzz_real(bytes));
    PROMISE(at_fault >= -1 && (at_fault < 0 || (size_t)at_fault < n));
    return status;
}

/* 1: the memory was altered between two frames, which the calls of that frame may not
 * notice. */
static int is_altered;

static rigcal_status end_frame(rigcal_real monitor[], fuzz_bytes *bytes)
{
    rigcal_monitor_report report, asked;
    const rigcal_status status = rigcal_monitor_frame(&report, monitor, fuzz_real(bytes));

    if (status >= 0 && !is_altered) {
        PROMISE(rigcal_monitor_ask(&asked, monitor) == RIGCAL_OK);
        PROMISE(asked.alarm == report.alarm && asked.body == report.body);
        PROMISE(asked.rows == report.rows && asked.frames == report.frames);
        PROMISE(memcmp(&asked.evidence, &report.evidence, sizeof asked.evidence) == 0);
        PROMISE(report.alarm == 0 || report.alarm == 1);
        PROMISE(report.confidence >= 0 && report.confidence <= 1);
        PROMISE(fuzz_all_finite(&report.evidence, 1) && report.noise >= 0);
        PROMISE(report.doubted <= report.rows);
    }
    return status;
}

/* Whether a transform is as rigid as the input, which may be wrong by 1e-6 (float:
 * 1e-3). */
static int is_rigid(const rigcal_transform *b_from_a)
{
    return fuzz_is_rotation(b_from_a->R, FUZZ_TOL(1e-5, 1e-2)) &&
           fuzz_all_finite(b_from_a->t, 3);
}

static void check_bodies(const rigcal_real monitor[], size_t n_cameras, size_t n_targets)
{
    rigcal_body_report report;
    rigcal_transform b_from_a;
    rigcal_mounted_camera camera;
    rigcal_real Sigma[36];
    rigcal_status status;
    calibrated kept;
    size_t i;

    for (i = 0; i < n_cameras + n_targets; i++) {
        PROMISE(rigcal_monitor_body(&report, monitor, i) == RIGCAL_OK);
        PROMISE(fuzz_all_finite(report.weakest, 6) && report.weakest_sigma >= 0);
        PROMISE(report.share >= 0 && report.share <= 1);
        PROMISE(report.blame >= 0 && report.blame <= 1);
        status = rigcal_monitor_pair(&b_from_a, Sigma, monitor, 0, i);
        PROMISE(status == RIGCAL_OK || (i >= n_cameras && status == RIGCAL_ERR_RANGE));
        if (status == RIGCAL_OK) {
            PROMISE(is_rigid(&b_from_a));
            PROMISE(fuzz_is_covariance(Sigma, 6, FUZZ_TOL(1e-6, 1e-2)));
        }
        if (i < n_cameras) {
            PROMISE(rigcal_monitor_camera(&camera, monitor, i) == RIGCAL_OK);
            PROMISE(is_rigid(&camera.cam_from_rig));
            PROMISE(fuzz_is_covariance(camera.Sigma, 6, FUZZ_TOL(1e-6, 1e-2)));
        }
    }
    open_rig(&kept);
    PROMISE(rigcal_monitor_rig(&kept.rig, monitor) == RIGCAL_OK);
    PROMISE(kept.rig.n_cameras == n_cameras);
}

static rigcal_status one_call(rigcal_real monitor[], size_t n_cameras, fuzz_bytes *bytes)
{
    const int kind = fuzz_below(bytes, 9);
    size_t a, b;
    rigcal_real x[6];

    switch (kind) {
    case 0:
    case 1:
        a = (size_t)fuzz_below(bytes, (int32_t)n_cameras + 1);
        b = (size_t)fuzz_below(bytes, (int32_t)n_cameras + 1);
        fuzz_reals(x, kind == 0 ? 4 : 6, bytes);
        return kind == 0
                   ? rigcal_monitor_match(monitor, a, x, b, x + 2, fuzz_real(bytes))
                   : rigcal_monitor_match_rays(monitor, a, x, b, x + 3, fuzz_real(bytes));
    case 2:
    case 3:
        return end_frame(monitor, bytes);
    case 4:
    case 5:
        return see_target(monitor, (size_t)fuzz_below(bytes, 4), bytes);
    case 6:
        return rigcal_monitor_moved(monitor, (size_t)fuzz_below(bytes, 6));
    case 7:
        return rigcal_monitor_dismiss(monitor);
    default:
        return rigcal_monitor_lifted(monitor, (size_t)fuzz_below(bytes, 3));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static rigcal_real monitor[SIZE];
    static calibrated rig;
    fuzz_bytes bytes = {data, data + size};
    const size_t n_cameras = 2 + (size_t)fuzz_below(&bytes, CAMERAS_MOST - 1);
    const size_t n_targets = (size_t)fuzz_below(&bytes, TARGETS_MOST + 1);
    rigcal_monitor_options options;
    rigcal_status status;
    int calls;

    is_altered = 0;
    PROMISE(rigcal_monitor_defaults(&options) == RIGCAL_OK);
    options.arl0_frames = 100;
    options.walk_rad = (rigcal_real)(size % 4 == 3 ? 0.03 : 0);
    options.move_t = (rigcal_real)(size % 8 == 5 ? FUZZ_TOL(1e-170, 1e-30) : 0);
    read_rig(&rig, n_cameras, &bytes);
    MARK(monitor);
    status = rigcal_monitor_begin(monitor, SIZE, &rig.rig, n_targets, &options);
    PROMISE(fuzz_is_status(status));
    if (status != RIGCAL_OK) {
        PROMISE(IS_MARKED(monitor));
        return 0;
    }
    for (calls = 0; calls < CALLS_MOST && !fuzz_is_empty(&bytes); calls++) {
        memcpy(saved, monitor, sizeof saved);
        if (fuzz_below(&bytes, 64) == 63) { /* altered memory must be refused, or do no
                                               harm */
            ((uint8_t *)monitor)[fuzz_word(&bytes) % sizeof monitor] ^= fuzz_byte(&bytes);
            is_altered = 1;
            (void)one_call(monitor, n_cameras, &bytes);
            return 0;
        }
        check_call(one_call(monitor, n_cameras, &bytes), monitor);
    }
    check_bodies(monitor, n_cameras, n_targets);
    return 0;
}
