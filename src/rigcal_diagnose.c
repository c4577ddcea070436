#include "rc_pose.h"

/* ---- constants ----------------------------------------------------------- */

/* points: the least number. If one of four is left out, any three fit. */
enum { POINTS_LEAST = 5 };

/* chance of noise alone: below it one point is surely wrong. A usual level of a test. */
#define SURE_CHANCE RC(0.01)

/* chance of noise alone: below it one point is suspected. */
#define LIKELY_CHANCE RC(0.1)

/* probability: with this or more, the point is called the wrong one for certain. */
#define SURE_PROBABILITY RC(0.99)

/* odds of the data as given to those mirrored: if they are less, the data are mirrored. */
#define MIRRORED_ODDS RC(1e-3)

/* ratio: two distances whose ratio is within this factor of a usual mistake of units have
 * this mistake. */
#define UNITS_NEAR RC(1.1)

/* Ratios of lengths that come from mistakes of units. */
static const rigcal_real UNITS[4] = {10, RC(25.4), 100, 1000};

/* ---- fits ---------------------------------------------------------------- */

typedef struct {
    rigcal_points points; /* every fit surveys them again */
    rigcal_pose_options options;
} problem;

/* The best pose of the points that count. Returns the status of its result. */
RC_APART static rigcal_status best_fit(rigcal_pose *pose, problem *P)
{
    rigcal_pose_solver solver;
    size_t n_found;
    const rigcal_status status = rc_pose_begin(&solver, NULL, &P->points, &P->options);
    if (status != RIGCAL_OK) {
        return status;
    }
    (void)rigcal_pose_step(&solver, INT32_MAX);
    return rigcal_pose_result(pose, 1, &n_found, NULL, &solver);
}

static rigcal_real odds(const problem *P, rigcal_real sse, rigcal_real other, size_t n)
{
    return rc_odds(sse, other, P->options.sigma_px, rc_pixel_size(P->points.view.camera),
                   n);
}

/* ---- one point ----------------------------------------------------------- */

/* What is known after some points were left out in turn. */
typedef struct {
    rigcal_real best, total; /* least sum of squares; sum of likelihoods over that of the
                                best */
} tried;

/* Fits all points but i. */
static void leave_out(rigcal_blame *blame, rigcal_real rms_without[], tried *so_far,
                      problem *P, size_t i)
{
    rigcal_pose pose;
    P->points.left_out = (int32_t)i;
    const rigcal_status status = best_fit(&pose, P);
    P->points.left_out = -1;
    if (status < 0) {
        return;
    }
    if (rms_without != NULL) {
        rms_without[i] = pose.rms_px;
    }
    const int is_best = pose.sse < so_far->best;
    const rigcal_real ratio =
        (so_far->best < RC_MAX) ? odds(P, pose.sse, so_far->best, P->points.view.n - 1) : 1;
    so_far->total = is_best ? 1 + so_far->total / ratio : so_far->total + ratio;
    if (is_best) {
        so_far->best = pose.sse;
        blame->point = (int32_t)i;
        blame->rms_without_px = pose.rms_px;
        blame->is_rest_poor = status == RIGCAL_POOR_FIT;
    }
}

/* The point farthest from its projection among those nearer than *distance2, which becomes
 * its squared distance. Returns n if there is none. Points of equal distance count as
 * one. */
static size_t next_farthest(rigcal_real *distance2, const rigcal_points *points,
                            const rigcal_transform *cam_from_points)
{
    const size_t n = points->view.n;
    rigcal_real most = -1;
    size_t at = n;
    for (size_t i = 0; i < n; i++) {
        const rigcal_real d2 = rc_points_error2(points, cam_from_points, i);
        if (d2 < *distance2 && d2 > most) {
            most = d2;
            at = i;
        }
    }
    *distance2 = most;
    return at;
}

/* If there are more points than can be tried, leaves out those farthest from their
 * projections. */
