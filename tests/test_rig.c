/* Rigs: the mean of transforms, cameras joined through placements of a target,
 * and the bound of Section VI-C. */
#include <math.h>
#include <string.h>

#include "test_support.h"
#include "vectors_transform.h"

/* Entries of a rotation after a few products; lengths of order 10. */
#define TOL_ENTRY TOL(3e-14, 5e-6)
#define TOL_LENGTH TOL(2e-13, 5e-5)

enum { CAMERAS_MAX = 12, PLACEMENTS_MAX = 10 };
enum { VIEWS_MAX = RIGCAL_TEST_RAM < 32768 ? 40 : 120 };

static const rigcal_transform NOTHING = {{1, 0, 0, 0, 1, 0, 0, 0, 1},
                                         {0, 0, 0}};

/* ---- what several tests need --------------------------------------------- */

static rigcal_transform from_ypr(const double ypr[3], const double t[3])
{
    double R[9];

    test_rotation(R, ypr[0], ypr[1], ypr[2]);
    return test_transform(R, t);
}

static rigcal_transform random_transform(test_rng *rng)
{
    double R[9], t[3];

    test_random_rotation(R, rng);
    for (int k = 0; k < 3; k++) {
        t[k] = test_uniform(rng, -5, 5);
    }
    return test_transform(R, t);
}

static rigcal_transform times(const rigcal_transform *c_from_b,
                              const rigcal_transform *b_from_a)
{
    double R_cb[9], R_ba[9], R[9], t_cb[3], t_ba[3], t[3];

    test_transform_parts(R_cb, t_cb, c_from_b);
    test_transform_parts(R_ba, t_ba, b_from_a);
    test_product(R, R_cb, R_ba);
    test_apply(t, R_cb, t_ba, t_cb);
    return test_transform(R, t);
}

static rigcal_transform inverse(const rigcal_transform *b_from_a)
{
    double R[9], Rt[9], t[3], o[3];

    test_transform_parts(R, t, b_from_a);
    test_transpose(Rt, R);
    test_apply(o, Rt, t, NULL);
    for (int k = 0; k < 3; k++) {
        o[k] = -o[k];
    }
    return test_transform(Rt, o);
}

static rigcal_transform turned_about(const double axis[3], double angle)
{
    double R[9];

    test_rotation_about(R, axis, angle);
    return test_transform(R, NULL);
}

static void assert_same(const rigcal_transform *expected,
                        const rigcal_transform *seen, double tol_entry,
                        double tol_length)
{
    double R[9], t[3];

    test_transform_parts(R, t, expected);
    ASSERT_ARRAY_NEAR(R, seen->R, 9, tol_entry);
    ASSERT_ARRAY_NEAR(t, seen->t, 3, tol_length);
}

/* ---- the mean ------------------------------------------------------------ */

static void test_the_mean_is_scipys_karcher_mean(void)
{
    for (int i = 0; i < TRANSFORM_MEAN_ROWS; i++) {
        const double *v = TRANSFORM_MEAN[i];
        rigcal_transform transforms[5], mean;
        rigcal_real weight[5], sigma_rad, sigma_t;

        for (int k = 0; k < 5; k++) {
            weight[k] = RC(v[7 * k]);
            transforms[k] = from_ypr(v + 7 * k + 1, v + 7 * k + 4);
        }
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_transform_mean(&mean, &sigma_rad, &sigma_t,
                                            transforms, weight, 5));
        ASSERT_ARRAY_NEAR(v + 35, mean.R, 9, TOL(1e-12, 5e-6));
        ASSERT_ARRAY_NEAR(v + 44, mean.t, 3, TOL(1e-14, 2e-6));
        ASSERT_NEAR(v[47], sigma_rad, TOL(1e-12, 5e-6));
        ASSERT_NEAR(v[48], sigma_t, TOL(1e-14, 3e-6));
    }
}

