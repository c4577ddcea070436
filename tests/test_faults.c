/* faults: why the views of a rig disagree. The truth: tests/vectors, where one dense system
 * of all unknowns is solved, its derivatives by complex steps; and adjustments with the
 * fault free. */
#include <math.h>
#include <string.h>

#include "rc_columns.h"
#include "rc_evidence.h"
#include "rigcal_solvers.h"
#include "test_fit.h"
#include "test_motions.h"
#include "vectors_faults.h"

/* One camera more than the vectors have: a camera that moved, at its pose afterwards. */
enum {
    CAMERAS = 3,
    MORE = CAMERAS + 1,
    PLACEMENTS = 6,
    VIEWS = CAMERAS * PLACEMENTS,
    POINTS = 9,
    FAULTS = 40
};

/* A rig of the vectors, and the faults that are found. */
typedef struct {
    rigcal_camera camera[CAMERAS];
    rigcal_observation o[VIEWS][POINTS];
    rigcal_rig_view views[VIEWS];
    rigcal_transform cams[MORE], places[PLACEMENTS];
    rigcal_real times[PLACEMENTS], instants[PLACEMENTS], offsets[MORE];
    rigcal_real drifts[MORE];
    uint8_t held[MORE];
    int32_t states[MORE], group[MORE];
    rigcal_real
        work[RIGCAL_RIG_WORK(MORE, MORE, PLACEMENTS) + RIGCAL_CLOCKS_WORK(MORE, MORE)];
    rigcal_real
        room[RIGCAL_FAULTS_WORK(CAMERAS, CAMERAS) + RIGCAL_FAULTS_CLOCKS_WORK(CAMERAS)],
        clocks[2 * CAMERAS];
    rigcal_rig_clocks with_clocks;
    rigcal_rig rig;
    rigcal_faults_options options;
    rigcal_faults found;
    rigcal_fault faults[FAULTS];
} fixture;

static fixture x;

#define WANTS_A_RIG TEST_WANTS_RAM(sizeof(fixture) + 20000)

static void set_camera(rigcal_camera *camera, int c)
{
    memset(camera, 0, sizeof *camera);
    camera->width = 1280;
    camera->height = 960;
    camera->fx = RC(800 + 10 * c);
    camera->fy = RC(805);
    camera->cx = RC(640 - 3 * c);
    camera->cy = RC(480);
    camera->k1 = RC(-0.1 + 0.02 * c);
    camera->k2 = RC(0.03);
}

static void set_view(fixture *f, int scene, int v)
{
    const double *const uv = &FAULTS_PIXELS[scene][2 * POINTS * v];

    for (int i = 0; i < POINTS; i++) {
        f->o[v][i].X_w[0] = RC(0.11 * (i % 3) - 0.11);
        f->o[v][i].X_w[1] = RC(0.09 * (i / 3) - 0.09);
        f->o[v][i].X_w[2] = 0;
        test_to_real(f->o[v][i].uv, &uv[2 * i], 2);
    }
    f->views[v].view = VIEW(&f->camera[v % CAMERAS], f->o[v], NULL, POINTS);
    f->views[v].camera = v % CAMERAS;
    f->views[v].placement = v / CAMERAS;
    f->views[v].target = 0;
}

/* A scene at its optimum, adjusted. */
static void set_up(fixture *f, int scene)
{
    const double *pose = FAULTS_POSES[scene];
    rigcal_rig_fit fit;
    int32_t at_fault;

    memset(f, 0, sizeof *f);
    for (size_t i = 0; i < sizeof f->work / sizeof *f->work; i++) {
        f->work[i] = TEST_NAN; /* what is not written is not read */
    }
    for (size_t i = 0; i < sizeof f->room / sizeof *f->room; i++) {
        f->room[i] = TEST_NAN;
    }
    for (int c = 0; c < CAMERAS; c++, pose += 12) {
        set_camera(&f->camera[c], c);
        f->cams[c] = test_transform(pose, pose + 9);
    }
    for (int p = 0; p < PLACEMENTS; p++, pose += 12) {
        f->places[p] = test_transform(pose, pose + 9);
        f->times[p] = RC(10 * (p / 3) + (p % 3 - 1) / 30.);
    }
    for (int v = 0; v < VIEWS; v++) {
        set_view(f, scene, v);
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_defaults(&f->with_clocks));
    f->with_clocks.times = f->times;
    f->with_clocks.instants = f->instants;
    f->with_clocks.offsets = f->offsets;
    f->with_clocks.states = f->states;
    f->rig.cams_from_rig = f->cams;
    f->rig.n_cameras = CAMERAS;
    f->rig.rig_from_placements = f->places;
    f->rig.n_placements = PLACEMENTS;
    f->rig.group = f->group;
    f->rig.n_views = VIEWS;
    f->rig.views = f->views;
    f->rig.clocks = &f->with_clocks;
    f->rig.work = f->work;
    f->rig.work_capacity = sizeof f->work / sizeof *f->work;
    f->options.work = f->room;
    f->options.work_capacity = sizeof f->room / sizeof *f->room;
    f->options.clocks = f->clocks;
    for (int k = 0; k < 3; k++) { /* to the last digits */
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, &at_fault, &f->rig));
    }
}

static void test_it(fixture *f)
{
    int32_t at_fault = -2;

    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_faults(&f->found, f->faults, FAULTS, &at_fault,
                                               &f->options, &f->rig));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
}

static const rigcal_fault *fault_of(const fixture *f, double kind, double camera)
{
    for (int i = 0; i < f->found.n; i++) {
        if (f->faults[i].kind == (int)kind && f->faults[i].camera == (int)camera) {
            return &f->faults[i];
        }
    }
    TEST_FAIL_MESSAGE("this fault was not tested");
    return NULL;
}

/* ---- against dense least squares ------------------------------------------------ */

/* The six parameters of a camera that moved are correlated, so float loses digits. */
static double loss_of(const rigcal_fault *seen)
{
    return (seen->kind == RIGCAL_FAULT_MOVED) ? TOL(1, 100) : 1;
}

/* The adjustment of a float build ends where its own rounding stops it. The truth is then
 * 1e-6 sigma from the optimum. */
static void assert_fault(const double row[], const rigcal_fault *seen)
{
    const double *const theta = &row[4], *const sigma = &row[10];
    const double part = TOL(1e-6, 5e-3), of_sigma = TOL(1e-6, 5e-3), gain = row[16];
    const double noise2 = D(x.found.sigma_px) * D(x.found.sigma_px);
    const double loss = loss_of(seen);

    TEST_ASSERT_EQUAL_INT32(1, seen->is_seen);
    for (int i = 0; i < seen->n; i++) {
        ASSERT_NEAR(theta[i], seen->value[i], loss * of_sigma * sigma[i]);
        ASSERT_NEAR(sigma[i], seen->sigma[i], loss * part * sigma[i]);
    }
    ASSERT_NEAR(gain, seen->gain, loss * part * (gain + 2 * sqrt(gain * noise2) + noise2));
    ASSERT_NEAR(row[17], seen->F_after, loss * part * (1 + row[17]));
    ASSERT_NEAR(row[18], seen->p, loss * 10 * part);
    ASSERT_NEAR(row[19], seen->turn, loss * part * row[19]);
    ASSERT_NEAR(row[20], seen->shift, loss * part * row[20]);
}

static void test_each_fault_is_that_of_dense_least_squares(void)
{
    int scene = -1;
    uint8_t breaks[PLACEMENTS] = {0, 0, 0, 1, 0, 0};

    WANTS_A_RIG;
    for (int i = 0; i < FAULTS_TESTS_ROWS; i++) {
        const double *const row = FAULTS_TESTS[i];

        if ((int)row[0] != scene) {
            scene = (int)row[0];
            set_up(&x, scene);
            x.options.breaks = breaks;
            test_it(&x);
        }
        const rigcal_fault *const seen = fault_of(&x, row[1], row[2]);

        TEST_ASSERT_EQUAL_INT32((int32_t)row[3], seen->placement);
        assert_fault(row, seen);
    }
}

static void test_what_the_views_have_in_common_is_that_of_dense_least_squares(void)
{
    WANTS_A_RIG;
    for (int scene = 0; scene < FAULTS_WHOLE_ROWS; scene++) {
        const double *const row = FAULTS_WHOLE[scene];

        set_up(&x, scene);
        test_it(&x);
        ASSERT_NEAR(row[1], x.found.F, TOL(1e-6, 1e-3) * (1 + row[1]));
        ASSERT_NEAR(row[2], x.found.along, TOL(1e-6, 1e-3));
        ASSERT_NEAR(row[3], x.found.pattern, TOL(1e-6, 1e-3));
        TEST_ASSERT_TRUE(D(x.found.pattern_sigma) * sqrt(row[4]) < 1);
        TEST_ASSERT_TRUE(D(x.found.pattern_sigma) * sqrt(row[4]) > 0.6);
    }
}

/* Compares one step with an adjustment in which the fault is an unknown. */
static void test_a_fault_is_named_and_is_that_of_an_adjustment_with_it(void)
{
    WANTS_A_RIG;
    for (int i = 0; i < FAULTS_REFITS_ROWS; i++) {
        const double *const row = FAULTS_REFITS[i];

        set_up(&x, (int)row[0]);
        test_it(&x);
        const rigcal_fault *const seen = fault_of(&x, row[1], row[2]);

        TEST_ASSERT_TRUE((x.found.bits & RIGCAL_FAULTS_NAMED) != 0);
        TEST_ASSERT_TRUE(D(seen->bic) < D(x.faults[0].bic) + 9.2);
        for (int k = 0; k < seen->n; k++) {
            ASSERT_NEAR(row[3 + k], seen->value[k], 0.15 * D(seen->sigma[k]));
        }
        ASSERT_NEAR(row[9], seen->gain, 0.01 * row[9]);
    }
}

static void test_the_clocks_are_told_one_by_one(void)
{
    WANTS_A_RIG;
    set_up(&x, 2);
    for (int c = 0; c < 2 * CAMERAS; c++) {
        x.clocks[c] = TEST_NAN;
    }
    test_it(&x);
    const rigcal_fault *const all = fault_of(&x, RIGCAL_FAULT_CLOCKS, -1);

    ASSERT_NEAR(0, x.clocks[0], 0);
    ASSERT_NEAR(0, x.clocks[CAMERAS], 0);
    for (int c = 1; c < CAMERAS; c++) {
        ASSERT_NEAR(all->value[c - 1], x.clocks[c], 0);
        ASSERT_NEAR(all->sigma[c - 1], x.clocks[CAMERAS + c], 1e-6 * D(all->sigma[c - 1]));
    }
}

/* ---- against adjustments: clocks that are free, stamps with noise (H11) ------------ */

/* The least sum of squares. */
static double least_sum(fixture *f)
{
    rigcal_rig_fit fit;

    for (int k = 0; k < 4; k++) {
        TEST_ASSERT_TRUE(rigcal_rig_adjust(&fit, NULL, &f->rig) >= 0);
    }
    return D(fit.sum);
}

/* Changes the camera, clock or board to what it would be with a fault of this size. */
static void correct(fixture *f, int kind, int c, const rigcal_real theta[])
{
    rigcal_camera *const camera = &f->camera[c];

    switch (kind) {
    case RIGCAL_FAULT_CLOCK:
        f->offsets[c] += theta[0];
        break;
    case RIGCAL_FAULT_DRIFT:
        f->drifts[c] += theta[0];
        break;
    case RIGCAL_FAULT_FOCAL:
        camera->fx *= 1 + theta[0];
        camera->fy *= 1 + theta[0];
        break;
    case RIGCAL_FAULT_ASPECT:
        camera->fx *= 1 + theta[0] / 2;
        camera->fy *= 1 - theta[0] / 2;
        break;
    case RIGCAL_FAULT_CENTRE:
        camera->cx += theta[0];
        camera->cy += theta[1];
        break;
    case RIGCAL_FAULT_DISTORTION:
        camera->k1 += theta[0];
        camera->k2 += theta[1];
        break;
    default: /* STRETCHED */
        for (int v = 0; v < VIEWS; v++) {
            for (int i = 0; i < POINTS; i++) {
                f->o[v][i].X_w[0] *= 1 + theta[0] / 2;
                f->o[v][i].X_w[1] *= 1 - theta[0] / 2;
            }
        }
        break;
    }
}

