#include "rc_joint.h"
#include "rc_monitor.h"

#include <string.h>

/* ---- constants ----------------------------------------------------------- */

/* 1: the first word of a head, "rcm1". */
#define MAGIC 0x316d6372u

/* 1: factor of the sums of words. It is odd, so that no changed word is lost. 2^32 over the
 * golden ratio. */
#define SEAL_FACTOR 0x9e3779b9u

/* frames: default of the mean time between false alarms. One day at 12 frames a second. */
#define ARL0_DEFAULT RC(1e6)

/* frames: the least mean time between false alarms. With fewer the windows would not end
 * between alarms. */
#define ARL0_LEAST RC(100)

/* frames: the longest mean time between false alarms. One year at 30 frames a second. */
#define ARL0_MOST RC(1e9)

/* 1: default share by which the rows of a frame err together. Matches of real boards need
 * it: they all lie where the lens model is a little wrong. */
#define COMMON_DEFAULT RC(0.5)

/* part of the matches: default of how many are wrong. */
#define WRONG_DEFAULT RC(0.1)

/* part of the matches: the least that are taken as wrong. With none a bump would drag the
 * poses along until it is noticed. */
#define WRONG_LEAST RC(1e-5)

/* part of the matches: the most that may be wrong. With more, matches carry no
 * information. */
#define WRONG_MOST RC(0.9)

/* rad: default of the largest move, 3 degrees. After such a move one frame of rows brings
 * the pose back. */
#define MOVE_DEFAULT RC(0.0523598776)

/* rad: the most that the largest move may be. Beyond it the pose must be solved anew. */
#define MOVE_MOST RC(0.5)

/* rad per square root of a second: the fastest random walk. A rig that moves more is not
 * calibrated. */
#define WALK_MOST RC(1)

/* px: least noise. With it the weight of a row stays within float. */
#define NOISE_LEAST RC(1e-6)

/* px: largest noise, the size of the largest image. */
#define NOISE_MOST RC(1e6)

/* part of a correlation: rounding may bring it above 1 by this. */
#define CORRELATION_ROUNDING RC_TOL(1e-9, 1e-5)

/* ---- memory ---------------------------------------------------------------- */

size_t rigcal_monitor_size(size_t n_cameras, size_t n_targets)
{
    const int is_right = n_cameras >= 2 && n_cameras <= RIGCAL_MONITOR_CAMERAS_MAX &&
                         n_targets <= RIGCAL_MONITOR_TARGETS_MAX;
    return is_right ? RIGCAL_MONITOR_SIZE(n_cameras, n_targets) : 0;
}

/* Compile-time checks that the public macros have room for the structs. */
typedef char rc_monitor_head_fits
    [sizeof(rc_monitor_copy) == RIGCAL_MONITOR_HEAD * sizeof(rigcal_real) ? 1 : -1];
typedef char rc_monitor_rows_fit[offsetof(rc_monitor_head, magic) <= sizeof(rc_monitor_part)
                                     ? 1
                                     : -1];
typedef char rc_monitor_body_fits[RC_ALARM_BODY + 12 == RIGCAL_MONITOR_BODY ? 1 : -1];
typedef char rc_monitor_lens_fits
    [sizeof(rc_monitor_lens_copy) == RIGCAL_MONITOR_LENS * sizeof(rigcal_real) ? 1 : -1];
typedef char rc_monitor_trial_fits[(int)RC_TRIAL_SIZE <= (int)RC_ALARM_WINDOW ? 1 : -1];

/* Two sums of words, which take the words in turn. Each sum is multiplied before a word is
 * added, so exchanged words change it too. */
static void sum_words(uint32_t seal[2], const void *from, size_t n_bytes)
{
    const unsigned char *at = (const unsigned char *)from;
    uint32_t a = MAGIC, b = 0, w, x, y, z;
    for (; n_bytes >= 16; n_bytes -= 16, at += 16) {
        memcpy(&w, at, sizeof w);
        memcpy(&x, at + 4, sizeof x);
        memcpy(&y, at + 8, sizeof y);
        memcpy(&z, at + 12, sizeof z);
        a = (a * SEAL_FACTOR + w) * SEAL_FACTOR + y;
        b = (b * SEAL_FACTOR + x) * SEAL_FACTOR + z;
    }
    for (; n_bytes >= sizeof w; n_bytes -= sizeof w, at += sizeof w) {
        memcpy(&w, at, sizeof w);
        a = a * SEAL_FACTOR + w;
    }
    seal[0] = a | 1; /* never 0 */
    seal[1] = a ^ b;
}

