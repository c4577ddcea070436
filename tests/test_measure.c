/* measure: points with their covariance, wrong views dropped, lengths between points. */
#include <math.h>
#include <string.h>

#include "rc_locate.h"
#include "test_support.h"
#include "vectors_camera.h"
#include "vectors_point.h"

enum { N = 20, FREE = 6 * N };

/* A rig with its joint covariance, and what it saw of a point. */
typedef struct {
    rigcal_mounted_camera cameras[N];
    int32_t group[N];
    uint8_t held[N];
    rigcal_real Sigma[RIGCAL_CALIBRATED_SIZE(N)], noise[N];
    rigcal_calibrated_rig rig;
    rigcal_sighting seen[N];
    rigcal_real work[RIGCAL_POINT_WORK(N)];
    rigcal_sightings s;
    double X[3];
} measuring;

static measuring m;
static rigcal_point_gain gains[N];
static rigcal_measured_point point;

#define WANTS_RIG TEST_WANTS_RAM(sizeof m + sizeof gains + 8000)

static double root[FREE][FREE]; /* a factor of the joint covariance */

/* L L^T with small integers in L, as in tests/vectors/point_oracle.py. */
static void fill_covariance(int n_free, int seed)
{
    double(*const L)[FREE] = root;
    const int n = 6 * n_free;

    for (int i = 0; i < n; i++) {
        const double scale = i % 6 < 3 ? 4e-4 : 2e-3;

        for (int j = 0; j < i; j++) {
            L[i][j] = scale * ((7 * i + 11 * j + 3 * seed) % 13 - 6) / 13;
        }
        L[i][i] = scale;
        for (int j = 0; j <= i; j++) {
            double sum = 0;

            for (int k = 0; k <= j; k++) {
                sum += L[i][k] * L[j][k];
            }
            m.Sigma[i * (i + 1) / 2 + j] = RC(sum);
        }
    }
}

static void clear(int n, int n_held)
{
    memset(&m, 0, sizeof m);
    m.rig.cameras = m.cameras;
    m.rig.group = m.group;
    m.rig.held = m.held;
    m.rig.Sigma = m.Sigma;
    m.rig.capacity = N;
    m.rig.Sigma_capacity = RIGCAL_CALIBRATED_SIZE(N);
    m.rig.n_cameras = (size_t)n;
    m.rig.sigma_px = 1;
    m.s.rig = &m.rig;
    m.s.seen = m.seen;
    m.s.n = (size_t)n;
    m.s.sigma_px = m.noise;
    m.s.work = m.work;
    m.s.work_capacity = RIGCAL_POINT_WORK(N);
    for (int i = 0; i < n; i++) {
        m.held[i] = i < n_held;
        m.seen[i].camera = i;
    }
    memset(&point, 0, sizeof point);
    point.gains = gains;
    point.gains_capacity = N;
}

/* ---- against dense algebra --------------------------------------------------- */

static const double *golden(int row)
{
    const double *v = POINT[row];
    const int n = (int)v[0], held = (int)v[1];

    clear(n, held);
    fill_covariance(n - held, (int)v[2]);
    for (int i = 0; i < n; i++) {
        const double *view = v + 3 + 10 * i;

        m.cameras[i].camera = test_camera(CAMERA[(int)view[0]]);
        m.cameras[i].cam_from_rig = test_from_ypr(view + 1, view + 4);
        test_to_real(m.seen[i].uv, view + 7, 2);
        m.noise[i] = RC(view[9]);
    }
    m.s.keep_all = 1;
    return v + 53;
}

static double largest(const double A[], int n)
{
    double most = 0;

    for (int i = 0; i < n; i++) {
        most = fmax(most, fabs(A[i]));
    }
    return most;
}

static void test_points_are_those_of_dense_algebra(void)
{
    WANTS_RIG;
    for (int row = 0; row < POINT_ROWS; row++) {
        const double *v = golden(row);
        const double sigma = sqrt(largest(v + 3, 9));
        const rigcal_status status = rigcal_point_measure(&point, NULL, &m.s);

        TEST_ASSERT_TRUE(status == RIGCAL_OK || status == RIGCAL_POOR_FIT);
        ASSERT_ARRAY_NEAR(v, point.X, 3, TOL(1e-6, 2e-3) * sigma);
        ASSERT_ARRAY_NEAR(v + 3, point.Sigma, 9, TOL(1e-4, 1e-3) * sigma * sigma);
        ASSERT_ARRAY_NEAR(v + 12, point.Sigma_noise, 9, TOL(1e-4, 1e-3) * sigma * sigma);
        ASSERT_NEAR(v[21], point.chi2, TOL(1e-4, 1e-2) * (1 + v[21]));
        ASSERT_NEAR(v[22], point.rms_px, TOL(1e-6, 2e-3));
        ASSERT_NEAR(2 * POINT[row][0] - 3, point.freedom, 0);
        TEST_ASSERT_EQUAL_UINT64((uint64_t)POINT[row][0], point.n_used);
    }
}

static void test_lengths_are_those_of_dense_algebra(void)
{
    static rigcal_point_gain other_gains[N];
    rigcal_measured_point other;
    rigcal_real distance, sigma;

    WANTS_RIG;
    for (int row = 0; row < POINT_LENGTH_ROWS; row++) {
        (void)golden(2 * row);
        TEST_ASSERT_TRUE(rigcal_point_measure(&point, NULL, &m.s) >= 0);
        other = point;
        memcpy(other_gains, gains, sizeof gains);
        other.gains = other_gains;
        (void)golden(2 * row + 1);
        TEST_ASSERT_TRUE(rigcal_point_measure(&point, NULL, &m.s) >= 0);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_point_distance(&distance, &sigma, &m.rig, &other, &point));
        ASSERT_NEAR(POINT_LENGTH[row][0], distance, TOL(1e-5, 1e-2) * POINT_LENGTH[row][1]);
        ASSERT_NEAR(POINT_LENGTH[row][1], sigma, TOL(1e-4, 2e-3) * POINT_LENGTH[row][1]);
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_point_distance(&distance, NULL, &m.rig, &point, &other));
        ASSERT_NEAR(POINT_LENGTH[row][0], distance, TOL(1e-5, 1e-2) * POINT_LENGTH[row][1]);
    }
}

