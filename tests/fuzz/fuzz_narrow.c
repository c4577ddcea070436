#include "fuzz_narrow.h"

#include "fuzz.h"

#if !RIGCAL_USE_FLOAT
#error "fuzz_narrow.c is for the library in float"
#endif

static void copy(double to[], const rigcal_real from[], int n)
{
    int i;

    for (i = 0; i < n; i++) {
        to[i] = (double)from[i];
    }
}

static rigcal_camera camera_of(const narrow_camera *c)
{
    rigcal_camera camera;

    camera.lens = c->lens;
    camera.width = c->width;
    camera.height = c->height;
    fuzz_camera_set(&camera, c->numbers);
    return camera;
}

int32_t narrow_project(double uv[2], const narrow_camera *camera, const float X[3])
{
    const rigcal_camera c = camera_of(camera);
    rigcal_real made[2];
    const rigcal_status status = rigcal_camera_project(made, &c, X);

    if (status >= 0) {
        copy(uv, made, 2);
    }
    return status;
}

int32_t narrow_ray(double ray[3], const narrow_camera *camera, const float uv[2])
{
    const rigcal_camera c = camera_of(camera);
    rigcal_real made[3];
    const rigcal_status status = rigcal_camera_ray(made, &c, uv);

    if (status >= 0) {
        copy(ray, made, 3);
    }
    return status;
}

int32_t narrow_solve(double poses[4][12], int *n_found, const narrow_camera *camera,
                     float X[][3], float uv[][2], int n)
{
    const rigcal_camera c = camera_of(camera);
    rigcal_observation observations[NARROW_POINTS];
    rigcal_pose found[RIGCAL_POSES_MAX];
    rigcal_view view = {&c, observations, NULL, (size_t)n};
    size_t count = 0, k;
    int i;

    for (i = 0; i < n; i++) {
        int j;

        for (j = 0; j < 3; j++) {
            observations[i].X_w[j] = X[i][j];
        }
        observations[i].uv[0] = uv[i][0];
        observations[i].uv[1] = uv[i][1];
    }
    const rigcal_status status =
        rigcal_pose_solve(found, RIGCAL_POSES_MAX, &count, NULL, &view, NULL);
    *n_found = status < 0 ? 0 : (int)count;
    for (k = 0; status >= 0 && k < count; k++) {
        copy(&poses[k][0], found[k].cam_from_world.R, 9);
        copy(&poses[k][9], found[k].cam_from_world.t, 3);
    }
    return status;
}

int32_t narrow_triangulate(double X[3], const narrow_camera cameras[],
                           const narrow_pose cams_from_world[], float uv[][2], int n)
{
    rigcal_camera made[NARROW_CAMERAS];
    rigcal_transform poses[NARROW_CAMERAS];
    rigcal_point point;
    int c, i;

    for (c = 0; c < n; c++) {
        made[c] = camera_of(&cameras[c]);
        for (i = 0; i < 9; i++) {
            poses[c].R[i] = cams_from_world[c].R[i];
        }
        for (i = 0; i < 3; i++) {
            poses[c].t[i] = cams_from_world[c].t[i];
        }
    }
    const rigcal_status status =
        rigcal_point_triangulate(&point, made, poses, uv[0], (size_t)n, 1);
    if (status >= 0) {
        copy(X, point.X, 3);
    }
    return status;
}
