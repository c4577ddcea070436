/* flash.c - a calibration kept in flash: saved, loaded, and refused when it is damaged.
 * The truth: it has the number 7. The camera is at (0.5, 0.2, 0.1) m in the frame of the
 * rig, and turned by 90 degrees about its optical axis. */
#include <stdio.h>
#include <rigcal.h>

static uint8_t page[1024]; /* stands for a page of flash */

static void load(const char *when)
{
    rigcal_mounted_camera cam;
    rigcal_saved_info info;
    rigcal_real o[3];
    rigcal_status status = rigcal_store_load(&cam, 1, &info, page, sizeof page);
    printf("%s: %s\n", when, rigcal_status_text(status));
    if (status == RIGCAL_OK && rigcal_camera_center(o, &cam.cam_from_rig) == RIGCAL_OK) {
        printf("  calibration %u: the camera is at (%.1f, %.1f, %.1f) m\n",
               (unsigned)info.sequence, o[0], o[1], o[2]);
    }
}

int main(void)
{
    const rigcal_mounted_camera cam = {
        .camera = {.lens = RIGCAL_LENS_BROWN,
                   .width = 640,
                   .height = 480,
                   .fx = 800,
                   .fy = 800,
                   .cx = 320,
                   .cy = 240},
        .cam_from_rig = {{0, 1, 0, -1, 0, 0, 0, 0, 1}, {-0.2, 0.5, -0.1}}};
    size_t n_bytes;

    load("empty");
    rigcal_status status = rigcal_store_save(page, sizeof page, &n_bytes, &cam, 1, 7, 0);
    if (status != RIGCAL_OK) {
        printf("%s\n", rigcal_status_text(status));
        return 1;
    }
    load("saved");
    page[100] ^= 1;
    load("one bit altered");
    return 0;
}
