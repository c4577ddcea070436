/* points: which points count, what is wrong with them, where they are, and their errors,
 * compared with sums in double precision. */
#include <math.h>
#include <string.h>

#include "rc_points.h"
#include "test_support.h"

enum { N = 6 };

/* A view that owns the arrays it points to. */
typedef struct {
    rigcal_camera camera;
    rigcal_observation o[N];
    rigcal_real sigma[N];
    rigcal_points points;
    rigcal_real uv_middle[2];
    int32_t at_fault;
} problem;

static void random_problem(problem *p, test_rng *rng)
{
    test_scene scene;
    p->camera = test_pinhole();
    test_scene_random(&scene, rng, N, TEST_GENERAL);
    test_observations(p->o, &scene, &p->camera);
    for (int i = 0; i < N; i++) {
        p->sigma[i] = RC(test_uniform(rng, 0.5, 4));
    }
}

static rigcal_status survey(problem *p, int weighted, const uint8_t mask[])
{
    rc_points_of(&p->points, &VIEW(&p->camera, p->o, weighted ? p->sigma : NULL, N), mask);
    p->at_fault = -2;
    return rc_points_survey(&p->points, p->uv_middle, &p->at_fault);
}

/* ---- checks -------------------------------------------------------------------- */

static void test_noise_is_nothing_or_within_a_million_either_way(void)
{
    static const double WRONG[5] = {-1, 0.9e-6, -1e-30, 1.1e6, 1e30};
    static const double RIGHT[4] = {0, 1.1e-6, 1, 0.9e6};
    const rigcal_real nan = TEST_NAN, infinity = TEST_INF;
    for (int i = 0; i < 4; i++) {
        const rigcal_real sigma = RC(RIGHT[i]);
        ASSERT_STATUS(RIGCAL_OK, rc_check_noise(&sigma));
    }
    for (int i = 0; i < 5; i++) {
        const rigcal_real sigma = RC(WRONG[i]);
        ASSERT_STATUS(RIGCAL_ERR_RANGE, rc_check_noise(&sigma));
    }
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rc_check_noise(&nan));
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rc_check_noise(&infinity));
}

static void test_a_view_is_checked_for_its_pointers_and_its_camera(void)
{
    const rigcal_observation o[1] = {{{0, 0, 0}, {0, 0}}};
    rigcal_camera camera = test_pinhole();
    ASSERT_STATUS(RIGCAL_OK, rc_check_view(&VIEW(&camera, o, NULL, 1)));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rc_check_view(NULL));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rc_check_view(&VIEW(NULL, o, NULL, 1)));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rc_check_view(&VIEW(&camera, NULL, NULL, 1)));
    camera.fx = 0;
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rc_check_view(&VIEW(&camera, o, NULL, 1)));
    camera.fx = TEST_NAN;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rc_check_view(&VIEW(&camera, o, NULL, 1)));
}

/* 8 units in the last place of the image's extent, squared, or that number of pixels^2 for
 * an image without one. */
static void test_what_is_negligible_grows_with_the_image_and_the_pixel(void)
{
    const double eps = TOL(2.220446049250313e-16, 1.1920928955078125e-7);
    const double least = TOL(1e-20, 1e-7), digits = TOL(1e-12, 1e-6);
    ASSERT_NEAR(least, rc_negligible(1, 0), least * digits);
    ASSERT_NEAR(least / 16, rc_negligible(RC(0.25), 0), least * digits);
    ASSERT_NEAR(64e12 * eps * eps, rc_negligible(1, RC(1e6)), 64e12 * eps * eps * digits);
    ASSERT_NEAR(64 * eps * eps, rc_negligible(RC(1e-9), 1), 64 * eps * eps * digits);
}

/* ---- which count --------------------------------------------------------------- */

