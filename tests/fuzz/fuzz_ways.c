/* Results that can be had in a second way: costs by formulas of this file, minima by trying
 * places beside them, two views by two functions, and double by float.
 *
 * The scenes are such as cameras see. The bytes choose within them. All numbers are floats,
 * so that both precisions have the same input. */
#include <math.h>
#include <string.h>

#include "fuzz_narrow.h"
#include "fuzz_rigs.h"

enum { WIDTH = 1280, HEIGHT = 960 };

/* ---- scenes ------------------------------------------------------------------- */

/* A number of -range .. range, from two bytes. */
static float within(double range, fuzz_bytes *bytes)
{
    const int low = fuzz_byte(bytes);

    return (float)(range * ((256 * fuzz_byte(bytes) + low) / 32768. - 1));
}

static void make_camera(narrow_camera *c, fuzz_bytes *bytes)
{
    memset(c, 0, sizeof *c);
    c->lens = fuzz_below(bytes, 2);
    c->width = WIDTH;
    c->height = HEIGHT;
    c->numbers[0] = 1000 + within(300, bytes);
    c->numbers[1] = c->numbers[0] + within(10, bytes);
    c->numbers[2] = WIDTH / 2 + within(40, bytes);
    c->numbers[3] = HEIGHT / 2 + within(40, bytes);
    if (c->lens == RIGCAL_LENS_FISHEYE) {
        c->numbers[4] = within(0.05, bytes);
        c->numbers[5] = within(0.01, bytes);
        c->numbers[8] = within(0.003, bytes);
        c->numbers[9] = within(0.001, bytes);
    } else if (fuzz_below(bytes, 4) > 0) {
        c->numbers[4] = within(0.1, bytes);
        c->numbers[5] = within(0.02, bytes);
        c->numbers[6] = within(0.002, bytes);
        c->numbers[7] = within(0.002, bytes);
        c->numbers[8] = within(0.005, bytes);
    }
}

static rigcal_camera wide_camera(const narrow_camera *c)
{
    rigcal_real numbers[12];
    rigcal_camera camera;
    int i;

    for (i = 0; i < 12; i++) {
        numbers[i] = c->numbers[i];
    }
    camera.lens = c->lens;
    camera.width = c->width;
    camera.height = c->height;
    fuzz_camera_set(&camera, numbers);
    return camera;
}

/* R = exp([w]x), by Rodrigues' formula. */
static void rotation_of(double R[9], const double w[3])
{
    const double angle = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    const double s = angle > 0 ? sin(angle) / angle : 1;
    const double c = angle > 0 ? (1 - cos(angle)) / (angle * angle) : 0.5;
    const double K[9] = {0, -w[2], w[1], w[2], 0, -w[0], -w[1], w[0], 0};
    int i, j, k;

    for (i = 0; i < 3; i++) {
        for (j = 0; j < 3; j++) {
            R[3 * i + j] = (i == j) + s * K[3 * i + j];
            for (k = 0; k < 3; k++) {
                R[3 * i + j] += c * K[3 * i + k] * K[3 * k + j];
            }
        }
    }
}

/* A pose with the origin of the points `far` ahead, and rotated by up to `turn`. */
static void make_pose(narrow_pose *pose, double turn, double far, fuzz_bytes *bytes)
{
    double w[3], R[9];
    int i;

    for (i = 0; i < 3; i++) {
        w[i] = within(turn, bytes);
        pose->t[i] = within(0.2 * far, bytes);
    }
    pose->t[2] += (float)far;
    rotation_of(R, w);
    for (i = 0; i < 9; i++) {
        pose->R[i] = (float)R[i];
    }
}

static rigcal_transform wide_pose(const narrow_pose *pose)
{
    rigcal_transform wide;
    int i;

    for (i = 0; i < 9; i++) {
        wide.R[i] = pose->R[i];
    }
    for (i = 0; i < 3; i++) {
        wide.t[i] = pose->t[i];
    }
    return wide;
}

/* X_b = R X_a + t */
static void place(double X_b[3], const double R[9], const double t[3], const double X_a[3])
{
    int i, j;

    for (i = 0; i < 3; i++) {
        X_b[i] = t[i];
        for (j = 0; j < 3; j++) {
            X_b[i] += R[3 * i + j] * X_a[j];
        }
    }
}

/* The squared tangent of the angle off the axis up to which no lens of make_camera folds:
 * there 3 |k1| s + 5 |k2| s^2 + 7 |k3| s^3 and the rest is below 1. */
