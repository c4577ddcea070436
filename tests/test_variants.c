/* One rig in several forms: with a placement that nobody saw, a view that is left out, a
 * camera that is held, or a camera with a nearly exact prior. The results must be the
 * same. */
#include <string.h>

#include "rigcal_solvers.h"
#include "test_boards.h"

enum { CAMERAS = 4, PLACES = 6, SEEN = 3, EMPTY = 2, TURNED = 7 };

static const double NOISE = 0.3;

static test_boards b;
static rigcal_real
    memory[RIGCAL_FAULTS_WORK(CAMERAS, CAMERAS) + RIGCAL_CONSIDER_WORK(CAMERAS, CAMERAS)];
static rigcal_real more[RIGCAL_ESTIMATE_WORK(CAMERAS, CAMERAS)];
static rigcal_intrinsics_sigma sigmas[CAMERAS];
static uint8_t roles[CAMERAS];
static rigcal_camera_prior priors[CAMERAS];

#define WANTS_BOARDS \
    TEST_WANTS_RAM(sizeof(test_boards) + sizeof memory + sizeof more + 40000)

/* The results for the rig. */
typedef struct {
    double chosen[12], adjusted[12]; /* camera 2 */
    double sum, freedom, sigma_px, F;
    double noise[CAMERAS], own[CAMERAS];
    double covariance[36], considered[36], placement[36];
    double share, links;
    double explained, passes;
} outcome;

static void transform_of(double out[12], const rigcal_transform *T)
{
    test_transform_parts(out, out + 9, T);
}

static void links_of(outcome *o)
{
    rigcal_link found[RIGCAL_LINKS(CAMERAS)];
    int32_t n_groups, at_fault;

    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_links(found, RIGCAL_LINKS(CAMERAS), &n_groups,
                                              &at_fault, &b.rig));
    TEST_ASSERT_EQUAL_INT32(1, n_groups);
    for (size_t k = 0; k < RIGCAL_LINKS(CAMERAS); k++) {
        o->links += D(found[k].information) * (double)(k + 1);
    }
}

static void after_adjustment(outcome *o, size_t placement)
{
    rigcal_real sigma_px[CAMERAS], freedom[CAMERAS], Sigma[36];
    rigcal_considered considered = {0};
    rigcal_faults_options options = {0};
    rigcal_faults found;
    rigcal_fault faults[12];

    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_noise(sigma_px, freedom, &b.rig));
    test_to_double(o->noise, sigma_px, CAMERAS);
    test_to_double(o->own, freedom, CAMERAS);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(Sigma, &b.rig, 1, 2));
    test_to_double(o->covariance, Sigma, 36);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_placement(Sigma, &b.rig, 1, placement));
    test_to_double(o->placement, Sigma, 36);
    options.work = memory;
    options.work_capacity = sizeof memory / sizeof *memory;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_faults(&found, faults, 12, NULL, &options, &b.rig));
    o->explained = D(found.F);
    o->passes = found.n_seen;
    b.rig.intrinsics_sigmas = sigmas;
    considered.effects = memory;
    considered.capacity = sizeof memory / sizeof *memory;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &b.rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(Sigma, &b.rig, 1, 2));
    test_to_double(o->considered, Sigma, 36);
    b.rig.considered = NULL;
    b.rig.intrinsics_sigmas = NULL;
}

static outcome find(size_t placement)
{
    rigcal_rig_fit fit;
    int32_t at_fault;
    outcome o;

    memset(&o, 0, sizeof o);
    b.rig.sigma_px = RC(NOISE);
    links_of(&o);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_choose(&b.choice, &at_fault, &b.rig));
    o.share = D(b.choice.share);
    transform_of(o.chosen, &b.cams[2]);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_join(&b.rig, &at_fault));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, &at_fault, &b.rig));
    transform_of(o.adjusted, &b.cams[2]);
    o.sum = D(fit.sum);
    o.freedom = D(fit.freedom);
    o.sigma_px = D(fit.sigma_px);
    o.F = D(fit.F);
    after_adjustment(&o, placement);
    return o;
}

static void make(uint64_t seed)
{
    test_rng rng = test_seed(seed);

    test_boards_make(&b, &rng, CAMERAS, PLACES, SEEN, NOISE, 0);
    test_boards_solve(&b);
    for (int c = 0; c < CAMERAS; c++) {
        sigmas[c] = (rigcal_intrinsics_sigma){RC(1e-3), RC(1e-4), RC(0.5), 0, 0};
    }
}

