#include "rc_refine.h"

/* One residual row j = d(u or v) / d(w, dt), from d / dX_c: with q = R X,
 * dX_c = w x q + dt, so j = (q x J_c, J_c). */
static void add_row(rc_normal *out, const rigcal_real J_c[3],
                    const rigcal_real q[3], rigcal_real e)
{
    rigcal_real j[6];
    rigcal_real *h = out->H;
    rc_vec3_cross(j, q, J_c);
    j[3] = J_c[0];
    j[4] = J_c[1];
    j[5] = J_c[2];
    for (int r = 0; r < 6; r++) {
        out->g[r] += j[r] * e;
        for (int c = 0; c <= r; c++) {
            *h++ += j[r] * j[c];
        }
    }
    out->sse += e * e;
}

rigcal_status rc_normal_at(rc_normal *out, const rc_fit *fit,
                           const rigcal_transform *cam_from_points)
{
    *out = (rc_normal){{0}, {0}, 0};
    for (size_t i = 0; i < fit->n; i++) {
        const rigcal_observation *const o = &fit->observations[i];
        rigcal_real x[3], q[3], X_c[3], uv[2], J_c[6];
        if (fit->use != NULL && !fit->use[i]) {
            continue;
        }
        rc_vec3_sub(x, o->X_w, fit->origin);
        rc_mat3_mul_vec3(q, cam_from_points->R, x);
        for (int k = 0; k < 3; k++) {
            X_c[k] = q[k] + cam_from_points->t[k];
        }
        const rigcal_status status =
            rc_project_through(uv, J_c, &fit->lens, fit->camera, X_c);
        if (status != RIGCAL_OK) {
            return status;
        }
        add_row(out, &J_c[0], q, o->uv[0] - uv[0]);
        add_row(out, &J_c[3], q, o->uv[1] - uv[1]);
    }
    return rc_is_finite(out->sse) ? RIGCAL_OK : RIGCAL_ERR_NO_RAY;
}

/* Solves (H + lambda diag H) d = g by Cholesky, packed. 0: singular. */
static int solve_damped(rigcal_real d[6], const rc_normal *at, rigcal_real lambda)
{
    rigcal_real L[21], inverse[6];
    const rigcal_real *h = at->H;
    rigcal_real *row = L;
    for (int i = 0; i < 6; i++) {
        const rigcal_real *upper = L;
        for (int j = 0; j < i; j++) {
            rigcal_real sum = h[j];
            for (int k = 0; k < j; k++) {
                sum -= row[k] * upper[k];
            }
            row[j] = sum * inverse[j];
            upper += j + 1;
        }
        rigcal_real pivot = h[i] * (1 + lambda);
        const rigcal_real least = 8 * RC_EPS * pivot;
        for (int k = 0; k < i; k++) {
            pivot -= row[k] * row[k];
        }
        if (!(pivot > least)) {
            return 0;
        }
        row[i] = RC_SQRT(pivot);
        inverse[i] = 1 / row[i];
        d[i] = at->g[i];
        for (int k = 0; k < i; k++) {
            d[i] -= row[k] * d[k];
        }
        d[i] *= inverse[i];
        row += i + 1;
        h += i + 1;
    }
    for (int i = 5; i >= 0; i--) {
        row -= i + 1;
        d[i] *= inverse[i];
        for (int k = 0; k < i; k++) {
            d[k] -= row[k] * d[i];
        }
    }
    return 1;
}

/* R <- exp([w]x) R, t <- t + dt. For the short steps of a fit the quaternion
 * (1, w / 2), normalised, is exp([w]x) to third order: a retraction all the same. */
static void moved(rigcal_transform *out, const rigcal_transform *from,
                  const rigcal_real d[6])
{
    const rigcal_real q[4] = {1, d[0] / 2, d[1] / 2, d[2] / 2};
    rigcal_real turn[9];
    rc_rotation_from_quaternion(turn, q);
    rc_mat3_mul(out->R, turn, from->R);
    for (int k = 0; k < 3; k++) {
        out->t[k] = from->t[k] + d[3 + k];
    }
}

#define SSE_ROUNDING (16 * RC_EPS)

rigcal_status rc_refine(rigcal_transform *cam_from_points, rigcal_real *sse,
                        const rc_fit *fit, int max_steps)
{
    rc_normal at, next;
    rigcal_real lambda = RC(LAM0);
    rigcal_status status = rc_normal_at(&at, fit, cam_from_points);
    if (status != RIGCAL_OK) {
        return status;
    }
    int done = 0;
    for (int i = 0; i < max_steps && !done; i++) {
        rigcal_transform candidate;
        rigcal_real d[6];
        if (!solve_damped(d, &at, lambda)) {
            return RIGCAL_ERR_DEGENERATE;
        }
        moved(&candidate, cam_from_points, d);
        rigcal_real predicted = 0;
        for (int k = 0; k < 6; k++) {
            predicted += d[k] * at.g[k];
        }
        if (rc_normal_at(&next, fit, &candidate) == RIGCAL_OK &&
            next.sse <= at.sse * (1 + SSE_ROUNDING)) {
            done = predicted <= RC(PTOL) * at.sse || predicted <= RC_TOL(1e-20, 1e-8);
            *cam_from_points = candidate;
            at = next;
            lambda *= RC(0.1);
        } else {
            lambda *= 10;
            done = lambda > RC(1e6);
        }
    }
    *sse = at.sse;
    return done ? RIGCAL_OK : RIGCAL_BUDGET_SPENT;
}
