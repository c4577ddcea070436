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
    f->number = c->n_findings++ + c->n_troubles;
    f->what = what;
    f->advice = advice;
    c->exit_status = CLI_GEOMETRY;
    return f;
}

char *trouble_text(const calibration *c, const view_trouble *t)
{
    const char *camera = c->cameras.names.name[t->camera];
    const char *frame = c->observations.frames.name[t->frame];
    const char *status = rigcal_status_text((rigcal_status)t->status);

    switch (t->kind) {
    case TROUBLE_TOO_FEW:
        return cli_text("camera %s has no pose in frame %s: it sees %lu point%s there, and "
                        "a pose takes 3 at least",
                        camera, frame, (unsigned long)t->n, t->n == 1 ? "" : "s");
    case TROUBLE_POINT:
        return cli_text("camera %s has no pose in frame %s because of point %s: %s", camera,
                        frame, c->observations.points.name[t->n], status);
    case TROUBLE_NO_POSE:
        return cli_text("camera %s has no pose in frame %s: %s", camera, frame, status);
    case TROUBLE_CAVEAT:
        return cli_text("camera %s in frame %s, %.3g px rms: %s", camera, frame,
                        (double)t->rms_px, status);
    default:
        return cli_text("camera %s in frame %s is left out of the rig: %s", camera, frame,
                        status);
    }
}

static void say_trouble(const void *context, size_t number)
{
    const calibration *c = context;
    char *text = trouble_text(c, &c->troubles[number]);

    cli_say("%s", text);
    cli_free(text);
}

void say_of_view(calibration *c, const view *v, trouble_kind kind, rigcal_status status,
                 size_t point)
{
    view_trouble *list = c->troubles;
    view_trouble *t;

    if (c->n_troubles == c->room_for_troubles) {
        c->room_for_troubles += c->room_for_troubles / 2 + 64;
        list = list == NULL ? cli_alloc(c->room_for_troubles, sizeof *list)
                            : cli_resize(list, c->room_for_troubles, sizeof *list);
        c->troubles = list;
    }
    t = &list[c->n_troubles];
    t->number = (uint32_t)(c->n_findings + c->n_troubles);
    t->camera = v->camera;
    t->frame = v->frame;
    t->n = kind == TROUBLE_POINT ? (uint32_t)point : v->n;
    t->rms_px = kind == TROUBLE_CAVEAT ? view_taken(v)->rms_px : 0;
    t->status = (int16_t)status;
    t->kind = (uint8_t)kind;
    cli_say_later(say_trouble, c, c->n_troubles++);
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

        if (is_finding_told(c, f)) {
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