static void test_a_mask_and_the_one_left_out_do_not_count(void)
{
    static const uint8_t MASK[N] = {0, 1, 1, 2, 1, 0};
    static const size_t ALL[N + 1] = {0, 1, 2, 3, 4, 5, 6};
    static const size_t MASKED[N + 1] = {1, 1, 2, 4, 4, 6, 6};
    static const size_t WITHOUT_2[N + 1] = {1, 1, 4, 4, 4, 6, 6};
    static const size_t WITHOUT_0[N + 1] = {1, 1, 2, 3, 4, 5, 6};
    const rigcal_camera camera = test_pinhole();
    const rigcal_observation o[N] = {{{0, 0, 0}, {0, 0}}};
    rigcal_points points;
    for (size_t i = 0; i <= N; i++) {
        rc_points_of(&points, &VIEW(&camera, o, NULL, N), NULL);
        TEST_ASSERT_EQUAL(ALL[i], rc_points_next(&points, i));
        points.left_out = 0;
        TEST_ASSERT_EQUAL(WITHOUT_0[i], rc_points_next(&points, i));
        rc_points_of(&points, &VIEW(&camera, o, NULL, N), MASK);
        TEST_ASSERT_EQUAL(MASKED[i], rc_points_next(&points, i));
        points.left_out = 2;
        TEST_ASSERT_EQUAL(WITHOUT_2[i], rc_points_next(&points, i));
    }
}

/* ---- the survey ---------------------------------------------------------------- */

/* Checks the weighted means of points and pixels, and the longest distance from the first
 * point that counts. */
static void assert_surveyed(const problem *p, const uint8_t mask[], int left_out,
                            int weighted)
{
    double total = 0, X[3] = {0}, uv[2] = {0}, size = 0, extent = 0;
    int first = -1, count = 0;
    for (int i = 0; i < N; i++) {
        const double w = weighted ? 1 / (D(p->sigma[i]) * D(p->sigma[i])) : 1;
        if (i == left_out || (mask && !mask[i])) {
            continue;
        }
        first = first < 0 ? i : first;
        count++;
        total += w;
        for (int k = 0; k < 3; k++) {
            X[k] += w * D(p->o[i].X_w[k]);
            size = fmax(size, fabs(D(p->o[i].X_w[k]) - D(p->o[first].X_w[k])));
        }
        for (int k = 0; k < 2; k++) {
            uv[k] += w * D(p->o[i].uv[k]);
            extent = fmax(extent, fabs(D(p->o[i].uv[k]) - D(p->o[first].uv[k])));
        }
        ASSERT_NEAR(w, rc_points_weight(&p->points, (size_t)i), TOL(1e-14, 1e-5));
    }
    for (int k = 0; k < 3; k++) {
        ASSERT_NEAR(X[k] / total, p->points.origin[k], TOL(1e-14, 1e-6));
    }
    for (int k = 0; k < 2; k++) {
        ASSERT_NEAR(uv[k] / total, p->uv_middle[k], TOL(1e-11, 2e-4));
    }
    TEST_ASSERT_EQUAL(count, p->points.n_used);
    ASSERT_NEAR(size, p->points.size, TOL(1e-15, 1e-6));
    ASSERT_NEAR(extent, p->points.extent_px, TOL(1e-12, 1e-4));
    TEST_ASSERT_EQUAL_INT32(-1, p->at_fault);
}

static void test_a_survey_finds_the_middle_and_the_size(void)
{
    static const uint8_t MASK[N] = {0, 1, 1, 0, 1, 1};
    test_rng rng = test_seed(71);
    for (int trial = 0; trial < 200; trial++) {
        const int weighted = trial % 2;
        problem p;
        random_problem(&p, &rng);
        ASSERT_STATUS(RIGCAL_OK, survey(&p, weighted, NULL));
        assert_surveyed(&p, NULL, -1, weighted);
        ASSERT_STATUS(RIGCAL_OK, survey(&p, weighted, MASK));
        assert_surveyed(&p, MASK, -1, weighted);
        p.points.left_out = 4;
        ASSERT_STATUS(RIGCAL_OK, rc_points_survey(&p.points, p.uv_middle, &p.at_fault));
        assert_surveyed(&p, MASK, 4, weighted);
    }
}