/* Each number must agree to `tol` of the largest of its kind. */
static void assert_alike(const outcome *expected, const outcome *seen, double tol)
{
    const double *const e = (const double *)(const void *)expected;
    const double *const s = (const double *)(const void *)seen;
    static const int SIZES[] = {12, 12, 1,  1, 1, 1, CAMERAS, CAMERAS,
                                36, 36, 36, 1, 1, 1, 1};
    size_t at = 0;

    for (size_t k = 0; k < sizeof SIZES / sizeof *SIZES; k++) {
        double largest = 0;

        for (int i = 0; i < SIZES[k]; i++) {
            const double size =
                e[at + (size_t)i] < 0 ? -e[at + (size_t)i] : e[at + (size_t)i];
            largest = size > largest ? size : largest;
        }
        for (int i = 0; i < SIZES[k]; i++) {
            ASSERT_NEAR(e[at + (size_t)i], s[at + (size_t)i], tol * largest);
        }
        at += (size_t)SIZES[k];
    }
    TEST_ASSERT_EQUAL_size_t(sizeof(outcome), at * sizeof(double));
}

/* Inserts placement EMPTY, which no camera saw; the later ones move up by one. */
static void insert_a_placement(void)
{
    for (size_t v = 0; v < b.rig.n_views; v++) {
        b.views[v].placement += b.views[v].placement >= EMPTY;
        b.own[v].placement = b.views[v].placement;
    }
    b.rig.n_placements++;
}

static void test_a_placement_that_nobody_saw_changes_nothing(void)
{
    WANTS_BOARDS;
    make(4100);
    const outcome before = find(4);

    make(4100);
    insert_a_placement();
    const outcome after = find(5);

    assert_alike(&before, &after, TOL(1e-9, 1e-4));
}

static void remove_view(int gone)
{
    for (size_t v = (size_t)gone; v + 1 < b.rig.n_views; v++) {
        memcpy(b.o[v], b.o[v + 1], sizeof b.o[v]);
        b.own[v] = b.own[v + 1];
        b.views[v] = b.views[v + 1];
        b.views[v].view.observations = b.o[v];
    }
    b.rig.n_views--;
}

/* A view that is left out has the same effect as one that does not exist, whatever its
 * pixels. */
static void test_a_view_that_is_left_out_changes_nothing(void)
{
    WANTS_BOARDS;
    make(4200);
    remove_view(TURNED);
    const outcome before = find(4);

    make(4200);
    test_boards_reverse(&b, TURNED);
    test_boards_solve_view(&b, TURNED);
    b.left_out[TURNED] = 1;
    b.rig.left_out = b.left_out;
    const outcome after = find(4);

    assert_alike(&before, &after, TOL(1e-9, 1e-4));
}

/* The first camera is held by default. Held by its role it must give the same. */
static void test_a_camera_held_by_its_role(void)
{
    WANTS_BOARDS;
    make(4300);
    const outcome before = find(3);

    make(4300);
    memset(roles, 0, sizeof roles);
    roles[0] = RIGCAL_CAMERA_HELD;
    b.rig.roles = roles;
    const outcome after = find(3);

    assert_alike(&before, &after, TOL(1e-9, 1e-4));
}

/* A nearly exact prior has the effect of a held camera. It counts as 6 unknowns and 6
 * numbers that were known. */
static void test_a_sure_prior_is_as_a_camera_that_is_held(void)
{
    outcome before, after;

    WANTS_BOARDS;
    make(4400);
    before = find(3);
    make(4400);
    memset(roles, 0, sizeof roles);
    memset(priors, 0, sizeof priors);
    roles[0] = RIGCAL_CAMERA_PRIOR;
    priors[0].cam_from_rig = b.true_cams[0];
    for (int k = 0; k < 6; k++) {
        priors[0].Sigma[7 * k] = RC(TOL(1e-14, 1e-10));
    }
    b.rig.roles = roles;
    b.rig.priors = priors;
    after = find(3);
    assert_alike(&before, &after, TOL(1e-4, 2e-2));
}