/* ---- simulated rigs ------------------------------------------------------------ */

static const double NOISE = 0.3;

/* Cameras in an arc of 70 degrees, at a distance of 4, which see X. One lens in three is a
 * fisheye, one has distortion. */
static void simulate(test_rng *rng, int n, double noise)
{
    clear(n, 1);
    fill_covariance(n - 1, 1);
    for (int k = 0; k < 3; k++) {
        m.X[k] = test_uniform(rng, -0.4, 0.4);
    }
    for (int i = 0; i < n; i++) {
        const double t[3] = {test_uniform(rng, -0.2, 0.2), test_uniform(rng, -0.2, 0.2), 4};
        double R[9], X_c[3], uv[2];

        m.cameras[i].camera = test_camera(CAMERA[(i % 3 == 0) ? 0 : (i % 3 == 1) ? 1 : 4]);
        test_rotation(R, test_uniform(rng, -0.3, 0.3), -0.6 + 1.2 * i / (n - 1),
                      test_uniform(rng, -0.3, 0.3));
        m.cameras[i].cam_from_rig = test_transform(R, t);
        test_move_point(X_c, &m.cameras[i].cam_from_rig, m.X);
        test_project_px(uv, &m.cameras[i].camera, X_c);
        for (int k = 0; k < 2; k++) {
            m.seen[i].uv[k] = RC(uv[k] + noise * test_normal(rng));
        }
        m.noise[i] = RC(NOISE);
    }
}

static void spoil(test_rng *rng, int view, double off)
{
    const double way = test_uniform(rng, -TEST_PI, TEST_PI);

    m.seen[view].uv[0] += RC(off * cos(way));
    m.seen[view].uv[1] += RC(off * sin(way));
}

static void test_a_point_of_exact_views_is_where_it_is(void)
{
    test_rng rng = test_seed(601);

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(100); trial++) {
        const int n = 2 + trial % 9;

        simulate(&rng, n, 0);
        ASSERT_STATUS(RIGCAL_OK, rigcal_point_measure(&point, NULL, &m.s));
        ASSERT_ARRAY_NEAR(m.X, point.X, 3, TOL(1e-11, 1e-4));
        ASSERT_NEAR(0, point.chi2, TOL(1e-12, 1e-2));
        ASSERT_NEAR(0, point.rms_px, TOL(1e-8, 1e-2));
    }
}

/* The derivative of the point by a move of a camera, R <- exp([w]x) R, t <- t + dt, by
 * differences. The gain is minus that, because it gives the effect of an error of the
 * camera. */
static void test_gains_are_what_moved_cameras_do(void)
{
    const double step = TOL(1e-5, 2e-3);
    test_rng rng = test_seed(602);
    rigcal_real to[2][3];
    static rigcal_point_gain kept[N];

    WANTS_RIG;
    simulate(&rng, 4, 0);
    m.s.keep_all = 1;
    TEST_ASSERT_TRUE(rigcal_point_measure(&point, NULL, &m.s) >= 0);
    memcpy(kept, gains, sizeof kept);
    for (int k = 0; k < 24; k++) {
        const rigcal_transform there = m.cameras[k / 6].cam_from_rig;

        TEST_ASSERT_EQUAL_INT32(k / 6, kept[k / 6].camera);
        for (int side = 0; side < 2; side++) {
            double d[6] = {0}, R[9], t[3], turn[9], moved[9];

            d[k % 6] = side ? step : -step;
            test_transform_parts(R, t, &there);
            if (k % 6 < 3) {
                const double axis[3] = {k % 6 == 0, k % 6 == 1, k % 6 == 2};
                test_rotation_about(turn, axis, d[k % 6]);
                test_product(moved, turn, R);
                memcpy(R, moved, sizeof R);
            } else {
                t[k % 6 - 3] += d[k % 6];
            }
            m.cameras[k / 6].cam_from_rig = test_transform(R, t);
            TEST_ASSERT_TRUE(rigcal_point_measure(&point, NULL, &m.s) >= 0);
            memcpy(to[side], point.X, sizeof to[side]);
        }
        m.cameras[k / 6].cam_from_rig = there;
        for (int i = 0; i < 3; i++) {
            const double moved = (D(to[1][i]) - D(to[0][i])) / (2 * step);

            ASSERT_NEAR(moved, kept[k / 6].gain[6 * i + k % 6], TOL(1e-6, 2e-2));
        }
    }
}

/* g^T Sigma g over all cameras of the rig. Each point is seen by two cameras of its own. */
static void test_a_length_takes_points_of_different_cameras(void)
{
    static rigcal_point_gain other_gains[N];
    rigcal_sighting all[4];
    rigcal_measured_point other;
    rigcal_real distance, sigma;
    double g[FREE] = {0}, variance = 0, unit[3], length = 0;
    test_rng rng = test_seed(603);

    WANTS_RIG;
    simulate(&rng, 4, NOISE);
    memcpy(all, m.seen, sizeof all);
    m.s.n = 2;
    TEST_ASSERT_TRUE(rigcal_point_measure(&point, NULL, &m.s) >= 0);
    other = point;
    memcpy(other_gains, gains, sizeof gains);
    other.gains = other_gains;
    m.seen[0] = all[2];
    m.seen[1] = all[3];
    m.seen[0].uv[0] += 60;
    m.seen[1].uv[0] += 60;
    TEST_ASSERT_TRUE(rigcal_point_measure(&point, NULL, &m.s) >= 0);
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_point_distance(&distance, &sigma, &m.rig, &other, &point));
    for (int k = 0; k < 3; k++) {
        unit[k] = D(other.X[k]) - D(point.X[k]);
        length += unit[k] * unit[k];
    }
    ASSERT_NEAR(sqrt(length), distance, TOL(1e-14, 1e-6));
    for (int v = 0; v < 4; v++) { /* camera 0 is held */
        const rigcal_point_gain *of = v < 2 ? &other_gains[v] : &gains[v - 2];

        for (int k = 0; of->camera > 0 && k < 18; k++) {
            g[6 * (of->camera - 1) + k % 6] +=
                (v < 2 ? 1 : -1) * unit[k / 6] / sqrt(length) * D(of->gain[k]);
        }
    }
    for (int i = 0; i < 18; i++) {
        for (int j = 0; j < 18; j++) {
            const int high = i > j ? i : j, low = i > j ? j : i;
            variance += g[i] * D(m.Sigma[high * (high + 1) / 2 + low]) * g[j];
        }
    }
    for (int k = 0; k < 9; k++) {
        variance += unit[k / 3] * unit[k % 3] / length *
                    (D(other.Sigma_noise[k]) + D(point.Sigma_noise[k]));
    }
    ASSERT_NEAR(sqrt(variance), sigma, TOL(1e-10, 1e-4) * sqrt(variance));
}