#define SEEN 1.5

/* The pixel of a point in the camera's frame, by the formulas of the header. Returns 0 if
 * it is not ahead, too far off the axis, or not in the image. */
static int project(double uv[2], const narrow_camera *c, const double X[3])
{
    const float *n = c->numbers;
    double x = X[0] / X[2], y = X[1] / X[2], s = x * x + y * y;

    if (!(X[2] > 0.01 && s <= SEEN)) {
        return 0;
    }
    if (c->lens == RIGCAL_LENS_FISHEYE) {
        const double theta = atan(sqrt(s)), q = theta * theta;
        const double d = s > 0 ? theta / sqrt(s) : 1;
        const double f = d * (1 + q * (n[4] + q * (n[5] + q * (n[8] + q * (double)n[9]))));

        x *= f;
        y *= f;
    } else {
        const double d = 1 + s * (n[4] + s * (n[5] + s * (double)n[8]));
        const double xd = x * d + 2 * n[6] * x * y + n[7] * (s + 2 * x * x);

        y = y * d + n[6] * (s + 2 * y * y) + 2 * n[7] * x * y;
        x = xd;
    }
    uv[0] = n[0] * x + n[2];
    uv[1] = n[1] * y + n[3];
    return uv[0] >= 0 && uv[0] < WIDTH && uv[1] >= 0 && uv[1] < HEIGHT;
}

/* The pixel of X_c with noise of up to `noise`. Returns 0 if there is none. */
static int see(float uv[2], const narrow_camera *c, const double X_c[3], double noise,
               fuzz_bytes *bytes)
{
    double exact[2];
    int k;

    if (!project(exact, c, X_c)) {
        return 0;
    }
    for (k = 0; k < 2; k++) {
        uv[k] = (float)exact[k] + (float)noise * within(1, bytes);
    }
    return 1;
}

/* The squared distance of the pixel of X_c from uv; huge if there is none. */
static double error2(const narrow_camera *c, const double X_c[3], const float uv[2])
{
    double made[2];

    return project(made, c, X_c) ? (made[0] - uv[0]) * (made[0] - uv[0]) +
                                       (made[1] - uv[1]) * (made[1] - uv[1])
                                 : 1e30;
}

/* ---- the lens ----------------------------------------------------------------- */

static void check_lens(fuzz_bytes *bytes)
{
    narrow_camera narrow;
    float X[3];
    double wide[3], uv[2], by_float[3];
    rigcal_real made[2], ray[3];
    int i;

    make_camera(&narrow, bytes);
    const rigcal_camera camera = wide_camera(&narrow);
    X[0] = within(1, bytes);
    X[1] = within(1, bytes);
    X[2] = 2 + within(1, bytes);
    for (i = 0; i < 3; i++) {
        wide[i] = X[i];
    }
    if (!project(uv, &narrow, wide)) {
        return;
    }
    PROMISE(rigcal_camera_project(made, &camera, wide) == RIGCAL_OK);
    PROMISE(hypot(made[0] - uv[0], made[1] - uv[1]) < 1e-9);
    PROMISE(narrow_project(by_float, &narrow, X) == RIGCAL_OK);
    PROMISE(hypot(by_float[0] - uv[0], by_float[1] - uv[1]) < 2e-3);
    const float pixel[2] = {(float)uv[0], (float)uv[1]};
    made[0] = pixel[0];
    made[1] = pixel[1];
    PROMISE(rigcal_camera_ray(ray, &camera, made) == RIGCAL_OK);
    PROMISE(narrow_ray(by_float, &narrow, pixel) == RIGCAL_OK);
    for (i = 0; i < 3; i++) { /* 2e-3 px of a focal length of 700, where it magnifies */
        PROMISE(fabs(by_float[i] - ray[i]) < 1e-5);
    }
}

/* ---- the pose ----------------------------------------------------------------- */

typedef struct {
    narrow_camera camera;
    int n;
    float X[NARROW_POINTS][3], uv[NARROW_POINTS][2];
} narrow_view;

static double pose_cost(const narrow_view *v, const double R[9], const double t[3])
{
    double sum = 0;
    int i;

    for (i = 0; i < v->n; i++) {
        const double X[3] = {v->X[i][0], v->X[i][1], v->X[i][2]};
        double X_c[3];

        place(X_c, R, t, X);
        sum += error2(&v->camera, X_c, v->uv[i]);
    }
    return sum;
}

