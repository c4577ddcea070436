#include "rc_pose.h"

/* Directions of the lattice, and how many of the best are followed. */
enum { LATTICE = 24, LATTICE_THOROUGH = 96 };
enum { FOLLOWED = 3, FOLLOWED_THOROUGH = RIGCAL_POSE_SEEDS - 1 };

/* A descent: the simplex's first edge [rad], about half the lattice's spacing, and
 * its evaluations. It only has to land where refinement converges. */
#define EDGE RC(0.3)
enum { DESCENT_EVALS = 10, DESCENT_EVALS_THOROUGH = 20, REFINE_EVALS = 60 };

/* A target whose mean square across its plane is below this part of the whole has
 * a second optimum, the pose mirrored in the line of sight. */
#define FLAT_THICKNESS RC(0.05)

/* A direction whose cost is so many times the least is no optimum worth refining,
 * unless the target is flat: its second optimum may be as bad. */
#define HOPELESS RC(100)

/* A seed so near to an optimum found [rad] was on its way there; the mirrored one,
 * which starts where its optimum is expected, may be nearer. Two optima closer than
 * the last are one. */
#define SAME_BASIN RC(0.25)
#define SAME_BASIN_MIRRORED RC(0.05)
#define SAME_POSE RC(2e-3)

/* A refinement that did not end counts unless its sum is so many times the best. */
#define STRAY RC(10)

/* Noise, stated in pixels or relative, outside which it is a mistake. */
#define SIGMA_MIN RC(1e-6)
#define SIGMA_MAX RC(1e6)

/* Least noise assumed where none is stated [px]. */
#define NOISE_LEAST RC(0.01)

/* The first pose is sure from here on. */
#define SURE RC(0.99)

/* A warm start proves bad when its error is above this part of the target's image. */
#define WARM_ERROR RC(0.02)

/* Rays so far off the middle of the target's image do not fit the virtual camera:
 * cosine of 80 degrees. */
#define WIDE_COSINE RC(0.17)

enum { NOT_BEGUN = 0, WARM, LATTICE_SCAN, DESCENT, REFINING, DONE };

/* ---- the data ------------------------------------------------------------ */

static rigcal_real weight_of(const rigcal_real sigma[], size_t i)
{
    return (sigma == NULL) ? 1 : 1 / (sigma[i] * sigma[i]);
}

static rigcal_status check_data(int32_t *at, const rigcal_observation o[],
                                const rigcal_real sigma[], size_t n)
{
    for (size_t i = 0; i < n; i++) {
        *at = (int32_t)i;
        if (!rc_all_finite(o[i].X_w, 3) || !rc_all_finite(o[i].uv, 2) ||
            (sigma != NULL && !rc_is_finite(sigma[i]))) {
            return RIGCAL_ERR_NOT_FINITE;
        }
        if (!rc_all_within(o[i].X_w, 3, RC_COORDINATE_MAX) ||
            !rc_all_within(o[i].uv, 2, RC_PIXEL_MAX) ||
            (sigma != NULL && !(sigma[i] >= SIGMA_MIN && sigma[i] <= SIGMA_MAX))) {
            return RIGCAL_ERR_RANGE;
        }
    }
    *at = -1;
    return RIGCAL_OK;
}

/* The weighted mean of the points, and the pixel in the middle of their image. */
static void find_middle(rigcal_real origin[3], rigcal_real uv_middle[2],
                        const rigcal_observation o[], const rigcal_real sigma[],
                        size_t n)
{
    rigcal_real total = 0, shift[3] = {0, 0, 0};
    uv_middle[0] = uv_middle[1] = 0;
    for (size_t i = 0; i < n; i++) { /* from the first point: far origins */
        rigcal_real x[3];
        const rigcal_real weight = weight_of(sigma, i);
        rc_vec3_sub(x, o[i].X_w, o[0].X_w);
        rc_vec3_add_scaled(shift, weight, x);
        uv_middle[0] += o[i].uv[0];
        uv_middle[1] += o[i].uv[1];
        total += weight;
    }
    for (int k = 0; k < 3; k++) {
        origin[k] = o[0].X_w[k] + shift[k] / total;
    }
    uv_middle[0] /= (rigcal_real)n;
    uv_middle[1] /= (rigcal_real)n;
}

