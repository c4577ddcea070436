#include "bench_rigs.h"

#include <stdio.h>
#include <stdlib.h>

#define FAR 5.0 /* distance of the target's middle from camera 0 */
#define ARC 1.4 /* radian, over all cameras */

static void fail(const char *why)
{
    fprintf(stderr, "bench_rigs: %s\n", why);
    exit(2);
}

static void *memory(size_t n, size_t size)
{
    void *const p = calloc(n, size);

    if (p == NULL) {
        fail("there is no memory");
    }
    return p;
}

/* cam_from_rig of a camera that looks at the middle. */
static rigcal_transform camera_pose(test_rng *rng, int index, int n_cameras)
{
    static const double up[3] = {0, 1, 0};
    double turn[9], tilt[9], R[9], t[3] = {0, 0, 0};

    if (index == 0) {
        test_rotation(R, 0, 0, 0);
        return test_transform(R, t);
    }
    const double angle = ARC * index / n_cameras + test_uniform(rng, -0.05, 0.05);
    const double axis[3] = {1, test_uniform(rng, -0.5, 0.5), test_uniform(rng, -1, 1)};

    test_rotation_about(turn, up, angle);
    test_rotation_about(tilt, axis, test_uniform(rng, -0.15, 0.15));
    test_product(R, tilt, turn);
    for (int k = 0; k < 3; k++) { /* R (0, 0, FAR) + t is near (0, 0, FAR) */
        t[k] = test_uniform(rng, -0.3, 0.3) - FAR * R[3 * k + 2] + ((k == 2) ? FAR : 0);
    }
    return test_transform(R, t);
}

static rigcal_transform placement_pose(test_rng *rng)
{
    double turn[9];
    const double axis[3] = {test_uniform(rng, -1, 1), test_uniform(rng, -1, 1), 0.3};
    const double angle = test_uniform(rng, -0.6, 0.6);
    const double t[3] = {test_uniform(rng, -0.5, 0.5), test_uniform(rng, -0.4, 0.4),
                         FAR + test_uniform(rng, -0.6, 0.6)};

    test_rotation_about(turn, axis, angle);
    return test_transform(turn, t);
}

static rigcal_camera camera_of(test_rng *rng)
{
    rigcal_camera c = test_pinhole();

    c.width = 1280;
    c.height = 960;
    c.cx = RC(639.5 + test_uniform(rng, -10, 10));
    c.cy = RC(479.5 + test_uniform(rng, -10, 10));
    c.k1 = RC(test_uniform(rng, -0.28, -0.2));
    c.k2 = RC(0.09);
    c.k3 = RC(-0.01);
    c.p1 = RC(0.0005);
    c.p2 = RC(-0.0003);
    return c;
}

/* The noisy pixels of a view, by the true poses. */
static void see(rigcal_observation seen[], test_rng *rng, const rigcal_camera *camera,
                const rigcal_transform *cam_from_target, double (*X)[3], int n)
{
    double R[9], t[3];

    test_transform_parts(R, t, cam_from_target);
    for (int i = 0; i < n; i++) {
        double X_c[3], uv[2];

        test_apply(X_c, R, X[i], t);
        test_project_px(uv, camera, X_c);
        if (!(X_c[2] > 1 && uv[0] > 0 && uv[1] > 0 && uv[0] < 1280 && uv[1] < 960)) {
            fail("a point is out of sight; the cameras' arc is too wide");
        }
        test_to_real(seen[i].X_w, X[i], 3);
        for (int k = 0; k < 2; k++) {
            seen[i].uv[k] = RC(uv[k] + BENCH_RIG_NOISE_PX * test_normal(rng));
        }
    }
}

/* The first eight points are near the corners of the box, four of them off every plane, so
 * every view has enough information. */
