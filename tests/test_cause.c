/* cause: why a view, or most views of a camera, contradict the others. The truth: rigs in
 * which the test made that error. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rigcal_solvers.h"
#include "test_boards.h"

static const double NOISE = 0.3;

static test_boards b;

#define WANTS_BOARDS TEST_WANTS_RAM(sizeof(test_boards) + 20000)

/* A board turned by half a turn, and two permutations that are no symmetries of it: a row
 * shifted, and points exchanged in pairs. */
enum { SHIFTED_ROWS, TURNED, PAIRS, PERMUTATIONS };
static int32_t permutations[PERMUTATIONS * BOARD_POINTS];
static rigcal_observation room[BOARD_POINTS];
static rigcal_symmetries symmetries = {permutations, PERMUTATIONS, BOARD_POINTS, room};

static void fill_permutations(void)
{
    for (int32_t i = 0; i < BOARD_POINTS; i++) {
        permutations[SHIFTED_ROWS * BOARD_POINTS + i] = (i + 5) % BOARD_POINTS;
        permutations[TURNED * BOARD_POINTS + i] = BOARD_POINTS - 1 - i;
        permutations[PAIRS * BOARD_POINTS + i] = i ^ 1;
    }
}

static void make(uint64_t seed, int n_cameras, int n_places)
{
    test_rng rng = test_seed(seed);

    fill_permutations();
    test_boards_make(&b, &rng, n_cameras, n_places, n_cameras, NOISE, 0);
}

/* Judges with poses joined at the truth. Of three cameras with one wrong, most pairs
 * disagree, and the choice would refuse. */
static rigcal_status judged(void)
{
    test_boards_solve(&b);
    test_boards_join(&b, NOISE);
    b.choice.sigma_px = RC(NOISE);
    return rigcal_rig_judge(&b.judgement, NULL, b.judged, b.left_out, &b.choice, &b.rig);
}

static void judge(void)
{
    TEST_ASSERT_TRUE(judged() > 0);
}

static rigcal_cause cause_of(int view)
{
    rigcal_cause cause;

    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_cause(&cause, &b.rig, &b.judgement, &symmetries,
                                              (size_t)view));
    return cause;
}

static rigcal_cause camera_cause(int camera)
{
    rigcal_cause cause;

    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_cause(&cause, &b.rig, &b.judgement, &symmetries,
                                                 (size_t)camera));
    return cause;
}

/* ---- one view -------------------------------------------------------------- */

static void test_a_turned_view_is_told_with_its_permutation(void)
{
    WANTS_BOARDS;
    for (int trial = 0; trial < TEST_TRIALS(10); trial++) {
        const int v = 3 * trial;

        make(3000 + (uint64_t)trial, 4, 8);
        test_boards_reverse(&b, v);
        judge();
        TEST_ASSERT_EQUAL_INT32(RIGCAL_VIEW_CONTRADICTS, b.judged[v].verdict);
        const rigcal_cause cause = cause_of(v);
        TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_TURNED, cause.cause);
        TEST_ASSERT_EQUAL_INT32(TURNED, cause.permutation);
        TEST_ASSERT_EQUAL_INT32(0, cause.shift);
        TEST_ASSERT_EQUAL_INT32(-1, cause.camera);
        TEST_ASSERT_TRUE(cause.distance >= 0 && D(cause.distance) < 0.8);
    }
}

/* The farther the pose of a turned view is off, the larger is `distance`. Beyond the limit
 * the cause is unknown. */
static void test_up_to_the_limit_the_cause_is_told(void)
{
    rigcal_real step = RC(0.002);
    int told = 0;

    WANTS_BOARDS;
    make(3000, 4, 8);
    test_boards_reverse(&b, 6);
    judge();
    rigcal_cause cause = cause_of(6);
    for (; cause.cause == RIGCAL_CAUSE_TURNED && told < 500; told++) {
        TEST_ASSERT_TRUE(cause.distance <= 1);
        for (int i = 0; i < BOARD_POINTS; i++) {
            b.o[6][i].uv[0] += 40 * step;
        }
        test_boards_solve_view(&b, 6);
        cause = cause_of(6);
    }
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_UNKNOWN, cause.cause);
    TEST_ASSERT_GREATER_THAN_INT(2, told);
}

/* Either of the two views may be the turned one. */
static void test_of_two_views_either_may_be_turned(void)
{
    WANTS_BOARDS;
    make(3100, 2, 8);
    test_boards_reverse(&b, 6);
    judge();
    for (int v = 6; v < 8; v++) {
        const rigcal_cause cause = cause_of(v);

        TEST_ASSERT_EQUAL_INT32(RIGCAL_VIEW_ONE_OF_TWO, b.judged[v].verdict);
        TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_TURNED, cause.cause);
        TEST_ASSERT_EQUAL_INT32(TURNED, cause.permutation);
    }
}

static void test_a_view_of_the_placement_before_or_after_is_told(void)
{
    WANTS_BOARDS;
    for (int trial = 0; trial < TEST_TRIALS(10); trial++) {
        const int f = 1 + trial % 6, shift = trial % 2 ? 1 : -1;

        make(3200 + (uint64_t)trial, 4, 8);
        const int v = test_boards_view(&b, 2, f);
        test_boards_replace(&b, v, test_boards_view(&b, 2, f + shift));
        judge();
        const rigcal_cause cause = cause_of(v);
        TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_SHIFTED, cause.cause);
        TEST_ASSERT_EQUAL_INT32(shift, cause.shift);
        TEST_ASSERT_EQUAL_INT32(0, cause.is_still);
        TEST_ASSERT_EQUAL_INT32(-1, cause.permutation);
    }
}

