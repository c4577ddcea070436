#include "rc_p3p.h"

/* ---- constants ----------------------------------------------------------- */

/* part of the longest side squared: twice the area of points on a line is no more than
 * this. Rounding of the coordinates makes it, and a far origin enlarges it. */
#define LINE_TOL (64 * RC_EPS)

/* 1: rays nearer together than this are one, to rounding. */
#define RAY_TOL (16 * RC_EPS)

/* longest sides squared: a complex pair is a double root that noise has lifted, if its real
 * part breaks the equations by no more than this. */
#define LIFTED RC(0.01)

/* longest sides: a depth times h of no more than this is zero, to rounding. */
#define DEPTH_MIN (16 * RC_EPS)

/* 1: the least cube that the root of the pencil is computed from. It moves the root by
 * RC_EPS at most. */
#define CUBE_LEAST (RC_EPS * RC_EPS * RC_EPS)

/* part of the root: a step of no more than this is rounding. */
#define ROOT_ROUNDING (4 * RC_EPS)

/* part of the next two coefficients: the leading one of a cubic is zero if it is no more
 * than this. A root of up to 1 / this is scaled by this, a power of 2, if its square is
 * beyond 1 / this: squares of sides contain its eighth power, which must not overflow. */
#define LEAD_LEAST RC_EPS

/* Point 0 of the triangle is opposite to the longest side, whose length is 1. The unknowns
 * are v = (D, p, q), for depths s0 = D / h, s1 = s0 + p, s2 = s0 + q, and h is the longest
 * chord between the rays. The rows of SIDE take v to the differences of depths along the
 * sides 01, 02, 12. */
static const rigcal_real SIDE[3][3] = {{0, 1, 0}, {0, 0, 1}, {0, 1, -1}};

/* Side k goes from point FROM[k] to point TO[k]. */
static const uint8_t FROM[3] = {0, 0, 1}, TO[3] = {1, 2, 2};

static const uint8_t CYCLE[5] = {0, 1, 2, 0, 1};

/* ---- the equations ------------------------------------------------------- */

/* (D1) Computes the squares of the sides that v makes, and the three depths times h. */
static void sides(rigcal_real f[3], rigcal_real s[3], const rigcal_p3p *T,
                  const rigcal_real v[3])
{
    const rigcal_real along[3] = {v[1], v[2], v[1] - v[2]}; /* SIDE v */
    s[0] = v[0];
    s[1] = v[0] + T->h * v[1];
    s[2] = v[0] + T->h * v[2];
    for (int k = 0; k < 3; k++) {
        f[k] = along[k] * along[k] + T->chord2[k] * s[FROM[k]] * s[TO[k]];
    }
}

/* ---- the pencil of conics ------------------------------------------------ */

/* Computes the symmetric M with f[k] = v^T M v. */
static void form(rigcal_real M[9], const rigcal_p3p *T, int k)
{
    const rigcal_real depth[9] = {1, 0, 0, 1, T->h, 0, 1, 0, T->h};
    const rigcal_real *const from = &depth[3 * FROM[k]];
    const rigcal_real *const to = &depth[3 * TO[k]];
    const rigcal_real half = T->chord2[k] / 2;
    for (int i = 0; i < 3; i++) {
        rc_vec3_combine(&M[3 * i], half * from[i], to, half * to[i], from);
        rc_vec3_add_scaled(&M[3 * i], SIDE[k][i], SIDE[k]);
    }
}

/* A += s B */
static void add_scaled(rigcal_real A[9], rigcal_real s, const rigcal_real B[9])
{
    for (int k = 0; k < 9; k++) {
        A[k] += s * B[k];
    }
}

/* Computes the conics on which the sides 01 and 02 have the right ratio to 12. */
static void conics(rigcal_real *const C[2], const rigcal_p3p *T)
{
    rigcal_real M12[9];
    form(M12, T, 2);
    for (int k = 0; k < 2; k++) {
        form(C[k], T, k);
        add_scaled(C[k], -T->squared[k], M12);
    }
}

/* The trace of the product of symmetric matrices. */
static rigcal_real trace_of(const rigcal_real A[9], const rigcal_real C[9])
{
    return rc_vec3_dot(&A[0], &C[0]) + rc_vec3_dot(&A[3], &C[3]) +
           rc_vec3_dot(&A[6], &C[6]);
}

/* Computes det(C[0] + x C[1]) by powers of x. */
static void pencil_cubic(rigcal_real c[4], rigcal_real *const C[2])
{
    rigcal_real A[9];
    for (int k = 0; k < 2; k++) {
        c[3 * k] = rc_mat3_cofactors(A, C[k]);
        c[1 + k] = trace_of(A, C[1 - k]);
    }
}

