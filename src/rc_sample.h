/* rc_sample.h - the triples of points whose poses a robust pose tries. */
#ifndef RC_SAMPLE_H
#define RC_SAMPLE_H

#include "rc_real.h"

/* How many triples n points make, or RC_COUNT_MAX if there are more. */
size_t rc_count_triples(size_t n);

/* A number near 0.6 of `total` that has no divisor in common with it. Steps of this size
 * reach each number below `total` once. */
int32_t rc_sample_stride(int32_t total);

/* Finds triple number `rank` of n points; (0, 1, 2) is the first. */
void rc_sample_ranked(int32_t sample[3], int32_t n, int32_t rank);

/* Draws three different ones of n points. *random is the state, never 0; sample has any
 * numbers. */
void rc_sample_random(int32_t sample[3], uint32_t *random, size_t n);

#endif /* RC_SAMPLE_H */
