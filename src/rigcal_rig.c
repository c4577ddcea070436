#include "rc_transform.h"

static rigcal_status check_views(const rigcal_view_pose views[], size_t n_views,
                                 size_t n_cameras)
{
    for (size_t i = 0; i < n_views; i++) {
        const rigcal_view_pose *const v = &views[i];
        const rigcal_status status = rc_check_transform(&v->cam_from_target);
        if (status != RIGCAL_OK) {
            return status;
        }
        if (!rc_is_finite(v->weight)) {
            return RIGCAL_ERR_NOT_FINITE;
        }
        if (!(v->weight > 0 && v->weight <= RC_COORDINATE_MAX) || v->camera < 0 ||
            (size_t)v->camera >= n_cameras || v->placement < 0) {
            return RIGCAL_ERR_RANGE;
        }
    }
    return RIGCAL_OK;
}

/* rig_from_target of one placement: the mean over the cameras of `in_group` that
 * saw it, as work[first] onwards. *total gets their weight.
 * OK, ERR_TOO_FEW (none did), ERR_ROTATION. */
static rigcal_status place(rigcal_transform *rig_from_target, rigcal_real *total,
                           const rigcal_rig *r, int32_t placement, int32_t in_group,
                           size_t first)
{
    size_t n = first;
    *total = 0;
    for (size_t i = 0; i < r->n_views; i++) {
        const rigcal_view_pose *const v = &r->views[i];
        if (v->placement == placement && r->group[v->camera] == in_group) {
            rigcal_transform rig_from_cam;
            rc_transform_invert(&rig_from_cam, &r->cams_from_rig[v->camera]);
            rc_transform_compose(&r->work[n], &rig_from_cam, &v->cam_from_target);
            r->weight[n++] = v->weight;
            *total += v->weight;
        }
    }
    return (n == first) ? RIGCAL_ERR_TOO_FEW
                        : rc_transform_mean(rig_from_target, NULL, NULL, &r->work[first],
                                            &r->weight[first], n - first);
}

/* Weight of what camera c shares with a group: over its views, that of the
 * placements that the group saw too. */
static rigcal_real shared_weight(const rigcal_rig *r, int32_t camera, int32_t in_group)
{
    rigcal_real shared = 0;
    for (size_t i = 0; i < r->n_views; i++) {
        int seen = 0;
        if (r->views[i].camera != camera) {
            continue;
        }
        for (size_t j = 0; j < r->n_views && !seen; j++) {
            seen = r->views[j].placement == r->views[i].placement &&
                   r->group[r->views[j].camera] == in_group;
        }
        shared += seen ? r->views[i].weight : 0;
    }
    return shared;
}

/* Camera c from every placement that it shares with the group. Two weights w and
 * W meeting in one estimate count as 1 / (1/w + 1/W), as inverse variances do. */
static rigcal_status join_camera(rigcal_transform *cam_from_rig, const rigcal_rig *r,
                                 int32_t camera, int32_t in_group)
{
    size_t n = 0;
    for (size_t i = 0; i < r->n_views; i++) {
        const rigcal_view_pose *const v = &r->views[i];
        rigcal_transform rig_from_target;
        rigcal_real total;
        if (v->camera != camera) {
            continue;
        }
        const rigcal_status status =
            place(&rig_from_target, &total, r, v->placement, in_group, n);
        if (status == RIGCAL_ERR_TOO_FEW) {
            continue;
        }
        if (status != RIGCAL_OK) {
            return status;
        }
        rc_transform_between(&r->work[n], &v->cam_from_target, &rig_from_target);
        /* 1 / (1/a + 1/b), written so that nothing overflows. */
        const rigcal_real less = rc_min(v->weight, total);
        r->weight[n++] = less / (1 + less / rc_max(v->weight, total));
    }
    return rc_transform_mean(cam_from_rig, NULL, NULL, r->work, r->weight, n);
}

/* The camera, of those not yet joined, that shares most with the group; -1 when
 * none shares anything. */
static int32_t best_candidate(const rigcal_rig *r, int32_t in_group)
{
    int32_t best = -1;
    rigcal_real most = 0;
    for (size_t c = 0; c < r->n_cameras; c++) {
        if (r->group[c] < 0) {
            const rigcal_real shared = shared_weight(r, (int32_t)c, in_group);
            if (shared > most) {
                most = shared;
                best = (int32_t)c;
            }
        }
    }
    return best;
}

/* From one camera, everything that connects to it. */
static rigcal_status join_group(rigcal_rig *r, int32_t first, int32_t in_group)
{
    rigcal_status status = RIGCAL_OK;
    int32_t next = first;
    rc_transform_identity(&r->cams_from_rig[first]);
    for (size_t i = 0; i < r->n_cameras && next >= 0; i++) {
        r->group[next] = in_group;
        next = best_candidate(r, in_group);
        if (next >= 0) {
            status = join_camera(&r->cams_from_rig[next], r, next, in_group);
        }
        if (status != RIGCAL_OK) {
            break;
        }
    }
    return status;
}

static rigcal_status check_rig(const rigcal_rig *r)
{
    if (r == NULL || r->cams_from_rig == NULL || r->group == NULL || r->work == NULL ||
        r->weight == NULL || r->views == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (r->n_cameras < 1) {
        return RIGCAL_ERR_TOO_FEW;
    }
    if (r->n_cameras > RC_COUNT_MAX || r->n_views > RC_COUNT_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    return check_views(r->views, r->n_views, r->n_cameras);
}

rigcal_status rigcal_rig_join(rigcal_rig *rig)
{
    rigcal_status status = check_rig(rig);
    if (status != RIGCAL_OK) {
        return status;
    }
    int32_t groups = 0;
    for (size_t c = 0; c < rig->n_cameras; c++) {
        rig->group[c] = -1;
    }
    for (size_t c = 0; c < rig->n_cameras && status == RIGCAL_OK; c++) {
        if (rig->group[c] < 0) {
            status = join_group(rig, (int32_t)c, groups);
            groups++;
        }
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    return (groups > 1) ? RIGCAL_DISCONNECTED : RIGCAL_OK;
}

rigcal_status rigcal_rig_place(rigcal_transform *rig_from_target, rigcal_rig *rig,
                               int32_t placement, int32_t in_group)
{
    rigcal_real total;
    rigcal_status status = (rig_from_target == NULL) ? RIGCAL_ERR_NULL : check_rig(rig);
    if (status == RIGCAL_OK && (placement < 0 || in_group < 0)) {
        status = RIGCAL_ERR_RANGE;
    }
    for (size_t c = 0; status == RIGCAL_OK && c < rig->n_cameras; c++) {
        status = rc_check_transform(&rig->cams_from_rig[c]);
    }
    return (status == RIGCAL_OK)
               ? place(rig_from_target, &total, rig, placement, in_group, 0)
               : status;
}
