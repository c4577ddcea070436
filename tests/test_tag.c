/* tag: corners as a camera sees them in known poses, and corners that no upright tag can
 * have that is seen from the front. */
#include <math.h>
#include <string.h>

#include "test_support.h"

#define DEGREE (TEST_PI / 180)

/* Top left, top right, bottom right, bottom left: x to the right, y up. */
static const double CORNER[4][2] = {{-0.5, 0.5}, {0.5, 0.5}, {0.5, -0.5}, {-0.5, -0.5}};

typedef struct {
    rigcal_camera camera;
    double R[9], t[3], size;
    rigcal_real uv[8];
} sight;

/* A tag of `size` anywhere in the image. Its front faces the camera to within `tilt` of the
 * line of sight. */
static void random_sight(sight *s, test_rng *rng, double size, double tilt)
{
    /* axes of a tag that is read upright; the camera's y is down and its z forward */
    static const double UPRIGHT[9] = {1, 0, 0, 0, -1, 0, 0, 0, -1};
    const double way = test_uniform(rng, -TEST_PI, TEST_PI);
    const double axis[3] = {cos(way), sin(way), 0};
    double spin[9], lean[9], both[9];

    s->camera = test_pinhole();
    s->size = size;
    s->t[2] = size * test_uniform(rng, 3, 10);
    s->t[0] = s->t[2] * test_uniform(rng, -0.15, 0.15);
    s->t[1] = s->t[2] * test_uniform(rng, -0.15, 0.15);
    test_rotation(spin, test_uniform(rng, -TEST_PI, TEST_PI), 0, 0);
    test_rotation_about(lean, axis, test_uniform(rng, 0.1, tilt));
    test_product(both, UPRIGHT, spin);
    test_product(s->R, lean, both);
    for (int i = 0; i < 4; i++) {
        const double X[3] = {size * CORNER[i][0], size * CORNER[i][1], 0};
        double X_c[3], uv[2];

        test_apply(X_c, s->R, X, s->t);
        test_project_px(uv, &s->camera, X_c);
        test_to_real(s->uv + 2 * i, uv, 2);
    }
}

static rigcal_status solve(rigcal_pose poses[RIGCAL_POSES_MAX], size_t *n, const sight *s,
                           const rigcal_pose_options *options)
{
    return rigcal_tag_solve(poses, RIGCAL_POSES_MAX, n, NULL, &s->camera, s->uv,
                            RC(s->size), options);
}

static void test_the_pose_of_a_tag_in_the_unit_of_its_size(void)
{
    test_rng rng = test_seed(1);

    for (int trial = 0; trial < TEST_TRIALS(2000); trial++) {
        const double size = trial % 2 ? 0.08 : 80; /* metres, millimetres */
        rigcal_pose poses[RIGCAL_POSES_MAX];
        size_t n;
        double R[9], t[3];
        sight s;

        random_sight(&s, &rng, size, 55 * DEGREE);
        TEST_ASSERT_TRUE(solve(poses, &n, &s, NULL) >= 0);
        test_transform_parts(R, t, &poses[0].cam_from_world);
        ASSERT_NEAR(0, test_angle_between(R, s.R), TOL(1e-7, 2e-2));
        for (int k = 0; k < 3; k++) {
            ASSERT_NEAR(s.t[k], t[k], TOL(1e-8, 3e-3) * test_norm(s.t));
        }
        for (size_t i = 0; i < n; i++) { /* each pose must see the front */
            test_transform_parts(R, t, &poses[i].cam_from_world);
            TEST_ASSERT_TRUE(R[2] * t[0] + R[5] * t[1] + R[8] * t[2] < 0);
        }
    }
}

