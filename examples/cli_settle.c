/* Which pose of an ambiguous view is taken, by what other frames tell. */
#include "cli_calibrate.h"

/* Poses less likely than this are not weighed against other frames. */
#define PROBABLE ((rigcal_real)1e-3)

/* ==== ambiguous views =====================================================
 *
 * One view cannot tell which of two poses of a flat target is right, but a rig
 * is rigid: with the right one, the rotation to another camera that saw the same
 * placement is that of other frames, where both cameras are sure. With the wrong
 * one it is off by twice the tilt. A pose is taken if its sum of angles to all
 * such rotations is less than half of every other's; else the likeliest stays. */

/* The first of the views whose camera is this one, or a later one. Views are sorted by
 * camera and frame. */
static const view *first_from(const calibration *c, size_t camera)
{
    size_t low = 0, high = c->n_views;

    while (low < high) {
        const size_t middle = low + (high - low) / 2;

        if (c->views[middle].camera < camera) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return c->views + low;
}

const view *views_of(const view **first, const calibration *c, size_t camera)
{
    *first = first_from(c, camera);
    return first_from(c, camera + 1);
}

static int is_sure(const view *v)
{
    return v->status == RIGCAL_OK && !v->by_paper;
}

static rigcal_real angle_between(const rigcal_transform *a_known,
                                 const rigcal_transform *b_known, const rigcal_transform *a,
                                 const rigcal_transform *b)
{
    rigcal_transform known, here;
    rigcal_real angle = 0;

    rigcal_transform_between(&known, b_known, a_known);
    rigcal_transform_between(&here, b, a);
    rigcal_rotation_angle(&angle, known.R, here.R);
    return angle;
}

/* Adds up the angles of the view's poses to a second camera, which saw the same
 * placement, from those in frames where both are sure; returns how many. */
static size_t add_angles(rigcal_real sum[RIGCAL_POSES_MAX], const calibration *c,
                         const view *v, const view *b)
{
    const view *known, *b_known;
    const view *end = views_of(&known, c, v->camera);
    const view *b_end = views_of(&b_known, c, b->camera);
    size_t k, n_known = 0;

    for (; known < end; known++) {
        while (b_known < b_end && b_known->frame < known->frame) {
            b_known++;
        }
        if (b_known == b_end || b_known->frame != known->frame || !is_sure(known) ||
            !is_sure(b_known)) {
            continue;
        }
        n_known++;
        for (k = 0; k < v->n_poses; k++) {
            sum[k] += angle_between(
                &view_taken(known)->cam_from_world, &view_taken(b_known)->cam_from_world,
                &v->poses[k].cam_from_world, &view_taken(b)->cam_from_world);
        }
    }
    return n_known;
}

static void settle(const calibration *c, view *v)
{
    rigcal_real sum[RIGCAL_POSES_MAX] = {0};
    size_t i, k, n_known = 0, best = 0;

    for (i = 0; i < c->n_views; i++) {
        const view *b = &c->views[i];

        if (b->frame == v->frame && b->camera != v->camera && is_sure(b)) {
            n_known += add_angles(sum, c, v, b);
        }
    }
    if (n_known == 0) {
        return;
    }
    for (k = 1; k < v->n_poses; k++) {
        if (v->poses[k].probability >= PROBABLE && sum[k] < sum[best]) {
            best = k;
        }
    }
    for (k = 0; k < v->n_poses; k++) {
        if (k != best && v->poses[k].probability >= PROBABLE && 2 * sum[best] > sum[k]) {
            return;
        }
    }
    v->settled = 1;
    view_take(c, v, best);
}

void settle_ambiguous_views(calibration *c)
{
    size_t i;

    for (i = 0; i < c->n_views; i++) {
        if (c->views[i].status == RIGCAL_AMBIGUOUS) {
            settle(c, &c->views[i]);
        }
    }
}
