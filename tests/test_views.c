/* views: the input of a rig, its checks, its groups, and views from a source. */
#include <math.h>
#include <string.h>

#include "rc_views.h"
#include "rigcal_solvers.h"
#include "test_rigs.h"

static test_rig r;

#define WANTS_RIG TEST_WANTS_RAM(sizeof(test_rig) + 12000)

/* Two cameras and three placements, all seen: views 0 to 5. */
static void make(int n_cameras, int n_placements)
{
    test_rng rng = test_seed(331);

    test_rig_random(&r, &rng, n_cameras, n_placements, 6);
    test_rig_see_all(&r, &rng, 0.2);
    test_rig_solve_views(&r);
}

/* Both functions must refuse it and leave cameras and placements unchanged. */
static void assert_refused(rigcal_status status, int32_t at)
{
    rigcal_rig_fit fit;
    int32_t at_fault = -2;

    memcpy(r.cams, r.true_cams, sizeof r.cams);
    memcpy(r.places, r.true_places, sizeof r.places);
    ASSERT_REFUSED(status, fit, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_INT32(at, at_fault);
    at_fault = -2;
    ASSERT_STATUS(status, rigcal_rig_join(&r.rig, &at_fault));
    TEST_ASSERT_EQUAL_INT32(at, at_fault);
    TEST_ASSERT_EQUAL_MEMORY(r.true_cams, r.cams, sizeof r.cams);
    TEST_ASSERT_EQUAL_MEMORY(r.true_places, r.places, sizeof r.places);
}

static void set_view(size_t v, int32_t camera, int32_t placement)
{
    r.views[v].camera = r.own[v].camera = camera;
    r.views[v].placement = r.own[v].placement = placement;
}

static void test_pointers_must_be_there(void)
{
    rigcal_rig_fit fit;
    int32_t at_fault;

    WANTS_RIG;
    make(2, 3);
    ASSERT_REFUSED(RIGCAL_ERR_NULL, fit, rigcal_rig_adjust(&fit, &at_fault, NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rig_adjust(NULL, &at_fault, &r.rig));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rig_join(NULL, NULL));
    for (int k = 0; k < 5; k++) {
        make(2, 3);
        r.rig.cams_from_rig = k == 0 ? NULL : r.rig.cams_from_rig;
        r.rig.rig_from_placements = k == 1 ? NULL : r.rig.rig_from_placements;
        r.rig.group = k == 2 ? NULL : r.rig.group;
        r.rig.work = k == 3 ? NULL : r.rig.work;
        if (k == 4) { /* it has the role of a prior, but no prior is given */
            r.roles[1] = RIGCAL_CAMERA_PRIOR;
            r.rig.roles = r.roles;
            r.rig.sigma_px = 1;
        }
        assert_refused(RIGCAL_ERR_NULL, -1);
    }
    make(2, 3);
    r.rig.views = NULL;
    ASSERT_REFUSED(RIGCAL_ERR_NULL, fit, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
    make(2, 3);
    r.rig.view_poses = NULL;
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rig_join(&r.rig, &at_fault));
}

static void test_counts_have_their_range(void)
{
    const size_t most = (size_t)1 << 28;

    WANTS_RIG;
    make(2, 3);
    r.rig.n_cameras = 0;
    assert_refused(RIGCAL_ERR_TOO_FEW, -1);
    r.rig.n_cameras = most + 1;
    assert_refused(RIGCAL_ERR_RANGE, -1);
    make(2, 3);
    r.rig.n_views = 0;
    assert_refused(RIGCAL_ERR_TOO_FEW, -1);
    r.rig.n_views = most + 1;
    assert_refused(RIGCAL_ERR_RANGE, -1);
    make(2, 3);
    r.rig.n_placements = most + 1;
    assert_refused(RIGCAL_ERR_RANGE, -1);
    make(2, 3);
    r.rig.sigma_px = -1;
    assert_refused(RIGCAL_ERR_RANGE, -1);
    r.rig.sigma_px = TEST_NAN;
    assert_refused(RIGCAL_ERR_NOT_FINITE, -1);
}

static void test_a_view_names_a_camera_a_placement_and_a_target_that_are(void)
{
    WANTS_RIG;
    for (size_t v = 0; v < 6; v++) {
        static const int32_t BAD[] = {-1, INT32_MIN, INT32_MAX, 4};

        for (int k = 0; k < 4; k++) {
            make(2, 3);
            set_view(v, BAD[k], r.views[v].placement);
            assert_refused(RIGCAL_ERR_RANGE, (int32_t)v);
            make(2, 3);
            set_view(v, r.views[v].camera, BAD[k]);
            assert_refused(RIGCAL_ERR_RANGE, (int32_t)v);
        }
        make(2, 3);
        set_view(v, 2, r.views[v].placement); /* and the next view, which has the same
                                                 place */
        assert_refused(RIGCAL_ERR_RANGE, (int32_t)v);
        make(2, 3);
        set_view(v, r.views[v].camera, 3);
        assert_refused(RIGCAL_ERR_RANGE, (int32_t)v);
    }
}

static void test_so_far_there_is_one_target(void)
{
    rigcal_rig_fit fit;
    int32_t at_fault;

    WANTS_RIG;
    make(2, 3);
    r.views[4].target = 1;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, fit, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_INT32(4, at_fault);
}

static void test_roles_and_what_priors_want(void)
{
    rigcal_rig_fit fit;
    int32_t at_fault;

    WANTS_RIG;
    make(2, 3);
    r.roles[1] = 3;
    r.rig.roles = r.roles;
    assert_refused(RIGCAL_ERR_RANGE, -1);
    r.roles[1] = RIGCAL_CAMERA_PRIOR;
    r.rig.priors = r.priors;
    r.priors[1].cam_from_rig = r.true_cams[1];
    for (int k = 0; k < 6; k++) {
        r.priors[1].Sigma[7 * k] = RC(1e-4);
    }
    assert_refused(RIGCAL_ERR_RANGE, -1); /* its noise is unknown */
    r.rig.sigma_px = RC(0.2);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
    r.priors[1].Sigma[7] = TEST_NAN;
    assert_refused(RIGCAL_ERR_NOT_FINITE, -1);
    r.priors[1].Sigma[7] = RC(1e-4);
    r.priors[1].cam_from_rig.R[0] = 3;
    assert_refused(RIGCAL_ERR_ROTATION, -1);
    r.priors[1].cam_from_rig = r.true_cams[1];
    r.priors[1].Sigma[7] = -1;
    memcpy(r.cams, r.true_cams, sizeof r.cams);
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, fit, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
}

static void test_views_are_in_order_and_no_camera_twice_in_a_placement(void)
{
    WANTS_RIG;
    make(2, 3);
    set_view(4, 0, 0); /* this one comes after placement 1 */
    assert_refused(RIGCAL_ERR_UNSORTED, 4);
    make(2, 3);
    set_view(0, 0, 2);
    assert_refused(RIGCAL_ERR_UNSORTED, 1);
    make(2, 3);
    set_view(3, 0, 1);
    assert_refused(RIGCAL_ERR_TWICE, 3);
    make(3, 2);
    set_view(5, 0, 1); /* not next to it */
    assert_refused(RIGCAL_ERR_TWICE, 5);
}

static void test_memory_to_work_in_is_as_told(void)
{
    rigcal_real Sigma[36];
    rigcal_rig_fit fit;
    int32_t at_fault;

    WANTS_RIG;
    make(3, 2);
    TEST_ASSERT_EQUAL_UINT64(RIGCAL_RIG_WORK(2, 3, 2), rigcal_rig_work(2, 3, 2));
    r.rig.work_capacity = RIGCAL_RIG_WORK(2, 3, 2) - 1;
    assert_refused(RIGCAL_ERR_CAPACITY, -1);
    r.rig.work_capacity = RIGCAL_RIG_WORK(0, 3, 2) - 1;
    assert_refused(RIGCAL_ERR_CAPACITY, -1);
    /* Exactly this much memory is enough, and nothing is written beyond it. */
    r.rig.work_capacity = RIGCAL_RIG_WORK(2, 3, 2);
    for (size_t k = 0; k < RIG_WORK; k++) {
        r.work[k] = 77;
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
    for (size_t k = RIGCAL_RIG_WORK(2, 3, 2); k < RIG_WORK; k++) {
        ASSERT_NEAR(77, r.work[k], 0);
    }
    /* A rig whose memory has become less since then is not adjusted. */
    r.rig.work_capacity--;
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_rig_covariance(Sigma, &r.rig, RC(0.2), 1));
    r.rig.work_capacity++;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(Sigma, &r.rig, RC(0.2), 1));
}