/* ---- wrong views --------------------------------------------------------------- */

/* Moves each camera by a random error of the joint covariance: d = L z. */
static void misplace(test_rng *rng, int n_free)
{
    double z[FREE];

    for (int i = 0; i < 6 * n_free; i++) {
        z[i] = test_normal(rng);
    }
    for (int c = 0; c < n_free; c++) {
        double d[6] = {0}, R[9], t[3], turn[9], moved[9];

        for (int i = 6 * c; i < 6 * c + 6; i++) {
            for (int k = 0; k <= i; k++) {
                d[i % 6] += root[i][k] * z[k];
            }
        }
        test_transform_parts(R, t, &m.cameras[c + 1].cam_from_rig);
        test_rotation_about(turn, d, test_norm(d));
        test_product(moved, turn, R);
        for (int k = 0; k < 3; k++) {
            t[k] += d[3 + k];
        }
        m.cameras[c + 1].cam_from_rig = test_transform(moved, t);
    }
}

/* The effect of the calibration's error does not make a view wrong. */
static void test_views_of_misplaced_cameras_are_not_wrong(void)
{
    test_rng rng = test_seed(620);
    int exact = 0, trials = TEST_TRIALS(200);

    WANTS_RIG;
    for (int trial = 0; trial < trials; trial++) {
        uint8_t used[N];

        simulate(&rng, 5, 0.02);
        misplace(&rng, 4);
        for (int i = 0; i < 5; i++) {
            m.noise[i] = RC(0.02);
        }
        spoil(&rng, 1, 40);
        exact += rigcal_point_measure(&point, used, &m.s) == RIGCAL_VIEWS_LEFT_OUT &&
                 point.n_used == 4 && used[1] == 0;
    }
    TEST_ASSERT_TRUE(exact >= trials - trials / 100);
}

static void test_the_order_of_views_does_not_matter(void)
{
    test_rng rng = test_seed(621);
    double X[3], Sigma[9], chi2;

    WANTS_RIG;
    simulate(&rng, 5, NOISE);
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_measure(&point, NULL, &m.s));
    test_to_double(X, point.X, 3);
    test_to_double(Sigma, point.Sigma, 9);
    chi2 = D(point.chi2);
    for (int i = 0; i < 2; i++) {
        const rigcal_sighting kept = m.seen[i];

        m.seen[i] = m.seen[4 - i];
        m.seen[4 - i] = kept;
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_measure(&point, NULL, &m.s));
    ASSERT_ARRAY_NEAR(X, point.X, 3, TOL(1e-7, 1e-4));
    ASSERT_ARRAY_NEAR(Sigma, point.Sigma, 9, TOL(1e-6, 1e-3) * largest(Sigma, 9));
    ASSERT_NEAR(chi2, point.chi2, TOL(1e-6, 2e-2) * (1 + chi2));
}

/* One point in a hundred has a large chi square, but no view is wrong. */
static void test_views_that_are_right_are_all_used(void)
{
    test_rng rng = test_seed(604);
    int n_used = 0, n = 0, n_poor = 0;

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(400); trial++) {
        simulate(&rng, 3 + trial % 6, 1.2 * NOISE);

        const rigcal_status status = rigcal_point_measure(&point, NULL, &m.s);

        n += (int)m.s.n;
        n_used += (int)point.n_used;
        n_poor += status == RIGCAL_POOR_FIT;
        if (point.n_used == m.s.n) {
            TEST_ASSERT_TRUE(status == RIGCAL_OK || status == RIGCAL_POOR_FIT);
        } else {
            TEST_ASSERT_TRUE(status == RIGCAL_VIEWS_LEFT_OUT || status == RIGCAL_FEW_AGREE);
        }
    }
    TEST_ASSERT_TRUE(n_used >= n - n / 50);
    TEST_ASSERT_TRUE(n_poor > 0 || TEST_ONE_IN > 1);
}

/* With 4 or more views the wrong ones are named, and no others. The gains and the point are
 * those of the views that are used. */
static void test_wrong_views_are_named(void)
{
    test_rng rng = test_seed(605);
    int exact = 0, trials = TEST_TRIALS(300);

    WANTS_RIG;
    for (int trial = 0; trial < trials; trial++) {
        const int n = 4 + trial % 5, wrong = trial % n,
                  second = n > 5 ? (wrong + 2) % n : wrong;
        uint8_t used[N];
        rigcal_real X[3];
        int is_exact = 1, k = 0;

        simulate(&rng, n, NOISE);
        spoil(&rng, wrong, test_uniform(&rng, 5, 60));
        if (second != wrong) {
            spoil(&rng, second, test_uniform(&rng, 5, 60));
        }
        if (rigcal_point_measure(&point, used, &m.s) != RIGCAL_VIEWS_LEFT_OUT) {
            continue;
        }
        for (int i = 0; i < n; i++) {
            is_exact = is_exact && used[i] == (i != wrong && i != second);
        }
        exact += is_exact;
        for (int i = 0; i < n; i++) {
            if (used[i]) {
                TEST_ASSERT_EQUAL_INT32(m.seen[i].camera, gains[k].camera);
                m.seen[k++] = m.seen[i];
            }
        }
        TEST_ASSERT_EQUAL_INT(k, (int)point.n_used);
        memcpy(X, point.X, sizeof X);
        m.s.n = (size_t)k;
        m.s.keep_all = 1;
        TEST_ASSERT_TRUE(rigcal_point_measure(&point, used, &m.s) >= 0);
        TEST_ASSERT_EQUAL_MEMORY(X, point.X, sizeof X);
    }
    /* 98 % are expected here, with views that are also wrong along their lines.
     * bench_points counts the shares. */
    TEST_ASSERT_TRUE(exact >= trials - (trials + 19) / 20);
}

