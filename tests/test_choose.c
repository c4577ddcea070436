/* choose: claims about one transform, and the claim that the others support. The truth is
 * made with NumPy, and with distances by hand. */
#include <math.h>
#include <string.h>

#include "rc_choose.h"
#include "test_fit.h"
#include "vectors_choice.h"

static rigcal_view_pose pose_of(const double v[31])
{
    static const int ROW[21] = {0, 0, 0, 1, 1, 2, 0, 0, 0, 1, 1,
                                1, 2, 2, 2, 3, 3, 3, 4, 4, 5};
    static const int COLUMN[21] = {0, 1, 2, 1, 2, 2, 3, 4, 5, 3, 4,
                                   5, 3, 4, 5, 3, 4, 5, 4, 5, 5};
    rigcal_view_pose pose;

    memset(&pose, 0, sizeof pose);
    pose.camera = (int32_t)v[0];
    pose.placement = (int32_t)v[1];
    pose.cam_from_target = test_from_ypr(&v[3], &v[6]);
    for (int k = 0; k < 21; k++) { /* from the upper triangle row by row */
        const int i = ROW[k], j = COLUMN[k];

        pose.information[k] = RC(v[9 + i * 6 - i * (i - 1) / 2 + j - i]);
    }
    pose.sse = RC(v[30]);
    pose.n = 4;
    return pose;
}

static rigcal_view_pose golden(int camera, int placement, int candidate)
{
    for (int i = 0; i < CHOICE_POSE_ROWS; i++) {
        const double *const v = CHOICE_POSE[i];

        if ((int)v[0] == camera && (int)v[1] == placement && (int)v[2] == candidate) {
            return pose_of(v);
        }
    }
    TEST_FAIL_MESSAGE("no such pose");
    return pose_of(CHOICE_POSE[0]);
}

/* The claim about camera 1 from camera 0 by one placement. */
static rc_claim hypothesis(int placement, int number)
{
    const rigcal_view_pose a = golden(0, placement, number / 2);
    const rigcal_view_pose b = golden(1, placement, number % 2);
    rc_claim of_a, of_b, between;

    TEST_ASSERT_TRUE(rc_claim_of_view(&of_a, &a, a.sse, 0, 0));
    TEST_ASSERT_TRUE(rc_claim_of_view(&of_b, &b, b.sse, 0, 0));
    rc_claim_between(&between, &of_b, &of_a);
    return between;
}

static void test_distances_are_those_of_the_golden_vectors(void)
{
    for (int i = 0; i < CHOICE_APART_ROWS; i++) {
        const double *const v = CHOICE_APART[i];
        const rc_claim p = hypothesis((int)v[0], (int)v[1]);
        const rc_claim q = hypothesis((int)v[2], (int)v[3]);

        ASSERT_NEAR(v[4], rc_claims_apart(&p, &q), TOL(1e-9, 1e-3) * v[4]);
    }
}

static rc_claim claim_at(const double d[6], const double sd[6], int view, int candidate)
{
    static const int DIAGONAL[6] = {0, 3, 5, 15, 18, 20};
    static const double NONE[3] = {0, 0, 0};
    rc_claim claim;
    double turn[9];

    memset(&claim, 0, sizeof claim);
    test_rotation_about(turn, d, test_norm(d));
    claim.b_from_a = test_transform(turn, test_norm(d) > 0 ? &d[3] : NONE);
    if (!(test_norm(d) > 0)) {
        claim.b_from_a =
            test_transform((const double[9]){1, 0, 0, 0, 1, 0, 0, 0, 1}, &d[3]);
    }
    for (int k = 0; k < 6; k++) {
        claim.Sigma[DIAGONAL[k]] = RC(sd[k] * sd[k]);
    }
    claim.view = (rigcal_real)view;
    claim.candidate = (rigcal_real)candidate;
    return claim;
}

/* Each error is divided by its own standard deviation, and the variances of both claims are
 * added. */
