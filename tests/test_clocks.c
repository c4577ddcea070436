/* clocks: the cameras' clocks as unknowns of the adjustment. The truth is made with paths
 * of a hand and cameras that are late by known times, and with dense least squares of the
 * same model. */
#include <math.h>
#include <string.h>

#include "rc_cost.h"
#include "rigcal_solvers.h"
#include "test_motions.h"

static test_motions m;

#define WANTS_MOTIONS() TEST_WANTS_RAM(sizeof(test_motions) + 60000)

static const motion_scene SCENE = {3, 3, 3, 30, 0.35, 0.8, 10, 0.01, 0, 0, 0.3};

static void make(const motion_scene *scene, uint64_t seed)
{
    test_rng rng = test_seed(seed);

    test_motions_make(&m, &rng, scene);
    test_motions_solve(&m);
}

/* Leaves the views of which `is_kept` is true. */
static void keep_views(int (*is_kept)(int camera, int placement))
{
    size_t n = 0;

    for (size_t v = 0; v < m.rig.n_views; v++) {
        if (is_kept(m.views[v].camera, m.views[v].placement)) {
            m.views[n] = m.views[v];
            m.own[n++] = m.own[v];
        }
    }
    m.rig.n_views = n;
}

static rigcal_status adjust(rigcal_rig_fit *fit)
{
    int32_t at_fault = -2;

    m.rig.clocks = &m.clocks;
    return rigcal_rig_adjust(fit, &at_fault, &m.rig);
}

/* ---- nothing to find ------------------------------------------------------ */

static void test_clocks_that_are_known_and_right_change_no_bit(void)
{
    rigcal_transform cams[MOTION_CAMERAS_MAX], places[MOTION_PLACES_MAX];
    rigcal_real Sigma[36], with[36];
    rigcal_rig_fit fit, again;

    WANTS_MOTIONS();
    make(&SCENE, 1);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &m.rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(Sigma, &m.rig, 1, 2));
    memcpy(cams, m.cams, sizeof cams);
    memcpy(places, m.places, sizeof places);
    test_motions_reset(&m);
    m.clocks.free_offsets = 0;
    ASSERT_STATUS(RIGCAL_OK, adjust(&again));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(with, &m.rig, 1, 2));
    TEST_ASSERT_EQUAL_MEMORY(cams, m.cams, sizeof cams);
    TEST_ASSERT_EQUAL_MEMORY(places, m.places, sizeof places);
    TEST_ASSERT_EQUAL_MEMORY(Sigma, with, sizeof Sigma);
    TEST_ASSERT_EQUAL_MEMORY(&fit, &again, sizeof fit);
}

/* ---- clocks are found ----------------------------------------------------- */

static void expect_clocks(double limit)
{
    rigcal_real sigma[MOTION_CAMERAS_MAX], rates[MOTION_CAMERAS_MAX];

    ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_sigma(sigma, rates, &m.rig, RC(0.3)));
    for (size_t c = 0; c < m.rig.n_cameras; c++) {
        const double off = D(m.offsets[c]) - m.true_offsets[c];

        TEST_ASSERT_EQUAL_INT32(c > 0 ? RIGCAL_CLOCK_FREE : RIGCAL_CLOCK_HELD, m.states[c]);
        if (c == 0) {
            ASSERT_NEAR(0, sigma[c], 0);
            ASSERT_NEAR(0, m.offsets[c], 0);
        } else {
            TEST_ASSERT_TRUE(D(sigma[c]) > 0 && D(sigma[c]) < 1e-3);
            ASSERT_NEAR(0, off / D(sigma[c]), limit);
        }
        if (m.clocks.free_drifts && c > 0) {
            TEST_ASSERT_TRUE(D(rates[c]) > 0);
            ASSERT_NEAR(0, (D(m.drifts[c]) - m.true_drifts[c]) / D(rates[c]), limit);
        } else {
            ASSERT_NEAR(0, rates[c], 0);
        }
    }
}

static void test_clocks_that_differ_are_found(void)
{
    WANTS_MOTIONS();
    for (int trial = 0; trial < TEST_TRIALS(12); trial++) {
        double inverse[4 * 6 * 6];
        rigcal_rig_fit fit;

        make(&SCENE, 10 + (uint64_t)trial);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &m.rig));
        TEST_ASSERT_TRUE(D(fit.F) > 1.5);
        ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
        TEST_ASSERT_TRUE(fit.evals < 30);
        ASSERT_NEAR(1, fit.F, 0.6);
        ASSERT_NEAR(0.3, fit.sigma_px, 0.03);
        ASSERT_NEAR(2.0 * 3 * 9 * 20 - 2 * 6 - 9 * 6 - 2, fit.freedom, 0);
        expect_clocks(4.5);
        test_motions_information(inverse, &m, 0.3);
        TEST_ASSERT_TRUE(test_motions_error2(&m, inverse) < 4);
    }
}

static void test_clocks_that_drift_are_found(void)
{
    motion_scene scene = SCENE;
    rigcal_rig_fit fit;

    WANTS_MOTIONS();
    scene.runs = 4;
    scene.drift = 1e-4;
    make(&scene, 30);
    m.clocks.drifts = m.drifts;
    m.clocks.free_drifts = 1;
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    ASSERT_NEAR(1, fit.F, 0.6);
    ASSERT_NEAR(2.0 * 3 * 12 * 20 - 2 * 6 - 12 * 6 - 4, fit.freedom, 0);
    expect_clocks(4.5);
}

/* ---- dense least squares of the same model -------------------------------- */

enum {
    LOCAL = 15, /* unknowns of a view: camera, placement, offset, drift, its own time */
    DENSE = 6 * 2 + 6 * 6 + 2 * 2 + 18
};

static double H[DENSE][DENSE], g[DENSE];

/* The d of the curve through placement f and all others of its run, in Lagrange's form. */
static void curve(double d[6], int f, double after, int frames)
{
    const int first = f / frames * frames;
    double R[9], t[3];

    test_transform_parts(R, t, &m.places[f]);
    memset(d, 0, 6 * sizeof d[0]);
    for (int i = first; i < first + frames; i++) {
        const double node = D(m.instants[i]) - D(m.instants[f]);
        double weight = 1, R_i[9], t_i[3], turn[9], R_t[9];

        for (int j = first; j < first + frames; j++) {
            const double other = D(m.instants[j]) - D(m.instants[f]);
            weight *= j == i ? 1 : (after - other) / (node - other);
        }
        test_transform_parts(R_i, t_i, &m.places[i]);
        test_transpose(R_t, R);
        test_product(turn, R_i, R_t);
        double w[3] = {turn[7] - turn[5], turn[2] - turn[6], turn[3] - turn[1]};
        const double sine = test_norm(w) / 2;
        for (int k = 0; k < 3; k++) {
            d[k] += weight * w[k] / 2 * (sine > 0 ? asin(sine) / sine : 1);
            d[3 + k] += weight * (t_i[k] - t[k]);
        }
    }
}

static rigcal_transform moved(const rigcal_transform *T, const double d[6])
{
    double R[9], t[3], turn[9], out[9], axis[3];
    const double angle = test_norm(d);

    test_transform_parts(R, t, T);
    for (int k = 0; k < 3; k++) {
        axis[k] = angle > 0 ? d[k] / angle : (k == 0);
        t[k] += d[3 + k];
    }
    test_rotation_about(turn, axis, angle);
    test_product(out, turn, R);
    return test_transform(out, t);
}

/* The residuals of view v after its unknowns moved by x. The curve about its placement
 * moves as a whole; its shape does not change. */