/* Sets the clocks of the adjustment: free or not, with noise of stamps or not. */
static void set_clocks(fixture *f, int free_offsets, int free_drifts, double sigma_time)
{
    f->with_clocks.free_offsets = free_offsets;
    f->with_clocks.free_drifts = free_drifts;
    f->with_clocks.drifts = f->drifts;
    f->with_clocks.sigma_time = (rigcal_real)sigma_time;
    f->rig.sigma_px = RC(0.3);
}

/* The sum falls by the gain. One sigma further it rises by the variance. */
static void assert_as_adjusted(int kind, int free_offsets, int free_drifts,
                               double sigma_time)
{
    rigcal_real further[RIGCAL_FAULT_VALUES] = {0};

    set_up(&x, 3);
    set_clocks(&x, free_offsets, free_drifts, sigma_time);
    const double before = least_sum(&x);
    test_it(&x);
    const rigcal_fault seen =
        *fault_of(&x, kind, (kind == RIGCAL_FAULT_STRETCHED) ? -1 : 1);

    TEST_ASSERT_EQUAL_INT32(1, seen.is_seen);
    correct(&x, kind, 1, seen.value);
    const double after = least_sum(&x);
    const double freedom = D(x.found.freedom_between) + D(x.found.freedom_within);
    const double noise2 = after / (freedom - seen.n);

    /* Two parameters of a camera are not quite linear. */
    ASSERT_NEAR(before - after, seen.gain,
                0.02 * seen.n * D(seen.gain) + TOL(1e-3, 1e-2) * noise2);
    if (seen.n == 1) { /* of two cameras, the other one follows */
        further[0] = seen.sigma[0];
        correct(&x, kind, 1, further);
        ASSERT_NEAR(noise2, least_sum(&x) - after, 0.08 * noise2);
    }
}

static void test_faults_are_those_of_adjustments_with_free_clocks_and_noisy_stamps(void)
{
    static const int KINDS[] = {RIGCAL_FAULT_CLOCK,    RIGCAL_FAULT_DRIFT,
                                RIGCAL_FAULT_FOCAL,    RIGCAL_FAULT_ASPECT,
                                RIGCAL_FAULT_CENTRE,   RIGCAL_FAULT_DISTORTION,
                                RIGCAL_FAULT_STRETCHED};

    WANTS_A_RIG;
    for (size_t i = 0; i < sizeof KINDS / sizeof *KINDS; i++) {
        assert_as_adjusted(KINDS[i], 0, 0, 0.001);
        if (KINDS[i] != RIGCAL_FAULT_CLOCK) {
            assert_as_adjusted(KINDS[i], 1, 0, 0);
            assert_as_adjusted(KINDS[i], 1, 0, 0.001);
        }
        if (KINDS[i] > RIGCAL_FAULT_DRIFT) {
            assert_as_adjusted(KINDS[i], 1, 1, 0.001);
        }
    }
}

/* The views after the move belong to a camera of their own. */
static void assert_moved(int c, int free_drifts)
{
    static const uint8_t breaks[PLACEMENTS] = {0, 0, 0, 1, 0, 0};

    set_up(&x, 5);
    set_clocks(&x, 1, free_drifts, 0.001);
    for (int k = 0; k < MORE; k++) {
        x.held[k] = (uint8_t)(free_drifts ? k != ((c == 1) ? 2 : 1) : k == 0);
    }
    x.with_clocks.held = x.held;
    x.options.breaks = breaks;
    const double before = least_sum(&x);
    test_it(&x);
    const rigcal_fault seen = *fault_of(&x, RIGCAL_FAULT_MOVED, c);

    TEST_ASSERT_EQUAL_INT32(1, seen.is_seen);
    x.rig.n_cameras = MORE;
    x.cams[CAMERAS] = x.cams[c];
    x.offsets[CAMERAS] = x.offsets[c];
    x.drifts[CAMERAS] = x.drifts[c];
    for (int k = 0; k < MORE && !free_drifts;
         k++) { /* one clock, which the free ones are relative to */
        x.held[k] = (uint8_t)(k == c || k == CAMERAS);
    }
    for (int v = 0; v < VIEWS; v++) {
        if (x.views[v].camera == c && x.views[v].placement >= seen.placement) {
            x.views[v].camera = CAMERAS;
        }
    }
    ASSERT_NEAR(before - least_sum(&x), seen.gain, TOL(0.02, 0.08) * D(seen.gain));
}

static void test_a_camera_that_moved_is_another_one_with_free_clocks(void)
{
    WANTS_A_RIG;
    for (int c = 0; c < CAMERAS; c++) {
        assert_moved(c, 0);
        assert_moved(c, 1);
    }
}

static void test_clocks_that_are_free_are_not_found(void)
{
    static rigcal_fault faults[FAULTS];
    rigcal_faults found;

    WANTS_A_RIG;
    set_up(&x, 2);
    set_clocks(&x, 1, 1, 0.001);
    (void)least_sum(&x);
    test_it(&x);
    for (int c = 0; c < CAMERAS; c++) {
        TEST_ASSERT_EQUAL_INT32(0, fault_of(&x, RIGCAL_FAULT_CLOCK, c)->is_seen);
        TEST_ASSERT_EQUAL_INT32(0, fault_of(&x, RIGCAL_FAULT_DRIFT, c)->is_seen);
    }
    x.options.work_capacity =
        RIGCAL_FAULTS_LEAST(CAMERAS, CAMERAS) + RIGCAL_FAULTS_CLOCKS_WORK(CAMERAS);
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_rig_faults(&found, faults, FAULTS, NULL, &x.options, &x.rig));
    for (int i = 0; i < found.n; i++) {
        const rigcal_fault *const other = fault_of(&x, faults[i].kind, faults[i].camera);

        ASSERT_NEAR(other->gain, faults[i].gain, TOL(1e-9, 1e-3) * (1 + D(other->gain)));
    }
}

/* A rig of four cameras, and the stated memory for it, with some more behind. */
enum { ROOM = RIGCAL_FAULTS_WORK(3, 4) + RIGCAL_FAULTS_CLOCKS_WORK(4) };
static test_motions m;
static rigcal_real room[ROOM + 8];

/* Four cameras whose offsets and drifts are free, in memory of the stated size. What lies
 * behind it is not read, and two passes are enough. */
static void test_four_free_clocks_need_the_stated_memory(void)
{
    static const motion_scene SCENE = {4, 2, 4, 30, 0.35, 0.8, 10, 0.01, 3e-4, 0, 0.3};
    test_rng rng = test_seed(75);
    rigcal_faults_options options = {.work = room, .work_capacity = ROOM};
    rigcal_rig_fit fit;

    TEST_WANTS_RAM(sizeof m + sizeof room + 20000);
    test_motions_make(&m, &rng, &SCENE);
    test_motions_solve(&m);
    m.clocks.drifts = m.drifts;
    m.clocks.free_drifts = 1;
    m.rig.clocks = &m.clocks;
    m.rig.work_capacity = rigcal_rig_work(3, 4, 8) + rigcal_clocks_work(3, 4);
    for (size_t i = 0; i < MOTION_WORK; i++) {
        m.work[i] = TEST_NAN;
    }
    for (size_t i = 0; i < ROOM + 8; i++) {
        room[i] = TEST_NAN;
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &m.rig));
    x.options = options;
    x.rig = m.rig;
    test_it(&x);
    TEST_ASSERT_TRUE(x.found.passes <= 2);
    TEST_ASSERT_TRUE(D(x.found.F) > 0.3 && D(x.found.F) < 3);
    for (int i = 0; i < x.found.n; i++) {
        const int kind = x.faults[i].kind;
        const int is_clock = kind == RIGCAL_FAULT_CLOCK || kind == RIGCAL_FAULT_CLOCKS ||
                             kind == RIGCAL_FAULT_DRIFT;

        TEST_ASSERT_EQUAL_INT32(!is_clock, x.faults[i].is_seen);
        TEST_ASSERT_TRUE(D(x.faults[i].gain) >= 0 && D(x.faults[i].gain) < 20);
    }
    for (size_t i = ROOM; i < ROOM + 8; i++) {
        TEST_ASSERT_TRUE(isnan(D(room[i])));
    }
}

/* The least memory in which a rig of four free clocks is tested for cameras that moved. */
static size_t room_to_move(size_t most)
{
    size_t low = 0;

    while (low < most) {
        const size_t middle = (low + most) / 2;

        x.options.work_capacity = middle;
        if (rigcal_rig_faults(&x.found, x.faults, FAULTS, NULL, &x.options, &x.rig) < 0) {
            low = middle + 1;
        } else {
            most = middle;
        }
    }
    return most;
}

/* If clocks are free, the test for cameras that moved needs all pairs of cameras for each
 * unknown of a clock. It asks for this memory: in the least, the result is the same, and
 * the covariance of the rig and what lies behind stay. */
static void test_cameras_that_moved_are_tested_within_the_least_memory(void)
{
    static const motion_scene SCENE = {4, 2, 4, 30, 0.35, 0.8, 10, 0.01, 3e-4, 0, 0.3};
    rigcal_fault faults[4];
    test_rng rng = test_seed(75);
    rigcal_real before[36], after[36];
    rigcal_rig_fit fit;

    TEST_WANTS_RAM(sizeof m + sizeof room + 20000);
    test_motions_make(&m, &rng, &SCENE);
    test_motions_solve(&m);
    m.clocks.drifts = m.drifts;
    m.clocks.free_drifts = 1;
    m.rig.clocks = &m.clocks;
    m.rig.work_capacity = rigcal_rig_work(3, 4, 8) + rigcal_clocks_work(3, 4);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &m.rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(before, &m.rig, 1, 2));
    memset(&x, 0, sizeof x);
    x.options.work = room;
    x.options.work_capacity = ROOM;
    x.options.kinds = RIGCAL_FAULTS_OF(RIGCAL_FAULT_MOVED);
    x.rig = m.rig;
    test_it(&x);
    const int n = x.found.n;
    TEST_ASSERT_TRUE(n > 0 && n <= 4);
    memcpy(faults, x.faults, sizeof faults);
    const size_t least = room_to_move(ROOM);
    for (size_t i = 0; i < ROOM; i++) {
        room[i] = TEST_NAN;
    }
    x.options.work_capacity = least;
    test_it(&x);
    TEST_ASSERT_EQUAL_INT(n, x.found.n);
    for (int i = 0; i < n; i++) {
        const rigcal_fault *const same = fault_of(&x, faults[i].kind, faults[i].camera);

        ASSERT_NEAR(faults[i].gain, same->gain, TOL(1e-9, 1e-3) * (1 + D(same->gain)));
    }
    for (size_t i = least; i < ROOM; i++) {
        TEST_ASSERT_TRUE(isnan(D(room[i])));
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(after, &m.rig, 1, 2));
    TEST_ASSERT_EQUAL_MEMORY(before, after, sizeof before);
}

/* A moving rig whose clocks differ, and are held at 0. Views may be left out. */
static void make_late(test_rng *rng, const motion_scene *scene)
{
    test_motions_make(&m, rng, scene);
    test_motions_solve(&m);
    m.clocks.free_offsets = 0;
    m.rig.clocks = &m.clocks;
    m.rig.left_out = m.left_out;
}

/* The test for clocks of the rig as it was adjusted finds those of the two cameras after
 * `first`, and how much later they are than that of `first`. */