static void test_of_three_views_it_is_told_that_only_two_agree(void)
{
    test_rng rng = test_seed(606);
    int told = 0, exact = 0, trials = TEST_TRIALS(200);

    WANTS_RIG;
    for (int trial = 0; trial < trials; trial++) {
        uint8_t used[N];

        simulate(&rng, 3, NOISE);
        spoil(&rng, trial % 3, test_uniform(&rng, 5, 60));
        if (rigcal_point_measure(&point, used, &m.s) == RIGCAL_FEW_AGREE) {
            told++;
            TEST_ASSERT_EQUAL_UINT64(2, point.n_used);
            exact += used[trial % 3] == 0;
        }
    }
    TEST_ASSERT_TRUE(told >= trials * 95 / 100);
    TEST_ASSERT_TRUE(exact >= trials * 94 / 100);
}

static void test_views_that_do_not_show_one_point_are_told(void)
{
    test_rng rng = test_seed(607);

    WANTS_RIG;
    simulate(&rng, 4, 0);
    spoil(&rng, 1, 30);
    m.s.keep_all = 1;
    ASSERT_STATUS(RIGCAL_POOR_FIT, rigcal_point_measure(&point, NULL, &m.s));
    TEST_ASSERT_TRUE(D(point.chi2) > 1000);
    TEST_ASSERT_EQUAL_UINT64(4, point.n_used);

    /* Two views, one of them moved across the matching line. */
    simulate(&rng, 2, 0);
    m.seen[1].uv[1] += 40;
    ASSERT_STATUS(RIGCAL_POOR_FIT, rigcal_point_measure(&point, NULL, &m.s));

    simulate(&rng, 3, 0);
    for (int i = 0; i < 3; i++) { /* no pair agrees */
        m.seen[i].uv[1] += RC(i == 1 ? -80 : i == 2 ? 30 : 120);
    }
    ASSERT_REFUSED(RIGCAL_ERR_NO_CONSENSUS, point,
                   rigcal_point_measure(&point, NULL, &m.s));
}

/* The rig's F says how much more than noise right views differ. */
static void test_limits_grow_with_what_views_of_the_rig_disagree(void)
{
    test_rng rng = test_seed(608);
    int dropped = 0, dropped_with_F = 0;

    WANTS_RIG;
    for (int trial = 0; trial < TEST_TRIALS(60); trial++) {
        simulate(&rng, 5, 5 * NOISE);
        TEST_ASSERT_TRUE(rigcal_point_measure(&point, NULL, &m.s) >= 0);
        dropped += 5 - (int)point.n_used;
        m.rig.F = 10000;
        TEST_ASSERT_TRUE(rigcal_point_measure(&point, NULL, &m.s) >= 0);
        dropped_with_F += 5 - (int)point.n_used;
    }
    TEST_ASSERT_TRUE(dropped > 0);
    TEST_ASSERT_EQUAL_INT(0, dropped_with_F);
}

/* More than 16 views: 120 pairs are tried. Two thirds of the views are right. */
static void test_many_views_with_a_third_of_them_wrong(void)
{
    test_rng rng = test_seed(609);
    int exact = 0, trials = TEST_TRIALS(20);

    WANTS_RIG;
    for (int trial = 0; trial < trials; trial++) {
        uint8_t used[N];
        int is_exact = 1;

        simulate(&rng, N, NOISE);
        for (int i = 0; i < N; i += 3) {
            spoil(&rng, i, test_uniform(&rng, 8, 60));
        }
        ASSERT_STATUS(RIGCAL_VIEWS_LEFT_OUT, rigcal_point_measure(&point, used, &m.s));
        for (int i = 0; i < N; i++) {
            is_exact = is_exact && used[i] == (i % 3 != 0);
        }
        exact += is_exact;
    }
    TEST_ASSERT_TRUE(exact >= trials - (trials + 9) / 10);
}

/* If there are many views, pairs are tried in the order of their angles, the widest
 * first. */
static void test_the_pair_of_the_widest_angle_is_tried_first(void)
{
    test_rng rng = test_seed(613);
    rigcal_point_solver solver;
    double last = 1;
    size_t tried = 0;

    WANTS_RIG;
    simulate(&rng, N, NOISE);
    for (int i = 0; i < N; i += 3) {
        spoil(&rng, i, 40);
    }
    memset(&solver, 0, sizeof solver); /* its pairs are read before they are begun */
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_begin(&solver, &m.s));
    while (rigcal_point_step(&solver, 1) == RIGCAL_RUNNING) {
        double ray[2][3], across[3], sine2;

        if (solver.pair == tried || solver.pair > solver.n_pairs) {
            continue;
        }
        tried = solver.pair;
        for (int k = 0; k < 2; k++) {
            test_to_double(ray[k], rc_sights_of(&solver)[solver.two[k]].ray, 3);
        }
        test_cross(across, ray[0], ray[1]);
        sine2 =
            test_dot(across, across) / test_dot(ray[0], ray[0]) / test_dot(ray[1], ray[1]);
        TEST_ASSERT_TRUE(sine2 <= last * (1 + TOL(1e-9, 1e-3)));
        last = sine2;
    }
    TEST_ASSERT_GREATER_THAN_size_t(10, tried);
}

/* ---- steps ---------------------------------------------------------------------- */

static void test_any_budgets_give_the_same_bits(void)
{
    static rigcal_point_gain once_gains[N];
    test_rng rng = test_seed(610);
    rigcal_point_solver solver;
    rigcal_measured_point once;
    uint8_t used_once[N], used[N];

    WANTS_RIG;
    for (int trial = 0; trial < 4; trial++) {
        const int n = trial == 3 ? N : 3 + trial;
        rigcal_status status;
        int units = 0;

        simulate(&rng, n, NOISE);
        spoil(&rng, 1, 25);
        status = rigcal_point_measure(&point, used_once, &m.s);
        once = point;
        memcpy(once_gains, gains, sizeof gains);
        for (int32_t budget = 1; budget < 100; budget += 7) {
            memset(m.work, 0x5a, sizeof m.work);
            ASSERT_STATUS(RIGCAL_OK, rigcal_point_begin(&solver, &m.s));
            units = 0;
            while (rigcal_point_step(&solver, budget) == RIGCAL_RUNNING) {
                units++;
            }
            memset(gains, 0, sizeof gains);
            ASSERT_STATUS(status, rigcal_point_result(&point, used, &solver));
            TEST_ASSERT_EQUAL_MEMORY(&once, &point, sizeof once);
            TEST_ASSERT_EQUAL_MEMORY(once_gains, gains, point.n_used * sizeof gains[0]);
            TEST_ASSERT_EQUAL_MEMORY(used_once, used, (size_t)n);
        }
    }
}

