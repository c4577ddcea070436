/* store: a calibration as bytes and back. The expected bytes were made by Python's struct
 * and zlib (tests/vectors). Refusals are tested completely: every length that is too short,
 * and every flipped bit. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rc_store.h"
#include "test_support.h"
#include "vectors_store.h"

enum {
    N = STORE_CAMERA_ROWS,
    DOUBLE_BYTES = 32 + 376 * N,
    FLOAT_BYTES = 32 + 196 * N,
    OWN_BYTES = RIGCAL_USE_FLOAT ? FLOAT_BYTES : DOUBLE_BYTES,
    OTHER_BYTES = RIGCAL_USE_FLOAT ? DOUBLE_BYTES : FLOAT_BYTES,
    OWN_REAL = RIGCAL_USE_FLOAT ? 4 : 8,
    OTHER_REAL = RIGCAL_USE_FLOAT ? 8 : 4
};

/* A page of flash memory. */
enum { PAGE = RIGCAL_TEST_RAM < 32768 ? 2048 : 4096 };

static rigcal_mounted_camera calibration[N];
static uint32_t sequence, tag;
static uint8_t own[OWN_BYTES], other[OTHER_BYTES];

static void camera_of_row(rigcal_mounted_camera *m, const double row[64])
{
    double v[15];

    memset(m, 0, sizeof *m);
    memcpy(v, row, 3 * sizeof v[0]);
    memcpy(v + 3, row + 4, 12 * sizeof v[0]);
    m->camera = test_camera(v);
    m->has_Sigma = (int32_t)row[3];
    m->cam_from_rig = test_transform(row + 16, row + 25);
    test_to_real(m->Sigma, row + 28, 36);
}

static void bytes_of_row(uint8_t bytes[], const double row[], size_t n)
{
    for (size_t i = 0; i < n; i++) {
        bytes[i] = (uint8_t)row[i];
    }
}

void setUp(void)
{
    for (int i = 0; i < N; i++) {
        camera_of_row(&calibration[i], STORE_CAMERA[i]);
    }
    sequence = (uint32_t)STORE_NUMBERS[0][0];
    tag = (uint32_t)STORE_NUMBERS[0][1];
    bytes_of_row(own, RIGCAL_USE_FLOAT ? STORE_FLOAT[0] : STORE_DOUBLE[0], OWN_BYTES);
    bytes_of_row(other, RIGCAL_USE_FLOAT ? STORE_DOUBLE[0] : STORE_FLOAT[0], OTHER_BYTES);
}

void tearDown(void)
{
}

/* ---- helpers ------------------------------------------------------------- */

static int same_bits(const void *a, const void *b, size_t size)
{
    return memcmp(a, b, size) == 0;
}

static void assert_same_camera(const rigcal_mounted_camera *expected,
                               const rigcal_mounted_camera *actual)
{
    TEST_ASSERT_EQUAL_INT32(expected->camera.lens, actual->camera.lens);
    TEST_ASSERT_EQUAL_INT32(expected->camera.width, actual->camera.width);
    TEST_ASSERT_EQUAL_INT32(expected->camera.height, actual->camera.height);
    TEST_ASSERT_TRUE(same_bits(&expected->camera.fx, &actual->camera.fx,
                               12 * sizeof expected->camera.fx));
    TEST_ASSERT_TRUE(same_bits(&expected->cam_from_rig, &actual->cam_from_rig,
                               sizeof expected->cam_from_rig));
    TEST_ASSERT_TRUE(same_bits(expected->Sigma, actual->Sigma, sizeof expected->Sigma));
    TEST_ASSERT_EQUAL_INT32(expected->has_Sigma, actual->has_Sigma);
}

static void put_u32(uint8_t *at, uint32_t x)
{
    for (int i = 0; i < 4; i++) {
        at[i] = (uint8_t)(x >> 8 * i);
    }
}

/* The CRC computed bit by bit, from its definition. */
static uint32_t plain_crc(const uint8_t bytes[], size_t n)
{
    uint32_t crc = 0xffffffff;

    for (size_t i = 0; i < 8 * n; i++) {
        const uint32_t bit = (crc ^ (uint32_t)bytes[i / 8] >> i % 8) & 1;

        crc = crc >> 1 ^ (bit ? 0xedb88320 : 0);
    }
    return ~crc;
}

/* Corrects the CRCs after the bytes were changed on purpose. */
static void seal(uint8_t bytes[], size_t n)
{
    put_u32(bytes + 24, plain_crc(bytes + 32, n - 32));
    put_u32(bytes + 28, plain_crc(bytes, 28));
}

/* Little-endian bytes of a number of either precision. */
static void put_double(uint8_t *at, double x)
{
    uint64_t bits;

    memcpy(&bits, &x, sizeof bits);
    put_u32(at, (uint32_t)bits);
    put_u32(at + 4, (uint32_t)(bits >> 32));
}

static void put_float(uint8_t *at, float x)
{
    uint32_t bits;

    memcpy(&bits, &x, sizeof bits);
    put_u32(at, bits);
}

static void put_number(uint8_t *at, double x, int real_bytes)
{
    if (real_bytes == 8) {
        put_double(at, x);
    } else {
        put_float(at, (float)x);
    }
}

/* Loads exactly these bytes, from memory that ends where they do. It must refuse them with
 * `expected`, or with any status of damage (0), and write nothing. */
static rigcal_status assert_refused(rigcal_status expected, const uint8_t bytes[], size_t n)
{
    rigcal_mounted_camera cameras[N];
    rigcal_saved_info info;
    rigcal_status status;
    uint8_t *exact = malloc(n > 0 ? n : 1);

    if (exact == NULL && RIGCAL_TEST_RAM < 32768) {
        TEST_IGNORE_MESSAGE("wants more RAM than there is: a copy of the bytes");
    }
    TEST_ASSERT_NOT_NULL(exact);
    memcpy(exact, bytes, n);
    FILL(cameras);
    FILL(info);
    status = rigcal_store_load(cameras, N, &info, exact, n);
    ASSERT_UNTOUCHED(cameras);
    ASSERT_UNTOUCHED(info);
    if (expected == 0) {
        TEST_ASSERT_TRUE(status == RIGCAL_ERR_DAMAGED || status == RIGCAL_ERR_FOREIGN);
        ASSERT_STATUS(status, rigcal_store_info(&info, exact, n));
        ASSERT_UNTOUCHED(info);
    } else {
        ASSERT_STATUS(expected, status);
    }
    free(exact);
    return status;
}

