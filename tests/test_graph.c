/* graph: what cameras share, groups, advice, the weakest link. The truth: counts by hand,
 * and the covariance of pairs. */
#include <math.h>
#include <string.h>

#include "rc_graph.h"
#include "test_fit.h"
#include "test_rigs.h"

static test_rig r;
static rigcal_link links[RIGCAL_LINKS(RIG_CAMERAS_MAX)];
static int32_t n_groups;

#define WANTS_RIG TEST_WANTS_RAM(sizeof(test_rig) + 12000)

/* Gives the poses an information, so that 1 / variance of the rotation is strength / 3. */
static void give_poses(const double strength[])
{
    static const int DIAGONAL[6] = {0, 3, 5, 15, 18, 20};

    for (size_t v = 0; v < r.rig.n_views; v++) {
        memset(&r.own[v], 0, sizeof r.own[v]);
        r.own[v].camera = r.views[v].camera;
        r.own[v].placement = r.views[v].placement;
        r.own[v].n = 6;
        r.own[v].cam_from_target =
            test_rig_chain(&r, r.views[v].camera, r.views[v].placement);
        for (int k = 0; k < 6; k++) {
            r.own[v].information[DIAGONAL[k]] = RC(strength ? strength[v] : 100);
        }
    }
    r.rig.view_poses = r.own;
}

/* Behind the groups of the cameras and their links nothing is read or written. */
static rigcal_status link_all(void)
{
    const size_t n = r.rig.n_cameras, n_links = RIGCAL_LINKS(n);
    int32_t at_fault = -2;

    if (n < RIG_CAMERAS_MAX) {
        r.group[n] = links[n_links].n_shared = 77;
    }
    const rigcal_status status = rigcal_rig_links(links, RIGCAL_LINKS(RIG_CAMERAS_MAX),
                                                  &n_groups, &at_fault, &r.rig);
    if (n < RIG_CAMERAS_MAX) {
        TEST_ASSERT_EQUAL_INT32(77, r.group[n]);
        TEST_ASSERT_EQUAL_INT32(77, links[n_links].n_shared);
    }
    TEST_ASSERT_TRUE(n_groups <= (int32_t)n);
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
    return status;
}

static void test_where_links_stand(void)
{
    TEST_ASSERT_EQUAL(0, RIGCAL_LINKS(0));
    TEST_ASSERT_EQUAL(0, RIGCAL_LINKS(1));
    TEST_ASSERT_EQUAL(6, RIGCAL_LINKS(4));
    TEST_ASSERT_EQUAL(0, RIGCAL_LINK(0, 1));
    TEST_ASSERT_EQUAL(1, RIGCAL_LINK(0, 2));
    TEST_ASSERT_EQUAL(2, RIGCAL_LINK(1, 2));
    TEST_ASSERT_EQUAL(5, RIGCAL_LINK(2, 3));
}

/* Views with information 30 and 60: 10 and 20 for the rotation, 1 / (1/10 + 1/20) for
 * both. */
static void test_links_by_hand(void)
{
    static const double strength[5] = {30, 60, 60, 60, 30};
    test_rng rng = test_seed(501);

    WANTS_RIG;
    test_rig_random(&r, &rng, 3, 3, 6);
    test_rig_see(&r, &rng, 0, 0, 0);
    test_rig_see(&r, &rng, 2, 0, 0);
    test_rig_see(&r, &rng, 2, 1, 0);
    test_rig_see(&r, &rng, 0, 1, 0);
    test_rig_see(&r, &rng, 1, 2, 0);
    give_poses(strength);
    ASSERT_STATUS(RIGCAL_DISCONNECTED, link_all());
    TEST_ASSERT_EQUAL_INT32(2, n_groups);
    TEST_ASSERT_EQUAL_INT32(0, r.group[0]);
    TEST_ASSERT_EQUAL_INT32(1, r.group[1]);
    TEST_ASSERT_EQUAL_INT32(0, r.group[2]);
    TEST_ASSERT_EQUAL_INT32(2, links[RIGCAL_LINK(0, 2)].n_shared);
    ASSERT_NEAR(20 / 3.0 + 10, links[RIGCAL_LINK(0, 2)].information, TOL(1e-12, 1e-5));
    TEST_ASSERT_EQUAL_INT32(0, links[RIGCAL_LINK(0, 1)].n_shared);
    ASSERT_NEAR(0, links[RIGCAL_LINK(1, 2)].information, 0);
    ASSERT_NEAR(2.0, rc_information_of_both(RC(3), RC(6)), TOL(1e-15, 1e-6));
    ASSERT_NEAR(0, rc_information_of_both(0, RC(6)), 0);
    ASSERT_NEAR(10, rc_view_information(&r.own[0]), TOL(1e-12, 1e-5));
}

