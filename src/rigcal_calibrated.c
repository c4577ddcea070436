#include "rc_calibrated.h"
#include "rc_joint.h"

size_t rigcal_calibrated_size(size_t n_free)
{
    return RIGCAL_CALIBRATED_SIZE(n_free);
}

/* ---- a calibrated rig ---------------------------------------------------- */

rigcal_status rc_calibrated_numbers(const rigcal_real numbers[4])
{
    if (!rc_all_finite(numbers, 4)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    for (int i = 0; i < 4; i++) {
        if (!(numbers[i] >= 0)) {
            return RIGCAL_ERR_RANGE;
        }
    }
    return (numbers[0] > 0) ? RIGCAL_OK : RIGCAL_ERR_STATE;
}

/* Checks groups, roles and the number of free cameras. */
static rigcal_status check_cameras(size_t *n_free, const rigcal_calibrated_rig *rig)
{
    int32_t groups = 0;
    *n_free = 0;
    for (size_t c = 0; c < rig->n_cameras; c++) {
        if (rig->held[c] > 1 || rig->group[c] < 0 || rig->group[c] > groups) {
            return RIGCAL_ERR_RANGE;
        }
        groups += rig->group[c] == groups;
        *n_free += rig->held[c] == 0;
    }
    if (*n_free > RIGCAL_STORE_FREE_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    return (rigcal_calibrated_size(*n_free) > rig->Sigma_capacity) ? RIGCAL_ERR_CAPACITY
                                                                   : RIGCAL_OK;
}

rigcal_status rc_calibrated_check(size_t *n_free, const rigcal_calibrated_rig *rig)
{
    if (rig == NULL || rig->cameras == NULL || rig->group == NULL || rig->held == NULL ||
        rig->Sigma == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (rig->n_cameras < 1) {
        return RIGCAL_ERR_TOO_FEW;
    }
    if (rig->n_cameras > RIGCAL_STORE_CAMERAS_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    if (rig->n_cameras > rig->capacity) {
        return RIGCAL_ERR_CAPACITY;
    }
    const rigcal_real numbers[] = {rig->sigma_px, rig->F, rig->freedom_between,
                                   rig->freedom_within};
    const rigcal_status status = rc_calibrated_numbers(numbers);
    return (status == RIGCAL_OK) ? check_cameras(n_free, rig) : status;
}

rigcal_real rc_calibrated_first(const rigcal_calibrated_rig *rig, size_t camera)
{
    rigcal_real first = 0;
    for (size_t c = 0; c < camera; c++) {
        first += (rig->held[c] == 0) ? 6 : 0;
    }
    return (rig->held[camera] == 0) ? first : -1;
}

static rigcal_status check_pair(const rigcal_calibrated_rig *rig, size_t a, size_t b)
{
    size_t n_free;
    const rigcal_status status = rc_calibrated_check(&n_free, rig);
    if (status == RIGCAL_OK && (a >= rig->n_cameras || b >= rig->n_cameras)) {
        return RIGCAL_ERR_RANGE;
    }
    return status;
}

rigcal_status rigcal_calibrated_covariance(rigcal_real Sigma[36],
                                           const rigcal_calibrated_rig *rig, size_t a,
                                           size_t b)
{
    rigcal_real block[36];
    const rigcal_status status = (Sigma == NULL) ? RIGCAL_ERR_NULL : check_pair(rig, a, b);
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_joint_block(block, rig->Sigma, rc_calibrated_first(rig, a),
                   rc_calibrated_first(rig, b));
    if (!rc_all_finite(block, 36)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    for (int k = 0; k < 36; k++) {
        Sigma[k] = block[k];
    }
    return RIGCAL_OK;
}

rigcal_status rigcal_calibrated_pair(rigcal_transform *b_from_a, rigcal_real Sigma[36],
                                     const rigcal_calibrated_rig *rig, size_t a, size_t b)
{
    rigcal_transform pair;
    rigcal_real found[36];
    rigcal_status status =
        (b_from_a == NULL || Sigma == NULL) ? RIGCAL_ERR_NULL : check_pair(rig, a, b);
    if (status == RIGCAL_OK && rig->group[a] != rig->group[b]) {
        status = RIGCAL_DISCONNECTED;
    }
    if (status == RIGCAL_OK) {
        status = rc_check_transform(&rig->cameras[a].cam_from_rig);
    }
    if (status == RIGCAL_OK) {
        status = rc_check_transform(&rig->cameras[b].cam_from_rig);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_joint_pair(&pair, found, &rig->cameras[a].cam_from_rig,
                  &rig->cameras[b].cam_from_rig, rig->Sigma, rc_calibrated_first(rig, a),
                  rc_calibrated_first(rig, b), 1);
    if (!rc_all_finite(found, 36)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    *b_from_a = pair;
    for (int k = 0; k < 36; k++) {
        Sigma[k] = found[k];
    }
    return RIGCAL_OK;
}

/* ---- from an adjusted rig ------------------------------------------------ */

/* Copies an adjusted rig, after all checks. The covariance is in rig->work. */
static void copy_rig(rigcal_calibrated_rig *out, const rigcal_rig *rig,
                     const rc_rig_parts *parts, rigcal_real scale)
{
    size_t first = 0;
    for (size_t c = 0; c < rig->n_cameras; c++) {
        rigcal_mounted_camera *const m = &out->cameras[c];
        out->held[c] = (parts->column[c] >= 0) ? 0 : 1;
        out->group[c] = rig->group[c];
        m->cam_from_rig = rig->cams_from_rig[c];
        m->has_Sigma = 1;
        first += out->held[c] ? 0 : 6;
    }
    for (size_t k = 0; k < first * (first + 1) / 2; k++) {
        out->Sigma[k] = scale * parts->S[k];
    }
    if (rig->considered != NULL) {
        rig->considered->by->joint(out->Sigma, rig);
    }
    for (size_t c = 0; c < rig->n_cameras; c++) {
        rc_joint_block(out->cameras[c].Sigma, out->Sigma, parts->column[c],
                       parts->column[c]);
    }
    out->n_cameras = rig->n_cameras;
}

rigcal_status rigcal_calibrated_take(rigcal_calibrated_rig *out, const rigcal_rig *rig,
                                     const rigcal_rig_fit *fit, rigcal_real sigma_px)
{
    rigcal_real Sigma[36];
    rc_rig_parts parts;
    size_t n_free = 0;
    if (out == NULL || out->cameras == NULL || out->group == NULL || out->held == NULL ||
        out->Sigma == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = rigcal_rig_covariance(Sigma, rig, sigma_px, 0);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!(sigma_px > 0) || rig->n_cameras > RIGCAL_STORE_CAMERAS_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    rc_rig_parts_of(&parts, rig, 0);
    for (size_t c = 0; c < rig->n_cameras; c++) {
        n_free += (parts.column[c] >= 0) ? 1 : 0;
    }
    if (n_free > RIGCAL_STORE_FREE_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    if (rig->n_cameras > out->capacity ||
        rigcal_calibrated_size(n_free) > out->Sigma_capacity) {
        return RIGCAL_ERR_CAPACITY;
    }
    copy_rig(out, rig, &parts, sigma_px * sigma_px);
    out->sigma_px = sigma_px;
    out->F = (fit != NULL) ? fit->F : 0;
    out->freedom_between = (fit != NULL) ? fit->freedom_between : 0;
    out->freedom_within = (fit != NULL) ? fit->freedom_within : 0;
    return RIGCAL_OK;
}
