#include "rc_outline.h"

/* ---- constants ----------------------------------------------------------- */

/* px: an arc may be wrong by this where it crosses a row. Both ends of a span are moved
 * outwards by it, so that no pixel is missed. Half a pixel would add one. */
#define SLACK RC(0.1)

/* px: accuracy of a crossing, along the row. */
#define CROSSING_TOL RC_TOL(2e-5, 2e-3)

/* px: the last step of Newton's method along the row. The error after it is its square,
 * over some pixels. */
#define NEWTON_PX RC_TOL(1e-3, 0.05)

/* px: how far a polynomial in v may be from the arc, along the row. */
#define DIRECT_TOL RC_TOL(2e-5, 5e-3)

/* rows: a polynomial in v is made only for arcs of more than this. */
#define DIRECT_ROWS RC(6)

/* rows: a longer arc is divided if no polynomial in v fits it. */
#define PART_ROWS RC(16)

/* parts: such an arc is divided into this many. */
enum { PARTS = 4 };

/* arcs: none is divided if there are more. */
enum { ARCS_TO_PART = RIGCAL_SPANS_ARCS / 2 };

/* steps: the most of Newton's method for a crossing, usually 2. */
enum { CROSSING_STEPS = 24 };

enum { NODES = RIGCAL_SPANS_NODES, LAST = NODES - 1 };

/* ---- polynomials --------------------------------------------------------- */

/* The value at t; *slope is the derivative there. */
static rigcal_real value_at(rigcal_real *slope, const rigcal_real c[NODES], rigcal_real t)
{
    rigcal_real value = c[LAST], derivative = 0;
    for (int i = LAST - 1; i >= 0; i--) {
        derivative = derivative * t + value;
        value = value * t + c[i];
    }
    *slope = derivative;
    return value;
}

static rigcal_real slope_at(const rigcal_real c[NODES], rigcal_real t)
{
    return c[1] + t * (2 * c[2] + t * (3 * c[3] + t * 4 * c[4]));
}

/* Coefficients of the powers of t, from the values at 0, 1 .. 4: Newton's differences d,
 * multiplied out. */
static void fit_even(rigcal_real c[NODES], const rigcal_real x[NODES])
{
    const rigcal_real d1 = x[1] - x[0], e1 = x[2] - x[1], f1 = x[3] - x[2],
                      g1 = x[4] - x[3];
    const rigcal_real d2 = e1 - d1, e2 = f1 - e1, d3 = e2 - d2, d4 = (g1 - f1) - e2 - d3;
    c[0] = x[0];
    c[1] = d1 - d2 / 2 + d3 / 3 - d4 / 4;
    c[2] = (d2 - d3) / 2 + d4 * 11 / 24;
    c[3] = d3 / 6 - d4 / 4;
    c[4] = d4 / 24;
}

/* The polynomial in w = v - b[0]. */
static inline rigcal_real direct_at(const rigcal_real a[NODES], rigcal_real w)
{
    return a[0] + w * (a[1] + w * (a[2] + w * (a[3] + w * a[4])));
}

/* Makes u a polynomial in v, if that is as accurate. */
static void make_direct(rigcal_arc *arc)
{
    rigcal_real a[NODES], b[NODES], slope, v[2], u[2];
    const rigcal_real step = (arc->t_high - arc->t_low) / LAST;
    for (int i = 0; i < NODES; i++) {
        const rigcal_real t = arc->t_low + (rigcal_real)i * step;
        a[i] = value_at(&slope, arc->a, t);
        b[i] = value_at(&slope, arc->b, t);
    }
    for (int i = 0; i < 2; i++) { /* the error is largest near the ends */
        const rigcal_real t = arc->t_low + (RC(0.5) + (rigcal_real)(3 * i)) * step;
        u[i] = value_at(&slope, arc->a, t);
        v[i] = value_at(&slope, arc->b, t);
    }
    for (int k = 1; k < NODES; k++) {
        for (int i = LAST; i >= k; i--) {
            const rigcal_real rise = b[i] - b[i - k];
            if (!(rise > 0)) {
                return;
            }
            a[i] = (a[i] - a[i - 1]) / rise;
        }
    }
    for (int k = LAST - 1; k > 0; k--) { /* multiplies by (w - w_k), adds a[k] */
        for (int i = k; i < LAST; i++) {
            a[i] -= (b[k] - b[0]) * a[i + 1];
        }
    }
    for (int i = 0; i < 2; i++) {
        if (!(RC_FABS(direct_at(a, v[i] - b[0]) - u[i]) <= DIRECT_TOL)) {
            return;
        }
    }
    arc->is_direct = 1;
    arc->b[0] = b[0];
    for (int i = 0; i < NODES; i++) {
        arc->a[i] = a[i];
    }
}

