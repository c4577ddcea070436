/* rigcal triangulate: pixels of a calibrated rig to points in space. */
#include "cli.h"
#include "cli_covariance.h"

#include <math.h>
#include <string.h>

typedef struct {
    size_t frame, point; /* numbers of their names */
    size_t n;            /* number of cameras that it is measured from */
    rigcal_real X[3], Sigma[9], rms_px, chi2, freedom;
    const char *left_out; /* cameras whose views contradict the others; "": none */
} measurement;

typedef struct {
    cli_cameras cameras;
    cli_rig rig;
    cli_transforms targets;
    cli_observations observations;
    int in_targets;
    int is_noise_known; /* 0: Sigma is for noise of one pixel, until the noise is
                           estimated */
    int exit_status;
    measurement *list;
    size_t count, n_failed, n_left_out, n_poor;

    /* Work: the views of one point. */
    rigcal_calibrated_rig exact; /* the rig without its covariance */
    rigcal_sighting *seen;
    rigcal_real *noise, *work;
    uint8_t *used;
    size_t work_capacity;
} triangulation;

static void name_unused_cameras(const triangulation *t)
{
    size_t i;

    for (i = 0; i < t->cameras.names.count; i++) {
        const char *name = t->cameras.names.name[i];

        if (cli_names_find(&t->rig.file.names, name) == CLI_UNKNOWN) {
            cli_say("camera %s is not in %s: what it observed is not used", name,
                    t->rig.file.table.path);
        }
    }
}

/* Allocates memory for the views of one point: at most one for each camera. */
static void open_work(triangulation *t)
{
    const size_t n = t->rig.rig.n_cameras;

    t->exact = t->rig.rig;
    t->exact.sigma_px = 0;
    t->seen = cli_alloc(n, sizeof *t->seen);
    t->used = cli_alloc(n, sizeof *t->used);
    t->work_capacity = rigcal_point_work(n);
    t->work = cli_alloc(t->work_capacity, sizeof *t->work);
    t->noise = cli_alloc(n, sizeof *t->noise);
}

static void open_triangulation(triangulation *t, const char *const option[OPTION_COUNT])
{
    double sigma_px = 0;

    memset(t, 0, sizeof *t);
    if (option[OPTION_SIGMA] != NULL) {
        sigma_px = cli_sigma(option[OPTION_SIGMA]);
    }
    cli_cameras_read(&t->cameras, option[OPTION_CAMERAS]);
    cli_rig_read(&t->rig, option[OPTION_RIG], &t->cameras, sigma_px);
    if (t->rig.rig.n_cameras > RIGCAL_SIGHTINGS_MAX) {
        cli_fail("%s has %lu cameras: a point is measured from %d at most",
                 t->rig.file.table.path, (unsigned long)t->rig.rig.n_cameras,
                 (int)RIGCAL_SIGHTINGS_MAX);
    }
    t->is_noise_known = t->rig.noise_px > 0;
    cli_observations_read(&t->observations, option[OPTION_OBSERVATIONS], &t->cameras, 0);
    name_unused_cameras(t);
    t->in_targets = option[OPTION_TARGETS] != NULL;
    if (t->in_targets) {
        cli_transforms_read(&t->targets, option[OPTION_TARGETS], "frame", NULL);
    }
    cli_rig_tell_exact(&t->rig);
    t->list = cli_alloc(t->observations.count, sizeof *t->list);
    open_work(t);
}

static const char *name_of(const triangulation *t, size_t view)
{
    return t->rig.file.names.name[t->seen[view].camera];
}

/* Gathers the views of one point by cameras of the rig. Returns their number. */
static size_t gather(triangulation *t, const cli_observation list[], size_t n)
{
    size_t i, count = 0;

    for (i = 0; i < n; i++) {
        const char *name = t->cameras.names.name[list[i].camera];
        const size_t in_rig = cli_names_find(&t->rig.file.names, name);

        if (in_rig != CLI_UNKNOWN) {
            t->seen[count].camera = (int32_t)in_rig;
            memcpy(t->seen[count].uv, list[i].uv, sizeof t->seen[count].uv);
            count++;
        }
    }
    return count;
}

/* Names the first few points that failed. The CSV file shows which others are missing. */
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

