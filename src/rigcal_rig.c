#include "rc_rig.h"

enum { KARCHER_MAX = 20 };

/* ---- the mean of transforms ---------------------------------------------- */

static rigcal_real weight_of(const rigcal_real weight[], size_t i)
{
    return (weight == NULL) ? 1 : weight[i];
}

/* Rotation vector from mean to R_i, in the frame of a. */
static void deviation(rigcal_real w[3], const rigcal_real mean[9],
                      const rigcal_real R_i[9])
{
    rigcal_real mean_t[9], R_i_t[9], between[9];
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++) {
            mean_t[3 * r + c] = mean[3 * c + r];
            R_i_t[3 * r + c] = R_i[3 * c + r];
        }
    }
    rc_mat3_mul_t(between, mean_t, R_i_t); /* mean^T R_i */
    rc_vector_from_rotation(w, between);
}

/* One step to the Karcher mean: turn by the mean deviation. Returns its angle. */
static rigcal_real karcher_step(rigcal_real mean[9],
                                const rigcal_transform transforms[],
                                const rigcal_real weight[], size_t n,
                                rigcal_real total)
{
    rigcal_real step[3] = {0, 0, 0}, turn[9], turned[9];
    for (size_t i = 0; i < n; i++) {
        rigcal_real w[3];
        deviation(w, mean, transforms[i].R);
        rc_vec3_add_scaled(step, weight_of(weight, i) / total, w);
    }
    rc_rotation_from_vector(turn, step);
    rc_mat3_mul(turned, mean, turn);
    for (int k = 0; k < 9; k++) {
        mean[k] = turned[k];
    }
    return rc_vec3_norm(step);
}

static rigcal_status mean_rotation(rigcal_real R[9],
                                   const rigcal_transform transforms[],
                                   const rigcal_real weight[], size_t n,
                                   rigcal_real total)
{
    rigcal_real sum[9] = {0}, mean[9];
    for (size_t i = 0; i < n; i++) {
        for (int k = 0; k < 9; k++) {
            sum[k] += weight_of(weight, i) / total * transforms[i].R[k];
        }
    }
    if (!rc_rotation_nearest(mean, sum)) {
        return RIGCAL_ERR_ROTATION;
    }
    for (int i = 0; i < KARCHER_MAX; i++) {
        if (!(karcher_step(mean, transforms, weight, n, total) > 4 * RC_EPS)) {
            break;
        }
    }
    return rc_rotation_nearest(R, mean) ? RIGCAL_OK : RIGCAL_ERR_ROTATION;
}

static rigcal_status transform_mean(rigcal_transform *mean, rigcal_real *sigma_rad,
                                    rigcal_real *sigma_t,
                                    const rigcal_transform transforms[],
                                    const rigcal_real weight[], size_t n)
{
    rigcal_real total = 0, angles = 0, lengths = 0;
    rigcal_transform found = {{0}, {0}};
    for (size_t i = 0; i < n; i++) {
        total += weight_of(weight, i);
    }
    const rigcal_status status =
        mean_rotation(found.R, transforms, weight, n, total);
    if (status != RIGCAL_OK) {
        return status;
    }
    for (size_t i = 0; i < n; i++) {
        rc_vec3_add_scaled(found.t, weight_of(weight, i) / total,
                           transforms[i].t);
    }
    for (size_t i = 0; i < n; i++) {
        const rigcal_real part = weight_of(weight, i) / total;
        rigcal_real dt[3];
        const rigcal_real angle = rc_rotation_angle(found.R, transforms[i].R);
        rc_vec3_sub(dt, transforms[i].t, found.t);
        angles += part * angle * angle;
        lengths += part * rc_vec3_dot(dt, dt);
    }
    *mean = found;
    if (sigma_rad != NULL) {
        *sigma_rad = RC_SQRT(angles);
    }
    if (sigma_t != NULL) {
        *sigma_t = RC_SQRT(lengths);
    }
    return RIGCAL_OK;
}

