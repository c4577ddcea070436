#include "rc_logs.h"

/* ---- constants ----------------------------------------------------------- */

/* 1: exponents are clipped here. exp(80) = 5e34 is near the largest float. */
#define EXPONENT_MOST RC(80)

/* 1: exp(x / 256) comes from a series and is squared eight times. A power of 2. */
enum { EXP_PARTS = 256 };

/* terms: the length of the series of exp, for x / 256 within 0.32. The next one is below
 * 3e-12 (float: 1e-7). */
enum { EXP_TERMS = RIGCAL_USE_FLOAT ? 6 : 9 };

/* terms: the length of the series of log. The next term is below a tenth of a rounding. */
enum { LOG_TERMS = RIGCAL_USE_FLOAT ? 5 : 11 };

/* ---- facts --------------------------------------------------------------- */

#define ROOT_2 RC(1.4142135623730950488)
#define LOG_2 RC(0.69314718055994530942)

/* The argument of log is first divided or multiplied by this power of 2. */
#define LOG_CHUNK RC(65536)
enum { LOG_CHUNK_BITS = 16 }; /* 2^16 */

/* 1 / k! */
static const rigcal_real BY_FACTORIAL[EXP_TERMS + 1] = {
    RC(1),        RC(1),         RC(1) / 2,     RC(1) / 6,
    RC(1) / 24,   RC(1) / 120,   RC(1) / 720,
#if !RIGCAL_USE_FLOAT
    RC(1) / 5040, RC(1) / 40320, RC(1) / 362880
#endif
};

rigcal_real rc_exp(rigcal_real x)
{
    const rigcal_real part = rc_min(rc_max(x, -EXPONENT_MOST), EXPONENT_MOST) / EXP_PARTS;
    rigcal_real sum = 0;
    for (int k = EXP_TERMS; k >= 0; k--) {
        sum = sum * part + BY_FACTORIAL[k];
    }
    sum *= sum;
    sum *= sum;
    sum *= sum;
    sum *= sum;
    sum *= sum;
    sum *= sum;
    sum *= sum;
    return sum * sum;
}

/* 1 / (2 j + 1) of the series of log. */
static const rigcal_real ODD_PARTS[LOG_TERMS] = {
    RC(1),      RC(1) / 3,  RC(1) / 5,  RC(1) / 7,  RC(1) / 9,
#if !RIGCAL_USE_FLOAT
    RC(1) / 11, RC(1) / 13, RC(1) / 15, RC(1) / 17, RC(1) / 19,
    RC(1) / 21
#endif
};

/* log((1 + part) / (1 - part)) = 2 artanh(part), part within 0.172. */
static rigcal_real log_of_part(rigcal_real part)
{
    const rigcal_real square = part * part;
    rigcal_real sum = 0;
    for (int j = LOG_TERMS; j > 0; j--) {
        sum = sum * square + ODD_PARTS[j - 1];
    }
    return 2 * part * sum;
}

/* x = 2^k y, y within sqrt(2) of 1: log y = 2 artanh((y - 1) / (y + 1)). */
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
    return (rigcal_real)k * LOG_2 + log_of_part((x - 1) / (x + 1));
}

/* Near 0 the rounding of 1 + x would count: log(1 + x) = 2 artanh(x / (2 + x)). No 1 + x
 * above 0 is less than half of RC_EPS. */
rigcal_real rc_log1p(rigcal_real x)
{
    RIGCAL_ASSERT(x > -1);
    const rigcal_real y = 1 + x;
    if (y <= ROOT_2 && y * ROOT_2 >= 1) {
        return log_of_part(x / (2 + x));
    }
    return rc_log(rc_min(rc_max(y, RC_EPS / 2), RC_MAX));
}