/* A work array that says that a placement has more views than there are cameras. */
static void test_counts_that_cannot_be_are_refused(void)
{
    test_rng rng = test_seed(4500);
    rigcal_considered considered = {0};
    rigcal_real sigma_px[CAMERAS], freedom[CAMERAS], Sigma[36];
    rigcal_rig_fit fit;

    WANTS_BOARDS;
    test_boards_make(&b, &rng, CAMERAS, PLACES, CAMERAS, NOISE, 0);
    test_boards_solve(&b);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &b.rig));
    b.rig.intrinsics_sigmas = sigmas;
    sigmas[0] = (rigcal_intrinsics_sigma){RC(1e-3), RC(1e-4), RC(0.5), 0, 0};
    considered.effects = memory;
    considered.capacity = sizeof memory / sizeof *memory;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &b.rig));
    b.work[0] = CAMERAS + 1;
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_rig_consider(&considered, NULL, &b.rig));
    ASSERT_REFUSED(RIGCAL_ERR_STATE, sigma_px, rigcal_rig_noise(sigma_px, freedom, &b.rig));
    ASSERT_REFUSED(RIGCAL_ERR_STATE, Sigma, rigcal_rig_placement(Sigma, &b.rig, 1, 0));
}

static void test_a_rig_whose_views_are_all_left_out_is_refused(void)
{
    rigcal_link found[RIGCAL_LINKS(CAMERAS)];
    int32_t n_groups, at_fault = 0;

    WANTS_BOARDS;
    make(4600);
    memset(b.left_out, 1, sizeof b.left_out);
    b.rig.left_out = b.left_out;
    ASSERT_STATUS(RIGCAL_ERR_TOO_FEW, rigcal_rig_links(found, RIGCAL_LINKS(CAMERAS),
                                                       &n_groups, &at_fault, &b.rig));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
    at_fault = 0;
    ASSERT_STATUS(RIGCAL_ERR_TOO_FEW, rigcal_rig_choose(&b.choice, &at_fault, &b.rig));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
}

/* A work array that says that no placement was seen. */
static void test_a_rig_without_placements_has_no_faults(void)
{
    rigcal_faults_options options = {0};
    rigcal_faults found;
    rigcal_fault faults[12];
    rigcal_rig_fit fit;

    WANTS_BOARDS;
    make(4700);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &b.rig));
    options.work = memory;
    options.work_capacity = sizeof memory / sizeof *memory;
    for (int f = 0; f < PLACES; f++) {
        b.work[f] = 0;
    }
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, found,
                   rigcal_rig_faults(&found, faults, 12, NULL, &options, &b.rig));
}

/* Puts point 4 of view v behind its camera. */
static void put_behind(size_t v)
{
    const rigcal_transform chain =
        test_times(&b.true_cams[b.views[v].camera], &b.true_places[b.views[v].placement]);
    const rigcal_real behind[3] = {0, 0, -2};
    rigcal_transform target_from_cam;

    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_invert(&target_from_cam, &chain));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_transform_point(b.o[v][4].X_w, &target_from_cam, behind));
}

static void test_a_point_behind_its_camera_has_a_status(void)
{
    static const rigcal_intrinsics_change MADE[CAMERAS];
    rigcal_intrinsics_change change[CAMERAS], sigma[CAMERAS];
    rigcal_estimated estimated = {0};
    rigcal_considered considered = {0};
    rigcal_faults_options options = {0};
    rigcal_faults found, whole;
    rigcal_fault faults[12];
    rigcal_real Sigma[36];
    rigcal_rig_fit fit;
    int32_t at_fault;

    WANTS_BOARDS;
    make(4800);
    b.rig.sigma_px = RC(NOISE);
    b.rig.intrinsics_sigmas = sigmas;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &b.rig));
    considered.effects = memory;
    considered.capacity = sizeof memory / sizeof *memory;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &b.rig));
    put_behind(8); /* of placement 2 */
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, Sigma, rigcal_rig_placement(Sigma, &b.rig, 1, 2));
    ASSERT_STATUS(RIGCAL_ERR_BEHIND, rigcal_rig_consider(&considered, &at_fault, &b.rig));
    TEST_ASSERT_EQUAL_INT32(8, at_fault);
    TEST_ASSERT_NULL(b.rig.considered);
    estimated.considered.effects = more;
    estimated.considered.capacity = sizeof more / sizeof *more;
    estimated.made = MADE;
    estimated.change = change;
    estimated.sigma = sigma;
    ASSERT_STATUS(RIGCAL_ERR_BEHIND,
                  rigcal_rig_estimate(&estimated, &at_fault, &b.rig, RC(NOISE)));
    b.rig.intrinsics_sigmas = NULL;
    options.work = memory;
    options.work_capacity = sizeof memory / sizeof *memory;
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, found,
                   rigcal_rig_faults(&found, faults, 12, &at_fault, &options, &b.rig));
    TEST_ASSERT_EQUAL_INT32(8, at_fault);
    options.is_truncated = 1; /* then it is a wrong point like others */
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_faults(&found, faults, 12, NULL, &options, &b.rig));
    make(4800);
    b.rig.sigma_px = RC(NOISE);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &b.rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_faults(&whole, faults, 12, NULL, &options, &b.rig));
    ASSERT_NEAR(D(whole.freedom_within) - 2, found.freedom_within, 0);
}

