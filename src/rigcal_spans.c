#include "rc_edge.h"
#include "rc_outline.h"

/* ---- constants ----------------------------------------------------------- */

/* px: the largest fourth difference of the five nodes of an arc. A polynomial of fourth
 * degree then misses the border by a thirtieth of it, where the next differences are
 * smaller; a fifth of it was seen. */
#define BEND_MAX RC_TOL(1e-3, 0.2)

/* 1: the next arc may be twice as long if the fourth differences are smaller by this
 * factor. */
#define BEND_SPARE RC(16)

/* part of the radius of the image: length of the first arc. Later lengths follow from the
 * fourth differences. */
#define ARC_FIRST RC(0.5)

/* part of the radius of the image: length of the shortest arc, a few pixels. */
#define ARC_LEAST RC(0.01)

/* tangent: the largest angle of an arc is 45 degrees. */
#define STRIDE_MOST RC(1)

/* 1: a border is followed until its distance from the axis is this many times that of the
 * image's corners. The excess is for a decentered lens, whose distances do not grow
 * evenly. */
#define BEYOND RC(1.05)

/* px: a border ends if even an arc of this length would go beyond the lens. */
#define CLOSED_PX RC_TOL(0.02, 0.1)

/* arcs: the most of one border in one direction. */
enum { ARCS_OF_BORDER = 24 };

/* 1: two ends outside the image are joined by a straight line if the square of its distance
 * from the axis is at least this part of theirs. */
#define CUT RC(0.9998)

/* 1: else they are joined on a circle of this many times the radius of the image. Its
 * chords of 90 degrees are outside the image too. */
#define WIDE RC(3)

/* part of the width of the band: the least part of a join, if the lens bends it. */
#define PART_LEAST RC(0.1)

enum { NODES = RIGCAL_SPANS_NODES, LAST = NODES - 1 };

enum { NOT_BEGUN, START, TRACE, DONE };

/* ---- a border, one way --------------------------------------------------- */

/* The sign of the direction in which p moves: towards far (way 0) or near (way 1). */
static rigcal_real sign_of(const rigcal_spans_solver *s)
{
    return (s->way == 0) ? RC(-1) : RC(1);
}

static rigcal_real dot2(const rigcal_real a[2], const rigcal_real b[2])
{
    return a[0] * b[0] + a[1] * b[1];
}

/* a x b */
static rigcal_real cross2(const rigcal_real a[2], const rigcal_real b[2])
{
    return a[0] * b[1] - a[1] * b[0];
}

/* A pixel's place in the normalised image, and its squared distance from the axis. */
static rigcal_real normalise(rigcal_real x[2], const rigcal_spans_solver *s, rigcal_real u,
                             rigcal_real v)
{
    const rigcal_camera *const c = &s->edge.band.camera_b;
    x[0] = (u - c->cx) / c->fx;
    x[1] = (v - c->cy) / c->fy;
    return dot2(x, x);
}

/* Whether the border is outside the image at this node of the arc, and goes on outwards to
 * the last one. */
static int is_leaving(const rigcal_spans_solver *s, int node)
{
    rigcal_real x[2];
    const rigcal_real before = normalise(x, s, s->u[node], s->v[node]);
    return before > s->radius2 && normalise(x, s, s->u[LAST], s->v[LAST]) > before;
}

/* Sets the end of the next arc: `stride` ahead, or the end of the depth range. Returns 0 if
 * that end has been reached. */
static int aim(rigcal_spans_solver *s)
{
    const rigcal_real *const p = s->at, *const end = s->ends[s->way];
    const rigcal_real across = sign_of(s) * cross2(p, end), ahead = dot2(p, end);
    s->stride = rc_min(s->stride, STRIDE_MOST);
    s->is_last = ahead > 0 && across <= s->stride * ahead;
    if (s->is_last) {
        s->stride = across / ahead;
    }
    s->node = 1;
    return s->stride > RC_EPS;
}