static void residuals(double e[2 * MOTION_POINTS], size_t v, const double x[LOCAL],
                      int frames)
{
    const int c = m.views[v].camera, f = m.views[v].placement;
    const double middle = D(m.times[m.rig.n_placements - 1]) / 2;
    const double stamp = D(m.view_times[v]);
    const double after = stamp + D(m.offsets[c]) + x[12] +
                         (D(m.drifts[c]) + x[13]) * (stamp - middle) + x[14] -
                         D(m.instants[f]);
    double d[6], R[9], t[3];

    curve(d, f, after, frames);
    const rigcal_transform cam = moved(&m.cams[c], x), place = moved(&m.places[f], d);
    const rigcal_transform seen = moved(&place, &x[6]), T = test_times(&cam, &seen);
    test_transform_parts(R, t, &T);
    for (int i = 0; i < MOTION_POINTS; i++) {
        double X_c[3];

        test_apply(X_c, R, m.X[i], t);
        test_project_px(&e[2 * i], &m.camera, X_c);
        e[2 * i] = D(m.o[v][i].uv[0]) - e[2 * i];
        e[2 * i + 1] = D(m.o[v][i].uv[1]) - e[2 * i + 1];
    }
}

/* Adds the view to H and g. of[k] is the global number of its unknown k, or -1. */
static double add_dense(size_t v, const int of[LOCAL], int frames)
{
    const double h = 1e-5;
    double e[2 * MOTION_POINTS], J[LOCAL][2 * MOTION_POINTS], low[2 * MOTION_POINTS],
        x[LOCAL];
    double sum = 0;

    memset(x, 0, sizeof x);
    residuals(e, v, x, frames);
    for (int k = 0; k < LOCAL; k++) {
        x[k] = h;
        residuals(J[k], v, x, frames);
        x[k] = -h;
        residuals(low, v, x, frames);
        x[k] = 0;
        for (int i = 0; i < 2 * MOTION_POINTS; i++) {
            J[k][i] = (low[i] - J[k][i]) / (2 * h); /* derivative of the projection */
        }
    }
    for (int i = 0; i < 2 * MOTION_POINTS; i++) {
        sum += e[i] * e[i];
        for (int a = 0; a < LOCAL; a++) {
            g[of[a] < 0 ? 0 : of[a]] += of[a] < 0 ? 0 : J[a][i] * e[i];
            for (int b = 0; b < LOCAL; b++) {
                if (of[a] >= 0 && of[b] >= 0) {
                    H[of[a]][of[b]] += J[a][i] * J[b][i];
                }
            }
        }
    }
    return sum;
}

/* Replaces the first n rows and columns of H by their inverse. */
static void invert(int n)
{
    for (int p = 0; p < n; p++) {
        const double pivot = H[p][p];

        TEST_ASSERT_TRUE(pivot > 0);
        H[p][p] = 1;
        for (int j = 0; j < n; j++) {
            H[p][j] /= pivot;
        }
        for (int i = 0; i < n; i++) {
            const double part = H[i][p];

            if (i != p) {
                H[i][p] = 0;
                for (int j = 0; j < n; j++) {
                    H[i][j] -= part * H[p][j];
                }
            }
        }
    }
}

/* Compares with the dense minimum: the remaining step in sigmas of each unknown, and the
 * covariances of cameras and clocks. own: the sigma of a view's own time over that of a
 * pixel; 0: it has none. */
static void expect_dense_minimum(int frames, double own, double step_limit,
                                 double sigma_limit)
{
    const int n_cams = (int)m.rig.n_cameras - 1, n_places = (int)m.rig.n_placements;
    const int n_clocks = n_cams * (m.clocks.free_drifts ? 2 : 1);
    const int at_clock = 6 * (n_cams + n_places), at_own = at_clock + n_clocks;
    const int n = at_own + (own > 0 ? (int)m.rig.n_views : 0);
    rigcal_real sigma[MOTION_CAMERAS_MAX], rates[MOTION_CAMERAS_MAX], Sigma[36];

    TEST_ASSERT_TRUE(n <= DENSE);
    memset(H, 0, sizeof H);
    memset(g, 0, sizeof g);
    for (size_t v = 0; v < m.rig.n_views; v++) {
        const int c = m.views[v].camera, f = m.views[v].placement;
        int of[LOCAL];

        for (int k = 0; k < 6; k++) {
            of[k] = c > 0 ? 6 * (c - 1) + k : -1;
            of[6 + k] = 6 * (n_cams + f) + k;
        }
        of[12] = c > 0 ? at_clock + c - 1 : -1;
        of[13] = c > 0 && m.clocks.free_drifts ? at_clock + n_cams + c - 1 : -1;
        of[14] = own > 0 ? at_own + (int)v : -1;
        (void)add_dense(v, of, frames);
        if (own > 0) {
            H[of[14]][of[14]] += 1 / (own * own);
        }
    }
    invert(n);
    for (int i = 0; i < at_own; i++) {
        double step = 0;

        for (int j = 0; j < n; j++) {
            step += H[i][j] * g[j];
        }
        ASSERT_NEAR(0, step / (0.3 * sqrt(H[i][i])), step_limit);
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_sigma(sigma, rates, &m.rig, 1));
    for (int c = 1; c <= n_cams; c++) {
        const int at = 6 * (c - 1), clock = at_clock + c - 1;

        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(Sigma, &m.rig, 1, (size_t)c));
        for (int k = 0; k < 36; k++) {
            const double scale =
                sqrt(H[at + k / 6][at + k / 6] * H[at + k % 6][at + k % 6]);
            ASSERT_NEAR(H[at + k / 6][at + k % 6] / scale, D(Sigma[k]) / scale,
                        sigma_limit);
        }
        ASSERT_NEAR(1, D(sigma[c]) / sqrt(H[clock][clock]), sigma_limit);
        if (m.clocks.free_drifts) {
            ASSERT_NEAR(1, D(rates[c]) / sqrt(H[clock + n_cams][clock + n_cams]),
                        sigma_limit);
        }
    }
}

static const motion_scene SMALL = {3, 2, 3, 30, 0.35, 0.8, 10, 0.01, 0, 0, 0.3};

static void test_the_answer_is_the_dense_minimum(void)
{
    WANTS_MOTIONS();
    TEST_ON_HOST_ONLY("the dense inverse takes minutes");
    for (int trial = 0; trial < 4; trial++) {
        rigcal_rig_fit fit;
        motion_scene scene = SMALL;

        scene.frames = trial % 2 == 0 ? 3 : 5;
        scene.runs = trial % 2 == 0 ? 2 : 1;
        make(&scene, 50 + (uint64_t)trial);
        ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
        /* the ends of a run of five follow the noise of their neighbours with a lag of one
         * step */
        expect_dense_minimum(scene.frames, 0, scene.frames > 3 ? 0.25 : TOL(0.12, 0.2),
                             TOL(0.01, 0.05));
    }
}

static void test_the_answer_with_drifts_is_the_dense_minimum(void)
{
    rigcal_rig_fit fit;
    motion_scene scene = SMALL;

    WANTS_MOTIONS();
    TEST_ON_HOST_ONLY("the dense inverse takes minutes");
    scene.drift = 3e-4;
    make(&scene, 60);
    m.clocks.drifts = m.drifts;
    m.clocks.free_drifts = 1;
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    expect_dense_minimum(3, 0, TOL(0.12, 0.2), TOL(0.01, 0.03));
}

/* ---- noise of stamps ------------------------------------------------------ */

/* Noise of stamps has the same effect as a time of each view as an unknown with that
 * sigma. */
static void test_noise_of_stamps_is_a_free_time_of_each_view(void)
{
    rigcal_rig_fit fit;
    motion_scene scene = SMALL;

    WANTS_MOTIONS();
    TEST_ON_HOST_ONLY("the dense inverse takes minutes");
    scene.stamp = 1e-4;
    make(&scene, 70);
    m.rig.sigma_px = RC(0.3);
    m.clocks.sigma_time = RC(1e-3);
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    expect_dense_minimum(3, 1e-3 / 0.3, TOL(0.12, 0.2), TOL(0.01, 0.03));
}

