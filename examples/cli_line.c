/* rigcal line: where in one image the match of a pixel of another can be. */
#include "cli_band.h"

#include <string.h>

typedef struct {
    size_t number, in_rig; /* number of the name in cameras.csv; number in rig.csv */
    const char *name;
    const rigcal_camera *camera;
    const rigcal_transform *cam_from_rig;
} rig_camera;

typedef struct {
    rig_camera a, b; /* from, to */
    rigcal_transform b_from_a;
    rigcal_real uv_a[2], ray_a[3];
    int exit_status;
} epipolar;

static rig_camera find(const cli_cameras *cameras, const cli_transforms *rig,
                       const char *name)
{
    rig_camera found;
    const size_t in_rig = cli_names_find(&rig->names, name);

    found.name = name;
    found.number = cli_names_find(&cameras->names, name);
    if (found.number == CLI_UNKNOWN) {
        const char *alike = cli_names_alike(&cameras->names, name);

        cli_fail("camera %s is not in %s%s%s", name, cameras->table.path,
                 alike != NULL ? ", but this one is: " : "", alike != NULL ? alike : "");
    }
    if (in_rig == CLI_UNKNOWN) {
        cli_fail("camera %s is not in %s: it has no place in the rig", name,
                 rig->table.path);
    }
    found.in_rig = in_rig;
    found.camera = &cameras->camera[found.number];
    found.cam_from_rig = &rig->transform[in_rig];
    return found;
}

static void find_both(epipolar *e, const cli_cameras *cameras, const cli_transforms *rig,
                      const char *const option[OPTION_COUNT])
{
    e->a = find(cameras, rig, option[OPTION_FROM]);
    e->b = find(cameras, rig, option[OPTION_TO]);
    if (e->a.number == e->b.number) {
        cli_fail("--from and --to are one camera, %s: a line takes two", e->a.name);
    }
}

/* Says what could not be computed. */
static int failed(epipolar *e, rigcal_status status, const char *what)
{
    if (status >= 0) {
        return 0;
    }
    cli_say("cannot compute %s: %s", what, rigcal_status_text(status));
    e->exit_status = CLI_GEOMETRY;
    return 1;
}

static void check_inside(const rig_camera *from, const double uv[2], const char *text)
{
    const rigcal_camera *camera = from->camera;

    if (!(uv[0] >= -0.5 && uv[0] <= camera->width - 0.5 && uv[1] >= -0.5 &&
          uv[1] <= camera->height - 0.5)) {
        cli_fail("--pixel %s is outside the image of camera %s, %ld x %ld pixels", text,
                 from->name, (long)camera->width, (long)camera->height);
    }
}

static int find_ray(epipolar *e, const char *text)
{
    double pixel[2];
    rigcal_real *uv = e->uv_a;

    cli_numbers(pixel, 2, "--pixel", text);
    check_inside(&e->a, pixel, text);
    uv[0] = (rigcal_real)pixel[0];
    uv[1] = (rigcal_real)pixel[1];
    return !failed(e, rigcal_camera_ray(e->ray_a, e->a.camera, uv), "the ray of --pixel") &&
           !failed(
               e,
               rigcal_transform_between(&e->b_from_a, e->b.cam_from_rig, e->a.cam_from_rig),
               "the transform from camera to camera");
}

static void print_row(const char *quantity, const rigcal_real numbers[], size_t count)
{
    printf("%s", quantity);
    cli_write_numbers(stdout, numbers, count);
    printf("%s\n", count < 4 ? "," : "");
}

static void print_line(epipolar *e)
{
    rigcal_real line[3], ends[4];

    if (failed(e, rigcal_epiline_px(line, e->b.camera, &e->b_from_a, e->ray_a), "line")) {
        return;
    }
    print_row("line", line, 3);
    if (!failed(e, rigcal_epiline_clip(ends, line, e->b.camera->width, e->b.camera->height),
                "ends")) {
        print_row("ends", ends, 4);
    }
}

