/* The calibration equations, one by one: pairs (11) to (13), elimination (14),
 * (15), the residual over three angles (5), translation (10), (16). */
#include <math.h>
#include <string.h>

#include "test_support.h"
#include "vectors_elimination_all.h"
#include "vectors_elimination_two.h"
#include "vectors_pairs.h"
#include "vectors_scenes.h"
#include "vectors_translation.h"

/* What the formulas owe to the oracle where numbers are of order 1. */
#define TOL_FORMULA TOL(1e-12, 1e-4)

enum { POINTS_MAX = TEST_SCENE_MAX, PAIRS_MAX = 4 * POINTS_MAX };

static const rigcal_real IDENTITY[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

/* Scene k of the vectors: its noisy bearings, the rotation it was taken from
 * and the angles nearby. */
static void golden_scene(rigcal_bearing out[6], double ypr[3], double wrong[3],
                         int k)
{
    const double *v = SCENE[k];

    for (int i = 0; i < 6; i++) {
        test_to_real(out[i].X_w, v + 3 * i, 3);
        test_to_real(out[i].ray, v + 18 + 2 * i, 2);
        out[i].ray[2] = 1;
    }
    for (int i = 0; i < 3; i++) {
        ypr[i] = v[30 + i];
        wrong[i] = v[36 + i];
    }
}

/* The pairs of the first n points in the vectors' order. */
static int golden_pairs(rigcal_pair pairs[15], const rigcal_bearing s[6],
                        int n)
{
    int count = 0;

    for (int j = 0; j < n; j++) {
        for (int i = 0; i < j; i++) {
            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_pair_make(&pairs[count++], s, 6, i, j));
        }
    }
    return count;
}

/* The two angles that stay, in the order yaw, pitch, roll. */
static void other_two(rigcal_real out[2], const double ypr[3], int eliminate)
{
    out[0] = RC(ypr[eliminate == RIGCAL_YAW ? 1 : 0]);
    out[1] = RC(ypr[eliminate == RIGCAL_ROLL ? 1 : 2]);
}

static void rotation_of(rigcal_real R[9], const double ypr[3])
{
    double M[9];

    test_rotation(M, ypr[0], ypr[1], ypr[2]);
    test_to_real(R, M, 9);
}

static rigcal_pair pair_of(double n1, double n2, double n3, double d1,
                           double d2, double d3)
{
    const rigcal_pair pair = {
        {RC(n1), RC(n2), RC(n3)}, {RC(d1), RC(d2), RC(d3)}, 0, 1};

    return pair;
}

/* ---- one pair ------------------------------------------------------------ */

/* Rays straight ahead and 45 degrees to the right span the plane y = 0. */
static void test_a_pair_is_a_plane_of_rays_and_a_direction(void)
{
    static const rigcal_bearing s[2] = {{{5, 7, 0}, {0, 0, 1}},
                                         {{6, 7, 0}, {1, 0, 1}}};
    static const double normal[3] = {0, 1, 0}, offset[3] = {-1, 0, 0};
    static const rigcal_real quarter_yaw[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1};
    rigcal_pair pair;
    rigcal_real e;

    ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&pair, s, 2, 0, 1));
    ASSERT_ARRAY_NEAR(normal, pair.normal, 3, TOL(1e-15, 1e-7));
    ASSERT_ARRAY_NEAR(offset, pair.offset, 3, TOL(1e-15, 1e-7));
    TEST_ASSERT_EQUAL_INT32(0, pair.i);
    TEST_ASSERT_EQUAL_INT32(1, pair.j);
    ASSERT_STATUS(RIGCAL_OK, rigcal_pair_residual(&e, &pair, IDENTITY));
    ASSERT_NEAR(0, e, TOL(1e-15, 1e-7));
    ASSERT_STATUS(RIGCAL_OK, rigcal_pair_residual(&e, &pair, quarter_yaw));
    ASSERT_NEAR(-1, e, TOL(1e-15, 1e-7));
}

static void test_pairs_and_their_residuals_are_the_oracles(void)
{
    for (int k = 0; k < SCENE_ROWS; k++) {
        const double *v = PAIR_TERMS[k];
        double ypr[3], wrong[3];
        rigcal_bearing s[6];
        rigcal_pair pair;
        rigcal_real R[9], e;

        golden_scene(s, ypr, wrong, k);
        ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&pair, s, 6, (int32_t)v[0],
                                                  (int32_t)v[1]));
        ASSERT_ARRAY_NEAR(v + 2, pair.normal, 3, TOL_FORMULA);
        ASSERT_ARRAY_NEAR(v + 5, pair.offset, 3, TOL_FORMULA);
        rotation_of(R, wrong);
        ASSERT_STATUS(RIGCAL_OK, rigcal_pair_residual(&e, &pair, R));
        ASSERT_NEAR(v[8], e, TOL_FORMULA);
    }
}

static void test_a_pair_does_not_depend_on_the_length_of_its_rays(void)
{
    const double lengths[3] = {0.01, 300, TOL(1e9, 1e6)};
    double ypr[3], wrong[3], normal[3];
    rigcal_bearing s[6];
    rigcal_pair pair;

    golden_scene(s, ypr, wrong, 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&pair, s, 6, 0, 1));
    test_to_double(normal, pair.normal, 3);
    for (int i = 0; i < 3; i++) {
        golden_scene(s, ypr, wrong, 0);
        for (int k = 0; k < 3; k++) {
            s[0].ray[k] *= RC(lengths[i]);
            s[1].ray[k] *= RC(lengths[2 - i]);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&pair, s, 6, 0, 1));
        ASSERT_ARRAY_NEAR(normal, pair.normal, 3, TOL(1e-13, 2e-5));
    }
}

static void test_a_pair_taken_the_other_way_round_is_the_same_equation(void)
{
    double ypr[3], wrong[3];
    rigcal_bearing s[6];
    rigcal_pair there, back;
    rigcal_real R[9], e_there, e_back;

    golden_scene(s, ypr, wrong, 1);
    rotation_of(R, wrong);
    ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&there, s, 6, 2, 5));
    ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&back, s, 6, 5, 2));
    for (int k = 0; k < 3; k++) {
        ASSERT_NEAR(there.normal[k], -back.normal[k], TOL(1e-15, 1e-7));
        ASSERT_NEAR(there.offset[k], -back.offset[k], TOL(1e-15, 1e-7));
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_pair_residual(&e_there, &there, R));
    ASSERT_STATUS(RIGCAL_OK, rigcal_pair_residual(&e_back, &back, R));
    ASSERT_NEAR(e_there, e_back, TOL(1e-15, 1e-7));
}

static void test_the_residual_vanishes_at_the_true_rotation(void)
{
    test_rng rng = test_seed(31);

    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        test_scene scene;
        rigcal_bearing s[8];
        rigcal_real R[9];

        test_scene_random(&scene, &rng, 8, (test_shape)(trial % 3));
        test_bearings(s, &scene);
        test_to_real(R, scene.R, 9);
        for (int i = 1; i < 8; i++) {
            const double apart = hypot(scene.xy[i][0] - scene.xy[0][0],
                                       scene.xy[i][1] - scene.xy[0][1]);
            rigcal_pair pair;
            rigcal_real e;

            if (apart < 0.01) {
                continue;
            }
            ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&pair, s, 8, 0, i));
            ASSERT_STATUS(RIGCAL_OK, rigcal_pair_residual(&e, &pair, R));
            /* The plane of rays is known to rounding over their distance, and
             * so is the direction: coordinates are up to 3 for a size of 1. */
            ASSERT_NEAR(0, e, TOL(2e-15, 1e-6) / apart);
        }
    }
}

