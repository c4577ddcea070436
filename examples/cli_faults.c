/* Why the views of the rig as a whole disagree, and the clocks of its cameras. */
#include "cli_calibrate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Frames are paired anew at most this many times. Clocks that are off by several frames are
 * estimated too small at first. */
enum { PAIRED_MOST = 3 };

/* ==== times =============================================================== */

static void open_clocks(calibration *c)
{
    const size_t n = c->rig.n_cameras;

    rigcal_clocks_defaults(&c->clocks);
    c->clocks.offsets = cli_alloc(n, sizeof *c->clocks.offsets);
    c->clocks.drifts = cli_alloc(n, sizeof *c->clocks.drifts);
    c->clocks.states = cli_alloc(n, sizeof *c->clocks.states);
    c->clocks.free_offsets = c->times.is_free;
    c->clocks.free_drifts = c->times.has_drift;
    c->clocks.frame = c->times.is_frames ? 1 : 0;
    c->clocks.sigma_time = (rigcal_real)c->times.sigma;
    c->placement_time = cli_alloc(c->observations.frames.count, sizeof *c->placement_time);
    memcpy(c->placement_time, c->times.of_frame,
           c->observations.frames.count * sizeof *c->placement_time);
}

void give_times(calibration *c)
{
    rigcal_real *times, *view_times;
    size_t i;

    if (c->times.path == NULL) {
        return;
    }
    if (c->clocks.offsets == NULL) {
        open_clocks(c);
    }
    times = cli_alloc(c->rig.n_placements, sizeof *times);
    view_times = cli_alloc(c->rig.n_views, sizeof *view_times);
    for (i = 0; i < c->rig.n_placements; i++) {
        times[i] = (rigcal_real)c->placement_time[i];
    }
    for (i = 0; i < c->rig.n_views; i++) {
        const view *v = rig_view(c, i);

        view_times[i] = (rigcal_real)time_of_view(&c->times, v->camera, v->frame);
    }
    c->clocks.times = times;
    c->clocks.view_times = view_times;
    c->clocks.instants = cli_alloc(c->rig.n_placements, sizeof *c->clocks.instants);
    c->rig.clocks = &c->clocks;
}

/* ==== frames that are paired anew ========================================= */

/* A placement: that of a frame, or, with CLI_UNKNOWN, that of a time at which there is no
 * frame. */
typedef struct {
    double time;
    size_t frame, number;
} moment;

static int compare_moments(const void *va, const void *vb)
{
    const moment *a = va, *b = vb;

    return (a->time > b->time) - (a->time < b->time);
}

static int has_view_of(const calibration *c, size_t camera, const size_t moment_of[],
                       size_t n_done, size_t wanted)
{
    size_t i;

    for (i = 0; i < n_done; i++) {
        if (moment_of[i] == wanted && c->views[i].rig_camera == camera) {
            return 1;
        }
    }
    return 0;
}

/* The moment of a view whose picture belongs a number of frames later: the nearest moment
 * within half a frame that has no view of this camera yet; otherwise a new one. */
static size_t moment_of_view(moment moments[], size_t *n, const calibration *c,
                             size_t index, const size_t moment_of[])
{
    const view *v = &c->views[index];
    const double frame = (double)c->clocks.frame;
    const double time =
        time_of_view(&c->times, v->camera, v->frame) + frame * c->paired_by[v->rig_camera];
    size_t i, best = *n;
    double least = frame / 2;

    for (i = 0; i < *n; i++) {
        const double apart = fabs(moments[i].time - time);

        if (apart < least && !has_view_of(c, v->rig_camera, moment_of, index, i)) {
            least = apart;
            best = i;
        }
    }
    if (best == *n) {
        moments[*n].time = time;
        moments[*n].frame = CLI_UNKNOWN;
        ++*n;
    }
    return best;
}

