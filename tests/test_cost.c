/* cost: what a view of an adjusted rig costs. The truth: its placement is adjusted again
 * without the view, by the test's own least squares. */
#include <math.h>
#include <string.h>

#include "rc_cost.h"
#include "rc_linalg.h"
#include "rigcal_solvers.h"
#include "test_boards.h"
#include "test_fit.h"

static const double NOISE = 0.3;

/* sigma^2: the limit of the cost of a view. */
static const double LIMIT = 40;

static test_boards b;

/* Sum of squared errors of all views of the placement but one, after a move d. */
static double sum_without(const rigcal_transform *placement, int f, size_t without)
{
    double sum = 0;

    for (size_t v = 0; v < b.rig.n_views; v++) {
        if (b.views[v].placement == f && v != without) {
            const rigcal_transform T = test_times(&b.cams[b.views[v].camera], placement);
            const test_data data = {&b.camera, b.o[v], NULL, BOARD_POINTS};
            double R[9], t[3];

            test_transform_parts(R, t, &T);
            sum += test_sse(&data, R, t);
        }
    }
    return sum;
}

/* The minimum of that sum, by Newton's steps with difference quotients. */
static double least_without(const rigcal_transform *placement, int f, size_t without)
{
    static const double H = 1e-4;
    double at[9], t_at[3], R_0[9], t_0[3], least = 0;

    test_transform_parts(at, t_at, placement);
    for (int round = 0; round < 4; round++) {
        double values[13][13], g[6], G[36], step[6];

        memcpy(R_0, at, sizeof at);
        memcpy(t_0, t_at, sizeof t_at);
        for (int i = 0; i < 13; i++) { /* the point 0; then e_k and -e_k; and with a second
                                          one */
            for (int j = 0; j <= i; j++) {
                double R[9], t[3], d[6] = {0, 0, 0, 0, 0, 0};

                for (int n = 0; n < 2; n++) {
                    const int k = n ? j : i;

                    if (k > 0 && (i != j || n == 0)) {
                        d[(k - 1) / 2] += (k % 2) ? H : -H;
                    }
                }
                memcpy(R, R_0, sizeof R);
                memcpy(t, t_0, sizeof t);
                test_move(R, t, d);
                const rigcal_transform moved = test_transform(R, t);
                values[i][j] = values[j][i] = sum_without(&moved, f, without);
            }
        }
        for (int i = 0; i < 6; i++) {
            g[i] = -(values[2 * i + 1][0] - values[2 * i + 2][0]) / (2 * H);
            for (int j = 0; j < 6; j++) {
                G[6 * i + j] =
                    i == j
                        ? (values[2 * i + 1][0] + values[2 * i + 2][0] - 2 * values[0][0]) /
                              (H * H)
                        : (values[2 * i + 1][2 * j + 1] - values[2 * i + 1][2 * j + 2] -
                           values[2 * i + 2][2 * j + 1] + values[2 * i + 2][2 * j + 2]) /
                              (4 * H * H);
            }
        }
        least = values[0][0];
        TEST_ASSERT_TRUE(test_solve(step, G, g, 6));
        test_move(at, t_at, step);
    }
    return least;
}