/* ---- golden bytes -------------------------------------------------------- */

static void test_the_size_is_as_the_table_says(void)
{
    static uint8_t buffer[RIGCAL_STORE_SIZE(N)];

    TEST_ASSERT_EQUAL_size_t(OWN_BYTES, sizeof buffer);
    TEST_ASSERT_EQUAL_size_t(0, rigcal_store_size(0));
    TEST_ASSERT_EQUAL_size_t(OWN_BYTES, rigcal_store_size(N));
    TEST_ASSERT_EQUAL_size_t(32 + 65535 * (size_t)(16 + 45 * OWN_REAL),
                             rigcal_store_size(65535));
    TEST_ASSERT_EQUAL_size_t(0, rigcal_store_size(65536));
    TEST_ASSERT_EQUAL_size_t(0, rigcal_store_size(SIZE_MAX));
    TEST_ASSERT_EQUAL_size_t(DOUBLE_BYTES, RIGCAL_STORE_SIZE_OF(N, 8));
    TEST_ASSERT_EQUAL_size_t(FLOAT_BYTES, RIGCAL_STORE_SIZE_OF(N, 4));
}

static void test_a_calibration_is_saved_as_the_bytes_that_python_packs(void)
{
    uint8_t bytes[OWN_BYTES + 1];
    size_t n = 77;

    memset(bytes, 0x5a, sizeof bytes);
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_save(bytes, sizeof bytes, &n, calibration, N,
                                               sequence, tag));
    TEST_ASSERT_EQUAL_size_t(OWN_BYTES, n);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(own, bytes, OWN_BYTES);
    TEST_ASSERT_EQUAL_HEX8(0x5a, bytes[OWN_BYTES]);
}

static void test_those_bytes_are_loaded_as_the_calibration(void)
{
    rigcal_mounted_camera cameras[N];
    rigcal_saved_info info;

    FILL(cameras);
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_load(cameras, N, &info, own, sizeof own));
    for (int i = 0; i < N; i++) {
        assert_same_camera(&calibration[i], &cameras[i]);
    }
    TEST_ASSERT_EQUAL_HEX32(sequence, info.sequence);
    TEST_ASSERT_EQUAL_HEX32(tag, info.tag);
    TEST_ASSERT_EQUAL_INT32(N, info.n_cameras);
    TEST_ASSERT_EQUAL_INT32(-1, info.n_free);
    TEST_ASSERT_EQUAL_INT32(OWN_BYTES, info.n_bytes);
    TEST_ASSERT_EQUAL_INT32(OWN_REAL, info.real_bytes);
}

/* A float build rounds what a double build stored; the result is `calibration`. A double
 * build gets the floats, except for the rotation, which is the nearest rotation to them. */
static void test_the_bytes_of_the_other_precision_are_loaded_too(void)
{
    rigcal_mounted_camera cameras[N];
    rigcal_saved_info info;

    ASSERT_STATUS(RIGCAL_OK, rigcal_store_load(cameras, N, &info, other, sizeof other));
    TEST_ASSERT_EQUAL_INT32(OTHER_BYTES, info.n_bytes);
    TEST_ASSERT_EQUAL_INT32(OTHER_REAL, info.real_bytes);
    for (int i = 0; i < N; i++) {
        rigcal_mounted_camera expected = calibration[i];

        if (!RIGCAL_USE_FLOAT) {
            double R[9], Rt[9], RRt[9];
            double row[64];

            for (int k = 0; k < 64; k++) {
                row[k] = (double)(float)STORE_CAMERA[i][k];
            }
            camera_of_row(&expected, row);
            test_to_double(R, cameras[i].cam_from_rig.R, 9);
            test_transpose(Rt, R);
            test_product(RRt, R, Rt);
            for (int k = 0; k < 9; k++) {
                ASSERT_NEAR(k % 4 == 0, RRt[k], 1e-15);
                ASSERT_NEAR(row[16 + k], R[k], 1e-7);
            }
            memcpy(expected.cam_from_rig.R, cameras[i].cam_from_rig.R,
                   sizeof expected.cam_from_rig.R);
        }
        assert_same_camera(&expected, &cameras[i]);
    }
}

/* ---- there and back ------------------------------------------------------ */

/* A A^T for a random A, which may have a row of zeros. */
static void random_covariance(rigcal_real Sigma[36], test_rng *rng)
{
    const int zero = (int)test_uniform(rng, 0, 12);
    double A[36];

    for (int k = 0; k < 36; k++) {
        A[k] = k / 6 == zero ? 0 : test_normal(rng);
    }
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j <= i; j++) {
            double sum = 0;

            for (int k = 0; k < 6; k++) {
                sum += A[6 * i + k] * A[6 * j + k];
            }
            Sigma[6 * i + j] = Sigma[6 * j + i] = RC(sum);
        }
    }
}

static rigcal_mounted_camera random_camera(test_rng *rng)
{
    rigcal_mounted_camera m;
    double R[9];

    memset(&m, 0, sizeof m);
    m.camera.lens = test_uniform(rng, 0, 1) < 0.5 ? RIGCAL_LENS_BROWN : RIGCAL_LENS_FISHEYE;
    m.camera.width = (int32_t)test_uniform(rng, 1, 1000000);
    m.camera.height = (int32_t)test_uniform(rng, 1, 1000000);
    m.camera.fx = RC(test_uniform(rng, 1, 5000));
    m.camera.fy = RC(test_uniform(rng, 1, 5000));
    m.camera.cx = RC(test_normal(rng) * 1e3);
    m.camera.cy = RC(-0.0);
    m.camera.k1 = RC(test_normal(rng));
    m.camera.k2 = RC(test_normal(rng) * 1e8);
    m.camera.k3 = RC(test_normal(rng) * TOL(1e-310, 1e-40)); /* denormal */
    m.camera.k4 = RC(-1e9);
    test_random_rotation(R, rng);
    test_to_real(m.cam_from_rig.R, R, 9);
    for (int k = 0; k < 3; k++) {
        m.cam_from_rig.t[k] = RC(test_normal(rng) * TOL(1e29, 1e8));
    }
    m.has_Sigma = test_uniform(rng, 0, 1) < 0.5;
    if (m.has_Sigma) {
        random_covariance(m.Sigma, rng);
    }
    return m;
}

