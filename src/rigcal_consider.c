#include "rc_border.h"
#include "rc_intrinsics.h"
#include "rc_joint.h"
#include "rc_motion.h"
#include "rc_views.h"

enum {
    DONE = 1,
    ADDING,      /* adds a view */
    ELIMINATING, /* eliminates a placement, after all its views */
    SOLVING      /* computes a row of the effects */
};

size_t rigcal_consider_work(size_t n_free, size_t n_cameras)
{
    return RIGCAL_CONSIDER_WORK(n_free, n_cameras);
}

size_t rigcal_consider_clocks_work(size_t n_cameras)
{
    return RIGCAL_CONSIDER_CLOCKS_WORK(n_cameras);
}

/* ---- which of the intrinsics ------------------------------------------------ */

/* Deviations of the intrinsics, in the order of RC_BY_FOCAL and so on. */
static void deviations_of(rigcal_real sigma[RC_INTRINSICS], const rigcal_rig *rig, size_t c)
{
    if (rig->intrinsics_sigmas == NULL) {
        rc_clear(sigma, RC_INTRINSICS);
        return;
    }
    const rigcal_intrinsics_sigma *const s = &rig->intrinsics_sigmas[c];
    sigma[RC_BY_FOCAL] = s->focal;
    sigma[RC_BY_ASPECT] = s->aspect;
    sigma[RC_BY_CENTRE] = sigma[RC_BY_CENTRE + 1] = s->centre;
    sigma[RC_BY_K1] = s->k1;
    sigma[RC_BY_K2] = s->k2;
}

/* Number of columns of the cameras before c. */
static size_t columns_before(const rigcal_rig *rig, size_t c)
{
    size_t n = 0;
    for (size_t before = 0; before < c; before++) {
        rigcal_real sigma[RC_INTRINSICS];
        deviations_of(sigma, rig, before);
        for (int i = 0; i < RC_INTRINSICS; i++) {
            n += sigma[i] > 0;
        }
    }
    return n;
}

/* ---- one view --------------------------------------------------------------- */

/* What a view adds for each of the intrinsics, not yet times its deviation. */
typedef struct {
    rigcal_real E[RC_INTRINSICS][6]; /* J^T D */
    rigcal_real Q[RC_INTRINSICS];    /* D^T D */
    rigcal_real own[RC_INTRINSICS];  /* D^T D, the view's own pose eliminated */
} shares;

/* E[p] += D_p (q x b, b), where b is a row of B, and Q[p] += D_p^2. */
static void add_row(shares *by, const rigcal_real q[3], const rigcal_real b[3],
                    const rigcal_real D[RC_INTRINSICS], rigcal_real weight)
{
    rigcal_real turn[3];
    rc_vec3_cross(turn, q, b);
    for (int p = 0; p < RC_INTRINSICS; p++) {
        rc_vec3_add_scaled(&by->E[p][0], weight * D[p], turn);
        rc_vec3_add_scaled(&by->E[p][3], weight * D[p], b);
        by->Q[p] += weight * D[p] * D[p];
    }
}

/* A view at cam_from_target: H = J^T J, and E and Q of each of the intrinsics, by the
 * weights that its points have by the loss. */
static rigcal_status add_points(rigcal_real H[21], shares *by, const rigcal_points *points,
                                const rigcal_transform *cam_from_target, int32_t loss,
                                rigcal_real sigma_px)
{
    static const rigcal_real NO_ERROR[2] = {0, 0};
    const rigcal_camera *const camera = points->view.camera;
    rigcal_real g[6];
    rc_rigid_clear(g, H);
    *by = (shares){0};
    for (size_t i = 0; i < points->view.n; i++) {
        rigcal_real x[2], uv[2], B[6], q[3], X_c[3], D[2 * RC_INTRINSICS];
        const rigcal_real weight =
            rc_rig_weight(points, cam_from_target, i, loss, sigma_px);
        if (!(weight > 0)) {
            continue;
        }
        rc_points_place(q, X_c, points, cam_from_target, i);
        const rigcal_status status = rc_project_by(x, uv, B, camera, X_c);
        if (status != RIGCAL_OK) {
            return status;
        }
        rc_rigid_add(g, H, B, q, NO_ERROR, weight, NULL, 0);
        rc_intrinsics(D, camera, x, uv);
        add_row(by, q, &B[0], &D[0], weight);
        add_row(by, q, &B[3], &D[RC_INTRINSICS], weight);
    }
    return RIGCAL_OK;
}

