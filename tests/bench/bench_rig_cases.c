#include "bench_rig_cases.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ARC 1.4 /* radian, over all cameras */
enum { TRIES = 1000 };

/* ---- a rig --------------------------------------------------------------- */

static void fail(const char *why)
{
    fprintf(stderr, "bench_rig_cases: %s\n", why);
    exit(2);
}

static int draw(test_rng *rng, int least, int most)
{
    return least + (int)(test_next(rng) % (uint64_t)(most - least + 1));
}

static rigcal_camera camera_of(test_rng *rng, lens_kind lens)
{
    rigcal_camera c = test_pinhole();

    c.width = 1280;
    c.height = 960;
    c.cx = RC(639.5 + test_uniform(rng, -10, 10));
    c.cy = RC(479.5 + test_uniform(rng, -10, 10));
    if (lens == FISHEYE) {
        c.lens = RIGCAL_LENS_FISHEYE;
        c.fx = c.fy = RC(600);
        c.k1 = RC(test_uniform(rng, -0.03, 0.03));
        c.k2 = RC(-0.006);
        c.k3 = RC(0.002);
        c.k4 = RC(-0.0005);
        return c;
    }
    c.k1 = RC(test_uniform(rng, -0.28, -0.2));
    c.k2 = RC(0.09);
    c.k3 = RC(-0.01);
    c.p1 = RC(0.0005);
    c.p2 = RC(-0.0003);
    if (lens == RATIONAL) {
        c.k1 = RC(test_uniform(rng, 0.25, 0.35));
        c.k2 = RC(0.05);
        c.k3 = RC(0.002);
        c.k4 = RC(0.55);
        c.k5 = RC(0.12);
        c.k6 = RC(0.01);
    }
    return c;
}

static void make_target(rig_case *r, test_rng *rng)
{
    static const double tag[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};

    r->n_points = (r->target == TAG)     ? 4
                  : (r->target == BOARD) ? 4 * draw(rng, 3, 5)
                                         : draw(rng, 12, 20);
    for (int i = 0; i < r->n_points; i++) {
        double *const X = r->X[i];

        if (r->target == SPATIAL) {
            for (int k = 0; k < 3; k++) {
                const double half = (k == 2) ? 0.25 : 0.5;

                X[k] = (double)(float)test_uniform(rng, -half, half);
            }
        } else {
            X[0] = (r->target == TAG) ? 0.5 * tag[i][0] : 0.25 * (i % 4) - 0.375;
            X[1] = (r->target == TAG) ? 0.5 * tag[i][1] : 0.25 * (i / 4) - 0.375;
            X[2] = 0;
        }
    }
}

/* cam_from_world. The origin of the world is in the middle of the placements. */
static rigcal_transform camera_pose(const rig_case *r, test_rng *rng, int index)
{
    static const double up[3] = {0, 1, 0};
    double turn[9], tilt[9], R[9];
    const double angle =
        ARC * ((index + 0.5) / r->n_cameras - 0.5) + test_uniform(rng, -0.05, 0.05);
    const double axis[3] = {1, test_uniform(rng, -0.5, 0.5), test_uniform(rng, -1, 1)};
    const double t[3] = {test_uniform(rng, -0.3, 0.3), test_uniform(rng, -0.3, 0.3),
                         r->far + test_uniform(rng, -0.3, 0.3)};

    test_rotation_about(turn, up, angle);
    test_rotation_about(tilt, axis, test_uniform(rng, -0.15, 0.15));
    test_product(R, tilt, turn);
    return test_transform(R, t);
}

/* rig_from_placement, so that the target is in the images. */
static rigcal_transform placement_pose(const rig_case *r, test_rng *rng,
                                       const rigcal_transform *rig_from_world)
{
    double turn[9];
    const double axis[3] = {test_uniform(rng, -1, 1), test_uniform(rng, -1, 1),
                            test_uniform(rng, -0.5, 0.5)};
    const double wide = 0.5 * r->far;
    const double t[3] = {test_uniform(rng, -wide, wide), test_uniform(rng, -wide, wide),
                         test_uniform(rng, -0.15, 0.15) * r->far};

    test_rotation_about(turn, axis, test_uniform(rng, -0.6, 0.6));
    const rigcal_transform world_from_placement = test_transform(turn, t);
    return test_times(rig_from_world, &world_from_placement);
}

