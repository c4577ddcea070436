#include "rc_chance.h"
#include "rc_joint.h"
#include "rc_locate.h"

/* ---- constants ----------------------------------------------------------- */

/* standard deviations: a normal variable exceeds this once in a hundred times. */
#define DEVIATIONS RC(2.326)

/* chi squared with 2 degrees of freedom: it exceeds this once in a hundred times. A view
 * below it agrees. */
#define AGREES RC(9.21)

/* views: every pair is tried if there are no more than this. */
enum { ALL_PAIRS = 16 };

/* reals: the memory of a ranked pair: its parallax and its two views. */
enum { PAIR_REALS = 3 };

/* ---- memory -------------------------------------------------------------- */

enum { CHECK = 1, LOCATE, RANK, COMPARE, DONE };

/* Which views the current point is found from. */
enum { OF_ALL, OF_PAIR, OF_AGREED };

size_t rigcal_point_work(size_t n)
{
    return RIGCAL_POINT_WORK(n);
}

static rigcal_real *ranks_of(const rigcal_point_solver *p)
{
    const size_t n = p->sightings->n;
    return p->sums.V + n * (2 * n + 1);
}

/* ---- begin --------------------------------------------------------------- */

/* Checks the rig's pointers and numbers. Without a joint covariance only those of its
 * cameras are checked. */
