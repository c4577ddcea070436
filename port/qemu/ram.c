/* ram.c - linked into the tests of the bare targets: a stack that came down to the
 * data ends the program with status 99, whatever the test said. */
#include <stdio.h>
#include <stdlib.h>

/* Wider than what a frame is likely to step over without writing. */
enum { GUARD = 512, PATTERN = 0xA5 };

static volatile unsigned char *guard;

static void __attribute__((constructor)) set_guard(void)
{
    guard = malloc(GUARD); /* the first is the lowest, right above the data */
    for (int i = 0; i < GUARD; i++) {
        guard[i] = PATTERN;
    }
}

static void __attribute__((destructor)) check_guard(void)
{
    for (int i = 0; i < GUARD; i++) {
        if (guard[i] != PATTERN) {
            printf("the stack came down to the data: %d bytes below the guard's "
                   "end\n",
                   GUARD - i);
            _Exit(99);
        }
    }
}