/* If a camera of a group is held or has a prior, none is held for the group, whichever
 * camera that is; else the first one is. */
static void test_the_first_camera_is_held_if_no_other_is_fixed(void)
{
    rigcal_rig_fit fit;
    rc_rig_parts parts;

    WANTS_RIG;
    for (int fixed = -1; fixed < 3; fixed++) {
        for (int how = RIGCAL_CAMERA_HELD; how <= RIGCAL_CAMERA_PRIOR; how++) {
            int next = 0;

            make(3, 3);
            r.rig.roles = r.roles;
            r.rig.priors = r.priors;
            r.rig.sigma_px = RC(0.2);
            for (int c = 0; c < 3; c++) {
                r.roles[c] = (uint8_t)(c == fixed ? how : RIGCAL_CAMERA_FREE);
                r.priors[c].cam_from_rig = r.true_cams[c];
                for (int k = 0; k < 6; k++) {
                    r.priors[c].Sigma[7 * k] = RC(1e-4);
                }
            }
            ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
            rc_rig_parts_of(&parts, &r.rig, 0);
            for (int c = 0; c < 3; c++) {
                const int is_held =
                    c == fixed ? how == RIGCAL_CAMERA_HELD : fixed < 0 && c == 0;
                ASSERT_NEAR(is_held ? -1 : next, parts.column[c], 0);
                next += is_held ? 0 : 6;
            }
        }
    }
}