static void test_stamps_with_noise_leave_the_noise_of_pixels(void)
{
    double without = 0, with = 0;

    WANTS_MOTIONS();
    for (int trial = 0; trial < TEST_TRIALS(8); trial++) {
        rigcal_rig_fit fit;
        motion_scene scene = SCENE;

        scene.stamp = 0.004;
        scene.offset = 0;
        make(&scene, 80 + (uint64_t)trial);
        m.clocks.free_offsets = 0;
        ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
        without += D(fit.sigma_px) / TEST_TRIALS(8);
        test_motions_reset(&m);
        m.clocks.sigma_time = RC(0.004); /* sigma_px is that of the views by themselves */
        ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
        with += D(fit.sigma_px) / TEST_TRIALS(8);
    }
    TEST_ASSERT_TRUE(without > 0.36);
    ASSERT_NEAR(0.3, with, TEST_ONE_IN > 1 ? 0.02 : 0.009);
}

/* Known stamps of single views are better than one stamp for all. */
static void test_the_stamp_of_a_view_counts(void)
{
    rigcal_rig_fit fit;

    WANTS_MOTIONS();
    make(&SCENE, 90);
    m.clocks.free_offsets = 0;
    for (size_t v = 0; v < m.rig.n_views; v++) {
        m.view_times[v] += (rigcal_real)m.true_offsets[m.views[v].camera];
    }
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    TEST_ASSERT_TRUE(D(fit.F) > 1.5);
    test_motions_reset(&m);
    m.clocks.view_times = m.view_times;
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    ASSERT_NEAR(1, fit.F, 0.6);
    m.view_times[4] = TEST_NAN; /* an unknown stamp is that of the placement */
    m.view_times[7] = TEST_INF;
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
}

/* ---- what is not known ---------------------------------------------------- */

static void expect_held(int32_t state)
{
    rigcal_real sigma[MOTION_CAMERAS_MAX];
    rigcal_rig_fit fit;

    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_sigma(sigma, NULL, &m.rig, 1));
    for (size_t c = 1; c < m.rig.n_cameras; c++) {
        TEST_ASSERT_EQUAL_INT32(state, m.states[c]);
        ASSERT_NEAR(0, m.offsets[c], 0);
        ASSERT_NEAR(0, sigma[c], 0);
    }
    ASSERT_NEAR(2.0 * 3 * 9 * 20 - 2 * 6 - 9 * 6, fit.freedom, 0);
}

static void test_clocks_of_a_target_that_stands_still_are_held(void)
{
    motion_scene scene = SCENE;

    WANTS_MOTIONS();
    scene.speed = scene.turn = 0;
    make(&scene, 100);
    expect_held(RIGCAL_CLOCK_STILL);
    scene.speed = 0.001; /* a hundredth of a pixel in a frame */
    make(&scene, 101);
    expect_held(RIGCAL_CLOCK_STILL);
    test_motions_reset(&m);
    m.rig.view_poses = NULL; /* the noise is then that of the rig */
    expect_held(RIGCAL_CLOCK_STILL);
}

/* Leaves the corners of the board. */
static void keep_three_points(void)
{
    for (size_t v = 0; v < m.rig.n_views; v++) {
        m.o[v][1] = m.o[v][4];
        m.o[v][2] = m.o[v][19];
        m.views[v].view.n = 3;
    }
}

/* Every picture is the same, so the target stands still whatever the noise of a pixel.
 * Three points do not tell that noise. */
static void test_equal_pictures_have_no_motion(void)
{
    motion_scene scene = SCENE;
    rigcal_rig_fit fit;

    WANTS_MOTIONS();
    scene.speed = scene.turn = scene.noise_px = 0;
    scene.runs = 1;
    make(&scene, 106);
    keep_three_points();
    for (size_t v = 3; v < m.rig.n_views; v++) {
        memcpy(m.o[v], m.o[v - 3], sizeof m.o[v]);
    }
    for (size_t f = 1; f < m.rig.n_placements; f++) {
        m.places[f] = m.places[0];
    }
    m.rig.view_poses = NULL;
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CLOCK_STILL, m.states[1]);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CLOCK_STILL, m.states[2]);
}

static void test_clocks_of_single_pictures_are_held(void)
{
    motion_scene scene = SCENE;

    WANTS_MOTIONS();
    scene.runs = 9;
    scene.frames = 1;
    make(&scene, 102);
    expect_held(RIGCAL_CLOCK_ALONE);
    m.clocks.frame = RC(1.0 / 30);
    make(&SCENE, 103);
    for (int f = 0; f < 9; f++) {
        m.times[f] = TEST_NAN;
    }
    expect_held(RIGCAL_CLOCK_ALONE);
}

/* A known clock is not an unknown, and the other clocks are relative to it. */
static void test_a_clock_that_is_known_is_held(void)
{
    const uint8_t held[3] = {0, 0, 1};
    rigcal_rig_fit fit;

    WANTS_MOTIONS();
    make(&SCENE, 104);
    m.clocks.held = held;
    m.offsets[2] = (rigcal_real)(0.02 + m.true_offsets[2]);
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    ASSERT_NEAR(0.02 + m.true_offsets[2], m.offsets[2], TOL(1e-15, 1e-7));
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CLOCK_HELD, m.states[2]);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CLOCK_FREE, m.states[0]);
    for (int c = 0; c < 2; c++) {
        ASSERT_NEAR(0.02 + m.true_offsets[c], m.offsets[c], 1.5e-3);
    }
    ASSERT_NEAR(1, fit.F, 0.6);
}

/* Any number but 0 holds a clock. If none is held, that of the first camera is. */
static void test_each_clock_is_held_or_free(void)
{
    static const uint8_t HELD[5][3] = {
        {0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 1, 2}, {1, 1, 1}};
    static const uint8_t IS_FREE[5][3] = {
        {0, 1, 1}, {0, 1, 1}, {1, 0, 1}, {1, 0, 0}, {0, 0, 0}};
    rigcal_rig_fit fit;

    WANTS_MOTIONS();
    for (int k = 0; k < 5; k++) {
        make(&SCENE, 105);
        m.clocks.held = HELD[k];
        TEST_ASSERT_TRUE(adjust(&fit) >= 0);
        for (int c = 0; c < 3; c++) {
            TEST_ASSERT_EQUAL_INT32(IS_FREE[k][c] ? RIGCAL_CLOCK_FREE : RIGCAL_CLOCK_HELD,
                                    m.states[c]);
            if (!IS_FREE[k][c]) {
                ASSERT_NEAR(0, m.offsets[c], 0);
            }
        }
    }
}

/* Here no drift is estimated. */
static void test_drifts_that_are_held_are_exact(void)
{
    const uint8_t held[3] = {0, 0, 1};
    rigcal_real offsets[3], drifts[3];
    rigcal_rig_fit fit;

    WANTS_MOTIONS();
    make(&SCENE, 104);
    m.clocks.held = held;
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_sigma(offsets, drifts, &m.rig, RC(0.3)));
    for (int c = 0; c < 3; c++) {
        TEST_ASSERT_EQUAL_INT(!held[c], D(offsets[c]) > 0);
        ASSERT_NEAR(0, drifts[c], 0);
    }
}

/* The clock of a camera without views does not change. */
static void test_the_clock_of_a_camera_without_views_is_left_alone(void)
{
    rigcal_rig_fit fit;

    WANTS_MOTIONS();
    make(&SCENE, 105);
    m.offsets[2] = RC(0.25);
    m.rig.left_out = m.left_out;
    for (size_t v = 0; v < m.rig.n_views; v++) {
        m.left_out[v] = m.views[v].camera == 2;
    }
    ASSERT_STATUS(RIGCAL_DISCONNECTED, adjust(&fit));
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CLOCK_HELD, m.states[2]);
    ASSERT_NEAR(0.25, m.offsets[2], 0);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CLOCK_FREE, m.states[1]);
    ASSERT_NEAR(m.true_offsets[1], m.offsets[1], 1.5e-3);
}

/* ---- the other functions of a rig ----------------------------------------- */

