#include "rc_joint.h"
#include "rc_store.h"

#include <string.h>

/* ---- constants ----------------------------------------------------------- */

/* 1: the most by which an element of a rotation stored as floats may be moved to make a
 * rotation of doubles. The float build accepts as much. */
#define FLOAT_ROTATION_TOL RC(1e-3)

/* 1: a negative eigenvalue of correlations up to this may be rounding, also of a covariance
 * that is stored in double and loaded in float. */
#define CORRELATION_TOL RC_TOL(1e-9, 1e-5)

/* The byte form: examples/data/FORMAT.md. All numbers are little-endian. */
enum {
    FORM_CAMERAS = 1, /* version: each camera has its own covariance */
    FORM_RIG = 2,     /* version: all cameras have a joint one */
    AT_VERSION = 4,
    AT_REAL_BYTES = 6,
    AT_N_CAMERAS = 8,
    AT_SEQUENCE = 12,
    AT_TAG = 16,
    AT_N_BYTES = 20,
    AT_BODY_CRC = 24,
    AT_HEADER_CRC = 28,
    HEADER_BYTES = RIGCAL_STORE_HEADER_BYTES,

    CAMERA_INTEGERS = 4, /* lens, width, height, has_Sigma (in a rig: held) */
    AT_ROLE = 12,
    AT_GROUP = 16, /* in a rig only */
    CAMERA_REALS = 12,
    RIG_REALS = 4,
    CAMERAS_MAX = RIGCAL_STORE_CAMERAS_MAX
};

static const uint8_t MAGIC[4] = {'R', 'I', 'G', 'C'};

typedef char
    a_camera_has_the_bytes_told[RIGCAL_STORE_SIZE(1) ==
                                        HEADER_BYTES + 4 * CAMERA_INTEGERS +
                                            (CAMERA_REALS + 12 + 21) * sizeof(rigcal_real)
                                    ? 1
                                    : -1];

/* The length of the bytes must fit an int32_t. */
typedef char
    a_length_fits[RIGCAL_STORE_RIG_SIZE_OF((uint64_t)CAMERAS_MAX,
                                           (uint64_t)RIGCAL_STORE_FREE_MAX, 8) <= INT32_MAX
                      ? 1
                      : -1];

/* ---- one camera ----------------------------------------------------------- */

/* Element (i, j) divided by the standard deviations of i and j. */
static rigcal_real correlation(const rigcal_real Sigma[36], int i, int j)
{
    const rigcal_real x = Sigma[6 * i + j];
    const rigcal_real deviations = RC_SQRT(Sigma[7 * i]) * RC_SQRT(Sigma[7 * j]);
    return (RC_FABS(x) > 0) ? x / deviations : 0;
}

/* Whether Sigma is symmetric and positive semidefinite to rounding: its correlations, with
 * the tolerance added to the diagonal, have a Cholesky factor. */
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

/* Writes a camera without its covariance. role: has_Sigma, or whether the camera is held. A
 * group below 0 is not stored. */
static uint8_t *put_mounted(uint8_t *at, const rigcal_mounted_camera *m, int32_t role,
                            int32_t group)
{
    const rigcal_camera *const c = &m->camera;
    const rigcal_real numbers[CAMERA_REALS] = {c->fx, c->fy, c->cx, c->cy, c->k1, c->k2,
                                               c->p1, c->p2, c->k3, c->k4, c->k5, c->k6};
    at = rc_put_u32(at, (uint32_t)c->lens);
    at = rc_put_u32(at, (uint32_t)c->width);
    at = rc_put_u32(at, (uint32_t)c->height);
    at = rc_put_u32(at, (uint32_t)role);
    at = (group >= 0) ? rc_put_u32(at, (uint32_t)group) : at;
    at = rc_put_reals(at, numbers, CAMERA_REALS);
    at = rc_put_reals(at, m->cam_from_rig.R, 9);
    return rc_put_reals(at, m->cam_from_rig.t, 3);
}

static uint8_t *put_Sigma(uint8_t *at, const rigcal_mounted_camera *m)
{
    static const rigcal_real UNKNOWN[6] = {0};
    for (size_t row = 0; row < 6; row++) {
        at = rc_put_reals(at, (m->has_Sigma == 1) ? m->Sigma + 6 * row : UNKNOWN, row + 1);
    }
    return at;
}