/* After a rig is forgotten nothing is asked of it, though its numbers are still there. */
static void test_a_rig_that_is_forgotten_is_not_adjusted(void)
{
    rigcal_real Sigma[36];
    rigcal_rig_fit fit;
    rc_rig_parts parts;

    WANTS_RIG;
    make(3, 2);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    TEST_ASSERT_TRUE(rc_rig_is_adjusted(&parts, &r.rig));
    rc_rig_forget(&r.rig);
    TEST_ASSERT_FALSE(rc_rig_is_adjusted(&parts, &r.rig));
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_rig_covariance(Sigma, &r.rig, RC(0.2), 1));
}

/* What is counted is refused beyond 2^28, each count by itself, before anything is read. */
static void test_each_count_has_its_most(void)
{
    const size_t most = RC_COUNT_MAX;

    WANTS_RIG;
    if (most + 1 < most) {
        TEST_IGNORE_MESSAGE("this size_t counts no more");
    }
    make(2, 3);
    for (int which = 0; which < 3; which++) {
        size_t *const n = which == 0   ? &r.rig.n_cameras
                          : which == 1 ? &r.rig.n_placements
                                       : &r.rig.n_views;
        const size_t kept = *n;

        *n = most;
        ASSERT_STATUS(RIGCAL_OK, rc_rig_check(&r.rig));
        *n = most + 1;
        ASSERT_STATUS(RIGCAL_ERR_RANGE, rc_rig_check(&r.rig));
        *n = 0;
        ASSERT_STATUS(which == 1 ? RIGCAL_OK : RIGCAL_ERR_TOO_FEW, rc_rig_check(&r.rig));
        *n = kept;
    }
}

/* The information of two views one after the other is that of springs in a row. */
static void test_the_information_of_both_is_half_the_harmonic_mean(void)
{
    static const double A[5] = {1, 2, 1e-20, 1e20, 3};
    static const double B[5] = {1, 6, 1e20, 1e20, 0};
    static const double BOTH[5] = {0.5, 1.5, 1e-20, 5e19, 0};

    for (int k = 0; k < 5; k++) {
        ASSERT_NEAR(BOTH[k], rc_information_of_both(RC(A[k]), RC(B[k])),
                    TOL(1e-15, 1e-6) * BOTH[k]);
        ASSERT_NEAR(BOTH[k], rc_information_of_both(RC(B[k]), RC(A[k])),
                    TOL(1e-15, 1e-6) * BOTH[k]);
    }
    ASSERT_NEAR(0, rc_information_of_both(-1, 2), 0);
}

/* Each number of a pose, and what no pose can have. */
static void test_a_pose_of_a_view_is_checked_to_its_last_number(void)
{
    rigcal_view_pose pose;

    WANTS_RIG;
    make(2, 3);
    ASSERT_STATUS(RIGCAL_OK, rc_check_pose(&r.own[0]));
    for (int k = 0; k < 21; k++) {
        pose = r.own[0];
        pose.information[k] = k % 2 ? TEST_NAN : TEST_INF;
        ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rc_check_pose(&pose));
    }
    for (int k = 0; k < 9; k++) {
        pose = r.own[0];
        pose.cam_from_target.R[k] += 1;
        ASSERT_STATUS(RIGCAL_ERR_ROTATION, rc_check_pose(&pose));
    }
    pose = r.own[0];
    pose.sse = TEST_NAN;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rc_check_pose(&pose));
    pose.sse = RC(-1e-9);
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rc_check_pose(&pose));
    pose.sse = 0;
    ASSERT_STATUS(RIGCAL_OK, rc_check_pose(&pose));
    memset(pose.information, 0, sizeof pose.information);
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE, rc_check_pose(&pose));
    ASSERT_NEAR(0, rc_view_information(&pose), 0);
}

