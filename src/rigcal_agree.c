#include "rc_agree.h"

/* ---- one point ----------------------------------------------------------- */

/* A pose as its points are projected: rows by which a pinhole takes x to Z (u - cx), to
 * Z (v - cy) and to Z. */
typedef struct {
    const rigcal_points *points;
    const rigcal_transform *cam_from_points;
    rigcal_real row[3][3], shift[3];
    int is_plain; /* a pinhole, and the points are not mirrored */
} projection;

static void project_by(projection *p, const rigcal_points *points,
                       const rigcal_transform *cam_from_points)
{
    const rigcal_camera *const camera = points->view.camera;
    const rigcal_real scale[3] = {camera->fx, camera->fy, 1};
    p->points = points;
    p->cam_from_points = cam_from_points;
    p->is_plain = points->is_pinhole && !points->is_mirrored;
    for (int k = 0; k < 3; k++) {
        rc_vec3_scale(p->row[k], scale[k], &cam_from_points->R[3 * k]);
        p->shift[k] = scale[k] * cam_from_points->t[k];
    }
}

/* Squared distance over sigma_i^2, or something above the limit. A point that disagrees
 * costs no division. */
static inline rigcal_real off2(const projection *p, size_t i, rigcal_real limit)
{
    const rigcal_view *const view = &p->points->view;
    const rigcal_camera *const camera = view->camera;
    const rigcal_observation *const o = &view->observations[i];
    if (!p->is_plain) {
        return rc_points_error2(p->points, p->cam_from_points, i);
    }
    rigcal_real x[3];
    rc_vec3_sub(x, o->X_w, p->points->origin);
    const rigcal_real Z = rc_vec3_dot(p->row[2], x) + p->shift[2];
    const rigcal_real du =
        rc_vec3_dot(p->row[0], x) + p->shift[0] - (o->uv[0] - camera->cx) * Z;
    const rigcal_real dv =
        rc_vec3_dot(p->row[1], x) + p->shift[1] - (o->uv[1] - camera->cy) * Z;
    const rigcal_real d2 = du * du + dv * dv;
    rigcal_real scale2 = Z * Z;
    if (view->sigma != NULL) {
        scale2 *= view->sigma[i] * view->sigma[i];
    }
    return (Z > 0 && d2 <= limit * scale2 && d2 <= RC_MAX) ? d2 / scale2 : RC_MAX;
}

/* ---- all points ---------------------------------------------------------- */

size_t rc_agree_score(rigcal_real *sum, const rigcal_points *points,
                      const rigcal_transform *cam_from_points, rigcal_real limit,
                      rigcal_real enough)
{
    RIGCAL_ASSERT(limit > 0);
    projection p;
    rigcal_real total = 0;
    size_t count = 0;
    project_by(&p, points, cam_from_points);
    for (size_t i = 0; i < points->view.n && total < enough; i++) {
        const rigcal_real d2 = off2(&p, i, limit);
        count += d2 <= limit;
        total += rc_min(d2, limit);
    }
    *sum = total;
    return count;
}

static void add_to(rc_agree_histogram *off, rigcal_real d2, rigcal_real limit)
{
    int k = 0;
    for (; k < RC_AGREE_BINS - 1 && d2 <= limit / 2; k++) {
        limit /= 2;
    }
    off->count[k]++;
    off->most[k] = rc_max(off->most[k], d2);
}

size_t rc_agree_mark(uint8_t marks[], rc_agree_histogram *off, const rigcal_points *points,
                     const rigcal_transform *cam_from_points, rigcal_real limit)
{
    RIGCAL_ASSERT(limit > 0);
    projection p;
    size_t changed = 0;
    project_by(&p, points, cam_from_points);
    if (off != NULL) {
        *off = (rc_agree_histogram){{0}, {0}};
    }
    for (size_t i = 0; i < points->view.n; i++) {
        const rigcal_real d2 = off2(&p, i, limit);
        const uint8_t is_near = d2 <= limit;
        changed += is_near != marks[i];
        marks[i] = is_near;
        if (is_near && off != NULL) {
            add_to(off, d2, limit);
        }
    }
    return changed;
}

/* ---- chance -------------------------------------------------------------- */

/* A pose that is fitted to k points takes 6 of their 2 k errors away: the distances are
 * larger by k / (k - 3), squared. Any k may be the one: n - 3 of them. */
static rigcal_real expected_of(size_t n, size_t k, rigcal_real d2, rigcal_real area)
{
    const rigcal_real fitted = (rigcal_real)k / (rigcal_real)(k - 3);
    const rigcal_real disc = RC_PI * d2 * fitted;
    const rigcal_real near = (disc < area) ? disc / area : 1;
    return (rigcal_real)(n - 3) * rc_expected_sets(n, k, near);
}

rigcal_real rc_agree_by_chance(const rc_agree_histogram *off, size_t n, rigcal_real area,
                               rigcal_real enough)
{
    rigcal_real least = RC_MAX;
    size_t k = 0;
    for (int bin = 0; bin < RC_AGREE_BINS; bin++) {
        k += off->count[bin];
    }
    for (int bin = 0; bin < RC_AGREE_BINS && k > 3 && !(least < enough); bin++) {
        if (off->count[bin] > 0) {
            least = rc_min(least, expected_of(n, k, off->most[bin], area));
        }
        k -= off->count[bin];
    }
    return least;
}
