#include "rc_motion.h"

/* ---- neighbours in time (H1) --------------------------------------------- */

/* The placement before f in its run (by = -1), or after it (by = 1). n: there is none. */
static size_t next_of(const rc_path *path, size_t f, size_t by)
{
    rigcal_real step;
    size_t m = f;
    do {
        m += by; /* before 0 it wraps to more than any n */
        if (m >= path->n) {
            return path->n;
        }
        step = RC_FABS(path->times[m] - path->times[f]);
    } while (!(RC_FABS(path->times[m]) <= RC_COORDINATE_MAX));
    return (step > 0 && step <= path->longest) ? m : path->n;
}

/* ---- the curve (H2) ------------------------------------------------------ */

/* Newton's divided differences with the nodes 0 and t. */
void rc_motion_of(rigcal_motion *motion, const rc_path *path, size_t f)
{
    size_t next[2] = {next_of(path, f, (size_t)-1), next_of(path, f, 1)};
    int n = 0;
    motion->t[0] = 0;
    while (n < path->neighbours) {
        const int side = (next[n % 2] < path->n) ? n % 2 : 1 - n % 2;
        const size_t m = next[side];
        rigcal_real *const c = motion->c[n], *const t = motion->t;
        if (m >= path->n) {
            break;
        }
        next[side] = next_of(path, m, (side > 0) ? 1 : (size_t)-1);
        t[n] = path->times[m] - path->times[f];
        rc_deviation(c, &path->poses[m], &path->poses[f]);
        for (int k = 0; k < 6; k++) {
            c[k] /= t[n];
            for (int before = 0; before < n; before++) {
                c[k] = (c[k] - motion->c[before][k]) / (t[n] - t[before]);
            }
        }
        n++;
    }
    motion->n = n;
}

void rc_motion_at(rigcal_real d[6], rigcal_real xi[6], const rigcal_motion *motion,
                  rigcal_real after)
{
    const int last = motion->n - 1;
    for (int k = 0; k < 6; k++) {
        rigcal_real value = (last >= 0) ? motion->c[last][k] : 0, slope = 0;
        for (int row = last - 1; row >= 0; row--) {
            const rigcal_real from = after - motion->t[row];
            slope = value + from * slope;
            value = motion->c[row][k] + from * value;
        }
        d[k] = after * value;
        xi[k] = value + after * slope;
    }
}

void rc_motion_seen(rigcal_real m[6], const rc_chain *chain, const rigcal_real xi[6])
{
    rc_mat3_mul_vec3(m, chain->R_c, xi);
    rc_mat3_mul_vec3(&m[3], chain->R_c, &xi[3]);
}
