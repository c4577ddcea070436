#include "rc_calibrated.h"
#include "rc_joint.h"
#include "rc_points.h"

/* ---- constants ----------------------------------------------------------- */

/* steps: Gauss-Newton for a point takes this many, from the middle between two rays. The
 * third is below rounding. */
enum { STEPS = 3 };

/* part of an element of the diagonal: a smaller pivot is rounding. */
#define RANK_TOL (4 * RC_EPS)

/* part of a pixel's noise: smaller residuals are rounding and count as 0. */
#define RESIDUAL_LEAST RC_TOL(1e-9, 1e-3)

/* The three cameras, and the rows that depend on their poses. Each row has 6 numbers for
 * each camera. */
enum { CAM_A, CAM_B, CAM_C, CAMERAS };
enum { ROW_X = 0, ROW_UV = 3, ROW_MISS = 5, ROWS = 6 };

/* What one camera sees of the point. */
typedef struct {
    const rigcal_camera *camera;
    const rigcal_transform *cam_from_rig;
    rigcal_real uv[2], e[2];      /* projected pixel; residual */
    rigcal_real A[2][3], B[2][6]; /* d uv / d X, d uv / d (w, dt) */
} sight;

/* All numbers of one transfer. L says how the rows depend on the cameras. */
typedef struct {
    sight sights[CAMERAS];
    rigcal_real X[3], H[6], weight[2];
    rigcal_real L[ROWS][CAMERAS][6];
} transferred;

/* ---- the point ----------------------------------------------------------- */

/* Projects X, with derivatives. uv may be NULL if nothing was observed. */
static rigcal_status look(sight *s, const rigcal_real X[3], const rigcal_real *uv)
{
    const rigcal_transform *const T = s->cam_from_rig;
    rigcal_real q[3], X_c[3], J[6];
    rc_mat3_mul_vec3(q, T->R, X);
    rc_vec3_copy(X_c, q);
    rc_vec3_add(X_c, T->t);
    const rigcal_status status =
        rc_project_through(s->uv, J, s->camera, rc_lens_is_pinhole(s->camera), X_c);
    for (int i = 0; i < 2 && status == RIGCAL_OK; i++) {
        rc_mat3_tmul_vec3(s->A[i], T->R, &J[3 * i]);
        rc_vec3_cross(&s->B[i][0], q, &J[3 * i]);
        rc_vec3_copy(&s->B[i][3], &J[3 * i]);
        s->e[i] = (uv != NULL) ? uv[i] - s->uv[i] : 0;
    }
    return status;
}

static void solve(rigcal_real x[3], const rigcal_real L[6])
{
    rc_sym3_forward(x, L);
    rc_sym3_backward(x, L);
}

/* Finds the point that a and b see, by least squares in pixels from the middle between the
 * rays. H becomes the factor of the normal equations. */
