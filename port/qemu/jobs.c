/* jobs.c - the library's main jobs over seeded scenes, on an emulated target.
 *
 * A line for each job and scene: the job, the status, the bytes of stack the call
 * took, and every number it returned as the bits of a rigcal_real in hexadecimal.
 * figures.py counts and compares; count.c counts instructions between the two marks. Then
 * "bytes NAME NUMBER" of what the rig's jobs work in.
 *
 * The scenes are made by +, -, *, / and sqrt of doubles alone, which IEEE 754
 * defines to the last bit, so that they are the same on every target. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "rigcal.h"

#ifndef JOBS_SCENES
#define JOBS_SCENES 20
#endif

/* A rig has 24 views. Their poses have to be found before they are joined. */
#define JOBS_RIGS ((JOBS_SCENES + 3) / 4)

/* Whether there is RAM for a rig. */
#ifndef JOBS_RIG
#define JOBS_RIG 1
#endif

/* The only job to run; "": all jobs. */
#ifndef JOBS_ONLY
#define JOBS_ONLY ""
#endif

enum { POINTS_MAX = 50 };

/* The noise of a pixel, and the error of a previous pose: radian, and part of the
 * distance. */
#define NOISE_PX 0.5
#define OFF_ANGLE 0.035
#define OFF_DISTANCE 0.02

void jobs_begin(void);
void jobs_end(void);

/* ---- random scenes ------------------------------------------------------- */

static uint64_t state;

/* A number in [low, high), by SplitMix64. */
static double uniform(double low, double high)
{
    uint64_t z = (state += UINT64_C(0x9E3779B97F4A7C15));
    z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
    return low + (high - low) * ((double)((z ^ (z >> 31)) >> 11) * 0x1p-53);
}

/* A normal number with standard deviation 1. */
static double normal(void)
{
    double sum = -6;
    for (int i = 0; i < 12; i++) {
        sum += uniform(0, 1);
    }
    return sum;
}

static void rotation_of(double R[9], const double q[4])
{
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double s = 2 / (w * w + x * x + y * y + z * z);
    R[0] = 1 - s * (y * y + z * z);
    R[1] = s * (x * y - w * z);
    R[2] = s * (x * z + w * y);
    R[3] = s * (x * y + w * z);
    R[4] = 1 - s * (x * x + z * z);
    R[5] = s * (y * z - w * x);
    R[6] = s * (x * z - w * y);
    R[7] = s * (y * z + w * x);
    R[8] = 1 - s * (x * x + y * y);
}

/* A uniformly distributed direction in n dimensions. */
static void direction(double d[], int n)
{
    double squared;
    do {
        squared = 0;
        for (int k = 0; k < n; k++) {
            d[k] = uniform(-1, 1);
            squared += d[k] * d[k];
        }
    } while (squared > 1 || squared < 0.01);
    for (int k = 0; k < n; k++) {
        d[k] /= sqrt(squared);
    }
}

static void transform(rigcal_transform *T, const double R[9], const double t[3])
{
    for (int k = 0; k < 9; k++) {
        T->R[k] = (rigcal_real)R[k];
    }
    for (int k = 0; k < 3; k++) {
        T->t[k] = (rigcal_real)t[k];
    }
}

/* A VGA camera of 800 px. With a lens it has Brown's k1, k2, k3, p1, p2. */
static rigcal_camera camera_of(int has_lens)
{
    rigcal_camera camera = {.lens = RIGCAL_LENS_BROWN,
                            .width = 640,
                            .height = 480,
                            .fx = 800,
                            .fy = 800,
                            .cx = (rigcal_real)319.5,
                            .cy = (rigcal_real)239.5};
    if (has_lens) {
        camera.k1 = (rigcal_real)-0.28;
        camera.k2 = (rigcal_real)0.09;
        camera.k3 = (rigcal_real)-0.01;
        camera.p1 = (rigcal_real)0.0005;
        camera.p2 = (rigcal_real)-0.0003;
    }
    return camera;
}

/* The input of the jobs: points of a unit cube before two cameras, 3 to 10 sizes away. */
static struct {
    rigcal_camera camera[2];
    rigcal_transform cam_from_world[2], b_from_a;
    rigcal_observation seen[POINTS_MAX];
    rigcal_real X_c[3], uv[2], uv_both[4], ray[3];
    rigcal_pose_options warm;
    size_t n;
} scene;