/* For each camera the least camera that it is joined with, by a search of the test's
 * own. */
static void groups_by_search(int group[], int seen[RIG_PLACEMENTS_MAX][RIG_CAMERAS_MAX])
{
    const int C = (int)r.rig.n_cameras, F = (int)r.rig.n_placements;

    for (int c = 0; c < C; c++) {
        int in[RIG_CAMERAS_MAX] = {0}, is_more = 1;

        in[c] = 1;
        while (is_more) {
            is_more = 0;
            for (int f = 0; f < F; f++) {
                int touches = 0;

                for (int d = 0; d < C; d++) {
                    touches |= seen[f][d] && in[d];
                }
                for (int d = 0; d < C; d++) {
                    is_more |= touches && seen[f][d] && !in[d];
                    in[d] |= touches && seen[f][d];
                }
            }
        }
        for (group[c] = 0; !in[group[c]]; group[c]++) {
        }
    }
}

static void see_at_random(int seen[RIG_PLACEMENTS_MAX][RIG_CAMERAS_MAX], test_rng *rng)
{
    for (int f = 0; f < (int)r.rig.n_placements; f++) {
        for (int c = 0; c < (int)r.rig.n_cameras; c++) {
            seen[f][c] = test_next(rng) % 3 == 0;
            if (seen[f][c]) {
                test_rig_see(&r, rng, c, f, 0);
            }
        }
    }
}

/* Many random rigs. Their groups are named, and one placement for each line of advice
 * connects them all. */
static void test_advice_connects_every_rig(void)
{
    test_rng rng = test_seed(502);
    int disconnected = 0;

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(400); trial++) {
        int seen[RIG_PLACEMENTS_MAX][RIG_CAMERAS_MAX] = {{0}}, group[RIG_CAMERAS_MAX];
        rigcal_advice advice[RIG_CAMERAS_MAX];
        size_t n = 99;
        int F = 1 + trial % 4, lines;

        test_rig_random(&r, &rng, 1 + (int)(test_next(&rng) % 4), F + 3, 6);
        r.rig.n_placements = (size_t)F;
        see_at_random(seen, &rng);
        if (r.rig.n_views == 0) {
            continue;
        }
        give_poses(NULL);
        groups_by_search(group, seen);
        (void)link_all();
        lines = 0;
        for (int c = 0; c < (int)r.rig.n_cameras; c++) {
            lines += group[c] == c;
            for (int d = 0; d < (int)r.rig.n_cameras; d++) {
                TEST_ASSERT_EQUAL(group[c] == group[d], r.group[c] == r.group[d]);
            }
        }
        TEST_ASSERT_EQUAL_INT32(lines, n_groups);
        disconnected += lines > 1;
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_rig_advise(advice, RIG_CAMERAS_MAX, &n, links, &r.rig));
        TEST_ASSERT_EQUAL(lines - 1, n);
        for (size_t i = 0; i < n; i++) {
            TEST_ASSERT_NOT_EQUAL(r.group[advice[i].a], r.group[advice[i].b]);
            test_rig_see(&r, &rng, advice[i].a, F + (int)i, 0);
            test_rig_see(&r, &rng, advice[i].b, F + (int)i, 0);
        }
        r.rig.n_placements = (size_t)(F + 3);
        give_poses(NULL);
        ASSERT_STATUS(RIGCAL_OK, link_all());
        TEST_ASSERT_EQUAL_INT32(1, n_groups);
    }
    TEST_ASSERT_TRUE(disconnected >= TEST_TRIALS(400) / 4);
}

/* Cameras 0 and 1 share two placements, 1 and 2 share one, camera 3 is alone. The advice
 * must be to show the target to cameras 1 and 3 together. */
