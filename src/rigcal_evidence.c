#include "rc_evidence.h"

/* ---- constants ----------------------------------------------------------- */

/* 1: square of 1.2. Points of a view are neighbours if their step is at most 1.2 times the
 * shortest one. So the last point of a row is no neighbour of the next row's first. */
#define NEIGHBOUR_MOST RC(1.44)

const uint8_t rc_pair_first[RC_PAIRS] = {RC_BY_INTRINSICS + RC_BY_CENTRE,
                                         RC_BY_INTRINSICS + RC_BY_K1, RC_BY_BENT};

/* ---- one point ----------------------------------------------------------- */

/* Columns of D, which begin with the shutter's. */
enum { FROM = RC_BY_SHUTTER, POINT_COLUMNS = RC_COLUMNS - FROM };

/* The two rows of a point, divided by its sigma. */
typedef struct {
    rigcal_real e[2], B[6], q[3], J[2][6], D[2][POINT_COLUMNS];
    int counts;
} rows;

static rigcal_real dot(const rigcal_real a[], const rigcal_real b[], size_t n)
{
    rigcal_real sum = 0;
    for (size_t i = 0; i < n; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

/* Adds the board's columns: a shift of a point of the target moves its pixel by B R times
 * this shift. */
static void add_board(rows *p, const rc_scan *scan, const rigcal_real X[3],
                      const rigcal_real R[9])
{
    const rigcal_real x = (X[0] - scan->middle[0]) / scan->half[0];
    const rigcal_real y = (X[1] - scan->middle[1]) / scan->half[1];
    rigcal_real longer[3];
    for (int k = 0; k < 3; k++) {
        longer[k] = (R[3 * k] * X[0] - R[3 * k + 1] * X[1]) / 2;
    }
    for (int row = 0; row < 2; row++) {
        const rigcal_real *const b = &p->B[3 * row];
        rigcal_real *const D = &p->D[row][RC_BY_BENT - FROM];
        const rigcal_real out = b[0] * R[2] + b[1] * R[5] + b[2] * R[8];
        D[0] = out * (1 - x * x);
        D[1] = out * (1 - y * y);
        D[2] = rc_vec3_dot(b, longer);
    }
}

static void add_camera(rows *p, const rigcal_camera *camera, const rigcal_real x[2],
                       const rigcal_real uv[2], rigcal_real by_sigma)
{
    rigcal_real D[2 * RC_INTRINSICS];
    rc_intrinsics(D, camera, x, uv);
    for (int row = 0; row < 2; row++) {
        for (int k = 0; k < RC_INTRINSICS; k++) {
            p->D[row][RC_BY_INTRINSICS - FROM + k] = by_sigma * D[RC_INTRINSICS * row + k];
        }
    }
}

int rc_evidence_reference(rigcal_real w[3], rigcal_real v[3],
                          const rigcal_real reference[3], size_t parameter)
{
    rc_clear(w, 3);
    rc_clear(v, 3);
    switch ((int)parameter - RC_BY_INTRINSICS) {
    case RC_BY_FOCAL:
        v[2] = -reference[2];
        return 1;
    case RC_BY_CENTRE:
        w[1] = reference[0];
        return 1;
    case RC_BY_CENTRE + 1:
        w[0] = -reference[1];
        return 1;
    default:
        return 0;
    }
}

/* A turn w about the camera's centre moves a pixel by B (w x X_c), so by w . (X_c x b). */
static void take_off_reference(rows *p, const rigcal_real reference[3],
                               const rigcal_real X_c[3])
{
    for (int row = 0; row < 2; row++) {
        rigcal_real *const D = &p->D[row][RC_BY_INTRINSICS - FROM], turn[3];
        rc_vec3_cross(turn, X_c, &p->B[3 * row]);
        D[RC_BY_FOCAL] += p->B[3 * row + 2] * reference[2];
        D[RC_BY_CENTRE] -= turn[1] * reference[0];
        D[RC_BY_CENTRE + 1] += turn[0] * reference[1];
    }
}

static rigcal_status rows_of(rows *p, const rc_scan *scan, const rigcal_points *points,
                             const rc_chain *chain, const rigcal_real m[6], size_t i)
{
    const rigcal_camera *const camera = points->view.camera;
    const rigcal_observation *const o = &points->view.observations[i];
    rigcal_real X_c[3], x[2], uv[2];
    rc_points_place(p->q, X_c, points, &chain->cam_from_target, i);
    const rigcal_status status = rc_project_by(x, uv, p->B, camera, X_c);
    if (status != RIGCAL_OK) {
        return status;
    }
    const rigcal_real by_sigma = RC_SQRT(rc_points_weight(points, i));
    for (int k = 0; k < 6; k++) {
        p->B[k] *= by_sigma;
    }
    add_camera(p, camera, x, uv, by_sigma);
    take_off_reference(p, scan->reference, X_c);
    add_board(p, scan, o->X_w, chain->cam_from_target.R);
    const rigcal_real height = (rigcal_real)camera->height;
    const rigcal_real row_time = (o->uv[1] - (height - 1) / 2) / height;
    for (int row = 0; row < 2; row++) {
        p->e[row] = by_sigma * (o->uv[row] - uv[row]);
        rc_vec3_cross(p->J[row], p->q, &p->B[3 * row]);
        rc_vec3_copy(&p->J[row][3], &p->B[3 * row]);
        p->D[row][0] = row_time * rc_vec6_dot(p->J[row], m);
    }
    p->counts = !(scan->limit2 > 0 && dot(p->e, p->e, 2) > scan->limit2);
    return RIGCAL_OK;
}

/* ---- sums over the points -------------------------------------------------- */

static void add_point(rc_evidence *out, const rows *p)
{
    const rigcal_real *const D = p->D[0], *const F = p->D[1];
    rigcal_real *const Q = &out->Q[FROM], *const q = &out->q[FROM];
    out->n++;
    out->sum += dot(p->e, p->e, 2);
    rc_rigid_add(out->g, out->H, p->B, p->q, p->e, 1, NULL, 0);
    for (int c = 0; c < POINT_COLUMNS; c++) {
        rigcal_real *const E = out->E[FROM + c];
        for (int k = 0; k < 6; k++) {
            E[k] += D[c] * p->J[0][k] + F[c] * p->J[1][k];
        }
    }
    for (int c = 0; c < POINT_COLUMNS; c++) {
        Q[c] += D[c] * D[c] + F[c] * F[c];
        q[c] += D[c] * p->e[0] + F[c] * p->e[1];
    }
    for (int k = 0; k < RC_PAIRS; k++) {
        const int c = rc_pair_first[k] - FROM;
        out->pairs[k] += D[c] * D[c + 1] + F[c] * F[c + 1];
    }
}

static void add_neighbours(rc_evidence *out, const rows *a, const rows *b)
{
    out->n_neighbours++;
    out->product += dot(a->e, b->e, 2);
    for (int i = 0; i < 6; i++) {
        const rigcal_real u = a->J[0][i], v = a->J[1][i];
        rigcal_real *const M = &out->M[6 * i];
        out->mixed[i] += u * b->e[0] + v * b->e[1];
        out->mixed[i] += b->J[0][i] * a->e[0] + b->J[1][i] * a->e[1];
        for (int j = 0; j < 6; j++) {
            M[j] += u * b->J[0][j] + v * b->J[1][j];
        }
    }
}

/* Squared distance on the target between point i and the one before it. */
static rigcal_real step_to(const rigcal_view *view, size_t i)
{
    rigcal_real d[3];
    rc_vec3_sub(d, view->observations[i].X_w, view->observations[i - 1].X_w);
    return rc_vec3_dot(d, d);
}

static rigcal_real shortest_step(const rigcal_view *view)
{
    rigcal_real least = RC_MAX;
    for (size_t i = 1; i < view->n; i++) {
        least = rc_min(least, step_to(view, i));
    }
    return least;
}

/* Adds the clock's columns. The column of the offset is J m. */
static void add_clock(rc_evidence *out, const rigcal_real m[6], rigcal_real since)
{
    for (int k = 0; k < 6; k++) {
        out->m[k] = m[k];
    }
    out->left = 1;
    rc_sym6_mul(out->E[RC_BY_CLOCK], out->H, m);
    out->Q[RC_BY_CLOCK] = rc_vec6_dot(out->E[RC_BY_CLOCK], m);
    out->q[RC_BY_CLOCK] = rc_vec6_dot(out->g, m);
    for (int k = 0; k < 6; k++) {
        out->E[RC_BY_DRIFT][k] = since * out->E[RC_BY_CLOCK][k];
    }
    out->Q[RC_BY_DRIFT] = since * since * out->Q[RC_BY_CLOCK];
    out->q[RC_BY_DRIFT] = since * out->q[RC_BY_CLOCK];
}

rigcal_status rc_evidence_of(rc_evidence *out, const rc_scan *scan,
                             const rigcal_rig_view *view, const rc_chain *chain,
                             const rigcal_real m[6], rigcal_real since)
{
    rigcal_points points;
    rows at[2];
    const rigcal_real near = NEIGHBOUR_MOST * shortest_step(&view->view);
    *out = (rc_evidence){0};
    rc_points_of(&points, &view->view, NULL);
    points.origin[0] = points.origin[1] = points.origin[2] = 0;
    at[1].counts = 0;
    for (size_t i = 0; i < view->view.n; i++) {
        rows *const p = &at[i % 2], *const before = &at[1 - i % 2];
        const rigcal_status status = rows_of(p, scan, &points, chain, m, i);
        if (status != RIGCAL_OK && !(scan->limit2 > 0)) {
            return status;
        }
        p->counts = status == RIGCAL_OK && p->counts;
        if (!p->counts) {
            continue;
        }
        add_point(out, p);
        if (before->counts && step_to(&view->view, i) <= near) {
            add_neighbours(out, before, p);
        }
    }
    add_clock(out, m, since);
    return rc_is_finite(out->sum) ? RIGCAL_OK : RIGCAL_ERR_NO_RAY;
}

/* ---- noise of stamps (H11) -------------------------------------------------- */

void rc_evidence_stamp(rc_evidence *v, rigcal_real ratio2)
{
    if (ratio2 > 0) {
        v->stamp = 1 / (v->Q[RC_BY_CLOCK] + ratio2);
        v->left = ratio2 * v->stamp;
    }
}

void rc_evidence_weighed(rigcal_real E[6], rigcal_real *Q, rigcal_real *q,
                         rigcal_real *along, const rc_evidence *v, size_t parameter)
{
    *along = rc_vec6_dot(v->m, v->E[parameter]);
    const rigcal_real part = v->stamp * *along;
    for (int k = 0; k < 6; k++) {
        E[k] = v->E[parameter][k] - part * v->E[RC_BY_CLOCK][k];
    }
    *Q = v->Q[parameter] - part * *along;
    *q = v->q[parameter] - part * v->q[RC_BY_CLOCK];
}

/* ---- with the view's own pose free ----------------------------------------- */

int rc_evidence_alone(rc_evidence *v, rigcal_real d[6])
{
    rc_sym6_factor L;
    if (!rc_sym6_factor_of(&L, v->H, 0)) {
        return 0;
    }
    for (int k = 0; k < 6; k++) {
        d[k] = v->g[k];
    }
    rc_sym6_forward(d, &L);
    v->sum -= rc_vec6_dot(d, d);
    for (int c = 0; c < RC_COLUMNS; c++) {
        rc_sym6_forward(v->E[c], &L);
        v->Q[c] -= rc_vec6_dot(v->E[c], v->E[c]);
        v->q[c] -= rc_vec6_dot(v->E[c], d);
    }
    for (int k = 0; k < RC_PAIRS; k++) {
        const int c = rc_pair_first[k];
        v->pairs[k] -= rc_vec6_dot(v->E[c], v->E[c + 1]);
    }
    rc_sym6_backward(d, &L);
    return 1;
}

rigcal_real rc_evidence_pattern(rigcal_real *expected, const rc_evidence *v,
                                const rigcal_real d[6])
{
    rigcal_real inverse[36], product = v->product - rc_vec6_dot(d, v->mixed);
    (void)rc_sym6_invert(inverse, v->H);
    for (int i = 0; i < 6; i++) {
        product += d[i] * rc_vec6_dot(&v->M[6 * i], d);
    }
    *expected = -dot(inverse, v->M, 36);
    return product;
}