static void test_it_is_solve_pose_of_these_four_points(void)
{
    test_rng rng = test_seed(2);
    int both = 0;

    for (int trial = 0; trial < TEST_TRIALS(300); trial++) {
        rigcal_pose poses[RIGCAL_POSES_MAX], same[RIGCAL_POSES_MAX];
        rigcal_observation o[4];
        size_t n, n_same;
        sight s;

        random_sight(&s, &rng, 1, 50 * DEGREE);
        for (int i = 0; i < 4; i++) {
            const double X[3] = {CORNER[i][0], CORNER[i][1], 0};

            test_to_real(o[i].X_w, X, 3);
            for (int k = 0; k < 2; k++) {
                s.uv[2 * i + k] += RC(0.5 * test_normal(&rng));
                o[i].uv[k] = s.uv[2 * i + k];
            }
        }
        memset(poses, 0, sizeof poses);
        memset(same, 0, sizeof same);
        ASSERT_STATUS(rigcal_pose_solve(same, RIGCAL_POSES_MAX, &n_same, NULL,
                                        &VIEW(&s.camera, o, NULL, 4), NULL),
                      solve(poses, &n, &s, NULL));
        TEST_ASSERT_EQUAL_size_t(n_same, n);
        TEST_ASSERT_EQUAL_MEMORY(same, poses, sizeof same);
        both += n == 2;
    }
    TEST_ASSERT_GREATER_THAN_INT(TEST_TRIALS(150), both);
}

/* The corners in reverse order: as AprilTag's p[0] to p[3], or in a flipped image. */
static void test_corners_the_wrong_way_round_are_mirrored(void)
{
    test_rng rng = test_seed(3);

    for (int trial = 0; trial < TEST_TRIALS(500); trial++) {
        rigcal_pose poses[RIGCAL_POSES_MAX];
        rigcal_real uv[8];
        size_t n;
        int32_t at_fault = 5;
        sight s;

        random_sight(&s, &rng, 1, 55 * DEGREE);
        for (int i = 0; i < 4; i++) {
            const int from = trial % 2 ? 3 - i : i;

            uv[2 * i] = s.uv[2 * from];
            uv[2 * i + 1] = trial % 2 ? s.uv[2 * from + 1] : 480 - s.uv[2 * from + 1];
        }
        ASSERT_REFUSED(RIGCAL_ERR_MIRRORED, poses,
                       rigcal_tag_solve(poses, RIGCAL_POSES_MAX, &n, &at_fault, &s.camera,
                                        uv, 1, NULL));
        TEST_ASSERT_EQUAL_INT32(-1, at_fault);
    }
}

/* If the corners begin at another one, the tag is turned by right angles. */
static void test_another_first_corner_is_a_turned_tag(void)
{
    test_rng rng = test_seed(4);
    rigcal_pose poses[RIGCAL_POSES_MAX];
    rigcal_real uv[8];
    size_t n;
    double quarter[9], expected[9], R[9];
    sight s;

    random_sight(&s, &rng, 1, 40 * DEGREE);
    for (int i = 0; i < 8; i++) {
        uv[i] = s.uv[(i + 2) % 8];
    }
    TEST_ASSERT_TRUE(
        rigcal_tag_solve(poses, RIGCAL_POSES_MAX, &n, NULL, &s.camera, uv, 1, NULL) >= 0);
    test_rotation(quarter, -TEST_PI / 2, 0, 0);
    test_product(expected, s.R, quarter);
    test_transform_parts(R, NULL, &poses[0].cam_from_world);
    ASSERT_NEAR(0, test_angle_between(R, expected), TOL(1e-7, 2e-2));
}

static void test_what_is_no_tag_is_refused_by_name(void)
{
    test_rng rng = test_seed(5);
    rigcal_pose poses[RIGCAL_POSES_MAX];
    rigcal_real one_place[8], line[8];
    int32_t at_fault = 7;
    size_t n;
    sight s;

    random_sight(&s, &rng, 1, 40 * DEGREE);
    for (int i = 0; i < 8; i++) {
        one_place[i] = s.uv[i % 2];
        line[i] = RC(100 + 20 * (i / 2));
    }
    ASSERT_REFUSED(
        RIGCAL_ERR_COINCIDENT, poses,
        rigcal_tag_solve(poses, 1, &n, &at_fault, &s.camera, one_place, 1, NULL));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, poses,
                   rigcal_tag_solve(poses, 1, &n, &at_fault, &s.camera, s.uv, 0, NULL));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, poses,
                   rigcal_tag_solve(poses, 1, &n, &at_fault, &s.camera, s.uv, -1, NULL));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, poses,
                   rigcal_tag_solve(poses, 0, &n, &at_fault, &s.camera, s.uv, 1, NULL));
    TEST_ASSERT_TRUE(rigcal_tag_solve(poses, 1, &n, &at_fault, &s.camera, line, 1, NULL) !=
                     RIGCAL_OK);
}

