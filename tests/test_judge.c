/* judge: which views of a rig are wrong. The truth: rigs with views of which the test knows
 * that they are wrong. */
#include <math.h>
#include <string.h>

#include "rc_cost.h"
#include "rigcal_solvers.h"
#include "test_boards.h"

static const double NOISE = 0.3;

static test_boards b, other;

#define WANTS_BOARDS(n) TEST_WANTS_RAM((n) * sizeof(test_boards) + 20000)

/* Solves, chooses and judges. Returns the status of the last. sigma_px: 0: that of the
 * choice. What lies behind the last view is not written. */
static rigcal_status judge_by(test_boards *which, double sigma_px)
{
    const size_t n = which->rig.n_views;
    int32_t at_fault = -2;
    rigcal_status status;

    TEST_ASSERT_TRUE(n < BOARD_VIEWS_MAX);
    which->left_out[n] = which->takes[n] = 77;
    which->judged[n].verdict = 77;
    test_boards_solve(which);
    TEST_ASSERT_TRUE(rigcal_rig_choose(&which->choice, &at_fault, &which->rig) >= 0);
    which->choice.sigma_px = sigma_px > 0 ? RC(sigma_px) : which->choice.sigma_px;
    status = rigcal_rig_judge(&which->judgement, &at_fault, which->judged, which->left_out,
                              &which->choice, &which->rig);
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
    TEST_ASSERT_EQUAL_UINT8(77, which->left_out[n]);
    TEST_ASSERT_EQUAL_UINT8(77, which->takes[n]);
    TEST_ASSERT_EQUAL_INT32(77, which->judged[n].verdict);
    return status;
}

static rigcal_status judge(test_boards *which)
{
    return judge_by(which, 0);
}

static int is_named(const test_boards *which, size_t v)
{
    return which->judged[v].verdict == RIGCAL_VIEW_CONTRADICTS ||
           which->judged[v].verdict == RIGCAL_VIEW_ONE_OF_TWO;
}

/* ---- nothing wrong --------------------------------------------------------- */

static void test_where_nothing_is_wrong_no_view_is_named(void)
{
    static const int SIZES[4][3] = {{2, 8, 2}, {4, 10, 4}, {4, 20, 2}, {3, 4, 3}};
    double scale = 0;

    WANTS_BOARDS(1);
    for (int trial = 0; trial < TEST_TRIALS(80); trial++) {
        test_rng rng = test_seed(910 + (uint64_t)trial);
        const int *const size = SIZES[trial % 4];

        test_boards_make(&b, &rng, size[0], size[1], size[2], NOISE, 0);
        ASSERT_STATUS(RIGCAL_OK, judge(&b));
        TEST_ASSERT_EQUAL_INT32((int32_t)b.rig.n_views, b.judgement.n_fit);
        ASSERT_NEAR(NOISE, b.judgement.sigma_px, 0.1);
        scale += D(b.judgement.scale) / TEST_TRIALS(80);
        for (size_t v = 0; v < b.rig.n_views; v++) {
            TEST_ASSERT_TRUE(D(b.judged[v].cost) < 1);
            TEST_ASSERT_EQUAL_UINT8(0, b.left_out[v]);
        }
    }
    ASSERT_NEAR(2, scale, 1); /* with noise alone M is about 1 */
}

/* All views are bent, some of them more: sqrt F is 3 to 7. */
static void test_where_all_views_are_bent_no_view_is_named(void)
{
    WANTS_BOARDS(1);
    for (int trial = 0; trial < TEST_TRIALS(40); trial++) {
        test_rng rng = test_seed(1010 + (uint64_t)trial);

        test_boards_make(&b, &rng, 4, 10, 4, NOISE, trial % 2 ? 4 : 8);
        ASSERT_STATUS(RIGCAL_OK, judge(&b));
        TEST_ASSERT_TRUE(D(b.judgement.scale) > 3);
        TEST_ASSERT_EQUAL_INT32(40, b.judgement.n_fit);
    }
}

/* ---- views that are wrong -------------------------------------------------- */

typedef struct {
    int wrong, wrong_named;   /* in placements with two or more right views that outnumber
                                 the wrong ones */
    int right, right_named;   /* the same */
    int all_wrong, all_named; /* anywhere */
} shares;

