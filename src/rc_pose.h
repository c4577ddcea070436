/* rc_pose.h - what the pose solver is made of. */
#ifndef RC_POSE_H
#define RC_POSE_H

#include "rc_neldermead.h"
#include "rc_p3p.h"
#include "rc_refine.h"
#include "rc_view.h"

/* Where the points are. */
typedef struct {
    rigcal_real origin[3];    /* their weighted mean */
    rigcal_real size;         /* their longest distance from the first, along an axis */
    rigcal_real uv_middle[2]; /* weighted mean of the pixels */
    rigcal_real extent_px;    /* their longest distance from the first, likewise */
    size_t n_used;
} rc_survey;

/* Of the points that count; of data as rc_fit_of makes them. OK;
 * ERR_NOT_FINITE, ERR_RANGE of the observation *bad, else -1; ERR_TOO_FEW (below 3); and,
 * the survey made, ERR_COINCIDENT, ERR_PRECISION. */
rigcal_status rc_survey_points(rc_survey *out, int32_t *bad, const rigcal_fit *fit);

/* Whether the points, counted from `origin`, are on a line to rounding. */
int rc_are_on_line(const rigcal_observation o[], size_t n, const rigcal_real origin[3]);

/* rigcal_pose_begin of data as rc_fit_of makes them, of which the camera and the
 * observations are checked here. */
rigcal_status rc_pose_begin(rigcal_pose_solver *solver, int32_t *bad,
                            const rigcal_fit *data, const rigcal_pose_options *options);

/* (D) All poses of three of the points from their rays; how many, as of rc_p3p. */
int32_t rc_poses_of_three(rigcal_transform cam_from_points[RC_P3P_MAX],
                          const rigcal_fit *fit, const int32_t index[3],
                          const rigcal_real ray[3][3]);

void rc_found_transform(rigcal_transform *cam_from_points,
                        const rigcal_pose_optimum *found);

/* (C) Likelihood of a sum of squared errors over that of another, for n >= 3 points.
 * sigma_px 0: unknown, and integrated over; `pixel` as of rc_pixel_size. Underflows to 0,
 * overflows to infinity. */
rigcal_real rc_odds(rigcal_real sse, rigcal_real other, rigcal_real sigma_px,
                    rigcal_real pixel, size_t n);

/* Of a search that is done: likelihood of optimum i over that of the first. */
rigcal_real rc_pose_likelihood(const rigcal_pose_solver *s, int32_t i);

#endif /* RC_POSE_H */
