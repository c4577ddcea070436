/* Targets that look the same from several sides, by column turned of the observations. In
 * each view it is unknown which side was read. The readings are chosen so that the cameras
 * have the same relative poses in all frames, as they have in most. */
#include "cli_calibrate.h"

#include <math.h>
#include <string.h>

enum { TURNS_MOST = 12, RELATIONS_TRIED = 60 };

/* A pose counts as another one if it differs by this, in rad and in parts of the
 * distance. */
static const double FAR = 0.15;

/* A turned point may miss the place of another point by this part of the target, because X,
 * Y, Z are written with few digits. */
static const double DIGITS = 1e-4;

typedef struct {
    calibration *c;
    size_t n_turns;
    rigcal_transform back[TURNS_MOST]; /* for a number of turns: takes the turned target to
                                          the target */
    rigcal_transform *in_rig;          /* for each camera of cameras.csv: cam_from_rig */
    int *is_in;
    size_t *shared; /* for two cameras: the number of frames that both saw */
} turning;

/* ==== the turn ============================================================ */

/* For each point, one of its observations. */
static const cli_observation **places_of(const cli_observations *seen)
{
    const cli_observation **place =
        cli_alloc(seen->points.count, sizeof(const cli_observation *));
    size_t i;
    int k;

    for (i = 0; i < seen->count; i++) {
        const cli_observation *o = &seen->list[i];
        const size_t point = cli_point(seen, o);
        const cli_observation **at = &place[point];

        *at = *at == NULL ? o : *at;
        for (k = 0; k < 3; k++) {
            if (fabs((double)(cli_X(seen, *at)[k] - cli_X(seen, o)[k])) > 0) {
                csv_fail_line(&seen->table, o->line,
                              "column turned: point %s has other coordinates X, Y, Z on "
                              "line %lu: a target that is turned has one shape",
                              seen->points.name[point], (unsigned long)(*at)->line);
            }
        }
    }
    return place;
}

/* The number of turns that bring all points back to themselves. */
static size_t count_turns(const cli_observations *seen,
                          const cli_observation *const place[])
{
    size_t p, n, most = 1;

    for (p = 0; p < seen->points.count; p++) {
        uint32_t at = (uint32_t)p;

        for (n = 0; n == 0 || (at != p && n <= TURNS_MOST); n++) {
            at = seen->turned[at];
        }
        if (at != p || (most > 1 && n > 1 && n != most)) {
            csv_fail_line(
                &seen->table, place[p]->line,
                "column turned: point %s is not itself again after as many turns as the "
                "other points, or after %d",
                seen->points.name[p], TURNS_MOST);
        }
        most = n > most ? n : most;
    }
    return most;
}

/* Axes from three points. The columns are along a to b, in the plane, and normal to it.
 * Returns the size of the triangle; 0: the points are on a line. */
static double axes_of(double axes[9], const rigcal_real a[3], const rigcal_real b[3],
                      const rigcal_real c[3])
{
    double x[3], y[3], z[3], xx = 0, xy = 0, yy = 0;
    int i;

    for (i = 0; i < 3; i++) {
        x[i] = (double)(b[i] - a[i]);
        y[i] = (double)(c[i] - a[i]);
        xx += x[i] * x[i];
        xy += x[i] * y[i];
    }
    for (i = 0; i < 3; i++) {
        y[i] -= xy / fmax(xx, 1e-300) * x[i];
        yy += y[i] * y[i];
    }
    for (i = 0; i < 3; i++) {
        x[i] /= sqrt(fmax(xx, 1e-300));
        y[i] /= sqrt(fmax(yy, 1e-300));
    }
    for (i = 0; i < 3; i++) {
        z[i] = x[(i + 1) % 3] * y[(i + 2) % 3] - x[(i + 2) % 3] * y[(i + 1) % 3];
        axes[3 * i] = x[i];
        axes[3 * i + 1] = y[i];
        axes[3 * i + 2] = z[i];
    }
    return yy > 1e-6 * xx ? sqrt(xx) : 0;
}

/* Where point p is. */
static const rigcal_real *at_point(const cli_observations *seen,
                                   const cli_observation *const place[], size_t p)
{
    return cli_X(seen, place[p]);
}

