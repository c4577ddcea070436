#include "rc_pose.h"

/* Directions of the lattice, how many of the best are followed, and how far apart
 * these are [cosine]: the finer lattice's best would all be neighbours. */
enum { LATTICE = 24, LATTICE_THOROUGH = 96 };
enum { FOLLOWED = 3, FOLLOWED_THOROUGH = RIGCAL_POSE_SEEDS };
#define NEIGHBOUR_COSINE RC(0.88)

/* A descent: the simplex's first edge [rad], about half the lattice's spacing, and
 * its evaluations. It only has to land where refinement converges. */
#define EDGE RC(0.3)
enum { DESCENT_EVALS = 10, DESCENT_EVALS_THOROUGH = 20 };
enum { REFINE_EVALS = 100, REFINE_EVALS_THOROUGH = 250 };

/* A target whose mean square across its plane is below this part of the whole has
 * a second optimum, which leans the other way. */
#define FLAT_THICKNESS RC(0.05)

/* Below this mirrored points have nearly the same image. */
#define PLANE_THICKNESS RC(1e-4)

/* A direction whose cost is so many times the least is no optimum worth refining,
 * unless the target is flat: its second optimum may be as bad. */
#define HOPELESS RC(100)

/* A flat target's seeds that lean other than its first optimum does: the least lean
 * [rad], and how many times the least cost the sideways ones may be. */
#define LEAN_LEAST RC(0.3)
#define SHALLOW RC(30)
enum { OTHER_WAY = 0, SIDEWAYS, SIDEWAYS_BACK, LEANS };

/* A seed so near to an optimum found [rad] was on its way there; those that lean
 * start where an optimum is expected, and may be nearer. Two optima closer than
 * SAME_POSE are one; those of three points may be about to merge, but are exact. */
#define SAME_BASIN RC(0.25)
#define SAME_BASIN_LEANING RC(0.05)
#define SAME_POSE RC(2e-3)
#define SAME_EXACT RC_TOL(1e-6, 1e-3)

/* Points so near to each other are one; in sizes of the target. */
#define SAME_POINT RC_TOL(1e-9, 1e-5)

/* Noise, stated in pixels or relative, outside which it is a mistake. */
#define SIGMA_MIN RC(1e-6)
#define SIGMA_MAX RC(1e6)

/* Where no noise is stated: the least assumed [px], and the most that is believed
 * [px], or as a part of the target's image where that is more. */
#define NOISE_LEAST RC(0.01)
#define NOISE_MOST RC(2)
#define NOISE_MOST_PART RC(0.01)

/* Mirrored points are only suspected where the fit leaves room for a better one [px],
 * and believed where they are so many times as likely. */
#define MIRROR_NOISE RC(0.1)
#define MIRROR_ODDS RC(100)

/* How many times the cost of the points that of mirrored ones may be, in the same
 * direction, to be worth refining. */
#define MIRROR_WORSE RC(10)

/* Beyond this the exponential is more than odds can be. */
#define EXPONENT_MOST RC(80)

/* A pose whose rotation has a standard deviation above this [rad] is hardly one;
 * reckoned with at least so much noise [px] where none is stated, and from so many
 * points first. */
#define VAGUE RC(0.25)
#define VAGUE_NOISE RC(0.25)
enum { VAGUE_POINTS = 16 };

/* The first pose is sure from here on. */
#define SURE RC(0.99)

/* A warm start proves bad when its error is above this part of the target's image, or
 * this where that is more [px]: far away noise alone is above such a part. */
#define WARM_ERROR RC(0.02)
#define WARM_NOISE RC(1)

/* Rays so far off the middle of the target's image do not fit the virtual camera:
 * cosine of 80 degrees. */
#define WIDE_COSINE RC(0.17)

enum {
    NOT_BEGUN = 0,
    WARM,
    GATHERING,
    LATTICE_SCAN,
    DESCENT,
    REFINING,
    MIRRORED,
    WEIGHING,
    DONE
};

/* ---- the data ------------------------------------------------------------ */

static rigcal_real weight_of(const rigcal_real sigma[], size_t i)
{
    return (sigma == NULL) ? 1 : 1 / (sigma[i] * sigma[i]);
}

static int is_used(const uint8_t mask[], size_t i)
{
    return mask == NULL || mask[i] != 0;
}

/* NaN is within nothing. */
static int is_sound(const rigcal_observation *o, const rigcal_real sigma[], size_t i)
{
    return rc_all_within(o->X_w, 3, RC_COORDINATE_MAX) &&
           rc_all_within(o->uv, 2, RC_PIXEL_MAX) &&
           (sigma == NULL || (sigma[i] >= SIGMA_MIN && sigma[i] <= SIGMA_MAX));
}

static rigcal_status check_data(int32_t *at, const rigcal_observation o[],
                                const rigcal_real sigma[], const uint8_t mask[],
                                size_t n)
{
    for (size_t i = 0; i < n; i++) {
        if (is_used(mask, i) && !is_sound(&o[i], sigma, i)) {
            *at = (int32_t)i;
            return (rc_all_finite(o[i].X_w, 3) && rc_all_finite(o[i].uv, 2) &&
                    (sigma == NULL || rc_is_finite(sigma[i])))
                       ? RIGCAL_ERR_RANGE
                       : RIGCAL_ERR_NOT_FINITE;
        }
    }
    return RIGCAL_OK;
}

/* The first point that counts. */
static size_t first_used(const uint8_t mask[], size_t n)
{
    size_t i = 0;
    while (i + 1 < n && !is_used(mask, i)) {
        i++;
    }
    return i;
}

/* The weighted mean of the points, and the pixel in the middle of their image. */
RC_APART static void find_middle(rigcal_real origin[3], rigcal_real uv_middle[2],
                        const rigcal_observation o[], const rigcal_real sigma[],
                        const uint8_t mask[], size_t n)
{
    const rigcal_observation *const first = &o[first_used(mask, n)];
    rigcal_real total = 0, count = 0, shift[3] = {0, 0, 0}, uv[2] = {0, 0};
    for (size_t i = 0; i < n; i++) { /* from the first point: far origins */
        if (is_used(mask, i)) {
            rigcal_real x[3];
            const rigcal_real weight = weight_of(sigma, i);
            rc_vec3_sub(x, o[i].X_w, first->X_w);
            rc_vec3_add_scaled(shift, weight, x);
            uv[0] += o[i].uv[0];
            uv[1] += o[i].uv[1];
            total += weight;
            count += 1;
        }
    }
    for (int k = 0; k < 3; k++) {
        origin[k] = first->X_w[k] + shift[k] / total;
    }
    uv_middle[0] = uv[0] / count;
    uv_middle[1] = uv[1] / count;
}