static void test_a_pair_of_one_point_or_one_ray_carries_no_equation(void)
{
    rigcal_bearing s[2] = {{{1000, 2, 3}, {RC(0.1), RC(0.2), 1}},
                            {{1000, 2, 3}, {RC(0.3), RC(0.1), 1}}};
    rigcal_pair pair;

    ASSERT_REFUSED(RIGCAL_ERR_COINCIDENT, pair,
                   rigcal_pair_make(&pair, s, 2, 0, 1));
    /* One rounding apart is no direction either. */
    s[1].X_w[0] = RC(1000 + TOL(1.2e-13, 6.2e-5));
    ASSERT_REFUSED(RIGCAL_ERR_COINCIDENT, pair,
                   rigcal_pair_make(&pair, s, 2, 0, 1));
    s[1].X_w[0] = 1001;
    ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&pair, s, 2, 0, 1));
    for (int k = 0; k < 3; k++) {
        s[1].ray[k] = 4 * s[0].ray[k];
    }
    ASSERT_REFUSED(RIGCAL_ERR_COINCIDENT, pair,
                   rigcal_pair_make(&pair, s, 2, 0, 1));
    for (int k = 0; k < 3; k++) {
        s[1].ray[k] = s[0].ray[k] / 3;
    }
    ASSERT_REFUSED(RIGCAL_ERR_COINCIDENT, pair,
                   rigcal_pair_make(&pair, s, 2, 0, 1));
    for (int k = 0; k < 3; k++) {
        s[1].ray[k] = -s[0].ray[k];
    }
    ASSERT_REFUSED(RIGCAL_ERR_COINCIDENT, pair,
                   rigcal_pair_make(&pair, s, 2, 0, 1));
}

static void test_what_is_no_pair_is_refused(void)
{
    double ypr[3], wrong[3];
    rigcal_bearing s[6], none[6];
    rigcal_pair pair;

    golden_scene(s, ypr, wrong, 0);
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_pair_make(NULL, s, 6, 0, 1));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, pair,
                   rigcal_pair_make(&pair, NULL, 6, 0, 1));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, pair, rigcal_pair_make(&pair, s, 6, 2, 2));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, pair,
                   rigcal_pair_make(&pair, s, 6, -1, 2));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, pair,
                   rigcal_pair_make(&pair, s, 6, 2, -1));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, pair, rigcal_pair_make(&pair, s, 6, 6, 2));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, pair, rigcal_pair_make(&pair, s, 6, 0, 6));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, pair, rigcal_pair_make(&pair, s, 0, 0, 1));
    for (int i = 0; i < 2; i++) {
        memcpy(none, s, sizeof none);
        none[i].ray[0] = none[i].ray[1] = none[i].ray[2] = 0;
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, pair,
                       rigcal_pair_make(&pair, none, 6, 0, 1));
        for (int k = 0; k < 3; k++) {
            memcpy(none, s, sizeof none);
            none[i].ray[k] = k == 1 ? TEST_NAN : TEST_INF;
            ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, pair,
                           rigcal_pair_make(&pair, none, 6, 0, 1));
            memcpy(none, s, sizeof none);
            none[i].X_w[k] = k == 1 ? -TEST_INF : TEST_NAN;
            ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, pair,
                           rigcal_pair_make(&pair, none, 6, 0, 1));
        }
    }
}

static void test_a_residual_of_what_is_no_pair_or_rotation_is_refused(void)
{
    const rigcal_pair good = pair_of(1, 0, 0, 0, 1, 0);
    rigcal_real M[9], e;

    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_pair_residual(NULL, &good, IDENTITY));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, e,
                   rigcal_pair_residual(&e, NULL, IDENTITY));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, e, rigcal_pair_residual(&e, &good, NULL));
    for (int k = 0; k < 3; k++) {
        rigcal_pair bad = good;

        bad.normal[k] = TEST_NAN;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, e,
                       rigcal_pair_residual(&e, &bad, IDENTITY));
        bad = good;
        bad.offset[k] = TEST_INF;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, e,
                       rigcal_pair_residual(&e, &bad, IDENTITY));
    }
    for (int k = 0; k < 4; k++) { /* not of unit length */
        static const double lengths[4][2] = {
            {2, 1}, {1, -1.5}, {0.9, 1}, {1, 0}};
        const rigcal_pair bad =
            pair_of(lengths[k][0], 0, 0, 0, lengths[k][1], 0);
        const rigcal_real angles[2] = {0, 0};
        rigcal_real pqk[3];

        ASSERT_REFUSED(RIGCAL_ERR_RANGE, e,
                       rigcal_pair_residual(&e, &bad, IDENTITY));
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, pqk,
                       rigcal_pair_coefficients(pqk, &bad, RIGCAL_YAW, angles));
    }
    memcpy(M, IDENTITY, sizeof M);
    M[5] = TEST_NAN;
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, e,
                   rigcal_pair_residual(&e, &good, M));
    M[5] = RC(0.5);
    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, e, rigcal_pair_residual(&e, &good, M));
}

/* ---- choosing pairs ------------------------------------------------------ */

static double image_distance(const rigcal_bearing *a, const rigcal_bearing *b)
{
    return hypot(D(a->ray[0]) / D(a->ray[2]) - D(b->ray[0]) / D(b->ray[2]),
                 D(a->ray[1]) / D(a->ray[2]) - D(b->ray[1]) / D(b->ray[2]));
}

/* The largest distance between two image points. */
static double image_size(const rigcal_bearing s[], int n)
{
    double most = 0;

    for (int i = 0; i < n; i++) {
        for (int j = 0; j < i; j++) {
            most = fmax(most, image_distance(&s[i], &s[j]));
        }
    }
    return most;
}

/* Each pair is the one of its indices, and none is there twice. */
static void assert_pairs_sound(const rigcal_pair pairs[], size_t n_pairs,
                               const rigcal_bearing s[], int n)
{
    for (size_t k = 0; k < n_pairs; k++) {
        const rigcal_pair *p = &pairs[k];
        rigcal_pair own;

        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_pair_make(&own, s, (size_t)n, p->i, p->j));
        for (int c = 0; c < 3; c++) {
            ASSERT_NEAR(own.normal[c], p->normal[c], TOL(1e-13, 1e-4));
            ASSERT_NEAR(own.offset[c], p->offset[c], TOL(1e-13, 1e-4));
        }
        for (size_t l = 0; l < k; l++) {
            TEST_ASSERT_FALSE((p->i == pairs[l].i && p->j == pairs[l].j) ||
                              (p->i == pairs[l].j && p->j == pairs[l].i));
        }
    }
}

static int is_chosen(const rigcal_pair pairs[], size_t n_pairs, int i, int j)
{
    for (size_t k = 0; k < n_pairs; k++) {
        if ((pairs[k].i == i && pairs[k].j == j) ||
            (pairs[k].i == j && pairs[k].j == i)) {
            return 1;
        }
    }
    return 0;
}

static void test_the_count_of_pairs_is_all_of_few_and_four_each_of_many(void)
{
    TEST_ASSERT_EQUAL_UINT(3, rigcal_pairs_for(3));
    TEST_ASSERT_EQUAL_UINT(6, rigcal_pairs_for(4));
    TEST_ASSERT_EQUAL_UINT(28, rigcal_pairs_for(8));
    TEST_ASSERT_EQUAL_UINT(36, rigcal_pairs_for(9));
    TEST_ASSERT_EQUAL_UINT(40, rigcal_pairs_for(10));
    TEST_ASSERT_EQUAL_UINT(400, rigcal_pairs_for(100));
    for (size_t n = 0; n < 50; n++) {
        TEST_ASSERT_EQUAL_UINT(RIGCAL_PAIRS_FOR(n), rigcal_pairs_for(n));
    }
}

/* Up to nine points all pairs but those too close in the image. How exactly the
 * image of the target is measured is left to the library: a factor of two. */
static void test_few_points_are_paired_all_but_where_rays_are_close(void)
{
    test_rng rng = test_seed(32);

    for (int trial = 0; trial < TEST_TRIALS(140); trial++) {
        const int n = 3 + trial % 7;
        test_scene scene;
        rigcal_bearing s[9];
        rigcal_pair pairs[36];
        size_t n_pairs;
        double size;

        test_scene_random(&scene, &rng, n, (test_shape)(trial % 3));
        test_bearings(s, &scene);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_pairs_choose(pairs, 36, &n_pairs, s, (size_t)n));
        TEST_ASSERT_TRUE(n_pairs <= (size_t)(n * (n - 1) / 2));
        assert_pairs_sound(pairs, n_pairs, s, n);
        size = image_size(s, n);
        for (int i = 0; i < n; i++) {
            for (int j = 0; j < i; j++) {
                const double part = image_distance(&s[i], &s[j]) / size;

                if (part > 1.0 / 3) {
                    TEST_ASSERT_TRUE(is_chosen(pairs, n_pairs, i, j));
                }
                if (part < 1.0 / 12 && n_pairs > 3) {
                    TEST_ASSERT_FALSE(is_chosen(pairs, n_pairs, i, j));
                }
            }
        }
    }
}

