/* p3p: compared with scenes whose pose is known, and with a dense scan of one depth, which
 * finds all solutions by the law of cosines alone. */
#include <math.h>
#include <string.h>

#include "rc_p3p.h"
#include "test_support.h"

#define EPS (RIGCAL_USE_FLOAT ? 1.2e-7 : 2.3e-16)

/* ---- scenes -------------------------------------------------------------- */

/* A triangle whose longest side is about 1, its pose, and its image. */
typedef struct {
    double X[3][3], R[9], t[3], Y[3][3]; /* Y = R X + t */
    double ray[3][3];
    double size, area2, distance; /* longest side; |u x w|; distance of the middle */
    rigcal_transform found[RC_P3P_MAX];
    int count;
} scene;

static double between(const double a[3], const double b[3])
{
    const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};

    return test_norm(d);
}

/* Computes everything else from X, R, t. */
static void observe(scene *s)
{
    double u[3], w[3], normal[3], middle[3] = {0, 0, 0};

    s->size = 0;
    for (int i = 0; i < 3; i++) {
        test_apply(s->Y[i], s->R, s->X[i], s->t);
        s->size = fmax(s->size, between(s->X[i], s->X[(i + 1) % 3]));
        for (int k = 0; k < 3; k++) {
            s->ray[i][k] = s->Y[i][k] / test_norm(s->Y[i]);
            middle[k] += s->Y[i][k] / 3;
        }
    }
    for (int k = 0; k < 3; k++) {
        u[k] = s->X[1][k] - s->X[0][k];
        w[k] = s->X[2][k] - s->X[0][k];
    }
    test_cross(normal, u, w);
    s->area2 = test_norm(normal);
    s->distance = test_norm(middle);
}

/* Sets t so that the target's middle is at `at` in the camera's frame. */
static void place(scene *s, const double R[9], const double at[3])
{
    double turned[3], middle[3] = {0, 0, 0};

    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            middle[k] += s->X[i][k] / 3;
        }
    }
    memcpy(s->R, R, sizeof s->R);
    test_apply(turned, R, middle, NULL);
    for (int k = 0; k < 3; k++) {
        s->t[k] = at[k] - turned[k];
    }
    observe(s);
}

/* The cosine of the angle between the target's normal and the line of sight. */
static double facing(const scene *s)
{
    double u[3], w[3], normal[3], middle[3];

    for (int k = 0; k < 3; k++) {
        u[k] = s->Y[1][k] - s->Y[0][k];
        w[k] = s->Y[2][k] - s->Y[0][k];
        middle[k] = s->Y[0][k] + s->Y[1][k] + s->Y[2][k];
    }
    test_cross(normal, u, w);
    return fabs(test_dot(normal, middle)) / (test_norm(normal) * test_norm(middle));
}

static void random_triangle(scene *s, test_rng *rng)
{
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            s->X[i][k] = test_uniform(rng, -0.5, 0.5);
        }
    }
    memset(s->t, 0, sizeof s->t);
    test_rotation(s->R, 0, 0, 0);
    observe(s); /* to know its size */
}

/* A triangle in front of the camera, 1.5 to 30 sizes away, tilted by up to 60 degrees. */
static void random_scene(scene *s, test_rng *rng)
{
    random_triangle(s, rng);
    do {
        const double far = s->size * exp(test_uniform(rng, log(1.5), log(30)));
        double R[9],
            at[3] = {test_uniform(rng, -0.35, 0.35), test_uniform(rng, -0.35, 0.35), 1};
        const double length = test_norm(at);

        for (int k = 0; k < 3; k++) {
            at[k] *= far / length;
        }
        test_random_rotation(R, rng);
        place(s, R, at);
    } while (facing(s) < 0.5 || s->Y[0][2] <= 0 || s->Y[1][2] <= 0 || s->Y[2][2] <= 0);
}

/* Solves, and checks that only the poses that count were written. */
static int solve(scene *s)
{
    rigcal_real x[3][3], ray[3][3];

    FILL(s->found);
    for (int i = 0; i < 3; i++) {
        test_to_real(x[i], s->X[i], 3);
        test_to_real(ray[i], s->ray[i], 3);
    }
    s->count = rc_p3p(s->found, (const rigcal_real(*)[3])x, (const rigcal_real(*)[3])ray);
    TEST_ASSERT_TRUE(s->count >= 0 && s->count <= RC_P3P_MAX);
    for (int i = s->count; i < RC_P3P_MAX; i++) {
        ASSERT_UNTOUCHED(s->found[i]);
    }
    return s->count;
}

