/* adjust: cameras and placements together at maximum likelihood. The truth: vectors of
 * dense least squares, exact pixels, and what noise does to many simulated rigs. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rigcal_solvers.h"
#include "test_fit.h"
#include "test_rigs.h"
#include "vectors_rig.h"

static test_rig r, other;

#define WANTS_RIGS(n) TEST_WANTS_RAM((n) * sizeof(test_rig) + 12000)

static void adjust(rigcal_rig_fit *fit, test_rig *which)
{
    int32_t at_fault = -2;

    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(fit, &at_fault, &which->rig));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
}

/* The largest turn and shift of any pose away from `truth`. */
static void furthest(double *turn, double *shift, const test_rig *from,
                     const rigcal_transform cams[], const rigcal_transform places[])
{
    *turn = *shift = 0;
    for (size_t i = 0; i < from->rig.n_cameras + from->rig.n_placements; i++) {
        const size_t f = i - from->rig.n_cameras;
        const int is_camera = i < from->rig.n_cameras;
        double d[6];

        test_step_between(d, is_camera ? &from->cams[i] : &from->places[f],
                          is_camera ? &cams[i] : &places[f]);
        *turn = fmax(*turn, test_norm(d));
        *shift = fmax(*shift, test_norm(&d[3]));
    }
}

/* ---- vectors ------------------------------------------------------------- */

static rigcal_real spreads[RIG_VIEW_ROWS][RIG_POINT_ROWS];

/* The rig of the vectors. `bumped`: camera 1 is where it was bumped to. */
static void rig_of_vectors(int bumped)
{
    memset(&r, 0, sizeof r);
    for (int c = 0; c < RIG_CAMERA_ROWS; c++) {
        const double *const row = RIG_CAMERA[c];

        r.camera[c] = test_camera(row);
        r.cams[c] =
            bumped ? test_transform(&row[21], &row[30]) : test_from_ypr(&row[15], &row[18]);
        r.priors[c].cam_from_rig = test_transform(&row[33], &row[42]);
        test_to_real(r.priors[c].Sigma, &row[45], 36);
    }
    for (int f = 0; f < RIG_PLACE_ROWS; f++) {
        r.places[f] = test_from_ypr(RIG_PLACE[f], &RIG_PLACE[f][3]);
    }
    for (int v = 0; v < RIG_VIEW_ROWS; v++) {
        for (int i = 0; i < RIG_POINT_ROWS; i++) {
            test_to_real(r.o[v][i].X_w, RIG_POINT[i], 3);
            test_to_real(r.o[v][i].uv, &RIG_VIEW[v][2 + 3 * i], 2);
            spreads[v][i] = RC(RIG_VIEW[v][4 + 3 * i]);
        }
        r.views[v].camera = (int32_t)RIG_VIEW[v][0];
        r.views[v].placement = (int32_t)RIG_VIEW[v][1];
        r.views[v].view =
            VIEW(&r.camera[r.views[v].camera], r.o[v], spreads[v], RIG_POINT_ROWS);
    }
    r.rig = (rigcal_rig){.cams_from_rig = r.cams,
                         .n_cameras = RIG_CAMERA_ROWS,
                         .rig_from_placements = r.places,
                         .n_placements = RIG_PLACE_ROWS,
                         .group = r.group,
                         .n_views = RIG_VIEW_ROWS,
                         .views = r.views,
                         .work = r.work,
                         .work_capacity = RIG_WORK};
}

/* Each element is compared to a part of sqrt(Sigma_ii Sigma_jj). */
static void assert_covariance(const double expected[36], const rigcal_real seen[36],
                              double part)
{
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++) {
            const double size = sqrt(expected[7 * i] * expected[7 * j]);

            ASSERT_NEAR(expected[6 * i + j], seen[6 * i + j], part * size);
        }
    }
}

static void assert_answers(int kind, const rigcal_rig_fit *fit, double tol, double part)
{
    int n = 0;

    for (int k = 0; k < RIG_ANSWER_ROWS; k++) {
        const double *const row = RIG_ANSWER[k];
        const size_t which = (size_t)row[2];
        rigcal_transform expected, pair;
        rigcal_real Sigma[36];

        if ((int)row[0] != kind) {
            continue;
        }
        n++;
        expected = test_transform(&row[3], &row[12]);
        ASSERT_NEAR(row[15], fit->sum, TOL(1e-8, 1e-3) * row[15]);
        if ((int)row[1] == 0) {
            ASSERT_TRANSFORM(&expected, &r.cams[which], tol, 4 * tol);
            ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(Sigma, &r.rig, 1, which));
        } else if ((int)row[1] == 1) {
            ASSERT_TRANSFORM(&expected, &r.places[which], tol, 4 * tol);
            ASSERT_STATUS(RIGCAL_OK, rigcal_rig_placement(Sigma, &r.rig, 1, which));
        } else {
            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_rig_pair(&pair, Sigma, &r.rig, 1, which / 3, which % 3));
            ASSERT_TRANSFORM(&expected, &pair, tol, 4 * tol);
        }
        assert_covariance(&row[16], Sigma, part);
    }
    TEST_ASSERT_EQUAL_INT(11, n);
}

