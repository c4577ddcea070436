/* store: a calibrated rig with its joint covariance, as bytes and back. The expected bytes
 * were made by Python's struct and zlib (tests/vectors). Bytes of the older form, without a
 * joint covariance, load too. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rc_store.h"
#include "test_rigs.h"
#include "vectors_store.h"

enum {
    N = STORE_CAMERA_ROWS,
    FREE = 2,
    UNKNOWNS = 6 * FREE,
    SIGMA_REALS = UNKNOWNS * (UNKNOWNS + 1) / 2,
    DOUBLE_BYTES = 32 + 32 + N * (20 + 192) + 8 * SIGMA_REALS,
    FLOAT_BYTES = 32 + 16 + N * (20 + 96) + 4 * SIGMA_REALS,
    OWN_BYTES = RIGCAL_USE_FLOAT ? FLOAT_BYTES : DOUBLE_BYTES,
    OTHER_BYTES = RIGCAL_USE_FLOAT ? DOUBLE_BYTES : FLOAT_BYTES,
    OWN_REAL = RIGCAL_USE_FLOAT ? 4 : 8,
    CAMERAS_AT = 32 + 4 * OWN_REAL,
    STRIDE = 20 + 24 * OWN_REAL,
    SIGMA_AT = CAMERAS_AT + N * STRIDE,
    OLD_BYTES = 32 + N * (16 + 45 * OWN_REAL)
};

/* A rig with its own memory. */
typedef struct {
    rigcal_mounted_camera cameras[N];
    int32_t group[N];
    uint8_t held[N];
    rigcal_real Sigma[SIGMA_REALS];
} memory;

static memory saved;
static rigcal_calibrated_rig rig;
static uint32_t sequence, tag;
static uint8_t own[OWN_BYTES], other[OTHER_BYTES];

static void bytes_of_row(uint8_t bytes[], const double row[], size_t n)
{
    for (size_t i = 0; i < n; i++) {
        bytes[i] = (uint8_t)row[i];
    }
}

/* A rig without content whose arrays are those of m. */
static rigcal_calibrated_rig open_rig(memory *m)
{
    rigcal_calibrated_rig opened;

    memset(&opened, 0, sizeof opened);
    opened.cameras = m->cameras;
    opened.group = m->group;
    opened.held = m->held;
    opened.capacity = N;
    opened.Sigma = m->Sigma;
    opened.Sigma_capacity = SIGMA_REALS;
    return opened;
}

static size_t at_of(size_t i, size_t j)
{
    return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i;
}

void setUp(void)
{
    const double *joint = STORE_JOINT[0];

    memset(&saved, 0, sizeof saved);
    rig = open_rig(&saved);
    rig.n_cameras = N;
    rig.sigma_px = RC(joint[0]);
    rig.F = RC(joint[1]);
    rig.freedom_between = RC(joint[2]);
    rig.freedom_within = RC(joint[3]);
    for (size_t c = 0; c < N; c++) {
        const double *row = STORE_CAMERA[c];
        double v[15];

        memcpy(v, row, 3 * sizeof v[0]);
        memcpy(v + 3, row + 4, 12 * sizeof v[0]);
        saved.cameras[c].camera = test_camera(v);
        saved.cameras[c].cam_from_rig = test_transform(row + 16, row + 25);
        saved.held[c] = (uint8_t)joint[4 + c];
        saved.group[c] = (int32_t)joint[4 + N + c];
    }
    test_to_real(saved.Sigma, joint + 4 + 2 * N, SIGMA_REALS);
    sequence = (uint32_t)STORE_NUMBERS[0][0];
    tag = (uint32_t)STORE_NUMBERS[0][1];
    bytes_of_row(own, RIGCAL_USE_FLOAT ? STORE_RIG_FLOAT[0] : STORE_RIG_DOUBLE[0],
                 OWN_BYTES);
    bytes_of_row(other, RIGCAL_USE_FLOAT ? STORE_RIG_DOUBLE[0] : STORE_RIG_FLOAT[0],
                 OTHER_BYTES);
}

void tearDown(void)
{
}

/* ---- helpers ------------------------------------------------------------- */

static void put_u32(uint8_t *at, uint32_t x)
{
    for (int i = 0; i < 4; i++) {
        at[i] = (uint8_t)(x >> 8 * i);
    }
}

static void put_real(uint8_t *at, double value)
{
    const rigcal_real x = RC(value);

    (void)rc_put_reals(at, &x, 1);
}

/* Corrects the CRCs after the bytes were changed on purpose. */
static void seal(uint8_t bytes[], size_t n)
{
    put_u32(bytes + 24, rc_crc32(bytes + 32, n - 32));
    put_u32(bytes + 28, rc_crc32(bytes, 28));
}

/* Loads exactly these bytes, as a rig and as cameras. Both must refuse them and write
 * nothing. expected: 0 for any status of damage. */