/* A tag anywhere in a wide image, with its front or its back to the camera. The true pose
 * decides which side is seen; the optical axis does not. */
static void test_the_side_is_that_of_the_line_of_sight(void)
{
    test_rng rng = test_seed(6);
    int front = 0, back = 0;

    for (int trial = 0; trial < TEST_TRIALS(2000); trial++) {
        rigcal_pose poses[RIGCAL_POSES_MAX];
        size_t n = 0;
        double axis[3], turn[9], side, R[9];
        sight s;

        random_sight(&s, &rng, 1, 10 * DEGREE);
        for (int k = 0; k < 2; k++) {
            s.t[k] = s.t[2] * test_uniform(&rng, -1.2, 1.2);
        }
        for (int k = 0; k < 3; k++) {
            axis[k] = test_normal(&rng);
        }
        test_rotation_about(turn, axis, test_uniform(&rng, 0, TEST_PI));
        memcpy(R, s.R, sizeof R);
        test_product(s.R, turn, R);
        side = (s.R[2] * s.t[0] + s.R[5] * s.t[1] + s.R[8] * s.t[2]) / test_norm(s.t);
        if (fabs(side) < 0.2) {
            continue;
        }
        for (int i = 0; i < 4; i++) {
            const double X[3] = {CORNER[i][0], CORNER[i][1], 0};
            double X_c[3], uv[2];

            test_apply(X_c, s.R, X, s.t);
            test_project_px(uv, &s.camera, X_c);
            test_to_real(s.uv + 2 * i, uv, 2);
        }
        const rigcal_status status = solve(poses, &n, &s, NULL);
        if (side > 0) {
            TEST_ASSERT_EQUAL_INT32(RIGCAL_ERR_MIRRORED, status);
            back++;
            continue;
        }
        TEST_ASSERT_TRUE(status >= 0);
        test_transform_parts(R, NULL, &poses[0].cam_from_world);
        ASSERT_NEAR(0, test_angle_between(R, s.R), TOL(1e-6, 5e-2));
        front++;
    }
    TEST_ASSERT_GREATER_THAN_INT(TEST_ONE_IN > 1 ? 0 : 400, front);
    TEST_ASSERT_GREATER_THAN_INT(TEST_ONE_IN > 1 ? 0 : 400, back);
}

/* The sine by which the camera is behind the tag's plane: its centre is at -R^T t, and z
 * points forward. */
static double side_of(const rigcal_transform *cam_from_tag)
{
    double R[9], t[3];

    test_transform_parts(R, t, cam_from_tag);
    return (R[2] * t[0] + R[5] * t[1] + R[8] * t[2]) / test_norm(t);
}

/* Corners that are mostly noise fit poses seen from both sides. Only those seen from the
 * front are returned. */
static void test_of_poses_from_both_sides_those_from_the_front_are_kept(void)
{
    test_rng rng = test_seed(9);
    rigcal_pose_options options;
    int both = 0;

    (void)rigcal_pose_defaults(&options);
    options.sigma_px = 1;
    for (int trial = 0; trial < TEST_TRIALS(12000); trial++) {
        rigcal_pose all[RIGCAL_POSES_MAX], front[RIGCAL_POSES_MAX];
        rigcal_observation o[4];
        size_t n_all = 0, n_front = 0, n = 0;
        sight s;

        s.camera = test_pinhole();
        s.size = 1;
        for (int i = 0; i < 4; i++) {
            o[i].X_w[0] = RC(CORNER[i][0]);
            o[i].X_w[1] = RC(CORNER[i][1]);
            o[i].X_w[2] = 0;
            s.uv[2 * i] = o[i].uv[0] = RC(320 + test_uniform(&rng, -4, 4));
            s.uv[2 * i + 1] = o[i].uv[1] = RC(240 + test_uniform(&rng, -0.2, 0.2));
        }
        if (rigcal_pose_solve(all, RIGCAL_POSES_MAX, &n_all, NULL,
                              &VIEW(&s.camera, o, NULL, 4), &options) < 0 ||
            solve(front, &n_front, &s, &options) < 0) {
            continue;
        }
        for (size_t i = 0; i < n_all; i++) {
            if (side_of(&all[i].cam_from_world) < 0) {
                TEST_ASSERT_TRUE(n < n_front);
                ASSERT_TRANSFORM(&all[i].cam_from_world, &front[n].cam_from_world, 0, 0);
                n++;
            }
        }
        TEST_ASSERT_EQUAL_size_t(n, n_front);
        both += n < n_all;
    }
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || both > 10);
}

