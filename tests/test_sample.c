/* sample: which triples a robust pose tries, counted by hand. */
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

TEST_MAIN()
{
    RUN_TEST(test_triples_are_counted);
    RUN_TEST(test_a_stride_reaches_all);
    RUN_TEST(test_random_triples_are_spread);
    RUN_TEST(test_the_first_random_triple_is_that_of_the_generator);
    RUN_TEST(test_ranked_triples_are_in_order);
    RUN_TEST(test_a_stride_is_the_golden_section);
}
