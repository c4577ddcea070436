/* grow: which of its two poses each view has, with the cameras and placements that follow.
 * The truth: NumPy, and simulated rigs of square tags. */
#include <math.h>
#include <string.h>

#include "test_fit.h"
#include "test_tags.h"
#include "vectors_choice.h"

enum { C_MAX = 6, F_MAX = 20, V_MAX = C_MAX * F_MAX };

TEST_TAGS(t, C_MAX, F_MAX);

#define WANTS_RIG TEST_WANTS_RAM(V_MAX * 1200)

/* Starts with arrays full of other values, which must not matter. */
static rigcal_status choose(void)
{
    int32_t at_fault = -2;
    rigcal_status status;

    memset(t.cams, 0, C_MAX * sizeof t.cams[0]);
    memset(t.places, 0, F_MAX * sizeof t.places[0]);
    memset(t.takes, 9, V_MAX);
    status = rigcal_rig_choose(&t.choice, &at_fault, &t.rig);
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
    return status;
}

static void simulate(test_rng *rng, int C, int F, double distance, double share)
{
    t.distance = distance;
    t.share_seen = share;
    t.noise_px = 0.3;
    test_tags_random(&t, rng, C, F);
    test_tags_solve(&t);
}

/* ---- golden vectors ------------------------------------------------------ */

static void golden(void)
{
    static const int AT[6][6] = {{0, 1, 2, 6, 7, 8},      {1, 3, 4, 9, 10, 11},
                                 {2, 4, 5, 12, 13, 14},   {6, 9, 12, 15, 16, 17},
                                 {7, 10, 13, 16, 18, 19}, {8, 11, 14, 17, 19, 20}};
    test_rng rng = test_seed(1);
    size_t n = 0;

    t.share_seen = 0;
    test_tags_random(&t, &rng, 4, 6);
    memset(t.second, 0, V_MAX * sizeof t.second[0]);
    for (int i = 0; i < CHOICE_POSE_ROWS; i++) {
        const double *const v = CHOICE_POSE[i];
        const int is_second = v[2] > 0;
        rigcal_view_pose *const pose = is_second ? &t.second[n - 1] : &t.own[n++];
        int k = 9;

        memset(pose, 0, sizeof *pose);
        pose->camera = (int32_t)v[0];
        pose->placement = (int32_t)v[1];
        pose->n = 4;
        pose->sse = RC(v[30]);
        pose->cam_from_target = test_from_ypr(&v[3], &v[6]);
        for (int row = 0; row < 6; row++) {
            for (int column = row; column < 6; column++) {
                pose->information[AT[row][column]] = RC(v[k++]);
            }
        }
    }
    t.rig.n_views = n;
    t.rig.sigma_px = RC(0.3);
}

static void test_golden_vectors(void)
{
    WANTS_RIG;
    golden();
    ASSERT_STATUS(RIGCAL_OK, choose());
    ASSERT_NEAR(CHOICE_ANSWER[0][0], t.choice.tau2, 0);
    ASSERT_NEAR(CHOICE_ANSWER[0][1], t.choice.share, TOL(1e-12, 1e-6));
    ASSERT_NEAR(0.3, t.choice.sigma_px, TOL(1e-12, 1e-6));
    TEST_ASSERT_EQUAL(CHOICE_TAKES_ROWS, t.rig.n_views);
    for (size_t v = 0; v < t.rig.n_views; v++) {
        TEST_ASSERT_EQUAL((int)CHOICE_TAKES[v][2], t.takes[v]);
    }
    TEST_ASSERT_EQUAL(1, t.choice.n_left_out);
    for (int c = 0; c < 4; c++) {
        ASSERT_ARRAY_NEAR(CHOICE_CAMERA[c], t.cams[c].R, 9, TOL(1e-10, 1e-4));
        ASSERT_ARRAY_NEAR(&CHOICE_CAMERA[c][9], t.cams[c].t, 3, TOL(1e-9, 1e-3));
    }
    for (int f = 0; f < 6; f++) {
        ASSERT_ARRAY_NEAR(CHOICE_PLACE[f], t.places[f].R, 9, TOL(1e-10, 1e-4));
        ASSERT_ARRAY_NEAR(&CHOICE_PLACE[f][9], t.places[f].t, 3, TOL(1e-9, 1e-3));
    }
}

/* ---- tags ---------------------------------------------------------------- */

/* The share of wrong poses among all, over many rigs. */
static double wrong_share(uint64_t seed, int rigs, int C, int F, double distance,
                          double share, double *first)
{
    test_rng rng = test_seed(seed);
    double views = 0, wrong = 0;

    *first = 0;
    for (int i = 0; i < rigs; i++) {
        simulate(&rng, C, F, distance, share);
        TEST_ASSERT_TRUE(choose() >= 0);
        wrong += test_tags_wrong(&t);
        *first += test_tags_wrong_first(&t);
        views += (double)t.rig.n_views;
    }
    *first /= views;
    return wrong / views;
}

static void test_most_tags_take_their_right_pose(void)
{
    double first;

    WANTS_RIG;
    TEST_ON_HOST_ONLY("a share of many views");
    TEST_ASSERT_TRUE(wrong_share(521, 25, 4, 10, 10, 1, &first) <= 0.002);
    TEST_ASSERT_TRUE(wrong_share(522, 25, 4, 10, 20, 1, &first) <= 0.005);
    TEST_ASSERT_TRUE(first > 0.05);
    TEST_ASSERT_TRUE(wrong_share(523, 25, 4, 10, 30, 1, &first) <= 0.01);
    TEST_ASSERT_TRUE(first > 0.15);
}

static void test_tags_of_which_a_part_is_seen(void)
{
    double first;

    WANTS_RIG;
    TEST_ON_HOST_ONLY("a share of many views");
    TEST_ASSERT_TRUE(wrong_share(524, 60, 4, 20, 20, 0.5, &first) <= 0.02);
    TEST_ASSERT_TRUE(wrong_share(525, 60, 6, 20, 20, 1 / 3., &first) <= 0.02);
}

/* Starts a little away from the truth. The adjustment must end in the same minimum as from
 * the truth. */
static void test_the_adjustment_from_the_choice_is_right(void)
{
    test_rng rng = test_seed(526);

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(6); trial++) {
        rigcal_rig_fit chosen, truth;

        simulate(&rng, 4, 10, 20, 1);
        ASSERT_STATUS(RIGCAL_OK, choose());
        t.rig.view_poses = NULL;
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&chosen, NULL, &t.rig));
        memcpy(t.cams, t.true_cams, C_MAX * sizeof t.cams[0]);
        memcpy(t.places, t.true_places, F_MAX * sizeof t.places[0]);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&truth, NULL, &t.rig));
        ASSERT_NEAR(D(truth.sum), chosen.sum, TOL(1e-6, 1e-3) * D(truth.sum));
    }
}

/* ---- the same answer ----------------------------------------------------- */

static void shuffle(int order[], int n, test_rng *rng)
{
    for (int i = 0; i < n; i++) {
        const int k = (int)(test_next(rng) % (uint64_t)(i + 1));

        order[i] = order[k];
        order[k] = i;
    }
}

