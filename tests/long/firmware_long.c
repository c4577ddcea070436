/* firmware_long.c - the firmware of examples/firmware for a long time on its simulated
 * board: random detections, bumps, resets, power cuts, flash that fails, bits that flip.
 * After every tick it is asserted that
 *
 *   - the slot in use holds the bytes that were last stored, and after a reset the
 *     firmware has them, or those whose last byte came before the power went: never a
 *     mixture
 *   - the watchdog was fed in time, and the flash was treated as its makers want
 *   - the firmware comes to rest in a bounded number of ticks
 *
 * and at the end that
 *
 *   - each bump was told within ALARM_FRAMES, and mended within SETTLE_FRAMES after that
 *   - the alarms of a rig at rest are no more than the stated rate allows, except by a
 *     chance of 1e-4, and wrong names no more than the stated probabilities allow
 *
 *   firmware_long [TICKS [SEED]]     status 1 and a line when one of these is broken */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sim.h"

#ifndef LONG_TICKS
#define LONG_TICKS 100000
#endif

enum {
    REST_TICKS = 20000, /* ticks within which the firmware must be at rest */
    ALARM_FRAMES = 60,
    SETTLE_FRAMES = 400,
    BODIES = FIRMWARE_CAMERAS + 1, /* the last body is the board at work */
    LEVELS = 4,                    /* places of a body, at distances of 0.02 rad and 0.01
                                      m */
    AFTER_FRAMES = 400,            /* see judge */
    START_FRAMES = 5,              /* frames after a reset until the board has its place */
    UNKNOWN = -1
};

static const double ARL0_FRAMES = 864000; /* the number that watch.c states */

/* What is stored in a slot, or is about to be. In a rig at work only the relative poses of
 * the cameras can be seen. `levels` is where the cameras stood when these poses were right.
 * If a camera moved while the power was off, nothing shows which one it was. */
typedef struct {
    uint8_t bytes[PORT_SLOT_BYTES];
    size_t n; /* 0: nothing */
    firmware_watch watch;
    rigcal_mounted_camera cameras[FIRMWARE_CAMERAS];
    uint32_t sequence;
    int levels[FIRMWARE_CAMERAS]; /* UNKNOWN: the pose is not where the camera ever was */
    int in_doubt; /* stored after a bump and before its alarm: somewhere between the two */
} record;

static firmware app;
static record stored[PORT_SLOTS], pending;
static int in_use;                       /* the slot in use; -1: none */
static int levels[BODIES], base[BODIES]; /* the place of each body, and where the firmware
                                            believes it is */
static int still;                        /* 1: all bodies are where the firmware believes
                                            they are */
static int unsettled, since_bump, bumped;
static int since_start; /* frames */
static int from_start;  /* whether the last alarm was about an event before a reset */
static int after;       /* frames in which an alarm counts as a second one; see judge */
static int at_work, wants_help, broken;

static struct {
    long ticks, frames, still_frames, bumps, alarms, false_alarms, names, wrong, settled;
    long resets, cuts, saved, failed, flips, second, from_start, in_doubt;
    double doubt; /* the sum of 1 - (stated probability) over the named bumps */
} count;

static int chance(double p)
{
    return sim_uniform() < p;
}

static int below(int n)
{
    return (int)(sim_uniform() * n);
}

static void fail(const char *what)
{
    if (!broken) {
        printf("broken at tick %ld: %s\n%s\n", count.ticks, what, sim.serial);
    }
    broken = 1;
}

static void want(int holds, const char *what)
{
    if (!holds) {
        fail(what);
    }
}

/* ---- what must be in flash -------------------------------------------------- */

static int is_whole(const record *r, int slot)
{
    return r->n > 0 && memcmp(sim.flash[slot], r->bytes, r->n) == 0;
}

static int same_pose(const rigcal_transform *a, const rigcal_transform *b)
{
    return memcmp(a, b, sizeof *a) == 0;
}

/* Whether the firmware's calibration is that of r, to the bit. */
static int has(const record *r)
{
    int same = app.sequence == r->sequence;
    for (int c = 0; c < FIRMWARE_CAMERAS; c++) {
        same &= same_pose(&app.cameras[c].cam_from_rig, &r->cameras[c].cam_from_rig);
        same &= same_pose(&app.stored[c], &r->cameras[c].cam_from_rig);
    }
    same &= (app.watch.rig.sigma_px > 0) == (r->watch.rig.sigma_px > 0);
    if (same && r->watch.rig.sigma_px > 0) {
        same &= memcmp(app.watch.Sigma, r->watch.Sigma, sizeof r->watch.Sigma) == 0;
    }
    return same;
}

