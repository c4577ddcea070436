/* optima: which optima are kept, in which order, and which count as the same. */
#include "rc_optima.h"
#include "test_support.h"

static const double AXIS[3] = {1, 2, -3};

/* A pose that shows its number: turned by a tenth of it, and as far away. */
static rigcal_transform numbered(int number)
{
    const double t[3] = {number, -number, 2 * number};
    rigcal_transform T = test_turned_about(AXIS, 0.1 * number);
    test_to_real(T.t, t, 3);
    return T;
}

static int32_t insert(rigcal_optima *optima, int number, double sse)
{
    const rigcal_transform T = numbered(number);
    return rc_optima_insert(optima, -1, &T, RC(sse));
}

/* Checks the numbers and sums of all optima that are kept. */
static void assert_kept(const rigcal_optima *optima, int n, const int numbers[],
                        const double sums[])
{
    TEST_ASSERT_EQUAL_INT32(n, optima->n);
    for (int i = 0; i < n; i++) {
        const rigcal_transform expected = numbered(numbers[i]);
        rigcal_transform seen;
        rc_optimum_transform(&seen, &optima->list[i]);
        ASSERT_TRANSFORM(&expected, &seen, TOL(3e-15, 2e-7), 0);
        ASSERT_NEAR(sums[i], optima->list[i].sse, 0);
    }
}

/* ---- two rows of a rotation ---------------------------------------------------- */

static void test_a_kept_pose_comes_back_whole(void)
{
    test_rng rng = test_seed(61);
    for (int trial = 0; trial < 200; trial++) {
        const rigcal_transform T = test_random_transform(&rng);
        rigcal_optima optima = {0};
        rigcal_transform seen;
        TEST_ASSERT_EQUAL_INT32(0, rc_optima_insert(&optima, -1, &T, RC(2.5)));
        rc_optimum_transform(&seen, &optima.list[0]);
        ASSERT_TRANSFORM(&T, &seen, TOL(3e-15, 5e-7), 0);
        ASSERT_NEAR(2.5, optima.list[0].sse, 0);
    }
}

/* ---- order, capacity ----------------------------------------------------------- */

/* Every order in which four optima can come. At the end they are sorted, and each insertion
 * returned its place. */
static void test_every_order_of_coming_ends_in_the_order_of_the_sums(void)
{
    static const int SORTED[4] = {0, 1, 2, 3};
    static const double SUMS[4] = {0, 10, 20, 30};
    TEST_ASSERT_TRUE(RIGCAL_POSES_MAX >= 4);
    for (int code = 0; code < 256; code++) {
        const int order[4] = {code & 3, code >> 2 & 3, code >> 4 & 3, code >> 6};
        rigcal_optima optima = {0};
        int came = 0;
        for (int i = 0; i < 4; i++) {
            came |= 1 << order[i];
        }
        if (came != 15) { /* skip unless each comes once */
            continue;
        }
        for (int i = 0; i < 4; i++) {
            int better = 0;
            for (int j = 0; j < i; j++) {
                better += order[j] < order[i];
            }
            TEST_ASSERT_EQUAL_INT32(better, insert(&optima, order[i], 10 * order[i]));
        }
        assert_kept(&optima, 4, SORTED, SUMS);
    }
}

static void test_the_best_are_kept_when_there_are_too_many(void)
{
    int numbers[RIGCAL_POSES_MAX];
    double sums[RIGCAL_POSES_MAX];
    rigcal_optima optima = {0};
    for (int i = RIGCAL_POSES_MAX + 4; i >= 1; i--) { /* ever better */
        TEST_ASSERT_EQUAL_INT32(0, insert(&optima, i, i));
    }
    for (int i = 0; i < RIGCAL_POSES_MAX; i++) {
        numbers[i] = i + 1;
        sums[i] = i + 1;
    }
    assert_kept(&optima, RIGCAL_POSES_MAX, numbers, sums);

    /* no better than the last one */
    TEST_ASSERT_EQUAL_INT32(-1, insert(&optima, 50, RIGCAL_POSES_MAX));
    TEST_ASSERT_EQUAL_INT32(-1, insert(&optima, 51, 1e9));
    assert_kept(&optima, RIGCAL_POSES_MAX, numbers, sums);

    /* better than the last one, which is removed */
    TEST_ASSERT_EQUAL_INT32(RIGCAL_POSES_MAX - 1,
                            insert(&optima, 52, RIGCAL_POSES_MAX - 0.5));
    numbers[RIGCAL_POSES_MAX - 1] = 52;
    sums[RIGCAL_POSES_MAX - 1] = RIGCAL_POSES_MAX - 0.5;
    assert_kept(&optima, RIGCAL_POSES_MAX, numbers, sums);
}