static void test_the_order_does_not_matter(void)
{
    static rigcal_rig_view views[V_MAX];
    static rigcal_view_pose own[V_MAX], second[V_MAX];
    static uint8_t takes[V_MAX];
    static int from[V_MAX];
    static rigcal_transform cams[C_MAX];
    test_rng rng = test_seed(531);

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(12); trial++) {
        int camera[C_MAX], placement[F_MAX];
        const int C = 3 + trial % 4;
        size_t n = 0;

        simulate(&rng, C, 10, 15, trial % 2 ? 1 : 0.8);
        TEST_ASSERT_TRUE(choose() >= 0);
        memcpy(views, t.views, sizeof views);
        memcpy(own, t.own, sizeof own);
        memcpy(second, t.second, sizeof second);
        memcpy(takes, t.takes, sizeof takes);
        memcpy(cams, t.cams, sizeof cams);
        shuffle(camera, C, &rng);
        shuffle(placement, 10, &rng);
        for (int f = 0; f < 10;
             f++) { /* number f is placement[f]; the order of cameras is reversed */
            for (size_t v = t.rig.n_views; v-- > 0;) {
                if (views[v].placement == placement[f]) {
                    from[n] = (int)v;
                    t.own[n] = own[v];
                    t.second[n] = second[v];
                    t.own[n].camera = t.second[n].camera = camera[own[v].camera];
                    t.own[n].placement = t.second[n].placement = f;
                    n++;
                }
            }
        }
        TEST_ASSERT_EQUAL(t.rig.n_views, n);
        TEST_ASSERT_TRUE(choose() >= 0);
        for (size_t v = 0; v < n; v++) {
            TEST_ASSERT_EQUAL_UINT8(takes[from[v]], t.takes[v]);
        }
        for (int c = 1; c < C; c++) { /* relative to camera 0, from a start */
            const rigcal_transform back = test_inverse(&t.cams[camera[0]]);
            const rigcal_transform now = test_times(&t.cams[camera[c]], &back);

            ASSERT_TRANSFORM(&cams[c], &now, TOL(1e-8, 1e-3), TOL(1e-7, 1e-2));
        }
    }
}

static void test_the_same_bits_whatever_the_budgets(void)
{
    static rigcal_transform cams[C_MAX], places[F_MAX];
    static uint8_t takes[V_MAX];
    test_rng rng = test_seed(532);

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(9); trial++) {
        rigcal_choose_solver solver;
        rigcal_choice one;
        rigcal_status status = RIGCAL_RUNNING;
        int32_t at_fault = -2;

        simulate(&rng, 4, 10, 20, trial % 3 ? 1 : 0.5);
        TEST_ASSERT_TRUE(choose() >= 0);
        memcpy(cams, t.cams, sizeof cams);
        memcpy(places, t.places, sizeof places);
        memcpy(takes, t.takes, sizeof takes);
        one = t.choice;
        memset(t.cams, 0, C_MAX * sizeof t.cams[0]);
        memset(t.places, 0, F_MAX * sizeof t.places[0]);
        memset(t.takes, 9, V_MAX);
        ASSERT_STATUS(RIGCAL_OK, rigcal_choose_begin(&solver, &t.choice, &t.rig));
        while (status == RIGCAL_RUNNING) {
            int32_t budget = trial % 2 ? 1 : 1 + (int32_t)(test_next(&rng) % 50);
            rigcal_choose_solver moved;

            at_fault = 7;
            ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_choose_result(&at_fault, &solver));
            TEST_ASSERT_EQUAL_INT32(-1, at_fault);
            status = rigcal_choose_step(&solver, budget);
            moved = solver; /* the solver may be copied */
            memset(&solver, 0x55, sizeof solver);
            solver = moved;
        }
        ASSERT_STATUS(RIGCAL_OK, status);
        TEST_ASSERT_TRUE(rigcal_choose_result(&at_fault, &solver) >= 0);
        TEST_ASSERT_EQUAL_INT32(-1, at_fault);
        TEST_ASSERT_EQUAL_MEMORY(cams, t.cams, t.rig.n_cameras * sizeof cams[0]);
        TEST_ASSERT_EQUAL_MEMORY(places, t.places, t.rig.n_placements * sizeof places[0]);
        TEST_ASSERT_EQUAL_MEMORY(takes, t.takes, t.rig.n_views);
        TEST_ASSERT_EQUAL_MEMORY(&one.sigma_px, &t.choice.sigma_px, sizeof one.sigma_px);
    }
}

/* Pixels twice as large: half the noise, and a quarter of the information. */
static void double_pixels(void)
{
    for (size_t v = 0; v < t.rig.n_views; v++) {
        for (int k = 0; k < 21; k++) {
            t.own[v].information[k] /= 4;
            t.second[v].information[k] /= 4;
        }
        t.own[v].sse /= 4;
        t.second[v].sse /= 4;
    }
    t.rig.sigma_px /= 2;
}

/* If pixels are larger by a power of two, all information and all noise are scaled exactly.
 * So the choice is the same, bit by bit. Here all cameras see placement 0. The last two
 * see it best, and are the only ones that see placement 1. */
static void test_the_size_of_a_pixel_changes_no_bit(void)
{
    static rigcal_transform cams[C_MAX], places[2];
    static uint8_t takes[C_MAX + 2];

    WANTS_RIG;
    for (uint64_t trial = 0; trial < (uint64_t)TEST_TRIALS(10); trial++) {
        test_rng rng = test_seed(5360 + trial);
        size_t n = 0;

        simulate(&rng, C_MAX, 2, 10, 1);
        for (size_t v = 0; v < t.rig.n_views; v++) {
            const int is_last = t.own[v].camera >= C_MAX - 2;

            if (is_last || t.own[v].placement == 0) {
                t.own[n] = t.own[v];
                t.second[n] = t.second[v];
                for (int k = 0; k < 21; k++) {
                    t.own[n].information[k] *= RC(is_last ? 1 : 0.001);
                    t.second[n].information[k] *= RC(is_last ? 1 : 0.001);
                }
                n++;
            }
        }
        t.rig.n_views = n;
        t.rig.sigma_px = RC(0.3);
        const rigcal_status status = choose();
        TEST_ASSERT_TRUE(status >= 0);
        memcpy(cams, t.cams, sizeof cams);
        memcpy(places, t.places, sizeof places);
        memcpy(takes, t.takes, sizeof takes);
        for (int times = 0; times < 15; times++) {
            double_pixels();
            ASSERT_STATUS(status, choose());
            TEST_ASSERT_EQUAL_MEMORY(cams, t.cams, sizeof cams);
            TEST_ASSERT_EQUAL_MEMORY(places, t.places, sizeof places);
            TEST_ASSERT_EQUAL_MEMORY(takes, t.takes, sizeof takes);
        }
    }
}

/* How many steps of this budget a choice takes. */
static int steps_of(int32_t budget)
{
    rigcal_choose_solver solver;
    int n = 1;

    ASSERT_STATUS(RIGCAL_OK, rigcal_choose_begin(&solver, &t.choice, &t.rig));
    while (rigcal_choose_step(&solver, budget) == RIGCAL_RUNNING) {
        n++;
    }
    return n;
}

