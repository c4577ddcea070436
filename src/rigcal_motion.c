#include "rc_motion.h"

/* ---- constants ----------------------------------------------------------- */

/* terms: of the series of the sine and cosine of half a turn, at most. They are exact to
 * rounding up to half a circle. */
enum { SERIES_TERMS = 11 };

/* of 1: a term of that series that is less is rounding. */
#define TERM_LEAST (RC_EPS / 4)

/* ---- neighbours in time (H1) --------------------------------------------- */

static int is_on_path(const rc_path *path, size_t f)
{
    return (path->count == NULL || path->count[f] > 0) &&
           RC_FABS(path->times[f]) <= RC_COORDINATE_MAX;
}

/* The placement before f in its run (side -1), or after it (1); n: there is none. */
static size_t next_of(const rc_path *path, size_t f, int side)
{
    size_t m = f;
    do {
        m = (side > 0) ? m + 1 : m - 1; /* before 0 there is more than any n */
        if (m >= path->n) {
            return path->n;
        }
    } while (!is_on_path(path, m));
    const rigcal_real step = RC_FABS(path->times[m] - path->times[f]);
    return (step > 0 && step <= path->longest) ? m : path->n;
}

/* The next neighbour of a side, or n. */
typedef struct {
    size_t at[2];
} next_two;

static size_t neighbour_of(next_two *next, const rc_path *path, int k)
{
    const int is_after = k % 2;
    const int side = (next->at[is_after] < path->n) ? is_after : 1 - is_after;
    const size_t m = next->at[side];
    if (m < path->n) {
        next->at[side] = next_of(path, m, (side > 0) ? 1 : -1);
    }
    return m;
}

/* ---- the curve (H2) ------------------------------------------------------ */

/* Newton's divided differences by the nodes 0 and t, where the curve is 0 and c. */
static void divide(rc_motion *motion, const rigcal_real t[])
{
    for (int row = 0; row < motion->n; row++) {
        for (int k = 0; k < 6; k++) {
            rigcal_real x = motion->c[row][k] / t[row];
            for (int before = 0; before < row; before++) {
                x = (x - motion->c[before][k]) / (t[row] - t[before]);
            }
            motion->c[row][k] = x;
        }
    }
}

/* From them, by after (c0 + (after - t0) (c1 + (after - t1) (...))), to powers. */
static void expand(rc_motion *motion, const rigcal_real t[])
{
    for (int node = motion->n - 2; node >= 0; node--) {
        for (int row = node; row < motion->n - 1; row++) {
            for (int k = 0; k < 6; k++) {
                motion->c[row][k] -= t[node] * motion->c[row + 1][k];
            }
        }
    }
}

void rc_motion_of(rc_motion *motion, const rc_path *path, size_t f)
{
    rigcal_real t[RC_MOTION_MOST];
    motion->n = 0;
    motion->nearest = 0;
    if (!is_on_path(path, f)) {
        return;
    }
    next_two next = {{next_of(path, f, -1), next_of(path, f, 1)}};
    while (motion->n < path->neighbours) {
        const size_t m = neighbour_of(&next, path, motion->n);
        if (m >= path->n) {
            break;
        }
        t[motion->n] = path->times[m] - path->times[f];
        rc_deviation(motion->c[motion->n++], &path->poses[m], &path->poses[f]);
    }
    if (motion->n > 0) {
        motion->nearest = t[0];
    }
    divide(motion, t);
    expand(motion, t);
}

void rc_motion_at(rigcal_real d[6], rigcal_real xi[6], const rc_motion *motion,
                  rigcal_real after)
{
    rc_clear(d, 6);
    for (int row = motion->n - 1; row >= 0; row--) {
        for (int k = 0; k < 6; k++) {
            d[k] = after * (d[k] + motion->c[row][k]);
        }
    }
    if (xi == NULL) {
        return;
    }
    rc_clear(xi, 6);
    for (int row = motion->n - 1; row >= 0; row--) {
        for (int k = 0; k < 6; k++) {
            xi[k] = after * xi[k] + (rigcal_real)(row + 1) * motion->c[row][k];
        }
    }
}

/* The turn that rc_transform_move makes of w is by 2 arctan(|w| / 2): w is made longer by
 * tan(x) / x, x half the turn. */
void rc_motion_move(rigcal_transform *pose, const rigcal_real d[6])
{
    rigcal_real longer[6];
    const rigcal_real xx = rc_vec3_dot(d, d) / 4;
    rigcal_real term = 1, sine_by_x = 1, cosine = 1;
    for (int k = 1; k <= SERIES_TERMS && RC_FABS(term) > TERM_LEAST; k++) {
        const rigcal_real even = (rigcal_real)(2 * k);
        term *= -xx / (even * (even - 1));
        cosine += term;
        sine_by_x += term / (even + 1);
    }
    rc_vec3_scale(longer, sine_by_x / cosine, d);
    rc_vec3_copy(&longer[3], &d[3]);
    rc_transform_move(pose, longer);
}

void rc_motion_seen(rigcal_real m[6], const rc_chain *chain, const rigcal_real xi[6])
{
    rc_mat3_mul_vec3(m, chain->R_c, xi);
    rc_mat3_mul_vec3(&m[3], chain->R_c, &xi[3]);
}