static void sum_head(uint32_t seal[2], const rc_monitor_head *head)
{
    const size_t from = offsetof(rc_monitor_head, magic);
    sum_words(seal, (const unsigned char *)head + from, sizeof *head - from);
}

static void sum_all(uint32_t seal[2], const rc_monitor *m)
{
    const size_t from = offsetof(rc_monitor_head, rows);
    const size_t n_bytes = m->size * sizeof(rigcal_real) - from;
    sum_words(seal, (const unsigned char *)m->memory + from, n_bytes);
}

/* Copy the head out of the memory; write its first part back; write all of it back. */
static void copy_out(rc_monitor_part top[RC_MONITOR_PARTS], const rigcal_real memory[])
{
    const rc_monitor_part *const parts = (const rc_monitor_part *)memory;
    top[0] = parts[0];
    top[1] = parts[1];
    top[2] = parts[2];
}

static void copy_first_in(rc_monitor *m)
{
    *(rc_monitor_part *)m->memory = m->top.parts[0];
}

static void copy_in(rc_monitor *m)
{
    rc_monitor_part *const parts = (rc_monitor_part *)m->memory;
    parts[0] = m->top.parts[0];
    parts[1] = m->top.parts[1];
    parts[2] = m->top.parts[2];
}

void rc_monitor_lay_out(rc_monitor *m, rigcal_real memory[])
{
    const rc_monitor_head *const head = &m->top.head;
    rc_filter *const f = &m->filter;
    rigcal_real *at = memory + RIGCAL_MONITOR_HEAD;
    f->n_cameras = head->n_cameras;
    f->n_bodies = f->n_cameras + head->n_targets;
    f->n = 6 * (f->n_bodies - 1);
    f->frame = head->frame;
    f->placed = head->placed;
    f->poses = (rigcal_transform *)at;
    at += 12 * f->n_bodies;
    f->UD = at;
    at += f->n * (f->n + 1) / 2;
    f->d = at;
    f->room = f->d + f->n;
    m->bodies = f->room + f->n;
    m->lenses = m->bodies + RC_ALARM_BODY * f->n_bodies;
    m->memory = memory;
    m->size = rigcal_monitor_size(f->n_cameras, head->n_targets);
}

/* Whether these are the words of a monitor's head. */
static int is_head(const rc_monitor_head *head)
{
    uint32_t seal[2];
    sum_head(seal, head);
    return head->magic == MAGIC && head->head_seal == seal[1] &&
           rigcal_monitor_size(head->n_cameras, head->n_targets) > 0 &&
           head->frame < head->n_cameras &&
           head->alarm.n_bodies == (int32_t)(head->n_cameras + head->n_targets);
}

rigcal_status rc_monitor_open(rc_monitor *m, const rigcal_real memory[])
{
    if (memory == NULL) {
        *m = (rc_monitor){0};
        return RIGCAL_ERR_NULL;
    }
    copy_out(m->top.parts, memory);
    if (!is_head(&m->top.head)) {
        return RIGCAL_ERR_STATE;
    }
    rc_monitor_lay_out(m, (rigcal_real *)memory);
    if ((m->top.head.seal[0] | m->top.head.seal[1]) != 0) {
        uint32_t seal[2];
        sum_all(seal, m);
        if (m->top.head.seal[0] != seal[0] || m->top.head.seal[1] != seal[1]) {
            return RIGCAL_ERR_STATE;
        }
    }
    return RIGCAL_OK;
}