/* What one other camera saw of the placement before or after is enough. */
static void test_of_two_cameras_a_view_of_another_placement_is_told(void)
{
    WANTS_BOARDS;
    for (int trial = 0; trial < 4; trial++) {
        const int c = trial % 2, shift = trial / 2 ? 1 : -1;

        make(3250 + (uint64_t)trial, 2, 8);
        const int v = test_boards_view(&b, c, 4);
        test_boards_replace(&b, v, test_boards_view(&b, c, 4 + shift));
        judge();
        TEST_ASSERT_EQUAL_INT32(RIGCAL_VIEW_ONE_OF_TWO, b.judged[v].verdict);
        const rigcal_cause cause = cause_of(v);
        TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_SHIFTED, cause.cause);
        TEST_ASSERT_EQUAL_INT32(shift, cause.shift);
    }
}

/* The placements before and after are the same: the target stood still. */
static void test_of_a_target_that_stood_still_the_shift_is_open(void)
{
    WANTS_BOARDS;
    make(3300, 4, 8);
    for (int c = 0; c < 4; c++) {
        test_boards_replace(&b, test_boards_view(&b, c, 5), test_boards_view(&b, c, 3));
    }
    const int v = test_boards_view(&b, 1, 4);
    test_boards_replace(&b, v, test_boards_view(&b, 1, 3));
    judge();
    TEST_ASSERT_EQUAL_INT32(RIGCAL_VIEW_CONTRADICTS, b.judged[v].verdict);
    const rigcal_cause cause = cause_of(v);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_SHIFTED, cause.cause);
    TEST_ASSERT_EQUAL_INT32(1, cause.is_still);
}

/* Camera 3 gets a lens whose images are 1.25 times as large. */
static void give_a_longer_lens(void)
{
    static rigcal_camera lens;

    lens = b.camera;
    lens.fx = lens.fy = 1000;
    for (size_t v = 0; v < b.rig.n_views; v++) {
        if (b.views[v].camera == 3) {
            b.views[v].view.camera = &lens;
            for (int i = 0; i < BOARD_POINTS; i++) {
                b.o[v][i].uv[0] = b.camera.cx + (b.o[v][i].uv[0] - b.camera.cx) * RC(1.25);
                b.o[v][i].uv[1] = b.camera.cy + (b.o[v][i].uv[1] - b.camera.cy) * RC(1.25);
            }
        }
    }
}

/* The lenses differ. Each view is solved with the lens of the other. */
static void test_swapped_cameras_are_told(void)
{
    WANTS_BOARDS;
    make(3400, 4, 8);
    give_a_longer_lens();
    const int one = test_boards_view(&b, 3, 2), two = test_boards_view(&b, 0, 2);
    test_boards_swap(&b, one, two);
    judge();
    rigcal_cause cause = cause_of(one);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_SWAPPED, cause.cause);
    TEST_ASSERT_EQUAL_INT32(0, cause.camera);
    cause = cause_of(two);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_SWAPPED, cause.cause);
    TEST_ASSERT_EQUAL_INT32(3, cause.camera);
}

/* The view is of camera 0. But camera 0 has a view of this placement that agrees. It does
 * not matter that its view of the placement before or after is left out. */
static void test_a_view_is_swapped_only_with_one_of_its_placement(void)
{
    WANTS_BOARDS;
    for (int shift = -1; shift < 2; shift += 2) {
        make(3450, 4, 8);
        give_a_longer_lens();
        const int one = test_boards_view(&b, 3, 3), two = test_boards_view(&b, 0, 3);
        const int other = test_boards_view(&b, 0, 3 + shift);
        test_boards_replace(&b, one, two);
        test_boards_reverse(&b, other);
        judge();
        TEST_ASSERT_TRUE(b.left_out[one] && !b.left_out[two] && b.left_out[other]);
        TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_UNKNOWN, cause_of(one).cause);
        b.left_out[two] = 1;
        const rigcal_cause cause = cause_of(one);
        TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_SWAPPED, cause.cause);
        TEST_ASSERT_EQUAL_INT32(0, cause.camera);
    }
}

/* A view is replaced by one of a placement that is not near in time: it has no cause. */
static void test_of_other_views_the_cause_is_unknown(void)
{
    WANTS_BOARDS;
    for (int trial = 0; trial < TEST_TRIALS(10); trial++) {
        make(3500 + (uint64_t)trial, 4, 8);
        const int v = test_boards_view(&b, trial % 4, 1);
        test_boards_replace(&b, v, test_boards_view(&b, trial % 4, 6));
        judge();
        const rigcal_cause cause = cause_of(v);
        TEST_ASSERT_EQUAL_INT32(RIGCAL_VIEW_CONTRADICTS, b.judged[v].verdict);
        TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_UNKNOWN, cause.cause);
        TEST_ASSERT_EQUAL_INT32(-1, cause.permutation);
        TEST_ASSERT_EQUAL_INT32(-1, cause.camera);
    }
}

/* ---- a camera -------------------------------------------------------------- */

static void test_a_camera_is_late(void)
{
    WANTS_BOARDS;
    for (int c = 0; c < 4; c += TEST_HOST ? 1 : 3) {
        make(3600 + (uint64_t)c, 4, 8);
        test_boards_late(&b, c);
        judge();
        for (int other = 0; other < 4; other++) {
            const rigcal_cause cause = camera_cause(other);

            TEST_ASSERT_EQUAL_INT32(
                other == c ? RIGCAL_CAUSE_SHIFTED : RIGCAL_CAUSE_UNKNOWN, cause.cause);
            TEST_ASSERT_EQUAL_INT32(other == c ? -1 : 0, cause.shift);
            TEST_ASSERT_EQUAL_INT32(-1, cause.permutation);
            TEST_ASSERT_EQUAL_INT32(0, cause.is_still);
            TEST_ASSERT_TRUE(cause.n_agree >= 6 && cause.n_views <= 8);
        }
    }
}

