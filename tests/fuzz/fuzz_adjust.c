/* The adjustment and the functions for an adjusted rig, with any views. */
#include <math.h>
#include <string.h>

#include "fuzz_rigs.h"

/* Bits of the first byte: what else is called. */
enum { ROBUST = 1, CLOCKS = 2, FAULTS = 4, CONSIDER = 8, PRIOR = 16, LEFT_OUT = 32 };

enum {
    N_FAULTS = 12,
    FAULTS_WORK = RIGCAL_FAULTS_WORK(RIG_CAMERAS, RIG_CAMERAS) +
                  RIGCAL_FAULTS_CLOCKS_WORK(RIG_CAMERAS),
    CONSIDER_WORK = RIGCAL_ESTIMATE_WORK(RIG_CAMERAS, RIG_CAMERAS) +
                    RIGCAL_CONSIDER_CLOCKS_WORK(RIG_CAMERAS)
};

typedef struct {
    rigcal_rig_clocks clocks;
    rigcal_real times[RIG_PLACEMENTS], instants[RIG_PLACEMENTS];
    rigcal_real offsets[RIG_CAMERAS], drifts[RIG_CAMERAS];
    int32_t states[RIG_CAMERAS];
} clocks_of_rig;

static void add_clocks(clocks_of_rig *c, rigcal_rig *rig, fuzz_bytes *bytes)
{
    size_t i;

    memset(c, 0, sizeof *c);
    PROMISE(rigcal_clocks_defaults(&c->clocks) == RIGCAL_OK);
    for (i = 0; i < rig->n_placements; i++) {
        c->times[i] = (rigcal_real)0.1 * (rigcal_real)i;
    }
    if (fuzz_below(bytes, 4) == 3) {
        fuzz_reals(c->times, rig->n_placements, bytes);
    }
    c->clocks.times = c->times;
    c->clocks.instants = c->instants;
    c->clocks.offsets = c->offsets;
    c->clocks.drifts = c->drifts;
    c->clocks.states = c->states;
    c->clocks.free_offsets = 1;
    c->clocks.free_drifts = fuzz_below(bytes, 2);
    rig->clocks = &c->clocks;
}

static int is_refused(rigcal_status status)
{
    return status < 0 || status == RIGCAL_DISCONNECTED;
}

/* Calls the functions for an adjusted rig. */
static void check_covariances(fuzz_rig *made, rigcal_real sigma_px)
{
    rigcal_rig *rig = &made->rig;
    rigcal_real Sigma[36], noise[RIG_CAMERAS], freedom[RIG_CAMERAS], duv[2 * RIG_POINTS];
    rigcal_transform b_from_a;
    rigcal_status status;
    rigcal_weakest weakest;
    size_t i, n_written;

    for (i = 0; i < rig->n_cameras; i++) {
        MARK(Sigma);
        status = rigcal_rig_covariance(Sigma, rig, sigma_px, i);
        PROMISE(fuzz_is_status(status));
        PROMISE_UNTOUCHED(status, Sigma);
        PROMISE(status < 0 || fuzz_is_covariance(Sigma, 6, FUZZ_TOL(1e-6, 1e-2)));
        MARK(Sigma);
        MARK(b_from_a);
        status = rigcal_rig_pair(&b_from_a, Sigma, rig, sigma_px, 0, i);
        PROMISE(!is_refused(status) || (IS_MARKED(Sigma) && IS_MARKED(b_from_a)));
        PROMISE(is_refused(status) || fuzz_is_transform(&b_from_a));
    }
    MARK(Sigma);
    status = rigcal_rig_placement(Sigma, rig, sigma_px, rig->n_placements - 1);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, Sigma);
    MARK(noise);
    MARK(freedom);
    status = rigcal_rig_noise(noise, freedom, rig);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, noise);
    for (i = 0; status >= 0 && i < rig->n_cameras; i++) {
        PROMISE(noise[i] >= 0 && fuzz_all_finite(&noise[i], 1));
        PROMISE(fuzz_all_finite(&freedom[i], 1));
    }
    MARK(weakest);
    status = rigcal_rig_weakest(&weakest, rig, sigma_px);
    PROMISE_UNTOUCHED(status, weakest);
    for (i = 0; i < rig->n_views; i++) {
        MARK(duv);
        status = rigcal_rig_residuals(duv, 2 * RIG_POINTS, &n_written, rig, i);
        PROMISE(fuzz_is_status(status));
        PROMISE_UNTOUCHED(status, duv);
        PROMISE(status < 0 || (n_written == made->views[i].view.n &&
                               fuzz_all_finite(duv, 2 * n_written)));
    }
}

