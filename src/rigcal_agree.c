#include "rc_agree.h"

/* The base of natural logarithms. */
#define RC_E RC(2.718281828459045235360287471352662498)

/* ---- one point ----------------------------------------------------------- */

/* A pose as rows that project the points of a pinhole: they take x to Z u, Z v and Z. */
typedef struct {
    rigcal_real row[3][3], shift[3];
} projection;

static void project_by(projection *p, const rigcal_points *points,
                       const rigcal_transform *T)
{
    const rigcal_camera *const c = points->view.camera;
    const rigcal_real focal[2] = {c->fx, c->fy}, middle[2] = {c->cx, c->cy};
    rc_vec3_copy(p->row[2], &T->R[6]);
    p->shift[2] = T->t[2];
    for (int k = 0; k < 2; k++) {
        rc_vec3_combine(p->row[k], focal[k], &T->R[3 * k], middle[k], &T->R[6]);
        p->shift[k] = focal[k] * T->t[k] + middle[k] * T->t[2];
    }
}

/* Squared distance over sigma_i^2, or something above the limit. A point that is too far
 * off costs no division. If it is too far off in u alone, v is not computed. */
RIGCAL_FORCE_INLINE static inline rigcal_real off2(const projection *p,
                                                   const rigcal_points *points, size_t i,
                                                   rigcal_real limit)
{
    const rigcal_observation *const o = &points->view.observations[i];
    const rigcal_real *const sigma = points->view.sigma;
    rigcal_real x[3];
    rc_vec3_sub(x, o->X_w, points->origin);
    const rigcal_real Z = rc_vec3_dot(p->row[2], x) + p->shift[2];
    const rigcal_real du = rc_vec3_dot(p->row[0], x) + p->shift[0] - o->uv[0] * Z;
    const rigcal_real by2 = (sigma == NULL) ? Z * Z : Z * Z * (sigma[i] * sigma[i]);
    const rigcal_real most = limit * by2;
    if (!(du * du <= most && Z > 0)) {
        return RC_MAX;
    }
    const rigcal_real dv = rc_vec3_dot(p->row[1], x) + p->shift[1] - o->uv[1] * Z;
    const rigcal_real d2 = du * du + dv * dv;
    return (d2 <= most && d2 <= RC_MAX) ? d2 / by2 : RC_MAX;
}

/* ---- all points ---------------------------------------------------------- */

RIGCAL_FORCE_INLINE static inline size_t score(rigcal_real *sum,
                                               const rigcal_points *points,
                                               const rigcal_transform *T, rigcal_real limit,
                                               rigcal_real enough, int is_pinhole)
{
    projection p;
    rigcal_real total = 0;
    size_t count = 0;
    if (is_pinhole) {
        project_by(&p, points, T);
    }
    for (size_t i = 0; i < points->view.n && total < enough; i++) {
        const rigcal_real d2 =
            is_pinhole ? off2(&p, points, i, limit) : rc_points_error2(points, T, i);
        count += d2 <= limit;
        total += rc_min(d2, limit);
    }
    *sum = total;
    return count;
}

size_t rc_agree_score(rigcal_real *sum, const rigcal_points *points,
                      const rigcal_transform *cam_from_points, rigcal_real limit,
                      rigcal_real enough)
{
    RIGCAL_ASSERT(limit > 0 && !points->is_mirrored);
    return points->is_pinhole ? score(sum, points, cam_from_points, limit, enough, 1)
                              : score(sum, points, cam_from_points, limit, enough, 0);
}

static void add_to(rc_agree_histogram *off, rigcal_real d2, rigcal_real limit)
{
    int k = 0;
    for (; k < RC_AGREE_BINS - 1 && d2 <= limit / 2; k++) {
        limit /= 2;
    }
    off->count[k]++;
    off->sum[k] += d2;
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
        if (marks[i] == RC_AGREE_NO_RAY) {
            continue;
        }
        const rigcal_real d2 = points->is_pinhole
                                   ? off2(&p, points, i, limit)
                                   : rc_points_error2(points, cam_from_points, i);
        const uint8_t is_near = d2 <= limit;
        changed += is_near != marks[i];
        marks[i] = is_near;
        if (is_near && off != NULL) {
            add_to(off, d2, limit);
        }
    }
    return changed;
}

/* ---- where the points lie ----------------------------------------------------- */

typedef struct {
    rigcal_real low[2], high[2];
} box;

static void box_clear(box *b)
{
    *b = (box){{RC_MAX, RC_MAX}, {-RC_MAX, -RC_MAX}};
}