/* Puts the views that were dropped into the CSV file, and the first few into a message. */
static void name_left_out(triangulation *t, measurement *m, size_t n, int only_two)
{
    enum { NAMED = 5 };
    size_t i;

    for (i = 0; i < n; i++) {
        if (!t->used[i]) {
            m->left_out = *m->left_out == '\0'
                              ? name_of(t, i)
                              : cli_text("%s %s", m->left_out, name_of(t, i));
        }
    }
    t->exit_status = CLI_GEOMETRY;
    if (t->n_left_out++ < NAMED) {
        cli_say(
            "frame %s, point %s: left out, because it contradicts the others: camera %s%s",
            t->observations.frames.name[m->frame], t->observations.points.name[m->point],
            m->left_out,
            only_two ? "; only two cameras agree, which wrong ones may do by chance" : "");
    }
}

/* Without the joint covariance of the rig no view is dropped, because the rig may be the
 * cause of a disagreement. */
static void measure(triangulation *t, const cli_observation list[], size_t n,
                    const rigcal_calibrated_rig *rig, const rigcal_real *sigma_px)
{
    const rigcal_sightings s = {.rig = rig,
                                .seen = t->seen,
                                .n = gather(t, list, n),
                                .sigma_px = sigma_px,
                                .keep_all = !(rig->sigma_px > 0),
                                .work = t->work,
                                .work_capacity = t->work_capacity};
    measurement *m = &t->list[t->count];
    rigcal_measured_point p;
    rigcal_status status;

    memset(&p, 0, sizeof p);
    m->frame = list[0].frame;
    m->point = cli_point(&t->observations, &list[0]);
    m->left_out = "";
    if (s.n < 2) {
        return;
    }
    status = rigcal_point_measure(&p, t->used, &s);
    if (status < 0) {
        name_failed(t, m, status);
        return;
    }
    if (status == RIGCAL_VIEWS_LEFT_OUT || status == RIGCAL_FEW_AGREE) {
        name_left_out(t, m, s.n, status == RIGCAL_FEW_AGREE);
    }
    t->n_poor += status == RIGCAL_POOR_FIT;
    memcpy(m->X, p.X, sizeof m->X);
    memcpy(m->Sigma, p.Sigma, sizeof m->Sigma);
    m->rms_px = p.rms_px;
    m->chi2 = p.chi2;
    m->freedom = p.freedom;
    m->n = p.n_used;
    t->count++;
}

static void measure_all(triangulation *t, const rigcal_calibrated_rig *rig,
                        const rigcal_real *sigma_px)
{
    const cli_observation *list = t->observations.list;
    const size_t count = t->observations.count;
    size_t begin, end;

    t->count = t->n_failed = t->n_poor = 0;
    for (begin = 0; begin < count; begin = end) {
        for (end = begin; end < count && list[end].frame == list[begin].frame &&
                          cli_point(&t->observations, &list[end]) ==
                              cli_point(&t->observations, &list[begin]);
             end++) {
        }
        measure(t, list + begin, end - begin, rig, sigma_px);
    }
}

/* The noise of a pixel. A point uses up 3 of its 2 n coordinates; what is left of the
 * residuals is noise. */
static double estimate_sigma(const triangulation *t)
{
    double sum = 0, freedom = 0;
    size_t i;

    for (i = 0; i < t->count; i++) {
        const double n = (double)t->list[i].n;
        const double rms = (double)t->list[i].rms_px;

        sum += n * rms * rms;
        freedom += 2 * n - 3;
    }
    return freedom > 0 ? sqrt(sum / freedom) : 0;
}

/* Scales the sigmas, which were for noise of one pixel. */
static void scale_by(triangulation *t, double sigma_px)
{
    size_t i;
    int k;

    for (i = 0; i < t->count; i++) {
        for (k = 0; k < 9; k++) {
            t->list[i].Sigma[k] *= (rigcal_real)(sigma_px * sigma_px);
        }
    }
}

static void set_noise(triangulation *t, double sigma_px)
{
    size_t c;

    for (c = 0; c < t->rig.rig.n_cameras; c++) {
        t->noise[c] = (rigcal_real)sigma_px;
    }
}