static void test_many_points_are_paired_a_few_times_each(void)
{
    test_rng rng = test_seed(33);

    for (int trial = 0; trial < TEST_TRIALS(60); trial++) {
        const int n = 10 + trial % (POINTS_MAX - 9);
        test_scene scene;
        rigcal_bearing s[POINTS_MAX];
        rigcal_pair pairs[PAIRS_MAX];
        size_t n_pairs;

        test_scene_random(&scene, &rng, n, (test_shape)(trial % 3));
        test_bearings(s, &scene);
        ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_choose(pairs, PAIRS_MAX, &n_pairs, s, (size_t)n));
        TEST_ASSERT_TRUE(n_pairs <= rigcal_pairs_for((size_t)n));
        TEST_ASSERT_TRUE(n_pairs >= (size_t)(2 * n));
        assert_pairs_sound(pairs, n_pairs, s, n);
        for (int i = 0; i < n; i++) {
            int times = 0;

            for (size_t k = 0; k < n_pairs; k++) {
                times += pairs[k].i == i || pairs[k].j == i;
            }
            TEST_ASSERT_TRUE(times >= 1 && times <= 24);
        }
        for (size_t k = 0; k < n_pairs; k++) {
            TEST_ASSERT_TRUE(image_distance(&s[pairs[k].i], &s[pairs[k].j]) >
                             image_size(s, n) / 12);
        }
    }
}

static void test_pairs_of_thousands_of_points_stay_four_each(void)
{
    enum { MANY = 5000 };
    static rigcal_bearing s[MANY];
    static rigcal_pair pairs[4 * MANY];
    test_rng rng = test_seed(34);
    size_t n_pairs;

    TEST_ON_HOST_ONLY("760 KB");
    for (int i = 0; i < MANY; i++) {
        for (int k = 0; k < 3; k++) {
            s[i].X_w[k] = RC(test_uniform(&rng, -0.5, 0.5));
        }
        s[i].ray[0] = s[i].X_w[0];
        s[i].ray[1] = s[i].X_w[1];
        s[i].ray[2] = s[i].X_w[2] + 4;
    }
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_pairs_choose(pairs, 4 * MANY, &n_pairs, s, MANY));
    TEST_ASSERT_TRUE(n_pairs >= 2 * MANY && n_pairs <= 4 * MANY);
}

static void test_the_same_bearings_give_the_same_pairs(void)
{
    test_rng rng = test_seed(35);
    static rigcal_pair first[PAIRS_MAX], second[PAIRS_MAX];
    test_scene scene;
    rigcal_bearing s[40];
    size_t n_first, n_second;

    test_scene_random(&scene, &rng, 40, TEST_GENERAL);
    test_bearings(s, &scene);
    FILL(first);
    FILL(second);
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_pairs_choose(first, PAIRS_MAX, &n_first, s, 40));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_pairs_choose(second, PAIRS_MAX, &n_second, s, 40));
    TEST_ASSERT_EQUAL_UINT(n_first, n_second);
    TEST_ASSERT_EQUAL_MEMORY(first, second, sizeof first);
}

/* Fewer pairs than wanted are still spread, and nothing is written beyond. */
static void test_a_small_buffer_holds_fewer_pairs_still_spread(void)
{
    static const size_t capacities[5] = {3, 4, 7, 12, 30};
    test_rng rng = test_seed(36);

    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        const size_t capacity = capacities[trial % 5];
        const int n = trial % 2 ? 25 : 8;
        int used[25] = {0}, distinct = 0;
        test_scene scene;
        rigcal_bearing s[25];
        rigcal_pair pairs[31];
        rigcal_pair *guard = &pairs[capacity];
        size_t n_pairs;

        test_scene_random(&scene, &rng, n, (test_shape)(trial % 3));
        test_bearings(s, &scene);
        FILL(pairs);
        ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_choose(pairs, capacity, &n_pairs, s, (size_t)n));
        TEST_ASSERT_TRUE(n_pairs >= 3 && n_pairs <= capacity);
        ASSERT_UNTOUCHED(*guard);
        assert_pairs_sound(pairs, n_pairs, s, n);
        for (size_t k = 0; k < n_pairs; k++) {
            used[pairs[k].i] = used[pairs[k].j] = 1;
        }
        for (int i = 0; i < n; i++) {
            distinct += used[i];
        }
        TEST_ASSERT_TRUE(distinct >= 3);
        TEST_ASSERT_TRUE(capacity < 12 || distinct >= 8);
    }
}

/* cond(A) of two pairs at the truth, the least of the three eliminations. */
static double least_condition(const rigcal_pair pairs[3], const double ypr[3])
{
    double least = 1e300;

    for (int which = RIGCAL_YAW; which <= RIGCAL_ROLL; which++) {
        rigcal_real angles[2];
        rigcal_elimination out;

        other_two(angles, ypr, which);
        if (rigcal_pairs_eliminate(&out, pairs, 3, 2, which, angles) == RIGCAL_OK) {
            least = fmin(least, D(out.condition));
        }
    }
    return least;
}

/* Which two are best depends on angles not yet known. Over many scenes those
 * put first must beat others clearly, and be far from singular in nearly
 * all. */
static void test_the_first_two_pairs_are_well_conditioned(void)
{
    enum { TRIALS = 200 };
    test_rng rng = test_seed(37);
    double first = 0, others = 0;
    int poor = 0;

    TEST_ON_HOST_ONLY("a rate wants all scenes");
    for (int trial = 0; trial < TRIALS; trial++) {
        test_scene scene;
        rigcal_bearing s[8];
        rigcal_pair pairs[28], last[3];
        size_t n_pairs;
        double condition;

        test_scene_random(&scene, &rng, 8, TEST_PLANAR);
        test_bearings(s, &scene);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_pairs_choose(pairs, 28, &n_pairs, s, 8));
        condition = least_condition(pairs, scene.ypr);
        poor += condition > 20;
        first += log(condition);
        memcpy(last, &pairs[n_pairs - 3], sizeof last);
        others += log(least_condition(last, scene.ypr));
    }
    TEST_ASSERT_TRUE(poor < TRIALS / 20);
    TEST_ASSERT_TRUE(first / TRIALS < log(3));
    TEST_ASSERT_TRUE(first / TRIALS < others / TRIALS - 0.2);
}

static void test_repeated_bearings_are_never_paired_with_themselves(void)
{
    test_rng rng = test_seed(38);

    for (int trial = 0; trial < TEST_TRIALS(40); trial++) {
        const int n = trial % 2 ? 7 : 30;
        test_scene scene;
        rigcal_bearing s[30];
        rigcal_pair pairs[120];
        size_t n_pairs;

        test_scene_random(&scene, &rng, n, TEST_GENERAL);
        for (int i = n / 2; i < n; i++) {
            memcpy(scene.X[i], scene.X[i % 3], sizeof scene.X[i]);
            memcpy(scene.xy[i], scene.xy[i % 3], sizeof scene.xy[i]);
        }
        test_bearings(s, &scene);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_pairs_choose(pairs, 120, &n_pairs, s, (size_t)n));
        assert_pairs_sound(pairs, n_pairs, s, n); /* pair_make refuses those */
    }
}