static void test_distance_of_independent_errors(void)
{
    static const double origin[6] = {0, 0, 0, 1, 2, 3};
    static const double sd[6] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6},
                        other[6] = {1, 1, 1, 1, 1, 1};

    for (int k = 0; k < 6; k++) {
        double moved[6] = {0, 0, 0, 1, 2, 3};
        rc_claim p, q;

        moved[k] += 0.25;
        p = claim_at(origin, sd, 0, 0);
        q = claim_at(moved, other, 1, 0);
        ASSERT_NEAR(0.0625 / (1 + sd[k] * sd[k]), rc_claims_apart(&p, &q),
                    TOL(1e-12, 1e-6));
        ASSERT_NEAR(0.0625 / (1 + sd[k] * sd[k]), rc_claims_apart(&q, &p),
                    TOL(1e-12, 1e-6));
    }
}

/* A claim that knows one point exactly, but not its turn, says little far from that point:
 * at a lever of 10 a turn of 0.1 is a shift of 1. */
static void test_a_lever_makes_a_turn_a_shift(void)
{
    static const double origin[6] = {0, 0, 0, 0, 0, 0};
    static const double sd[6] = {0.1, 0.1, 0.1, 0.01, 0.01, 0.01};
    static const double shifted[6] = {0, 0, 0, 0, 0.5, 0};
    rc_claim p = claim_at(origin, sd, 0, 0), q = claim_at(shifted, sd, 1, 0);

    ASSERT_NEAR(0.25 / 2e-4, rc_claims_apart(&p, &q), TOL(1e-8, 1e-2));
    q.pivot[0] = 10; /* d = (0, dy) at p; for q cov(wz, dy) = -10 wz^2 there */
    {
        /* by hand: S = (2 w^2, -10 w^2; -10 w^2, 2 s^2 + 100 w^2), d = (0, 0.5) */
        const double ww = 0.01, ss = 1e-4,
                     det = 2 * ww * (2 * ss + 100 * ww) - 100 * ww * ww;

        ASSERT_NEAR(0.25 * 2 * ww / det, rc_claims_apart(&p, &q), TOL(1e-10, 1e-4));
    }
}

/* All of a covariance that is held as its blocks by w, across and by dt. */
static void unpacked(double out[36], const rigcal_real packed[21])
{
    static const int AT[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};

    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++) {
            const int at = i % 3 * 3 + j % 3;
            out[6 * i + j] = D(i < 3 && j < 3     ? packed[AT[at]]
                               : i >= 3 && j >= 3 ? packed[15 + AT[at]]
                               : i < 3            ? packed[6 + at]
                                                  : packed[6 + j % 3 * 3 + i % 3]);
        }
    }
}

/* With covariance 0 the pose of a camera counts as exact. */
static void test_a_placement_from_a_view(void)
{
    test_rng rng = test_seed(511);

    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        const rigcal_view_pose pose = golden(trial % 3, trial % 2 * 2, 0);
        const rigcal_transform C = test_random_transform(&rng);
        const rigcal_transform back = test_inverse(&C);
        const rigcal_transform expected = test_times(&back, &pose.cam_from_target);
        rc_claim view, camera, placed, alone;

        memset(&camera, 0, sizeof camera);
        camera.b_from_a = C;
        TEST_ASSERT_TRUE(rc_claim_of_view(&view, &pose, 0, 7, 1));
        rc_claim_place(&placed, &view, &camera, 1);
        rc_claim_place(&alone, &view, &camera, 0);
        ASSERT_TRANSFORM(&expected, &placed.b_from_a, TOL(1e-12, 1e-5), TOL(1e-11, 1e-4));
        ASSERT_NEAR(7, placed.view, 0);
        ASSERT_NEAR(1, placed.candidate, 0);
        ASSERT_NEAR(D(pose.sse), placed.extra, 0);
        for (int k = 0; k < 21; k++) {
            ASSERT_NEAR(D(alone.Sigma[k]), placed.Sigma[k], TOL(1e-15, 1e-7));
        }
        /* the traces of both blocks are the same in all axes */
        ASSERT_NEAR(D(view.Sigma[0] + view.Sigma[3] + view.Sigma[5]),
                    placed.Sigma[0] + placed.Sigma[3] + placed.Sigma[5], TOL(1e-12, 1e-6));
        ASSERT_NEAR(D(view.Sigma[15] + view.Sigma[18] + view.Sigma[20]),
                    placed.Sigma[15] + placed.Sigma[18] + placed.Sigma[20],
                    TOL(1e-12, 1e-6));
    }
}

