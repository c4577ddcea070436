/* For Frama-C's Eva: whatever the bytes, the reader of stored calibrations accesses
 * nothing out of bounds. tests/proof/run.sh runs it.
 *
 * The header states how many bytes belong to the calibration. Stated lengths from
 * SHORTEST to LONGEST are tried one by one. With each, a caller gives every length at
 * once: at least the stated one, up to SIZE_MAX, in an array that ends where the stated
 * bytes do; and less, in an array that ends where the header does. All bytes are unknown
 * except the stated length and three fields of the header: REAL_BYTES, VERSION and
 * N_CAMERAS. In version 2 it is also known whether the first camera is held, HELD. With
 * ANY_HEADER only the stated length is known. Then bytes without a whole header are tried
 * too, and a header that states more than LONGEST where fewer bytes are given. */
#include "rc_store.h"
#include "rigcal_rig.h"

#include "__fc_builtin.h"

enum {
    CAPACITY = 2,
    LOWER = 3 * CAPACITY * (6 * CAPACITY + 1),
    HEADER = RIGCAL_STORE_HEADER_BYTES,
    AT_STATED = 20,
    ROLE = 32 + 4 * REAL_BYTES + 12 /* place of the first camera's role in version 2 */
};

static uint8_t memory[LONGEST];
static rigcal_mounted_camera cameras[CAPACITY];
static int32_t group[CAPACITY];
static uint8_t held[CAPACITY];
static rigcal_real Sigma[LOWER];

/* An array of `size` bytes that ends where memory does. */
static uint8_t *unknown_bytes(size_t size)
{
    Frama_C_make_unknown((char *)memory, sizeof memory);
    return memory + LONGEST - size;
}

static void state(uint8_t bytes[], size_t size, uint32_t stated)
{
    for (size_t i = 0; i < 4; i++) {
        bytes[AT_STATED + i] = (uint8_t)(stated >> 8 * i);
    }
#ifndef ANY_HEADER
    const uint8_t known[8] = {VERSION, 0, REAL_BYTES, 0, N_CAMERAS, 0, 0, 0};
    for (size_t i = 0; i < sizeof known; i++) {
        bytes[4 + i] = known[i];
    }
    for (size_t i = 0; VERSION == 2 && i < 4 && ROLE + i < size; i++) {
        bytes[ROLE + i] = (i == 0) ? HELD : 0;
    }
#else
    (void)size;
#endif
}

static void read(const uint8_t bytes[], size_t least, size_t most)
{
    rigcal_saved_info info;
    rigcal_calibrated_rig rig = {
        .cameras = cameras, .group = group, .held = held, .Sigma = Sigma};
    const size_t length = Frama_C_size_t_interval(least, most);
    (void)rigcal_store_info(&info, bytes, length);
    (void)rigcal_store_load(cameras, (size_t)Frama_C_interval(0, CAPACITY), &info, bytes,
                            length);
    rig.capacity = (size_t)Frama_C_interval(0, CAPACITY);
    rig.Sigma_capacity = (size_t)Frama_C_interval(0, LOWER);
    (void)rigcal_store_load_rig(&rig, &info, bytes, length);
}

static void read_stated(size_t stated)
{
    const size_t size = (stated > HEADER) ? stated : HEADER;
    uint8_t *bytes = unknown_bytes(size);
    state(bytes, size, (uint32_t)stated);
    read(bytes, size, SIZE_MAX);
    if (stated > HEADER) {
        bytes = unknown_bytes(HEADER);
        state(bytes, HEADER, (uint32_t)stated);
        read(bytes, HEADER, stated - 1);
    }
}

#ifdef ANY_HEADER
static void read_too_short(void)
{
    /*@ loop unroll HEADER + 1; */
    for (size_t length = 0; length < HEADER; length++) {
        read(unknown_bytes(length), length, length);
    }
    /* Byte k is the last one that is not 0: Eva knows the least number by it. */
    for (int k = 0; k < 4; k++) {
        uint8_t *const bytes = unknown_bytes(HEADER);
        bytes[AT_STATED + k] =
            Frama_C_unsigned_char_interval((k == 0) ? LONGEST + 1 : 1, 255);
        for (int i = k + 1; i < 4; i++) {
            bytes[AT_STATED + i] = 0;
        }
        read(bytes, HEADER, LONGEST);
    }
}
#endif

int main(void)
{
#ifdef ANY_HEADER
    read_too_short();
#endif
    /*@ loop unroll LONGEST + 1; */
    for (size_t stated = SHORTEST; stated <= LONGEST; stated++) {
        read_stated(stated);
    }
    return 0;
}
