/* The camera model, with any intrinsics, pixels and points. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "fuzz.h"

/* The manual states the accuracy of a ray for images and focal lengths up to this many
 * pixels. */
#define PIXELS_STATED 4000

static int is_small(const rigcal_camera *camera, const rigcal_real uv[2])
{
    return camera->width <= PIXELS_STATED && camera->height <= PIXELS_STATED &&
           camera->fx <= PIXELS_STATED && camera->fy <= PIXELS_STATED &&
           fabs((double)uv[0]) <= PIXELS_STATED && fabs((double)uv[1]) <= PIXELS_STATED &&
           fabs((double)camera->cx) <= PIXELS_STATED &&
           fabs((double)camera->cy) <= PIXELS_STATED;
}

/* The ray of a pixel must be a unit vector that projects to that pixel. */
static void check_ray(const rigcal_camera *camera, const rigcal_real uv[2])
{
    rigcal_real ray[3], back[2];
    rigcal_ray with_derivatives;
    rigcal_status status;

    MARK(ray);
    status = rigcal_camera_ray(ray, camera, uv);
    PROMISE(fuzz_is_status(status) && status <= 0);
    PROMISE_UNTOUCHED(status, ray);
    if (status == RIGCAL_OK) {
        const double length2 = (double)ray[0] * (double)ray[0] +
                               (double)ray[1] * (double)ray[1] +
                               (double)ray[2] * (double)ray[2];

        PROMISE(fabs(length2 - 1) < FUZZ_TOL(1e-14, 1e-6));
        if (is_small(camera, uv) && sizeof(rigcal_real) == 8) {
            PROMISE(rigcal_camera_project(back, camera, ray) == RIGCAL_OK);
            PROMISE(fabs((double)(back[0] - uv[0])) <= 1e-9);
            PROMISE(fabs((double)(back[1] - uv[1])) <= 1e-9);
        }
    }
    MARK(with_derivatives);
    status = rigcal_ray_make(&with_derivatives, camera, uv);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, with_derivatives);
    if (status == RIGCAL_OK) {
        PROMISE(fuzz_all_finite(with_derivatives.m, 3));
        PROMISE(fuzz_all_finite(with_derivatives.D, 6));
    }
}

/* The ray of a projection must be the direction of the point, or there is none. */
static void check_projection(const rigcal_camera *camera, const rigcal_real X[3])
{
    rigcal_real uv[2], ray[3];
    rigcal_status status;

    MARK(uv);
    status = rigcal_camera_project(uv, camera, X);
    PROMISE(fuzz_is_status(status) && status <= 0);
    PROMISE_UNTOUCHED(status, uv);
    if (status != RIGCAL_OK) {
        return;
    }
    PROMISE(fuzz_all_finite(uv, 2));
    PROMISE(camera->lens == RIGCAL_LENS_FISHEYE || X[2] > 0);
    const double largest =
        fmax(fmax(fabs((double)X[0]), fabs((double)X[1])), fabs((double)X[2]));
    if (is_small(camera, uv) && sizeof(rigcal_real) == 8 && camera->fx > 100 &&
        camera->fy > 100 && largest > DBL_MIN / DBL_EPSILON &&
        rigcal_camera_ray(ray, camera, uv) == RIGCAL_OK) {
        const double x = (double)X[0] / largest, y = (double)X[1] / largest;
        const double z = (double)X[2] / largest, length = sqrt(x * x + y * y + z * z);

        /* near a fold two rays have nearly the same pixel */
        PROMISE(fabs((double)ray[0] - x / length) < 1e-3);
        PROMISE(fabs((double)ray[1] - y / length) < 1e-3);
        PROMISE(fabs((double)ray[2] - z / length) < 1e-3);
    }
}

/* How far the pixel moves if the undistorted pixel moves by a part of 1e-13. */
static double moves_by(const rigcal_camera *camera, const rigcal_real straight[2],
                       const rigcal_real uv[2])
{
    const rigcal_real beside[2] = {
        straight[0] * (1 + (rigcal_real)1e-13) + (rigcal_real)1e-13,
        straight[1] * (1 + (rigcal_real)1e-13) + (rigcal_real)1e-13};
    rigcal_real moved[2];

    return rigcal_camera_distort(moved, camera, beside) == RIGCAL_OK
               ? hypot((double)(moved[0] - uv[0]), (double)(moved[1] - uv[1]))
               : INFINITY;
}

/* Removes the distortion and adds it again, in double. */
static void check_undistortion(const rigcal_camera *camera, const rigcal_real uv[2])
{
    rigcal_real straight[2], back[2];
    rigcal_status status;

    MARK(straight);
    status = rigcal_camera_undistort(straight, camera, uv);
    PROMISE(fuzz_is_status(status) && status <= 0);
    PROMISE_UNTOUCHED(status, straight);
    MARK(back);
    if (status != RIGCAL_OK) {
        status = rigcal_camera_distort(back, camera, uv);
        PROMISE(fuzz_is_status(status) && status <= 0);
        PROMISE_UNTOUCHED(status, back);
        return;
    }
    PROMISE(fuzz_all_finite(straight, 2));
    status = rigcal_camera_distort(back, camera, straight);
    PROMISE_UNTOUCHED(status, back);
    if (status == RIGCAL_OK && is_small(camera, uv) && sizeof(rigcal_real) == 8) {
        const double rounding = 1e-8 + 10 * moves_by(camera, straight, back);

        PROMISE(fabs((double)(back[0] - uv[0])) <= rounding);
        PROMISE(fabs((double)(back[1] - uv[1])) <= rounding);
    }
}

enum { POINTS_MOST = 12 };

static void check_view(fuzz_bytes *bytes)
{
    rigcal_observation observations[POINTS_MOST];
    rigcal_real sigma[POINTS_MOST], rms_px, center[3];
    rigcal_transform cam_from_world;
    rigcal_camera camera;
    rigcal_view view;
    rigcal_status status;
    int32_t worst;

    fuzz_view(&view, &camera, observations, sigma, POINTS_MOST, bytes);
    fuzz_transform(&cam_from_world, bytes);
    MARK(rms_px);
    MARK(worst);
    status = rigcal_view_rms(&rms_px, &worst, &view, &cam_from_world);
    PROMISE(fuzz_is_status(status));
    PROMISE_UNTOUCHED(status, rms_px);
    PROMISE_UNTOUCHED(status, worst);
    if (status >= 0) {
        PROMISE(rms_px >= 0 && fuzz_all_finite(&rms_px, 1));
        PROMISE(worst >= 0 && (size_t)worst < view.n);
    }
    MARK(center);
    status = rigcal_camera_center(center, &cam_from_world);
    PROMISE_UNTOUCHED(status, center);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_bytes bytes = {data, data + size};
    rigcal_camera camera;
    rigcal_real uv[2], X[3];
    rigcal_status status;

    if (fuzz_below(&bytes, 4) == 3) {
        check_view(&bytes);
        return 0;
    }
    fuzz_camera(&camera, &bytes);
    fuzz_reals(uv, 2, &bytes);
    fuzz_reals(X, 3, &bytes);
    status = rigcal_camera_check(&camera);
    PROMISE(status == RIGCAL_OK || status == RIGCAL_ERR_NOT_FINITE ||
            status == RIGCAL_ERR_CAMERA);
    check_ray(&camera, uv);
    check_projection(&camera, X);
    check_undistortion(&camera, uv);
    return 0;
}
