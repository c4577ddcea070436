/* rc_layout.h - the one list of the structs of the public headers, from which rigcal_layout
 * and its test are made. tests/checks/check_layout.py compares it with the headers.
 *
 * S(struct) and M(struct, member). The members of a solver are its own, so it has only
 * S. */
#ifndef RC_LAYOUT_H
#define RC_LAYOUT_H

#include "rc_real.h"
#include "rigcal_paper.h"

/* clang-format off */
#define RC_LAYOUT(S, M)                                                            \
    /* rigcal.h */                                                                 \
    S(rigcal_layout_entry)                                                         \
        M(rigcal_layout_entry, name) M(rigcal_layout_entry, offset)                \
        M(rigcal_layout_entry, size)                                               \
    S(rigcal_transform)                                                            \
        M(rigcal_transform, R) M(rigcal_transform, t)                              \
    S(rigcal_camera)                                                               \
        M(rigcal_camera, lens) M(rigcal_camera, width) M(rigcal_camera, height)    \
        M(rigcal_camera, fx) M(rigcal_camera, fy) M(rigcal_camera, cx)             \
        M(rigcal_camera, cy) M(rigcal_camera, k1) M(rigcal_camera, k2)             \
        M(rigcal_camera, p1) M(rigcal_camera, p2) M(rigcal_camera, k3)             \
        M(rigcal_camera, k4) M(rigcal_camera, k5) M(rigcal_camera, k6)             \
    S(rigcal_observation)                                                          \
        M(rigcal_observation, X_w) M(rigcal_observation, uv)                       \
    S(rigcal_view)                                                                 \
        M(rigcal_view, camera) M(rigcal_view, observations) M(rigcal_view, sigma)  \
        M(rigcal_view, n)                                                          \
    S(rigcal_pose)                                                                 \
        M(rigcal_pose, cam_from_world) M(rigcal_pose, sse) M(rigcal_pose, rms_px)  \
        M(rigcal_pose, probability)                                                \
    S(rigcal_pose_options)                                                         \
        M(rigcal_pose_options, use_start) M(rigcal_pose_options, sigma_px)         \
        M(rigcal_pose_options, start)                                              \
    S(rigcal_pose_uncertainty)                                                     \
        M(rigcal_pose_uncertainty, Sigma) M(rigcal_pose_uncertainty, rotation)     \
        M(rigcal_pose_uncertainty, translation) M(rigcal_pose_uncertainty, center) \
        M(rigcal_pose_uncertainty, sigma_px)                                       \
    S(rigcal_robust_options)                                                       \
        M(rigcal_robust_options, threshold_px) M(rigcal_robust_options, sigma_px)  \
        M(rigcal_robust_options, samples) M(rigcal_robust_options, seed)           \
        M(rigcal_robust_options, max_units)                                        \
    S(rigcal_blame)                                                                \
        M(rigcal_blame, verdict) M(rigcal_blame, point)                            \
        M(rigcal_blame, is_rest_poor) M(rigcal_blame, rms_px)                      \
        M(rigcal_blame, rms_without_px) M(rigcal_blame, chance)                    \
        M(rigcal_blame, probability)                                               \
    S(rigcal_diagnosis)                                                            \
        M(rigcal_diagnosis, verdict) M(rigcal_diagnosis, is_handed)                \
        M(rigcal_diagnosis, rms_mirrored_px) M(rigcal_diagnosis, rms_flipped_px)   \
        M(rigcal_diagnosis, units) M(rigcal_diagnosis, blame)                      \
    S(rigcal_mounted_camera)                                                       \
        M(rigcal_mounted_camera, camera) M(rigcal_mounted_camera, cam_from_rig)    \
        M(rigcal_mounted_camera, Sigma) M(rigcal_mounted_camera, has_Sigma)        \
    S(rigcal_saved_info)                                                           \
        M(rigcal_saved_info, sequence) M(rigcal_saved_info, tag)                   \
        M(rigcal_saved_info, n_cameras) M(rigcal_saved_info, n_free)               \
        M(rigcal_saved_info, n_bytes) M(rigcal_saved_info, real_bytes)             \
    /* rigcal_measure.h */                                                         \
    S(rigcal_point)                                                                \
        M(rigcal_point, X) M(rigcal_point, Sigma) M(rigcal_point, rms_px)          \
    /* rigcal_rig.h */                                                             \
    S(rigcal_rig_view)                                                             \
        M(rigcal_rig_view, view) M(rigcal_rig_view, camera)                        \
        M(rigcal_rig_view, placement) M(rigcal_rig_view, target)                   \
    S(rigcal_view_pose)                                                            \
        M(rigcal_view_pose, cam_from_target) M(rigcal_view_pose, information)      \
        M(rigcal_view_pose, sse) M(rigcal_view_pose, n)                            \
        M(rigcal_view_pose, camera) M(rigcal_view_pose, placement)                 \
    S(rigcal_camera_prior)                                                         \
        M(rigcal_camera_prior, cam_from_rig) M(rigcal_camera_prior, Sigma)         \
    S(rigcal_intrinsics_sigma)                                                     \
        M(rigcal_intrinsics_sigma, focal) M(rigcal_intrinsics_sigma, aspect)       \
        M(rigcal_intrinsics_sigma, centre) M(rigcal_intrinsics_sigma, k1)          \
        M(rigcal_intrinsics_sigma, k2)                                             \
    S(rigcal_rig)                                                                  \
        M(rigcal_rig, cams_from_rig) M(rigcal_rig, n_cameras)                      \
        M(rigcal_rig, rig_from_placements) M(rigcal_rig, n_placements)             \
        M(rigcal_rig, group) M(rigcal_rig, n_views) M(rigcal_rig, views)           \
        M(rigcal_rig, view_source) M(rigcal_rig, view_poses)                       \
        M(rigcal_rig, view_pose_source) M(rigcal_rig, context)                     \
        M(rigcal_rig, left_out)                                                    \
        M(rigcal_rig, roles) M(rigcal_rig, priors)                                 \
        M(rigcal_rig, priors_information) M(rigcal_rig, sigma_px)                  \
        M(rigcal_rig, work) M(rigcal_rig, work_capacity) M(rigcal_rig, clocks)     \
        M(rigcal_rig, intrinsics_sigmas) M(rigcal_rig, considered)                 \
    S(rigcal_rig_fit)                                                              \
        M(rigcal_rig_fit, sum) M(rigcal_rig_fit, freedom)                          \
        M(rigcal_rig_fit, sigma_px) M(rigcal_rig_fit, n_points)                    \
        M(rigcal_rig_fit, evals) M(rigcal_rig_fit, F)                              \
        M(rigcal_rig_fit, freedom_between) M(rigcal_rig_fit, freedom_within)       \
    S(rigcal_calibrated_rig)                                                       \
        M(rigcal_calibrated_rig, cameras) M(rigcal_calibrated_rig, group)          \
        M(rigcal_calibrated_rig, held) M(rigcal_calibrated_rig, capacity)          \
        M(rigcal_calibrated_rig, Sigma) M(rigcal_calibrated_rig, Sigma_capacity)   \
        M(rigcal_calibrated_rig, n_cameras) M(rigcal_calibrated_rig, sigma_px)     \
        M(rigcal_calibrated_rig, F) M(rigcal_calibrated_rig, freedom_between)      \
        M(rigcal_calibrated_rig, freedom_within)                                   \
    /* rigcal_choose.h */                                                          \
    S(rigcal_link)                                                                 \
        M(rigcal_link, n_shared) M(rigcal_link, information)                       \
    S(rigcal_advice)                                                               \
        M(rigcal_advice, a) M(rigcal_advice, b)                                    \
    S(rigcal_weakest)                                                              \
        M(rigcal_weakest, camera) M(rigcal_weakest, other)                         \
        M(rigcal_weakest, rotation) M(rigcal_weakest, translation)                 \
    S(rigcal_choice)                                                               \
        M(rigcal_choice, second_poses) M(rigcal_choice, second_source)             \
        M(rigcal_choice, takes) M(rigcal_choice, sigma_px)                         \
        M(rigcal_choice, tau2) M(rigcal_choice, share)                             \
        M(rigcal_choice, n_left_out)                                               \
    /* rigcal_judge.h */                                                           \
    S(rigcal_judged_view)                                                          \
        M(rigcal_judged_view, verdict) M(rigcal_judged_view, cost)                 \
        M(rigcal_judged_view, rms_px)                                              \
    S(rigcal_judgement)                                                            \
        M(rigcal_judgement, fit) M(rigcal_judgement, sigma_px)                     \
        M(rigcal_judgement, scale) M(rigcal_judgement, n_fit)                      \
        M(rigcal_judgement, n_contradict) M(rigcal_judgement, n_one_of_two)        \
        M(rigcal_judgement, n_unchecked) M(rigcal_judgement, adjustments)          \
    S(rigcal_cause)                                                                \
        M(rigcal_cause, cause) M(rigcal_cause, permutation) M(rigcal_cause, shift) \
        M(rigcal_cause, is_still) M(rigcal_cause, camera) M(rigcal_cause, n_agree) \
        M(rigcal_cause, n_views) M(rigcal_cause, distance)                         \
    S(rigcal_symmetries)                                                           \
        M(rigcal_symmetries, permutations) M(rigcal_symmetries, n_permutations)    \
        M(rigcal_symmetries, n_points) M(rigcal_symmetries, room)                  \
    /* rigcal_clocks.h */                                                          \
    S(rigcal_motion)                                                               \
        M(rigcal_motion, n) M(rigcal_motion, t)                                    \
        M(rigcal_motion, c)                                                        \
    S(rigcal_clock_memory)                                                         \
        M(rigcal_clock_memory, pass) M(rigcal_clock_memory, is_moved)              \
        M(rigcal_clock_memory, placement) M(rigcal_clock_memory, motion)           \
        M(rigcal_clock_memory, step) M(rigcal_clock_memory, moved)                 \
        M(rigcal_clock_memory, views) M(rigcal_clock_memory, late)                 \
        M(rigcal_clock_memory, velocity) M(rigcal_clock_memory, after)             \
        M(rigcal_clock_memory, since) M(rigcal_clock_memory, middle)               \
        M(rigcal_clock_memory, ratio2)                                             \
    S(rigcal_rig_clocks)                                                           \
        M(rigcal_rig_clocks, calls) M(rigcal_rig_clocks, times)                    \
        M(rigcal_rig_clocks, view_times) M(rigcal_rig_clocks, instants)            \
        M(rigcal_rig_clocks, offsets) M(rigcal_rig_clocks, drifts)                 \
        M(rigcal_rig_clocks, held) M(rigcal_rig_clocks, states)                    \
        M(rigcal_rig_clocks, free_offsets) M(rigcal_rig_clocks, free_drifts)       \
        M(rigcal_rig_clocks, neighbours) M(rigcal_rig_clocks, frame)               \
        M(rigcal_rig_clocks, sigma_time) M(rigcal_rig_clocks, memory)              \
    /* rigcal_faults.h */                                                          \
    S(rigcal_fault)                                                                \
        M(rigcal_fault, kind) M(rigcal_fault, camera) M(rigcal_fault, placement)   \
        M(rigcal_fault, n) M(rigcal_fault, is_seen) M(rigcal_fault, explains)      \
        M(rigcal_fault, value) M(rigcal_fault, sigma) M(rigcal_fault, gain)        \
        M(rigcal_fault, p) M(rigcal_fault, bic) M(rigcal_fault, F_after)           \
        M(rigcal_fault, turn) M(rigcal_fault, shift)                               \
    S(rigcal_faults)                                                               \
        M(rigcal_faults, verdict) M(rigcal_faults, bits) M(rigcal_faults, n)       \
        M(rigcal_faults, n_alike) M(rigcal_faults, n_seen)                         \
        M(rigcal_faults, n_cameras) M(rigcal_faults, passes) M(rigcal_faults, F)   \
        M(rigcal_faults, freedom_between) M(rigcal_faults, freedom_within)         \
        M(rigcal_faults, sigma_px) M(rigcal_faults, own_px)                        \
        M(rigcal_faults, explained) M(rigcal_faults, pattern)                      \
        M(rigcal_faults, pattern_sigma) M(rigcal_faults, along)                    \
        M(rigcal_faults, along_time) M(rigcal_faults, frame)                       \
        M(rigcal_faults, clocks)                                                   \
    S(rigcal_faults_options)                                                       \
        M(rigcal_faults_options, kinds) M(rigcal_faults_options, is_truncated)     \
        M(rigcal_faults_options, breaks) M(rigcal_faults_options, clocks)          \
        M(rigcal_faults_options, work) M(rigcal_faults_options, work_capacity)     \
    S(rigcal_faults_words)                                                         \
        M(rigcal_faults_words, names) M(rigcal_faults_words, length)               \
        M(rigcal_faults_words, time) M(rigcal_faults_words, length_scale)          \
        M(rigcal_faults_words, time_scale) M(rigcal_faults_words, with_unseen)     \
    /* rigcal_consider.h */                                                        \
    S(rigcal_considered)                                                           \
        M(rigcal_considered, by) M(rigcal_considered, n) M(rigcal_considered, k)   \
        M(rigcal_considered, effects) M(rigcal_considered, capacity)               \
        M(rigcal_considered, loss)                                                 \
        M(rigcal_considered, factor)                                               \
        M(rigcal_considered, sum) M(rigcal_considered, own_sum)                    \
    S(rigcal_intrinsics_change)                                                    \
        M(rigcal_intrinsics_change, focal) M(rigcal_intrinsics_change, aspect)     \
        M(rigcal_intrinsics_change, cx) M(rigcal_intrinsics_change, cy)            \
        M(rigcal_intrinsics_change, k1) M(rigcal_intrinsics_change, k2)            \
    S(rigcal_estimated)                                                            \
        M(rigcal_estimated, considered) M(rigcal_estimated, made)                  \
        M(rigcal_estimated, change) M(rigcal_estimated, sigma)                     \
        M(rigcal_estimated, step)                                                  \
    /* rigcal_point.h */                                                           \
    S(rigcal_sighting)                                                             \
        M(rigcal_sighting, camera) M(rigcal_sighting, uv)                          \
    S(rigcal_sightings)                                                            \
        M(rigcal_sightings, rig) M(rigcal_sightings, seen) M(rigcal_sightings, n)  \
        M(rigcal_sightings, sigma_px) M(rigcal_sightings, parallax_least)          \
        M(rigcal_sightings, keep_all) M(rigcal_sightings, work)                    \
        M(rigcal_sightings, work_capacity)                                         \
    S(rigcal_point_gain)                                                           \
        M(rigcal_point_gain, camera) M(rigcal_point_gain, gain)                    \
    S(rigcal_measured_point)                                                       \
        M(rigcal_measured_point, X) M(rigcal_measured_point, Sigma)                \
        M(rigcal_measured_point, Sigma_noise) M(rigcal_measured_point, chi2)       \
        M(rigcal_measured_point, freedom) M(rigcal_measured_point, parallax)       \
        M(rigcal_measured_point, rms_px) M(rigcal_measured_point, n_used)          \
        M(rigcal_measured_point, gains) M(rigcal_measured_point, gains_capacity)   \
    /* rigcal_match.h */                                                           \
    S(rigcal_ray)                                                                  \
        M(rigcal_ray, m) M(rigcal_ray, D)                                          \
    S(rigcal_match_pair)                                                           \
        M(rigcal_match_pair, camera_a) M(rigcal_match_pair, camera_b)              \
        M(rigcal_match_pair, b_from_a) M(rigcal_match_pair, Sigma)                 \
        M(rigcal_match_pair, sigma_a) M(rigcal_match_pair, sigma_b)                \
        M(rigcal_match_pair, k) M(rigcal_match_pair, near_a)                       \
        M(rigcal_match_pair, far_a)                                                \
    S(rigcal_band)                                                                 \
        M(rigcal_band, camera_b) M(rigcal_band, ray) M(rigcal_band, towards)       \
        M(rigcal_band, along) M(rigcal_band, across) M(rigcal_band, line)          \
        M(rigcal_band, Sigma_line) M(rigcal_band, epipole2)                        \
        M(rigcal_band, sigma_b) M(rigcal_band, k) M(rigcal_band, near_a)           \
        M(rigcal_band, far_a)                                                      \
    S(rigcal_band_point)                                                           \
        M(rigcal_band_point, uv) M(rigcal_band_point, across)                      \
        M(rigcal_band_point, half_width) M(rigcal_band_point, depth_a)             \
    S(rigcal_match)                                                                \
        M(rigcal_match, index) M(rigcal_match, is_inside) M(rigcal_match, chi2)    \
        M(rigcal_match, distance_px) M(rigcal_match, half_width_px)                \
        M(rigcal_match, score) M(rigcal_match, depth_a)                            \
    S(rigcal_span)                                                                 \
        M(rigcal_span, row) M(rigcal_span, first) M(rigcal_span, last)             \
    S(rigcal_transfer)                                                             \
        M(rigcal_transfer, uv) M(rigcal_transfer, Sigma) M(rigcal_transfer, X)     \
        M(rigcal_transfer, Sigma_X) M(rigcal_transfer, chi2)                       \
    S(rigcal_rectified)                                                            \
        M(rigcal_rectified, aligned_from_a) M(rigcal_rectified, aligned_from_b)    \
        M(rigcal_rectified, baseline) M(rigcal_rectified, a_is_right)              \
        M(rigcal_rectified, camera)                                                \
    /* rigcal_monitor.h */                                                         \
    S(rigcal_monitor_options)                                                      \
        M(rigcal_monitor_options, arl0_frames) M(rigcal_monitor_options, common)   \
        M(rigcal_monitor_options, wrong) M(rigcal_monitor_options, walk_rad)       \
        M(rigcal_monitor_options, walk_t) M(rigcal_monitor_options, move_rad)      \
        M(rigcal_monitor_options, move_t)                                          \
    S(rigcal_monitor_report)                                                       \
        M(rigcal_monitor_report, alarm) M(rigcal_monitor_report, body)             \
        M(rigcal_monitor_report, confidence) M(rigcal_monitor_report, evidence)    \
        M(rigcal_monitor_report, noise) M(rigcal_monitor_report, smallest_rad)     \
        M(rigcal_monitor_report, n_blind) M(rigcal_monitor_report, frames)         \
        M(rigcal_monitor_report, rows) M(rigcal_monitor_report, doubted)           \
        M(rigcal_monitor_report, frames_since)                                     \
    S(rigcal_body_report)                                                          \
        M(rigcal_body_report, is_blind) M(rigcal_body_report, share)               \
        M(rigcal_body_report, blame) M(rigcal_body_report, smallest_rad)           \
        M(rigcal_body_report, weakest) M(rigcal_body_report, weakest_sigma)        \
    /* rigcal_paper.h */                                                           \
    S(rigcal_bearing)                                                              \
        M(rigcal_bearing, X_w) M(rigcal_bearing, ray)                              \
    S(rigcal_pair)                                                                 \
        M(rigcal_pair, normal) M(rigcal_pair, offset) M(rigcal_pair, i)            \
        M(rigcal_pair, j)                                                          \
    S(rigcal_elimination)                                                          \
        M(rigcal_elimination, angle) M(rigcal_elimination, cosine)                 \
        M(rigcal_elimination, sine) M(rigcal_elimination, condition)               \
        M(rigcal_elimination, unit) M(rigcal_elimination, residual)                \
    S(rigcal_paper_options)                                                        \
        M(rigcal_paper_options, angles) M(rigcal_paper_options, eliminated)        \
        M(rigcal_paper_options, pairs_used) M(rigcal_paper_options, use_guess)     \
        M(rigcal_paper_options, max_evals) M(rigcal_paper_options, guess_ypr)      \
        M(rigcal_paper_options, xtol) M(rigcal_paper_options, ftol)                \
    S(rigcal_paper_pose)                                                           \
        M(rigcal_paper_pose, cam_from_world) M(rigcal_paper_pose, ypr)             \
        M(rigcal_paper_pose, residual) M(rigcal_paper_pose, condition)             \
        M(rigcal_paper_pose, rms) M(rigcal_paper_pose, eliminated)                 \
        M(rigcal_paper_pose, evals) M(rigcal_paper_pose, starts)                   \
    /* solvers */                                                                  \
    S(rigcal_pose_solver) S(rigcal_robust_solver) S(rigcal_rig_solver)             \
    S(rigcal_choose_solver) S(rigcal_judge_solver) S(rigcal_cause_solver)          \
    S(rigcal_consider_solver) S(rigcal_faults_solver) S(rigcal_point_solver)       \
    S(rigcal_spans_solver)                                                         \
    S(rigcal_paper_solver) S(rigcal_neldermead)
/* clang-format on */

#endif /* RC_LAYOUT_H */