static void test_what_was_saved_is_loaded_bit_by_bit(void)
{
    enum { MOST = 4 };
    static const uint32_t NUMBERS[] = {0, 1, 0x7fffffff, 0x80000000, UINT32_MAX};
    static uint8_t bytes[RIGCAL_STORE_SIZE(MOST)];
    test_rng rng = test_seed(41);

    for (int trial = 0; trial < TEST_TRIALS(500); trial++) {
        const size_t n = 1 + (size_t)trial % MOST;
        const uint32_t a = NUMBERS[trial % 5], b = NUMBERS[trial / 5 % 5];
        static rigcal_mounted_camera saved[MOST], loaded[MOST];
        rigcal_saved_info info, found;
        size_t size;

        for (size_t i = 0; i < n; i++) {
            saved[i] = random_camera(&rng);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_store_save(bytes, rigcal_store_size(n), &size,
                                                   saved, n, a, b));
        TEST_ASSERT_EQUAL_size_t(rigcal_store_size(n), size);
        FILL(loaded);
        ASSERT_STATUS(RIGCAL_OK, rigcal_store_load(loaded, n, &info, bytes, size));
        for (size_t i = 0; i < n; i++) {
            assert_same_camera(&saved[i], &loaded[i]);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_store_info(&found, bytes, size));
        TEST_ASSERT_TRUE(same_bits(&info, &found, sizeof info));
        TEST_ASSERT_EQUAL_HEX32(a, info.sequence);
        TEST_ASSERT_EQUAL_HEX32(b, info.tag);
    }
}

/* A covariance with 4 on the diagonal and 1 elsewhere, of which two elements are
 * changed. */
static void test_what_is_no_covariance_is_not_saved(void)
{
    static const struct {
        int at[2];
        double value[2];
        rigcal_status status;
    } CASES[] = {
        {{0, 0}, {4, 4}, RIGCAL_OK},
        {{6, 1}, {1.0000000001, 1}, RIGCAL_OK}, /* rounding */
        {{6, 1}, {4, 4}, RIGCAL_ERR_RANGE},     /* 0 instead of 1, inconsistent with a third
                                                   unknown */
        {{6, 1}, {1, -5}, RIGCAL_ERR_RANGE},    /* not symmetric */
        {{6, 1}, {5, 5}, RIGCAL_ERR_RANGE},     /* a correlation above 1 */
        {{6, 1}, {1e30, 1e30}, RIGCAL_ERR_RANGE},
        {{7, 7}, {0, 0}, RIGCAL_ERR_RANGE}, /* covariance without variance */
        {{35, 35}, {-1, -1}, RIGCAL_ERR_RANGE},
        {{35, 35}, {1e-3, 1e-3}, RIGCAL_ERR_RANGE}, /* not definite together */
    };
    uint8_t bytes[RIGCAL_STORE_SIZE(1)];
    size_t n;

    for (size_t k = 0; k < sizeof CASES / sizeof CASES[0]; k++) {
        rigcal_mounted_camera m = calibration[1], loaded;
        rigcal_saved_info info;

        for (int i = 0; i < 36; i++) {
            m.Sigma[i] = RC(i % 7 == 0 ? 4 : i / 6 - i % 6 == 1 || i % 6 - i / 6 == 1);
        }
        for (int i = 0; i < 2; i++) {
            m.Sigma[CASES[k].at[i]] = RC(CASES[k].value[i]);
        }
        ASSERT_STATUS(CASES[k].status,
                      rigcal_store_save(bytes, sizeof bytes, &n, &m, 1, 0, 0));
        if (CASES[k].status == RIGCAL_OK) {
            ASSERT_STATUS(RIGCAL_OK, rigcal_store_load(&loaded, 1, &info, bytes, n));
            TEST_ASSERT_TRUE(D(loaded.Sigma[1]) >= D(m.Sigma[6]) &&
                             D(loaded.Sigma[1]) <= D(m.Sigma[6]));
        }
    }
}

/* Unknowns 0 and 4 have the variances 4 and 1/16, and the others 1. What is added to a
 * correlation is a part of the tolerance, 1e-9 (float: 1e-5). */
static void test_rounding_of_a_correlation_is_accepted_within_its_tolerance(void)
{
    const double tol = TOL(1e-9, 1e-5);
    const struct {
        double below, above; /* covariances of 0 and 4, on both sides of the diagonal */
        rigcal_status status;
    } CASES[] = {
        {0.5 * (1 + 0.4 * tol), 0.5 * (1 + 0.4 * tol), RIGCAL_OK}, /* correlated fully */
        {-0.5 * (1 + 0.4 * tol), -0.5 * (1 + 0.4 * tol), RIGCAL_OK},
        {0.5 * (1 + 2 * tol), 0.5 * (1 + 2 * tol), RIGCAL_ERR_RANGE},
        {-0.5 * (1 + 2 * tol), -0.5 * (1 + 2 * tol), RIGCAL_ERR_RANGE},
        {0.5 * 0.7 * tol, 0, RIGCAL_OK}, /* not symmetric */
        {0, 0.5 * 0.7 * tol, RIGCAL_OK},
        {0, 0.5 * tol, RIGCAL_OK},
        {0.5 * 1.5 * tol, 0, RIGCAL_ERR_RANGE},
        {0, 0.5 * 1.5 * tol, RIGCAL_ERR_RANGE},
    };
    uint8_t bytes[RIGCAL_STORE_SIZE(1)];
    size_t n;

    for (size_t k = 0; k < sizeof CASES / sizeof CASES[0]; k++) {
        rigcal_mounted_camera m = calibration[1];

        for (int i = 0; i < 36; i++) {
            m.Sigma[i] = RC(i % 7 == 0);
        }
        m.Sigma[0] = 4;
        m.Sigma[28] = RC(0.0625);
        m.Sigma[24] = RC(CASES[k].below);
        m.Sigma[4] = RC(CASES[k].above);
        ASSERT_STATUS(CASES[k].status,
                      rigcal_store_save(bytes, sizeof bytes, &n, &m, 1, 0, 0));
    }
}