static void test_a_target_far_from_its_origin_is_paired_while_digits_last(void)
{
    test_rng rng = test_seed(39);
    test_scene scene;
    rigcal_bearing s[6];
    rigcal_pair pairs[15];
    size_t n_pairs;

    /* A board of a metre in map coordinates: nanometres in double, half a metre
     * in float. */
    test_scene_random(&scene, &rng, 6, TEST_GENERAL);
    test_bearings(s, &scene);
    for (int i = 0; i < 6; i++) {
        s[i].X_w[0] += RC(512000);
        s[i].X_w[1] += RC(5154500);
    }
    if (RIGCAL_USE_FLOAT) {
        FILL(n_pairs);
        ASSERT_REFUSED(RIGCAL_ERR_PRECISION, pairs,
                       rigcal_pairs_choose(pairs, 15, &n_pairs, s, 6));
        ASSERT_UNTOUCHED(n_pairs);
        return;
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_choose(pairs, 15, &n_pairs, s, 6));
    for (size_t k = 0; k < n_pairs; k++) {
        rigcal_real R[9], e;

        test_to_real(R, scene.R, 9);
        ASSERT_STATUS(RIGCAL_OK, rigcal_pair_residual(&e, &pairs[k], R));
        ASSERT_NEAR(0, e, 2e-8);
    }
    for (int i = 0; i < 6; i++) {
        s[i].X_w[1] += RC(1e15);
    }
    ASSERT_REFUSED(RIGCAL_ERR_PRECISION, pairs,
                   rigcal_pairs_choose(pairs, 15, &n_pairs, s, 6));
}

static void assert_choice_refused(rigcal_status status,
                                  const rigcal_bearing s[], size_t n)
{
    rigcal_pair pairs[36];
    size_t n_pairs;

    FILL(n_pairs);
    ASSERT_REFUSED(status, pairs,
                   rigcal_pairs_choose(pairs, 36, &n_pairs, s, n));
    ASSERT_UNTOUCHED(n_pairs);
}

static void six_bearings(rigcal_bearing s[6], uint64_t seed, test_shape shape)
{
    test_rng rng = test_seed(seed);
    test_scene scene;

    test_scene_random(&scene, &rng, 6, shape);
    test_bearings(s, &scene);
}

static void test_fewer_than_three_distinct_points_or_rays_are_refused(void)
{
    rigcal_bearing good[6], s[6];

    six_bearings(good, 40, TEST_GENERAL);
    for (int distinct = 1; distinct <= 3; distinct++) {
        memcpy(s, good, sizeof s);
        for (int i = distinct; i < 6; i++) {
            memcpy(s[i].X_w, good[i % distinct].X_w, sizeof s[i].X_w);
        }
        if (distinct < 3) {
            assert_choice_refused(RIGCAL_ERR_COINCIDENT, s, 6);
        }
        memcpy(s, good, sizeof s);
        for (int i = distinct; i < 6; i++) {
            for (int k = 0; k < 3; k++) {
                s[i].ray[k] = good[i % distinct].ray[k] * RC(i);
            }
        }
        if (distinct < 3) {
            assert_choice_refused(RIGCAL_ERR_COINCIDENT, s, 6);
        }
    }
}

static void test_points_on_one_line_are_refused(void)
{
    rigcal_bearing good[6], s[6];

    six_bearings(good, 41, TEST_GENERAL);
    for (int n = 3; n <= 6; n++) {
        for (int turn = 0; turn < 3; turn++) {
            memcpy(s, good, sizeof s);
            for (int i = 0; i < n; i++) {
                for (int k = 0; k < 3; k++) {
                    s[i].X_w[k] = RC(turn == k ? 0.25 * i : 0.1 * k * i + 2);
                }
            }
            assert_choice_refused(RIGCAL_ERR_COLLINEAR, s, (size_t)n);
        }
    }
    /* A thousandth of its length off the line is no line. */
    s[3].X_w[2] += RC(0.01);
    {
        rigcal_pair pairs[15];
        size_t n_pairs;

        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_pairs_choose(pairs, 15, &n_pairs, s, 6));
    }
}

static void test_rays_in_one_plane_are_refused(void)
{
    rigcal_bearing good[6], s[6];

    six_bearings(good, 42, TEST_GENERAL);
    for (int n = 3; n <= 6; n++) {
        memcpy(s, good, sizeof s);
        for (int i = 0; i < n; i++) {
            s[i].ray[0] = RC(0.1 * i - 0.2);
            s[i].ray[1] = RC(0.05 - 0.04 * i);
            s[i].ray[2] = 1;
        }
        assert_choice_refused(RIGCAL_ERR_EDGE_ON, s, (size_t)n);
    }
}

/* A telephoto's bundle is narrow and no plane for it. */
static void test_a_narrow_bundle_of_rays_is_accepted(void)
{
    rigcal_bearing s[6];
    rigcal_pair pairs[15];
    size_t n_pairs;

    six_bearings(s, 48, TEST_GENERAL);
    for (int i = 0; i < 6; i++) {
        s[i].ray[0] /= 100;
        s[i].ray[1] /= 100;
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_choose(pairs, 15, &n_pairs, s, 6));
}

/* Points ever nearer to a line: whether they are taken for one does not
 * depend on the unit of length. */
static void test_the_unit_of_length_does_not_decide_what_is_a_line(void)
{
    rigcal_bearing good[6], s[6];
    int lines = 0;

    six_bearings(good, 49, TEST_GENERAL);
    for (int power = 1; power <= 10; power++) {
        rigcal_status of_unit[3];

        for (int unit = 0; unit < 3; unit++) {
            const double scale = unit == 0 ? 1.0 / 4096 : unit == 1 ? 1 : 4096;
            rigcal_pair pairs[15];
            size_t n_pairs;

            memcpy(s, good, sizeof s);
            for (int i = 0; i < 6; i++) {
                s[i].X_w[0] = RC(scale * 0.25 * i);
                s[i].X_w[1] = RC(scale * pow(10, -power) * (i % 3));
                s[i].X_w[2] = 0;
            }
            of_unit[unit] = rigcal_pairs_choose(pairs, 15, &n_pairs, s, 6);
        }
        ASSERT_STATUS(of_unit[1], of_unit[0]);
        ASSERT_STATUS(of_unit[1], of_unit[2]);
        lines += of_unit[1] == RIGCAL_ERR_COLLINEAR;
        if (power < 3) {
            ASSERT_STATUS(RIGCAL_OK, of_unit[1]);
        }
    }
    TEST_ASSERT_TRUE(lines >= 2); /* at the latest 1e-9 of the length */
}

static void test_arguments_of_the_choice_are_checked(void)
{
    rigcal_bearing good[6], s[6];
    rigcal_pair pairs[15];
    size_t n_pairs;

    six_bearings(good, 43, TEST_GENERAL);
    ASSERT_REFUSED(RIGCAL_ERR_NULL, n_pairs,
                   rigcal_pairs_choose(NULL, 15, &n_pairs, good, 6));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, pairs,
                   rigcal_pairs_choose(pairs, 15, NULL, good, 6));
    assert_choice_refused(RIGCAL_ERR_NULL, NULL, 6);
    assert_choice_refused(RIGCAL_ERR_TOO_FEW, good, 2);
    assert_choice_refused(RIGCAL_ERR_TOO_FEW, good, 0);
    assert_choice_refused(RIGCAL_ERR_RANGE, good, ((size_t)1 << 28) + 1);
    FILL(n_pairs);
    ASSERT_REFUSED(RIGCAL_ERR_CAPACITY, pairs,
                   rigcal_pairs_choose(pairs, 2, &n_pairs, good, 6));
    ASSERT_UNTOUCHED(n_pairs);
    ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_choose(pairs, 15, &n_pairs, good, 3));
    TEST_ASSERT_EQUAL_UINT(3, n_pairs);
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < 3; k++) {
            memcpy(s, good, sizeof s);
            s[i].ray[k] = i % 2 ? TEST_NAN : TEST_INF;
            assert_choice_refused(RIGCAL_ERR_NOT_FINITE, s, 6);
            memcpy(s, good, sizeof s);
            s[i].X_w[k] = i % 2 ? -TEST_INF : TEST_NAN;
            assert_choice_refused(RIGCAL_ERR_NOT_FINITE, s, 6);
            s[i].X_w[k] = RC(TOL(-1.1e30, 1.1e9));
            assert_choice_refused(RIGCAL_ERR_RANGE, s, 6);
        }
        memcpy(s, good, sizeof s);
        s[i].ray[0] = s[i].ray[1] = s[i].ray[2] = 0;
        assert_choice_refused(RIGCAL_ERR_RANGE, s, 6);
        s[i].ray[0] = 1; /* 90 degrees off the axis */
        assert_choice_refused(RIGCAL_ERR_WIDE_RAY, s, 6);
        s[i].ray[2] = RC(-0.1);
        assert_choice_refused(RIGCAL_ERR_WIDE_RAY, s, 6);
    }
}

