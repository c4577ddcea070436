/* hostile: every public function against arguments that no sane caller passes.
 *
 * One line of FUNCTIONS describes a function: its arguments with a valid value of each,
 * what it then returns, and the statuses that its manual names. From that line alone the
 * test makes
 *
 *   NULL for each pointer         ERR_NULL; the usual answer where it may be
 *   NaN and infinities            ERR_NOT_FINITE, in each number in turn
 *   zero, denormal, tiny, huge,   a status the manual names and, where it says
 *   negated, one and all numbers  that the outputs are usable, finite outputs
 *   counts and options            the status named, outside their range
 *   numbers each kind of input    the status named, e.g. a focal length of 0
 *   cannot have
 *
 * and on every failure sees that the outputs still hold what they held. Buffers are
 * allocated to the byte, so that the address sanitizer sees a step beyond.
 *
 * A view and a rig are handed in by their parts, each of which is tried, and the struct
 * itself as one argument more, which may be NULL.
 *
 * A new function wants one CALL line and one line of FUNCTIONS; a test reads the public
 * headers and fails until it has them. */
#include <ctype.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rigcal_solvers.h"
#include "test_support.h"

/* ---- valid arguments ----------------------------------------------------- */

enum { N = 6, N_PAIRS = 15, N_CAMERAS = 3, N_PLACEMENTS = 2, N_VIEWS = 6 };
enum {
    RIG_WORK = RIGCAL_RIG_WORK(N_CAMERAS, N_CAMERAS, N_PLACEMENTS),
    CHOOSE_WORK = RIGCAL_CHOOSE_WORK(N_CAMERAS, N_PLACEMENTS, N_VIEWS),
    JUDGE_WORK = RIGCAL_JUDGE_WORK(N_CAMERAS, N_PLACEMENTS),
    MONITOR_SIZE = RIGCAL_MONITOR_SIZE(2, 1),
    CONSIDER_WORK = RIGCAL_CONSIDER_WORK(N_CAMERAS - 1, N_CAMERAS),
    CLOCKS_WORK = RIG_WORK + RIGCAL_CLOCKS_WORK(N_CAMERAS, N_CAMERAS),
    ESTIMATE_WORK = RIGCAL_ESTIMATE_WORK(N_CAMERAS - 1, N_CAMERAS),
    FAULTS_WORK = RIGCAL_FAULTS_WORK(N_CAMERAS - 1, N_CAMERAS),
    N_FAULTS = 2,
    TEXT_SIZE = 2000
};

/* The arguments of all calls, made once by build_valid. */
static struct {
    rigcal_real angles[3], vector[3], quaternion[4], other_rotation[9];
    rigcal_real rotation[9], matrix[9];
    rigcal_transform b_from_a, a_from_b;
    rigcal_camera camera, cameras[2];
    rigcal_real X[3], uv[2], xy[2], xy_right[2];
    rigcal_real ray_a[3], ray_b[3], line[3];
    rigcal_observation observations[N];
    rigcal_bearing bearings[N];
    rigcal_pair pairs[N_PAIRS];
    rigcal_transform cams_from_world[2], poses[N_CAMERAS];
    rigcal_real uv_views[4], uv_corners[8], weights[N_VIEWS];
    int32_t groups[N_CAMERAS];
    rigcal_transform placements[N_PLACEMENTS];
    rigcal_observation seen[N_VIEWS][N];
    rigcal_rig_view rig_views[N_VIEWS];
    rigcal_view_pose view_poses[N_VIEWS];
    rigcal_real rig_work[RIG_WORK];
    rigcal_rig_solver rig_begun, rig_done, join_begun;
    rigcal_link links[RIGCAL_LINKS(N_CAMERAS)];
    rigcal_choose_solver choose_begun, choose_done;
    uint8_t takes[N_VIEWS];
    rigcal_judgement judgement;
    rigcal_judge_solver judge_begun, judge_done;
    rigcal_cause_solver cause_begun, cause_done;
    rigcal_intrinsics_sigma deviations[N_CAMERAS];
    rigcal_consider_solver consider_begun, consider_done;
    rigcal_rig_clocks clocks;
    rigcal_transform clock_poses[N_CAMERAS], clock_placements[N_PLACEMENTS];
    rigcal_real times[N_PLACEMENTS], instants[N_PLACEMENTS];
    rigcal_real offsets[N_CAMERAS], clock_work[CLOCKS_WORK];
    int32_t clock_states[N_CAMERAS], clock_groups[N_CAMERAS];
    rigcal_intrinsics_change changes[N_CAMERAS]; /* none */
    rigcal_faults_solver faults_begun, faults_done;
    rigcal_faults told;
    rigcal_fault told_faults[N_FAULTS];
    rigcal_real told_clocks[2 * N_CAMERAS];
    char text[TEXT_SIZE];
    int32_t permutation[N];
    rigcal_rig rig;
    rigcal_rig_fit fit;
    rigcal_transform estimates[N_VIEWS];
    rigcal_real x0[3], simplex[12];
    rigcal_neldermead search, search_begun;
    rigcal_paper_options options;
    rigcal_paper_solver solver, solver_done;
    rigcal_real spreads[N];
    rigcal_pose_options warm, cold;
    rigcal_pose_solver pose_solver, pose_solver_done;
    uint8_t marks[N];
    rigcal_robust_options robust;
    rigcal_robust_solver robust_solver, robust_solver_done;
    rigcal_mounted_camera mounted[2];
    uint8_t saved[RIGCAL_STORE_SIZE(2)], saved_rig[RIGCAL_STORE_RIG_SIZE(2, 1)];
    int32_t kept_group[2];
    uint8_t kept_held[2];
    rigcal_real kept_Sigma[RIGCAL_CALIBRATED_SIZE(1)], kept_numbers[4];
    rigcal_sighting sightings[2];
    rigcal_point_gain gains[2];
    rigcal_measured_point measured, other;
    rigcal_point_solver point_begun, point_done;
    rigcal_real pair_Sigma[36], pair_numbers[5], uv_b[2], uv_candidates[4], uv_three[6];
    rigcal_band band;
    rigcal_ray ray, rays[2];
    rigcal_spans_solver spans_begun, spans_done;
    size_t abc[3];
    rigcal_calibrated_rig three; /* a calibrated rig of three cameras */
    rigcal_transfer transfer;
    rigcal_real monitor[MONITOR_SIZE], alarmed[MONITOR_SIZE];
    rigcal_monitor_options watching;
} ok;

static const size_t SIZE_0 = 0, SIZE_1 = 1, SIZE_2 = 2, SIZE_3 = 3, SIZE_4 = 4, SIZE_6 = 6,
                    SIZE_8 = 8, SIZE_15 = 15, SIZE_SAVED = RIGCAL_STORE_SIZE(2),
                    SIZE_12 = 12, SIZE_WORK = RIG_WORK, SIZE_CHOOSE = CHOOSE_WORK,
                    SIZE_TO_JUDGE = JUDGE_WORK, SIZE_CONSIDER = CONSIDER_WORK,
                    SIZE_CLOCKS = CLOCKS_WORK, SIZE_ESTIMATE = ESTIMATE_WORK,
                    SIZE_FAULTS = FAULTS_WORK, SIZE_TEXT = TEXT_SIZE,

                    SIZE_KEPT = RIGCAL_CALIBRATED_SIZE(1), SIZE_MONITOR = MONITOR_SIZE,
                    SIZE_TAKEN = RIGCAL_CALIBRATED_SIZE(2),
                    SIZE_SAVED_RIG = RIGCAL_STORE_RIG_SIZE(2, 1),
                    SIZE_POINT = RIGCAL_POINT_WORK(2);
static const size_t SIZE_SPANS = 4000;
static const uint32_t UINT_7 = 7;
static const int32_t INT_0 = 0, INT_1 = 1, INT_2 = 2, INT_3 = 3, INT_8 = 8, INT_480 = 480,
                     INT_640 = 640, INT_1000 = 1000;
static const rigcal_real REAL_TOL = RC(1e-6), REAL_COST = RC(2.5), REAL_BASELINE = RC(0.3),
                         REAL_SIGMA = RC(0.5), REAL_NEAR = RC(2), REAL_FAR = RC(9),
                         REAL_PARALLAX = RC(0.01);

static rigcal_real bowl(void *context, const rigcal_real x[])
{
    (void)context;
    return (x[0] - 1) * (x[0] - 1) + 2 * x[1] * x[1] + (x[2] + 2) * (x[2] + 2);
}

/* The pixel of a world point in a camera, in double. */
static void pixel_of(rigcal_real uv[2], const rigcal_camera *camera, const double R[9],
                     const double t[3], const double X[3])
{
    double X_c[3], exact[2];

    test_apply(X_c, R, X, t);
    test_project_px(exact, camera, X_c);
    test_to_real(uv, exact, 2);
}

static void build_geometry(void)
{
    static const double t[3] = {-0.3, 0.05, 0.02}, a[3] = {0.1, -0.05, 1};
    double R[9], Rt[9], m[3], normal[3], line[3], length;

    test_rotation(R, 0.05, -0.1, 0.07);
    test_to_real(ok.rotation, R, 9);
    ok.b_from_a = test_transform(R, t);
    test_rotation(Rt, 0.4, 0.3, -0.2);
    test_to_real(ok.other_rotation, Rt, 9);
    ok.a_from_b = test_transform(Rt, a);
    for (int i = 0; i < 9; i++) {
        ok.matrix[i] = RC(1.1 * R[i] + 0.01 * (i % 4));
    }
    for (int i = 0; i < 3; i++) {
        ok.angles[i] = RC(0.2 * (i + 1));
        ok.vector[i] = RC(0.3 - 0.4 * i);
        ok.X[i] = RC(i == 2 ? 4 : 0.3 * i - 0.1);
        ok.ray_a[i] = RC(a[i]);
        ok.x0[i] = RC(i == 1 ? 0 : 1.5 * i - 0.7);
    }
    for (int i = 0; i < 4; i++) {
        ok.quaternion[i] = RC(0.9 - 0.3 * i);
        for (int j = 0; j < 3; j++) {
            ok.simplex[3 * i + j] = RC(0.2 * (j + 1) + (i == j ? 0.5 : 0));
        }
    }
    /* Camera b sees the point at depth five along ray_a, and the line by (25), (26). */
    test_apply(m, R, a, NULL);
    for (int i = 0; i < 3; i++) {
        ok.ray_b[i] = RC(5 * m[i] + t[i]);
    }
    test_cross(normal, t, m);
    line[0] = normal[0] / D(ok.camera.fx);
    line[1] = normal[1] / D(ok.camera.fy);
    line[2] = normal[2] - line[0] * D(ok.camera.cx) - line[1] * D(ok.camera.cy);
    length = hypot(line[0], line[1]);
    for (int i = 0; i < 3; i++) {
        ok.line[i] = RC(line[i] / length);
    }
    ok.uv[0] = RC(301.25);
    ok.uv[1] = RC(277.5);
    ok.xy[0] = RC(0.11);
    ok.xy[1] = RC(-0.04);
    ok.xy_right[0] = RC(0.04);
    ok.xy_right[1] = RC(-0.04);
}

static void build_target(void)
{
    test_rng rng = test_seed(20);
    test_scene scene;
    size_t p = 0;

    test_scene_random(&scene, &rng, N, TEST_GENERAL);
    test_observations(ok.observations, &scene, &ok.camera);
    test_bearings(ok.bearings, &scene);
    for (int i = 0; i < N; i++) {
        for (int j = i + 1; j < N; j++, p++) {
            const double mi[3] = {scene.xy[i][0], scene.xy[i][1], 1};
            const double mj[3] = {scene.xy[j][0], scene.xy[j][1], 1};
            double n[3], d[3];

            test_cross(n, mi, mj);
            for (int k = 0; k < 3; k++) {
                d[k] = scene.X[i][k] - scene.X[j][k];
            }
            for (int k = 0; k < 3; k++) {
                ok.pairs[p].normal[k] = RC(n[k] / test_norm(n));
                ok.pairs[p].offset[k] = RC(d[k] / test_norm(d));
            }
            ok.pairs[p].i = i;
            ok.pairs[p].j = j;
        }
    }
    ok.cams_from_world[0] = test_transform(scene.R, scene.t);
    pixel_of(ok.uv_views, &ok.camera, scene.R, scene.t, scene.X[0]);
    {
        static const double up[3] = {0, 1, 0};
        double turn[9], R[9], t[3], aim[3];

        /* The second camera is the first, turned about the target's first point. */
        test_rotation_about(turn, up, 0.3);
        test_product(R, turn, scene.R);
        test_apply(aim, scene.R, scene.X[0], scene.t);
        test_apply(t, R, scene.X[0], NULL);
        for (int k = 0; k < 3; k++) {
            t[k] = aim[k] - t[k];
        }
        ok.cams_from_world[1] = test_transform(R, t);
        pixel_of(ok.uv_views + 2, &ok.camera, R, t, scene.X[0]);
    }
    for (int k = 0; k < 3; k++) {
        ok.options.guess_ypr[k] = RC(scene.ypr[k] + 0.05);
    }
}

/* Makes view v of camera c and placement f, with R and t. */
static void see(int v, int c, int f, const double R[9], const double t[3])
{
    const rigcal_transform T = test_transform(R, t);

    for (int i = 0; i < N; i++) {
        const double X[3] = {0.4 * (i & 1) - 0.2, 0.2 * (i >> 1) - 0.2, 0.1 * (i % 3)};

        test_to_real(ok.seen[v][i].X_w, X, 3);
        pixel_of(ok.seen[v][i].uv, &ok.camera, R, t, X);
        ok.seen[v][i].uv[0] += RC(0.1 * ((i + v) % 3));
    }
    ok.rig_views[v].view = VIEW(&ok.camera, ok.seen[v], NULL, N);
    ok.rig_views[v].camera = c;
    ok.rig_views[v].placement = f;
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_view_pose_make(&ok.view_poses[v], &ok.rig_views[v], &T));
}

static void build_rig(void)
{
    double R[N_CAMERAS][9], t[N_CAMERAS][3];
    double Q[N_PLACEMENTS][9], s[N_PLACEMENTS][3];

    for (int c = 0; c < N_CAMERAS; c++) {
        test_rotation(R[c], 0.1 * c, -0.2 * c, 0.05 * c);
        t[c][0] = -0.4 * c;
        t[c][1] = 0.1 * c;
        t[c][2] = 0.03 * c;
        ok.poses[c] = test_transform(R[c], t[c]);
    }
    for (int f = 0; f < N_PLACEMENTS; f++) {
        test_rotation(Q[f], 0.5 * f, 0.3, -0.4 * f);
        s[f][0] = 0.2 * f;
        s[f][1] = -0.1;
        s[f][2] = 4 + f;
        ok.placements[f] = test_transform(Q[f], s[f]);
    }
    for (int v = 0; v < N_VIEWS; v++) {
        const int c = v % N_CAMERAS, f = v / N_CAMERAS;
        double A[9], b[3];

        test_product(A, R[c], Q[f]);
        test_apply(b, R[c], s[f], t[c]);
        see(v, c, f, A, b);
        test_rotation(A, 0.3 + 0.01 * v, -0.2, 0.1 - 0.02 * v);
        ok.estimates[v] = test_transform(A, b);
        ok.weights[v] = RC(1 + v);
    }
}

static void build_adjusted(void)
{
    static rigcal_transform cams[N_CAMERAS], placements[N_PLACEMENTS];
    static rigcal_real work[RIG_WORK], join_work[RIG_WORK];
    static rigcal_rig joined;
    static int32_t groups[N_CAMERAS];
    rigcal_rig_solver solver;
    rigcal_rig_fit fit;

    ok.rig.cams_from_rig = ok.poses;
    ok.rig.n_cameras = N_CAMERAS;
    ok.rig.rig_from_placements = ok.placements;
    ok.rig.n_placements = N_PLACEMENTS;
    ok.rig.group = ok.groups;
    ok.rig.n_views = N_VIEWS;
    ok.rig.views = ok.rig_views;
    ok.rig.work = ok.rig_work;
    ok.rig.work_capacity = RIG_WORK;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &ok.rig));
    ok.fit = fit;
    /* Searches that are under way have a rig of their own. */
    memcpy(cams, ok.poses, sizeof cams);
    memcpy(placements, ok.placements, sizeof placements);
    ok.rig.cams_from_rig = cams;
    ok.rig.rig_from_placements = placements;
    ok.rig.work = work;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_begin(&solver, &ok.rig));
    ok.rig_begun = solver;
    while (rigcal_rig_step(&solver, 1000) == RIGCAL_RUNNING) {
    }
    ok.rig_done = solver;
    joined = ok.rig;
    joined.view_poses = ok.view_poses;
    joined.work = join_work;
    joined.group = groups;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_join_begin(&ok.join_begun, &joined));
}

/* The links of the cameras; a choice under way, and one that has ended. */
static void build_choice(void)
{
    static rigcal_transform cams[N_CAMERAS], placements[N_PLACEMENTS];
    static rigcal_real work[CHOOSE_WORK];
    static int32_t group[N_CAMERAS];
    static uint8_t takes[N_VIEWS];
    static rigcal_choice choice;
    static rigcal_rig rig;
    rigcal_choose_solver solver;
    int32_t n_groups;

    rig = ok.rig;
    rig.cams_from_rig = cams;
    rig.rig_from_placements = placements;
    rig.group = group;
    rig.view_poses = ok.view_poses;
    rig.work = work;
    rig.work_capacity = CHOOSE_WORK;
    choice.takes = takes;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_links(ok.links, RIGCAL_LINKS(N_CAMERAS), &n_groups,
                                              NULL, &rig));
    ASSERT_STATUS(RIGCAL_OK, rigcal_choose_begin(&solver, &choice, &rig));
    ok.choose_begun = solver;
    while (rigcal_choose_step(&solver, 1000) == RIGCAL_RUNNING) {
    }
    ok.choose_done = solver;
    ASSERT_STATUS(RIGCAL_OK, rigcal_choose_begin(&ok.choose_begun, &choice, &rig));
}

/* A judgement under way, and one that has ended; a search for a cause under way, and one
 * that has ended. */
static void build_judgement(void)
{
    static rigcal_transform cams[N_CAMERAS], placements[N_PLACEMENTS];
    static rigcal_real work[JUDGE_WORK];
    static int32_t group[N_CAMERAS];
    static uint8_t takes[N_VIEWS], left_out[N_VIEWS];
    static rigcal_judged_view judged[N_VIEWS];
    static rigcal_choice choice;
    static rigcal_rig rig;
    rigcal_judge_solver solver;

    rig = ok.rig;
    memcpy(cams, ok.poses, sizeof cams);
    memcpy(placements, ok.placements, sizeof placements);
    rig.cams_from_rig = cams;
    rig.rig_from_placements = placements;
    rig.group = group;
    rig.view_poses = ok.view_poses;
    rig.work = work;
    rig.work_capacity = JUDGE_WORK;
    choice.takes = takes;
    choice.sigma_px = REAL_SIGMA;
    ASSERT_STATUS(RIGCAL_OK, rigcal_judge_begin(&solver, judged, left_out, &choice, &rig));
    while (rigcal_judge_step(&solver, 1000) == RIGCAL_RUNNING) {
    }
    ok.judge_done = solver;
    ASSERT_STATUS(RIGCAL_OK, rigcal_judge_result(&ok.judgement, NULL, &solver));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_judge_begin(&ok.judge_begun, judged, left_out, &choice, &rig));
    for (int32_t i = 0; i < N; i++) {
        ok.permutation[i] = N - 1 - i;
    }
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_camera_cause_begin(&ok.cause_begun, &rig, &ok.judgement, NULL, 1));
    ok.cause_done = ok.cause_begun;
    while (rigcal_cause_step(&ok.cause_done, 1000) == RIGCAL_RUNNING) {
    }
}

/* A rig whose intrinsics are being considered, and one for which this has ended. */
static void build_considered(void)
{
    static rigcal_real work[RIG_WORK], effects[CONSIDER_WORK];
    static rigcal_considered considered;
    static rigcal_rig rig;

    for (int c = 0; c < N_CAMERAS; c++) {
        ok.deviations[c] =
            (rigcal_intrinsics_sigma){RC(0.003), RC(0.001), RC(3), RC(0.01), RC(0.03)};
    }
    rig = ok.rig;
    memcpy(work, ok.rig_work, sizeof work);
    rig.work = work;
    rig.views = ok.rig_views;
    rig.intrinsics_sigmas = ok.deviations;
    considered.effects = effects;
    considered.capacity = CONSIDER_WORK;
    ASSERT_STATUS(RIGCAL_OK, rigcal_consider_begin(&ok.consider_begun, &considered, &rig));
    ok.consider_done = ok.consider_begun;
    while (rigcal_consider_step(&ok.consider_done, 1000) == RIGCAL_RUNNING) {
    }
}

/* A rig that was adjusted with clocks, of two frames that follow each other. */
static void build_clocks(void)
{
    rigcal_rig rig;
    rigcal_rig_fit fit;

    rig = ok.rig;
    memcpy(ok.clock_poses, ok.poses, sizeof ok.poses);
    memcpy(ok.clock_placements, ok.placements, sizeof ok.placements);
    ok.times[1] = RC(0.1);
    ASSERT_STATUS(RIGCAL_OK, rigcal_clocks_defaults(&ok.clocks));
    ok.clocks.times = ok.times;
    ok.clocks.instants = ok.instants;
    ok.clocks.offsets = ok.offsets;
    ok.clocks.states = ok.clock_states;
    ok.clocks.free_offsets = 1;
    rig.cams_from_rig = ok.clock_poses;
    rig.rig_from_placements = ok.clock_placements;
    rig.group = ok.clock_groups;
    rig.views = ok.rig_views;
    rig.work = ok.clock_work;
    rig.work_capacity = CLOCKS_WORK;
    rig.clocks = &ok.clocks;
    ASSERT_STATUS(RIGCAL_OK, rigcal_rig_adjust(&fit, NULL, &rig));
    TEST_ASSERT_EQUAL_INT32(RIGCAL_CLOCK_FREE, ok.clock_states[1]);
}

