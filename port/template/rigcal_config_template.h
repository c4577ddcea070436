/* rigcal_config_template.h - a firmware's own choices for rigcal.
 *
 * Copy this file into your firmware under a name of yours and tell every
 * compilation, the library's and your own:
 *
 *     -DRIGCAL_CONFIG_FILE='"my_rigcal_config.h"'
 *
 * include/rigcal_config.h reads it first and gives a default to whatever it
 * leaves out, so keep only what you change. As it is, it changes nothing.
 */
#ifndef RIGCAL_CONFIG_TEMPLATE_H
#define RIGCAL_CONFIG_TEMPLATE_H

/* rigcal_real: 1 is float, 0 is double. Choose float where the FPU is single
 * precision (Cortex-M4F, M33, ESP32) or absent. This alone changes the ABI:
 * what calls the library must be compiled with the same choice, and can ask
 * rigcal_sizeof_real() what the library was built with. A build system may set
 * it on the command line, hence the #ifndef. */
#ifndef RIGCAL_USE_FLOAT
#define RIGCAL_USE_FLOAT 0
#endif

/* Parts to leave out if the flash is too small for them: 0 leaves a part out. */
#define RIGCAL_WITH_FISHEYE 1
#define RIGCAL_WITH_THREE_POINTS 1 /* also used for poses of wide targets */
#define RIGCAL_WITH_MIRRORED 1     /* checks a pose for mirrored coordinates */

/* The header that declares the functions named below, brackets or quotes
 * included. Default: <math.h>. */
#define RIGCAL_MATH_HEADER <math.h>

/* All of libm that the library calls, rigcal_real to rigcal_real; solving,
 * triangulating and matching lines call RIGCAL_SQRT and RIGCAL_FABS alone. A
 * replacement must be accurate to a few units in the last place: a table of
 * sines good to 1e-5 is not enough, nor is a routine for a reduced range of
 * angles. */
#if RIGCAL_USE_FLOAT
#define RIGCAL_SQRT(x) sqrtf(x) /* one instruction where there is an FPU */
#define RIGCAL_SIN(x) sinf(x)
#define RIGCAL_COS(x) cosf(x)
#define RIGCAL_ATAN2(y, x) atan2f(y, x) /* full circle, (-pi, pi] */
#define RIGCAL_FABS(x) fabsf(x)
#else
#define RIGCAL_SQRT(x) sqrt(x)
#define RIGCAL_SIN(x) sin(x)
#define RIGCAL_COS(x) cos(x)
#define RIGCAL_ATAN2(y, x) atan2(y, x)
#define RIGCAL_FABS(x) fabs(x)
#endif

/* A precondition inside the library, which callers cannot violate: public
 * functions check their arguments and return a status. While porting, stop
 * here, e.g. with
 *     do { if (!(condition)) { __asm volatile("bkpt"); } } while (0)
 * or define RIGCAL_ASSERTS as 1 in its place, which takes the C library's
 * assert(). In the field, leave it empty. */
#define RIGCAL_ASSERT(condition) ((void)0)

/* A prefix for the declarations of public functions, such as a section or a calling
 * convention. The default is kept here: exported if the library is shared, otherwise
 * nothing.
 *
 * #define RIGCAL_API __attribute__((section(".itcm")))
 */

#endif /* RIGCAL_CONFIG_TEMPLATE_H */
