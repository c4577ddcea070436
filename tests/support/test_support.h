/* test_support.h - what the tests of every layer share.
 *
 * Expected values come from paper, from symmetry, from tests/vectors or from
 * the plain double-precision arithmetic below, which shares no code with the
 * library and stays double in a float build. Tolerances are doubles too.
 */
#ifndef TEST_SUPPORT_H
#define TEST_SUPPORT_H

#include <stddef.h>
#include <stdint.h>

#include "rigcal_paper.h"
#include "unity.h"

/* ---- the main function ---------------------------------------------------- */

/* A test program ends with
 *
 *     TEST_MAIN()
 *     {
 *         RUN_TEST(test_one);
 *         RUN_TEST(test_other);
 *     }
 *
 * Its arguments are those of Unity: `-n name` runs the tests whose names contain `name`,
 * `-x name` leaves them out, `-l` lists them. No test of that name is a failure. */
#define TEST_MAIN() \
    void setUp(void) \
    { \
    } \
    void tearDown(void) \
    { \
    } \
    TEST_MAIN_WITH_SETUP()

/* The same for a file with setUp and tearDown of its own. */
#define TEST_MAIN_WITH_SETUP() \
    static void run_tests(void); \
    int main(int argc, char *argv[]) \
    { \
        return test_main(argc, argv, __FILE__, run_tests); \
    } \
    static void run_tests(void)

#undef RUN_TEST
#define RUN_TEST(function) test_run(function, #function, __LINE__)

void test_run(void (*function)(void), const char *name, int line);
int test_main(int argc, char *argv[], const char *file, void (*run_tests)(void));

/* ---- how much ------------------------------------------------------------ */

/* A host runs all trials. An emulated microcontroller computes in double a hundred times
 * slower. So its build runs one in RIGCAL_TEST_ONE_IN of a test's trials. It leaves out,
 * with the reason, tests that mean nothing with so few trials, or that do not fit
 * (RIGCAL_TEST_HOST is 0). With the sanitizers a host runs a part of the trials too, and
 * leaves out the rates that take long. */
#ifndef RIGCAL_TEST_ONE_IN
#define RIGCAL_TEST_ONE_IN 1
#endif
#ifndef RIGCAL_TEST_HOST
#define RIGCAL_TEST_HOST 1
#endif
enum { TEST_ONE_IN = RIGCAL_TEST_ONE_IN, TEST_HOST = RIGCAL_TEST_HOST };
#define TEST_TRIALS(n) (((n) + TEST_ONE_IN - 1) / TEST_ONE_IN)
#define TEST_ON_HOST_ONLY(reason) \
    do { \
        if (!TEST_HOST) { \
            TEST_IGNORE_MESSAGE("only on a host: " reason); \
            return; \
        } \
    } while (0)
#define TEST_WANTS_ALL_TRIALS(reason) \
    do { \
        if (TEST_ONE_IN > 1) { \
            TEST_IGNORE_MESSAGE("only with all trials: " reason); \
            return; \
        } \
    } while (0)

/* Bytes of RAM that the build states. Bytes that a test needs, without code and C
 * library. */