/* The point that makes the largest triangle with a and b. If a == b, the point that is
 * farthest from a. */
static size_t widest_with(const cli_observations *seen,
                          const cli_observation *const place[], size_t a, size_t b)
{
    size_t p, best = a;
    double most = 0;

    for (p = 0; p < seen->points.count; p++) {
        const rigcal_real *A = at_point(seen, place, a), *B = at_point(seen, place, b);
        const rigcal_real *P = at_point(seen, place, p);
        double off = 0, along = 0, length = 0;
        int i;

        for (i = 0; i < 3; i++) {
            off += pow((double)(P[i] - A[i]), 2);
            along += (double)(P[i] - A[i]) * (double)(B[i] - A[i]);
            length += pow((double)(B[i] - A[i]), 2);
        }
        off -= length > 0 ? along * along / length : 0;
        if (off > most) {
            most = off;
            best = p;
        }
    }
    return best;
}

/* The rigid transform that takes each point to the point that it becomes. */
static rigcal_transform turn_of(const cli_observations *seen,
                                const cli_observation *const place[])
{
    const size_t n = seen->points.count;
    const size_t b = widest_with(seen, place, 0, 0), c = widest_with(seen, place, 0, b);
    const uint32_t *to = seen->turned;
    double from[9], onto[9];
    const double size = axes_of(from, at_point(seen, place, 0), at_point(seen, place, b),
                                at_point(seen, place, c));
    rigcal_transform turn = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    rigcal_real R[9] = {0}, moved[3];
    size_t p;
    int i, j, k, is_alike;

    axes_of(onto, at_point(seen, place, to[0]), at_point(seen, place, to[b]),
            at_point(seen, place, to[c]));
    for (i = 0; i < 3; i++) {
        for (j = 0; j < 3; j++) {
            for (k = 0; k < 3; k++) {
                R[3 * i + j] += (rigcal_real)(onto[3 * i + k] * from[3 * j + k]);
            }
        }
    }
    is_alike = size > 0 && rigcal_rotation_nearest(turn.R, R) == RIGCAL_OK;
    rigcal_transform_point(moved, &turn, at_point(seen, place, 0));
    for (i = 0; i < 3; i++) {
        turn.t[i] = at_point(seen, place, to[0])[i] - moved[i];
    }
    for (p = 0; p < n; p++) {
        rigcal_transform_point(moved, &turn, at_point(seen, place, p));
        for (i = 0; i < 3; i++) {
            is_alike =
                is_alike &&
                fabs((double)(moved[i] - at_point(seen, place, to[p])[i])) < DIGITS * size;
        }
        if (!is_alike) {
            csv_fail_line(
                &seen->table, place[p]->line,
                "column turned: no turn of the target takes every point to the one "
                "that its line names, as %s to %s",
                seen->points.name[p], seen->points.name[to[p]]);
        }
    }
    return turn;
}

/* Checks what the column says and computes the turn. n_turns = 1: there is none. */
static void find_turn(turning *t)
{
    const cli_observations *seen = &t->c->observations;
    const cli_observation **place;
    rigcal_transform turn;
    size_t k;

    t->n_turns = 1;
    if (seen->turned == NULL || seen->count == 0) {
        return;
    }
    place = places_of(seen);
    for (k = 0; k < seen->points.count; k++) {
        if (place[k] == NULL) { /* only another point refers to it */
            size_t p = 0;

            while (seen->turned[p] != k) {
                p++;
            }
            csv_fail_line(&seen->table, place[p]->line,
                          "column turned: point %s, which %s becomes, is in no line",
                          seen->points.name[k], seen->points.name[p]);
        }
    }
    t->n_turns = count_turns(seen, place);
    if (t->n_turns > 1) {
        turn = turn_of(seen, place);
        memset(t->back, 0, sizeof t->back);
        t->back[0].R[0] = t->back[0].R[4] = t->back[0].R[8] = 1;
        rigcal_transform_invert(&t->back[1], &turn);
        for (k = 2; k < t->n_turns; k++) {
            rigcal_transform_compose(&t->back[k], &t->back[1], &t->back[k - 1]);
        }
    }
    cli_free(place);
}

/* ==== how the cameras stand =============================================== */