static void test_a_view_costs_what_the_sum_falls_by_without_it(void)
{
    test_rng rng = test_seed(901);

    TEST_WANTS_RAM(sizeof(test_boards) + 20000);
    if (RIGCAL_USE_FLOAT) {
        TEST_IGNORE_MESSAGE("differences of poses in float are too coarse");
    }
    test_boards_make(&b, &rng, 3, 5, 3, NOISE, 0);
    test_boards_solve(&b);
    b.choice.sigma_px = RC(NOISE);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_judge(&b.judgement, NULL, b.judged, b.left_out,
                                              &b.choice, &b.rig));
    TEST_ASSERT_EQUAL_INT32(15, b.judgement.n_fit);
    const double unit =
        LIMIT * D(b.judgement.scale) * D(b.judgement.sigma_px) * D(b.judgement.sigma_px);
    for (size_t v = 0; v < b.rig.n_views; v += 2) {
        const test_data data = {&b.camera, b.o[v], NULL, BOARD_POINTS};
        const int f = b.views[v].placement;
        test_fitted own;
        const double all = sum_without(&b.places[f], f, b.rig.n_views);

        test_transform_parts(own.R, own.t, &b.own[v].cam_from_target);
        TEST_ASSERT_TRUE(test_fit(&own, &data));
        const double falls = all - own.sse - least_without(&b.places[f], f, v);
        ASSERT_NEAR(falls, unit * D(b.judged[v].cost), 0.02 * falls + 0.01);
        const rigcal_transform T = test_times(&b.cams[b.views[v].camera], &b.places[f]);
        rigcal_real rms;
        ASSERT_STATUS(RIGCAL_OK, rigcal_view_rms(&rms, NULL, &b.views[v].view, &T));
        ASSERT_NEAR(rms, b.judged[v].rms_px, 1e-9);
    }
}

/* With noise alone, the mean of the costs is that of chi squared with 6 degrees of freedom
 * for each cycle that the views close, shared among the views. */
static void test_costs_of_noise_are_chi_squared(void)
{
    double sum = 0, cycles = 0;

    TEST_WANTS_RAM(sizeof(test_boards) + 20000);
    for (int trial = 0; trial < TEST_TRIALS(40); trial++) {
        test_rng rng = test_seed(950 + (uint64_t)trial);

        test_boards_make(&b, &rng, 4, 8, 4, NOISE, 0);
        test_boards_solve(&b);
        b.choice.sigma_px = RC(NOISE);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_judge(&b.judgement, NULL, b.judged, b.left_out,
                                                  &b.choice, &b.rig));
        for (size_t v = 0; v < b.rig.n_views; v++) {
            sum += LIMIT * D(b.judgement.scale) * D(b.judged[v].cost);
        }
        cycles += 32 * (32. - 4 - 8 + 1) / (32 - 8);
    }
    ASSERT_NEAR(6, sum / cycles, 0.5);
}

static void judge(void)
{
    test_boards_solve(&b);
    test_boards_join(&b, NOISE);
    b.choice.sigma_px = RC(NOISE);
    TEST_ASSERT_TRUE(
        rigcal_rig_judge(&b.judgement, NULL, b.judged, b.left_out, &b.choice, &b.rig) >= 0);
}

/* A view that is left out also costs what the sum falls by without it, to first order. Its
 * cost is divided by the limit of the choice. */
static void test_a_view_that_is_left_out_costs_what_the_sum_would_fall_by(void)
{
    enum { F = 2 };
    static const double LIMIT_OF_CHOICE = 30;

    TEST_WANTS_RAM(sizeof(test_boards) + 20000);
    if (RIGCAL_USE_FLOAT) {
        TEST_IGNORE_MESSAGE("differences of poses in float are too coarse");
    }
    for (int n_cameras = 2; n_cameras <= 3; n_cameras++) {
        test_rng rng = test_seed(902);
        test_data data = {&b.camera, NULL, NULL, BOARD_POINTS};
        test_fitted own;

        test_boards_make(&b, &rng, n_cameras, 6, n_cameras, NOISE, 0);
        const size_t v = (size_t)test_boards_view(&b, 0, F);
        for (int i = 0; i < BOARD_POINTS; i++) {
            b.o[v][i].uv[0] += RC(n_cameras == 2 ? 15 : 5);
        }
        judge();
        TEST_ASSERT_EQUAL_UINT8(1, b.left_out[v]);
        TEST_ASSERT_EQUAL_UINT8(n_cameras == 2, b.left_out[v + 1]);
        data.observations = b.o[v];
        test_transform_parts(own.R, own.t, &b.own[v].cam_from_target);
        TEST_ASSERT_TRUE(test_fit(&own, &data));
        const double falls = least_without(&b.places[F], F, b.rig.n_views) - own.sse -
                             least_without(&b.places[F], F, v);
        const double unit = LIMIT_OF_CHOICE * D(b.judgement.scale) * NOISE * NOISE;
        ASSERT_NEAR(falls, unit * D(b.judged[v].cost), 0.05 * falls);
        if (n_cameras == 2) { /* no view says where the placement is */
            ASSERT_NEAR(-1, b.judged[v].rms_px, 0);
            ASSERT_NEAR(-1, b.judged[v + 1].rms_px, 0);
            ASSERT_NEAR(falls, unit * D(b.judged[v + 1].cost), 0.05 * falls);
        }
    }
}