/* Whether the points have a shape, the scale that makes its size 1, and the extent
 * of its image. */
RC_APART static rigcal_status measure(rigcal_pose_solver *s,
                                      const rigcal_real uv_middle[2])
{
    const rigcal_real *const first =
        s->observations[first_used(s->mask, s->n)].X_w;
    rigcal_real largest = 0, extent2 = 0;
    rigcal_real box[3] = {0, 0, 0};
    for (size_t i = 0; i < s->n; i++) { /* differences of two points are exact */
        const rigcal_observation *const o = &s->observations[i];
        if (is_used(s->mask, i)) {
            const rigcal_real du = o->uv[0] - uv_middle[0];
            const rigcal_real dv = o->uv[1] - uv_middle[1];
            for (int k = 0; k < 3; k++) {
                box[k] = rc_max(box[k], RC_FABS(o->X_w[k] - first[k]));
                largest = rc_max(largest, RC_FABS(o->X_w[k]));
            }
            extent2 = rc_max(extent2, du * du + dv * dv);
        }
    }
    const rigcal_real size = rc_vec3_max_abs(box);
    if (!(size > 1 / RC_COORDINATE_MAX)) {
        return RIGCAL_ERR_COINCIDENT;
    }
    s->scale = 1 / size;
    s->extent_px = RC_SQRT(extent2);
    return (largest * RC_EPS <= RC_SHAPE_ROUNDING * size) ? RIGCAL_OK
                                                       : RIGCAL_ERR_PRECISION;
}

/* Rotation whose third row is the unit vector `axis`: the virtual camera, which
 * looks along it, from the camera. */
static void look_along(rigcal_real R[9], const rigcal_real axis[3])
{
    rc_view_complete(&R[0], &R[3], axis);
    for (int k = 0; k < 3; k++) {
        R[6 + k] = axis[k];
    }
}

/* The middle of the rays, where the middle pixel has none: or the pixel that has
 * none itself, and pulled the middle away. */
static rigcal_status middle_ray(rigcal_real middle[3], int32_t *at,
                                const rigcal_pose_solver *s)
{
    rigcal_real sum[3] = {0, 0, 0};
    for (size_t i = 0; i < s->n; i++) {
        rigcal_real ray[3];
        if (is_used(s->mask, i)) {
            const rigcal_status status =
                rc_pixel_to_ray(ray, s->camera, s->observations[i].uv);
            if (status != RIGCAL_OK) {
                *at = (int32_t)i;
                return status;
            }
            rc_vec3_add_scaled(sum, 1, ray);
        }
    }
    return rc_vec3_unit(middle, sum) ? RIGCAL_OK : RIGCAL_ERR_WIDE_RAY;
}

/* One point, scaled to size 1, and its ray turned to the middle. */
static rigcal_status gather_point(rigcal_pose_solver *s,
                                  const rigcal_real virtual_from_cam[9], size_t i)
{
    const rigcal_observation *const o = &s->observations[i];
    rigcal_real x[3], ray[3], turned[3];
    const rigcal_status status = rc_pixel_to_ray(ray, s->camera, o->uv);
    if (status != RIGCAL_OK) {
        return status;
    }
    rc_mat3_mul_vec3(turned, virtual_from_cam, ray);
    if (!(turned[2] > WIDE_COSINE)) {
        return RIGCAL_ERR_WIDE_RAY;
    }
    const rigcal_real by_depth = 1 / turned[2];
    const rigcal_real u[2] = {turned[0] * by_depth, turned[1] * by_depth};
    rc_vec3_sub(x, o->X_w, s->origin);
    for (int k = 0; k < 3; k++) {
        x[k] *= s->scale;
    }
    rc_view_add(&s->from.lattice.moments, weight_of(s->sigma, i), x, u);
    return RIGCAL_OK;
}