/* A test for faults under way, and one that has ended; and what may be found for a rig with
 * free clocks, or with a camera that moved. */
static void build_faults(void)
{
    static rigcal_real work[RIG_WORK], room[FAULTS_WORK];
    static rigcal_fault faults[N_FAULTS];
    static rigcal_faults_options options;
    static rigcal_rig rig;

    rig = ok.rig;
    memcpy(work, ok.rig_work, sizeof work);
    rig.work = work;
    rig.views = ok.rig_views;
    options.work = room;
    options.work_capacity = FAULTS_WORK;
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_faults_begin(&ok.faults_begun, faults, N_FAULTS, &options, &rig));
    ok.faults_done = ok.faults_begun;
    while (rigcal_faults_step(&ok.faults_done, 1000) == RIGCAL_RUNNING) {
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_faults_result(&ok.told, NULL, &ok.faults_done));
    ok.told.verdict = RIGCAL_RIG_EXPLAINED;
    ok.told.bits = RIGCAL_FAULTS_NAMED | RIGCAL_FAULTS_ALIKE | RIGCAL_FAULTS_NO_MOTION;
    ok.told.n = N_FAULTS;
    ok.told.n_alike = 1;
    ok.told.n_cameras = N_CAMERAS;
    memset(ok.told_faults, 0, sizeof ok.told_faults);
    for (int32_t i = 0; i < N_FAULTS; i++) {
        rigcal_fault *const fault = &ok.told_faults[i];

        fault->kind = (i == 0) ? RIGCAL_FAULT_CLOCKS : RIGCAL_FAULT_MOVED;
        fault->camera = i - 1;
        fault->placement = 1;
        fault->n = (i == 0) ? 2 : 6;
        fault->is_seen = fault->explains = 1;
        fault->value[0] = RC(0.02);
        fault->sigma[0] = RC(0.001);
    }
    for (int c = 0; c < 2 * N_CAMERAS; c++) {
        ok.told_clocks[c] = RC(0.01);
    }
}

/* Only the library can make the states of searches. */
static void build_searches(void)
{
    rigcal_real x[3];
    rigcal_status status;

    ok.options.angles = 2;
    ok.options.eliminated = RIGCAL_BEST_CONDITIONED;
    ok.options.use_guess = 1;
    ok.options.xtol = RC(TOL(1e-9, 1e-4));
    ok.options.ftol = RC(TOL(1e-9, 1e-4));
    ASSERT_STATUS(RIGCAL_OK, rigcal_neldermead_begin(&ok.search_begun, ok.x0, 3, REAL_TOL,
                                                     REAL_TOL, 1000));
    ok.search = ok.search_begun;
    for (int i = 0; i < 10; i++) {
        ASSERT_STATUS(RIGCAL_RUNNING, rigcal_neldermead_ask(x, &ok.search));
        ASSERT_STATUS(RIGCAL_RUNNING, rigcal_neldermead_tell(&ok.search, bowl(NULL, x)));
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_paper_begin(&ok.solver, ok.bearings, N, ok.pairs,
                                                N_PAIRS, &ok.options));
    ok.solver_done = ok.solver;
    do {
        status = rigcal_paper_step(&ok.solver_done, 1000);
    } while (status == RIGCAL_RUNNING);
    ASSERT_STATUS(RIGCAL_OK, status);
}

static void build_pose_searches(void)
{
    int32_t at_fault;
    rigcal_status status;

    for (int i = 0; i < N; i++) {
        ok.spreads[i] = RC(0.5 + 0.25 * i);
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_pose_defaults(&ok.cold));
    ok.warm = ok.cold;
    ok.cold.sigma_px = REAL_SIGMA;
    for (int i = 0; i < 4; i++) { /* corners of a tag nearby, its top leaning back */
        const rigcal_real x = RC(i == 1 || i == 2 ? 0.15 : -0.15);
        const rigcal_real y = RC(i < 2 ? 0.15 : -0.15);
        const rigcal_real X_c[3] = {x, RC(-0.8) * y, RC(0.7) + RC(0.6) * y};

        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_camera_project(ok.uv_corners + 2 * i, &ok.camera, X_c));
    }
    ok.warm.use_start = 1;
    ok.warm.start = ok.cams_from_world[0];
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_pose_begin(&ok.pose_solver, &at_fault,
                                    &VIEW(&ok.camera, ok.observations, ok.spreads, N),
                                    &ok.cold));
    ok.pose_solver_done = ok.pose_solver;
    do {
        status = rigcal_pose_step(&ok.pose_solver_done, 1000);
    } while (status == RIGCAL_RUNNING);
    ASSERT_STATUS(RIGCAL_OK, status);
}

static void build_robust(void)
{
    rigcal_status status;

    ASSERT_STATUS(RIGCAL_OK, rigcal_robust_defaults(&ok.robust));
    ok.robust.sigma_px = REAL_SIGMA;
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_robust_begin(&ok.robust_solver, ok.marks, NULL,
                                      &VIEW(&ok.camera, ok.observations, ok.spreads, N),
                                      &ok.robust));
    ok.robust_solver_done = ok.robust_solver;
    do {
        status = rigcal_robust_step(&ok.robust_solver_done, 1000);
    } while (status == RIGCAL_RUNNING);
    ASSERT_STATUS(RIGCAL_OK, status);
}

static void build_store(void)
{
    size_t n;

    for (int c = 0; c < 2; c++) {
        ok.mounted[c].camera = ok.camera;
        ok.mounted[c].cam_from_rig = ok.poses[c];
        ok.mounted[c].has_Sigma = 1;
        for (int i = 0; i < 6; i++) {
            ok.mounted[c].Sigma[7 * i] = RC(1e-6 * (i + 1));
        }
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_save(ok.saved, sizeof ok.saved, &n, ok.mounted, 2,
                                               UINT_7, UINT_7));
}

/* Gives matches that never fit. */
static void raise_alarm(void)
{
    rigcal_monitor_report report = {0};

    for (int f = 0; f < 200 && !report.alarm; f++) {
        for (int k = 0; k < 10; k++) {
            const rigcal_real a[3] = {RC(0.1 * (k % 3) - 0.1), RC(0.05 * k - 0.2), 1};
            const rigcal_real b[3] = {RC(0.1 * (k % 4) - 0.1), RC(0.05 * k - 0.2 + 0.01),
                                      1};

            (void)rigcal_monitor_match_rays(ok.alarmed, 0, a, 1, b, 1);
        }
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_frame(&report, ok.alarmed, 0));
    }
    TEST_ASSERT_EQUAL_INT32(1, report.alarm);
}

/* The second camera is free. */
static void build_calibrated(void)
{
    rigcal_calibrated_rig rig = {.cameras = ok.mounted,
                                 .group = ok.kept_group,
                                 .held = ok.kept_held,
                                 .capacity = 2,
                                 .Sigma = ok.kept_Sigma,
                                 .Sigma_capacity = RIGCAL_CALIBRATED_SIZE(1),
                                 .n_cameras = 2,
                                 .sigma_px = RC(0.5),
                                 .F = RC(1.25),
                                 .freedom_between = 12,
                                 .freedom_within = 34};
    size_t n;

    ok.kept_held[0] = 1;
    for (size_t i = 0, k = 0; i < 6; i++) {
        for (size_t j = 0; j <= i; j++, k++) {
            ok.kept_Sigma[k] = RC(i == j ? 1e-6 * (double)(i + 1) : 1e-8);
        }
    }
    memcpy(ok.kept_numbers, &rig.sigma_px, sizeof ok.kept_numbers);
    ASSERT_STATUS(RIGCAL_OK, rigcal_store_save_rig(ok.saved_rig, sizeof ok.saved_rig, &n,
                                                   &rig, UINT_7, UINT_7));
    ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_defaults(&ok.watching));
    ok.watching.arl0_frames = 100;
    ok.watching.move_t = RC(0.01);
    ok.watching.common = 0;
    for (int k = 0; k < 2; k++) {
        ASSERT_STATUS(RIGCAL_OK, rigcal_monitor_begin(k ? ok.alarmed : ok.monitor,
                                                      MONITOR_SIZE, &rig, 1, &ok.watching));
    }
    raise_alarm();
}

/* Two cameras, and their pixels of the first placement's origin; a measurement of a point
 * under way, and one that has ended. */
static void build_point(void)
{
    static rigcal_real work[2][RIGCAL_POINT_WORK(2)];
    static rigcal_calibrated_rig rig;
    static rigcal_sightings s[2];

    rig = (rigcal_calibrated_rig){.cameras = ok.mounted,
                                  .group = ok.kept_group,
                                  .held = ok.kept_held,
                                  .capacity = 2,
                                  .Sigma = ok.kept_Sigma,
                                  .Sigma_capacity = RIGCAL_CALIBRATED_SIZE(1),
                                  .n_cameras = 2};
    memcpy(&rig.sigma_px, ok.kept_numbers, sizeof ok.kept_numbers);
    for (int i = 0; i < 2; i++) {
        rigcal_real X_c[3];

        ok.sightings[i].camera = i;
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_transform_point(X_c, &ok.poses[i], ok.placements[0].t));
        ASSERT_STATUS(RIGCAL_OK,
                      rigcal_camera_project(ok.sightings[i].uv, &ok.camera, X_c));
        s[i] = (rigcal_sightings){.rig = &rig,
                                  .seen = ok.sightings,
                                  .n = 2,
                                  .work = work[i],
                                  .work_capacity = RIGCAL_POINT_WORK(2)};
    }
    ok.measured.gains = ok.gains;
    ok.measured.gains_capacity = 2;
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_begin(&ok.point_begun, &s[0]));
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_begin(&ok.point_done, &s[1]));
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_step(&ok.point_done, 1000));
    ASSERT_STATUS(RIGCAL_OK, rigcal_point_result(&ok.measured, NULL, &ok.point_done));
    ok.other = ok.measured;
    ok.other.X[0] += 1;
}

/* A band and what is made from it; three cameras, and their pixels of one point. */
static void build_match(void)
{
    static const double X_a[3] = {0.2, -0.1, 4};
    static rigcal_mounted_camera cameras[N_CAMERAS];
    static int32_t group[N_CAMERAS];
    static uint8_t held[N_CAMERAS] = {1, 0, 0};
    static rigcal_real Sigma[RIGCAL_CALIBRATED_SIZE(2)];
    static const rigcal_real noise[2] = {RC(0.5), RC(0.5)};
    rigcal_match_pair pair;
    double R[9], t[3];

    memset(&pair, 0, sizeof pair);
    for (int i = 0; i < 6; i++) {
        ok.pair_Sigma[7 * i] = RC(1e-6 * (i + 1));
    }
    ok.pair_numbers[0] = ok.pair_numbers[1] = REAL_SIGMA;
    ok.pair_numbers[2] = RC(2.5);
    ok.pair_numbers[3] = REAL_NEAR;
    ok.pair_numbers[4] = REAL_FAR;
    pair.camera_a = pair.camera_b = &ok.camera;
    pair.b_from_a = ok.b_from_a;
    memcpy(pair.Sigma, ok.pair_Sigma, sizeof pair.Sigma);
    memcpy(&pair.sigma_a, ok.pair_numbers, sizeof ok.pair_numbers);
    ASSERT_STATUS(RIGCAL_OK, rigcal_band_make(&ok.band, &pair, ok.uv));
    ASSERT_STATUS(RIGCAL_OK, rigcal_ray_make(&ok.ray, &ok.camera, ok.uv));
    {
        rigcal_band_point points[3];
        size_t n;

        ASSERT_STATUS(RIGCAL_OK, rigcal_band_curve(points, 3, &n, &ok.band));
        memcpy(ok.uv_b, points[1].uv, sizeof ok.uv_b);
        memcpy(ok.uv_candidates, points[1].uv, sizeof ok.uv_b);
        memcpy(ok.uv_candidates + 2, ok.uv, sizeof ok.uv);
        for (int i = 0; i < 2; i++) {
            ASSERT_STATUS(RIGCAL_OK, rigcal_ray_make(&ok.rays[i], &ok.camera,
                                                     &ok.uv_candidates[2 * i]));
        }
    }
    ASSERT_STATUS(RIGCAL_OK, rigcal_spans_begin(&ok.spans_begun, &ok.band));
    ok.spans_done = ok.spans_begun;
    ASSERT_STATUS(RIGCAL_OK, rigcal_spans_step(&ok.spans_done, RIGCAL_SPANS_UNITS));

    for (size_t c = 0; c < N_CAMERAS; c++) {
        cameras[c].camera = ok.camera;
        cameras[c].cam_from_rig = ok.poses[c];
        ok.abc[c] = (c + 1) % N_CAMERAS;
        test_transform_parts(R, t, &ok.poses[ok.abc[c]]);
        pixel_of(&ok.uv_three[2 * c], &ok.camera, R, t, X_a);
    }
    for (size_t i = 0; i < 12; i++) {
        Sigma[i * (i + 1) / 2 + i] = RC(1e-6 * (double)(i + 1));
    }
    ok.three = (rigcal_calibrated_rig){
        cameras,   group,   held, N_CAMERAS, Sigma, RIGCAL_CALIBRATED_SIZE(2),
        N_CAMERAS, RC(0.5), 1,    1,         1};
    ASSERT_STATUS(RIGCAL_OK, rigcal_transfer_make(&ok.transfer, &ok.three, ok.abc,
                                                  ok.uv_three, ok.uv_three + 2, noise));
}

static void build_valid(void)
{
    static const rigcal_camera camera = {RIGCAL_LENS_BROWN, 640,       480,       RC(532.5),
                                         RC(533.5),         RC(320),   RC(240),   RC(-0.28),
                                         RC(0.07),          RC(0.001), RC(-5e-4), RC(-0.01),
                                         RC(0.01),          RC(0.002), RC(0.001)};

    ok.camera = camera;
    ok.cameras[0] = camera;
    ok.cameras[1] = camera;
    build_geometry();
    build_target();
    build_rig();
    build_adjusted();
    build_choice();
    build_judgement();
    build_considered();
    build_clocks();
    build_faults();
    build_searches();
    build_pose_searches();
    build_robust();
    build_store();
    build_calibrated();
    build_point();
    build_match();
}

/* ---- kinds of argument --------------------------------------------------- */

/* A number that an input of this kind cannot have: `value` at `offset`, as a rigcal_real or
 * an int32_t. */
typedef struct {
    rigcal_status status;
    size_t offset;
    int is_real;
    double value;
} impossible;

#define BAD_INT(type, field, value, status) \
    { \
        status, offsetof(type, field), 0, value \
    }
#define BAD_REAL(type, field, value, status) \
    { \
        status, offsetof(type, field), 1, value \
    }
#define BAD_NUMBER(value, status) \
    { \
        status, 0, 1, value \
    }
#define BAD_END \
    { \
        RIGCAL_OK, 0, 0, 0 \
    }

static const impossible BAD_ROTATION[] = {
    BAD_NUMBER(2, RIGCAL_ERR_ROTATION), BAD_NUMBER(-5, RIGCAL_ERR_ROTATION),
    BAD_NUMBER(0, RIGCAL_ERR_ROTATION), BAD_NUMBER(1e9, RIGCAL_ERR_ROTATION), BAD_END};
static const impossible BAD_CAMERA[] = {
    BAD_INT(rigcal_camera, lens, -1, RIGCAL_ERR_CAMERA),
    BAD_INT(rigcal_camera, lens, 2, RIGCAL_ERR_CAMERA),
    BAD_INT(rigcal_camera, lens, INT32_MAX, RIGCAL_ERR_CAMERA),
    BAD_INT(rigcal_camera, width, 0, RIGCAL_ERR_CAMERA),
    BAD_INT(rigcal_camera, width, -1, RIGCAL_ERR_CAMERA),
    BAD_INT(rigcal_camera, width, 1000001, RIGCAL_ERR_CAMERA),
    BAD_INT(rigcal_camera, width, INT32_MIN, RIGCAL_ERR_CAMERA),
    BAD_INT(rigcal_camera, height, 0, RIGCAL_ERR_CAMERA),
    BAD_INT(rigcal_camera, height, -1, RIGCAL_ERR_CAMERA),
    BAD_INT(rigcal_camera, height, 1000001, RIGCAL_ERR_CAMERA),
    BAD_REAL(rigcal_camera, fx, 0, RIGCAL_ERR_CAMERA),
    BAD_REAL(rigcal_camera, fx, -500, RIGCAL_ERR_CAMERA),
    BAD_REAL(rigcal_camera, fy, 0, RIGCAL_ERR_CAMERA),
    BAD_REAL(rigcal_camera, fy, -500, RIGCAL_ERR_CAMERA),
    BAD_END};
static const impossible BAD_OPTIONS[] = {
    BAD_INT(rigcal_paper_options, angles, -2, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_paper_options, angles, 1, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_paper_options, angles, 4, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_paper_options, eliminated, -1, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_paper_options, eliminated, 4, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_paper_options, pairs_used, -1, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_paper_options, pairs_used, 1, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_paper_options, pairs_used, 3, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_paper_options, use_guess, -1, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_paper_options, use_guess, 2, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_paper_options, max_evals, -1, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_paper_options, max_evals, INT32_MIN, RIGCAL_ERR_RANGE),
    BAD_REAL(rigcal_paper_options, xtol, -1e-6, RIGCAL_ERR_RANGE),
    BAD_REAL(rigcal_paper_options, ftol, -1e-6, RIGCAL_ERR_RANGE),
    BAD_END};
static const impossible BAD_COLD[] = {
    BAD_INT(rigcal_pose_options, use_start, -1, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_pose_options, use_start, INT32_MAX, RIGCAL_ERR_RANGE),
    BAD_REAL(rigcal_pose_options, sigma_px, -1, RIGCAL_ERR_RANGE), BAD_END};
static const impossible BAD_WARM[] = {
    BAD_INT(rigcal_pose_options, use_start, 2, RIGCAL_ERR_RANGE),
    BAD_REAL(rigcal_pose_options, sigma_px, -1e-9, RIGCAL_ERR_RANGE),
    BAD_REAL(rigcal_pose_options, start.R[0], 2, RIGCAL_ERR_ROTATION),
    BAD_REAL(rigcal_pose_options, start.R[8], -5, RIGCAL_ERR_ROTATION), BAD_END};
static const impossible BAD_ROBUST[] = {
    BAD_REAL(rigcal_robust_options, threshold_px, -1, RIGCAL_ERR_RANGE),
    BAD_REAL(rigcal_robust_options, threshold_px, 1e-7, RIGCAL_ERR_RANGE),
    BAD_REAL(rigcal_robust_options, sigma_px, -1, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_robust_options, samples, 0, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_robust_options, samples, 100001, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_robust_options, max_units, 0, RIGCAL_ERR_RANGE),
    BAD_END};
static const impossible BAD_INDEX[] = {BAD_INT(rigcal_pair, i, -1, RIGCAL_ERR_RANGE),
                                       BAD_INT(rigcal_pair, i, N, RIGCAL_ERR_RANGE),
                                       BAD_INT(rigcal_pair, j, -1, RIGCAL_ERR_RANGE),
                                       BAD_INT(rigcal_pair, j, INT32_MAX, RIGCAL_ERR_RANGE),
                                       BAD_END};
static const impossible BAD_VIEW_POSE[] = {
    BAD_INT(rigcal_view_pose, camera, -1, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_view_pose, camera, N_CAMERAS, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_view_pose, camera, INT32_MAX, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_view_pose, placement, -1, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_view_pose, placement, N_PLACEMENTS, RIGCAL_ERR_RANGE),
    BAD_REAL(rigcal_view_pose, information[0], -1, RIGCAL_ERR_DEGENERATE),
    BAD_REAL(rigcal_view_pose, information[20], 0, RIGCAL_ERR_DEGENERATE),
    BAD_REAL(rigcal_view_pose, cam_from_target.R[0], 2, RIGCAL_ERR_ROTATION),
    BAD_REAL(rigcal_view_pose, cam_from_target.R[8], -5, RIGCAL_ERR_ROTATION),
    BAD_END};
static const impossible BAD_RIG_VIEW[] = {
    BAD_INT(rigcal_rig_view, camera, -1, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_rig_view, camera, N_CAMERAS, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_rig_view, camera, INT32_MIN, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_rig_view, placement, -1, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_rig_view, placement, N_PLACEMENTS, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_rig_view, target, 1, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_rig_view, target, -1, RIGCAL_ERR_RANGE),
    BAD_END};
static const impossible BAD_MOUNTED[] = {
    BAD_INT(rigcal_mounted_camera, camera.lens, 2, RIGCAL_ERR_CAMERA),
    BAD_REAL(rigcal_mounted_camera, camera.fx, 0, RIGCAL_ERR_CAMERA),
    BAD_REAL(rigcal_mounted_camera, cam_from_rig.R[0], 2, RIGCAL_ERR_ROTATION),
    BAD_REAL(rigcal_mounted_camera, cam_from_rig.R[8], -5, RIGCAL_ERR_ROTATION),
    BAD_REAL(rigcal_mounted_camera, Sigma[0], -1, RIGCAL_ERR_RANGE),
    BAD_REAL(rigcal_mounted_camera, Sigma[35], -1e-9, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_mounted_camera, has_Sigma, -1, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_mounted_camera, has_Sigma, 2, RIGCAL_ERR_RANGE),
    BAD_END};
/* Bytes, four of which are overwritten. */
static const impossible BAD_SAVED[] = {
    {RIGCAL_ERR_FOREIGN, 0, 0, 0x43474952 + 1},
    {RIGCAL_ERR_DAMAGED, 8, 0, 1},
    {RIGCAL_ERR_DAMAGED, 8, 0, INT32_MIN},
    {RIGCAL_ERR_DAMAGED, 20, 0, INT32_MAX},
    {RIGCAL_ERR_DAMAGED, 40, 0, 0},
    {RIGCAL_ERR_DAMAGED, RIGCAL_STORE_SIZE(2) - 4, 0, -1},
    BAD_END};