/* The pixel of X for the pose R, t and the lens of a camera, in double. */
static void image(rigcal_real uv[2], const rigcal_camera *camera, const double R[9],
                  const double t[3], const double X[3], double noise)
{
    double c[3];
    for (int k = 0; k < 3; k++) {
        c[k] = R[3 * k] * X[0] + R[3 * k + 1] * X[1] + R[3 * k + 2] * X[2] + t[k];
    }
    const double x = c[0] / c[2], y = c[1] / c[2], q = x * x + y * y;
    const double k1 = (double)camera->k1, k2 = (double)camera->k2;
    const double k3 = (double)camera->k3;
    const double p1 = (double)camera->p1, p2 = (double)camera->p2;
    const double d = 1 + q * (k1 + q * (k2 + q * k3));
    const double xd = x * d + 2 * p1 * x * y + p2 * (q + 2 * x * x);
    const double yd = y * d + p1 * (q + 2 * y * y) + 2 * p2 * x * y;
    uv[0] = (rigcal_real)(800 * xd + 319.5 + noise * normal());
    uv[1] = (rigcal_real)(800 * yd + 239.5 + noise * normal());
}

/* PLAIN and LENS: points in a unit cube with any orientation. TAG: the corners of a unit
 * square that faces the camera within 60 degrees. */
typedef enum { PLAIN, LENS, TAG } kind;

static void place_point(double X[3], size_t i, kind what)
{
    for (int k = 0; k < 3; k++) {
        X[k] = uniform(-0.5, 0.5);
    }
    if (what == TAG) {
        X[0] = (i == 1 || i == 2) ? 0.5 : -0.5;
        X[1] = (i >= 2) ? 0.5 : -0.5;
        X[2] = 0;
    }
}

static void make_scene(size_t n, kind what, uint64_t seed)
{
    double q[4], R[9], t[3], way[3], X[3], R_warm[9];
    state = seed;
    scene.n = n;
    do {
        direction(q, 4);
        rotation_of(R, q);
    } while (what == TAG && R[8] < 0.5);
    t[2] = uniform(3, 10);
    t[0] = t[2] * uniform(-0.1, 0.1);
    t[1] = t[2] * uniform(-0.1, 0.1);
    for (int i = 0; i < 2; i++) { /* the second camera is a tenth to the side */
        scene.camera[i] = camera_of(what == LENS);
        transform(&scene.cam_from_world[i], R, t);
        scene.cam_from_world[i].t[0] += (rigcal_real)(0.1 * t[2] * i);
    }
    for (size_t i = 0; i < n; i++) {
        place_point(X, i, what);
        for (int k = 0; k < 3; k++) {
            scene.seen[i].X_w[k] = (rigcal_real)X[k];
        }
        image(scene.seen[i].uv, &scene.camera[0], R, t, X, NOISE_PX);
    }

    /* The last point in both cameras. */
    const double aside[3] = {t[0] + 0.1 * t[2], t[1], t[2]};
    image(scene.uv_both, &scene.camera[0], R, t, X, NOISE_PX);
    image(scene.uv_both + 2, &scene.camera[1], R, aside, X, NOISE_PX);
    for (int k = 0; k < 3; k++) {
        scene.X_c[k] = (rigcal_real)(R[3 * k] * X[0] + R[3 * k + 1] * X[1] +
                                     R[3 * k + 2] * X[2] + t[k]);
        scene.ray[k] = scene.X_c[k] / (rigcal_real)t[2];
    }
    scene.uv[0] = scene.uv_both[0];
    scene.uv[1] = scene.uv_both[1];

    /* (1, a) is a turn by 2 |a|, to second order. */
    direction(way, 3);
    for (int k = 0; k < 3; k++) {
        q[k + 1] = way[k] * OFF_ANGLE / 2;
    }
    q[0] = 1;
    rotation_of(R_warm, q);
    double turned[9];
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            turned[3 * i + j] = R_warm[3 * i] * R[j] + R_warm[3 * i + 1] * R[3 + j] +
                                R_warm[3 * i + 2] * R[6 + j];
        }
    }
    direction(way, 3);
    for (int k = 0; k < 3; k++) {
        t[k] += way[k] * OFF_DISTANCE * t[2];
    }
    (void)rigcal_pose_defaults(&scene.warm);
    scene.warm.use_start = 1;
    transform(&scene.warm.start, turned, t);
    (void)rigcal_transform_between(&scene.b_from_a, &scene.cam_from_world[1],
                                   &scene.cam_from_world[0]);
}