static void test_advice_takes_the_best_connected_camera(void)
{
    test_rng rng = test_seed(503);
    rigcal_advice advice[3];
    size_t n;

    WANTS_RIG;
    test_rig_random(&r, &rng, 4, 4, 6);
    for (int f = 0; f < 3; f++) {
        test_rig_see(&r, &rng, f == 2 ? 2 : 0, f, 0);
        test_rig_see(&r, &rng, 1, f, 0);
    }
    test_rig_see(&r, &rng, 3, 3, 0);
    give_poses(NULL);
    ASSERT_STATUS(RIGCAL_DISCONNECTED, link_all());
    FILL(advice);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_advise(advice, 1, &n, links, &r.rig));
    TEST_ASSERT_EQUAL(1, n);
    TEST_ASSERT_EQUAL_INT32(1, advice[0].a);
    TEST_ASSERT_EQUAL_INT32(3, advice[0].b);
    ASSERT_UNTOUCHED(advice[1]);
    ASSERT_REFUSED(RIGCAL_ERR_CAPACITY, advice,
                   rigcal_rig_advise(advice, 0, &n, links, &r.rig));
    for (int c = 0; c < 4; c++) {
        const int32_t group = r.group[c];

        r.group[c] = 4;
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, advice,
                       rigcal_rig_advise(advice, 3, &n, links, &r.rig));
        r.group[c] = -1;
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, advice,
                       rigcal_rig_advise(advice, 3, &n, links, &r.rig));
        r.group[c] = group;
    }
}

/* The only two cameras of a group share the same with it. */
static void test_of_two_that_share_as_much_the_advice_takes_the_first(void)
{
    test_rng rng = test_seed(508);
    rigcal_advice advice[2];
    size_t n;

    WANTS_RIG;
    for (int alone = 0; alone < 3; alone++) {
        const int a = (alone == 0) ? 1 : 0, b = (alone == 2) ? 1 : 2;

        test_rig_random(&r, &rng, 3, 2, 6);
        test_rig_see(&r, &rng, b, 0, 0);
        test_rig_see(&r, &rng, a, 0, 0);
        test_rig_see(&r, &rng, alone, 1, 0);
        give_poses(NULL);
        ASSERT_STATUS(RIGCAL_DISCONNECTED, link_all());
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_advise(advice, 2, &n, links, &r.rig));
        TEST_ASSERT_EQUAL(1, n);
        TEST_ASSERT_EQUAL_INT32(a, advice[0].a);
        TEST_ASSERT_EQUAL_INT32(alone, advice[0].b);
    }
}

/* Two groups of two cameras. The one that shares more placements is joined by the other,
 * whichever has the lower numbers. */
static void test_the_advice_joins_a_group_to_the_best_connected_one(void)
{
    test_rng rng = test_seed(514);
    rigcal_advice advice[3];
    size_t n;

    WANTS_RIG;
    for (int best = 0; best < 2; best++) {
        test_rig_random(&r, &rng, 4, 4, 6);
        for (int f = 0; f < 4; f++) {
            const int pair = (f == 1) ? !best : best;

            test_rig_see(&r, &rng, 2 * pair, f, 0);
            test_rig_see(&r, &rng, 2 * pair + 1, f, 0);
        }
        give_poses(NULL);
        ASSERT_STATUS(RIGCAL_DISCONNECTED, link_all());
        TEST_ASSERT_EQUAL_INT32(2, n_groups);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_advise(advice, 3, &n, links, &r.rig));
        TEST_ASSERT_EQUAL(1, n);
        TEST_ASSERT_EQUAL_INT32(2 * best, advice[0].a);
        TEST_ASSERT_EQUAL_INT32(2 * !best, advice[0].b);
    }
}

/* Nobody saw a target together: each camera is a group, and the first is as good a partner
 * for the rest as any. */
static void test_where_nothing_is_shared_the_advice_joins_all_to_the_first(void)
{
    test_rng rng = test_seed(509);
    rigcal_advice advice[3];
    size_t n;

    WANTS_RIG;
    test_rig_random(&r, &rng, 4, 4, 6);
    for (int c = 0; c < 4; c++) {
        test_rig_see(&r, &rng, c, c, 0);
    }
    give_poses(NULL);
    ASSERT_STATUS(RIGCAL_DISCONNECTED, link_all());
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_advise(advice, 3, &n, links, &r.rig));
    TEST_ASSERT_EQUAL(3, n);
    for (int c = 1; c < 4; c++) {
        TEST_ASSERT_EQUAL_INT32(0, advice[c - 1].a);
        TEST_ASSERT_EQUAL_INT32(c, advice[c - 1].b);
    }
}

