/* estimate: the intrinsics of the cameras with their deviations as a prior. The truth is
 * dense least squares in double over all poses and all intrinsics, by differences of the
 * projection. At the library's answer its next step must be 0, and its inverse normal
 * matrix must have all covariances. */
#include <math.h>
#include <string.h>

#include "rigcal_solvers.h"
#include "test_fit.h"
#include "test_rigs.h"

enum {
    CAMERAS = 3,
    PLACES = 5,
    BY = 6, /* numbers of a camera: focal, aspect, cx, cy, k1, k2 */
    POSES = 6 * (CAMERAS + PLACES),
    ALL = POSES + BY * CAMERAS,
    WORK = RIGCAL_ESTIMATE_WORK(CAMERAS, CAMERAS)
};

#define SIGMA_PX 0.3

/* In double the derivatives by f are those of the changed camera, which differ by 0.4 %. In
 * float the poses explain all but a thousandth of the effect of the intrinsics, and S^-1
 * has a rounding of some 1e-5: 1e-2 of what is left. */
#define PART TOL(0.01, 0.06)
#define WANTS TEST_WANTS_RAM(sizeof(test_rig) + 131072)

static test_rig r;
static rigcal_camera nominal[CAMERAS]; /* the results of a calibration program */
static rigcal_intrinsics_sigma sigmas[CAMERAS];
static rigcal_intrinsics_change made[CAMERAS], change[CAMERAS], left[CAMERAS];
static rigcal_real memory[WORK];
static rigcal_estimated estimated;
static uint8_t is_wrong[RIG_VIEWS_MAX][RIG_POINTS_MAX];

/* ---- the rig ------------------------------------------------------------------ */

static double sigma_of(int column)
{
    const rigcal_intrinsics_sigma *const s = &sigmas[column / BY];
    const rigcal_real by[BY] = {s->focal, s->aspect, s->centre, s->centre, s->k1, s->k2};

    return D(by[column % BY]);
}

static rigcal_real *number_of(rigcal_intrinsics_change *of, int which)
{
    rigcal_real *const by[BY] = {&of->focal, &of->aspect, &of->cx,
                                 &of->cy,    &of->k1,     &of->k2};

    return by[which];
}

static rigcal_camera changed(const rigcal_camera *camera, const double d[BY])
{
    rigcal_camera c = *camera;

    c.fx = RC(D(c.fx) * (1 + d[0] + d[1] / 2));
    c.fy = RC(D(c.fy) * (1 + d[0] - d[1] / 2));
    c.cx = RC(D(c.cx) + d[2]);
    c.cy = RC(D(c.cy) + d[3]);
    c.k1 = RC(D(c.k1) + d[4]);
    c.k2 = RC(D(c.k2) + d[5]);
    return c;
}

/* Makes views with r.camera. Then it changes r.camera, with known deviations. */
static void make(uint64_t seed)
{
    test_rng rng = test_seed(seed);

    test_rig_random(&r, &rng, CAMERAS, PLACES, 12);
    r.camera[2].lens = RIGCAL_LENS_FISHEYE;
    test_rig_see_all(&r, &rng, SIGMA_PX);
    for (int c = 0; c < CAMERAS; c++) {
        double d[BY];

        sigmas[c] =
            (rigcal_intrinsics_sigma){RC(0.003), RC(0.001), RC(3), RC(0.01), RC(0.03)};
        for (int k = 0; k < BY; k++) {
            d[k] = sigma_of(BY * c + k) * test_normal(&rng);
        }
        r.camera[c] = nominal[c] = changed(&r.camera[c], d);
    }
    r.rig.intrinsics_sigmas = sigmas;
    memset(made, 0, sizeof made);
    memset(is_wrong, 0, sizeof is_wrong);
    estimated = (rigcal_estimated){.considered = {.effects = memory, .capacity = WORK},
                                   .made = made,
                                   .change = change,
                                   .sigma = left};
}

