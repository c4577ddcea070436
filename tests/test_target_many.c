/* target: several targets, each with a place of its own; the noise of a view; its
 * arguments. The truth: where a simulated rig has its targets. */
#include <math.h>
#include <string.h>

#include "rc_real.h"
#include "test_watched.h"

static const double DEGREE = TEST_PI / 180, NOISE = 0.3;

enum { POINTS = 8, TARGETS = 3 };

static test_watched w;
static double X_w[POINTS][3];

#define WANTS_RIG() TEST_WANTS_RAM(sizeof w + 40000)

/* Two cameras and targets of the same points, without a place. */
static void begin(test_rng *rng, int n_targets)
{
    test_watched_make(&w, rng, 2, 1, 0.05 * DEGREE, 2e-3);
    test_watched_begin(&w, n_targets, NULL);
    for (int i = 0; i < POINTS; i++) {
        for (int k = 0; k < 3; k++) {
            X_w[i][k] = D((rigcal_real)test_uniform(rng, -0.3, 0.3));
        }
    }
    for (int target = 0; target < n_targets; target++) {
        test_watched_hang(&w, rng, target, 0.45 * target - 0.4);
    }
}

static void show(int camera, int target, test_rng *rng)
{
    rigcal_observation o[POINTS];
    int32_t at_fault = -2;

    test_watched_see(o, &w, camera, target, X_w, POINTS, rng, 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_view(w.monitor, &at_fault, (size_t)camera,
                                                 (size_t)target, o, POINTS, RC(NOISE)));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
}

/* ---- several targets --------------------------------------------------------- */

#define WANTS_TARGETS() \
    do { \
        if (WATCHED_BODIES_MAX < 2 + TARGETS || \
            sizeof w.monitor < sizeof w.monitor[0] * RIGCAL_MONITOR_SIZE(2, TARGETS)) { \
            TEST_IGNORE_MESSAGE("wants memory for three targets"); \
            return; \
        } \
    } while (0)

/* Checks where a target is, or that it is nowhere. */
static void assert_place(int target, int is_placed)
{
    const size_t body = 2 + (size_t)target;
    rigcal_transform b_from_a;
    rigcal_real Sigma[36];

    if (!is_placed) {
        ASSERT_STATUS(RIGCAL_ERR_RANGE,
                      rigcal_monitor_pair(&b_from_a, Sigma, w.monitor, 0, body));
        return;
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_pair(&b_from_a, Sigma, w.monitor, 0, body));
    const rigcal_transform expected = test_transform(w.truth[body].R, w.truth[body].t);
    ASSERT_TRANSFORM(&expected, &b_from_a, TOL(1e-6, 2e-3), TOL(1e-5, 5e-3));
}

/* Each is placed and lifted by itself, in any order. */
static void test_each_target_has_a_place_of_its_own(void)
{
    static const int ORDER[TARGETS] = {2, 0, 1};
    int is_placed[TARGETS] = {0, 0, 0};
    test_rng rng = test_seed(500);

    WANTS_TARGETS();
    begin(&rng, TARGETS);
    for (int k = 0; k < 2 * TARGETS; k++) {
        const int target = ORDER[k % TARGETS];

        rigcal_body_report report;

        is_placed[target] = k < TARGETS;
        if (k < TARGETS) {
            show(0, target, &rng);
        } else {
            ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_lifted(w.monitor, (size_t)target));
        }
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_monitor_body(&report, w.monitor, 2 + (size_t)target));
        TEST_ASSERT_EQUAL_INT(is_placed[target], report.weakest_sigma > 0);
        for (int t = 0; t < TARGETS; t++) {
            assert_place(t, is_placed[t]);
        }
    }
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_monitor_lifted(w.monitor, TARGETS));
}

/* Whether the pose of a target follows a view at once, before the frame ends. */
static int follows(int target, test_rng *rng)
{
    static const double d[6] = {0.01, 0, 0, 0, 0.01, 0};
    const size_t body = 2 + (size_t)target;
    rigcal_transform before, after;
    rigcal_real Sigma[36];

    test_watched_bump(&w, (int)body, d);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_pair(&before, Sigma, w.monitor, 0, body));
    show(0, target, rng);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_pair(&after, Sigma, w.monitor, 0, body));
    return memcmp(&before, &after, sizeof before) != 0;
}

static void test_a_target_that_settles_is_let_go_by_its_own_lifting_alone(void)
{
    for (int lifted = 0; lifted < TARGETS; lifted++) {
        test_rng rng = test_seed(501);

        WANTS_TARGETS();
        begin(&rng, TARGETS);
        for (int t = 0; t < TARGETS; t++) {
            show(0, t, &rng);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_moved(w.monitor, 3)); /* target 1 */
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_lifted(w.monitor, (size_t)lifted));
        show(0, lifted, &rng);
        TEST_ASSERT_EQUAL_INT(lifted != 1, follows(1, &rng));
        TEST_ASSERT_FALSE(follows(2, &rng));
    }
}

