#include "rc_sight.h"

/* ---- constants ----------------------------------------------------------- */

/* sine squared of an angle, 0.6 degrees: a point so near to the ray that was seen, which
 * the lens images, needs no proof of its own that the lens sees it there. */
#define NEAR_RAY RC(1e-4)

/* ---- one view ------------------------------------------------------------ */

static const rigcal_mounted_camera *camera_of(const rigcal_sightings *s, size_t i)
{
    return &s->rig->cameras[s->seen[i].camera];
}

static rigcal_status check_noise(rc_sight *v, rigcal_real sigma_px)
{
    const rigcal_status status = rc_check_noise(&sigma_px);
    if (status == RIGCAL_OK && !(sigma_px > 0)) {
        return RIGCAL_ERR_RANGE;
    }
    v->weight = 1 / (sigma_px * sigma_px);
    return status;
}

rigcal_status rc_sight_check(rc_sight *v, const rigcal_sightings *s, size_t i)
{
    const rigcal_sighting *const seen = &s->seen[i];
    if (seen->camera < 0 || (size_t)seen->camera >= s->rig->n_cameras) {
        return RIGCAL_ERR_RANGE;
    }
    const rigcal_mounted_camera *const m = camera_of(s, i);
    rigcal_status status = rc_check_camera(&m->camera);
    if (status == RIGCAL_OK) {
        status = rc_check_transform(&m->cam_from_rig);
    }
    if (status == RIGCAL_OK) {
        status = rc_check_pixel(seen->uv);
    }
    if (status == RIGCAL_OK) {
        status = check_noise(v, (s->sigma_px != NULL) ? s->sigma_px[seen->camera]
                                                      : s->rig->sigma_px);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    rigcal_real ray[3];
    v->ray[0] = v->ray[1] = v->ray[2] = 0;
    if (rc_pixel_to_ray(ray, &m->camera, seen->uv) == RIGCAL_OK) {
        rc_mat3_tmul_vec3(v->ray, m->cam_from_rig.R, ray);
    }
    v->first =
        (s->rig->sigma_px > 0) ? rc_calibrated_first(s->rig, (size_t)seen->camera) : -1;
    return RIGCAL_OK;
}

rigcal_status rc_sight_evaluate(rc_sight *v, const rigcal_sightings *s, size_t i,
                                const rigcal_real X[3])
{
    const rigcal_mounted_camera *const m = camera_of(s, i);
    const int is_pinhole = rc_lens_is_pinhole(&m->camera);
    rigcal_real *const P = v->B; /* for now */
    rigcal_real X_c[3];
    rc_transform_point(X_c, &m->cam_from_rig, X);
    const rigcal_status status =
        rc_residual(v->e, P, &m->camera, is_pinhole, s->seen[i].uv, X_c);
    if (status == RIGCAL_OK) {
        rc_mat3_tmul_vec3(&v->A[0], m->cam_from_rig.R, &P[0]);
        rc_mat3_tmul_vec3(&v->A[3], m->cam_from_rig.R, &P[3]);
    }
    return status;
}

/* Rows (q x p, p), p a row of d projection / d X_c, q = R X. */
rigcal_status rc_sight_move(rc_sight *v, const rigcal_sightings *s, size_t i,
                            const rigcal_real X[3])
{
    const rigcal_transform *const T = &camera_of(s, i)->cam_from_rig;
    rigcal_real q[3], X_c[3], P[6], ray[3], aside[3], uv[2];
    rc_mat3_mul_vec3(q, T->R, X);
    rc_vec3_copy(X_c, T->t);
    rc_vec3_add(X_c, q);
    rc_vec3_copy(&P[0], &v->B[0]);
    rc_vec3_copy(&P[3], &v->B[3]);
    for (int row = 0; row < 2; row++) {
        rc_vec3_cross(&v->B[6 * row], q, &P[3 * row]);
        rc_vec3_copy(&v->B[6 * row + 3], &P[3 * row]);
    }
    rc_mat3_mul_vec3(ray, T->R, v->ray);
    rc_vec3_cross(aside, ray, X_c);
    if (rc_vec3_dot(ray, X_c) > 0 &&
        rc_vec3_dot(aside, aside) <= NEAR_RAY * rc_vec3_dot(X_c, X_c)) {
        return RIGCAL_OK;
    }
    return rc_project_usable(uv, &camera_of(s, i)->camera, X_c);
}

/* ---- their covariance ---------------------------------------------------- */

static inline rigcal_real dot6(const rigcal_real a[6], const rigcal_real b[6])
{
    return rc_vec3_dot(a, b) + rc_vec3_dot(a + 3, b + 3);
}

/* T = B Sigma, 2 x 6, of the rows a of Sigma and the columns b <= a. A block of the
 * diagonal is symmetric. */
static void times_rows(rigcal_real T[12], const rigcal_real B[12],
                       const rigcal_real Sigma[], size_t a, size_t b)
{
    rc_clear(T, 12);
    for (size_t i = 0; i < 6; i++) {
        const rigcal_real *const row = &Sigma[rc_packed_at(a + i, b)];
        const rigcal_real u = B[i], v = B[6 + i];
        const size_t last = (a > b) ? 6 : i;
        for (size_t j = 0; j < last; j++) {
            T[j] += u * row[j];
            T[6 + j] += v * row[j];
        }
        if (a == b) {
            T[i] += B[i] * row[i];
            T[6 + i] += B[6 + i] * row[i];
            for (size_t j = 0; j < i; j++) {
                T[i] += B[j] * row[j];
                T[6 + i] += B[6 + j] * row[j];
            }
        }
    }
}

void rc_sight_block(rigcal_real C[4], const rc_sight *a, const rc_sight *b,
                    const rigcal_real Sigma[])
{
    rigcal_real T[12];
    const int is_swapped = a->first < b->first;
    const rc_sight *const high = is_swapped ? b : a, *const low = is_swapped ? a : b;
    if (!(low->first >= 0)) {
        rc_clear(C, 4);
        return;
    }
    times_rows(T, high->B, Sigma, (size_t)high->first, (size_t)low->first);
    C[0] = dot6(&T[0], &low->B[0]);
    C[1 + is_swapped] = dot6(&T[0], &low->B[6]);
    C[2 - is_swapped] = dot6(&T[6], &low->B[0]);
    C[3] = dot6(&T[6], &low->B[6]);
}

/* G = N A^T W, of one view. */
static void fill_gain(rc_sight *v, const rigcal_real N[6])
{
    for (int row = 0; row < 2; row++) {
        rigcal_real g[3];
        rc_sym3_mul_vec3(g, N, &v->A[3 * row]);
        for (int k = 0; k < 3; k++) {
            v->G[2 * k + row] = v->weight * g[k];
        }
    }
}

/* h += G C^T, 3 x 2, times scale. */
static void add_leverage(rigcal_real h[6], const rigcal_real G[6], const rigcal_real C[4],
                         rigcal_real scale)
{
    for (int k = 0; k < 3; k++) {
        h[2 * k] += scale * (G[2 * k] * C[0] + G[2 * k + 1] * C[1]);
        h[2 * k + 1] += scale * (G[2 * k] * C[2] + G[2 * k + 1] * C[3]);
    }
}

/* Sigma += G h^T + h G^T */
static void add_symmetric(rigcal_real Sigma[6], const rigcal_real G[6],
                          const rigcal_real h[6])
{
    for (int i = 0, at = 0; i < 3; i++) {
        for (int j = i; j < 3; j++, at++) {
            Sigma[at] += G[2 * i] * h[2 * j] + G[2 * i + 1] * h[2 * j + 1] +
                         h[2 * i] * G[2 * j] + h[2 * i + 1] * G[2 * j + 1];
        }
    }
}

/* One row of L^-1 (A e) in its place, and its part of the sums. */
static int add_row(rigcal_point_sums *sums, rc_sight sights[], size_t row)
{
    rigcal_real *const L = &sums->V[rc_packed_at(row, 0)];
    rc_sight *const v = &sights[(size_t)sights[row / 2].order];
    rigcal_real *const y = &v->y[4 * (row % 2)];
    if (!rc_packed_factor_row(sums->V, row, 0)) {
        return 0;
    }
    rc_vec3_copy(y, &v->A[3 * (row % 2)]);
    y[3] = v->e[row % 2];
    for (size_t j = 0; j < row; j++) {
        const rigcal_real *const above =
            &sights[(size_t)sights[j / 2].order].y[4 * (j % 2)];
        rc_vec3_add_scaled(y, -L[j], above);
        y[3] -= L[j] * above[3];
    }
    rc_vec3_scale(y, L[row], y);
    y[3] *= L[row];
    rc_sym3_add_outer(sums->M, 1, y);
    rc_vec3_add_scaled(sums->c, y[3], y);
    sums->q += y[3] * y[3];
    return 1;
}

int rc_sight_add(rigcal_point_sums *sums, rc_sight sights[], size_t k,
                 const rigcal_real Sigma[])
{
    rc_sight *const v = &sights[(size_t)sights[k].order];
    rigcal_real *const upper = &sums->V[rc_packed_at(2 * k, 0)];
    rigcal_real *const lower = &sums->V[rc_packed_at(2 * k + 1, 0)];
    rigcal_real h[6] = {0, 0, 0, 0, 0, 0}, C[4];
    fill_gain(v, sums->N);
    for (size_t j = 0; j <= k; j++) {
        const rc_sight *const w = &sights[(size_t)sights[j].order];
        rc_sight_block(C, v, w, Sigma);
        upper[2 * j] = C[0];
        lower[2 * j] = C[2];
        lower[2 * j + 1] = C[3];
        if (j < k) {
            upper[2 * j + 1] = C[1];
        }
        add_leverage(h, w->G, C, (j < k) ? 1 : RC(0.5));
    }
    upper[2 * k] += 1 / v->weight;
    lower[2 * k + 1] += 1 / v->weight;
    add_symmetric(sums->Sigma, v->G, h);
    return add_row(sums, sights, 2 * k) && add_row(sums, sights, 2 * k + 1);
}