/* The negative real root of y^3 - 3 r2 y + g, g >= 0, which lies apart from the others, or
 * alone. Newton's method starts from -2 r if the root is not beyond that. Else it starts
 * from g^(5/16) in place of the cube root. The curve is concave there: from the second step
 * on, y comes from beyond the root, each step takes a third of the way to it or more, and
 * none passes it. Usually there are 3 to 6 steps. The least g keeps the start within
 * RC_EPS^(-1/16) cube roots: there are at most 16 steps in double and 8 in float, tried for
 * ratios of r2^3 to g from 0 to both infinities. */
static rigcal_real root_apart(rigcal_real r2, rigcal_real g)
{
    g = rc_max(g, CUBE_LEAST);
    rigcal_real y = -2 * RC_SQRT(rc_max(r2, 0)), step;
    if (y * (y * y - 3 * r2) + g > 0) {
        y = rc_min(y, -RC_SQRT(RC_SQRT(g * RC_SQRT(RC_SQRT(g)))));
    }
    do {
        step = (y * (y * y - 3 * r2) + g) / (3 * (y * y - r2));
        y -= step;
    } while (RC_FABS(step) > -ROOT_ROUNDING * y);
    return y;
}

/* The degenerate conic m[0] C0 + m[1] C1 that lies apart from the other two. Those two
 * merge where two solutions do. If C0 and C1 are both degenerate, it is the third. */
static void pencil_root(rigcal_real m[2], const rigcal_real c[4])
{
    const int swapped = RC_FABS(c[0]) > RC_FABS(c[3]), down = swapped ? 1 : -1;
    const rigcal_real *const lead = swapped ? &c[0] : &c[3];
    const rigcal_real b3 = lead[0], b2 = lead[down], b1 = lead[2 * down];
    const rigcal_real b0 = lead[3 * down];
    rigcal_real one = b2, x = -b1;
    if (RC_FABS(b3) > LEAD_LEAST * (RC_FABS(b1) + RC_FABS(b2))) {
        const rigcal_real by_lead = 1 / b3, k = b2 * by_lead / 3;
        const rigcal_real r2 = k * k - b1 * by_lead / 3;
        const rigcal_real g = k * (2 * k * k - b1 * by_lead) + b0 * by_lead;
        const rigcal_real y = root_apart(r2, rc_max(g, -g));
        x = ((g < 0) ? -y : y) - k;
        one = (x * x * LEAD_LEAST > 1) ? LEAD_LEAST : 1;
        x *= one;
    }
    m[swapped] = one;
    m[!swapped] = x;
}

/* Which of n numbers is the largest, whatever their signs. */
static int largest_of(const rigcal_real x[], int n)
{
    int at = 0;
    for (int k = 1; k < n; k++) {
        at = (RC_FABS(x[k]) > RC_FABS(x[at])) ? k : at;
    }
    return at;
}

/* S = [c]x */
RC_APART static void skew(rigcal_real S[9], const rigcal_real c[3])
{
    S[0] = S[4] = S[8] = 0;
    S[1] = -c[2];
    S[2] = c[1];
    S[3] = c[2];
    S[5] = -c[0];
    S[6] = -c[1];
    S[7] = c[0];
}

/* Splits a conic of rank 2 into two lines: D = l m^T + m l^T. Their crossing c is the root
 * of -adj(D), and N = D + [c]x = 2 l m^T takes the place of D. Returns 0 if the lines are
 * complex. */
static int split(rigcal_real l[3], rigcal_real m[3], rigcal_real D[9])
{
    rigcal_real A[9], c[3];
    int at = 0;
    (void)rc_mat3_cofactors(A, D);
    for (int k = 4; k < 9; k += 4) {
        at = (A[k] < A[at]) ? k : at;
    }
    if (!(A[at] < 0)) {
        return 0;
    }
    const rigcal_real *const row = &A[at - at / 4];
    rc_vec3_scale(c, 1 / RC_SQRT(-A[at]), row);
    skew(A, c);
    add_scaled(D, 1, A);
    at = largest_of(D, 9);
    const int first = (at < 3) ? 0 : (at < 6) ? 3 : 6; /* start of its row */
    rc_vec3_copy(l, &D[first]);
    for (int k = 0; k < 3; k++) {
        m[k] = D[at - first + 3 * k];
    }
    return 1;
}

/* Finds where the line l.v = 0 crosses the conic C, up to scale. Returns 2, or 1 for the
 * real part of a complex pair. v = x a + y b. The rows a and b of [l]x leave v its digits:
 * the coordinate of the largest of l follows from the other two. */