/* With n views: each is checked, its ray computed, evaluated two or three times, and its
 * rows computed. */
static void test_units_are_views(void)
{
    test_rng rng = test_seed(611);
    rigcal_point_solver solver;
    int units = 0;

    WANTS_RIG;
    simulate(&rng, 8, NOISE);
    m.s.keep_all = 1;
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_begin(&solver, &m.s));
    while (rigcal_point_step(&solver, 1) == RIGCAL_RUNNING) {
        units++;
    }
    TEST_ASSERT_TRUE(units + 1 >= 4 * 8 && units + 1 <= 7 * 8);
}

static void test_a_solver_tells_its_state(void)
{
    test_rng rng = test_seed(612);
    rigcal_point_solver solver;

    WANTS_RIG;
    simulate(&rng, 3, NOISE);
    memset(&solver, 0, sizeof solver);
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_point_step(&solver, 1));
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_point_result(&point, NULL, &solver));
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_begin(&solver, &m.s));
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_point_result(&point, NULL, &solver));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_point_step(&solver, -1));
    ASSERT_STATUS(RIGCAL_RUNNING, rigcal_point_step(&solver, 1));
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_step(&solver, 1000));
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_step(&solver, 1000));
    point.gains_capacity = 2;
    ASSERT_STATUS(RIGCAL_ERR_CAPACITY, rigcal_point_result(&point, NULL, &solver));
}

/* ---- what has no answer ----------------------------------------------------------- */

static void look(int i, double x, double y, double z, double yaw_about_y)
{
    static const double UP[3] = {0, 1, 0};
    const double at[3] = {x, y, z};
    double R[9], t[3];

    m.cameras[i].camera = test_pinhole();
    test_rotation_about(R, UP, yaw_about_y);
    test_apply(t, R, at, NULL);
    for (int k = 0; k < 3; k++) {
        t[k] = -t[k];
    }
    m.cameras[i].cam_from_rig = test_transform(R, t);
    m.seen[i].uv[0] = RC(319.5);
    m.seen[i].uv[1] = RC(239.5);
    m.noise[i] = RC(NOISE);
}

static void test_zero_parallax_has_a_status(void)
{
    WANTS_RIG;
    clear(2, 1);
    fill_covariance(1, 1);
    look(0, 0, 0, 0, 0); /* side by side, with the same pixel */
    look(1, 1, 0, 0, 0);
    ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, point, rigcal_point_measure(&point, NULL, &m.s));
    look(1, 0, 0, 0, 0); /* from the same place */
    ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, point, rigcal_point_measure(&point, NULL, &m.s));
    look(1, 0, 0, 5, TEST_PI); /* each camera is in the middle of the other's image, at its
                                  epipole */
    ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, point, rigcal_point_measure(&point, NULL, &m.s));
    m.seen[0].uv[0] += RC(0.5); /* and next to it */
    ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, point, rigcal_point_measure(&point, NULL, &m.s));
}

static void test_the_least_parallax_is_the_callers(void)
{
    WANTS_RIG;
    clear(2, 1);
    fill_covariance(1, 1);
    look(0, 0, 0, 0, 0);
    look(1, 1, 0, 0, 0);
    m.seen[1].uv[0] -= RC(800 * tan(5 * TEST_PI / 180)); /* 5 degrees */
    memset(&point, 0, sizeof point);
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_measure(&point, NULL, &m.s));
    ASSERT_NEAR(5 * TEST_PI / 180, point.parallax, TOL(1e-9, 1e-5));
    ASSERT_NEAR(1 / tan(5 * TEST_PI / 180), point.X[2], TOL(1e-6, 1e-2));
    m.s.parallax_least = RC(4.99 * TEST_PI / 180);
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_measure(&point, NULL, &m.s));
    m.s.parallax_least = RC(5.01 * TEST_PI / 180);
    ASSERT_REFUSED(RIGCAL_ERR_PARALLEL, point, rigcal_point_measure(&point, NULL, &m.s));
}

/* If the caller states no limit, it is 0.1 degree. */
static void test_the_least_parallax_is_a_tenth_of_a_degree(void)
{
    WANTS_RIG;
    for (int more = 0; more < 2; more++) {
        const double angle = (more ? 0.1005 : 0.0995) * TEST_PI / 180;

        clear(2, 1);
        fill_covariance(1, 1);
        look(0, 0, 0, 0, 0);
        look(1, 1, 0, 0, 0);
        m.seen[1].uv[0] -= RC(800 * tan(angle));
        memset(&point, 0, sizeof point);
        ASSERT_STATUS(more ? RIGCAL_OK : RIGCAL_ERR_PARALLEL,
                      rigcal_point_measure(&point, NULL, &m.s));
    }
}

static void test_a_point_behind_a_camera_has_a_status(void)
{
    WANTS_RIG;
    clear(2, 1);
    fill_covariance(1, 1);
    look(0, 0, 0, 0, 0);
    look(1, 1, 0, 0, 0);
    m.seen[1].uv[0] += 80; /* the rays do not meet in front */
    ASSERT_REFUSED(RIGCAL_ERR_BEHIND, point, rigcal_point_measure(&point, NULL, &m.s));
    clear(3, 1);
    fill_covariance(2, 1);
    look(0, 0, 0, 0, 0);
    look(1, 1, 0, 0, 0);
    look(2, 2, 0, 0, 0);
    m.seen[1].uv[0] -= 80; /* of three views it is dropped: the other two show a point 10
                              ahead */
    m.seen[2].uv[0] += 80;
    memset(&point, 0, sizeof point);
    ASSERT_STATUS(RIGCAL_FEW_AGREE, rigcal_point_measure(&point, NULL, &m.s));
    ASSERT_NEAR(10, point.X[2], TOL(1e-6, 1e-2));
}

/* Views 0, 1 and 3 show a point 10 ahead. Camera 2 cannot have seen it: it looks back, or
 * so far to the side that its lens folds before that; then also where the formula of the
 * lens has the point beyond the fold. */
