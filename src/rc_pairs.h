/* rc_pairs.h - pairs of bearings. Each pair gives one equation (11)..(13). */
#ifndef RC_PAIRS_H
#define RC_PAIRS_H

#include "rc_bearings.h"

/* Checks pairs: OK, ERR_NULL, ERR_NOT_FINITE, ERR_RANGE or ERR_TOO_FEW. */
rigcal_status rc_check_pairs(const rigcal_pair pairs[], size_t n_pairs, size_t n_least);

#endif /* RC_PAIRS_H */
