#include "rc_lens.h"

#include <string.h>

/* ---- constants ----------------------------------------------------------- */

/* steps: the most of a proof, which usually takes 1 to 3. The manual states this worst
 * case. */
enum { WALK_MAX = 1024 };

/* part of the way: a shorter step of a proof is rounding. */
#define WALK_LEAST RC_EPS

/* part of the way: a proof that comes this near to the end has reached it. */
#define WALK_LEFT (4 * RC_EPS)

/* steps: the number to find the radius that a lens maps to the wanted one. */
enum { REACH_STEPS = 3 };

/* times that radius: the radius of a proof's disc. Points are near where they were seen. */
#define REACH_MORE RC(1.1)

/* steps: the most of the proof of a disc, which usually takes 1 or 2. */
enum { DISC_STEPS = 8 };

/* steps: the most that Newton's method takes in such a disc. Usually it takes 3. */
enum { NEAR_STEPS = 5 };

/* squared distance in the plane: if Newton's method is this near to the target, its next
 * step is the last. That step misses by the square of this distance or, in float, by
 * rounding. */
#define NEAR_ENOUGH RC_TOL(1e-10, 1e-8)

/* steps: the most of a Newton iteration, which usually takes 3 to 6. The manual states this
 * worst case. */
enum { NEWTON_MAX = 60 };

/* parts: the most of the way to a pixel. Usually 1 is enough; strongly curved lenses take 4
 * to 16. */
enum { STAGES_MAX = 64 };

/* ---- the map ------------------------------------------------------------- */

extern inline int rc_lens_is_fisheye(const rigcal_camera *camera);
extern inline const rigcal_real *rc_camera_numbers(const rigcal_camera *camera,
                                                   size_t offset);

int rc_lens_is_pinhole(const rigcal_camera *camera)
{
    return !rc_lens_is_fisheye(camera) &&
           rc_all_within(rc_camera_numbers(camera, offsetof(rigcal_camera, k1)), 8, 0);
}

/* One more degree of a polynomial by Horner's rule: its value at s, and its derivative. */
static inline void horner(rigcal_real value[2], rigcal_real s, rigcal_real coefficient)
{
    value[1] = value[1] * s + value[0];
    value[0] = value[0] * s + coefficient;
}

/* k4 belongs to D in Brown's lens, and to N in the fisheye. */
static rigcal_real k4_of(const rigcal_camera *camera, int is_in_N)
{
    return (rc_lens_is_fisheye(camera) == is_in_N) ? camera->k4 : 0;
}

static inline int has_denominator(const rigcal_camera *camera)
{
    return !rc_lens_is_fisheye(camera) &&
           RC_FABS(camera->k4) + RC_FABS(camera->k5) + RC_FABS(camera->k6) > 0;
}

enum { N_DEGREE = 4, D_DEGREE = 3, G_DEGREE = 6 };

/* Puts the coefficients of N, else of D, in ascending powers of s. */
RIGCAL_FORCE_INLINE static inline void put_powers(rigcal_real c[N_DEGREE + 1],
                                                  const rigcal_camera *camera, int is_N)
{
    c[0] = 1;
    c[1] = is_N ? camera->k1 : k4_of(camera, 0);
    c[2] = is_N ? camera->k2 : camera->k5;
    c[3] = is_N ? camera->k3 : camera->k6;
    c[4] = is_N ? k4_of(camera, 1) : 0;
}

RC_APART static void powers_of(rigcal_real c[N_DEGREE + 1], const rigcal_camera *camera,
                               int is_N)
{
    put_powers(c, camera, is_N);
}

/* N, else D, at s, with its derivative. For speed it is written out. */
static inline void polynomial_at(rigcal_real value[2], rigcal_real s,
                                 const rigcal_camera *camera, int is_N)
{
    rigcal_real c[N_DEGREE + 1];
    if (RC_FOR_SPEED) {
        put_powers(c, camera, is_N);
        value[0] = c[4];
        value[1] = 0;
        horner(value, s, c[3]);
        horner(value, s, c[2]);
        horner(value, s, c[1]);
        horner(value, s, c[0]);
        return;
    }
    powers_of(c, camera, is_N);
    value[0] = value[1] = 0;
    for (int k = N_DEGREE; k >= 0; k--) {
        horner(value, s, c[k]);
    }
}