/* The likelihood of the best pose from the front, over that of the best of all. *apart gets
 * the difference of their sums of squares. */
static double front_of(double *apart, const sight *s, const rigcal_pose_options *options)
{
    rigcal_pose all[RIGCAL_POSES_MAX];
    rigcal_observation o[4];
    size_t n = 0;
    double likely = 0;

    for (int i = 0; i < 4; i++) {
        o[i].X_w[0] = RC(CORNER[i][0]);
        o[i].X_w[1] = RC(CORNER[i][1]);
        o[i].X_w[2] = 0;
        o[i].uv[0] = s->uv[2 * i];
        o[i].uv[1] = s->uv[2 * i + 1];
    }
    (void)rigcal_pose_solve(all, RIGCAL_POSES_MAX, &n, NULL, &VIEW(&s->camera, o, NULL, 4),
                            options);
    for (size_t i = n; i > 0; i--) {
        if (side_of(&all[i - 1].cam_from_world) < 0) {
            likely = D(all[i - 1].probability) / D(all[0].probability);
            *apart = D(all[i - 1].sse) - D(all[0].sse);
        }
    }
    return likely;
}

/* Corners that are mostly noise, for which a pose from behind fits best. The noise that is
 * stated decides how likely a pose from the front is: a bit more or less than a thousandth
 * of the best. Then it is kept, or not. */
static void test_a_front_that_is_a_thousandth_as_likely_is_kept(void)
{
    test_rng rng = test_seed(11);
    rigcal_pose_options options;
    int count[2] = {0, 0};

    TEST_ON_HOST_ONLY("few of many corners have both poses");
    (void)rigcal_pose_defaults(&options);
    for (int trial = 0; trial < 12000; trial++) {
        rigcal_pose front[RIGCAL_POSES_MAX];
        double apart = 0;
        size_t n;
        sight s;

        s.camera = test_pinhole();
        s.size = 1;
        for (int i = 0; i < 4; i++) {
            s.uv[2 * i] = RC(320 + test_uniform(&rng, -4, 4));
            s.uv[2 * i + 1] = RC(240 + test_uniform(&rng, -0.2, 0.2));
        }
        options.sigma_px = 1;
        const double first = front_of(&apart, &s, &options);
        for (int side = 0; side < 2 && first > 0 && apart > 1e-3; side++) {
            options.sigma_px = RC(sqrt(apart / (2 * log(1 / (side ? 1.5e-3 : 0.7e-3)))));
            const double likely = front_of(&apart, &s, &options);
            count[side] += likely > 5e-4 && likely < 2e-3;
            TEST_ASSERT_EQUAL_INT(likely > 0 && likely <= 1e-3,
                                  likely > 0 && solve(front, &n, &s, &options) ==
                                                    RIGCAL_ERR_MIRRORED);
        }
    }
    TEST_ASSERT_TRUE(count[0] > 2 && count[1] > 2);
}

/* The plane of the tag goes through the camera: it shows neither side, and noise alone
 * would name one. */