/* ---- elimination (14), (15) ---------------------------------------------- */

static void test_coefficients_are_the_oracles(void)
{
    for (int k = 0; k < SCENE_ROWS; k++) {
        double ypr[3], wrong[3];
        rigcal_bearing s[6];
        rigcal_pair pair;

        golden_scene(s, ypr, wrong, k);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_pair_make(&pair, s, 6, (int32_t)PAIR_TERMS[k][0],
                                       (int32_t)PAIR_TERMS[k][1]));
        for (int which = RIGCAL_YAW; which <= RIGCAL_ROLL; which++) {
            rigcal_real angles[2], pqk[3];

            other_two(angles, wrong, which);
            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_pair_coefficients(pqk, &pair, which, angles));
            ASSERT_ARRAY_NEAR(PAIR_COEFFICIENTS[k] + 3 * which, pqk, 3,
                              TOL_FORMULA);
        }
    }
}

/* p cos w + q sin w + k is the residual for every w, not only the true one. */
static void test_coefficients_give_the_residual_at_any_angle(void)
{
    test_rng rng = test_seed(44);

    for (int k = 0; k < 120; k++) {
        const int which = k % 3;
        double unused[3], ypr[3];
        rigcal_bearing s[6];
        rigcal_pair pair;
        rigcal_real angles[2], pqk[3], R[9], e;

        golden_scene(s, unused, unused, k % SCENE_ROWS);
        ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&pair, s, 6, 0, 1 + k % 5));
        for (int c = 0; c < 3; c++) {
            ypr[c] = test_uniform(&rng, -TEST_PI, TEST_PI);
        }
        rotation_of(R, ypr);
        other_two(angles, ypr, which);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_pair_coefficients(pqk, &pair, which, angles));
        ASSERT_STATUS(RIGCAL_OK, rigcal_pair_residual(&e, &pair, R));
        ASSERT_NEAR(e,
                    D(pqk[0]) * cos(ypr[which]) + D(pqk[1]) * sin(ypr[which]) +
                        D(pqk[2]),
                    TOL(2e-15, 1e-6));
    }
}

/* Yaw eliminated at pitch = roll = 0, where v = d: p = n1 d1 + n2 d2, q = n2
 * d1 - n1 d2, k = n3 d3. Two pairs give 0.64 c = 0.36 and 0.64 s = 0.36, so
 * c = s = 0.5625 and w = 45 degrees; a third, whatever w, leaves 1. */
static void test_an_elimination_on_paper(void)
{
    const rigcal_pair pairs[3] = {
        pair_of(0.8, 0, 0.6, 0.8, 0, -0.6),
        pair_of(0, 0.8, 0.6, 0.8, 0, -0.6),
        pair_of(0, 0, 1, 0, 0, 1),
    };
    const rigcal_real angles[2] = {0, 0};
    const double tol = TOL(1e-15, 1e-6);
    rigcal_elimination out;

    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_pairs_eliminate(&out, pairs, 3, 2, RIGCAL_YAW, angles));
    ASSERT_NEAR(0.5625, out.cosine, tol);
    ASSERT_NEAR(0.5625, out.sine, tol);
    ASSERT_NEAR(TEST_PI / 4, out.angle, tol);
    ASSERT_NEAR(1, out.condition, 4 * tol);
    ASSERT_NEAR(2 * 0.5625 * 0.5625 - 1, out.unit, 2 * tol);
    ASSERT_NEAR(1 + 1 - 2 * 0.5625 * 0.5625, out.residual, 4 * tol);

    /* By least squares the third is in A as a row of zeros, which changes
     * nothing; but now the first two count, each 0.64 cos 45 - 0.36. */
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_pairs_eliminate(&out, pairs, 3, 0, RIGCAL_YAW, angles));
    ASSERT_NEAR(0.5625, out.cosine, tol);
    ASSERT_NEAR(0.5625, out.sine, tol);
    ASSERT_NEAR(2 - 2 * 0.5625 * 0.5625 + 2 * (0.64 * sqrt(0.5) - 0.36),
                out.residual, 4 * tol);
}

/* A = [0.36 0; 0 0.48]: cond 4/3. */
static void test_the_condition_is_that_of_the_spectral_norm(void)
{
    const rigcal_pair pairs[3] = {
        pair_of(0.6, 0, 0.8, 0.6, 0, 0.8),
        pair_of(0, 0.6, 0.8, 0.8, 0, 0.6),
        pair_of(0, 1, 0, 0, 0.6, 0.8),
    };
    const rigcal_real angles[2] = {0, 0};
    rigcal_elimination out;

    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_pairs_eliminate(&out, pairs, 3, 2, RIGCAL_YAW, angles));
    ASSERT_NEAR(4.0 / 3, out.condition, TOL(1e-14, 1e-5));
    /* All three: columns (0.36, 0, 0.6) and (0, 0.48, 0), still orthogonal. */
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_pairs_eliminate(&out, pairs, 3, 0, RIGCAL_YAW, angles));
    ASSERT_NEAR(sqrt(0.4896) / 0.48, out.condition, TOL(1e-14, 1e-5));
}

/* A is fine, but its answer c = s = 0 points nowhere. */
static void test_an_elimination_without_a_direction_is_refused(void)
{
    const rigcal_pair pairs[3] = {
        pair_of(1, 0, 0, 1, 0, 0),
        pair_of(0, 0.6, 0.8, 1, 0, 0),
        pair_of(0, 1, 0, 0, 0.6, 0.8),
    };
    const rigcal_real angles[2] = {0, 0};
    rigcal_elimination out;

    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, out,
                   rigcal_pairs_eliminate(&out, pairs, 3, 2, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, out,
                   rigcal_pairs_eliminate(&out, pairs, 3, 0, RIGCAL_YAW, angles));
}

/* 0.48 c = -0.48 and s = 0: half a turn, whichever zero the sine is. */
static void test_half_a_turn_is_eliminated_as_plus_pi(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        const rigcal_pair pairs[3] = {
            pair_of(0.6, 0, 0.8, 0.8, 0, 0.6),
            pair_of(0, sign, 0, 1, 0, 0),
            pair_of(0, -sign, 0, 1, 0, 0),
        };
        const rigcal_real angles[2] = {0, 0};
        rigcal_elimination out;

        for (int32_t pairs_used = 0; pairs_used <= 2; pairs_used += 2) {
            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_pairs_eliminate(&out, pairs, 3, pairs_used,
                                           RIGCAL_YAW, angles));
            ASSERT_NEAR(TEST_PI, out.angle, TOL(1e-15, 1e-6));
            ASSERT_NEAR(-1, out.cosine, TOL(1e-15, 1e-6));
        }
    }
}

/* c and s are known to cond(A) times rounding, times their own size; (15) has
 * squares of them. Said so in the tolerance, and no more. */
static void assert_elimination(const double expected[6],
                               const rigcal_elimination *seen)
{
    const double size = hypot(expected[1], expected[2]);
    const double tol = TOL(1e-14, 2e-6) * expected[3] * (1 + size);
    double turn = D(seen->angle) - expected[0];

    turn -= 2 * TEST_PI * floor(turn / (2 * TEST_PI) + 0.5);
    TEST_ASSERT_TRUE(D(seen->angle) <= D(RC(TEST_PI)) &&
                     D(seen->angle) > -D(RC(TEST_PI)));
    ASSERT_NEAR(0, turn, tol / size);
    ASSERT_NEAR(expected[1], seen->cosine, tol);
    ASSERT_NEAR(expected[2], seen->sine, tol);
    /* A singular value is known to rounding; the least is cond times
     * smaller. */
    ASSERT_NEAR(expected[3], seen->condition,
                TOL(1e-14, 2e-6) * expected[3] * expected[3]);
    ASSERT_NEAR(expected[4], seen->unit, tol * 2 * (1 + size));
    /* Up to 15 residuals follow the angle. */
    ASSERT_NEAR(expected[5], seen->residual,
                tol * 2 * (1 + size) + 15 * tol / size);
}

