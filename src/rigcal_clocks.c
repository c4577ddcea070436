#include "rc_adjust.h"
#include "rc_times.h"

/* ---- constants ----------------------------------------------------------- */

/* sigma^2: noise alone makes the squared step between two placements of a resting target 12
 * in the mean. Below this the velocity is hardly known, and the target hardly moves. */
#define STILL RC(100)

/* sigma^2: a step that gains less moves no unknown by more than a tenth of its sigma. */
#define GAIN_ENOUGH RC(0.01)

/* times GAIN_ENOUGH: a search has not converged if no step helps although the last one
 * promised more than this. */
#define GAIN_LEFT RC(100)

/* part of the diagonal before placements were eliminated: added to the diagonal of each
 * clock. A clock that the data do not separate from other clocks then stays where it is. */
#define DAMPING RC_TOL(1e-9, 1e-5)

/* ---- the memory to work in ----------------------------------------------- */

/* Memory behind that of the rig. The unknowns of the clocks follow those of the cameras:
 * first all offsets, then all drifts, in the order of the cameras. */
typedef struct {
    rigcal_real *saved;  /* 2 a camera: the values before a step */
    rigcal_real *moved;  /* of each camera: sum of d^T H d, d to the nearest placement */
    rigcal_real *count;  /* of each camera: its views whose placement has a neighbour */
    rigcal_real *w;      /* of each slot, 6: its clock by the placement */
    rigcal_real *since;  /* of each slot: its stamp less the middle of the recording */
    rigcal_real *camera; /* of each slot: its camera */
    rigcal_real *z;      /* of each slot, 6: w times the inverse of the placement's H */
    size_t at, n;        /* first unknown of the clocks; unknowns of a clock */
} clock_parts;

/* reals: that a camera takes of this memory. */
enum { PARTS = 18 };

static void clock_parts_of(clock_parts *c, const rc_rig_parts *parts,
                           const rigcal_rig_solver *s)
{
    const rigcal_rig_clocks *const clocks = s->rig->clocks;
    const size_t n = s->rig->n_cameras;
    c->n = (clocks->free_offsets == 0) ? 0 : (clocks->free_drifts == 0) ? 1 : 2;
    c->at = s->n - c->n * n;
    c->saved = parts->d + s->n;
    c->moved = c->saved + 2 * n;
    c->count = c->moved + n;
    c->w = c->count + n;
    c->since = c->w + 6 * n;
    c->camera = c->since + n;
    c->z = c->camera + n;
}

size_t rigcal_clocks_work(size_t n_free, size_t n_cameras)
{
    return RIGCAL_CLOCKS_WORK(n_free, n_cameras);
}

static rigcal_real real_of(size_t n)
{
    return (rigcal_real)(int32_t)n;
}

/* ---- what is unknown ----------------------------------------------------- */

/* Whether a clock is free. If no clock of a group is held, that of its first camera is
 * held. */
static int is_free(const rigcal_rig *rig, size_t c)
{
    const uint8_t *const held = rig->clocks->held;
    int is_fixed = 0;
    for (size_t other = 0; other < rig->n_cameras; other++) {
        if (rig->group[other] == rig->group[c]) {
            is_fixed |= other < c || (held != NULL && held[other] != 0);
        }
    }
    return is_fixed && rig->clocks->free_offsets != 0 && (held == NULL || held[c] == 0);
}

/* Saves the offsets and drifts that are unknowns, restores them, or moves them by the
 * step. */
enum { SAVE, RESTORE, MOVE };

static void values(const rigcal_rig_solver *s, const rc_rig_parts *parts, int what)
{
    const rigcal_rig_clocks *const clocks = s->rig->clocks;
    const size_t n = s->rig->n_cameras;
    clock_parts c;
    clock_parts_of(&c, parts, s);
    for (size_t i = 0; i < c.n * n; i++) {
        rigcal_real *const value = (i < n) ? &clocks->offsets[i] : &clocks->drifts[i - n];
        if (what == SAVE) {
            c.saved[i] = *value;
        } else {
            *value = (what == MOVE) ? *value + parts->g[c.at + i] : c.saved[i];
        }
    }
}

/* The variance of a pixel [px^2]: the stated one, or that of the views at their own poses,
 * or else that of `sum`, the rig's sum of squares. Returns 0 if it is unknown. */