/* Three unknowns whose pairs are possible, but whose determinant is below 0. */
static void test_three_correlations_that_contradict_each_other_are_refused(void)
{
    static const double R[][3] = {{0.9, 0.9, 0.3}, {0.9, -0.9, 0}, {0.5, 0.8, -0.2}};
    uint8_t bytes[RIGCAL_STORE_SIZE(1)];
    size_t n;

    for (int k = 0; k < 3; k++) {
        for (int first = 0; first < 4; first++) {
            for (int possible = 0; possible < 2; possible++) {
                const double a = R[k][0], b = R[k][1], c = possible ? a * b : R[k][2];
                rigcal_mounted_camera m = calibration[1];
                rigcal_real *const S = m.Sigma + 7 * first;

                for (int i = 0; i < 36; i++) {
                    m.Sigma[i] = RC(i % 7 == 0);
                }
                S[1] = S[6] = RC(a);
                S[2] = S[12] = RC(b);
                S[8] = S[13] = RC(c);
                TEST_ASSERT_TRUE((1 + 2 * a * b * c - a * a - b * b - c * c > 0) ==
                                 possible);
                ASSERT_STATUS(possible ? RIGCAL_OK : RIGCAL_ERR_RANGE,
                              rigcal_store_save(bytes, sizeof bytes, &n, &m, 1, 0, 0));
            }
        }
    }
}

/* Nothing reads the bytes that a compiler leaves between two fields. */
static void test_what_is_between_the_fields_of_a_camera_is_not_read(void)
{
    static rigcal_mounted_camera m;
    uint8_t bytes[2][RIGCAL_STORE_SIZE(1)];
    size_t n;

    for (int k = 0; k < 2; k++) {
        const rigcal_mounted_camera *const from = &calibration[1];

        memset(&m, k == 0 ? 0 : 0xff, sizeof m);
        m.camera.lens = from->camera.lens;
        m.camera.width = from->camera.width;
        m.camera.height = from->camera.height;
        memcpy(&m.camera.fx, &from->camera.fx, 12 * sizeof from->camera.fx);
        memcpy(&m.cam_from_rig, &from->cam_from_rig, sizeof m.cam_from_rig);
        memcpy(m.Sigma, from->Sigma, sizeof m.Sigma);
        m.has_Sigma = from->has_Sigma;
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_store_save(bytes[k], sizeof bytes[k], &n, &m, 1, 0, 0));
    }
    TEST_ASSERT_EQUAL_HEX8_ARRAY(bytes[0], bytes[1], n);
}

static void test_an_exact_pose_has_a_covariance_of_zeros(void)
{
    rigcal_mounted_camera loaded;
    rigcal_saved_info info;
    uint8_t bytes[RIGCAL_STORE_SIZE(1)];
    size_t n;

    calibration[0].has_Sigma = 1; /* the first camera of a rig, with zeros */
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_store_save(bytes, sizeof bytes, &n, calibration, 1, 0, 0));
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_load(&loaded, 1, &info, bytes, n));
    assert_same_camera(&calibration[0], &loaded);
}

static void test_a_covariance_that_is_not_known_is_not_read(void)
{
    rigcal_mounted_camera loaded;
    rigcal_saved_info info;
    uint8_t bytes[RIGCAL_STORE_SIZE(1)];
    size_t n;

    calibration[1].has_Sigma = 0;
    calibration[1].Sigma[0] = TEST_NAN;
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_store_save(bytes, sizeof bytes, &n, calibration + 1, 1, 0, 0));
    for (size_t i = n - 21 * OWN_REAL; i < n; i++) {
        TEST_ASSERT_EQUAL_HEX8(0, bytes[i]);
    }
    FILL(loaded);
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_load(&loaded, 1, &info, bytes, n));
    for (int i = 0; i < 36; i++) {
        TEST_ASSERT_EQUAL_DOUBLE(0, D(loaded.Sigma[i]));
    }
    TEST_ASSERT_EQUAL_INT32(0, loaded.has_Sigma);
    /* Nor is it if the bytes contain a covariance. */
    put_number(bytes + n - OWN_REAL, test_nan(), OWN_REAL);
    seal(bytes, n);
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_load(&loaded, 1, &info, bytes, n));
    TEST_ASSERT_EQUAL_DOUBLE(0, D(loaded.Sigma[35]));
}

/* ---- numbers of the other precision -------------------------------------- */

/* The eight coefficients of Brown's lens may be any numbers within 1e9, a variance any
 * number that is not negative. So they can carry numbers through the bytes of the other
 * precision. */
enum {
    CARRIED = 8,
    COEFFICIENTS_AT = 32 + 16 + 4 * OTHER_REAL,
    HAS_SIGMA_AT = 32 + 12,
    VARIANCE_AT = 32 + 16 + 24 * OTHER_REAL
};

static rigcal_status carried(rigcal_real out[CARRIED])
{
    rigcal_mounted_camera cameras[N];
    rigcal_saved_info info;
    rigcal_status status;

    seal(other, sizeof other);
    status = rigcal_store_load(cameras, N, &info, other, sizeof other);
    if (status == RIGCAL_OK) {
        memcpy(out, &cameras[0].camera.k1, CARRIED * sizeof out[0]);
    }
    return status;
}

static double double_of_bits(uint64_t bits)
{
    double x;

    memcpy(&x, &bits, sizeof x);
    return x;
}

/* Whether x rounds to a finite float. */
static int fits_a_float(double x)
{
    return fabs(x) < ldexp(1.0 - ldexp(1, -25), 128);
}