static void test_the_mean_of_one_is_that_one(void)
{
    test_rng rng = test_seed(71);
    const rigcal_transform one = random_transform(&rng);
    rigcal_transform mean;
    rigcal_real sigma_rad, sigma_t;

    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_mean(&mean, &sigma_rad, &sigma_t,
                                                   &one, NULL, 1));
    assert_same(&one, &mean, TOL(1e-15, 1e-6), 0);
    ASSERT_NEAR(0, sigma_rad, TOL(1e-15, 1e-6));
    ASSERT_NEAR(0, sigma_t, 0);
}

/* Turned by +w and -w, shifted by +d and -d: the middle is known, and so is the
 * deviation. */
static void test_deviations_that_balance_leave_the_middle(void)
{
    test_rng rng = test_seed(72);

    for (int trial = 0; trial < 60; trial++) {
        const double angle = trial % 2 ? 0.9 : 1e-3;
        const rigcal_transform middle = random_transform(&rng);
        double axis[3], d[3], length;
        rigcal_transform six[6], mean;
        rigcal_real sigma_rad, sigma_t;

        for (int k = 0; k < 3; k++) {
            d[k] = test_uniform(&rng, -1, 1);
        }
        length = test_norm(d);
        for (int i = 0; i < 6; i += 2) {
            for (int k = 0; k < 3; k++) {
                axis[k] = test_normal(&rng);
            }
            for (int side = 0; side < 2; side++) {
                const rigcal_transform turn =
                    turned_about(axis, side ? angle : -angle);

                six[i + side] = times(&turn, &middle);
                for (int k = 0; k < 3; k++) {
                    six[i + side].t[k] =
                        middle.t[k] + (side ? RC(d[k]) : -RC(d[k]));
                }
            }
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_transform_mean(&mean, &sigma_rad,
                                                       &sigma_t, six, NULL, 6));
        assert_same(&middle, &mean, TOL(1e-14, 3e-6), TOL(1e-14, 3e-6));
        ASSERT_NEAR(angle, sigma_rad, TOL(1e-14, 3e-6));
        ASSERT_NEAR(length, sigma_t, TOL(1e-14, 3e-6));
    }
}

/* About one axis the mean angle is the mean of the angles. That of the entries
 * (the chordal mean) of 0, 0 and 1.5 would be 0.45. */
static void test_angles_are_averaged_and_not_entries(void)
{
    static const double axis[3] = {1, 2, -2};
    const rigcal_transform three[3] = {
        turned_about(axis, 0), turned_about(axis, 0), turned_about(axis, 1.5)};
    const rigcal_transform expected = turned_about(axis, 0.5);
    rigcal_transform mean;

    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_transform_mean(&mean, NULL, NULL, three, NULL, 3));
    assert_same(&expected, &mean, TOL(1e-14, 2e-6), 0);
}

static void test_a_weight_counts_as_so_many_repetitions(void)
{
    test_rng rng = test_seed(73);
    const rigcal_real weight[3] = {3, 0, 2}, scaled[3] = {48, 0, 32};
    const double base[3] = {0.4, -0.3, 1.2};
    rigcal_transform three[3], five[5], by_weight, by_scaled, by_repetition;
    rigcal_real sigma[3][2];

    for (int i = 0; i < 3; i++) {
        double ypr[3], t[3];

        for (int k = 0; k < 3; k++) {
            ypr[k] = base[k] + test_uniform(&rng, -0.4, 0.4);
            t[k] = test_uniform(&rng, -2, 2);
        }
        three[i] = from_ypr(ypr, t);
    }
    for (int i = 0; i < 5; i++) {
        five[i] = three[i < 3 ? 0 : 2];
    }
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_transform_mean(&by_weight, &sigma[0][0], &sigma[0][1],
                                        three, weight, 3));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_transform_mean(&by_scaled, &sigma[1][0], &sigma[1][1],
                                        three, scaled, 3));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_transform_mean(&by_repetition, &sigma[2][0],
                                        &sigma[2][1], five, NULL, 5));
    assert_same(&by_weight, &by_scaled, TOL_ENTRY, TOL_LENGTH);
    assert_same(&by_weight, &by_repetition, TOL_ENTRY, TOL_LENGTH);
    for (int k = 0; k < 2; k++) {
        ASSERT_NEAR(sigma[0][k], sigma[1][k], TOL_ENTRY);
        ASSERT_NEAR(sigma[0][k], sigma[2][k], TOL_ENTRY);
    }
}