/* ---- cameras of a rig ------------------------------------------------------ */

#define RIG_FAR 5.0

static void random_pose(double R[9], double t[3], double about_y, double turn, double shift)
{
    double q[4] = {1, 0, about_y, 0};
    for (int k = 0; k < 3; k++) {
        q[k + 1] += uniform(-turn, turn);
        t[k] = uniform(-shift, shift);
    }
    rotation_of(R, q);
    t[2] += RIG_FAR;
}

/* cam_from_rig, as R and t. The camera looks at the middle, far ahead of the first
 * camera. */
static void random_camera(double pose[12], int c)
{
    random_pose(pose, &pose[9], 0.17 * c, 0, 0.1);
    for (int k = 0; k < 3; k++) {
        pose[9 + k] -= RIG_FAR * pose[3 * k + 2];
    }
}

/* b = R a + t */
static void apply(double b[3], const double R[9], const double t[3], const double a[3])
{
    for (int k = 0; k < 3; k++) {
        b[k] = R[3 * k] * a[0] + R[3 * k + 1] * a[1] + R[3 * k + 2] * a[2] + t[k];
    }
}

/* A point that four cameras see through the lens. They are 20 degrees apart and RIG_FAR
 * away; the first is held. The joint covariance of the others is L L^T, with small integers
 * in L. */
enum { EYES = 4, EYES_FREE = 6 * EYES };

static struct {
    rigcal_mounted_camera cameras[EYES];
    int32_t group[EYES];
    uint8_t held[EYES];
    rigcal_real Sigma[RIGCAL_CALIBRATED_SIZE(EYES)];
    rigcal_calibrated_rig rig;
    rigcal_sighting seen[EYES];
    rigcal_real work[RIGCAL_POINT_WORK(EYES)];
    rigcal_sightings sightings;
} eyes;

static double lower(int i, int j)
{
    const double scale = (i % 6 < 3) ? 2e-4 : 1e-3;
    return (i == j) ? scale : scale * ((7 * i + 11 * j) % 13 - 6) / 13;
}

static void make_eyes(size_t n, kind what, uint64_t seed)
{
    double X[3], pose[12];
    state = seed;
    memset(&eyes, 0, sizeof eyes);
    place_point(X, 0, what);
    X[2] += RIG_FAR;
    for (int c = 0; c < EYES; c++) {
        rigcal_mounted_camera *const m = &eyes.cameras[c];
        random_camera(pose, c);
        m->camera = camera_of(what == LENS);
        transform(&m->cam_from_rig, pose, &pose[9]);
        eyes.held[c] = 0;
        eyes.seen[c].camera = c;
        image(eyes.seen[c].uv, &m->camera, pose, &pose[9], X, NOISE_PX);
    }
    for (int i = 0; i < EYES_FREE; i++) {
        for (int j = 0; j <= i; j++) {
            double sum = 0;
            for (int k = 0; k <= j; k++) {
                sum += lower(i, k) * lower(j, k);
            }
            eyes.Sigma[i * (i + 1) / 2 + j] = (rigcal_real)sum;
        }
    }
    eyes.rig = (rigcal_calibrated_rig){.cameras = eyes.cameras,
                                       .group = eyes.group,
                                       .held = eyes.held,
                                       .capacity = EYES,
                                       .Sigma = eyes.Sigma,
                                       .Sigma_capacity = RIGCAL_CALIBRATED_SIZE(EYES),
                                       .n_cameras = EYES,
                                       .sigma_px = (rigcal_real)NOISE_PX};
    eyes.sightings = (rigcal_sightings){.rig = &eyes.rig,
                                        .seen = eyes.seen,
                                        .n = n,
                                        .work = eyes.work,
                                        .work_capacity = RIGCAL_POINT_WORK(EYES)};
}

#if JOBS_RIG
/* ---- a rig --------------------------------------------------------------- */

/* Three cameras are RIG_FAR sizes from the target, 20 degrees apart. All see it in each
 * placement. The poses of the views by themselves are refined from the truth. */