static const impossible BAD_SAVED_RIG[] = {
    {RIGCAL_ERR_FOREIGN, 0, 0, 0x43474952 + 1},
    {RIGCAL_ERR_DAMAGED, 8, 0, 1},
    {RIGCAL_ERR_DAMAGED, 20, 0, INT32_MAX},
    {RIGCAL_ERR_DAMAGED, 40, 0, -1},
    {RIGCAL_ERR_DAMAGED, RIGCAL_STORE_RIG_SIZE(2, 1) - 4, 0, -1},
    BAD_END};
static const impossible BAD_POSE[] = {
    BAD_REAL(rigcal_mounted_camera, cam_from_rig.R[0], 2, RIGCAL_ERR_ROTATION),
    BAD_REAL(rigcal_mounted_camera, cam_from_rig.R[8], -5, RIGCAL_ERR_ROTATION), BAD_END};
static const impossible BAD_SAVED_CAMERA[] = {
    BAD_INT(rigcal_mounted_camera, camera.lens, 2, RIGCAL_ERR_CAMERA),
    BAD_REAL(rigcal_mounted_camera, camera.fx, 0, RIGCAL_ERR_CAMERA),
    BAD_REAL(rigcal_mounted_camera, cam_from_rig.R[0], 2, RIGCAL_ERR_ROTATION), BAD_END};
/* Overwrites the group of the first of two cameras. */
static const impossible BAD_GROUP[] = {{RIGCAL_ERR_RANGE, 0, 0, -1},
                                       {RIGCAL_ERR_RANGE, 0, 0, 1},
                                       {RIGCAL_ERR_RANGE, 4, 0, 2},
                                       {RIGCAL_ERR_RANGE, 4, 0, INT32_MIN},
                                       BAD_END};
/* An element of the first row, and one off the diagonal. */
static const impossible BAD_JOINT[] = {BAD_NUMBER(-1, RIGCAL_ERR_RANGE),
                                       BAD_NUMBER(-1e-9, RIGCAL_ERR_RANGE),
                                       {RIGCAL_ERR_RANGE, sizeof(rigcal_real), 1, 1},
                                       {RIGCAL_ERR_RANGE, sizeof(rigcal_real), 1, -1},
                                       BAD_END};
static const impossible BAD_SIGHTING[] = {
    BAD_INT(rigcal_sighting, camera, -1, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_sighting, camera, 2, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_sighting, camera, INT32_MIN, RIGCAL_ERR_RANGE), BAD_END};
static const impossible BAD_LINE[] = {BAD_NUMBER(5, RIGCAL_ERR_RANGE), BAD_END};
static const impossible NOT_POSITIVE[] = {BAD_NUMBER(0, RIGCAL_ERR_RANGE),
                                          BAD_NUMBER(-1, RIGCAL_ERR_RANGE), BAD_END};
static const impossible BAD_DEVIATION[] = {
    BAD_REAL(rigcal_intrinsics_sigma, focal, -1, RIGCAL_ERR_RANGE),
    BAD_REAL(rigcal_intrinsics_sigma, aspect, 2e9, RIGCAL_ERR_RANGE),
    BAD_REAL(rigcal_intrinsics_sigma, k2, -1e-9, RIGCAL_ERR_RANGE), BAD_END};
static const impossible BAD_CHANGE[] = {
    BAD_REAL(rigcal_intrinsics_change, focal, 2e9, RIGCAL_ERR_RANGE),
    BAD_REAL(rigcal_intrinsics_change, k2, -2e9, RIGCAL_ERR_RANGE), BAD_END};
static const impossible TOO_FAR[] = {
    BAD_REAL(rigcal_intrinsics_change, focal, -1.5, RIGCAL_ERR_CAMERA), BAD_END};
static const impossible BAD_TOLD[] = {
    BAD_INT(rigcal_faults, verdict, -1, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_faults, verdict, 4, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_faults, n, -1, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_faults, n, 0, RIGCAL_ERR_RANGE), /* although a fault is named */
    BAD_INT(rigcal_faults, n_alike, -1, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_faults, n_alike, N_FAULTS, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_faults, n_cameras, -1, RIGCAL_ERR_RANGE),
    BAD_END};
static const impossible BAD_FAULT[] = {
    BAD_INT(rigcal_fault, kind, -1, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_fault, kind, RIGCAL_FAULT_KINDS, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_fault, kind, INT32_MIN, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_fault, camera, -2, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_fault, camera, N_CAMERAS, RIGCAL_ERR_RANGE),
    BAD_INT(rigcal_fault, camera, INT32_MAX, RIGCAL_ERR_RANGE),
    BAD_END};
static const impossible NEGATIVE[] = {BAD_NUMBER(-1, RIGCAL_ERR_RANGE),
                                      BAD_NUMBER(-1e-9, RIGCAL_ERR_RANGE), BAD_END};

/* The first number of a covariance. */
static const impossible BAD_DIAGONAL[] = {BAD_NUMBER(-1, RIGCAL_ERR_RANGE),
                                          BAD_NUMBER(-1e-9, RIGCAL_ERR_RANGE), BAD_END};
/* sigma_a, sigma_b, k, near_a, far_a */
#define NTH(n) ((n) * sizeof(rigcal_real))
static const impossible BAD_PAIR_NUMBERS[] = {BAD_NUMBER(-1, RIGCAL_ERR_RANGE),
                                              {RIGCAL_ERR_RANGE, NTH(1), 1, 0},
                                              {RIGCAL_ERR_RANGE, NTH(1), 1, -1},
                                              {RIGCAL_ERR_RANGE, NTH(1), 1, 2e6},
                                              {RIGCAL_ERR_RANGE, NTH(2), 1, 0},
                                              {RIGCAL_ERR_RANGE, NTH(2), 1, 101},
                                              {RIGCAL_ERR_RANGE, NTH(3), 1, -1},
                                              {RIGCAL_ERR_RANGE, NTH(3), 1, 9},
                                              {RIGCAL_ERR_RANGE, NTH(4), 1, -1},
                                              {RIGCAL_ERR_RANGE, NTH(4), 1, 1},
                                              BAD_END};
static const impossible BAD_BAND[] = {
    BAD_INT(rigcal_band, camera_b.lens, 2, RIGCAL_ERR_CAMERA),
    BAD_REAL(rigcal_band, camera_b.fx, 0, RIGCAL_ERR_CAMERA),
    BAD_REAL(rigcal_band, ray[0], 3, RIGCAL_ERR_RANGE),
    BAD_REAL(rigcal_band, towards[1], -3, RIGCAL_ERR_RANGE),
    BAD_REAL(rigcal_band, across, 0, RIGCAL_ERR_RANGE),
    BAD_REAL(rigcal_band, epipole2, -1, RIGCAL_ERR_RANGE),
    BAD_REAL(rigcal_band, sigma_b, 0, RIGCAL_ERR_RANGE),
    BAD_REAL(rigcal_band, k, -1, RIGCAL_ERR_RANGE),
    BAD_REAL(rigcal_band, far_a, 1, RIGCAL_ERR_RANGE),
    BAD_END};
static const impossible BAD_RAY[] = {BAD_NUMBER(3, RIGCAL_ERR_RANGE),
                                     BAD_NUMBER(-3, RIGCAL_ERR_RANGE), BAD_END};

/* A kind of element: its size; the place of its numbers, which are contiguous; what it
 * cannot be; and the status if all its bytes are 0, if that is fixed. */
typedef struct {
    size_t size, first_real, n_reals;
    const impossible *bad;
    rigcal_status zeroed;
} kind;

#define REALS(n) sizeof(rigcal_real) * (n), 0, (n)
/* A struct that is given by its parts: only whether it is NULL matters. */
static const kind THERE = {1, 0, 0, NULL, 0};
static const kind NUMBER = {REALS(1), NULL, 0};
static const kind POSITIVE = {REALS(1), NOT_POSITIVE, 0};
static const kind TOLERANCE = {REALS(1), NEGATIVE, 0};
static const kind VEC2 = {REALS(2), NULL, 0};
static const kind VEC3 = {REALS(3), NULL, 0};
static const kind VEC4 = {REALS(4), NULL, 0};
static const kind MAT3 = {REALS(9), NULL, 0};
static const kind RAY = {REALS(3), NULL, RIGCAL_ERR_RANGE};
static const kind QUATERNION = {REALS(4), NULL, RIGCAL_ERR_ROTATION};
static const kind LINE = {REALS(3), BAD_LINE, RIGCAL_ERR_RANGE};
static const kind ROTATION = {REALS(9), BAD_ROTATION, RIGCAL_ERR_ROTATION};
static const kind TRANSFORM = {REALS(12), BAD_ROTATION, RIGCAL_ERR_ROTATION};
static const kind WEIGHT = {REALS(1), NEGATIVE, 0};
static const kind OBSERVATION = {REALS(5), NULL, 0};
static const kind BEARING = {REALS(6), NULL, RIGCAL_ERR_RANGE};
static const kind POINT = {REALS(13), NULL, 0};
static const kind ELIMINATION = {REALS(6), NULL, 0};
static const kind CAMERA = {sizeof(rigcal_camera), offsetof(rigcal_camera, fx), 12,
                            BAD_CAMERA, RIGCAL_ERR_CAMERA};
static const kind PAIR = {sizeof(rigcal_pair), 0, 6, NULL, 0};
static const kind PAIR_OF_POINTS = {sizeof(rigcal_pair), 0, 6, BAD_INDEX, 0};
static const kind VIEW_POSE = {sizeof(rigcal_view_pose), 0, 33, BAD_VIEW_POSE,
                               RIGCAL_ERR_ROTATION};
/* All of the struct except its counts. */
static const kind MADE_POSE = {sizeof(rigcal_view_pose), 0, 34, NULL, 0};
static const kind RIG_VIEW = {sizeof(rigcal_rig_view), 0, 0, BAD_RIG_VIEW, RIGCAL_ERR_NULL};
static const kind VIEW_TO_MAKE = {sizeof(rigcal_rig_view), 0, 0, NULL, RIGCAL_ERR_NULL};
static const kind FIT = {sizeof(rigcal_rig_fit), 0, 3, NULL, 0};
static const kind MAT6 = {REALS(36), NULL, 0};
/* Poses of an adjusted rig, which are not checked again. */
static const kind RIG_CAMS = {N_CAMERAS * sizeof(rigcal_transform), 0, 0, NULL, 0};
static const kind RIG_PLACEMENTS = {N_PLACEMENTS * sizeof(rigcal_transform), 0, 0, NULL, 0};
static const kind RIG_GROUPS = {N_CAMERAS * sizeof(int32_t), 0, 0, NULL, 0};
static const kind RIG_MEMORY = {sizeof(rigcal_real) * RIG_WORK, 0, 0, NULL,
                                RIGCAL_ERR_STATE};
static const kind SECOND_POSE = {sizeof(rigcal_view_pose), 0, 33, BAD_VIEW_POSE, 0};
static const kind LINK = {sizeof(rigcal_link), 0, 0, NULL, 0};
static const kind ADVICE = {sizeof(rigcal_advice), 0, 0, NULL, 0};
static const kind WEAKEST = {sizeof(rigcal_weakest), 0, 0, NULL, 0};
static const kind TAKES = {N_VIEWS, 0, 0, NULL, 0};
static const kind JUDGED = {sizeof(rigcal_judged_view), 0, 0, NULL, 0};
static const kind JUDGEMENT = {sizeof(rigcal_judgement),
                               offsetof(rigcal_judgement, sigma_px), 2, NULL, 0};
static const kind CAUSE = {sizeof(rigcal_cause), offsetof(rigcal_cause, distance), 1, NULL,
                           0};
static const kind JUDGE_SOLVER = {sizeof(rigcal_judge_solver), 0, 0, NULL,
                                  RIGCAL_ERR_STATE};
static const kind CAUSE_SOLVER = {sizeof(rigcal_cause_solver), 0, 0, NULL,
                                  RIGCAL_ERR_STATE};
static const kind DEVIATION = {REALS(5), BAD_DEVIATION, 0};
static const kind CLOCKS = {sizeof(rigcal_rig_clocks), 0, 0, NULL, 0};
static const kind CLOCK_MEMORY = {sizeof(rigcal_real) * CLOCKS_WORK, 0, 0, NULL,
                                  RIGCAL_ERR_STATE};
static const kind MADE = {REALS(6), BAD_CHANGE, 0};
static const kind CHANGE = {REALS(6), TOO_FAR, 0};
static const kind CONSIDER_SOLVER = {sizeof(rigcal_consider_solver), 0, 0, NULL,
                                     RIGCAL_ERR_STATE};
static const kind FAULTS_SOLVER = {sizeof(rigcal_faults_solver), 0, 0, NULL,
                                   RIGCAL_ERR_STATE};
static const kind FAULTS = {sizeof(rigcal_faults), offsetof(rigcal_faults, F), 10, BAD_TOLD,
                            0};
static const kind FAULT = {sizeof(rigcal_fault), offsetof(rigcal_fault, value), 18,
                           BAD_FAULT, 0};
static const kind TEXT = {TEXT_SIZE, 0, 0, NULL, 0};
static const kind CHOOSE_SOLVER = {sizeof(rigcal_choose_solver), 0, 0, NULL,
                                   RIGCAL_ERR_STATE};
static const kind RIG_UNREAD = {sizeof(rigcal_real) * RIG_WORK, 0, 0, NULL, 0};
static const kind RIG_SOLVER = {sizeof(rigcal_rig_solver), 0, 0, NULL, RIGCAL_ERR_STATE};
static const kind OPTIONS = {sizeof(rigcal_paper_options),
                             offsetof(rigcal_paper_options, guess_ypr), 5, BAD_OPTIONS, 0};
static const kind POSE = {sizeof(rigcal_paper_pose), 0, 18, NULL, 0};
static const kind SPREAD = {REALS(1), NOT_POSITIVE, RIGCAL_ERR_RANGE};
static const kind ML_POSE = {REALS(15), NULL, 0};
/* Options whose member `start` is not read. */
static const kind COLD = {sizeof(rigcal_pose_options),
                          offsetof(rigcal_pose_options, sigma_px), 1, BAD_COLD, 0};
static const kind WARM = {sizeof(rigcal_pose_options),
                          offsetof(rigcal_pose_options, sigma_px), 13, BAD_WARM, 0};
static const kind UNCERTAINTY = {REALS(46), NULL, 0};
/* These are internal. So the only test is that they were begun. */
static const kind POSE_SOLVER = {sizeof(rigcal_pose_solver), 0, 0, NULL, RIGCAL_ERR_STATE};
static const kind ROBUST = {sizeof(rigcal_robust_options), 0, 2, BAD_ROBUST,
                            RIGCAL_ERR_RANGE};
static const kind ROBUST_SOLVER = {sizeof(rigcal_robust_solver), 0, 0, NULL,
                                   RIGCAL_ERR_STATE};
static const kind BLAME = {sizeof(rigcal_blame), offsetof(rigcal_blame, rms_px), 4, NULL,
                           0};
static const kind DIAGNOSIS = {sizeof(rigcal_diagnosis),
                               offsetof(rigcal_diagnosis, rms_mirrored_px), 3, NULL, 0};
static const kind MONITOR = {sizeof(rigcal_real) * MONITOR_SIZE, 0, 0, NULL,
                             RIGCAL_ERR_STATE};
static const kind WATCHING = {sizeof(rigcal_monitor_options), 0, 7, NULL, RIGCAL_ERR_RANGE};
static const kind REPORT = {sizeof(rigcal_monitor_report),
                            offsetof(rigcal_monitor_report, confidence), 4, NULL, 0};
static const kind OF_BODY = {sizeof(rigcal_body_report),
                             offsetof(rigcal_body_report, share), 10, NULL, 0};
static const kind SEARCH = {sizeof(rigcal_neldermead), 0, 0, NULL, RIGCAL_ERR_STATE};
static const kind SOLVER = {sizeof(rigcal_paper_solver), 0, 0, NULL, RIGCAL_ERR_STATE};
static const kind ENTRY = {sizeof(rigcal_layout_entry), 0, 0, NULL, 0};
static const kind INT32 = {sizeof(int32_t), 0, 0, NULL, 0};
static const kind SIZE = {sizeof(size_t), 0, 0, NULL, 0};
static const kind BYTES = {1, 0, 0, NULL, 0};
static const kind MOUNTED = {sizeof(rigcal_mounted_camera),
                             offsetof(rigcal_mounted_camera, camera.fx), 60, BAD_MOUNTED,
                             RIGCAL_ERR_CAMERA};
static const kind SAVED = {RIGCAL_STORE_SIZE(2), 0, 0, BAD_SAVED, RIGCAL_ERR_FOREIGN};
static const kind SAVED_RIG = {RIGCAL_STORE_RIG_SIZE(2, 1), 0, 0, BAD_SAVED_RIG,
                               RIGCAL_ERR_FOREIGN};
/* The parts of a calibrated rig of two cameras: its cameras are not read; or only their
 * poses; or all of them except the covariances. */
static const kind KEPT_UNREAD = {sizeof(rigcal_mounted_camera), 0, 0, NULL, 0};
static const kind KEPT_POSE = {sizeof(rigcal_mounted_camera),
                               offsetof(rigcal_mounted_camera, cam_from_rig), 12, BAD_POSE,
                               RIGCAL_ERR_ROTATION};
static const kind KEPT_CAMERA = {sizeof(rigcal_mounted_camera),
                                 offsetof(rigcal_mounted_camera, camera.fx), 24,
                                 BAD_SAVED_CAMERA, RIGCAL_ERR_CAMERA};
static const kind KEPT_GROUPS = {2 * sizeof(int32_t), 0, 0, BAD_GROUP, 0};
static const kind KEPT_HELD = {2, 0, 0, NULL, RIGCAL_ERR_CAPACITY}; /* 0: both are free */
static const kind KEPT_SIGMA = {REALS(21), NULL, 0};
static const kind KEPT_JOINT = {REALS(21), BAD_JOINT, 0};
static const kind KEPT_NUMBERS = {REALS(4), NEGATIVE, RIGCAL_ERR_STATE};
/* Without a covariance, poses count as exact. */
static const kind KEPT_OR_EXACT = {REALS(4), NEGATIVE, 0};
static const kind SIGHTING = {sizeof(rigcal_sighting), offsetof(rigcal_sighting, uv), 2,
                              BAD_SIGHTING, 0};
/* Arguments that a begin passes on to its steps. */
static const kind SIGMA_UNREAD = {sizeof(rigcal_real) * 21, 0, 0, NULL, 0};
static const kind SIGHTING_UNREAD = {sizeof(rigcal_sighting), 0, 0, NULL, 0};
static const kind NOISE_UNREAD = {sizeof(rigcal_real), 0, 0, NULL, 0};
static const kind POINT_UNREAD = {sizeof(rigcal_point_solver), 0, 0, NULL, 0};
/* All members except those that the caller sets. */
static const kind MEASURED = {offsetof(rigcal_measured_point, gains), 0, 0, NULL, 0};
static const kind END = {sizeof(rigcal_measured_point), 0, 3, NULL, RIGCAL_ERR_NULL};
static const kind POINT_SOLVER = {sizeof(rigcal_point_solver), 0, 0, NULL,
                                  RIGCAL_ERR_STATE};
static const kind PAIR_SIGMA = {REALS(36), BAD_DIAGONAL, 0};
static const kind PAIR_NUMBERS = {REALS(5), BAD_PAIR_NUMBERS, RIGCAL_ERR_RANGE};
static const kind BAND = {sizeof(rigcal_band), offsetof(rigcal_band, camera_b.fx), 34,
                          BAD_BAND, RIGCAL_ERR_CAMERA};
static const kind BAND_POINT = {REALS(6), NULL, 0};
static const kind RAY_OF_PIXEL = {REALS(9), BAD_RAY, RIGCAL_ERR_RANGE};
static const kind MATCH = {sizeof(rigcal_match), offsetof(rigcal_match, chi2), 5, NULL, 0};
static const kind SPAN = {sizeof(rigcal_span), 0, 0, NULL, 0};
static const kind SPANS_SOLVER = {sizeof(rigcal_spans_solver), 0, 0, NULL,
                                  RIGCAL_ERR_STATE};
static const kind TRANSFER = {REALS(19), NULL, 0};
static const kind TRANSFER_IN = {REALS(6), NULL, 0}; /* uv and Sigma */
static const kind RECTIFIED = {sizeof(rigcal_rectified), 0, 19, NULL, 0};
static const kind THREE_SIZES = {3 * sizeof(size_t), 0, 0, NULL, RIGCAL_ERR_RANGE};
static const kind SAVED_INFO = {sizeof(rigcal_saved_info), 0, 0, NULL, 0};

/* ---- roles of an argument ------------------------------------------------ */

typedef enum {
    NONE,       /* end of the list */
    R_OUT,      /* an output: all of it is written on success, none on failure */
    R_OUT_PART, /* an output of which a part may stay */
    R_OUT_OPT,  /* may be NULL */
    R_OUT_BAD,  /* may be NULL; always written: an index, or -1 */
    R_WORK,     /* must not be NULL; may be written at any time */
    R_STATE,    /* is read and written; stays unchanged if the arguments are refused */
    R_IN,       /* is read; each number is checked */
    R_IN_OPT,   /* may be NULL */
    R_UNREAD,   /* may be NULL; may contain anything */
    R_VALUE,    /* a number by value, which is checked */
    R_ANY,      /* a number by value; NaN and infinity are valid too */
    R_COUNT     /* an integer by value, from `low` to `high` */
} role;

typedef struct {
    role role;
    const kind *kind;
    size_t n;
    const void *valid;     /* n elements; NULL for outputs */
    int64_t low, high;     /* limits of a count; high = 0: no limit that can be tried */
    rigcal_status outside; /* status of a count below `low` or above `high`; 0: any */
} argument;

#define OUT(kind, n) \
    { \
        R_OUT, &kind, n, NULL, 0, 0, 0 \
    }
#define OUT_PART(kind, n) \
    { \
        R_OUT_PART, &kind, n, NULL, 0, 0, 0 \
    }