/* The rise of its own sum bounds what a view that is left out costs. That is so where its
 * error is many pixels, and where it is a small part of one. */
static void test_a_view_that_is_left_out_costs_no_more_than_its_own_sum_rises(void)
{
    enum { F = 2 };
    int n_bounded[2] = {0, 0};

    TEST_WANTS_RAM(sizeof(test_boards) + 20000);
    if (RIGCAL_USE_FLOAT) {
        TEST_IGNORE_MESSAGE("a hundredth of a pixel is rounding in float");
    }
    for (int trial = 0; trial < 12; trial++) {
        const double noise = trial % 2 ? NOISE : NOISE / 100;
        test_rng rng = test_seed(903 + (uint64_t)trial);

        test_boards_make(&b, &rng, 5, 6, 5, noise, 0);
        const size_t v = (size_t)test_boards_view(&b, trial / 2 % 5, F);
        for (int i = 0; i < BOARD_POINTS; i++) {
            b.o[v][i].uv[0] += RC(15 * noise);
        }
        test_boards_solve(&b);
        test_boards_join(&b, noise);
        b.choice.sigma_px = RC(noise);
        TEST_ASSERT_TRUE(rigcal_rig_judge(&b.judgement, NULL, b.judged, b.left_out,
                                          &b.choice, &b.rig) >= 0);
        TEST_ASSERT_EQUAL_UINT8(1, b.left_out[v]);
        const double rms = D(b.judged[v].rms_px);
        const double rises = BOARD_POINTS * rms * rms - D(b.own[v].sse);
        const double costs =
            LIMIT * D(b.judgement.scale) * noise * noise * D(b.judged[v].cost);
        TEST_ASSERT_TRUE(trial % 2 ? rms > 1 : rms > 0 && rms < 0.1);
        TEST_ASSERT_TRUE(costs <= rises * (1 + 1e-9));
        n_bounded[trial % 2] += costs > rises * (1 - 1e-9);
    }
    TEST_ASSERT_TRUE(n_bounded[0] > 0 && n_bounded[1] > 0);
}

/* Placements that nobody saw, in the middle and at the end, change no cost. */
static void test_placements_without_views_cost_nothing(void)
{
    test_rng rng = test_seed(960);
    rigcal_real costs[15];

    TEST_WANTS_RAM(sizeof(test_boards) + 20000);
    test_boards_make(&b, &rng, 3, 5, 3, NOISE, 0);
    judge();
    for (int v = 0; v < 15; v++) {
        costs[v] = b.judged[v].cost;
    }
    for (int f = 4; f >= 2; f--) {
        b.true_places[f + 1] = b.true_places[f];
    }
    b.true_places[6] = b.true_places[2];
    for (int v = 6; v < 15; v++) {
        b.views[v].placement++;
    }
    b.rig.n_placements = 7;
    judge();
    for (int v = 0; v < 15; v++) {
        ASSERT_NEAR(costs[v], b.judged[v].cost, TOL(1e-9, 1e-3) * (1 + D(costs[v])));
    }
}

/* Points of the board are behind camera 3, which is beside camera 2: their views have the
 * pixels of another placement, and are left out. That of camera 3 has no error at the
 * stated place. */
