/* seeds: the starts of a search, compared with the true pose of the scene and with minima
 * that test_fit finds. */
#include <math.h>
#include <string.h>

#include "rc_seeds.h"
#include "test_problem.h"

/* ---- a search by hand -------------------------------------------------------- */

static void begin(rigcal_search *s, const test_problem *p)
{
    rigcal_real uv_middle[2];
    int32_t at_fault;
    memset(s, 0, sizeof *s);
    rc_points_of(&s->points, &VIEW_OF(p), NULL);
    ASSERT_STATUS(RIGCAL_OK, rc_points_survey(&s->points, uv_middle, &at_fault));
    rc_seeds_begin(s, uv_middle);
}

/* Steps until there is a result. */
static int32_t next_start(rigcal_search *s)
{
    int32_t came = RC_SEEDS_BUSY;
    for (int step = 0; came == RC_SEEDS_BUSY; step++) {
        TEST_ASSERT_LESS_THAN_INT(1000, step);
        came = rc_seeds_step(s);
    }
    return came;
}

static const rigcal_transform *start_of(const rigcal_search *s)
{
    return &s->work.refinement.cam_from_points;
}

static double angle_to(const double R[9], const rigcal_transform *T)
{
    double seen[9];
    test_to_double(seen, T->R, 9);
    return test_angle_between(R, seen);
}

/* Keeps a pose as an optimum. Its points count from the origin of the search. */
static void keep(rigcal_search *s, const double R[9], const double t[3], double sse)
{
    double origin[3], shifted[3];
    rigcal_transform T;
    test_to_double(origin, s->points.origin, 3);
    test_apply(shifted, R, origin, t);
    T = test_transform(R, shifted);
    (void)rc_optima_insert(&s->optima, -1, &T, RC(sse));
}

/* ---- gathering --------------------------------------------------------------- */

static void test_the_virtual_camera_looks_at_the_middle_of_the_image(void)
{
    test_rng rng = test_seed(91);
    for (int trial = 0; trial < 100; trial++) {
        test_problem p;
        rigcal_search s;
        double ray[3] = {0, 0, 1};
        test_random_problem(&p, &rng, 8, TEST_GENERAL);
        begin(&s, &p);
        for (int i = 0; i < 8; i++) {
            ray[0] += (D(p.o[i].uv[0]) - D(p.camera.cx)) / D(p.camera.fx) / 8;
            ray[1] += (D(p.o[i].uv[1]) - D(p.camera.cy)) / D(p.camera.fy) / 8;
        }
        for (int k = 0; k < 3; k++) {
            ASSERT_NEAR(ray[k] / test_norm(ray), s.axis[k], TOL(1e-14, 1e-6));
        }
    }
}

/* Brown's lens with k1 = -1 folds 30 degrees off its axis: 800 / sqrt(3) 2 / 3 = 308 pixels
 * from the middle. */
static void test_a_pixel_that_the_lens_does_not_reach_is_told(void)
{
    static const rigcal_real MIDDLE[2] = {320 + 350, 240};
    test_rng rng = test_seed(92);
    for (int unseen = 0; unseen < 6; unseen++) {
        test_problem p;
        rigcal_search s;
        test_random_problem(&p, &rng, 6, TEST_GENERAL);
        p.camera.k1 = -1;
        p.o[unseen].uv[0] = MIDDLE[0];
        begin(&s, &p);
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_UNSEEN, next_start(&s));
        TEST_ASSERT_EQUAL(unseen, s.point);
        rc_seeds_begin(&s, MIDDLE); /* then it is the camera's own axis */
        ASSERT_NEAR(1, s.axis[2], 0);
        ASSERT_NEAR(0, s.axis[1], 0);
        ASSERT_NEAR(0, s.axis[0], 0);
    }
}

static void test_a_step_takes_16_rays_of_a_pinhole_and_one_of_a_lens(void)
{
    test_rng rng = test_seed(93);
    test_problem p;
    rigcal_search s;
    test_random_problem(&p, &rng, 20, TEST_GENERAL);
    begin(&s, &p);
    TEST_ASSERT_EQUAL_INT32(RC_SEEDS_BUSY, rc_seeds_step(&s));
    TEST_ASSERT_EQUAL(16, s.point);
    TEST_ASSERT_EQUAL_INT32(RC_SEEDS_BUSY, rc_seeds_step(&s));
    TEST_ASSERT_EQUAL(20, s.point);
    p.camera.k1 = RC(-0.01);
    begin(&s, &p);
    for (size_t i = 1; i <= 20; i++) {
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_BUSY, rc_seeds_step(&s));
        TEST_ASSERT_EQUAL(i, s.point);
    }
}

static void test_points_in_two_places_or_on_a_line_have_no_start(void)
{
    test_rng rng = test_seed(94);
    for (int trial = 0; trial < 20; trial++) {
        test_problem p, line;
        rigcal_search s;
        test_random_problem(&p, &rng, 6, TEST_GENERAL);
        line = p;
        for (int i = 2; i < 6; i++) {
            for (int k = 0; k < 3; k++) {
                line.o[i].X_w[k] =
                    RC(D(p.o[0].X_w[k]) + 0.3 * i * (D(p.o[1].X_w[k]) - D(p.o[0].X_w[k])));
            }
            p.o[i] = p.o[i % 2];
        }
        begin(&s, &p);
        ASSERT_STATUS(RIGCAL_ERR_COINCIDENT, next_start(&s));
        begin(&s, &line);
        ASSERT_STATUS(RIGCAL_ERR_COLLINEAR, next_start(&s));
        for (int i = 1; i < 6; i++) { /* one pixel for all */
            memcpy(p.o[i].uv, p.o[0].uv, sizeof p.o[0].uv);
        }
        begin(&s, &p);
        ASSERT_STATUS(RIGCAL_ERR_COINCIDENT, next_start(&s));
    }
}