/* In an adjustment the points of a view may be far from the origin compared with their
 * size, even if no pose can be found from them. */
static void test_a_target_may_be_far_from_its_origin(void)
{
    rigcal_pose poses[RIGCAL_POSES_MAX];
    rigcal_rig_fit fit;
    int32_t at_fault;
    size_t n_found;

    WANTS_RIG;
    make(2, 3);
    for (size_t i = 0; i < r.views[0].view.n; i++) {
        r.o[0][i].X_w[0] += RC(TOL(1e13, 1e5));
    }
    ASSERT_STATUS(RIGCAL_ERR_PRECISION,
                  rigcal_pose_solve(poses, RIGCAL_POSES_MAX, &n_found, &at_fault,
                                    &r.views[0].view, NULL));
    TEST_ASSERT_TRUE(rigcal_rig_adjust(&fit, &at_fault, &r.rig) != RIGCAL_ERR_PRECISION);
}

static void test_a_view_that_is_bad_is_named(void)
{
    rigcal_rig_fit fit;
    int32_t at_fault;

    WANTS_RIG;
    for (size_t v = 0; v < 6; v++) {
        make(2, 3);
        r.o[v][3].uv[1] = TEST_NAN;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, fit,
                       rigcal_rig_adjust(&fit, &at_fault, &r.rig));
        TEST_ASSERT_EQUAL_INT32((int32_t)v, at_fault);
        make(2, 3);
        r.views[v].view.n = 0;
        ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, fit, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
        TEST_ASSERT_EQUAL_INT32((int32_t)v, at_fault);
        make(2, 3);
        r.own[v].information[20] = TEST_INF;
        ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rigcal_rig_join(&r.rig, &at_fault));
        TEST_ASSERT_EQUAL_INT32((int32_t)v, at_fault);
        make(2, 3);
        memset(r.own[v].information, 0, sizeof r.own[v].information);
        ASSERT_STATUS(RIGCAL_ERR_DEGENERATE, rigcal_rig_join(&r.rig, &at_fault));
        TEST_ASSERT_EQUAL_INT32((int32_t)v, at_fault);
        make(2, 3);
        r.own[v].cam_from_target.R[0] = 2;
        ASSERT_STATUS(RIGCAL_ERR_ROTATION, rigcal_rig_join(&r.rig, &at_fault));
        TEST_ASSERT_EQUAL_INT32((int32_t)v, at_fault);
    }
}

/* ---- groups -------------------------------------------------------------- */

