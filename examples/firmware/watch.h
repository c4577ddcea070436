/* watch.h - the rig at work: whether it has moved, and where it is now. */
#ifndef WATCH_H
#define WATCH_H

#include "firmware.h"

/* No rig, and no monitor. w->rig gets its arrays, which the caller fills. */
void watch_clear(firmware_watch *w);

/* Takes what a camera saw of the board at work. The last camera ends a frame. Returns 1 if
 * w->rig is the rig as it is now, 0 if there is none or it is in doubt. */
int watch_view(firmware_watch *w, int32_t camera, const rigcal_view *view);

/* Sends the state of the rig. */
void watch_answer(const firmware_watch *w);

#endif /* WATCH_H */
