/* rigcal triangulate: pixels of a calibrated rig to points in space. */
#include "cli.h"

#include <math.h>
#include <string.h>

typedef struct {
    size_t frame, point;   /* numbers of their names */
    size_t n;              /* cameras that saw it */
    rigcal_point measured; /* for noise of one pixel */
} measurement;

typedef struct {
    cli_cameras cameras;
    cli_transforms rig, targets;
    cli_observations observations;
    int in_targets;
    int exit_status;
    measurement *list;
    size_t count, n_failed;

    /* Work: the views of one point. */
    rigcal_camera *camera;
    rigcal_transform *cam_from_rig;
    rigcal_real *uv;
} triangulation;

static void name_unused_cameras(const triangulation *t)
{
    size_t i;

    for (i = 0; i < t->cameras.names.count; i++) {
        const char *name = t->cameras.names.name[i];

        if (cli_names_find(&t->rig.names, name) == CLI_UNKNOWN) {
            cli_say("camera %s is not in %s: what it observed is not used", name,
                    t->rig.table.path);
        }
    }
}

static void open_triangulation(triangulation *t, const char *const option[OPTION_COUNT])
{
    size_t most;

    memset(t, 0, sizeof *t);
    cli_cameras_read(&t->cameras, option[OPTION_CAMERAS]);
    cli_transforms_read(&t->rig, option[OPTION_RIG], "camera", &t->cameras);
    cli_observations_read(&t->observations, option[OPTION_OBSERVATIONS], &t->cameras, 0);
    name_unused_cameras(t);
    t->in_targets = option[OPTION_TARGETS] != NULL;
    if (t->in_targets) {
        cli_transforms_read(&t->targets, option[OPTION_TARGETS], "frame", NULL);
    }
    most = t->cameras.names.count;
    t->list = cli_alloc(t->observations.count, sizeof *t->list);
    t->camera = cli_alloc(most, sizeof *t->camera);
    t->cam_from_rig = cli_alloc(most, sizeof *t->cam_from_rig);
    t->uv = cli_alloc(2 * most, sizeof *t->uv);
}

/* The views of one point by cameras of the rig; returns how many. */
static size_t gather(triangulation *t, const cli_observation seen[], size_t n)
{
    size_t i, count = 0;

    for (i = 0; i < n; i++) {
        const char *name = t->cameras.names.name[seen[i].camera];
        const size_t in_rig = cli_names_find(&t->rig.names, name);

        if (in_rig != CLI_UNKNOWN) {
            t->camera[count] = t->cameras.camera[seen[i].camera];
            t->cam_from_rig[count] = t->rig.transform[in_rig];
            t->uv[2 * count] = seen[i].seen.uv[0];
            t->uv[2 * count + 1] = seen[i].seen.uv[1];
            count++;
        }
    }
    return count;
}

/* The first few; the CSV shows which of the others are missing. */
static void name_failed(triangulation *t, const measurement *m, rigcal_status status)
{
    enum { NAMED = 5 };

    t->exit_status = CLI_GEOMETRY;
    if (t->n_failed++ < NAMED) {
        cli_say("frame %s, point %s cannot be triangulated: %s",
                t->observations.frames.name[m->frame],
                t->observations.points.name[m->point], rigcal_status_text(status));
    }
    if (t->n_failed == NAMED + 1) {
        cli_say("more points cannot be triangulated; they are not in the output");
    }
}

static void measure(triangulation *t, const cli_observation seen[], size_t n)
{
    measurement *m = &t->list[t->count];
    rigcal_status status;

    m->frame = seen[0].frame;
    m->point = seen[0].point;
    m->n = gather(t, seen, n);
    if (m->n < 2) {
        return;
    }
    status =
        rigcal_point_triangulate(&m->measured, t->camera, t->cam_from_rig, t->uv, m->n, 1);
    if (status < 0) {
        name_failed(t, m, status);
        return;
    }
    t->count++;
}

static void measure_all(triangulation *t)
{
    const cli_observation *list = t->observations.list;
    const size_t count = t->observations.count;
    size_t begin, end;

    for (begin = 0; begin < count; begin = end) {
        for (end = begin; end < count && list[end].frame == list[begin].frame &&
                          list[end].point == list[begin].point;
             end++) {
        }
        measure(t, list + begin, end - begin);
    }
}

/* A point takes 3 of its 2 n coordinates; what they miss by is noise. */
static double estimate_sigma(const triangulation *t)
{
    double sum = 0, freedom = 0;
    size_t i;

    for (i = 0; i < t->count; i++) {
        const double n = (double)t->list[i].n;
        const double rms = (double)t->list[i].measured.rms_px;

        sum += n * rms * rms;
        freedom += 2 * n - 3;
    }
    return freedom > 0 ? sqrt(sum / freedom) : 0;
}