static rigcal_status check_rig(const rigcal_calibrated_rig *rig)
{
    size_t n_free;
    if (rig == NULL || !rc_is_finite(rig->sigma_px) || rig->sigma_px > 0) {
        return rc_calibrated_check(&n_free, rig);
    }
    if (rig->cameras == NULL || rig->group == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (rig->sigma_px < 0 || rig->n_cameras > RIGCAL_STORE_CAMERAS_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    if (rig->n_cameras < 1) {
        return RIGCAL_ERR_TOO_FEW;
    }
    if (rig->n_cameras > rig->capacity) {
        return RIGCAL_ERR_CAPACITY;
    }
    return RIGCAL_OK;
}

static rigcal_status check_all(const rigcal_sightings *s)
{
    if (s == NULL || s->seen == NULL || s->work == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = check_rig(s->rig);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (s->sigma_px == NULL && !(s->rig->sigma_px > 0)) {
        return RIGCAL_ERR_STATE;
    }
    if (!rc_is_finite(s->parallax_least)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    if (!(s->parallax_least >= 0) || !(s->parallax_least <= RC_PI / 2) ||
        (s->keep_all != 0 && s->keep_all != 1) || s->n > RIGCAL_SIGHTINGS_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    if (s->n < 2) {
        return RIGCAL_ERR_TOO_FEW;
    }
    return (s->work_capacity < rigcal_point_work(s->n)) ? RIGCAL_ERR_CAPACITY : RIGCAL_OK;
}

static void begin_views(rigcal_point_solver *p, int32_t phase)
{
    p->phase = phase;
    p->view = 0;
}

rigcal_status rigcal_point_begin(rigcal_point_solver *solver, const rigcal_sightings *s)
{
    if (solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = check_all(s);
    if (status != RIGCAL_OK) {
        return status;
    }
    solver->sightings = s;
    solver->sums.V = s->work + RC_SIGHT_REALS * s->n;
    solver->status = RIGCAL_RUNNING;
    solver->negligible = RC_MAX;
    solver->tolerance = (s->rig->F > 1) ? RC_SQRT(s->rig->F) : 1;
    begin_views(solver, CHECK);
    return RIGCAL_OK;
}

static void end(rigcal_point_solver *p, rigcal_status status)
{
    p->status = status;
    p->phase = DONE;
}

static void begin_point(rigcal_point_solver *p, int32_t of, size_t n_used)
{
    p->phase = LOCATE;
    p->of = of;
    rc_locate_begin(p, n_used);
}

static void check_view(rigcal_point_solver *p)
{
    const rigcal_sightings *const s = p->sightings;
    rc_sighted *const v = &rc_sights_of(p)[p->view];
    const size_t i = p->view++;
    const rigcal_status status = rc_sight_check(v, s, i);
    if (status != RIGCAL_OK) {
        end(p, status);
        return;
    }
    const rigcal_camera *const camera = &s->rig->cameras[s->seen[i].camera].camera;
    p->negligible =
        rc_min(p->negligible, v->weight * rc_negligible(rc_pixel_size(camera),
                                                        (rigcal_real)camera->width));
    v->order = (rigcal_real)i;
    v->chosen = 0;
    if (s->rig->group[s->seen[i].camera] != s->rig->group[s->seen[0].camera]) {
        end(p, RIGCAL_DISCONNECTED);
    } else if (p->view == s->n) {
        begin_point(p, OF_ALL, s->n);
    }
}

/* ---- wrong views --------------------------------------------------------- */

/* Writes the next pair into p->two. Returns 0 if there is none. */
static int choose_pair(rigcal_point_solver *p)
{
    const size_t k = p->pair++;
    if (p->sightings->n > ALL_PAIRS) {
        const rigcal_real *const rank = &ranks_of(p)[PAIR_REALS * k];
        if (k < p->n_pairs) {
            p->two[0] = (size_t)rank[2];
            p->two[1] = (size_t)rank[1];
        }
        return k < p->n_pairs;
    }
    if (k == 0) {
        p->two[0] = 0;
        p->two[1] = 1;
    } else if (++p->two[1] == p->sightings->n) {
        p->two[1] = ++p->two[0] + 1;
    }
    return p->two[1] < p->sightings->n;
}

/* Begins the point of the views that agree with the best pair. */
static void begin_agreed(rigcal_point_solver *p)
{
    rc_sighted *const sights = rc_sights_of(p);
    size_t count = 0;
    for (size_t i = 0; i < p->sightings->n; i++) {
        if (sights[i].chosen > 0) {
            sights[count++].order = (rigcal_real)i;
        }
    }
    begin_point(p, OF_AGREED, count);
}

static void next_pair(rigcal_point_solver *p)
{
    if (choose_pair(p)) {
        rc_sights_of(p)[0].order = (rigcal_real)p->two[0];
        rc_sights_of(p)[1].order = (rigcal_real)p->two[1];
        begin_point(p, OF_PAIR, 2);
    } else if (p->best > 0) {
        begin_agreed(p);
    } else {
        end(p, p->whole);
    }
}

/* Inserts a pair into the ranking, the widest angle first. If the ranking is full its last
 * pair falls out. */
static void rank_pair(rigcal_point_solver *p, size_t i, size_t j)
{
    const rigcal_real aside = rc_sight_aside(&rc_sights_of(p)[i], &rc_sights_of(p)[j]);
    rigcal_real *const ranks = ranks_of(p);
    size_t at = p->n_pairs;
    if (at < RIGCAL_SIGHTING_PAIRS) {
        p->n_pairs++;
    } else if (!(aside > ranks[PAIR_REALS * --at])) {
        return;
    }
    for (; at > 0 && aside > ranks[PAIR_REALS * (at - 1)]; at--) {
        rc_vec3_copy(&ranks[PAIR_REALS * at], &ranks[PAIR_REALS * (at - 1)]);
    }
    const rigcal_real rank[PAIR_REALS] = {aside, (rigcal_real)i, (rigcal_real)j};
    rc_vec3_copy(&ranks[PAIR_REALS * at], rank);
}

static void rank_view(rigcal_point_solver *p)
{
    for (size_t j = 0; j < p->view; j++) {
        rank_pair(p, p->view, j);
    }
    if (++p->view == p->sightings->n) {
        next_pair(p);
    }
}

static void begin_pairs(rigcal_point_solver *p)
{
    p->best = p->n_pairs = 0;
    p->least = RC_MAX;
    p->pair = 0;
    if (p->sightings->n > ALL_PAIRS) {
        begin_views(p, RANK);
    } else {
        next_pair(p);
    }
}

/* Squared distance of a view from the point of two others, weighed by the inverse
 * covariance. The covariance has the noise, the point's and the camera's error. */
static rigcal_real miss_of(const rigcal_point_solver *p, size_t i)
{
    const rigcal_sightings *const s = p->sightings;
    rc_sighted v = rc_sights_of(p)[i];
    rigcal_real C[4], a[3];
    if (!(rc_vec3_dot(v.ray, v.ray) > 0) || /* the view could not be used */
        rc_sight_evaluate(&v, s, i, p->X) != RIGCAL_OK ||
        rc_sight_move(&v, s, i, p->X) != RIGCAL_OK) {
        return p->tolerance * AGREES;
    }
    rc_sight_block(C, &v, &v, s->rig->Sigma);
    rc_sym3_mul_vec3(a, p->sums.Sigma, &v.A[0]);
    const rigcal_real uu = C[0] + 1 / v.weight + rc_vec3_dot(a, &v.A[0]);
    const rigcal_real uv = C[2] + rc_vec3_dot(a, &v.A[3]);
    rc_sym3_mul_vec3(a, p->sums.Sigma, &v.A[3]);
    const rigcal_real vv = C[3] + 1 / v.weight + rc_vec3_dot(a, &v.A[3]);
    const rigcal_real along = v.e[1] - uv / uu * v.e[0], left = vv - uv / uu * uv;
    const rigcal_real miss = v.e[0] * v.e[0] / uu + along * along / left;
    return (miss < p->tolerance * AGREES) ? miss : p->tolerance * AGREES;
}

static void compare_view(rigcal_point_solver *p)
{
    rc_sighted *const sights = rc_sights_of(p);
    const size_t i = p->view++, n = p->sightings->n;
    const int is_own = i == p->two[0] || i == p->two[1];
    const rigcal_real miss = is_own ? p->chi2 / 2 : miss_of(p, i);
    const int agrees = is_own || miss < p->tolerance * AGREES;
    sights[i].agrees = (rigcal_real)agrees;
    p->agree += (size_t)agrees;
    p->distance += miss;
    if (p->view < n) {
        return;
    }
    if (p->agree > p->best || (p->agree == p->best && p->distance < p->least)) {
        p->best = p->agree;
        p->least = p->distance;
        for (size_t k = 0; k < n; k++) {
            sights[k].chosen = sights[k].agrees;
        }
    }
    next_pair(p);
}

/* ---- a point, and what comes after it -------------------------------------- */

static rigcal_real freedom_of(const rigcal_point_solver *p)
{
    return (rigcal_real)(2 * p->n_used - 3);
}

/* Whether the views see one point. Their chi2 is that of noise alone. If the views of the
 * rig differ by more, right views of a point do so too. */
static int is_one_point(const rigcal_point_solver *p)
{
    return p->chi2 <= p->tolerance * rc_chi2_limit(freedom_of(p), DEVIATIONS);
}

static int may_drop(const rigcal_point_solver *p)
{
    return p->sightings->n > 2 && p->sightings->keep_all == 0;
}

/* Judges the point of all views. The search ends with `status` if the point is right. */
static void judge_all(rigcal_point_solver *p, rigcal_status status)
{
    if ((status < 0) ? !may_drop(p) : is_one_point(p)) {
        end(p, status);
    } else if (!may_drop(p)) {
        end(p, RIGCAL_POOR_FIT);
    } else {
        p->whole = (status < 0) ? status : RIGCAL_ERR_NO_CONSENSUS;
        begin_pairs(p);
    }
}

static void judge_pair(rigcal_point_solver *p, rigcal_status status)
{
    if (status >= 0 && is_one_point(p)) {
        p->agree = 0;
        p->distance = 0;
        begin_views(p, COMPARE);
    } else {
        next_pair(p);
    }
}

static void locate(rigcal_point_solver *p)
{
    const rigcal_status status = rc_locate_step(p);
    if (status == RIGCAL_RUNNING) {
        return;
    }
    if (p->of == OF_ALL) {
        judge_all(p, status);
    } else if (p->of == OF_PAIR) {
        judge_pair(p, status);
    } else if (status < 0) {
        end(p, status);
    } else if (p->n_used == p->sightings->n) {
        end(p, RIGCAL_POOR_FIT);
    } else {
        end(p, (p->n_used == 2) ? RIGCAL_FEW_AGREE : RIGCAL_VIEWS_LEFT_OUT);
    }
}

/* ---- steps and result ---------------------------------------------------- */

static void step_once(rigcal_point_solver *p)
{
    if (p->phase == CHECK) {
        check_view(p);
    } else if (p->phase == LOCATE) {
        locate(p);
    } else if (p->phase == RANK) {
        rank_view(p);
    } else {
        compare_view(p);
    }
}

rigcal_status rigcal_point_step(rigcal_point_solver *solver, int32_t budget)
{
    const rigcal_status status =
        rc_check_step((solver != NULL) ? &solver->phase : NULL, budget);
    if (status != RIGCAL_OK) {
        return status;
    }
    for (int32_t k = 0; k < budget && solver->phase != DONE; k++) {
        step_once(solver);
    }
    return solver->status;
}

/* The packed matrix as 3 x 3, row by row. */
static void unpack(rigcal_real full[9], const rigcal_real A[6])
{
    for (int i = 0, at = 0; i < 3; i++) {
        for (int j = i; j < 3; j++, at++) {
            full[3 * i + j] = full[3 * j + i] = A[at];
        }
    }
}

/* Writes -G B of each view. */
static void write_gains(rigcal_measured_point *point, const rigcal_point_solver *p)
{
    for (size_t k = 0; k < p->n_used; k++) {
        const size_t i = rc_sight_number(p, k);
        const rc_sighted *const v = &rc_sights_of(p)[i];
        point->gains[k].camera = p->sightings->seen[i].camera;
        for (int row = 0; row < 3; row++) {
            for (int j = 0; j < 6; j++) {
                point->gains[k].gain[6 * row + j] =
                    -v->G[2 * row] * v->B[j] - v->G[2 * row + 1] * v->B[6 + j];
            }
        }
    }
}

static void write_used(uint8_t used[], const rigcal_point_solver *p)
{
    for (size_t i = 0; i < p->sightings->n && used != NULL; i++) {
        used[i] = 0;
    }
    for (size_t k = 0; k < p->n_used && used != NULL; k++) {
        used[rc_sight_number(p, k)] = 1;
    }
}

/* The rms of the used views at the point where the last step went [px]. */
static rigcal_real rms_of(const rigcal_point_solver *p)
{
    rigcal_real sse = 0, step[3];
    rc_vec3_sub(step, p->X, p->before);
    for (size_t k = 0; k < p->n_used; k++) {
        const rc_sighted *const v = &rc_sights_of(p)[rc_sight_number(p, k)];
        for (int row = 0; row < 2; row++) {
            const rigcal_real e = v->e[row] - rc_vec3_dot(&v->A[3 * row], step);
            sse += e * e;
        }
    }
    return RC_SQRT(sse / (rigcal_real)p->n_used);
}

rigcal_status rigcal_point_result(rigcal_measured_point *point, uint8_t used[],
                                  const rigcal_point_solver *solver)
{
    if (point == NULL || solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (solver->phase != DONE) {
        return RIGCAL_ERR_STATE;
    }
    if (solver->status < 0 || solver->status == RIGCAL_DISCONNECTED) {
        return solver->status;
    }
    if (point->gains != NULL && point->gains_capacity < solver->n_used) {
        return RIGCAL_ERR_CAPACITY;
    }
    rc_vec3_copy(point->X, solver->X);
    unpack(point->Sigma, solver->sums.Sigma);
    unpack(point->Sigma_noise, solver->sums.N);
    point->chi2 = solver->chi2;
    point->freedom = freedom_of(solver);
    point->parallax = rc_locate_parallax(solver);
    point->rms_px = rms_of(solver);
    point->n_used = solver->n_used;
    if (point->gains != NULL) {
        write_gains(point, solver);
    }
    write_used(used, solver);
    return solver->status;
}

rigcal_status rigcal_point_measure(rigcal_measured_point *point, uint8_t used[],
                                   const rigcal_sightings *s)
{
    rigcal_point_solver solver;
    if (point == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rigcal_point_begin(&solver, s);
    if (status != RIGCAL_OK) {
        return status;
    }
    while (solver.phase != DONE) {
        step_once(&solver);
    }
    return rigcal_point_result(point, used, &solver);
}

/* ---- a length ------------------------------------------------------------ */

/* Checks what the caller gives of one of the two points. */
static rigcal_status check_end(const rigcal_measured_point *end,
                               const rigcal_calibrated_rig *rig)
{
    if (end == NULL || end->gains == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_point(end->X);
    if (status == RIGCAL_OK) {
        status = rc_check_numbers(end->Sigma_noise, 9, RC_MAX);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    if (end->n_used < 2 || end->n_used > RIGCAL_SIGHTINGS_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    for (size_t k = 0; k < end->n_used; k++) {
        const rigcal_point_gain *const g = &end->gains[k];
        if (g->camera < 0 || (size_t)g->camera >= rig->n_cameras) {
            return RIGCAL_ERR_RANGE;
        }
        if (!rc_all_finite(g->gain, 18)) {
            return RIGCAL_ERR_NOT_FINITE;
        }
    }
    return RIGCAL_OK;
}

static rigcal_status check_ends(const rigcal_calibrated_rig *rig,
                                const rigcal_measured_point *p,
                                const rigcal_measured_point *q)
{
    rigcal_status status = check_rig(rig);
    if (status == RIGCAL_OK) {
        status = check_end(p, rig);
    }
    if (status == RIGCAL_OK) {
        status = check_end(q, rig);
    }
    if (status == RIGCAL_OK &&
        rig->group[p->gains[0].camera] != rig->group[q->gains[0].camera]) {
        return RIGCAL_DISCONNECTED;
    }
    return status;
}

/* w = direction^T gain of view k of p, or minus that of view k - p->n_used of q. Returns
 * the first unknown of its camera. */
static rigcal_real lever_of(rigcal_real w[6], const rigcal_calibrated_rig *rig,
                            const rigcal_measured_point *p, const rigcal_measured_point *q,
                            const rigcal_real direction[3], size_t k)
{
    const int is_q = k >= p->n_used;
    const rigcal_point_gain *const g = is_q ? &q->gains[k - p->n_used] : &p->gains[k];
    for (int j = 0; j < 6; j++) {
        w[j] = direction[0] * g->gain[j] + direction[1] * g->gain[6 + j] +
               direction[2] * g->gain[12 + j];
        w[j] = is_q ? -w[j] : w[j];
    }
    return (rig->sigma_px > 0) ? rc_calibrated_first(rig, (size_t)g->camera) : -1;
}

/* The part of the variance that the calibration causes. */
static rigcal_real spread_of(const rigcal_calibrated_rig *rig,
                             const rigcal_measured_point *p, const rigcal_measured_point *q,
                             const rigcal_real direction[3])
{
    const size_t n = p->n_used + q->n_used;
    rigcal_real sum = 0;
    for (size_t a = 0; a < n; a++) {
        rigcal_real v[6], w[6], Sigma[36];
        const rigcal_real first = lever_of(v, rig, p, q, direction, a);
        for (size_t b = 0; b <= a && first >= 0; b++) {
            const rigcal_real other = lever_of(w, rig, p, q, direction, b);
            rc_joint_block(Sigma, rig->Sigma, first, other);
            for (int i = 0; i < 36; i++) {
                sum += RC((a == b) ? 1 : 2) * v[i / 6] * Sigma[i] * w[i % 6];
            }
        }
    }
    return sum;
}

rigcal_status rigcal_point_distance(rigcal_real *distance, rigcal_real *sigma,
                                    const rigcal_calibrated_rig *rig,
                                    const rigcal_measured_point *p,
                                    const rigcal_measured_point *q)
{
    if (distance == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = check_ends(rig, p, q);
    if (status != RIGCAL_OK) {
        return status;
    }
    rigcal_real d[3], direction[3], row[3], variance;
    rc_vec3_sub(d, p->X, q->X);
    if (!rc_vec3_unit(direction, d)) {
        return RIGCAL_ERR_COINCIDENT;
    }
    rc_mat3_mul_vec3(row, p->Sigma_noise, direction);
    variance = rc_vec3_dot(direction, row);
    rc_mat3_mul_vec3(row, q->Sigma_noise, direction);
    variance += rc_vec3_dot(direction, row) + spread_of(rig, p, q, direction);
    if (!rc_is_finite(variance)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    *distance = rc_vec3_norm(d);
    if (sigma != NULL) {
        *sigma = RC_SQRT(rc_max(0, variance));
    }
    return RIGCAL_OK;
}
