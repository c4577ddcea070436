/* pairs: the equation of one pair (11) to (13), and the choice of pairs. */
#include <math.h>
#include <string.h>

#include "rc_pairs.h"
#include "test_equations.h"

enum { POINTS_MAX = TEST_SCENE_MAX, PAIRS_MAX = 4 * POINTS_MAX };

static const rigcal_real IDENTITY[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

/* ---- one pair ------------------------------------------------------------ */

/* Rays straight ahead and 45 degrees to the right span the plane y = 0. */
static void test_a_pair_is_a_plane_of_rays_and_a_direction(void)
{
    static const rigcal_bearing s[2] = {{{5, 7, 0}, {0, 0, 1}}, {{6, 7, 0}, {1, 0, 1}}};
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

static void test_a_pair_does_not_depend_on_the_length_of_its_rays(void)
{
    const double lengths[3] = {0.01, 300, TOL(1e9, 1e6)};
    double ypr[3], wrong[3], normal[3];
    rigcal_bearing s[6];
    rigcal_pair pair;

    test_golden_scene(s, ypr, wrong, 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&pair, s, 6, 0, 1));
    test_to_double(normal, pair.normal, 3);
    for (int i = 0; i < 3; i++) {
        test_golden_scene(s, ypr, wrong, 0);
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

    test_golden_scene(s, ypr, wrong, 1);
    test_rotation_of(R, wrong);
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

static void test_a_pair_of_one_point_or_one_ray_carries_no_equation(void)
{
    rigcal_bearing s[2] = {{{1000, 2, 3}, {RC(0.1), RC(0.2), 1}},
                           {{1000, 2, 3}, {RC(0.3), RC(0.1), 1}}};
    rigcal_pair pair;

    ASSERT_REFUSED(RIGCAL_ERR_COINCIDENT, pair, rigcal_pair_make(&pair, s, 2, 0, 1));
    /* Coordinates that differ by one rounding give no direction either. */
    s[1].X_w[0] = RC(1000 + TOL(1.2e-13, 6.2e-5));
    ASSERT_REFUSED(RIGCAL_ERR_COINCIDENT, pair, rigcal_pair_make(&pair, s, 2, 0, 1));
    s[1].X_w[0] = 1001;
    ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&pair, s, 2, 0, 1));
    for (int k = 0; k < 3; k++) {
        s[1].ray[k] = 4 * s[0].ray[k];
    }
    ASSERT_REFUSED(RIGCAL_ERR_COINCIDENT, pair, rigcal_pair_make(&pair, s, 2, 0, 1));
    for (int k = 0; k < 3; k++) {
        s[1].ray[k] = s[0].ray[k] / 3;
    }
    ASSERT_REFUSED(RIGCAL_ERR_COINCIDENT, pair, rigcal_pair_make(&pair, s, 2, 0, 1));
    for (int k = 0; k < 3; k++) {
        s[1].ray[k] = -s[0].ray[k];
    }
    ASSERT_REFUSED(RIGCAL_ERR_COINCIDENT, pair, rigcal_pair_make(&pair, s, 2, 0, 1));
}

static void test_what_is_no_pair_is_refused(void)
{
    double ypr[3], wrong[3];
    rigcal_bearing s[6], none[6];
    rigcal_pair pair;

    test_golden_scene(s, ypr, wrong, 0);
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_pair_make(NULL, s, 6, 0, 1));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, pair, rigcal_pair_make(&pair, NULL, 6, 0, 1));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, pair, rigcal_pair_make(&pair, s, 6, 2, 2));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, pair, rigcal_pair_make(&pair, s, 6, -1, 2));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, pair, rigcal_pair_make(&pair, s, 6, 2, -1));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, pair, rigcal_pair_make(&pair, s, 6, 6, 2));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, pair, rigcal_pair_make(&pair, s, 6, 0, 6));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, pair, rigcal_pair_make(&pair, s, 0, 0, 1));
    for (int i = 0; i < 2; i++) {
        memcpy(none, s, sizeof none);
        none[i].ray[0] = none[i].ray[1] = none[i].ray[2] = 0;
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, pair, rigcal_pair_make(&pair, none, 6, 0, 1));
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