static void pair_anew(calibration *c)
{
    const size_t n_frames = c->observations.frames.count;
    moment *moments = cli_alloc(n_frames + c->n_views, sizeof *moments);
    size_t *moment_of = cli_alloc(c->n_views, sizeof *moment_of);
    size_t *number = cli_alloc(n_frames + c->n_views, sizeof *number);
    size_t i, n = n_frames;

    for (i = 0; i < n_frames; i++) {
        moments[i].time = c->times.of_frame[i];
        moments[i].frame = i;
    }
    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];

        moment_of[i] = c->paired_by[v->rig_camera] == 0
                           ? v->frame
                           : moment_of_view(moments, &n, c, i, moment_of);
    }
    for (i = 0; i < n; i++) {
        moments[i].number = i;
    }
    qsort(moments, n, sizeof *moments, compare_moments);
    c->placement_time = cli_alloc(n, sizeof *c->placement_time);
    for (i = 0; i < n; i++) {
        number[moments[i].number] = i;
        c->placement_time[i] = moments[i].time;
        if (moments[i].frame != CLI_UNKNOWN) {
            c->placement_of[moments[i].frame] = (uint32_t)i;
        }
    }
    for (i = 0; i < c->n_views; i++) {
        c->views[i].placement = (uint32_t)number[moment_of[i]];
    }
    c->rig.n_placements = n;
    cli_free(moments);
    cli_free(moment_of);
    cli_free(number);
}

/* Whether the clocks say that pictures of different frames belong together. */
static int must_pair_anew(calibration *c)
{
    int32_t *frames = cli_alloc(c->rig.n_cameras, sizeof *frames);
    int is_new = 0;
    size_t i;

    if (c->times.is_free && c->n_paired < PAIRED_MOST &&
        rigcal_clocks_frames(frames, &c->clocks, c->rig.n_cameras) == RIGCAL_OK) {
        for (i = 0; i < c->rig.n_cameras; i++) {
            is_new |= frames[i] != c->paired_by[i];
        }
    }
    if (is_new) {
        memcpy(c->paired_by, frames, c->rig.n_cameras * sizeof *frames);
        c->n_paired++;
        pair_anew(c);
    }
    cli_free(frames);
    return is_new;
}

/* ==== the test ============================================================ */

static rigcal_status faults_in_steps(calibration *c, const rigcal_faults_options *options,
                                     size_t capacity, int32_t *at_fault)
{
    const int32_t budget = (int32_t)c->rig.n_views;
    rigcal_faults_solver solver;
    rigcal_status status =
        rigcal_faults_begin(&solver, c->faults, capacity, options, &c->rig);

    if (status != RIGCAL_OK) {
        return status;
    }
    cli_progress(c->rig.n_views, "looking for what is wrong with %lu views",
                 (unsigned long)c->rig.n_views);
    do {
        status = rigcal_faults_step(&solver, budget);
    } while (status == RIGCAL_RUNNING);
    return rigcal_faults_result(&c->verdict, at_fault, &solver);
}

void test_rig(calibration *c)
{
    const size_t n = c->rig.n_cameras;
    const size_t capacity = 16 * n + 16;
    rigcal_faults_options options;
    int32_t at_fault = -1;

    if (!c->is_adjusted) {
        return;
    }
    memset(&options, 0, sizeof options);
    options.work_capacity = rigcal_faults_work(n, n) + RIGCAL_FAULTS_CLOCKS_WORK(n);
    options.work = cli_alloc(options.work_capacity, sizeof *options.work);
    options.clocks = cli_alloc(2 * n, sizeof *options.clocks);
    c->faults = cli_alloc(capacity, sizeof *c->faults);
    c->is_tested = faults_in_steps(c, &options, capacity, &at_fault) == RIGCAL_OK;
    cli_free(options.work);
}

static rigcal_status adjust_in_steps(calibration *c, int32_t *at_fault)
{
    const int32_t budget = (int32_t)c->rig.n_views;
    rigcal_rig_solver solver;
    rigcal_status status = rigcal_rig_begin(&solver, &c->rig);
    unsigned long step = 0;

    if (status != RIGCAL_OK) {
        return status;
    }
    do {
        cli_progress(c->rig.n_views, "adjusting the rig of %lu views, step %lu",
                     (unsigned long)c->rig.n_views, ++step);
        status = rigcal_rig_step(&solver, budget);
    } while (status == RIGCAL_RUNNING);
    return rigcal_rig_result(&c->fit, at_fault, &solver);
}

/* Marks the views that the choice leaves out because they put the target at another
 * place. */
static size_t mark_not_taken(uint8_t left_out[], const calibration *c)
{
    size_t i, n = 0;

    for (i = 0; i < c->rig.n_views; i++) {
        left_out[i] = c->choice.takes[i] == RIGCAL_TAKES_NONE;
        n += left_out[i];
    }
    return n;
}