#define OUT_OPT(kind, n) \
    { \
        R_OUT_OPT, &kind, n, NULL, 0, 0, 0 \
    }
#define OUT_BAD \
    { \
        R_OUT_BAD, &INT32, 1, NULL, 0, 0, 0 \
    }
#define WORK(kind, n) \
    { \
        R_WORK, &kind, n, NULL, 0, 0, 0 \
    }
#define STATE(kind, valid) \
    { \
        R_STATE, &kind, 1, valid, 0, 0, 0 \
    }
#define IN(kind, n, valid) \
    { \
        R_IN, &kind, n, valid, 0, 0, 0 \
    }
#define IN_OPT(kind, n, valid) \
    { \
        R_IN_OPT, &kind, n, valid, 0, 0, 0 \
    }
#define VALUE(kind, valid) \
    { \
        R_VALUE, &kind, 1, valid, 0, 0, 0 \
    }
#define ANY_VALUE(valid) \
    { \
        R_ANY, &NUMBER, 1, valid, 0, 0, 0 \
    }
#define COUNT(valid, low, status) \
    { \
        R_COUNT, &SIZE, 1, valid, low, INT64_C(1) << 28, status \
    }
/* The number of pairs may be four times that of points. */
#define PAIRS(valid, low, status) \
    { \
        R_COUNT, &SIZE, 1, valid, low, INT64_C(1) << 30, status \
    }
/* A capacity can never be too large. */
#define ROOM(valid, low, status) \
    { \
        R_COUNT, &SIZE, 1, valid, low, 0, status \
    }
/* Cameras of a stored calibration. */
#define CAMERAS(valid) \
    { \
        R_COUNT, &SIZE, 1, valid, 1, RIGCAL_STORE_CAMERAS_MAX, RIGCAL_ERR_TOO_FEW \
    }
/* A view given by its parts: camera, observations, sigma, n. */
#define VIEW_OF_N(least) \
    IN(THERE, 1, &INT_1), IN(CAMERA, 1, &ok.camera), IN(OBSERVATION, N, ok.observations), \
        IN_OPT(SPREAD, N, ok.spreads), COUNT(&SIZE_6, least, RIGCAL_ERR_TOO_FEW)
/* The same, for functions that do not read sigma. */
#define VIEW_WITHOUT_SIGMA(least) \
    IN(THERE, 1, &INT_1), IN(CAMERA, 1, &ok.camera), IN(OBSERVATION, N, ok.observations), \
        {R_UNREAD, &NUMBER, N, ok.spreads, 0, 0, 0}, \
        COUNT(&SIZE_6, least, RIGCAL_ERR_TOO_FEW)
/* An index below n. */
#define LESS(valid, n) \
    { \
        R_COUNT, &SIZE, 1, valid, 0, (n)-1, RIGCAL_ERR_RANGE \
    }
/* A rig given by its parts: itself, cams_from_rig, n_cameras, rig_from_placements, group,
 * n_views, work, work_capacity. */
#define RIG_OF(cams, placements, group, work) \
    IN(THERE, 1, &INT_1), cams, COUNT(&SIZE_3, 1, RIGCAL_ERR_TOO_FEW), placements, group, \
        COUNT(&SIZE_6, 1, RIGCAL_ERR_TOO_FEW), work, \
        ROOM(&SIZE_WORK, RIGCAL_RIG_WORK(0, 3, 2), RIGCAL_ERR_CAPACITY)
#define RIG_TO_JUDGE(placements) \
    IN(THERE, 1, &INT_1), IN(TRANSFORM, N_CAMERAS, ok.poses), \
        COUNT(&SIZE_3, 1, RIGCAL_ERR_TOO_FEW), placements, WORK(INT32, N_CAMERAS), \
        COUNT(&SIZE_6, 1, RIGCAL_ERR_TOO_FEW), WORK(NUMBER, JUDGE_WORK), \
        ROOM(&SIZE_TO_JUDGE, JUDGE_WORK, RIGCAL_ERR_CAPACITY)
/* A choice given by its parts: whether it is NULL, second_poses, takes, sigma_px. */
#define JUDGE_CHOICE(second) \
    IN(THERE, 1, &INT_1), second, STATE(TAKES, ok.takes), VALUE(POSITIVE, &REAL_SIGMA)
/* A rig with the poses of its views, a judgement and a symmetry, given by their parts. */
#define RIG_OF_CAUSE \
    IN(THERE, 1, &INT_1), IN(TRANSFORM, N_CAMERAS, ok.poses), \
        COUNT(&SIZE_3, 1, RIGCAL_ERR_TOO_FEW), IN(TRANSFORM, N_PLACEMENTS, ok.placements), \
        STATE(RIG_GROUPS, ok.groups), COUNT(&SIZE_6, 1, RIGCAL_ERR_TOO_FEW), \
        STATE(RIG_UNREAD, ok.rig_work), ROOM(&SIZE_WORK, 0, 0), \
        IN(VIEW_POSE, N_VIEWS, ok.view_poses), IN(JUDGEMENT, 1, &ok.judgement), \
        IN_OPT(THERE, 1, &INT_1), IN(INT32, N, ok.permutation), WORK(OBSERVATION, N)
#define RIG_TO_CHOOSE \
    IN(THERE, 1, &INT_1), WORK(TRANSFORM, N_CAMERAS), \
        COUNT(&SIZE_3, 1, RIGCAL_ERR_TOO_FEW), WORK(TRANSFORM, N_PLACEMENTS), \
        WORK(INT32, N_CAMERAS), COUNT(&SIZE_6, 1, RIGCAL_ERR_TOO_FEW), \
        WORK(NUMBER, CHOOSE_WORK), ROOM(&SIZE_CHOOSE, CHOOSE_WORK, RIGCAL_ERR_CAPACITY)
/* A calibrated rig given by its parts: itself, cameras, group, held, capacity, Sigma,
 * Sigma_capacity, n_cameras, its numbers. */
#define KEPT_OF(cameras, Sigma) \
    IN(THERE, 1, &INT_1), IN(cameras, 2, ok.mounted), IN(KEPT_GROUPS, 1, ok.kept_group), \
        IN(KEPT_HELD, 1, ok.kept_held), ROOM(&SIZE_2, 2, RIGCAL_ERR_CAPACITY), \
        IN(Sigma, 1, ok.kept_Sigma), \
        ROOM(&SIZE_KEPT, RIGCAL_CALIBRATED_SIZE(1), RIGCAL_ERR_CAPACITY), \
        CAMERAS(&SIZE_2), IN(KEPT_NUMBERS, 1, ok.kept_numbers)
/* What cameras saw of a point, given by its parts: the rig, seen, n, sigma_px,
 * parallax_least, work, work_capacity. */
#define SIGHTINGS_OF(cameras, Sigma, what, spread) \
    IN(THERE, 1, &INT_1), IN(cameras, 2, ok.mounted), IN(KEPT_GROUPS, 1, ok.kept_group), \
        IN(KEPT_HELD, 1, ok.kept_held), ROOM(&SIZE_2, 2, RIGCAL_ERR_CAPACITY), \
        IN(Sigma, 1, ok.kept_Sigma), \
        ROOM(&SIZE_KEPT, RIGCAL_CALIBRATED_SIZE(1), RIGCAL_ERR_CAPACITY), \
        CAMERAS(&SIZE_2), IN(KEPT_OR_EXACT, 1, ok.kept_numbers), \
        IN(what, 2, ok.sightings), \
        {R_COUNT, &SIZE, 1, &SIZE_2, 2, RIGCAL_SIGHTINGS_MAX, RIGCAL_ERR_TOO_FEW}, \
        IN_OPT(spread, 2, ok.spreads), VALUE(TOLERANCE, &REAL_PARALLAX), \
        WORK(NUMBER, RIGCAL_POINT_WORK(2)), \
        ROOM(&SIZE_POINT, RIGCAL_POINT_WORK(2), RIGCAL_ERR_CAPACITY)
