/* What is printed of a calibration for a person to read. */
#include "cli_calibrate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ==== points that --robust left out ======================================= */

/* A point that was left out, and its distance from its expected pixel; below 0: the camera
 * cannot see it there at all. */
typedef struct {
    size_t point; /* number of the point in the view */
    double error_px;
} left_out_point;

/* Sorts the worst first: points that cannot be seen, then the farthest. */
static int compare_errors(const void *va, const void *vb)
{
    const left_out_point *a = va, *b = vb;
    const int a_unseen = a->error_px < 0, b_unseen = b->error_px < 0;

    if (a_unseen != b_unseen) {
        return b_unseen - a_unseen;
    }
    if (a->error_px < b->error_px || a->error_px > b->error_px) {
        return a->error_px < b->error_px ? 1 : -1;
    }
    return (a->point > b->point) - (a->point < b->point);
}

static size_t list_left_out(left_out_point list[], const calibration *c, const view *v)
{
    size_t k, count = 0;

    for (k = 0; k < v->n_seen; k++) {
        if (view_disagrees(v, k)) {
            residual r;
            const int is_known = view_residual(&r, c, v, k);

            list[count].point = k;
            list[count++].error_px = is_known ? (double)r.error_px : -1;
        }
    }
    qsort(list, count, sizeof *list, compare_errors);
    return count;
}

/* Prints one line for each view. Returns the number of points that it did not name. */
static size_t name_points(const calibration *c, const view *v, const left_out_point list[],
                          size_t count)
{
    enum { NAMED = 5 };
    size_t i;

    cli_say_part("rigcal: camera %s in frame %s: --robust leaves out %lu of %lu "
                 "points:",
                 c->cameras.names.name[v->camera], c->observations.frames.name[v->frame],
                 (unsigned long)count, (unsigned long)v->n_seen);
    for (i = 0; i < count && i < NAMED; i++) {
        cli_say_part("%s %s", i > 0 ? "," : "", view_point_name(c, v, list[i].point));
        if (list[i].error_px < 0) {
            cli_say_part(" (where the camera cannot see it)");
        } else {
            cli_say_part(" (%.3g px off)", list[i].error_px);
        }
    }
    if (count > i) {
        cli_say_part(" and %lu more", (unsigned long)(count - i));
    }
    cli_say_part("\n");
    return count - i;
}

void name_left_out(const calibration *c, const char *folder)
{
    left_out_point *list;
    size_t i, count, unnamed = 0;

    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];

        if (v->n + v->n_unseen < v->n_seen) {
            list = cli_alloc(v->n_seen, sizeof *list);
            count = list_left_out(list, c, v);
            unnamed += name_points(c, v, list, count);
            cli_free(list);
        }
    }
    if (unnamed > 0 && folder != NULL) {
        cli_say("%s/residuals.csv lists all of them", folder);
    } else if (unnamed > 0) {
        cli_say("with --out FOLDER, FOLDER/residuals.csv lists all of them");
    }
}

/* ==== summary ============================================================= */

int widest(const cli_names *names)
{
    size_t i, most = 6;

    for (i = 0; i < names->count; i++) {
        const size_t length = strlen(names->name[i]);

        most = length > most ? length : most;
    }
    return (int)most;
}

static void print_sigma(const view *v)
{
    if (v->has_sigma) {
        printf("  %8.2g  %11.2g", (double)v->sigma_deg, (double)v->sigma_pos);
    } else {
        printf("  %8s  %11s", "-", "-");
    }
}

static void print_caveat(const view *v)
{
    const kept_pose *other = view_second(v);

    if (v->by_paper && v->n == 3) {
        printf("  three points fit several poses; one, by --method paper");
    } else if (v->status == RIGCAL_AMBIGUOUS && other != NULL) {
        printf("  ambiguous: 2nd pose %.2f px, p %.2g%s", (double)other->rms_px,
               (double)other->probability, v->settled ? ", settled by other frames" : "");
    }
    if (v->is_left_out) {
        printf("  left out of the rig");
    }
}

/* Rms of the view's points that count, in the rig; below 0: the camera cannot see one of
 * them there. *worst is the point that is farthest off. */
static double rms_in_rig(const calibration *c, const view *v, left_out_point *worst)
{
    view_residuals of = residuals_in_rig(c, v);
    double sum = 0;
    size_t k;

    worst->error_px = -1;
    for (k = 0; k < v->n_seen; k++) {
        residual r;

        if (view_leaves_out(v, k)) {
            continue;
        }
        r = next_residual(&of, c, k);
        if (!r.is_known) {
            return -1;
        }
        sum += (double)r.error_px * (double)r.error_px;
        if ((double)r.error_px > worst->error_px) {
            worst->point = k;
            worst->error_px = (double)r.error_px;
        }
    }
    return sqrt(sum / (double)v->n);
}

static void print_rms(double rms_px)
{
    if (rms_px >= 0) {
        printf("  %8.3f", rms_px);
    } else {
        printf("  %8s", "-");
    }
}

