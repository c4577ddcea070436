#include "sim.h"

#include <math.h>
#include <setjmp.h>
#include <stdio.h>
#include <string.h>

sim_board sim;

static jmp_buf board_stopped;

/* ---- chance (SplitMix64) ---------------------------------------------------- */

static uint64_t next_random(void)
{
    uint64_t z = sim.random += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

double sim_uniform(void)
{
    return (double)(next_random() >> 11) / 9007199254740992.0;
}

static double normal(void)
{
    double sum = -6;
    for (int i = 0; i < 12; i++) {
        sum += sim_uniform();
    }
    return sum;
}

/* ---- time and the watchdog --------------------------------------------------- */

/* Timer 0 of the mps2 boards counts 25 MHz of QEMU's time. With -icount that time is a
 * number of instructions: at shift 10, 25.6 instructions for each count. */
#ifdef SIM_TIMER
#define TIMER ((volatile uint32_t *)0x40000000)

static uint32_t counts_now(void)
{
    if (TIMER[0] == 0) {
        TIMER[1] = 0xffffffff; /* value */
        TIMER[2] = 0xffffffff; /* reload */
        TIMER[0] = 1;
    }
    return ~TIMER[1];
}
#else
static uint32_t counts_now(void)
{
    return 0;
}
#endif

static void spend(int units)
{
    sim.spent += units;
    if (sim.spent > sim.watchdog_units) {
        longjmp(board_stopped, SIM_WATCHDOG);
    }
}

void port_feed_watchdog(void)
{
    const uint32_t now = counts_now();
    const uint32_t instructions = (uint32_t)((now - sim.fed_at) * 10.0 / 256);
    if (instructions > sim.most_instructions) {
        sim.most_instructions = instructions;
    }
    if (instructions > SIM_WATCHDOG_INSTRUCTIONS) {
        longjmp(board_stopped, SIM_WATCHDOG);
    }
    if (sim.spent > sim.most_spent) {
        sim.most_spent = sim.spent;
    }
    sim.spent = 0;
    sim.fed_at = counts_now();
}

/* firmware.c is compiled with this name in place of rigcal_pose_step, so that the watchdog
 * can count the evaluations a step may take. */
rigcal_status sim_pose_step(rigcal_pose_solver *solver, int32_t budget);

rigcal_status sim_pose_step(rigcal_pose_solver *solver, int32_t budget)
{
    spend(budget * SIM_COST_EVAL);
    return rigcal_pose_step(solver, budget);
}

/* The same for a step of the rig's adjustment. */
rigcal_status sim_rig_step(rigcal_rig_solver *solver, int32_t budget);

rigcal_status sim_rig_step(rigcal_rig_solver *solver, int32_t budget)
{
    spend(budget * SIM_COST_EVAL);
    return rigcal_rig_step(solver, budget);
}

/* ---- the serial line ------------------------------------------------------------ */

void port_send(const char text[], size_t n)
{
    const uint32_t begin = counts_now();
    if (sim.echo) {
        fwrite(text, 1, n, stdout);
    }
    if (sim.n_serial + n < sizeof sim.serial) {
        memcpy(sim.serial + sim.n_serial, text, n);
        sim.n_serial += n;
        sim.serial[sim.n_serial] = '\0';
    }
    sim.fed_at += counts_now() - begin; /* hardware would do this at the same time */
}

int port_receive(void)
{
    const char c = sim.typed[0];
    if (c == '\0') {
        return -1;
    }
    memmove(sim.typed, sim.typed + 1, sizeof sim.typed - 1);
    return (unsigned char)c;
}

void sim_type(const char *text)
{
    const size_t used = strlen(sim.typed);
    strncat(sim.typed, text, sizeof sim.typed - 1 - used);
}

void sim_clear_serial(void)
{
    sim.n_serial = 0;
    sim.serial[0] = '\0';
}

/* ---- flash ---------------------------------------------------------------------- */

const uint8_t *port_flash(int slot)
{
    return sim.flash[slot];
}

/* The byte after only some of the changed bits of `to` have been written. */
static uint8_t partly(uint8_t from, uint8_t to)
{
    return (uint8_t)(from ^ ((from ^ to) & (uint8_t)next_random()));
}

/* Changes n bytes one by one until the power is cut. Bits of a stuck byte stay 1. */
static void work(uint8_t *cell, const uint8_t *to, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        if (sim.cut_after >= 0 && sim.worked >= sim.cut_after) {
            if (sim.cut == SIM_CUT_HALF) {
                cell[i] = partly(cell[i], to[i]);
            }
            for (size_t k = 0; sim.cut == SIM_CUT_SCATTERED && k < n; k++) {
                cell[k] = partly(cell[k], to[k]);
            }
            longjmp(board_stopped, SIM_CUT);
        }
        cell[i] = to[i];
        if (cell + i == &sim.flash[sim.stuck_slot][sim.stuck_at]) {
            cell[i] |= sim.stuck_mask;
        }
        sim.worked++;
    }
}