#if !RIGCAL_USE_FLOAT
/* Makes a rotation that was stored as floats orthonormal in doubles. Floats are so to 1e-7
 * at best. */
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
#endif

/* Where the parts of stored bytes are. */
typedef struct {
    const uint8_t *cameras; /* the first; the next ones follow every `stride` bytes */
    size_t stride;
    const uint8_t *joint;     /* NULL: each camera has its own covariance */
    const rigcal_real *Sigma; /* the joint covariance, if it is not in the bytes */
    const uint8_t *rig;       /* RIG_REALS numbers before the cameras, of a rig */
    int32_t real_bytes;
} form_parts;

static void find_parts(form_parts *p, const uint8_t bytes[], size_t n_cameras,
                       int32_t real_bytes)
{
    const size_t r = (size_t)real_bytes;
    p->real_bytes = real_bytes;
    p->Sigma = NULL;
    p->rig = bytes + HEADER_BYTES;
    if (rc_u16_at(bytes + AT_VERSION) == FORM_RIG) {
        p->stride = 4 * (CAMERA_INTEGERS + 1) + (CAMERA_REALS + 12) * r;
        p->cameras = p->rig + RIG_REALS * r;
        p->joint = p->cameras + n_cameras * p->stride;
    } else {
        p->stride = 4 * CAMERA_INTEGERS + (CAMERA_REALS + 12 + 21) * r;
        p->cameras = p->rig;
        p->joint = NULL;
    }
}

/* Reads the covariance of a camera: behind its pose, or from unknown `first` on in the
 * joint one. It is 0 if the camera is held or its covariance unknown. */
static void get_Sigma(rigcal_mounted_camera *m, const form_parts *p, const uint8_t *at,
                      size_t first, int is_held)
{
    const int is_known = (p->joint == NULL) ? m->has_Sigma != 0 : !is_held;
    for (size_t row = 0; row < 6; row++) {
        if (p->joint != NULL && !is_held) {
            at = p->joint + rc_packed_at(first + row, first) * (size_t)p->real_bytes;
        }
        if (is_known) {
            at = rc_get_reals(m->Sigma + 6 * row, row + 1, at, p->real_bytes);
        }
        for (size_t column = 0; column <= row; column++) {
            m->Sigma[6 * column + row] = m->Sigma[6 * row + column] =
                is_known ? m->Sigma[6 * row + column] : 0;
        }
    }
}

/* Reads camera `index`, whose unknowns begin at *first. *first becomes that of the next
 * camera. */
static void get_mounted(rigcal_mounted_camera *m, size_t *first, const form_parts *p,
                        size_t index)
{
    const int32_t real_bytes = p->real_bytes;
    const uint8_t *at = p->cameras + index * p->stride;
    const int is_held = p->joint != NULL && rc_u32_at(at + AT_ROLE) != 0;
    rigcal_camera *const c = &m->camera;
    rigcal_real numbers[CAMERA_REALS];
    c->lens = (int32_t)rc_u32_at(at);
    c->width = (int32_t)rc_u32_at(at + 4);
    c->height = (int32_t)rc_u32_at(at + 8);
    m->has_Sigma = (p->joint != NULL) ? 1 : (int32_t)rc_u32_at(at + AT_ROLE);
    at += (p->joint != NULL) ? AT_GROUP + 4 : AT_ROLE + 4;
    at = rc_get_reals(numbers, CAMERA_REALS, at, real_bytes);
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
    at = rc_get_reals(m->cam_from_rig.R, 9, at, real_bytes);
    at = rc_get_reals(m->cam_from_rig.t, 3, at, real_bytes);
#if !RIGCAL_USE_FLOAT
    if ((size_t)real_bytes < sizeof(rigcal_real)) {
        make_orthonormal(m->cam_from_rig.R);
    }
#endif
    get_Sigma(m, p, at, *first, is_held);
    *first += is_held ? 0 : 6;
}

/* ---- the joint covariance ------------------------------------------------ */

/* Element k of the packed covariance, from a rig or from bytes. */
static rigcal_real joint_at(const form_parts *p, size_t k)
{
    rigcal_real x;
    if (p->Sigma != NULL) {
        return p->Sigma[k];
    }
    (void)rc_get_reals(&x, 1, p->joint + k * (size_t)p->real_bytes, p->real_bytes);
    return x;
}

