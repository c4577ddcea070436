#include "test_watched.h"

#include <math.h>
#include <string.h>

static const double FOCAL = 800, ARC = 0.5, DISTANCE = 3;

/* ---- poses ------------------------------------------------------------------ */

static void turn_by(double R[9], const double w[3])
{
    const double angle = test_norm(w);
    double turn[9], out[9];

    if (angle > 0) {
        test_rotation_about(turn, w, angle);
        test_product(out, turn, R);
        memcpy(R, out, sizeof out);
    }
}

/* d = (w, dt): t becomes t + dt. */
static void step(watched_pose *pose, const double d[6])
{
    turn_by(pose->R, d);
    for (int k = 0; k < 3; k++) {
        pose->t[k] += d[3 + k];
    }
}

/* d = (w, ds): a turn about the body's own centre, then a shift. */
static void move(watched_pose *pose, const double d[6])
{
    double Rt[9], centre[3];

    test_transpose(Rt, pose->R);
    test_apply(centre, Rt, pose->t, NULL);
    turn_by(pose->R, d);
    test_apply(pose->t, pose->R, centre, &d[3]);
}

/* R <- 1.5 R - 0.5 R R^T R, so that rounding does not add up. */
static void tidy(double R[9])
{
    double Rt[9], RRt[9], RRtR[9];

    test_transpose(Rt, R);
    test_product(RRt, R, Rt);
    test_product(RRtR, RRt, R);
    for (int k = 0; k < 9; k++) {
        R[k] = 1.5 * R[k] - 0.5 * RRtR[k];
    }
}

/* Makes camera 0 the frame again: X_0 = R_0 X + t_0 for all. */
static void regauge(test_watched *w)
{
    const watched_pose frame = w->truth[0];

    for (int b = 0; b < w->n_cameras + w->n_targets; b++) {
        double Rt[9], R[9], shift[3];

        test_transpose(Rt, frame.R);
        test_product(R, w->truth[b].R, Rt);
        test_apply(shift, R, frame.t, NULL);
        tidy(R);
        memcpy(w->truth[b].R, R, sizeof R);
        for (int k = 0; k < 3; k++) {
            w->truth[b].t[k] -= shift[k];
        }
    }
}

/* ---- a rig ------------------------------------------------------------------- */

static void nominal(watched_pose *pose, test_rng *rng, int camera, int n, int is_parallel)
{
    static const double UP[3] = {0, 1, 0};
    const double a = n > 1 ? ARC * (2.0 * camera / (n - 1) - 1) : 0;
    double o[3] = {DISTANCE * sin(a), camera % 2 ? -0.25 : 0.25,
                   DISTANCE - DISTANCE * cos(a)};
    double z[3] = {-o[0], -o[1], DISTANCE - o[2]}, x[3], y[3], turn[3], minus[3];

    memset(pose, 0, sizeof *pose);
    if (is_parallel) {
        pose->R[0] = pose->R[4] = pose->R[8] = 1;
        pose->t[0] = -0.12 * camera;
        return;
    }
    for (int k = 0; k < 3; k++) {
        turn[k] = 0.02 * test_normal(rng);
        z[k] /= sqrt(o[0] * o[0] + o[1] * o[1] + (DISTANCE - o[2]) * (DISTANCE - o[2]));
    }
    test_cross(x, UP, z);
    const double length = test_norm(x);
    for (int k = 0; k < 3; k++) {
        x[k] /= length;
    }
    test_cross(y, z, x);
    memcpy(&pose->R[0], x, sizeof x);
    memcpy(&pose->R[3], y, sizeof y);
    memcpy(&pose->R[6], z, sizeof z);
    turn_by(pose->R, turn);
    test_apply(minus, pose->R, o, NULL);
    for (int k = 0; k < 3; k++) {
        pose->t[k] = -minus[k];
    }
}

static void mount(test_watched *w, int camera)
{
    rigcal_mounted_camera *const m = &w->cameras[camera];

    memset(m, 0, sizeof *m);
    m->camera = test_pinhole();
    m->camera.width = 1280;
    m->camera.height = 960;
    m->camera.fx = m->camera.fy = (rigcal_real)FOCAL;
    m->camera.cx = 640;
    m->camera.cy = 480;
    m->cam_from_rig = test_transform(w->truth[camera].R, w->truth[camera].t);
}

