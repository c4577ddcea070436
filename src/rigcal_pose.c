#include "rc_pose.h"

/* Directions of the lattice, and how many of the best are followed. */
enum { LATTICE = 24, FOLLOWED = RIGCAL_POSE_SEEDS };

/* A descent: the simplex's first edge [rad], about half the lattice's spacing, and
 * its evaluations. It only has to land where refinement converges. */
#define EDGE RC(0.3)
enum { DESCENT_EVALS = 10, REFINE_EVALS = 100 };

/* A target of less thickness (rc_view_normal) has a second optimum, which leans the other
 * way. */
#define FLAT_THICKNESS RC(0.04)

/* Below this mirrored points have nearly the same image. */
#define PLANE_THICKNESS RC(1e-4)

/* A direction whose cost is so many times the least is no optimum worth refining, unless
 * the target is flat: its second optimum may be as bad. */
#define HOPELESS RC(100)

/* A flat target's seeds that lean other than its first optimum does: the least lean
 * [rad], and how many times the first one's cost that of sideways ones may be, over the
 * number of points: the least cost of few points may be small by chance. */
#define LEAN_LEAST RC(0.3)
#define SHALLOW RC(400)
enum { OTHER_WAY = 0, SIDEWAYS, SIDEWAYS_BACK, LEANS };

/* A seed so near to an optimum found [rad] is on its way there. Two optima closer than
 * SAME_POSE are one; those of three points may be about to merge, but are exact. */
#define SAME_BASIN RC(0.05)
#define SAME_POSE RC(2e-3)
#define SAME_EXACT RC_TOL(1e-6, 1e-3)

/* Points so near to each other are one; in sizes of the target. */
#define SAME_POINT RC_TOL(1e-9, 1e-5)

/* Noise, stated in pixels or relative, outside which it is a mistake. */
#define SIGMA_MIN RC(1e-6)
#define SIGMA_MAX RC(1e6)

/* Rounding of a pixel, as a part of the image's extent: a sum of squares that falls by its
 * square falls by nothing. */
#define ROUNDING (8 * RC_EPS)

/* Three points fit exactly when the sum of their squared errors is below this [px^2]. */
#define EXACT RC_TOL(1e-11, 1e-5)

/* Where no noise is stated: the least assumed [px], and the most that is believed of a
 * search and of a warm start [px], or as a part of the target's image where that is
 * more. */
#define NOISE_LEAST RC(0.01)
#define NOISE_MOST RC(2)
#define NOISE_WARM RC(0.55)
#define NOISE_PART RC(0.007)

/* So many standard deviations has noise a chance to go beyond of one in a million, which
 * makes a fit poor, and of one in a thousand, which only costs a search. */
#define DEVIATIONS RC(4.75)
#define DEVIATIONS_WARM RC(3.1)

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

/* The rays of a pinhole that are taken in one step. */
enum { PINHOLE_RAYS = 16 };

/* Rays so far off the middle of the target's image do not fit the virtual camera, and
 * triples of points take the place of the search: cosine of 80 degrees. */
#define SPREAD_COSINE RC(0.17)

/* A target with a ray this far off the camera's axis is wide: cosine of 60 degrees. There
 * pixels change so fast with the pose that a refinement needs a start that is nearly
 * right. */
#define WIDE_COSINE RC(0.5)

/* Triples that are tried: the first always, more until one leads to a pose that fits. */
enum { PICKS = 6 };

/* Whether there is code for rays that far off: it takes the poses of three points. */
enum { WITH_WIDE = RIGCAL_WITH_THREE_POINTS };

enum {
    NOT_BEGUN = 0,
    GATHERING,
    GATHERED,
    PICKING, /* a triple of rays far apart */
    SCANNING,
    DESCENT,
    REFINING,
    PROVING,
    CHOOSING, /* the next start */
    MIRRORED,
    WEIGHING,
    DONE
};

/* ---- the data ------------------------------------------------------------ */

RC_APART static rigcal_real weight_of(const rigcal_real sigma[], size_t i)
{
    return (sigma == NULL) ? 1 : 1 / (sigma[i] * sigma[i]);
}

static rigcal_status check_sigma(const rigcal_real *sigma)
{
    const rigcal_status status = rc_check_numbers(sigma, 1, SIGMA_MAX);
    return (status == RIGCAL_OK && !(*sigma >= SIGMA_MIN)) ? RIGCAL_ERR_RANGE
                                                           : status;
}

rigcal_status rc_survey_points(rc_survey *out, int32_t *bad, const rigcal_fit *fit)
{
    const rigcal_observation *const o = fit->observations;
    const rigcal_real *const sigma = fit->sigma;
    rigcal_real total = 0, size = 0, extent = 0;
    rigcal_real shift[3] = {0, 0, 0}, uv_shift[3] = {0, 0, 0};
    const rigcal_observation *first = NULL;
    size_t n_used = 0;
    *bad = -1;
    for (size_t i = 0; i < fit->n; i++) {
        if (!rc_fit_uses(fit, i)) {
            continue;
        }
        rigcal_status status = rc_check_observation(&o[i]);
        if (status == RIGCAL_OK && sigma != NULL) {
            status = check_sigma(&sigma[i]);
        }
        if (status != RIGCAL_OK) {
            *bad = (int32_t)i;
            return status;
        }
        if (n_used++ == 0) {
            first = &o[i];
        }
        rigcal_real x[3]; /* differences of two points are exact */
        const rigcal_real weight = weight_of(sigma, i);
        rc_vec3_sub(x, o[i].X_w, first->X_w);
        rc_vec3_add_scaled(shift, weight, x);
        size = rc_max(size, rc_vec3_max_abs(x));
        total += weight;
        const rigcal_real uv[3] = {o[i].uv[0] - first->uv[0],
                                   o[i].uv[1] - first->uv[1], 0};
        rc_vec3_add_scaled(uv_shift, weight, uv);
        extent = rc_max(extent, rc_vec3_max_abs(uv));
    }
    if (n_used < 3) {
        return RIGCAL_ERR_TOO_FEW;
    }
    rc_vec3_combine(out->origin, 1, first->X_w, 1 / total, shift);
    out->uv_middle[0] = first->uv[0] + uv_shift[0] / total;
    out->uv_middle[1] = first->uv[1] + uv_shift[1] / total;
    out->extent_px = extent;
    out->size = size;
    out->n_used = n_used;
    if (!(size > 1 / RC_COORDINATE_MAX)) {
        return RIGCAL_ERR_COINCIDENT;
    }
    return (rc_vec3_max_abs(out->origin) * RC_EPS <= RC_SHAPE_ROUNDING * size)
               ? RIGCAL_OK
               : RIGCAL_ERR_PRECISION;
}