/* Checks that no variance is below 0 and no correlation exceeds 1. Time O(n^2) */
static rigcal_status check_joint(const form_parts *p, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const rigcal_real variance = joint_at(p, rc_packed_at(i, i));
        if (!rc_all_finite(&variance, 1)) {
            return RIGCAL_ERR_NOT_FINITE;
        }
        if (!(variance >= 0)) {
            return RIGCAL_ERR_RANGE;
        }
        const rigcal_real most = (1 + CORRELATION_TOL) * RC_SQRT(variance);
        for (size_t j = 0; j < i; j++) {
            const rigcal_real x = joint_at(p, rc_packed_at(i, j));
            const rigcal_real other = joint_at(p, rc_packed_at(j, j));
            if (!rc_all_finite(&x, 1)) {
                return RIGCAL_ERR_NOT_FINITE;
            }
            if (!(RC_FABS(x) <= most * RC_SQRT(other))) {
                return RIGCAL_ERR_RANGE;
            }
        }
    }
    return RIGCAL_OK;
}

/* Number of cameras in the bytes of a rig that are not held. */
static size_t count_free(const form_parts *p, size_t n_cameras)
{
    size_t n_free = 0;
    for (size_t c = 0; c < n_cameras; c++) {
        n_free += rc_u32_at(p->cameras + c * p->stride + AT_ROLE) == 0;
    }
    return n_free;
}

/* Checks what form 2 has of each camera in addition to form 1: whether it is held, and its
 * group. */
static rigcal_status check_links(const form_parts *p, size_t n_cameras)
{
    uint32_t groups = 0;
    for (size_t c = 0; c < n_cameras; c++) {
        const uint8_t *const at = p->cameras + c * p->stride;
        const uint32_t group = rc_u32_at(at + AT_GROUP);
        if (rc_u32_at(at + AT_ROLE) > 1 || group > groups) {
            return RIGCAL_ERR_RANGE;
        }
        groups += group == groups;
    }
    return RIGCAL_OK;
}

/* ---- header -------------------------------------------------------------- */

static void seal(uint8_t bytes[], size_t size, uint32_t version, size_t n_cameras,
                 uint32_t sequence, uint32_t tag)
{
    memcpy(bytes, MAGIC, sizeof MAGIC);
    (void)rc_put_u32(bytes + AT_VERSION, version | (uint32_t)sizeof(rigcal_real) << 16);
    (void)rc_put_u32(bytes + AT_N_CAMERAS, (uint32_t)n_cameras);
    (void)rc_put_u32(bytes + AT_SEQUENCE, sequence);
    (void)rc_put_u32(bytes + AT_TAG, tag);
    (void)rc_put_u32(bytes + AT_N_BYTES, (uint32_t)size);
    (void)rc_put_u32(bytes + AT_BODY_CRC,
                     rc_crc32(bytes + HEADER_BYTES, size - HEADER_BYTES));
    (void)rc_put_u32(bytes + AT_HEADER_CRC, rc_crc32(bytes, AT_HEADER_CRC));
}

/* Whether the length of bytes with right CRCs is that of their cameras. *n_free: cameras of
 * the joint covariance, or -1. */
static int is_length_right(int32_t *n_free, const uint8_t bytes[], size_t size, size_t n,
                           int32_t real_bytes)
{
    const size_t r = (size_t)real_bytes;
    form_parts p;
    *n_free = -1;
    if (rc_u16_at(bytes + AT_VERSION) != FORM_RIG) {
        return size == RIGCAL_STORE_SIZE_OF(n, r);
    }
    if (size < RIGCAL_STORE_RIG_SIZE_OF(n, 0, r)) {
        return 0;
    }
    find_parts(&p, bytes, n, real_bytes);
    const size_t count = count_free(&p, n);
    *n_free = (int32_t)count;
    return count <= RIGCAL_STORE_FREE_MAX && size == RIGCAL_STORE_RIG_SIZE_OF(n, count, r);
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
        at = put_mounted(at, &cameras[i], cameras[i].has_Sigma, -1);
        at = put_Sigma(at, &cameras[i]);
    }
    seal(bytes, size, FORM_CAMERAS, n_cameras, sequence, tag);
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
    /* The length is used only after the header's CRC was found right. */
    if (rc_u32_at(bytes + AT_HEADER_CRC) != rc_crc32(bytes, AT_HEADER_CRC)) {
        return RIGCAL_ERR_DAMAGED;
    }
    const uint32_t real_bytes = rc_u16_at(bytes + AT_REAL_BYTES);
    const uint32_t version = rc_u16_at(bytes + AT_VERSION);
    if ((version != FORM_CAMERAS && version != FORM_RIG) ||
        (real_bytes != 4 && real_bytes != 8)) {
        return RIGCAL_ERR_VERSION;
    }
    const uint32_t n = rc_u32_at(bytes + AT_N_CAMERAS);
    const uint32_t size = rc_u32_at(bytes + AT_N_BYTES);
    int32_t n_free;
    if (n < 1 || n > CAMERAS_MAX || size > n_bytes || size < HEADER_BYTES ||
        rc_u32_at(bytes + AT_BODY_CRC) !=
            rc_crc32(bytes + HEADER_BYTES, size - HEADER_BYTES) ||
        !is_length_right(&n_free, bytes, size, n, (int32_t)real_bytes)) {
        return RIGCAL_ERR_DAMAGED;
    }
    info->sequence = rc_u32_at(bytes + AT_SEQUENCE);
    info->tag = rc_u32_at(bytes + AT_TAG);
    info->n_cameras = (int32_t)n;
    info->n_free = n_free;
    info->n_bytes = (int32_t)size;
    info->real_bytes = (int32_t)real_bytes;
    return RIGCAL_OK;
}

