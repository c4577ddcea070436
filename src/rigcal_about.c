#include "rc_real.h"

int32_t rigcal_version(void)
{
    return RIGCAL_VERSION_MAJOR * 10000 + RIGCAL_VERSION_MINOR * 100 +
           RIGCAL_VERSION_PATCH;
}

int32_t rigcal_sizeof_real(void)
{
    return (int32_t)sizeof(rigcal_real);
}

/* ---- statuses ------------------------------------------------------------
 *
 * A switch, not a table of pointers: tables need relocation in a shared library,
 * which makes them writable data while it loads. */

#define NAME_OF(status) \
    case status: \
        return #status;

const char *rigcal_status_name(rigcal_status status)
{
    switch (status) {
        NAME_OF(RIGCAL_OK)
        NAME_OF(RIGCAL_RUNNING)
        NAME_OF(RIGCAL_BUDGET_SPENT)
        NAME_OF(RIGCAL_DISCONNECTED)
        NAME_OF(RIGCAL_AMBIGUOUS)
        NAME_OF(RIGCAL_POOR_FIT)
        NAME_OF(RIGCAL_FEW_AGREE)
        NAME_OF(RIGCAL_VAGUE)
        NAME_OF(RIGCAL_UNSEEN_POINT)
        NAME_OF(RIGCAL_MOST_DISAGREE)
        NAME_OF(RIGCAL_ERR_NULL)
        NAME_OF(RIGCAL_ERR_NOT_FINITE)
        NAME_OF(RIGCAL_ERR_RANGE)
        NAME_OF(RIGCAL_ERR_CAMERA)
        NAME_OF(RIGCAL_ERR_ROTATION)
        NAME_OF(RIGCAL_ERR_CAPACITY)
        NAME_OF(RIGCAL_ERR_STATE)
        NAME_OF(RIGCAL_ERR_TOO_FEW)
        NAME_OF(RIGCAL_ERR_COINCIDENT)
        NAME_OF(RIGCAL_ERR_COLLINEAR)
        NAME_OF(RIGCAL_ERR_EDGE_ON)
        NAME_OF(RIGCAL_ERR_PRECISION)
        NAME_OF(RIGCAL_ERR_NO_RAY)
        NAME_OF(RIGCAL_ERR_BEHIND)
        NAME_OF(RIGCAL_ERR_WIDE_RAY)
        NAME_OF(RIGCAL_ERR_PARALLEL)
        NAME_OF(RIGCAL_ERR_EPIPOLE)
        NAME_OF(RIGCAL_ERR_OUTSIDE)
        NAME_OF(RIGCAL_ERR_DEGENERATE)
        NAME_OF(RIGCAL_ERR_NO_POSE)
        NAME_OF(RIGCAL_ERR_DAMAGED)
        NAME_OF(RIGCAL_ERR_FOREIGN)
        NAME_OF(RIGCAL_ERR_VERSION)
        NAME_OF(RIGCAL_ERR_NO_CONSENSUS)
        NAME_OF(RIGCAL_ERR_MIRRORED)
    default:
        return "unknown status";
    }
}

