/* What is wrong, and what to do. This is printed before everything else. */
#include "cli_calibrate.h"

#include <stdlib.h>
#include <string.h>

finding *find(calibration *c, finding_rank rank, const char *what, const char *advice)
{
    finding *list = c->findings;
    finding *f;

    if (c->n_findings == c->room_for_findings) {
        c->room_for_findings = 2 * c->room_for_findings + 8;
        list = list == NULL ? cli_alloc(c->room_for_findings, sizeof *list)
                            : cli_resize(list, c->room_for_findings, sizeof *list);
        c->findings = list;
    }
    f = &list[c->n_findings];
    memset(f, 0, sizeof *f);
    f->rank = rank;
    f->number = c->n_findings++;
    f->what = what;
    f->advice = advice;
    c->exit_status = CLI_GEOMETRY;
    return f;
}

void say_of_view(calibration *c, const view *v, const char *what)
{
    const int exit_status = c->exit_status;
    finding *f;

    cli_say("%s", what);
    f = find(c, ABOUT_VIEW, what, "");
    f->cameras = view_camera_name(c, v);
    f->frames = view_frame_name(c, v);
    f->is_said = 1;
    c->exit_status = exit_status;
}

static int compare_findings(const void *va, const void *vb)
{
    const finding *a = va, *b = vb;

    if (a->rank != b->rank) {
        return a->rank < b->rank ? -1 : 1;
    }
    return a->number < b->number ? -1 : a->number > b->number;
}

/* Whether a finding about a view is superfluous: its camera is named as a whole, or the
 * view fits badly because the stated noise is too small for most views. */
int is_finding_told(const calibration *c, const finding *f)
{
    return f->v != NULL && (c->camera_is_told[f->v->camera] ||
                            (c->sigma_is_told && f->v->status == RIGCAL_POOR_FIT));
}

void tell_findings(calibration *c)
{
    enum { TOLD_MOST = 100 };
    size_t i, n = 0, n_more = 0;

    if (c->n_findings > 0) {
        qsort(c->findings, c->n_findings, sizeof *c->findings, compare_findings);
    }
    for (i = 0; i < c->n_findings; i++) {
        const finding *f = &c->findings[i];

        if (f->is_said || is_finding_told(c, f)) {
            continue;
        }
        if (n++ < TOLD_MOST) {
            const int is_left_out = f->v != NULL && f->v->is_left_out;

            fprintf(stderr, "rigcal: %s%s\n", f->what,
                    is_left_out ? "; the view is left out of the rig" : "");
            fprintf(stderr, "rigcal:   %s\n", f->advice);
        } else {
            n_more++;
        }
    }
    if (n_more > 0) {
        fprintf(stderr,
                "rigcal: and %lu more like these: column verdict of poses.csv has "
                "all\n",
                (unsigned long)n_more);
    }
    cli_release();
}