static void test_cameras_are_grouped_by_what_they_share(void)
{
    static const struct {
        int n_views;
        int8_t seen[6][2]; /* camera, placement */
        int32_t group[4];
    } CASES[] = {
        {4, {{0, 0}, {2, 0}, {1, 1}, {3, 1}}, {0, 1, 0, 1}},
        {4, {{0, 0}, {1, 1}, {2, 1}, {3, 2}}, {0, 1, 1, 2}},
        {6, {{3, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}, {0, 0, 0, 0}}, /* a chain */
        {2, {{1, 0}, {2, 0}}, {0, 1, 1, 2}}, /* 0 and 3 see nothing */
        {5, {{0, 0}, {3, 0}, {1, 1}, {2, 1}, {3, 2}}, {0, 1, 1, 0}},
        {6, {{0, 0}, {1, 0}, {2, 1}, {3, 1}, {3, 2}, {1, 2}}, {0, 0, 0, 0}},
    };
    test_rng rng = test_seed(332);

    WANTS_RIG;
    for (size_t k = 0; k < sizeof CASES / sizeof CASES[0]; k++) {
        rigcal_status expected = RIGCAL_OK;
        rigcal_rig_fit fit;
        int32_t at_fault;

        test_rig_random(&r, &rng, 4, 3, 6);
        for (int v = 0; v < CASES[k].n_views; v++) {
            test_rig_see(&r, &rng, CASES[k].seen[v][0], CASES[k].seen[v][1], 0.2);
        }
        test_rig_solve_views(&r);
        for (int c = 0; c < 4; c++) {
            expected = CASES[k].group[c] > 0 ? RIGCAL_DISCONNECTED : expected;
        }
        ASSERT_STATUS(expected, rigcal_rig_join(&r.rig, &at_fault));
        TEST_ASSERT_EQUAL_INT32_ARRAY(CASES[k].group, r.group, 4);
        memset(r.group, 77, sizeof r.group);
        ASSERT_STATUS(expected, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
        TEST_ASSERT_EQUAL_INT32_ARRAY(CASES[k].group, r.group, 4);
    }
}

/* ---- sources ------------------------------------------------------------- */

typedef struct {
    size_t fails_at;
    rigcal_status status;
    rigcal_observation kept[RIG_POINTS_MAX]; /* valid only until the next call */
} source;

static rigcal_status next_view(rigcal_rig_view *view, size_t index, void *context)
{
    source *const from = context;

    if (index == from->fails_at) {
        return from->status;
    }
    memcpy(from->kept, r.o[index], sizeof from->kept);
    *view = r.views[index];
    view->view.observations = from->kept;
    return RIGCAL_OK;
}

static rigcal_status next_pose(rigcal_view_pose *pose, size_t index, void *context)
{
    const source *const from = context;

    if (index == from->fails_at) {
        return from->status;
    }
    *pose = r.own[index];
    return RIGCAL_OK;
}

static void use_sources(source *from)
{
    r.rig.views = NULL;
    r.rig.view_poses = NULL;
    r.rig.view_source = next_view;
    r.rig.view_pose_source = next_pose;
    r.rig.context = from;
}

static void test_a_source_gives_the_bits_of_arrays(void)
{
    rigcal_transform joined[RIG_CAMERAS_MAX], cams[RIG_CAMERAS_MAX];
    rigcal_real Sigma[36], Sigma_again[36];
    source from = {(size_t)-1, RIGCAL_OK, {{{0}, {0}}}};
    rigcal_rig_fit fit, again;
    int32_t at_fault;

    WANTS_RIG;
    make(3, 4);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_join(&r.rig, &at_fault));
    memcpy(joined, r.cams, sizeof joined);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
    memcpy(cams, r.cams, sizeof cams);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_placement(Sigma, &r.rig, 1, 2));
    use_sources(&from);
    memset(r.places, 0, sizeof r.places);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_join(&r.rig, &at_fault));
    TEST_ASSERT_EQUAL_MEMORY(joined, r.cams, sizeof joined);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&again, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_MEMORY(cams, r.cams, sizeof cams);
    TEST_ASSERT_TRUE(fit.sum == again.sum && fit.F == again.F && fit.F > 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_placement(Sigma_again, &r.rig, 1, 2));
    TEST_ASSERT_EQUAL_MEMORY(Sigma, Sigma_again, sizeof Sigma);
}

static void test_what_a_source_says_is_returned(void)
{
    source from = {0, RIGCAL_ERR_DAMAGED, {{{0}, {0}}}};

    WANTS_RIG;
    for (size_t v = 0; v < 6; v++) {
        make(2, 3);
        from.fails_at = v;
        use_sources(&from);
        assert_refused(RIGCAL_ERR_DAMAGED, (int32_t)v);
    }
}

/* A source that fails only after the views have been checked. */
static rigcal_status fails_later(rigcal_rig_view *view, size_t index, void *context)
{
    size_t *const calls = context;

    *view = r.views[index];
    return ++*calls > 8 ? RIGCAL_ERR_DAMAGED : RIGCAL_OK;
}

