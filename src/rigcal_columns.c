#include "rc_columns.h"

extern inline size_t rc_packed_size(size_t n);

/* ---- constants ----------------------------------------------------------- */

/* part of Q: a parameter cannot be seen if less of it is left when all else is free. */
#define RANK_TOL RC_TOL(1e-10, 1e-5)

/* Parts of s->sums. Of each column: Q; q; Q before placements were eliminated; Q and q with
 * each view's own pose free. Then Q across two columns, and the same with each view's own
 * pose free. Then Q across clocks; g of the cameras and clocks; of each camera the stamp of
 * its view in the placement. */
enum {
    Q_OF,
    SLOPE,
    RAW,
    OWN_Q,
    OWN_SLOPE,
    PAIRS,
    OWN_PAIRS,
    CLOCKS,
    GRADIENT,
    SINCE,
    SUMS
};

/* ---- what belongs to a kind ------------------------------------------------- */

static const uint8_t KIND_OF[RC_COLUMNS] = {
    RIGCAL_FAULT_CLOCK,  RIGCAL_FAULT_DRIFT,      RIGCAL_FAULT_SHUTTER,
    RIGCAL_FAULT_FOCAL,  RIGCAL_FAULT_ASPECT,     RIGCAL_FAULT_CENTRE,
    RIGCAL_FAULT_CENTRE, RIGCAL_FAULT_DISTORTION, RIGCAL_FAULT_DISTORTION,
    RIGCAL_FAULT_BENT,   RIGCAL_FAULT_BENT,       RIGCAL_FAULT_STRETCHED};

/* The first parameter of a view that belongs to a kind other than CLOCKS and MOVED. */
static size_t parameter_of(int32_t kind)
{
    size_t p = 0;
    while (KIND_OF[p] != kind) {
        p++;
    }
    return p;
}

int rc_is_of_camera(int32_t kind)
{
    return kind != RIGCAL_FAULT_CLOCKS && kind < RIGCAL_FAULT_BENT;
}

int rc_columns_has(const rigcal_columns *s, int32_t kind)
{
    return (s->kinds & RIGCAL_FAULTS_OF(kind)) != 0;
}

static size_t n_clocks(const rigcal_columns *s)
{
    return (s->per_clock > 0 || rc_columns_has(s, RIGCAL_FAULT_CLOCK) ||
            rc_columns_has(s, RIGCAL_FAULT_CLOCKS))
               ? s->rig->n_cameras
               : 0;
}

int rc_columns_is_free(const rigcal_columns *s, size_t camera)
{
    const rigcal_rig_clocks *const clocks = s->rig->clocks;
    return clocks != NULL && clocks->free_offsets != 0 &&
           clocks->states[camera] == RIGCAL_CLOCK_FREE;
}

size_t rc_columns_n_free(const rigcal_columns *s)
{
    size_t n = 0;
    for (size_t c = 0; c < s->rig->n_cameras; c++) {
        n += (size_t)rc_columns_is_free(s, c);
    }
    return (n > 0 && s->rig->clocks->free_drifts != 0) ? 2 * n : n;
}

static int is_in_pass(const rigcal_columns *s, size_t parameter)
{
    return s->at[parameter] >= 0;
}

static size_t column_of(const rigcal_columns *s, size_t camera, size_t parameter)
{
    return (parameter == RC_BY_CLOCK)
               ? camera
               : n_clocks(s) + (size_t)s->at[parameter] +
                     s->per_camera *
                         ((parameter < RC_OF_CAMERA) ? camera : s->rig->n_cameras);
}

/* The index, in the list of the pairs of all columns, of pair k of this camera's views. */
static size_t pair_of(const rigcal_columns *s, size_t camera, size_t k)
{
    return (k < RC_PAIRS - 1) ? (RC_PAIRS - 1) * camera + k
                              : (RC_PAIRS - 1) * s->rig->n_cameras;
}

/* ---- memory ----------------------------------------------------------------- */

size_t rigcal_faults_work(size_t n_free, size_t n_cameras)
{
    return RIGCAL_FAULTS_WORK(n_free, n_cameras);
}

size_t rigcal_faults_least(size_t n_free, size_t n_cameras)
{
    return RIGCAL_FAULTS_LEAST(n_free, n_cameras);
}