static void test_a_survey_knows_the_camera(void)
{
    test_rng rng = test_seed(72);
    problem p;
    random_problem(&p, &rng);
    ASSERT_STATUS(RIGCAL_OK, survey(&p, 0, NULL));
    TEST_ASSERT_TRUE(p.points.is_pinhole);
    ASSERT_NEAR(1, p.points.pixel_size, 0);
    ASSERT_NEAR(rc_negligible(p.points.pixel_size, p.points.extent_px), p.points.negligible,
                0);
    p.camera.k1 = RC(0.1);
    ASSERT_STATUS(RIGCAL_OK, survey(&p, 0, NULL));
    TEST_ASSERT_FALSE(p.points.is_pinhole);
    p.camera.fx = 1; /* normalised coordinates are not pixels */
    ASSERT_STATUS(RIGCAL_OK, survey(&p, 0, NULL));
    TEST_ASSERT_TRUE(D(p.points.pixel_size) < 0.01);
}

/* For points far from their origin, the coordinates keep all the digits that they have. */
static void test_a_far_world_costs_no_digits(void)
{
    const double far = TOL(1e6, 256);
    test_rng rng = test_seed(73);
    for (int trial = 0; trial < 100; trial++) {
        double near[N][3], mean[3] = {0};
        problem p;
        random_problem(&p, &rng);
        for (int i = 0; i < N; i++) {
            for (int k = 0; k < 3; k++) {
                p.o[i].X_w[k] = RC(far + test_uniform(&rng, -1, 1));
                near[i][k] = D(p.o[i].X_w[k]) - far;
                mean[k] += near[i][k] / N;
            }
        }
        ASSERT_STATUS(RIGCAL_OK, survey(&p, 0, NULL));
        for (int i = 0; i < N; i++) {
            rigcal_real x[3];
            rc_points_at(x, &p.points, (size_t)i);
            for (int k = 0; k < 3; k++) { /* one rounding of the origin */
                ASSERT_NEAR(near[i][k] - mean[k], x[k], far * TOL(3e-16, 1.5e-7));
            }
        }
    }
}

/* ---- what is wrong -------------------------------------------------------------- */

/* Number k of observation i: X, Y, Z, u, v, sigma. */
static rigcal_real *number_of(problem *p, int i, int k)
{
    return k < 3 ? &p->o[i].X_w[k] : k < 5 ? &p->o[i].uv[k - 3] : &p->sigma[i];
}

static void test_a_wrong_number_is_told_with_its_observation(void)
{
    test_rng rng = test_seed(74);
    problem right, p;
    random_problem(&right, &rng);
    for (int i = 0; i < N; i++) {
        for (int k = 0; k < 6; k++) {
            p = right;
            *number_of(&p, i, k) = (i + k) % 2 ? TEST_NAN : TEST_INF;
            ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, survey(&p, 1, NULL));
            TEST_ASSERT_EQUAL_INT32(i, p.at_fault);

            p = right;
            *number_of(&p, i, k) = RC(TOL(1e35, 1e20)); /* its square overflows in float */
            ASSERT_STATUS(RIGCAL_ERR_RANGE, survey(&p, 1, NULL));
            TEST_ASSERT_EQUAL_INT32(i, p.at_fault);
        }
        p = right;
        p.sigma[i] = 0;
        ASSERT_STATUS(RIGCAL_ERR_RANGE, survey(&p, 1, NULL));
        TEST_ASSERT_EQUAL_INT32(i, p.at_fault);
        ASSERT_STATUS(RIGCAL_OK, survey(&p, 0, NULL)); /* not read */
        TEST_ASSERT_EQUAL_INT32(-1, p.at_fault);
    }
}