static void box_add(box *b, const rigcal_real uv[2])
{
    for (int k = 0; k < 2; k++) {
        b->low[k] = rc_min(b->low[k], uv[k]);
        b->high[k] = rc_max(b->high[k], uv[k]);
    }
}

/* Where the points were seen. It exceeds the image by at most the image's size. Else one
 * wrong pixel could make it as large as it likes. */
static void box_of_seen(box *b, const rigcal_view *view)
{
    const int32_t size[2] = {view->camera->width, view->camera->height};
    box_clear(b);
    for (size_t i = 0; i < view->n; i++) {
        box_add(b, view->observations[i].uv);
    }
    for (int k = 0; k < 2; k++) {
        const rigcal_real side = (rigcal_real)size[k];
        b->low[k] = rc_min(rc_max(b->low[k], -side), 2 * side);
        b->high[k] = rc_max(rc_min(b->high[k], 2 * side), -side);
    }
}

static rigcal_real box_area(const box *b)
{
    return rc_max(b->high[0] - b->low[0], 0) * rc_max(b->high[1] - b->low[1], 0);
}

rigcal_real rc_agree_area(const rigcal_view *view)
{
    box seen;
    rigcal_real variances = 0;
    box_of_seen(&seen, view);
    for (size_t i = 0; i < view->n; i++) {
        variances += (view->sigma == NULL) ? 1 : view->sigma[i] * view->sigma[i];
    }
    return box_area(&seen) * (rigcal_real)view->n / variances;
}

rigcal_real rc_agree_misfit(const rigcal_points *points,
                            const rigcal_transform *cam_from_points)
{
    box seen, target, common;
    box_of_seen(&seen, &points->view);
    box_clear(&target);
    for (size_t i = 0; i < points->view.n; i++) {
        rigcal_real q[3], X_c[3], uv[2], J[6];
        rc_points_place(q, X_c, points, cam_from_points, i);
        if (rc_project_through(uv, J, points->view.camera, points->is_pinhole, X_c) !=
            RIGCAL_OK) { /* to prove that the lens sees it would cost twice as much */
            return 1;
        }
        box_add(&target, uv);
    }
    for (int k = 0; k < 2; k++) {
        common.low[k] = rc_max(seen.low[k], target.low[k]);
        common.high[k] = rc_min(seen.high[k], target.high[k]);
    }
    const rigcal_real shared = box_area(&common);
    const rigcal_real all = box_area(&seen) + box_area(&target) - shared;
    return (shared < all) ? 1 - shared / all : 0;
}

int rc_agree_differ(const rigcal_transform *a, const rigcal_transform *b, rigcal_real most)
{
    rigcal_real turn2 = 0, step[3];
    for (int k = 0; k < 9; k++) {
        turn2 += (a->R[k] - b->R[k]) * (a->R[k] - b->R[k]);
    }
    rc_vec3_sub(step, a->t, b->t);
    return turn2 > 2 * most * most ||
           rc_vec3_dot(step, step) > most * most * rc_vec3_dot(a->t, a->t);
}

/* ---- chance -------------------------------------------------------------- */

/* Poses expected by chance. A pose that is fitted to k points leaves 2 k - 6 free errors,
 * as many as k - 3 points have. The chance that their squares come to no more than `sum` is
 * (pi sum / area)^(k - 3) / (k - 3)!, with Stirling's factorial. Any k may be the best:
 * there are n - 3 of them. */
static rigcal_real expected_of(size_t n, size_t k, rigcal_real sum, rigcal_real area)
{
    const rigcal_real free = (rigcal_real)(k - 3);
    const rigcal_real disc = RC_E * RC_PI * sum / free;
    const rigcal_real near = (disc < area) ? disc / area : 1;
    return (rigcal_real)(n - 3) * rc_expected_sets(n, k, near) / RC_SQRT(2 * RC_PI * free);
}

rigcal_real rc_agree_by_chance(const rc_agree_histogram *off, size_t n, rigcal_real area,
                               rigcal_real enough)
{
    rigcal_real least = RC_MAX, sum[RC_AGREE_BINS], total = 0;
    size_t k = 0;
    for (int bin = RC_AGREE_BINS - 1; bin >= 0; bin--) {
        k += off->count[bin];
        total += off->sum[bin];
        sum[bin] = total;
    }
    for (int bin = 0; bin < RC_AGREE_BINS && k > 3 && !(least < enough); bin++) {
        if (off->count[bin] > 0) {
            least = rc_min(least, expected_of(n, k, sum[bin], area));
        }
        k -= off->count[bin];
    }
    return least;
}
