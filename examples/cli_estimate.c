/* Intrinsics that are estimated from the recording: --estimate-intrinsics. */
#include <math.h>
#include <string.h>

#include "cli_calibrate.h"

enum {
    ROUNDS_MOST = 8,
    NUMBERS = 6 /* numbers of a camera: f, fx / fy, cx, cy, k1, k2 */
};

/* The last round is the one that moves no number by more than this part of its standard
 * deviation. In float, rounding alone moves some numbers by a tenth. */
#define SETTLED (sizeof(rigcal_real) < sizeof(double) ? 0.25 : 0.1)

/* A number counts as changed by the recording if its standard deviation fell to this part
 * of what it was, or less. */
#define MOVED 0.5

typedef struct {
    rigcal_estimated is;
    rigcal_intrinsics_change *made, *change, *sigma;
    rigcal_view_pose *poses; /* of the views of the rig, as they are solved anew */
    rigcal_camera *nominal;  /* for each camera of the rig: as cameras.csv has it */
} estimate;

/* Solves the pose of the view by itself again, with its camera as it is now. */
static void solve_again(const calibration *c, view *v, rigcal_view_pose *pose)
{
    const rigcal_view seen = view_points(c, v);
    rigcal_pose_options options = c->pose;
    rigcal_rig_view in_rig;
    rigcal_view_pose made;
    rigcal_pose found[RIGCAL_POSES_MAX];
    int32_t at_fault;
    size_t n;

    options.use_start = 1;
    options.start = kept_transform(view_taken(v));
    memset(&in_rig, 0, sizeof in_rig);
    in_rig.view = seen;
    in_rig.camera = (int32_t)v->rig_camera;
    in_rig.placement = (int32_t)v->placement;
    if (rigcal_pose_solve(found, RIGCAL_POSES_MAX, &n, &at_fault, &seen, &options) >= 0 &&
        rigcal_view_pose_make(&made, &in_rig, &found[0].cam_from_world) == RIGCAL_OK) {
        keep_transform(&v->poses[v->taken], &found[0].cam_from_world);
        v->poses[v->taken].rms_px = found[0].rms_px;
        view_take(c, v, v->taken);
        *pose = made;
    }
}

/* Sets the cameras to the estimate, and solves the poses of the views by themselves with
 * them. */
static void change_cameras(calibration *c, const estimate *e)
{
    size_t i;

    memcpy(e->made, e->change, c->rig.n_cameras * sizeof *e->made);
    for (i = 0; i < c->rig.n_views && c->rig.view_poses == NULL; i++) {
        e->poses[i] = pose_in_rig(c, i);
    }
    c->rig.view_poses = e->poses;
    for (i = 0; i < c->rig.n_cameras; i++) {
        rigcal_camera_change(&c->cameras.camera[c->camera[i]], &e->nominal[i], &e->made[i]);
    }
    for (i = 0; i < c->rig.n_views; i++) {
        solve_again(c, rig_view(c, i), &e->poses[i]);
    }
}

static void begin(estimate *e, calibration *c)
{
    const size_t n = c->rig.n_cameras;
    size_t i;

    memset(e, 0, sizeof *e);
    e->is.made = e->made = cli_alloc(n, sizeof *e->made);
    e->is.change = e->change = cli_alloc(n, sizeof *e->change);
    e->is.sigma = e->sigma = cli_alloc(n, sizeof *e->sigma);
    e->is.considered.capacity = rigcal_estimate_work(n, n);
    e->is.considered.effects =
        cli_alloc(e->is.considered.capacity, sizeof *e->is.considered.effects);
    e->nominal = cli_alloc(n, sizeof *e->nominal);
    e->poses = cli_alloc(c->rig.n_views, sizeof *e->poses);
    for (i = 0; i < n; i++) {
        e->nominal[i] = c->cameras.camera[c->camera[i]];
    }
}

/* Repeats until the estimate is settled. The covariances of the rig then contain the
 * uncertainty that is left. */