static void test_a_tag_seen_edge_on_has_no_front(void)
{
    test_rng rng = test_seed(10);
    int edge_on = 0;

    for (int trial = 0; trial < 300; trial++) {
        rigcal_pose all[RIGCAL_POSES_MAX], front[RIGCAL_POSES_MAX];
        rigcal_observation o[4];
        size_t n_all = 0, n_front = 0;
        double middle[3];
        sight s;

        random_sight(&s, &rng, 1, 40 * DEGREE);
        test_random_rotation(s.R, &rng);
        const double normal[3] = {s.R[2], s.R[5], s.R[8]};
        const double off = test_dot(normal, s.t);
        for (int k = 0; k < 3; k++) {
            middle[k] = s.t[k] - off * normal[k];
        }
        if (middle[2] < 1.5) {
            continue;
        }
        for (int i = 0; i < 4; i++) {
            const double X[3] = {CORNER[i][0], CORNER[i][1], 0};
            double X_c[3], uv[2];

            test_apply(X_c, s.R, X, middle);
            test_project_px(uv, &s.camera, X_c);
            test_to_real(o[i].X_w, X, 3);
            test_to_real(o[i].uv, uv, 2);
            test_to_real(s.uv + 2 * i, uv, 2);
        }
        (void)rigcal_pose_solve(all, RIGCAL_POSES_MAX, &n_all, NULL,
                                &VIEW(&s.camera, o, NULL, 4), NULL);
        for (size_t i = 0; i < n_all; i++) {
            edge_on += fabs(side_of(&all[i].cam_from_world)) < TOL(1e-15, 1e-6);
        }
        (void)solve(front, &n_front, &s, NULL);
        for (size_t i = 0; i < n_front; i++) {
            TEST_ASSERT_TRUE(side_of(&front[i].cam_from_world) < TOL(-1e-12, -1e-6));
        }
    }
    TEST_ASSERT_TRUE(RIGCAL_USE_FLOAT || edge_on > 50);
}

/* In any unit of length: powers of 2 change no digit. */
static void test_the_unit_of_length_does_not_matter(void)
{
    test_rng rng = test_seed(11);

    for (int trial = 0; trial < 20; trial++) {
        const double unit = ldexp(1, trial % 2 ? 25 : -25);
        rigcal_pose one[RIGCAL_POSES_MAX], other[RIGCAL_POSES_MAX];
        size_t n_one, n_other;
        sight s;

        random_sight(&s, &rng, 1, 40 * DEGREE);
        TEST_ASSERT_TRUE(solve(one, &n_one, &s, NULL) >= 0);
        s.size = unit;
        TEST_ASSERT_TRUE(solve(other, &n_other, &s, NULL) >= 0);
        TEST_ASSERT_EQUAL_size_t(n_one, n_other);
        for (size_t i = 0; i < n_one; i++) {
            for (int k = 0; k < 3; k++) {
                other[i].cam_from_world.t[k] /= RC(unit);
            }
            ASSERT_TRANSFORM(&one[i].cam_from_world, &other[i].cam_from_world,
                             TOL(1e-10, 1e-4), TOL(1e-9, 1e-3));
        }
    }
}

static void test_arguments_are_checked(void)
{
    test_rng rng = test_seed(12);
    rigcal_pose poses[RIGCAL_POSES_MAX];
    rigcal_real reversed[8];
    size_t n;
    sight s;

    random_sight(&s, &rng, 1, 40 * DEGREE);
    for (int k = 0; k < 8; k++) {
        reversed[k] = s.uv[6 - k + 2 * (k % 2)];
    }
    for (int bad = 0; bad < 6; bad++) { /* of a tag that would be refused as mirrored */
        int32_t at_fault = 3;
        const rigcal_status status =
            rigcal_tag_solve(bad == 0 ? NULL : poses, 1, bad == 1 ? NULL : &n, &at_fault,
                             bad == 2 ? NULL : &s.camera, bad == 3 ? NULL : reversed,
                             bad == 4   ? TEST_NAN
                             : bad == 5 ? TEST_INF
                                        : 1,
                             NULL);

        ASSERT_STATUS(bad < 4 ? RIGCAL_ERR_NULL : RIGCAL_ERR_NOT_FINITE, status);
        TEST_ASSERT_EQUAL_INT32(-1, at_fault);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_the_pose_of_a_tag_in_the_unit_of_its_size);
    RUN_TEST(test_it_is_solve_pose_of_these_four_points);
    RUN_TEST(test_corners_the_wrong_way_round_are_mirrored);
    RUN_TEST(test_another_first_corner_is_a_turned_tag);
    RUN_TEST(test_what_is_no_tag_is_refused_by_name);
    RUN_TEST(test_the_side_is_that_of_the_line_of_sight);
    RUN_TEST(test_of_poses_from_both_sides_those_from_the_front_are_kept);
    RUN_TEST(test_a_front_that_is_a_thousandth_as_likely_is_kept);
    RUN_TEST(test_a_tag_seen_edge_on_has_no_front);
    RUN_TEST(test_the_unit_of_length_does_not_matter);
    RUN_TEST(test_arguments_are_checked);
}