/* Eliminates the view's own pose from Q. Where its points do not fix a pose, no error is
 * left. */
static void eliminate_own(shares *by, const rigcal_real H[21])
{
    rc_sym6_factor L;
    if (!rc_sym6_factor_of(&L, H, 0)) {
        return;
    }
    for (int p = 0; p < RC_INTRINSICS; p++) {
        rigcal_real y[6];
        for (int i = 0; i < 6; i++) {
            y[i] = by->E[p][i];
        }
        rc_sym6_forward(y, &L);
        by->own[p] = by->Q[p] - rc_vec6_dot(y, y);
    }
}

/* (H11): eliminates the noise of the view's stamp from H, E and Q. m is its (w, dt) a
 * second. */
static void weigh(rigcal_real H[21], shares *by, const rigcal_real m[6], rigcal_real ratio2)
{
    rigcal_real Hm[6], full[36];
    rc_sym6_mul(Hm, H, m);
    const rigcal_real scale = 1 / (rc_vec6_dot(m, Hm) + ratio2);
    rc_sym6_unpack(full, H);
    for (int i = 0; i < 36; i++) {
        full[i] -= scale * Hm[i / 6] * Hm[i % 6];
    }
    rc_sym6_pack(H, full);
    for (int p = 0; p < RC_INTRINSICS; p++) {
        const rigcal_real mE = rc_vec6_dot(m, by->E[p]), along = scale * mE;
        rc_vec3_add_scaled(&by->E[p][0], -along, &Hm[0]);
        rc_vec3_add_scaled(&by->E[p][3], -along, &Hm[3]);
        by->Q[p] -= along * mE;
    }
}

/* Evaluates view `index`, with the poses and clocks as they are. m is its (w, dt) a second,
 * 0 if there are no clocks. */
static rigcal_status evaluate(rc_chain *chain, rigcal_real m[6], rigcal_real H[21],
                              shares *by, const rigcal_rig_view *v, const rigcal_rig *rig,
                              size_t index, int32_t loss)
{
    rigcal_points points;
    rigcal_status status = rc_rig_points(&points, v);
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_rig_chain(chain, rig, v->camera, (size_t)v->placement, index);
    status = add_points(H, by, &points, &chain->cam_from_target, loss, rig->sigma_px);
    eliminate_own(by, H);
    rc_clear(m, 6);
    if (rig->clocks != NULL) {
        rc_motion_seen(m, chain, rig->clocks->memory.velocity);
        if (rig->clocks->memory.ratio2 > 0) {
            weigh(H, by, m, rig->clocks->memory.ratio2);
        }
    }
    return status;
}

/* ---- clocks ------------------------------------------------------------------ */

/* Number of unknowns after those of the cameras: all offsets, then all drifts. A held clock
 * has unknowns too, but they are fixed. */
static size_t unknowns_of_clocks(const rigcal_rig *rig)
{
    const rigcal_rig_clocks *const clocks = rig->clocks;
    return (clocks == NULL || clocks->free_offsets == 0) ? 0
           : (clocks->free_drifts != 0)                  ? 2 * rig->n_cameras
                                                         : rig->n_cameras;
}

/* Numbers of each view of the placement, in the memory behind Z: its clock by the
 * placement; its stamp less the middle of the recording; the unknown of the clock's offset,
 * below 0 if it is fixed. */
enum { SLOT_SINCE = 6, SLOT_COLUMN = 7, SLOT = 8 };

static rigcal_real *slots_of(const rc_border *b)
{
    return &b->Z[6 * b->k];
}

/* Adds the clock of the view that was added last. m is its (w, dt) a second, H its
 * equations. */
static void begin_slot(rc_border *b, const rc_chain *chain, const rigcal_rig *rig,
                       size_t camera, const rigcal_real m[6], const rigcal_real H[21])
{
    rigcal_real *const slot = &slots_of(b)[SLOT * (b->count - 1)];
    const size_t n = unknowns_of_clocks(rig);
    rigcal_real Hm[6];
    slot[SLOT_COLUMN] = -1;
    if (n > 0 && rig->clocks->states[camera] == RIGCAL_CLOCK_FREE) {
        rc_sym6_mul(Hm, H, m);
        rc_mat3_tmul_vec3(&slot[0], chain->R_c, &Hm[0]);
        rc_mat3_tmul_vec3(&slot[3], chain->R_c, &Hm[3]);
        slot[SLOT_SINCE] = rig->clocks->memory.since;
        slot[SLOT_COLUMN] = (rigcal_real)(b->n - n + camera);
    }
}