/* The pose after a step of d: a rotation vector, which turns the camera's frame about
 * `pivot`, and a translation. */
static void moved(double R_moved[9], double t_moved[3], const double R[9],
                  const double t[3], const double pivot[3], const double d[6])
{
    double turn[9];
    int i, j, k;

    rotation_of(turn, d);
    for (i = 0; i < 3; i++) {
        t_moved[i] = pivot[i] + d[3 + i];
        for (j = 0; j < 3; j++) {
            R_moved[3 * i + j] = 0;
            t_moved[i] += turn[3 * i + j] * (t[j] - pivot[j]);
            for (k = 0; k < 3; k++) {
                R_moved[3 * i + j] += turn[3 * i + k] * R[3 * k + j];
            }
        }
    }
}

/* No step from a minimum lowers the cost. The minimum is found to rounding: the part of the
 * cost that is allowed is far below what noise can tell. */
static void check_minimum(const narrow_view *v, const double R[9], const double t[3])
{
    const double cost = pose_cost(v, R, t), zero[3] = {0, 0, 0};
    int k;

    for (k = 0; k < 12; k++) {
        double d[6] = {0, 0, 0, 0, 0, 0}, R_moved[9], t_moved[3];

        d[k / 2] = (k % 2 == 0 ? 1e-4 : -1e-4) * (k < 6 ? 1 : t[2]);
        moved(R_moved, t_moved, R, t, k < 6 ? t : zero, d);
        PROMISE(pose_cost(v, R_moved, t_moved) >= cost - 1e-6 * (1 + cost));
    }
}

static int make_view(narrow_view *v, fuzz_bytes *bytes)
{
    const double size = 0.3, noise = 0.5 * fuzz_below(bytes, 4);
    const int is_flat = fuzz_below(bytes, 2);
    narrow_pose pose;
    int i, k;

    make_camera(&v->camera, bytes);
    make_pose(&pose, 2, 1.5, bytes);
    const rigcal_transform cam_from_world = wide_pose(&pose);
    v->n = 4 + fuzz_below(bytes, NARROW_POINTS - 3);
    for (i = 0; i < v->n; i++) {
        double X[3], X_c[3];

        for (k = 0; k < 3; k++) {
            v->X[i][k] = k == 2 && is_flat ? 0 : within(size, bytes);
            X[k] = v->X[i][k];
        }
        place(X_c, cam_from_world.R, cam_from_world.t, X);
        if (!see(v->uv[i], &v->camera, X_c, noise, bytes)) {
            return 0;
        }
    }
    return 1;
}

static void check_pose(fuzz_bytes *bytes)
{
    narrow_view v;
    rigcal_observation observations[NARROW_POINTS];
    rigcal_pose poses[RIGCAL_POSES_MAX];
    double by_float[RIGCAL_POSES_MAX][12], least = 1e30;
    size_t n_found, p;
    int n_float, i, k;

    if (!make_view(&v, bytes)) {
        return;
    }
    const rigcal_camera camera = wide_camera(&v.camera);
    const rigcal_view view = {&camera, observations, NULL, (size_t)v.n};
    for (i = 0; i < v.n; i++) {
        for (k = 0; k < 3; k++) {
            observations[i].X_w[k] = v.X[i][k];
        }
        observations[i].uv[0] = v.uv[i][0];
        observations[i].uv[1] = v.uv[i][1];
    }
    const rigcal_status status =
        rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, NULL, &view, NULL);
    const rigcal_status narrow =
        narrow_solve(by_float, &n_float, &v.camera, v.X, v.uv, v.n);
    for (p = 0; status >= 0 && p < n_found; p++) {
        const rigcal_transform *T = &poses[p].cam_from_world;
        const double cost = pose_cost(&v, T->R, T->t);

        if (cost >= 1e30) { /* a point is outside the image */
            return;
        }
        PROMISE(fabs(cost - poses[p].sse) <= 1e-6 * (1 + cost));
        PROMISE(fabs(poses[p].rms_px - sqrt(poses[p].sse / v.n)) <=
                1e-9 * (1 + poses[p].rms_px));
        if (status != RIGCAL_BUDGET_SPENT && status != RIGCAL_VAGUE) {
            check_minimum(&v, T->R, T->t);
        }
    }
    if (status != RIGCAL_OK || narrow != RIGCAL_OK) {
        return;
    }
    for (i = 0; i < n_float; i++) {
        least = fmin(least, pose_cost(&v, &by_float[i][0], &by_float[i][9]));
    }
    /* Each pixel of the pose in float is right to a hundredth. */
    PROMISE(sqrt(least / v.n) <= poses[0].rms_px + 0.01);
}

