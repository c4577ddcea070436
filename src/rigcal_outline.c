#include "rc_outline.h"

/* ---- constants ----------------------------------------------------------- */

/* px: how far an arc may be from where it is computed to cross a row. Both ends of a span
 * are moved outwards by this, so that no pixel is missed; half a pixel would add one. */
#define SLACK RC(0.1)

/* px: how well a crossing is found, along the row. */
#define CROSSING_TOL RC_TOL(2e-5, 2e-3)

/* rows: an arc of fewer is not worth a polynomial by v. */
#define DIRECT_ROWS RC(6)

/* steps: of a crossing by Newton's method, usually 2; and of a turning point by halving. */
enum { CROSSING_STEPS = 24, TURN_STEPS = RIGCAL_USE_FLOAT ? 24 : 50 };

enum { NODES = RIGCAL_SPANS_NODES, LAST = NODES - 1 };

/* ---- polynomials --------------------------------------------------------- */

/* The value at t, and the derivative where it is wanted. */
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

/* By powers of t, from the values at 0, 1 .. 4: Newton's differences, multiplied out. */
static void fit_even(rigcal_real c[NODES], const rigcal_real nodes[NODES])
{
    for (int i = 0; i < NODES; i++) {
        c[i] = nodes[i];
    }
    for (int k = 1; k < NODES; k++) {
        for (int i = LAST; i >= k; i--) {
            c[i] = (c[i] - c[i - 1]) / (rigcal_real)k;
        }
    }
    for (int k = LAST - 1; k >= 0; k--) { /* (t - k) times what is above, and c[k] */
        for (int i = k; i < LAST; i++) {
            c[i] -= (rigcal_real)k * c[i + 1];
        }
    }
}

/* a[0] + (v - b[0]) (a[1] + ..) */
static rigcal_real direct_at(const rigcal_arc *arc, rigcal_real v)
{
    rigcal_real u = arc->a[LAST];
    for (int i = LAST - 1; i >= 0; i--) {
        u = arc->a[i] + (v - arc->b[i]) * u;
    }
    return u;
}

/* u as a polynomial of v, where that is as good. */
static void make_direct(rigcal_arc *arc)
{
    rigcal_arc direct = *arc;
    const rigcal_real step = (arc->t_high - arc->t_low) / LAST;
    rigcal_real slope;
    for (int i = 0; i < NODES; i++) {
        const rigcal_real t = arc->t_low + (rigcal_real)i * step;
        direct.a[i] = value_at(&slope, arc->a, t);
        direct.b[i] = value_at(&slope, arc->b, t);
    }
    for (int k = 1; k < NODES; k++) {
        for (int i = LAST; i >= k; i--) {
            const rigcal_real rise = direct.b[i] - direct.b[i - k];
            if (!(rise > 0)) {
                return;
            }
            direct.a[i] = (direct.a[i] - direct.a[i - 1]) / rise;
        }
    }
    for (int i = 0; i < LAST; i++) { /* the end of an arc is where it can be worst */
        const rigcal_real t = arc->t_low + ((rigcal_real)i + RC(0.5)) * step;
        const rigcal_real v = value_at(&slope, arc->b, t);
        if (!(RC_FABS(direct_at(&direct, v) - value_at(&slope, arc->a, t)) <=
              CROSSING_TOL)) {
            return;
        }
    }
    direct.is_direct = 1;
    *arc = direct;
}

/* ---- arcs ---------------------------------------------------------------- */

void rc_outline_begin(rigcal_outline *outline, int32_t height)
{
    outline->n_arcs = 0;
    outline->height = height;
    outline->is_full = 0;
    outline->row = -1;
    outline->next = outline->n_active = 0;
}

/* The least row from v on: rows of [v0, v1) are those from one to the next. */
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

/* The arc from t0 to t1, where v is v0 and v1. Without a row, it is of no use. */
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

/* Where v turns between t and t + 1/2, its slopes there being of different signs. */
static rigcal_real turning_point(const rigcal_real v[NODES], rigcal_real t, int rises)
{
    rigcal_real slope, from = t, width = RC(0.5);
    for (int i = 0; i < TURN_STEPS; i++) {
        width /= 2;
        (void)value_at(&slope, v, from + width);
        if ((slope > 0) == rises) {
            from += width;
        }
    }
    return from;
}