/* Adds `by` to T of a column at the offset of a slot's clock, and `since` times as much at
 * its drift. */
static void add_by_clock(rc_border *b, const rigcal_rig *rig, const rigcal_real slot[SLOT],
                         size_t column, rigcal_real by)
{
    if (slot[SLOT_COLUMN] >= 0) {
        rigcal_real *const T = &b->T[b->n * column + (size_t)slot[SLOT_COLUMN]];
        T[0] += by;
        if (unknowns_of_clocks(rig) > rig->n_cameras) {
            T[rig->n_cameras] += slot[SLOT_SINCE] * by;
        }
    }
}

/* Eliminates the placement from the clocks, after rc_border_eliminate. */
static void eliminate_clocks(rc_border *b, const rigcal_rig *rig)
{
    const rc_sym6_factor *const L = (const rc_sym6_factor *)(const void *)b->Hp;
    for (size_t i = 0; i < b->count; i++) {
        rigcal_real *const slot = &slots_of(b)[SLOT * i];
        rc_sym6_forward(slot, L);
        for (size_t column = 0; column < b->k; column++) {
            add_by_clock(b, rig, slot, column, -rc_vec6_dot(slot, &b->Z[6 * column]));
        }
    }
}

/* ---- a view of a placement ----------------------------------------------------- */

/* Adds a view to the current placement, unless it is left out. Also adds its D^T D to *sum,
 * and what of this is left with its own pose to *own_sum. */
static rigcal_status add_view(rc_border *b, rigcal_real *sum, rigcal_real *own_sum,
                              const rigcal_rig *rig, size_t index, size_t placement,
                              int32_t loss)
{
    rigcal_rig_view v;
    shares by;
    rigcal_real g[6] = {0, 0, 0, 0, 0, 0}, m[6], H[21], by_view[21];
    rigcal_real sigma[RC_INTRINSICS];
    rc_chain chain;
    rc_rig_parts parts;
    if (rc_rig_is_left_out(rig, index)) {
        return RIGCAL_OK;
    }
    if (b->count >= rig->n_cameras) {
        return RIGCAL_ERR_STATE;
    }
    rigcal_status status = rc_rig_view_at(&v, rig, index);
    if (status == RIGCAL_OK && (size_t)v.placement != placement) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK) {
        status = evaluate(&chain, m, H, &by, &v, rig, index, loss);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    const size_t c = (size_t)v.camera;
    const int has_clocks = rig->clocks != NULL && b->T != NULL;
    for (int i = 0; i < 21; i++) {
        by_view[i] = H[i];
    }
    rc_rig_parts_of(&parts, rig, 0);
    rc_border_view(b, &chain, parts.column[c], g, H);
    if (has_clocks) {
        begin_slot(b, &chain, rig, c, m, by_view);
    }
    size_t column = columns_before(rig, c);
    deviations_of(sigma, rig, c);
    for (int p = 0; p < RC_INTRINSICS; p++) {
        if (sigma[p] > 0) {
            for (int i = 0; i < 6; i++) {
                by.E[p][i] *= sigma[p];
            }
            *sum += sigma[p] * sigma[p] * by.Q[p];
            *own_sum += sigma[p] * sigma[p] * by.own[p];
            rc_border_add(b, &chain, column, by.E[p]);
            if (has_clocks) {
                add_by_clock(b, rig, &slots_of(b)[SLOT * (b->count - 1)], column,
                             rc_vec6_dot(m, by.E[p]));
            }
            column++;
        }
    }
    return RIGCAL_OK;
}

/* ---- every covariance -------------------------------------------------------- */

/* Sigma += v v^T */
static void add_outer(rigcal_real Sigma[36], const rigcal_real v[6])
{
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++) {
            Sigma[6 * i + j] += v[i] * v[j];
        }
    }
}