static void assert_noise(int kind, double part)
{
    rigcal_real sigma_px[3], freedom[3];

    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_noise(sigma_px, freedom, &r.rig));
    for (int k = 0; k < RIG_NOISE_ROWS; k++) {
        const double *const row = RIG_NOISE[k];
        const int c = (int)row[1];

        if ((int)row[0] == kind) {
            ASSERT_NEAR(row[3], freedom[c], part * row[3]);
            ASSERT_NEAR(sqrt(row[2] / row[3]), sigma_px[c], part);
        }
    }
}

static void test_all_poses_and_covariances_are_those_of_dense_least_squares(void)
{
    rigcal_rig_fit fit;

    WANTS_RIGS(1);
    rig_of_vectors(0);
    adjust(&fit, &r);
    ASSERT_NEAR(0, fit.F, 0);
    assert_answers(0, &fit, TOL(1e-7, 2e-5), TOL(1e-4, 1e-2));
    assert_noise(0, TOL(1e-5, 1e-3));
    ASSERT_NEAR(2 * 8 * 14 - 12 - 30, fit.freedom, 0);
    ASSERT_NEAR(sqrt(RIG_ANSWER[0][15] / 182), fit.sigma_px, TOL(1e-8, 1e-3));
    TEST_ASSERT_EQUAL_UINT64(8 * 14, fit.n_points);
}

