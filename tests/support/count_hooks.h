/* count_hooks.h - reports each call of the library's math functions to test_bounds.c. So it
 * can count the passes of loops that the API does not count. */
#ifndef COUNT_HOOKS_H
#define COUNT_HOOKS_H

enum { HOOK_SQRT, HOOK_FABS };

/* Called before a math function that a function of the library calls with x. */
void hook_called(int hook, const char *function, double x);

#if RIGCAL_USE_FLOAT
#define RIGCAL_SQRT(x) (hook_called(HOOK_SQRT, __func__, (double)(x)), sqrtf(x))
#define RIGCAL_FABS(x) (hook_called(HOOK_FABS, __func__, (double)(x)), fabsf(x))
#else
#define RIGCAL_SQRT(x) (hook_called(HOOK_SQRT, __func__, x), sqrt(x))
#define RIGCAL_FABS(x) (hook_called(HOOK_FABS, __func__, x), fabs(x))
#endif

#endif /* COUNT_HOOKS_H */
