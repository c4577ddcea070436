#include "scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

const double paper_points[PAPER_POINTS][3] = {
    {0, 0, 0}, {20, 2, 4}, {5, 19, -3}, {12, 8, 18}};

const double paper_depths_cm[PAPER_DEPTHS] = {50, 100, 200};
const int paper_widths[PAPER_WIDTHS] = {32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024};

void paper_expect(int fact, const char *what)
{
    if (!fact) {
        fprintf(stderr, "paper: %s\n", what);
        exit(1);
    }
}

/* ---- random numbers ----------------------------------------------------- */

static uint64_t next(paper_rng *rng)
{
    uint64_t z = rng->state += 0x9e3779b97f4a7c15u;

    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

paper_rng paper_stream(int use, int k)
{
    const paper_rng rng = {(uint64_t)PAPER_SEED << 48 | (uint64_t)use << 32 | (uint64_t)k};

    return rng;
}

double paper_uniform(paper_rng *rng, double low, double high)
{
    return low + (high - low) * (double)(next(rng) >> 11) / 9007199254740992.0;
}

/* The sum of twelve uniform numbers. It needs no logarithm, so it has the same bits
 * everywhere. */
double paper_normal(paper_rng *rng)
{
    double sum = -6;

    for (int i = 0; i < 12; i++) {
        sum += paper_uniform(rng, 0, 1);
    }
    return sum;
}

/* ---- scenes ------------------------------------------------------------- */

void paper_middle(double X[3])
{
    for (int k = 0; k < 3; k++) {
        X[k] = 0;
        for (int i = 0; i < PAPER_POINTS; i++) {
            X[k] += paper_points[i][k] / PAPER_POINTS;
        }
    }
}

void paper_in_camera(double X_c[3], const rigcal_transform *T, const double X[3])
{
    paper_expect(rigcal_transform_point(X_c, T, X) == RIGCAL_OK,
                 "a point has no place in the camera");
}

/* The t that puts the target's middle at (x, y, 1) times depth. */
static void place(rigcal_transform *cam_from_target, double x, double y, double depth)
{
    const double seen_at[3] = {x * depth, y * depth, depth};
    double middle[3], turned[3];

    paper_middle(middle);
    for (int k = 0; k < 3; k++) {
        cam_from_target->t[k] = 0;
    }
    paper_in_camera(turned, cam_from_target, middle);
    for (int k = 0; k < 3; k++) {
        cam_from_target->t[k] = seen_at[k] - turned[k];
    }
}

void paper_scene_documented(paper_scene *scene, double depth_cm)
{
    static const double degrees[PAPER_CAMERAS][3] = {{10, -20, 35}, {-25, 25, 10}};
    static const double off[PAPER_CAMERAS][2] = {{0.04, -0.03}, {-0.05, 0.04}};

    for (int c = 0; c < PAPER_CAMERAS; c++) {
        rigcal_transform *const T = &scene->cam_from_target[c];
        double ypr[3];

        for (int k = 0; k < 3; k++) {
            ypr[k] = degrees[c][k] * PAPER_DEGREE;
        }
        (void)rigcal_rotation_from_yaw_pitch_roll(T->R, ypr);
        place(T, off[c][0], off[c][1], depth_cm);
    }
}

void paper_scene_random(paper_scene *scene, int k, double depth_cm)
{
    paper_rng rng = paper_stream(PAPER_PLACING, k);
    double q[4], w[3], turn[9], length, across, angle;
    rigcal_transform T[PAPER_CAMERAS] = {{{0}, {0}}, {{0}, {0}}}, by = T[0];

    do { /* uniform in the ball, so uniform over the rotations */
        length = 0;
        for (int i = 0; i < 4; i++) {
            q[i] = paper_uniform(&rng, -1, 1);
            length += q[i] * q[i];
        }
    } while (!(length > 0.01 && length <= 1));
    paper_expect(rigcal_rotation_from_quaternion(T[0].R, q) == RIGCAL_OK,
                 "a quaternion is no rotation");
    across = paper_uniform(&rng, 0, 360) * PAPER_DEGREE;
    angle = paper_uniform(&rng, PAPER_TURN_LEAST, PAPER_TURN_MOST) * PAPER_DEGREE;
    w[0] = angle * cos(across);
    w[1] = angle * sin(across);
    w[2] = 0;
    (void)rigcal_rotation_from_vector(turn, w);
    for (int i = 0; i < 9; i++) {
        by.R[i] = turn[i];
    }
    paper_expect(rigcal_transform_compose(&T[1], &by, &T[0]) == RIGCAL_OK,
                 "two rotations have no product");
    for (int c = 0; c < PAPER_CAMERAS; c++) {
        const double x = paper_uniform(&rng, -PAPER_OFF_AXIS, PAPER_OFF_AXIS);
        const double y = paper_uniform(&rng, -PAPER_OFF_AXIS, PAPER_OFF_AXIS);

        place(&T[c], x, y, depth_cm);
        scene->cam_from_target[c] = T[c];
    }
}

/* ---- images ------------------------------------------------------------- */

void paper_see_point(double uv[2], const paper_images *images, const paper_scene *scene,
                     int k, const double X[3])
{
    double X_c[3];

    paper_in_camera(X_c, &scene->cam_from_target[k], X);
    paper_expect(rigcal_camera_project(uv, &images->camera, X_c) == RIGCAL_OK,
                 "a point is not in front of a camera");
    for (int i = 0; images->digital && i < 2; i++) {
        uv[i] = floor(uv[i] + 0.5);
        paper_expect(uv[i] >= 0 && uv[i] <= images->camera.width - 1,
                     "a point is outside a digital image");
    }
}

void paper_look(paper_images *images, const paper_scene *scene, int width, int digital)
{
    const double middle = (width - 1) / 2.0;

    *images = (paper_images){0};
    images->camera.lens = RIGCAL_LENS_BROWN;
    images->camera.width = images->camera.height = width;
    images->camera.fx = images->camera.fy = width * PAPER_FOCAL_INCH / PAPER_IMAGE_INCH;
    images->camera.cx = images->camera.cy = middle;
    images->digital = digital;
    for (int c = 0; c < PAPER_CAMERAS; c++) {
        for (int i = 0; i < PAPER_POINTS; i++) {
            rigcal_observation *const o = &images->seen[c][i];
            rigcal_bearing *const s = &images->bearings[c][i];

            for (int k = 0; k < 3; k++) {
                o->X_w[k] = s->X_w[k] = paper_points[i][k];
            }
            paper_see_point(o->uv, images, scene, c, paper_points[i]);
            if (digital) {
                s->ray[0] = (o->uv[0] - middle) / images->camera.fx;
                s->ray[1] = (o->uv[1] - middle) / images->camera.fy;
                s->ray[2] = 1;
            } else {
                paper_in_camera(s->ray, &scene->cam_from_target[c], paper_points[i]);
            }
        }
    }
}
