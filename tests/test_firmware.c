/* firmware: the example of examples/firmware on its simulated board. Its stored calibration
 * is tested most: the power is cut after every single byte of work on the flash, and every
 * stored bit is flipped. */
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "sim.h"
#include "test_support.h"

enum {
    ALL = 0xff, /* all eight reference points are seen */
    SAVED_BYTES = RIGCAL_STORE_SIZE(FIRMWARE_CAMERAS),
    PAGES = (SAVED_BYTES + PORT_PAGE_BYTES - 1) / PORT_PAGE_BYTES,
    WORK = PORT_SLOT_BYTES + PAGES * PORT_PAGE_BYTES, /* bytes of flash work of one
                                                         saving */
    TICKS = 20000
};

static firmware app;

static const double HERE[FIRMWARE_CAMERAS][3] = {{0.5, -0.2, 1.1}, {-0.4, 0.3, 1.3}};
static const double THERE[FIRMWARE_CAMERAS][3] = {{0.55, -0.2, 1.1}, {-0.4, 0.36, 1.25}};

static void place(const double center[FIRMWARE_CAMERAS][3])
{
    sim_place(0, center[0], 0.2);
    sim_place(1, center[1], -1.4);
}

void setUp(void)
{
    sim_new(7);
    sim.noise_px = 0.1;
    place(HERE);
}

/* Whatever was done to the firmware, it must not misuse the flash. */
void tearDown(void)
{
    TEST_ASSERT_EQUAL_INT(0, sim.misuse);
}

/* ---- helpers ----------------------------------------------------------- */

static void boot(void)
{
    sim_clear_serial();
    TEST_ASSERT_EQUAL_INT(SIM_IDLE, sim_boot(&app));
}

static void run(void)
{
    sim_clear_serial();
    TEST_ASSERT_EQUAL_INT(SIM_IDLE, sim_run(&app, TICKS));
}

static void shoot_both(void)
{
    (void)sim_shoot(0, ALL);
    (void)sim_shoot(1, ALL);
}

/* A board that has calibrated itself, and has saved the result as sequence number 1 in slot
 * 0. */
static void calibrate(void)
{
    boot();
    shoot_both();
    run();
    TEST_ASSERT_EQUAL_INT32(0, app.slot);
    TEST_ASSERT_EQUAL_UINT32(1, app.sequence);
}

static void assert_sent(const char *text)
{
    if (strstr(sim.serial, text) == NULL) {
        TEST_MESSAGE(sim.serial);
        TEST_FAIL_MESSAGE(text);
    }
}

static int times_sent(const char *text)
{
    const char *at = sim.serial;
    int n = 0;

    while ((at = strstr(at, text)) != NULL) {
        at += strlen(text);
        n++;
    }
    return n;
}

typedef struct {
    unsigned camera, frame, ticks;
    char status[24];
    double center[3], turn[3], sigma_center[3], sigma_turn[3], rms;
} pose_line;

/* Reads one line in the form that README.md of the example describes, and moves *at on.
 * Returns 0 if it is not a pose line in that form. */
static int read_pose_line(pose_line *p, const char **at)
{
    int n = -1;
    const int fields =
        sscanf(*at,
               "pose camera=%u frame=%u status=%23s center=%lf,%lf,%lf turn=%lf,%lf,%lf "
               "+-center=%lf,%lf,%lf +-turn=%lf,%lf,%lf rms=%lf ticks=%u\r\n%n",
               &p->camera, &p->frame, p->status, &p->center[0], &p->center[1],
               &p->center[2], &p->turn[0], &p->turn[1], &p->turn[2], &p->sigma_center[0],
               &p->sigma_center[1], &p->sigma_center[2], &p->sigma_turn[0],
               &p->sigma_turn[1], &p->sigma_turn[2], &p->rms, &p->ticks, &n);

    if (fields != 17 || n < 0) {
        return 0;
    }
    *at += n;
    return 1;
}

/* Compares every number exactly. Only the lower triangle of a covariance is stored, so the
 * upper one is its mirror afterwards. Padding of the struct does not count. */
static void assert_same_cameras(const rigcal_mounted_camera expected[],
                                const rigcal_mounted_camera actual[])
{
    for (int i = 0; i < FIRMWARE_CAMERAS; i++) {
        const rigcal_mounted_camera *const e = &expected[i], *const a = &actual[i];

        TEST_ASSERT_EQUAL_INT32(e->camera.lens, a->camera.lens);
        TEST_ASSERT_EQUAL_INT32(e->camera.width, a->camera.width);
        TEST_ASSERT_EQUAL_INT32(e->camera.height, a->camera.height);
        TEST_ASSERT_EQUAL_MEMORY(&e->camera.fx, &a->camera.fx,
                                 sizeof e->camera - offsetof(rigcal_camera, fx));
        TEST_ASSERT_EQUAL_MEMORY(&e->cam_from_rig, &a->cam_from_rig,
                                 sizeof e->cam_from_rig);
        for (int k = 0; k < 36; k++) {
            const int row = k / 6, column = k % 6;
            const int lower = (column > row) ? 6 * column + row : k;

            ASSERT_NEAR(e->Sigma[lower], a->Sigma[k], 0);
        }
        TEST_ASSERT_EQUAL_INT32(e->has_Sigma, a->has_Sigma);
    }
}