/* ---- arcs ---------------------------------------------------------------- */

void rc_outline_begin(rigcal_outline *outline, int32_t height)
{
    outline->n_arcs = 0;
    outline->height = height;
    outline->is_full = 0;
    outline->row = -1;
    outline->changes = 0;
    outline->next = outline->n_active = 0;
}

/* The first row at or below v. The rows in [v0, v1) begin at row_from(v0) and end before
 * row_from(v1). */
static int32_t row_from(const rigcal_outline *outline, rigcal_real v)
{
    if (!(v > 0)) {
        return 0;
    }
    if (!(v < (rigcal_real)outline->height)) {
        return outline->height;
    }
    const int32_t whole = (int32_t)v;
    return whole + ((rigcal_real)whole < v);
}

/* Adds the arc from t[0] to t[1], at whose ends v is ends[0] and ends[1]. An arc that
 * crosses no row is left out. */
static void add_arc(rigcal_outline *outline, const rigcal_real u[NODES],
                    const rigcal_real v[NODES], const rigcal_real t[2],
                    const rigcal_real ends[2])
{
    const int falls = ends[0] > ends[1];
    if (row_from(outline, ends[0]) == row_from(outline, ends[1])) {
        return;
    }
    if (outline->n_arcs == RIGCAL_SPANS_ARCS) {
        outline->is_full = 1;
        return;
    }
    rigcal_arc *const arc = &outline->arcs[outline->n_arcs];
    outline->n_arcs++;
    arc->low = ends[falls];
    arc->high = ends[!falls];
    arc->t_low = t[falls];
    arc->t_high = t[!falls];
    arc->is_direct = 0;
    for (int i = 0; i < NODES; i++) {
        arc->a[i] = u[i];
        arc->b[i] = v[i];
    }
    if (arc->high - arc->low > DIRECT_ROWS) {
        make_direct(arc);
    }
}

/* Adds an arc. A long one that is not direct is added in parts: most parts are direct. */
static void add_parts(rigcal_outline *outline, const rigcal_real u[NODES],
                      const rigcal_real v[NODES], const rigcal_real t[2],
                      const rigcal_real ends[2])
{
    const int32_t before = outline->n_arcs;
    rigcal_real slope, part_t[2] = {t[0], t[0]}, part_ends[2] = {ends[0], ends[0]};
    add_arc(outline, u, v, t, ends);
    if (outline->n_arcs == before || outline->n_arcs > ARCS_TO_PART ||
        outline->arcs[before].is_direct || !(RC_FABS(ends[1] - ends[0]) > PART_ROWS)) {
        return;
    }
    outline->n_arcs = before;
    for (int i = 1; i <= PARTS; i++) {
        part_t[1] = (i < PARTS) ? t[0] + (rigcal_real)i * ((t[1] - t[0]) / PARTS) : t[1];
        part_ends[1] = (i < PARTS) ? value_at(&slope, v, part_t[1]) : ends[1];
        add_arc(outline, u, v, part_t, part_ends);
        part_t[0] = part_t[1];
        part_ends[0] = part_ends[1];
    }
}

/* Where v turns between t and t + 1, at which its slopes have different signs. Halves the
 * interval down to rounding. */
static rigcal_real turning_point(const rigcal_real v[NODES], rigcal_real t, int rises)
{
    rigcal_real from = t, width = RC(1) / 2;
    while (width > RC_EPS) {
        if ((slope_at(v, from + width) > 0) == rises) {
            from += width;
        }
        width /= 2;
    }
    return from;
}

