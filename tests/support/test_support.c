#include "test_support.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- the main function ---------------------------------------------------- */

#ifdef UNITY_USE_COMMAND_LINE_ARGS

/* Unity does not declare these. */
int UnityTestMatches(void);
extern char *UnityOptionIncludeNamed;

static int lists_only;

/* Whether the command line asks for the test `name`. Unity would also search for the text
 * in the name of the file. */
static int is_asked_for(const char *name)
{
    const char *const file = Unity.TestFile;
    int asked;

    Unity.TestFile = "";
    Unity.CurrentTestName = name;
    asked = UnityTestMatches();
    Unity.TestFile = file;
    if (asked && lists_only) {
        printf("%s\n", name);
    }
    return asked && !lists_only;
}

static int parse(int argc, char *argv[])
{
    const int status = UnityParseOptions(argc, argv);

    lists_only = status < 0;
    return lists_only ? 0 : status;
}

static void say_what_is_missing(void)
{
    if (UnityOptionIncludeNamed) {
        printf("There is no test \"%s\"; -l lists all.\n", UnityOptionIncludeNamed);
    } else {
        printf("There is no test to run.\n");
    }
}

#else

static int is_asked_for(const char *name)
{
    (void)name;
    return 1;
}

static int parse(int argc, char *argv[])
{
    (void)argc;
    (void)argv;
    return 0;
}

static void say_what_is_missing(void)
{
    printf("There is no test to run.\n");
}

#endif

void test_run(void (*function)(void), const char *name, int line)
{
    if (is_asked_for(name)) {
        UnityDefaultTestRun(function, name, line);
    }
}

int test_main(int argc, char *argv[], const char *file, void (*run_tests)(void))
{
    const int status = parse(argc, argv);

    if (status != 0) {
        return status;
    }
    UnityBegin(file);
    run_tests();
#ifdef UNITY_USE_COMMAND_LINE_ARGS
    if (lists_only) {
        return 0;
    }
#endif
    if (Unity.NumberOfTests == 0) {
        say_what_is_missing();
        return 1;
    }
    return UnityEnd() != 0;
}

/* ---- numbers ------------------------------------------------------------- */

/* By a volatile variable, so that no compiler evaluates it or warns. */
double test_nan(void)
{
    volatile double zero = 0;

    return zero / zero;
}

double test_infinity(void)
{
    volatile double zero = 0;

    return 1 / zero;
}

void test_to_real(rigcal_real out[], const double in[], size_t n)
{
    for (size_t i = 0; i < n; i++) {
        out[i] = RC(in[i]);
    }
}

void test_to_double(double out[], const rigcal_real in[], size_t n)
{
    for (size_t i = 0; i < n; i++) {
        out[i] = D(in[i]);
    }
}

/* ---- assertions ---------------------------------------------------------- */

void test_assert_status(rigcal_status expected, rigcal_status actual, int line)
{
    char message[128];

    if (expected != actual) {
        snprintf(message, sizeof message, "expected %s (%d), was %s (%d)",
                 rigcal_status_name(expected), (int)expected, rigcal_status_name(actual),
                 (int)actual);
        UNITY_TEST_FAIL(line, message);
    }
}

void test_assert_near(double expected, double actual, double tol, int index, int line)
{
    char where[32] = "", message[160];

    /* In this form a NaN anywhere fails too. */
    if (isfinite(expected) && fabs(actual - expected) <= tol) {
        return;
    }
    if (index >= 0) {
        snprintf(where, sizeof where, "element %d: ", index);
    }
    snprintf(message, sizeof message,
             "%sexpected %.17g within %.3g, was %.17g (off by %.3g)", where, expected, tol,
             actual, actual - expected);
    UNITY_TEST_FAIL(line, message);
}

void test_assert_array_near(const double expected[], const rigcal_real actual[], size_t n,
                            double tol, int line)
{
    for (size_t i = 0; i < n; i++) {
        test_assert_near(expected[i], D(actual[i]), tol, (int)i, line);
    }
}

/* An unlikely finite number, whether read as a float, a double or an integer. */
enum { PATTERN = 0xA5 };

void test_fill(void *object, size_t size)
{
    memset(object, PATTERN, size);
}

void test_assert_untouched(const void *object, size_t size, const char *name, int line)
{
    const unsigned char *bytes = object;
    char message[160];

    for (size_t i = 0; i < size; i++) {
        if (bytes[i] != PATTERN) {
            snprintf(message, sizeof message,
                     "%s was written to (byte %u) though the call failed", name,
                     (unsigned)i);
            UNITY_TEST_FAIL(line, message);
        }
    }
}