void rc_outline_add(rigcal_outline *outline, const rigcal_real u[NODES],
                    const rigcal_real v[NODES])
{
    rigcal_real cu[NODES], cv[NODES], slope, t[2] = {0, 0}, ends[2] = {v[0], v[0]};
    fit_even(cu, u);
    fit_even(cv, v);
    (void)value_at(&slope, cv, 0);
    int rises = slope > 0;
    for (int half = 1; half <= 2 * LAST; half++) {
        const rigcal_real next = (rigcal_real)half / 2;
        (void)value_at(&slope, cv, next);
        if ((slope > 0) != rises) {
            t[1] = turning_point(cv, next - RC(0.5), rises);
            ends[1] = value_at(&slope, cv, t[1]);
            add_arc(outline, cu, cv, t, ends);
            t[0] = t[1];
            ends[0] = ends[1];
            rises = !rises;
        }
    }
    t[1] = LAST;
    ends[1] = v[LAST];
    add_arc(outline, cu, cv, t, ends);
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

/* ---- rows ---------------------------------------------------------------- */

/* u where the arc crosses v = row: Newton's method, kept between bounds that close in. */
static rigcal_real crossing(const rigcal_arc *arc, rigcal_real row)
{
    if (arc->is_direct) {
        return direct_at(arc, row);
    }
    rigcal_real low = arc->t_low, high = arc->t_high, slope_u = 0;
    rigcal_real t = low + (high - low) * (row - arc->low) / (arc->high - arc->low);
    for (int i = 0; i < CROSSING_STEPS; i++) {
        rigcal_real slope;
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
        (void)value_at(&slope_u, arc->a, t);
        const rigcal_real moved = RC_FABS((next - t) * slope_u);
        t = next;
        if (!(moved > CROSSING_TOL)) {
            break;
        }
    }
    return value_at(&slope_u, arc->a, t);
}

static int crosses(const rigcal_arc *arc, rigcal_real row)
{
    return arc->low <= row && row < arc->high;
}

/* The arcs that cross the row. */
static void go_to_row(rigcal_outline *outline, int32_t row)
{
    const rigcal_real v = (rigcal_real)row;
    int32_t kept = 0;
    if (row < outline->row) {
        outline->next = outline->n_active = 0;
    }
    for (int32_t i = 0; i < outline->n_active; i++) {
        if (crosses(&outline->arcs[outline->active[i]], v)) {
            outline->active[kept] = outline->active[i];
            kept++;
        }
    }
    for (; outline->next < outline->n_arcs; outline->next++) {
        const uint8_t which = outline->order[outline->next];
        if (outline->arcs[which].low > v) {
            break;
        }
        if (crosses(&outline->arcs[which], v) && kept < RIGCAL_SPANS_ACTIVE) {
            outline->active[kept] = which;
            kept++;
        }
    }
    outline->n_active = kept;
    outline->row = row;
}

/* The least column from u on, u not far from the image. */
static int32_t column_from(rigcal_real u)
{
    const int32_t whole = (u > 0) ? (int32_t)u : 0;
    return whole + ((rigcal_real)whole < u);
}

/* The pixels of [from, to] within the columns, and of the slack beside it where it holds
 * one at all. Spans that touch become one. */
static size_t add_span(rigcal_span spans[], size_t n, rigcal_real from, rigcal_real to,
                       int32_t row, int32_t width)
{
    const rigcal_real end = (rigcal_real)(width - 1);
    if (!(to >= -CROSSING_TOL && from <= end + CROSSING_TOL)) {
        return n;
    }
    const rigcal_real last_u = rc_min(to + SLACK, end);
    if (!((rigcal_real)column_from(from - CROSSING_TOL) <= to + CROSSING_TOL)) {
        return n;
    }
    const int32_t first = column_from(from - SLACK), last = (int32_t)last_u;
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
    rigcal_real at[RIGCAL_SPANS_ACTIVE];
    size_t n = 0;
    go_to_row(outline, row);
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
        n = add_span(spans, n, at[i], at[i + 1], row, width);
    }
    return n;
}