/* v += scale W^T G of a column, summed over all cameras on which v depends. */
static void add_leverage(rigcal_real v[6], const rc_leverage *on, const rigcal_real G[],
                         rigcal_real scale)
{
    for (size_t i = 0; i < on->count; i++) {
        for (size_t row = 0; row < 6 && on->at[i] >= 0; row++) {
            const rigcal_real by = scale * G[(size_t)on->at[i] + row];
            const rigcal_real *const w = &on->W[36 * i + 6 * row];
            rc_vec3_add_scaled(&v[0], by, &w[0]);
            rc_vec3_add_scaled(&v[3], by, &w[3]);
        }
    }
}

static void considered_pair(rigcal_real Sigma[36], const rigcal_transform *b_from_a,
                            const rigcal_rig *rig, size_t a, size_t b)
{
    const rigcal_considered *const all = rig->considered;
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, rig, 0);
    rigcal_real W[72], at[2] = {parts.column[a], parts.column[b]};
    const rc_leverage hanging = {NULL, W, at, 2}, *const on = &hanging;
    rc_joint_steps_of_pair(W, b_from_a, &rig->cams_from_rig[a]);
    for (size_t j = 0; j < all->k; j++) {
        rigcal_real v[6] = {0, 0, 0, 0, 0, 0};
        add_leverage(v, on, &all->effects[all->n * j], 1);
        add_outer(Sigma, v);
    }
}

static void considered_camera(rigcal_real Sigma[36], const rigcal_rig *rig, size_t camera)
{
    const rigcal_considered *const all = rig->considered;
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, rig, 0);
    const rigcal_real at = parts.column[camera];
    for (size_t j = 0; j < all->k && at >= 0; j++) {
        add_outer(Sigma, &all->effects[all->n * j + (size_t)at]);
    }
}

static void considered_joint(rigcal_real S[], const rigcal_rig *rig)
{
    const rigcal_considered *const all = rig->considered;
    for (size_t j = 0; j < all->k; j++) {
        const rigcal_real *const G = &all->effects[all->n * j];
        for (size_t row = 0; row < all->n; row++) {
            for (size_t column = 0; column <= row; column++) {
                S[rc_packed_at(row, column)] += G[row] * G[column];
            }
        }
    }
}

/* Adds all views of a placement. `first` is its first view. */
static rigcal_status add_views(rc_border *b, const rigcal_rig *rig, size_t first,
                               size_t count, size_t placement)
{
    rigcal_status status = RIGCAL_OK;
    rigcal_real sum = 0, own_sum = 0; /* not used */
    for (size_t i = first; i < first + count && status == RIGCAL_OK; i++) {
        status = add_view(b, &sum, &own_sum, rig, i, placement, rig->considered->loss);
    }
    return status;
}

/* Covariance of a placement from the intrinsics. One deviation of a column moves it by H^-1
 * (B^T E - sum of W_i^T G_i). */
static rigcal_status considered_placement(rigcal_real Sigma[36], const rigcal_rig *rig,
                                          size_t first, size_t count, size_t placement)
{
    const rigcal_considered *const all = rig->considered;
    rc_rig_parts parts;
    rigcal_real inverse[36];
    rc_border b = {0};
    rc_rig_parts_of(&parts, rig, 0);
    b.k = all->k;
    b.Z = &all->effects[all->n * all->k];
    b.W = parts.W;
    b.slot = parts.slot;
    rc_clear(Sigma, 36);
    if (columns_before(rig, rig->n_cameras) != all->k) {
        return RIGCAL_ERR_STATE;
    }
    rc_border_next(&b);
    const rigcal_status status = add_views(&b, rig, first, count, placement);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!rc_sym6_invert(inverse, b.Hp)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    const rc_leverage on = {NULL, b.W, b.slot, b.count};
    if (all->factor != NULL) {
        rc_border_mix(b.Z, 6, all->factor, all->k);
    }
    for (size_t j = 0; j < all->k; j++) {
        rigcal_real *const Z = &b.Z[6 * j], v[6];
        add_leverage(Z, &on, &all->effects[all->n * j], -1);
        for (int i = 0; i < 6; i++) {
            v[i] = rc_vec3_dot(&inverse[6 * i], &Z[0]) +
                   rc_vec3_dot(&inverse[6 * i + 3], &Z[3]);
        }
        add_outer(Sigma, v);
    }
    return RIGCAL_OK;
}

static const struct rigcal_considering CONSIDERING = {
    considered_camera, considered_pair, considered_joint, considered_placement};

/* ---- the pass ----------------------------------------------------------------- */