/* ---- random numbers ------------------------------------------------------ */

test_rng test_seed(uint64_t seed)
{
    test_rng rng;

    rng.state = seed;
    return rng;
}

uint64_t test_next(test_rng *rng)
{
    uint64_t z = (rng->state += UINT64_C(0x9E3779B97F4A7C15));

    z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
    return z ^ (z >> 31);
}

double test_uniform(test_rng *rng, double low, double high)
{
    return low + (high - low) * ((double)(test_next(rng) >> 11) * 0x1p-53);
}

double test_normal(test_rng *rng)
{
    double sum = -6;

    for (int i = 0; i < 12; i++) {
        sum += test_uniform(rng, 0, 1);
    }
    return sum;
}

/* ---- geometry ------------------------------------------------------------ */

void test_product(double C[9], const double A[9], const double B[9])
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            C[3 * i + j] =
                A[3 * i] * B[j] + A[3 * i + 1] * B[3 + j] + A[3 * i + 2] * B[6 + j];
        }
    }
}

void test_transpose(double At[9], const double A[9])
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            At[3 * i + j] = A[3 * j + i];
        }
    }
}

void test_apply(double y[3], const double R[9], const double x[3], const double t[3])
{
    for (int i = 0; i < 3; i++) {
        y[i] = test_dot(R + 3 * i, x) + (t ? t[i] : 0);
    }
}

void test_cross(double c[3], const double a[3], const double b[3])
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

double test_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

double test_norm(const double a[3])
{
    return sqrt(test_dot(a, a));
}

void test_axes_of(double R_t[9], const double near_x[3], const double z[3])
{
    double length = test_norm(z), *const x = R_t, *const y = &R_t[3];

    for (int k = 0; k < 3; k++) {
        R_t[6 + k] = z[k] / length;
    }
    test_cross(x, near_x, &R_t[6]);
    length = test_norm(x);
    for (int k = 0; k < 3; k++) {
        x[k] /= length;
    }
    test_cross(y, &R_t[6], x);
}

double test_determinant(const double A[9])
{
    double c[3];

    test_cross(c, A + 3, A + 6);
    return test_dot(A, c);
}

void test_rotation(double R[9], double yaw, double pitch, double roll)
{
    const double cy = cos(yaw), sy = sin(yaw);
    const double cp = cos(pitch), sp = sin(pitch);
    const double cr = cos(roll), sr = sin(roll);
    const double Rz[9] = {cy, -sy, 0, sy, cy, 0, 0, 0, 1};
    const double Ry[9] = {cp, 0, sp, 0, 1, 0, -sp, 0, cp};
    const double Rx[9] = {1, 0, 0, 0, cr, -sr, 0, sr, cr};
    double RyRx[9];

    test_product(RyRx, Ry, Rx);
    test_product(R, Rz, RyRx);
}

void test_rotation_about(double R[9], const double axis[3], double angle)
{
    const double c = cos(angle), s = sin(angle), h = sin(angle / 2);
    const double versine = 2 * h * h; /* 1 - cos, without cancellation */
    const double length = test_norm(axis);
    const double x = axis[0] / length, y = axis[1] / length, z = axis[2] / length;

    R[0] = c + x * x * versine;
    R[1] = x * y * versine - z * s;
    R[2] = x * z * versine + y * s;
    R[3] = y * x * versine + z * s;
    R[4] = c + y * y * versine;
    R[5] = y * z * versine - x * s;
    R[6] = z * x * versine - y * s;
    R[7] = z * y * versine + x * s;
    R[8] = c + z * z * versine;
}

/* A random direction for the last row, and any turn about it. */
void test_random_rotation(double R[9], test_rng *rng)
{
    const double yaw = test_uniform(rng, -TEST_PI, TEST_PI);
    const double pitch = asin(test_uniform(rng, -1, 1));
    const double roll = test_uniform(rng, -TEST_PI, TEST_PI);

    test_rotation(R, yaw, pitch, roll);
}

double test_angle_between(const double A[9], const double B[9])
{
    double sum = 0;

    for (int i = 0; i < 9; i++) {
        sum += (A[i] - B[i]) * (A[i] - B[i]);
    }
    sum = sqrt(sum / 8);
    return 2 * asin(sum < 1 ? sum : 1);
}

