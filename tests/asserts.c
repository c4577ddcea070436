/* asserts: calls an internal function with an index that is not below its count. */
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>

#include "rc_linalg.h"

/* ctest takes a program that ends by a signal for a failure, whatever it printed. */
static void end(int signal_number)
{
    (void)signal_number;
    _Exit(EXIT_FAILURE);
}

int main(void)
{
    rigcal_real rows[3] = {1, 1, 1};
    (void)signal(SIGABRT, end);
    rc_packed_square_row(rows, 1, 1);
    puts("It went on.");
    return 0;
}