static void check_faults(fuzz_rig *made)
{
    static rigcal_real work[FAULTS_WORK];
    static char text[8000];
    rigcal_fault faults[N_FAULTS];
    rigcal_faults found;
    rigcal_faults_options options;
    rigcal_faults_words words;
    rigcal_status status;
    int32_t at_fault, i;
    size_t n_needed;

    memset(&options, 0, sizeof options);
    options.work = work;
    options.work_capacity = FAULTS_WORK;
    MARK(found);
    MARK(faults);
    status = rigcal_rig_faults(&found, faults, N_FAULTS, &at_fault, &options, &made->rig);
    PROMISE(fuzz_is_status(status) && status != RIGCAL_RUNNING);
    PROMISE_UNTOUCHED(status, found);
    if (status < 0) {
        return;
    }
    PROMISE(found.verdict >= RIGCAL_RIG_AGREES && found.verdict <= RIGCAL_RIG_UNEXPLAINED);
    PROMISE(found.n >= 0 && found.n <= N_FAULTS);
    PROMISE(found.pattern >= -1 && found.pattern <= 1);
    PROMISE(found.along >= 0 && found.along <= 1);
    for (i = 0; i < found.n; i++) {
        PROMISE(faults[i].p >= 0 && faults[i].p <= 1);
        PROMISE(fuzz_all_finite(faults[i].value, (size_t)faults[i].n));
        PROMISE(faults[i].gain >= 0 && faults[i].F_after >= 0);
        PROMISE(i == 0 || faults[i].is_seen <= faults[i - 1].is_seen);
    }
    memset(&words, 0, sizeof words);
    words.with_unseen = 1;
    MARK(text);
    status = rigcal_faults_text(text, sizeof text, &n_needed, &found, faults, &words);
    PROMISE(status == RIGCAL_OK);
    PROMISE(strlen(text) + 1 == n_needed);
}

static void check_intrinsics(fuzz_rig *made, rigcal_real sigma_px, fuzz_bytes *bytes)
{
    static rigcal_real memory[CONSIDER_WORK];
    rigcal_intrinsics_sigma deviations[RIG_CAMERAS];
    rigcal_intrinsics_change change[RIG_CAMERAS] = {{0, 0, 0, 0, 0, 0}}, sigma[RIG_CAMERAS];
    rigcal_considered considered;
    rigcal_estimated estimated;
    rigcal_status status;
    int32_t at_fault;
    size_t i;

    for (i = 0; i < RIG_CAMERAS; i++) {
        memset(&deviations[i], 0, sizeof deviations[i]);
        deviations[i].focal = (rigcal_real)0.001;
        deviations[i].centre = fuzz_real(bytes);
    }
    made->rig.intrinsics_sigmas = deviations;
    memset(&considered, 0, sizeof considered);
    considered.effects = memory;
    considered.capacity = CONSIDER_WORK;
    considered.loss = made->rig.sigma_px > 0 ? RIGCAL_LOSS_TRUNCATED : 0;
    status = rigcal_rig_consider(&considered, &at_fault, &made->rig);
    PROMISE(fuzz_is_status(status) && status != RIGCAL_RUNNING);
    PROMISE((status < 0) == (made->rig.considered == NULL));
    if (status >= 0) {
        check_covariances(made, sigma_px);
    }
    memset(&estimated, 0, sizeof estimated);
    estimated.considered.effects = memory;
    estimated.considered.capacity = CONSIDER_WORK;
    estimated.considered.loss = made->rig.sigma_px > 0 ? RIGCAL_LOSS_HUBER : 0;
    estimated.made = change;
    estimated.change = change;
    estimated.sigma = sigma;
    MARK(sigma);
    status = rigcal_rig_estimate(&estimated, &at_fault, &made->rig, sigma_px);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, sigma);
    made->rig.considered = NULL;
    made->rig.intrinsics_sigmas = NULL;
}

/* The bits of the result must not depend on the budgets. `before` is the rig before the
 * call. */
static void check_steps(const fuzz_rig *made, fuzz_rig *before, rigcal_status expected,
                        const rigcal_rig_fit *fit, fuzz_budget budget)
{
    rigcal_rig *rig = &before->rig;
    rigcal_rig_solver solver;
    rigcal_rig_fit again;
    rigcal_status status;
    int32_t at_fault;

    rig->cams_from_rig = before->cams_from_rig;
    rig->rig_from_placements = before->rig_from_placements;
    rig->group = before->group;
    rig->work = before->work;
    status = rigcal_rig_begin(&solver, rig);
    if (status < 0) {
        PROMISE(status == expected);
        return;
    }
    do {
        status = rigcal_rig_step(&solver, fuzz_budget_next(&budget));
    } while (status == RIGCAL_RUNNING);
    MARK(again);
    status = rigcal_rig_result(&again, &at_fault, &solver);
    PROMISE(status == expected);
    PROMISE(status < 0 || memcmp(&again, fit, sizeof again) == 0);
    PROMISE(memcmp(before->cams_from_rig, made->cams_from_rig,
                   sizeof made->cams_from_rig) == 0);
}