static void assert_refused(rigcal_status expected, const uint8_t bytes[], size_t n)
{
    static memory m;
    rigcal_calibrated_rig loaded = open_rig(&m), before;
    rigcal_mounted_camera cameras[N];
    rigcal_saved_info info;
    uint8_t *exact = malloc(n > 0 ? n : 1);
    rigcal_status status, of_cameras;

    TEST_ASSERT_NOT_NULL(exact);
    memcpy(exact, bytes, n);
    before = loaded;
    FILL(m);
    FILL(info);
    FILL(cameras);
    status = rigcal_store_load_rig(&loaded, &info, exact, n);
    of_cameras = rigcal_store_load(cameras, N, &info, exact, n);
    ASSERT_UNTOUCHED(m);
    ASSERT_UNTOUCHED(info);
    ASSERT_UNTOUCHED(cameras);
    TEST_ASSERT_EQUAL_MEMORY(&before, &loaded, sizeof loaded);
    ASSERT_STATUS(status, of_cameras);
    if (expected == 0) {
        TEST_ASSERT_TRUE(status == RIGCAL_ERR_DAMAGED || status == RIGCAL_ERR_FOREIGN);
    } else {
        ASSERT_STATUS(expected, status);
    }
    free(exact);
}

static void assert_same_rig(const rigcal_calibrated_rig *expected,
                            const rigcal_calibrated_rig *actual)
{
    TEST_ASSERT_EQUAL_UINT64(expected->n_cameras, actual->n_cameras);
    TEST_ASSERT_EQUAL_MEMORY(&expected->sigma_px, &actual->sigma_px,
                             4 * sizeof(rigcal_real));
    TEST_ASSERT_EQUAL_MEMORY(expected->Sigma, actual->Sigma,
                             SIGMA_REALS * sizeof(rigcal_real));
    for (size_t c = 0; c < N; c++) {
        const rigcal_mounted_camera *a = &expected->cameras[c], *b = &actual->cameras[c];

        TEST_ASSERT_EQUAL_MEMORY(&a->camera, &b->camera, 3 * sizeof(int32_t));
        TEST_ASSERT_EQUAL_MEMORY(&a->camera.fx, &b->camera.fx, 12 * sizeof(rigcal_real));
        TEST_ASSERT_EQUAL_MEMORY(&a->cam_from_rig, &b->cam_from_rig,
                                 sizeof a->cam_from_rig);
        TEST_ASSERT_EQUAL_UINT8(expected->held[c], actual->held[c]);
        TEST_ASSERT_EQUAL_INT32(expected->group[c], actual->group[c]);
    }
}

/* Cameras that were loaded from bytes of the rig: each must have its block of the joint
 * covariance. */
static void assert_own_covariances(const rigcal_mounted_camera cameras[])
{
    size_t first = 0;

    for (size_t c = 0; c < N; c++) {
        TEST_ASSERT_EQUAL_INT32(1, cameras[c].has_Sigma);
        for (size_t k = 0; k < 36; k++) {
            const size_t at = at_of(first + k / 6, first + k % 6);

            ASSERT_NEAR(saved.held[c] ? 0 : D(saved.Sigma[at]), cameras[c].Sigma[k], 0);
        }
        first += saved.held[c] ? 0 : 6;
    }
}

/* ---- golden bytes -------------------------------------------------------- */

static void test_the_size_is_as_the_table_says(void)
{
    TEST_ASSERT_EQUAL_size_t(OWN_BYTES, rigcal_store_rig_size(N, FREE));
    TEST_ASSERT_EQUAL_size_t(OWN_BYTES, RIGCAL_STORE_RIG_SIZE(N, FREE));
    TEST_ASSERT_EQUAL_size_t(DOUBLE_BYTES, RIGCAL_STORE_RIG_SIZE_OF(N, FREE, 8));
    TEST_ASSERT_EQUAL_size_t(FLOAT_BYTES, RIGCAL_STORE_RIG_SIZE_OF(N, FREE, 4));
    TEST_ASSERT_EQUAL_size_t(CAMERAS_AT + STRIDE, rigcal_store_rig_size(1, 0));
    TEST_ASSERT_EQUAL_size_t(0, rigcal_store_rig_size(0, 0));
    TEST_ASSERT_EQUAL_size_t(0, rigcal_store_rig_size(3, 4));
    TEST_ASSERT_EQUAL_size_t(RIGCAL_STORE_RIG_SIZE(3, 3), rigcal_store_rig_size(3, 3));
    TEST_ASSERT_EQUAL_size_t(0, rigcal_store_rig_size(65536, 2));
    TEST_ASSERT_EQUAL_size_t(0, rigcal_store_rig_size(65535, 3801));
    TEST_ASSERT_EQUAL_size_t(RIGCAL_STORE_RIG_SIZE((uint64_t)65535, (uint64_t)3800),
                             rigcal_store_rig_size(65535, 3800));
    TEST_ASSERT_EQUAL_size_t(0, rigcal_store_rig_size(SIZE_MAX, SIZE_MAX));
    TEST_ASSERT_TRUE(rigcal_store_rig_size(65535, 3800) <= INT32_MAX);
}

static void test_a_rig_is_saved_as_the_bytes_that_python_packs(void)
{
    uint8_t bytes[OWN_BYTES + 1];
    size_t n = 77;

    memset(bytes, 0x5a, sizeof bytes);
    saved.cameras[1].Sigma[3] = TEST_NAN; /* this number is not read */
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_store_save_rig(bytes, OWN_BYTES, &n, &rig, sequence, tag));
    TEST_ASSERT_EQUAL_size_t(OWN_BYTES, n);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(own, bytes, OWN_BYTES);
    TEST_ASSERT_EQUAL_HEX8(0x5a, bytes[OWN_BYTES]);
}

