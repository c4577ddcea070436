/* Bearings, pairs, elimination and the published procedure, with any view and options. */
#include <math.h>
#include <string.h>

#include "fuzz.h"

enum { POINTS_MOST = 12, PAIRS_MOST = 80 };

/* Checks what is computed from one pair, at any angles. */
static void check_equations(const rigcal_pair pairs[], size_t n_pairs,
                            const rigcal_real x[9], int32_t eliminated, int32_t pairs_used)
{
    rigcal_elimination elimination;
    rigcal_real pqk[3], residual;
    rigcal_status status;

    MARK(pqk);
    status = rigcal_pair_coefficients(pqk, &pairs[0], eliminated, x);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, pqk);
    MARK(residual);
    status = rigcal_pair_residual(&residual, &pairs[0], x);
    PROMISE_UNTOUCHED(status, residual);
    MARK(residual);
    status = rigcal_pairs_residual(&residual, pairs, n_pairs, x);
    PROMISE_UNTOUCHED(status, residual);
    PROMISE(status < 0 || residual >= 0);
    MARK(elimination);
    status =
        rigcal_pairs_eliminate(&elimination, pairs, n_pairs, pairs_used, eliminated, x);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, elimination);
    if (status >= 0) {
        PROMISE(fabs((double)elimination.angle) <= 3.1415927);
        PROMISE(elimination.residual >= 0 && elimination.condition >= 1);
    }
}

static void check_translation(const rigcal_bearing bearings[], size_t n,
                              const rigcal_pair pairs[], size_t n_pairs,
                              const rigcal_real R[9])
{
    rigcal_real t[3];
    rigcal_status status;

    MARK(t);
    status = rigcal_translation_from_pairs(t, R, bearings, n, pairs, n_pairs);
    PROMISE_UNTOUCHED(status, t);
    PROMISE(status < 0 || fuzz_all_finite(t, 3));
    MARK(t);
    status = rigcal_translation_least_squares(t, R, bearings, n);
    PROMISE_UNTOUCHED(status, t);
    PROMISE(status < 0 || fuzz_all_finite(t, 3));
}

static void check_procedure(const rigcal_bearing bearings[], size_t n,
                            const rigcal_pair pairs[], size_t n_pairs,
                            const rigcal_paper_options *options, fuzz_budget budget)
{
    rigcal_paper_pose pose, again;
    rigcal_paper_solver solver;
    rigcal_status status, stepped;

    MARK(pose);
    MARK(again);
    status = rigcal_paper_solve(&pose, bearings, n, pairs, n_pairs, options);
    PROMISE(fuzz_is_status(status) && status != RIGCAL_RUNNING);
    PROMISE_UNTOUCHED(status, pose);
    if (status >= 0) {
        PROMISE(fuzz_is_transform(&pose.cam_from_world));
        PROMISE(pose.residual >= 0 && pose.rms >= 0 && fuzz_all_finite(&pose.rms, 1));
    }
    stepped = rigcal_paper_begin(&solver, bearings, n, pairs, n_pairs, options);
    if (stepped < 0) {
        PROMISE(stepped == status);
        return;
    }
    do {
        stepped = rigcal_paper_step(&solver, fuzz_budget_next(&budget));
        PROMISE(stepped == RIGCAL_OK || stepped == RIGCAL_RUNNING);
    } while (stepped == RIGCAL_RUNNING);
    PROMISE(rigcal_paper_result(&again, &solver) == status);
    PROMISE(memcmp(&again, &pose, sizeof pose) == 0);
}

static void read_options(rigcal_paper_options *options, fuzz_bytes *bytes)
{
    PROMISE(rigcal_paper_defaults(options) == RIGCAL_OK);
    options->angles = fuzz_below(bytes, 5);
    options->eliminated = fuzz_below(bytes, 5);
    options->use_guess = fuzz_below(bytes, 3);
    options->pairs_used = fuzz_below(bytes, 4);
    options->max_evals = options->use_guess == 0 ? 200 : 50;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_bytes bytes = {data, data + size};
    const int is_odd = fuzz_below(&bytes, 2);
    const fuzz_budget budget = fuzz_budget_of(&bytes);
    rigcal_observation observations[POINTS_MOST];
    rigcal_bearing bearings[POINTS_MOST];
    rigcal_pair pairs[PAIRS_MOST];
    rigcal_real sigma[POINTS_MOST], x[9];
    rigcal_paper_options options;
    rigcal_camera camera;
    rigcal_view view;
    rigcal_status status;
    int32_t at_fault;
    size_t n_pairs;

    read_options(&options, &bytes);
    fuzz_view(&view, &camera, observations, sigma, POINTS_MOST, &bytes);
    fuzz_reals(options.guess_ypr, 3, &bytes);
    fuzz_rotation(x, &bytes);
    MARK(bearings);
    status = rigcal_bearings_of_view(bearings, &at_fault, &view);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, bearings);
    if (status < 0) {
        return 0;
    }
    if (is_odd) { /* rays with any numbers */
        fuzz_reals(bearings[view.n / 2].ray, 3, &bytes);
    }
    MARK(pairs);
    MARK(n_pairs);
    status = rigcal_pairs_choose(pairs, PAIRS_MOST, &n_pairs, bearings, view.n);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, pairs);
    PROMISE_UNTOUCHED(status, n_pairs);
    if (status < 0) {
        return 0;
    }
    PROMISE(n_pairs >= 3 && n_pairs <= rigcal_pairs_for(view.n));
    check_equations(pairs, n_pairs, x, options.eliminated, options.pairs_used);
    check_translation(bearings, view.n, pairs, n_pairs, x);
    check_procedure(bearings, view.n, pairs, n_pairs, &options, budget);
    return 0;
}
