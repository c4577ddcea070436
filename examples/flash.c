/* flash.c - a calibration kept in flash: saved, loaded, refused when it is damaged.
 *
 * Given: one camera with its pose, and bytes that stand for a page of flash.
 * Asked: the same camera after a restart, and a refusal of bytes that are not whole.
 * Truth: it is calibration number 7. The camera is at (0.5, 0.2, 0.1) m in the frame of the
 *        rig: cam_from_rig turns by 90 degrees, and t = -R (0.5, 0.2, 0.1). */
#include <stdio.h>
#include <rigcal.h>

static uint8_t page[1024];

static void load(const char *when)
{
    rigcal_mounted_camera cam;
    rigcal_saved_info info;
    rigcal_real o[3];

    rigcal_status status = rigcal_store_load(&cam, 1, &info, page, sizeof page);
    printf("%s: %s\n", when, rigcal_status_text(status));
    if (status == RIGCAL_OK && rigcal_camera_center(o, &cam.cam_from_rig) == RIGCAL_OK) {
        printf("number %u, camera at (%.1f, %.1f, %.1f) m\n", (unsigned)info.sequence, o[0],
               o[1], o[2]);
    }
}

int main(void)
{
    rigcal_mounted_camera cam = {
        .camera = {.width = 640, .height = 480, .fx = 800, .fy = 800, .cx = 320, .cy = 240},
        .cam_from_rig = {{0, 1, 0, -1, 0, 0, 0, 0, 1}, {-0.2, 0.5, -0.1}}};
    size_t n_bytes; /* how many of the page are written */

    load("empty page");
    rigcal_status status = rigcal_store_save(page, sizeof page, &n_bytes, &cam, 1, 7, 0);
    printf("save: %s\n", rigcal_status_text(status));
    load("saved page");
    page[100] ^= 1; /* one bit */
    load("damaged page");
    return status == RIGCAL_OK ? 0 : 1;
}