static rigcal_real variance_of(const rigcal_rig_solver *s, rigcal_real sum)
{
    const rigcal_real freedom = 2 * real_of(s->n_points) - 6 * real_of(s->n_used);
    const rigcal_real sigma2 = s->rig->sigma_px * s->rig->sigma_px;
    if (sigma2 > 0 || !(freedom > 0)) {
        return sigma2;
    }
    return ((s->own_sum > 0) ? s->own_sum : sum) / freedom;
}

/* Numbers the unknowns of the clocks, after the input was checked. */
static rigcal_status number(rigcal_rig_solver *s)
{
    const rigcal_rig *const rig = s->rig;
    rigcal_rig_clocks *const clocks = rig->clocks;
    const size_t n = rig->n_cameras;
    rc_rig_parts parts;
    clock_parts c;
    rc_rig_parts_of(&parts, rig, s->n);
    clock_parts_of(&c, &parts, s);
    s->n += c.n * n;
    if (rigcal_rig_work(0, n, rig->n_placements) + s->n * (s->n + 5) / 2 + PARTS * n >
        rig->work_capacity) {
        return RIGCAL_ERR_CAPACITY;
    }
    for (size_t i = 0; i < n; i++) {
        clocks->states[i] = is_free(rig, i) ? RIGCAL_CLOCK_FREE : RIGCAL_CLOCK_HELD;
    }
    rc_rig_parts_of(&parts, rig, s->n);
    values(s, &parts, SAVE);
    clocks->memory.ratio2 = 0;
    if (clocks->sigma_time > 0) {
        clocks->memory.ratio2 =
            variance_of(s, 0) / (clocks->sigma_time * clocks->sigma_time);
        return (clocks->memory.ratio2 > 0) ? RIGCAL_OK : RIGCAL_ERR_RANGE;
    }
    return RIGCAL_OK;
}

/* ---- the equations of the clocks (H5) ------------------------------------ */

/* Adds a view to the equations of its clock: E = H m, Q = m^T H m and q = m^T g. Those of
 * the drift are `since` times as large. */
static void add(const rigcal_rig_solver *s, const rc_rig_parts *parts, const clock_parts *c,
                const rigcal_real g[6], const rigcal_real H[21], const rc_chain *chain)
{
    const rigcal_clock_memory *const memory = &s->rig->clocks->memory;
    const size_t slot = s->view - s->first, camera = (size_t)c->camera[slot];
    rigcal_real *const w = &c->w[6 * slot];
    rigcal_real m[6], E[6], part = 1;
    rc_motion_seen(m, chain, memory->velocity);
    rc_sym6_mul(E, H, m);
    const rigcal_real Q = rc_vec6_dot(m, E), q = rc_vec6_dot(m, g);
    c->since[slot] = memory->since;
    rc_mat3_tmul_vec3(w, chain->R_c, E); /* B^T E, then A^T E */
    rc_mat3_tmul_vec3(&w[3], chain->R_c, &E[3]);
    rc_vec3_cross(m, chain->lever, &E[3]);
    rc_vec3_add(E, m);
    for (size_t i = 0; i < c->n; i++) {
        const size_t at = c->at + i * s->rig->n_cameras + camera;
        rigcal_real *const row = &parts->S[rc_packed_at(at, 0)];
        parts->g[at] += part * q;
        parts->d[at] += part * part * Q;
        row[c->at + camera] += part * Q;
        row[at] += (i > 0) ? part * part * Q : 0;
        row[at] += DAMPING * part * part * Q;
        if (parts->column[camera] >= 0) {
            rigcal_real *const to = &row[(size_t)parts->column[camera]];
            for (size_t k = 0; k < 6; k++) {
                to[k] += part * E[k];
            }
        }
        part = memory->since;
    }
}

/* Computes H_p^-1 w of the clock of a slot. Subtracts (H_p^-1 w) g_p from the clock's right
 * side. */
static void eliminate_right(const rigcal_rig_solver *s, const rc_rig_parts *parts,
                            const clock_parts *c, size_t slot)
{
    const rc_sym6_factor *const L = (const rc_sym6_factor *)(const void *)s->Hp;
    rigcal_real *const g = &parts->g[c->at + (size_t)c->camera[slot]];
    rigcal_real *const z = &c->z[6 * slot];
    for (size_t k = 0; k < 6; k++) {
        z[k] = c->w[6 * slot + k];
    }
    rc_sym6_forward(z, L);
    const rigcal_real lost = rc_vec6_dot(z, s->gp); /* s->gp is L^-1 g_p */
    rc_sym6_backward(z, L);
    g[0] -= lost;
    if (c->n > 1) {
        g[s->rig->n_cameras] -= c->since[slot] * lost;
    }
}