static void test_a_view_of_what_is_behind_its_camera_has_no_error(void)
{
    enum { F = 5 };
    test_rng rng = test_seed(961);
    double centre[3], middle[3];
    int n_behind = 0;

    TEST_WANTS_RAM(sizeof(test_boards) + 20000);
    test_boards_make(&b, &rng, 4, 6, 4, NOISE, 0);
    const rigcal_transform rig_from_last = test_inverse(&b.true_cams[3]);
    test_to_double(centre, rig_from_last.t, 3);
    test_to_double(middle, b.true_places[0].t, 3);
    b.true_places[F] = test_inverse(&b.true_cams[0]); /* turned towards camera 0 */
    for (int k = 0; k < 3; k++) {
        b.true_places[F].t[k] = RC(centre[k] + 0.08 * (centre[k] - middle[k]));
    }
    for (int c = 0; c < 4; c++) {
        const rigcal_transform T = test_times(&b.true_cams[c], &b.true_places[F]);
        const int v = test_boards_view(&b, c, F);

        for (int i = 0; i < BOARD_POINTS; i++) {
            double X_c[3], uv[2];

            test_move_point(X_c, &T, b.X[i]);
            TEST_ASSERT_TRUE(c > 1 || X_c[2] > 0);
            n_behind += c == 3 && X_c[2] < 0;
            test_project_px(uv, &b.camera, X_c);
            for (int k = 0; k < 2; k++) {
                b.o[v][i].uv[k] = RC(uv[k] + NOISE * test_normal(&rng));
            }
        }
        if (c > 1) {
            test_boards_replace(&b, v, test_boards_view(&b, c, 0));
        }
    }
    TEST_ASSERT_TRUE(n_behind > 0);
    judge();
    for (int c = 0; c < 4; c++) {
        const int v = test_boards_view(&b, c, F);

        TEST_ASSERT_EQUAL_INT(c > 1, b.left_out[v] != 0);
        if (c == 3) {
            ASSERT_NEAR(-1, b.judged[v].rms_px, 0);
        }
        TEST_ASSERT_TRUE(c < 2 ? D(b.judged[v].rms_px) > 0 && D(b.judged[v].rms_px) < 1
                               : D(b.judged[v].cost) > 1);
    }
}

/* ---- the limit --------------------------------------------------------------- */

/* What EQUATIONS.md JUDGE says of the scale, from the costs that were reported. *n_small:
 * how many views cost less than sigma^2. */
static double scale_of_costs(int n_free, int *n_small)
{
    double costs[BOARD_VIEWS_MAX], n_places = 0;
    int n = 0;

    *n_small = 0;
    for (size_t v = 0; v < b.rig.n_views; v++) {
        if (b.judged[v].verdict == RIGCAL_VIEW_FITS) {
            const double cost = LIMIT * D(b.judgement.scale) * D(b.judged[v].cost);
            int at = n++;

            for (; at > 0 && costs[at - 1] > cost; at--) {
                costs[at] = costs[at - 1];
            }
            costs[at] = cost;
            *n_small += cost < 1;
            n_places += v == 0 || b.views[v].placement != b.views[v - 1].placement;
        }
    }
    const double median = (costs[(n - 1) / 2] + costs[n / 2]) / 2;
    const double checked = (n - n_free - n_places) / (n - n_places);

    return 1 + 10 * fmax(0, median / 5.35 / checked - 1);
}

/* Some placements are seen exactly, others with more noise than is stated. Camera 1 is held
 * in the second of each two trials. The last placement is seen by camera 0 alone; what was
 * in its cost does not count. */
