/* consider: what inexact intrinsics add to the covariances of a rig. The truth is dense
 * least squares in double, by differences of the projection, with the rows of all poses and
 * of the intrinsics; and also the adjustment itself with other intrinsics. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rigcal_solvers.h"
#include "test_fit.h"
#include "test_motions.h"
#include "test_rigs.h"

enum {
    CAMERAS = 4,
    PLACES = 5,
    BY = 6, /* numbers of a camera: focal, aspect, cx, cy, k1, k2 */
    POSES = 6 * (CAMERAS + PLACES),
    COLUMNS = BY * CAMERAS,
    WORK = RIGCAL_CONSIDER_WORK(CAMERAS, CAMERAS)
};

static test_rig r;
static rigcal_intrinsics_sigma sigmas[CAMERAS];
static rigcal_real effects[WORK], spreads[RIG_POINTS_MAX];
static rigcal_considered considered;
static int is_huber; /* whether the truth weighs points as Huber does */
static uint8_t left_out[RIG_VIEWS_MAX], is_wrong[RIG_VIEWS_MAX][RIG_POINTS_MAX];

#define WANTS TEST_WANTS_RAM(sizeof(test_rig) + 65536)

/* ---- the rig ----------------------------------------------------------------- */

static double uniform(test_rng *rng, double from, double to)
{
    return (double)(float)test_uniform(rng, from, to);
}

static void set_sigmas(test_rng *rng)
{
    for (int c = 0; c < CAMERAS; c++) {
        sigmas[c].focal = RC(uniform(rng, 0.001, 0.004));
        sigmas[c].aspect = RC(uniform(rng, 0.0005, 0.002));
        sigmas[c].centre = RC(uniform(rng, 1, 4));
        sigmas[c].k1 = RC(uniform(rng, 0.005, 0.02));
        sigmas[c].k2 = RC(uniform(rng, 0.01, 0.04));
    }
}

/* Lenses of both models, sigmas of points, views that are missing or left out. */
static void make(uint64_t seed)
{
    test_rng rng = test_seed(seed);
    size_t kept = 0;

    test_rig_random(&r, &rng, CAMERAS, PLACES, 12);
    r.camera[1].k4 = RC(0.05);
    r.camera[1].p1 = RC(0.01);
    r.camera[2].lens = RIGCAL_LENS_FISHEYE;
    test_rig_see_all(&r, &rng, 0.3);
    for (size_t v = 0; v < r.rig.n_views; v++) {
        if (v != 6) { /* camera 2 has not seen placement 1 */
            r.views[kept++] = r.views[v];
        }
    }
    r.rig.n_views = kept;
    for (int i = 0; i < r.n_points; i++) {
        spreads[i] = RC(uniform(&rng, 0.5, 2));
    }
    for (size_t v = 0; v < kept; v++) {
        r.views[v].view.sigma = spreads;
    }
    memset(left_out, 0, sizeof left_out);
    memset(is_wrong, 0, sizeof is_wrong);
    is_huber = 0;
    left_out[9] = 1;
    r.rig.left_out = left_out;
    set_sigmas(&rng);
    r.rig.intrinsics_sigmas = sigmas;
    considered = (rigcal_considered){.effects = effects, .capacity = WORK};
}

/* An adjustment computes its covariance at the poses before its last step. From the optimum
 * these are the same, so the rig is adjusted again. */
static void adjust(void)
{
    rigcal_rig_fit fit;

    for (int i = 0; i < 3; i++) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &r.rig));
    }
}

static void adjust_and_consider(void)
{
    int32_t at_fault = -2;

    adjust();
    TEST_ASSERT_NULL(r.rig.considered);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
}

/* ---- dense least squares -------------------------------------------------------- */

static double sigma_of(int column)
{
    const rigcal_intrinsics_sigma *const s = &sigmas[column / BY];
    const rigcal_real by[BY] = {s->focal, s->aspect, s->centre, s->centre, s->k1, s->k2};

    return D(by[column % BY]);
}

static rigcal_camera changed(const rigcal_camera *camera, int which, double step)
{
    rigcal_camera c = *camera;

    switch (which) {
    case 0:
        c.fx = RC(D(c.fx) * (1 + step));
        c.fy = RC(D(c.fy) * (1 + step));
        break;
    case 1:
        c.fx = RC(D(c.fx) * (1 + step / 2));
        c.fy = RC(D(c.fy) * (1 - step / 2));
        break;
    case 2:
        c.cx = RC(D(c.cx) + step);
        break;
    case 3:
        c.cy = RC(D(c.cy) + step);
        break;
    case 4:
        c.k1 = RC(D(c.k1) + step);
        break;
    default:
        c.k2 = RC(D(c.k2) + step);
        break;
    }
    return c;
}

/* The pixel of point i of a view, after its camera and placement moved. */
static void pixel(double uv[2], const rigcal_rig_view *v, int i, const rigcal_camera *lens,
                  const double d_camera[6], const double d_place[6])
{
    double R[9], t[3], X[3], X_r[3], X_c[3];

    test_to_double(X, v->view.observations[i].X_w, 3);
    test_transform_parts(R, t, &r.places[v->placement]);
    test_move(R, t, d_place);
    test_apply(X_r, R, X, t);
    test_transform_parts(R, t, &r.cams[v->camera]);
    test_move(R, t, d_camera);
    test_apply(X_c, R, X_r, t);
    test_project_px(uv, lens, X_c);
}

/* M = J^T J and J^T D over all poses, and D^T D of each column. The first `fixed` cameras
 * have no unknowns. */
static double M[POSES][POSES + COLUMNS], left[COLUMNS];

/* The root of the weight of a point, over its sigma_i. The weight is 1 up to 2 sigma, and
 * falls as 1 / error beyond. */
static double root_weight(const rigcal_rig_view *v, int i)
{
    static const double NOTHING[6] = {0};
    const double s = D(v->view.sigma[i]), limit = 2 * s * D(r.rig.sigma_px);
    double uv[2];

    pixel(uv, v, i, &r.camera[v->camera], NOTHING, NOTHING);
    const double off = hypot(uv[0] - D(v->view.observations[i].uv[0]),
                             uv[1] - D(v->view.observations[i].uv[1]));
    return (is_huber && off > limit ? sqrt(limit / off) : 1) / s;
}

