#include <string.h>

#include "rc_agree.h"
#include "rc_logs.h"
#include "rc_pose.h"
#include "rc_sample.h"

/* ---- constants ----------------------------------------------------------- */

/* points: fewer are an error. Any three of four points agree with a pose, and one more may
 * agree by chance. */
enum { POINTS_LEAST = 5 };

/* samples: the default. If nine in ten of many points are wrong, this many samples miss
 * every clean one with a chance of 1e-3, by USEFUL_PART. */
enum { SAMPLES = 10000 };

/* samples: more are a mistake. */
enum { SAMPLES_MAX = 100000 };

/* units: the default for the search. A triple usually takes 3, or 5 through a lens. */
enum { UNITS = 100000 };

/* px: a point agrees if it is off by no more than this. It serves if no noise is stated. */
#define THRESHOLD_PX RC(3)

/* times the noise stated: a point agrees if it is off by no more than this. */
#define THRESHOLD_SIGMAS RC(4)

/* logs: samples end when the chance to have missed every clean sample is below
 * exp(-this). */
#define MISSED_LOG RC(6.9)

/* part: a clean sample counts as this much of one, because noise spoils some. For general
 * targets 0.9 of them lead to the pose. */
#define USEFUL_PART RC(0.7)

/* points: a pose is not improved if fewer points agree with it. */
enum { IMPROVED_LEAST = 5 };

/* points: if fewer agree, the pose always has the caveat. A wrong point among them would
 * find others that agree with it. */
enum { SURE_LEAST = 6 };

/* evaluations: a best pose is improved by this many, over the points that agree. */
enum { IMPROVE_EVALS = 3 };

/* times: a best pose is improved at most this often, while it gets better. */
enum { IMPROVE_ROUNDS = 4 };

/* times: the points that agree are chosen again at most this often, by the pose of the last
 * ones. */
enum { ROUNDS = 8 };

/* limits: a pose is a rival if its score is above the best one's by less than this many
 * points that disagree. */
#define RIVAL_WITHIN RC(0.7)

/* limits: while triples are tried, a pose that far above the best is improved too. */
#define IMPROVED_WITHIN RC(2)

/* rad, part of the distance: poses that differ by less are one. */
#define POSES_APART RC(0.05)

/* poses expected by chance: above this, times the fourth power of the misfit, the pose has
 * a caveat. Of 270 000 scenes with all points wrong at most 3 are below. */
#define CHANCE RC(5e-5)

/* part: a smaller misfit counts as this. Noise and the wrong pixels make as much. */
#define MISFIT_LEAST RC(0.1)

/* poses expected by chance: with this number or more, no pose is returned. */
#define CHANCE_MOST RC(0.3)

enum {
    NOT_BEGUN = 0,
    SEEING,  /* the rays of a triple, and its poses */
    SCORING, /* one of the poses */
    MARKING, /* the points that agree with a new best pose */
    IMPROVING,
    RESCORING,
    SIGHTING, /* the ray of each point, if rays cost much */
    SETTLING, /* the points that agree with the best pose, once more */
    REFINING,
    SOLVING,
    SOLVED,
    FITTING,   /* whether the target lies where the pixels do */
    RIVALLING, /* whether a rival is nearly as good */
    DONE
};

static rigcal_real limit_of(const rigcal_robust_solver *s)
{
    return s->threshold_px * s->threshold_px;
}

/* ---- phases -------------------------------------------------------------- */

static void fail(rigcal_robust_solver *s, rigcal_status status)
{
    s->failure = status;
    s->phase = DONE;
}

/* If all triples are tried, the next one's number is far from this one's. */
static void next_sample(rigcal_robust_solver *s)
{
    if (s->is_complete) {
        rc_sample_ranked(s->sample, (int32_t)s->points.view.n, s->rank);
        s->rank += (s->rank < s->samples - s->stride) ? s->stride : s->stride - s->samples;
    } else {
        rc_sample_random(s->sample, &s->random, s->points.view.n);
    }
}

static void begin_settling(rigcal_robust_solver *s)
{
    s->next = 0;
    s->rounds = 0;
    s->phase = s->points.is_pinhole ? SETTLING : SIGHTING;
}