static void test_those_bytes_are_loaded_as_the_rig(void)
{
    memory m;
    rigcal_calibrated_rig loaded = open_rig(&m);
    rigcal_saved_info info;
    rigcal_mounted_camera cameras[N];

    FILL(m);
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_load_rig(&loaded, &info, own, sizeof own));
    assert_same_rig(&rig, &loaded);
    assert_own_covariances(m.cameras);
    TEST_ASSERT_EQUAL_HEX32(sequence, info.sequence);
    TEST_ASSERT_EQUAL_HEX32(tag, info.tag);
    TEST_ASSERT_EQUAL_INT32(N, info.n_cameras);
    TEST_ASSERT_EQUAL_INT32(FREE, info.n_free);
    TEST_ASSERT_EQUAL_INT32(OWN_BYTES, info.n_bytes);
    TEST_ASSERT_EQUAL_INT32(OWN_REAL, info.real_bytes);
    /* A board that needs no cross terms loads only the cameras. */
    FILL(cameras);
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_load(cameras, N, &info, own, sizeof own));
    assert_own_covariances(cameras);
}

static void test_the_bytes_of_the_other_precision_are_loaded_too(void)
{
    memory m;
    rigcal_calibrated_rig loaded = open_rig(&m);
    rigcal_saved_info info;

    ASSERT_STATUS(RIGCAL_OK, rigcal_store_load_rig(&loaded, &info, other, sizeof other));
    TEST_ASSERT_EQUAL_INT32(OTHER_BYTES, info.n_bytes);
    for (size_t k = 0; k < SIGMA_REALS; k++) {
        const double x = STORE_JOINT[0][4 + 2 * N + k];

        ASSERT_NEAR((double)(float)x, loaded.Sigma[k], 0);
        saved.Sigma[k] = RC((float)x);
    }
    assert_own_covariances(m.cameras);
    for (size_t c = 0; c < N; c++) {
        const double *row = STORE_CAMERA[c];

        for (size_t k = 0; k < 9; k++) {
            ASSERT_NEAR(row[16 + k], m.cameras[c].cam_from_rig.R[k], 1e-7);
        }
        for (size_t k = 0; k < 3; k++) {
            ASSERT_NEAR((double)(float)row[25 + k], m.cameras[c].cam_from_rig.t[k], 0);
        }
        TEST_ASSERT_EQUAL_UINT8(rig.held[c], m.held[c]);
        TEST_ASSERT_EQUAL_INT32(rig.group[c], m.group[c]);
    }
    ASSERT_NEAR(1.75, loaded.F, 0);
    ASSERT_NEAR(1234, loaded.freedom_within, 0);
}

/* The older form. STORE_DOUBLE and STORE_FLOAT are bytes of version 0.1.0. */
static void test_bytes_of_the_older_form_are_loaded_without_a_joint_covariance(void)
{
    uint8_t old[OLD_BYTES];
    memory m;
    rigcal_calibrated_rig loaded = open_rig(&m);
    rigcal_saved_info info;
    rigcal_mounted_camera cameras[N];
    rigcal_transform pair;
    rigcal_real Sigma[36];

    bytes_of_row(old, RIGCAL_USE_FLOAT ? STORE_FLOAT[0] : STORE_DOUBLE[0], OLD_BYTES);
    FILL(m);
    loaded.Sigma = NULL;
    loaded.sigma_px = loaded.F = 5;
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_load_rig(&loaded, &info, old, sizeof old));
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_load(cameras, N, &info, old, sizeof old));
    TEST_ASSERT_EQUAL_INT32(-1, info.n_free);
    ASSERT_NEAR(0, loaded.sigma_px, 0);
    ASSERT_NEAR(0, loaded.F, 0);
    for (size_t c = 0; c < N; c++) {
        TEST_ASSERT_EQUAL_INT32((int32_t)STORE_CAMERA[c][3], m.cameras[c].has_Sigma);
        for (size_t k = 0; k < 36; k++) {
            ASSERT_NEAR(D(RC(STORE_CAMERA[c][28 + k])), m.cameras[c].Sigma[k], 0);
        }
        TEST_ASSERT_EQUAL_MEMORY(cameras[c].cam_from_rig.R, m.cameras[c].cam_from_rig.R,
                                 9 * sizeof(rigcal_real));
        TEST_ASSERT_EQUAL_UINT8(0, m.held[c]);
        TEST_ASSERT_EQUAL_INT32(0, m.group[c]);
    }
    ASSERT_UNTOUCHED(m.Sigma);
    loaded.Sigma = m.Sigma;
    loaded.Sigma_capacity = SIZE_MAX;
    ASSERT_REFUSED(RIGCAL_ERR_STATE, Sigma,
                   rigcal_calibrated_pair(&pair, Sigma, &loaded, 0, 1));
    ASSERT_REFUSED(RIGCAL_ERR_STATE, old,
                   rigcal_store_save_rig(old, sizeof old, &(size_t){0}, &loaded, 0, 0));
}

/* ---- a rig that was adjusted ---------------------------------------------- */

/* Pairs and covariances of the loaded rig must be those of the adjusted rig, which no
 * longer exists. */