/* Subtracts what the clock of slot a shares, through the placement, with the camera and the
 * clock of slot b. W of the camera must still be as it was added. */
static void eliminate_pair(const rigcal_rig_solver *s, const rc_rig_parts *parts,
                           const clock_parts *c, size_t a, size_t b)
{
    const size_t n = s->rig->n_cameras;
    const size_t other = c->at + (size_t)c->camera[b];
    const rigcal_real *const z = &c->z[6 * a], *W = &parts->W[36 * b];
    const rigcal_real clock = rc_vec6_dot(z, &c->w[6 * b]);
    size_t at = c->at + (size_t)c->camera[a];
    rigcal_real part = 1;
    for (size_t i = 0; i < c->n; i++) {
        rigcal_real *const row = &parts->S[rc_packed_at(at, 0)];
        if (parts->slot[b] >= 0) {
            rigcal_real *const to = &row[(size_t)parts->slot[b]];
            for (size_t k = 0; k < 6; k++) {
                to[k] -= part * rc_vec6_dot(z, &W[6 * k]);
            }
        }
        if (other <= at) { /* only the lower triangle is kept */
            row[other] -= part * clock;
        }
        if (i > 0 && other + n <= at) {
            row[other + n] -= part * c->since[b] * clock;
        }
        at += n;
        part = c->since[a];
    }
}

/* Eliminates all clocks of the placement against slot s->row. */
static void eliminate(const rigcal_rig_solver *s, const rc_rig_parts *parts,
                      const clock_parts *c)
{
    const size_t count = rc_rig_views_of(parts, s->placement);
    for (size_t a = 0; a < count; a++) {
        if (s->rig->clocks->states[(size_t)c->camera[a]] != RIGCAL_CLOCK_HELD) {
            if (s->row == 0) {
                eliminate_right(s, parts, c, a);
            }
            eliminate_pair(s, parts, c, a, s->row);
        }
    }
}

/* ---- clocks that are held after all -------------------------------------- */

/* Holds an unknown: clears its row and right side, so that its step is 0. */
static void hold(const rigcal_rig_solver *s, const rc_rig_parts *parts, size_t at)
{
    for (size_t i = 0; i < s->n; i++) {
        parts->S[rc_packed_of(i, at)] = 0;
    }
    parts->S[rc_packed_at(at, at)] = parts->d[at] = 1;
    parts->g[at] = 0;
}

/* Chooses the clocks on which the data have information, after all views have been added.
 * If views have other times than their placement, the motion lags by a step. Then the last
 * digits of the sum need not fall, and a larger gain counts as negligible. */
static void choose_clocks(rigcal_rig_solver *s, const rc_rig_parts *parts,
                          const clock_parts *c)
{
    const rigcal_rig_clocks *const clocks = s->rig->clocks;
    const rigcal_real still = STILL * variance_of(s, s->sum);
    s->n_clocks = 0;
    for (size_t i = 0; i < s->rig->n_cameras; i++) {
        int32_t *const state = &clocks->states[i];
        if (*state != RIGCAL_CLOCK_HELD) {
            *state = !(c->count[i] > 0)                  ? RIGCAL_CLOCK_ALONE
                     : c->moved[i] > still * c->count[i] ? RIGCAL_CLOCK_FREE
                                                         : RIGCAL_CLOCK_STILL;
        }
        for (size_t k = 0; k < c->n; k++) {
            if (*state == RIGCAL_CLOCK_FREE) {
                s->n_clocks++;
            } else {
                hold(s, parts, c->at + k * s->rig->n_cameras + i);
            }
        }
    }
    s->is_lagging = 0;
    if (s->n_clocks > 0 || clocks->memory.is_moved != 0) {
        s->is_lagging = s->is_trial;
        s->negligible =
            rc_max(s->negligible, GAIN_ENOUGH * s->sum / (2 * real_of(s->n_points)));
    }
}

/* ---- a pass -------------------------------------------------------------- */

/* Finds the motion at the next placement, from the poses where the last step began. A pass
 * that tries no step is at the end of the last step that helped. */
