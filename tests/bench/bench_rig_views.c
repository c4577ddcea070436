/* bench_rig_views: the evaluations that the adjustment of given views takes, from the join
 * and from poses composed along a tree. real_rigs.py writes the views to its input:
 *
 *   numbers of cameras, placements and views
 *   a line a camera: lens, width, height, fx, fy, cx, cy, k1, k2, p1, p2, k3 .. k6
 *   a view: its camera, placement and number of points; its pose, R and t; then a line a
 *   point, X, Y, Z, u, v. Views are in the order of their placements */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "test_support.h"

/* Unity needs these: the arithmetic of the tests uses its checks. */
void setUp(void)
{
}

void tearDown(void)
{
}

typedef struct {
    rigcal_rig rig;
    rigcal_camera *cameras;
    rigcal_rig_view *views;
    rigcal_view_pose *own;
} given;

static void fail(const char *why)
{
    fprintf(stderr, "bench_rig_views: %s\n", why);
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

static void read_numbers(double x[], int n)
{
    for (int i = 0; i < n; i++) {
        if (scanf("%lf", &x[i]) != 1) {
            fail("a number is missing");
        }
    }
}

static size_t read_count(void)
{
    double n;

    read_numbers(&n, 1);
    if (!(n >= 0 && n < 1e6)) {
        fail("a count is wrong");
    }
    return (size_t)n;
}

static void read_view(given *g, size_t index)
{
    rigcal_rig_view *const v = &g->views[index];
    const size_t camera = read_count(), placement = read_count(), n = read_count();
    rigcal_observation *const seen = memory(n + 1, sizeof *seen);
    double pose[12];
    rigcal_pose_options options;
    rigcal_pose found;
    size_t n_found;

    if (camera >= g->rig.n_cameras) {
        fail("there is no such camera");
    }
    (void)rigcal_pose_defaults(&options);
    options.use_start = 1;
    read_numbers(pose, 12);
    options.start = test_transform(pose, &pose[9]);
    for (size_t i = 0; i < n; i++) {
        double numbers[5];

        read_numbers(numbers, 5);
        test_to_real(seen[i].X_w, numbers, 3);
        test_to_real(seen[i].uv, &numbers[3], 2);
    }
    v->view = VIEW(&g->cameras[camera], seen, NULL, n);
    v->camera = (int32_t)camera;
    v->placement = (int32_t)placement;
    if (rigcal_pose_solve(&found, 1, &n_found, NULL, &v->view, &options) < 0 ||
        rigcal_view_pose_make(&g->own[index], v, &found.cam_from_world) != RIGCAL_OK) {
        fail("the pose of a view cannot be had");
    }
}

static void read_rig(given *g)
{
    rigcal_rig *const rig = &g->rig;

    rig->n_cameras = read_count();
    rig->n_placements = read_count();
    rig->n_views = read_count();
    g->cameras = memory(rig->n_cameras, sizeof *g->cameras);
    g->views = memory(rig->n_views, sizeof *g->views);
    g->own = memory(rig->n_views, sizeof *g->own);
    for (size_t c = 0; c < rig->n_cameras; c++) {
        double numbers[15];

        read_numbers(numbers, 15);
        g->cameras[c] = test_camera(numbers);
    }
    for (size_t i = 0; i < rig->n_views; i++) {
        read_view(g, i);
    }
    rig->cams_from_rig = memory(rig->n_cameras, sizeof *rig->cams_from_rig);
    rig->rig_from_placements = memory(rig->n_placements, sizeof *rig->rig_from_placements);
    rig->group = memory(rig->n_cameras, sizeof *rig->group);
    rig->work_capacity = rigcal_rig_work(rig->n_cameras, rig->n_cameras, rig->n_placements);
    rig->work = memory(rig->work_capacity, sizeof *rig->work);
    rig->views = g->views;
    rig->view_poses = g->own;
}

/* Composes each camera and placement from a single view, along a tree that begins at camera
 * 0. */
static void compose(given *g)
{
    const rigcal_rig *const rig = &g->rig;
    char *const known_cameras = memory(rig->n_cameras, 1);
    char *const known_places = memory(rig->n_placements + 1, 1);

    known_cameras[0] = 1;
    rig->cams_from_rig[0] = test_transform(NULL, NULL);
    for (size_t round = 0; round < rig->n_cameras; round++) {
        for (size_t i = 0; i < rig->n_views; i++) {
            const rigcal_view_pose *const v = &g->own[i];
            rigcal_transform *const camera = &rig->cams_from_rig[v->camera];
            rigcal_transform *const place = &rig->rig_from_placements[v->placement];

            if (known_cameras[v->camera] && !known_places[v->placement]) {
                const rigcal_transform rig_from_cam = test_inverse(camera);

                *place = test_times(&rig_from_cam, &v->cam_from_target);
                known_places[v->placement] = 1;
            } else if (known_places[v->placement] && !known_cameras[v->camera]) {
                const rigcal_transform target_from_rig = test_inverse(place);

                *camera = test_times(&v->cam_from_target, &target_from_rig);
                known_cameras[v->camera] = 1;
            }
        }
    }
    free(known_cameras);
    free(known_places);
}

static void adjust(const char *from, given *g)
{
    rigcal_rig_fit fit;
    const rigcal_status status = rigcal_rig_adjust(&fit, NULL, &g->rig);

    if (status < 0) {
        fail(rigcal_status_name(status));
    }
    printf("%s %d %.9g %.9g\n", from, (int)fit.evals, D(fit.sum), D(fit.F));
}

int main(void)
{
    given g = {0};

    read_rig(&g);
    if (rigcal_rig_join(&g.rig, NULL) < 0) {
        fail("the views cannot be joined");
    }
    adjust("joined", &g);
    compose(&g);
    adjust("composed", &g);
    for (size_t i = 0; i < g.rig.n_views; i++) {
        free((void *)(uintptr_t)g.views[i].view.observations);
    }
    free(g.cameras);
    free(g.views);
    free(g.own);
    free(g.rig.cams_from_rig);
    free(g.rig.rig_from_placements);
    free(g.rig.group);
    free(g.rig.work);
    return 0;
}