/* The limit is a part of the target's size: the farthest that a coordinate is from the
 * first point. Nearer points count as one, and then three are left. */
static void test_points_at_nearly_one_place_count_as_one(void)
{
    test_rng rng = test_seed(117);
    for (int trial = 0; trial < 40; trial++) {
        const double apart = TOL(1e-9, 1e-5) * ((trial % 2) ? 0.7 : 1.4);
        double size = 0;
        test_problem p;
        rigcal_search s;
        test_random_problem(&p, &rng, 4, TEST_GENERAL);
        for (int i = 1; i < 3; i++) {
            for (int k = 0; k < 3; k++) {
                p.o[i].X_w[k] -= p.o[0].X_w[k];
                size = fmax(size, fabs(D(p.o[i].X_w[k])));
            }
        }
        for (int k = 0; k < 3; k++) {
            p.o[0].X_w[k] = 0;
            p.o[3].X_w[k] = (k == trial % 3) ? RC(apart * size) : 0;
        }
        begin(&s, &p);
        while (s.point < 4) {
            TEST_ASSERT_EQUAL_INT32(RC_SEEDS_BUSY, rc_seeds_step(&s));
        }
        TEST_ASSERT_EQUAL_INT(trial % 2 ? 3 : 4, s.work.triple.count);
    }
}

/* ---- the lattice -------------------------------------------------------------- */

/* points: fewer start from the poses of three of them, in builds that have the code. */
enum { MANY = 9, WITH_FEW = RIGCAL_FOR_SPEED && RIGCAL_WITH_THREE_POINTS };

enum { LATTICE = 24 };

/* A Fibonacci sphere: even steps in height, a golden angle in azimuth. */
static void lattice_direction(double m3[3], int i)
{
    const double azimuth = i * TEST_PI * (3 - sqrt(5)), z = 1 - (2 * i + 1.0) / LATTICE;
    m3[0] = sqrt(1 - z * z) * cos(azimuth);
    m3[1] = sqrt(1 - z * z) * sin(azimuth);
    m3[2] = z;
}

/* 24 caps of equal area have a radius of 23.6 degrees. With 8 degrees more they cover the
 * sphere. */
static void test_the_lattice_covers_the_sphere(void)
{
    test_rng rng = test_seed(95);
    double farthest = 0;
    for (int trial = 0; trial < TEST_TRIALS(20000); trial++) {
        double R[9], nearest = -1;
        test_random_rotation(R, &rng);
        for (int i = 0; i < LATTICE; i++) {
            double m3[3];
            lattice_direction(m3, i);
            nearest = fmax(nearest, test_dot(R, m3));
        }
        farthest = fmax(farthest, acos(fmin(1, nearest)));
    }
    TEST_ASSERT_TRUE(farthest < 32 * TEST_PI / 180);
}

/* Steps through the lattice. The library uses these directions, takes one step for each,
 * and keeps the three with the least cost, best first. */
static void assert_best_of_lattice(rigcal_search *s)
{
    const rigcal_lattice *const lattice = &s->from.lattice;
    double cost[LATTICE], scale = 0;
    int steps = 0;
    do {
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_BUSY, rc_seeds_step(s));
        steps += s->n_seeds > 0;
    } while (s->n_seeds == 0 || s->next > 0);
    TEST_ASSERT_EQUAL_INT(LATTICE, steps);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_SEEDS_MAX, s->n_seeds);
    for (int i = 0; i < LATTICE; i++) {
        double m3[3];
        rigcal_real m[3];
        lattice_direction(m3, i);
        test_to_real(m, m3, 3);
        cost[i] = D(rc_direction_cost(&lattice->moments, m));
        scale = fmax(scale, cost[i] < 1e30 ? cost[i] : 0);
    }
    for (int k = 0; k < RIGCAL_SEEDS_MAX; k++) {
        int better = 0;
        ASSERT_NEAR(cost[lattice->index[k]], lattice->cost[k], TOL(1e-12, 1e-4) * scale);
        for (int i = 0; i < LATTICE; i++) {
            better += cost[i] < D(lattice->cost[k]) - TOL(1e-12, 1e-4) * scale;
        }
        TEST_ASSERT_LESS_OR_EQUAL_INT(k, better);
    }
    ASSERT_NEAR(D(lattice->cost[0]), lattice->least_cost, 0);
}

static void test_the_search_keeps_the_three_best_of_the_lattice(void)
{
    test_rng rng = test_seed(96);
    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        test_problem p;
        rigcal_search s;
        test_random_problem(&p, &rng, MANY, trial % 2 ? TEST_PLANAR : TEST_GENERAL);
        test_add_noise(&p, &rng, 1);
        begin(&s, &p);
        assert_best_of_lattice(&s);
        TEST_ASSERT_FALSE(rc_seeds_scan(&s)); /* it has been searched */
    }
}

/* Few points start from poses of three of them. The lattice can be searched after those,
 * once. */
static void test_the_lattice_can_be_searched_after_few_points_are_spent(void)
{
    test_rng rng = test_seed(114);
    for (int trial = 0; trial < TEST_TRIALS(50); trial++) {
        test_problem p;
        rigcal_search s;
        test_random_problem(&p, &rng, 6, TEST_GENERAL);
        test_add_noise(&p, &rng, 1);
        begin(&s, &p);
        while (next_start(&s) == RC_SEEDS_START) {
        }
        if (s.n_seeds == 0) { /* there were such poses */
            TEST_ASSERT_TRUE(rc_seeds_scan(&s));
            assert_best_of_lattice(&s);
        }
        TEST_ASSERT_FALSE(rc_seeds_scan(&s));
    }
}

/* Of a target narrower than a quarter of its length, three points do not give the turn
 * about its length. So even few points of it begin with the lattice. */