static void test_of_two_wrong_ones_the_first_that_counts_is_told(void)
{
    uint8_t mask[N] = {1, 1, 1, 1, 1, 1};
    test_rng rng = test_seed(75);
    problem p;
    random_problem(&p, &rng);
    p.o[1].uv[0] = TEST_NAN;
    p.o[4].X_w[2] = TEST_NAN;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, survey(&p, 0, mask));
    TEST_ASSERT_EQUAL_INT32(1, p.at_fault);
    mask[1] = 0;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, survey(&p, 0, mask));
    TEST_ASSERT_EQUAL_INT32(4, p.at_fault);
    mask[4] = 0;
    ASSERT_STATUS(RIGCAL_OK, survey(&p, 0, mask));
    TEST_ASSERT_EQUAL_INT32(-1, p.at_fault);
}

static void test_fewer_than_three_that_count_are_too_few(void)
{
    static const uint8_t TWO[N] = {0, 1, 0, 0, 0, 1}, THREE[N] = {0, 1, 0, 1, 0, 1};
    test_rng rng = test_seed(76);
    problem p;
    random_problem(&p, &rng);
    ASSERT_STATUS(RIGCAL_ERR_TOO_FEW, survey(&p, 0, TWO));
    ASSERT_STATUS(RIGCAL_OK, survey(&p, 0, THREE));
    p.points.left_out = 3;
    ASSERT_STATUS(RIGCAL_ERR_TOO_FEW,
                  rc_points_survey(&p.points, p.uv_middle, &p.at_fault));
    TEST_ASSERT_EQUAL_INT32(-1, p.at_fault);
}

static void test_more_than_can_be_counted_are_refused_unread(void)
{
    const rigcal_camera camera = test_pinhole();
    const rigcal_observation o[1] = {{{0, 0, 0}, {0, 0}}};
    rigcal_points points;
    rigcal_real uv_middle[2];
    int32_t at_fault = -2;
    if (RC_COUNT_MAX == SIZE_MAX) {
        TEST_IGNORE_MESSAGE("this size_t counts no more");
    }
    rc_points_of(&points, &VIEW(&camera, o, NULL, RC_COUNT_MAX + 1), NULL);
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rc_points_survey(&points, uv_middle, &at_fault));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
}

/* The first point is wrong, so no other is read. */
static void test_as_many_as_can_be_counted_are_read(void)
{
    const rigcal_camera camera = test_pinhole();
    const rigcal_observation first = {{0, 0, 1}, {TEST_NAN, 0}};
    rigcal_points points;
    rigcal_real uv_middle[2];
    int32_t at_fault = -2;
    rc_points_of(&points, &VIEW(&camera, &first, NULL, RC_COUNT_MAX), NULL);
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rc_points_survey(&points, uv_middle, &at_fault));
    TEST_ASSERT_EQUAL_INT32(0, at_fault);
}

/* The disc about the axis that a survey proves is that of the pixel farthest from it,
 * whichever of them that is, and on whichever side. */
static void test_the_disc_that_is_proved_holds_every_pixel(void)
{
    static const double AT[4][2] = {{250, 40}, {-250, -90}, {60, 190}, {-30, -190}};
    static const uint8_t MASK[N] = {1, 0, 1, 1, 1, 1};
    test_rng rng = test_seed(81);
    problem p;
    if (!RC_FOR_SPEED) {
        TEST_IGNORE_MESSAGE("nothing is proved in advance");
    }
    random_problem(&p, &rng);
    p.camera.fx = 500;
    p.camera.fy = 400;
    p.camera.cx = 330;
    p.camera.cy = 250;
    p.camera.k1 = RC(0.05);
    for (int far = 0; far < N; far++) {
        for (int way = 0; way < 4; way++) {
            for (int i = 0; i < N; i++) {
                p.o[i].uv[0] = RC(330 + (i == far ? AT[way][0] : 20 - 7 * i));
                p.o[i].uv[1] = RC(250 + (i == far ? AT[way][1] : 9 * i - 15));
            }
            const double reach = hypot(AT[way][0] / 500, AT[way][1] / 400);
            const double disc = D(rc_lens_proved(&p.camera, RC(reach)));
            ASSERT_STATUS(RIGCAL_OK, survey(&p, 0, NULL));
            ASSERT_NEAR(disc, p.points.proved2, TOL(1e-12, 1e-4) * disc);
            TEST_ASSERT_TRUE(D(p.points.proved2) >= reach * reach * 0.9);
            ASSERT_STATUS(RIGCAL_OK, survey(&p, 0, MASK));
            TEST_ASSERT_EQUAL_INT(far == 1, D(p.points.proved2) < 0.9 * disc);
        }
    }
    p.camera.k1 = 0;
    ASSERT_STATUS(RIGCAL_OK, survey(&p, 0, NULL)); /* a pinhole sees all */
    ASSERT_NEAR(0, p.points.proved2, 0);
}