void rc_outline_add(rigcal_outline *outline, const rigcal_real u[NODES],
                    const rigcal_real v[NODES])
{
    rigcal_real cu[NODES], cv[NODES], slope, t[2] = {0, 0}, ends[2] = {v[0], v[0]};
    fit_even(cu, u);
    fit_even(cv, v);
    int rises = cv[1] > 0;
    for (int i = 1; i < NODES; i++) {
        if ((slope_at(cv, (rigcal_real)i) > 0) != rises) {
            t[1] = turning_point(cv, (rigcal_real)(i - 1), rises);
            ends[1] = value_at(&slope, cv, t[1]);
            add_parts(outline, cu, cv, t, ends);
            t[0] = t[1];
            ends[0] = ends[1];
            rises = !rises;
        }
    }
    t[1] = LAST;
    ends[1] = v[LAST];
    add_parts(outline, cu, cv, t, ends);
}

void rc_outline_close(rigcal_outline *outline)
{
    for (int32_t i = 0; i < outline->n_arcs; i++) {
        const rigcal_real low = outline->arcs[i].low;
        int32_t at = i;
        for (; at > 0 && low < outline->arcs[outline->order[at - 1]].low; at--) {
            outline->order[at] = outline->order[at - 1];
        }
        outline->order[at] = (uint8_t)i;
    }
}

int32_t rc_outline_rows(int32_t *last, const rigcal_outline *outline)
{
    rigcal_real high = 0;
    for (int32_t i = 0; i < outline->n_arcs; i++) {
        high = rc_max(high, outline->arcs[i].high);
    }
    *last = row_from(outline, high) - 1;
    return (outline->n_arcs > 0) ? row_from(outline, outline->arcs[outline->order[0]].low)
                                 : outline->height;
}

/* ---- rows ---------------------------------------------------------------- */

/* u where the arc crosses v = row, by Newton's method. Bounds that close in keep it on the
 * arc. */
RC_APART static rigcal_real crossing_of_t(const rigcal_arc *arc, rigcal_real row)
{
    rigcal_real low = arc->t_low, high = arc->t_high, slope;
    rigcal_real t = low + (high - low) * (row - arc->low) / (arc->high - arc->low);
    rigcal_real along = RC_FABS(slope_at(arc->a, t));
    for (int i = 0; i < CROSSING_STEPS; i++) {
        const rigcal_real gap = row - value_at(&slope, arc->b, t);
        if (gap > 0) {
            low = t;
        } else {
            high = t;
        }
        rigcal_real next = t + gap / slope;
        if (!((next - low) * (next - high) <= 0)) {
            next = (low + high) / 2;
        }
        /* u may turn at one end of the step. */
        const rigcal_real along_next = RC_FABS(slope_at(arc->a, next));
        const rigcal_real moved = (next - t) * rc_max(along, along_next);
        t = next;
        along = along_next;
        if (!(RC_FABS(moved) > NEWTON_PX)) {
            break;
        }
    }
    return value_at(&slope, arc->a, t);
}

static inline rigcal_real crossing(const rigcal_arc *arc, rigcal_real row)
{
    return arc->is_direct ? direct_at(arc->a, row - arc->b[0]) : crossing_of_t(arc, row);
}

static void see_change(rigcal_outline *outline, rigcal_real v)
{
    outline->changes = rc_min(outline->changes, v);
}

/* Finds the arcs that cross the row. They stay the same up to the row `changes`. If the row
 * is above the last one, all arcs are found anew, so that no active arc begins below the
 * row. */
static void go_to_row(rigcal_outline *outline, int32_t row)
{
    const rigcal_real v = (rigcal_real)row;
    int32_t kept = 0;
    if (row < outline->row) {
        outline->next = outline->n_active = 0;
    }
    outline->changes = RC_MAX;
    for (int32_t i = 0; i < outline->n_active; i++) {
        if (v < outline->arcs[outline->active[i]].high) {
            outline->active[kept] = outline->active[i];
            kept++;
            see_change(outline, outline->arcs[outline->active[i]].high);
        }
    }
    for (; outline->next < outline->n_arcs; outline->next++) {
        const uint8_t which = outline->order[outline->next];
        if (outline->arcs[which].low > v) {
            see_change(outline, outline->arcs[which].low);
            break;
        }
        if (v < outline->arcs[which].high && kept < RIGCAL_SPANS_ACTIVE) {
            outline->active[kept] = which;
            kept++;
            see_change(outline, outline->arcs[which].high);
        }
    }
    outline->n_active = kept;
}