static void test_what_is_left_is_of_views_at_their_times(void)
{
    rigcal_real duv[2 * MOTION_POINTS], noise[3], freedom[3], Sigma[36];
    double sum = 0;
    rigcal_rig_fit fit;
    size_t n;

    WANTS_MOTIONS();
    make(&SCENE, 110);
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    for (size_t v = 0; v < m.rig.n_views; v++) {
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_rig_residuals(duv, 2 * MOTION_POINTS, &n, &m.rig, v));
        for (size_t i = 0; i < 2 * n; i++) {
            sum += D(duv[i]) * D(duv[i]);
        }
    }
    ASSERT_NEAR(1, D(fit.sum) / sum, TOL(2e-3, 1e-2));
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_noise(noise, freedom, &m.rig));
    for (int c = 0; c < 3; c++) {
        ASSERT_NEAR(0.3, noise[c], 0.04);
    }
    ASSERT_NEAR(D(fit.freedom), D(freedom[0]) + D(freedom[1]) + D(freedom[2]), 4);
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_placement(Sigma, &m.rig, RC(0.3), 4));
    for (int k = 0; k < 6; k++) {
        TEST_ASSERT_TRUE(D(Sigma[7 * k]) > 0);
    }
}

/* The frame of the rig may be changed after the adjustment: what is left does not depend on
 * it. */
static void test_what_is_left_does_not_depend_on_the_frame(void)
{
    rigcal_real duv[2 * MOTION_POINTS];
    static double sums[MOTION_VIEWS_MAX];
    test_rng rng = test_seed(118);
    rigcal_rig_fit fit;
    size_t n;

    WANTS_MOTIONS();
    make(&SCENE, 118);
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    for (int is_moved = 0; is_moved < 2; is_moved++) {
        const rigcal_transform move = test_random_transform(&rng),
                               back = test_inverse(&move);

        for (size_t c = 0; c < m.rig.n_cameras && is_moved; c++) {
            m.cams[c] = test_times(&m.cams[c], &back);
        }
        for (size_t f = 0; f < m.rig.n_placements && is_moved; f++) {
            m.places[f] = test_times(&move, &m.places[f]);
        }
        for (size_t v = m.rig.n_views; v-- > 0;) {
            double sum = 0;

            ASSERT_STATUS(RIGCAL_OK,
                          rigcal_rig_residuals(duv, 2 * MOTION_POINTS, &n, &m.rig, v));
            for (size_t i = 0; i < 2 * n; i++) {
                sum += D(duv[i]) * D(duv[i]);
            }
            if (is_moved) {
                ASSERT_NEAR(sums[v], sum, TOL(1e-6, 0.05) * sums[v]);
            }
            sums[v] = sum;
        }
    }
}

/* Clocks that differ look like wrong views. If they are known, they do not. */
static void test_no_view_is_named_for_its_clock(void)
{
    static rigcal_judged_view judged[MOTION_VIEWS_MAX];
    static uint8_t takes[MOTION_VIEWS_MAX];
    rigcal_judgement judgement;
    rigcal_choice choice = {0};
    rigcal_rig_fit fit;

    WANTS_MOTIONS();
    make(&SCENE, 111);
    choice.takes = takes;
    choice.sigma_px = RC(0.3);
    m.rig.left_out = m.left_out;
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_rig_judge(&judgement, NULL, judged, m.left_out, &choice, &m.rig));
    TEST_ASSERT_EQUAL_INT32((int32_t)m.rig.n_views, judgement.n_fit);
    ASSERT_NEAR(1, judgement.fit.F, 0.6);
    expect_clocks(4.5);
}

/* Camera 1 is late while the target moves. The place that it claims is that of the
 * placement's instant. The pixels are exact. */
static void test_a_claim_is_of_the_instant_of_the_placement(void)
{
    static rigcal_judged_view judged[MOTION_VIEWS_MAX];
    static uint8_t takes[MOTION_VIEWS_MAX];
    rigcal_choice choice = {0};
    rigcal_judge_solver solver;
    motion_scene scene = SCENE;
    double most = 0;

    WANTS_MOTIONS();
    scene.frames = 4;
    scene.runs = 2;
    scene.noise_px = 0;
    make(&scene, 119);
    m.clocks.free_offsets = 0;
    test_to_real(m.offsets, m.true_offsets, 3);
    m.rig.clocks = &m.clocks;
    m.rig.left_out = m.left_out;
    choice.takes = takes;
    choice.sigma_px = RC(0.3);
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_judge_begin(&solver, judged, m.left_out, &choice, &m.rig));
    while (rigcal_judge_step(&solver, 1000) == RIGCAL_RUNNING) {
    }
    for (size_t v = 0; v < m.rig.n_views; v++) {
        const int f = m.views[v].placement;
        const rigcal_transform at_view =
            test_motions_at(&m, f, m.true_offsets[m.views[v].camera]);
        rc_claim claim;
        double moves = 0;

        solver.placement = (size_t)f;
        ASSERT_STATUS(RIGCAL_OK, rc_judge_claim(&claim, &solver, v, 0, 0));
        for (int k = 0; k < 3; k++) {
            moves += fabs(D(at_view.t[k]) - D(m.places[f].t[k]));
        }
        most = fmax(most, moves);
        ASSERT_TRANSFORM(&m.places[f], &claim.b_from_a, 2e-4, 2e-4);
    }
    TEST_ASSERT_TRUE(most > 1e-3);
}

static void test_wrong_points_are_left_out_with_clocks_too(void)
{
    rigcal_rig_fit fit;
    size_t n_wrong = 0;

    WANTS_MOTIONS();
    make(&SCENE, 112);
    m.rig.sigma_px = RC(0.3);
    for (size_t v = 0; v < m.rig.n_views; v += 2) {
        m.o[v][v % MOTION_POINTS].uv[0] += 30;
    }
    m.rig.clocks = &m.clocks;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust_robust(&fit, &n_wrong, NULL, &m.rig));
    TEST_ASSERT_TRUE(n_wrong >= (m.rig.n_views + 1) / 2 &&
                     n_wrong < (m.rig.n_views + 1) / 2 + 4);
    ASSERT_NEAR(0.3, fit.sigma_px, 0.03);
    expect_clocks(4.5);
}

static void test_the_bits_are_those_of_any_budget(void)
{
    static rigcal_rig_solver solver;
    rigcal_transform cams[MOTION_CAMERAS_MAX];
    rigcal_real offsets[MOTION_CAMERAS_MAX];
    rigcal_rig_fit fit, again;

    WANTS_MOTIONS();
    make(&SCENE, 113);
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    memcpy(cams, m.cams, sizeof cams);
    memcpy(offsets, m.offsets, sizeof offsets);
    for (int32_t budget = 1; budget < 12; budget += 5) {
        test_motions_reset(&m);
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_begin(&solver, &m.rig));
        while (rigcal_rig_step(&solver, budget) == RIGCAL_RUNNING) {
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_result(&again, NULL, &solver));
        TEST_ASSERT_EQUAL_MEMORY(cams, m.cams, sizeof cams);
        TEST_ASSERT_EQUAL_MEMORY(offsets, m.offsets, sizeof offsets);
        TEST_ASSERT_EQUAL_MEMORY(&fit, &again, sizeof fit);
    }
}

/* ---- when a clock is free -------------------------------------------------- */

/* The sum of squares by which the pixels of view v move, to first order, when the target
 * goes on to the other placement of its run of two. */