static void check_golden_eliminations(const double golden[][18],
                                      int32_t pairs_used)
{
    int well_conditioned = 0;

    for (int k = 0; k < SCENE_ROWS; k++) {
        double ypr[3], wrong[3];
        rigcal_bearing s[6];
        rigcal_pair pairs[15];
        int n_pairs;

        golden_scene(s, ypr, wrong, k);
        n_pairs = golden_pairs(pairs, s, 3 + k % 4);
        for (int which = RIGCAL_YAW; which <= RIGCAL_ROLL; which++) {
            const double *expected = golden[k] + 6 * which;
            rigcal_real angles[2];
            rigcal_elimination out;

            if (expected[3] > TOL(1e7, 300)) {
                continue; /* as good as singular */
            }
            other_two(angles, wrong, which);
            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_pairs_eliminate(&out, pairs, (size_t)n_pairs,
                                           pairs_used, which, angles));
            assert_elimination(expected, &out);
            if (expected[3] < 20) { /* the plain promise */
                well_conditioned++;
                ASSERT_NEAR(expected[5], out.residual,
                            TOL_FORMULA * fmax(1, expected[5]));
            }
        }
    }
    TEST_ASSERT_TRUE(well_conditioned > 2 * SCENE_ROWS);
}

static void test_elimination_by_two_pairs_is_the_oracles(void)
{
    check_golden_eliminations(ELIMINATION_TWO, 2);
}

static void test_elimination_by_all_pairs_is_numpys_least_squares(void)
{
    check_golden_eliminations(ELIMINATION_ALL, 0);
}

static void test_elimination_finds_the_true_angle_of_perfect_images(void)
{
    test_rng rng = test_seed(45);
    int tried = 0;

    for (int trial = 0; trial < TEST_TRIALS(200); trial++) {
        test_scene scene;
        rigcal_bearing s[6];
        rigcal_pair pairs[15];
        size_t n_pairs;

        test_scene_random(&scene, &rng, 3 + trial % 4, TEST_GENERAL);
        test_bearings(s, &scene);
        ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_choose(pairs, 15, &n_pairs, s, (size_t)scene.n));
        for (int which = RIGCAL_YAW; which <= RIGCAL_ROLL; which++) {
            for (int32_t pairs_used = 0; pairs_used <= 2; pairs_used += 2) {
                rigcal_real angles[2];
                rigcal_elimination out;
                rigcal_status status;
                double tol, turn;

                other_two(angles, scene.ypr, which);
                status = rigcal_pairs_eliminate(&out, pairs, n_pairs, pairs_used,
                                          which, angles);
                if (status == RIGCAL_ERR_DEGENERATE ||
                    D(out.condition) > TOL(1e4, 300)) {
                    continue; /* this angle, in this view; few are */
                }
                ASSERT_STATUS(RIGCAL_OK, status);
                tried++;
                /* Rounding of rays a tenth of the image apart, times cond. */
                tol = TOL(1e-13, 5e-5) * D(out.condition);
                turn = D(out.angle) - scene.ypr[which];
                turn -= 2 * TEST_PI * floor(turn / (2 * TEST_PI) + 0.5);
                ASSERT_NEAR(0, turn, tol);
                ASSERT_NEAR(0, out.unit, 2 * tol);
                ASSERT_NEAR(0, out.residual, 20 * tol);
            }
        }
    }
    TEST_ASSERT_TRUE(tried > TEST_TRIALS(1000));
}

static void test_the_order_of_pairs_does_not_matter_to_least_squares(void)
{
    double ypr[3], wrong[3];
    rigcal_bearing s[6];
    rigcal_pair pairs[15], reversed[15];
    rigcal_real angles[2];
    rigcal_elimination first, second;

    golden_scene(s, ypr, wrong, 3);
    golden_pairs(pairs, s, 6);
    for (int k = 0; k < 15; k++) {
        reversed[k] = pairs[14 - k];
    }
    other_two(angles, wrong, RIGCAL_PITCH);
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_pairs_eliminate(&first, pairs, 15, 0, RIGCAL_PITCH, angles));
    ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_eliminate(&second, reversed, 15, 0,
                                              RIGCAL_PITCH, angles));
    ASSERT_NEAR(first.angle, second.angle, TOL(1e-14, 1e-5));
    ASSERT_NEAR(first.condition, second.condition, TOL(1e-13, 1e-4));
    ASSERT_NEAR(first.residual, second.residual, TOL(1e-13, 1e-4));
}

static void test_a_singular_elimination_is_refused(void)
{
    const rigcal_pair twice[3] = {
        pair_of(0.8, 0, 0.6, 0.8, 0, -0.6),
        pair_of(0.8, 0, 0.6, 0.8, 0, -0.6),
        pair_of(0, 0.8, 0.6, 0.8, 0, -0.6),
    };
    /* Planes of rays that contain no x or y, or offsets along the axis: yaw
     * leaves them as they are. */
    const rigcal_pair blind[3] = {
        pair_of(0, 0, 1, 0.6, 0.8, 0),
        pair_of(0, 0, 1, 0.6, 0, 0.8),
        pair_of(0.6, 0.8, 0, 0, 0, 1),
    };
    const rigcal_real angles[2] = {0, 0};
    rigcal_elimination out;

    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, out,
                   rigcal_pairs_eliminate(&out, twice, 3, 2, RIGCAL_YAW, angles));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_pairs_eliminate(&out, twice, 3, 0, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, out,
                   rigcal_pairs_eliminate(&out, blind, 3, 2, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, out,
                   rigcal_pairs_eliminate(&out, blind, 3, 0, RIGCAL_YAW, angles));
}

static void test_arguments_of_the_elimination_are_checked(void)
{
    double ypr[3], wrong[3];
    rigcal_bearing s[6];
    rigcal_pair pairs[15], bad[3];
    rigcal_real angles[2] = {0, 0}, odd[2], pqk[3];
    rigcal_elimination out;

    golden_scene(s, ypr, wrong, 0);
    golden_pairs(pairs, s, 6);
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_pairs_eliminate(NULL, pairs, 3, 2, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, out,
                   rigcal_pairs_eliminate(&out, NULL, 3, 2, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, out,
                   rigcal_pairs_eliminate(&out, pairs, 3, 2, RIGCAL_YAW, NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_pair_coefficients(NULL, pairs, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, pqk,
                   rigcal_pair_coefficients(pqk, NULL, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, pqk,
                   rigcal_pair_coefficients(pqk, pairs, RIGCAL_YAW, NULL));
    for (int32_t which = -1; which <= 4; which++) {
        if (which >= RIGCAL_YAW && which <= RIGCAL_ROLL) {
            continue;
        }
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, out,
                       rigcal_pairs_eliminate(&out, pairs, 3, 2, which, angles));
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, pqk,
                       rigcal_pair_coefficients(pqk, pairs, which, angles));
    }
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, out,
                   rigcal_pairs_eliminate(&out, pairs, 3, 1, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, out,
                   rigcal_pairs_eliminate(&out, pairs, 3, 3, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, out,
                   rigcal_pairs_eliminate(&out, pairs, 3, -2, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, out,
                   rigcal_pairs_eliminate(&out, pairs, 2, 2, RIGCAL_YAW, angles));
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, out,
                   rigcal_pairs_eliminate(&out, pairs, 0, 0, RIGCAL_YAW, angles));
    for (int k = 0; k < 2; k++) {
        odd[k] = TEST_NAN;
        odd[1 - k] = 0;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, out,
                       rigcal_pairs_eliminate(&out, pairs, 3, 2, RIGCAL_YAW, odd));
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, pqk,
                       rigcal_pair_coefficients(pqk, pairs, RIGCAL_YAW, odd));
        odd[k] = -TEST_INF;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, out,
                       rigcal_pairs_eliminate(&out, pairs, 3, 0, RIGCAL_YAW, odd));
    }
    for (int k = 0; k < 3; k++) {
        memcpy(bad, pairs, sizeof bad);
        bad[k].normal[k] = TEST_NAN;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, out,
                       rigcal_pairs_eliminate(&out, bad, 3, 0, RIGCAL_YAW, angles));
        ASSERT_REFUSED(
            RIGCAL_ERR_NOT_FINITE, pqk,
            rigcal_pair_coefficients(pqk, &bad[k], RIGCAL_YAW, angles));
        memcpy(bad, pairs, sizeof bad);
        bad[k].offset[k] = TEST_INF;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, out,
                       rigcal_pairs_eliminate(&out, bad, 3, 2, RIGCAL_YAW, angles));
    }
}