/* The largest difference of the true pose from the one in a line, over six numbers, in its
 * sigmas. */
static double worst_in_sigmas(const pose_line *p)
{
    const double *const R = sim.R[p->camera], *const t = sim.t[p->camera];
    double worst = 0, Rt[9], found[9], between[9], c[3];
    const double angle = test_norm(p->turn);

    test_transpose(Rt, R);
    test_apply(c, Rt, t, NULL);
    for (int i = 0; i < 3; i++) {
        worst = fmax(worst, fabs(p->center[i] + c[i]) / p->sigma_center[i]);
    }
    test_rotation_about(found, p->turn, angle);
    test_product(between, found, Rt);
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const double w = (between[3 * k + j] - between[3 * j + k]) / 2;

        worst = fmax(worst, fabs(w) / p->sigma_turn[i]);
    }
    return worst;
}

/* ---- poses and their lines --------------------------------------------- */

static void test_a_new_board_says_that_it_is_uncalibrated(void)
{
    boot();
    TEST_ASSERT_EQUAL_STRING("uncalibrated\r\n", sim.serial);
    run();
    TEST_ASSERT_EQUAL_STRING("", sim.serial);
    TEST_ASSERT_EQUAL_INT(0, sim.erases + sim.pages);
}

static void test_a_pose_is_reported_within_its_uncertainty(void)
{
    double sum = 0;
    int n = 0;

    boot();
    sim.noise_px = 0.2; /* the noise that the firmware assumes */
    for (int trial = 0; trial < 200; trial++) {
        const double center[3] = {2 * sim_uniform() - 1, 2 * sim_uniform() - 1,
                                  1 + sim_uniform()};
        const char *at = sim.serial;
        pose_line p;

        sim_place(trial % 2, center, 6.28 * sim_uniform());
        (void)sim_shoot(trial % 2, ALL);
        run();
        TEST_ASSERT_TRUE_MESSAGE(read_pose_line(&p, &at), sim.serial);
        TEST_ASSERT_EQUAL_UINT(trial % 2, p.camera);
        TEST_ASSERT_EQUAL_UINT(trial + 1, p.frame);
        TEST_ASSERT_EQUAL_STRING("OK", p.status);
        TEST_ASSERT_TRUE(p.rms > 0.02 && p.rms < 0.8);
        TEST_ASSERT_TRUE(p.ticks >= 1);
        /* Each pose has six numbers. One is beyond 5 sigma once in a million cases. */
        TEST_ASSERT_TRUE_MESSAGE(worst_in_sigmas(&p) < 5, sim.serial);
        sum += worst_in_sigmas(&p);
        n++;
    }
    /* The largest of six normal numbers, which are correlated: between one and two in the
     * mean, if the sigmas are right. */
    TEST_ASSERT_TRUE(sum / n > 0.8 && sum / n < 2);
}

static void test_the_numbers_sent_are_the_pose_to_half_a_millionth(void)
{
    double R[9], Rt[9], t[3], c[3];
    const char *at = sim.serial;
    pose_line p;

    boot();
    (void)sim_shoot(1, ALL);
    run();
    TEST_ASSERT_TRUE(read_pose_line(&p, &at));
    TEST_ASSERT_EQUAL_STRING("", at);
    test_transform_parts(R, t, &app.cameras[1].cam_from_rig);
    test_transpose(Rt, R);
    test_apply(c, Rt, t, NULL);
    for (int i = 0; i < 3; i++) {
        ASSERT_NEAR(-c[i], p.center[i], TOL(0.51e-6, 1e-6));
    }
    test_rotation_about(Rt, p.turn, test_norm(p.turn));
    TEST_ASSERT_TRUE(test_angle_between(R, Rt) < TOL(1e-6, 3e-6));
    for (int i = 0; i < 3; i++) {
        ASSERT_NEAR(sqrt(D(app.cameras[1].Sigma[7 * i])), p.sigma_turn[i], 0.51e-6);
    }
}

/* A line has room for two thousand metres. */
static void test_a_position_out_of_range_is_sent_as_the_range_s_end(void)
{
    static const double FAR_AWAY[3] = {0, 0, 30000};
    const char *at = sim.serial;
    pose_line p;

    boot();
    sim.noise_px = 0;
    sim_place(0, FAR_AWAY, 0);
    (void)sim_shoot(0, ALL);
    run();
    if (read_pose_line(&p, &at)) {
        for (int i = 0; i < 3; i++) {
            TEST_ASSERT_TRUE(fabs(p.center[i]) <= 2147.001);
            TEST_ASSERT_TRUE(fabs(p.sigma_center[i]) <= 2147.001);
        }
    } else {
        assert_sent("none camera=0 frame=1 status=ERR_");
    }
}

/* ---- detections that are missing or wrong ------------------------------ */

static void test_too_few_corners_make_no_pose_and_harm_nothing(void)
{
    boot();
    (void)sim_shoot(0, 0);
    (void)sim_shoot(0, 0x01);
    (void)sim_shoot(0, 0x07);
    (void)sim_shoot(1, 0x43);
    run();
    TEST_ASSERT_EQUAL_STRING("none camera=0 frame=1 status=ERR_TOO_FEW\r\n"
                             "none camera=0 frame=2 status=ERR_TOO_FEW\r\n"
                             "none camera=0 frame=3 status=ERR_TOO_FEW\r\n"
                             "none camera=1 frame=4 status=ERR_TOO_FEW\r\n",
                             sim.serial);
    shoot_both();
    run();
    TEST_ASSERT_EQUAL_INT(2, times_sent("status=OK"));
}