static void adjust(fuzz_rig *made, int options, fuzz_bytes *bytes, fuzz_budget budget)
{
    static fuzz_rig before;
    rigcal_rig *rig = &made->rig;
    rigcal_rig_fit fit;
    rigcal_status status;
    size_t n_wrong;
    int32_t at_fault;

    memcpy(&before, made, sizeof before);
    MARK(fit);
    MARK(n_wrong);
    status = options & ROBUST ? rigcal_rig_adjust_robust(&fit, &n_wrong, &at_fault, rig)
                              : rigcal_rig_adjust(&fit, &at_fault, rig);
    PROMISE(fuzz_is_status(status) && status != RIGCAL_RUNNING);
    PROMISE_UNTOUCHED(status, fit);
    PROMISE_UNTOUCHED(status, n_wrong);
    PROMISE(at_fault >= -1 && at_fault < (int32_t)rig->n_views);
    if (!(options & (ROBUST | CLOCKS))) {
        check_steps(made, &before, status, &fit, budget);
    }
    if (status < 0) {
        return;
    }
    fuzz_rig_check(rig);
    PROMISE(fit.sum >= 0 && fuzz_all_finite(&fit.sum, 1) && fit.F >= 0);
    check_covariances(made, 1);
    if (options & FAULTS) {
        check_faults(made);
    }
    if (options & CONSIDER) {
        check_intrinsics(made, (rigcal_real)0.5, bytes);
    }
}

/* Sometimes gives the priors a joint covariance, most of which is 0. */
static void join_priors(rigcal_rig *rig, fuzz_bytes *bytes)
{
    static rigcal_real information[RIGCAL_CALIBRATED_SIZE(RIG_CAMERAS)];
    size_t n = 0, i;

    for (i = 0; i < rig->n_cameras; i++) {
        n += rig->roles[i] == RIGCAL_CAMERA_PRIOR;
    }
    if (n == 0 || fuzz_below(bytes, 2) == 0) {
        return;
    }
    memset(information, 0, sizeof information);
    for (i = 0; i < 6 * n; i++) {
        information[i * (i + 3) / 2] = fuzz_real(bytes);
        information[i * (i + 1) / 2] = (i > 0) ? fuzz_real(bytes) : information[0];
    }
    if (fuzz_below(bytes, 4) == 0) { /* hardly ever an information matrix */
        rig->priors_information = information;
    } else if (rigcal_priors_information(information, information, n) == RIGCAL_OK) {
        PROMISE(fuzz_all_finite(information, rigcal_calibrated_size(n)));
        rig->priors_information = information;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static fuzz_rig made;
    static clocks_of_rig clocks;
    static uint8_t roles[RIG_CAMERAS], left_out[RIG_VIEWS];
    static rigcal_camera_prior priors[RIG_CAMERAS];
    fuzz_bytes bytes = {data, data + size};
    const int options = fuzz_byte(&bytes);
    const fuzz_budget budget = fuzz_budget_of(&bytes);
    rigcal_rig *rig = &made.rig;
    size_t i;

    if (!fuzz_rig_read(&made, &bytes) || rigcal_rig_join(rig, NULL) < 0) {
        return 0;
    }
    rig->sigma_px = options & (ROBUST | PRIOR) ? (rigcal_real)0.3 : 0;
    if (options & LEFT_OUT) {
        for (i = 0; i < rig->n_views; i++) {
            left_out[i] = fuzz_below(&bytes, 4) == 3;
        }
        rig->left_out = left_out;
    }
    if (options & PRIOR) {
        memset(priors, 0, sizeof priors);
        for (i = 0; i < rig->n_cameras; i++) {
            int k;

            roles[i] = (uint8_t)fuzz_below(&bytes, 3);
            priors[i].cam_from_rig = rig->cams_from_rig[i];
            for (k = 0; k < 6; k++) {
                priors[i].Sigma[7 * k] = fuzz_real(&bytes);
            }
        }
        rig->roles = roles;
        rig->priors = priors;
        join_priors(rig, &bytes);
    }
    if (options & CLOCKS) {
        add_clocks(&clocks, rig, &bytes);
    }
    adjust(&made, options, &bytes, budget);
    return 0;
}