/* Before a tick: notes what will be stored if this tick completes it. */
static void note_pending(void)
{
    if (app.image_bytes == 0) {
        return;
    }
    memcpy(pending.bytes, app.image, sizeof pending.bytes);
    pending.n = app.image_bytes;
    pending.watch = app.watch;
    memcpy(pending.cameras, app.cameras, sizeof pending.cameras);
    pending.sequence = app.sequence + 1;
    memcpy(pending.levels, base, sizeof pending.levels);
    pending.in_doubt = at_work && !still && unsettled == 0;
}

static void check_tick(int32_t slot_before)
{
    if (app.slot != slot_before) { /* the saving has ended */
        want(app.slot != in_use && is_whole(&pending, app.slot), "saved, but not in flash");
        stored[app.slot] = pending;
        in_use = app.slot;
    }
    if (in_use >= 0) {
        want(is_whole(&stored[in_use], in_use), "the slot in use was touched");
    }
    want(sim.misuse == 0, "the flash was misused");
}

static void learn_base(const record *r)
{
    still = r->watch.rig.sigma_px > 0;
    for (int c = 0; c < FIRMWARE_CAMERAS; c++) {
        base[c] = r->levels[c];
        still &= base[c] == levels[c];
    }
    base[FIRMWARE_CAMERAS] = levels[FIRMWARE_CAMERAS]; /* its place is searched again */
    since_bump = unsettled = 0;
    bumped = UNKNOWN;
    wants_help |= r->in_doubt; /* it may be right or wrong, so an alarm cannot be
                                  demanded */
    count.in_doubt += r->in_doubt;
}

/* Switches the power on, with the present contents of flash. */
static void reset(void)
{
    const int spare = (in_use == 0) ? 1 : 0;
    if (is_whole(&pending, spare)) {
        stored[spare] = pending;
        in_use = spare;
    }
    if (in_use >= 0 && !is_whole(&stored[in_use], in_use)) { /* one bit has flipped */
        in_use = is_whole(&stored[1 - in_use], 1 - in_use) ? 1 - in_use : -1;
    }
    pending.n = 0;
    sim.cut_after = -1;
    sim.n_frames = sim.first = 0;
    sim.typed[0] = '\0';
    sim.erase_fails = sim.program_fails = 0;
    sim.stuck_mask = 0;
    sim_clear_serial();
    count.resets++;
    since_start = 0;
    want(sim_boot(&app) == SIM_IDLE, "the watchdog bit during the start");
    want(app.slot == in_use, "another slot in use than the newest whole one");
    want(strstr(sim.serial, in_use < 0 ? "uncalibrated\r\n" : "loaded slot=") != NULL,
         "the start was not told");
    still = 0;
    if (in_use >= 0) {
        want(has(&stored[in_use]), "what was loaded is not what was stored");
        learn_base(&stored[in_use]);
    }
}

/* Runs ticks until the firmware is at rest. After a power cut it resets the board and
 * returns 0. */
static int run(void)
{
    for (int i = 0; i < REST_TICKS && !broken; i++) {
        const int32_t slot = app.slot;
        note_pending();
        const sim_end end = sim_run(&app, 1);
        if (end == SIM_IDLE) {
            return 1;
        }
        count.ticks++;
        want(end != SIM_WATCHDOG, "the watchdog was not fed");
        if (end == SIM_CUT) {
            count.cuts++;
            note_pending();
            reset();
            return 0;
        }
        check_tick(slot);
    }
    want(0, "no rest");
    return 0;
}

/* ---- the world --------------------------------------------------------------- */

static void place_all(void)
{
    const double a = 0.01 * levels[0], b = 0.01 * levels[1];
    const double centers[FIRMWARE_CAMERAS][3] = {{0.5, -0.2 + a, 1.1},
                                                 {-0.4, 0.3 + b, 1.3}};
    sim_place(0, centers[0], 0.2 + 2 * a);
    sim_place(1, centers[1], -1.4 + 2 * b);
}

/* Takes a picture. It shows most corners, or sometimes few or none, one of them twice, or
 * unknown ones. */