void test_watched_make(test_watched *w, test_rng *rng, int n_cameras, int is_parallel,
                       double sd_rad, double sd_t)
{
    const int n = 6 * (n_cameras - 1);

    memset(w, 0, sizeof *w);
    w->n_cameras = n_cameras;
    w->is_parallel = is_parallel;
    for (int c = 0; c < n_cameras; c++) {
        nominal(&w->truth[c], rng, c, n_cameras, is_parallel);
    }
    regauge(w);
    for (int c = 0; c < n_cameras; c++) {
        double d[6], R[9], t[3];

        mount(w, c);
        w->held[c] = c == 0;
        /* rounded, as the library has it */
        test_transform_parts(R, t, &w->cameras[c].cam_from_rig);
        memcpy(w->truth[c].R, R, sizeof R);
        memcpy(w->truth[c].t, t, sizeof t);
        for (int k = 0; k < 6 && c > 0; k++) {
            d[k] = (k < 3 ? sd_rad : sd_t) * test_normal(rng);
        }
        if (c > 0) {
            step(&w->truth[c], d);
        }
    }
    for (int i = 0; i < n; i++) {
        const double sd = i % 6 < 3 ? sd_rad : sd_t;

        w->Sigma[i * (i + 1) / 2 + i] = (rigcal_real)(sd * sd);
    }
    w->rig.cameras = w->cameras;
    w->rig.group = w->group;
    w->rig.held = w->held;
    w->rig.capacity = WATCHED_CAMERAS_MAX;
    w->rig.Sigma = w->Sigma;
    w->rig.Sigma_capacity = sizeof w->Sigma / sizeof w->Sigma[0];
    w->rig.n_cameras = (size_t)n_cameras;
    w->rig.sigma_px = RC(0.3);
}

void test_watched_begin(test_watched *w, int n_targets,
                        const rigcal_monitor_options *options)
{
    w->n_targets = n_targets;
    w->size = RIGCAL_MONITOR_SIZE(w->n_cameras, n_targets);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_begin(w->monitor, w->size, &w->rig,
                                                  (size_t)n_targets, options));
}

void test_watched_bump(test_watched *w, int body, const double d[6])
{
    move(&w->truth[body], d);
    if (body == 0) {
        regauge(w);
    }
}

void test_watched_walk(test_watched *w, test_rng *rng, double sd_rad, double sd_t)
{
    if (!(sd_rad > 0 || sd_t > 0)) {
        return;
    }
    for (int c = 0; c < w->n_cameras; c++) {
        double d[6];

        for (int k = 0; k < 6; k++) {
            d[k] = (k < 3 ? sd_rad : sd_t) * test_normal(rng);
        }
        move(&w->truth[c], d);
    }
    regauge(w);
}

/* ---- what cameras see ---------------------------------------------------------- */

void test_watched_point(double X[3], const test_watched *w, test_rng *rng)
{
    (void)w;
    for (int k = 0; k < 3; k++) {
        X[k] = test_uniform(rng, -1, 1) + (k == 2 ? DISTANCE : 0);
    }
}

void test_watched_pixel(double uv[2], const test_watched *w, int camera, const double X[3])
{
    double X_c[3];

    test_apply(X_c, w->truth[camera].R, X, w->truth[camera].t);
    uv[0] = FOCAL * X_c[0] / X_c[2] + 640;
    uv[1] = FOCAL * X_c[1] / X_c[2] + 480;
}

void test_watched_target_point(double X[3], const test_watched *w, int target,
                               const double X_w[3])
{
    const watched_pose *const pose = &w->truth[w->n_cameras + target];
    double Rt[9], from[3];

    test_transpose(Rt, pose->R);
    for (int k = 0; k < 3; k++) {
        from[k] = X_w[k] - pose->t[k];
    }
    test_apply(X, Rt, from, NULL);
}

void test_watched_hang(test_watched *w, test_rng *rng, int target, double shift)
{
    watched_pose *const pose = &w->truth[w->n_cameras + target];
    const double axis[3] = {test_normal(rng), test_normal(rng), test_normal(rng)};
    const double at[3] = {shift, -0.1, 2.5};
    double minus[3];

    test_rotation_about(pose->R, axis, 0.5);
    test_apply(minus, pose->R, at, NULL);
    for (int k = 0; k < 3; k++) {
        pose->t[k] = -minus[k];
    }
}