static void test_a_camera_is_early(void)
{
    WANTS_BOARDS;
    make(3650, 3, 8);
    for (int f = 0; f < 7; f++) {
        test_boards_replace(&b, test_boards_view(&b, 1, f), test_boards_view(&b, 1, f + 1));
    }
    judge();
    const rigcal_cause cause = camera_cause(1);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_SHIFTED, cause.cause);
    TEST_ASSERT_EQUAL_INT32(1, cause.shift);
}

/* Two cameras. One of them has all its points in reverse, so no placement agrees. */
static void test_all_views_of_a_camera_are_turned(void)
{
    int32_t at_fault;

    WANTS_BOARDS;
    make(3700, 2, 8);
    for (int f = 0; f < 8; f++) {
        test_boards_reverse(&b, test_boards_view(&b, 1, f));
    }
    test_boards_solve(&b);
    ASSERT_STATUS(RIGCAL_ERR_CONTRADICTION,
                  rigcal_rig_choose(&b.choice, &at_fault, &b.rig));
    memset(b.left_out, 1, sizeof b.left_out);
    b.rig.left_out = b.left_out;
    b.judgement.sigma_px = RC(NOISE);
    b.judgement.scale = 1;
    for (int c = 0; c < 2; c++) {
        const rigcal_cause cause = camera_cause(c);

        TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_TURNED, cause.cause);
        TEST_ASSERT_EQUAL_INT32(TURNED, cause.permutation);
        TEST_ASSERT_EQUAL_INT32(0, cause.shift);
        TEST_ASSERT_EQUAL_INT32(-1, cause.camera);
        TEST_ASSERT_TRUE(cause.n_agree >= 7);
        TEST_ASSERT_EQUAL_INT32(8, cause.n_views);
    }
}

/* Moves the origin of the target this far from its points. */
static void shift_origin(double x, double y)
{
    const double shift[3] = {-x, -y, 0};
    const rigcal_transform middle_from_far = test_transform(NULL, shift);

    for (size_t v = 0; v < b.rig.n_views; v++) {
        for (int i = 0; i < BOARD_POINTS; i++) {
            b.o[v][i].X_w[0] += RC(x);
            b.o[v][i].X_w[1] += RC(y);
        }
    }
    for (size_t f = 0; f < b.rig.n_placements; f++) {
        b.true_places[f] = test_times(&b.true_places[f], &middle_from_far);
    }
}

/* The information about the shift of a far origin differs from that of a turned target's
 * origin. */
static void test_a_camera_is_turned_about_a_far_origin(void)
{
    WANTS_BOARDS;
    make(3750, 3, 8);
    shift_origin(5, 3.75);
    for (int f = 0; f < 8; f++) {
        test_boards_reverse(&b, test_boards_view(&b, 2, f));
    }
    judge();
    const rigcal_cause cause = camera_cause(2);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_TURNED, cause.cause);
    TEST_ASSERT_EQUAL_INT32(TURNED, cause.permutation);
    TEST_ASSERT_TRUE(cause.n_agree >= 7);
}

/* All views of camera 2 are turned, and moved by some pixels, each in its own way. */
static rigcal_cause cause_of_moved(uint64_t seed, double px, double origin)
{
    make(seed, 3, 8);
    shift_origin(origin, 0.75 * origin);
    for (int f = 0; f < 8; f++) {
        const int v = test_boards_view(&b, 2, f);

        test_boards_reverse(&b, v);
        for (int i = 0; i < BOARD_POINTS; i++) {
            b.o[v][i].uv[0] += RC(px * ((f * 5) % 8 - 3.5));
            b.o[v][i].uv[1] += RC(px * ((f * 3) % 8 - 3.5));
        }
    }
    (void)judged();
    b.judgement.sigma_px = RC(NOISE);
    b.judgement.scale = 1;
    return camera_cause(2);
}

/* How many views agree does not depend on where the target has its origin. */
static void test_the_origin_of_the_target_does_not_matter(void)
{
    WANTS_BOARDS;
    for (int trial = 0; trial < TEST_TRIALS(8); trial++) {
        const double px = 0.25 * pow(1.6, trial / 2);
        const uint64_t seed = 3750 + (uint64_t)trial;
        const rigcal_cause middle = cause_of_moved(seed, px, 0);
        const rigcal_cause far = cause_of_moved(seed, px, 5);

        TEST_ASSERT_TRUE(abs(far.n_agree - middle.n_agree) <= TOL(0, 1));
        TEST_ASSERT_EQUAL_INT32(middle.cause, far.cause);
    }
}

/* The first view of another camera is wrong by half a metre. The turn does not come from
 * it. */
static void test_a_turn_does_not_come_from_another_camera(void)
{
    WANTS_BOARDS;
    make(3790, 3, 8);
    for (int f = 0; f < 8; f++) {
        test_boards_reverse(&b, test_boards_view(&b, 2, f));
    }
    judge();
    b.own[0].cam_from_target.t[0] += RC(0.5);
    const rigcal_cause cause = camera_cause(2);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_TURNED, cause.cause);
    TEST_ASSERT_EQUAL_INT32(TURNED, cause.permutation);
}

/* Only one view of the camera shows the whole board. All other views, of other cameras too,
 * have fewer points than the symmetry. So the turn of the target can be found in that view
 * alone. */
