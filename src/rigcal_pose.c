#include "rc_pose.h"

/* ---- constants ----------------------------------------------------------- */

/* evaluations: the most of a refinement, which usually takes 4 or 5. The manual states this
 * worst case. */
enum { REFINE_EVALS = 100 };

/* rad: two optima count as one if their rotations are nearer than this. */
#define SAME_POSE RC(2e-3)

/* rad: SAME_POSE for three points. Their poses are exact even when two are about to
 * merge. */
#define SAME_EXACT RC_TOL(1e-6, 1e-3)

/* times the negligible sum of squares: three points fit exactly if their sum is no more
 * than this. */
#define EXACT RC_TOL(1e9, 100)

/* px: if no noise is stated, a search believes in no more noise than this. */
#define NOISE_MOST RC(2)

/* px: NOISE_MOST for a warm start, which may have ended elsewhere than at the pose. */
#define NOISE_WARM RC(0.55)

/* part of the target's image: if this is more than NOISE_MOST or NOISE_WARM, it is used
 * instead. It serves coarse targets. */
#define NOISE_PART RC(0.007)

/* standard deviations: a fit with a larger error is poor. Noise alone exceeds it once in a
 * million fits. */
#define DEVIATIONS RC(4.75)

/* standard deviations: DEVIATIONS for a warm start. Noise alone exceeds it once in a
 * thousand fits. Then a search runs, which only costs time. */
#define DEVIATIONS_WARM RC(3.1)

/* px: mirrored points are suspected only if the error is above this noise. */
#define MIRROR_NOISE RC(0.1)

/* odds: mirrored points are believed only if they are this many times as likely. */
#define MIRROR_ODDS RC(100)

/* rad: if the standard deviation of the rotation is larger than this, the points hardly fix
 * the pose. */
#define VAGUE RC(0.25)

/* px: if no noise is stated, VAGUE is checked with at least this noise. */
#define VAGUE_NOISE RC(0.25)

/* probability: the first pose is sure if it has at least this. */
#define SURE RC(0.99)

enum {
    NOT_BEGUN = 0,
    SEEDING, /* the next start */
    REFINING,
    PROVING,  /* the proof that the lens sees the points */
    MIRRORED, /* the refinement of mirrored points */
    DONE
};

static void fail(rigcal_pose_solver *s, rigcal_status status, int32_t at_fault)
{
    s->failure = status;
    s->at_fault = at_fault;
    s->phase = DONE;
}

static void begin_refining(rigcal_pose_solver *s, uint8_t phase, int is_wide)
{
    rc_refine_begin(&s->search.work.refinement, is_wide);
    s->phase = phase;
}

/* ---- is it good? --------------------------------------------------------- */

RC_APART static rigcal_real likelihood_of(const rigcal_pose_solver *s, rigcal_real sse)
{
    const rigcal_search *const search = &s->search;
    return rc_odds(sse, search->optima.list[0].sse, s->sigma_px, search->points.pixel_size,
                   search->points.n_used);
}

/* The sum of the squared errors [px^2] of optimum i. Without sigma that is its sse. */
RC_APART static rigcal_real squared_pixels(const rigcal_pose_solver *s, int32_t i)
{
    const rigcal_points *const points = &s->search.points;
    rigcal_transform cam_from_points;
    rigcal_real sum = 0;
    if (points->view.sigma == NULL) {
        return s->search.optima.list[i].sse;
    }
    rc_pose_found(&cam_from_points, s, i);
    for (size_t k = rc_points_next(points, 0); k < points->view.n;
         k = rc_points_next(points, k + 1)) {
        sum += rc_points_distance2(points, &cam_from_points, k);
    }
    return sum;
}

/* Whether the first pose's error is too large for the noise stated. If none is stated, the
 * noise is taken as `most` px or a part of the target's image, whichever is more. */
RC_APART static int is_poor(const rigcal_pose_solver *s, rigcal_real most,
                            rigcal_real deviations)
{
    const rigcal_points *const points = &s->search.points;
    rigcal_real sum = s->search.optima.list[0].sse, noise = s->sigma_px;
    if (!(noise > 0)) {
        sum = squared_pixels(s, 0);
        noise = rc_max(most * points->pixel_size, NOISE_PART * points->extent_px);
    }
    return !(sum <= noise * noise * rc_chi2_limit(rc_freedom(points->n_used), deviations));
}

/* Whether the points hardly fix the first pose, given the noise. If none is stated, the
 * noise is judged by the pose's error. */