/* Counts placements in which the wrong views can be known: two or more views are right, and
 * more than are wrong. */
static void count(shares *n, const test_boards *which)
{
    for (size_t v = 0; v < which->rig.n_views; v++) {
        int wrong = 0, right = 0;

        for (size_t u = 0; u < which->rig.n_views; u++) {
            if (which->views[u].placement == which->views[v].placement) {
                wrong += which->is_wrong[u];
                right += !which->is_wrong[u];
            }
        }
        n->all_wrong += which->is_wrong[v];
        n->all_named += which->is_wrong[v] && is_named(which, v);
        if (right > 1 && right > wrong) {
            n->wrong += which->is_wrong[v];
            n->right += !which->is_wrong[v];
            n->wrong_named += which->is_wrong[v] && is_named(which, v);
            n->right_named += !which->is_wrong[v] && is_named(which, v);
        }
    }
}

enum { REPLACED, REVERSED, SWAPPED };

/* Makes one view in ten wrong, all in the same way. */
static void spoil(test_boards *which, test_rng *rng, int how)
{
    const size_t n = which->rig.n_views;

    for (size_t v = 0; v < n; v++) {
        const int place = (int)test_uniform(rng, 0, (double)which->rig.n_placements);
        const int from = test_boards_view(which, which->views[v].camera, place);
        const int partner = test_boards_view(
            which, (which->views[v].camera + 1) % (int)which->rig.n_cameras,
            which->views[v].placement);

        if (which->is_wrong[v] || test_uniform(rng, 0, how == SWAPPED ? 2 : 1) > 0.1) {
            continue;
        }
        if (how == REVERSED) {
            test_boards_reverse(which, (int)v);
        } else if (how == REPLACED && !which->is_wrong[from] && from != (int)v) {
            test_boards_replace(which, (int)v, from);
        } else if (how == SWAPPED && !which->is_wrong[partner]) {
            test_boards_swap(which, (int)v, partner);
        }
    }
}

static void assert_spoilt_views_are_named(int how, double pattern_px)
{
    shares n = {0, 0, 0, 0, 0, 0};
    double error = 0;
    int rigs = 0;

    for (int trial = 0; trial < TEST_TRIALS(30); trial++) {
        test_rng rng = test_seed(1100 + 100 * (uint64_t)how + (uint64_t)trial);

        test_boards_make(&b, &rng, 4, 10, 4, NOISE, pattern_px);
        spoil(&b, &rng, how);
        TEST_ASSERT_TRUE(judge(&b) >= 0);
        count(&n, &b);
        error += pow(test_boards_error(&b, b.judgement.sigma_px), 2);
        rigs++;
    }
    TEST_ASSERT_EQUAL_INT(n.wrong, n.wrong_named);
    TEST_ASSERT_EQUAL_INT(0, n.right_named);
    if (TEST_ONE_IN > 1) {
        return; /* too few views for the checks below */
    }
    TEST_ASSERT_TRUE(n.wrong >= 2 * rigs || how == SWAPPED);
    /* All wrong views must be named, except those that agree with each other. */
    TEST_ASSERT_TRUE(n.all_named >= (how == REVERSED ? 0.8 : 0.95) * n.all_wrong);
    if (!(pattern_px > 0)) {
        ASSERT_NEAR(1, sqrt(error / rigs), 0.15);
    }
}

static void test_replaced_views_are_named(void)
{
    WANTS_BOARDS(1);
    assert_spoilt_views_are_named(REPLACED, 0);
    assert_spoilt_views_are_named(REPLACED, 4);
}

static void test_reversed_views_are_named(void)
{
    WANTS_BOARDS(1);
    assert_spoilt_views_are_named(REVERSED, 0);
}

static void test_views_of_swapped_cameras_are_named(void)
{
    WANTS_BOARDS(1);
    assert_spoilt_views_are_named(SWAPPED, 0);
}