static void add_point(const rigcal_rig_view *v, int i, int fixed)
{
    static const double NOTHING[6] = {0};
    const double step = 1e-5, s = 1 / root_weight(v, i);
    const int c = v->camera, f = v->placement;
    double rows[2][POSES + COLUMNS];

    memset(rows, 0, sizeof rows);
    for (int k = 0; k < 12; k++) {
        double d[6] = {0}, up[2], down[2];
        const int is_camera = k < 6;
        const int at = is_camera ? 6 * c + k : 6 * CAMERAS + 6 * f + k - 6;

        d[k % 6] = step;
        pixel(up, v, i, &r.camera[c], is_camera ? d : NOTHING, is_camera ? NOTHING : d);
        d[k % 6] = -step;
        pixel(down, v, i, &r.camera[c], is_camera ? d : NOTHING, is_camera ? NOTHING : d);
        for (int row = 0; row < 2 && !(is_camera && c < fixed); row++) {
            rows[row][at] = (up[row] - down[row]) / (2 * step) / s;
        }
    }
    for (int k = 0; k < BY; k++) {
        const rigcal_camera more = changed(&r.camera[c], k, 0.5);
        double up[2], there[2];

        pixel(up, v, i, &more, NOTHING, NOTHING);
        pixel(there, v, i, &r.camera[c], NOTHING, NOTHING);
        for (int row = 0; row < 2; row++) {
            rows[row][POSES + BY * c + k] = (up[row] - there[row]) / 0.5 / s;
        }
    }
    for (int row = 0; row < 2; row++) {
        for (int a = 0; a < POSES; a++) {
            for (int b = 0; b < POSES + COLUMNS && rows[row][a] != 0; b++) {
                M[a][b] += rows[row][a] * rows[row][b];
            }
        }
        for (int k = 0; k < COLUMNS; k++) {
            left[k] += pow(rows[row][POSES + k], 2);
        }
    }
}

/* Solves for the effects of all deviations on all poses by views first .. end - 1, in the
 * last columns of M. What is left of D^T D is the sum of squares that no poses explain. */
static void solve_views(int fixed, size_t first, size_t end)
{
    memset(M, 0, sizeof M);
    memset(left, 0, sizeof left);
    for (size_t v = first; v < end; v++) {
        for (int i = 0; i < r.n_points && !left_out[v]; i++) {
            if (!is_wrong[v][i]) {
                add_point(&r.views[v], i, fixed);
            }
        }
    }
    for (int a = 0; a < POSES; a++) { /* unknowns on which nothing depends */
        M[a][a] = (M[a][a] > 0) ? M[a][a] : 1;
    }
    for (int c = 0; c < CAMERAS; c++) { /* information of a prior, sigma_px^2 Sigma^-1 */
        for (int k = 0; k < 6 && r.roles[c] == RIGCAL_CAMERA_PRIOR; k++) {
            const double v = D(r.rig.sigma_px) * D(r.rig.sigma_px);

            M[6 * c + k][6 * c + k] += v / D(r.priors[c].Sigma[7 * k]);
        }
    }
    for (int p = 0; p < POSES; p++) {
        const double by = 1 / M[p][p];

        for (int k = 0; k < COLUMNS; k++) {
            left[k] -= by * pow(M[p][POSES + k], 2);
        }
        for (int b = p; b < POSES + COLUMNS; b++) {
            M[p][b] *= by;
        }
        for (int a = 0; a < POSES; a++) {
            const double part = M[a][p];

            for (int b = p; b < POSES + COLUMNS && a != p && part != 0; b++) {
                M[a][b] -= part * M[p][b];
            }
        }
    }
}

/* The sum of squares that the deviations are expected to leave. */
static double sum_left(void)
{
    double sum = 0;

    for (int k = 0; k < COLUMNS; k++) {
        sum += sigma_of(k) * sigma_of(k) * left[k];
    }
    return sum;
}

/* The same of all views, each with a pose of its own. */
static double own_sum_left(void)
{
    double sum = 0;

    for (size_t v = 0; v < r.rig.n_views; v++) {
        solve_views(CAMERAS, v, v + 1);
        sum += sum_left();
    }
    return sum;
}

/* Adds v v^T for each column, where v is the effect of one deviation. */
static void spread(double Sigma[36], int row_a, int row_b)
{
    memset(Sigma, 0, 36 * sizeof *Sigma);
    for (int k = 0; k < COLUMNS; k++) {
        for (int i = 0; i < 6; i++) {
            for (int j = 0; j < 6; j++) {
                Sigma[6 * i + j] += M[row_a + i][POSES + k] * M[row_b + j][POSES + k] *
                                    sigma_of(k) * sigma_of(k);
            }
        }
    }
}

static void spread_of_pair(double Sigma[36], int a, int b)
{
    double R_a[9], t_a[3], R_b[9], t_b[3], R_ab[9], t_ab[3], R_i[9];

    memset(Sigma, 0, 36 * sizeof *Sigma);
    for (int k = 0; k < COLUMNS; k++) {
        const double step = 1e-4 * sigma_of(k);
        double v[2][6] = {{0}, {0}}, d[2][9 + 3], d_pair[6];

        for (int sign = -1; sign <= 1; sign += 2) {
            for (int i = 0; i < 6; i++) {
                v[0][i] = sign * step * M[6 * a + i][POSES + k];
                v[1][i] = sign * step * M[6 * b + i][POSES + k];
            }
            test_transform_parts(R_a, t_a, &r.cams[a]);
            test_transform_parts(R_b, t_b, &r.cams[b]);
            test_move(R_a, t_a, v[0]);
            test_move(R_b, t_b, v[1]);
            test_transpose(R_i, R_a);
            test_product(R_ab, R_b, R_i);
            test_apply(t_ab, R_ab, t_a, NULL);
            memcpy(d[sign > 0], R_ab, sizeof R_ab);
            for (int i = 0; i < 3; i++) {
                d[sign > 0][9 + i] = t_b[i] - t_ab[i];
            }
        }
        test_difference(d_pair, d[0], &d[0][9], d[1], &d[1][9]);
        for (int i = 0; i < 36 && step > 0; i++) {
            Sigma[i] += d_pair[i / 6] * d_pair[i % 6] / (4 * 1e-8);
        }
    }
}

static void assert_part(const double expected[36], const rigcal_real seen[36], double part)
{
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++) {
            const double size = sqrt(expected[7 * i] * expected[7 * j]);

            ASSERT_NEAR(expected[6 * i + j], seen[6 * i + j], part * size);
        }
    }
}

#define PART TOL(2e-7, 2e-3)
#define SUM_PART TOL(1e-7, 0.04) /* sums are differences of large numbers */