static void test_a_camera_that_drops_detections_gives_poses_from_the_rest(void)
{
    int n_poses = 0, n_few = 0;

    calibrate();
    for (int trial = 0; trial < 300; trial++) {
        unsigned mask = 0;
        int n = 0;
        const char *at = sim.serial;
        pose_line p;

        for (int k = 0; k < FIRMWARE_POINTS; k++) {
            if (sim_uniform() < 0.6) {
                mask |= 1u << k;
                n++;
            }
        }
        (void)sim_shoot(trial % 2, mask);
        run();
        if (n < 4) {
            assert_sent("ERR_TOO_FEW");
            n_few++;
        } else {
            TEST_ASSERT_TRUE_MESSAGE(read_pose_line(&p, &at), sim.serial);
            /* The noise is 0.1, and 0.2 is assumed. */
            TEST_ASSERT_TRUE_MESSAGE(worst_in_sigmas(&p) < 3, sim.serial);
            n_poses++;
        }
    }
    TEST_ASSERT_TRUE(n_few > 10 && n_poses > 200);
}

static void test_detections_that_cannot_be_are_left_out(void)
{
    port_frame *frame;
    const char *at = sim.serial;
    pose_line p;

    boot();
    frame = sim_shoot(0, ALL);
    frame->id[1] = -1;
    frame->id[3] = FIRMWARE_POINTS;
    frame->id[4] = INT32_MAX;
    frame->id[6] = frame->id[0]; /* it appears twice; the first one counts */
    run();
    TEST_ASSERT_TRUE_MESSAGE(read_pose_line(&p, &at), sim.serial);
    TEST_ASSERT_TRUE(worst_in_sigmas(&p) < 5);

    frame = sim_shoot(0, ALL);
    frame->uv[2][1] = (float)test_nan();
    frame = sim_shoot(0, ALL);
    frame->n = 1000; /* more corners than fit into the array */
    frame = sim_shoot(0, ALL);
    frame->n = -1;
    frame = sim_shoot(0, ALL);
    frame->camera = FIRMWARE_CAMERAS;
    frame = sim_shoot(0, ALL);
    frame->camera = -1;
    (void)sim_shoot(0, ALL);
    run();
    at = strstr(sim.serial, "pose");
    assert_sent("none camera=0 frame=2 status=ERR_NOT_FINITE\r\n");
    TEST_ASSERT_NOT_NULL(at);
    TEST_ASSERT_EQUAL_INT(2, times_sent("status=OK"));
    assert_sent("none camera=0 frame=4 status=ERR_TOO_FEW\r\n");
    /* The camera that does not exist is not mentioned. */
    TEST_ASSERT_EQUAL_INT(4, times_sent("camera=0"));
    TEST_ASSERT_EQUAL_INT(4, times_sent("\r\n"));
}

/* Wrong correspondences show in the error of the pose. It is reported, but not stored. */
static void test_a_pose_that_fits_badly_is_told_but_not_kept(void)
{
    port_frame *frame;
    rigcal_transform before;

    calibrate();
    before = app.cameras[0].cam_from_rig;
    frame = sim_shoot(0, ALL);
    for (int k = 0; k < 4; k++) {
        frame->id[k] = (k + 2) % 4;
    }
    run();
    assert_sent("status=POOR_FIT");
    sim.noise_px = 2; /* ten times the assumed noise of corners */
    (void)sim_shoot(0, ALL);
    sim.noise_px = 0.1;
    run();
    assert_sent("status=POOR_FIT");
    TEST_ASSERT_EQUAL_MEMORY(&before, &app.cameras[0].cam_from_rig, sizeof before);
    (void)sim_shoot(0, ALL);
    run();
    TEST_ASSERT_EQUAL_INT(1, times_sent("status=OK"));
    TEST_ASSERT_EQUAL_INT(1, sim.erases);
}

/* ---- remembering ------------------------------------------------------- */

static void test_a_calibration_is_saved_once_every_camera_has_a_pose(void)
{
    rigcal_mounted_camera cameras[FIRMWARE_CAMERAS];
    rigcal_saved_info info;

    boot();
    (void)sim_shoot(0, ALL);
    (void)sim_shoot(0, ALL);
    run();
    TEST_ASSERT_EQUAL_INT(0, sim.erases + sim.pages);
    (void)sim_shoot(1, ALL);
    run();
    assert_sent("saved slot=0 sequence=1\r\n");
    TEST_ASSERT_EQUAL_INT(1, sim.erases);
    TEST_ASSERT_EQUAL_INT(PAGES, sim.pages);
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_load(cameras, FIRMWARE_CAMERAS, &info,
                                               sim.flash[0], PORT_SLOT_BYTES));
    assert_same_cameras(app.cameras, cameras);
    TEST_ASSERT_EQUAL_HEX32(FIRMWARE_SERIAL, info.tag);
    TEST_ASSERT_EQUAL_UINT32(1, info.sequence);
    for (int i = SAVED_BYTES; i < PORT_SLOT_BYTES; i++) {
        TEST_ASSERT_EQUAL_HEX8(0xff, sim.flash[0][i]);
    }
    for (int i = 0; i < PORT_SLOT_BYTES; i++) {
        TEST_ASSERT_EQUAL_HEX8(0xff, sim.flash[1][i]);
    }
}