/* Which frame the rotations are written in changes nothing. */
static void test_the_mean_turns_with_its_frame(void)
{
    test_rng rng = test_seed(74);
    const rigcal_transform turn = random_transform(&rng);
    const rigcal_transform after = random_transform(&rng);
    rigcal_transform plain[4], turned[4], mean, mean_turned, expected;

    for (int i = 0; i < 4; i++) {
        const double ypr[3] = {0.3 * i, 0.2 - 0.2 * i, 0.1 * i * i};
        double R[9];

        test_rotation(R, ypr[0], ypr[1], ypr[2]);
        plain[i] = test_transform(R, NULL);
        turned[i] = times(&turn, &plain[i]);
        turned[i] = times(&turned[i], &after);
    }
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_transform_mean(&mean, NULL, NULL, plain, NULL, 4));
    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_mean(&mean_turned, NULL, NULL,
                                                   turned, NULL, 4));
    expected = times(&turn, &mean);
    expected = times(&expected, &after);
    for (int i = 0; i < 9; i++) {
        ASSERT_NEAR(expected.R[i], mean_turned.R[i], TOL_ENTRY);
    }
}

static void test_rotations_that_cancel_have_no_mean(void)
{
    static const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    rigcal_transform four[4] = {NOTHING, NOTHING, NOTHING, NOTHING}, mean;
    rigcal_real sigma_rad, sigma_t;

    FILL(sigma_rad);
    FILL(sigma_t);
    /* Half a turn apart. */
    four[1] = turned_about(axes[2], TEST_PI);
    ASSERT_REFUSED(
        RIGCAL_ERR_ROTATION, mean,
        rigcal_transform_mean(&mean, &sigma_rad, &sigma_t, four, NULL, 2));
    /* All the way round. */
    for (int i = 0; i < 4; i++) {
        four[i] = turned_about(axes[1], i * TEST_PI / 2);
    }
    ASSERT_REFUSED(
        RIGCAL_ERR_ROTATION, mean,
        rigcal_transform_mean(&mean, &sigma_rad, &sigma_t, four, NULL, 4));
    /* Half turns about all three axes: the matrices sum to zero. */
    for (int i = 0; i < 3; i++) {
        four[i] = turned_about(axes[i], TEST_PI);
    }
    four[3] = NOTHING;
    ASSERT_REFUSED(
        RIGCAL_ERR_ROTATION, mean,
        rigcal_transform_mean(&mean, &sigma_rad, &sigma_t, four, NULL, 4));
    ASSERT_UNTOUCHED(sigma_rad);
    ASSERT_UNTOUCHED(sigma_t);
}

