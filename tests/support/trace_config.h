/* trace_config.h - prints what a search does, event by event. CONTRIBUTING.md shows how to
 * use it, and what it prints. */
#include <stdio.h>

#define RIGCAL_TRACE(event, number, value) \
    printf("%-52s %3ld %10.3g\n", event, (long)(number), (double)(value))