/* The covariance of a placement by a view and a camera that is known with an error too:
 * with l = R (pivot - t), a turn w of the camera moves the target by l x w in its frame.
 * The sum is then turned into the rig's frame. All by matrices of 6 x 6. */
static void test_a_placement_has_the_errors_of_view_and_camera(void)
{
    test_rng rng = test_seed(512);

    for (int trial = 0; trial < TEST_TRIALS(40); trial++) {
        const rigcal_view_pose pose = golden(trial % 3, trial % 2 * 2, 0);
        double J[36] = {0}, B[36] = {0}, S[36], V[36], sum[36] = {0}, placed_S[36];
        double R[9], t[3], R_p[9], t_p[3], l[3], arm[3];
        rc_claim view, camera, placed, of_camera;

        TEST_ASSERT_TRUE(rc_claim_of_view(&view, &pose, 0, 7, 1));
        TEST_ASSERT_TRUE(rc_claim_of_view(&of_camera, &pose, 0, 7, 1));
        camera = of_camera;
        camera.b_from_a = test_random_transform(&rng);
        for (int k = 0; k < 3; k++) {
            camera.pivot[k] = RC(test_uniform(&rng, -2, 2));
        }
        rc_claim_place(&placed, &view, &camera, 1);
        test_transform_parts(R, t, &camera.b_from_a);
        test_transform_parts(R_p, t_p, &placed.b_from_a);
        for (int k = 0; k < 3; k++) {
            arm[k] = D(camera.pivot[k]) - t_p[k];
        }
        test_apply(l, R, arm, NULL);
        unpacked(S, camera.Sigma);
        unpacked(V, view.Sigma);
        for (int k = 0; k < 6; k++) {
            J[7 * k] = 1;
            for (int j = 0; j < 3; j++) {
                B[6 * k + 3 * (k / 3) + j] = R[3 * (k % 3) + j];
            }
        }
        J[19] = -l[2]; /* [l]x in rows 3 to 5 */
        J[20] = l[1];
        J[24] = l[2];
        J[26] = -l[0];
        J[30] = -l[1];
        J[31] = l[0];
        for (int k = 0; k < 36; k++) {
            for (int m = 0; m < 36; m++) {
                sum[k] += J[k / 6 * 6 + m / 6] * S[m] * J[k % 6 * 6 + m % 6];
            }
            sum[k] += V[k];
        }
        unpacked(placed_S, placed.Sigma);
        for (int k = 0; k < 36; k++) {
            double exact = 0, size = 0;

            for (int m = 0; m < 36; m++) {
                exact += B[m / 6 * 6 + k / 6] * sum[m] * B[m % 6 * 6 + k % 6];
                size = fmax(size, fabs(sum[m]));
            }
            ASSERT_NEAR(exact, RC(placed_S[k]), TOL(1e-11, 1e-4) * size);
        }
        rc_claim_of_view(&view, &pose, pose.sse + 1, 7, 1); /* it fits better: no extra */
        ASSERT_NEAR(0, view.extra, 0);
    }
}

