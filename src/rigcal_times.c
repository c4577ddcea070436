#include "rc_times.h"

/* ---- constants ----------------------------------------------------------- */

/* s: the longest step between two frames that follow each other. At three frames a second
 * the target's motion is too little known. */
#define FRAME_LONGEST RC(0.35)

/* frames: the longest step of a run. It exceeds one and a half because stamps are uneven.
 * It is less than two because a curve through a gap is not known well enough. */
#define STEP_LONGEST RC(1.6)

/* part of a frame: the times contain no information on clocks if their rounding is
 * larger. */
#define ROUNDING_MOST RC(0.001)

/* frames: the largest offset of a clock. Frame numbers then fit an int32_t. */
#define FRAMES_MOST RC(1e6)

/* halvings: the median step is found by this many. It is then exact to float's rounding. */
enum { HALVINGS = 24 };

/* ---- what is handed in --------------------------------------------------- */

/* How many steps from one known time to the next are at most `limit`. */
static size_t count_steps(const rigcal_real times[], size_t n, rigcal_real limit)
{
    rigcal_real last = RC_MAX;
    size_t count = 0;
    for (size_t f = 0; f < n; f++) {
        count += times[f] > last && times[f] - last <= limit;
        last = (times[f] <= RC_MAX) ? times[f] : last;
    }
    return count;
}

/* The median of the steps up to FRAME_LONGEST, or FRAME_LONGEST if there are none. */
static rigcal_real middle_step(const rigcal_real times[], size_t n)
{
    const size_t half = (count_steps(times, n, FRAME_LONGEST) + 1) / 2;
    rigcal_real high = FRAME_LONGEST, width = FRAME_LONGEST;
    for (int k = 0; k < HALVINGS && half > 0; k++) {
        width /= 2;
        high -= (count_steps(times, n, high - width) >= half) ? width : 0;
    }
    return high;
}

/* Checks that the known times rise. *middle is the middle between the first and the
 * last. */
static rigcal_status check_order(rigcal_real *middle, const rigcal_real times[], size_t n,
                                 rigcal_real frame)
{
    rigcal_real first = 0, last = -RC_MAX;
    for (size_t f = 0; f < n; f++) {
        const rigcal_real t = times[f];
        if (RC_FABS(t) > RC_COORDINATE_MAX) {
            return (RC_FABS(t) > RC_MAX) ? RIGCAL_ERR_NOT_FINITE : RIGCAL_ERR_RANGE;
        }
        if (t < last || t == last) {
            return (t < last) ? RIGCAL_ERR_UNSORTED : RIGCAL_ERR_TWICE;
        }
        if (t > last) { /* false for NaN */
            first = (last > -RC_MAX) ? first : t;
            last = t;
        }
    }
    last = (last > -RC_MAX) ? last : 0;
    *middle = (first + last) / 2;
    return (RC_EPS * rc_max(RC_FABS(first), RC_FABS(last)) > ROUNDING_MOST * frame)
               ? RIGCAL_ERR_PRECISION
               : RIGCAL_OK;
}

