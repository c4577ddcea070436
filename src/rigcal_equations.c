#include "rc_equations.h"

/* Points whose distance, or rays whose sine, is below this many roundings are the
 * same. */
#define SAME (8 * RC_EPS)

/* A target is a line, or its rays a plane, when nothing stands farther out than
 * this part of its length: the turn about the line would be noise. */
#define FLAT RC_TOL(1e-6, 1e-4)

/* Pairs nearer than this part of the image that the target fills are left out:
 * the direction of their plane is mostly noise. Chosen on real targets; 0.1 to
 * 0.25 do about as well, 0 and 0.4 do not. */
#define NEAR_PART (RC(1) / 6)

/* Least difference of two normalised coordinates that (10a), (10b) divide by. */
#define SPREAD_MIN RC_TOL(1e-9, 1e-4)

enum { PARTNERS = 4, ROUNDS_MAX = 8, ALL_PAIRS_UP_TO = 9 };

/* ---- checks -------------------------------------------------------------- */

static rigcal_status check_sighting(const rigcal_sighting *sighting, int need_z)
{
    if (!rc_all_finite(sighting->X_w, 3) || !rc_all_finite(sighting->ray, 3)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    if (!rc_all_within(sighting->X_w, 3, RC_COORDINATE_MAX) ||
        !(rc_vec3_max_abs(sighting->ray) > 0)) {
        return RIGCAL_ERR_RANGE;
    }
    if (need_z && !(sighting->ray[2] >
                    RC_EPS * rc_vec3_max_abs(sighting->ray))) {
        return RIGCAL_ERR_WIDE_RAY;
    }
    return RIGCAL_OK;
}

rigcal_status rc_check_sightings(const rigcal_sighting sightings[], size_t n,
                                 int need_z)
{
    if (sightings == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (n > RC_COUNT_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    for (size_t i = 0; i < n; i++) {
        const rigcal_status status = check_sighting(&sightings[i], need_z);
        if (status != RIGCAL_OK) {
            return status;
        }
    }
    return RIGCAL_OK;
}

/* The slack is for a vector that was stored in single precision or as text. */
static int is_unit(const rigcal_real a[3])
{
    return RC_FABS(rc_vec3_dot(a, a) - 1) <= RC(0.002);
}

static rigcal_status check_pair(const rigcal_pair *pair)
{
    if (!rc_all_finite(pair->normal, 3) || !rc_all_finite(pair->offset, 3)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    return (is_unit(pair->normal) && is_unit(pair->offset)) ? RIGCAL_OK
                                                            : RIGCAL_ERR_RANGE;
}

rigcal_status rc_check_pairs(const rigcal_pair pairs[], size_t n_pairs,
                             size_t n_least)
{
    if (pairs == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (n_pairs < n_least) {
        return RIGCAL_ERR_TOO_FEW;
    }
    if (n_pairs > 4 * RC_COUNT_MAX) {
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

/* Distance of two rays as points of the unit sphere. */
static rigcal_real ray_distance(const rigcal_real ray_a[3],
                                const rigcal_real ray_b[3])
{
    rigcal_real a[3], b[3], difference[3];
    (void)rc_vec3_unit(a, ray_a);
    (void)rc_vec3_unit(b, ray_b);
    rc_vec3_sub(difference, a, b);
    return rc_vec3_norm(difference);
}

static rigcal_real point_distance(const rigcal_real X_a[3],
                                  const rigcal_real X_b[3])
{
    rigcal_real difference[3];
    rc_vec3_sub(difference, X_a, X_b);
    return rc_vec3_norm(difference);
}

/* (11)..(13) for the points i and j. 0: the pair carries no equation. */
static int make_pair(rigcal_pair *pair, const rigcal_sighting sightings[],
                     size_t i, size_t j)
{
    const rigcal_real *const X_i = sightings[i].X_w, *const X_j = sightings[j].X_w;
    rigcal_real m_i[3], m_j[3], normal[3], offset[3];

    (void)rc_vec3_unit(m_i, sightings[i].ray);
    (void)rc_vec3_unit(m_j, sightings[j].ray);
    rc_vec3_cross(normal, m_i, m_j);
    rc_vec3_sub(offset, X_i, X_j);
    const rigcal_real size = rc_max(rc_vec3_max_abs(X_i), rc_vec3_max_abs(X_j));
    if (!(rc_vec3_norm(normal) > SAME) ||
        !(rc_vec3_max_abs(offset) > SAME * size)) {
        return 0;
    }
    (void)rc_vec3_unit(pair->normal, normal);
    (void)rc_vec3_unit(pair->offset, offset);
    pair->i = (int32_t)i;
    pair->j = (int32_t)j;
    return 1;
}

/* The index farthest from `from`, among the points or among the rays. */
static size_t farthest_point(const rigcal_sighting sightings[], size_t n,
                             size_t from)
{
    size_t far = from;
    rigcal_real longest = 0;
    for (size_t i = 0; i < n; i++) {
        const rigcal_real d =
            point_distance(sightings[i].X_w, sightings[from].X_w);
        if (d > longest) {
            longest = d;
            far = i;
        }
    }
    return far;
}

static size_t farthest_ray(const rigcal_sighting sightings[], size_t n,
                           size_t from)
{
    size_t far = from;
    rigcal_real longest = 0;
    for (size_t i = 0; i < n; i++) {
        const rigcal_real d = ray_distance(sightings[i].ray, sightings[from].ray);
        if (d > longest) {
            longest = d;
            far = i;
        }
    }
    return far;
}

/* Whether the points have a shape: three of them, not on a line, and told apart
 * by the precision of their coordinates. */
static rigcal_status check_points_shape(const rigcal_sighting sightings[],
                                        size_t n)
{
    const size_t a = farthest_point(sightings, n, 0);
    const size_t b = farthest_point(sightings, n, a);
    const rigcal_real *const X_a = sightings[a].X_w, *const X_b = sightings[b].X_w;
    const rigcal_real length = point_distance(X_a, X_b);
    rigcal_real along[3], size = 0, width = 0;
    int others = 0;

    if (!(length > 0)) {
        return RIGCAL_ERR_COINCIDENT;
    }
    rc_vec3_sub(along, X_b, X_a);
    (void)rc_vec3_unit(along, along);
    for (size_t i = 0; i < n; i++) {
        const rigcal_real *const X = sightings[i].X_w;
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
    return (width > FLAT * length + SAME * size) ? RIGCAL_OK
                                                 : RIGCAL_ERR_COLLINEAR;
}

/* Whether the rays span space. *extent gets the size of the bundle, as a distance
 * on the unit sphere. */
static rigcal_status check_rays_shape(rigcal_real *extent,
                                      const rigcal_sighting sightings[], size_t n)
{
    const size_t a = farthest_ray(sightings, n, 0);
    const size_t b = farthest_ray(sightings, n, a);
    rigcal_real m_a[3], m_b[3], normal[3], height = 0;
    int others = 0;

    *extent = ray_distance(sightings[a].ray, sightings[b].ray);
    if (!(*extent > SAME)) {
        return RIGCAL_ERR_COINCIDENT;
    }
    (void)rc_vec3_unit(m_a, sightings[a].ray);
    (void)rc_vec3_unit(m_b, sightings[b].ray);
    rc_vec3_cross(normal, m_a, m_b);
    if (!rc_vec3_unit(normal, normal)) {
        return RIGCAL_ERR_EDGE_ON;
    }
    for (size_t i = 0; i < n; i++) {
        rigcal_real m[3];
        (void)rc_vec3_unit(m, sightings[i].ray);
        height = rc_max(height, RC_FABS(rc_vec3_dot(m, normal)));
        others += ray_distance(m, m_a) > SAME && ray_distance(m, m_b) > SAME;
    }
    if (others == 0) {
        return RIGCAL_ERR_COINCIDENT;
    }
    return (height > FLAT * *extent + SAME) ? RIGCAL_OK : RIGCAL_ERR_EDGE_ON;
}

typedef struct {
    rigcal_pair *pairs;
    size_t n, capacity;
    const rigcal_sighting *sightings;
    rigcal_real nearest; /* least distance of the two rays */
} pair_list;

static void add_pair(pair_list *list, size_t i, size_t j)
{
    const rigcal_sighting *const s = list->sightings;
    if (list->n < list->capacity &&
        ray_distance(s[i].ray, s[j].ray) >= list->nearest &&
        make_pair(&list->pairs[list->n], s, i, j)) {
        list->n++;
    }
}

/* Every pair once, those of distant indices first. */
static void add_all_pairs(pair_list *list, size_t n)
{
    for (size_t apart = n - 1; apart >= 1; apart--) {
        for (size_t i = 0; i + apart < n; i++) {
            add_pair(list, i, i + apart);
        }
    }
}

/* The points in a fixed disorder: a linear congruential generator of full period
 * 2^k >= n (Hull and Dobell 1962) passes every index below n once a period; the
 * others are skipped. */
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

/* Round r pairs every point with the one r places on in the disorder, so no pair
 * comes twice, and on a grid of points the pairs run in all
 * directions, which constant strides of the index do not. Four rounds fill the
 * list unless pairs are left out. */
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

/* How well two pairs fix an angle together: both far apart in the image, their
 * planes and their offsets in different directions. */
static rigcal_real joint_worth(const rigcal_pair *first, const rigcal_pair *second,
                               const rigcal_sighting sightings[])
{
    rigcal_real across_normals[3], across_offsets[3];
    rc_vec3_cross(across_normals, first->normal, second->normal);
    rc_vec3_cross(across_offsets, first->offset, second->offset);
    return rc_vec3_norm(across_normals) * rc_vec3_norm(across_offsets) *
           ray_distance(sightings[second->i].ray, sightings[second->j].ray);
}

static void swap_pairs(rigcal_pair *a, rigcal_pair *b)
{
    const rigcal_pair kept = *a;
    *a = *b;
    *b = kept;
}

/* To the front: the pair that is longest in the image, then its best partner. */
static void put_best_first(pair_list *list)
{
    rigcal_pair *const pairs = list->pairs;
    const rigcal_sighting *const s = list->sightings;
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

/* ---- elimination --------------------------------------------------------- */

/* Axes (a, b) that the eliminated angle turns, a to b, and c that it keeps. */
typedef struct {
    int a, b, c;
} turned_axes;

static turned_axes axes_of(int32_t eliminate)
{
    switch (eliminate) {
    case RIGCAL_YAW:
        return (turned_axes){0, 1, 2};
    case RIGCAL_PITCH:
        return (turned_axes){2, 0, 1};
    default:
        return (turned_axes){1, 2, 0};
    }
}

/* R = L E(w) Q: what stands left and right of the eliminated rotation E. */
typedef struct {
    rigcal_real L[9], Q[9];
    turned_axes axes;
} split_rotation;

/* R = Rz Ry Rx: pitch stands left of an eliminated roll, right of an eliminated
 * yaw; the eliminated factor itself is left out by giving it angle 0. */
static void split_at(split_rotation *split, int32_t eliminate,
                     const rigcal_real angles[2])
{
    rigcal_real ypr[3], Rz[9], Ry[9], Rx[9];
    rc_angles_join(ypr, eliminate, angles, 0);
    rc_rotation_z(Rz, ypr[0]);
    rc_rotation_y(Ry, (eliminate == RIGCAL_ROLL) ? ypr[1] : 0);
    rc_mat3_mul(split->L, Rz, Ry);
    rc_rotation_y(Ry, (eliminate == RIGCAL_YAW) ? ypr[1] : 0);
    rc_rotation_x(Rx, ypr[2]);
    rc_mat3_mul(split->Q, Ry, Rx);
    split->axes = axes_of(eliminate);
}

/* (14): with m = L^T normal and v = Q offset,  e = p cos w + q sin w + k. */
static void coefficients(rigcal_real pqk[3], const rigcal_pair *pair,
                         const split_rotation *split)
{
    const turned_axes ax = split->axes;
    rigcal_real m[3], v[3];
    rc_mat3_tmul_vec3(m, split->L, pair->normal);
    rc_mat3_mul_vec3(v, split->Q, pair->offset);
    pqk[0] = m[ax.a] * v[ax.a] + m[ax.b] * v[ax.b];
    pqk[1] = m[ax.b] * v[ax.a] - m[ax.a] * v[ax.b];
    pqk[2] = m[ax.c] * v[ax.c];
}

void rc_angles_join(rigcal_real ypr[3], int32_t eliminate,
                    const rigcal_real angles[2], rigcal_real eliminated)
{
    int next = 0;
    for (int i = 0; i < 3; i++) {
        ypr[i] = (i == eliminate) ? eliminated : angles[next++];
    }
}

void rc_angles_split(rigcal_real angles[2], int32_t eliminate,
                     const rigcal_real ypr[3])
{
    int next = 0;
    for (int i = 0; i < 3; i++) {
        if (i != eliminate) {
            angles[next++] = ypr[i];
        }
    }
}

/* Normal equations of A (c, s)^T = b over the first n_pairs pairs. */
typedef struct {
    rigcal_real pp, pq, qq, pk, qk;
} normal_sums;

static void sum_normals(normal_sums *sums, const rigcal_pair pairs[],
                        size_t n_pairs, const split_rotation *split)
{
    *sums = (normal_sums){0, 0, 0, 0, 0};
    for (size_t i = 0; i < n_pairs; i++) {
        rigcal_real pqk[3];
        coefficients(pqk, &pairs[i], split);
        sums->pp += pqk[0] * pqk[0];
        sums->pq += pqk[0] * pqk[1];
        sums->qq += pqk[1] * pqk[1];
        sums->pk += pqk[0] * pqk[2];
        sums->qk += pqk[1] * pqk[2];
    }
}

/* Larger eigenvalue of A^T A. */
static rigcal_real larger_eigenvalue(const normal_sums *sums)
{
    const rigcal_real half_gap = (sums->pp - sums->qq) / 2;
    return (sums->pp + sums->qq) / 2 +
           RC_SQRT(half_gap * half_gap + sums->pq * sums->pq);
}

/* Two equations, two unknowns: Cramer's rule on A itself keeps the accuracy that
 * A^T A would lose. cond(A) = largest singular value squared over |det A|. */
static int solve_two_pairs(rigcal_elimination *out, const rigcal_pair pairs[2],
                           const split_rotation *split)
{
    rigcal_real e[3], f[3];
    normal_sums sums;
    coefficients(e, &pairs[0], split);
    coefficients(f, &pairs[1], split);
    sum_normals(&sums, pairs, 2, split);
    const rigcal_real det = e[0] * f[1] - e[1] * f[0];
    const rigcal_real largest = larger_eigenvalue(&sums);
    if (!(RC_FABS(det) > 4 * RC_EPS * largest)) {
        return 0;
    }
    out->cosine = (e[1] * f[2] - f[1] * e[2]) / det;
    out->sine = (f[0] * e[2] - e[0] * f[2]) / det;
    out->condition = largest / RC_FABS(det);
    return 1;
}

static int solve_all_pairs(rigcal_elimination *out, const rigcal_pair pairs[],
                           size_t n_pairs, const split_rotation *split)
{
    normal_sums sums;
    sum_normals(&sums, pairs, n_pairs, split);
    const rigcal_real det = sums.pp * sums.qq - sums.pq * sums.pq;
    const rigcal_real largest = larger_eigenvalue(&sums);
    if (!(det > 16 * RC_EPS * largest * largest)) {
        return 0;
    }
    out->cosine = (sums.pq * sums.qk - sums.qq * sums.pk) / det;
    out->sine = (sums.pq * sums.pk - sums.pp * sums.qk) / det;
    out->condition = largest / RC_SQRT(det);
    return 1;
}

rigcal_status rc_eliminate(rigcal_elimination *out, const rigcal_pair pairs[],
                           size_t n_pairs, int32_t eliminating,
                           int32_t eliminate, const rigcal_real angles[2])
{
    split_rotation split;
    rigcal_elimination found;
    split_at(&split, eliminate, angles);
    const int solved = (eliminating == 2)
                           ? solve_two_pairs(&found, pairs, &split)
                           : solve_all_pairs(&found, pairs, n_pairs, &split);
    if (!solved) {
        return RIGCAL_ERR_DEGENERATE;
    }
    const rigcal_real c = found.cosine, s = found.sine;
    const rigcal_real length = RC_SQRT(c * c + s * s);
    if (!(length > 0)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    found.angle = rc_angle(s, c);
    found.unit = c * c + s * s - 1;               /* (15) */
    found.residual = RC_FABS(found.unit);
    for (size_t i = (size_t)eliminating; i < n_pairs; i++) { /* (13c) ... */
        rigcal_real pqk[3];
        coefficients(pqk, &pairs[i], &split);
        found.residual +=
            RC_FABS((pqk[0] * c + pqk[1] * s) / length + pqk[2]);
    }
    *out = found;
    return RIGCAL_OK;
}

static rigcal_real pair_residual(const rigcal_pair *pair, const rigcal_real R[9])
{
    rigcal_real turned[3];
    rc_mat3_mul_vec3(turned, R, pair->offset);
    return rc_vec3_dot(pair->normal, turned);
}

rigcal_real rc_three_angle_residual(const rigcal_pair pairs[], size_t n_pairs,
                                    const rigcal_real ypr[3])
{
    rigcal_real R[9], sum = 0;
    rc_rotation_from_yaw_pitch_roll(R, ypr);
    for (size_t i = 0; i < n_pairs; i++) {
        sum += RC_FABS(pair_residual(&pairs[i], R));
    }
    return sum;
}

/* ---- translation --------------------------------------------------------- */

/* Of sighting i: u = (x, y) and q = R (X - origin). */
static void ray_and_turned(rigcal_real u[2], rigcal_real q[3],
                           const rigcal_real R[9],
                           const rigcal_sighting *sighting,
                           const rigcal_real origin[3])
{
    rigcal_real x[3];
    u[0] = sighting->ray[0] / sighting->ray[2];
    u[1] = sighting->ray[1] / sighting->ray[2];
    rc_vec3_sub(x, sighting->X_w, origin);
    rc_mat3_mul_vec3(q, R, x);
}

/* t for the world's own origin, from t for another one. */
static void move_origin(rigcal_real t[3], const rigcal_real R[9],
                        const rigcal_real origin[3])
{
    rigcal_real turned[3];
    rc_mat3_mul_vec3(turned, R, origin);
    rc_vec3_sub(t, t, turned);
}

/* Least squares of  t_xy - u t_z = w,  w = u q_z - q_xy: with means taken out,
 *   t_z = -sum du.w / sum |du|^2,   t_xy = mean(w) + mean(u) t_z */
rigcal_status rc_translation_least_squares(rigcal_real t[3],
                                           const rigcal_real R[9],
                                           const rigcal_sighting sightings[],
                                           size_t n)
{
    const rigcal_real *const origin = sightings[0].X_w;
    rigcal_real u[2], q[3], u_mean[2] = {0, 0}, w_mean[2] = {0, 0};
    rigcal_real du_w = 0, du_du = 0, u_largest = 0;

    for (size_t i = 0; i < n; i++) {
        ray_and_turned(u, q, R, &sightings[i], origin);
        for (int k = 0; k < 2; k++) {
            u_mean[k] += u[k];
            w_mean[k] += u[k] * q[2] - q[k];
            u_largest = rc_max(u_largest, RC_FABS(u[k]));
        }
    }
    for (int k = 0; k < 2; k++) {
        u_mean[k] /= (rigcal_real)n;
        w_mean[k] /= (rigcal_real)n;
    }
    for (size_t i = 0; i < n; i++) {
        ray_and_turned(u, q, R, &sightings[i], origin);
        for (int k = 0; k < 2; k++) {
            const rigcal_real du = u[k] - u_mean[k];
            du_w += du * (u[k] * q[2] - q[k] - w_mean[k]);
            du_du += du * du;
        }
    }
    const rigcal_real rounding = SAME * rc_max(u_largest, SAME);
    if (!(du_du > (rigcal_real)n * rounding * rounding)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    t[2] = -du_w / du_du;
    t[0] = w_mean[0] + u_mean[0] * t[2];
    t[1] = w_mean[1] + u_mean[1] * t[2];
    move_origin(t, R, origin);
    return RIGCAL_OK;
}

/* ---- public -------------------------------------------------------------- */

size_t rigcal_pairs_for(size_t n)
{
    return RIGCAL_PAIRS_FOR(n);
}

rigcal_status rigcal_pair_make(rigcal_pair *pair,
                               const rigcal_sighting sightings[], size_t n,
                               int32_t i, int32_t j)
{
    if (pair == NULL || sightings == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (n > RC_COUNT_MAX || i < 0 || j < 0 || i == j || (size_t)i >= n ||
        (size_t)j >= n) {
        return RIGCAL_ERR_RANGE;
    }
    rigcal_status status = check_sighting(&sightings[i], 0);
    if (status == RIGCAL_OK) {
        status = check_sighting(&sightings[j], 0);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    return make_pair(pair, sightings, (size_t)i, (size_t)j)
               ? RIGCAL_OK
               : RIGCAL_ERR_COINCIDENT;
}

rigcal_status rigcal_pairs_choose(rigcal_pair pairs[], size_t *n_pairs,
                                  size_t capacity,
                                  const rigcal_sighting sightings[], size_t n)
{
    if (pairs == NULL || n_pairs == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_real extent;
    rigcal_status status = rc_check_sightings(sightings, n, 1);
    if (status == RIGCAL_OK && n < 3) {
        status = RIGCAL_ERR_TOO_FEW;
    }
    if (status == RIGCAL_OK && capacity < 3) {
        status = RIGCAL_ERR_CAPACITY;
    }
    if (status == RIGCAL_OK) {
        status = check_points_shape(sightings, n);
    }
    if (status == RIGCAL_OK) {
        status = check_rays_shape(&extent, sightings, n);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    pair_list list = {pairs, 0, capacity, sightings, NEAR_PART * extent};
    add_pairs(&list, n);
    if (list.n < 3) { /* few points, some of them near: take what there is */
        list.nearest = 0;
        add_pairs(&list, n);
    }
    if (list.n < 3) {
        return RIGCAL_ERR_COINCIDENT;
    }
    put_best_first(&list);
    *n_pairs = list.n;
    return RIGCAL_OK;
}

rigcal_status rigcal_pair_residual(rigcal_real *e, const rigcal_pair *pair,
                                   const rigcal_real R[9])
{
    if (e == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_pairs(pair, 1, 1);
    if (status == RIGCAL_OK) {
        status = rc_check_rotation(R);
    }
    if (status == RIGCAL_OK) {
        *e = pair_residual(pair, R);
    }
    return status;
}

static rigcal_status check_two_angles(int32_t eliminate,
                                      const rigcal_real angles[2])
{
    if (angles == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (!rc_all_finite(angles, 2)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    return (eliminate >= RIGCAL_YAW && eliminate <= RIGCAL_ROLL &&
            rc_all_within(angles, 2, RC_ANGLE_MAX))
               ? RIGCAL_OK
               : RIGCAL_ERR_RANGE;
}

rigcal_status rigcal_pair_coefficients(rigcal_real pqk[3],
                                       const rigcal_pair *pair,
                                       int32_t eliminate,
                                       const rigcal_real angles[2])
{
    if (pqk == NULL || pair == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = check_two_angles(eliminate, angles);
    if (status == RIGCAL_OK) {
        status = rc_check_pairs(pair, 1, 1);
    }
    if (status == RIGCAL_OK) {
        split_rotation split;
        split_at(&split, eliminate, angles);
        coefficients(pqk, pair, &split);
    }
    return status;
}

rigcal_status rigcal_eliminate(rigcal_elimination *out,
                               const rigcal_pair pairs[], size_t n_pairs,
                               int32_t eliminating, int32_t eliminate,
                               const rigcal_real angles[2])
{
    if (out == NULL || pairs == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = check_two_angles(eliminate, angles);
    if (status == RIGCAL_OK && eliminating != 0 && eliminating != 2) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK) {
        status = rc_check_pairs(pairs, n_pairs, 3);
    }
    return (status == RIGCAL_OK)
               ? rc_eliminate(out, pairs, n_pairs, eliminating, eliminate, angles)
               : status;
}

rigcal_status rigcal_three_angle_residual(rigcal_real *residual,
                                          const rigcal_pair pairs[],
                                          size_t n_pairs,
                                          const rigcal_real ypr[3])
{
    if (residual == NULL || pairs == NULL || ypr == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (!rc_all_finite(ypr, 3)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    if (!rc_all_within(ypr, 3, RC_ANGLE_MAX)) {
        return RIGCAL_ERR_RANGE;
    }
    const rigcal_status status = rc_check_pairs(pairs, n_pairs, 3);
    if (status == RIGCAL_OK) {
        *residual = rc_three_angle_residual(pairs, n_pairs, ypr);
    }
    return status;
}

static rigcal_status check_translation(const rigcal_real t[3],
                                       const rigcal_real R[9],
                                       const rigcal_sighting sightings[],
                                       size_t n)
{
    if (t == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_rotation(R);
    if (status == RIGCAL_OK) {
        status = rc_check_sightings(sightings, n, 1);
    }
    return (status == RIGCAL_OK && n < 2) ? RIGCAL_ERR_TOO_FEW : status;
}

rigcal_status rigcal_translation_least_squares(rigcal_real t[3],
                                               const rigcal_real R[9],
                                               const rigcal_sighting sightings[],
                                               size_t n)
{
    rigcal_real found[3];
    rigcal_status status = check_translation(t, R, sightings, n);
    if (status == RIGCAL_OK) {
        status = rc_translation_least_squares(found, R, sightings, n);
    }
    for (int i = 0; i < 3 && status == RIGCAL_OK; i++) {
        t[i] = found[i];
    }
    return status;
}

/* (10a), (10b) of one pair: adds t_z of each coordinate that differs enough. */
static void sum_depths(rigcal_real *sum, size_t *count, const rigcal_real R[9],
                       const rigcal_sighting *first,
                       const rigcal_sighting *second, const rigcal_real origin[3])
{
    rigcal_real u_i[2], u_j[2], q_i[3], q_j[3];
    ray_and_turned(u_i, q_i, R, first, origin);
    ray_and_turned(u_j, q_j, R, second, origin);
    for (int k = 0; k < 2; k++) {
        const rigcal_real du = u_i[k] - u_j[k];
        if (RC_FABS(du) > SPREAD_MIN) {
            *sum += (q_i[k] - q_j[k] - (u_i[k] * q_i[2] - u_j[k] * q_j[2])) / du;
            ++*count;
        }
    }
}

rigcal_status rigcal_translation_from_pairs(rigcal_real t[3],
                                            const rigcal_real R[9],
                                            const rigcal_sighting sightings[],
                                            size_t n, const rigcal_pair pairs[],
                                            size_t n_pairs)
{
    rigcal_status status = check_translation(t, R, sightings, n);
    if (status == RIGCAL_OK) {
        status = rc_check_pairs(pairs, n_pairs, 1);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    const rigcal_real *const origin = sightings[0].X_w;
    rigcal_real found[3] = {0, 0, 0}, sum = 0;
    size_t count = 0;
    for (size_t p = 0; p < n_pairs; p++) {
        const int32_t i = pairs[p].i, j = pairs[p].j;
        if (i < 0 || j < 0 || (size_t)i >= n || (size_t)j >= n) {
            return RIGCAL_ERR_RANGE;
        }
        sum_depths(&sum, &count, R, &sightings[i], &sightings[j], origin);
    }
    if (count == 0) {
        return RIGCAL_ERR_DEGENERATE;
    }
    found[2] = sum / (rigcal_real)count;
    for (size_t i = 0; i < n; i++) { /* (9) */
        rigcal_real u[2], q[3];
        ray_and_turned(u, q, R, &sightings[i], origin);
        found[0] += u[0] * (q[2] + found[2]) - q[0];
        found[1] += u[1] * (q[2] + found[2]) - q[1];
    }
    found[0] /= (rigcal_real)n;
    found[1] /= (rigcal_real)n;
    move_origin(found, R, origin);
    for (int i = 0; i < 3; i++) {
        t[i] = found[i];
    }
    return RIGCAL_OK;
}