static int is_vague(const rigcal_pose_solver *s)
{
    const rigcal_points *const points = &s->search.points;
    rigcal_real noise = s->sigma_px;
    if (!(noise > 0)) {
        noise = rc_max(VAGUE_NOISE * points->pixel_size,
                       RC_SQRT(s->search.optima.list[0].sse / rc_freedom(points->n_used)));
    }
    return !(noise * noise * s->variance <= VAGUE * VAGUE);
}

/* ---- the beginning and the end ------------------------------------------- */

/* Whether exactly three points count. */
static int is_exact(const rigcal_pose_solver *s)
{
    return RIGCAL_WITH_THREE_POINTS && s->search.points.n_used == 3;
}

/* Ends the search. With three points, noise can make two exact poses one and leave minima
 * that do not fit. Those are dropped if others fit and no noise is stated. */
static void end_search(rigcal_pose_solver *s)
{
    rigcal_optima *const optima = &s->search.optima;
    const rigcal_real most = EXACT * s->search.points.negligible;
    s->phase = DONE;
    if (!is_exact(s) || s->sigma_px > 0) {
        return;
    }
    while (optima->n > 1 && optima->list[0].sse <= most &&
           optima->list[optima->n - 1].sse > most) {
        optima->n--;
    }
}

/* Surveys the points that count, and begins the search of their pose. */
RC_APART static void begin_search(rigcal_pose_solver *s)
{
    rigcal_real uv_middle[2];
    int32_t at;
    if (rc_points_survey(&s->search.points, uv_middle, &at) != RIGCAL_OK) {
        fail(s, RIGCAL_ERR_NO_RAY, s->at_fault); /* too few are left */
        return;
    }
    rc_seeds_begin(&s->search, uv_middle);
    s->phase = SEEDING;
}

/* ---- a search ------------------------------------------------------------ */

/* Leaves out point i, at whose pixel the lens images no ray. The pose is that of the
 * others. A second such point is a failure. */
static void leave_out(rigcal_pose_solver *s, int32_t i)
{
    if (s->search.points.left_out >= 0) {
        fail(s, RIGCAL_ERR_NO_RAY, i);
        return;
    }
    RIGCAL_TRACE("no ray: left out point", i, 0);
    s->search.points.left_out = s->at_fault = i;
    begin_search(s);
}

/* Ends seeding when the starts are spent. Mirrored points are suspected only if the fit
 * leaves room for a better one. */
RC_APART static void end_seeding(rigcal_pose_solver *s)
{
    rigcal_points *const points = &s->search.points;
    const rigcal_real noise = rc_max(s->sigma_px, MIRROR_NOISE * points->pixel_size);
    if (RIGCAL_WITH_MIRRORED && s->search.optima.n > 0 &&
        s->search.optima.list[0].sse > noise * noise * rc_freedom(points->n_used) &&
        rc_seeds_mirrored(&s->search)) {
        points->is_mirrored = !points->is_mirrored;
        begin_refining(s, MIRRORED, 0);
    } else {
        end_search(s);
    }
}

static void end_mirrored(rigcal_pose_solver *s)
{
    rigcal_points *const points = &s->search.points;
    const rigcal_levenberg *const end = &s->search.work.refinement.search;
    points->is_mirrored = !points->is_mirrored;
    s->is_mirrored = end->status >= 0 && likelihood_of(s, end->sum) > MIRROR_ODDS;
    RIGCAL_TRACE("mirrored points (1: likelier), their sum of squares", s->is_mirrored,
                 end->sum);
    end_search(s);
}

/* Goes on with the lattice if the poses of three points led to none that fits. */
static int searches_on(rigcal_pose_solver *s)
{
    return RC_FOR_SPEED &&
           (s->search.optima.n == 0 || is_poor(s, NOISE_MOST, DEVIATIONS)) &&
           rc_seeds_scan(&s->search);
}

static void seeding_step(rigcal_pose_solver *s)
{
    const int32_t came = rc_seeds_step(&s->search);
    if (came == RC_SEEDS_BUSY) {
        return;
    }
    if (came == RC_SEEDS_START) {
        begin_refining(s, REFINING, s->search.is_wide);
    } else if (came == RC_SEEDS_UNSEEN) {
        leave_out(s, (int32_t)s->search.point);
    } else if (came == RC_SEEDS_TRIPLE_SPENT) {
        if (s->search.optima.n == 0 || !is_poor(s, NOISE_MOST, DEVIATIONS) ||
            !rc_seeds_pick(&s->search)) {
            end_search(s);
        }
    } else if (came == RC_SEEDS_SPENT) {
        if (!searches_on(s)) {
            end_seeding(s);
        }
    } else {
        fail(s, came,
             (came == RIGCAL_ERR_WIDE_RAY) ? (int32_t)s->search.point : s->at_fault);
    }
}