static void print_noise_of_views(const calibration *c)
{
    printf("+- of a view: standard deviation of its own pose, for noise ");
    if (c->pose.sigma_px > 0) {
        printf("of %.4g px\n", (double)c->pose.sigma_px);
    } else {
        printf("as large as its residuals\n");
    }
}

static void print_views(const calibration *c)
{
    const int wide_camera = widest(&c->cameras.names);
    const int wide_frame = widest(&c->observations.frames);
    int has_sigma = 0;
    size_t i;

    printf("%-*s  %-*s  points  rms [px]  rig [px]  distance  +- [deg]  +- position\n",
           wide_camera, "camera", wide_frame, "frame");
    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];
        left_out_point worst;

        printf("%-*s  %-*s  %6lu  %8.3f", wide_camera, c->cameras.names.name[v->camera],
               wide_frame, c->observations.frames.name[v->frame], (unsigned long)v->n,
               (double)view_taken(v)->rms_px);
        print_rms(v->in_rig ? rms_in_rig(c, v, &worst) : -1);
        printf("  %8.5g", (double)v->distance);
        print_sigma(v);
        print_caveat(v);
        printf("\n");
        has_sigma |= v->has_sigma;
    }
    printf("rms of a view: of its own pose, and of the rig's, per point\n");
    if (has_sigma) {
        print_noise_of_views(c);
    }
}

/* Rms of all views of a camera in the rig; below 0: there is no view, or one has a point
 * that the camera cannot see. */
static double camera_rms(const calibration *c, size_t rig_camera)
{
    double sum = 0;
    size_t i, n = 0;

    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];
        left_out_point worst;
        double rms_px;

        if (v->rig_camera == rig_camera && v->in_rig) {
            rms_px = rms_in_rig(c, v, &worst);
            if (rms_px < 0) {
                return -1;
            }
            sum += (double)v->n * rms_px * rms_px;
            n += v->n;
        }
    }
    return n > 0 ? sqrt(sum / (double)n) : -1;
}

/* Prints the noise of one coordinate, by the camera's own residuals. */
static void print_sigma_px(const calibration *c, size_t rig_camera)
{
    if (c->sigma_px != NULL && c->sigma_px[rig_camera] > 0) {
        printf("  %10.3f", (double)c->sigma_px[rig_camera]);
    } else {
        printf("  %10s", "-");
    }
}

void print_rig_sigma(const rig_sigma *s, int is_known)
{
    if (is_known) {
        printf("  %8.2g  %11.2g", s->deg, s->position);
    } else {
        printf("  %8s  %11s", "-", "-");
    }
}

/* Prints the cameras of one frame: that of the main camera, or, in another group, that of
 * its first camera. */
static void print_cameras(const calibration *c, const int shown[], const char *frame)
{
    const int wide = widest(&c->cameras.names);
    size_t i;

    printf(
        "\n%-*s  rig [px]  sigma [px]  +- [deg]  +- position  centre in the frame of %s\n",
        wide, "camera", frame);
    for (i = 0; i < c->rig.n_cameras; i++) {
        rigcal_real o[3] = {0, 0, 0};
        rig_sigma s;

        if (shown[i]) {
            const int is_known = rig_camera_sigma(&s, c, i);

            rigcal_camera_center(o, &c->rig.cams_from_rig[i]);
            printf("%-*s", wide, rig_camera_name(c, i));
            print_rms(camera_rms(c, i));
            print_sigma_px(c, i);
            print_rig_sigma(&s, is_known);
            printf("  %10.5g %10.5g %10.5g\n", (double)o[0] + 0, (double)o[1] + 0,
                   (double)o[2] + 0);
        }
    }
}

static void print_groups(const calibration *c)
{
    const size_t n = c->rig.n_cameras;
    int *shown = cli_alloc(n, sizeof *shown);
    const int *counts = cameras_that_count(c);
    size_t first, i;

    print_cameras(c, c->in_frame, rig_frame_name(c));
    for (first = 0; first < n; first++) {
        int is_first = !c->in_frame[first] && counts[first];

        for (i = 0; i < n; i++) {
            shown[i] = counts[i] && c->rig.group[i] == c->rig.group[first];
            is_first = is_first && !(i < first && shown[i]);
        }
        if (is_first) {
            print_cameras(c, shown, rig_camera_name(c, first));
        }
    }
}

/* ==== how well the rig fits =============================================== */

static void print_closure(const calibration *c)
{
    const rigcal_rig_fit *fit = &c->fit;

    if (!(fit->freedom_between > 0)) {
        printf("sqrt(F) is not known: no two ways lead from a camera to another\n");
        return;
    }
    printf("sqrt(F) %.2f: the views disagree this many times as much as noise; F has %.0f "
           "and %.0f degrees of freedom\n",
           c->root_F, (double)fit->freedom_between, (double)fit->freedom_within);
    print_verdict(c);
}

