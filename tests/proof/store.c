/* For Frama-C's Eva: whatever the bytes, the reader of stored calibrations accesses nothing
 * out of bounds. tests/proof/run.sh runs it.
 *
 * Lengths from SHORTEST to LONGEST are tried one by one, each with an array that ends where
 * the bytes do. All bytes are unknown, but three fields of the header, REAL_BYTES, VERSION
 * and N_CAMERAS, and in version 2 whether the first camera is held, HELD. With ANY_HEADER,
 * none is known. */
#include "rc_store.h"
#include "rigcal_rig.h"

#include "__fc_builtin.h"

enum { CAPACITY = 2, LOWER = 3 * CAPACITY * (6 * CAPACITY + 1) };

/* The place of the first camera's role in version 2. */
#define ROLE (32 + 4 * REAL_BYTES + 12)

static uint8_t memory[LONGEST];
static rigcal_mounted_camera cameras[CAPACITY];
static int32_t group[CAPACITY];
static uint8_t held[CAPACITY];
static rigcal_real Sigma[LOWER];

static void read(uint8_t bytes[], size_t length)
{
    rigcal_saved_info info;
    rigcal_calibrated_rig rig = {
        .cameras = cameras, .group = group, .held = held, .Sigma = Sigma};
    Frama_C_make_unknown((char *)bytes, length);
#ifndef ANY_HEADER
    const uint8_t known[8] = {VERSION, 0, REAL_BYTES, 0, N_CAMERAS, 0, 0, 0};
    for (size_t i = 0; i < sizeof known && 4 + i < length; i++) {
        bytes[4 + i] = known[i];
    }
    for (size_t i = 0; VERSION == 2 && i < 4 && ROLE + i < length; i++) {
        bytes[ROLE + i] = (i == 0) ? HELD : 0;
    }
#endif
    (void)rigcal_store_info(&info, bytes, length);
    (void)rigcal_store_load(cameras, (size_t)Frama_C_interval(0, CAPACITY), &info, bytes,
                            length);
    rig.capacity = (size_t)Frama_C_interval(0, CAPACITY);
    rig.Sigma_capacity = (size_t)Frama_C_interval(0, LOWER);
    (void)rigcal_store_load_rig(&rig, &info, bytes, length);
}

int main(void)
{
    /*@ loop unroll LONGEST + 1; */
    for (size_t length = SHORTEST; length <= LONGEST; length++) {
        read(memory + LONGEST - length, length);
    }
    return 0;
}