rigcal_status rc_times_check(const rigcal_rig *rig)
{
    rigcal_rig_clocks *const clocks = rig->clocks;
    const int n = (int)rig->n_cameras;
    if (clocks->times == NULL || clocks->instants == NULL || clocks->states == NULL ||
        (clocks->free_drifts != 0 && clocks->drifts == NULL)) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_numbers(clocks->offsets, n, RC_COORDINATE_MAX);
    if (status == RIGCAL_OK && clocks->drifts != NULL) {
        status = rc_check_numbers(clocks->drifts, n, 1);
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
    return check_order(&clocks->memory.middle, clocks->times, rig->n_placements,
                       clocks->frame);
}

/* ---- where a view sees its placement (H3) -------------------------------- */

void rc_times_motion(rigcal_motion *motion, const rigcal_rig *rig,
                     const rigcal_transform poses[], size_t placement)
{
    const rigcal_rig_clocks *const clocks = rig->clocks;
    const rc_path path = {poses, clocks->instants, rig->n_placements,
                          STEP_LONGEST * clocks->frame, clocks->neighbours};
    rc_motion_of(motion, &path, placement);
}

rigcal_real rc_times_after(const rigcal_rig *rig, int32_t camera, size_t placement,
                           size_t view, rigcal_real from)
{
    rigcal_rig_clocks *const clocks = rig->clocks;
    rigcal_clock_memory *const memory = &clocks->memory;
    rigcal_real stamp = clocks->times[placement];
    if (clocks->view_times != NULL &&
        RC_FABS(clocks->view_times[view]) <= RC_COORDINATE_MAX) {
        stamp = clocks->view_times[view];
    }
    memory->since = stamp - memory->middle;
    const rigcal_real after = stamp - from + clocks->offsets[camera];
    return (clocks->drifts == NULL) ? after
                                    : after + clocks->drifts[camera] * memory->since;
}

void rc_times_place(rigcal_transform *rig_from_placement, const rigcal_rig *rig,
                    int32_t camera, size_t placement, size_t view)
{
    const rigcal_rig_clocks *const clocks = rig->clocks;
    rigcal_clock_memory *const memory = &rig->clocks->memory;
    const rigcal_motion *motion = &memory->motion;
    rigcal_motion fresh;
    rigcal_real d[6];
    if (memory->placement != (int32_t)placement) {
        rc_times_motion(&fresh, rig, rig->rig_from_placements, placement);
        motion = &fresh;
    }
    memory->since = memory->after = 0;
    if (motion->n > 0) {
        memory->after =
            rc_times_after(rig, camera, placement, view, clocks->instants[placement]);
    }
    rc_motion_at(d, memory->velocity, motion, memory->after);
    if (memory->after > 0 || memory->after < 0) {
        memory->is_moved = 1;
        rc_transform_move(rig_from_placement, d);
    }
}

/* ---- noise of stamps (H11) ----------------------------------------------- */

void rc_times_weigh(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                    const rc_chain *chain, const rigcal_rig *rig)
{
    const rigcal_clock_memory *const memory = &rig->clocks->memory;
    rigcal_real m[6], Hm[6], full[36];
    if (!(memory->ratio2 > 0)) {
        return;
    }
    rc_motion_seen(m, chain, memory->velocity);
    rc_sym6_mul(Hm, H, m);
    const rigcal_real along = rc_vec6_dot(m, g);
    const rigcal_real scale = 1 / (rc_vec6_dot(m, Hm) + memory->ratio2);
    rc_sym6_unpack(full, H);
    for (int k = 0; k < 36; k++) {
        full[k] -= Hm[k / 6] * Hm[k % 6] * scale;
    }
    rc_sym6_pack(H, full);
    for (int k = 0; k < 6; k++) {
        g[k] -= Hm[k] * along * scale;
    }
    *sum -= along * along * scale;
}

/* ---- public -------------------------------------------------------------- */

rigcal_status rigcal_clocks_frames(int32_t frames[], const rigcal_rig_clocks *clocks,
                                   size_t n_cameras)
{
    if (frames == NULL || clocks == NULL || clocks->offsets == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status =
        (n_cameras > RC_COUNT_MAX) ? RIGCAL_ERR_RANGE : rc_check_noise(&clocks->frame);
    if (status == RIGCAL_OK && !(clocks->frame > 0)) {
        status = RIGCAL_ERR_RANGE;
    }
    for (size_t c = 0; status == RIGCAL_OK && c < n_cameras; c++) {
        status = rc_check_numbers(&clocks->offsets[c], 1, FRAMES_MOST * clocks->frame);
    }
    for (size_t c = 0; status == RIGCAL_OK && c < n_cameras; c++) {
        const rigcal_real by = clocks->offsets[c] / clocks->frame;
        frames[c] = (int32_t)((by < 0) ? by - RC(0.5) : by + RC(0.5));
    }
    return status;
}