/* All its views are left out, so it has no frame, and no pose is invented for it. */
static void test_a_camera_that_is_late_is_left_out(void)
{
    shares n = {0, 0, 0, 0, 0, 0};

    WANTS_BOARDS(1);
    for (int trial = 0; trial < TEST_TRIALS(20); trial++) {
        test_rng rng = test_seed(1500 + (uint64_t)trial);
        const int late = trial % 4;

        test_boards_make(&b, &rng, 4, 10, 4, NOISE, 0);
        test_boards_late(&b, late);
        ASSERT_STATUS(RIGCAL_DISCONNECTED, judge(&b));
        count(&n, &b);
        TEST_ASSERT_EQUAL_INT32(9, b.judgement.n_contradict);
        for (int c = 0; c < 4; c++) {
            TEST_ASSERT_EQUAL_INT(c == late, b.group[c] != b.group[late == 1 ? 2 : 1]);
        }
    }
    TEST_ASSERT_EQUAL_INT(n.wrong, n.wrong_named);
    TEST_ASSERT_EQUAL_INT(0, n.right_named);
}

/* All views of camera 3 are wrong. The limit is as if there were only the other cameras,
 * also where a prior says where it is. */
static void test_a_camera_that_is_left_out_does_not_count_for_the_limit(void)
{
    enum { WRONG = 3 };
    static rigcal_camera_prior priors[4];

    WANTS_BOARDS(2);
    for (int has_prior = 0; has_prior < 2; has_prior++) {
        const uint8_t roles[4] = {RIGCAL_CAMERA_HELD, 0, 0,
                                  has_prior ? RIGCAL_CAMERA_PRIOR : RIGCAL_CAMERA_FREE};
        size_t n = 0;
        test_rng rng = test_seed(1510);

        test_boards_make(&b, &rng, 4, 10, 4, NOISE, 2);
        for (int f = 9; f >= 0; f--) {
            test_boards_replace(&b, test_boards_view(&b, WRONG, f),
                                test_boards_view(&b, 0, (3 * f + 1) % 10));
        }
        rng = test_seed(1510);
        test_boards_make(&other, &rng, 4, 10, 4, NOISE, 2);
        for (size_t v = 0; v < other.rig.n_views; v++) {
            if (other.views[v].camera != WRONG) {
                other.views[n++] = other.views[v];
            }
        }
        other.rig.n_views = n;
        other.rig.n_cameras = 3;
        priors[WRONG].cam_from_rig = b.true_cams[WRONG];
        for (int k = 0; k < 6; k++) {
            priors[WRONG].Sigma[7 * k] = RC(1e-4);
        }
        b.rig.roles = other.rig.roles = roles;
        b.rig.priors = other.rig.priors = priors;
        b.rig.sigma_px = other.rig.sigma_px = RC(NOISE);
        TEST_ASSERT_TRUE(judge_by(&b, NOISE) > 0);
        ASSERT_STATUS(RIGCAL_OK, judge_by(&other, NOISE));
        TEST_ASSERT_EQUAL_INT32(10, b.judgement.n_contradict);
        TEST_ASSERT_TRUE(D(other.judgement.scale) > 1.5);
        ASSERT_NEAR(other.judgement.scale, b.judgement.scale,
                    TOL(1e-6, 1e-3) * D(other.judgement.scale));
    }
}

/* Wrong views that the joiner took for right bend the rig. The view with the largest cost
 * in each placement is left out first, from the first placement to the last. */
static void test_wrong_views_that_were_joined_are_named(void)
{
    WANTS_BOARDS(1);
    for (int trial = 0; trial < TEST_TRIALS(10); trial++) {
        const int reversed = 37 - 4 * trial, replaced = (reversed + 17) % 40;
        test_rng rng = test_seed(1600 + (uint64_t)trial);

        test_boards_make(&b, &rng, 4, 10, 4, NOISE, 0);
        test_boards_reverse(&b, reversed);
        test_boards_replace(&b, replaced, (replaced + 36) % 40);
        test_boards_solve(&b);
        b.choice.sigma_px = RC(NOISE); /* takes is 0; the poses are the true ones */
        ASSERT_STATUS(
            RIGCAL_VIEWS_LEFT_OUT,
            rigcal_rig_judge(&b.judgement, NULL, b.judged, b.left_out, &b.choice, &b.rig));
        for (size_t v = 0; v < b.rig.n_views; v++) {
            TEST_ASSERT_EQUAL_INT(b.is_wrong[v], is_named(&b, v));
            TEST_ASSERT_EQUAL_UINT8(b.is_wrong[v] ? 1 : 0, b.left_out[v]);
            TEST_ASSERT_EQUAL_UINT8(b.is_wrong[v] ? RIGCAL_TAKES_NONE : RIGCAL_TAKES_FIRST,
                                    b.takes[v]);
            TEST_ASSERT_EQUAL_INT(b.is_wrong[v], D(b.judged[v].cost) > 1);
        }
        TEST_ASSERT_TRUE(b.rig.left_out == b.left_out);
    }
}