static void test_pairs_of_the_loaded_rig_are_those_of_the_adjusted_one(void)
{
    enum { CAMERAS = 4, LOADED_REALS = RIGCAL_CALIBRATED_SIZE(CAMERAS - 1) };
    static test_rig r;
    static rigcal_real Sigma[2][LOADED_REALS];
    static rigcal_mounted_camera cameras[2][CAMERAS];
    static uint8_t bytes[RIGCAL_STORE_RIG_SIZE(CAMERAS, CAMERAS - 1)];
    static rigcal_real of_rig[CAMERAS][CAMERAS][36];
    int32_t group[2][CAMERAS];
    uint8_t held[2][CAMERAS];
    rigcal_calibrated_rig kept[2];
    test_rng rng = test_seed(371);
    rigcal_saved_info info;
    rigcal_transform pair;
    rigcal_rig_fit fit;
    size_t n;

    TEST_WANTS_RAM(sizeof r + sizeof of_rig + 3 * sizeof bytes + 8000);
    test_rig_random(&r, &rng, CAMERAS, 4, 8);
    test_rig_see_all(&r, &rng, 0.3);
    test_rig_solve_views(&r);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    memset(kept, 0, sizeof kept);
    memset(cameras, 0, sizeof cameras);
    for (int k = 0; k < 2; k++) {
        kept[k].cameras = cameras[k];
        kept[k].group = group[k];
        kept[k].held = held[k];
        kept[k].capacity = CAMERAS;
        kept[k].Sigma = Sigma[k];
        kept[k].Sigma_capacity = LOADED_REALS;
    }
    for (size_t c = 0; c < CAMERAS; c++) {
        cameras[0][c].camera = r.camera[c];
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_calibrated_take(&kept[0], &r.rig, &fit, RC(0.3)));
    for (size_t a = 0; a < CAMERAS; a++) {
        for (size_t b = 0; b < CAMERAS; b++) {
            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_rig_pair(&pair, of_rig[a][b], &r.rig, RC(0.3), a, b));
        }
    }
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_store_save_rig(bytes, sizeof bytes, &n, &kept[0], 1, 2));
    memset(r.work, 0xff, sizeof r.work);
    memset(Sigma[0], 0xff, sizeof Sigma[0]);
    memset(cameras[0], 0xff, sizeof cameras[0]);
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_load_rig(&kept[1], &info, bytes, n));
    for (size_t a = 0; a < CAMERAS; a++) {
        for (size_t b = 0; b < CAMERAS; b++) {
            rigcal_real loaded[36];

            ASSERT_STATUS(RIGCAL_OK, rigcal_calibrated_pair(&pair, loaded, &kept[1], a, b));
            for (size_t k = 0; a != b && k < 36; k++) {
                const rigcal_real *S = of_rig[a][b];
                const double scale = sqrt(D(S[k / 6 * 7]) * D(S[k % 6 * 7]));

                ASSERT_NEAR(D(S[k]), loaded[k], TOL(1e-11, 1e-4) * scale);
            }
        }
    }
}

/* ---- the edge of what is taken --------------------------------------------- */

/* Saves the rig and loads it again: both must give this status. */
static void there_and_back(rigcal_status expected)
{
    static uint8_t bytes[OWN_BYTES];
    memory m;
    rigcal_calibrated_rig loaded = open_rig(&m);
    rigcal_saved_info info;
    size_t n = 0;

    ASSERT_STATUS(expected, rigcal_store_save_rig(bytes, sizeof bytes, &n, &rig, 0, 0));
    if (expected == RIGCAL_OK) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_store_load_rig(&loaded, &info, bytes, n));
        assert_same_rig(&rig, &loaded);
    } else {
        (void)rc_put_reals(own + SIGMA_AT, saved.Sigma, SIGMA_REALS);
        seal(own, sizeof own);
        assert_refused(expected, own, sizeof own);
    }
    setUp();
}

static void unit_covariance(void)
{
    for (size_t i = 0; i < UNKNOWNS; i++) {
        for (size_t j = 0; j <= i; j++) {
            saved.Sigma[at_of(i, j)] = RC(i == j);
        }
    }
}

/* Unknowns of two cameras that are correlated fully, to rounding. */
static void test_a_correlation_of_two_cameras_may_exceed_1_by_rounding(void)
{
    const double tol = TOL(1e-9, 1e-5);

    for (int sign = -1; sign <= 1; sign += 2) {
        for (int k = 0; k < 3; k++) {
            const double r = sign * (k == 0 ? 1 + 0.4 * tol : k == 1 ? 1 + 2 * tol : 1.5);

            unit_covariance();
            saved.Sigma[at_of(2, 2)] = 4;
            saved.Sigma[at_of(9, 9)] = RC(0.25);
            saved.Sigma[at_of(9, 2)] = RC(r);
            there_and_back(k == 0 ? RIGCAL_OK : RIGCAL_ERR_RANGE);
        }
    }
}

/* Pairs of unknowns and the block of each camera are checked. The whole is not: that would
 * take the time of its factor. */
static void test_cameras_may_contradict_each_other_if_no_pair_does(void)
{
    unit_covariance();
    saved.Sigma[at_of(2, 1)] = saved.Sigma[at_of(6, 1)] = RC(0.9);
    saved.Sigma[at_of(6, 2)] = RC(-0.9);
    there_and_back(RIGCAL_OK);
}

/* The array may be longer than the covariance. */
static void test_what_is_behind_the_covariance_is_not_read(void)
{
    enum { MORE = RIGCAL_CALIBRATED_SIZE(FREE + 1) };
    static rigcal_real longer[MORE];

    for (size_t k = 0; k < MORE; k++) {
        longer[k] = k < SIGMA_REALS ? saved.Sigma[k] : TEST_NAN;
    }
    rig.Sigma = longer;
    rig.Sigma_capacity = MORE;
    there_and_back(RIGCAL_OK);
}

