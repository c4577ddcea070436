#include "rc_p3p.h"

/* Twice the area of the points, over the square of the longest side, below which
 * they are on a line; in roundings of the coordinates, which a far origin enlarges. */
#define LINE_TOL (64 * RC_EPS)

/* Rays nearer together than so many roundings are one. */
#define RAY_TOL (16 * RC_EPS)

/* A complex pair counts as a double root that noise has lifted when its real part
 * breaks the equations by no more than this, in squares of the longest side. */
#define LIFTED RC(0.01)

/* A depth times h of no more than this, in longest sides, is zero. */
#define DEPTH_MIN (16 * RC_EPS)

/* Newton steps to the root of the pencil, from a start that bounds it. */
enum { ROOT_STEPS = 12 };

/* The triangle, point 0 opposite to the longest side, which is 1. The unknowns are
 * v = (D, p, q), for depths s0 = D / h, s1 = s0 + p, s2 = s0 + q. */
typedef struct {
    rigcal_real a[3]; /* squares of the sides 01, 02, 12; the last is 1 */
    rigcal_real e[3]; /* of the chords between the rays, over h^2 */
    rigcal_real h;    /* longest chord */
} triangle;

/* ---- the equations ------------------------------------------------------- */

/* (D1) Squares of the sides that v makes, and the three depths times h. */
static void sides(rigcal_real f[3], rigcal_real s[3], const triangle *T,
                  const rigcal_real v[3])
{
    s[0] = v[0];
    s[1] = v[0] + T->h * v[1];
    s[2] = v[0] + T->h * v[2];
    f[0] = v[1] * v[1] + T->e[0] * s[0] * s[1];
    f[1] = v[2] * v[2] + T->e[1] * s[0] * s[2];
    f[2] = (v[1] - v[2]) * (v[1] - v[2]) + T->e[2] * s[1] * s[2];
}

/* ---- the pencil of conics ------------------------------------------------ */

/* Symmetric matrices are held as 00, 01, 02, 11, 12, 22. The conics on which the
 * sides 01 and 02 have the right ratio to 12. */
static void conics(rigcal_real C0[6], rigcal_real C1[6], const triangle *T)
{
    const rigcal_real half = T->h / 2;
    const rigcal_real M12[6] = {T->e[2], half * T->e[2], half * T->e[2], 1,
                                half * T->h * T->e[2] - 1, 1};
    for (int k = 0; k < 6; k++) {
        C0[k] = -T->a[0] * M12[k];
        C1[k] = -T->a[1] * M12[k];
    }
    C0[0] += T->e[0];
    C0[1] += half * T->e[0];
    C0[3] += 1;
    C1[0] += T->e[1];
    C1[2] += half * T->e[1];
    C1[5] += 1;
}

static void adjugate(rigcal_real A[6], const rigcal_real C[6])
{
    A[0] = C[3] * C[5] - C[4] * C[4];
    A[1] = C[2] * C[4] - C[1] * C[5];
    A[2] = C[1] * C[4] - C[2] * C[3];
    A[3] = C[0] * C[5] - C[2] * C[2];
    A[4] = C[1] * C[2] - C[0] * C[4];
    A[5] = C[0] * C[3] - C[1] * C[1];
}

/* Trace of the product. */
static rigcal_real trace_of(const rigcal_real A[6], const rigcal_real C[6])
{
    return A[0] * C[0] + A[3] * C[3] + A[5] * C[5] +
           2 * (A[1] * C[1] + A[2] * C[2] + A[4] * C[4]);
}

/* det(C0 + x C1) by powers of x. */
static void pencil_cubic(rigcal_real c[4], const rigcal_real C0[6],
                         const rigcal_real C1[6])
{
    rigcal_real A[6];
    adjugate(A, C0);
    c[0] = trace_of(A, C0) / 3;
    c[1] = trace_of(A, C1);
    adjugate(A, C1);
    c[2] = trace_of(A, C0);
    c[3] = trace_of(A, C1) / 3;
}

/* The real root of y^3 - 3 r2 y + g, g >= 0, that lies apart from the others, or
 * alone: the negative one. From -2 r, when it is beyond, from a bound of its own:
 * g^(5/16) for the cube root. */