/* With sigma_px 0 the covariance has only this part. */
static void assert_all(int fixed)
{
    double expected[36];
    rigcal_real Sigma[36];
    rigcal_transform pair;

    solve_views(fixed, 0, r.rig.n_views);
    ASSERT_NEAR(sum_left(), considered.sum, SUM_PART * sum_left());
    for (int a = 0; a < CAMERAS; a++) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(Sigma, &r.rig, 0, (size_t)a));
        spread(expected, 6 * a, 6 * a);
        assert_part(expected, Sigma, PART);
        for (int b = 0; b < CAMERAS; b++) {
            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_rig_pair(&pair, Sigma, &r.rig, 0, (size_t)a, (size_t)b));
            spread_of_pair(expected, a, b);
            if (a != b && (a >= fixed || b >= fixed)) {
                assert_part(expected, Sigma, 2 * PART);
            }
        }
    }
    for (int f = 0; f < PLACES; f++) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_placement(Sigma, &r.rig, 0, (size_t)f));
        spread(expected, 6 * (CAMERAS + f), 6 * (CAMERAS + f));
        assert_part(expected, Sigma, PART);
    }
    ASSERT_NEAR(own_sum_left(), considered.own_sum, SUM_PART * own_sum_left());
}

static void test_the_effects_are_those_of_dense_least_squares(void)
{
    WANTS;
    for (uint64_t trial = 0; trial < (uint64_t)TEST_TRIALS(3); trial++) {
        make(7301 + trial);
        adjust_and_consider();
        TEST_ASSERT_EQUAL_UINT64(COLUMNS, considered.k);
        assert_all(1);
    }
}

static void test_cameras_with_exact_intrinsics_have_no_columns(void)
{
    WANTS;
    make(7311);
    memset(&sigmas[0], 0, sizeof sigmas[0]);
    sigmas[1].centre = sigmas[1].k1 = 0;
    sigmas[3].focal = 0;
    adjust_and_consider();
    TEST_ASSERT_EQUAL_UINT64(COLUMNS - 6 - 3 - 1, considered.k);
    assert_all(1);
}

static void test_held_cameras_move_placements_and_other_cameras(void)
{
    WANTS;
    for (int held = 2; held <= CAMERAS; held += 2) {
        make(7312);
        for (int c = 0; c < held; c++) {
            r.roles[c] = RIGCAL_CAMERA_HELD;
        }
        r.rig.roles = r.roles;
        adjust_and_consider();
        assert_all(held);
    }
}

static void test_a_prior_holds_against_intrinsics(void)
{
    WANTS;
    make(7313);
    r.roles[0] = RIGCAL_CAMERA_HELD;
    r.roles[2] = RIGCAL_CAMERA_PRIOR;
    r.priors[2].cam_from_rig = r.cams[2];
    for (int k = 0; k < 6; k++) {
        r.priors[2].Sigma[7 * k] = RC(1e-6);
    }
    r.rig.roles = r.roles;
    r.rig.priors = r.priors;
    r.rig.sigma_px = RC(0.3);
    adjust_and_consider();
    assert_all(1);
}

/* Views that are left out do not count, even where a placement has no others. The
 * covariances are those of the rig without these views, bit for bit. */
static void test_a_placement_that_is_left_out_changes_nothing(void)
{
    rigcal_real Sigma[2][CAMERAS][36], own_sum[2];

    WANTS;
    for (int is_gone = 0; is_gone < 2; is_gone++) {
        size_t kept = 0;

        make(7318);
        for (size_t v = 0; v < r.rig.n_views; v++) {
            const int is_out = v == 9 || r.views[v].placement == 2;

            left_out[v] = !is_gone && is_out;
            if (is_gone && !is_out) {
                r.views[kept++] = r.views[v];
            }
        }
        if (is_gone) {
            r.rig.n_views = kept;
        }
        adjust_and_consider();
        own_sum[is_gone] = considered.own_sum;
        for (size_t c = 0; c < CAMERAS; c++) {
            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_rig_covariance(Sigma[is_gone][c], &r.rig, 0, c));
        }
    }
    TEST_ASSERT_EQUAL_MEMORY(Sigma[0], Sigma[1], sizeof Sigma[0]);
    TEST_ASSERT_EQUAL_MEMORY(&own_sum[0], &own_sum[1], sizeof own_sum[0]);
}

/* Three times the same point: rank 2 of 6. */
static void test_a_view_that_fixes_no_pose_leaves_no_sum_of_its_own(void)
{
    WANTS;
    make(7317);
    r.o[3][1] = r.o[3][2] = r.o[3][0];
    r.views[3].view.n = 3;
    adjust_and_consider();
    left_out[3] = 1; /* in the dense solution only */
    ASSERT_NEAR(own_sum_left(), considered.own_sum, SUM_PART * own_sum_left());
}

/* ---- against the adjustment itself -------------------------------------------------- */

static void assert_refused(rigcal_status expected)
{
    const rigcal_considered before = considered;
    int32_t at_fault = -2;

    ASSERT_STATUS(expected, rigcal_rig_consider(&considered, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_MEMORY(&before, &considered, sizeof before);
    TEST_ASSERT_EQUAL_INT32(-1, at_fault);
}

/* Moves some pixels by some 30 to 40 sigma. The noise that make() adds has at most the
 * deviation that is stated here. */
static void make_wrong_points(test_rng *rng)
{
    r.rig.sigma_px = RC(0.6);
    for (size_t v = 0; v < r.rig.n_views; v++) {
        rigcal_observation *const seen = r.o[v < 6 ? v : v + 1];
        const int i = (int)(5 * v % 12);

        if (v % 3 != 1) {
            is_wrong[v][i] = 1;
            for (int k = 0; k < 2; k++) {
                const double by = 0.3 * D(spreads[i]) * uniform(rng, 60, 80);

                seen[i].uv[k] =
                    RC(D(seen[i].uv[k]) + (test_uniform(rng, 0, 1) < 0.5 ? -by : by));
            }
        }
    }
}

/* The adjustment must leave out n_wrong points, and no other. Huber's loss moves the rig
 * from the optimum of the truncated one, so only this is adjusted again. */
static void adjust_robust(size_t n_wrong)
{
    static rigcal_rig_solver solver;
    rigcal_rig_fit fit;
    size_t n = 0;

    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust_robust(&fit, &n, NULL, &r.rig));
    for (int i = 0; i < 2; i++) {
        TEST_ASSERT_EQUAL_size_t(n_wrong, n);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_rig_robust_begin(&solver, &r.rig, RIGCAL_LOSS_TRUNCATED));
        while (rigcal_rig_step(&solver, 1000) == RIGCAL_RUNNING) {
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_robust_result(&fit, &n, NULL, &solver));
    }
    TEST_ASSERT_EQUAL_size_t(n_wrong, n);
}

