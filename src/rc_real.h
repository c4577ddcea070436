/* rc_real.h - the number type, its constants and the math hooks. It is the first layer and
 * includes only the public header. */
#ifndef RC_REAL_H
#define RC_REAL_H

#include <float.h>

#include "rigcal.h"
#include RIGCAL_MATH_HEADER
#if RIGCAL_ASSERTS
#undef NDEBUG /* so that an optimised build can have assertions too */
#include <assert.h>
#endif

/* clang-format off */
/* Compiler options that break the library: see include/rigcal_config.h. */
#if defined(__FAST_MATH__) || defined(_M_FP_FAST) || \
    (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "The compiler is told that no number is NaN or infinite: -ffast-math, -Ofast, -ffinite-math-only, /fp:fast. rigcal could not refuse such input. Build rigcal without that option."
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || \
    defined(__NO_SIGNED_ZEROS__)
#error "The compiler is told to reorder arithmetic: -funsafe-math-optimizations, -fassociative-math, -freciprocal-math, -fno-signed-zeros. rigcal would not be as accurate as it promises. Build rigcal without that option."
#endif
/* 16 concerns only half precision. */
#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 16
#error "FLT_EVAL_METHOD is not 0: the compiler may keep more digits than a type has. rigcal needs each operation rounded to its type. On x86 build it with -msse2 -mfpmath=sse."
#endif
/* clang-format on */
#if !RIGCAL_USE_FLOAT
/* Fails with -fsingle-precision-constant, which takes half the digits of every constant. In
 * float that does no harm. */
typedef char rc_not_with_fsingle_precision_constant[sizeof 1.0 == sizeof(double) ? 1 : -1];
#endif

#define RC(x) ((rigcal_real)(x))

/* A tolerance that depends on the precision: the value for double, the value for float. */
#if RIGCAL_USE_FLOAT
#define RC_TOL(for_double, for_float) RC(for_float)
#define RC_EPS FLT_EPSILON
#define RC_MAX FLT_MAX
#else
#define RC_TOL(for_double, for_float) RC(for_double)
#define RC_EPS DBL_EPSILON
#define RC_MAX DBL_MAX
#endif

#define RC_PI RC(3.14159265358979323846264338327950288)

#define RC_SQRT RIGCAL_SQRT
#define RC_SIN RIGCAL_SIN
#define RC_COS RIGCAL_COS
#define RC_ATAN2 RIGCAL_ATAN2
#define RC_FABS RIGCAL_FABS

/* When compiling for size, a call of a three-line function is smaller than another copy of
 * its body. gcc warns of noinline with `inline`, although they agree here: `inline` is
 * C99's, for a body in a header. */
#ifdef __OPTIMIZE_SIZE__
#pragma GCC diagnostic ignored "-Wattributes"
#define RC_INLINE RIGCAL_NOINLINE inline
#else
#define RC_INLINE inline
#endif

/* Whether code is compiled in that is only faster: code written out beside shorter code
 * with the same result to rounding. */
enum { RC_FOR_SPEED = RIGCAL_FOR_SPEED };

/* The inline functions also have a body in rigcal_linalg.c, which a compiler for size
 * calls. They must not use the math hooks, which may be static. */
RC_INLINE rigcal_real rc_max(rigcal_real a, rigcal_real b)
{
    return a > b ? a : b;
}

RC_INLINE rigcal_real rc_min(rigcal_real a, rigcal_real b)
{
    return a < b ? a : b;
}

/* ---- constants ----------------------------------------------------------- */

/* points, pairs, views: the largest number. Indices up to it fit an int32_t, sums a
 * rigcal_real. A size_t of 16 bits cannot count as many. */
#if SIZE_MAX >> 27 > 1
#define RC_COUNT_MAX ((size_t)1 << 28)
#else
#define RC_COUNT_MAX SIZE_MAX
#endif

/* unit of length: squares and fourth powers of coordinates up to this do not overflow. */
#define RC_COORDINATE_MAX RC_TOL(1e30, 1e9)

/* part of the target's size: if the rounding of its coordinates is more, its shape is
 * lost. */
#define RC_SHAPE_ROUNDING RC(1e-4)

/* ---- functions ----------------------------------------------------------- */

/* NaN is neither finite nor within a limit. */
int rc_is_finite(rigcal_real x);
int rc_all_finite(const rigcal_real x[], int n);
int rc_all_within(const rigcal_real x[], int n, rigcal_real limit);

/* Checks n numbers that must lie within `limit`: OK, ERR_NULL, ERR_NOT_FINITE or
 * ERR_RANGE. */
rigcal_status rc_check_numbers(const rigcal_real x[], int n, rigcal_real limit);

/* Keeps the locals of a function off its caller's stack frame, where the caller calls
 * deeper functions later. */
#define RC_APART RIGCAL_NOINLINE

/* The same where speed counts. For size a function that is called once is cheaper inlined,
 * and leaves the stack as it was. */
#if RIGCAL_FOR_SPEED
#define RC_APART_FAST RIGCAL_NOINLINE
#else
#define RC_APART_FAST
#endif

#endif /* RC_REAL_H */