static rigcal_real root_apart(rigcal_real r2, rigcal_real g)
{
    rigcal_real y = -2 * RC_SQRT(rc_max(r2, 0));
    if (y * (y * y - 3 * r2) + g > 0) {
        y = rc_min(y, -RC_SQRT(RC_SQRT(g * RC_SQRT(RC_SQRT(g)))));
    }
    for (int i = 0; i < ROOT_STEPS; i++) {
        const rigcal_real slope = 3 * (y * y - r2);
        if (!(slope > 0)) {
            break;
        }
        const rigcal_real step = (y * (y * y - 3 * r2) + g) / slope;
        y -= step;
        if (RC_FABS(step) <= -4 * RC_EPS * y) {
            break;
        }
    }
    return y;
}

/* The degenerate conic m[0] C0 + m[1] C1 apart from the other two: where two
 * solutions merge, those two do. With C0 and C1 both degenerate it is the third. */
static void pencil_root(rigcal_real m[2], const rigcal_real c[4])
{
    const int swapped = RC_FABS(c[0]) > RC_FABS(c[3]);
    const rigcal_real b3 = c[swapped ? 0 : 3], b2 = c[swapped ? 1 : 2];
    const rigcal_real b1 = c[swapped ? 2 : 1], b0 = c[swapped ? 3 : 0];
    rigcal_real one = b2, x = -b1;
    if (RC_FABS(b3) > RC_EPS * (RC_FABS(b1) + RC_FABS(b2))) {
        const rigcal_real by_lead = 1 / b3, k = b2 * by_lead / 3;
        const rigcal_real r2 = k * k - b1 * by_lead / 3;
        const rigcal_real g = k * (2 * k * k - b1 * by_lead) + b0 * by_lead;
        one = 1;
        x = ((g < 0) ? -root_apart(r2, -g) : root_apart(r2, g)) - k;
    }
    m[swapped] = one;
    m[!swapped] = x;
}

/* The two lines that make up a conic of rank 2: D = l m^T + m l^T. Their crossing
 * is the root of -adj(D), and D + [crossing]x = 2 l m^T. 0 when they are complex. */
static int split(rigcal_real l[2][3], const rigcal_real D[6])
{
    rigcal_real A[6];
    adjugate(A, D);
    const rigcal_real full[3][3] = {
        {A[0], A[1], A[2]}, {A[1], A[3], A[4]}, {A[2], A[4], A[5]}};
    int at = (full[1][1] < full[0][0]) ? 1 : 0;
    at = (full[2][2] < full[at][at]) ? 2 : at;
    if (!(full[at][at] < 0)) {
        return 0;
    }
    const rigcal_real by_root = 1 / RC_SQRT(-full[at][at]);
    const rigcal_real c[3] = {full[at][0] * by_root, full[at][1] * by_root,
                              full[at][2] * by_root};
    const rigcal_real N[3][3] = {{D[0], D[1] - c[2], D[2] + c[1]},
                                 {D[1] + c[2], D[3], D[4] - c[0]},
                                 {D[2] - c[1], D[4] + c[0], D[5]}};
    int row = 0, column = 0;
    for (int k = 1; k < 9; k++) {
        if (RC_FABS(N[k / 3][k % 3]) > RC_FABS(N[row][column])) {
            row = k / 3;
            column = k % 3;
        }
    }
    for (int k = 0; k < 3; k++) {
        l[0][k] = N[row][k];
        l[1][k] = N[k][column];
    }
    return 1;
}

/* Where the line l.v = 0 crosses the conic C, up to scale: 2, or 1, the real part of
 * a complex pair. */
