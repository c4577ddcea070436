/* main_template.c - a firmware's first program with rigcal.
 *
 * Copy it, fill in the three functions of the board, and run it: 0 says that the
 * port works. The search runs in steps, so that the watchdog is fed and the rest of
 * the firmware has its turn; to give up, stop calling: there is nothing to free. */
#include <stdio.h>

#include "rigcal.h"

/* ---- the board's --------------------------------------------------------- */

static void feed_watchdog(void)
{
}

/* Whether to give up: a button, a deadline, a message. */
static int must_stop(void)
{
    return 0;
}

static void say(const char *text)
{
    puts(text);
}

/* ---- a target whose pose is known ---------------------------------------- */

/* Four corners of a square 2 ahead of the camera and a pin that sticks out by 0.4:
 * u = 320 + 800 X / Z, v = 240 + 800 Y / Z, Z = 2 and 1.6, with no rounding. */
static const rigcal_observation SEEN[] = {
    {{-1, -1, 0}, {-80, -160}},
    {{1, -1, 0}, {720, -160}},
    {{1, 1, 0}, {720, 640}},
    {{-1, 1, 0}, {-80, 640}},
    {{(rigcal_real)0.5, 0, (rigcal_real)-0.4}, {570, 240}}};

enum { POINTS = sizeof SEEN / sizeof SEEN[0] };

static const rigcal_real CENTER[3] = {0, 0, -2};

/* Evaluations between two feedings of the watchdog. */
enum { BUDGET = 4 };

/* Static, because a task's stack may be too small for a solver. */
static rigcal_camera camera;
static rigcal_pose_solver solver;
static rigcal_pose poses[RIGCAL_POSES_MAX];

static void set_camera(void)
{
    camera.lens = RIGCAL_LENS_BROWN;
    camera.width = 640;
    camera.height = 480;
    camera.fx = camera.fy = 800;
    camera.cx = 320;
    camera.cy = 240;
}

/* Some compiler options break this check. Not every compiler tells the library about them:
 * see include/rigcal_config.h. */
static int refuses_nan(void)
{
    const volatile rigcal_real zero = 0;
    rigcal_real uv[2] = {0, 0}, ray[3];

    uv[0] = zero / zero;
    return rigcal_camera_ray(ray, &camera, uv) == RIGCAL_ERR_NOT_FINITE;
}

static rigcal_status solve(size_t *n_found)
{
    const rigcal_view view = {&camera, SEEN, NULL, POINTS};
    rigcal_status status = rigcal_pose_begin(&solver, NULL, &view, NULL);

    if (status != RIGCAL_OK) {
        return status;
    }
    do {
        feed_watchdog();
        if (must_stop()) {
            return RIGCAL_RUNNING;
        }
        status = rigcal_pose_step(&solver, BUDGET);
    } while (status == RIGCAL_RUNNING);
    return rigcal_pose_result(poses, RIGCAL_POSES_MAX, n_found, NULL, &solver);
}

int main(void)
{
    rigcal_real center[3];
    rigcal_status status;
    size_t n_found;

    if (rigcal_sizeof_real() != (int32_t)sizeof(rigcal_real) ||
        rigcal_version() != RIGCAL_VERSION_MAJOR * 10000 + RIGCAL_VERSION_MINOR * 100 +
                                RIGCAL_VERSION_PATCH) {
        say("The library was not compiled as this program was.");
        return 1;
    }
    set_camera();
    if (!refuses_nan()) {
        say("NaN is taken for a number: the library has a wrong compiler option.");
        return 1;
    }
    status = solve(&n_found);
    if (status != RIGCAL_OK) {
        say(rigcal_status_text(status));
        return 1;
    }
    rigcal_camera_center(center, &poses[0].cam_from_world);
    for (int i = 0; i < 3; i++) {
        const rigcal_real off = center[i] - CENTER[i];

        if (!(off < (rigcal_real)1e-4 && off > (rigcal_real)-1e-4)) {
            say("The pose is not the right one.");
            return 1;
        }
    }
    say("rigcal works on this board.");
    return 0;
}
