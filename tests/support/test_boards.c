#include "test_boards.h"

#include <math.h>
#include <string.h>

#include "test_fit.h"

static const double DISTANCE = 4, ARC = 1.2;

/* cam_from_world: on an arc about the origin; the camera looks at it. */
static rigcal_transform camera_at(test_rng *rng, int index, int n)
{
    const double azimuth = (index - 0.5 * (n - 1)) * ARC / fmax(n - 1, 1);
    const double eye[3] = {DISTANCE * cos(azimuth), DISTANCE * sin(azimuth),
                           DISTANCE * 0.25 * test_uniform(rng, -1, 1)};
    const double z[3] = {-eye[0], -eye[1], -eye[2]}, up[3] = {0, 0, -1};
    const double axis[3] = {0, 0, 1};
    double rows[9], roll[9], R[9], t[3];

    test_axes_of(rows, up, z);
    test_rotation_about(roll, axis, test_uniform(rng, -0.3, 0.3));
    test_product(R, roll, rows);
    test_apply(t, R, z, NULL);
    return test_transform(R, t);
}

/* world_from_placement: the board faces the arc. */
static rigcal_transform place_at(test_rng *rng)
{
    const double z[3] = {1, 0.8 * test_uniform(rng, -1, 1), 0.8 * test_uniform(rng, -1, 1)};
    const double any[3] = {test_normal(rng), test_normal(rng), test_normal(rng)};
    const double t[3] = {0.5 * test_uniform(rng, -1, 1), 0.6 * test_uniform(rng, -1, 1),
                         0.4 * test_uniform(rng, -1, 1)};
    double rows[9], R[9];

    test_axes_of(rows, any, z);
    test_transpose(R, rows);
    return test_transform(R, t);
}

static void see(test_boards *b, test_rng *rng, int camera, int placement, double noise_px,
                double pattern_px)
{
    const size_t v = b->rig.n_views++;
    const rigcal_transform T =
        test_times(&b->true_cams[camera], &b->true_places[placement]);
    double R[9], t[3], bend[4][2];

    TEST_ASSERT_TRUE(v < BOARD_VIEWS_MAX);
    test_transform_parts(R, t, &T);
    for (int k = 0; k < 8; k++) {
        bend[k / 2][k % 2] = pattern_px > 0 ? pattern_px * test_normal(rng) : 0;
    }
    for (int i = 0; i < BOARD_POINTS; i++) {
        const double x = b->X[i][0], y = b->X[i][1];
        double X_c[3], uv[2];

        test_apply(X_c, R, b->X[i], t);
        test_project_px(uv, &b->camera, X_c);
        for (int k = 0; k < 2; k++) {
            uv[k] += x * x * bend[0][k] + x * y * bend[1][k] + y * y * bend[2][k] +
                     x * x * x * bend[3][k] + noise_px * test_normal(rng);
        }
        test_to_real(b->o[v][i].X_w, b->X[i], 3);
        test_to_real(b->o[v][i].uv, uv, 2);
    }
    b->views[v].view = VIEW(&b->camera, b->o[v], NULL, BOARD_POINTS);
    b->views[v].camera = camera;
    b->views[v].placement = placement;
}

void test_boards_make(test_boards *b, test_rng *rng, int n_cameras, int n_places, int seen,
                      double noise_px, double pattern_px)
{
    memset(b, 0, sizeof *b);
    b->camera = test_pinhole();
    b->camera.width = 1280;
    b->camera.height = 960;
    b->camera.cx = RC(639.5);
    b->camera.cy = RC(479.5);
    for (int i = 0; i < BOARD_POINTS; i++) {
        b->X[i][0] = (i % 5 - 2) * 0.25;
        b->X[i][1] = (i / 5 - 1.5) * 0.25;
    }
    for (int c = 0; c < n_cameras; c++) {
        b->true_cams[c] = camera_at(rng, c, n_cameras);
    }
    const rigcal_transform first = b->true_cams[0], world = test_inverse(&first);
    for (int c = 0; c < n_cameras; c++) {
        b->true_cams[c] = test_times(&b->true_cams[c], &world);
    }
    for (int f = 0; f < n_places; f++) {
        const rigcal_transform place = place_at(rng);
        int n = 0;

        b->true_places[f] = test_times(&first, &place);
        for (int c = 0; c < n_cameras; c++) { /* the wanted number of cameras, at random */
            const int left = n_cameras - c;
            if (test_uniform(rng, 0, 1) * left < seen - n) {
                see(b, rng, c, f, noise_px, pattern_px);
                n++;
            }
        }
    }
    b->rig.cams_from_rig = b->cams;
    b->rig.n_cameras = (size_t)n_cameras;
    b->rig.rig_from_placements = b->places;
    b->rig.n_placements = (size_t)n_places;
    b->rig.group = b->group;
    b->rig.views = b->views;
    b->rig.view_poses = b->own;
    b->rig.work = b->work;
    b->rig.work_capacity = BOARD_WORK;
    b->choice.takes = b->takes;
}

int test_boards_view(const test_boards *b, int camera, int placement)
{
    for (size_t v = 0; v < b->rig.n_views; v++) {
        if (b->views[v].camera == camera && b->views[v].placement == placement) {
            return (int)v;
        }
    }
    return -1;
}

