#include "rc_graph.h"

/* ---- links --------------------------------------------------------------- */

/* Checks view s->view. */
static rigcal_status check_view(int32_t *camera, int32_t *placement, rigcal_rig_solver *s)
{
    rigcal_view_pose pose;
    const rigcal_status status = rc_rig_pose_at(&pose, s->rig, s->view);
    if (status != RIGCAL_OK) {
        return status;
    }
    *camera = pose.camera;
    *placement = pose.placement;
    return rc_rig_is_left_out(s->rig, s->view) ? RIGCAL_OK : rc_check_pose(&pose);
}

const struct rigcal_rig_given rc_given_poses = {check_view, NULL, NULL, NULL, 1};

/* Checks the poses of the views, and writes the groups. */
static rigcal_status check(int32_t *at_fault, rigcal_rig *rig)
{
    rigcal_rig_solver s = {0};
    rigcal_status status = rc_rig_check(rig);
    if (status == RIGCAL_OK && rig->view_poses == NULL && rig->view_pose_source == NULL) {
        status = RIGCAL_ERR_NULL;
    }
    if (status == RIGCAL_OK &&
        rigcal_rig_work(0, rig->n_cameras, rig->n_placements) > rig->work_capacity) {
        status = RIGCAL_ERR_CAPACITY;
    }
    if (status == RIGCAL_OK) {
        s.rig = rig;
        s.is_join = 1;
        s.given = &rc_given_poses;
        status = rc_views_begin(&s);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    do {
        status = rc_views_step(&s);
    } while (status == RIGCAL_RUNNING);
    *at_fault = (status < 0 && s.view < rig->n_views) ? (int32_t)s.view : -1;
    return status;
}

/* Adds the `count` views of a placement, from `first` on, to the links. */
static rigcal_status add_links(rigcal_link links[], const rigcal_rig *rig,
                               const rc_rig_parts *parts, size_t first, size_t count)
{
    rigcal_real *const information = parts->W;
    for (size_t i = 0; i < count; i++) {
        parts->slot[i] = -1;
        if (rc_rig_is_left_out(rig, first + i)) {
            continue;
        }
        rigcal_view_pose pose;
        const rigcal_status status = rc_rig_pose_at(&pose, rig, first + i);
        if (status != RIGCAL_OK) {
            return status;
        }
        information[i] = rc_view_information(&pose);
        parts->slot[i] = (rigcal_real)pose.camera;
        for (size_t j = 0; j < i; j++) {
            if (parts->slot[j] < 0) {
                continue;
            }
            const int32_t other = (int32_t)parts->slot[j];
            if (other == pose.camera) { /* another than before, of a source */
                return RIGCAL_ERR_TWICE;
            }
            rigcal_link *const link =
                &links[(other < pose.camera) ? RIGCAL_LINK(other, pose.camera)
                                             : RIGCAL_LINK(pose.camera, other)];
            link->n_shared++;
            link->information += rc_information_of_both(information[i], information[j]);
        }
    }
    return RIGCAL_OK;
}

static int32_t groups_of(const rigcal_rig *rig)
{
    int32_t n = 0;
    for (size_t c = 0; c < rig->n_cameras; c++) {
        n = (rig->group[c] >= n) ? rig->group[c] + 1 : n;
    }
    return n;
}

rigcal_status rigcal_rig_links(rigcal_link links[], size_t capacity, int32_t *n_groups,
                               int32_t *at_fault, rigcal_rig *rig)
{
    rc_rig_parts parts;
    size_t first = 0;
    int32_t at = -1;
    rigcal_status status =
        (links == NULL || n_groups == NULL) ? RIGCAL_ERR_NULL : check(&at, rig);
    if (at_fault != NULL) {
        *at_fault = at;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    if (capacity < RIGCAL_LINKS(rig->n_cameras)) {
        return RIGCAL_ERR_CAPACITY;
    }
    for (size_t k = 0; k < RIGCAL_LINKS(rig->n_cameras); k++) {
        links[k] = (rigcal_link){0, 0};
    }
    rc_rig_parts_of(&parts, rig, 0);
    for (size_t f = 0; f < rig->n_placements && status == RIGCAL_OK; f++) {
        const size_t count = rc_rig_views_of(&parts, f);
        status = add_links(links, rig, &parts, first, count);
        first += count;
    }
    rc_rig_forget(rig);
    *n_groups = groups_of(rig);
    return (status == RIGCAL_OK && *n_groups > 1) ? RIGCAL_DISCONNECTED : status;
}

/* ---- advice -------------------------------------------------------------- */

/* The information that a camera shares with all others. */
static rigcal_real total_of(const rigcal_link links[], size_t n_cameras, size_t camera)
{
    rigcal_real sum = 0;
    for (size_t d = 0; d < n_cameras; d++) {
        if (d != camera) {
            sum += links[(d < camera) ? RIGCAL_LINK(d, camera) : RIGCAL_LINK(camera, d)]
                       .information;
        }
    }
    return sum;
}

/* The camera of a group that shares most information; *most is its total. */
static int32_t best_of(rigcal_real *most, const rigcal_link links[], const rigcal_rig *rig,
                       int32_t group)
{
    int32_t best = -1;
    *most = 0;
    for (size_t c = 0; c < rig->n_cameras; c++) {
        if (rig->group[c] == group) {
            const rigcal_real total = total_of(links, rig->n_cameras, c);
            if (best < 0 || total > *most) {
                *most = total;
                best = (int32_t)c;
            }
        }
    }
    return best;
}

rigcal_status rigcal_rig_advise(rigcal_advice advice[], size_t capacity, size_t *n,
                                const rigcal_link links[], const rigcal_rig *rig)
{
    const rigcal_status status = (advice == NULL || n == NULL || links == NULL)
                                     ? RIGCAL_ERR_NULL
                                     : rc_rig_check(rig);
    if (status != RIGCAL_OK) {
        return status;
    }
    for (size_t c = 0; c < rig->n_cameras; c++) {
        if (rig->group[c] < 0 || (size_t)rig->group[c] >= rig->n_cameras) {
            return RIGCAL_ERR_RANGE;
        }
    }
    const int32_t groups = groups_of(rig);
    rigcal_real most = 0, total;
    int32_t hub = -1, hub_group = 0;
    const size_t lines = (size_t)groups - 1;
    if (capacity < lines) {
        return RIGCAL_ERR_CAPACITY;
    }
    *n = lines;
    for (int32_t g = 0; g < groups; g++) {
        const int32_t best = best_of(&total, links, rig, g);
        if (hub < 0 || total > most) {
            most = total;
            hub = best;
            hub_group = g;
        }
    }
    for (int32_t g = 0, line = 0; g < groups; g++) {
        if (g != hub_group) {
            advice[line++] = (rigcal_advice){hub, best_of(&total, links, rig, g)};
        }
    }
    return RIGCAL_OK;
}

/* ---- the weakest link ---------------------------------------------------- */

/* Finds the camera to which `camera` is surest. found->other is -1 if there is none. */
static rigcal_status surest(rigcal_weakest *found, const rigcal_rig *rig,
                            rigcal_real sigma_px, size_t camera)
{
    *found = (rigcal_weakest){(int32_t)camera, -1, 0, 0};
    for (size_t d = 0; d < rig->n_cameras; d++) {
        rigcal_transform between;
        rigcal_real S[36];
        if (d == camera || rig->group[d] != rig->group[camera]) {
            continue;
        }
        const rigcal_status status = rigcal_rig_pair(&between, S, rig, sigma_px, camera, d);
        if (status != RIGCAL_OK) {
            return status;
        }
        const rigcal_real rotation = RC_SQRT(rc_max(0, S[0] + S[7] + S[14]));
        if (found->other < 0 || rotation < found->rotation) {
            found->other = (int32_t)d;
            found->rotation = rotation;
            found->translation = RC_SQRT(rc_max(0, S[21] + S[28] + S[35]));
        }
    }
    return RIGCAL_OK;
}

rigcal_status rigcal_rig_weakest(rigcal_weakest *weakest, const rigcal_rig *rig,
                                 rigcal_real sigma_px)
{
    rigcal_real S[36];
    rigcal_status status =
        (weakest == NULL) ? RIGCAL_ERR_NULL : rigcal_rig_covariance(S, rig, sigma_px, 0);
    if (status != RIGCAL_OK) {
        return status;
    }
    rigcal_weakest least_sure = {-1, -1, -1, 0};
    for (size_t c = 0; c < rig->n_cameras; c++) {
        rigcal_weakest found;
        status = surest(&found, rig, sigma_px, c);
        if (status != RIGCAL_OK) {
            return status;
        }
        if (found.other >= 0 && found.rotation > least_sure.rotation) {
            least_sure = found;
        }
    }
    if (least_sure.other < 0) {
        return RIGCAL_ERR_TOO_FEW;
    }
    *weakest = least_sure;
    return RIGCAL_OK;
}