static void test_cameras_that_stay_where_they_are_wear_no_flash(void)
{
    calibrate();
    sim.noise_px = 0.2;
    for (int i = 0; i < 30; i++) {
        shoot_both();
        run();
        TEST_ASSERT_EQUAL_INT(2, times_sent("status=OK"));
    }
    boot(); /* nor a reset */
    shoot_both();
    run();
    TEST_ASSERT_EQUAL_INT(1, sim.erases);
}

static void test_a_camera_that_only_turned_or_only_moved_is_saved(void)
{
    calibrate();
    sim_place(1, HERE[1], -1.4 + 0.03);
    shoot_both();
    run();
    assert_sent("saved slot=1 sequence=2\r\n");
    sim.t[0][0] += 0.03;
    shoot_both();
    run();
    assert_sent("saved slot=0 sequence=3\r\n");
}

static void test_savings_take_turns_between_the_slots(void)
{
    char text[64];

    calibrate();
    for (uint32_t sequence = 2; sequence < 8; sequence++) {
        place(sequence % 2 == 0 ? THERE : HERE);
        shoot_both();
        run();
        TEST_ASSERT_EQUAL_INT(1, times_sent("saved"));
        snprintf(text, sizeof text, "saved slot=%u sequence=%u\r\n",
                 (unsigned)(sequence + 1) % 2, (unsigned)sequence);
        assert_sent(text);
        boot();
        snprintf(text, sizeof text, "loaded slot=%u sequence=%u\r\n",
                 (unsigned)(sequence + 1) % 2, (unsigned)sequence);
        TEST_ASSERT_EQUAL_STRING(text, sim.serial);
    }
}

static void test_after_a_reset_it_starts_warm_from_what_was_stored(void)
{
    rigcal_mounted_camera before[FIRMWARE_CAMERAS];
    unsigned cold, warm;
    const char *at = sim.serial;
    pose_line p;

    boot();
    shoot_both();
    run();
    TEST_ASSERT_TRUE(read_pose_line(&p, &at));
    cold = p.ticks;
    memcpy(before, app.cameras, sizeof before);
    boot();
    TEST_ASSERT_EQUAL_STRING("loaded slot=0 sequence=1\r\n", sim.serial);
    assert_same_cameras(before, app.cameras);
    (void)sim_shoot(0, ALL);
    run();
    at = sim.serial;
    TEST_ASSERT_TRUE(read_pose_line(&p, &at));
    warm = p.ticks;
    TEST_ASSERT_TRUE(worst_in_sigmas(&p) < 5);
    TEST_ASSERT_TRUE_MESSAGE(3 * warm < cold, sim.serial);
}

/* ---- the newer of two ---------------------------------------------------- */

static void write_slot(int slot, uint32_t sequence, uint32_t tag, size_t n,
                       const double center[FIRMWARE_CAMERAS][3])
{
    rigcal_mounted_camera cameras[3];
    size_t size;

    place(center);
    memset(cameras, 0, sizeof cameras);
    for (int i = 0; i < 3; i++) {
        cameras[i].camera = FIRMWARE_INTRINSICS[i % 2];
        cameras[i].cam_from_rig = test_transform(sim.R[i % 2], sim.t[i % 2]);
    }
    memset(sim.flash[slot], 0xff, PORT_SLOT_BYTES);
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_save(sim.flash[slot], PORT_SLOT_BYTES, &size,
                                               cameras, n, sequence, tag));
}

static void test_the_newer_slot_counts_even_when_its_number_wrapped(void)
{
    static const uint32_t PAIRS[][2] = {
        {1, 2},          {0, 1},          {UINT32_MAX - 1, UINT32_MAX},
        {UINT32_MAX, 0}, {UINT32_MAX, 1}, {0x7fffffff, 0x80000000}};

    for (size_t i = 0; i < sizeof PAIRS / sizeof PAIRS[0]; i++) {
        for (int newer = 0; newer < 2; newer++) {
            double t[3];

            write_slot(1 - newer, PAIRS[i][0], FIRMWARE_SERIAL, 2, HERE);
            write_slot(newer, PAIRS[i][1], FIRMWARE_SERIAL, 2, THERE);
            boot();
            TEST_ASSERT_EQUAL_INT32(newer, app.slot);
            TEST_ASSERT_EQUAL_UINT32(PAIRS[i][1], app.sequence);
            test_transform_parts(NULL, t, &app.cameras[1].cam_from_rig);
            for (int k = 0; k < 3; k++) {
                ASSERT_NEAR(sim.t[1][k], t[k], 1e-6);
            }
        }
    }
}

static void test_the_number_wraps_from_the_last_to_zero(void)
{
    write_slot(0, UINT32_MAX, FIRMWARE_SERIAL, 2, HERE);
    boot();
    assert_sent("loaded slot=0 sequence=4294967295\r\n");
    place(THERE);
    shoot_both();
    run();
    assert_sent("saved slot=1 sequence=0\r\n");
    boot();
    TEST_ASSERT_EQUAL_STRING("loaded slot=1 sequence=0\r\n", sim.serial);
}

