/* rigcal monitor: whether a camera of a calibrated rig has moved, which one, and where it
 * is now. */
#include "cli.h"
#include "cli_os.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define DEGREE 57.295779513082320877

/* frames: an alarm is answered after this many. */
enum { FRAMES_TO_ANSWER = 15 };

/* 1: above this probability only the likeliest camera is named. */
static const double TOLD = 0.9;

typedef struct {
    const char *path; /* path of the stored bytes */
    cli_transforms file;
    cli_cameras cameras; /* names from rig.csv, intrinsics from the stored bytes */
    rigcal_calibrated_rig rig;
    rigcal_real *monitor;
    rigcal_real sigma_px;
    rigcal_monitor_report report;
    double time, alarm_time;
    int has_time;
    unsigned long rows_before, n_alarms, n_unused;
} watch;

/* ==== the rig ============================================================= */

/* The path of "rig.bin" in the folder of "rig.csv". */
static const char *beside(const char *path)
{
    const size_t length = strlen(path);

    if (length < 4 || strcmp(path + length - 4, ".csv") != 0) {
        cli_fail("--rig %s: give the rig.csv that calibrate wrote, with the rig.bin "
                 "beside it",
                 path);
    }
    return cli_text("%.*s.bin", (int)(length - 4), path);
}

static uint8_t *read_bytes(size_t *n_bytes, const char *path)
{
    enum { CHUNK = 65536 };
    FILE *file = cli_os_open(path);
    uint8_t *bytes = cli_alloc(CHUNK, 1);
    size_t got;

    if (file == NULL) {
        cli_fail("cannot read %s, which calibrate --out writes beside rig.csv: %s", path,
                 strerror(errno));
    }
    *n_bytes = 0;
    while ((got = fread(bytes + *n_bytes, 1, CHUNK, file)) > 0) {
        *n_bytes += got;
        bytes = cli_resize(bytes, *n_bytes + CHUNK, 1);
    }
    if (ferror(file)) {
        cli_fail("cannot read %s", path);
    }
    fclose(file);
    return bytes;
}

static void check_status(const watch *w, rigcal_status status)
{
    if (status != RIGCAL_OK) {
        cli_fail("%s: %s", w->path, rigcal_status_text(status));
    }
}

static void read_stored(watch *w)
{
    rigcal_calibrated_rig *rig = &w->rig;
    rigcal_saved_info info;
    size_t n_bytes, n;
    const uint8_t *bytes = read_bytes(&n_bytes, w->path);

    check_status(w, rigcal_store_info(&info, bytes, n_bytes));
    if (info.n_free < 0) {
        cli_fail("%s has no joint covariance of the cameras: calibrate with --sigma, from "
                 "views that connect all cameras",
                 w->path);
    }
    n = (size_t)info.n_cameras;
    rig->capacity = n;
    rig->Sigma_capacity = RIGCAL_CALIBRATED_SIZE(info.n_free);
    rig->cameras = cli_alloc(n, sizeof *rig->cameras);
    rig->group = cli_alloc(n, sizeof *rig->group);
    rig->held = cli_alloc(n, sizeof *rig->held);
    rig->Sigma = cli_alloc(rig->Sigma_capacity + 1, sizeof *rig->Sigma);
    check_status(w, rigcal_store_load_rig(rig, &info, bytes, n_bytes));
}

/* Gives the cameras the names of rig.csv, in its order. */
static void name_cameras(watch *w, const char *path)
{
    static const double ROUNDING = 1e-6;
    size_t i, k;

    cli_transforms_read(&w->file, path, "camera", NULL);
    w->cameras.names = w->file.names;
    w->cameras.table = w->file.table;
    w->cameras.camera = cli_alloc(w->rig.n_cameras, sizeof *w->cameras.camera);
    for (i = 0; i < w->rig.n_cameras && i < w->file.names.count; i++) {
        const rigcal_transform *a = &w->rig.cameras[i].cam_from_rig;
        const rigcal_transform *b = &w->file.transform[i];
        double off = 0, size = 1;

        w->cameras.camera[i] = w->rig.cameras[i].camera;
        for (k = 0; k < 9; k++) {
            off = fmax(off, fabs((double)(a->R[k] - b->R[k])));
        }
        for (k = 0; k < 3; k++) {
            size = fmax(size, fabs((double)a->t[k]));
            off = fmax(off, fabs((double)(a->t[k] - b->t[k])) / size);
        }
        if (off > ROUNDING) {
            cli_fail("%s and %s are not of one calibration: camera %s is elsewhere", path,
                     w->path, w->file.names.name[i]);
        }
    }
    if (w->rig.n_cameras != w->file.names.count) {
        cli_fail("%s has %lu cameras and %s %lu: they are not of one calibration", path,
                 (unsigned long)w->file.names.count, w->path,
                 (unsigned long)w->rig.n_cameras);
    }
}