/* p after this part of the stride. */
static void place_of_node(rigcal_real p[2], const rigcal_spans_solver *s, rigcal_real part)
{
    const rigcal_real turn = sign_of(s) * part * s->stride;
    p[0] = s->at[0] - turn * s->at[1];
    p[1] = s->at[1] + turn * s->at[0];
}

/* Finds the first place of a border, the nearest to the axis. Returns 0 if the lens does
 * not see it. */
static int begin_side(rigcal_spans_solver *s)
{
    const rigcal_real *const p = s->start;
    rigcal_real J[6], m[3];
    if (!rc_edge_begin_side(&s->edge, s->side, p) ||
        rc_edge_find(s->start_uv, J, &s->edge, p) != RIGCAL_OK) {
        return 0;
    }
    rc_vec3_combine(m, -p[1], s->edge.band.ray, p[0], s->edge.band.towards);
    const rigcal_real speed[3] = {rc_vec3_dot(&J[0], m), rc_vec3_dot(&J[3], m), 0};
    s->start_speed = rc_vec3_norm(speed);
    s->start_height = s->edge.height;
    s->way = 0;
    return s->start_speed > 0;
}

/* Begins at the first place, in one of the two directions. */
static void begin_way(rigcal_spans_solver *s)
{
    s->u[0] = s->start_uv[0];
    s->v[0] = s->start_uv[1];
    s->at[0] = s->start[0];
    s->at[1] = s->start[1];
    s->edge.height = s->start_height;
    s->length = ARC_FIRST * s->radius;
    s->stride = s->length / s->start_speed;
    s->n_arcs = s->is_closing = 0;
}

static void end_way(rigcal_spans_solver *s)
{
    rigcal_border_end *const corner = &s->corners[s->side][s->way];
    corner->uv[0] = s->u[0];
    corner->uv[1] = s->v[0];
    corner->height = s->edge.height;
    corner->is_of_range = s->is_last;
    s->way++;
}

/* Adds the curve through the nodes to the outline, and counts its turns around the axis:
 * how often it crosses the half line from the axis along u. The outline goes from side 0 to
 * side 1 at near, and back at far. A curve that goes the other way counts the other way. */
static void add_curve(rigcal_spans_solver *s)
{
    const rigcal_camera *const c = &s->edge.band.camera_b;
    const rigcal_real a[2] = {s->u[0] - c->cx, s->v[0] - c->cy};
    const rigcal_real b[2] = {s->u[LAST] - c->cx, s->v[LAST] - c->cy};
    const int rises = a[1] < 0;
    if ((b[1] < 0) != rises && (cross2(a, b) > 0) == rises) {
        s->turns += (rises == (s->side == s->way)) ? -1 : 1;
    }
    rc_outline_add(&s->outline, s->u, s->v);
}

/* Adds a straight line. */
static void add_line(rigcal_spans_solver *s, const rigcal_real from[2],
                     const rigcal_real to[2])
{
    for (int i = 0; i < LAST; i++) {
        const rigcal_real part = (rigcal_real)i / LAST;
        s->u[i] = from[0] + part * (to[0] - from[0]);
        s->v[i] = from[1] + part * (to[1] - from[1]);
    }
    s->u[LAST] = to[0];
    s->v[LAST] = to[1];
    add_curve(s);
}

/* Whether the straight line between two places of the normalised image comes nearer to the
 * axis than both of them and the circle around the image. a2 and b2 are their squared
 * distances from the axis. */
static int cuts_circle(const rigcal_spans_solver *s, const rigcal_real a[2], rigcal_real a2,
                       const rigcal_real b[2], rigcal_real b2)
{
    const rigcal_real ab[2] = {b[0] - a[0], b[1] - a[1]}, area = cross2(a, b);
    const rigcal_real length2 = dot2(ab, ab), ahead = -dot2(a, ab);
    return ahead > 0 && ahead < length2 &&
           area * area < CUT * rc_min(s->radius2, rc_min(a2, b2)) * length2;
}

