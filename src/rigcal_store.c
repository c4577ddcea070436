#include "rc_store.h"

#include <string.h>

/* ---- constants ----------------------------------------------------------- */

/* 1: how far an element of a rotation stored as floats may be moved to make it one of
 * doubles. The float build accepts as much. */
#define FLOAT_ROTATION_TOL RC(1e-3)

/* 1: the most negative eigenvalue of correlations that may be rounding, also that of a
 * covariance stored in double and loaded in float. */
#define CORRELATION_TOL RC_TOL(1e-9, 1e-5)

/* The byte form: DESIGN.md, "Stored calibration". All numbers little-endian. */
enum {
    FORM_VERSION = 1,
    AT_VERSION = 4,
    AT_REAL_BYTES = 6,
    AT_N_CAMERAS = 8,
    AT_SEQUENCE = 12,
    AT_TAG = 16,
    AT_N_BYTES = 20,
    AT_BODY_CRC = 24,
    AT_HEADER_CRC = 28,
    HEADER_BYTES = RIGCAL_STORE_HEADER_BYTES,

    CAMERA_INTEGERS = 4, /* lens, width, height, has_Sigma */
    CAMERA_REALS = 12,
    CAMERAS_MAX = RIGCAL_STORE_CAMERAS_MAX
};

static const uint8_t MAGIC[4] = {'R', 'I', 'G', 'C'};

#if RIGCAL_USE_FLOAT
typedef uint32_t real_bits;
#else
typedef uint64_t real_bits;
#endif

/* Bytes and bits of a number are copied, which takes IEEE 754 for granted. */
typedef char a_real_is_an_ieee_number[(sizeof(float) == 4 && FLT_MANT_DIG == 24 &&
                                       FLT_MAX_EXP == 128 &&
                                       sizeof(rigcal_real) == sizeof(real_bits) &&
                                       (RIGCAL_USE_FLOAT ||
                                        (DBL_MANT_DIG == 53 && DBL_MAX_EXP == 1024)))
                                          ? 1
                                          : -1];

typedef char
    a_camera_has_the_bytes_told[RIGCAL_STORE_SIZE(1) ==
                                        HEADER_BYTES + 4 * CAMERA_INTEGERS +
                                            (CAMERA_REALS + 12 + 21) * sizeof(rigcal_real)
                                    ? 1
                                    : -1];

uint32_t rc_crc32(const uint8_t bytes[], size_t n)
{
    RIGCAL_ASSERT(bytes != NULL || n == 0);
    /* Remainders of the sixteen nibbles. */
    static const uint32_t NIBBLE[16] = {0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac,
                                        0x76dc4190, 0x6b6b51f4, 0x4db26158, 0x5005713c,
                                        0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c,
                                        0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c};
    uint32_t crc = 0xffffffff;
    for (size_t i = 0; i < n; i++) {
        crc ^= bytes[i];
        crc = crc >> 4 ^ NIBBLE[crc & 15];
        crc = crc >> 4 ^ NIBBLE[crc & 15];
    }
    return ~crc;
}

/* ---- numbers to bytes: each returns where the next one goes --------------- */

static uint8_t *put_u32(uint8_t *at, uint32_t x)
{
    for (int i = 0; i < 4; i++) {
        at[i] = (uint8_t)(x >> 8 * i);
    }
    return at + 4;
}

static uint8_t *put_reals(uint8_t *at, const rigcal_real x[], int n)
{
    for (int i = 0; i < n; i++) {
        real_bits bits;
        memcpy(&bits, &x[i], sizeof bits);
        for (size_t k = 0; k < sizeof bits; k++) {
            *at++ = (uint8_t)(bits >> 8 * k);
        }
    }
    return at;
}

/* ---- bytes to numbers ----------------------------------------------------- */

static uint32_t u16_at(const uint8_t *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8;
}

static uint32_t u32_at(const uint8_t *at)
{
    return u16_at(at) | u16_at(at + 2) << 16;
}

