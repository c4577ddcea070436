/* firmware.h - two cameras that calibrate themselves against reference points of the
 * machine they are mounted on, and remember it. README.md explains how. */
#ifndef FIRMWARE_H
#define FIRMWARE_H

#include "port.h"
#include "rigcal.h"

enum {
    FIRMWARE_CAMERAS = 2,
    FIRMWARE_POINTS = 8,
    FIRMWARE_PLACEMENTS = 4, /* placements of the board for a rig */
    FIRMWARE_VIEWS = FIRMWARE_CAMERAS * FIRMWARE_PLACEMENTS,
    FIRMWARE_EVALS_PER_TICK = 4, /* evaluations of the solver between two feedings of the
                                    watchdog */
    FIRMWARE_UNITS_PER_TICK = 4, /* units of the rig's adjustment between two feedings */
    FIRMWARE_SAVE_TRIES = 3      /* tries to save to a flash that fails, until the next
                                    reset */
};

/* The reference points [m], the cameras' intrinsics, and the serial number of the machine.
 * A calibration with another serial number is not used. */
extern const rigcal_real FIRMWARE_TARGET[FIRMWARE_POINTS][3];
extern const rigcal_camera FIRMWARE_INTRINSICS[FIRMWARE_CAMERAS];
#define FIRMWARE_SIGMA_PX 0.2 /* noise of a corner */
#define FIRMWARE_SERIAL UINT32_C(0x52494721)

/* What was seen of the board, and the rig that it gives. Camera 0 is held. */
typedef struct {
    rigcal_observation seen[FIRMWARE_VIEWS][FIRMWARE_POINTS];
    rigcal_rig_view views[FIRMWARE_VIEWS]; /* views of placement f are at 2 f and 2 f + 1; n
                                              = 0: none */
    rigcal_view_pose poses[FIRMWARE_VIEWS];
    rigcal_transform cams_from_rig[FIRMWARE_CAMERAS];
    rigcal_transform rig_from_placements[FIRMWARE_PLACEMENTS];
    int32_t group[FIRMWARE_CAMERAS];
    rigcal_real
        work[RIGCAL_RIG_WORK(FIRMWARE_CAMERAS - 1, FIRMWARE_CAMERAS, FIRMWARE_PLACEMENTS)];
    rigcal_rig rig;
    rigcal_rig_solver solver;
    int32_t n_views, ticks;
} firmware_rig;

/* The rig in flash, and the monitor that watches it at work. The board that the cameras see
 * then is body FIRMWARE_CAMERAS. */
typedef struct {
    rigcal_mounted_camera cameras[FIRMWARE_CAMERAS];
    int32_t group[FIRMWARE_CAMERAS];
    uint8_t held[FIRMWARE_CAMERAS];
    rigcal_real Sigma[RIGCAL_CALIBRATED_SIZE(FIRMWARE_CAMERAS - 1)];
    rigcal_calibrated_rig rig; /* sigma_px = 0: there is none */
    rigcal_real monitor[RIGCAL_MONITOR_SIZE(FIRMWARE_CAMERAS, 1)];
    int32_t is_on;   /* whether the monitor was begun */
    int32_t mending; /* number of frames until the body that was bumped has its new pose */
} firmware_watch;

/* All of the firmware's memory. */
typedef struct {
    rigcal_mounted_camera cameras[FIRMWARE_CAMERAS]; /* the latest pose of each */
    rigcal_transform stored[FIRMWARE_CAMERAS];       /* cam_from_rig as in flash */
    int32_t is_known[FIRMWARE_CAMERAS];              /* whether camera i has a pose */
    int32_t is_fresh[FIRMWARE_CAMERAS];              /* whether the pose was found since the
                                                        last saving began */
    int32_t slot;      /* of the calibration in flash; -1: there is none */
    uint32_t sequence; /* its number */
    int32_t tries_left;

    int32_t state;                    /* 0: waits for a frame */
    int32_t camera, placement, ticks; /* of the frame in work */
    uint32_t frame;
    rigcal_observation seen[FIRMWARE_POINTS];
    rigcal_view view; /* of that frame: its camera, and which points of seen[] it saw */
    rigcal_pose_solver solver;
    firmware_rig rig;
    firmware_watch watch;
    size_t n_heard; /* number of characters of the question that came so far */

    uint8_t image[PORT_SLOT_BYTES]; /* the bytes that are being written to flash */
    size_t image_bytes, written;
} firmware;

/* After a reset: reads the flash and reports what was found. *f may hold anything. */
void firmware_boot(firmware *f);

/* One round of the superloop: a bounded piece of work, then the watchdog is fed. */
void firmware_tick(firmware *f);

#endif /* FIRMWARE_H */
