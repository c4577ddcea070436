/* Stored calibrations, from any bytes and of any cameras. */
#include <stdlib.h>
#include <string.h>

#include "fuzz.h"

enum { CAMERAS_MOST = 8, FREE_MOST = 8, BYTES_MOST = 16384 };

/* The places of the two checksums in the stored form (examples/data/FORMAT.md). */
enum { HEADER = 32, CRC_OF_BODY = 24, CRC_OF_HEADER = 28 };

static uint32_t crc32(const uint8_t bytes[], size_t n)
{
    uint32_t crc = 0xFFFFFFFFu;
    size_t i;
    int bit;

    for (i = 0; i < n; i++) {
        crc ^= bytes[i];
        for (bit = 0; bit < 8; bit++) {
            crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320u : 0);
        }
    }
    return ~crc;
}

static void put(uint8_t bytes[], uint32_t word)
{
    int i;

    for (i = 0; i < 4; i++) {
        bytes[i] = (uint8_t)(word >> (8 * i));
    }
}

/* Corrects both checksums. Otherwise damage would be refused before anything else is
 * read. */
static void seal(uint8_t bytes[], size_t n)
{
    if (n >= HEADER) {
        put(bytes + CRC_OF_BODY, crc32(bytes + HEADER, n - HEADER));
        put(bytes + CRC_OF_HEADER, crc32(bytes, CRC_OF_HEADER));
    }
}

typedef struct {
    rigcal_mounted_camera cameras[CAMERAS_MOST];
    int32_t group[CAMERAS_MOST];
    uint8_t held[CAMERAS_MOST];
    rigcal_real Sigma[RIGCAL_CALIBRATED_SIZE(FREE_MOST)];
    rigcal_calibrated_rig rig;
} loaded;

static void open_loaded(loaded *to)
{
    MARK(*to);
    memset(&to->rig, 0, sizeof to->rig);
    to->rig.cameras = to->cameras;
    to->rig.group = to->group;
    to->rig.held = to->held;
    to->rig.capacity = CAMERAS_MOST;
    to->rig.Sigma = to->Sigma;
    to->rig.Sigma_capacity = RIGCAL_CALIBRATED_SIZE(FREE_MOST);
}

static void check_cameras(const rigcal_mounted_camera cameras[], size_t n)
{
    size_t i;

    for (i = 0; i < n; i++) {
        PROMISE(rigcal_camera_check(&cameras[i].camera) == RIGCAL_OK);
        PROMISE(fuzz_is_rotation(cameras[i].cam_from_rig.R, FUZZ_TOL(4e-6, 4e-3)));
        PROMISE(fuzz_all_finite(cameras[i].cam_from_rig.t, 3));
        PROMISE(cameras[i].has_Sigma == 0 || cameras[i].has_Sigma == 1);
        PROMISE(fuzz_all_finite(cameras[i].Sigma, 36));
    }
}

/* A calibration that was loaded must be saved and loaded again with the same bits. */
static void check_round_trip(const loaded *first, const rigcal_saved_info *info)
{
    static uint8_t bytes[BYTES_MOST], again[BYTES_MOST];
    loaded second;
    rigcal_saved_info its_info;
    size_t n, n_again;

    open_loaded(&second);
    if (first->rig.sigma_px > 0) {
        PROMISE(rigcal_store_save_rig(bytes, sizeof bytes, &n, &first->rig, info->sequence,
                                      info->tag) == RIGCAL_OK);
    } else {
        PROMISE(rigcal_store_save(bytes, sizeof bytes, &n, first->cameras,
                                  first->rig.n_cameras, info->sequence,
                                  info->tag) == RIGCAL_OK);
    }
    PROMISE(rigcal_store_load_rig(&second.rig, &its_info, bytes, n) == RIGCAL_OK);
    PROMISE(its_info.sequence == info->sequence && its_info.tag == info->tag);
    PROMISE(its_info.n_cameras == info->n_cameras && (size_t)its_info.n_bytes == n);
    PROMISE(its_info.real_bytes == rigcal_sizeof_real());
    if (first->rig.sigma_px > 0) {
        PROMISE(rigcal_store_save_rig(again, sizeof again, &n_again, &second.rig,
                                      info->sequence, info->tag) == RIGCAL_OK);
    } else {
        PROMISE(rigcal_store_save(again, sizeof again, &n_again, second.cameras,
                                  second.rig.n_cameras, info->sequence,
                                  info->tag) == RIGCAL_OK);
    }
    PROMISE(n_again == n && memcmp(again, bytes, n) == 0);
}

