#include "rc_diagnose.h"

/* Chances below which, and probabilities above which, one point is surely wrong, and
 * below which it is suspected. */
#define SURE_CHANCE RC(0.01)
#define SURE_PROBABILITY RC(0.99)
#define LIKELY_CHANCE RC(0.1)

/* How much likelier mirrored data must be to be told. */
#define MIRRORED_ODDS RC(1e-3)

/* Ratios of distances that are mistakes of units, and how near to one is that. */
static const rigcal_real UNITS[4] = {10, RC(25.4), 100, 1000};
#define UNITS_NEAR RC(1.1)

/* ---- fits ---------------------------------------------------------------- */

typedef struct {
    const rigcal_camera *camera;
    const rigcal_observation *observations;
    const rigcal_real *sigma;
    size_t n;
    rigcal_pose_options options;
} problem;

/* The best pose of the points whose mask is not 0, with the status of its result. */
static rigcal_status best_fit(rigcal_pose *pose, const problem *P,
                              const uint8_t mask[])
{
    rigcal_pose_solver solver;
    size_t n_found;
    const rigcal_status status =
        rc_pose_begin(&solver, NULL, P->camera, P->observations, P->sigma, mask, P->n,
                      &P->options);
    if (status != RIGCAL_OK) {
        return status;
    }
    while (rigcal_pose_step(&solver, INT32_MAX) == RIGCAL_RUNNING) {
    }
    return rigcal_pose_result(pose, &n_found, 1, NULL, &solver);
}

static rigcal_real odds(const problem *P, rigcal_real sse, rigcal_real other, size_t n)
{
    return rc_odds(sse, other, P->options.sigma_px, rc_pixel_size(P->camera), n);
}

/* ---- one point ----------------------------------------------------------- */

/* Every point left out in turn. rms_without[i] is -1 where the rest has no pose.
 * *verdict is for noise of which each point has its share: leaving point i out
 * lowers the sum from S to S_i, and the chance that the best of n does so is at most
 * n (S_i / S)^(n - 4), an F test of 2 and 2 n - 8 degrees of freedom; where the noise
 * is known, n exp(-(S - S_i) / (2 sigma^2)). */
static void leave_out(rigcal_blame *blame, rigcal_real rms_without[],
                      const problem *P, rigcal_real sse)
{
    uint8_t mask[RIGCAL_BLAME_POINTS_MAX];
    rigcal_real best = RC_MAX, total = 0;
    for (size_t i = 0; i < P->n; i++) {
        rigcal_pose pose;
        for (size_t k = 0; k < P->n; k++) {
            mask[k] = k != i;
        }
        const rigcal_status status = best_fit(&pose, P, mask);
        rms_without[i] = (status >= 0) ? pose.rms_px : -1;
        if (status >= 0) {
            const int is_best = pose.sse < best;
            const rigcal_real ratio =
                (best < RC_MAX) ? odds(P, pose.sse, best, P->n - 1) : 1;
            total = is_best ? 1 + total / ratio : total + ratio;
            if (is_best) {
                best = pose.sse;
                blame->point = (int32_t)i;
                blame->rms_without_px = pose.rms_px;
                blame->is_rest_poor = status == RIGCAL_POOR_FIT;
            }
        }
    }
    if (blame->point < 0) {
        return;
    }
    blame->probability = 1 / total;
    blame->chance =
        rc_min(1, (rigcal_real)P->n * odds(P, sse, best, P->n - 1));
    if (blame->chance <= SURE_CHANCE && blame->probability >= SURE_PROBABILITY) {
        blame->verdict = RIGCAL_BLAME_SURE;
    } else if (blame->chance <= LIKELY_CHANCE) {
        blame->verdict = RIGCAL_BLAME_LIKELY;
    }
}

/* Fills all of *blame from the fit of all points: its status, and its pose where it
 * has one. */
static void find_blame(rigcal_blame *blame, rigcal_real rms_without[],
                       const problem *P, const rigcal_pose *pose,
                       rigcal_status status)
{
    *blame = (rigcal_blame){0};
    blame->point = -1;
    blame->chance = 1;
    blame->rms_px = (status >= 0) ? pose->rms_px : -1;
    leave_out(blame, rms_without, P, (status >= 0) ? pose->sse : RC_MAX);
}

/* Statuses that a wrong point may be the cause of. */
static int may_be_a_point(rigcal_status status)
{
    return status >= 0 || status == RIGCAL_ERR_NO_POSE ||
           status == RIGCAL_ERR_NO_RAY || status == RIGCAL_ERR_WIDE_RAY ||
           status == RIGCAL_ERR_DEGENERATE;
}

/* The problem of a caller's arguments: what rc_pose_begin does not check, or not
 * before what it does. */