/* Camera 2 saw only one placement of six. */
static void test_the_weakest_link(void)
{
    test_rng rng = test_seed(504);
    rigcal_weakest weakest;
    rigcal_rig_fit fit;
    rigcal_transform b_from_a;
    rigcal_real S[36];
    double least = 1e9;

    WANTS_RIG;
    test_rig_random(&r, &rng, 4, 6, 8);
    for (int f = 0; f < 6; f++) {
        for (int c = 0; c < 4; c++) {
            if (c != 2 || f == 3) {
                test_rig_see(&r, &rng, c, f, 0.3);
            }
        }
    }
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_rig_weakest(&weakest, &r.rig, 1));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_weakest(&weakest, &r.rig, RC(0.3)));
    TEST_ASSERT_EQUAL_INT32(2, weakest.camera);
    for (size_t d = 0; d < 4; d++) {
        if (d != 2) {
            ASSERT_STATUS(RIGCAL_OK, rigcal_rig_pair(&b_from_a, S, &r.rig, RC(0.3), 2, d));
            least = fmin(least, sqrt(D(S[0]) + D(S[7]) + D(S[14])));
        }
    }
    ASSERT_NEAR(least, weakest.rotation, TOL(1e-12, 1e-6));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_rig_pair(&b_from_a, S, &r.rig, RC(0.3), 2, (size_t)weakest.other));
    ASSERT_NEAR(sqrt(D(S[21]) + D(S[28]) + D(S[35])), weakest.translation,
                TOL(1e-12, 1e-6));
}

/* Cameras 0 and 1 are held side by side, so camera 2 is as sure to one as to the other. */
static void test_of_two_that_are_as_sure_the_first_is_told(void)
{
    test_rng rng = test_seed(507);
    rigcal_weakest weakest;
    rigcal_rig_fit fit;

    WANTS_RIG;
    test_rig_random(&r, &rng, 3, 4, 8);
    r.true_cams[1] = r.true_cams[0];
    r.true_cams[1].t[0] = RC(0.5);
    r.cams[1] = r.true_cams[1];
    test_rig_see_all(&r, &rng, 0.3);
    r.roles[0] = r.roles[1] = RIGCAL_CAMERA_HELD;
    r.rig.roles = r.roles;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    r.group[3] = r.group[0]; /* of no camera of the rig */
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_weakest(&weakest, &r.rig, RC(0.3)));
    TEST_ASSERT_EQUAL_INT32(2, weakest.camera);
    TEST_ASSERT_EQUAL_INT32(0, weakest.other);
}

/* Of held cameras each is known exactly against each. */
static void test_of_all_that_are_as_sure_the_first_is_the_weakest(void)
{
    test_rng rng = test_seed(515);
    rigcal_weakest weakest;
    rigcal_rig_fit fit;

    WANTS_RIG;
    test_rig_random(&r, &rng, 3, 4, 8);
    test_rig_see_all(&r, &rng, 0.3);
    memset(r.roles, RIGCAL_CAMERA_HELD, sizeof r.roles);
    r.rig.roles = r.roles;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_weakest(&weakest, &r.rig, RC(0.3)));
    TEST_ASSERT_EQUAL_INT32(0, weakest.camera);
    TEST_ASSERT_EQUAL_INT32(1, weakest.other);
    ASSERT_NEAR(0, weakest.rotation, 0);
    ASSERT_NEAR(0, weakest.translation, 0);
}

static void test_no_two_cameras_no_weakest_link(void)
{
    test_rng rng = test_seed(505);
    rigcal_weakest weakest;
    rigcal_rig_fit fit;

    WANTS_RIG;
    test_rig_random(&r, &rng, 2, 2, 8);
    test_rig_see(&r, &rng, 0, 0, 0.3);
    test_rig_see(&r, &rng, 1, 1, 0.3);
    ASSERT_STATUS(RIGCAL_DISCONNECTED, rigcal_rig_adjust(&fit, NULL, &r.rig));
    ASSERT_STATUS(RIGCAL_ERR_TOO_FEW, rigcal_rig_weakest(&weakest, &r.rig, 1));
    test_rig_random(&r, &rng, 1, 2, 8);
    test_rig_see_all(&r, &rng, 0.3);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, weakest, rigcal_rig_weakest(&weakest, &r.rig, 1));
}