/* Where no view is at fault, none is named. */
static void test_too_little_memory_is_no_views_fault(void)
{
    rigcal_rig_fit fit;
    int32_t at_fault = 0;

    WANTS_RIGS(1);
    rig_of_vectors(0);
    r.rig.work_capacity = rigcal_rig_work(2, 3, r.rig.n_placements) - 1;
    ASSERT_REFUSED(RIGCAL_ERR_CAPACITY, fit, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
    r.rig.work_capacity++;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
}

static void test_a_role_that_is_none_is_no_views_fault(void)
{
    rigcal_rig_fit fit;
    int32_t at_fault = 0;

    WANTS_RIGS(1);
    rig_of_vectors(0);
    memset(r.roles, RIGCAL_CAMERA_FREE, sizeof r.roles);
    r.rig.roles = r.roles;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
    r.roles[1] = RIGCAL_CAMERA_PRIOR + 1;
    at_fault = 0;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, fit, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
}

/* Where all cameras are held there is no covariance of theirs to work with. */
static void test_where_all_cameras_are_held_less_memory_is_enough(void)
{
    test_rng rng = test_seed(334);
    rigcal_rig_fit fit;
    int32_t at_fault;

    WANTS_RIGS(1);
    test_rig_random(&r, &rng, 3, 4, 8);
    test_rig_see_all(&r, &rng, 0.3);
    memset(r.roles, RIGCAL_CAMERA_HELD, sizeof r.roles);
    r.rig.roles = r.roles;
    r.rig.work_capacity = rigcal_rig_work(0, 3, 4) - 1;
    ASSERT_REFUSED(RIGCAL_ERR_CAPACITY, fit, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
    r.rig.work_capacity++;
    adjust(&fit, &r);
}

/* What was considered belongs to the rig as it was before. */
static void test_an_adjustment_forgets_what_was_considered(void)
{
    static const rigcal_considered considered = {0};
    test_rng rng = test_seed(335);
    rigcal_rig_fit fit;

    WANTS_RIGS(1);
    test_rig_random(&r, &rng, 2, 3, 8);
    test_rig_see_all(&r, &rng, 0.3);
    r.rig.considered = &considered;
    adjust(&fit, &r);
    TEST_ASSERT_NULL(r.rig.considered);
}

static void test_one_camera_is_solved_again_with_the_others_held(void)
{
    static const uint8_t ROLES[3] = {RIGCAL_CAMERA_HELD, RIGCAL_CAMERA_HELD,
                                     RIGCAL_CAMERA_FREE};
    rigcal_transform before[2];
    rigcal_rig_fit fit;

    WANTS_RIGS(1);
    rig_of_vectors(1);
    memcpy(before, r.cams, sizeof before);
    r.rig.roles = ROLES;
    adjust(&fit, &r);
    TEST_ASSERT_EQUAL_MEMORY(before, r.cams, sizeof before);
    assert_answers(1, &fit, TOL(1e-7, 2e-5), TOL(1e-4, 1e-2));
    assert_noise(1, TOL(1e-5, 1e-3));
    ASSERT_NEAR(2 * 8 * 14 - 6 - 30, fit.freedom, 0);
}

/* RIG uses -1 for the derivative of the deviation from a prior. This is wrong by half the
 * deviation: some 1e-3 of the error of the priors' angles. */
static void test_what_is_known_beforehand_counts_by_its_covariance(void)
{
    static const uint8_t ROLES[3] = {RIGCAL_CAMERA_FREE, RIGCAL_CAMERA_PRIOR,
                                     RIGCAL_CAMERA_PRIOR};
    rigcal_rig_fit fit;

    WANTS_RIGS(1);
    rig_of_vectors(0);
    r.rig.roles = ROLES;
    r.rig.priors = r.priors;
    r.rig.sigma_px = RC(0.4);
    adjust(&fit, &r);
    assert_answers(2, &fit, TOL(1e-6, 2e-5), TOL(1e-3, 1e-2));
    assert_noise(2, TOL(1e-3, 1e-3));
    ASSERT_NEAR(2 * 8 * 14 - 6 - 30, fit.freedom, 0);
}

static void test_the_loop_closure_is_that_of_the_vectors(void)
{
    rigcal_rig_fit fit;
    double own = 0;

    WANTS_RIGS(1);
    rig_of_vectors(0);
    for (int v = 0; v < RIG_VIEW_ROWS; v++) {
        rigcal_pose pose[RIGCAL_POSES_MAX];
        rigcal_pose_options options;
        size_t n;

        ASSERT_STATUS(RIGCAL_OK, rigcal_pose_defaults(&options));
        options.use_start = 1;
        options.start =
            test_times(&r.cams[r.views[v].camera], &r.places[r.views[v].placement]);
        TEST_ASSERT_TRUE(rigcal_pose_solve(pose, RIGCAL_POSES_MAX, &n, NULL,
                                           &r.views[v].view, &options) >= 0);
        ASSERT_STATUS(RIGCAL_OK, rigcal_view_pose_make(&r.own[v], &r.views[v],
                                                       &pose[0].cam_from_world));
        own += D(r.own[v].sse);
    }
    ASSERT_NEAR(RIG_CLOSURE[0][0], own, TOL(1e-8, 1e-2));
    r.rig.view_poses = r.own;
    adjust(&fit, &r);
    ASSERT_NEAR(RIG_CLOSURE[0][1], fit.F, TOL(1e-7, 1e-2));
    ASSERT_NEAR(RIG_CLOSURE[0][2], fit.freedom_between, 0);
    ASSERT_NEAR(RIG_CLOSURE[0][3], fit.freedom_within, 0);
}

/* ---- steps --------------------------------------------------------------- */

static void test_the_budget_changes_no_bit(void)
{
    static const int32_t BUDGETS[] = {1, 2, 7, 100};
    test_rng rng = test_seed(321);
    rigcal_rig_fit fit, stepped;

    WANTS_RIGS(2);
    test_rig_random(&r, &rng, 3, 4, 8);
    test_rig_see_all(&r, &rng, 0.3);
    test_rig_start(&r, &rng, 0.01, 0.03);
    memcpy(other.cams, r.cams, sizeof r.cams);
    memcpy(other.places, r.places, sizeof r.places);
    adjust(&fit, &r);
    for (int k = 0; k < 4; k++) {
        rigcal_rig rig = r.rig;
        rigcal_rig_solver solver;
        rigcal_transform cams[RIG_CAMERAS_MAX], places[RIG_PLACEMENTS_MAX];
        int32_t at_fault;

        memcpy(cams, other.cams, sizeof cams);
        memcpy(places, other.places, sizeof places);
        rig.cams_from_rig = cams;
        rig.rig_from_placements = places;
        rig.work = other.work;
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_begin(&solver, &rig));
        ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_rig_result(&stepped, &at_fault, &solver));
        while (rigcal_rig_step(&solver, BUDGETS[k]) == RIGCAL_RUNNING) {
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_result(&stepped, &at_fault, &solver));
        TEST_ASSERT_EQUAL_MEMORY(r.cams, cams, sizeof cams);
        TEST_ASSERT_EQUAL_MEMORY(r.places, places, sizeof places);
        TEST_ASSERT_TRUE(fit.sum == stepped.sum && fit.evals == stepped.evals);
    }
}

