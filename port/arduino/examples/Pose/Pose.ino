/* Where a camera is, from five points on a target. The search runs in small
 * steps, so that loop() returns soon enough for a watchdog and for the radio. */
#include <rigcal.h>

/* A 16 cm square with a pin on it: X, Y, Z in metres, and where one camera saw it. */
static const rigcal_observation SEEN[] = {{{-0.08f, 0.08f, 0.00f}, {311.7f, 148.6f}},
                                          {{0.08f, 0.08f, 0.00f}, {404.1f, 183.0f}},
                                          {{0.08f, -0.08f, 0.00f}, {400.4f, 286.7f}},
                                          {{-0.08f, -0.08f, 0.00f}, {302.3f, 258.0f}},
                                          {{0.00f, 0.00f, 0.05f}, {378.1f, 206.8f}}};

/* All that the search keeps; it must stay while the search runs. */
static rigcal_camera camera;
static rigcal_pose_solver solver;
static rigcal_status status;

static void report()
{
    rigcal_pose poses[RIGCAL_POSES_MAX];
    size_t found;
    rigcal_real center[3];

    status = rigcal_pose_result(poses, RIGCAL_POSES_MAX, &found, NULL, &solver);
    if (status < 0) {
        Serial.println(rigcal_status_text(status));
        return;
    }
    rigcal_camera_center(center, &poses[0].cam_from_world);
    for (int i = 0; i < 3; i++) {
        Serial.print(center[i], 3);
        Serial.print(i < 2 ? " " : " m, to ");
    }
    Serial.print(poses[0].rms_px, 2);
    Serial.println(" px");
}

void setup()
{
    Serial.begin(115200);
    camera.lens = RIGCAL_LENS_BROWN;
    camera.width = 640;
    camera.height = 480;
    camera.fx = camera.fy = 800;
    camera.cx = 320;
    camera.cy = 240;
    const rigcal_view view = {&camera, SEEN, NULL, sizeof SEEN / sizeof SEEN[0]};
    status = rigcal_pose_begin(&solver, NULL, &view, NULL);
    if (status == RIGCAL_OK) {
        status = RIGCAL_RUNNING;
    } else {
        Serial.println(rigcal_status_text(status));
    }
}

void loop()
{
    if (status == RIGCAL_RUNNING) {
        status = rigcal_pose_step(&solver, 4);
        if (status != RIGCAL_RUNNING) {
            report();
        }
    }
}