static rigcal_status pose_at(rigcal_view_pose *pose, size_t index, void *context)
{
    *pose = r.own[index];
    return (index == *(const size_t *)context) ? RIGCAL_ERR_NO_RAY : RIGCAL_OK;
}

/* The poses come from a source, and from an array. If the source fails, its status is told,
 * and the view. */
static void test_links_of_a_source_are_those_of_an_array(void)
{
    rigcal_link expected[RIGCAL_LINKS(3)];
    size_t fails = 99;
    int32_t at_fault;
    test_rng rng = test_seed(510);

    WANTS_RIG;
    test_rig_random(&r, &rng, 3, 2, 6);
    test_rig_see_all(&r, &rng, 0);
    give_poses(NULL);
    ASSERT_STATUS(RIGCAL_OK, link_all());
    memcpy(expected, links, sizeof expected);
    memset(links, 0, sizeof links);
    r.rig.view_poses = NULL;
    r.rig.view_pose_source = pose_at;
    r.rig.context = &fails;
    ASSERT_STATUS(RIGCAL_OK, link_all());
    TEST_ASSERT_EQUAL_MEMORY(expected, links, sizeof expected);
    for (fails = 0; fails < 6; fails++) {
        ASSERT_STATUS(RIGCAL_ERR_NO_RAY,
                      rigcal_rig_links(links, 3, &n_groups, &at_fault, &r.rig));
        TEST_ASSERT_EQUAL_INT32((int32_t)fails, at_fault);
    }
}

/* Each view is read once when it is checked, and once for its links. The second time the
 * source says another camera for view 4. */
static rigcal_status pose_of_another_camera(rigcal_view_pose *pose, size_t index,
                                            void *context)
{
    int *const calls = (int *)context;

    *pose = r.own[index];
    pose->camera = (++*calls > 6 && index == 4) ? 0 : pose->camera;
    return RIGCAL_OK;
}