static void test_the_calibration_of_another_machine_is_not_used(void)
{
    write_slot(0, 5, FIRMWARE_SERIAL + 1, 2, HERE);
    write_slot(1, 6, FIRMWARE_SERIAL, 1, HERE);
    boot();
    TEST_ASSERT_EQUAL_STRING("uncalibrated\r\n", sim.serial);
    if (rigcal_store_size(3) <= PORT_SLOT_BYTES) {
        write_slot(1, 7, FIRMWARE_SERIAL, 3, HERE);
        boot();
        TEST_ASSERT_EQUAL_STRING("uncalibrated\r\n", sim.serial);
    }
    write_slot(0, 4, FIRMWARE_SERIAL, 2, HERE);
    boot();
    TEST_ASSERT_EQUAL_STRING("loaded slot=0 sequence=4\r\n", sim.serial);
}

/* ---- damage -------------------------------------------------------------- */

/* Slot 0 holds 1, slot 1 holds 2. */
static void save_both_slots(void)
{
    calibrate();
    place(THERE);
    shoot_both();
    run();
    TEST_ASSERT_EQUAL_INT32(1, app.slot);
    TEST_ASSERT_EQUAL_UINT32(2, app.sequence);
}

static void test_any_bit_flipped_leaves_the_other_slot_in_use(void)
{
    save_both_slots();
    for (int slot = 0; slot < 2; slot++) {
        for (size_t bit = 0; bit < 8 * (size_t)PORT_SLOT_BYTES; bit++) {
            uint8_t *const byte = &sim.flash[slot][bit / 8];
            const int in_use = bit / 8 < SAVED_BYTES ? 1 - slot : 1;

            *byte ^= (uint8_t)(1u << bit % 8);
            boot();
            TEST_ASSERT_EQUAL_INT32(in_use, app.slot);
            TEST_ASSERT_EQUAL_UINT32(in_use + 1, app.sequence);
            *byte ^= (uint8_t)(1u << bit % 8);
        }
    }
}

static void test_with_both_slots_damaged_it_calibrates_anew(void)
{
    save_both_slots();
    sim.flash[0][100] ^= 4;
    sim.flash[1][200] ^= 8;
    boot();
    TEST_ASSERT_EQUAL_STRING("uncalibrated\r\n", sim.serial);
    shoot_both();
    run();
    assert_sent("saved slot=0 sequence=1\r\n");
    boot();
    TEST_ASSERT_EQUAL_STRING("loaded slot=0 sequence=1\r\n", sim.serial);
}

/* Cuts the power after `k` bytes of a saving. The firmware runs to the begin of that saving
 * once and is copied, because it must continue at the same place. */
static void cut_after(long k, sim_cut how, const sim_board *board, const firmware *ready)
{
    sim = *board;
    app = *ready;
    sim.random += (uint64_t)k;
    sim.cut = how;
    sim.cut_after = sim.worked + k;
    TEST_ASSERT_EQUAL_INT(k < WORK ? SIM_CUT : SIM_IDLE, sim_run(&app, TICKS));
    sim.cut_after = -1;
}

/* A board whose next tick erases a slot, and its firmware at that moment. */
static void come_to_erasing(sim_board *board, firmware *ready)
{
    const int erases = sim.erases;

    do {
        *board = sim;
        *ready = app;
        TEST_ASSERT_NOT_EQUAL(SIM_CUT, sim_run(&app, 1));
    } while (sim.erases == erases);
}

static sim_board board;
static firmware ready;

static void test_power_cut_after_any_byte_of_a_saving_leaves_one_calibration(void)
{
    for (int how = SIM_CUT_CLEAN; how <= SIM_CUT_SCATTERED; how++) {
        setUp();
        save_both_slots();
        place(HERE);
        shoot_both();
        come_to_erasing(&board, &ready);
        for (long k = 0; k <= WORK; k++) {
            cut_after(k, (sim_cut)how, &board, &ready);
            boot();
            /* The new calibration counts once its last byte is written; the rest of the
             * page is padding. Half of the last byte may happen to equal all of it. */
            if (memcmp(sim.flash[0], ready.image, SAVED_BYTES) == 0) {
                TEST_ASSERT_TRUE(k >= PORT_SLOT_BYTES + SAVED_BYTES - 1);
                TEST_ASSERT_EQUAL_STRING("loaded slot=0 sequence=3\r\n", sim.serial);
                assert_same_cameras(ready.cameras, app.cameras);
            } else {
                TEST_ASSERT_TRUE(k < PORT_SLOT_BYTES + SAVED_BYTES);
                TEST_ASSERT_EQUAL_STRING("loaded slot=1 sequence=2\r\n", sim.serial);
            }
            /* The firmware continues: the next saving succeeds. */
            if (k % 16 == 0) {
                place(app.slot == 0 ? THERE : HERE);
                shoot_both();
                run();
                assert_sent("saved ");
                TEST_ASSERT_EQUAL_INT(0, sim.misuse);
            }
        }
    }
}

static void test_power_cut_in_the_first_saving_leaves_a_new_board(void)
{
    for (int how = SIM_CUT_CLEAN; how <= SIM_CUT_SCATTERED; how++) {
        setUp();
        boot();
        shoot_both();
        come_to_erasing(&board, &ready);
        for (long k = 0; k <= WORK; k++) {
            cut_after(k, (sim_cut)how, &board, &ready);
            boot();
            TEST_ASSERT_EQUAL_STRING(memcmp(sim.flash[0], ready.image, SAVED_BYTES) == 0
                                         ? "loaded slot=0 sequence=1\r\n"
                                         : "uncalibrated\r\n",
                                     sim.serial);
        }
    }
}