/* The view of a camera in a frame, or NULL. Views are sorted by camera and frame. */
static view *view_in(const calibration *c, size_t camera, size_t frame)
{
    size_t low = 0, high = c->n_views;

    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        const view *v = &c->views[middle];

        if (v->camera < camera || (v->camera == camera && v->frame < frame)) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low < c->n_views && c->views[low].camera == camera &&
                   c->views[low].frame == frame
               ? &c->views[low]
               : NULL;
}

/* The pose cam_from_target of a view, if the target was read after this many turns. */
static rigcal_transform reading(const turning *t, const view *v, size_t turns)
{
    const rigcal_transform taken = kept_transform(view_taken(v));
    rigcal_transform read;

    rigcal_transform_compose(&read, &taken, &t->back[turns]);
    return read;
}

/* The distance of two poses: the angle in rad, plus the shift as a part of the distance. */
static double apart(const rigcal_transform *a, const rigcal_transform *b)
{
    const rigcal_real off[3] = {a->t[0] - b->t[0], a->t[1] - b->t[1], a->t[2] - b->t[2]};
    rigcal_real angle = 0;

    rigcal_rotation_angle(&angle, a->R, b->R);
    return (double)angle +
           2 * length_of(off) / fmax(length_of(a->t) + length_of(b->t), 1e-300);
}

/* b_from_a of each frame that both cameras saw, once for each reading of b. */
static rigcal_transform *relations_of(const turning *t, size_t a, size_t b,
                                      size_t *n_frames)
{
    const calibration *c = t->c;
    rigcal_transform *found =
        cli_alloc(t->shared[a * c->cameras.names.count + b] * t->n_turns, sizeof *found);
    size_t frame, k, n = 0;

    for (frame = 0; frame < c->observations.frames.count; frame++) {
        const view *of_a = view_in(c, a, frame), *of_b = view_in(c, b, frame);

        for (k = 0; of_a != NULL && of_b != NULL && k < t->n_turns; k++) {
            const rigcal_transform from = reading(t, of_b, k);
            const rigcal_transform to = kept_transform(view_taken(of_a));

            rigcal_transform_between(&found[n * t->n_turns + k], &from, &to);
        }
        n += of_a != NULL && of_b != NULL;
    }
    *n_frames = n;
    return found;
}

/* The mean distance of the frames from a relation. Each frame counts at most FAR. */
static double disagreement(const turning *t, const rigcal_transform *relation,
                           const rigcal_transform all[], size_t n_frames)
{
    double sum = 0;
    size_t f, k;

    for (f = 0; f < n_frames; f++) {
        double near = FAR;

        for (k = 0; k < t->n_turns; k++) {
            near = fmin(near, apart(relation, &all[f * t->n_turns + k]));
        }
        sum += near;
    }
    return sum / (double)n_frames;
}

/* Finds the b_from_a with which most frames agree. Returns by how much more they agree with
 * it than with the best different one. */
static double find_relation(rigcal_transform *b_from_a, const turning *t, size_t a,
                            size_t b)
{
    size_t n_frames, i, best = 0;
    rigcal_transform *all = relations_of(t, a, b, &n_frames);
    const size_t step = n_frames / RELATIONS_TRIED + 1;
    double *cost = cli_alloc(n_frames * t->n_turns, sizeof *cost), next = FAR;

    for (i = 0; i < n_frames * t->n_turns; i++) {
        cost[i] =
            i / t->n_turns % step == 0 ? disagreement(t, &all[i], all, n_frames) : FAR;
        best = cost[i] < cost[best] ? i : best;
    }
    for (i = 0; i < n_frames * t->n_turns; i++) {
        if (apart(&all[i], &all[best]) > FAR) {
            next = fmin(next, cost[i]);
        }
    }
    *b_from_a = all[best];
    next -= cost[best];
    cli_free(cost);
    cli_free(all);
    return next;
}

/* Finds the pair with most frames of a placed camera and one that is not. Returns 0 if
 * there is no pair. */
static int next_pair(size_t *a, size_t *b, const turning *t)
{
    const size_t n = t->c->cameras.names.count;
    size_t i, j, most = 0;

    for (i = 0; i < n; i++) {
        for (j = 0; j < n; j++) {
            if (t->is_in[i] && !t->is_in[j] && t->shared[i * n + j] > most) {
                most = t->shared[i * n + j];
                *a = i;
                *b = j;
            }
        }
    }
    return most > 0;
}

