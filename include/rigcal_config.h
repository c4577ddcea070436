/* rigcal_config.h - what a firmware may choose once, at compile time.
 *
 * Every choice has a default, so an ordinary build defines nothing. To replace
 * some, define RIGCAL_CONFIG_FILE as the name of a header of yours, quotes or
 * brackets included, e.g. -DRIGCAL_CONFIG_FILE='"my_rigcal_config.h"'. A copy of
 * port/template/rigcal_config_template.h is the place to start.
 */
#ifndef RIGCAL_CONFIG_H
#define RIGCAL_CONFIG_H

#ifdef RIGCAL_CONFIG_FILE
#include RIGCAL_CONFIG_FILE
#endif

/* ---- options of the compiler ----------------------------------------------
 *
 * The library refuses NaN and infinity by comparisons. Its accuracies are those of
 * operations that each round once, to rigcal_real. The compilation of the library stops
 * where the compiler tells that an option breaks this:
 *
 *   options                                     what breaks           who tells
 *   -ffast-math, -Ofast, -ffinite-math-only     NaN passes as good    gcc, clang
 *   MSVC's /fp:fast                             NaN passes as good    MSVC
 *   -funsafe-math-optimizations,                accuracy              gcc from 12 on
 *     -fassociative-math, -freciprocal-math,
 *     -fno-signed-zeros
 *   FLT_EVAL_METHOD neither 0 nor 16: the x87   accuracy              gcc, clang, MSVC
 *     unit (-mfpmath=387, plain -m32)
 *   -fsingle-precision-constant, in double      accuracy              gcc
 *   -fno-honor-nans, -fno-honor-infinities      NaN passes as good    nobody (clang)
 *
 * Where nobody tells, CMake looks for the option in the flags that it is given. A build by
 * hand has to look itself. port/template/main_template.c checks on the target that NaN is
 * refused. -fno-math-errno and -fno-trapping-math do no harm.
 *
 * Contraction: the compiler makes one fused multiply-add of a product and a sum, where the
 * processor has that instruction. gcc does so unless -ffp-contract=off or -std=c99 is
 * given, clang from 14 on unless -ffp-contract=off is, MSVC before 2022 unless /fp:strict
 * is. CMake switches it off. With contraction these promises fall, and the tests find no
 * other:
 *
 *   - The same input gives the same bits on every target with the same libm.
 *   - A search takes as many evaluations as on other targets. Its upper bounds hold.
 *   - A search by rigcal_neldermead_*, in float, ends in the same place of a flat valley.
 *
 * A program that gcc links with -ffast-math makes the processor take subnormal numbers for
 * zero. Then lengths whose squares are below 1e-308 / 1e-38 count as zero. */

/* CMake's option has this name. Given to a compiler, it would do nothing. */
/* clang-format off */
#ifdef RIGCAL_REAL
#error "RIGCAL_REAL is an option of CMake. A compiler is given RIGCAL_USE_FLOAT=1 for float, or RIGCAL_USE_FLOAT=0 for double."
#endif
/* clang-format on */

/* 1: rigcal_real is float, for cores whose FPU is single precision or absent.
 * 0: double. The one choice that changes the ABI: library and caller must agree,
 * and rigcal_sizeof_real() tells what the library was built with. */
#ifndef RIGCAL_USE_FLOAT
#define RIGCAL_USE_FLOAT 0
#endif
#if RIGCAL_USE_FLOAT != 0 && RIGCAL_USE_FLOAT != 1
#error "RIGCAL_USE_FLOAT must be 1 for float or 0 for double."
#endif

#if RIGCAL_USE_FLOAT
typedef float rigcal_real;
#else
typedef double rigcal_real;
#endif

/* What a 0 leaves out, where flash is short, and which status a caller who wants it then
 * gets:
 *
 *   FISHEYE       RIGCAL_ERR_CAMERA, of a camera with such a lens
 *   THREE_POINTS  RIGCAL_ERR_TOO_FEW: a pose wants four different points; of three, and of
 *                 more of which some are given twice, there is none.
 *                 RIGCAL_ERR_WIDE_RAY: no ray may be 80 degrees or more off the optical
 *                 axis, for such poses begin with those of three points
 *   MIRRORED      nothing: a pose does not look whether mirrored coordinates would fit far
 *                 better. It is POOR_FIT only if its own error is too large
 *
 * port/template/rigcal_config_small.h leaves out all three. */
#ifndef RIGCAL_WITH_FISHEYE
#define RIGCAL_WITH_FISHEYE 1
#endif
#ifndef RIGCAL_WITH_THREE_POINTS
#define RIGCAL_WITH_THREE_POINTS 1
#endif
#ifndef RIGCAL_WITH_MIRRORED
#define RIGCAL_WITH_MIRRORED 1
#endif

