/* bench_hooks: instructions and answers of the jobs that call sine, cosine and
 * square root, for tests/bench/hooks.sh, which compares builds.
 *
 * A line a job: "job NAME INSTRUCTIONS", the mean of TURNS inputs, then one "of NAME
 * NUMBER..." an input. The inputs are the same floats in every build. Instructions
 * are counted on the emulated mps2-an386 only (-icount shift=10: an instruction is
 * 1024 ns, and the timer ticks at 25 MHz); 0 elsewhere. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>

#include "rigcal_paper.h"

enum { TURNS = 50, POINTS = 8, NUMBERS = 12 };

/* ---- the timer of the emulated board ------------------------------------- */

#ifdef __arm__
static volatile uint32_t *const TIMER = (volatile uint32_t *)0x40000000;

#define TICKS_AN_INSTRUCTION 25.6

static void start_timer(void)
{
    TIMER[2] = UINT32_MAX;
    TIMER[1] = UINT32_MAX;
    TIMER[0] = 1;
}

static double instructions(uint32_t from)
{
    return (double)(from - TIMER[1]) / TICKS_AN_INSTRUCTION;
}

static uint32_t now(void)
{
    return TIMER[1];
}
#else
static void start_timer(void)
{
}

static double instructions(uint32_t from)
{
    return from;
}

static uint32_t now(void)
{
    return 0;
}
#endif

/* ---- inputs -------------------------------------------------------------- */

static uint64_t state;

/* A number in [low, high), by SplitMix64, rounded to float. */
static double uniform(double low, double high)
{
    uint64_t z = (state += UINT64_C(0x9E3779B97F4A7C15));

    z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
    z ^= z >> 31;
    return (double)(float)(low + (high - low) * ((double)(z >> 11) * 0x1p-53));
}

static void three(rigcal_real x[3], double size)
{
    for (int i = 0; i < 3; i++) {
        x[i] = (rigcal_real)uniform(-size, size);
    }
}

static rigcal_camera camera_of(int32_t lens)
{
    rigcal_camera c = {.lens = lens, .width = 1280, .height = 960};

    c.fx = c.fy = 400;
    c.cx = 640;
    c.cy = 480;
    c.k1 = (rigcal_real)(lens == RIGCAL_LENS_FISHEYE ? 0.0625 : -0.0625);
    return c;
}

/* A target of size 2 about its origin, 3 to 6 away, with any orientation. Its pixels have
 * noise of a quarter of a pixel. */
static struct {
    rigcal_camera camera;
    rigcal_observation seen[POINTS];
    rigcal_bearing bearings[POINTS];
    rigcal_pair pairs[RIGCAL_PAIRS_FOR(POINTS)];
    size_t n_pairs;
} scene;

static void rotation_of(double R[9], const double q[4])
{
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double n = w * w + x * x + y * y + z * z;
    const double rows[9] = {w * w + x * x - y * y - z * z, 2 * (x * y - w * z),
                            2 * (x * z + w * y),           2 * (x * y + w * z),
                            w * w - x * x + y * y - z * z, 2 * (y * z - w * x),
                            2 * (x * z - w * y),           2 * (y * z + w * x),
                            w * w - x * x - y * y + z * z};

    for (int i = 0; i < 9; i++) {
        R[i] = rows[i] / n;
    }
}

static void image(double uv[2], const rigcal_camera *c, const double X_c[3])
{
    const double r = sqrt(X_c[0] * X_c[0] + X_c[1] * X_c[1]), k1 = (double)c->k1;
    const double theta = atan2(r, X_c[2]), m = r / X_c[2];
    const double rd = c->lens == RIGCAL_LENS_FISHEYE ? theta * (1 + k1 * theta * theta)
                                                     : m * (1 + k1 * m * m);

    for (int i = 0; i < 2; i++) {
        uv[i] = 400 * rd * X_c[i] / r + (i == 0 ? 640 : 480);
    }
}