/* The first units read one view each. */
static void test_a_budget_is_a_number_of_units(void)
{
    test_rng rng = test_seed(536);
    rigcal_choose_solver solver;

    WANTS_RIG;
    simulate(&rng, 3, 6, 10, 1);
    ASSERT_STATUS(RIGCAL_OK, rigcal_choose_begin(&solver, &t.choice, &t.rig));
    for (size_t v = 1; v < 6; v++) {
        ASSERT_STATUS(RIGCAL_RUNNING, rigcal_choose_step(&solver, 1));
        TEST_ASSERT_EQUAL(v, solver.check.view);
    }
    const int units = steps_of(1);
    for (int32_t budget = 2; budget < 40; budget++) {
        TEST_ASSERT_EQUAL_INT((units + budget - 1) / budget, steps_of(budget));
    }
}

static rigcal_status first_from(rigcal_view_pose *pose, size_t index, void *context)
{
    *pose = ((test_tags *)context)->own[index];
    return RIGCAL_OK;
}

static rigcal_status second_from(rigcal_view_pose *pose, size_t index, void *context)
{
    *pose = ((test_tags *)context)->second[index];
    return RIGCAL_OK;
}

static rigcal_status broken(rigcal_view_pose *pose, size_t index, void *context)
{
    *pose = ((test_tags *)context)->second[index];
    return index == 5 ? RIGCAL_ERR_DAMAGED : RIGCAL_OK;
}

static void test_poses_from_sources(void)
{
    static rigcal_transform cams[C_MAX];
    test_rng rng = test_seed(533);
    int32_t at_fault;

    WANTS_RIG;
    simulate(&rng, 3, 8, 20, 1);
    ASSERT_STATUS(RIGCAL_OK, choose());
    memcpy(cams, t.cams, sizeof cams);
    t.rig.view_poses = NULL;
    t.rig.view_pose_source = first_from;
    t.rig.context = &t;
    t.choice.second_poses = NULL;
    t.choice.second_source = second_from;
    ASSERT_STATUS(RIGCAL_OK, choose());
    TEST_ASSERT_EQUAL_MEMORY(cams, t.cams, 3 * sizeof cams[0]);
    t.choice.second_source = broken;
    ASSERT_STATUS(RIGCAL_ERR_DAMAGED, rigcal_rig_choose(&t.choice, &at_fault, &t.rig));
    TEST_ASSERT_EQUAL_INT32(5, at_fault);
}

/* A source that gives view 1 the placement 0 at call number `lie`. */
static struct {
    int asked, lie;
} liar;

static rigcal_status lying(rigcal_view_pose *pose, size_t index, void *context)
{
    *pose = ((test_tags *)context)->own[index];
    if (index == 1 && ++liar.asked == liar.lie) {
        pose->placement = 0;
    }
    return RIGCAL_OK;
}

/* Two cameras that share no placement stay apart, even if a source says once that they
 * share one. */
static void test_a_placement_that_a_source_changes_joins_nothing(void)
{
    test_rng rng = test_seed(535);

    WANTS_RIG;
    for (liar.lie = 1; liar.lie < 6; liar.lie++) {
        simulate(&rng, 2, 2, 8, 1);
        t.own[1] = t.own[3]; /* camera 1 in placement 1 */
        t.rig.n_views = 2;
        t.rig.view_poses = NULL;
        t.rig.view_pose_source = lying;
        t.rig.context = &t;
        t.choice.second_poses = NULL;
        liar.asked = 0;
        const rigcal_status status = rigcal_rig_choose(&t.choice, NULL, &t.rig);
        TEST_ASSERT_TRUE(liar.asked >= 3);
        TEST_ASSERT_TRUE(liar.lie < 3 || status == RIGCAL_DISCONNECTED);
    }
}

/* Without second poses, the choice is a join that leaves out what does not agree. */
static void test_without_second_poses(void)
{
    test_rng rng = test_seed(534);

    WANTS_RIG;
    simulate(&rng, 4, 8, 8, 1);
    t.choice.second_poses = NULL;
    ASSERT_STATUS(RIGCAL_OK, choose());
    TEST_ASSERT_EQUAL(0, t.choice.n_left_out);
    for (size_t v = 0; v < t.rig.n_views; v++) {
        TEST_ASSERT_EQUAL_UINT8(RIGCAL_TAKES_FIRST, t.takes[v]);
    }
}

/* ---- wrong views --------------------------------------------------------- */

static void test_a_wrong_view_is_left_out(void)
{
    test_rng rng = test_seed(541);

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(10); trial++) {
        const size_t bad = trial > 0 ? (size_t)(test_next(&rng) % 40) : 0;
        const size_t like = (bad + 4) % 40;

        simulate(&rng, 4, 10, 10, 1);
        t.own[bad].cam_from_target = t.own[like].cam_from_target;
        t.second[bad].n = 0;
        ASSERT_STATUS(RIGCAL_OK, choose());
        TEST_ASSERT_EQUAL(1, t.choice.n_left_out);
        TEST_ASSERT_EQUAL_UINT8(RIGCAL_TAKES_NONE, t.takes[bad]);
    }
}

/* Every view is from another rig: nothing agrees, and nothing is written. */
static void test_views_that_contradict_each_other(void)
{
    rigcal_transform cams[C_MAX];
    test_rng rng = test_seed(542);
    int32_t at_fault = -2;

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(10); trial++) {
        simulate(&rng, 4, 10, 10, 1);
        for (size_t v = 0; v < t.rig.n_views; v++) {
            const double shift[3] = {test_normal(&rng), test_normal(&rng), 10};

            double R[9];
            test_random_rotation(R, &rng);
            t.own[v].cam_from_target = test_transform(R, shift);
            t.second[v].n = 0;
        }
        test_fill(t.cams, sizeof cams);
        memcpy(cams, t.cams, sizeof cams);
        ASSERT_STATUS(RIGCAL_ERR_CONTRADICTION,
                      rigcal_rig_choose(&t.choice, &at_fault, &t.rig));
        TEST_ASSERT_EQUAL_INT32(-1, at_fault);
        TEST_ASSERT_EQUAL_MEMORY(cams, t.cams, sizeof cams);
        TEST_ASSERT_TRUE(D(t.choice.share) < 0.5);
    }
}

/* Two cameras share two placements: the least that can contradict each other. */
static void test_two_placements_can_contradict_each_other(void)
{
    test_rng rng = test_seed(557);

    WANTS_RIG;
    for (int is_wrong = 0; is_wrong < 2; is_wrong++) {
        simulate(&rng, 2, 2, 10, 1);
        for (size_t v = 0; v < 4; v++) {
            const int32_t c = t.own[v].camera, f = t.own[v].placement;

            t.own[v].cam_from_target = test_times(&t.true_cams[c], &t.true_places[f]);
            t.second[v].n = 0;
        }
        if (is_wrong) {
            t.own[3].cam_from_target =
                t.own[1].cam_from_target; /* as if it had not moved */
        }
        ASSERT_STATUS(is_wrong ? RIGCAL_ERR_CONTRADICTION : RIGCAL_OK, choose());
        ASSERT_NEAR(!is_wrong, t.choice.share, 0);
    }
}

/* All views of camera 2 are wrong. Cameras 0 and 1 are both right in n_right of n
 * placements. */
static rigcal_status choose_two_of_three(uint64_t seed, int n_right, int n)
{
    test_rng rng = test_seed(seed);

    simulate(&rng, 3, n, 10, 1);
    for (size_t v = 0; v < t.rig.n_views; v++) {
        if (t.views[v].camera == 2 ||
            (t.views[v].camera == 1 && t.views[v].placement >= n_right)) {
            const double shift[3] = {test_normal(&rng), test_normal(&rng), 10};
            double R[9];

            test_random_rotation(R, &rng);
            t.own[v].cam_from_target = test_transform(R, shift);
            t.second[v].n = 0;
        }
    }
    return choose();
}