/* ---- three angles (5) ---------------------------------------------------- */

static void test_the_three_angle_residual_is_the_oracles(void)
{
    for (int k = 0; k < SCENE_ROWS; k++) {
        double ypr[3], wrong[3];
        rigcal_bearing s[6];
        rigcal_pair pairs[15];
        rigcal_real angles[3], residual;

        golden_scene(s, ypr, wrong, k);
        golden_pairs(pairs, s, 6);
        test_to_real(angles, wrong, 3);
        ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_residual(&residual, pairs,
                                                             15, angles));
        ASSERT_NEAR(TRANSLATION[k][12], residual, 4 * TOL_FORMULA);
    }
}

static void test_the_three_angle_residual_is_the_sum_over_its_pairs(void)
{
    const rigcal_real angles[3] = {RC(0.3), RC(-0.2), RC(1.1)};
    double ypr[3], wrong[3], sum = 0;
    rigcal_bearing s[6];
    rigcal_pair pairs[15];
    rigcal_real R[9], e, residual;

    golden_scene(s, ypr, wrong, 7);
    golden_pairs(pairs, s, 6);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rotation_from_yaw_pitch_roll(R, angles));
    for (int k = 0; k < 3; k++) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_pair_residual(&e, &pairs[k], R));
        sum += fabs(D(e));
    }
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_pairs_residual(&residual, pairs, 3, angles));
    ASSERT_NEAR(sum, residual, TOL(1e-15, 1e-6));
}

static void test_arguments_of_the_three_angle_residual_are_checked(void)
{
    const rigcal_real zero[3] = {0, 0, 0};
    double ypr[3], wrong[3];
    rigcal_bearing s[6];
    rigcal_pair pairs[15];
    rigcal_real residual;

    golden_scene(s, ypr, wrong, 7);
    golden_pairs(pairs, s, 6);
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_pairs_residual(NULL, pairs, 3, zero));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, residual,
                   rigcal_pairs_residual(&residual, NULL, 3, zero));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, residual,
                   rigcal_pairs_residual(&residual, pairs, 3, NULL));
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, residual,
                   rigcal_pairs_residual(&residual, pairs, 2, zero));
    for (int k = 0; k < 3; k++) {
        rigcal_real bad[3] = {0, 0, 0};

        bad[k] = TEST_INF;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, residual,
                       rigcal_pairs_residual(&residual, pairs, 3, bad));
        bad[k] = RC(TOL(1.1e6, 1.1e3));
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, residual,
                       rigcal_pairs_residual(&residual, pairs, 3, bad));
    }
    pairs[1].offset[2] = TEST_NAN;
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, residual,
                   rigcal_pairs_residual(&residual, pairs, 3, zero));
}

/* ---- translation (10a), (10b), (16) -------------------------------------- */

/* A point ahead and one a unit to the right of it, seen at x = 0 and 1/2: they
 * are 2 away. They do not differ in y, so (10b) is left out. */
static void test_a_translation_on_paper(void)
{
    static const rigcal_bearing s[2] = {{{3, 4, 0}, {0, 0, 1}},
                                         {{4, 4, 0}, {1, 0, 2}}};
    static const double expected[3] = {-3, -4, 2};
    rigcal_pair pair;
    rigcal_real t[3];

    ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&pair, s, 2, 0, 1));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_translation_from_pairs(t, IDENTITY, s, 2, &pair, 1));
    ASSERT_ARRAY_NEAR(expected, t, 3, TOL(1e-15, 1e-6));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_translation_least_squares(t, IDENTITY, s, 2));
    ASSERT_ARRAY_NEAR(expected, t, 3, TOL(1e-14, 1e-5));
}

/* At the rotation of the image and at one well off it. Depths of 3 to 6 for an
 * image of about 0.2 and coordinates of 3: amplified by 15 or so. */
static void test_translations_are_the_oracles(void)
{
    const double tol = 15 * TOL(1e-13, 1e-5);

    for (int k = 0; k < SCENE_ROWS; k++) {
        double at[2][3];
        rigcal_bearing s[6];
        rigcal_pair pairs[15];

        golden_scene(s, at[0], at[1], k);
        golden_pairs(pairs, s, 6);
        for (int i = 0; i < 2; i++) {
            rigcal_real R[9], t[3];

            rotation_of(R, at[i]);
            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_translation_from_pairs(t, R, s, 4, pairs, 6));
            ASSERT_ARRAY_NEAR(TRANSLATION[k] + 3 * i, t, 3, tol);
            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_translation_least_squares(t, R, s, 6));
            ASSERT_ARRAY_NEAR(TRANSLATION[k] + 6 + 3 * i, t, 3, tol);
        }
    }
}

static void test_translations_of_perfect_images_are_true(void)
{
    test_rng rng = test_seed(46);

    for (int trial = 0; trial < TEST_TRIALS(150); trial++) {
        const int n = 3 + trial % 20;
        test_scene scene;
        rigcal_bearing s[22];
        rigcal_pair pairs[88];
        size_t n_pairs;
        rigcal_real R[9], t[3];

        test_scene_random(&scene, &rng, n, (test_shape)(trial % 3));
        test_bearings(s, &scene);
        for (int i = 0; i < n; i++) { /* rays of any length */
            const double length = test_uniform(&rng, 0.1, 9);

            for (int k = 0; k < 3; k++) {
                s[i].ray[k] *= RC(length);
            }
        }
        test_to_real(R, scene.R, 9);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_pairs_choose(pairs, 88, &n_pairs, s, (size_t)n));
        ASSERT_STATUS(RIGCAL_OK, rigcal_translation_from_pairs(
                                     t, R, s, (size_t)n, pairs, n_pairs));
        /* Each equation of a pair is as good as its coordinates differ. */
        ASSERT_ARRAY_NEAR(scene.t, t, 3, TOL(1e-10, 0.05));
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_translation_least_squares(t, R, s, (size_t)n));
        ASSERT_ARRAY_NEAR(scene.t, t, 3, TOL(1e-11, 5e-3));
    }
}

/* Double the target and its camera is twice as far. */
static void test_translation_scales_with_the_target(void)
{
    double ypr[3], wrong[3], t_once[3];
    rigcal_bearing s[6];
    rigcal_real R[9], t[3];

    golden_scene(s, ypr, wrong, 9);
    rotation_of(R, wrong);
    ASSERT_STATUS(RIGCAL_OK, rigcal_translation_least_squares(t, R, s, 6));
    test_to_double(t_once, t, 3);
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < 3; k++) {
            s[i].X_w[k] *= 1024;
        }
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_translation_least_squares(t, R, s, 6));
    for (int k = 0; k < 3; k++) {
        ASSERT_NEAR(1024 * t_once[k], t[k], TOL(1e-9, 0.5));
    }
}

static void test_a_translation_far_from_the_origin_keeps_its_digits(void)
{
    test_rng rng = test_seed(47);
    const double far[3] = {512000, 5154500, 1200};
    double back[3];
    test_scene scene;
    rigcal_bearing s[6];
    rigcal_real R[9], t[3];

    if (RIGCAL_USE_FLOAT) {
        return; /* half a metre a digit: nothing to keep */
    }
    test_scene_random(&scene, &rng, 6, TEST_GENERAL);
    test_bearings(s, &scene);
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < 3; k++) {
            s[i].X_w[k] += RC(far[k]);
        }
    }
    test_to_real(R, scene.R, 9);
    ASSERT_STATUS(RIGCAL_OK, rigcal_translation_least_squares(t, R, s, 6));
    /* Seen from the target again, t + R far is the camera's own. A nanometre of
     * rounding, times distance over size. */
    test_apply(back, scene.R, far, NULL);
    for (int k = 0; k < 3; k++) {
        ASSERT_NEAR(scene.t[k], D(t[k]) + back[k], 2e-7);
    }
}

