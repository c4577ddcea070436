/* What looks wrong before there is a rig: duplicates, intrinsics, points. */
#include "cli_calibrate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *names_joined(const char *const names[], size_t n, const char *last)
{
    enum { NAMED = 10 };
    const char *text = n > 0 ? names[0] : "";
    size_t i;

    for (i = 1; i < n && i < NAMED; i++) {
        text = cli_text("%s%s%s", text, i + 1 == n ? last : ", ", names[i]);
    }
    return n > NAMED ? cli_text("%s and %lu more", text, (unsigned long)(n - NAMED)) : text;
}

const char *names_with_commas(const char *const names[], size_t n)
{
    const char *text = n > 0 ? names[0] : "";
    size_t i;

    for (i = 1; i < n; i++) {
        text = cli_text("%s,%s", text, names[i]);
    }
    return text;
}

/* ==== the same pixels in two frames ======================================= */

typedef struct {
    view *v;
    double sum[2]; /* sums of its pixels, u and v */
} pixels;

static int compare_numbers(double a, double b)
{
    return (a > b) - (a < b);
}

static int compare_pixels(const void *va, const void *vb)
{
    const pixels *a = va, *b = vb;
    int order = (a->v->camera > b->v->camera) - (a->v->camera < b->v->camera);

    order =
        order != 0 ? order : (a->v->n_seen > b->v->n_seen) - (a->v->n_seen < b->v->n_seen);
    order = order != 0 ? order : compare_numbers(a->sum[0], b->sum[0]);
    order = order != 0 ? order : compare_numbers(a->sum[1], b->sum[1]);
    return order != 0 ? order : (a->v->frame > b->v->frame) - (a->v->frame < b->v->frame);
}

static int is_same(rigcal_real a, rigcal_real b)
{
    return a <= b && a >= b;
}

static int same_pixels(const view *a, const view *b)
{
    size_t i;

    if (a->camera != b->camera || a->n_seen != b->n_seen) {
        return 0;
    }
    for (i = 0; i < a->n_seen; i++) {
        const rigcal_real *of_a = a->first[i].uv, *of_b = b->first[i].uv;

        if (!is_same(of_a[0], of_b[0]) || !is_same(of_a[1], of_b[1])) {
            return 0;
        }
    }
    return 1;
}

/* A camera that has the same pixels in two frames; the later frame first. */
typedef struct {
    size_t frame, other;
    const char *camera;
    size_t number;
} repetition;

static int compare_repetitions(const void *va, const void *vb)
{
    const repetition *a = va, *b = vb;

    if (a->frame != b->frame) {
        return a->frame < b->frame ? -1 : 1;
    }
    if (a->other != b->other) {
        return a->other < b->other ? -1 : 1;
    }
    return a->number < b->number ? -1 : a->number > b->number;
}

static size_t list_repetitions(repetition list[], calibration *c)
{
    pixels *all = cli_alloc(c->n_views, sizeof *all);
    size_t i, k, n = 0;

    for (i = 0; i < c->n_views; i++) {
        all[i].v = &c->views[i];
        for (k = 0; k < c->views[i].n_seen; k++) {
            all[i].sum[0] += (double)c->views[i].first[k].uv[0];
            all[i].sum[1] += (double)c->views[i].first[k].uv[1];
        }
    }
    qsort(all, c->n_views, sizeof *all, compare_pixels);
    for (i = 1; i < c->n_views; i++) {
        view *a = all[i - 1].v, *b = all[i].v;

        if (same_pixels(a, b)) {
            a->is_repeated = b->is_repeated = 1;
            list[n].frame = b->frame;
            list[n].other = a->frame;
            list[n].camera = view_camera_name(c, b);
            list[n].number = b->camera;
            n++;
        }
    }
    cli_free(all);
    return n;
}

void find_duplicates(calibration *c)
{
    repetition *list = cli_alloc(c->n_views, sizeof *list);
    const char **names = cli_alloc(c->n_views, sizeof *names);
    const size_t n = list_repetitions(list, c);
    size_t i, n_names = 0;

    qsort(list, n, sizeof *list, compare_repetitions);
    for (i = 0; i < n; i++) {
        names[n_names++] = list[i].camera;
        if (i + 1 == n || list[i + 1].frame != list[i].frame ||
            list[i + 1].other != list[i].other) {
            const char *const frames[2] = {c->observations.frames.name[list[i].frame],
                                           c->observations.frames.name[list[i].other]};
            finding *f = find(
                c, ABOUT_VIEW,
                cli_text("frame %s is a duplicate of frame %s in camera%s %s: all pixels "
                         "are the same",
                         frames[0], frames[1], n_names > 1 ? "s" : "",
                         names_joined(names, n_names, " and ")),
                "remove the lines of the frame that this image is not of");

            f->cameras = names_with_commas(names, n_names);
            f->frames = names_with_commas(frames, 2);
            n_names = 0;
        }
    }
    cli_free(names);
    cli_free(list);
}

/* ==== by their own fits =================================================== */

/* A camera is suspect if its views fit this many times worse than those of the others, and
 * to no better than the number of pixels below. A view is suspect if it fits that much
 * worse than others of its camera. */
#define WORSE 5.0
#define VIEW_WORSE 4.0
#define POOR_PX 1.0
enum { VIEWS_LEAST = 3 };

static int compare_doubles(const void *a, const void *b)
{
    return compare_numbers(*(const double *)a, *(const double *)b);
}