static void assert_clocks_seen(int first)
{
    memset(&x, 0, sizeof x);
    x.options.work = x.work;
    x.options.work_capacity = sizeof x.work / sizeof *x.work;
    x.options.kinds = RIGCAL_FAULTS_OF(RIGCAL_FAULT_CLOCKS);
    x.rig = m.rig;
    TEST_ASSERT_TRUE(
        rigcal_rig_faults(&x.found, x.faults, FAULTS, NULL, &x.options, &x.rig) >= 0);
    const rigcal_fault *const all = fault_of(&x, RIGCAL_FAULT_CLOCKS, -1);

    TEST_ASSERT_EQUAL_INT32(2, all->n);
    TEST_ASSERT_EQUAL_INT32(1, all->is_seen);
    for (int i = 0; i < 2; i++) {
        ASSERT_NEAR(m.true_offsets[first + 1 + i] - m.true_offsets[first], all->value[i],
                    5 * D(all->sigma[i]));
    }
}

/* Camera 0 shares no placement with the three others, which are a group of their own. The
 * clock of its first camera is no parameter: the others are late by it. */
static void test_the_first_clock_of_each_group_is_not_told(void)
{
    static const motion_scene SCENE = {4, 4, 4, 30, 0.35, 0.8, 10, 0.01, 0, 0, 0.3};
    test_rng rng = test_seed(77);
    rigcal_rig_fit fit;

    TEST_WANTS_RAM(sizeof m + sizeof x + 20000);
    make_late(&rng, &SCENE);
    for (size_t v = 0; v < m.rig.n_views; v++) {
        m.left_out[v] = (m.views[v].camera == 0) != (m.views[v].placement < 4);
    }
    ASSERT_STATUS(RIGCAL_DISCONNECTED, rigcal_rig_adjust(&fit, NULL, &m.rig));
    assert_clocks_seen(1);
}

/* Camera 3 has seen only a placement whose time is not known, so nothing shows its clock.
 * Those of the others are found all the same. */
static void test_a_clock_that_nothing_shows_is_no_unknown(void)
{
    static const motion_scene SCENE = {4, 2, 4, 30, 0.35, 0.8, 10, 0.01, 3e-4, 0, 0.3};
    test_rng rng = test_seed(78);
    rigcal_rig_fit fit;

    TEST_WANTS_RAM(sizeof m + sizeof x + 20000);
    make_late(&rng, &SCENE);
    m.times[7] = TEST_NAN;
    for (size_t v = 0; v < m.rig.n_views; v++) {
        m.left_out[v] = m.views[v].camera == 3 && m.views[v].placement != 7;
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &m.rig));
    assert_clocks_seen(0);
}

/* ---- the unit of the pixels ------------------------------------------------------- */

/* Makes each image 64 times smaller, about its corner: -0.5, -0.5. */
static rigcal_real smaller(rigcal_real uv)
{
    return (uv + RC(0.5)) / 64 - RC(0.5);
}

static void shrink(fixture *f)
{
    for (int c = 0; c < CAMERAS; c++) {
        rigcal_camera *const camera = &f->camera[c];

        camera->width /= 64;
        camera->height /= 64;
        camera->fx /= 64;
        camera->fy /= 64;
        camera->cx = smaller(camera->cx);
        camera->cy = smaller(camera->cy);
    }
    for (int v = 0; v < VIEWS; v++) {
        for (int i = 0; i < POINTS; i++) {
            f->o[v][i].uv[0] = smaller(f->o[v][i].uv[0]);
            f->o[v][i].uv[1] = smaller(f->o[v][i].uv[1]);
        }
    }
}

/* The noise of small images is small too, down to a sum of squares below 1. */
static void test_small_images_have_the_faults_of_large_ones(void)
{
    static rigcal_fault faults[FAULTS];

    WANTS_A_RIG;
    for (int scene = 0; scene < FAULTS_WHOLE_ROWS; scene++) {
        set_up(&x, scene);
        test_it(&x);
        const rigcal_faults found = x.found;
        memcpy(faults, x.faults, sizeof faults);
        shrink(&x);
        TEST_ASSERT_TRUE(least_sum(&x) < 1);
        test_it(&x);
        TEST_ASSERT_EQUAL_INT32(found.bits, x.found.bits);
        TEST_ASSERT_EQUAL_INT32(found.n, x.found.n);
        ASSERT_NEAR(D(found.sigma_px) / 64, x.found.sigma_px,
                    TOL(1e-8, 1e-3) * D(found.sigma_px));
        ASSERT_NEAR(D(found.own_px) / 64, x.found.own_px,
                    TOL(1e-8, 1e-3) * D(found.own_px));
        ASSERT_NEAR(found.F, x.found.F, TOL(1e-6, 1e-2) * D(found.F));
        for (int i = 0; i < found.n; i++) {
            const rigcal_fault *const seen = fault_of(&x, faults[i].kind, faults[i].camera);
            const double loss = loss_of(seen);

            TEST_ASSERT_EQUAL_INT32(faults[i].is_seen, seen->is_seen);
            ASSERT_NEAR(faults[i].p, seen->p, loss * TOL(1e-5, 0.05));
            ASSERT_NEAR(faults[i].F_after, seen->F_after,
                        loss * TOL(1e-5, 0.05) * D(found.F));
        }
    }
}

/* ---- what cannot be seen ---------------------------------------------------------- */

static void test_without_times_no_clock_is_tested_and_that_is_told(void)
{
    WANTS_A_RIG;
    set_up(&x, 1);
    x.rig.clocks = NULL;
    test_it(&x);
    TEST_ASSERT_TRUE((x.found.bits & RIGCAL_FAULTS_NO_TIMES) != 0);
    TEST_ASSERT_EQUAL_INT(0, x.found.bits & RIGCAL_FAULTS_TWO_CAMERAS);
    ASSERT_NEAR(0, x.found.frame, 0);
    for (int c = 0; c < CAMERAS; c++) {
        TEST_ASSERT_EQUAL_INT32(0, fault_of(&x, RIGCAL_FAULT_CLOCK, c)->is_seen);
        TEST_ASSERT_EQUAL_INT32(0, fault_of(&x, RIGCAL_FAULT_SHUTTER, c)->is_seen);
    }
}

/* Tests a rig whose placements are 10 s apart. */
static void test_without_neighbours(void)
{
    rigcal_rig_fit fit;

    set_up(&x, 1);
    for (int p = 0; p < PLACEMENTS; p++) {
        x.times[p] = RC(10 * p);
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &x.rig));
    test_it(&x);
}

static void test_placements_far_apart_in_time_have_no_motion(void)
{
    WANTS_A_RIG;
    test_without_neighbours();
    TEST_ASSERT_TRUE((x.found.bits & RIGCAL_FAULTS_NO_NEIGHBOUR) != 0);
    TEST_ASSERT_EQUAL_INT32(0, fault_of(&x, RIGCAL_FAULT_CLOCK, 1)->is_seen);
}

static void test_a_camera_without_views_has_no_faults(void)
{
    static uint8_t left_out[VIEWS];
    rigcal_rig_fit fit;

    WANTS_A_RIG;
    set_up(&x, 1);
    for (int v = 0; v < VIEWS; v++) {
        left_out[v] = v % CAMERAS == 2;
    }
    x.rig.left_out = left_out;
    TEST_ASSERT_TRUE(rigcal_rig_adjust(&fit, NULL, &x.rig) >= 0);
    test_it(&x);
    for (int kind = 0; kind < RIGCAL_FAULT_BENT; kind++) {
        if (kind != RIGCAL_FAULT_CLOCKS) {
            TEST_ASSERT_EQUAL_INT32(0, fault_of(&x, kind, 2)->is_seen);
        }
    }
    TEST_ASSERT_EQUAL_INT32(1, fault_of(&x, RIGCAL_FAULT_FOCAL, 1)->is_seen);
}

static void test_nothing_in_common_is_no_disagreement(void)
{
    static uint8_t left_out[VIEWS];
    rigcal_rig_fit fit;

    WANTS_A_RIG;
    set_up(&x, 0);
    for (int v = 0; v < VIEWS; v++) { /* each placement has one view */
        left_out[v] = v % CAMERAS != (v / CAMERAS) % CAMERAS;
    }
    x.rig.left_out = left_out;
    TEST_ASSERT_TRUE(rigcal_rig_adjust(&fit, NULL, &x.rig) >= 0);
    test_it(&x);
    TEST_ASSERT_TRUE((x.found.bits & RIGCAL_FAULTS_NO_LOOP) != 0);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_RIG_AGREES, x.found.verdict);
}

/* ---- how it is called --------------------------------------------------------------- */

static void assert_close(double expected, rigcal_real seen, double tol)
{
    ASSERT_NEAR(expected, seen, tol * (1 + fabs(expected)));
}

/* All numbers of one fault, in units of its deviations or of itself. */
static void assert_same_fault(const rigcal_fault *a, const rigcal_fault *b, double tol)
{
    const double loss = 10 * tol * loss_of(a);

    TEST_ASSERT_EQUAL_INT32(a->is_seen, b->is_seen);
    TEST_ASSERT_EQUAL_INT32(a->placement, b->placement);
    TEST_ASSERT_EQUAL_INT32(a->n, b->n);
    TEST_ASSERT_EQUAL_INT32(a->explains, b->explains);
    for (int k = 0; k < RIGCAL_FAULT_VALUES; k++) {
        ASSERT_NEAR(a->value[k], b->value[k],
                    loss * (D(a->sigma[k]) + fabs(D(a->value[k]))));
        ASSERT_NEAR(a->sigma[k], b->sigma[k], loss * D(a->sigma[k]));
    }
    assert_close(D(a->gain), b->gain, loss);
    assert_close(D(a->p), b->p, loss);
    assert_close(D(a->bic), b->bic, loss);
    assert_close(D(a->F_after), b->F_after, loss);
    ASSERT_NEAR(a->turn, b->turn, loss * D(a->turn));
    ASSERT_NEAR(a->shift, b->shift, loss * D(a->shift));
}

static void assert_same(const fixture *a, const rigcal_faults *found,
                        const rigcal_fault faults[], double tol)
{
    const rigcal_faults *const f = &a->found;

    TEST_ASSERT_EQUAL_INT32(f->n, found->n);
    TEST_ASSERT_EQUAL_INT32(f->n_seen, found->n_seen);
    TEST_ASSERT_EQUAL_INT32(f->n_alike, found->n_alike);
    TEST_ASSERT_EQUAL_INT32(f->verdict, found->verdict);
    TEST_ASSERT_EQUAL_INT32(f->bits, found->bits);
    ASSERT_NEAR(f->freedom_between, found->freedom_between, 0);
    ASSERT_NEAR(f->freedom_within, found->freedom_within, 0);
    assert_close(D(f->F), found->F, tol);
    assert_close(D(f->sigma_px), found->sigma_px, tol);
    assert_close(D(f->own_px), found->own_px, tol);
    assert_close(D(f->explained), found->explained, 10 * tol);
    assert_close(D(f->pattern), found->pattern, tol);
    assert_close(D(f->pattern_sigma), found->pattern_sigma, tol);
    assert_close(D(f->along), found->along, tol);
    assert_close(D(f->along_time), found->along_time, tol);
    assert_close(D(f->frame), found->frame, tol);
    for (int i = 0; i < found->n; i++) {
        assert_same_fault(fault_of(a, faults[i].kind, faults[i].camera), &faults[i], tol);
    }
}

static void test_the_budget_of_a_step_changes_no_bit(void)
{
    static rigcal_faults_solver solver;
    static rigcal_fault faults[FAULTS];
    rigcal_faults found;
    int steps = 0;

    WANTS_A_RIG;
    set_up(&x, 1);
    test_it(&x);
    memset(faults, 0, sizeof faults);
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_faults_begin(&solver, faults, FAULTS, &x.options, &x.rig));
    ASSERT_REFUSED(RIGCAL_ERR_STATE, found, rigcal_faults_result(&found, NULL, &solver));
    while (rigcal_faults_step(&solver, 1 + steps % 3) == RIGCAL_RUNNING) {
        steps++;
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_faults_result(&found, NULL, &solver));
    TEST_ASSERT_TRUE(steps > VIEWS);
    assert_same(&x, &found, faults, 0);
}