/* Places each placement of which the choice takes no view by its first view. */
static void place_all(const calibration *c)
{
    const rigcal_rig *rig = &c->rig;
    size_t first, end;

    for (first = 0; first < rig->n_views; first = end) {
        const view *v = rig_view(c, first);
        rigcal_transform rig_from_cam, placed;
        const rigcal_transform best = kept_transform(&v->poses[0]);
        int is_placed = 0;

        for (end = first; end < rig->n_views && rig_view(c, end)->placement == v->placement;
             end++) {
            is_placed |= c->choice.takes[end] != RIGCAL_TAKES_NONE;
        }
        if (!is_placed &&
            rigcal_transform_invert(&rig_from_cam, &rig->cams_from_rig[v->rig_camera]) >=
                0 &&
            rigcal_transform_compose(&placed, &rig_from_cam, &best) >= 0) {
            rig->rig_from_placements[v->placement] = placed;
        }
    }
}

/* Lets all views count: none is wrong. */
static void accept_all(calibration *c)
{
    size_t *count = cli_alloc(c->rig.n_placements, sizeof *count);
    size_t i;

    for (i = 0; i < c->rig.n_views; i++) {
        count[rig_view(c, i)->placement]++;
    }
    for (i = 0; i < c->rig.n_views; i++) {
        c->judged[i].verdict =
            count[rig_view(c, i)->placement] > 1 ? RIGCAL_VIEW_FITS : RIGCAL_VIEW_UNCHECKED;
    }
    cli_free(count);
    note_verdicts(c);
}

/* Whether a camera that moved has enough views before and after its move. Otherwise a
 * single wrong view at an end of the recording would look like a camera that moved. */
static int has_moved_for_long(const calibration *c, const rigcal_fault *f)
{
    enum { LEAST = 3 };
    size_t i, before = 0, after = 0;

    for (i = 0; i < c->n_views; i++) {
        const view *v = &c->views[i];

        if (v->in_rig && v->rig_camera == (size_t)f->camera) {
            before += v->placement < (size_t)f->placement;
            after += v->placement >= (size_t)f->placement;
        }
    }
    return before >= LEAST && after >= LEAST;
}

/* The camera that all views left out by the choice belong to; -1: they belong to
 * several. */
static int camera_not_taken(const calibration *c)
{
    int camera = -1;
    size_t i;

    for (i = 0; i < c->rig.n_views; i++) {
        const int of_view = (int)rig_view(c, i)->rig_camera;

        if (c->choice.takes[i] == RIGCAL_TAKES_NONE) {
            if (camera >= 0 && of_view != camera) {
                return -1;
            }
            camera = of_view;
        }
    }
    return camera;
}

/* Whether one fault of the rig, or single wrong times, explain why the views disagree.
 * Wrong times are off along the motion. Views that the choice leaves out are wrong in most
 * cases. They can be explained by faults of times alone, or, if they are of one camera, by
 * its intrinsics, if these explain nearly all. An error of two fifths of the intrinsics is
 * too large for one linear step, so its estimate then explains nothing. */
static int is_explained(const calibration *c, size_t n_not_taken)
{
    static const double NEARLY_ALL = 0.8, IN_REACH = 0.4;
    const rigcal_fault *f = c->faults;

    if (!c->is_tested || c->verdict.verdict == RIGCAL_RIG_AGREES) {
        return 0;
    }
    if (c->verdict.verdict != RIGCAL_RIG_EXPLAINED) {
        return (c->verdict.bits & RIGCAL_FAULTS_ALONG_MOTION) != 0;
    }
    if (f->kind <= RIGCAL_FAULT_SHUTTER) {
        return 1;
    }
    if ((f->kind == RIGCAL_FAULT_FOCAL || f->kind == RIGCAL_FAULT_ASPECT) &&
        fabs((double)f->value[0]) > IN_REACH) {
        return 0;
    }
    if (n_not_taken > 0) {
        return f->kind <= RIGCAL_FAULT_DISTORTION && f->camera == camera_not_taken(c) &&
               (double)c->verdict.explained > NEARLY_ALL;
    }
    return f->kind != RIGCAL_FAULT_MOVED || has_moved_for_long(c, f);
}

/* Adjusts the rig, with free clocks or not. */
static rigcal_status adjust(calibration *c, int is_free, double sigma_time)
{
    int32_t at_fault = -1;
    rigcal_status status;

    c->clocks.free_offsets = is_free;
    c->clocks.free_drifts = is_free && c->times.has_drift;
    c->clocks.sigma_time = (rigcal_real)sigma_time;
    status = adjust_in_steps(c, &at_fault);
    c->is_adjusted = status >= 0;
    return status;
}