/* A unit is one view, one row or one slot. A rig that converges takes this many. */
static void test_a_step_is_small(void)
{
    test_rng rng = test_seed(322);
    rigcal_rig_solver solver;
    rigcal_rig_fit fit;
    size_t units = 1, expected;
    int32_t at_fault;

    WANTS_RIGS(1);
    test_rig_random(&r, &rng, 3, 4, 8);
    test_rig_see_all(&r, &rng, 0.3);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_begin(&solver, &r.rig));
    while (rigcal_rig_step(&solver, 1) == RIGCAL_RUNNING) {
        units++;
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_result(&fit, &at_fault, &solver));
    TEST_ASSERT_TRUE(fit.evals >= 4 && fit.evals % 2 == 0);
    /* all views are checked; the first pass has 12 views, 12 slots, 3 priors and 12 rows;
     * each step that is tried settles 12 views before it; so does the last, without
     * equations; twice 12 rows at the end */
    expected = 12 + 1 + (12 + 12 + 3 + 12) + 12 + 24;
    expected += (size_t)(fit.evals - 2) / 2 * (12 + 12 + 12 + 3 + 12);
    TEST_ASSERT_EQUAL_size_t(expected, units);
}

/* ---- exact pixels -------------------------------------------------------- */

static void test_exact_pixels_give_the_truth_from_bad_starts(void)
{
    test_rng rng = test_seed(323);

    WANTS_RIGS(1);
    for (int trial = 0; trial < TEST_TRIALS(40); trial++) {
        rigcal_rig_fit fit;
        double turn, shift;

        test_rig_random(&r, &rng, 2 + trial % 3, 3 + trial % 5, 8);
        test_rig_see_all(&r, &rng, 0);
        test_rig_start(&r, &rng, 0.1, 0.1);
        adjust(&fit, &r);
        furthest(&turn, &shift, &r, r.true_cams, r.true_places);
        TEST_ASSERT_TRUE(turn < TOL(1e-9, 1e-4) && shift < TOL(1e-8, 5e-4));
        TEST_ASSERT_TRUE(D(fit.sigma_px) < TOL(1e-9, 1e-3));
    }
}

/* From a start that is wrong by 0.1 rad the answer is the same as from the truth. */
static void test_bad_starts_end_in_the_same_minimum(void)
{
    test_rng rng = test_seed(324);

    WANTS_RIGS(2);
    for (int trial = 0; trial < TEST_TRIALS(40); trial++) {
        rigcal_rig_fit good, bad;
        double turn, shift;

        test_rig_random(&r, &rng, 3, 5, 8);
        test_rig_see_all(&r, &rng, 0.3);
        adjust(&good, &r);
        memcpy(other.cams, r.cams, sizeof r.cams);
        memcpy(other.places, r.places, sizeof r.places);
        test_rig_start(&r, &rng, 0.1, 0.2);
        adjust(&bad, &r);
        furthest(&turn, &shift, &r, other.cams, other.places);
        TEST_ASSERT_TRUE(turn < TOL(1e-7, 1e-4) && shift < TOL(5e-7, 5e-4));
        ASSERT_NEAR(good.sum, bad.sum, TOL(1e-9, 1e-3) * D(good.sum));
    }
}

static int compare(const void *a, const void *b)
{
    return *(const int32_t *)a - *(const int32_t *)b;
}

/* After a search that ends with a damped step, the equations are made once more, because
 * the covariance is that of undamped ones. */
static void test_a_search_ends_with_equations_that_are_not_damped(void)
{
    test_rng rng = test_seed(325);
    int n_final = 0;

    WANTS_RIGS(1);
    for (int trial = 0; trial < TEST_TRIALS(40); trial++) {
        rigcal_transform cams[RIG_CAMERAS_MAX], places[RIG_PLACEMENTS_MAX];
        rigcal_rig_solver solver;
        rigcal_real first[36], again[36];
        double expected[36];
        rigcal_rig_fit fit;
        int was_final = 0;

        test_rig_random(&r, &rng, 3, 5, 8);
        test_rig_see_all(&r, &rng, 0.3);
        test_rig_start(&r, &rng, 0.25, 0.4);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_begin(&solver, &r.rig));
        while (rigcal_rig_step(&solver, 1) == RIGCAL_RUNNING) {
            if (!was_final) {
                memcpy(cams, r.cams, sizeof cams);
                memcpy(places, r.places, sizeof places);
                was_final = solver.is_final;
            }
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_result(&fit, NULL, &solver));
        TEST_ASSERT_TRUE(!(solver.search.lambda > 0));
        if (was_final) { /* they move nothing */
            TEST_ASSERT_EQUAL_MEMORY(cams, r.cams, sizeof cams);
            TEST_ASSERT_EQUAL_MEMORY(places, r.places, sizeof places);
            n_final++;
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(first, &r.rig, 1, 2));
        adjust(&fit, &r); /* starts in the minimum: nothing is damped */
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(again, &r.rig, 1, 2));
        test_to_double(expected, again, 36);
        assert_covariance(expected, first, TOL(1e-4, 1e-2));
    }
    TEST_ASSERT_TRUE(n_final > 0 || TEST_ONE_IN > 1);
}