/* With d = N / D, d' = (N' - d D') / D and p = d' x + 2 g:
 *   J = (d + 2 g.x) I + p x^T + x p^T */
int rc_lens_map(rigcal_real F[2], rigcal_real J[3], const rigcal_camera *camera,
                const rigcal_real x[2])
{
    const rigcal_real g[2] = {camera->p2, camera->p1};
    const rigcal_real s = x[0] * x[0] + x[1] * x[1];
    rigcal_real N[2];
    polynomial_at(N, s, camera, 1);
    if (!RC_FOR_SPEED || has_denominator(camera)) {
        rigcal_real D[2];
        polynomial_at(D, s, camera, 0);
        if (!(D[0] > 0)) {
            return 0;
        }
        N[0] /= D[0];
        N[1] = (N[1] - N[0] * D[1]) / D[0];
    }
    const rigcal_real d = N[0], slope = N[1];
    const rigcal_real scale = d + 2 * (g[0] * x[0] + g[1] * x[1]);
    const rigcal_real p[2] = {slope * x[0] + 2 * g[0], slope * x[1] + 2 * g[1]};

    F[0] = scale * x[0] + g[0] * s;
    F[1] = scale * x[1] + g[1] * s;
    J[0] = scale + 2 * p[0] * x[0];
    J[1] = p[0] * x[1] + p[1] * x[0];
    J[2] = scale + 2 * p[1] * x[1];
    return 1;
}

RC_APART static int is_positive_definite(const rigcal_real J[3])
{
    return J[0] + J[2] > 0 && J[0] * J[2] - J[1] * J[1] > 0;
}

/* ---- where it can be used ------------------------------------------------ */

/* Lower and upper bound of a polynomial within `half` of `middle`. The other terms of its
 * series there take off, and add, no more than their absolute values. The distance to the
 * true range shrinks as half^2. The series takes the place of b. */
static void polynomial_range(rigcal_real range[2], rigcal_real b[], int degree,
                             rigcal_real middle, rigcal_real half)
{
    rigcal_real power = half, reach = 0;
    for (int i = 0; i <= degree; i++) { /* powers of s - middle: b[i] is final */
        for (int j = degree - 1; j >= i; j--) {
            b[j] += middle * b[j + 1];
        }
        if (i > 0) {
            reach += power * RC_FABS(b[i]);
            power *= half;
        }
    }
    range[0] = b[0] - reach;
    range[1] = b[0] + reach;
}

/* G = (N + 2 s N') D - 2 s N D': d/dr (r N / D) times D^2. */
RC_APART_FAST static void radial_slope(rigcal_real G[G_DEGREE + 1],
                                       const rigcal_camera *camera)
{
    rigcal_real N[N_DEGREE + 1], D[N_DEGREE + 1];
    powers_of(N, camera, 1);
    powers_of(D, camera, 0);
    for (int i = 0; i <= G_DEGREE; i++) {
        G[i] = 0;
    }
    for (int i = 0; i <= N_DEGREE; i++) {
        for (int j = 0; j <= D_DEGREE && i + j <= G_DEGREE; j++) {
            G[i + j] += N[i] * D[j] * (rigcal_real)(1 + 2 * (i - j));
        }
    }
}

/* The least possible N / D, if N is at least `low` and D > 0 lies between its bounds. */
RC_APART static rigcal_real least_quotient(rigcal_real low, const rigcal_real D[2])
{
    return low / ((low > 0) ? D[1] : D[0]);
}

/* A direction e from the axis, to r^2 = `end`. a r and b r are given: a = g.e, b = g.e',
 * with e' normal to e. */
typedef struct {
    const rigcal_camera *camera;
    rigcal_real G[G_DEGREE + 1], ar, br, end;
} direction;