/* Each pair must be the one of its indices, and none may occur twice. */
static void assert_pairs_sound(const rigcal_pair pairs[], size_t n_pairs,
                               const rigcal_bearing s[], int n)
{
    for (size_t k = 0; k < n_pairs; k++) {
        const rigcal_pair *p = &pairs[k];
        rigcal_pair own;

        ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&own, s, (size_t)n, p->i, p->j));
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
        if ((pairs[k].i == i && pairs[k].j == j) || (pairs[k].i == j && pairs[k].j == i)) {
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

/* With up to nine points all pairs are used, except those too close in the image. The
 * library may measure the image of the target in its own way, within a factor of two. */
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
        ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_choose(pairs, 36, &n_pairs, s, (size_t)n));
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
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_pairs_choose(pairs, PAIRS_MAX, &n_pairs, s, (size_t)n));
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
    ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_choose(pairs, 4 * MANY, &n_pairs, s, MANY));
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
    ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_choose(first, PAIRS_MAX, &n_first, s, 40));
    ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_choose(second, PAIRS_MAX, &n_second, s, 40));
    TEST_ASSERT_EQUAL_UINT(n_first, n_second);
    TEST_ASSERT_EQUAL_MEMORY(first, second, sizeof first);
}

static void assert_choice_refused(rigcal_status status, const rigcal_bearing s[], size_t n)
{
    rigcal_pair pairs[36];
    size_t n_pairs;

    FILL(n_pairs);
    ASSERT_REFUSED(status, pairs, rigcal_pairs_choose(pairs, 36, &n_pairs, s, n));
    ASSERT_UNTOUCHED(n_pairs);
}

/* Which pairs are chosen, stated once more. Few points: all pairs, of distant indices
 * first. Many: the points in the order of a generator of period 2^k; round r pairs each
 * with the one r places later; at most 8 rounds. Only pairs whose rays are apart by a sixth
 * of the image count. */
typedef struct {
    int i[PAIRS_MAX], j[PAIRS_MAX], n, capacity;
    const rigcal_bearing *s;
    double nearest;
} own_list;

static double sphere_distance(const rigcal_bearing *a, const rigcal_bearing *b)
{
    double p[3], q[3], d[3];

    test_to_double(p, a->ray, 3);
    test_to_double(q, b->ray, 3);
    for (int k = 0; k < 3; k++) {
        d[k] = p[k] / test_norm(p) - q[k] / test_norm(q);
    }
    return test_norm(d);
}

static int farthest_ray(const rigcal_bearing s[], int n, int from)
{
    int far = from;

    for (int i = 0; i < n; i++) {
        far =
            sphere_distance(&s[i], &s[from]) > sphere_distance(&s[far], &s[from]) ? i : far;
    }
    return far;
}

static void own_add(own_list *list, int i, int j)
{
    if (list->n < list->capacity &&
        sphere_distance(&list->s[i], &list->s[j]) >= list->nearest) {
        list->i[list->n] = i;
        list->j[list->n++] = j;
    }
}

static void own_choice(own_list *list, int n)
{
    int order[POINTS_MAX], at = 0, count = 0, period = 1;

    for (int apart = n - 1; apart >= 1 && n <= 9; apart--) {
        for (int i = 0; i + apart < n; i++) {
            own_add(list, i, i + apart);
        }
    }
    while (period < n) {
        period *= 2;
    }
    while (count < n) {
        at = (int)(((uint64_t)at * 1664525 + 1013904223) % (uint64_t)period);
        if (at < n) {
            order[count++] = at;
        }
    }
    for (int r = 1; r <= 8 && 2 * r < n && n > 9; r++) {
        for (int i = 0; i < n; i++) {
            own_add(list, order[i], order[(i + r) % n]);
        }
    }
}

/* How well pair k fixes an angle together with the first pair. */
static double worth_with_first(const rigcal_pair pairs[], int k, const rigcal_bearing s[])
{
    double a[3], b[3], normals[3], offsets[3];

    test_to_double(a, pairs[0].normal, 3);
    test_to_double(b, pairs[k].normal, 3);
    test_cross(normals, a, b);
    test_to_double(a, pairs[0].offset, 3);
    test_to_double(b, pairs[k].offset, 3);
    test_cross(offsets, a, b);
    return test_norm(normals) * test_norm(offsets) *
           sphere_distance(&s[pairs[k].i], &s[pairs[k].j]);
}