static void make_scene(int32_t lens)
{
    double q[4], R[9], t[3];

    for (int i = 0; i < 4; i++) {
        q[i] = uniform(-1, 1);
    }
    rotation_of(R, q);
    t[2] = uniform(3, 6);
    t[0] = uniform(-0.25, 0.25) * t[2];
    t[1] = uniform(-0.25, 0.25) * t[2];
    scene.camera = camera_of(lens);
    for (int k = 0; k < POINTS; k++) {
        rigcal_observation *const o = &scene.seen[k];
        double X_c[3], uv[2];

        three(o->X_w, 1);
        for (int i = 0; i < 3; i++) {
            X_c[i] = R[3 * i] * (double)o->X_w[0] + R[3 * i + 1] * (double)o->X_w[1] +
                     R[3 * i + 2] * (double)o->X_w[2] + t[i];
        }
        image(uv, &scene.camera, X_c);
        for (int i = 0; i < 2; i++) {
            o->uv[i] = (rigcal_real)(float)(uv[i] + uniform(-0.4375, 0.4375));
        }
    }
}

/* ---- jobs ---------------------------------------------------------------- */

static rigcal_real input[3], output[NUMBERS];
static rigcal_pose poses[RIGCAL_POSES_MAX];
static rigcal_paper_pose paper;

static void prepare_angles(void)
{
    three(input, 3);
}

static void prepare_pixel(void)
{
    scene.camera = camera_of(RIGCAL_LENS_FISHEYE);
    input[0] = (rigcal_real)uniform(0, 1280);
    input[1] = (rigcal_real)uniform(0, 960);
}

static void prepare_pinhole(void)
{
    make_scene(RIGCAL_LENS_BROWN);
}

static void prepare_fisheye(void)
{
    make_scene(RIGCAL_LENS_FISHEYE);
}

static void prepare_paper(void)
{
    const rigcal_view view = {&scene.camera, scene.seen, NULL, POINTS};

    make_scene(RIGCAL_LENS_BROWN);
    (void)rigcal_bearings_of_view(scene.bearings, NULL, &view);
    (void)rigcal_pairs_choose(scene.pairs, RIGCAL_PAIRS_FOR(POINTS), &scene.n_pairs,
                              scene.bearings, POINTS);
}

static rigcal_status from_angles(void)
{
    return rigcal_rotation_from_yaw_pitch_roll(output, input);
}

static rigcal_status from_vector(void)
{
    return rigcal_rotation_from_vector(output, input);
}

static rigcal_status to_ray(void)
{
    return rigcal_camera_ray(output, &scene.camera, input);
}

static rigcal_status solve(void)
{
    const rigcal_view view = {&scene.camera, scene.seen, NULL, POINTS};
    size_t n;

    return rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n, NULL, &view, NULL);
}

static rigcal_status solve_paper(void)
{
    return rigcal_paper_solve(&paper, scene.bearings, POINTS, scene.pairs, scene.n_pairs,
                              NULL);
}

static const struct {
    const char *name;
    void (*prepare)(void);
    rigcal_status (*run)(void);
    const rigcal_real *numbers;
    int n;
} jobs[] = {
    {"rigcal_rotation_from_yaw_pitch_roll", prepare_angles, from_angles, output, 9},
    {"rigcal_rotation_from_vector", prepare_angles, from_vector, output, 9},
    {"rigcal_camera_ray,_fisheye", prepare_pixel, to_ray, output, 3},
    {"rigcal_pose_solve,_8_points", prepare_pinhole, solve, poses[0].cam_from_world.R, 9},
    {"rigcal_pose_solve,_8_points,_fisheye", prepare_fisheye, solve,
     poses[0].cam_from_world.R, 9},
    {"rigcal_paper_solve,_8_points", prepare_paper, solve_paper, paper.cam_from_world.R, 9},
};

int main(void)
{
    for (size_t j = 0; j < sizeof jobs / sizeof jobs[0]; j++) {
        double sum = 0;

        start_timer();
        state = j;
        for (int i = 0; i < TURNS; i++) {
            jobs[j].prepare();
            const uint32_t from = now();
            const rigcal_status status = jobs[j].run();
            sum += instructions(from);
            if (status < 0) {
                printf("bench_hooks: %s, input %d: %s\n", jobs[j].name, i,
                       rigcal_status_name(status));
                return 1;
            }
            printf("of %s", jobs[j].name);
            for (int k = 0; k < jobs[j].n; k++) {
                printf(" %.17g", (double)jobs[j].numbers[k]);
            }
            printf("\n");
        }
        printf("job %s %.0f\n", jobs[j].name, sum / TURNS);
    }
    return 0;
}
