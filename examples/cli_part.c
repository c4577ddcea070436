/* A part of the rig. A search for a cause reads all views of its rig. It is given only the
 * views that can tell the cause. Otherwise the time would grow with the square of the
 * length of the file. */
#include "cli_calibrate.h"

#include <string.h>

/* If a camera has more than RUNS * RUN views, only RUNS runs of RUN views each are
 * compared. The time grows with the square of the number of views that are compared. */
enum { RUNS = 8, RUN = 16 };

static rigcal_status view_of_part(rigcal_rig_view *seen, size_t index, void *context)
{
    const rig_part *part = context;

    return view_at(seen, part->views[index], part->c);
}

static rigcal_status pose_of_part(rigcal_view_pose *pose, size_t index, void *context)
{
    const rig_part *part = context;

    return pose_at(pose, part->views[index], part->c);
}

static void open_part(rig_part *part, calibration *c, size_t capacity)
{
    part->c = c;
    part->views = cli_alloc(capacity, sizeof *part->views);
    part->left_out = cli_alloc(capacity, sizeof *part->left_out);
    part->rig = c->rig;
    part->rig.view_poses = NULL;
    part->rig.view_source = view_of_part;
    part->rig.view_pose_source = pose_of_part;
    part->rig.context = part;
    part->rig.left_out = part->left_out;
    part->rig.n_views = 0;
}

static void add_to_part(rig_part *part, size_t i)
{
    const uint8_t *left_out = part->c->rig.left_out;

    part->left_out[part->rig.n_views] = (uint8_t)(left_out != NULL && left_out[i]);
    part->views[part->rig.n_views++] = i;
}

void close_part(rig_part *part)
{
    cli_free(part->views);
    cli_free(part->left_out);
}

/* Takes the views of three placements: that of view i, the one before and the one after.
 * Returns the number that view i has in the part. */
static size_t open_part_near(rig_part *part, calibration *c, size_t i)
{
    const size_t placement = rig_view(c, i)->placement;
    size_t first = i, end = i, k;

    while (first > 0 && rig_view(c, first - 1)->placement + 1 >= placement) {
        first--;
    }
    while (end < c->rig.n_views && rig_view(c, end)->placement <= placement + 1) {
        end++;
    }
    open_part(part, c, end - first);
    for (k = first; k < end; k++) {
        add_to_part(part, k);
    }
    return i - first;
}

rigcal_status cause_of_view(rigcal_cause *cause, calibration *c, size_t i,
                            const symmetries *by)
{
    rig_part part;
    const size_t in_part = open_part_near(&part, c, i);
    const rigcal_status status =
        rigcal_rig_cause(cause, &part.rig, &c->judgement, &by->of, in_part);

    close_part(&part);
    return status;
}

/* The runs are spread evenly over the recording. With each view of the camera come all
 * views of three placements: its own, the one before and the one after. */
void open_part_of_camera(rig_part *part, calibration *c, size_t camera)
{
    uint8_t *wanted = cli_alloc(c->rig.n_placements + 2, sizeof *wanted); /* from
                                                placement -1 on */
    size_t i, k = 0, n = 0, capacity = 0;

    for (i = 0; i < c->rig.n_views; i++) {
        n += rig_view(c, i)->rig_camera == camera;
    }
    for (i = 0; i < c->rig.n_views; i++) {
        const view *v = rig_view(c, i);

        if (v->rig_camera == camera) {
            const size_t run = k * RUNS / n, begin = (run * n + RUNS - 1) / RUNS;

            if (n <= RUNS * (size_t)RUN || k - begin < RUN) {
                memset(wanted + v->placement, 1, 3);
            }
            k++;
        }
    }
    for (i = 0; i < c->rig.n_views; i++) {
        capacity += wanted[rig_view(c, i)->placement + 1];
    }
    open_part(part, c, capacity);
    for (i = 0; i < c->rig.n_views; i++) {
        if (wanted[rig_view(c, i)->placement + 1]) {
            add_to_part(part, i);
        }
    }
    cli_free(wanted);
}