/* Whether the points have a shape, and the scale that makes its size 1. */
static rigcal_status check_shape(rigcal_real *scale, const rigcal_pose_solver *s)
{
    rigcal_real size = 0, largest = 0;
    for (size_t i = 0; i < s->n; i++) { /* differences of two points are exact */
        rigcal_real x[3];
        rc_vec3_sub(x, s->observations[i].X_w, s->observations[0].X_w);
        size = rc_max(size, rc_vec3_norm(x));
        largest = rc_max(largest, rc_vec3_max_abs(s->observations[i].X_w));
    }
    if (!(size > 1 / RC_COORDINATE_MAX)) {
        return RIGCAL_ERR_COINCIDENT;
    }
    *scale = 1 / size;
    return (largest * RC_EPS <= RC_SHAPE_ROUNDING * size) ? RIGCAL_OK
                                                       : RIGCAL_ERR_PRECISION;
}

/* Rotation whose third row is the unit vector `axis`. */
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
        const rigcal_status status =
            rc_pixel_to_ray(ray, s->camera, s->observations[i].uv);
        if (status != RIGCAL_OK) {
            *at = (int32_t)i;
            return status;
        }
        rc_vec3_add_scaled(sum, 1, ray);
    }
    return rc_vec3_unit(middle, sum) ? RIGCAL_OK : RIGCAL_ERR_WIDE_RAY;
}

/* The moments, with points scaled to size 1 and rays turned to the middle. */
static rigcal_status gather(rigcal_pose_solver *s, int32_t *at, rigcal_real scale)
{
    rc_view_begin(&s->moments);
    for (size_t i = 0; i < s->n; i++) {
        rigcal_real x[3], ray[3], turned[3];
        *at = (int32_t)i;
        const rigcal_status status =
            rc_pixel_to_ray(ray, s->camera, s->observations[i].uv);
        if (status != RIGCAL_OK) {
            return status;
        }
        rc_mat3_mul_vec3(turned, s->virtual_from_cam, ray);
        if (!(turned[2] > WIDE_COSINE)) {
            return RIGCAL_ERR_WIDE_RAY;
        }
        const rigcal_real u[2] = {turned[0] / turned[2], turned[1] / turned[2]};
        rc_vec3_sub(x, s->observations[i].X_w, s->origin);
        for (int k = 0; k < 3; k++) {
            x[k] *= scale;
        }
        rc_view_add(&s->moments, weight_of(s->sigma, i), x, u);
    }
    *at = -1;
    return rc_view_finish(&s->moments) ? RIGCAL_OK : RIGCAL_ERR_COINCIDENT;
}

/* ---- seeds --------------------------------------------------------------- */

/* Direction i of a Fibonacci sphere of n: heights in even steps, azimuths a golden
 * angle apart, which s->spiral carries on from call to call. */
static void next_direction(rigcal_real m3[3], rigcal_pose_solver *s, int32_t i,
                           int32_t n)
{
    static const rigcal_real GOLDEN_COS = RC(-0.73736887807831989);
    static const rigcal_real GOLDEN_SIN = RC(0.67549029426152364);
    const rigcal_real c = s->spiral[0], d = s->spiral[1];
    m3[2] = 1 - (rigcal_real)(2 * i + 1) / (rigcal_real)n;
    const rigcal_real r = RC_SQRT(1 - m3[2] * m3[2]);
    m3[0] = r * c;
    m3[1] = r * d;
    s->spiral[0] = c * GOLDEN_COS - d * GOLDEN_SIN;
    s->spiral[1] = c * GOLDEN_SIN + d * GOLDEN_COS;
}