static void test_arguments_of_the_mean_are_checked(void)
{
    const rigcal_transform two[2] = {NOTHING, NOTHING};
    const rigcal_real none[2] = {0, 0}, negative[2] = {2, -1};
    const rigcal_real odd[2] = {1, TEST_NAN}, endless[2] = {TEST_INF, 1};
    rigcal_transform mean, bad[2];
    rigcal_real a, b;

    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_transform_mean(NULL, &a, &b, two, NULL, 2));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, mean,
                   rigcal_transform_mean(&mean, &a, &b, NULL, NULL, 2));
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, mean,
                   rigcal_transform_mean(&mean, &a, &b, two, NULL, 0));
    ASSERT_REFUSED(
        RIGCAL_ERR_RANGE, mean,
        rigcal_transform_mean(&mean, &a, &b, two, NULL, ((size_t)1 << 28) + 1));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, mean,
                   rigcal_transform_mean(&mean, &a, &b, two, none, 2));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, mean,
                   rigcal_transform_mean(&mean, &a, &b, two, negative, 2));
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, mean,
                   rigcal_transform_mean(&mean, &a, &b, two, odd, 2));
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, mean,
                   rigcal_transform_mean(&mean, &a, &b, two, endless, 2));
    for (int i = 0; i < 2; i++) {
        memcpy(bad, two, sizeof bad);
        bad[i].R[4] = -1;
        ASSERT_REFUSED(RIGCAL_ERR_ROTATION, mean,
                       rigcal_transform_mean(&mean, &a, &b, bad, NULL, 2));
        bad[i].R[4] = TEST_NAN;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, mean,
                       rigcal_transform_mean(&mean, &a, &b, bad, NULL, 2));
        memcpy(bad, two, sizeof bad);
        bad[i].t[2] = RC(TOL(1e31, 1e10));
        ASSERT_REFUSED(RIGCAL_ERR_RANGE, mean,
                       rigcal_transform_mean(&mean, &a, &b, bad, NULL, 2));
    }
}

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
        r->cams_from_rig[i] = i ? random_transform(rng) : NOTHING;
    }
    for (int i = 0; i < PLACEMENTS_MAX; i++) {
        r->rig_from_target[i] = random_transform(rng);
    }
}

static rigcal_view_pose *add_view(rig *r, int camera, int placement, double weight)
{
    rigcal_view_pose *view = &r->views[r->n_views++];

    view->cam_from_target =
        times(&r->cams_from_rig[camera], &r->rig_from_target[placement]);
    view->weight = RC(weight);
    view->camera = camera;
    view->placement = placement;
    return view;
}

static rigcal_status join(rig *r)
{
    return rigcal_rig_join(r->joined, r->group, r->n_cameras, r->views,
                           r->n_views, r->work, r->weight);
}

static void assert_joined(const rig *r, int camera)
{
    assert_same(&r->cams_from_rig[camera], &r->joined[camera], TOL_ENTRY,
                TOL_LENGTH);
}

static void test_two_cameras_join_through_one_placement(void)
{
    test_rng rng = test_seed(75);
    rig r;

    new_rig(&r, &rng, 2);
    add_view(&r, 0, 4, 10);
    add_view(&r, 1, 4, 12);
    ASSERT_STATUS(RIGCAL_OK, join(&r));
    assert_same(&NOTHING, &r.joined[0], 0, 0);
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
    assert_same(&NOTHING, &r.joined[0], 0, 0);
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
    assert_same(&NOTHING, &r.joined[1], 0, 0);
    assert_same(&NOTHING, &r.joined[2], 0, 0);
    assert_same(&NOTHING, &r.joined[5], 0, 0);
    back = inverse(&r.cams_from_rig[1]);
    expected = times(&r.cams_from_rig[4], &back);
    assert_same(&expected, &r.joined[4], TOL_ENTRY, TOL_LENGTH);
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
            const rigcal_transform twist =
                turned_about(axis, i ? -angle : angle);
            const double weight = i ? 10 : 10 * heavy;
            rigcal_view_pose *view;

            add_view(&r, 0, i, weight);
            view = add_view(&r, 1, i, weight);
            view->cam_from_target = times(&twist, &view->cam_from_target);
        }
        ASSERT_STATUS(RIGCAL_OK, join(&r));
        turn = turned_about(axis, off);
        expected = times(&turn, &r.cams_from_rig[1]);
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
    const rigcal_transform twist = turned_about(axis, angle);
    test_rng rng = test_seed(89);
    double R[9], R_true[9];
    rigcal_view_pose *view;
    rig r;

    new_rig(&r, &rng, 2);
    add_view(&r, 0, 0, 1);
    view = add_view(&r, 1, 0, 1000);
    view->cam_from_target = times(&twist, &view->cam_from_target);
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
    rigcal_transform twist = turned_about(axis, angle);
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
    bad->cam_from_target = times(&twist, &bad->cam_from_target);
    ASSERT_STATUS(RIGCAL_OK, join(&r));
    assert_joined(&r, 1);
    test_transform_parts(R, NULL, &r.joined[2]);
    test_transform_parts(R_true, NULL, &r.cams_from_rig[2]);
    TEST_ASSERT_TRUE(test_angle_between(R, R_true) < angle / 10);
}