static void test_a_source_that_fails_later_ends_the_search(void)
{
    rigcal_rig_fit fit;
    int32_t at_fault;
    size_t calls = 0;

    WANTS_RIG;
    make(2, 3);
    r.rig.view_poses = NULL;
    r.rig.views = NULL;
    r.rig.view_source = fails_later;
    r.rig.context = &calls;
    ASSERT_REFUSED(RIGCAL_ERR_DAMAGED, fit, rigcal_rig_adjust(&fit, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_INT32(2, at_fault);
}

/* ---- views left out ------------------------------------------------------ */

/* The same rig, but some views are not given at all. */
static void keep_only(const uint8_t left_out[])
{
    size_t n = 0;

    for (size_t v = 0; v < r.rig.n_views; v++) {
        if (left_out[v] == 0) {
            r.views[n] = r.views[v];
            r.own[n] = r.own[v];
            n++;
        }
    }
    r.rig.n_views = n;
    r.rig.left_out = NULL;
}

static void test_views_left_out_are_as_if_they_were_not_there(void)
{
    test_rng rng = test_seed(339);
    rigcal_transform cams[RIG_CAMERAS_MAX], places[RIG_PLACEMENTS_MAX];
    uint8_t left_out[RIG_VIEWS_MAX];

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(20); trial++) {
        rigcal_rig_fit with, without;
        rigcal_real Sigma[36], fewer[36];

        test_rig_random(&r, &rng, 3, 6, 8);
        test_rig_see_all(&r, &rng, 0.3);
        test_rig_solve_views(&r);
        for (int v = 0; v < 18; v++) {
            left_out[v] = v / 3 == 4 || (v / 3 > 1 && test_next(&rng) % 4 == 0);
            if (left_out[v] != 0) { /* these contents are not read */
                r.views[v].view.n = 0;
                r.own[v].cam_from_target.R[0] = RC(1e30);
                r.own[v].sse = RC(-1e30);
            }
        }
        r.rig.left_out = left_out;
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_join(&r.rig, NULL));
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&with, NULL, &r.rig));
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_placement(Sigma, &r.rig, 1, 5));
        ASSERT_STATUS(RIGCAL_ERR_TOO_FEW, rigcal_rig_placement(fewer, &r.rig, 1, 4));
        memcpy(cams, r.cams, sizeof cams);
        memcpy(places, r.places, sizeof places);
        keep_only(left_out);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_join(&r.rig, NULL));
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&without, NULL, &r.rig));
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_placement(fewer, &r.rig, 1, 5));
        TEST_ASSERT_EQUAL_MEMORY(cams, r.cams, 3 * sizeof cams[0]);
        TEST_ASSERT_EQUAL_MEMORY(places, r.places, 6 * sizeof places[0]);
        TEST_ASSERT_EQUAL_MEMORY(Sigma, fewer, sizeof Sigma);
        ASSERT_NEAR(with.F, without.F, 0);
        ASSERT_NEAR(with.freedom, without.freedom, 0);
    }
}

static void test_a_view_left_out_connects_nothing(void)
{
    static const uint8_t LEFT_OUT[4] = {0, 1, 0, 0}, ALL[4] = {1, 1, 1, 1};
    test_rng rng = test_seed(338);
    rigcal_rig_fit fit;

    WANTS_RIG;
    test_rig_random(&r, &rng, 3, 2, 8);
    test_rig_see(&r, &rng, 0, 0, 0);
    test_rig_see(&r, &rng, 1, 0, 0);
    test_rig_see(&r, &rng, 1, 1, 0);
    test_rig_see(&r, &rng, 2, 1, 0);
    r.rig.left_out = LEFT_OUT;
    ASSERT_STATUS(RIGCAL_DISCONNECTED, rigcal_rig_adjust(&fit, NULL, &r.rig));
    TEST_ASSERT_EQUAL_INT32(0, r.group[0]);
    TEST_ASSERT_EQUAL_INT32(1, r.group[1]);
    TEST_ASSERT_EQUAL_INT32(1, r.group[2]);
    r.rig.left_out = ALL;
    ASSERT_STATUS(RIGCAL_ERR_TOO_FEW, rigcal_rig_adjust(&fit, NULL, &r.rig));
}

static void test_a_pose_may_have_as_many_points_as_can_be_counted(void)
{
    rigcal_view_pose pose = {0};
    rigcal_real unit[36] = {0};

    for (int k = 0; k < 6; k++) {
        unit[7 * k] = 1;
    }
    rc_sym6_pack(pose.information, unit);
    pose.cam_from_target = test_transform(NULL, NULL);
    pose.n = RC_COUNT_MAX;
    ASSERT_STATUS(RIGCAL_OK, rc_check_pose(&pose));
    if (RC_COUNT_MAX < SIZE_MAX) {
        pose.n++;
        ASSERT_STATUS(RIGCAL_ERR_RANGE, rc_check_pose(&pose));
    }
    pose.n = 4;
    pose.sse = -1;
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rc_check_pose(&pose));
}

/* ---- priors that are not independent ----------------------------------------- */

enum { N_PRIORS = 3, OF_PRIORS = RIGCAL_CALIBRATED_SIZE(N_PRIORS), N = 6 * N_PRIORS };
static rigcal_real joint[OF_PRIORS], information[OF_PRIORS];