int port_flash_erase(int slot)
{
    uint8_t to[PORT_SLOT_BYTES];
    spend(SIM_COST_ERASE);
    if (sim.erase_fails > 0) {
        sim.erase_fails--;
        return 0;
    }
    memset(to, 0xff, sizeof to);
    memset(sim.is_programmed[slot], 1, sizeof sim.is_programmed[slot]);
    work(sim.flash[slot], to, sizeof to);
    memset(sim.is_programmed[slot], 0, sizeof sim.is_programmed[slot]);
    sim.erases++;
    return 1;
}

int port_flash_program(int slot, size_t at, const uint8_t page[PORT_PAGE_BYTES])
{
    uint8_t to[PORT_PAGE_BYTES];
    uint8_t *const cell = sim.flash[slot] + at;
    spend(SIM_COST_PAGE);
    if (sim.program_fails > 0) {
        sim.program_fails--;
        return 0;
    }
    if (at % PORT_PAGE_BYTES != 0 || at >= PORT_SLOT_BYTES ||
        sim.is_programmed[slot][at / PORT_PAGE_BYTES]) {
        sim.misuse++;
        return 0;
    }
    sim.is_programmed[slot][at / PORT_PAGE_BYTES] = 1;
    for (size_t i = 0; i < PORT_PAGE_BYTES; i++) {
        sim.misuse += (page[i] & (uint8_t)~cell[i]) != 0;
        to[i] = cell[i] & page[i];
    }
    work(cell, to, sizeof to);
    sim.pages++;
    return 1;
}

/* ---- cameras -------------------------------------------------------------------- */

static void unit(double v[3])
{
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; i++) {
        v[i] /= length;
    }
}

static void cross(double c[3], const double a[3], const double b[3])
{
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        c[i] = a[j] * b[k] - a[k] * b[j];
    }
}

void sim_place(int camera, const double center[3], double roll)
{
    static const double DOWN[3] = {0, -1, 0};
    double *const R = sim.R[camera];
    double x[3], y[3], z[3] = {0, 0, 0};
    for (int p = 0; p < FIRMWARE_POINTS; p++) {
        for (int i = 0; i < 3; i++) {
            z[i] += (double)FIRMWARE_TARGET[p][i] / FIRMWARE_POINTS;
        }
    }
    for (int i = 0; i < 3; i++) {
        z[i] -= center[i];
    }
    unit(z);
    cross(x, DOWN, z);
    unit(x);
    cross(y, z, x);
    for (int i = 0; i < 3; i++) {
        R[i] = cos(roll) * x[i] + sin(roll) * y[i];
        R[3 + i] = cos(roll) * y[i] - sin(roll) * x[i];
        R[6 + i] = z[i];
    }
    for (int i = 0; i < 3; i++) {
        sim.t[camera][i] =
            -(R[3 * i] * center[0] + R[3 * i + 1] * center[1] + R[3 * i + 2] * center[2]);
    }
}