/* The pixels of a view. Returns 0 if a point is outside the image. */
static int see(rigcal_observation seen[], const rig_case *r, test_rng *rng, int camera,
               int placement)
{
    for (int i = 0; i < r->n_points; i++) {
        double X_r[3], X_c[3], uv[2];

        test_move_point(X_r, &r->truth[CAMERAS + placement], r->X[i]);
        test_move_point(X_c, &r->truth[camera], X_r);
        test_project_px(uv, &r->camera[camera], X_c);
        if (!(X_c[2] > 1 && uv[0] > 0 && uv[1] > 0 && uv[0] < 1279 && uv[1] < 959)) {
            return 0;
        }
        test_to_real(seen[i].X_w, r->X[i], 3);
        for (int k = 0; k < 2; k++) {
            seen[i].uv[k] = RC(uv[k] + NOISE * test_normal(rng));
        }
    }
    return 1;
}

/* Whether all cameras are connected. */
static int is_connected(const rig_case *r)
{
    int reached = 1; /* one bit for each camera */

    for (int round = 0; round < r->n_cameras; round++) {
        for (int f = 0; f < r->n_placements; f++) {
            int of_placement = 0;

            for (int c = 0; c < r->n_cameras; c++) {
                of_placement |= r->sees[f][c] << c;
            }
            reached |= (of_placement & reached) ? of_placement : 0;
        }
    }
    return reached == (1 << r->n_cameras) - 1;
}

/* Gives each camera its share of the placements. In a rig without a connection the first
 * and the last camera share none. */
static void choose_views(rig_case *r, test_rng *rng)
{
    memset(r->sees, 0, sizeof r->sees);
    for (int c = 0; c < r->n_cameras; c++) {
        const double share = test_uniform(rng, 0.3, 1);
        const int n = (int)(share * r->n_placements + 0.5);

        for (int i = 0; i < n;) {
            const int f = draw(rng, 0, r->n_placements - 1);

            i += !r->sees[f][c];
            r->sees[f][c] = 1;
        }
    }
    for (int f = 0; f < r->n_placements; f++) {
        int n = 0;

        if (r->is_apart) {
            r->sees[f][draw(rng, 0, 1) ? 0 : r->n_cameras - 1] = 0;
        }
        for (int c = 0; c < r->n_cameras; c++) {
            n += r->sees[f][c];
        }
        if (n == 0) {
            r->sees[f][draw(rng, 0, r->n_cameras - 1)] = 1;
        }
    }
}

/* Makes the views of a placement, the first of which is `first`. Returns their number; 0: a
 * point is outside an image. */
static size_t see_placement(rig_case *r, test_rng *rng, int placement, size_t first)
{
    size_t n = first;

    for (int c = 0; c < r->n_cameras; c++) {
        if (r->sees[placement][c]) {
            if (!see(r->seen[n], r, rng, c, placement)) {
                return 0;
            }
            r->views[n].view = VIEW(&r->camera[c], r->seen[n], NULL, r->n_points);
            r->views[n].camera = c;
            r->views[n].placement = placement;
            n++;
        }
    }
    return n - first;
}

/* Makes cameras, and placements that lie within the images of the cameras that see them.
 * Returns 0 if there are none. */