/* Views 0 and 2 have one claim each. View 1 has two, of which the second agrees. */
static void test_the_others_choose(void)
{
    static const double here[6] = {0, 0, 0, 0, 0, 5}, there[6] = {0.5, 0, 0, 0, 0, 5};
    static const double near[6] = {0.01, 0, 0, 0.01, 0, 5};
    static const double sd[6] = {0.02, 0.02, 0.02, 0.02, 0.02, 0.02};
    rc_claim claims[5];
    rc_support support;
    uint8_t takes[4] = {9, 9, 9, 9};

    claims[0] = claim_at(here, sd, 0, 0);
    claims[1] = claim_at(there, sd, 1, 0);
    claims[2] = claim_at(near, sd, 1, 1);
    claims[2].extra = RC(0.5);
    claims[3] = claim_at(here, sd, 2, 0);
    claims[4] = claim_at(there, sd, 3, 0);
    TEST_ASSERT_NOT_EQUAL(1, rc_choose_place(&support, takes, claims, 4, 30));
    TEST_ASSERT_EQUAL_INT32(3, support.agree);
    TEST_ASSERT_EQUAL_INT32(3, support.n);
    TEST_ASSERT_EQUAL_UINT8(0, takes[0]);
    TEST_ASSERT_EQUAL_UINT8(1, takes[1]);
    TEST_ASSERT_EQUAL_UINT8(0, takes[2]);
    TEST_ASSERT_EQUAL_UINT8(9, takes[3]);
    /* its cost: the distance of view 1, plus what it fits worse */
    rc_choose_support(&support, takes, claims, 4, 0, 30);
    ASSERT_NEAR(D(rc_claims_apart(&claims[0], &claims[2])) + 0.5, support.cost,
                TOL(1e-12, 1e-6));
    /* view 3 has no support, and costs the limit */
    rc_choose_support(&support, takes, claims, 5, 0, 30);
    TEST_ASSERT_EQUAL_UINT8(2, takes[3]);
    TEST_ASSERT_EQUAL_INT32(3, support.agree);
    TEST_ASSERT_EQUAL_INT32(4, support.n);
    ASSERT_NEAR(D(rc_claims_apart(&claims[0], &claims[2])) + 30.5, support.cost,
                TOL(1e-12, 1e-5));
    /* view 3 supports the first claim of view 1, which loses to the two other claims */
    rc_choose_support(&support, takes, claims, 5, 1, 30);
    TEST_ASSERT_EQUAL_INT32(2, support.agree);
    TEST_ASSERT_EQUAL_UINT8(0, takes[1]);
}

/* Both poses of view 0 are close to each other, and the first fits better. The claim by the
 * second pose still takes the second. */
static void test_a_claim_takes_its_own_pose(void)
{
    static const double here[6] = {0, 0, 0, 0, 0, 5}, near[6] = {0.001, 0, 0, 0, 0, 5};
    static const double sd[6] = {0.02, 0.02, 0.02, 0.02, 0.02, 0.02};
    rc_claim claims[2];
    rc_support support;
    uint8_t takes[1];

    claims[0] = claim_at(here, sd, 0, 0);
    claims[1] = claim_at(near, sd, 0, 1);
    claims[1].extra = 1;
    rc_choose_support(&support, takes, claims, 2, 1, 30);
    TEST_ASSERT_EQUAL_UINT8(1, takes[0]);
    ASSERT_NEAR(1, support.cost, 0);
    TEST_ASSERT_EQUAL_INT32(1, support.n);
}

static void test_two_views_cost_what_both_do(void)
{
    static const double here[6] = {0, 0, 0, 0, 0, 5};
    static const double sd[6] = {0.02, 0.02, 0.02, 0.02, 0.02, 0.02};
    rc_claim a = claim_at(here, sd, 0, 0), b = claim_at(here, sd, 1, 0), between;

    a.extra = 2;
    b.extra = 3;
    rc_claim_between(&between, &b, &a);
    ASSERT_NEAR(5, between.extra, 0);
}

/* Of two claims that disagree, the one with less variance wins, in either order. */
static void test_ties_go_to_the_surer(void)
{
    static const double here[6] = {0, 0, 0, 0, 0, 5}, there[6] = {0.5, 0, 0, 0, 0, 5};
    static const double sure[6] = {0.01, 0.01, 0.01, 0.1, 0.1, 0.1};
    static const double less[6] = {0.02, 0.01, 0.01, 0.1, 0.1, 0.1};

    for (int swap = 0; swap < 2; swap++) {
        rc_claim claims[2];
        rc_support support;
        uint8_t takes[2];

        claims[swap] = claim_at(here, sure, swap, 0);
        claims[1 - swap] = claim_at(there, less, 1 - swap, 0);
        TEST_ASSERT_EQUAL(swap, rc_choose_place(&support, takes, claims, 2, 30));
        TEST_ASSERT_EQUAL_UINT8(0, takes[swap]);
        TEST_ASSERT_EQUAL_UINT8(2, takes[1 - swap]);
    }
}

/* A cost below the limit is support, the limit itself is none. Of two poses of a view that
 * cost the same the first is taken. */