/* Ends a warm start. If it ended elsewhere than at the pose, its error shows that. If
 * hardly any data support it, it is dropped too: the status of the search then names what
 * is wrong with the data. */
static void end_warm(rigcal_pose_solver *s)
{
    rigcal_optima *const optima = &s->search.optima;
    s->phase = DONE;
    if (optima->n == 0 || is_poor(s, NOISE_WARM, DEVIATIONS_WARM) || is_vague(s)) {
        RIGCAL_TRACE("the start is dropped", 0, 0);
        s->is_warm = 0;
        optima->n = 0;
        begin_search(s);
    }
}

/* Ends the refinement. Its result is an optimum, or none. */
RC_APART static void settle(rigcal_pose_solver *s, int is_optimum)
{
    rigcal_refinement *const end = &s->search.work.refinement;
    if (is_optimum) {
        rc_rotation_tidy(end->cam_from_points.R);
        if (rc_optima_insert(&s->search.optima, s->same, &end->cam_from_points,
                             end->search.sum) == 0) {
            s->is_unfinished = end->search.status == RIGCAL_BUDGET_SPENT;
            s->variance = RC_MAX;
            (void)rc_sym6_inverse_trace(&s->variance, end->H);
        }
    }
    s->phase = SEEDING;
    if (s->is_warm) {
        end_warm(s);
    }
}

/* Refinement keeps the points in front of the camera. Whether a lens that turns back sees
 * them still has to be proved. A refinement that ran out of evaluations is on its way along
 * a valley, and likely leads to an optimum that is found from elsewhere too. It counts only
 * until a better one takes its place. */
static void end_refinement(rigcal_pose_solver *s)
{
    const rigcal_optima *const optima = &s->search.optima;
    const rigcal_refinement *const end = &s->search.work.refinement;
    const rigcal_status status = end->search.status;
    const rigcal_real sum = end->search.sum;
    int32_t same = rc_optima_near(optima, end->cam_from_points.R,
                                  is_exact(s) ? SAME_EXACT : SAME_POSE);
    int is_optimum = status == RIGCAL_OK;
    if (!s->is_warm) {
        if (status == RIGCAL_BUDGET_SPENT) {
            is_optimum = optima->n == 0 || sum < optima->list[0].sse;
        } else if (status == RIGCAL_ERR_DEGENERATE) {
            s->failure = status;
        }
    }
    if (same < 0 && s->is_unfinished && sum < optima->list[0].sse) {
        same = 0;
    }
    if (same >= 0 && !(sum < optima->list[same].sse)) {
        is_optimum = 0;
    }
    s->same = same;
    RIGCAL_TRACE("refined: status, sum of squares", status, sum);
    RIGCAL_TRACE("evaluations; 1: a new or better optimum", end->evals,
                 (rigcal_real)is_optimum);
    if (is_optimum && !s->search.points.is_pinhole) {
        s->next = rc_points_next(&s->search.points, 0);
        s->phase = PROVING;
    } else {
        settle(s, is_optimum);
    }
}

/* Skips the points at which the lens is proved already. */
RC_APART static void skip_proved(rigcal_pose_solver *s)
{
    const rigcal_points *const points = &s->search.points;
    for (; s->next < points->view.n; s->next = rc_points_next(points, s->next + 1)) {
        rigcal_real q[3], X[3];
        rc_points_place(q, X, points, &s->search.work.refinement.cam_from_points, s->next);
        if (!(X[2] > 0 && X[0] * X[0] + X[1] * X[1] <= points->proved2 * X[2] * X[2])) {
            return;
        }
    }
}

/* Whether the lens sees the next point. */
RC_APART_FAST static int sees_next(const rigcal_pose_solver *s)
{
    const rigcal_points *const points = &s->search.points;
    rigcal_real q[3], X_c[3], uv[2];
    rc_points_place(q, X_c, points, &s->search.work.refinement.cam_from_points, s->next);
    return rc_project_usable(uv, points->view.camera, X_c) == RIGCAL_OK;
}

RC_APART static void proving_step(rigcal_pose_solver *s)
{
    const rigcal_points *const points = &s->search.points;
    if (RC_FOR_SPEED && points->proved2 > 0) {
        skip_proved(s);
        if (s->next == points->view.n) {
            settle(s, 1);
            return;
        }
    }
    const int is_seen = sees_next(s);
    if (!is_seen) {
        RIGCAL_TRACE("the lens does not see point", (int32_t)s->next, 0);
    }
    s->next = rc_points_next(points, s->next + 1);
    if (!is_seen || s->next == points->view.n) {
        settle(s, is_seen);
    }
}

