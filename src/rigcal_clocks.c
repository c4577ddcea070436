#include "rc_adjust.h"
#include "rc_times.h"

/* ---- constants ----------------------------------------------------------- */

/* part of a frame: a placement stays where its views' mean time has moved by less. */
#define CENTRE_ENOUGH RC(0.01)

/* sigma^2: of a target that stands still the step from a placement to the next has 12, by
 * noise alone. With less than this its velocity is hardly known, and it hardly moves. */
#define STILL RC(100)

/* sigma^2: a step that gains less moves no unknown by more than a tenth of its sigma. */
#define GAIN_ENOUGH RC(0.01)

/* times GAIN_ENOUGH: a search that ends where no step helps, although one promised more, has
 * not converged. */
#define GAIN_LEFT RC(100)

/* part of the diagonal before placements were eliminated: a smaller pivot of a clock is
 * rounding. */
#define RANK_TOL RC_TOL(1e-12, 1e-6)

/* ---- the memory to work in ----------------------------------------------- */

/* Behind that of the rig. */
typedef struct {
    rigcal_real *saved;  /* of each camera, its offset and drift before a step */
    rigcal_real *column; /* of each camera, the first unknown of its clock; -1: none */
    rigcal_real *moved;  /* of each camera, sum of d^T H d, d to the nearest placement */
    rigcal_real *count;  /* of each camera, its views; those with a neighbour in time */
    rigcal_real *w;      /* of each slot, 6: its clock by the placement */
    rigcal_real *z;      /* of each slot, 6: the same by the inverse of the placement's H */
    rigcal_real *since;  /* of each slot, its stamp after the middle */
    rigcal_real *camera; /* of each slot; -1: its view does not count */
} clock_parts;

/* reals: of it a camera. */
enum { PARTS = 20 };