RC_APART static int cross_line(rigcal_real v[2][3], const rigcal_real l[3],
                      const rigcal_real C[6])
{
    const rigcal_real full[3][3] = {
        {C[0], C[1], C[2]}, {C[1], C[3], C[4]}, {C[2], C[4], C[5]}};
    int k = (RC_FABS(l[1]) > RC_FABS(l[0])) ? 1 : 0;
    k = (RC_FABS(l[2]) > RC_FABS(l[k])) ? 2 : k;
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const rigcal_real u = -l[i] / l[k], w = -l[j] / l[k]; /* v_k = u v_i + w v_j */
    const rigcal_real A = full[i][i] + u * (2 * full[i][k] + u * full[k][k]);
    const rigcal_real G = full[j][j] + w * (2 * full[j][k] + w * full[k][k]);
    const rigcal_real B = full[i][j] + u * full[j][k] + w * full[i][k] +
                          u * w * full[k][k];
    const rigcal_real discriminant = B * B - A * G;
    const rigcal_real root = RC_SQRT(rc_max(discriminant, 0));
    const rigcal_real sum = (B < 0) ? root - B : -B - root;
    /* A x^2 + 2 B x y + G y^2 = 0 has the roots (sum : A) and (G : sum). */
    const rigcal_real xy[2][2] = {{sum, A}, {G, sum}};
    const int first = (discriminant > 0 || RC_FABS(A) >= RC_FABS(G)) ? 0 : 1;
    const int count = (discriminant > 0) ? 2 : 1;
    for (int n = 0; n < count; n++) {
        v[n][i] = xy[first + n][0];
        v[n][j] = xy[first + n][1];
        v[n][k] = u * v[n][i] + w * v[n][j];
    }
    return count;
}

/* ---- poses --------------------------------------------------------------- */

/* The depths times h of v, scaled to the size of the triangle, in front. 0 when it
 * does not make the sides, or a point is not in front. */
static int depths_of(rigcal_real s[3], const rigcal_real v[3], const triangle *T)
{
    rigcal_real f[3], wrong = 0;
    sides(f, s, T, v);
    const rigcal_real squared = (T->a[0] + T->a[1] + T->a[2]) / (f[0] + f[1] + f[2]);
    if (!(squared > 0 && squared <= RC_MAX)) {
        return 0;
    }
    const rigcal_real scale = (s[0] < 0) ? -RC_SQRT(squared) : RC_SQRT(squared);
    int is_in_front = 1;
    for (int k = 0; k < 3; k++) {
        s[k] *= scale;
        is_in_front = is_in_front && s[k] > DEPTH_MIN;
        wrong = rc_max(wrong, RC_FABS(squared * f[k] - T->a[k]));
    }
    return is_in_front && wrong <= LIFTED;
}

/* In rows, the axes of the triangle 0, u, w: along w - u, across it, normal to it.
 * u x w of a thin triangle is not normal to rounding: the last row is taken anew.
 * 0 when |u x w| is no more than `least`. */
static int frame(rigcal_real F[9], const rigcal_real u[3], const rigcal_real w[3],
                 rigcal_real least)
{
    rc_vec3_sub(&F[0], w, u);
    rc_vec3_cross(&F[6], u, w);
    if (!(rc_vec3_norm(&F[6]) > least)) {
        return 0;
    }
    rc_vec3_cross(&F[3], &F[6], &F[0]);
    const rigcal_real by_along = 1 / rc_vec3_norm(&F[0]);
    const rigcal_real by_across = 1 / rc_vec3_norm(&F[3]);
    for (int k = 0; k < 3; k++) {
        F[k] *= by_along;
        F[3 + k] *= by_across;
    }
    rc_vec3_cross(&F[6], &F[0], &F[3]);
    return 1;
}

/* The problem as the equations take it: the points and rays in the order of the
 * triangle. */
typedef struct {
    const rigcal_real *ray[3];
    rigcal_real size;      /* longest side */
    rigcal_real middle[3]; /* of the points */
    rigcal_real frame[9];  /* of the points */
    triangle T;
} problem;