static void adjust(void)
{
    rigcal_rig_fit fit;
    size_t n;

    for (int i = 0; i < 3; i++) {
        ASSERT_STATUS(RIGCAL_OK, estimated.considered.loss
                                     ? rigcal_rig_adjust_robust(&fit, &n, NULL, &r.rig)
                                     : rigcal_rig_adjust(&fit, NULL, &r.rig));
    }
}

/* `step` is the largest of (change - made) / sigma. */
static void assert_step(void)
{
    double largest = 0;

    for (int k = 0; k < BY * CAMERAS; k++) {
        const double by =
            D(*number_of(&change[k / BY], k % BY)) - D(*number_of(&made[k / BY], k % BY));
        const double sigma = D(*number_of(&left[k / BY], k % BY));

        largest = (sigma > 0) ? fmax(largest, fabs(by) / sigma) : largest;
    }
    ASSERT_NEAR(largest, estimated.step, TOL(1e-9, 1e-2) * (1 + largest));
}

/* Runs rounds until no step is longer than `limit`. Returns their number. */
static int settle(double limit)
{
    for (int round = 1; round <= 12; round++) {
        int32_t at_fault = -2;

        adjust();
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_rig_estimate(&estimated, &at_fault, &r.rig, RC(SIGMA_PX)));
        TEST_ASSERT_EQUAL_INT32(-1, at_fault);
        assert_step();
        if (D(estimated.step) < limit) {
            return round;
        }
        memcpy(made, change, sizeof made);
        for (int c = 0; c < CAMERAS; c++) {
            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_camera_change(&r.camera[c], &nominal[c], &made[c]));
        }
    }
    TEST_FAIL_MESSAGE("it does not settle");
    return 0;
}

/* ---- dense least squares -------------------------------------------------------- */

/* The normal matrix over all unknowns, with its right side in the last column; then its
 * inverse. */
static double A[ALL][ALL + 1], inverse[ALL][ALL];

/* The pixel of point i of a view, after everything that it depends on moved. */
static void pixel(double uv[2], const rigcal_rig_view *v, int i, const double d[18])
{
    double R[9], t[3], X[3], X_r[3], X_c[3], all[BY];
    rigcal_intrinsics_change so_far = made[v->camera];

    test_to_double(X, v->view.observations[i].X_w, 3);
    test_transform_parts(R, t, &r.places[v->placement]);
    test_move(R, t, &d[6]);
    test_apply(X_r, R, X, t);
    test_transform_parts(R, t, &r.cams[v->camera]);
    test_move(R, t, &d[0]);
    test_apply(X_c, R, X_r, t);
    for (int k = 0; k < BY; k++) {
        all[k] = D(*number_of(&so_far, k)) + d[12 + k];
    }
    const rigcal_camera camera = changed(&nominal[v->camera], all);
    test_project_px(uv, &camera, X_c);
}

/* The projection is linear in the intrinsics, so a step may have any length. */
static void add_point(const rigcal_rig_view *v, int i)
{
    static const double STEPS[BY] = {0.125, 0.25, 16, 16, 0.125, 0.125};
    int at[18];
    double rows[2][18], there[2], zero[18] = {0};

    pixel(there, v, i, zero);
    for (int k = 0; k < 18; k++) {
        const double step = (k < 12) ? 1e-4 : STEPS[k - 12];
        double d[18] = {0}, up[2], down[2];

        at[k] = (k < 6)    ? 6 * v->camera + k
                : (k < 12) ? 6 * CAMERAS + 6 * v->placement + k - 6
                           : POSES + BY * v->camera + k - 12;
        d[k] = step;
        pixel(up, v, i, d);
        d[k] = -step;
        pixel(down, v, i, d);
        for (int row = 0; row < 2; row++) {
            rows[row][k] = (k < 6 && v->camera == 0)
                               ? 0
                               : (up[row] - down[row]) / (2 * step) / SIGMA_PX;
        }
    }
    for (int row = 0; row < 2; row++) {
        const double e = (D(v->view.observations[i].uv[row]) - there[row]) / SIGMA_PX;

        for (int a = 0; a < 18; a++) {
            for (int b = 0; b < 18; b++) {
                A[at[a]][at[b]] += rows[row][a] * rows[row][b];
            }
            A[at[a]][ALL] += rows[row][a] * e;
        }
    }
}