static void test_few_points_of_a_narrow_target_begin_with_the_lattice(void)
{
    test_rng rng = test_seed(116);
    for (int trial = 0; trial < 40; trial++) {
        const double width = (trial % 2) ? 0.2 : 0.3;
        test_problem p;
        rigcal_search s;
        test_random_problem(&p, &rng, 6, TEST_GENERAL);
        for (int i = 0; i < 6; i++) {
            const double X[3] = {i % 2 - 0.5,
                                 width * (i < 2    ? 0
                                          : i == 2 ? 1
                                                   : 0.5),
                                 i > 3 ? 0.01 : 0};
            double X_c[3], uv[2];
            test_apply(X_c, p.scene.R, X, p.scene.t);
            test_project_px(uv, &p.camera, X_c);
            test_to_real(p.o[i].X_w, X, 3);
            test_to_real(p.o[i].uv, uv, 2);
        }
        begin(&s, &p);
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_START, next_start(&s));
        TEST_ASSERT_EQUAL_INT(WITH_FEW && width > 0.25, s.n_seeds == 0);
        TEST_ASSERT_EQUAL_INT(WITH_FEW && width > 0.25, s.n_roots > 0);
    }
}

/* ---- starts of a search ------------------------------------------------------- */

/* The distance of the nearest start, of all that come while nothing was found, and their
 * number. */
static double nearest_start(const test_problem *p, int *n_starts)
{
    double nearest = 10;
    rigcal_search s;
    int32_t came;
    *n_starts = 0;
    begin(&s, p);
    while ((came = next_start(&s)) == RC_SEEDS_START) {
        nearest = fmin(nearest, angle_to(p->scene.R, start_of(&s)));
        ++*n_starts;
    }
    TEST_ASSERT_EQUAL_INT32(RC_SEEDS_SPENT, came);
    return nearest;
}

/* 0.3 rad, half the spacing of the lattice, is close enough for a refinement. For a flat
 * target all starts may be at its second minimum: the leaning starts come only after that
 * was found. */
static void test_a_start_of_an_exact_view_is_near_its_pose(void)
{
    enum { TRIALS = TEST_TRIALS(400) };
    static const test_shape SHAPE[2] = {TEST_GENERAL, TEST_PLANAR};
    static const int FAR_MOST[2] = {TRIALS / 200, TRIALS / 40};
    test_rng rng = test_seed(97);
    for (int k = 0; k < 2; k++) {
        int far = 0;
        for (int trial = 0; trial < TRIALS; trial++) {
            test_problem p;
            int n_starts;
            test_random_problem(&p, &rng, MANY, SHAPE[k]);
            far += nearest_start(&p, &n_starts) > 0.3;
            TEST_ASSERT_EQUAL_INT(RIGCAL_SEEDS_MAX, n_starts);
        }
        TEST_ASSERT_LESS_OR_EQUAL_INT(FAR_MOST[k], far);
    }
}

static void test_no_start_leads_to_what_has_been_found(void)
{
    static const test_shape SHAPE[2] = {TEST_GENERAL, TEST_PLANAR};
    static const int POINTS[3] = {4, 8, 12};
    test_rng rng = test_seed(98);
    for (int trial = 0; trial < TEST_TRIALS(3000); trial++) {
        test_problem p;
        rigcal_search s;
        int n_starts = 0;
        test_random_problem(&p, &rng, POINTS[trial / 2 % 3], SHAPE[trial % 2]);
        test_add_noise(&p, &rng, trial % 7);
        begin(&s, &p);
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_START, next_start(&s));
        keep(&s, p.scene.R, p.scene.t, 0);
        while (next_start(&s) == RC_SEEDS_START) {
            TEST_ASSERT_TRUE(angle_to(p.scene.R, start_of(&s)) > TOL(0.05, 0.0499));
            n_starts++;
        }
        TEST_ASSERT_LESS_OR_EQUAL_INT(2 + 3, n_starts); /* from the lattice; leaning */
    }
}

/* A descent takes ten evaluations, of which that of the seed is known. Its start costs less
 * than the seed, or as much. */
static void test_a_descent_takes_ten_evaluations(void)
{
    test_rng rng = test_seed(115);
    int better = 0, descents = 0;
    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        test_problem p;
        rigcal_search s;
        test_random_problem(&p, &rng, MANY, TEST_GENERAL);
        begin(&s, &p);
        assert_best_of_lattice(&s);
        for (int k = 0; k < RIGCAL_SEEDS_MAX; k++, descents++) {
            int steps = 1;
            while (rc_seeds_step(&s) != RC_SEEDS_START) {
                steps++;
            }
            TEST_ASSERT_EQUAL_INT(1 + 9, steps);
            better += s.from.lattice.least_cost < s.from.lattice.cost[k];
            TEST_ASSERT_TRUE(s.from.lattice.least_cost <= s.from.lattice.cost[k]);
        }
    }
    TEST_ASSERT_GREATER_THAN_INT(descents * 9 / 10, better);
}

/* After a pose was found, a direction that costs more than 100 times the least is not worth
 * a start, unless the target is flat. */
static void test_a_hopeless_direction_is_no_start(void)
{
    test_rng rng = test_seed(118);
    for (int trial = 0; trial < TEST_TRIALS(400); trial++) {
        test_problem p;
        rigcal_search s;
        test_random_problem(&p, &rng, MANY, TEST_GENERAL);
        test_add_noise(&p, &rng, 0.1);
        begin(&s, &p);
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_START, next_start(&s));
        keep(&s, p.scene.R, p.scene.t, 0);
        while (next_start(&s) == RC_SEEDS_START) {
            const rigcal_lattice *const lattice = &s.from.lattice;
            rigcal_real m3[3];
            rc_mat3_tmul_vec3(m3, start_of(&s)->R, s.axis);
            TEST_ASSERT_TRUE(s.is_flat ||
                             D(rc_direction_cost(&lattice->moments, m3)) <=
                                 (1 + TOL(1e-9, 1e-3)) * 100 * D(lattice->least_cost));
        }
    }
}

