/* rc_store.h - calibrations as bytes; see rigcal.h. No other layer includes it. */
#ifndef RC_STORE_H
#define RC_STORE_H

#include "rc_bytes.h"
#include "rc_calibrated.h"
#include "rc_camera.h"

#endif /* RC_STORE_H */
