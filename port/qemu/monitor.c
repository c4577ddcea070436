/* monitor.c - what a monitor costs, frame by frame: count.c counts instructions between the
 * marks, two intervals a frame, its matches and its end. The rig is still, then a camera is
 * turned, and the alarm is answered.
 *
 * -DCAMERAS=n, -DFRAMES=n; prints "frame ALARM" for each frame, then the stack. */
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "marks.h"

#ifndef CAMERAS
#define CAMERAS 4
#endif
#ifndef FRAMES
#define FRAMES 300
#endif

#ifndef WALK
#define WALK 0
#endif

enum { MATCHES = 20, TURNED_AT = FRAMES - 60, ANSWER_AFTER = 15 };

/* From the linker script: the stack's top, and its size as an address. */
extern unsigned char __stack[], __stack_size[];

static rigcal_real monitor[RIGCAL_MONITOR_SIZE(CAMERAS, 0)];
static rigcal_mounted_camera cameras[CAMERAS];
static int32_t group[CAMERAS];
static uint8_t held[CAMERAS];
static rigcal_real Sigma[RIGCAL_CALIBRATED_SIZE(CAMERAS - 1)];

/* A sum of four numbers: nearly normal, with standard deviation 1. */
static rigcal_real noise(void)
{
    rigcal_real sum = 0;
    for (int k = 0; k < 4; k++) {
        sum += uniform(-1, 1);
    }
    return sum * (rigcal_real)0.866;
}

static void begin(void)
{
    rigcal_calibrated_rig rig = {cameras, group,
                                 held,    CAMERAS,
                                 Sigma,   sizeof Sigma / sizeof Sigma[0],
                                 CAMERAS, (rigcal_real)0.3,
                                 0,       0,
                                 0};
    rigcal_monitor_options o;
    for (int c = 0; c < CAMERAS; c++) {
        const rigcal_real ypr[3] = {0, (rigcal_real)(-0.2 * c), 0};
        rigcal_mounted_camera *const m = &cameras[c];
        m->camera.width = m->camera.height = 800;
        m->camera.fx = m->camera.fy = 800;
        m->camera.cx = m->camera.cy = 400;
        (void)rigcal_rotation_from_yaw_pitch_roll(m->cam_from_rig.R, ypr);
        m->cam_from_rig.t[0] = (rigcal_real)(-0.5 * c);
        m->cam_from_rig.t[1] = (rigcal_real)(0.1 * (c % 2));
        held[c] = c == 0;
    }
    for (int i = 0; i < 6 * (CAMERAS - 1); i++) {
        Sigma[i * (i + 3) / 2] = (rigcal_real)(i % 6 < 3 ? 1e-6 : 4e-6);
    }
    (void)rigcal_monitor_defaults(&o);
    o.arl0_frames = 10000;
    o.walk_rad = WALK; /* with one camera more, the end of a frame has this walk too */
    o.walk_t = WALK;
    if (rigcal_monitor_begin(monitor, sizeof monitor / sizeof monitor[0], &rig, 0, &o) !=
        0) {
        printf("begin failed\n");
    }
}

/* The ray of a point in a camera. The last camera is turned by 0.01 rad. */
static void see(rigcal_real ray[3], int c, const rigcal_real X[3], int is_turned)
{
    rigcal_real p[3];
    (void)rigcal_transform_point(p, &cameras[c].cam_from_rig, X);
    ray[0] = p[0] / p[2] + (rigcal_real)3.75e-4 * noise();
    ray[1] = p[1] / p[2] + (rigcal_real)3.75e-4 * noise();
    ray[1] += (is_turned && c == CAMERAS - 1) ? (rigcal_real)0.01 : 0;
    ray[2] = 1;
}

static void frame(int f, rigcal_monitor_report *report)
{
    static rigcal_real rays[MATCHES][2][3];
    static uint8_t of[MATCHES][2];
    for (int i = 0; i < MATCHES; i++) {
        const rigcal_real X[3] = {uniform(-1, 1), uniform(-1, 1), uniform(3, 5)};
        of[i][0] = (uint8_t)uniform(0, CAMERAS);
        of[i][1] = (uint8_t)((of[i][0] + 1 + (int)uniform(0, CAMERAS - 1)) % CAMERAS);
        see(rays[i][0], of[i][0], X, f >= TURNED_AT);
        see(rays[i][1], of[i][1], X, f >= TURNED_AT);
    }
    jobs_begin();
    for (int i = 0; i < MATCHES; i++) {
        (void)rigcal_monitor_match_rays(monitor, of[i][0], rays[i][0], of[i][1], rays[i][1],
                                        (rigcal_real)0.3);
    }
    jobs_end();
    jobs_begin();
    const rigcal_status status =
        rigcal_monitor_frame(report, monitor, (rigcal_real)(1.0 / 30));
    jobs_end();
    printf("frame %d %d\n", (int)report->alarm, (int)status);
}

int main(void)
{
    unsigned char *const bottom = __stack - (size_t)__stack_size;
    unsigned char *const here = __builtin_frame_address(0), *at = bottom;
    rigcal_monitor_report report = {0};
    for (; at < here - 256; at++) {
        *(volatile unsigned char *)at = 0xA5;
    }
    begin();
    for (int f = 0; f < FRAMES; f++) {
        frame(f, &report);
        if (report.frames_since == ANSWER_AFTER) {
            printf("blamed %d %d\n", (int)report.body, (int)(100 * report.confidence));
            (void)rigcal_monitor_moved(monitor, (size_t)report.body);
        }
    }
    for (at = bottom; *at == 0xA5; at++) {
    }
    printf("stack %d monitor %d\n", (int)(__stack - at), (int)sizeof monitor);
    return 0;
}