static void invert(void)
{
    memset(inverse, 0, sizeof inverse);
    for (int i = 0; i < ALL; i++) {
        inverse[i][i] = 1;
    }
    for (int p = 0; p < ALL; p++) {
        const double by = 1 / A[p][p];

        for (int b = 0; b < ALL; b++) {
            A[p][b] *= by;
            inverse[p][b] *= by;
        }
        for (int a = 0; a < ALL; a++) {
            const double part = A[a][p];

            for (int b = 0; b < ALL && a != p; b++) {
                A[a][b] -= part * A[p][b];
                inverse[a][b] -= part * inverse[p][b];
            }
        }
    }
}

/* A deviation of 0 is replaced by a millionth of the others. */
static void solve_dense(void)
{
    static const double LEAST[BY] = {1e-9, 1e-9, 1e-6, 1e-9, 1e-9, 1e-9};

    memset(A, 0, sizeof A);
    for (size_t v = 0; v < r.rig.n_views; v++) {
        for (int i = 0; i < r.n_points; i++) {
            if (!is_wrong[v][i]) {
                add_point(&r.views[v], i);
            }
        }
    }
    for (int a = 0; a < 6; a++) {
        A[a][a] = 1;
    }
    for (int k = 0; k < BY * CAMERAS; k++) {
        const double s = fmax(sigma_of(k), LEAST[k % BY]);

        A[POSES + k][POSES + k] += 1 / (s * s);
        A[POSES + k][ALL] -= D(*number_of(&made[k / BY], k % BY)) / (s * s);
    }
    invert();
}

static void assert_block(int row, const rigcal_real Sigma[36])
{
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++) {
            const double size = sqrt(inverse[row + i][row + i] * inverse[row + j][row + j]);

            ASSERT_NEAR(inverse[row + i][row + j], Sigma[6 * i + j], PART * size);
        }
    }
}

static void assert_intrinsics(void)
{
    solve_dense();
    for (int k = 0; k < BY * CAMERAS; k++) {
        const double after = sqrt(inverse[POSES + k][POSES + k]);
        double step = 0;

        for (int b = 0; b < ALL; b++) {
            step += inverse[POSES + k][b] * A[b][ALL];
        }
        if (sigma_of(k) > 0) {
            ASSERT_NEAR(after, *number_of(&left[k / BY], k % BY), PART * after);
            ASSERT_NEAR(0, step / after, 2 * PART);
        }
    }
}

static void assert_cameras(void)
{
    rigcal_real Sigma[36];

    for (int c = 1; c < CAMERAS; c++) {
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_rig_covariance(Sigma, &r.rig, RC(SIGMA_PX), (size_t)c));
        assert_block(6 * c, Sigma);
    }
}

static void assert_minimum(void)
{
    rigcal_real Sigma[36];

    assert_intrinsics();
    assert_cameras();
    for (int f = 0; f < PLACES; f++) {
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_rig_placement(Sigma, &r.rig, RC(SIGMA_PX), (size_t)f));
        assert_block(6 * (CAMERAS + f), Sigma);
    }
}

/* ---- tests ---------------------------------------------------------------------- */

static void test_the_answer_is_that_of_dense_least_squares(void)
{
    WANTS;
    for (uint64_t trial = 0; trial < (uint64_t)TEST_TRIALS(3); trial++) {
        double moved = 0;

        make(8801 + trial);
        (void)settle(TOL(1e-4, 2e-2));
        for (int k = 0; k < BY * CAMERAS; k++) {
            moved = fmax(moved, fabs(D(*number_of(&made[k / BY], k % BY)) / sigma_of(k)));
        }
        TEST_ASSERT_TRUE(moved > 0.5);
        assert_minimum();
        ASSERT_NEAR(0, estimated.considered.sum, 0); /* the fit is that of the estimate */
        ASSERT_NEAR(0, estimated.considered.own_sum, 0);
    }
}

/* A point of each view is 60 sigma and more from where it should be. The limit is 4 times
 * 0.5 px, which no other point reaches. */