/* With the truncated loss a point that cannot be seen is a wrong point. With Huber's loss,
 * which has no limit, it is an error. */
static void test_a_point_behind_its_camera_is_wrong_by_the_truncated_loss(void)
{
    static rigcal_rig_solver solver;
    rigcal_rig_fit fit;
    size_t n_wrong = 0;
    int32_t at_fault;

    WANTS_BOARDS;
    make(4900);
    b.rig.sigma_px = RC(NOISE);
    put_behind(8);
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_rig_robust_begin(&solver, &b.rig, RIGCAL_LOSS_TRUNCATED));
    while (rigcal_rig_step(&solver, 1000) == RIGCAL_RUNNING) {
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_robust_result(&fit, &n_wrong, &at_fault, &solver));
    TEST_ASSERT_EQUAL_size_t(1, n_wrong);
    make(4900);
    b.rig.sigma_px = RC(NOISE);
    put_behind(8);
    ASSERT_STATUS(RIGCAL_ERR_BEHIND,
                  rigcal_rig_adjust_robust(&fit, &n_wrong, &at_fault, &b.rig));
    TEST_ASSERT_EQUAL_INT32(8, at_fault);
}

/* Two cameras, one placement, three points each: as many numbers as unknowns. All fits, and
 * the noise cannot be estimated. */
static void test_a_rig_without_freedom_tells_no_noise(void)
{
    test_rng rng = test_seed(5100);
    rigcal_real sigma_px[2], freedom[2];
    rigcal_faults_options options = {0};
    rigcal_faults found;
    rigcal_fault faults[12];
    rigcal_rig_fit fit;

    WANTS_BOARDS;
    test_boards_make(&b, &rng, 2, 1, 2, 0, 0);
    test_boards_solve(&b);
    for (int v = 0; v < 2; v++) {
        b.o[v][1] = b.o[v][4];
        b.o[v][2] = b.o[v][15];
        b.views[v].view.n = 3;
    }
    b.rig.view_poses = NULL;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &b.rig));
    ASSERT_NEAR(0, fit.freedom, 0);
    ASSERT_NEAR(0, fit.sigma_px, 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_noise(sigma_px, freedom, &b.rig));
    for (int c = 0; c < 2; c++) {
        ASSERT_NEAR(0, freedom[c], TOL(1e-6, 1e-2));
    }
    options.work = memory;
    options.work_capacity = sizeof memory / sizeof *memory;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_faults(&found, faults, 12, NULL, &options, &b.rig));
    ASSERT_NEAR(0, found.sigma_px, 0);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_RIG_AGREES, found.verdict);
    TEST_ASSERT_TRUE((found.bits & RIGCAL_FAULTS_NO_LOOP) != 0);
    TEST_ASSERT_EQUAL_INT32(0, found.n_seen);
}

TEST_MAIN()
{
    RUN_TEST(test_a_placement_that_nobody_saw_changes_nothing);
    RUN_TEST(test_a_view_that_is_left_out_changes_nothing);
    RUN_TEST(test_a_camera_held_by_its_role);
    RUN_TEST(test_a_sure_prior_is_as_a_camera_that_is_held);
    RUN_TEST(test_counts_that_cannot_be_are_refused);
    RUN_TEST(test_a_rig_whose_views_are_all_left_out_is_refused);
    RUN_TEST(test_a_rig_without_placements_has_no_faults);
    RUN_TEST(test_a_point_behind_its_camera_has_a_status);
    RUN_TEST(test_a_point_behind_its_camera_is_wrong_by_the_truncated_loss);
    RUN_TEST(test_a_rig_without_freedom_tells_no_noise);
}