/* Carries a number that is too large for a coefficient, as the only variance. */
static void carry_as_variance(double x)
{
    static uint8_t bytes[sizeof other];
    rigcal_mounted_camera cameras[N];
    rigcal_saved_info info;
    const float expected = (float)x;

    memcpy(bytes, other, sizeof bytes);
    put_u32(bytes + HAS_SIGMA_AT, 1);
    memset(bytes + VARIANCE_AT, 0, 21 * OTHER_REAL);
    put_double(bytes + VARIANCE_AT, x);
    for (int i = 0; i < CARRIED; i++) {
        put_double(bytes + COEFFICIENTS_AT + 8 * i, 0);
    }
    seal(bytes, sizeof bytes);
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_load(cameras, N, &info, bytes, sizeof bytes));
    TEST_ASSERT_TRUE(same_bits(&expected, &cameras[0].Sigma[0], sizeof expected));
}

/* Collects numbers until there are enough to be carried at once. */
static double collected[CARRIED];
static int n_collected;

static void carry_as_float(double x)
{
    rigcal_real seen[CARRIED];

    if (!fits_a_float(x)) {
        put_double(other + COEFFICIENTS_AT, x);
        ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, carried(seen));
        return;
    }
    if (fabs(x) > 1e9) {
        carry_as_variance(fabs(x));
        return;
    }
    collected[n_collected++] = x;
    if (n_collected < CARRIED) {
        return;
    }
    for (int i = 0; i < CARRIED; i++) {
        put_double(other + COEFFICIENTS_AT + 8 * i, collected[i]);
    }
    ASSERT_STATUS(RIGCAL_OK, carried(seen));
    for (int i = 0; i < CARRIED; i++) {
        const float expected = (float)collected[i]; /* rounded by this machine */

        TEST_ASSERT_TRUE(same_bits(&expected, &seen[i], sizeof expected));
    }
    n_collected = 0;
}

/* Every exponent, with: no digits, all digits, a tie with an odd and with an even
 * neighbour, slightly more and less than these, random digits. */
static void test_a_float_build_rounds_doubles_to_nearest(void)
{
    test_rng rng = test_seed(42);

    n_collected = 0;
    for (uint64_t exponent = 0; exponent < 2048; exponent++) {
        const int drop = 29 + (exponent < 897 ? (int)(897 - exponent) : 0);
        const uint64_t tie = drop <= 52 ? UINT64_C(1) << (drop - 1) : 0;

        if (exponent > 1152 && exponent % 128 != 0 && exponent < 2046) {
            continue; /* far too large; all are alike */
        }
        if (TEST_ONE_IN > 1 && exponent % 8 != 0 && (exponent < 860 || exponent > 900)) {
            continue; /* not near the least normal float */
        }
        for (int k = 0; k < 24; k++) {
            const uint64_t some = test_next(&rng);
            const uint64_t special[] = {0,       1,       ~UINT64_C(0), tie,        tie + 1,
                                        tie - 1, 3 * tie, 3 * tie + 1,  3 * tie - 1};
            uint64_t fraction = k % 2 == 0 ? some : some * 2 * tie + tie;

            if (k < (int)(sizeof special / sizeof special[0])) {
                fraction = special[k];
            }
            fraction &= (UINT64_C(1) << 52) - 1;
            carry_as_float(double_of_bits(exponent << 52 | fraction));
            carry_as_float(double_of_bits(UINT64_C(1) << 63 | exponent << 52 | fraction));
        }
    }
}

static void test_a_double_build_takes_floats_as_they_are(void)
{
    test_rng rng = test_seed(43);

    for (uint32_t exponent = 0; exponent < 256; exponent++) {
        for (int k = 0; k < 16; k++) {
            const uint32_t fraction = k == 0 ? 0 : (uint32_t)test_next(&rng) & 0x7fffff;
            const uint32_t bits = (uint32_t)(k & 1) << 31 | exponent << 23 | fraction;
            rigcal_real seen[CARRIED];
            float x;

            memcpy(&x, &bits, sizeof x);
            put_u32(other + COEFFICIENTS_AT, bits);
            if (exponent == 255) {
                ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, carried(seen));
            } else if (fabs((double)x) > 1e9) {
                ASSERT_STATUS(RIGCAL_ERR_CAMERA, carried(seen));
            } else {
                ASSERT_STATUS(RIGCAL_OK, carried(seen));
                /* Exact: the same number, and a zero has the same sign. */
                TEST_ASSERT_TRUE((double)x == D(seen[0]));
                TEST_ASSERT_EQUAL_INT(signbit(x) != 0, signbit(seen[0]) != 0);
            }
        }
    }
}

/* The float build accepts a rotation that is right to 1e-3. The double build corrects it,
 * but refuses what the float build would refuse. */
static void test_a_rotation_of_floats_is_mended_within_their_tolerance(void)
{
    const int R_at = 32 + 16 + 12 * 4;
    rigcal_mounted_camera cameras[N];
    rigcal_saved_info info;

    put_float(other + R_at, 1.0004f);
    put_float(other + R_at + 4, 3e-4f);
    seal(other, sizeof other);
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_load(cameras, N, &info, other, sizeof other));
    for (int i = 0; i < 9; i++) {
        ASSERT_NEAR(i % 4 == 0, cameras[0].cam_from_rig.R[i], 5e-4);
    }
    {
        double R[9];

        test_to_double(R, cameras[0].cam_from_rig.R, 9);
        ASSERT_NEAR(1, test_determinant(R), 1e-15);
    }
    put_float(other + R_at, 1.003f);
    seal(other, sizeof other);
    assert_refused(RIGCAL_ERR_ROTATION, other, sizeof other);
    put_float(other + R_at, -1.0f); /* a mirror */
    seal(other, sizeof other);
    assert_refused(RIGCAL_ERR_ROTATION, other, sizeof other);
}

/* ---- damage -------------------------------------------------------------- */

static void test_every_length_too_short_is_refused(void)
{
    for (size_t n = 0; n < sizeof own; n++) {
        assert_refused(RIGCAL_ERR_DAMAGED, own, n);
    }
    for (size_t n = 0; n < sizeof other; n++) {
        assert_refused(RIGCAL_ERR_DAMAGED, other, n);
    }
}

