#include "rc_seeds.h"

/* ---- constants ----------------------------------------------------------- */

/* directions: the lattice has this many. In many scenes each basin had one of them. */
enum { LATTICE = 24 };

/* rad: first edge of a descent's simplex, about half the lattice's spacing. */
#define EDGE RC(0.3)

/* evaluations: a descent takes this many. It only has to end where refinement converges. */
enum { DESCENT_EVALS = 10 };

/* part (rc_sym3_thinnest): a thinner target has a second optimum, which leans the other
 * way. */
#define FLAT_THICKNESS RC(0.04)

/* part: if the target is thinner, its mirrored points have nearly the same image. */
#define PLANE_THICKNESS RC(1e-4)

/* times the least cost: a direction that costs more is not worth refining, unless the
 * target is flat. A flat target's second optimum may be as bad. */
#define HOPELESS RC(100)

/* rad: the least lean of a flat target's other seeds. Nearly head-on the tilt is weakly
 * determined, and the other optimum may lean more. */
#define LEAN_LEAST RC(0.3)

/* times the first optimum's cost, over the number of points: a sideways seed may cost this.
 * With few points the least cost may be small by chance. */
#define SHALLOW RC(400)

/* rad: with less lean a flat target is seen head-on, and it may lean any way. */
#define HEAD_ON RC_TOL(1e-6, 1e-3)

/* rad: a seed this near to a known optimum would lead to it. */
#define SAME_BASIN RC(0.05)

/* sizes of the target: points that are nearer to each other count as one. */
#define SAME_POINT RC_TOL(1e-9, 1e-5)

/* times the cost of the points as given: if the mirrored points cost more than this in the
 * same direction, they are not refined. */
#define MIRROR_WORSE RC(10)

/* rays: the most of a pinhole camera in one step. They cost nearly nothing. */
enum { PINHOLE_RAYS = 16 };

/* cosine of 80 degrees: rays farther off the middle of the target's image do not fit the
 * virtual camera. Then triples of points replace the search. */
#define SPREAD_COSINE RC(0.17)

/* cosine of 60 degrees: a target with a ray farther off the camera's axis is wide. There
 * pixels change so fast with the pose that a refinement needs a start that is nearly
 * right. */
#define WIDE_COSINE RC(0.5)

/* triples: the most that are tried. One is tried after a search, else two, and more until
 * one leads to a pose that fits. */
enum { TRIPLES = 6 };

/* points: a view with at most this many starts from the poses of three of them, in builds
 * that have the code. A search descends from the FOLLOWED best directions of the
 * lattice. */
enum { FEW = RIGCAL_FOR_SPEED && RIGCAL_WITH_THREE_POINTS ? 8 : 0 };
enum { FOLLOWED = RIGCAL_SEEDS_MAX };

/* How a flat target's seed leans against its first optimum. */
enum { OTHER_WAY = 0, SIDEWAYS, SIDEWAYS_BACK, LEANS };

/* Whether there is code for wide targets. It needs the poses of three points. */
enum { WITH_WIDE = RIGCAL_WITH_THREE_POINTS };

/* A bit of is_wide: the rays are too far apart for the lattice. */
enum { TOO_WIDE = 2 };

enum {
    GATHERING, /* rays, and the sums over the points */
    GATHERED,
    PICKING, /* a triple of rays far apart */
    ROOTING, /* poses of the widest triple of few points */
    SCANNING,
    DESCENT,
    CHOOSING /* the next start */
};

/* ---- the virtual camera -------------------------------------------------- */

/* Columns m1, m2, axis: camera from the virtual camera, which looks along `axis`. */
static void look_along(rigcal_real R[9], const rigcal_real axis[3])
{
    rigcal_real m1[3], m2[3];
    rc_vec3_complete(m1, m2, axis);
    for (int k = 0; k < 3; k++) {
        R[3 * k] = m1[k];
        R[3 * k + 1] = m2[k];
        R[3 * k + 2] = axis[k];
    }
}

/* Takes T from the virtual camera and size 1 to the camera and the caller's unit. */
RC_APART static void leave_virtual(rigcal_transform *T, const rigcal_search *s)
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

/* The pose that belongs to direction m3. */
static void seed_pose(rigcal_transform *cam_from_points, const rigcal_search *s,
                      const rigcal_real m3[3])
{
    rc_direction_pose(cam_from_points, &s->from.lattice.moments, m3);
    leave_virtual(cam_from_points, s);
}

