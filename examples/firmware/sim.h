/* sim.h - a simulated board: what port.h wants, and the strings that a test pulls. */
#ifndef SIM_H
#define SIM_H

#include "firmware.h"

/* How a run of the firmware ended. */
typedef enum {
    SIM_IDLE,    /* no frame is waiting and nothing is left to do */
    SIM_BUSY,    /* the ticks allowed were too few */
    SIM_CUT,     /* the power was cut during work on the flash */
    SIM_WATCHDOG /* the watchdog was not fed in time */
} sim_end;

/* What things take, in the watchdog's units. */
enum {
    SIM_COST_BOOT = 20,
    SIM_COST_TICK = 1,
    SIM_COST_EVAL = 1, /* of the solver: one that is allowed counts as spent */
    SIM_COST_ERASE = 16,
    SIM_COST_PAGE = 4,
    SIM_WATCHDOG_UNITS = 20,
    SIM_WATCHDOG_INSTRUCTIONS = 200000, /* where they are counted */

    SIM_FRAMES_MAX = 16,
    SIM_SERIAL_BYTES = 4096,
    SIM_TYPED_BYTES = 64
};

/* What becomes of a byte, or of a slot, that was being changed when the power went. */
typedef enum {
    SIM_CUT_CLEAN,    /* bytes before it are done, it and those after untouched */
    SIM_CUT_HALF,     /* it has some of its bits changed */
    SIM_CUT_SCATTERED /* of all bytes of the page or slot some bits have changed */
} sim_cut;

typedef struct {
    uint8_t flash[PORT_SLOTS][PORT_SLOT_BYTES];
    uint8_t is_programmed[PORT_SLOTS][PORT_SLOT_BYTES / PORT_PAGE_BYTES];
    long cut_after; /* bytes of work on the flash until the power goes; -1: never */
    sim_cut cut;
    long worked; /* bytes of work done on the flash */
    int erases, pages;
    int erase_fails, program_fails; /* how many of the next ones */
    int stuck_slot, stuck_at;       /* a byte whose bits `stuck_mask` stay 1 */
    uint8_t stuck_mask;
    int misuse; /* a page programmed twice or across its border, a bit set */

    double R[FIRMWARE_CAMERAS][9], t[FIRMWARE_CAMERAS][3]; /* cam_from_rig, true */
    double turn[9], shift[3]; /* of the board: of its points, to where they are held */
    int placement;
    double noise_px;
    port_frame frames[SIM_FRAMES_MAX];
    int first, n_frames;

    char serial[SIM_SERIAL_BYTES]; /* ends with 0 */
    size_t n_serial;
    int echo;                    /* 1: to standard output too */
    char typed[SIM_TYPED_BYTES]; /* and not yet taken */

    int watchdog_units, spent;
    int most_spent;                     /* between two feeds */
    uint32_t fed_at, most_instructions; /* where there is a timer to count them */
    uint64_t random;
} sim_board;

extern sim_board sim;

/* A new board: flash erased, no frames, cameras nowhere. */
void sim_new(uint64_t seed);

/* Puts a camera at `center` [m], looking at the target's middle, turned by `roll`. */
void sim_place(int camera, const double center[3], double roll);

/* The board is held up: its points are turned about the vertical and the horizontal, then
 * shifted. Placement 0: the points are where they belong. */
void sim_hold(int placement, double about_y, double about_x, const double shift[3]);

/* The camera takes a picture, in which the corners of `mask` are detected. Returns the
 * frame, to be tampered with. */
port_frame *sim_shoot(int camera, unsigned mask);

/* A reset, and ticks until the firmware is idle. *f is filled with rubbish first, as
 * RAM is at power-up. `most` bounds the ticks. */
sim_end sim_boot(firmware *f);
sim_end sim_run(firmware *f, int most);

/* Somebody types this at the other end of the serial line. */
void sim_type(const char *text);

/* Forgets what was sent so far. */
void sim_clear_serial(void);

double sim_uniform(void);

#endif /* SIM_H */