static void count_shared(turning *t)
{
    const calibration *c = t->c;
    const size_t n = c->cameras.names.count;
    size_t i, b;

    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];

        for (b = 0; b < n; b++) {
            t->shared[v->camera * n + b] +=
                b != v->camera && view_in(c, b, v->frame) != NULL;
        }
    }
}

/* Names cameras whose frames do not show which reading is right. */
static void name_doubtful(const turning *t, const char *const names[], size_t n)
{
    if (n > 0) {
        find(
            t->c, ABOUT_CAMERA,
            cli_text("the target looks the same from %lu sides, and the frames do not tell "
                     "which is meant for %s",
                     (unsigned long)t->n_turns, names_joined(names, n, " and ")),
            "show it in more places, or use a board with an even and an odd number of "
            "corners")
            ->cameras = names_with_commas(names, n);
    }
}

/* Places each camera in the frame of the first camera of its group. */
static void place_cameras(turning *t)
{
    static const rigcal_transform HERE = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    const size_t n = t->c->cameras.names.count;
    const char **doubtful = cli_alloc(n, sizeof *doubtful);
    size_t i, a = 0, b = 0, n_doubtful = 0;

    count_shared(t);
    for (i = 0; i < n; i++) {
        if (!t->is_in[i]) {
            t->in_rig[i] = HERE;
            t->is_in[i] = 1;
        }
        while (next_pair(&a, &b, t)) {
            rigcal_transform b_from_a;

            if (find_relation(&b_from_a, t, a, b) < FAR / 10) {
                doubtful[n_doubtful++] = t->c->cameras.names.name[b];
            }
            rigcal_transform_compose(&t->in_rig[b], &b_from_a, &t->in_rig[a]);
            t->is_in[b] = 1;
        }
    }
    name_doubtful(t, doubtful, n_doubtful);
    cli_free(doubtful);
}

/* ==== the readings ======================================================== */

/* The reading of a view that is nearest to cam_from_target. Returns its distance. */
static double nearest_reading(size_t *turns, const turning *t, const view *v,
                              const rigcal_transform *cam_from_target)
{
    double least = HUGE_VAL;
    size_t k;

    for (k = 0; k < t->n_turns; k++) {
        const rigcal_transform read = reading(t, v, k);
        const double off = apart(&read, cam_from_target);

        if (off < least) {
            least = off;
            *turns = k;
        }
    }
    return least;
}

/* The turns of all views of a frame, by camera, if the first reading of view v is right.
 * Returns the distance of these views from the target's place in the rig. Each view counts
 * at most FAR. */
static double read_as(size_t turns[], const turning *t, const view *v)
{
    const calibration *c = t->c;
    const rigcal_transform taken = kept_transform(view_taken(v));
    rigcal_transform rig_from_cam, rig_from_target, expected;
    double sum = 0;
    size_t b;

    rigcal_transform_invert(&rig_from_cam, &t->in_rig[v->camera]);
    rigcal_transform_compose(&rig_from_target, &rig_from_cam, &taken);
    for (b = 0; b < c->cameras.names.count; b++) {
        const view *other = view_in(c, b, v->frame);

        turns[b] = 0;
        if (other != NULL && other != v) {
            rigcal_transform_compose(&expected, &t->in_rig[b], &rig_from_target);
            sum += fmin(FAR, nearest_reading(&turns[b], t, other, &expected));
        }
    }
    return sum;
}

/* Gives the points of a view the names and places that they have after the turns. */
static void turn_view(const turning *t, view *v, size_t turns, const uint32_t where[])
{
    cli_observations *seen = &t->c->observations;
    cli_observation *first = &seen->list[v->first - seen->list];
    size_t i, k;

    for (i = 0; i < v->n_seen; i++) {
        size_t point = cli_point(seen, &first[i]);

        for (k = 0; k < turns; k++) {
            point = seen->turned[point];
        }
        first[i].place = where[point];
    }
    for (i = 0; i < v->n_poses; i++) {
        const rigcal_transform read = kept_transform(&v->poses[i]);
        rigcal_transform turned;

        rigcal_transform_compose(&turned, &read, &t->back[turns]);
        keep_transform(&v->poses[i], &turned);
    }
}