static void test_a_camera_that_cannot_see_the_point_is_left_out(void)
{
    static const double X[3] = {0, 0, 10};

    WANTS_RIG;
    for (int k = 0; k < 3; k++) {
        const int is_aside = k > 0, is_spurious = k == 2;
        uint8_t used[N];

        clear(4, 1);
        fill_covariance(3, 1);
        look(0, 0, 0, 0, 0);
        look(1, 1, 0, 0, 0);
        look(2, 2, 0, 0, is_aside ? TEST_PI / 3 : TEST_PI);
        m.cameras[2].camera.k1 = RC(is_aside ? -0.4 : 0);
        look(3, -1, 0, 0, 0);
        m.seen[1].uv[0] -= 80;
        m.seen[3].uv[0] += 80;
        if (is_spurious) {
            double R[9], t[3], X_c[3], uv[2];

            test_transform_parts(R, t, &m.cameras[2].cam_from_rig);
            test_apply(X_c, R, X, t);
            test_project_px(uv, &m.cameras[2].camera, X_c);
            test_to_real(m.seen[2].uv, uv, 2);
        }
        ASSERT_STATUS(RIGCAL_VIEWS_LEFT_OUT, rigcal_point_measure(&point, used, &m.s));
        TEST_ASSERT_EQUAL_INT(0, used[2]);
        TEST_ASSERT_EQUAL_UINT64(3, point.n_used);
        ASSERT_NEAR(10, point.X[2], TOL(1e-6, 1e-2));
    }
}

/* A barrel lens folds 490 pixels from the middle. Beyond that there is no ray. */
static void test_a_pixel_beyond_a_lens_has_a_status(void)
{
    test_rng rng = test_seed(613);
    uint8_t used[N];

    WANTS_RIG;
    simulate(&rng, 4, NOISE);
    m.cameras[2].camera = test_pinhole();
    m.cameras[2].camera.k1 = RC(-0.4);
    m.seen[2].uv[0] = 5000;
    m.s.keep_all = 1;
    ASSERT_REFUSED(RIGCAL_ERR_NO_RAY, point, rigcal_point_measure(&point, NULL, &m.s));
    m.s.keep_all = 0; /* and is dropped */
    memset(&point, 0, sizeof point);
    ASSERT_STATUS(RIGCAL_VIEWS_LEFT_OUT, rigcal_point_measure(&point, used, &m.s));
    TEST_ASSERT_EQUAL_INT(0, used[2]);
    TEST_ASSERT_EQUAL_UINT64(3, point.n_used);
}

/* Each of two cameras has a covariance, and gives a point together with the exact camera.
 * Their joint covariance has a correlation of 2, so it is no covariance. */
static void test_a_joint_covariance_that_is_none_has_a_status(void)
{
    test_rng rng = test_seed(622);

    WANTS_RIG;
    simulate(&rng, 3, 0);
    memset(m.Sigma, 0, sizeof m.Sigma);
    for (int i = 3; i < 6; i++) {
        const int j = i + 6;

        m.Sigma[i * (i + 1) / 2 + i] = m.Sigma[j * (j + 1) / 2 + j] = RC(0.01);
        m.Sigma[j * (j + 1) / 2 + i] = RC(0.02);
    }
    ASSERT_REFUSED(RIGCAL_ERR_DEGENERATE, point, rigcal_point_measure(&point, NULL, &m.s));
    m.seen[2] = m.seen[1];
    m.s.n = 2; /* without the third camera it is a covariance */
    memset(&point, 0, sizeof point);
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_measure(&point, NULL, &m.s));
    ASSERT_ARRAY_NEAR(m.X, point.X, 3, TOL(1e-11, 1e-4));
}

static void test_cameras_without_a_common_frame_are_refused(void)
{
    test_rng rng = test_seed(614);

    WANTS_RIG;
    simulate(&rng, 3, NOISE);
    m.group[2] = 1;
    ASSERT_REFUSED(RIGCAL_DISCONNECTED, point, rigcal_point_measure(&point, NULL, &m.s));
    m.s.n = 2;
    memset(&point, 0, sizeof point);
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_measure(&point, NULL, &m.s));
}

/* ---- cameras that count as exact ---------------------------------------------------- */

static void test_without_a_joint_covariance_there_is_noise_alone(void)
{
    static rigcal_point_gain other_gains[N];
    test_rng rng = test_seed(615);
    rigcal_measured_point held;
    rigcal_real distance, sigma;

    WANTS_RIG;
    simulate(&rng, 3, NOISE);
    memset(m.held, 1, sizeof m.held);
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_measure(&point, NULL, &m.s));
    held = point;
    TEST_ASSERT_EQUAL_MEMORY(held.Sigma_noise, held.Sigma, sizeof held.Sigma);
    m.rig.sigma_px = 0;
    m.rig.Sigma = NULL;
    m.rig.held = NULL;
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_measure(&point, NULL, &m.s));
    TEST_ASSERT_EQUAL_MEMORY(&held, &point, sizeof held);
    memcpy(other_gains, gains, sizeof gains);
    held.gains = other_gains;
    held.X[0] += 1; /* another point with the same noise, which no camera shares */
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_point_distance(&distance, &sigma, &m.rig, &held, &point));
    ASSERT_NEAR(1, distance, TOL(1e-12, 1e-5));
    ASSERT_NEAR(sqrt(2 * D(point.Sigma_noise[0])), sigma, TOL(1e-9, 1e-4) * D(sigma));
    m.s.sigma_px = NULL;
    ASSERT_REFUSED(RIGCAL_ERR_STATE, point, rigcal_point_measure(&point, NULL, &m.s));
}

/* A larger noise of its own makes a view count less. If no noise is given, each view has
 * that of the rig. */
static void test_the_noise_is_the_rigs_if_no_other_is_given(void)
{
    test_rng rng = test_seed(616);
    rigcal_measured_point all;

    WANTS_RIG;
    simulate(&rng, 3, NOISE);
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_measure(&point, NULL, &m.s));
    all = point;
    m.s.sigma_px = NULL;
    m.rig.sigma_px = RC(NOISE);
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_measure(&point, NULL, &m.s));
    TEST_ASSERT_EQUAL_MEMORY(&all, &point, sizeof all);
}

