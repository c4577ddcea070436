/* rig: cameras joined through placements of a target, and where the target was. */
#include <math.h>
#include <string.h>

#include "test_support.h"
#include "vectors_transform.h"

/* Entries of a rotation after a few products; lengths of order 10. */
#define TOL_ENTRY TOL(3e-14, 5e-6)
#define TOL_LENGTH TOL(2e-13, 5e-5)

enum { CAMERAS_MAX = 12, PLACEMENTS_MAX = 10 };
enum { VIEWS_MAX = RIGCAL_TEST_RAM < 32768 ? 40 : 120 };

static const rigcal_transform NOTHING = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};

/* ---- joining cameras ----------------------------------------------------- */

/* A rig with ground truth: camera 0 is the rig frame. */
typedef struct {
    rigcal_transform cams_from_rig[CAMERAS_MAX];
    rigcal_transform rig_from_target[PLACEMENTS_MAX];
    rigcal_view_pose views[VIEWS_MAX];
    size_t n_cameras, n_views;
    /* What the library makes of it. */
    rigcal_transform joined[CAMERAS_MAX];
    int32_t group[CAMERAS_MAX];
    rigcal_transform work[VIEWS_MAX];
    rigcal_real weight[VIEWS_MAX];
} rig;

static void new_rig(rig *r, test_rng *rng, int n_cameras)
{
    r->n_cameras = (size_t)n_cameras;
    r->n_views = 0;
    for (int i = 0; i < CAMERAS_MAX; i++) {
        r->cams_from_rig[i] = i ? test_random_transform(rng) : NOTHING;
    }
    for (int i = 0; i < PLACEMENTS_MAX; i++) {
        r->rig_from_target[i] = test_random_transform(rng);
    }
}

static rigcal_view_pose *add_view(rig *r, int camera, int placement, double weight)
{
    rigcal_view_pose *view = &r->views[r->n_views++];

    view->cam_from_target =
        test_times(&r->cams_from_rig[camera], &r->rig_from_target[placement]);
    view->weight = RC(weight);
    view->camera = camera;
    view->placement = placement;
    return view;
}

/* As the library takes it. */
static rigcal_rig rig_of(rig *r)
{
    const rigcal_rig library = {r->joined,  r->group, r->n_cameras, r->views,
                                r->n_views, r->work,  r->weight};

    return library;
}

static rigcal_status join(rig *r)
{
    rigcal_rig library = rig_of(r);

    return rigcal_rig_join(&library);
}

static void assert_joined(const rig *r, int camera)
{
    ASSERT_TRANSFORM(&r->cams_from_rig[camera], &r->joined[camera], TOL_ENTRY, TOL_LENGTH);
}

static void test_two_cameras_join_through_one_placement(void)
{
    test_rng rng = test_seed(75);
    rig r;

    new_rig(&r, &rng, 2);
    add_view(&r, 0, 4, 10);
    add_view(&r, 1, 4, 12);
    ASSERT_STATUS(RIGCAL_OK, join(&r));
    ASSERT_TRANSFORM(&NOTHING, &r.joined[0], 0, 0);
    assert_joined(&r, 1);
    TEST_ASSERT_EQUAL_INT32(0, r.group[0]);
    TEST_ASSERT_EQUAL_INT32(0, r.group[1]);
}

static void test_one_camera_alone_is_a_rig(void)
{
    test_rng rng = test_seed(76);
    rig r;

    new_rig(&r, &rng, 1);
    add_view(&r, 0, 0, 5);
    ASSERT_STATUS(RIGCAL_OK, join(&r));
    ASSERT_TRANSFORM(&NOTHING, &r.joined[0], 0, 0);
    TEST_ASSERT_EQUAL_INT32(0, r.group[0]);
}

/* Cameras and placements at random, most cameras not seeing most placements,
 * the views in disorder; a path through all cameras sees to it that they
 * connect. */
