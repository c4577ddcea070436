#include "test_tags.h"

#include <math.h>
#include <string.h>

static const double TAG[4][3] = {
    {-0.5, 0.5, 0}, {0.5, 0.5, 0}, {0.5, -0.5, 0}, {-0.5, -0.5, 0}};

static void unit(double v[3])
{
    const double length = test_norm(v);

    for (int k = 0; k < 3; k++) {
        v[k] /= length;
    }
}

/* A camera of n on the arc. Its z axis meets the origin; its x axis is level, except for a
 * turn about z. */
static rigcal_transform camera_on_arc(test_rng *rng, int index, int n, double distance)
{
    static const double up[3] = {0, 0, 1}, ahead[3] = {0, 0, 1};
    const double azimuth = n > 1 ? (index - (n - 1) / 2.0) * 1.2 / (n - 1) : 0;
    double eye[3] = {distance * cos(azimuth), distance * sin(azimuth),
                     distance * 0.25 * test_uniform(rng, -1, 1)};
    double z[3], x[3], y[3], look[9], roll[9], R[9], t[3];

    for (int k = 0; k < 3; k++) {
        z[k] = -eye[k];
    }
    unit(z);
    test_cross(x, z, up);
    unit(x);
    test_cross(y, z, x);
    memcpy(&look[0], x, sizeof x);
    memcpy(&look[3], y, sizeof y);
    memcpy(&look[6], z, sizeof z);
    test_rotation_about(roll, ahead, test_uniform(rng, -0.3, 0.3));
    test_product(R, roll, look);
    test_apply(t, R, eye, NULL);
    for (int k = 0; k < 3; k++) {
        t[k] = -t[k];
    }
    return test_transform(R, t);
}

/* A tag whose normal is at most some 50 degrees from the middle of the arc. */
static rigcal_transform tag_placed(test_rng *rng)
{
    double z[3] = {1, 0.8 * test_uniform(rng, -1, 1), 0.8 * test_uniform(rng, -1, 1)};
    double any[3], x[3], y[3], R[9], t[3];

    unit(z);
    for (int k = 0; k < 3; k++) {
        any[k] = test_normal(rng);
    }
    test_cross(x, any, z);
    unit(x);
    test_cross(y, z, x);
    for (int k = 0; k < 3; k++) {
        R[3 * k] = x[k];
        R[3 * k + 1] = y[k];
        R[3 * k + 2] = z[k];
    }
    t[0] = 0.5 * test_uniform(rng, -1, 1);
    t[1] = 0.6 * test_uniform(rng, -1, 1);
    t[2] = 0.4 * test_uniform(rng, -1, 1);
    return test_transform(R, t);
}

static void see(test_tags *t, test_rng *rng, int camera, int placement)
{
    const size_t v = t->rig.n_views++;
    double R_c[9], t_c[3], R_f[9], t_f[3];

    test_transform_parts(R_c, t_c, &t->true_cams[camera]);
    test_transform_parts(R_f, t_f, &t->true_places[placement]);
    for (int i = 0; i < 4; i++) {
        rigcal_observation *const o = &t->o[4 * v + (size_t)i];
        double X_r[3], X_c[3], uv[2];

        test_apply(X_r, R_f, TAG[i], t_f);
        test_apply(X_c, R_c, X_r, t_c);
        test_project_px(uv, &t->camera, X_c);
        test_to_real(o->X_w, TAG[i], 3);
        for (int k = 0; k < 2; k++) {
            o->uv[k] = RC(uv[k] + t->noise_px * test_normal(rng));
        }
    }
    t->views[v] =
        (rigcal_rig_view){{&t->camera, &t->o[4 * v], NULL, 4}, camera, placement, 0};
}

void test_tags_random(test_tags *t, test_rng *rng, int n_cameras, int n_placements)
{
    rigcal_transform first;
    const size_t capacity = t->rig.work_capacity;

    t->camera = test_pinhole();
    t->camera.fx = t->camera.fy = RC(800);
    t->camera.width = 1280;
    t->camera.height = 960;
    t->camera.cx = RC(639.5);
    t->camera.cy = RC(479.5);
    for (int c = 0; c < n_cameras; c++) {
        t->true_cams[c] = camera_on_arc(rng, c, n_cameras, t->distance);
    }
    first = t->true_cams[0];
    for (int c = 0; c < n_cameras; c++) {
        const rigcal_transform back = test_inverse(&first);

        t->true_cams[c] = test_times(&t->true_cams[c], &back);
    }
    for (int f = 0; f < n_placements; f++) {
        const rigcal_transform placed = tag_placed(rng);

        t->true_places[f] = test_times(&first, &placed);
    }
    memset(&t->rig, 0, sizeof t->rig);
    t->rig.cams_from_rig = t->cams;
    t->rig.n_cameras = (size_t)n_cameras;
    t->rig.rig_from_placements = t->places;
    t->rig.n_placements = (size_t)n_placements;
    t->rig.group = t->group;
    t->rig.views = t->views;
    t->rig.view_poses = t->own;
    t->rig.work = t->work;
    t->rig.work_capacity = capacity;
    memset(&t->choice, 0, sizeof t->choice);
    t->choice.second_poses = t->second;
    t->choice.takes = t->takes;
    for (int f = 0; f < n_placements; f++) {
        for (int c = 0; c < n_cameras; c++) {
            if (test_uniform(rng, 0, 1) < t->share_seen) {
                see(t, rng, c, f);
            }
        }
    }
}

void test_tags_solve(test_tags *t)
{
    for (size_t v = 0; v < t->rig.n_views; v++) {
        const rigcal_rig_view *const view = &t->views[v];
        const rigcal_transform truth =
            test_times(&t->true_cams[view->camera], &t->true_places[view->placement]);
        rigcal_pose poses[RIGCAL_POSES_MAX];
        double R[9], R_true[9], nearest = 10;
        size_t n = 0;

        TEST_ASSERT_TRUE(
            rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n, NULL, &view->view, NULL) >= 0);
        test_transform_parts(R_true, NULL, &truth);
        memset(&t->second[v], 0, sizeof t->second[v]);
        for (size_t i = 0; i < n && i < 2; i++) {
            test_transform_parts(R, NULL, &poses[i].cam_from_world);
            if (test_angle_between(R, R_true) < nearest) {
                nearest = test_angle_between(R, R_true);
                t->right[v] = (uint8_t)i;
            }
            if (rigcal_view_pose_make(i ? &t->second[v] : &t->own[v], view,
                                      &poses[i].cam_from_world) != RIGCAL_OK) {
                TEST_ASSERT_EQUAL(1, i); /* then there is no second pose */
            }
        }
    }
}

int test_tags_wrong(const test_tags *t)
{
    int wrong = 0;

    for (size_t v = 0; v < t->rig.n_views; v++) {
        wrong += t->takes[v] != RIGCAL_TAKES_NONE && t->takes[v] != t->right[v];
    }
    return wrong;
}

int test_tags_left_out(const test_tags *t)
{
    int out = 0;

    for (size_t v = 0; v < t->rig.n_views; v++) {
        out += t->takes[v] == RIGCAL_TAKES_NONE;
    }
    return out;
}

int test_tags_wrong_first(const test_tags *t)
{
    int wrong = 0;

    for (size_t v = 0; v < t->rig.n_views; v++) {
        wrong += t->right[v] != 0;
    }
    return wrong;
}
