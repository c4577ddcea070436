/* bench_tally.h - how often each status came, for the benchmarks. */
#ifndef BENCH_TALLY_H
#define BENCH_TALLY_H

#include <stdio.h>
#include <string.h>

#include "rigcal.h"

enum { STATUS_LEAST = -40, STATUS_MOST = 10 };

typedef struct {
    int count[STATUS_MOST - STATUS_LEAST + 1];
} tally;

static inline void tally_add(tally *t, rigcal_status status)
{
    t->count[status - STATUS_LEAST]++;
}

static inline void tally_sum(tally *sum, const tally *t)
{
    for (int i = 0; i <= STATUS_MOST - STATUS_LEAST; i++) {
        sum->count[i] += t->count[i];
    }
}

/* Prints all statuses except OK, caveats too. */
static inline void tally_print(const tally *t)
{
    const char *between = "";

    for (rigcal_status s = STATUS_LEAST; s <= STATUS_MOST; s++) {
        const int count = t->count[s - STATUS_LEAST];

        if (count > 0 && s != RIGCAL_OK) {
            printf("%s%s %d", between, rigcal_status_name(s) + strlen("RIGCAL_"), count);
            between = ", ";
        }
    }
    printf("%s", *between == '\0' ? "none" : "");
}

#endif /* BENCH_TALLY_H */