/* The first column at or right of u. u must not be far from the image. */
static inline int32_t column_from(rigcal_real u)
{
    const int32_t whole = (u > 0) ? (int32_t)u : 0;
    return whole + ((rigcal_real)whole < u);
}

/* Adds the pixels of [from, to] within the columns. If it holds a pixel at all, those
 * within SLACK beside it are added too. Spans that touch become one. */
static inline size_t add_span(rigcal_span spans[], size_t n, rigcal_real from,
                              rigcal_real to, int32_t row, rigcal_real end)
{
    if (!(to >= -CROSSING_TOL && from <= end + CROSSING_TOL)) {
        return n;
    }
    const int32_t first = column_from(from - SLACK);
    const int32_t last = (int32_t)rc_min(to + SLACK, end);
    if (last - first < 2 &&
        !((rigcal_real)column_from(from - CROSSING_TOL) <= to + CROSSING_TOL)) {
        return n;
    }
    if (n > 0 && first <= spans[n - 1].last) {
        spans[n - 1].last = (last > spans[n - 1].last) ? last : spans[n - 1].last;
        return n;
    }
    spans[n].row = row;
    spans[n].first = first;
    spans[n].last = last;
    return n + 1;
}

size_t rc_outline_row(rigcal_span spans[RIGCAL_SPANS_ROW], rigcal_outline *outline,
                      int32_t row, int32_t width)
{
    const rigcal_real end = (rigcal_real)(width - 1);
    rigcal_real at[RIGCAL_SPANS_ACTIVE];
    size_t n = 0;
    if (row < outline->row || !((rigcal_real)row < outline->changes)) {
        go_to_row(outline, row);
    }
    outline->row = row;
    if (outline->n_active == 2) { /* nearly always so */
        const rigcal_real u0 =
            crossing(&outline->arcs[outline->active[0]], (rigcal_real)row);
        const rigcal_real u1 =
            crossing(&outline->arcs[outline->active[1]], (rigcal_real)row);
        return add_span(spans, 0, rc_min(u0, u1), rc_max(u0, u1), row, end);
    }
    for (int32_t i = 0; i < outline->n_active; i++) {
        const rigcal_real u =
            crossing(&outline->arcs[outline->active[i]], (rigcal_real)row);
        int32_t k = i;
        for (; k > 0 && u < at[k - 1]; k--) {
            at[k] = at[k - 1];
        }
        at[k] = u;
    }
    for (int32_t i = 0; i + 1 < outline->n_active; i += 2) {
        n = add_span(spans, n, at[i], at[i + 1], row, end);
    }
    return n;
}

size_t rc_outline_stretch(rigcal_span spans[], size_t room, rigcal_outline *outline,
                          int32_t *row, int32_t last, int32_t width)
{
    const rigcal_real end = (rigcal_real)(width - 1);
    size_t n = rc_outline_row(spans, outline, *row, width);
    (*row)++;
    if (outline->n_active != 2) {
        return n;
    }
    const rigcal_arc *const p = &outline->arcs[outline->active[0]];
    const rigcal_arc *const q = &outline->arcs[outline->active[1]];
    if (!p->is_direct || !q->is_direct) {
        return n;
    }
    for (; *row <= last && n < room; (*row)++) {
        const rigcal_real v = (rigcal_real)*row;
        if (!(v < outline->changes)) {
            break;
        }
        const rigcal_real u0 = direct_at(p->a, v - p->b[0]);
        const rigcal_real u1 = direct_at(q->a, v - q->b[0]);
        n += add_span(&spans[n], 0, rc_min(u0, u1), rc_max(u0, u1), *row, end);
    }
    return n;
}