void test_project(double xy[2], const double R[9], const double t[3], const double X[3])
{
    double p[3];

    test_apply(p, R, X, t);
    xy[0] = p[0] / p[2];
    xy[1] = p[1] / p[2];
}

void test_project_px(double uv[2], const rigcal_camera *camera, const double X_c[3])
{
    const double k1 = D(camera->k1), k2 = D(camera->k2), k3 = D(camera->k3);
    const double k4 = D(camera->k4), k5 = D(camera->k5), k6 = D(camera->k6);
    const double p1 = D(camera->p1), p2 = D(camera->p2);
    double xd, yd;

    if (camera->lens == RIGCAL_LENS_FISHEYE) {
        const double r = hypot(X_c[0], X_c[1]);
        const double theta = atan2(r, X_c[2]), q = theta * theta;
        const double bent = theta * (1 + q * (k1 + q * (k2 + q * (k3 + q * k4))));

        xd = r > 0 ? X_c[0] / r * bent : 0;
        yd = r > 0 ? X_c[1] / r * bent : 0;
    } else {
        const double x = X_c[0] / X_c[2], y = X_c[1] / X_c[2];
        const double q = x * x + y * y;
        const double d =
            (1 + q * (k1 + q * (k2 + q * k3))) / (1 + q * (k4 + q * (k5 + q * k6)));

        xd = x * d + 2 * p1 * x * y + p2 * (q + 2 * x * x);
        yd = y * d + p1 * (q + 2 * y * y) + 2 * p2 * x * y;
    }
    uv[0] = D(camera->fx) * xd + D(camera->cx);
    uv[1] = D(camera->fy) * yd + D(camera->cy);
}

rigcal_transform test_transform(const double R[9], const double t[3])
{
    rigcal_transform T = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};

    if (R) {
        test_to_real(T.R, R, 9);
    }
    if (t) {
        test_to_real(T.t, t, 3);
    }
    return T;
}

void test_transform_parts(double R[9], double t[3], const rigcal_transform *T)
{
    if (R) {
        test_to_double(R, T->R, 9);
    }
    if (t) {
        test_to_double(t, T->t, 3);
    }
}

/* ---- transforms ------------------------------------------------------------ */

rigcal_transform test_from_ypr(const double ypr[3], const double t[3])
{
    double R[9];

    test_rotation(R, ypr[0], ypr[1], ypr[2]);
    return test_transform(R, t);
}

rigcal_transform test_random_transform(test_rng *rng)
{
    double R[9], t[3];

    test_random_rotation(R, rng);
    for (int k = 0; k < 3; k++) {
        t[k] = test_uniform(rng, -5, 5);
    }
    return test_transform(R, t);
}

rigcal_transform test_turned_about(const double axis[3], double angle)
{
    double R[9];

    test_rotation_about(R, axis, angle);
    return test_transform(R, NULL);
}

rigcal_transform test_times(const rigcal_transform *c_from_b,
                            const rigcal_transform *b_from_a)
{
    double R_cb[9], R_ba[9], R[9], t_cb[3], t_ba[3], t[3];

    test_transform_parts(R_cb, t_cb, c_from_b);
    test_transform_parts(R_ba, t_ba, b_from_a);
    test_product(R, R_cb, R_ba);
    test_apply(t, R_cb, t_ba, t_cb);
    return test_transform(R, t);
}

rigcal_transform test_inverse(const rigcal_transform *b_from_a)
{
    double R[9], Rt[9], t[3], o[3];

    test_transform_parts(R, t, b_from_a);
    test_transpose(Rt, R);
    test_apply(o, Rt, t, NULL);
    for (int k = 0; k < 3; k++) {
        o[k] = -o[k];
    }
    return test_transform(Rt, o);
}

void test_move_point(double X_b[3], const rigcal_transform *b_from_a, const double X_a[3])
{
    double R[9], t[3];

    test_transform_parts(R, t, b_from_a);
    test_apply(X_b, R, X_a, t);
}

void test_assert_transform(const rigcal_transform *expected, const rigcal_transform *seen,
                           double tol_entry, double tol_length, int line)
{
    double R[9], t[3];

    test_transform_parts(R, t, expected);
    test_assert_array_near(R, seen->R, 9, tol_entry, line);
    test_assert_array_near(t, seen->t, 3, tol_length, line);
}

void test_assert_rotation(const double R[9], double tol, int line)
{
    double Rt[9], product[9];

    test_transpose(Rt, R);
    test_product(product, R, Rt);
    for (int k = 0; k < 9; k++) {
        test_assert_near(k % 4 == 0, product[k], tol, k, line);
    }
    test_assert_near(1, test_determinant(R), tol, -1, line);
}