static double median(double list[], size_t n)
{
    qsort(list, n, sizeof *list, compare_doubles);
    return n > 0 ? list[n / 2] : 0;
}

/* The sum of squared errors of the view's own fit, each divided by the relative sigma of
 * its point. */
static double weighed_errors(const calibration *c, const view *v)
{
    const rigcal_transform cam_from_target = kept_transform(view_taken(v));
    double sum = 0;
    size_t k;

    for (k = 0; k < v->n_seen; k++) {
        residual r;

        if (!view_leaves_out(v, k) && pose_residual(&r, c, v, k, &cam_from_target)) {
            const double sigma = (double)cli_sigma_of(&c->observations, &v->first[k]);

            sum += pow((double)r.error_px / sigma, 2);
        }
    }
    return sum;
}

/* Noise of one coordinate, from the view's own fit; 0: the fit gives no estimate. */
static double own_noise(const calibration *c, const view *v)
{
    const double rms_px = (double)view_taken(v)->rms_px, n = (double)v->n;

    if (c->is_weighing && n > 3) {
        return sqrt(weighed_errors(c, v) / (2 * n - 6));
    }
    return n > 3 ? rms_px * sqrt(n / (2 * n - 6)) : 0;
}

double camera_noise(const calibration *c, size_t camera)
{
    const view *v;
    const view *end = views_of(&v, c, camera);
    double *list = cli_alloc((size_t)(end - v) + 1, sizeof *list), noise;
    size_t n = 0;

    for (; v < end; v++) {
        list[n] = own_noise(c, v);
        n += list[n] > 0;
    }
    noise = n >= VIEWS_LEAST ? median(list, n) : 0;
    cli_free(list);
    return noise;
}

static void find_wrong_intrinsics(calibration *c, const double noise[])
{
    const size_t n = c->cameras.names.count;
    double *others = cli_alloc(n, sizeof *others);
    size_t i, k;

    for (i = 0; i < n; i++) {
        size_t n_others = 0;
        double middle;

        for (k = 0; k < n; k++) {
            if (k != i && noise[k] > 0) {
                others[n_others++] = noise[k];
            }
        }
        middle = median(others, n_others);
        if (n_others > 0 && noise[i] > POOR_PX && noise[i] > WORSE * middle) {
            c->camera_is_told[i] = 1;
            find(
                c, ABOUT_CAMERA,
                cli_text("camera %s: the intrinsics are wrong: its views fit by themselves "
                         "to %.3g px, those of the other cameras to %.3g px",
                         c->cameras.names.name[i], noise[i], middle),
                "check its line of cameras.csv, or calibrate its lens again: focal "
                "lengths, centre, distortion, image size")
                ->cameras = c->cameras.names.name[i];
        }
    }
    cli_free(others);
}

/* Finds views that fit badly for their camera because one of their points is wrong. */
static void find_wrong_points(calibration *c, const double noise[])
{
    enum { LOOKED_AT_MOST = 100 };
    size_t i, n = 0;

    for (i = 0; i < c->n_views && n < LOOKED_AT_MOST; i++) {
        view *v = &c->views[i];
        const double usual = noise[v->camera];
        rigcal_pose_options options = c->pose;
        rigcal_blame blame;
        rigcal_view seen;

        if (v->is_told || c->camera_is_told[v->camera] || !(usual > 0) || v->n < 6 ||
            own_noise(c, v) < VIEW_WORSE * usual) {
            continue;
        }
        n++;
        seen = view_points(c, v);
        options.sigma_px = (rigcal_real)usual;
        if (rigcal_pose_blame(&blame, NULL, &seen, &options) >= 0 &&
            blame.verdict == RIGCAL_BLAME_SURE && blame.rms_px >= 0 &&
            2 * blame.rms_without_px < blame.rms_px) {
            v->is_told = 1;
            find_point(c, v, &blame);
        }
    }
}

/* Finds whether --sigma is wrong: then most views fit that much worse than it says. */
static void find_wrong_sigma(calibration *c, double list[])
{
    const double sigma_px = (double)c->pose.sigma_px;
    size_t i, n = 0, n_poor = 0;
    double usual;

    for (i = 0; i < c->n_views; i++) {
        list[n] = own_noise(c, &c->views[i]);
        n += list[n] > 0;
        n_poor += c->views[i].status == RIGCAL_POOR_FIT;
    }
    usual = median(list, n);
    if (sigma_px > 0 && 2 * n_poor > n && usual > 1.5 * sigma_px) {
        c->sigma_is_told = 1;
        find(c, ABOUT_RIG,
             cli_text(
                 "--sigma %.3g is too small: %lu of %lu views fit worse than that, most "
                 "to %.3g px",
                 sigma_px, (unsigned long)n_poor, (unsigned long)c->n_views, usual),
             "state the noise of one coordinate of a pixel, or leave --sigma out. If it is "
             "right, check the intrinsics and the target's coordinates");
    }
}

void find_suspects(calibration *c)
{
    const size_t n = c->cameras.names.count;
    double *list = cli_alloc(c->n_views + 1, sizeof *list);
    double *noise = cli_alloc(n, sizeof *noise);
    size_t i;

    c->camera_is_told = cli_alloc(n, sizeof *c->camera_is_told);
    for (i = 0; i < n; i++) {
        noise[i] = camera_noise(c, i);
    }
    find_wrong_intrinsics(c, noise);
    if (!c->by_paper) {
        find_wrong_sigma(c, list);
        find_wrong_points(c, noise);
    }
    cli_free(list);
    cli_free(noise);
}