/* A calibrated rig as an output: all parts except the last two. */
#define KEPT_OUT(n, n_Sigma, size) \
    IN(THERE, 1, &INT_1), OUT_PART(MOUNTED, n), OUT(INT32, n), OUT(BYTES, n), \
        ROOM(&SIZE_##n, n, RIGCAL_ERR_CAPACITY), OUT(NUMBER, n_Sigma), \
        ROOM(&size, n_Sigma, RIGCAL_ERR_CAPACITY)
/* A pair given by its parts: itself, camera_a, camera_b, b_from_a, Sigma, its numbers. */
#define PAIR_OF \
    IN(THERE, 1, &INT_1), IN(CAMERA, 1, &ok.camera), IN(CAMERA, 1, &ok.camera), \
        IN(TRANSFORM, 1, &ok.b_from_a), IN(PAIR_SIGMA, 1, ok.pair_Sigma), \
        IN(PAIR_NUMBERS, 1, ok.pair_numbers)
/* A rig that was adjusted. `memory` is the kind of its work array. */
#define RIG_DONE RIG_WITH_MEMORY(RIG_MEMORY)
#define RIG_WITH_MEMORY(memory) \
    IN(THERE, 1, &INT_1), STATE(RIG_CAMS, ok.poses), \
        COUNT(&SIZE_3, 1, RIGCAL_ERR_TOO_FEW), STATE(RIG_PLACEMENTS, ok.placements), \
        STATE(RIG_GROUPS, ok.groups), COUNT(&SIZE_6, 1, RIGCAL_ERR_TOO_FEW), \
        STATE(memory, ok.rig_work), ROOM(&SIZE_WORK, 0, 0)
/* The faults, whether options are there, kinds, is_truncated, work, work_capacity, breaks;
 * `at_fault` before the options. */
#define FAULTS_BY(faults, at_fault) \
    faults, ROOM(&SIZE_2, 1, RIGCAL_ERR_RANGE), at_fault, IN(THERE, 1, &INT_1), \
        CHOICE(&INT_0, 0, RIGCAL_FAULTS_ALL, RIGCAL_ERR_RANGE), \
        CHOICE(&INT_0, 0, 0, RIGCAL_ERR_RANGE), WORK(NUMBER, FAULTS_WORK), \
        ROOM(&SIZE_FAULTS, 4, RIGCAL_ERR_CAPACITY), IN_OPT(BYTES, N_PLACEMENTS, ok.takes)
/* Every number is valid for a tag. */
#define ANY_INTEGER(valid) \
    { \
        R_COUNT, &INT32, 1, valid, INT32_MIN, 0, 0 \
    }
#define CHOICE(valid, low, high, status) \
    { \
        R_COUNT, &INT32, 1, valid, low, high, status \
    }

/* ---- the functions ------------------------------------------------------- */

enum { MAX_ARGUMENTS = 18 };

typedef struct {
    const char *name;
    rigcal_status (*call)(void *const p[]);
    rigcal_status usual;
    uint64_t named;
    argument arguments[MAX_ARGUMENTS];
} function;

/* A set of statuses. */
#define BIT(status) (UINT64_C(1) << ((status) < 0 ? -(status) : 40 + (status)))
#define S(name) BIT(RIGCAL_ERR_##name)
#define ARGS (S(NULL) | S(NOT_FINITE) | S(RANGE))
#define MEASURING \
    (ARGS | S(CAMERA) | S(ROTATION) | S(TOO_FEW) | S(CAPACITY) | S(STATE) | S(NO_RAY) | \
     S(PARALLEL) | S(BEHIND) | S(DEGENERATE) | S(NO_CONSENSUS) | \
     BIT(RIGCAL_DISCONNECTED) | BIT(RIGCAL_POOR_FIT) | BIT(RIGCAL_VIEWS_LEFT_OUT) | \
     BIT(RIGCAL_FEW_AGREE) | BIT(RIGCAL_BUDGET_SPENT))
#define ROTATED (ARGS | S(ROTATION))
#define DEVICE (ARGS | S(CAMERA))
#define POINTS \
    (ARGS | S(RANGE) | S(TOO_FEW) | S(CAPACITY) | S(WIDE_RAY) | S(COINCIDENT) | \
     S(COLLINEAR) | S(EDGE_ON) | S(PRECISION))
#define POSES (S(BEHIND) | S(NO_POSE) | BIT(RIGCAL_BUDGET_SPENT))
#define VIEWED \
    (DEVICE | S(ROTATION) | S(TOO_FEW) | S(NO_RAY) | S(WIDE_RAY) | S(COINCIDENT) | \
     S(COLLINEAR) | S(PRECISION))
#define STORED (S(NULL) | S(FOREIGN) | S(DAMAGED) | S(VERSION))
#define FITTED \
    (S(NO_POSE) | S(DEGENERATE) | BIT(RIGCAL_AMBIGUOUS) | BIT(RIGCAL_POOR_FIT) | \
     BIT(RIGCAL_VAGUE) | BIT(RIGCAL_UNSEEN_POINT) | BIT(RIGCAL_BUDGET_SPENT))

#define JOINED \
    (ROTATED | S(TOO_FEW) | S(CAPACITY) | S(TWICE) | S(UNSORTED) | S(DEGENERATE) | \
     BIT(RIGCAL_DISCONNECTED) | BIT(RIGCAL_BUDGET_SPENT))
#define ADJUSTED (JOINED | DEVICE | S(BEHIND) | S(NO_RAY))
#define MET (S(NO_RAY) | S(EPIPOLE) | S(PARALLEL) | S(BEHIND) | S(DEGENERATE))
#define CAUSED (ROTATED | S(TOO_FEW) | S(UNSORTED) | S(DEGENERATE) | S(CAMERA))
#define AGREED \
    (VIEWED | FITTED | S(NO_CONSENSUS) | BIT(RIGCAL_FEW_AGREE) | BIT(RIGCAL_MOST_DISAGREE))

#define REAL(p) (*(const rigcal_real *)(p))
#define INT(p) (*(const int32_t *)(p))
#define UINT(p) (*(const uint32_t *)(p))
#define COUNTED(p) (*(const size_t *)(p))
#define CALL(name, ...) \
    static rigcal_status call_##name(void *const p[]) \
    { \
        return rigcal_##name(__VA_ARGS__); \
    }
#define CALL_BY(name, call) \
    static rigcal_status call_##name(void *const p[]) \
    { \
        return call; \
    }
#define F(name) "rigcal_" #name, call_##name

/* The view whose parts are arguments k to k + 4, and the rig of arguments k to k + 7. NULL
 * if argument k is NULL. */
#define VIEW_AT(k) \
    ((p[k]) ? &VIEW(p[(k) + 1], p[(k) + 2], p[(k) + 3], COUNTED(p[(k) + 4])) : NULL)
#define RIG_AT(k) \
    ((p[k]) ? &(rigcal_rig){.cams_from_rig = p[(k) + 1], \
                            .n_cameras = COUNTED(p[(k) + 2]), \
                            .rig_from_placements = p[(k) + 3], \
                            .n_placements = N_PLACEMENTS, \
                            .group = p[(k) + 4], \
                            .n_views = COUNTED(p[(k) + 5]), \
                            .views = ok.rig_views, \
                            .view_poses = NULL, \
                            .work = p[(k) + 6], \
                            .work_capacity = COUNTED(p[(k) + 7])} \
            : NULL)
#define KEPT_ARRAYS(k) \
    .cameras = p[(k) + 1], .group = p[(k) + 2], .held = p[(k) + 3], \
    .capacity = COUNTED(p[(k) + 4]), .Sigma = p[(k) + 5], \
    .Sigma_capacity = COUNTED(p[(k) + 6])
/* A calibrated rig, whose numbers are argument k + 8; and one without content. */
#define KEPT_AT(k) \
    (p[k] ? with_numbers(&(rigcal_calibrated_rig){KEPT_ARRAYS(k), \
                                                  .n_cameras = COUNTED(p[(k) + 7])}, \
                         p[(k) + 8]) \
          : NULL)
#define KEPT_TO(k) (p[k] ? &(rigcal_calibrated_rig){KEPT_ARRAYS(k)} : NULL)

static rigcal_calibrated_rig *with_numbers(rigcal_calibrated_rig *rig, const void *numbers)
{
    if (numbers == NULL) { /* they are no pointer of the rig */
        return NULL;
    }
    memcpy(&rig->sigma_px, numbers, 4 * sizeof(rigcal_real));
    return rig;
}

static const rigcal_sightings *sightings_at(void *const p[],
                                            const rigcal_calibrated_rig *rig)
{
    static rigcal_calibrated_rig kept;
    static rigcal_sightings s;

    if (rig != NULL) {
        kept = *rig;
    }
    s.rig = (rig != NULL) ? &kept : NULL;
    s.seen = p[9];
    s.n = COUNTED(p[10]);
    s.sigma_px = p[11];
    s.parallax_least = REAL(p[12]);
    s.work = p[13];
    s.work_capacity = COUNTED(p[14]);
    return &s;
}

#define PAIR_AT(k) pair_of(p[k], p[(k) + 1], p[(k) + 2], p[(k) + 3], p[(k) + 4], p[(k) + 5])

/* The arrays of a pair are its members, not pointers: without an array there is no pair. */
static rigcal_match_pair *pair_of(const void *is_there, const void *camera_a,
                                  const void *camera_b, const void *b_from_a,
                                  const void *Sigma, const void *numbers)
{
    static rigcal_match_pair pair;

    if (is_there == NULL || b_from_a == NULL || Sigma == NULL || numbers == NULL) {
        return NULL;
    }
    pair.camera_a = camera_a;
    pair.camera_b = camera_b;
    memcpy(&pair.b_from_a, b_from_a, sizeof pair.b_from_a);
    memcpy(pair.Sigma, Sigma, sizeof pair.Sigma);
    memcpy(&pair.sigma_a, numbers, 5 * sizeof(rigcal_real));
    return &pair;
}

/* The parts of a transfer that are read: uv and Sigma. */
static const rigcal_transfer *transfer_of(const void *numbers)
{
    static rigcal_transfer transfer;

    memcpy(&transfer, numbers, 6 * sizeof(rigcal_real));
    return &transfer;
}

/* A point as an output, as far as its gains, which are not used. */
static rigcal_status measure_to(void *out, uint8_t used[], const rigcal_sightings *s,
                                const rigcal_point_solver *solver)
{
    const size_t size = offsetof(rigcal_measured_point, gains);
    rigcal_measured_point measured;
    rigcal_status status;

    memset(&measured, 0, sizeof measured);
    if (out != NULL) {
        memcpy(&measured, out, size);
    }
    status = (s != NULL)
                 ? rigcal_point_measure((out != NULL) ? &measured : NULL, used, s)
                 : rigcal_point_result((out != NULL) ? &measured : NULL, used, solver);
    if (out != NULL) {
        memcpy(out, &measured, size);
    }
    return status;
}

/* A rig with the views, or their poses, as argument k + 8. */
#define RIG_WITH(k, what) with_##what(RIG_AT(k), p[k], p[(k) + 8])

static rigcal_rig *with_views(rigcal_rig *rig, const void *is_there, const void *views)
{
    if (is_there) {
        rig->views = views;
    }
    return rig;
}

static rigcal_choice *choice_of(const void *is_there, const void *second, void *takes)
{
    static rigcal_choice choice;

    memset(&choice, 0, sizeof choice);
    choice.second_poses = second;
    choice.takes = takes;
    return is_there ? &choice : NULL;
}

static rigcal_choice *judged_by(const void *is_there, const void *second, void *takes,
                                const void *sigma_px)
{
    rigcal_choice *const choice = choice_of(is_there, second, takes);

    if (choice != NULL) {
        memcpy(&choice->sigma_px, sigma_px, sizeof choice->sigma_px);
    }
    return choice;
}

static const rigcal_symmetries *symmetries_of(const void *is_there, const void *numbers,
                                              void *room)
{
    static rigcal_symmetries symmetries;

    symmetries = (rigcal_symmetries){numbers, 1, N, room};
    return is_there ? &symmetries : NULL;
}

static const rigcal_rig *rig_considered(void)
{
    static const rigcal_considered considered = {.sum = RC(0.2), .own_sum = RC(0.1)};
    static const rigcal_rig rig = {.considered = &considered};

    return &rig;
}

static rigcal_considered *considered_of(const void *is_there, void *effects,
                                        const void *capacity, const void *loss)
{
    static rigcal_considered considered;

    memset(&considered, 0, sizeof considered);
    considered.effects = effects;
    considered.capacity = *(const size_t *)capacity;
    considered.loss = *(const int32_t *)loss;
    return is_there ? &considered : NULL;
}

static rigcal_rig *with_clocks(rigcal_rig *rig, const void *is_there,
                               const void *has_clocks)
{
    if (is_there) {
        rig->clocks = has_clocks ? &ok.clocks : NULL;
    }
    return rig;
}

/* Clocks for a function that uses only the offsets and the frame. */
static const rigcal_rig_clocks *clocks_of(const void *is_there, void *offsets,
                                          const void *frame)
{
    static rigcal_rig_clocks clocks;

    clocks.offsets = offsets;
    memcpy(&clocks.frame, frame, sizeof clocks.frame);
    return is_there ? &clocks : NULL;
}

static const rigcal_faults_options *faults_by(void *const p[])
{
    static rigcal_faults_options options;

    options.kinds = *(const int32_t *)p[13];
    options.is_truncated = *(const int32_t *)p[14];
    options.work = p[15];
    options.work_capacity = *(const size_t *)p[16];
    options.breaks = p[17];
    return p[12] ? &options : NULL;
}

/* The faults that were found, with clocks. */
static const rigcal_faults *told_of(const void *told, const void *clocks)
{
    static rigcal_faults found;

    if (told != NULL) {
        memcpy(&found, told, sizeof found);
        found.clocks = clocks;
    }
    return told ? &found : NULL;
}

static const rigcal_faults_words *words_of(const void *is_there, const void *length_scale,
                                           const void *time_scale)
{
    static rigcal_faults_words words;

    words.with_unseen = 1;
    memcpy(&words.length_scale, length_scale, sizeof words.length_scale);
    memcpy(&words.time_scale, time_scale, sizeof words.time_scale);
    return is_there ? &words : NULL;
}

static rigcal_estimated *estimated_of(void *const p[])
{
    static rigcal_estimated estimated;

    memset(&estimated, 0, sizeof estimated);
    estimated.considered.effects = p[10];
    estimated.considered.capacity = *(const size_t *)p[11];
    estimated.made = p[12];
    estimated.change = p[13];
    estimated.sigma = p[14];
    estimated.considered.loss = *(const int32_t *)p[17];
    return p[9] ? &estimated : NULL;
}

static rigcal_rig *with_deviations(rigcal_rig *rig, const void *is_there,
                                   const void *deviations)
{
    if (is_there) {
        rig->intrinsics_sigmas = deviations;
    }
    return rig;
}

static rigcal_rig *with_noise(rigcal_rig *rig, const void *is_there, const void *sigma_px)
{
    if (is_there) {
        rig->views = ok.rig_views;
        rig->sigma_px = *(const rigcal_real *)sigma_px;
    }
    return rig;
}

static rigcal_rig *with_poses(rigcal_rig *rig, const void *is_there, const void *poses)
{
    if (is_there) {
        rig->view_poses = poses;
    }
    return rig;
}

/* clang-format off */
CALL(layout, p[0], INT(p[1]))
CALL(rotation_from_yaw_pitch_roll, p[0], p[1])
CALL(yaw_pitch_roll_from_rotation, p[0], p[1])
CALL(rotation_from_vector, p[0], p[1])
CALL(vector_from_rotation, p[0], p[1])
CALL(rotation_from_quaternion, p[0], p[1])
CALL(quaternion_from_rotation, p[0], p[1])
CALL(rotation_nearest, p[0], p[1])
CALL(rotation_angle, p[0], p[1], p[2])
CALL(transform_compose, p[0], p[1], p[2])
CALL(transform_invert, p[0], p[1])
CALL(transform_point, p[0], p[1], p[2])
CALL(camera_center, p[0], p[1])
CALL(transform_between, p[0], p[1], p[2])
CALL(camera_check, p[0])
CALL(camera_project, p[0], p[1], p[2])
CALL(camera_ray, p[0], p[1], p[2])
CALL(camera_undistort, p[0], p[1], p[2])
CALL(camera_distort, p[0], p[1], p[2])
CALL(view_rms, p[0], p[1], VIEW_AT(2), p[7])
CALL(neldermead_begin, p[0], p[1], INT(p[2]), REAL(p[3]), REAL(p[4]), INT(p[5]))
CALL(neldermead_begin_simplex, p[0], p[1], INT(p[2]), REAL(p[3]), REAL(p[4]),
     INT(p[5]))
CALL(neldermead_ask, p[0], p[1])
CALL(neldermead_tell, p[0], REAL(p[1]))
CALL(neldermead_step, p[0], p[1] ? bowl : NULL, NULL, INT(p[2]))
CALL(neldermead_result, p[0], p[1], p[2], p[3])
CALL(bearings_of_view, p[0], p[1], VIEW_AT(2))
CALL(pair_make, p[0], p[1], COUNTED(p[2]), INT(p[3]), INT(p[4]))
CALL(pairs_choose, p[0], COUNTED(p[1]), p[2], p[3], COUNTED(p[4]))
CALL(pair_residual, p[0], p[1], p[2])
CALL(pair_coefficients, p[0], p[1], INT(p[2]), p[3])
CALL(pairs_eliminate, p[0], p[1], COUNTED(p[2]), INT(p[3]), INT(p[4]), p[5])
CALL(pairs_residual, p[0], p[1], COUNTED(p[2]), p[3])
CALL(translation_from_pairs, p[0], p[1], p[2], COUNTED(p[3]), p[4],
     COUNTED(p[5]))
CALL(translation_least_squares, p[0], p[1], p[2], COUNTED(p[3]))
CALL(paper_defaults, p[0])
CALL(paper_begin, p[0], p[1], COUNTED(p[2]), p[3], COUNTED(p[4]), p[5])
CALL(paper_step, p[0], INT(p[1]))
CALL(paper_result, p[0], p[1])
CALL(paper_solve, p[0], p[1], COUNTED(p[2]), p[3], COUNTED(p[4]), p[5])
CALL(pose_defaults, p[0])
CALL(pose_begin, p[0], p[1], VIEW_AT(2), p[7])
CALL(pose_step, p[0], INT(p[1]))
CALL(pose_result, p[0], COUNTED(p[1]), p[2], p[3], p[4])
CALL(pose_solve, p[0], COUNTED(p[1]), p[2], p[3], VIEW_AT(4), p[9])
CALL(pose_covariance, p[0], VIEW_AT(1), p[6], REAL(p[7]))
CALL(robust_defaults, p[0])
CALL(robust_begin, p[0], p[1], p[2], VIEW_AT(3), p[8])
CALL(robust_step, p[0], INT(p[1]))
CALL(robust_result, p[0], COUNTED(p[1]), p[2], p[3], p[4])
CALL(robust_solve, p[0], COUNTED(p[1]), p[2], p[3], p[4], p[5], VIEW_AT(6), p[11])
CALL(tag_solve, p[0], COUNTED(p[1]), p[2], p[3], p[4], p[5], REAL(p[6]), p[7])
CALL(pose_blame, p[0], p[1], VIEW_AT(2), p[7])
CALL(pose_diagnose, p[0], p[1], VIEW_AT(2), p[7])
CALL(depth_two_views, p[0], p[1], p[2], p[3], p[4])
CALL(depth_aligned, p[0], REAL(p[1]), p[2], p[3])
CALL(point_triangulate, p[0], p[1], p[2], p[3], COUNTED(p[4]), REAL(p[5]))
CALL(point_bound, p[0], p[1], p[2], p[3])
CALL(epiline, p[0], p[1], p[2])
CALL(epiline_px, p[0], p[1], p[2], p[3])
CALL(epiline_distance, p[0], p[1], p[2], p[3])
CALL(epiline_clip, p[0], p[1], INT(p[2]), INT(p[3]))
CALL(epiline_segment, p[0], p[1], p[2], p[3], REAL(p[4]), REAL(p[5]))
CALL(epiline_curve, p[0], COUNTED(p[1]), p[2], p[3], p[4], p[5], REAL(p[6]),
     REAL(p[7]))
CALL(transform_mean, p[0], p[1], p[2], p[3], p[4], COUNTED(p[5]))
CALL(view_pose_make, p[0], p[1], p[2])
CALL(rig_join, RIG_WITH(0, poses), p[9])
CALL(rig_join_begin, p[9], RIG_WITH(0, poses))
CALL(rig_join_step, p[0], INT(p[1]))
CALL(rig_adjust, p[9], p[10], RIG_WITH(0, views))
CALL(rig_begin, p[9], RIG_WITH(0, views))
CALL(rig_step, p[0], INT(p[1]))
CALL(rig_result, p[0], p[1], p[2])
CALL(rig_covariance, p[8], RIG_AT(0), REAL(p[9]), COUNTED(p[10]))
CALL(rig_pair, p[8], p[11], RIG_AT(0), REAL(p[9]), COUNTED(p[10]), COUNTED(p[12]))
CALL(rig_placement, p[8], RIG_AT(0), REAL(p[9]), COUNTED(p[10]))
CALL(rig_adjust_robust, p[9], p[10], p[11], RIG_WITH(0, noise))
CALL(rig_robust_begin, p[10], RIG_WITH(0, noise), INT(p[9]))
CALL(rig_robust_result, p[0], p[1], p[2], p[3])
CALL(rig_noise, p[8], p[9], RIG_AT(0))
CALL(rig_links, p[9], COUNTED(p[10]), p[11], p[12], RIG_WITH(0, poses))
CALL(priors_information, p[0], p[1], COUNTED(p[2]))
CALL(rig_advise, p[8], COUNTED(p[9]), p[10], p[11], RIG_AT(0))
CALL(rig_weakest, p[8], RIG_AT(0), REAL(p[9]))
CALL(rig_choose, choice_of(p[9], p[10], p[11]), p[12], RIG_WITH(0, poses))
CALL(choose_begin, p[12], choice_of(p[9], p[10], p[11]), RIG_WITH(0, poses))
CALL(choose_step, p[0], INT(p[1]))
CALL(choose_result, p[0], p[1])
CALL(rig_judge, p[16], p[17], p[14], p[15], judged_by(p[10], p[11], p[12], p[13]), with_poses(RIG_WITH(0, views), p[0], p[9]))
CALL(judge_begin, p[16], p[14], p[15], judged_by(p[10], p[11], p[12], p[13]), with_poses(RIG_WITH(0, views), p[0], p[9]))
CALL(judge_step, p[0], INT(p[1]))
CALL(match_k, p[0], REAL(p[1]), INT(p[2]))
CALL(ray_make, p[0], p[1], p[2])
CALL(band_make, p[6], PAIR_AT(0), p[7])
CALL(band_make_ray, p[6], PAIR_AT(0), p[7])
CALL(band_curve, p[0], COUNTED(p[1]), p[2], p[3])
CALL(band_test, p[0], p[1], p[2])
CALL(band_test_ray, p[0], p[1], p[2])
CALL(band_search, p[0], COUNTED(p[1]), p[2], p[3], p[4], p[5], p[6], COUNTED(p[7]))
CALL(band_search_rays, p[0], COUNTED(p[1]), p[2], p[3], p[4], p[5], p[6], COUNTED(p[7]))
CALL(spans_find, p[0], COUNTED(p[1]), p[2], p[3], p[4])
CALL(spans_begin, p[0], p[1])
CALL(spans_step, p[0], INT(p[1]))
CALL(spans_row, p[0], p[1], p[2], INT(p[3]))
CALL(spans_result, p[0], COUNTED(p[1]), p[2], p[3])
CALL(transfer_make, p[0], p[1] ? &ok.three : NULL, p[2], p[3], p[4], p[5])
CALL(transfer_test, p[0], p[1] ? transfer_of(p[1]) : NULL, REAL(p[2]), p[3])
CALL(rectify, p[0], p[1], p[2], p[3])
CALL(judge_result, p[0], p[1], p[2])
CALL(rig_cause, p[14], RIG_WITH(0, poses), p[9], symmetries_of(p[10], p[11], p[12]), COUNTED(p[13]))
CALL(camera_cause, p[14], RIG_WITH(0, poses), p[9], symmetries_of(p[10], p[11], p[12]), COUNTED(p[13]))
CALL(cause_begin, p[14], RIG_WITH(0, poses), p[9], symmetries_of(p[10], p[11], p[12]), COUNTED(p[13]))
CALL(camera_cause_begin, p[14], RIG_WITH(0, poses), p[9], symmetries_of(p[10], p[11], p[12]), COUNTED(p[13]))
CALL(cause_step, p[0], INT(p[1]))
CALL(cause_result, p[0], p[1])
CALL(rig_consider, considered_of(p[9], p[10], p[11], p[13]), p[12], RIG_WITH(0, deviations))
CALL(rig_estimate, estimated_of(p), p[15], RIG_WITH(0, deviations), REAL(p[16]))
CALL(camera_change, p[0], p[1], p[2])
CALL(considered_fit, p[0], p[1], p[2] ? rig_considered() : NULL)
CALL(consider_begin, p[12], considered_of(p[9], p[10], p[11], p[13]), RIG_WITH(0, deviations))
CALL(consider_step, p[0], INT(p[1]))
CALL(consider_result, p[0], p[1])
CALL(clocks_defaults, p[0])
CALL(clocks_sigma, p[9], p[10], RIG_WITH(0, clocks), REAL(p[11]))
CALL(clocks_frames, p[0], clocks_of(p[1], p[2], p[3]), COUNTED(p[4]))
CALL(rig_faults, p[8], p[9], COUNTED(p[10]), p[11], faults_by(p), RIG_AT(0))
CALL(faults_begin, p[8], p[9], COUNTED(p[10]), faults_by(p), RIG_AT(0))
CALL(faults_step, p[0], INT(p[1]))
CALL(faults_result, p[0], p[1], p[2])
CALL(faults_text, p[0], COUNTED(p[1]), p[2], told_of(p[3], p[4]), p[5], words_of(p[6], p[7], p[8]))
CALL(rig_residuals, p[8], COUNTED(p[9]), p[10], RIG_AT(0), COUNTED(p[11]))
CALL_BY(point_measure, measure_to(p[15], p[16], sightings_at(p, KEPT_AT(0)), NULL))
CALL(point_begin, p[15], sightings_at(p, KEPT_AT(0)))
CALL(point_step, p[0], INT(p[1]))
CALL_BY(point_result, measure_to(p[0], p[1], NULL, p[2]))
CALL(point_distance, p[9], p[10], KEPT_AT(0), p[11], p[12])
CALL(calibrated_take, KEPT_TO(0), RIG_AT(7), p[15], REAL(p[16]))
CALL(calibrated_covariance, p[9], KEPT_AT(0), COUNTED(p[10]), COUNTED(p[11]))
CALL(calibrated_pair, p[9], p[10], KEPT_AT(0), COUNTED(p[11]), COUNTED(p[12]))
CALL(monitor_defaults, p[0])
CALL(monitor_begin, p[9], COUNTED(p[10]), KEPT_AT(0), COUNTED(p[11]), p[12])
CALL(monitor_match, p[0], COUNTED(p[1]), p[2], COUNTED(p[3]), p[4], REAL(p[5]))
CALL(monitor_match_rays, p[0], COUNTED(p[1]), p[2], COUNTED(p[3]), p[4], REAL(p[5]))
CALL(monitor_view, p[0], p[1], COUNTED(p[2]), COUNTED(p[3]), p[4], COUNTED(p[5]), REAL(p[6]))
CALL(monitor_lifted, p[0], COUNTED(p[1]))
CALL(monitor_frame, p[0], p[1], REAL(p[2]))
CALL(monitor_ask, p[0], p[1])
CALL(monitor_body, p[0], p[1], COUNTED(p[2]))
CALL(monitor_moved, p[0], COUNTED(p[1]))
CALL(monitor_dismiss, p[0])
CALL(monitor_camera, p[0], p[1], COUNTED(p[2]))
CALL(monitor_pair, p[0], p[1], p[2], COUNTED(p[3]), COUNTED(p[4]))
CALL(monitor_rig, KEPT_TO(0), p[7])
CALL(store_save_rig, p[9], COUNTED(p[10]), p[11], KEPT_AT(0), UINT(p[12]), UINT(p[13]))
CALL(store_load_rig, KEPT_TO(0), p[7], p[8], COUNTED(p[9]))
CALL(store_save, p[0], COUNTED(p[1]), p[2], p[3], COUNTED(p[4]), UINT(p[5]),
     UINT(p[6]))
CALL(store_info, p[0], p[1], COUNTED(p[2]))
CALL(store_load, p[0], COUNTED(p[1]), p[2], p[3], COUNTED(p[4]))

static const function FUNCTIONS[] = {
    {F(layout), 0, S(NULL) | S(RANGE),
     {OUT(ENTRY, 1), CHOICE(&INT_0, 0, 100000, RIGCAL_ERR_RANGE)}},
    {F(rotation_from_yaw_pitch_roll), 0, ARGS | S(RANGE),
     {OUT(MAT3, 1), IN(VEC3, 1, ok.angles)}},
    {F(yaw_pitch_roll_from_rotation), 0, ROTATED,
     {OUT(VEC3, 1), IN(ROTATION, 1, ok.rotation)}},
    {F(rotation_from_vector), 0, ARGS | S(RANGE),
     {OUT(MAT3, 1), IN(VEC3, 1, ok.vector)}},
    {F(vector_from_rotation), 0, ROTATED,
     {OUT(VEC3, 1), IN(ROTATION, 1, ok.rotation)}},
    {F(rotation_from_quaternion), 0, ROTATED,
     {OUT(MAT3, 1), IN(QUATERNION, 1, ok.quaternion)}},
    {F(quaternion_from_rotation), 0, ROTATED,
     {OUT(VEC4, 1), IN(ROTATION, 1, ok.rotation)}},
    {F(rotation_nearest), 0, ROTATED,
     {OUT(MAT3, 1), IN(MAT3, 1, ok.matrix)}},
    {F(rotation_angle), 0, ROTATED,
     {OUT(NUMBER, 1), IN(ROTATION, 1, ok.rotation),
      IN(ROTATION, 1, ok.other_rotation)}},

    {F(transform_compose), 0, ROTATED,
     {OUT(TRANSFORM, 1), IN(TRANSFORM, 1, &ok.b_from_a),
      IN(TRANSFORM, 1, &ok.a_from_b)}},
    {F(transform_invert), 0, ROTATED,
     {OUT(TRANSFORM, 1), IN(TRANSFORM, 1, &ok.b_from_a)}},
    {F(transform_point), 0, ROTATED,
     {OUT(VEC3, 1), IN(TRANSFORM, 1, &ok.b_from_a), IN(VEC3, 1, ok.X)}},
    {F(camera_center), 0, ROTATED,
     {OUT(VEC3, 1), IN(TRANSFORM, 1, &ok.b_from_a)}},
    {F(transform_between), 0, ROTATED,
     {OUT(TRANSFORM, 1), IN(TRANSFORM, 1, &ok.b_from_a),
      IN(TRANSFORM, 1, &ok.a_from_b)}},

    {F(camera_check), 0, DEVICE, {IN(CAMERA, 1, &ok.camera)}},
    {F(camera_project), 0, DEVICE | S(BEHIND) | S(NO_RAY) | S(DEGENERATE),
     {OUT(VEC2, 1), IN(CAMERA, 1, &ok.camera), IN(VEC3, 1, ok.X)}},
    {F(camera_ray), 0, DEVICE | S(NO_RAY),
     {OUT(VEC3, 1), IN(CAMERA, 1, &ok.camera), IN(VEC2, 1, ok.uv)}},
    {F(camera_undistort), 0, DEVICE | S(NO_RAY) | S(WIDE_RAY),
     {OUT(VEC2, 1), IN(CAMERA, 1, &ok.camera), IN(VEC2, 1, ok.uv)}},
    {F(camera_distort), 0, DEVICE | S(NO_RAY),
     {OUT(VEC2, 1), IN(CAMERA, 1, &ok.camera), IN(VEC2, 1, ok.uv)}},
    {F(view_rms), 0,
     DEVICE | S(ROTATION) | S(BEHIND) | S(NO_RAY) | S(DEGENERATE) | S(TOO_FEW),
     {OUT(NUMBER, 1), OUT_OPT(INT32, 1), VIEW_WITHOUT_SIGMA(1),
      IN(TRANSFORM, 1, &ok.cams_from_world[0])}},

    {F(neldermead_begin), 0, ARGS | S(RANGE),
     {OUT_PART(SEARCH, 1), IN(VEC3, 1, ok.x0),
      CHOICE(&INT_3, 1, 3, RIGCAL_ERR_RANGE), VALUE(TOLERANCE, &REAL_TOL),
      VALUE(TOLERANCE, &REAL_TOL), CHOICE(&INT_1000, 1, 0, RIGCAL_ERR_RANGE)}},
    {F(neldermead_begin_simplex), 0, ARGS | S(RANGE),
     {OUT_PART(SEARCH, 1), IN(NUMBER, 12, ok.simplex),
      CHOICE(&INT_3, 1, 3, RIGCAL_ERR_RANGE), VALUE(TOLERANCE, &REAL_TOL),
      VALUE(TOLERANCE, &REAL_TOL), CHOICE(&INT_1000, 1, 0, RIGCAL_ERR_RANGE)}},
    {F(neldermead_ask), RIGCAL_RUNNING,
     S(NULL) | S(STATE) | BIT(RIGCAL_RUNNING) | BIT(RIGCAL_BUDGET_SPENT),
     {OUT(VEC3, 1), IN(SEARCH, 1, &ok.search)}},
    {F(neldermead_tell), RIGCAL_RUNNING,
     S(NULL) | S(STATE) | BIT(RIGCAL_RUNNING) | BIT(RIGCAL_BUDGET_SPENT),
     {STATE(SEARCH, &ok.search), ANY_VALUE(&REAL_COST)}},
    {F(neldermead_step), RIGCAL_RUNNING,
     S(NULL) | S(STATE) | S(RANGE) | BIT(RIGCAL_RUNNING) |
         BIT(RIGCAL_BUDGET_SPENT),
     {STATE(SEARCH, &ok.search_begun), IN(BYTES, 1, &INT_1),
      CHOICE(&INT_8, 1, 0, RIGCAL_ERR_RANGE)}},
    {F(neldermead_result), RIGCAL_RUNNING,
     S(NULL) | S(STATE) | S(NOT_FINITE) | BIT(RIGCAL_RUNNING) |
         BIT(RIGCAL_BUDGET_SPENT),
     {OUT(VEC3, 1), OUT_OPT(NUMBER, 1), OUT_OPT(INT32, 1),
      IN(SEARCH, 1, &ok.search)}},

    {F(bearings_of_view), 0, DEVICE | S(NO_RAY) | S(TOO_FEW),
     {OUT(BEARING, N), OUT_BAD, VIEW_WITHOUT_SIGMA(1)}},
    {F(pair_make), 0, ARGS | S(RANGE) | S(COINCIDENT),
     {OUT(PAIR, 1), IN(BEARING, 2, ok.bearings),
      COUNT(&SIZE_2, 2, RIGCAL_ERR_RANGE),
      CHOICE(&INT_1, 0, 1, RIGCAL_ERR_RANGE),
      CHOICE(&INT_0, 0, 1, RIGCAL_ERR_RANGE)}},
    {F(pairs_choose), 0, POINTS,
     {OUT_PART(PAIR, N_PAIRS), ROOM(&SIZE_15, 3, RIGCAL_ERR_CAPACITY),
      OUT(SIZE, 1), IN(BEARING, N, ok.bearings),
      COUNT(&SIZE_6, 3, RIGCAL_ERR_TOO_FEW)}},
    {F(pair_residual), 0, ROTATED,
     {OUT(NUMBER, 1), IN(PAIR, 1, &ok.pairs[4]),
      IN(ROTATION, 1, ok.rotation)}},
    {F(pair_coefficients), 0, ARGS | S(RANGE),
     {OUT(VEC3, 1), IN(PAIR, 1, &ok.pairs[4]),
      CHOICE(&INT_1, 0, 2, RIGCAL_ERR_RANGE), IN(VEC2, 1, ok.angles)}},
    {F(pairs_eliminate), 0, ARGS | S(RANGE) | S(TOO_FEW) | S(DEGENERATE),
     {OUT(ELIMINATION, 1), IN(PAIR, 6, ok.pairs),
      PAIRS(&SIZE_6, 3, RIGCAL_ERR_TOO_FEW),
      CHOICE(&INT_2, 0, 2, RIGCAL_ERR_RANGE),
      CHOICE(&INT_1, 0, 2, RIGCAL_ERR_RANGE), IN(VEC2, 1, ok.angles)}},
    {F(pairs_residual), 0, ARGS | S(RANGE) | S(TOO_FEW),
     {OUT(NUMBER, 1), IN(PAIR, 6, ok.pairs),
      PAIRS(&SIZE_6, 3, RIGCAL_ERR_TOO_FEW), IN(VEC3, 1, ok.angles)}},
    {F(translation_from_pairs), 0,
     ROTATED | S(RANGE) | S(TOO_FEW) | S(WIDE_RAY) | S(DEGENERATE),
     {OUT(VEC3, 1), IN(ROTATION, 1, ok.cams_from_world[0].R),
      IN(BEARING, N, ok.bearings), COUNT(&SIZE_6, 2, RIGCAL_ERR_TOO_FEW),
      IN(PAIR_OF_POINTS, 3, ok.pairs), PAIRS(&SIZE_3, 1, RIGCAL_ERR_TOO_FEW)}},
    {F(translation_least_squares), 0,
     ROTATED | S(RANGE) | S(TOO_FEW) | S(WIDE_RAY) | S(DEGENERATE),
     {OUT(VEC3, 1), IN(ROTATION, 1, ok.cams_from_world[0].R),
      IN(BEARING, N, ok.bearings), COUNT(&SIZE_6, 2, RIGCAL_ERR_TOO_FEW)}},

    {F(paper_defaults), 0, S(NULL), {OUT(OPTIONS, 1)}},
    {F(paper_begin), 0, ARGS | S(RANGE) | S(TOO_FEW) | S(WIDE_RAY),
     {OUT_PART(SOLVER, 1), IN(BEARING, N, ok.bearings),
      COUNT(&SIZE_6, 3, RIGCAL_ERR_TOO_FEW), IN(PAIR, N_PAIRS, ok.pairs),
      PAIRS(&SIZE_15, 3, RIGCAL_ERR_TOO_FEW), IN_OPT(OPTIONS, 1, &ok.options)}},
    {F(paper_step), RIGCAL_RUNNING,
     S(NULL) | S(RANGE) | S(STATE) | S(NO_POSE) | BIT(RIGCAL_RUNNING) |
         BIT(RIGCAL_BUDGET_SPENT),
     {STATE(SOLVER, &ok.solver), CHOICE(&INT_8, 1, 0, RIGCAL_ERR_RANGE)}},
    {F(paper_result), 0, S(NULL) | S(STATE) | POSES,
     {OUT(POSE, 1), IN(SOLVER, 1, &ok.solver_done)}},
    {F(paper_solve), 0, ARGS | S(RANGE) | S(TOO_FEW) | S(WIDE_RAY) | POSES,
     {OUT(POSE, 1), IN(BEARING, N, ok.bearings),
      COUNT(&SIZE_6, 3, RIGCAL_ERR_TOO_FEW), IN(PAIR, N_PAIRS, ok.pairs),
      PAIRS(&SIZE_15, 3, RIGCAL_ERR_TOO_FEW), IN_OPT(OPTIONS, 1, &ok.options)}},

    {F(pose_defaults), 0, S(NULL), {OUT(WARM, 1)}},
    {F(pose_begin), 0, VIEWED,
     {OUT_PART(POSE_SOLVER, 1), OUT_BAD, VIEW_OF_N(3), IN_OPT(WARM, 1, &ok.warm)}},
    {F(pose_step), RIGCAL_RUNNING,
     S(NULL) | S(RANGE) | S(STATE) | BIT(RIGCAL_RUNNING),
     {STATE(POSE_SOLVER, &ok.pose_solver),
      CHOICE(&INT_8, 1, 0, RIGCAL_ERR_RANGE)}},
    {F(pose_result), 0, S(NULL) | S(RANGE) | S(STATE) | FITTED,
     {OUT_PART(ML_POSE, RIGCAL_POSES_MAX), ROOM(&SIZE_4, 1, RIGCAL_ERR_RANGE),
      OUT(SIZE, 1), OUT_BAD, IN(POSE_SOLVER, 1, &ok.pose_solver_done)}},
    {F(pose_solve), 0, VIEWED | FITTED,
     {OUT_PART(ML_POSE, RIGCAL_POSES_MAX), ROOM(&SIZE_4, 1, RIGCAL_ERR_RANGE),
      OUT(SIZE, 1), OUT_BAD, VIEW_OF_N(3), IN_OPT(COLD, 1, &ok.cold)}},
    {F(tag_solve), 0, (VIEWED & ~S(TOO_FEW)) | FITTED | S(MIRRORED),
     {OUT_PART(ML_POSE, RIGCAL_POSES_MAX), ROOM(&SIZE_4, 1, RIGCAL_ERR_RANGE),
      OUT(SIZE, 1), OUT_BAD, IN(CAMERA, 1, &ok.camera),
      IN(VEC2, 4, ok.uv_corners), VALUE(POSITIVE, &REAL_BASELINE),
      IN_OPT(COLD, 1, &ok.cold)}},
    {F(pose_covariance), 0,
     DEVICE | S(ROTATION) | S(TOO_FEW) | S(BEHIND) | S(NO_RAY) | S(DEGENERATE),
     {OUT(UNCERTAINTY, 1), VIEW_OF_N(3), IN(TRANSFORM, 1, &ok.cams_from_world[0]),
      VALUE(TOLERANCE, &REAL_SIGMA)}},

    {F(robust_defaults), 0, S(NULL), {OUT_PART(ROBUST, 1)}},
    {F(robust_begin), 0, VIEWED,
     {OUT_PART(ROBUST_SOLVER, 1), WORK(BYTES, N), OUT_BAD, VIEW_OF_N(5),
      IN_OPT(ROBUST, 1, &ok.robust)}},
    {F(robust_step), RIGCAL_RUNNING,
     S(NULL) | S(RANGE) | S(STATE) | BIT(RIGCAL_RUNNING),
     {STATE(ROBUST_SOLVER, &ok.robust_solver),
      CHOICE(&INT_8, 1, 0, RIGCAL_ERR_RANGE)}},
    {F(robust_result), RIGCAL_OK, S(STATE) | AGREED,
     {OUT_PART(ML_POSE, RIGCAL_POSES_MAX), ROOM(&SIZE_4, 1, RIGCAL_ERR_RANGE),
      OUT(SIZE, 1), OUT(SIZE, 1), IN(ROBUST_SOLVER, 1, &ok.robust_solver_done)}},
    {F(robust_solve), RIGCAL_OK, AGREED,
     {OUT_PART(ML_POSE, RIGCAL_POSES_MAX), ROOM(&SIZE_4, 1, RIGCAL_ERR_RANGE),
      OUT(SIZE, 1), WORK(BYTES, N), OUT(SIZE, 1), OUT_BAD, VIEW_OF_N(5),
      IN_OPT(ROBUST, 1, &ok.robust)}},

    {F(pose_blame), 0, VIEWED,
     {OUT_PART(BLAME, 1), OUT_OPT(NUMBER, N), VIEW_OF_N(5),
      IN_OPT(COLD, 1, &ok.cold)}},
    {F(pose_diagnose), 0, VIEWED,
     {OUT_PART(DIAGNOSIS, 1), OUT_OPT(NUMBER, N), VIEW_OF_N(5),
      IN_OPT(WARM, 1, &ok.warm)}},

    {F(depth_two_views), 0, ROTATED | S(RANGE) | S(PARALLEL) | S(BEHIND),
     {OUT(VEC2, 1), OUT(NUMBER, 1), IN(TRANSFORM, 1, &ok.b_from_a),
      IN(RAY, 1, ok.ray_a), IN(RAY, 1, ok.ray_b)}},
    {F(depth_aligned), 0, ARGS | S(RANGE) | S(PARALLEL) | S(BEHIND),
     {OUT(VEC3, 1), VALUE(POSITIVE, &REAL_BASELINE), IN(VEC2, 1, ok.xy),
      IN(VEC2, 1, ok.xy_right)}},
    {F(point_triangulate), 0,
     DEVICE | S(ROTATION) | S(RANGE) | S(TOO_FEW) | S(NO_RAY) | S(PARALLEL) |
         S(BEHIND),
     {OUT(POINT, 1), IN(CAMERA, 2, ok.cameras),
      IN(TRANSFORM, 2, ok.cams_from_world), IN(VEC2, 2, ok.uv_views),
      COUNT(&SIZE_2, 2, RIGCAL_ERR_TOO_FEW), VALUE(POSITIVE, &REAL_SIGMA)}},
    {F(epiline), 0, ROTATED | S(RANGE) | S(EPIPOLE),
     {OUT(VEC3, 1), IN(TRANSFORM, 1, &ok.b_from_a), IN(RAY, 1, ok.ray_a)}},
    {F(epiline_px), 0, ROTATED | S(CAMERA) | S(RANGE) | S(EPIPOLE),
     {OUT(VEC3, 1), IN(CAMERA, 1, &ok.camera), IN(TRANSFORM, 1, &ok.b_from_a),
      IN(RAY, 1, ok.ray_a)}},
    {F(epiline_distance), 0, DEVICE | S(NO_RAY) | S(WIDE_RAY) | S(RANGE),
     {OUT(NUMBER, 1), IN(LINE, 1, ok.line), IN(CAMERA, 1, &ok.camera),
      IN(VEC2, 1, ok.uv)}},
    {F(epiline_clip), 0, ARGS | S(RANGE) | S(OUTSIDE),
     {OUT(VEC4, 1), IN(LINE, 1, ok.line),
      CHOICE(&INT_640, 1, 0, RIGCAL_ERR_RANGE),
      CHOICE(&INT_480, 1, 0, RIGCAL_ERR_RANGE)}},
    {F(epiline_segment), 0, ROTATED | S(CAMERA) | S(RANGE) | S(WIDE_RAY),
     {OUT(VEC4, 1), IN(CAMERA, 1, &ok.camera), IN(TRANSFORM, 1, &ok.b_from_a),
      IN(RAY, 1, ok.ray_a), VALUE(POSITIVE, &REAL_NEAR),
      VALUE(POSITIVE, &REAL_FAR)}},
    {F(epiline_curve), 0, ROTATED | S(CAMERA) | S(RANGE) | S(OUTSIDE),
     {OUT_PART(VEC2, 8), COUNT(&SIZE_8, 2, RIGCAL_ERR_RANGE), OUT(SIZE, 1),
      IN(CAMERA, 1, &ok.camera), IN(TRANSFORM, 1, &ok.b_from_a),
      IN(RAY, 1, ok.ray_a), VALUE(POSITIVE, &REAL_NEAR),
      VALUE(POSITIVE, &REAL_FAR)}},

    {F(transform_mean), 0, ROTATED | S(RANGE) | S(TOO_FEW),
     {OUT(TRANSFORM, 1), OUT_OPT(NUMBER, 1), OUT_OPT(NUMBER, 1),
      IN(TRANSFORM, N_VIEWS, ok.estimates), IN_OPT(WEIGHT, N_VIEWS, ok.weights),
      COUNT(&SIZE_6, 1, RIGCAL_ERR_TOO_FEW)}},
    {F(view_pose_make), 0,
     DEVICE | S(ROTATION) | S(TOO_FEW) | S(BEHIND) | S(NO_RAY) | S(DEGENERATE),
     {OUT(MADE_POSE, 1), IN(VIEW_TO_MAKE, 1, ok.rig_views), IN(TRANSFORM, 1, &ok.view_poses[0].cam_from_target)}},
    {F(rig_join), 0, JOINED,
     {RIG_OF(WORK(TRANSFORM, N_CAMERAS), WORK(TRANSFORM, N_PLACEMENTS), WORK(INT32, N_CAMERAS), WORK(NUMBER, RIG_WORK)),
      IN(VIEW_POSE, N_VIEWS, ok.view_poses), OUT_BAD}},
    {F(rig_join_begin), 0, JOINED,
     {RIG_OF(WORK(TRANSFORM, N_CAMERAS), WORK(TRANSFORM, N_PLACEMENTS), WORK(INT32, N_CAMERAS), WORK(NUMBER, RIG_WORK)),
      IN(THERE, 1, &INT_1), OUT_PART(RIG_SOLVER, 1)}},
    {F(rig_join_step), RIGCAL_RUNNING,
     S(NULL) | S(RANGE) | S(STATE) | BIT(RIGCAL_RUNNING),
     {STATE(RIG_SOLVER, &ok.join_begun), CHOICE(&INT_2, 1, 0, RIGCAL_ERR_RANGE)}},
    {F(rig_adjust), 0, ADJUSTED,
     {RIG_OF(IN(TRANSFORM, N_CAMERAS, ok.poses), IN(TRANSFORM, N_PLACEMENTS, ok.placements), WORK(INT32, N_CAMERAS), WORK(NUMBER, RIG_WORK)),
      IN(RIG_VIEW, N_VIEWS, ok.rig_views), OUT(FIT, 1), OUT_BAD}},
    {F(rig_begin), 0, ADJUSTED,
     {RIG_OF(IN(TRANSFORM, N_CAMERAS, ok.poses), WORK(TRANSFORM, N_PLACEMENTS), WORK(INT32, N_CAMERAS), WORK(NUMBER, RIG_WORK)),
      IN(THERE, 1, &INT_1), OUT_PART(RIG_SOLVER, 1)}},
    {F(rig_step), RIGCAL_RUNNING,
     S(NULL) | S(RANGE) | S(STATE) | BIT(RIGCAL_RUNNING),
     {STATE(RIG_SOLVER, &ok.rig_begun), CHOICE(&INT_2, 1, 0, RIGCAL_ERR_RANGE)}},
    {F(rig_result), 0, S(STATE) | ADJUSTED,
     {OUT(FIT, 1), OUT_BAD, IN(RIG_SOLVER, 1, &ok.rig_done)}},
    {F(rig_adjust_robust), 0, ADJUSTED,
     {RIG_OF(IN(TRANSFORM, N_CAMERAS, ok.poses), IN(TRANSFORM, N_PLACEMENTS, ok.placements), WORK(INT32, N_CAMERAS), WORK(NUMBER, RIG_WORK)),
      VALUE(POSITIVE, &REAL_SIGMA), OUT(FIT, 1), OUT(SIZE, 1), OUT_BAD}},
    {F(rig_robust_begin), 0, ADJUSTED,
     {RIG_OF(IN(TRANSFORM, N_CAMERAS, ok.poses), WORK(TRANSFORM, N_PLACEMENTS), WORK(INT32, N_CAMERAS), WORK(NUMBER, RIG_WORK)),
      VALUE(POSITIVE, &REAL_SIGMA), CHOICE(&INT_2, 1, 2, RIGCAL_ERR_RANGE), OUT_PART(RIG_SOLVER, 1)}},
    {F(rig_robust_result), 0, S(STATE) | ADJUSTED,
     {OUT(FIT, 1), OUT(SIZE, 1), OUT_BAD, IN(RIG_SOLVER, 1, &ok.rig_done)}},
    {F(rig_covariance), 0, S(STATE) | S(TOO_FEW) | ARGS,
     {RIG_DONE, OUT(MAT6, 1), VALUE(TOLERANCE, &REAL_SIGMA),
      LESS(&SIZE_2, N_CAMERAS)}},
    {F(rig_pair), 0, S(STATE) | S(TOO_FEW) | ARGS | BIT(RIGCAL_DISCONNECTED),
     {RIG_DONE, OUT(TRANSFORM, 1), VALUE(TOLERANCE, &REAL_SIGMA),
      LESS(&SIZE_0, N_CAMERAS), OUT(MAT6, 1), LESS(&SIZE_2, N_CAMERAS)}},
    {F(rig_placement), 0, S(STATE) | S(TOO_FEW) | ARGS | S(DEGENERATE),
     {RIG_DONE, OUT(MAT6, 1), VALUE(TOLERANCE, &REAL_SIGMA),
      LESS(&SIZE_1, N_PLACEMENTS)}},
    {F(rig_noise), 0, S(STATE) | S(TOO_FEW) | ARGS | S(DEGENERATE),
     {RIG_DONE, OUT(NUMBER, 3), OUT(NUMBER, 3)}},
    {F(rig_links), 0, JOINED,
     {RIG_OF(WORK(TRANSFORM, N_CAMERAS), WORK(TRANSFORM, N_PLACEMENTS), WORK(INT32, N_CAMERAS), WORK(NUMBER, RIG_WORK)),
      IN(VIEW_POSE, N_VIEWS, ok.view_poses), OUT(LINK, 3), ROOM(&SIZE_3, 3, RIGCAL_ERR_CAPACITY), OUT(INT32, 1), OUT_BAD}},
    {F(priors_information), 0, ARGS | S(TOO_FEW) | S(DEGENERATE),
     {WORK(NUMBER, 21), IN(KEPT_SIGMA, 1, ok.kept_Sigma),
      {R_COUNT, &SIZE, 1, &SIZE_1, 1, RIGCAL_STORE_FREE_MAX, RIGCAL_ERR_TOO_FEW}}},
    {F(rig_advise), 0, ARGS | S(CAPACITY) | S(TOO_FEW),
     {RIG_WITH_MEMORY(RIG_UNREAD), OUT_PART(ADVICE, 3), ROOM(&SIZE_3, 0, 0), OUT(SIZE, 1), IN(LINK, 3, ok.links)}},
    {F(rig_weakest), 0, S(STATE) | S(TOO_FEW) | ARGS,
     {RIG_DONE, OUT(WEAKEST, 1), VALUE(TOLERANCE, &REAL_SIGMA)}},
    {F(rig_choose), 0, JOINED | S(CONTRADICTION),
     {RIG_TO_CHOOSE, IN(VIEW_POSE, N_VIEWS, ok.view_poses), IN(THERE, 1, &INT_1),
      IN_OPT(SECOND_POSE, N_VIEWS, ok.view_poses), WORK(BYTES, N_VIEWS), OUT_BAD}},
    {F(choose_begin), 0, JOINED,
     {RIG_TO_CHOOSE, IN(THERE, 1, &INT_1), IN(THERE, 1, &INT_1),
      IN_OPT(THERE, 1, &INT_1), WORK(BYTES, N_VIEWS), OUT_PART(CHOOSE_SOLVER, 1)}},
    {F(choose_step), RIGCAL_RUNNING,
     S(NULL) | S(RANGE) | S(STATE) | BIT(RIGCAL_RUNNING),
     {STATE(CHOOSE_SOLVER, &ok.choose_begun), CHOICE(&INT_2, 1, 0, RIGCAL_ERR_RANGE)}},
    {F(choose_result), 0, S(STATE) | JOINED | S(CONTRADICTION),
     {OUT_BAD, IN(CHOOSE_SOLVER, 1, &ok.choose_done)}},
    {F(rig_judge), 0, ADJUSTED | BIT(RIGCAL_VIEWS_LEFT_OUT),
     {RIG_TO_JUDGE(IN(TRANSFORM, N_PLACEMENTS, ok.placements)), IN(RIG_VIEW, N_VIEWS, ok.rig_views), IN(VIEW_POSE, N_VIEWS, ok.view_poses),
      JUDGE_CHOICE(IN_OPT(SECOND_POSE, N_VIEWS, ok.view_poses)),
      WORK(JUDGED, N_VIEWS), WORK(BYTES, N_VIEWS), OUT(JUDGEMENT, 1), OUT_BAD}},
    {F(judge_begin), 0, ADJUSTED,
     {RIG_TO_JUDGE(WORK(TRANSFORM, N_PLACEMENTS)), IN(THERE, 1, &INT_1), IN(THERE, 1, &INT_1), JUDGE_CHOICE(IN_OPT(THERE, 1, &INT_1)),
      WORK(JUDGED, N_VIEWS), WORK(BYTES, N_VIEWS), OUT_PART(JUDGE_SOLVER, 1)}},
    {F(judge_step), RIGCAL_RUNNING,
     S(NULL) | S(RANGE) | S(STATE) | BIT(RIGCAL_RUNNING),
     {STATE(JUDGE_SOLVER, &ok.judge_begun), CHOICE(&INT_2, 1, 0, RIGCAL_ERR_RANGE)}},
    {F(judge_result), 0, S(STATE) | ADJUSTED | BIT(RIGCAL_VIEWS_LEFT_OUT),
     {OUT(JUDGEMENT, 1), OUT_BAD, IN(JUDGE_SOLVER, 1, &ok.judge_done)}},
    {F(rig_cause), 0, CAUSED,
     {RIG_OF_CAUSE, LESS(&SIZE_4, N_VIEWS), OUT(CAUSE, 1)}},
    {F(camera_cause), 0, CAUSED,
     {RIG_OF_CAUSE, LESS(&SIZE_2, N_CAMERAS), OUT(CAUSE, 1)}},
    {F(cause_begin), 0, CAUSED,
     {RIG_OF_CAUSE, LESS(&SIZE_4, N_VIEWS), OUT_PART(CAUSE_SOLVER, 1)}},
    {F(camera_cause_begin), 0, CAUSED,
     {RIG_OF_CAUSE, LESS(&SIZE_2, N_CAMERAS), OUT_PART(CAUSE_SOLVER, 1)}},
    {F(cause_step), RIGCAL_RUNNING,
     S(NULL) | S(RANGE) | S(STATE) | BIT(RIGCAL_RUNNING),
     {STATE(CAUSE_SOLVER, &ok.cause_begun), CHOICE(&INT_2, 1, 0, RIGCAL_ERR_RANGE)}},
    {F(cause_result), 0, S(STATE) | CAUSED,
     {OUT(CAUSE, 1), IN(CAUSE_SOLVER, 1, &ok.cause_done)}},
    {F(match_k), 0, ARGS,
     {OUT(NUMBER, 1), VALUE(NUMBER, &REAL_SIGMA), CHOICE(&INT_1, 1, 2, RIGCAL_ERR_RANGE)}},
    {F(ray_make), 0, DEVICE | S(NO_RAY),
     {OUT(RAY_OF_PIXEL, 1), IN(CAMERA, 1, &ok.camera), IN(VEC2, 1, ok.uv)}},
    {F(band_make), 0, DEVICE | S(ROTATION) | S(NO_RAY) | S(EPIPOLE),
     {PAIR_OF, OUT(BAND, 1), IN(VEC2, 1, ok.uv)}},
    {F(band_make_ray), 0, DEVICE | S(ROTATION) | S(EPIPOLE),
     {PAIR_OF, OUT(BAND, 1), IN(RAY_OF_PIXEL, 1, &ok.ray)}},
    {F(band_curve), 0, DEVICE | S(OUTSIDE),
     {OUT_PART(BAND_POINT, 8), COUNT(&SIZE_8, 2, RIGCAL_ERR_RANGE), OUT(SIZE, 1),
      IN(BAND, 1, &ok.band)}},
    {F(band_test), 0, DEVICE | MET,
     {OUT(MATCH, 1), IN(BAND, 1, &ok.band), IN(VEC2, 1, ok.uv_b)}},
    {F(band_test_ray), 0, DEVICE | MET,
     {OUT(MATCH, 1), IN(BAND, 1, &ok.band), IN(RAY_OF_PIXEL, 1, &ok.rays[0])}},
    {F(band_search), 0, DEVICE,
     {OUT_PART(MATCH, 2), COUNT(&SIZE_2, 0, 0), OUT(SIZE, 1), OUT(SIZE, 1), OUT_BAD,
      IN(BAND, 1, &ok.band), IN(VEC2, 2, ok.uv_candidates), COUNT(&SIZE_2, 0, 0)}},
    {F(band_search_rays), 0, DEVICE,
     {OUT_PART(MATCH, 2), COUNT(&SIZE_2, 0, 0), OUT(SIZE, 1), OUT(SIZE, 1), OUT_BAD,
      IN(BAND, 1, &ok.band), IN(RAY_OF_PIXEL, 2, ok.rays), COUNT(&SIZE_2, 0, 0)}},
    {F(spans_find), 0, DEVICE | S(CAPACITY) | S(OUTSIDE) | S(DEGENERATE),
     {OUT_PART(SPAN, 4000), ROOM(&SIZE_SPANS, 1, RIGCAL_ERR_CAPACITY), OUT(SIZE, 1),
      WORK(SPANS_SOLVER, 1), IN(BAND, 1, &ok.band)}},
    {F(spans_begin), 0, DEVICE, {WORK(SPANS_SOLVER, 1), IN(BAND, 1, &ok.band)}},
    {F(spans_step), RIGCAL_RUNNING,
     S(NULL) | S(RANGE) | S(STATE) | S(DEGENERATE) | BIT(RIGCAL_RUNNING),
     {STATE(SPANS_SOLVER, &ok.spans_begun), CHOICE(&INT_2, 1, 0, RIGCAL_ERR_RANGE)}},
    {F(spans_row), 0, S(NULL) | S(RANGE) | S(STATE),
     {OUT_PART(SPAN, RIGCAL_SPANS_ROW), OUT(SIZE, 1), STATE(SPANS_SOLVER, &ok.spans_done),
      CHOICE(&INT_3, 0, 479, RIGCAL_ERR_RANGE)}},
    {F(spans_result), 0, S(NULL) | S(STATE) | S(CAPACITY) | S(OUTSIDE),
     {OUT_PART(SPAN, 4000), ROOM(&SIZE_SPANS, 1, RIGCAL_ERR_CAPACITY), OUT(SIZE, 1),
      STATE(SPANS_SOLVER, &ok.spans_done)}},
    {F(transfer_make), 0,
     VIEWED | S(CAPACITY) | S(STATE) | S(PARALLEL) | S(BEHIND) | S(DEGENERATE) | BIT(RIGCAL_DISCONNECTED),
     {OUT(TRANSFER, 1), IN(THERE, 1, &INT_1), IN(THREE_SIZES, 1, ok.abc),
      IN(VEC2, 1, ok.uv_three), IN(VEC2, 1, ok.uv_three + 2), IN(POSITIVE, 2, ok.pair_numbers)}},
    {F(transfer_test), 0, ARGS | S(DEGENERATE),
     {OUT(NUMBER, 1), IN(TRANSFER_IN, 1, &ok.transfer), VALUE(TOLERANCE, &REAL_SIGMA),
      IN(VEC2, 1, ok.uv_three + 4)}},
    {F(rectify), 0, DEVICE | S(ROTATION) | S(PARALLEL) | S(EPIPOLE) | S(NO_RAY) | S(WIDE_RAY),
     {OUT(RECTIFIED, 1), IN(CAMERA, 1, &ok.camera), IN(CAMERA, 1, &ok.camera),
      IN(TRANSFORM, 1, &ok.b_from_a)}},
    {F(rig_consider), 0, S(STATE) | ADJUSTED,
     {RIG_DONE, IN_OPT(DEVIATION, N_CAMERAS, ok.deviations), IN(THERE, 1, &INT_1), WORK(NUMBER, CONSIDER_WORK),
      ROOM(&SIZE_CONSIDER, CONSIDER_WORK, RIGCAL_ERR_CAPACITY), OUT_BAD,
      CHOICE(&INT_0, 0, 0, RIGCAL_ERR_RANGE)}},
    {F(rig_estimate), 0, S(STATE) | ADJUSTED,
     {RIG_DONE, IN_OPT(DEVIATION, N_CAMERAS, ok.deviations), IN(THERE, 1, &INT_1), WORK(NUMBER, ESTIMATE_WORK),
      ROOM(&SIZE_ESTIMATE, ESTIMATE_WORK, RIGCAL_ERR_CAPACITY), IN(MADE, N_CAMERAS, ok.changes),
      OUT(CHANGE, N_CAMERAS), OUT(CHANGE, N_CAMERAS), OUT_BAD, VALUE(SPREAD, &REAL_SIGMA),
      CHOICE(&INT_0, 0, 0, RIGCAL_ERR_RANGE)}},
    {F(camera_change), 0, DEVICE,
     {OUT(CAMERA, 1), IN(CAMERA, 1, &ok.camera), IN(CHANGE, 1, ok.changes)}},
    {F(considered_fit), 0, ARGS,
     {OUT(FIT, 1), IN(FIT, 1, &ok.fit), IN(THERE, 1, &INT_1)}},
    {F(consider_begin), 0, S(STATE) | S(TOO_FEW) | S(CAPACITY) | ARGS,
     {RIG_DONE, IN_OPT(DEVIATION, N_CAMERAS, ok.deviations), IN(THERE, 1, &INT_1), WORK(NUMBER, CONSIDER_WORK),
      ROOM(&SIZE_CONSIDER, CONSIDER_WORK, RIGCAL_ERR_CAPACITY), OUT_PART(CONSIDER_SOLVER, 1),
      CHOICE(&INT_0, 0, 0, RIGCAL_ERR_RANGE)}},
    {F(consider_step), RIGCAL_RUNNING,
     S(NULL) | S(RANGE) | S(STATE) | BIT(RIGCAL_RUNNING),
     {STATE(CONSIDER_SOLVER, &ok.consider_begun), CHOICE(&INT_2, 1, 0, RIGCAL_ERR_RANGE)}},
    {F(consider_result), 0, S(STATE) | ADJUSTED,
     {OUT_BAD, IN(CONSIDER_SOLVER, 1, &ok.consider_done)}},
    {F(clocks_defaults), 0, S(NULL), {OUT_PART(CLOCKS, 1)}},
    {F(clocks_sigma), 0, S(STATE) | S(TOO_FEW) | ARGS,
     {IN(THERE, 1, &INT_1), STATE(RIG_CAMS, ok.clock_poses), COUNT(&SIZE_3, 1, RIGCAL_ERR_TOO_FEW),
      STATE(RIG_PLACEMENTS, ok.clock_placements), STATE(RIG_GROUPS, ok.clock_groups),
      COUNT(&SIZE_6, 1, RIGCAL_ERR_TOO_FEW), STATE(CLOCK_MEMORY, ok.clock_work), ROOM(&SIZE_CLOCKS, 0, 0),
      IN(THERE, 1, &INT_1), OUT(NUMBER, N_CAMERAS), OUT_OPT(NUMBER, N_CAMERAS), VALUE(TOLERANCE, &REAL_SIGMA)}},
    {F(clocks_frames), 0, ARGS,
     {OUT(INT32, N_CAMERAS), IN(THERE, 1, &INT_1), IN(NUMBER, N_CAMERAS, ok.offsets),
      VALUE(POSITIVE, &REAL_SIGMA), COUNT(&SIZE_3, 0, RIGCAL_ERR_RANGE)}},
    {F(rig_faults), 0, S(STATE) | ADJUSTED,
     {RIG_DONE, OUT(FAULTS, 1), FAULTS_BY(WORK(FAULT, N_FAULTS), OUT_BAD)}},
    {F(faults_begin), 0, S(STATE) | ADJUSTED,
     {RIG_DONE, OUT_PART(FAULTS_SOLVER, 1), FAULTS_BY(OUT_PART(FAULT, N_FAULTS), OUT_OPT(THERE, 1))}},
    {F(faults_step), RIGCAL_RUNNING,
     S(NULL) | S(RANGE) | S(STATE) | BIT(RIGCAL_RUNNING),
     {STATE(FAULTS_SOLVER, &ok.faults_begun), CHOICE(&INT_2, 1, 0, RIGCAL_ERR_RANGE)}},
    {F(faults_result), 0, S(STATE) | ADJUSTED,
     {OUT(FAULTS, 1), OUT_BAD, IN(FAULTS_SOLVER, 1, &ok.faults_done)}},
    {F(faults_text), 0, ARGS | S(CAPACITY),
     {STATE(TEXT, ok.text), ROOM(&SIZE_TEXT, 4, RIGCAL_ERR_CAPACITY), {R_UNREAD, &SIZE, 1, &SIZE_0, 0, 0, 0},
      IN(FAULTS, 1, &ok.told), IN_OPT(NUMBER, 2 * N_CAMERAS, ok.told_clocks), IN(FAULT, N_FAULTS, ok.told_faults),
      IN(THERE, 1, &INT_1), VALUE(NUMBER, &REAL_SIGMA), VALUE(NUMBER, &REAL_SIGMA)}},
    {F(rig_residuals), 0, S(TOO_FEW) | S(CAPACITY) | ARGS,
     {RIG_WITH_MEMORY(RIG_UNREAD), OUT(NUMBER, 12), ROOM(&SIZE_12, 12, RIGCAL_ERR_CAPACITY), OUT(SIZE, 1),
      LESS(&SIZE_4, N_VIEWS)}},
    {F(point_bound), 0, ROTATED,
     {OUT(NUMBER, 1), IN(TRANSFORM, 1, &ok.b_from_a),
      IN(TRANSFORM, 1, &ok.a_from_b), IN(VEC3, 1, ok.X)}},

    {F(store_save), 0, DEVICE | S(ROTATION) | S(TOO_FEW) | S(CAPACITY),
     {OUT(SAVED, 1), ROOM(&SIZE_SAVED, RIGCAL_STORE_SIZE(2), RIGCAL_ERR_CAPACITY),
      OUT(SIZE, 1), IN(MOUNTED, 2, ok.mounted), CAMERAS(&SIZE_2),
      ANY_INTEGER(&UINT_7), ANY_INTEGER(&UINT_7)}},
    {F(store_info), 0, STORED,
     {OUT(SAVED_INFO, 1), IN(SAVED, 1, ok.saved),
      ROOM(&SIZE_SAVED, RIGCAL_STORE_SIZE(2), RIGCAL_ERR_DAMAGED)}},
    {F(store_load), 0, STORED | DEVICE | S(ROTATION) | S(CAPACITY),
     {OUT(MOUNTED, 2), ROOM(&SIZE_2, 2, RIGCAL_ERR_CAPACITY), OUT(SAVED_INFO, 1),
      IN(SAVED, 1, ok.saved),
      ROOM(&SIZE_SAVED, RIGCAL_STORE_SIZE(2), RIGCAL_ERR_DAMAGED)}},
    {F(point_measure), 0, MEASURING,
     {SIGHTINGS_OF(KEPT_CAMERA, KEPT_SIGMA, SIGHTING, SPREAD), OUT(MEASURED, 1),
      OUT_OPT(BYTES, 2)}},
    {F(point_begin), 0, MEASURING, 
     {SIGHTINGS_OF(KEPT_UNREAD, SIGMA_UNREAD, SIGHTING_UNREAD, NOISE_UNREAD),
      STATE(POINT_UNREAD, &ok.point_begun)}},
    {F(point_step), RIGCAL_RUNNING, MEASURING | S(STATE) | BIT(RIGCAL_RUNNING),
     {STATE(POINT_SOLVER, &ok.point_begun), CHOICE(&INT_2, 1, 0, RIGCAL_ERR_RANGE)}},
    {F(point_result), 0, MEASURING | S(STATE) | S(CAPACITY),
     {OUT(MEASURED, 1), OUT_OPT(BYTES, 2), IN(POINT_SOLVER, 1, &ok.point_done)}},
    {F(point_distance), 0,
     S(TOO_FEW) | S(CAPACITY) | ARGS | S(COINCIDENT) | BIT(RIGCAL_DISCONNECTED),
     {IN(THERE, 1, &INT_1), IN(KEPT_UNREAD, 2, ok.mounted),
      IN(KEPT_GROUPS, 1, ok.kept_group), IN(KEPT_HELD, 1, ok.kept_held),
      ROOM(&SIZE_2, 2, RIGCAL_ERR_CAPACITY), IN(KEPT_SIGMA, 1, ok.kept_Sigma),
      ROOM(&SIZE_KEPT, RIGCAL_CALIBRATED_SIZE(1), RIGCAL_ERR_CAPACITY), CAMERAS(&SIZE_2),
      IN(KEPT_OR_EXACT, 1, ok.kept_numbers), OUT(NUMBER, 1), OUT_OPT(NUMBER, 1),
      IN(END, 1, &ok.measured), IN(END, 1, &ok.other)}},
    {F(calibrated_take), 0, S(STATE) | S(TOO_FEW) | S(CAPACITY) | ARGS,
     {KEPT_OUT(3, RIGCAL_CALIBRATED_SIZE(2), SIZE_TAKEN), RIG_DONE,
      {R_UNREAD, &FIT, 1, &ok.fit, 0, 0, 0}, VALUE(SPREAD, &REAL_SIGMA)}},
    {F(calibrated_covariance), 0, S(STATE) | S(TOO_FEW) | S(CAPACITY) | ARGS,
     {KEPT_OF(KEPT_UNREAD, KEPT_SIGMA), OUT(MAT6, 1), LESS(&SIZE_1, 2), LESS(&SIZE_1, 2)}},
    {F(calibrated_pair), 0,
     S(STATE) | S(TOO_FEW) | S(CAPACITY) | ROTATED | BIT(RIGCAL_DISCONNECTED),
     {KEPT_OF(KEPT_POSE, KEPT_SIGMA), OUT(TRANSFORM, 1), OUT(MAT6, 1), LESS(&SIZE_0, 2),
      LESS(&SIZE_1, 2)}},
    {F(monitor_defaults), 0, S(NULL), {OUT(WATCHING, 1)}},
    {F(monitor_begin), 0,
     DEVICE | S(ROTATION) | S(CAPACITY) | S(TOO_FEW) | S(STATE) | S(DEGENERATE) |
         BIT(RIGCAL_DISCONNECTED),
     {KEPT_OF(KEPT_CAMERA, KEPT_JOINT), OUT(MONITOR, 1),
      ROOM(&SIZE_MONITOR, MONITOR_SIZE, RIGCAL_ERR_CAPACITY),
      {R_COUNT, &SIZE, 1, &SIZE_1, 0, RIGCAL_MONITOR_TARGETS_MAX, RIGCAL_ERR_RANGE},
      IN_OPT(WATCHING, 1, &ok.watching)}},
    {F(monitor_match), 0, ARGS | S(RANGE) | S(STATE) | S(NO_RAY) | S(BEHIND) | S(DEGENERATE),
     {STATE(MONITOR, ok.monitor), LESS(&SIZE_0, 2), IN(VEC2, 1, ok.uv), LESS(&SIZE_1, 2),
      IN(VEC2, 1, ok.uv), VALUE(POSITIVE, &REAL_SIGMA)}},
    {F(monitor_match_rays), 0,
     ARGS | S(RANGE) | S(STATE) | S(NO_RAY) | S(BEHIND) | S(DEGENERATE),
     {STATE(MONITOR, ok.monitor), LESS(&SIZE_0, 2), IN(RAY, 1, ok.ray_a), LESS(&SIZE_1, 2),
      IN(RAY, 1, ok.ray_b), VALUE(POSITIVE, &REAL_SIGMA)}},
    {F(monitor_lifted), 0, S(NULL) | S(RANGE) | S(STATE),
     {STATE(MONITOR, ok.monitor), LESS(&SIZE_0, 1)}},
    {F(monitor_frame), 0, ARGS | S(RANGE) | S(STATE),
     {OUT_OPT(REPORT, 1), STATE(MONITOR, ok.monitor), VALUE(TOLERANCE, &REAL_SIGMA)}},
    {F(monitor_ask), 0, S(NULL) | S(STATE), {OUT(REPORT, 1), IN(MONITOR, 1, ok.monitor)}},
    {F(monitor_body), 0, S(NULL) | S(RANGE) | S(STATE),
     {OUT(OF_BODY, 1), IN(MONITOR, 1, ok.monitor), LESS(&SIZE_1, 3)}},
    {F(monitor_moved), 0, S(NULL) | S(RANGE) | S(STATE),
     {STATE(MONITOR, ok.monitor), LESS(&SIZE_1, 2)}},
    {F(monitor_dismiss), 0, S(NULL) | S(STATE), {STATE(MONITOR, ok.alarmed)}},
    {F(monitor_camera), 0, S(NULL) | S(RANGE) | S(STATE),
     {OUT_PART(MOUNTED, 1), IN(MONITOR, 1, ok.monitor), LESS(&SIZE_1, 2)}},
    {F(monitor_pair), 0, S(NULL) | S(RANGE) | S(STATE),
     {OUT(TRANSFORM, 1), OUT(MAT6, 1), IN(MONITOR, 1, ok.monitor), LESS(&SIZE_0, 2),
      LESS(&SIZE_1, 2)}},
    {F(monitor_rig), 0, S(NULL) | S(CAPACITY) | S(STATE),
     {KEPT_OUT(2, RIGCAL_CALIBRATED_SIZE(1), SIZE_KEPT), IN(MONITOR, 1, ok.monitor)}},
    {F(monitor_view), 0, VIEWED | FITTED | S(STATE) | S(DEGENERATE),
     {STATE(MONITOR, ok.monitor), OUT_BAD, LESS(&SIZE_0, 2), LESS(&SIZE_0, 1),
      IN(OBSERVATION, N, ok.observations), COUNT(&SIZE_6, 3, RIGCAL_ERR_TOO_FEW),
      VALUE(POSITIVE, &REAL_SIGMA)}},
    {F(store_save_rig), 0, DEVICE | S(ROTATION) | S(TOO_FEW) | S(CAPACITY) | S(STATE),
     {KEPT_OF(KEPT_CAMERA, KEPT_JOINT), OUT(SAVED_RIG, 1),
      ROOM(&SIZE_SAVED_RIG, RIGCAL_STORE_RIG_SIZE(2, 1), RIGCAL_ERR_CAPACITY), OUT(SIZE, 1),
      ANY_INTEGER(&UINT_7), ANY_INTEGER(&UINT_7)}},
    {F(store_load_rig), 0, STORED | DEVICE | S(ROTATION) | S(CAPACITY),
     {KEPT_OUT(2, RIGCAL_CALIBRATED_SIZE(1), SIZE_KEPT), OUT(SAVED_INFO, 1),
      IN(SAVED_RIG, 1, ok.saved_rig),
      ROOM(&SIZE_SAVED_RIG, RIGCAL_STORE_RIG_SIZE(2, 1), RIGCAL_ERR_DAMAGED)}},
};
/* clang-format on */
enum { N_FUNCTIONS = sizeof FUNCTIONS / sizeof FUNCTIONS[0] };

/* Functions that take only plain numbers and have an answer for all of them. */
static const char *const HARMLESS[] = {
    "rigcal_version",        "rigcal_sizeof_real",
    "rigcal_status_name",    "rigcal_status_text",
    "rigcal_layout_count",   "rigcal_pairs_for",
    "rigcal_store_size",     "rigcal_rig_work",
    "rigcal_choose_work",    "rigcal_judge_work",
    "rigcal_store_rig_size", "rigcal_calibrated_size",
    "rigcal_consider_work",  "rigcal_consider_clocks_work",
    "rigcal_point_work",     "rigcal_monitor_size",
    "rigcal_clocks_work",    "rigcal_estimate_work",
    "rigcal_faults_work",    "rigcal_faults_least",
};
enum { N_HARMLESS = sizeof HARMLESS / sizeof HARMLESS[0] };

/* ---- one call ------------------------------------------------------------ */

/* The function under test, its buffers, and what is being changed. */
static const function *current;
static unsigned char *buffer[MAX_ARGUMENTS];
static char what[160];
static int failures;

static size_t size_of(const argument *a)
{
    return a->kind->size * a->n;
}

static int is_output(role r)
{
    return r == R_OUT || r == R_OUT_PART || r == R_OUT_OPT;
}

static int n_arguments(void)
{
    int n = 0;

    while (n < MAX_ARGUMENTS && current->arguments[n].role != NONE) {
        n++;
    }
    return n;
}

static void complain(const char *text, rigcal_status status)
{
    char message[320];

    failures++;
    if (failures <= 8) {
        snprintf(message, sizeof message, "%s: %s (%s)", what, text,
                 rigcal_status_name(status));
        TEST_MESSAGE(message);
    }
}

/* Fills outputs with a byte, and sets inputs to valid values. */
static void refresh(int byte)
{
    for (int i = 0; i < n_arguments(); i++) {
        const argument *a = &current->arguments[i];

        if (a->valid) {
            memcpy(buffer[i], a->valid, size_of(a));
        } else {
            memset(buffer[i], byte, size_of(a));
        }
    }
}

static double real_at(const unsigned char *bytes)
{
    rigcal_real x;

    memcpy(&x, bytes, sizeof x);
    return D(x);
}

static void put_real(unsigned char *bytes, double value)
{
    const rigcal_real x = RC(value);

    memcpy(bytes, &x, sizeof x);
}

/* The address of number `k` of an argument. */
static unsigned char *real_of(int i, size_t k)
{
    const kind *type = current->arguments[i].kind;

    return buffer[i] + k / type->n_reals * type->size + type->first_real +
           k % type->n_reals * sizeof(rigcal_real);
}

static size_t n_reals(int i)
{
    return current->arguments[i].n * current->arguments[i].kind->n_reals;
}

static void expect_untouched(int i, int byte, rigcal_status status)
{
    const argument *a = &current->arguments[i];

    for (size_t k = 0; k < size_of(a); k++) {
        const unsigned char before =
            a->valid ? ((const unsigned char *)a->valid)[k] : (unsigned char)byte;

        if (buffer[i][k] != before) {
            complain(a->valid ? "the state was changed though it was refused"
                              : "an output was written though it failed",
                     status);
            return;
        }
    }
}

static void expect_index(int i, rigcal_status status)
{
    int32_t index;

    memcpy(&index, buffer[i], sizeof index);
    if (index < -1 || index >= N) {
        complain("the observation at fault is none, or not written", status);
    }
}

static void expect_finite(int i, rigcal_status status)
{
    for (size_t k = 0; k < n_reals(i); k++) {
        if (!isfinite(real_at(real_of(i, k)))) {
            complain("an output is not finite, or not written", status);
            return;
        }
    }
}

/* Makes the call, with argument `absent` NULL (-1: none), and checks what is always
 * promised. */
static rigcal_status call(int absent, int byte)
{
    void *p[MAX_ARGUMENTS];
    rigcal_status status;

    for (int i = 0; i < MAX_ARGUMENTS; i++) {
        p[i] = i == absent ? NULL : buffer[i];
    }
    status = current->call(p);
    if (status != RIGCAL_OK &&
        (status < RIGCAL_ERR_MIRRORED || status > RIGCAL_MOST_DISAGREE ||
         !(current->named & BIT(status)))) {
        complain("a status that the manual does not name here", status);
    }
    for (int i = 0; i < n_arguments(); i++) {
        const role r = current->arguments[i].role;

        if (i == absent) {
            continue;
        }
        if (status < 0 && is_output(r)) {
            expect_untouched(i, byte, status);
        } else if (status >= 0 && is_output(r) && (r != R_OUT_PART || byte != 0xff)) {
            expect_finite(i, status);
        }
        if (r == R_STATE &&
            (status == RIGCAL_ERR_NULL || status == RIGCAL_ERR_RANGE ||
             status == RIGCAL_ERR_STATE || status == RIGCAL_ERR_NOT_FINITE)) {
            const kind *type = current->arguments[i].kind;

            if (status != type->zeroed) {
                expect_untouched(i, byte, status);
            }
        }
        if (r == R_OUT_BAD) {
            expect_index(i, status);
        }
    }
    return status;
}

enum { FINITE_BYTE = 0x3f, NAN_BYTE = 0xff };

static void expect(rigcal_status expected, int absent)
{
    char text[80];
    const rigcal_status status = call(absent, FINITE_BYTE);

    if (status != expected) {
        snprintf(text, sizeof text, "expected %s", rigcal_status_name(expected));
        complain(text, status);
    }
}

/* ---- what is done to a function ------------------------------------------ */

static void valid_arguments(void)
{
    rigcal_status status;

    snprintf(what, sizeof what, "valid arguments");
    refresh(NAN_BYTE);
    status = call(-1, NAN_BYTE);
    if (status != current->usual) {
        complain("not the usual answer", status);
    }
}

static void null_for_each_pointer(void)
{
    for (int i = 0; i < n_arguments(); i++) {
        const role r = current->arguments[i].role;

        if (r == R_VALUE || r == R_ANY || r == R_COUNT) {
            continue;
        }
        snprintf(what, sizeof what, "argument %d NULL", i);
        refresh(FINITE_BYTE);
        if (r == R_OUT_OPT || r == R_OUT_BAD || r == R_IN_OPT || r == R_UNREAD) {
            expect(current->usual, i);
        } else {
            expect(RIGCAL_ERR_NULL, i);
        }
    }
}

static int has_checked_reals(int i)
{
    const role r = current->arguments[i].role;

    return r == R_IN || r == R_IN_OPT || r == R_UNREAD || r == R_VALUE || r == R_ANY;
}

/* An emulated target tries one in STEP values of each number, and other values of the next
 * number. */
enum { STEP = TEST_ONE_IN > 1 ? 24 : 1 };

static void not_finite_numbers(void)
{
    const double values[] = {test_nan(), test_infinity(), -test_infinity()};

    for (int i = 0; i < n_arguments(); i++) {
        if (!has_checked_reals(i)) {
            continue;
        }
        for (size_t k = 0; k < n_reals(i); k++) {
            for (size_t v = ((size_t)i + k) % STEP % 3; v < 3; v += STEP) {
                snprintf(what, sizeof what, "argument %d, number %u: %g", i, (unsigned)k,
                         values[v]);
                refresh(FINITE_BYTE);
                put_real(real_of(i, k), values[v]);
                if (current->arguments[i].role == R_ANY ||
                    current->arguments[i].role == R_UNREAD) {
                    call(-1, FINITE_BYTE);
                } else {
                    expect(RIGCAL_ERR_NOT_FINITE, -1);
                }
            }
        }
    }
}

/* Changes one number, or all (k = n_reals). */
static void disturb(int i, size_t k, double factor, double value)
{
    const size_t n = n_reals(i);

    for (size_t j = k < n ? k : 0; j < (k < n ? k + 1 : n); j++) {
        put_real(real_of(i, j), factor != 0 ? factor * real_at(real_of(i, j)) : value);
    }
}

static void extreme_numbers(void)
{
    const double least = RIGCAL_USE_FLOAT ? (double)FLT_MIN : DBL_MIN;
    const double most = RIGCAL_USE_FLOAT ? (double)FLT_MAX : DBL_MAX;
    const struct {
        double factor, value;
    } values[] = {
        {-1, 0},
        {0, 0},
        {0, least / 8}, /* denormal */
        {0, -least / 8},
        {0, least},
        {0, TOL(1e-150, 1e-20)}, /* its square is denormal or 0 */
        {0, TOL(-1e-100, -1e-12)},
        {0, TOL(1e100, 1e12)},
        {0, TOL(1e160, 1e20)}, /* its square is infinite */
        {0, TOL(-1e160, -1e20)},
        {0, TOL(1e300, 1e38)},
        {0, TOL(-1e300, -1e38)},
        {0, most},
        {TOL(1e-160, 1e-20), 0},
        {TOL(1e160, 1e20), 0},
    };

    for (int i = 0; i < n_arguments(); i++) {
        if (!has_checked_reals(i) || n_reals(i) == 0) {
            continue;
        }
        for (size_t k = 0; k <= n_reals(i); k++) {
            for (size_t v = ((size_t)i + k) % STEP; v < sizeof values / sizeof values[0];
                 v += STEP) {
                snprintf(what, sizeof what, "argument %d, %s %u: %s%g", i,
                         k < n_reals(i) ? "number" : "all", (unsigned)k,
                         values[v].factor != 0 ? "times " : "",
                         values[v].factor != 0 ? values[v].factor : values[v].value);
                refresh(FINITE_BYTE);
                disturb(i, k, values[v].factor, values[v].value);
                call(-1, FINITE_BYTE);
            }
        }
    }
}

static void put_count(int i, int64_t value)
{
    if (current->arguments[i].kind == &SIZE) {
        const size_t x = (size_t)value;

        memcpy(buffer[i], &x, sizeof x);
    } else {
        const int32_t x = (int32_t)value;

        memcpy(buffer[i], &x, sizeof x);
    }
}

static void counts_and_options(void)
{
    for (int i = 0; i < n_arguments(); i++) {
        const argument *a = &current->arguments[i];
        const int is_size = a->kind == &SIZE;
        int64_t values[16];
        int n = 0;

        if (a->role != R_COUNT) {
            continue;
        }
        for (int64_t v = 0; v < a->low && v < 4; v++) {
            values[n++] = v;
        }
        if (!is_size) {
            values[n++] = a->low - 1;
            values[n++] = -7;
            values[n++] = INT32_MIN;
        }
        if (a->high > 0) {
            values[n++] = a->high + 1;
            values[n++] = INT32_MAX;
        }
        for (int v = 0; v < n; v++) {
            snprintf(what, sizeof what, "argument %d: %.0f", i, (double)values[v]);
            refresh(FINITE_BYTE);
            put_count(i, values[v]);
            if (a->outside == 0) {
                call(-1, FINITE_BYTE);
            } else if (is_size && a->high > 0 && values[v] > a->high) {
                expect(RIGCAL_ERR_RANGE, -1);
            } else {
                expect(a->outside, -1);
            }
        }
    }
}

/* Tries them in the first and in the last element of each input. */
static void impossible_numbers(void)
{
    for (int i = 0; i < n_arguments(); i++) {
        const argument *a = &current->arguments[i];

        if (!a->valid || !a->kind->bad) {
            continue;
        }
        for (const impossible *bad = a->kind->bad; bad->status != 0; bad++) {
            for (size_t e = 0; e<a->n; e += a->n> 1 ? a->n - 1 : 1) {
                unsigned char *place;

                snprintf(what, sizeof what, "argument %d, element %u, offset %u: %g", i,
                         (unsigned)e, (unsigned)bad->offset, bad->value);
                refresh(FINITE_BYTE);
                place = buffer[i] + e * a->kind->size + bad->offset;
                if (bad->is_real) {
                    put_real(place, bad->value);
                } else {
                    const int32_t x = (int32_t)bad->value;

                    memcpy(place, &x, sizeof x);
                }
                expect(bad->status, -1);
            }
        }
    }
}

static void all_bytes_zero(void)
{
    for (int i = 0; i < n_arguments(); i++) {
        const argument *a = &current->arguments[i];

        if (!a->valid || a->kind->zeroed == 0) {
            continue;
        }
        snprintf(what, sizeof what, "argument %d all 0", i);
        refresh(FINITE_BYTE);
        memset(buffer[i], 0, size_of(a));
        expect(a->kind->zeroed, -1);
    }
}

static void withstands_hostile_arguments(void)
{
    char summary[80];

    for (int i = 0; i < n_arguments(); i++) {
        buffer[i] = malloc(size_of(&current->arguments[i]));
        TEST_ASSERT_NOT_NULL(buffer[i]);
    }
    failures = 0;
    valid_arguments();
    null_for_each_pointer();
    not_finite_numbers();
    extreme_numbers();
    counts_and_options();
    impossible_numbers();
    all_bytes_zero();
    for (int i = 0; i < n_arguments(); i++) {
        free(buffer[i]);
        buffer[i] = NULL;
    }
    if (failures > 0) {
        snprintf(summary, sizeof summary, "%d broken promises", failures);
        TEST_FAIL_MESSAGE(summary);
    }
}

/* ---- that no function is missing ----------------------------------------- */

static int is_in_table(const char *name)
{
    int n = 0;

    for (int i = 0; i < N_FUNCTIONS; i++) {
        n += strcmp(FUNCTIONS[i].name, name) == 0;
    }
    for (int i = 0; i < N_HARMLESS; i++) {
        n += strcmp(HARMLESS[i], name) == 0;
    }
    return n;
}

/* The name of the next function that the header declares from *text on: the word before the
 * first parenthesis after RIGCAL_API. */
static int next_function(char name[64], const char **text)
{
    const char *api = strstr(*text, "RIGCAL_API"), *end, *start;

    while (api && !isalpha((unsigned char)api[11])) {
        api = strstr(api + 1, "RIGCAL_API"); /* a comment's */
    }
    if (!api) {
        return 0;
    }
    end = strchr(api, '(');
    TEST_ASSERT_NOT_NULL(end);
    for (start = end; start > api && start[-1] != ' ' && start[-1] != '*';) {
        start--;
    }
    TEST_ASSERT_TRUE(end - start < 64);
    memcpy(name, start, (size_t)(end - start));
    name[end - start] = '\0';
    *text = end;
    return 1;
}

/* The number of functions that a public header declares. Each must be in the table. */
static int functions_of(const char *path)
{
    static char header[100000];
    const char *text = header;
    FILE *const file = fopen(path, "r");
    char name[64];
    size_t length;
    int n = 0;

    TEST_ASSERT_NOT_NULL_MESSAGE(file, path);
    length = fread(header, 1, sizeof header - 1, file);
    fclose(file);
    TEST_ASSERT_TRUE_MESSAGE(length < sizeof header - 1, path);
    header[length] = '\0';
    while (next_function(name, &text)) {
        n++;
        TEST_ASSERT_EQUAL_INT_MESSAGE(1, is_in_table(name), name);
    }
    return n;
}

static void test_every_public_function_of_the_headers_is_in_the_table(void)
{
#define HEADER(name) functions_of(RIGCAL_DATA_DIR "/../../include/" name)
    TEST_ON_HOST_ONLY("it reads the headers");
    TEST_ASSERT_EQUAL_INT(N_FUNCTIONS + N_HARMLESS,
                          HEADER("rigcal.h") + HEADER("rigcal_measure.h") +
                              HEADER("rigcal_rig.h") + HEADER("rigcal_choose.h") +
                              HEADER("rigcal_judge.h") + HEADER("rigcal_clocks.h") +
                              HEADER("rigcal_consider.h") + HEADER("rigcal_point.h") +
                              HEADER("rigcal_match.h") + HEADER("rigcal_monitor.h") +
                              HEADER("rigcal_faults.h") + HEADER("rigcal_solvers.h") +
                              HEADER("rigcal_paper.h"));
}

/* ---- what one line of a table cannot tell -------------------------------- */

static void test_a_solver_still_running_has_no_result(void)
{
    rigcal_paper_pose pose;

    ASSERT_REFUSED(RIGCAL_ERR_STATE, pose, rigcal_paper_result(&pose, &ok.solver));
    {
        rigcal_pose poses[RIGCAL_POSES_MAX];
        size_t n_found = 77;

        ASSERT_REFUSED(
            RIGCAL_ERR_STATE, poses,
            rigcal_pose_result(poses, RIGCAL_POSES_MAX, &n_found, NULL, &ok.pose_solver));
        TEST_ASSERT_EQUAL_UINT64(77, n_found);
    }
}

static void test_three_points_have_no_noise_to_estimate(void)
{
    rigcal_pose_uncertainty out;

    ASSERT_REFUSED(RIGCAL_ERR_TOO_FEW, out,
                   rigcal_pose_covariance(&out, &VIEW(&ok.camera, ok.observations, NULL, 3),
                                          &ok.cams_from_world[0], 0));
    ASSERT_STATUS(RIGCAL_OK,
                  rigcal_pose_covariance(&out, &VIEW(&ok.camera, ok.observations, NULL, 3),
                                         &ok.cams_from_world[0], REAL_SIGMA));
}

static void test_a_search_has_no_result_before_the_first_cost(void)
{
    rigcal_real x[3];

    ASSERT_REFUSED(RIGCAL_ERR_STATE, x,
                   rigcal_neldermead_result(x, NULL, NULL, &ok.search_begun));
}

static void test_only_none_or_two_pairs_eliminate(void)
{
    rigcal_elimination out;

    ASSERT_REFUSED(
        RIGCAL_ERR_RANGE, out,
        rigcal_pairs_eliminate(&out, ok.pairs, N_PAIRS, 1, RIGCAL_YAW, ok.angles));
}

static void test_a_pair_is_of_two_different_points(void)
{
    rigcal_pair pair;

    ASSERT_REFUSED(RIGCAL_ERR_RANGE, pair, rigcal_pair_make(&pair, ok.bearings, N, 2, 2));
}

static void test_the_far_end_of_a_line_lies_beyond_the_near_one(void)
{
    rigcal_real ends[4], uv[16];
    size_t n;

    ASSERT_REFUSED(RIGCAL_ERR_RANGE, ends,
                   rigcal_epiline_segment(ends, &ok.camera, &ok.b_from_a, ok.ray_a,
                                          REAL_FAR, REAL_NEAR));
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, ends,
                   rigcal_epiline_segment(ends, &ok.camera, &ok.b_from_a, ok.ray_a,
                                          REAL_NEAR, REAL_NEAR));
    FILL(n);
    ASSERT_REFUSED(RIGCAL_ERR_RANGE, uv,
                   rigcal_epiline_curve(uv, 8, &n, &ok.camera, &ok.b_from_a, ok.ray_a,
                                        REAL_FAR, REAL_NEAR));
    ASSERT_UNTOUCHED(n);
}

