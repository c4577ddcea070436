/* The times of frames: --times, --clocks, --drift, --sigma-time; and --intrinsics-sigma. */
#include "cli_calibrate.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ==== the stamps of a file ================================================ */

static int compare_stamps(const void *va, const void *vb)
{
    const stamp *a = va, *b = vb;

    if (a->camera != b->camera) {
        return a->camera < b->camera ? -1 : 1;
    }
    return (a->frame > b->frame) - (a->frame < b->frame);
}

static const stamp *find_stamp(const known_times *times, size_t camera, size_t frame)
{
    stamp wanted;

    memset(&wanted, 0, sizeof wanted);
    wanted.camera = camera;
    wanted.frame = frame;
    return bsearch(&wanted, times->stamps, times->n_stamps, sizeof wanted, compare_stamps);
}

/* Refuses a camera that has two lines for one frame. */
static void check_twice(const known_times *times, const csv_table *table,
                        const cli_names *frames, const cli_cameras *cameras)
{
    size_t i;

    for (i = 1; i < times->n_stamps; i++) {
        const stamp *a = &times->stamps[i - 1], *b = &times->stamps[i];

        if (compare_stamps(a, b) == 0) {
            csv_fail_line(table, a->line > b->line ? a->line : b->line,
                          "camera %s in frame %s is on line %lu already: it takes one line",
                          cameras->names.name[b->camera], frames->name[b->frame],
                          (unsigned long)(a->line < b->line ? a->line : b->line));
        }
    }
}

/* Reads the stamps. Frames without observations are allowed, and are left out. */
static void read_stamps(known_times *times, csv_table *table, cli_names *frames,
                        const cli_cameras *cameras, const cli_observations *observations)
{
    size_t frame, camera, time, row, i;

    csv_read(table, times->path);
    table->form = "times.csv";
    frame = csv_column(table, "frame");
    camera = csv_column(table, "camera");
    time = csv_column(table, "time_s");
    times->stamps = cli_alloc(table->n_rows, sizeof *times->stamps);
    times->n_stamps = table->n_rows;
    cli_names_open(frames);
    for (i = 0; i < observations->frames.count; i++) {
        cli_names_add(frames, observations->frames.name[i]);
    }
    for (row = 0; row < table->n_rows; row++) {
        stamp *s = &times->stamps[row];

        s->camera = cli_find_camera(cameras, table, row, camera);
        s->frame = cli_names_add(frames, csv_id(table, row, frame));
        s->time = csv_number(table, row, time);
        s->line = table->lines[row];
    }
    qsort(times->stamps, times->n_stamps, sizeof *times->stamps, compare_stamps);
    check_twice(times, table, frames, cameras);
}

/* A frame of the file that has no observations and whose name looks like this one, or
 * NULL. */
static const char *find_alike(const cli_names *frames, size_t n_observed, const char *frame)
{
    size_t i;

    for (i = n_observed; i < frames->count; i++) {
        if (cli_look_alike(frames->name[i], frame)) {
            return frames->name[i];
        }
    }
    return NULL;
}

/* Refuses a view without a time. */
static void check_missing(const known_times *times, const cli_names *frames,
                          const cli_cameras *cameras, const cli_observations *observations)
{
    size_t i;

    for (i = 0; i < observations->count; i++) {
        const cli_observation *o = &observations->list[i];
        const char *frame = observations->frames.name[o->frame];
        const char *alike;

        if (find_stamp(times, o->camera, o->frame) == NULL) {
            alike = find_alike(frames, observations->frames.count, frame);
            cli_fail("%s has no time of camera %s in frame %s, which is in %s%s%s%s",
                     times->path, cameras->names.name[o->camera], frame,
                     observations->table.path, alike != NULL ? ". It has frame " : "",
                     alike != NULL ? alike : "", alike != NULL ? ": spell them alike" : "");
        }
    }
}

/* ==== frames in the order of their times ==================================== */

static int compare_stamps_of_frames(const void *va, const void *vb)
{
    const stamp *a = va, *b = vb;

    if (a->frame != b->frame) {
        return a->frame < b->frame ? -1 : 1;
    }
    return (a->time > b->time) - (a->time < b->time);
}

/* Gives each frame the median time of the cameras that have points in it. So one wrong time
 * does not matter. */
