/* Mirrored coordinates were found for at most 64 points. With more the status was
 * ERR_RANGE. */
#include <math.h>
#include <string.h>

#include "test_support.h"

enum { N = 96 };

static rigcal_observation seen[N];

static void make(const rigcal_camera *camera)
{
    test_rng rng = test_seed(3);
    double R[9];
    static const double T[3] = {0.1, -0.2, 3};

    test_random_rotation(R, &rng);
    for (int i = 0; i < N; i++) {
        double X[3], X_c[3], uv[2];

        for (int k = 0; k < 3; k++) {
            X[k] = test_uniform(&rng, -0.5, 0.5);
        }
        test_apply(X_c, R, X, T);
        test_project_px(uv, camera, X_c);
        for (int k = 0; k < 2; k++) {
            uv[k] += 0.3 * test_normal(&rng);
        }
        test_to_real(seen[i].X_w, X, 3);
        test_to_real(seen[i].uv, uv, 2);
    }
}

static rigcal_diagnosis diagnosed(const rigcal_camera *camera)
{
    rigcal_diagnosis d;

    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_pose_diagnose(&d, NULL, &VIEW(camera, seen, NULL, N), NULL));
    return d;
}

static void test_mirrored_coordinates_are_told(void)
{
    rigcal_camera camera = test_pinhole();

    TEST_ON_HOST_ONLY("67 poses of 96 points");
    camera.p1 = RC(1e-3);
    make(&camera);
    for (int i = 0; i < N; i++) {
        seen[i].X_w[0] = -seen[i].X_w[0];
    }
    TEST_ASSERT_EQUAL_INT(RIGCAL_DIAGNOSIS_MIRRORED, diagnosed(&camera).verdict);
}

static void test_a_flipped_image_is_told(void)
{
    rigcal_camera camera = test_pinhole();
    rigcal_diagnosis d;

    TEST_ON_HOST_ONLY("67 poses of 96 points");
    camera.p1 = RC(2e-2); /* the flip changes the sign of this */
    camera.cy = RC(200);
    make(&camera);
    for (int i = 0; i < N; i++) {
        seen[i].uv[1] = RC(camera.height - 1) - seen[i].uv[1];
    }
    d = diagnosed(&camera);
    TEST_ASSERT_EQUAL_INT(RIGCAL_DIAGNOSIS_MIRRORED, d.verdict);
    TEST_ASSERT_TRUE(D(d.rms_flipped_px) < 0.5 &&
                     D(d.rms_mirrored_px) > D(d.rms_flipped_px));
}

/* The points that are farthest off are tried. */
static void test_one_wrong_point_of_many_is_told(void)
{
    const rigcal_camera camera = test_pinhole();
    rigcal_diagnosis d;

    TEST_ON_HOST_ONLY("67 poses of 96 points");
    make(&camera);
    seen[90].uv[0] += 40;
    d = diagnosed(&camera);
    TEST_ASSERT_EQUAL_INT(RIGCAL_DIAGNOSIS_ONE_POINT, d.verdict);
    TEST_ASSERT_EQUAL_INT32(90, d.blame.point);
    seen[90].uv[0] -= 40;
    TEST_ASSERT_EQUAL_INT(RIGCAL_DIAGNOSIS_CONSISTENT, diagnosed(&camera).verdict);
}

TEST_MAIN()
{
    RUN_TEST(test_mirrored_coordinates_are_told);
    RUN_TEST(test_a_flipped_image_is_told);
    RUN_TEST(test_one_wrong_point_of_many_is_told);
}
