/* rc_measure.h - measuring with known poses; see rigcal.h. Nothing below this
 * layer calls into it. */
#ifndef RC_MEASURE_H
#define RC_MEASURE_H

#include "rc_camera.h"

#endif /* RC_MEASURE_H */
