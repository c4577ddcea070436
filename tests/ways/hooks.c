/* Compares the functions of port/cmsis_dsp with those of double: their largest error over
 * every angle that the library uses. */
#include <math.h>
#include <stdio.h>

#include "rigcal_tables.h"

/* What the header promises of sine and cosine. */
#define SINE_TOL 1e-7

/* Half a unit in the last place of numbers from 1 to 2. */
#define ROUNDING 0x1p-24

typedef struct {
    double error, at;
} worst;

static void compare(worst *w, double got, double truth, double x)
{
    const double error = fabs(got - truth);

    if (!(error <= w->error)) {
        w->error = error;
        w->at = x;
    }
}

static int report(const char *name, const worst *w, double tol)
{
    printf("%s: off by %.2g at most, at %.9g\n", name, w->error, w->at);
    if (!(w->error <= tol)) {
        printf("hooks: %s is off by more than %g\n", name, tol);
        return 1;
    }
    return 0;
}

int main(void)
{
    worst sine = {0, 0}, cosine = {0, 0}, small = {0, 0}, root = {0, 0};
    int bad = 0;

    /* 2.5 million angles of either sign, to beyond where the table ends; closer
     * and closer around 0. */
    for (int i = -2500000; i <= 2500000; i++) {
        const double part = i / 2.5e6;
        const float x = (float)(1700 * part * fabs(part));

        compare(&sine, (double)rigcal_table_sinf(x), sin((double)x), (double)x);
        compare(&cosine, (double)rigcal_table_cosf(x), cos((double)x), (double)x);
        if (x != 0 && fabsf(x) < 0.04f) {
            compare(&small, (double)rigcal_table_sinf(x) / sin((double)x), 1, (double)x);
        }
    }
    bad |= report("sine", &sine, SINE_TOL);
    bad |= report("cosine", &cosine, SINE_TOL);

    bad |= report("sine of a small angle, relatively", &small, SINE_TOL);

    /* One octave for each parity of the exponent covers all roots. */
    for (int i = 0; i <= 3000000; i++) {
        const float x = (float)(1 + i / 1e6);

        compare(&root, (double)rigcal_fpu_sqrtf(x), sqrt((double)x), (double)x);
    }
    bad |= report("root", &root, ROUNDING);

    if (rigcal_table_sinf(0) != 0 || rigcal_table_cosf(0) != 1 ||
        rigcal_table_sinf((float)NAN) == rigcal_table_sinf((float)NAN)) {
        printf("hooks: 0 or NaN is not kept\n");
        bad = 1;
    }
    return bad;
}
