#include "rc_chance.h"

#include "rc_logs.h"

/* ---- constants ----------------------------------------------------------- */

/* px: the least noise where none is stated. No camera's pixels are better. */
#define NOISE_LEAST RC(0.01)

/* sets: expected numbers are clipped here, far above any limit. */
#define EXPECTED_MOST RC(1e30)

/* 1: rc_normal_within uses its first quotient up to twice this probability (Wichura
 * 1988). */
#define CENTRAL RC(0.425)

/* 1: where the argument of its second quotient begins (Wichura 1988). */
#define TAIL_FROM RC(1.6)

/* 1: from here on Stirling's series is exact to 3e-10. A smaller x is raised first. */
#define STIRLING_FROM RC(8)

/* steps: the most of the continued fraction. It needs about ten times the cube root of the
 * degrees of freedom. */
enum { FRACTION_STEPS = 2000 };

/* ---- facts --------------------------------------------------------------- */

/* 2^90. Large expected numbers are counted in this unit, so that they do not overflow
 * before they become small. */
#define EXPECTED_UNIT RC(1.237940039285380274899124224e27)

/* Numerators and denominators of both quotients of rc_normal_within, by ascending powers
 * (Wichura 1988, PPND16). */
enum { QUOTIENT_TERMS = 8 };
static const rigcal_real QUOTIENTS[2][2][QUOTIENT_TERMS] = {
    {{RC(3.3871328727963666080e0), RC(1.3314166789178437745e2), RC(1.9715909503065514427e3),
      RC(1.3731693765509461125e4), RC(4.5921953931549871457e4), RC(6.7265770927008700853e4),
      RC(3.3430575583588128105e4), RC(2.5090809287301226727e3)},
     {1, RC(4.2313330701600911252e1), RC(6.8718700749205790830e2),
      RC(5.3941960214247511077e3), RC(2.1213794301960595867e4), RC(3.9307895800092710610e4),
      RC(2.8729085735721942674e4), RC(5.2264952788528545610e3)}},
    {{RC(1.42343711074968357734e0), RC(4.63033784615654529590e0),
      RC(5.76949722146069140550e0), RC(3.64784832476320460504e0),
      RC(1.27045825245236838258e0), RC(2.41780725177450611770e-1),
      RC(2.27238449892691845833e-2), RC(7.74545014278341407640e-4)},
     {1, RC(2.05319162663775882187e0), RC(1.67638483018380384940e0),
      RC(6.89767334985100004550e-1), RC(1.48103976427480074590e-1),
      RC(1.51986665636164571966e-2), RC(5.47593808499534494600e-4),
      RC(1.05075007164441684324e-9)}}};

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
RC_APART_FAST static rigcal_real power(rigcal_real base, size_t exponent)
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

/* With known noise the odds are exp of half the difference. Unknown noise is integrated out
 * with the prior 1 / noise, which gives the ratio to the power n - 3. `least`, the sum that
 * the least noise makes, is added to both sums. */
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

/* Three points choose a pose, usually with two solutions: n (n - 1) (n - 2) / 6 times 2
 * poses. Of the other points, count - 3 agree by chance. */
rigcal_real rc_expected_sets(size_t n, size_t count, rigcal_real near)
{
    RIGCAL_ASSERT(count <= n && near >= 0 && near <= 1);
    const rigcal_real all = (rigcal_real)n;
    rigcal_real expected = all * (all - 1) * (all - 2) / 3;
    size_t units = 0; /* powers of the unit */
    for (size_t i = 0; i + 3 < count; i++) {
        const rigcal_real ways = (all - 3 - (rigcal_real)i) / (rigcal_real)(i + 1);
        expected *= ways * near;
        if (expected >= EXPECTED_UNIT) {
            expected /= EXPECTED_UNIT;
            units++;
        } else if (expected < 1 && units > 0) {
            expected *= EXPECTED_UNIT;
            units--;
        }
    }
    for (; units > 0 && expected < EXPECTED_MOST; units--) {
        expected *= EXPECTED_UNIT;
    }
    return rc_min(expected, EXPECTED_MOST);
}