static void test_the_scale_is_that_of_the_median_cost(void)
{
    static uint8_t roles[BOARD_CAMERAS_MAX];
    int n_above = 0, n_small = 0;

    TEST_WANTS_RAM(sizeof(test_boards) + 20000);
    for (int trial = 0; trial < 8; trial++) {
        test_rng rng = test_seed(970 + (uint64_t)trial);
        const int n_cameras = 2 + trial / 2, n_places = 10;
        int small;
        size_t n = 0;

        test_boards_make(&b, &rng, n_cameras, n_places, n_cameras, 0.01, 0);
        for (size_t v = 0; v < b.rig.n_views; v++) {
            const int f = b.views[v].placement;

            for (int i = 0; i < BOARD_POINTS && f > 2; i++) {
                b.o[v][i].uv[0] += (rigcal_real)(0.8 * test_normal(&rng));
                b.o[v][i].uv[1] += (rigcal_real)(0.8 * test_normal(&rng));
            }
            if (f < n_places - 1 || b.views[v].camera == 0) {
                b.views[n++] = b.views[v];
            }
        }
        b.rig.n_views = n;
        test_boards_solve(&b);
        roles[1] = trial % 2 ? RIGCAL_CAMERA_HELD : RIGCAL_CAMERA_FREE;
        b.rig.roles = roles;
        b.choice.sigma_px = RC(NOISE);
        for (size_t v = 0; v < n; v++) {
            b.judged[v].cost = 1000;
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_judge(&b.judgement, NULL, b.judged, b.left_out,
                                                  &b.choice, &b.rig));
        TEST_ASSERT_EQUAL_INT32(RIGCAL_VIEW_UNCHECKED, b.judged[n - 1].verdict);
        ASSERT_NEAR(0, b.judged[n - 1].cost, 0);
        TEST_ASSERT_EQUAL_UINT8(0, b.left_out[n - 1]);
        const double scale = scale_of_costs(n_cameras - 1, &small);
        ASSERT_NEAR(scale, b.judgement.scale, TOL(1e-9, 1e-3) * scale);
        n_above += scale > 1.1;
        n_small += scale > 1.1 ? small : 0;
    }
    TEST_ASSERT_TRUE(n_above > 3);
    TEST_ASSERT_TRUE(n_small > 0);
}

/* Judges a ring of cameras of which each two neighbours see a placement. It closes one
 * cycle. Its 12 views fit. */
static void judge_ring(uint64_t seed, double stated)
{
    test_rng rng = test_seed(seed);
    size_t n = 0;

    test_boards_make(&b, &rng, 6, 6, 6, NOISE, 0);
    for (size_t v = 0; v < b.rig.n_views; v++) {
        const int c = b.views[v].camera, f = b.views[v].placement;

        if (c == f || c == (f + 1) % 6) {
            b.views[n++] = b.views[v];
        }
    }
    b.rig.n_views = n;
    test_boards_solve(&b);
    b.choice.sigma_px = RC(stated);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_judge(&b.judgement, NULL, b.judged, b.left_out,
                                              &b.choice, &b.rig));
    TEST_ASSERT_EQUAL_INT32(12, b.judgement.n_fit);
}

/* The views agree far better than the stated noise, so the limit is that of noise
 * alone. */
static void test_views_that_agree_better_than_noise_do_not_raise_the_limit(void)
{
    TEST_WANTS_RAM(sizeof(test_boards) + 20000);
    judge_ring(980, 10 * NOISE);
    ASSERT_NEAR(1, b.judgement.scale, 0);
}

/* Half of the noise is stated. One cycle is enough to show by how much more than that the
 * views differ. */
static void test_one_cycle_shows_the_scale(void)
{
    int n_small;

    TEST_WANTS_RAM(sizeof(test_boards) + 20000);
    judge_ring(983, NOISE / 2);
    const double scale = scale_of_costs(5, &n_small);
    TEST_ASSERT_TRUE(scale > 1.1);
    ASSERT_NEAR(scale, b.judgement.scale, TOL(1e-9, 1e-3) * scale);
}

/* Two cameras that are held, with n_places placements. All numbers of the first three are
 * sums of powers of two, so their residuals are 0 to the last bit. The others have
 * noise. */