/* Keeps the `most` best directions in order of cost. */
static void insert_seed(rigcal_pose_solver *s, const rigcal_real m3[3],
                        rigcal_real cost, int32_t most)
{
    int32_t at = (s->n_seeds < most) ? s->n_seeds++ : most;
    for (; at > 0 && cost < s->seed[at - 1][3]; at--) {
        for (int k = 0; k < 4 && at < most; k++) {
            s->seed[at][k] = s->seed[at - 1][k];
        }
    }
    if (at < most) {
        for (int k = 0; k < 3; k++) {
            s->seed[at][k] = m3[k];
        }
        s->seed[at][3] = cost;
    }
}

static void begin_descent(rigcal_pose_solver *s)
{
    static const rigcal_real SIMPLEX[6] = {0, 0, EDGE, 0, 0, EDGE};
    (void)rigcal_neldermead_begin_simplex(
        &s->nm, SIMPLEX, 2, RC(1e-4), 0,
        s->options.thorough ? DESCENT_EVALS_THOROUGH : DESCENT_EVALS);
    rc_neldermead_tell(&s->nm, s->seed[s->next][3]); /* known already */
    s->phase = DESCENT;
}

/* The direction at (a, b) in the plane that touches the sphere at a seed. */
static void direction_near(rigcal_real m3[3], const rigcal_real seed[3],
                           const rigcal_real ab[2])
{
    rigcal_real R[9];
    look_along(R, seed);
    for (int k = 0; k < 3; k++) {
        m3[k] = seed[k] + ab[0] * R[k] + ab[1] * R[3 + k];
    }
    const rigcal_real by_length = 1 / rc_vec3_norm(m3);
    for (int k = 0; k < 3; k++) {
        m3[k] *= by_length;
    }
}

static void begin_refining(rigcal_pose_solver *s);

/* Sorts the followed seeds, whose costs the descents have lowered. */
static void sort_seeds(rigcal_pose_solver *s)
{
    const int32_t n = s->n_seeds;
    s->n_seeds = 0;
    for (int32_t i = 0; i < n; i++) {
        const rigcal_real seed[4] = {s->seed[i][0], s->seed[i][1], s->seed[i][2],
                                     s->seed[i][3]};
        insert_seed(s, seed, seed[3], RIGCAL_POSE_SEEDS);
    }
}

static void end_descent(rigcal_pose_solver *s)
{
    rigcal_real ab[3] = {0, 0, 0}, cost, m3[3];
    if (rigcal_neldermead_result(ab, &cost, NULL, &s->nm) >= 0) {
        direction_near(m3, s->seed[s->next], ab);
        for (int k = 0; k < 3; k++) {
            s->seed[s->next][k] = m3[k];
        }
        s->seed[s->next][3] = cost;
    }
    if (++s->next < s->n_seeds) {
        begin_descent(s);
        return;
    }
    sort_seeds(s);
    s->next = 0;
    begin_refining(s);
}

static void lattice_step(rigcal_pose_solver *s)
{
    const int32_t n = s->options.thorough ? LATTICE_THOROUGH : LATTICE;
    rigcal_real m3[3];
    next_direction(m3, s, s->next, n);
    insert_seed(s, m3, rc_view_cost(&s->moments, m3),
                s->options.thorough ? FOLLOWED_THOROUGH : FOLLOWED);
    if (++s->next == n) {
        s->next = 0;
        begin_descent(s);
    }
}

static void descent_step(rigcal_pose_solver *s)
{
    rigcal_real m3[3];
    direction_near(m3, s->seed[s->next], s->nm.trial);
    rc_neldermead_tell(&s->nm, rc_view_cost(&s->moments, m3));
    if (s->nm.status != RIGCAL_RUNNING) {
        end_descent(s);
    }
}

/* ---- refinement ---------------------------------------------------------- */