/* Two views by one camera, of a target that stands still, count like one view with less
 * noise. */
static void test_a_camera_may_see_a_point_twice(void)
{
    test_rng rng = test_seed(617);
    rigcal_measured_point once;
    double expected[9];

    WANTS_RIG;
    simulate(&rng, 3, 0);
    m.noise[2] = RC(NOISE / sqrt(2));
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_measure(&point, NULL, &m.s));
    once = point;
    m.noise[2] = RC(NOISE);
    m.seen[3] = m.seen[2];
    m.s.n = 4;
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_measure(&point, NULL, &m.s));
    test_to_double(expected, once.Sigma, 9);
    ASSERT_ARRAY_NEAR(expected, point.Sigma, 9, TOL(1e-9, 1e-3) * largest(expected, 9));
}

/* ---- arguments ----------------------------------------------------------------------- */

static void test_arguments_are_checked(void)
{
    test_rng rng = test_seed(618);
    rigcal_sightings s;

    WANTS_RIG;
    simulate(&rng, 3, NOISE);
    ASSERT_REFUSED(RIGCAL_ERR_NULL, point, rigcal_point_measure(&point, NULL, NULL));
    s = m.s;
    s.n = 1;
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, point, rigcal_point_measure(&point, NULL, &s));
    s.n = RIGCAL_SIGHTINGS_MAX + 1;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, point, rigcal_point_measure(&point, NULL, &s));
    s = m.s;
    s.work_capacity = RIGCAL_POINT_WORK(3) - 1;
    ASSERT_REFUSED(RIGCAL_ERR_CAPACITY, point, rigcal_point_measure(&point, NULL, &s));
    s.work_capacity++;
    memset(&point, 0, sizeof point);
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_measure(&point, NULL, &s));
    s.parallax_least = RC(1.6);
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, point, rigcal_point_measure(&point, NULL, &s));
    s.parallax_least = TEST_NAN;
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, point, rigcal_point_measure(&point, NULL, &s));
    s = m.s;
    s.keep_all = 2;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, point, rigcal_point_measure(&point, NULL, &s));
    m.seen[1].camera = 3;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, point, rigcal_point_measure(&point, NULL, &m.s));
    m.seen[1].camera = 1;
    m.noise[1] = 0;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, point, rigcal_point_measure(&point, NULL, &m.s));
    m.noise[1] = 1;
    m.cameras[1].cam_from_rig.R[0] = 2;
    ASSERT_REFUSED(RIGCAL_ERR_ROTATION, point, rigcal_point_measure(&point, NULL, &m.s));
    TEST_ASSERT_EQUAL_UINT64(RIGCAL_POINT_WORK(5), rigcal_point_work(5));
    TEST_ASSERT_EQUAL_UINT64(RIGCAL_POINT_WORK(17), rigcal_point_work(17));
}

static void test_arguments_of_a_length_are_checked(void)
{
    test_rng rng = test_seed(619);
    rigcal_real distance = 0, sigma = 0;
    rigcal_measured_point other;

    WANTS_RIG;
    simulate(&rng, 3, NOISE);
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_measure(&point, NULL, &m.s));
    other = point;
    ASSERT_REFUSED(RIGCAL_ERR_COINCIDENT, distance,
                   rigcal_point_distance(&distance, &sigma, &m.rig, &point, &other));
    other.X[0] += 1;
    other.gains = NULL;
    ASSERT_REFUSED(RIGCAL_ERR_NULL, distance,
                   rigcal_point_distance(&distance, &sigma, &m.rig, &point, &other));
    other.gains = gains;
    other.n_used = 1;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, distance,
                   rigcal_point_distance(&distance, &sigma, &m.rig, &point, &other));
    other.n_used = 3;
    other.Sigma_noise[4] = TEST_NAN;
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, distance,
                   rigcal_point_distance(&distance, &sigma, &m.rig, &point, &other));
    other.Sigma_noise[4] = 0;
    gains[1].camera = 7;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, distance,
                   rigcal_point_distance(&distance, &sigma, &m.rig, &point, &other));
    gains[1].camera = 1;
    gains[1].gain[3] = TEST_INF;
    ASSERT_REFUSED(RIGCAL_ERR_NOT_FINITE, distance,
                   rigcal_point_distance(&distance, &sigma, &m.rig, &point, &other));
}

/* Without a covariance, all else in a calibrated rig is still checked. */
static void test_a_rig_without_a_covariance_is_checked(void)
{
    test_rng rng = test_seed(620);
    rigcal_calibrated_rig rig;
    rigcal_sightings s;

    WANTS_RIG;
    simulate(&rng, 3, NOISE);
    rig = m.rig;
    s = m.s;
    s.rig = &rig;
    rig.sigma_px = 0;
    rig.cameras = NULL;
    ASSERT_REFUSED(RIGCAL_ERR_NULL, point, rigcal_point_measure(&point, NULL, &s));
    rig.cameras = m.rig.cameras;
    rig.group = NULL;
    ASSERT_REFUSED(RIGCAL_ERR_NULL, point, rigcal_point_measure(&point, NULL, &s));
    rig.group = m.rig.group;
    rig.n_cameras = (size_t)RIGCAL_STORE_CAMERAS_MAX + 1;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, point, rigcal_point_measure(&point, NULL, &s));
    rig.n_cameras = RIGCAL_STORE_CAMERAS_MAX;
    ASSERT_REFUSED(RIGCAL_ERR_CAPACITY, point, rigcal_point_measure(&point, NULL, &s));
    rig.n_cameras = 0;
    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, point, rigcal_point_measure(&point, NULL, &s));
    rig.n_cameras = m.rig.n_cameras;
    rig.capacity = rig.n_cameras - 1;
    ASSERT_REFUSED(RIGCAL_ERR_CAPACITY, point, rigcal_point_measure(&point, NULL, &s));
    rig.capacity = m.rig.capacity;
    rig.sigma_px = -1;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, point, rigcal_point_measure(&point, NULL, &s));
}

