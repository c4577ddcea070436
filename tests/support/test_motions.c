#include "test_motions.h"

#include <math.h>
#include <string.h>

static const double ARC = 1.4; /* rad, at the distance 1 */

static rigcal_transform camera_at(test_rng *rng, int index, int n)
{
    const double azimuth = (index - 0.5 * (n - 1)) * ARC / fmax(n - 1, 1);
    const double z[3] = {-cos(azimuth), -sin(azimuth), 0.3 * test_uniform(rng, -1, 1)};
    const double up[3] = {0, 0, -1};
    double R[9], t[3];

    test_axes_of(R, up, z);
    test_apply(t, R, z, NULL);
    return test_transform(R, t);
}

/* The path of a hand. Each direction has three slow swings, so the path does not repeat. */
static void path_at(motion_path *p, test_rng *rng, const motion_scene *scene,
                    const rigcal_transform *first)
{
    const double z[3] = {1, 0.7 * test_uniform(rng, -1, 1), 0.7 * test_uniform(rng, -1, 1)};
    const double any[3] = {test_normal(rng), test_normal(rng), test_normal(rng)};
    const double t[3] = {0.2 * test_uniform(rng, -1, 1), 0.2 * test_uniform(rng, -1, 1),
                         0.12 * test_uniform(rng, -1, 1)};
    double rows[9], R[9], rms[2] = {0, 0};

    test_axes_of(rows, any, z);
    test_transpose(R, rows);
    const rigcal_transform place = test_transform(R, t), base = test_times(first, &place);
    test_transform_parts(p->base_R, p->base_t, &base);
    for (int k = 0; k < 6; k++) {
        p->rate[k] = 2 * TEST_PI * test_uniform(rng, 0.4, 1.2);
        p->phase[k] = test_uniform(rng, 0, 2 * TEST_PI);
        p->amplitude[k] = test_normal(rng);
        rms[k / 3] += p->amplitude[k] * p->amplitude[k] * p->rate[k] * p->rate[k] / 2;
    }
    for (int k = 0; k < 6; k++) {
        p->amplitude[k] *= (k < 3 ? scene->turn : scene->speed) / sqrt(rms[k / 3]);
    }
}

/* The place at the time t after the middle of the run. */
static rigcal_transform place_at(const motion_path *p, double t)
{
    double d[6], axis[3], turn[9], R[9];

    for (int k = 0; k < 6; k++) {
        d[k] = p->amplitude[k] * sin(p->rate[k] * t + p->phase[k]);
    }
    const double angle = test_norm(d);
    for (int k = 0; k < 3; k++) {
        axis[k] = angle > 0 ? d[k] / angle : (k == 0);
        d[3 + k] += p->base_t[k];
    }
    test_rotation_about(turn, axis, angle);
    test_product(R, turn, p->base_R);
    return test_transform(R, &d[3]);
}

rigcal_transform test_motions_at(const test_motions *m, int f, double after)
{
    return place_at(&m->paths[f], D(m->times[f]) - m->paths[f].middle + after);
}

static void see(test_motions *m, test_rng *rng, const motion_scene *scene, int camera,
                int f)
{
    const size_t v = m->rig.n_views++;
    const double stamp = D(m->times[f]) + scene->stamp * test_normal(rng);
    const double late = m->true_offsets[camera] +
                        m->true_drifts[camera] *
                            (D(m->times[f]) - D(m->times[m->rig.n_placements - 1]) / 2);
    const rigcal_transform place = test_motions_at(m, f, stamp - D(m->times[f]) + late);
    const rigcal_transform T = test_times(&m->true_cams[camera], &place);
    double R[9], t[3];

    test_transform_parts(R, t, &T);
    for (int i = 0; i < MOTION_POINTS; i++) {
        double X_c[3], uv[2];

        test_apply(X_c, R, m->X[i], t);
        test_project_px(uv, &m->camera, X_c);
        for (int k = 0; k < 2; k++) {
            uv[k] += scene->noise_px * test_normal(rng);
        }
        test_to_real(m->o[v][i].X_w, m->X[i], 3);
        test_to_real(m->o[v][i].uv, uv, 2);
    }
    m->views[v].view = VIEW(&m->camera, m->o[v], NULL, MOTION_POINTS);
    m->views[v].camera = camera;
    m->views[v].placement = f;
    m->view_times[v] = m->times[f];
}

static void connect(test_motions *m, const motion_scene *scene)
{
    m->rig.cams_from_rig = m->cams;
    m->rig.n_cameras = (size_t)scene->cameras;
    m->rig.rig_from_placements = m->places;
    m->rig.n_placements = (size_t)(scene->runs * scene->frames);
    m->rig.group = m->group;
    m->rig.views = m->views;
    m->rig.view_poses = m->own;
    m->rig.work = m->work;
    m->rig.work_capacity = MOTION_WORK;
    (void)rigcal_clocks_defaults(&m->clocks);
    m->clocks.times = m->times;
    m->clocks.instants = m->instants;
    m->clocks.offsets = m->offsets;
    m->clocks.states = m->states;
    m->clocks.free_offsets = 1;
}

