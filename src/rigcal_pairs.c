#include "rc_pairs.h"

/* ---- constants ----------------------------------------------------------- */

/* part of the size, or sine: points or rays that are nearer are the same. */
#define SAME (8 * RC_EPS)

/* part of the length: a target that extends less across its length is a line. Rays that do
 * so are in a plane. A turn about the line would be noise. */
#define FLAT RC_TOL(1e-6, 1e-4)

/* part of the image that the target fills: pairs whose points are nearer are left out,
 * because the direction of their plane is mostly noise. Chosen on real targets: 0.1 to 0.25
 * do about as well, 0 and 0.4 do not. */
#define NEAR_PART (RC(1) / 6)

/* points: up to this many all pairs are taken. Of 9 points these are 4 for each. */
enum { ALL_PAIRS_UP_TO = 9 };

/* pairs: each point has this many, if there are more than ALL_PAIRS_UP_TO points. */
enum { PARTNERS = 4 };

/* rounds: those pairs are chosen in at most this many: 4, and as many again because pairs
 * may be left out. */
enum { ROUNDS_MAX = 8 };

/* 1: how far the square of a unit vector may be from 1. It allows for a vector that was
 * stored in single precision or as text. */
#define UNIT_TOL RC(0.002)

/* ---- checks -------------------------------------------------------------- */

static int is_unit(const rigcal_real a[3])
{
    return RC_FABS(rc_vec3_dot(a, a) - 1) <= UNIT_TOL;
}