/* ==== options ============================================================= */

static double within(const char *name, const char *text, double least, double most)
{
    double value;

    cli_numbers(&value, 1, name, text);
    if (!(value >= least && value <= most)) {
        cli_fail("%s is from %g to %g, not \"%s\"", name, least, most, text);
    }
    return value;
}

static void choose(rigcal_monitor_options *o, const char *const option[OPTION_COUNT])
{
    rigcal_monitor_defaults(o);
    if (option[OPTION_ARL0] != NULL) {
        o->arl0_frames = (rigcal_real)within("--arl0", option[OPTION_ARL0], 100, 1e9);
    }
    if (option[OPTION_COMMON] != NULL) {
        o->common = (rigcal_real)within("--common", option[OPTION_COMMON], 0, 1);
    }
    if (option[OPTION_WRONG] != NULL) {
        o->wrong = (rigcal_real)within("--wrong", option[OPTION_WRONG], 0, 0.9);
    }
    if (option[OPTION_WALK] != NULL) {
        double walk[2];

        cli_numbers(walk, 2, "--walk", option[OPTION_WALK]);
        if (!(walk[0] >= 0 && walk[0] <= DEGREE && walk[1] >= 0)) {
            cli_fail("--walk is degrees and a length a square root of a second, 0 or more, "
                     "not \"%s\"",
                     option[OPTION_WALK]);
        }
        o->walk_rad = (rigcal_real)(walk[0] / DEGREE);
        o->walk_t = (rigcal_real)walk[1];
    }
}

static void begin(watch *w, const char *const option[OPTION_COUNT])
{
    const size_t size = RIGCAL_MONITOR_SIZE(w->rig.n_cameras, 0);
    rigcal_monitor_options options;
    rigcal_status status;

    choose(&options, option);
    w->sigma_px = option[OPTION_SIGMA] != NULL
                      ? (rigcal_real)cli_sigma(option[OPTION_SIGMA])
                      : w->rig.sigma_px;
    w->monitor = cli_alloc(size, sizeof *w->monitor);
    status = rigcal_monitor_begin(w->monitor, size, &w->rig, 0, &options);
    if (status != RIGCAL_OK) {
        cli_fail("%s cannot be watched: %s", w->path, rigcal_status_text(status));
    }
}

/* ==== what it says ======================================================== */

static const char *name_of(const watch *w, size_t camera)
{
    return w->cameras.names.name[camera];
}

static void print_header(const watch *w)
{
    size_t i;

    printf("time_s,rows,evidence,noise,smallest_deg,n_blind,alarm,camera,probability");
    for (i = 0; i < w->rig.n_cameras; i++) {
        const char *const columns[] = {"R11", "R12", "R13",          "R21", "R22",
                                       "R23", "R31", "R32",          "R33", "tx",
                                       "ty",  "tz",  "sigma_rot_deg"};
        size_t k;

        for (k = 0; k < sizeof columns / sizeof columns[0]; k++) {
            printf(",%s.%s", name_of(w, i), columns[k]);
        }
    }
    printf("\n");
}