static void make_views(bench_rig *b, test_rng *rng)
{
    static const int corners[8] = {0, 3, 5, 6, 7, 4, 2, 1}; /* one bit for each axis */
    double(*const X)[3] = memory((size_t)b->n_points, sizeof *X);
    const rigcal_transform *const places = &b->poses[b->n_cameras];

    for (int i = 0; i < b->n_points; i++) {
        for (int k = 0; k < 3; k++) {
            const double half = (k == 2) ? 0.25 : 0.5;
            const double side = ((corners[i % 8] >> k) & 1) ? half : -half;

            X[i][k] =
                (i < 8) ? side * test_uniform(rng, 0.6, 1) : test_uniform(rng, -half, half);
            X[i][k] = (double)(float)X[i][k];
        }
    }
    for (int f = 0; f < b->n_placements; f++) {
        for (int c = 0; c < b->n_cameras; c++) {
            const size_t index = (size_t)f * (size_t)b->n_cameras + (size_t)c;
            rigcal_observation *const seen = &b->observations[index * (size_t)b->n_points];
            const rigcal_transform pose = test_times(&b->poses[c], &places[f]);

            see(seen, rng, &b->cameras[c], &pose, X, b->n_points);
            b->views[index].view = VIEW(&b->cameras[c], seen, NULL, b->n_points);
            b->views[index].camera = c;
            b->views[index].placement = f;
        }
    }
    free(X);
}

static void solve_views(bench_rig *b)
{
    for (size_t i = 0; i < b->rig.n_views; i++) {
        rigcal_pose poses[RIGCAL_POSES_MAX];
        size_t n;

        if (rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n, NULL, &b->views[i].view, NULL) <
                0 ||
            rigcal_view_pose_make(&b->own[i], &b->views[i], &poses[0].cam_from_world) !=
                RIGCAL_OK) {
            fail("the pose of a view cannot be had");
        }
    }
}

static void compose_starts(bench_rig *b)
{
    rigcal_transform *const places = &b->starts[b->n_cameras];
    const rigcal_transform target_from_rig = test_inverse(&b->own[0].cam_from_target);

    for (int c = 0; c < b->n_cameras; c++) {
        b->starts[c] = test_times(&b->own[c].cam_from_target, &target_from_rig);
    }
    b->starts[0] = b->poses[0];
    for (int f = 0; f < b->n_placements; f++) {
        places[f] = b->own[f * b->n_cameras].cam_from_target;
    }
}

void bench_rig_make(bench_rig *b, int n_cameras, int n_placements, int n_points,
                    uint64_t seed)
{
    const size_t C = (size_t)n_cameras, F = (size_t)n_placements, n = (size_t)n_points;
    test_rng rng = test_seed(seed);
    const rigcal_rig nothing = {0};

    b->n_cameras = n_cameras;
    b->n_placements = n_placements;
    b->n_points = n_points;
    b->rig = nothing;
    b->cameras = memory(C, sizeof *b->cameras);
    b->observations = memory(C * F * n, sizeof *b->observations);
    b->views = memory(C * F, sizeof *b->views);
    b->own = memory(C * F, sizeof *b->own);
    b->poses = memory(C + F, sizeof *b->poses);
    b->starts = memory(C + F, sizeof *b->starts);
    b->group = memory(C, sizeof *b->group);
    b->rig.work_capacity = rigcal_rig_work(C - 1, C, F);
    b->work = memory(b->rig.work_capacity, sizeof *b->work);
    for (size_t c = 0; c < C; c++) {
        b->cameras[c] = camera_of(&rng);
        b->poses[c] = camera_pose(&rng, (int)c, n_cameras);
    }
    for (size_t f = 0; f < F; f++) {
        b->poses[C + f] = placement_pose(&rng);
    }
    make_views(b, &rng);

    b->rig.cams_from_rig = b->poses;
    b->rig.n_cameras = C;
    b->rig.rig_from_placements = &b->poses[C];
    b->rig.n_placements = F;
    b->rig.group = b->group;
    b->rig.n_views = C * F;
    b->rig.views = b->views;
    b->rig.work = b->work;
    solve_views(b);
    compose_starts(b);
    bench_rig_reset(b);
}

void bench_rig_free(bench_rig *b)
{
    free(b->cameras);
    free(b->observations);
    free(b->views);
    free(b->own);
    free(b->poses);
    free(b->starts);
    free(b->group);
    free(b->work);
}

void bench_rig_reset(bench_rig *b)
{
    for (int i = 0; i < b->n_cameras + b->n_placements; i++) {
        b->poses[i] = b->starts[i];
    }
}

rigcal_status bench_adjust(rigcal_rig_fit *fit, bench_rig *b)
{
    b->rig.view_poses = NULL;
    return rigcal_rig_adjust(fit, NULL, &b->rig);
}

rigcal_status bench_join(bench_rig *b)
{
    b->rig.view_poses = b->own;
    return rigcal_rig_join(&b->rig, NULL);
}