static void load(const uint8_t data[], size_t size, int is_sealed)
{
    uint8_t *bytes = malloc(size + 1); /* exactly this size, so that an access after the end
                                          is found */
    rigcal_mounted_camera cameras[CAMERAS_MOST];
    rigcal_saved_info info, other;
    rigcal_status told, status;
    loaded rig;

    memcpy(bytes, data, size);
    bytes = realloc(bytes, size > 0 ? size : 1);
    if (is_sealed) {
        seal(bytes, size);
    }
    MARK(info);
    told = rigcal_store_info(&info, bytes, size);
    PROMISE(fuzz_is_status(told) && told <= 0);
    PROMISE_UNTOUCHED(told, info);
    PROMISE(told < 0 || (info.n_bytes > 0 && (size_t)info.n_bytes <= size));
    MARK(cameras);
    MARK(other);
    status = rigcal_store_load(cameras, CAMERAS_MOST, &other, bytes, size);
    PROMISE(fuzz_is_status(status) && status <= 0);
    PROMISE_UNTOUCHED(status, cameras);
    PROMISE_UNTOUCHED(status, other);
    PROMISE(status < 0 || told == RIGCAL_OK);
    if (status == RIGCAL_OK) {
        PROMISE(memcmp(&info, &other, sizeof info) == 0);
        check_cameras(cameras, (size_t)info.n_cameras);
    }
    open_loaded(&rig);
    MARK(other);
    status = rigcal_store_load_rig(&rig.rig, &other, bytes, size);
    PROMISE(fuzz_is_status(status) && status <= 0);
    PROMISE_UNTOUCHED(status, other);
    PROMISE_UNTOUCHED(status, rig.cameras);
    PROMISE_UNTOUCHED(status, rig.Sigma);
    if (status == RIGCAL_OK) {
        check_cameras(rig.cameras, rig.rig.n_cameras);
        check_round_trip(&rig, &other);
    }
    free(bytes);
}

static void save(fuzz_bytes *bytes)
{
    static uint8_t stored[BYTES_MOST];
    rigcal_mounted_camera cameras[CAMERAS_MOST];
    const size_t n = (size_t)fuzz_below(bytes, CAMERAS_MOST + 1);
    rigcal_status status;
    size_t i, n_bytes;

    memset(cameras, 0, sizeof cameras);
    for (i = 0; i < n; i++) {
        const int kind = fuzz_below(bytes, 4);
        int k;

        fuzz_camera(&cameras[i].camera, bytes);
        fuzz_transform(&cameras[i].cam_from_rig, bytes);
        cameras[i].has_Sigma = kind > 0;
        for (k = 0; k < 6 && kind == 1; k++) {
            cameras[i].Sigma[7 * k] = fuzz_real(bytes);
        }
        if (kind >= 2) {
            cameras[i].has_Sigma = kind == 2 ? 1 : (int32_t)fuzz_word(bytes);
            fuzz_reals(cameras[i].Sigma, 36, bytes);
        }
    }
    MARK(stored);
    MARK(n_bytes);
    status = rigcal_store_save(stored, sizeof stored, &n_bytes, cameras, n, 7, 9);
    PROMISE(fuzz_is_status(status) && status <= 0);
    PROMISE_UNTOUCHED(status, stored);
    PROMISE_UNTOUCHED(status, n_bytes);
    if (status == RIGCAL_OK) {
        PROMISE(n_bytes == rigcal_store_size(n));
        PROMISE(fuzz_is_marked(stored + n_bytes, sizeof stored - n_bytes));
        load(stored, n_bytes, 0);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_bytes bytes = {data, data + size};
    const int kind = fuzz_below(&bytes, 3);

    if (kind == 2) {
        save(&bytes);
    } else {
        load(bytes.next, (size_t)(bytes.end - bytes.next), kind);
    }
    return 0;
}