/* ---- a point ------------------------------------------------------------------ */

typedef struct {
    int n;
    narrow_camera cameras[NARROW_CAMERAS];
    narrow_pose poses[NARROW_CAMERAS];
    float uv[NARROW_CAMERAS][2];
    rigcal_camera wide_cameras[NARROW_CAMERAS];
    rigcal_transform wide_poses[NARROW_CAMERAS];
    rigcal_real wide_uv[2 * NARROW_CAMERAS];
} narrow_sightings;

/* m: a pixel's noise moves a well-fixed point, some 2 m away, by less. */
#define FIXED 0.02

static double point_cost(const narrow_sightings *s, const double X[3])
{
    double sum = 0;
    int c;

    for (c = 0; c < s->n; c++) {
        double X_c[3];

        place(X_c, s->wide_poses[c].R, s->wide_poses[c].t, X);
        sum += error2(&s->cameras[c], X_c, s->uv[c]);
    }
    return sum;
}

static int make_sightings(narrow_sightings *s, fuzz_bytes *bytes)
{
    const double noise = 0.5 * fuzz_below(bytes, 4);
    double X[3];
    int c, k;

    s->n = 2 + fuzz_below(bytes, NARROW_CAMERAS - 1);
    for (k = 0; k < 3; k++) {
        X[k] = within(0.3, bytes);
    }
    for (c = 0; c < s->n; c++) {
        double X_c[3];

        make_camera(&s->cameras[c], bytes);
        make_pose(&s->poses[c], 1, 2, bytes);
        s->wide_cameras[c] = wide_camera(&s->cameras[c]);
        s->wide_poses[c] = wide_pose(&s->poses[c]);
        place(X_c, s->wide_poses[c].R, s->wide_poses[c].t, X);
        if (!see(s->uv[c], &s->cameras[c], X_c, noise, bytes)) {
            return 0;
        }
        for (k = 0; k < 2; k++) {
            s->wide_uv[2 * c + k] = s->uv[c][k];
        }
    }
    return 1;
}

/* The point from the depths along two rays, which is not the most likely one, must not be
 * more likely than that. */
static void check_two_views(const narrow_sightings *s, double cost)
{
    rigcal_transform b_from_a;
    rigcal_real ray_a[3], ray_b[3], depth_ab[2], miss;
    double X[3] = {0, 0, 0};
    int i, j;

    if (rigcal_transform_between(&b_from_a, &s->wide_poses[1], &s->wide_poses[0]) !=
            RIGCAL_OK ||
        rigcal_camera_ray(ray_a, &s->wide_cameras[0], &s->wide_uv[0]) != RIGCAL_OK ||
        rigcal_camera_ray(ray_b, &s->wide_cameras[1], &s->wide_uv[2]) != RIGCAL_OK ||
        rigcal_depth_two_views(depth_ab, &miss, &b_from_a, ray_a, ray_b) != RIGCAL_OK) {
        return;
    }
    for (i = 0; i < 3; i++) { /* R^T (depth ray - t) */
        for (j = 0; j < 3; j++) {
            X[i] += s->wide_poses[0].R[3 * j + i] *
                    (depth_ab[0] * ray_a[j] - s->wide_poses[0].t[j]);
        }
    }
    PROMISE(cost <= point_cost(s, X) + 1e-6);
}

