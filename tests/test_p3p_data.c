/* p3p on real cameras: every group of examples/data/SET/reference_p3p.csv. The reference
 * has all solutions from three points of an image, found by OpenCV and from random starts.
 * It reads files, so it runs only on a host. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "rc_p3p.h"
#include "test_support.h"

enum { LINE = 1024, NAME = 32 };

/* Opens a file of a set and skips its header. */
static FILE *open_data(const char *set, const char *file)
{
    char path[LINE], header[LINE];
    FILE *stream;

    snprintf(path, sizeof path, "%s/%s/%s", RIGCAL_DATA_DIR, set, file);
    stream = fopen(path, "r");
    TEST_ASSERT_NOT_NULL_MESSAGE(stream, path);
    TEST_ASSERT_NOT_NULL(fgets(header, sizeof header, stream));
    return stream;
}

static rigcal_camera read_camera(const char *set, const char *name)
{
    FILE *stream = open_data(set, "cameras.csv");
    char line[LINE], at[NAME];
    double v[15] = {RIGCAL_LENS_BROWN};
    int found = 0;

    while (!found && fgets(line, sizeof line, stream) != NULL) {
        found = sscanf(line, "%31[^,],%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", at,
                       &v[1], &v[2], &v[3], &v[4], &v[5], &v[6], &v[7], &v[8], &v[9],
                       &v[10], &v[11]) == 12 &&
                strcmp(at, name) == 0;
    }
    fclose(stream);
    TEST_ASSERT_TRUE_MESSAGE(found, name);
    return test_camera(v);
}

static void read_point(double X[3], double uv[2], const char *set, const char *camera,
                       const char *frame, const char *point)
{
    FILE *stream = open_data(set, "observations.csv");
    char line[LINE], f[NAME], c[NAME], p[NAME];
    int found = 0;

    while (!found && fgets(line, sizeof line, stream) != NULL) {
        found = sscanf(line, "%31[^,],%31[^,],%31[^,],%lf,%lf,%lf,%lf,%lf", f, c, p, &X[0],
                       &X[1], &X[2], &uv[0], &uv[1]) == 8 &&
                strcmp(f, frame) == 0 && strcmp(c, camera) == 0 && strcmp(p, point) == 0;
    }
    fclose(stream);
    TEST_ASSERT_TRUE_MESSAGE(found, point);
}

/* A line of reference_p3p.csv. */
typedef struct {
    int group, solutions;
    char camera[NAME], frame[NAME], point[3][NAME];
    double R[9], t[3];
} reference;

static int read_reference(reference *r, FILE *stream)
{
    char line[LINE];
    double *const R = r->R, *const t = r->t;

    return fgets(line, sizeof line, stream) != NULL &&
           sscanf(line,
                  "%d,%31[^,],%31[^,],%31[^,],%31[^,],%31[^,],%d,%*d,%*d,%*f,%*f,"
                  "%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf",
                  &r->group, r->camera, r->frame, r->point[0], r->point[1], r->point[2],
                  &r->solutions, &R[0], &R[1], &R[2], &R[3], &R[4], &R[5], &R[6], &R[7],
                  &R[8], &t[0], &t[1], &t[2]) == 19;
}

/* Three points of an image, and all poses that they allow. */
typedef struct {
    double X[3][3], uv[3][2];
    rigcal_camera camera;
    rigcal_transform found[RC_P3P_MAX];
    int count;
} triple;

static void solve(triple *T, const char *set, const reference *r)
{
    rigcal_real x[3][3], ray[3][3];

    T->camera = read_camera(set, r->camera);
    for (int i = 0; i < 3; i++) {
        rigcal_real uv[2];

        read_point(T->X[i], T->uv[i], set, r->camera, r->frame, r->point[i]);
        test_to_real(x[i], T->X[i], 3);
        test_to_real(uv, T->uv[i], 2);
        ASSERT_STATUS(RIGCAL_OK, rigcal_camera_ray(ray[i], &T->camera, uv));
    }
    T->count = rc_p3p(T->found, (const rigcal_real(*)[3])x, (const rigcal_real(*)[3])ray);
}

/* The number of poses that put every point on its pixel. */
static int exact_ones(const triple *T)
{
    int count = 0;

    for (int i = 0; i < T->count; i++) {
        double R[9], t[3], worst = 0;

        test_transform_parts(R, t, &T->found[i]);
        for (int k = 0; k < 3; k++) {
            double X_c[3], uv[2];

            test_apply(X_c, R, T->X[k], t);
            test_project_px(uv, &T->camera, X_c);
            worst = fmax(worst, hypot(uv[0] - T->uv[k][0], uv[1] - T->uv[k][1]));
        }
        count += worst < TOL(1e-6, 0.05);
    }
    return count;
}

/* The error of the pose that is nearest to the reference: the largest distance of a point
 * from its reference place, over that point's distance. */
static double nearest(const triple *T, const reference *r)
{
    double least = 1e300;

    for (int i = 0; i < T->count; i++) {
        double R[9], t[3], worst = 0;

        test_transform_parts(R, t, &T->found[i]);
        for (int k = 0; k < 3; k++) {
            double here[3], there[3], d[3];

            test_apply(here, R, T->X[k], t);
            test_apply(there, r->R, T->X[k], r->t);
            for (int j = 0; j < 3; j++) {
                d[j] = here[j] - there[j];
            }
            worst = fmax(worst, test_norm(d) / test_norm(there));
        }
        least = fmin(least, worst);
    }
    return least;
}

static void check_set(const char *set, int groups)
{
    FILE *stream = open_data(set, "reference_p3p.csv");
    int last = -1, seen = 0, lines = 0;
    reference r;
    triple T;

    while (read_reference(&r, stream)) {
        if (r.group != last) {
            solve(&T, set, &r);
            TEST_ASSERT_EQUAL_INT(r.solutions, exact_ones(&T));
            last = r.group;
            seen++;
            lines += r.solutions;
        }
        /* The files have nine digits. */
        ASSERT_NEAR(0, nearest(&T, &r), TOL(2e-8, 1e-4));
        lines--;
    }
    fclose(stream);
    TEST_ASSERT_EQUAL_INT(groups, seen);
    TEST_ASSERT_EQUAL_INT(0, lines);
}

static void test_opencv_stereo(void)
{
    check_set("opencv_stereo", 14);
}

static void test_myptv_stepped(void)
{
    check_set("myptv_stepped", 18);
}

TEST_MAIN()
{
    RUN_TEST(test_opencv_stereo);
    RUN_TEST(test_myptv_stepped);
}