/* Calls with this budget until it is done. */
static int calls_of(int32_t budget)
{
    static rigcal_faults_solver solver;
    int n = 1;

    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_faults_begin(&solver, x.faults, FAULTS, &x.options, &x.rig));
    while (n < 1000 && rigcal_faults_step(&solver, budget) == RIGCAL_RUNNING) {
        n++;
    }
    return n;
}

static void test_a_budget_is_a_number_of_units(void)
{
    WANTS_A_RIG;
    set_up(&x, 1);
    const int units = calls_of(1);

    TEST_ASSERT_TRUE(units > VIEWS && units < 1000);
    for (int32_t budget = 2; budget < 6; budget++) {
        TEST_ASSERT_EQUAL_INT((units + budget - 1) / budget, calls_of(budget));
    }
}

static void test_less_memory_takes_more_passes_and_finds_the_same(void)
{
    static rigcal_fault faults[FAULTS];
    rigcal_faults found;

    WANTS_A_RIG;
    set_up(&x, 1);
    test_it(&x);
    TEST_ASSERT_TRUE(x.found.passes <= 2);
    memcpy(faults, x.faults, sizeof faults);
    found = x.found;
    x.options.work_capacity = RIGCAL_FAULTS_LEAST(CAMERAS - 1, CAMERAS);
    test_it(&x);
    TEST_ASSERT_TRUE(x.found.passes > 1);
    assert_same(&x, &found, faults, TOL(1e-9, 1e-3));
    x.options.work_capacity = 10;
    ASSERT_STATUS(RIGCAL_ERR_CAPACITY,
                  rigcal_rig_faults(&x.found, x.faults, FAULTS, NULL, &x.options, &x.rig));
}

/* The stated memory is enough for two passes. */
static void test_the_stated_memory_is_enough_for_two_passes(void)
{
    WANTS_A_RIG;
    set_up(&x, 1);
    x.options.work_capacity = RIGCAL_FAULTS_WORK(CAMERAS - 1, CAMERAS);
    test_it(&x);
    TEST_ASSERT_TRUE(x.found.passes <= 2);
}

/* The least memory with which these kinds take one pass. */
static size_t room_of(int32_t kinds)
{
    size_t low = 0, high = sizeof x.room / sizeof *x.room;

    x.options.kinds = kinds;
    while (low < high) {
        const size_t middle = (low + high) / 2;

        x.options.work_capacity = middle;
        const rigcal_status status =
            rigcal_rig_faults(&x.found, x.faults, FAULTS, NULL, &x.options, &x.rig);
        if (status == RIGCAL_OK && x.found.passes == 1) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    return high;
}

/* A column has six reals by the unknowns of a placement, one for each unknown of the
 * cameras, and five sums. As much again may be lost where a part no longer fits into the
 * first of two pieces of memory. */
static void test_what_is_not_asked_for_takes_no_memory(void)
{
    const int32_t focal = RIGCAL_FAULTS_OF(RIGCAL_FAULT_FOCAL);
    const int32_t aspect = RIGCAL_FAULTS_OF(RIGCAL_FAULT_ASPECT);
    const int32_t clock = RIGCAL_FAULTS_OF(RIGCAL_FAULT_CLOCK);
    const int32_t lens = RIGCAL_FAULTS_OF(RIGCAL_FAULT_DISTORTION);
    const int32_t stretched = RIGCAL_FAULTS_OF(RIGCAL_FAULT_STRETCHED);
    const size_t column = 6 + 6 * (CAMERAS - 1) + 5;

    WANTS_A_RIG;
    set_up(&x, 1);
    const size_t one = room_of(focal | aspect);

    TEST_ASSERT_TRUE(one > 0);
    TEST_ASSERT_TRUE(room_of(focal | aspect | clock) >= one + 6 * CAMERAS);
    TEST_ASSERT_TRUE(room_of(focal | aspect | lens | stretched) <=
                     room_of(focal | aspect | lens) + 2 * column);
    TEST_ASSERT_TRUE(room_of(focal | aspect | lens) <= one + (2 * CAMERAS + 1) * column);
}

/* The least memory is enough for each kind, whichever others are asked for. */
static void test_each_kind_by_itself_is_as_among_the_others(void)
{
    static rigcal_fault faults[FAULTS];
    int seen = 0;

    WANTS_A_RIG;
    set_up(&x, 1);
    test_it(&x);
    const int n = x.found.n;
    memcpy(faults, x.faults, sizeof faults);
    x.options.work_capacity = RIGCAL_FAULTS_LEAST(CAMERAS - 1, CAMERAS);
    for (int32_t kind = 0; kind < RIGCAL_FAULT_KINDS; kind++) {
        x.options.kinds = RIGCAL_FAULTS_OF(kind);
        test_it(&x);
        for (int i = 0; i < n; i++) {
            if (faults[i].kind == kind) {
                const rigcal_fault *const alone = fault_of(&x, kind, faults[i].camera);

                for (int k = 0; k < RIGCAL_FAULT_VALUES; k++) {
                    const double sigma = D(faults[i].sigma[k]);

                    ASSERT_NEAR(faults[i].value[k], alone->value[k],
                                TOL(1e-9, 1e-3) * sigma);
                    ASSERT_NEAR(sigma, alone->sigma[k], TOL(1e-9, 1e-3) * sigma);
                }
                ASSERT_NEAR(faults[i].turn, alone->turn,
                            TOL(1e-9, 1e-3) * D(faults[i].turn));
                ASSERT_NEAR(faults[i].shift, alone->shift,
                            TOL(1e-9, 1e-3) * D(faults[i].shift));
                seen++;
            }
        }
    }
    TEST_ASSERT_EQUAL_INT(n, seen);
}

static void test_a_short_list_has_the_best(void)
{
    rigcal_fault two[2];
    rigcal_faults found;

    WANTS_A_RIG;
    set_up(&x, 1);
    test_it(&x);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_faults(&found, two, 2, NULL, &x.options, &x.rig));
    TEST_ASSERT_EQUAL_INT32(2, found.n);
    TEST_ASSERT_EQUAL_INT32(x.found.n_seen, found.n_seen);
    for (int i = 0; i < 2; i++) {
        TEST_ASSERT_EQUAL_INT32(x.faults[i].kind, two[i].kind);
        TEST_ASSERT_EQUAL_INT32(x.faults[i].camera, two[i].camera);
    }
}

static void test_the_covariance_stays(void)
{
    rigcal_real before[36], after[36];

    WANTS_A_RIG;
    set_up(&x, 1);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(before, &x.rig, 1, 2));
    test_it(&x);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(after, &x.rig, 1, 2));
    TEST_ASSERT_EQUAL_MEMORY(before, after, sizeof before);
}

static void test_points_beyond_4_sigma_do_not_count_where_they_are_left_out(void)
{
    rigcal_faults whole;

    WANTS_A_RIG;
    set_up(&x, 0);
    test_it(&x);
    whole = x.found;
    ASSERT_NEAR(0.3, whole.sigma_px, 0.06); /* the noise of the pixels */
    x.o[4][2].uv[0] += RC(40);
    x.rig.sigma_px = RC(0.3);
    x.options.is_truncated = 1;
    test_it(&x);
    ASSERT_NEAR(D(whole.sigma_px), x.found.sigma_px, 0.02);
    ASSERT_NEAR(D(whole.freedom_between), x.found.freedom_between, 0);
    ASSERT_NEAR(D(whole.freedom_within) - 2, x.found.freedom_within, 0);
}

static void test_options_are_checked(void)
{
    WANTS_A_RIG;
    set_up(&x, 0);
    test_it(&x);
#define FAULTS_OF rigcal_rig_faults(&x.found, x.faults, FAULTS, NULL, &x.options, &x.rig)
    x.options.is_truncated = 2;
    x.rig.sigma_px = 1;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, x.found, FAULTS_OF);
    x.options.is_truncated = 1;
    ASSERT_STATUS(RIGCAL_OK, FAULTS_OF);
    x.rig.sigma_px = 0;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, x.found, FAULTS_OF);
    x.options.is_truncated = -1;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, x.found, FAULTS_OF);
    x.options.is_truncated = 0;
    x.rig.views = NULL;
    ASSERT_REFUSED(RIGCAL_ERR_NULL, x.found, FAULTS_OF);
    x.rig.views = x.views;
    for (int p = 0; p < PLACEMENTS; p++) { /* with more views than there are cameras */
        x.work[p] = RC(MORE + 1);
        ASSERT_REFUSED(RIGCAL_ERR_STATE, x.found, FAULTS_OF);
        x.work[p] = RC(CAMERAS);
    }
    ASSERT_STATUS(RIGCAL_OK, FAULTS_OF);
    TEST_ASSERT_EQUAL_size_t(RIGCAL_FAULTS_WORK(5, 7), rigcal_faults_work(5, 7));
    TEST_ASSERT_EQUAL_size_t(RIGCAL_FAULTS_LEAST(5, 7), rigcal_faults_least(5, 7));
}

/* If one kind is asked for, only that kind is tested, with the same result as if all
 * are. */
static void test_kinds_that_are_asked_for(void)
{
    rigcal_fault all[FAULTS];
    int32_t n_all;

    WANTS_A_RIG;
    set_up(&x, 1);
    test_it(&x);
    memcpy(all, x.faults, sizeof all);
    n_all = x.found.n;
    for (int kind = 0; kind < RIGCAL_FAULT_KINDS; kind++) {
        x.options.kinds = RIGCAL_FAULTS_OF(kind);
        test_it(&x);
        for (int i = 0; i < x.found.n; i++) {
            int k = 0;

            TEST_ASSERT_EQUAL_INT32(kind, x.faults[i].kind);
            while (k < n_all &&
                   (all[k].kind != kind || all[k].camera != x.faults[i].camera ||
                    all[k].placement != x.faults[i].placement)) {
                k++;
            }
            TEST_ASSERT_TRUE(k < n_all);
            ASSERT_NEAR(D(all[k].value[0]), x.faults[i].value[0],
                        TOL(1e-9, 1e-4) + TOL(1e-6, 1e-2) * fabs(D(all[k].value[0])));
        }
    }
}

static void test_clocks_without_their_memory_are_refused(void)
{
    rigcal_rig_fit fit;

    WANTS_A_RIG;
    set_up(&x, 0);
#define ADJUST rigcal_rig_adjust(&fit, NULL, &x.rig)
    x.with_clocks.instants = NULL;
    ASSERT_REFUSED(RIGCAL_ERR_NULL, fit, ADJUST);
    x.with_clocks.instants = x.instants;
    x.with_clocks.states = NULL;
    ASSERT_REFUSED(RIGCAL_ERR_NULL, fit, ADJUST);
    x.with_clocks.states = x.states;
    x.with_clocks.neighbours = 0;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, fit, ADJUST);
    x.with_clocks.neighbours = RIGCAL_MOTION_MOST + 1;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, fit, ADJUST);
    x.with_clocks.neighbours = RIGCAL_MOTION_MOST;
    ASSERT_STATUS(RIGCAL_OK, ADJUST);
#undef ADJUST
}

/* ---- where one finds nothing ------------------------------------------------------- */

/* A rig of two cameras at a distance of 1, which look the same way and see the same three
 * or four points in each of n placements. */