RC_APART static void refining_step(rigcal_pose_solver *s)
{
    rigcal_refinement *const work = &s->search.work.refinement;
    rc_refine_step(work, &s->search.points, REFINE_EVALS);
    if (work->search.status == RIGCAL_RUNNING) {
        return;
    }
    if (RIGCAL_WITH_MIRRORED && s->phase == MIRRORED) {
        end_mirrored(s);
    } else {
        end_refinement(s);
    }
}

/* ---- for other layers ---------------------------------------------------- */

int32_t rc_pose_n_found(const rigcal_pose_solver *s)
{
    return s->search.optima.n;
}

void rc_pose_found(rigcal_transform *cam_from_points, const rigcal_pose_solver *s,
                   int32_t i)
{
    RIGCAL_ASSERT(i >= 0 && i < s->search.optima.n);
    rc_optimum_transform(cam_from_points, &s->search.optima.list[i]);
}

const rigcal_real *rc_pose_origin(const rigcal_pose_solver *s)
{
    return s->search.points.origin;
}

rigcal_real rc_pose_likelihood(const rigcal_pose_solver *s, int32_t i)
{
    RIGCAL_ASSERT(i >= 0 && i < s->search.optima.n);
    return likelihood_of(s, s->search.optima.list[i].sse);
}

/* Exchanges neighbours: a compiler would make a memmove of plain copies. */
void rc_pose_drop(rigcal_pose_solver *s, int32_t i)
{
    RIGCAL_ASSERT(s->phase == DONE && i >= 0 && i < s->search.optima.n);
    rigcal_optima *const optima = &s->search.optima;
    optima->n--;
    for (; i < optima->n; i++) {
        const rigcal_optimum dropped = optima->list[i];
        optima->list[i] = optima->list[i + 1];
        optima->list[i + 1] = dropped;
    }
}

/* ---- public -------------------------------------------------------------- */

rigcal_status rigcal_pose_defaults(rigcal_pose_options *options)
{
    if (options == NULL) {
        return RIGCAL_ERR_NULL;
    }
    options->use_start = 0;
    options->sigma_px = 0;
    rc_transform_identity(&options->start);
    return RIGCAL_OK;
}

RC_APART static rigcal_status check_options(const rigcal_pose_options *o)
{
    const rigcal_status status = rc_check_noise(&o->sigma_px);
    if (status == RIGCAL_ERR_NOT_FINITE) {
        return status;
    }
    if ((o->use_start & ~1) != 0) {
        return RIGCAL_ERR_RANGE;
    }
    return (status == RIGCAL_OK && o->use_start) ? rc_check_transform(&o->start) : status;
}

static void begin_warm(rigcal_pose_solver *s, const rigcal_transform *start)
{
    rigcal_transform *const cam_from_points = &s->search.work.refinement.cam_from_points;
    *cam_from_points = *start;
    rc_rotation_tidy(cam_from_points->R);
    rc_transform_point(cam_from_points->t, start, s->search.points.origin);
    s->is_warm = 1;
    begin_refining(s, REFINING, 0);
    if (RC_FOR_SPEED) {
        rc_refine_begin_part(&s->search.work.refinement, &s->search.points);
    }
}

rigcal_status rc_pose_begin(rigcal_pose_solver *solver, int32_t *at_fault,
                            rigcal_points *points, const rigcal_pose_options *options)
{
    RIGCAL_ASSERT(solver != NULL && points != NULL);
    rigcal_real uv_middle[2];
    int32_t at = -1;
    rigcal_status status = rc_check_view(&points->view);
    if (status == RIGCAL_OK && options != NULL) {
        status = check_options(options);
    }
    if (status == RIGCAL_OK) {
        status = rc_points_survey(points, uv_middle, &at);
    }
    rc_write_fault(at_fault, at);
    if (status != RIGCAL_OK) {
        return status;
    }
    *solver = (rigcal_pose_solver){0};
    solver->search.points = *points;
    solver->at_fault = -1;
    if (options != NULL) {
        solver->sigma_px = options->sigma_px;
    }
    if (options != NULL && options->use_start) {
        begin_warm(solver, &options->start);
    } else {
        rc_seeds_begin(&solver->search, uv_middle);
        solver->phase = SEEDING;
    }
    return RIGCAL_OK;
}