/* Tests the rig with held clocks and exact times. If they explain why views disagree, no
 * view is wrong, however well the others agree when clocks are free. If times are known and
 * all views agree, no view is wrong either: the choice does not know of times. */
static void test_as_it_is(calibration *c, size_t n_not_taken)
{
    const int has_times = c->times.path != NULL;

    if (!c->is_explained && (has_times || n_not_taken == 0 || camera_not_taken(c) >= 0)) {
        place_all(c);
        c->is_tested = 0;
        adjust(c, 0, 0);
        test_rig(c);
        c->is_explained =
            is_explained(c, n_not_taken) ||
            (has_times && c->is_tested && c->verdict.verdict == RIGCAL_RIG_AGREES);
    }
}

static int test_views(calibration *c, const uint8_t left_out[], size_t n_not_taken)
{
    test_as_it_is(c, n_not_taken);
    if (!c->times.is_free && !(c->times.sigma > 0)) {
        return c->is_explained ? TEST_EXPLAINS : TEST_TELLS_NOTHING;
    }
    if (c->is_explained) {
        place_all(c);
    } else {
        c->rig.left_out = left_out;
    }
    if (adjust(c, c->times.is_free, c->times.sigma) < 0) {
        return TEST_TELLS_NOTHING;
    }
    if (must_pair_anew(c)) {
        return TEST_PAIRS_ANEW;
    }
    test_rig(c);
    return c->is_explained || (n_not_taken == 0 && is_explained(c, 0)) ? TEST_EXPLAINS
                                                                       : TEST_TELLS_NOTHING;
}

int test_all_views(calibration *c)
{
    rigcal_rig *rig = &c->rig;
    const size_t n_cameras = rig->n_cameras, n_placements = rig->n_placements;
    rigcal_transform *cameras, *placements;
    uint8_t *left_out;
    int outcome;

    if (n_cameras < 2) {
        return TEST_TELLS_NOTHING; /* nothing that could disagree */
    }
    cameras = cli_alloc(n_cameras, sizeof *cameras);
    placements = cli_alloc(n_placements, sizeof *placements);
    left_out = cli_alloc(rig->n_views, sizeof *left_out);
    memcpy(cameras, rig->cams_from_rig, n_cameras * sizeof *cameras);
    memcpy(placements, rig->rig_from_placements, n_placements * sizeof *placements);
    outcome = test_views(c, left_out, mark_not_taken(left_out, c));
    rig->left_out = NULL;
    if (outcome == TEST_EXPLAINS) {
        accept_all(c);
    } else {
        memcpy(rig->cams_from_rig, cameras, n_cameras * sizeof *cameras);
        memcpy(rig->rig_from_placements, placements, n_placements * sizeof *placements);
        c->is_adjusted = 0;
    }
    cli_free(cameras);
    cli_free(placements);
    cli_free(left_out);
    return outcome;
}

/* ==== intrinsics that are not exact ======================================= */

void consider_intrinsics(calibration *c)
{
    const size_t n = c->rig.n_cameras;
    rigcal_intrinsics_sigma *sigmas;
    rigcal_rig_fit left;
    int32_t at_fault = -1;
    rigcal_status status;
    size_t i;

    if (!c->has_intrinsics) {
        return;
    }
    sigmas = cli_alloc(n, sizeof *sigmas);
    for (i = 0; i < n; i++) {
        sigmas[i] = c->intrinsics;
    }
    c->rig.intrinsics_sigmas = sigmas;
    if (c->is_estimating && estimate_intrinsics(c)) {
        return;
    }
    c->considered.capacity = rigcal_consider_work(n, n) + rigcal_consider_clocks_work(n);
    c->considered.effects =
        cli_alloc(c->considered.capacity, sizeof *c->considered.effects);
    status = rigcal_rig_consider(&c->considered, &at_fault, &c->rig);
    if (status != RIGCAL_OK) {
        name_rig_trouble(c, "--intrinsics-sigma is not considered", status, at_fault);
        return;
    }
    if (rigcal_considered_fit(&left, &c->fit, &c->rig) == RIGCAL_OK) {
        c->factor = left.F > 1 ? sqrt((double)left.F) : 1;
    }
}

/* ==== what is printed ===================================================== */