static void test_of_equal_sums_the_first_to_come_is_first(void)
{
    static const int NUMBERS[3] = {7, 8, 9};
    static const double SUMS[3] = {1, 1, 1};
    rigcal_optima optima = {0};
    for (int i = 0; i < 3; i++) {
        TEST_ASSERT_EQUAL_INT32(i, insert(&optima, NUMBERS[i], 1));
    }
    assert_kept(&optima, 3, NUMBERS, SUMS);
}

/* ---- the same pose, better ------------------------------------------------------ */

static void test_a_better_one_takes_the_place_of_the_same_and_moves_up(void)
{
    static const int NUMBERS[3] = {9, 1, 2};
    static const double SUMS[3] = {5, 10, 20};
    const rigcal_transform better = numbered(9);
    rigcal_optima optima = {0};
    for (int i = 1; i <= 3; i++) {
        (void)insert(&optima, i, 10 * i);
    }
    TEST_ASSERT_EQUAL_INT32(0, rc_optima_insert(&optima, 2, &better, RC(5)));
    assert_kept(&optima, 3, NUMBERS, SUMS);
}

static void test_a_better_one_stays_where_its_sum_belongs(void)
{
    static const int NUMBERS[3] = {1, 9, 3};
    static const double SUMS[3] = {10, 15, 30};
    const rigcal_transform better = numbered(9);
    rigcal_optima optima = {0};
    for (int i = 1; i <= 3; i++) {
        (void)insert(&optima, i, 10 * i);
    }
    TEST_ASSERT_EQUAL_INT32(1, rc_optima_insert(&optima, 1, &better, RC(15)));
    assert_kept(&optima, 3, NUMBERS, SUMS);
}

/* ---- near --------------------------------------------------------------------- */

static void test_a_rotation_is_near_within_the_angle_and_no_farther(void)
{
    const double angle = 0.05;
    test_rng rng = test_seed(62);
    for (int trial = 0; trial < 500; trial++) {
        const rigcal_transform T = test_random_transform(&rng);
        const double axis[3] = {test_normal(&rng), test_normal(&rng), test_normal(&rng)};
        rigcal_optima optima = {0};
        rigcal_transform turned;
        (void)rc_optima_insert(&optima, -1, &T, 1);
        turned = test_turned_about(axis, 0.97 * angle);
        turned = test_times(&turned, &T);
        TEST_ASSERT_EQUAL_INT32(0, rc_optima_near(&optima, turned.R, RC(angle)));
        turned = test_turned_about(axis, 1.03 * angle);
        turned = test_times(&turned, &T);
        TEST_ASSERT_EQUAL_INT32(-1, rc_optima_near(&optima, turned.R, RC(angle)));
    }
}

/* Half a turn about an axis differs by 2 in just two elements: the sum of squares is 8, as
 * that of the angle 2, without rounding. */
static void test_a_rotation_at_the_angle_itself_is_not_near(void)
{
    static const double HALF_TURN[9] = {-1, 0, 0, 0, -1, 0, 0, 0, 1};
    rigcal_optima optima = {0};
    rigcal_real R[9];
    (void)insert(&optima, 0, 1);
    test_to_real(R, HALF_TURN, 9);
    TEST_ASSERT_EQUAL_INT32(-1, rc_optima_near(&optima, R, 2));
    TEST_ASSERT_EQUAL_INT32(0, rc_optima_near(&optima, R, RC(2.0001)));
}

/* Of several that are near it is the first. The translation does not count. */
static void test_the_first_of_those_near_is_told(void)
{
    const double t[3] = {100, 200, 300};
    rigcal_optima optima = {0};
    rigcal_transform R = numbered(3);
    test_to_real(R.t, t, 3);
    TEST_ASSERT_EQUAL_INT32(-1, rc_optima_near(&optima, R.R, 1));
    for (int i = 1; i <= 4; i++) {
        (void)insert(&optima, i, i);
    }
    TEST_ASSERT_EQUAL_INT32(2, rc_optima_near(&optima, R.R, RC(0.05)));
    TEST_ASSERT_EQUAL_INT32(1, rc_optima_near(&optima, R.R, RC(0.15)));
    TEST_ASSERT_EQUAL_INT32(0, rc_optima_near(&optima, R.R, RC(0.25)));
}

TEST_MAIN()
{
    RUN_TEST(test_a_kept_pose_comes_back_whole);
    RUN_TEST(test_every_order_of_coming_ends_in_the_order_of_the_sums);
    RUN_TEST(test_the_best_are_kept_when_there_are_too_many);
    RUN_TEST(test_of_equal_sums_the_first_to_come_is_first);
    RUN_TEST(test_a_better_one_takes_the_place_of_the_same_and_moves_up);
    RUN_TEST(test_a_better_one_stays_where_its_sum_belongs);
    RUN_TEST(test_a_rotation_is_near_within_the_angle_and_no_farther);
    RUN_TEST(test_a_rotation_at_the_angle_itself_is_not_near);
    RUN_TEST(test_the_first_of_those_near_is_told);
}
