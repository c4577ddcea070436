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
 * The library refuses NaN and infinity by comparisons. Its accuracies assume that each
 * operation rounds once, to rigcal_real. Some options of compilers break this. Where the
 * compiler lets the library know, its compilation stops:
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
 * No compiler tells of the options in the last line. CMake searches its flags for them. If
 * you build by hand, check the flags yourself. port/template/main_template.c checks on the
 * target that NaN is refused. -fno-math-errno and -fno-trapping-math do no harm.
 *
 * Contraction: the compiler turns a product and a sum into one fused multiply-add, where
 * the processor has that instruction. gcc does so unless -ffp-contract=off or -std=c99 is
 * given, clang from 14 on unless -ffp-contract=off is given, MSVC before 2022 unless
 * /fp:strict is given. Where gcc vectorises for an x86 with FMA, or for the vectors of
 * RISC-V, it does so in spite of -ffp-contract=off; -fno-tree-vectorize prevents that.
 * CMake switches contraction off, and gives that option where it is needed. With
 * contraction these promises no longer hold; the tests found no others
 * (tests/ways/MATRIX.md names those that fail):
 *
 *   - The same input gives the same bits on every target with the same libm.
 *   - A search takes as many evaluations as on other targets. Its upper bounds hold.
 *   - In float, a search by rigcal_neldermead_* ends at the same place of a flat valley.
 *   - A status near its limit is the same. A few poses are RIGCAL_VAGUE instead of
 *     RIGCAL_AMBIGUOUS, or the other way. In float a few are RIGCAL_BUDGET_SPENT instead.
 *   - In float, a fault of rigcal_rig_faults differs from that of dense least squares by
 *     less than 0.005 of its standard deviation. With contraction it may be 0.007.
 *
 * If gcc links a program with -ffast-math, the processor takes subnormal numbers for zero.
 * Then lengths whose squares are below 1e-308 / 1e-38 count as zero. */

/* This is the name of CMake's option. As a macro for the compiler it would do nothing. */
/* clang-format off */
#ifdef RIGCAL_REAL
#error "RIGCAL_REAL is an option of CMake. A compiler is given RIGCAL_USE_FLOAT=1 for float, or RIGCAL_USE_FLOAT=0 for double."
#endif
/* clang-format on */

/* 1: rigcal_real is float, for cores whose FPU is single precision or absent.
 * 0: double. Only this choice changes the ABI: library and caller must agree.
 * rigcal_sizeof_real() returns what the library was built with. */
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

/* A 0 leaves a part out, where flash is short. A caller who needs that part then gets this
 * status:
 *
 *   FISHEYE       RIGCAL_ERR_CAMERA, for a camera with such a lens
 *   THREE_POINTS  RIGCAL_ERR_TOO_FEW: a pose needs four different points. A point that is
 *                 given twice counts once. RIGCAL_ERR_WIDE_RAY: no ray may be 80 degrees
 *                 or more off the optical axis, because poses of such rays start from
 *                 poses of three points
 *   MIRRORED      none. A pose is not compared with that of mirrored coordinates. It is
 *                 POOR_FIT only if its own error is too large
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

/* 1: the build has code that only saves time: the equations of a pinhole written out,
 * checks written out, starts from three points where there are few (also needs
 * RIGCAL_WITH_THREE_POINTS), and first steps that use only some of many points. 0: the
 * poses are the same to rounding, and the code is some 2 KB of flash smaller. The default
 * is 0 if the compiler optimises for size (-Os). All files of a build must have the same
 * value: define it, if some of them are optimised differently. */
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

/* 1: the library checks its internal preconditions, for those who work on it or port it.
 * 0: they cost nothing. Callers cannot violate them, because public functions check their
 * arguments first and return a status. CMake's option has the same name. */
#ifndef RIGCAL_ASSERTS
#define RIGCAL_ASSERTS 0
#endif

/* How a precondition is checked. The C library's assert() prints the condition and aborts.
 * A firmware may define its own check, which is used whatever RIGCAL_ASSERTS is. */
#ifndef RIGCAL_ASSERT
#if RIGCAL_ASSERTS
#define RIGCAL_ASSERT(condition) assert(condition)
#else
#define RIGCAL_ASSERT(condition) ((void)0)
#endif
#endif

/* Traces what a search does, event by event, for those who work on the library. `event` is
 * a text, `number` an integer and `value` a rigcal_real. CONTRIBUTING.md shows a trace.
 * Where the macro is not defined, it costs nothing. */
#ifndef RIGCAL_TRACE
#define RIGCAL_TRACE(event, number, value) ((void)0)
#endif

/* The compiler must not inline the function: this saves stack in its callers. */
#ifndef RIGCAL_NOINLINE
#if defined(__GNUC__)
#define RIGCAL_NOINLINE __attribute__((noinline))
#else
#define RIGCAL_NOINLINE
#endif
#endif

/* The compiler must inline the function into each caller: this saves time. */
#ifndef RIGCAL_FORCE_INLINE
#if defined(__GNUC__)
#define RIGCAL_FORCE_INLINE __attribute__((always_inline))
#else
#define RIGCAL_FORCE_INLINE
#endif
#endif

/* Every public function is declared with this. RIGCAL_SHARED: the library is a shared one.
 * RIGCAL_BUILD: the library is being compiled, not used. */
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
