#include "rc_pose.h"

/* ---- constants ----------------------------------------------------------- */

/* points: the least. Of four, any three agree with a pose, and one point more may by
 * chance. */
enum { POINTS_LEAST = 5 };

/* samples: the default. Enough, by MISSED, where 42 of 100 points agree. */
enum { SAMPLES = 500 };

/* samples: more are a mistake. */
enum { SAMPLES_MAX = 100000 };

/* points: of more, the triples are not counted. They would overflow, and are far more than
 * SAMPLES_MAX. */
enum { COUNTED_MAX = 1000 };

/* px: how far a point that agrees may be off, where no noise is stated. */
#define THRESHOLD_PX RC(3)

/* times the noise stated: how far a point that agrees may be off. */
#define THRESHOLD_SIGMAS RC(4)

/* chance: random samples end when that to have missed every clean one is less. */
#define MISSED RC(1e-4)

/* part: a clean sample counts as so much of one, for noise spoils some. */
#define USEFUL_PART RC(0.25)

/* times: that the points that agree are decided anew by the pose of the last ones. */
enum { ROUNDS = 8 };

/* thresholds: a fit to all that agree may take in points so far from the pose of three. */
#define REACH RC(2)

/* sets expected to agree by chance: above it the pose has a caveat. */
#define CHANCE RC(1e-3)

/* sets expected to agree by chance: from here on there is no pose. */
#define CHANCE_MOST RC(1)

enum {
    NOT_BEGUN = 0,
    SEEING,   /* the rays of a triple, and its poses */
    SCORING,  /* one of them */
    AGREEING, /* the points that agree with the best */
    SOLVING,
    SOLVED,
    DONE
};

/* ---- samples ------------------------------------------------------------- */

/* Marsaglia's xorshift of 32 bits (2003); the state is not 0. */
static size_t draw(rigcal_robust_solver *s, size_t n)
{
    uint32_t x = s->random;
    x ^= x << 13;
    x ^= x >> 17;
    x ^= x << 5;
    s->random = x;
    return (size_t)(((uint64_t)x * (uint64_t)n) >> 32);
}

/* How many triples there are, or RC_COUNT_MAX when more. */
static size_t count_triples(size_t n)
{
    return (n > COUNTED_MAX) ? RC_COUNT_MAX : n * (n - 1) / 2 * (n - 2) / 3;
}

/* The next triple in order, from (0, 1, 2). */
static void next_in_order(int32_t sample[3], int32_t n)
{
    if (++sample[2] == n) {
        if (++sample[1] == n - 1) {
            sample[1] = ++sample[0] + 1;
        }
        sample[2] = sample[1] + 1;
    }
}

static void next_sample(rigcal_robust_solver *s)
{
    const size_t n = s->points.view.n;
    if (s->is_complete) {
        next_in_order(s->sample, (int32_t)n);
        return;
    }
    for (int k = 0; k < 3; k++) { /* distinct: skips what is taken, in order */
        size_t i = draw(s, n - (size_t)k);
        const size_t low =
            (size_t)((s->sample[0] < s->sample[1]) ? s->sample[0] : s->sample[1]);
        const size_t high =
            (size_t)((s->sample[0] < s->sample[1]) ? s->sample[1] : s->sample[0]);
        if (k == 1) {
            i += i >= (size_t)s->sample[0];
        } else if (k == 2) {
            i += i >= low;
            i += i >= high;
        }
        s->sample[k] = (int32_t)i;
    }
}

/* ---- scores -------------------------------------------------------------- */

/* Sum of the squared distances, none counting more than the threshold's; above `enough` it
 * is not finished. *count: points within. */
static rigcal_real score(size_t *count, const rigcal_robust_solver *s,
                         const rigcal_transform *pose, rigcal_real enough)
{
    const rigcal_real limit = s->threshold_px * s->threshold_px;
    rigcal_real sum = 0;
    *count = 0;
    for (size_t i = 0; i < s->points.view.n && sum < enough; i++) {
        const rigcal_real d2 = rc_points_error2(&s->points, pose, i);
        *count += d2 <= limit;
        sum += rc_min(d2, limit);
    }
    return sum;
}

