#include "rc_views.h"

size_t rigcal_rig_work(size_t n_free, size_t n_cameras, size_t n_placements)
{
    return RIGCAL_RIG_WORK(n_free, n_cameras, n_placements);
}

/* ---- what the caller gives ----------------------------------------------- */

void rc_rig_parts_of(rc_rig_parts *parts, const rigcal_rig *rig, size_t n_unknowns)
{
    const size_t n = n_unknowns;
    parts->count = rig->work;
    parts->column = parts->count + rig->n_placements;
    parts->slot = parts->column + rig->n_cameras;
    parts->W = parts->slot + rig->n_cameras;
    parts->saved = (rigcal_transform *)(void *)(parts->W + 36 * rig->n_cameras);
    parts->S = (rigcal_real *)(parts->saved + rig->n_cameras + rig->n_placements);
    parts->g = parts->S + n * (n + 1) / 2;
    parts->d = parts->g + n;
}

void rc_rig_forget(const rigcal_rig *rig)
{
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, rig, 0);
    parts.column[0] = -2;
}

int rc_rig_is_adjusted(rc_rig_parts *parts, const rigcal_rig *rig)
{
    size_t n = 0, n_free = 0;
    rc_rig_parts_of(parts, rig, 0);
    for (size_t c = 0;; c++) { /* the unknowns before n have a variance */
        if (rig->work_capacity <
                rigcal_rig_work(n_free, rig->n_cameras, rig->n_placements) ||
            (n > 0 && !(parts->S[rc_packed_at(n - 6, n - 6)] > 0))) {
            return 0;
        }
        if (c == rig->n_cameras) {
            return 1;
        }
        if (RC_FABS(parts->column[c] - (rigcal_real)n) <= 0) {
            n += 6;
            n_free++;
        } else if (!(RC_FABS(parts->column[c] + 1) <= 0)) {
            return 0;
        }
    }
}

rigcal_status rc_rig_numbers(const rigcal_rig *rig, int32_t camera, int32_t placement)
{
    return (camera < 0 || (size_t)camera >= rig->n_cameras || placement < 0 ||
            (size_t)placement >= rig->n_placements)
               ? RIGCAL_ERR_RANGE
               : RIGCAL_OK;
}

rigcal_status rc_rig_view_at(rigcal_rig_view *out, const rigcal_rig *rig, size_t index)
{
    rigcal_status status = RIGCAL_OK;
    if (rig->views == NULL) {
        status = rig->view_source(out, index, rig->context);
    } else {
        *out = rig->views[index];
    }
    return (status != RIGCAL_OK) ? status
                                 : rc_rig_numbers(rig, out->camera, out->placement);
}

rigcal_status rc_rig_pose_at(rigcal_view_pose *out, const rigcal_rig *rig, size_t index)
{
    rigcal_status status = RIGCAL_OK;
    if (rig->view_poses == NULL) {
        status = rig->view_pose_source(out, index, rig->context);
    } else {
        *out = rig->view_poses[index];
    }
    return (status != RIGCAL_OK) ? status
                                 : rc_rig_numbers(rig, out->camera, out->placement);
}

void rc_rig_chain(rc_chain *chain, const rigcal_rig *rig, int32_t camera, size_t placement,
                  size_t view)
{
    rigcal_transform seen = rig->rig_from_placements[placement];
    if (rig->clocks != NULL) {
        rig->clocks->calls->place(&seen, rig, camera, placement, view);
    }
    rc_chain_of(chain, &rig->cams_from_rig[camera], &seen);
}

size_t rc_rig_views_of(const rc_rig_parts *parts, size_t placement)
{
    return (size_t)RC_FABS(parts->count[placement]);
}

int rc_rig_is_left_out(const rigcal_rig *rig, size_t view)
{
    return rig->left_out != NULL && rig->left_out[view] != 0;
}

int rc_rig_is_held(const rigcal_rig *rig, size_t camera)
{
    return rig->roles != NULL && rig->roles[camera] == RIGCAL_CAMERA_HELD;
}

int rc_rig_has_prior(const rigcal_rig *rig, size_t camera)
{
    return rig->roles != NULL && rig->roles[camera] == RIGCAL_CAMERA_PRIOR;
}

