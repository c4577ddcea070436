/* marks.h - what monitor.c and match.c share: the marks of count.c, and random numbers.
 * Only one file of a program may include it. */
#ifndef MARKS_H
#define MARKS_H

#include <stdint.h>

#include "rigcal.h"

void jobs_begin(void);
void jobs_end(void);

/* Marks for count.c. They are called, never inlined. */
void __attribute__((noinline)) jobs_begin(void)
{
    __asm__ volatile("" ::: "memory");
}

void __attribute__((noinline)) jobs_end(void)
{
    __asm__ volatile("" ::: "memory");
}

static uint64_t state = 1;

/* A number in [low, high), by SplitMix64. */
static rigcal_real uniform(rigcal_real low, rigcal_real high)
{
    uint64_t z = (state += UINT64_C(0x9E3779B97F4A7C15));
    z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
    return low + (high - low) * ((rigcal_real)((z ^ (z >> 31)) >> 40) / (1 << 24));
}

#endif