/* The place of a wide circle around the image, in this direction from the axis. */
static void place_on_circle(rigcal_real uv[2], const rigcal_spans_solver *s,
                            const rigcal_real d[2])
{
    const rigcal_camera *const c = &s->edge.band.camera_b;
    const rigcal_real radius = WIDE * RC_SQRT(s->radius2);
    uv[0] = c->cx + radius * d[0] * c->fx;
    uv[1] = c->cy + radius * d[1] * c->fy;
}

/* Adds four chords of the wide circle. What was outside the outline is then inside. */
static void turn_inside_out(rigcal_spans_solver *s)
{
    rigcal_real d[2] = {1, 0}, from[2], to[2];
    for (int side = 0; side < 4; side++) {
        place_on_circle(from, s, d);
        const rigcal_real next[2] = {-d[1], d[0]};
        place_on_circle(to, s, next);
        add_line(s, from, to);
        d[0] = next[0];
        d[1] = next[1];
    }
}

/* Joins two ends that are outside the image or where the lens ends. A straight line between
 * them may cut the image if the band is wide. Then the join goes out from the axis, around
 * it on a wide circle by the shorter way, and in again. */
static void go_round(rigcal_spans_solver *s, const rigcal_real from[2],
                     const rigcal_real to[2])
{
    rigcal_real a[3] = {0, 0, 0}, b[3] = {0, 0, 0}, at[2] = {from[0], from[1]};
    const rigcal_real a2 = normalise(a, s, from[0], from[1]);
    const rigcal_real b2 = normalise(b, s, to[0], to[1]);
    if (!cuts_circle(s, a, a2, b, b2)) {
        add_line(s, from, to);
        return;
    }
    (void)rc_vec3_unit(a, a); /* the line passes the axis between them: neither is on it */
    (void)rc_vec3_unit(b, b);
    const rigcal_real way = (cross2(a, b) < 0) ? RC(-1) : RC(1);
    const rigcal_real aside[3] = {way * (b[1] - a[1]), way * (a[0] - b[0]), 0};
    rigcal_real between[3] = {b[0], b[1], 0};
    (void)rc_vec3_unit(between, aside);
    for (int i = 0; i < 3; i++) {
        rigcal_real next[2];
        place_on_circle(next, s, (i == 0) ? a : (i == 1) ? between : b);
        add_line(s, at, next);
        at[0] = next[0];
        at[1] = next[1];
    }
    add_line(s, at, to);
}

/* The largest fourth difference of the nodes. */
static rigcal_real bend_of(const rigcal_real x[NODES])
{
    return RC_FABS((x[0] + x[4]) - 4 * (x[1] + x[3]) + 6 * x[2]);
}

/* Sets the stride of the next arc. It is longer after an arc of small fourth
 * differences. */
static void set_stride(rigcal_spans_solver *s, rigcal_real bend)
{
    const rigcal_real chord[3] = {s->u[LAST] - s->u[LAST - 1], s->v[LAST] - s->v[LAST - 1],
                                  0};
    if (s->is_closing) {
        return;
    }
    if (bend * BEND_SPARE < BEND_MAX) {
        s->length *= 2;
    }
    s->stride *= s->length / rc_max(LAST * rc_vec3_norm(chord), ARC_LEAST * s->length);
}

/* Whether the last node is nearer to the first one than the second one is. */
static int turns_back(const rigcal_spans_solver *s)
{
    const rigcal_real next[2] = {s->u[1] - s->u[0], s->v[1] - s->v[0]};
    const rigcal_real last[2] = {s->u[LAST] - s->u[0], s->v[LAST] - s->v[0]};
    return dot2(last, last) < dot2(next, next);
}

/* Takes the arc through the nodes. No polynomial fits nodes that leap over the end of the
 * lens, or to and fro beside it, or far away from the image: only their ends are joined. */