/* A descent takes ten steps. It takes one step to see that a seed leads downhill to a pose
 * that was found. */
static void test_a_seed_on_the_way_to_the_pose_found_takes_no_descent(void)
{
    enum { TRIALS = TEST_TRIALS(200) };
    test_rng rng = test_seed(108);
    int quick = 0;
    for (int trial = 0; trial < TRIALS; trial++) {
        test_problem p;
        rigcal_search s;
        int steps = 0;
        test_random_problem(&p, &rng, MANY, TEST_GENERAL);
        begin(&s, &p);
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_START, next_start(&s));
        keep(&s, p.scene.R, p.scene.t, 0);
        while (rc_seeds_step(&s) != RC_SEEDS_SPENT) {
            steps++;
        }
        quick += steps < 10;
    }
    TEST_ASSERT_GREATER_THAN_INT(TRIALS / 2, quick);
    TEST_ASSERT_TRUE(TEST_ONE_IN > 1 || quick < TRIALS * 49 / 50);
}

/* ---- flat targets -------------------------------------------------------------- */

/* test_fit finds the second minimum of a plane's image. */
static void test_a_flat_target_has_a_start_near_its_second_minimum(void)
{
    enum { TRIALS = TEST_TRIALS(300) };
    test_rng rng = test_seed(99);
    int with_second = 0, missed = 0;
    for (int trial = 0; trial < TRIALS; trial++) {
        test_problem p;
        rigcal_search s;
        test_data data;
        test_fitted second;
        double nearest = 10;
        test_random_problem(&p, &rng, 6, TEST_PLANAR);
        test_add_noise(&p, &rng, 0.5);
        data = test_data_of(&p);
        test_mirror_tilt(&second, &data, p.scene.R, p.scene.t);
        if (!test_fit(&second, &data) || test_angle_between(p.scene.R, second.R) < 0.3) {
            continue; /* there is only one minimum */
        }
        with_second++;
        begin(&s, &p);
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_START, next_start(&s));
        keep(&s, p.scene.R, p.scene.t, 0);
        while (next_start(&s) == RC_SEEDS_START) {
            nearest = fmin(nearest, angle_to(second.R, start_of(&s)));
        }
        missed += nearest > 0.3;
    }
    TEST_ASSERT_GREATER_THAN_INT(TRIALS / 2, with_second);
    TEST_ASSERT_LESS_OR_EQUAL_INT(with_second / 50, missed);
}

/* Puts n points of p on a ring about the origin, in the plane z = 0, and projects them by R
 * of the scene and t. Their middle is the middle of the image. */
static void see_ring(test_problem *p, int n, const double t[3])
{
    for (int i = 0; i < n; i++) {
        const double way = 2 * TEST_PI / n * i;
        const double X[3] = {0.5 * cos(way), 0.5 * sin(way), 0};
        double X_c[3], uv[2];
        test_apply(X_c, p->scene.R, X, t);
        test_project_px(uv, &p->camera, X_c);
        test_to_real(p->o[i].X_w, X, 3);
        test_to_real(p->o[i].uv, uv, 2);
    }
}

/* Nearly head-on the least lean has a tangent of 0.3. Exactly head-on no direction of lean
 * is preferred, so any is right. */
static void test_a_flat_target_seen_head_on_has_starts_that_lean(void)
{
    const double t[3] = {0, 0, 5}, least = atan(0.3);
    double lean;
    test_rng rng = test_seed(106);
    for (int trial = 0; trial < 50; trial++) {
        test_problem p;
        rigcal_search s;
        test_random_problem(&p, &rng, MANY, TEST_GENERAL);
        test_rotation(p.scene.R, test_uniform(&rng, -3, 3), trial % 2 ? 0.01 : 0, 0);
        see_ring(&p, MANY, t);
        begin(&s, &p);
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_START, next_start(&s));
        keep(&s, p.scene.R, t, 0);
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_START, next_start(&s));
        lean = acos(D(start_of(&s)->R[8]));
        TEST_ASSERT_TRUE(lean > least - 0.01 && lean < (trial % 2 ? least + 0.01 : 1));
    }
}

/* Far away and with noise the tilt is hardly determined: two more starts lean sideways, one
 * to each side. */
static void test_a_small_flat_target_has_starts_that_lean_to_both_sides(void)
{
    const double t[3] = {0, 0, 60};
    test_rng rng = test_seed(112);
    for (int trial = 0; trial < 20; trial++) {
        double side[2][2];
        test_problem p;
        rigcal_search s;
        test_random_problem(&p, &rng, MANY, TEST_GENERAL);
        test_rotation(p.scene.R, test_uniform(&rng, -3, 3), 0.01, 0);
        see_ring(&p, MANY, t);
        for (int i = 0; i < MANY; i++) {
            for (int k = 0; k < 2; k++) {
                p.o[i].uv[k] += RC(test_uniform(&rng, -0.3, 0.3));
            }
        }
        begin(&s, &p);
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_START, next_start(&s));
        keep(&s, p.scene.R, t, 0);
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_START, next_start(&s)); /* the other way */
        for (int way = 0; way < 2; way++) {
            TEST_ASSERT_EQUAL_INT32(RC_SEEDS_START, next_start(&s));
            for (int k = 0; k < 2; k++) { /* how the normal leans in the image */
                side[way][k] = D(start_of(&s)->R[3 * k + 2]);
            }
        }
        TEST_ASSERT_TRUE(side[0][0] * side[1][0] + side[0][1] * side[1][1] < -0.05);
    }
}

/* A hexagon nearly head-on. A view of so few points starts from the poses of three of them.
 * After those comes a start that leans the other way by a tangent of 0.3, though the cost
 * falls from there to the pose found. It does not come if two poses were found: then it
 * would only lead to one of them. */