/* Two cameras that agree in most of their placements are believed against a third one. They
 * are not if they agree in less than half, or in only two placements. The placement that
 * joins them does not count. */
static void test_two_cameras_that_agree_are_believed_against_a_third(void)
{
    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(5); trial++) {
        const uint64_t seed = 5460 + (uint64_t)trial;

        TEST_ASSERT_TRUE(choose_two_of_three(seed, 10, 10) >= 0);
        TEST_ASSERT_TRUE(D(t.choice.share) < 0.5);
        for (size_t v = 0; v < t.rig.n_views; v++) {
            TEST_ASSERT_TRUE(t.views[v].camera == 2 || t.takes[v] != RIGCAL_TAKES_NONE);
        }
        ASSERT_STATUS(RIGCAL_ERR_CONTRADICTION, choose_two_of_three(seed, 4, 10));
        ASSERT_STATUS(RIGCAL_ERR_CONTRADICTION, choose_two_of_three(seed, 2, 2));
        TEST_ASSERT_TRUE(choose_two_of_three(seed, 6, 11) >= 0); /* five of ten */
        ASSERT_STATUS(RIGCAL_ERR_CONTRADICTION, choose_two_of_three(seed, 5, 10));
        ASSERT_STATUS(RIGCAL_ERR_CONTRADICTION, choose_two_of_three(seed, 5, 11));
    }
}

/* Another pose, turned by one radian about the target's own point. */
static rigcal_transform turned_far(const rigcal_transform *pose)
{
    static const double axis[3] = {0.6, 0, 0.8};
    double R[9], at[3], turn[9], out[9];

    test_transform_parts(R, at, pose);
    test_rotation_about(turn, axis, 1);
    test_product(out, turn, R);
    return test_transform(out, at);
}

/* Right views that disagree by more than noise: all poses are off by 4 sigma more. */
static void test_what_is_more_than_noise_raises_the_limit(void)
{
    test_rng rng = test_seed(543);

    WANTS_RIG;
    simulate(&rng, 4, 10, 10, 1);
    t.rig.sigma_px = RC(0.3 / 5);
    ASSERT_STATUS(RIGCAL_OK, choose());
    TEST_ASSERT_TRUE(D(t.choice.tau2) >= 4);
    TEST_ASSERT_TRUE(D(t.choice.share) >= 0.8);
    TEST_ASSERT_EQUAL(0, test_tags_wrong(&t));
    TEST_ASSERT_TRUE(t.choice.n_left_out <= 2);
    for (size_t v = 13; v < 40; v += 8) { /* wrong, and stated to be exact */
        t.own[v].cam_from_target = turned_far(&t.own[v].cam_from_target);
        t.second[v].n = 0;
        for (int k = 0; k < 21; k++) {
            t.own[v].information[k] *= 100;
        }
    }
    ASSERT_STATUS(RIGCAL_OK, choose());
    TEST_ASSERT_TRUE(D(t.choice.tau2) >= 4);
    TEST_ASSERT_TRUE(t.choice.n_left_out <= 4 + 2);
    for (size_t v = 13; v < 40; v += 8) {
        TEST_ASSERT_EQUAL_UINT8(RIGCAL_TAKES_NONE, t.takes[v]);
    }
}

/* Four of five placements agree with a hypothesis for noise alone. The fifth is off by more
 * and more. It is left out, and does not raise the limit. */
static void test_one_placement_of_five_does_not_raise_the_limit(void)
{
    test_rng rng = test_seed(547);
    int n_off = 0;

    WANTS_RIG;
    simulate(&rng, 2, 6, 10, 1);
    t.rig.sigma_px = RC(0.3);
    for (size_t v = 0; v < t.rig.n_views; v++) {
        t.own[v].cam_from_target =
            test_times(&t.true_cams[t.own[v].camera], &t.true_places[t.own[v].placement]);
        t.second[v].n = 0;
    }
    const double x = D(t.own[11].cam_from_target.t[0]);
    for (double off = 1e-3; off < 3; off *= 1.2) {
        t.own[11].cam_from_target.t[0] = RC(x + off);
        ASSERT_STATUS(RIGCAL_OK, choose());
        ASSERT_NEAR(1, t.choice.tau2, 0);
        n_off += D(t.choice.share) < 0.9;
        ASSERT_NEAR(D(t.choice.share) < 0.9 ? 0.8 : 1, t.choice.share, TOL(1e-12, 1e-6));
    }
    TEST_ASSERT_TRUE(n_off > 10);
}

/* Where no views agree at the first two rungs, a higher one is chosen. */
static void test_noise_that_is_stated_far_too_small_is_found(void)
{
    test_rng rng = test_seed(546);

    WANTS_RIG;
    simulate(&rng, 4, 10, 10, 1);
    t.rig.sigma_px = RC(0.3 / 40);
    ASSERT_STATUS(RIGCAL_OK, choose());
    TEST_ASSERT_TRUE(D(t.choice.tau2) >= 64);
    TEST_ASSERT_TRUE(D(t.choice.share) >= 0.5);
}

/* The noise is the median of the estimates from the fits. A few blurred views do not change
 * it. */
static void test_the_noise_of_the_views(void)
{
    test_rng rng = test_seed(544);
    double sigma;

    WANTS_RIG;
    TEST_ON_HOST_ONLY("a median of many views");
    simulate(&rng, 6, 20, 10, 1);
    ASSERT_STATUS(RIGCAL_OK, choose());
    sigma = D(t.choice.sigma_px);
    ASSERT_NEAR(0.3, sigma, 0.05);
    for (size_t v = 0; v < t.rig.n_views; v += 12) {
        t.own[v].sse *= 1000;
        t.second[v].sse *= 1000;
    }
    ASSERT_STATUS(RIGCAL_OK, choose());
    ASSERT_NEAR(sigma, t.choice.sigma_px, 0.03);
}

/* By hand: 2 x 4 - 6 = 2 degrees of freedom in each view, whose median is 2 (1 - 2 / 18)^3.
 * For an even number of views it is the mean of the middle two. */
static void test_the_median_by_hand(void)
{
    static const double sums[4] = {4, 1, 100, 2};
    test_rng rng = test_seed(545);

    WANTS_RIG;
    simulate(&rng, 2, 2, 8, 1);
    for (size_t v = 0; v < 4; v++) {
        t.own[v].sse = RC(sums[v]);
        t.second[v].n = 0;
    }
    (void)choose();
    ASSERT_NEAR(sqrt(3 / (2 * pow(1 - 2 / 18., 3))), t.choice.sigma_px, TOL(1e-12, 1e-6));
    for (size_t v = 0; v < 4; v++) {
        t.own[v].sse = 0;
    }
    (void)choose();
    ASSERT_NEAR(0.01, t.choice.sigma_px, TOL(1e-12, 1e-8)); /* no pixels are more exact than
                                                               this */
    for (size_t v = 0; v < 4; v++) {
        t.own[v].n = 3;
    }
    ASSERT_STATUS(RIGCAL_ERR_TOO_FEW, choose());
    t.rig.sigma_px = RC(0.3);
    ASSERT_STATUS(RIGCAL_OK, choose());
}