static void add_arc(rigcal_spans_solver *s, int is_bent)
{
    const rigcal_real from[2] = {s->u[0], s->v[0]}, to[2] = {s->u[LAST], s->v[LAST]};
    rigcal_real x[2];
    const rigcal_real least2 =
        rc_min(normalise(x, s, from[0], from[1]), normalise(x, s, to[0], to[1]));
    if (is_bent && (least2 > s->radius2 || turns_back(s))) {
        go_round(s, from, to);
    } else {
        add_curve(s);
    }
}

/* After all five nodes: takes the arc, or begins it again at half the length. Returns 0 if
 * the border ends with this arc, at the end of the depth range or outside the image. */
static int finish_arc(rigcal_spans_solver *s)
{
    const rigcal_real bend = rc_max(bend_of(s->u), bend_of(s->v));
    rigcal_real p[3] = {0, 0, 0}, unit[3] = {1, 0, 0};
    if (bend > BEND_MAX && s->length > ARC_LEAST * s->radius &&
        s->n_arcs < ARCS_OF_BORDER) {
        s->length /= 2;
        s->stride /= 2;
        return 1;
    }
    const int leaves = is_leaving(s, LAST - 1);
    place_of_node(p, s, 1);
    (void)rc_vec3_unit(unit, p);
    s->at[0] = unit[0];
    s->at[1] = unit[1];
    set_stride(s, bend);
    add_arc(s, bend > BEND_MAX);
    s->u[0] = s->u[LAST];
    s->v[0] = s->v[LAST];
    s->n_arcs++;
    return !s->is_last && s->n_arcs < 2 * ARCS_OF_BORDER && !leaves;
}

/* Adds one node of the current arc. If the lens does not see it, the arc begins again at
 * half the length, down to CLOSED_PX. Returns 0 if the border ends. */
static int add_node(rigcal_spans_solver *s)
{
    rigcal_real p[2], uv[2], J[6];
    place_of_node(p, s, (rigcal_real)s->node / LAST);
    if (rc_edge_find(uv, J, &s->edge, p) != RIGCAL_OK) {
        s->length /= 2;
        s->stride /= 2;
        s->is_closing = 1;
        (void)aim(s);
        return s->length > CLOSED_PX;
    }
    s->u[s->node] = uv[0];
    s->v[s->node] = uv[1];
    s->node++;
    return s->node < NODES || (finish_arc(s) && aim(s));
}

/* ---- the ends ------------------------------------------------------------ */

/* Finds the nodes of a part of an end of the depth range: from the height `from` on, over
 * `rise`. The first node stays. Returns 0 if the lens does not see one of them. */
static int place_nodes(rigcal_spans_solver *s, rigcal_real from, rigcal_real rise)
{
    for (int i = 1; i < NODES; i++) {
        const rigcal_real h = from + (rigcal_real)i / LAST * rise;
        rigcal_real uv[2];
        if (rc_edge_pixel(uv, &s->edge, s->ends[s->way], h) != RIGCAL_OK) {
            return 0;
        }
        s->u[i] = uv[0];
        s->v[i] = uv[1];
    }
    return 1;
}

/* Follows an end of the depth range across the band, from border s->side to the other one,
 * in parts. It stops where the lens ends, or outside the image if the other border does not
 * reach this end. Returns 1 at the other border; *stop is the last place. */
