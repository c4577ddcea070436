/* rc_translation.h - the translation for a known rotation (16). */
#ifndef RC_TRANSLATION_H
#define RC_TRANSLATION_H

#include "rc_pairs.h"

/* rigcal_translation_least_squares without checks. OK or ERR_DEGENERATE. */
rigcal_status rc_translation_least_squares(rigcal_real t[3], const rigcal_real R[9],
                                           const rigcal_bearing bearings[], size_t n);

#endif /* RC_TRANSLATION_H */