static void test_points_that_a_robust_adjustment_left_out_do_not_count(void)
{
    WANTS;
    make(8806);
    r.rig.sigma_px = RC(0.5);
    estimated.considered.loss = RIGCAL_LOSS_TRUNCATED;
    for (size_t v = 0; v < r.rig.n_views; v++) {
        const size_t i = 5 * v % 12;

        is_wrong[v][i] = 1;
        r.o[v][i].uv[v % 2] += (v % 3 == 0) ? RC(-30) : RC(40);
    }
    (void)settle(TOL(1e-4, 2e-2));
    assert_intrinsics();
    assert_cameras();
}

static void test_it_settles_in_a_few_rounds(void)
{
    WANTS;
    for (uint64_t trial = 0; trial < (uint64_t)TEST_TRIALS(5); trial++) {
        make(8811 + trial);
        TEST_ASSERT_LESS_OR_EQUAL_INT(4, settle(0.1));
    }
}

static void test_what_has_no_deviation_does_not_move(void)
{
    WANTS;
    make(8821);
    memset(&sigmas[1], 0, sizeof sigmas[1]);
    sigmas[0].centre = 0;
    sigmas[2].focal = sigmas[2].k2 = 0;
    (void)settle(TOL(1e-4, 2e-2));
    for (int k = 0; k < BY * CAMERAS; k++) {
        if (!(sigma_of(k) > 0)) {
            ASSERT_NEAR(0, *number_of(&made[k / BY], k % BY), 0);
            ASSERT_NEAR(0, *number_of(&left[k / BY], k % BY), 0);
        }
    }
    assert_minimum();
}

static void test_a_single_number_is_estimated(void)
{
    WANTS;
    make(8822);
    for (int c = 0; c < CAMERAS; c++) {
        sigmas[c] = (rigcal_intrinsics_sigma){.k1 = c == 2 ? sigmas[c].k1 : 0};
    }
    (void)settle(TOL(1e-4, 2e-2));
    assert_minimum();
}

/* Beside one number the poses need the longer row. What lies behind it is not touched. */
static void test_the_least_memory_of_a_single_number_is_enough(void)
{
    const size_t k = 1, n = 6 * (CAMERAS - 1);
    const size_t needs = (n + 6) * k + k * (k + 1) / 2 + k + n;

    WANTS;
    make(8823);
    memset(sigmas, 0, sizeof sigmas);
    sigmas[1].k1 = RC(0.01);
    adjust();
    estimated.considered.capacity = needs - 1;
    ASSERT_STATUS(RIGCAL_ERR_CAPACITY,
                  rigcal_rig_estimate(&estimated, NULL, &r.rig, RC(SIGMA_PX)));
    estimated.considered.capacity = needs;
    memory[needs] = 77;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_estimate(&estimated, NULL, &r.rig, RC(SIGMA_PX)));
    ASSERT_NEAR(77, memory[needs], 0);
}

static void test_without_any_deviation_the_covariance_is_that_of_pixels(void)
{
    rigcal_real plain[36], with[36];

    WANTS;
    make(8831);
    memset(sigmas, 0, sizeof sigmas);
    adjust();
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(plain, &r.rig, RC(SIGMA_PX), 1));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_estimate(&estimated, NULL, &r.rig, RC(SIGMA_PX)));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(with, &r.rig, RC(SIGMA_PX), 1));
    TEST_ASSERT_EQUAL_MEMORY(plain, with, sizeof plain);
    ASSERT_NEAR(0, estimated.step, 0);
}

static void assert_refused_at(int32_t at, rigcal_status expected, double sigma_px)
{
    rigcal_intrinsics_change kept[CAMERAS];
    int32_t at_fault = -2;

    memset(change, 0x55, sizeof change);
    memcpy(kept, change, sizeof kept);
    ASSERT_STATUS(expected,
                  rigcal_rig_estimate(&estimated, &at_fault, &r.rig, RC(sigma_px)));
    TEST_ASSERT_EQUAL_MEMORY(kept, change, sizeof kept);
    TEST_ASSERT_NULL(r.rig.considered);
    TEST_ASSERT_EQUAL_INT32(at, at_fault);
}