/* Then the rig is that of the other views alone. */
static void test_a_named_view_does_not_touch_the_rig(void)
{
    test_rng rng = test_seed(1700), again = test_seed(1700);
    rigcal_rig_fit fit;

    WANTS_BOARDS(2);
    test_boards_make(&b, &rng, 4, 8, 4, NOISE, 0);
    test_boards_make(&other, &again, 4, 8, 4, NOISE, 0);
    test_boards_reverse(&b, 13);
    ASSERT_STATUS(RIGCAL_VIEWS_LEFT_OUT, judge(&b));
    test_boards_solve(&other);
    other.left_out[13] = 1;
    other.rig.left_out = other.left_out;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &other.rig));
    for (int c = 0; c < 4; c++) {
        ASSERT_TRANSFORM(&other.cams[c], &b.cams[c], TOL(1e-6, 3e-5), TOL(3e-6, 1e-4));
    }
    TEST_ASSERT_EQUAL_INT32(1, b.judgement.n_contradict);
    TEST_ASSERT_EQUAL_INT32(31, b.judgement.n_fit);
    ASSERT_NEAR(fit.sum, b.judgement.fit.sum, TOL(1e-6, 1e-3) * D(fit.sum));
}

/* A camera has one right view and nine wrong ones. The right one is left out too, because
 * nothing else says where the camera is. If the camera is held or has a prior, the right
 * view stays. */
static void test_the_only_right_view_of_a_camera_stays_if_its_pose_is_known(void)
{
    enum { LATE = 1 };
    static rigcal_camera_prior priors[4];

    WANTS_BOARDS(1);
    for (int role = RIGCAL_CAMERA_FREE; role <= RIGCAL_CAMERA_PRIOR; role++) {
        const uint8_t roles[4] = {RIGCAL_CAMERA_HELD, (uint8_t)role, 0, 0};
        test_rng rng = test_seed(1650);

        test_boards_make(&b, &rng, 4, 10, 4, NOISE, 0);
        for (int f = 9; f > 0; f--) {
            test_boards_replace(&b, test_boards_view(&b, LATE, f),
                                test_boards_view(&b, LATE, f - 1));
        }
        priors[LATE].cam_from_rig = b.true_cams[LATE];
        for (int k = 0; k < 6; k++) {
            priors[LATE].Sigma[7 * k] = RC(1e-10);
        }
        b.rig.roles = roles;
        b.rig.priors = priors;
        b.rig.sigma_px = RC(NOISE);
        TEST_ASSERT_TRUE(judge(&b) > 0);

        for (size_t v = 0; v < b.rig.n_views; v++) {
            const int is_alone = role == RIGCAL_CAMERA_FREE && b.views[v].camera == LATE;

            TEST_ASSERT_EQUAL_INT(b.is_wrong[v] || is_alone, is_named(&b, v));
        }
    }
}

/* One view is shifted by some pixels. A little is noise; a view that may be wrong is left
 * out to see, and comes back by a third adjustment; what is named is left out of a second
 * one; what the choice has left out is in none. */
static void test_the_rig_is_adjusted_no_more_than_it_takes(void)
{
    enum { SHIFTED = 13 };
    static const struct {
        double px;
        int32_t adjustments, n_fit;
    } CASES[4] = {{0.3, 1, 32}, {0.65, 3, 32}, {2, 2, 31}, {10, 1, 31}};

    WANTS_BOARDS(1);
    for (int k = 0; k < 4; k++) {
        test_rng rng = test_seed(1700);

        test_boards_make(&b, &rng, 4, 8, 4, NOISE, 0);
        for (int i = 0; i < BOARD_POINTS; i++) {
            b.o[SHIFTED][i].uv[0] += RC(CASES[k].px);
        }
        ASSERT_STATUS(CASES[k].n_fit < 32 ? RIGCAL_VIEWS_LEFT_OUT : RIGCAL_OK, judge(&b));
        TEST_ASSERT_EQUAL_INT32(CASES[k].adjustments, b.judgement.adjustments);
        TEST_ASSERT_EQUAL_INT32(CASES[k].n_fit, b.judgement.n_fit);
        TEST_ASSERT_EQUAL_INT(CASES[k].n_fit < 32, is_named(&b, SHIFTED));
    }
}