static size_t count_wrong(void)
{
    size_t n = 0;

    for (size_t v = 0; v < r.rig.n_views; v++) {
        for (int i = 0; i < r.n_points; i++) {
            n += is_wrong[v][i] && !left_out[v];
        }
    }
    return n;
}

static void test_points_that_a_robust_adjustment_left_out_do_not_count(void)
{
    double expected[36];
    rigcal_real Sigma[36];
    test_rng rng = test_seed(7316);

    WANTS;
    make(7316);
    make_wrong_points(&rng);
    considered.loss = RIGCAL_LOSS_TRUNCATED;
    adjust_robust(count_wrong());
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &r.rig));
    assert_all(1);
    considered.loss = 0; /* all points, at the same poses */
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &r.rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(Sigma, &r.rig, 0, 2));
    spread(expected, 12, 12);
    TEST_ASSERT_TRUE(fabs(D(Sigma[0]) / expected[0] - 1) > 0.01);
}

static void test_points_count_as_the_loss_of_the_adjustment_weighs_them(void)
{
    static rigcal_rig_solver solver;
    rigcal_rig_fit fit;
    test_rng rng = test_seed(7318);
    size_t n;

    WANTS;
    make(7318);
    make_wrong_points(&rng);
    memset(is_wrong, 0, sizeof is_wrong); /* all count, by their weights */
    is_huber = 1;
    considered.loss = RIGCAL_LOSS_HUBER;
    for (int i = 0; i < 8; i++) {
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_rig_robust_begin(&solver, &r.rig, RIGCAL_LOSS_HUBER));
        while (rigcal_rig_step(&solver, 1000) == RIGCAL_RUNNING) {
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_robust_result(&fit, &n, NULL, &solver));
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &r.rig));
    assert_all(1);
}

/* A point that its camera cannot see is wrong. A limit for the truncated loss needs the
 * noise of the pixels. */
static void test_what_the_truncated_loss_leaves_out_needs_the_noise(void)
{
    static const rigcal_real BEHIND[3] = {0, 0, -2};
    rigcal_transform chain, target_from_cam;
    rigcal_real whole[36], Sigma[36];
    double expected[36];
    test_rng rng = test_seed(7317);
    int32_t at_fault;

    WANTS;
    make(7317);
    make_wrong_points(&rng);
    adjust_robust(count_wrong());
    considered.loss = RIGCAL_LOSS_TRUNCATED;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &r.rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(whole, &r.rig, 0, 2));
    chain = test_times(&r.cams[r.views[0].camera], &r.places[r.views[0].placement]);
    ASSERT_STATUS(RIGCAL_OK, rigcal_transform_invert(&target_from_cam, &chain));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_transform_point(r.o[0][0].X_w, &target_from_cam, BEHIND));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &r.rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(Sigma, &r.rig, 0, 2));
    test_to_double(expected, whole, 36);
    assert_part(expected, Sigma, TOL(1e-12, 1e-5));
    considered.loss = 0;
    ASSERT_STATUS(RIGCAL_ERR_BEHIND, rigcal_rig_consider(&considered, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_INT32(0, at_fault);
    for (int32_t k = -1; k <= 3; k += 4) {
        considered.loss = k;
        assert_refused(RIGCAL_ERR_RANGE);
    }
    considered.loss = RIGCAL_LOSS_TRUNCATED;
    r.rig.sigma_px = 0;
    assert_refused(RIGCAL_ERR_RANGE);
}

static void test_other_intrinsics_move_the_adjusted_rig_by_the_effects(void)
{
    WANTS;
    make(7321);
    adjust_and_consider();
    for (int k = 0; k < COLUMNS; k += 5) {
        const rigcal_camera kept = r.camera[k / BY];
        const size_t column = (size_t)k * considered.n;
        rigcal_transform before[CAMERAS];
        double moved = 0, off = 0;
        rigcal_real foretold[6 * CAMERAS];

        memcpy(before, r.cams, sizeof before);
        memcpy(foretold, &effects[column], considered.n * sizeof *foretold);
        /* If a smaller camera is assumed than the true one, the error is that of a larger
         * one. */
        r.camera[k / BY] = changed(&kept, k % BY, -sigma_of(k));
        adjust();
        for (int c = 1; c < CAMERAS; c++) {
            double d[6];

            test_step_between(d, &r.cams[c], &before[c]);
            for (int i = 0; i < 6; i++) {
                moved += d[i] * d[i];
                off += pow(d[i] - D(foretold[6 * (c - 1) + i]), 2);
            }
        }
        TEST_ASSERT_TRUE(sqrt(off) < 0.1 * sqrt(moved));
        r.camera[k / BY] = kept;
        adjust_and_consider();
    }
}

/* ---- with clocks ------------------------------------------------------------------- */

enum {
    CLOCKS_WORK = RIGCAL_CONSIDER_WORK(MOTION_CAMERAS_MAX, MOTION_CAMERAS_MAX) +
                  RIGCAL_CONSIDER_CLOCKS_WORK(MOTION_CAMERAS_MAX)
};

static test_motions moving;
static rigcal_camera lens[MOTION_CAMERAS_MAX];
static rigcal_real with_clocks[CLOCKS_WORK];

static void adjust_moving(void)
{
    rigcal_rig_fit fit;

    for (int i = 0; i < 3; i++) {
        const rigcal_status status = rigcal_rig_adjust(&fit, NULL, &moving.rig);

        TEST_ASSERT_GREATER_OR_EQUAL_INT(0, status);
    }
}

static void make_moving(int has_drifts, double stamp)
{
    const motion_scene scene = {.cameras = 3,
                                .runs = 5,
                                .frames = 4,
                                .fps = 30,
                                .speed = 0.35,
                                .turn = 0.8,
                                .pause = 5,
                                .offset = 0.01,
                                .noise_px = 0.01};
    test_rng rng = test_seed(7351);

    test_motions_make(&moving, &rng, &scene);
    for (size_t v = 0; v < moving.rig.n_views; v++) {
        lens[moving.views[v].camera] = moving.camera;
        moving.views[v].view.camera = &lens[moving.views[v].camera];
    }
    moving.rig.clocks = &moving.clocks;
    moving.rig.sigma_px = RC(0.3);
    moving.clocks.free_offsets = 1;
    moving.clocks.drifts = moving.drifts;
    moving.clocks.free_drifts = has_drifts;
    moving.clocks.sigma_time = RC(stamp);
    set_sigmas(&rng);
    moving.rig.intrinsics_sigmas = sigmas;
    considered = (rigcal_considered){.effects = with_clocks, .capacity = CLOCKS_WORK};
    adjust_moving();
}

/* The move of the cameras with a smaller lens, minus the predicted one, as a part of it. */
static double surprise(int camera, int which)
{
    const rigcal_camera kept = lens[camera];
    const int column = BY * camera + which;
    rigcal_transform before[MOTION_CAMERAS_MAX];
    double moved = 0, off = 0;

    memcpy(before, moving.cams, sizeof before);
    lens[camera] = changed(&kept, which, -0.2 * sigma_of(column));
    adjust_moving();
    for (int i = 0; i < 12; i++) {
        const int c = 1 + i / 6;
        double d[6];

        test_step_between(d, &moving.cams[c], &before[c]);
        d[i % 6] -= 0.2 * D(with_clocks[(size_t)column * considered.n + (size_t)i]);
        off += d[i % 6] * d[i % 6];
        d[i % 6] += 0.2 * D(with_clocks[(size_t)column * considered.n + (size_t)i]);
        moved += d[i % 6] * d[i % 6];
    }
    lens[camera] = kept;
    adjust_moving();
    return sqrt(off / moved);
}

static void test_intrinsics_act_through_clocks_too(void)
{
    TEST_ON_HOST_ONLY("a rig of 60 views is adjusted 24 times");
    for (int k = 0; k < 3; k++) {
        make_moving(k == 1, k == 2 ? 0.004 : 0);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &moving.rig));
        TEST_ASSERT_EQUAL_UINT64(12, considered.n);
        for (int which = 0; which < BY; which += 2) {
            const double off = surprise(which % 3, which);

            /* The weight of a stamp's noise depends on the motion, which lags by one step.
             * Its derivative is not in the equations of the adjustment. */
            ASSERT_NEAR(0, off, (k == 2) ? 0.1 : TOL(0.02, 0.2));
        }
    }
    considered.capacity = RIGCAL_CONSIDER_WORK(2, 3);
    ASSERT_STATUS(RIGCAL_ERR_CAPACITY, rigcal_rig_consider(&considered, NULL, &moving.rig));
}

