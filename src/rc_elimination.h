/* rc_elimination.h - finds one Euler angle by linear algebra if the other two are given
 * (14), (15). */
#ifndef RC_ELIMINATION_H
#define RC_ELIMINATION_H

#include "rc_pairs.h"

/* rigcal_pairs_eliminate and rigcal_pairs_residual without checks. rc_eliminate returns OK
 * or ERR_DEGENERATE. */
rigcal_status rc_eliminate(rigcal_elimination *out, const rigcal_pair pairs[],
                           size_t n_pairs, int32_t pairs_used, int32_t eliminated,
                           const rigcal_real angles[2]);
rigcal_real rc_pairs_residual(const rigcal_pair pairs[], size_t n_pairs,
                              const rigcal_real ypr[3]);

/* Makes (yaw, pitch, roll) of the two searched angles and the eliminated one, w; and back.
 * With RC_NONE_ELIMINATED `angles` has all three. */
enum { RC_NONE_ELIMINATED = 3 };
void rc_angles_join(rigcal_real ypr[3], int32_t eliminated, const rigcal_real angles[],
                    rigcal_real w);
void rc_angles_split(rigcal_real angles[2], int32_t eliminated, const rigcal_real ypr[3]);

#endif /* RC_ELIMINATION_H */