RC_APART static uint8_t cross_line(rigcal_real v[2][3], const rigcal_real l[3],
                                   const rigcal_real C[9])
{
    const int k = largest_of(l, 3);
    rigcal_real S[9], Ca[3], Cb[3];
    const rigcal_real *const a = &S[3 * CYCLE[k + 1]];
    const rigcal_real *const b = &S[3 * CYCLE[k + 2]];
    skew(S, l);
    rc_mat3_mul_vec3(Ca, C, a);
    rc_mat3_mul_vec3(Cb, C, b);
    const rigcal_real A = rc_vec3_dot(a, Ca), B = rc_vec3_dot(a, Cb);
    const rigcal_real G = rc_vec3_dot(b, Cb);
    const rigcal_real discriminant = B * B - A * G;
    const rigcal_real root = RC_SQRT(rc_max(discriminant, 0));
    const rigcal_real sum = (B < 0) ? root - B : -B - root;
    /* A x^2 + 2 B x y + G y^2 = 0 has the roots (sum : A) and (G : sum). */
    const int is_one = !(discriminant > 0);
    rc_vec3_combine(v[0], sum, a, A, b);
    rc_vec3_combine(v[1], G, a, sum, b);
    if (is_one && RC_FABS(A) < RC_FABS(G)) {
        rc_vec3_copy(v[0], v[1]);
    }
    return is_one ? 1 : 2;
}

/* ---- poses --------------------------------------------------------------- */

/* Computes the depths times h of v, scaled to the size of the triangle, in front. Returns 0
 * if v does not make the sides, or a point is not in front. */
static int depths_of(rigcal_real s[3], const rigcal_real v[3], const rigcal_p3p *T)
{
    rigcal_real f[3], wrong = 0;
    sides(f, s, T, v);
    const rigcal_real squared =
        (T->squared[0] + T->squared[1] + T->squared[2]) / (f[0] + f[1] + f[2]);
    if (!(squared > 0 && squared <= RC_MAX)) {
        return 0;
    }
    const rigcal_real scale = (s[0] < 0) ? -RC_SQRT(squared) : RC_SQRT(squared);
    int is_in_front = 1;
    for (int k = 0; k < 3; k++) {
        s[k] *= scale;
        is_in_front = is_in_front && s[k] > DEPTH_MIN;
        wrong = rc_max(wrong, RC_FABS(squared * f[k] - T->squared[k]));
    }
    return is_in_front && wrong <= LIFTED;
}

/* Makes the axes of the triangle 0, u, w, in rows: along w - u, across it, and normal to
 * it. u x w of a thin triangle is not normal to rounding, so the last row is computed anew.
 * Returns 0 if |u x w| is no more than `least`. */
static int axes_of(rigcal_real F[9], const rigcal_real u[3], const rigcal_real w[3],
                   rigcal_real least)
{
    rc_vec3_sub(&F[0], w, u);
    rc_vec3_cross(&F[6], u, w);
    if (!(rc_vec3_norm(&F[6]) > least)) {
        return 0;
    }
    rc_vec3_cross(&F[3], &F[6], &F[0]);
    rc_vec3_scale(&F[0], 1 / rc_vec3_norm(&F[0]), &F[0]);
    rc_vec3_scale(&F[3], 1 / rc_vec3_norm(&F[3]), &F[3]);
    rc_vec3_cross(&F[6], &F[0], &F[3]);
    return 1;
}

/* Prepares the problem for the equations. Returns 0 if the points are on a line or rays
 * coincide. */
RC_APART_FAST static int prepare(rigcal_p3p *P, const rigcal_real ray[3][3])
{
    const rigcal_real(*const x)[3] = (const rigcal_real(*)[3])P->work.x;
    rigcal_real longest = -1, d[3], w[2][3];
    int top = 0;
    for (int k = 0; k < 3; k++) { /* the side opposite to k */
        rc_vec3_sub(d, x[CYCLE[k + 2]], x[CYCLE[k + 1]]);
        const rigcal_real squared = rc_vec3_dot(d, d);
        top = (squared > longest) ? k : top;
        longest = rc_max(squared, longest);
    }
    P->size = RC_SQRT(longest);
    if (!(P->size > 0)) {
        return 0;
    }
    const rigcal_real by_size = 1 / P->size;
    const rigcal_real *const point = x[top];
    P->first = (uint8_t)top;
    rigcal_real h2 = 0;
    int is_apart = 1;
    for (int k = 0; k < 3; k++) {
        rc_vec3_sub(d, ray[CYCLE[top + TO[k]]], ray[CYCLE[top + FROM[k]]]);
        P->chord2[k] = rc_vec3_dot(d, d);
        h2 = rc_max(h2, P->chord2[k]);
        is_apart = is_apart && P->chord2[k] > RAY_TOL * RAY_TOL;
    }
    for (int k = 0; k < 2; k++) {
        rc_vec3_sub(d, x[CYCLE[top + 1 + k]], point);
        rc_vec3_scale(w[k], by_size, d);
        P->squared[k] = rc_vec3_dot(w[k], w[k]);
    }
    P->squared[2] = 1;
    rc_vec3_combine(P->middle, P->size / 3, w[0], P->size / 3, w[1]);
    rc_vec3_add(P->middle, point);
    P->h = RC_SQRT(h2);
    rc_vec3_scale(P->chord2, 1 / h2, P->chord2);
    return is_apart && axes_of(P->frame, w[0], w[1],
                               LINE_TOL * (1 + rc_vec3_max_abs(P->middle) * by_size));
}