static void test_what_costs_the_limit_is_no_support(void)
{
    static const double here[6] = {0, 0, 0, 0, 0, 5};
    static const double sd[6] = {0.02, 0.02, 0.02, 0.02, 0.02, 0.02};
    rc_claim claims[3];
    rc_support support;
    uint8_t takes[2];

    for (int below = 0; below < 2; below++) {
        claims[0] = claim_at(here, sd, 0, 0);
        claims[1] = claim_at(here, sd, 1, 0);
        claims[2] = claim_at(here, sd, 1, 1);
        claims[1].extra = claims[2].extra = RC(30 - below);
        rc_choose_support(&support, takes, claims, 3, 0, 30);
        TEST_ASSERT_EQUAL_INT32(1 + below, support.agree);
        TEST_ASSERT_EQUAL_INT32(2, support.n);
        TEST_ASSERT_EQUAL_UINT8(0, takes[0]);
        TEST_ASSERT_EQUAL_UINT8(below ? 0 : 2, takes[1]);
        ASSERT_NEAR(30 - below, support.cost, 0);
        ASSERT_NEAR(3 * 0.0004, support.spread, TOL(1e-15, 1e-9));
    }
}

/* Whichever claim it is, first or last: three views agree, the others with none. */
static void test_the_best_claim_is_sought_among_all(void)
{
    static const double sure[6] = {0.01, 0.01, 0.01, 0.01, 0.01, 0.01};
    static const double less[6] = {0.02, 0.02, 0.02, 0.02, 0.02, 0.02};

    for (int best = 0; best < 6; best++) {
        rc_claim claims[6];
        rc_support support;
        uint8_t takes[6];

        for (int i = 0; i < 6; i++) {
            const int agrees = i == best || i == (best + 2) % 6 || i == (best + 3) % 6;
            const double at[6] = {agrees ? 0 : 0.3 * i + 0.2, 0, 0, 0, 0, 5};
            claims[i] = claim_at(at, i == best ? sure : less, i, 0);
        }
        TEST_ASSERT_EQUAL(best, rc_choose_place(&support, takes, claims, 6, 30));
        TEST_ASSERT_EQUAL_INT32(3, support.agree);
        for (int i = 0; i < 6; i++) {
            const int agrees = i == best || i == (best + 2) % 6 || i == (best + 3) % 6;
            TEST_ASSERT_EQUAL_UINT8(agrees ? 0 : 2, takes[i]);
        }
    }
}

/* By how many agree; then by the cost; then by the spread. */
static void test_more_support_is_better_then_less_cost_then_less_spread(void)
{
    for (int k = 0; k < 27; k++) {
        const int agree = k % 3 - 1, cost = k / 3 % 3 - 1, spread = k / 9 - 1;
        const rc_support a = {RC(10 + cost), RC(5 + spread), 4 + agree, 7};
        const rc_support b = {10, 5, 4, 7};
        const int order = agree ? agree : cost ? -cost : -spread;

        TEST_ASSERT_EQUAL_INT(order > 0, rc_choose_is_better(&a, &b));
        TEST_ASSERT_EQUAL_INT(order < 0, rc_choose_is_better(&b, &a));
    }
}

static void test_no_information_is_no_claim(void)
{
    rigcal_view_pose pose = golden(0, 0, 0);
    rc_claim claim;

    memset(&pose.information[15], 0, 6 * sizeof pose.information[0]);
    TEST_ASSERT_FALSE(rc_claim_of_view(&claim, &pose, 0, 0, 0));
}

TEST_MAIN()
{
    RUN_TEST(test_distances_are_those_of_the_golden_vectors);
    RUN_TEST(test_distance_of_independent_errors);
    RUN_TEST(test_a_lever_makes_a_turn_a_shift);
    RUN_TEST(test_a_placement_from_a_view);
    RUN_TEST(test_a_placement_has_the_errors_of_view_and_camera);
    RUN_TEST(test_the_others_choose);
    RUN_TEST(test_a_claim_takes_its_own_pose);
    RUN_TEST(test_two_views_cost_what_both_do);
    RUN_TEST(test_ties_go_to_the_surer);
    RUN_TEST(test_no_information_is_no_claim);
    RUN_TEST(test_what_costs_the_limit_is_no_support);
    RUN_TEST(test_the_best_claim_is_sought_among_all);
    RUN_TEST(test_more_support_is_better_then_less_cost_then_less_spread);
}