static const char *const *names_of_cameras(const calibration *c)
{
    const char **names = cli_alloc(c->rig.n_cameras, sizeof *names);
    size_t i;

    for (i = 0; i < c->rig.n_cameras; i++) {
        names[i] = rig_camera_name(c, i);
    }
    return names;
}

static const char *unit_of_times(const calibration *c)
{
    return c->times.is_frames ? "frames" : "ms";
}

static double in_unit(const calibration *c, rigcal_real time)
{
    return (double)time * (c->times.is_frames ? 1 : 1000);
}

/* Prints the option of the command line for what is to be done. */
static void print_option(const calibration *c)
{
    const int is_found = c->verdict.verdict == RIGCAL_RIG_EXPLAINED ||
                         c->verdict.verdict == RIGCAL_RIG_FOUND;

    if (c->times.path == NULL && c->verdict.verdict >= RIGCAL_RIG_FOUND &&
        (c->verdict.bits & RIGCAL_FAULTS_PATTERN) == 0) {
        printf("(--times FILE takes the times of the frames.)\n");
    } else if (is_found && !c->times.is_free && c->faults[0].kind <= RIGCAL_FAULT_CLOCKS) {
        printf("(--clocks estimates the clocks%s.)\n",
               c->faults[0].kind == RIGCAL_FAULT_DRIFT ? ", --drift how fast they run"
                                                       : "");
    } else if (c->times.is_free && !(c->times.sigma > 0) &&
               (c->verdict.bits & RIGCAL_FAULTS_ALONG_MOTION) != 0) {
        printf("(--sigma-time states the noise of each time.)\n");
    }
}

/* The sentences of the verdict, with placements named by their frames instead of
 * numbers. */
static const char *with_frames(const calibration *c, const char *text)
{
    static const char WORD[] = "placement ";
    const char *at, *done = "";

    while ((at = strstr(text, WORD)) != NULL) {
        char *end;
        const char *number = at + sizeof WORD - 1;
        const unsigned long placement = strtoul(number, &end, 10);
        const char *name = end != number && placement < c->rig.n_placements
                               ? name_of_placement(c, placement)
                               : "";

        if (*name == '\0') {
            done = cli_text("%s%.*s", done, (int)(number - text), text);
            text = number;
        } else {
            done = cli_text("%s%.*sframe %s", done, (int)(at - text), text, name);
            text = end;
        }
    }
    return cli_text("%s%s", done, text);
}

const char *verdict_text(const calibration *c)
{
    rigcal_faults_words words;
    size_t needed = 0;
    char none[1], *text;

    if (!c->is_tested) {
        return NULL;
    }
    memset(&words, 0, sizeof words);
    words.names = names_of_cameras(c);
    words.time = unit_of_times(c);
    words.time_scale = c->times.is_frames ? 1 : 1000;
    rigcal_faults_text(none, 1, &needed, &c->verdict, c->faults, &words);
    text = cli_alloc(needed + 1, 1);
    return rigcal_faults_text(text, needed + 1, &needed, &c->verdict, c->faults, &words) ==
                   RIGCAL_OK
               ? with_frames(c, text)
               : NULL;
}

void print_verdict(const calibration *c)
{
    const char *text = verdict_text(c);

    if (text != NULL) {
        printf("%s\n", text);
        print_option(c);
    }
}

static const char *state_of(const calibration *c, size_t camera)
{
    static const char *const STATE[] = {"held", "",
                                        "held: no frame of it has a neighbour in time",
                                        "held: the target hardly moves"};
    const int32_t state = c->clocks.states[camera];

    if (state == RIGCAL_CLOCK_HELD) {
        return c->times.is_free ? "the clock that the others are relative to" : "as given";
    }
    return STATE[state];
}

static void find_clock_sigmas(rigcal_real **offsets, rigcal_real **drifts,
                              const calibration *c)
{
    const rigcal_real noise = (rigcal_real)(c->noise_px * c->factor);

    *offsets = cli_alloc(c->rig.n_cameras, sizeof **offsets);
    *drifts = cli_alloc(c->rig.n_cameras, sizeof **drifts);
    if (rigcal_clocks_sigma(*offsets, *drifts, &c->rig, noise) != RIGCAL_OK) {
        memset(*offsets, 0, c->rig.n_cameras * sizeof **offsets);
        memset(*drifts, 0, c->rig.n_cameras * sizeof **drifts);
    }
}