static void set_up_simple(fixture *f, int n_placements, int n_points, double noise)
{
    static const double X[4][2] = {{-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
    test_rng rng = test_seed(71);

    memset(f, 0, sizeof *f);
    for (int c = 0; c < 2; c++) {
        const double t[3] = {-c, 0, 0};

        f->camera[c] = test_pinhole();
        f->camera[c].cx = f->camera[c].cy = 320;
        f->cams[c] = test_transform(NULL, t);
    }
    for (int p = 0; p < n_placements; p++) {
        const double t[3] = {0, 0, 8 << p};

        f->places[p] = test_transform(NULL, t);
        for (int c = 0; c < 2; c++) {
            rigcal_rig_view *const view = &f->views[2 * p + c];
            rigcal_observation *const o = f->o[2 * p + c];

            for (int i = 0; i < n_points; i++) {
                o[i].X_w[0] = RC(X[i][0]);
                o[i].X_w[1] = RC(X[i][1]);
                o[i].uv[0] = RC(320 + 800 * (X[i][0] - c) / t[2]);
                o[i].uv[1] = RC(320 + 800 * X[i][1] / t[2]);
                for (int k = 0; k < 2; k++) {
                    o[i].uv[k] += RC(noise * test_normal(&rng));
                }
            }
            *view = (rigcal_rig_view){.view = VIEW(&f->camera[c], o, NULL, n_points),
                                      .camera = c,
                                      .placement = p};
        }
    }
    f->rig.cams_from_rig = f->cams;
    f->rig.n_cameras = 2;
    f->rig.rig_from_placements = f->places;
    f->rig.n_placements = (size_t)n_placements;
    f->rig.group = f->group;
    f->rig.n_views = (size_t)(2 * n_placements);
    f->rig.views = f->views;
    f->rig.work = f->work;
    f->rig.work_capacity = sizeof f->work / sizeof *f->work;
    f->options.work = f->room;
    f->options.work_capacity = sizeof f->room / sizeof *f->room;
    (void)least_sum(f);
}

/* Three points fit any pixels, so there is nothing to compare with. With two placements six
 * numbers are left, as many as a camera that moved has. */
static void test_views_of_three_points_have_no_loop(void)
{
    static const uint8_t breaks[PLACEMENTS] = {0, 1, 0, 0, 0, 0};

    WANTS_A_RIG;
    for (int n = 2; n < 4; n++) {
        set_up_simple(&x, n, 3, 0.3);
        x.options.breaks = breaks;
        memset(x.faults, 0x5a, sizeof x.faults);
        test_it(&x);
        TEST_ASSERT_EQUAL_HEX32(0x5a5a5a5a, x.faults[x.found.n].explains);
        TEST_ASSERT_TRUE((x.found.bits & RIGCAL_FAULTS_NO_LOOP) != 0);
        TEST_ASSERT_EQUAL_INT32(RIGCAL_RIG_AGREES, x.found.verdict);
        ASSERT_NEAR(6 * (n - 1), x.found.freedom_between, 0);
        ASSERT_NEAR(0, x.found.freedom_within, 0);
        ASSERT_NEAR(0, x.found.own_px, 0);
        ASSERT_NEAR(0, x.found.F, 0);
        TEST_ASSERT_EQUAL_INT32(2, x.found.n_cameras);
        TEST_ASSERT_EQUAL_INT32(RIGCAL_FAULTS_NO_LOOP | RIGCAL_FAULTS_NO_TIMES |
                                    RIGCAL_FAULTS_TWO_CAMERAS,
                                x.found.bits);
        for (int i = 0; i < x.found.n; i++) { /* nothing is left to be explained */
            TEST_ASSERT_EQUAL_INT32(0, x.faults[i].explains);
        }
        for (int c = 0; c < 2; c++) {
            const rigcal_fault *const moved = fault_of(&x, RIGCAL_FAULT_MOVED, c);

            TEST_ASSERT_EQUAL_INT32(n > 2, moved->is_seen);
            TEST_ASSERT_EQUAL_INT32(n > 2 ? 1 : -1, moved->placement);
        }
    }
}

/* A ring: camera c sees placements c and c + 1, the last camera also placement 0. So there
 * is one loop, and it closes in six numbers. Five clocks are free. */
enum { RING = TEST_HOST ? 6 : 2, RING_POINTS = 6 };

static struct {
    rigcal_camera camera;
    rigcal_observation o[2 * RING][RING_POINTS];
    rigcal_rig_view views[2 * RING];
    rigcal_transform cams[RING], places[RING];
    rigcal_real times[RING], instants[RING], offsets[RING];
    int32_t states[RING], group[RING];
    rigcal_real work[RIGCAL_RIG_WORK(RING, RING, RING) + RIGCAL_CLOCKS_WORK(RING, RING)];
    rigcal_real room[RIGCAL_FAULTS_WORK(RING, RING) + RIGCAL_FAULTS_CLOCKS_WORK(RING)];
    rigcal_rig_clocks clocks;
    rigcal_rig rig;
} ring;

static void make_ring(test_rng *rng)
{
    static const double UP[3] = {0, 1, 0};
    double X[RING_POINTS][3];

    memset(&ring, 0, sizeof ring);
    ring.camera = test_pinhole();
    for (int i = 0; i < RING_POINTS; i++) {
        for (int k = 0; k < 3; k++) {
            X[i][k] = test_uniform(rng, -0.5, 0.5);
        }
    }
    for (int c = 0; c < RING; c++) {
        const double axis[3] = {test_normal(rng), test_normal(rng), test_normal(rng)};

        ring.cams[c] = test_turned_about(UP, 0.4 * c);
        ring.cams[c].t[2] = 4;
        ring.places[c] = test_turned_about(axis, 0.5);
        for (int k = 0; k < 3; k++) {
            ring.places[c].t[k] = RC(test_uniform(rng, -0.3, 0.3));
        }
        ring.times[c] = RC(0.3 * c);
    }
    for (int v = 0; v < 2 * RING; v++) {
        const int place = v / 2, camera = (place + (v % 2) * (RING - 1)) % RING;
        const rigcal_transform T = test_times(&ring.cams[camera], &ring.places[place]);

        ring.views[v].camera = camera;
        ring.views[v].placement = place;
        ring.views[v].view = VIEW(&ring.camera, ring.o[v], NULL, RING_POINTS);
        for (int i = 0; i < RING_POINTS; i++) {
            double X_c[3], uv[2];

            test_to_real(ring.o[v][i].X_w, X[i], 3);
            test_move_point(X_c, &T, X[i]);
            test_project_px(uv, &ring.camera, X_c);
            ring.o[v][i].uv[0] = RC(uv[0] + 0.3 * test_normal(rng));
            ring.o[v][i].uv[1] = RC(uv[1] + 0.3 * test_normal(rng));
        }
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_defaults(&ring.clocks));
    ring.clocks.times = ring.times;
    ring.clocks.instants = ring.instants;
    ring.clocks.offsets = ring.offsets;
    ring.clocks.states = ring.states;
    ring.clocks.free_offsets = 1;
    ring.clocks.neighbours = 2;
    ring.rig.cams_from_rig = ring.cams;
    ring.rig.rig_from_placements = ring.places;
    ring.rig.n_cameras = ring.rig.n_placements = RING;
    ring.rig.group = ring.group;
    ring.rig.views = ring.views;
    ring.rig.n_views = (size_t)(2 * RING);
    ring.rig.clocks = &ring.clocks;
    ring.rig.work = ring.work;
    ring.rig.work_capacity = sizeof ring.work / sizeof ring.work[0];
}

/* The only loop has one freedom more than there are clocks. It is enough to disagree. F is
 * what the views at their own poses leave, and what the rig adds to that. */
static void test_one_freedom_is_a_loop(void)
{
    const double within = 2 * 2 * RING * RING_POINTS - 6 * 2 * RING;
    test_rng rng = test_seed(78);
    rigcal_rig_fit fit;
    double own = 0;

    TEST_ON_HOST_ONLY("memory of six cameras");
    make_ring(&rng);
    x.options = (rigcal_faults_options){
        .work = ring.room, .work_capacity = sizeof ring.room / sizeof ring.room[0]};
    x.rig = ring.rig;
    for (int k = 0; k < 4; k++) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &x.rig));
    }
    for (int v = 0; v < 2 * RING; v++) {
        rigcal_pose poses[RIGCAL_POSES_MAX];
        size_t n;

        TEST_ASSERT_TRUE(rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n, NULL,
                                           &ring.views[v].view, NULL) >= 0);
        own += RING_POINTS * D(poses[0].rms_px) * D(poses[0].rms_px);
    }
    test_it(&x);
    ASSERT_NEAR(1, x.found.freedom_between, 0);
    ASSERT_NEAR(within, x.found.freedom_within, 0);
    TEST_ASSERT_EQUAL_INT32(0, x.found.bits & RIGCAL_FAULTS_NO_LOOP);
    const double F = (D(fit.sum) - own) / (own / within);
    ASSERT_NEAR(F, x.found.F, TOL(1e-3, 0.02) * (1 + F));
    TEST_ASSERT_TRUE(F > 0.01);
}

/* The target stands still except for noise: a clock that is off would not show. */
static void test_of_a_target_that_stands_still_no_clock_is_told(void)
{
    WANTS_A_RIG;
    for (int is_still = 0; is_still < 2; is_still++) {
        set_up_simple(&x, 3, 4, 0.3);
        for (int v = 2; v < 6 && is_still; v++) {
            test_rng rng = test_seed(72 + (uint64_t)v);
            for (int k = 0; k < 8; k++) {
                x.o[v][k / 2].uv[k % 2] =
                    RC(D(x.o[v % 2][k / 2].uv[k % 2]) + 1e-3 * test_normal(&rng));
            }
            x.places[v / 2] = x.places[0];
        }
        for (int p = 0; p < 3; p++) {
            x.times[p] = RC(p / 30.);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_defaults(&x.with_clocks));
        x.with_clocks.times = x.times;
        x.with_clocks.instants = x.instants;
        x.with_clocks.offsets = x.offsets;
        x.with_clocks.states = x.states;
        x.rig.clocks = &x.with_clocks;
        (void)least_sum(&x);
        test_it(&x);
        TEST_ASSERT_EQUAL_INT(is_still, (x.found.bits & RIGCAL_FAULTS_NO_MOTION) != 0);
        TEST_ASSERT_EQUAL_INT(0, x.found.bits & RIGCAL_FAULTS_NO_NEIGHBOUR);
        TEST_ASSERT_TRUE((x.found.bits & RIGCAL_FAULTS_TWO_CAMERAS) != 0);
        for (int i = 0; i < x.found.n; i++) { /* one clock is free, so CLOCK says all */
            TEST_ASSERT_TRUE(x.faults[i].kind != RIGCAL_FAULT_CLOCKS);
        }
    }
}

/* Times may have any unit. One of 2^-10 s changes no digit: what has the unit of a time is
 * 2^10 times as large. */
static void test_the_unit_of_time_changes_no_fault(void)
{
    static rigcal_fault faults[FAULTS];
    int n = 0;

    WANTS_A_RIG;
    for (int is_small = 0; is_small < 2; is_small++) {
        set_up(&x, 2);
        for (int p = 0; p < PLACEMENTS && is_small; p++) {
            x.times[p] *= 1024;
        }
        x.with_clocks.frame *= (rigcal_real)(is_small ? 1024 : 1);
        (void)least_sum(&x);
        test_it(&x);
        for (int i = 0; i < n; i++) {
            const int has_time = faults[i].kind == RIGCAL_FAULT_CLOCK ||
                                 faults[i].kind == RIGCAL_FAULT_CLOCKS;
            const double unit = has_time ? 1024 : 1;
            const rigcal_fault *const seen = fault_of(&x, faults[i].kind, faults[i].camera);

            TEST_ASSERT_EQUAL_INT32(faults[i].is_seen, seen->is_seen);
            TEST_ASSERT_EQUAL_INT32(faults[i].n, seen->n);
            for (int k = 0; k < RIGCAL_FAULT_VALUES; k++) {
                if (faults[i].kind != RIGCAL_FAULT_SHUTTER) {
                    ASSERT_NEAR(unit * D(faults[i].value[k]), seen->value[k], 0);
                    ASSERT_NEAR(unit * D(faults[i].sigma[k]), seen->sigma[k], 0);
                }
            }
            ASSERT_NEAR(faults[i].gain, seen->gain, 0);
        }
        n = x.found.n;
        memcpy(faults, x.faults, sizeof faults);
    }
    TEST_ASSERT_TRUE(n > 10);
}