/* What a lens that is off by a part of its deviation adds to the sum of the fit. The terms
 * of first order cancel between both signs. */
static double added_by(int column)
{
    const double part = 0.2;
    const rigcal_camera kept = lens[column / BY];
    double sum[3];

    for (int sign = -1; sign <= 1; sign++) {
        rigcal_rig_fit fit;

        lens[column / BY] = changed(&kept, column % BY, sign * part * sigma_of(column));
        adjust_moving();
        TEST_ASSERT_GREATER_OR_EQUAL_INT(0, rigcal_rig_adjust(&fit, NULL, &moving.rig));
        sum[1 + sign] = D(fit.sum);
    }
    lens[column / BY] = kept;
    adjust_moving();
    return ((sum[0] + sum[2]) / 2 - sum[1]) / (part * part);
}

static void keep_deviation_of(int column)
{
    const rigcal_intrinsics_sigma kept = sigmas[column / BY];

    memset(sigmas, 0, sizeof sigmas);
    sigmas[column / BY].focal = column % BY == 0 ? kept.focal : 0;
    sigmas[column / BY].aspect = column % BY == 1 ? kept.aspect : 0;
    sigmas[column / BY].k1 = column % BY == 4 ? kept.k1 : 0;
}

static void test_the_sum_is_what_intrinsics_add_where_clocks_are_free(void)
{
    TEST_ON_HOST_ONLY("a rig of 60 views is adjusted 117 times");
    for (int k = 0; k < 9; k++) {
        static const int COLUMN[] = {0, BY + 1, 2 * BY + 4};

        make_moving(k / 3 == 1, k / 3 == 2 ? 0.004 : 0);
        keep_deviation_of(COLUMN[k % 3]);
        const double added = added_by(COLUMN[k % 3]);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &moving.rig));
        ASSERT_NEAR(added, considered.sum, TOL(0.01, 0.1) * added);
    }
}

/* All unknowns and all deviations take exactly the memory that the macros say. */
static void test_with_clocks_the_memory_is_enough(void)
{
    enum { EXACT = RIGCAL_CONSIDER_WORK(2, 3) + RIGCAL_CONSIDER_CLOCKS_WORK(3) };

    TEST_ON_HOST_ONLY("a rig of 60 views is adjusted");
    make_moving(1, 0);
    FILL(with_clocks);
    considered.capacity = EXACT;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &moving.rig));
    TEST_ASSERT_EQUAL_UINT64(12, considered.n);
    TEST_ASSERT_EQUAL_UINT64(18, considered.k);
    for (size_t k = EXACT; k < CLOCKS_WORK; k++) {
        ASSERT_UNTOUCHED(with_clocks[k]);
    }
    considered.capacity = EXACT - 1;
    ASSERT_STATUS(RIGCAL_ERR_CAPACITY, rigcal_rig_consider(&considered, NULL, &moving.rig));
}

/* Times in seconds, and in units of a thousandth: a stamp is off by 0.004 or by 4 of
 * them. */
static void test_the_unit_of_time_does_not_matter(void)
{
    static rigcal_real effects_before[12 * COLUMNS];
    double largest = 0;

    TEST_ON_HOST_ONLY("a rig of 60 views is adjusted twice");
    make_moving(0, 0.004);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &moving.rig));
    TEST_ASSERT_EQUAL_UINT64(12, considered.n);
    TEST_ASSERT_EQUAL_UINT64(18, considered.k);
    memcpy(effects_before, with_clocks, 12 * 18 * sizeof with_clocks[0]);
    for (size_t f = 0; f < moving.rig.n_placements; f++) {
        moving.times[f] *= 1024;
    }
    for (size_t c = 0; c < 3; c++) {
        moving.offsets[c] *= 1024;
    }
    moving.clocks.sigma_time *= 1024;
    moving.clocks.frame *= 1024;
    adjust_moving();
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &moving.rig));
    for (int i = 0; i < 12 * 18; i++) {
        largest = fmax(largest, fabs(D(effects_before[i])));
    }
    for (int i = 0; i < 12 * 18; i++) {
        ASSERT_NEAR(D(effects_before[i]), with_clocks[i], TOL(1e-6, 1e-2) * largest);
    }
}

/* With the lens of one camera alone, the variance of a placement is the effect of a smaller
 * lens. */