enum { RIG_CAMERAS = 3, RIG_PLACEMENTS = 8, RIG_POINTS_MAX = 12 };
enum { RIG_VIEWS = RIG_CAMERAS * RIG_PLACEMENTS, RIG_POSES = RIG_CAMERAS + RIG_PLACEMENTS };

static struct {
    rigcal_rig rig;
    rigcal_camera camera;
    rigcal_transform poses[RIG_POSES], joined[RIG_POSES]; /* cameras, then placements */
    int32_t group[RIG_CAMERAS];
    rigcal_observation seen[RIG_VIEWS][RIG_POINTS_MAX];
    rigcal_rig_view views[RIG_VIEWS];
    rigcal_view_pose own[RIG_VIEWS];
    rigcal_real work[RIGCAL_RIG_WORK(RIG_CAMERAS - 1, RIG_CAMERAS, RIG_PLACEMENTS)];
} rig;

/* cam_from_target of a view, and its pixels. */
static void see_view(size_t v, const double X[][3], size_t n, const double camera[12],
                     const double place[12])
{
    double R[9], t[3];
    for (int i = 0; i < 9; i++) {
        R[i] = 0;
        for (int k = 0; k < 3; k++) {
            R[i] += camera[i / 3 * 3 + k] * place[3 * k + i % 3];
        }
    }
    apply(t, camera, &camera[9], &place[9]);
    for (size_t i = 0; i < n; i++) {
        for (int k = 0; k < 3; k++) {
            rig.seen[v][i].X_w[k] = (rigcal_real)X[i][k];
        }
        image(rig.seen[v][i].uv, &rig.camera, R, t, X[i], NOISE_PX);
    }
    rigcal_pose poses[RIGCAL_POSES_MAX];
    rigcal_pose_options options;
    size_t n_found;
    (void)rigcal_pose_defaults(&options);
    options.use_start = 1;
    transform(&options.start, R, t);
    (void)rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL, &rig.views[v].view,
                            &options);
    (void)rigcal_view_pose_make(&rig.own[v], &rig.views[v], &poses[0].cam_from_world);
}

static rigcal_status rig_join(void)
{
    return rigcal_rig_join(&rig.rig, NULL);
}

/* Makes the rig from the poses that the join gives. */
static void make_rig(size_t n, kind what, uint64_t seed)
{
    double X[RIG_POINTS_MAX][3], pose[RIG_POSES][12];
    state = seed;
    memset(&rig, 0, sizeof rig);
    rig.camera = camera_of(what == LENS);
    rig.rig = (rigcal_rig){.cams_from_rig = rig.poses,
                           .n_cameras = RIG_CAMERAS,
                           .rig_from_placements = &rig.poses[RIG_CAMERAS],
                           .n_placements = RIG_PLACEMENTS,
                           .group = rig.group,
                           .n_views = RIG_VIEWS,
                           .views = rig.views,
                           .view_poses = rig.own,
                           .work = rig.work,
                           .work_capacity = sizeof rig.work / sizeof rig.work[0]};
    for (int c = 0; c < RIG_CAMERAS; c++) {
        random_camera(pose[c], c);
    }
    for (int i = RIG_CAMERAS; i < RIG_POSES; i++) {
        random_pose(pose[i], &pose[i][9], 0, 0.3, 0.3);
    }
    for (size_t i = 0; i < n; i++) {
        place_point(X[i], i, what);
    }
    for (int v = 0; v < RIG_VIEWS; v++) {
        rigcal_rig_view *const view = &rig.views[v];
        view->view.camera = &rig.camera;
        view->view.observations = rig.seen[v];
        view->view.n = n;
        view->camera = v % RIG_CAMERAS;
        view->placement = v / RIG_CAMERAS;
        see_view((size_t)v, (const double(*)[3])X, n, pose[view->camera],
                 pose[RIG_CAMERAS + view->placement]);
    }
    (void)rig_join();
    memcpy(rig.joined, rig.poses, sizeof rig.joined);
}
#endif

/* The view of the first camera. */
static rigcal_view view_of(const rigcal_real sigma[])
{
    const rigcal_view view = {&scene.camera[0], scene.seen, sigma, scene.n};
    return view;
}

#ifndef JOBS_ONLY_SCENES /* steps.c needs only the scenes */

/* ---- the jobs ------------------------------------------------------------ */