/* Prints the first and the last sample of the visible part of the curve. */
static void print_curve_ends(epipolar *e, const rigcal_real ray_a[3],
                             const rigcal_real depth[2])
{
    enum { SAMPLES = 65 };
    rigcal_real uv[2 * SAMPLES], ends[4];
    size_t count = 0;

    if (failed(e,
               rigcal_epiline_curve(uv, SAMPLES, &count, e->b.camera, &e->b_from_a, ray_a,
                                    depth[0], depth[1]),
               "depth_ends_image")) {
        return;
    }
    if (count < SAMPLES) {
        cli_say("camera %s cannot see all of that depth range; "
                "depth_ends_image is of the part it can",
                e->b.name);
    }
    memcpy(ends, uv, 2 * sizeof ends[0]);
    memcpy(ends + 2, uv + 2 * (count - 1), 2 * sizeof ends[0]);
    print_row("depth_ends_image", ends, 4);
}

static void print_depths(epipolar *e, const rigcal_real depth[2])
{
    rigcal_real ray[3], ends[4];
    int k;

    if (!(e->ray_a[2] > 0)) {
        failed(e, RIGCAL_ERR_WIDE_RAY, "depth");
        return;
    }
    for (k = 0; k < 3; k++) { /* so that depths are measured along the axis */
        ray[k] = e->ray_a[k] / e->ray_a[2];
    }
    if (!failed(e,
                rigcal_epiline_segment(ends, e->b.camera, &e->b_from_a, ray, depth[0],
                                       depth[1]),
                "depth_ends")) {
        print_row("depth_ends", ends, 4);
    }
    print_curve_ends(e, ray, depth);
}

static void read_depths(rigcal_real depth[2], const char *text)
{
    double numbers[2];

    cli_numbers(numbers, 2, "--depth", text);
    if (!(numbers[0] > 0 && numbers[1] > numbers[0])) {
        cli_fail("--depth takes 0 < NEAR < FAR, not \"%s\"", text);
    }
    depth[0] = (rigcal_real)numbers[0];
    depth[1] = (rigcal_real)numbers[1];
}

static void print_band(epipolar *e, const cli_rig *rig, const rigcal_real depth[2],
                       const char *const option[OPTION_COUNT])
{
    cli_band band;

    memset(&band, 0, sizeof band);
    band.rig = rig;
    band.a = e->a.in_rig;
    band.b = e->b.in_rig;
    memcpy(band.uv_a, e->uv_a, sizeof band.uv_a);
    if (depth[1] > 0 && e->ray_a[2] > 0) { /* from a depth along the axis to one along the
                                              ray */
        band.near_a = depth[0] / e->ray_a[2];
        band.far_a = depth[1] / e->ray_a[2];
    }
    band.probability = option[OPTION_PROBABILITY];
    band.candidates = option[OPTION_CANDIDATES];
    if (cli_band_print(&band) != CLI_DONE) {
        e->exit_status = CLI_GEOMETRY;
    }
}

static void check_band(const cli_rig *rig, const char *const option[OPTION_COUNT])
{
    cli_band band;

    memset(&band, 0, sizeof band);
    band.rig = rig;
    band.probability = option[OPTION_PROBABILITY];
    band.candidates = option[OPTION_CANDIDATES];
    cli_band_check(&band);
}

int cli_line(const char *const option[OPTION_COUNT])
{
    cli_cameras cameras;
    cli_rig rig;
    epipolar e;
    rigcal_real depth[2] = {0, 0};
    double sigma_px = 0;

    memset(&e, 0, sizeof e);
    if (option[OPTION_DEPTH] != NULL) {
        read_depths(depth, option[OPTION_DEPTH]);
    }
    if (option[OPTION_SIGMA] != NULL) {
        sigma_px = cli_sigma(option[OPTION_SIGMA]);
    }
    cli_cameras_read(&cameras, option[OPTION_CAMERAS]);
    cli_rig_read(&rig, option[OPTION_RIG], &cameras, sigma_px);
    find_both(&e, &cameras, &rig.file, option);
    check_band(&rig, option);
    if (rig.sigma_px != NULL) {
        cli_rig_tell_exact(&rig);
    }
    if (find_ray(&e, option[OPTION_PIXEL])) {
        printf("quantity,v1,v2,v3,v4\n");
        print_line(&e);
        if (option[OPTION_DEPTH] != NULL) {
            print_depths(&e, depth);
        }
        print_band(&e, &rig, depth, option);
    }
    return e.exit_status;
}
