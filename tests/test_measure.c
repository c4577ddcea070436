/* measure: points with their covariance, wrong views dropped, lengths between points. */
#include <math.h>
#include <string.h>

#include "test_support.h"
#include "vectors_camera.h"
#include "vectors_point.h"

enum { N = 20, FREE = 6 * N };

/* A rig with its joint covariance, and what it saw of a point. */
typedef struct {
    rigcal_mounted_camera cameras[N];
    int32_t group[N];
    uint8_t held[N];
    rigcal_real Sigma[RIGCAL_CALIBRATED_SIZE(N)], noise[N];
    rigcal_calibrated_rig rig;
    rigcal_sighting seen[N];
    rigcal_real work[RIGCAL_POINT_WORK(N)];
    rigcal_sightings s;
    double X[3];
} measuring;

static measuring m;
static rigcal_point_gain gains[N];
static rigcal_measured_point point;

#define WANTS_RIG TEST_WANTS_RAM(sizeof m + sizeof gains + 8000)

/* L L^T, L from small integers: as tests/vectors/point_oracle.py has it. */
static void fill_covariance(int n_free, int seed)
{
    static double L[FREE][FREE];
    const int n = 6 * n_free;

    for (int i = 0; i < n; i++) {
        const double scale = i % 6 < 3 ? 4e-4 : 2e-3;

        for (int j = 0; j < i; j++) {
            L[i][j] = scale * ((7 * i + 11 * j + 3 * seed) % 13 - 6) / 13;
        }
        L[i][i] = scale;
        for (int j = 0; j <= i; j++) {
            double sum = 0;

            for (int k = 0; k <= j; k++) {
                sum += L[i][k] * L[j][k];
            }
            m.Sigma[i * (i + 1) / 2 + j] = RC(sum);
        }
    }
}

static void clear(int n, int n_held)
{
    memset(&m, 0, sizeof m);
    m.rig.cameras = m.cameras;
    m.rig.group = m.group;
    m.rig.held = m.held;
    m.rig.Sigma = m.Sigma;
    m.rig.capacity = N;
    m.rig.Sigma_capacity = RIGCAL_CALIBRATED_SIZE(N);
    m.rig.n_cameras = (size_t)n;
    m.rig.sigma_px = 1;
    m.s.rig = &m.rig;
    m.s.seen = m.seen;
    m.s.n = (size_t)n;
    m.s.sigma_px = m.noise;
    m.s.work = m.work;
    m.s.work_capacity = RIGCAL_POINT_WORK(N);
    for (int i = 0; i < n; i++) {
        m.held[i] = i < n_held;
        m.seen[i].camera = i;
    }
    memset(&point, 0, sizeof point);
    point.gains = gains;
    point.gains_capacity = N;
}

/* ---- against dense algebra --------------------------------------------------- */

static const double *golden(int row)
{
    const double *v = POINT[row];
    const int n = (int)v[0], held = (int)v[1];

    clear(n, held);
    fill_covariance(n - held, (int)v[2]);
    for (int i = 0; i < n; i++) {
        const double *view = v + 3 + 10 * i;

        m.cameras[i].camera = test_camera(CAMERA[(int)view[0]]);
        m.cameras[i].cam_from_rig = test_from_ypr(view + 1, view + 4);
        test_to_real(m.seen[i].uv, view + 7, 2);
        m.noise[i] = RC(view[9]);
    }
    m.s.keep_all = 1;
    return v + 53;
}

static double largest(const double A[], int n)
{
    double most = 0;

    for (int i = 0; i < n; i++) {
        most = fmax(most, fabs(A[i]));
    }
    return most;
}

static void test_points_are_those_of_dense_algebra(void)
{
    WANTS_RIG;
    for (int row = 0; row < POINT_ROWS; row++) {
        const double *v = golden(row);
        const double sigma = sqrt(largest(v + 3, 9));
        const rigcal_status status = rigcal_point_measure(&point, NULL, &m.s);

        TEST_ASSERT_TRUE(status == RIGCAL_OK || status == RIGCAL_POOR_FIT);
        ASSERT_ARRAY_NEAR(v, point.X, 3, TOL(1e-6, 2e-3) * sigma);
        ASSERT_ARRAY_NEAR(v + 3, point.Sigma, 9, TOL(1e-4, 1e-3) * sigma * sigma);
        ASSERT_ARRAY_NEAR(v + 12, point.Sigma_noise, 9, TOL(1e-4, 1e-3) * sigma * sigma);
        ASSERT_NEAR(v[21], point.chi2, TOL(1e-4, 1e-2) * (1 + v[21]));
        ASSERT_NEAR(v[22], point.rms_px, TOL(1e-6, 2e-3));
        ASSERT_NEAR(2 * POINT[row][0] - 3, point.freedom, 0);
        TEST_ASSERT_EQUAL_UINT64((uint64_t)POINT[row][0], point.n_used);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_points_are_those_of_dense_algebra);
}