/* The output of the jobs. */
static struct {
    rigcal_real uv[2], ray[3], line[3];
    rigcal_transform transform;
    rigcal_pose poses[RIGCAL_POSES_MAX];
    rigcal_pose_uncertainty uncertainty;
    rigcal_point point;
    rigcal_measured_point measured;
    struct {
        rigcal_transform cameras[3];
        rigcal_real Sigma[36]; /* of the last camera */
    } rig;
    size_t n_found;
} result;

static rigcal_status project(void)
{
    return rigcal_camera_project(result.uv, &scene.camera[0], scene.X_c);
}

static rigcal_status pixel_to_ray(void)
{
    return rigcal_camera_ray(result.ray, &scene.camera[0], scene.uv);
}

static rigcal_status undistort(void)
{
    return rigcal_camera_undistort(result.uv, &scene.camera[0], scene.uv);
}

static rigcal_status solve_cold(void)
{
    const rigcal_view view = view_of(NULL);
    return rigcal_pose_solve(result.poses, RIGCAL_POSES_MAX, &result.n_found, NULL, &view,
                             NULL);
}

static rigcal_status solve_warm(void)
{
    const rigcal_view view = view_of(NULL);
    return rigcal_pose_solve(result.poses, RIGCAL_POSES_MAX, &result.n_found, NULL, &view,
                             &scene.warm);
}

static rigcal_status covariance(void)
{
    const rigcal_view view = view_of(NULL);
    return rigcal_pose_covariance(&result.uncertainty, &view, &scene.cam_from_world[0],
                                  (rigcal_real)NOISE_PX);
}

static rigcal_status triangulate(void)
{
    return rigcal_point_triangulate(&result.point, scene.camera, scene.cam_from_world,
                                    scene.uv_both, 2, (rigcal_real)NOISE_PX);
}

static rigcal_status measure_point(void)
{
    return rigcal_point_measure(&result.measured, NULL, &eyes.sightings);
}

static rigcal_status epiline(void)
{
    return rigcal_epiline_px(result.line, &scene.camera[1], &scene.b_from_a, scene.ray);
}

static rigcal_status relative_pose(void)
{
    return rigcal_transform_between(&result.transform, &scene.cam_from_world[1],
                                    &scene.cam_from_world[0]);
}

#if JOBS_RIG
static rigcal_status rig_adjust(void)
{
    rigcal_rig_fit fit;
    rigcal_status status = rigcal_rig_adjust(&fit, NULL, &rig.rig);
    if (status >= 0) {
        status = rigcal_rig_covariance(result.rig.Sigma, &rig.rig, (rigcal_real)NOISE_PX,
                                       RIG_CAMERAS - 1);
    }
    memcpy(result.rig.cameras, rig.poses, sizeof result.rig.cameras);
    return status;
}
#endif

typedef struct {
    const char *name;
    rigcal_status (*call)(void);
    void (*make)(size_t n, kind what, uint64_t seed);
    size_t n;
    kind what;
    const rigcal_real *out; /* of poses, the first */
    size_t out_count;
} job;

#define OUT(member) \
    (const rigcal_real *)&result.member, sizeof result.member / sizeof(rigcal_real)

#define RIG_OUT (const rigcal_real *)rig.poses, sizeof rig.poses / sizeof(rigcal_real)