void rc_monitor_close(rc_monitor *m, int is_frame_over)
{
    uint32_t seal[2];
    m->top.head.placed = m->filter.placed;
    sum_head(seal, &m->top.head);
    m->top.head.head_seal = seal[1];
    m->top.head.seal[0] = m->top.head.seal[1] = 0;
    copy_in(m);
    if (is_frame_over) {
        sum_all(m->top.head.seal, m);
        copy_first_in(m);
    }
}

void rc_monitor_close_again(rc_monitor *m)
{
    rc_monitor_close(m, (m->top.head.seal[0] | m->top.head.seal[1]) != 0);
}

const rigcal_camera *rc_monitor_lens(rc_monitor_lens_copy *lens, const rc_monitor *m,
                                     size_t index)
{
    lens->part = *(const rc_monitor_lens_part *)(m->lenses + RIGCAL_MONITOR_LENS * index);
    return &lens->camera;
}

/* ---- begin ------------------------------------------------------------------ */

rigcal_status rigcal_monitor_defaults(rigcal_monitor_options *options)
{
    if (options == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_monitor_options defaults = {
        ARL0_DEFAULT, COMMON_DEFAULT, WRONG_DEFAULT, 0, 0, MOVE_DEFAULT, 0};
    *options = defaults;
    return RIGCAL_OK;
}

static int is_within(rigcal_real x, rigcal_real least, rigcal_real most)
{
    return x >= least && x <= most;
}

static rigcal_status check_options(const rigcal_monitor_options *o)
{
    const rigcal_real numbers[] = {o->arl0_frames, o->common,   o->wrong, o->walk_rad,
                                   o->walk_t,      o->move_rad, o->move_t};
    if (!rc_all_finite(numbers, 7)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    return (is_within(o->arl0_frames, ARL0_LEAST, ARL0_MOST) &&
            is_within(o->common, 0, 1) && is_within(o->wrong, 0, WRONG_MOST) &&
            is_within(o->walk_rad, 0, WALK_MOST) &&
            is_within(o->walk_t, 0, RC_COORDINATE_MAX) && o->move_rad > 0 &&
            o->move_rad <= MOVE_MOST && is_within(o->move_t, 0, RC_COORDINATE_MAX))
               ? RIGCAL_OK
               : RIGCAL_ERR_RANGE;
}

/* Checks the cameras and their covariance. *frame is the first held camera. */
static rigcal_status check_cameras(size_t *frame, const rigcal_calibrated_rig *rig)
{
    size_t n = 0;
    *frame = rig->n_cameras;
    for (size_t c = 0; c < rig->n_cameras; c++) {
        rigcal_status status = rc_check_camera(&rig->cameras[c].camera);
        if (status == RIGCAL_OK) {
            status = rc_check_transform(&rig->cameras[c].cam_from_rig);
        }
        if (status != RIGCAL_OK) {
            return status;
        }
        n += rig->held[c] ? 0 : 6;
        *frame = (rig->held[c] && *frame == rig->n_cameras) ? c : *frame;
    }
    for (size_t i = 0; i < n; i++) {
        const rigcal_real *const row = &rig->Sigma[rc_packed_at(i, 0)];
        if (!rc_all_finite(row, (int)i + 1)) {
            return RIGCAL_ERR_NOT_FINITE;
        }
        for (size_t j = 0; j <= i; j++) {
            const rigcal_real of_both = row[i] * rig->Sigma[rc_packed_at(j, j)];
            if (!(row[i] >= 0) || !(row[i] <= RC_COORDINATE_MAX) ||
                row[j] * row[j] > of_both * (1 + CORRELATION_ROUNDING)) {
                return RIGCAL_ERR_RANGE;
            }
        }
    }
    return (*frame == rig->n_cameras) ? RIGCAL_ERR_RANGE : RIGCAL_OK;
}

/* The mean distance between the cameras' centres. */
static rigcal_real mean_distance(const rigcal_calibrated_rig *rig)
{
    rigcal_real sum = 0, count = 0;
    for (size_t a = 0; a < rig->n_cameras; a++) {
        for (size_t b = 0; b < a; b++) {
            rigcal_transform b_from_a;
            rc_transform_between(&b_from_a, &rig->cameras[b].cam_from_rig,
                                 &rig->cameras[a].cam_from_rig);
            sum += rc_vec3_norm(b_from_a.t);
            count += 1;
        }
    }
    return sum / count;
}

/* (w, ds) of a camera = out (w, dt). */
static void own_error(rigcal_real out[36], const rigcal_calibrated_rig *rig, size_t index)
{
    rigcal_transform shift;
    rc_transform_identity(&shift);
    rc_vec3_copy(shift.t, rig->cameras[index].cam_from_rig.t);
    rc_transform_carry(out, &shift);
}

/* Copies the covariance of the cameras. The rig has that of (w, dt), the filter that of (w,
 * ds): ds = dt + t x w. UD was set to 0, which is right for targets and held cameras. */
static void copy_covariance(rc_filter *f, const rigcal_calibrated_rig *rig)
{
    rigcal_real from_a = 0;
    for (size_t a = 0; a < rig->n_cameras; a++) {
        rigcal_real from_b = 0, A[36], B[36], block[36], moved[36];
        own_error(A, rig, a);
        for (size_t b = 0; b <= a && !rig->held[a]; b++) {
            if (rig->held[b]) {
                continue;
            }
            own_error(B, rig, b);
            rc_joint_block(block, rig->Sigma, from_a, from_b);
            rc_filter_through(moved, A, block, B);
            rc_filter_add(f, f->UD, a, b, moved);
            from_b += 6;
        }
        from_a += rig->held[a] ? 0 : 6;
    }
    rc_filter_factor(f->UD, f->n);
}

static void begin_head(rc_monitor_head *head, const rigcal_calibrated_rig *rig,
                       size_t n_targets, size_t frame,
                       const rigcal_monitor_options *options)
{
    memset(head, 0, sizeof *head);
    head->magic = MAGIC;
    head->n_cameras = (uint32_t)rig->n_cameras;
    head->n_targets = (uint32_t)n_targets;
    head->frame = (uint32_t)frame;
    head->wrong = rc_max(options->wrong, WRONG_LEAST);
    head->walk_rad = options->walk_rad;
    head->walk_t = options->walk_t;
    head->move_rad = options->move_rad;
    head->move_t = options->move_t > 0 ? options->move_t
                                       : options->move_rad * RC_LEVER * mean_distance(rig);
    head->numbers[0] = rig->sigma_px;
    head->numbers[1] = rig->F;
    head->numbers[2] = rig->freedom_between;
    head->numbers[3] = rig->freedom_within;
}

/* Checks a rig and its numbers. *frame is the first held camera. */
static rigcal_status check_rig(size_t *frame, const rigcal_calibrated_rig *rig,
                               size_t n_targets, size_t capacity)
{
    size_t n_free;
    rigcal_status status = rc_calibrated_check(&n_free, rig);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (rig->n_cameras < 2) {
        return RIGCAL_ERR_TOO_FEW;
    }
    const size_t size = rigcal_monitor_size(rig->n_cameras, n_targets);
    if (size == 0) {
        return RIGCAL_ERR_RANGE;
    }
    if (size > capacity) {
        return RIGCAL_ERR_CAPACITY;
    }
    for (size_t c = 0; c < rig->n_cameras; c++) {
        if (rig->group[c] != 0) {
            return RIGCAL_DISCONNECTED;
        }
    }
    return check_cameras(frame, rig);
}

rigcal_status rigcal_monitor_begin(rigcal_real monitor[], size_t capacity,
                                   const rigcal_calibrated_rig *rig, size_t n_targets,
                                   const rigcal_monitor_options *options)
{
    rigcal_monitor_options chosen;
    rc_monitor_head head;
    rc_monitor m;
    size_t frame = 0;
    if (monitor == NULL) {
        return RIGCAL_ERR_NULL;
    }
    (void)rigcal_monitor_defaults(&chosen);
    if (options != NULL) {
        chosen = *options;
    }
    rigcal_status status = check_rig(&frame, rig, n_targets, capacity);
    if (status == RIGCAL_OK) {
        status = check_options(&chosen);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    begin_head(&head, rig, n_targets, frame, &chosen);
    if (!(head.move_t > 0)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    memset(monitor, 0, rigcal_monitor_size(rig->n_cameras, n_targets) * sizeof monitor[0]);
    memset(&m.top, 0, sizeof m.top);
    m.top.head = head;
    rc_monitor_lay_out(&m, monitor);
    for (size_t b = 0; b < m.filter.n_bodies; b++) {
        rc_transform_identity(&m.filter.poses[b]);
    }
    for (size_t c = 0; c < rig->n_cameras; c++) {
        m.filter.poses[c] = rig->cameras[c].cam_from_rig;
        memcpy(m.lenses + RIGCAL_MONITOR_LENS * c, &rig->cameras[c].camera,
               sizeof(rigcal_camera));
    }
    copy_covariance(&m.filter, rig);
    rc_alarm_begin(&m.top.head.alarm, m.bodies, m.filter.n_bodies, chosen.arl0_frames,
                   chosen.common, m.top.head.move_rad, m.top.head.move_t);
    rc_monitor_close(&m, 1);
    return RIGCAL_OK;
}

/* ---- rows -------------------------------------------------------------------- */

rigcal_status rc_monitor_check_noise(rigcal_real sigma_px)
{
    if (!rc_is_finite(sigma_px)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    return is_within(sigma_px, NOISE_LEAST, NOISE_MOST) ? RIGCAL_OK : RIGCAL_ERR_RANGE;
}

/* Which of the two bodies settle, as bits. If the frame settles, both do. */
static int settling_of(const rc_monitor *m, const rc_seen *seen)
{
    const size_t body = m->top.head.settles;
    if (m->top.head.settling == 0) {
        return 0;
    }
    return body == m->filter.frame ? 3 : (seen->a == body) + 2 * (seen->b == body);
}

/* Moves the pose of the body that settles, after each of its rows. If this body is the
 * frame, all other poses move instead. */
static void settle(const rc_monitor *m)
{
    if (m->top.head.settles != m->filter.frame) {
        rc_filter_apply(&m->filter, m->top.head.settles);
        return;
    }
    for (size_t b = 0; b < m->filter.n_bodies; b++) {
        rc_filter_apply(&m->filter, b);
    }
}

static rigcal_status take_rows(rc_monitor *m, const rc_seen *seen)
{
    const rc_filter *const f = &m->filter;
    const int open = settling_of(m, seen);
    for (int k = 0; k < seen->n_rows; k++) {
        rc_row rows[2];
        rc_news news;
        const rigcal_status status =
            rc_rows_of(rows, seen, &f->poses[seen->a], &f->poses[seen->b]);
        if (status != RIGCAL_OK) {
            return status;
        }
        if (!rc_filter_row(&news, f, seen->a, seen->b, &rows[k], m->top.head.wrong, open)) {
            return RIGCAL_ERR_DEGENERATE;
        }
        m->top.head.rows++;
        m->top.head.doubted += (news.doubt.beta < RC(0.5)) ? 1 : 0;
        rc_alarm_row(&m->top.head.alarm, m->bodies, news.z, news.sd, seen->a, rows[k].h_a,
                     seen->b, rows[k].h_b);
        if (open != 0) {
            settle(m);
        }
    }
    return RIGCAL_OK;
}

rigcal_status rc_monitor_take(rc_monitor *m, const rc_seen *seen)
{
    if (m->top.head.is_alarm == 0) {
        return take_rows(m, seen);
    }
    const int is_doubted = rc_trial_take(&m->filter, m->bodies, seen, m->top.head.wrong);
    m->top.head.rows += (uint32_t)seen->n_rows;
    m->top.head.doubted += is_doubted ? (uint32_t)seen->n_rows : 0;
    return RIGCAL_OK;
}

/* Opens a monitor for a match and checks the arguments. */
static rigcal_status open_match(rc_monitor *m, const rigcal_real monitor[], size_t a,
                                size_t b, rigcal_real sigma_px)
{
    rigcal_status status = rc_monitor_open(m, monitor);
    if (status == RIGCAL_OK) {
        status = rc_monitor_check_noise(sigma_px);
    }
    if (status == RIGCAL_OK &&
        (a >= m->filter.n_cameras || b >= m->filter.n_cameras || a == b)) {
        status = RIGCAL_ERR_RANGE;
    }
    return status;
}

/* Takes a match whose sights are set. */
static rigcal_status take_match(rc_monitor *m, rc_seen *seen, size_t a, size_t b)
{
    seen->a = a;
    seen->b = b;
    seen->n_rows = 1;
    const rigcal_status status = rc_monitor_take(m, seen);
    if (status == RIGCAL_OK) { /* the other parts did not change */
        m->top.head.seal[0] = m->top.head.seal[1] = 0;
        copy_first_in(m);
    }
    return status;
}

/* Makes the sight of a ray. */
static rigcal_status sight_ray(rc_sight *sight, const rc_monitor *m, size_t index,
                               const rigcal_real ray[3], rigcal_real sigma_px)
{
    rc_monitor_lens_copy lens;
    return rc_sight_of(sight, rc_monitor_lens(&lens, m, index), ray, sigma_px);
}

/* Like rc_check_ray, but calls it only if something may be wrong. */
static inline rigcal_status check_ray(const rigcal_real ray[3])
{
    if (ray != NULL) {
        const rigcal_real sum = RC_FABS(ray[0]) + RC_FABS(ray[1]) + RC_FABS(ray[2]);
        if (sum > 3 / RC_COORDINATE_MAX && sum <= RC_COORDINATE_MAX) {
            return RIGCAL_OK;
        }
    }
    return rc_check_ray(ray);
}

rigcal_status rigcal_monitor_match_rays(rigcal_real monitor[], size_t camera_a,
                                        const rigcal_real ray_a[3], size_t camera_b,
                                        const rigcal_real ray_b[3], rigcal_real sigma_px)
{
    rc_monitor m;
    rc_seen seen;
    rigcal_status status = check_ray(ray_a);
    if (status == RIGCAL_OK) {
        status = check_ray(ray_b);
    }
    if (status == RIGCAL_OK) {
        status = open_match(&m, monitor, camera_a, camera_b, sigma_px);
    }
    if (status == RIGCAL_OK) {
        status = sight_ray(&seen.sight[0], &m, camera_a, ray_a, sigma_px);
    }
    if (status == RIGCAL_OK) {
        status = sight_ray(&seen.sight[1], &m, camera_b, ray_b, sigma_px);
    }
    return (status == RIGCAL_OK) ? take_match(&m, &seen, camera_a, camera_b) : status;
}

/* Makes the sight of a pixel. */
static rigcal_status sight_pixel(rc_sight *sight, const rc_monitor *m, size_t index,
                                 const rigcal_real uv[2], rigcal_real sigma_px)
{
    rc_monitor_lens_copy lens;
    rigcal_real ray[3];
    const rigcal_camera *const camera = rc_monitor_lens(&lens, m, index);
    const rigcal_status status = rc_pixel_to_ray(ray, camera, uv);
    return (status == RIGCAL_OK) ? rc_sight_of(sight, camera, ray, sigma_px) : status;
}

rigcal_status rigcal_monitor_match(rigcal_real monitor[], size_t camera_a,
                                   const rigcal_real uv_a[2], size_t camera_b,
                                   const rigcal_real uv_b[2], rigcal_real sigma_px)
{
    rc_monitor m;
    rc_seen seen;
    rigcal_status status = rc_check_pixel(uv_a);
    if (status == RIGCAL_OK) {
        status = rc_check_pixel(uv_b);
    }
    if (status == RIGCAL_OK) {
        status = open_match(&m, monitor, camera_a, camera_b, sigma_px);
    }
    if (status == RIGCAL_OK) {
        status = sight_pixel(&seen.sight[0], &m, camera_a, uv_a, sigma_px);
    }
    if (status == RIGCAL_OK) {
        status = sight_pixel(&seen.sight[1], &m, camera_b, uv_b, sigma_px);
    }
    return (status == RIGCAL_OK) ? take_match(&m, &seen, camera_a, camera_b) : status;
}
