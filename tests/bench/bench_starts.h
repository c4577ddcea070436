/* bench_starts.h - starts over all rotations, for the fits that find the minima of a scene.
 * The library's search might have missed some. These fits share no code with it. */
#ifndef BENCH_STARTS_H
#define BENCH_STARTS_H

#include "bench_scenes.h"
#include "test_fit.h"

/* The rotations of a cube, turned at random: any rotation is within 63 degrees of one. */
enum { BENCH_STARTS_MAX = 24 };

/* The different places where fits from all these rotations end. Such a fit minimises the
 * distances between unit rays. They have no pole where a point is 90 degrees off the axis,
 * and they differ for a point in front of the camera and one behind it. */
int bench_starts(test_fitted starts[BENCH_STARTS_MAX], const bench_scene *s);

#endif /* BENCH_STARTS_H */
