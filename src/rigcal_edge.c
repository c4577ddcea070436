#include "rc_edge.h"

#include "rc_lens.h"

/* ---- constants ----------------------------------------------------------- */

/* px: a place of a border is final if the last correction was no more. The next one would
 * be some hundredths of it. */
#define SETTLED_PX RC_TOL(1e-5, 0.05)

/* rounds: the most to find a place of a border, usually 1 or 2. Where the lens folds, all
 * are used. */
enum { ROUNDS_MAX = 24 };

/* 1: a height over the line, as a tangent, above which it is proved that the lens sees the
 * place. */
#define LEAP RC(0.05)

/* ---- a place of the band -------------------------------------------------- */

/* (M6) The height of the border on this side over the line at p, in the direction `normal`.
 * It is the root of A h^2 - 2 k^2 b h - k^2 (a + sigma_b^2 slope2) = 0 with the sign of the
 * side. */
static rigcal_real height_at(const rigcal_edge *e, const rigcal_real p[2],
                             rigcal_real slope2)
{
    const rigcal_real *const M = e->band.Sigma_line;
    const rigcal_real k2 = e->band.k * e->band.k;
    const rigcal_real a = p[0] * (p[0] * M[0] + 2 * p[1] * M[1]) + p[1] * p[1] * M[3];
    const rigcal_real b = k2 * (p[0] * M[2] + p[1] * M[4]);
    const rigcal_real c = k2 * (a + e->band.sigma_b * e->band.sigma_b * slope2);
    const rigcal_real root = RC_SQRT(rc_max(b * b + e->A * c, 0));
    return (b + ((e->side == 0) ? root : -root)) / e->A;
}

static void direction_at(rigcal_real m[3], const rigcal_edge *e, const rigcal_real p[2],
                         rigcal_real height)
{
    rc_vec3_combine(m, p[0], e->band.ray, p[1], e->band.towards);
    rc_vec3_add_scaled(m, height, e->normal);
}

/* Projects the place of the band at this height over p. Far from the line it also proves
 * that the lens sees it: between two places a fold may have been passed unnoticed. */
static rigcal_status place_at(rigcal_real uv[2], rigcal_real J[6], rigcal_real D[2][3],
                              const rigcal_edge *e, const rigcal_real p[2],
                              rigcal_real height)
{
    rigcal_real m[3], again[2];
    direction_at(m, e, p, height);
    const rigcal_status status =
        rc_band_place(uv, J, D, &e->band.camera_b, e->is_pinhole, m);
    return (status == RIGCAL_OK && RC_FABS(height) > LEAP)
               ? rc_project_usable(again, &e->band.camera_b, m)
               : status;
}

rigcal_status rc_edge_pixel(rigcal_real uv[2], const rigcal_edge *e, const rigcal_real p[2],
                            rigcal_real height)
{
    rigcal_real J[6], D[2][3];
    return place_at(uv, J, D, e, p, height);
}

/* (M6) The squared slope of the distance from the line by a pixel of b. */
static rigcal_real slope2_of(const rigcal_edge *e, rigcal_real D[2][3])
{
    const rigcal_real du = rc_vec3_dot(D[0], e->band.line);
    const rigcal_real dv = rc_vec3_dot(D[1], e->band.line);
    return du * du + dv * dv;
}

/* ---- begin ---------------------------------------------------------------- */

int rc_edge_begin(rigcal_edge *e, const rigcal_band *band)
{
    e->band = *band;
    e->is_pinhole = rc_lens_is_pinhole(&band->camera_b);
    rc_vec3_scale(e->normal, 1 / band->across, band->line);
    e->A = band->across * band->across - band->k * band->k * band->Sigma_line[5];
    return e->A > 0;
}

int rc_edge_begin_side(rigcal_edge *e, int side, const rigcal_real p[2])
{
    rigcal_real uv[2], J[6], D[2][3], m[3];
    e->side = side;
    direction_at(m, e, p, 0);
    if (!rc_lens_is_fisheye(&e->band.camera_b) && !(m[2] > RC_FORWARD_LEAST)) {
        return 0; /* beside or behind the camera, to rounding */
    }
    if ((side == 0 && rc_project_usable(uv, &e->band.camera_b, m) != RIGCAL_OK) ||
        place_at(uv, J, D, e, p, 0) != RIGCAL_OK) {
        return 0;
    }
    e->slope2 = slope2_of(e, D);
    return 1;
}