/* ---- judging ------------------------------------------------------------- */

static int is_pose(const scene *s, int i)
{
    static const double UNIT[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    double R[9], t[3], Rt[9], RRt[9];

    test_transform_parts(R, t, &s->found[i]);
    test_transpose(Rt, R);
    test_product(RRt, R, Rt);
    for (int k = 0; k < 9; k++) {
        if (!(fabs(RRt[k] - UNIT[k]) <= 16 * EPS)) {
            return 0;
        }
    }
    return test_determinant(R) > 0 && test_norm(t) < 1e300;
}

/* The largest angle between a ray and the direction of its point by pose i [rad]; -1: a
 * point is behind the camera, or the pose is not a pose. */
static double ray_error(const scene *s, int i)
{
    double R[9], t[3], worst = 0;

    if (!is_pose(s, i)) {
        return -1;
    }
    test_transform_parts(R, t, &s->found[i]);
    for (int k = 0; k < 3; k++) {
        double Y[3], across[3];

        test_apply(Y, R, s->X[k], t);
        test_cross(across, Y, s->ray[k]);
        if (!(test_dot(Y, s->ray[k]) > 0)) {
            return -1;
        }
        worst = fmax(worst, test_norm(across) / test_norm(Y));
    }
    return worst;
}

/* The error of pose i: the largest displacement of a point, over the size of the
 * triangle. */
static double pose_error(const scene *s, int i)
{
    double R[9], t[3], worst = 0;

    test_transform_parts(R, t, &s->found[i]);
    for (int k = 0; k < 3; k++) {
        double Y[3];

        test_apply(Y, R, s->X[k], t);
        worst = fmax(worst, between(Y, s->Y[k]) / s->size);
    }
    return worst;
}

static double least_error(const scene *s)
{
    double least = 1e300;

    for (int i = 0; i < s->count; i++) {
        TEST_ASSERT_TRUE(ray_error(s, i) >= 0);
        least = fmin(least, pose_error(s, i));
    }
    return least;
}

/* Bound of the displacement of the true pose's points by rounding of rays and points, over
 * the size. A side has the error eps times the distance. The square of the side has twice
 * that times its length. The depths have the inverse of the derivative of the squares. */
static double rounding_bound(const scene *s)
{
    double J[9] = {0}, column[3][3], sum = 0, farthest = 0;

    for (int k = 0; k < 3; k++) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const double c = test_dot(s->ray[i], s->ray[j]);
        const double di = test_norm(s->Y[i]), dj = test_norm(s->Y[j]);

        J[3 * k + i] = 2 * (di - dj * c) / s->size;
        J[3 * k + j] = 2 * (dj - di * c) / s->size;
        farthest = fmax(farthest, di);
    }
    for (int k = 0; k < 3; k++) { /* rows of the inverse, times the determinant */
        test_cross(column[k], &J[3 * ((k + 1) % 3)], &J[3 * ((k + 2) % 3)]);
        sum += test_dot(column[k], column[k]);
    }
    farthest /= s->size;
    return 4 * EPS * farthest *
           (1 + 2 * sqrt(sum) / fabs(test_determinant(J)) *
                    (1 + s->size * s->size / s->area2 / farthest));
}

/* ---- all solutions by a scan --------------------------------------------- */

typedef struct {
    double cosine[3], side2[3]; /* for the sides 01, 02, 12 */
    double most;                /* the largest depth of point 0 that both its sides allow */
} cosines;

/* Depth j from depth 0, on the nearer or the farther branch. */
static double other_depth(const cosines *C, int j, double s0, int farther)
{
    const double c = C->cosine[j];
    const double root = sqrt(fmax(0, C->side2[j] - s0 * s0 * (1 - c * c)));

    return s0 * c + (farther ? root : -root);
}

/* The error of the square of the third side. s0 = most sin(angle), so that the root above
 * is smooth at the end. */