static void shoot(int camera)
{
    unsigned mask = 0xff;
    for (int p = 0; p < FIRMWARE_POINTS; p++) {
        mask &= ~((unsigned)chance(0.03) << p);
    }
    mask = chance(0.01) ? mask & (unsigned)below(256) : mask;
    port_frame *const frame = sim_shoot(camera, mask);
    if (frame->n > 0 && frame->n < PORT_CORNERS_MAX && chance(0.01)) {
        frame->uv[frame->n][0] = (float)(640 * sim_uniform());
        frame->uv[frame->n][1] = (float)(480 * sim_uniform());
        frame->id[frame->n] = chance(0.5) ? 8 + below(1 << 20) : frame->id[0];
        frame->n++;
    }
    if (chance(0.001)) {
        frame->camera = below(1 << 20) - (1 << 19);
    }
    if (chance(0.001)) {
        frame->placement = 5 + below(1 << 20);
    }
}

static void make_flash_worse(void)
{
    if (chance(0.3)) {
        sim.cut = (sim_cut)below(3);
        sim.cut_after = sim.worked + below(2 * PORT_SLOT_BYTES);
    }
    if (chance(0.1)) {
        sim.erase_fails = 1 + below(2);
    }
    if (chance(0.1)) {
        sim.program_fails = 1 + below(2);
    }
    if (chance(0.05)) {
        sim.stuck_slot = below(PORT_SLOTS);
        sim.stuck_at = below(PORT_SLOT_BYTES);
        sim.stuck_mask = (uint8_t)(1 << below(8));
    }
}

static void count_lines(void)
{
    for (const char *at = sim.serial; (at = strstr(at, "saved slot=")) != NULL; at++) {
        count.saved++;
    }
    for (const char *at = sim.serial; (at = strstr(at, "failed slot=")) != NULL; at++) {
        count.failed++;
    }
}

/* Shows the reference points, then the board in its four places, until there is a rig. */
static void calibrate(void)
{
    int whole = 1;
    at_work = 0;
    sim_clear_serial();
    place_all();
    make_flash_worse();
    sim.placement = 0;
    shoot(0);
    shoot(1);
    whole &= run();
    for (int f = 1; f <= FIRMWARE_PLACEMENTS && whole; f++) {
        const double shift[3] = {0.05 * f - 0.1, 0.04 * (f % 2), 0.03 * f};
        memcpy(base, levels, sizeof base); /* for what is stored at the end */
        sim_hold(f, 0.15 * f - 0.4, 0.2 * (f % 3) - 0.2, shift);
        shoot(0);
        shoot(1);
        whole &= run();
    }
    count_lines();
    if (whole && strstr(sim.serial, "rig t=") != NULL) {
        wants_help = 0;
        still = 1;
        since_bump = unsettled = 0;
        bumped = UNKNOWN;
    }
}

static void bump(void)
{
    const int body = below(BODIES), to = below(LEVELS - 1);
    levels[body] = to + (to >= levels[body]);
    still = 0;
    /* As before the start: the board has no place yet, so no camera can be named. */
    bumped = (since_start < START_FRAMES) ? UNKNOWN : body;
    since_bump = 0;
    count.bumps++;
    make_flash_worse();
}

/* ---- at work ------------------------------------------------------------------ */

/* The body that the firmware named, and its probability; UNKNOWN: none was named. */
static int named(double *sure)
{
    const char *const at = strstr(sim.serial, "moved ");
    int body = FIRMWARE_CAMERAS;
    if (at == NULL) {
        return UNKNOWN;
    }
    if (sscanf(at, "moved camera=%d sure=%lf", &body, sure) != 2) {
        want(sscanf(at, "moved board sure=%lf", sure) == 1, "a line that says nothing");
    }
    want(body >= 0 && body < BODIES && *sure >= 0 && *sure <= 1, "no such body");
    return body;
}

/* Compares what the firmware said of this frame with the truth. */
static void judge(void)
{
    double sure = 0;
    const int body = named(&sure);
    if (strstr(sim.serial, "alarm frame=") != NULL) {
        count.alarms++;
        /* If a camera was bumped before a reset, a rig that is wrong places the board. Of
         * such starts, one or two in a hundred give a second alarm after the mending. */
        count.false_alarms += still && after == 0;
        count.second += still && after > 0;
        count.from_start += !still && bumped == UNKNOWN;
        from_start = !still && bumped == UNKNOWN;
        unsettled = 1;
        still = 0;
    }
    if (body != UNKNOWN) {
        if (bumped != UNKNOWN) {
            count.names++;
            count.wrong += body != bumped;
            count.doubt += 1 - sure;
        }
        for (int k = 0; k < BODIES; k++) { /* after a wrong name the rig is wrong */
            base[k] = (bumped == UNKNOWN || body == bumped) ? levels[k] : UNKNOWN;
        }
    }
    since_bump++;
    unsettled += unsettled > 0;
    want(unsettled < SETTLE_FRAMES, "never well again after an alarm");
    want(still || unsettled > 0 || since_bump < ALARM_FRAMES, "a bump without an alarm");
}

