#include "rc_chance.h"

/* ---- constants ----------------------------------------------------------- */

/* px: the least noise that is believed where none is stated. Pixels are not better. */
#define NOISE_LEAST RC(0.01)

/* 1: exponents are clipped here. exp(80) = 5e34 is near the end of float. */
#define EXPONENT_MOST RC(80)

/* 1: the series is of exp(x / 256), x within EXPONENT_MOST; a power of 2. */
enum { EXP_PARTS = 256 };

/* terms: of that series; the next is below 1e-10. */
enum { EXP_TERMS = 8 };

/* 1: powers of 2 are taken out of the argument of log in chunks of 2^16. */
#define LOG_CHUNK RC(65536)
enum { LOG_CHUNK_BITS = 16 };

/* terms: of the series of log; the next is below a rounding. */
enum { LOG_TERMS = RIGCAL_USE_FLOAT ? 5 : 11 };

#define ROOT_2 RC(1.4142135623730950488)
#define LOG_2 RC(0.69314718055994530942)

/* sets: expected numbers are clipped here, far above any limit, before they overflow. */
#define EXPECTED_MOST RC(1e30)

RC_APART rigcal_real rc_freedom(size_t n)
{
    RIGCAL_ASSERT(n >= 3 && n <= RC_COUNT_MAX);
    return rc_max(1, (rigcal_real)(2 * (int32_t)n - 6));
}

rigcal_real rc_chi2_limit(rigcal_real freedom, rigcal_real deviations)
{
    RIGCAL_ASSERT(freedom >= 1);
    const rigcal_real v = 2 / (9 * freedom);
    const rigcal_real root = 1 - v + deviations * RC_SQRT(v);
    return freedom * root * root * root;
}

/* base^exponent. Underflows to 0, overflows to infinity. */
RC_APART static rigcal_real power(rigcal_real base, size_t exponent)
{
    rigcal_real result = 1;
    for (; exponent > 0; exponent /= 2) {
        if (exponent % 2 == 1) {
            result *= base;
        }
        base *= base;
    }
    return result;
}

/* The series of exp(x / EXP_PARTS), to that power. */
rigcal_real rc_exp(rigcal_real x)
{
    const rigcal_real part = rc_min(rc_max(x, -EXPONENT_MOST), EXPONENT_MOST) / EXP_PARTS;
    rigcal_real sum = 1;
    for (int k = EXP_TERMS; k > 0; k--) {
        sum = 1 + part * sum / (rigcal_real)k;
    }
    return power(sum, EXP_PARTS);
}

/* x = 2^k y, y within sqrt(2) of 1: log y = 2 artanh((y - 1) / (y + 1)), a series whose
 * argument is at most 0.172. */
rigcal_real rc_log(rigcal_real x)
{
    RIGCAL_ASSERT(x > 0 && x <= RC_MAX);
    int32_t k = 0;
    for (; x >= LOG_CHUNK; k += LOG_CHUNK_BITS) {
        x /= LOG_CHUNK;
    }
    for (; x * LOG_CHUNK <= 1; k -= LOG_CHUNK_BITS) {
        x *= LOG_CHUNK;
    }
    for (; x > ROOT_2; k++) {
        x /= 2;
    }
    for (; x * ROOT_2 < 1; k--) {
        x *= 2;
    }
    const rigcal_real part = (x - 1) / (x + 1), square = part * part;
    rigcal_real sum = 0;
    for (int j = LOG_TERMS; j > 0; j--) {
        sum = sum * square + RC(1) / (rigcal_real)(2 * j - 1);
    }
    return (rigcal_real)k * LOG_2 + 2 * part * sum;
}

/* Noise known: exp of half the difference. Unknown, it is integrated out with the prior
 * 1 / noise, which leaves the power n - 3 of the ratio; added is what the least noise makes
 * of a sum. */
rigcal_real rc_odds(rigcal_real sse, rigcal_real other, rigcal_real sigma_px,
                    rigcal_real pixel_size, size_t n)
{
    RIGCAL_ASSERT(sigma_px >= 0 && pixel_size > 0);
    RIGCAL_ASSERT(n >= 3 && sse >= 0 && other >= 0);
    if (sigma_px > 0) {
        return rc_exp((other - sse) / (2 * sigma_px * sigma_px));
    }
    const rigcal_real noise = NOISE_LEAST * pixel_size;
    const rigcal_real least = rc_freedom(n) * noise * noise;
    return power((other + least) / (sse + least), n - 3);
}

/* Three points choose a pose, with two solutions as a rule: n (n - 1) (n - 2) / 6 times 2.
 * Of the others, count - 3 agree by chance. */
rigcal_real rc_expected_sets(size_t n, size_t count, rigcal_real near)
{
    RIGCAL_ASSERT(count <= n && near >= 0 && near <= 1);
    const rigcal_real all = (rigcal_real)n;
    rigcal_real expected = all * (all - 1) * (all - 2) / 3;
    for (size_t i = 0; i + 3 < count; i++) {
        const rigcal_real ways = (all - 3 - (rigcal_real)i) / (rigcal_real)(i + 1);
        expected = rc_min(expected * ways * near, EXPECTED_MOST);
    }
    return expected;
}
