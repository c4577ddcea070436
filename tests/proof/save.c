/* For Frama-C's Eva: whatever the cameras, what stores them writes no byte beyond the size
 * that the header of the library states. tests/proof/run.sh runs it.
 *
 * All numbers of N_CAMERAS cameras are unknown. The first is held, if HELD is 1. The array
 * ends where the calibration does; the capacity is any up to that. */
#include "rc_store.h"
#include "rigcal_rig.h"

#include "__fc_builtin.h"

enum {
    N_FREE = N_CAMERAS - HELD,
    SIZE = RIGCAL_STORE_SIZE(N_CAMERAS),
    RIG_SIZE = RIGCAL_STORE_RIG_SIZE(N_CAMERAS, N_FREE),
    LOWER = 3 * N_FREE * (6 * N_FREE + 1)
};

static rigcal_mounted_camera cameras[N_CAMERAS];
static int32_t group[N_CAMERAS];
static uint8_t held[N_CAMERAS];
static rigcal_real Sigma[LOWER + 1];

#define UNKNOWN(object) Frama_C_make_unknown((char *)&(object), sizeof(object))

int main(void)
{
    static uint8_t bytes[SIZE], rig_bytes[RIG_SIZE];
    rigcal_calibrated_rig rig = {.cameras = cameras,
                                 .group = group,
                                 .held = held,
                                 .Sigma = Sigma + 1,
                                 .capacity = N_CAMERAS,
                                 .Sigma_capacity = LOWER,
                                 .n_cameras = N_CAMERAS};
    size_t n_bytes;
    UNKNOWN(cameras);
    UNKNOWN(group);
    UNKNOWN(Sigma);
    UNKNOWN(rig.sigma_px);
    UNKNOWN(rig.F);
    UNKNOWN(rig.freedom_between);
    UNKNOWN(rig.freedom_within);
    held[0] = HELD;
    (void)rigcal_store_save(bytes, Frama_C_size_t_interval(0, SIZE), &n_bytes, cameras,
                            N_CAMERAS, 1, 2);
    (void)rigcal_store_save_rig(rig_bytes, Frama_C_size_t_interval(0, RIG_SIZE), &n_bytes,
                                &rig, 1, 2);
    return 0;
}