static void test_from_the_join_few_evaluations_are_enough(void)
{
    enum { TRIALS = 61 };
    static int32_t evals[TRIALS];
    test_rng rng = test_seed(325);

    TEST_ON_HOST_ONLY("a median of many");
    for (int trial = 0; trial < TRIALS; trial++) {
        rigcal_rig_fit fit;
        int32_t at_fault;

        test_rig_random(&r, &rng, 3, 6, 8);
        test_rig_see_all(&r, &rng, 0.3);
        test_rig_solve_views(&r);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_join(&r.rig, &at_fault));
        adjust(&fit, &r);
        evals[trial] = fit.evals;
    }
    qsort(evals, TRIALS, sizeof evals[0], compare);
    TEST_ASSERT_LESS_OR_EQUAL_INT32(6, evals[TRIALS / 2]);
}

/* ---- statistics ---------------------------------------------------------- */

static int is_inside(const rigcal_transform *seen, const rigcal_transform *truth,
                     const rigcal_real Sigma[36], double *chi2)
{
    double d[6], full[36];

    test_step_between(d, seen, truth);
    test_to_double(full, Sigma, 36);
    *chi2 = test_squared_distance(d, full, 6);
    return *chi2 < 12.5916; /* 95 % of chi square of 6 */
}

/* With 2000 rigs three standard errors are: 1.5 % of 95 %; 2 % of the root of the mean of
 * chi square / 6; 1.7 % of the mean of F. */
static void test_sigmas_and_the_loop_closure_say_what_noise_does(void)
{
    enum { RIGS = 2000 };
    const double sigma = 0.3;
    test_rng rng = test_seed(326);
    double inside[3] = {0, 0, 0}, ratio = 0, mean = 0, d2 = 1;

    TEST_ON_HOST_ONLY("shares of many rigs");
    for (int trial = 0; trial < RIGS; trial++) {
        rigcal_transform pair, back, b_from_a;
        rigcal_rig_fit fit;
        rigcal_real Sigma[36];
        double chi2;

        test_rig_random(&r, &rng, 3, 5, 8);
        test_rig_see_all(&r, &rng, sigma);
        test_rig_solve_views(&r);
        adjust(&fit, &r);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(Sigma, &r.rig, RC(sigma), 2));
        inside[0] += is_inside(&r.cams[2], &r.true_cams[2], Sigma, &chi2);
        ratio += chi2 / 6 / RIGS;
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_pair(&pair, Sigma, &r.rig, RC(sigma), 1, 2));
        back = test_inverse(&r.true_cams[1]);
        b_from_a = test_times(&r.true_cams[2], &back);
        inside[1] += is_inside(&pair, &b_from_a, Sigma, &chi2);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_placement(Sigma, &r.rig, RC(sigma), 3));
        inside[2] += is_inside(&r.places[3], &r.true_places[3], Sigma, &chi2);
        mean += D(fit.F) / RIGS;
        d2 = D(fit.freedom_within);
    }
    ASSERT_NEAR(1, sqrt(ratio), 0.025);
    for (int k = 0; k < 3; k++) {
        ASSERT_NEAR(0.95, inside[k] / RIGS, 0.02);
    }
    ASSERT_NEAR(d2 / (d2 - 2), mean, 0.02);
}

/* The relative pose of two cameras is the same whichever camera is held. */
static void test_a_pair_does_not_depend_on_which_camera_is_held(void)
{
    test_rng rng = test_seed(327);
    rigcal_transform pair, again;
    rigcal_real Sigma[36], Sigma_again[36];
    double expected[36];
    rigcal_rig_fit fit;

    WANTS_RIGS(1);
    test_rig_random(&r, &rng, 3, 5, 8);
    test_rig_see_all(&r, &rng, 0.3);
    adjust(&fit, &r);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_pair(&pair, Sigma, &r.rig, 1, 0, 1));
    r.roles[2] = RIGCAL_CAMERA_HELD;
    r.rig.roles = r.roles;
    adjust(&fit, &r);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_pair(&again, Sigma_again, &r.rig, 1, 0, 1));
    ASSERT_TRANSFORM(&pair, &again, TOL(1e-7, 1e-4), TOL(1e-6, 5e-4));
    test_to_double(expected, Sigma, 36);
    assert_covariance(expected, Sigma_again, TOL(1e-5, 2e-2));
}

