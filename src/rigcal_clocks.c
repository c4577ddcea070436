#include "rc_adjust.h"

/* ---- constants ----------------------------------------------------------- */

/* s: a longer step from one placement to the next is none of frames that follow each other. */
#define FRAME_LONGEST RC(0.35)

/* frames: the longest step of a run. More than one and a half, for stamps that are uneven;
 * less than two, for the curve through a gap is not known well enough. */
#define STEP_LONGEST RC(1.6)

/* part of a frame: a placement whose views have moved by less from its instant stays. */
#define CENTRE_ENOUGH RC(0.01)

/* part of a frame: times whose own rounding is more say nothing of clocks. */
#define ROUNDING_MOST RC(0.001)

/* sigma^2: of a target that stands still the step from one placement to the next has about
 * 12, from noise. With less than this it hardly moves: its velocity is then known to a
 * third. */
#define STILL RC(100)

/* sigma^2: a step that gains less moves no unknown by more than a tenth of its sigma. */
#define GAIN_ENOUGH RC(0.01)

/* frames: a camera is not off by more. */
#define FRAMES_MOST RC(1e6)

/* halvings: of the search of the middle step. */
enum { HALVINGS = 40 };

/* ---- the memory to work in ----------------------------------------------- */

/* Behind that of the rig. */
typedef struct {
    rigcal_real *saved;  /* the offsets, the drifts */
    rigcal_real *column; /* of each camera, the first unknown of its clock; -1: none */
    rigcal_real *moved; /* of each camera, (H_p d, d) of its placements, d to the nearest */
    rigcal_real *count; /* of each camera: its views; those with a neighbour in time */
    rigcal_real *y;     /* 6 of each slot: its clock by the placement */
    rigcal_real *since; /* of each slot, its stamp after the middle */
    rigcal_real *camera; /* of each slot; -1: its view does not count */
} clock_parts;

/* Reals of it a camera. */
enum { PARTS = 14 };

static void clock_parts_of(clock_parts *c, const rc_rig_parts *parts,
                           const rigcal_rig_solver *s)
{
    const size_t n = s->rig->n_cameras;
    c->saved = parts->d + s->n;
    c->column = c->saved + 2 * n;
    c->moved = c->column + n;
    c->count = c->moved + n;
    c->y = c->count + 2 * n;
    c->since = c->y + 6 * n;
    c->camera = c->since + n;
}

size_t rigcal_clocks_work(size_t n_free, size_t n_cameras)
{
    return RIGCAL_CLOCKS_WORK(n_free, n_cameras);
}

/* ---- what is handed in --------------------------------------------------- */

static int is_known(rigcal_real time)
{
    return time <= RC_COORDINATE_MAX && time >= -RC_COORDINATE_MAX;
}

/* NaN is no stamp, and right. */
static rigcal_status check_stamp(rigcal_real time)
{
    return (is_known(time) || time != time) ? RIGCAL_OK
           : rc_is_finite(time)             ? RIGCAL_ERR_RANGE
                                            : RIGCAL_ERR_NOT_FINITE;
}

/* Of the times that are known the first, the last, and the largest. */
static rigcal_status check_times(rigcal_real ends[2], const rigcal_real times[], size_t n)
{
    int is_first = 1;
    for (size_t f = 0; f < n; f++) {
        const rigcal_status status = check_stamp(times[f]);
        if (status != RIGCAL_OK) {
            return status;
        }
        if (!is_known(times[f])) {
            continue;
        }
        if (!is_first && !(times[f] > ends[1])) {
            return (times[f] < ends[1]) ? RIGCAL_ERR_UNSORTED : RIGCAL_ERR_TWICE;
        }
        ends[0] = is_first ? times[f] : ends[0];
        ends[1] = times[f];
        is_first = 0;
    }
    return RIGCAL_OK;
}

/* How many steps between times that are known are at most `limit`. */
static size_t count_steps(const rigcal_real times[], size_t n, rigcal_real limit)
{
    rigcal_real last = RC_MAX;
    size_t count = 0;
    for (size_t f = 0; f < n; f++) {
        if (is_known(times[f])) {
            count += times[f] - last <= limit && times[f] > last;
            last = times[f];
        }
    }
    return count;
}