/* Coordinates whose rounding is slightly less, and slightly more, than 1e-4 of the size, in
 * three units of length. */
static void test_points_in_one_place_or_too_far_for_their_size_are_refused(void)
{
    const double limit = 1e-4 / TOL(2.220446049250313e-16, 1.1920928955078125e-7);
    test_rng rng = test_seed(77);
    problem p, moved;
    random_problem(&p, &rng);
    for (int i = 0; i < N; i++) {
        for (int k = 0; k < 3; k++) {
            p.o[i].X_w[k] = RC(i == k ? 1 : 0);
        }
    }
    for (int step = 0; step < 6; step++) {
        const int is_far = step % 2;
        moved = p;
        for (int i = 0; i < N; i++) {
            moved.o[i].X_w[1] += RC(limit * (is_far ? 1.1 : 0.9));
            for (int k = 0; k < 3; k++) {
                moved.o[i].X_w[k] *= RC(ldexp(1, 10 * (step / 2 - 1)));
            }
        }
        ASSERT_STATUS(is_far ? RIGCAL_ERR_PRECISION : RIGCAL_OK, survey(&moved, 0, NULL));
        TEST_ASSERT_EQUAL_INT32(-1, moved.at_fault);
        TEST_ASSERT_EQUAL(N, moved.points.n_used); /* the survey is complete in spite of
                                                      that */
    }
    for (int i = 1; i < N; i++) {
        memcpy(p.o[i].X_w, p.o[0].X_w, sizeof p.o[0].X_w);
    }
    ASSERT_STATUS(RIGCAL_ERR_COINCIDENT, survey(&p, 0, NULL));
    TEST_ASSERT_EQUAL(N, p.points.n_used);
}

/* Coordinates whose rounding is 1e-4 of the size of 1, to the last bit, still do; and so
 * does a size of 1e-30 only just not. */
static void test_the_limits_of_size_and_digits_are_met_exactly(void)
{
    const rigcal_real most =
        RC(1e-4) / RC(TOL(2.220446049250313e-16, 1.1920928955078125e-7));
    const rigcal_real least = 1 / RC_COORDINATE_MAX, more = RC(TOL(1 + 1e-15, 1 + 2e-7));
    test_rng rng = test_seed(83);
    problem p;
    random_problem(&p, &rng);
    for (int step = 0; step < 4; step++) {
        const rigcal_real size = step == 2 ? least : step == 3 ? least * more : 1;
        for (int i = 0; i < N; i++) {
            p.o[i].X_w[0] = step == 0 ? most : step == 1 ? most * more : 0;
            p.o[i].X_w[1] = i == 1 ? size : 0;
            p.o[i].X_w[2] = 0;
        }
        ASSERT_STATUS(step == 1   ? RIGCAL_ERR_PRECISION
                      : step == 2 ? RIGCAL_ERR_COINCIDENT
                                  : RIGCAL_OK,
                      survey(&p, 0, NULL));
    }
}

/* ---- one point ------------------------------------------------------------------ */