static void test_residuals_are_observed_less_projected(void)
{
    test_rng rng = test_seed(328);
    rigcal_real duv[2 * RIG_POINTS_MAX];
    rigcal_rig_fit fit;
    double sum = 0;
    size_t n;

    WANTS_RIGS(1);
    test_rig_random(&r, &rng, 2, 3, 8);
    test_rig_see_all(&r, &rng, 0.3);
    adjust(&fit, &r);
    for (size_t v = 0; v < r.rig.n_views; v++) {
        const rigcal_transform T =
            test_times(&r.cams[r.views[v].camera], &r.places[r.views[v].placement]);

        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_residuals(duv, 16, &n, &r.rig, v));
        TEST_ASSERT_EQUAL_UINT64(8, n);
        for (size_t i = 0; i < n; i++) {
            double X_c[3], uv[2];

            test_move_point(X_c, &T, r.X[i]);
            test_project_px(uv, &r.camera[r.views[v].camera], X_c);
            for (int k = 0; k < 2; k++) {
                ASSERT_NEAR(D(r.o[v][i].uv[k]) - uv[k], duv[2 * i + (size_t)k],
                            TOL(1e-9, 2e-3));
                sum += D(duv[2 * i + (size_t)k]) * D(duv[2 * i + (size_t)k]);
            }
        }
    }
    ASSERT_NEAR(sum, fit.sum, TOL(1e-8, 1e-3) * sum);
}

/* All points of placement 1 are one point, seen by six views or more: nothing shows how the
 * placement is turned. No step is taken. */
static void test_a_placement_that_its_views_do_not_fix_is_degenerate(void)
{
    test_rng rng = test_seed(329);
    rigcal_transform cams[RIG_CAMERAS_MAX], places[RIG_PLACEMENTS_MAX];
    rigcal_rig_fit fit;
    int32_t at_fault;

    WANTS_RIGS(1);
    test_rig_random(&r, &rng, 2, 2, 8);
    test_rig_see_all(&r, &rng, 0);
    test_rig_start(&r, &rng, 0.01, 0.01);
    for (size_t v = 2; v < 4; v++) {
        for (int i = 1; i < 8; i++) {
            r.o[v][i] = r.o[v][0];
        }
    }
    memcpy(cams, r.cams, sizeof cams);
    memcpy(places, r.places, sizeof places);
    FILL(fit);
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
    ASSERT_UNTOUCHED(fit);
    TEST_ASSERT_EQUAL_INT32(3, at_fault);
    TEST_ASSERT_EQUAL_MEMORY(cams, r.cams, sizeof cams);
    TEST_ASSERT_EQUAL_MEMORY(places, r.places, sizeof places);
}

/* A source of views that fails once, in the call of number `fails`. */
static struct {
    int calls, fails;
    size_t view; /* that was asked for when it failed */
} asked;

static rigcal_status fails_once(rigcal_rig_view *view, size_t index, void *context)
{
    (void)context;
    *view = r.views[index];
    if (++asked.calls == asked.fails) {
        asked.view = index;
        return RIGCAL_ERR_DAMAGED;
    }
    return RIGCAL_OK;
}

/* Whenever a view cannot be read, the search ends. A step that was tried is not to
 * blame. */