static void assert_refused(rigcal_status expected, double sigma_px)
{
    assert_refused_at(-1, expected, sigma_px);
}

static void test_what_cannot_be_is_refused(void)
{
    static rigcal_rig_clocks clocks;
    const size_t k = BY * CAMERAS, n = 6 * (CAMERAS - 1);
    const size_t needs = (n + 6) * k + k * (k + 1) / 2 + 2 * k;

    WANTS;
    make(8841);
    assert_refused(RIGCAL_ERR_STATE, 0.3);
    adjust();
    assert_refused(RIGCAL_ERR_RANGE, 0);
    assert_refused(RIGCAL_ERR_RANGE, -1);
    assert_refused(RIGCAL_ERR_NOT_FINITE, (double)TEST_NAN);
    made[1].k1 = TEST_INF;
    assert_refused_at(1, RIGCAL_ERR_NOT_FINITE, 0.3);
    made[1].k1 = 0;
    r.rig.clocks = &clocks;
    assert_refused(RIGCAL_ERR_STATE, 0.3);
    r.rig.clocks = NULL;
    r.o[4][3].uv[1] = TEST_NAN;
    assert_refused_at(4, RIGCAL_ERR_NOT_FINITE, 0.3);
    make(8841);
    adjust();
    TEST_ASSERT_EQUAL_UINT64(WORK, rigcal_estimate_work(CAMERAS, CAMERAS));
    estimated.considered.capacity = needs - 1;
    assert_refused(RIGCAL_ERR_CAPACITY, 0.3);
    estimated.considered.capacity = needs;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_estimate(&estimated, NULL, &r.rig, RC(0.3)));
}

static void test_a_camera_is_changed_or_left_as_it_is(void)
{
    const rigcal_intrinsics_change by = {RC(0.5), RC(0.25), 3, -2, RC(0.01), RC(0.02)};
    const rigcal_intrinsics_change too_much = {-1, 0, 0, 0, 0, 0};
    rigcal_intrinsics_change bad = by;

    WANTS;
    make(8851);
    rigcal_camera out = nominal[0];
    ASSERT_STATUS(RIGCAL_OK, rigcal_camera_change(&out, &nominal[0], &by));
    ASSERT_NEAR(1.625 * D(nominal[0].fx), out.fx, TOL(1e-9, 1e-3));
    ASSERT_NEAR(1.375 * D(nominal[0].fy), out.fy, TOL(1e-9, 1e-3));
    ASSERT_NEAR(3 + D(nominal[0].cx), out.cx, TOL(1e-9, 1e-3));
    ASSERT_NEAR(-2 + D(nominal[0].cy), out.cy, TOL(1e-9, 1e-3));
    ASSERT_NEAR(0.01 + D(nominal[0].k1), out.k1, TOL(1e-12, 1e-6));
    ASSERT_NEAR(0.02 + D(nominal[0].k2), out.k2, TOL(1e-12, 1e-6));
    out = nominal[0];
    ASSERT_STATUS(RIGCAL_ERR_CAMERA, rigcal_camera_change(&out, &nominal[0], &too_much));
    bad.cy = TEST_NAN;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rigcal_camera_change(&out, &nominal[0], &bad));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_camera_change(&out, &nominal[0], NULL));
    TEST_ASSERT_EQUAL_MEMORY(&nominal[0], &out, sizeof out);
}

TEST_MAIN()
{
    RUN_TEST(test_the_answer_is_that_of_dense_least_squares);
    RUN_TEST(test_points_that_a_robust_adjustment_left_out_do_not_count);
    RUN_TEST(test_it_settles_in_a_few_rounds);
    RUN_TEST(test_what_has_no_deviation_does_not_move);
    RUN_TEST(test_a_single_number_is_estimated);
    RUN_TEST(test_the_least_memory_of_a_single_number_is_enough);
    RUN_TEST(test_without_any_deviation_the_covariance_is_that_of_pixels);
    RUN_TEST(test_what_cannot_be_is_refused);
    RUN_TEST(test_a_camera_is_changed_or_left_as_it_is);
}
