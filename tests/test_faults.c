/* faults: why the views of a rig disagree. The truth: tests/vectors, where one dense system
 * of all unknowns is solved, its derivatives by complex steps; and adjustments with the
 * fault free. */
#include <math.h>
#include <string.h>

#include "rigcal_solvers.h"
#include "test_support.h"
#include "vectors_faults.h"

enum { CAMERAS = 3, PLACEMENTS = 6, VIEWS = CAMERAS * PLACEMENTS, POINTS = 9, FAULTS = 40 };

/* A rig of the vectors, and what is found of it. */
typedef struct {
    rigcal_camera camera[CAMERAS];
    rigcal_observation o[VIEWS][POINTS];
    rigcal_rig_view views[VIEWS];
    rigcal_transform cams[CAMERAS], places[PLACEMENTS];
    rigcal_real times[PLACEMENTS], instants[PLACEMENTS], offsets[CAMERAS];
    int32_t states[CAMERAS], group[CAMERAS];
    rigcal_real work[RIGCAL_RIG_WORK(CAMERAS, CAMERAS, PLACEMENTS) +
                     RIGCAL_CLOCKS_WORK(CAMERAS, CAMERAS)];
    rigcal_real room[RIGCAL_FAULTS_WORK(CAMERAS, CAMERAS)], clocks[2 * CAMERAS];
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

/* The adjustment of a float build ends where its own rounding is; the truth, 1e-6 sigma
 * off the optimum. */
static void assert_fault(const double row[], const rigcal_fault *seen)
{
    const double *const theta = &row[4], *const sigma = &row[10];
    const double part = TOL(1e-6, 5e-3), of_sigma = TOL(1e-6, 5e-3), gain = row[16];
    const double noise2 = D(x.found.sigma_px) * D(x.found.sigma_px);
    const int is_moved = seen->kind == RIGCAL_FAULT_MOVED;
    /* Six parameters of one camera hang together: in float they lose digits. */
    const double loss = is_moved ? TOL(1, 100) : 1;

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

/* One step against an adjustment in which the fault is free. */
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
    test_it(&x);
    const rigcal_fault *const all = fault_of(&x, RIGCAL_FAULT_CLOCKS, -1);

    ASSERT_NEAR(0, x.clocks[0], 0);
    for (int c = 1; c < CAMERAS; c++) {
        ASSERT_NEAR(all->value[c - 1], x.clocks[c], 0);
        ASSERT_NEAR(all->sigma[c - 1], x.clocks[CAMERAS + c], 1e-6 * D(all->sigma[c - 1]));
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
    for (int c = 0; c < CAMERAS; c++) {
        TEST_ASSERT_EQUAL_INT32(0, fault_of(&x, RIGCAL_FAULT_CLOCK, c)->is_seen);
        TEST_ASSERT_EQUAL_INT32(0, fault_of(&x, RIGCAL_FAULT_SHUTTER, c)->is_seen);
    }
}

static void test_placements_far_apart_in_time_have_no_motion(void)
{
    rigcal_rig_fit fit;

    WANTS_A_RIG;
    set_up(&x, 1);
    for (int p = 0; p < PLACEMENTS; p++) {
        x.times[p] = RC(10 * p);
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &x.rig));
    test_it(&x);
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

static void assert_same(const fixture *a, const rigcal_faults *found,
                        const rigcal_fault faults[], double tol)
{
    TEST_ASSERT_EQUAL_INT32(a->found.n, found->n);
    ASSERT_NEAR(a->found.F, found->F, tol);
    for (int i = 0; i < found->n; i++) {
        const rigcal_fault *const other = fault_of(a, faults[i].kind, faults[i].camera);

        ASSERT_NEAR(other->gain, faults[i].gain, tol * (1 + D(other->gain)));
        TEST_ASSERT_EQUAL_INT32(other->is_seen, faults[i].is_seen);
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
    x.o[4][2].uv[0] += RC(40);
    x.rig.sigma_px = RC(0.3);
    x.options.is_truncated = 1;
    test_it(&x);
    ASSERT_NEAR(D(whole.sigma_px), x.found.sigma_px, 0.02);
    ASSERT_NEAR(D(whole.freedom_between), x.found.freedom_between, 0);
    ASSERT_NEAR(D(whole.freedom_within) - 2, x.found.freedom_within, 0);
}

TEST_MAIN()
{
    RUN_TEST(test_each_fault_is_that_of_dense_least_squares);
    RUN_TEST(test_what_the_views_have_in_common_is_that_of_dense_least_squares);
    RUN_TEST(test_a_fault_is_named_and_is_that_of_an_adjustment_with_it);
    RUN_TEST(test_the_clocks_are_told_one_by_one);
    RUN_TEST(test_without_times_no_clock_is_tested_and_that_is_told);
    RUN_TEST(test_placements_far_apart_in_time_have_no_motion);
    RUN_TEST(test_a_camera_without_views_has_no_faults);
    RUN_TEST(test_nothing_in_common_is_no_disagreement);
    RUN_TEST(test_the_budget_of_a_step_changes_no_bit);
    RUN_TEST(test_less_memory_takes_more_passes_and_finds_the_same);
    RUN_TEST(test_a_short_list_has_the_best);
    RUN_TEST(test_the_covariance_stays);
    RUN_TEST(test_points_beyond_4_sigma_do_not_count_where_they_are_left_out);
}