static void test_a_connected_rig_is_joined_whatever_sees_what(void)
{
    test_rng rng = test_seed(77);

    for (int trial = 0; trial < 60; trial++) {
        const int n = 2 + trial % (CAMERAS_MAX - 1);
        int order[CAMERAS_MAX];
        rig r;

        new_rig(&r, &rng, n);
        for (int i = 0; i < n; i++) {
            const int k = (int)(test_next(&rng) % (uint64_t)(i + 1));

            order[i] = order[k];
            order[k] = i;
        }
        for (int i = 0; i + 1 < n; i++) {
            const int placement = (int)(test_next(&rng) % PLACEMENTS_MAX);

            add_view(&r, order[i], placement, test_uniform(&rng, 3, 50));
            add_view(&r, order[i + 1], placement, test_uniform(&rng, 3, 50));
        }
        for (int extra = 0; extra < 3 * (trial % 5); extra++) {
            add_view(&r, (int)(test_next(&rng) % (uint64_t)n),
                     (int)(test_next(&rng) % PLACEMENTS_MAX), 4);
        }
        for (size_t i = 0; i < r.n_views; i++) {
            const size_t k = (size_t)(test_next(&rng) % (uint64_t)(i + 1));
            const rigcal_view_pose kept = r.views[i];

            r.views[i] = r.views[k];
            r.views[k] = kept;
        }
        ASSERT_STATUS(RIGCAL_OK, join(&r));
        for (int i = 0; i < n; i++) {
            TEST_ASSERT_EQUAL_INT32(0, r.group[i]);
            assert_joined(&r, i);
        }
    }
}

static void test_cameras_that_share_nothing_join_through_a_third(void)
{
    test_rng rng = test_seed(78);
    rig r;

    new_rig(&r, &rng, 3);
    add_view(&r, 2, 1, 9);
    add_view(&r, 0, 0, 9);
    add_view(&r, 1, 1, 9);
    add_view(&r, 1, 0, 9);
    ASSERT_STATUS(RIGCAL_OK, join(&r));
    assert_joined(&r, 1);
    assert_joined(&r, 2);
}

static void test_groups_that_share_nothing_are_told_apart(void)
{
    test_rng rng = test_seed(79);
    rigcal_transform expected, back;
    rig r;

    /* 0 and 3; 1 and 4; 2 alone; 5 has seen nothing. */
    new_rig(&r, &rng, 6);
    add_view(&r, 0, 0, 9);
    add_view(&r, 3, 0, 9);
    add_view(&r, 4, 1, 9);
    add_view(&r, 1, 1, 9);
    add_view(&r, 2, 2, 9);
    ASSERT_STATUS(RIGCAL_DISCONNECTED, join(&r));
    TEST_ASSERT_EQUAL_INT32(0, r.group[0]);
    TEST_ASSERT_EQUAL_INT32(1, r.group[1]);
    TEST_ASSERT_EQUAL_INT32(2, r.group[2]);
    TEST_ASSERT_EQUAL_INT32(0, r.group[3]);
    TEST_ASSERT_EQUAL_INT32(1, r.group[4]);
    TEST_ASSERT_EQUAL_INT32(3, r.group[5]);
    assert_joined(&r, 3);
    /* The first of each group is at home there. */
    ASSERT_TRANSFORM(&NOTHING, &r.joined[1], 0, 0);
    ASSERT_TRANSFORM(&NOTHING, &r.joined[2], 0, 0);
    ASSERT_TRANSFORM(&NOTHING, &r.joined[5], 0, 0);
    back = test_inverse(&r.cams_from_rig[1]);
    expected = test_times(&r.cams_from_rig[4], &back);
    ASSERT_TRANSFORM(&expected, &r.joined[4], TOL_ENTRY, TOL_LENGTH);
}

/* Camera 1 is turned by +w in one placement and by -w in another: the mean
 * is the truth; with a third of the weight on one side it lies a third off
 * the middle. */
static void test_placements_are_averaged_by_weight(void)
{
    static const double axis[3] = {2, -1, 2};
    const double angle = 0.03;
    test_rng rng = test_seed(80);

    for (int heavy = 1; heavy <= 2; heavy++) {
        const double off = heavy == 1 ? 0 : angle / 3;
        rigcal_transform expected, turn;
        rig r;

        new_rig(&r, &rng, 2);
        for (int i = 0; i < 2; i++) {
            const rigcal_transform twist = test_turned_about(axis, i ? -angle : angle);
            const double weight = i ? 10 : 10 * heavy;
            rigcal_view_pose *view;

            add_view(&r, 0, i, weight);
            view = add_view(&r, 1, i, weight);
            view->cam_from_target = test_times(&twist, &view->cam_from_target);
        }
        ASSERT_STATUS(RIGCAL_OK, join(&r));
        turn = test_turned_about(axis, off);
        expected = test_times(&turn, &r.cams_from_rig[1]);
        for (int k = 0; k < 9; k++) {
            ASSERT_NEAR(expected.R[k], r.joined[1].R[k], TOL_ENTRY);
        }
    }
}

