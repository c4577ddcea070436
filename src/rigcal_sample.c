#include "rc_sample.h"

/* ---- constants ----------------------------------------------------------- */

/* points: with more than this the triples are not counted. Their number would overflow, and
 * is far more than SAMPLES_MAX. */
enum { COUNTED_MAX = 1000 };

/* part: if all triples are tried, the next one's number is this part of their count further
 * on. It is the golden section, which spreads them (Weyl 1916). */
#define STRIDE_PART RC(0.618)

/* ---- samples ------------------------------------------------------------- */

/* Draws by Marsaglia's xorshift of 32 bits (2003). Its state is never 0. */
static size_t draw(uint32_t *random, size_t n)
{
    uint32_t x = *random;
    x ^= x << 13;
    x ^= x >> 17;
    x ^= x << 5;
    *random = x;
    return (size_t)(((uint64_t)x * (uint64_t)n) >> 32);
}

size_t rc_count_triples(size_t n)
{
    return (n > COUNTED_MAX) ? RC_COUNT_MAX : n * (n - 1) / 2 * (n - 2) / 3;
}

int32_t rc_sample_stride(int32_t total)
{
    int32_t stride = (int32_t)(STRIDE_PART * (rigcal_real)total) + 1;
    for (;; stride++) {
        int32_t a = stride, b = total;
        while (b > 0) {
            const int32_t rest = a % b;
            a = b;
            b = rest;
        }
        if (a == 1) {
            return stride;
        }
    }
}

void rc_sample_ranked(int32_t sample[3], int32_t n, int32_t rank)
{
    int32_t i = 0;
    for (; rank >= (n - 1 - i) * (n - 2 - i) / 2; i++) {
        rank -= (n - 1 - i) * (n - 2 - i) / 2;
    }
    sample[0] = i;
    for (i++; rank >= n - 1 - i; i++) {
        rank -= n - 1 - i;
    }
    sample[1] = i;
    sample[2] = i + 1 + rank;
}

void rc_sample_random(int32_t sample[3], uint32_t *random, size_t n)
{
    for (int k = 0; k < 3; k++) { /* distinct: skips those taken, in order */
        size_t i = draw(random, n - (size_t)k);
        const size_t low = (size_t)((sample[0] < sample[1]) ? sample[0] : sample[1]);
        const size_t high = (size_t)((sample[0] < sample[1]) ? sample[1] : sample[0]);
        if (k == 1) {
            i += i >= (size_t)sample[0];
        } else if (k == 2) {
            i += i >= low;
            i += i >= high;
        }
        sample[k] = (int32_t)i;
    }
}