static void test_power_cut_again_and_again_never_loses_the_calibration(void)
{
    save_both_slots();
    for (int trial = 0; trial < 300; trial++) {
        const uint32_t sequence = app.sequence;

        place(trial % 2 == 0 ? HERE : THERE);
        shoot_both();
        sim.cut = (sim_cut)(trial % 3);
        sim.cut_after = sim.worked + (long)(sim_uniform() * (WORK + 200));
        (void)sim_run(&app, TICKS);
        sim.cut_after = -1;
        sim.n_frames = 0;
        boot();
        assert_sent("loaded slot=");
        TEST_ASSERT_TRUE(app.sequence == sequence || app.sequence == sequence + 1);
    }
    TEST_ASSERT_TRUE(app.sequence > 10);
}

/* ---- flash that fails ---------------------------------------------------- */

static void test_a_flash_that_fails_is_told_and_tried_again(void)
{
    save_both_slots();
    place(HERE);
    sim.erase_fails = 1;
    shoot_both();
    shoot_both();
    run();
    assert_sent("failed slot=0 sequence=3\r\n");
    assert_sent("saved slot=0 sequence=3\r\n");

    place(THERE);
    sim.program_fails = 1;
    shoot_both();
    shoot_both();
    run();
    assert_sent("failed slot=1 sequence=4\r\n");
    assert_sent("saved slot=1 sequence=4\r\n");

    /* After a saving that succeeded, all tries are available again. */
    place(HERE);
    sim.erase_fails = FIRMWARE_SAVE_TRIES - 1;
    for (int i = 0; i < FIRMWARE_SAVE_TRIES; i++) {
        shoot_both();
    }
    run();
    TEST_ASSERT_EQUAL_INT(FIRMWARE_SAVE_TRIES - 1, times_sent("failed"));
    assert_sent("saved slot=0 sequence=5\r\n");
}

static void test_a_bit_that_cannot_be_programmed_is_seen(void)
{
    save_both_slots();
    place(HERE);
    sim.stuck_slot = 0;
    sim.stuck_at = 2; /* G: 0x47 */
    sim.stuck_mask = 0x80;
    for (int i = 0; i < 10; i++) {
        shoot_both();
        run();
        TEST_ASSERT_EQUAL_INT(0, times_sent("saved"));
    }
    /* Not for ever, because each try wears the flash. */
    TEST_ASSERT_EQUAL_INT(2 + FIRMWARE_SAVE_TRIES, sim.erases);
    boot();
    TEST_ASSERT_EQUAL_STRING("loaded slot=1 sequence=2\r\n", sim.serial);
}

/* ---- the watchdog -------------------------------------------------------- */

static void test_the_watchdog_is_fed_in_time_whatever_happens(void)
{
    save_both_slots();
    TEST_ASSERT_EQUAL_INT(SIM_COST_BOOT, sim.most_spent);
    sim.most_spent = 0;
    place(HERE);
    shoot_both();
    run();
    TEST_ASSERT_EQUAL_INT(SIM_COST_TICK + SIM_COST_ERASE, sim.most_spent);
}

static void test_a_watchdog_that_is_not_fed_in_time_bites(void)
{
    boot();
    shoot_both();
    sim.watchdog_units = FIRMWARE_EVALS_PER_TICK;
    TEST_ASSERT_EQUAL_INT(SIM_WATCHDOG, sim_run(&app, TICKS));
    sim.n_frames = 0;
    TEST_ASSERT_EQUAL_INT(SIM_WATCHDOG, sim_boot(&app));
    sim.watchdog_units = SIM_WATCHDOG_UNITS;
    boot();
    sim.watchdog_units = FIRMWARE_EVALS_PER_TICK + SIM_COST_TICK;
    shoot_both();
    TEST_ASSERT_EQUAL_INT(SIM_WATCHDOG, sim_run(&app, TICKS)); /* erasing */
}

/* ---- the rig ----------------------------------------------------------- */

static void hold_up(int first, int last)
{
    for (int f = first; f <= last; f++) {
        const double shift[3] = {0.05 * f - 0.1, 0.04 * (f % 2), 0.03 * f};

        sim_hold(f, 0.15 * f - 0.4, 0.2 * (f % 3) - 0.2, shift);
        shoot_both();
        TEST_ASSERT_EQUAL_INT(SIM_IDLE, sim_run(&app, TICKS));
    }
    sim.placement = 0;
}

/* The distance of camera 1 from its true place, seen from camera 0, in sigmas: only t. */
static double rig_in_sigmas(const rigcal_mounted_camera cameras[])
{
    double Rt[9], true_R[9], moved[3], worst = 0;
    rigcal_real Sigma[36];
    rigcal_transform pair;

    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_rig_pair(&pair, Sigma, &app.rig.rig, (rigcal_real)0.2, 0, 1));
    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_between(&pair, &cameras[1].cam_from_rig,
                                                      &cameras[0].cam_from_rig));
    test_transpose(Rt, sim.R[0]);
    test_product(true_R, sim.R[1], Rt);
    test_apply(moved, true_R, sim.t[0], NULL);
    for (int i = 0; i < 3; i++) {
        const double off = (double)pair.t[i] - (sim.t[1][i] - moved[i]);

        worst = fmax(worst, fabs(off) / sqrt((double)Sigma[7 * (i + 3)]));
    }
    return worst;
}