/* The firmware's answer to the question how it is. */
static int is_well(void)
{
    sim_clear_serial();
    sim_type("how are you?\n");
    if (!run()) {
        return 0;
    }
    want(strstr(sim.serial, " evidence=") != NULL ||
             strcmp(sim.serial, "not watched\r\n") == 0,
         "no answer");
    return strncmp(sim.serial, "well", 4) == 0;
}

static void settle(void)
{
    int at_home = 1;
    if (unsettled < 80 || unsettled % 20 != 0 || !is_well()) {
        return;
    }
    for (int k = 0; k < BODIES; k++) {
        at_home &= base[k] == levels[k];
    }
    count.settled++;
    unsettled = 0;
    still = at_home;
    bumped = UNKNOWN;
    since_bump = 0;
    after = from_start ? AFTER_FRAMES : 0;
    wants_help = !at_home; /* the wrong body was named: somebody holds the board up again */
}

static void frame(void)
{
    const double shift[3] = {0.01 * levels[FIRMWARE_CAMERAS], 0, 0.05};
    sim_clear_serial();
    place_all();
    sim_hold(PORT_AT_WORK, 0.3 + 0.02 * levels[FIRMWARE_CAMERAS], -0.2, shift);
    shoot(0);
    shoot(1);
    count.frames++;
    since_start++;
    at_work = 1;
    count.still_frames += still && after == 0;
    after -= after > 0;
    if (run()) {
        count_lines();
        judge();
        settle();
    }
}

static void flip(void)
{
    if (in_use < 0 || !is_whole(&stored[1 - in_use], 1 - in_use)) {
        return; /* with only one good slot a flipped bit may lose it: nothing is promised */
    }
    const int slot = below(PORT_SLOTS);
    sim.flash[slot][below((int)stored[slot].n)] ^= (uint8_t)(1 << below(8));
    count.flips++;
    reset();
}

/* ---- the bounds ----------------------------------------------------------------- */

/* The chance that a Poisson number with this mean is k or more. */
static double at_least(long k, double mean)
{
    double term = exp(-mean), sum = 0;
    for (long i = 0; i < k; i++) {
        sum += term;
        term *= mean / (double)(i + 1);
    }
    return 1 - sum;
}

static void report(unsigned long seed)
{
    const double mean = (double)count.still_frames / ARL0_FRAMES;
    want(at_least(count.false_alarms, mean) > 1e-4, "more false alarms than stated");
    want(at_least(count.wrong, count.doubt) > 1e-4, "more wrong names than stated");
    printf(
        "| %s | %lu | %ld | %ld | %ld | %ld | %ld | %ld | %ld | %ld | %ld of %ld, %.2f | "
        "%ld of %.2f | %ld of %ld | %ld | %d of %d | %s |\n",
        sizeof(rigcal_real) == sizeof(float) ? "float" : "double", seed, count.ticks,
        count.frames, count.resets, count.cuts, count.flips, count.saved, count.failed,
        count.bumps, count.wrong, count.names, count.doubt, count.false_alarms, mean,
        count.second, count.from_start, count.in_doubt, sim.most_spent, SIM_WATCHDOG_UNITS,
        broken ? "no" : "yes");
}

int main(int argc, char *argv[])
{
#ifdef SIM_TIMER /* the emulated board has no command line */
    argc = 1;
#endif
    const long ticks = (argc > 1) ? atol(argv[1]) : LONG_TICKS;
    const unsigned long seed = (argc > 2) ? strtoul(argv[2], NULL, 10) : 1;
    sim_new(seed);
    sim.noise_px = FIRMWARE_SIGMA_PX;
    in_use = -1;
    reset();
    while (count.ticks < ticks && !broken) {
        if (app.watch.rig.sigma_px <= 0 || wants_help) {
            calibrate();
        } else {
            frame();
        }
        if (still && chance(1.0 / 1500)) {
            bump();
        }
        if (chance(1.0 / 5000)) {
            flip();
        }
        if (chance(1.0 / 3000)) {
            reset();
        }
        wants_help |= chance(1.0 / 20000);
    }
    report(seed);
    return broken;
}