static void begin_placement(const rigcal_rig_solver *s, const rc_rig_parts *parts,
                            const clock_parts *c)
{
    rigcal_clock_memory *const memory = &s->rig->clocks->memory;
    rigcal_real velocity[6];
    if (memory->pass != s->evals) {
        memory->pass = s->evals;
        rc_clear(c->moved, 2 * s->rig->n_cameras); /* clears count, too */
        if (!s->is_trial && !s->is_last) {
            values(s, parts, RESTORE);
        }
        if (s->evals == 1) {
            for (size_t f = 0; f < s->rig->n_placements; f++) {
                parts->saved[s->rig->n_cameras + f] = s->rig->rig_from_placements[f];
            }
        }
    }
    rc_clear(c->w, 8 * s->rig->n_cameras); /* clears since and camera, too */
    rc_times_motion(&memory->motion, s->rig, &parts->saved[s->rig->n_cameras],
                    s->placement);
    rc_motion_at(memory->step, velocity, &memory->motion, memory->motion.t[0]);
    memory->placement = (int32_t)s->placement;
    memory->views = memory->late = 0;
}

/* Counts a view. The first view of a placement gives the move of the placement, which all
 * its views use. */
static void count_view(const rigcal_rig_solver *s, const rc_rig_parts *parts,
                       const clock_parts *c, const rigcal_real H[21], const rc_chain *chain,
                       int32_t camera)
{
    rigcal_clock_memory *const memory = &s->rig->clocks->memory;
    if (!(memory->views > 0)) {
        rigcal_real m[6], Hm[6];
        rc_motion_seen(m, chain, memory->step);
        rc_sym6_mul(Hm, H, m);
        memory->moved = rc_vec6_dot(m, Hm) * real_of(rc_rig_views_of(parts, s->placement));
    }
    memory->views += 1;
    memory->late += memory->after;
    c->camera[s->view - s->first] = (rigcal_real)camera;
    c->moved[camera] += memory->moved;
    c->count[camera] += (memory->motion.n > 0) ? 1 : 0;
}

/* (H10): moves the placement, and the pose where the next step begins, to the mean time of
 * its views. A placement without neighbours stays at its stamp. */
static void centre(const rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    const rigcal_rig *const rig = s->rig;
    const rigcal_clock_memory *const memory = &rig->clocks->memory;
    rigcal_real *const instant = &rig->clocks->instants[s->placement];
    const rigcal_real mean = memory->late / memory->views;
    rigcal_real d[6], velocity[6];
    if (memory->motion.n == 0) {
        *instant = rig->clocks->times[s->placement];
    } else if (mean > 0 || mean < 0) {
        *instant += mean;
        rc_motion_at(d, velocity, &memory->motion, mean);
        rc_transform_move(&rig->rig_from_placements[s->placement], d);
        rc_transform_move(&parts->saved[rig->n_cameras + s->placement], d);
    }
}

/* The equations of a view from its points, at the view's time. */
static rigcal_status equations_of_points(rigcal_real *sum, rigcal_real g[6],
                                         rigcal_real H[21], rc_chain *chain,
                                         int32_t *camera, const rigcal_rig_solver *s)
{
    rigcal_rig_view v;
    const rigcal_status status = rc_rig_view_at(&v, s->rig, s->view);
    if (status != RIGCAL_OK) {
        return status;
    }
    *camera = v.camera;
    rc_rig_chain(chain, s->rig, v.camera, s->placement, s->view);
    return rc_rig_equations(sum, g, H, &v, &chain->cam_from_target);
}

static rigcal_status equations_timed(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                                     rc_chain *chain, int32_t *camera,
                                     const rigcal_rig_solver *s)
{
    rc_rig_parts parts;
    clock_parts c;
    const rigcal_status status = (s->timed == &rc_given_points)
                                     ? equations_of_points(sum, g, H, chain, camera, s)
                                     : s->timed->equations(sum, g, H, chain, camera, s);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (s->phase == RC_RIG_REDUCING) {
        rc_rig_parts_of(&parts, s->rig, s->n);
        clock_parts_of(&c, &parts, s);
        count_view(s, &parts, &c, H, chain, *camera);
        rc_times_weigh(sum, g, H, chain, s->rig);
        add(s, &parts, &c, g, H, chain);
    } else {
        rc_times_weigh(sum, g, H, chain, s->rig);
    }
    return RIGCAL_OK;
}

/* ---- the search ---------------------------------------------------------- */

static void move_timed(const rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    rc_rig_move(s, parts);
    values(s, parts, MOVE);
}