static void test_the_information_of_priors_is_the_inverse_of_their_covariance(void)
{
    test_rng rng = test_seed(32);
    double A[N][N], Sigma[N][N];

    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            A[i][j] = test_normal(&rng) * ((i < 3) ? 1e-3 : 1);
        }
    }
    for (int i = 0; i < N; i++) {
        for (int j = 0; j <= i; j++) {
            Sigma[i][j] = 0;
            for (int k = 0; k < N; k++) {
                Sigma[i][j] += A[i][k] * A[j][k];
            }
            Sigma[i][j] += (i == j) ? 0.1 * Sigma[i][j] : 0;
            Sigma[j][i] = Sigma[i][j];
            joint[i * (i + 1) / 2 + j] = (rigcal_real)Sigma[i][j];
        }
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_priors_information(information, joint, N_PRIORS));
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            double sum = 0;

            for (int k = 0; k < N; k++) {
                const int row = k > j ? k : j, column = k > j ? j : k;

                sum += Sigma[i][k] * D(information[row * (row + 1) / 2 + column]);
            }
            ASSERT_NEAR(i == j, sum * sqrt(Sigma[j][j] / Sigma[i][i]), TOL(1e-10, 1e-2));
        }
    }
    /* in the memory of the covariance */
    ASSERT_STATUS(RIGCAL_OK, rigcal_priors_information(joint, joint, N_PRIORS));
    TEST_ASSERT_EQUAL_MEMORY(information, joint, sizeof(rigcal_real) * N * (N + 1) / 2);
}

static void test_what_is_no_joint_covariance_has_no_information(void)
{
    const size_t n = RIGCAL_CALIBRATED_SIZE(N_PRIORS);

    for (size_t k = 0; k < n; k++) {
        joint[k] = 0;
    }
    for (size_t i = 0; i < 6 * N_PRIORS; i++) {
        joint[i * (i + 1) / 2 + i] = 1;
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_priors_information(information, joint, N_PRIORS));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_priors_information(NULL, joint, N_PRIORS));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_priors_information(information, NULL, N_PRIORS));
    ASSERT_STATUS(RIGCAL_ERR_TOO_FEW, rigcal_priors_information(information, joint, 0));
    ASSERT_STATUS(RIGCAL_ERR_RANGE,
                  rigcal_priors_information(information, joint, RIGCAL_STORE_FREE_MAX + 1));
    const rigcal_real none[1] = {TEST_NAN}; /* nothing after it is read */
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE,
                  rigcal_priors_information(information, none, RIGCAL_STORE_FREE_MAX));
    joint[n - 2] = TEST_NAN;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE,
                  rigcal_priors_information(information, joint, N_PRIORS));
    joint[n - 2] = RC(1.5); /* two elements are correlated by more than 1 */
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE,
                  rigcal_priors_information(information, joint, N_PRIORS));
    joint[n - 2] = 0;
    joint[0] = RC(TOL(1e-309, 1e-39)); /* 1 / this is infinite */
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE,
                  rigcal_priors_information(information, joint, N_PRIORS));
    joint[0] = 0;
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE,
                  rigcal_priors_information(information, joint, N_PRIORS));
}

/* A rig of which cameras 0, 2 and 3 have priors. `d` is how far they are from them. */
static void make_priors(double Q[N][N], double d[N], test_rng *rng)
{
    static const uint8_t ROLES[4] = {RIGCAL_CAMERA_PRIOR, RIGCAL_CAMERA_FREE,
                                     RIGCAL_CAMERA_PRIOR, RIGCAL_CAMERA_PRIOR};
    make(4, 2);
    r.rig.roles = ROLES;
    r.rig.priors = r.priors;
    r.rig.sigma_px = RC(0.5);
    r.rig.priors_information = information;
    for (int i = 0; i < N; i++) {
        d[i] = test_normal(rng) / 100;
        for (int j = 0; j <= i; j++) {
            const rigcal_real q = RC(test_normal(rng) + ((i == j) ? 9 : 0));

            information[i * (i + 1) / 2 + j] = q;
            Q[i][j] = Q[j][i] = D(q);
        }
    }
    for (int k = 0; k < N_PRIORS; k++) {
        const int c = k + (k > 0);

        r.priors[c].cam_from_rig = test_moved(&r.cams[c], &d[6 * k]);
    }
}