static void flip_every_bit(uint8_t bytes[], size_t n)
{
    for (size_t bit = 0; bit < 8 * n; bit++) {
        rigcal_status status;

        bytes[bit / 8] ^= (uint8_t)(1u << bit % 8);
        status = assert_refused(0, bytes, n);
        ASSERT_STATUS(bit < 32 ? RIGCAL_ERR_FOREIGN : RIGCAL_ERR_DAMAGED, status);
        bytes[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
}

static void test_every_single_bit_flipped_is_refused(void)
{
    flip_every_bit(own, sizeof own);
    flip_every_bit(other, sizeof other);
}

/* In a page with room for more, so that a count or length that is too large would reach
 * bytes that exist. */
static void test_every_bit_flipped_in_an_erased_page_is_refused(void)
{
    static uint8_t page[PAGE];

    memset(page, 0xff, sizeof page);
    memcpy(page, own, sizeof own);
    for (size_t bit = 0; bit < 8 * sizeof own; bit++) {
        page[bit / 8] ^= (uint8_t)(1u << bit % 8);
        assert_refused(0, page, sizeof page);
        page[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
}

/* The writing of it stopped after any number of bytes. */
static void test_every_beginning_in_an_erased_page_is_refused(void)
{
    static const uint8_t ERASED[] = {0xff, 0x00};

    for (int e = 0; e < 2; e++) {
        uint8_t page[OWN_BYTES + 64];

        for (size_t n = 0; n < sizeof own; n++) {
            memset(page, ERASED[e], sizeof page);
            memcpy(page, own, n);
            if (memcmp(page, own, sizeof own) != 0) {
                assert_refused(0, page, sizeof page);
            }
        }
    }
}

static void test_two_flipped_bits_are_refused(void)
{
    test_rng rng = test_seed(44);

    for (int trial = 0; trial < TEST_TRIALS(20000); trial++) {
        const size_t a = (size_t)(test_next(&rng) % (8 * sizeof own));
        const size_t b = (size_t)(test_next(&rng) % (8 * sizeof own));

        if (a != b) {
            own[a / 8] ^= (uint8_t)(1u << a % 8);
            own[b / 8] ^= (uint8_t)(1u << b % 8);
            assert_refused(0, own, sizeof own);
            own[a / 8] ^= (uint8_t)(1u << a % 8);
            own[b / 8] ^= (uint8_t)(1u << b % 8);
        }
    }
}

static void test_what_follows_does_not_matter(void)
{
    test_rng rng = test_seed(45);

    for (size_t more = 1; more < 100; more++) {
        uint8_t bytes[OWN_BYTES + 100];
        rigcal_mounted_camera cameras[N];
        rigcal_saved_info info;

        memcpy(bytes, own, sizeof own);
        for (size_t i = sizeof own; i < sizeof bytes; i++) {
            bytes[i] = (uint8_t)test_next(&rng);
        }
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_store_load(cameras, N, &info, bytes, sizeof own + more));
        TEST_ASSERT_EQUAL_INT32(OWN_BYTES, info.n_bytes);
        assert_same_camera(&calibration[N - 1], &cameras[N - 1]);
    }
}

static void test_other_bytes_are_foreign(void)
{
    static uint8_t bytes[PAGE / 2];
    test_rng rng = test_seed(46);

    memset(bytes, 0xff, sizeof bytes);
    assert_refused(RIGCAL_ERR_FOREIGN, bytes, sizeof bytes);
    memset(bytes, 0, sizeof bytes);
    assert_refused(RIGCAL_ERR_FOREIGN, bytes, sizeof bytes);
    for (int trial = 0; trial < TEST_TRIALS(1000); trial++) {
        for (size_t i = 0; i < sizeof bytes; i++) {
            bytes[i] = (uint8_t)test_next(&rng);
        }
        assert_refused(RIGCAL_ERR_FOREIGN, bytes, sizeof bytes);
    }
}

/* ---- whole, but not ours, or not valid ------------------------------------ */

static void put_u16(uint8_t *at, uint32_t x)
{
    at[0] = (uint8_t)x;
    at[1] = (uint8_t)(x >> 8);
}

static void test_another_version_or_precision_is_named(void)
{
    for (uint32_t version = 0; version < 0x10000; version += 257) {
        put_u16(own + 4, version);
        seal(own, sizeof own);
        assert_refused(RIGCAL_ERR_VERSION, own, sizeof own);
    }
    put_u16(own + 4, 3);
    seal(own, sizeof own);
    assert_refused(RIGCAL_ERR_VERSION, own, sizeof own);
    put_u16(own + 4, 2); /* a calibrated rig has another length */
    seal(own, sizeof own);
    assert_refused(RIGCAL_ERR_DAMAGED, own, sizeof own);
    put_u16(own + 4, 1);
    for (uint32_t real_bytes = 0; real_bytes < 20; real_bytes++) {
        if (real_bytes != 4 && real_bytes != 8) {
            put_u16(own + 6, real_bytes);
            seal(own, sizeof own);
            assert_refused(RIGCAL_ERR_VERSION, own, sizeof own);
        }
    }
    put_u16(own + 6, OTHER_REAL);
    seal(own, sizeof own);
    assert_refused(RIGCAL_ERR_DAMAGED, own, sizeof own);
}

/* With a right CRC. Chance does not produce that, but a wrong tool may. */
static void test_counts_that_do_not_fit_the_length_are_damage(void)
{
    static const uint32_t COUNTS[] = {0, 1, N - 1, N + 1, 65535, 65536, 0x7fffffff,
                                      0x80000000, UINT32_MAX,
                                      /* its length is that of N, modulo 2^32 */
                                      N + 0x40000000u};

    for (size_t i = 0; i < sizeof COUNTS / sizeof COUNTS[0]; i++) {
        put_u32(own + 8, COUNTS[i]);
        seal(own, sizeof own);
        assert_refused(RIGCAL_ERR_DAMAGED, own, sizeof own);
    }
    put_u32(own + 8, 0);
    put_u32(own + 20, 32);
    seal(own, sizeof own);
    put_u32(own + 24, plain_crc(own, 0)); /* without any camera */
    put_u32(own + 28, plain_crc(own, 28));
    assert_refused(RIGCAL_ERR_DAMAGED, own, sizeof own);
    put_u32(own + 8, N);
    for (size_t i = 0; i < sizeof COUNTS / sizeof COUNTS[0]; i++) {
        put_u32(own + 20, COUNTS[i]);
        seal(own, sizeof own);
        assert_refused(RIGCAL_ERR_DAMAGED, own, sizeof own);
    }
}

static void refuses_number(rigcal_status expected, size_t at, double x, int real_bytes)
{
    uint8_t *const bytes = real_bytes == OWN_REAL ? own : other;
    const size_t size = 32 + N * (size_t)(16 + 45 * real_bytes);
    uint8_t kept[8];

    /* In the second camera; so the first could have been written before. */
    at = 32 + (size_t)(16 + 45 * real_bytes) + 16 + at * (size_t)real_bytes;
    memcpy(kept, bytes + at, sizeof kept);
    put_number(bytes + at, x, real_bytes);
    seal(bytes, size);
    assert_refused(expected, bytes, size);
    memcpy(bytes + at, kept, sizeof kept);
}

static void test_numbers_that_no_function_takes_are_not_loaded(void)
{
    static const int REAL_BYTES[] = {4, 8};
    const double nothing[] = {test_nan(), test_infinity(), -test_infinity()};

    for (int p = 0; p < 2; p++) {
        const int real_bytes = REAL_BYTES[p];

        for (size_t k = 0; k < 45; k++) {
            for (int v = 0; v < 3; v++) {
                refuses_number(RIGCAL_ERR_NOT_FINITE, k, nothing[v], real_bytes);
            }
        }
        refuses_number(RIGCAL_ERR_CAMERA, 0, 0, real_bytes);
        refuses_number(RIGCAL_ERR_CAMERA, 1, -900, real_bytes);
        refuses_number(RIGCAL_ERR_CAMERA, 2, 2e9, real_bytes);
        for (size_t k = 12; k < 21; k++) {
            refuses_number(RIGCAL_ERR_ROTATION, k, 3, real_bytes);
        }
        for (size_t k = 21; k < 24; k++) {
            refuses_number(RIGCAL_ERR_RANGE, k, TOL(2e30, 2e9), real_bytes);
        }
        for (size_t i = 0; i < 6; i++) {
            refuses_number(RIGCAL_ERR_RANGE, 24 + i * (i + 3) / 2, -1e-9, real_bytes);
        }
    }
}

static void test_integers_that_no_function_takes_are_not_loaded(void)
{
    static const struct {
        int at;
        uint32_t value;
        rigcal_status status;
    } BAD[] = {
        {0, 2, RIGCAL_ERR_CAMERA},          {0, UINT32_MAX, RIGCAL_ERR_CAMERA},
        {4, 0, RIGCAL_ERR_CAMERA},          {4, 1000001, RIGCAL_ERR_CAMERA},
        {8, UINT32_MAX, RIGCAL_ERR_CAMERA}, {12, 2, RIGCAL_ERR_RANGE},
        {12, UINT32_MAX, RIGCAL_ERR_RANGE}, {0, 1, RIGCAL_ERR_CAMERA},
    };
    const int second = 32 + 16 + 45 * OWN_REAL;

    for (size_t i = 0; i < sizeof BAD / sizeof BAD[0]; i++) {
        uint8_t kept[4];

        memcpy(kept, own + second + BAD[i].at, 4);
        put_u32(own + second + BAD[i].at, BAD[i].value);
        seal(own, sizeof own);
        /* The last case: a fisheye with coefficients that only Brown's lens has. */
        assert_refused(BAD[i].status, own, sizeof own);
        memcpy(own + second + BAD[i].at, kept, 4);
    }
}

static void test_too_many_cameras_for_the_room_are_refused(void)
{
    rigcal_mounted_camera cameras[N];
    rigcal_saved_info info;

    for (size_t room = 0; room < N; room++) {
        FILL(info);
        ASSERT_REFUSED(RIGCAL_ERR_CAPACITY, cameras,
                       rigcal_store_load(cameras, room, &info, own, sizeof own));
        ASSERT_UNTOUCHED(info);
    }
}

/* ---- what is not saved ---------------------------------------------------- */

static void assert_not_saved(rigcal_status expected, size_t capacity, size_t n)
{
    uint8_t bytes[OWN_BYTES];
    size_t n_bytes;

    FILL(n_bytes);
    ASSERT_REFUSED(
        expected, bytes,
        rigcal_store_save(bytes, capacity, &n_bytes, calibration, n, sequence, tag));
    ASSERT_UNTOUCHED(n_bytes);
}

static void test_what_could_not_be_loaded_is_not_saved(void)
{
    assert_not_saved(RIGCAL_ERR_TOO_FEW, OWN_BYTES, 0);
    assert_not_saved(RIGCAL_ERR_RANGE, SIZE_MAX, 65536);
    assert_not_saved(RIGCAL_ERR_RANGE, SIZE_MAX, SIZE_MAX);
    assert_not_saved(RIGCAL_ERR_CAPACITY, OWN_BYTES - 1, N);
    assert_not_saved(RIGCAL_ERR_CAPACITY, 0, N);

    calibration[N - 1].has_Sigma = 2;
    assert_not_saved(RIGCAL_ERR_RANGE, OWN_BYTES, N);
    calibration[N - 1].has_Sigma = -1;
    assert_not_saved(RIGCAL_ERR_RANGE, OWN_BYTES, N);
    setUp();
    for (int i = 0; i < 36; i++) {
        calibration[N - 1].Sigma[i] = TEST_INF;
        assert_not_saved(RIGCAL_ERR_NOT_FINITE, OWN_BYTES, N);
        setUp();
    }
    for (int i = 0; i < 6; i++) {
        calibration[N - 1].Sigma[7 * i] = RC(-1e-12);
        assert_not_saved(RIGCAL_ERR_RANGE, OWN_BYTES, N);
        setUp();
    }
    calibration[N - 1].cam_from_rig.R[4] = TEST_NAN;
    assert_not_saved(RIGCAL_ERR_NOT_FINITE, OWN_BYTES, N);
    setUp();
    calibration[N - 1].cam_from_rig.R[4] = 2;
    assert_not_saved(RIGCAL_ERR_ROTATION, OWN_BYTES, N);
    setUp();
    calibration[N - 1].camera.k2 = TEST_NAN;
    assert_not_saved(RIGCAL_ERR_NOT_FINITE, OWN_BYTES, N);
    setUp();
    calibration[N - 1].camera.width = 0;
    assert_not_saved(RIGCAL_ERR_CAMERA, OWN_BYTES, N);
}

static void test_a_missing_argument_is_named(void)
{
    uint8_t bytes[OWN_BYTES];
    rigcal_mounted_camera cameras[N];
    rigcal_saved_info info;
    size_t n;

    ASSERT_REFUSED(RIGCAL_ERR_NULL, n,
                   rigcal_store_save(NULL, OWN_BYTES, &n, calibration, N, 0, 0));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, bytes,
                   rigcal_store_save(bytes, OWN_BYTES, NULL, calibration, N, 0, 0));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, bytes,
                   rigcal_store_save(bytes, OWN_BYTES, &n, NULL, N, 0, 0));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_store_info(NULL, own, sizeof own));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, info, rigcal_store_info(&info, NULL, sizeof own));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, info,
                   rigcal_store_load(NULL, N, &info, own, sizeof own));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, cameras,
                   rigcal_store_load(cameras, N, NULL, own, sizeof own));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, cameras,
                   rigcal_store_load(cameras, N, &info, NULL, sizeof own));
}