/* The moments: what the search needs to know of the points. */
RC_APART static rigcal_status gather_moments(rigcal_pose_solver *s, int32_t *at,
                            const rigcal_real uv_middle[2])
{
    rigcal_real virtual_from_cam[9], normal[3], thickness;
    rigcal_status status = RIGCAL_OK;
    if (rc_pixel_to_ray(s->axis, s->camera, uv_middle) != RIGCAL_OK) {
        status = middle_ray(s->axis, at, s);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    look_along(virtual_from_cam, s->axis);
    rc_view_begin(&s->from.lattice.moments);
    for (size_t i = 0; i < s->n && status == RIGCAL_OK; i++) {
        if (is_used(s->mask, i)) {
            *at = (int32_t)i;
            status = gather_point(s, virtual_from_cam, i);
        }
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    *at = -1;
    if (!rc_view_finish(&s->from.lattice.moments)) {
        return RIGCAL_ERR_COINCIDENT;
    }
    if (!rc_view_normal(normal, &thickness, &s->from.lattice.moments)) {
        return RIGCAL_ERR_COLLINEAR;
    }
    s->is_flat = thickness < FLAT_THICKNESS;
    s->is_plane = thickness < PLANE_THICKNESS;
    return RIGCAL_OK;
}

/* The first three different points, and whether there are no more. */
static int are_three(size_t first[3], const rigcal_pose_solver *s)
{
    int count = 0;
    for (size_t i = 0; i < s->n; i++) {
        int is_new = is_used(s->mask, i);
        for (int k = 0; k < count && is_new; k++) {
            rigcal_real x[3];
            rc_vec3_sub(x, s->observations[i].X_w, s->observations[first[k]].X_w);
            is_new = rc_vec3_max_abs(x) * s->scale > SAME_POINT;
        }
        if (is_new && count == 3) {
            return 0;
        }
        if (is_new) {
            first[count++] = i;
        }
    }
    return count == 3;
}

/* (D): all poses of three points. 0: there is none, and the moments are gone. */
RC_APART static int32_t gather_exact(rigcal_pose_solver *s, const size_t three[3])
{
    rigcal_real x[3][3], ray[3][3];
    for (int k = 0; k < 3; k++) {
        const rigcal_observation *const o = &s->observations[three[k]];
        rc_vec3_sub(x[k], o->X_w, s->origin);
        (void)rc_pixel_to_ray(ray[k], s->camera, o->uv);
    }
    return rc_p3p(s->from.exact, (const rigcal_real(*)[3])x,
                  (const rigcal_real(*)[3])ray);
}

/* What the seeds come from. */
RC_APART static rigcal_status gather(rigcal_pose_solver *s, int32_t *at,
                                     const rigcal_real uv_middle[2])
{
    size_t three[3];
    const rigcal_status status = gather_moments(s, at, uv_middle);
    if (status != RIGCAL_OK || !are_three(three, s)) {
        return status;
    }
    s->n_exact = gather_exact(s, three);
    return (s->n_exact > 0) ? status : gather_moments(s, at, uv_middle);
}

/* ---- optima found -------------------------------------------------------- */

/* The first optimum whose rotation is within a (small) angle of R, or -1. For unit
 * quaternions |p -+ q| = 2 sin(angle / 4). */
static int32_t near_found(const rigcal_pose_solver *s, const rigcal_real R[9],
                          rigcal_real angle)
{
    rigcal_real q[4];
    rc_quaternion_from_rotation(q, R);
    for (int32_t i = 0; i < s->n_found; i++) {
        const rigcal_real *const p = s->found[i].q_wxyz;
        rigcal_real less = 0, more = 0;
        for (int k = 0; k < 4; k++) {
            less += (p[k] - q[k]) * (p[k] - q[k]);
            more += (p[k] + q[k]) * (p[k] + q[k]);
        }
        if (4 * rc_min(less, more) < angle * angle) {
            return i;
        }
    }
    return -1;
}

static void found_transform(rigcal_transform *cam_from_points,
                            const rigcal_pose_optimum *found)
{
    rc_rotation_from_quaternion(cam_from_points->R, found->q_wxyz);
    for (int k = 0; k < 3; k++) {
        cam_from_points->t[k] = found->t[k];
    }
}

/* The direction of the virtual camera's axis, seen from the target, at an optimum. */
static void found_direction(rigcal_real m3[3], const rigcal_pose_solver *s,
                            int32_t i)
{
    rigcal_real R[9];
    rc_rotation_from_quaternion(R, s->found[i].q_wxyz);
    rc_mat3_tmul_vec3(m3, R, s->axis);
}

/* Refinement sees to it that the points are in front; whether a lens that turns back
 * sees them is asked once. */
RC_APART static int is_seen(const rigcal_pose_solver *s, const rc_fit *fit)
{
    if (fit->lens.is_pinhole) {
        return 1;
    }
    for (size_t i = 0; i < s->n; i++) {
        rigcal_real x[3], X_c[3], uv[2];
        if (is_used(s->mask, i)) {
            rc_vec3_sub(x, s->observations[i].X_w, s->origin);
            rc_transform_point(X_c, &s->work.fit.cam_from_points, x);
            if (rc_project_usable(uv, s->camera, X_c) != RIGCAL_OK) {
                return 0;
            }
        }
    }
    return 1;
}

/* Keeps the RIGCAL_POSES_MAX best optima in order; of two that are one, the better. */
RC_APART static void insert_found(rigcal_pose_solver *s, const rc_fit *fit)
{
    const rigcal_refinement *const end = &s->work.fit;
    const int32_t same = near_found(s, end->cam_from_points.R,
                                    (s->n_exact > 0) ? SAME_EXACT : SAME_POSE);
    if ((same >= 0 && end->sse >= s->found[same].sse) || !is_seen(s, fit)) {
        return;
    }
    int32_t at = same;
    if (same < 0) {
        at = (s->n_found < RIGCAL_POSES_MAX) ? s->n_found++ : RIGCAL_POSES_MAX;
    }
    for (; at > 0 && end->sse < s->found[at - 1].sse; at--) {
        if (at < RIGCAL_POSES_MAX) {
            s->found[at] = s->found[at - 1];
        }
    }
    if (at < RIGCAL_POSES_MAX) {
        rigcal_pose_optimum *const found = &s->found[at];
        rc_quaternion_from_rotation(found->q_wxyz, end->cam_from_points.R);
        for (int k = 0; k < 3; k++) {
            found->t[k] = end->cam_from_points.t[k];
        }
        found->sse = end->sse;
    }
}

/* ---- likelihood ---------------------------------------------------------- */

static rigcal_real freedom(const rigcal_pose_solver *s)
{
    return (rigcal_real)(2 * s->n_used - 6);
}

static rigcal_real power(rigcal_real base, size_t exponent)
{
    rigcal_real result = 1;
    for (; exponent > 0; exponent /= 2) {
        result *= (exponent % 2 == 1) ? base : 1;
        base *= base;
    }
    return result;
}

/* (C): likelihood of a sum of squares over that of the first pose. Noise known:
 * exp(-sse / 2 noise^2). Unknown, it is integrated out with the prior 1 / noise, which
 * leaves sse^-(n - 3); the floor is what the least noise makes of the sum. */
static rigcal_real likelihood_of(const rigcal_pose_solver *s, rigcal_real sse)
{
    const rigcal_real first = s->found[0].sse, stated = s->sigma_px;
    if (stated > 0) {
        return RC_EXP(rc_min((first - sse) / (2 * stated * stated), EXPONENT_MOST));
    }
    const rigcal_real floor_sum = rc_max(1, freedom(s)) * NOISE_LEAST * NOISE_LEAST;
    return power((first + floor_sum) / (sse + floor_sum), s->n_used - 3);
}

rigcal_real rc_pose_likelihood(const rigcal_pose_solver *s, int32_t i)
{
    return likelihood_of(s, s->found[i].sse);
}

/* ---- seeds: the lattice -------------------------------------------------- */

static int32_t lattice_size(const rigcal_pose_solver *s)
{
    return s->thorough ? LATTICE_THOROUGH : LATTICE;
}

/* A golden angle, pi (3 - sqrt 5). */
#define GOLDEN_COS RC(-0.73736887807831989)
#define GOLDEN_SIN RC(0.67549029426152364)

/* z <- z w, as complex numbers. */
static void turn(rigcal_real z[2], const rigcal_real w[2])
{
    const rigcal_real x = z[0] * w[0] - z[1] * w[1];
    z[1] = z[0] * w[1] + z[1] * w[0];
    z[0] = x;
}

/* Direction i of a Fibonacci sphere of n: heights in even steps, azimuths a golden
 * angle apart. */
static void direction_of(rigcal_real m3[3], int32_t i, int32_t n,
                         const rigcal_real azimuth[2])
{
    m3[2] = 1 - (rigcal_real)(2 * i + 1) / (rigcal_real)n;
    const rigcal_real r = RC_SQRT(1 - m3[2] * m3[2]);
    m3[0] = r * azimuth[0];
    m3[1] = r * azimuth[1];
}

/* The azimuth by squaring, for there may be no other use for a sine. */
static void seed_direction(rigcal_real m3[3], const rigcal_pose_solver *s,
                           int32_t index)
{
    rigcal_real azimuth[2] = {1, 0}, doubled[2] = {GOLDEN_COS, GOLDEN_SIN};
    for (int32_t k = index; k > 0; k /= 2) {
        if (k % 2 == 1) {
            turn(azimuth, doubled);
        }
        turn(doubled, (const rigcal_real[2]){doubled[0], doubled[1]});
    }
    direction_of(m3, index, lattice_size(s), azimuth);
}

/* The same in turn: the azimuth is carried on. */
static void next_direction(rigcal_real m3[3], rigcal_pose_solver *s)
{
    static const rigcal_real GOLDEN[2] = {GOLDEN_COS, GOLDEN_SIN};
    direction_of(m3, s->next, lattice_size(s), s->from.lattice.spiral);
    turn(s->from.lattice.spiral, GOLDEN);
}

static void move_seed(rigcal_pose_lattice *lattice, int32_t to, int32_t from)
{
    lattice->cost[to] = lattice->cost[from];
    lattice->index[to] = lattice->index[from];
}

/* Removes the seeds of neighbours that are worse. 0: there is a better one. */
static int is_best_nearby(rigcal_pose_solver *s, const rigcal_real m3[3],
                          rigcal_real cost)
{
    int32_t kept = 0;
    for (int32_t i = 0; i < s->n_seeds; i++) {
        rigcal_real other[3];
        seed_direction(other, s, s->from.lattice.index[i]);
        if (rc_vec3_dot(m3, other) > NEIGHBOUR_COSINE) {
            if (s->from.lattice.cost[i] <= cost) {
                return 0; /* sorted by cost: nothing has been removed */
            }
        } else {
            move_seed(&s->from.lattice, kept++, i);
        }
    }
    s->n_seeds = kept;
    return 1;
}

/* Keeps the `most` best directions in order of cost. */
static void insert_seed(rigcal_pose_solver *s, rigcal_real cost, int32_t most)
{
    int32_t at = (s->n_seeds < most) ? s->n_seeds++ : most;
    for (; at > 0 && cost < s->from.lattice.cost[at - 1]; at--) {
        if (at < most) {
            move_seed(&s->from.lattice, at, at - 1);
        }
    }
    if (at < most) {
        s->from.lattice.cost[at] = cost;
        s->from.lattice.index[at] = s->next;
    }
}

static void begin_lattice(rigcal_pose_solver *s)
{
    s->phase = LATTICE_SCAN;
    s->next = 0;
    s->n_seeds = 0;
    s->from.lattice.spiral[0] = 1;
    s->from.lattice.spiral[1] = 0;
}

static void next_seed(rigcal_pose_solver *s);
static void begin_weighing(rigcal_pose_solver *s, int32_t by_all);

/* Three points: every pose of theirs is refined. */
static void next_exact(rigcal_pose_solver *s)
{
    if (s->next == s->n_exact) {
        begin_weighing(s, 0);
        return;
    }
    s->work.fit.cam_from_points = s->from.exact[s->next++];
    rc_refine_begin(&s->work.fit);
    s->phase = REFINING;
}

static void begin_search(rigcal_pose_solver *s)
{
    if (s->n_exact > 0) {
        s->next = 0;
        next_exact(s);
    } else {
        begin_lattice(s);
    }
}

RC_APART static void lattice_step(rigcal_pose_solver *s)
{
    const int32_t most = s->thorough ? FOLLOWED_THOROUGH : FOLLOWED;
    rigcal_real m3[3];
    next_direction(m3, s);
    const rigcal_real cost = rc_view_cost(&s->from.lattice.moments, m3);
    if ((s->n_seeds < most || cost < s->from.lattice.cost[most - 1]) &&
        (!s->thorough || is_best_nearby(s, m3, cost))) {
        insert_seed(s, cost, most);
    }
    if (++s->next == lattice_size(s)) {
        s->from.lattice.least_cost = s->from.lattice.cost[0];
        s->next = 0;
        next_seed(s);
    }
}

/* ---- seeds: the descent -------------------------------------------------- */

/* Whether the way to an optimum found is downhill: then a descent would only end
 * there once more. */
static int leads_to_found(const rigcal_pose_solver *s, const rigcal_real m3[3],
                          rigcal_real cost)
{
    for (int32_t i = 0; i < s->n_found; i++) {
        rigcal_real middle[3];
        found_direction(middle, s, i);
        rc_vec3_add_scaled(middle, 1, m3);
        if (rc_vec3_unit(middle, middle) &&
            rc_view_cost(&s->from.lattice.moments, middle) < cost) {
            return 1;
        }
    }
    return 0;
}

/* The direction at (a, b) in the plane that touches the sphere at a seed. */
static void direction_near(rigcal_real m3[3], const rigcal_real seed[3],
                           const rigcal_real ab[2])
{
    rigcal_real m1[3], m2[3];
    rc_view_complete(m1, m2, seed);
    for (int k = 0; k < 3; k++) {
        m3[k] = seed[k] + ab[0] * m1[k] + ab[1] * m2[k];
    }
    const rigcal_real by_length = 1 / rc_vec3_norm(m3);
    for (int k = 0; k < 3; k++) {
        m3[k] *= by_length;
    }
}

static void begin_descent(rigcal_pose_solver *s, const rigcal_real m3[3],
                          rigcal_real cost)
{
    static const rigcal_real SIMPLEX[6] = {0, 0, EDGE, 0, 0, EDGE};
    (void)rigcal_neldermead_begin_simplex(
        &s->work.descent.nm, SIMPLEX, 2, RC(1e-4), 0,
        s->thorough ? DESCENT_EVALS_THOROUGH : DESCENT_EVALS);
    rc_neldermead_tell(&s->work.descent.nm, cost); /* known already */
    for (int k = 0; k < 3; k++) {
        s->work.descent.m3[k] = m3[k];
    }
    s->phase = DESCENT;
}

static void begin_mirrored(rigcal_pose_solver *s);

/* The next seed that is worth a descent, or the end. */
RC_APART static void next_seed(rigcal_pose_solver *s)
{
    for (; s->next < s->n_seeds; s->next++) {
        rigcal_real m3[3];
        const rigcal_real cost = s->from.lattice.cost[s->next];
        if (!(cost < RC_MAX)) {
            break;
        }
        seed_direction(m3, s, s->from.lattice.index[s->next]);
        if (s->thorough || !leads_to_found(s, m3, cost)) {
            begin_descent(s, m3, cost);
            s->next++;
            return;
        }
    }
    begin_mirrored(s);
}

/* Camera from points, in the caller's unit, of a direction: V^T of what the virtual
 * camera sees, V = virtual_from_cam. */
static void seed_pose(rigcal_transform *cam_from_points,
                      const rigcal_pose_solver *s, const rigcal_real m3[3])
{
    rigcal_real V[9];
    rigcal_real *const R = cam_from_points->R, *const t = cam_from_points->t;
    rc_view_pose(cam_from_points, &s->from.lattice.moments, m3);
    look_along(V, s->axis);
    for (int column = 0; column < 3; column++) {
        const rigcal_real r[3] = {R[column], R[3 + column], R[6 + column]};
        for (int row = 0; row < 3; row++) {
            R[3 * row + column] = V[row] * r[0] + V[3 + row] * r[1] + V[6 + row] * r[2];
        }
    }
    const rigcal_real by_scale = 1 / s->scale;
    const rigcal_real r[3] = {by_scale * t[0], by_scale * t[1], by_scale * t[2]};
    rc_mat3_tmul_vec3(t, V, r);
}

/* Whether the points are mirrored. Mirrored ones, -x, have far away the same image as
 * x, turned half about the line of sight: their pose is near the direction found, and
 * the cost there tells whether it is worth refining. */
static void begin_mirrored(rigcal_pose_solver *s)
{
    rigcal_view_moments *const view = &s->from.lattice.moments;
    rigcal_real m3[3];
    const rigcal_real noise = rc_max(s->sigma_px, MIRROR_NOISE);
    begin_weighing(s, 0);
    if (s->is_plane || s->n_found == 0 ||
        s->found[0].sse <= noise * noise * rc_max(1, freedom(s))) {
        return;
    }
    found_direction(m3, s, 0);
    const rigcal_real cost = rc_view_cost(view, m3);
    rc_view_mirror(view);
    if (rc_view_cost(view, m3) < MIRROR_WORSE * cost) {
        seed_pose(&s->work.fit.cam_from_points, s, m3);
        rc_refine_begin(&s->work.fit);
        s->phase = MIRRORED;
    }
}

static void end_mirrored(rigcal_pose_solver *s)
{
    s->is_mirrored = s->work.fit.status >= 0 &&
                     likelihood_of(s, s->work.fit.sse) > MIRROR_ODDS;
    begin_weighing(s, 0);
}

/* 0: it would only lead to an optimum found. */
RC_APART static int begin_refining(rigcal_pose_solver *s, const rigcal_real m3[3],
                                   rigcal_real same_basin)
{
    rigcal_transform *const start = &s->work.fit.cam_from_points;
    seed_pose(start, s, m3);
    if (near_found(s, start->R, same_basin) >= 0) {
        return 0;
    }
    rc_refine_begin(&s->work.fit);
    s->phase = REFINING;
    return 1;
}

RC_APART static void end_descent(rigcal_pose_solver *s)
{
    rigcal_real ab[3] = {0, 0, 0}, cost = 0, m3[3];
    if (rigcal_neldermead_result(ab, &cost, NULL, &s->work.descent.nm) >= 0) {
        direction_near(m3, s->work.descent.m3, ab);
        s->from.lattice.least_cost = rc_min(s->from.lattice.least_cost, cost);
        /* Rounding makes the costs of noiseless images anything: the last term. */
        const rigcal_real hopeless = HOPELESS * s->from.lattice.least_cost +
                                     64 * RC_EPS * s->from.lattice.moments.weight;
        if ((s->n_found == 0 || s->is_flat || !(cost > hopeless)) &&
            begin_refining(s, m3, SAME_BASIN)) {
            return;
        }
    }
    next_seed(s);
}

RC_APART static void descent_step(rigcal_pose_solver *s)
{
    rigcal_neldermead *const nm = &s->work.descent.nm;
    rigcal_real m3[3];
    direction_near(m3, s->work.descent.m3, nm->trial);
    rc_neldermead_tell(nm, rc_view_cost(&s->from.lattice.moments, m3));
    if (nm->status != RIGCAL_RUNNING) {
        end_descent(s);
    }
}

/* ---- refinement ---------------------------------------------------------- */

/* A flat target's other optimum leans the other way: there the line of sight is
 * mirrored in the target's normal n, m3' = 2 (m3.n) n - m3, m3 being that of the
 * first one found. Nearly head-on the tilt is weakly determined, the other optimum
 * may lean more, and there may be a third one sideways. */
static void leaning_direction(rigcal_real m3[3], const rigcal_pose_solver *s,
                              const rigcal_real normal[3], int32_t lean)
{
    rigcal_real first[3], side[3], back[3];
    found_direction(first, s, 0);
    const rigcal_real along = rc_vec3_dot(first, normal);
    rc_vec3_cross(side, normal, first);
    if (!(rc_vec3_norm(side) > RC_TOL(1e-6, 1e-3))) { /* head-on: any way will do */
        rc_view_complete(side, back, normal);
    }
    rc_vec3_cross(back, normal, side); /* along n - m3: the other way */
    const rigcal_real *const way = (lean == OTHER_WAY) ? back : side;
    const rigcal_real far = rc_max(1, LEAN_LEAST / rc_vec3_norm(way));
    const rigcal_real signed_far = (lean == SIDEWAYS_BACK) ? -far : far;
    for (int k = 0; k < 3; k++) {
        m3[k] = along * normal[k] + signed_far * way[k];
    }
    (void)rc_vec3_unit(m3, m3);
}

/* The next lean that is worth it, or 0. */
RC_APART static int next_lean(rigcal_real m3[3], rigcal_pose_solver *s)
{
    rigcal_real first[3], normal[3], thickness;
    if (!rc_view_normal(normal, &thickness, &s->from.lattice.moments)) {
        return 0;
    }
    found_direction(first, s, 0);
    const rigcal_real most = (s->thorough ? HOPELESS : SHALLOW) *
                             rc_view_cost(&s->from.lattice.moments, first);
    while (s->leans < LEANS) {
        const int32_t lean = s->leans++;
        leaning_direction(m3, s, normal, lean);
        if (lean == OTHER_WAY || rc_view_cost(&s->from.lattice.moments, m3) < most) {
            return 1;
        }
    }
    return 0;
}

static void fit_of(rc_fit *fit, const rigcal_pose_solver *s)
{
    rc_fit_begin(fit, s->camera, s->observations, s->sigma, s->mask, s->n, s->origin);
}

/* A refinement has ended, where it may. */
RC_APART static void end_refinement(rigcal_pose_solver *s, const rc_fit *fit)
{
    const rigcal_refinement *const end = &s->work.fit;
    /* One that ran out of evaluations is on its way along a valley, likely to an
     * optimum that is found from elsewhere too. */
    if (end->status == RIGCAL_OK ||
        (end->status == RIGCAL_BUDGET_SPENT &&
         (s->n_found == 0 || end->sse < s->found[0].sse))) {
        insert_found(s, fit);
    } else if (end->status == RIGCAL_ERR_DEGENERATE) {
        s->failure = RIGCAL_ERR_DEGENERATE;
    }
    rigcal_real m3[3];
    if (s->n_exact > 0) {
        next_exact(s);
        return;
    }
    while (s->is_flat && s->n_found > 0 && next_lean(m3, s)) {
        if (begin_refining(s, m3, SAME_BASIN_LEANING)) {
            return;
        }
    }
    next_seed(s);
}

/* ---- is it good? --------------------------------------------------------- */

/* Sum of the squared errors [px^2] of optimum i, which without sigma is its sse. */
static rigcal_real squared_pixels(const rigcal_pose_solver *s, int32_t i)
{
    rigcal_transform cam_from_points;
    rigcal_real sum = 0;
    if (s->sigma == NULL) {
        return s->found[i].sse;
    }
    found_transform(&cam_from_points, &s->found[i]);
    for (size_t k = 0; k < s->n; k++) {
        const rigcal_observation *const o = &s->observations[k];
        rigcal_real x[3], X_c[3], uv[2];
        if (is_used(s->mask, k)) {
            rc_vec3_sub(x, o->X_w, s->origin);
            rc_transform_point(X_c, &cam_from_points, x);
            (void)rc_project(uv, NULL, s->camera, X_c);
            sum += (o->uv[0] - uv[0]) * (o->uv[0] - uv[0]) +
                   (o->uv[1] - uv[1]) * (o->uv[1] - uv[1]);
        }
    }
    return sum;
}

/* Whether noise alone has a chance below 1e-6 to make so large a sum: chi squared of
 * 2 n - 6 degrees of freedom by Wilson and Hilferty (1931), 4.75 standard deviations.
 * Three points have none; they fit nearly. */
static int is_above_noise(rigcal_real sum, rigcal_real noise, rigcal_real freedom)
{
    const rigcal_real dof = rc_max(1, freedom);
    const rigcal_real v = 2 / (9 * dof);
    const rigcal_real root = 1 - v + RC(4.75) * RC_SQRT(v);
    return !(sum <= noise * noise * dof * root * root * root);
}

static int is_poor(const rigcal_pose_solver *s)
{
    if (s->is_mirrored) {
        return 1;
    }
    if (s->sigma_px > 0) {
        return is_above_noise(s->found[0].sse, s->sigma_px, freedom(s));
    }
    const rigcal_real most = rc_max(NOISE_MOST, NOISE_MOST_PART * s->extent_px);
    return is_above_noise(squared_pixels(s, 0), most, freedom(s));
}

/* The search has ended; how well the observations fix its first pose is left to weigh:
 * by some of them, and if these leave it all but open by all. */
RC_APART static void begin_weighing(rigcal_pose_solver *s, int32_t by_all)
{
    s->phase = DONE;
    if (s->n_found > 0) {
        found_transform(&s->work.fit.cam_from_points, &s->found[0]);
        rc_refine_begin(&s->work.fit);
        s->weighed_by_all = by_all || s->n <= VAGUE_POINTS;
        s->phase = WEIGHING;
    }
}

RC_APART static void end_weighing(rigcal_pose_solver *s)
{
    const rigcal_real dof = rc_max(1, freedom(s));
    const rigcal_real noise =
        (s->sigma_px > 0)
            ? s->sigma_px
            : rc_max(VAGUE_NOISE, RC_SQRT(s->found[0].sse / dof));
    rigcal_real variance;
    s->is_vague = s->work.fit.status < 0 ||
                  !rc_refine_rotation_variance(&variance, s->work.fit.H) ||
                  !(noise * noise * variance <= VAGUE * VAGUE);
    s->phase = DONE;
    if (s->is_vague && !s->weighed_by_all) {
        begin_weighing(s, 1);
    }
}

/* A warm start that ended elsewhere than at the pose shows by its error. */
static int is_warm_good(const rigcal_pose_solver *s)
{
    if (s->n_found == 0) {
        return 0;
    }
    if (s->sigma_px > 0) {
        return !is_poor(s);
    }
    const rigcal_real limit = rc_max(WARM_NOISE, WARM_ERROR * s->extent_px);
    return squared_pixels(s, 0) <= (rigcal_real)s->n_used * limit * limit;
}

/* ---- the phases ---------------------------------------------------------- */

RC_APART static void end_warm(rigcal_pose_solver *s, const rc_fit *fit)
{
    if (s->work.fit.status >= 0) {
        insert_found(s, fit);
    }
    if (is_warm_good(s)) {
        begin_weighing(s, 0);
    } else {
        s->n_found = 0;
        s->phase = GATHERING;
    }
}

static void begin_warm(rigcal_pose_solver *s, const rigcal_transform *start)
{
    rigcal_transform *const cam_from_points = &s->work.fit.cam_from_points;
    *cam_from_points = *start;
    rc_transform_point(cam_from_points->t, start, s->origin);
    rc_refine_begin(&s->work.fit);
    s->phase = WARM;
}

RC_APART static void gathering_step(rigcal_pose_solver *s)
{
    int32_t at = -1;
    rigcal_real uv_middle[2];
    find_middle(s->origin, uv_middle, s->observations, s->sigma, s->mask, s->n);
    s->failure = gather(s, &at, uv_middle);
    if (s->failure == RIGCAL_OK) {
        begin_search(s);
    } else {
        s->phase = DONE;
    }
}

static int is_refining(const rigcal_pose_solver *s)
{
    return s->phase == WARM || s->phase == REFINING || s->phase == MIRRORED ||
           s->phase == WEIGHING;
}

/* Evaluations as long as they are those of a refinement, or of the search. What is
 * left of the budget. */
RC_APART static int32_t refine(rigcal_pose_solver *s, int32_t budget)
{
    rc_fit fit;
    const int32_t most = s->thorough ? REFINE_EVALS_THOROUGH : REFINE_EVALS;
    fit_of(&fit, s);
    for (; budget > 0 && is_refining(s); budget--) {
        fit.is_mirrored = (s->phase == MIRRORED);
        fit.n = (s->phase == WEIGHING && !s->weighed_by_all) ? VAGUE_POINTS : s->n;
        rc_refine_step(&s->work.fit, &fit, most);
        if (s->phase == WEIGHING) {
            end_weighing(s);
            continue;
        }
        if (s->work.fit.status == RIGCAL_RUNNING) {
            continue;
        }
        if (s->phase == MIRRORED) {
            end_mirrored(s);
        } else if (s->phase == WARM) {
            end_warm(s, &fit);
        } else {
            end_refinement(s, &fit);
        }
    }
    return budget;
}

RC_APART static int32_t search(rigcal_pose_solver *s, int32_t budget)
{
    for (; budget > 0 && s->phase != DONE && !is_refining(s); budget--) {
        if (s->phase == LATTICE_SCAN) {
            lattice_step(s);
        } else if (s->phase == DESCENT) {
            descent_step(s);
        } else {
            gathering_step(s);
        }
    }
    return budget;
}

/* ---- public -------------------------------------------------------------- */

rigcal_status rigcal_pose_defaults(rigcal_pose_options *options)
{
    if (options == NULL) {
        return RIGCAL_ERR_NULL;
    }
    options->thorough = 0;
    options->use_start = 0;
    options->sigma_px = 0;
    rc_transform_identity(&options->start);
    return RIGCAL_OK;
}

/* 0 for unknown, or a number whose square is one. */
static int is_noise(rigcal_real sigma_px)
{
    return rc_all_within(&sigma_px, 1, 0) ||
           (sigma_px >= SIGMA_MIN && sigma_px <= SIGMA_MAX);
}

static size_t count_used(const uint8_t mask[], size_t n)
{
    size_t count = n;
    for (size_t i = 0; mask != NULL && i < n; i++) {
        count -= (mask[i] == 0);
    }
    return count;
}

static rigcal_status check_options(const rigcal_pose_options *o)
{
    if (!rc_is_finite(o->sigma_px)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    if ((o->thorough != 0 && o->thorough != 1) ||
        (o->use_start != 0 && o->use_start != 1) ||
        !is_noise(o->sigma_px)) {
        return RIGCAL_ERR_RANGE;
    }
    return o->use_start ? rc_check_transform(&o->start) : RIGCAL_OK;
}

/* All that can be wrong with the arguments. */
RC_APART static rigcal_status check_arguments(int32_t *at, const rigcal_camera *camera,
                                     const rigcal_observation observations[],
                                     const rigcal_real sigma[],
                                     const uint8_t mask[], size_t n,
                                     const rigcal_pose_options *options)
{
    rigcal_status status = RIGCAL_ERR_NULL;
    if (observations != NULL) {
        status = rc_check_camera(camera);
    }
    if (status == RIGCAL_OK && options != NULL) {
        status = check_options(options);
    }
    if (status == RIGCAL_OK && n > RC_COUNT_MAX) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK && count_used(mask, n) < 3) {
        status = RIGCAL_ERR_TOO_FEW;
    }
    return (status == RIGCAL_OK) ? check_data(at, observations, sigma, mask, n)
                                 : status;
}

rigcal_status rc_pose_begin(rigcal_pose_solver *solver, int32_t *at,
                            const rigcal_camera *camera,
                            const rigcal_observation observations[],
                            const rigcal_real sigma[], const uint8_t mask[],
                            size_t n, const rigcal_pose_options *options)
{
    rigcal_real uv_middle[2];
    const int is_warm = options != NULL && options->use_start;
    *at = -1;
    rigcal_status status = check_arguments(at, camera, observations, sigma, mask, n,
                                           options);
    if (status != RIGCAL_OK) {
        return status;
    }
    *solver = (rigcal_pose_solver){0};
    solver->camera = camera;
    solver->observations = observations;
    solver->sigma = sigma;
    solver->mask = mask;
    solver->n = n;
    solver->n_used = count_used(mask, n);
    if (options != NULL) {
        solver->thorough = options->thorough;
        solver->sigma_px = options->sigma_px;
    }
    find_middle(solver->origin, uv_middle, observations, sigma, mask, n);
    status = measure(solver, uv_middle);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (is_warm) {
        begin_warm(solver, &options->start);
        return RIGCAL_OK;
    }
    status = gather(solver, at, uv_middle);
    if (status == RIGCAL_OK) {
        begin_search(solver);
    }
    return status;
}

rigcal_status rigcal_pose_begin(rigcal_pose_solver *solver, int32_t *bad,
                                const rigcal_camera *camera,
                                const rigcal_observation observations[],
                                const rigcal_real sigma[], size_t n,
                                const rigcal_pose_options *options)
{
    rigcal_pose_solver begun;
    int32_t at;
    if (solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status = rc_pose_begin(&begun, &at, camera, observations,
                                               sigma, NULL, n, options);
    if (status == RIGCAL_OK) {
        *solver = begun;
    } else if (bad != NULL) {
        *bad = at;
    }
    return status;
}

rigcal_status rigcal_pose_step(rigcal_pose_solver *solver, int32_t budget)
{
    if (solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (budget < 1) {
        return RIGCAL_ERR_RANGE;
    }
    if (solver->phase <= NOT_BEGUN || solver->phase > DONE) {
        return RIGCAL_ERR_STATE;
    }
    while (budget > 0 && solver->phase != DONE) {
        budget = is_refining(solver) ? refine(solver, budget) : search(solver, budget);
    }
    return (solver->phase == DONE) ? RIGCAL_OK : RIGCAL_RUNNING;
}

static void set_probabilities(rigcal_pose poses[], size_t n_written,
                              const rigcal_pose_solver *s)
{
    rigcal_real total = 0;
    for (int32_t i = 0; i < s->n_found; i++) {
        total += rc_pose_likelihood(s, i);
    }
    for (size_t i = 0; i < n_written; i++) {
        poses[i].probability = rc_pose_likelihood(s, (int32_t)i) / total;
    }
}

/* A pose as the caller knows it: of the world's origin, with its error in px. */
static void write_pose(rigcal_pose *out, const rigcal_pose_solver *s, int32_t i)
{
    rigcal_transform *const pose = &out->cam_from_world;
    rigcal_real turned[3];
    found_transform(pose, &s->found[i]);
    rc_mat3_mul_vec3(turned, pose->R, s->origin);
    rc_vec3_sub(pose->t, s->found[i].t, turned);
    out->sse = s->found[i].sse;
    out->rms_px = RC_SQRT(squared_pixels(s, i) / (rigcal_real)s->n_used);
}

rigcal_status rigcal_pose_result(rigcal_pose poses[], size_t *n_found,
                                 size_t capacity,
                                 const rigcal_pose_solver *solver)
{
    const rigcal_pose_solver *const s = solver;
    if (poses == NULL || n_found == NULL || s == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (capacity < 1) {
        return RIGCAL_ERR_RANGE;
    }
    if (s->phase != DONE || s->n_found < 0 || s->n_found > RIGCAL_POSES_MAX) {
        return RIGCAL_ERR_STATE;
    }
    if (s->n_found == 0) {
        return (s->failure != 0) ? s->failure : RIGCAL_ERR_NO_POSE;
    }
    const size_t n = ((size_t)s->n_found < capacity) ? (size_t)s->n_found : capacity;
    for (size_t i = 0; i < n; i++) {
        write_pose(&poses[i], s, (int32_t)i);
    }
    set_probabilities(poses, n, s);
    *n_found = n;
    if (is_poor(s)) {
        return RIGCAL_POOR_FIT;
    }
    return (poses[0].probability >= SURE && !s->is_vague) ? RIGCAL_OK
                                                          : RIGCAL_AMBIGUOUS;
}

rigcal_status rigcal_solve_pose(rigcal_pose poses[], size_t *n_found,
                                size_t capacity, int32_t *bad,
                                const rigcal_camera *camera,
                                const rigcal_observation observations[],
                                const rigcal_real sigma[], size_t n,
                                const rigcal_pose_options *options)
{
    rigcal_pose_solver solver;
    int32_t at;
    if (poses == NULL || n_found == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (capacity < 1) {
        return RIGCAL_ERR_RANGE;
    }
    const rigcal_status status = rc_pose_begin(&solver, &at, camera, observations,
                                               sigma, NULL, n, options);
    if (status != RIGCAL_OK) {
        if (bad != NULL) {
            *bad = at;
        }
        return status;
    }
    while (solver.phase != DONE) {
        (void)rigcal_pose_step(&solver, INT32_MAX);
    }
    return rigcal_pose_result(poses, n_found, capacity, &solver);
}

/* ---- uncertainty --------------------------------------------------------- */

/* From t of the points' own origin to t of the world's: t = t' - R o, so
 * dt = dt' - w x R o. The camera's centre is -R^T t: with w and dt in the camera's
 * axes, d(-R^T t) = -R^T (dt - w x t). Both are Sigma <- A Sigma A^T with
 * A = (1 0; [s]x 1), s = R o and s = t. */
static void shift_covariance(rigcal_real Sigma[36], const rigcal_real s[3])
{
    const rigcal_real S[9] = {0, -s[2], s[1], s[2], 0, -s[0], -s[1], s[0], 0};
    for (int j = 0; j < 6; j++) { /* rows: dt += [s]x w */
        for (int r = 0; r < 3; r++) {
            for (int k = 0; k < 3; k++) {
                Sigma[6 * (3 + r) + j] += S[3 * r + k] * Sigma[6 * k + j];
            }
        }
    }
    for (int j = 0; j < 6; j++) { /* columns */
        for (int r = 0; r < 3; r++) {
            for (int k = 0; k < 3; k++) {
                Sigma[6 * j + 3 + r] += S[3 * r + k] * Sigma[6 * j + k];
            }
        }
    }
}

/* 1-sigma along the world's axes of a covariance block given in the camera's. */
static void center_sigmas(rigcal_real out[3], const rigcal_real Sigma[36],
                          const rigcal_real R[9])
{
    for (int i = 0; i < 3; i++) {
        rigcal_real variance = 0;
        for (int r = 0; r < 3; r++) {
            for (int c = 0; c < 3; c++) {
                variance += R[3 * r + i] * Sigma[6 * (3 + r) + 3 + c] * R[3 * c + i];
            }
        }
        out[i] = RC_SQRT(rc_max(0, variance));
    }
}

static void fill_uncertainty(rigcal_pose_uncertainty *out,
                             const rigcal_transform *cam_from_world,
                             const rigcal_real at_points[36],
                             const rigcal_real turned_origin[3],
                             rigcal_real noise2)
{
    rigcal_real at_center[36];
    for (int k = 0; k < 36; k++) {
        out->Sigma[k] = noise2 * at_points[k];
    }
    shift_covariance(out->Sigma, turned_origin);
    for (int k = 0; k < 36; k++) {
        at_center[k] = out->Sigma[k];
    }
    shift_covariance(at_center, cam_from_world->t);
    center_sigmas(out->center, at_center, cam_from_world->R);
    for (int k = 0; k < 3; k++) {
        out->rotation[k] = RC_SQRT(out->Sigma[7 * k]);
        out->translation[k] = RC_SQRT(rc_max(0, out->Sigma[7 * (3 + k)]));
    }
    out->sigma_px = RC_SQRT(noise2);
}

/* Rounding may hide from the normal equations that a line fixes no turn about
 * itself; the points do not. */
static int is_line(const rigcal_observation o[], const rigcal_real origin[3],
                   size_t n)
{
    static const rigcal_real NO_IMAGE[2] = {0, 0};
    rigcal_view_moments moments;
    rigcal_real normal[3], thickness, x[3];
    rc_view_begin(&moments);
    for (size_t i = 0; i < n; i++) {
        rc_vec3_sub(x, o[i].X_w, origin);
        rc_view_add(&moments, 1, x, NO_IMAGE);
    }
    return !rc_view_normal(normal, &thickness, &moments);
}

rigcal_status rigcal_pose_covariance(
    rigcal_pose_uncertainty *out, const rigcal_camera *camera,
    const rigcal_transform *cam_from_world,
    const rigcal_observation observations[], const rigcal_real sigma[], size_t n,
    rigcal_real sigma_px)
{
    int32_t at;
    if (out == NULL || observations == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_camera(camera);
    if (status == RIGCAL_OK) {
        status = rc_check_transform(cam_from_world);
    }
    if (status == RIGCAL_OK && !rc_is_finite(sigma_px)) {
        status = RIGCAL_ERR_NOT_FINITE;
    }
    if (status == RIGCAL_OK && (!is_noise(sigma_px) || n > RC_COUNT_MAX)) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK && (n < 3 || (n == 3 && !(sigma_px > 0)))) {
        status = RIGCAL_ERR_TOO_FEW;
    }
    if (status == RIGCAL_OK) {
        status = check_data(&at, observations, sigma, NULL, n);
    }
    if (status != RIGCAL_OK) {
        return status;
    }

    rigcal_real origin[3], uv_middle[2], sse, g[6], H[21], at_points[36], turned[3];
    rigcal_transform cam_from_points = *cam_from_world;
    rc_fit fit;
    find_middle(origin, uv_middle, observations, sigma, NULL, n);
    if (is_line(observations, origin, n)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    rc_fit_begin(&fit, camera, observations, sigma, NULL, n, origin);
    rc_transform_point(cam_from_points.t, cam_from_world, origin);
    status = rc_normal_equations(&sse, g, H, &fit, &cam_from_points);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!rc_refine_covariance(at_points, H)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    rc_mat3_mul_vec3(turned, cam_from_world->R, origin);
    fill_uncertainty(out, cam_from_world, at_points, turned,
                     (sigma_px > 0) ? sigma_px * sigma_px
                                    : sse / (rigcal_real)(2 * n - 6));
    return RIGCAL_OK;
}