static void leave_out_farthest(rigcal_blame *blame, rigcal_real rms_without[],
                               tried *so_far, problem *P,
                               const rigcal_transform *cam_from_world)
{
    rigcal_points points = P->points;
    rigcal_transform cam_from_points = *cam_from_world;
    rigcal_real distance2 = RC_MAX, uv_middle[2];
    int32_t at;
    (void)rc_points_survey(&points, uv_middle, &at);
    rc_transform_point(cam_from_points.t, cam_from_world, points.origin);
    for (int k = 0; k < RIGCAL_BLAME_TRIES; k++) {
        const size_t i = next_farthest(&distance2, &points, &cam_from_points);
        if (i == points.view.n) {
            return;
        }
        leave_out(blame, rms_without, so_far, P, i);
    }
}

/* Fills all of *blame from the fit of all points: `status`, and `pose` if it has one. The
 * verdict assumes that each point has its share of the noise. Leaving point i out lowers
 * the sum from S to S_i. The chance that the best of n does so is at most n (S_i / S)^(n -
 * 4), an F test of 2 and 2 n - 8 degrees of freedom. If the noise is known it is n exp(-(S
 * - S_i) / (2 sigma^2)). */
static void find_blame(rigcal_blame *blame, rigcal_real rms_without[], problem *P,
                       const rigcal_pose *pose, rigcal_status status)
{
    const size_t n = P->points.view.n;
    tried so_far = {RC_MAX, 0};
    *blame = (rigcal_blame){0};
    blame->point = -1;
    blame->chance = 1;
    blame->rms_px = (status >= 0) ? pose->rms_px : -1;
    for (size_t i = 0; rms_without != NULL && i < n; i++) {
        rms_without[i] = -1;
    }
    if (n > RIGCAL_BLAME_TRIES && status >= 0) {
        leave_out_farthest(blame, rms_without, &so_far, P, &pose->cam_from_world);
    } else {
        for (size_t i = 0; i < n && i < RIGCAL_BLAME_TRIES; i++) {
            leave_out(blame, rms_without, &so_far, P, i);
        }
    }
    if (blame->point < 0) {
        return;
    }
    const rigcal_real sse = (status >= 0) ? pose->sse : RC_MAX;
    blame->probability = 1 / so_far.total;
    blame->chance = rc_min(1, (rigcal_real)n * odds(P, sse, so_far.best, n - 1));
    if (blame->chance <= SURE_CHANCE && blame->probability >= SURE_PROBABILITY) {
        blame->verdict = RIGCAL_BLAME_SURE;
    } else if (blame->chance <= LIKELY_CHANCE) {
        blame->verdict = RIGCAL_BLAME_LIKELY;
    }
}

/* Whether a wrong point may be the cause of this status. */
static int may_be_a_point(rigcal_status status)
{
    return status >= 0 || status == RIGCAL_ERR_NO_POSE || status == RIGCAL_ERR_NO_RAY ||
           status == RIGCAL_ERR_WIDE_RAY || status == RIGCAL_ERR_DEGENERATE;
}

/* Sets the problem from a caller's arguments. Checks what rc_pose_begin does not check. */
static rigcal_status begin(problem *P, const rigcal_view *view,
                           const rigcal_pose_options *options)
{
    const rigcal_status status = rc_check_view(view);
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_points_of(&P->points, view, NULL);
    (void)rigcal_pose_defaults(&P->options);
    if (options != NULL) {
        P->options = *options;
    }
    return (view->n < POINTS_LEAST) ? RIGCAL_ERR_TOO_FEW : RIGCAL_OK;
}