static void test_a_turn_is_found_from_the_view_that_shows_the_whole_target(void)
{
    static const int CAMERA[4] = {0, 2, 1, 2}, PLACE[4] = {0, 0, 2, 3};

    WANTS_BOARDS;
    for (int trial = 0; trial < 4; trial++) {
        const int c = CAMERA[trial];

        make(3760 + (uint64_t)trial, 3, 4);
        for (int f = 0; f < 4; f++) {
            test_boards_reverse(&b, test_boards_view(&b, c, f));
        }
        for (size_t v = 0; v < b.rig.n_views; v++) {
            if (b.views[v].camera != c || b.views[v].placement != PLACE[trial]) {
                b.views[v].view.n = BOARD_POINTS - 1;
            }
        }
        judge();
        for (int camera = 0; camera < 3; camera++) {
            const rigcal_cause cause = camera_cause(camera);

            TEST_ASSERT_EQUAL_INT32(
                camera == c ? RIGCAL_CAUSE_TURNED : RIGCAL_CAUSE_UNKNOWN, cause.cause);
            TEST_ASSERT_EQUAL_INT32(camera == c ? TURNED : -1, cause.permutation);
        }
    }
}

/* Random views: no two agree, turned or not. */
static void test_of_a_camera_with_other_views_the_cause_is_unknown(void)
{
    WANTS_BOARDS;
    for (int trial = 0; trial < TEST_TRIALS(4); trial++) {
        make(3770 + (uint64_t)trial, 3, 8);
        shift_origin(5 * (trial % 2), 3.75 * (trial % 2));
        for (int f = 0; f < 8; f++) {
            const int v = test_boards_view(&b, 2, f);
            for (int i = 0; i < BOARD_POINTS; i++) { /* moves the view */
                b.o[v][i].uv[0] += RC(30 * ((f * 5) % 8 - 3.5));
                b.o[v][i].uv[1] += RC(30 * ((f * 3) % 8 - 3.5));
            }
            b.is_wrong[v] = 1;
        }
        judge();
        const rigcal_cause cause = camera_cause(2);
        TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_UNKNOWN, cause.cause);
        TEST_ASSERT_TRUE(cause.n_agree <= 2);
    }
}

/* The views of camera 0 say that it is farther to the right by these multiples of a step.
 * All else is exact. */
static rigcal_cause cause_of_shifts(const double multiple[3], double step)
{
    for (size_t v = 0; v < b.rig.n_views; v++) {
        const int32_t c = b.views[v].camera, f = b.views[v].placement;

        b.own[v].cam_from_target = test_times(&b.true_cams[c], &b.true_places[f]);
        b.own[v].cam_from_target.t[0] += RC(c == 0 ? multiple[f] * step : 0);
    }
    return camera_cause(0);
}

/* Two views agree up to some step. Of three in a row the one in the middle agrees with both
 * at 0.7 of it, but the outer ones not with each other. So three agree, whichever view is
 * the one in the middle. */
static void test_the_view_with_which_most_agree_may_be_any(void)
{
    static const double ONE[3] = {0, 0, 1};
    double step = 1e-5;

    TEST_ON_HOST_ONLY("a hundred answers until two are left");
    WANTS_BOARDS;
    make(4100, 3, 3);
    ASSERT_STATUS(RIGCAL_OK, judged());
    for (int i = 0; i < 36 * 3; i++) { /* the same for all views of a camera */
        b.own[i / 36 * 3].information[i % 21] = b.own[0].information[i % 21];
    }
    memcpy(b.cams, b.true_cams, sizeof b.cams);
    memcpy(b.places, b.true_places, sizeof b.places);
    while (cause_of_shifts(ONE, step).n_agree == 3) {
        step *= 1.05;
    }
    TEST_ASSERT_EQUAL_INT32(2, cause_of_shifts(ONE, step).n_agree);
    for (int middle = 0; middle < 3; middle++) {
        double multiple[3] = {-0.7, -0.7, 0.7};

        multiple[middle] = 0;
        multiple[(middle + 2) % 3] = 0.7;
        multiple[(middle + 1) % 3] = -0.7;
        const rigcal_cause cause = cause_of_shifts(multiple, step);
        TEST_ASSERT_EQUAL_INT32(3, cause.n_agree);
        TEST_ASSERT_EQUAL_INT32(3, cause.n_views);
    }
}

/* ---- views that stand still, agree by half, or say nothing ------------------ */

/* Gives the views of placement f the pixels of placement `from`. */
static void stand_still(int f, int from)
{
    for (int c = 0; c < (int)b.rig.n_cameras; c++) {
        test_boards_replace(&b, test_boards_view(&b, c, f), test_boards_view(&b, c, from));
    }
    b.true_places[f] = b.true_places[from];
}

/* The placements before and after differ only by noise. The nearer one is named. */
static void test_of_two_causes_the_nearer_is_told(void)
{
    int n_before = 0, n_after = 0;

    WANTS_BOARDS;
    for (int trial = 0; trial < TEST_TRIALS(12); trial++) {
        make(4000 + (uint64_t)trial, 4, 8);
        test_rng rng = test_seed(4020 + (uint64_t)trial);
        stand_still(5, 3);
        const int v = test_boards_view(&b, 1, 4);
        test_boards_replace(&b, v, test_boards_view(&b, 1, 3));
        for (int f = 3; f < 6; f++) {
            for (int c = 0; c < 4; c++) {
                for (int i = 0; i < 2 * BOARD_POINTS; i++) {
                    b.o[test_boards_view(&b, c, f)][i / 2].uv[i % 2] +=
                        RC(NOISE * test_normal(&rng));
                }
            }
        }
        judge();
        const rigcal_cause cause = cause_of(v);
        TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_SHIFTED, cause.cause);
        TEST_ASSERT_EQUAL_INT32(1, cause.is_still);
        n_before += cause.shift == -1;
        n_after += cause.shift == 1;
    }
    TEST_ASSERT_EQUAL_INT(TEST_TRIALS(12), n_before + n_after);
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || (n_before > 0 && n_after > 0));
}