/* Prepares the clocks' part of the next unit of the search. */
static void prepare(rigcal_rig_solver *s)
{
    const rigcal_clock_memory *const memory = &s->rig->clocks->memory;
    const int is_view = s->phase == RC_RIG_SETTLING || s->phase == RC_RIG_REDUCING;
    rc_rig_parts parts;
    clock_parts c;
    if (is_view && memory->pass == s->evals && memory->placement == (int32_t)s->placement) {
        return;
    }
    rc_rig_parts_of(&parts, s->rig, s->n);
    clock_parts_of(&c, &parts, s);
    if (is_view) {
        begin_placement(s, &parts, &c);
    } else if (s->phase == RC_RIG_ELIMINATING) {
        if (s->row == 0) {
            centre(s, &parts);
        }
        eliminate(s, &parts, &c);
    } else if (s->phase == RC_RIG_PRIORS && s->row == 0) {
        choose_clocks(s, &parts, &c);
    } else if (s->phase == RC_RIG_FACTORING && s->row == 0) {
        values(s, &parts, SAVE); /* the last step helped */
    }
}

static void step_timed(rigcal_rig_solver *s)
{
    if (s->phase == RC_RIG_CHECKED) {
        const rigcal_status status = number(s);
        if (status != RIGCAL_OK) {
            rc_rig_end(s, status, -1);
            return;
        }
    } else if (s->phase != RC_RIG_CHECKING) {
        prepare(s);
    }
    rc_rig_step(s);
    if (s->phase == RC_RIG_DONE) {
        s->rig->clocks->memory.placement = -1;
        if (s->search.status == RIGCAL_OK && s->n_clocks > 0 &&
            s->promised > GAIN_LEFT * s->negligible) {
            s->search.status = RIGCAL_BUDGET_SPENT;
        }
    }
}

/* Checks a view. The pose of a placement where the search begins is that of the mean time
 * of its views, which is summed here. */
static rigcal_status check_timed(int32_t *camera, int32_t *placement, rigcal_rig_solver *s)
{
    rigcal_rig_clocks *const clocks = s->rig->clocks;
    rigcal_clock_memory *const memory = &clocks->memory;
    const rigcal_status status = rc_rig_check_points(camera, placement, s);
    if (status == RIGCAL_OK && !rc_rig_is_left_out(s->rig, s->view)) {
        const size_t f = (size_t)*placement;
        if (memory->placement != *placement) {
            memory->placement = *placement;
            memory->views = memory->late = 0;
        }
        memory->views += 1;
        memory->late += rc_times_after(s->rig, *camera, f, s->view, clocks->times[f]);
        clocks->instants[f] = clocks->times[f] + memory->late / memory->views;
    }
    return status;
}

static const struct rigcal_rig_given TIMED = {check_timed, equations_timed, step_timed,
                                              move_timed, 0};

static rigcal_status begin_clocks(rigcal_rig_solver *s)
{
    rigcal_clock_memory *const memory = &s->rig->clocks->memory;
    const rigcal_status status = rc_times_check(s->rig);
    if (status != RIGCAL_OK) {
        s->phase = 0; /* the search has not begun */
        return status;
    }
    for (size_t f = 0; f < s->rig->n_placements; f++) {
        s->rig->clocks->instants[f] = RC_MAX; /* until a view of it is checked */
    }
    memory->placement = -1;
    memory->pass = memory->is_moved = 0;
    s->timed = s->given;
    s->given = &TIMED;
    return RIGCAL_OK;
}

static const struct rigcal_clock_calls CALLS = {begin_clocks, rc_times_place,
                                                rc_times_weigh};

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
    if (offsets == NULL || rig == NULL || rig->clocks == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = rigcal_rig_covariance(Sigma, rig, sigma_px, 0);
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_rig_parts_of(&parts, rig, 0);
    const size_t n = rig->n_cameras;
    for (size_t c = 0; c < n; c++) {
        at += (parts.column[c] >= 0) ? 6 : 0;
    }
    for (size_t i = 0; i < ((drifts == NULL) ? n : 2 * n); i++, at++) {
        const int is_known = rig->clocks->states[i % n] == RIGCAL_CLOCK_FREE &&
                             (i < n || rig->clocks->free_drifts != 0);
        rigcal_real *const sigma = (i < n) ? &offsets[i] : &drifts[i - n];
        *sigma = is_known ? sigma_px * RC_SQRT(parts.S[rc_packed_at(at, at)]) : 0;
    }
    return RIGCAL_OK;
}
