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

TEST_MAIN()
{
    RUN_TEST(test_triples_are_counted);
    RUN_TEST(test_a_stride_reaches_all);
    RUN_TEST(test_random_triples_are_spread);
}
