/* rc_chance.h - what chance explains: sums of squared errors, sets of points that agree
 * (EQUATIONS.md C, E). */
#ifndef RC_CHANCE_H
#define RC_CHANCE_H

#include "rc_real.h"

/* Degrees of freedom of the fit of a pose to n points. Three points have none and fit
 * nearly exactly: 1. */
rigcal_real rc_freedom(size_t n);

/* The limit of chi squared with `freedom` degrees of freedom. It is exceeded as seldom as a
 * normal variable exceeds `deviations` standard deviations (Wilson and Hilferty 1931). */
rigcal_real rc_chi2_limit(rigcal_real freedom, rigcal_real deviations);

/* (C) Likelihood of a sum of squared errors over that of another, for n >= 3 points.
 * sigma_px 0: the noise is unknown and integrated out. pixel_size is that of rc_pixel_size.
 * Underflows to 0, overflows to infinity. */
rigcal_real rc_odds(rigcal_real sse, rigcal_real other, rigcal_real sigma_px,
                    rigcal_real pixel_size, size_t n);

/* (E) Expected number of sets of `count` of n wrong points that agree with a pose of three
 * of them. `near` is the chance that one wrong point agrees. At most 1e30. */
rigcal_real rc_expected_sets(size_t n, size_t count, rigcal_real near);

/* The number k of standard deviations within which a normal variable lies with
 * `probability`, 0 < probability < 1. k^2 is the limit of chi squared with 1 degree of
 * freedom. Exact to a few units in the last place of 1 - probability. */
rigcal_real rc_normal_within(rigcal_real probability);

/* The same for the length of a vector of two normal variables: k^2 is the limit of chi
 * squared with 2 degrees of freedom. */
rigcal_real rc_plane_within(rigcal_real probability);

/* The chance that F of (k, n) degrees of freedom exceeds this F. At least 2e-35. */
rigcal_real rc_f_tail(rigcal_real F, rigcal_real k, rigcal_real n);

#endif /* RC_CHANCE_H */