/* Least angle between a rotation and those found. */
static int is_near_found(const rigcal_pose_solver *s, const rigcal_real R[9],
                         rigcal_real angle)
{
    for (int32_t i = 0; i < s->n_found; i++) {
        const rigcal_real *const F = s->found[i].cam_from_world.R;
        rigcal_real squared = 0; /* |R - F|^2 = 8 sin^2(angle / 2) */
        for (int k = 0; k < 9; k++) {
            squared += (R[k] - F[k]) * (R[k] - F[k]);
        }
        if (squared < 2 * angle * angle) {
            return 1;
        }
    }
    return 0;
}

/* Camera from points, in the caller's unit, of a seed's direction. */
static void seed_pose(rigcal_transform *cam_from_points,
                      const rigcal_pose_solver *s, const rigcal_real m3[3])
{
    rigcal_transform virtual_from_points;
    const rigcal_real *const V = s->virtual_from_cam;
    rc_view_pose(&virtual_from_points, &s->moments, m3);
    for (int row = 0; row < 3; row++) { /* V^T R */
        for (int column = 0; column < 3; column++) {
            cam_from_points->R[3 * row + column] =
                V[row] * virtual_from_points.R[column] +
                V[3 + row] * virtual_from_points.R[3 + column] +
                V[6 + row] * virtual_from_points.R[6 + column];
        }
    }
    rc_mat3_tmul_vec3(cam_from_points->t, V, virtual_from_points.t);
    for (int k = 0; k < 3; k++) {
        cam_from_points->t[k] /= s->scale;
    }
}

/* A flat target's other optimum lies where the line of sight is mirrored in the
 * target's normal n: m3' = 2 (m3.n) n - m3, m3 being that of the first one found. */
static void add_mirrored_seed(rigcal_pose_solver *s)
{
    rigcal_real m3[3], normal[3], thickness;
    rigcal_real *const mirrored = s->seed[s->n_seeds];
    rc_mat3_tmul_vec3(m3, s->found[0].cam_from_world.R, &s->virtual_from_cam[6]);
    if (!rc_view_normal(normal, &thickness, &s->moments)) {
        return;
    }
    const rigcal_real along = 2 * rc_vec3_dot(m3, normal);
    for (int k = 0; k < 3; k++) {
        mirrored[k] = along * normal[k] - m3[k];
    }
    mirrored[3] = rc_view_cost(&s->moments, mirrored);
    s->mirrored = s->n_seeds++;
}

/* The next seed that is worth it, or the end. */
static void begin_refining(rigcal_pose_solver *s)
{
    const rigcal_real hopeless = HOPELESS * s->seed[0][3];
    s->phase = REFINING;
    for (; s->next < s->n_seeds; s->next++) {
        const rigcal_real *const seed = s->seed[s->next];
        rigcal_transform start;
        if (!(seed[3] < RC_MAX) ||
            (s->n_found > 0 && !s->is_flat && seed[3] > hopeless)) {
            continue;
        }
        seed_pose(&start, s, seed);
        if (!is_near_found(s, start.R, (s->next == s->mirrored)
                                           ? SAME_BASIN_MIRRORED
                                           : SAME_BASIN)) {
            rc_refine_begin(&s->fit, &start);
            return;
        }
    }
    s->phase = DONE;
}

/* Refinement sees to it that the points are in front; whether a lens that turns back
 * sees them is asked once. */
static int is_seen(const rigcal_pose_solver *s, const rigcal_transform *pose)
{
    rc_lens lens;
    rc_lens_of(&lens, s->camera);
    if (lens.is_pinhole) {
        return 1;
    }
    for (size_t i = 0; i < s->n; i++) {
        rigcal_real x[3], X_c[3], uv[2];
        rc_vec3_sub(x, s->observations[i].X_w, s->origin);
        rc_transform_point(X_c, pose, x);
        if (rc_project_usable(uv, s->camera, X_c) != RIGCAL_OK) {
            return 0;
        }
    }
    return 1;
}