static void test_intrinsics_act_on_placements_of_a_rig_with_clocks(void)
{
    TEST_ON_HOST_ONLY("a rig of 60 views is adjusted");
    for (int has_clocks = 0; has_clocks < 2; has_clocks++) {
        rigcal_transform before;
        rigcal_real Sigma[36];
        double d[6], seen = 0, foretold = 0, off = 0;

        make_moving(0, 0);
        memset(sigmas, 0, sizeof sigmas);
        sigmas[1].focal = RC(1e-3);
        moving.clocks.free_offsets = has_clocks;
        adjust_moving();
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &moving.rig));
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_placement(Sigma, &moving.rig, 0, 6));
        before = moving.places[6];
        const rigcal_camera kept = lens[1];
        lens[1] = changed(&kept, 0, -1e-3);
        adjust_moving();
        test_step_between(d, &moving.places[6], &before);
        for (int i = 0; i < 36; i++) {
            seen += d[i / 6] * d[i % 6] * d[i / 6] * d[i % 6];
            foretold += D(Sigma[i]) * D(Sigma[i]);
            off += pow(d[i / 6] * d[i % 6] - D(Sigma[i]), 2);
        }
        TEST_ASSERT_TRUE(sqrt(off) < 0.2 * sqrt(seen) && foretold > 0);
    }
}

/* More steps than one call takes. */
static void test_many_steps_are_taken(void)
{
    TEST_WANTS_RAM(1000000); /* a rig of 72 views */
    make_moving(0, 0);
    for (int p = 0; p < 4; p++) { /* the last run a second time, later */
        const int from = 16 + p, to = 20 + p;

        moving.places[to] = moving.places[from];
        moving.times[to] = moving.times[from] + 5;
        for (int c = 0; c < 3; c++) {
            moving.views[3 * to + c] = moving.views[3 * from + c];
            moving.views[3 * to + c].placement = to;
        }
    }
    moving.rig.n_placements = 24;
    moving.rig.n_views = 72;
    adjust_moving();
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &moving.rig));
    TEST_ASSERT_EQUAL_UINT64(18, considered.k);
    TEST_ASSERT_TRUE(72 + 24 + considered.k + 1 > 100);
}

/* ---- to the last bit -------------------------------------------------------- */

typedef struct {
    rigcal_real camera[CAMERAS][36], pair[36], place[PLACES][36];
    rigcal_real noise[CAMERAS], freedom[CAMERAS], joint[RIGCAL_CALIBRATED_SIZE(CAMERAS)];
    rigcal_mounted_camera mounted[CAMERAS];
} answers;

static void ask(answers *a)
{
    static int32_t group[CAMERAS];
    static uint8_t held[CAMERAS];
    rigcal_transform pair;
    rigcal_calibrated_rig out = {.cameras = a->mounted,
                                 .group = group,
                                 .held = held,
                                 .capacity = CAMERAS,
                                 .Sigma = a->joint,
                                 .Sigma_capacity = RIGCAL_CALIBRATED_SIZE(CAMERAS)};

    memset(a, 0, sizeof *a);
    for (size_t c = 0; c < CAMERAS; c++) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(a->camera[c], &r.rig, RC(0.3), c));
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_pair(&pair, a->pair, &r.rig, RC(0.3), 1, 3));
    for (size_t f = 0; f < PLACES; f++) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_placement(a->place[f], &r.rig, RC(0.3), f));
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_noise(a->noise, a->freedom, &r.rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_calibrated_take(&out, &r.rig, NULL, RC(0.3)));
}

static void test_deviations_of_zero_change_no_bit(void)
{
    static answers plain, with;

    WANTS;
    make(7331);
    adjust();
    ask(&plain);
    memset(sigmas, 0, sizeof sigmas);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &r.rig));
    ask(&with);
    TEST_ASSERT_EQUAL_MEMORY(&plain, &with, sizeof plain);
    r.rig.intrinsics_sigmas = NULL;
    considered.capacity = 0;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &r.rig));
    ask(&with);
    TEST_ASSERT_EQUAL_MEMORY(&plain, &with, sizeof plain);
}

static void test_pixels_and_intrinsics_are_added(void)
{
    static answers plain, with, alone;

    WANTS;
    make(7332);
    adjust();
    ask(&plain);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &r.rig));
    ask(&with);
    TEST_ASSERT_EQUAL_MEMORY(plain.noise, with.noise, sizeof plain.noise);
    for (size_t c = 1; c < CAMERAS; c++) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(alone.camera[c], &r.rig, 0, c));
        for (int k = 0; k < 36; k++) {
            const double size =
                D(with.camera[c][7 * (k / 6)]) * D(with.camera[c][7 * (k % 6)]);

            ASSERT_NEAR(D(plain.camera[c][k]) + D(alone.camera[c][k]), with.camera[c][k],
                        TOL(1e-12, 1e-5) * sqrt(size));
        }
        /* A rig that was taken over has the same, also in its joint covariance. */
        TEST_ASSERT_EQUAL_MEMORY(with.mounted[c].Sigma, with.camera[c],
                                 sizeof with.camera[c]);
    }
}

/* ---- the fit -------------------------------------------------------------------- */

/* All but sum, sigma_px and F are the same. */
static void assert_others(const rigcal_rig_fit *a, const rigcal_rig_fit *b)
{
    ASSERT_NEAR(D(a->freedom), b->freedom, 0);
    TEST_ASSERT_EQUAL_size_t(a->n_points, b->n_points);
    TEST_ASSERT_EQUAL_INT32(a->evals, b->evals);
    ASSERT_NEAR(D(a->freedom_between), b->freedom_between, 0);
    ASSERT_NEAR(D(a->freedom_within), b->freedom_within, 0);
}

/* Sums of the rig and of the views by themselves, and what intrinsics add to both. */
static void check_fit(double sum, double own, double adds, double adds_own)
{
    const double b = 40, w = 500;
    const rigcal_rig_fit fit = {
        RC(sum), RC(b + w), RC(1), 300, 7, RC((sum / own - 1) * w / b), RC(b), RC(w)};
    const rigcal_considered all = {.sum = RC(adds), .own_sum = RC(adds_own)};
    const rigcal_rig rig = {.considered = &all};
    const double rest = fmax(0, sum - adds);
    const double F = fmax(0, (sum - own - (adds - adds_own)) / b / (own / w));
    rigcal_rig_fit out;

    ASSERT_STATUS(RIGCAL_OK, rigcal_considered_fit(&out, &fit, &rig));
    ASSERT_NEAR(rest, out.sum, TOL(1e-12, 1e-5) * sum);
    ASSERT_NEAR(sqrt(rest / (b + w)), out.sigma_px, TOL(1e-12, 1e-5) * sqrt(sum));
    ASSERT_NEAR(F, out.F, TOL(1e-12, 1e-5) * (1 + D(fit.F)));
    assert_others(&fit, &out);
}