/* Bytes as long as a header are enough to see that they are foreign. */
static void test_a_foreign_header_is_foreign_and_a_lone_header_damaged(void)
{
    uint8_t foreign[32] = {'R', 'I', 'G', 'D'};

    assert_refused(RIGCAL_ERR_FOREIGN, foreign, 32);
    assert_refused(RIGCAL_ERR_DAMAGED, foreign, 31);
    assert_refused(RIGCAL_ERR_DAMAGED, own, 32);
}

/* 24 MB in double. */
static void test_the_most_cameras_are_saved_and_loaded(void)
{
    enum { MOST = 65535 };
    const size_t size = rigcal_store_size(MOST);
    rigcal_saved_info info;
    size_t n_bytes;

    TEST_ON_HOST_ONLY("it takes 60 MB");
    uint8_t *const bytes = malloc(size);
    rigcal_mounted_camera *const cameras = malloc((MOST + 1) * sizeof *cameras);
    TEST_ASSERT_TRUE(bytes != NULL && cameras != NULL);
    for (int i = 0; i <= MOST; i++) {
        cameras[i] = calibration[i % N];
    }
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_store_save(bytes, size, &n_bytes, cameras,
                                                      MOST + 1, sequence, tag));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_store_save(bytes, size, &n_bytes, cameras, MOST, sequence, tag));
    TEST_ASSERT_EQUAL_size_t(size, n_bytes);
    memset(cameras, 0, (MOST + 1) * sizeof *cameras);
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_load(cameras, MOST, &info, bytes, n_bytes));
    TEST_ASSERT_EQUAL_INT32(MOST, info.n_cameras);
    TEST_ASSERT_EQUAL_MEMORY(&calibration[(MOST - 1) % N].cam_from_rig,
                             &cameras[MOST - 1].cam_from_rig, sizeof(rigcal_transform));
    TEST_ASSERT_EQUAL_INT32(0, cameras[MOST].camera.width);
    free(cameras);
    free(bytes);
}