static double step_of(size_t v)
{
    const double h = 1e-3;
    const int c = m.views[v].camera, f = m.views[v].placement, to = f ^ 1;
    double d[6], x[6], uv[2][2 * MOTION_POINTS], sum = 0;

    curve(d, f, D(m.instants[to]) - D(m.instants[f]), 2);
    for (int side = 0; side < 2; side++) {
        double R[9], t[3];

        for (int k = 0; k < 6; k++) {
            x[k] = (side ? h : -h) * d[k];
        }
        const rigcal_transform place = moved(&m.places[f], x);
        const rigcal_transform T = test_times(&m.cams[c], &place);
        test_transform_parts(R, t, &T);
        for (int i = 0; i < MOTION_POINTS; i++) {
            double X_c[3];

            test_apply(X_c, R, m.X[i], t);
            test_project_px(&uv[side][2 * i], &m.camera, X_c);
        }
    }
    for (int i = 0; i < 2 * MOTION_POINTS; i++) {
        sum += pow((uv[1][i] - uv[0][i]) / (2 * h), 2);
    }
    return sum;
}

/* Cameras 1 and 2 do not see the run of their number. */
static int sees_other_runs(int camera, int placement)
{
    return camera == 0 || placement / 2 != camera;
}

/* A clock is free if the step to the next placement is more than ten times its noise, in
 * the mean of the camera's views that have a neighbour. A placement is as exact as its
 * number of views times the first of them. */
static void test_a_clock_is_free_where_the_target_moves_by_ten_sigma(void)
{
    motion_scene scene = SCENE;
    const double near = TOL(0.01, 0.03);

    WANTS_MOTIONS();
    scene.runs = 4;
    scene.frames = 2;
    scene.offset = scene.noise_px = 0;
    for (int c = 1; c < 3; c++) {
        for (int is_free = 0; is_free < 2; is_free++) {
            double sum = 0, views = 0, first = 0;
            rigcal_rig_fit fit;

            make(&scene, 107);
            keep_views(sees_other_runs);
            m.times[6] = TEST_NAN; /* so the last two have no neighbour */
            memcpy(m.instants, m.times, sizeof m.instants);
            for (size_t v = 0; v < m.rig.n_views; v++) {
                const int f = m.views[v].placement;
                const int is_first = v == 0 || m.views[v - 1].placement != f;
                const double seen = 3 - (f == 2 || f == 3) - (f == 4 || f == 5);

                if (f < 6) {
                    first = is_first ? seen * step_of(v) : first;
                    sum += m.views[v].camera == c ? first : 0;
                    views += m.views[v].camera == c;
                }
            }
            m.rig.sigma_px =
                (rigcal_real)sqrt(sum / (100 * views) * (is_free ? 1 - near : 1 + near));
            ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
            TEST_ASSERT_EQUAL_INT32(is_free ? RIGCAL_CLOCK_FREE : RIGCAL_CLOCK_STILL,
                                    m.states[c]);
        }
    }
}

/* Camera 2 sees placement 4 only. */
static int is_of_two_or_fourth(int camera, int placement)
{
    return camera < 2 || placement == 4;
}

/* A single view that has a neighbour is enough for a clock that is not ALONE. Its camera's
 * pose can take up what the clock could, so the clock stays where it is. */
static void test_a_camera_with_one_view_is_not_alone(void)
{
    rigcal_rig_fit fit;

    WANTS_MOTIONS();
    make(&SCENE, 108);
    keep_views(is_of_two_or_fourth);
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CLOCK_FREE, m.states[1]);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CLOCK_FREE, m.states[2]);
    ASSERT_NEAR(m.true_offsets[1], m.offsets[1], 1.5e-3);
    ASSERT_NEAR(0, m.offsets[2], 1e-3);
}

/* One camera has no other clock to compare its own with. */
static void test_one_camera_keeps_its_clock(void)
{
    motion_scene scene = SCENE;
    rigcal_real sigma[1];
    rigcal_rig_fit fit;

    WANTS_MOTIONS();
    scene.cameras = 1;
    make(&scene, 109);
    m.offsets[0] = RC(0.125);
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CLOCK_HELD, m.states[0]);
    ASSERT_NEAR(0.125, m.offsets[0], 0);
    ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_sigma(sigma, NULL, &m.rig, 1));
    ASSERT_NEAR(0, sigma[0], 0);
    ASSERT_NEAR(2.0 * 9 * 20 - 9 * 6, fit.freedom, 0);
}

/* The clock of the last camera is known. Those of the others drift from it. */
static void test_the_drift_of_the_first_camera_is_found_too(void)
{
    static const uint8_t held[3] = {0, 0, 1};
    rigcal_real sigma[3], rates[3];
    motion_scene scene = SCENE;
    rigcal_rig_fit fit;

    WANTS_MOTIONS();
    scene.runs = 4;
    scene.drift = 3e-4;
    make(&scene, 31);
    m.clocks.held = held;
    m.clocks.drifts = m.drifts;
    m.clocks.free_drifts = 1;
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_sigma(sigma, rates, &m.rig, RC(0.3)));
    for (int c = 0; c < 2; c++) {
        const double late = m.true_offsets[c] - m.true_offsets[2];
        const double rate = m.true_drifts[c] - m.true_drifts[2];

        TEST_ASSERT_EQUAL_INT32(RIGCAL_CLOCK_FREE, m.states[c]);
        TEST_ASSERT_TRUE(D(sigma[c]) > 0 && D(rates[c]) > 0);
        ASSERT_NEAR(0, (D(m.offsets[c]) - late) / D(sigma[c]), 4.5);
        ASSERT_NEAR(0, (D(m.drifts[c]) - rate) / D(rates[c]), 4.5);
    }
    ASSERT_NEAR(0, m.drifts[2], 0);
    ASSERT_NEAR(0, rates[2], 0);
}

/* ---- the same answer -------------------------------------------------------- */

/* Times may have any unit. One of 2^-10 s changes no digit: what has the unit of a time is
 * 2^10 times as large. */
static void test_the_unit_of_time_changes_no_bit(void)
{
    rigcal_transform cams[MOTION_CAMERAS_MAX], places[MOTION_PLACES_MAX];
    rigcal_real offsets[3], drifts[3], sigma[2][3], rates[2][3];
    rigcal_rig_fit fit[2];
    motion_scene scene = SCENE;

    WANTS_MOTIONS();
    scene.drift = 1e-4;
    scene.stamp = 1e-4;
    for (int way = 0; way < 3; way++) {
        for (int i = 0; i < 2; i++) {
            const rigcal_real unit = i ? 1024 : 1;

            make(&scene, 114);
            m.clocks.frame = unit / 30;
            m.clocks.sigma_time = way == 2 ? unit * RC(1e-3) : 0;
            m.clocks.drifts = way > 0 ? m.drifts : NULL;
            m.clocks.free_drifts = way > 0;
            for (size_t f = 0; f < m.rig.n_placements; f++) {
                m.times[f] *= unit;
            }
            ASSERT_STATUS(RIGCAL_OK, adjust(&fit[i]));
            ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_sigma(sigma[i], rates[i], &m.rig, 1));
            if (i == 0) {
                memcpy(cams, m.cams, sizeof cams);
                memcpy(places, m.places, sizeof places);
                memcpy(offsets, m.offsets, sizeof offsets);
                memcpy(drifts, m.drifts, sizeof drifts);
            }
        }
        TEST_ASSERT_EQUAL_MEMORY(cams, m.cams, sizeof cams);
        TEST_ASSERT_EQUAL_MEMORY(places, m.places, sizeof places);
        TEST_ASSERT_EQUAL_MEMORY(&fit[0], &fit[1], sizeof fit[0]);
        for (int c = 0; c < 3; c++) {
            ASSERT_NEAR(1024 * D(offsets[c]), m.offsets[c], 0);
            ASSERT_NEAR(drifts[c], m.drifts[c], 0);
            ASSERT_NEAR(1024 * D(sigma[0][c]), sigma[1][c], 0);
            ASSERT_NEAR(rates[0][c], rates[1][c], 0);
        }
    }
}

