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

/* 1: the logarithm's series takes x within this. Beyond it the root is taken first. */
#define LOG_SERIES RC(0.25)

/* roots: at most; each halves the logarithm, and the largest number takes 13. */
enum { LOG_ROOTS = 20 };

/* terms: of that series; the next is below 1e-18. */
enum { LOG_TERMS = 10 };

/* 1: from here on Stirling's series is exact to 1e-11; below, x is raised first. */
#define STIRLING_FROM RC(8)

/* steps: of the continued fraction, some sqrt(n) for n degrees of freedom. */
enum { FRACTION_STEPS = 2000 };

/* 1: the least that a denominator of the continued fraction may be. */
#define FRACTION_LEAST RC(1e-30)

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

/* ---- the F distribution ---------------------------------------------------- */

/* log(1 + x) = 2 log(1 + y), y = sqrt(1 + x) - 1; and 2 artanh(x / (2 + x)). */
rigcal_real rc_log1p(rigcal_real x)
{
    RIGCAL_ASSERT(x > -1);
    rigcal_real scale = 2, sum = 0;
    for (int k = 0; k < LOG_ROOTS && RC_FABS(x) > LOG_SERIES; k++) {
        x /= 1 + RC_SQRT(1 + x);
        scale *= 2;
    }
    const rigcal_real t = x / (2 + x);
    for (int i = 2 * LOG_TERMS - 1; i > 0; i -= 2) {
        sum = sum * t * t + 1 / (rigcal_real)i;
    }
    return scale * sum * t;
}

/* log(gamma(x)) - (x - 1/2) log(x) + x - log(2 pi) / 2, x >= STIRLING_FROM */
static rigcal_real stirling(rigcal_real x)
{
    const rigcal_real xx = x * x;
    return (RC(1) / 12 - (RC(1) / 360 - RC(1) / 1260 / xx) / xx) / x;
}

/* log(gamma(a + b) / gamma(a) / gamma(b)) by differences, for its terms are large. Of
 * small a, gamma(a) = gamma(a + 1) / a. */
static rigcal_real log_beta_inverse(rigcal_real a, rigcal_real b)
{
    const rigcal_real half = RC(1) / 2;
    rigcal_real sum = 0;
    for (; a < STIRLING_FROM; a++) {
        sum -= rc_log1p(b / a);
    }
    for (; b < STIRLING_FROM; b++) {
        sum -= rc_log1p(a / b);
    }
    const rigcal_real both = a + b;
    sum += (a - half) * rc_log1p(b / a) + (b - half) * rc_log1p(a / b);
    sum += half * rc_log1p(both / (2 * RC_PI) - 1);
    return sum + stirling(both) - stirling(a) - stirling(b);
}

/* 1 + x, or what is next to 0. */
static rigcal_real away_from_0(rigcal_real x)
{
    return (RC_FABS(1 + x) < FRACTION_LEAST) ? FRACTION_LEAST : 1 + x;
}

/* The continued fraction of the incomplete beta function (Lentz 1976). */
static rigcal_real beta_fraction(rigcal_real a, rigcal_real b, rigcal_real x)
{
    rigcal_real c = 1, d = 1 / away_from_0(-(a + b) * x / (a + 1)), fraction = d;
    for (int i = 2; i <= FRACTION_STEPS; i++) {
        const rigcal_real m = (rigcal_real)(i / 2), at = a + (rigcal_real)i;
        const rigcal_real next = (i % 2 == 0)
                                     ? m * (b - m) * x / ((at - 1) * at)
                                     : -(a + m) * (a + b + m) * x / ((at - 1) * at);
        d = 1 / away_from_0(next * d);
        c = away_from_0(next / c);
        fraction *= c * d;
        if (RC_FABS(c * d - 1) <= RC_EPS) {
            break;
        }
    }
    return fraction;
}

/* The incomplete beta function I_x(a, b) at x = n / (n + k F), a = n / 2, b = k / 2. */
rigcal_real rc_f_tail(rigcal_real F, rigcal_real k, rigcal_real n)
{
    if (!(F > 0)) {
        return 1;
    }
    const rigcal_real odds = k * F / n, a = n / 2, b = k / 2;
    const rigcal_real x = 1 / (1 + odds), y = odds / (1 + odds);
    const rigcal_real front =
        exponential(log_beta_inverse(a, b) - a * rc_log1p(odds) - b * rc_log1p(1 / odds));
    return (x * (a + b + 2) < a + 1) ? front * beta_fraction(a, b, x) / a
                                     : 1 - front * beta_fraction(b, a, y) / b;
}
