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

/* The series of exp(x / EXP_PARTS), to that power: exp itself would bring 0.4 KB along. */
static rigcal_real exponential(rigcal_real x)
{
    const rigcal_real part = rc_min(rc_max(x, -EXPONENT_MOST), EXPONENT_MOST) / EXP_PARTS;
    rigcal_real sum = 1;
    for (int k = EXP_TERMS; k > 0; k--) {
        sum = 1 + part * sum / (rigcal_real)k;
    }
    return power(sum, EXP_PARTS);
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
        return exponential((other - sse) / (2 * sigma_px * sigma_px));
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
