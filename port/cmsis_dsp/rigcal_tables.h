/* rigcal_tables.h - sine, cosine and square root for a core whose FPU is single
 * precision. */
#ifndef RIGCAL_TABLES_H
#define RIGCAL_TABLES_H

#include <math.h>

/* Any angle, within 1e-7 of the true value (tests/ways/hooks.c); beyond 1600 rad,
 * and for NaN, libm is asked. */
float rigcal_table_sinf(float x);
float rigcal_table_cosf(float x);

/* One instruction. libm's sqrtf is that instruction, a comparison and a call that sets
 * errno. */
static inline float rigcal_fpu_sqrtf(float x)
{
#if defined(__GNUC__) && defined(__ARM_FP) && (__ARM_FP & 4)
    float root;

    __asm__("vsqrt.f32 %0, %1" : "=t"(root) : "t"(x));
    return root;
#else
    return sqrtf(x);
#endif
}

#endif /* RIGCAL_TABLES_H */