/* Marks the points within the threshold. Returns whether any mark changed. */
static int mark(rigcal_robust_solver *s, const rigcal_transform *pose)
{
    const rigcal_real limit = s->threshold_px * s->threshold_px;
    int changed = 0;
    for (size_t i = 0; i < s->points.view.n; i++) {
        const uint8_t is_in = rc_points_error2(&s->points, pose, i) <= limit;
        changed |= is_in != s->inliers[i];
        s->inliers[i] = is_in;
    }
    return changed;
}

/* ---- phases -------------------------------------------------------------- */

static void fail(rigcal_robust_solver *s, rigcal_status status)
{
    s->failure = status;
    s->phase = DONE;
}

/* The next triple, unless there have been enough. */
static void end_sample(rigcal_robust_solver *s)
{
    const rigcal_real part = (rigcal_real)s->n_agree / (rigcal_real)s->points.view.n;
    s->missed *= 1 - USEFUL_PART * part * part * part;
    s->tried++;
    s->next = 0;
    s->phase = SEEING;
    if (s->tried >= s->samples || (!s->is_complete && s->missed < MISSED)) {
        s->phase = AGREEING;
    } else {
        next_sample(s);
    }
}

static void begin_scoring(rigcal_robust_solver *s)
{
    rigcal_trial_poses *const trial = &s->work.trial;
    s->n_poses = rc_poses_of_three(trial->tried, &s->points, s->sample,
                                   (const rigcal_real(*)[3])trial->ray);
    s->next = 0;
    s->phase = SCORING;
    if (s->n_poses == 0) {
        end_sample(s);
    }
}

/* One ray; of a pinhole, whose rays cost next to nothing, all three. */
static void seeing_step(rigcal_robust_solver *s)
{
    const rigcal_view *const view = &s->points.view;
    do {
        const rigcal_observation *const o = &view->observations[s->sample[s->next]];
        if (rc_pixel_to_ray(s->work.trial.ray[s->next], view->camera, o->uv) != RIGCAL_OK) {
            end_sample(s);
            return;
        }
        s->next++;
    } while (s->next < 3 && s->points.is_pinhole);
    if (s->next == 3) {
        begin_scoring(s);
    }
}

static void scoring_step(rigcal_robust_solver *s)
{
    rigcal_trial_poses *const trial = &s->work.trial;
    const rigcal_transform *const pose = &trial->tried[s->next++];
    size_t count;
    const rigcal_real cost = score(&count, s, pose, trial->cost);
    if (cost < trial->cost) {
        trial->cost = cost;
        trial->best = *pose;
        s->n_agree = count;
    }
    if (s->next == s->n_poses) {
        end_sample(s);
    }
}

/* The pose of the inliers as they are marked; DONE when there is none. */
static void begin_solving(rigcal_robust_solver *s)
{
    rigcal_pose_options options;
    rigcal_points agreeing;
    (void)rigcal_pose_defaults(&options);
    options.sigma_px = s->sigma_px;
    rc_points_of(&agreeing, &s->points.view, s->inliers);
    const rigcal_status status = rc_pose_begin(&s->work.pose, NULL, &agreeing, &options);
    if (status == RIGCAL_OK) {
        s->phase = SOLVING;
    } else {
        fail(s, (status == RIGCAL_ERR_TOO_FEW) ? RIGCAL_ERR_NO_CONSENSUS : status);
    }
}

static void agreeing_step(rigcal_robust_solver *s)
{
    if (s->work.trial.cost < RC_MAX) {
        (void)mark(s, &s->work.trial.best);
        begin_solving(s);
    } else {
        fail(s, RIGCAL_ERR_NO_CONSENSUS);
    }
}