static void test_a_board_in_several_places_makes_a_rig_in_flash(void)
{
    rigcal_mounted_camera stored[FIRMWARE_CAMERAS];
    rigcal_saved_info info;

    calibrate();
    sim_clear_serial();
    sim_place(1, THERE[1], -1.4); /* what is in flash is wrong */
    hold_up(1, FIRMWARE_PLACEMENTS);
    assert_sent("rig t=");
    assert_sent("point at=");
    assert_sent("line camera=1 abc=");
    assert_sent("saved slot=1 sequence=2");
    TEST_ASSERT_TRUE(rig_in_sigmas(app.cameras) < 4);
    TEST_ASSERT_TRUE(app.rig.ticks > 5); /* in steps */
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_load(stored, FIRMWARE_CAMERAS, &info,
                                               sim.flash[1], PORT_SLOT_BYTES));
    assert_same_cameras(app.cameras, stored);
}

static void test_a_rig_of_which_a_view_is_missing_is_begun_anew(void)
{
    calibrate();
    sim_clear_serial();
    hold_up(1, 2);
    hold_up(4, FIRMWARE_PLACEMENTS); /* the third is left out */
    TEST_ASSERT_EQUAL_INT(0, times_sent("rig t="));
    hold_up(1, FIRMWARE_PLACEMENTS);
    TEST_ASSERT_EQUAL_INT(1, times_sent("rig t="));
}

/* ---- at work ------------------------------------------------------------- */

/* Runs the rig at work for n frames of both cameras. Camera 1 is off by a turn [rad], and
 * by a shift of half that number of metres. */
static void work(int n, double by)
{
    static const double BOARD[3] = {0, 0, 0.05};

    sim_clear_serial();
    sim.noise_px = 0.2;
    for (int i = 0; i < n; i++) {
        const double center[3] = {HERE[1][0], HERE[1][1] + by / 2, HERE[1][2]};

        sim_place(1, center, -1.4 + by);
        sim_hold(PORT_AT_WORK, 0.3, -0.2, BOARD);
        shoot_both();
        TEST_ASSERT_EQUAL_INT(SIM_IDLE, sim_run(&app, TICKS));
    }
    sim.placement = 0;
}

static void ask(void)
{
    sim_clear_serial();
    sim_type("how are you?\r\n");
    TEST_ASSERT_EQUAL_INT(SIM_IDLE, sim_run(&app, TICKS));
    TEST_ASSERT_EQUAL_INT(1, times_sent("\r\n"));
}

/* A rig in slot 1, with number 2, that has been at work for a while. */
static void work_in(void)
{
    calibrate();
    hold_up(1, FIRMWARE_PLACEMENTS);
    assert_sent("saved slot=1 sequence=2");
    work(30, 0);
}

/* Whether camera 1 has its true pose relative to camera 0. */
static void assert_mended(const rigcal_mounted_camera cameras[])
{
    double R[9], t[3], Rt[9], true_R[9], moved[3];
    rigcal_transform pair;

    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_between(&pair, &cameras[1].cam_from_rig,
                                                      &cameras[0].cam_from_rig));
    test_transform_parts(R, t, &pair);
    test_transpose(Rt, sim.R[0]);
    test_product(true_R, sim.R[1], Rt);
    test_apply(moved, true_R, sim.t[0], NULL);
    TEST_ASSERT_TRUE(test_angle_between(R, true_R) < 0.004);
    for (int i = 0; i < 3; i++) {
        ASSERT_NEAR(sim.t[1][i] - moved[i], t[i], 0.006);
    }
}

static void test_it_says_how_it_is(void)
{
    boot();
    ask();
    assert_sent("not watched");
    work_in();
    ask();
    assert_sent("well evidence=-");
    sim_clear_serial();
    sim_type("how are you\nhow are you??\nhow  are you?\n?\n\n");
    TEST_ASSERT_EQUAL_INT(SIM_IDLE, sim_run(&app, TICKS));
    TEST_ASSERT_EQUAL_STRING("", sim.serial);
}

static void test_a_rig_that_warms_up_is_followed_without_an_alarm(void)
{
    work_in();
    for (int i = 1; i <= 200; i++) {
        work(1, 1e-6 * i);
        TEST_ASSERT_EQUAL_STRING("", sim.serial);
    }
    ask();
    assert_sent("well evidence=-");
}

static void test_a_bump_is_told_named_mended_and_stored(void)
{
    rigcal_mounted_camera stored[FIRMWARE_CAMERAS];
    rigcal_saved_info info;

    work_in();
    work(20, 0.02);
    assert_sent("alarm frame=");
    TEST_ASSERT_EQUAL_INT(0, times_sent("saved")); /* not while it is in doubt */
    ask();
    assert_sent("alarm ");
    work(40, 0.02);
    assert_sent("moved camera=1 sure=");
    TEST_ASSERT_EQUAL_INT(1, times_sent("saved"));
    assert_sent("saved slot=0 sequence=3");
    ask();
    assert_sent("well evidence=-");
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_load(stored, FIRMWARE_CAMERAS, &info,
                                               sim.flash[0], PORT_SLOT_BYTES));
    TEST_ASSERT_EQUAL_INT32(FIRMWARE_CAMERAS - 1, info.n_free);
    assert_mended(stored);
    boot();
    assert_sent("loaded slot=0 sequence=3");
    work(30, 0.02); /* it is watched from this place on */
    TEST_ASSERT_EQUAL_STRING("", sim.serial);
}