/* What was seen of a target before it was lifted is no evidence of where it is now. */
static void test_a_target_that_is_placed_anew_is_blind(void)
{
    test_rng rng = test_seed(502);
    rigcal_body_report report;

    WANTS_TARGETS();
    begin(&rng, TARGETS);
    for (int f = 0; f < 4; f++) {
        show(f % 2, 1, &rng);
        show(f % 2, 2, &rng);
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(NULL, w.monitor, 0));
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_lifted(w.monitor, 1));
    show(0, 1, &rng);
    for (size_t target = 1; target < 3; target++) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_body(&report, w.monitor, 2 + target));
        TEST_ASSERT_EQUAL_INT32(target == 1, report.is_blind);
    }
}

/* ---- the noise of pixels ----------------------------------------------------- */

/* Places the target by camera 0, the frame, which is exact. */
static rigcal_status place_by(const rigcal_observation o[POINTS], double sigma_px,
                              rigcal_real Sigma[36])
{
    rigcal_transform b_from_a;

    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_lifted(w.monitor, 0));
    const rigcal_status status =
        rigcal_monitor_view(w.monitor, NULL, 0, 0, o, POINTS, RC(sigma_px));
    if (status == RIGCAL_OK) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_pair(&b_from_a, Sigma, w.monitor, 0, 2));
    }
    return status;
}

/* The covariance of a place scales with the square of the noise. A view that noise does not
 * explain places nothing. */
static void test_the_stated_noise_counts_in_a_place(void)
{
    test_rng rng = test_seed(503);
    rigcal_observation o[POINTS];
    rigcal_real Sigma[36], of_double[36];

    WANTS_RIG();
    begin(&rng, 1);
    test_watched_see(o, &w, 0, 0, X_w, POINTS, &rng, 0.5);
    ASSERT_STATUS(RIGCAL_OK, place_by(o, 0.5, Sigma));
    ASSERT_STATUS(RIGCAL_OK, place_by(o, 1, of_double));
    for (int k = 0; k < 36; k++) {
        const double scale = sqrt(D(Sigma[7 * (k / 6)]) * D(Sigma[7 * (k % 6)]));
        ASSERT_NEAR(4 * D(Sigma[k]) / scale, D(of_double[k]) / scale, TOL(1e-9, 1e-3));
    }
    ASSERT_STATUS(RIGCAL_POOR_FIT, place_by(o, 0.02, Sigma));
}

/* Of a target that has a place, one point is enough. */
static void test_arguments_of_a_view_are_checked_from_both_sides(void)
{
    const size_t most = RC_COUNT_MAX;
    test_rng rng = test_seed(504);
    rigcal_observation o[POINTS];
    int32_t at_fault = -2;

    WANTS_RIG();
    begin(&rng, 1);
    for (int has_place = 0; has_place < 2; has_place++) {
        test_watched_see(o, &w, 0, 0, X_w, POINTS, &rng, 0);
        ASSERT_STATUS(RIGCAL_ERR_NULL,
                      rigcal_monitor_view(NULL, &at_fault, 0, 0, o, POINTS, 1));
        ASSERT_STATUS(RIGCAL_ERR_NULL,
                      rigcal_monitor_view(w.monitor, &at_fault, 0, 0, NULL, POINTS, 1));
        ASSERT_STATUS(RIGCAL_ERR_TOO_FEW,
                      rigcal_monitor_view(w.monitor, &at_fault, 0, 0, o, 0, 1));
        ASSERT_STATUS(RIGCAL_ERR_RANGE,
                      rigcal_monitor_view(w.monitor, &at_fault, 0, 0, o, POINTS, 0));
        if (most < SIZE_MAX) {
            ASSERT_STATUS(RIGCAL_ERR_RANGE,
                          rigcal_monitor_view(w.monitor, &at_fault, 0, 0, o, most + 1, 1));
        }
        TEST_ASSERT_EQUAL_INT32(-1, at_fault);
        o[0].uv[0] = TEST_NAN; /* no further one is read */
        ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE,
                      rigcal_monitor_view(w.monitor, &at_fault, 0, 0, o, most, 1));
        TEST_ASSERT_EQUAL_INT32(0, at_fault);
        show(0, 0, &rng);
    }
    test_watched_see(o, &w, 1, 0, X_w, POINTS, &rng, 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_view(w.monitor, NULL, 1, 0, o, 1, 1));
}

TEST_MAIN()
{
    RUN_TEST(test_each_target_has_a_place_of_its_own);
    RUN_TEST(test_a_target_that_settles_is_let_go_by_its_own_lifting_alone);
    RUN_TEST(test_a_target_that_is_placed_anew_is_blind);
    RUN_TEST(test_the_stated_noise_counts_in_a_place);
    RUN_TEST(test_arguments_of_a_view_are_checked_from_both_sides);
}
