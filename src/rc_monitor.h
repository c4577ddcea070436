/* rc_monitor.h - what the memory of a monitor holds; see rigcal_monitor.h. */
#ifndef RC_MONITOR_H
#define RC_MONITOR_H

#include "rc_calibrated.h"
#include "rc_trial.h"

/* The head: the first part of the memory. */
typedef struct {
    uint32_t seal[2];   /* of all that follows except head_seal; 0, 0 within a frame */
    uint32_t head_seal; /* of all that follows from `magic` on */
    uint32_t rows, doubted;
    rc_alarm alarm;
    uint32_t magic;
    uint32_t n_cameras, n_targets, frame;
    uint32_t placed;   /* bit k: target k has a place */
    uint32_t is_alarm; /* 1: an alarm was raised and is not yet answered */
    uint32_t settling; /* frames for which the pose of `settles` takes in every row */
    uint32_t settles;  /* the body that settles */
    uint32_t frames, since;
    rigcal_real wrong, walk_rad, walk_t, move_rad, move_t, evidence;
    rigcal_real numbers[4]; /* of the calibrated rig: sigma_px, F, degrees of freedom */
} rc_monitor_head;

/* The head lies in an array of reals. C99 6.5 forbids reading integers there, so the head
 * is copied out and in. It is copied as structs of reals, which compilers do by few
 * instructions. A row changes the first part only. */
typedef struct {
    rigcal_real reals[16];
} rc_monitor_part;

enum { RC_MONITOR_PARTS = RIGCAL_MONITOR_HEAD / 16 };

typedef union {
    rc_monitor_head head;
    rc_monitor_part parts[RC_MONITOR_PARTS];
} rc_monitor_copy;

typedef struct {
    rigcal_real reals[RIGCAL_MONITOR_LENS];
} rc_monitor_lens_part;

typedef union {
    rigcal_camera camera;
    rc_monitor_lens_part part;
} rc_monitor_lens_copy;

/* An open monitor. */
typedef struct {
    rc_monitor_copy top; /* a copy of the head; who changes it must call rc_monitor_close */
    rc_filter filter;
    rigcal_real *bodies; /* state of the alarm */
    rigcal_real *lenses; /* RIGCAL_MONITOR_LENS of each camera: the bytes of its
                            intrinsics */
    rigcal_real *memory;
    size_t size;
} rc_monitor;

/* Opens a monitor. OK, ERR_NULL, ERR_STATE (it was not begun, or its memory was altered).
 * This only reads; who writes must call rc_monitor_close. */
rigcal_status rc_monitor_open(rc_monitor *m, const rigcal_real memory[]);

/* Sets the pointers of m into the memory. m->top must hold a valid head. Poses are used in
 * place, because they consist of reals only. */
void rc_monitor_lay_out(rc_monitor *m, rigcal_real memory[]);

/* Seals the head and writes it back. If is_frame_over it seals all of the memory. */
void rc_monitor_close(rc_monitor *m, int is_frame_over);

/* Closes the monitor sealed as it was when it was opened. */
void rc_monitor_close_again(rc_monitor *m);

/* Copies a camera's intrinsics. */
const rigcal_camera *rc_monitor_lens(rc_monitor_lens_copy *lens, const rc_monitor *m,
                                     size_t index);

/* Checks sigma_px: OK, ERR_NOT_FINITE, ERR_RANGE. */
rigcal_status rc_monitor_check_noise(rigcal_real sigma_px);

/* Hands what was seen to the filter or, during an alarm, to the trials. OK; ERR_DEGENERATE
 * and the statuses of rc_rows_of, after which a match has changed nothing. */
rigcal_status rc_monitor_take(rc_monitor *m, const rc_seen *seen);

#endif /* RC_MONITOR_H */