static rigcal_status check_pair(const rigcal_pair *pair)
{
    if (!rc_all_finite(pair->normal, 3) || !rc_all_finite(pair->offset, 3)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    return (is_unit(pair->normal) && is_unit(pair->offset)) ? RIGCAL_OK : RIGCAL_ERR_RANGE;
}

rigcal_status rc_check_pairs(const rigcal_pair pairs[], size_t n_pairs, size_t n_least)
{
    if (pairs == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (n_pairs < n_least) {
        return RIGCAL_ERR_TOO_FEW;
    }
    if (n_pairs > PARTNERS * RC_COUNT_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    for (size_t i = 0; i < n_pairs; i++) {
        const rigcal_status status = check_pair(&pairs[i]);
        if (status != RIGCAL_OK) {
            return status;
        }
    }
    return RIGCAL_OK;
}

/* ---- pairs --------------------------------------------------------------- */

/* Distance between two rays as points of the unit sphere. */
static rigcal_real ray_distance(const rigcal_real ray_a[3], const rigcal_real ray_b[3])
{
    rigcal_real a[3], b[3], difference[3];
    (void)rc_vec3_unit(a, ray_a);
    (void)rc_vec3_unit(b, ray_b);
    rc_vec3_sub(difference, a, b);
    return rc_vec3_norm(difference);
}

static rigcal_real point_distance(const rigcal_real X_a[3], const rigcal_real X_b[3])
{
    rigcal_real difference[3];
    rc_vec3_sub(difference, X_a, X_b);
    return rc_vec3_norm(difference);
}

/* (11)..(13) for the points i and j. Returns 0 if the pair gives no equation. */
static int make_pair(rigcal_pair *pair, const rigcal_bearing bearings[], size_t i, size_t j)
{
    const rigcal_real *const X_i = bearings[i].X_w, *const X_j = bearings[j].X_w;
    rigcal_real m_i[3], m_j[3], normal[3], offset[3];

    (void)rc_vec3_unit(m_i, bearings[i].ray);
    (void)rc_vec3_unit(m_j, bearings[j].ray);
    rc_vec3_cross(normal, m_i, m_j);
    rc_vec3_sub(offset, X_i, X_j);
    const rigcal_real size = rc_max(rc_vec3_max_abs(X_i), rc_vec3_max_abs(X_j));
    if (!(rc_vec3_norm(normal) > SAME) || !(rc_vec3_max_abs(offset) > SAME * size)) {
        return 0;
    }
    (void)rc_vec3_unit(pair->normal, normal);
    (void)rc_vec3_unit(pair->offset, offset);
    pair->i = (int32_t)i;
    pair->j = (int32_t)j;
    return 1;
}

/* The index farthest from `from`, among the rays or among the points. */
static size_t farthest(const rigcal_bearing bearings[], size_t n, size_t from, int by_rays)
{
    const rigcal_bearing *const start = &bearings[from];
    size_t far = from;
    rigcal_real longest = 0;
    for (size_t i = 0; i < n; i++) {
        const rigcal_real d = by_rays ? ray_distance(bearings[i].ray, start->ray)
                                      : point_distance(bearings[i].X_w, start->X_w);
        if (d > longest) {
            longest = d;
            far = i;
        }
    }
    return far;
}

/* Checks that the points have a shape: at least three are different, not on one line, and
 * distinguished by the precision of their coordinates. */
static rigcal_status check_points_shape(const rigcal_bearing bearings[], size_t n)
{
    const size_t a = farthest(bearings, n, 0, 0);
    const size_t b = farthest(bearings, n, a, 0);
    const rigcal_real *const X_a = bearings[a].X_w, *const X_b = bearings[b].X_w;
    const rigcal_real length = point_distance(X_a, X_b);
    rigcal_real along[3], size = 0, width = 0;
    int others = 0;

    if (!(length > 0)) {
        return RIGCAL_ERR_COINCIDENT;
    }
    rc_vec3_sub(along, X_b, X_a);
    (void)rc_vec3_unit(along, along);
    for (size_t i = 0; i < n; i++) {
        const rigcal_real *const X = bearings[i].X_w;
        rigcal_real from_a[3], across[3];
        rc_vec3_sub(from_a, X, X_a);
        rc_vec3_cross(across, from_a, along);
        width = rc_max(width, rc_vec3_norm(across));
        size = rc_max(size, rc_vec3_max_abs(X));
        others += point_distance(X, X_a) > SAME * length &&
                  point_distance(X, X_b) > SAME * length;
    }
    if (!(size * RC_EPS <= RC_SHAPE_ROUNDING * length)) {
        return RIGCAL_ERR_PRECISION;
    }
    if (others == 0) {
        return RIGCAL_ERR_COINCIDENT;
    }
    return (width > FLAT * length + SAME * size) ? RIGCAL_OK : RIGCAL_ERR_COLLINEAR;
}

/* Checks that the rays are not in one plane. *extent is the size of the bundle, as a
 * distance on the unit sphere. */
static rigcal_status check_rays_shape(rigcal_real *extent, const rigcal_bearing bearings[],
                                      size_t n)
{
    const size_t a = farthest(bearings, n, 0, 1);
    const size_t b = farthest(bearings, n, a, 1);
    rigcal_real m_a[3], m_b[3], normal[3], height = 0;
    int others = 0;

    *extent = ray_distance(bearings[a].ray, bearings[b].ray);
    if (!(*extent > SAME)) {
        return RIGCAL_ERR_COINCIDENT;
    }
    (void)rc_vec3_unit(m_a, bearings[a].ray);
    (void)rc_vec3_unit(m_b, bearings[b].ray);
    rc_vec3_cross(normal, m_a, m_b); /* not 0: the rays differ, and all have z > 0 */
    (void)rc_vec3_unit(normal, normal);
    for (size_t i = 0; i < n; i++) {
        rigcal_real m[3];
        (void)rc_vec3_unit(m, bearings[i].ray);
        height = rc_max(height, RC_FABS(rc_vec3_dot(m, normal)));
        others += ray_distance(m, m_a) > SAME && ray_distance(m, m_b) > SAME;
    }
    if (others == 0) {
        return RIGCAL_ERR_COINCIDENT;
    }
    return (height > FLAT * *extent + SAME) ? RIGCAL_OK : RIGCAL_ERR_EDGE_ON;
}

/* A choice has at least this many pairs, one for each unknown angle. */
enum { PAIRS_LEAST = 3 };

/* The first pairs wait until there are enough of them: a call that fails writes nothing. */
typedef struct {
    rigcal_pair first[PAIRS_LEAST], *pairs;
    size_t n, capacity;
    const rigcal_bearing *bearings;
    rigcal_real nearest; /* least distance between the two rays */
} pair_list;

static void add_pair(pair_list *list, size_t i, size_t j)
{
    const rigcal_bearing *const s = list->bearings;
    rigcal_pair *const to =
        (list->n < PAIRS_LEAST) ? &list->first[list->n] : &list->pairs[list->n];
    if (list->n < list->capacity && ray_distance(s[i].ray, s[j].ray) >= list->nearest &&
        make_pair(to, s, i, j)) {
        list->n++;
    }
}

/* Adds every pair once, those of distant indices first. */
static void add_all_pairs(pair_list *list, size_t n)
{
    for (size_t apart = n - 1; apart >= 1; apart--) {
        for (size_t i = 0; i + apart < n; i++) {
            add_pair(list, i, i + apart);
        }
    }
}

/* An order of the points that is fixed but irregular. A linear congruential generator of
 * full period 2^k >= n (Hull and Dobell 1962) gives every index below n once a period. The
 * other numbers are skipped. */
typedef struct {
    uint32_t state, mask;
    size_t n;
} disorder;

static disorder disorder_of(size_t n)
{
    disorder d = {0, 1, n};
    while ((size_t)d.mask < n - 1) {
        d.mask = 2 * d.mask + 1;
    }
    return d;
}

static size_t next_of(disorder *d)
{
    do {
        d->state = (d->state * UINT32_C(1664525) + UINT32_C(1013904223)) & d->mask;
    } while ((size_t)d->state >= d->n);
    return (size_t)d->state;
}

/* Round r pairs every point with the one r places later in this order, so no pair comes
 * twice. On a grid of points the pairs run in all directions; with constant steps of the
 * index they would not. Four rounds fill the list unless pairs are left out. */
static void add_spread_pairs(pair_list *list, size_t n)
{
    for (size_t round = 1; round <= ROUNDS_MAX && 2 * round < n; round++) {
        disorder order = disorder_of(n);
        size_t passed[ROUNDS_MAX];
        for (size_t i = 0; i < n + round && list->n < PARTNERS * n; i++) {
            const size_t at = next_of(&order);
            if (i >= round) {
                add_pair(list, passed[i % round], at);
            }
            passed[i % round] = at;
        }
    }
}

/* How well two pairs together fix an angle. It is large if both are long in the image and
 * if their planes and offsets have different directions. */
static rigcal_real joint_worth(const rigcal_pair *first, const rigcal_pair *second,
                               const rigcal_bearing bearings[])
{
    rigcal_real across_normals[3], across_offsets[3];
    rc_vec3_cross(across_normals, first->normal, second->normal);
    rc_vec3_cross(across_offsets, first->offset, second->offset);
    return rc_vec3_norm(across_normals) * rc_vec3_norm(across_offsets) *
           ray_distance(bearings[second->i].ray, bearings[second->j].ray);
}

static void swap_pairs(rigcal_pair *a, rigcal_pair *b)
{
    const rigcal_pair kept = *a;
    *a = *b;
    *b = kept;
}

/* Puts the pair that is longest in the image first, then its best partner. */
static void put_best_first(pair_list *list)
{
    rigcal_pair *const pairs = list->pairs;
    const rigcal_bearing *const s = list->bearings;
    size_t best = 0;
    rigcal_real most = 0;
    for (size_t i = 0; i < list->n; i++) {
        const rigcal_real d = ray_distance(s[pairs[i].i].ray, s[pairs[i].j].ray);
        if (d > most) {
            most = d;
            best = i;
        }
    }
    swap_pairs(&pairs[0], &pairs[best]);
    best = 1;
    most = 0;
    for (size_t i = 1; i < list->n; i++) {
        const rigcal_real worth = joint_worth(&pairs[0], &pairs[i], s);
        if (worth > most) {
            most = worth;
            best = i;
        }
    }
    swap_pairs(&pairs[1], &pairs[best]);
}

static void add_pairs(pair_list *list, size_t n)
{
    list->n = 0;
    if (n <= ALL_PAIRS_UP_TO) {
        add_all_pairs(list, n);
    } else {
        add_spread_pairs(list, n);
    }
}

/* ---- public -------------------------------------------------------------- */

size_t rigcal_pairs_for(size_t n)
{
    return RIGCAL_PAIRS_FOR(n);
}

rigcal_status rigcal_pair_make(rigcal_pair *pair, const rigcal_bearing bearings[], size_t n,
                               int32_t i, int32_t j)
{
    if (pair == NULL || bearings == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (n > RC_COUNT_MAX || i < 0 || j < 0 || i == j || (size_t)i >= n || (size_t)j >= n) {
        return RIGCAL_ERR_RANGE;
    }
    rigcal_status status = rc_check_bearing(&bearings[i], 0);
    if (status == RIGCAL_OK) {
        status = rc_check_bearing(&bearings[j], 0);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    return make_pair(pair, bearings, (size_t)i, (size_t)j) ? RIGCAL_OK
                                                           : RIGCAL_ERR_COINCIDENT;
}

rigcal_status rigcal_pairs_choose(rigcal_pair pairs[], size_t capacity, size_t *n_pairs,
                                  const rigcal_bearing bearings[], size_t n)
{
    if (pairs == NULL || n_pairs == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_real extent;
    rigcal_status status = rc_check_bearings(bearings, n, 1);
    if (status == RIGCAL_OK && n < 3) {
        status = RIGCAL_ERR_TOO_FEW;
    }
    if (status == RIGCAL_OK && capacity < PAIRS_LEAST) {
        status = RIGCAL_ERR_CAPACITY;
    }
    if (status == RIGCAL_OK) {
        status = check_points_shape(bearings, n);
    }
    if (status == RIGCAL_OK) {
        status = check_rays_shape(&extent, bearings, n);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    pair_list list;
    list.pairs = pairs;
    list.capacity = capacity;
    list.bearings = bearings;
    list.nearest = NEAR_PART * extent;
    add_pairs(&list, n);
    if (list.n < PAIRS_LEAST) { /* few points, some of them near: takes near pairs too */
        list.nearest = 0;
        add_pairs(&list, n);
    }
    if (list.n < PAIRS_LEAST) {
        return RIGCAL_ERR_COINCIDENT;
    }
    for (int k = 0; k < PAIRS_LEAST; k++) {
        pairs[k] = list.first[k];
    }
    put_best_first(&list);
    *n_pairs = list.n;
    return RIGCAL_OK;
}