static void test_poses_that_contradict_each_other_have_no_mean(void)
{
    static const double axis[3] = {1, 0, 0};
    const rigcal_transform half = turned_about(axis, TEST_PI);
    test_rng rng = test_seed(83);
    rigcal_view_pose *view;
    rig r;

    new_rig(&r, &rng, 2);
    for (int i = 0; i < 2; i++) {
        add_view(&r, 0, i, 8);
        view = add_view(&r, 1, i, 8);
        if (i == 1) {
            view->cam_from_target = times(&half, &view->cam_from_target);
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
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rig_join(NULL, r.group, 2, r.views, 6,
                                                   r.work, r.weight));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rig_join(r.joined, NULL, 2, r.views,
                                                   6, r.work, r.weight));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rig_join(r.joined, r.group, 2, NULL,
                                                   6, r.work, r.weight));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rig_join(r.joined, r.group, 2,
                                                   r.views, 6, NULL, r.weight));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rig_join(r.joined, r.group, 2,
                                                   r.views, 6, r.work, NULL));
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
    return rigcal_rig_place(out, placement, in_group, r->joined, r->group,
                            r->n_cameras, r->views, r->n_views, r->work,
                            r->weight);
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
        assert_same(&r.rig_from_target[i], &seen, TOL_ENTRY, TOL_LENGTH);
        ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, seen, place(&seen, &r, i, 1));
    }
    for (int32_t i = 6; i < 9; i++) { /* in the frame of camera 3 */
        ASSERT_STATUS(RIGCAL_OK, place(&seen, &r, i, 1));
        expected = times(&r.cams_from_rig[3], &r.rig_from_target[i]);
        assert_same(&expected, &seen, TOL_ENTRY, TOL_LENGTH);
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
    ASSERT_REFUSED(RIGCAL_ERR_NULL, seen,
                   rigcal_rig_place(&seen, 0, 0, NULL, r.group, 2, r.views, 2,
                                    r.work, r.weight));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, seen,
                   rigcal_rig_place(&seen, 0, 0, r.joined, NULL, 2, r.views, 2,
                                    r.work, r.weight));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, seen,
                   rigcal_rig_place(&seen, 0, 0, r.joined, r.group, 2, NULL, 2,
                                    r.work, r.weight));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, seen,
                   rigcal_rig_place(&seen, 0, 0, r.joined, r.group, 2, r.views,
                                    2, NULL, r.weight));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, seen,
                   rigcal_rig_place(&seen, 0, 0, r.joined, r.group, 2, r.views,
                                    2, r.work, NULL));
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

/* ---- Section VI-C -------------------------------------------------------- */

static void test_the_bound_is_the_oracles_with_the_spectral_norm(void)
{
    for (int i = 0; i < TRANSFORM_BOUND_ROWS; i++) {
        const double *v = TRANSFORM_BOUND[i];
        const rigcal_transform used = from_ypr(v, v + 3);
        const rigcal_transform truth = from_ypr(v + 6, v + 9);
        rigcal_real X[3], bound;

        test_to_real(X, v + 12, 3);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_point_bound(&bound, &used, &truth, X));
        ASSERT_NEAR(v[15], bound, TOL(1e-13, 2e-5));
    }
}

static void test_no_point_is_farther_off_than_the_bound(void)
{
    test_rng rng = test_seed(88);

    for (int i = 0; i < 200; i++) {
        const rigcal_transform used = random_transform(&rng);
        const rigcal_transform truth = random_transform(&rng);
        double R[9], t[3], X[3], Y[3], Y_true[3], off[3];
        rigcal_real X_a[3], bound;

        for (int k = 0; k < 3; k++) {
            X[k] = test_uniform(&rng, -5, 5);
        }
        test_transform_parts(R, t, &used);
        test_apply(Y, R, X, t);
        test_transform_parts(R, t, &truth);
        test_apply(Y_true, R, X, t);
        for (int k = 0; k < 3; k++) {
            off[k] = Y[k] - Y_true[k];
        }
        test_to_real(X_a, X, 3);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_point_bound(&bound, &used, &truth, X_a));
        TEST_ASSERT_TRUE(test_norm(off) <= D(bound) * (1 + TOL(1e-14, 1e-6)));
    }
}