static void test_a_view_that_cannot_be_read_ends_the_search(void)
{
    int n = 0;

    WANTS_RIGS(1);
    for (int k = 0; k == 0 || k <= n; k++) {
        test_rng rng = test_seed(333);
        rigcal_rig_fit fit;
        int32_t at_fault;

        test_rig_random(&r, &rng, 2, 3, 6);
        test_rig_see_all(&r, &rng, 0.3);
        test_rig_start(&r, &rng, 0.1, 0.1);
        r.rig.views = NULL;
        r.rig.view_source = fails_once;
        asked.calls = 0;
        asked.fails = k;
        if (k == 0) {
            adjust(&fit, &r);
            n = asked.calls;
            TEST_ASSERT_TRUE(fit.evals > 3);
            continue;
        }
        ASSERT_REFUSED(RIGCAL_ERR_DAMAGED, fit, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
        TEST_ASSERT_EQUAL_INT(k, asked.calls); /* nothing is read after it */
        TEST_ASSERT_EQUAL_INT32((int32_t)asked.view, at_fault);
    }
}

/* The cameras of r, numbered from the last to the first. The one that was camera 0 is
 * held. */
static void number_from_the_last(void)
{
    const int n = (int)r.rig.n_cameras;

    for (size_t v = 0; v < r.rig.n_views; v++) {
        r.views[v].camera = n - 1 - r.views[v].camera;
    }
    for (int c = 0; c < n / 2; c++) {
        const rigcal_transform first = r.cams[c];

        r.cams[c] = r.cams[n - 1 - c];
        r.cams[n - 1 - c] = first;
    }
    memset(r.roles, RIGCAL_CAMERA_FREE, sizeof r.roles);
    r.roles[n - 1] = RIGCAL_CAMERA_HELD;
    r.rig.roles = r.roles;
}

/* From starts so bad that a step may take a target behind a camera, whichever number that
 * camera has: the step is taken back. */
static void test_the_numbers_of_the_cameras_do_not_matter(void)
{
    test_rng rng = test_seed(336);
    int n_damped = 0;

    WANTS_RIGS(1);
    for (int trial = 0; trial < TEST_TRIALS(40); trial++) {
        const test_rng before = rng;
        rigcal_rig_fit fit[2];
        rigcal_status status[2];

        for (int way = 0; way < 2; way++) {
            rng = before;
            test_rig_random(&r, &rng, 3, 5, 8);
            test_rig_see_all(&r, &rng, 0.3);
            test_rig_start(&r, &rng, 0.5, 0.8);
            if (way) {
                number_from_the_last();
            }
            status[way] = rigcal_rig_adjust(&fit[way], NULL, &r.rig);
        }
        TEST_ASSERT_EQUAL_INT(status[0], status[1]);
        if (status[0] == RIGCAL_OK) {
            ASSERT_NEAR(D(fit[0].sum), fit[1].sum, TOL(1e-6, 1e-3) * D(fit[0].sum));
            n_damped += fit[0].evals > 12;
        }
    }
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || n_damped > 3);
}

/* All lengths, in another unit: points, and where the search starts. */
static void change_unit(double unit)
{
    for (size_t v = 0; v < r.rig.n_views; v++) {
        for (int i = 0; i < r.n_points; i++) {
            for (int k = 0; k < 3; k++) {
                r.o[v][i].X_w[k] *= RC(unit);
            }
        }
    }
    for (int i = 0; i < RIG_CAMERAS_MAX + RIG_PLACEMENTS_MAX; i++) {
        for (int k = 0; k < 3; k++) {
            if (i < RIG_CAMERAS_MAX) {
                r.cams[i].t[k] *= RC(unit);
            } else {
                r.places[i - RIG_CAMERAS_MAX].t[k] *= RC(unit);
            }
        }
    }
}

/* Lengths in units that are a metre times a power of two. Turns and pixels are the same,
 * and lengths are as many units more or fewer. */
static void test_the_unit_of_length_does_not_matter(void)
{
    static const int POWER[3] = {10, RIGCAL_USE_FLOAT ? -20 : -30,
                                 RIGCAL_USE_FLOAT ? 20 : 30};

    WANTS_RIGS(1);
    for (int trial = 0; trial < 3; trial++) {
        rigcal_transform cams[RIG_CAMERAS_MAX], places[RIG_PLACEMENTS_MAX];
        rigcal_rig_fit metres, units;
        double turn, shift;

        for (int is_other = 0; is_other < 2; is_other++) {
            test_rng rng = test_seed(332);

            test_rig_random(&r, &rng, 3, 5, 8);
            test_rig_see_all(&r, &rng, 0.3);
            test_rig_start(&r, &rng, 0.03, 0.03);
            if (is_other) {
                change_unit(ldexp(1, POWER[trial]));
                adjust(&units, &r);
                change_unit(ldexp(1, -POWER[trial]));
            } else {
                adjust(&metres, &r);
                memcpy(cams, r.cams, sizeof cams);
                memcpy(places, r.places, sizeof places);
            }
        }
        furthest(&turn, &shift, &r, cams, places);
        TEST_ASSERT_TRUE(turn < TOL(1e-9, 1e-4) && shift < TOL(1e-9, 1e-4));
        ASSERT_NEAR(D(metres.sum), units.sum, TOL(1e-9, 1e-4) * D(metres.sum));
    }
}

/* If all evaluations are spent, a search that could still gain ends with BUDGET_SPENT. A
 * search that has arrived does not. */