/* ---- what cannot be known -------------------------------------------------- */

static void test_of_two_views_that_contradict_each_other_both_are_named(void)
{
    WANTS_BOARDS(1);
    for (int trial = 0; trial < TEST_TRIALS(10); trial++) {
        test_rng rng = test_seed(1800 + (uint64_t)trial);

        test_boards_make(&b, &rng, 2, 8, 2, NOISE, 0);
        test_boards_reverse(&b, 2 * (trial % 8) + trial % 2);
        ASSERT_STATUS(RIGCAL_VIEWS_LEFT_OUT, judge(&b));
        TEST_ASSERT_EQUAL_INT32(2, b.judgement.n_one_of_two);
        TEST_ASSERT_EQUAL_INT32(14, b.judgement.n_fit);
        for (int v = 0; v < 16; v++) {
            const int is_here = v / 2 == trial % 8;

            TEST_ASSERT_EQUAL_INT32(is_here ? RIGCAL_VIEW_ONE_OF_TWO : RIGCAL_VIEW_FITS,
                                    b.judged[v].verdict);
            TEST_ASSERT_EQUAL_INT(is_here, D(b.judged[v].cost) > 1);
            TEST_ASSERT_EQUAL_INT(is_here, D(b.judged[v].rms_px) < 0);
        }
    }
}

static void remove_view(int camera, int placement)
{
    const int gone = test_boards_view(&b, camera, placement);

    b.rig.n_views--;
    for (size_t v = (size_t)gone; v < b.rig.n_views; v++) {
        memcpy(b.o[v], b.o[v + 1], sizeof b.o[v]);
        b.views[v] = b.views[v + 1];
        b.views[v].view.observations = b.o[v];
    }
}

/* Cameras 0 and 1 share placements 0 to 3. Camera 2 sees placement 4 with camera 0, and
 * placement 5 with camera 1. One of its two views is wrong. Its pose would be that of the
 * other view, and nothing says which one is right: both are named, and so are the views of
 * cameras 0 and 1 that have no partner then. */
static void test_of_a_camera_with_two_views_that_contradict_both_are_named(void)
{
    WANTS_BOARDS(1);
    for (int wrong = 4; wrong < 6; wrong++) {
        test_rng rng = test_seed(1850);

        test_boards_make(&b, &rng, 3, 6, 3, NOISE, 0);
        for (int f = 0; f < 4; f++) {
            remove_view(2, f);
        }
        remove_view(1, 4);
        remove_view(0, 5);
        test_boards_reverse(&b, test_boards_view(&b, 2, wrong));
        TEST_ASSERT_TRUE(judge_by(&b, NOISE) > 0);
        TEST_ASSERT_EQUAL_INT32(4, b.judgement.n_one_of_two);
        TEST_ASSERT_EQUAL_INT32(8, b.judgement.n_fit);
        for (size_t v = 0; v < b.rig.n_views; v++) {
            TEST_ASSERT_EQUAL_INT(b.views[v].placement >= 4, is_named(&b, v));
        }
    }
}

/* A rig in which only camera 2 sees placement 4, and this view is wrong. */
static int make_unshared(void)
{
    test_rng rng = test_seed(1900);

    test_boards_make(&b, &rng, 3, 6, 3, NOISE, 0);
    remove_view(0, 4);
    remove_view(1, 4);
    const int gone = test_boards_view(&b, 2, 4);
    test_boards_reverse(&b, gone);
    return gone;
}

static void assert_unshared(int alone)
{
    TEST_ASSERT_EQUAL_INT32(1, b.judgement.n_unchecked);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_VIEW_UNCHECKED, b.judged[alone].verdict);
    ASSERT_NEAR(0, b.judged[alone].cost, 0);
    TEST_ASSERT_EQUAL_INT32(15, b.judgement.n_fit);
}