/* A point across the axis of the error, the shift in the direction it moves: 60
 * degrees move it by its own distance, 10, and the shift adds 3. */
static void test_the_bound_is_reached_on_paper(void)
{
    static const double axis[3] = {0, 0, 1};
    const rigcal_transform truth = NOTHING;
    const rigcal_real X[3] = {10, 0, 0};
    rigcal_transform used = turned_about(axis, TEST_PI / 3);
    rigcal_real bound;

    used.t[0] = RC(-1.5);
    used.t[1] = RC(3 * sqrt(0.75));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_point_bound(&bound, &used, &truth, X));
    ASSERT_NEAR(13, bound, TOL(1e-14, 5e-6));
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_bound(&bound, &used, &used, X));
    ASSERT_NEAR(0, bound, TOL(1e-14, 1e-5));
}

static void test_arguments_of_the_bound_are_checked(void)
{
    const rigcal_real X[3] = {1, 2, 3};
    rigcal_real bound;

    ASSERT_STATUS(RIGCAL_ERR_NULL,
                  rigcal_point_bound(NULL, &NOTHING, &NOTHING, X));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, bound,
                   rigcal_point_bound(&bound, NULL, &NOTHING, X));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, bound,
                   rigcal_point_bound(&bound, &NOTHING, NULL, X));
    ASSERT_REFUSED(RIGCAL_ERR_NULL, bound,
                   rigcal_point_bound(&bound, &NOTHING, &NOTHING, NULL));
    for (int k = 0; k < 3; k++) {
        rigcal_transform bad = NOTHING;
        rigcal_real odd[3] = {1, 2, 3};

        odd[k] = TEST_NAN;
        ASSERT_REFUSED(
            RIGCAL_ERR_NOT_FINITE, bound,
            rigcal_point_bound(&bound, &NOTHING, &NOTHING, odd));
        odd[k] = RC(TOL(2e30, 2e9));
        ASSERT_REFUSED(
            RIGCAL_ERR_RANGE, bound,
            rigcal_point_bound(&bound, &NOTHING, &NOTHING, odd));
        bad.t[k] = TEST_INF;
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, bound,
                       rigcal_point_bound(&bound, &bad, &NOTHING, X));
        ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, bound,
                       rigcal_point_bound(&bound, &NOTHING, &bad, X));
        bad = NOTHING;
        bad.R[4 * k] = -1;
        ASSERT_REFUSED(RIGCAL_ERR_ROTATION, bound,
                       rigcal_point_bound(&bound, &bad, &NOTHING, X));
        ASSERT_REFUSED(RIGCAL_ERR_ROTATION, bound,
                       rigcal_point_bound(&bound, &NOTHING, &bad, X));
    }
}

TEST_MAIN()
{
    RUN_TEST(test_the_mean_is_scipys_karcher_mean);
    RUN_TEST(test_the_mean_of_one_is_that_one);
    RUN_TEST(test_deviations_that_balance_leave_the_middle);
    RUN_TEST(test_angles_are_averaged_and_not_entries);
    RUN_TEST(test_a_weight_counts_as_so_many_repetitions);
    RUN_TEST(test_the_mean_turns_with_its_frame);
    RUN_TEST(test_rotations_that_cancel_have_no_mean);
    RUN_TEST(test_arguments_of_the_mean_are_checked);
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
    RUN_TEST(test_the_bound_is_the_oracles_with_the_spectral_norm);
    RUN_TEST(test_no_point_is_farther_off_than_the_bound);
    RUN_TEST(test_the_bound_is_reached_on_paper);
    RUN_TEST(test_arguments_of_the_bound_are_checked);
}