static void see(rigcal_real uv[2], const test_watched *w, int camera, const double X[3],
                test_rng *rng, double noise)
{
    double px[2];

    test_watched_pixel(px, w, camera, X);
    uv[0] = (rigcal_real)(px[0] + noise * test_normal(rng));
    uv[1] = (rigcal_real)(px[1] + noise * test_normal(rng));
}

void test_watched_see(rigcal_observation o[], const test_watched *w, int camera, int target,
                      double X_w[][3], int n, test_rng *rng, double noise_px)
{
    for (int i = 0; i < n; i++) {
        double X[3];

        test_watched_target_point(X, w, target, X_w[i]);
        test_to_real(o[i].X_w, X_w[i], 3);
        see(o[i].uv, w, camera, X, rng, noise_px);
    }
}

static void to_ray(rigcal_real ray[3], const rigcal_real uv[2])
{
    ray[0] = (rigcal_real)((D(uv[0]) - 640) / FOCAL);
    ray[1] = (rigcal_real)((D(uv[1]) - 480) / FOCAL);
    ray[2] = 1;
}

void test_watched_match(test_watched *w, test_rng *rng, const watched_matches *like)
{
    for (int i = 0; i < like->matches; i++) {
        const int a = (int)test_uniform(rng, 0, w->n_cameras);
        const int b = (a + 1 + (int)test_uniform(rng, 0, w->n_cameras - 1)) % w->n_cameras;
        const rigcal_real sigma_px = RC(0.3);
        double X[3];
        rigcal_real uv_a[2], uv_b[2], ray_a[3], ray_b[3];

        test_watched_point(X, w, rng);
        see(uv_a, w, a, X, rng, like->noise_px);
        see(uv_b, w, b, X, rng, like->noise_px);
        if (test_uniform(rng, 0, 1) < like->wrong) {
            uv_b[0] += (rigcal_real)test_uniform(rng, -40, 40);
            uv_b[1] += (rigcal_real)test_uniform(rng, -40, 40);
        }
        to_ray(ray_a, uv_a);
        to_ray(ray_b, uv_b);
        ASSERT_STATUS(RIGCAL_OK,
                      like->by_rays
                          ? rigcal_monitor_match_rays(w->monitor, (size_t)a, ray_a,
                                                      (size_t)b, ray_b, sigma_px)
                          : rigcal_monitor_match(w->monitor, (size_t)a, uv_a, (size_t)b,
                                                 uv_b, sigma_px));
    }
}

/* ---- against the truth ----------------------------------------------------------- */

void test_watched_error(double e[], test_watched *w)
{
    for (int c = 1; c < w->n_cameras; c++) {
        double R[9], t[3], Rt[9], D[9];
        rigcal_mounted_camera m;

        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_camera(&m, w->monitor, (size_t)c));
        test_transform_parts(R, t, &m.cam_from_rig);
        test_transpose(Rt, R);
        test_product(D, w->truth[c].R, Rt);
        const double v[3] = {(D[7] - D[5]) / 2, (D[2] - D[6]) / 2, (D[3] - D[1]) / 2};
        const double sine = test_norm(v), angle = asin(sine < 1 ? sine : 1);
        for (int k = 0; k < 3; k++) {
            e[6 * (c - 1) + k] = sine > 1e-9 ? v[k] * angle / sine : v[k];
            e[6 * (c - 1) + 3 + k] = w->truth[c].t[k] - t[k];
        }
    }
}

double test_watched_nees(test_watched *w, double e[])
{
    const int n = 6 * (w->n_cameras - 1);
    double L[WATCHED_FREE_MAX][WATCHED_FREE_MAX], y[WATCHED_FREE_MAX], sum = 0;

    test_watched_error(e, w);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_rig(&w->rig, w->monitor));
    for (int i = 0; i < n; i++) {
        y[i] = e[i];
        for (int j = 0; j <= i; j++) {
            double x = D(w->Sigma[i * (i + 1) / 2 + j]);

            for (int k = 0; k < j; k++) {
                x -= L[i][k] * L[j][k];
            }
            L[i][j] = i == j ? sqrt(x) : x / L[j][j];
        }
        for (int k = 0; k < i; k++) {
            y[i] -= L[i][k] * y[k];
        }
        y[i] /= L[i][i];
        sum += y[i] * y[i];
    }
    return sum;
}

double test_chi2_95(int n)
{
    const double c = 2 / (9.0 * n);

    return n * pow(1 - c + 1.6448536 * sqrt(c), 3);
}
