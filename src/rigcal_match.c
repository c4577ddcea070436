#include "rc_band.h"

/* ---- the curve ----------------------------------------------------------- */

/* The point at the distance d is X = d ray + t = (d + along) ray + across towards. So its
 * direction p is along (d + along, across). */
void rc_band_direction(rigcal_real out[2], const rigcal_band *band, rigcal_real depth)
{
    const rigcal_real X[3] = {depth + band->along, band->across, 0};
    rigcal_real unit[3] = {1, 0, 0};
    (void)rc_vec3_unit(unit, X);
    out[0] = unit[0];
    out[1] = unit[1];
}

void rc_band_ends(rigcal_real ends[2][2], const rigcal_band *band)
{
    ends[0][0] = 1;
    ends[0][1] = 0;
    if (band->far_a > 0) {
        rc_band_direction(ends[0], band, band->far_a);
    }
    rc_band_direction(ends[1], band, band->near_a);
}

/* The place of the line in the direction p. RIGCAL_OK, or the error there. */
static rigcal_status place_on_line(rigcal_band_point *point, const rigcal_band *band,
                                   const rigcal_real p[2])
{
    rigcal_real direction[3], m[3], J[6], D[2][3];
    rigcal_match match;
    rigcal_ray ray;
    rc_vec3_combine(direction, p[0], band->ray, p[1], band->towards);
    if (!rc_vec3_unit(m, direction)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    rigcal_status status = rc_project_usable(point->uv, &band->camera_b, m);
    if (status == RIGCAL_OK) {
        status = rc_band_place(point->uv, J, D, &band->camera_b,
                               rc_lens_is_pinhole(&band->camera_b), m);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_vec3_copy(ray.m, m);
    for (int i = 0; i < 3; i++) {
        ray.D[2 * i] = D[0][i];
        ray.D[2 * i + 1] = D[1][i];
    }
    status = rc_band_test(&match, band, &ray);
    if (status != RIGCAL_OK && status != RIGCAL_ERR_PARALLEL) {
        return status;
    }
    const rigcal_real g[3] = {rc_vec3_dot(D[0], band->line), rc_vec3_dot(D[1], band->line),
                              0};
    const rigcal_real slope = rc_vec3_norm(g);
    point->across[0] = g[0] / slope;
    point->across[1] = g[1] / slope;
    point->half_width = match.half_width_px;
    point->depth_a = (status == RIGCAL_OK) ? match.depth_a : 0;
    return RIGCAL_OK;
}

rigcal_status rigcal_band_curve(rigcal_band_point points[], size_t capacity,
                                size_t *n_written, const rigcal_band *band)
{
    if (points == NULL || n_written == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = rc_band_check(band);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (capacity < 2 || capacity > RC_COUNT_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    rigcal_real ends[2][2];
    size_t written = 0;
    rc_band_ends(ends, band);
    for (size_t i = 0; i < capacity; i++) {
        const rigcal_real far = (rigcal_real)i / (rigcal_real)(capacity - 1);
        const rigcal_real p[2] = {far * ends[0][0] + (1 - far) * ends[1][0],
                                  far * ends[0][1] + (1 - far) * ends[1][1]};
        rigcal_band_point point;
        if (place_on_line(&point, band, p) == RIGCAL_OK) {
            points[written] = point;
            written++;
        }
    }
    if (written == 0) {
        return RIGCAL_ERR_OUTSIDE;
    }
    *n_written = written;
    return RIGCAL_OK;
}

/* ---- many candidates ----------------------------------------------------- */

/* The candidates. One of the two pointers is not NULL. */
typedef struct {
    const rigcal_real *uv;
    const rigcal_ray *rays;
} candidates;

/* Inserts *match into the first *n of matches[capacity], sorted by score, the least first.
 * Of equal scores the one that came first stays first. */
static void sort_in(rigcal_match matches[], size_t capacity, size_t *n,
                    const rigcal_match *match)
{
    size_t at = *n;
    if (*n == capacity) {
        if (!(match->score < matches[capacity - 1].score)) {
            return;
        }
        at--;
    } else {
        (*n)++;
    }
    for (; at > 0 && match->score < matches[at - 1].score; at--) {
        matches[at] = matches[at - 1];
    }
    matches[at] = *match;
}

static rigcal_status test_candidate(rigcal_match *match, const rigcal_band *band,
                                    const candidates *from, size_t i)
{
    rigcal_ray ray;
    if (from->rays != NULL) {
        return rc_band_test(match, band, &from->rays[i]);
    }
    const rigcal_status status = rigcal_ray_make(&ray, &band->camera_b, &from->uv[2 * i]);
    return (status == RIGCAL_OK) ? rc_band_test(match, band, &ray) : status;
}

static rigcal_status check_candidates(int32_t *at_fault, const candidates *from, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const rigcal_status status = (from->rays != NULL)
                                         ? rc_ray_check(&from->rays[i])
                                         : rc_check_pixel(&from->uv[2 * i]);
        if (status != RIGCAL_OK) {
            rc_write_fault(at_fault, (int32_t)i);
            return status;
        }
    }
    return RIGCAL_OK;
}

static rigcal_status search(rigcal_match matches[], size_t capacity, size_t *n_written,
                            size_t *n_inside, int32_t *at_fault, const rigcal_band *band,
                            const candidates *from, size_t n)
{
    rc_write_fault(at_fault, -1);
    if (n_written == NULL || n_inside == NULL || (matches == NULL && capacity > 0)) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_band_check(band);
    if (status == RIGCAL_OK && (n > RC_COUNT_MAX || capacity > RC_COUNT_MAX)) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK) {
        status = check_candidates(at_fault, from, n);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    size_t written = 0, inside = 0;
    for (size_t i = 0; i < n; i++) {
        rigcal_match match;
        if (test_candidate(&match, band, from, i) == RIGCAL_OK && match.is_inside) {
            match.index = (int32_t)i;
            inside++;
            if (capacity > 0) {
                sort_in(matches, capacity, &written, &match);
            }
        }
    }
    *n_written = written;
    *n_inside = inside;
    return RIGCAL_OK;
}

rigcal_status rigcal_band_search(rigcal_match matches[], size_t capacity, size_t *n_written,
                                 size_t *n_inside, int32_t *at_fault,
                                 const rigcal_band *band, const rigcal_real uv_b[],
                                 size_t n)
{
    const candidates from = {uv_b, NULL};
    if (uv_b == NULL) {
        rc_write_fault(at_fault, -1);
        return RIGCAL_ERR_NULL;
    }
    return search(matches, capacity, n_written, n_inside, at_fault, band, &from, n);
}

rigcal_status rigcal_band_search_rays(rigcal_match matches[], size_t capacity,
                                      size_t *n_written, size_t *n_inside,
                                      int32_t *at_fault, const rigcal_band *band,
                                      const rigcal_ray rays_b[], size_t n)
{
    const candidates from = {NULL, rays_b};
    if (rays_b == NULL) {
        rc_write_fault(at_fault, -1);
        return RIGCAL_ERR_NULL;
    }
    return search(matches, capacity, n_written, n_inside, at_fault, band, &from, n);
}