/* Each point in the camera's frame, its error and distance. A mirrored point is -x. */
static void test_a_point_and_its_error_are_those_of_the_pose(void)
{
    test_rng rng = test_seed(78);
    for (int trial = 0; trial < 100; trial++) {
        const int is_mirrored = trial % 2;
        rigcal_transform pose;
        double R[9], t[3];
        problem p;
        random_problem(&p, &rng);
        if (trial % 4 > 1) {
            p.camera.k1 = RC(-0.1);
        }
        ASSERT_STATUS(RIGCAL_OK, survey(&p, 0, NULL));
        p.points.is_mirrored = (uint8_t)is_mirrored;
        pose = test_random_transform(&rng);
        pose.t[2] = RC(5);
        test_transform_parts(R, t, &pose);
        for (int i = 0; i < N; i++) {
            double exact[3], q_exact[3], X_exact[3], uv[2], e_exact[2];
            rigcal_real x[3], q[3], X_c[3], e[2], B[6];
            for (int k = 0; k < 3; k++) {
                exact[k] = D(p.o[i].X_w[k]) - D(p.points.origin[k]);
                exact[k] *= is_mirrored ? -1 : 1;
            }
            test_apply(q_exact, R, exact, NULL);
            test_apply(X_exact, R, exact, t);
            rc_points_at(x, &p.points, (size_t)i);
            ASSERT_ARRAY_NEAR(exact, x, 3, TOL(1e-15, 1e-6));
            rc_points_place(q, X_c, &p.points, &pose, (size_t)i);
            ASSERT_ARRAY_NEAR(q_exact, q, 3, TOL(2e-15, 2e-6));
            ASSERT_ARRAY_NEAR(X_exact, X_c, 3, TOL(5e-15, 4e-6));

            ASSERT_STATUS(RIGCAL_OK,
                          rc_points_residual(e, B, q, X_c, &p.points, &pose, (size_t)i));
            test_project_px(uv, &p.camera, X_exact);
            for (int k = 0; k < 2; k++) {
                e_exact[k] = D(p.o[i].uv[k]) - uv[k];
            }
            ASSERT_ARRAY_NEAR(e_exact, e, 2, TOL(1e-10, 1e-2));
            ASSERT_ARRAY_NEAR(q_exact, q, 3, TOL(2e-15, 2e-6));
            ASSERT_NEAR(hypot(e_exact[0], e_exact[1]),
                        sqrt(D(rc_points_distance2(&p.points, &pose, (size_t)i))),
                        TOL(1e-10, 1e-2));
        }
    }
}

static void test_a_point_behind_is_as_far_off_as_can_be(void)
{
    test_rng rng = test_seed(79);
    problem p;
    double R[9];
    rigcal_transform pose;
    const double t[3] = {0, 0, -5};
    random_problem(&p, &rng);
    ASSERT_STATUS(RIGCAL_OK, survey(&p, 0, NULL));
    test_random_rotation(R, &rng);
    pose = test_transform(R, t);
    for (size_t i = 0; i < N; i++) {
        ASSERT_NEAR(RC_MAX, rc_points_distance2(&p.points, &pose, i), 0);
    }
}

/* Beside the camera and hardly in front: the square of the distance overflows. */
static void test_a_distance_that_overflows_is_the_most(void)
{
    const double t[3] = {0, 0, TOL(1e-170, 1e-20)};
    const rigcal_transform pose = test_transform(NULL, t);
    test_rng rng = test_seed(84);
    problem p;
    random_problem(&p, &rng);
    ASSERT_STATUS(RIGCAL_OK, survey(&p, 1, NULL));
    rc_clear(p.points.origin, 3);
    for (int i = 0; i < N; i++) {
        p.o[i].X_w[0] = 1;
        p.o[i].X_w[2] = 0;
        ASSERT_NEAR(RC_MAX, rc_points_distance2(&p.points, &pose, (size_t)i), 0);
    }
}

/* ---- on a line ------------------------------------------------------------------- */