/* The target moves to and fro, so one placement late is the same as one placement early. */
static void test_of_a_target_that_goes_to_and_fro_the_shift_of_a_camera_is_open(void)
{
    WANTS_BOARDS;
    make(4040, 3, 8);
    for (int f = 2; f < 8; f++) {
        stand_still(f, f - 2);
    }
    test_boards_late(&b, 1);
    judge();
    const rigcal_cause cause = camera_cause(1);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_SHIFTED, cause.cause);
    TEST_ASSERT_EQUAL_INT32(1, cause.is_still);
}

/* As many views agree unchanged as agree one placement late: nothing is wrong. */
static void test_of_a_target_that_stands_still_no_camera_is_late(void)
{
    WANTS_BOARDS;
    make(4050, 3, 8);
    for (int f = 1; f < 8; f++) {
        stand_still(f, 0);
    }
    ASSERT_STATUS(RIGCAL_OK, judged());
    for (int c = 0; c < 3; c++) {
        const rigcal_cause cause = camera_cause(c);
        TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_UNKNOWN, cause.cause);
        TEST_ASSERT_EQUAL_INT32(8, cause.n_agree);
    }
}

/* Three of eight views are one placement late. The others moved each by itself. */
static void test_a_few_views_that_are_late_are_not_the_camera(void)
{
    WANTS_BOARDS;
    make(4060, 3, 8);
    for (int f = 7; f >= 0; f--) {
        const int v = test_boards_view(&b, 2, f);
        if (f >= 1 && f <= 3) {
            test_boards_replace(&b, v, test_boards_view(&b, 2, f - 1));
        }
    }
    for (int f = 0; f < 8; f = f == 0 ? 4 : f + 1) {
        const int v = test_boards_view(&b, 2, f);
        for (int i = 0; i < BOARD_POINTS; i++) {
            b.o[v][i].uv[0] += RC(30 * ((f * 5) % 8 - 3.5));
            b.o[v][i].uv[1] += RC(30 * ((f * 3) % 8 - 3.5));
        }
    }
    judge();
    const rigcal_cause cause = camera_cause(2);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_UNKNOWN, cause.cause);
}

/* Half of the views of camera 2 are turned, and one more in the second trial. The others
 * moved each by itself. More than half must agree. */
static void test_half_of_its_views_are_not_the_camera(void)
{
    WANTS_BOARDS;
    for (int more = 0; more < 2; more++) {
        make(4065, 3, 8);
        for (int f = 0; f < 8; f++) {
            const int v = test_boards_view(&b, 2, f);

            if (f < 4 + more) {
                test_boards_reverse(&b, v);
                continue;
            }
            for (int i = 0; i < BOARD_POINTS; i++) {
                b.o[v][i].uv[0] += RC(30 * ((f * 5) % 8 - 3.5));
                b.o[v][i].uv[1] += RC(30 * ((f * 3) % 8 - 3.5));
            }
        }
        judge();
        const rigcal_cause cause = camera_cause(2);
        TEST_ASSERT_EQUAL_INT32(more ? RIGCAL_CAUSE_TURNED : RIGCAL_CAUSE_UNKNOWN,
                                cause.cause);
        TEST_ASSERT_EQUAL_INT32(8, cause.n_views);
        TEST_ASSERT_TRUE(more ? cause.n_agree == 5 : cause.n_agree < 4);
    }
}

/* The only view of camera 2 is of a placement that nobody else saw, so it agrees with one
 * camera that is late, and with one that is early. One view is not most views. */
static void test_a_single_view_does_not_say_that_its_camera_is_late(void)
{
    enum { F = 4 };
    size_t n = 0;

    WANTS_BOARDS;
    make(4070, 3, 8);
    TEST_ASSERT_TRUE(judged() >= 0);
    for (size_t v = 0; v < b.rig.n_views; v++) {
        if ((b.views[v].camera == 2) == (b.views[v].placement == F)) {
            b.views[n] = b.views[v];
            b.own[n] = b.own[v];
            b.left_out[n++] = b.left_out[v];
        }
    }
    b.rig.n_views = n;
    const rigcal_cause cause = camera_cause(2);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_UNKNOWN, cause.cause);
    TEST_ASSERT_EQUAL_INT32(0, cause.n_agree);
    TEST_ASSERT_EQUAL_INT32(0, cause.n_views);
}

/* Nobody else saw the placement of view 6, nor that before or after. So there is nothing
 * that the view could agree with, turned or not. */
static void test_a_view_alone_has_no_cause(void)
{
    size_t n = 0;

    WANTS_BOARDS;
    make(4075, 3, 6);
    ASSERT_STATUS(RIGCAL_OK, judged());
    for (size_t v = 0; v < b.rig.n_views; v++) {
        const int32_t f = b.views[v].placement;

        if (f < 2 || f > 4 || (f == 3 && b.views[v].camera == 1)) {
            b.views[n] = b.views[v];
            b.own[n++] = b.own[v];
        }
    }
    b.rig.n_views = n;
    b.rig.left_out = NULL;
    TEST_ASSERT_EQUAL_INT32(3, b.views[6].placement);
    const rigcal_cause cause = cause_of(6);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_UNKNOWN, cause.cause);
    TEST_ASSERT_EQUAL_INT32(-1, cause.permutation);
    TEST_ASSERT_EQUAL_INT32(0, cause.shift);
}

/* No turn can be found for a view whose pixels are no image of the target, for one without
 * pixels, and for one whose points are too far from their origin to show their
 * directions. */