#ifndef RIGCAL_TEST_RAM
#define RIGCAL_TEST_RAM 1000000
#endif
#define TEST_WANTS_RAM(bytes) \
    do { \
        if ((size_t)(bytes) > RIGCAL_TEST_RAM) { \
            TEST_IGNORE_MESSAGE("wants more RAM than there is: " #bytes); \
            return; \
        } \
    } while (0)

/* ---- numbers ------------------------------------------------------------- */

/* A constant as a rigcal_real; a rigcal_real as a double; a tolerance of the
 * double or of the float build. */
#define RC(x) ((rigcal_real)(x))
#define D(x) ((double)(x))
#define TOL(in_double, in_float) \
    (RIGCAL_USE_FLOAT ? (double)(in_float) : (double)(in_double))

#define TEST_PI 3.14159265358979323846

/* Arguments of hostile callers. */
#define TEST_NAN ((rigcal_real)test_nan())
#define TEST_INF ((rigcal_real)test_infinity())
double test_nan(void);
double test_infinity(void);

/* Converts n numbers from double to rigcal_real, and back. */
void test_to_real(rigcal_real out[], const double in[], size_t n);
void test_to_double(double out[], const rigcal_real in[], size_t n);

/* ---- assertions ---------------------------------------------------------- */

/* Compares statuses. If they differ, the message has their names. */
#define ASSERT_STATUS(expected, actual) test_assert_status((expected), (actual), __LINE__)

/* |actual - expected| <= tol, both finite: Unity's own comparison of doubles
 * holds for NaN against NaN, and prints too few digits. */
#define ASSERT_NEAR(expected, actual, tol) \
    test_assert_near((double)(expected), (double)(actual), (double)(tol), -1, __LINE__)

/* The same for n numbers: expected doubles, and rigcal_reals that were computed. */
#define ASSERT_ARRAY_NEAR(expected, actual, n, tol) \
    test_assert_array_near((expected), (actual), (size_t)(n), (double)(tol), __LINE__)

/* Outputs that a failing call must not change. Fill the object (a struct, a number or an
 * array, not a pointer) with a pattern, make the call, and check that the pattern is still
 * there. */
#define FILL(object) test_fill(&(object), sizeof(object))
#define ASSERT_UNTOUCHED(object) \
    test_assert_untouched(&(object), sizeof(object), #object, __LINE__)

/* Does all of this: `call` must fail with `expected` and not change `output`. */
#define ASSERT_REFUSED(expected, output, call) \
    do { \
        FILL(output); \
        ASSERT_STATUS(expected, call); \
        ASSERT_UNTOUCHED(output); \
    } while (0)

void test_assert_status(rigcal_status expected, rigcal_status actual, int line);
void test_assert_near(double expected, double actual, double tol, int index, int line);
void test_assert_array_near(const double expected[], const rigcal_real actual[], size_t n,
                            double tol, int line);
void test_fill(void *object, size_t size);
void test_assert_untouched(const void *object, size_t size, const char *name, int line);

/* ---- random numbers, the same on every machine (SplitMix64) -------------- */

typedef struct {
    uint64_t state;
} test_rng;

test_rng test_seed(uint64_t seed);
uint64_t test_next(test_rng *rng);
double test_uniform(test_rng *rng, double low, double high); /* [low, high) */
double test_normal(test_rng *rng); /* mean 0, deviation 1: sum of 12 uniforms */

/* ---- plain double-precision geometry ------------------------------------- */

/* R = Rz(yaw) Ry(pitch) Rx(roll), product of the three matrices. */
void test_rotation(double R[9], double yaw, double pitch, double roll);
/* A right-handed rotation by `angle` about `axis`, of any length but zero. */
void test_rotation_about(double R[9], const double axis[3], double angle);
/* A rotation that is uniform over all rotations. */
void test_random_rotation(double R[9], test_rng *rng);

void test_product(double C[9], const double A[9], const double B[9]);
void test_transpose(double At[9], const double A[9]);
void test_apply(double y[3], const double R[9], const double x[3],
                const double t[3]); /* y = R x + t; t = NULL: without t */
void test_cross(double c[3], const double a[3], const double b[3]);
double test_dot(const double a[3], const double b[3]);
double test_norm(const double a[3]);
double test_determinant(const double A[9]);

/* The rows of R_t are right-handed axes: z along `z`, x along the part of `near_x` that is
 * across z. */
void test_axes_of(double R_t[9], const double near_x[3], const double z[3]);

/* Angle between two rotations, [0, pi], from the distance of the matrices. */
double test_angle_between(const double A[9], const double B[9]);

/* (x, y) = (X, Y) / Z of R X + t. */
void test_project(double xy[2], const double R[9], const double t[3], const double X[3]);

/* Pixel of a point X_c in the camera frame by the formulas of rigcal.h, with no
 * check whether the lens reaches that far. */
void test_project_px(double uv[2], const rigcal_camera *camera, const double X_c[3]);

/* Converts a transform from doubles, and back (t or R may be NULL). */
rigcal_transform test_transform(const double R[9], const double t[3]);
void test_transform_parts(double R[9], double t[3], const rigcal_transform *T);

/* ---- transforms ------------------------------------------------------------ */

rigcal_transform test_from_ypr(const double ypr[3], const double t[3]);
/* A random rotation, and t within 5. */
rigcal_transform test_random_transform(test_rng *rng);
/* A rotation about an axis of any length but zero; t = 0. */
rigcal_transform test_turned_about(const double axis[3], double angle);
rigcal_transform test_times(const rigcal_transform *c_from_b,
                            const rigcal_transform *b_from_a);
rigcal_transform test_inverse(const rigcal_transform *b_from_a);
/* The X_b of a point X_a. */
void test_move_point(double X_b[3], const rigcal_transform *b_from_a, const double X_a[3]);

/* Each entry of R and of t within its tolerance. */
#define ASSERT_TRANSFORM(expected, seen, tol_entry, tol_length) \
    test_assert_transform((expected), (seen), (double)(tol_entry), (double)(tol_length), \
                          __LINE__)
void test_assert_transform(const rigcal_transform *expected, const rigcal_transform *seen,
                           double tol_entry, double tol_length, int line);

/* R R^T = 1 and det R = 1, each entry within tol. */
#define ASSERT_ROTATION(R, tol) test_assert_rotation((R), (double)(tol), __LINE__)
void test_assert_rotation(const double R[9], double tol, int line);

/* ---- views ----------------------------------------------------------------- */

/* A view as an argument: &VIEW(&camera, observations, NULL, 6). */
#define VIEW(camera, observations, sigma, n) \
    ((const rigcal_view){(camera), (observations), (sigma), (size_t)(n)})

/* ---- a random camera before a random target ------------------------------ */

/* A test that needs more points than the memory holds is left out. */
#define TEST_SCENE_MAX (RIGCAL_TEST_RAM < 32768 ? 20 : 64)
#define TEST_MANY (TEST_SCENE_MAX < 50 ? TEST_SCENE_MAX : 50)

typedef enum {
    TEST_GENERAL, /* anywhere in a unit cube */
    TEST_PLANAR,  /* in a unit square with any orientation in space */
    TEST_SQUARE   /* planar, the first four nearly the corners of a square */
} test_shape;

/* The camera is 3 to 10 sizes away. The target's middle is up to 20 degrees off its axis,
 * with any orientation. A planar target is never within 15 degrees of edge-on. */
typedef struct {
    int n;
    double X[TEST_SCENE_MAX][3];  /* the target: size 1, its origin within 2 */
    double R[9], t[3];            /* cam_from_world */
    double ypr[3];                /* of R */
    double xy[TEST_SCENE_MAX][2]; /* exact normalised image points */
    double Z[TEST_SCENE_MAX];     /* depths */
} test_scene;

void test_scene_random(test_scene *scene, test_rng *rng, int n, test_shape shape);

/* The input of the library: rays (x, y, 1), or pixels of `camera`. */
void test_bearings(rigcal_bearing out[], const test_scene *scene);
void test_observations(rigcal_observation out[], const test_scene *scene,
                       const rigcal_camera *camera);

/* lens, width, height, fx, fy, cx, cy and the eight coefficients, as in the
 * vectors. */
rigcal_camera test_camera(const double v[15]);

/* A camera without distortion: focal length 800 pixels, image 640 x 480. */
rigcal_camera test_pinhole(void);

#endif /* TEST_SUPPORT_H */