/* Of two faults, that of the joint covariance is named. */
static void test_the_joint_covariance_is_checked_before_the_cameras(void)
{
    for (int k = 0; k < 2; k++) {
        const double bad = k == 0 ? test_nan() : -1;
        const rigcal_status status = k == 0 ? RIGCAL_ERR_NOT_FINITE : RIGCAL_ERR_RANGE;
        uint8_t bytes[OWN_BYTES];
        size_t n;

        saved.Sigma[at_of(8, 8)] = RC(bad);
        saved.cameras[0].cam_from_rig.R[4] = 2;
        ASSERT_REFUSED(status, n,
                       rigcal_store_save_rig(bytes, sizeof bytes, &n, &rig, 0, 0));
        put_real(own + SIGMA_AT + at_of(8, 8) * OWN_REAL, bad);
        put_real(own + CAMERAS_AT + 20 + 16 * OWN_REAL, 2);
        seal(own, sizeof own);
        assert_refused(status, own, sizeof own);
        put_real(own + SIGMA_AT + at_of(8, 8) * OWN_REAL, 1);
        seal(own, sizeof own);
        assert_refused(RIGCAL_ERR_ROTATION, own, sizeof own);
        setUp();
    }
}

/* Nothing is left to know of some unknowns. */
static void test_a_variance_of_0_is_taken(void)
{
    for (size_t first = 0; first < UNKNOWNS; first++) {
        for (size_t i = first; i < UNKNOWNS && i < first + 3; i++) {
            for (size_t j = 0; j < UNKNOWNS; j++) {
                saved.Sigma[at_of(i, j)] = 0;
            }
        }
        there_and_back(RIGCAL_OK);
    }
}

static void test_a_rig_of_which_all_cameras_are_held_has_no_covariance(void)
{
    uint8_t bytes[OWN_BYTES];
    memory m;
    rigcal_calibrated_rig loaded = open_rig(&m);
    rigcal_saved_info info;
    size_t n;

    memset(saved.held, 1, sizeof saved.held);
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_save_rig(bytes, sizeof bytes, &n, &rig, 5, 6));
    TEST_ASSERT_EQUAL_size_t(SIGMA_AT, n);
    loaded.Sigma_capacity = 0;
    FILL(m);
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_load_rig(&loaded, &info, bytes, n));
    ASSERT_UNTOUCHED(m.Sigma);
    TEST_ASSERT_EQUAL_INT32(0, info.n_free);
    loaded.Sigma = NULL; /* also without an element it is an array */
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_store_load_rig(&loaded, &info, bytes, n));
    for (size_t c = 0; c < N; c++) {
        TEST_ASSERT_EQUAL_UINT8(1, m.held[c]);
        TEST_ASSERT_EQUAL_INT32(1, m.cameras[c].has_Sigma);
        for (size_t k = 0; k < 36; k++) {
            ASSERT_NEAR(0, m.cameras[c].Sigma[k], 0);
        }
    }
}

static void test_a_missing_argument_is_named(void)
{
    static memory m;
    uint8_t bytes[OWN_BYTES];
    const rigcal_calibrated_rig whole = open_rig(&m);
    rigcal_calibrated_rig loaded = whole;
    rigcal_saved_info info;
    size_t n;

    ASSERT_REFUSED(RIGCAL_ERR_NULL, n,
                   rigcal_store_save_rig(NULL, OWN_BYTES, &n, &rig, 0, 0));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, bytes,
                   rigcal_store_save_rig(bytes, OWN_BYTES, NULL, &rig, 0, 0));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, bytes,
                   rigcal_store_save_rig(bytes, OWN_BYTES, &n, NULL, 0, 0));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, info,
                   rigcal_store_load_rig(NULL, &info, own, sizeof own));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, m,
                   rigcal_store_load_rig(&loaded, NULL, own, sizeof own));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, m,
                   rigcal_store_load_rig(&loaded, &info, NULL, sizeof own));
    loaded.cameras = NULL;
    ASSERT_REFUSED(RIGCAL_ERR_NULL, m,
                   rigcal_store_load_rig(&loaded, &info, own, sizeof own));
    loaded = whole;
    loaded.group = NULL;
    ASSERT_REFUSED(RIGCAL_ERR_NULL, m,
                   rigcal_store_load_rig(&loaded, &info, own, sizeof own));
    loaded = whole;
    loaded.held = NULL;
    ASSERT_REFUSED(RIGCAL_ERR_NULL, m,
                   rigcal_store_load_rig(&loaded, &info, own, sizeof own));
}

/* ---- damage --------------------------------------------------------------- */

static void test_every_length_too_short_is_refused(void)
{
    for (size_t n = 0; n < sizeof own; n++) {
        assert_refused(RIGCAL_ERR_DAMAGED, own, n);
    }
    for (size_t n = 0; n < sizeof other; n++) {
        assert_refused(RIGCAL_ERR_DAMAGED, other, n);
    }
}