/* 1: what is only faster is in too: the equations of a pinhole written out, checks written
 * out, starts from three of few points (these besides with RIGCAL_WITH_THREE_POINTS), and
 * the first steps of many points on some of them. 0: the same poses, to rounding, by less
 * code: some 2 KB of flash. A compiler that is told to optimise for size (-Os) has it at 0
 * unless it is given. All files of a build must have the same: give it, where some of them
 * are optimised otherwise. */
#ifndef RIGCAL_FOR_SPEED
#ifdef __OPTIMIZE_SIZE__
#define RIGCAL_FOR_SPEED 0
#else
#define RIGCAL_FOR_SPEED 1
#endif
#endif

/* The header that declares the functions below; only src/ includes it. */
#ifndef RIGCAL_MATH_HEADER
#define RIGCAL_MATH_HEADER <math.h>
#endif

/* The whole of libm that the library calls, rigcal_real to rigcal_real. A
 * replacement (CMSIS-DSP, a vendor's trigonometry unit) must be accurate to a
 * few units in the last place, else the accuracies in rigcal.h do not hold. */
#ifndef RIGCAL_SQRT
#if RIGCAL_USE_FLOAT
#define RIGCAL_SQRT(x) sqrtf(x)
#else
#define RIGCAL_SQRT(x) sqrt(x)
#endif
#endif

#ifndef RIGCAL_SIN
#if RIGCAL_USE_FLOAT
#define RIGCAL_SIN(x) sinf(x)
#else
#define RIGCAL_SIN(x) sin(x)
#endif
#endif

#ifndef RIGCAL_COS
#if RIGCAL_USE_FLOAT
#define RIGCAL_COS(x) cosf(x)
#else
#define RIGCAL_COS(x) cos(x)
#endif
#endif

#ifndef RIGCAL_ATAN2
#if RIGCAL_USE_FLOAT
#define RIGCAL_ATAN2(y, x) atan2f(y, x)
#else
#define RIGCAL_ATAN2(y, x) atan2(y, x)
#endif
#endif

#ifndef RIGCAL_FABS
#if RIGCAL_USE_FLOAT
#define RIGCAL_FABS(x) fabsf(x)
#else
#define RIGCAL_FABS(x) fabs(x)
#endif
#endif

/* 1: the preconditions inside the library are checked, for who works on it or ports it.
 * 0: they cost nothing. Callers cannot violate one: public functions check their arguments
 * first and return a status. CMake's option has the same name. */
#ifndef RIGCAL_ASSERTS
#define RIGCAL_ASSERTS 0
#endif

/* What a check is. The C library's assert() prints the condition and aborts; a firmware
 * may have something of its own, which counts whatever RIGCAL_ASSERTS is. */
#ifndef RIGCAL_ASSERT
#if RIGCAL_ASSERTS
#define RIGCAL_ASSERT(condition) assert(condition)
#else
#define RIGCAL_ASSERT(condition) ((void)0)
#endif
#endif

/* What a search does, event by event, for who works on the library: `event` is a text,
 * `number` an integer and `value` a rigcal_real. CONTRIBUTING.md shows a trace. It costs
 * nothing where it is not defined. */
#ifndef RIGCAL_TRACE
#define RIGCAL_TRACE(event, number, value) ((void)0)
#endif

/* Keeps a function out of its callers, for the sake of the stack. */
#ifndef RIGCAL_NOINLINE
#if defined(__GNUC__)
#define RIGCAL_NOINLINE __attribute__((noinline))
#else
#define RIGCAL_NOINLINE
#endif
#endif

/* Has a function made anew in each of its callers, for the sake of speed. */
#ifndef RIGCAL_FORCE_INLINE
#if defined(__GNUC__)
#define RIGCAL_FORCE_INLINE __attribute__((always_inline))
#else
#define RIGCAL_FORCE_INLINE
#endif
#endif

/* What a public function is declared with. RIGCAL_SHARED: the library is a
 * shared one. RIGCAL_BUILD: it is being compiled, not used. */
#ifndef RIGCAL_API
#if defined(_WIN32) && defined(RIGCAL_SHARED)
#ifdef RIGCAL_BUILD
#define RIGCAL_API __declspec(dllexport)
#else
#define RIGCAL_API __declspec(dllimport)
#endif
#elif defined(__GNUC__)
#define RIGCAL_API __attribute__((visibility("default")))
#else
#define RIGCAL_API
#endif
#endif

#endif /* RIGCAL_CONFIG_H */
