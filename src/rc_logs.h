/* rc_logs.h - exp and log with the same bits on every target. Those of libm would add 0.4
 * KB each. */
#ifndef RC_LOGS_H
#define RC_LOGS_H

#include "rc_real.h"

/* exp(x), to 1e-9 (float: 5e-5). x is clipped to +-80. */
rigcal_real rc_exp(rigcal_real x);

/* log(x) for x > 0 and finite, to a few roundings. */
rigcal_real rc_log(rigcal_real x);

/* log(1 + x) for x > -1, to a few units in the last place. */
rigcal_real rc_log1p(rigcal_real x);

#endif /* RC_LOGS_H */