/* The list of the test, with the places of the longest pair and of its best partner
 * exchanged, is that of the library, to the order. */
static void assert_own_choice(const rigcal_bearing s[], int n, int capacity)
{
    rigcal_pair pairs[PAIRS_MAX];
    own_list own;
    size_t n_pairs;
    int at[2] = {0, 1};

    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_pairs_choose(pairs, (size_t)capacity, &n_pairs, s, (size_t)n));
    const int a = farthest_ray(s, n, 0), b = farthest_ray(s, n, a);
    own.s = s;
    own.n = 0;
    own.capacity = capacity < 4 * n ? capacity : 4 * n;
    own.nearest = sphere_distance(&s[a], &s[b]) / 6;
    own_choice(&own, n);
    TEST_ASSERT_EQUAL_INT(own.n, n_pairs);
    for (int k = 0; k < own.n; k++) {
        const rigcal_bearing *const first[2] = {&s[pairs[0].i], &s[pairs[0].j]};
        TEST_ASSERT_TRUE(sphere_distance(&s[own.i[k]], &s[own.j[k]]) <=
                         sphere_distance(first[0], first[1]) + TOL(1e-15, 1e-6));
        TEST_ASSERT_TRUE(k == 0 || worth_with_first(pairs, k, s) <=
                                       worth_with_first(pairs, 1, s) + TOL(1e-14, 1e-5));
    }
    for (int place = 0; place < 2; place++) { /* undoes what put_best_first exchanged */
        for (at[place] = place;
             own.i[at[place]] != pairs[place].i || own.j[at[place]] != pairs[place].j;
             at[place]++) {
            TEST_ASSERT_LESS_THAN_INT(own.n - 1, at[place]);
        }
        own.i[at[place]] = own.i[place];
        own.j[at[place]] = own.j[place];
    }
    for (int k = 2; k < own.n; k++) {
        TEST_ASSERT_EQUAL_INT32(own.i[k], pairs[k].i);
        TEST_ASSERT_EQUAL_INT32(own.j[k], pairs[k].j);
    }
}

static void test_the_pairs_are_those_of_the_rule(void)
{
    static const int POINTS[8] = {3, 4, 9, 10, 16, 17, 33, POINTS_MAX};
    test_rng rng = test_seed(51);

    TEST_WANTS_RAM(PAIRS_MAX * (sizeof(rigcal_pair) + 2 * sizeof(int)) + 12000);
    for (int trial = 0; trial < TEST_TRIALS(96); trial++) {
        const int n = POINTS[trial % 8] < POINTS_MAX ? POINTS[trial % 8] : POINTS_MAX;
        test_scene scene;
        rigcal_bearing s[POINTS_MAX];

        test_scene_random(&scene, &rng, n, trial / 8 % 2 ? TEST_GENERAL : TEST_PLANAR);
        if (n < 9) { /* far apart, so that enough pairs are left */
            for (int i = 0; i < n; i++) {
                scene.xy[i][0] = 0.3 * cos(2 * TEST_PI * i / n + 0.2) + 0.01 * i;
                scene.xy[i][1] = 0.3 * sin(2 * TEST_PI * i / n + 0.2);
            }
        } else if (trial / 8 % 3 ==
                   0) { /* most are near: eight rounds do not fill the list */
            for (int i = 0; i < n * 4 / 5; i++) {
                scene.xy[i][0] = 0.1 * scene.xy[i][0] + 0.05;
                scene.xy[i][1] = 0.1 * scene.xy[i][1] - 0.02;
            }
        }
        test_bearings(s, &scene);
        assert_own_choice(s, n, trial / 16 % 2 && n > 3 ? n : PAIRS_MAX);
    }
}

static void six_bearings(rigcal_bearing s[6], uint64_t seed, test_shape shape)
{
    test_rng rng = test_seed(seed);
    test_scene scene;

    test_scene_random(&scene, &rng, 6, shape);
    test_bearings(s, &scene);
}