/* The same point by the function for a calibrated rig, if its cameras are known exactly. */
static void check_measure(const narrow_sightings *s, const rigcal_point *triangulated)
{
    enum { WORK = RIGCAL_POINT_WORK(NARROW_CAMERAS) };
    static rigcal_real work[WORK];
    rigcal_mounted_camera cameras[NARROW_CAMERAS];
    rigcal_sighting seen[NARROW_CAMERAS];
    int32_t group[NARROW_CAMERAS] = {0, 0, 0};
    uint8_t held[NARROW_CAMERAS] = {1, 1, 1}, used[NARROW_CAMERAS];
    rigcal_calibrated_rig rig;
    rigcal_sightings sightings;
    rigcal_measured_point point;
    int c;

    memset(&rig, 0, sizeof rig);
    memset(&sightings, 0, sizeof sightings);
    memset(&point, 0, sizeof point);
    for (c = 0; c < s->n; c++) {
        memset(&cameras[c], 0, sizeof cameras[c]);
        cameras[c].camera = s->wide_cameras[c];
        cameras[c].cam_from_rig = s->wide_poses[c];
        seen[c].camera = c;
        seen[c].uv[0] = s->wide_uv[2 * c];
        seen[c].uv[1] = s->wide_uv[2 * c + 1];
    }
    rig.cameras = cameras;
    rig.group = group;
    rig.held = held;
    rig.capacity = NARROW_CAMERAS;
    rig.n_cameras = (size_t)s->n;
    rig.sigma_px = 1;
    sightings.rig = &rig;
    sightings.seen = seen;
    sightings.n = (size_t)s->n;
    sightings.keep_all = 1;
    sightings.work = work;
    sightings.work_capacity = WORK;
    if (rigcal_point_measure(&point, used, &sightings) == RIGCAL_OK) {
        const double cost = point_cost(s, point.X);
        const double other = point_cost(s, triangulated->X);

        PROMISE(fabs(cost - other) <= 1e-6 * (1 + other));
        PROMISE(fabs(point.chi2 - cost) <= 1e-6 * (1 + cost));
    }
}

static void check_point(fuzz_bytes *bytes)
{
    narrow_sightings s;
    rigcal_point point;
    double by_float[3];
    int k;

    if (!make_sightings(&s, bytes)) {
        return;
    }
    const rigcal_status status = rigcal_point_triangulate(
        &point, s.wide_cameras, s.wide_poses, s.wide_uv, (size_t)s.n, 1);
    const rigcal_status narrow =
        narrow_triangulate(by_float, s.cameras, s.poses, s.uv, s.n);
    const double cost = status == RIGCAL_OK ? point_cost(&s, point.X) : 1e30;
    if (cost >= 1e30) { /* or the point is outside an image */
        return;
    }
    PROMISE(fabs(cost - s.n * point.rms_px * point.rms_px) <= 1e-9 * (1 + cost));
    for (k = 0; k < 6; k++) {
        double X[3] = {point.X[0], point.X[1], point.X[2]};

        X[k / 2] += k % 2 == 0 ? 1e-4 : -1e-4;
        PROMISE(point_cost(&s, X) >= cost - 1e-6 * (1 + cost));
    }
    if (s.n == 2) {
        check_two_views(&s, cost);
    }
    check_measure(&s, &point);
    /* Where the rays are nearly parallel, float loses the depth. */
    if (narrow == RIGCAL_OK &&
        point.Sigma[0] + point.Sigma[4] + point.Sigma[8] < FIXED * FIXED) {
        PROMISE(sqrt(point_cost(&s, by_float) / s.n) <= point.rms_px + 0.01);
    }
}

/* ---- a rig -------------------------------------------------------------------- */

static double rig_cost(const fuzz_rig *made, const narrow_camera cameras[])
{
    double sum = 0;
    size_t i, k;

    for (i = 0; i < made->rig.n_views; i++) {
        const rigcal_rig_view *view = &made->views[i];
        const rigcal_transform *cam = &made->cams_from_rig[view->camera];
        const rigcal_transform *target = &made->rig_from_placements[view->placement];

        for (k = 0; k < view->view.n; k++) {
            const rigcal_observation *o = &view->view.observations[k];
            const float uv[2] = {(float)o->uv[0], (float)o->uv[1]};
            double X_r[3], X_c[3];

            place(X_r, target->R, target->t, o->X_w);
            place(X_c, cam->R, cam->t, X_r);
            sum += error2(&cameras[view->camera], X_c, uv);
        }
    }
    return sum;
}

/* The target of a rig and a camera that looks at it. */
typedef struct {
    const narrow_camera *camera;
    rigcal_transform cam_from_rig, rig_from_target;
    double noise;
} narrow_sight;

/* Returns 0 if a point is not seen. */
static int see_target(rigcal_observation o[], const narrow_sight *sight, float points[][3],
                      fuzz_bytes *bytes)
{
    const rigcal_transform *cam = &sight->cam_from_rig, *target = &sight->rig_from_target;
    size_t i, k;

    for (i = 0; i < RIG_POINTS; i++) {
        double X_r[3], X_c[3];
        float uv[2];

        for (k = 0; k < 3; k++) {
            o[i].X_w[k] = points[i][k];
        }
        place(X_r, target->R, target->t, o[i].X_w);
        place(X_c, cam->R, cam->t, X_r);
        if (!see(uv, sight->camera, X_c, sight->noise, bytes)) {
            return 0;
        }
        for (k = 0; k < 2; k++) {
            o[i].uv[k] = uv[k];
        }
    }
    return 1;
}