static double third_side(double s[3], const cosines *C, double angle, int branch)
{
    s[0] = C->most * sin(angle);
    s[1] = other_depth(C, 0, s[0], branch & 1);
    s[2] = other_depth(C, 1, s[0], branch & 2);
    return s[1] * s[1] + s[2] * s[2] - 2 * s[1] * s[2] * C->cosine[2] - C->side2[2];
}

/* Finds all solutions with positive depths. *margin: how close the scan came to another
 * solution: the least square of a side or depth that is nearly zero. */
static int scan(double s[16][3], double *margin, const scene *target)
{
    enum { STEPS = 2000 };
    static const int PAIR[3][2] = {{0, 1}, {0, 2}, {1, 2}};
    const double half = TEST_PI / 2;
    cosines C;
    int count = 0;

    C.most = *margin = 1e300;
    for (int k = 0; k < 3; k++) {
        const int i = PAIR[k][0], j = PAIR[k][1];
        double across[3];

        test_cross(across, target->ray[i], target->ray[j]);
        C.cosine[k] = test_dot(target->ray[i], target->ray[j]);
        C.side2[k] = pow(between(target->X[i], target->X[j]), 2);
        if (k < 2) {
            C.most = fmin(C.most, sqrt(C.side2[k]) / test_norm(across));
        }
    }
    for (int branch = 0; branch < 4; branch++) {
        double f[3] = {0, 0, 0};

        for (int n = 0; n <= STEPS; n++) {
            double at[3], low = half * (n - 1) / STEPS, high = half * n / STEPS;

            f[0] = f[1];
            f[1] = f[2];
            f[2] = third_side(at, &C, high, branch);
            if (n > 1 && (f[1] - f[0]) * (f[2] - f[1]) < 0 && f[0] * f[2] > 0) {
                *margin = fmin(*margin, fabs(f[1]));
            }
            if (n == 0 || f[1] * f[2] > 0) {
                continue;
            }
            for (int k = 0; k < 60; k++) {
                const double middle = (low + high) / 2;

                if (third_side(at, &C, middle, branch) * f[2] > 0) {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            for (int k = 0; k < 3; k++) {
                *margin = fmin(*margin, fabs(at[k]));
            }
            if (at[0] > 0 && at[1] > 0 && at[2] > 0) {
                TEST_ASSERT_LESS_THAN_INT(16, count);
                memcpy(s[count++], at, sizeof at);
            }
        }
        *margin = fmin(*margin, fabs(f[2])); /* two branches meet here */
    }
    return count;
}

/* Computes the depths of pose i. */
static void depths(double s[3], const scene *target, int i)
{
    double R[9], t[3];

    test_transform_parts(R, t, &target->found[i]);
    for (int k = 0; k < 3; k++) {
        double Y[3];

        test_apply(Y, R, target->X[k], t);
        s[k] = test_norm(Y);
    }
}

/* ---- the truth is among them --------------------------------------------- */

/* Where rounding alone moves the pose by a tenth of the triangle, two poses merge. */
static void test_the_true_pose_is_among_them(void)
{
    enum { SCENES = TEST_TRIALS(100000) };
    test_rng rng = test_seed(1);
    int missed = 0, open = 0;

    for (int n = 0; n < SCENES; n++) {
        scene s;

        random_scene(&s, &rng);
        (void)solve(&s);
        const double bound = rounding_bound(&s);
        open += bound > 0.1;
        missed += !(least_error(&s) <= bound);
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(SCENES / 10000, missed);
    TEST_ASSERT_LESS_OR_EQUAL_INT(SCENES / TOL(10000, 100), open);
}

/* From a distance of 0.3 sizes, where points are seen at any angle, and for triangles as
 * thin as a thousandth. */
static void test_near_and_thin_triangles_too(void)
{
    enum { SCENES = TEST_TRIALS(50000) };
    test_rng rng = test_seed(12);
    int missed = 0, judged = 0;

    for (int n = 0; n < SCENES; n++) {
        const double thin = exp(test_uniform(&rng, log(1e-3), 0));
        double at[3] = {0, 0, 0};
        scene s;

        random_scene(&s, &rng);
        for (int k = 0; k < 3 && n % 2 == 0; k++) {
            s.X[2][k] =
                s.X[0][k] + 0.6 * (s.X[1][k] - s.X[0][k]) + thin * (s.X[2][k] - s.X[0][k]);
        }
        at[2] = s.size * exp(test_uniform(&rng, log(0.3), log(3)));
        place(&s, s.R, at);
        const double bound = rounding_bound(&s);
        if (!(bound < 0.1)) {
            continue;
        }
        (void)solve(&s);
        missed += !(least_error(&s) <= bound);
        judged++;
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(SCENES / 10000, missed);
    TEST_ASSERT_GREATER_THAN_INT(SCENES * TOL(0.99, 0.8), judged);
}

/* The camera is on the cylinder through the corners, along the normal. There two solutions
 * are one, and rounding moves them by its square root. */
static void test_a_double_solution_is_found(void)
{
    test_rng rng = test_seed(2);
    double worst = 0;

    for (int n = 0; n < TEST_TRIALS(2000); n++) {
        const double angle = test_uniform(&rng, 0, 2 * TEST_PI);
        const double height = test_uniform(&rng, 1.5, 8);
        double R[9], at[3];
        scene s;

        for (int i = 0; i < 3; i++) { /* corners on the unit circle */
            const double a = (2 * i + test_uniform(&rng, -0.7, 0.7)) * TEST_PI / 3;

            s.X[i][0] = cos(a);
            s.X[i][1] = sin(a);
            s.X[i][2] = 0;
        }
        /* A camera at o in the target's frame, with a random rotation. */
        const double o[3] = {cos(angle), sin(angle), height};
        test_random_rotation(R, &rng);
        test_apply(at, R, o, NULL);
        memcpy(s.R, R, sizeof R);
        for (int k = 0; k < 3; k++) {
            s.t[k] = -at[k];
        }
        observe(&s);
        TEST_ASSERT_GREATER_THAN_INT(0, solve(&s));
        worst = fmax(worst, least_error(&s) / (height * height));
    }
    TEST_ASSERT_TRUE(worst < 20 * sqrt(EPS));
}

/* The same cylinder in an image with noise, which makes half of the pairs of solutions
 * complex. */
static void test_noise_does_not_take_a_double_solution_away(void)
{
    test_rng rng = test_seed(3);
    int far_off = 0;

    for (int n = 0; n < TEST_TRIALS(2000); n++) {
        const double angle = test_uniform(&rng, 0, 2 * TEST_PI);
        const double o[3] = {cos(angle), sin(angle), 4};
        double at[3];
        scene s;

        for (int i = 0; i < 3; i++) {
            const double a = (2 * i + test_uniform(&rng, -0.7, 0.7)) * TEST_PI / 3;

            s.X[i][0] = cos(a);
            s.X[i][1] = sin(a);
            s.X[i][2] = 0;
        }
        test_random_rotation(s.R, &rng);
        test_apply(at, s.R, o, NULL);
        for (int k = 0; k < 3; k++) {
            s.t[k] = -at[k];
        }
        observe(&s);
        for (int i = 0; i < 3; i++) { /* a pixel of 800 */
            for (int k = 0; k < 3; k++) {
                s.ray[i][k] += test_normal(&rng) / 800;
            }
            const double length = test_norm(s.ray[i]);
            for (int k = 0; k < 3; k++) {
                s.ray[i][k] /= length;
            }
        }
        (void)solve(&s);
        far_off += !(least_error(&s) < 0.5);
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(20, far_off);
}

/* ---- nothing but, and all of them ---------------------------------------- */

/* Each pose either puts the points on their rays, or is the real part of a complex pair.
 * The latter may miss by a hundredth of the square of the longest side: a tenth of it for a
 * short side, and more at the corner between two. */
static void test_each_is_a_solution_or_nearly_one(void)
{
    test_rng rng = test_seed(4);
    int lifted = 0, total = 0;

    for (int n = 0; n < TEST_TRIALS(20000); n++) {
        scene s;

        random_scene(&s, &rng);
        total += solve(&s);
        for (int i = 0; i < s.count; i++) {
            const double error = ray_error(&s, i) * s.distance / s.size;

            TEST_ASSERT_TRUE(error >= 0 && error < 0.3);
            lifted += error > TOL(1e-7, 1e-3);
        }
    }
    TEST_ASSERT_LESS_THAN_INT(total / 10, lifted);
}

static void test_it_finds_what_a_scan_finds(void)
{
    enum { SCENES = TEST_TRIALS(1500) };
    test_rng rng = test_seed(5);
    int left_out = 0, with[RC_P3P_MAX + 1] = {0};

    for (int n = 0; n < SCENES; n++) {
        double expected[16][3], margin;
        int exact = 0;
        scene s;

        random_scene(&s, &rng);
        const int count = scan(expected, &margin, &s);
        if (margin < TOL(1e-4, 3e-3)) {
            left_out++;
            continue;
        }
        (void)solve(&s);
        for (int i = 0; i < s.count; i++) {
            double found[3], least = 1e300;

            depths(found, &s, i);
            for (int k = 0; k < count; k++) {
                least = fmin(least, between(found, expected[k]) / s.distance);
            }
            exact += least < TOL(1e-8, 1e-3);
        }
        TEST_ASSERT_EQUAL_INT(count, exact);
        with[count]++;
    }
    TEST_ASSERT_LESS_OR_EQUAL_INT(SCENES / TOL(20, 5), left_out);
    TEST_ASSERT_GREATER_THAN_INT(0, with[2]);
    TEST_ASSERT_TRUE(with[4] > 0 || TEST_ONE_IN > 1); /* only a few scenes have four */
}

/* An equilateral triangle of side 1 and a camera on its axis, at the distance x = 2 from
 * every corner. The law of cosines gives (x, x, x), and three solutions with one corner at
 * x - 1 / x (Fischler and Bolles 1981). */
static void test_a_case_from_paper(void)
{
    const double radius = 1 / sqrt(3), height = sqrt(4 - radius * radius);
    int seen[3] = {0, 0, 0}, all_equal = 0;
    scene s;

    for (int i = 0; i < 3; i++) {
        s.X[i][0] = radius * cos(2 * TEST_PI * i / 3);
        s.X[i][1] = radius * sin(2 * TEST_PI * i / 3);
        s.X[i][2] = 0;
    }
    test_rotation(s.R, 0, 0, 0);
    s.t[0] = s.t[1] = 0;
    s.t[2] = height;
    observe(&s);
    TEST_ASSERT_EQUAL_INT(4, solve(&s));
    for (int i = 0; i < 4; i++) {
        double found[3];
        int nearer = -1;

        depths(found, &s, i);
        for (int k = 0; k < 3; k++) {
            nearer = (found[k] < 1.75) ? k : nearer;
        }
        for (int k = 0; k < 3; k++) {
            ASSERT_NEAR(k == nearer ? 1.5 : 2, found[k], TOL(1e-13, 1e-5));
        }
        if (nearer < 0) {
            all_equal++;
        } else {
            seen[nearer]++;
        }
    }
    TEST_ASSERT_EQUAL_INT(1, all_equal);
    TEST_ASSERT_TRUE(seen[0] == 1 && seen[1] == 1 && seen[2] == 1);
}

/* ---- symmetry ------------------------------------------------------------ */

/* Corners of a square seen head-on and from the side, where determinants vanish. */
static void test_half_a_square_seen_head_on_or_aslant(void)
{
    static const double CORNER[3][3] = {{-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0.5, 0.5, 0}};
    static const double FAR[4] = {1.5, 5, 30, TOL(3000, 100)};

    for (int tilt = 0; tilt <= 60; tilt += 15) {
        for (int turn = 0; turn < 360; turn += 45) {
            for (int n = 0; n < 4; n++) {
                const double at[3] = {0, 0, FAR[n]};
                double yaw[9], pitch[9], R[9];
                scene s;

                memcpy(s.X, CORNER, sizeof s.X);
                test_rotation(pitch, 0, tilt * TEST_PI / 180, 0);
                test_rotation(yaw, turn * TEST_PI / 180, 0, 0);
                test_product(R, pitch, yaw);
                place(&s, R, at);
                (void)solve(&s);
                TEST_ASSERT_TRUE(least_error(&s) <= fmin(0.2 * FAR[n], rounding_bound(&s)));
            }
        }
    }
}

/* Corners and a camera at whole coordinates. Often one or both conics are lines already, or
 * would be without rounding. */
static void test_whole_coordinates(void)
{
    enum { SCENES = TEST_TRIALS(50000) };
    test_rng rng = test_seed(14);
    int missed = 0, judged = 0;

    for (int n = 0; n < SCENES; n++) {
        scene s;

        test_rotation(s.R, 0, 0, 0);
        for (int k = 0; k < 3; k++) {
            for (int i = 0; i < 3; i++) {
                s.X[i][k] = floor(test_uniform(&rng, -2, 3));
            }
            s.t[k] = floor(test_uniform(&rng, -4, 5));
        }
        observe(&s);
        const double bound = rounding_bound(&s), chord01 = between(s.ray[0], s.ray[1]);
        const double chord2 =
            fmin(between(s.ray[1], s.ray[2]), between(s.ray[2], s.ray[0]));
        if (!(bound < 0.1 && fmin(chord01, chord2) > 1e-3)) { /* NaN: seen from a corner */
            continue;
        }
        (void)solve(&s);
        missed += !(least_error(&s) <= bound);
        judged++;
    }
    TEST_ASSERT_EQUAL_INT(0, missed);
    TEST_ASSERT_GREATER_THAN_INT(SCENES / 2, judged);
}

/* Three solutions merge, or nearly: the cubic of the pencil is x^3, in double without
 * rounding. */
static void test_three_pairings_that_are_one(void)
{
    static const double X[2][3][3] = {{{-2, -2, -1}, {2, 0, -2}, {1, -2, 2}},
                                      {{0, -2, -1}, {-2, 0, -1}, {-2, -2, 2}}};
    static const double T[2][3] = {{3, -2, -3}, {3, 3, 3}};
    scene s;

    for (int n = 0; n < 2; n++) {
        memcpy(s.X, X[n], sizeof s.X);
        memcpy(s.t, T[n], sizeof s.t);
        test_rotation(s.R, 0, 0, 0);
        observe(&s);
        (void)solve(&s);
        TEST_ASSERT_TRUE(least_error(&s) < 2 * cbrt(EPS));
    }
}

/* At these corners two solutions are one, and its equations have no rounding in double. It
 * is one pose, as each other solution is. */
static void test_a_double_solution_of_whole_coordinates_is_one_pose(void)
{
    static const double Y[3][3][3] = {{{2, -1, 1}, {0, 0, 1}, {0, 2, 1}},
                                      {{2, 0, 2}, {0, 1, 1}, {-1, 1, 1}},
                                      {{1, -1, 1}, {0, 2, 2}, {1, 0, 1}}};
    static const double NOWHERE[3] = {0, 0, 0};

    for (int n = 0; n < 3; n++) {
        scene s;

        memcpy(s.X, Y[n], sizeof s.X);
        memcpy(s.t, NOWHERE, sizeof s.t);
        test_rotation(s.R, 0, 0, 0);
        observe(&s);
        (void)solve(&s);
        TEST_ASSERT_TRUE(least_error(&s) < 4 * sqrt(EPS));
        for (int i = 0; i < s.count && !RIGCAL_USE_FLOAT; i++) {
            for (int j = 0; j < i; j++) {
                double there[3], here[3];

                depths(there, &s, i);
                depths(here, &s, j);
                TEST_ASSERT_TRUE(between(there, here) > 0.01);
            }
        }
    }
}

/* Units, origin and order of the points have no effect. */
static void test_units_origin_and_order_do_not_matter(void)
{
    static const int ORDER[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                    {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    static const double UNIT[3] = {1, TOL(1e-20, 1e-6), TOL(1e20, 1e6)};
    test_rng rng = test_seed(6);

    for (int n = 0; n < TEST_TRIALS(600); n++) {
        const double unit = UNIT[n % 3], offset = 5 * (n % 2);
        scene s, other;

        random_scene(&s, &rng);
        if (!(rounding_bound(&s) < TOL(1e-11, 1e-3))) {
            continue;
        }
        other = s;
        for (int i = 0; i < 3; i++) {
            for (int k = 0; k < 3; k++) {
                other.X[i][k] = unit * (s.X[ORDER[n % 6][i]][k] + offset);
                other.ray[i][k] = s.ray[ORDER[n % 6][i]][k];
            }
        }
        (void)solve(&s);
        TEST_ASSERT_EQUAL_INT(s.count, solve(&other));
        for (int i = 0; i < s.count; i++) {
            double least = 1e300, here[3], there[3];

            depths(here, &s, i);
            for (int j = 0; j < other.count; j++) {
                double ordered[3];

                depths(there, &other, j);
                for (int k = 0; k < 3; k++) {
                    ordered[ORDER[n % 6][k]] = there[k] / unit;
                }
                least = fmin(least, between(here, ordered) / s.size);
            }
            TEST_ASSERT_TRUE(least < TOL(1e-6, 0.05));
        }
    }
}

/* The camera is a fisheye that sees behind itself. */
static void test_rays_may_point_anywhere(void)
{
    test_rng rng = test_seed(7);

    for (int n = 0; n < TEST_TRIALS(2000); n++) {
        double R[9];
        scene s, turned;

        random_scene(&s, &rng);
        turned = s;
        test_random_rotation(R, &rng);
        test_product(turned.R, R, s.R);
        test_apply(turned.t, R, s.t, NULL);
        observe(&turned);
        (void)solve(&turned);
        TEST_ASSERT_TRUE(least_error(&turned) <= 2 * rounding_bound(&turned));
    }
}

/* ---- what has no answer -------------------------------------------------- */

static void assert_none(scene *s)
{
    TEST_ASSERT_EQUAL_INT(0, solve(s));
}

static void test_points_on_a_line_or_together_have_none(void)
{
    test_rng rng = test_seed(8);

    for (int n = 0; n < TEST_TRIALS(1000); n++) {
        scene s;

        random_scene(&s, &rng);
        for (int k = 0; k < 3; k++) { /* rounded; in some trials far from the origin */
            s.X[1][k] = D(RC(s.X[1][k] + 100 * (n % 2)));
            s.X[0][k] = D(RC(s.X[0][k] + 100 * (n % 2)));
            s.X[2][k] = s.X[0][k] + 0.37 * (s.X[1][k] - s.X[0][k]);
        }
        assert_none(&s);
        memcpy(s.X[2], s.X[n % 2], sizeof s.X[2]);
        assert_none(&s);
        memcpy(s.X[1 - n % 2], s.X[n % 2], sizeof s.X[2]);
        assert_none(&s);
    }
}

static void test_rays_together_have_none(void)
{
    test_rng rng = test_seed(9);

    for (int n = 0; n < TEST_TRIALS(1000); n++) {
        scene s;

        random_scene(&s, &rng);
        memcpy(s.ray[(n + 1) % 3], s.ray[n % 3], sizeof s.ray[0]);
        assert_none(&s);
        memcpy(s.ray[(n + 2) % 3], s.ray[n % 3], sizeof s.ray[0]);
        assert_none(&s);
    }
}

/* Never a NaN, and never a pose of a triangle that does not fit its rays. */
static void test_anything_else_gives_poses_or_none(void)
{
    static const double ODD[6] = {0, 1, -1, 1e-3, 0.5, 2};
    test_rng rng = test_seed(10);
    int none = 0;

    for (int n = 0; n < TEST_TRIALS(20000); n++) {
        scene s;

        random_scene(&s, &rng);
        for (int i = 0; i < 3; i++) {
            for (int k = 0; k < 3; k++) {
                s.X[i][k] = (n % 2) ? ODD[test_next(&rng) % 6] : s.X[i][k];
                s.ray[i][k] = (n % 4 < 2) ? ODD[test_next(&rng) % 6] : test_normal(&rng);
            }
            s.ray[i][n % 3] += test_norm(s.ray[i]) > 0 ? 0 : 1;
            const double length = test_norm(s.ray[i]);
            for (int k = 0; k < 3; k++) {
                s.ray[i][k] /= length;
            }
        }
        (void)solve(&s);
        none += s.count == 0;
        for (int i = 0; i < s.count; i++) {
            TEST_ASSERT_TRUE(is_pose(&s, i));
        }
    }
    TEST_ASSERT_GREATER_THAN_INT(0, none);
}

static void test_nan_has_none(void)
{
    test_rng rng = test_seed(11);
    scene s;

    for (int k = 0; k < 18; k++) {
        random_scene(&s, &rng);
        *(k < 9 ? &s.X[k / 3][k % 3] : &s.ray[k / 3 - 3][k % 3]) =
            (rng.state % 2) ? D(TEST_NAN) : D(TEST_INF);
        assert_none(&s);
    }
}

static void make_unit(scene *s)
{
    for (int i = 0; i < 3; i++) {
        const double length = test_norm(s->ray[i]);

        for (int k = 0; k < 3; k++) {
            s->ray[i][k] /= length;
        }
    }
}

/* The rays are nearly on one line, on both sides of the centre, and the points are close
 * together. All numbers are powers of 2. */
static void nearly_on_a_line(scene *s, test_rng *rng)
{
    const int most = RIGCAL_USE_FLOAT ? 20 : 48;
    double far[4];

    for (int i = 0; i < 4; i++) {
        far[i] = ldexp(1, -(int)(test_next(rng) % (uint64_t)most));
    }
    for (int k = 0; k < 3; k++) {
        s->X[0][k] = test_uniform(rng, -1, 1);
        s->ray[0][k] = test_uniform(rng, -1, 1);
        s->X[1][k] = s->X[0][k] + far[0] * test_uniform(rng, -1, 1);
        s->ray[1][k] = -s->ray[0][k] + far[1] * test_uniform(rng, -1, 1);
        s->X[2][k] = s->X[0][k] + far[2] * test_uniform(rng, -1, 1);
        s->ray[2][k] = s->ray[0][k] + far[3] * test_uniform(rng, -1, 1);
    }
    make_unit(s);
}

/* Rays in one plane, close together. */
static void narrow_in_a_plane(scene *s, test_rng *rng)
{
    const int most = RIGCAL_USE_FLOAT ? 18 : 44;
    const double far = ldexp(1, -most / 3 - (int)(test_next(rng) % (uint64_t)most) / 2);

    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            s->X[i][k] = test_uniform(rng, -1, 1);
        }
        s->ray[i][0] = far * test_uniform(rng, -1, 1);
        s->ray[i][1] = 0;
        s->ray[i][2] = 1;
    }
    make_unit(s);
}

static void assert_poses_or_none(scene *s)
{
    (void)solve(s);
    for (int i = 0; i < s->count; i++) {
        TEST_ASSERT_TRUE(is_pose(s, i));
    }
}

/* Here rounding decides. A root is threefold, or takes many steps; a solution is 0, has no
 * length, or has points on a line. The seeds below are such cases. */
static void test_rays_that_hardly_differ_give_poses_or_none(void)
{
    static const uint64_t ON_A_LINE[] = {1104, 1141, 1476, 7471, 43456, 148206};
    static const uint64_t IN_A_PLANE[] = {22102, 48870};
    enum { LINES = sizeof ON_A_LINE / sizeof ON_A_LINE[0] };
    scene s;

    for (int n = 0; n < TEST_TRIALS(2000) + LINES; n++) {
        test_rng rng = test_seed(n < LINES ? ON_A_LINE[n] : 2000 + (uint64_t)n);

        nearly_on_a_line(&s, &rng);
        assert_poses_or_none(&s);
    }
    for (int n = 0; n < TEST_TRIALS(2000) + 2; n++) {
        test_rng rng = test_seed(n < 2 ? IN_A_PLANE[n] : 2000 + (uint64_t)n);

        narrow_in_a_plane(&s, &rng);
        assert_poses_or_none(&s);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_the_true_pose_is_among_them);
    RUN_TEST(test_near_and_thin_triangles_too);
    RUN_TEST(test_a_double_solution_is_found);
    RUN_TEST(test_noise_does_not_take_a_double_solution_away);
    RUN_TEST(test_each_is_a_solution_or_nearly_one);
    RUN_TEST(test_it_finds_what_a_scan_finds);
    RUN_TEST(test_a_case_from_paper);
    RUN_TEST(test_half_a_square_seen_head_on_or_aslant);
    RUN_TEST(test_whole_coordinates);
    RUN_TEST(test_three_pairings_that_are_one);
    RUN_TEST(test_a_double_solution_of_whole_coordinates_is_one_pose);
    RUN_TEST(test_units_origin_and_order_do_not_matter);
    RUN_TEST(test_rays_may_point_anywhere);
    RUN_TEST(test_points_on_a_line_or_together_have_none);
    RUN_TEST(test_rays_together_have_none);
    RUN_TEST(test_anything_else_gives_poses_or_none);
    RUN_TEST(test_nan_has_none);
    RUN_TEST(test_rays_that_hardly_differ_give_poses_or_none);
}