/* Also where every coordinate is tiny. */
static void test_a_tiny_target_is_paired_as_a_large_one(void)
{
    rigcal_bearing s[6];
    rigcal_pair pairs[15], tiny[15];
    size_t n_pairs, n_tiny;

    six_bearings(s, 52, TEST_GENERAL);
    ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_choose(pairs, 15, &n_pairs, s, 6));
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < 3; k++) { /* by a power of two: the same digits */
            s[i].X_w[k] *= RC(TOL(ldexp(1, -80), ldexp(1, -40)));
        }
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_choose(tiny, 15, &n_tiny, s, 6));
    TEST_ASSERT_EQUAL(n_pairs, n_tiny);
    for (size_t k = 0; k < n_pairs; k++) {
        TEST_ASSERT_EQUAL_INT32(pairs[k].i, tiny[k].i);
        TEST_ASSERT_EQUAL_INT32(pairs[k].j, tiny[k].j);
        for (int c = 0; c < 3; c++) {
            ASSERT_NEAR(D(pairs[k].offset[c]), tiny[k].offset[c], 0);
        }
    }
}

/* The first pair is wrong, so no other is read. */
static void test_there_are_at_most_four_pairs_of_2_to_the_28_points(void)
{
    const rigcal_pair first = {{TEST_NAN, 0, 1}, {1, 0, 0}, 0, 1};
    const size_t most = 4 * RC_COUNT_MAX;

    if (RC_COUNT_MAX > SIZE_MAX / 8) {
        TEST_IGNORE_MESSAGE("this size_t counts no more");
    }
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rc_check_pairs(&first, most, 2));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rc_check_pairs(&first, most + 1, 2));
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rc_check_pairs(&first, 2, 2));
    ASSERT_STATUS(RIGCAL_ERR_TOO_FEW, rc_check_pairs(&first, 1, 2));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rc_check_pairs(NULL, 2, 2));
}

/* Each vector of each pair: its numbers, and its length, whose square is 1 to 0.002. */
static void test_vectors_of_pairs_are_units(void)
{
    static const double LENGTH[4] = {0.9989, 0.9991, 1.0009, 1.0011};
    rigcal_pair pairs[3];

    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < 3; k++) {
            for (int p = 0; p < 3; p++) {
                pairs[p] = (rigcal_pair){{0, 1, 0}, {0, 0, 1}, 0, 1};
            }
            rigcal_real *const v = i % 2 ? pairs[i / 2].normal : pairs[i / 2].offset;
            v[k] = TEST_INF;
            ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rc_check_pairs(pairs, 3, 3));
            for (int way = 0; way < 4; way++) {
                rc_clear(v, 3);
                v[k] = RC(LENGTH[way]);
                ASSERT_STATUS(way % 3 ? RIGCAL_OK : RIGCAL_ERR_RANGE,
                              rc_check_pairs(pairs, 3, 3));
            }
        }
    }
}

/* Points 8 roundings apart are one, in one place or at the ends of a line. */
static void test_points_are_the_same_up_to_eight_roundings(void)
{
    const rigcal_real eps = RC(TOL(2.220446049250313e-16, 1.1920928955078125e-7));
    rigcal_bearing s[3] = {
        {{0, 0, 0}, {0, 0, 1}}, {{1, 0, 0}, {RC(0.1), 0, 1}}, {{0, 0, 0}, {0, RC(0.1), 1}}};
    rigcal_pair pair;

    ASSERT_REFUSED(RIGCAL_ERR_COINCIDENT, pair, rigcal_pair_make(&pair, s, 3, 0, 2));
    for (int end = 0; end < 2; end++) { /* 1 - 8 eps and 1 - 16 eps are exact */
        s[2].X_w[0] = end ? 1 - 8 * eps : 8 * eps;
        assert_choice_refused(RIGCAL_ERR_COINCIDENT, s, 3);
        s[2].X_w[0] = end ? 1 - 16 * eps : 16 * eps;
        assert_choice_refused(RIGCAL_ERR_COLLINEAR, s, 3);
    }
    s[2].X_w[0] = 1 - 8 * eps; /* the largest coordinate is 1 */
    ASSERT_REFUSED(RIGCAL_ERR_COINCIDENT, pair, rigcal_pair_make(&pair, s, 3, 1, 2));
    ASSERT_REFUSED(RIGCAL_ERR_COINCIDENT, pair, rigcal_pair_make(&pair, s, 3, 2, 1));
    s[2].X_w[0] = 1 - 9 * eps;
    ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&pair, s, 3, 1, 2));
}

