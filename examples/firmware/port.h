/* port.h - what the firmware needs from its board: seven small functions. A real board
 * implements them in a file of its own; sim_port.c simulates a board. */
#ifndef PORT_H
#define PORT_H

#include <stddef.h>
#include <stdint.h>

/* ---- the cameras' corner detector ---------------------------------------- */

enum {
    PORT_CORNERS_MAX = 16,
    PORT_AT_WORK = -1 /* placement at work: the board may be anywhere, and the rig is in
                         use */
};

typedef struct {
    int32_t camera;
    int32_t placement; /* 0: the reference points are where they belong. From 1 on: they are
                          on a board that is held up in one place after the other. Or
                          PORT_AT_WORK. */
    int32_t n;         /* 0 .. PORT_CORNERS_MAX */
    int32_t id[PORT_CORNERS_MAX];  /* for each: the number of the reference point that it is
                                      said to be */
    float uv[PORT_CORNERS_MAX][2]; /* and its pixel */
} port_frame;

/* Returns 1 if a frame was waiting: *frame is then the oldest. 0: none is waiting. Does not
 * block. */
int port_take_frame(port_frame *frame);

/* ---- flash: two slots, erased as a whole, programmed page by page ---------- */

enum { PORT_SLOTS = 2, PORT_SLOT_BYTES = 1024, PORT_PAGE_BYTES = 64 };

/* The slot's PORT_SLOT_BYTES, mapped into memory. */
const uint8_t *port_flash(int slot);

/* Sets every bit to 1. Returns 0 if the hardware reports a failure. */
int port_flash_erase(int slot);

/* Clears the bits that are 0 in page[]. `at` is a multiple of PORT_PAGE_BYTES. Returns 0 if
 * the hardware reports a failure. */
int port_flash_program(int slot, size_t at, const uint8_t page[PORT_PAGE_BYTES]);

/* ---- the rest ------------------------------------------------------------- */

/* Sends text[n] over the serial line. */
void port_send(const char text[], size_t n);

/* The next character received from the serial line, or -1. Does not block. */
int port_receive(void);

/* The board resets if this is not called within the watchdog's time. */
void port_feed_watchdog(void);

#endif /* PORT_H */
