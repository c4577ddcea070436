/* sample: which triples a robust pose tries, counted by hand. */
#include <string.h>

#include "rc_sample.h"
#include "test_support.h"

enum { N = 9, TRIPLES = N * (N - 1) * (N - 2) / 6 };

static void test_triples_are_counted(void)
{
    TEST_ASSERT_EQUAL_INT(1, rc_count_triples(3));
    TEST_ASSERT_EQUAL_INT(84, rc_count_triples(9));
    TEST_ASSERT_EQUAL_INT(166167000, rc_count_triples(1000));
    TEST_ASSERT_EQUAL_INT(RC_COUNT_MAX, rc_count_triples(1001));
}

static void test_a_stride_reaches_all(void)
{
    for (int32_t total = 10; total < 300; total++) {
        const int32_t stride = rc_sample_stride(total);
        int32_t at = 0, steps = 0;
        do {
            at = (at + stride) % total;
            steps++;
        } while (at != 0);
        TEST_ASSERT_EQUAL_INT(total, steps);
    }
}

/* Random triples: each has three different points, and all triples are about equally
 * frequent. */
static void test_random_triples_are_spread(void)
{
    static int count[N][N][N];
    int32_t sample[3] = {0, 1, 2};
    uint32_t random = 1;
    int least = 1 << 30, most = 0;

    for (int k = 0; k < 100 * TRIPLES; k++) {
        rc_sample_random(sample, &random, N);
        int32_t a[3] = {sample[0], sample[1], sample[2]};
        for (int i = 0; i < 3; i++) {
            const int j = i % 2; /* sorts */
            if (a[j] > a[j + 1]) {
                const int32_t swap = a[j];
                a[j] = a[j + 1];
                a[j + 1] = swap;
            }
        }
        TEST_ASSERT_TRUE(0 <= a[0] && a[0] < a[1] && a[1] < a[2] && a[2] < N);
        count[a[0]][a[1]][a[2]]++;
    }
    for (int a = 0; a < N; a++) {
        for (int b = a + 1; b < N; b++) {
            for (int c = b + 1; c < N; c++) {
                least = count[a][b][c] < least ? count[a][b][c] : least;
                most = count[a][b][c] > most ? count[a][b][c] : most;
            }
        }
    }
    TEST_ASSERT_GREATER_THAN_INT(60, least); /* four deviations of 100 */
    TEST_ASSERT_LESS_THAN_INT(140, most);
}

/* 270369, 67634689 and 2647435461 are the generator's first numbers of the seed 1. Divided
 * by 2^32, they choose point 0 of 9, then place 0 of the other 8, which is point 1, then
 * place 4 of the other 7, which is point 6. */
static void test_the_first_random_triple_is_that_of_the_generator(void)
{
    int32_t sample[3] = {5, 3, 8};
    uint32_t random = 1;

    rc_sample_random(sample, &random, N);
    TEST_ASSERT_EQUAL_INT32(0, sample[0]);
    TEST_ASSERT_EQUAL_INT32(1, sample[1]);
    TEST_ASSERT_EQUAL_INT32(6, sample[2]);
    TEST_ASSERT_EQUAL_UINT32(2647435461, random);
}

static void test_ranked_triples_are_in_order(void)
{
    int32_t rank = 0;

    for (int32_t a = 0; a < N; a++) {
        for (int32_t b = a + 1; b < N; b++) {
            for (int32_t c = b + 1; c < N; c++) {
                int32_t sample[3];

                rc_sample_ranked(sample, N, rank++);
                TEST_ASSERT_EQUAL_INT32(a, sample[0]);
                TEST_ASSERT_EQUAL_INT32(b, sample[1]);
                TEST_ASSERT_EQUAL_INT32(c, sample[2]);
            }
        }
    }
    TEST_ASSERT_EQUAL_INT32(TRIPLES, rank);
}

/* The stride is about 0.6 of all triples, so that triples tried in turn are far apart. */
static void test_a_stride_is_the_golden_section(void)
{
    TEST_ASSERT_INT32_WITHIN(3, 618, rc_sample_stride(1000));
    TEST_ASSERT_INT32_WITHIN(3, 53, rc_sample_stride(84));
    TEST_ASSERT_EQUAL_INT32(1, rc_sample_stride(1));
}

/* The generator stated once more: x_1 is the seed, times (1 + L^13), (1 + R^17), (1 + L^5)
 * as shifts of 32 bits; the number is the part x / 2^32 of n, rounded down. */
static size_t own_draw(uint32_t *x, size_t n)
{
    *x = (uint32_t)(*x ^ ((uint64_t)*x * 8192u));
    *x = *x ^ (*x / 131072u);
    *x = (uint32_t)(*x ^ ((uint64_t)*x * 32u));
    const uint64_t high = (*x >> 16) * (uint64_t)n, low = (*x & 0xffff) * (uint64_t)n;
    return (size_t)((high + (low >> 16)) >> 16);
}

/* The k-th draw counts among the points that are left, in their order. */
static void own_sample(int32_t sample[3], uint32_t *x, size_t n)
{
    for (int k = 0; k < 3; k++) {
        size_t place = own_draw(x, n - (size_t)k), at = 0;

        for (;; at++) {
            int is_left = 1;
            for (int i = 0; i < k; i++) {
                is_left &= (size_t)sample[i] != at;
            }
            if (is_left && place-- == 0) {
                break;
            }
        }
        sample[k] = (int32_t)at;
    }
}