/* A placement that one camera hardly saw says little, however well the other
 * did: of two that differ, the mean is at the one that both saw well. */
static void test_a_placement_counts_as_its_weaker_view(void)
{
    static const double axis[3] = {1, 0, 0};
    const double angle = 0.1;
    const rigcal_transform twist = test_turned_about(axis, angle);
    test_rng rng = test_seed(89);
    double R[9], R_true[9];
    rigcal_view_pose *view;
    rig r;

    new_rig(&r, &rng, 2);
    add_view(&r, 0, 0, 1);
    view = add_view(&r, 1, 0, 1000);
    view->cam_from_target = test_times(&twist, &view->cam_from_target);
    add_view(&r, 0, 1, 20);
    add_view(&r, 1, 1, 20);
    ASSERT_STATUS(RIGCAL_OK, join(&r));
    test_transform_parts(R, NULL, &r.joined[1]);
    test_transform_parts(R_true, NULL, &r.cams_from_rig[1]);
    TEST_ASSERT_TRUE(test_angle_between(R, R_true) < angle / 5);
}

static void test_small_weights_connect_as_well(void)
{
    test_rng rng = test_seed(90);
    rig r;

    new_rig(&r, &rng, 2);
    add_view(&r, 0, 0, 1e-6);
    add_view(&r, 1, 0, 1e-6);
    ASSERT_STATUS(RIGCAL_OK, join(&r));
    assert_joined(&r, 1);
}

static void test_a_length_is_averaged_over_placements(void)
{
    static const double d[3] = {0.03, -0.02, 0.05};
    test_rng rng = test_seed(81);
    rig r;

    new_rig(&r, &rng, 2);
    for (int i = 0; i < 2; i++) {
        rigcal_view_pose *view;

        add_view(&r, 0, i, 8);
        view = add_view(&r, 1, i, 8);
        for (int k = 0; k < 3; k++) {
            view->cam_from_target.t[k] += i ? RC(d[k]) : -RC(d[k]);
        }
    }
    ASSERT_STATUS(RIGCAL_OK, join(&r));
    assert_joined(&r, 1);
}

/* Camera 2 shares much with camera 1 and one bad placement with camera 0;
 * joined after 1, its error is averaged down, not taken whole. */
static void test_the_best_shared_camera_is_joined_first(void)
{
    static const double axis[3] = {0, 0, 1};
    const double angle = 0.1;
    test_rng rng = test_seed(82);
    rigcal_view_pose *bad;
    double R[9], R_true[9];
    rigcal_transform twist = test_turned_about(axis, angle);
    rig r;

    new_rig(&r, &rng, 3);
    for (int i = 0; i < 5; i++) {
        add_view(&r, 0, i, 20);
        add_view(&r, 1, i, 20);
        add_view(&r, 1, i + 5, 20);
        if (i < 4) {
            add_view(&r, 2, i + 5, 20);
        }
    }
    add_view(&r, 0, 9, 2);
    bad = add_view(&r, 2, 9, 2);
    bad->cam_from_target = test_times(&twist, &bad->cam_from_target);
    ASSERT_STATUS(RIGCAL_OK, join(&r));
    assert_joined(&r, 1);
    test_transform_parts(R, NULL, &r.joined[2]);
    test_transform_parts(R_true, NULL, &r.cams_from_rig[2]);
    TEST_ASSERT_TRUE(test_angle_between(R, R_true) < angle / 10);
}

static void test_poses_that_contradict_each_other_have_no_mean(void)
{
    static const double axis[3] = {1, 0, 0};
    const rigcal_transform half = test_turned_about(axis, TEST_PI);
    test_rng rng = test_seed(83);
    rigcal_view_pose *view;
    rig r;

    new_rig(&r, &rng, 2);
    for (int i = 0; i < 2; i++) {
        add_view(&r, 0, i, 8);
        view = add_view(&r, 1, i, 8);
        if (i == 1) {
            view->cam_from_target = test_times(&half, &view->cam_from_target);
        }
    }
    ASSERT_STATUS(RIGCAL_ERR_ROTATION, join(&r));
}