static void end(rigcal_consider_solver *s, rigcal_status status, int32_t at_fault)
{
    s->status = status;
    s->at_fault = at_fault;
    s->phase = DONE;
}

/* Begins the first placement that was seen, from s->placement on, or ends the pass. */
static void begin_placement(rigcal_consider_solver *s)
{
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, s->rig, 0);
    while (s->placement < s->rig->n_placements && !(parts.count[s->placement] > 0)) {
        s->view += rc_rig_views_of(&parts, s->placement);
        s->placement++;
    }
    s->first = s->view;
    rc_border_next(&s->border);
    s->phase = (s->placement < s->rig->n_placements) ? ADDING : SOLVING;
}

static void adding_step(rigcal_consider_solver *s)
{
    rc_rig_parts parts;
    const rigcal_status status = add_view(&s->border, &s->sum, &s->own_sum, s->rig, s->view,
                                          s->placement, s->considered->loss);
    if (status != RIGCAL_OK) {
        end(s, status, (int32_t)s->view);
        return;
    }
    rc_rig_parts_of(&parts, s->rig, 0);
    s->view++;
    if (s->view - s->first == rc_rig_views_of(&parts, s->placement)) {
        s->phase = ELIMINATING;
    }
}

static void eliminating_step(rigcal_consider_solver *s)
{
    if (!rc_border_eliminate(&s->border)) {
        end(s, RIGCAL_ERR_DEGENERATE, (int32_t)s->view - 1);
        return;
    }
    if (s->rig->clocks != NULL) {
        eliminate_clocks(&s->border, s->rig);
    }
    for (size_t i = 0; i < 6 * s->border.k; i++) {
        s->sum -= s->border.Z[i] * s->border.Z[i];
    }
    s->placement++;
    begin_placement(s);
}

/* Turns a row of T into a row of G, and drops the clocks' part. */
static void solving_step(rigcal_consider_solver *s)
{
    rc_border *const b = &s->border;
    const size_t n_cameras = b->n - unknowns_of_clocks(s->rig);
    rc_rig_parts parts;
    if (s->column < b->k) {
        rc_rig_parts_of(&parts, s->rig, b->n);
        rc_border_effect(parts.g, b, parts.S, s->column);
        for (size_t i = 0; i < b->n; i++) {
            s->sum -= b->T[b->n * s->column + i] * parts.g[i];
        }
        for (size_t i = 0; i < n_cameras; i++) {
            b->T[n_cameras * s->column + i] = parts.g[i];
        }
        s->column++;
        return;
    }
    s->considered->by = &CONSIDERING;
    s->considered->n = n_cameras;
    s->considered->k = b->k;
    s->considered->factor = NULL;
    s->considered->sum = s->sum;
    s->considered->own_sum = s->own_sum;
    s->rig->considered = s->considered;
    end(s, RIGCAL_OK, -1);
}

static void step(rigcal_consider_solver *s)
{
    switch (s->phase) {
    case ADDING:
        adding_step(s);
        break;
    case ELIMINATING:
        eliminating_step(s);
        break;
    default:
        solving_step(s);
        break;
    }
}

static rigcal_status check_deviations(const rigcal_rig *rig)
{
    rigcal_status status = RIGCAL_OK;
    for (size_t c = 0; c < rig->n_cameras && status == RIGCAL_OK; c++) {
        rigcal_real sigma[RC_INTRINSICS];
        deviations_of(sigma, rig, c);
        status = rc_check_numbers(sigma, RC_INTRINSICS, RC_PIXEL_MAX);
        for (int i = 0; i < RC_INTRINSICS && status == RIGCAL_OK; i++) {
            status = (sigma[i] >= 0) ? RIGCAL_OK : RIGCAL_ERR_RANGE;
        }
    }
    return status;
}