static void test_few_points_of_a_flat_target_have_a_start_that_leans(void)
{
    const double t[3] = {0, 0, 5}, lean = 0.01, least = atan(0.3);
    test_rng rng = test_seed(110);
    for (int trial = 0; trial < 50; trial++) {
        const int n_found = 1 + (WITH_FEW && trial % 2);
        double nearest = 10, other[9];
        test_problem p;
        rigcal_search s;
        test_random_problem(&p, &rng, 6, TEST_GENERAL);
        test_rotation(p.scene.R, test_uniform(&rng, -3, 3), lean, 0);
        test_rotation(other, 1, 1.2, 0.5);
        see_ring(&p, 6, t);
        begin(&s, &p);
        for (int i = 0; i < n_found; i++) {
            TEST_ASSERT_EQUAL_INT32(RC_SEEDS_START, next_start(&s));
        }
        for (int i = 0; i < n_found; i++) {
            keep(&s, i == 0 ? p.scene.R : other, t, i);
        }
        while (next_start(&s) == RC_SEEDS_START) {
            const rigcal_real *const R = start_of(&s)->R; /* its last column: the normal */
            double off = fabs(D(R[8]) - cos(least));
            for (int k = 0; k < 2; k++) {
                const double other_way = -p.scene.R[3 * k + 2] / sin(lean) * sin(least);
                off = fmax(off, fabs(D(R[3 * k + 2]) - other_way));
            }
            nearest = fmin(nearest, off);
        }
        TEST_ASSERT_EQUAL_INT(n_found == 1, nearest < 0.01);
    }
}

/* ---- three points --------------------------------------------------------------- */

/* One start is the true pose. Each other start puts the three points on their pixels, or
 * close to them: these are the real parts of two poses that noise or rounding made
 * complex. */
static void test_all_poses_of_three_points_are_starts(void)
{
    test_rng rng = test_seed(100);
    int several = 0, missed = 0, inexact = 0;
    for (int trial = 0; trial < 200; trial++) {
        test_problem p;
        rigcal_search s;
        int n_starts = 0;
        double nearest = 10;
        int32_t came;
        test_random_problem(&p, &rng, 3, TEST_GENERAL);
        begin(&s, &p);
        while ((came = next_start(&s)) == RC_SEEDS_START) {
            double off = 0;
            n_starts++;
            nearest = fmin(nearest, angle_to(p.scene.R, start_of(&s)));
            for (size_t i = 0; i < 3; i++) {
                off = fmax(off, sqrt(D(rc_points_distance2(&s.points, start_of(&s), i))));
            }
            TEST_ASSERT_TRUE(off < 3);
            inexact += off > TOL(1e-6, 0.1);
        }
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_TRIPLE_SPENT, came);
        TEST_ASSERT_FALSE(rc_seeds_pick(&s)); /* there is no other triple */
        missed += !(nearest < TOL(1e-6, 0.02));
        several += n_starts > 1;
        TEST_ASSERT_LESS_OR_EQUAL_INT(RC_P3P_MAX, n_starts);
    }
    TEST_ASSERT_GREATER_THAN_INT(100, several);
    TEST_ASSERT_LESS_OR_EQUAL_INT(TOL(0, 2), missed); /* two poses are about to merge */
    TEST_ASSERT_LESS_OR_EQUAL_INT(20, inexact);
}

/* Points 0 and 1 are 0.1 apart, and seen 40 degrees apart. So the camera is nearer to both
 * than 0.1 / sin 40, 0.16. Point 2 is 1 away, on a ray 0.1 degrees from that of point 0: so
 * it is 1 behind point 0. From there point 1 is 0.91 away, but would be more than 1, as its
 * part along the ray is in front of point 0. No pose puts these points on their pixels. The
 * lattice is scanned at once. */
static void test_three_points_without_a_pose_begin_with_the_lattice(void)
{
    static const double X[3][3] = {{0, 0, 0}, {0.09, 0.0436, 0}, {1, 0, 0}};
    static const double ANGLE[3] = {-20, 20, -20.1};
    test_rng rng = test_seed(119);
    test_problem p;
    rigcal_search s;
    test_random_problem(&p, &rng, 3, TEST_GENERAL);
    p.camera = test_pinhole();
    for (int i = 0; i < 3; i++) {
        test_to_real(p.o[i].X_w, X[i], 3);
        p.o[i].uv[0] = RC(D(p.camera.cx) + D(p.camera.fx) * tan(ANGLE[i] * TEST_PI / 180));
        p.o[i].uv[1] = p.camera.cy + (i == 2);
    }
    begin(&s, &p);
    while (s.point < 3) {
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_BUSY, rc_seeds_step(&s));
    }
    assert_best_of_lattice(&s);
    TEST_ASSERT_EQUAL_INT(0, s.n_roots);
    TEST_ASSERT_EQUAL_INT32(RC_SEEDS_START, next_start(&s));
}

/* ---- triples --------------------------------------------------------------------- */

static void test_rays_all_around_start_from_triples_among_which_is_the_pose(void)
{
    test_rng rng = test_seed(101);
    for (int trial = 0; trial < 100; trial++) {
        test_problem p;
        rigcal_search s;
        double nearest = 10;
        test_surrounded_problem(&p, &rng, 4 + trial % 12);
        begin(&s, &p);
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_START, next_start(&s));
        TEST_ASSERT_TRUE(s.is_wide);
        do {
            nearest = fmin(nearest, angle_to(p.scene.R, start_of(&s)));
        } while (next_start(&s) == RC_SEEDS_START);
        TEST_ASSERT_TRUE(nearest < TOL(1e-6, 1e-2));
    }
}

/* All rays are as far off the axis. Beyond 60 degrees triples of points come after the
 * search, beyond 80 degrees in place of it. */