rigcal_real *rc_pool_take(rc_pool *pool, size_t n)
{
    const int which = (n <= pool->left[0]) ? 0 : 1;
    rigcal_real *const at = pool->at[which];
    if (n > pool->left[which]) {
        pool->is_enough = 0;
        return NULL;
    }
    pool->left[which] -= n;
    pool->at[which] += n;
    return at;
}

static size_t larger(size_t a, size_t b)
{
    return (a > b) ? a : b;
}

static void number_columns(rigcal_columns *s)
{
    int32_t rank = 0;
    s->at[RC_BY_CLOCK] = (n_clocks(s) > 0) ? 0 : -1;
    for (size_t p = RC_BY_CLOCK + 1; p < RC_COLUMNS; p++) {
        if (p == RC_OF_CAMERA) {
            s->per_camera = (size_t)rank;
            rank = 0;
        }
        s->at[p] = rc_columns_has(s, KIND_OF[p]) ? rank++ : -1;
    }
    s->border.k = n_clocks(s) + s->per_camera * s->rig->n_cameras + (size_t)rank;
}

/* Number of reals of a part of s->sums. */
static size_t size_of(const rigcal_columns *s, int part)
{
    switch (part) {
    case PAIRS:
    case OWN_PAIRS:
        return (RC_PAIRS - 1) * s->rig->n_cameras + 1;
    case CLOCKS:
        return rc_packed_size(n_clocks(s));
    case GRADIENT:
        return s->border.n;
    case SINCE:
        return (s->per_clock > 1) ? s->rig->n_cameras : 0;
    default:
        return s->border.k;
    }
}

void rc_columns_lay_out(rigcal_columns *s, rc_pool *pool, size_t room)
{
    const size_t n_cameras = s->rig->n_cameras, n_free = rc_columns_n_free(s);
    s->per_clock = (n_free == 0) ? 0 : (s->rig->clocks->free_drifts == 0) ? 1 : 2;
    s->border.n = s->n + s->per_clock * n_cameras;
    const size_t n = s->border.n;
    number_columns(s);
    const size_t k = s->border.k;
    const size_t test = n + rc_packed_size(larger(n_cameras, 2)) + 4 * larger(n_cameras, 2);
    s->border.Z = rc_pool_take(pool, larger(larger(6 * k, test), room * n));
    s->border.T = rc_pool_take(pool, k * n);
    for (int i = 0; i < SUMS; i++) {
        s->sums[i] = rc_pool_take(pool, size_of(s, i));
    }
}

void rc_columns_begin(rigcal_columns *s)
{
    rc_border_begin(&s->border);
    for (int i = 0; i < SUMS; i++) {
        rc_clear(s->sums[i], size_of(s, i));
    }
}

/* ---- sums ---------------------------------------------------------------------- */