static void assert_join_refused(rigcal_status status, rig *r)
{
    FILL(r->joined);
    FILL(r->group);
    ASSERT_STATUS(status, join(r));
    ASSERT_UNTOUCHED(r->joined);
    ASSERT_UNTOUCHED(r->group);
}

/* Pointer k of a rig is NULL. */
enum { N_POINTERS = 5 };
static void without_pointer(rigcal_rig *library, int k)
{
    library->cams_from_rig = k == 0 ? NULL : library->cams_from_rig;
    library->group = k == 1 ? NULL : library->group;
    library->views = k == 2 ? NULL : library->views;
    library->work = k == 3 ? NULL : library->work;
    library->weight = k == 4 ? NULL : library->weight;
}

static void test_arguments_of_the_join_are_checked(void)
{
    test_rng rng = test_seed(84);
    rig good, r;

    TEST_WANTS_RAM(2 * sizeof(rig) + 8000);
    new_rig(&good, &rng, 2);
    for (int i = 0; i < 3; i++) {
        add_view(&good, 0, i, 8);
        add_view(&good, 1, i, 8);
    }
    r = good;
    FILL(r.joined);
    FILL(r.group);
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rig_join(NULL));
    for (int k = 0; k < N_POINTERS; k++) {
        rigcal_rig library = rig_of(&r);

        without_pointer(&library, k);
        ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rig_join(&library));
    }
    ASSERT_UNTOUCHED(r.joined);
    ASSERT_UNTOUCHED(r.group);
    r.n_cameras = 0;
    assert_join_refused(RIGCAL_ERR_TOO_FEW, &r);
    r.n_cameras = ((size_t)1 << 28) + 1;
    assert_join_refused(RIGCAL_ERR_RANGE, &r);
    r = good;
    r.n_views = ((size_t)1 << 28) + 1;
    assert_join_refused(RIGCAL_ERR_RANGE, &r);
    for (size_t i = 0; i < 6; i++) {
        r = good;
        r.views[i].camera = 2;
        assert_join_refused(RIGCAL_ERR_RANGE, &r);
        r.views[i].camera = -1;
        assert_join_refused(RIGCAL_ERR_RANGE, &r);
        r = good;
        r.views[i].placement = -1;
        assert_join_refused(RIGCAL_ERR_RANGE, &r);
        r = good;
        r.views[i].weight = 0;
        assert_join_refused(RIGCAL_ERR_RANGE, &r);
        r.views[i].weight = -3;
        assert_join_refused(RIGCAL_ERR_RANGE, &r);
        r.views[i].weight = TEST_NAN;
        assert_join_refused(RIGCAL_ERR_NOT_FINITE, &r);
        r = good;
        r.views[i].cam_from_target.t[1] = TEST_INF;
        assert_join_refused(RIGCAL_ERR_NOT_FINITE, &r);
        r = good;
        r.views[i].cam_from_target.R[0] += RC(0.2);
        assert_join_refused(RIGCAL_ERR_ROTATION, &r);
        r = good;
        r.views[i].cam_from_target.t[2] = RC(TOL(2e30, 2e9));
        assert_join_refused(RIGCAL_ERR_RANGE, &r);
    }
}

/* ---- placing the target -------------------------------------------------- */

static rigcal_status place(rigcal_transform *out, rig *r, int32_t placement,
                           int32_t in_group)
{
    rigcal_rig library = rig_of(r);

    return rigcal_rig_place(out, &library, placement, in_group);
}

static void test_placements_come_back_from_the_joined_rig(void)
{
    test_rng rng = test_seed(85);
    rigcal_transform seen, expected;
    rig r;

    /* 0, 1 and 2 connect; 3 and 4 are a group of their own. */
    new_rig(&r, &rng, 5);
    for (int i = 0; i < 3; i++) {
        add_view(&r, 0, i, 5);
        add_view(&r, 1, i + 1, 7);
        add_view(&r, 2, i, 9);
        add_view(&r, 3, i + 6, 5);
        add_view(&r, 4, i + 6, 6);
    }
    ASSERT_STATUS(RIGCAL_DISCONNECTED, join(&r));
    for (int32_t i = 0; i < 4; i++) {
        ASSERT_STATUS(RIGCAL_OK, place(&seen, &r, i, 0));
        ASSERT_TRANSFORM(&r.rig_from_target[i], &seen, TOL_ENTRY, TOL_LENGTH);
        ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, seen, place(&seen, &r, i, 1));
    }
    for (int32_t i = 6; i < 9; i++) { /* in the frame of camera 3 */
        ASSERT_STATUS(RIGCAL_OK, place(&seen, &r, i, 1));
        expected = test_times(&r.cams_from_rig[3], &r.rig_from_target[i]);
        ASSERT_TRANSFORM(&expected, &seen, TOL_ENTRY, TOL_LENGTH);
        ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, seen, place(&seen, &r, i, 0));
    }
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, seen, place(&seen, &r, 5, 0));
}

