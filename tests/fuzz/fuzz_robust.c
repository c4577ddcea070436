/* The robust pose, with any view, options and budgets. */
#include <math.h>
#include <string.h>

#include "fuzz.h"

enum { POINTS_MOST = 20, POSES_MOST = 8, SAMPLES_MOST = 300 };

typedef struct {
    rigcal_pose poses[POSES_MOST];
    size_t n_found, n_inliers;
    uint8_t inliers[POINTS_MOST];
} answer;

static void read_options(rigcal_robust_options *options, fuzz_bytes *bytes)
{
    PROMISE(rigcal_robust_defaults(options) == RIGCAL_OK);
    if (fuzz_below(bytes, 2) == 1) {
        options->threshold_px = fuzz_real(bytes);
        options->sigma_px = fuzz_real(bytes);
        options->samples = (int32_t)fuzz_word(bytes);
        options->seed = fuzz_word(bytes);
        options->max_units = (int32_t)fuzz_word(bytes);
    }
    if (options->samples > SAMPLES_MOST) { /* limits the time of one input */
        options->samples = options->samples % SAMPLES_MOST + 1;
    }
}

static void check_answer(const answer *found, const rigcal_view *view)
{
    size_t i, k, marked = 0;
    double sum = 0;

    PROMISE(found->n_found >= 1 && found->n_found <= RIGCAL_POSES_MAX);
    for (i = 0; i < view->n; i++) {
        PROMISE(found->inliers[i] <= 1);
        marked += found->inliers[i];
    }
    PROMISE(marked == found->n_inliers && marked >= 3);
    for (k = 0; k < found->n_found; k++) {
        const rigcal_pose *pose = &found->poses[k];

        PROMISE(fuzz_is_transform(&pose->cam_from_world));
        PROMISE(fuzz_all_finite(&pose->sse, 1) && fuzz_all_finite(&pose->rms_px, 1));
        PROMISE(pose->probability >= 0 && pose->probability <= 1);
        PROMISE(k == 0 || pose->probability <= found->poses[k - 1].probability);
        sum += (double)pose->probability;
    }
    PROMISE(fabs(sum - 1) < FUZZ_TOL(1e-12, 1e-5));
}

/* Units of the search for a pose of the points that agree: before and after the search. */
enum {
    SETTLE_MOST = 17,
    DECIDE_MOST = 9,
    SEARCHES = 9,
    SEARCH_MOST = 2000 + 9 * POINTS_MOST
};

/* The bits of the result must not depend on the budgets, and the number of units must be as
 * promised. */
static rigcal_status solve_in_steps(answer *found, const rigcal_view *view,
                                    const rigcal_robust_options *options,
                                    fuzz_budget budget)
{
    const long most =
        (long)options->max_units + SETTLE_MOST + DECIDE_MOST + (long)SEARCHES * SEARCH_MOST;
    rigcal_robust_solver solver;
    int32_t at_fault;
    long units = 0;
    rigcal_status status =
        rigcal_robust_begin(&solver, found->inliers, &at_fault, view, options);

    PROMISE(fuzz_is_status(status));
    if (status < 0) {
        return status;
    }
    do {
        const int32_t next = fuzz_budget_next(&budget);
        PROMISE(units <= most);
        status = rigcal_robust_step(&solver, next);
        units += next;
        PROMISE(status == RIGCAL_OK || status == RIGCAL_RUNNING);
    } while (status == RIGCAL_RUNNING);
    return rigcal_robust_result(found->poses, POSES_MOST, &found->n_found,
                                &found->n_inliers, &solver);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_bytes bytes = {data, data + size};
    const fuzz_budget budget = fuzz_budget_of(&bytes);
    rigcal_observation observations[POINTS_MOST];
    rigcal_real sigma[POINTS_MOST];
    rigcal_robust_options options;
    rigcal_camera camera;
    rigcal_view view;
    rigcal_status status;
    answer found, again;
    int32_t at_fault;

    read_options(&options, &bytes);
    fuzz_view(&view, &camera, observations, sigma, POINTS_MOST, &bytes);
    MARK(found);
    MARK(again);
    status = rigcal_robust_solve(found.poses, POSES_MOST, &found.n_found, found.inliers,
                                 &found.n_inliers, &at_fault, &view, &options);
    PROMISE(fuzz_is_status(status) && status != RIGCAL_RUNNING);
    PROMISE(at_fault >= -1 && at_fault < (int32_t)view.n + (view.n == 0));
    if (status >= 0) {
        check_answer(&found, &view);
    } else { /* the contents of `inliers` mean nothing then */
        PROMISE(IS_MARKED(found.poses));
        PROMISE(IS_MARKED(found.n_found));
        PROMISE(IS_MARKED(found.n_inliers));
    }
    PROMISE(solve_in_steps(&again, &view, &options, budget) == status);
    PROMISE(memcmp(again.poses, found.poses, sizeof found.poses) == 0);
    PROMISE(memcmp(&again.n_found, &found.n_found, sizeof found.n_found) == 0);
    PROMISE(status < 0 || memcmp(again.inliers, found.inliers, view.n) == 0);
    return 0;
}
