#include "rc_bytes.h"

#include <string.h>

#if RIGCAL_USE_FLOAT
typedef uint32_t real_bits;
#else
typedef uint64_t real_bits;
#endif

/* The bits of numbers are copied to bytes, which needs IEEE 754. */
typedef char a_real_is_an_ieee_number[(sizeof(float) == 4 && FLT_MANT_DIG == 24 &&
                                       FLT_MAX_EXP == 128 &&
                                       sizeof(rigcal_real) == sizeof(real_bits) &&
                                       (RIGCAL_USE_FLOAT ||
                                        (DBL_MANT_DIG == 53 && DBL_MAX_EXP == 1024)))
                                          ? 1
                                          : -1];

uint32_t rc_crc32(const uint8_t bytes[], size_t n)
{
    RIGCAL_ASSERT(bytes != NULL || n == 0);
    /* Remainders of the sixteen values of 4 bits. */
    static const uint32_t NIBBLE[16] = {0x00000000,  0x1db71064,  0x3b6e20c8,  0x26d930ac,
                                        0x76dc4190,  0x6b6b51f4,  0x4db26158,  0x5005713c,
                                        0xedb88320U, 0xf00f9344U, 0xd6d6a3e8U, 0xcb61b38cU,
                                        0x9b64c2b0U, 0x86d3d2d4U, 0xa00ae278U, 0xbdbdf21cU};
    uint32_t crc = 0xffffffffU;
    for (size_t i = 0; i < n; i++) {
        crc ^= bytes[i];
        crc = crc >> 4 ^ NIBBLE[crc & 15];
        crc = crc >> 4 ^ NIBBLE[crc & 15];
    }
    return ~crc;
}

/* ---- numbers to bytes: each returns where the next one goes --------------- */

uint8_t *rc_put_u32(uint8_t *at, uint32_t x)
{
    for (int i = 0; i < 4; i++) {
        at[i] = (uint8_t)(x >> 8 * i);
    }
    return at + 4;
}

uint8_t *rc_put_reals(uint8_t *at, const rigcal_real x[], size_t n)
{
    for (size_t i = 0; i < n; i++) {
        real_bits bits;
        memcpy(&bits, &x[i], sizeof bits);
        for (size_t k = 0; k < sizeof bits; k++) {
            *at++ = (uint8_t)(bits >> 8 * k);
        }
    }
    return at;
}

/* ---- bytes to numbers ----------------------------------------------------- */

uint32_t rc_u16_at(const uint8_t *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8;
}

uint32_t rc_u32_at(const uint8_t *at)
{
    return rc_u16_at(at) | rc_u16_at(at + 2) << 16;
}

static float float_of_bits(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

#if RIGCAL_USE_FLOAT

/* The float nearest to the double with these bits, ties to even. It uses integers, because
 * a float build has no double arithmetic. Too large numbers and NaN become infinity. */
static rigcal_real real_of_double(uint64_t bits)
{
    enum { DROPPED = 52 - 23, ALL_DROPPED = 54, FLOAT_INFINITY = 0xff };
    const uint32_t sign = (uint32_t)(bits >> 63) << 31;
    const int32_t exponent = (int32_t)(bits >> 52 & 0x7ff) - 1023 + 127;
    const uint64_t mantissa = (bits & ((UINT64_C(1) << 52) - 1)) | UINT64_C(1) << 52;
    if (exponent >= FLOAT_INFINITY) {
        return float_of_bits(sign | (uint32_t)FLOAT_INFINITY << 23);
    }
    /* Below the normal floats, smaller numbers lose more digits. */
    const int32_t shift = (exponent >= 1) ? DROPPED : DROPPED + 1 - exponent;
    if (shift >= ALL_DROPPED) {
        return float_of_bits(sign);
    }
    const uint64_t rest = mantissa & ((UINT64_C(1) << shift) - 1);
    const uint64_t half = UINT64_C(1) << (shift - 1);
    uint32_t kept = (uint32_t)(mantissa >> shift);
    if (rest > half || (rest == half && (kept & 1) != 0)) {
        kept++;
    }
    /* The leading 1 of `kept` adds 1 to the exponent, and so does a carry. */
    const uint32_t below = (exponent >= 1) ? (uint32_t)(exponent - 1) << 23 : 0;
    return float_of_bits(sign | (below + kept));
}

#else

static rigcal_real real_of_double(uint64_t bits)
{
    rigcal_real x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

#endif

const uint8_t *rc_get_reals(rigcal_real x[], size_t n, const uint8_t *at,
                            int32_t real_bytes)
{
    for (size_t i = 0; i < n; i++) {
        x[i] = (real_bytes == 4)
                   ? (rigcal_real)float_of_bits(rc_u32_at(at))
                   : real_of_double((uint64_t)rc_u32_at(at + 4) << 32 | rc_u32_at(at));
        at += real_bytes;
    }
    return at;
}