/* ---- frames -------------------------------------------------------------- */

static void test_a_held_camera_is_the_frame(void)
{
    test_rng rng = test_seed(551);
    uint8_t roles[4] = {RIGCAL_CAMERA_FREE, RIGCAL_CAMERA_FREE, RIGCAL_CAMERA_HELD,
                        RIGCAL_CAMERA_FREE};
    static rigcal_camera_prior priors[4];
    static rigcal_transform cams[4], places[10];

    WANTS_RIG;
    simulate(&rng, 4, 10, 10, 1);
    ASSERT_STATUS(RIGCAL_OK, choose());
    memcpy(cams, t.cams, sizeof cams);
    memcpy(places, t.places, sizeof places);
    for (int is_prior = 0; is_prior < 2; is_prior++) {
        const rigcal_transform given = test_random_transform(&rng);

        t.rig.roles = roles;
        t.cams[2] = given;
        if (is_prior) {
            roles[2] = RIGCAL_CAMERA_PRIOR;
            t.rig.priors = priors;
            t.rig.sigma_px = t.choice.sigma_px;
            priors[2].cam_from_rig = given;
            memset(&t.cams[2], 0, sizeof t.cams[2]);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_choose(&t.choice, NULL, &t.rig));
        TEST_ASSERT_EQUAL_MEMORY(&given, &t.cams[2], sizeof given);
        for (int f = 0; f < 10; f++) {
            const rigcal_transform before = test_times(&cams[1], &places[f]);
            const rigcal_transform now = test_times(&t.cams[1], &t.places[f]);

            ASSERT_TRANSFORM(&before, &now, TOL(1e-9, 1e-3), TOL(1e-8, 1e-2));
        }
        for (int c = 0; c < 4; c++) {
            const rigcal_transform back = test_inverse(&cams[2]);
            const rigcal_transform back_now = test_inverse(&t.cams[2]);
            const rigcal_transform before = test_times(&cams[c], &back);
            const rigcal_transform now = test_times(&t.cams[c], &back_now);

            ASSERT_TRANSFORM(&before, &now, TOL(1e-9, 1e-3), TOL(1e-8, 1e-2));
        }
    }
}

/* Cameras 0 and 2 share no placement with 1, 3 and 4. */
static void simulate_groups(test_rng *rng)
{
    size_t n = 0;

    simulate(rng, 5, 12, 10, 1);
    for (size_t v = 0; v < t.rig.n_views; v++) {
        const int is_even = t.views[v].camera == 0 || t.views[v].camera == 2;

        if (is_even == (t.views[v].placement % 2 == 0)) {
            t.views[n] = t.views[v];
            t.own[n] = t.own[v];
            t.right[n] = t.right[v];
            t.second[n++] = t.second[v];
        }
    }
    t.rig.n_views = n;
}

static rigcal_status first_of_views(rigcal_view_pose *pose, size_t index, void *context)
{
    return index < t.rig.n_views ? first_from(pose, index, context) : RIGCAL_ERR_DAMAGED;
}

static rigcal_status second_of_views(rigcal_view_pose *pose, size_t index, void *context)
{
    return index < t.rig.n_views ? second_from(pose, index, context) : RIGCAL_ERR_DAMAGED;
}

/* A camera that shares nothing with those that have joined has no hypothesis. */
static void test_no_view_is_asked_for_that_is_not_there(void)
{
    test_rng rng = test_seed(552);

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(6); trial++) {
        simulate_groups(&rng);
        t.rig.view_poses = NULL;
        t.rig.view_pose_source = first_of_views;
        t.rig.context = &t;
        t.choice.second_poses = NULL;
        t.choice.second_source = second_of_views;
        ASSERT_STATUS(RIGCAL_DISCONNECTED, choose());
    }
}

/* Each group must be the same as without the other. */
static void test_groups_have_frames_of_their_own(void)
{
    static const rigcal_transform ORIGIN = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    test_rng rng = test_seed(552);

    WANTS_RIG;
    simulate_groups(&rng);
    const size_t n = t.rig.n_views;
    ASSERT_STATUS(RIGCAL_DISCONNECTED, choose());
    TEST_ASSERT_EQUAL_INT32(0, t.group[0]);
    TEST_ASSERT_EQUAL_INT32(1, t.group[1]);
    TEST_ASSERT_EQUAL_INT32(0, t.group[2]);
    TEST_ASSERT_EQUAL_INT32(1, t.group[3]);
    TEST_ASSERT_EQUAL_INT32(1, t.group[4]);
    ASSERT_TRANSFORM(&ORIGIN, &t.cams[0], TOL(1e-12, 1e-5), TOL(1e-10, 1e-4));
    ASSERT_TRANSFORM(&ORIGIN, &t.cams[1], TOL(1e-12, 1e-5), TOL(1e-10, 1e-4));
    TEST_ASSERT_EQUAL(0, test_tags_wrong(&t));
    TEST_ASSERT_EQUAL(0, t.choice.n_left_out);
    for (size_t v = 0; v < n; v++) { /* a start with the errors that a view leaves */
        const rigcal_transform truth = test_times(&t.true_cams[t.views[v].camera],
                                                  &t.true_places[t.views[v].placement]);
        const rigcal_transform now =
            test_times(&t.cams[t.views[v].camera], &t.places[t.views[v].placement]);

        ASSERT_TRANSFORM(&truth, &now, 0.3, 0.6);
    }
}

/* One camera alone, and one that saw nothing. */
static void test_a_camera_by_itself(void)
{
    test_rng rng = test_seed(553);

    WANTS_RIG;
    simulate(&rng, 1, 5, 10, 1);
    ASSERT_STATUS(RIGCAL_OK, choose());
    TEST_ASSERT_EQUAL(0, t.choice.n_left_out);
    ASSERT_NEAR(0, t.choice.share, 0);
    for (size_t v = 0; v < 5; v++) {
        TEST_ASSERT_EQUAL_UINT8(RIGCAL_TAKES_FIRST, t.takes[v]);
        ASSERT_TRANSFORM(&t.own[v].cam_from_target, &t.places[v], TOL(1e-12, 1e-5),
                         TOL(1e-11, 1e-4));
    }
    simulate(&rng, 2, 5, 10, 1);
    for (size_t v = 0; v < 5; v++) {
        t.own[v] = t.own[2 * v];
        t.second[v] = t.second[2 * v];
    }
    t.rig.n_views = 5;
    ASSERT_STATUS(RIGCAL_DISCONNECTED, choose());
    TEST_ASSERT_EQUAL(0, t.choice.n_left_out);
}

/* Camera 0 shares no placement with the others, which join first. It begins by itself. */
static void test_the_first_camera_may_be_apart(void)
{
    test_rng rng = test_seed(564);
    size_t n = 0;

    WANTS_RIG;
    simulate(&rng, 4, 12, 10, 1);
    for (size_t v = 0; v < t.rig.n_views; v++) {
        if ((t.views[v].camera == 0) == (t.views[v].placement % 2 == 0)) {
            t.own[n] = t.own[v];
            t.second[n++] = t.second[v];
        }
    }
    t.rig.n_views = n;
    ASSERT_STATUS(RIGCAL_DISCONNECTED, choose());
    for (size_t v = 0; v < n; v++) {
        if (t.own[v].camera == 0) {
            TEST_ASSERT_EQUAL_UINT8(RIGCAL_TAKES_FIRST, t.takes[v]);
            ASSERT_TRANSFORM(&t.own[v].cam_from_target, &t.places[t.own[v].placement],
                             TOL(1e-12, 1e-5), TOL(1e-11, 1e-4));
        }
    }
}

