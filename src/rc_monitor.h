/* rc_monitor.h - what a monitor's memory holds; see rigcal_monitor.h. */
#ifndef RC_MONITOR_H
#define RC_MONITOR_H

#include "rc_calibrated.h"
#include "rc_trial.h"

/* The first numbers of the memory. */
typedef struct {
    uint32_t seal[2];   /* of all that follows but head_seal; 0, 0 within a frame */
    uint32_t head_seal; /* of what follows from `magic` on */
    uint32_t rows, doubted;
    rc_alarm alarm;
    uint32_t magic;
    uint32_t n_cameras, n_targets, frame;
    uint32_t placed;   /* bit k: target k has a place */
    uint32_t is_alarm; /* 1: raised, and not yet answered */
    uint32_t settling; /* frames for which a body's pose takes in every row */
    uint32_t settles;  /* that body */
    uint32_t frames, since;
    rigcal_real wrong, walk_rad, walk_t, move_rad, move_t, evidence;
    rigcal_real numbers[4]; /* of the calibrated rig: sigma_px, F, degrees of freedom */
} rc_monitor_head;

/* It lies in an array of reals, where C99 6.5 lets no integer be read: it is copied out and
 * in, as structs of reals, which compilers copy by a few instructions. A row changes the
 * first part alone. */
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

/* A monitor that was opened. */
typedef struct {
    rc_monitor_copy top; /* copied out; who changes it calls rc_monitor_close */
    rc_filter filter;
    rigcal_real *bodies; /* of the alarm */
    rigcal_real *lenses; /* RIGCAL_MONITOR_LENS of each camera: the bytes of them */
    rigcal_real *memory;
    size_t size;
} rc_monitor;

/* OK, ERR_NULL, ERR_STATE: it was not begun, or was altered. It only reads; who writes
 * calls rc_monitor_close. */
rigcal_status rc_monitor_open(rc_monitor *m, const rigcal_real memory[]);

/* Where everything is, of a head that is right: m->top is there. A pose is read in its
 * place: reals and nothing else are in it. */
void rc_monitor_lay_out(rc_monitor *m, rigcal_real memory[]);

/* The head is sealed and put back; is_frame_over: all is sealed. */
void rc_monitor_close(rc_monitor *m, int is_frame_over);

/* The same as it was opened. */
void rc_monitor_close_again(rc_monitor *m);

/* A camera's intrinsics, copied. */
const rigcal_camera *rc_monitor_lens(rc_monitor_lens_copy *lens, const rc_monitor *m,
                                     size_t index);

/* OK; ERR_NULL, ERR_NOT_FINITE, ERR_RANGE of sigma_px. */
rigcal_status rc_monitor_check_noise(rigcal_real sigma_px);

/* Takes what was seen into the filter, or into the trials. OK; ERR_DEGENERATE and what
 * rc_rows_of returns, having changed nothing. */
rigcal_status rc_monitor_take(rc_monitor *m, const rc_seen *seen);

#endif /* RC_MONITOR_H */