static void test_the_evaluations_are_bounded(void)
{
    WANTS_RIGS(1);
    for (int is_far = 0; is_far < 2; is_far++) {
        test_rng rng = test_seed(330);
        rigcal_rig_solver solver;
        rigcal_rig_fit fit;

        test_rig_random(&r, &rng, 3, 4, 8);
        test_rig_see_all(&r, &rng, 0.3);
        if (is_far) {
            test_rig_start(&r, &rng, 0.1, 0.1);
        } else {
            adjust(&fit, &r);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_begin(&solver, &r.rig));
        while (solver.n_points == 0 || solver.evals == 0) {
            ASSERT_STATUS(RIGCAL_RUNNING, rigcal_rig_step(&solver, 1));
        }
        solver.evals = 200; /* this one is the last */
        while (rigcal_rig_step(&solver, 100) == RIGCAL_RUNNING) {
        }
        ASSERT_STATUS(is_far ? RIGCAL_BUDGET_SPENT : RIGCAL_OK,
                      rigcal_rig_result(&fit, NULL, &solver));
        TEST_ASSERT_TRUE(is_far ? fit.evals == 200 : fit.evals <= 202);
    }
}

/* After a damped step that helped all evaluations are spent. The equations that follow are
 * for the covariance, and move nothing. */
static void test_after_the_last_evaluation_nothing_moves(void)
{
    test_rng rng = test_seed(331);
    int n_spent = 0;

    WANTS_RIGS(1);
    for (int trial = 0; trial < TEST_TRIALS(40); trial++) {
        rigcal_transform cams[RIG_CAMERAS_MAX], places[RIG_PLACEMENTS_MAX];
        rigcal_rig_solver solver;
        rigcal_rig_fit fit;

        test_rig_random(&r, &rng, 3, 5, 8);
        test_rig_see_all(&r, &rng, 0.3);
        test_rig_start(&r, &rng, 0.5, 0.8);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_begin(&solver, &r.rig));
        while (solver.search.status == RIGCAL_RUNNING) {
            (void)rigcal_rig_step(&solver, 1);
            if (solver.search.lambda > 0 && solver.search.last_gain > 0) {
                solver.evals = 200;
            }
        }
        memcpy(cams, r.cams, sizeof cams);
        memcpy(places, r.places, sizeof places);
        while (rigcal_rig_step(&solver, 1) == RIGCAL_RUNNING) {
        }
        if (rigcal_rig_result(&fit, NULL, &solver) == RIGCAL_BUDGET_SPENT) {
            TEST_ASSERT_EQUAL_MEMORY(cams, r.cams, sizeof cams);
            TEST_ASSERT_EQUAL_MEMORY(places, r.places, sizeof places);
            n_spent++;
        }
    }
    TEST_ASSERT_TRUE(n_spent > 0 || TEST_ONE_IN > 1);
}

TEST_MAIN()
{
    RUN_TEST(test_all_poses_and_covariances_are_those_of_dense_least_squares);
    RUN_TEST(test_too_little_memory_is_no_views_fault);
    RUN_TEST(test_a_role_that_is_none_is_no_views_fault);
    RUN_TEST(test_where_all_cameras_are_held_less_memory_is_enough);
    RUN_TEST(test_an_adjustment_forgets_what_was_considered);
    RUN_TEST(test_one_camera_is_solved_again_with_the_others_held);
    RUN_TEST(test_what_is_known_beforehand_counts_by_its_covariance);
    RUN_TEST(test_the_loop_closure_is_that_of_the_vectors);
    RUN_TEST(test_the_budget_changes_no_bit);
    RUN_TEST(test_a_step_is_small);
    RUN_TEST(test_exact_pixels_give_the_truth_from_bad_starts);
    RUN_TEST(test_bad_starts_end_in_the_same_minimum);
    RUN_TEST(test_a_search_ends_with_equations_that_are_not_damped);
    RUN_TEST(test_from_the_join_few_evaluations_are_enough);
    RUN_TEST(test_sigmas_and_the_loop_closure_say_what_noise_does);
    RUN_TEST(test_a_pair_does_not_depend_on_which_camera_is_held);
    RUN_TEST(test_residuals_are_observed_less_projected);
    RUN_TEST(test_a_placement_that_its_views_do_not_fix_is_degenerate);
    RUN_TEST(test_a_view_that_cannot_be_read_ends_the_search);
    RUN_TEST(test_the_numbers_of_the_cameras_do_not_matter);
    RUN_TEST(test_the_unit_of_length_does_not_matter);
    RUN_TEST(test_the_evaluations_are_bounded);
    RUN_TEST(test_after_the_last_evaluation_nothing_moves);
}