static void test_a_length_between_groups_is_refused(void)
{
    static int32_t group[16];
    test_rng rng = test_seed(621);
    rigcal_real distance = 0, sigma = 0;
    rigcal_point_gain of_other[3];
    rigcal_measured_point other;

    WANTS_RIG;
    simulate(&rng, 3, NOISE);
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_measure(&point, NULL, &m.s));
    memcpy(of_other, gains, sizeof of_other);
    other = point;
    other.gains = of_other;
    other.X[0] += 1;
    of_other[1].camera = -1;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, distance,
                   rigcal_point_distance(&distance, &sigma, &m.rig, &point, &other));
    of_other[1].camera = 1;
    other.n_used = RIGCAL_SIGHTINGS_MAX + 1;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, distance,
                   rigcal_point_distance(&distance, &sigma, &m.rig, &point, &other));
    other.n_used = 3;
    group[2] = 1;
    m.rig.group = group;
    of_other[0].camera = 2;
    ASSERT_REFUSED(RIGCAL_DISCONNECTED, distance,
                   rigcal_point_distance(&distance, &sigma, &m.rig, &point, &other));
    of_other[0].camera = 0;
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_point_distance(&distance, &sigma, &m.rig, &point, &other));
}

/* Views 0 and 1 see one point, 2 and 3 another one. As many agree with each. Of equals that
 * of the least sum wins, whichever is tried first. */
static void test_of_equal_points_that_of_the_least_misfit_wins(void)
{
    WANTS_RIG;
    for (int which = 0; which < 2; which++) {
        uint8_t used[N];

        clear(4, 4);
        m.rig.sigma_px = 0;
        look(0, -1, 0, 0, 0);
        look(1, 1, 0, 0, 0);
        look(2, -1.1, 1, 0, 0);
        look(3, 1.1, 1, 0, 0);
        m.seen[0].uv[0] += 80; /* 10 ahead */
        m.seen[1].uv[0] -= 80;
        m.seen[2].uv[0] += 176; /* 5 ahead */
        m.seen[3].uv[0] -= 176;
        m.seen[which ? 0 : 2].uv[1] += RC(1.5 * NOISE); /* the misfit */
        ASSERT_STATUS(RIGCAL_FEW_AGREE, rigcal_point_measure(&point, used, &m.s));
        ASSERT_NEAR(which ? 5 : 10, point.X[2], 0.05);
        for (int i = 0; i < 4; i++) {
            TEST_ASSERT_EQUAL_INT((i >= 2) == which, used[i]);
        }
    }
}

/* View 2 is midway between views 0 and 1, and d pixels off, along u or v. View 3 is wrong.
 * The mean of two views has half the variance of one, so view 2 agrees if d^2 < 9.21 (1 +
 * 1/2) noise^2: 3.717 deviations. If the rig's views differ by more than noise, sqrt(F)
 * times that square is allowed. An F below 1 narrows no limit. */
static void test_the_limit_of_agreement_counts_the_noise_of_both(void)
{
    static const double F[4] = {0.5, 1, 1.5, 9};

    WANTS_RIG;
    for (int k = 0; k < 16; k++) {
        const double wider = sqrt(sqrt(fmax(1, F[k / 4])));

        clear(4, 4);
        m.rig.sigma_px = 0;
        m.rig.F = RC(F[k / 4]);
        look(0, -1, 0, 0, 0);
        look(1, 1, 0, 0, 0);
        look(2, 0, 0, 0, 0);
        look(3, 0.5, 0, 0, 0);
        m.seen[0].uv[0] += 80; /* 10 ahead */
        m.seen[1].uv[0] -= 80;
        m.seen[2].uv[k / 2 % 2] += RC(NOISE * wider * (k % 2 ? 3.8 : 3.63));
        m.seen[3].uv[0] -= 40;
        m.seen[3].uv[1] += 100;
        const rigcal_status status = rigcal_point_measure(&point, NULL, &m.s);
        ASSERT_STATUS(k % 2 ? RIGCAL_FEW_AGREE : RIGCAL_VIEWS_LEFT_OUT, status);
    }
}

TEST_MAIN()
{
    RUN_TEST(test_the_limit_of_agreement_counts_the_noise_of_both);
    RUN_TEST(test_of_equal_points_that_of_the_least_misfit_wins);
    RUN_TEST(test_points_are_those_of_dense_algebra);
    RUN_TEST(test_lengths_are_those_of_dense_algebra);
    RUN_TEST(test_a_point_of_exact_views_is_where_it_is);
    RUN_TEST(test_gains_are_what_moved_cameras_do);
    RUN_TEST(test_a_length_takes_points_of_different_cameras);
    RUN_TEST(test_views_of_misplaced_cameras_are_not_wrong);
    RUN_TEST(test_the_order_of_views_does_not_matter);
    RUN_TEST(test_views_that_are_right_are_all_used);
    RUN_TEST(test_wrong_views_are_named);
    RUN_TEST(test_of_three_views_it_is_told_that_only_two_agree);
    RUN_TEST(test_views_that_do_not_show_one_point_are_told);
    RUN_TEST(test_limits_grow_with_what_views_of_the_rig_disagree);
    RUN_TEST(test_many_views_with_a_third_of_them_wrong);
    RUN_TEST(test_the_pair_of_the_widest_angle_is_tried_first);
    RUN_TEST(test_any_budgets_give_the_same_bits);
    RUN_TEST(test_units_are_views);
    RUN_TEST(test_a_solver_tells_its_state);
    RUN_TEST(test_zero_parallax_has_a_status);
    RUN_TEST(test_the_least_parallax_is_the_callers);
    RUN_TEST(test_the_least_parallax_is_a_tenth_of_a_degree);
    RUN_TEST(test_a_point_behind_a_camera_has_a_status);
    RUN_TEST(test_a_camera_that_cannot_see_the_point_is_left_out);
    RUN_TEST(test_a_pixel_beyond_a_lens_has_a_status);
    RUN_TEST(test_a_joint_covariance_that_is_none_has_a_status);
    RUN_TEST(test_cameras_without_a_common_frame_are_refused);
    RUN_TEST(test_without_a_joint_covariance_there_is_noise_alone);
    RUN_TEST(test_the_noise_is_the_rigs_if_no_other_is_given);
    RUN_TEST(test_a_camera_may_see_a_point_twice);
    RUN_TEST(test_arguments_are_checked);
    RUN_TEST(test_arguments_of_a_length_are_checked);
    RUN_TEST(test_a_rig_without_a_covariance_is_checked);
    RUN_TEST(test_a_length_between_groups_is_refused);
}
