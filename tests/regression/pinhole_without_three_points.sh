#!/bin/sh
# With RIGCAL_WITH_THREE_POINTS = 0, a pose of a pinhole whose rays are far apart used the
# frame of its first try again: most points 60 degrees to one side, the others as far to the
# other side.
#
#   sh tests/regression/pinhole_without_three_points.sh FOLDER
set -eu
out=$(cd "$1" && pwd)

cat >"$out/wide.c" <<'END'
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "rigcal.h"

enum { N = 12, SCENES = 240 };

static unsigned long state = 1;

static double uniform(double from, double to)
{
    state = (state * 1103515245UL + 12345UL) & 0x7fffffffUL;
    return from + (to - from) * (double)state / 2147483648.0;
}

/* Points in the camera's frame, one of them on the other side, and how they look. */
static void make(rigcal_observation o[N], const rigcal_camera *c, const double R[9], int other)
{
    for (int i = 0; i < N; i++) {
        const double side = i == other ? -1 : 1, depth = uniform(0.8, 1.2);
        const double X_c[3] = {side * depth * uniform(1.5, 2), depth * uniform(-0.6, 0.6), depth};
        for (int k = 0; k < 3; k++) { /* X_c = R X_w + (0, 0, 1) */
            o[i].X_w[k] = (rigcal_real)(R[k] * X_c[0] + R[3 + k] * X_c[1] + R[6 + k] * (X_c[2] - 1));
        }
        o[i].uv[0] = (rigcal_real)((double)c->fx * X_c[0] / X_c[2] + (double)c->cx);
        o[i].uv[1] = (rigcal_real)((double)c->fy * X_c[1] / X_c[2] + (double)c->cy);
    }
}

int main(void)
{
    static rigcal_observation o[N];
    rigcal_camera camera;
    rigcal_pose_options options;
    int right = 0;
    memset(&camera, 0, sizeof camera);
    camera.width = camera.height = 1000;
    camera.fx = camera.fy = 200;
    camera.cx = camera.cy = 500;
    if (rigcal_pose_defaults(&options) != RIGCAL_OK) {
        return 1;
    }
    for (int scene = 0; scene < SCENES; scene++) {
        const double a = uniform(-3, 3), c = cos(a), s = sin(a);
        const double R[9] = {c, -s, 0, s, c, 0, 0, 0, 1};
        rigcal_pose poses[RIGCAL_POSES_MAX];
        rigcal_view view = {&camera, o, NULL, N};
        size_t n = 0;
        make(o, &camera, R, scene % N);
        if (rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n, NULL, &view, &options) < 0 || n == 0) {
            continue;
        }
        right += fabs((double)poses[0].cam_from_world.R[0] - c) < 1e-5 &&
                 fabs((double)poses[0].cam_from_world.t[2] - 1) < 1e-5;
    }
    printf("%d of %d poses are right\n", right, SCENES);
    return right != SCENES;
}
END
gcc -std=c99 -O1 -ffp-contract=off -DRIGCAL_WITH_THREE_POINTS=0 -Iinclude -Isrc \
    "$out/wide.c" src/*.c -lm -o "$out/wide"
"$out/wide"