static void make_exact(test_rng *rng, int n_places)
{
    static const double ONE[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    static uint8_t roles[2] = {RIGCAL_CAMERA_HELD, RIGCAL_CAMERA_HELD};

    test_boards_make(&b, rng, 2, n_places, 2, NOISE, 0);
    b.camera.fx = b.camera.fy = 512;
    b.camera.cx = 640;
    b.camera.cy = 480;
    for (int c = 0; c < 2; c++) {
        const double t[3] = {-0.5 * c, 0, 0};

        b.true_cams[c] = test_transform(ONE, t);
    }
    for (int f = 0; f < n_places; f++) {
        const double t[3] = {0.25 * (f % 2), 0.125 * f - 0.25, f == 2 ? 4 : 2};

        b.true_places[f] = test_transform(ONE, t);
    }
    for (size_t v = 0; v < b.rig.n_views; v++) {
        const int f = b.views[v].placement;
        const rigcal_transform T =
            test_times(&b.true_cams[b.views[v].camera], &b.true_places[f]);

        for (int i = 0; i < BOARD_POINTS; i++) {
            double X_c[3], uv[2];

            b.o[v][i].X_w[1] = RC(0.25 * (i / 5) - 0.25);
            X_c[0] = D(b.o[v][i].X_w[0]) + D(T.t[0]);
            X_c[1] = D(b.o[v][i].X_w[1]) + D(T.t[1]);
            X_c[2] = D(T.t[2]);
            for (int k = 0; k < 2; k++) {
                uv[k] = 512 * X_c[k] / X_c[2] + (k == 0 ? 640 : 480);
                uv[k] += f < 3 ? 0 : 2 * NOISE * test_normal(rng);
            }
            test_to_real(b.o[v][i].uv, uv, 2);
        }
    }
    test_boards_solve(&b);
    for (int v = 0; v < 6; v++) {
        const rigcal_transform T = test_times(&b.true_cams[b.views[v].camera],
                                              &b.true_places[b.views[v].placement]);

        ASSERT_STATUS(RIGCAL_OK, rigcal_view_pose_make(&b.own[v], &b.views[v], &T));
        ASSERT_NEAR(0, b.own[v].sse, 0);
    }
    b.rig.roles = roles;
}

/* A view that costs nothing is one of those of which the median is taken. */
static void test_a_cost_of_0_counts(void)
{
    TEST_WANTS_RAM(sizeof(test_boards) + 20000);
    for (int n_places = 5; n_places < 8; n_places += 2) {
        test_rng rng = test_seed(981);
        int n_small;

        make_exact(&rng, n_places);
        b.choice.sigma_px = RC(NOISE);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_judge(&b.judgement, NULL, b.judged, b.left_out,
                                                  &b.choice, &b.rig));
        TEST_ASSERT_EQUAL_INT32(2 * n_places, b.judgement.n_fit);
        for (int v = 0; v < 2 * n_places; v++) {
            TEST_ASSERT_EQUAL_INT(v < 6, !(D(b.judged[v].cost) > 0));
        }
        const double scale = scale_of_costs(0, &n_small);
        TEST_ASSERT_EQUAL_INT(n_places == 7, scale > 1.1);
        ASSERT_NEAR(scale, b.judgement.scale, TOL(1e-9, 1e-3) * scale);
        TEST_ASSERT_EQUAL_INT(6, n_small);
    }
}

/* ---- claims -------------------------------------------------------------------- */

/* The pose of the placement by a view, if the camera moved by d; then turn and shift of the
 * pivot from `from`. */
static void claimed(double move[6], const rigcal_transform *from, const double pivot[3],
                    const rigcal_transform *cam, const rigcal_transform *own,
                    const double d[6])
{
    double R[9], t[3], R_0[9], t_0[3], turn[9], back[9], at[3], at_0[3];

    test_transform_parts(R, t, cam);
    test_move(R, t, d);
    const rigcal_transform moved = test_transform(R, t), inverse = test_inverse(&moved);
    const rigcal_transform place = test_times(&inverse, own);
    test_transform_parts(R, t, &place);
    test_transform_parts(R_0, t_0, from);
    test_transpose(back, R_0);
    test_product(turn, R, back);
    test_apply(at, R, pivot, t);
    test_apply(at_0, R_0, pivot, t_0);
    move[0] = (turn[7] - turn[5]) / 2;
    move[1] = (turn[2] - turn[6]) / 2;
    move[2] = (turn[3] - turn[1]) / 2;
    for (int k = 0; k < 3; k++) {
        move[3 + k] = at[k] - at_0[k];
    }
}