static void test_the_fit_loses_what_intrinsics_add(void)
{
    check_fit(60, 45, 4, 1);
    check_fit(60, 45, 0, 0);
    check_fit(60, 45, 20, 3);  /* between the views there is nothing left */
    check_fit(60, 45, 70, 3);  /* there is nothing left at all */
    check_fit(60, 45, -1, -2); /* by rounding */
}

/* Without a cycle there is no F, without freedom no sigma. */
static void test_a_fit_without_freedom_has_neither_sigma_nor_ratio(void)
{
    const rigcal_considered all = {.sum = RC(0.5), .own_sum = RC(0.25)};
    const rigcal_rig rig = {.considered = &all};
    rigcal_rig_fit fit = {.sum = 4, .freedom = 14, .n_points = 10};

    ASSERT_STATUS(RIGCAL_OK, rigcal_considered_fit(&fit, &fit, &rig));
    ASSERT_NEAR(3.5, fit.sum, 0);
    ASSERT_NEAR(0.5, fit.sigma_px, TOL(1e-15, 1e-6));
    ASSERT_NEAR(0, fit.F, 0);
    fit = (rigcal_rig_fit){.sum = 1, .sigma_px = 7};
    ASSERT_STATUS(RIGCAL_OK, rigcal_considered_fit(&fit, &fit, &rig));
    ASSERT_NEAR(0, fit.sigma_px, 0);
    fit = (rigcal_rig_fit){.sum = RC(1.5), .freedom = 1};
    ASSERT_STATUS(RIGCAL_OK, rigcal_considered_fit(&fit, &fit, &rig));
    ASSERT_NEAR(1, fit.sigma_px, TOL(1e-15, 1e-6));
}

static void test_a_fit_of_exact_intrinsics_stays_as_it_is(void)
{
    const rigcal_rig rig = {0};
    const rigcal_rig_fit fit = {60, 540, RC(0.4), 300, 7, RC(1.5), 40, 500};
    rigcal_rig_fit out = {0};

    ASSERT_STATUS(RIGCAL_OK, rigcal_considered_fit(&out, &fit, &rig));
    ASSERT_NEAR(60, out.sum, 0);
    ASSERT_NEAR(D(fit.sigma_px), out.sigma_px, 0);
    ASSERT_NEAR(1.5, out.F, 0);
    assert_others(&fit, &out);
    out.F = 9;
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_considered_fit(NULL, &fit, &rig));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_considered_fit(&out, NULL, &rig));
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_considered_fit(&out, &fit, NULL));
    for (int k = 0; k < 6; k++) {
        rigcal_rig_fit bad = fit;
        rigcal_real *const numbers[] = {
            &bad.sum, &bad.freedom,         &bad.sigma_px,
            &bad.F,   &bad.freedom_between, &bad.freedom_within};

        *numbers[k] = RC(NAN);
        ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, rigcal_considered_fit(&out, &bad, &rig));
    }
    ASSERT_NEAR(9, out.F, 0);
}

static void test_an_adjustment_forgets_what_was_considered(void)
{
    static answers plain, again;

    WANTS;
    make(7333);
    adjust();
    ask(&plain);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &r.rig));
    TEST_ASSERT_EQUAL_PTR(&considered, r.rig.considered);
    make(7333);
    r.rig.considered = &considered;
    adjust();
    TEST_ASSERT_NULL(r.rig.considered);
    ask(&again);
    TEST_ASSERT_EQUAL_MEMORY(&plain, &again, sizeof plain);
}

static void test_the_budget_changes_no_bit(void)
{
    static rigcal_real kept[WORK];

    WANTS;
    make(7334);
    adjust_and_consider();
    memcpy(kept, effects, considered.n * considered.k * sizeof *kept);
    const rigcal_considered before = considered;
    for (int32_t budget = 1; budget < 40; budget += 6) {
        rigcal_consider_solver solver;
        int32_t at_fault = -2;

        memset(effects, 0x55, sizeof effects);
        ASSERT_STATUS(RIGCAL_OK, rigcal_consider_begin(&solver, &considered, &r.rig));
        TEST_ASSERT_NULL(r.rig.considered);
        ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_consider_result(&at_fault, &solver));
        TEST_ASSERT_EQUAL_INT32(-1, at_fault);
        at_fault = -2;
        ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_consider_result(&at_fault, NULL));
        TEST_ASSERT_EQUAL_INT32(-1, at_fault);
        while (rigcal_consider_step(&solver, budget) == RIGCAL_RUNNING) {
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_consider_result(&at_fault, &solver));
        TEST_ASSERT_EQUAL_INT32(-1, at_fault);
        TEST_ASSERT_EQUAL_MEMORY(kept, effects, considered.n * considered.k * sizeof *kept);
        ASSERT_NEAR(D(before.sum), considered.sum, 0);
        ASSERT_NEAR(D(before.own_sum), considered.own_sum, 0);
    }
}

/* ---- what cannot be --------------------------------------------------------- */

static void test_bad_deviations_and_memory_are_refused(void)
{
    static const struct {
        double value;
        rigcal_status status;
    } BAD[] = {{-1e-6, RIGCAL_ERR_RANGE}, {2e9, RIGCAL_ERR_RANGE}};
    rigcal_real *const each[] = {&sigmas[2].focal, &sigmas[0].aspect, &sigmas[3].centre,
                                 &sigmas[1].k1, &sigmas[3].k2};

    WANTS;
    make(7341);
    assert_refused(RIGCAL_ERR_STATE);
    adjust();
    for (int k = 0; k < 5; k++) {
        const rigcal_real kept = *each[k];

        for (int i = 0; i < 2; i++) {
            *each[k] = RC(BAD[i].value);
            assert_refused(BAD[i].status);
        }
        *each[k] = TEST_NAN;
        assert_refused(RIGCAL_ERR_NOT_FINITE);
        *each[k] = TEST_INF;
        assert_refused(RIGCAL_ERR_NOT_FINITE);
        *each[k] = kept;
    }
    TEST_ASSERT_EQUAL_UINT64(WORK, rigcal_consider_work(CAMERAS, CAMERAS));
    considered.capacity = (6 * (CAMERAS - 1) + 6) * COLUMNS;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &r.rig));
    considered.capacity--;
    ASSERT_STATUS(RIGCAL_ERR_CAPACITY, rigcal_rig_consider(&considered, NULL, &r.rig));
    r.rig.views = NULL;
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_rig_consider(&considered, NULL, &r.rig));
}