/* given: 0 if it is not. */
static double choose_sigma(const triangulation *t, double given)
{
    const double sigma = given > 0 ? given : estimate_sigma(t);

    if (given > 0) {
        cli_say("noise of a pixel coordinate, as given: %.4g px", sigma);
    } else if (t->count > 0) {
        cli_say("noise of a pixel coordinate, estimated from %lu points: %.4g px",
                (unsigned long)t->count, sigma);
    }
    return sigma;
}

/* Sigma of R X when that of X is S: R S R^T. */
static void turn_covariance(rigcal_real Sigma[9], const rigcal_real R[9])
{
    rigcal_real RS[9], turned[9];
    int i, j;

    for (i = 0; i < 3; i++) {
        for (j = 0; j < 3; j++) {
            RS[3 * i + j] = R[3 * i] * Sigma[j] + R[3 * i + 1] * Sigma[3 + j] +
                            R[3 * i + 2] * Sigma[6 + j];
        }
    }
    for (i = 0; i < 3; i++) {
        for (j = 0; j < 3; j++) {
            turned[3 * i + j] = RS[3 * i] * R[3 * j] + RS[3 * i + 1] * R[3 * j + 1] +
                                RS[3 * i + 2] * R[3 * j + 2];
        }
    }
    memcpy(Sigma, turned, sizeof turned);
}

static rigcal_status into_target(rigcal_point *point,
                                 const rigcal_transform *rig_from_target)
{
    rigcal_transform target_from_rig;
    rigcal_real X[3];
    rigcal_status status;

    status = rigcal_transform_invert(&target_from_rig, rig_from_target);
    if (status == RIGCAL_OK) {
        status = rigcal_transform_point(X, &target_from_rig, point->X);
    }
    if (status == RIGCAL_OK) {
        memcpy(point->X, X, sizeof X);
        turn_covariance(point->Sigma, target_from_rig.R);
    }
    return status;
}

/* Points of a frame whose target has no known place are left out. */
static void move_into_targets(triangulation *t)
{
    size_t i, kept = 0, named = CLI_UNKNOWN;

    for (i = 0; i < t->count; i++) {
        measurement m = t->list[i];
        const char *frame = t->observations.frames.name[m.frame];
        const size_t target = cli_names_find(&t->targets.names, frame);

        if (target != CLI_UNKNOWN &&
            into_target(&m.measured, &t->targets.transform[target]) == RIGCAL_OK) {
            t->list[kept++] = m;
            continue;
        }
        if (named != m.frame) {
            const char *alike = cli_names_alike(&t->targets.names, frame);

            cli_say("frame %s has no place in %s%s%s; its points are left out", frame,
                    t->targets.table.path, alike != NULL ? ", which has frame " : "",
                    alike != NULL ? alike : "");
            named = m.frame;
        }
        t->exit_status = CLI_GEOMETRY;
    }
    t->count = kept;
}

static void print_points(const triangulation *t, double sigma_px)
{
    size_t i;
    int k;

    printf("frame,point,ncams,X,Y,Z,sigma_X,sigma_Y,sigma_Z,rms_px\n");
    for (i = 0; i < t->count; i++) {
        const measurement *m = &t->list[i];
        rigcal_real sigma[3];

        for (k = 0; k < 3; k++) {
            sigma[k] = (rigcal_real)(sigma_px * sqrt((double)m->measured.Sigma[4 * k]));
        }
        printf("%s,%s,%lu", t->observations.frames.name[m->frame],
               t->observations.points.name[m->point], (unsigned long)m->n);
        cli_write_numbers(stdout, m->measured.X, 3);
        cli_write_numbers(stdout, sigma, 3);
        cli_write_numbers(stdout, &m->measured.rms_px, 1);
        printf("\n");
    }
}

int cli_triangulate(const char *const option[OPTION_COUNT])
{
    triangulation t;
    double sigma_px = 0;

    if (option[OPTION_SIGMA] != NULL) {
        sigma_px = cli_sigma(option[OPTION_SIGMA]);
    }
    open_triangulation(&t, option);
    measure_all(&t);
    if (t.count == 0) {
        cli_say("no point could be measured: two cameras of %s must observe it in "
                "one frame",
                t.rig.table.path);
        t.exit_status = CLI_GEOMETRY;
    }
    sigma_px = choose_sigma(&t, sigma_px);
    if (t.in_targets) {
        move_into_targets(&t);
    }
    print_points(&t, sigma_px);
    return t.exit_status;
}
