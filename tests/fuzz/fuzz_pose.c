/* The pose of one view, and of a tag, with any view, options and budgets. */
#include <math.h>
#include <string.h>

#include "fuzz.h"

enum { POINTS_MOST = 20, POSES_MOST = 8 };

/* Checks what the manual promises of every pose. `unseen` is a point for whose pixel the
 * lens images no ray, or -1. */
static void check_poses(const rigcal_pose poses[], size_t n_found, const rigcal_view *view,
                        int32_t unseen)
{
    double sum = 0;
    size_t i, k;

    PROMISE(n_found >= 1 && n_found <= RIGCAL_POSES_MAX);
    for (k = 0; k < n_found; k++) {
        const rigcal_pose *pose = &poses[k];

        PROMISE(fuzz_is_transform(&pose->cam_from_world));
        PROMISE(fuzz_all_finite(&pose->sse, 1) && pose->sse >= 0);
        PROMISE(fuzz_all_finite(&pose->rms_px, 1) && pose->rms_px >= 0);
        PROMISE(pose->probability >= 0 && pose->probability <= 1);
        PROMISE(k == 0 || pose->probability <= poses[k - 1].probability);
        sum += (double)pose->probability;
        for (i = 0; i < view->n; i++) {
            rigcal_real X_c[3], uv[2];

            PROMISE(rigcal_transform_point(X_c, &pose->cam_from_world,
                                           view->observations[i].X_w) == RIGCAL_OK);
            if ((int32_t)i != unseen && sizeof(rigcal_real) == 8) {
                PROMISE(rigcal_camera_project(uv, view->camera, X_c) == RIGCAL_OK);
            }
        }
    }
    PROMISE(fabs(sum - 1) < FUZZ_TOL(1e-12, 1e-5));
}

static void check_covariance(const rigcal_view *view,
                             const rigcal_transform *cam_from_world, rigcal_real sigma_px)
{
    rigcal_pose_uncertainty uncertainty;
    rigcal_status status;

    MARK(uncertainty);
    status = rigcal_pose_covariance(&uncertainty, view, cam_from_world, sigma_px);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, uncertainty);
    if (status >= 0) {
        PROMISE(fuzz_is_covariance(uncertainty.Sigma, 6, FUZZ_TOL(1e-9, 1e-5)));
        PROMISE(fuzz_all_finite(uncertainty.center, 3));
    }
}

/* The bits of the result must not depend on the budgets. */
static void check_steps(rigcal_status expected, const rigcal_pose poses[], size_t n_found,
                        const rigcal_view *view, const rigcal_pose_options *options,
                        fuzz_budget budget)
{
    rigcal_pose again[POSES_MOST];
    rigcal_pose_solver solver;
    int32_t at_fault;
    size_t n_again;
    rigcal_status status = rigcal_pose_begin(&solver, &at_fault, view, options);

    if (status < 0) {
        PROMISE(status == expected);
        return;
    }
    do {
        status = rigcal_pose_step(&solver, fuzz_budget_next(&budget));
        PROMISE(status == RIGCAL_OK || status == RIGCAL_RUNNING);
    } while (status == RIGCAL_RUNNING);
    MARK(again);
    MARK(n_again);
    status = rigcal_pose_result(again, POSES_MOST, &n_again, &at_fault, &solver);
    PROMISE(status == expected);
    PROMISE(memcmp(again, poses, sizeof again) == 0);
    PROMISE(memcmp(&n_again, &n_found, sizeof n_found) == 0);
}

static void read_options(rigcal_pose_options *options, fuzz_bytes *bytes)
{
    PROMISE(rigcal_pose_defaults(options) == RIGCAL_OK);
    switch (fuzz_below(bytes, 4)) {
    case 1:
        options->sigma_px = fuzz_real(bytes);
        break;
    case 2:
        options->use_start = 1;
        fuzz_transform(&options->start, bytes);
        break;
    case 3:
        options->use_start = (int32_t)fuzz_word(bytes);
        options->sigma_px = fuzz_real(bytes);
        fuzz_transform(&options->start, bytes);
        break;
    default:
        break;
    }
}

static void solve_tag(fuzz_bytes *bytes)
{
    rigcal_pose poses[POSES_MOST];
    rigcal_pose_options options;
    rigcal_camera camera;
    rigcal_real uv[8], tag_size;
    rigcal_status status;
    int32_t at_fault;
    size_t n_found, k;

    read_options(&options, bytes);
    fuzz_camera(&camera, bytes);
    tag_size = fuzz_real(bytes);
    fuzz_reals(uv, 8, bytes);
    MARK(poses);
    MARK(n_found);
    status = rigcal_tag_solve(poses, POSES_MOST, &n_found, &at_fault, &camera, uv, tag_size,
                              &options);
    PROMISE(fuzz_is_status(status) && status != RIGCAL_RUNNING);
    PROMISE_UNTOUCHED(status, poses);
    PROMISE_UNTOUCHED(status, n_found);
    PROMISE(at_fault >= -1 && at_fault < 4);
    for (k = 0; status >= 0 && k < n_found; k++) {
        /* The camera must see the front: the tag's z axis points to its side. */
        const rigcal_transform *cam_from_tag = &poses[k].cam_from_world;
        double towards = 0;
        int i;

        PROMISE(fuzz_is_transform(cam_from_tag));
        for (i = 0; i < 3; i++) {
            towards -= (double)cam_from_tag->R[3 * i + 2] * (double)cam_from_tag->t[i];
        }
        PROMISE(towards > 0);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_bytes bytes = {data, data + size};
    const int kind = fuzz_below(&bytes, 8);
    const fuzz_budget budget = fuzz_budget_of(&bytes);
    rigcal_observation observations[POINTS_MOST];
    rigcal_real sigma[POINTS_MOST];
    rigcal_pose poses[POSES_MOST];
    rigcal_pose_options options;
    rigcal_camera camera;
    rigcal_view view;
    rigcal_status status;
    int32_t at_fault;
    size_t n_found;

    if (kind == 7) {
        solve_tag(&bytes);
        return 0;
    }
    read_options(&options, &bytes);
    fuzz_view(&view, &camera, observations, sigma, POINTS_MOST, &bytes);
    MARK(poses);
    MARK(n_found);
    status = rigcal_pose_solve(poses, POSES_MOST, &n_found, &at_fault, &view, &options);
    PROMISE(fuzz_is_status(status) && status != RIGCAL_RUNNING);
    PROMISE_UNTOUCHED(status, poses);
    PROMISE_UNTOUCHED(status, n_found);
    PROMISE(at_fault >= -1 && at_fault < (int32_t)view.n + (view.n == 0));
    if (status >= 0) {
        check_poses(poses, n_found, &view, at_fault);
        check_covariance(&view, &poses[0].cam_from_world, options.sigma_px);
    }
    check_steps(status, poses, n_found, &view, &options, budget);
    return 0;
}
