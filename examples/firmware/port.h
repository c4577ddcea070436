/* port.h - what the firmware wants from its board: seven small functions. A real
 * board implements them in a file of its own; sim_port.c is a simulated one. */
#ifndef PORT_H
#define PORT_H

#include <stddef.h>
#include <stdint.h>

/* ---- the cameras' corner detector ---------------------------------------- */

enum {
    PORT_CORNERS_MAX = 16,
    PORT_AT_WORK = -1 /* a placement: the board stands somewhere, and the rig works */
};

typedef struct {
    int32_t camera;
    int32_t placement; /* 0: the reference points are where they belong; 1 ..: they are on a
                          board that is held up in one place after the other; or
                          PORT_AT_WORK */
    int32_t n;         /* 0 .. PORT_CORNERS_MAX */
    int32_t id[PORT_CORNERS_MAX];  /* which reference point each is said to be */
    float uv[PORT_CORNERS_MAX][2]; /* and its pixel */
} port_frame;

/* 1: the oldest frame waiting is in *frame. 0: none is waiting. Does not block. */
int port_take_frame(port_frame *frame);

/* ---- flash: two slots, erased as a whole, programmed page by page ---------- */

enum { PORT_SLOTS = 2, PORT_SLOT_BYTES = 1024, PORT_PAGE_BYTES = 64 };

/* The slot's PORT_SLOT_BYTES, mapped into memory. */
const uint8_t *port_flash(int slot);

/* Every bit to 1. 0: the hardware says that it failed. */
int port_flash_erase(int slot);

/* Clears the bits that are 0 in page[]; `at` is a multiple of PORT_PAGE_BYTES. 0: the
 * hardware says that it failed. */
int port_flash_program(int slot, size_t at, const uint8_t page[PORT_PAGE_BYTES]);

/* ---- the rest ------------------------------------------------------------- */

/* Sends text[n] over the serial line. */
void port_send(const char text[], size_t n);

/* The next character that came in over it, or -1. Does not block. */
int port_receive(void);

/* Unless called once within the watchdog's time, the board resets. */
void port_feed_watchdog(void);

#endif /* PORT_H */