static void solving_step(rigcal_robust_solver *s)
{
    if (rigcal_pose_step(&s->work.pose, 1) != RIGCAL_RUNNING) {
        s->phase = SOLVED;
    }
}

/* The points that agree with the pose found, and its solution again when they are
 * others. */
static void solved_step(rigcal_robust_solver *s)
{
    rigcal_pose pose;
    size_t n_found;
    s->failure = rigcal_pose_result(&pose, 1, &n_found, NULL, &s->work.pose);
    s->phase = DONE;
    if (s->failure < 0 || s->rounds++ >= ROUNDS) {
        return;
    }
    rigcal_transform cam_from_points = pose.cam_from_world;
    rc_transform_point(cam_from_points.t, &pose.cam_from_world, s->points.origin);
    if (mark(s, &cam_from_points)) {
        begin_solving(s);
    }
}

/* ---- public -------------------------------------------------------------- */

rigcal_status rigcal_robust_defaults(rigcal_robust_options *options)
{
    if (options == NULL) {
        return RIGCAL_ERR_NULL;
    }
    options->threshold_px = 0;
    options->sigma_px = 0;
    options->samples = SAMPLES;
    options->seed = 1;
    return RIGCAL_OK;
}

static rigcal_status check_options(const rigcal_robust_options *o)
{
    rigcal_status status = rc_check_noise(&o->threshold_px);
    const rigcal_status sigma_status = rc_check_noise(&o->sigma_px);
    if (status == RIGCAL_OK || sigma_status == RIGCAL_ERR_NOT_FINITE) {
        status = sigma_status;
    }
    if (status == RIGCAL_OK && (o->samples < 1 || o->samples > SAMPLES_MAX)) {
        status = RIGCAL_ERR_RANGE;
    }
    return status;
}

/* The rectangle [px^2] in which the points were seen. */
static rigcal_real seen_area(const rigcal_view *view)
{
    const rigcal_observation *const o = view->observations;
    rigcal_real area = 1;
    for (int k = 0; k < 2; k++) {
        rigcal_real low = o[0].uv[k], high = low;
        for (size_t i = 1; i < view->n; i++) {
            low = rc_min(low, o[i].uv[k]);
            high = rc_max(high, o[i].uv[k]);
        }
        area *= high - low;
    }
    return area;
}

/* Fills in *s of points that have been surveyed. */
static void fill(rigcal_robust_solver *s, const rigcal_points *points, uint8_t inliers[],
                 const rigcal_robust_options *o)
{
    const size_t n = points->view.n;
    *s = (rigcal_robust_solver){0};
    s->points = *points;
    s->inliers = inliers;
    s->sigma_px = o->sigma_px;
    s->threshold_px = (o->threshold_px > 0) ? o->threshold_px
                      : (o->sigma_px > 0)   ? THRESHOLD_SIGMAS * o->sigma_px
                                            : THRESHOLD_PX * points->pixel_size;
    s->random = (o->seed != 0) ? o->seed : UINT32_C(0x9e3779b9);
    s->samples = o->samples;
    s->is_complete = count_triples(n) <= (size_t)o->samples;
    if (s->is_complete) {
        s->samples = (int32_t)count_triples(n);
    }
    s->work.trial.cost = RC_MAX;
    s->missed = 1;
    s->sample[1] = 1;
    s->sample[2] = 2;
    if (!s->is_complete) {
        next_sample(s);
    }
    s->area_px2 = seen_area(&points->view);
    s->phase = SEEING;
}