static void copy_pixels(rigcal_observation to[], const rigcal_observation from[])
{
    for (int i = 0; i < BOARD_POINTS; i++) {
        memcpy(to[i].uv, from[i].uv, sizeof to[i].uv);
    }
}

void test_boards_replace(test_boards *b, int v, int from)
{
    copy_pixels(b->o[v], b->o[from]);
    b->is_wrong[v] = 1;
}

void test_boards_reverse(test_boards *b, int v)
{
    rigcal_observation before[BOARD_POINTS];

    memcpy(before, b->o[v], sizeof before);
    for (int i = 0; i < BOARD_POINTS; i++) {
        memcpy(b->o[v][i].uv, before[BOARD_POINTS - 1 - i].uv, sizeof before[i].uv);
    }
    b->is_wrong[v] = 1;
}

void test_boards_swap(test_boards *b, int v, int other)
{
    rigcal_observation before[BOARD_POINTS];

    memcpy(before, b->o[v], sizeof before);
    copy_pixels(b->o[v], b->o[other]);
    copy_pixels(b->o[other], before);
    b->is_wrong[v] = b->is_wrong[other] = 1;
}

void test_boards_late(test_boards *b, int camera)
{
    size_t n = 0;

    for (int f = (int)b->rig.n_placements - 1; f > 0; f--) {
        test_boards_replace(b, test_boards_view(b, camera, f),
                            test_boards_view(b, camera, f - 1));
    }
    const int gone = test_boards_view(b, camera, 0);
    for (size_t v = 0; v < b->rig.n_views; v++) {
        if ((int)v != gone) {
            memmove(b->o[n], b->o[v], sizeof b->o[n]);
            b->views[n] = b->views[v];
            b->views[n].view.observations = b->o[n];
            b->is_wrong[n] = b->is_wrong[v];
            n++;
        }
    }
    b->rig.n_views = n;
}

rigcal_camera test_boards_lens(const test_boards *b, test_rng *rng,
                               const rigcal_intrinsics_sigma *sigma)
{
    rigcal_camera c = b->camera;
    const double focal = D(sigma->focal) * test_normal(rng);
    const double aspect = D(sigma->aspect) * test_normal(rng);

    c.fx = RC(D(c.fx) * (1 + focal + aspect / 2));
    c.fy = RC(D(c.fy) * (1 + focal - aspect / 2));
    c.cx = RC(D(c.cx) + D(sigma->centre) * test_normal(rng));
    c.cy = RC(D(c.cy) + D(sigma->centre) * test_normal(rng));
    c.k1 = RC(D(c.k1) + D(sigma->k1) * test_normal(rng));
    c.k2 = RC(D(c.k2) + D(sigma->k2) * test_normal(rng));
    return c;
}

void test_boards_solve_view(test_boards *b, int v)
{
    rigcal_pose poses[RIGCAL_POSES_MAX];
    size_t n;

    TEST_ASSERT_TRUE(
        rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n, NULL, &b->views[v].view, NULL) >= 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_view_pose_make(&b->own[v], &b->views[v],
                                                   &poses[0].cam_from_world));
}

void test_boards_solve(test_boards *b)
{
    for (size_t v = 0; v < b->rig.n_views; v++) {
        test_boards_solve_view(b, (int)v);
    }
    memcpy(b->cams, b->true_cams, sizeof b->cams);
    memcpy(b->places, b->true_places, sizeof b->places);
}

void test_boards_join(test_boards *b, double noise_px)
{
    for (size_t v = 0; v < b->rig.n_views; v++) {
        const rigcal_transform T = test_times(&b->true_cams[b->views[v].camera],
                                              &b->true_places[b->views[v].placement]);
        double R[9], t[3], R_0[9], t_0[3], d[6], apart = 0;

        test_transform_parts(R, t, &b->own[v].cam_from_target);
        test_transform_parts(R_0, t_0, &T);
        test_difference(d, R_0, t_0, R, t);
        for (int i = 0; i < 36; i++) {
            apart +=
                d[i / 6] * test_in_blocks(b->own[v].information, i / 6, i % 6) * d[i % 6];
        }
        b->takes[v] = apart > 30 * noise_px * noise_px ? RIGCAL_TAKES_NONE : 0;
    }
}

double test_boards_error(const test_boards *b, rigcal_real sigma_px)
{
    double sum = 0;
    int n = 0;

    for (size_t a = 0; a < b->rig.n_cameras; a++) {
        for (size_t c = a + 1; c < b->rig.n_cameras; c++) {
            const rigcal_transform inverse = test_inverse(&b->true_cams[a]),
                                   truth = test_times(&b->true_cams[c], &inverse);
            rigcal_transform seen;
            rigcal_real Sigma[36];
            double d[6], S[36], R[9], t[3], R_0[9], t_0[3];

            if (b->group[c] == b->group[a]) {
                ASSERT_STATUS(RIGCAL_OK,
                              rigcal_rig_pair(&seen, Sigma, &b->rig, sigma_px, a, c));
                test_transform_parts(R, t, &seen);
                test_transform_parts(R_0, t_0, &truth);
                test_difference(d, R_0, t_0, R, t);
                test_to_double(S, Sigma, 36);
                sum += test_squared_distance(d, S, 6) / 6;
                n++;
            }
        }
    }
    return sqrt(sum / n);
}
