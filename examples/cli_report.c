/* What a person reads of a calibration. */
#include "cli_calibrate.h"

#include <string.h>

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
               (double)other->probability,
               v->settled ? ", settled by other frames" : "");
    }
}

static void print_views(const calibration *c)
{
    const int wide_camera = widest(&c->cameras.names);
    const int wide_frame = widest(&c->observations.frames);
    size_t i;

    printf("%-*s  %-*s  points  rms [px]  distance  +- [deg]  +- position\n",
           wide_camera, "camera", wide_frame, "frame");
    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];

        printf("%-*s  %-*s  %6lu  %8.3f  %8.5g", wide_camera,
               c->cameras.names.name[v->camera], wide_frame,
               c->observations.frames.name[v->frame], (unsigned long)v->n,
               (double)view_taken(v)->rms_px, (double)v->distance);
        print_sigma(v);
        print_caveat(v);
        printf("\n");
    }
}

static void print_cameras(const calibration *c, int32_t group, size_t first)
{
    const int wide = widest(&c->cameras.names);
    size_t i;

    printf("\n%-*s  centre in the frame of %s\n", wide, "camera",
           rig_camera_name(c, first));
    for (i = first; i < c->n_rig; i++) {
        rigcal_real o[3] = {0, 0, 0};

        if (c->group[i] == group) {
            rigcal_camera_center(o, &c->cam_from_rig[i]);
            printf("%-*s  %10.5g %10.5g %10.5g\n", wide, rig_camera_name(c, i),
                   (double)o[0] + 0, (double)o[1] + 0, (double)o[2] + 0);
        }
    }
}

/* b_from_a from each placement that both saw, into work; returns how many. */
static size_t shared_placements(const calibration *c, size_t a, size_t b)
{
    const rigcal_view *va = c->rig_views + c->first[a];
    const rigcal_view *vb = c->rig_views + c->first[b];
    const rigcal_view *end_a = c->rig_views + c->first[a + 1];
    const rigcal_view *end_b = c->rig_views + c->first[b + 1];
    size_t count = 0;

    while (va < end_a && vb < end_b) {
        if (va->placement == vb->placement &&
            rigcal_relative_pose(&c->work[count], &vb->cam_from_target,
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

static void print_pair(const calibration *c, size_t a, size_t b, int wide)
{
    const size_t shared = shared_placements(c, a, b);
    rigcal_transform b_from_a, mean;
    rigcal_real sigma_rad, sigma_t;

    rig_relative(&b_from_a, c, a, b);
    printf("%-*s  %-*s  %8.5g  %11.4f", wide, rig_camera_name(c, a), wide,
           rig_camera_name(c, b), length_of(b_from_a.t), angle_of(&b_from_a));
    if (shared > 1 &&
        rigcal_transform_mean(&mean, &sigma_rad, &sigma_t, c->work, NULL,
                              shared) == RIGCAL_OK) {
        printf("  +- %.2g, %.2g deg over %lu placements", (double)sigma_t,
               DEGREE * (double)sigma_rad, (unsigned long)shared);
    }
    printf("\n");
}

static void print_pairs(const calibration *c)
{
    const int wide = widest(&c->cameras.names);
    int header = 0;
    size_t a, b;

    for (a = 0; a < c->n_rig; a++) {
        for (b = a + 1; b < c->n_rig; b++) {
            if (c->group[a] != c->group[b]) {
                continue;
            }
            if (!header++) {
                printf("\n%-*s  %-*s  distance  angle [deg]\n", wide, "camera",
                       wide, "camera");
            }
            print_pair(c, a, b, wide);
        }
    }
}

void print_summary(const calibration *c)
{
    int32_t group = 0;
    size_t i;

    print_views(c);
    for (i = 0; i < c->n_rig; i++) {
        if (c->group[i] == group) {
            print_cameras(c, group++, i);
        }
    }
    print_pairs(c);
}