static void fail(rigcal_pose_solver *s, rigcal_status status, int32_t bad)
{
    s->failure = status;
    s->bad = bad;
    s->phase = DONE;
}

/* ---- gathering: what the search needs to know of the points --------------- */

/* Columns m1, m2, axis: camera from the virtual camera, which looks along its axis. */
static void look_along(rigcal_real R[9], const rigcal_real axis[3])
{
    rigcal_real m1[3], m2[3];
    rc_view_complete(m1, m2, axis);
    for (int k = 0; k < 3; k++) {
        R[3 * k] = m1[k];
        R[3 * k + 1] = m2[k];
        R[3 * k + 2] = axis[k];
    }
}

/* The first point from i on that counts, or n. */
static int32_t next_used(const rigcal_pose_solver *s, int32_t i)
{
    while (i < (int32_t)s->n && !rc_fit_uses(&s->fit, (size_t)i)) {
        i++;
    }
    return i;
}

/* The virtual camera looks along the ray of the middle pixel; where that has none, or none
 * is given, along the camera's own axis. */
static void begin_gathering(rigcal_pose_solver *s,
                            const rigcal_real uv_middle[2])
{
    s->phase = GATHERING;
    s->next = next_used(s, 0);
    s->work.triple.count = 0;
    rc_view_begin(&s->from.lattice.moments);
    if (uv_middle == NULL ||
        rc_pixel_to_ray(s->axis, s->fit.camera, uv_middle) != RIGCAL_OK) {
        s->axis[0] = s->axis[1] = 0;
        s->axis[2] = 1;
    }
}

/* Surveys the points that count, and begins the search of their pose. */
RC_APART static void begin_over(rigcal_pose_solver *s)
{
    rc_survey survey;
    int32_t at;
    if (rc_survey_points(&survey, &at, &s->fit) != RIGCAL_OK) {
        fail(s, RIGCAL_ERR_NO_RAY, s->bad); /* too few without those left out */
        return;
    }
    rc_vec3_copy(s->fit.origin, survey.origin);
    s->scale = 1 / survey.size;
    s->n_used = survey.n_used;
    begin_gathering(s, survey.uv_middle);
}

/* The lens images no ray at the pixel of point i: the pose is that of the others. A second
 * such point is too much. */
static void leave_out_unseen(rigcal_pose_solver *s, int32_t i)
{
    if (s->fit.left_out >= 0) {
        fail(s, RIGCAL_ERR_NO_RAY, i);
        return;
    }
    s->fit.left_out = s->bad = i;
    begin_over(s);
}

/* In the axes of the virtual camera. */
RC_APART static void turn_to_virtual(rigcal_real turned[3],
                                     const rigcal_real axis[3],
                                     const rigcal_real ray[3])
{
    rigcal_real cam_from_virtual[9];
    look_along(cam_from_virtual, axis);
    rc_mat3_tmul_vec3(turned, cam_from_virtual, ray);
}

/* Counts point i if it is different from those that count. */
RC_APART static void count_point(rigcal_pose_solver *s, int32_t i,
                                 const rigcal_real ray[3])
{
    rigcal_pose_triple *const triple = &s->work.triple;
    if (triple->count > 3) {
        return;
    }
    for (int k = 0; k < triple->count; k++) {
        const int32_t other = triple->index[k];
        rigcal_real x[3];
        rc_vec3_sub(x, s->fit.observations[i].X_w,
                    s->fit.observations[other].X_w);
        if (!(rc_vec3_max_abs(x) * s->scale > SAME_POINT)) {
            return;
        }
    }
    if (triple->count < 3) {
        triple->index[triple->count] = i;
        rc_vec3_copy(triple->ray[triple->count], ray);
    }
    triple->count++;
}

static void begin_picking(rigcal_pose_solver *s)
{
    s->phase = PICKING;
    s->work.triple.count = 0;
}

/* A ray is too far off the virtual camera's axis. What cannot take its poses from triples
 * of points tries the camera's own axis. */
static void begin_spread(rigcal_pose_solver *s)
{
    if (WITH_WIDE) {
        s->is_wide = 1;
        begin_picking(s);
    } else {
        begin_gathering(s, NULL);
    }
}

/* One point, scaled to size 1, and its image in the virtual camera. */
static void gather_point(rigcal_pose_solver *s, int32_t i)
{
    const rigcal_observation *const o = &s->fit.observations[i];
    rigcal_real x[3], ray[3], u[3];
    if (rc_pixel_to_ray(ray, s->fit.camera, o->uv) != RIGCAL_OK) {
        leave_out_unseen(s, i);
        return;
    }
    turn_to_virtual(u, s->axis, ray);
    if (0 && !WITH_WIDE && !(ray[2] > SPREAD_COSINE)) {
        fail(s, RIGCAL_ERR_WIDE_RAY, i);
        return;
    }
    if (!(u[2] > SPREAD_COSINE)) {
        begin_spread(s);
        return;
    }
    s->is_wide |= WITH_WIDE && !(ray[2] > WIDE_COSINE);
    rc_vec3_scale(u, 1 / u[2], u);
    rc_fit_point(x, &s->fit, (size_t)i);
    rc_vec3_scale(x, s->scale, x);
    rc_view_add(&s->from.lattice.moments, weight_of(s->fit.sigma, (size_t)i), x,
                u);
    count_point(s, i, ray);
    s->next = next_used(s, i + 1);
}