/* Keeps the RIGCAL_POSES_MAX best poses in order; those of camera from points. */
static void insert_found(rigcal_pose_solver *s)
{
    const rigcal_transform *const pose = &s->fit.cam_from_points;
    if (is_near_found(s, pose->R, SAME_POSE) || !is_seen(s, pose)) {
        return;
    }
    int32_t at = (s->n_found < RIGCAL_POSES_MAX) ? s->n_found++ : RIGCAL_POSES_MAX;
    for (; at > 0 && s->fit.sse < s->found[at - 1].sse; at--) {
        if (at < RIGCAL_POSES_MAX) {
            s->found[at] = s->found[at - 1];
        }
    }
    if (at < RIGCAL_POSES_MAX) {
        s->found[at].cam_from_world = *pose;
        s->found[at].sse = s->fit.sse;
    }
}

static void fit_of(rc_fit *fit, const rigcal_pose_solver *s)
{
    fit->camera = s->camera;
    fit->observations = s->observations;
    fit->sigma = s->sigma;
    fit->n = s->n;
    fit->origin = s->origin;
    rc_lens_of(&fit->lens, s->camera);
}

/* A refinement has ended, where it may. */
static void end_refinement(rigcal_pose_solver *s)
{
    /* One that ran out of evaluations is near an optimum in a valley, or nowhere. */
    if (s->fit.status == RIGCAL_OK ||
        (s->fit.status == RIGCAL_BUDGET_SPENT &&
         (s->n_found == 0 || s->fit.sse < STRAY * s->found[0].sse))) {
        insert_found(s);
    } else if (s->fit.status == RIGCAL_ERR_DEGENERATE) {
        s->failure = RIGCAL_ERR_DEGENERATE;
    }
    if (s->is_flat && s->n_found == 1 && s->mirrored == 0) {
        add_mirrored_seed(s);
    }
    s->next++;
    begin_refining(s);
}

/* ---- warm start ---------------------------------------------------------- */

static void begin_search(rigcal_pose_solver *s)
{
    s->phase = LATTICE_SCAN;
    s->next = 0;
    s->n_seeds = 0;
    s->mirrored = 0;
    s->spiral[0] = 1;
    s->spiral[1] = 0;
}

/* What the noise of one coordinate may be, squared. */
static rigcal_real noise_squared(const rigcal_pose_solver *s)
{
    const rigcal_real stated = s->options.sigma_px;
    if (stated > 0) {
        return stated * stated;
    }
    return rc_max(s->found[0].sse / (rigcal_real)(2 * s->n - 6),
                  NOISE_LEAST * NOISE_LEAST);
}

/* Chance below 1e-6 that noise alone makes a sum so large: chi squared of 2 n - 6
 * degrees of freedom by Wilson and Hilferty (1931), 4.75 standard deviations. */
static int is_poor(const rigcal_pose_solver *s, rigcal_real noise2)
{
    const rigcal_real dof = (rigcal_real)(2 * s->n - 6);
    const rigcal_real v = 2 / (9 * dof);
    const rigcal_real root = 1 - v + RC(4.75) * RC_SQRT(v);
    return !(s->found[0].sse <= noise2 * dof * root * root * root);
}

/* A warm start that ended elsewhere than at the pose shows by its error. */
static int is_warm_good(const rigcal_pose_solver *s)
{
    if (s->n_found == 0) {
        return 0;
    }
    if (s->options.sigma_px > 0) {
        return !is_poor(s, noise_squared(s));
    }
    const rigcal_real limit = WARM_ERROR * s->extent_px;
    return s->found[0].sse <= (rigcal_real)s->n * limit * limit;
}

static void end_warm(rigcal_pose_solver *s)
{
    if (s->fit.status >= 0) {
        insert_found(s);
    }
    if (is_warm_good(s)) {
        s->phase = DONE;
    } else {
        s->n_found = 0;
        begin_search(s);
    }
}

static void begin_warm(rigcal_pose_solver *s)
{
    const rigcal_transform *const start = &s->options.start;
    rigcal_transform cam_from_points = *start;
    rc_transform_point(cam_from_points.t, start, s->origin);
    rc_refine_begin(&s->fit, &cam_from_points);
    s->phase = WARM;
}

