/* rc_layout.h - the structs of the public headers: the one list that rigcal_layout and its
 * test are made from. tests/checks/check_layout.py compares it with the headers.
 *
 * S(struct), F(struct, field). What a solver keeps is its own: S alone. */
#ifndef RC_LAYOUT_H
#define RC_LAYOUT_H

#include "rc_real.h"
#include "rigcal_paper.h"

/* clang-format off */
#define RC_LAYOUT(S, F)                                                            \
    /* rigcal.h */                                                                 \
    S(rigcal_layout_entry)                                                         \
        F(rigcal_layout_entry, name) F(rigcal_layout_entry, offset)                \
        F(rigcal_layout_entry, size)                                               \
    S(rigcal_transform)                                                            \
        F(rigcal_transform, R) F(rigcal_transform, t)                              \
    S(rigcal_camera)                                                               \
        F(rigcal_camera, lens) F(rigcal_camera, width) F(rigcal_camera, height)    \
        F(rigcal_camera, fx) F(rigcal_camera, fy) F(rigcal_camera, cx)             \
        F(rigcal_camera, cy) F(rigcal_camera, k1) F(rigcal_camera, k2)             \
        F(rigcal_camera, p1) F(rigcal_camera, p2) F(rigcal_camera, k3)             \
        F(rigcal_camera, k4) F(rigcal_camera, k5) F(rigcal_camera, k6)             \
    S(rigcal_observation)                                                          \
        F(rigcal_observation, X_w) F(rigcal_observation, uv)                       \
    S(rigcal_view)                                                                 \
        F(rigcal_view, camera) F(rigcal_view, observations) F(rigcal_view, sigma)  \
        F(rigcal_view, n)                                                          \
    S(rigcal_pose)                                                                 \
        F(rigcal_pose, cam_from_world) F(rigcal_pose, sse) F(rigcal_pose, rms_px)  \
        F(rigcal_pose, probability)                                                \
    S(rigcal_pose_options)                                                         \
        F(rigcal_pose_options, use_start) F(rigcal_pose_options, sigma_px)         \
        F(rigcal_pose_options, start)                                              \
    S(rigcal_pose_uncertainty)                                                     \
        F(rigcal_pose_uncertainty, Sigma) F(rigcal_pose_uncertainty, rotation)     \
        F(rigcal_pose_uncertainty, translation) F(rigcal_pose_uncertainty, center) \
        F(rigcal_pose_uncertainty, sigma_px)                                       \
    S(rigcal_robust_options)                                                       \
        F(rigcal_robust_options, threshold_px) F(rigcal_robust_options, sigma_px)  \
        F(rigcal_robust_options, samples) F(rigcal_robust_options, seed)           \
    S(rigcal_blame)                                                                \
        F(rigcal_blame, verdict) F(rigcal_blame, point)                            \
        F(rigcal_blame, is_rest_poor) F(rigcal_blame, rms_px)                      \
        F(rigcal_blame, rms_without_px) F(rigcal_blame, chance)                    \
        F(rigcal_blame, probability)                                               \
    S(rigcal_diagnosis)                                                            \
        F(rigcal_diagnosis, verdict) F(rigcal_diagnosis, is_handed)                \
        F(rigcal_diagnosis, rms_mirrored_px) F(rigcal_diagnosis, rms_flipped_px)   \
        F(rigcal_diagnosis, units) F(rigcal_diagnosis, blame)                      \
    S(rigcal_mounted_camera)                                                       \
        F(rigcal_mounted_camera, camera) F(rigcal_mounted_camera, cam_from_rig)    \
        F(rigcal_mounted_camera, Sigma) F(rigcal_mounted_camera, has_Sigma)        \
    S(rigcal_saved_info)                                                           \
        F(rigcal_saved_info, sequence) F(rigcal_saved_info, tag)                   \
        F(rigcal_saved_info, n_cameras) F(rigcal_saved_info, n_bytes)              \
        F(rigcal_saved_info, real_bytes)                                           \
    /* rigcal_measure.h */                                                         \
    S(rigcal_point)                                                                \
        F(rigcal_point, X) F(rigcal_point, Sigma) F(rigcal_point, rms_px)          \
    /* rigcal_rig.h */                                                             \
    S(rigcal_rig_view)                                                             \
        F(rigcal_rig_view, view) F(rigcal_rig_view, camera)                        \
        F(rigcal_rig_view, placement) F(rigcal_rig_view, target)                   \
    S(rigcal_view_pose)                                                            \
        F(rigcal_view_pose, cam_from_target) F(rigcal_view_pose, information)      \
        F(rigcal_view_pose, sse) F(rigcal_view_pose, n)                            \
        F(rigcal_view_pose, camera) F(rigcal_view_pose, placement)                 \
    S(rigcal_camera_prior)                                                         \
        F(rigcal_camera_prior, cam_from_rig) F(rigcal_camera_prior, Sigma)         \
    S(rigcal_rig)                                                                  \
        F(rigcal_rig, cams_from_rig) F(rigcal_rig, n_cameras)                      \
        F(rigcal_rig, rig_from_placements) F(rigcal_rig, n_placements)             \
        F(rigcal_rig, group) F(rigcal_rig, n_views) F(rigcal_rig, views)           \
        F(rigcal_rig, view_source) F(rigcal_rig, view_poses)                       \
        F(rigcal_rig, view_pose_source) F(rigcal_rig, context)                     \
        F(rigcal_rig, roles) F(rigcal_rig, priors) F(rigcal_rig, sigma_px)         \
        F(rigcal_rig, work) F(rigcal_rig, work_capacity)                           \
    S(rigcal_rig_fit)                                                              \
        F(rigcal_rig_fit, sum) F(rigcal_rig_fit, freedom)                          \
        F(rigcal_rig_fit, sigma_px) F(rigcal_rig_fit, n_points)                    \
        F(rigcal_rig_fit, evals) F(rigcal_rig_fit, F)                              \
        F(rigcal_rig_fit, freedom_between) F(rigcal_rig_fit, freedom_within)       \
    /* rigcal_paper.h */                                                           \
    S(rigcal_bearing)                                                              \
        F(rigcal_bearing, X_w) F(rigcal_bearing, ray)                              \
    S(rigcal_pair)                                                                 \
        F(rigcal_pair, normal) F(rigcal_pair, offset) F(rigcal_pair, i)            \
        F(rigcal_pair, j)                                                          \
    S(rigcal_elimination)                                                          \
        F(rigcal_elimination, angle) F(rigcal_elimination, cosine)                 \
        F(rigcal_elimination, sine) F(rigcal_elimination, condition)               \
        F(rigcal_elimination, unit) F(rigcal_elimination, residual)                \
    S(rigcal_paper_options)                                                        \
        F(rigcal_paper_options, angles) F(rigcal_paper_options, eliminated)        \
        F(rigcal_paper_options, pairs_used) F(rigcal_paper_options, use_guess)     \
        F(rigcal_paper_options, max_evals) F(rigcal_paper_options, guess_ypr)      \
        F(rigcal_paper_options, xtol) F(rigcal_paper_options, ftol)                \
    S(rigcal_paper_pose)                                                           \
        F(rigcal_paper_pose, cam_from_world) F(rigcal_paper_pose, ypr)             \
        F(rigcal_paper_pose, residual) F(rigcal_paper_pose, condition)             \
        F(rigcal_paper_pose, rms) F(rigcal_paper_pose, eliminated)                 \
        F(rigcal_paper_pose, evals) F(rigcal_paper_pose, starts)                   \
    /* solvers */                                                                  \
    S(rigcal_pose_solver) S(rigcal_robust_solver) S(rigcal_rig_solver)             \
    S(rigcal_paper_solver) S(rigcal_neldermead)
/* clang-format on */

#endif /* RC_LAYOUT_H */