static void test_rays_that_fix_no_translation_are_refused(void)
{
    rigcal_bearing s[3] = {{{0, 0, 0}, {RC(0.1), RC(0.2), 1}},
                            {{1, 0, 0}, {RC(0.2), RC(0.4), 2}},
                            {{0, 1, 0}, {RC(0.1), RC(0.2), 1}}};
    rigcal_pair pairs[2] = {pair_of(1, 0, 0, 0, 1, 0),
                            pair_of(0, 1, 0, 1, 0, 0)};
    rigcal_real t[3];

    pairs[1].j = 2;
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, t,
                   rigcal_translation_from_pairs(t, IDENTITY, s, 3, pairs, 2));
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, t,
                   rigcal_translation_least_squares(t, IDENTITY, s, 3));
    s[1].ray[1] = 1; /* now they differ in y, and that is enough */
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_translation_from_pairs(t, IDENTITY, s, 3, pairs, 2));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_translation_least_squares(t, IDENTITY, s, 3));
}

static void assert_both_translations_refuse(rigcal_status status,
                                            const rigcal_real R[9],
                                            const rigcal_bearing s[], size_t n,
                                            const rigcal_pair pairs[])
{
    rigcal_real t[3];

    ASSERT_REFUSED(status, t,
                   rigcal_translation_from_pairs(t, R, s, n, pairs, 3));
    ASSERT_REFUSED(status, t, rigcal_translation_least_squares(t, R, s, n));
}

static void test_arguments_of_the_translation_are_checked(void)
{
    double ypr[3], wrong[3];
    rigcal_bearing good[6], s[6];
    rigcal_pair pairs[15], bad[3];
    rigcal_real M[9], t[3];

    golden_scene(good, ypr, wrong, 0);
    golden_pairs(pairs, good, 3);
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_translation_from_pairs(
                                       NULL, IDENTITY, good, 6, pairs, 3));
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_translation_least_squares(NULL, IDENTITY, good, 6));
    ASSERT_REFUSED(
        RIGCAL_ERR_NULL, t,
        rigcal_translation_from_pairs(t, IDENTITY, good, 6, NULL, 3));
    assert_both_translations_refuse(RIGCAL_ERR_NULL, NULL, good, 6, pairs);
    assert_both_translations_refuse(RIGCAL_ERR_NULL, IDENTITY, NULL, 6, pairs);
    assert_both_translations_refuse(RIGCAL_ERR_TOO_FEW, IDENTITY, good, 1,
                                    pairs);
    assert_both_translations_refuse(RIGCAL_ERR_TOO_FEW, IDENTITY, good, 0,
                                    pairs);
    assert_both_translations_refuse(RIGCAL_ERR_RANGE, IDENTITY, good,
                                    ((size_t)1 << 28) + 1, pairs);
    ASSERT_REFUSED(
        RIGCAL_ERR_TOO_FEW, t,
        rigcal_translation_from_pairs(t, IDENTITY, good, 6, pairs, 0));
    for (int k = 0; k < 9; k++) {
        memcpy(M, IDENTITY, sizeof M);
        M[k] = TEST_NAN;
        assert_both_translations_refuse(RIGCAL_ERR_NOT_FINITE, M, good, 6,
                                        pairs);
        M[k] = RC(0.3);
        assert_both_translations_refuse(RIGCAL_ERR_ROTATION, M, good, 6, pairs);
    }
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            memcpy(s, good, sizeof s);
            s[i].X_w[k] = TEST_INF;
            assert_both_translations_refuse(RIGCAL_ERR_NOT_FINITE, IDENTITY, s,
                                            6, pairs);
            memcpy(s, good, sizeof s);
            s[i].ray[k] = TEST_NAN;
            assert_both_translations_refuse(RIGCAL_ERR_NOT_FINITE, IDENTITY, s,
                                            6, pairs);
        }
        memcpy(s, good, sizeof s);
        s[i].ray[0] = s[i].ray[1] = s[i].ray[2] = 0;
        assert_both_translations_refuse(RIGCAL_ERR_RANGE, IDENTITY, s, 6,
                                        pairs);
        s[i].ray[1] = 1;
        assert_both_translations_refuse(RIGCAL_ERR_WIDE_RAY, IDENTITY, s, 6,
                                        pairs);
        memcpy(bad, pairs, sizeof bad);
        bad[i].i = 6;
        ASSERT_REFUSED(
            RIGCAL_ERR_RANGE, t,
            rigcal_translation_from_pairs(t, IDENTITY, good, 6, bad, 3));
        bad[i].i = 0;
        bad[i].j = 6;
        ASSERT_REFUSED(
            RIGCAL_ERR_RANGE, t,
            rigcal_translation_from_pairs(t, IDENTITY, good, 6, bad, 3));
        bad[i].j = -1;
        ASSERT_REFUSED(
            RIGCAL_ERR_RANGE, t,
            rigcal_translation_from_pairs(t, IDENTITY, good, 6, bad, 3));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_pair_is_a_plane_of_rays_and_a_direction);
    RUN_TEST(test_pairs_and_their_residuals_are_the_oracles);
    RUN_TEST(test_a_pair_does_not_depend_on_the_length_of_its_rays);
    RUN_TEST(test_a_pair_taken_the_other_way_round_is_the_same_equation);
    RUN_TEST(test_the_residual_vanishes_at_the_true_rotation);
    RUN_TEST(test_a_pair_of_one_point_or_one_ray_carries_no_equation);
    RUN_TEST(test_what_is_no_pair_is_refused);
    RUN_TEST(test_a_residual_of_what_is_no_pair_or_rotation_is_refused);
    RUN_TEST(test_the_count_of_pairs_is_all_of_few_and_four_each_of_many);
    RUN_TEST(test_few_points_are_paired_all_but_where_rays_are_close);
    RUN_TEST(test_many_points_are_paired_a_few_times_each);
    RUN_TEST(test_pairs_of_thousands_of_points_stay_four_each);
    RUN_TEST(test_the_same_bearings_give_the_same_pairs);
    RUN_TEST(test_a_small_buffer_holds_fewer_pairs_still_spread);
    RUN_TEST(test_the_first_two_pairs_are_well_conditioned);
    RUN_TEST(test_repeated_bearings_are_never_paired_with_themselves);
    RUN_TEST(test_a_target_far_from_its_origin_is_paired_while_digits_last);
    RUN_TEST(test_fewer_than_three_distinct_points_or_rays_are_refused);
    RUN_TEST(test_points_on_one_line_are_refused);
    RUN_TEST(test_rays_in_one_plane_are_refused);
    RUN_TEST(test_a_narrow_bundle_of_rays_is_accepted);
    RUN_TEST(test_the_unit_of_length_does_not_decide_what_is_a_line);
    RUN_TEST(test_arguments_of_the_choice_are_checked);
    RUN_TEST(test_coefficients_are_the_oracles);
    RUN_TEST(test_coefficients_give_the_residual_at_any_angle);
    RUN_TEST(test_an_elimination_on_paper);
    RUN_TEST(test_the_condition_is_that_of_the_spectral_norm);
    RUN_TEST(test_an_elimination_without_a_direction_is_refused);
    RUN_TEST(test_half_a_turn_is_eliminated_as_plus_pi);
    RUN_TEST(test_elimination_by_two_pairs_is_the_oracles);
    RUN_TEST(test_elimination_by_all_pairs_is_numpys_least_squares);
    RUN_TEST(test_elimination_finds_the_true_angle_of_perfect_images);
    RUN_TEST(test_the_order_of_pairs_does_not_matter_to_least_squares);
    RUN_TEST(test_a_singular_elimination_is_refused);
    RUN_TEST(test_arguments_of_the_elimination_are_checked);
    RUN_TEST(test_the_three_angle_residual_is_the_oracles);
    RUN_TEST(test_the_three_angle_residual_is_the_sum_over_its_pairs);
    RUN_TEST(test_arguments_of_the_three_angle_residual_are_checked);
    RUN_TEST(test_a_translation_on_paper);
    RUN_TEST(test_translations_are_the_oracles);
    RUN_TEST(test_translations_of_perfect_images_are_true);
    RUN_TEST(test_translation_scales_with_the_target);
    RUN_TEST(test_a_translation_far_from_the_origin_keeps_its_digits);
    RUN_TEST(test_rays_that_fix_no_translation_are_refused);
    RUN_TEST(test_arguments_of_the_translation_are_checked);
}