/* The sine of the angle between (0, 0, 1) and (x, 0, 1) is x, for an x whose square is
 * below the rounding of 1. */
static void test_rays_are_the_same_up_to_eight_roundings(void)
{
    const rigcal_real eps = RC(TOL(2.220446049250313e-16, 1.1920928955078125e-7));
    rigcal_bearing s[2] = {{{0, 0, 0}, {0, 0, 1}}, {{1, 0, 0}, {8 * eps, 0, 1}}};
    rigcal_pair pair;

    ASSERT_REFUSED(RIGCAL_ERR_COINCIDENT, pair, rigcal_pair_make(&pair, s, 2, 0, 1));
    ASSERT_REFUSED(RIGCAL_ERR_COINCIDENT, pair, rigcal_pair_make(&pair, s, 2, 1, 0));
    s[1].ray[0] = 9 * eps;
    ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&pair, s, 2, 0, 1));
    ASSERT_STATUS(RIGCAL_OK, rigcal_pair_make(&pair, s, 2, 1, 0));
}

/* Coordinates whose rounding is 1e-4 of the length of 1, to the last bit, still do. */
static void test_the_digits_that_a_target_needs(void)
{
    const rigcal_real most =
        RC(1e-4) / RC(TOL(2.220446049250313e-16, 1.1920928955078125e-7));

    for (int more = 0; more < 2; more++) {
        const rigcal_real far = RC(TOL(1 + 1e-15, 1 + 2e-7));
        const rigcal_real x = more ? most * far : most;
        const rigcal_bearing s[3] = {{{x, 0, 0}, {0, 0, 1}},
                                     {{x, 1, 0}, {RC(0.1), 0, 1}},
                                     {{x, RC(0.5), RC(0.25)}, {0, RC(0.1), 1}}};
        rigcal_pair pairs[3];
        size_t n_pairs;

        ASSERT_STATUS(more ? RIGCAL_ERR_PRECISION : RIGCAL_OK,
                      rigcal_pairs_choose(pairs, 3, &n_pairs, s, 3));
    }
}

/* What is wrong with the points is told before what is wrong with the rays. */
static void test_points_in_one_place_are_told_before_rays_in_a_plane(void)
{
    rigcal_bearing s[4];

    for (int i = 0; i < 4; i++) {
        rc_clear(s[i].X_w, 3);
        s[i].X_w[0] = 2;
        s[i].ray[0] = RC(0.1 * i);
        s[i].ray[1] = 0;
        s[i].ray[2] = 1;
    }
    assert_choice_refused(RIGCAL_ERR_COINCIDENT, s, 4);
}

/* A smaller number of pairs is still spread out, and nothing is written beyond it. */
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
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_pairs_choose(pairs, capacity, &n_pairs, s, (size_t)n));
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

/* cond(A) of two pairs at the truth: the least of the three eliminations. */
static double least_condition(const rigcal_pair pairs[3], const double ypr[3])
{
    double least = 1e300;

    for (int which = RIGCAL_YAW; which <= RIGCAL_ROLL; which++) {
        rigcal_real angles[2];
        rigcal_elimination out;

        test_other_two(angles, ypr, which);
        if (rigcal_pairs_eliminate(&out, pairs, 3, 2, which, angles) == RIGCAL_OK) {
            least = fmin(least, D(out.condition));
        }
    }
    return least;
}

/* The best two depend on angles that are not known yet. Over many scenes the first two must
 * be clearly better than others, and far from singular in nearly all scenes. */
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
        ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_choose(pairs, 28, &n_pairs, s, 8));
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
        ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_choose(pairs, 120, &n_pairs, s, (size_t)n));
        assert_pairs_sound(pairs, n_pairs, s, n); /* pair_make refuses these */
    }
}