static void refine_step(rigcal_pose_solver *s)
{
    rc_fit fit;
    fit_of(&fit, s);
    rc_refine_step(&s->fit, &fit, REFINE_EVALS);
    if (s->fit.status == RIGCAL_RUNNING) {
        return;
    }
    if (s->phase == WARM) {
        end_warm(s);
    } else {
        end_refinement(s);
    }
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

/* Everything that can be wrong, and what the search needs to start. */
static rigcal_status prepare(rigcal_pose_solver *s, int32_t *at)
{
    rigcal_real uv_middle[2], middle[3], normal[3], thickness;
    find_middle(s->origin, uv_middle, s->observations, s->sigma, s->n);
    rigcal_status status = check_shape(&s->scale, s);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (rc_pixel_to_ray(middle, s->camera, uv_middle) != RIGCAL_OK) {
        status = middle_ray(middle, at, s);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    look_along(s->virtual_from_cam, middle);
    status = gather(s, at, s->scale);
    if (status != RIGCAL_OK) {
        return status;
    }
    for (size_t i = 0; i < s->n; i++) {
        const rigcal_real du = s->observations[i].uv[0] - uv_middle[0];
        const rigcal_real dv = s->observations[i].uv[1] - uv_middle[1];
        s->extent_px = rc_max(s->extent_px, RC_SQRT(du * du + dv * dv));
    }
    if (!rc_view_normal(normal, &thickness, &s->moments)) {
        return RIGCAL_ERR_COLLINEAR;
    }
    s->is_flat = thickness < FLAT_THICKNESS;
    return RIGCAL_OK;
}

/* rigcal_pose_begin, but that a failure may leave *solver written. */
static rigcal_status begin(rigcal_pose_solver *solver, int32_t *bad,
                           const rigcal_camera *camera,
                           const rigcal_observation observations[],
                           const rigcal_real sigma[], size_t n,
                           const rigcal_pose_options *options)
{
    int32_t at = -1;
    rigcal_status status = RIGCAL_ERR_NULL;
    if (observations != NULL) {
        status = rc_check_camera(camera);
    }
    if (status == RIGCAL_OK && options != NULL) {
        status = check_options(options);
    }
    if (status == RIGCAL_OK && n < 4) {
        status = RIGCAL_ERR_TOO_FEW;
    }
    if (status == RIGCAL_OK && n > RC_COUNT_MAX) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK) {
        status = check_data(&at, observations, sigma, n);
    }
    if (status == RIGCAL_OK) {
        *solver = (rigcal_pose_solver){0};
        solver->camera = camera;
        solver->observations = observations;
        solver->sigma = sigma;
        solver->n = n;
        status = prepare(solver, &at);
    }
    if (status != RIGCAL_OK) {
        if (bad != NULL) {
            *bad = at;
        }
        return status;
    }
    (void)rigcal_pose_defaults(&solver->options);
    if (options != NULL) {
        solver->options = *options;
    }
    if (solver->options.use_start) {
        begin_warm(solver);
    } else {
        begin_search(solver);
    }
    return RIGCAL_OK;
}

rigcal_status rigcal_pose_begin(rigcal_pose_solver *solver, int32_t *bad,
                                const rigcal_camera *camera,
                                const rigcal_observation observations[],
                                const rigcal_real sigma[], size_t n,
                                const rigcal_pose_options *options)
{
    rigcal_pose_solver begun;
    if (solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    const rigcal_status status =
        begin(&begun, bad, camera, observations, sigma, n, options);
    if (status == RIGCAL_OK) {
        *solver = begun;
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
    for (int32_t i = 0; i < budget && solver->phase != DONE; i++) {
        solver->evals++;
        if (solver->phase == LATTICE_SCAN) {
            lattice_step(solver);
        } else if (solver->phase == DESCENT) {
            descent_step(solver);
        } else {
            refine_step(solver);
        }
    }
    return (solver->phase == DONE) ? RIGCAL_OK : RIGCAL_RUNNING;
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

/* (C): likelihood of pose i over that of the first. Noise known: exp(-sse / 2
 * noise^2). Unknown, it is integrated out with the prior 1 / noise, which leaves
 * sse^-(n - 3); the floor is what the least noise makes of the sum. */
static rigcal_real likelihood(const rigcal_pose_solver *s, int32_t i)
{
    const rigcal_real first = s->found[0].sse, other = s->found[i].sse;
    const rigcal_real stated = s->options.sigma_px;
    if (stated > 0) {
        return RC_EXP((first - other) / (2 * stated * stated));
    }
    const rigcal_real floor_sum =
        (rigcal_real)(2 * s->n - 6) * NOISE_LEAST * NOISE_LEAST;
    return power((first + floor_sum) / (other + floor_sum), s->n - 3);
}

static void set_probabilities(rigcal_pose poses[], size_t n_written,
                              const rigcal_pose_solver *s)
{
    rigcal_real total = 0;
    for (int32_t i = 0; i < s->n_found; i++) {
        total += likelihood(s, i);
    }
    for (size_t i = 0; i < n_written; i++) {
        poses[i].probability = likelihood(s, (int32_t)i) / total;
    }
}

/* A pose as the caller knows it: of the world's origin, with its error in px. */
static void write_pose(rigcal_pose *out, const rigcal_pose_solver *s, int32_t i)
{
    const rigcal_transform *const from_points = &s->found[i].cam_from_world;
    rigcal_real turned[3], sum = 0;
    rc_mat3_mul_vec3(turned, from_points->R, s->origin);
    *out = s->found[i];
    rc_vec3_sub(out->cam_from_world.t, from_points->t, turned);
    if (s->sigma == NULL) {
        sum = out->sse;
    }
    for (size_t k = 0; k < s->n && s->sigma != NULL; k++) {
        const rigcal_observation *const o = &s->observations[k];
        rigcal_real x[3], X_c[3], uv[2];
        rc_vec3_sub(x, o->X_w, s->origin);
        rc_transform_point(X_c, from_points, x);
        (void)rc_project(uv, NULL, s->camera, X_c);
        sum += (o->uv[0] - uv[0]) * (o->uv[0] - uv[0]) +
               (o->uv[1] - uv[1]) * (o->uv[1] - uv[1]);
    }
    out->rms_px = RC_SQRT(sum / (rigcal_real)s->n);
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
    const rigcal_real noise2 = noise_squared(s);
    for (size_t i = 0; i < n; i++) {
        write_pose(&poses[i], s, (int32_t)i);
    }
    set_probabilities(poses, n, s);
    *n_found = n;
    if (s->options.sigma_px > 0 && is_poor(s, noise2)) {
        return RIGCAL_POOR_FIT;
    }
    return (poses[0].probability >= SURE) ? RIGCAL_OK : RIGCAL_AMBIGUOUS;
}

rigcal_status rigcal_solve_pose(rigcal_pose poses[], size_t *n_found,
                                size_t capacity, int32_t *bad,
                                const rigcal_camera *camera,
                                const rigcal_observation observations[],
                                const rigcal_real sigma[], size_t n,
                                const rigcal_pose_options *options)
{
    rigcal_pose_solver solver;
    if (poses == NULL || n_found == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (capacity < 1) {
        return RIGCAL_ERR_RANGE;
    }
    const rigcal_status status =
        begin(&solver, bad, camera, observations, sigma, n, options);
    if (status != RIGCAL_OK) {
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
        status = check_data(&at, observations, sigma, n);
    }
    if (status != RIGCAL_OK) {
        return status;
    }

    rigcal_real origin[3], uv_middle[2], sse, g[6], H[21], at_points[36], turned[3];
    rigcal_transform cam_from_points = *cam_from_world;
    rc_fit fit;
    find_middle(origin, uv_middle, observations, sigma, n);
    if (is_line(observations, origin, n)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    fit.camera = camera;
    fit.observations = observations;
    fit.sigma = sigma;
    fit.n = n;
    fit.origin = origin;
    rc_lens_of(&fit.lens, camera);
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
