#include "watch.h"

#include <string.h>

#include "line.h"

#define R(x) ((rigcal_real)(x))

/* s: the time between two frames. */
#define FRAME_SECONDS R(0.1)

/* While the rig warms up, each camera turns and shifts randomly by this in the square root
 * of a second [rad, m]. */
#define WARM_RAD R(2e-5)
#define WARM_T R(2e-5)

/* One false alarm a day, with ten frames a second. */
#define ARL0_FRAMES R(864000)

enum {
    BLAME_FRAMES = 15,  /* after an alarm, until it is known which body moved */
    MENDING_FRAMES = 20 /* after that, until the new pose is stored */
};

void watch_clear(firmware_watch *w)
{
    memset(w, 0, sizeof *w);
    w->rig.cameras = w->cameras;
    w->rig.group = w->group;
    w->rig.held = w->held;
    w->rig.capacity = FIRMWARE_CAMERAS;
    w->rig.Sigma = w->Sigma;
    w->rig.Sigma_capacity = sizeof w->Sigma / sizeof w->Sigma[0];
}

/* Starts the monitor from the stored rig. */
static void begin(firmware_watch *w)
{
    rigcal_monitor_options options;
    if (w->rig.sigma_px > 0 && rigcal_monitor_defaults(&options) == RIGCAL_OK) {
        options.arl0_frames = ARL0_FRAMES;
        options.walk_rad = WARM_RAD;
        options.walk_t = WARM_T;
        w->is_on =
            rigcal_monitor_begin(w->monitor, sizeof w->monitor / sizeof w->monitor[0],
                                 &w->rig, 1, &options) == RIGCAL_OK;
    }
}

static void put_body(line *out, int32_t body)
{
    if (body < FIRMWARE_CAMERAS) {
        put_count(out, " camera=", (uint32_t)body);
    } else {
        put_text(out, " board");
    }
}

/* Sends the alarm at once. When there is enough data to say which body moved, that body is
 * solved again. */
static void answer_alarm(firmware_watch *w, const rigcal_monitor_report *report)
{
    line out = {{0}, 0};
    if (report->frames_since == 1) {
        put_text(&out, "alarm");
        put_count(&out, " frame=", report->frames);
        send_line(&out);
    } else if (report->frames_since == BLAME_FRAMES &&
               rigcal_monitor_moved(w->monitor, (size_t)report->body) == RIGCAL_OK) {
        put_text(&out, "moved");
        put_body(&out, report->body);
        put_text(&out, " sure=");
        put_micro(&out, report->confidence);
        send_line(&out);
        w->mending = MENDING_FRAMES;
    }
}

int watch_view(firmware_watch *w, int32_t camera, const rigcal_view *view)
{
    rigcal_monitor_report report;
    if (!w->is_on) {
        begin(w);
    }
    if (!w->is_on) {
        return 0;
    }
    (void)rigcal_monitor_view(w->monitor, NULL, (size_t)camera, 0, view->observations,
                              view->n, R(FIRMWARE_SIGMA_PX));
    if (camera != FIRMWARE_CAMERAS - 1 ||
        rigcal_monitor_frame(&report, w->monitor, FRAME_SECONDS) != RIGCAL_OK) {
        return 0;
    }
    if (report.alarm) {
        answer_alarm(w, &report);
        return 0;
    }
    w->mending -= (w->mending > 0) ? 1 : 0;
    return w->mending == 0 && rigcal_monitor_rig(&w->rig, w->monitor) == RIGCAL_OK;
}

void watch_answer(const firmware_watch *w)
{
    rigcal_monitor_report report;
    line out = {{0}, 0};
    if (!w->is_on || rigcal_monitor_ask(&report, w->monitor) != RIGCAL_OK) {
        put_text(&out, "not watched");
        send_line(&out);
        return;
    }
    put_text(&out, report.alarm ? "alarm" : report.n_blind > 0 ? "blind" : "well");
    if (report.alarm) {
        put_body(&out, report.body);
        put_text(&out, " sure=");
        put_micro(&out, report.confidence);
    }
    put_text(&out, " evidence=");
    put_micro(&out, report.evidence);
    put_text(&out, " noise=");
    put_micro(&out, report.noise);
    put_text(&out, " smallest=");
    put_micro(&out, report.smallest_rad);
    put_count(&out, " frames=", report.frames);
    put_count(&out, " rows=", report.rows);
    put_count(&out, " doubted=", report.doubted);
    send_line(&out);
}