/* What is not written is not read, even where views are left out. */
static void test_what_was_in_the_memory_does_not_matter(void)
{
    rigcal_transform cams[MOTION_CAMERAS_MAX];
    const rigcal_real CONTENTS[3] = {0, RC(1e9), TEST_NAN};
    rigcal_real offsets[3], drifts[3], sigma[2][3];
    rigcal_rig_fit fit[2];
    motion_scene scene = SCENE;

    WANTS_MOTIONS();
    scene.drift = 1e-4;
    for (int way = 0; way < 3; way++) {
        const int is_first = way == 0;

        make(&scene, 115);
        m.clocks.drifts = m.drifts;
        m.clocks.free_drifts = 1;
        m.rig.left_out = m.left_out;
        for (size_t v = 0; v < m.rig.n_views; v++) {
            m.left_out[v] = v % 5 == 0;
        }
        for (size_t i = 0; i < MOTION_WORK; i++) {
            m.work[i] = CONTENTS[way];
        }
        ASSERT_STATUS(RIGCAL_OK, adjust(&fit[!is_first]));
        ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_sigma(sigma[!is_first], NULL, &m.rig, 1));
        if (is_first) {
            memcpy(cams, m.cams, sizeof cams);
            memcpy(offsets, m.offsets, sizeof offsets);
            memcpy(drifts, m.drifts, sizeof drifts);
            continue;
        }
        TEST_ASSERT_EQUAL_MEMORY(cams, m.cams, sizeof cams);
        TEST_ASSERT_EQUAL_MEMORY(offsets, m.offsets, sizeof offsets);
        TEST_ASSERT_EQUAL_MEMORY(drifts, m.drifts, sizeof drifts);
        TEST_ASSERT_EQUAL_MEMORY(sigma[0], sigma[1], sizeof sigma[0]);
        TEST_ASSERT_EQUAL_MEMORY(&fit[0], &fit[1], sizeof fit[0]);
    }
}

/* A source of views that have the pixels of others wherever a step is tried. Each view is
 * asked for once when it is checked, and once where a search is. A step that is tried asks
 * twice. */
static size_t n_asked;

static rigcal_status spoiled(rigcal_rig_view *view, size_t index, void *context)
{
    const size_t n = m.rig.n_views, at = n_asked++;

    (void)context;
    *view = m.views[index];
    if (at >= 2 * n && (at - 2 * n) % (3 * n) < 2 * n) {
        view->view.observations = m.o[n - 1 - index];
    }
    return RIGCAL_OK;
}

/* A step that does not help is undone: cameras, offsets and drifts are those of before. */
static void test_a_step_that_does_not_help_is_undone(void)
{
    rigcal_transform cams[MOTION_CAMERAS_MAX];
    motion_scene scene = SCENE;
    rigcal_rig_fit fit;

    WANTS_MOTIONS();
    scene.drift = 1e-4;
    make(&scene, 116);
    m.clocks.drifts = m.drifts;
    m.clocks.free_drifts = 1;
    m.rig.view_poses = NULL;
    m.rig.views = NULL;
    m.rig.view_source = spoiled;
    n_asked = 0;
    memcpy(cams, m.cams, sizeof cams);
    TEST_ASSERT_TRUE(adjust(&fit) >= 0);
    TEST_ASSERT_TRUE(n_asked > 4 * m.rig.n_views);
    TEST_ASSERT_EQUAL_MEMORY(cams, m.cams, sizeof cams);
    for (int c = 0; c < 3; c++) {
        ASSERT_NEAR(0, m.offsets[c], 0);
        ASSERT_NEAR(0, m.drifts[c], 0);
    }
    for (size_t f = 0; f < m.rig.n_placements; f++) {
        ASSERT_NEAR(m.times[f], m.instants[f], TOL(1e-12, 1e-5));
    }
}

/* ---- what is handed in ----------------------------------------------------- */

/* The clocks are known. Cameras 1 and 2 are not in all placements; one is seen by camera 1
 * alone. */
static void test_the_instant_of_a_placement_is_the_mean_time_of_its_views(void)
{
    static const double OFFSETS[3] = {0, 0.004, -0.0075};
    double sum[9] = {0}, views[9] = {0};
    rigcal_rig_fit fit;
    size_t n = 0;

    WANTS_MOTIONS();
    make(&SCENE, 117);
    m.clocks.free_offsets = 0;
    m.clocks.view_times = m.view_times;
    for (size_t v = 0; v < m.rig.n_views; v++) {
        const int c = m.views[v].camera, f = m.views[v].placement;

        if (f == 4 ? c == 1 : f % 3 != 0 || c < 2) {
            m.views[n] = m.views[v];
            m.own[n] = m.own[v];
            m.view_times[n] = m.times[f] + RC(1e-3 * (f % 4));
            sum[f] += D(m.view_times[n++]) + OFFSETS[c];
            views[f]++;
        }
    }
    m.rig.n_views = n;
    test_to_real(m.offsets, OFFSETS, 3);
    TEST_ASSERT_TRUE(adjust(&fit) >= 0);
    for (int f = 0; f < 9; f++) {
        ASSERT_NEAR(sum[f] / views[f], m.instants[f], TOL(1e-9, 1e-5));
    }
}

/* The clocks are known. In a run of one placement it has no neighbours, and its motion is
 * not known. In a run of two each has one. */
static void test_a_placement_without_neighbours_stays_at_its_stamp(void)
{
    static const double OFFSETS[3] = {0, 0.004, -0.0075};

    WANTS_MOTIONS();
    for (int frames = 1; frames <= 2; frames++) {
        motion_scene scene = SCENE;
        rigcal_rig_fit fit;

        scene.runs = 4;
        scene.frames = frames;
        make(&scene, 118);
        m.clocks.free_offsets = 0;
        test_to_real(m.offsets, OFFSETS, 3);
        TEST_ASSERT_TRUE(adjust(&fit) >= 0);
        for (int f = 0; f < 4 * frames; f++) {
            ASSERT_NEAR(D(m.times[f]) + (frames == 1 ? 0 : -0.0035 / 3), m.instants[f],
                        TOL(1e-9, 1e-5));
        }
    }
}

/* A placement that nobody saw has no time. */
static void test_a_placement_without_views_has_no_instant(void)
{
    rigcal_rig_fit fit;

    WANTS_MOTIONS();
    make(&SCENE, 91);
    const size_t f = m.rig.n_placements++;
    m.places[f] = m.places[0];
    m.times[f] = m.times[f - 1] + 1;
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    TEST_ASSERT_TRUE(D(m.instants[f]) > TOL(1e30, 1e9));
    TEST_ASSERT_TRUE(D(m.instants[f - 1]) < TOL(1e30, 1e9));
}

/* Placement 4 is seen by camera 0 only. */
static int is_first_in_fourth(int camera, int placement)
{
    return placement != 4 || camera == 0;
}

/* The instant of a placement is the mean time of its views. The first camera's clock is
 * right. */
static void test_a_placement_seen_once_has_the_time_of_that_view(void)
{
    rigcal_rig_fit fit;

    WANTS_MOTIONS();
    make(&SCENE, 95);
    keep_views(is_first_in_fourth);
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    ASSERT_NEAR(m.times[4], m.instants[4], TOL(1e-12, 1e-5));
    ASSERT_NEAR(m.times[3], m.instants[3], 0.02);
    TEST_ASSERT_TRUE(fabs(D(m.instants[3]) - D(m.times[3])) > TOL(1e-9, 1e-4));
    expect_clocks(4.5);
}

/* Views of three points fit with any noise, so the ratio of the noises of stamps and pixels
 * is unknown. */
static void test_without_the_noise_of_pixels_stamps_have_no_weight(void)
{
    rigcal_rig_fit fit;

    WANTS_MOTIONS();
    make(&SCENE, 92);
    m.rig.view_poses = NULL;
    m.clocks.sigma_time = RC(1e-3);
    keep_three_points();
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, fit, adjust(&fit));
    for (size_t v = 0; v < m.rig.n_views; v++) {
        m.own[v].n = 3;
        m.own[v].sse = RC(1e-6); /* what a search left */
    }
    m.rig.view_poses = m.own;
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, fit, adjust(&fit));
    m.rig.view_poses = NULL;
    m.rig.sigma_px = RC(0.3);
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
}