static void test_every_single_bit_flipped_is_refused(void)
{
    for (size_t bit = 0; bit < 8 * sizeof own; bit++) {
        own[bit / 8] ^= (uint8_t)(1u << bit % 8);
        assert_refused(bit < 32 ? RIGCAL_ERR_FOREIGN : RIGCAL_ERR_DAMAGED, own, sizeof own);
        own[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    for (size_t bit = 0; bit < 8 * sizeof other; bit++) {
        other[bit / 8] ^= (uint8_t)(1u << bit % 8);
        assert_refused(0, other, sizeof other);
        other[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
}

/* The writing stopped after any number of bytes, over erased flash and over the bytes of
 * another rig. */
static void test_every_torn_write_is_refused(void)
{
    uint8_t page[OWN_BYTES], before[3][OWN_BYTES];
    size_t n;

    memset(before[0], 0xff, OWN_BYTES);
    memset(before[1], 0, OWN_BYTES);
    rig.F = 3;
    saved.cameras[0].cam_from_rig.t[0] = 1;
    saved.Sigma[SIGMA_REALS - 1] *= 2;
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_store_save_rig(before[2], OWN_BYTES, &n, &rig, sequence + 1, tag));
    for (int e = 0; e < 3; e++) {
        for (n = 0; n < sizeof own; n++) {
            memcpy(page, before[e], sizeof page);
            memcpy(page, own, n);
            if (memcmp(page, own, sizeof own) != 0 &&
                memcmp(page, before[e], sizeof own) != 0) {
                assert_refused(0, page, sizeof page);
            }
        }
    }
}

static void test_counts_that_do_not_fit_the_length_are_damage(void)
{
    static const uint32_t COUNTS[] = {0,     1,          N - 1,      N + 1,     65535,
                                      65536, 0x7fffffff, 0x80000000, UINT32_MAX};

    for (size_t i = 0; i < sizeof COUNTS / sizeof COUNTS[0]; i++) {
        put_u32(own + 8, COUNTS[i]);
        seal(own, sizeof own);
        assert_refused(RIGCAL_ERR_DAMAGED, own, sizeof own);
    }
    put_u32(own + 8, N);
    for (size_t c = 0; c < N; c++) { /* one camera more or less is held */
        uint8_t *at = own + CAMERAS_AT + c * STRIDE + 12;

        *at ^= 1;
        seal(own, sizeof own);
        assert_refused(RIGCAL_ERR_DAMAGED, own, sizeof own);
        *at ^= 1;
    }
    put_u32(own + 4, 1 | OWN_REAL << 16); /* the older form has another length */
    seal(own, sizeof own);
    assert_refused(RIGCAL_ERR_DAMAGED, own, sizeof own);
    put_u32(own + 4, 3 | OWN_REAL << 16);
    seal(own, sizeof own);
    assert_refused(RIGCAL_ERR_VERSION, own, sizeof own);
}

/* More free cameras than a rig may have, 3800, and no joint covariance after them. */
static void test_more_free_cameras_than_a_rig_may_have_are_damage(void)
{
    enum { MANY = 3801 };
    const size_t size = CAMERAS_AT + (size_t)MANY * STRIDE;
    rigcal_saved_info info;

    TEST_ON_HOST_ONLY("it takes 800 KB");
    uint8_t *const bytes = calloc(size, 1);
    TEST_ASSERT_NOT_NULL(bytes);
    memcpy(bytes, own, CAMERAS_AT);
    put_u32(bytes + 8, MANY);
    put_u32(bytes + 20, (uint32_t)size);
    seal(bytes, size);
    ASSERT_REFUSED(RIGCAL_ERR_DAMAGED, info, rigcal_store_info(&info, bytes, size));
    free(bytes);
}

/* A rig of 65535 cameras, all held, is saved and loaded in both forms; one of 65536 is not
 * saved, and bytes that have so many are damaged. */
static void test_the_most_cameras_of_a_rig_are_saved_and_loaded(void)
{
    enum { MOST = 65535, OLD_STRIDE = 16 + 45 * OWN_REAL };
    const size_t size = CAMERAS_AT + (size_t)MOST * STRIDE;
    const size_t old_size = 32 + (size_t)MOST * OLD_STRIDE, room = old_size + OLD_STRIDE;
    rigcal_calibrated_rig most = rig;
    rigcal_saved_info info;
    rigcal_real block[36];
    size_t n;

    TEST_ON_HOST_ONLY("it takes 60 MB");
    uint8_t *const bytes = malloc(room);
    most.capacity = MOST + 1;
    most.cameras = malloc((MOST + 1) * sizeof *most.cameras);
    most.group = calloc(MOST + 1, sizeof *most.group);
    most.held = malloc(MOST + 1);
    TEST_ASSERT_TRUE(bytes && most.cameras && most.group && most.held);
    for (size_t c = 0; c <= MOST; c++) {
        most.cameras[c] = rig.cameras[c % N];
        most.cameras[c].has_Sigma = 0;
        most.held[c] = 1;
    }
    most.n_cameras = MOST + 1;
    ASSERT_STATUS(RIGCAL_ERR_RANGE,
                  rigcal_store_save_rig(bytes, room, &n, &most, sequence, tag));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_calibrated_covariance(block, &most, 0, 1));
    most.n_cameras = MOST;
    ASSERT_STATUS(RIGCAL_OK, rigcal_calibrated_covariance(block, &most, 0, MOST - 1));
    TEST_ASSERT_EQUAL_size_t(size, rigcal_store_rig_size(MOST, 0));
    for (int is_old = 0; is_old < 2; is_old++) {
        const size_t stride = is_old ? OLD_STRIDE : STRIDE,
                     whole = is_old ? old_size : size;

        ASSERT_STATUS(
            RIGCAL_OK,
            is_old ? rigcal_store_save(bytes, room, &n, most.cameras, MOST, sequence, tag)
                   : rigcal_store_save_rig(bytes, room, &n, &most, sequence, tag));
        TEST_ASSERT_EQUAL_size_t(whole, n);
        most.cameras[MOST - 1].cam_from_rig.t[0] = 9;
        most.n_cameras = 0;
        ASSERT_STATUS(RIGCAL_OK, rigcal_store_load_rig(&most, &info, bytes, n));
        TEST_ASSERT_EQUAL_INT32(MOST, info.n_cameras);
        TEST_ASSERT_EQUAL_size_t(MOST, most.n_cameras);
        TEST_ASSERT_EQUAL_MEMORY(&rig.cameras[(MOST - 1) % N].cam_from_rig,
                                 &most.cameras[MOST - 1].cam_from_rig,
                                 sizeof(rigcal_transform));
        for (size_t c = 0; c < MOST; c++) {
            most.cameras[c].has_Sigma = 0;
        }
        memcpy(bytes + whole, bytes + whole - stride, stride); /* one more */
        put_u32(bytes + 8, MOST + 1);
        put_u32(bytes + 20, (uint32_t)(whole + stride));
        seal(bytes, whole + stride);
        ASSERT_REFUSED(RIGCAL_ERR_DAMAGED, info,
                       rigcal_store_info(&info, bytes, whole + stride));
    }
    free(most.held);
    free(most.group);
    free(most.cameras);
    free(bytes);
}

/* ---- numbers that are not taken -------------------------------------------- */

static void refuses_real(rigcal_status expected, size_t at, double x)
{
    uint8_t kept[8];

    memcpy(kept, own + at, OWN_REAL);
    put_real(own + at, x);
    seal(own, sizeof own);
    assert_refused(expected, own, sizeof own);
    memcpy(own + at, kept, OWN_REAL);
    seal(own, sizeof own);
}

static void test_numbers_that_no_function_takes_are_not_loaded(void)
{
    const size_t R_at = CAMERAS_AT + STRIDE + 20 + 12 * OWN_REAL;

    refuses_real(RIGCAL_ERR_RANGE, 32, 0);
    for (size_t k = 0; k < 4; k++) {
        refuses_real(RIGCAL_ERR_RANGE, 32 + k * OWN_REAL, -1);
        refuses_real(RIGCAL_ERR_NOT_FINITE, 32 + k * OWN_REAL, test_nan());
    }
    refuses_real(RIGCAL_ERR_ROTATION, R_at, 3);
    refuses_real(RIGCAL_ERR_CAMERA, CAMERAS_AT + STRIDE + 20, 0);
    for (size_t i = 0; i < UNKNOWNS; i++) {
        for (size_t j = 0; j <= i; j++) {
            const size_t at = SIGMA_AT + at_of(i, j) * OWN_REAL;

            refuses_real(RIGCAL_ERR_NOT_FINITE, at, test_nan());
            refuses_real(RIGCAL_ERR_NOT_FINITE, at, -test_infinity());
            if (j < i) { /* a correlation beyond 1 */
                refuses_real(RIGCAL_ERR_RANGE, at, 1);
                refuses_real(RIGCAL_ERR_RANGE, at, -1);
            }
        }
    }
    for (size_t i = 0; i < UNKNOWNS; i++) {
        refuses_real(RIGCAL_ERR_RANGE, SIGMA_AT + at_of(i, i) * OWN_REAL, -1e-9);
        refuses_real(RIGCAL_ERR_RANGE, SIGMA_AT + at_of(i, i) * OWN_REAL, 0);
    }
}

static void test_integers_that_no_function_takes_are_not_loaded(void)
{
    static const struct {
        size_t camera, at;
        uint32_t value;
        rigcal_status status;
    } BAD[] = {
        {0, 12, 2, RIGCAL_ERR_RANGE},          {0, 12, UINT32_MAX, RIGCAL_ERR_RANGE},
        {0, 16, 1, RIGCAL_ERR_RANGE},          {1, 16, 2, RIGCAL_ERR_RANGE},
        {2, 16, UINT32_MAX, RIGCAL_ERR_RANGE}, {1, 0, 2, RIGCAL_ERR_CAMERA},
        {2, 4, 0, RIGCAL_ERR_CAMERA},
    };

    for (size_t i = 0; i < sizeof BAD / sizeof BAD[0]; i++) {
        uint8_t *at = own + CAMERAS_AT + BAD[i].camera * STRIDE + BAD[i].at, kept[4];

        memcpy(kept, at, 4);
        put_u32(at, BAD[i].value);
        seal(own, sizeof own);
        assert_refused(BAD[i].status, own, sizeof own);
        memcpy(at, kept, 4);
    }
}

/* The block of a camera whose correlations are all below 1, but which is indefinite. */
static void make_indefinite(rigcal_real Sigma[])
{
    for (size_t i = 6; i < 12; i++) {
        for (size_t j = 0; j <= i; j++) {
            Sigma[at_of(i, j)] = RC(i == j ? 1 : 0);
        }
    }
    Sigma[at_of(7, 6)] = Sigma[at_of(8, 6)] = RC(0.9);
    Sigma[at_of(8, 7)] = RC(-0.9);
}

static void test_a_block_that_is_no_covariance_is_refused(void)
{
    uint8_t bytes[OWN_BYTES];
    size_t n;

    make_indefinite(saved.Sigma);
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, bytes,
                   rigcal_store_save_rig(bytes, sizeof bytes, &n, &rig, 0, 0));
    (void)rc_put_reals(own + SIGMA_AT, saved.Sigma, SIGMA_REALS);
    seal(own, sizeof own);
    assert_refused(RIGCAL_ERR_RANGE, own, sizeof own);
}

static void test_arrays_too_small_are_refused(void)
{
    static memory m;
    rigcal_calibrated_rig loaded = open_rig(&m);
    rigcal_saved_info info;

    for (size_t room = 0; room < N; room++) {
        loaded.capacity = room;
        ASSERT_REFUSED(RIGCAL_ERR_CAPACITY, m,
                       rigcal_store_load_rig(&loaded, &info, own, sizeof own));
    }
    loaded = open_rig(&m);
    for (size_t room = 0; room < SIGMA_REALS; room++) {
        loaded.Sigma_capacity = room;
        ASSERT_REFUSED(RIGCAL_ERR_CAPACITY, m,
                       rigcal_store_load_rig(&loaded, &info, own, sizeof own));
    }
    loaded.Sigma = NULL;
    ASSERT_REFUSED(RIGCAL_ERR_NULL, m,
                   rigcal_store_load_rig(&loaded, &info, own, sizeof own));
}

/* ---- what is not saved ---------------------------------------------------- */

static void assert_not_saved(rigcal_status expected, size_t capacity)
{
    uint8_t bytes[OWN_BYTES];
    size_t n_bytes;

    FILL(n_bytes);
    ASSERT_REFUSED(expected, bytes,
                   rigcal_store_save_rig(bytes, capacity, &n_bytes, &rig, sequence, tag));
    ASSERT_UNTOUCHED(n_bytes);
    setUp();
}

static void test_what_could_not_be_loaded_is_not_saved(void)
{
    assert_not_saved(RIGCAL_ERR_CAPACITY, OWN_BYTES - 1);
    rig.n_cameras = 0;
    assert_not_saved(RIGCAL_ERR_TOO_FEW, OWN_BYTES);
    rig.n_cameras = 65536;
    assert_not_saved(RIGCAL_ERR_RANGE, OWN_BYTES);
    rig.capacity = N - 1;
    assert_not_saved(RIGCAL_ERR_CAPACITY, OWN_BYTES);
    rig.Sigma_capacity--;
    assert_not_saved(RIGCAL_ERR_CAPACITY, OWN_BYTES);
    rig.sigma_px = 0;
    assert_not_saved(RIGCAL_ERR_STATE, OWN_BYTES);
    rig.F = TEST_INF;
    assert_not_saved(RIGCAL_ERR_NOT_FINITE, OWN_BYTES);
    saved.held[1] = 2;
    assert_not_saved(RIGCAL_ERR_RANGE, OWN_BYTES);
    saved.group[1] = 1;
    saved.group[2] = 3;
    assert_not_saved(RIGCAL_ERR_RANGE, OWN_BYTES);
    saved.cameras[0].cam_from_rig.R[4] = 2;
    assert_not_saved(RIGCAL_ERR_ROTATION, OWN_BYTES);
    saved.cameras[2].cam_from_rig.R[4] = 2;
    assert_not_saved(RIGCAL_ERR_ROTATION, OWN_BYTES);
    saved.cameras[2].camera.width = 0;
    assert_not_saved(RIGCAL_ERR_CAMERA, OWN_BYTES);
    for (size_t k = 0; k < SIGMA_REALS; k++) {
        saved.Sigma[k] = TEST_NAN;
        assert_not_saved(RIGCAL_ERR_NOT_FINITE, OWN_BYTES);
    }
    for (size_t i = 0; i < UNKNOWNS; i++) {
        saved.Sigma[at_of(i, i)] = RC(-1e-12);
        assert_not_saved(RIGCAL_ERR_RANGE, OWN_BYTES);
    }
    saved.Sigma[at_of(9, 2)] = 1; /* of two cameras */
    assert_not_saved(RIGCAL_ERR_RANGE, OWN_BYTES);
}

TEST_MAIN_WITH_SETUP()
{
    RUN_TEST(test_the_size_is_as_the_table_says);
    RUN_TEST(test_a_rig_is_saved_as_the_bytes_that_python_packs);
    RUN_TEST(test_those_bytes_are_loaded_as_the_rig);
    RUN_TEST(test_the_bytes_of_the_other_precision_are_loaded_too);
    RUN_TEST(test_bytes_of_the_older_form_are_loaded_without_a_joint_covariance);
    RUN_TEST(test_pairs_of_the_loaded_rig_are_those_of_the_adjusted_one);
    RUN_TEST(test_a_correlation_of_two_cameras_may_exceed_1_by_rounding);
    RUN_TEST(test_cameras_may_contradict_each_other_if_no_pair_does);
    RUN_TEST(test_what_is_behind_the_covariance_is_not_read);
    RUN_TEST(test_the_joint_covariance_is_checked_before_the_cameras);
    RUN_TEST(test_a_variance_of_0_is_taken);
    RUN_TEST(test_a_rig_of_which_all_cameras_are_held_has_no_covariance);
    RUN_TEST(test_a_missing_argument_is_named);
    RUN_TEST(test_every_length_too_short_is_refused);
    RUN_TEST(test_every_single_bit_flipped_is_refused);
    RUN_TEST(test_every_torn_write_is_refused);
    RUN_TEST(test_counts_that_do_not_fit_the_length_are_damage);
    RUN_TEST(test_more_free_cameras_than_a_rig_may_have_are_damage);
    RUN_TEST(test_the_most_cameras_of_a_rig_are_saved_and_loaded);
    RUN_TEST(test_numbers_that_no_function_takes_are_not_loaded);
    RUN_TEST(test_integers_that_no_function_takes_are_not_loaded);
    RUN_TEST(test_a_block_that_is_no_covariance_is_refused);
    RUN_TEST(test_arrays_too_small_are_refused);
    RUN_TEST(test_what_could_not_be_loaded_is_not_saved);
}