/* If the noise is not known, it is estimated from the residuals of the points. A rig with a
 * covariance then measures again with that noise. */
static void measure_with_noise(triangulation *t, const char *sigma)
{
    const rigcal_calibrated_rig *rig = t->rig.rig.sigma_px > 0 ? &t->rig.rig : &t->exact;
    double estimate;

    if (t->is_noise_known) {
        set_noise(t, (double)t->rig.noise_px);
        measure_all(t, rig, t->noise);
        cli_say("noise of a pixel coordinate, %s%s: %.4g px",
                sigma != NULL ? "as given" : "by ",
                sigma != NULL ? "" : t->rig.file.table.path, (double)t->noise[0]);
        return;
    }
    set_noise(t, 1);
    measure_all(t, &t->exact, t->noise);
    estimate = estimate_sigma(t);
    if (t->count > 0) {
        cli_say("noise of a pixel coordinate, estimated from %lu points: %.4g px",
                (unsigned long)t->count, estimate);
    }
    if (rig == &t->exact || !(estimate >= RIGCAL_CLI_SIGMA_LEAST)) {
        scale_by(t, estimate);
        return;
    }
    set_noise(t, estimate);
    measure_all(t, rig, t->noise);
}

/* The covariance of R X if that of X is S: R S R^T. */
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

static rigcal_status into_target(measurement *point,
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

/* Leaves out points of frames in which the place of the target is not known. */
static void move_into_targets(triangulation *t)
{
    size_t i, kept = 0, named = CLI_UNKNOWN;

    for (i = 0; i < t->count; i++) {
        measurement m = t->list[i];
        const char *frame = t->observations.frames.name[m.frame];
        const size_t target = cli_names_find(&t->targets.names, frame);

        if (target != CLI_UNKNOWN &&
            into_target(&m, &t->targets.transform[target]) == RIGCAL_OK) {
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

static void print_points(const triangulation *t)
{
    size_t i;
    int k, j;

    printf("frame,point,ncams,X,Y,Z,sigma_X,sigma_Y,sigma_Z,rms_px,S11,S21,S22,S31,S32,S33,"
           "chi2,freedom,left_out\n");
    for (i = 0; i < t->count; i++) {
        const measurement *m = &t->list[i];
        rigcal_real sigma[3];

        for (k = 0; k < 3; k++) {
            sigma[k] = (rigcal_real)sqrt((double)m->Sigma[4 * k]);
        }
        printf("%s,%s,%lu", t->observations.frames.name[m->frame],
               t->observations.points.name[m->point], (unsigned long)m->n);
        cli_write_numbers(stdout, m->X, 3);
        cli_write_numbers(stdout, sigma, 3);
        cli_write_numbers(stdout, &m->rms_px, 1);
        for (k = 0; k < 3; k++) {
            for (j = 0; j <= k; j++) {
                cli_write_numbers(stdout, &m->Sigma[3 * k + j], 1);
            }
        }
        cli_write_known(stdout, m->chi2, t->is_noise_known);
        cli_write_known(stdout, m->freedom, t->is_noise_known);
        printf(",%s\n", m->left_out);
    }
}

/* Prints the totals of what was named only for the first few points. */
static void tell_counts(const triangulation *t)
{
    if (t->n_left_out > 5) {
        cli_say("views of %lu points are left out: column left_out names them",
                (unsigned long)t->n_left_out);
    }
    if (t->n_poor > 0 && t->rig.rig.sigma_px > 0) {
        cli_say(
            "%lu points of two cameras fit badly: column chi2 is above 6.6, which noise "
            "exceeds once in a hundred times",
            (unsigned long)t->n_poor);
    }
}

int cli_triangulate(const char *const option[OPTION_COUNT])
{
    triangulation t;

    open_triangulation(&t, option);
    measure_with_noise(&t, option[OPTION_SIGMA]);
    if (t.count == 0) {
        cli_say("no point could be measured: two cameras of %s must observe it in "
                "one frame",
                t.rig.file.table.path);
        t.exit_status = CLI_GEOMETRY;
    }
    tell_counts(&t);
    if (t.in_targets) {
        move_into_targets(&t);
    }
    print_points(&t);
    return t.exit_status;
}