static void test_a_view_that_cannot_be_solved_has_no_cause(void)
{
    WANTS_BOARDS;
    for (int way = 0; way < 3; way++) {
        test_rng rng = test_seed(4070);

        make(4070, 3, 4);
        ASSERT_STATUS(RIGCAL_OK, judged());
        for (int i = 0; i < BOARD_POINTS; i++) {
            for (int k = 0; k < 2 && way == 0; k++) {
                b.o[3][i].uv[k] = RC(test_uniform(&rng, -1e5, 1e5));
            }
            b.o[3][i].X_w[0] += RC(way == 2 ? TOL(1e8, 3e3) : 0);
        }
        if (way == 1) {
            b.views[3].view.observations = NULL;
        }
        TEST_ASSERT_EQUAL_INT32(0, b.views[3].camera);
        for (int is_camera = 0; is_camera < 2; is_camera++) {
            const rigcal_cause cause = is_camera ? camera_cause(0) : cause_of(3);

            TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_UNKNOWN, cause.cause);
            TEST_ASSERT_EQUAL_INT32(-1, cause.permutation);
        }
        memmove(b.o[0], b.o[3], sizeof b.o[0]); /* the first that is permuted */
        TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_UNKNOWN, camera_cause(0).cause);
    }
}

/* The other view has nearly no information on one turn about its camera's axes. Its
 * information can be inverted there, but not in the frame of the rig. */
static void test_against_a_view_that_knows_no_turn_there_is_no_cause(void)
{
    WANTS_BOARDS;
    make(4080, 2, 8);
    test_boards_reverse(&b, 6);
    judge();
    memset(b.left_out, 0, sizeof b.left_out);
    b.rig.left_out = b.left_out;
    for (int k = 0; k < 21; k++) {
        b.own[7].information[k] = 0;
    }
    for (int k = 0; k < 6; k++) {
        b.own[7].information[k < 3 ? (k * (7 - k)) / 2 : 15 + ((k - 3) * (10 - k)) / 2] =
            k == 0 ? RC(TOL(5e-15, 3e-6)) : RC(1e2);
    }
    const rigcal_cause cause = cause_of(6);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_UNKNOWN, cause.cause);
}

static rigcal_status pose_from(rigcal_view_pose *pose, size_t index, void *context)
{
    TEST_ASSERT_TRUE(index < b.rig.n_views);
    *pose = ((const rigcal_view_pose *)context)[index];
    return RIGCAL_OK;
}

static void test_poses_may_come_from_a_source(void)
{
    WANTS_BOARDS;
    make(4090, 3, 4);
    test_boards_reverse(&b, 4);
    judge();
    const rigcal_cause expected = cause_of(4);
    b.rig.view_poses = NULL;
    b.rig.view_pose_source = pose_from;
    b.rig.context = b.own;
    const rigcal_cause cause = cause_of(4);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_TURNED, cause.cause);
    TEST_ASSERT_EQUAL_MEMORY(&expected, &cause, sizeof cause);
}

/* Sources that fail once, in the call of number `fails`. */
static struct {
    long calls, fails;
} asked;

static rigcal_status fail_in_turn(void)
{
    asked.calls++;
    return (asked.calls == asked.fails) ? RIGCAL_ERR_WIDE_RAY : RIGCAL_OK;
}

static rigcal_status failing_pose(rigcal_view_pose *pose, size_t index, void *context)
{
    (void)context;
    TEST_ASSERT_TRUE(index < b.rig.n_views);
    *pose = b.own[index];
    return fail_in_turn();
}

static rigcal_status failing_view(rigcal_rig_view *view, size_t index, void *context)
{
    (void)context;
    TEST_ASSERT_TRUE(index < b.rig.n_views);
    *view = b.views[index];
    return fail_in_turn();
}

/* Whatever is read when a source fails, the status is that of the source, and there is no
 * result. Without a failure the cause is the same as from arrays. */
static void test_the_failure_of_a_source_is_told(void)
{
    WANTS_BOARDS;
    make(4110, 3, 3);
    test_boards_swap(&b, 4, 5);
    judge();
    for (int way = 0; way < 4; way++) {
        const int is_camera = way / 2, has_views = way % 2;
        const rigcal_cause expected = is_camera ? camera_cause(1) : cause_of(4);
        rigcal_cause cause;
        long calls;

        b.rig.views = has_views ? NULL : b.views;
        b.rig.view_source = has_views ? failing_view : NULL;
        b.rig.view_poses = has_views ? b.own : NULL;
        b.rig.view_pose_source = has_views ? NULL : failing_pose;
        asked.fails = asked.calls = 0;
        cause = is_camera ? camera_cause(1) : cause_of(4);
        TEST_ASSERT_EQUAL_MEMORY(&expected, &cause, sizeof cause);
        calls = asked.calls;
        TEST_ASSERT_GREATER_THAN_INT(0, calls);
        for (long k = 1; k <= calls; k += 1 + (k > 60 ? k / 8 : 0)) {
            asked.fails = k;
            asked.calls = 0;
            ASSERT_REFUSED(
                RIGCAL_ERR_WIDE_RAY, cause,
                is_camera
                    ? rigcal_camera_cause(&cause, &b.rig, &b.judgement, &symmetries, 1)
                    : rigcal_rig_cause(&cause, &b.rig, &b.judgement, &symmetries, 4));
            TEST_ASSERT_EQUAL_INT(k, asked.calls); /* nothing is read after it */
        }
        b.rig.views = b.views;
        b.rig.view_poses = b.own;
    }
}

/* The source gives no information any more after the search has begun. */
static rigcal_status pose_without_information(rigcal_view_pose *pose, size_t index,
                                              void *context)
{
    *pose = b.own[index];
    if (*(const int *)context) {
        memset(pose->information, 0, sizeof pose->information);
    }
    return RIGCAL_OK;
}