/* ---- a place of the border ------------------------------------------------ */

/* One try of a border: the height h, the height `wish` that follows from the slope there,
 * and the move in pixels between them. */
typedef struct {
    rigcal_real uv[2], J[6], h, wish, move[2], speed, slope2; /* speed: px per unit of h */
} trial;

static rigcal_status try_height(trial *at, const rigcal_edge *e, const rigcal_real p[2],
                                rigcal_real h)
{
    rigcal_real D[2][3];
    const rigcal_status status = place_at(at->uv, at->J, D, e, p, h);
    if (status != RIGCAL_OK) {
        return status;
    }
    at->slope2 = slope2_of(e, D);
    at->h = h;
    at->wish = height_at(e, p, at->slope2);
    const rigcal_real du = rc_vec3_dot(&at->J[0], e->normal);
    const rigcal_real dv = rc_vec3_dot(&at->J[3], e->normal);
    at->speed = rc_max(RC_FABS(du), RC_FABS(dv));
    at->move[0] = (at->wish - h) * du;
    at->move[1] = (at->wish - h) * dv;
    return rc_is_finite(at->uv[0] + at->uv[1] + at->move[0] + at->move[1])
               ? RIGCAL_OK
               : RIGCAL_ERR_NO_RAY;
}

/* Finds the height of the border of this side over p. The noise of b's pixels weighs by the
 * slope at the place itself, so the height is computed again until it stays. If the lens
 * folds before, the border is the fold. It lies between a height that the lens sees and one
 * that it does not see; these two are brought together. Returns 0 if there is no border. */
static int find_height(trial *found, const rigcal_edge *e, const rigcal_real p[2],
                       rigcal_real slope2)
{
    const rigcal_real out = (e->side == 0) ? 1 : -1;
    rigcal_real h = height_at(e, p, slope2), beyond = out * RC_MAX;
    trial now, inside = {.speed = RC_MAX}; /* all fields are written, because it is
                                              copied */
    int has_inside = 0;
    for (int i = 0; i < ROUNDS_MAX; i++) {
        const int is_seen = try_height(&now, e, p, h) == RIGCAL_OK;
        const rigcal_real px =
            is_seen ? rc_max(RC_FABS(now.move[0]), RC_FABS(now.move[1])) : RC_MAX;
        if (px <= SETTLED_PX) {
            inside = now;
            has_inside = 1;
            break;
        }
        if (is_seen && out * (now.wish - h) > 0) {
            inside = now;
            has_inside = 1;
        } else {
            beyond = h;
        }
        const rigcal_real low = has_inside ? inside.h : 0; /* the line itself */
        if (!has_inside && !is_seen && !(RC_FABS(h) > 0)) {
            break;
        }
        if (has_inside && out * (beyond - low) * inside.speed <= SETTLED_PX) {
            break;
        }
        h = is_seen ? now.wish : low;
        if (has_inside && (!(out * (h - low) > 0) || !(out * (beyond - h) > 0))) {
            h = (low + beyond) / 2;
        }
    }
    *found = inside;
    return has_inside;
}

rigcal_status rc_edge_find(rigcal_real uv[2], rigcal_real J[6], rigcal_edge *e,
                           const rigcal_real p[2])
{
    const rigcal_real p2 = p[0] * p[0] + p[1] * p[1];
    trial inside;
    if (!find_height(&inside, e, p, e->slope2 * p2)) {
        return RIGCAL_ERR_NO_RAY;
    }
    const rigcal_real px = rc_max(RC_FABS(inside.move[0]), RC_FABS(inside.move[1]));
    const int is_settled = px <= SETTLED_PX;
    for (int i = 0; i < 6; i++) {
        J[i] = inside.J[i];
    }
    uv[0] = inside.uv[0] + (is_settled ? inside.move[0] : 0);
    uv[1] = inside.uv[1] + (is_settled ? inside.move[1] : 0);
    e->height = is_settled ? inside.wish : inside.h;
    e->slope2 = inside.slope2 / p2;
    return RIGCAL_OK;
}
