#include "batch.h"

#include <math.h>
#include <string.h>

/* ==== what all batches have =================================================== */

#define STRUCT(type) {#type, 0, (int32_t)sizeof(type)},
#define FIELD(type, field) \
    {#type "." #field, (int32_t)offsetof(type, field), (int32_t)sizeof(((type *)0)->field)},

/* clang-format off */
#define BATCH_LAYOUT(S, M)                                                           \
    S(rigcal_batch_views)                                                            \
        M(rigcal_batch_views, cameras) M(rigcal_batch_views, camera_of)              \
        M(rigcal_batch_views, X) M(rigcal_batch_views, uv)                           \
        M(rigcal_batch_views, sigma) M(rigcal_batch_views, first)                    \
        M(rigcal_batch_views, is_one_target)                                         \
    S(rigcal_batch_result)                                                           \
        M(rigcal_batch_result, status) M(rigcal_batch_result, covariance)            \
        M(rigcal_batch_result, at_fault) M(rigcal_batch_result, n_found)             \
        M(rigcal_batch_result, n_inliers)                                            \
    S(rigcal_batch_solved)                                                           \
        M(rigcal_batch_solved, poses) M(rigcal_batch_solved, most)                   \
        M(rigcal_batch_solved, results) M(rigcal_batch_solved, uncertainties)        \
        M(rigcal_batch_solved, inliers)
/* clang-format on */

static const rigcal_layout_entry LAYOUT[] = {BATCH_LAYOUT(STRUCT, FIELD)};

int32_t rigcal_batch_layout_count(void)
{
    return (int32_t)(sizeof LAYOUT / sizeof LAYOUT[0]);
}

rigcal_status rigcal_batch_layout(rigcal_layout_entry *entry, int32_t index)
{
    if (entry == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (index < 0 || index >= rigcal_batch_layout_count()) {
        return RIGCAL_ERR_RANGE;
    }
    *entry = LAYOUT[index];
    return RIGCAL_OK;
}

/* Whether an item has no numbers: it failed, or its status says that none were written. */
static int is_missing(rigcal_status status)
{
    return status < 0 || status == RIGCAL_DISCONNECTED;
}

/* Stores the status of an item. Numbers that do not exist become NaN. Returns 1 for a
 * failure, else 0. */
static size_t end_item(int32_t *status, rigcal_status got, rigcal_real numbers[],
                       size_t n_numbers)
{
    *status = got;
    for (size_t i = 0; is_missing(got) && i < n_numbers; i++) {
        numbers[i] = (rigcal_real)NAN;
    }
    return is_missing(got) ? 1 : 0;
}

/* ==== poses ================================================================== */

/* One view in the form of the library. Its points are in the work memory. */
static rigcal_view gather(rigcal_real work[], const rigcal_batch_views *views, size_t k)
{
    const size_t first = (size_t)views->first[k], n = (size_t)views->first[k + 1] - first;
    const rigcal_real *X = &views->X[views->is_one_target ? 0 : 3 * first];
    rigcal_observation *const observations = (rigcal_observation *)(void *)work;
    for (size_t i = 0; i < n; i++) {
        memcpy(observations[i].X_w, &X[3 * i], sizeof observations[i].X_w);
        memcpy(observations[i].uv, &views->uv[2 * (first + i)], sizeof observations[i].uv);
    }
    const int32_t camera = (views->camera_of != NULL) ? views->camera_of[k] : 0;
    return (rigcal_view){&views->cameras[camera], observations,
                         (views->sigma != NULL) ? &views->sigma[first] : NULL, n};
}

/* Leaves the points that agree in a view of `gather`, and moves them to the front. */
static void keep_inliers(rigcal_view *view, rigcal_real work[], const uint8_t inliers[])
{
    rigcal_observation *const observations = (rigcal_observation *)(void *)work;
    rigcal_real *const sigma = &work[5 * view->n];
    size_t kept = 0;
    for (size_t i = 0; i < view->n; i++) {
        if (inliers[i]) {
            observations[kept] = observations[i];
            sigma[kept] = (view->sigma != NULL) ? view->sigma[i] : 1;
            kept++;
        }
    }
    view->n = kept;
    view->sigma = (view->sigma != NULL) ? sigma : NULL;
}

/* The covariance of a solved view, if it is wanted. Poses that were not found become NaN.
 * Returns 1 for a failure, else 0. */
static size_t end_view(const rigcal_batch_solved *solved, size_t k, size_t n_found,
                       const rigcal_view *view, rigcal_real sigma_px)
{
    rigcal_batch_result *const result = &solved->results[k];
    rigcal_pose *const poses = &solved->poses[k * solved->most];
    result->n_found = is_missing(result->status) ? 0 : (int32_t)n_found;
    for (size_t i = (size_t)result->n_found; i < solved->most; i++) {
        rigcal_real *const numbers = (rigcal_real *)(void *)&poses[i];
        for (size_t j = 0; j < sizeof poses[i] / sizeof *numbers; j++) {
            numbers[j] = (rigcal_real)NAN;
        }
    }
    result->covariance = RIGCAL_ERR_STATE;
    if (solved->uncertainties != NULL) {
        rigcal_pose_uncertainty *const out = &solved->uncertainties[k];
        const rigcal_status status =
            (result->n_found > 0)
                ? rigcal_pose_covariance(out, view, &poses->cam_from_world, sigma_px)
                : RIGCAL_ERR_STATE;
        end_item(&result->covariance, status, (rigcal_real *)(void *)out,
                 sizeof *out / sizeof(rigcal_real));
    }
    return is_missing(result->status) ? 1 : 0;
}

size_t rigcal_batch_poses(const rigcal_batch_solved *solved, rigcal_real work[],
                          const rigcal_batch_views *views, size_t n,
                          const rigcal_pose_options *options)
{
    size_t failed = 0;
    for (size_t k = 0; k < n; k++) {
        const rigcal_view view = gather(work, views, k);
        rigcal_batch_result *const result = &solved->results[k];
        size_t n_found = 0;
        result->status = rigcal_pose_solve(&solved->poses[k * solved->most], solved->most,
                                           &n_found, &result->at_fault, &view, options);
        result->n_inliers = (int32_t)view.n;
        failed +=
            end_view(solved, k, n_found, &view, (options != NULL) ? options->sigma_px : 0);
    }
    return failed;
}

size_t rigcal_batch_robust(const rigcal_batch_solved *solved, rigcal_real work[],
                           const rigcal_batch_views *views, size_t n,
                           const rigcal_robust_options *options)
{
    size_t failed = 0;
    for (size_t k = 0; k < n; k++) {
        rigcal_view view = gather(work, views, k);
        rigcal_batch_result *const result = &solved->results[k];
        uint8_t *const inliers = &solved->inliers[views->first[k]];
        size_t n_found = 0, n_inliers = 0;
        result->status =
            rigcal_robust_solve(&solved->poses[k * solved->most], solved->most, &n_found,
                                inliers, &n_inliers, &result->at_fault, &view, options);
        if (is_missing(result->status)) {
            memset(inliers, 0, view.n);
            n_inliers = 0;
        }
        result->n_inliers = (int32_t)n_inliers;
        keep_inliers(&view, work, inliers);
        failed +=
            end_view(solved, k, n_found, &view, (options != NULL) ? options->sigma_px : 0);
    }
    return failed;
}

/* The corners of a tag in its frame, in the order of rigcal_tag_solve. */
static void tag_corners(rigcal_observation corners[4], const rigcal_real uv[8],
                        rigcal_real size)
{
    static const rigcal_real SIGN[4][2] = {{-1, 1}, {1, 1}, {1, -1}, {-1, -1}};
    for (int i = 0; i < 4; i++) {
        corners[i] = (rigcal_observation){{SIGN[i][0] * size / 2, SIGN[i][1] * size / 2, 0},
                                          {uv[2 * i], uv[2 * i + 1]}};
    }
}

size_t rigcal_batch_tags(const rigcal_batch_solved *solved, const rigcal_camera *camera,
                         const rigcal_real uv[], rigcal_real size, size_t n,
                         const rigcal_pose_options *options)
{
    size_t failed = 0;
    for (size_t k = 0; k < n; k++) {
        rigcal_observation corners[4];
        rigcal_batch_result *const result = &solved->results[k];
        size_t n_found = 0;
        tag_corners(corners, &uv[8 * k], size);
        const rigcal_view view = {camera, corners, NULL, 4};
        result->status =
            rigcal_tag_solve(&solved->poses[k * solved->most], solved->most, &n_found,
                             &result->at_fault, camera, &uv[8 * k], size, options);
        result->n_inliers = 4;
        failed +=
            end_view(solved, k, n_found, &view, (options != NULL) ? options->sigma_px : 0);
    }
    return failed;
}

/* ==== pixels and rays ======================================================== */

size_t rigcal_batch_project(rigcal_real uv[], int32_t status[], const rigcal_camera *camera,
                            const rigcal_transform *cam_from_world, const rigcal_real X[],
                            size_t n)
{
    size_t failed = 0;
    for (size_t k = 0; k < n; k++) {
        rigcal_real X_c[3];
        const rigcal_real *at = &X[3 * k];
        rigcal_status got = RIGCAL_OK;
        if (cam_from_world != NULL) {
            got = rigcal_transform_point(X_c, cam_from_world, at);
            at = X_c;
        }
        if (got == RIGCAL_OK) {
            got = rigcal_camera_project(&uv[2 * k], camera, at);
        }
        failed += end_item(&status[k], got, &uv[2 * k], 2);
    }
    return failed;
}

size_t rigcal_batch_rays(rigcal_real rays[], int32_t status[], const rigcal_camera *camera,
                         const rigcal_real uv[], size_t n)
{
    size_t failed = 0;
    for (size_t k = 0; k < n; k++) {
        const rigcal_status got = rigcal_camera_ray(&rays[3 * k], camera, &uv[2 * k]);
        failed += end_item(&status[k], got, &rays[3 * k], 3);
    }
    return failed;
}

size_t rigcal_batch_undistort(rigcal_real uv_straight[], int32_t status[],
                              const rigcal_camera *camera, const rigcal_real uv[], size_t n)
{
    size_t failed = 0;
    for (size_t k = 0; k < n; k++) {
        const rigcal_status got =
            rigcal_camera_undistort(&uv_straight[2 * k], camera, &uv[2 * k]);
        failed += end_item(&status[k], got, &uv_straight[2 * k], 2);
    }
    return failed;
}

size_t rigcal_batch_distort(rigcal_real uv[], int32_t status[], const rigcal_camera *camera,
                            const rigcal_real uv_straight[], size_t n)
{
    size_t failed = 0;
    for (size_t k = 0; k < n; k++) {
        const rigcal_status got =
            rigcal_camera_distort(&uv[2 * k], camera, &uv_straight[2 * k]);
        failed += end_item(&status[k], got, &uv[2 * k], 2);
    }
    return failed;
}

size_t rigcal_batch_turning_rays(rigcal_ray rays[], int32_t status[],
                                 const rigcal_camera *camera, const rigcal_real uv[],
                                 size_t n)
{
    size_t failed = 0;
    for (size_t k = 0; k < n; k++) {
        const rigcal_status got = rigcal_ray_make(&rays[k], camera, &uv[2 * k]);
        failed += end_item(&status[k], got, (rigcal_real *)(void *)&rays[k],
                           sizeof rays[k] / sizeof(rigcal_real));
    }
    return failed;
}

/* ==== points ================================================================= */

/* The cameras that saw point k. Returns their number. */
static size_t see(rigcal_sighting seen[], const rigcal_real *const uv_of[],
                  size_t n_cameras, size_t k)
{
    size_t n = 0;
    for (size_t c = 0; c < n_cameras && n < RIGCAL_SIGHTINGS_MAX; c++) {
        const rigcal_real *const uv = (uv_of[c] != NULL) ? &uv_of[c][2 * k] : NULL;
        if (uv != NULL && !(isnan(uv[0]) && isnan(uv[1]))) {
            seen[n] = (rigcal_sighting){(int32_t)c, {uv[0], uv[1]}};
            n++;
        }
    }
    return n;
}

/* The contents of a point that was not measured. */
static void clear_point(rigcal_measured_point *point)
{
    const rigcal_real nan = (rigcal_real)NAN;
    for (int i = 0; i < 9; i++) {
        point->X[i % 3] = nan;
        point->Sigma[i] = nan;
        point->Sigma_noise[i] = nan;
    }
    point->chi2 = point->freedom = point->parallax = point->rms_px = nan;
    point->n_used = 0;
}

size_t rigcal_batch_points(rigcal_measured_point points[], uint8_t used[], int32_t status[],
                           rigcal_point_gain gains[], const rigcal_sightings *s,
                           const rigcal_real *const uv_of[], size_t n)
{
    rigcal_sighting seen[RIGCAL_SIGHTINGS_MAX];
    uint8_t is_used[RIGCAL_SIGHTINGS_MAX];
    const size_t n_cameras = s->rig->n_cameras;
    rigcal_sightings sightings = *s;
    size_t failed = 0;
    sightings.seen = seen;
    for (size_t k = 0; k < n; k++) {
        sightings.n = see(seen, uv_of, n_cameras, k);
        points[k].gains = (gains != NULL) ? &gains[k * n_cameras] : NULL;
        points[k].gains_capacity = (gains != NULL) ? n_cameras : 0;
        status[k] = rigcal_point_measure(&points[k], is_used, &sightings);
        memset(&used[k * n_cameras], 0, n_cameras);
        if (is_missing(status[k])) {
            clear_point(&points[k]);
            failed++;
            continue;
        }
        for (size_t i = 0; i < sightings.n; i++) {
            used[k * n_cameras + (size_t)seen[i].camera] = is_used[i];
        }
    }
    return failed;
}

size_t rigcal_batch_transfers(rigcal_transfer transfers[], int32_t status[],
                              const rigcal_calibrated_rig *rig, const size_t abc[3],
                              const rigcal_real uv_a[], const rigcal_real uv_b[],
                              const rigcal_real sigma_ab[2], size_t n)
{
    size_t failed = 0;
    for (size_t k = 0; k < n; k++) {
        const rigcal_status got = rigcal_transfer_make(
            &transfers[k], rig, abc, &uv_a[2 * k], &uv_b[2 * k], sigma_ab);
        failed += end_item(&status[k], got, (rigcal_real *)(void *)&transfers[k],
                           sizeof transfers[k] / sizeof(rigcal_real));
    }
    return failed;
}

/* ==== lines, bands, spans ==================================================== */

size_t rigcal_batch_bands(rigcal_band bands[], int32_t status[],
                          const rigcal_match_pair *pair, const rigcal_real uv_a[], size_t n)
{
    size_t failed = 0;
    for (size_t k = 0; k < n; k++) {
        status[k] = rigcal_band_make(&bands[k], pair, &uv_a[2 * k]);
        if (is_missing(status[k])) {
            memset(&bands[k], 0, sizeof bands[k]);
            failed++;
        }
    }
    return failed;
}

size_t rigcal_batch_curves(rigcal_band_point points[], size_t capacity, int32_t n_written[],
                           int32_t status[], const rigcal_band bands[], size_t n)
{
    const size_t reals = sizeof *points / sizeof(rigcal_real);
    size_t failed = 0;
    for (size_t k = 0; k < n; k++) {
        rigcal_band_point *const own = &points[k * capacity];
        size_t count = 0;
        status[k] = rigcal_band_curve(own, capacity, &count, &bands[k]);
        if (is_missing(status[k])) {
            count = 0;
            failed++;
        }
        n_written[k] = (int32_t)count;
        for (size_t i = count * reals; i < capacity * reals; i++) {
            ((rigcal_real *)(void *)own)[i] = (rigcal_real)NAN;
        }
    }
    return failed;
}

/* The contents of a candidate that was not tested. */
static void clear_match(rigcal_match *match)
{
    const rigcal_real nan = (rigcal_real)NAN;
    *match = (rigcal_match){-1, 0, nan, nan, nan, nan, nan};
}

size_t rigcal_batch_tests(rigcal_match matches[], int32_t status[],
                          const rigcal_band bands[], int32_t is_one_band,
                          const rigcal_real uv_b[], size_t n)
{
    size_t failed = 0;
    for (size_t k = 0; k < n; k++) {
        status[k] =
            rigcal_band_test(&matches[k], &bands[is_one_band ? 0 : k], &uv_b[2 * k]);
        if (is_missing(status[k])) {
            clear_match(&matches[k]);
            failed++;
        } else {
            matches[k].index = (int32_t)k;
        }
    }
    return failed;
}

size_t rigcal_batch_searches(rigcal_match matches[], size_t capacity, int32_t n_inside[],
                             int32_t status[], const rigcal_band bands[], size_t n,
                             const rigcal_ray rays_b[], size_t n_b)
{
    size_t failed = 0;
    for (size_t k = 0; k < n; k++) {
        size_t count = 0, inside = 0;
        int32_t at_fault;
        status[k] = rigcal_band_search_rays(&matches[k * capacity], capacity, &count,
                                            &inside, &at_fault, &bands[k], rays_b, n_b);
        if (is_missing(status[k])) {
            count = inside = 0;
            failed++;
        }
        n_inside[k] = (int32_t)inside;
        for (size_t i = count; i < capacity; i++) {
            clear_match(&matches[k * capacity + i]);
        }
    }
    return failed;
}

size_t rigcal_batch_spans(rigcal_span spans[], size_t capacity, int64_t first[],
                          int32_t status[], rigcal_spans_solver *solver,
                          const rigcal_band bands[], size_t n)
{
    size_t used = 0;
    first[0] = 0;
    for (size_t k = 0; k < n; k++) {
        size_t found = 0;
        status[k] =
            rigcal_spans_find(&spans[used], capacity - used, &found, solver, &bands[k]);
        if (status[k] == RIGCAL_ERR_CAPACITY) {
            return k;
        }
        used += is_missing(status[k]) ? 0 : found;
        first[k + 1] = (int64_t)used;
    }
    return n;
}

/* ==== a monitor ============================================================== */

size_t rigcal_batch_matches(rigcal_real monitor[], int32_t status[], size_t camera_a,
                            const rigcal_real uv_a[], size_t camera_b,
                            const rigcal_real uv_b[], rigcal_real sigma_px, size_t n)
{
    size_t failed = 0;
    for (size_t k = 0; k < n; k++) {
        status[k] = rigcal_monitor_match(monitor, camera_a, &uv_a[2 * k], camera_b,
                                         &uv_b[2 * k], sigma_px);
        failed += is_missing(status[k]) ? 1 : 0;
    }
    return failed;
}
