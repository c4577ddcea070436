/* batch.h - the library over arrays: many items in one call, for the Python package.
 *
 * Compiled into the package's shared library beside the library's own functions, and used
 * by rigcal/_library.py. The rules of rigcal.h's first page hold, with these besides:
 *
 *   items      n of them in each array. A part of a batch is a call with pointers to that
 *              part, so that threads can share a batch
 *   status     one of each item, that of the function named. A failed item does not stop
 *              the others: its numbers become NaN, its counts 0, its band 0
 *   returned   how many items failed
 *   arguments  are not checked for NULL, and offsets are believed: the caller made the
 *              arrays. Numbers in them are checked, item by item
 */
#ifndef RIGCAL_BATCH_H
#define RIGCAL_BATCH_H

#include "rigcal.h"

#ifdef __cplusplus
extern "C" {
#endif

/* As rigcal_layout, of the structs of this header. */
RIGCAL_API int32_t rigcal_batch_layout_count(void);
RIGCAL_API rigcal_status rigcal_batch_layout(rigcal_layout_entry *entry, int32_t index);

/* ==== poses ================================================================== */

/* Views of one target or of many. View k has the points first[k] to first[k + 1] - 1 of uv
 * and sigma. */
typedef struct rigcal_batch_views {
    const rigcal_camera *cameras;
    const int32_t *camera_of; /* for each view, which camera; NULL: cameras[0] */
    const rigcal_real *X;     /* 3 for each point */
    const rigcal_real *uv;    /* 2 for each point */
    const rigcal_real *sigma; /* for each point, as in rigcal_view; NULL: all equal */
    const int64_t *first;     /* n + 1 */
    int32_t is_one_target;    /* 1: X has the points of one target, and each view saw all of
                                 them in this order; 0: X has those of all views, as uv */
} rigcal_batch_views;

/* The result of one view. */
typedef struct rigcal_batch_result {
    int32_t status;     /* of the pose */
    int32_t covariance; /* status of the covariance; -7 if there is no pose */
    int32_t at_fault;   /* index of a point of the view; -1: none */
    int32_t n_found;    /* poses */
    int32_t n_inliers;  /* of a robust pose; otherwise the number of points */
} rigcal_batch_result;

/* Where the results go. */
typedef struct rigcal_batch_solved {
    rigcal_pose *poses; /* at most `most` for each view, best first */
    size_t most;        /* 1 .. RIGCAL_POSES_MAX */
    rigcal_batch_result *results;
    rigcal_pose_uncertainty *uncertainties; /* of the best pose; NULL: not wanted */
    uint8_t *inliers; /* for each point, as uv; only rigcal_batch_robust writes it */
} rigcal_batch_solved;

/* Reals of work memory for views of at most n_points points. */
#define RIGCAL_BATCH_WORK(n_points) (6 * (size_t)(n_points))

/* rigcal_pose_solve and rigcal_pose_covariance; rigcal_robust_solve, with the covariance of
 * the points that agree; rigcal_tag_solve of tags of one camera, uv 8 a tag. options NULL:
 * all defaults. */
RIGCAL_API size_t rigcal_batch_poses(const rigcal_batch_solved *solved, rigcal_real work[],
                                     const rigcal_batch_views *views, size_t n,
                                     const rigcal_pose_options *options);
RIGCAL_API size_t rigcal_batch_robust(const rigcal_batch_solved *solved, rigcal_real work[],
                                      const rigcal_batch_views *views, size_t n,
                                      const rigcal_robust_options *options);
RIGCAL_API size_t rigcal_batch_tags(const rigcal_batch_solved *solved,
                                    const rigcal_camera *camera, const rigcal_real uv[],
                                    rigcal_real size, size_t n,
                                    const rigcal_pose_options *options);

/* ==== pixels and rays ======================================================== */

/* rigcal_camera_project for points in the world or, if cam_from_world is NULL, in the
 * camera's frame. */
RIGCAL_API size_t rigcal_batch_project(rigcal_real uv[], int32_t status[],
                                       const rigcal_camera *camera,
                                       const rigcal_transform *cam_from_world,
                                       const rigcal_real X[], size_t n);

/* rigcal_camera_ray; rigcal_camera_undistort, rigcal_camera_distort; rigcal_ray_make. */
RIGCAL_API size_t rigcal_batch_rays(rigcal_real rays[], int32_t status[],
                                    const rigcal_camera *camera, const rigcal_real uv[],
                                    size_t n);
RIGCAL_API size_t rigcal_batch_undistort(rigcal_real uv_straight[], int32_t status[],
                                         const rigcal_camera *camera,
                                         const rigcal_real uv[], size_t n);
RIGCAL_API size_t rigcal_batch_distort(rigcal_real uv[], int32_t status[],
                                       const rigcal_camera *camera,
                                       const rigcal_real uv_straight[], size_t n);
RIGCAL_API size_t rigcal_batch_turning_rays(rigcal_ray rays[], int32_t status[],
                                            const rigcal_camera *camera,
                                            const rigcal_real uv[], size_t n);

/* ==== points ================================================================= */

/* rigcal_point_measure. Camera c of the rig saw point k at uv_of[c][2 k]; uv_of[c] NULL,
 * or both of its numbers NaN: it did not see it.
 *
 *   used     out  n_cameras of each point: 1 where that view is used
 *   gains    out  n_cameras of each point, for rigcal_point_distance; NULL: not wanted
 *   s        in   without seen and n, which are made here; its work is written */
RIGCAL_API size_t rigcal_batch_points(rigcal_measured_point points[], uint8_t used[],
                                      int32_t status[], rigcal_point_gain gains[],
                                      const rigcal_sightings *s,
                                      const rigcal_real *const uv_of[], size_t n);

/* rigcal_transfer_make: where a third camera must see what two saw. */
RIGCAL_API size_t rigcal_batch_transfers(rigcal_transfer transfers[], int32_t status[],
                                         const rigcal_calibrated_rig *rig,
                                         const size_t abc[3], const rigcal_real uv_a[],
                                         const rigcal_real uv_b[],
                                         const rigcal_real sigma_ab[2], size_t n);

/* ==== lines, bands, spans ==================================================== */

/* rigcal_band_make of each pixel. */
RIGCAL_API size_t rigcal_batch_bands(rigcal_band bands[], int32_t status[],
                                     const rigcal_match_pair *pair,
                                     const rigcal_real uv_a[], size_t n);

/* rigcal_band_curve for each band, with `capacity` places for each. */
RIGCAL_API size_t rigcal_batch_curves(rigcal_band_point points[], size_t capacity,
                                      int32_t n_written[], int32_t status[],
                                      const rigcal_band bands[], size_t n);

/* rigcal_band_test of pixel k by band k; if is_one_band is 1, by bands[0]. */
RIGCAL_API size_t rigcal_batch_tests(rigcal_match matches[], int32_t status[],
                                     const rigcal_band bands[], int32_t is_one_band,
                                     const rigcal_real uv_b[], size_t n);

/* rigcal_band_search_rays of each band among the same n_b candidates: capacity matches of
 * each; n_inside[k], how many there are. */
RIGCAL_API size_t rigcal_batch_searches(rigcal_match matches[], size_t capacity,
                                        int32_t n_inside[], int32_t status[],
                                        const rigcal_band bands[], size_t n,
                                        const rigcal_ray rays_b[], size_t n_b);

/* rigcal_spans_find of each band. Those of band k are first[k] to first[k + 1] - 1 of
 * spans[capacity]; first has n + 1. Returned is how many bands were done: less than n where
 * the next one's spans have no room. */
RIGCAL_API size_t rigcal_batch_spans(rigcal_span spans[], size_t capacity, int64_t first[],
                                     int32_t status[], rigcal_spans_solver *solver,
                                     const rigcal_band bands[], size_t n);

/* ==== a monitor ============================================================== */

/* rigcal_monitor_match of each pair of pixels. */
RIGCAL_API size_t rigcal_batch_matches(rigcal_real monitor[], int32_t status[],
                                       size_t camera_a, const rigcal_real uv_a[],
                                       size_t camera_b, const rigcal_real uv_b[],
                                       rigcal_real sigma_px, size_t n);

#ifdef __cplusplus
}
#endif

#endif /* RIGCAL_BATCH_H */