RC_APART int32_t rc_poses_of_three(rigcal_transform cam_from_points[RC_P3P_MAX],
                                   const rigcal_fit *fit,
                                   const int32_t index[3],
                                   const rigcal_real ray[3][3])
{
    rigcal_real x[3][3];
    for (int k = 0; k < 3; k++) {
        rc_fit_point(x[k], fit, (size_t)index[k]);
    }
    return rc_p3p(cam_from_points, (const rigcal_real(*)[3])x, ray);
}

static void begin_refining(rigcal_pose_solver *s, int32_t phase)
{
    rc_refine_begin(&s->work.fit, s->is_wide && phase == REFINING);
    s->phase = phase;
}

/* Of three points, minima that do not fit may be left by two exact poses that noise has made
 * one. They go where others fit and the noise is not stated. */
static void keep_exact(rigcal_pose_solver *s)
{
    const rigcal_real most = EXACT * s->fit.pixel * s->fit.pixel;
    while (s->n_found > 1 && s->found[0].sse <= most &&
           s->found[s->n_found - 1].sse > most) {
        s->n_found--;
    }
}

/* The search has ended; how well the observations fix its first pose is left to weigh:
 * by the first n of them. */
static void begin_weighing(rigcal_pose_solver *s, size_t n)
{
    s->phase = DONE;
    if (s->n_used == 3 && !(s->sigma_px > 0)) {
        keep_exact(s);
    }
    if (s->n_found > 0) {
        rc_found_transform(&s->work.fit.cam_from_points, &s->found[0]);
        s->fit.n = (n < s->n) ? n : s->n;
        begin_refining(s, WEIGHING);
    }
}


RC_APART static void begin_search(rigcal_pose_solver *s)
{
    rigcal_view_moments *const view = &s->from.lattice.moments;
    const rigcal_pose_triple *const triple = &s->work.triple;
    rigcal_real thickness;
    s->next = 0;
    if (!rc_view_finish(view) || triple->count < 3) {
        fail(s, RIGCAL_ERR_COINCIDENT, s->bad);
        return;
    }
    if (!rc_view_normal(s->normal, &thickness, view)) {
        fail(s, RIGCAL_ERR_COLLINEAR, s->bad);
        return;
    }
    s->is_flat = thickness < FLAT_THICKNESS;
    s->is_plane = thickness < PLANE_THICKNESS;
    if (triple->count == 3) {
        if (!RIGCAL_WITH_THREE_POINTS) {
            fail(s, RIGCAL_ERR_TOO_FEW, s->bad);
            return;
        }
        /* None: the moments, whose memory the poses share, stay. */
        s->n_exact = rc_poses_of_three(s->from.exact, &s->fit, triple->index,
                                       triple->ray);
        s->picks = (s->n_exact > 0) ? PICKS : 0;
    }
    s->phase = CHOOSING;
    if (s->n_exact == 0) {
        s->phase = SCANNING;
        s->n_seeds = 0;
        s->from.lattice.azimuth[0] = 1;
        s->from.lattice.azimuth[1] = 0;
    }
}

/* A triple spread over the points' order, and its poses. */
RC_APART static void picking_step(rigcal_pose_solver *s)
{
    const int32_t n = (int32_t)s->n;
    rigcal_pose_triple *const triple = &s->work.triple;
    int32_t i = s->picks++;
    for (int k = 0; k < 3; k++) {
        i = next_used(s, i);
        i = (i < n) ? i : next_used(s, i - n);
        if (rc_pixel_to_ray(triple->ray[k], s->fit.camera, s->fit.observations[i].uv) !=
            RIGCAL_OK) {
            leave_out_unseen(s, i);
            return;
        }
        triple->index[k] = i;
        i += ((n + 1) >> 2) + (n >> 4);
    }
    s->next = 0;
    s->n_exact = rc_poses_of_three(s->from.exact, &s->fit, triple->index,
                                   (const rigcal_real(*)[3])triple->ray);
    s->phase = CHOOSING;
}

/* One ray; of a pinhole, whose rays cost next to nothing, some. */
RC_APART static void gathering_step(rigcal_pose_solver *s)
{
    const int32_t n = (int32_t)s->n;
    int32_t left = s->fit.lens.is_pinhole ? PINHOLE_RAYS : 1;
    for (; left > 0 && s->next < n; left--) {
        gather_point(s, s->next);
        if (s->phase != GATHERING) {
            return;
        }
    }
    if (s->next == n) {
        s->phase = GATHERED;
    }
}

/* ---- optima found -------------------------------------------------------- */

void rc_found_transform(rigcal_transform *cam_from_points,
                        const rigcal_pose_optimum *found)
{
    const rigcal_real *const x = &found->rows[0], *const y = &found->rows[3];
    rc_vec3_copy(&cam_from_points->R[0], x);
    rc_vec3_copy(&cam_from_points->R[3], y);
    rc_vec3_cross(&cam_from_points->R[6], x, y);
    rc_vec3_copy(cam_from_points->t, found->t);
}

/* The first optimum whose rotation is within a (small) angle of R, or -1: the squared
 * differences of two rotations sum to 8 sin^2(angle / 2). */
RC_APART static int32_t near_found(const rigcal_pose_solver *s,
                                   const rigcal_real R[9], rigcal_real angle)
{
    for (int32_t i = 0; i < s->n_found; i++) {
        rigcal_transform other;
        rigcal_real sum = 0;
        rc_found_transform(&other, &s->found[i]);
        for (int k = 0; k < 9; k++) {
            sum += (other.R[k] - R[k]) * (other.R[k] - R[k]);
        }
        if (sum < 2 * angle * angle) {
            return i;
        }
    }
    return -1;
}