/* Poses and clocks that are some sigma beside their optimum give the same faults: to first
 * order the equations take such a step into account. */
static void test_a_rig_beside_its_optimum_has_the_same_faults(void)
{
    static rigcal_fault faults[FAULTS];

    WANTS_A_RIG;
    for (int way = 0; way < 3; way++) {
        test_rng rng = test_seed(73 + (uint64_t)way);
        int n_seen = 0;

        set_up(&x, 3);
        set_clocks(&x, way > 0, way > 1, way > 0 ? 0.001 : 0);
        (void)least_sum(&x);
        test_it(&x);
        memcpy(faults, x.faults, sizeof faults);
        for (int c = 1; c < CAMERAS; c++) {
            double R[9], t[3], d[6];

            for (int k = 0; k < 6; k++) {
                d[k] = 1e-4 * test_normal(&rng);
            }
            test_transform_parts(R, t, &x.cams[c]);
            test_move(R, t, d);
            x.cams[c] = test_transform(R, t);
            x.offsets[c] += (rigcal_real)(way > 0 ? 1e-4 * test_normal(&rng) : 0);
        }
        const int n = x.found.n;
        test_it(&x);
        for (int i = 0; i < n; i++) {
            const rigcal_fault *const seen = fault_of(&x, faults[i].kind, faults[i].camera);

            for (int k = 0; k < seen->n && faults[i].kind != RIGCAL_FAULT_MOVED; k++) {
                ASSERT_NEAR(faults[i].value[k], seen->value[k],
                            TOL(0.05, 0.2) * D(faults[i].sigma[k]));
                n_seen += seen->is_seen;
            }
        }
        TEST_ASSERT_TRUE(n_seen > 10);
    }
}

/* The board in another frame, in which all its points have Y = 0. */
static void test_a_board_in_the_plane_of_x_and_z_has_the_same_cameras(void)
{
    static const double ACROSS[9] = {1, 0, 0, 0, 0, 1, 0, -1, 0};
    rigcal_fault before;

    WANTS_A_RIG;
    set_up(&x, 3);
    (void)least_sum(&x);
    test_it(&x);
    before = *fault_of(&x, RIGCAL_FAULT_FOCAL, 1);
    for (int p = 0; p < PLACEMENTS; p++) {
        const rigcal_transform turned_from_board = test_transform(ACROSS, NULL),
                               back = test_inverse(&turned_from_board);
        x.places[p] = test_times(&x.places[p], &back);
    }
    for (int i = 0; i < VIEWS * POINTS; i++) {
        rigcal_real *const X = x.o[i / POINTS][i % POINTS].X_w;
        X[2] = -X[1];
        X[1] = 0;
    }
    (void)least_sum(&x);
    test_it(&x);
    ASSERT_NEAR(before.value[0], fault_of(&x, RIGCAL_FAULT_FOCAL, 1)->value[0],
                TOL(1e-6, 5e-2) * D(before.sigma[0]));
    ASSERT_NEAR(before.gain, fault_of(&x, RIGCAL_FAULT_FOCAL, 1)->gain,
                TOL(1e-6, 1e-2) * (1 + D(before.gain)));
}

/* Two cameras are held, so their poses cannot absorb the effect of a fault. */
static void test_a_fault_of_a_camera_that_is_held_is_that_of_an_adjustment(void)
{
    static const uint8_t ROLES[CAMERAS] = {RIGCAL_CAMERA_HELD, RIGCAL_CAMERA_HELD,
                                           RIGCAL_CAMERA_FREE};

    WANTS_A_RIG;
    for (int c = 0; c < CAMERAS; c++) {
        set_up(&x, 3);
        x.rig.roles = ROLES;
        const double before = least_sum(&x);
        test_it(&x);
        const rigcal_fault seen = *fault_of(&x, RIGCAL_FAULT_FOCAL, c);
        correct(&x, RIGCAL_FAULT_FOCAL, c, seen.value);
        ASSERT_NEAR(before - least_sum(&x), seen.gain,
                    0.02 * D(seen.gain) + TOL(1e-3, 1e-2) * before);
    }
}

/* All cameras have priors, which are off by more than their deviations. So the views pull
 * each camera away from where its prior has it. */
static void test_a_fault_of_cameras_with_priors_is_that_of_an_adjustment(void)
{
    static const uint8_t ROLES[CAMERAS] = {RIGCAL_CAMERA_PRIOR, RIGCAL_CAMERA_PRIOR,
                                           RIGCAL_CAMERA_PRIOR};
    static rigcal_camera_prior priors[CAMERAS];
    const double sigma = 1e-3;

    WANTS_A_RIG;
    for (int c = 0; c < CAMERAS; c++) {
        test_rng rng = test_seed(77);

        set_up(&x, 3);
        for (int i = 0; i < CAMERAS; i++) {
            double R[9], t[3], d[6];

            for (int k = 0; k < 6; k++) {
                d[k] = 3 * sigma * test_normal(&rng);
                priors[i].Sigma[7 * k] = RC(sigma * sigma);
            }
            test_transform_parts(R, t, &x.cams[i]);
            test_move(R, t, d);
            priors[i].cam_from_rig = test_transform(R, t);
        }
        x.rig.roles = ROLES;
        x.rig.priors = priors;
        x.rig.sigma_px = RC(0.3);
        const double before = least_sum(&x);
        test_it(&x);
        const rigcal_fault seen = *fault_of(&x, RIGCAL_FAULT_FOCAL, c);
        correct(&x, RIGCAL_FAULT_FOCAL, c, seen.value);
        ASSERT_NEAR(before - least_sum(&x), seen.gain,
                    0.02 * D(seen.gain) + TOL(1e-3, 1e-2) * before);
    }
}

/* Two cameras that see the board from far away, in a narrow field. There a turn has nearly
 * the effect of a centre that is off. */
static void set_up_narrow(fixture *f, double far)
{
    test_rng rng = test_seed(76);

    set_up(f, 3);
    f->rig.n_cameras = 2;
    f->rig.n_views = 2 * PLACEMENTS;
    f->rig.clocks = NULL;
    for (int c = 0; c < 2; c++) {
        static const double AXIS[3] = {0.2, 1, 0.1};

        f->camera[c] = test_pinhole();
        f->camera[c].fx = f->camera[c].fy = RC(1200 * far);
        f->cams[c] = test_turned_about(AXIS, 0.7 * c);
        f->cams[c].t[2] = RC(far);
    }
    for (int p = 0; p < PLACEMENTS; p++) {
        const double axis[3] = {test_normal(&rng), test_normal(&rng), test_normal(&rng)};

        f->places[p] = test_turned_about(axis, 0.4);
        f->places[p].t[2] = RC(0.02 * far * p);
        for (int c = 0; c < 2; c++) {
            const int v = 2 * p + c;
            const rigcal_transform T = test_times(&f->cams[c], &f->places[p]);

            f->views[v].camera = c;
            f->views[v].placement = p;
            f->views[v].view = VIEW(&f->camera[c], f->o[v], NULL, POINTS);
            for (int i = 0; i < POINTS; i++) {
                double X[3], X_c[3], uv[2];

                test_to_double(X, f->o[v][i].X_w, 3);
                test_move_point(X_c, &T, X);
                test_project_px(uv, &f->camera[c], X_c);
                f->o[v][i].uv[0] = RC(uv[0] + 0.1 * test_normal(&rng));
                f->o[v][i].uv[1] = RC(uv[1] + 0.1 * test_normal(&rng));
            }
        }
    }
}

/* Which of two cameras is held changes no fault. Float has no digits left to see one. */
static void test_narrow_cameras_have_the_same_faults_whichever_is_held(void)
{
    static const uint8_t ROLES[2][2] = {{RIGCAL_CAMERA_HELD, RIGCAL_CAMERA_FREE},
                                        {RIGCAL_CAMERA_FREE, RIGCAL_CAMERA_HELD}};
    static const int KINDS[3] = {RIGCAL_FAULT_CENTRE, RIGCAL_FAULT_FOCAL,
                                 RIGCAL_FAULT_ASPECT};

    WANTS_A_RIG;
    for (int far = 9; far < 1000 && !RIGCAL_USE_FLOAT; far *= 9) {
        rigcal_fault first[3][2];

        for (int held = 0; held < 2; held++) {
            set_up_narrow(&x, far);
            x.rig.roles = ROLES[held];
            ASSERT_NEAR(1.8, least_sum(&x), 0.1);
            test_it(&x);
            for (int i = 0; i < 6; i++) {
                const rigcal_fault *const seen = fault_of(&x, KINDS[i / 2], i % 2);

                TEST_ASSERT_EQUAL_INT32(1, seen->is_seen);
                if (held == 0) {
                    first[i / 2][i % 2] = *seen;
                    continue;
                }
                const rigcal_fault *const other = &first[i / 2][i % 2];

                ASSERT_NEAR(other->gain, seen->gain, 1e-5);
                ASSERT_NEAR(other->sigma[0], seen->sigma[0], 1e-4 * D(other->sigma[0]));
                ASSERT_NEAR(other->value[0], seen->value[0], 1e-4 * D(other->sigma[0]));
                ASSERT_NEAR(other->turn, seen->turn, 1e-3 * D(other->turn));
            }
        }
    }
}

static void test_clocks_need_not_be_written(void)
{
    rigcal_fault all;

    WANTS_A_RIG;
    set_up(&x, 2);
    test_it(&x);
    all = *fault_of(&x, RIGCAL_FAULT_CLOCKS, -1);
    x.options.clocks = NULL;
    test_it(&x);
    TEST_ASSERT_EQUAL_MEMORY(&all, fault_of(&x, RIGCAL_FAULT_CLOCKS, -1), sizeof all);
    TEST_ASSERT_NULL(x.found.clocks);
}

/* After the adjustment the stamps of the rig get so much noise that they say nothing. */
static void test_placements_that_nothing_fixes_are_degenerate(void)
{
    int32_t at_fault;

    WANTS_A_RIG;
    set_up(&x, 2);
    set_clocks(&x, 0, 0, 0.001);
    (void)least_sum(&x);
    x.with_clocks.memory.ratio2 = RC(TOL(1e-30, 1e-20));
    FILL(x.found);
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE, rigcal_rig_faults(&x.found, x.faults, FAULTS,
                                                           &at_fault, &x.options, &x.rig));
    ASSERT_UNTOUCHED(x.found);
    TEST_ASSERT_TRUE(at_fault >= 0 && at_fault % CAMERAS == 0); /* of this placement */
}

/* ---- what must not matter ------------------------------------------------------------ */

/* The board in another frame, beside itself: all faults are the same. */
static void test_the_origin_of_the_board_changes_no_fault(void)
{
    static const double BESIDE[3] = {0.7, -0.4, 0};
    static rigcal_fault faults[FAULTS];
    const rigcal_transform to_board = test_transform(NULL, (double[3]){-0.7, 0.4, 0});

    WANTS_A_RIG;
    set_up(&x, 1);
    x.rig.clocks = NULL; /* the curve through its origins would be another one */
    (void)least_sum(&x);
    test_it(&x);
    const rigcal_faults found = x.found;
    memcpy(faults, x.faults, sizeof faults);
    for (int p = 0; p < PLACEMENTS; p++) {
        x.places[p] = test_times(&x.places[p], &to_board);
    }
    for (int i = 0; i < VIEWS * POINTS; i++) {
        for (int k = 0; k < 3; k++) {
            x.o[i / POINTS][i % POINTS].X_w[k] += RC(BESIDE[k]);
        }
    }
    (void)least_sum(&x);
    test_it(&x);
    if (!RIGCAL_USE_FLOAT) {
        assert_same(&x, &found, faults, 1e-5);
    }
}

/* A board whose first point alone is at its corner. Told from the last point to the first,
 * the faults are the same. */