/* Checks the numbers in complete bytes, which `info` describes. It accepts only what
 * rigcal_store_save would save. */
static rigcal_status check_bytes(form_parts *p, const uint8_t bytes[],
                                 const rigcal_saved_info *info)
{
    const size_t n = (size_t)info->n_cameras;
    rigcal_mounted_camera m;
    size_t first = 0;
    find_parts(p, bytes, n, info->real_bytes);
    if (p->joint != NULL) {
        rigcal_real numbers[RIG_REALS];
        (void)rc_get_reals(numbers, RIG_REALS, p->rig, p->real_bytes);
        rigcal_status status = rc_calibrated_numbers(numbers);
        if (status == RIGCAL_ERR_STATE) { /* the bytes claim a covariance */
            status = RIGCAL_ERR_RANGE;
        }
        if (status == RIGCAL_OK) {
            status = check_links(p, n);
        }
        if (status == RIGCAL_OK) {
            status = check_joint(p, 6 * (size_t)info->n_free);
        }
        if (status != RIGCAL_OK) {
            return status;
        }
    }
    for (size_t i = 0; i < n; i++) {
        get_mounted(&m, &first, p, i);
        const rigcal_status status = check_mounted(&m);
        if (status != RIGCAL_OK) {
            return status;
        }
    }
    return RIGCAL_OK;
}

static void get_cameras(rigcal_mounted_camera cameras[], const form_parts *p, size_t n)
{
    size_t first = 0;
    for (size_t i = 0; i < n; i++) {
        get_mounted(&cameras[i], &first, p, i);
    }
}