/* (H11): the noise of a pixel is the stated one, or that of the views by themselves. */
static void test_the_weight_of_a_stamp_is_that_of_the_noises(void)
{
    static const double STAMPS[3] = {1e-3, 0.02, 0.5};

    WANTS_MOTIONS();
    for (int way = 0; way < (RIGCAL_USE_FLOAT ? 4 : 6); way++) { /* the last says little */
        const double stamp = STAMPS[way / 2];
        double sum = 0, freedom = 0, variance = 0.0625;
        rigcal_rig_fit fit;

        make(&SCENE, 97);
        m.clocks.sigma_time = RC(stamp);
        m.rig.sigma_px = way % 2 ? RC(0.25) : 0;
        for (size_t v = 0; v < m.rig.n_views && way % 2 == 0; v++) {
            sum += D(m.own[v].sse);
            freedom += 2 * (double)m.own[v].n - 6;
            variance = sum / freedom;
        }
        TEST_ASSERT_TRUE(adjust(&fit) >= 0);
        ASSERT_NEAR(1, D(m.clocks.memory.ratio2) * stamp * stamp / variance,
                    TOL(1e-12, 1e-5));
        m.clocks.sigma_time = 0; /* nothing of it is left */
        ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
        ASSERT_NEAR(0, m.clocks.memory.ratio2, 0);
        if (way == 0) { /* views that fit to a thousandth of a pixel */
            test_motions_reset(&m);
            m.clocks.sigma_time = RC(stamp);
            for (size_t v = 0; v < m.rig.n_views; v++) {
                m.own[v].sse *= RC(1e-5);
            }
            TEST_ASSERT_TRUE(1e-5 * sum < 1);
            (void)adjust(&fit);
            ASSERT_NEAR(1, D(m.clocks.memory.ratio2) * stamp * stamp / (1e-5 * variance),
                        TOL(1e-12, 1e-5));
        }
    }
}

/* Views that are left out are as good as none. */
static void test_views_that_are_left_out_leave_no_trace(void)
{
    static uint8_t left_out[MOTION_VIEWS_MAX];
    rigcal_real offsets[2][3], sigma[2][3], Sigma[2][36];
    rigcal_rig_fit fit[2];

    WANTS_MOTIONS();
    for (int is_short = 0; is_short < 2; is_short++) {
        size_t n = 0;

        make(&SCENE, 99);
        m.rig.view_poses = NULL;
        for (size_t v = 0; v < m.rig.n_views; v++) {
            left_out[v] = v % 4 == 1;
            if (is_short && !left_out[v]) {
                m.views[n++] = m.views[v];
            }
        }
        m.rig.left_out = is_short ? NULL : left_out;
        m.rig.n_views = is_short ? n : m.rig.n_views;
        ASSERT_STATUS(RIGCAL_OK, adjust(&fit[is_short]));
        memcpy(offsets[is_short], m.offsets, sizeof offsets[0]);
        ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_sigma(sigma[is_short], NULL, &m.rig, 1));
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_covariance(Sigma[is_short], &m.rig, 1, 2));
    }
    ASSERT_NEAR(1, D(sigma[0][1]) / D(sigma[1][1]), TOL(1e-6, 1e-3));
    ASSERT_NEAR(1, D(sigma[0][2]) / D(sigma[1][2]), TOL(1e-6, 1e-3));
    for (int k = 0; k < 36; k += 7) {
        ASSERT_NEAR(1, D(Sigma[0][k]) / D(Sigma[1][k]), TOL(1e-6, 1e-3));
    }
    ASSERT_NEAR(1, D(fit[0].sum) / D(fit[1].sum), TOL(1e-9, 1e-3));
    ASSERT_NEAR(fit[0].freedom, fit[1].freedom, 0);
    for (int c = 0; c < 3; c++) {
        ASSERT_NEAR(offsets[0][c], offsets[1][c], TOL(1e-9, 1e-4));
    }
}

/* Camera 0 sees three pictures by themselves, the others all. So their clocks tell the time
 * between them, and not that of camera 0. They are found all the same, and their poses. */
static void test_clocks_that_the_data_do_not_separate_stay_together(void)
{
    static uint8_t left_out[MOTION_VIEWS_MAX];
    rigcal_rig_fit fit;

    WANTS_MOTIONS();
    make(&SCENE, 98);
    for (int f = 0; f < 9; f++) { /* the first of each run is by itself */
        m.times[f] += f % 3 == 0 ? RC(-1) : 0;
    }
    for (size_t v = 0; v < m.rig.n_views; v++) {
        left_out[v] = m.views[v].camera == 0 && m.views[v].placement % 3 != 0;
    }
    m.rig.left_out = left_out;
    TEST_ASSERT_TRUE(adjust(&fit) >= 0);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CLOCK_FREE, m.states[1]);
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CLOCK_FREE, m.states[2]);
    ASSERT_NEAR(m.true_offsets[2] - m.true_offsets[1], D(m.offsets[2]) - D(m.offsets[1]),
                4e-3);
    TEST_ASSERT_TRUE(fabs(D(m.offsets[1])) < 0.05 && fabs(D(m.offsets[2])) < 0.05);
}

/* A search that ends although its last step promised much has not converged if a clock is
 * free. If it ends with another status, it keeps that status. */
static void test_a_search_that_promised_more_has_not_converged(void)
{
    WANTS_MOTIONS();
    for (int way = 0; way < 5; way++) {
        rigcal_rig_solver solver;
        rigcal_rig_fit fit;
        motion_scene scene = SCENE;

        scene.cameras = way == 4 ? 2 : 3; /* with two, one clock is free */
        make(&scene, 93);
        m.rig.clocks = &m.clocks;
        m.clocks.free_offsets = way > 0;
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_begin(&solver, &m.rig));
        while (rigcal_rig_step(&solver, 1) == RIGCAL_RUNNING) {
            if (way == 3 && solver.evals == 1) {
                solver.evals = 200; /* all evaluations are spent */
            }
            if (way != 1 && solver.search.status != RIGCAL_RUNNING) {
                solver.promised = RC(1e9);
            }
        }
        ASSERT_STATUS((way < 2) ? RIGCAL_OK : RIGCAL_BUDGET_SPENT,
                      rigcal_rig_result(&fit, NULL, &solver));
    }
}

/* Where the motion lags, a step may cost a hundredth of the variance of a pixel: clocks are
 * free, or known and not those of the placements. */
static void test_what_counts_as_rounding_is_more_where_the_motion_lags(void)
{
    WANTS_MOTIONS();
    for (int way = 0; way < 4; way++) {
        double largest = 0;
        rigcal_rig_solver solver;
        motion_scene scene = SCENE;

        scene.cameras = way == 3 ? 2 : 3; /* with two, one clock is free */
        make(&scene, 96);
        m.rig.clocks = &m.clocks;
        m.clocks.free_offsets = way == 0 || way == 3;
        for (int c = 0; c < 3 && way == 1; c++) {
            m.offsets[c] = RC(m.true_offsets[c]);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_begin(&solver, &m.rig));
        while (rigcal_rig_step(&solver, 1) == RIGCAL_RUNNING) {
            largest = fmax(largest, D(solver.sum));
        }
        const double lags = 0.01 * largest / (2.0 * scene.cameras * 9 * 20);

        if (way != 2) {
            ASSERT_NEAR(lags, solver.negligible, TOL(1e-9, 1e-4) * lags);
        } else {
            TEST_ASSERT_TRUE(D(solver.negligible) < TOL(1e-6, 0.1) * lags);
        }
    }
}

/* The variance of a pixel is known from the worst pass. If the last step promised to gain
 * more, some unknown may be off by a sigma. */