void print_clocks(const calibration *c)
{
    const int wide = widest(&c->cameras.names);
    const char *unit = unit_of_times(c);
    rigcal_real *offsets, *drifts;
    size_t i;

    if (!c->times.is_free || !c->is_adjusted) {
        return;
    }
    find_clock_sigmas(&offsets, &drifts, c);
    printf("\n%-*s  late by [%s]        +-", wide, "camera", unit);
    if (c->times.has_drift) {
        printf("  drift [ppm]        +-");
    }
    printf("\n");
    for (i = 0; i < c->rig.n_cameras; i++) {
        printf("%-*s  %*.*f  %8.2g", wide, rig_camera_name(c, i), (int)strlen(unit) + 10, 2,
               in_unit(c, c->clocks.offsets[i]), in_unit(c, offsets[i]));
        if (c->times.has_drift) {
            printf("  %11.1f  %8.2g", 1e6 * (double)c->clocks.drifts[i],
                   1e6 * (double)drifts[i]);
        }
        printf("%s%s\n", *state_of(c, i) != '\0' ? "  " : "", state_of(c, i));
    }
    for (i = 0; i < c->rig.n_cameras; i++) {
        if (c->paired_by[i] != 0) {
            printf(
                "frames are paired anew: a picture of %s belongs to the frame that is %ld "
                "%s than its own\n",
                rig_camera_name(c, i), labs((long)c->paired_by[i]),
                c->paired_by[i] > 0 ? "later" : "earlier");
        }
    }
}

/* ==== files =============================================================== */

static const char *const KIND[RIGCAL_FAULT_KINDS] = {
    "clock",  "drift",      "clocks", "shutter", "focal",    "aspect",
    "centre", "distortion", "moved",  "bent",    "stretched"};

const char *name_of_placement(const calibration *c, size_t placement)
{
    size_t frame;

    for (frame = 0; frame < c->observations.frames.count; frame++) {
        if (c->placement_of[frame] == placement) {
            return c->observations.frames.name[frame];
        }
    }
    return "";
}

/* Writes one line for each fault, the likeliest first. */
void write_faults(FILE *file, const calibration *c)
{
    int32_t i, k;

    fprintf(file,
            "fault,camera,frame,explains,p,gain_px2,F_after,shows_turn_deg,shows_shift");
    for (k = 1; k <= RIGCAL_FAULT_VALUES; k++) {
        fprintf(file, ",value%ld,sigma%ld", (long)k, (long)k);
    }
    fprintf(file, "\n");
    for (i = 0; i < c->verdict.n; i++) {
        const rigcal_fault *f = &c->faults[i];

        fprintf(file, "%s,%s,%s,%ld", KIND[f->kind],
                f->camera >= 0 ? rig_camera_name(c, (size_t)f->camera) : "",
                f->placement >= 0 ? name_of_placement(c, (size_t)f->placement) : "",
                (long)f->explains);
        cli_write_known(file, f->p, f->is_seen);
        cli_write_known(file, f->gain, f->is_seen);
        cli_write_known(file, f->F_after, f->is_seen);
        cli_write_known(file, (rigcal_real)(DEGREE * (double)f->turn), f->is_seen);
        cli_write_known(file, f->shift, f->is_seen);
        for (k = 0; k < RIGCAL_FAULT_VALUES; k++) {
            cli_write_known(file, f->value[k], f->is_seen && k < f->n);
            cli_write_known(file, f->sigma[k], f->is_seen && k < f->n);
        }
        fprintf(file, "\n");
    }
}

void write_clocks(FILE *file, const calibration *c)
{
    static const char *const STATE[] = {"held", "free", "alone", "still"};
    rigcal_real *offsets, *drifts;
    size_t i;

    find_clock_sigmas(&offsets, &drifts, c);
    fprintf(file, "camera,offset,sigma_offset,drift,sigma_drift,state,paired_later\n");
    for (i = 0; i < c->rig.n_cameras; i++) {
        fprintf(file, "%s", rig_camera_name(c, i));
        cli_write_numbers(file, &c->clocks.offsets[i], 1);
        cli_write_numbers(file, &offsets[i], 1);
        cli_write_numbers(file, &c->clocks.drifts[i], 1);
        cli_write_numbers(file, &drifts[i], 1);
        fprintf(file, ",%s,%ld\n", STATE[c->clocks.states[i]], (long)c->paired_by[i]);
    }
}