rigcal_status rigcal_pose_blame(rigcal_blame *blame, rigcal_real rms_without[],
                                const rigcal_view *view, const rigcal_pose_options *options)
{
    problem P;
    rigcal_pose pose;
    if (blame == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = begin(&P, view, options);
    if (status != RIGCAL_OK) {
        return status;
    }
    status = best_fit(&pose, &P);
    if (!may_be_a_point(status)) {
        return status;
    }
    find_blame(blame, rms_without, &P, &pose, status);
    return RIGCAL_OK;
}

/* ---- mirrors and units --------------------------------------------------- */

/* Fits the mirrored target as `camera` sees it. Returns whether it fits well and is much
 * likelier than the points as given. *unlike: whether it is much less likely. */
static int fits_mirrored(rigcal_real *rms_px, int *unlike, const problem *P,
                         const rigcal_camera *camera, rigcal_real sse, rigcal_status status)
{
    problem other = *P;
    rigcal_pose pose;
    const size_t n = P->points.view.n;
    other.points.view.camera = camera;
    other.points.is_mirrored = 1;
    const rigcal_status mirrored_status = best_fit(&pose, &other);
    *rms_px = (mirrored_status >= 0) ? pose.rms_px : -1;
    *unlike =
        mirrored_status < 0 || (status >= 0 && odds(P, pose.sse, sse, n) < MIRRORED_ODDS);
    return mirrored_status >= 0 && mirrored_status != RIGCAL_POOR_FIT &&
           (status < 0 || odds(P, sse, pose.sse, n) < MIRRORED_ODDS);
}

/* The mistake of units that a ratio of distances is close to, or 0. */
static rigcal_real units_of(rigcal_real ratio)
{
    for (int k = 0; k < 4; k++) {
        const rigcal_real many = ratio / UNITS[k], few = ratio * UNITS[k];
        if (many < UNITS_NEAR && many * UNITS_NEAR > 1) {
            return UNITS[k];
        }
        if (few < UNITS_NEAR && few * UNITS_NEAR > 1) {
            return 1 / UNITS[k];
        }
    }
    return 0;
}

static void judge(rigcal_diagnosis *d, rigcal_status status, int is_mirrored)
{
    const int is_poor = status < 0 || status == RIGCAL_POOR_FIT;
    const int is_one = d->blame.verdict == RIGCAL_BLAME_SURE && !d->blame.is_rest_poor;
    const rigcal_real mirrored_px =
        (d->rms_flipped_px >= 0 &&
         (d->rms_mirrored_px < 0 || d->rms_flipped_px < d->rms_mirrored_px))
            ? d->rms_flipped_px
            : d->rms_mirrored_px;
    if (is_mirrored && (!is_one || mirrored_px < d->blame.rms_without_px)) {
        d->verdict = RIGCAL_DIAGNOSIS_MIRRORED;
    } else if (!is_poor) {
        d->verdict = (d->units > 0) ? RIGCAL_DIAGNOSIS_UNITS : RIGCAL_DIAGNOSIS_CONSISTENT;
    } else {
        d->verdict = is_one ? RIGCAL_DIAGNOSIS_ONE_POINT : RIGCAL_DIAGNOSIS_UNEXPLAINED;
    }
}

/* A camera whose image is that of `camera` flipped: v becomes height - 1 - v. */
static void flip(rigcal_camera *flipped, const rigcal_camera *camera)
{
    *flipped = *camera;
    flipped->cy = (rigcal_real)(camera->height - 1) - camera->cy;
    flipped->p1 = -camera->p1;
}

rigcal_status rigcal_pose_diagnose(rigcal_diagnosis *diagnosis, rigcal_real rms_without[],
                                   const rigcal_view *view,
                                   const rigcal_pose_options *options)
{
    problem P;
    rigcal_pose pose = {0};
    rigcal_diagnosis d = {0};
    rigcal_camera flipped;
    int unlike[2];
    if (diagnosis == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = begin(&P, view, options);
    if (status == RIGCAL_OK && P.options.use_start == 1) {
        status = rc_check_transform(&P.options.start);
        P.options.use_start = 0;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    const rigcal_status fitted = best_fit(&pose, &P);
    if (!may_be_a_point(fitted)) {
        return fitted;
    }
    find_blame(&d.blame, rms_without, &P, &pose, fitted);
    int is_mirrored =
        fits_mirrored(&d.rms_mirrored_px, &unlike[0], &P, view->camera, pose.sse, fitted);
    /* A flipped image is the image of a mirrored target in a flipped camera. */
    flip(&flipped, view->camera);
    is_mirrored |=
        fits_mirrored(&d.rms_flipped_px, &unlike[1], &P, &flipped, pose.sse, fitted);
    d.is_handed = is_mirrored || (unlike[0] && unlike[1]);
    if (options != NULL && options->use_start == 1 && fitted >= 0) {
        d.units =
            units_of(rc_vec3_norm(pose.cam_from_world.t) / rc_vec3_norm(options->start.t));
    }
    judge(&d, fitted, is_mirrored);
    *diagnosis = d;
    return RIGCAL_OK;
}
