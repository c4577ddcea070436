/* sim.h - a simulated board: the functions of port.h, and the controls for a test. */
#ifndef SIM_H
#define SIM_H

#include "firmware.h"

/* How a run of the firmware ended. */
typedef enum {
    SIM_IDLE,    /* no frame is waiting, and nothing is left to do */
    SIM_BUSY,    /* the allowed ticks were used up */
    SIM_CUT,     /* the power was cut during work on the flash */
    SIM_WATCHDOG /* the watchdog was not fed in time */
} sim_end;

/* The cost of each action, in the watchdog's units. */
enum {
    SIM_COST_BOOT = 20,
    SIM_COST_TICK = 1,
    SIM_COST_EVAL = 1, /* an evaluation of the solver: each one that is allowed counts as
                          spent */
    SIM_COST_ERASE = 16,
    SIM_COST_PAGE = 4,
    SIM_WATCHDOG_UNITS = 20,
    SIM_WATCHDOG_INSTRUCTIONS = 200000, /* limit, if instructions are counted */

    SIM_FRAMES_MAX = 16,
    SIM_SERIAL_BYTES = 4096,
    SIM_TYPED_BYTES = 64
};

/* What happens to the byte or slot that was being changed when the power was cut. */
typedef enum {
    SIM_CUT_CLEAN,    /* bytes before it are changed; it and those after it are not */
    SIM_CUT_HALF,     /* some of its bits are changed */
    SIM_CUT_SCATTERED /* in all bytes of the page or slot some bits are changed */
} sim_cut;

typedef struct {
    uint8_t flash[PORT_SLOTS][PORT_SLOT_BYTES];
    uint8_t is_programmed[PORT_SLOTS][PORT_SLOT_BYTES / PORT_PAGE_BYTES];
    long cut_after; /* bytes of flash work until the power is cut; -1: never */
    sim_cut cut;
    long worked; /* bytes of work done on the flash */
    int erases, pages;
    int erase_fails, program_fails; /* how many of the next calls fail */
    int stuck_slot, stuck_at;       /* a byte of which the bits `stuck_mask` stay 1 */
    uint8_t stuck_mask;
    int misuse; /* counts pages programmed twice or across a border, and bits set */

    double R[FIRMWARE_CAMERAS][9], t[FIRMWARE_CAMERAS][3]; /* true poses cam_from_rig */
    double turn[9], shift[3]; /* takes the points of the board to where they are held */
    int placement;
    double noise_px;
    port_frame frames[SIM_FRAMES_MAX];
    int first, n_frames;

    char serial[SIM_SERIAL_BYTES]; /* ends with 0 */
    size_t n_serial;
    int echo;                    /* 1: what is sent also goes to standard output */
    char typed[SIM_TYPED_BYTES]; /* characters that were typed and not read yet */

    int watchdog_units, spent;
    int most_spent;                     /* most units spent between two feedings */
    uint32_t fed_at, most_instructions; /* only with a timer that counts instructions */
    uint64_t random;
} sim_board;

extern sim_board sim;

/* A new board: flash erased, no frames, no poses of cameras. */
void sim_new(uint64_t seed);

/* Puts a camera at `center` [m], looking at the target's middle, turned by `roll`. */
void sim_place(int camera, const double center[3], double roll);

/* Holds the board up: its points are turned about the vertical and the horizontal, then
 * shifted. Placement 0: the points are where they belong. */
void sim_hold(int placement, double about_y, double about_x, const double shift[3]);

/* The camera takes a picture in which the corners of `mask` are detected. Returns the
 * frame, so that a test can change it. */
port_frame *sim_shoot(int camera, unsigned mask);

/* Resets the board, and runs ticks until the firmware is idle, at most `most`. *f is filled
 * with random bytes first, as RAM has them at power-up. */
sim_end sim_boot(firmware *f);
sim_end sim_run(firmware *f, int most);

/* Somebody types this at the other end of the serial line. */
void sim_type(const char *text);

/* Forgets what was sent so far. */
void sim_clear_serial(void);

double sim_uniform(void);

#endif /* SIM_H */
