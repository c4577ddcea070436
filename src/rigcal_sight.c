#include "rc_sight.h"

/* ---- constants ----------------------------------------------------------- */

/* squared sine: the angle is 0.6 degrees. A point this near to the ray that was seen needs
 * no proof that the lens sees it: the lens images this ray. */
#define NEAR_RAY RC(1e-4)

/* squared distance in a lens's plane: 0.1 px of a usual camera. The Newton step from there
 * ends the search for a ray. Its error is then 1e-6 px. */
#define RAY_NEAR RC(1e-8)

/* steps: the most of the search for a ray, usually 2 or 3. */
enum { RAY_STEPS = 3 };

/* ---- a ray --------------------------------------------------------------- */

/* Whether the Jacobian of Brown's lens without a denominator is positive definite on the
 * whole way from the axis to x. Its least eigenvalue is at least 1 minus this sum of
 * bounds. The test holds for most images, and takes a tenth of the time of
 * rc_lens_is_usable. */
static int is_mild(const rigcal_camera *c, const rigcal_real x[2])
{
    const rigcal_real s = x[0] * x[0] + x[1] * x[1];
    const rigcal_real radial =
        s * (3 * RC_FABS(c->k1) + s * (5 * RC_FABS(c->k2) + s * 7 * RC_FABS(c->k3)));
    return radial + 6 * (RC_FABS(c->p1) + RC_FABS(c->p2)) * RC_SQRT(s) < 1;
}

/* Finds x with F(x) = target for such a lens. x is the target at first. Returns 0 if it
 * needs a more careful search. */
static int find_mild(rigcal_real x[2], const rigcal_camera *c, const rigcal_real target[2])
{
    const rigcal_real denominator = RC_FABS(c->k4) + RC_FABS(c->k5) + RC_FABS(c->k6);
    if (rc_lens_is_fisheye(c) || denominator > 0) {
        return 0;
    }
    for (int i = 0; i < RAY_STEPS && is_mild(c, x); i++) {
        rigcal_real F[2], J[3];
        (void)rc_lens_map(F, J, c, x);
        const rigcal_real u = target[0] - F[0], v = target[1] - F[1];
        const rigcal_real by_det = 1 / (J[0] * J[2] - J[1] * J[1]);
        x[0] += (J[2] * u - J[1] * v) * by_det;
        x[1] += (J[0] * v - J[1] * u) * by_det;
        if (u * u + v * v <= RAY_NEAR) {
            return is_mild(c, x);
        }
    }
    return 0;
}

/* Computes the unit ray of a pixel in the rig's frame. It is 0 if the lens has none. */
static void fill_ray(rc_sighted *v, const rigcal_mounted_camera *m, const rigcal_real uv[2])
{
    const rigcal_camera *const c = &m->camera;
    const rigcal_real target[2] = {(uv[0] - c->cx) / c->fx, (uv[1] - c->cy) / c->fy};
    rigcal_real ray[3] = {target[0], target[1], 1};
    v->ray[0] = v->ray[1] = v->ray[2] = 0;
    if (v->is_pinhole > 0 || find_mild(ray, c, target)) {
        const rigcal_real scale = 1 / rc_vec3_norm(ray);
        rc_mat3_tmul_vec3(v->ray, m->cam_from_rig.R, ray);
        rc_vec3_scale(v->ray, scale, v->ray);
    } else if (rc_pixel_to_ray(ray, c, uv) == RIGCAL_OK) {
        rc_mat3_tmul_vec3(v->ray, m->cam_from_rig.R, ray);
    }
}

/* ---- one view ------------------------------------------------------------ */

static const rigcal_mounted_camera *camera_of(const rigcal_sightings *s, size_t i)
{
    return &s->rig->cameras[s->seen[i].camera];
}

static rigcal_status check_noise(rc_sighted *v, rigcal_real sigma_px)
{
    const rigcal_status status = rc_check_noise(&sigma_px);
    if (status == RIGCAL_OK && !(sigma_px > 0)) {
        return RIGCAL_ERR_RANGE;
    }
    v->weight = 1 / (sigma_px * sigma_px);
    return status;
}

rigcal_status rc_sight_check(rc_sighted *v, const rigcal_sightings *s, size_t i)
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
    v->is_pinhole = (rigcal_real)rc_lens_is_pinhole(&m->camera);
    fill_ray(v, m, seen->uv);
    v->first =
        (s->rig->sigma_px > 0) ? rc_calibrated_first(s->rig, (size_t)seen->camera) : -1;
    return RIGCAL_OK;
}

rigcal_status rc_sight_evaluate(rc_sighted *v, const rigcal_sightings *s, size_t i,
                                const rigcal_real X[3])
{
    const rigcal_mounted_camera *const m = camera_of(s, i);
    rigcal_real *const P = v->B; /* used as scratch */
    rigcal_real X_c[3];
    rc_transform_point(X_c, &m->cam_from_rig, X);
    const rigcal_status status =
        rc_residual(v->e, P, &m->camera, v->is_pinhole > 0, s->seen[i].uv, X_c);
    if (status == RIGCAL_OK) {
        rc_mat3_tmul_vec3(&v->A[0], m->cam_from_rig.R, &P[0]);
        rc_mat3_tmul_vec3(&v->A[3], m->cam_from_rig.R, &P[3]);
    }
    return status;
}