void test_motions_make(test_motions *m, test_rng *rng, const motion_scene *scene)
{
    memset(m, 0, sizeof *m);
    connect(m, scene);
    m->camera = test_pinhole();
    m->camera.width = 1280;
    m->camera.height = 960;
    m->camera.cx = RC(639.5);
    m->camera.cy = RC(479.5);
    m->camera.k1 = RC(-0.12);
    m->camera.k2 = RC(0.05);
    m->camera.p1 = RC(0.0005);
    m->camera.p2 = RC(-0.0004);
    for (int i = 0; i < MOTION_POINTS; i++) {
        m->X[i][0] = (i % 5 - 2) * 0.05;
        m->X[i][1] = (i / 5 - 1.5) * 0.05;
    }
    for (int c = 0; c < scene->cameras; c++) {
        m->true_cams[c] = camera_at(rng, c, scene->cameras);
        m->true_offsets[c] = scene->offset * test_uniform(rng, -1, 1);
        m->true_drifts[c] = scene->drift * test_uniform(rng, -1, 1);
    }
    for (int c = scene->cameras - 1; c >= 0;
         c--) { /* the time of the first camera is the true time */
        m->true_offsets[c] -= m->true_offsets[0];
        m->true_drifts[c] -= m->true_drifts[0];
    }
    const rigcal_transform first = m->true_cams[0], world = test_inverse(&first);
    for (int c = 0; c < scene->cameras; c++) {
        m->true_cams[c] = test_times(&m->true_cams[c], &world);
    }
    for (int run = 0; run < scene->runs; run++) {
        motion_path *const path = &m->paths[run * scene->frames];

        path_at(path, rng, scene, &first);
        path->middle = run * scene->pause + (scene->frames - 1) / (2 * scene->fps);
        for (int i = 0; i < scene->frames; i++) {
            path[i] = *path;
            m->times[run * scene->frames + i] =
                (rigcal_real)(run * scene->pause + i / scene->fps);
        }
    }
    for (int f = 0; f < scene->runs * scene->frames; f++) {
        for (int c = 0; c < scene->cameras; c++) {
            see(m, rng, scene, c, f);
        }
    }
    test_motions_reset(m);
}

void test_motions_reset(test_motions *m)
{
    memcpy(m->cams, m->true_cams, sizeof m->cams);
    for (size_t f = 0; f < m->rig.n_placements; f++) {
        m->places[f] = test_motions_at(m, (int)f, 0);
    }
    memset(m->offsets, 0, sizeof m->offsets);
    memset(m->drifts, 0, sizeof m->drifts);
}

void test_motions_solve(test_motions *m)
{
    for (size_t v = 0; v < m->rig.n_views; v++) {
        const rigcal_rig_view *const view = &m->views[v];
        rigcal_pose_options options;
        rigcal_pose pose;
        size_t n;

        ASSERT_STATUS(RIGCAL_OK, rigcal_pose_defaults(&options));
        options.use_start = 1;
        options.start = test_times(&m->cams[view->camera], &m->places[view->placement]);
        TEST_ASSERT_TRUE(rigcal_pose_solve(&pose, 1, &n, NULL, &view->view, &options) >= 0);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_view_pose_make(&m->own[v], view, &pose.cam_from_world));
    }
}

/* ---- error over bound ----------------------------------------------------- */

enum { UNKNOWNS_MAX = 6 * (MOTION_CAMERAS_MAX - 1) };

/* A <- A^-1 by Gauss and Jordan, without pivots: A is positive definite. */
static void invert(double A[], int n)
{
    for (int p = 0; p < n; p++) {
        const double pivot = A[p * n + p];

        A[p * n + p] = 1;
        for (int j = 0; j < n; j++) {
            A[p * n + j] /= pivot;
        }
        for (int i = 0; i < n; i++) {
            const double part = A[i * n + p];

            if (i != p) {
                A[i * n + p] = 0;
                for (int j = 0; j < n; j++) {
                    A[i * n + j] -= part * A[p * n + j];
                }
            }
        }
    }
}

void test_motions_information(double inverse[], const test_motions *m, double sigma_px)
{
    rigcal_mounted_camera cameras[MOTION_CAMERAS_MAX];
    rigcal_real Sigma[RIGCAL_CALIBRATED_SIZE(MOTION_CAMERAS_MAX)];
    int32_t group[MOTION_CAMERAS_MAX];
    uint8_t held[MOTION_CAMERAS_MAX];
    rigcal_calibrated_rig kept = {0};
    const int n = 6 * ((int)m->rig.n_cameras - 1);

    kept.cameras = cameras;
    kept.group = group;
    kept.held = held;
    kept.capacity = MOTION_CAMERAS_MAX;
    kept.Sigma = Sigma;
    kept.Sigma_capacity = RIGCAL_CALIBRATED_SIZE(MOTION_CAMERAS_MAX);
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_calibrated_take(&kept, &m->rig, NULL, (rigcal_real)sigma_px));
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            inverse[i * n + j] = inverse[j * n + i] = D(Sigma[i * (i + 1) / 2 + j]);
        }
    }
    invert(inverse, n);
}

double test_motions_error2(const test_motions *m, const double inverse[])
{
    const int n = 6 * ((int)m->rig.n_cameras - 1);
    double d[UNKNOWNS_MAX], sum = 0;

    for (size_t c = 1; c < m->rig.n_cameras; c++) {
        double R[9], t[3], R_true[9], t_true[3], between[9], *const of = &d[6 * (c - 1)];

        test_transform_parts(R, t, &m->cams[c]);
        test_transform_parts(R_true, t_true, &m->true_cams[c]);
        test_transpose(between, R_true);
        test_product(R_true, R, between); /* next to 1 */
        of[0] = (R_true[7] - R_true[5]) / 2;
        of[1] = (R_true[2] - R_true[6]) / 2;
        of[2] = (R_true[3] - R_true[1]) / 2;
        for (int k = 0; k < 3; k++) {
            of[3 + k] = t[k] - t_true[k];
        }
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            sum += d[i] * inverse[i * n + j] * d[j];
        }
    }
    return sum / n;
}