static rigcal_status run(estimate *e, calibration *c, int32_t *at_fault)
{
    int round;

    for (round = 0; round < ROUNDS_MOST; round++) {
        rigcal_status status;

        find_noise(c);
        status = rigcal_rig_estimate(&e->is, at_fault, &c->rig, rig_noise_px(c));
        if (status != RIGCAL_OK || (double)e->is.step < SETTLED) {
            return status;
        }
        change_cameras(c, e);
        status = rigcal_rig_adjust(&c->fit, at_fault, &c->rig);
        if (status < 0) {
            return status;
        }
    }
    return RIGCAL_BUDGET_SPENT;
}

/* After a failure: the cameras become those of cameras.csv again. */
static void take_back(estimate *e, calibration *c)
{
    memset(e->change, 0, c->rig.n_cameras * sizeof *e->change);
    change_cameras(c, e);
    c->is_adjusted = rigcal_rig_adjust(&c->fit, NULL, &c->rig) >= 0;
}

int estimate_intrinsics(calibration *c)
{
    int32_t at_fault = -1;
    rigcal_status status;
    estimate e;

    begin(&e, c);
    status = run(&e, c, &at_fault);
    if (status != RIGCAL_OK) {
        name_rig_trouble(c, "the intrinsics are not estimated", status, at_fault);
        take_back(&e, c);
        return 0;
    }
    c->estimated = e.is;
    c->considered = e.is.considered;
    c->rig.considered = &c->considered;
    test_rig(c);
    return 1;
}

/* ==== what is printed and written ========================================= */

static void numbers_of(double x[NUMBERS], const rigcal_intrinsics_change *change)
{
    x[0] = 100 * (double)change->focal;
    x[1] = 100 * (double)change->aspect;
    x[2] = (double)change->cx;
    x[3] = (double)change->cy;
    x[4] = (double)change->k1;
    x[5] = (double)change->k2;
}

void print_estimated(const calibration *c)
{
    static const char *const NAME[NUMBERS] = {"f", "fx / fy", "cx", "cy", "k1", "k2"};
    static const char *const UNIT[NUMBERS] = {" %", " %", " px", " px", "", ""};
    const rigcal_intrinsics_sigma *s = &c->intrinsics;
    const rigcal_intrinsics_change before = {s->focal,  s->aspect, s->centre,
                                             s->centre, s->k1,     s->k2};
    double was[NUMBERS], change[NUMBERS], sigma[NUMBERS];
    size_t i;
    int k;

    if (c->estimated.change == NULL) {
        return;
    }
    numbers_of(was, &before);
    printf("\nintrinsics estimated, with their deviations as a prior\n");
    for (i = 0; i < c->rig.n_cameras; i++) {
        const char *cannot[NUMBERS];
        size_t n_cannot = 0, n_moved = 0;

        numbers_of(change, &c->estimated.made[i]);
        numbers_of(sigma, &c->estimated.sigma[i]);
        printf("  %s:", rig_camera_name(c, i));
        for (k = 0; k < NUMBERS; k++) {
            if (was[k] > 0 && sigma[k] < MOVED * was[k]) {
                printf("%s %s by %.2g +- %.2g%s", n_moved++ == 0 ? " moved" : ",", NAME[k],
                       change[k], sigma[k], UNIT[k]);
            } else if (was[k] > 0) {
                cannot[n_cannot++] = NAME[k];
            }
        }
        if (n_cannot > 0) {
            printf("%s it could not determine %s", n_moved > 0 ? ";" : "",
                   names_joined(cannot, n_cannot, " and "));
        }
        printf("\n");
    }
}

/* Writes the camera file with the changed numbers. */
void write_cameras(FILE *file, const calibration *c)
{
    size_t i;

    fprintf(file, "camera,lens,width,height,fx,fy,cx,cy,k1,k2,p1,p2,k3,k4,k5,k6\n");
    for (i = 0; i < c->cameras.names.count; i++) {
        const rigcal_camera *m = &c->cameras.camera[i];
        const rigcal_real numbers[] = {m->fx, m->fy, m->cx, m->cy, m->k1, m->k2,
                                       m->p1, m->p2, m->k3, m->k4, m->k5, m->k6};

        fprintf(file, "%s,%s,%ld,%ld", c->cameras.names.name[i],
                m->lens == RIGCAL_LENS_FISHEYE ? "fisheye" : "brown", (long)m->width,
                (long)m->height);
        cli_write_numbers(file, numbers, sizeof numbers / sizeof numbers[0]);
        fprintf(file, "\n");
    }
}