/* Goes to the next triple, unless there have been enough. */
static void end_sample(rigcal_robust_solver *s)
{
    s->tried++;
    s->next = 0;
    s->phase = SEEING;
    if (s->tried >= s->wanted) {
        begin_settling(s);
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

/* Computes one ray, or all three of a pinhole, whose rays cost nearly nothing. */
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

/* Decides how many samples are enough if `count` points agree with the best pose. N random
 * samples miss all useful triples with the chance exp(-useful N / all). If each triple is
 * drawn once, the chance is (1 - N / all)^useful. */
static void decide_samples(rigcal_robust_solver *s, size_t count)
{
    const rigcal_real samples = (rigcal_real)s->samples;
    rigcal_real part = USEFUL_PART, enough;
    for (int k = 0; k < 3; k++) {
        part *= ((rigcal_real)count - (rigcal_real)k) /
                ((rigcal_real)s->points.view.n - (rigcal_real)k);
    }
    if (s->is_complete) {
        enough =
            (part > 0) ? samples * (1 - rc_exp(-MISSED_LOG / (part * samples))) : samples;
    } else {
        enough = (MISSED_LOG < part * samples) ? MISSED_LOG / part : samples;
    }
    s->wanted = (int32_t)enough + 1;
    if (s->wanted > s->samples) {
        s->wanted = s->samples;
    }
}

/* Whether the pose scores below `most`. If so, it is the one that is improved. */
static int is_good(rigcal_robust_solver *s, const rigcal_transform *pose, rigcal_real most)
{
    rigcal_trial_poses *const trial = &s->work.trial;
    rigcal_real cost;
    const size_t count = rc_agree_score(&cost, &s->points, pose, limit_of(s), most);
    if (!(cost < most)) {
        return 0;
    }
    trial->good = *pose;
    trial->good_cost = cost;
    trial->n_good = count;
    return 1;
}

/* The pose that was improved becomes the best or its rival, if it is as good. A rival
 * differs from the best. */
static void take_good(rigcal_robust_solver *s)
{
    rigcal_trial_poses *const trial = &s->work.trial;
    const int is_other = rc_agree_differ(&trial->good, &trial->best, POSES_APART);
    if (trial->good_cost < trial->cost) {
        if (is_other && trial->cost < RC_MAX) {
            s->rival = trial->best;
            s->rival_cost = trial->cost;
        } else if (!rc_agree_differ(&trial->good, &s->rival, POSES_APART)) {
            s->rival_cost = RC_MAX;
        }
        trial->cost = trial->good_cost;
        trial->best = trial->good;
        decide_samples(s, trial->n_good);
    } else if (is_other && trial->good_cost < s->rival_cost) {
        s->rival = trial->good;
        s->rival_cost = trial->good_cost;
    }
}

/* The score below which a pose of three points is improved. */
static rigcal_real good_below(const rigcal_robust_solver *s)
{
    const rigcal_real cost = s->work.trial.cost;
    return (cost < RC_MAX) ? cost + IMPROVED_WITHIN * limit_of(s) : cost;
}

/* Goes to the next pose of the triple, or to the next triple. */
static void end_pose(rigcal_robust_solver *s)
{
    s->phase = SCORING;
    s->rounds = 0;
    if (s->next == s->n_poses) {
        end_sample(s);
    }
}

/* A pose near the best is not improved if most points agree with it: it would become the
 * same. */
static void scoring_step(rigcal_robust_solver *s)
{
    const rigcal_trial_poses *const trial = &s->work.trial;
    if (!is_good(s, &trial->tried[s->next++], good_below(s))) {
        end_pose(s);
    } else if (trial->n_good >= IMPROVED_LEAST &&
               (trial->good_cost < trial->cost || 2 * trial->n_good < s->points.view.n ||
                rc_agree_differ(&trial->good, &trial->best, POSES_APART))) {
        s->phase = MARKING;
    } else {
        take_good(s);
        end_pose(s);
    }
}

/* ---- the best pose, improved ---------------------------------------------- */

static void begin_improving(rigcal_robust_solver *s, const rigcal_transform *pose,
                            int32_t phase)
{
    rigcal_trial_poses *const trial = &s->work.trial;
    rc_refine_begin(&trial->better, 0);
    trial->better.cam_from_points = *pose;
    s->phase = phase;
}

/* Evaluates the marked points once. Returns 1 after the last of IMPROVE_EVALS. */
static int improve(rigcal_robust_solver *s)
{
    rigcal_refinement *const better = &s->work.trial.better;
    s->points.mask = s->inliers;
    rc_refine_step(better, &s->points, IMPROVE_EVALS);
    s->points.mask = NULL;
    return better->search.status != RIGCAL_RUNNING;
}

static void marking_step(rigcal_robust_solver *s)
{
    const rigcal_transform *const good = &s->work.trial.good;
    (void)rc_agree_mark(s->inliers, NULL, &s->points, good, limit_of(s));
    begin_improving(s, good, IMPROVING);
}

static void improving_step(rigcal_robust_solver *s)
{
    if (improve(s)) {
        s->phase = RESCORING;
    }
}

static void rescoring_step(rigcal_robust_solver *s)
{
    rigcal_trial_poses *const trial = &s->work.trial;
    if (is_good(s, &trial->better.cam_from_points, trial->good_cost) &&
        ++s->rounds < IMPROVE_ROUNDS) {
        s->phase = MARKING;
    } else {
        take_good(s);
        end_pose(s);
    }
}

/* ---- the points that agree ------------------------------------------------ */

/* Begins to solve the pose of the marked points. The phase is DONE if they are too few, or
 * on a line. */
static void begin_solving(rigcal_robust_solver *s)
{
    rigcal_pose_options options;
    rigcal_points agreeing;
    (void)rigcal_pose_defaults(&options);
    options.sigma_px = s->sigma_px;
    rc_points_of(&agreeing, &s->points.view, s->inliers);
    if (rc_pose_begin(&s->work.pose, NULL, &agreeing, &options) == RIGCAL_OK) {
        s->phase = SOLVING;
    } else {
        fail(s, RIGCAL_ERR_NO_CONSENSUS);
    }
}

/* Computes one ray. A point without a ray agrees with no pose. */
static void sighting_step(rigcal_robust_solver *s)
{
    const rigcal_view *const view = &s->points.view;
    const size_t i = (size_t)s->next++;
    rigcal_real ray[3];
    if (rc_pixel_to_ray(ray, view->camera, view->observations[i].uv) != RIGCAL_OK) {
        s->inliers[i] = RC_AGREE_NO_RAY;
    }
    if (i + 1 == view->n) {
        s->phase = SETTLING;
    }
}

/* Marks the points that agree with the best pose, and refines it until they stay the same.
 * A search by all points would cost far more. */
static void settling_step(rigcal_robust_solver *s)
{
    rigcal_trial_poses *const trial = &s->work.trial;
    if (!(trial->cost < RC_MAX)) {
        fail(s, RIGCAL_ERR_NO_CONSENSUS);
        return;
    }
    s->cost = trial->cost;
    if (rc_agree_mark(s->inliers, NULL, &s->points, &trial->best, limit_of(s)) > 0 &&
        s->rounds++ < IMPROVE_ROUNDS) {
        begin_improving(s, &trial->best, REFINING);
    } else {
        s->rounds = 0;
        begin_solving(s);
    }
}

static void refining_step(rigcal_robust_solver *s)
{
    rigcal_trial_poses *const trial = &s->work.trial;
    if (improve(s)) {
        trial->best = trial->better.cam_from_points;
        s->phase = SETTLING;
    }
}

static void solving_step(rigcal_robust_solver *s)
{
    if (rigcal_pose_step(&s->work.pose, 1) != RIGCAL_RUNNING) {
        s->phase = SOLVED;
    }
}

/* Pose i of those found, best first, for points as all of them are centred. */
static void found_pose(rigcal_transform *cam_from_points, const rigcal_robust_solver *s,
                       int32_t i)
{
    rigcal_real shift[3], turned[3];
    rc_pose_found(cam_from_points, &s->work.pose, i);
    rc_vec3_sub(shift, s->points.origin, rc_pose_origin(&s->work.pose));
    rc_mat3_mul_vec3(turned, cam_from_points->R, shift);
    rc_vec3_add(cam_from_points->t, turned);
}

/* Sets the mark of each point to 1 if it agrees, else to 0. The search is done. */
static void finish(rigcal_robust_solver *s)
{
    for (size_t i = 0; i < s->points.view.n; i++) {
        s->inliers[i] = s->inliers[i] == RC_AGREE_YES;
    }
    s->phase = DONE;
}

/* Whether the rival agrees with other points and is none of the poses found. */
static void rivalling_step(rigcal_robust_solver *s)
{
    rigcal_transform found;
    int is_rival = 1;
    for (int32_t i = rc_pose_n_found(&s->work.pose); i > 0 && is_rival; i--) {
        found_pose(&found, s, i - 1);
        is_rival = rc_agree_differ(&s->rival, &found, POSES_APART);
    }
    if (is_rival) { /* `found` is the best pose, whose marks come back */
        s->is_doubtful =
            rc_agree_mark(s->inliers, NULL, &s->points, &s->rival, limit_of(s)) > 0;
        (void)rc_agree_mark(s->inliers, NULL, &s->points, &found, limit_of(s));
    }
    finish(s);
}

/* Whether chance may explain that the points agree. If not, a rival nearly as good as the
 * best pose is looked at. */
static void fitting_step(rigcal_robust_solver *s)
{
    rigcal_transform best;
    found_pose(&best, s, 0);
    const rigcal_real misfit = rc_max(rc_agree_misfit(&s->points, &best), MISFIT_LEAST);
    const rigcal_real squared = misfit * misfit;
    s->is_doubtful = !(s->by_chance * squared * squared < CHANCE);
    const int has_rival = s->rival_cost < s->cost + RIVAL_WITHIN * limit_of(s);
    if (!s->is_doubtful && has_rival) {
        s->phase = RIVALLING;
    } else {
        finish(s);
    }
}

/* Marks the points that agree with the pose found. If they changed, it solves again. */
static void solved_step(rigcal_robust_solver *s)
{
    rigcal_pose pose;
    rigcal_transform found;
    size_t n_found;
    rc_agree_histogram off;
    s->failure = rigcal_pose_result(&pose, 1, &n_found, NULL, &s->work.pose);
    s->phase = DONE;
    if (s->failure < 0) {
        return;
    }
    found_pose(&found, s, 0);
    if (rc_agree_mark(s->inliers, &off, &s->points, &found, limit_of(s)) > 0 &&
        s->rounds++ < ROUNDS) {
        begin_solving(s);
    } else {
        for (int k = 0; k < RC_AGREE_BINS; k++) {
            s->n_agree += off.count[k];
        }
        s->by_chance = rc_agree_by_chance(&off, s->points.view.n, s->area_px2, CHANCE);
        s->phase = FITTING;
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
    options->max_units = UNITS;
    return RIGCAL_OK;
}

static rigcal_status check_options(const rigcal_robust_options *o)
{
    rigcal_status status = rc_check_noise(&o->threshold_px);
    const rigcal_status sigma_status = rc_check_noise(&o->sigma_px);
    if (status == RIGCAL_OK || sigma_status == RIGCAL_ERR_NOT_FINITE) {
        status = sigma_status;
    }
    if (status == RIGCAL_OK &&
        (o->samples < 1 || o->samples > SAMPLES_MAX || o->max_units < 1)) {
        status = RIGCAL_ERR_RANGE;
    }
    return status;
}

/* Fills in *s for points that have been surveyed. */
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
    s->max_units = o->max_units;
    s->is_complete = rc_count_triples(n) <= (size_t)o->samples;
    if (s->is_complete) {
        s->samples = (int32_t)rc_count_triples(n);
        s->stride = rc_sample_stride(s->samples);
    }
    s->wanted = s->samples;
    s->work.trial.cost = s->rival_cost = RC_MAX;
    next_sample(s);
    memset(inliers, 0, n);
    s->area_px2 = rc_agree_area(&points->view);
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

static void unit(rigcal_robust_solver *s)
{
    switch (s->phase) {
    case SEEING:
        seeing_step(s);
        break;
    case SCORING:
        scoring_step(s);
        break;
    case MARKING:
        marking_step(s);
        break;
    case IMPROVING:
        improving_step(s);
        break;
    case RESCORING:
        rescoring_step(s);
        break;
    case SIGHTING:
        sighting_step(s);
        break;
    case SETTLING:
        settling_step(s);
        break;
    case REFINING:
        refining_step(s);
        break;
    case SOLVING:
        solving_step(s);
        break;
    case SOLVED:
        solved_step(s);
        break;
    case FITTING:
        fitting_step(s);
        break;
    default:
        rivalling_step(s);
        break;
    }
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
        if (solver->phase < SIGHTING && solver->units++ == solver->max_units) {
            if (solver->phase >= MARKING) {
                take_good(solver);
            }
            begin_settling(solver);
        }
        unit(solver);
    }
    return (solver->phase == DONE) ? RIGCAL_OK : RIGCAL_RUNNING;
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
    const size_t n = solver->points.view.n, count = solver->n_agree;
    if (!(solver->by_chance < CHANCE_MOST)) {
        return RIGCAL_ERR_NO_CONSENSUS;
    }
    const rigcal_status status =
        rigcal_pose_result(poses, capacity, n_found, NULL, &solver->work.pose);
    if (status < 0) {
        return status;
    }
    *n_inliers = count;
    if (count < SURE_LEAST || solver->is_doubtful) {
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