static void print_frame(const watch *w)
{
    const rigcal_monitor_report *r = &w->report;
    size_t i;

    printf("%.12g,%lu", w->time, (unsigned long)r->rows - w->rows_before);
    cli_write_numbers(stdout, &r->evidence, 1);
    cli_write_numbers(stdout, &r->noise, 1);
    cli_write_known(stdout, (rigcal_real)((double)r->smallest_rad * DEGREE),
                    r->smallest_rad > 0);
    printf(",%ld,%ld,%s", (long)r->n_blind, (long)r->alarm, name_of(w, (size_t)r->body));
    cli_write_known(stdout, r->confidence, r->alarm != 0);
    for (i = 0; i < w->rig.n_cameras; i++) {
        rigcal_mounted_camera now;
        rigcal_real sigma = 0;

        if (rigcal_monitor_camera(&now, w->monitor, i) != RIGCAL_OK) {
            cli_fail("the pose of camera %s is lost", name_of(w, i));
        }
        sigma = (rigcal_real)(sqrt((double)(now.Sigma[0] + now.Sigma[7] + now.Sigma[14])) *
                              DEGREE);
        cli_write_transform(stdout, &now.cam_from_rig);
        cli_write_numbers(stdout, &sigma, 1);
    }
    printf("\n");
}

/* How far a camera has turned, and how far its centre has moved, in the frame of another
 * camera. */
static void change(double *deg, double *shift, const rigcal_transform *before,
                   const rigcal_transform *after)
{
    double trace = 0, squares = 0, sine = 0, o[2][3];
    const rigcal_transform *both[2];
    int i, j, k;

    both[0] = before;
    both[1] = after;
    for (k = 0; k < 9; k++) {
        trace += (double)before->R[k] * (double)after->R[k];
        sine += pow((double)before->R[k] - (double)after->R[k], 2);
    }
    for (i = 0; i < 2; i++) {
        for (j = 0; j < 3; j++) {
            o[i][j] = 0;
            for (k = 0; k < 3; k++) {
                o[i][j] -= (double)both[i]->R[3 * k + j] * (double)both[i]->t[k];
            }
        }
    }
    for (j = 0; j < 3; j++) {
        squares += pow(o[1][j] - o[0][j], 2);
    }
    *deg = DEGREE * atan2(sqrt(sine * fmax(0, 8 - sine)) / 4, (trace - 1) / 2);
    *shift = sqrt(squares);
}

/* Names and probabilities of the cameras that may have moved. With only two cameras,
 * matches do not show which one it was. */
static const char *suspects(const watch *w)
{
    const char *text = "";
    size_t i;

    if (w->rig.n_cameras == 2) {
        return cli_text("%s or %s", name_of(w, 0), name_of(w, 1));
    }

    for (i = 0; i < w->rig.n_cameras; i++) {
        rigcal_body_report body;

        if (rigcal_monitor_body(&body, w->monitor, i) == RIGCAL_OK &&
            (double)body.blame > 1 - TOLD) {
            text = cli_text("%s%s%s (probability %.2f)", text, *text ? ", " : "",
                            name_of(w, i), (double)body.blame);
        }
    }
    return text;
}

/* Answers an alarm: solves again who moved, and prints it. */
static void answer(watch *w)
{
    const size_t body = (size_t)w->report.body, other = body == 0;
    const double probability = (double)w->report.confidence;
    const char *who = suspects(w);
    rigcal_transform before, after;
    rigcal_real Sigma[36];
    double deg, shift;

    if (rigcal_monitor_pair(&before, Sigma, w->monitor, other, body) != RIGCAL_OK ||
        rigcal_monitor_moved(w->monitor, body) != RIGCAL_OK ||
        rigcal_monitor_pair(&after, Sigma, w->monitor, other, body) != RIGCAL_OK) {
        cli_fail("the camera that moved, %s, cannot be solved", name_of(w, body));
    }
    change(&deg, &shift, &before, &after);
    if (probability > TOLD && w->rig.n_cameras > 2) {
        cli_say("alarm at %.6g s: camera %s moved (probability %.3f). It turned by %.3g "
                "degrees and its centre shifted by %.3g; it is solved anew",
                w->alarm_time, name_of(w, body), probability, deg, shift);
    } else {
        cli_say("alarm at %.6g s: a camera moved, and nothing shows which: %s. A turn of "
                "%.3g degrees and a shift of %.3g between %s and %s are taken for %s's",
                w->alarm_time, who, deg, shift, name_of(w, other), name_of(w, body),
                name_of(w, body));
    }
}