static void test_how_far_off_the_axis_triples_are_taken(void)
{
    static const double DEGREES[8] = {20, 59, 61, 70, 79, 81, 85, 89};
    test_rng rng = test_seed(112);
    for (int trial = 0; trial < 16; trial++) {
        const double off = DEGREES[trial / 2];
        test_problem p;
        rigcal_search s;
        test_surrounded_problem(&p, &rng, 12);
        p.camera.lens = (trial % 2) ? RIGCAL_LENS_FISHEYE : RIGCAL_LENS_BROWN;
        for (int i = 0; i < 12; i++) {
            const double way = TEST_PI / 6 * i, out = off * TEST_PI / 180;
            const double range = test_uniform(&rng, 1, 2);
            const double X_c[3] = {range * sin(out) * cos(way), range * sin(out) * sin(way),
                                   range * cos(out)};
            double uv[2], from[3], back[9], X[3];
            test_project_px(uv, &p.camera, X_c);
            test_to_real(p.o[i].uv, uv, 2);
            for (int k = 0; k < 3; k++) {
                from[k] = X_c[k] - p.scene.t[k];
            }
            test_transpose(back, p.scene.R);
            test_apply(X, back, from, NULL);
            test_to_real(p.o[i].X_w, X, 3);
        }
        begin(&s, &p);
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_START, next_start(&s));
        TEST_ASSERT_EQUAL_INT(off > 60, s.is_wide != 0);
        TEST_ASSERT_EQUAL_INT(off > 80, s.triples > 0);
        TEST_ASSERT_EQUAL_INT(off > 80, s.n_seeds == 0);
        keep(&s, p.scene.R, p.scene.t, 0);
        while (next_start(&s) == RC_SEEDS_START) {
        }
        TEST_ASSERT_EQUAL_INT(off > 60, s.triples > 0);
    }
}

/* A fisheye's pixel at 180 degrees or more is reported before the first start, whether or
 * not a triple would use that point. */
static void test_a_pixel_of_rays_all_around_that_has_none_is_told_before_a_start(void)
{
    test_rng rng = test_seed(107);
    for (int unseen = 0; unseen < 8; unseen++) {
        test_problem p;
        rigcal_search s;
        test_surrounded_problem(&p, &rng, 8);
        p.o[unseen].uv[0] = RC(320 + 120 * 3.2);
        p.o[unseen].uv[1] = 240;
        begin(&s, &p);
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_UNSEEN, next_start(&s));
        TEST_ASSERT_EQUAL(unseen, s.point);
    }
}

/* A triple is spread over the points' order, which goes round: between two of its points
 * lie at least five sixteenths of all, or nearly so. */
static void test_a_triple_is_spread_over_the_order_of_the_points(void)
{
    test_rng rng = test_seed(109);
    for (int n = 8; n <= 32 && n <= TEST_SCENE_MAX; n += 4) {
        test_problem p;
        rigcal_search s;
        int32_t triples = 0;
        test_surrounded_problem(&p, &rng, n);
        begin(&s, &p);
        while (rc_seeds_step(&s) != RC_SEEDS_TRIPLE_SPENT) {
            if (s.triples > triples) {
                const int32_t *const i = s.work.triple.index;
                for (int k = 0; k < 3; k++) {
                    TEST_ASSERT_GREATER_OR_EQUAL_INT(n / 4 + n / 16,
                                                     (i[(k + 1) % 3] - i[k] + n) % n);
                }
                triples = s.triples;
            }
        }
        TEST_ASSERT_EQUAL_INT32(6, triples);
    }
}

/* While nothing is found, every pose of every triple is a start. */
static void test_all_poses_of_each_triple_are_starts(void)
{
    test_rng rng = test_seed(113);
    int several = 0;
    for (int trial = 0; trial < 40; trial++) {
        int32_t came = RC_SEEDS_BUSY, triples = 0;
        int n_starts = 0, n_poses = 0;
        test_problem p;
        rigcal_search s;
        test_surrounded_problem(&p, &rng, 12);
        begin(&s, &p);
        while (came != RC_SEEDS_TRIPLE_SPENT) {
            came = rc_seeds_step(&s);
            n_starts += came == RC_SEEDS_START;
            if (s.triples > triples) {
                triples = s.triples;
                n_poses += s.n_exact;
                several += s.n_exact > 1;
            }
        }
        TEST_ASSERT_EQUAL_INT(n_poses, n_starts);
    }
    TEST_ASSERT_GREATER_THAN_INT(40, several);
}

/* Each triple has three different points. Together they have all of 8 points; with more
 * points at least as many. No triple comes twice if there are 6 points or more. */
static void test_triples_are_of_different_points_and_six_at_most(void)
{
    test_rng rng = test_seed(102);
    for (int n = 4; n <= 20; n++) {
        test_problem p;
        rigcal_search s;
        unsigned used = 0, triple[6] = {0};
        int n_used = 0;
        int32_t came = RC_SEEDS_BUSY, triples = 0;
        test_surrounded_problem(&p, &rng, n);
        begin(&s, &p);
        while (came != RC_SEEDS_TRIPLE_SPENT) { /* nothing is found */
            came = rc_seeds_step(&s);
            if (s.triples > triples) {
                const int32_t *const i = s.work.triple.index;
                TEST_ASSERT_LESS_THAN_INT(6, triples);
                TEST_ASSERT_TRUE(i[0] != i[1] && i[1] != i[2] && i[0] != i[2]);
                for (int k = 0; k < 3; k++) {
                    TEST_ASSERT_TRUE(i[k] >= 0 && i[k] < n);
                    triple[triples] |= 1u << i[k];
                }
                used |= triple[triples];
                for (int32_t before = 0; before < triples && n >= 6; before++) {
                    TEST_ASSERT_TRUE(triple[before] != triple[triples]);
                }
                triples = s.triples;
            }
        }
        TEST_ASSERT_EQUAL_INT32(6, triples);
        TEST_ASSERT_FALSE(rc_seeds_pick(&s));
        for (; used != 0; used &= used - 1) {
            n_used++;
        }
        TEST_ASSERT_GREATER_OR_EQUAL_INT(n < 8 ? n : 8, n_used);
    }
}