static void test_the_order_of_points_changes_no_fault(void)
{
    static rigcal_fault faults[FAULTS];
    test_rng rng = test_seed(80);

    WANTS_A_RIG;
    set_up(&x, 1);
    for (int v = 0; v < VIEWS; v++) {
        const rigcal_transform T = test_times(&x.cams[v % CAMERAS], &x.places[v / CAMERAS]);
        const double X[3] = {-0.2, -0.15, 0};
        double X_c[3], uv[2];

        test_to_real(x.o[v][0].X_w, X, 3);
        test_move_point(X_c, &T, X);
        test_project_px(uv, &x.camera[v % CAMERAS], X_c);
        x.o[v][0].uv[0] = RC(uv[0] + 0.3 * test_normal(&rng));
        x.o[v][0].uv[1] = RC(uv[1] + 0.3 * test_normal(&rng));
    }
    (void)least_sum(&x);
    test_it(&x);
    const rigcal_faults found = x.found;
    memcpy(faults, x.faults, sizeof faults);
    for (int v = 0; v < VIEWS; v++) {
        for (int i = 0; i < POINTS / 2; i++) {
            const rigcal_observation first = x.o[v][i];

            x.o[v][i] = x.o[v][POINTS - 1 - i];
            x.o[v][POINTS - 1 - i] = first;
        }
    }
    test_it(&x);
    assert_same(&x, &found, faults, TOL(1e-7, 3e-2));
}

/* ---- which views there are ---------------------------------------------------------- */

/* Leaves out the views of these bits, and adjusts. */
static void leave_out(uint8_t left_out[VIEWS], int32_t views)
{
    rigcal_rig_fit fit;

    for (int v = 0; v < VIEWS; v++) {
        left_out[v] = (uint8_t)(views >> v & 1);
    }
    x.rig.left_out = left_out;
    TEST_ASSERT_TRUE(rigcal_rig_adjust(&fit, NULL, &x.rig) >= 0);
    test_it(&x);
}

/* Placement 1 is seen by camera 0 alone, placement 2 by none. There are 13 views of 18
 * numbers. Six unknowns belong to each of 2 cameras and 5 placements. */
static void test_placements_count_that_a_camera_saw(void)
{
    static uint8_t left_out[VIEWS];

    WANTS_A_RIG;
    set_up(&x, 1);
    leave_out(left_out, 7 << 6 | 3 << 4);
    ASSERT_NEAR(13 * 18 - 13 * 6, x.found.freedom_within, 0);
    ASSERT_NEAR(13 * 6 - 6 * (2 + 5), x.found.freedom_between, 0);
    ASSERT_NEAR(0.3, x.found.sigma_px, 0.3);
    for (int n = 0; n < 3; n++) { /* views of the last placement */
        const int used = 15 + n, seen = n > 0 ? 6 : 5;

        set_up(&x, 1);
        x.rig.n_views = (size_t)used;
        leave_out(left_out, 0);
        ASSERT_NEAR(used * 12, x.found.freedom_within, 0);
        ASSERT_NEAR(used * 6 - 6 * (2 + seen), x.found.freedom_between, 0);
    }
}

/* One view of a camera shows what its own pose does not take up. */
static void test_a_camera_with_one_view_has_faults(void)
{
    static uint8_t left_out[VIEWS];

    WANTS_A_RIG;
    for (int c = 1; c < CAMERAS; c++) {
        set_up(&x, 1);
        leave_out(left_out, 0x3fff8 & (c == 1 ? 0x12492 : 0x24924)); /* all but the first */
        TEST_ASSERT_EQUAL_INT32(1, fault_of(&x, RIGCAL_FAULT_FOCAL, c)->is_seen);
        TEST_ASSERT_EQUAL_INT32(1, fault_of(&x, RIGCAL_FAULT_CENTRE, c)->is_seen);
        TEST_ASSERT_EQUAL_INT32(0, fault_of(&x, RIGCAL_FAULT_MOVED, c)->is_seen);
    }
}

/* A move needs views of the camera on both sides. One that has none is not tried. */
static void test_a_move_has_views_on_both_sides(void)
{
    static const uint8_t FIRST[PLACEMENTS] = {1}, MIDDLE[PLACEMENTS] = {0, 0, 0, 1},
                         BOTH[PLACEMENTS] = {1, 0, 0, 1},
                         ALL[PLACEMENTS] = {1, 1, 1, 1, 1, 1};
    rigcal_fault once[CAMERAS];

    WANTS_A_RIG;
    set_up(&x, 5);
    x.options.breaks = FIRST;
    test_it(&x);
    for (int c = 0; c < CAMERAS; c++) {
        TEST_ASSERT_EQUAL_INT32(0, fault_of(&x, RIGCAL_FAULT_MOVED, c)->is_seen);
        TEST_ASSERT_EQUAL_INT32(-1, fault_of(&x, RIGCAL_FAULT_MOVED, c)->placement);
        TEST_ASSERT_EQUAL_INT32(6, fault_of(&x, RIGCAL_FAULT_MOVED, c)->n);
    }
    x.options.breaks = MIDDLE;
    test_it(&x);
    for (int c = 0; c < CAMERAS; c++) {
        once[c] = *fault_of(&x, RIGCAL_FAULT_MOVED, c);
        TEST_ASSERT_EQUAL_INT32(3, once[c].placement);
    }
    x.options.breaks = BOTH;
    test_it(&x);
    for (int c = 0; c < CAMERAS; c++) {
        TEST_ASSERT_EQUAL_MEMORY(&once[c], fault_of(&x, RIGCAL_FAULT_MOVED, c),
                                 sizeof once[c]);
    }
    x.options.breaks = ALL;
    test_it(&x);
    for (int c = 0; c < CAMERAS; c++) {
        const rigcal_fault *const seen = fault_of(&x, RIGCAL_FAULT_MOVED, c);

        TEST_ASSERT_TRUE(seen->placement >= 1 && seen->gain >= once[c].gain);
        if (seen->placement == 3 && once[c].p < RC(0.1)) { /* five are tried */
            ASSERT_NEAR(5 * D(once[c].p), seen->p, TOL(1e-9, 1e-3));
        }
    }
}

/* Between two views of a camera all placements fit alike. One of them is tried: of four
 * views there are three tries. */
static void test_a_move_is_tried_once_between_two_views(void)
{
    static uint8_t left_out[VIEWS];

    WANTS_A_RIG;
    for (int c = 0; c < CAMERAS; c++) {
        uint8_t breaks[PLACEMENTS] = {0};

        set_up(&x, 5);
        leave_out(left_out, 1 << (6 + c) | 1 << (9 + c)); /* at placements 2 and 3 */
        const rigcal_fault tried = *fault_of(&x, RIGCAL_FAULT_MOVED, c);

        TEST_ASSERT_EQUAL_INT32(1, tried.is_seen);
        TEST_ASSERT_TRUE(tried.placement != 2 && tried.placement != 3);
        breaks[tried.placement] = 1;
        x.options.breaks = breaks;
        test_it(&x);
        const rigcal_fault *const once = fault_of(&x, RIGCAL_FAULT_MOVED, c);

        TEST_ASSERT_EQUAL_INT32(tried.placement, once->placement);
        ASSERT_NEAR(fmin(1, 3 * D(once->p)), tried.p, TOL(1e-9, 1e-3));
        breaks[tried.placement] = 0;
        breaks[3] = 1; /* where it saw nothing */
        test_it(&x);
        TEST_ASSERT_EQUAL_INT32(3, fault_of(&x, RIGCAL_FAULT_MOVED, c)->placement);
    }
}

/* Each fault of the three cameras, the clocks together, and two of the board. Free clocks
 * are unknowns too. */
static void test_each_fault_is_listed_once(void)
{
    WANTS_A_RIG;
    set_up(&x, 1);
    test_it(&x);
    TEST_ASSERT_EQUAL_INT32(8 * CAMERAS + 3, x.found.n);
    TEST_ASSERT_EQUAL_INT32(CAMERAS, x.found.n_cameras);
    TEST_ASSERT_EQUAL_PTR(x.clocks, x.found.clocks);
    ASSERT_NEAR(VIEWS * 6 - 6 * (2 + PLACEMENTS), x.found.freedom_between, 0);
    for (int drifts = 0; drifts < 2; drifts++) {
        set_up(&x, 3);
        set_clocks(&x, 1, drifts, 0);
        (void)least_sum(&x);
        test_it(&x);
        ASSERT_NEAR(VIEWS * 6 - 6 * (2 + PLACEMENTS) - 2 * (1 + drifts),
                    x.found.freedom_between, 0);
    }
}

/* Where nothing is known to move, nothing lies along a motion. */
static void test_without_motion_nothing_lies_along_it(void)
{
    rigcal_rig_fit fit;

    WANTS_A_RIG;
    test_without_neighbours();
    ASSERT_NEAR(0, x.found.along, 0);
    ASSERT_NEAR(0, x.found.along_time, 0);
    TEST_ASSERT_TRUE(x.found.F > 0 && x.found.pattern_sigma > 0);
    set_up(&x, 1);
    x.times[5] += 10; /* one placement by itself */
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &x.rig));
    test_it(&x);
    TEST_ASSERT_TRUE(x.found.along > 0 && x.found.along < 1 && x.found.along_time > 0);
}

/* ---- sums over the views ------------------------------------------------------------ */

/* (H12), of the evidence of each view. */
static void test_the_pattern_is_that_of_all_views(void)
{
    const rigcal_real none[6] = {0}, origin[3] = {0};
    const rc_scan scan = {{0, 0}, {1, 1}, 0, origin};
    double n = 0, product = 0, sum_expected = 0, squares = 0;

    WANTS_A_RIG;
    set_up(&x, 3);
    x.rig.clocks = NULL;
    (void)least_sum(&x);
    test_it(&x);
    for (int v = 0; v < VIEWS; v++) {
        rc_evidence e;
        rc_chain chain;
        rigcal_real d[6], expected;

        rc_chain_of(&chain, &x.cams[v % CAMERAS], &x.places[v / CAMERAS]);
        ASSERT_STATUS(RIGCAL_OK, rc_evidence_of(&e, &scan, &x.views[v], &chain, none, 0));
        TEST_ASSERT_EQUAL_INT(1, rc_evidence_alone(&e, d));
        product += D(rc_evidence_pattern(&expected, &e, d));
        sum_expected += D(expected);
        squares += D(expected) * D(expected);
        n += 2 * (double)e.n_neighbours;
    }
    const double variance = D(x.found.own_px) * D(x.found.own_px);
    ASSERT_NEAR((product / variance - sum_expected) / n, x.found.pattern, TOL(1e-9, 1e-3));
    ASSERT_NEAR(sqrt(n - squares / 3) / n, x.found.pattern_sigma, TOL(1e-9, 1e-4));
}

/* 4 sigma are 2 px here. An error of some 1.5 px counts, one of some 3.5 px does not. */
static void test_the_limit_of_truncation_is_4_sigma(void)
{
    WANTS_A_RIG;
    set_up(&x, 0);
    x.o[4][2].uv[0] += RC(3.5);
    x.o[7][5].uv[1] += RC(1.5);
    x.rig.sigma_px = RC(0.5);
    x.options.is_truncated = 1;
    test_it(&x);
    ASSERT_NEAR(VIEWS * (2 * POINTS - 6) - 2, x.found.freedom_within, 0);
    x.options.is_truncated = 0;
    test_it(&x);
    ASSERT_NEAR(VIEWS * (2 * POINTS - 6), x.found.freedom_within, 0);
}

/* ---- arguments, one by one ----------------------------------------------------------- */