/* Whichever camera is held, the effects take as many numbers, also if they are computed
 * again. */
static void test_any_camera_may_be_the_one_that_is_held(void)
{
    WANTS;
    for (int which = 0; which < CAMERAS; which++) {
        make(7344);
        memset(r.roles, RIGCAL_CAMERA_FREE, sizeof r.roles);
        r.roles[which] = RIGCAL_CAMERA_HELD;
        r.rig.roles = r.roles;
        adjust();
        considered.capacity = (6 * (CAMERAS - 1) + 6) * COLUMNS;
        for (int time = 0; time < 2; time++) {
            ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &r.rig));
        }
        considered.capacity--;
        ASSERT_STATUS(RIGCAL_ERR_CAPACITY, rigcal_rig_consider(&considered, NULL, &r.rig));
    }
}

/* One number of one camera is not exact, so the effects are few. They, and what is worked
 * with beside them, stay in the memory. What an estimate wrote before is gone. */
static void test_few_effects_take_little_memory(void)
{
    enum { EXACT = 6 * (CAMERAS - 1) + 6 };

    WANTS;
    make(7346);
    memset(sigmas, 0, sizeof sigmas);
    sigmas[1].focal = RC(0.001);
    adjust();
    considered.capacity = EXACT;
    considered.factor = spreads;
    FILL(effects);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_consider(&considered, NULL, &r.rig));
    TEST_ASSERT_EQUAL_UINT64(6 * (CAMERAS - 1), considered.n);
    TEST_ASSERT_EQUAL_UINT64(1, considered.k);
    TEST_ASSERT_NULL(considered.factor);
    for (size_t k = EXACT; k < WORK; k++) {
        ASSERT_UNTOUCHED(effects[k]);
    }
}

static void test_a_view_that_has_changed_is_told(void)
{
    int32_t at_fault = -2;

    WANTS;
    make(7342);
    adjust();
    r.o[8][3].uv[1] = TEST_NAN; /* index of view 7, because a view before it is missing */
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE,
                  rigcal_rig_consider(&considered, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_INT32(7, at_fault);
    TEST_ASSERT_NULL(r.rig.considered);
}

/* Views of placement 0 change after the intrinsics were considered. */
static void test_a_placement_that_has_changed_has_no_covariance(void)
{
    rigcal_real Sigma[36];
    int32_t at_fault = -2;

    WANTS;
    make(7343);
    adjust_and_consider();
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_placement(Sigma, &r.rig, 1, 0));
    const rigcal_real kept = r.o[1][3].uv[1];
    r.o[1][3].uv[1] = TEST_NAN; /* of its second view */
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, Sigma, rigcal_rig_placement(Sigma, &r.rig, 1, 0));
    r.o[1][3].uv[1] = kept;
    sigmas[1].k1 = 0; /* one column less than was considered */
    ASSERT_REFUSED(RIGCAL_ERR_STATE, Sigma, rigcal_rig_placement(Sigma, &r.rig, 1, 0));
    sigmas[1].k1 = RC(0.01);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_placement(Sigma, &r.rig, 1, 0));
    for (int v = 0; v < CAMERAS; v++) { /* all views see only one point */
        for (int i = 1; i < r.n_points; i++) {
            r.o[v][i] = r.o[v][0];
        }
    }
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, Sigma, rigcal_rig_placement(Sigma, &r.rig, 1, 0));
    ASSERT_STATUS(RIGCAL_ERR_DEGENERATE,
                  rigcal_rig_consider(&considered, &at_fault, &r.rig));
    TEST_ASSERT_EQUAL_INT32(CAMERAS - 1, at_fault);
    TEST_ASSERT_NULL(r.rig.considered);
}

static void test_the_memory_for_clocks_is_that_of_the_macro(void)
{
    TEST_ASSERT_EQUAL_size_t(RIGCAL_CONSIDER_CLOCKS_WORK(5),
                             rigcal_consider_clocks_work(5));
}

TEST_MAIN()
{
    RUN_TEST(test_the_effects_are_those_of_dense_least_squares);
    RUN_TEST(test_cameras_with_exact_intrinsics_have_no_columns);
    RUN_TEST(test_held_cameras_move_placements_and_other_cameras);
    RUN_TEST(test_a_prior_holds_against_intrinsics);
    RUN_TEST(test_a_placement_that_is_left_out_changes_nothing);
    RUN_TEST(test_a_view_that_fixes_no_pose_leaves_no_sum_of_its_own);
    RUN_TEST(test_points_that_a_robust_adjustment_left_out_do_not_count);
    RUN_TEST(test_points_count_as_the_loss_of_the_adjustment_weighs_them);
    RUN_TEST(test_what_the_truncated_loss_leaves_out_needs_the_noise);
    RUN_TEST(test_other_intrinsics_move_the_adjusted_rig_by_the_effects);
    RUN_TEST(test_intrinsics_act_through_clocks_too);
    RUN_TEST(test_the_sum_is_what_intrinsics_add_where_clocks_are_free);
    RUN_TEST(test_with_clocks_the_memory_is_enough);
    RUN_TEST(test_the_unit_of_time_does_not_matter);
    RUN_TEST(test_intrinsics_act_on_placements_of_a_rig_with_clocks);
    RUN_TEST(test_many_steps_are_taken);
    RUN_TEST(test_deviations_of_zero_change_no_bit);
    RUN_TEST(test_a_placement_that_has_changed_has_no_covariance);
    RUN_TEST(test_pixels_and_intrinsics_are_added);
    RUN_TEST(test_the_fit_loses_what_intrinsics_add);
    RUN_TEST(test_a_fit_without_freedom_has_neither_sigma_nor_ratio);
    RUN_TEST(test_a_fit_of_exact_intrinsics_stays_as_it_is);
    RUN_TEST(test_an_adjustment_forgets_what_was_considered);
    RUN_TEST(test_the_budget_changes_no_bit);
    RUN_TEST(test_bad_deviations_and_memory_are_refused);
    RUN_TEST(test_any_camera_may_be_the_one_that_is_held);
    RUN_TEST(test_few_effects_take_little_memory);
    RUN_TEST(test_a_view_that_has_changed_is_told);
    RUN_TEST(test_the_memory_for_clocks_is_that_of_the_macro);
}