static void test_after_a_pose_two_triples_are_enough(void)
{
    test_rng rng = test_seed(103);
    test_problem p;
    rigcal_search s;
    test_surrounded_problem(&p, &rng, 12);
    begin(&s, &p);
    TEST_ASSERT_EQUAL_INT32(RC_SEEDS_START, next_start(&s));
    keep(&s, p.scene.R, p.scene.t, 0);
    while (next_start(&s) == RC_SEEDS_START) {
        TEST_ASSERT_TRUE(angle_to(p.scene.R, start_of(&s)) > TOL(0.05, 0.0499));
    }
    TEST_ASSERT_EQUAL_INT32(2, s.triples);
    TEST_ASSERT_TRUE(rc_seeds_pick(&s)); /* its owner may want more */
    (void)next_start(&s);
    TEST_ASSERT_EQUAL_INT32(3, s.triples);
}

/* ---- mirrored points ------------------------------------------------------------- */

/* Gives all points of the scene their pixels. */
static void see(test_problem *p)
{
    for (int i = 0; i < p->scene.n; i++) {
        double X_c[3], uv[2];
        test_apply(X_c, p->scene.R, p->scene.X[i], p->scene.t);
        test_project_px(uv, &p->camera, X_c);
        test_to_real(p->o[i].X_w, p->scene.X[i], 3);
        test_to_real(p->o[i].uv, uv, 2);
    }
}

/* A target at this distance in front of the camera. */
static void far_target(test_problem *p, test_shape shape, double distance, test_rng *rng)
{
    test_random_problem(p, rng, 10, shape);
    for (int k = 0; k < 3; k++) {
        double middle = 0, at = 0;
        for (int i = 0; i < 10; i++) {
            middle += p->scene.X[i][k] / 10;
        }
        for (int i = 0; i < 10; i++) {
            p->scene.X[i][k] -= middle;
        }
        at = (k == 2) ? distance : 0;
        p->scene.t[k] = at;
    }
    see(p);
}

/* The target is seen from a direction of the lattice, and what was found is 0.03 rad beside
 * it. The cost falls from there to the direction of the lattice, so its descent ends there.
 * But that is too near to what was found. */
static void test_no_start_is_beside_what_was_found(void)
{
    static const double X_AXIS[3] = {1, 0, 0};
    test_rng rng = test_seed(111);
    for (int i = 0; i < LATTICE; i++) {
        double *R, beside[9], by[9], length;
        test_problem p;
        rigcal_search s;
        far_target(&p, TEST_GENERAL, 20, &rng);
        R = p.scene.R;
        lattice_direction(R + 6, i);
        length = hypot(R[6], R[7]);
        R[0] = -R[7] / length;
        R[1] = R[6] / length;
        R[2] = 0;
        test_cross(R + 3, R + 6, R);
        see(&p);
        test_rotation_about(by, X_AXIS, 0.03);
        test_product(beside, by, R);
        begin(&s, &p);
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_START, next_start(&s));
        TEST_ASSERT_TRUE(angle_to(R, start_of(&s)) < 0.05);
        keep(&s, beside, p.scene.t, 1);
        s.next = 0; /* all seeds once more */
        while (next_start(&s) == RC_SEEDS_START) {
            TEST_ASSERT_TRUE(angle_to(beside, start_of(&s)) > 0.05);
        }
    }
}

/* The given points are mirrored. Their least sum is about half a turn about the line of
 * sight from the pose. The start for mirrored points undoes this. */
static void test_of_mirrored_points_the_start_is_near_the_pose(void)
{
    static const double SIGHT[3] = {0, 0, 1};
    test_rng rng = test_seed(104);
    for (int trial = 0; trial < TEST_TRIALS(60); trial++) {
        test_problem p;
        rigcal_search s;
        test_data data;
        test_fitted wrong;
        double half_turn[9];
        far_target(&p, TEST_GENERAL, 20, &rng);
        test_add_noise(&p, &rng, 0.2);
        for (int i = 0; i < 10; i++) {
            for (int k = 0; k < 3; k++) {
                p.o[i].X_w[k] = -p.o[i].X_w[k];
            }
        }
        data = test_data_of(&p);
        test_rotation_about(half_turn, SIGHT, TEST_PI);
        test_product(wrong.R, half_turn, p.scene.R);
        memcpy(wrong.t, p.scene.t, sizeof wrong.t);
        TEST_ASSERT_TRUE(test_fit(&wrong, &data));
        begin(&s, &p);
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_START, next_start(&s));
        keep(&s, wrong.R, wrong.t, wrong.sse);
        while (next_start(&s) == RC_SEEDS_START) {
        }
        TEST_ASSERT_TRUE(rc_seeds_mirrored(&s));
        TEST_ASSERT_TRUE(angle_to(p.scene.R, start_of(&s)) < 0.3);
        ASSERT_NEAR(20, start_of(&s)->t[2], 2);
    }
}

/* A plane has the same images when mirrored. Near the camera, right coordinates leave no
 * doubt. */
static void test_neither_a_plane_nor_right_points_near_by_are_tried_mirrored(void)
{
    test_rng rng = test_seed(105);
    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        test_problem p;
        rigcal_search s;
        far_target(&p, trial % 2 ? TEST_PLANAR : TEST_GENERAL, trial % 2 ? 20 : 3, &rng);
        test_add_noise(&p, &rng, 0.3);
        begin(&s, &p);
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_START, next_start(&s));
        keep(&s, p.scene.R, p.scene.t, 1);
        while (next_start(&s) == RC_SEEDS_START) {
        }
        TEST_ASSERT_FALSE(rc_seeds_mirrored(&s));
    }
}