/* The direction of the virtual camera's axis, seen from the target, at optimum i. */
static void found_direction(rigcal_real m3[3], const rigcal_search *s, int32_t i)
{
    const rigcal_real *const rows = s->optima.list[i].rows, *const axis = s->axis;
    rc_vec3_cross(m3, &rows[0], &rows[3]);
    rc_vec3_combine(m3, axis[2], m3, axis[0], &rows[0]);
    rc_vec3_add_scaled(m3, axis[1], &rows[3]);
}

/* ---- gathering ----------------------------------------------------------- */

static void begin_gathering(rigcal_search *s)
{
    s->phase = GATHERING;
    s->point = rc_points_next(&s->points, 0);
    s->next = s->n_seeds = s->n_exact = s->triples = s->leans = s->is_wide = 0;
    s->scale = 1 / s->points.size;
    s->work.triple.count = 0;
    rc_moments_begin(&s->from.lattice.moments);
}

static void look_ahead(rigcal_search *s)
{
    s->axis[0] = s->axis[1] = 0;
    s->axis[2] = 1;
}

void rc_seeds_begin(rigcal_search *s, const rigcal_real uv_middle[2])
{
    RIGCAL_ASSERT(s->points.n_used >= 3 && s->points.size > 0);
    if (rc_pixel_to_ray(s->axis, s->points.view.camera, uv_middle) != RIGCAL_OK) {
        look_ahead(s);
    }
    begin_gathering(s);
}

/* Counts point i if it differs from the points that count already. */
static void count_point(rigcal_search *s, size_t i, const rigcal_real ray[3])
{
    const rigcal_observation *const o = s->points.view.observations;
    rigcal_triple *const triple = &s->work.triple;
    if (triple->count > 3) {
        return;
    }
    for (int k = 0; k < triple->count; k++) {
        rigcal_real x[3];
        rc_vec3_sub(x, o[i].X_w, o[triple->index[k]].X_w);
        if (!(rc_vec3_max_abs(x) * s->scale > SAME_POINT)) {
            return;
        }
    }
    if (triple->count < 3) {
        triple->index[triple->count] = (int32_t)i;
        rc_vec3_copy(triple->ray[triple->count], ray);
        if (RC_FOR_SPEED) {
            (void)rc_vec3_unit(triple->ray[triple->count], ray);
        }
    }
    triple->count++;
}

/* The place of the pixel of point i in the lens's plane. */
static inline void plane_of(rigcal_real at[3], const rigcal_points *points, size_t i)
{
    const rigcal_camera *const c = points->view.camera;
    const rigcal_real *const uv = points->view.observations[i].uv;
    at[0] = (uv[0] - c->cx) / c->fx;
    at[1] = (uv[1] - c->cy) / c->fy;
    at[2] = 1;
}

/* The ray of point i. Its length is arbitrary. */
static rigcal_status ray_of(rigcal_real ray[3], const rigcal_points *points, size_t i)
{
    if (RC_FOR_SPEED) {
        rigcal_real at[3];
        plane_of(at, points, i);
        ray[2] = 1;
        if (rc_lens_invert_within(ray, points->view.camera, at, points->proved2)) {
            return RIGCAL_OK;
        }
    }
    return rc_pixel_to_ray(ray, points->view.camera, points->view.observations[i].uv);
}

/* Whether a ray with the part `along` on an axis is within the cosine's angle of it. */
static inline int is_near(rigcal_real along, rigcal_real cosine, const rigcal_real ray[3])
{
    return along > (RC_FOR_SPEED ? 0 : cosine) &&
           (!RC_FOR_SPEED || along * along > cosine * cosine * rc_vec3_dot(ray, ray));
}

/* Adds point s->point, scaled to size 1, and its image in the virtual camera. `frame` is
 * the virtual camera's, or NULL if the caller has not computed it. */