static void test_a_target_far_from_its_origin_is_paired_while_digits_last(void)
{
    test_rng rng = test_seed(39);
    test_scene scene;
    rigcal_bearing s[6];
    rigcal_pair pairs[15];
    size_t n_pairs;

    /* A board of one metre in map coordinates. Rounding is nanometres in double, half a
     * metre in float. */
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
    /* A point off the line by a thousandth of its length: this is no line. */
    s[3].X_w[2] += RC(0.01);
    {
        rigcal_pair pairs[15];
        size_t n_pairs;

        ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_choose(pairs, 15, &n_pairs, s, 6));
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

static void test_rays_in_one_plane_are_refused_however_near(void)
{
    rigcal_bearing s[6];

    six_bearings(s, 42, TEST_GENERAL);
    for (int i = 0; i < 6; i++) {
        s[i].ray[0] = RC(TOL(1e-10, 1e-3) * i); /* a plane to the last bit */
        s[i].ray[1] = 0;
        s[i].ray[2] = 1;
    }
    assert_choice_refused(RIGCAL_ERR_EDGE_ON, s, 6);
}

/* The rays of a telephoto lens form a narrow bundle, but not a plane. */
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

/* Points closer and closer to a line. Whether they count as a line must not depend on the
 * unit of length. */
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
    TEST_ASSERT_TRUE(lines >= 2); /* at the latest at 1e-9 of the length */
}

static void test_arguments_of_the_choice_are_checked(void)
{
    rigcal_bearing good[6], s[6];
    rigcal_pair pairs[15];
    size_t n_pairs;

    six_bearings(good, 43, TEST_GENERAL);
    ASSERT_REFUSED(RIGCAL_ERR_NULL, n_pairs,
                   rigcal_pairs_choose(NULL, 15, &n_pairs, good, 6));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, pairs, rigcal_pairs_choose(pairs, 15, NULL, good, 6));
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

/* One point is given twice, with two pixels. One of these is wrong, and no pair is made of
 * the two. */
static void test_a_point_seen_twice_is_not_paired_with_itself(void)
{
    rigcal_bearing s[6];
    rigcal_pair pairs[15];
    size_t n_pairs;

    six_bearings(s, 47, TEST_GENERAL);
    memcpy(s[5].X_w, s[0].X_w, sizeof s[5].X_w);
    s[5].ray[0] = s[0].ray[0] + 2 * s[0].ray[2];
    ASSERT_STATUS(RIGCAL_OK, rigcal_pairs_choose(pairs, 15, &n_pairs, s, 6));
    assert_pairs_sound(pairs, n_pairs, s, 6);
    TEST_ASSERT_TRUE(is_chosen(pairs, n_pairs, 1, 5));
    TEST_ASSERT_FALSE(is_chosen(pairs, n_pairs, 0, 5));
}

TEST_MAIN()
{
    RUN_TEST(test_a_pair_is_a_plane_of_rays_and_a_direction);
    RUN_TEST(test_a_pair_does_not_depend_on_the_length_of_its_rays);
    RUN_TEST(test_a_pair_taken_the_other_way_round_is_the_same_equation);
    RUN_TEST(test_a_pair_of_one_point_or_one_ray_carries_no_equation);
    RUN_TEST(test_what_is_no_pair_is_refused);
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
    RUN_TEST(test_rays_in_one_plane_are_refused_however_near);
    RUN_TEST(test_a_narrow_bundle_of_rays_is_accepted);
    RUN_TEST(test_the_unit_of_length_does_not_decide_what_is_a_line);
    RUN_TEST(test_arguments_of_the_choice_are_checked);
    RUN_TEST(test_a_point_seen_twice_is_not_paired_with_itself);
    RUN_TEST(test_the_pairs_are_those_of_the_rule);
    RUN_TEST(test_a_tiny_target_is_paired_as_a_large_one);
    RUN_TEST(test_there_are_at_most_four_pairs_of_2_to_the_28_points);
    RUN_TEST(test_vectors_of_pairs_are_units);
    RUN_TEST(test_points_are_the_same_up_to_eight_roundings);
    RUN_TEST(test_rays_are_the_same_up_to_eight_roundings);
    RUN_TEST(test_the_digits_that_a_target_needs);
    RUN_TEST(test_points_in_one_place_are_told_before_rays_in_a_plane);
}