/* The error of a claim with the camera's error has the camera's covariance more, as
 * difference quotients carry it over. */
static void test_a_claim_has_the_covariance_of_its_camera(void)
{
    static const double H = 1e-5;
    rigcal_judge_solver solver;
    test_rng rng = test_seed(982);

    TEST_WANTS_RAM(sizeof(test_boards) + 20000);
    if (RIGCAL_USE_FLOAT) {
        TEST_IGNORE_MESSAGE("differences of poses in float are too coarse");
    }
    test_boards_make(&b, &rng, 3, 5, 3, NOISE, 0);
    test_boards_solve(&b);
    b.choice.sigma_px = RC(NOISE);
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_judge_begin(&solver, b.judged, b.left_out, &b.choice, &b.rig));
    while (rigcal_judge_step(&solver, 1000) == RIGCAL_RUNNING) {
    }
    for (size_t v = 0; v < b.rig.n_views; v++) {
        const int c = b.views[v].camera;
        rigcal_real of_camera[36], with[36], without[36];
        double J[6][6], pivot[3];
        rc_claim claim[2];

        solver.placement = (size_t)b.views[v].placement;
        for (int i = 0; i < 2; i++) {
            ASSERT_STATUS(RIGCAL_OK, rc_judge_claim(&claim[i], &solver, v, 0, i));
        }
        rc_sym6_unpack(without, claim[0].Sigma);
        rc_sym6_unpack(with, claim[1].Sigma);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(of_camera, &b.rig, 1, (size_t)c));
        test_to_double(pivot, claim[0].pivot, 3);
        for (int k = 0; k < 6; k++) {
            double low[6], d[6] = {0, 0, 0, 0, 0, 0};

            d[k] = H;
            claimed(J[k], &claim[0].b_from_a, pivot, &b.cams[c], &b.own[v].cam_from_target,
                    d);
            d[k] = -H;
            claimed(low, &claim[0].b_from_a, pivot, &b.cams[c], &b.own[v].cam_from_target,
                    d);
            for (int i = 0; i < 6; i++) {
                J[k][i] = (J[k][i] - low[i]) / (2 * H);
            }
        }
        for (int i = 0; i < 36; i++) {
            double sum = 0;

            for (int k = 0; k < 36; k++) {
                sum += J[k / 6][i / 6] * D(of_camera[k]) * J[k % 6][i % 6];
            }
            ASSERT_NEAR(sum, D(with[i]) - D(without[i]),
                        1e-5 * sqrt(D(with[i / 6 * 7]) * D(with[i % 6 * 7])));
        }
    }
}

TEST_MAIN()
{
    RUN_TEST(test_a_view_costs_what_the_sum_falls_by_without_it);
    RUN_TEST(test_costs_of_noise_are_chi_squared);
    RUN_TEST(test_a_view_that_is_left_out_costs_what_the_sum_would_fall_by);
    RUN_TEST(test_a_view_that_is_left_out_costs_no_more_than_its_own_sum_rises);
    RUN_TEST(test_placements_without_views_cost_nothing);
    RUN_TEST(test_a_view_of_what_is_behind_its_camera_has_no_error);
    RUN_TEST(test_the_scale_is_that_of_the_median_cost);
    RUN_TEST(test_views_that_agree_better_than_noise_do_not_raise_the_limit);
    RUN_TEST(test_one_cycle_shows_the_scale);
    RUN_TEST(test_a_cost_of_0_counts);
    RUN_TEST(test_a_claim_has_the_covariance_of_its_camera);
}