/* Prints what --intrinsics-sigma adds. */
static void print_intrinsics(const calibration *c)
{
    const rigcal_intrinsics_sigma *s = &c->intrinsics;

    if (c->considered.k > 0 && c->estimated.change == NULL) {
        printf("and for intrinsics that are uncertain by %.3g %% of f, %.3g %% of fx / fy, "
               "%.3g px of the centre,\n%.3g of k1, %.3g of k2\n",
               100 * (double)s->focal, 100 * (double)s->aspect, (double)s->centre,
               (double)s->k1, (double)s->k2);
    }
}

/* Prints how points of different noise are weighted. */
static void print_weights(const calibration *c)
{
    if (c->is_weighing) {
        printf("points are weighed by column sigma_px; sigma and noise are those of the "
               "usual point, rms counts all alike\n");
    } else if (c->observations.has_sigma) {
        printf("all points count alike: column sigma_px is not used (--weigh uses it)\n");
    }
}

static void print_fit(const calibration *c)
{
    printf("\nrig: %lu view%s, %lu points, ", (unsigned long)c->rig.n_views,
           c->rig.n_views == 1 ? "" : "s", (unsigned long)c->fit.n_points);
    if (c->fit.sigma_px > 0) {
        printf("sigma %.3g px of one coordinate\n", (double)c->fit.sigma_px);
    } else {
        printf("whose sigma is not known\n");
    }
    print_weights(c);
    print_closure(c);
    if (!(c->noise_px > 0)) {
        return;
    }
    printf("+- of the rig: standard deviation for noise of %.3g px, %s%s", c->noise_px,
           c->pose.sigma_px > 0 ? "as given" : "as estimated view by view",
           c->factor > 1 ? "," : "\n");
    if (c->factor > 1) {
        printf("\nmultiplied by sqrt(F), %.2f%s\n", c->factor,
               c->factor < c->root_F ? ", less what uncertain intrinsics explain of it"
                                     : "");
    }
    print_intrinsics(c);
}

typedef struct {
    const view *v;
    left_out_point worst;
    double rms_px;
} view_and_worst;

/* Adds a view to the n with the largest residuals, of which at most `most` are kept. Of
 * equal ones the first stays. Returns how many there are. */
static size_t add_largest(view_and_worst list[], size_t n, size_t most,
                          const view_and_worst *added)
{
    size_t i = n;

    while (i > 0 && list[i - 1].worst.error_px < added->worst.error_px) {
        if (i < most) {
            list[i] = list[i - 1];
        }
        i--;
    }
    if (i < most) {
        list[i] = *added;
    }
    return n < most ? n + 1 : most;
}

/* Prints the worst point of each view in which it is largest. */
static void print_largest(const calibration *c)
{
    enum { SHOWN = 5 };
    const int wide_camera = widest(&c->cameras.names);
    const int wide_frame = widest(&c->observations.frames);
    view_and_worst list[SHOWN];
    size_t i, n = 0;

    for (i = 0; i < c->n_views; i++) {
        view_and_worst added = {&c->views[i], {0, 0}, -1};

        if (added.v->in_rig) {
            added.rms_px = rms_in_rig(c, added.v, &added.worst);
        }
        if (added.rms_px >= 0) {
            n = add_largest(list, n, SHOWN, &added);
        }
    }
    printf("\n%-*s  %-*s  rig [px]  worst [px]  point\n", wide_camera, "camera", wide_frame,
           "frame");
    for (i = 0; i < n; i++) {
        const view *v = list[i].v;

        printf("%-*s  %-*s  %8.3f  %10.3f  %s\n", wide_camera,
               c->cameras.names.name[v->camera], wide_frame,
               c->observations.frames.name[v->frame], list[i].rms_px,
               list[i].worst.error_px, view_point_name(c, v, list[i].worst.point));
    }
}

/* Prints what does not count in the rig, and what is not checked by anything. */
static void print_left_out(const calibration *c)
{
    size_t i, n = 0, n_unchecked = 0;

    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];

        n_unchecked += v->verdict == RIGCAL_VIEW_UNCHECKED;
        if (v->is_left_out) {
            printf("%s%s in %s", n++ == 0 ? "left out of the rig: " : ", ",
                   view_camera_name(c, v), view_frame_name(c, v));
        }
    }
    if (n > 0) {
        printf(" (%lu of %lu views)\n", (unsigned long)n, (unsigned long)c->n_views);
    }
    if (n_unchecked > 0) {
        printf("unchecked: %lu view%s, whose placement no other camera saw\n",
               (unsigned long)n_unchecked, n_unchecked == 1 ? "" : "s");
    }
    if (n + n_unchecked > 0) {
        printf("\n");
    }
}

void print_summary(const calibration *c)
{
    print_left_out(c);
    print_views(c);
    print_groups(c);
    print_graph(c);
    if (c->is_adjusted) {
        print_fit(c);
        print_clocks(c);
        print_estimated(c);
        print_largest(c);
    }
}