static void test_a_view_that_nobody_shares_is_unchecked(void)
{
    int alone;

    WANTS_BOARDS(1);
    alone = make_unshared();
    ASSERT_STATUS(RIGCAL_OK, judge(&b));
    assert_unshared(alone);
}

static void test_a_view_that_nobody_shares_is_unchecked_if_it_is_left_out_too(void)
{
    int alone;

    WANTS_BOARDS(1);
    alone = make_unshared();
    test_boards_solve(&b);
    b.choice.sigma_px = RC(NOISE);
    b.takes[alone] = RIGCAL_TAKES_NONE;
    (void)rigcal_rig_judge(&b.judgement, NULL, b.judged, b.left_out, &b.choice, &b.rig);
    assert_unshared(alone);
}

/* ---- second poses ---------------------------------------------------------- */

static rigcal_view_pose second[BOARD_VIEWS_MAX];

static rigcal_status second_from_source(rigcal_view_pose *pose, size_t index, void *context)
{
    (void)context;
    *pose = second[index];
    return RIGCAL_OK;
}

/* A view whose second pose is the right one: the judge takes it, although the choice left
 * the view out. So it does if the poses come from a source. */
static void test_a_second_pose_is_taken_up(void)
{
    static const double axis[3] = {1, 0, 0};
    const rigcal_transform turned = test_turned_about(axis, 0.4);
    test_rng rng = test_seed(2000);

    WANTS_BOARDS(1);
    memset(second, 0, sizeof second);
    test_boards_make(&b, &rng, 3, 6, 3, NOISE, 0);
    test_boards_solve(&b);
    second[7] = b.own[7];
    b.own[7].cam_from_target = test_times(&b.own[7].cam_from_target, &turned);
    second[7].sse += 1;
    b.choice.second_poses = second;
    b.choice.sigma_px = RC(NOISE);
    b.takes[7] = RIGCAL_TAKES_NONE;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_judge(&b.judgement, NULL, b.judged, b.left_out,
                                              &b.choice, &b.rig));
    TEST_ASSERT_EQUAL_UINT8(RIGCAL_TAKES_SECOND, b.takes[7]);
    TEST_ASSERT_EQUAL_INT32(18, b.judgement.n_fit);
    b.choice.second_poses = NULL;
    b.choice.second_source = second_from_source;
    b.takes[7] = RIGCAL_TAKES_NONE;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_judge(&b.judgement, NULL, b.judged, b.left_out,
                                              &b.choice, &b.rig));
    TEST_ASSERT_EQUAL_UINT8(RIGCAL_TAKES_SECOND, b.takes[7]);
    TEST_ASSERT_EQUAL_INT32(18, b.judgement.n_fit);
}

/* The choice has left out all views of a placement, and the placement stands behind the
 * cameras. The views agree, so the judge takes them up and moves the placement to where
 * they have it. The rig is then that of a choice that took them. */
static void test_a_placement_that_is_taken_up_is_moved_to_its_views(void)
{
    enum { MOVED = 2 };
    test_rng rng = test_seed(2050), again = test_seed(2050);

    WANTS_BOARDS(2);
    test_boards_make(&b, &rng, 3, 6, 3, NOISE, 0);
    test_boards_make(&other, &again, 3, 6, 3, NOISE, 0);
    test_boards_solve(&b);
    b.choice.sigma_px = RC(NOISE);
    for (int c = 0; c < 3; c++) {
        b.takes[test_boards_view(&b, c, MOVED)] = RIGCAL_TAKES_NONE;
    }
    for (int k = 0; k < 3; k++) {
        b.places[MOVED].t[k] = -b.places[MOVED].t[k];
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_judge(&b.judgement, NULL, b.judged, b.left_out,
                                              &b.choice, &b.rig));
    ASSERT_STATUS(RIGCAL_OK, judge_by(&other, NOISE));
    TEST_ASSERT_EQUAL_INT32(18, b.judgement.n_fit);
    ASSERT_NEAR(other.judgement.fit.sum, b.judgement.fit.sum,
                TOL(1e-6, 1e-3) * D(other.judgement.fit.sum));
    for (int f = 0; f < 6; f++) {
        ASSERT_TRANSFORM(&other.places[f], &b.places[f], TOL(1e-6, 3e-5), TOL(3e-6, 1e-4));
    }
}

/* ---- steps and arguments --------------------------------------------------- */