static void test_a_camera_twice_in_a_placement_is_refused(void)
{
    test_rng rng = test_seed(516);
    int calls = 0;
    int32_t at_fault;

    WANTS_RIG;
    test_rig_random(&r, &rng, 3, 2, 6);
    test_rig_see_all(&r, &rng, 0);
    give_poses(NULL);
    r.rig.view_poses = NULL;
    r.rig.view_pose_source = pose_of_another_camera;
    r.rig.context = &calls;
    ASSERT_STATUS(RIGCAL_ERR_TWICE,
                  rigcal_rig_links(links, 3, &n_groups, &at_fault, &r.rig));
    r.own[4].camera = 0;
    calls = 0;
    ASSERT_STATUS(RIGCAL_ERR_TWICE,
                  rigcal_rig_links(links, 3, &n_groups, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_INT32(4, at_fault);
}

/* What rigcal_rig_work counts is enough, and one number less is not. Nothing is written
 * beyond the memory. */
static void test_links_take_no_more_memory_than_a_join(void)
{
    test_rng rng = test_seed(511);

    WANTS_RIG;
    for (size_t n = 1; n <= 4; n++) {
        const size_t wanted = rigcal_rig_work(n - 1, n, 3),
                     least = rigcal_rig_work(0, n, 3);
        const size_t capacity[5] = {wanted, wanted - 1, least, least - 1, 0};

        test_rig_random(&r, &rng, (int)n, 3, 6);
        test_rig_see_all(&r, &rng, 0);
        give_poses(NULL);
        for (int k = 0; k < 5; k++) {
            const int is_enough = capacity[k] >= wanted;

            for (size_t i = 0; i < RIG_WORK; i++) {
                r.work[i] = RC(-17);
            }
            r.rig.work_capacity = capacity[k];
            ASSERT_STATUS(is_enough ? RIGCAL_OK : RIGCAL_ERR_CAPACITY, link_all());
            for (size_t i = capacity[k]; i < RIG_WORK; i++) {
                ASSERT_NEAR(-17, r.work[i], 0);
            }
        }
    }
}

/* Links use the memory in which an adjustment left its covariance. */
static void test_after_links_a_rig_is_not_adjusted(void)
{
    test_rng rng = test_seed(512);
    rigcal_weakest weakest;
    rigcal_rig_fit fit;

    WANTS_RIG;
    test_rig_random(&r, &rng, 3, 3, 8);
    test_rig_see_all(&r, &rng, 0.3);
    give_poses(NULL);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_weakest(&weakest, &r.rig, 1));
    ASSERT_STATUS(RIGCAL_OK, link_all());
    ASSERT_REFUSED(RIGCAL_ERR_STATE, weakest,
                   rigcal_rig_weakest(&weakest, &r.rig, RC(0.3)));
}

/* A view that is left out shares nothing, whatever its pose is. */
static void test_what_is_left_out_shares_nothing(void)
{
    static const uint8_t LEFT_OUT[6] = {0, 1, 0, 0, 0, 1};
    test_rng rng = test_seed(513);

    WANTS_RIG;
    test_rig_random(&r, &rng, 3, 2, 6);
    test_rig_see_all(&r, &rng, 0);
    give_poses(NULL);
    memset(r.own[1].information, 0, sizeof r.own[1].information);
    r.own[5].information[0] = TEST_NAN;
    r.rig.left_out = LEFT_OUT;
    ASSERT_STATUS(RIGCAL_OK, link_all());
    TEST_ASSERT_EQUAL_INT32(1, links[RIGCAL_LINK(0, 1)].n_shared);
    TEST_ASSERT_EQUAL_INT32(1, links[RIGCAL_LINK(0, 2)].n_shared);
    TEST_ASSERT_EQUAL_INT32(0, links[RIGCAL_LINK(1, 2)].n_shared);
    ASSERT_NEAR(50 / 3.0, links[RIGCAL_LINK(0, 1)].information, TOL(1e-12, 1e-5));
    ASSERT_NEAR(50 / 3.0, links[RIGCAL_LINK(0, 2)].information, TOL(1e-12, 1e-5));
}

static void test_what_is_refused(void)
{
    test_rng rng = test_seed(506);
    int32_t at_fault = -2;

    WANTS_RIG;
    test_rig_random(&r, &rng, 3, 2, 6);
    test_rig_see_all(&r, &rng, 0);
    give_poses(NULL);
    ASSERT_STATUS(RIGCAL_OK, link_all());
    r.own[4].placement = 0;
    ASSERT_STATUS(RIGCAL_ERR_UNSORTED,
                  rigcal_rig_links(links, 3, &n_groups, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_INT32(4, at_fault);
    r.own[4].placement = 1;
    ASSERT_REFUSED(RIGCAL_ERR_CAPACITY, links,
                   rigcal_rig_links(links, 2, &n_groups, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
    r.rig.left_out = (const uint8_t[]){1, 1, 1, 1, 1, 1};
    at_fault = 7;
    ASSERT_STATUS(RIGCAL_ERR_TOO_FEW,
                  rigcal_rig_links(links, 3, &n_groups, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
    r.rig.left_out = NULL;
    r.rig.view_poses = NULL;
    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_rig_links(links, 3, &n_groups, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
    r.rig.view_poses = r.own;
    r.own[0].camera = 7;
    ASSERT_STATUS(RIGCAL_ERR_RANGE,
                  rigcal_rig_links(links, 3, &n_groups, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_INT32(0, at_fault);
}

TEST_MAIN()
{
    RUN_TEST(test_where_links_stand);
    RUN_TEST(test_links_by_hand);
    RUN_TEST(test_advice_connects_every_rig);
    RUN_TEST(test_advice_takes_the_best_connected_camera);
    RUN_TEST(test_of_two_that_share_as_much_the_advice_takes_the_first);
    RUN_TEST(test_the_advice_joins_a_group_to_the_best_connected_one);
    RUN_TEST(test_where_nothing_is_shared_the_advice_joins_all_to_the_first);
    RUN_TEST(test_the_weakest_link);
    RUN_TEST(test_of_two_that_are_as_sure_the_first_is_told);
    RUN_TEST(test_of_all_that_are_as_sure_the_first_is_the_weakest);
    RUN_TEST(test_no_two_cameras_no_weakest_link);
    RUN_TEST(test_links_of_a_source_are_those_of_an_array);
    RUN_TEST(test_a_camera_twice_in_a_placement_is_refused);
    RUN_TEST(test_links_take_no_more_memory_than_a_join);
    RUN_TEST(test_after_links_a_rig_is_not_adjusted);
    RUN_TEST(test_what_is_left_out_shares_nothing);
    RUN_TEST(test_what_is_refused);
}