/* Writes the pose of a solution with depths s / h. */
RC_APART_FAST static int write_pose(rigcal_transform *cam_from_points, const rigcal_p3p *P,
                                    const rigcal_real ray[3][3], const rigcal_real s[3])
{
    const rigcal_real by_h = 1 / P->h;
    rigcal_real first[3], w[2][3], F[9], middle[3], turned[3];
    rc_vec3_scale(first, s[0] * by_h, ray[P->first]);
    for (int k = 0; k < 2; k++) {
        rc_vec3_combine(w[k], s[1 + k] * by_h, ray[CYCLE[P->first + 1 + k]], -1, first);
    }
    if (!axes_of(F, w[0], w[1], 0)) {
        return 0;
    }
    for (int row = 0; row < 3; row++) {
        const rigcal_real column[3] = {F[row], F[3 + row], F[6 + row]};
        rc_mat3_tmul_vec3(&cam_from_points->R[3 * row], P->frame, column);
    }
    rc_mat3_mul_vec3(turned, cam_from_points->R, P->middle);
    rc_vec3_combine(middle, RC(1) / 3, w[0], RC(1) / 3, w[1]);
    rc_vec3_add(middle, first);
    rc_vec3_combine(cam_from_points->t, P->size, middle, -1, turned);
    return 1;
}

/* Finds the two lines on which the solutions lie, at most two on each, and a conic that
 * crosses the lines there. Keeps the second line. Returns 0 if there are no lines. */
RC_APART_FAST static int find_lines(rigcal_real first[3], rigcal_p3p *P)
{
    rigcal_real *const conic = P->work.conic;
    rigcal_real C0[9], c[4], m[2];
    rigcal_real *const C[2] = {C0, conic};
    conics(C, P);
    pencil_cubic(c, C);
    pencil_root(m, c);
    for (int k = 0; k < 9; k++) {
        const rigcal_real apart = m[0] * C0[k] + m[1] * conic[k];
        conic[k] = m[0] * conic[k] - m[1] * C0[k];
        C0[k] = apart;
    }
    return split(first, P->line, C0);
}

static void cross(rigcal_p3p *P, const rigcal_real line[3])
{
    P->crossings = cross_line(P->v, line, P->work.conic);
    P->next = 0;
}

int rc_p3p_begin(rigcal_p3p *P, const rigcal_real ray[3][3])
{
    rigcal_real first[3];
    if (!prepare(P, ray) || !find_lines(first, P)) {
        return 0;
    }
    cross(P, first);
    P->is_second = 0;
    return 1;
}

int rc_p3p_next(rigcal_transform *cam_from_points, rigcal_p3p *P,
                const rigcal_real ray[3][3])
{
    rigcal_real s[3];
    for (;;) {
        while (P->next < P->crossings) {
            if (depths_of(s, P->v[P->next++], P) &&
                write_pose(cam_from_points, P, ray, s)) {
                return 1;
            }
        }
        if (P->is_second) {
            return 0;
        }
        cross(P, P->line);
        P->is_second = 1;
    }
}

int rc_p3p(rigcal_transform cam_from_points[RC_P3P_MAX], const rigcal_real x[3][3],
           const rigcal_real ray[3][3])
{
    rigcal_p3p P;
    int count = 0;
    for (int k = 0; k < 3; k++) {
        rc_vec3_copy(P.work.x[k], x[k]);
    }
    if (rc_p3p_begin(&P, ray)) {
        while (count < RC_P3P_MAX && rc_p3p_next(&cam_from_points[count], &P, ray)) {
            count++;
        }
    }
    return count;
}