const char *rigcal_status_text(rigcal_status status)
{
    switch (status) {
    case RIGCAL_OK:
        return "done";
    case RIGCAL_RUNNING:
        return "the solver is not finished: call its step function "
               "again";
    case RIGCAL_BUDGET_SPENT:
        return "the evaluations ran out before the tolerance was met: "
               "the best found so far was returned; allow more";
    case RIGCAL_DISCONNECTED:
        return "some cameras share no placement of the target with the "
               "first one: place the target where both sides see it";
    case RIGCAL_AMBIGUOUS:
        return "another pose fits nearly as well: see the probabilities, tilt "
               "the target or use another camera to tell";
    case RIGCAL_POOR_FIT:
        return "the error is too large for noise: check the "
               "correspondences, the target and the intrinsics";
    case RIGCAL_FEW_AGREE:
        return "so few observations agree that chance may do it: check the "
               "correspondences, or give more";
    case RIGCAL_VAGUE:
        return "the data hardly fix the pose: move nearer, or observe points "
               "that are farther apart";
    case RIGCAL_UNSEEN_POINT:
        return "the lens model images no ray at one of the pixels: the pose is that of "
               "the other points; check that pixel and the lens";
    case RIGCAL_MOST_DISAGREE:
        return "most observations disagree with this pose: check the "
               "correspondences and the target's coordinates";
    case RIGCAL_ERR_NULL:
        return "a pointer that must not be NULL is NULL";
    case RIGCAL_ERR_NOT_FINITE:
        return "an input is NaN or infinite";
    case RIGCAL_ERR_RANGE:
        return "a count, an option or a number is outside its "
               "documented range";
    case RIGCAL_ERR_CAMERA:
        return "the intrinsics cannot be used: focal lengths and image "
               "size must be positive, the lens known, and coefficients "
               "that it has not must be 0";
    case RIGCAL_ERR_ROTATION:
        return "the matrix or quaternion is not a rotation: it must be "
               "orthonormal and not mirror";
    case RIGCAL_ERR_CAPACITY:
        return "a buffer is too small: ask the size function that goes "
               "with it";
    case RIGCAL_ERR_STATE:
        return "the solver was not begun, or was asked out of turn";
    case RIGCAL_ERR_TOO_FEW:
        return "too few points, views or pairs for the unknowns: "
               "observe more";
    case RIGCAL_ERR_COINCIDENT:
        return "fewer than three distinct points or rays: check for "
               "points entered twice";
    case RIGCAL_ERR_COLLINEAR:
        return "all the points lie on one line, about which the camera "
               "may turn freely: add a point off the line";
    case RIGCAL_ERR_EDGE_ON:
        return "all the rays lie in one plane: the target is seen "
               "edge-on, tilt it";
    case RIGCAL_ERR_PRECISION:
        return "the points are so far from the origin that their shape "
               "is lost in rounding: subtract a common offset";
    case RIGCAL_ERR_NO_RAY:
        return "the lens model images no ray there: the pixel or point "
               "is outside its usable field";
    case RIGCAL_ERR_BEHIND:
        return "a point is not in front of the camera";
    case RIGCAL_ERR_WIDE_RAY:
        return "a ray is 90 degrees or more off the optical axis (80, for a pose in a "
               "build without three points), which this function cannot use";
    case RIGCAL_ERR_PARALLEL:
        return "the rays are parallel or nearly so: the depth cannot be "
               "told";
    case RIGCAL_ERR_EPIPOLE:
        return "the point is the image of the other camera's centre: "
               "every line through it matches";
    case RIGCAL_ERR_OUTSIDE:
        return "the line does not cross the image";
    case RIGCAL_ERR_DEGENERATE:
        return "the equations are singular: this geometry has no unique "
               "answer";
    case RIGCAL_ERR_NO_POSE:
        return "no start led to a pose with every point in front: check "
               "the correspondences, and that the coordinates are "
               "right-handed";
    case RIGCAL_ERR_DAMAGED:
        return "the stored bytes are incomplete or were altered: use "
               "another copy, or calibrate again";
    case RIGCAL_ERR_FOREIGN:
        return "these bytes are not a stored calibration";
    case RIGCAL_ERR_MIRRORED:
        return "only a mirror shows this: the corners run the wrong way round, the "
               "tag is seen from behind or the image is flipped";
    case RIGCAL_ERR_VERSION:
        return "the calibration was stored in a form that this version of "
               "the library does not know: use the one that stored it";
    case RIGCAL_ERR_NO_CONSENSUS:
        return "no more observations agree on a pose than chance makes agree: "
               "check the correspondences, the target and the camera";
    default:
        return "unknown status";
    }
}

/* ---- layout -------------------------------------------------------------- */

#define STRUCT(type) {#type, 0, (int32_t)sizeof(type)}
#define FIELD(type, field) \
    {#type "." #field, (int32_t)offsetof(type, field), \
     (int32_t)sizeof(((type *)0)->field)}