static void test_views_that_lose_their_information_are_degenerate(void)
{
    static rigcal_cause_solver solver;
    static int is_lost;

    WANTS_BOARDS;
    make(4120, 3, 3);
    test_boards_swap(&b, 4, 5);
    judge();
    b.rig.view_poses = NULL;
    b.rig.view_pose_source = pose_without_information;
    b.rig.context = &is_lost;
    for (int way = 0; way < 4; way++) {
        const rigcal_symmetries *const sym = (way % 2) ? &symmetries : NULL;
        rigcal_cause cause;

        is_lost = 0;
        ASSERT_STATUS(RIGCAL_OK,
                      way / 2
                          ? rigcal_camera_cause_begin(&solver, &b.rig, &b.judgement, sym, 1)
                          : rigcal_cause_begin(&solver, &b.rig, &b.judgement, sym, 4));
        is_lost = 1;
        ASSERT_STATUS(RIGCAL_OK, rigcal_cause_step(&solver, 100000));
        ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, cause, rigcal_cause_result(&cause, &solver));
    }
}

/* ---- steps and arguments --------------------------------------------------- */

static void test_the_same_bits_whatever_the_budgets(void)
{
    static rigcal_cause_solver solver;

    WANTS_BOARDS;
    make(3800, 3, 6);
    test_boards_late(&b, 1);
    judge();
    for (int is_camera = 0; is_camera < 2; is_camera++) {
        const size_t number = is_camera ? 1 : (size_t)test_boards_view(&b, 1, 3);
        const rigcal_cause whole = is_camera ? camera_cause(1) : cause_of((int)number);

        int units = 0; /* of all */
        for (int32_t budget = 1; budget < 60; budget += 13) {
            int calls = 0;
            rigcal_cause cause;
            rigcal_status status =
                is_camera ? rigcal_camera_cause_begin(&solver, &b.rig, &b.judgement,
                                                      &symmetries, number)
                          : rigcal_cause_begin(&solver, &b.rig, &b.judgement, &symmetries,
                                               number);

            ASSERT_STATUS(RIGCAL_OK, status);
            ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_cause_result(&cause, &solver));
            do {
                status = rigcal_cause_step(&solver, budget);
                calls++;
            } while (status == RIGCAL_RUNNING);
            units = (budget == 1) ? calls : units;
            TEST_ASSERT_EQUAL_INT((units + budget - 1) / budget, calls);
            ASSERT_STATUS(RIGCAL_OK, rigcal_cause_result(&cause, &solver));
            TEST_ASSERT_EQUAL_MEMORY(&whole, &cause, sizeof cause);
        }
    }
}

/* Without symmetries, and beside views that are kept, the view is solved once, as it is.
 * Each step of that solver is a unit. There is one more that begins it, one for each view
 * of the placement, and one that ends. */
static void test_a_step_of_a_pose_is_a_unit(void)
{
    static rigcal_cause_solver solver;
    int in_pose = 0, units = 0;

    WANTS_BOARDS;
    make(3850, 3, 6);
    const int v = test_boards_view(&b, 1, 3);
    test_boards_replace(&b, v, test_boards_view(&b, 1, 2));
    judge();
    TEST_ASSERT_EQUAL_INT32(1, b.judgement.n_contradict);
    ASSERT_STATUS(RIGCAL_OK, rigcal_pose_begin(&solver.pose, NULL, &b.views[v].view, NULL));
    for (in_pose = 1; rigcal_pose_step(&solver.pose, 1) == RIGCAL_RUNNING; in_pose++) {
    }
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_cause_begin(&solver, &b.rig, &b.judgement, NULL, (size_t)v));
    for (units = 1; rigcal_cause_step(&solver, 1) == RIGCAL_RUNNING; units++) {
    }
    TEST_ASSERT_EQUAL_INT(in_pose + 1 + 3 + 1, units);
}

static void test_permutations_are_checked(void)
{
    rigcal_cause cause;

    WANTS_BOARDS;
    make(3900, 3, 4);
    test_boards_reverse(&b, 2);
    judge();
#define CAUSE rigcal_rig_cause(&cause, &b.rig, &b.judgement, &symmetries, 2)
    permutations[PAIRS * BOARD_POINTS + 4] = BOARD_POINTS;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, cause, CAUSE);
    permutations[PAIRS * BOARD_POINTS + 4] = -1;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, cause, CAUSE);
    permutations[PAIRS * BOARD_POINTS + 4] = 4; /* twice */
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, cause, CAUSE);
    for (int32_t way = 0; way < 3; way++) { /* the first point too */
        fill_permutations();
        permutations[0] = (way == 0) ? -1 : (way == 1) ? BOARD_POINTS : permutations[1];
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, cause, CAUSE);
    }
    fill_permutations();
    ASSERT_STATUS(RIGCAL_OK, CAUSE);
    symmetries.n_points = 2;
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, cause, CAUSE);
    symmetries.n_points = 3; /* the fewest of a target: the points take turns */
    symmetries.n_permutations = 1;
    for (int32_t i = 0; i < 3; i++) {
        permutations[i] = (i + 1) % 3;
    }
    ASSERT_STATUS(RIGCAL_OK, CAUSE);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_UNKNOWN, cause.cause);
    symmetries.n_permutations = PERMUTATIONS;
    fill_permutations();
    symmetries.n_points = BOARD_POINTS / 2; /* no view has this number of points */
    permutations[5] = 0;
    symmetries.n_permutations = 1;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, cause, CAUSE);
    for (int32_t i = 0; i < BOARD_POINTS / 2; i++) {
        permutations[i] = i;
    }
    ASSERT_STATUS(RIGCAL_OK, CAUSE);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_UNKNOWN, cause.cause);
    symmetries = (rigcal_symmetries){permutations, PERMUTATIONS, BOARD_POINTS, room};
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, cause,
                   rigcal_rig_cause(&cause, &b.rig, &b.judgement, NULL, 12));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, cause,
                   rigcal_camera_cause(&cause, &b.rig, &b.judgement, NULL, 3));
    b.judgement.scale = 0;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, cause,
                   rigcal_rig_cause(&cause, &b.rig, &b.judgement, NULL, 2));
#undef CAUSE
}