/* ---- scenes -------------------------------------------------------------- */

static void place_points(test_scene *scene, test_rng *rng, test_shape shape)
{
    static const double corners[4][2] = {
        {-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
    const int planar = shape != TEST_GENERAL;
    double Q[9], s[3], x[3];

    test_random_rotation(Q, rng);
    for (int k = 0; k < 3; k++) {
        s[k] = test_uniform(rng, -1, 1);
    }
    for (int i = 0; i < scene->n; i++) {
        if (shape == TEST_SQUARE && i < 4) {
            x[0] = corners[i][0] + test_uniform(rng, -0.02, 0.02);
            x[1] = corners[i][1] + test_uniform(rng, -0.02, 0.02);
        } else {
            x[0] = test_uniform(rng, -0.5, 0.5);
            x[1] = test_uniform(rng, -0.5, 0.5);
        }
        x[2] = planar ? 0 : test_uniform(rng, -0.5, 0.5);
        test_apply(scene->X[i], Q, x, s);
    }
    /* Places the camera anywhere, except near the plane of the target. */
    for (;;) {
        double view[3], normal[3];
        const double distance = test_uniform(rng, 3, 10);
        const double off = test_uniform(rng, 0, tan(20 * TEST_PI / 180));
        const double way = test_uniform(rng, -TEST_PI, TEST_PI);

        test_random_rotation(scene->R, rng);
        view[0] = off * cos(way) * distance;
        view[1] = off * sin(way) * distance;
        view[2] = distance;
        for (int k = 0; k < 3; k++) {
            scene->t[k] = view[k] - test_dot(scene->R + 3 * k, s);
            x[k] = Q[3 * k + 2];
        }
        test_apply(normal, scene->R, x, NULL);
        if (!planar ||
            fabs(test_dot(normal, view)) > sin(15 * TEST_PI / 180) * test_norm(view)) {
            return;
        }
    }
}

void test_scene_random(test_scene *scene, test_rng *rng, int n, test_shape shape)
{
    if (n > TEST_SCENE_MAX && RIGCAL_TEST_RAM < 32768) {
        TEST_IGNORE_MESSAGE("wants more RAM than there is: more points");
    }
    TEST_ASSERT_MESSAGE(n <= TEST_SCENE_MAX, "TEST_SCENE_MAX is too small");
    scene->n = n;
    place_points(scene, rng, shape);
    scene->ypr[0] = atan2(scene->R[3], scene->R[0]);
    scene->ypr[1] = atan2(-scene->R[6], hypot(scene->R[7], scene->R[8]));
    scene->ypr[2] = atan2(scene->R[7], scene->R[8]);
    for (int i = 0; i < n; i++) {
        double X_c[3];

        test_apply(X_c, scene->R, scene->X[i], scene->t);
        scene->Z[i] = X_c[2];
        scene->xy[i][0] = X_c[0] / X_c[2];
        scene->xy[i][1] = X_c[1] / X_c[2];
    }
}

void test_bearings(rigcal_bearing out[], const test_scene *scene)
{
    for (int i = 0; i < scene->n; i++) {
        test_to_real(out[i].X_w, scene->X[i], 3);
        test_to_real(out[i].ray, scene->xy[i], 2);
        out[i].ray[2] = 1;
    }
}

void test_observations(rigcal_observation out[], const test_scene *scene,
                       const rigcal_camera *camera)
{
    for (int i = 0; i < scene->n; i++) {
        double X_c[3], uv[2];

        test_apply(X_c, scene->R, scene->X[i], scene->t);
        test_project_px(uv, camera, X_c);
        test_to_real(out[i].X_w, scene->X[i], 3);
        test_to_real(out[i].uv, uv, 2);
    }
}

rigcal_camera test_camera(const double v[15])
{
    rigcal_camera camera = {0};

    camera.lens = (int32_t)v[0];
    camera.width = (int32_t)v[1];
    camera.height = (int32_t)v[2];
    test_to_real(&camera.fx, v + 3, 4);
    test_to_real(&camera.k1, v + 7, 8);
    return camera;
}

rigcal_camera test_pinhole(void)
{
    const rigcal_camera camera = {
        .lens = RIGCAL_LENS_BROWN,
        .width = 640,
        .height = 480,
        .fx = 800,
        .fy = 800,
        .cx = RC(319.5),
        .cy = RC(239.5),
    };

    return camera;
}