static rigcal_status find_point(transferred *t, const rigcal_real uv_a[2],
                                const rigcal_real uv_b[2])
{
    rigcal_real rays[2][3], depths[2], miss, o[3], diagonal[3], g[3];
    rigcal_transform b_from_a;
    rigcal_status status = rc_pixel_to_ray(rays[0], t->sights[CAM_A].camera, uv_a);
    if (status == RIGCAL_OK) {
        status = rc_pixel_to_ray(rays[1], t->sights[CAM_B].camera, uv_b);
    }
    rc_transform_between(&b_from_a, t->sights[CAM_B].cam_from_rig,
                         t->sights[CAM_A].cam_from_rig);
    if (status == RIGCAL_OK) {
        status = rigcal_depth_two_views(depths, &miss, &b_from_a, rays[0], rays[1]);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_vec3_combine(o, depths[0], rays[0], -1, t->sights[CAM_A].cam_from_rig->t);
    rc_mat3_tmul_vec3(t->X, t->sights[CAM_A].cam_from_rig->R, o);
    for (int step = 0; step <= STEPS; step++) {
        rc_clear(t->H, 6);
        rc_clear(g, 3);
        for (int i = CAM_A; i <= CAM_B; i++) {
            status = look(&t->sights[i], t->X, (i == CAM_A) ? uv_a : uv_b);
            if (status != RIGCAL_OK) {
                return status;
            }
            for (int k = 0; k < 2; k++) {
                rc_sym3_add_outer(t->H, t->weight[i], t->sights[i].A[k]);
                rc_vec3_add_scaled(g, t->weight[i] * t->sights[i].e[k], t->sights[i].A[k]);
            }
        }
        diagonal[0] = t->H[0];
        diagonal[1] = t->H[3];
        diagonal[2] = t->H[5];
        if (!rc_sym3_factor(t->H, t->H, diagonal, RANK_TOL)) {
            return RIGCAL_ERR_PARALLEL;
        }
        if (step < STEPS) {
            solve(g, t->H);
            rc_vec3_add(t->X, g);
        }
    }
    return RIGCAL_OK; /* an X that is not finite has no H that can be factored */
}

/* ---- how sure ------------------------------------------------------------ */

/* (M8) Fills L. The rows of X are gain_i = -H^-1 A_i^T w_i B_i. The rows of c's pixel are
 * A_c gain_i and B_c. The row of the residual of a and b, along itself, is
 * e_i^T w_i B_i. */
static void fill_rows(transferred *t)
{
    const sight *const c = &t->sights[CAM_C];
    rc_clear(&t->L[0][0][0], sizeof t->L / sizeof t->L[0][0][0]);
    for (int i = CAM_A; i <= CAM_B; i++) {
        const sight *const s = &t->sights[i];
        for (int k = 0; k < 2; k++) {
            rigcal_real by_X[3];
            rc_vec3_copy(by_X, s->A[k]);
            solve(by_X, t->H);
            for (int column = 0; column < 6; column++) {
                const rigcal_real b = t->weight[i] * s->B[k][column];
                for (int row = 0; row < 3; row++) {
                    t->L[ROW_X + row][i][column] -= by_X[row] * b;
                }
                for (int row = 0; row < 2; row++) {
                    t->L[ROW_UV + row][i][column] -= rc_vec3_dot(c->A[row], by_X) * b;
                }
                t->L[ROW_MISS][i][column] += s->e[k] * b;
            }
        }
    }
    for (int k = 0; k < 12; k++) {
        t->L[ROW_UV + k / 6][CAM_C][k % 6] = c->B[k / 6][k % 6];
    }
}

/* V[i][j] = L_i Sigma L_j^T of each two rows. Sigma is the joint covariance. */
static void spread(rigcal_real V[ROWS][ROWS], const transferred *t,
                   const rigcal_calibrated_rig *rig, const size_t abc[3])
{
    rc_clear(&V[0][0], (size_t)ROWS * ROWS);
    for (int a = CAM_A; a < CAMERAS; a++) {
        for (int b = CAM_A; b < CAMERAS; b++) {
            rigcal_real block[36];
            rc_joint_block(block, rig->Sigma, rc_calibrated_first(rig, abc[a]),
                           rc_calibrated_first(rig, abc[b]));
            for (int j = 0; j < ROWS; j++) {
                rigcal_real moved[6];
                for (int k = 0; k < 6; k++) {
                    moved[k] = rc_vec3_dot(&block[6 * k], &t->L[j][b][0]) +
                               rc_vec3_dot(&block[6 * k + 3], &t->L[j][b][3]);
                }
                for (int i = 0; i < ROWS; i++) {
                    V[i][j] += rc_vec3_dot(&t->L[i][a][0], &moved[0]) +
                               rc_vec3_dot(&t->L[i][a][3], &moved[3]);
                }
            }
        }
    }
}

static void write_out(rigcal_transfer *out, const transferred *t, rigcal_real V[ROWS][ROWS])
{
    const sight *const c = &t->sights[CAM_C];
    rigcal_real weighed = 0, noise = 0;
    rc_vec3_copy(out->X, t->X);
    for (int i = 0; i < 3; i++) {
        rigcal_real e[3] = {0, 0, 0};
        e[i] = 1;
        solve(e, t->H);
        for (int j = 0; j < 3; j++) {
            out->Sigma_X[3 * i + j] = e[j] + (V[i][j] + V[j][i]) / 2;
        }
    }
    for (int i = 0; i < 2; i++) {
        rigcal_real by_X[3];
        rc_vec3_copy(by_X, c->A[i]);
        solve(by_X, t->H);
        for (int j = 0; j < 2; j++) {
            const rigcal_real share = V[ROW_UV + i][ROW_UV + j] + V[ROW_UV + j][ROW_UV + i];
            out->Sigma[2 * i + j] = rc_vec3_dot(c->A[j], by_X) + share / 2;
        }
        out->uv[i] = c->uv[i];
    }
    for (int i = CAM_A; i <= CAM_B; i++) {
        for (int k = 0; k < 2; k++) {
            weighed += t->weight[i] * t->sights[i].e[k] * t->sights[i].e[k];
            noise += RESIDUAL_LEAST * RESIDUAL_LEAST;
        }
    }
    out->chi2 =
        (weighed > noise) ? weighed * (weighed / (weighed + V[ROW_MISS][ROW_MISS])) : 0;
}

/* Whether all variances are 0 or more, chi2 too, which is divided by one. They may not be
 * if the rig's Sigma is no covariance. */
static int has_variances(const rigcal_transfer *made)
{
    const rigcal_real *const S = made->Sigma, *const S_X = made->Sigma_X;
    return made->chi2 >= 0 && S[0] >= 0 && S[3] >= 0 && S_X[0] >= 0 && S_X[4] >= 0 &&
           S_X[8] >= 0;
}

/* ---- public -------------------------------------------------------------- */

static rigcal_status check(const rigcal_calibrated_rig *rig, const size_t abc[3],
                           const rigcal_real uv_a[2], const rigcal_real uv_b[2],
                           const rigcal_real sigma_ab[2])
{
    size_t n_free;
    if (abc == NULL || uv_a == NULL || uv_b == NULL || sigma_ab == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_calibrated_check(&n_free, rig);
    for (int i = 0; i < CAMERAS && status == RIGCAL_OK; i++) {
        if (abc[i] >= rig->n_cameras || abc[i] == abc[(i + 1) % CAMERAS]) {
            return RIGCAL_ERR_RANGE;
        }
        if (i > 0 && rig->group[abc[i]] != rig->group[abc[0]]) {
            return RIGCAL_DISCONNECTED;
        }
        status = rc_check_camera(&rig->cameras[abc[i]].camera);
        if (status == RIGCAL_OK) {
            status = rc_check_transform(&rig->cameras[abc[i]].cam_from_rig);
        }
    }
    for (int i = 0; i < 2 && status == RIGCAL_OK; i++) {
        status = rc_check_pixel((i == 0) ? uv_a : uv_b);
        if (status == RIGCAL_OK) {
            status = rc_check_noise(&sigma_ab[i]);
        }
        if (status == RIGCAL_OK && !(sigma_ab[i] > 0)) {
            status = RIGCAL_ERR_RANGE;
        }
    }
    return status;
}

rigcal_status rigcal_transfer_make(rigcal_transfer *out, const rigcal_calibrated_rig *rig,
                                   const size_t abc[3], const rigcal_real uv_a[2],
                                   const rigcal_real uv_b[2], const rigcal_real sigma_ab[2])
{
    transferred t;
    rigcal_real V[ROWS][ROWS], X_c[3], uv[2];
    rigcal_status status =
        (out == NULL) ? RIGCAL_ERR_NULL : check(rig, abc, uv_a, uv_b, sigma_ab);
    if (status != RIGCAL_OK) {
        return status;
    }
    for (int i = CAM_A; i < CAMERAS; i++) {
        t.sights[i].camera = &rig->cameras[abc[i]].camera;
        t.sights[i].cam_from_rig = &rig->cameras[abc[i]].cam_from_rig;
    }
    t.weight[CAM_A] = 1 / (sigma_ab[CAM_A] * sigma_ab[CAM_A]);
    t.weight[CAM_B] = 1 / (sigma_ab[CAM_B] * sigma_ab[CAM_B]);
    status = find_point(&t, uv_a, uv_b);
    if (status == RIGCAL_OK) {
        rc_transform_point(X_c, t.sights[CAM_C].cam_from_rig, t.X);
        status = rc_project_usable(uv, t.sights[CAM_C].camera, X_c);
    }
    if (status == RIGCAL_OK) {
        status = look(&t.sights[CAM_C], t.X, NULL);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    fill_rows(&t);
    spread(V, &t, rig, abc);
    if (!rc_all_finite(&V[0][0], ROWS * ROWS)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    rigcal_transfer made;
    write_out(&made, &t, V);
    if (!rc_all_finite(made.Sigma, 4) || !rc_all_finite(made.Sigma_X, 9) ||
        !rc_is_finite(made.chi2) || !has_variances(&made)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    *out = made;
    return RIGCAL_OK;
}

rigcal_status rigcal_transfer_test(rigcal_real *chi2, const rigcal_transfer *transfer,
                                   rigcal_real sigma_c, const rigcal_real uv_c[2])
{
    if (chi2 == NULL || transfer == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_pixel(uv_c);
    if (status == RIGCAL_OK) {
        status = rc_check_noise(&sigma_c);
    }
    if (status == RIGCAL_OK) {
        status = rc_check_pixel(transfer->uv);
    }
    if (status == RIGCAL_OK && !rc_all_finite(transfer->Sigma, 4)) {
        status = RIGCAL_ERR_NOT_FINITE;
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    const rigcal_real du = uv_c[0] - transfer->uv[0], dv = uv_c[1] - transfer->uv[1];
    const rigcal_real uu = transfer->Sigma[0] + sigma_c * sigma_c;
    const rigcal_real vv = transfer->Sigma[3] + sigma_c * sigma_c,
                      across = transfer->Sigma[1];
    const rigcal_real det = uu * vv - across * across;
    if (!(uu > 0 && vv > 0 && det > RANK_TOL * uu * vv && det <= RC_MAX)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    const rigcal_real found = (vv * du * du - 2 * across * du * dv + uu * dv * dv) / det;
    if (!rc_is_finite(found)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    *chi2 = found;
    return RIGCAL_OK;
}