TEST_MAIN_WITH_SETUP()
{
    RUN_TEST(test_the_size_is_as_the_table_says);
    RUN_TEST(test_a_calibration_is_saved_as_the_bytes_that_python_packs);
    RUN_TEST(test_those_bytes_are_loaded_as_the_calibration);
    RUN_TEST(test_the_bytes_of_the_other_precision_are_loaded_too);
    RUN_TEST(test_what_was_saved_is_loaded_bit_by_bit);
    RUN_TEST(test_what_is_no_covariance_is_not_saved);
    RUN_TEST(test_rounding_of_a_correlation_is_accepted_within_its_tolerance);
    RUN_TEST(test_three_correlations_that_contradict_each_other_are_refused);
    RUN_TEST(test_what_is_between_the_fields_of_a_camera_is_not_read);
    RUN_TEST(test_an_exact_pose_has_a_covariance_of_zeros);
    RUN_TEST(test_a_covariance_that_is_not_known_is_not_read);
    if (RIGCAL_USE_FLOAT) {
        RUN_TEST(test_a_float_build_rounds_doubles_to_nearest);
    } else {
        RUN_TEST(test_a_double_build_takes_floats_as_they_are);
        RUN_TEST(test_a_rotation_of_floats_is_mended_within_their_tolerance);
    }
    RUN_TEST(test_every_length_too_short_is_refused);
    RUN_TEST(test_every_single_bit_flipped_is_refused);
    RUN_TEST(test_every_bit_flipped_in_an_erased_page_is_refused);
    RUN_TEST(test_every_beginning_in_an_erased_page_is_refused);
    RUN_TEST(test_two_flipped_bits_are_refused);
    RUN_TEST(test_what_follows_does_not_matter);
    RUN_TEST(test_other_bytes_are_foreign);
    RUN_TEST(test_a_foreign_header_is_foreign_and_a_lone_header_damaged);
    RUN_TEST(test_another_version_or_precision_is_named);
    RUN_TEST(test_counts_that_do_not_fit_the_length_are_damage);
    RUN_TEST(test_numbers_that_no_function_takes_are_not_loaded);
    RUN_TEST(test_integers_that_no_function_takes_are_not_loaded);
    RUN_TEST(test_too_many_cameras_for_the_room_are_refused);
    RUN_TEST(test_what_could_not_be_loaded_is_not_saved);
    RUN_TEST(test_a_missing_argument_is_named);
    RUN_TEST(test_the_most_cameras_are_saved_and_loaded);
}