/* The rows are (q x p, p), with p a row of d projection / d X_c and q = R X. */
rigcal_status rc_sight_move(rc_sighted *v, const rigcal_sightings *s, size_t i,
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

/* C = B_a Sigma B_b^T, with the block of Sigma that begins at `row` and at the lower
 * `column`. */
static void block_before(rigcal_real C[4], const rigcal_real B_a[12],
                         const rigcal_real B_b[12], const rigcal_real Sigma[], size_t row,
                         size_t column)
{
    const rigcal_real *at = &Sigma[rc_packed_at(row, column)];
    rigcal_real u = rc_vec6_dot(at, &B_b[0]), v = rc_vec6_dot(at, &B_b[6]);
    C[0] = B_a[0] * u;
    C[1] = B_a[0] * v;
    C[2] = B_a[6] * u;
    C[3] = B_a[6] * v;
    for (size_t i = 1; i < 6; i++) {
        at += row + i;
        u = rc_vec6_dot(at, &B_b[0]);
        v = rc_vec6_dot(at, &B_b[6]);
        C[0] += B_a[i] * u;
        C[1] += B_a[i] * v;
        C[2] += B_a[6 + i] * u;
        C[3] += B_a[6 + i] * v;
    }
}

/* The same for one camera. Its block of Sigma is symmetric, and only its lower half is
 * stored. */
static void block_own(rigcal_real C[4], const rigcal_real B_a[12],
                      const rigcal_real B_b[12], const rigcal_real Sigma[], size_t row)
{
    C[0] = C[1] = C[2] = C[3] = 0;
    for (size_t i = 0; i < 6; i++) {
        const rigcal_real *const at = &Sigma[rc_packed_at(row + i, row)];
        rigcal_real ua = 0, va = 0, ub = at[i] * B_b[i], vb = at[i] * B_b[6 + i];
        for (size_t j = 0; j < i; j++) {
            ua += at[j] * B_a[j];
            va += at[j] * B_a[6 + j];
            ub += at[j] * B_b[j];
            vb += at[j] * B_b[6 + j];
        }
        C[0] += B_a[i] * ub + ua * B_b[i];
        C[1] += B_a[i] * vb + ua * B_b[6 + i];
        C[2] += B_a[6 + i] * ub + va * B_b[i];
        C[3] += B_a[6 + i] * vb + va * B_b[6 + i];
    }
}

void rc_sight_block(rigcal_real C[4], const rc_sighted *a, const rc_sighted *b,
                    const rigcal_real Sigma[])
{
    if (!(a->first >= 0 && b->first >= 0)) {
        C[0] = C[1] = C[2] = C[3] = 0;
    } else if (a->first > b->first) {
        block_before(C, a->B, b->B, Sigma, (size_t)a->first, (size_t)b->first);
    } else if (a->first < b->first) {
        block_before(C, b->B, a->B, Sigma, (size_t)b->first, (size_t)a->first);
        const rigcal_real across = C[1];
        C[1] = C[2];
        C[2] = across;
    } else {
        block_own(C, a->B, b->B, Sigma, (size_t)a->first);
    }
}

/* G = N A^T W of one view. */
static void fill_gain(rc_sighted *v, const rigcal_real N[6])
{
    for (int row = 0; row < 2; row++) {
        rigcal_real g[3];
        rc_sym3_mul_vec3(g, N, &v->A[3 * row]);
        for (int k = 0; k < 3; k++) {
            v->G[2 * k + row] = v->weight * g[k];
        }
    }
}

/* h += G C^T, 3 x 2. */
static void add_leverage(rigcal_real h[6], const rigcal_real G[6], const rigcal_real C[4])
{
    for (int k = 0; k < 3; k++) {
        h[2 * k] += G[2 * k] * C[0] + G[2 * k + 1] * C[1];
        h[2 * k + 1] += G[2 * k] * C[2] + G[2 * k + 1] * C[3];
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

/* Computes one row of L^-1 (A e) and adds it to the sums. */
static int add_row(rigcal_point_sums *sums, rc_sighted sights[], size_t row)
{
    rigcal_real *const L = &sums->V[rc_packed_at(row, 0)];
    rc_sighted *const v = &sights[(size_t)sights[row / 2].order];
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

int rc_sight_add(rigcal_point_sums *sums, rc_sighted sights[], size_t k,
                 const rigcal_real Sigma[])
{
    rc_sighted *const v = &sights[(size_t)sights[k].order];
    rigcal_real *const upper = &sums->V[rc_packed_at(2 * k, 0)];
    rigcal_real *const lower = &sums->V[rc_packed_at(2 * k + 1, 0)];
    rigcal_real h[6] = {0, 0, 0, 0, 0, 0}, C[4];
    fill_gain(v, sums->N);
    for (size_t j = 0; j < k; j++) {
        const rc_sighted *const w = &sights[(size_t)sights[j].order];
        rc_sight_block(C, v, w, Sigma);
        upper[2 * j] = C[0];
        upper[2 * j + 1] = C[1];
        lower[2 * j] = C[2];
        lower[2 * j + 1] = C[3];
        add_leverage(h, w->G, C);
    }
    rc_sight_block(C, v, v, Sigma);
    upper[2 * k] = C[0];
    lower[2 * k] = C[2];
    lower[2 * k + 1] = C[3];
    for (int i = 0; i < 4; i++) { /* half, because it is added with its transpose */
        C[i] /= 2;
    }
    add_leverage(h, v->G, C);
    upper[2 * k] += 1 / v->weight;
    lower[2 * k + 1] += 1 / v->weight;
    add_symmetric(sums->Sigma, v->G, h);
    return add_row(sums, sights, 2 * k) && add_row(sums, sights, 2 * k + 1);
}