/* ---- seeds of an odd kind ------------------------------------------------------ */

/* The points of a cross. All points of one bar are seen on the left, all of the other on
 * the right. So the pixels fit the points in no direction. */
static void test_an_image_that_does_not_go_with_the_target_has_no_start(void)
{
    test_problem p;
    rigcal_search s;

    p.camera = test_pinhole();
    p.camera.fx = p.camera.fy = 512;
    p.use_sigma = 0;
    p.scene.n = 12;
    for (int i = 0; i < 12; i++) {
        const double r = (i < 4 ? 1 : i < 8 ? 0.5 : 0.25) * (i % 2 ? 1 : -1);
        const int is_bar = i / 2 % 2;

        p.o[i] = (rigcal_observation){{RC(is_bar ? 0 : r), RC(is_bar ? r : 0), 0},
                                      {RC(is_bar ? 320 + 64 : 320 - 64), 240}};
    }
    begin(&s, &p);
    TEST_ASSERT_EQUAL_INT32(RC_SEEDS_SPENT, next_start(&s));
    TEST_ASSERT_EQUAL_INT32(RIGCAL_SEEDS_MAX, s.n_seeds); /* the lattice was tried */
}

/* Half-way between a seed and an optimum straight across there is no direction. The seed
 * then takes a descent. */
static void test_a_seed_straight_across_from_what_was_found_takes_a_descent(void)
{
    const rigcal_real z = 1 - RC(1) / 24, r = RC(sqrt(D(1 - z * z)));
    test_rng rng = test_seed(107);
    test_problem p;
    rigcal_search s;
    double first[3];

    test_random_problem(&p, &rng, 12, TEST_GENERAL);
    begin(&s, &p);
    while (s.n_seeds < RIGCAL_SEEDS_MAX || s.next > 0) {
        TEST_ASSERT_EQUAL_INT32(RC_SEEDS_BUSY, rc_seeds_step(&s));
    }
    TEST_ASSERT_FALSE(s.is_flat);
    lattice_direction(first, 0);
    s.from.lattice.index[0] = 0;
    s.axis[0] = s.axis[1] = 0;
    s.axis[2] = 1;
    s.optima.n = 1; /* it looks along the rows' product, (-r, 0, -z) */
    const rigcal_real rows[6] = {0, 1, 0, z, 0, -r};
    memcpy(s.optima.list[0].rows, rows, sizeof rows);
    TEST_ASSERT_EQUAL_INT32(RC_SEEDS_BUSY, rc_seeds_step(&s));
    ASSERT_NEAR(first[0], s.work.descent.m3[0], TOL(1e-14, 1e-6));
    ASSERT_NEAR(first[2], s.work.descent.m3[2], TOL(1e-14, 1e-6));
    ASSERT_NEAR(0, s.work.descent.m3[0] - r, 0);
    ASSERT_NEAR(0, s.work.descent.m3[2] - z, 0);
}

TEST_MAIN()
{
    RUN_TEST(test_the_virtual_camera_looks_at_the_middle_of_the_image);
    RUN_TEST(test_a_pixel_that_the_lens_does_not_reach_is_told);
    RUN_TEST(test_a_step_takes_16_rays_of_a_pinhole_and_one_of_a_lens);
    RUN_TEST(test_points_in_two_places_or_on_a_line_have_no_start);
    RUN_TEST(test_points_at_nearly_one_place_count_as_one);
    RUN_TEST(test_the_lattice_covers_the_sphere);
    RUN_TEST(test_the_search_keeps_the_three_best_of_the_lattice);
    RUN_TEST(test_the_lattice_can_be_searched_after_few_points_are_spent);
    RUN_TEST(test_few_points_of_a_narrow_target_begin_with_the_lattice);
    RUN_TEST(test_a_start_of_an_exact_view_is_near_its_pose);
    RUN_TEST(test_no_start_leads_to_what_has_been_found);
    RUN_TEST(test_a_descent_takes_ten_evaluations);
    RUN_TEST(test_a_hopeless_direction_is_no_start);
    RUN_TEST(test_a_seed_on_the_way_to_the_pose_found_takes_no_descent);
    RUN_TEST(test_a_flat_target_has_a_start_near_its_second_minimum);
    RUN_TEST(test_a_flat_target_seen_head_on_has_starts_that_lean);
    RUN_TEST(test_a_small_flat_target_has_starts_that_lean_to_both_sides);
    RUN_TEST(test_few_points_of_a_flat_target_have_a_start_that_leans);
    RUN_TEST(test_all_poses_of_three_points_are_starts);
    RUN_TEST(test_three_points_without_a_pose_begin_with_the_lattice);
    RUN_TEST(test_rays_all_around_start_from_triples_among_which_is_the_pose);
    RUN_TEST(test_how_far_off_the_axis_triples_are_taken);
    RUN_TEST(test_a_pixel_of_rays_all_around_that_has_none_is_told_before_a_start);
    RUN_TEST(test_a_triple_is_spread_over_the_order_of_the_points);
    RUN_TEST(test_all_poses_of_each_triple_are_starts);
    RUN_TEST(test_triples_are_of_different_points_and_six_at_most);
    RUN_TEST(test_after_a_pose_two_triples_are_enough);
    RUN_TEST(test_no_start_is_beside_what_was_found);
    RUN_TEST(test_of_mirrored_points_the_start_is_near_the_pose);
    RUN_TEST(test_neither_a_plane_nor_right_points_near_by_are_tried_mirrored);
    RUN_TEST(test_an_image_that_does_not_go_with_the_target_has_no_start);
    RUN_TEST(test_a_seed_straight_across_from_what_was_found_takes_a_descent);
}