static void find_middles(known_times *times, const cli_observations *observations)
{
    const size_t n = observations->frames.count;
    const cli_observation *last = NULL;
    stamp *list = cli_alloc(observations->count, sizeof *list);
    size_t i, end, count = 0;

    times->of_frame = cli_alloc(n, sizeof *times->of_frame);
    for (i = 0; i < observations->count; i++) {
        const cli_observation *o = &observations->list[i];

        if (last == NULL || o->frame != last->frame || o->camera != last->camera) {
            list[count++] = *find_stamp(times, o->camera, o->frame);
        }
        last = o;
    }
    qsort(list, count, sizeof *list, compare_stamps_of_frames);
    for (i = 0; i < count; i = end) {
        for (end = i; end < count && list[end].frame == list[i].frame; end++) {
        }
        times->of_frame[list[i].frame] =
            (list[i + (end - i) / 2].time + list[i + (end - i - 1) / 2].time) / 2;
    }
    cli_free(list);
}

typedef struct {
    double time;
    size_t frame;
} timed_frame;

static int compare_times(const void *va, const void *vb)
{
    const timed_frame *a = va, *b = vb;

    if (a->time < b->time || a->time > b->time) {
        return a->time < b->time ? -1 : 1;
    }
    return (a->frame > b->frame) - (a->frame < b->frame);
}

/* Numbers the frames of the observations and of the stamps anew, in the order of their
 * times. */
static void sort_frames(known_times *times, cli_observations *observations)
{
    const size_t n = observations->frames.count;
    timed_frame *list = cli_alloc(n, sizeof *list);
    size_t *number = cli_alloc(n, sizeof *number);
    const char **sorted = cli_alloc(n, sizeof *sorted);
    size_t i, kept = 0;

    for (i = 0; i < n; i++) {
        list[i].time = times->of_frame[i];
        list[i].frame = i;
    }
    qsort(list, n, sizeof *list, compare_times);
    for (i = 0; i < n; i++) {
        if (i > 0 && !(list[i].time > list[i - 1].time)) {
            cli_fail("%s: frames %s and %s have the same time, %.9g: a time belongs to one "
                     "frame",
                     times->path, observations->frames.name[list[i - 1].frame],
                     observations->frames.name[list[i].frame], list[i].time);
        }
        number[list[i].frame] = i;
        sorted[i] = observations->frames.name[list[i].frame];
        times->of_frame[i] = list[i].time;
    }
    for (i = 0; i < observations->count; i++) {
        cli_observation *o = &observations->list[i];

        o->frame = (uint32_t)number[o->frame];
    }
    for (i = 0; i < times->n_stamps; i++) {
        if (times->stamps[i].frame < n) {
            times->stamps[kept] = times->stamps[i];
            times->stamps[kept++].frame = number[times->stamps[i].frame];
        }
    }
    times->n_stamps = kept;
    qsort(times->stamps, kept, sizeof *times->stamps, compare_stamps);
    cli_names_close(&observations->frames);
    memcpy(observations->frames.name, sorted, n * sizeof *sorted);
    cli_free(sorted);
    cli_free(list);
    cli_free(number);
}

/* Refuses times that do not rise: a camera takes one picture after the other. */
static void check_rising(const known_times *times, const csv_table *table,
                         const cli_cameras *cameras, const cli_observations *observations)
{
    size_t i;

    for (i = 1; i < times->n_stamps; i++) {
        const stamp *a = &times->stamps[i - 1], *b = &times->stamps[i];

        if (a->camera == b->camera && !(b->time > a->time)) {
            csv_fail_line(
                table, b->line,
                "camera %s: frame %s at %.9g s is not later than frame %s at %.9g s, "
                "line %lu. Other cameras have these frames in this order: the times of a "
                "camera rise from frame to frame",
                cameras->names.name[b->camera], observations->frames.name[b->frame],
                b->time, observations->frames.name[a->frame], a->time,
                (unsigned long)a->line);
        }
    }
}

/* ==== frame numbers as times ================================================ */

static double number_of_frame(const char *name)
{
    const char *problem, *end;
    double number = 0;

    end = cli_number(&number, &problem, name);
    if (problem != NULL || *end != '\0' || !(floor(number) >= number) ||
        !(fabs(number) < 1e6)) {
        cli_fail("--times frames: the name of frame %s is not a whole number below a "
                 "million, so it is no time: give --times a file of times",
                 name);
    }
    return number;
}

/* Gives all cameras the time of the frame. */
static void stamps_of_frames(known_times *times, const cli_observations *observations)
{
    const cli_observation *last = NULL;
    size_t i, n = 0;

    times->stamps = cli_alloc(observations->count, sizeof *times->stamps);
    for (i = 0; i < observations->count; i++) {
        const cli_observation *o = &observations->list[i];

        if (last == NULL || o->frame != last->frame || o->camera != last->camera) {
            stamp *s = &times->stamps[n++];

            s->camera = o->camera;
            s->frame = o->frame;
            s->time = number_of_frame(observations->frames.name[o->frame]);
        }
        last = o;
    }
    qsort(times->stamps, n, sizeof *times->stamps, compare_stamps);
    times->n_stamps = 0;
    for (i = 0; i < n; i++) {
        if (i == 0 || compare_stamps(&times->stamps[i - 1], &times->stamps[i]) != 0) {
            times->stamps[times->n_stamps++] = times->stamps[i];
        }
    }
    times->stamps = cli_resize(times->stamps, times->n_stamps, sizeof *times->stamps);
}