static void clock_parts_of(clock_parts *c, const rc_rig_parts *parts,
                           const rigcal_rig_solver *s)
{
    const size_t n = s->rig->n_cameras;
    c->saved = parts->d + s->n;
    c->column = c->saved + 2 * n;
    c->moved = c->column + n;
    c->count = c->moved + n;
    c->w = c->count + 2 * n;
    c->z = c->w + 6 * n;
    c->since = c->z + 6 * n;
    c->camera = c->since + n;
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

/* Unknowns of a clock that is free. */
static size_t unknowns_of(const rigcal_rig_clocks *clocks)
{
    return (clocks->free_drifts != 0) ? 2 : 1;
}

static int is_held(const rigcal_rig_clocks *clocks, size_t c)
{
    return clocks->held != NULL && clocks->held[c] != 0;
}

/* Of a group in which no clock is held, that of the first camera is. */
static int is_free(const rigcal_rig *rig, size_t c)
{
    int is_first = 1, is_fixed = 0;
    if (rig->clocks->free_offsets == 0 || is_held(rig->clocks, c)) {
        return 0;
    }
    for (size_t other = 0; other < rig->n_cameras; other++) {
        if (rig->group[other] == rig->group[c]) {
            is_first &= other >= c;
            is_fixed |= is_held(rig->clocks, other);
        }
    }
    return is_fixed || !is_first;
}

static void save(const rigcal_rig_solver *s, const clock_parts *c)
{
    const rigcal_rig_clocks *const clocks = s->rig->clocks;
    for (size_t i = 0; i < s->rig->n_cameras; i++) {
        c->saved[2 * i] = clocks->offsets[i];
        c->saved[2 * i + 1] = (clocks->drifts == NULL) ? 0 : clocks->drifts[i];
    }
}

static void restore(const rigcal_rig_solver *s, const clock_parts *c)
{
    const rigcal_rig_clocks *const clocks = s->rig->clocks;
    for (size_t i = 0; i < s->rig->n_cameras; i++) {
        clocks->offsets[i] = c->saved[2 * i];
        if (clocks->drifts != NULL) {
            clocks->drifts[i] = c->saved[2 * i + 1];
        }
    }
}

/* The variance of a pixel: as stated, or of the views by themselves, or `sum` of the rig; 0:
 * unknown. */
static rigcal_real variance_of(const rigcal_rig_solver *s, rigcal_real sum)
{
    const rigcal_real freedom = 2 * real_of(s->n_points) - 6 * real_of(s->n_used);
    const rigcal_real sigma2 = s->rig->sigma_px * s->rig->sigma_px;
    return (sigma2 > 0)     ? sigma2
           : !(freedom > 0) ? 0
           : s->own_sum > 0 ? s->own_sum / freedom
                            : sum / freedom;
}

/* Numbers the unknowns, behind those of the cameras. */
static rigcal_status number(rigcal_rig_solver *s)
{
    const rigcal_rig *const rig = s->rig;
    rigcal_rig_clocks *const clocks = rig->clocks;
    const size_t C = rig->n_cameras, n_cameras = s->n;
    rc_rig_parts parts;
    clock_parts c;
    size_t at = n_cameras;
    for (size_t i = 0; i < C; i++) {
        s->n += is_free(rig, i) ? unknowns_of(clocks) : 0;
    }
    const size_t more = s->n - n_cameras;
    if (rigcal_rig_work(n_cameras / 6, C, rig->n_placements) + more * n_cameras +
            more * (more + 5) / 2 + PARTS * C >
        rig->work_capacity) {
        return RIGCAL_ERR_CAPACITY;
    }
    rc_rig_parts_of(&parts, rig, s->n);
    clock_parts_of(&c, &parts, s);
    for (size_t i = 0; i < C; i++) {
        c.column[i] = is_free(rig, i) ? (rigcal_real)at : -1;
        at += is_free(rig, i) ? unknowns_of(clocks) : 0;
    }
    save(s, &c);
    clocks->memory.ratio2 = 0;
    if (clocks->sigma_time > 0) {
        clocks->memory.ratio2 =
            variance_of(s, 0) / (clocks->sigma_time * clocks->sigma_time);
        return (clocks->memory.ratio2 > 0) ? RIGCAL_OK : RIGCAL_ERR_RANGE;
    }
    return RIGCAL_OK;
}

/* ---- the equations of the clocks (H5) ------------------------------------ */

/* Of an unknown of the clock of a slot, the offset or the drift, by its offset. */
static rigcal_real part_of(const clock_parts *c, size_t slot, size_t which)
{
    return (which > 0) ? c->since[slot] : 1;
}

/* The first unknown of the clock of a slot that has one. */
static size_t unknown_of(const clock_parts *c, size_t slot)
{
    return (size_t)c->column[(size_t)c->camera[slot]];
}

static int has_clock(const clock_parts *c, size_t slot)
{
    return c->camera[slot] >= 0 && c->column[(size_t)c->camera[slot]] >= 0;
}

/* Adds a view to the equations of its clock: E = H m, Q = m^T H m and q = m^T g. */
static void add(const rigcal_rig_solver *s, const rc_rig_parts *parts, const clock_parts *c,
                const rigcal_real g[6], const rigcal_real H[21], const rc_chain *chain)
{
    const rigcal_clock_memory *const memory = &s->rig->clocks->memory;
    const size_t slot = s->view - s->first, at = unknown_of(c, slot);
    const rigcal_real camera = parts->column[(size_t)c->camera[slot]];
    rigcal_real m[6], Hm[6], across[6];
    rc_motion_seen(m, chain, memory->velocity);
    rc_sym6_mul(Hm, H, m);
    c->since[slot] = memory->since;
    rc_mat3_tmul_vec3(&c->w[6 * slot], chain->R_c, Hm);
    rc_mat3_tmul_vec3(&c->w[6 * slot + 3], chain->R_c, &Hm[3]);
    rc_vec3_cross(across, chain->lever, &Hm[3]);
    rc_vec3_add(across, Hm);
    rc_vec3_copy(&across[3], &Hm[3]);
    const rigcal_real Q = rc_vec6_dot(m, Hm), q = rc_vec6_dot(m, g);
    for (size_t i = 0; i < unknowns_of(s->rig->clocks); i++) {
        rigcal_real *const row = &parts->S[rc_packed_at(at + i, 0)];
        const rigcal_real part = part_of(c, slot, i);
        parts->g[at + i] += part * q;
        parts->d[at + i] += part * part * Q;
        for (size_t j = 0; j <= i; j++) {
            row[at + j] += part * part_of(c, slot, j) * Q;
        }
        for (size_t k = 0; camera >= 0 && k < 6; k++) {
            row[(size_t)camera + k] += part * across[k];
        }
    }
}

/* H_p^-1 w of the clock of a slot, and what its right side loses: (H_p^-1 w) g_p. */
static void eliminate_right(const rigcal_rig_solver *s, const rc_rig_parts *parts,
                            const clock_parts *c, size_t slot)
{
    const rc_sym6_factor *const L = (const rc_sym6_factor *)(const void *)s->Hp;
    rigcal_real *const z = &c->z[6 * slot];
    for (size_t k = 0; k < 6; k++) {
        z[k] = c->w[6 * slot + k];
    }
    rc_sym6_forward(z, L);
    const rigcal_real lost = rc_vec6_dot(z, s->gp); /* L^-1 g_p */
    rc_sym6_backward(z, L);
    for (size_t i = 0; i < unknowns_of(s->rig->clocks); i++) {
        parts->g[unknown_of(c, slot) + i] -= part_of(c, slot, i) * lost;
    }
}

/* row[k] -= part lost[k] */
static void subtract(rigcal_real row[], rigcal_real part, const rigcal_real lost[],
                     size_t n)
{
    for (size_t k = 0; k < n; k++) {
        row[k] -= part * lost[k];
    }
}

/* What the clock of slot a has in common with the camera and the clock of slot b, as both
 * depend on the placement. */
static void eliminate_pair(const rigcal_rig_solver *s, const rc_rig_parts *parts,
                           const clock_parts *c, size_t a, size_t b)
{
    const size_t n = unknowns_of(s->rig->clocks), at = unknown_of(c, a);
    const rigcal_real *const z = &c->z[6 * a];
    const rigcal_real *const W = &parts->W[36 * b];
    const int is_free_camera = parts->slot[b] >= 0;
    const int is_lower = has_clock(c, b) && unknown_of(c, b) <= at;
    rigcal_real by_camera[6], by_clock[2];
    for (size_t k = 0; is_free_camera && k < 6; k++) {
        by_camera[k] = rc_vec6_dot(z, &W[6 * k]);
    }
    if (is_lower) {
        by_clock[0] = rc_vec6_dot(z, &c->w[6 * b]);
        by_clock[1] = c->since[b] * by_clock[0];
    }
    for (size_t i = 0; i < n; i++) {
        rigcal_real *const row = &parts->S[rc_packed_at(at + i, 0)];
        const rigcal_real part = part_of(c, a, i);
        if (is_free_camera) {
            subtract(&row[(size_t)parts->slot[b]], part, by_camera, 6);
        }
        if (is_lower) { /* of its own clock the lower triangle */
            subtract(&row[unknown_of(c, b)], part, by_clock, (a == b) ? i + 1 : n);
        }
    }
}

/* All clocks of the placement against slot s->row, of whose camera W is as it was added. */
static void eliminate(const rigcal_rig_solver *s, const rc_rig_parts *parts,
                      const clock_parts *c)
{
    const size_t count = rc_rig_views_of(parts, s->placement);
    for (size_t slot = 0; slot < count; slot++) {
        if (has_clock(c, slot)) {
            if (s->row == 0) {
                eliminate_right(s, parts, c, slot);
            }
            eliminate_pair(s, parts, c, slot, s->row);
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

/* Row s->row, if it is that of a clock of camera i: whether it can be factored. */
static void try_row(rigcal_rig_solver *s, const rc_rig_parts *parts, const clock_parts *c,
                    size_t i)
{
    rigcal_real *const row = &parts->S[rc_packed_at(s->row, 0)], *const kept = parts->W;
    if (!(c->column[i] >= 0) || s->row < (size_t)c->column[i] ||
        s->row >= (size_t)c->column[i] + unknowns_of(s->rig->clocks)) {
        return;
    }
    for (size_t k = 0; k <= s->row; k++) {
        kept[k] = row[k];
    }
    if (!rc_packed_factor_row(parts->S, s->row, RANK_TOL * parts->d[s->row])) {
        s->rig->clocks->states[i] = RIGCAL_CLOCK_UNTESTABLE;
        hold_unknown(s, parts, s->row);
        return;
    }
    for (size_t k = 0; k <= s->row; k++) {
        row[k] = kept[k];
    }
}

static int32_t state_of(const rigcal_rig_solver *s, const clock_parts *c, size_t i)
{
    const rigcal_real seen = c->count[2 * i], moving = c->count[2 * i + 1];
    return !(seen > 0)                                                ? RIGCAL_CLOCK_UNSEEN
           : !(c->column[i] >= 0)                                     ? RIGCAL_CLOCK_HELD
           : !(moving > 0)                                            ? RIGCAL_CLOCK_ALONE
           : !(c->moved[i] > STILL * variance_of(s, s->sum) * moving) ? RIGCAL_CLOCK_STILL
                                                                      : RIGCAL_CLOCK_FREE;
}

/* All views have been added: which clocks something is known of. Where views are of another
 * instant than their placement, the motion lags by a step, so that the last digits of the
 * sum need not fall. */
static void choose_clocks(rigcal_rig_solver *s, const rc_rig_parts *parts,
                          const clock_parts *c)
{
    rigcal_rig_clocks *const clocks = s->rig->clocks;
    s->n_clocks = 0;
    for (size_t i = 0; i < s->rig->n_cameras; i++) {
        clocks->states[i] = state_of(s, c, i);
        for (size_t k = 0; c->column[i] >= 0 && k < unknowns_of(clocks); k++) {
            s->n_clocks++;
            if (clocks->states[i] != RIGCAL_CLOCK_FREE) {
                hold_unknown(s, parts, (size_t)c->column[i] + k);
            }
        }
    }
    if (s->n_clocks > 0 || clocks->memory.is_moved != 0) {
        s->negligible =
            rc_max(s->negligible, GAIN_ENOUGH * s->sum / (2 * real_of(s->n_points)));
    }
}

/* ---- a pass -------------------------------------------------------------- */

/* (H10): the mean time of the views of placement f, or RC_MAX. */
static rigcal_real mean_time(const rigcal_rig_solver *s, size_t f, size_t begin, size_t end)
{
    const rigcal_rig *const rig = s->rig;
    rigcal_real sum = 0, count = 0, first = 0;
    for (size_t v = begin; v < end; v++) {
        rigcal_rig_view view;
        const rigcal_real stamp = rc_times_stamp(rig->clocks, f, v);
        if (!rc_rig_is_left_out(rig, v) && rc_times_is_known(stamp) &&
            rc_rig_view_at(&view, rig, v) == RIGCAL_OK) {
            const rigcal_real time = rc_times_of(rig->clocks, stamp, (size_t)view.camera);
            first = (count > 0) ? first : time;
            sum += time - first;
            count += 1;
        }
    }
    return (count > 0) ? first + sum / count : RC_MAX;
}

/* Placement f, with its pose, at that time. */
static void centre(const rigcal_rig_solver *s, const rc_rig_parts *parts, size_t f,
                   rigcal_real time)
{
    const rigcal_rig *const rig = s->rig;
    rigcal_real *const instant = &rig->clocks->instants[f];
    rigcal_transform *const pose = &rig->rig_from_placements[f];
    if (s->evals < 2) { /* the first pass: poses are as they were handed in */
        *instant = time;
    } else if (RC_FABS(time - *instant) > CENTRE_ENOUGH * rig->clocks->frame) {
        rigcal_real d[6];
        rigcal_motion motion;
        rc_path path;
        rc_times_path(&path, rig, rig->rig_from_placements);
        rc_motion_of(&motion, &path, f);
        rc_motion_at(d, NULL, &motion, time - *instant);
        rc_motion_move(pose, d);
        *instant = time;
    }
    parts->saved[rig->n_cameras + f] = *pose;
}

/* Before the views of a pass are read: one placement at its instant. A pass that tries no
 * step is where the last step that helped ended. */
static void centring_step(const rigcal_rig_solver *s, const rc_rig_parts *parts,
                          const clock_parts *c)
{
    rigcal_clock_memory *const memory = &s->rig->clocks->memory;
    const size_t f = (size_t)memory->next, begin = (size_t)memory->view;
    const size_t end = begin + rc_rig_views_of(parts, f);
    if (f == 0) {
        if (!s->is_trial && !s->is_last) {
            restore(s, c);
        }
        rc_clear(c->moved, 3 * s->rig->n_cameras);
        memory->is_moved = 0;
    }
    centre(s, parts, f, mean_time(s, f, begin, end));
    memory->view = (int32_t)end;
    memory->next++;
    if ((size_t)memory->next == s->rig->n_placements) {
        memory->next = memory->view = 0;
        memory->pass = s->evals;
        memory->placement = -1;
    }
}

/* The motion of the placement that comes next, by where the last step began. */
static void begin_placement(const rigcal_rig_solver *s, const rc_rig_parts *parts,
                            const clock_parts *c)
{
    rigcal_clock_memory *const memory = &s->rig->clocks->memory;
    rc_path path;
    rc_times_path(&path, s->rig, &parts->saved[s->rig->n_cameras]);
    rc_motion_of(&memory->motion, &path, s->placement);
    rc_motion_at(memory->step, NULL, &memory->motion, memory->motion.nearest);
    memory->placement = (int32_t)s->placement;
    memory->is_first = 1;
    for (size_t slot = 0; slot < s->rig->n_cameras; slot++) {
        c->camera[slot] = -1;
    }
}

/* Counts a view. The first one of a placement tells by how much that moves, for all. */
static void count_view(const rigcal_rig_solver *s, const rc_rig_parts *parts,
                       const clock_parts *c, const rigcal_real H[21], const rc_chain *chain,
                       int32_t camera)
{
    rigcal_clock_memory *const memory = &s->rig->clocks->memory;
    rigcal_real *const count = &c->count[2 * camera];
    if (memory->is_first != 0) {
        rigcal_real m[6], Hm[6];
        rc_motion_seen(m, chain, memory->step);
        rc_sym6_mul(Hm, H, m);
        memory->moved = rc_vec6_dot(m, Hm) * real_of(rc_rig_views_of(parts, s->placement));
        memory->is_first = 0;
    }
    c->camera[s->view - s->first] = (rigcal_real)camera;
    c->moved[camera] += memory->moved;
    count[0] += 1;
    count[1] += (memory->motion.n > 0) ? 1 : 0;
}

/* A view by its points, at its time. */
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

static rigcal_status equations(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                               rc_chain *chain, int32_t *camera, const rigcal_rig_solver *s)
{
    const int is_reducing = s->phase == RC_RIG_REDUCING;
    rc_rig_parts parts;
    clock_parts c;
    const rigcal_status status = (s->timed == &rc_given_points)
                                     ? equations_of_points(sum, g, H, chain, camera, s)
                                     : s->timed->equations(sum, g, H, chain, camera, s);
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_rig_parts_of(&parts, s->rig, s->n);
    clock_parts_of(&c, &parts, s);
    if (is_reducing) {
        count_view(s, &parts, &c, H, chain, *camera);
    }
    rc_times_weigh(sum, g, H, chain, s->rig);
    if (is_reducing && has_clock(&c, s->view - s->first)) {
        add(s, &parts, &c, g, H, chain);
    }
    return RIGCAL_OK;
}

/* ---- the search ---------------------------------------------------------- */

static void move(const rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    rigcal_rig_clocks *const clocks = s->rig->clocks;
    clock_parts c;
    clock_parts_of(&c, parts, s);
    rc_rig_move(s, parts);
    for (size_t i = 0; i < s->rig->n_cameras; i++) {
        if (c.column[i] >= 0) {
            clocks->offsets[i] += parts->g[(size_t)c.column[i]];
            if (unknowns_of(clocks) > 1) {
                clocks->drifts[i] += parts->g[(size_t)c.column[i] + 1];
            }
        }
    }
}

/* Before the views of a placement. 1: it was a unit of its own. */
static int prepare_view(rigcal_rig_solver *s, const rc_rig_parts *parts,
                        const clock_parts *c)
{
    if (s->rig->clocks->memory.pass != s->evals) {
        centring_step(s, parts, c);
        return 1;
    }
    begin_placement(s, parts, c);
    return 0;
}

static void prepare_row(rigcal_rig_solver *s, const rc_rig_parts *parts,
                        const clock_parts *c)
{
    if (s->row == 0) {
        save(s, c); /* the last step helped */
    }
    for (size_t i = 0; s->row < s->n && i < s->rig->n_cameras; i++) {
        try_row(s, parts, c, i);
    }
}

/* What comes before a unit of the search. 1: it was a unit itself. */
static int prepare(rigcal_rig_solver *s)
{
    const rigcal_clock_memory *const memory = &s->rig->clocks->memory;
    rc_rig_parts parts;
    clock_parts c;
    const int is_view = s->phase == RC_RIG_SETTLING || s->phase == RC_RIG_REDUCING;
    if (is_view && memory->pass == s->evals && memory->placement == (int32_t)s->placement) {
        return 0;
    }
    rc_rig_parts_of(&parts, s->rig, s->n);
    clock_parts_of(&c, &parts, s);
    if (is_view) {
        return prepare_view(s, &parts, &c);
    }
    if (s->phase == RC_RIG_ELIMINATING) {
        eliminate(s, &parts, &c);
    } else if (s->phase == RC_RIG_PRIORS && s->row == 0) {
        choose_clocks(s, &parts, &c);
    } else if (s->phase == RC_RIG_FACTORING) {
        prepare_row(s, &parts, &c);
    }
    return 0;
}

static void step(rigcal_rig_solver *s)
{
    if (s->phase == RC_RIG_CHECKED) {
        const rigcal_status status = number(s);
        if (status != RIGCAL_OK) {
            rc_rig_end(s, status, -1);
            return;
        }
    } else if (s->phase != RC_RIG_CHECKING && prepare(s)) {
        return;
    }
    rc_rig_step(s);
    if (s->phase == RC_RIG_DONE) {
        rigcal_clock_memory *const memory = &s->rig->clocks->memory;
        memory->placement = -1;
        if (s->search.status == RIGCAL_OK && s->n_clocks > 0 &&
            s->promised > GAIN_LEFT * s->negligible) {
            s->search.status = RIGCAL_BUDGET_SPENT;
        }
    }
}

static const struct rigcal_rig_given TIMED = {rc_rig_check_points, equations, step, move,
                                              0};

static rigcal_status begin(rigcal_rig_solver *s)
{
    rigcal_clock_memory *const memory = &s->rig->clocks->memory;
    const rigcal_status status = rc_times_check(s->rig);
    if (status != RIGCAL_OK) {
        *s = (rigcal_rig_solver){0}; /* it has not begun */
        return status;
    }
    memory->placement = -1;
    memory->pass = memory->next = memory->view = 0;
    s->timed = s->given;
    s->given = &TIMED;
    return RIGCAL_OK;
}

static const struct rigcal_clock_calls CALLS = {begin, rc_times_place, rc_times_weigh};

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
    for (size_t c = 0; c < rig->n_cameras; c++) {
        at += (parts.column[c] >= 0) ? 6 : 0;
    }
    for (size_t c = 0; c < rig->n_cameras; c++) {
        rigcal_real sigma[2] = {0, 0};
        for (size_t i = 0; is_free(rig, c) && i < unknowns_of(rig->clocks); i++) {
            if (rig->clocks->states[c] == RIGCAL_CLOCK_FREE) {
                sigma[i] = sigma_px * RC_SQRT(parts.S[rc_packed_at(at, at)]);
            }
            at++;
        }
        offsets[c] = sigma[0];
        if (drifts != NULL) {
            drifts[c] = sigma[1];
        }
    }
    return RIGCAL_OK;
}