static void run_in_steps(test_boards *which, int32_t budget)
{
    static rigcal_judge_solver solver;
    test_rng rng = test_seed(2100);
    rigcal_status status;

    test_boards_make(which, &rng, 3, 6, 3, NOISE, 3);
    test_boards_reverse(which, 4);
    test_boards_replace(which, 12, 9);
    test_boards_solve(which);
    which->choice.sigma_px = RC(NOISE);
    ASSERT_STATUS(RIGCAL_OK, rigcal_judge_begin(&solver, which->judged, which->left_out,
                                                &which->choice, &which->rig));
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_judge_result(&which->judgement, NULL, &solver));
    do {
        status = rigcal_judge_step(&solver, budget);
    } while (status == RIGCAL_RUNNING);
    ASSERT_STATUS(RIGCAL_OK, status);
    ASSERT_STATUS(RIGCAL_VIEWS_LEFT_OUT,
                  rigcal_judge_result(&which->judgement, NULL, &solver));
}

static void test_the_same_bits_whatever_the_budgets(void)
{
    WANTS_BOARDS(2);
    memset(&b, 0, sizeof b);
    run_in_steps(&b, 1000);
    for (int32_t budget = 1; budget<100; budget += TEST_ONE_IN> 1 ? 36 : 6) {
        run_in_steps(&other, budget);
        TEST_ASSERT_EQUAL_MEMORY(b.cams, other.cams, sizeof b.cams);
        TEST_ASSERT_EQUAL_MEMORY(b.places, other.places, sizeof b.places);
        TEST_ASSERT_EQUAL_MEMORY(b.judged, other.judged, sizeof b.judged);
        TEST_ASSERT_EQUAL_MEMORY(&b.judgement, &other.judgement, sizeof b.judgement);
    }
}

/* While the rig is adjusted, a unit of the judge is a unit of the adjustment. */
static void test_a_unit_of_an_adjustment_is_one_of_the_judge(void)
{
    static rigcal_judge_solver solver;
    static rigcal_rig_solver adjust;
    test_rng rng = test_seed(2110);
    int units = 0, expected = 1;

    WANTS_BOARDS(1);
    test_boards_make(&b, &rng, 3, 6, 3, NOISE, 0);
    test_boards_solve(&b);
    b.choice.sigma_px = RC(NOISE);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_begin(&adjust, &b.rig));
    while (rigcal_rig_step(&adjust, 1) == RIGCAL_RUNNING) {
        expected++;
    }
    test_boards_solve(&b); /* back to where the adjustment began */
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_judge_begin(&solver, b.judged, b.left_out, &b.choice, &b.rig));
    do {
        units += solver.phase == RC_JUDGE_ADJUSTING;
    } while (rigcal_judge_step(&solver, 1) == RIGCAL_RUNNING);
    ASSERT_STATUS(RIGCAL_OK, rigcal_judge_result(&b.judgement, NULL, &solver));
    TEST_ASSERT_EQUAL_INT32(1, b.judgement.adjustments);
    TEST_ASSERT_EQUAL_INT(expected, units);
}

static size_t calls, fails_at, failed;

static rigcal_status pose_that_fails(rigcal_view_pose *pose, size_t index, void *context)
{
    (void)context;
    *pose = b.own[index];
    failed = index;
    return (++calls == fails_at) ? RIGCAL_ERR_DAMAGED : RIGCAL_OK;
}

/* At fault is no view, or one of the placement whose view failed. */
static void test_a_source_that_fails_ends_the_judgement(void)
{
    test_rng rng = test_seed(1810);
    size_t n = 1;

    WANTS_BOARDS(2);
    test_boards_make(&b, &rng, 2, 3, 2, NOISE, 0);
    test_boards_solve(&b);
    TEST_ASSERT_TRUE(rigcal_rig_choose(&b.choice, NULL, &b.rig) >= 0);
    b.rig.view_poses = NULL;
    b.rig.view_pose_source = pose_that_fails;
    other = b;
    for (fails_at = 0; fails_at <= n; fails_at++) {
        int32_t at_fault = -2;

        b = other;
        calls = 0;
        ASSERT_STATUS(fails_at ? RIGCAL_ERR_DAMAGED : RIGCAL_OK,
                      rigcal_rig_judge(&b.judgement, &at_fault, b.judged, b.left_out,
                                       &b.choice, &b.rig));
        TEST_ASSERT_TRUE(at_fault == -1 ||
                         (at_fault >= 0 && at_fault / 2 == (int32_t)failed / 2));
        TEST_ASSERT_EQUAL_size_t(fails_at ? fails_at : calls, calls);
        n = fails_at ? n : calls;
    }
}