static void test_a_placement_is_the_weighted_mean_of_what_cameras_say(void)
{
    test_rng rng = test_seed(86);
    rigcal_transform seen;
    double expected[3];
    rig r;

    new_rig(&r, &rng, 2);
    r.cams_from_rig[1] = NOTHING; /* so both speak in the rig's own frame */
    add_view(&r, 0, 0, 30);
    add_view(&r, 1, 0, 10)->cam_from_target.t[1] += 1;
    for (int i = 0; i < 2; i++) {
        r.joined[i] = NOTHING;
        r.group[i] = 0;
    }
    ASSERT_STATUS(RIGCAL_OK, place(&seen, &r, 0, 0));
    test_to_double(expected, r.rig_from_target[0].t, 3);
    expected[1] += 0.25;
    ASSERT_ARRAY_NEAR(expected, seen.t, 3, TOL(1e-14, 3e-6));
}

static void test_arguments_of_the_placing_are_checked(void)
{
    test_rng rng = test_seed(87);
    rigcal_transform seen;
    rig r, bad;

    TEST_WANTS_RAM(2 * sizeof(rig) + 8000);
    new_rig(&r, &rng, 2);
    add_view(&r, 0, 0, 8);
    add_view(&r, 1, 0, 8);
    ASSERT_STATUS(RIGCAL_OK, join(&r));
    ASSERT_STATUS(RIGCAL_ERR_NULL, place(NULL, &r, 0, 0));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, seen, rigcal_rig_place(&seen, NULL, 0, 0));
    for (int k = 0; k < N_POINTERS; k++) {
        rigcal_rig library = rig_of(&r);

        without_pointer(&library, k);
        ASSERT_REFUSED(RIGCAL_ERR_NULL, seen, rigcal_rig_place(&seen, &library, 0, 0));
    }
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, seen, place(&seen, &r, 3, 0));
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, seen, place(&seen, &r, 0, 3));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, seen, place(&seen, &r, -1, 0));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, seen, place(&seen, &r, 0, -1));
    for (int i = 0; i < 2; i++) {
        bad = r;
        bad.views[i].camera = 2;
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, seen, place(&seen, &bad, 0, 0));
        bad = r;
        bad.views[i].cam_from_target.R[8] = TEST_NAN;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, seen, place(&seen, &bad, 0, 0));
        bad = r;
        bad.joined[i].R[8] += RC(0.1);
        ASSERT_REFUSED(RIGCAL_ERR_ROTATION, seen, place(&seen, &bad, 0, 0));
        bad = r;
        bad.joined[i].t[0] = TEST_INF;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, seen, place(&seen, &bad, 0, 0));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_two_cameras_join_through_one_placement);
    RUN_TEST(test_one_camera_alone_is_a_rig);
    RUN_TEST(test_a_connected_rig_is_joined_whatever_sees_what);
    RUN_TEST(test_cameras_that_share_nothing_join_through_a_third);
    RUN_TEST(test_groups_that_share_nothing_are_told_apart);
    RUN_TEST(test_placements_are_averaged_by_weight);
    RUN_TEST(test_a_placement_counts_as_its_weaker_view);
    RUN_TEST(test_small_weights_connect_as_well);
    RUN_TEST(test_a_length_is_averaged_over_placements);
    RUN_TEST(test_the_best_shared_camera_is_joined_first);
    RUN_TEST(test_poses_that_contradict_each_other_have_no_mean);
    RUN_TEST(test_arguments_of_the_join_are_checked);
    RUN_TEST(test_placements_come_back_from_the_joined_rig);
    RUN_TEST(test_a_placement_is_the_weighted_mean_of_what_cameras_say);
    RUN_TEST(test_arguments_of_the_placing_are_checked);
}