rigcal_status rigcal_store_load(rigcal_mounted_camera cameras[], size_t capacity,
                                rigcal_saved_info *info, const uint8_t bytes[],
                                size_t n_bytes)
{
    if (cameras == NULL || info == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_saved_info found;
    form_parts p;
    rigcal_status status = rigcal_store_info(&found, bytes, n_bytes);
    if (status != RIGCAL_OK) {
        return status;
    }
    const size_t n = (size_t)found.n_cameras;
    if (capacity < n) {
        return RIGCAL_ERR_CAPACITY;
    }
    status = check_bytes(&p, bytes, &found);
    if (status != RIGCAL_OK) {
        return status;
    }
    get_cameras(cameras, &p, n);
    *info = found;
    return RIGCAL_OK;
}

/* ---- public: a calibrated rig -------------------------------------------- */

size_t rigcal_store_rig_size(size_t n_cameras, size_t n_free)
{
    return (n_cameras >= 1 && n_cameras <= CAMERAS_MAX && n_free <= n_cameras &&
            n_free <= RIGCAL_STORE_FREE_MAX)
               ? RIGCAL_STORE_RIG_SIZE(n_cameras, n_free)
               : 0;
}

/* Checks the numbers that rigcal_store_save_rig may refuse. A camera's own covariance is
 * its block of the joint one. */
static rigcal_status check_rig(const rigcal_calibrated_rig *rig, size_t n_free)
{
    const form_parts p = {.Sigma = rig->Sigma};
    const rigcal_status status = check_joint(&p, 6 * n_free);
    rigcal_real first = 0;
    for (size_t c = 0; status == RIGCAL_OK && c < rig->n_cameras; c++) {
        rigcal_mounted_camera m = rig->cameras[c];
        const rigcal_real at = rig->held[c] ? -1 : first;
        m.has_Sigma = 1;
        rc_joint_block(m.Sigma, rig->Sigma, at, at);
        const rigcal_status of_camera = check_mounted(&m);
        if (of_camera != RIGCAL_OK) {
            return of_camera;
        }
        first += rig->held[c] ? 0 : 6;
    }
    return status;
}

rigcal_status rigcal_store_save_rig(uint8_t bytes[], size_t capacity, size_t *n_bytes,
                                    const rigcal_calibrated_rig *rig, uint32_t sequence,
                                    uint32_t tag)
{
    size_t n_free;
    if (bytes == NULL || n_bytes == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rc_calibrated_check(&n_free, rig);
    if (status != RIGCAL_OK) {
        return status;
    }
    const size_t size = RIGCAL_STORE_RIG_SIZE(rig->n_cameras, n_free);
    if (capacity < size) {
        return RIGCAL_ERR_CAPACITY;
    }
    status = check_rig(rig, n_free);
    if (status != RIGCAL_OK) {
        return status;
    }
    const rigcal_real numbers[RIG_REALS] = {rig->sigma_px, rig->F, rig->freedom_between,
                                            rig->freedom_within};
    uint8_t *at = rc_put_reals(bytes + HEADER_BYTES, numbers, RIG_REALS);
    for (size_t c = 0; c < rig->n_cameras; c++) {
        at = put_mounted(at, &rig->cameras[c], rig->held[c], rig->group[c]);
    }
    (void)rc_put_reals(at, rig->Sigma, rigcal_calibrated_size(n_free));
    seal(bytes, size, FORM_RIG, rig->n_cameras, sequence, tag);
    *n_bytes = size;
    return RIGCAL_OK;
}

/* Reads the numbers of a rig, and whether each camera is held, its group and the camera. */
static void get_rig(rigcal_calibrated_rig *rig, const form_parts *p,
                    const rigcal_saved_info *info)
{
    const int is_joint = p->joint != NULL;
    rigcal_real numbers[RIG_REALS] = {0};
    rig->n_cameras = (size_t)info->n_cameras;
    if (is_joint) {
        (void)rc_get_reals(numbers, RIG_REALS, p->rig, p->real_bytes);
        (void)rc_get_reals(rig->Sigma, rigcal_calibrated_size((size_t)info->n_free),
                           p->joint, p->real_bytes);
    }
    rig->sigma_px = numbers[0];
    rig->F = numbers[1];
    rig->freedom_between = numbers[2];
    rig->freedom_within = numbers[3];
    for (size_t c = 0; c < rig->n_cameras; c++) {
        const uint8_t *const at = p->cameras + c * p->stride;
        rig->held[c] = is_joint ? (uint8_t)rc_u32_at(at + AT_ROLE) : 0;
        rig->group[c] = is_joint ? (int32_t)rc_u32_at(at + AT_GROUP) : 0;
    }
    get_cameras(rig->cameras, p, rig->n_cameras);
}

rigcal_status rigcal_store_load_rig(rigcal_calibrated_rig *rig, rigcal_saved_info *info,
                                    const uint8_t bytes[], size_t n_bytes)
{
    rigcal_saved_info found;
    form_parts p;
    if (rig == NULL || info == NULL || rig->cameras == NULL || rig->group == NULL ||
        rig->held == NULL) {
        return RIGCAL_ERR_NULL;
    }
    rigcal_status status = rigcal_store_info(&found, bytes, n_bytes);
    if (status != RIGCAL_OK) {
        return status;
    }
    if (found.n_free >= 0 && rig->Sigma == NULL) {
        return RIGCAL_ERR_NULL;
    }
    if (rig->capacity < (size_t)found.n_cameras ||
        (found.n_free >= 0 &&
         rig->Sigma_capacity < rigcal_calibrated_size((size_t)found.n_free))) {
        return RIGCAL_ERR_CAPACITY;
    }
    status = check_bytes(&p, bytes, &found);
    if (status != RIGCAL_OK) {
        return status;
    }
    get_rig(rig, &p, &found);
    *info = found;
    return RIGCAL_OK;
}