RC_APART_FAST static int32_t gather_point(rigcal_search *s, const rigcal_real frame[9],
                                          const rigcal_real ray[3])
{
    const size_t i = s->point;
    rigcal_real x[3], u[3];
    if (RC_FOR_SPEED && frame != NULL) {
        rc_mat3_tmul_vec3(u, frame, ray);
    } else {
        rigcal_real own[9];
        look_along(own, s->axis);
        rc_mat3_tmul_vec3(u, own, ray);
    }
    if (!WITH_WIDE && !is_near(ray[2], SPREAD_COSINE, ray)) {
        return RIGCAL_ERR_WIDE_RAY;
    }
    if (is_near(u[2], SPREAD_COSINE, ray)) {
        s->is_wide |= WITH_WIDE && !is_near(ray[2], WIDE_COSINE, ray);
        rc_vec3_scale(u, 1 / u[2], u);
        rc_points_at(x, &s->points, i);
        rc_vec3_scale(x, s->scale, x);
        rc_moments_add(&s->from.lattice.moments, rc_points_weight(&s->points, i), x, u);
        count_point(s, i, ray);
    } else if (WITH_WIDE) {
        RIGCAL_TRACE("rays too far apart for the lattice: point", i, u[2]);
        s->is_wide |= TOO_WIDE;
    } else { /* again with the camera's own axis: no ray is so far off it */
        look_ahead(s);
        begin_gathering(s);
        return RC_SEEDS_BUSY;
    }
    s->point = rc_points_next(&s->points, i + 1);
    return RC_SEEDS_BUSY;
}

/* A pinhole's rays need no stack. One frame serves for all of them. */
RC_APART static int32_t gather_pinhole(rigcal_search *s)
{
    rigcal_real frame[9], ray[3];
    look_along(frame, s->axis);
    for (int left = PINHOLE_RAYS; left > 0 && s->point < s->points.view.n; left--) {
        const size_t i = s->point;
        plane_of(ray, &s->points, i);
        const int32_t came = gather_point(s, frame, ray);
        if (came != RC_SEEDS_BUSY || s->point <= i) { /* began again */
            return came;
        }
    }
    return RC_SEEDS_BUSY;
}

RC_APART_FAST static int32_t gathering_step(rigcal_search *s)
{
    int32_t came = RC_SEEDS_BUSY;
    if (RC_FOR_SPEED && s->points.is_pinhole) {
        came = gather_pinhole(s);
    } else {
        int left = s->points.is_pinhole ? PINHOLE_RAYS : 1;
        for (; left > 0 && came == RC_SEEDS_BUSY && s->point < s->points.view.n; left--) {
            rigcal_real ray[3];
            came = (ray_of(ray, &s->points, s->point) == RIGCAL_OK)
                       ? gather_point(s, NULL, ray)
                       : RC_SEEDS_UNSEEN;
        }
    }
    if (s->point == s->points.view.n) {
        s->phase = (s->is_wide & TOO_WIDE) ? PICKING : GATHERED;
    }
    return came;
}

/* ---- three points -------------------------------------------------------- */

int rc_seeds_pick(rigcal_search *s)
{
    if (s->triples >= TRIPLES) {
        return 0;
    }
    s->phase = PICKING;
    return 1;
}

/* Computes the poses of a triple spread over the points that count. All have rays. */
RC_APART_FAST static int32_t picking_step(rigcal_search *s)
{
    const size_t n = s->points.view.n, n_used = s->points.n_used;
    rigcal_triple *const triple = &s->work.triple;
    size_t i = n, ahead = (size_t)s->triples++ + 1;
    for (int k = 0; k < 3; k++) {
        do { /* the first point follows the last */
            i = rc_points_next(&s->points, (i < n) ? i + 1 : 0);
            ahead -= i < n;
        } while (ahead > 0);
        (void)rc_pixel_to_ray(triple->ray[k], s->points.view.camera,
                              s->points.view.observations[i].uv);
        triple->index[k] = (int32_t)i;
        ahead = ((n_used + 1) >> 2) + (n_used >> 4);
    }
    s->next = 0;
    s->n_exact = (uint8_t)rc_triple_poses(s->from.exact, triple, &s->points);
    RIGCAL_TRACE("poses of a triple", s->n_exact, 0);
    s->phase = CHOOSING;
    return RC_SEEDS_BUSY;
}

/* Starts from the next pose of a triple. If there are more than three points, a pose that
 * would only lead to a known optimum is skipped. */
static int32_t next_exact(rigcal_search *s)
{
    rigcal_transform *const start = &s->work.refinement.cam_from_points;
    *start = s->from.exact[s->next++];
    return (s->points.n_used == 3 || rc_optima_near(&s->optima, start->R, SAME_BASIN) < 0)
               ? RC_SEEDS_START
               : RC_SEEDS_BUSY;
}

/* A triple's poses are spent. At least two triples are tried, or one after a search. */
static int32_t end_triple(rigcal_search *s)
{
    if (s->optima.n > 0 && (s->triples > 1 || s->n_seeds > 0)) {
        return RC_SEEDS_TRIPLE_SPENT;
    }
    return rc_seeds_pick(s) ? RC_SEEDS_BUSY : RC_SEEDS_TRIPLE_SPENT;
}

