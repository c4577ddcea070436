#include "rc_adjust.h"

/* The join: poses from which the least squares of the views' own poses starts. From what is
 * fixed, cameras are reached by the view of most information that leads to them, all that
 * one placement apart first. */

/* What a camera, not yet reached, is best reached by. */
typedef struct {
    rigcal_real information;
    rigcal_transform cam_from_rig;
} candidate;

/* 1 / variance of its rotation, for noise of 1 px. */
static rigcal_real information_of(const rigcal_view_pose *v)
{
    rigcal_real trace = 0;
    return rc_sym6_inverse_trace(&trace, v->information) ? 1 / trace : 0;
}

/* The placement whose views begin with `first`, by the best of those whose camera is
 * reached. Returns that one's information; 0: there is none. */
static rigcal_status place(rigcal_real *information, rigcal_transform *rig_from_placement,
                           const rigcal_rig *rig, const rc_rig_parts *parts, size_t first,
                           size_t count)
{
    *information = 0;
    for (size_t i = first; i < first + count; i++) {
        rigcal_view_pose v;
        const rigcal_status status = rc_rig_pose_at(&v, rig, i);
        if (status != RIGCAL_OK) {
            return status;
        }
        const rigcal_real more = information_of(&v);
        if (parts->slot[v.camera] > 0 && more > *information) {
            rigcal_transform rig_from_cam;
            rc_transform_invert(&rig_from_cam, &rig->cams_from_rig[v.camera]);
            rc_transform_compose(rig_from_placement, &rig_from_cam, &v.cam_from_target);
            *information = more;
        }
    }
    return RIGCAL_OK;
}

/* The cameras of that placement that are not reached. The information of a way is that of
 * its two views, as inverse variances are added. */
static rigcal_status reach(candidate best[], const rigcal_rig *rig,
                           const rc_rig_parts *parts, size_t first, size_t count,
                           rigcal_real information,
                           const rigcal_transform *rig_from_placement)
{
    for (size_t i = first; i < first + count; i++) {
        rigcal_view_pose v;
        const rigcal_status status = rc_rig_pose_at(&v, rig, i);
        if (status != RIGCAL_OK) {
            return status;
        }
        if (parts->slot[v.camera] > 0) {
            continue;
        }
        candidate *const c = &best[v.camera];
        const rigcal_real other = information_of(&v);
        const rigcal_real less = rc_min(information, other);
        const rigcal_real way = less / (1 + less / rc_max(information, other));
        if (way > c->information) {
            rigcal_transform placement_from_rig;
            rc_transform_invert(&placement_from_rig, rig_from_placement);
            rc_transform_compose(&c->cam_from_rig, &v.cam_from_target, &placement_from_rig);
            c->information = way;
        }
    }
    return RIGCAL_OK;
}

/* Places what it can, and finds the best way to each camera. */
static rigcal_status look_around(candidate best[], const rigcal_rig *rig,
                                 const rc_rig_parts *parts)
{
    size_t first = 0;
    for (size_t f = 0; f < rig->n_placements; f++) {
        const size_t count = (size_t)parts->count[f];
        rigcal_transform *const placement = &rig->rig_from_placements[f];
        rigcal_real information;
        rigcal_status status = place(&information, placement, rig, parts, first, count);
        if (status == RIGCAL_OK && information > 0) {
            status = reach(best, rig, parts, first, count, information, placement);
        }
        if (status != RIGCAL_OK) {
            return status;
        }
        first += count;
    }
    return RIGCAL_OK;
}

/* Where the cameras are that are fixed; parts->slot says of each whether it is reached. */
static rigcal_status begin(const rigcal_rig *rig, const rc_rig_parts *parts)
{
    for (size_t c = 0; c < rig->n_cameras; c++) {
        const uint8_t role = (rig->roles == NULL) ? RIGCAL_CAMERA_FREE : rig->roles[c];
        rigcal_transform *const camera = &rig->cams_from_rig[c];
        parts->slot[c] = 1;
        if (role == RIGCAL_CAMERA_PRIOR) {
            *camera = rig->priors[c].cam_from_rig;
        } else if (role == RIGCAL_CAMERA_HELD) {
            const rigcal_status status = rc_check_transform(camera);
            if (status != RIGCAL_OK) {
                return status;
            }
        } else {
            rc_transform_identity(camera); /* the first of a group; others: for now */
            parts->slot[c] = (parts->column[c] < 0) ? 1 : 0;
        }
    }
    return RIGCAL_OK;
}

static rigcal_status start(const rigcal_rig *rig, const rc_rig_parts *parts)
{
    candidate *const best = (candidate *)(void *)parts->W;
    int is_more = 1;
    rigcal_status status = begin(rig, parts);
    while (status == RIGCAL_OK && is_more) {
        is_more = 0;
        for (size_t c = 0; c < rig->n_cameras; c++) {
            best[c].information = 0;
        }
        status = look_around(best, rig, parts);
        for (size_t c = 0; c < rig->n_cameras && status == RIGCAL_OK; c++) {
            if (best[c].information > 0) {
                rig->cams_from_rig[c] = best[c].cam_from_rig;
                parts->slot[c] = 1;
                is_more = 1;
            }
        }
    }
    return status;
}

rigcal_status rigcal_rig_join(rigcal_rig *rig, int32_t *at_fault)
{
    rigcal_rig_solver s;
    rc_rig_parts parts;
    if (at_fault != NULL) {
        *at_fault = -1;
    }
    rigcal_status status = rc_rig_check(rig);
    if (status == RIGCAL_OK && rig->view_poses == NULL && rig->view_pose_source == NULL) {
        status = RIGCAL_ERR_NULL;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_rig_begin(&s, rig, 1);
    while (s.phase != RC_RIG_DONE && s.phase != RC_RIG_CHECKED) {
        rc_rig_step(&s);
    }
    if (s.phase == RC_RIG_CHECKED) {
        rc_rig_parts_of(&parts, rig, s.n);
        status = start(rig, &parts);
        if (status != RIGCAL_OK) {
            return status;
        }
    }
    while (s.phase != RC_RIG_DONE) {
        rc_rig_step(&s);
    }
    rc_rig_forget(rig);
    if (at_fault != NULL) {
        *at_fault = s.at_fault;
    }
    status = s.search.status;
    return (status == RIGCAL_OK && s.is_disconnected) ? RIGCAL_DISCONNECTED : status;
}
