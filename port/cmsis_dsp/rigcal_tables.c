/* rigcal_tables.c - sine and cosine from a table of a sixty-fourth of a turn and
 * the first terms of their series between.
 *
 * With a the nearest multiple of the step and d = x - a, |d| <= pi / 64:
 *
 *     sin x = sin a cos d + cos a sin d
 *
 * sin d = d - d^3 / 6 and cos d = 1 - d^2 / 2 + d^4 / 24 are left off by less than
 * |d|^5 / 120 = 2.4e-9. The step is taken off in three parts, so that k times the
 * first two is exact for 14 bits of k: up to 1600 rad the error of d is that of its
 * own rounding. */
#include "rigcal_tables.h"

#include <stdint.h>

#define X_MAX 1600.0f
#define STEPS_A_RADIAN 10.1859159f
#define STEP_FIRST 0.0981445312f
#define STEP_SECOND 3.02195549e-05f
#define STEP_THIRD 1.96197796e-08f

/* make_table.py prints it and the constants above. sin of k steps; cos is a
 * quarter of a turn, 16 steps, further on. */
/* clang-format off */
static const float SINE[80] = {
    0, 0.0980171412f, 0.195090324f, 0.290284663f, 0.382683426f,
    0.471396744f, 0.555570245f, 0.634393275f, 0.707106769f, 0.773010433f,
    0.831469595f, 0.881921291f, 0.923879504f, 0.956940353f, 0.980785251f,
    0.99518472f, 1, 0.99518472f, 0.980785251f, 0.956940353f,
    0.923879504f, 0.881921291f, 0.831469595f, 0.773010433f, 0.707106769f,
    0.634393275f, 0.555570245f, 0.471396744f, 0.382683426f, 0.290284663f,
    0.195090324f, 0.0980171412f, 0, -0.0980171412f, -0.195090324f,
    -0.290284663f, -0.382683426f, -0.471396744f, -0.555570245f, -0.634393275f,
    -0.707106769f, -0.773010433f, -0.831469595f, -0.881921291f, -0.923879504f,
    -0.956940353f, -0.980785251f, -0.99518472f, -1, -0.99518472f,
    -0.980785251f, -0.956940353f, -0.923879504f, -0.881921291f, -0.831469595f,
    -0.773010433f, -0.707106769f, -0.634393275f, -0.555570245f, -0.471396744f,
    -0.382683426f, -0.290284663f, -0.195090324f, -0.0980171412f, 0,
    0.0980171412f, 0.195090324f, 0.290284663f, 0.382683426f, 0.471396744f,
    0.555570245f, 0.634393275f, 0.707106769f, 0.773010433f, 0.831469595f,
    0.881921291f, 0.923879504f, 0.956940353f, 0.980785251f, 0.99518472f,
};
/* clang-format on */

/* Splits x into k steps, whose index in the table is returned, and a rest d. */
static uint32_t reduce(float *d, float x)
{
    const int32_t k = (int32_t)(x * STEPS_A_RADIAN + (x < 0 ? -0.5f : 0.5f));
    const float steps = (float)k;

    *d = ((x - steps * STEP_FIRST) - steps * STEP_SECOND) - steps * STEP_THIRD;
    return (uint32_t)k & 63;
}

/* s cos d + c sin d, with the small terms summed first. */
static float turned(float s, float c, float d)
{
    const float d2 = d * d;
    const float sine = d - d * d2 * (1.0f / 6);
    const float versine = d2 * (0.5f - d2 * (1.0f / 24));

    return s + (c * sine - s * versine);
}

float rigcal_table_sinf(float x)
{
    float d;

    if (!(fabsf(x) <= X_MAX)) {
        return sinf(x);
    }
    const uint32_t k = reduce(&d, x);
    return turned(SINE[k], SINE[k + 16], d);
}

float rigcal_table_cosf(float x)
{
    float d;

    if (!(fabsf(x) <= X_MAX)) {
        return cosf(x);
    }
    const uint32_t k = reduce(&d, x);
    return turned(SINE[k + 16], -SINE[k], d);
}
