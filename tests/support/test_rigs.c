#include "test_rigs.h"

#include <string.h>

#include "test_fit.h"

static const rigcal_transform ORIGIN = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};

/* rig_from_camera of a camera that looks at the middle, 5 ahead of camera 0. */
static rigcal_transform camera_of(test_rng *rng, int index)
{
    const double angle = 0.35 * index + test_uniform(rng, -0.1, 0.1), far = 5;
    double turn[9], tilt[9], R[9], t[3];
    static const double up[3] = {0, 1, 0};
    const double axis[3] = {1, test_uniform(rng, -0.5, 0.5), test_uniform(rng, -1, 1)};

    test_rotation_about(turn, up, angle);
    test_rotation_about(tilt, axis, test_uniform(rng, -0.15, 0.15));
    test_product(R, tilt, turn);
    /* R (0, 0, far) + t is near (0, 0, far). */
    t[0] = -far * R[2] + test_uniform(rng, -0.3, 0.3);
    t[1] = -far * R[5] + test_uniform(rng, -0.3, 0.3);
    t[2] = far - far * R[8] + test_uniform(rng, -0.3, 0.3);
    return test_transform(R, t);
}

static rigcal_transform placement_of(test_rng *rng)
{
    double turn[9];
    const double axis[3] = {test_uniform(rng, -1, 1), test_uniform(rng, -1, 1), 0.3};
    const double t[3] = {test_uniform(rng, -0.6, 0.6), test_uniform(rng, -0.5, 0.5),
                         test_uniform(rng, 4.4, 5.6)};

    test_rotation_about(turn, axis, test_uniform(rng, -0.6, 0.6));
    return test_transform(turn, t);
}

void test_rig_random(test_rig *r, test_rng *rng, int n_cameras, int n_placements,
                     int n_points)
{
    memset(r, 0, sizeof *r);
    r->n_points = n_points;
    for (int c = 0; c < n_cameras; c++) {
        r->true_cams[c] = c ? camera_of(rng, c) : ORIGIN;
        r->camera[c] = test_pinhole();
        r->camera[c].width = 1280;
        r->camera[c].height = 960;
        r->camera[c].cx = RC(639.5);
        r->camera[c].cy = RC(479.5);
        r->camera[c].k1 = RC(-0.02 * c);
    }
    for (int f = 0; f < n_placements; f++) {
        r->true_places[f] = placement_of(rng);
    }
    for (int i = 0; i < n_points; i++) {
        for (int k = 0; k < 3; k++) { /* spread out, so that every view has enough
                                         information */
            r->X[i][k] =
                (double)(float)(((i >> k) & 1 ? 0.5 : -0.5) + test_uniform(rng, -0.2, 0.2));
        }
    }
    memcpy(r->cams, r->true_cams, sizeof r->cams);
    memcpy(r->places, r->true_places, sizeof r->places);
    r->rig.cams_from_rig = r->cams;
    r->rig.n_cameras = (size_t)n_cameras;
    r->rig.rig_from_placements = r->places;
    r->rig.n_placements = (size_t)n_placements;
    r->rig.group = r->group;
    r->rig.views = r->views;
    r->rig.work = r->work;
    r->rig.work_capacity = RIG_WORK;
}

rigcal_transform test_rig_chain(const test_rig *r, int camera, int placement)
{
    return test_times(&r->true_cams[camera], &r->true_places[placement]);
}

void test_rig_see(test_rig *r, test_rng *rng, int camera, int placement, double noise_px)
{
    const size_t v = r->rig.n_views++;
    double R_c[9], t_c[3], R_f[9], t_f[3];

    test_transform_parts(R_c, t_c, &r->true_cams[camera]);
    test_transform_parts(R_f, t_f, &r->true_places[placement]);
    for (int i = 0; i < r->n_points; i++) {
        double X_r[3], X_c[3], uv[2];

        test_apply(X_r, R_f, r->X[i], t_f);
        test_apply(X_c, R_c, X_r, t_c);
        test_project_px(uv, &r->camera[camera], X_c);
        test_to_real(r->o[v][i].X_w, r->X[i], 3);
        for (int k = 0; k < 2; k++) {
            r->o[v][i].uv[k] = RC(uv[k] + (noise_px > 0 ? noise_px * test_normal(rng) : 0));
        }
    }
    r->views[v].view = VIEW(&r->camera[camera], r->o[v], NULL, r->n_points);
    r->views[v].camera = camera;
    r->views[v].placement = placement;
    r->views[v].target = 0;
}

void test_rig_see_all(test_rig *r, test_rng *rng, double noise_px)
{
    r->rig.n_views = 0;
    for (int f = 0; f < (int)r->rig.n_placements; f++) {
        for (int c = 0; c < (int)r->rig.n_cameras; c++) {
            test_rig_see(r, rng, c, f, noise_px);
        }
    }
}

void test_rig_solve_views(test_rig *r)
{
    for (size_t v = 0; v < r->rig.n_views; v++) {
        rigcal_pose pose[RIGCAL_POSES_MAX];
        rigcal_pose_options options;
        size_t n;

        ASSERT_STATUS(RIGCAL_OK, rigcal_pose_defaults(&options));
        options.use_start = 1;
        options.start = test_rig_chain(r, r->views[v].camera, r->views[v].placement);
        TEST_ASSERT_TRUE(rigcal_pose_solve(pose, RIGCAL_POSES_MAX, &n, NULL,
                                           &r->views[v].view, &options) >= 0);
        ASSERT_STATUS(RIGCAL_OK, rigcal_view_pose_make(&r->own[v], &r->views[v],
                                                       &pose[0].cam_from_world));
    }
    r->rig.view_poses = r->own;
}

rigcal_transform test_moved(const rigcal_transform *origin, const double d[6])
{
    double R[9], t[3];

    test_transform_parts(R, t, origin);
    test_move(R, t, d);
    return test_transform(R, t);
}

void test_step_between(double d[6], const rigcal_transform *moved,
                       const rigcal_transform *origin)
{
    double R[9], t[3], R_0[9], t_0[3];

    test_transform_parts(R, t, moved);
    test_transform_parts(R_0, t_0, origin);
    test_difference(d, R_0, t_0, R, t);
}

static void start_at(rigcal_transform *pose, const rigcal_transform *truth, test_rng *rng,
                     double turn, double shift)
{
    double d[6];

    for (int k = 0; k < 6; k++) {
        d[k] = (k < 3 ? turn : shift) * test_normal(rng);
    }
    *pose = test_moved(truth, d);
}

void test_rig_start(test_rig *r, test_rng *rng, double turn, double shift)
{
    r->cams[0] = r->true_cams[0];
    for (size_t c = 1; c < r->rig.n_cameras; c++) {
        start_at(&r->cams[c], &r->true_cams[c], rng, turn, shift);
    }
    for (size_t f = 0; f < r->rig.n_placements; f++) {
        start_at(&r->places[f], &r->true_places[f], rng, turn, shift);
    }
}
