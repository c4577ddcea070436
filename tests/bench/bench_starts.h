/* bench_starts.h - starts all over the rotations, for the fits that find the minima of
 * a scene: what the library's search might have missed. They share nothing with it. */
#ifndef BENCH_STARTS_H
#define BENCH_STARTS_H

#include "bench_scenes.h"
#include "test_fit.h"

/* The rotations of a cube, turned at random: any rotation is within 63 degrees of one. */
enum { BENCH_STARTS_MAX = 24 };

/* The different places where fits from all these rotations end. Such a fit minimises the
 * distances between unit rays, which have no pole where a point is 90 degrees off the
 * axis, and tell a point behind the camera from one in front. */
int bench_starts(test_fitted starts[BENCH_STARTS_MAX], const bench_scene *s);

#endif /* BENCH_STARTS_H */