/* In the basis (e, e') the Jacobian is
 *
 *     [ G / D^2 + 6 a r     2 b r   ]
 *     [     2 b r       N / D + 2 a r]
 *
 * It is positive definite on all of r^2 in [from, from + length] when the bounds of G, N
 * and D there make it so. */
RC_APART_FAST static int is_usable_between(const direction *e, rigcal_real from,
                                           rigcal_real length)
{
    const rigcal_real half = length / 2, middle = from + half;
    rigcal_real slope[2], N[2], D[2], b[G_DEGREE + 1];
    powers_of(b, e->camera, 0);
    polynomial_range(D, b, D_DEGREE, middle, half);
    memcpy(b, e->G, sizeof b);
    polynomial_range(slope, b, G_DEGREE, middle, half);
    if (!(D[0] > 0)) {
        return 0;
    }
    if (!(RC_FABS(e->ar) > 0 || RC_FABS(e->br) > 0)) {
        return slope[0] > 0; /* then N / D > 0 too: r N / D rises from 0 */
    }
    powers_of(b, e->camera, 1);
    polynomial_range(N, b, N_DEGREE, middle, half);
    const rigcal_real far = (from + length) / e->end;
    const rigcal_real ar_low = e->ar * RC_SQRT((e->ar > 0) ? from / e->end : far);
    const rigcal_real along = least_quotient(least_quotient(slope[0], D), D) + 6 * ar_low;
    const rigcal_real across = least_quotient(N[0], D) + 2 * ar_low;
    return along > 0 && across > 0 && along * across > 4 * e->br * e->br * far;
}

RC_APART_FAST static int is_definite_at(const rigcal_camera *camera, const rigcal_real x[2],
                                        rigcal_real part)
{
    const rigcal_real at[2] = {part * x[0], part * x[1]};
    rigcal_real F[2], J[3];
    return rc_lens_map(F, J, camera, at) && is_positive_definite(J);
}

/* Walks from the axis to x. A step is halved until the bounds decide, or until its end is
 * seen to be beyond a turning point. It is doubled after each success. */
RC_APART_FAST static int walk_to(const rigcal_camera *camera, const rigcal_real x[2])
{
    direction e;
    e.camera = camera;
    e.end = x[0] * x[0] + x[1] * x[1];
    e.ar = camera->p2 * x[0] + camera->p1 * x[1];
    e.br = camera->p1 * x[0] - camera->p2 * x[1];
    radial_slope(e.G, camera);
    rigcal_real from = 0, length = e.end;
    for (int i = 0; i < WALK_MAX && length > WALK_LEAST * e.end; i++) {
        if (is_usable_between(&e, from, length)) {
            from += length;
            length = rc_min(2 * length, e.end - from);
        } else if (is_definite_at(camera, x, RC_SQRT((from + length) / e.end))) {
            length /= 2;
        } else {
            return 0;
        }
    }
    return rc_is_finite(e.end) && e.end - from <= WALK_LEFT * e.end;
}

int rc_lens_is_usable(const rigcal_camera *camera, const rigcal_real x[2])
{
    return rc_lens_is_pinhole(camera) ? rc_is_finite(x[0] * x[0] + x[1] * x[1])
                                      : walk_to(camera, x);
}

#if RIGCAL_FOR_SPEED
/* (B6) A disc about the axis holds the way from the axis to each of its points. In any
 * direction e |a| and |b| are at most |g|, so the worst of both at once serves for all. */
rigcal_real rc_lens_proved(const rigcal_camera *camera, rigcal_real reach)
{
    RIGCAL_ASSERT(reach >= 0 && !rc_lens_is_fisheye(camera));
    const rigcal_real g = RC_SQRT(camera->p1 * camera->p1 + camera->p2 * camera->p2);
    rigcal_real r = reach, F[2], J[3], from = 0;
    direction e;
    for (int i = 0; i < REACH_STEPS; i++) { /* F is at least `low` from the axis */
        const rigcal_real x[2] = {r, 0};
        const rigcal_real low =
            rc_lens_map(F, J, camera, x) ? F[0] - 3 * (camera->p2 + g) * r * r : 0;
        r *= rc_min(reach / rc_max(low, reach / 2), 2);
    }
    r *= REACH_MORE;
    e.end = r * r;
    e.ar = -g * r;
    e.br = g * r;
    e.camera = camera;
    radial_slope(e.G, camera);
    rigcal_real length = e.end;
    for (int i = 0; i < DISC_STEPS && from < e.end; i++) {
        if (is_usable_between(&e, from, length)) {
            from += length;
            length = e.end - from;
        } else {
            length /= 2;
        }
    }
    return from;
}