static int cross_band(rigcal_real stop[2], rigcal_spans_solver *s)
{
    const rigcal_border_end *const from = &s->corners[s->side][s->way];
    const rigcal_border_end *const to = &s->corners[!s->side][s->way];
    const rigcal_real rise = to->height - from->height;
    rigcal_real at = 0, part = 1;
    int leaves = 0;
    stop[0] = from->uv[0];
    stop[1] = from->uv[1];
    while (at < 1 && !leaves) {
        s->u[0] = stop[0];
        s->v[0] = stop[1];
        const int is_seen = place_nodes(s, from->height + at * rise, part * rise);
        const int is_bent = is_seen && rc_max(bend_of(s->u), bend_of(s->v)) > BEND_MAX;
        if ((!is_seen || is_bent) && part > PART_LEAST) {
            part /= 2;
            continue;
        }
        if (!is_seen) {
            return 0;
        }
        at += part;
        if (!(at < 1) && to->is_of_range) {
            s->u[LAST] = to->uv[0];
            s->v[LAST] = to->uv[1];
        }
        stop[0] = s->u[LAST];
        stop[1] = s->v[LAST];
        leaves = !to->is_of_range && is_leaving(s, 0);
        add_arc(s, is_bent);
    }
    return to->is_of_range;
}

/* Joins the two borders at one of their ends, along the end of the depth range if one of
 * them reaches it. */
static void close_way(rigcal_spans_solver *s, int way)
{
    const rigcal_border_end *const from = &s->corners[0][way];
    const rigcal_border_end *const to = &s->corners[1][way];
    rigcal_real stop[2] = {from->uv[0], from->uv[1]}, back[2] = {to->uv[0], to->uv[1]};
    rigcal_real again[2];
    s->way = way;
    s->side = 0;
    if (from->is_of_range && cross_band(stop, s)) {
        return;
    }
    /* If both reach it, the lens ends on the way. It may see the way again at the other
     * border. */
    if (to->is_of_range &&
        (!from->is_of_range ||
         rc_edge_pixel(again, &s->edge, s->ends[way], to->height) == RIGCAL_OK)) {
        s->side = 1;
        (void)cross_band(back, s);
        s->side = 0;
    }
    go_round(s, stop, back);
}

/* The outline turns around the axis once if the band holds the axis, else not at all. It
 * turns the other way if the band passes straight behind the camera. Then the joins went
 * round on the wrong side, and the outline is inside out. */
static void finish(rigcal_spans_solver *s, int is_seen)
{
    if (is_seen) {
        close_way(s, 0);
        close_way(s, 1);
        if (s->turns < 0) {
            turn_inside_out(s);
        }
    } else {
        rc_outline_begin(&s->outline, s->edge.band.camera_b.height);
    }
    rc_outline_close(&s->outline);
    s->phase = DONE;
    s->status = s->outline.is_full ? RIGCAL_ERR_DEGENERATE : RIGCAL_OK;
}

/* ---- begin, step, result ------------------------------------------------- */

/* Finds the place of the line that is nearest to the axis, within the depth range, and the
 * circle around the image. */
static void prepare(rigcal_spans_solver *s)
{
    const rigcal_band *const band = &s->edge.band;
    const rigcal_camera *const c = &band->camera_b;
    rc_band_ends(s->ends, band);
    rigcal_real start[3] = {band->ray[2], band->towards[2], 0}, unit[3] = {1, 0, 0}, x[2];
    if (cross2(s->ends[0], start) < 0 || cross2(start, s->ends[1]) < 0) {
        const int is_nearer = dot2(s->ends[1], start) > dot2(s->ends[0], start);
        start[0] = s->ends[is_nearer][0];
        start[1] = s->ends[is_nearer][1];
    }
    (void)rc_vec3_unit(unit, start);
    s->start[0] = unit[0];
    s->start[1] = unit[1];
    s->radius2 = 0;
    for (int i = 0; i < 4; i++) {
        const rigcal_real u = (i % 2 == 0) ? 0 : (rigcal_real)(c->width - 1);
        const rigcal_real v = (i < 2) ? 0 : (rigcal_real)(c->height - 1);
        s->radius2 = rc_max(s->radius2, normalise(x, s, u, v));
    }
    s->radius2 *= BEYOND * BEYOND;
    s->radius = RC_SQRT(s->radius2) * c->fx + 1;
}

