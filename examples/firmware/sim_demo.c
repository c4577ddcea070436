/* sim_demo.c - a day of the simulated board. What the firmware sends goes to standard
 * output. What happens to the board stands between the lines, in brackets. Ends with 1 if
 * the firmware does not do what it should. */
#include "sim.h"

#include <stdio.h>
#include <string.h>

static firmware app;

static void tell(const char *what)
{
    printf("[%s]\n", what);
}

/* Returns 1 if the firmware ended as expected and sent `text`. */
static int expect(sim_end expected, sim_end end, const char *text)
{
    const int ok = end == expected && strstr(sim.serial, text) != NULL;
    if (!ok) {
        printf("[failed: ended with %d, expected %d and \"%s\"]\n", (int)end, (int)expected,
               text);
    }
    sim_clear_serial();
    return ok;
}

static void place(double shift)
{
    const double centers[FIRMWARE_CAMERAS][3] = {{0.5 + shift, -0.2, 1.1},
                                                 {-0.4, 0.3 + shift, 1.3}};
    sim_place(0, centers[0], 0.2);
    sim_place(1, centers[1], -1.4);
}

static void shoot(unsigned mask)
{
    (void)sim_shoot(0, mask);
    (void)sim_shoot(1, 0xff);
}

/* Both cameras see the board in each of its places. */
static void hold_up(void)
{
    for (int f = 1; f <= FIRMWARE_PLACEMENTS; f++) {
        const double shift[3] = {0.05 * f - 0.1, 0.04 * (f % 2), 0.03 * f};
        sim_hold(f, 0.15 * f - 0.4, 0.2 * (f % 3) - 0.2, shift);
        shoot(0xff);
    }
    sim.placement = 0;
}

/* Runs the rig at work for n frames. Camera 1 is turned by `by` [rad] and shifted by half
 * that number of metres. */
static sim_end work(int n, double by)
{
    static const double BOARD[3] = {0, 0, 0.05};
    sim_end end = SIM_IDLE;
    for (int i = 0; i < n && end == SIM_IDLE; i++) {
        const double center[3] = {-0.4, 0.35 + by / 2, 1.3};
        sim_place(1, center, -1.4 + by);
        sim_hold(PORT_AT_WORK, 0.3, -0.2, BOARD);
        shoot(0xff);
        end = sim_run(&app, 1000);
    }
    sim.placement = 0;
    return end;
}

int main(void)
{
    int ok = 1;
    sim_new(1);
    sim.echo = 1;
    sim.noise_px = 0.1;

    tell("power on: the flash is empty");
    ok &= expect(SIM_IDLE, sim_boot(&app), "uncalibrated");

    tell("both cameras see the reference points; then camera 0 sees three, then six");
    place(0);
    shoot(0xff);
    shoot(0x13);
    shoot(0xde);
    ok &= expect(SIM_IDLE, sim_run(&app, 10000), "saved slot=0 sequence=1");

    tell("reset: the poses are there, and the search starts from them");
    ok &= expect(SIM_IDLE, sim_boot(&app), "loaded slot=0 sequence=1");
    shoot(0xff);
    ok &= expect(SIM_IDLE, sim_run(&app, 10000), "status=OK");

    tell("the rig is bumped, and the power goes while the new poses are written");
    place(0.05);
    shoot(0xff);
    sim.cut_after = sim.worked + PORT_SLOT_BYTES + 200;
    ok &= expect(SIM_CUT, sim_run(&app, 10000), "status=OK");
    sim.cut_after = -1;

    tell("power on: the old ones are still there");
    ok &= expect(SIM_IDLE, sim_boot(&app), "loaded slot=0 sequence=1");
    shoot(0xff);
    ok &= expect(SIM_IDLE, sim_run(&app, 10000), "saved slot=1 sequence=2");

    tell("a bit of them flips in flash, and the board is reset");
    sim.flash[1][300] ^= 0x10;
    ok &= expect(SIM_IDLE, sim_boot(&app), "loaded slot=0 sequence=1");
    shoot(0xff);
    ok &= expect(SIM_IDLE, sim_run(&app, 10000), "saved slot=1 sequence=2");

    tell("a board with the points is held up in four places: the rig is adjusted");
    hold_up();
    ok &= expect(SIM_IDLE, sim_run(&app, 10000), "saved slot=0 sequence=3");

    tell("the rig works, and warms up");
    for (int i = 0; i < 60; i++) {
        ok &= work(1, 1e-6 * i) == SIM_IDLE;
    }
    sim_type("how are you?\n");
    ok &= expect(SIM_IDLE, sim_run(&app, 10), "well");

    tell("camera 1 is bumped");
    ok &= expect(SIM_IDLE, work(20, 0.02), "alarm");
    ok &= expect(SIM_IDLE, work(40, 0.02), "saved slot=1 sequence=4");
    sim_type("how are you?\n");
    ok &= expect(SIM_IDLE, sim_run(&app, 10), "well");

    tell("reset: it is watched from where it was left");
    ok &= expect(SIM_IDLE, sim_boot(&app), "loaded slot=1 sequence=4");
    ok &= work(30, 0.02) == SIM_IDLE;
    sim_type("how are you?\n");
    ok &= expect(SIM_IDLE, sim_run(&app, 10), "well");

    printf("[watchdog: %d of %d units spent at most between two feeds]\n", sim.most_spent,
           SIM_WATCHDOG_UNITS);
    if (sim.most_instructions > 0) {
        printf("[watchdog: %u instructions at most between two feeds]\n",
               (unsigned)sim.most_instructions);
    }
    printf("[memory: %u bytes of the firmware's own, solver included]\n",
           (unsigned)sizeof app);
    printf(ok ? "[all as it should be]\n" : "[not as it should be]\n");
    return ok ? 0 : 1;
}