RC_APART rigcal_status rigcal_pose_begin(rigcal_pose_solver *solver, int32_t *at_fault,
                                         const rigcal_view *view,
                                         const rigcal_pose_options *options)
{
    rigcal_points points;
    rc_write_fault(at_fault, -1);
    if (solver == NULL || view == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rc_points_of(&points, view, NULL);
    return rc_pose_begin(solver, at_fault, &points, options);
}

static void step_once(rigcal_pose_solver *s)
{
    if (s->phase == SEEDING) {
        seeding_step(s);
    } else if (s->phase == PROVING) {
        proving_step(s);
    } else {
        refining_step(s);
    }
}

rigcal_status rigcal_pose_step(rigcal_pose_solver *solver, int32_t budget)
{
    if (solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (budget < 1) {
        return RIGCAL_ERR_RANGE;
    }
    if (solver->phase == NOT_BEGUN || solver->phase > DONE) {
        return RIGCAL_ERR_STATE;
    }
    for (; budget > 0 && solver->phase != DONE; budget--) {
        step_once(solver);
    }
    return (solver->phase == DONE) ? RIGCAL_OK : RIGCAL_RUNNING;
}

/* Writes the pose as the caller knows it: from the world's origin, and with its error in
 * px. */
static void write_pose(rigcal_pose *out, const rigcal_pose_solver *s, int32_t i)
{
    const rigcal_points *const points = &s->search.points;
    rigcal_transform *const pose = &out->cam_from_world;
    rigcal_real turned[3];
    rc_pose_found(pose, s, i);
    rc_mat3_mul_vec3(turned, pose->R, points->origin);
    rc_vec3_add_scaled(pose->t, -1, turned);
    out->sse = s->search.optima.list[i].sse;
    out->rms_px = RC_SQRT(squared_pixels(s, i) / (rigcal_real)(int32_t)points->n_used);
}

/* The first caveat that applies to the solution. */
static rigcal_status caveat_of(const rigcal_pose_solver *s, rigcal_real probability)
{
    if ((RIGCAL_WITH_MIRRORED && s->is_mirrored) || is_poor(s, NOISE_MOST, DEVIATIONS)) {
        return RIGCAL_POOR_FIT;
    }
    if (s->is_unfinished) {
        return RIGCAL_BUDGET_SPENT;
    }
    if (is_vague(s)) {
        return RIGCAL_VAGUE;
    }
    if (!(probability >= SURE)) {
        return RIGCAL_AMBIGUOUS;
    }
    return (s->at_fault >= 0) ? RIGCAL_UNSEEN_POINT : RIGCAL_OK;
}

rigcal_status rigcal_pose_result(rigcal_pose poses[], size_t capacity, size_t *n_found,
                                 int32_t *at_fault, const rigcal_pose_solver *solver)
{
    const rigcal_pose_solver *const s = solver;
    rigcal_real total = 0;
    rc_write_fault(at_fault, -1);
    if (poses == NULL || n_found == NULL || s == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (capacity < 1) {
        return RIGCAL_ERR_RANGE;
    }
    const int32_t n_optima = s->search.optima.n;
    if (s->phase != DONE || n_optima < 0 || n_optima > RIGCAL_POSES_MAX) {
        return RIGCAL_ERR_STATE;
    }
    rc_write_fault(at_fault, s->at_fault);
    if (n_optima == 0) {
        return (s->failure != 0) ? s->failure : RIGCAL_ERR_NO_POSE;
    }
    for (int32_t i = 0; i < n_optima; i++) {
        total += rc_pose_likelihood(s, i);
    }
    const size_t n = ((size_t)n_optima < capacity) ? (size_t)n_optima : capacity;
    *n_found = n;
    for (size_t i = 0; i < n; i++) {
        write_pose(&poses[i], s, (int32_t)i);
        poses[i].probability = rc_pose_likelihood(s, (int32_t)i) / total;
    }
    const rigcal_status status = caveat_of(s, poses[0].probability);
    RIGCAL_TRACE("verdict: status, probability", status, poses[0].probability);
    return status;
}

rigcal_status rigcal_pose_solve(rigcal_pose poses[], size_t capacity, size_t *n_found,
                                int32_t *at_fault, const rigcal_view *view,
                                const rigcal_pose_options *options)
{
    rigcal_pose_solver solver;
    rc_write_fault(at_fault, -1);
    if (poses == NULL || n_found == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (capacity < 1) {
        return RIGCAL_ERR_RANGE;
    }
    const rigcal_status status = rigcal_pose_begin(&solver, at_fault, view, options);
    if (status != RIGCAL_OK) {
        return status;
    }
    (void)rigcal_pose_step(&solver, INT32_MAX);
    return rigcal_pose_result(poses, capacity, n_found, at_fault, &solver);
}
