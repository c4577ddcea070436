#include "rc_robust.h"

/* Defaults: samples; how far a point may be off, in pixels and in noise. */
enum { SAMPLES = 500, SAMPLES_MAX = 100000 };
#define THRESHOLD_PX RC(3)
#define THRESHOLD_SIGMAS RC(4)
#define THRESHOLD_MIN RC(1e-6)
#define THRESHOLD_MAX RC(1e6)

/* Random samples end when the chance to have missed every clean one is this. Noise
 * spoils some clean ones: a sample counts as a part of one. */
#define MISSED RC(1e-4)
#define USEFUL_PART RC(0.25)

/* How often the inliers are decided anew by the pose of the last ones. */
enum { ROUNDS = 8 };

/* Expected number of sets of points that agree so by chance, below which they do
 * not, and above which nothing is told. */
#define CHANCE RC(1e-3)
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
    return (n > 1000) ? RC_COUNT_MAX : n * (n - 1) / 2 * (n - 2) / 3;
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
    if (s->is_complete) {
        next_in_order(s->sample, (int32_t)s->n);
        return;
    }
    for (int k = 0; k < 3; k++) { /* distinct: skips what is taken, in order */
        size_t i = draw(s, s->n - (size_t)k);
        const size_t low =
            (size_t)((s->sample[0] < s->sample[1]) ? s->sample[0]
                                                   : s->sample[1]);
        const size_t high =
            (size_t)((s->sample[0] < s->sample[1]) ? s->sample[1]
                                                   : s->sample[0]);
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

/* Squared distance [px^2] of point i from its projection, over sigma_i^2. */
static rigcal_real distance2(const rigcal_fit *fit,
                             const rigcal_transform *pose, size_t i)
{
    const rigcal_real squared = rc_fit_distance2(fit, pose, i);
    return (fit->sigma == NULL) ? squared
                                : squared / (fit->sigma[i] * fit->sigma[i]);
}

/* Sum of the squared distances, none counting more than the threshold's; above
 * `enough` it is not finished. *count: points within. */
static rigcal_real score(size_t *count, const rigcal_robust_solver *s,
                         const rigcal_fit *fit, const rigcal_transform *pose,
                         rigcal_real enough)
{
    const rigcal_real limit = s->threshold_px * s->threshold_px;
    rigcal_real sum = 0;
    *count = 0;
    for (size_t i = 0; i < s->n && sum < enough; i++) {
        const rigcal_real d2 = distance2(fit, pose, i);
        *count += d2 <= limit;
        sum += rc_min(d2, limit);
    }
    return sum;
}

/* Marks the points within the threshold; *changed: whether any mark changed. */
static void mark(rigcal_robust_solver *s, const rigcal_fit *fit,
                 const rigcal_transform *pose, int *changed)
{
    const rigcal_real limit = s->threshold_px * s->threshold_px;
    *changed = 0;
    for (size_t i = 0; i < s->n; i++) {
        const uint8_t is_in = distance2(fit, pose, i) <= limit;
        *changed |= is_in != s->inliers[i];
        s->inliers[i] = is_in;
    }
}

/* ---- phases -------------------------------------------------------------- */

/* The next triple, unless there have been enough. */
static void end_sample(rigcal_robust_solver *s)
{
    const rigcal_real part = (rigcal_real)s->n_agree / (rigcal_real)s->n;
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

static void begin_scoring(rigcal_robust_solver *s, const rigcal_fit *fit)
{
    rigcal_robust_poses *const some = &s->work.some;
    s->n_poses = rc_poses_of_three(some->tried, fit, s->sample,
                                   (const rigcal_real(*)[3])some->ray);
    s->next = 0;
    s->phase = SCORING;
    if (s->n_poses == 0) {
        end_sample(s);
    }
}

/* One ray; of a pinhole, whose rays cost next to nothing, all three. */
static void seeing_step(rigcal_robust_solver *s, const rigcal_fit *fit)
{
    do {
        const rigcal_observation *const o =
            &s->observations[s->sample[s->next]];
        if (rc_pixel_to_ray(s->work.some.ray[s->next], s->camera, o->uv) !=
            RIGCAL_OK) {
            end_sample(s);
            return;
        }
        s->next++;
    } while (s->next < 3 && fit->lens.is_pinhole);
    if (s->next == 3) {
        begin_scoring(s, fit);
    }
}

static void scoring_step(rigcal_robust_solver *s, const rigcal_fit *fit)
{
    rigcal_robust_poses *const some = &s->work.some;
    const rigcal_transform *const pose = &some->tried[s->next++];
    size_t count;
    const rigcal_real cost = score(&count, s, fit, pose, some->cost);
    if (cost < some->cost) {
        some->cost = cost;
        some->best = *pose;
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
    rigcal_fit data;
    (void)rigcal_pose_defaults(&options);
    options.sigma_px = s->sigma_px;
    rc_fit_of(&data, s->camera, s->observations, s->sigma, s->inliers, s->n);
    s->failure = rc_pose_begin(&s->work.pose, NULL, &data, &options);
    if (s->failure == RIGCAL_ERR_TOO_FEW) {
        s->failure = RIGCAL_ERR_NO_CONSENSUS;
    }
    s->phase = (s->failure == RIGCAL_OK) ? SOLVING : DONE;
}

static void agreeing_step(rigcal_robust_solver *s, const rigcal_fit *fit)
{
    int changed;
    if (!(s->work.some.cost < RC_MAX)) {
        s->failure = RIGCAL_ERR_NO_CONSENSUS;
        s->phase = DONE;
        return;
    }
    mark(s, fit, &s->work.some.best, &changed);
    begin_solving(s);
}

/* The inliers of the pose found, and its solution again when they are others. */
static void end_solving(rigcal_robust_solver *s, const rigcal_fit *fit)
{
    rigcal_pose poses[1];
    size_t n_found;
    int changed;
    s->failure = rigcal_pose_result(poses, &n_found, 1, NULL, &s->work.pose);
    s->phase = DONE;
    if (s->failure < 0 || s->rounds++ >= ROUNDS) {
        return;
    }
    rigcal_transform from_points = poses[0].cam_from_world;
    rc_transform_point(from_points.t, &poses[0].cam_from_world, s->origin);
    mark(s, fit, &from_points, &changed);
    if (changed) {
        begin_solving(s);
    }
}

static void solving_step(rigcal_robust_solver *s)
{
    if (rigcal_pose_step(&s->work.pose, 1) != RIGCAL_RUNNING) {
        s->phase = SOLVED;
    }
}

/* ---- chance -------------------------------------------------------------- */

/* Expected number of sets of `count` points that agree although all are wrong: three
 * choose a pose, with two solutions, the others are each as near with the chance
 * that a disc has in the area of the image. A fit to all of them may take in points
 * twice as far from the three's own pose. */
static rigcal_real by_chance(const rigcal_robust_solver *s, size_t count)
{
    const rigcal_real n = (rigcal_real)s->n, limit = 2 * s->threshold_px;
    const rigcal_real near = rc_min(1, RC_PI * limit * limit / s->area_px2);
    rigcal_real expected = n * (n - 1) * (n - 2) / 3;
    for (size_t i = 0; i + 3 < count; i++) {
        const rigcal_real ways =
            (n - 3 - (rigcal_real)i) / (rigcal_real)(i + 1);
        expected = rc_min(expected * ways * near, RC(1e30));
    }
    return expected;
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
    if (!rc_is_finite(o->threshold_px) || !rc_is_finite(o->sigma_px)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    const int is_default = rc_all_within(&o->threshold_px, 1, 0);
    return ((is_default || (o->threshold_px >= THRESHOLD_MIN &&
                            o->threshold_px <= THRESHOLD_MAX)) &&
            o->samples >= 1 && o->samples <= SAMPLES_MAX)
               ? RIGCAL_OK
               : RIGCAL_ERR_RANGE;
}

/* The rectangle [px^2] in which the points were seen. */
static rigcal_real seen_area(const rigcal_observation o[], size_t n)
{
    rigcal_real area = 1;
    for (int k = 0; k < 2; k++) {
        rigcal_real low = o[0].uv[k], high = low;
        for (size_t i = 1; i < n; i++) {
            low = rc_min(low, o[i].uv[k]);
            high = rc_max(high, o[i].uv[k]);
        }
        area *= high - low;
    }
    return area;
}

/* rigcal_robust_begin, but that a failure may leave *s written. */
static rigcal_status begin(rigcal_robust_solver *s, int32_t *at,
                           uint8_t inliers[], const rigcal_camera *camera,
                           const rigcal_observation observations[],
                           const rigcal_real sigma[], size_t n,
                           const rigcal_robust_options *options)
{
    rigcal_pose_options pose_options;
    rigcal_robust_options defaults;
    rc_survey survey;
    rigcal_fit fit;
    *at = -1;
    (void)rigcal_robust_defaults(&defaults);
    const rigcal_robust_options *const o =
        (options != NULL) ? options : &defaults;
    if (inliers == NULL || camera == NULL || observations == NULL) {
        return RIGCAL_ERR_NULL;
    }
    (void)rigcal_pose_defaults(&pose_options);
    pose_options.sigma_px = o->sigma_px;
    rigcal_status status = rc_check_camera(camera);
    if (status == RIGCAL_OK) {
        status = check_options(o);
    }
    if (status == RIGCAL_OK && n < 5) {
        status = RIGCAL_ERR_TOO_FEW;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    *s = (rigcal_robust_solver){0};
    rc_fit_of(&fit, camera, observations, sigma, NULL, n);
    status = rc_pose_begin(&s->work.pose, at, &fit, &pose_options);
    if (status == RIGCAL_OK) {
        status = rc_survey_points(&survey, at, &fit);
    }
    if (status == RIGCAL_OK && rc_are_on_line(observations, n, survey.origin)) {
        status = RIGCAL_ERR_COLLINEAR;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    s->camera = camera;
    s->observations = observations;
    s->sigma = sigma;
    s->inliers = inliers;
    s->n = n;
    s->sigma_px = o->sigma_px;
    s->threshold_px = (o->threshold_px > 0) ? o->threshold_px
                      : (o->sigma_px > 0)   ? THRESHOLD_SIGMAS * o->sigma_px
                                            : THRESHOLD_PX * rc_pixel_size(camera);
    s->random = (o->seed != 0) ? o->seed : UINT32_C(0x9e3779b9);
    s->samples = o->samples;
    s->is_complete = count_triples(n) <= (size_t)o->samples;
    if (s->is_complete) {
        s->samples = (int32_t)count_triples(n);
    }
    s->work.some.cost = RC_MAX;
    s->missed = 1;
    s->sample[1] = 1;
    s->sample[2] = 2;
    if (!s->is_complete) {
        next_sample(s);
    }
    rc_vec3_copy(s->origin, survey.origin);
    s->area_px2 = seen_area(observations, n);
    s->phase = SEEING;
    return RIGCAL_OK;
}

rigcal_status rigcal_robust_begin(rigcal_robust_solver *solver,
                                  uint8_t inliers[], int32_t *bad,
                                  const rigcal_camera *camera,
                                  const rigcal_observation observations[],
                                  const rigcal_real sigma[], size_t n,
                                  const rigcal_robust_options *options)
{
    rigcal_robust_solver begun;
    int32_t at;
    rc_write_fault(bad, -1);
    if (solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status =
        begin(&begun, &at, inliers, camera, observations, sigma, n, options);
    rc_write_fault(bad, at);
    if (status == RIGCAL_OK) {
        *solver = begun;
    }
    return status;
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
    if (solver->phase == DONE) { /* reads nothing any more */
        return RIGCAL_OK;
    }
    rigcal_fit fit;
    rc_fit_of(&fit, solver->camera, solver->observations, solver->sigma,
              solver->inliers, solver->n);
    rc_fit_begin(&fit, solver->origin);
    for (int32_t i = 0; i < budget && solver->phase != DONE; i++) {
        switch (solver->phase) {
        case SEEING:
            seeing_step(solver, &fit);
            break;
        case SCORING:
            scoring_step(solver, &fit);
            break;
        case AGREEING:
            agreeing_step(solver, &fit);
            break;
        case SOLVING:
            solving_step(solver);
            break;
        default:
            end_solving(solver, &fit);
            break;
        }
    }
    return (solver->phase == DONE) ? RIGCAL_OK : RIGCAL_RUNNING;
}

rigcal_status rigcal_robust_result(rigcal_pose poses[], size_t *n_found,
                                   size_t *n_inliers, size_t capacity,
                                   const rigcal_robust_solver *solver)
{
    if (poses == NULL || n_found == NULL || n_inliers == NULL ||
        solver == NULL) {
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
    const size_t count = solver->work.pose.n_used;
    const rigcal_real chance = by_chance(solver, count);
    if (!(chance < CHANCE_MOST)) {
        return RIGCAL_ERR_NO_CONSENSUS;
    }
    const rigcal_status status =
        rigcal_pose_result(poses, n_found, capacity, NULL, &solver->work.pose);
    if (status >= 0) {
        *n_inliers = count;
    }
    if (status >= 0 && chance > CHANCE) {
        return RIGCAL_FEW_AGREE;
    }
    return (status == RIGCAL_OK && 2 * count < solver->n) ? RIGCAL_MOST_DISAGREE : status;
}

rigcal_status rigcal_solve_pose_robust(rigcal_pose poses[], size_t *n_found,
                                       uint8_t inliers[], size_t *n_inliers,
                                       size_t capacity, int32_t *bad,
                                       const rigcal_camera *camera,
                                       const rigcal_observation observations[],
                                       const rigcal_real sigma[], size_t n,
                                       const rigcal_robust_options *options)
{
    rigcal_robust_solver solver;
    int32_t at;
    rc_write_fault(bad, -1);
    if (poses == NULL || n_found == NULL || n_inliers == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (capacity < 1) {
        return RIGCAL_ERR_RANGE;
    }
    const rigcal_status status =
        begin(&solver, &at, inliers, camera, observations, sigma, n, options);
    rc_write_fault(bad, at);
    if (status != RIGCAL_OK) {
        return status;
    }
    while (solver.phase != DONE) {
        (void)rigcal_robust_step(&solver, INT32_MAX);
    }
    return rigcal_robust_result(poses, n_found, n_inliers, capacity, &solver);
}