static rigcal_status check_weights(const rigcal_real weight[], size_t n)
{
    rigcal_real total = 0;
    for (size_t i = 0; i < n; i++) {
        const rigcal_real w = weight_of(weight, i);
        if (!rc_is_finite(w)) {
            return RIGCAL_ERR_NOT_FINITE;
        }
        if (!(w >= 0 && w <= RC_COORDINATE_MAX)) {
            return RIGCAL_ERR_RANGE;
        }
        total += w;
    }
    return (total > 0) ? RIGCAL_OK : RIGCAL_ERR_RANGE;
}

rigcal_status rigcal_transform_mean(rigcal_transform *mean,
                                    rigcal_real *sigma_rad, rigcal_real *sigma_t,
                                    const rigcal_transform transforms[],
                                    const rigcal_real weight[], size_t n)
{
    if (mean == NULL || transforms == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (n < 1) {
        return RIGCAL_ERR_TOO_FEW;
    }
    rigcal_status status =
        (n > RC_COUNT_MAX) ? RIGCAL_ERR_RANGE : check_weights(weight, n);
    for (size_t i = 0; i < n && status == RIGCAL_OK; i++) {
        status = rc_check_transform(&transforms[i]);
    }
    return (status == RIGCAL_OK) ? transform_mean(mean, sigma_rad, sigma_t,
                                                  transforms, weight, n)
                                 : status;
}

/* ---- joining cameras ----------------------------------------------------- */

/* Cameras, made or in the making, and what they saw. group[c] is -1 until camera c
 * is joined. */
typedef struct {
    const rigcal_transform *cams_from_rig;
    const int32_t *group;
    size_t n_cameras;
    const rigcal_view *views;
    size_t n_views;
    rigcal_transform *work;
    rigcal_real *weight;
} rig;

static rigcal_status check_views(const rigcal_view views[], size_t n_views,
                                 size_t n_cameras)
{
    for (size_t i = 0; i < n_views; i++) {
        const rigcal_view *const v = &views[i];
        const rigcal_status status = rc_check_transform(&v->cam_from_target);
        if (status != RIGCAL_OK) {
            return status;
        }
        if (!rc_is_finite(v->weight)) {
            return RIGCAL_ERR_NOT_FINITE;
        }
        if (!(v->weight > 0 && v->weight <= RC_COORDINATE_MAX) ||
            v->camera < 0 || (size_t)v->camera >= n_cameras ||
            v->placement < 0) {
            return RIGCAL_ERR_RANGE;
        }
    }
    return RIGCAL_OK;
}

/* rig_from_target of one placement: the mean over the cameras of `in_group` that
 * saw it, as work[first] onwards. *total gets their weight.
 * OK, ERR_TOO_FEW (none did), ERR_ROTATION. */
static rigcal_status place(rigcal_transform *rig_from_target, rigcal_real *total,
                           const rig *r, int32_t placement, int32_t in_group,
                           size_t first)
{
    size_t n = first;
    *total = 0;
    for (size_t i = 0; i < r->n_views; i++) {
        const rigcal_view *const v = &r->views[i];
        if (v->placement == placement && r->group[v->camera] == in_group) {
            rigcal_transform rig_from_cam;
            rc_transform_invert(&rig_from_cam, &r->cams_from_rig[v->camera]);
            rc_transform_compose(&r->work[n], &rig_from_cam,
                                 &v->cam_from_target);
            r->weight[n++] = v->weight;
            *total += v->weight;
        }
    }
    return (n == first) ? RIGCAL_ERR_TOO_FEW
                        : transform_mean(rig_from_target, NULL, NULL,
                                         &r->work[first], &r->weight[first],
                                         n - first);
}

/* Weight of what camera c shares with a group: over its views, that of the
 * placements that the group saw too. */
static rigcal_real shared_weight(const rig *r, int32_t camera, int32_t in_group)
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
static rigcal_status join_camera(rigcal_transform *cam_from_rig, const rig *r,
                                 int32_t camera, int32_t in_group)
{
    size_t n = 0;
    for (size_t i = 0; i < r->n_views; i++) {
        const rigcal_view *const v = &r->views[i];
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
    return transform_mean(cam_from_rig, NULL, NULL, r->work, r->weight, n);
}

/* The camera, of those not yet joined, that shares most with the group; -1 when
 * none shares anything. */
static int32_t best_candidate(const rig *r, int32_t in_group)
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
static rigcal_status join_group(rigcal_transform cams_from_rig[], int32_t group[],
                                const rig *r, int32_t first, int32_t in_group)
{
    rigcal_status status = RIGCAL_OK;
    int32_t next = first;
    rc_transform_identity(&cams_from_rig[first]);
    for (size_t i = 0; i < r->n_cameras && next >= 0; i++) {
        group[next] = in_group;
        next = best_candidate(r, in_group);
        if (next >= 0) {
            status = join_camera(&cams_from_rig[next], r, next, in_group);
        }
        if (status != RIGCAL_OK) {
            break;
        }
    }
    return status;
}

static rigcal_status check_rig(const rig *r)
{
    if (r->cams_from_rig == NULL || r->group == NULL || r->work == NULL ||
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

rigcal_status rigcal_rig_join(rigcal_transform cams_from_rig[], int32_t group[],
                              size_t n_cameras, const rigcal_view views[],
                              size_t n_views, rigcal_transform work[],
                              rigcal_real weight[])
{
    const rig r = {cams_from_rig, group, n_cameras, views,
                   n_views,       work,  weight};
    rigcal_status status = check_rig(&r);
    if (status != RIGCAL_OK) {
        return status;
    }
    int32_t groups = 0;
    for (size_t c = 0; c < n_cameras; c++) {
        group[c] = -1;
    }
    for (size_t c = 0; c < n_cameras && status == RIGCAL_OK; c++) {
        if (group[c] < 0) {
            status = join_group(cams_from_rig, group, &r, (int32_t)c, groups);
            groups++;
        }
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    return (groups > 1) ? RIGCAL_DISCONNECTED : RIGCAL_OK;
}

rigcal_status rigcal_rig_place(rigcal_transform *rig_from_target,
                               int32_t placement, int32_t in_group,
                               const rigcal_transform cams_from_rig[],
                               const int32_t group[], size_t n_cameras,
                               const rigcal_view views[], size_t n_views,
                               rigcal_transform work[], rigcal_real weight[])
{
    const rig r = {cams_from_rig, group, n_cameras, views,
                   n_views,       work,  weight};
    rigcal_real total;
    rigcal_status status =
        (rig_from_target == NULL) ? RIGCAL_ERR_NULL : check_rig(&r);
    if (status == RIGCAL_OK && (placement < 0 || in_group < 0)) {
        status = RIGCAL_ERR_RANGE;
    }
    for (size_t c = 0; c < n_cameras && status == RIGCAL_OK; c++) {
        status = rc_check_transform(&cams_from_rig[c]);
    }
    return (status == RIGCAL_OK)
               ? place(rig_from_target, &total, &r, placement, in_group, 0)
               : status;
}

/* ---- Section VI-C -------------------------------------------------------- */

rigcal_status rigcal_measurement_bound(rigcal_real *bound,
                                       const rigcal_transform *b_from_a,
                                       const rigcal_transform *b_from_a_true,
                                       const rigcal_real X_a[3])
{
    if (bound == NULL || b_from_a_true == NULL || X_a == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_transform(b_from_a);
    if (status == RIGCAL_OK) {
        status = rc_check_transform(b_from_a_true);
    }
    if (status == RIGCAL_OK) {
        status = rc_check_point(X_a);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    rigcal_real dt[3];
    const rigcal_real angle = rc_rotation_angle(b_from_a_true->R, b_from_a->R);
    rc_vec3_sub(dt, b_from_a->t, b_from_a_true->t);
    *bound = 2 * RC_SIN(angle / 2) * rc_vec3_norm(X_a) + rc_vec3_norm(dt);
    return RIGCAL_OK;
}