/* The turns of all views of a frame that leave most of them as they were read. *n_others is
 * the number of the other views. */
static size_t usual_turns(size_t *n_others, const turning *t, size_t frame,
                          const size_t turns[])
{
    size_t count[TURNS_MOST] = {0}, b, k, best = 0, n_views = 0;

    for (b = 0; b < t->c->cameras.names.count; b++) {
        if (view_in(t->c, b, frame) != NULL) {
            count[(t->n_turns - turns[b]) % t->n_turns]++;
            n_views++;
        }
    }
    for (k = 1; k < t->n_turns; k++) {
        best = count[k] > count[best] ? k : best;
    }
    *n_others = n_views - count[best];
    return best;
}

/* The view of a frame whose first reading makes the other views agree best with the rig,
 * and their turns. NULL: there is none. */
static const view *read_frame(size_t turns[], const turning *t, size_t frame)
{
    const calibration *c = t->c;
    const view *best = NULL;
    double least = HUGE_VAL;
    size_t b;

    for (b = 0; b < c->cameras.names.count; b++) {
        const view *v = view_in(c, b, frame);
        const double off = v != NULL ? read_as(turns, t, v) : HUGE_VAL;

        if (off < least) {
            least = off;
            best = v;
        }
    }
    if (best != NULL) {
        read_as(turns, t, best);
    }
    return best;
}

/* Turns all views of a frame alike. If times are known, the target is put as near as
 * possible to where it was in the frame before, because its motion is wanted. Returns the
 * number of views that were read differently from most. */
static size_t turn_frame(const turning *t, size_t frame, rigcal_transform *before,
                         int *has_before, size_t turns[], const uint32_t where[])
{
    const calibration *c = t->c;
    const view *best = read_frame(turns, t, frame);
    rigcal_transform expected, taken;
    size_t b, all, n_others = 0;

    if (best == NULL) {
        return 0;
    }
    all = usual_turns(&n_others, t, frame, turns);
    if (*has_before && c->times.path != NULL) {
        rigcal_transform_compose(&expected, &t->in_rig[best->camera], before);
        nearest_reading(&all, t, best, &expected);
    }
    for (b = 0; b < c->cameras.names.count; b++) {
        view *v = view_in(c, b, frame);
        const size_t k = (turns[b] + all) % t->n_turns;

        if (v != NULL && k > 0) {
            turn_view(t, v, k, where);
        }
    }
    rigcal_transform_invert(&expected, &t->in_rig[best->camera]);
    taken = kept_transform(view_taken(best));
    rigcal_transform_compose(before, &expected, &taken);
    *has_before = 1;
    return n_others;
}

void turn_views(calibration *c)
{
    const size_t n = c->cameras.names.count;
    turning t = {c, 1, {{{0}, {0}}}, NULL, NULL, NULL};
    const cli_observation **place;
    uint32_t *where;
    rigcal_transform before;
    size_t *turns, frame, p, n_turned = 0;
    int has_before = 0;

    find_turn(&t);
    if (t.n_turns == 1) {
        return;
    }
    t.in_rig = cli_alloc(n, sizeof *t.in_rig);
    t.is_in = cli_alloc(n, sizeof *t.is_in);
    t.shared = cli_alloc(n * n, sizeof *t.shared);
    turns = cli_alloc(n, sizeof *turns);
    place_cameras(&t);
    place = places_of(&c->observations);
    where = cli_alloc(c->observations.points.count, sizeof *where);
    for (p = 0; p < c->observations.points.count; p++) {
        where[p] = place[p]->place;
    }
    for (frame = 0; frame < c->observations.frames.count; frame++) {
        n_turned += turn_frame(&t, frame, &before, &has_before, turns, where);
    }
    if (n_turned > 0) {
        cli_say("the target looks the same from %lu sides: %lu of %lu views were read from "
                "another side than the rest, and are turned",
                (unsigned long)t.n_turns, (unsigned long)n_turned,
                (unsigned long)c->n_views);
    }
    cli_free(place);
    cli_free(where);
    cli_free(turns);
    cli_free(t.in_rig);
    cli_free(t.is_in);
    cli_free(t.shared);
}