/* Cameras 0 and 1 disagree in the only placement that camera 2 saw too. Camera 2 joins in
 * spite of that, because the rig is connected. */
static void test_a_camera_that_joins_by_a_doubtful_placement(void)
{
    test_rng rng = test_seed(554);
    size_t n = 0;

    WANTS_RIG;
    simulate(&rng, 3, 6, 10, 1);
    for (size_t v = 0; v < t.rig.n_views; v++) {
        if (t.views[v].camera < 2 || t.views[v].placement == 5) {
            t.own[n] = t.own[v];
            t.second[n++] = t.second[v];
        }
    }
    t.rig.n_views = n;
    t.own[n - 2].cam_from_target = t.own[0].cam_from_target; /* of camera 1 */
    t.second[n - 2].n = 0;
    ASSERT_STATUS(RIGCAL_OK, choose());
    TEST_ASSERT_NOT_EQUAL(0, D(t.cams[2].t[0]));
    TEST_ASSERT_EQUAL_UINT8(RIGCAL_TAKES_NONE, t.takes[n - 2]);
}

/* Cameras 0 and 1 disagree in placement 5, where the wrong one has less variance. Camera 2
 * saw that placement, and placement 4, in which they agree. It joins by placement 4. */
static void test_a_doubtful_placement_does_not_count(void)
{
    test_rng rng = test_seed(555);

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(6); trial++) {
        size_t n = 0;
        rigcal_view_pose *wrong;

        simulate(&rng, 3, 6, 10, 1);
        for (size_t v = 0; v < t.rig.n_views; v++) {
            if (t.views[v].camera < 2 || t.views[v].placement > 3) {
                t.own[n] = t.own[v];
                t.second[n++] = t.second[v];
            }
        }
        t.rig.n_views = n;
        wrong = &t.own[n - 2];
        wrong->cam_from_target = turned_far(&wrong->cam_from_target);
        t.second[n - 2].n = 0;
        for (int k = 0; k < 21; k++) {
            wrong->information[k] *= 9;
            t.own[n - 1].information[k] *= 9;
            t.second[n - 1].information[k] *= 9;
        }
        ASSERT_STATUS(RIGCAL_OK, choose());
        ASSERT_TRANSFORM(&t.true_cams[2], &t.cams[2], 0.3, 2);
    }
}

/* Which camera sees which of 14 placements. */
static int sees(int camera, int placement)
{
    static const char *const SEEN[5] = {"11111111110000", "11111111000000",
                                        "00000000110111", "11111100110000",
                                        "10000000001111"};
    return SEEN[camera][placement] == '1' || (camera < 2 && placement == 10);
}

/* Camera 0 was bumped while it saw placements 8 and 9, in which camera 2 agrees with it.
 * Camera 3, which joins first, contradicts that. So camera 2 waits until camera 4, which
 * shares one placement only, has joined. The poses are exact. */
static void test_what_a_camera_contradicts_joins_no_other(void)
{
    static const double BUMP[9] = {0.8, -0.6, 0, 0.6, 0.8, 0, 0, 0, 1}, AT[3] = {0, 0, 0};
    const rigcal_transform bump = test_transform(BUMP, AT);
    test_rng rng = test_seed(559);
    size_t n = 0;

    WANTS_RIG;
    simulate(&rng, 5, 14, 10, 1);
    for (size_t v = 0; v < t.rig.n_views; v++) {
        const int c = t.views[v].camera, f = t.views[v].placement;

        if (sees(c, f)) {
            rigcal_view_pose *const own = &t.own[n];

            *own = t.own[v];
            own->cam_from_target = test_times(&t.true_cams[c], &t.true_places[f]);
            if (c == 0 && (f == 8 || f == 9)) {
                own->cam_from_target = test_times(&bump, &own->cam_from_target);
            }
            t.second[n++].n = 0;
        }
    }
    t.rig.n_views = n;
    t.rig.sigma_px = RC(0.3);
    ASSERT_STATUS(RIGCAL_OK, choose());
    for (int c = 0; c < 5; c++) {
        ASSERT_TRANSFORM(&t.true_cams[c], &t.cams[c], TOL(1e-6, 1e-2), TOL(1e-6, 1e-2));
    }
    TEST_ASSERT_EQUAL(2, t.choice.n_left_out);
}

/* Twelve cameras, of which the last two are the same camera twice. More than eight views of
 * a placement do not place it again. */
enum { MANY = TEST_HOST ? 12 : 1 };
TEST_TAGS(many, MANY, 4);

/* Four placements before all cameras. */
static void make_many(test_rng *rng)
{
    many.distance = 10;
    many.share_seen = 1;
    many.noise_px = 0.3;
    test_tags_random(&many, rng, MANY, 4);
    test_tags_solve(&many);
}

static void test_many_cameras_and_two_that_are_alike(void)
{
    test_rng rng = test_seed(556);
    size_t last[2] = {0, 0};

    TEST_ON_HOST_ONLY("memory of twelve cameras");
    make_many(&rng);
    for (size_t v = 0; v < many.rig.n_views; v++) {
        if (many.views[v].camera >= MANY - 2) {
            last[many.views[v].camera - (MANY - 2)] = v;
        }
        if (many.views[v].camera == MANY - 1) {
            many.own[v] = many.own[last[0]];
            many.second[v] = many.second[last[0]];
            many.own[v].camera = many.second[v].camera = MANY - 1;
            many.right[v] = many.right[last[0]];
        }
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_choose(&many.choice, NULL, &many.rig));
    TEST_ASSERT_EQUAL(0, test_tags_wrong(&many));
    TEST_ASSERT_EQUAL(0, many.choice.n_left_out);
    ASSERT_TRANSFORM(&many.cams[MANY - 2], &many.cams[MANY - 1], TOL(1e-9, 1e-3),
                     TOL(1e-8, 1e-2));
}

/* The poses of the last placement are all wrong where the view has much information, and
 * none is wrong as another. The eight of most information may place it: the right ones if
 * one of these is right. */
static void test_the_eight_views_of_most_information_place_a_placement(void)
{
    TEST_ON_HOST_ONLY("memory of twelve cameras");
    for (int n_wrong = 7; n_wrong < 9; n_wrong++) {
        test_rng rng = test_seed(560);

        make_many(&rng);
        for (size_t v = 0; v < many.rig.n_views; v++) {
            rigcal_view_pose *const own = &many.own[v];

            own->cam_from_target =
                test_times(&many.true_cams[own->camera], &many.true_places[own->placement]);
            many.second[v].n = 0;
            if (own->placement == 3 && own->camera >= MANY - n_wrong) {
                own->cam_from_target = test_random_transform(&rng);
                for (int k = 0; k < 21; k++) {
                    own->information[k] *= 1000;
                }
            }
        }
        many.rig.sigma_px = RC(0.3);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_choose(&many.choice, NULL, &many.rig));
        const rigcal_transform now = test_times(&many.cams[0], &many.places[3]);
        const rigcal_transform truth = test_times(&many.true_cams[0], &many.true_places[3]);
        const double off = fabs(D(now.t[0]) - D(truth.t[0])) +
                           fabs(D(now.t[1]) - D(truth.t[1])) +
                           fabs(D(now.t[2]) - D(truth.t[2]));

        TEST_ASSERT_EQUAL_INT(n_wrong < 8, off < TOL(1e-6, 1e-2));
    }
}