static rigcal_real dot(const rigcal_real a[], const rigcal_real b[], size_t n)
{
    rigcal_real sum = 0;
    for (size_t i = 0; i < n; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

void rc_columns_add_clock(const rigcal_columns *s, rigcal_real of[], size_t stride,
                          size_t camera, rigcal_real x)
{
    if (rc_columns_is_free(s, camera)) {
        of[stride * camera] += x;
        if (s->per_clock > 1) {
            of[stride * (s->rig->n_cameras + camera)] += s->sums[SINCE][camera] * x;
        }
    }
}

void rc_columns_add_gradient(rigcal_columns *s, rigcal_real at, const rigcal_real g[6])
{
    for (size_t k = 0; at >= 0 && k < 6; k++) {
        s->sums[GRADIENT][(size_t)at + k] += g[k];
    }
}

void rc_columns_add(rigcal_columns *s, const rc_evidence *v, const rc_chain *chain,
                    size_t camera, rigcal_real since, const rigcal_real g[6])
{
    rigcal_real E[6], Q, q, along, other;
    if (s->per_clock > 1) {
        s->sums[SINCE][camera] = since;
    }
    rc_columns_add_clock(s, &s->sums[GRADIENT][s->n], 1, camera,
                         v->left * v->q[RC_BY_CLOCK]);
    rc_columns_add_gradient(s, s->border.slot[s->border.count - 1], g);
    for (size_t p = 0; p < RC_COLUMNS; p++) {
        if (is_in_pass(s, p)) {
            const size_t at = column_of(s, camera, p);
            rc_evidence_weighed(E, &Q, &q, &along, v, p);
            rc_border_add(&s->border, chain, at, E);
            rc_columns_add_clock(s, &s->border.T[s->border.n * at + s->n], 1, camera,
                                 v->left * along);
            s->sums[Q_OF][at] += Q;
            s->sums[RAW][at] += Q;
            s->sums[SLOPE][at] += q;
        }
    }
    for (size_t k = 0; k < RC_PAIRS; k++) {
        const size_t p = rc_pair_first[k];
        along = rc_vec6_dot(v->m, v->E[p]);
        other = rc_vec6_dot(v->m, v->E[p + 1]);
        s->sums[PAIRS][pair_of(s, camera, k)] += v->pairs[k] - v->stamp * along * other;
    }
}

void rc_columns_add_alone(rigcal_columns *s, const rc_evidence *v, size_t camera)
{
    /* The pose of the view is free, and takes up offset and drift: their columns are 0. */
    for (size_t p = RC_BY_SHUTTER; p < RC_COLUMNS; p++) {
        if (is_in_pass(s, p)) {
            const size_t at = column_of(s, camera, p);
            s->sums[OWN_Q][at] += v->Q[p];
            s->sums[OWN_SLOPE][at] += v->q[p];
        }
    }
    for (size_t k = 0; k < RC_PAIRS; k++) {
        s->sums[OWN_PAIRS][pair_of(s, camera, k)] += v->pairs[k];
    }
}

static void eliminate_pairs(rigcal_columns *s)
{
    for (size_t k = 0; k < RC_PAIRS; k++) {
        const size_t p = rc_pair_first[k];
        const size_t n = !is_in_pass(s, p) ? 0 : (p < RC_OF_CAMERA) ? s->rig->n_cameras : 1;
        for (size_t c = 0; c < n; c++) {
            const rigcal_real *const Y = &s->border.Z[6 * column_of(s, c, p)];
            s->sums[PAIRS][pair_of(s, c, k)] -= rc_vec6_dot(Y, &Y[6]);
        }
    }
}

/* Eliminates the placement from the clocks' rows of each column and of g. */
static void eliminate_clocks(rigcal_columns *s)
{
    const rc_border *const b = &s->border;
    for (size_t c = 0; s->per_clock > 0 && c < s->rig->n_cameras; c++) {
        const rigcal_real *const Y = &b->Z[6 * c];
        rc_columns_add_clock(s, &s->sums[GRADIENT][s->n], 1, c, -rc_vec6_dot(Y, b->gp));
        for (size_t i = 0; i < b->k; i++) {
            rc_columns_add_clock(s, &b->T[b->n * i + s->n], 1, c,
                                 -rc_vec6_dot(Y, &b->Z[6 * i]));
        }
    }
}

void rc_columns_eliminate(rigcal_columns *s)
{
    const rc_border *const b = &s->border;
    eliminate_clocks(s);
    for (size_t i = 0; i < b->k; i++) {
        const rigcal_real *const Y = &b->Z[6 * i];
        s->sums[Q_OF][i] -= rc_vec6_dot(Y, Y);
        s->sums[SLOPE][i] -= rc_vec6_dot(Y, b->gp);
        for (size_t j = 0; i < n_clocks(s) && j < i; j++) {
            s->sums[CLOCKS][rc_packed_at(i, j)] -= rc_vec6_dot(Y, &b->Z[6 * j]);
        }
    }
    eliminate_pairs(s);
    for (size_t row = 0; row < 6 * b->count; row++) {
        if (b->slot[row / 6] >= 0) {
            s->sums[GRADIENT][(size_t)b->slot[row / 6] + row % 6] -=
                rc_vec6_dot(&b->W[6 * row], b->gp);
        }
    }
}

/* ---- a fault -------------------------------------------------------------------- */

/* The columns of a fault, and room for its test in the memory of Z. */
typedef struct {
    int32_t kind;
    size_t camera, k;
    rigcal_real *G, *I, *theta, *variance, *turn, *shift;
} trial;

/* Whether CLOCKS has this camera's clock as a parameter: the camera is not the first of its
 * group, and the data show its clock. */
static int is_freed(const rigcal_columns *s, size_t camera)
{
    int is_first = 1;
    for (size_t c = 0; c < camera; c++) {
        is_first &= s->rig->group[c] != s->rig->group[camera];
    }
    return !is_first && s->per_clock == 0 && s->sums[RAW][camera] > 0;
}

static size_t column_at(const rigcal_columns *s, const trial *t, size_t j)
{
    if (t->kind != RIGCAL_FAULT_CLOCKS) {
        return column_of(s, t->camera, parameter_of(t->kind)) + j;
    }
    size_t c = 0;
    while (!is_freed(s, c) || j-- > 0) {
        c++;
    }
    return c;
}

static void begin_trial(trial *t, const rigcal_columns *s, const rigcal_fault *fault)
{
    t->kind = fault->kind;
    t->camera = (size_t)((fault->camera < 0) ? 0 : fault->camera);
    t->k = 0;
    for (size_t p = 0; p < RC_COLUMNS; p++) {
        t->k += KIND_OF[p] == t->kind;
    }
    for (size_t c = 0; t->kind == RIGCAL_FAULT_CLOCKS && c < s->rig->n_cameras; c++) {
        t->k += (size_t)is_freed(s, c);
    }
    t->G = s->border.Z;
    t->I = t->G + s->border.n;
    t->theta = t->I + rc_packed_size(t->k);
    t->variance = t->theta + t->k;
    t->turn = t->variance + t->k;
    t->shift = t->turn + t->k;
}

/* The number of the pair that the two columns of this fault make. */
static size_t pair_at(const rigcal_columns *s, const trial *t)
{
    size_t k = 0;
    while (rc_pair_first[k] != parameter_of(t->kind)) {
        k++;
    }
    return pair_of(s, t->camera, k);
}

static rigcal_real Q_across(const rigcal_columns *s, const trial *t, size_t i, size_t j)
{
    if (i == j) {
        return s->sums[Q_OF][column_at(s, t, i)];
    }
    return (t->kind == RIGCAL_FAULT_CLOCKS)
               ? s->sums[CLOCKS][rc_packed_at(column_at(s, t, i), column_at(s, t, j))]
               : s->sums[PAIRS][pair_at(s, t)];
}

/* Whether camera c has unknowns, and is of the same group as the fault's camera. */
static int is_moved(const rigcal_columns *s, const rc_rig_parts *parts, const trial *t,
                    size_t c)
{
    return parts->column[c] >= 0 && s->rig->group[c] == s->rig->group[t->camera];
}

/* Adds to G what one unit of parameter j does to the cameras through its reference. The
 * reference is the turn w and the shift v of the camera against which the column was taken.
 * If the fault's camera is held, the other cameras of its group move the other way. */
static void add_reference(rigcal_real G[], const rigcal_columns *s,
                          const rc_rig_parts *parts, const trial *t, size_t j)
{
    const rigcal_rig *const rig = s->rig;
    const rigcal_transform *const from = &rig->cams_from_rig[t->camera];
    rigcal_real w[3], v[3], d[6], in_rig[3], in_camera[3];
    if (t->kind == RIGCAL_FAULT_CLOCKS ||
        !rc_evidence_reference(w, v, &s->reference[3 * t->camera],
                               parameter_of(t->kind) + j)) {
        return;
    }
    rc_vec3_copy(&d[0], w);
    rc_vec3_cross(&d[3], w, from->t);
    rc_vec3_add(&d[3], v);
    if (parts->column[t->camera] >= 0) {
        rc_vec3_add(&G[(size_t)parts->column[t->camera]], &d[0]);
        rc_vec3_add(&G[(size_t)parts->column[t->camera] + 3], &d[3]);
        return;
    }
    for (size_t c = 0; c < rig->n_cameras; c++) {
        for (size_t k = 0; is_moved(s, parts, t, c) && k < 6; k += 3) {
            rc_mat3_tmul_vec3(in_rig, from->R, &d[k]);
            rc_mat3_mul_vec3(in_camera, rig->cams_from_rig[c].R, in_rig);
            rc_vec3_add_scaled(&G[(size_t)parts->column[c] + k], -1, in_camera);
        }
    }
}

void rc_columns_most(rigcal_real *turn, rigcal_real *shift, const rigcal_real G[], size_t n)
{
    for (size_t at = 0; at < n; at += 6) {
        *turn = rc_max(*turn, rc_vec3_norm(&G[at]));
        *shift = rc_max(*shift, rc_vec3_norm(&G[at + 3]));
    }
}

int rc_columns_solve(rigcal_real *gain, rigcal_real theta[], rigcal_real variance[],
                     rigcal_real I[], size_t k)
{
    *gain = 0;
    for (size_t i = 0; i < k; i++) {
        if (!(variance[i] > 0) || !rc_packed_factor_row(I, i, RANK_TOL * variance[i])) {
            return 0;
        }
    }
    rc_packed_forward(theta, I, k);
    for (size_t i = 0; i < k; i++) {
        *gain += theta[i] * theta[i];
        rc_packed_invert_row(I, i);
        variance[i] = 0;
    }
    for (size_t i = 0; i < k; i++) { /* theta and variance by L^-T; its columns are the rows
                                        of L^-1 */
        rigcal_real sum = 0;
        for (size_t j = i; j < k; j++) {
            const rigcal_real x = I[rc_packed_at(j, i)];
            sum += x * theta[j];
            variance[i] += x * x;
        }
        theta[i] = sum;
    }
    return 1;
}

/* Computes I and u of (H6), u in theta, and what one unit of each parameter does to the
 * cameras (H13). */
static void reduce(const trial *t, const rigcal_columns *s)
{
    const size_t n = s->border.n;
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, s->rig, 0);
    for (size_t j = 0; j < t->k; j++) {
        const size_t at = column_at(s, t, j);
        rc_border_effect(t->G, &s->border, parts.S, at);
        t->variance[j] = s->sums[RAW][at];
        t->theta[j] = s->sums[SLOPE][at] - dot(t->G, s->sums[GRADIENT], n);
        for (size_t i = j; i < t->k; i++) {
            t->I[rc_packed_at(i, j)] =
                Q_across(s, t, i, j) - dot(t->G, &s->border.T[n * column_at(s, t, i)], n);
        }
        add_reference(t->G, s, &parts, t, j);
        t->turn[j] = t->shift[j] = 0;
        rc_columns_most(&t->turn[j], &t->shift[j], t->G, s->n);
    }
}

/* Solves for theta, gain and variances. Returns 0 if the data cannot show the fault. */
static int solve(rigcal_real *gain, const trial *t, const rigcal_columns *s)
{
    if ((t->kind == RIGCAL_FAULT_CLOCK && s->per_clock > 0) ||
        (t->kind == RIGCAL_FAULT_DRIFT && s->per_clock > 1)) {
        return 0; /* the adjustment has already removed it */
    }
    return t->k > 0 && rc_columns_solve(gain, t->theta, t->variance, t->I, t->k);
}

/* What the views gain from theta with their own poses free (H8). */
static rigcal_real own_gain(const rigcal_columns *s, const trial *t)
{
    rigcal_real gain = 0;
    for (size_t i = 0; i < t->k; i++) {
        const size_t at = column_at(s, t, i);
        gain +=
            t->theta[i] * (2 * s->sums[OWN_SLOPE][at] - t->theta[i] * s->sums[OWN_Q][at]);
    }
    if (t->k == 2 && t->kind != RIGCAL_FAULT_CLOCKS) {
        gain -= 2 * t->theta[0] * t->theta[1] * s->sums[OWN_PAIRS][pair_at(s, t)];
    }
    return gain;
}

/* Writes each clock's value and its deviation. That of camera 0 is never a parameter. */
static void write_clocks(rigcal_real clocks[], const rigcal_columns *s, const trial *t,
                         rigcal_real variance)
{
    size_t j = 0;
    for (size_t c = 1; c < s->rig->n_cameras; c++) {
        if (is_freed(s, c)) {
            clocks[c] = t->theta[j];
            clocks[s->rig->n_cameras + c] = RC_SQRT(t->variance[j++] * variance);
        }
    }
}

void rc_columns_test(rigcal_fault *fault, const rigcal_columns *s, const rc_common *common,
                     rigcal_real clocks[])
{
    trial t;
    rigcal_real gain;
    begin_trial(&t, s, fault);
    const rigcal_real freedom = common->freedom - (rigcal_real)(int32_t)t.k;
    fault->n = (int32_t)t.k;
    reduce(&t, s);
    if (!(freedom > 0) || !solve(&gain, &t, s)) {
        return;
    }
    const rc_one_step step = {t.k,    1,       t.theta, t.variance,
                              t.turn, t.shift, gain,    own_gain(s, &t)};
    rc_finding_of(fault, common, &step);
    if (t.kind == RIGCAL_FAULT_CLOCKS && clocks != NULL) {
        write_clocks(clocks, s, &t, (common->sum - fault->gain) / freedom);
    }
}