/* The formulas of rigcal.h for Brown's lens, in double. */
static void pixel(double uv[2], const rigcal_camera *c, const double X_c[3])
{
    const double x = X_c[0] / X_c[2], y = X_c[1] / X_c[2], q = x * x + y * y;
    const double p1 = (double)c->p1, p2 = (double)c->p2;
    const double d = (1 + q * ((double)c->k1 + q * ((double)c->k2 + q * (double)c->k3))) /
                     (1 + q * ((double)c->k4 + q * ((double)c->k5 + q * (double)c->k6)));
    uv[0] = (double)c->fx * (x * d + 2 * p1 * x * y + p2 * (q + 2 * x * x)) + (double)c->cx;
    uv[1] = (double)c->fy * (y * d + p1 * (q + 2 * y * y) + 2 * p2 * x * y) + (double)c->cy;
}

void sim_hold(int placement, double about_y, double about_x, const double shift[3])
{
    const double cy = cos(about_y), sy = sin(about_y), cx = cos(about_x), sx = sin(about_x);
    const double R[9] = {cy, sy * sx, sy * cx, 0, cx, -sx, -sy, cy * sx, cy * cx};
    memcpy(sim.turn, R, sizeof R);
    memcpy(sim.shift, shift, sizeof sim.shift);
    sim.placement = placement;
}

port_frame *sim_shoot(int camera, unsigned mask)
{
    port_frame *const frame = &sim.frames[(sim.first + sim.n_frames) % SIM_FRAMES_MAX];
    const double *const R = sim.R[camera];
    sim.n_frames++;
    memset(frame, 0, sizeof *frame);
    frame->camera = camera;
    frame->placement = sim.placement;
    for (int p = 0; p < FIRMWARE_POINTS; p++) {
        double X_c[3], X[3], uv[2];
        if ((mask >> p & 1) == 0) {
            continue;
        }
        for (int i = 0; i < 3; i++) {
            X[i] = (double)FIRMWARE_TARGET[p][i];
        }
        for (int i = 0; i < 3 && sim.placement != 0; i++) {
            X[i] = sim.shift[i];
            for (int k = 0; k < 3; k++) {
                X[i] += sim.turn[3 * i + k] * (double)FIRMWARE_TARGET[p][k];
            }
        }
        for (int i = 0; i < 3; i++) {
            X_c[i] = sim.t[camera][i];
            for (int k = 0; k < 3; k++) {
                X_c[i] += R[3 * i + k] * X[k];
            }
        }
        pixel(uv, &FIRMWARE_INTRINSICS[camera], X_c);
        frame->id[frame->n] = p;
        frame->uv[frame->n][0] = (float)(uv[0] + sim.noise_px * normal());
        frame->uv[frame->n][1] = (float)(uv[1] + sim.noise_px * normal());
        frame->n++;
    }
    return frame;
}

int port_take_frame(port_frame *frame)
{
    if (sim.n_frames == 0) {
        return 0;
    }
    *frame = sim.frames[sim.first];
    sim.first = (sim.first + 1) % SIM_FRAMES_MAX;
    sim.n_frames--;
    return 1;
}

/* ---- the board ------------------------------------------------------------------- */

void sim_new(uint64_t seed)
{
    memset(&sim, 0, sizeof sim);
    memset(sim.flash, 0xff, sizeof sim.flash);
    sim.random = seed;
    sim.cut_after = -1;
    sim.watchdog_units = SIM_WATCHDOG_UNITS;
}

sim_end sim_boot(firmware *f)
{
    const int stopped = setjmp(board_stopped);
    if (stopped != 0) {
        return (sim_end)stopped;
    }
    memset(f, 0xa5, sizeof *f);
    sim.spent = 0;
    sim.fed_at = counts_now();
    spend(SIM_COST_BOOT);
    firmware_boot(f);
    return SIM_IDLE;
}

sim_end sim_run(firmware *f, int most)
{
    /* Variables that change between setjmp and longjmp are in `sim`. */
    const int stopped = setjmp(board_stopped);
    if (stopped != 0) {
        return (sim_end)stopped;
    }
    sim.fed_at = counts_now();
    for (volatile int i = 0; i < most; i++) {
        if (sim.n_frames == 0 && f->state == 0 && sim.typed[0] == '\0') {
            return SIM_IDLE;
        }
        spend(SIM_COST_TICK);
        firmware_tick(f);
    }
    return SIM_BUSY;
}
