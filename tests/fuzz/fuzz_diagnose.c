/* The search for a wrong point and for what is wrong with a view, with any view and
 * options. */
#include <math.h>
#include <string.h>

#include "fuzz.h"

enum { POINTS_MOST = 12 };

static void check_blame(const rigcal_blame *blame, const rigcal_real rms_without[],
                        const rigcal_view *view)
{
    size_t i;

    PROMISE(blame->verdict >= RIGCAL_BLAME_NONE && blame->verdict <= RIGCAL_BLAME_SURE);
    PROMISE(blame->point >= -1 && blame->point < (int32_t)view->n);
    PROMISE(blame->chance >= 0 && blame->chance <= 1);
    PROMISE(blame->probability >= 0 && blame->probability <= 1);
    PROMISE(blame->rms_px >= 0 || (blame->rms_px <= -1 && blame->rms_px >= -1));
    PROMISE(fuzz_all_finite(&blame->rms_px, 1));
    for (i = 0; i < view->n; i++) {
        PROMISE(fuzz_all_finite(&rms_without[i], 1) && rms_without[i] >= -1);
    }
    PROMISE(blame->point < 0 || rms_without[blame->point] >= 0);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_bytes bytes = {data, data + size};
    const int is_diagnosis = fuzz_below(&bytes, 2);
    rigcal_observation observations[POINTS_MOST];
    rigcal_real sigma[POINTS_MOST], rms_without[POINTS_MOST];
    rigcal_diagnosis diagnosis;
    rigcal_pose_options options;
    rigcal_camera camera;
    rigcal_view view;
    rigcal_status status;
    rigcal_blame blame;

    PROMISE(rigcal_pose_defaults(&options) == RIGCAL_OK);
    switch (fuzz_below(&bytes, 3)) {
    case 1:
        options.sigma_px = fuzz_real(&bytes);
        break;
    case 2:
        options.use_start = 1;
        fuzz_transform(&options.start, &bytes);
        break;
    default:
        break;
    }
    fuzz_view(&view, &camera, observations, sigma, POINTS_MOST, &bytes);
    MARK(rms_without);
    MARK(blame);
    MARK(diagnosis);
    if (is_diagnosis) {
        status = rigcal_pose_diagnose(&diagnosis, rms_without, &view, &options);
        PROMISE_UNTOUCHED(status, diagnosis);
        if (status >= 0) {
            PROMISE(diagnosis.verdict >= RIGCAL_DIAGNOSIS_CONSISTENT &&
                    diagnosis.verdict <= RIGCAL_DIAGNOSIS_UNEXPLAINED);
            PROMISE(diagnosis.is_handed == 0 || diagnosis.is_handed == 1);
            PROMISE(diagnosis.rms_mirrored_px >= -1 && diagnosis.rms_flipped_px >= -1);
            PROMISE(fuzz_all_finite(&diagnosis.units, 1) && diagnosis.units >= 0);
            check_blame(&diagnosis.blame, rms_without, &view);
        }
    } else {
        status = rigcal_pose_blame(&blame, rms_without, &view, &options);
        PROMISE_UNTOUCHED(status, blame);
        if (status >= 0) {
            check_blame(&blame, rms_without, &view);
        }
    }
    PROMISE(fuzz_is_status(status) && status != RIGCAL_RUNNING);
    PROMISE_UNTOUCHED(status, rms_without);
    return 0;
}