static const job jobs[] = {
    {"project", project, make_scene, 4, LENS, OUT(uv)},
    {"pixel_to_ray", pixel_to_ray, make_scene, 4, LENS, OUT(ray)},
    {"undistort_pixel", undistort, make_scene, 4, LENS, OUT(uv)},
#if RIGCAL_WITH_THREE_POINTS
    {"solve_pose_3", solve_cold, make_scene, 3, PLAIN, OUT(poses[0])},
#endif
    {"solve_pose_tag", solve_cold, make_scene, 4, TAG, OUT(poses[0])},
    {"solve_pose_4", solve_cold, make_scene, 4, PLAIN, OUT(poses[0])},
    {"solve_pose_8", solve_cold, make_scene, 8, PLAIN, OUT(poses[0])},
    {"solve_pose_8_lens", solve_cold, make_scene, 8, LENS, OUT(poses[0])},
    {"solve_pose_50", solve_cold, make_scene, 50, PLAIN, OUT(poses[0])},
    {"solve_pose_tag_warm", solve_warm, make_scene, 4, TAG, OUT(poses[0])},
    {"solve_pose_4_warm", solve_warm, make_scene, 4, PLAIN, OUT(poses[0])},
    {"solve_pose_8_warm", solve_warm, make_scene, 8, PLAIN, OUT(poses[0])},
    {"solve_pose_50_warm", solve_warm, make_scene, 50, PLAIN, OUT(poses[0])},
    {"pose_covariance_8", covariance, make_scene, 8, PLAIN, OUT(uncertainty)},
    {"triangulate_2", triangulate, make_scene, 4, LENS, OUT(point)},
    {"measure_2", measure_point, make_eyes, 2, LENS, OUT(measured.X)},
    {"measure_4", measure_point, make_eyes, 4, LENS, OUT(measured.X)},
    {"epiline_px", epiline, make_scene, 4, LENS, OUT(line)},
    {"relative_pose", relative_pose, make_scene, 4, PLAIN, OUT(transform)},
#if JOBS_RIG
    {"rig_join_tag", rig_join, make_rig, 4, TAG, RIG_OUT},
    {"rig_join_12_lens", rig_join, make_rig, 12, LENS, RIG_OUT},
    {"rig_adjust_tag", rig_adjust, make_rig, 4, TAG, OUT(rig)},
    {"rig_adjust_12_lens", rig_adjust, make_rig, 12, LENS, OUT(rig)},
#endif
};

/* ---- stack --------------------------------------------------------------- */

#ifdef __linux__
static size_t measure(rigcal_status *status, const job *todo)
{
    jobs_begin();
    *status = todo->call();
    jobs_end();
    return 0;
}
#else
/* From the linker script: the stack's top, and its size as an address. */
extern unsigned char __stack[], __stack_size[];

enum { PATTERN = 0xA5 };

/* Fills the stack below this function's own stack pointer, makes the call, and returns how
 * many bytes of it were written. */
static size_t __attribute__((noinline)) measure(rigcal_status *status, const job *todo)
{
    register volatile unsigned char *const sp __asm__("sp");
    volatile unsigned char *const top = sp;
    volatile unsigned char *const bottom = __stack - (uintptr_t)__stack_size;
    volatile unsigned char *at = bottom;
    for (at = bottom; at < top; at++) {
        *at = PATTERN;
    }
    jobs_begin();
    *status = todo->call();
    jobs_end();
    for (at = bottom; at < top && *at == PATTERN; at++) {
    }
    return (at == bottom) ? SIZE_MAX : (size_t)(top - at);
}
#endif

/* Marks for count.c. They are called, never inlined. */
void __attribute__((noinline)) jobs_begin(void)
{
    __asm__ volatile("" ::: "memory");
}

void __attribute__((noinline)) jobs_end(void)
{
    __asm__ volatile("" ::: "memory");
}

static void print_bits(const rigcal_real *x, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        uint32_t words[sizeof x[0] / sizeof(uint32_t)];
        memcpy(words, &x[i], sizeof words);
        for (size_t k = 0; k < sizeof words / sizeof words[0]; k++) {
            printf(" %08lx", (unsigned long)words[k]);
        }
    }
}

int main(void)
{
    for (size_t j = 0; j < sizeof jobs / sizeof jobs[0]; j++) {
        if (JOBS_ONLY[0] != '\0' && strcmp(JOBS_ONLY, jobs[j].name) != 0) {
            continue;
        }
        const uint64_t scenes = (jobs[j].make == make_scene || jobs[j].make == make_eyes)
                                    ? JOBS_SCENES
                                    : JOBS_RIGS;
        for (uint64_t i = 0; i < scenes; i++) {
            rigcal_status status = 0;
            memset(&result, 0, sizeof result);
            jobs[j].make(jobs[j].n, jobs[j].what, 1000 * jobs[j].n + i);
            const size_t stack = measure(&status, &jobs[j]);
            printf("%s %ld %ld", jobs[j].name, (long)status, (long)stack);
            print_bits(jobs[j].out, jobs[j].out_count);
            printf("\n");
        }
    }
#if JOBS_RIG
    printf("bytes rig_work %ld\n", (long)sizeof rig.work);
    printf("bytes rig_poses_and_groups %ld\n", (long)(sizeof rig.poses + sizeof rig.group));
    printf("bytes rig_solver %ld\n", (long)sizeof(rigcal_rig_solver));
    printf("bytes rig_view_poses %ld\n", (long)sizeof rig.own);
#endif
    return 0;
}
#endif