static void test_a_camera_of_a_list_of_names_has_one(void)
{
    static const char *const names[N_CAMERAS] = {"left", "middle", NULL};
    const rigcal_faults_words words = {.names = names};
    char text[TEXT_SIZE];

    ASSERT_REFUSED(
        RIGCAL_ERR_NULL, text,
        rigcal_faults_text(text, sizeof text, NULL, &ok.told, ok.told_faults, &words));
}

static void test_the_size_of_a_text_can_be_asked_for(void)
{
    const rigcal_faults_words words = {0};
    size_t n_needed = 0;
    char text[TEXT_SIZE];

    ASSERT_REFUSED(
        RIGCAL_ERR_CAPACITY, text,
        rigcal_faults_text(text, 0, &n_needed, &ok.told, ok.told_faults, &words));
    TEST_ASSERT_TRUE(n_needed > 100);
    ASSERT_STATUS(RIGCAL_OK, rigcal_faults_text(text, n_needed, NULL, &ok.told,
                                                ok.told_faults, &words));
    TEST_ASSERT_EQUAL_UINT64(n_needed, strlen(text) + 1);
}

/* At least one kind fits at a time; then another one needs more. */
static void test_faults_that_have_no_room_are_refused_before_the_first(void)
{
    static rigcal_real work[RIG_WORK], room[FAULTS_WORK];
    rigcal_fault faults[N_FAULTS];
    rigcal_faults_options options = {.work = room};
    rigcal_faults found;
    rigcal_rig rig = ok.rig;
    rigcal_status status = RIGCAL_ERR_CAPACITY;

    memcpy(work, ok.rig_work, sizeof work);
    rig.work = work;
    rig.views = ok.rig_views;
    for (size_t n = 0; status == RIGCAL_ERR_CAPACITY && n <= FAULTS_WORK; n += 5) {
        options.work_capacity = n;
        FILL(faults);
        status = rigcal_rig_faults(&found, faults, N_FAULTS, NULL, &options, &rig);
        if (status != RIGCAL_OK) {
            ASSERT_UNTOUCHED(faults);
        }
    }
    ASSERT_STATUS(RIGCAL_OK, status);
}