static void test_what_cannot_be_judged_is_refused(void)
{
    static rigcal_judge_solver solver;
    test_rng rng = test_seed(2200);

    WANTS_BOARDS(1);
    test_boards_make(&b, &rng, 2, 3, 2, NOISE, 0);
    test_boards_solve(&b);
#define BEGIN rigcal_judge_begin(&solver, b.judged, b.left_out, &b.choice, &b.rig)
    ASSERT_STATUS(RIGCAL_ERR_RANGE, BEGIN); /* no noise */
    b.choice.sigma_px = RC(NOISE);
    b.rig.work_capacity = RIGCAL_JUDGE_WORK(2, 3) - 1;
    ASSERT_STATUS(RIGCAL_ERR_CAPACITY, BEGIN);
    b.rig.work_capacity++;
    ASSERT_STATUS(RIGCAL_OK, BEGIN);
    b.choice.takes = NULL;
    ASSERT_STATUS(RIGCAL_ERR_NULL, BEGIN);
    b.choice.takes = b.takes;
    b.rig.view_poses = NULL;
    ASSERT_STATUS(RIGCAL_ERR_NULL, BEGIN);
    b.rig.view_poses = b.own;
#undef BEGIN
    int32_t at_fault;
#define JUDGE \
    rigcal_rig_judge(&b.judgement, &at_fault, b.judged, b.left_out, &b.choice, &b.rig)
    b.takes[3] = 3;
    ASSERT_STATUS(RIGCAL_ERR_RANGE, JUDGE);
    TEST_ASSERT_EQUAL_INT32(3, at_fault);
    b.takes[3] = RIGCAL_TAKES_SECOND; /* there is no such pose */
    ASSERT_STATUS(RIGCAL_ERR_RANGE, JUDGE);
    memset(b.takes, RIGCAL_TAKES_NONE, sizeof b.takes);
    ASSERT_STATUS(RIGCAL_ERR_TOO_FEW, JUDGE);
    memset(b.takes, 0, sizeof b.takes);
    b.own[4].sse = TEST_NAN;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, JUDGE);
    TEST_ASSERT_EQUAL_INT32(4, at_fault);
#undef JUDGE
}

TEST_MAIN()
{
    RUN_TEST(test_where_nothing_is_wrong_no_view_is_named);
    RUN_TEST(test_where_all_views_are_bent_no_view_is_named);
    RUN_TEST(test_replaced_views_are_named);
    RUN_TEST(test_reversed_views_are_named);
    RUN_TEST(test_views_of_swapped_cameras_are_named);
    RUN_TEST(test_a_camera_that_is_late_is_left_out);
    RUN_TEST(test_a_camera_that_is_left_out_does_not_count_for_the_limit);
    RUN_TEST(test_wrong_views_that_were_joined_are_named);
    RUN_TEST(test_a_named_view_does_not_touch_the_rig);
    RUN_TEST(test_the_only_right_view_of_a_camera_stays_if_its_pose_is_known);
    RUN_TEST(test_the_rig_is_adjusted_no_more_than_it_takes);
    RUN_TEST(test_of_two_views_that_contradict_each_other_both_are_named);
    RUN_TEST(test_of_a_camera_with_two_views_that_contradict_both_are_named);
    RUN_TEST(test_a_view_that_nobody_shares_is_unchecked);
    RUN_TEST(test_a_view_that_nobody_shares_is_unchecked_if_it_is_left_out_too);
    RUN_TEST(test_a_second_pose_is_taken_up);
    RUN_TEST(test_a_placement_that_is_taken_up_is_moved_to_its_views);
    RUN_TEST(test_the_same_bits_whatever_the_budgets);
    RUN_TEST(test_a_unit_of_an_adjustment_is_one_of_the_judge);
    RUN_TEST(test_a_source_that_fails_ends_the_judgement);
    RUN_TEST(test_what_cannot_be_judged_is_refused);
}