/* ---- the lattice --------------------------------------------------------- */

/* z = z w, of complex numbers. */
RC_APART static void turn(rigcal_real z[2], const rigcal_real w[2])
{
    const rigcal_real x = z[0] * w[0] - z[1] * w[1];
    const rigcal_real y = z[0] * w[1] + z[1] * w[0];
    z[0] = x;
    z[1] = y;
}

/* A golden angle, pi (3 - sqrt 5). */
static const rigcal_real GOLDEN[2] = {RC(-0.73736887807831989), RC(0.67549029426152364)};

/* Direction `index` of a Fibonacci sphere: heights in even steps, azimuths a golden angle
 * apart. */
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

/* Puts the new direction among the FOLLOWED best, which are in order of cost. */
static void insert_seed(rigcal_search *s, rigcal_real cost)
{
    rigcal_lattice *const lattice = &s->from.lattice;
    int32_t at = (s->n_seeds < FOLLOWED) ? s->n_seeds++ : FOLLOWED - 1;
    for (; at > 0 && cost < lattice->cost[at - 1]; at--) {
        lattice->cost[at] = lattice->cost[at - 1];
        lattice->index[at] = lattice->index[at - 1];
    }
    lattice->cost[at] = cost;
    lattice->index[at] = s->next;
}

RC_APART_FAST static void scanning_step(rigcal_search *s)
{
    rigcal_lattice *const lattice = &s->from.lattice;
    rigcal_real m3[3];
    direction_of(m3, s->next, lattice->azimuth);
    turn(lattice->azimuth, GOLDEN);
    const rigcal_real cost = rc_direction_cost(&lattice->moments, m3);
    if (s->n_seeds < FOLLOWED || cost < lattice->cost[FOLLOWED - 1]) {
        insert_seed(s, cost);
    }
    if (++s->next == LATTICE) {
        lattice->least_cost = lattice->cost[0];
        s->next = 0;
        s->phase = CHOOSING;
    }
}

static void begin_scanning(rigcal_search *s)
{
    s->phase = SCANNING;
    s->from.lattice.azimuth[0] = 1;
    s->from.lattice.azimuth[1] = 0;
}

/* Begins the search after all points have been gathered. */
RC_APART_FAST static int32_t begin_search(rigcal_search *s)
{
    rigcal_moments *const sums = &s->from.lattice.moments;
    rigcal_triple *const triple = &s->work.triple;
    rigcal_real thickness;
    if (!rc_moments_finish(sums) || triple->count < 3) {
        return RIGCAL_ERR_COINCIDENT;
    }
    if (!rc_sym3_thinnest(s->normal, &thickness, sums->C)) {
        return RIGCAL_ERR_COLLINEAR;
    }
    RIGCAL_TRACE("different points (4: or more), thickness", triple->count, thickness);
    s->is_flat = thickness < FLAT_THICKNESS;
    s->is_plane = thickness < PLANE_THICKNESS;
    if (triple->count == 3) {
        if (!RIGCAL_WITH_THREE_POINTS) {
            return RIGCAL_ERR_TOO_FEW;
        }
        /* The sums share memory with the poses. Without poses they stay. */
        s->n_exact = (uint8_t)rc_triple_poses(s->from.exact, triple, &s->points);
        s->triples = (s->n_exact > 0) ? TRIPLES : 0;
    }
    s->phase = CHOOSING;
    if (FEW > 0 && s->n_exact == 0 && s->points.n_used > 3 && s->points.n_used <= FEW &&
        !s->is_wide) {
        s->work.triple.count = s->n_roots = 0;
        s->phase = ROOTING;
    } else if (s->n_exact == 0) {
        begin_scanning(s);
    }
    return RC_SEEDS_BUSY;
}

#if RIGCAL_FOR_SPEED && RIGCAL_WITH_THREE_POINTS
static int32_t rooting_step(rigcal_search *s)
{
    if (rc_roots_step(&s->optima, &s->n_roots, &s->work.triple, &s->points)) {
        RIGCAL_TRACE("poses of the widest triple", s->n_roots, 0);
        s->phase = CHOOSING;
        if (s->n_roots == 0) {
            begin_scanning(s);
        }
    }
    return RC_SEEDS_BUSY;
}
#endif