static const rigcal_layout_entry LAYOUT[] = {
    STRUCT(rigcal_layout_entry),
    FIELD(rigcal_layout_entry, name),
    FIELD(rigcal_layout_entry, offset),
    FIELD(rigcal_layout_entry, size),
    STRUCT(rigcal_transform),
    FIELD(rigcal_transform, R),
    FIELD(rigcal_transform, t),
    STRUCT(rigcal_camera),
    FIELD(rigcal_camera, lens),
    FIELD(rigcal_camera, width),
    FIELD(rigcal_camera, height),
    FIELD(rigcal_camera, reserved),
    FIELD(rigcal_camera, fx),
    FIELD(rigcal_camera, fy),
    FIELD(rigcal_camera, cx),
    FIELD(rigcal_camera, cy),
    FIELD(rigcal_camera, k1),
    FIELD(rigcal_camera, k2),
    FIELD(rigcal_camera, p1),
    FIELD(rigcal_camera, p2),
    FIELD(rigcal_camera, k3),
    FIELD(rigcal_camera, k4),
    FIELD(rigcal_camera, k5),
    FIELD(rigcal_camera, k6),
    STRUCT(rigcal_observation),
    FIELD(rigcal_observation, X_w),
    FIELD(rigcal_observation, uv),
    STRUCT(rigcal_sighting),
    FIELD(rigcal_sighting, X_w),
    FIELD(rigcal_sighting, ray),
    STRUCT(rigcal_vertex),
    FIELD(rigcal_vertex, x),
    FIELD(rigcal_vertex, cost),
    STRUCT(rigcal_neldermead),
    FIELD(rigcal_neldermead, k),
    FIELD(rigcal_neldermead, evals),
    FIELD(rigcal_neldermead, max_evals),
    FIELD(rigcal_neldermead, phase),
    FIELD(rigcal_neldermead, vertex_next),
    FIELD(rigcal_neldermead, status),
    FIELD(rigcal_neldermead, xtol),
    FIELD(rigcal_neldermead, ftol),
    FIELD(rigcal_neldermead, trial),
    FIELD(rigcal_neldermead, reflected),
    FIELD(rigcal_neldermead, vertex),
    STRUCT(rigcal_pair),
    FIELD(rigcal_pair, normal),
    FIELD(rigcal_pair, offset),
    FIELD(rigcal_pair, i),
    FIELD(rigcal_pair, j),
    STRUCT(rigcal_elimination),
    FIELD(rigcal_elimination, angle),
    FIELD(rigcal_elimination, cosine),
    FIELD(rigcal_elimination, sine),
    FIELD(rigcal_elimination, condition),
    FIELD(rigcal_elimination, unit),
    FIELD(rigcal_elimination, residual),
    STRUCT(rigcal_paper_options),
    FIELD(rigcal_paper_options, angles),
    FIELD(rigcal_paper_options, eliminate),
    FIELD(rigcal_paper_options, eliminating),
    FIELD(rigcal_paper_options, use_guess),
    FIELD(rigcal_paper_options, max_evals),
    FIELD(rigcal_paper_options, reserved),
    FIELD(rigcal_paper_options, guess_ypr),
    FIELD(rigcal_paper_options, xtol),
    FIELD(rigcal_paper_options, ftol),
    STRUCT(rigcal_paper_pose),
    FIELD(rigcal_paper_pose, cam_from_world),
    FIELD(rigcal_paper_pose, ypr),
    FIELD(rigcal_paper_pose, residual),
    FIELD(rigcal_paper_pose, condition),
    FIELD(rigcal_paper_pose, rms),
    FIELD(rigcal_paper_pose, eliminated),
    FIELD(rigcal_paper_pose, evals),
    FIELD(rigcal_paper_pose, starts),
    FIELD(rigcal_paper_pose, reserved),
    STRUCT(rigcal_paper_solver),
    FIELD(rigcal_paper_solver, sightings),
    FIELD(rigcal_paper_solver, pairs),
    FIELD(rigcal_paper_solver, n),
    FIELD(rigcal_paper_solver, n_pairs),
    FIELD(rigcal_paper_solver, options),
    FIELD(rigcal_paper_solver, nm),
    FIELD(rigcal_paper_solver, best),
    FIELD(rigcal_paper_solver, least_condition),
    FIELD(rigcal_paper_solver, seed_cost),
    FIELD(rigcal_paper_solver, seed_node),
    FIELD(rigcal_paper_solver, phase),
    FIELD(rigcal_paper_solver, next),
    FIELD(rigcal_paper_solver, eliminate),
    FIELD(rigcal_paper_solver, found),
    FIELD(rigcal_paper_solver, behind),
    FIELD(rigcal_paper_solver, evals),
    FIELD(rigcal_paper_solver, starts),
    FIELD(rigcal_paper_solver, spent),
    STRUCT(rigcal_pose),
    FIELD(rigcal_pose, cam_from_world),
    FIELD(rigcal_pose, sse),
    FIELD(rigcal_pose, rms_px),
    FIELD(rigcal_pose, probability),
    STRUCT(rigcal_pose_options),
    FIELD(rigcal_pose_options, use_start),
    FIELD(rigcal_pose_options, sigma_px),
    FIELD(rigcal_pose_options, start),
    STRUCT(rigcal_lens),
    FIELD(rigcal_lens, is_fisheye),
    FIELD(rigcal_lens, is_pinhole),
    FIELD(rigcal_lens, N),
    FIELD(rigcal_lens, D),
    FIELD(rigcal_lens, q),
    STRUCT(rigcal_fit),
    FIELD(rigcal_fit, camera),
    FIELD(rigcal_fit, observations),
    FIELD(rigcal_fit, sigma),
    FIELD(rigcal_fit, mask),
    FIELD(rigcal_fit, n),
    FIELD(rigcal_fit, is_mirrored),
    FIELD(rigcal_fit, left_out),
    FIELD(rigcal_fit, pixel),
    FIELD(rigcal_fit, nothing),
    FIELD(rigcal_fit, origin),
    FIELD(rigcal_fit, lens),
    STRUCT(rigcal_view_moments),
    FIELD(rigcal_view_moments, weight),
    FIELD(rigcal_view_moments, S),
    FIELD(rigcal_view_moments, u_mean),
    FIELD(rigcal_view_moments, V_mean),
    FIELD(rigcal_view_moments, h),
    FIELD(rigcal_view_moments, Q),
    FIELD(rigcal_view_moments, C),
    FIELD(rigcal_view_moments, G),
    STRUCT(rigcal_refinement),
    FIELD(rigcal_refinement, evals),
    FIELD(rigcal_refinement, is_stale),
    FIELD(rigcal_refinement, curvature),
    FIELD(rigcal_refinement, status),
    FIELD(rigcal_refinement, sse),
    FIELD(rigcal_refinement, last_gain),
    FIELD(rigcal_refinement, lambda),
    FIELD(rigcal_refinement, cam_from_points),
    FIELD(rigcal_refinement, g),
    FIELD(rigcal_refinement, H),
    STRUCT(rigcal_descent),
    FIELD(rigcal_descent, m3),
    FIELD(rigcal_descent, nm),
    STRUCT(rigcal_pose_triple),
    FIELD(rigcal_pose_triple, index),
    FIELD(rigcal_pose_triple, count),
    FIELD(rigcal_pose_triple, ray),
    STRUCT(rigcal_pose_optimum),
    FIELD(rigcal_pose_optimum, rows),
    FIELD(rigcal_pose_optimum, t),
    FIELD(rigcal_pose_optimum, sse),
    STRUCT(rigcal_pose_lattice),
    FIELD(rigcal_pose_lattice, index),
    FIELD(rigcal_pose_lattice, reserved),
    FIELD(rigcal_pose_lattice, least_cost),
    FIELD(rigcal_pose_lattice, azimuth),
    FIELD(rigcal_pose_lattice, cost),
    FIELD(rigcal_pose_lattice, moments),
    STRUCT(rigcal_pose_solver),
    FIELD(rigcal_pose_solver, phase),
    FIELD(rigcal_pose_solver, next),
    FIELD(rigcal_pose_solver, n_seeds),
    FIELD(rigcal_pose_solver, n_exact),
    FIELD(rigcal_pose_solver, n_found),
    FIELD(rigcal_pose_solver, is_flat),
    FIELD(rigcal_pose_solver, is_plane),
    FIELD(rigcal_pose_solver, leans),
    FIELD(rigcal_pose_solver, failure),
    FIELD(rigcal_pose_solver, bad),
    FIELD(rigcal_pose_solver, is_warm),
    FIELD(rigcal_pose_solver, point),
    FIELD(rigcal_pose_solver, is_mirrored),
    FIELD(rigcal_pose_solver, is_vague),
    FIELD(rigcal_pose_solver, is_unfinished),
    FIELD(rigcal_pose_solver, is_wide),
    FIELD(rigcal_pose_solver, picks),
    FIELD(rigcal_pose_solver, n),
    FIELD(rigcal_pose_solver, n_used),
    FIELD(rigcal_pose_solver, extent_px),
    FIELD(rigcal_pose_solver, scale),
    FIELD(rigcal_pose_solver, sigma_px),
    FIELD(rigcal_pose_solver, axis),
    FIELD(rigcal_pose_solver, normal),
    FIELD(rigcal_pose_solver, fit),
    FIELD(rigcal_pose_solver, from),
    FIELD(rigcal_pose_solver, work),
    FIELD(rigcal_pose_solver, found),
    STRUCT(rigcal_pose_uncertainty),
    FIELD(rigcal_pose_uncertainty, Sigma),
    FIELD(rigcal_pose_uncertainty, rotation),
    FIELD(rigcal_pose_uncertainty, translation),
    FIELD(rigcal_pose_uncertainty, center),
    FIELD(rigcal_pose_uncertainty, sigma_px),
    STRUCT(rigcal_robust_options),
    FIELD(rigcal_robust_options, threshold_px),
    FIELD(rigcal_robust_options, sigma_px),
    FIELD(rigcal_robust_options, samples),
    FIELD(rigcal_robust_options, seed),
    STRUCT(rigcal_robust_poses),
    FIELD(rigcal_robust_poses, best),
    FIELD(rigcal_robust_poses, tried),
    FIELD(rigcal_robust_poses, ray),
    FIELD(rigcal_robust_poses, cost),
    STRUCT(rigcal_robust_solver),
    FIELD(rigcal_robust_solver, camera),
    FIELD(rigcal_robust_solver, observations),
    FIELD(rigcal_robust_solver, sigma),
    FIELD(rigcal_robust_solver, inliers),
    FIELD(rigcal_robust_solver, n),
    FIELD(rigcal_robust_solver, n_agree),
    FIELD(rigcal_robust_solver, work),
    FIELD(rigcal_robust_solver, origin),
    FIELD(rigcal_robust_solver, sigma_px),
    FIELD(rigcal_robust_solver, threshold_px),
    FIELD(rigcal_robust_solver, missed),
    FIELD(rigcal_robust_solver, area_px2),
    FIELD(rigcal_robust_solver, random),
    FIELD(rigcal_robust_solver, sample),
    FIELD(rigcal_robust_solver, samples),
    FIELD(rigcal_robust_solver, tried),
    FIELD(rigcal_robust_solver, is_complete),
    FIELD(rigcal_robust_solver, phase),
    FIELD(rigcal_robust_solver, next),
    FIELD(rigcal_robust_solver, n_poses),
    FIELD(rigcal_robust_solver, rounds),
    FIELD(rigcal_robust_solver, failure),
    STRUCT(rigcal_blame),
    FIELD(rigcal_blame, verdict),
    FIELD(rigcal_blame, point),
    FIELD(rigcal_blame, is_rest_poor),
    FIELD(rigcal_blame, reserved),
    FIELD(rigcal_blame, rms_px),
    FIELD(rigcal_blame, rms_without_px),
    FIELD(rigcal_blame, chance),
    FIELD(rigcal_blame, probability),
    STRUCT(rigcal_diagnosis),
    FIELD(rigcal_diagnosis, verdict),
    FIELD(rigcal_diagnosis, is_handed),
    FIELD(rigcal_diagnosis, rms_mirrored_px),
    FIELD(rigcal_diagnosis, rms_flipped_px),
    FIELD(rigcal_diagnosis, units),
    FIELD(rigcal_diagnosis, blame),
    STRUCT(rigcal_point),
    FIELD(rigcal_point, X),
    FIELD(rigcal_point, Sigma),
    FIELD(rigcal_point, rms_px),
    STRUCT(rigcal_view),
    FIELD(rigcal_view, cam_from_target),
    FIELD(rigcal_view, weight),
    FIELD(rigcal_view, camera),
    FIELD(rigcal_view, placement),
    STRUCT(rigcal_mounted_camera),
    FIELD(rigcal_mounted_camera, camera),
    FIELD(rigcal_mounted_camera, cam_from_rig),
    FIELD(rigcal_mounted_camera, Sigma),
    FIELD(rigcal_mounted_camera, has_Sigma),
    FIELD(rigcal_mounted_camera, reserved),
    STRUCT(rigcal_saved_info),
    FIELD(rigcal_saved_info, sequence),
    FIELD(rigcal_saved_info, tag),
    FIELD(rigcal_saved_info, n_cameras),
    FIELD(rigcal_saved_info, n_bytes),
    FIELD(rigcal_saved_info, real_bytes),
};

int32_t rigcal_layout_count(void)
{
    return (int32_t)(sizeof LAYOUT / sizeof LAYOUT[0]);
}

rigcal_status rigcal_layout(rigcal_layout_entry *entry, int32_t index)
{
    if (entry == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (index < 0 || index >= rigcal_layout_count()) {
        return RIGCAL_ERR_RANGE;
    }
    *entry = LAYOUT[index];
    return RIGCAL_OK;
}