static rigcal_real quotient(int which, rigcal_real r)
{
    rigcal_real value[2] = {0, 0};
    for (int k = 0; k < 2; k++) {
        for (int i = QUOTIENT_TERMS - 1; i >= 0; i--) {
            value[k] = value[k] * r + QUOTIENTS[which][k][i];
        }
    }
    return value[0] / value[1];
}

rigcal_real rc_normal_within(rigcal_real probability)
{
    RIGCAL_ASSERT(probability > 0 && probability < 1);
    const rigcal_real q = probability / 2;
    if (q <= CENTRAL) {
        return q * quotient(0, CENTRAL * CENTRAL - q * q);
    }
    return quotient(1, RC_SQRT(-rc_log((1 - probability) / 2)) - TAIL_FROM);
}

rigcal_real rc_plane_within(rigcal_real probability)
{
    RIGCAL_ASSERT(probability > 0 && probability < 1);
    return RC_SQRT(-2 * rc_log(1 - probability));
}

/* ---- the F distribution ---------------------------------------------------- */

/* log(gamma(x)) - (x - 1/2) log(x) + x - log(2 pi) / 2, x >= STIRLING_FROM */
static rigcal_real stirling(rigcal_real x)
{
    const rigcal_real xx = x * x;
    return (RC(1) / 12 - (RC(1) / 360 - RC(1) / 1260 / xx) / xx) / x;
}

/* log(gamma(a + b) / gamma(a) / gamma(b)), by differences because its terms are large. A
 * small a is raised by gamma(a) = gamma(a + 1) / a. */
static rigcal_real log_beta_inverse(rigcal_real a, rigcal_real b)
{
    const rigcal_real half = RC(1) / 2;
    rigcal_real sum = 0;
    while (a < STIRLING_FROM) {
        sum -= rc_log1p(b / a);
        a += 1;
    }
    while (b < STIRLING_FROM) {
        sum -= rc_log1p(a / b);
        b += 1;
    }
    const rigcal_real both = a + b;
    sum += (a - half) * rc_log1p(b / a) + (b - half) * rc_log1p(a / b);
    sum += half * rc_log1p(both / (2 * RC_PI) - 1);
    return sum + stirling(both) - stirling(a) - stirling(b);
}

/* 1 + x > 0. Rounding may make it 0, so it is at least RC_EPS. */
static rigcal_real above_0(rigcal_real x)
{
    return rc_max(1 + x, RC_EPS);
}

/* The continued fraction of the incomplete beta function (Lentz 1976), for x below (a + 1)
 * / (a + b + 2). Then no denominator is much below 1 / (a + b). */
static rigcal_real beta_fraction(rigcal_real a, rigcal_real b, rigcal_real x)
{
    rigcal_real c = 1, d = 1 / above_0(-(a + b) * x / (a + 1)), fraction = d;
    for (int i = 2; i <= FRACTION_STEPS; i++) {
        const int pair = i / 2;
        const rigcal_real m = (rigcal_real)pair, at = a + (rigcal_real)i;
        const rigcal_real next = (i % 2 == 0)
                                     ? m * (b - m) * x / ((at - 1) * at)
                                     : -(a + m) * (a + b + m) * x / ((at - 1) * at);
        d = 1 / above_0(next * d);
        c = above_0(next / c);
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
        rc_exp(log_beta_inverse(a, b) - a * rc_log1p(odds) - b * rc_log1p(1 / odds));
    const rigcal_real tail = (x * (a + b + 2) < a + 1)
                                 ? front * beta_fraction(a, b, x) / a
                                 : 1 - front * beta_fraction(b, a, y) / b;
    return rc_max(0, rc_min(tail, 1)); /* rounding grows with the degrees of freedom */
}