static void test_power_cut_after_any_byte_of_what_was_mended_loses_nothing(void)
{
    enum {
        BYTES = RIGCAL_STORE_RIG_SIZE(FIRMWARE_CAMERAS, FIRMWARE_CAMERAS - 1),
        ALL_WORK = PORT_SLOT_BYTES +
                   (BYTES + PORT_PAGE_BYTES - 1) / PORT_PAGE_BYTES * PORT_PAGE_BYTES
    };

    work_in();
    do {
        board = sim;
        ready = app;
        work(1, 0.02);
    } while (times_sent("saved") == 0);
    sim = board;
    app = ready;
    sim_hold(PORT_AT_WORK, 0.3, -0.2, (const double[3]){0, 0, 0.05});
    shoot_both();
    come_to_erasing(&board, &ready);
    for (long k = 0; k < ALL_WORK; k++) {
        sim = board;
        app = ready;
        sim.cut = (sim_cut)(k % 3);
        sim.random += (uint64_t)k;
        sim.cut_after = sim.worked + k;
        TEST_ASSERT_EQUAL_INT(SIM_CUT, sim_run(&app, TICKS));
        sim.cut_after = -1;
        boot();
        if (memcmp(sim.flash[0], ready.image, BYTES) == 0) {
            TEST_ASSERT_TRUE(k >= PORT_SLOT_BYTES + BYTES - 1);
            TEST_ASSERT_EQUAL_STRING("loaded slot=0 sequence=3\r\n", sim.serial);
            assert_mended(app.cameras);
        } else {
            TEST_ASSERT_EQUAL_STRING("loaded slot=1 sequence=2\r\n", sim.serial);
        }
        TEST_ASSERT_TRUE(app.watch.rig.sigma_px > 0); /* it can be watched */
    }
}

static void test_the_rig_of_another_machine_is_not_watched(void)
{
    size_t size;

    work_in();
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_save_rig(sim.flash[1], PORT_SLOT_BYTES, &size,
                                                   &app.watch.rig, 9, FIRMWARE_SERIAL + 1));
    sim.flash[0][0] ^= 1;
    boot();
    TEST_ASSERT_EQUAL_STRING("uncalibrated\r\n", sim.serial);
    work(1, 0);
    ask();
    assert_sent("not watched");
}

TEST_MAIN_WITH_SETUP()
{
    RUN_TEST(test_a_new_board_says_that_it_is_uncalibrated);
    RUN_TEST(test_a_pose_is_reported_within_its_uncertainty);
    RUN_TEST(test_the_numbers_sent_are_the_pose_to_half_a_millionth);
    RUN_TEST(test_a_position_out_of_range_is_sent_as_the_range_s_end);
    RUN_TEST(test_too_few_corners_make_no_pose_and_harm_nothing);
    RUN_TEST(test_a_camera_that_drops_detections_gives_poses_from_the_rest);
    RUN_TEST(test_detections_that_cannot_be_are_left_out);
    RUN_TEST(test_a_pose_that_fits_badly_is_told_but_not_kept);
    RUN_TEST(test_a_calibration_is_saved_once_every_camera_has_a_pose);
    RUN_TEST(test_cameras_that_stay_where_they_are_wear_no_flash);
    RUN_TEST(test_a_camera_that_only_turned_or_only_moved_is_saved);
    RUN_TEST(test_savings_take_turns_between_the_slots);
    RUN_TEST(test_after_a_reset_it_starts_warm_from_what_was_stored);
    RUN_TEST(test_the_newer_slot_counts_even_when_its_number_wrapped);
    RUN_TEST(test_the_number_wraps_from_the_last_to_zero);
    RUN_TEST(test_the_calibration_of_another_machine_is_not_used);
    RUN_TEST(test_any_bit_flipped_leaves_the_other_slot_in_use);
    RUN_TEST(test_with_both_slots_damaged_it_calibrates_anew);
    RUN_TEST(test_power_cut_after_any_byte_of_a_saving_leaves_one_calibration);
    RUN_TEST(test_power_cut_in_the_first_saving_leaves_a_new_board);
    RUN_TEST(test_power_cut_again_and_again_never_loses_the_calibration);
    RUN_TEST(test_a_flash_that_fails_is_told_and_tried_again);
    RUN_TEST(test_a_bit_that_cannot_be_programmed_is_seen);
    RUN_TEST(test_a_board_in_several_places_makes_a_rig_in_flash);
    RUN_TEST(test_a_rig_of_which_a_view_is_missing_is_begun_anew);
    RUN_TEST(test_it_says_how_it_is);
    RUN_TEST(test_a_rig_that_warms_up_is_followed_without_an_alarm);
    RUN_TEST(test_a_bump_is_told_named_mended_and_stored);
    RUN_TEST(test_power_cut_after_any_byte_of_what_was_mended_loses_nothing);
    RUN_TEST(test_the_rig_of_another_machine_is_not_watched);
    RUN_TEST(test_the_watchdog_is_fed_in_time_whatever_happens);
    RUN_TEST(test_a_watchdog_that_is_not_fed_in_time_bites);
}