rigcal_status rigcal_spans_begin(rigcal_spans_solver *solver, const rigcal_band *band)
{
    if (solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    solver->phase = NOT_BEGUN;
    const rigcal_status status = rc_band_check(band);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (!rc_edge_begin(&solver->edge, band)) {
        return RIGCAL_ERR_RANGE;
    }
    prepare(solver);
    rc_outline_begin(&solver->outline, band->camera_b.height);
    solver->side = solver->way = solver->turns = 0;
    solver->phase = START;
    solver->status = RIGCAL_RUNNING;
    return RIGCAL_OK;
}

/* One unit: the first place of a side, or a node. */
static void step(rigcal_spans_solver *s)
{
    if (s->phase == START) {
        if (!begin_side(s)) {
            finish(s, 0);
            return;
        }
        s->phase = TRACE;
        begin_way(s);
        if (aim(s)) {
            return;
        }
    } else if (add_node(s)) {
        return;
    }
    for (end_way(s); s->way < 2; end_way(s)) {
        begin_way(s);
        if (aim(s)) {
            return;
        }
    }
    s->side++;
    s->phase = START;
    if (s->side == 2) {
        finish(s, 1);
    }
}

rigcal_status rigcal_spans_step(rigcal_spans_solver *solver, int32_t budget)
{
    if (solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (budget < 1) {
        return RIGCAL_ERR_RANGE;
    }
    if (solver->phase == NOT_BEGUN) {
        return RIGCAL_ERR_STATE;
    }
    for (int32_t i = 0; i < budget && solver->phase != DONE; i++) {
        step(solver);
    }
    return (solver->phase == DONE) ? solver->status : RIGCAL_RUNNING;
}

rigcal_status rigcal_spans_row(rigcal_span spans[], size_t *n_found,
                               rigcal_spans_solver *solver, int32_t row)
{
    if (spans == NULL || n_found == NULL || solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (solver->phase != DONE || solver->status != RIGCAL_OK) {
        return RIGCAL_ERR_STATE;
    }
    if (row < 0 || row >= solver->edge.band.camera_b.height) {
        return RIGCAL_ERR_RANGE;
    }
    *n_found =
        rc_outline_row(spans, &solver->outline, row, solver->edge.band.camera_b.width);
    return RIGCAL_OK;
}

rigcal_status rigcal_spans_result(rigcal_span spans[], size_t capacity, size_t *n_found,
                                  rigcal_spans_solver *solver)
{
    if (spans == NULL || n_found == NULL || solver == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (solver->phase != DONE || solver->status != RIGCAL_OK) {
        return RIGCAL_ERR_STATE;
    }
    const int32_t width = solver->edge.band.camera_b.width;
    size_t found = 0;
    int32_t last, row = rc_outline_rows(&last, &solver->outline);
    while (row <= last) {
        rigcal_span of_row[RIGCAL_SPANS_ROW];
        if (capacity - found >= RIGCAL_SPANS_ROW) {
            found += rc_outline_stretch(&spans[found], capacity - found, &solver->outline,
                                        &row, last, width);
            continue;
        }
        const size_t n = rc_outline_row(of_row, &solver->outline, row, width);
        if (n > capacity - found) {
            return RIGCAL_ERR_CAPACITY;
        }
        for (size_t i = 0; i < n; i++) {
            spans[found + i] = of_row[i];
        }
        found += n;
        row++;
    }
    if (found == 0) {
        return RIGCAL_ERR_OUTSIDE;
    }
    *n_found = found;
    return RIGCAL_OK;
}

rigcal_status rigcal_spans_find(rigcal_span spans[], size_t capacity, size_t *n_found,
                                rigcal_spans_solver *solver, const rigcal_band *band)
{
    if (spans == NULL || n_found == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rigcal_spans_begin(solver, band);
    if (status == RIGCAL_OK) {
        status = rigcal_spans_step(solver, RIGCAL_SPANS_UNITS);
    }
    return (status == RIGCAL_OK) ? rigcal_spans_result(spans, capacity, n_found, solver)
                                 : status;
}