/* Of the first seven cameras three see placement 3 where it is, and three agree better on
 * another place. The eighth camera joins last of these and is the fourth that is right. The
 * ninth, which sees nothing else, joins by where the placement is then. */
static void test_the_eighth_camera_places_a_placement_anew(void)
{
    static const double NEAR[6] = {1e-3, -1e-3, 1e-3, 1e-3, 1e-3, -1e-3};
    test_rng rng = test_seed(563);
    size_t n = 0;

    TEST_ON_HOST_ONLY("memory of twelve cameras");
    make_many(&rng);
    const rigcal_transform elsewhere = turned_far(&many.true_places[3]);
    for (size_t v = 0; v < many.rig.n_views; v++) {
        const int c = many.views[v].camera, f = many.views[v].placement;
        const int is_wrong = f == 3 && c > 2 && c < 6;

        if (c < 7 || (c == 7 && f != 2) || (c == 8 && f == 3)) {
            rigcal_view_pose *const own = &many.own[n];

            *own = many.own[v];
            own->cam_from_target = test_times(&many.true_cams[c],
                                              is_wrong ? &elsewhere : &many.true_places[f]);
            if (f == 3 && c == 6) {
                own->cam_from_target = test_random_transform(&rng);
            } else if (f == 3 && !is_wrong) {
                double R[9], t_near[3], d[6];

                for (int k = 0; k < 6; k++) {
                    d[k] = c % 2 ? -NEAR[k] : NEAR[(k + c) % 6];
                }
                test_transform_parts(R, t_near, &own->cam_from_target);
                test_move(R, t_near, d);
                own->cam_from_target = test_transform(R, t_near);
            }
            for (int k = 0; k < 21 && is_wrong; k++) {
                own->information[k] *= 4; /* the three are the first to join */
            }
            many.second[n++].n = 0;
        }
    }
    many.rig.n_views = n;
    many.rig.n_cameras = 9;
    many.rig.sigma_px = RC(0.3);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_choose(&many.choice, NULL, &many.rig));
    TEST_ASSERT_EQUAL(4, many.choice.n_left_out);
    const rigcal_transform back = test_inverse(&many.cams[0]);
    const rigcal_transform true_back = test_inverse(&many.true_cams[0]);
    const rigcal_transform now = test_times(&many.cams[8], &back);
    const rigcal_transform truth = test_times(&many.true_cams[8], &true_back);
    ASSERT_TRANSFORM(&truth, &now, 0.02, 0.1);
}

static size_t read_last;

static rigcal_status pose_that_is_told(rigcal_view_pose *pose, size_t index, void *context)
{
    (void)context;
    read_last = index;
    *pose = many.own[index];
    return RIGCAL_OK;
}

/* After the first two cameras have joined, each one more places the placements anew, up to
 * the eighth. At the end all are placed once more. Each time the view of the frame's camera
 * is read, in a step after which the next view of the placement follows. */
static void test_more_than_eight_cameras_do_not_place_a_placement_anew(void)
{
    TEST_ON_HOST_ONLY("memory of twelve cameras");
    for (size_t C = 3; C <= MANY; C++) {
        test_rng rng = test_seed(565);
        rigcal_choose_solver solver;
        size_t n = 0;

        make_many(&rng);
        for (size_t v = 0; v < many.rig.n_views; v++) {
            if (many.own[v].camera < (int32_t)C) {
                many.own[n] = many.own[v];
                many.own[n].cam_from_target =
                    test_times(&many.true_cams[many.own[n].camera],
                               &many.true_places[many.own[n].placement]);
                n++;
            }
        }
        many.rig.n_views = n;
        many.rig.n_cameras = C;
        many.rig.sigma_px = RC(0.3);
        many.rig.view_poses = NULL;
        many.rig.view_pose_source = pose_that_is_told;
        many.choice.second_poses = NULL;
        ASSERT_STATUS(RIGCAL_OK, rigcal_choose_begin(&solver, &many.choice, &many.rig));
        while (!solver.is_again) {
            ASSERT_STATUS(RIGCAL_RUNNING, rigcal_choose_step(&solver, 1));
        }
        const size_t frame = (size_t)solver.a;
        size_t placed = 0, before;
        rigcal_status status;

        do {
            before = solver.view;
            read_last = n;
            status = rigcal_choose_step(&solver, 1);
            placed += solver.view == before + 1 && read_last < n && read_last % C == frame;
        } while (status == RIGCAL_RUNNING);
        ASSERT_STATUS(RIGCAL_OK, rigcal_choose_result(NULL, &solver));
        TEST_ASSERT_EQUAL_size_t(many.rig.n_placements * (C < 8 ? C : 8), placed);
        many.rig.view_pose_source = NULL;
    }
}

/* How many other links of camera a come before its link to b: those of more information,
 * and of equal ones those to lower cameras. */
static int rank_of(const rigcal_link links[], int n_cameras, int a, int b)
{
    int rank = 0;

    for (int d = 0; d < n_cameras; d++) {
        if (d != a && d != b) {
            const double link =
                D(links[a < b ? RIGCAL_LINK(a, b) : RIGCAL_LINK(b, a)].information);
            const double its =
                D(links[a < d ? RIGCAL_LINK(a, d) : RIGCAL_LINK(d, a)].information);

            rank += its > link || (!(its < link) && d < b);
        }
    }
    return rank;
}

/* A pair is scored if it is among the three best of one of its cameras. Every hypothesis of
 * a pair could agree with its three other placements. */
static void test_the_best_three_pairs_of_each_camera_are_scored(void)
{
    static rigcal_link links[RIGCAL_LINKS(MANY) + 1];
    test_rng rng = test_seed(558);
    rigcal_choose_solver solver;
    int32_t n_groups;
    int pairs = 0;

    TEST_ON_HOST_ONLY("memory of twelve cameras");
    make_many(&rng);
    for (size_t v = 0; v < many.rig.n_views; v++) { /* some cameras are alike */
        const size_t from = v - (size_t)(many.own[v].camera % 3);
        const rigcal_view_pose own = many.own[v];

        many.own[v] = many.own[from];
        many.own[v].camera = own.camera;
        many.second[v].n = 0;
    }
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_rig_links(links, RIGCAL_LINKS(MANY), &n_groups, NULL, &many.rig));
    for (int a = 0; a < MANY; a++) {
        for (int b = a + 1; b < MANY; b++) {
            pairs += rank_of(links, MANY, a, b) < 3 || rank_of(links, MANY, b, a) < 3;
        }
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_choose_begin(&solver, &many.choice, &many.rig));
    while (rigcal_choose_step(&solver, 1000) == RIGCAL_RUNNING) {
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_choose_result(NULL, &solver));
    ASSERT_NEAR(3 * pairs, solver.most, 0);
}

/* ---- refused ------------------------------------------------------------- */

static void assert_at_fault(rigcal_status expected, int32_t view)
{
    int32_t at_fault = -2;

    ASSERT_STATUS(expected, rigcal_rig_choose(&t.choice, &at_fault, &t.rig));
    TEST_ASSERT_EQUAL_INT32(view, at_fault);
}