int rc_lens_invert_within(rigcal_real x[2], const rigcal_camera *camera,
                          const rigcal_real target[2], rigcal_real proved2)
{
    x[0] = target[0];
    x[1] = target[1];
    for (int i = 0; i < NEAR_STEPS && x[0] * x[0] + x[1] * x[1] <= proved2; i++) {
        rigcal_real F[2], J[3];
        if (!rc_lens_map(F, J, camera, x)) {
            return 0;
        }
        const rigcal_real u = target[0] - F[0], v = target[1] - F[1];
        const rigcal_real by_det = 1 / (J[0] * J[2] - J[1] * J[1]);
        x[0] += (J[2] * u - J[1] * v) * by_det;
        x[1] += (J[0] * v - J[1] * u) * by_det;
        if (u * u + v * v <= NEAR_ENOUGH) {
            return x[0] * x[0] + x[1] * x[1] <= proved2;
        }
    }
    return 0;
}
#endif
/* ---- its inverse --------------------------------------------------------- */

/* Newton's method for F(x) = target, from an x where J is positive definite. A step is
 * halved if it leaves such places or does not bring F nearer. It ends when no step helps
 * any more, and returns |F(x) - target| there. */
RC_APART_FAST static rigcal_real solve_from(rigcal_real x[2], const rigcal_camera *camera,
                                            const rigcal_real target[2])
{
    rigcal_real F[2], J[3], step[2] = {0, 0}, miss = RC_MAX;
    rigcal_real at[2] = {x[0], x[1]};
    for (int i = 0; i < NEWTON_MAX; i++) {
        rigcal_real gap[2] = {0, 0}, next = RC_MAX;
        if (rc_lens_map(F, J, camera, at) && is_positive_definite(J)) {
            gap[0] = target[0] - F[0];
            gap[1] = target[1] - F[1];
            next = RC_SQRT(gap[0] * gap[0] + gap[1] * gap[1]);
        }
        if (next < miss) {
            const rigcal_real det = J[0] * J[2] - J[1] * J[1];
            miss = next;
            x[0] = at[0];
            x[1] = at[1];
            step[0] = (J[2] * gap[0] - J[1] * gap[1]) / det;
            step[1] = (J[0] * gap[1] - J[1] * gap[0]) / det;
        } else {
            step[0] /= 2;
            step[1] /= 2;
        }
        at[0] = x[0] + step[0];
        at[1] = x[1] + step[1];
        if (!(RC_FABS(at[0] - x[0]) > 0 || RC_FABS(at[1] - x[1]) > 0)) {
            break;
        }
    }
    return miss;
}

/* The answer is followed from the axis in `stages` equal parts of the target. One part
 * nearly always serves. More keep the method from jumping across a strongly curved lens. */
int rc_lens_invert(rigcal_real x[2], const rigcal_camera *camera,
                   const rigcal_real target[2], rigcal_real tolerance)
{
    RIGCAL_ASSERT(tolerance >= 0);
    for (int stages = 1; stages <= STAGES_MAX; stages *= 2) {
        rigcal_real miss = 0;
        x[0] = x[1] = 0;
        for (int i = 1; i <= stages && miss <= tolerance; i++) {
            const rigcal_real part = (rigcal_real)i / (rigcal_real)stages;
            const rigcal_real aim[2] = {part * target[0], part * target[1]};
            miss = solve_from(x, camera, aim);
        }
        if (miss <= tolerance && rc_lens_is_usable(camera, x)) {
            return 1;
        }
    }
    return 0;
}