/* A view that changed after the adjustment is refused, and named. */
static void test_a_view_that_is_wrong_is_named(void)
{
    WANTS_A_RIG;
    for (int v = 0; v < VIEWS; v += 5) {
        int32_t at_fault = -2;

        set_up(&x, 0);
        x.o[v][3].uv[1] = TEST_NAN;
        ASSERT_REFUSED(
            RIGCAL_ERR_NOT_FINITE, x.found,
            rigcal_rig_faults(&x.found, x.faults, FAULTS, &at_fault, &x.options, &x.rig));
        TEST_ASSERT_EQUAL_INT32(v, at_fault);
        set_up(&x, 0); /* a point behind the camera */
        const rigcal_transform T = test_times(&x.cams[v % CAMERAS], &x.places[v / CAMERAS]);
        const rigcal_transform back = test_inverse(&T);
        const double behind[3] = {0, 0, -5};
        double X[3];

        test_move_point(X, &back, behind);
        test_to_real(x.o[v][3].X_w, X, 3);
        ASSERT_REFUSED(
            RIGCAL_ERR_BEHIND, x.found,
            rigcal_rig_faults(&x.found, x.faults, FAULTS, &at_fault, &x.options, &x.rig));
        TEST_ASSERT_EQUAL_INT32(v, at_fault);
        set_up(&x, 0); /* all points on a line */
        for (int i = 0; i < POINTS; i++) {
            x.o[v][i].X_w[1] = 0;
            x.o[v][i].X_w[0] = RC(0.0625 * i - 0.25);
        }
        ASSERT_REFUSED(
            RIGCAL_ERR_DEGENERATE, x.found,
            rigcal_rig_faults(&x.found, x.faults, FAULTS, &at_fault, &x.options, &x.rig));
        TEST_ASSERT_EQUAL_INT32(v, at_fault);
    }
}

static void test_arguments_are_checked_from_both_sides(void)
{
    static rigcal_faults_solver solver;
    rigcal_faults found;
    int32_t at_fault = -2;

    WANTS_A_RIG;
    set_up(&x, 0);
    for (int k = 0; k < 4; k++) {
        static const int32_t KINDS[4] = {-1, 0, RIGCAL_FAULTS_ALL, RIGCAL_FAULTS_ALL + 1};

        x.options.kinds = KINDS[k];
        ASSERT_STATUS(k % 3 ? RIGCAL_OK : RIGCAL_ERR_RANGE,
                      rigcal_faults_begin(&solver, x.faults, 1, &x.options, &x.rig));
    }
    x.options.kinds = 0;
    FILL(solver);
    ASSERT_STATUS(RIGCAL_ERR_RANGE,
                  rigcal_faults_begin(&solver, x.faults, 0, &x.options, &x.rig));
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_faults_begin(NULL, x.faults, 1, &x.options, &x.rig));
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_faults_begin(&solver, NULL, 1, &x.options, &x.rig));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_faults_begin(&solver, x.faults, 1, NULL, &x.rig));
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_faults_begin(&solver, x.faults, 1, &x.options, NULL));
    x.options.work = NULL;
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_faults_begin(&solver, x.faults, 1, &x.options, &x.rig));
    ASSERT_UNTOUCHED(solver);
    x.options.work = x.room;
    ASSERT_STATUS(RIGCAL_OK, rigcal_faults_begin(&solver, x.faults, 1, &x.options, &x.rig));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_faults_step(&solver, 0));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_faults_step(NULL, 1));
    ASSERT_STATUS(RIGCAL_RUNNING, rigcal_faults_step(&solver, 1));
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_faults_result(&found, &at_fault, &solver));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
    ASSERT_STATUS(RIGCAL_OK, rigcal_faults_step(&solver, 100000));
    at_fault = -2;
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_faults_result(NULL, &at_fault, &solver));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_faults_result(&found, &at_fault, NULL));
    ASSERT_STATUS(RIGCAL_OK, rigcal_faults_result(&found, &at_fault, &solver));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
    TEST_ASSERT_EQUAL_INT32(1, found.n);
    at_fault = -2;
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_rig_faults(NULL, x.faults, FAULTS, &at_fault, &x.options, &x.rig));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
}

/* ---- columns -------------------------------------------------------------------- */

/* What lies behind the cameras of the rig does not matter, also where the camera that has
 * the fault is held and the others move in its place. */
static void test_what_is_behind_the_cameras_of_the_rig_does_not_matter(void)
{
    static const uint8_t ROLES[CAMERAS] = {RIGCAL_CAMERA_FREE, RIGCAL_CAMERA_HELD,
                                           RIGCAL_CAMERA_FREE};
    static rigcal_fault faults[FAULTS];

    WANTS_A_RIG;
    set_up(&x, 3);
    x.rig.roles = ROLES;
    (void)least_sum(&x);
    test_it(&x);
    memcpy(faults, x.faults, sizeof faults);
    x.cams[CAMERAS] = x.cams[0];
    x.group[CAMERAS] = x.group[0];
    test_it(&x);
    TEST_ASSERT_EQUAL_MEMORY(faults, x.faults, (size_t)x.found.n * sizeof faults[0]);
}

/* The test of the clocks of eight cameras has seven parameters. It needs this much of Z: G
 * of the unknowns, I, and four numbers of each parameter. Z ends where T begins. */
static void test_the_clocks_of_eight_cameras_have_room_for_their_test(void)
{
    enum { N = 6 * 7, K = 7 };
    rigcal_real memory[1000];
    rc_pool pool = {{memory, memory}, {1000, 0}, 1};
    rigcal_columns columns;
    rigcal_rig rig;

    memset(&rig, 0, sizeof rig);
    memset(&columns, 0, sizeof columns);
    rig.n_cameras = 8;
    columns.rig = &rig;
    columns.n = N;
    columns.kinds = RIGCAL_FAULTS_OF(RIGCAL_FAULT_CLOCKS);
    rc_columns_lay_out(&columns, &pool, 0);
    TEST_ASSERT_EQUAL_INT(1, pool.is_enough);
    TEST_ASSERT_TRUE(columns.border.T >= columns.border.Z + N + K * (K + 1) / 2 + 4 * K);
}

/* Memory comes from the first of two pieces that has enough of it. */
static void test_memory_is_of_the_first_piece_that_has_it(void)
{
    rigcal_real first[4], second[6];
    rc_pool pool = {{first, second}, {4, 6}, 1};

    TEST_ASSERT_EQUAL_PTR(first, rc_pool_take(&pool, 3));
    TEST_ASSERT_EQUAL_PTR(second, rc_pool_take(&pool, 2));
    TEST_ASSERT_EQUAL_PTR(first + 3, rc_pool_take(&pool, 1));
    TEST_ASSERT_EQUAL_PTR(first + 4, rc_pool_take(&pool, 0));
    TEST_ASSERT_EQUAL_PTR(second + 2, rc_pool_take(&pool, 4));
    TEST_ASSERT_EQUAL_INT(1, pool.is_enough);
    TEST_ASSERT_NULL(rc_pool_take(&pool, 1));
    TEST_ASSERT_EQUAL_INT(0, pool.is_enough);
    TEST_ASSERT_EQUAL_UINT64(0, pool.left[0]);
    TEST_ASSERT_EQUAL_UINT64(0, pool.left[1]);
}

/* Camera 0 may be free too, where another one has the reference clock. */
static void test_free_clocks_are_counted_from_camera_0(void)
{
    int32_t states[3] = {RIGCAL_CLOCK_FREE, RIGCAL_CLOCK_HELD, RIGCAL_CLOCK_FREE};
    rigcal_rig_clocks clocks;
    rigcal_columns columns;
    rigcal_rig rig;

    memset(&rig, 0, sizeof rig);
    memset(&clocks, 0, sizeof clocks);
    memset(&columns, 0, sizeof columns);
    rig.n_cameras = 3;
    rig.clocks = &clocks;
    clocks.states = states;
    clocks.free_offsets = 1;
    columns.rig = &rig;
    TEST_ASSERT_EQUAL_UINT64(2, rc_columns_n_free(&columns));
    clocks.free_drifts = 1;
    TEST_ASSERT_EQUAL_UINT64(4, rc_columns_n_free(&columns));
}

TEST_MAIN()
{
    RUN_TEST(test_each_fault_is_that_of_dense_least_squares);
    RUN_TEST(test_what_the_views_have_in_common_is_that_of_dense_least_squares);
    RUN_TEST(test_a_fault_is_named_and_is_that_of_an_adjustment_with_it);
    RUN_TEST(test_the_clocks_are_told_one_by_one);
    RUN_TEST(test_faults_are_those_of_adjustments_with_free_clocks_and_noisy_stamps);
    RUN_TEST(test_a_camera_that_moved_is_another_one_with_free_clocks);
    RUN_TEST(test_clocks_that_are_free_are_not_found);
    RUN_TEST(test_four_free_clocks_need_the_stated_memory);
    RUN_TEST(test_cameras_that_moved_are_tested_within_the_least_memory);
    RUN_TEST(test_the_first_clock_of_each_group_is_not_told);
    RUN_TEST(test_a_clock_that_nothing_shows_is_no_unknown);
    RUN_TEST(test_small_images_have_the_faults_of_large_ones);
    RUN_TEST(test_without_times_no_clock_is_tested_and_that_is_told);
    RUN_TEST(test_placements_far_apart_in_time_have_no_motion);
    RUN_TEST(test_a_camera_without_views_has_no_faults);
    RUN_TEST(test_nothing_in_common_is_no_disagreement);
    RUN_TEST(test_the_budget_of_a_step_changes_no_bit);
    RUN_TEST(test_a_budget_is_a_number_of_units);
    RUN_TEST(test_less_memory_takes_more_passes_and_finds_the_same);
    RUN_TEST(test_the_stated_memory_is_enough_for_two_passes);
    RUN_TEST(test_what_is_not_asked_for_takes_no_memory);
    RUN_TEST(test_each_kind_by_itself_is_as_among_the_others);
    RUN_TEST(test_a_short_list_has_the_best);
    RUN_TEST(test_the_covariance_stays);
    RUN_TEST(test_points_beyond_4_sigma_do_not_count_where_they_are_left_out);
    RUN_TEST(test_options_are_checked);
    RUN_TEST(test_kinds_that_are_asked_for);
    RUN_TEST(test_clocks_without_their_memory_are_refused);
    RUN_TEST(test_views_of_three_points_have_no_loop);
    RUN_TEST(test_one_freedom_is_a_loop);
    RUN_TEST(test_of_a_target_that_stands_still_no_clock_is_told);
    RUN_TEST(test_the_unit_of_time_changes_no_fault);
    RUN_TEST(test_a_rig_beside_its_optimum_has_the_same_faults);
    RUN_TEST(test_a_board_in_the_plane_of_x_and_z_has_the_same_cameras);
    RUN_TEST(test_a_fault_of_a_camera_that_is_held_is_that_of_an_adjustment);
    RUN_TEST(test_a_fault_of_cameras_with_priors_is_that_of_an_adjustment);
    RUN_TEST(test_narrow_cameras_have_the_same_faults_whichever_is_held);
    RUN_TEST(test_clocks_need_not_be_written);
    RUN_TEST(test_placements_that_nothing_fixes_are_degenerate);
    RUN_TEST(test_the_origin_of_the_board_changes_no_fault);
    RUN_TEST(test_the_order_of_points_changes_no_fault);
    RUN_TEST(test_placements_count_that_a_camera_saw);
    RUN_TEST(test_a_camera_with_one_view_has_faults);
    RUN_TEST(test_a_move_has_views_on_both_sides);
    RUN_TEST(test_a_move_is_tried_once_between_two_views);
    RUN_TEST(test_each_fault_is_listed_once);
    RUN_TEST(test_without_motion_nothing_lies_along_it);
    RUN_TEST(test_the_pattern_is_that_of_all_views);
    RUN_TEST(test_the_limit_of_truncation_is_4_sigma);
    RUN_TEST(test_a_view_that_is_wrong_is_named);
    RUN_TEST(test_arguments_are_checked_from_both_sides);
    RUN_TEST(test_what_is_behind_the_cameras_of_the_rig_does_not_matter);
    RUN_TEST(test_the_clocks_of_eight_cameras_have_room_for_their_test);
    RUN_TEST(test_memory_is_of_the_first_piece_that_has_it);
    RUN_TEST(test_free_clocks_are_counted_from_camera_0);
}
