/* ram.c - linked into the tests of the bare targets. If the stack grew down to the data,
 * the program ends with status 99, whatever the test said. */
#include <stdio.h>
#include <stdlib.h>

/* More bytes than a stack frame is likely to skip without writing. */
enum { GUARD = 512, PATTERN = 0xA5 };

static volatile unsigned char *guard;

static void __attribute__((constructor)) set_guard(void)
{
    guard = malloc(GUARD); /* the first block is the lowest, just above the data */
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