/* Sees the target of six points in every placement. Returns 0 if a point is not seen. */
static int make_rig(fuzz_rig *made, narrow_camera cameras[], fuzz_bytes *bytes)
{
    const double noise = 0.5 * fuzz_below(bytes, 4);
    const size_t n_cameras = 2 + (size_t)fuzz_below(bytes, RIG_CAMERAS - 1);
    const size_t n_placements = 2 + (size_t)fuzz_below(bytes, RIG_PLACEMENTS - 1);
    narrow_sight sights[RIG_CAMERAS];
    narrow_pose pose;
    float points[RIG_POINTS][3];
    size_t c, p, i, k;

    fuzz_rig_begin(made, n_cameras, n_placements);
    for (i = 0; i < RIG_POINTS; i++) {
        for (k = 0; k < 3; k++) {
            points[i][k] = within(0.25, bytes);
        }
    }
    for (c = 0; c < n_cameras; c++) {
        make_camera(&cameras[c], bytes);
        made->cameras[c] = wide_camera(&cameras[c]);
        make_pose(&pose, 0.5, 0.3, bytes);
        sights[c].camera = &cameras[c];
        sights[c].cam_from_rig = wide_pose(&pose);
        sights[c].noise = noise;
    }
    for (p = 0; p < n_placements; p++) {
        make_pose(&pose, 1, 1.5, bytes);
        for (c = 0; c < n_cameras; c++) {
            sights[c].rig_from_target = wide_pose(&pose);
            if (!see_target(made->observations[made->rig.n_views], &sights[c], points,
                            bytes)) {
                return 0;
            }
            fuzz_rig_add(made, c, p, RIG_POINTS);
        }
    }
    return made->rig.n_views == n_cameras * n_placements;
}

/* Part of the cost: how much of it an adjustment may leave, and how wrong its sum may be,
 * which is not evaluated after the last step. Usually both are far below 1e-8. Where the
 * cost falls ever more slowly, along a valley, the search ends before its floor. */
#define LEFT 1e-3

/* No step of one camera or placement lowers the cost. */
static void check_rig_minimum(fuzz_rig *made, const narrow_camera cameras[])
{
    const double cost = rig_cost(made, cameras), zero[3] = {0, 0, 0};
    const size_t n = made->rig.n_cameras + made->rig.n_placements;
    size_t i;
    int k;

    for (i = 1; i < n; i++) { /* camera 0 is held, which takes nothing from the minimum */
        rigcal_transform *T = i < made->rig.n_cameras
                                  ? &made->cams_from_rig[i]
                                  : &made->rig_from_placements[i - made->rig.n_cameras];
        const rigcal_transform before = *T;

        for (k = 0; k < 12; k++) {
            double d[6] = {0, 0, 0, 0, 0, 0};

            d[k / 2] = k % 2 == 0 ? 1e-4 : -1e-4;
            moved(T->R, T->t, before.R, before.t, k < 6 ? before.t : zero, d);
            PROMISE(rig_cost(made, cameras) >= cost - LEFT * (1 + cost));
        }
        *T = before;
    }
}

static void check_rig(fuzz_bytes *bytes)
{
    static fuzz_rig made;
    narrow_camera cameras[RIG_CAMERAS];
    rigcal_rig_fit fit;
    size_t free;

    if (!make_rig(&made, cameras, bytes) || rigcal_rig_join(&made.rig, NULL) != RIGCAL_OK ||
        rigcal_rig_adjust(&fit, NULL, &made.rig) != RIGCAL_OK) {
        return;
    }
    const double cost = rig_cost(&made, cameras);
    if (cost >= 1e30) {
        return;
    }
    free = 6 * (made.rig.n_cameras - 1 + made.rig.n_placements);
    PROMISE(fabs(fit.sum - cost) <= LEFT * (1 + cost));
    PROMISE(fit.n_points == RIG_POINTS * made.rig.n_views);
    PROMISE(fit.freedom == (rigcal_real)(2 * fit.n_points - free));
    check_rig_minimum(&made, cameras);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_bytes bytes = {data, data + size};

    switch (fuzz_below(&bytes, 4)) {
    case 0:
        check_lens(&bytes);
        break;
    case 1:
        check_pose(&bytes);
        break;
    case 2:
        check_point(&bytes);
        break;
    default:
        check_rig(&bytes);
        break;
    }
    return 0;
}
