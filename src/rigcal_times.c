#include "rc_times.h"

/* ---- constants ----------------------------------------------------------- */

/* s: a longer step from one placement to the next is none of frames that follow each other.
 * Three frames a second are too few for the target's motion to be known. */
#define FRAME_LONGEST RC(0.35)

/* frames: the longest step of a run. More than one and a half, for stamps that are uneven;
 * less than two, for the curve through a gap is not known well enough. */
#define STEP_LONGEST RC(1.6)

/* part of a frame: times whose own rounding is more say nothing of clocks. */
#define ROUNDING_MOST RC(0.001)

/* frames: a camera is not off by more. Frame numbers fit an int32_t. */
#define FRAMES_MOST RC(1e6)

/* halvings: of the search of the middle step. It is then exact to float's rounding. */
enum { HALVINGS = 24 };

/* ---- what is handed in --------------------------------------------------- */

int rc_times_is_known(rigcal_real time)
{
    return RC_FABS(time) <= RC_COORDINATE_MAX;
}

/* NaN is no stamp, and right. */
static rigcal_status check_stamps(const rigcal_real times[], size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const rigcal_real size = RC_FABS(times[i]);
        if (size > RC_COORDINATE_MAX) {
            return rc_is_finite(size) ? RIGCAL_ERR_RANGE : RIGCAL_ERR_NOT_FINITE;
        }
    }
    return RIGCAL_OK;
}

/* Times that are known rise. Their first, and their last. */
static rigcal_status check_order(rigcal_real ends[2], const rigcal_real times[], size_t n)
{
    int is_first = 1;
    for (size_t f = 0; f < n; f++) {
        if (!rc_times_is_known(times[f])) {
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

/* How many steps from one time that is known to the next are at most `limit`. */
static size_t count_steps(const rigcal_real times[], size_t n, rigcal_real limit)
{
    rigcal_real last = RC_MAX;
    size_t count = 0;
    for (size_t f = 0; f < n; f++) {
        if (rc_times_is_known(times[f])) {
            count += times[f] > last && times[f] - last <= limit;
            last = times[f];
        }
    }
    return count;
}

/* The middle one of the steps up to FRAME_LONGEST; that, where there is none. */
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

static rigcal_status check_clocks(const rigcal_rig_clocks *clocks, size_t n_cameras)
{
    for (size_t c = 0; c < n_cameras; c++) {
        rigcal_status status = rc_check_numbers(&clocks->offsets[c], 1, RC_COORDINATE_MAX);
        if (status == RIGCAL_OK && clocks->drifts != NULL) {
            status = rc_check_numbers(&clocks->drifts[c], 1, 1);
        }
        if (status != RIGCAL_OK) {
            return status;
        }
    }
    const rigcal_status status = rc_check_noise(&clocks->sigma_time);
    if (status != RIGCAL_OK) {
        return status;
    }
    return (clocks->neighbours < 1 || clocks->neighbours > RIGCAL_MOTION_MOST)
               ? RIGCAL_ERR_RANGE
               : rc_check_noise(&clocks->frame);
}

rigcal_status rc_times_check(const rigcal_rig *rig)
{
    rigcal_rig_clocks *const clocks = rig->clocks;
    rigcal_real ends[2] = {0, 0};
    if (clocks->times == NULL || clocks->instants == NULL || clocks->offsets == NULL ||
        clocks->states == NULL || (clocks->free_drifts != 0 && clocks->drifts == NULL)) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = check_clocks(clocks, rig->n_cameras);
    if (status == RIGCAL_OK) {
        status = check_stamps(clocks->times, rig->n_placements);
    }
    if (status == RIGCAL_OK && clocks->view_times != NULL) {
        status = check_stamps(clocks->view_times, rig->n_views);
    }
    if (status == RIGCAL_OK) {
        status = check_order(ends, clocks->times, rig->n_placements);
    }
    if (status != RIGCAL_OK) {
        return status;
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

/* ---- the time of a view -------------------------------------------------- */

rigcal_real rc_times_stamp(const rigcal_rig_clocks *clocks, size_t placement, size_t view)
{
    return (clocks->view_times != NULL && rc_times_is_known(clocks->view_times[view]))
               ? clocks->view_times[view]
               : clocks->times[placement];
}

rigcal_real rc_times_of(const rigcal_rig_clocks *clocks, rigcal_real stamp, size_t camera)
{
    const rigcal_real drift = (clocks->drifts == NULL) ? 0 : clocks->drifts[camera];
    return stamp + clocks->offsets[camera] + drift * (stamp - clocks->memory.middle);
}

void rc_times_path(rc_path *path, const rigcal_rig *rig, const rigcal_transform poses[])
{
    path->poses = poses;
    path->times = rig->clocks->instants;
    path->count = NULL; /* of a placement that is not seen the instant is unknown */
    path->n = rig->n_placements;
    path->longest = STEP_LONGEST * rig->clocks->frame;
    path->neighbours = rig->clocks->neighbours;
}

/* ---- where a view sees its placement (H3) -------------------------------- */

void rc_times_place(rigcal_transform *rig_from_placement, const rigcal_rig *rig,
                    int32_t camera, size_t placement, size_t view)
{
    rigcal_rig_clocks *const clocks = rig->clocks;
    rigcal_clock_memory *const memory = &clocks->memory;
    const rigcal_real stamp = rc_times_stamp(clocks, placement, view);
    const rigcal_motion *motion = &memory->motion;
    rigcal_motion fresh;
    rigcal_real d[6];
    if (memory->placement != (int32_t)placement) {
        rc_path path;
        rc_times_path(&path, rig, rig->rig_from_placements);
        rc_motion_of(&fresh, &path, placement);
        motion = &fresh;
    }
    rc_clear(memory->velocity, 6);
    memory->since = 0;
    if (motion->n == 0 || !rc_times_is_known(stamp)) {
        return;
    }
    memory->since = stamp - memory->middle;
    const rigcal_real after =
        rc_times_of(clocks, stamp, (size_t)camera) - clocks->instants[placement];
    rc_motion_at(d, memory->velocity, motion, after);
    if (after > 0 || after < 0) {
        memory->is_moved = 1;
        rc_motion_move(rig_from_placement, d);
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
    const rigcal_real scale = 1 / (rc_vec6_dot(m, Hm) + memory->ratio2);
    const rigcal_real along = rc_vec6_dot(m, g);
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