/* The direction of the virtual camera's axis, seen from the target, at an optimum. */
static void found_direction(rigcal_real m3[3], const rigcal_pose_solver *s,
                            int32_t i)
{
    const rigcal_real *const rows = s->found[i].rows, *const axis = s->axis;
    rc_vec3_cross(m3, &rows[0], &rows[3]);
    rc_vec3_combine(m3, axis[2], m3, axis[0], &rows[0]);
    rc_vec3_add_scaled(m3, axis[1], &rows[3]);
}

/* The optimum found at which the refinement has ended once more, or -1. */
static int32_t same_found(const rigcal_pose_solver *s)
{
    return near_found(s, s->work.fit.cam_from_points.R,
                      (s->n_used == 3) ? SAME_EXACT : SAME_POSE);
}

/* Keeps the RIGCAL_POSES_MAX best optima in order; of two that are one, the better. */
static void insert_found(rigcal_pose_solver *s)
{
    rigcal_refinement *const end = &s->work.fit;
    rigcal_pose_optimum *const found = s->found;
    int32_t at = same_found(s);
    rc_rotation_tidy(end->cam_from_points.R);
    if (at < 0) {
        at = s->n_found;
        if (at < RIGCAL_POSES_MAX) {
            s->n_found++;
        } else if (!(end->sse < found[--at].sse)) {
            return;
        }
    }
    for (; at > 0 && end->sse < found[at - 1].sse; at--) {
        found[at] = found[at - 1];
    }
    rc_vec3_copy(&found[at].rows[0], &end->cam_from_points.R[0]);
    rc_vec3_copy(&found[at].rows[3], &end->cam_from_points.R[3]);
    rc_vec3_copy(found[at].t, end->cam_from_points.t);
    found[at].sse = end->sse;
    if (at == 0) {
        s->is_unfinished = end->status == RIGCAL_BUDGET_SPENT;
    }
}

/* ---- likelihood ---------------------------------------------------------- */

/* Degrees of freedom; three points, which have none, nearly fit. */
RC_APART static rigcal_real freedom(size_t n)
{
    return rc_max(1, (rigcal_real)(2 * (int32_t)n - 6));
}

/* 0 or infinity where it is beyond them. */
RC_APART static rigcal_real power(rigcal_real base, size_t exponent)
{
    rigcal_real result = 1;
    for (; exponent > 0; exponent /= 2) {
        if (exponent % 2 == 1) {
            result *= base;
        }
        base *= base;
    }
    return result;
}

/* The series of exp(x / 256), to that power: exp itself would bring 0.4 KB along. */
static rigcal_real exponential(rigcal_real x)
{
    enum { PARTS = 256, TERMS = 8 };
    const rigcal_real part =
        rc_min(rc_max(x, -EXPONENT_MOST), EXPONENT_MOST) / PARTS;
    rigcal_real sum = 1;
    for (int k = TERMS; k > 0; k--) {
        sum = 1 + part * sum / (rigcal_real)k;
    }
    return power(sum, PARTS);
}

/* (C) Noise known: exp of half the difference. Unknown, it is integrated out with the
 * prior 1 / noise, which leaves the power n - 3 of the ratio; added is what the least
 * noise makes of a sum. */
rigcal_real rc_odds(rigcal_real sse, rigcal_real other, rigcal_real sigma_px,
                    rigcal_real pixel, size_t n)
{
    if (sigma_px > 0) {
        return exponential((other - sse) / (2 * sigma_px * sigma_px));
    }
    const rigcal_real noise = NOISE_LEAST * pixel;
    const rigcal_real least = freedom(n) * noise * noise;
    return power((other + least) / (sse + least), n - 3);
}

static rigcal_real likelihood_of(const rigcal_pose_solver *s, rigcal_real sse)
{
    return rc_odds(sse, s->found[0].sse, s->sigma_px, s->fit.pixel, s->n_used);
}

rigcal_real rc_pose_likelihood(const rigcal_pose_solver *s, int32_t i)
{
    return likelihood_of(s, s->found[i].sse);
}

/* ---- seeds: the lattice -------------------------------------------------- */

/* z = z w, complex */
RC_APART static void turn(rigcal_real z[2], const rigcal_real w[2])
{
    const rigcal_real x = z[0] * w[0] - z[1] * w[1];
    const rigcal_real y = z[0] * w[1] + z[1] * w[0];
    z[0] = x;
    z[1] = y;
}

/* A golden angle, pi (3 - sqrt 5). */
static const rigcal_real GOLDEN[2] = {RC(-0.73736887807831989),
                                      RC(0.67549029426152364)};

/* Direction `index` of a Fibonacci sphere: heights in even steps, azimuths a golden
 * angle apart. */
RC_APART static void direction_of(rigcal_real m3[3], int32_t index,
                                  const rigcal_real azimuth[2])
{
    m3[2] = 1 - (rigcal_real)(2 * index + 1) / (rigcal_real)LATTICE;
    const rigcal_real r = RC_SQRT(1 - m3[2] * m3[2]);
    m3[0] = r * azimuth[0];
    m3[1] = r * azimuth[1];
}

static void seed_direction(rigcal_real m3[3], int32_t index)
{
    rigcal_real azimuth[2] = {1, 0}, by[2] = {GOLDEN[0], GOLDEN[1]};
    for (int32_t left = index; left > 0; left /= 2) {
        if (left % 2 == 1) {
            turn(azimuth, by);
        }
        turn(by, by);
    }
    direction_of(m3, index, azimuth);
}

static void move_seed(rigcal_pose_lattice *lattice, int32_t to, int32_t from)
{
    lattice->cost[to] = lattice->cost[from];
    lattice->index[to] = lattice->index[from];
}

/* Keeps the best directions in order of cost; this one is among them. */
static void insert_seed(rigcal_pose_solver *s, rigcal_real cost)
{
    rigcal_pose_lattice *const lattice = &s->from.lattice;
    int32_t at = (s->n_seeds < FOLLOWED) ? s->n_seeds++ : FOLLOWED - 1;
    for (; at > 0 && cost < lattice->cost[at - 1]; at--) {
        move_seed(lattice, at, at - 1);
    }
    lattice->cost[at] = cost;
    lattice->index[at] = s->next;
}