static void test_what_is_refused(void)
{
    test_rng rng = test_seed(561);
    static const uint8_t left_out[12] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
    uint8_t roles[3] = {RIGCAL_CAMERA_FREE, RIGCAL_CAMERA_FREE, RIGCAL_CAMERA_FREE};
    rigcal_view_pose kept;
    rigcal_choose_solver solver;
    size_t capacity;

    WANTS_RIG;
    simulate(&rng, 3, 4, 10, 1);
    kept = t.second[7];
    kept.n = 4;
    kept.cam_from_target = t.own[7].cam_from_target;
    memcpy(kept.information, t.own[7].information, sizeof kept.information);
    kept.camera = t.own[7].camera;
    kept.placement = t.own[7].placement;
    t.second[7] = kept;
    t.second[7].camera = 0;
    assert_at_fault(RIGCAL_ERR_RANGE, 7);
    t.second[7] = kept;
    t.second[7].placement++;
    assert_at_fault(RIGCAL_ERR_RANGE, 7);
    t.second[7] = kept;
    t.second[7].sse = -1;
    assert_at_fault(RIGCAL_ERR_RANGE, 7);
    t.second[7] = kept;
    t.second[7].information[3] = TEST_NAN;
    assert_at_fault(RIGCAL_ERR_NOT_FINITE, 7);
    t.second[7] = kept;
    t.second[7].information[20] = 0;
    assert_at_fault(RIGCAL_ERR_DEGENERATE, 7);
    t.second[7] = kept;
    t.second[7].cam_from_target.R[0] = 2;
    assert_at_fault(RIGCAL_ERR_ROTATION, 7);
    t.second[7] = kept;
    t.own[3].sse = TEST_NAN;
    assert_at_fault(RIGCAL_ERR_NOT_FINITE, 3);
    t.own[3].sse = -1;
    assert_at_fault(RIGCAL_ERR_RANGE, 3);
    t.own[3].sse = 1;
    t.own[4].camera = 3;
    assert_at_fault(RIGCAL_ERR_RANGE, 4);
    t.own[4].camera = 0;
    assert_at_fault(RIGCAL_ERR_TWICE, 4);
    t.own[4].camera = 1;
    assert_at_fault(RIGCAL_OK, -1);
    t.rig.roles = roles;
    for (int c = 0; c < 3; c++) {
        const rigcal_transform pose = t.cams[c];

        roles[c] = RIGCAL_CAMERA_HELD;
        t.cams[c].R[4] = 2;
        assert_at_fault(RIGCAL_ERR_ROTATION, -1);
        t.cams[c] = pose;
        assert_at_fault(RIGCAL_OK, -1);
        roles[c] = RIGCAL_CAMERA_FREE;
        t.cams[c].R[4] = 2; /* where a free camera is does not matter */
        assert_at_fault(RIGCAL_OK, -1);
    }
    t.rig.roles = NULL;
    t.rig.left_out = left_out; /* no view is at fault if none is left */
    assert_at_fault(RIGCAL_ERR_TOO_FEW, -1);
    t.rig.left_out = NULL;
    capacity = t.rig.work_capacity;
    t.rig.work_capacity = rigcal_choose_work(3, 4, 12) - 1;
    assert_at_fault(RIGCAL_ERR_CAPACITY, -1);
    t.rig.work_capacity++;
    assert_at_fault(RIGCAL_OK, -1);
    t.rig.work_capacity = capacity;
    TEST_ASSERT_EQUAL(RIGCAL_CHOOSE_WORK(3, 4, 12), rigcal_choose_work(3, 4, 12));
    TEST_ASSERT_EQUAL(RIGCAL_CHOOSE_WORK(30, 4, 12), rigcal_choose_work(30, 4, 12));

    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rig_choose(NULL, NULL, &t.rig));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rig_choose(&t.choice, NULL, NULL));
    t.choice.takes = NULL;
    assert_at_fault(RIGCAL_ERR_NULL, -1);
    t.choice.takes = t.takes;
    memset(&solver, 0, sizeof solver);
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_choose_step(&solver, 1));
    ASSERT_STATUS(RIGCAL_OK, rigcal_choose_begin(&solver, &t.choice, &t.rig));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_choose_step(&solver, 0));
}

/* The covariance of the adjustment was in the same memory. */
static void test_after_a_choice_the_rig_is_not_adjusted(void)
{
    test_rng rng = test_seed(562);
    rigcal_rig_fit fit;
    rigcal_real Sigma[36];

    WANTS_RIG;
    simulate(&rng, 3, 5, 10, 1);
    ASSERT_STATUS(RIGCAL_OK, choose());
    t.rig.view_poses = NULL;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &t.rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(Sigma, &t.rig, 1, 1));
    t.rig.view_poses = t.own;
    ASSERT_STATUS(RIGCAL_OK, choose());
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_rig_covariance(Sigma, &t.rig, 1, 1));
}

TEST_MAIN()
{
    RUN_TEST(test_golden_vectors);
    RUN_TEST(test_most_tags_take_their_right_pose);
    RUN_TEST(test_tags_of_which_a_part_is_seen);
    RUN_TEST(test_the_adjustment_from_the_choice_is_right);
    RUN_TEST(test_the_order_does_not_matter);
    RUN_TEST(test_the_same_bits_whatever_the_budgets);
    RUN_TEST(test_the_size_of_a_pixel_changes_no_bit);
    RUN_TEST(test_a_budget_is_a_number_of_units);
    RUN_TEST(test_poses_from_sources);
    RUN_TEST(test_a_placement_that_a_source_changes_joins_nothing);
    RUN_TEST(test_without_second_poses);
    RUN_TEST(test_a_wrong_view_is_left_out);
    RUN_TEST(test_views_that_contradict_each_other);
    RUN_TEST(test_two_placements_can_contradict_each_other);
    RUN_TEST(test_two_cameras_that_agree_are_believed_against_a_third);
    RUN_TEST(test_what_is_more_than_noise_raises_the_limit);
    RUN_TEST(test_one_placement_of_five_does_not_raise_the_limit);
    RUN_TEST(test_noise_that_is_stated_far_too_small_is_found);
    RUN_TEST(test_the_noise_of_the_views);
    RUN_TEST(test_the_median_by_hand);
    RUN_TEST(test_a_held_camera_is_the_frame);
    RUN_TEST(test_no_view_is_asked_for_that_is_not_there);
    RUN_TEST(test_groups_have_frames_of_their_own);
    RUN_TEST(test_a_camera_by_itself);
    RUN_TEST(test_the_first_camera_may_be_apart);
    RUN_TEST(test_a_camera_that_joins_by_a_doubtful_placement);
    RUN_TEST(test_a_doubtful_placement_does_not_count);
    RUN_TEST(test_what_a_camera_contradicts_joins_no_other);
    RUN_TEST(test_many_cameras_and_two_that_are_alike);
    RUN_TEST(test_the_eight_views_of_most_information_place_a_placement);
    RUN_TEST(test_the_eighth_camera_places_a_placement_anew);
    RUN_TEST(test_more_than_eight_cameras_do_not_place_a_placement_anew);
    RUN_TEST(test_the_best_three_pairs_of_each_camera_are_scored);
    RUN_TEST(test_what_is_refused);
    RUN_TEST(test_after_a_choice_the_rig_is_not_adjusted);
}