/* Counts that no array can have; no permutation; a rig without views. */
static void test_counts_of_symmetries_are_checked(void)
{
    rigcal_cause cause;

    WANTS_BOARDS;
    make(3950, 3, 4);
    test_boards_reverse(&b, 2);
    judge();
#define CAUSE rigcal_rig_cause(&cause, &b.rig, &b.judgement, &symmetries, 2)
    symmetries.n_points = SIZE_MAX;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, cause, CAUSE);
    symmetries.n_points = BOARD_POINTS;
    symmetries.n_permutations = SIZE_MAX;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, cause, CAUSE);
    symmetries.n_points = 2; /* a count that can be is no reason to refuse */
    symmetries.n_permutations = (size_t)1 << 28;
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, cause, CAUSE);
    symmetries.n_points = BOARD_POINTS;
    symmetries.n_permutations = 0;
    ASSERT_STATUS(RIGCAL_OK, CAUSE);
    TEST_ASSERT_NOT_EQUAL_INT32(RIGCAL_CAUSE_TURNED, cause.cause);
    symmetries.n_permutations = PERMUTATIONS;
    b.own[8].placement -= 2; /* not in the order of placements */
    ASSERT_REFUSED(RIGCAL_ERR_UNSORTED, cause, CAUSE);
    b.own[8].placement += 2;
    b.rig.views = NULL;
    ASSERT_REFUSED(RIGCAL_ERR_NULL, cause, CAUSE);
    b.rig.views = b.views;
    b.rig.view_poses = NULL;
    ASSERT_REFUSED(RIGCAL_ERR_NULL, cause, CAUSE);
#undef CAUSE
}

/* A camera without views, or whose views have other points than the symmetry. */
static void test_a_camera_that_has_nothing_to_turn(void)
{
    rigcal_cause cause;

    WANTS_BOARDS;
    make(3960, 3, 4);
    test_boards_reverse(&b, 2);
    judge();
    symmetries.n_points = BOARD_POINTS / 2;
    symmetries.n_permutations = 1;
    for (int32_t i = 0; i < BOARD_POINTS / 2; i++) {
        permutations[i] = i;
    }
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_camera_cause(&cause, &b.rig, &b.judgement, &symmetries, 1));
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_UNKNOWN, cause.cause);
    TEST_ASSERT_EQUAL_INT32(-1, cause.permutation);
    symmetries = (rigcal_symmetries){permutations, PERMUTATIONS, BOARD_POINTS, room};
    fill_permutations();
    for (size_t v = 0; v < b.rig.n_views; v++) {
        b.left_out[v] = 1;
    }
    b.rig.left_out = b.left_out;
    b.cams[3] = b.cams[2];
    b.rig.n_cameras = 4;
    b.rig.view_pose_source = pose_from; /* no view beyond the last one is asked for */
    b.rig.context = b.own;
    for (int is_source = 0; is_source < 2; is_source++) {
        b.rig.view_poses = is_source ? NULL : b.own;
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_camera_cause(&cause, &b.rig, &b.judgement, &symmetries, 3));
        TEST_ASSERT_EQUAL_INT32(RIGCAL_CAUSE_UNKNOWN, cause.cause);
        TEST_ASSERT_EQUAL_INT32(0, cause.n_views);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_turned_view_is_told_with_its_permutation);
    RUN_TEST(test_up_to_the_limit_the_cause_is_told);
    RUN_TEST(test_of_two_views_either_may_be_turned);
    RUN_TEST(test_a_view_of_the_placement_before_or_after_is_told);
    RUN_TEST(test_of_two_cameras_a_view_of_another_placement_is_told);
    RUN_TEST(test_of_a_target_that_stood_still_the_shift_is_open);
    RUN_TEST(test_swapped_cameras_are_told);
    RUN_TEST(test_a_view_is_swapped_only_with_one_of_its_placement);
    RUN_TEST(test_of_other_views_the_cause_is_unknown);
    RUN_TEST(test_a_camera_is_late);
    RUN_TEST(test_a_camera_is_early);
    RUN_TEST(test_all_views_of_a_camera_are_turned);
    RUN_TEST(test_a_camera_is_turned_about_a_far_origin);
    RUN_TEST(test_the_origin_of_the_target_does_not_matter);
    RUN_TEST(test_a_turn_does_not_come_from_another_camera);
    RUN_TEST(test_a_turn_is_found_from_the_view_that_shows_the_whole_target);
    RUN_TEST(test_of_a_camera_with_other_views_the_cause_is_unknown);
    RUN_TEST(test_the_view_with_which_most_agree_may_be_any);
    RUN_TEST(test_of_two_causes_the_nearer_is_told);
    RUN_TEST(test_of_a_target_that_goes_to_and_fro_the_shift_of_a_camera_is_open);
    RUN_TEST(test_of_a_target_that_stands_still_no_camera_is_late);
    RUN_TEST(test_a_few_views_that_are_late_are_not_the_camera);
    RUN_TEST(test_half_of_its_views_are_not_the_camera);
    RUN_TEST(test_a_single_view_does_not_say_that_its_camera_is_late);
    RUN_TEST(test_a_view_alone_has_no_cause);
    RUN_TEST(test_a_view_that_cannot_be_solved_has_no_cause);
    RUN_TEST(test_against_a_view_that_knows_no_turn_there_is_no_cause);
    RUN_TEST(test_poses_may_come_from_a_source);
    RUN_TEST(test_the_failure_of_a_source_is_told);
    RUN_TEST(test_views_that_lose_their_information_are_degenerate);
    RUN_TEST(test_the_same_bits_whatever_the_budgets);
    RUN_TEST(test_a_step_of_a_pose_is_a_unit);
    RUN_TEST(test_permutations_are_checked);
    RUN_TEST(test_counts_of_symmetries_are_checked);
    RUN_TEST(test_a_camera_that_has_nothing_to_turn);
}