static float float_of_bits(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

#if RIGCAL_USE_FLOAT

/* The float nearest to the double of these bits, ties to even, by integers: a
 * float build has no double arithmetic. Infinity for what is too large, and for
 * NaN. */
static rigcal_real real_of_double(uint64_t bits)
{
    enum { DROPPED = 52 - 23, ALL_DROPPED = 54, FLOAT_INFINITY = 0xff };
    const uint32_t sign = (uint32_t)(bits >> 63) << 31;
    const int32_t exponent = (int32_t)(bits >> 52 & 0x7ff) - 1023 + 127;
    const uint64_t mantissa = (bits & ((UINT64_C(1) << 52) - 1)) | UINT64_C(1) << 52;
    if (exponent >= FLOAT_INFINITY) {
        return float_of_bits(sign | (uint32_t)FLOAT_INFINITY << 23);
    }
    /* Below the normal floats, the more digits go the smaller it is. */
    const int32_t shift = (exponent >= 1) ? DROPPED : DROPPED + 1 - exponent;
    if (shift >= ALL_DROPPED) {
        return float_of_bits(sign);
    }
    const uint64_t rest = mantissa & ((UINT64_C(1) << shift) - 1);
    const uint64_t half = UINT64_C(1) << (shift - 1);
    uint32_t kept = (uint32_t)(mantissa >> shift);
    if (rest > half || (rest == half && (kept & 1) != 0)) {
        kept++;
    }
    /* The leading one of `kept` adds to the exponent, a carry does too. */
    const uint32_t below = (exponent >= 1) ? (uint32_t)(exponent - 1) << 23 : 0;
    return float_of_bits(sign | (below + kept));
}

#else

static rigcal_real real_of_double(uint64_t bits)
{
    rigcal_real x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

#endif

static const uint8_t *get_reals(rigcal_real x[], int n, const uint8_t *at,
                                int32_t real_bytes)
{
    for (int i = 0; i < n; i++) {
        x[i] = (real_bytes == 4)
                   ? (rigcal_real)float_of_bits(u32_at(at))
                   : real_of_double((uint64_t)u32_at(at + 4) << 32 | u32_at(at));
        at += real_bytes;
    }
    return at;
}

/* ---- one camera ----------------------------------------------------------- */

/* Element (i, j) over the standard deviations of i and j. */
static rigcal_real correlation(const rigcal_real Sigma[36], int i, int j)
{
    const rigcal_real x = Sigma[6 * i + j];
    const rigcal_real deviations = RC_SQRT(Sigma[7 * i]) * RC_SQRT(Sigma[7 * j]);
    return (RC_FABS(x) > 0) ? x / deviations : 0;
}

/* 1 when Sigma is symmetric and positive semidefinite, to rounding: its correlations, with
 * the tolerance added on the diagonal, have a Cholesky factor. */
static int is_covariance(const rigcal_real Sigma[36])
{
    rigcal_real L[6][6];
    for (int j = 0; j < 6; j++) {
        for (int i = j; i < 6; i++) {
            const rigcal_real c = correlation(Sigma, i, j);
            rigcal_real rest = (i == j) ? c + CORRELATION_TOL : c;
            if (!(RC_FABS(c - correlation(Sigma, j, i)) <= CORRELATION_TOL)) {
                return 0;
            }
            for (int k = 0; k < j; k++) {
                rest -= L[i][k] * L[j][k];
            }
            if (i == j && !(rest > 0)) {
                return 0;
            }
            L[i][j] = (i == j) ? RC_SQRT(rest) : rest / L[j][j];
        }
    }
    return 1;
}

static rigcal_status check_mounted(const rigcal_mounted_camera *m)
{
    rigcal_status status = rc_check_camera(&m->camera);
    if (status == RIGCAL_OK) {
        status = rc_check_transform(&m->cam_from_rig);
    }
    if (status != RIGCAL_OK) {
        return status;
    }
    if (m->has_Sigma != 0 && m->has_Sigma != 1) {
        return RIGCAL_ERR_RANGE;
    }
    if (m->has_Sigma == 0) {
        return RIGCAL_OK;
    }
    if (!rc_all_finite(m->Sigma, 36)) {
        return RIGCAL_ERR_NOT_FINITE;
    }
    for (int i = 0; i < 6; i++) {
        if (!(m->Sigma[7 * i] >= 0)) {
            return RIGCAL_ERR_RANGE;
        }
    }
    return is_covariance(m->Sigma) ? RIGCAL_OK : RIGCAL_ERR_RANGE;
}

static uint8_t *put_mounted(uint8_t *at, const rigcal_mounted_camera *m)
{
    static const rigcal_real UNKNOWN[6] = {0};
    const rigcal_camera *const c = &m->camera;
    const rigcal_real numbers[CAMERA_REALS] = {c->fx, c->fy, c->cx, c->cy, c->k1, c->k2,
                                               c->p1, c->p2, c->k3, c->k4, c->k5, c->k6};
    at = put_u32(at, (uint32_t)c->lens);
    at = put_u32(at, (uint32_t)c->width);
    at = put_u32(at, (uint32_t)c->height);
    at = put_u32(at, (uint32_t)m->has_Sigma);
    at = put_reals(at, numbers, CAMERA_REALS);
    at = put_reals(at, m->cam_from_rig.R, 9);
    at = put_reals(at, m->cam_from_rig.t, 3);
    for (int row = 0; row < 6; row++) {
        at = put_reals(at, (m->has_Sigma == 1) ? m->Sigma + 6 * row : UNKNOWN, row + 1);
    }
    return at;
}

/* A rotation of floats is orthonormal to 1e-7 at best, which doubles show. */
static void make_orthonormal(rigcal_real R[9])
{
    rigcal_real nearest[9];
    if (!rc_rotation_nearest(nearest, R)) {
        return;
    }
    for (int i = 0; i < 9; i++) {
        if (!(RC_FABS(nearest[i] - R[i]) <= FLOAT_ROTATION_TOL)) {
            return;
        }
    }
    memcpy(R, nearest, sizeof nearest);
}

static void get_mounted(rigcal_mounted_camera *m, const uint8_t *at, int32_t real_bytes)
{
    rigcal_camera *const c = &m->camera;
    rigcal_real numbers[CAMERA_REALS];
    c->lens = (int32_t)u32_at(at);
    c->width = (int32_t)u32_at(at + 4);
    c->height = (int32_t)u32_at(at + 8);
    m->has_Sigma = (int32_t)u32_at(at + 12);
    at = get_reals(numbers, CAMERA_REALS, at + 4 * CAMERA_INTEGERS, real_bytes);
    c->fx = numbers[0];
    c->fy = numbers[1];
    c->cx = numbers[2];
    c->cy = numbers[3];
    c->k1 = numbers[4];
    c->k2 = numbers[5];
    c->p1 = numbers[6];
    c->p2 = numbers[7];
    c->k3 = numbers[8];
    c->k4 = numbers[9];
    c->k5 = numbers[10];
    c->k6 = numbers[11];
    at = get_reals(m->cam_from_rig.R, 9, at, real_bytes);
    at = get_reals(m->cam_from_rig.t, 3, at, real_bytes);
    if ((size_t)real_bytes < sizeof(rigcal_real)) {
        make_orthonormal(m->cam_from_rig.R);
    }
    for (int row = 0; row < 6; row++) {
        at = get_reals(m->Sigma + 6 * row, row + 1, at, real_bytes);
        for (int column = 0; column < row; column++) {
            m->Sigma[6 * column + row] = m->Sigma[6 * row + column];
        }
    }
    if (m->has_Sigma == 0) {
        memset(m->Sigma, 0, sizeof m->Sigma);
    }
}

/* ---- public --------------------------------------------------------------- */

size_t rigcal_store_size(size_t n_cameras)
{
    return (n_cameras >= 1 && n_cameras <= CAMERAS_MAX) ? RIGCAL_STORE_SIZE(n_cameras) : 0;
}

rigcal_status rigcal_store_save(uint8_t bytes[], size_t capacity, size_t *n_bytes,
                                const rigcal_mounted_camera cameras[], size_t n_cameras,
                                uint32_t sequence, uint32_t tag)
{
    if (bytes == NULL || n_bytes == NULL || cameras == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (n_cameras < 1) {
        return RIGCAL_ERR_TOO_FEW;
    }
    if (n_cameras > CAMERAS_MAX) {
        return RIGCAL_ERR_RANGE;
    }
    const size_t size = RIGCAL_STORE_SIZE(n_cameras);
    if (capacity < size) {
        return RIGCAL_ERR_CAPACITY;
    }
    for (size_t i = 0; i < n_cameras; i++) {
        const rigcal_status status = check_mounted(&cameras[i]);
        if (status != RIGCAL_OK) {
            return status;
        }
    }
    uint8_t *at = bytes + HEADER_BYTES;
    for (size_t i = 0; i < n_cameras; i++) {
        at = put_mounted(at, &cameras[i]);
    }
    memcpy(bytes, MAGIC, sizeof MAGIC);
    (void)put_u32(bytes + AT_VERSION, (uint32_t)FORM_VERSION | (uint32_t)sizeof(rigcal_real)
                                                                   << 16);
    (void)put_u32(bytes + AT_N_CAMERAS, (uint32_t)n_cameras);
    (void)put_u32(bytes + AT_SEQUENCE, sequence);
    (void)put_u32(bytes + AT_TAG, tag);
    (void)put_u32(bytes + AT_N_BYTES, (uint32_t)size);
    (void)put_u32(bytes + AT_BODY_CRC, rc_crc32(bytes + HEADER_BYTES, size - HEADER_BYTES));
    (void)put_u32(bytes + AT_HEADER_CRC, rc_crc32(bytes, AT_HEADER_CRC));
    *n_bytes = size;
    return RIGCAL_OK;
}

rigcal_status rigcal_store_info(rigcal_saved_info *info, const uint8_t bytes[],
                                size_t n_bytes)
{
    if (info == NULL || bytes == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (n_bytes < HEADER_BYTES) {
        return RIGCAL_ERR_DAMAGED;
    }
    for (size_t i = 0; i < sizeof MAGIC; i++) {
        if (bytes[i] != MAGIC[i]) {
            return RIGCAL_ERR_FOREIGN;
        }
    }
    /* The length is not believed before its own CRC is seen to hold. */
    if (u32_at(bytes + AT_HEADER_CRC) != rc_crc32(bytes, AT_HEADER_CRC)) {
        return RIGCAL_ERR_DAMAGED;
    }
    const uint32_t real_bytes = u16_at(bytes + AT_REAL_BYTES);
    if (u16_at(bytes + AT_VERSION) != FORM_VERSION ||
        (real_bytes != 4 && real_bytes != 8)) {
        return RIGCAL_ERR_VERSION;
    }
    const uint32_t n = u32_at(bytes + AT_N_CAMERAS);
    const uint32_t size = u32_at(bytes + AT_N_BYTES);
    if (n < 1 || n > CAMERAS_MAX || size > n_bytes ||
        size != RIGCAL_STORE_SIZE_OF(n, real_bytes) ||
        u32_at(bytes + AT_BODY_CRC) !=
            rc_crc32(bytes + HEADER_BYTES, size - HEADER_BYTES)) {
        return RIGCAL_ERR_DAMAGED;
    }
    info->sequence = u32_at(bytes + AT_SEQUENCE);
    info->tag = u32_at(bytes + AT_TAG);
    info->n_cameras = (int32_t)n;
    info->n_bytes = (int32_t)size;
    info->real_bytes = (int32_t)real_bytes;
    return RIGCAL_OK;
}

rigcal_status rigcal_store_load(rigcal_mounted_camera cameras[], size_t capacity,
                                rigcal_saved_info *info, const uint8_t bytes[],
                                size_t n_bytes)
{
    if (cameras == NULL || info == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_saved_info found;
    rigcal_mounted_camera m;
    rigcal_status status = rigcal_store_info(&found, bytes, n_bytes);
    if (status != RIGCAL_OK) {
        return status;
    }
    const size_t n = (size_t)found.n_cameras;
    const size_t stride = ((size_t)found.n_bytes - HEADER_BYTES) / n;
    if (capacity < n) {
        return RIGCAL_ERR_CAPACITY;
    }
    for (size_t i = 0; i < n; i++) {
        get_mounted(&m, bytes + HEADER_BYTES + i * stride, found.real_bytes);
        status = check_mounted(&m);
        if (status != RIGCAL_OK) {
            return status;
        }
    }
    for (size_t i = 0; i < n; i++) {
        get_mounted(&cameras[i], bytes + HEADER_BYTES + i * stride, found.real_bytes);
    }
    *info = found;
    return RIGCAL_OK;
}