static int make_poses(rig_case *r, test_rng *rng)
{
    const rigcal_transform first = camera_pose(r, rng, 0);
    const rigcal_transform world_from_rig = test_inverse(&first);

    r->truth[0] = test_transform(NULL, NULL);
    for (int c = 1; c < r->n_cameras; c++) {
        const rigcal_transform camera = camera_pose(r, rng, c);

        r->truth[c] = test_times(&camera, &world_from_rig);
    }
    r->rig.n_views = 0;
    for (int f = 0; f < r->n_placements; f++) {
        size_t n = 0;

        for (int tries = 0; n == 0 && tries < TRIES; tries++) {
            r->truth[CAMERAS + f] = placement_pose(r, rng, &first);
            n = see_placement(r, rng, f, r->rig.n_views);
        }
        if (n == 0) {
            return 0;
        }
        r->rig.n_views += n;
    }
    return 1;
}

void rig_case_make(rig_case *r, test_rng *rng, int placements_max)
{
    const rigcal_rig nothing = {0};
    int tries = 0;

    r->n_cameras = draw(rng, 2, CAMERAS);
    r->n_placements = draw(rng, 5, placements_max);
    r->target = (target_kind)draw(rng, 0, TARGETS - 1);
    r->lens = (lens_kind)draw(rng, 0, LENSES - 1);
    r->is_apart = r->n_cameras > 2 && draw(rng, 0, 2) == 0;
    r->far = test_uniform(rng, 4, 8);
    for (int c = 0; c < r->n_cameras; c++) {
        const int any = draw(rng, 0, MIXED - 1);

        r->camera[c] = camera_of(rng, (r->lens == MIXED) ? (lens_kind)any : r->lens);
    }
    make_target(r, rng);
    r->rig = nothing;
    do {
        if (tries++ == TRIES) {
            fail("there is no such rig");
        }
        choose_views(r, rng);
    } while (!is_connected(r) || !make_poses(r, rng));

    r->rig.cams_from_rig = r->poses;
    r->rig.n_cameras = (size_t)r->n_cameras;
    r->rig.rig_from_placements = &r->poses[CAMERAS];
    r->rig.n_placements = (size_t)r->n_placements;
    r->rig.group = r->group;
    r->rig.views = r->views;
    r->rig.view_poses = r->own;
    r->rig.work = r->work;
    r->rig.work_capacity = sizeof r->work / sizeof r->work[0];
}

/* ---- starts -------------------------------------------------------------- */

int rig_case_solve_views(rig_case *r)
{
    rigcal_pose_options options;

    (void)rigcal_pose_defaults(&options);
    options.use_start = 1;
    options.sigma_px = RC(NOISE);
    for (size_t i = 0; i < r->rig.n_views; i++) {
        const rigcal_rig_view *const v = &r->views[i];
        rigcal_pose pose;
        size_t n;

        options.start = test_times(&r->truth[v->camera], &r->truth[CAMERAS + v->placement]);
        if (rigcal_pose_solve(&pose, 1, &n, NULL, &v->view, &options) < 0 ||
            rigcal_view_pose_make(&r->own[i], v, &pose.cam_from_world) != RIGCAL_OK) {
            return 0;
        }
    }
    return 1;
}

void rig_case_start_at_truth(rig_case *r)
{
    memcpy(r->poses, r->truth, sizeof r->poses);
}

void rig_case_start_composed(rig_case *r)
{
    char is_known[POSES] = {1};

    r->poses[0] = r->truth[0];
    for (int round = 0; round < r->n_cameras; round++) {
        for (size_t i = 0; i < r->rig.n_views; i++) {
            const rigcal_view_pose *const v = &r->own[i];
            const int c = v->camera, f = CAMERAS + v->placement;

            if (is_known[c] && !is_known[f]) {
                const rigcal_transform rig_from_cam = test_inverse(&r->poses[c]);

                r->poses[f] = test_times(&rig_from_cam, &v->cam_from_target);
            } else if (is_known[f] && !is_known[c]) {
                const rigcal_transform target_from_rig = test_inverse(&r->poses[f]);

                r->poses[c] = test_times(&v->cam_from_target, &target_from_rig);
            }
            is_known[c] = is_known[f] = (char)(is_known[c] || is_known[f]);
        }
    }
}