int rc_seeds_scan(rigcal_search *s)
{
    if (FEW * s->n_roots == 0 || s->n_seeds > 0) {
        return 0;
    }
    s->next = 0;
    begin_scanning(s);
    return 1;
}

/* ---- the descent --------------------------------------------------------- */

/* Whether the cost falls all the way to an optimum found. Then a descent would only end
 * there once more. */
static int leads_to_found(const rigcal_search *s, const rigcal_real m3[3], rigcal_real cost)
{
    for (int32_t i = 0; i < s->optima.n; i++) {
        rigcal_real middle[3];
        found_direction(middle, s, i);
        rc_vec3_add(middle, m3);
        if (rc_vec3_unit(middle, middle) &&
            rc_direction_cost(&s->from.lattice.moments, middle) < cost) {
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
    rc_vec3_complete(m1, m2, seed);
    rc_vec3_combine(m3, ab[0], m1, ab[1], m2);
    rc_vec3_add(m3, seed);
    (void)rc_vec3_unit(m3, m3);
}

static void begin_descent(rigcal_search *s, const rigcal_real m3[3], rigcal_real cost)
{
    static const rigcal_real SIMPLEX[6] = {0, 0, EDGE, 0, 0, EDGE};
    rigcal_descent *const descent = &s->work.descent;
    rc_neldermead_begin_simplex(&descent->nm, SIMPLEX, 2, 0, 0, DESCENT_EVALS);
    rc_neldermead_tell(&descent->nm, cost); /* known already */
    rc_vec3_copy(descent->m3, m3);
    s->phase = DESCENT;
}

/* Descends from seed i, if it is worth a descent. */
static void try_seed(rigcal_search *s, int32_t i)
{
    const rigcal_real cost = s->from.lattice.cost[i];
    rigcal_real m3[3];
    seed_direction(m3, s->from.lattice.index[i]);
    RIGCAL_TRACE("seed: direction, cost", s->from.lattice.index[i], cost);
    if (cost < RC_MAX && !leads_to_found(s, m3, cost)) {
        begin_descent(s, m3, cost);
    }
}

/* Hands out a direction as a start, unless it would only lead to a known optimum. */
RC_APART static int32_t follow(rigcal_search *s, const rigcal_real m3[3])
{
    rigcal_transform *const start = &s->work.refinement.cam_from_points;
    seed_pose(start, s, m3);
    return (rc_optima_near(&s->optima, start->R, SAME_BASIN) < 0) ? RC_SEEDS_START
                                                                  : RC_SEEDS_BUSY;
}

static int32_t end_descent(rigcal_search *s)
{
    rigcal_lattice *const lattice = &s->from.lattice;
    const rigcal_vertex *const best = rc_neldermead_best(&s->work.descent.nm);
    rigcal_real m3[3];
    direction_near(m3, s->work.descent.m3, best->x);
    lattice->least_cost = rc_min(lattice->least_cost, best->cost);
    const rigcal_real hopeless = HOPELESS * lattice->least_cost;
    RIGCAL_TRACE("descent: evaluations, cost", s->work.descent.nm.evals, best->cost);
    s->phase = CHOOSING;
    return (s->optima.n == 0 || s->is_flat || !(best->cost > hopeless)) ? follow(s, m3)
                                                                        : RC_SEEDS_BUSY;
}

RC_APART_FAST static int32_t descent_step(rigcal_search *s)
{
    rigcal_neldermead *const nm = &s->work.descent.nm;
    rigcal_real m3[3];
    direction_near(m3, s->work.descent.m3, nm->trial.x);
    rc_neldermead_tell(nm, rc_direction_cost(&s->from.lattice.moments, m3));
    return (nm->status == RIGCAL_RUNNING) ? RC_SEEDS_BUSY : end_descent(s);
}

/* ---- flat targets -------------------------------------------------------- */

/* A flat target's other optimum leans the other way: its line of sight is the first one's,
 * m3, mirrored in the normal n: m3' = 2 (m3.n) n - m3. Nearly head-on the tilt is weakly
 * determined. Then the other optimum may lean more, and a third one may lie sideways. */
static void leaning_direction(rigcal_real m3[3], const rigcal_real first[3],
                              const rigcal_real normal[3], int32_t lean)
{
    rigcal_real side[3], back[3];
    rc_vec3_cross(side, normal, first);
    if (!(rc_vec3_norm(side) > HEAD_ON)) {
        rc_vec3_complete(side, back, normal);
    }
    rc_vec3_cross(back, normal, side); /* along n - m3, for the other way */
    const rigcal_real far = rc_max(1, LEAN_LEAST / rc_vec3_norm(side));
    rc_vec3_combine(m3, rc_vec3_dot(first, normal), normal,
                    (lean == SIDEWAYS_BACK) ? -far : far,
                    (lean == OTHER_WAY) ? back : side);
    (void)rc_vec3_unit(m3, m3);
}

/* Starts from a lean, if it is worth it. If roots were read, a lean from which the cost
 * falls to a known optimum is not. */
static int32_t try_lean(rigcal_search *s, int32_t lean)
{
    const rigcal_moments *const sums = &s->from.lattice.moments;
    const rigcal_real n = (rigcal_real)(int32_t)s->points.n_used;
    rigcal_real first[3], m3[3];
    found_direction(first, s, 0);
    leaning_direction(m3, first, s->normal, lean);
    RIGCAL_TRACE("lean (0: other way, 1, 2: sideways)", lean, rc_direction_cost(sums, m3));
    if (FEW * s->n_roots > 0 && (lean != OTHER_WAY || s->optima.n > 1) &&
        leads_to_found(s, m3, rc_direction_cost(sums, m3))) {
        return RC_SEEDS_BUSY;
    }
    return (lean == OTHER_WAY ||
            rc_direction_cost(sums, m3) * n < SHALLOW * rc_direction_cost(sums, first))
               ? follow(s, m3)
               : RC_SEEDS_BUSY;
}

/* ---- mirrored points ----------------------------------------------------- */

/* Mirrored points, -x, have the same image far away as x turned by half a turn about the
 * line of sight. So their pose is near the direction found. Its cost says whether it is
 * worth refining. */
int rc_seeds_mirrored(rigcal_search *s)
{
    RIGCAL_ASSERT(s->optima.n >= 1);
    rigcal_moments *const sums = &s->from.lattice.moments;
    rigcal_real m3[3];
    if (s->is_plane) {
        return 0;
    }
    found_direction(m3, s, 0);
    const rigcal_real cost = rc_direction_cost(sums, m3);
    rc_moments_mirror(sums);
    RIGCAL_TRACE("mirrored points: cost, over that as given", 0,
                 rc_direction_cost(sums, m3) / cost);
    if (!(rc_direction_cost(sums, m3) < MIRROR_WORSE * cost)) {
        return 0;
    }
    seed_pose(&s->work.refinement.cam_from_points, s, m3);
    return 1;
}

/* ---- few points ---------------------------------------------------------- */

/* Starts from the next root of the widest triple. The search finds no more optima than
 * roots were read, so none of the unread roots is overwritten. */
static int32_t next_root(rigcal_search *s)
{
    rigcal_transform *const start = &s->work.refinement.cam_from_points;
    rc_optimum_transform(start, &s->optima.list[s->next++]);
    return (rc_optima_near(&s->optima, start->R, SAME_BASIN) < 0) ? RC_SEEDS_START
                                                                  : RC_SEEDS_BUSY;
}

/* ---- the next start ------------------------------------------------------ */

RC_APART_FAST static int32_t choosing_step(rigcal_search *s)
{
    if (WITH_WIDE && s->next < s->n_exact) {
        return next_exact(s);
    }
    if (WITH_WIDE && s->triples > 0) {
        return end_triple(s);
    }
    if (FEW * s->n_roots > 0 && s->next < s->n_roots && s->n_seeds == 0) {
        return next_root(s);
    }
    if (s->is_flat && s->optima.n > 0 && s->leans < LEANS) {
        return try_lean(s, s->leans++);
    }
    if (s->next < s->n_seeds) {
        try_seed(s, s->next++);
    } else if (WITH_WIDE && s->is_wide) {
        s->phase = PICKING;
    } else {
        return RC_SEEDS_SPENT;
    }
    return RC_SEEDS_BUSY;
}

int32_t rc_seeds_step(rigcal_search *s)
{
    switch (s->phase) {
    case GATHERING:
        return gathering_step(s);
    case GATHERED:
        return begin_search(s);
#if RIGCAL_FOR_SPEED && RIGCAL_WITH_THREE_POINTS
    case ROOTING:
        return rooting_step(s);
#endif
    case PICKING:
        return WITH_WIDE ? picking_step(s) : RC_SEEDS_BUSY;
    case SCANNING:
        scanning_step(s);
        return RC_SEEDS_BUSY;
    case DESCENT:
        return descent_step(s);
    default:
        return choosing_step(s);
    }
}
