/* What a person reads of a calibration. */
#include "cli_calibrate.h"

#include <stdlib.h>
#include <string.h>

/* ==== points that --robust left out ======================================= */

/* A point left out, and how far it is from its place; less than 0: the camera cannot
 * see it there at all. */
typedef struct {
    size_t point; /* of the view's */
    double error_px;
} outlier;

/* The worst first: those that cannot be seen, then the farthest. */
static int compare_outliers(const void *va, const void *vb)
{
    const outlier *a = va, *b = vb;
    const int a_unseen = a->error_px < 0, b_unseen = b->error_px < 0;

    if (a_unseen != b_unseen) {
        return b_unseen - a_unseen;
    }
    if (a->error_px < b->error_px || a->error_px > b->error_px) {
        return a->error_px < b->error_px ? 1 : -1;
    }
    return (a->point > b->point) - (a->point < b->point);
}

static size_t list_outliers(outlier list[], const calibration *c, const view *v)
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
    qsort(list, count, sizeof *list, compare_outliers);
    return count;
}

/* One line a view; returns how many points it does not name. */
static size_t name_outliers(const calibration *c, const view *v, const outlier list[],
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
    outlier *list;
    size_t i, count, unnamed = 0;

    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];

        if (v->n + v->n_unseen < v->n_seen) {
            list = cli_alloc(v->n_seen, sizeof *list);
            count = list_outliers(list, c, v);
            unnamed += name_outliers(c, v, list, count);
        }
    }
    if (unnamed > 0 && folder != NULL) {
        cli_say("%s/residuals.csv lists all of them", folder);
    } else if (unnamed > 0) {
        cli_say("with --out FOLDER, FOLDER/residuals.csv lists all of them");
    }
}

/* ==== summary ============================================================= */

static int widest(const cli_names *names)
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
    const rigcal_pose *other = view_second(v);

    if (v->by_paper && v->n == 3) {
        printf("  three points fit several poses; one, by --method paper");
    } else if (v->status == RIGCAL_AMBIGUOUS && other != NULL) {
        printf("  ambiguous: 2nd pose %.2f px, p %.2g%s", (double)other->rms_px,
               (double)other->probability, v->settled ? ", settled by other frames" : "");
    }
}

static void print_views(const calibration *c)
{
    const int wide_camera = widest(&c->cameras.names);
    const int wide_frame = widest(&c->observations.frames);
    int has_sigma = 0;
    size_t i;

    printf("%-*s  %-*s  points  rms [px]  distance  +- [deg]  +- position\n", wide_camera,
           "camera", wide_frame, "frame");
    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];

        printf("%-*s  %-*s  %6lu  %8.3f  %8.5g", wide_camera,
               c->cameras.names.name[v->camera], wide_frame,
               c->observations.frames.name[v->frame], (unsigned long)v->n,
               (double)view_taken(v)->rms_px, (double)v->distance);
        print_sigma(v);
        print_caveat(v);
        printf("\n");
        has_sigma |= v->has_sigma;
    }
    if (has_sigma) {
        printf("+- of a view: standard deviation of its pose, for noise ");
        if (c->pose.sigma_px > 0) {
            printf("of %.4g px\n", (double)c->pose.sigma_px);
        } else {
            printf("as large as its residuals\n");
        }
    }
}

static void print_cameras(const calibration *c, int32_t group, size_t first)
{
    const int wide = widest(&c->cameras.names);
    size_t i;

    printf("\n%-*s  centre in the frame of %s\n", wide, "camera",
           rig_camera_name(c, first));
    for (i = first; i < c->rig.n_cameras; i++) {
        rigcal_real o[3] = {0, 0, 0};

        if (c->rig.group[i] == group) {
            rigcal_camera_center(o, &c->rig.cams_from_rig[i]);
            printf("%-*s  %10.5g %10.5g %10.5g\n", wide, rig_camera_name(c, i),
                   (double)o[0] + 0, (double)o[1] + 0, (double)o[2] + 0);
        }
    }
}

/* b_from_a from each placement that both saw, into work; returns how many. */
static size_t shared_placements(const calibration *c, size_t a, size_t b)
{
    const rigcal_view_pose *va = c->rig.views + c->first[a];
    const rigcal_view_pose *vb = c->rig.views + c->first[b];
    const rigcal_view_pose *end_a = c->rig.views + c->first[a + 1];
    const rigcal_view_pose *end_b = c->rig.views + c->first[b + 1];
    size_t count = 0;

    while (va < end_a && vb < end_b) {
        if (va->placement == vb->placement &&
            rigcal_transform_between(&c->rig.work[count], &vb->cam_from_target,
                                     &va->cam_from_target) == RIGCAL_OK) {
            count++;
        }
        if (va->placement <= vb->placement) {
            va++;
        } else {
            vb++;
        }
    }
    return count;
}

static double angle_of(const rigcal_transform *b_from_a)
{
    static const rigcal_real NONE[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    rigcal_real angle = 0;

    rigcal_rotation_angle(&angle, NONE, b_from_a->R);
    return DEGREE * (double)angle;
}

/* Returns whether it tells a scatter. */
static int print_pair(const calibration *c, size_t a, size_t b, int wide)
{
    const size_t shared = shared_placements(c, a, b);
    rigcal_transform b_from_a, mean;
    rigcal_real sigma_rad, sigma_t;
    int has_scatter;

    rig_relative(&b_from_a, c, a, b);
    printf("%-*s  %-*s  %8.5g  %11.4f", wide, rig_camera_name(c, a), wide,
           rig_camera_name(c, b), length_of(b_from_a.t), angle_of(&b_from_a));
    has_scatter =
        shared > 1 && rigcal_transform_mean(&mean, &sigma_rad, &sigma_t, c->rig.work, NULL,
                                            shared) == RIGCAL_OK;
    if (has_scatter) {
        printf("  +- %.2g, %.2g deg over %lu placements", (double)sigma_t,
               DEGREE * (double)sigma_rad, (unsigned long)shared);
    }
    printf("\n");
    return has_scatter;
}

static void print_pairs(const calibration *c)
{
    const int wide = widest(&c->cameras.names);
    int header = 0, has_scatter = 0;
    size_t a, b;

    for (a = 0; a < c->rig.n_cameras; a++) {
        for (b = a + 1; b < c->rig.n_cameras; b++) {
            if (c->rig.group[a] != c->rig.group[b]) {
                continue;
            }
            if (!header++) {
                printf("\n%-*s  %-*s  distance  angle [deg]\n", wide, "camera", wide,
                       "camera");
            }
            has_scatter |= print_pair(c, a, b, wide);
        }
    }
    if (has_scatter) {
        printf("+- of a pair: how far single placements' answers lie from their mean "
               "(rms),\nnot the error of the mean\n");
    }
}

void print_summary(const calibration *c)
{
    int32_t group = 0;
    size_t i;

    print_views(c);
    for (i = 0; i < c->rig.n_cameras; i++) {
        if (c->rig.group[i] == group) {
            print_cameras(c, group++, i);
        }
    }
    print_pairs(c);
}