static void test_points_on_any_line_are_told_from_those_beside_it(void)
{
    static const uint8_t MASK[N] = {1, 1, 0, 1, 1, 1};
    test_rng rng = test_seed(80);
    for (int trial = 0; trial < 300; trial++) {
        double way[3], from[3], aside[3];
        problem p;
        random_problem(&p, &rng);
        for (int k = 0; k < 3; k++) {
            way[k] = (k == trial % 4) ? 0 : test_uniform(&rng, -1, 1);
            from[k] = test_uniform(&rng, -3, 3);
            aside[k] =
                (k == trial % 4) ? 1 : 0; /* across the direction, if that has no part
                                             there */
        }
        if (trial % 4 == 3) {
            const double x_axis[3] = {1, 0, 0};
            test_cross(aside, way, x_axis);
        }
        for (int i = 0; i < N; i++) {
            const double along = test_uniform(&rng, -1, 1);
            for (int k = 0; k < 3; k++) {
                p.o[i].X_w[k] = RC(from[k] + along * way[k]);
            }
        }
        ASSERT_STATUS(RIGCAL_OK, survey(&p, 0, NULL));
        TEST_ASSERT_TRUE(rc_points_are_on_line(&p.points));

        for (int k = 0; k < 3; k++) {
            p.o[2].X_w[k] += RC(0.05 * aside[k] / test_norm(aside));
        }
        ASSERT_STATUS(RIGCAL_OK, survey(&p, 0, NULL));
        TEST_ASSERT_FALSE(rc_points_are_on_line(&p.points));

        ASSERT_STATUS(RIGCAL_OK, survey(&p, 0, MASK)); /* without the point beside it */
        TEST_ASSERT_TRUE(rc_points_are_on_line(&p.points));
    }
}

/* Two points are beside the line, on both sides, so that the mean is on it. */
static void test_each_point_beside_a_line_is_noticed(void)
{
    test_rng rng = test_seed(82);
    problem p;
    random_problem(&p, &rng);
    for (int one = 0; one < N; one++) {
        for (int other = 0; other < N; other++) {
            for (int i = 0; i < N; i++) {
                p.o[i].X_w[0] = RC(i);
                p.o[i].X_w[1] = RC(2 * i + 1);
                p.o[i].X_w[2] = RC(0.125 * ((i == one) - (i == other)));
            }
            ASSERT_STATUS(RIGCAL_OK, survey(&p, 0, NULL));
            TEST_ASSERT_EQUAL_INT(one == other, rc_points_are_on_line(&p.points));
        }
    }
}

TEST_MAIN()
{
    RUN_TEST(test_noise_is_nothing_or_within_a_million_either_way);
    RUN_TEST(test_a_view_is_checked_for_its_pointers_and_its_camera);
    RUN_TEST(test_what_is_negligible_grows_with_the_image_and_the_pixel);
    RUN_TEST(test_a_mask_and_the_one_left_out_do_not_count);
    RUN_TEST(test_a_survey_finds_the_middle_and_the_size);
    RUN_TEST(test_a_survey_knows_the_camera);
    RUN_TEST(test_a_far_world_costs_no_digits);
    RUN_TEST(test_a_wrong_number_is_told_with_its_observation);
    RUN_TEST(test_of_two_wrong_ones_the_first_that_counts_is_told);
    RUN_TEST(test_fewer_than_three_that_count_are_too_few);
    RUN_TEST(test_more_than_can_be_counted_are_refused_unread);
    RUN_TEST(test_points_in_one_place_or_too_far_for_their_size_are_refused);
    RUN_TEST(test_the_limits_of_size_and_digits_are_met_exactly);
    RUN_TEST(test_a_point_and_its_error_are_those_of_the_pose);
    RUN_TEST(test_a_point_behind_is_as_far_off_as_can_be);
    RUN_TEST(test_a_distance_that_overflows_is_the_most);
    RUN_TEST(test_points_on_any_line_are_told_from_those_beside_it);
    RUN_TEST(test_as_many_as_can_be_counted_are_read);
    RUN_TEST(test_the_disc_that_is_proved_holds_every_pixel);
    RUN_TEST(test_each_point_beside_a_line_is_noticed);
}
