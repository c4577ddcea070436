/* fuzz_narrow.h - the library in float, for harnesses that compare it with double. Plain
 * types, because rigcal_real has two meanings in such a program.
 *
 * fuzz_narrow.c and a library in float become one object, of which only these functions are
 * visible. */
#ifndef FUZZ_NARROW_H
#define FUZZ_NARROW_H

#include <stdint.h>

/* What both precisions can hold: all numbers are floats. */
enum { NARROW_CAMERAS = 3, NARROW_POINTS = 12 };

typedef struct narrow_camera {
    int32_t lens, width, height;
    float numbers[12]; /* fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6 */
} narrow_camera;

typedef struct narrow_pose {
    float R[9], t[3];
} narrow_pose;

/* Return the statuses of the library's functions. */
int32_t narrow_project(double uv[2], const narrow_camera *camera, const float X[3]);
int32_t narrow_ray(double ray[3], const narrow_camera *camera, const float uv[2]);

/* The poses of n points: R and t of each, 12 numbers. */
int32_t narrow_solve(double poses[4][12], int *n_found, const narrow_camera *camera,
                     float X[][3], float uv[][2], int n);

/* The point that n cameras see at uv. */
int32_t narrow_triangulate(double X[3], const narrow_camera cameras[],
                           const narrow_pose cams_from_world[], float uv[][2], int n);

#endif /* FUZZ_NARROW_H */