static void test_random_triples_are_those_of_the_generator(void)
{
    static const size_t POINTS[6] = {3, 4, 5, 17, 200, 5000};
    static const uint32_t SEEDS[4] = {1, 2, 0x9e3779b9u, 0xffffffffu};

    for (int i = 0; i < 24; i++) {
        const size_t n = POINTS[i % 6];
        uint32_t random = SEEDS[i / 6], own = random;
        int32_t sample[3] = {7, -1, 0}, expected[3];

        for (int draw = 0; draw < TEST_TRIALS(n > 1000 ? 100 : 1000); draw++) {
            rc_sample_random(sample, &random, n);
            own_sample(expected, &own, n);
            TEST_ASSERT_EQUAL_UINT32(own, random);
            TEST_ASSERT_EQUAL_INT32_ARRAY(expected, sample, 3);
        }
    }
}

/* Of many points too, whose number needs the generator's lowest bits. */
static void test_all_bits_of_the_generator_count(void)
{
    const size_t n = (RC_COUNT_MAX < 0x7fffffffu ? RC_COUNT_MAX : 0x7fffffffu) - 3;
    uint32_t random = 1, own = 1;

    for (int draw = 0; draw < TEST_TRIALS(1000); draw++) {
        int32_t sample[3] = {0, 0, 0};
        const uint32_t before = random;

        rc_sample_random(sample, &random, n);
        own = before;
        TEST_ASSERT_EQUAL_UINT32(own_draw(&own, n), (uint32_t)sample[0]);
    }
}

/* Chi squared of how often each of 50 points is drawn in 30 000 triples, at each of the
 * three places and in all. It has 49 degrees of freedom: 5 deviations of it are 50. */
static void test_random_points_are_as_frequent_as_by_chance(void)
{
    enum { POINTS = 50, DRAWS = 30000 };
    static int count[4][POINTS];
    int32_t sample[3] = {0, 1, 2};
    uint32_t random = 1;

    TEST_ON_HOST_ONLY("few draws say little");
    memset(count, 0, sizeof count);
    for (int draw = 0; draw < DRAWS; draw++) {
        rc_sample_random(sample, &random, POINTS);
        for (int k = 0; k < 3; k++) {
            count[k][sample[k]]++;
            count[3][sample[k]]++;
        }
    }
    for (int k = 0; k < 4; k++) {
        const double mean = (k < 3 ? 1.0 : 3.0) * DRAWS / POINTS;
        double chi2 = 0;

        for (int i = 0; i < POINTS; i++) {
            chi2 += (count[k][i] - mean) * (count[k][i] - mean) / mean;
        }
        TEST_ASSERT_TRUE(chi2 > 15 && chi2 < 100);
    }
}

/* Every triple of every small number of points, in the order of a dictionary, and the
 * number of them. */
static void test_every_triple_has_its_number(void)
{
    for (int32_t n = 3; n <= (TEST_ONE_IN > 1 ? 12 : 40); n++) {
        int32_t rank = 0, sample[3];

        for (int32_t a = 0; a < n; a++) {
            for (int32_t b = a + 1; b < n; b++) {
                for (int32_t c = b + 1; c < n; c++) {
                    rc_sample_ranked(sample, n, rank++);
                    TEST_ASSERT_TRUE(sample[0] == a && sample[1] == b && sample[2] == c);
                }
            }
        }
        TEST_ASSERT_EQUAL_UINT32(rank, rc_count_triples((size_t)n));
    }
}

static int32_t common_divisor(int32_t a, int32_t b)
{
    return b == 0 ? a : common_divisor(b, a % b);
}

/* The first number above 0.618 of all that has no divisor in common with it. */
static void test_a_stride_is_the_first_that_reaches_all(void)
{
    for (int32_t total = 1; total < TEST_TRIALS(3000); total++) {
        const int32_t stride = rc_sample_stride(total);
        const double least = 0.618 * total;

        TEST_ASSERT_TRUE(stride > least - 1e-3);
        TEST_ASSERT_EQUAL_INT32(1, common_divisor(stride, total));
        for (int32_t other = stride - 1; other > least + 1e-3; other--) {
            TEST_ASSERT_TRUE(common_divisor(other, total) > 1);
        }
    }
}

TEST_MAIN()
{
    RUN_TEST(test_triples_are_counted);
    RUN_TEST(test_a_stride_reaches_all);
    RUN_TEST(test_random_triples_are_spread);
    RUN_TEST(test_the_first_random_triple_is_that_of_the_generator);
    RUN_TEST(test_ranked_triples_are_in_order);
    RUN_TEST(test_a_stride_is_the_golden_section);
    RUN_TEST(test_random_triples_are_those_of_the_generator);
    RUN_TEST(test_all_bits_of_the_generator_count);
    RUN_TEST(test_random_points_are_as_frequent_as_by_chance);
    RUN_TEST(test_every_triple_has_its_number);
    RUN_TEST(test_a_stride_is_the_first_that_reaches_all);
}