rigcal_status rigcal_priors_information(rigcal_real information[],
                                        const rigcal_real Sigma[], size_t n_priors)
{
    if (information == NULL || Sigma == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (n_priors < 1) {
        return RIGCAL_ERR_TOO_FEW;
    }
    if (n_priors > RIGCAL_STORE_FREE_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    const size_t size = rigcal_calibrated_size(n_priors);
    if (!rc_all_finite(Sigma, (int)size)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    for (size_t k = 0; k < size; k++) {
        information[k] = Sigma[k];
    }
    if (!rc_packed_invert(information, 6 * n_priors)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    return rc_all_finite(information, (int)size) ? RIGCAL_OK : RIGCAL_ERR_DEGENERATE;
}

/* Number of cameras with a prior before this one. */
static size_t priors_before(const rigcal_rig *rig, size_t camera)
{
    size_t n = 0;
    for (size_t c = 0; c < camera; c++) {
        n += (size_t)rc_rig_has_prior(rig, c);
    }
    return n;
}

/* The equations of a camera's prior from the information of all together. */
static void joint_prior(rigcal_real g[6], rigcal_real H[21], const rc_rig_parts *parts,
                        const rigcal_rig *rig, size_t camera)
{
    const rigcal_real variance = rig->sigma_px * rig->sigma_px;
    const size_t row = 6 * priors_before(rig, camera);
    size_t column = 0;
    rigcal_real own[36];
    rc_clear(g, 6);
    for (size_t c = 0; c < rig->n_cameras; c++) {
        if (!rc_rig_has_prior(rig, c)) {
            continue;
        }
        rigcal_real d[6];
        rc_deviation(d, &rig->priors[c].cam_from_rig, &rig->cams_from_rig[c]);
        for (size_t k = 0; k < 36; k++) {
            const size_t i = k / 6, j = k % 6, at = row + i, across = column + j;
            const rigcal_real element =
                variance * rig->priors_information[rc_packed_of(at, across)];
            g[i] += element * d[j];
            if (c == camera) {
                own[k] = element;
            } else if (c < camera && parts != NULL) {
                parts->S[rc_packed_at((size_t)parts->column[camera] + i,
                                      (size_t)parts->column[c] + j)] += element;
            }
        }
        column += 6;
    }
    rc_sym6_pack(H, own);
}

/* The same from the camera's own covariance. Returns 0 if it is not one. */
static int own_prior(rigcal_real g[6], rigcal_real H[21], const rigcal_rig *rig,
                     size_t camera, const rigcal_real d[6])
{
    rigcal_real full[36];
    rc_sym6_pack(H, rig->priors[camera].Sigma);
    if (!rc_sym6_invert(full, H)) {
        return 0;
    }
    for (int k = 0; k < 36; k++) {
        full[k] *= rig->sigma_px * rig->sigma_px;
    }
    rc_sym6_pack(H, full);
    rc_sym6_mul(g, H, d);
    return 1;
}

rigcal_status rc_rig_prior(rigcal_real *sum, rigcal_real g[6], rigcal_real H[21],
                           const rc_rig_parts *parts, const rigcal_rig *rig, size_t camera)
{
    rigcal_real d[6];
    rc_deviation(d, &rig->priors[camera].cam_from_rig, &rig->cams_from_rig[camera]);
    if (rig->priors_information != NULL) {
        joint_prior(g, H, parts, rig, camera);
    } else if (!own_prior(g, H, rig, camera, d)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    *sum = rc_vec6_dot(g, d);
    return RIGCAL_OK;
}

rigcal_status rc_rig_check(const rigcal_rig *rig)
{
    if (rig == NULL || rig->cams_from_rig == NULL || rig->rig_from_placements == NULL ||
        rig->group == NULL || rig->work == NULL ||
        (rig->clocks != NULL && rig->clocks->calls == NULL)) {
        return RIGCAL_ERR_NULL;
    }
    if (rig->n_cameras < 1 || rig->n_views < 1) {
        return RIGCAL_ERR_TOO_FEW;
    }
    if (rig->n_cameras > RC_COUNT_MAX || rig->n_placements > RC_COUNT_MAX ||
        rig->n_views > RC_COUNT_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    return rc_check_noise(&rig->sigma_px);
}

rigcal_status rc_check_step(const int32_t *phase, int32_t budget)
{
    if (phase == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (*phase == 0) {
        return RIGCAL_ERR_STATE;
    }
    return (budget < 1) ? RIGCAL_ERR_RANGE : RIGCAL_OK;
}

/* ---- the pose of a view by itself ----------------------------------------- */

rigcal_status rc_check_pose(const rigcal_view_pose *pose)
{
    rc_sym6_factor L;
    rigcal_status status = rc_check_transform(&pose->cam_from_target);
    if (status == RIGCAL_OK) {
        status = rc_check_numbers(pose->information, 21, RC_MAX);
    }
    if (status == RIGCAL_OK) {
        status = rc_check_numbers(&pose->sse, 1, RC_MAX);
    }
    if (status == RIGCAL_OK && (pose->sse < 0 || pose->n > RC_COUNT_MAX)) {
        status = RIGCAL_ERR_RANGE;
    }
    return (status == RIGCAL_OK && !rc_sym6_factor_of(&L, pose->information, 0))
               ? RIGCAL_ERR_DEGENERATE
               : status;
}

rigcal_real rc_view_information(const rigcal_view_pose *pose)
{
    rigcal_real trace = 0;
    return rc_sym6_inverse_trace(&trace, pose->information) ? 1 / trace : 0;
}

rigcal_real rc_information_of_both(rigcal_real a, rigcal_real b)
{
    const rigcal_real less = rc_min(a, b), more = rc_max(a, b);
    return (less > 0) ? less / (1 + less / more) : 0;
}

/* ---- groups of cameras that share placements ----------------------------- */

/* The first camera of the group of camera c, as far as groups are joined. */
static int32_t root_of(const rigcal_rig *rig, int32_t c)
{
    while (rig->group[c] != c) {
        c = rig->group[c];
    }
    return c;
}

/* Cameras a and b saw the same placement: joins their groups. The group keeps the lower of
 * the two first cameras. */
static void connect(rigcal_rig *rig, int32_t a, int32_t b)
{
    const int32_t first = root_of(rig, a), second = root_of(rig, b);
    rig->group[(first > second) ? first : second] = (first > second) ? second : first;
    rig->group[a] = rig->group[b] = (first > second) ? second : first;
}

/* Replaces the first camera of each group by the number of the group. The first camera
 * comes before the others, so its number is known when theirs is needed. */
static int32_t number_groups(rigcal_rig *rig)
{
    int32_t groups = 0;
    for (size_t c = 0; c < rig->n_cameras; c++) {
        const int32_t on = rig->group[c];
        rig->group[c] = ((size_t)on == c) ? groups++ : rig->group[on];
    }
    return groups;
}

/* ---- checks -------------------------------------------------------------- */

rigcal_status rc_rig_points(rigcal_points *points, const rigcal_rig_view *view)
{
    rigcal_real uv_middle[2];
    int32_t at;
    rigcal_status status = rc_check_view(&view->view);
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_points_of(points, &view->view, NULL);
    status = rc_points_survey(points, uv_middle, &at);
    points->origin[0] = points->origin[1] = points->origin[2] = 0;
    return (status == RIGCAL_ERR_COINCIDENT || status == RIGCAL_ERR_PRECISION) ? RIGCAL_OK
                                                                               : status;
}

rigcal_real rc_rig_weight(const rigcal_points *points,
                          const rigcal_transform *cam_from_target, size_t i, int32_t loss,
                          rigcal_real sigma_px)
{
    const rigcal_real weight = rc_points_weight(points, i);
    if (loss == 0) {
        return weight;
    }
    const rigcal_real from =
        (loss == RIGCAL_LOSS_HUBER) ? RC_HUBER_FROM : RC_TRUNCATED_FROM;
    const rigcal_real limit = from * sigma_px;
    const rigcal_real error2 = rc_points_error2(points, cam_from_target, i);
    if (error2 <= limit * limit) {
        return weight;
    }
    return (loss == RIGCAL_LOSS_HUBER) ? weight * limit / RC_SQRT(error2) : 0;
}

/* Checks the rows of a camera in the joint information. */
static rigcal_status check_information(const rigcal_rig *rig, size_t camera)
{
    const size_t row = 6 * priors_before(rig, camera);
    const size_t begin = rc_packed_at(row, 0), end = rc_packed_at(row + 6, 0);
    return rc_check_numbers(&rig->priors_information[begin], (int)(end - begin), RC_MAX);
}

rigcal_status rc_rig_check_camera(const rigcal_rig *rig, size_t c)
{
    if (rig->roles == NULL || rig->roles[c] < RIGCAL_CAMERA_PRIOR) {
        return RIGCAL_OK;
    }
    if (rig->roles[c] > RIGCAL_CAMERA_PRIOR) {
        return RIGCAL_ERR_RANGE;
    }
    if (rig->priors == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = rc_check_transform(&rig->priors[c].cam_from_rig);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!(rig->sigma_px > 0)) {
        return RIGCAL_ERR_RANGE;
    }
    return (rig->priors_information != NULL)
               ? check_information(rig, c)
               : rc_check_numbers(rig->priors[c].Sigma, 36, RC_MAX);
}

/* Numbers the unknowns of the cameras. If no camera of a group is held or has a prior, its
 * first one is held. */
static rigcal_status number_unknowns(rigcal_rig_solver *s)
{
    rigcal_rig *const rig = s->rig;
    rc_rig_parts parts;
    size_t n = 0;
    s->is_disconnected = number_groups(rig) > 1;
    rc_rig_parts_of(&parts, rig, 0);
    rigcal_real *const is_fixed = parts.slot; /* of each group */
    rc_clear(is_fixed, rig->n_cameras);
    for (size_t c = 0; c < rig->n_cameras; c++) {
        if (rig->roles != NULL && rig->roles[c] != RIGCAL_CAMERA_FREE) {
            is_fixed[rig->group[c]] = 1;
        }
    }
    for (size_t c = 0; c < rig->n_cameras; c++) {
        if (rc_rig_is_held(rig, c) || !(is_fixed[rig->group[c]] > 0)) {
            is_fixed[rig->group[c]] = 1;
            parts.column[c] = -1;
        } else {
            parts.column[c] = (rigcal_real)n;
            n += 6;
            s->n_free += rc_rig_has_prior(rig, c) ? 0 : 1;
        }
    }
    s->n = n;
    if (s->n_used == 0) {
        return RIGCAL_ERR_TOO_FEW;
    }
    return (rigcal_rig_work(n / 6, rig->n_cameras, rig->n_placements) > rig->work_capacity)
               ? RIGCAL_ERR_CAPACITY
               : RIGCAL_OK;
}

/* Checks view s->view, and joins the cameras that it connects. */
static rigcal_status check_next(rigcal_rig_solver *s, const rc_rig_parts *parts)
{
    int32_t camera = -1, placement = -1;
    rigcal_status status = s->given->check(&camera, &placement, s);
    if (status == RIGCAL_OK && !s->is_join) {
        status = rc_check_transform(&s->rig->rig_from_placements[placement]);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    if ((size_t)placement < s->placement) {
        return RIGCAL_ERR_UNSORTED;
    }
    if (parts->slot[camera] > (rigcal_real)placement) { /* the placement that it saw last,
                                                           plus 1 */
        return RIGCAL_ERR_TWICE;
    }
    s->placement = (size_t)placement;
    parts->slot[camera] = (rigcal_real)placement + 1;
    rigcal_real *const count = &parts->count[placement];
    if (rc_rig_is_left_out(s->rig, s->view)) {
        *count += (*count > 0) ? 1 : -1;
        return RIGCAL_OK;
    }
    if (!(*count > 0)) {
        *count = -*count;
        s->n_seen++;
        s->first = (size_t)camera; /* the placement's first camera */
    }
    *count += 1;
    s->n_used++;
    connect(s->rig, (int32_t)s->first, camera);
    return RIGCAL_OK;
}

rigcal_status rc_views_begin(rigcal_rig_solver *s)
{
    rigcal_rig *const rig = s->rig;
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, rig, 0);
    rc_clear(parts.count, rig->n_placements);
    rc_clear(parts.slot, rig->n_cameras);
    for (size_t c = 0; c < rig->n_cameras; c++) {
        const rigcal_status status = rc_rig_check_camera(rig, c);
        rig->group[c] = (int32_t)c;
        if (status != RIGCAL_OK) {
            return status;
        }
    }
    return RIGCAL_OK;
}

rigcal_status rc_views_step(rigcal_rig_solver *s)
{
    rc_rig_parts parts;
    rc_rig_parts_of(&parts, s->rig, 0);
    const rigcal_status status = check_next(s, &parts);
    if (status != RIGCAL_OK) {
        return status;
    }
    return (++s->view == s->rig->n_views) ? number_unknowns(s) : RIGCAL_RUNNING;
}