static void end_frame(watch *w, double next)
{
    static double before;
    const double seconds = w->report.frames > 0 ? w->time - before : 0;
    const rigcal_status status =
        rigcal_monitor_frame(&w->report, w->monitor, (rigcal_real)seconds);

    if (status != RIGCAL_OK) {
        cli_fail("the frame at %.12g s, %.6g s after the one before: %s", w->time, seconds,
                 rigcal_status_text(status));
    }
    print_frame(w);
    before = w->time;
    w->time = next;
    w->rows_before = w->report.rows;
    if (w->report.alarm && w->report.frames_since == 1) {
        w->n_alarms++;
        w->alarm_time = before;
    }
    if (w->report.alarm && w->report.frames_since >= FRAMES_TO_ANSWER) {
        answer(w);
        w->report.alarm = 0;
    }
}

/* Prints the smallest moves that would have been noticed. */
static void tell_limits(const watch *w)
{
    double worst = 0;
    size_t i, at = 0;

    for (i = 0; i < w->rig.n_cameras; i++) {
        rigcal_body_report body;

        if (rigcal_monitor_body(&body, w->monitor, i) != RIGCAL_OK) {
            continue;
        }
        if (body.is_blind) {
            cli_say("camera %s is blind: it has too few matches to tell whether it moved",
                    name_of(w, i));
        } else if ((double)body.smallest_rad > worst) {
            worst = (double)body.smallest_rad;
            at = i;
        }
    }
    if (worst > 0) {
        cli_say("a turn of camera %s by less than %.2g degrees about its worst axis would "
                "not have been noticed",
                name_of(w, at), worst * DEGREE);
    }
    if (w->n_unused > 0) {
        cli_say("%lu matches were not used: the lens has no ray there, or they lie on the "
                "line through both cameras",
                w->n_unused);
    }
}

static void tell_end(watch *w)
{
    if (w->report.alarm) {
        cli_say("alarm at %.6g s, and the frames end %lu frames after it. Who moved: %s",
                w->alarm_time, (unsigned long)w->report.frames_since, suspects(w));
    }
    if (w->n_alarms == 0) {
        cli_say("no alarm in %lu frames with %lu matches", (unsigned long)w->report.frames,
                (unsigned long)w->report.rows);
    }
    tell_limits(w);
}

/* ==== frames ============================================================== */

/* Returns 1 if the match was taken, 0 if it cannot be used. */
static int take_match(watch *w, size_t a, const rigcal_real uv_a[2], size_t b,
                      const rigcal_real uv_b[2], rigcal_status *status)
{
    *status = rigcal_monitor_match(w->monitor, a, uv_a, b, uv_b, w->sigma_px);
    w->n_unused += *status != RIGCAL_OK;
    return *status == RIGCAL_OK || *status == RIGCAL_ERR_NO_RAY ||
           *status == RIGCAL_ERR_BEHIND || *status == RIGCAL_ERR_DEGENERATE;
}

/* A time in full precision, whatever rigcal_real is. */
static double time_in(const csv_table *table, size_t row, size_t column)
{
    const char *problem = NULL, *text = csv_id(table, row, column), *rest;
    double time;

    rest = cli_number(&time, &problem, text);
    if (problem != NULL || *rest != '\0') {
        csv_fail(table, row, "time_s is \"%s\": it is to be a number of seconds", text);
    }
    return time;
}

static size_t camera_in(const watch *w, const csv_table *table, size_t column)
{
    const char *name = csv_id(table, 0, column);
    const size_t camera = cli_names_find(&w->cameras.names, name);

    if (camera == CLI_UNKNOWN) {
        csv_fail(table, 0, "camera %s is not in %s", name, w->cameras.table.path);
    }
    return camera;
}

static void run_matches(watch *w, const char *path)
{
    csv_table table;
    size_t time, camera[2], at[4];
    static const char *const PIXELS[] = {"u_a", "v_a", "u_b", "v_b"};
    int k;

    csv_open(&table, path);
    table.form = "matches.csv";
    time = csv_column(&table, "time_s");
    camera[0] = csv_column(&table, "camera_a");
    camera[1] = csv_column(&table, "camera_b");
    for (k = 0; k < 4; k++) {
        at[k] = csv_column(&table, PIXELS[k]);
    }
    while (csv_next(&table)) {
        const double now = time_in(&table, 0, time);
        const size_t a = camera_in(w, &table, camera[0]);
        const size_t b = camera_in(w, &table, camera[1]);
        rigcal_real uv[4];
        rigcal_status status;

        for (k = 0; k < 4; k++) {
            uv[k] = csv_real(&table, 0, at[k]);
        }
        if (w->has_time && now < w->time) {
            csv_fail(&table, 0, "time_s is %.12g, before the %.12g of the line before", now,
                     w->time);
        }
        if (a == b) {
            csv_fail(&table, 0, "camera_a and camera_b are both %s", name_of(w, a));
        }
        if (w->has_time && now > w->time) {
            end_frame(w, now);
        }
        w->time = now;
        w->has_time = 1;
        if (!take_match(w, a, uv, b, &uv[2], &status)) {
            csv_fail(&table, 0, "%s", rigcal_status_text(status));
        }
    }
    end_frame(w, w->time);
}