static void test_weights_that_are_all_zero_make_no_mean(void)
{
    static const rigcal_real none[N_VIEWS] = {0};
    rigcal_transform mean;

    ASSERT_REFUSED(RIGCAL_ERR_RANGE, mean,
                   rigcal_transform_mean(&mean, NULL, NULL, ok.estimates, none, N_VIEWS));
}

static void test_pairs_for_any_number_of_points_does_not_wrap_round(void)
{
    TEST_ASSERT_EQUAL_UINT64(0, rigcal_pairs_for(0));
    TEST_ASSERT_EQUAL_UINT64(0, rigcal_pairs_for(1));
    for (size_t n = 2; n < 100; n++) {
        const size_t all = n * (n - 1) / 2;

        TEST_ASSERT_EQUAL_UINT64(all < 4 * n ? all : 4 * n, rigcal_pairs_for(n));
        TEST_ASSERT_EQUAL_UINT64(RIGCAL_PAIRS_FOR(n), rigcal_pairs_for(n));
    }
    TEST_ASSERT_EQUAL_UINT64((size_t)1 << 30, rigcal_pairs_for((size_t)1 << 28));
}

/* Makes the valid arguments before the first test, whichever that is. */
void setUp(void)
{
    static int is_built;

    if (!is_built) {
        build_valid();
        is_built = 1;
    }
}

