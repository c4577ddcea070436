#include "rc_logs.h"

/* ---- constants ----------------------------------------------------------- */

/* 1: exponents are clipped here. exp(80) = 5e34 is near the end of float. */
#define EXPONENT_MOST RC(80)

/* 1: the series is of exp(x / 256), which is then squared eight times. */
#define EXP_PART RC(0.00390625)

/* terms: of the series of log; the next is below a rounding. */
enum { LOG_TERMS = RIGCAL_USE_FLOAT ? 5 : 11 };

/* 1: the series of log(1 + x) takes x within this. Beyond it the root is taken first. */
#define LOG1P_SERIES RC(0.25)

/* roots: at most; each halves the logarithm, and the largest number takes 13. */
enum { LOG1P_ROOTS = 20 };

/* terms: of that series; the next is below 1e-18. */
enum { LOG1P_TERMS = 10 };

/* ---- facts --------------------------------------------------------------- */

#define ROOT_2 RC(1.4142135623730950488)
#define LOG_2 RC(0.69314718055994530942)

/* Powers of 2 are taken out of the argument of log in chunks first. */
#define LOG_CHUNK RC(65536)
enum { LOG_CHUNK_BITS = 16 }; /* 2^16 */

/* Inverse factorials. In float the next term is below 2e-6; double takes those on, to
 * below 1e-12. */
enum { FLOAT_TERMS = 6, MORE_TERMS = RIGCAL_USE_FLOAT ? 0 : 6 };
static const rigcal_real SERIES[] = {
    RC(1),           RC(1),           RC(1) / 2,     RC(1) / 6,
    RC(1) / 24,      RC(1) / 120,
#if !RIGCAL_USE_FLOAT
    RC(1) / 720,     RC(1) / 5040,    RC(1) / 40320, RC(1) / 362880,
    RC(1) / 3628800, RC(1) / 39916800
#endif
};

/* Written out, but for what double has more: it is asked for once a row of a monitor. */
rigcal_real rc_exp(rigcal_real x)
{
    const rigcal_real part = EXP_PART * rc_min(rc_max(x, -EXPONENT_MOST), EXPONENT_MOST);
    rigcal_real sum = 0;
    for (int k = FLOAT_TERMS + MORE_TERMS; k > FLOAT_TERMS; k--) {
        sum = sum * part + SERIES[k - 1];
    }
    sum = sum * part + SERIES[5];
    sum = sum * part + SERIES[4];
    sum = sum * part + SERIES[3];
    sum = sum * part + SERIES[2];
    sum = sum * part + SERIES[1];
    sum = sum * part + SERIES[0];
    const rigcal_real square = sum * sum, fourth = square * square;
    const rigcal_real eighth = fourth * fourth, part_16 = eighth * eighth;
    const rigcal_real part_32 = part_16 * part_16, part_64 = part_32 * part_32;
    const rigcal_real part_128 = part_64 * part_64;
    return part_128 * part_128;
}

/* 1 / (2 j + 1) of the series of log. */
static const rigcal_real ODD_PARTS[LOG_TERMS] = {
    RC(1),      RC(1) / 3,  RC(1) / 5,  RC(1) / 7,  RC(1) / 9,
#if !RIGCAL_USE_FLOAT
    RC(1) / 11, RC(1) / 13, RC(1) / 15, RC(1) / 17, RC(1) / 19,
    RC(1) / 21
#endif
};

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
        sum = sum * square + ODD_PARTS[j - 1];
    }
    return (rigcal_real)k * LOG_2 + 2 * part * sum;
}

/* log(1 + x) = 2 log(1 + y), y = sqrt(1 + x) - 1; and 2 artanh(x / (2 + x)). */
rigcal_real rc_log1p(rigcal_real x)
{
    RIGCAL_ASSERT(x > -1);
    rigcal_real scale = 2, sum = 0;
    for (int k = 0; k < LOG1P_ROOTS && RC_FABS(x) > LOG1P_SERIES; k++) {
        x /= 1 + RC_SQRT(1 + x);
        scale *= 2;
    }
    const rigcal_real t = x / (2 + x);
    for (int i = 2 * LOG1P_TERMS - 1; i > 0; i -= 2) {
        sum = sum * t * t + 1 / (rigcal_real)i;
    }
    return scale * sum * t;
}