static void test_more_than_the_variance_of_a_pixel_is_much(void)
{
    WANTS_MOTIONS();
    for (int is_more = 0; is_more < 2; is_more++) {
        double largest = 0;
        rigcal_rig_solver solver;
        rigcal_rig_fit fit;

        make(&SCENE, 94);
        m.rig.clocks = &m.clocks;
        ASSERT_STATUS(RIGCAL_OK, rigcal_rig_begin(&solver, &m.rig));
        while (rigcal_rig_step(&solver, 1) == RIGCAL_RUNNING) {
            largest = fmax(largest, D(solver.sum));
            if (solver.search.status != RIGCAL_RUNNING) {
                const double variance = largest / (2.0 * 3 * 9 * 20);

                solver.promised = RC(is_more ? 1.05 * variance : 0.95 * variance);
            }
        }
        ASSERT_STATUS(is_more ? RIGCAL_BUDGET_SPENT : RIGCAL_OK,
                      rigcal_rig_result(&fit, NULL, &solver));
    }
}

static void test_the_defaults_are_those_of_the_header(void)
{
    rigcal_rig_clocks clocks;

    FILL(clocks);
    ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_defaults(&clocks));
    TEST_ASSERT_NOT_NULL(clocks.calls);
    TEST_ASSERT_EQUAL_INT32(4, clocks.neighbours);
    TEST_ASSERT_EQUAL_INT32(-1, clocks.memory.placement);
    TEST_ASSERT_NULL(clocks.times);
    TEST_ASSERT_NULL(clocks.view_times);
    TEST_ASSERT_NULL(clocks.instants);
    TEST_ASSERT_NULL(clocks.offsets);
    TEST_ASSERT_NULL(clocks.drifts);
    TEST_ASSERT_NULL(clocks.held);
    TEST_ASSERT_NULL(clocks.states);
    TEST_ASSERT_TRUE(clocks.free_offsets == 0 && clocks.free_drifts == 0);
    ASSERT_NEAR(0, clocks.frame, 0);
    ASSERT_NEAR(0, clocks.sigma_time, 0);
    ASSERT_STATUS(RIGCAL_ERR_NULL, rigcal_clocks_defaults(NULL));
}

static void test_what_is_handed_in_is_checked(void)
{
    rigcal_rig_solver solver;
    rigcal_rig_fit fit;

    WANTS_MOTIONS();
    make(&SCENE, 122);
    m.clocks.sigma_time = RC(-0.01);
    ASSERT_STATUS(RIGCAL_ERR_RANGE, adjust(&fit));
    ASSERT_STATUS(RIGCAL_ERR_RANGE, rigcal_rig_begin(&solver, &m.rig));
    ASSERT_STATUS(RIGCAL_ERR_STATE, rigcal_rig_step(&solver, 1));
    m.clocks.sigma_time = TEST_INF;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, adjust(&fit));
    m.clocks.sigma_time = RC(0.01);
    m.rig.view_poses = NULL; /* and sigma_px is not known */
    ASSERT_STATUS(RIGCAL_ERR_RANGE, adjust(&fit));
    m.clocks.sigma_time = 0;
    m.clocks.neighbours = 5;
    ASSERT_STATUS(RIGCAL_ERR_RANGE, adjust(&fit));
    m.clocks.neighbours = 4;
    m.offsets[1] = TEST_NAN;
    ASSERT_STATUS(RIGCAL_ERR_NOT_FINITE, adjust(&fit));
    m.offsets[1] = 0;
    m.clocks.free_drifts = 1;
    ASSERT_STATUS(RIGCAL_ERR_NULL, adjust(&fit));
    m.clocks.free_drifts = 0;
    m.clocks.frame = RC(-1);
    ASSERT_STATUS(RIGCAL_ERR_RANGE, adjust(&fit));
    m.clocks.frame = 0;
    m.clocks.calls = NULL;
    ASSERT_STATUS(RIGCAL_ERR_NULL, adjust(&fit));
    ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_defaults(&m.clocks));
    ASSERT_STATUS(RIGCAL_ERR_NULL, adjust(&fit));
}

/* The memory that the macro states is enough; less is refused. */
static void test_the_memory_is_as_the_manual_says(void)
{
    rigcal_rig_fit fit;
    const size_t enough = rigcal_rig_work(2, 3, 9) + rigcal_clocks_work(2, 3);

    WANTS_MOTIONS();
    make(&SCENE, 123);
    m.clocks.drifts = m.drifts;
    m.clocks.free_drifts = 1;
    for (size_t i = enough; i < MOTION_WORK; i++) {
        m.work[i] = RC(7.5);
    }
    m.rig.work_capacity = enough;
    ASSERT_STATUS(RIGCAL_OK, adjust(&fit));
    for (size_t i = enough; i < MOTION_WORK; i++) {
        ASSERT_NEAR(7.5, m.work[i], 0);
    }
    m.rig.work_capacity--;
    ASSERT_STATUS(RIGCAL_ERR_CAPACITY, adjust(&fit));
}

TEST_MAIN()
{
    RUN_TEST(test_clocks_that_are_known_and_right_change_no_bit);
    RUN_TEST(test_clocks_that_differ_are_found);
    RUN_TEST(test_clocks_that_drift_are_found);
    RUN_TEST(test_the_answer_is_the_dense_minimum);
    RUN_TEST(test_the_answer_with_drifts_is_the_dense_minimum);
    RUN_TEST(test_noise_of_stamps_is_a_free_time_of_each_view);
    RUN_TEST(test_stamps_with_noise_leave_the_noise_of_pixels);
    RUN_TEST(test_the_stamp_of_a_view_counts);
    RUN_TEST(test_clocks_of_a_target_that_stands_still_are_held);
    RUN_TEST(test_equal_pictures_have_no_motion);
    RUN_TEST(test_clocks_of_single_pictures_are_held);
    RUN_TEST(test_a_clock_that_is_known_is_held);
    RUN_TEST(test_each_clock_is_held_or_free);
    RUN_TEST(test_drifts_that_are_held_are_exact);
    RUN_TEST(test_the_clock_of_a_camera_without_views_is_left_alone);
    RUN_TEST(test_what_is_left_is_of_views_at_their_times);
    RUN_TEST(test_what_is_left_does_not_depend_on_the_frame);
    RUN_TEST(test_no_view_is_named_for_its_clock);
    RUN_TEST(test_a_claim_is_of_the_instant_of_the_placement);
    RUN_TEST(test_wrong_points_are_left_out_with_clocks_too);
    RUN_TEST(test_the_bits_are_those_of_any_budget);
    RUN_TEST(test_a_clock_is_free_where_the_target_moves_by_ten_sigma);
    RUN_TEST(test_a_camera_with_one_view_is_not_alone);
    RUN_TEST(test_one_camera_keeps_its_clock);
    RUN_TEST(test_the_drift_of_the_first_camera_is_found_too);
    RUN_TEST(test_the_unit_of_time_changes_no_bit);
    RUN_TEST(test_what_was_in_the_memory_does_not_matter);
    RUN_TEST(test_a_step_that_does_not_help_is_undone);
    RUN_TEST(test_the_instant_of_a_placement_is_the_mean_time_of_its_views);
    RUN_TEST(test_a_placement_without_neighbours_stays_at_its_stamp);
    RUN_TEST(test_a_placement_without_views_has_no_instant);
    RUN_TEST(test_a_placement_seen_once_has_the_time_of_that_view);
    RUN_TEST(test_without_the_noise_of_pixels_stamps_have_no_weight);
    RUN_TEST(test_the_weight_of_a_stamp_is_that_of_the_noises);
    RUN_TEST(test_views_that_are_left_out_leave_no_trace);
    RUN_TEST(test_clocks_that_the_data_do_not_separate_stay_together);
    RUN_TEST(test_a_search_that_promised_more_has_not_converged);
    RUN_TEST(test_what_counts_as_rounding_is_more_where_the_motion_lags);
    RUN_TEST(test_more_than_the_variance_of_a_pixel_is_much);
    RUN_TEST(test_the_defaults_are_those_of_the_header);
    RUN_TEST(test_what_is_handed_in_is_checked);
    RUN_TEST(test_the_memory_is_as_the_manual_says);
}