/* (G7): g = sigma^2 Q d, in blocks. */
static void test_priors_count_with_what_links_them(void)
{
    enum { ALL = 24 };
    const double tol = TOL(1e-13, 1e-5), variance = 0.25;
    test_rng rng = test_seed(340);
    double Q[N][N], d[N], S[ALL][ALL] = {{0}};
    rc_rig_parts parts;

    WANTS_RIG;
    make_priors(Q, d, &rng);
    rc_rig_parts_of(&parts, &r.rig, ALL);
    rc_clear(parts.S, ALL * (ALL + 1) / 2);
    for (int c = 0; c < 4; c++) {
        parts.column[c] = (rigcal_real)(6 * c);
    }
    for (int k = 0; k < N_PRIORS; k++) {
        const int c = k + (k > 0);
        rigcal_real sum, g[6], H[21], full[36], again[6];
        double expected_sum = 0;

        ASSERT_STATUS(RIGCAL_OK, rc_rig_prior(&sum, g, H, &parts, &r.rig, (size_t)c));
        rc_sym6_unpack(full, H);
        for (int i = 0; i < 6; i++) {
            double expected = 0;

            for (int j = 0; j < N; j++) {
                const int other = j / 6 + (j >= 6);

                expected += variance * Q[6 * k + i][j] * d[j];
                if (j / 6 < k) {
                    S[6 * c + i][6 * other + j % 6] = variance * Q[6 * k + i][j];
                } else if (j / 6 == k) {
                    ASSERT_NEAR(variance * Q[6 * k + i][j], full[6 * i + j % 6], tol * 10);
                }
            }
            ASSERT_NEAR(expected, g[i], tol);
            expected_sum += expected * d[6 * k + i];
        }
        ASSERT_NEAR(expected_sum, sum, tol);
        ASSERT_STATUS(RIGCAL_OK, rc_rig_prior(&sum, again, H, NULL, &r.rig, (size_t)c));
        TEST_ASSERT_EQUAL_MEMORY(g, again, sizeof g);
    }
    for (int i = 0; i < ALL; i++) {
        for (int j = 0; j <= i; j++) {
            ASSERT_NEAR(S[i][j], parts.S[i * (i + 1) / 2 + j], tol * 10);
        }
    }
}

static void test_each_number_of_the_information_is_checked(void)
{
    test_rng rng = test_seed(341);
    double Q[N][N], d[N];
    rigcal_rig_fit fit;

    WANTS_RIG;
    make_priors(Q, d, &rng);
    for (int k = 0; k < OF_PRIORS; k++) {
        information[k] *= RC(1e5); /* they alone fix the frame of the rig */
    }
    r.priors[3].Sigma[0] = TEST_NAN; /* it does not count */
    TEST_ASSERT_TRUE(rigcal_rig_adjust(&fit, NULL, &r.rig) >= 0);
    for (int k = 0; k < OF_PRIORS; k++) {
        const rigcal_real kept = information[k];

        information[k] = TEST_NAN;
        assert_refused(RIGCAL_ERR_NOT_FINITE, -1);
        information[k] = kept;
    }
    information[0] = RC(-1e12); /* no information is below 0 */
    memcpy(r.cams, r.true_cams, sizeof r.cams);
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, fit, rigcal_rig_adjust(&fit, NULL, &r.rig));
    information[0] = RC(9e5);
    r.rig.sigma_px = 0;
    assert_refused(RIGCAL_ERR_RANGE, -1);
}

TEST_MAIN()
{
    RUN_TEST(test_the_information_of_priors_is_the_inverse_of_their_covariance);
    RUN_TEST(test_what_is_no_joint_covariance_has_no_information);
    RUN_TEST(test_priors_count_with_what_links_them);
    RUN_TEST(test_each_number_of_the_information_is_checked);
    RUN_TEST(test_a_pose_may_have_as_many_points_as_can_be_counted);
    RUN_TEST(test_views_left_out_are_as_if_they_were_not_there);
    RUN_TEST(test_a_view_left_out_connects_nothing);
    RUN_TEST(test_pointers_must_be_there);
    RUN_TEST(test_counts_have_their_range);
    RUN_TEST(test_a_view_names_a_camera_a_placement_and_a_target_that_are);
    RUN_TEST(test_so_far_there_is_one_target);
    RUN_TEST(test_roles_and_what_priors_want);
    RUN_TEST(test_the_first_camera_is_held_if_no_other_is_fixed);
    RUN_TEST(test_views_are_in_order_and_no_camera_twice_in_a_placement);
    RUN_TEST(test_memory_to_work_in_is_as_told);
    RUN_TEST(test_a_rig_that_is_forgotten_is_not_adjusted);
    RUN_TEST(test_each_count_has_its_most);
    RUN_TEST(test_the_information_of_both_is_half_the_harmonic_mean);
    RUN_TEST(test_a_pose_of_a_view_is_checked_to_its_last_number);
    RUN_TEST(test_a_target_may_be_far_from_its_origin);
    RUN_TEST(test_a_view_that_is_bad_is_named);
    RUN_TEST(test_cameras_are_grouped_by_what_they_share);
    RUN_TEST(test_a_source_gives_the_bits_of_arrays);
    RUN_TEST(test_what_a_source_says_is_returned);
    RUN_TEST(test_a_source_that_fails_later_ends_the_search);
}