RC_APART static void scanning_step(rigcal_pose_solver *s)
{
    rigcal_pose_lattice *const lattice = &s->from.lattice;
    rigcal_real m3[3];
    direction_of(m3, s->next, lattice->azimuth);
    turn(lattice->azimuth, GOLDEN);
    const rigcal_real cost = rc_view_cost(&lattice->moments, m3);
    if (s->n_seeds < FOLLOWED || cost < lattice->cost[FOLLOWED - 1]) {
        insert_seed(s, cost);
    }
    if (++s->next == LATTICE) {
        lattice->least_cost = lattice->cost[0];
        s->next = 0;
        s->phase = CHOOSING;
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
        rc_vec3_add(middle, m3);
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
    rc_vec3_combine(m3, ab[0], m1, ab[1], m2);
    rc_vec3_add(m3, seed);
    (void)rc_vec3_unit(m3, m3);
}

static void begin_descent(rigcal_pose_solver *s, const rigcal_real m3[3],
                          rigcal_real cost)
{
    static const rigcal_real SIMPLEX[6] = {0, 0, EDGE, 0, 0, EDGE};
    rigcal_descent *const descent = &s->work.descent;
    rc_neldermead_begin_simplex(&descent->nm, SIMPLEX, 2, RC(1e-4), 0,
                                DESCENT_EVALS);
    rc_neldermead_tell(&descent->nm, cost); /* known already */
    rc_vec3_copy(descent->m3, m3);
    s->phase = DESCENT;
}

/* Seed i, if it is worth a descent. */
static void try_seed(rigcal_pose_solver *s, int32_t i)
{
    const rigcal_real cost = s->from.lattice.cost[i];
    rigcal_real m3[3];
    seed_direction(m3, s->from.lattice.index[i]);
    if (cost < RC_MAX && !leads_to_found(s, m3, cost)) {
        begin_descent(s, m3, cost);
    }
}

/* From the virtual camera and size 1 to the camera and the caller's unit. */
RC_APART static void leave_virtual(rigcal_transform *T,
                                   const rigcal_pose_solver *s)
{
    rigcal_real cam_from_virtual[9], R[9], t[3];
    look_along(cam_from_virtual, s->axis);
    rc_mat3_mul(R, cam_from_virtual, T->R);
    rc_mat3_mul_vec3(t, cam_from_virtual, T->t);
    for (int k = 0; k < 9; k++) {
        T->R[k] = R[k];
    }
    rc_vec3_scale(T->t, 1 / s->scale, t);
}

/* Camera from points of a direction. */
static void seed_pose(rigcal_transform *cam_from_points,
                      const rigcal_pose_solver *s, const rigcal_real m3[3])
{
    rc_view_pose(cam_from_points, &s->from.lattice.moments, m3);
    leave_virtual(cam_from_points, s);
}

/* Whether the points are mirrored. Mirrored ones, -x, have far away the same image as
 * x, turned half about the line of sight: their pose is near the direction found, and
 * the cost there tells whether it is worth refining. */
static void begin_mirrored(rigcal_pose_solver *s)
{
    rigcal_view_moments *const view = &s->from.lattice.moments;
    rigcal_real m3[3];
    const rigcal_real noise = rc_max(s->sigma_px, MIRROR_NOISE * s->fit.pixel);
    begin_weighing(s, VAGUE_POINTS);
    if (s->is_plane || s->n_found == 0 ||
        s->found[0].sse <= noise * noise * freedom(s->n_used)) {
        return;
    }
    found_direction(m3, s, 0);
    const rigcal_real cost = rc_view_cost(view, m3);
    rc_view_mirror(view);
    if (rc_view_cost(view, m3) < MIRROR_WORSE * cost) {
        seed_pose(&s->work.fit.cam_from_points, s, m3);
        s->fit.is_mirrored = !s->fit.is_mirrored;
        s->fit.n = s->n;
        begin_refining(s, MIRRORED);
    }
}

static void end_mirrored(rigcal_pose_solver *s)
{
    s->fit.is_mirrored = !s->fit.is_mirrored;
    s->is_mirrored = s->work.fit.status >= 0 &&
                     likelihood_of(s, s->work.fit.sse) > MIRROR_ODDS;
    begin_weighing(s, VAGUE_POINTS);
}

/* Refines from a direction, unless it would only lead to an optimum found. */
RC_APART static void follow(rigcal_pose_solver *s, const rigcal_real m3[3])
{
    rigcal_transform *const start = &s->work.fit.cam_from_points;
    seed_pose(start, s, m3);
    if (near_found(s, start->R, SAME_BASIN) < 0) {
        begin_refining(s, REFINING);
    }
}

static void end_descent(rigcal_pose_solver *s)
{
    const rigcal_neldermead *const nm = &s->work.descent.nm;
    rigcal_pose_lattice *const lattice = &s->from.lattice;
    const rigcal_vertex *const best = rc_neldermead_best(nm);
    rigcal_real m3[3];
    direction_near(m3, s->work.descent.m3, best->x);
    lattice->least_cost = rc_min(lattice->least_cost, best->cost);
    /* Rounding makes the costs of noiseless images anything: the last term. */
    const rigcal_real hopeless =
        HOPELESS * lattice->least_cost + 64 * RC_EPS * lattice->moments.weight;
    s->phase = CHOOSING;
    if (s->n_found == 0 || s->is_flat || !(best->cost > hopeless)) {
        follow(s, m3);
    }
}

RC_APART static void descent_step(rigcal_pose_solver *s)
{
    rigcal_neldermead *const nm = &s->work.descent.nm;
    rigcal_real m3[3];
    direction_near(m3, s->work.descent.m3, nm->trial.x);
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
static void leaning_direction(rigcal_real m3[3], const rigcal_real first[3],
                              const rigcal_real normal[3], int32_t lean)
{
    rigcal_real side[3], back[3];
    rc_vec3_cross(side, normal, first);
    /* Head-on any way will do. */
    if (!(rc_vec3_norm(side) > RC_TOL(1e-6, 1e-3))) {
        rc_view_complete(side, back, normal);
    }
    rc_vec3_cross(back, normal, side); /* along n - m3: the other way */
    const rigcal_real far = rc_max(1, LEAN_LEAST / rc_vec3_norm(side));
    rc_vec3_combine(m3, rc_vec3_dot(first, normal), normal,
                    (lean == SIDEWAYS_BACK) ? -far : far,
                    (lean == OTHER_WAY) ? back : side);
    (void)rc_vec3_unit(m3, m3);
}

/* The way of a lean, if it is worth it. */
static void try_lean(rigcal_pose_solver *s, int32_t lean)
{
    const rigcal_view_moments *const view = &s->from.lattice.moments;
    const rigcal_real n = (rigcal_real)(int32_t)s->n_used;
    rigcal_real first[3], m3[3];
    found_direction(first, s, 0);
    leaning_direction(m3, first, s->normal, lean);
    if (lean == OTHER_WAY ||
        rc_view_cost(view, m3) * n < SHALLOW * rc_view_cost(view, first)) {
        follow(s, m3);
    }
}

/* ---- is it good? --------------------------------------------------------- */

/* Sum of the squared errors [px^2] of optimum i, which without sigma is its sse. */
RC_APART static rigcal_real squared_pixels(const rigcal_pose_solver *s,
                                           int32_t i)
{
    rigcal_transform cam_from_points;
    rigcal_real sum = 0;
    if (s->fit.sigma == NULL) {
        return s->found[i].sse;
    }
    rc_found_transform(&cam_from_points, &s->found[i]);
    for (size_t k = 0; k < s->n; k++) {
        if (rc_fit_uses(&s->fit, k)) {
            sum += rc_fit_distance2(&s->fit, &cam_from_points, k);
        }
    }
    return sum;
}

/* Whether the first pose's error is too large for the noise stated; where none is, for
 * noise of `most` px, or of a part of the target's image where that is more: beyond so
 * many standard deviations of chi squared, by Wilson and Hilferty (1931). */
RC_APART static int is_poor(const rigcal_pose_solver *s, rigcal_real most,
                            rigcal_real deviations)
{
    const rigcal_real dof = freedom(s->n_used), v = 2 / (9 * dof);
    const rigcal_real root = 1 - v + deviations * RC_SQRT(v);
    rigcal_real sum = s->found[0].sse, noise = s->sigma_px;
    if (!(noise > 0)) {
        sum = squared_pixels(s, 0);
        noise = rc_max(most * s->fit.pixel, NOISE_PART * s->extent_px);
    }
    return !(sum <= noise * noise * dof * root * root * root);
}

/* A pose of three points; of more, unless it would only lead to an optimum found. */
static void next_exact(rigcal_pose_solver *s)
{
    s->work.fit.cam_from_points = s->from.exact[s->next++];
    if (s->n_used == 3 ||
        near_found(s, s->work.fit.cam_from_points.R, SAME_BASIN) < 0) {
        begin_refining(s, REFINING);
    }
}

/* The poses of a triple have been tried: another one, or the end. A search has tried
 * seeds before; without one, two triples are tried at least. */
static void end_exact(rigcal_pose_solver *s)
{
    const int is_enough = s->n_found > 0 && s->picks + (s->n_seeds > 0) > 1 &&
                          !is_poor(s, NOISE_MOST, DEVIATIONS);
    if (s->picks < PICKS && !is_enough) {
        begin_picking(s);
    } else {
        begin_weighing(s, VAGUE_POINTS);
    }
}

/* The next start of a refinement or a descent, if it is worth it, or the end. */
RC_APART static void choosing_step(rigcal_pose_solver *s)
{
    if (WITH_WIDE && s->next < s->n_exact) {
        next_exact(s);
    } else if (WITH_WIDE && s->picks > 0) {
        end_exact(s);
    } else if (s->is_flat && s->n_found > 0 && s->leans < LEANS) {
        try_lean(s, s->leans++);
    } else if (s->next < s->n_seeds) {
        try_seed(s, s->next++);
    } else if (WITH_WIDE && s->is_wide) {
        begin_picking(s);
    } else {
        begin_mirrored(s);
    }
}

/* The previous pose was of no use. */
static void begin_cold(rigcal_pose_solver *s)
{
    s->is_warm = 0;
    s->n_found = 0;
    begin_over(s);
}

/* By all points, if some of them hardly fix the pose. A previous pose that hardly any data
 * support is not believed: the search tells what is wrong with them. */
static void end_weighing(rigcal_pose_solver *s)
{
    const rigcal_real noise =
        (s->sigma_px > 0)
            ? s->sigma_px
            : rc_max(VAGUE_NOISE * s->fit.pixel,
                     RC_SQRT(s->found[0].sse / freedom(s->n_used)));
    rigcal_real variance;
    s->is_vague = s->work.fit.status < 0 ||
                  !rc_refine_rotation_variance(&variance, s->work.fit.H) ||
                  !(noise * noise * variance <= VAGUE * VAGUE);
    s->phase = DONE;
    if (s->is_vague && s->fit.n < s->n) {
        begin_weighing(s, s->n);
    } else if (s->is_vague && s->is_warm) {
        begin_cold(s);
    }
}

/* ---- the phases ---------------------------------------------------------- */

/* A warm start that ended elsewhere than at the pose shows by its error. */
static void end_warm(rigcal_pose_solver *s)
{
    if (s->n_found > 0 && !is_poor(s, NOISE_WARM, DEVIATIONS_WARM)) {
        begin_weighing(s, VAGUE_POINTS);
    } else {
        begin_cold(s);
    }
}

/* The refinement's end is an optimum, or none. */
RC_APART static void settle(rigcal_pose_solver *s, int is_optimum)
{
    if (is_optimum) {
        insert_found(s);
    }
    if (s->is_warm) {
        end_warm(s);
    } else {
        s->phase = CHOOSING;
    }
}

/* Refinement sees to it that the points are in front; whether a lens that turns back
 * sees them is to be proved. One that ran out of evaluations is on its way along a
 * valley, likely to an optimum that is found from elsewhere too. */
RC_APART static void end_refinement(rigcal_pose_solver *s)
{
    const rigcal_refinement *const end = &s->work.fit;
    const int32_t same = same_found(s);
    int is_optimum = end->status == RIGCAL_OK;
    if (!s->is_warm && end->status == RIGCAL_BUDGET_SPENT) {
        is_optimum = s->n_found == 0 || end->sse < s->found[0].sse;
    }
    if (!s->is_warm && end->status == RIGCAL_ERR_DEGENERATE) {
        s->failure = RIGCAL_ERR_DEGENERATE;
    }
    if (same >= 0 && !(end->sse < s->found[same].sse)) {
        is_optimum = 0;
    }
    if (is_optimum && !s->fit.lens.is_pinhole) {
        s->point = next_used(s, 0);
        s->phase = PROVING;
    } else {
        settle(s, is_optimum);
    }
}

RC_APART static void proving_step(rigcal_pose_solver *s)
{
    rigcal_real q[3], X_c[3], uv[2];
    rc_fit_place(q, X_c, &s->fit, &s->work.fit.cam_from_points,
                 (size_t)s->point);
    const int is_seen = rc_project_usable(uv, s->fit.camera, X_c) == RIGCAL_OK;
    s->point = next_used(s, s->point + 1);
    if (!is_seen || s->point == (int32_t)s->n) {
        settle(s, is_seen);
    }
}

static void begin_warm(rigcal_pose_solver *s, const rigcal_transform *start)
{
    rigcal_transform *const cam_from_points = &s->work.fit.cam_from_points;
    *cam_from_points = *start;
    rc_rotation_tidy(cam_from_points->R);
    rc_transform_point(cam_from_points->t, start, s->fit.origin);
    s->is_warm = 1;
    begin_refining(s, REFINING);
}

RC_APART static void refining_step(rigcal_pose_solver *s)
{
    rigcal_refinement *const work = &s->work.fit;
    rc_refine_step(work, &s->fit, REFINE_EVALS);
    if (s->phase == WEIGHING) {
        end_weighing(s);
    } else if (work->status == RIGCAL_RUNNING) {
        return;
    } else if (s->phase == MIRRORED) {
        end_mirrored(s);
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
    options->use_start = 0;
    options->sigma_px = 0;
    rc_transform_identity(&options->start);
    return RIGCAL_OK;
}

/* 0 for unknown, or a number whose square is one. */
static rigcal_status check_noise(const rigcal_real *sigma_px)
{
    return rc_all_within(sigma_px, 1, 0) ? RIGCAL_OK : check_sigma(sigma_px);
}

static rigcal_status check_options(const rigcal_pose_options *o)
{
    const rigcal_status status = check_noise(&o->sigma_px);
    if (status == RIGCAL_ERR_NOT_FINITE) {
        return status;
    }
    if ((o->use_start & ~1) != 0) {
        return RIGCAL_ERR_RANGE;
    }
    return (status == RIGCAL_OK && o->use_start) ? rc_check_transform(&o->start)
                                                 : status;
}

rigcal_status rc_pose_begin(rigcal_pose_solver *solver, int32_t *bad,
                            const rigcal_fit *data, const rigcal_pose_options *options)
{
    rc_survey survey;
    int32_t at = -1;
    rigcal_status status = (data->observations == NULL)
                               ? RIGCAL_ERR_NULL
                               : rc_check_camera(data->camera);
    if (status == RIGCAL_OK && options != NULL) {
        status = check_options(options);
    }
    if (status == RIGCAL_OK && data->n > RC_COUNT_MAX) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK) {
        status = rc_survey_points(&survey, &at, data);
    }
    rc_write_fault(bad, at);
    if (status != RIGCAL_OK) {
        return status;
    }
    *solver = (rigcal_pose_solver){0};
    solver->fit = *data;
    rc_fit_begin(&solver->fit, survey.origin);
    const rigcal_real rounding = ROUNDING * survey.extent_px;
    solver->fit.nothing = rc_max(solver->fit.nothing, rounding * rounding);
    solver->n = data->n;
    solver->n_used = survey.n_used;
    solver->bad = -1;
    solver->scale = 1 / survey.size;
    solver->extent_px = survey.extent_px;
    if (options != NULL) {
        solver->sigma_px = options->sigma_px;
    }
    if (options != NULL && options->use_start) {
        begin_warm(solver, &options->start);
    } else {
        begin_gathering(solver, survey.uv_middle);
    }
    return RIGCAL_OK;
}

rigcal_status rigcal_pose_begin(rigcal_pose_solver *solver, int32_t *bad,
                                const rigcal_camera *camera,
                                const rigcal_observation observations[],
                                const rigcal_real sigma[], size_t n,
                                const rigcal_pose_options *options)
{
    rigcal_fit data;
    rc_write_fault(bad, -1);
    rc_fit_of(&data, camera, observations, sigma, NULL, n);
    return (solver == NULL) ? RIGCAL_ERR_NULL
                            : rc_pose_begin(solver, bad, &data, options);
}

static void step_once(rigcal_pose_solver *s)
{
    if (s->phase == GATHERING) {
        gathering_step(s);
    } else if (WITH_WIDE && s->phase == PICKING) {
        picking_step(s);
    } else if (s->phase == GATHERED) {
        begin_search(s);
    } else if (s->phase == SCANNING) {
        scanning_step(s);
    } else if (s->phase == CHOOSING) {
        choosing_step(s);
    } else if (s->phase == DESCENT) {
        descent_step(s);
    } else if (s->phase == PROVING) {
        proving_step(s);
    } else {
        refining_step(s);
    }
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
    for (; budget > 0 && solver->phase != DONE; budget--) {
        step_once(solver);
    }
    return (solver->phase == DONE) ? RIGCAL_OK : RIGCAL_RUNNING;
}

/* A pose as the caller knows it: of the world's origin, with its error in px. */
static void write_pose(rigcal_pose *out, const rigcal_pose_solver *s, int32_t i)
{
    rigcal_transform *const pose = &out->cam_from_world;
    rigcal_real turned[3];
    rc_found_transform(pose, &s->found[i]);
    rc_mat3_mul_vec3(turned, pose->R, s->fit.origin);
    rc_vec3_add_scaled(pose->t, -1, turned);
    out->sse = s->found[i].sse;
    out->rms_px =
        RC_SQRT(squared_pixels(s, i) / (rigcal_real)(int32_t)s->n_used);
}

rigcal_status rigcal_pose_result(rigcal_pose poses[], size_t *n_found,
                                 size_t capacity, int32_t *bad,
                                 const rigcal_pose_solver *solver)
{
    const rigcal_pose_solver *const s = solver;
    rigcal_real total = 0;
    rc_write_fault(bad, -1);
    if (poses == NULL || n_found == NULL || s == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (capacity < 1) {
        return RIGCAL_ERR_RANGE;
    }
    if (s->phase != DONE || s->n_found < 0 || s->n_found > RIGCAL_POSES_MAX) {
        return RIGCAL_ERR_STATE;
    }
    rc_write_fault(bad, s->bad);
    if (s->n_found == 0) {
        return (s->failure != 0) ? s->failure : RIGCAL_ERR_NO_POSE;
    }
    for (int32_t i = 0; i < s->n_found; i++) {
        total += rc_pose_likelihood(s, i);
    }
    const size_t n =
        ((size_t)s->n_found < capacity) ? (size_t)s->n_found : capacity;
    for (size_t i = 0; i < n; i++) {
        write_pose(&poses[i], s, (int32_t)i);
        poses[i].probability = rc_pose_likelihood(s, (int32_t)i) / total;
    }
    *n_found = n;
    if (s->is_mirrored || is_poor(s, NOISE_MOST, DEVIATIONS)) {
        return RIGCAL_POOR_FIT;
    }
    if (s->is_unfinished) {
        return RIGCAL_BUDGET_SPENT;
    }
    if (s->is_vague) {
        return RIGCAL_VAGUE;
    }
    if (!(poses[0].probability >= SURE)) {
        return RIGCAL_AMBIGUOUS;
    }
    return (s->bad >= 0) ? RIGCAL_UNSEEN_POINT : RIGCAL_OK;
}

rigcal_status rigcal_solve_pose(rigcal_pose poses[], size_t *n_found,
                                size_t capacity, int32_t *bad,
                                const rigcal_camera *camera,
                                const rigcal_observation observations[],
                                const rigcal_real sigma[], size_t n,
                                const rigcal_pose_options *options)
{
    rigcal_pose_solver solver;
    rc_write_fault(bad, -1);
    if (poses == NULL || n_found == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (capacity < 1) {
        return RIGCAL_ERR_RANGE;
    }
    const rigcal_status status = rigcal_pose_begin(&solver, bad, camera, observations,
                                                   sigma, n, options);
    if (status != RIGCAL_OK) {
        return status;
    }
    while (rigcal_pose_step(&solver, INT32_MAX) == RIGCAL_RUNNING) {
    }
    return rigcal_pose_result(poses, n_found, capacity, bad, &solver);
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
                variance +=
                    R[3 * r + i] * Sigma[6 * (3 + r) + 3 + c] * R[3 * c + i];
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
    for (int row = 0; row < 6; row++) { /* symmetric to the last bit */
        for (int column = 0; column < row; column++) {
            out->Sigma[6 * column + row] = out->Sigma[6 * row + column];
        }
    }
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
int rc_are_on_line(const rigcal_observation o[], size_t n,
                   const rigcal_real origin[3])
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

rigcal_status rigcal_pose_covariance(rigcal_pose_uncertainty *out,
                                     const rigcal_camera *camera,
                                     const rigcal_transform *cam_from_world,
                                     const rigcal_observation observations[],
                                     const rigcal_real sigma[], size_t n,
                                     rigcal_real sigma_px)
{
    rc_survey survey;
    rigcal_fit fit;
    int32_t at;
    if (out == NULL || observations == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_check_camera(camera);
    if (status == RIGCAL_OK) {
        status = rc_check_transform(cam_from_world);
    }
    if (status == RIGCAL_OK) {
        status = check_noise(&sigma_px);
    }
    if (status == RIGCAL_OK && n > RC_COUNT_MAX) {
        status = RIGCAL_ERR_RANGE;
    }
    if (status == RIGCAL_OK && n == 3 && !(sigma_px > 0)) {
        status = RIGCAL_ERR_TOO_FEW;
    }
    if (status == RIGCAL_OK) {
        rc_fit_of(&fit, camera, observations, sigma, NULL, n);
        status = rc_survey_points(&survey, &at, &fit);
    }
    if (status != RIGCAL_OK && status != RIGCAL_ERR_COINCIDENT &&
        status != RIGCAL_ERR_PRECISION) {
        return status;
    }

    rigcal_real sse, g[6], H[21], at_points[36], turned[3];
    rigcal_transform cam_from_points = *cam_from_world;
    if (rc_are_on_line(observations, n, survey.origin)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    rc_fit_begin(&fit, survey.origin);
    rc_transform_point(cam_from_points.t, cam_from_world, survey.origin);
    status = rc_normal_equations(&sse, g, H, &fit, &cam_from_points);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!rc_refine_covariance(at_points, H)) {
        return RIGCAL_ERR_DEGENERATE;
    }
    rc_mat3_mul_vec3(turned, cam_from_world->R, survey.origin);
    fill_uncertainty(out, cam_from_world, at_points, turned,
                     (sigma_px > 0) ? sigma_px * sigma_px
                                    : sse / (rigcal_real)(2 * n - 6));
    return RIGCAL_OK;
}
