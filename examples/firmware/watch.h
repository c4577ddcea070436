/* watch.h - the rig at work: has it moved, and where is it now. */
#ifndef WATCH_H
#define WATCH_H

#include "firmware.h"

/* No rig, and nothing watched; w->rig has its arrays, to be filled. */
void watch_clear(firmware_watch *w);

/* What a camera saw of the board at work. The last camera ends a frame. 1: w->rig is the
 * rig as it is now. 0: there is none, or it is in doubt. */
int watch_view(firmware_watch *w, int32_t camera, const rigcal_view *view);

/* Sends how the rig is. */
void watch_answer(const firmware_watch *w);

#endif /* WATCH_H */
