/* bytes: numbers as bytes and back, and the CRC of bytes. That a float build rounds doubles
 * to nearest is in test_store.c. */
#include <string.h>

#include "rc_bytes.h"
#include "test_support.h"
#include "vectors_store.h"

static void test_the_crc_is_that_of_zlib(void)
{
    for (int i = 0; i < STORE_CRC_ROWS; i++) {
        const size_t n = (size_t)STORE_CRC[i][0];
        uint8_t bytes[40];

        for (size_t k = 0; k < sizeof bytes; k++) {
            bytes[k] = (uint8_t)STORE_CRC[i][1 + k];
        }
        TEST_ASSERT_EQUAL_HEX32((uint32_t)STORE_CRC[i][41], rc_crc32(bytes, n));
    }
}

static void test_integers_are_little_endian(void)
{
    uint8_t bytes[5] = {0, 0, 0, 0, 0x5a};

    TEST_ASSERT_EQUAL_PTR(bytes + 4, rc_put_u32(bytes, 0x89abcdef));
    TEST_ASSERT_EQUAL_HEX8(0xef, bytes[0]);
    TEST_ASSERT_EQUAL_HEX8(0xcd, bytes[1]);
    TEST_ASSERT_EQUAL_HEX8(0xab, bytes[2]);
    TEST_ASSERT_EQUAL_HEX8(0x89, bytes[3]);
    TEST_ASSERT_EQUAL_HEX8(0x5a, bytes[4]);
    TEST_ASSERT_EQUAL_HEX32(0x89abcdef, rc_u32_at(bytes));
    TEST_ASSERT_EQUAL_HEX32(0xcdef, rc_u16_at(bytes));
}

/* -0.15625 is BFC40000 00000000 as a double and BE200000 as a float, by IEEE 754. */
static void test_reals_of_either_precision_are_read(void)
{
    static const uint8_t AS_DOUBLE[] = {0, 0, 0, 0, 0, 0, 0xc4, 0xbf,
                                        0, 0, 0, 0, 0, 0, 0,    0};
    static const uint8_t AS_FLOAT[] = {0, 0, 0x20, 0xbe, 0, 0, 0x80, 0x3f};
    rigcal_real x[2];

    TEST_ASSERT_EQUAL_PTR(AS_DOUBLE + 16, rc_get_reals(x, 2, AS_DOUBLE, 8));
    ASSERT_NEAR(-0.15625, x[0], 0);
    ASSERT_NEAR(0, x[1], 0);
    TEST_ASSERT_EQUAL_PTR(AS_FLOAT + 8, rc_get_reals(x, 2, AS_FLOAT, 4));
    ASSERT_NEAR(-0.15625, x[0], 0);
    ASSERT_NEAR(1, x[1], 0);
}

static void test_reals_are_written_as_they_are_read(void)
{
    const rigcal_real x[3] = {RC(-0.15625), RC(1) / 3, RC(1e-30)};
    rigcal_real back[3];
    uint8_t bytes[3 * sizeof(rigcal_real) + 1];

    bytes[sizeof bytes - 1] = 0x5a;
    TEST_ASSERT_EQUAL_PTR(bytes + sizeof bytes - 1, rc_put_reals(bytes, x, 3));
    TEST_ASSERT_EQUAL_HEX8(0x5a, bytes[sizeof bytes - 1]);
    TEST_ASSERT_EQUAL_HEX8(RIGCAL_USE_FLOAT ? 0xbe : 0xbf, bytes[sizeof(rigcal_real) - 1]);
    (void)rc_get_reals(back, 3, bytes, (int32_t)sizeof(rigcal_real));
    TEST_ASSERT_EQUAL_MEMORY(x, back, sizeof x);
}

TEST_MAIN()
{
    RUN_TEST(test_the_crc_is_that_of_zlib);
    RUN_TEST(test_integers_are_little_endian);
    RUN_TEST(test_reals_of_either_precision_are_read);
    RUN_TEST(test_reals_are_written_as_they_are_read);
}