RC_APART static int prepare(problem *P, const rigcal_real x[3][3],
                   const rigcal_real ray[3][3])
{
    rigcal_real squared[3], u[3], w[3], chord[3][3];
    for (int k = 0; k < 3; k++) { /* the side opposite to k */
        rc_vec3_sub(u, x[(k + 2) % 3], x[(k + 1) % 3]);
        squared[k] = rc_vec3_dot(u, u);
    }
    int top = (squared[1] > squared[0]) ? 1 : 0;
    top = (squared[2] > squared[top]) ? 2 : top;
    const int i = (top + 1) % 3, j = (top + 2) % 3;
    P->size = RC_SQRT(squared[top]);
    if (!(P->size > 0)) {
        return 0;
    }
    const rigcal_real by_size = 1 / P->size;
    for (int k = 0; k < 3; k++) {
        u[k] = (x[i][k] - x[top][k]) * by_size;
        w[k] = (x[j][k] - x[top][k]) * by_size;
        P->middle[k] = x[top][k] + P->size * (u[k] + w[k]) / 3;
    }
    if (!frame(P->frame, u, w,
               LINE_TOL * (1 + rc_vec3_max_abs(P->middle) * by_size))) {
        return 0;
    }
    P->ray[0] = ray[top];
    P->ray[1] = ray[i];
    P->ray[2] = ray[j];
    rc_vec3_sub(chord[0], ray[i], ray[top]);
    rc_vec3_sub(chord[1], ray[j], ray[top]);
    rc_vec3_sub(chord[2], ray[j], ray[i]);
    rigcal_real longest = 0, least = RC_MAX;
    for (int k = 0; k < 3; k++) {
        P->T.e[k] = rc_vec3_dot(chord[k], chord[k]);
        longest = rc_max(longest, P->T.e[k]);
        least = rc_min(least, P->T.e[k]);
    }
    if (!(least > RAY_TOL * RAY_TOL)) {
        return 0;
    }
    P->T.h = RC_SQRT(longest);
    for (int k = 0; k < 3; k++) {
        P->T.e[k] /= longest;
    }
    P->T.a[0] = rc_vec3_dot(u, u);
    P->T.a[1] = rc_vec3_dot(w, w);
    P->T.a[2] = 1;
    return 1;
}

/* The pose of a solution with depths s / h. */
RC_APART static int write_pose(rigcal_transform *cam_from_points, const problem *P,
                      const rigcal_real s[3])
{
    rigcal_real u[3], w[3], F[9], turned[3];
    const rigcal_real by_h = 1 / P->T.h;
    for (int k = 0; k < 3; k++) {
        const rigcal_real at = s[0] * by_h * P->ray[0][k];
        u[k] = s[1] * by_h * P->ray[1][k] - at;
        w[k] = s[2] * by_h * P->ray[2][k] - at;
    }
    if (!frame(F, u, w, 0)) {
        return 0;
    }
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 3; column++) {
            cam_from_points->R[3 * row + column] =
                F[row] * P->frame[column] + F[3 + row] * P->frame[3 + column] +
                F[6 + row] * P->frame[6 + column];
        }
    }
    rc_mat3_mul_vec3(turned, cam_from_points->R, P->middle);
    for (int k = 0; k < 3; k++) {
        cam_from_points->t[k] =
            P->size * (s[0] * by_h * P->ray[0][k] + (u[k] + w[k]) / 3) - turned[k];
    }
    return 1;
}

/* The lines on which the solutions lie, two by two at most, and a conic that crosses
 * them there. 0 when there are none. */
RC_APART static int find_lines(rigcal_real lines[2][3], rigcal_real conic[6],
                      const triangle *T)
{
    rigcal_real C0[6], c[4], m[2];
    conics(C0, conic, T);
    pencil_cubic(c, C0, conic);
    pencil_root(m, c);
    for (int k = 0; k < 6; k++) {
        const rigcal_real apart = m[0] * C0[k] + m[1] * conic[k];
        conic[k] = m[0] * conic[k] - m[1] * C0[k];
        C0[k] = apart;
    }
    return split(lines, C0);
}

int rc_p3p(rigcal_transform cam_from_points[RC_P3P_MAX], const rigcal_real x[3][3],
           const rigcal_real ray[3][3])
{
    rigcal_real lines[2][3], conic[6];
    problem P;
    int count = 0;
    if (!prepare(&P, x, ray) || !find_lines(lines, conic, &P.T)) {
        return 0;
    }
    for (int side = 0; side < 2; side++) {
        rigcal_real v[2][3], s[3];
        const int crossings = cross_line(v, lines[side], conic);
        for (int k = 0; k < crossings; k++) {
            if (depths_of(s, v[k], &P.T)) {
                count += write_pose(&cam_from_points[count], &P, s);
            }
        }
    }
    return count;
}