/* ==== the options ============================================================= */

static double choose_sigma_time(const char *text)
{
    double sigma;

    cli_numbers(&sigma, 1, "--sigma-time", text);
    if (!(sigma >= 0 && sigma <= 1e3)) {
        cli_fail("--sigma-time is from 0 to 1000, in the unit of the times, not \"%s\"",
                 text);
    }
    return sigma;
}

static void check_options(const char *const option[OPTION_COUNT])
{
    static const struct {
        int option, needs;
        const char *name, *needed;
    } NEEDS[] = {
        {OPTION_CLOCKS, OPTION_TIMES, "--clocks", "--times FILE, or --times frames"},
        {OPTION_SIGMA_TIME, OPTION_TIMES, "--sigma-time",
         "--times FILE, or --times frames"},
        {OPTION_DRIFT, OPTION_CLOCKS, "--drift", "--clocks"},
    };
    size_t i;

    for (i = 0; i < sizeof NEEDS / sizeof NEEDS[0]; i++) {
        if (option[NEEDS[i].option] != NULL && option[NEEDS[i].needs] == NULL) {
            cli_fail("%s goes with %s: give it too", NEEDS[i].name, NEEDS[i].needed);
        }
    }
}

/* Subtracts the middle of all times, so that no digits are lost. */
static void centre_times(known_times *times, size_t n_frames)
{
    const double middle = (times->of_frame[0] + times->of_frame[n_frames - 1]) / 2;
    size_t i;

    for (i = 0; i < n_frames; i++) {
        times->of_frame[i] -= middle;
    }
    for (i = 0; i < times->n_stamps; i++) {
        times->stamps[i].time -= middle;
    }
}

void read_times(known_times *times, cli_observations *observations,
                const cli_cameras *cameras, const char *const option[OPTION_COUNT])
{
    csv_table table;
    cli_names frames;

    memset(times, 0, sizeof *times);
    check_options(option);
    if (option[OPTION_TIMES] == NULL) {
        return;
    }
    times->path = option[OPTION_TIMES];
    times->is_frames = strcmp(times->path, "frames") == 0;
    times->is_free = option[OPTION_CLOCKS] != NULL;
    times->has_drift = option[OPTION_DRIFT] != NULL;
    if (option[OPTION_SIGMA_TIME] != NULL) {
        times->sigma = choose_sigma_time(option[OPTION_SIGMA_TIME]);
    }
    cli_observations_by_view(observations);
    if (times->is_frames) {
        stamps_of_frames(times, observations);
    } else {
        read_stamps(times, &table, &frames, cameras, observations);
        check_missing(times, &frames, cameras, observations);
    }
    find_middles(times, observations);
    sort_frames(times, observations);
    if (!times->is_frames) {
        check_rising(times, &table, cameras, observations);
    }
    centre_times(times, observations->frames.count);
}

double time_of_view(const known_times *times, size_t camera, size_t frame)
{
    return find_stamp(times, camera, frame)->time;
}

/* All cameras get the same standard deviations. */
rigcal_intrinsics_sigma choose_intrinsics_sigma(const char *text)
{
    static const double MOST[5] = {0.5, 0.5, 1e5, 100, 100};
    static const char *const WHAT[5] = {"F, of the focal length, is a part",
                                        "ASPECT is a part", "CENTRE is in pixels",
                                        "K1 is a number", "K2 is a number"};
    rigcal_intrinsics_sigma s;
    double numbers[5];
    int i;

    cli_numbers(numbers, 5, "--intrinsics-sigma", text);
    for (i = 0; i < 5; i++) {
        if (!(numbers[i] >= 0 && numbers[i] <= MOST[i])) {
            cli_fail("--intrinsics-sigma %s: %s from 0 to %g, not %g", text, WHAT[i],
                     MOST[i], numbers[i]);
        }
    }
    s.focal = (rigcal_real)numbers[0];
    s.aspect = (rigcal_real)numbers[1];
    s.centre = (rigcal_real)numbers[2];
    s.k1 = (rigcal_real)numbers[3];
    s.k2 = (rigcal_real)numbers[4];
    return s;
}