/* Checks the arguments. *n: number of unknowns of the cameras and clocks. */
static rigcal_status check(size_t *n, const rigcal_considered *considered, rigcal_rig *rig)
{
    rigcal_real Sigma[36];
    rc_rig_parts parts;
    rigcal_status status = (considered == NULL || considered->effects == NULL)
                               ? RIGCAL_ERR_NULL
                               : rigcal_rig_covariance(Sigma, rig, 0, 0);
    if (status == RIGCAL_OK && rig->views == NULL && rig->view_source == NULL) {
        status = RIGCAL_ERR_NULL;
    }
    if (status == RIGCAL_OK) {
        status = check_deviations(rig);
    }
    if (status == RIGCAL_OK &&
        (considered->loss < 0 || considered->loss > RIGCAL_LOSS_TRUNCATED ||
         (considered->loss > 0 && !(rig->sigma_px > 0)))) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    *n = 0;
    rc_rig_parts_of(&parts, rig, 0);
    for (size_t c = 0; c < rig->n_cameras; c++) {
        *n += (parts.column[c] >= 0) ? 6 : 0;
    }
    *n += unknowns_of_clocks(rig);
    const size_t slots = (rig->clocks == NULL) ? 0 : SLOT * rig->n_cameras;
    return (considered->capacity < (*n + 6) * columns_before(rig, rig->n_cameras) + slots)
               ? RIGCAL_ERR_CAPACITY
               : RIGCAL_OK;
}

rigcal_status rigcal_consider_begin(rigcal_consider_solver *solver,
                                    rigcal_considered *considered, rigcal_rig *rig)
{
    rc_rig_parts parts;
    size_t n;
    if (solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (rig != NULL) {
        rig->considered = NULL;
    }
    const rigcal_status status = check(&n, considered, rig);
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_rig_parts_of(&parts, rig, 0);
    *solver = (rigcal_consider_solver){0};
    solver->rig = rig;
    solver->considered = considered;
    rc_border *const b = &solver->border;
    b->n = n;
    b->k = columns_before(rig, rig->n_cameras);
    b->T = considered->effects;
    b->Z = &b->T[b->n * b->k];
    b->W = parts.W;
    b->slot = parts.slot;
    rc_border_begin(b);
    begin_placement(solver);
    return RIGCAL_OK;
}

rigcal_status rigcal_consider_step(rigcal_consider_solver *solver, int32_t budget)
{
    const rigcal_status status =
        rc_check_step((solver == NULL) ? NULL : &solver->phase, budget);
    if (status != RIGCAL_OK) {
        return status;
    }
    for (; budget > 0 && solver->phase != DONE; budget--) {
        step(solver);
    }
    return (solver->phase == DONE) ? RIGCAL_OK : RIGCAL_RUNNING;
}

rigcal_status rigcal_consider_result(int32_t *at_fault,
                                     const rigcal_consider_solver *solver)
{
    const int is_done = solver != NULL && solver->phase == DONE;
    if (at_fault != NULL) {
        *at_fault = is_done ? solver->at_fault : -1;
    }
    if (solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    return is_done ? solver->status : RIGCAL_ERR_STATE;
}

/* ---- the fit ------------------------------------------------------------------ */

rigcal_status rigcal_considered_fit(rigcal_rig_fit *out, const rigcal_rig_fit *fit,
                                    const rigcal_rig *rig)
{
    if (out == NULL || fit == NULL || rig == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_real numbers[] = {fit->sum, fit->freedom,         fit->sigma_px,
                                   fit->F,   fit->freedom_between, fit->freedom_within};
    if (!rc_all_finite(numbers, 6)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    const rigcal_considered *const all = rig->considered;
    rigcal_rig_fit left = *fit;
    if (all != NULL) {
        left.sum = rc_max(0, fit->sum - all->sum);
        left.sigma_px = (fit->freedom > 0) ? RC_SQRT(left.sum / fit->freedom) : 0;
    }
    /* The views by themselves have the sum `sum` freedom_within / by_own. */
    const rigcal_real by_own = fit->freedom_within + fit->F * fit->freedom_between;
    const rigcal_real scale = fit->sum * fit->freedom_between;
    if (all != NULL && scale > 0) {
        left.F = rc_max(0, fit->F - (all->sum - all->own_sum) * by_own / scale);
    }
    *out = left;
    return RIGCAL_OK;
}

rigcal_status rigcal_rig_consider(rigcal_considered *considered, int32_t *at_fault,
                                  rigcal_rig *rig)
{
    rigcal_consider_solver solver;
    if (at_fault != NULL) {
        *at_fault = -1;
    }
    const rigcal_status status = rigcal_consider_begin(&solver, considered, rig);
    if (status != RIGCAL_OK) {
        return status;
    }
    while (rigcal_consider_step(&solver, 100) == RIGCAL_RUNNING) {
    }
    return rigcal_consider_result(at_fault, &solver);
}