static rigcal_status begin(problem *P, const rigcal_camera *camera,
                           const rigcal_observation observations[],
                           const rigcal_real sigma[], size_t n,
                           const rigcal_pose_options *options)
{
    if (camera == NULL || observations == NULL) {
        return RIGCAL_ERR_NULL;
    }
    P->camera = camera;
    P->observations = observations;
    P->sigma = sigma;
    P->n = n;
    (void)rigcal_pose_defaults(&P->options);
    if (options != NULL) {
        P->options = *options;
    }
    const rigcal_status status = rc_check_camera(camera);
    if (status != RIGCAL_OK) {
        return status;
    }
    return (n < 5)                         ? RIGCAL_ERR_TOO_FEW
           : (n > RIGCAL_BLAME_POINTS_MAX) ? RIGCAL_ERR_RANGE
                                           : RIGCAL_OK;
}

rigcal_status rigcal_blame_point(rigcal_blame *blame, rigcal_real rms_without[],
                                 const rigcal_camera *camera,
                                 const rigcal_observation observations[],
                                 const rigcal_real sigma[], size_t n,
                                 const rigcal_pose_options *options)
{
    problem P;
    rigcal_pose pose;
    if (blame == NULL || rms_without == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = begin(&P, camera, observations, sigma, n, options);
    if (status != RIGCAL_OK) {
        return status;
    }
    status = best_fit(&pose, &P, NULL);
    if (!may_be_a_point(status)) {
        return status;
    }
    find_blame(blame, rms_without, &P, &pose, status);
    return RIGCAL_OK;
}

/* ---- mirrors and units --------------------------------------------------- */

/* Rms of the mirrored data, and whether they fit well and are much likelier; *unlike:
 * whether they are much less likely. */
static int fits_mirrored(rigcal_real *rms_px, int *unlike, const problem *P,
                         const rigcal_observation mirrored[], rigcal_real sse,
                         rigcal_status status)
{
    problem other = *P;
    rigcal_pose pose;
    other.observations = mirrored;
    other.options.use_start = 0;
    const rigcal_status mirrored_status = best_fit(&pose, &other, NULL);
    *rms_px = (mirrored_status >= 0) ? pose.rms_px : -1;
    *unlike = mirrored_status < 0 ||
              (status >= 0 && odds(P, pose.sse, sse, P->n) < MIRRORED_ODDS);
    return mirrored_status >= 0 && mirrored_status != RIGCAL_POOR_FIT &&
           (status < 0 || odds(P, sse, pose.sse, P->n) < MIRRORED_ODDS);
}

/* The mistake of units that a ratio of distances is near, or 0. */
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
        (d->rms_flipped_px >= 0 && (d->rms_mirrored_px < 0 ||
                                    d->rms_flipped_px < d->rms_mirrored_px))
            ? d->rms_flipped_px
            : d->rms_mirrored_px;
    if (is_mirrored && (!is_one || mirrored_px < d->blame.rms_without_px)) {
        d->verdict = RIGCAL_DIAGNOSIS_MIRRORED;
    } else if (!is_poor) {
        d->verdict = (d->units > 0) ? RIGCAL_DIAGNOSIS_UNITS
                                    : RIGCAL_DIAGNOSIS_CONSISTENT;
    } else {
        d->verdict = is_one ? RIGCAL_DIAGNOSIS_ONE_POINT : RIGCAL_DIAGNOSIS_UNEXPLAINED;
    }
}

rigcal_status rigcal_diagnose_pose(rigcal_diagnosis *out, rigcal_real rms_without[],
                                   rigcal_observation work[],
                                   const rigcal_camera *camera,
                                   const rigcal_observation observations[],
                                   const rigcal_real sigma[], size_t n,
                                   const rigcal_pose_options *options)
{
    problem P;
    rigcal_pose pose = {0};
    if (out == NULL || rms_without == NULL || work == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = begin(&P, camera, observations, sigma, n, options);
    if (status == RIGCAL_OK && P.options.use_start == 1) {
        status = rc_check_transform(&P.options.start);
        P.options.use_start = 0;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    const rigcal_status fitted = best_fit(&pose, &P, NULL);
    if (!may_be_a_point(fitted)) {
        return fitted;
    }
    rigcal_diagnosis d = {0};
    int unlike[2];
    find_blame(&d.blame, rms_without, &P, &pose, fitted);
    for (size_t i = 0; i < n; i++) {
        work[i] = observations[i];
        work[i].X_w[2] = -work[i].X_w[2];
    }
    int is_mirrored =
        fits_mirrored(&d.rms_mirrored_px, &unlike[0], &P, work, pose.sse, fitted);
    for (size_t i = 0; i < n; i++) {
        work[i] = observations[i];
        work[i].uv[1] = (rigcal_real)(camera->height - 1) - work[i].uv[1];
    }
    is_mirrored |=
        fits_mirrored(&d.rms_flipped_px, &unlike[1], &P, work, pose.sse, fitted);
    d.is_handed = is_mirrored || (unlike[0] && unlike[1]);
    if (options != NULL && options->use_start == 1 && fitted >= 0) {
        d.units = units_of(rc_vec3_norm(pose.cam_from_world.t) /
                           rc_vec3_norm(options->start.t));
    }
    judge(&d, fitted, is_mirrored);
    *out = d;
    return RIGCAL_OK;
}