void tearDown(void)
{
}

TEST_MAIN_WITH_SETUP()
{
    RUN_TEST(test_every_public_function_of_the_headers_is_in_the_table);
    for (int i = 0; i < N_FUNCTIONS; i++) {
        char name[80];

        current = &FUNCTIONS[i];
        snprintf(name, sizeof name, "%s_withstands_hostile_arguments", current->name);
        test_run(withstands_hostile_arguments, name, __LINE__);
    }
    RUN_TEST(test_a_solver_still_running_has_no_result);
    RUN_TEST(test_three_points_have_no_noise_to_estimate);
    RUN_TEST(test_a_search_has_no_result_before_the_first_cost);
    RUN_TEST(test_only_none_or_two_pairs_eliminate);
    RUN_TEST(test_a_pair_is_of_two_different_points);
    RUN_TEST(test_the_far_end_of_a_line_lies_beyond_the_near_one);
    RUN_TEST(test_a_camera_of_a_list_of_names_has_one);
    RUN_TEST(test_the_size_of_a_text_can_be_asked_for);
    RUN_TEST(test_faults_that_have_no_room_are_refused_before_the_first);
    RUN_TEST(test_weights_that_are_all_zero_make_no_mean);
    RUN_TEST(test_pairs_for_any_number_of_points_does_not_wrap_round);
}