typedef struct {
    double time; /* the sum of n_times times, then their mean */
    size_t first, n, n_times;
} timed_frame;

static int by_time(const void *a, const void *b)
{
    const timed_frame *x = a, *y = b;

    return (x->time > y->time) - (x->time < y->time);
}

/* Reads the frames of observations with their times. If cameras have times of their own, a
 * frame has the mean of these. */
static timed_frame *read_times(const cli_observations *o, const char *path)
{
    timed_frame *frames = cli_alloc(o->frames.count, sizeof *frames);
    csv_table table;
    size_t row, i, frame, time;

    csv_read(&table, path);
    table.form = "times.csv";
    frame = csv_column(&table, "frame");
    time = csv_column(&table, "time_s");
    for (i = 0; i < o->count; i++) {
        timed_frame *f = &frames[o->list[i].frame];

        f->first = f->n == 0 ? i : f->first;
        f->n++;
    }
    for (row = 0; row < table.n_rows; row++) {
        const size_t number = cli_names_find(&o->frames, csv_id(&table, row, frame));

        if (number != CLI_UNKNOWN) {
            frames[number].time += time_in(&table, row, time);
            frames[number].n_times++;
        }
    }
    for (i = 0; i < o->frames.count; i++) {
        if (frames[i].n_times == 0) {
            cli_fail("%s has no time_s of frame %s", path, o->frames.name[i]);
        }
        frames[i].time /= (double)frames[i].n_times;
    }
    qsort(frames, o->frames.count, sizeof *frames, by_time);
    return frames;
}

/* If two cameras or more saw a point in a frame, each of them and the next one make a
 * match. */
static void run_observations(watch *w, const char *path, const char *times_path)
{
    cli_observations o;
    timed_frame *frames;
    size_t f, i;

    cli_observations_read(&o, path, &w->cameras, 0);
    frames = read_times(&o, times_path);
    for (f = 0; f < o.frames.count; f++) {
        const cli_observation *seen = &o.list[frames[f].first];

        if (w->has_time) {
            end_frame(w, frames[f].time);
        }
        w->time = frames[f].time;
        w->has_time = 1;
        for (i = 0; i + 1 < frames[f].n; i++) {
            rigcal_status status;

            if (cli_point(&o, &seen[i]) == cli_point(&o, &seen[i + 1]) &&
                !take_match(w, seen[i].camera, seen[i].uv, seen[i + 1].camera,
                            seen[i + 1].uv, &status)) {
                cli_fail("%s:%lu: %s", path, (unsigned long)seen[i].line,
                         rigcal_status_text(status));
            }
        }
    }
    end_frame(w, w->time);
}

int cli_monitor(const char *const option[OPTION_COUNT])
{
    const char *observations = option[OPTION_OBSERVATIONS];
    watch w;

    memset(&w, 0, sizeof w);
    if ((option[OPTION_MATCHES] != NULL) == (observations != NULL)) {
        cli_fail("monitor needs --matches, or --observations with --times");
    }
    if ((observations != NULL) != (option[OPTION_TIMES] != NULL)) {
        cli_fail("--observations and --times go together: give both");
    }
    w.path = beside(option[OPTION_RIG]);
    read_stored(&w);
    name_cameras(&w, option[OPTION_RIG]);
    begin(&w, option);
    print_header(&w);
    if (observations != NULL) {
        run_observations(&w, observations, option[OPTION_TIMES]);
    } else {
        run_matches(&w, option[OPTION_MATCHES]);
    }
    tell_end(&w);
    return w.n_alarms > 0 ? CLI_GEOMETRY : CLI_DONE;
}