rigcal_status rigcal_robust_begin(rigcal_robust_solver *solver, uint8_t inliers[],
                                  int32_t *at_fault, const rigcal_view *view,
                                  const rigcal_robust_options *options)
{
    rigcal_robust_options o;
    rigcal_points points;
    rigcal_real uv_middle[2];
    int32_t at = -1;
    rc_write_fault(at_fault, -1);
    if (solver == NULL || inliers == NULL) {
        return RIGCAL_ERR_NULL;
    }
    (void)rigcal_robust_defaults(&o);
    if (options != NULL) {
        o = *options;
    }
    rigcal_status status = rc_check_view(view);
    if (status == RIGCAL_OK) {
        status = check_options(&o);
    }
    if (status == RIGCAL_OK && view->n < POINTS_LEAST) {
        status = RIGCAL_ERR_TOO_FEW;
    }
    if (status == RIGCAL_OK) {
        rc_points_of(&points, view, NULL);
        status = rc_points_survey(&points, uv_middle, &at);
        rc_write_fault(at_fault, at);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    if (rc_points_are_on_line(&points)) {
        return RIGCAL_ERR_COLLINEAR;
    }
    fill(solver, &points, inliers, &o);
    return RIGCAL_OK;
}

rigcal_status rigcal_robust_step(rigcal_robust_solver *solver, int32_t budget)
{
    if (solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (budget < 1) {
        return RIGCAL_ERR_RANGE;
    }
    if (solver->phase <= NOT_BEGUN || solver->phase > DONE) {
        return RIGCAL_ERR_STATE;
    }
    for (int32_t i = 0; i < budget && solver->phase != DONE; i++) {
        switch (solver->phase) {
        case SEEING:
            seeing_step(solver);
            break;
        case SCORING:
            scoring_step(solver);
            break;
        case AGREEING:
            agreeing_step(solver);
            break;
        case SOLVING:
            solving_step(solver);
            break;
        default:
            solved_step(solver);
            break;
        }
    }
    return (solver->phase == DONE) ? RIGCAL_OK : RIGCAL_RUNNING;
}

/* The chance that a wrong point agrees: that of a disc in the area of the image. */
static rigcal_real chance_of_one(const rigcal_robust_solver *s)
{
    const rigcal_real limit = REACH * s->threshold_px;
    return rc_min(1, RC_PI * limit * limit / s->area_px2);
}

rigcal_status rigcal_robust_result(rigcal_pose poses[], size_t capacity, size_t *n_found,
                                   size_t *n_inliers, const rigcal_robust_solver *solver)
{
    if (poses == NULL || n_found == NULL || n_inliers == NULL || solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (capacity < 1) {
        return RIGCAL_ERR_RANGE;
    }
    if (solver->phase != DONE) {
        return RIGCAL_ERR_STATE;
    }
    if (solver->failure < 0) {
        return solver->failure;
    }
    const size_t n = solver->points.view.n, count = rc_pose_n_used(&solver->work.pose);
    const rigcal_real expected = rc_expected_sets(n, count, chance_of_one(solver));
    if (!(expected < CHANCE_MOST)) {
        return RIGCAL_ERR_NO_CONSENSUS;
    }
    const rigcal_status status =
        rigcal_pose_result(poses, capacity, n_found, NULL, &solver->work.pose);
    if (status < 0) {
        return status;
    }
    *n_inliers = count;
    if (expected > CHANCE) {
        return RIGCAL_FEW_AGREE;
    }
    return (status == RIGCAL_OK && 2 * count < n) ? RIGCAL_MOST_DISAGREE : status;
}

rigcal_status rigcal_robust_solve(rigcal_pose poses[], size_t capacity, size_t *n_found,
                                  uint8_t inliers[], size_t *n_inliers, int32_t *at_fault,
                                  const rigcal_view *view,
                                  const rigcal_robust_options *options)
{
    rigcal_robust_solver solver;
    rc_write_fault(at_fault, -1);
    if (poses == NULL || n_found == NULL || n_inliers == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (capacity < 1) {
        return RIGCAL_ERR_RANGE;
    }
    const rigcal_status status =
        rigcal_robust_begin(&solver, inliers, at_fault, view, options);
    if (status != RIGCAL_OK) {
        return status;
    }
    while (solver.phase != DONE) {
        (void)rigcal_robust_step(&solver, INT32_MAX);
    }
    return rigcal_robust_result(poses, capacity, n_found, n_inliers, &solver);
}