/* The middle one of the steps up to FRAME_LONGEST, by halving; that, where there is none. */
static rigcal_real middle_step(const rigcal_real times[], size_t n)
{
    const size_t half = (count_steps(times, n, FRAME_LONGEST) + 1) / 2;
    rigcal_real low = 0, high = FRAME_LONGEST;
    for (int k = 0; k < HALVINGS && half > 0; k++) {
        const rigcal_real middle = (low + high) / 2;
        if (count_steps(times, n, middle) >= half) {
            high = middle;
        } else {
            low = middle;
        }
    }
    return high;
}

static rigcal_status check(const rigcal_rig *rig)
{
    rigcal_rig_clocks *const clocks = rig->clocks;
    const size_t C = rig->n_cameras;
    rigcal_real ends[2] = {0, 0};
    if (clocks->times == NULL || clocks->instants == NULL || clocks->offsets == NULL ||
        clocks->states == NULL || (clocks->free_drifts != 0 && clocks->drifts == NULL)) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = check_times(ends, clocks->times, rig->n_placements);
    for (size_t v = 0; clocks->view_times != NULL && v < rig->n_views; v++) {
        status = (status == RIGCAL_OK) ? check_stamp(clocks->view_times[v]) : status;
    }
    for (size_t c = 0; status == RIGCAL_OK && c < C; c++) {
        status = rc_check_numbers(&clocks->offsets[c], 1, RC_COORDINATE_MAX);
        if (status == RIGCAL_OK && clocks->drifts != NULL) {
            status = rc_check_numbers(&clocks->drifts[c], 1, 1);
        }
    }
    if (status == RIGCAL_OK) {
        status = rc_check_noise(&clocks->sigma_time);
    }
    if (status == RIGCAL_OK) {
        status = rc_check_noise(&clocks->frame);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    if (clocks->neighbours < 1 || clocks->neighbours > RIGCAL_MOTION_MOST) {
        return RIGCAL_ERR_RANGE;
    }
    if (!(clocks->frame > 0)) {
        clocks->frame = middle_step(clocks->times, rig->n_placements);
    }
    clocks->memory.middle = ends[0] + (ends[1] - ends[0]) / 2;
    return (RC_EPS * rc_max(RC_FABS(ends[0]), RC_FABS(ends[1])) >
            ROUNDING_MOST * clocks->frame)
               ? RIGCAL_ERR_PRECISION
               : RIGCAL_OK;
}

/* ---- what is unknown ----------------------------------------------------- */

/* Unknowns of a clock that is free. */
static size_t unknowns_of(const rigcal_rig_clocks *clocks)
{
    return (clocks->free_drifts != 0) ? 2 : 1;
}

static int is_held(const rigcal_rig_clocks *clocks, size_t c)
{
    return clocks->held != NULL && clocks->held[c] != 0;
}

/* Whether the clock of camera c is free: not where it is held; and of a group in which none
 * is held, the first one is. */
static int is_free(const rigcal_rig *rig, size_t c)
{
    if (rig->clocks->free_offsets == 0 || is_held(rig->clocks, c)) {
        return 0;
    }
    int is_first = 1, is_fixed = 0;
    for (size_t other = 0; other < rig->n_cameras; other++) {
        if (rig->group[other] == rig->group[c]) {
            is_first &= other >= c;
            is_fixed |= is_held(rig->clocks, other);
        }
    }
    return is_fixed || !is_first;
}

/* The noise of pixels, by which that of stamps is weighed: as stated, or of the views by
 * themselves. */
static rigcal_status weigh_stamps(const rigcal_rig_solver *s)
{
    rigcal_rig_clocks *const clocks = s->rig->clocks;
    const rigcal_real freedom =
        2 * (rigcal_real)(int32_t)s->n_points - 6 * (rigcal_real)(int32_t)s->n_used;
    clocks->memory.ratio2 = 0;
    if (!(clocks->sigma_time > 0)) {
        return RIGCAL_OK;
    }
    rigcal_real sigma2 = s->rig->sigma_px * s->rig->sigma_px;
    if (!(sigma2 > 0)) {
        sigma2 = (freedom > 0) ? s->own_sum / freedom : 0;
    }
    clocks->memory.ratio2 = sigma2 / (clocks->sigma_time * clocks->sigma_time);
    return (sigma2 > 0) ? RIGCAL_OK : RIGCAL_ERR_RANGE;
}

static rigcal_status begin(rigcal_rig_solver *s)
{
    const rigcal_rig *const rig = s->rig;
    rigcal_rig_clocks *const clocks = rig->clocks;
    const size_t C = rig->n_cameras, n_cameras = s->n;
    rc_rig_parts parts;
    clock_parts c;
    for (size_t i = 0; i < C; i++) {
        clocks->states[i] = is_free(rig, i) ? RIGCAL_CLOCK_FREE : RIGCAL_CLOCK_HELD;
        s->n += (clocks->states[i] == RIGCAL_CLOCK_FREE) ? unknowns_of(clocks) : 0;
    }
    const size_t more = s->n - n_cameras;
    if (rigcal_rig_work(n_cameras / 6, C, rig->n_placements) + more * n_cameras +
            more * (more + 5) / 2 + PARTS * C >
        rig->work_capacity) {
        return RIGCAL_ERR_CAPACITY;
    }
    rc_rig_parts_of(&parts, rig, s->n);
    clock_parts_of(&c, &parts, s);
    size_t at = n_cameras;
    for (size_t i = 0; i < C; i++) {
        c.column[i] = -1;
        if (clocks->states[i] == RIGCAL_CLOCK_FREE) {
            c.column[i] = (rigcal_real)at;
            at += unknowns_of(clocks);
        }
    }
    clocks->memory.placement = -1;
    return weigh_stamps(s);
}

/* ---- the time of a view -------------------------------------------------- */

/* Its stamp, or NaN. */
static rigcal_real stamp_of(const rigcal_rig_clocks *clocks, size_t placement, size_t view)
{
    return (clocks->view_times != NULL && is_known(clocks->view_times[view]))
               ? clocks->view_times[view]
               : clocks->times[placement];
}

/* What the camera's clock makes of it. */
static rigcal_real time_of(const rigcal_rig_clocks *clocks, rigcal_real stamp,
                           size_t camera)
{
    const rigcal_real drift = (clocks->drifts == NULL) ? 0 : clocks->drifts[camera];
    return stamp + clocks->offsets[camera] + drift * (stamp - clocks->memory.middle);
}

static void path_of(rc_path *path, const rigcal_rig *rig, const rigcal_transform poses[])
{
    path->poses = poses;
    path->times = rig->clocks->instants;
    path->count = NULL; /* of a placement that is not seen the instant is unknown */
    path->n = rig->n_placements;
    path->longest = STEP_LONGEST * rig->clocks->frame;
    path->neighbours = rig->clocks->neighbours;
}

/* ---- where a view sees its placement (H3) -------------------------------- */

static void place(rigcal_transform *rig_from_placement, const rigcal_rig *rig,
                  int32_t camera, size_t placement, size_t view)
{
    rigcal_rig_clocks *const clocks = rig->clocks;
    rigcal_clock_memory *const memory = &clocks->memory;
    const rigcal_real stamp = stamp_of(clocks, placement, view);
    rigcal_motion fresh;
    const rigcal_motion *motion = &memory->motion;
    rigcal_real d[6];
    if (memory->placement != (int32_t)placement) {
        rc_path path;
        path_of(&path, rig, rig->rig_from_placements);
        rc_motion_of(&fresh, &path, placement);
        motion = &fresh;
    }
    rc_clear(memory->velocity, 6);
    memory->since = stamp - memory->middle;
    if (motion->n == 0 || !is_known(stamp)) {
        memory->since = 0;
        return;
    }
    const rigcal_real after =
        time_of(clocks, stamp, (size_t)camera) - clocks->instants[placement];
    rc_motion_at(d, memory->velocity, motion, after);
    if (after > 0 || after < 0) {
        memory->moved = 1;
        rc_motion_move(rig_from_placement, d);
    }
}

static rigcal_real dot6(const rigcal_real a[6], const rigcal_real b[6])
{
    return rc_vec3_dot(a, b) + rc_vec3_dot(&a[3], &b[3]);
}

/* (H11) */
static void weigh(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                  const rc_chain *chain, const rigcal_rig *rig)
{
    const rigcal_clock_memory *const memory = &rig->clocks->memory;
    rigcal_real m[6], Hm[6], full[36];
    if (!(memory->ratio2 > 0)) {
        return;
    }
    rc_motion_seen(m, chain, memory->velocity);
    rc_sym6_mul(Hm, H, m);
    const rigcal_real scale = 1 / (dot6(m, Hm) + memory->ratio2);
    const rigcal_real along = dot6(m, g);
    rc_sym6_unpack(full, H);
    for (int i = 0; i < 6; i++) {
        g[i] -= Hm[i] * along * scale;
        for (int j = 0; j < 6; j++) {
            full[6 * i + j] -= Hm[i] * Hm[j] * scale;
        }
    }
    rc_sym6_pack(H, full);
    *sum -= along * along * scale;
}

/* ---- the equations of the clocks (H5) ------------------------------------ */

static void add(rigcal_rig_solver *s, const rc_rig_parts *parts, const rigcal_real g[6],
                const rigcal_real H[21], const rc_chain *chain, int32_t camera)
{
    const rigcal_rig_clocks *const clocks = s->rig->clocks;
    const size_t slot = s->view - s->first;
    rigcal_real m[6], Hm[6], across[6];
    clock_parts c;
    clock_parts_of(&c, parts, s);
    c.camera[slot] = (rigcal_real)camera;
    c.count[2 * camera] += 1;
    if (!(c.column[camera] >= 0)) {
        return;
    }
    const size_t column = (size_t)c.column[camera];
    rc_motion_seen(m, chain, clocks->memory.velocity);
    rc_sym6_mul(Hm, H, m);
    const rigcal_real Q = dot6(m, Hm), q = dot6(m, g);
    rigcal_real *const y = &c.y[6 * slot];
    rc_mat3_tmul_vec3(y, chain->R_c, Hm);
    rc_mat3_tmul_vec3(&y[3], chain->R_c, &Hm[3]);
    rc_vec3_cross(across, chain->lever, &Hm[3]);
    rc_vec3_add(across, Hm);
    rc_vec3_copy(&across[3], &Hm[3]);
    c.since[slot] = clocks->memory.since;
    rigcal_real factor = 1;
    for (size_t i = 0; i < unknowns_of(clocks); i++) {
        rigcal_real *const row = &parts->S[rc_packed_at(column + i, 0)];
        parts->g[column + i] += factor * q;
        parts->d[column + i] += factor * factor * Q;
        row[column + i] += factor * factor * Q;
        if (i > 0) {
            row[column] += factor * Q;
        }
        for (int k = 0; parts->column[camera] >= 0 && k < 6; k++) {
            row[(size_t)parts->column[camera] + (size_t)k] += factor * across[k];
        }
        factor = c.since[slot];
    }
}

/* The clock of slot a and the camera of slot b lose y Y^T. */
static void subtract_camera(const rigcal_rig_solver *s, const rc_rig_parts *parts,
                            const clock_parts *c, size_t a, size_t b)
{
    const rigcal_real *const y = &c->y[6 * a], *const Y = &parts->W[36 * b];
    if (!(parts->slot[b] >= 0)) {
        return;
    }
    const size_t column = (size_t)c->column[(size_t)c->camera[a]];
    rigcal_real *const row = &parts->S[rc_packed_at(column, (size_t)parts->slot[b])];
    for (size_t k = 0; k < 6; k++) {
        const rigcal_real lost = dot6(y, &Y[6 * k]);
        row[k] -= lost;
        if (s->rig->clocks->free_drifts != 0) {
            row[column + 1 + k] -= c->since[a] * lost; /* the next row */
        }
    }
}

/* The clocks of slots a and b. */
static void subtract_clocks(const rigcal_rig_solver *s, const rc_rig_parts *parts,
                            const clock_parts *c, size_t a, size_t b)
{
    const size_t at[2] = {(size_t)c->column[(size_t)c->camera[a]],
                          (size_t)c->column[(size_t)c->camera[b]]};
    const rigcal_real lost = dot6(&c->y[6 * a], &c->y[6 * b]);
    for (size_t i = 0; i < unknowns_of(s->rig->clocks); i++) {
        for (size_t j = 0; j < unknowns_of(s->rig->clocks); j++) {
            const size_t row = at[0] + i, column = at[1] + j;
            const rigcal_real part =
                lost * ((i > 0) ? c->since[a] : 1) * ((j > 0) ? c->since[b] : 1);
            if (a != b || row >= column) {
                parts->S[(row >= column) ? rc_packed_at(row, column)
                                         : rc_packed_at(column, row)] -= part;
            }
        }
    }
}

static int has_clock(const clock_parts *c, size_t slot)
{
    return c->camera[slot] >= 0 && c->column[(size_t)c->camera[slot]] >= 0;
}

static void eliminate(rigcal_rig_solver *s, const rc_rig_parts *parts, size_t slot)
{
    clock_parts c;
    clock_parts_of(&c, parts, s);
    const int is_clock = has_clock(&c, slot);
    if (is_clock) {
        rigcal_real *const y = &c.y[6 * slot];
        const size_t column = (size_t)c.column[(size_t)c.camera[slot]];
        rc_sym6_forward(y, (const rc_sym6_factor *)(const void *)s->Hp);
        const rigcal_real lost = dot6(y, s->gp);
        parts->g[column] -= lost;
        if (unknowns_of(s->rig->clocks) > 1) {
            parts->g[column + 1] -= c.since[slot] * lost;
        }
    }
    for (size_t other = 0; other <= slot; other++) {
        if (is_clock) {
            subtract_camera(s, parts, &c, slot, other);
        }
        if (has_clock(&c, other)) {
            if (other < slot) {
                subtract_camera(s, parts, &c, other, slot);
            }
            if (is_clock) {
                subtract_clocks(s, parts, &c, slot, other);
            }
        }
    }
}

/* ---- clocks that are held after all -------------------------------------- */

/* An unknown that does not move, and nothing with it. Rows before it may be factored. */
static void hold_unknown(rigcal_rig_solver *s, const rc_rig_parts *parts, size_t at)
{
    for (size_t i = 0; i < s->n; i++) {
        parts->S[(i < at) ? rc_packed_at(at, i) : rc_packed_at(i, at)] = 0;
    }
    parts->S[rc_packed_at(at, at)] = parts->d[at] = 1;
    parts->g[at] = 0;
    s->n_clocks--;
}

/* The drift goes with the offset. */
static int hold(rigcal_rig_solver *s, const rc_rig_parts *parts, size_t row)
{
    clock_parts c;
    clock_parts_of(&c, parts, s);
    for (size_t i = 0; i < s->rig->n_cameras; i++) {
        const rigcal_real at = (rigcal_real)row - c.column[i];
        if (c.column[i] >= 0 && at >= 0 && at < (rigcal_real)unknowns_of(s->rig->clocks)) {
            s->rig->clocks->states[i] = RIGCAL_CLOCK_UNTESTABLE;
            hold_unknown(s, parts, row);
            return 1;
        }
    }
    return 0;
}

/* All equations have been added: which clocks there is something known of. */
static void reduced(rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    rigcal_rig_clocks *const clocks = s->rig->clocks;
    clock_parts c;
    clock_parts_of(&c, parts, s);
    const rigcal_real freedom =
        2 * (rigcal_real)(int32_t)s->n_points - 6 * (rigcal_real)(int32_t)s->n_used;
    rigcal_real sigma2 = s->rig->sigma_px * s->rig->sigma_px;
    if (!(sigma2 > 0) && freedom > 0) {
        sigma2 = ((s->own_sum > 0) ? s->own_sum : s->sum) / freedom;
    }
    s->n_clocks = 0;
    for (size_t i = 0; i < s->rig->n_cameras; i++) {
        int32_t state = RIGCAL_CLOCK_FREE;
        if (!(c.count[2 * i] > 0)) {
            state = RIGCAL_CLOCK_UNSEEN;
        } else if (!(c.column[i] >= 0)) {
            state = RIGCAL_CLOCK_HELD;
        } else if (!(c.count[2 * i + 1] > 0)) {
            state = RIGCAL_CLOCK_ALONE;
        } else if (c.moved[i] < STILL * sigma2 * c.count[2 * i + 1]) {
            state = RIGCAL_CLOCK_STILL;
        }
        clocks->states[i] = state;
        if (c.column[i] >= 0) {
            const size_t at = (size_t)c.column[i];
            s->n_clocks += unknowns_of(clocks);
            for (size_t k = 0; state != RIGCAL_CLOCK_FREE && k < unknowns_of(clocks); k++) {
                hold_unknown(s, parts, at + k);
            }
        }
    }
    if (s->n_clocks > 0 || clocks->memory.moved != 0) {
        s->negligible = rc_max(s->negligible, GAIN_ENOUGH * s->sum /
                                                  (2 * (rigcal_real)(int32_t)s->n_points));
    }
}

/* ---- a pass -------------------------------------------------------------- */

/* (H10): the mean time of the placement's views, or RC_MAX. */
static rigcal_real mean_time(const rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    const rigcal_rig *const rig = s->rig;
    const rigcal_rig_clocks *const clocks = rig->clocks;
    const size_t end = s->view + rc_rig_views_of(parts, s->placement);
    rigcal_real sum = 0, count = 0, first = 0;
    for (size_t v = s->view; v < end; v++) {
        rigcal_rig_view view;
        const rigcal_real stamp = stamp_of(clocks, s->placement, v);
        if (!rc_rig_is_left_out(rig, v) && is_known(stamp) &&
            rc_rig_view_at(&view, rig, v) == RIGCAL_OK) {
            const rigcal_real time = time_of(clocks, stamp, (size_t)view.camera);
            first = (count > 0) ? first : time;
            sum += time - first;
            count += 1;
        }
    }
    return (count > 0) ? first + sum / count : RC_MAX;
}

/* The placement, with its pose, at that time. */
static void centre(const rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    const rigcal_rig *const rig = s->rig;
    const size_t f = s->placement;
    rigcal_real *const instant = &rig->clocks->instants[f];
    rigcal_transform *const pose = &rig->rig_from_placements[f];
    const rigcal_real time = mean_time(s, parts);
    if (s->evals < 2) { /* the first pass: poses are as they were handed in */
        *instant = time;
    } else if (RC_FABS(time - *instant) > CENTRE_ENOUGH * rig->clocks->frame) {
        rigcal_real d[6], velocity[6];
        rigcal_motion motion;
        rc_path path;
        path_of(&path, rig, rig->rig_from_placements);
        rc_motion_of(&motion, &path, f);
        rc_motion_at(d, velocity, &motion, time - *instant);
        rc_motion_move(pose, d);
        *instant = time;
    }
    parts->saved[rig->n_cameras + f] = *pose;
}

/* The motion of the placement that comes next, from where the last step began. */
static void begin_placement(const rigcal_rig_solver *s, const rc_rig_parts *parts,
                            const clock_parts *c)
{
    const rigcal_rig *const rig = s->rig;
    rigcal_clock_memory *const memory = &rig->clocks->memory;
    memory->placement = -1;
    if (s->placement < rig->n_placements) {
        rc_path path;
        path_of(&path, rig, &parts->saved[rig->n_cameras]);
        rc_motion_of(&memory->motion, &path, s->placement);
        memory->placement = (int32_t)s->placement;
    }
    for (size_t slot = 0; slot < rig->n_cameras; slot++) {
        c->camera[slot] = -1;
    }
}

/* How far the target moves to its nearest placement, against what is known of it. */
static void placed(const rigcal_rig_solver *s, const clock_parts *c)
{
    const rigcal_motion *const motion = &s->rig->clocks->memory.motion;
    rigcal_real d[6], velocity[6], Hd[6];
    if (motion->n == 0) {
        return;
    }
    rc_motion_at(d, velocity, motion, motion->nearest);
    rc_sym6_mul(Hd, s->Hp, d);
    for (size_t slot = 0; slot < s->rig->n_cameras; slot++) {
        if (c->camera[slot] >= 0) {
            const size_t camera = (size_t)c->camera[slot];
            c->moved[camera] += dot6(Hd, d);
            c->count[2 * camera + 1] += 1;
        }
    }
}

/* Of the unknowns `of`, the offsets or the drifts, unknown `which` of each clock. */
static void move_clocks(const rigcal_rig_solver *s, const rc_rig_parts *parts,
                        const clock_parts *c, rigcal_real of[], size_t which, int32_t what)
{
    const size_t n = s->rig->n_cameras;
    for (size_t i = 0; of != NULL && i < n; i++) {
        rigcal_real *const saved = &c->saved[which * n + i];
        if (what == RC_CLOCKS_RESTORE) {
            of[i] = *saved;
        } else {
            *saved = of[i];
            if (c->column[i] >= 0 && which < unknowns_of(s->rig->clocks)) {
                of[i] += parts->g[(size_t)c->column[i] + which];
            }
        }
    }
}

static void tell(rigcal_rig_solver *s, const rc_rig_parts *parts, int32_t what)
{
    rigcal_rig_clocks *const clocks = s->rig->clocks;
    clock_parts c;
    clock_parts_of(&c, parts, s);
    switch (what) {
    case RC_CLOCKS_CENTRE:
        if (s->placement == 0) {
            rc_clear(c.moved, 3 * s->rig->n_cameras);
            clocks->memory.moved = 0;
        }
        centre(s, parts);
        break;
    case RC_CLOCKS_PLACEMENT:
        begin_placement(s, parts, &c);
        break;
    case RC_CLOCKS_PLACED:
        placed(s, &c);
        break;
    case RC_CLOCKS_REDUCED:
        reduced(s, parts);
        break;
    case RC_CLOCKS_MOVE:
    case RC_CLOCKS_RESTORE:
        move_clocks(s, parts, &c, clocks->offsets, 0, what);
        move_clocks(s, parts, &c, clocks->drifts, 1, what);
        break;
    default:
        clocks->memory.placement = -1;
        break;
    }
}

static const struct rigcal_clock_calls CALLS = {check, begin, tell,      place,
                                                weigh, add,   eliminate, hold};

/* ---- public -------------------------------------------------------------- */

rigcal_status rigcal_clocks_defaults(rigcal_rig_clocks *clocks)
{
    if (clocks == NULL) {
        return RIGCAL_ERR_NULL;
    }
    *clocks = (rigcal_rig_clocks){0};
    clocks->calls = &CALLS;
    clocks->neighbours = RIGCAL_MOTION_MOST;
    clocks->memory.placement = -1;
    return RIGCAL_OK;
}

rigcal_status rigcal_clocks_sigma(rigcal_real offsets[], rigcal_real drifts[],
                                  const rigcal_rig *rig, rigcal_real sigma_px)
{
    rigcal_real Sigma[36];
    rc_rig_parts parts;
    size_t at = 0;
    if (offsets == NULL || (rig != NULL && rig->clocks == NULL)) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = rigcal_rig_covariance(Sigma, rig, sigma_px, 0);
    if (status != RIGCAL_OK) {
        return status;
    }
    const rigcal_rig_clocks *const clocks = rig->clocks;
    rc_rig_parts_of(&parts, rig, 0);
    for (size_t c = 0; c < rig->n_cameras; c++) {
        at += (parts.column[c] >= 0) ? 6 : 0;
    }
    for (size_t c = 0; c < rig->n_cameras; c++) {
        const int has_column = clocks->states[c] != RIGCAL_CLOCK_HELD &&
                               clocks->states[c] != RIGCAL_CLOCK_UNSEEN;
        const int is_asked = clocks->states[c] == RIGCAL_CLOCK_FREE;
        rigcal_real sigma[2] = {0, 0};
        for (size_t i = 0; has_column && i < unknowns_of(clocks); i++) {
            sigma[i] = is_asked ? sigma_px * RC_SQRT(parts.S[rc_packed_at(at, at)]) : 0;
            at++;
        }
        offsets[c] = sigma[0];
        if (drifts != NULL) {
            drifts[c] = sigma[1];
        }
    }
    return RIGCAL_OK;
}

rigcal_status rigcal_clocks_frames(int32_t frames[], const rigcal_rig_clocks *clocks,
                                   size_t n_cameras)
{
    if (frames == NULL || clocks == NULL || clocks->offsets == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (!rc_is_finite(clocks->frame)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    if (!(clocks->frame > 0)) {
        return RIGCAL_ERR_RANGE;
    }
    for (size_t c = 0; c < n_cameras; c++) {
        const rigcal_real by = clocks->offsets[c] / clocks->frame;
        if (!rc_is_finite(by)) {
            return RIGCAL_ERR_NOT_FINITE;
        }
        if (RC_FABS(by) > FRAMES_MOST) {
            return RIGCAL_ERR_RANGE;
        }
        frames[c] = (int32_t)((by < 0) ? by - RC(0.5) : by + RC(0.5));
    }
    return RIGCAL_OK;
}
